//! The chart of one view as SVG: time a ray against wrong rays, both logarithmic, the better the further down and left. Exact graphs have
//! no place on a logarithmic axis and stand below it, a line a graph. Dots of one graph on the layouts it ran over hang together.

mod strand;
#[cfg(test)]
mod tests;

use std::fmt::Write;

use raxel_measure::bench::Row;

use super::about::About;
use super::labels::{grouped, stem, view, wrong_ppm};
use strand::{Strand, draw_crossing, draw_lane, slant};

const WIDTH: f64 = 1000.0;
const LEFT: f64 = 146.0;
const RIGHT: f64 = 40.0;
const TOP: f64 = 104.0;
/// Pixels of a tenfold in error.
const DECADE: f64 = 88.0;
/// Right end of the panels.
const EDGE: f64 = WIDTH - RIGHT;
/// Characters of a line at the foot of the page.
const FOOT: usize = 150;

pub(super) const INK: &str = "#1f2933";
pub(super) const SOFT: &str = "#66727f";
pub(super) const GRID: &str = "#e4e8ec";
const FRONT: &str = "#c8452f";

/// A tracer as a dot.
struct Dot<'r> {
    row: &'r Row,
    /// Nanoseconds a ray.
    time: f64,
    /// Wrong of a million rays.
    wrong: f64,
    /// Nothing is both faster and less wrong.
    front: bool,
}

/// Draws the rows of one view; `None` when none was measured and judged.
pub(super) fn draw(rows: &[Row], about: &About) -> Option<String> {
    let (mut own, mut bounced): (Vec<Dot<'_>>, Vec<Dot<'_>>) = (Vec::new(), Vec::new());
    for row in rows {
        let (Ok(measured), Some(wrong)) = (&row.outcome, wrong_ppm(row)) else { continue };
        // A view without a hit has no rays that leave one.
        if measured.rays == 0 {
            continue;
        }
        let dot = Dot { row, time: measured.nanoseconds_a_ray(), wrong, front: false };
        // The rays that leave the hits are other rays, and no match for those of the camera.
        if measured.bounced { bounced.push(dot) } else { own.push(dot) }
    }
    mark_front(&mut own);
    mark_front(&mut bounced);
    let first = own.first().or(bounced.first())?;
    let times = || own.iter().chain(&bounced).map(|dot| dot.time);
    let graphs = graphs(own.iter().chain(&bounced));
    let scale = Scale::of(times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));

    let mut body = String::new();
    let mut y = TOP;
    let wrong: Vec<&Dot<'_>> = own.iter().filter(|dot| dot.wrong > 0.0).collect();
    let mut path = Path::default();
    if !wrong.is_empty() {
        y = scatter(&mut body, &wrong, &graphs, &scale, y, &mut path);
    }
    let exact: Vec<&Dot<'_>> = own.iter().filter(|dot| dot.wrong == 0.0).collect();
    if !exact.is_empty() {
        let title = format!("exact: none of {} rays is wrong", grouped(measured_rays(first)));
        y = lanes(&mut body, &title, &exact, &graphs, &scale, y, &mut path);
    }
    let _ = writeln!(body, "{}", path.draw());
    if !bounced.is_empty() {
        let title = "rays that leave the hits in random directions";
        let dots: Vec<&Dot<'_>> = bounced.iter().collect();
        y = lanes(&mut body, title, &dots, &graphs, &scale, y + 14.0, &mut Path::default());
    }
    let axes = scale.draw(y);
    let height = y + 104.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" width=\"{WIDTH}\" height=\"{height:.0}\" \
         font-family=\"system-ui, 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    let title = format!("Run time against error: {}", view(&first.row.case));
    svg += &text(28.0, 36.0, 19.0, INK, "start", "600", &title);
    svg += &text(28.0, 57.0, 12.0, SOFT, "start", "400", &format!("{}, {}", about.device.name, about.device.driver));
    let legend = WIDTH - RIGHT - 322.0;
    let _ = writeln!(svg, "<circle cx=\"{legend:.1}\" cy=\"53\" r=\"4.5\" fill=\"{FRONT}\"/>");
    svg +=
        &text(legend + 10.0, 57.0, 12.0, SOFT, "start", "400", "on the front: nothing is both faster and less wrong");
    svg += &axes;
    svg += &body;
    let foot = format!("raxel {}, {}: {}", env!("CARGO_PKG_VERSION"), about.date, about.command);
    for (line, y) in foot_lines(&foot).iter().zip([height - 28.0, height - 13.0]) {
        svg += &text(28.0, y, 10.5, SOFT, "start", "400", line);
    }
    svg += "</svg>\n";
    Some(svg)
}

