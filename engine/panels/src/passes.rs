//! The passes in their order, with their times, and what became of them.

use egui::{Grid, RichText, Sense, Ui};

use crate::action::Action;
use crate::bar::text_of;
use crate::frame::milliseconds;
use crate::samples::Samples;
use crate::view::{Pass, PassState, Shown, View};

/// Draws the panel. The pass under the pointer is given, as what it shows.
pub(crate) fn show(ui: &mut Ui, view: &View<'_>, (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>)) {
    ui.horizontal_wrapped(|ui| {
        let span = view.frame.gpu;
        let (median, p95) = (span.and_then(Samples::median), span.and_then(Samples::p95));
        ui.label(format!("span {} ms, p95 {}", milliseconds(median), milliseconds(p95)))
            .on_hover_text("From the start of the first pass to the end of the last, with gaps and overlaps.");
    });
    let longest = view.passes.iter().filter_map(median).fold(0.0_f32, f32::max);
    Grid::new("passes").num_columns(3).striped(true).min_col_width(30.0).show(ui, |ui| {
        ui.weak("pass");
        ui.weak("ms");
        ui.weak("p95");
        ui.end_row();
        for (index, pass) in view.passes.iter().enumerate() {
            row(ui, view, (index, pass), longest, (actions, hovered));
            ui.end_row();
        }
    });
    if view.passes.is_empty() {
        ui.weak("The graph has no passes.");
    }
}

fn row(
    ui: &mut Ui,
    view: &View<'_>,
    (index, pass): (usize, &Pass<'_>),
    longest: f32,
    (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>),
) {
    let target = target(view, index);
    let locked = target.as_ref().is_some_and(|target| view.status.locked.is_at(target));
    let name = match pass.state {
        PassState::Ran => RichText::new(pass.name),
        _ => RichText::new(pass.name).weak(),
    };
    let response = ui.selectable_label(locked, name);
    let response = response.on_hover_ui(|ui| about(ui, view, index));
    if let Some(target) = target {
        if response.hovered() && pass.state.is_planned() {
            *hovered = Some(target.clone());
        }
        if response.clicked() {
            actions.push(if locked { Action::ShowDefault } else { Action::Show(target) });
        }
    }
    if pass.state == PassState::Ran || (pass.state.is_planned() && median(pass).is_some()) {
        let value = median(pass);
        let text = ui.monospace(milliseconds(value));
        bar(ui, &text, value.unwrap_or(0.0) / longest.max(1e-9));
        ui.monospace(milliseconds(pass.times.and_then(Samples::p95)));
    } else {
        ui.weak(pass.state.word()).on_hover_text(pass.state.reason());
        ui.label("");
    }
    if pass.state != PassState::Ran && pass.state.is_planned() && median(pass).is_some() {
        ui.weak(pass.state.word()).on_hover_text(pass.state.reason());
    }
}

/// The target of a pass: the part that it writes of the resource that it is best known by.
pub(crate) fn target(view: &View<'_>, index: usize) -> Option<Shown> {
    let pass = &view.passes[index];
    let resource = pass.output.and_then(|index| view.resources.get(index))?;
    // A skipped pass has no place in the frame after which something could be shown.
    let after = pass.state.is_planned().then(|| pass.after.to_owned());
    // A pass of a loop writes another mip in each round.
    let used = resource.uses.get(index).copied().unwrap_or_default();
    Some(Shown::after(resource.name.clone(), after).part(used))
}

/// The tooltip of a pass.
pub(crate) fn about(ui: &mut Ui, view: &View<'_>, index: usize) {
    let pass = &view.passes[index];
    ui.label(RichText::new(pass.name).strong());
    ui.label(pass.state.reason());
    if !pass.groups.is_empty() {
        ui.label(format!("workgroups {}", pass.groups));
    }
    if let Some(output) = pass.output.and_then(|index| view.resources.get(index)) {
        let shown = target(view, index).as_ref().map(text_of).unwrap_or_default();
        ui.label(format!("shows {shown} ({}); a click locks it", output.about));
    }
    ui.weak(pass.place);
}

fn median(pass: &Pass<'_>) -> Option<f32> {
    pass.times.and_then(Samples::median)
}

/// A line under a number, as long as its share of the longest.
fn bar(ui: &Ui, text: &egui::Response, share: f32) {
    let rect = text.interact(Sense::hover()).rect;
    let line = egui::Rect::from_min_size(
        egui::pos2(rect.left(), rect.bottom() - 1.0),
        egui::vec2(rect.width() * share.clamp(0.0, 1.0), 2.0),
    );
    ui.painter().rect_filled(line, 0.0, egui::Color32::from_rgb(120, 200, 120));
}
