//! The contents of the shown resource: mip, layer, channel, range, distribution, the texel under the cursor and a pinned one, the rows of a
//! buffer.

use egui::{
    Align2, Button, Color32, ComboBox, Context, DragValue, Grid, LayerId, Rect, RichText, Sense, Stroke, StrokeKind,
    Ui, Vec2, pos2, vec2,
};

use raxel_picture::{BINS, Sought, Statistics};

use crate::action::Action;
use crate::bar::{RED, YELLOW, text_of};
use crate::docks::caption;
use crate::problems::place_of;
use crate::view::{
    Inspected, Looking, Magnified, Map, PassWriters, Pinned, Shown, Table, Texel, TexelHistory, View, Zoom,
};

/// Points between columns of numbers, and between their rows.
const COLUMNS: Vec2 = Vec2::new(12.0, 3.0);

/// Writes of a pass that are drawn; the others are counted.
const WRITES: usize = 12;

/// Draws the panel.
pub(crate) fn show(ui: &mut Ui, view: &View<'_>, actions: &mut Vec<Action>) {
    ui.label(RichText::new(text_of(&view.status.shown)).strong());
    let Some(found) = view.inspected else {
        ui.weak("reading");
        return;
    };
    ui.weak(&found.about);
    part(ui, found, actions);
    if !found.channels.is_empty() {
        mapping(ui, found, actions);
    }
    if let Some(statistics) = &found.statistics {
        numbers(ui, found, statistics, actions);
        histogram(ui, statistics);
    }
    if found.earlier {
        ui.weak("These numbers are of an earlier frame.");
    }
    if let Some(looking) = &found.looking {
        search(ui, looking, actions);
    }
    texels(ui, found, actions);
    if let Some(table) = &found.table {
        rows(ui, table, actions);
    }
}

/// Mip and layer.
fn part(ui: &mut Ui, found: &Inspected, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let mut shown = found.shown.clone();
        for (name, value, count) in [("mip", &mut shown.mip, found.mips), ("layer", &mut shown.layer, found.layers)] {
            if count > 1 {
                let label = ui.label(name);
                ui.add(DragValue::new(value).range(0..=count - 1).speed(0.1)).labelled_by(label.id);
                ui.weak(format!("of {count}"));
            }
        }
        if shown != found.shown {
            actions.push(Action::Show(Shown { ..shown }));
        }
    });
}

/// How texels become colours.
#[expect(clippy::cast_possible_truncation, reason = "there are four channels")]
fn mapping(ui: &mut Ui, found: &Inspected, actions: &mut Vec<Action>) {
    let Some(used) = found.used else { return };
    let mut own = found.map.is_some();
    let mut map = found.map.unwrap_or(used);
    let before = (own, map);
    ui.horizontal_wrapped(|ui| {
        if ui.checkbox(&mut own, "own map").on_hover_text("Off: `display` of the graph's file").changed() && own {
            map.range = None;
        }
        ui.add_enabled_ui(own, |ui| {
            ComboBox::from_id_salt("map").width(80.0).selected_text(Map::NAMES[map.map]).show_ui(ui, |ui| {
                for (index, name) in Map::NAMES.iter().enumerate() {
                    ui.selectable_value(&mut map.map, index, *name);
                }
            });
            for (index, name) in found.channels.iter().enumerate() {
                ui.selectable_value(&mut map.channel, index as u32, *name);
            }
        });
    });
    ui.add_enabled_ui(own, |ui| {
        ui.horizontal(|ui| {
            let mut automatic = map.range.is_none();
            let mut range = map.range.or(used.range).unwrap_or([0.0, 1.0]);
            let speed = f64::from((range[1] - range[0]).abs().max(1e-3)) / 200.0;
            let label = ui.label("range");
            let low = ui.add(DragValue::new(&mut range[0]).speed(speed)).labelled_by(label.id).changed();
            let high = ui.add(DragValue::new(&mut range[1]).speed(speed)).changed();
            let chosen = ui.checkbox(&mut automatic, "automatic").on_hover_text("From the 1st to the 99th percentile");
            if low || high {
                map.range = Some(range);
            } else if chosen.changed() {
                map.range = (!automatic).then_some(range);
            }
        });
    });
    if (own, map) != before {
        actions.push(Action::Display(own.then_some(map)));
    }
}

