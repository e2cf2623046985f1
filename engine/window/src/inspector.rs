//! Reads the shown target, without stalling a frame: its distribution, the texel under the cursor, the rows of a buffer.

use std::time::{Duration, Instant};

use raxel_execute::{Captured, FrameReport, ReadTicket, Region, Texels, TracedTexel, display_of};
use raxel_graph::checked::{Display, DisplayMap, Graph, ResourceKind};
use raxel_panels::view::{Inspected, Map, Shown, Sought, Table, Texel, WrittenTexel};
use raxel_panels::{NotFinite, Statistics, not_finite, view};
use raxel_runtime::Session;
use raxel_shader::interface::ScalarKind;

use super::elements::Elements;
use super::texel_history::TexelHistory;
use super::{locate, panel_data};

/// Shortest time between two copies of something that changes.
const EVERY: Duration = Duration::from_millis(250);

/// Bytes that are copied of a buffer at most, unless its later rows are looked at.
const HEAD: u64 = 4 << 20;

/// Rows of a buffer that are shown at once.
const ROWS: u64 = 32;

/// Maps in the order of [`Map::NAMES`].
const MAPS: [DisplayMap; 8] = [
    DisplayMap::Color,
    DisplayMap::Raw,
    DisplayMap::Gray,
    DisplayMap::Turbo,
    DisplayMap::Viridis,
    DisplayMap::Normal,
    DisplayMap::Id,
    DisplayMap::Integer,
];

/// The known contents of the shown target.
#[derive(Default)]
pub struct Inspector {
    on_its_way: Option<(Shown, ReadTicket<Captured>)>,
    asked: Option<Instant>,
    /// The time to decode the last copy: a large one is taken less often.
    cost: Duration,
    /// The last request, and whether the target may have changed since.
    of: Option<Shown>,
    stale: bool,
    found: Option<Found>,
    /// The user's own way of showing it.
    map: Option<Map>,
    /// The first row of a buffer that is shown.
    first: u64,
    /// The whole buffer is to be written to a file when it is there.
    writing: bool,
    /// A copy that was asked for, and then one that has come.
    copying: Option<CopiedFor>,
    copied: Option<(CopiedFor, Shown)>,
    pinned: Option<Pin>,
    /// The pinned texel over passes and frames.
    history: TexelHistory,
    seen: Inspected,
}

/// A pinned texel.
#[derive(Clone, Copy, Debug)]
pub struct Pin {
    /// Its place.
    pub texel: [u32; 2],
    /// Extent of the picture that it was pinned in.
    pub extent: [u32; 2],
}

/// The purpose of a copy of the shown target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CopiedFor {
    /// To be kept, and compared with.
    Keeping,
    /// To be measured against the kept picture.
    Measuring,
}

/// A copy of the shown target.
pub struct Copy {
    /// Its purpose.
    pub purpose: CopiedFor,
    /// The copied target.
    pub shown: Shown,
    /// Its texels and the way they are shown; `None` of a buffer.
    pub texels: Option<(Texels, Display)>,
}

struct Found {
    shown: Shown,
    captured: Captured,
    statistics: Option<(u32, Option<Statistics>)>,
    /// Of each channel.
    not_finite: Vec<NotFinite>,
}

impl Inspector {
    /// Asks for a copy of the shown target, for [`Self::copied`].
    pub fn copy(&mut self, purpose: CopiedFor) {
        (self.copying, self.stale, self.asked) = (Some(purpose), true, None);
    }

    /// Whether a copy was asked for that is not there yet.
    pub fn is_copying(&self) -> bool {
        self.copying.is_some()
    }

    /// The copy that was asked for, once it is there.
    pub fn copied(&mut self, graph: &Graph) -> Option<Copy> {
        let (purpose, shown) = self.copied.take()?;
        let map = self.map.unwrap_or_else(|| graphs_map(graph, &shown));
        let display = self.display(graph, map);
        let texels = self.picture().cloned().map(|texels| (texels, display));
        Some(Copy { purpose, shown, texels })
    }

