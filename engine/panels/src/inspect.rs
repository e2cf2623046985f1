//! What the shown resource holds: mip, layer, channel, range, distribution, the texel under the cursor, the rows of a buffer.

use egui::{Align2, Color32, ComboBox, DragValue, Grid, Rect, RichText, Sense, Ui, Vec2, pos2, vec2};

use crate::action::Action;
use crate::bar::{RED, text_of};
use crate::docks::caption;
use crate::statistics::{BINS, Statistics};
use crate::view::{Inspected, Map, Shown, Table, View};

/// Points between columns of numbers, and between their rows.
const COLUMNS: Vec2 = Vec2::new(12.0, 3.0);

/// Draws the panel.
pub(crate) fn show(ui: &mut Ui, view: &View<'_>, actions: &mut Vec<Action>) {
    ui.label(RichText::new(text_of(&view.status.shown)).strong());
    let Some(found) = view.inspected else {
        ui.weak("It is being read.");
        return;
    };
    ui.weak(&found.about);
    part(ui, found, actions);
    if !found.channels.is_empty() {
        mapping(ui, found, actions);
    }
    if let Some(statistics) = &found.statistics {
        numbers(ui, found, statistics);
        histogram(ui, statistics);
    }
    texel(ui, found);
    if let Some(table) = &found.table {
        rows(ui, table, actions);
    }
}

/// Mip and layer.
fn part(ui: &mut Ui, found: &Inspected, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let mut shown = found.shown.clone();
        for (name, value, count) in [("mip", &mut shown.mip, found.mips), ("layer", &mut shown.layer, found.layers)] {
            if count > 1 {
                let label = ui.label(name);
                ui.add(DragValue::new(value).range(0..=count - 1).speed(0.1)).labelled_by(label.id);
                ui.weak(format!("of {count}"));
            }
        }
        if shown != found.shown {
            actions.push(Action::Show(Shown { ..shown }));
        }
    });
}

/// How texels become colours.
#[expect(clippy::cast_possible_truncation, reason = "there are four channels")]
fn mapping(ui: &mut Ui, found: &Inspected, actions: &mut Vec<Action>) {
    let Some(used) = found.used else { return };
    let mut own = found.map.is_some();
    let mut map = found.map.unwrap_or(used);
    let before = (own, map);
    ui.horizontal_wrapped(|ui| {
        if ui.checkbox(&mut own, "own map").on_hover_text("Else `display` of the graph's file").changed() && own {
            map.range = None;
        }
        ui.add_enabled_ui(own, |ui| {
            ComboBox::from_id_salt("map").width(80.0).selected_text(Map::NAMES[map.map]).show_ui(ui, |ui| {
                for (index, name) in Map::NAMES.iter().enumerate() {
                    ui.selectable_value(&mut map.map, index, *name);
                }
            });
            for (index, name) in found.channels.iter().enumerate() {
                ui.selectable_value(&mut map.channel, index as u32, *name);
            }
        });
    });
    ui.add_enabled_ui(own, |ui| {
        ui.horizontal(|ui| {
            let mut automatic = map.range.is_none();
            let mut range = map.range.or(used.range).unwrap_or([0.0, 1.0]);
            let speed = f64::from((range[1] - range[0]).abs().max(1e-3)) / 200.0;
            let label = ui.label("range");
            let low = ui.add(DragValue::new(&mut range[0]).speed(speed)).labelled_by(label.id).changed();
            let high = ui.add(DragValue::new(&mut range[1]).speed(speed)).changed();
            let chosen = ui.checkbox(&mut automatic, "automatic").on_hover_text("From the 1st to the 99th percentile");
            if low || high {
                map.range = Some(range);
            } else if chosen.changed() {
                map.range = (!automatic).then_some(range);
            }
        });
    });
    if (own, map) != before {
        actions.push(Action::Display(own.then_some(map)));
    }
}

