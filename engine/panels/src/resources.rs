//! Which pass touches which resource: passes are rows, resources are columns. A click on a cell shows the resource right after that pass; with
//! the right button, right before it.

use egui::{Align2, Color32, FontId, Rect, Sense, Stroke, Ui, pos2, vec2};

use crate::action::Action;
use crate::frame::bytes;
use crate::view::{Pass, PassState, Resource, Shown, Use, View};

const CELL: f32 = 18.0;
/// The angle of the titles of the columns to the rows, in radians.
const LEANING: f32 = 1.1;
const READS: Color32 = Color32::from_rgb(90, 150, 240);
const WRITES: Color32 = Color32::from_rgb(240, 140, 80);
const BOTH: Color32 = Color32::from_rgb(190, 120, 230);
const ALIVE: Color32 = Color32::from_gray(55);

/// Draws the panel.
pub(crate) fn show(ui: &mut Ui, view: &View<'_>, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        for (color, word) in [(READS, "reads"), (WRITES, "writes"), (BOTH, "both"), (ALIVE, "alive")] {
            ui.colored_label(if color == ALIVE { Color32::GRAY } else { color }, word);
        }
        ui.weak("a click shows it after the pass, the right button before");
    });
    matrix(ui, view, actions);
    ui.separator();
    egui::Grid::new("resources").num_columns(2).striped(true).show(ui, |ui| {
        for resource in view.resources {
            let locked = view.status.shown.is_at(&Shown::after(resource.name.clone(), None));
            let name = ui.selectable_label(locked, &resource.name).on_hover_text(&resource.place);
            if name.clicked() {
                actions.push(Action::Show(Shown::after(resource.name.clone(), None)));
            }
            let size = if resource.bytes == 0 { String::new() } else { format!("{}, ", bytes(resource.bytes)) };
            ui.vertical(|ui| {
                ui.label(&resource.about);
                ui.weak(format!("{size}{}", resource.memory));
            });
            ui.end_row();
        }
    });
}

fn matrix(ui: &mut Ui, view: &View<'_>, actions: &mut Vec<Action>) {
    let font = egui::TextStyle::Small.resolve(ui.style());
    let names = widest(ui, view.passes.iter().map(|pass| pass.name), &font).min(160.0) + 8.0;
    let titles = widest(ui, view.resources.iter().map(|resource| resource.name.as_str()), &font).min(120.0) + 8.0;
    let columns = view.resources.len() as f32;
    // The titles lean over the columns beside them, and the last one over the edge.
    let size = vec2(names + columns * CELL + titles * LEANING.cos(), titles + view.passes.len() as f32 * CELL);
    let (response, painter) = ui.allocate_painter(size, Sense::hover());
    let origin = response.rect.min;
    for (column, resource) in view.resources.iter().enumerate() {
        let at = pos2(origin.x + names + (column as f32 + 0.75) * CELL, origin.y + titles - 4.0);
        let galley = painter.layout_no_wrap(resource.name.clone(), font.clone(), ui.visuals().text_color());
        let mut text = egui::epaint::TextShape::new(at - vec2(galley.size().y * 0.8, 0.0), galley, Color32::WHITE);
        text.angle = -LEANING;
        painter.add(text);
    }
    for (row, pass) in view.passes.iter().enumerate() {
        let y = origin.y + titles + row as f32 * CELL;
        let color = if pass.state.is_planned() { ui.visuals().text_color() } else { ui.visuals().weak_text_color() };
        painter
            .with_clip_rect(Rect::from_min_size(pos2(origin.x, y), vec2(names, CELL)).intersect(ui.clip_rect()))
            .text(pos2(origin.x, y + CELL / 2.0), Align2::LEFT_CENTER, pass.name, font.clone(), color);
        for (column, resource) in view.resources.iter().enumerate() {
            let rect =
                Rect::from_min_size(pos2(origin.x + names + column as f32 * CELL, y), vec2(CELL, CELL)).shrink(1.0);
            cell(ui, view, (row, resource), rect, actions);
        }
    }
}

fn cell(ui: &mut Ui, view: &View<'_>, (row, resource): (usize, &Resource), rect: Rect, actions: &mut Vec<Action>) {
    let pass = &view.passes[row];
    let used = resource.uses.get(row).copied().unwrap_or_default();
    let after = Shown::after(resource.name.clone(), Some(pass.after.to_owned())).part(used);
    let name = format!("{} after {}", resource.name, pass.name);
    let response = ui.interact(rect, ui.id().with(("cell", row, &resource.name)), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &name));
    let color = match (used.reads, used.writes) {
        (true, true) => BOTH,
        (false, true) => WRITES,
        (true, false) => READS,
        (false, false) if is_alive(&resource.uses, row) => ALIVE,
        (false, false) => Color32::from_gray(32),
    };
    let color = if pass.state.is_planned() { color } else { color.gamma_multiply(0.35) };
    ui.painter().rect_filled(rect, 2.0, color);
    if view.status.shown.is_at(&after) {
        ui.painter().rect_stroke(rect, 2.0, Stroke::new(2.0, Color32::WHITE), egui::StrokeKind::Inside);
    } else if response.hovered() {
        ui.painter().rect_stroke(rect, 2.0, Stroke::new(1.0, Color32::WHITE), egui::StrokeKind::Inside);
    }
    // A pass that is unused now runs on request; a pass whose `when` does not hold never runs.
    let runs = |pass: &Pass<'_>| pass.state != PassState::Condition;
    if resource.opaque || !runs(pass) {
        return;
    }
    // Before a pass is after the one that runs before it.
    let before = view.passes[..row].iter().rev().find(|pass| runs(pass));
    if response.clicked() {
        actions.push(Action::Show(after));
    } else if response.secondary_clicked()
        && let Some(before) = before
    {
        // The same part as after it, to be compared.
        let before = Shown::after(resource.name.clone(), Some(before.after.to_owned()));
        actions.push(Action::Show(before.part(used)));
    }
    response.on_hover_ui(|ui| {
        ui.label(name);
        ui.label(match (used.reads, used.writes) {
            (true, true) => "reads and writes it",
            (false, true) => "writes it",
            (true, false) => "reads it",
            (false, false) => "does not touch it",
        });
        ui.weak(format!("{}, {}", resource.about, resource.memory));
    });
}

/// Whether a row lies between the first and the last use.
fn is_alive(uses: &[Use], row: usize) -> bool {
    let touched = |used: &Use| used.reads || used.writes;
    uses.iter().take(row).any(touched) && uses.iter().skip(row + 1).any(touched)
}

fn widest<'n>(ui: &Ui, names: impl Iterator<Item = &'n str>, font: &FontId) -> f32 {
    let width =
        |name: &str| ui.fonts_mut(|fonts| fonts.layout_no_wrap(name.to_owned(), font.clone(), Color32::WHITE).size().x);
    names.map(width).fold(40.0, f32::max)
}