fn numbers(ui: &mut Ui, inspected: &Inspected, found: &Statistics, actions: &mut Vec<Action>) {
    let map = inspected.map.or(inspected.used);
    let chosen = map.map_or(0, |map| map.channel as usize).min(inspected.channels.len().saturating_sub(1));
    let channel = inspected.channels.get(chosen).copied().unwrap_or_default();
    // The numbers are those of the shown slice, and another one may have what this one lacks.
    let several = inspected.mips > 1 || inspected.layers > 1;
    Grid::new("statistics").num_columns(3).show(ui, |ui| {
        ui.weak("values");
        ui.monospace(found.count.to_string());
        ui.end_row();
        let [low, high] = found.range;
        let any = several || found.nan + found.infinite < found.count;
        for (sought, value) in [(Sought::Smallest, low), (Sought::Largest, high)] {
            ui.weak(sought.word());
            ui.monospace(value.to_string());
            jumps(ui, any, (sought, chosen, channel), actions);
            ui.end_row();
        }
        ui.weak("mean");
        ui.monospace(format!("{:.6}", found.mean));
        ui.end_row();
        // Who looks for a NaN need not try the channels one by one.
        for (index, (name, counts)) in inspected.channels.iter().zip(&inspected.not_finite).enumerate() {
            for (sought, count) in [(Sought::Nan, counts.nan), (Sought::Infinite, counts.infinite)] {
                if count == 0 && index != chosen {
                    continue;
                }
                ui.weak(format!("{} in {name}", sought.word()));
                let text = RichText::new(count.to_string()).monospace();
                ui.label(if count > 0 { text.color(RED) } else { text });
                jumps(ui, several || count > 0, (sought, index, name), actions);
                ui.end_row();
            }
        }
    });
}

/// Buttons that pin the previous and the next texel of a count.
#[expect(clippy::cast_possible_truncation, reason = "there are four channels")]
fn jumps(ui: &mut Ui, any: bool, (sought, index, channel): (Sought, usize, &str), actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        for (sign, which, forward) in [("<", "previous", false), (">", "next", true)] {
            let name = format!("{which} {} in {channel}", sought.word());
            let button = ui.add_enabled(any, Button::new(sign).small());
            button.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, any, &name));
            if button.on_hover_text(format!("Pins the {name}")).clicked() {
                actions.push(Action::Find { sought, channel: index as u32, forward });
            }
        }
    });
}

/// How far a search has come.
fn search(ui: &mut Ui, looking: &Looking, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let Looking { sought, looked, slices } = looking;
        ui.label(format!("looking for {}: slice {looked} of {slices}", sought.word()));
        if ui.button("Stop").on_hover_text("Ends the search").clicked() {
            actions.push(Action::StopFind);
        }
    });
}

fn histogram(ui: &mut Ui, found: &Statistics) {
    let size = vec2(ui.available_width().clamp(100.0, 400.0), 64.0);
    let (response, painter) = ui.allocate_painter(size, Sense::hover());
    let area = response.rect;
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(120));
    let most = found.histogram.iter().copied().max().unwrap_or(0).max(1) as f32;
    let width = area.width() / BINS as f32;
    for (index, count) in found.histogram.iter().enumerate() {
        // A few are seen beside many.
        let height = (*count as f32 / most).sqrt() * (area.height() - 12.0);
        let left = area.left() + index as f32 * width;
        let bar = Rect::from_min_max(pos2(left, area.bottom() - height), pos2(left + width - 0.5, area.bottom()));
        painter.rect_filled(bar, 0.0, Color32::from_rgb(120, 170, 250));
    }
    let [low, high] = found.percentiles;
    caption(ui, area.left_top() + vec2(3.0, 1.0), Align2::LEFT_TOP, &format!("{low}"));
    caption(ui, area.right_top() + vec2(-3.0, 1.0), Align2::RIGHT_TOP, &format!("{high}"));
}