/// Breaks the foot of the page between words into two lines at most; the rest is left out.
pub(super) fn foot_lines(foot: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in foot.split_whitespace() {
        let line = &lines[lines.len() - 1];
        let full = !line.is_empty() && line.chars().count() + word.chars().count() + 3 > FOOT;
        if full && lines.len() == 2 {
            lines[1].push_str(" …");
            break;
        }
        if full {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(if line.is_empty() { "" } else { " " });
            line.push_str(word);
        }
    }
    lines
}

fn measured_rays(dot: &Dot<'_>) -> u64 {
    dot.row.outcome.as_ref().map_or(0, |measured| measured.rays)
}

/// Marks the dots that no other beats in both.
fn mark_front(dots: &mut [Dot<'_>]) {
    dots.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.wrong.total_cmp(&b.wrong)));
    let mut least = f64::INFINITY;
    for dot in dots {
        dot.front = dot.wrong < least;
        least = least.min(dot.wrong);
    }
}

/// The dots of each graph that are about equally wrong, in order of time: those hang together. The most wrong first.
fn alike<'d, 'r>(dots: &[&'d Dot<'r>]) -> Vec<Vec<&'d Dot<'r>>> {
    let mut all: Vec<Vec<&Dot<'_>>> = Vec::new();
    for &dot in dots {
        let hangs = |other: &Dot<'_>| {
            other.row.case.graph == dot.row.case.graph && (other.wrong - dot.wrong).abs() <= 0.15 * other.wrong
        };
        match all.iter_mut().find(|strand| hangs(strand[0])) {
            Some(strand) => strand.push(dot),
            None => all.push(vec![dot]),
        }
    }
    all.sort_by(|a, b| b[0].wrong.total_cmp(&a[0].wrong));
    all
}

