//! The frame: a plot of its times, memory, scale, rate.

use egui::{Align2, Color32, DragValue, Grid, Sense, Shape, Slider, Stroke, Ui, pos2, vec2};
use raxel_diagnostics::names::{counted, grouped};

use crate::action::Action;
use crate::docks::caption;
use crate::samples::Samples;
use crate::shape_cache::Content;
use crate::view::{Frame, WorldExtent, WorldStatistics};

const GPU: Color32 = Color32::from_rgb(120, 200, 120);
const CPU: Color32 = Color32::from_rgb(120, 170, 250);
const INTERVAL: Color32 = Color32::from_rgb(130, 130, 130);

/// All that the panel shows.
pub(crate) fn content<'v>(frame: &'v Frame<'_>) -> impl Content + use<'v> {
    let Frame { interval, cpu, gpu, memory, saved, scale, scales, output, fps_cap, device, ran, world } = frame;
    let samples = |samples: Option<&'v Samples>| samples.map_or(&[][..], std::slice::from_ref);
    let times = (samples(*interval), samples(*cpu), samples(*gpu));
    (times, (memory, saved, ran, device.as_str()), (scale, scales, output, fps_cap), world)
}

/// Draws the panel.
pub(crate) fn show(ui: &mut Ui, frame: &Frame<'_>, actions: &mut Vec<Action>) {
    ui.horizontal_top(|ui| {
        ui.vertical(|ui| {
            ui.set_width(250.0);
            numbers(ui, frame);
            settings(ui, frame, actions);
        });
        ui.vertical(|ui| {
            ui.set_width(265.0);
            world(ui, &frame.world);
        });
        plot(ui, frame);
    });
}

fn numbers(ui: &mut Ui, frame: &Frame<'_>) {
    Grid::new("times").num_columns(3).show(ui, |ui| {
        ui.weak("ms");
        ui.weak("median");
        ui.weak("p95");
        ui.end_row();
        for (name, color, samples) in
            [("GPU span", GPU, frame.gpu), ("CPU", CPU, frame.cpu), ("frame to frame", INTERVAL, frame.interval)]
        {
            ui.colored_label(color, name);
            ui.monospace(milliseconds(samples.and_then(Samples::median)));
            ui.monospace(milliseconds(samples.and_then(Samples::p95)));
            ui.end_row();
        }
    });
    let [dispatched, skipped, idle] = frame.ran;
    ui.weak(format!("{dispatched} dispatched, {skipped} unchanged, {idle} not due or off"));
    ui.weak(format!("{}, {} saved by sharing", bytes(frame.memory), bytes(frame.saved)));
    ui.weak(&frame.device);
}

