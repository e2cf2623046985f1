//! The bar: the clock, the shown target, and its problems.

use std::fmt::Write as _;

use egui::{Align2, Area, Color32, Context, Frame, Id, Order, RichText, TextStyle, Ui};

use crate::action::Action;
use crate::frame::milliseconds;
use crate::samples::Samples;
use crate::view::{Busy, Compiling, FirstPicture, PassState, Problem, Shown, Status, View};

pub(crate) const RED: Color32 = Color32::from_rgb(240, 110, 100);
pub(crate) const YELLOW: Color32 = Color32::from_rgb(235, 200, 90);

/// Points between the bar and a notice below it.
const MARGIN: f32 = 6.0;

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

/// The shown target, and whether it is as in the files. Gives the notice if there is no room for it.
pub(crate) fn status<'v>(ui: &mut Ui, view: &'v View<'_>, actions: &mut Vec<Action>) -> Option<&'v str> {
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
    if let Some(seconds) = status.recording {
        let text = RichText::new(format!("recording {seconds} s")).color(RED);
        ui.label(text).on_hover_text("A take is recorded; F9 ends it, and writes it as a demo");
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
    if !status.written.is_empty() {
        let hint = format!("Restores {} as before the window wrote it", status.written.join(", "));
        if ui.button("Undo write").on_hover_text(hint).clicked() {
            actions.push(Action::UndoWrite);
        }
    }
    let notice = status.notice.as_deref()?;
    let font = TextStyle::Body.resolve(ui.style());
    let width = ui.painter().layout_no_wrap(notice.to_owned(), font, Color32::WHITE).rect.width();
    // The bar scrolls, so it has room without end; its window has not.
    if ui.cursor().left() + width > ui.clip_rect().right() {
        return Some(notice);
    }
    ui.label(RichText::new(notice).weak());
    None
}

/// Draws a notice that has no room in the bar below it, over picture and panels.
pub(crate) fn notice(ctx: &Context, bar: f32, notice: &str) {
    let area = Area::new(Id::new("notice")).order(Order::Foreground).interactable(false);
    area.anchor(Align2::CENTER_TOP, [0.0, bar + MARGIN]).show(ctx, |ui| {
        ui.set_max_width(ctx.content_rect().width() * 0.8);
        Frame::popup(ui.style()).show(ui, |ui| ui.label(notice));
    });
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
