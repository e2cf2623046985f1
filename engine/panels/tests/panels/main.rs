//! The panels, driven by their accessibility tree: what a user sees by name, clicks, and what comes of it.

#[path = "../window/mod.rs"]
mod window;

mod frame;
mod graph;
mod inspect;
mod layout;
mod params;
mod problems;
mod timeline;

use egui::Vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use raxel_panels::Action;
use window::Window;

impl Window {
    fn harness(mut self, width: f32, height: f32) -> Harness<'static, Window> {
        self.panels.whole = true;
        let size = Vec2::new(width, height);
        let mut harness =
            Harness::builder().with_size(size).build_state(|ctx, window: &mut Window| window.draw(ctx), self);
        harness.run_steps(3);
        harness
    }
}

/// Clicks the widget of this name, and returns the user's actions.
#[track_caller]
fn click(harness: &mut Harness<'_, Window>, name: &str) -> Vec<Action> {
    harness.state_mut().actions.clear();
    harness.get_by_label(name).click();
    // One for each event, and more for what opens to find its size.
    harness.run_steps(6);
    harness.state().actions.iter().filter(|action| !matches!(action, Action::Peek(_))).cloned().collect()
}

/// The places of the lines of a label with this text.
fn texts(harness: &Harness<'_, Window>, text: &str) -> Vec<egui::Rect> {
    let label = egui::accesskit::Role::Label;
    harness
        .query_all_by_value(text)
        .filter(|node| node.accesskit_node().role() == label)
        .map(|node| node.rect())
        .collect()
}

fn drag(harness: &mut Harness<'_, Window>, from: egui::Pos2, to: egui::Pos2) {
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(from + (to - from) * 0.5);
    harness.run_steps(2);
    harness.hover_at(to);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run_steps(2);
}
