//! The demo: where it is, its keys, scrubbing.

use egui::{Align2, Color32, Sense, Stroke, Ui, pos2, vec2};

use crate::action::Action;
use crate::docks::caption;
use crate::view::Timeline;

/// Points of a track's row, and of the column with the names.
const ROW: f32 = 16.0;
const NAMES: f32 = 110.0;

/// Draws the panel.
pub(crate) fn show(ui: &mut Ui, timeline: &Timeline, paused: bool, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        if ui.button(if paused { "Play demo" } else { "Pause demo" }).clicked() {
            actions.push(Action::Pause);
        }
        let mut looped = timeline.looped;
        if ui.checkbox(&mut looped, "loop").changed() {
            actions.push(Action::Loop(looped));
        }
        let mut time = timeline.time;
        let label = ui.label("seconds");
        let drag = egui::DragValue::new(&mut time)
            .range(0.0..=timeline.duration)
            .clamp_existing_to_range(false)
            .speed(0.02)
            .fixed_decimals(2);
        if ui.add(drag).labelled_by(label.id).changed() {
            actions.push(Action::Seek(time));
        }
        ui.weak(format!("of {:.2}, {}", timeline.duration, timeline.name));
        if !timeline.drives {
            ui.label("your hand is on it");
            if ui.button("Give back").on_hover_text("The demo drives again").clicked() {
                actions.push(Action::HandBack);
            }
        }
    });
    strip(ui, timeline, actions);
}

/// A row for each track with its keys; a click or a drag puts the demo there.
fn strip(ui: &mut Ui, timeline: &Timeline, actions: &mut Vec<Action>) {
    let rows = timeline.tracks.len().max(1) as f32;
    let size = vec2(ui.available_width().max(NAMES + 80.0), rows * ROW + 4.0);
    let (response, painter) = ui.allocate_painter(size, Sense::click_and_drag());
    let area = response.rect;
    let (left, right) = (area.left() + NAMES, area.right() - 8.0);
    let duration = timeline.duration.max(1e-6);
    let x = |seconds: f64| left + (seconds / duration).clamp(0.0, 1.0) as f32 * (right - left);
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(120));
    for (row, (name, keys)) in timeline.tracks.iter().enumerate() {
        let y = area.top() + 2.0 + (row as f32 + 0.5) * ROW;
        caption(ui, pos2(area.left() + 4.0, y), Align2::LEFT_CENTER, name);
        painter.hline(left..=right, y, Stroke::new(1.0, Color32::from_gray(60)));
        for key in keys {
            painter.circle_filled(pos2(x(*key), y), 3.5, Color32::from_rgb(235, 200, 90));
        }
    }
    painter.vline(x(timeline.time), area.y_range(), Stroke::new(1.5, Color32::WHITE));
    if (response.dragged() || response.clicked())
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let share = f64::from((pointer.x - left) / (right - left).max(1.0)).clamp(0.0, 1.0);
        actions.push(Action::Seek(share * timeline.duration));
    }
}
