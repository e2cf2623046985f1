//! A widget for each live value, by its type and range.

use std::collections::HashMap;
use std::hash::Hash;

use egui::{Button, CollapsingHeader, ComboBox, DragValue, Label, RichText, Slider, SliderClamping, Ui, Vec2};

use crate::action::{Action, WriteTo};
use crate::bar::RED;
use crate::hint::Hint as _;
use crate::presets;
use crate::rows::Rows;
use crate::view::{ComponentKind, Param, View};

/// Integers of so few values are chosen from a list.
const LISTED: f64 = 8.0;

/// In a narrower panel a label stands above its slider, in a line of its own.
const BESIDE: f32 = 250.0;

/// Points that the word `demo` needs behind a label.
const DRIVEN: f32 = 44.0;

/// Draws the panel. `preset` is the text of the field for a name of a preset.
pub(crate) fn show(
    ui: &mut Ui,
    view: &View<'_>,
    (lines, preset): (&mut Rows<1>, &mut String),
    actions: &mut Vec<Action>,
) {
    let params = &view.params;
    if params.is_empty() {
        ui.weak("The graph declares no params.");
        return;
    }
    let changed: Vec<String> =
        params.iter().filter(|param| is_changed(param)).map(|param| param.name.clone()).collect();
    ui.horizontal_wrapped(|ui| {
        let some = !changed.is_empty();
        let own = &view.status.graph_file;
        let hint = || format!("Writes {} into {own}; comments stay", changed.join(", "));
        if ui.add_enabled(some, Button::new("Write to file")).hint(hint).clicked() {
            actions.push(Action::WriteParams(changed.clone(), WriteTo::Own));
        }
        let inherited: Vec<&Param> = params.iter().filter(|param| is_changed(param) && param.file != *own).collect();
        if !inherited.is_empty() {
            let hint = || {
                let each = inherited.iter().map(|param| format!("{} into {}", param.name, param.file));
                let each = each.collect::<Vec<_>>().join(", ");
                format!("Writes {each}, for every graph that extends it; \"Write to file\" overrides it in {own}")
            };
            if ui.button("Write to base").hint(hint).clicked() {
                let names = inherited.iter().map(|param| param.name.clone()).collect();
                actions.push(Action::WriteParams(names, WriteTo::Declared));
            }
        }
        let demo = if view.timeline.is_some() { "of the demo" } else { "of a new demo" };
        let hint = || format!("Moving a param writes keys {demo} while the clock runs, and one key while it is paused");
        let record = RichText::new("Record");
        let record = if view.records { record.color(RED) } else { record };
        if ui.selectable_label(view.records, record).hint(hint).clicked() {
            actions.push(Action::Record(!view.records));
        }
        if ui.add_enabled(some, Button::new("Reset all")).hint(|| "Back to the values of the file").clicked() {
            actions.extend(changed.iter().cloned().map(Action::ResetParam));
        }
    });
    presets::show(ui, &view.presets, preset, actions);
    for section in sections(params) {
        let mut rows = |ui: &mut Ui, actions: &mut Vec<Action>| {
            for (index, param) in &section.params {
                let words = (words(param), view.records, ui.available_width().to_bits());
                lines.add(ui, *index, words, |ui| [row(ui, param, view.records, actions)]);
            }
        };
        match &section.title {
            Some(title) => {
                let header = CollapsingHeader::new(title).default_open(true).id_salt(("group", title));
                header.show(ui, |ui| rows(ui, actions));
            }
            None => rows(ui, actions),
        }
    }
}

/// All that the size of a row depends on.
fn words(param: &Param) -> impl Hash {
    let value: Vec<u64> = param.value.iter().map(|component| component.to_bits()).collect();
    let widget = (param.kind as u8, param.range.is_some(), param.choices.len(), param.color, param.driven);
    (&param.label, &param.unit, value, widget)
}

/// Params that stand together, under a title or under none, with their indices.
struct Section<'p> {
    title: Option<String>,
    params: Vec<(usize, &'p Param)>,
}

/// The params by group, each group where its first param stands.
fn sections(params: &[Param]) -> Vec<Section<'_>> {
    // How many params begin with a word.
    let mut begins: HashMap<&str, usize> = HashMap::new();
    for own in params.iter().filter_map(word) {
        *begins.entry(own).or_default() += 1;
    }
    let mut sections: Vec<Section<'_>> = Vec::new();
    for (index, param) in params.iter().enumerate() {
        let title = group_of(&begins, param);
        let known = match &title {
            Some(_) => sections.iter_mut().find(|section| section.title == title),
            None => sections.last_mut().filter(|section| section.title.is_none()),
        };
        match known {
            Some(section) => section.params.push((index, param)),
            None => sections.push(Section { title, params: vec![(index, param)] }),
        }
    }
    sections
}