/// The pinned texels, the one under the cursor, and what lies around.
fn texels(ui: &mut Ui, found: &Inspected, actions: &mut Vec<Action>) {
    let [width, height] = found.extent;
    if width == 0 || height == 0 {
        return;
    }
    if found.pins.len() > 1 {
        pins(ui, found, actions);
    }
    ui.horizontal(|ui| {
        let Some(pinned) = &found.pinned else {
            if ui.button("Pin a texel").on_hover_text("P pins the texel under the cursor").clicked() {
                actions.push(Action::Pin(found.cursor.as_ref().map_or([width / 2, height / 2], |texel| texel.at)));
            }
            return;
        };
        let mut at = pinned.at;
        let label = ui.label("pinned");
        for (place, size) in at.iter_mut().zip(found.extent) {
            ui.add(DragValue::new(place).range(0..=size - 1).speed(0.2)).labelled_by(label.id);
        }
        if at != pinned.at {
            actions.push(Action::MovePin(found.active, at));
        }
        if ui.button("Unpin").on_hover_text("P over the pin").clicked() {
            actions.push(Action::Unpin(found.active));
        }
    });
    if let Some(pinned) = &found.pinned {
        texel(ui, "pinned texel", found, pinned);
    }
    match &found.cursor {
        Some(cursor) => {
            ui.label(format!("texel {}, {}", cursor.at[0], cursor.at[1]));
            texel(ui, "texel", found, cursor);
        }
        None if found.pinned.is_none() => {
            ui.weak("The texel under the cursor is shown here.");
        }
        None => {}
    }
    if let Some(zoom) = &found.zoom {
        squares(ui, zoom);
    }
    if let (Some(_), Some(history)) = (&found.pinned, &found.history) {
        over_passes(ui, found, history);
        over_frames(ui, found, &history.frames);
    }
    if found.pinned.is_some() {
        who_wrote(ui, found.writers.as_deref(), actions);
    }
}

/// The invocations that wrote the pinned texel, for as long as they are asked for.
fn who_wrote(ui: &mut Ui, writers: Option<&[PassWriters]>, actions: &mut Vec<Action>) {
    let mut asked = writers.is_some();
    let about =
        "Compile the shaders so that they tell which invocation writes the pinned texel. The passes become slower.";
    if ui.toggle_value(&mut asked, "Who wrote it").on_hover_text(about).changed() {
        actions.push(Action::FindWriters(asked));
    }
    let Some(passes) = writers else { return };
    if passes.is_empty() {
        ui.weak("No pass that may write it has run with these shaders.");
    }
    for (index, pass) in passes.iter().enumerate() {
        written_by(ui, index, pass, actions);
    }
}

/// The writes of one pass.
fn written_by(ui: &mut Ui, index: usize, pass: &PassWriters, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.monospace(&pass.pass);
        ui.weak(match pass.count {
            0 => format!("did not write it in frame {}", pass.frame),
            1 => format!("in frame {}", pass.frame),
            count => format!("{count} times in frame {}", pass.frame),
        });
    });
    if pass.race {
        let text =
            "Several invocations wrote it: without a barrier between them, the device decides which value is left.";
        ui.label(RichText::new(text).color(YELLOW));
    }
    let shown = &pass.writes[..pass.writes.len().min(WRITES)];
    Grid::new(("written by", index)).num_columns(4).spacing(COLUMNS).show(ui, |ui| {
        for write in shown {
            let list = |numbers: [u32; 3]| format!("({}, {}, {})", numbers[0], numbers[1], numbers[2]);
            ui.horizontal(|ui| {
                if let Some(place) = &write.place {
                    place_of(ui, place, ui.visuals().hyperlink_color, actions);
                }
            });
            ui.monospace(list(write.invocation)).on_hover_text("gl_GlobalInvocationID");
            ui.monospace(write.values.join("  "));
            ui.monospace(list(write.workgroup)).on_hover_text("gl_WorkGroupID");
            ui.end_row();
        }
    });
    let more = pass.count as usize - shown.len().min(pass.count as usize);
    if more > 0 {
        ui.weak(format!("and {more} more"));
    }
}