/// The size of the world, its memory, and its changes.
fn world(ui: &mut Ui, world: &WorldStatistics) {
    ui.weak("world");
    let mut voxels = 0;
    match &world.extent {
        WorldExtent::Whole { chunks, voxels: solid, lamps } => {
            voxels = *solid;
            ui.label(format!("{} voxels in {}", grouped(*solid), counted(*chunks as u64, "chunk")));
            ui.label(counted(*lamps, "emissive voxel"));
        }
        WorldExtent::Around(loading) => {
            let [there, wanted] = loading.there;
            let [device, pool] = loading.device.map(bytes);
            ui.label(format!("{there} of {wanted} chunks, {device} of {pool}"));
            let ([host, most], [found, made]) = (loading.host.map(bytes), loading.found_made);
            ui.label(format!("{host} of {most} packed, {found} found, {made} made"));
            ui.label(format!("{}, {}", counted(loading.publications, "publication"), counted(loading.lamps, "lamp")));
        }
    }
    for (name, size) in &world.sources {
        let each = if voxels > 0 && !name.ends_with(".lights") {
            format!(", {:.2} bytes a voxel", *size as f64 / voxels as f64)
        } else {
            String::new()
        };
        ui.label(format!("{name} {}{each}", bytes(*size)));
    }
    let [undo, redo] = world.edits;
    ui.label(format!("{} to undo, {redo} to redo", counted(undo as u64, "edit")));
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is an integer in 0…1000")]
fn settings(ui: &mut Ui, frame: &Frame<'_>, actions: &mut Vec<Action>) {
    let mut scale = frame.scale;
    let [low, high] = frame.scales;
    let slider = Slider::new(&mut scale, low..=high).logarithmic(true).max_decimals(3).text("scale");
    let hint = format!("{} × {} pixels", frame.output[0], frame.output[1]);
    // Targets are created again for another size: not while the handle moves.
    let response = ui.add(slider.update_while_editing(false)).on_hover_text(hint);
    if response.drag_stopped() || (response.changed() && !response.dragged()) {
        actions.push(Action::Scale(scale));
    }
    ui.horizontal(|ui| {
        let mut cap = frame.fps_cap.unwrap_or(0);
        let drag = DragValue::new(&mut cap).range(0..=1000).custom_formatter(|value, _| match value as u32 {
            0 => "none".to_owned(),
            fps => format!("{fps} a second"),
        });
        let label = ui.label("frames at most");
        if ui.add(drag).labelled_by(label.id).changed() {
            actions.push(Action::FpsCap(Some(cap).filter(|&cap| cap > 0)));
        }
    });
}

/// Times from the oldest at the left to the newest at the right, on a scale that ends above the largest p95.
fn plot(ui: &mut Ui, frame: &Frame<'_>) {
    let size = vec2(ui.available_width().max(120.0), ui.available_height().max(60.0));
    let (response, painter) = ui.allocate_painter(size, Sense::hover());
    let area = response.rect;
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(120));
    let lines = [(frame.interval, INTERVAL), (frame.gpu, GPU), (frame.cpu, CPU)];
    let most = lines.iter().filter_map(|(samples, _)| samples.and_then(Samples::p95)).fold(0.0_f32, f32::max);
    let top = nice(most * 1.2);
    for (samples, color) in lines {
        let Some(samples) = samples.filter(|samples| samples.iter().len() > 1) else { continue };
        let count = samples.iter().len();
        let point = |(index, value): (usize, f32)| {
            let x = area.right() - (count - 1 - index) as f32 / 239.0 * area.width();
            pos2(x, area.bottom() - (value / top).min(1.0) * area.height())
        };
        painter.add(Shape::line(samples.iter().enumerate().map(point).collect(), Stroke::new(1.0, color)));
    }
    caption(ui, area.left_top() + vec2(3.0, 1.0), Align2::LEFT_TOP, &format!("{top} ms"));
    caption(ui, area.left_bottom() + vec2(3.0, -1.0), Align2::LEFT_BOTTOM, "0");
}

/// The next number of the form 1, 2 or 5 times a power of ten.
fn nice(value: f32) -> f32 {
    if value <= 0.0 || !value.is_finite() {
        return 1.0;
    }
    let power = 10_f32.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|&step| step >= value).unwrap_or(value)
}

/// Five digits at most, three of them behind the point.
pub(crate) fn milliseconds(value: Option<f32>) -> String {
    let Some(value) = value else { return "–".to_owned() };
    let decimals = match value {
        ..10.0 => 3,
        10.0..100.0 => 2,
        100.0..1000.0 => 1,
        _ => 0,
    };
    format!("{value:.decimals$}")
}

/// `12.5 MiB`.
pub(crate) fn bytes(count: u64) -> String {
    match count {
        0..1024 => format!("{count} B"),
        1024..1_048_576 => format!("{:.1} KiB", count as f64 / 1024.0),
        1_048_576..1_073_741_824 => format!("{:.1} MiB", count as f64 / 1_048_576.0),
        _ => format!("{:.2} GiB", count as f64 / 1_073_741_824.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_ends_at_a_round_number() {
        let ends = |value| format!("{}", nice(value));
        assert_eq!([0.0, 0.3, 1.0, 1.01, 4.9, 7.0, 120.0].map(ends), ["1", "0.5", "1", "2", "5", "10", "200"]);
    }

    #[test]
    fn times_have_as_many_digits_as_one_reads() {
        let said = |value| milliseconds(Some(value));
        assert_eq!([0.0123, 9.5, 23.2004, 105.314, 1467.419].map(said), ["0.012", "9.500", "23.20", "105.3", "1467"]);
    }

    #[test]
    fn bytes_have_units() {
        assert_eq!([3, 1536, 5 << 20, 3 << 30].map(bytes), ["3 B", "1.5 KiB", "5.0 MiB", "3.00 GiB"]);
    }
}