    /// No panel shows it: the known contents are stale from here on, and no texel is followed.
    pub fn rest(&mut self, session: &mut Session) {
        self.stale = true;
        self.history.follow(session, None);
    }

    /// Asks for the invocations that write the pinned texel, or no more.
    pub fn find_writers(&mut self, session: &mut Session, on: bool) {
        self.history.find_writers(session, on);
    }

    /// The values of the texels in a region of the shown target, as far as they are known.
    pub fn written(&self, shown: &Shown, region: &Region) -> Vec<WrittenTexel> {
        match self.found.as_ref().filter(|found| found.shown == *shown).map(|found| &found.captured) {
            Some(Captured::Texels(texels)) => locate::written(texels, region),
            _ => Vec::new(),
        }
    }

    /// The pinned texel.
    pub fn pinned(&self) -> Option<Pin> {
        self.pinned
    }

    /// Before a frame: asks for a copy when there is something new to copy.
    pub fn ask(&mut self, session: &mut Session) {
        let shown = panel_data::shown(session.debug_target(), session.graph());
        self.history.follow(session, self.traced(&shown));
        let new = self.of.as_ref() != Some(&shown);
        if new {
            (self.first, self.found) = (0, self.found.take().filter(|found| found.shown == shown));
        }
        let due = self.asked.is_none_or(|asked| asked.elapsed() >= EVERY.max(self.cost * 8));
        if self.on_its_way.is_some() || !(new || (self.stale && due)) {
            return;
        }
        (self.of, self.asked, self.stale) = (Some(shown), Some(Instant::now()), false);
        session.capture_shown(self.part(session));
    }

    /// The pinned texel of the shown target, if its values are those of the present frame.
    fn traced(&self, shown: &Shown) -> Option<TracedTexel> {
        let found = self.found.as_ref().filter(|found| found.shown == *shown && shown.age == 0)?;
        let Captured::Texels(texels) = &found.captured else { return None };
        let at = self.pinned_in(texels)?;
        Some(TracedTexel { target: shown.resource.clone(), mip: shown.mip, layer: shown.layer, at })
    }

    /// The bytes of a buffer that are wanted: its head, or the rows that are looked at.
    fn part(&self, session: &Session) -> std::ops::Range<u64> {
        let elements = Elements::of(session.graph(), self.of.as_ref().map_or("", |shown| &shown.resource));
        let Some(elements) = elements.filter(|_| !self.writing) else { return 0..u64::MAX };
        let end = elements.offset(self.first + ROWS);
        if end <= HEAD { 0..HEAD } else { elements.offset(self.first)..end }
    }

    /// After a frame: takes the copies that have come, and applies the user's display.
    pub fn take(&mut self, session: &mut Session, report: &FrameReport) {
        match (session.captured(), self.of.clone()) {
            (Some(ticket), Some(shown)) => self.on_its_way = Some((shown, ticket)),
            _ => self.stale |= report.displayed || report.dispatched > 0,
        }
        if let Some((shown, ticket)) = self.on_its_way.take() {
            match ticket.poll() {
                Ok(Some(captured)) => {
                    if self.of.as_ref() == Some(&shown) {
                        self.copied = self.copying.take().map(|purpose| (purpose, shown.clone()));
                    }
                    self.found = Some(Found { shown, captured, statistics: None, not_finite: Vec::new() });
                }
                Ok(None) => self.on_its_way = Some((shown, ticket)),
                // The next frame reopens the device and asks again.
                Err(_) => self.stale = true,
            }
        }
        self.history.take(session);
        self.judge(session.graph());
        let display = self.map.map(|map| self.display(session.graph(), map));
        session.set_display(display);
    }

    /// Forgets the user's way of showing when another resource is shown.
    pub fn shows(&mut self, map: Option<Map>) {
        self.map = map;
    }

    /// The picture that was copied last.
    fn picture(&self) -> Option<&Texels> {
        match &self.found.as_ref()?.captured {
            Captured::Texels(texels) => Some(texels),
            Captured::Bytes { .. } => None,
        }
    }

    /// The pinned texel in a picture, which may have another extent than the one it was pinned in.
    fn pinned_in(&self, texels: &Texels) -> Option<[u32; 2]> {
        self.pinned.map(|pin| locate::scaled(pin.texel, pin.extent, extent_of(texels)))
    }