/// A row for each pin. A click makes it the active one.
fn pins(ui: &mut Ui, found: &Inspected, actions: &mut Vec<Action>) {
    Grid::new("pins").num_columns(found.channels.len() + 2).spacing(COLUMNS).show(ui, |ui| {
        ui.weak("pin");
        ui.weak("texel");
        for name in &found.channels {
            ui.weak(*name);
        }
        ui.end_row();
        for Pinned { number, texel } in &found.pins {
            let name = format!("pin {number}");
            let button = ui.selectable_label(*number == found.active, number.to_string());
            button.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::SelectableLabel, true, &name));
            if button.on_hover_text("Shows the history of this texel").clicked() {
                actions.push(Action::ChoosePin(*number));
            }
            if let Some(Texel { at: [x, y], values }) = texel {
                ui.monospace(format!("{x}, {y}"));
                for [value, _] in values {
                    ui.monospace(value);
                }
            }
            ui.end_row();
        }
    });
}

fn texel(ui: &mut Ui, id: &str, found: &Inspected, texel: &Texel) {
    Grid::new(id).num_columns(3).spacing(COLUMNS).show(ui, |ui| {
        for (name, [value, bits]) in found.channels.iter().zip(&texel.values) {
            ui.weak(*name);
            ui.monospace(value);
            ui.monospace(bits);
            ui.end_row();
        }
    });
}

/// The pinned texel as each pass of the newest frame left it.
fn over_passes(ui: &mut Ui, found: &Inspected, history: &TexelHistory) {
    Grid::new("over passes").num_columns(found.channels.len() + 1).spacing(COLUMNS).show(ui, |ui| {
        ui.weak("after pass");
        for name in &found.channels {
            ui.weak(*name);
        }
        ui.end_row();
        for write in &history.writes {
            ui.monospace(&write.pass);
            for value in &write.values {
                ui.monospace(value);
            }
            ui.end_row();
        }
    });
}

/// The chosen channel of the pinned texel over frames, from its smallest value to its largest.
fn over_frames(ui: &mut Ui, found: &Inspected, values: &[Option<f32>]) {
    if values.len() < 2 {
        return;
    }
    let map = found.map.or(found.used);
    let channel = map.and_then(|map| found.channels.get(map.channel as usize)).copied().unwrap_or_default();
    ui.weak(format!("{channel} in the last {} frames that wrote it", values.len()));
    let size = vec2(ui.available_width().clamp(100.0, 400.0), 48.0);
    let (response, painter) = ui.allocate_painter(size, Sense::hover());
    let area = response.rect;
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(120));
    let finite = || values.iter().copied().flatten();
    let (low, high) = (finite().fold(f32::INFINITY, f32::min), finite().fold(f32::NEG_INFINITY, f32::max));
    if low > high {
        return;
    }
    let inner = area.shrink2(vec2(2.0, 12.0));
    let point = |index: usize| {
        let share = if high > low { (values[index]? - low) / (high - low) } else { 0.5 };
        let along = index as f32 / (values.len() - 1) as f32;
        Some(pos2(inner.left() + along * inner.width(), inner.bottom() - share * inner.height()))
    };
    // A value that is no finite number leaves a gap.
    for ends in (1..values.len()).filter_map(|index| Some([point(index - 1)?, point(index)?])) {
        painter.line_segment(ends, Stroke::new(1.5, Color32::from_rgb(120, 170, 250)));
    }
    caption(ui, area.left_top() + vec2(3.0, 0.0), Align2::LEFT_TOP, &high.to_string());
    caption(ui, area.left_bottom() + vec2(3.0, 0.0), Align2::LEFT_BOTTOM, &low.to_string());
}

