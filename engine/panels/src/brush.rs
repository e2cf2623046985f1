//! The brush: what the right mouse button does to the world's voxels.

use egui::{
    Button, Color32, Context, DragValue, Grid, LayerId, Rect, RichText, ScrollArea, Sense, Stroke, TextEdit, Ui, vec2,
};

use crate::action::Action;
use crate::bar::YELLOW;
use crate::view::{Brush, Editing, Effect, Shape, Swatch};

/// A palette with more materials has a field to search it.
const SEARCHED: usize = 12;

/// Draws it. `search` is the text of the field that the palette is searched by.
pub(crate) fn show(ui: &mut Ui, editing: &Editing<'_>, search: &mut String, actions: &mut Vec<Action>) {
    let brush = editing.brush;
    ui.horizontal_wrapped(|ui| {
        ui.strong("Brush");
        let [undo, redo] = editing.steps;
        step(ui, ("Undo", undo, "Ctrl+Z"), Action::Undo, actions);
        step(ui, ("Redo", redo, "Ctrl+Y"), Action::Redo, actions);
    });
    ui.weak("right button; Shift does the opposite, Ctrl picks the material").on_hover_text(
        "Holding the button goes on painting.\nShift: add and subtract change places, and so do paint and pick.",
    );
    if let Some(refused) = &editing.refused {
        ui.label(RichText::new(format!("the last edit was not made: {refused}")).color(YELLOW));
    }
    ui.horizontal_wrapped(|ui| {
        for effect in Effect::ALL {
            if ui.selectable_label(brush.effect == effect, effect.word()).on_hover_text(effect.about()).clicked() {
                actions.push(Action::Brush(Brush { effect, ..brush }));
            }
        }
    });
    if brush.effect != Effect::Pick {
        extent(ui, brush, actions);
    }
    if brush.effect != Effect::Subtract {
        palette(ui, editing, search, actions);
    }
    // Last: it comes and goes with the cursor, and nothing below it may move.
    if let Some(under) = &editing.under {
        ui.label(format!("under the cursor: {under}"));
    }
}

/// Draws lines over the picture, which is in this area, below all panels.
pub(crate) fn outline(ctx: &Context, area: Rect, lines: &[[[f32; 2]; 2]]) {
    let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(area);
    let scale = ctx.pixels_per_point();
    for [a, b] in lines {
        let ends = [a, b].map(|[x, y]| area.min + vec2(x / scale, y / scale));
        // Dark below light: seen over any picture.
        painter.line_segment(ends, Stroke::new(2.5, Color32::from_black_alpha(110)));
        painter.line_segment(ends, Stroke::new(1.0, Color32::from_white_alpha(220)));
    }
}

fn step(ui: &mut Ui, (word, steps, key): (&str, usize, &str), action: Action, actions: &mut Vec<Action>) {
    let hint = format!("{steps} steps; {key}");
    if ui.add_enabled(steps > 0, Button::new(word)).on_hover_text(hint).clicked() {
        actions.push(action);
    }
}

/// Shape and size.
fn extent(ui: &mut Ui, brush: Brush, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        for shape in Shape::ALL {
            if ui.selectable_label(brush.shape == shape, shape.word()).clicked() {
                actions.push(Action::Brush(Brush { shape, ..brush }));
            }
        }
    });
    Grid::new("brush").num_columns(2).show(ui, |ui| {
        let mut number = |label: &str, hint: &str, value: u32, set: fn(&mut Brush, u32)| {
            let label = ui.weak(label);
            let mut voxels = value;
            let speed = (f64::from(value) * 0.02).max(0.1);
            let drag = DragValue::new(&mut voxels).range(1..=Brush::LARGEST).speed(speed).suffix(" voxels");
            if ui.add(drag).labelled_by(label.id).on_hover_text(hint).changed() {
                let mut brush = brush;
                set(&mut brush, voxels);
                actions.push(Action::Brush(brush));
            }
            ui.end_row();
        };
        if brush.shape != Shape::Voxel {
            number("across", "The keys [ and ]", brush.size, |brush, voxels| brush.size = voxels);
        }
        if brush.shape == Shape::Cylinder {
            let hint = "Adding, the brush stands on the face under the cursor; subtracting and painting, it goes into the world";
            number("height", hint, brush.height, |brush, voxels| brush.height = voxels);
        }
    });
}

/// The materials, as colours with names.
fn palette(ui: &mut Ui, editing: &Editing<'_>, search: &mut String, actions: &mut Vec<Action>) {
    let brush = editing.brush;
    ui.weak("material");
    if editing.materials.len() > SEARCHED {
        ui.add(TextEdit::singleline(search).desired_width(140.0).hint_text(RichText::new("search").weak()));
    } else {
        search.clear();
    }
    let wanted = search.to_lowercase();
    let found: Vec<&Swatch> =
        editing.materials.iter().filter(|swatch| swatch.name.to_lowercase().contains(&wanted)).collect();
    let height = ui.spacing().interact_size.y;
    let room = (found.len() + 1).min(8) as f32 * (height + ui.spacing().item_spacing.y);
    let list = ScrollArea::vertical().id_salt("palette").max_height(room).auto_shrink([false, true]);
    // Row 0 is the material under the cursor.
    list.show_rows(ui, height, found.len() + 1, |ui, rows| {
        for row in rows {
            let swatch = row.checked_sub(1).map(|index| found[index]);
            let material = swatch.map(|swatch| swatch.material);
            let clicked = ui
                .horizontal(|ui| {
                    let (rect, square) = ui.allocate_exact_size(vec2(height, height - 4.0), Sense::click());
                    let name = match swatch {
                        Some(swatch) => {
                            let [r, g, b] = swatch.color;
                            ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
                            swatch.name.as_str()
                        }
                        None => "the one under the cursor",
                    };
                    square.clicked() | ui.selectable_label(brush.material == material, name).clicked()
                })
                .inner;
            if clicked {
                actions.push(Action::Brush(Brush { material, ..brush }));
            }
        }
    });
    if found.is_empty() {
        ui.weak("no material has this in its name");
    }
}
