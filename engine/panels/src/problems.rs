//! The problems, as the terminal prints them.

use egui::{Color32, RichText, Ui};

use crate::action::Action;
use crate::bar::{RED, YELLOW};
use crate::view::{Problem, View};

/// Problems that are drawn; the others are counted.
const SHOWN: usize = 50;

/// Draws the panel.
pub(crate) fn show(ui: &mut Ui, view: &View<'_>, actions: &mut Vec<Action>) {
    if let Some(failed) = view.status.failed {
        let text = format!("showing generation {}, {failed} failed", view.status.generation);
        ui.label(RichText::new(text).color(RED));
    }
    let mut checked = view.checks_bounds;
    let about =
        "Check each access of a shader to arrays and images, and list those out of bounds. The passes become slower.";
    if ui.checkbox(&mut checked, "check bounds").on_hover_text(about).changed() {
        actions.push(Action::CheckBounds(checked));
    }
    if view.problems.is_empty() {
        ui.weak("Nothing is wrong.");
    }
    problem_list(ui, view.problems, actions);
}

/// A place in a file, and a button that opens it.
pub(crate) fn place_of(ui: &mut Ui, place: &str, color: Color32, actions: &mut Vec<Action>) {
    let button = ui.link(RichText::new(place).color(color).monospace());
    if button.on_hover_text("Click copies it").clicked() {
        actions.push(Action::Copy(place.to_owned()));
    }
    if ui.small_button("edit").on_hover_text("Open it in $EDITOR").clicked() {
        actions.push(Action::Edit(place.to_owned()));
    }
}

/// Each problem with its text; a click on its place copies it.
pub(crate) fn problem_list(ui: &mut Ui, problems: &[Problem], actions: &mut Vec<Action>) {
    for problem in problems.iter().take(SHOWN) {
        ui.horizontal(|ui| {
            let color = if problem.error { RED } else { YELLOW };
            if let Some(place) = &problem.place {
                place_of(ui, place, color, actions);
            }
            ui.label(RichText::new(&problem.title).color(color));
        });
        ui.add(egui::Label::new(RichText::new(&problem.text).monospace()).extend());
        ui.add_space(6.0);
    }
    if problems.len() > SHOWN {
        ui.weak(format!("and {} more", problems.len() - SHOWN));
    }
}