/// The group that the file says; else params that begin with the same word belong together: `sun_azimuth`, `sun_strength`.
fn group_of(begins: &HashMap<&str, usize>, param: &Param) -> Option<String> {
    if param.group.is_some() {
        return param.group.clone();
    }
    let own = word(param)?;
    begins.get(own).is_some_and(|count| *count > 1).then(|| capital(own))
}

/// The first of the words of the name of a param without a group.
fn word(param: &Param) -> Option<&str> {
    param.name.split_once('_').map(|(word, _)| word).filter(|_| param.group.is_none())
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn is_changed(param: &Param) -> bool {
    param.value != param.default && !param.driven
}

/// Draws a param with what stands beside it. Gives the size of all.
fn row(ui: &mut Ui, param: &Param, records: bool, actions: &mut Vec<Action>) -> Vec2 {
    let mut value = param.value.clone();
    let line = ui.horizontal(|ui| {
        let reset = Button::new("↺").small();
        let response = ui.add_enabled(is_changed(param), reset);
        let response = response.hint(|| format!("Reset {} to {}", param.name, text_of(param, &param.default)));
        response
            .widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, format!("reset {}", param.name)));
        if response.clicked() {
            actions.push(Action::ResetParam(param.name.clone()));
        }
        ui.add_enabled_ui(!param.driven || records, |ui| {
            if widget(ui, param, &mut value) {
                actions.push(Action::SetParam(param.name.clone(), value));
            }
        });
        if param.driven {
            ui.label(RichText::new("demo").weak())
                .hint(|| "A track of the demo drives it. Move the camera to take over, or record it.");
        }
    });
    line.response.rect.size()
}

/// Draws a param, and says whether it was changed.
fn widget(ui: &mut Ui, param: &Param, value: &mut [f64]) -> bool {
    let hint = || hint_of(param);
    if let [component] = value {
        return match param.kind {
            ComponentKind::Bool => {
                let mut on = *component != 0.0;
                let response = ui.checkbox(&mut on, &param.label).hint(hint);
                *component = f64::from(u8::from(on));
                response.changed()
            }
            ComponentKind::Int | ComponentKind::Uint if !param.choices.is_empty() || is_short(param) => {
                choice(ui, param, component)
            }
            _ => scalar(ui, param, component, hint),
        };
    }
    if param.color {
        return color(ui, param, value, hint);
    }
    let mut changed = false;
    ui.vertical(|ui| {
        ui.label(&param.label).hint(hint);
        ui.horizontal_wrapped(|ui| {
            for (index, component) in value.iter_mut().enumerate() {
                let response = ui.add(drag(param, component));
                let name = format!("{} {index}", param.name);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::DragValue, true, &name));
                changed |= response.changed();
            }
        });
    });
    changed
}

fn scalar(ui: &mut Ui, param: &Param, component: &mut f64, hint: impl Fn() -> String + Copy) -> bool {
    let Some(range) = param.range else {
        let label = ui.label(&param.label);
        return ui.add(drag(param, component)).labelled_by(label.id).hint(hint).changed();
    };
    ui.spacing_mut().slider_width = 90.0;
    if ui.available_width() < BESIDE {
        let both = ui.vertical(|ui| {
            let label = ui.add(Label::new(&param.label).wrap()).hint(hint);
            ui.add(slider(param, range, component)).labelled_by(label.id).hint(hint).changed()
        });
        return both.inner;
    }
    let slider = ui.add(slider(param, range, component));
    // A label that is too long for the panel ends in dots; what follows it stays in sight.
    let room = ui.available_width() - if param.driven { DRIVEN } else { 0.0 };
    let label = ui.scope(|ui| {
        ui.set_max_width(room.max(0.0));
        ui.add(Label::new(&param.label).truncate())
    });
    slider.labelled_by(label.inner.hint(hint).id).hint(hint).changed()
}

fn slider<'v>(param: &Param, [low, high]: [f64; 2], component: &'v mut f64) -> Slider<'v> {
    let slider = Slider::new(component, low..=high).clamping(SliderClamping::Edits).suffix(suffix(param));
    let slider = match (param.step, param.kind) {
        (Some(step), _) => slider.step_by(step),
        (None, ComponentKind::Int | ComponentKind::Uint) => slider.step_by(1.0),
        (None, _) => slider.smart_aim(true),
    };
    if param.kind == ComponentKind::Float { slider } else { slider.integer() }
}