/// Every graph once, in order of name.
fn graphs<'d, 'r: 'd>(dots: impl Iterator<Item = &'d Dot<'r>>) -> Vec<&'r str> {
    let mut all: Vec<&str> = dots.map(|dot| dot.row.case.graph.as_str()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Height of the longest name of a layout where it slants.
fn longest(dots: &[&Dot<'_>]) -> f64 {
    dots.iter().map(|dot| slant(dot)).fold(0.0, f64::max)
}

/// The logarithmic axis of time.
struct Scale {
    /// Powers of ten of nanoseconds at the ends.
    low: f64,
    high: f64,
}

impl Scale {
    fn of(least: f64, most: f64) -> Self {
        let (low, high) = (least.log10(), most.log10());
        // Room for a name behind the last dot, and never less than half a tenfold.
        let span = (high - low).max(0.5);
        Self { low: low - 0.06 * span, high: low + 1.1 * span }
    }

    fn x(&self, nanoseconds: f64) -> f64 {
        LEFT + (nanoseconds.log10() - self.low) / (self.high - self.low) * (WIDTH - LEFT - RIGHT)
    }

    /// 1, 2 and 5 times the powers of ten, or only these when they are many.
    #[expect(clippy::cast_possible_truncation, reason = "powers of ten of measured times are few")]
    fn ticks(&self) -> Vec<f64> {
        let steps: &[f64] = if self.high - self.low > 3.2 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        (self.low.floor() as i32..=self.high.ceil() as i32)
            .flat_map(|power| steps.iter().map(move |step| step * 10f64.powi(power)))
            .filter(|tick| (self.low..=self.high).contains(&tick.log10()))
            .collect()
    }

    fn draw(&self, bottom: f64) -> String {
        let mut svg = String::new();
        for tick in self.ticks() {
            let x = self.x(tick);
            let top = TOP - 12.0;
            let _ = writeln!(svg, "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"{GRID}\" stroke-width=\"1\"/>");
            svg += &text(x, bottom + 18.0, 11.0, INK, "middle", "400", &duration(tick));
            svg += &text(x, top - 5.0, 10.5, SOFT, "middle", "400", &rate(tick));
        }
        let middle = f64::midpoint(LEFT, WIDTH - RIGHT);
        svg += &text(middle, bottom + 40.0, 12.0, INK, "middle", "400", "GPU time a ray; above, rays a second");
        svg
    }
}

fn duration(nanoseconds: f64) -> String {
    let (value, unit) = match nanoseconds {
        n if n < 0.95 => (n * 1e3, "ps"),
        n if n < 950.0 => (n, "ns"),
        n => (n / 1e3, "µs"),
    };
    format!("{} {unit}", (value * 100.0).round() / 100.0)
}

fn rate(nanoseconds: f64) -> String {
    let (value, unit) = match 1e9 / nanoseconds {
        r if r >= 0.95e9 => (r / 1e9, "G/s"),
        r if r >= 0.95e6 => (r / 1e6, "M/s"),
        r => (r / 1e3, "k/s"),
    };
    format!("{} {unit}", (value * 100.0).round() / 100.0)
}

/// The front as a stair: for every time the least error that can be had.
#[derive(Default)]
struct Path(Vec<[f64; 2]>);

impl Path {
    fn draw(&self) -> String {
        let mut steps = String::new();
        for (i, [x, y]) in self.0.iter().enumerate() {
            let _ = if i == 0 { write!(steps, "M{x:.1} {y:.1}") } else { write!(steps, "H{x:.1}V{y:.1}") };
        }
        if self.0.len() < 2 {
            return String::new();
        }
        format!("<path d=\"{steps}\" fill=\"none\" stroke=\"{FRONT}\" stroke-width=\"1.5\" stroke-opacity=\"0.55\"/>")
    }
}

/// The size of the error. Gives the end of the panel.
#[expect(
    clippy::cast_possible_truncation,
    reason = "casts of floats saturate, and powers that are not shown are left out"
)]
fn scatter(svg: &mut String, dots: &[&Dot<'_>], graphs: &[&str], scale: &Scale, top: f64, path: &mut Path) -> f64 {
    let least = dots.iter().map(|dot| dot.wrong).fold(f64::INFINITY, f64::min).log10();
    let most = dots.iter().map(|dot| dot.wrong).fold(0.0, f64::max).log10();
    // Few tenfolds are drawn larger; names slant upwards from the uppermost dots, and downwards from the lowest.
    let decade = DECADE.max(240.0 / (most - least).max(1.0));
    let (start, ends) = (top, longest(dots).max(56.0) + 8.0);
    let at = |wrong: f64| start + ends + (most - wrong.log10()) * decade;
    let bottom = at(10f64.powf(least)) + ends;
    let shown = |power: &i32| (top..=bottom).contains(&at(10f64.powi(*power)));
    for power in (least.floor() as i32 - 1..=most.ceil() as i32 + 1).filter(shown) {
        let y = at(10f64.powi(power));
        let _ = writeln!(svg, "<path d=\"M{LEFT} {y:.1}H{:.1}\" stroke=\"{GRID}\"/>", WIDTH - RIGHT);
        svg.push_str(&text(LEFT - 10.0, y + 4.0, 11.0, INK, "end", "400", &parts(power)));
    }
    let middle = f64::midpoint(top, bottom);
    let _ = writeln!(
        svg,
        "<text transform=\"translate(24 {middle:.1}) rotate(-90)\" font-size=\"12\" fill=\"{INK}\" text-anchor=\"middle\">wrong rays</text>"
    );
    let strands: Vec<Strand<'_, '_>> =
        alike(dots).into_iter().map(|dots| Strand::new(dots, scale, |dot| at(dot.wrong), graphs)).collect();
    draw_crossing(svg, &strands, [top, bottom]);
    path.0.extend(dots.iter().filter(|dot| dot.front).map(|dot| [scale.x(dot.time), at(dot.wrong)]));
    bottom
}

/// Shares of all rays by their power of ten of a millionth.
fn parts(power: i32) -> String {
    match power {
        3.. => format!("{} %", 10f64.powi(power - 4)),
        0.. => format!("{} ppm", 10f64.powi(power)),
        _ => format!("{} ppb", 10f64.powi(power + 3)),
    }
}

/// One line for each graph. Gives the end of the panel.
fn lanes(
    svg: &mut String,
    title: &str,
    dots: &[&Dot<'_>],
    graphs: &[&str],
    scale: &Scale,
    top: f64,
    path: &mut Path,
) -> f64 {
    let mut all: Vec<Vec<&Dot<'_>>> = Vec::new();
    for &dot in dots {
        match all.iter_mut().find(|lane| lane[0].row.case.graph == dot.row.case.graph) {
            Some(lane) => lane.push(dot),
            None => all.push(vec![dot]),
        }
    }
    // A line of dots has the names above it.
    let lane_height = longest(dots) + 10.0;
    let bottom = top + 28.0 + lane_height * all.len() as f64;
    let _ = writeln!(
        svg,
        "<rect x=\"{LEFT}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#f3f6f4\" fill-opacity=\"0.75\"/>",
        EDGE - LEFT,
        bottom - top
    );
    svg.push_str(&text(LEFT + 8.0, top + 16.0, 11.0, SOFT, "start", "600", title));
    for (i, lane) in all.iter().enumerate() {
        let y = top + 16.0 + lane_height * (i + 1) as f64;
        let name = stem(&lane[0].row.case.graph);
        let weight = if lane.iter().any(|dot| dot.front) { "600" } else { "400" };
        svg.push_str(&text(LEFT - 10.0, y + 4.0, 12.0, INK, "end", weight, name));
        draw_lane(svg, &Strand::new(lane.clone(), scale, |_| y, graphs));
        path.0.extend(lane.iter().filter(|dot| dot.front).map(|dot| [scale.x(dot.time), y]));
    }
    bottom
}

pub(super) fn text(x: f64, y: f64, size: f64, color: &str, anchor: &str, weight: &str, content: &str) -> String {
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{color}\" text-anchor=\"{anchor}\" font-weight=\"{weight}\">{}</text>\n",
        escaped(content)
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