    /// Pins a texel of the shown target; it stays while other resources and passes are shown.
    pub fn pin(&mut self, at: Option<[u32; 2]>) {
        let extent = self.picture().map(extent_of);
        self.pinned = at.zip(extent).map(|(texel, extent)| Pin { texel, extent });
    }

    /// Pins the texel under a pixel of the output, or lets go of the one that is pinned. False when there is no picture under it.
    pub fn pin_under(&mut self, pixel: Option<[i32; 2]>, output: [u32; 2], region: &Region) -> bool {
        if self.pinned.take().is_some() {
            return true;
        }
        let at = self.picture().zip(pixel).and_then(|(texels, pixel)| texel_under(texels, pixel, output, region));
        self.pin(at);
        at.is_some()
    }

    /// Pins the next texel with a sought value in its channel, or the one before. False when there is none.
    pub fn find(&mut self, sought: Sought, channel: u32, forward: bool) -> bool {
        let found =
            self.picture().and_then(|texels| locate::next(texels, channel, sought, self.pinned_in(texels), forward));
        if found.is_some() {
            self.pin(found);
        }
        found.is_some()
    }

    /// Rows of a buffer from here on.
    pub fn rows(&mut self, first: u64) {
        (self.first, self.stale, self.asked) = (first, true, None);
    }

    /// Asks for the whole buffer, for [`Self::whole`].
    pub fn write(&mut self) {
        (self.writing, self.stale, self.asked) = (true, true, None);
    }

    /// The columns and rows of the whole buffer, once they are there after [`Self::write`].
    pub fn whole(&mut self, graph: &Graph) -> Option<(String, Vec<String>, Vec<Vec<String>>)> {
        let found = self.found.as_ref().filter(|_| self.writing)?;
        let Captured::Bytes { start: 0, total, bytes } = &found.captured else { return None };
        if (bytes.len() as u64) < *total & !3 {
            return None;
        }
        self.writing = false;
        let elements = Elements::of(graph, &found.shown.resource)?;
        let rows = (0..elements.count(*total)).map(|row| elements.row(bytes, 0, row)).collect();
        Some((found.shown.resource.clone(), elements.names(), rows))
    }

    /// The channel and range that a map reads, automatic ones found from the percentiles.
    fn display(&self, graph: &Graph, map: Map) -> Display {
        let automatic = || {
            let statistics = self.found.as_ref().and_then(|found| found.statistics.as_ref()?.1.as_ref());
            statistics.map(|statistics| statistics.percentiles).filter(|[low, high]| low < high)
        };
        let graphs = self.of.as_ref().map(|shown| graphs_map(graph, shown).range);
        let range = map.range.or_else(automatic).or(graphs.flatten()).unwrap_or([0.0, 1.0]);
        Display { map: MAPS[map.map.min(MAPS.len() - 1)], range, channel: map.channel }
    }

    /// Finds the numbers of the chosen channel, once for each copy.
    fn judge(&mut self, graph: &Graph) {
        let Some(found) = &mut self.found else { return };
        let channel = self.map.unwrap_or_else(|| graphs_map(graph, &found.shown)).channel;
        if found.statistics.as_ref().is_some_and(|(known, _)| *known == channel) {
            return;
        }
        let began = Instant::now();
        let statistics = match &found.captured {
            Captured::Texels(texels) => {
                let channels = texels.format.channels() as usize;
                let texels = texels.floats();
                found.not_finite = not_finite(&texels, channels);
                let channel = (channel as usize).min(channels - 1);
                Statistics::of(texels.into_iter().map(|texel| texel[channel]))
            }
            Captured::Bytes { .. } => None,
        };
        found.statistics = Some((channel, statistics));
        self.cost = began.elapsed();
    }

