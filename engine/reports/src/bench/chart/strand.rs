//! Dots of one graph on a thread, with names that keep out of each other's way.

use std::f64::consts::FRAC_1_SQRT_2;
use std::fmt::Write;

use super::super::labels::{stem, three, tracer};
use super::{Dot, EDGE, FRONT, INK, LEFT, Scale, duration, escaped, text};

/// A box: left, top, right, bottom.
type Place = [f64; 4];

/// Pixels between names that slant, along the thread.
const APART: f64 = 17.0;
/// Pixels between a dot and its name.
const STALK: f64 = 12.0;

/// Colours that distinguish graphs where their threads cross, the clearest first also for the colour-blind (after M. Okabe and K. Ito,
/// "Color Universal Design", and P. Tol, "Colour Schemes"); none is the red of the front.
const COLORS: [&str; 13] = [
    "#0072b2", "#d98f00", "#009e73", "#cc79a7", "#332288", "#999933", "#56b4e9", "#882255", "#7a7a7a", "#8a5a2b",
    "#9b5fe0", "#14532d", "#1f2933",
];

/// Length of a layout's name.
fn length(dot: &Dot<'_>) -> f64 {
    6.3 * layout(dot).chars().count() as f64 + 4.0
}

fn layout<'r>(dot: &Dot<'r>) -> &'r str {
    dot.row.case.layout.unwrap_or("no world")
}

/// Height of a dot's name, which slants, over the dot.
pub(super) fn slant(dot: &Dot<'_>) -> f64 {
    STALK + 6.0 + length(dot) * FRAC_1_SQRT_2
}

/// Dots of one graph, in order of time.
pub(super) struct Strand<'d, 'r> {
    dots: Vec<&'d Dot<'r>>,
    points: Vec<[f64; 2]>,
    color: &'static str,
}

