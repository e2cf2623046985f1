//! The demo: where it is, its tracks with their keys, scrubbing and re-timing.

use egui::{Align2, Color32, CursorIcon, Id, Rect, Sense, Stroke, Ui, UiBuilder, WidgetInfo, WidgetType, pos2, vec2};

use crate::action::Action;
use crate::docks::caption;
use crate::hint::Hint as _;
use crate::shape_cache::ShapeCache;
use crate::view::{Lane, Timeline, Track};

/// Points of a track's row, of the ruler above the rows, and of the column with the names.
const ROW: f32 = 18.0;
const RULER: f32 = 16.0;
const NAMES: f32 = 120.0;

/// Half the size of a key, in points.
const KEY: f32 = 4.5;

/// Keys of a track keep this distance, in seconds. It is also what times are rounded to.
const STEP: f64 = 0.01;

/// A key on its way to another time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moving {
    lane: Lane,
    key: usize,
    to: f64,
    /// Seconds from the place where it was taken to its time.
    taken: f64,
    /// A dropped key that the file does not have yet: the old times of its track, and the time of the drop.
    dropped: Option<(Vec<f64>, f64)>,
}

/// A dropped key returns to its old time if the file does not change for this number of seconds.
const PATIENCE: f64 = 2.0;

/// The state of the panel from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    /// A key on its way.
    moving: Option<Moving>,
    /// The tracks: time goes on over them.
    tracks: ShapeCache,
}

impl Memory {
    /// Whether a key is on its way, or was dropped and not written yet.
    pub(crate) fn moves(&self) -> bool {
        self.moving.is_some()
    }
}

/// Draws the panel. `whole`: every key is a widget, in every frame.
pub(crate) fn show(
    ui: &mut Ui,
    timeline: &Timeline,
    paused: bool,
    (memory, whole): (&mut Memory, bool),
    actions: &mut Vec<Action>,
) {
    ui.horizontal_wrapped(|ui| {
        if ui.button(if paused { "Play demo" } else { "Pause demo" }).clicked() {
            actions.push(Action::Pause);
        }
        let mut looped = timeline.looped;
        if ui.checkbox(&mut looped, "loop").changed() {
            actions.push(Action::Loop(looped));
        }
        let mut time = timeline.time;
        let label = ui.label("seconds");
        let drag = egui::DragValue::new(&mut time)
            .range(0.0..=timeline.duration)
            .clamp_existing_to_range(false)
            .speed(0.02)
            .fixed_decimals(2);
        if ui.add(drag).labelled_by(label.id).changed() {
            actions.push(Action::Seek(time));
        }
        ui.weak(format!("of {:.2}, {}", timeline.duration, timeline.name));
        let hint = "Writes the camera into the demo's file at this time, in place of a key that is there; K";
        if ui.button("Record camera").on_hover_text(hint).clicked() {
            actions.push(Action::RecordKey);
        }
        if !timeline.drives {
            ui.label("you have the camera");
            if ui.button("Give back").on_hover_text("The demo drives again; the G key").clicked() {
                actions.push(Action::HandBack);
            }
        }
    });
    settle(&mut memory.moving, timeline, ui.input(|input| input.time));
    strip(ui, timeline, (memory, whole), actions);
}

/// Forgets a dropped key when the file has it, or did not get it.
fn settle(moving: &mut Option<Moving>, timeline: &Timeline, now: f64) {
    let Some(Moving { lane, dropped: Some((before, at)), .. }) = moving else { return };
    let track = timeline.tracks.iter().find(|track| track.lane == *lane);
    if track.is_none_or(|track| track.keys != *before) || now - *at > PATIENCE {
        *moving = None;
    }
}

/// From seconds to points and back.
#[derive(Clone, Copy)]
struct Scale {
    left: f32,
    right: f32,
    duration: f64,
}

impl Scale {
    #[expect(clippy::cast_possible_truncation, reason = "egui counts points in 32-bit floats")]
    fn x(self, seconds: f64) -> f32 {
        self.left + (seconds / self.duration).clamp(0.0, 1.0) as f32 * (self.right - self.left)
    }

    fn seconds(self, x: f32) -> f64 {
        f64::from((x - self.left) / (self.right - self.left).max(1.0)).clamp(0.0, 1.0) * self.duration
    }
}