/// Texels as squares, the central one framed.
fn squares(ui: &mut Ui, zoom: &Zoom) {
    let cell = (ui.available_width() / Zoom::SIDE as f32).clamp(4.0, 16.0).floor();
    let (response, painter) = ui.allocate_painter(Vec2::splat(cell * Zoom::SIDE as f32), Sense::hover());
    let square = |index: u32| {
        let (x, y) = (index % Zoom::SIDE, index / Zoom::SIDE);
        Rect::from_min_size(response.rect.min + vec2(x as f32, y as f32) * cell, Vec2::splat(cell))
    };
    for (index, color) in (0..).zip(&zoom.colors) {
        let color = color.map_or(Color32::from_black_alpha(120), |[r, g, b]| Color32::from_rgb(r, g, b));
        painter.rect_filled(square(index), 0.0, color);
    }
    let middle = square(Zoom::SIDE * Zoom::SIDE / 2).expand(1.0);
    painter.rect_stroke(middle, 0.0, Stroke::new(3.0, Color32::from_black_alpha(160)), StrokeKind::Outside);
    painter.rect_stroke(middle, 0.0, Stroke::new(1.0, Color32::WHITE), StrokeKind::Outside);
}

/// Marks the pinned texels in the picture, which is in this area, below all panels. Several of them have their numbers.
pub(crate) fn mark(ctx: &Context, area: Rect, found: &Inspected, magnified: &Magnified) {
    let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(area);
    // A magnified texel may be larger than the usual circle.
    let texel = if magnified.size < 1.0 { magnified.texel(area).max_elem() } else { 0.0 };
    let radius = (texel * 0.75).clamp(9.0, 400.0);
    for Pinned { number, texel } in &found.pins {
        let Some(Texel { at, .. }) = texel else { continue };
        let center = magnified.point(area, at.map(|place| f64::from(place) + 0.5), found.extent);
        let color = if *number == found.active { Color32::WHITE } else { Color32::from_gray(170) };
        for (width, color) in [(3.5, Color32::from_black_alpha(160)), (1.5, color)] {
            painter.circle_stroke(center, radius, Stroke::new(width, color));
        }
        if found.pins.len() > 1 {
            let at = center + Vec2::splat(radius * 0.75 + 1.0);
            let font = egui::TextStyle::Small.resolve(&ctx.style());
            let text = painter.layout_no_wrap(number.to_string(), font, color);
            painter.rect_filled(Rect::from_min_size(at, text.size()).expand(1.0), 2.0, Color32::from_black_alpha(160));
            painter.galley(at, text, color);
        }
    }
}

fn rows(ui: &mut Ui, table: &Table, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let mut first = table.first;
        let label = ui.label("from element");
        if ui
            .add(DragValue::new(&mut first).clamp_existing_to_range(false).range(0..=table.total.saturating_sub(1)))
            .labelled_by(label.id)
            .changed()
        {
            actions.push(Action::Rows(first));
        }
        ui.weak(format!("of {}", table.total));
        if ui.button("CSV").on_hover_text("Writes the whole buffer to a file").clicked() {
            actions.push(Action::WriteTable);
        }
    });
    for [name, value] in &table.head {
        ui.horizontal(|ui| {
            ui.weak(name);
            ui.monospace(value);
        });
    }
    Grid::new("table").num_columns(table.columns.len() + 1).spacing(COLUMNS).striped(true).show(ui, |ui| {
        ui.weak("#");
        for column in &table.columns {
            ui.weak(column);
        }
        ui.end_row();
        for (index, row) in table.rows.iter().enumerate() {
            ui.weak((table.first + index as u64).to_string());
            for value in row {
                ui.monospace(value);
            }
            ui.end_row();
        }
    });
}
