//! Texts that are made only while the pointer rests on their widget.

use egui::Response;

/// Shows a text while the pointer rests on a widget, as [`Response::on_hover_text`] does. egui looks for reasons to show a text before it asks
/// whether the pointer is there, which takes as long as drawing the widget.
pub(crate) trait Hint {
    /// Shows what `text` makes.
    fn hint<T: Into<String>>(self, text: impl FnOnce() -> T) -> Self;
}

impl Hint for Response {
    fn hint<T: Into<String>>(self, text: impl FnOnce() -> T) -> Self {
        if self.hovered() { self.on_hover_text(text().into()) } else { self }
    }
}