/// The ruler, and a row for each track with its keys. A click or a drag beside the keys puts the demo there.
fn strip(ui: &mut Ui, timeline: &Timeline, (memory, whole): (&mut Memory, bool), actions: &mut Vec<Action>) {
    let rows = timeline.tracks.len() as f32;
    let size = vec2(ui.available_width().max(NAMES + 80.0), RULER + rows * ROW + 4.0);
    let (response, painter) = ui.allocate_painter(size, Sense::click_and_drag());
    let area = response.rect;
    let duration = timeline.duration.max(1e-6);
    let scale = Scale { left: area.left() + NAMES, right: area.right() - 10.0, duration };
    let Memory { moving, tracks: kept } = memory;
    let mut inside = ui.new_child(UiBuilder::new().max_rect(area));
    if whole || moving.is_some() {
        tracks(&inside, (area, scale), timeline, moving, actions);
    } else {
        let content = (timeline.tracks.as_slice(), &timeline.duration);
        kept.show(&mut inside, &content, |ui| tracks(ui, (area, scale), timeline, moving, actions));
    }
    let playhead = if timeline.drives { Color32::WHITE } else { Color32::from_gray(140) };
    painter.vline(scale.x(timeline.time), area.y_range(), Stroke::new(1.5, playhead));
    if (response.dragged() || response.clicked())
        && let Some(pointer) = response.interact_pointer_pos()
    {
        actions.push(Action::Seek(scale.seconds(pointer.x)));
    }
}

/// All but the time.
fn tracks(
    ui: &Ui,
    (area, scale): (Rect, Scale),
    timeline: &Timeline,
    moving: &mut Option<Moving>,
    actions: &mut Vec<Action>,
) {
    ui.painter().rect_filled(area, 2.0, Color32::from_black_alpha(120));
    ruler(ui, area, scale);
    for (row, track) in timeline.tracks.iter().enumerate() {
        let y = area.top() + RULER + (row as f32 + 0.5) * ROW;
        if !ui.clip_rect().y_range().expand(ROW).contains(y) {
            continue;
        }
        caption(ui, pos2(area.left() + 4.0, y), Align2::LEFT_CENTER, &track.name);
        ui.painter().hline(scale.left..=scale.right, y, Stroke::new(1.0, Color32::from_gray(60)));
        for key in 0..track.keys.len() {
            handle(ui, (scale, y), (timeline, track, key), moving, actions);
        }
    }
}

/// Marks at round seconds, not closer than their numbers need.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "there are at most as many marks as have room"
)]
fn ruler(ui: &Ui, area: Rect, scale: Scale) {
    let fits = f64::from((scale.right - scale.left) / 46.0).max(1.0);
    let steps = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0, 600.0, 3600.0];
    let step = steps.into_iter().find(|step| scale.duration / step <= fits).unwrap_or(scale.duration);
    let marks = (scale.duration / step + 1e-9).floor() as u32;
    for mark in 0..=marks {
        let seconds = f64::from(mark) * step;
        let x = scale.x(seconds);
        ui.painter().vline(x, area.top()..=area.top() + 4.0, Stroke::new(1.0, Color32::from_gray(120)));
        let decimals = usize::from(step < 1.0);
        caption(ui, pos2(x, area.top() + 3.0), Align2::CENTER_TOP, &format!("{seconds:.decimals$}"));
    }
}

