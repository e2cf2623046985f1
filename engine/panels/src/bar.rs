//! The bar: the clock, the shown target, and its problems.

use std::fmt::Write as _;

use egui::{Color32, RichText, Ui};

use crate::action::Action;
use crate::frame::milliseconds;
use crate::samples::Samples;
use crate::view::{Busy, Compiling, FirstPicture, PassState, Problem, Shown, Status, View};

pub(crate) const RED: Color32 = Color32::from_rgb(240, 110, 100);
pub(crate) const YELLOW: Color32 = Color32::from_rgb(235, 200, 90);

/// The colour of the worst of them.
pub(crate) fn color_of(problems: &[Problem]) -> Color32 {
    if problems.iter().any(|problem| problem.error) { RED } else { YELLOW }
}

/// Pause, step, reset.
pub(crate) fn clock(ui: &mut Ui, status: &Status, actions: &mut Vec<Action>) {
    let pause = if status.paused { "Play" } else { "Pause" };
    if ui.button(pause).on_hover_text("Space").clicked() {
        actions.push(Action::Pause);
    }
    if ui.button("Step").on_hover_text("Runs one frame; the full stop key").clicked() {
        actions.push(Action::Step);
    }
    if ui.button("Reset").on_hover_text("Starts clocks, histories and contents over; R").clicked() {
        actions.push(Action::Reset);
    }
}

/// The shown target, and whether it is as in the files.
pub(crate) fn status(ui: &mut Ui, view: &View<'_>, actions: &mut Vec<Action>) {
    let status = &view.status;
    ui.separator();
    ui.label(RichText::new(text_of(&status.shown)).strong());
    if !status.is_default && ui.button("×").on_hover_text("Show what the graph presents").clicked() {
        actions.push(Action::ShowDefault);
    }
    for (name, samples) in [("GPU", view.frame.gpu), ("CPU", view.frame.cpu)] {
        if let Some(median) = samples.and_then(Samples::median) {
            ui.label(format!("{name} {} ms", milliseconds(Some(median))));
        }
    }
    if let Some(failed) = status.failed {
        let text = format!("showing generation {}, {failed} failed", status.generation);
        ui.label(RichText::new(text).color(RED));
    }
    let off: Vec<&str> = view.passes.iter().filter(|pass| pass.state == PassState::Off).map(|pass| pass.name).collect();
    if !off.is_empty() {
        let whose = if off.len() == 1 { "its shader or graph changes" } else { "their shaders or graph change" };
        let text = format!("{} off until {whose}", listed(&off));
        ui.label(RichText::new(text).color(RED)).on_hover_text(PassState::Off.reason());
    }
    if status.picture == FirstPicture::Awaited {
        ui.label(RichText::new("making the first picture").weak());
    }
    if status.refused {
        ui.label(RichText::new("refused: showing the last plan").color(YELLOW));
    }
    if let Some(Busy { pass, seconds }) = &status.busy {
        let on = pass.as_ref().map_or_else(String::new, |pass| format!(" on `{pass}`"));
        ui.label(RichText::new(format!("the device has worked{on} for {seconds} s")).color(YELLOW));
        if ui
            .button("Cancel")
            .on_hover_text("Switch the pass off until its shader or its part of the graph changes; Delete")
            .clicked()
        {
            actions.push(Action::Cancel);
        }
    }
    if let Some(Compiling { pass, seconds, left }) = &status.compiling {
        let text = format!("the driver has compiled `{pass}` for {seconds} s; pipelines left: {left}");
        ui.label(RichText::new(text).color(YELLOW));
    }
    if let Some(notice) = &status.notice {
        ui.label(RichText::new(notice).weak());
    }
    if !status.written.is_empty() {
        let hint = format!("Restores {} as before the window wrote it", status.written.join(", "));
        if ui.button("Undo write").on_hover_text(hint).clicked() {
            actions.push(Action::UndoWrite);
        }
    }
}

/// "`a` is", "`a` and 2 more are".
fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [name] => format!("`{name}` is"),
        [name, more @ ..] => format!("`{name}` and {} more are", more.len()),
    }
}

/// `color after sky, mip 1`.
pub(crate) fn text_of(shown: &Shown) -> String {
    let mut text = shown.resource.clone();
    if shown.age > 0 {
        let _ = write!(text, "@{}", shown.age);
    }
    if let Some(pass) = &shown.after {
        let _ = write!(text, " after {pass}");
    }
    if shown.mip > 0 {
        let _ = write!(text, ", mip {}", shown.mip);
    }
    if shown.layer > 0 {
        let _ = write!(text, ", layer {}", shown.layer);
    }
    text
}