impl<'d, 'r> Strand<'d, 'r> {
    /// `y` is the height of a dot; `graphs` are all there are, in order of name, for their colours.
    pub(crate) fn new(dots: Vec<&'d Dot<'r>>, scale: &Scale, y: impl Fn(&Dot<'_>) -> f64, graphs: &[&str]) -> Self {
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

    /// Where the names of the layouts begin, from left to right: at their dots, or as near as they keep apart inside the panel.
    fn slots(&self) -> Vec<f64> {
        let mut free = f64::NEG_INFINITY;
        let mut slots: Vec<f64> = Vec::new();
        for [x, _] in &self.points {
            slots.push(x.max(free));
            free = slots[slots.len() - 1] + APART;
        }
        let mut limit = f64::INFINITY;
        for (slot, dot) in slots.iter_mut().zip(&self.dots).rev() {
            *slot = slot.min(limit).min(EDGE - 8.0 - length(dot) * FRAC_1_SQRT_2);
            limit = *slot - APART;
        }
        slots
    }

    /// Names of layouts, slanting up or down from their dots: the room each takes, in pieces.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the length of a name is some hundred pixels"
    )]
    fn names(&self, up: bool) -> Vec<Name> {
        let sign = if up { -1.0 } else { 1.0 };
        let place = |((dot, [_, y]), at): ((&&Dot<'_>, &[f64; 2]), f64)| {
            let from = y + sign * STALK;
            let pieces = (length(dot) / 9.0).ceil() as u32;
            let piece = |i: u32| {
                let along = 9.0 * FRAC_1_SQRT_2 * (f64::from(i) + 0.5);
                let (x, y) = (at + along, from + sign * along);
                [x - 6.0, y - 6.0, x + 6.0, y + 6.0]
            };
            Name { at, from, room: (0..pieces).map(piece).collect() }
        };
        self.dots.iter().zip(&self.points).zip(self.slots()).map(place).collect()
    }

    /// Writes the name of a dot.
    fn write(&self, svg: &mut String, number: usize, name: &Name, up: bool) {
        let (dot, [x, y]) = (self.dots[number], self.points[number]);
        let (angle, right, down) = if up { (-45, 2.0, 0.0) } else { (45, -1.0, 5.0) };
        let (at, from) = (name.at, name.from);
        let _ = writeln!(svg, "<path d=\"M{x:.1} {y:.1}L{at:.1} {from:.1}\" stroke=\"#c3ced8\"/>");
        let (color, weight) = if dot.front { (FRONT, 600) } else { (INK, 400) };
        let _ = writeln!(
            svg,
            "<text transform=\"translate({:.1} {:.1}) rotate({angle})\" font-size=\"10.5\" fill=\"{color}\" \
             font-weight=\"{weight}\">{}</text>",
            at + right,
            from + down,
            escaped(layout(dot))
        );
    }
}

/// A name that slants.
struct Name {
    /// Where it begins.
    at: f64,
    from: f64,
    room: Vec<Place>,
}

/// Draws a strand that has a line of its own, where nothing is in its way.
pub(super) fn draw_lane(svg: &mut String, strand: &Strand<'_, '_>) {
    for (number, name) in strand.names(true).iter().enumerate() {
        strand.write(svg, number, name, true);
    }
    strand.draw(svg);
}

/// Draws strands that may cross. Names of layouts that have no room are left out; without that of the fastest it is named with the graph.
pub(super) fn draw_crossing(svg: &mut String, strands: &[Strand<'_, '_>], [top, bottom]: [f64; 2]) {
    let mut taken: Vec<Place> = strands.iter().map(|strand| strand.band(6.0)).collect();
    let mut dots = String::new();
    for (own, strand) in strands.iter().enumerate() {
        let (Some(&first), Some(&last)) = (strand.points.first(), strand.points.last()) else { continue };
        strand.draw(&mut dots);
        let free = |place: &Place, taken: &[Place]| {
            let mut others = taken.iter().enumerate().filter(|(other, _)| *other != own);
            let inside = place[0] > LEFT && place[2] < EDGE && place[1] > top && place[3] < bottom;
            inside && !others.any(|(_, other)| overlap(other, place))
        };
        let several = strand.points.len() > 1;
        let mut named = false;
        if several {
            // Up or down, wherever more of them have room.
            let [above, below] = [true, false].map(|up| {
                let all = strand.names(up).into_iter().enumerate();
                all.filter(|(_, name)| name.room.iter().all(|place| free(place, &taken))).collect::<Vec<_>>()
            });
            let up = above.len() >= below.len();
            for (number, name) in if up { above } else { below } {
                named |= number == 0;
                strand.write(svg, number, &name, up);
                taken.extend(name.room);
            }
        }
        let case = &strand.dots[0].row.case;
        let name = match case.layout {
            Some(layout) if several && !named => format!("{}, {layout} fastest", stem(&case.graph)),
            _ if several => stem(&case.graph).to_owned(),
            _ => tracer(case),
        };
        // A name of the fastest alone stays with it.
        let last = if named { last } else { first };
        let width = 7.2 * name.chars().count() as f64;
        let at = |x: f64, y: f64| [x, y - 8.0, x + width, y + 8.0];
        // Beside the thread first, then further and further away.
        let beside = |dy: f64| {
            let [left, right] = [at(first[0] - 10.0 - width, first[1] + dy), at(last[0] + 10.0, last[1] + dy)];
            if several { [left, right] } else { [right, left] }
        };
        let over = |dy: f64| [at(first[0] + 6.0, first[1] + dy), at(last[0] - width, last[1] + dy)];
        let steps = (1..=12).flat_map(|step| [f64::from(-18 * step), f64::from(18 * step)]);
        let far = (1..=30).flat_map(|dx| steps.clone().map(move |dy| (24.0 * f64::from(dx), dy)));
        // On its own thread, only the fastest has other dots to its right.
        let near = beside(0.0).into_iter().take(if several && !named { 1 } else { 2 });
        let place = near
            .chain(steps.clone().flat_map(|dy| beside(dy).into_iter().chain(over(dy))))
            .chain(far.map(|(dx, dy)| at(first[0] + 10.0 + dx, first[1] + dy)))
            .find(|place| free(place, &taken));
        let Some(place) = place else { continue };
        let anchor = if named && place[0] > f64::midpoint(first[0], last[0]) { last } else { first };
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
    svg.push_str(&dots);
}

fn overlap(a: &Place, b: &Place) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// The tooltip of a dot.
fn about(dot: &Dot<'_>) -> String {
    let mrays = dot.row.outcome.as_ref().map_or(0.0, raxel_measure::bench::Measured::mrays);
    let wrong = if dot.wrong == 0.0 { "exact".to_owned() } else { format!("{} ppm wrong", three(dot.wrong)) };
    format!("{}: {} a ray, {} Mrays/s, {wrong}", tracer(&dot.row.case), duration(dot.time), three(mrays))
}