fn drag<'v>(param: &Param, component: &'v mut f64) -> DragValue<'v> {
    let step = param.step.unwrap_or(match (param.kind, param.range) {
        (ComponentKind::Float, Some([low, high])) => (high - low) / 400.0,
        (ComponentKind::Float, None) => (component.abs() * 0.01).max(0.001),
        _ => 0.1,
    });
    let drag = DragValue::new(component).speed(step).clamp_existing_to_range(false).suffix(suffix(param));
    let drag = if param.kind == ComponentKind::Float { drag.max_decimals(5) } else { drag.max_decimals(0) };
    match (param.range, param.kind) {
        (Some([low, high]), _) => drag.range(low..=high),
        (None, ComponentKind::Uint) => drag.range(0.0..=f64::from(u32::MAX)),
        (None, ComponentKind::Int) => drag.range(f64::from(i32::MIN)..=f64::from(i32::MAX)),
        (None, _) => drag.range(f64::from(f32::MIN)..=f64::from(f32::MAX)),
    }
}

/// Whether its range has so few integers that they are listed.
fn is_short(param: &Param) -> bool {
    param.range.is_some_and(|[low, high]| high - low < LISTED)
}

#[expect(clippy::cast_possible_truncation, reason = "a choice is an integer of 32 bits")]
fn choice(ui: &mut Ui, param: &Param, component: &mut f64) -> bool {
    let [low, high] = param.range.unwrap_or_default().map(|end| end as i64);
    let text = |number: i64| {
        let name = usize::try_from(number).ok().and_then(|index| param.choices.get(index));
        name.cloned().unwrap_or_else(|| format!("{number}{}", suffix(param)))
    };
    let before = *component;
    let width = if param.choices.is_empty() { 60.0 } else { 130.0 };
    let list = ComboBox::from_label(&param.label).width(width).selected_text(text(before as i64));
    let shown = list.show_ui(ui, |ui| {
        for number in low..=high {
            ui.selectable_value(component, number as f64, text(number));
        }
    });
    shown.response.hint(|| hint_of(param));
    before.to_bits() != component.to_bits()
}

/// Its purpose, its name and range, and the place of its declaration.
fn hint_of(param: &Param) -> String {
    let about = param.tooltip.as_ref().map_or_else(String::new, |text| format!("{text}\n\n"));
    let range = match (param.range, param.choices.as_slice()) {
        (Some([low, high]), []) => format!(", {low} to {high}{}", suffix(param)),
        _ => String::new(),
    };
    format!("{about}{}{range}\n{}", param.name, param.place)
}

/// The unit, to stand behind a number: `°` close to it, a word apart.
fn suffix(param: &Param) -> String {
    let Some(unit) = &param.unit else { return String::new() };
    let apart = unit.starts_with(char::is_alphanumeric);
    format!("{}{unit}", if apart { " " } else { "" })
}

#[expect(clippy::cast_possible_truncation, reason = "colours of egui, and params, are 32-bit floats")]
fn color(ui: &mut Ui, param: &Param, value: &mut [f64], hint: impl Fn() -> String + Copy) -> bool {
    let label = ui.label(&param.label);
    let mut linear: Vec<f32> = value.iter().map(|component| *component as f32).collect();
    let response = match linear.as_mut_slice() {
        [r, g, b] => {
            let mut rgb = [*r, *g, *b];
            let response = ui.color_edit_button_rgb(&mut rgb);
            [*r, *g, *b] = rgb;
            response
        }
        [r, g, b, a] => {
            let mut rgba = [*r, *g, *b, *a];
            let response = ui.color_edit_button_rgba_unmultiplied(&mut rgba);
            [*r, *g, *b, *a] = rgba;
            response
        }
        _ => return false,
    };
    let changed = response.labelled_by(label.id).hint(hint).changed();
    if changed {
        for (component, linear) in value.iter_mut().zip(linear) {
            let [low, high] = param.range.unwrap_or([0.0, 1.0]);
            *component = f64::from(linear).clamp(low, high);
        }
    }
    changed
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a choice is an integer of 32 bits, and a cast of a float saturates"
)]
fn text_of(param: &Param, value: &[f64]) -> String {
    if let ([index], true) = (value, !param.choices.is_empty()) {
        return param.choices.get(*index as usize).cloned().unwrap_or_else(|| index.to_string());
    }
    let parts: Vec<String> = value.iter().map(ToString::to_string).collect();
    format!("{}{}", parts.join(", "), suffix(param))
}
