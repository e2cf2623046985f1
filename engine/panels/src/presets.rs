//! Named values of params: kept, set again, compared with the values of now.

use egui::{Button, RichText, TextEdit, Ui};

use crate::action::Action;
use crate::view::Preset;

/// Draws the presets and a field for a new one. `name` is the text of the field.
pub(crate) fn show(ui: &mut Ui, presets: &[Preset], name: &mut String, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        for preset in presets {
            let same = preset.differing.is_empty();
            let hint = if same {
                "The params have these values. The right button deletes the preset.".to_owned()
            } else {
                format!(
                    "Sets these params (now, then):\n{}\nThe right button deletes the preset.",
                    preset.differing.join("\n")
                )
            };
            let response = ui.selectable_label(same, &preset.name).on_hover_text(hint);
            if response.clicked() {
                actions.push(Action::ApplyPreset(preset.name.clone()));
            }
            response.context_menu(|ui| {
                if ui.button(format!("Delete {}", preset.name)).clicked() {
                    actions.push(Action::DeletePreset(preset.name.clone()));
                    ui.close();
                }
            });
        }
    });
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("preset");
        ui.add(TextEdit::singleline(name).desired_width(100.0).hint_text(RichText::new("name").weak()))
            .labelled_by(label.id);
        let typed = name.trim();
        let word = if presets.iter().any(|preset| preset.name == typed) { "Replace" } else { "Keep values" };
        let button = ui.add_enabled(!typed.is_empty(), Button::new(word));
        if button.on_hover_text("Keeps the values of all params under this name").clicked() {
            actions.push(Action::SavePreset(typed.to_owned()));
        }
    });
    ui.separator();
}
