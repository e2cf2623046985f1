//! Dots of one graph on a thread, with names that keep out of each other's way.

use std::fmt::Write;

use super::super::labels::{stem, three, tracer};
use super::{Dot, FRONT, INK, LEFT, Scale, WIDTH, duration, escaped, text};

/// A box: left, top, right, bottom.
type Place = [f64; 4];

/// Pixels between names that slant.
const APART: f64 = 13.0;
/// Height of names that slant.
const SLANT: f64 = 50.0;

/// Colours that tell graphs apart where their threads cross; none is the red of the front.
const COLORS: [&str; 8] = ["#4d7ea8", "#7d6aa8", "#3f9183", "#a8792c", "#93577a", "#66873a", "#5c6b7a", "#8a5a44"];

/// Dots of one graph, in order of time.
pub(super) struct Strand<'d, 'r> {
    dots: Vec<&'d Dot<'r>>,
    points: Vec<[f64; 2]>,
    color: &'static str,
}

impl<'d, 'r> Strand<'d, 'r> {
    /// `y` says how high a dot stands; `graphs` are all there are, in order of name, for their colours.
    pub fn new(dots: Vec<&'d Dot<'r>>, scale: &Scale, y: impl Fn(&Dot<'_>) -> f64, graphs: &[&str]) -> Self {
        let points = dots.iter().map(|dot| [scale.x(dot.time), y(dot)]).collect();
        let graph = dots.first().map_or("", |dot| dot.row.case.graph.as_str());
        let number = graphs.iter().position(|known| *known == graph).unwrap_or(0);
        Self { dots, points, color: COLORS[number % COLORS.len()] }
    }

    /// Around the dots, with a margin.
    fn band(&self, margin: f64) -> Place {
        let empty = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        self.points.iter().fold(empty, |[left, top, right, bottom], [x, y]| {
            [left.min(x - margin), top.min(y - margin), right.max(x + margin), bottom.max(y + margin)]
        })
    }

    /// Thread and dots.
    fn draw(&self, svg: &mut String) {
        let line: Vec<String> = self.points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-opacity=\"0.4\"/>",
            line.join(" "),
            self.color
        );
        for (dot, [x, y]) in self.dots.iter().zip(&self.points) {
            let (radius, fill) = if dot.front { (5.0, FRONT) } else { (4.0, self.color) };
            let about = escaped(&about(dot));
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{fill}\" stroke=\"#ffffff\"><title>{about}</title></circle>"
            );
        }
    }

    /// The names of the layouts, slanting up or down from their dots.
    fn layouts(&self, svg: &mut String, up: bool) {
        let sign = if up { -1.0 } else { 1.0 };
        let mut free = f64::NEG_INFINITY;
        for (dot, [x, y]) in self.dots.iter().zip(&self.points) {
            let at = x.max(free);
            free = at + APART;
            let from = y + sign * 6.0;
            if at - x > 1.0 {
                let _ = writeln!(svg, "<path d=\"M{x:.1} {y:.1}L{at:.1} {from:.1}\" stroke=\"#c3ced8\"/>");
            }
            let (angle, down) = if up { (-45, -1.5) } else { (45, 5.5) };
            let (color, weight) = if dot.front { (FRONT, 600) } else { (INK, 400) };
            let _ = writeln!(
                svg,
                "<text transform=\"translate({:.1} {:.1}) rotate({angle})\" font-size=\"10.5\" fill=\"{color}\" \
                 font-weight=\"{weight}\">{}</text>",
                at + 1.0,
                from + down,
                escaped(dot.row.case.layout.unwrap_or("no world"))
            );
        }
    }
}

/// Draws a strand that has a line of its own, where nothing is in its way.
pub(super) fn draw_lane(svg: &mut String, strand: &Strand<'_, '_>) {
    strand.draw(svg);
    strand.layouts(svg, true);
}

