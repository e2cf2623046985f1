//! Which pass touches which resource: passes are rows, resources are columns. A click on a cell shows the resource right after that pass; with
//! the right button, right before it.

use std::ops::Range;

use egui::{Align2, Color32, FontId, Rect, Sense, Stroke, Ui, Vec2, pos2, vec2};

use crate::action::Action;
use crate::frame::bytes;
use crate::hint::Hint as _;
use crate::rows::Rows;
use crate::view::{Pass, PassState, Resource, Shown, Use, View};

const CELL: f32 = 18.0;
/// The angle of the titles of the columns to the rows, in radians.
const LEANING: f32 = 1.1;
const READS: Color32 = Color32::from_rgb(90, 150, 240);
const WRITES: Color32 = Color32::from_rgb(240, 140, 80);
const BOTH: Color32 = Color32::from_rgb(190, 120, 230);
const ALIVE: Color32 = Color32::from_gray(55);

/// Draws the panel. `whole`: each cell in sight is a widget, rather than only the one under the pointer.
pub(crate) fn show(ui: &mut Ui, view: &View<'_>, rows: &mut Rows<2>, whole: bool, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        for (color, word) in [(READS, "reads"), (WRITES, "writes"), (BOTH, "both"), (ALIVE, "alive")] {
            ui.colored_label(if color == ALIVE { Color32::GRAY } else { color }, word);
        }
        ui.weak("a click shows it after the pass, the right button before");
    });
    matrix(ui, view, whole, actions);
    ui.separator();
    egui::Grid::new("resources").num_columns(2).striped(true).show(ui, |ui| {
        for (index, resource) in view.resources.iter().enumerate() {
            let words = (&resource.name, &resource.about, &resource.memory, resource.bytes);
            rows.add(ui, index, words, |ui| row(ui, view, resource, actions));
            ui.end_row();
        }
    });
}

/// A resource in words. Gives the sizes of its cells.
fn row(ui: &mut Ui, view: &View<'_>, resource: &Resource, actions: &mut Vec<Action>) -> [Vec2; 2] {
    let locked = view.status.shown.is_at(&Shown::after(resource.name.clone(), None));
    let name = ui.selectable_label(locked, &resource.name).hint(|| &resource.place);
    if name.clicked() {
        actions.push(Action::Show(Shown::after(resource.name.clone(), None)));
    }
    let size = if resource.bytes == 0 { String::new() } else { format!("{}, ", bytes(resource.bytes)) };
    let about = ui.vertical(|ui| {
        ui.label(&resource.about);
        ui.weak(format!("{size}{}", resource.memory));
    });
    [name.rect.size(), about.response.rect.size()]
}

fn matrix(ui: &mut Ui, view: &View<'_>, whole: bool, actions: &mut Vec<Action>) {
    let font = egui::TextStyle::Small.resolve(ui.style());
    let names = widest(ui, view.passes.iter().map(|pass| pass.name), &font).min(160.0) + 8.0;
    let titles = widest(ui, view.resources.iter().map(|resource| resource.name.as_str()), &font).min(120.0) + 8.0;
    let columns = view.resources.len() as f32;
    // The titles lean over the columns beside them, and the last one over the edge.
    let leaning = titles * LEANING.cos();
    let size = vec2(names + columns * CELL + leaning, titles + view.passes.len() as f32 * CELL);
    let (response, painter) = ui.allocate_painter(size, Sense::hover());
    let cells = response.rect.min + vec2(names, titles);
    let seen = painter.clip_rect();
    for column in in_sight((seen.left() - leaning, seen.right()), cells.x, view.resources.len()) {
        let at = pos2(cells.x + (column as f32 + 0.75) * CELL, cells.y - 4.0);
        let name = view.resources[column].name.clone();
        let galley = painter.layout_no_wrap(name, font.clone(), ui.visuals().text_color());
        let mut text = egui::epaint::TextShape::new(at - vec2(galley.size().y * 0.8, 0.0), galley, Color32::WHITE);
        text.angle = -LEANING;
        painter.add(text);
    }
    let pointer = ui.input(|input| input.pointer.latest_pos());
    for row in in_sight((seen.top(), seen.bottom()), cells.y, view.passes.len()) {
        let (pass, y) = (&view.passes[row], cells.y + row as f32 * CELL);
        let left = response.rect.left();
        let color = if pass.state.is_planned() { ui.visuals().text_color() } else { ui.visuals().weak_text_color() };
        painter.with_clip_rect(Rect::from_min_size(pos2(left, y), vec2(names, CELL)).intersect(ui.clip_rect())).text(
            pos2(left, y + CELL / 2.0),
            Align2::LEFT_CENTER,
            pass.name,
            font.clone(),
            color,
        );
        for column in in_sight((seen.left(), seen.right()), cells.x, view.resources.len()) {
            let corner = pos2(cells.x + column as f32 * CELL, y);
            let rect = Rect::from_min_size(corner, vec2(CELL, CELL)).shrink(1.0);
            let at = (row, &view.resources[column]);
            paint(ui, view, at, rect);
            if whole || pointer.is_some_and(|pointer| rect.contains(pointer)) {
                cell(ui, view, at, rect, actions);
            }
        }
    }
}

/// The indices of the rows or columns in sight between two ends. `count` of them begin at `begin`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast of a float saturates")]
fn in_sight((from, to): (f32, f32), begin: f32, count: usize) -> Range<usize> {
    let index = |at: f32| (((at - begin) / CELL).floor().max(0.0) as usize).min(count);
    index(from)..(index(to) + 1).min(count)
}

/// How a pass touches a resource.
fn use_of((row, resource): (usize, &Resource)) -> Use {
    resource.uses.get(row).copied().unwrap_or_default()
}

fn after(view: &View<'_>, (row, resource): (usize, &Resource)) -> Shown {
    let pass = view.passes[row].after.to_owned();
    Shown::after(resource.name.clone(), Some(pass)).part(use_of((row, resource)))
}

fn paint(ui: &Ui, view: &View<'_>, (row, resource): (usize, &Resource), rect: Rect) {
    let (pass, used) = (&view.passes[row], use_of((row, resource)));
    let color = match (used.reads, used.writes) {
        (true, true) => BOTH,
        (false, true) => WRITES,
        (true, false) => READS,
        (false, false) if is_alive(&resource.uses, row) => ALIVE,
        (false, false) => Color32::from_gray(32),
    };
    let color = if pass.state.is_planned() { color } else { color.gamma_multiply(0.35) };
    ui.painter().rect_filled(rect, 2.0, color);
    let shown = &view.status.shown;
    if shown.resource == resource.name && shown.is_at(&after(view, (row, resource))) {
        ui.painter().rect_stroke(rect, 2.0, Stroke::new(2.0, Color32::WHITE), egui::StrokeKind::Inside);
    }
}

fn cell(ui: &mut Ui, view: &View<'_>, (row, resource): (usize, &Resource), rect: Rect, actions: &mut Vec<Action>) {
    let (pass, used) = (&view.passes[row], use_of((row, resource)));
    let after = after(view, (row, resource));
    let name = format!("{} after {}", resource.name, pass.name);
    let response = ui.interact(rect, ui.id().with(("cell", row, &resource.name)), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &name));
    if response.hovered() && !view.status.shown.is_at(&after) {
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