    /// The panel's view. `cursor` is a pixel of the output, which shows a region of the picture.
    pub fn view(
        &mut self,
        session: &Session,
        resources: &[view::Resource],
        cursor: Option<[i32; 2]>,
        region: &Region,
    ) -> Option<&Inspected> {
        let found = self.found.as_ref()?;
        let graph = session.graph();
        let about = resources.iter().find(|resource| resource.name == found.shown.resource);
        let mut seen = Inspected {
            shown: found.shown.clone(),
            about: about.map(|resource| resource.about.clone()).unwrap_or_default(),
            mips: 1,
            layers: 1,
            map: self.map,
            ..Inspected::default()
        };
        match &found.captured {
            Captured::Texels(texels) => {
                let size = graph
                    .find_resource(&found.shown.resource)
                    .and_then(|id| session.plan().map(|plan| plan.sizes[id.0 as usize]));
                if let Some(size) = size {
                    seen.mips = size.mips();
                    seen.layers = size.texels(found.shown.mip).map_or(1, |[_, _, layers]| layers);
                }
                seen.channels = ["r", "g", "b", "a"][..texels.format.channels() as usize].to_vec();
                seen.used = Some(match self.map {
                    Some(map) => Map { range: Some(self.display(graph, map).range), ..map },
                    None => graphs_map(graph, &found.shown),
                });
                seen.statistics = found.statistics.as_ref().and_then(|(_, statistics)| statistics.clone());
                seen.not_finite.clone_from(&found.not_finite);
                seen.extent = extent_of(texels);
                let under = cursor.and_then(|pixel| texel_under(texels, pixel, session.size(), region));
                seen.cursor = under.and_then(|at| texel(texels, at));
                let pinned = self.pinned_in(texels);
                seen.pinned = pinned.and_then(|at| texel(texels, at));
                let channel = seen.used.map_or(0, |used| used.channel);
                seen.history = seen.pinned.as_ref().and_then(|_| self.history.view(channel));
                seen.writers = seen.pinned.as_ref().and_then(|_| self.history.view_writers());
                let display = seen.used.map(|used| self.display(graph, used));
                seen.zoom = pinned.or(under).zip(display).map(|(at, display)| locate::zoom(texels, at, &display));
            }
            Captured::Bytes { start, total, bytes } => {
                if let Some(elements) = Elements::of(graph, &found.shown.resource) {
                    let count = elements.count(*total);
                    let rows = (self.first..count.min(self.first + ROWS)).map(|row| elements.row(bytes, *start, row));
                    seen.table = Some(Table {
                        columns: elements.names(),
                        total: count,
                        first: self.first,
                        rows: rows.collect(),
                        head: elements.head(bytes, *start),
                    });
                }
            }
        }
        self.seen = seen;
        Some(&self.seen)
    }
}

/// The way in which the graph shows it.
fn graphs_map(graph: &Graph, shown: &Shown) -> Map {
    let display = graph.find_resource(&shown.resource).and_then(|id| match &graph.resource(id).kind {
        ResourceKind::Target(target) => Some(display_of(target)),
        ResourceKind::Buffer(_) => None,
    });
    let display = display.unwrap_or(Display { map: DisplayMap::Raw, range: [0.0, 1.0], channel: 0 });
    let map = MAPS.iter().position(|map| *map == display.map).unwrap_or(0);
    Map { map, range: Some(display.range), channel: display.channel }
}

fn extent_of(texels: &Texels) -> [u32; 2] {
    [texels.width, texels.height]
}

/// The place of the texel that a pixel of the output shows, by the rule of the shader that makes the picture (`display.comp`).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the pixel is inside the output, so that the texel is inside the extent"
)]
fn texel_under(texels: &Texels, pixel: [i32; 2], output: [u32; 2], region: &Region) -> Option<[u32; 2]> {
    let extent = extent_of(texels);
    let mut at = [0; 2];
    for axis in 0..2 {
        let pixel = u64::try_from(pixel[axis]).ok().filter(|&pixel| pixel < u64::from(output[axis]))?;
        at[axis] = if *region == Region::WHOLE {
            (pixel * u64::from(extent[axis]) / u64::from(output[axis].max(1))) as u32
        } else {
            let share = (pixel as f64 + 0.5) / f64::from(output[axis].max(1));
            let place = (region.origin[axis] + share * region.size) * f64::from(extent[axis]);
            (place as u32).min(extent[axis].saturating_sub(1))
        };
    }
    Some(at)
}