/// Draws strands that may cross. Where there is no room for the names of all layouts, the fastest is named with the graph.
pub(super) fn draw_crossing(svg: &mut String, strands: &[Strand<'_, '_>], [top, bottom]: [f64; 2]) {
    let mut taken: Vec<Place> = strands.iter().map(|strand| strand.band(6.0)).collect();
    for strand in strands {
        strand.draw(svg);
    }
    for (own, strand) in strands.iter().enumerate() {
        let (Some(first), Some(last)) = (strand.points.first(), strand.points.last()) else { continue };
        let band = strand.band(2.0);
        let free = |place: &Place, taken: &[Place]| {
            let others = taken.iter().enumerate().filter(|(other, _)| *other != own);
            place[0] > LEFT
                && place[2] < WIDTH - 6.0
                && place[1] > top
                && place[3] < bottom
                && !others.into_iter().any(|(_, other)| overlap(other, place))
        };
        // The last name reaches beyond its dot.
        let above = [band[0] - 2.0, band[1] - SLANT, (band[2] + 40.0).min(WIDTH - 7.0), band[1]];
        let below = [above[0], band[3], above[2], band[3] + SLANT];
        let several = strand.points.len() > 1;
        let up = several
            .then(|| [(true, above), (false, below)].into_iter().find(|(_, place)| free(place, &taken)))
            .flatten();
        if let Some((up, place)) = up {
            strand.layouts(svg, up);
            taken.push(place);
        }
        let case = &strand.dots[0].row.case;
        let name = match up {
            Some(_) => stem(&case.graph).to_owned(),
            None if several => format!("{}, {} fastest", stem(&case.graph), case.layout.unwrap_or("")),
            None => tracer(case),
        };
        let width = 7.2 * name.chars().count() as f64;
        let at = |x: f64, y: f64| [x, y - 8.0, x + width, y + 8.0];
        // Beside the thread first, then further and further away.
        let beside = |dy: f64| [at(last[0] + 10.0, last[1] + dy), at(first[0] - 10.0 - width, first[1] + dy)];
        let over = |dy: f64| [at(first[0] + 6.0, first[1] + dy), at(last[0] - width, last[1] + dy)];
        let steps = (1..=7).flat_map(|step| [f64::from(-18 * step), f64::from(18 * step)]);
        let place = beside(0.0)
            .into_iter()
            .chain(steps.flat_map(|dy| beside(dy).into_iter().chain(over(dy))))
            .find(|place| free(place, &taken))
            .unwrap_or_else(|| beside(0.0)[0]);
        let anchor = if place[0] > f64::midpoint(first[0], last[0]) { last } else { first };
        let (x, y) = (place[0], place[1] + 8.0);
        if (y - anchor[1]).abs() > 9.0 {
            let end = if x > anchor[0] { x - 2.0 } else { (x + width + 2.0).min(anchor[0]) };
            let _ = writeln!(
                svg,
                "<path d=\"M{:.1} {:.1}L{end:.1} {y:.1}\" stroke=\"{}\" stroke-opacity=\"0.6\"/>",
                anchor[0], anchor[1], strand.color
            );
        }
        let color = if strand.dots.iter().any(|dot| dot.front) { FRONT } else { strand.color };
        svg.push_str(&text(x, y + 4.0, 11.5, color, "start", "600", &name));
        taken.push(place);
    }
}

fn overlap(a: &Place, b: &Place) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// What the pointer is told over a dot.
fn about(dot: &Dot<'_>) -> String {
    let mrays = dot.row.outcome.as_ref().map_or(0.0, raxel_runtime::bench::Measured::mrays);
    let wrong = if dot.wrong == 0.0 { "exact".to_owned() } else { format!("{} ppm wrong", three(dot.wrong)) };
    format!("{}: {} a ray, {} Mrays/s, {wrong}", tracer(&dot.row.case), duration(dot.time), three(mrays))
}
