//! The chart of a scene as SVG: GPU time since the start against error, both logarithmic, a line a system with a band of its standard error.
//! Its bias, below which it cannot come, is dashed; the path tracer's own line goes down with one over the time. Rings are pictures of a
//! moving camera, at the time of a frame.

use std::fmt::Write;

use raxel_measure::light::Point;

use super::super::about::About;
use super::super::chart::{GRID, INK, SOFT, foot_lines, text};
use super::Judgement;

const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 640.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 170.0;
const TOP: f64 = 84.0;
const BOTTOM: f64 = 96.0;
/// Consecutive lines differ by hue, then by lightness.
const COLORS: [&str; 10] =
    ["#1f2933", "#c8452f", "#2f6db3", "#3b8a4a", "#8a4fa8", "#c78a1e", "#1d8f94", "#b03a78", "#6b7d1f", "#5a63c7"];
/// Pixels between the names at the right edge.
const NAME: f64 = 14.0;

/// A logarithmic axis.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64> + Clone, from: f64, to: f64) -> Self {
        let logs = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
        let low = logs.clone().fold(f64::INFINITY, f64::min);
        let high = logs.fold(f64::NEG_INFINITY, f64::max);
        Self { low: low - 0.1, high: high.max(low + 0.5) + 0.1, from, to }
    }

    fn at(&self, value: f64) -> f64 {
        let log = value.max(1e-300).log10().clamp(self.low, self.high);
        self.from + (log - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    #[expect(clippy::cast_possible_truncation, reason = "powers of ten of floats are within ±324")]
    fn powers(&self) -> impl Iterator<Item = f64> + use<> {
        (self.low.ceil() as i32..=self.high.floor() as i32).map(|power| 10f64.powi(power))
    }
}

/// Draws a scene; `None` when nothing in it has an error above 0.
pub(super) fn draw(judgement: &Judgement, about: &About) -> Option<String> {
    let outcomes: Vec<_> =
        (judgement.rows.iter()).filter_map(|row| Some((&row.system, row.outcome.as_ref().ok()?))).collect();
    let wrong = |point: &&Point| point.judged.error > 0.0 && point.ms > 0.0;
    let points = || outcomes.iter().flat_map(|(_, outcome)| &outcome.still).filter(wrong);
    points().next()?;
    let pans = || outcomes.iter().filter_map(|(_, outcome)| outcome.pan.as_ref());
    let times = points().map(|point| point.ms).chain(pans().map(|pan| pan.frame_ms));
    let errors = points().map(|point| point.judged.error).chain(pans().map(|pan| pan.judged.error));
    let x = Axis::of(times, LEFT, WIDTH - RIGHT);
    let y = Axis::of(errors, HEIGHT - BOTTOM, TOP);

    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"system-ui, 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    let [width, height] = judgement.references.about.size;
    let title = format!("Time against error: {}, {width} × {height}", judgement.scene.name);
    svg += &text(28.0, 34.0, 19.0, INK, "start", "600", &title);
    let reference = &judgement.references.about;
    let subtitle =
        format!("{}, {}; reference: 2 × {} paths a pixel", about.device.name, about.device.driver, reference.paths);
    svg += &text(28.0, 55.0, 12.0, SOFT, "start", "400", &subtitle);
    axes(&mut svg, &x, &y);
    if let Some(brute) = judgement.brute_force() {
        // From the left edge, or where it comes in at the top, down to the right.
        let [low, high] = [x.low, x.high].map(|log| 10f64.powf(log));
        let from = low.max(brute / 10f64.powf(y.high));
        let to = high.min(brute / 10f64.powf(y.low));
        let line = [from, to].map(|ms| format!("{:.1} {:.1}", x.at(ms), y.at(brute / ms)));
        let _ = writeln!(
            svg,
            "<path d=\"M{}L{}\" stroke=\"{SOFT}\" stroke-width=\"1\" stroke-dasharray=\"1 4\"/>",
            line[0], line[1]
        );
    }
    let mut names = Vec::new();
    for (i, (system, outcome)) in outcomes.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let line: Vec<&Point> = outcome.still.iter().filter(wrong).collect();
        system_line(&mut svg, &line, color, &x, &y);
        if let Some(pan) = outcome.pan.as_ref().filter(|pan| pan.judged.error > 0.0) {
            let (cx, cy) = (x.at(pan.frame_ms), y.at(pan.judged.error));
            let _ = writeln!(
                svg,
                "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"5.5\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>"
            );
        }
        if let Some(last) = line.last() {
            names.push((y.at(last.judged.error), color, system.as_str()));
        }
    }
    label(&mut svg, names);
    let foot = format!("raxel {}, {}: {}", env!("CARGO_PKG_VERSION"), about.date, about.command);
    for (line, y) in foot_lines(&foot).iter().zip([HEIGHT - 26.0, HEIGHT - 12.0]) {
        svg += &text(28.0, y, 10.5, SOFT, "start", "400", line);
    }
    svg += "</svg>\n";
    Some(svg)
}

