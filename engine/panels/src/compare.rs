//! Keeps a picture, and compares the shown target with it.

use egui::{
    Align2, Button, Color32, Context, DragValue, FontId, Grid, LayerId, Rect, RichText, Stroke, TextEdit, Ui, pos2,
};
use raxel_diagnostics::names::grouped;

use crate::action::Action;
use crate::bar::RED;
use crate::view::{Compare, CompareMode, Figures};

/// Draws the panel. `path` is the text of the field for a file.
pub(crate) fn show(ui: &mut Ui, compare: &Compare, path: &mut String, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        if ui.button("Keep").on_hover_text("Keeps what is shown, to compare with it; B").clicked() {
            actions.push(Action::Keep);
        }
        let hint = "Compares with what is shown now, as it goes on: show another target then; Shift+B";
        if ui.button("Keep live").on_hover_text(hint).clicked() {
            actions.push(Action::KeepLive);
        }
        let label = ui.label("or a file");
        ui.add(TextEdit::singleline(path).desired_width(130.0).hint_text(RichText::new("picture.png").weak()))
            .labelled_by(label.id);
        let hint = "A PNG, JPEG, EXR or HDR, from the folder of the project";
        if ui.add_enabled(!path.trim().is_empty(), Button::new("Load")).on_hover_text(hint).clicked() {
            actions.push(Action::KeepFile(path.trim().to_owned()));
        }
    });
    let Some(kept) = &compare.kept else {
        ui.weak("Nothing is kept yet.");
        return;
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(kept).strong());
        if ui.small_button("×").on_hover_text("Drops the kept picture").clicked() {
            actions.push(Action::ForgetKept);
        }
    });
    if let Some(refused) = &compare.refused {
        ui.label(RichText::new(refused).color(RED));
    }
    ui.horizontal_wrapped(|ui| {
        for mode in CompareMode::ALL {
            if ui.selectable_label(compare.mode == mode, mode.word()).on_hover_text("X takes the next one").clicked() {
                actions.push(Action::CompareMode(mode));
            }
        }
        let flip =
            ui.selectable_label(compare.flipped, "kept picture").on_hover_text("Shows the kept picture alone; V");
        if flip.clicked() {
            actions.push(Action::Flip);
        }
    });
    if compare.mode == CompareMode::Difference {
        ui.horizontal(|ui| {
            let mut gain = compare.gain;
            let label = ui.label("amplified");
            let speed = f64::from(gain) * 0.02;
            let drag = DragValue::new(&mut gain).range(0.01..=100_000.0).speed(speed).suffix(" ×");
            if ui.add(drag).labelled_by(label.id).changed() {
                actions.push(Action::Gain(gain));
            }
        });
        ui.weak("Shown minus kept, in units of the range. Numbers: orange is more, blue is less. Colours: by channel around a grey.");
    }
    ui.separator();
    figures(ui, compare, actions);
}

fn figures(ui: &mut Ui, compare: &Compare, actions: &mut Vec<Action>) {
    // A live target is there while it is shown.
    let is_there = !compare.live || compare.flipped || compare.mode != CompareMode::Off;
    let ready = compare.refused.is_none() && is_there && compare.figures != Figures::Awaited;
    if ui.add_enabled(ready, Button::new("Measure")).on_hover_text("As `raxel compare` does").clicked() {
        actions.push(Action::Measure);
    }
    match &compare.figures {
        Figures::None => {}
        Figures::Awaited => {
            ui.weak("comparing");
        }
        Figures::Refused(why) => {
            ui.label(RichText::new(why).color(RED));
        }
        Figures::Found { of, flip, rmse, max, differing: [differing, all] } => {
            ui.weak(of);
            Grid::new("figures").num_columns(2).show(ui, |ui| {
                for (name, value) in [("FLIP", flip), ("RMSE", rmse), ("largest", max)] {
                    ui.weak(name);
                    ui.monospace(format!("{value:.6}"));
                    ui.end_row();
                }
                ui.weak("differ");
                ui.monospace(format!("{} of {}", grouped(*differing), grouped(*all)));
                ui.end_row();
            });
        }
    }
}

/// Draws the edge of a wipe over the picture, which is in this area, below all panels.
#[expect(clippy::cast_possible_truncation, reason = "points of a window are small numbers")]
pub(crate) fn edge(ctx: &Context, area: Rect, compare: &Compare) {
    if !compare.has_edge() {
        return;
    }
    let x = area.left() + (f64::from(area.width()) * compare.edge) as f32;
    let painter = ctx.layer_painter(LayerId::background());
    for (width, color) in [(3.0, Color32::from_black_alpha(160)), (1.0, Color32::WHITE)] {
        painter.vline(x, area.y_range(), Stroke::new(width, color));
    }
    let y = area.center().y;
    painter.circle(pos2(x, y), 7.0, Color32::from_black_alpha(180), Stroke::new(1.5, Color32::WHITE));
    let other = if compare.live { "live" } else { "kept" };
    for (offset, anchor, text) in [(-12.0, Align2::RIGHT_CENTER, "shown"), (12.0, Align2::LEFT_CENTER, other)] {
        let at = pos2(x + offset, y);
        for (shift, color) in [(1.0, Color32::BLACK), (0.0, Color32::WHITE)] {
            painter.text(at + egui::Vec2::splat(shift), anchor, text, FontId::proportional(12.0), color);
        }
    }
}