/// A key: dragging it moves it in time, a click goes to its time, the right button offers more.
fn handle(
    ui: &Ui,
    (scale, y): (Scale, f32),
    (timeline, track, key): (&Timeline, &Track, usize),
    moving: &mut Option<Moving>,
    actions: &mut Vec<Action>,
) {
    let time = track.keys[key];
    let dragged = moving.as_ref().filter(|moving| moving.lane == track.lane && moving.key == key);
    let at = dragged.map_or(time, |moved| moved.to);
    let mut rect = Rect::from_center_size(pos2(scale.x(at), y), vec2(2.5 * KEY, ROW - 2.0));
    let movable = track.lane.movable();
    let sense = if movable { Sense::click_and_drag() } else { Sense::click() };
    let (lasts, x) = (track.lasts(key), rect.center().x);
    if lasts > 0.0 {
        let bar = Rect::from_x_y_ranges(x..=scale.x(at + lasts).max(x), y - 3.0..=y + 3.0);
        ui.painter().rect_filled(bar, 2.0, Color32::from_rgb(110, 95, 45));
        // A bar can be taken at any place of it.
        rect.max.x = rect.max.x.max(bar.max.x);
    }
    let response = ui.interact(rect, Id::new(("key", &track.name, key)), sense);
    let name = || format!("{} key {} at {time:.2} s", track.name, key + 1);
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, name()));
    let held = response.hovered() || response.dragged();
    let own = if movable { Color32::from_rgb(235, 200, 90) } else { Color32::from_rgb(120, 200, 140) };
    let color = if held { Color32::WHITE } else { own };
    let r = KEY;
    let diamond = vec![pos2(x, y - r), pos2(x + r, y), pos2(x, y + r), pos2(x - r, y)];
    ui.painter().add(egui::Shape::convex_polygon(diamond, color, Stroke::NONE));
    if response.dragged()
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let taken = dragged.filter(|moved| moved.dropped.is_none()).map_or_else(
            || at - scale.seconds(ui.input(|input| input.pointer.press_origin()).unwrap_or(pointer).x),
            |moved| moved.taken,
        );
        let to = between(track, key, scale.seconds(pointer.x) + taken, timeline.duration);
        caption(ui, pos2(x, y - r - 1.0), Align2::CENTER_BOTTOM, &format!("{to:.2} s"));
        *moving = Some(Moving { lane: track.lane.clone(), key, to, taken, dropped: None });
    } else if response.drag_stopped() {
        if let Some(moved) = moving.as_mut().filter(|moved| (moved.to - time).abs() > STEP / 2.0) {
            moved.dropped = Some((track.keys.clone(), ui.input(|input| input.time)));
            actions.push(Action::MoveKey { lane: track.lane.clone(), key, to: moved.to });
        } else {
            *moving = None;
        }
    } else if response.clicked() {
        let beside = response.interact_pointer_pos().filter(|pointer| pointer.x > x + KEY);
        actions.push(Action::Seek(beside.map_or(time, |pointer| scale.seconds(pointer.x))));
    }
    if !movable {
        response.hint(name);
        return;
    }
    let response = response.on_hover_cursor(CursorIcon::ResizeHorizontal);
    let hint = || format!("{}\nDrag it to another time; raxel writes the file when you let go", name());
    response.hint(hint).context_menu(|ui| {
        if ui.button("Delete key").clicked() {
            actions.push(Action::DeleteKey { lane: track.lane.clone(), key });
            ui.close();
        }
    });
}

/// The time that a key may have: in the demo, and between its neighbours.
fn between(track: &Track, key: usize, wanted: f64, duration: f64) -> f64 {
    let round = |seconds: f64| (seconds / STEP).round() * STEP;
    let low = key.checked_sub(1).map_or(0.0, |before| track.keys[before] + STEP);
    let end = duration - track.lasts(key);
    let high = track.keys.get(key + 1).map_or(end, |after| (after - STEP).min(end));
    if low > high { track.keys[key] } else { round(wanted).clamp(low, high) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_stay_in_order_and_in_the_demo() {
        let track = Track::new(Lane::Camera, "camera", vec![0.0, 2.0, 2.005, 5.0]);
        let milliseconds = |key, wanted| (between(&track, key, wanted, 6.0) * 1000.0).round() as i64;
        assert_eq!([milliseconds(0, -1.0), milliseconds(0, 1.2345), milliseconds(0, 9.0)], [0, 1230, 1990]);
        assert_eq!([milliseconds(3, 0.0), milliseconds(3, 9.0)], [2015, 6000]);
        // Between two that are closer than a step there is no room: it stays.
        let close = Track { keys: vec![1.0, 1.005, 1.01], ..track.clone() };
        assert_eq!(between(&close, 1, 1.1, 6.0).to_bits(), 1.005_f64.to_bits());
        // A bar ends with the demo at the latest.
        let caption = Track { lasting: vec![1.5], ..Track::new(Lane::Captions, "captions", vec![1.0]) };
        assert!((between(&caption, 0, 6.0, 6.0) - 4.5).abs() < 1e-9);
    }
}