fn axes(svg: &mut String, x: &Axis, y: &Axis) {
    for ms in x.powers() {
        let at = x.at(ms);
        let _ = writeln!(svg, "<path d=\"M{at:.1} {TOP}V{:.1}\" stroke=\"{GRID}\"/>", HEIGHT - BOTTOM);
        svg.push_str(&text(at, HEIGHT - BOTTOM + 17.0, 11.0, INK, "middle", "400", &format!("{ms} ms")));
    }
    for error in y.powers() {
        let at = y.at(error);
        let _ = writeln!(svg, "<path d=\"M{LEFT} {at:.1}H{:.1}\" stroke=\"{GRID}\"/>", WIDTH - RIGHT);
        svg.push_str(&text(LEFT - 8.0, at + 4.0, 11.0, INK, "end", "400", &format!("{error:e}")));
    }
    let below =
        "GPU time since the start; rings: moving camera, GPU time of a frame; dashed: bias²; dotted: one over the time";
    svg.push_str(&text(LEFT, HEIGHT - BOTTOM + 38.0, 12.0, INK, "start", "400", below));
    svg.push_str(&text(LEFT, TOP - 10.0, 12.0, INK, "start", "400", "relMSE"));
}

/// The line of a system with its band, and its bias as far as it is more than its standard error.
fn system_line(svg: &mut String, line: &[&Point], color: &str, x: &Axis, y: &Axis) {
    let place = |point: &&Point| format!("{:.1} {:.1}", x.at(point.ms), y.at(point.judged.error));
    let path: Vec<String> = line.iter().map(place).collect();
    let edge = |sign: f64| {
        move |point: &&Point| {
            let error = point.judged.error + sign * 1.96 * point.judged.error_se;
            format!("{:.1} {:.1}", x.at(point.ms), y.at(error.max(point.judged.error * 0.01)))
        }
    };
    let band: Vec<String> = line.iter().map(edge(1.0)).chain(line.iter().rev().map(edge(-1.0))).collect();
    if line.iter().all(|point| point.judged.error_se.is_finite()) && line.len() > 1 {
        let _ = writeln!(svg, "<path d=\"M{}Z\" fill=\"{color}\" fill-opacity=\"0.12\"/>", band.join("L"));
    }
    let _ = writeln!(svg, "<path d=\"M{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>", path.join("L"));
    for point in line {
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.5\" fill=\"{color}\"/>",
            x.at(point.ms),
            y.at(point.judged.error)
        );
    }
    if let Some(last) = line.last().filter(|last| last.judged.bias2 > 2.0 * last.judged.bias2_se) {
        let at = y.at(last.judged.bias2);
        let _ = writeln!(
            svg,
            "<path d=\"M{:.1} {at:.1}H{:.1}\" stroke=\"{color}\" stroke-width=\"1.2\" stroke-dasharray=\"6 4\"/>",
            x.at(line[0].ms),
            WIDTH - RIGHT
        );
    }
}

/// Names at the right edge, pushed apart where lines end close to each other.
fn label(svg: &mut String, mut names: Vec<(f64, &str, &str)>) {
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = f64::NEG_INFINITY;
    for (at, color, name) in names {
        let place = at.max(free);
        free = place + NAME;
        svg.push_str(&text(WIDTH - RIGHT + 10.0, place + 4.0, 12.0, color, "start", "600", name));
    }
}