/// A texel: its channels, and their bits in hexadecimal.
pub(super) fn texel(texels: &Texels, at: [u32; 2]) -> Option<Texel> {
    let (floats, bits) = texels.texel(at)?;
    let channels = texels.format.channels() as usize;
    let integers = texels.integer(at);
    let values = (0..channels).map(|channel| {
        let value = match (texels.scalar(), integers) {
            (ScalarKind::Int, Some(integers)) => integers[channel].cast_signed().to_string(),
            (ScalarKind::Uint, Some(integers)) => integers[channel].to_string(),
            _ => floats[channel].to_string(),
        };
        [value, format!("0x{:x}", bits[channel])]
    });
    Some(Texel { at, values: values.collect() })
}

#[cfg(test)]
mod tests {
    use raxel_shader::format::Format;

    use super::*;

    #[test]
    fn the_texel_under_a_pixel_is_exact() {
        let bytes = [1.5_f32, f32::NAN, -0.0, 2.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        let texels = Texels { format: Format::R32f, width: 2, height: 2, bytes };
        let under = |texels: &Texels, pixel, output| {
            texel_under(texels, pixel, output, &Region::WHOLE).and_then(|at| texel(texels, at))
        };
        let at = |x, y| under(&texels, [x, y], [8, 8]).map(|texel| (texel.at, texel.values[0].clone()));
        assert_eq!(at(0, 0), Some(([0, 0], ["1.5".to_owned(), "0x3fc00000".to_owned()])));
        assert_eq!(at(7, 3).unwrap().1[0], "NaN");
        assert_eq!(at(3, 4), Some(([0, 1], ["-0".to_owned(), "0x80000000".to_owned()])));
        assert_eq!((at(8, 0), at(-1, 0)), (None, None));
        // Magnified, a pixel shows another texel.
        let half = Region { origin: [0.25, 0.5], size: 0.5 };
        let magnified = |x, y| texel_under(&texels, [x, y], [8, 8], &half);
        assert_eq!([magnified(0, 0), magnified(3, 7), magnified(4, 0)], [Some([0, 1]), Some([0, 1]), Some([1, 1])]);
        let texels = Texels { format: Format::Rg16i, width: 1, height: 1, bytes: vec![0xff, 0xff, 2, 0] };
        let texel = under(&texels, [0, 0], [1, 1]).unwrap();
        assert_eq!(texel.values, [["-1", "0xffff"], ["2", "0x2"]].map(|pair| pair.map(str::to_owned)));
    }

    #[test]
    fn a_nan_is_pinned_and_the_pin_stays_where_it_is_in_another_picture() {
        let bytes = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let picture = |width, values: &[f32]| {
            let texels = Texels { format: Format::R32f, width, height: 2, bytes: bytes(values) };
            let captured = Captured::Texels(texels);
            Some(Found { shown: Shown::default(), captured, statistics: None, not_finite: Vec::new() })
        };
        let mut inspector = Inspector { found: picture(2, &[1.0, 2.0, f32::NAN, 4.0]), ..Inspector::default() };
        let pinned = |inspector: &Inspector| inspector.pinned_in(inspector.picture().unwrap());
        assert!(inspector.find(Sought::Nan, 0, true));
        assert_eq!(pinned(&inspector), Some([0, 1]));
        assert!(!inspector.find(Sought::Infinite, 0, true));
        assert_eq!(pinned(&inspector), Some([0, 1]), "what is not there moves nothing");
        // Twice as wide: the same place.
        inspector.found = picture(4, &[0.0; 8]);
        assert_eq!(pinned(&inspector), Some([1, 1]));
        assert!(inspector.pin_under(None, [8, 8], &Region::WHOLE), "let go of");
        assert_eq!(pinned(&inspector), None);
        assert!(!inspector.pin_under(None, [8, 8], &Region::WHOLE), "nothing is under the cursor");
        assert!(inspector.pin_under(Some([7, 0]), [8, 8], &Region::WHOLE));
        assert_eq!(pinned(&inspector), Some([3, 0]));
    }
}