fn numbers(ui: &mut Ui, inspected: &Inspected, found: &Statistics) {
    Grid::new("statistics").num_columns(2).show(ui, |ui| {
        let [low, high] = found.range;
        ui.weak("values");
        ui.monospace(format!("{low} to {high}"));
        ui.end_row();
        ui.weak("mean");
        ui.monospace(format!("{:.6}", found.mean));
        ui.end_row();
        ui.weak("NaN, infinite");
        let text =
            RichText::new(format!("{} NaN, {} infinite of {}", found.nan, found.infinite, found.count)).monospace();
        ui.label(if found.nan + found.infinite > 0 { text.color(RED) } else { text });
        ui.end_row();
        // Who looks for a NaN need not try the channels one by one.
        let chosen = inspected.map.or(inspected.used).map_or(0, |map| map.channel as usize);
        for (index, (name, [nan, infinite])) in inspected.channels.iter().zip(&inspected.not_finite).enumerate() {
            if index != chosen && nan + infinite > 0 {
                ui.weak(format!("in {name}"));
                ui.label(RichText::new(format!("{nan} NaN, {infinite} infinite")).monospace().color(RED));
                ui.end_row();
            }
        }
    });
}

fn histogram(ui: &mut Ui, found: &Statistics) {
    let size = vec2(ui.available_width().clamp(100.0, 400.0), 64.0);
    let (response, painter) = ui.allocate_painter(size, Sense::hover());
    let area = response.rect;
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(120));
    let most = found.histogram.iter().copied().max().unwrap_or(0).max(1) as f32;
    let width = area.width() / BINS as f32;
    for (index, count) in found.histogram.iter().enumerate() {
        // A few are seen beside many.
        let height = (*count as f32 / most).sqrt() * (area.height() - 12.0);
        let left = area.left() + index as f32 * width;
        let bar = Rect::from_min_max(pos2(left, area.bottom() - height), pos2(left + width - 0.5, area.bottom()));
        painter.rect_filled(bar, 0.0, Color32::from_rgb(120, 170, 250));
    }
    let [low, high] = found.percentiles;
    caption(ui, area.left_top() + vec2(3.0, 1.0), Align2::LEFT_TOP, &format!("{low}"));
    caption(ui, area.right_top() + vec2(-3.0, 1.0), Align2::RIGHT_TOP, &format!("{high}"));
}

fn texel(ui: &mut Ui, found: &Inspected) {
    let Some(([x, y], values)) = &found.cursor else {
        if found.table.is_none() {
            ui.weak("The texel under the cursor is shown here.");
        }
        return;
    };
    ui.label(format!("texel {x}, {y}"));
    Grid::new("texel").num_columns(3).spacing(COLUMNS).show(ui, |ui| {
        for (name, [value, bits]) in found.channels.iter().zip(values) {
            ui.weak(*name);
            ui.monospace(value);
            ui.monospace(bits);
            ui.end_row();
        }
    });
}

fn rows(ui: &mut Ui, table: &Table, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let mut first = table.first;
        let label = ui.label("from element");
        if ui
            .add(DragValue::new(&mut first).clamp_existing_to_range(false).range(0..=table.total.saturating_sub(1)))
            .labelled_by(label.id)
            .changed()
        {
            actions.push(Action::Rows(first));
        }
        ui.weak(format!("of {}", table.total));
        if ui.button("CSV").on_hover_text("Writes the whole buffer to a file").clicked() {
            actions.push(Action::WriteTable);
        }
    });
    for [name, value] in &table.head {
        ui.horizontal(|ui| {
            ui.weak(name);
            ui.monospace(value);
        });
    }
    Grid::new("table").num_columns(table.columns.len() + 1).spacing(COLUMNS).striped(true).show(ui, |ui| {
        ui.weak("#");
        for column in &table.columns {
            ui.weak(column);
        }
        ui.end_row();
        for (index, row) in table.rows.iter().enumerate() {
            ui.weak((table.first + index as u64).to_string());
            for value in row {
                ui.monospace(value);
            }
            ui.end_row();
        }
    });
}
