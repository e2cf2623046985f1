//! The list of graphs, worlds and demos of the project, with a filter: one of them takes the place of what runs.

use egui::{Context, Id, Key, Modal, Modifiers, RichText, ScrollArea, TextEdit, Ui};

use crate::action::Action;
use crate::view::{FileKind, ProjectFile};

/// Points of the list.
const WIDTH: f32 = 380.0;
const HEIGHT: f32 = 340.0;

/// The list while it is open.
#[derive(Debug, Default)]
pub(crate) struct Switcher {
    filter: String,
    /// Which of the files that are left is chosen.
    chosen: usize,
    /// The frame in which it was drawn first.
    first: Option<u64>,
}

/// The result of drawing the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switching {
    Goes,
    Ends,
}

impl Switcher {
    /// Draws the list.
    pub(crate) fn show(
        &mut self,
        ctx: &Context,
        files: Option<&[ProjectFile]>,
        actions: &mut Vec<Action>,
    ) -> Switching {
        let frame = ctx.cumulative_frame_nr();
        if *self.first.get_or_insert(frame) == frame {
            // The key that opened the list is no part of the filter.
            ctx.input_mut(|input| input.events.retain(|event| !matches!(event, egui::Event::Text(_))));
        }
        let modal = Modal::new(Id::new("switcher")).show(ctx, |ui| {
            ui.set_width(WIDTH);
            // Arrows and Enter are the list's, not the field's.
            let pressed = |ui: &Ui, key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
            let step = i32::from(pressed(ui, Key::ArrowDown)) - i32::from(pressed(ui, Key::ArrowUp));
            let enter = pressed(ui, Key::Enter);
            let hint = RichText::new("a graph, a world or a demo").weak();
            let field = ui.add(TextEdit::singleline(&mut self.filter).desired_width(f32::INFINITY).hint_text(hint));
            field.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::TextEdit, true, "file to open"));
            // Typed text is always the filter: a key that no field takes would move the camera.
            field.request_focus();
            if field.changed() {
                self.chosen = 0;
            }
            let Some(files) = files else {
                ui.weak("reads the folders of the project");
                return None;
            };
            let left: Vec<&ProjectFile> = files.iter().filter(|file| matches(&file.path, &self.filter)).collect();
            let last = left.len().saturating_sub(1);
            self.chosen = self.chosen.min(last).saturating_add_signed(step as isize).min(last);
            let clicked = list(ui, &left, self.chosen, step != 0);
            clicked.or(enter.then_some(self.chosen)).and_then(|index| left.get(index)).map(|file| (*file).clone())
        });
        if let Some(file) = modal.inner.clone() {
            actions.push(Action::Open(file.kind, file.path));
            return Switching::Ends;
        }
        if modal.should_close() { Switching::Ends } else { Switching::Goes }
    }
}

/// Draws the files that are left, and gives the one that was clicked.
fn list(ui: &mut Ui, left: &[&ProjectFile], chosen: usize, moved: bool) -> Option<usize> {
    let mut clicked = None;
    ScrollArea::vertical().max_height(HEIGHT).auto_shrink([false, true]).show(ui, |ui| {
        let mut kind = None;
        for (index, file) in left.iter().enumerate() {
            if kind != Some(file.kind) {
                kind = Some(file.kind);
                ui.weak(title(file.kind));
            }
            let text = if file.runs { format!("{} (open)", file.path) } else { file.path.clone() };
            let row = ui.selectable_label(index == chosen, text);
            if row.clicked() {
                clicked = Some(index);
            }
            if moved && index == chosen {
                row.scroll_to_me(None);
            }
        }
        if left.is_empty() {
            ui.weak("No file of the project has this in its path.");
        }
    });
    clicked
}

fn title(kind: FileKind) -> &'static str {
    match kind {
        FileKind::Demo => "demos",
        FileKind::World => "worlds",
        FileKind::Graph => "graphs",
    }
}

/// Whether a path has all words of a filter in it, in any order.
fn matches(path: &str, filter: &str) -> bool {
    let path = path.to_lowercase();
    filter.split_whitespace().all(|word| path.contains(&word.to_lowercase()))
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn a_path_has_all_words_of_the_filter() {
        let path = "worlds/valley.demo.toml";
        for found in ["", " ", "valley", "VALLEY demo", "demo val"] {
            assert!(matches(path, found), "{found}");
        }
        assert!(!matches(path, "valley graph"));
    }
}
