//! Reads the shown target, without stalling a frame: its distribution, the texel under the cursor, the rows of a buffer.

use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_execute::{Captured, FrameReport, ReadTicket, Region, Texels, TracedTexel, display_of};
use raxel_graph::checked::{Display, DisplayMap, Graph, ResourceKind};
use raxel_panels::view::{self, Inspected, Map, Pinned, Shown, Table, Texel, WrittenTexel};
use raxel_runtime::Session;
use raxel_shader::interface::ScalarKind;

use super::elements::Elements;
use super::finding::{Ended, Finding, Wanted};
use super::numbers::{self, Done, Job, Numberer, Numbers, Taken};
use super::pins::{Pin, Pins, Pressed};
use super::texel_history::TexelHistory;
use super::{locate, panel_data};

/// Shortest time between two copies of something that changes.
const EVERY: Duration = Duration::from_millis(250);

/// A reader is told that numbers are of an earlier frame when the newest copy has waited for its own so long.
const OLD: Duration = Duration::from_secs(1);

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
    /// The time to work out the numbers of the last copy: a large one is taken less often.
    cost: Duration,
    /// The thread that does, once there was a copy.
    numberer: Option<Numberer>,
    /// It has a job.
    works: bool,
    /// Copies that it was given.
    given: u64,
    /// The last request, and whether the target may have changed since.
    of: Option<Shown>,
    stale: bool,
    found: Option<Taken>,
    /// The last known numbers, of this copy or of an earlier one.
    numbers: Option<Box<Numbers>>,
    /// The search for a value.
    finding: Option<Finding>,
    /// Searches that were begun.
    searches: u64,
    /// How the last one ended, until [`Self::ended`].
    ended: Option<Ended>,
    /// The user's own way of showing it.
    map: Option<Map>,
    /// The first row of a buffer that is shown.
    first: u64,
    /// Copies that were asked for, one for each purpose, then those that have come, and those that cannot come any more.
    copying: Vec<Wish>,
    copied: Vec<Copied>,
    given_up: Vec<(CopiedFor, Shown)>,
    /// The generation that runs, which the window sets before [`Self::take`].
    pub(crate) generation: u64,
    /// Pinned texels.
    pins: Pins,
    /// The active one over passes and frames.
    history: TexelHistory,
    seen: Inspected,
}

/// The purpose of a copy of the shown resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CopiedFor {
    /// To be kept, and compared with. It has the number of its request.
    Keeping(u64),
    /// To be measured against the kept picture.
    Measuring,
    /// To be written as a table: all bytes of a buffer.
    Table,
}

/// A copy that was asked for.
struct Wish {
    purpose: CopiedFor,
    /// What was shown then.
    shown: Shown,
    /// The number of the copy that it gets, once a frame has made one.
    number: Option<u64>,
    /// The generation of that frame.
    generation: u64,
    /// The layout of a buffer in that frame.
    elements: Option<Elements>,
}

/// A copy that has come for a wish. Other files may run since the frame that has made it.
pub(crate) struct Copied {
    pub purpose: CopiedFor,
    pub taken: Taken,
    /// The generation of its frame.
    pub generation: u64,
    /// The layout of a buffer in its frame.
    pub elements: Option<Elements>,
}

impl Inspector {
    /// Asks for a copy that the next frame makes of what is shown, for [`Self::copied`]. A wish of the same kind is given up.
    pub(crate) fn copy(&mut self, purpose: CopiedFor, shown: Shown) {
        let same = |wish: &mut Wish| std::mem::discriminant(&wish.purpose) == std::mem::discriminant(&purpose);
        self.given_up.extend(self.copying.extract_if(.., same).map(|wish| (wish.purpose, wish.shown)));
        // A copy on its way is of an earlier frame. Another wish may wait for it: then the next copy follows it.
        let awaited = Some(self.given + 1);
        if !self.copying.iter().any(|wish| wish.number == awaited) {
            self.on_its_way = None;
        }
        self.copying.push(Wish { purpose, shown, number: None, generation: 0, elements: None });
        (self.stale, self.asked) = (true, None);
    }

    /// Whether a copy was asked for that is not there yet.
    pub(crate) fn is_copying(&self) -> bool {
        !self.copying.is_empty()
    }

    /// Copies that have come since the last call.
    pub(crate) fn copied(&mut self) -> Vec<Copied> {
        std::mem::take(&mut self.copied)
    }

    /// Copies that do not come, since another resource was shown before a frame could make them.
    pub(crate) fn given_up(&mut self) -> Vec<(CopiedFor, Shown)> {
        std::mem::take(&mut self.given_up)
    }

    /// The way in which texels are shown now.
    pub(crate) fn display_of(&self, graph: &Graph, shown: &Shown) -> Display {
        self.display(graph, self.map.unwrap_or_else(|| graphs_map(graph, shown)))
    }

    /// The buffer whose rows are shown, and its bytes.
    pub(crate) fn table(&self) -> Option<(Shown, u64)> {
        let found = self.found.as_ref()?;
        match &*found.captured {
            Captured::Bytes { total, .. } => Some((found.shown.clone(), *total)),
            Captured::Texels(_) => None,
        }
    }

    /// No panel shows it: the known contents are stale from here on, and no texel is followed. The user's own map stays, and undo may change it.
    pub fn rest(&mut self, session: &mut Session) {
        self.show_map(session);
        self.stale = true;
        self.stop(session);
        self.history.follow(session, None);
        session.rest_captures();
    }

    /// Asks for the invocations that write the pinned texel, or no more.
    pub fn find_writers(&mut self, session: &mut Session, on: bool) {
        self.history.find_writers(session, on);
    }

    /// The values of the texels in a region of the shown target, as far as they are known.
    pub fn written(&self, shown: &Shown, region: &Region) -> Vec<WrittenTexel> {
        match self.found.as_ref().filter(|found| found.shown == *shown).map(|found| &*found.captured) {
            Some(Captured::Texels(texels)) => locate::written(texels, region),
            _ => Vec::new(),
        }
    }

    /// The active one of the pinned texels.
    pub fn pinned(&self) -> Option<Pin> {
        self.pins.active()
    }

    /// Before a frame: asks for a copy when there is something new to copy.
    pub fn ask(&mut self, session: &mut Session) {
        let shown = panel_data::shown(session.debug_target(), session.graph());
        self.history.follow(session, self.traced(&shown));
        if let Some(finding) = self.finding.as_mut().filter(|finding| finding.is_of(&shown)) {
            return finding.ask(session);
        }
        // The user shows another target: there is nothing to go back to.
        self.finding = None;
        let too_late = |wish: &mut Wish| wish.number.is_none() && wish.shown != shown;
        self.given_up.extend(self.copying.extract_if(.., too_late).map(|wish| (wish.purpose, wish.shown)));
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
        let Captured::Texels(texels) = &*found.captured else { return None };
        let at = self.pinned_in(texels)?;
        Some(TracedTexel { target: shown.resource.clone(), mip: shown.mip, layer: shown.layer, at })
    }

    /// The bytes of a buffer that are wanted: its head, or the rows that are looked at.
    fn part(&self, session: &Session) -> std::ops::Range<u64> {
        let elements = Elements::of(session.graph(), self.of.as_ref().map_or("", |shown| &shown.resource));
        let whole = self.copying.iter().any(|wish| wish.purpose == CopiedFor::Table);
        let Some(elements) = elements.filter(|_| !whole) else { return 0..u64::MAX };
        let end = elements.offset(self.first + ROWS);
        if end <= HEAD { 0..HEAD } else { elements.offset(self.first)..end }
    }

    /// After a frame: takes the copies and the numbers that have come, and applies the user's display. Whether the panel has news.
    pub fn take(&mut self, session: &mut Session, report: &FrameReport) -> bool {
        if let Some(finding) = &mut self.finding {
            let copied = finding.take(session);
            self.stale |= report.dispatched > 0;
            if !copied {
                self.end(session, Ended::Lost);
            }
        } else {
            match (session.captured(), self.of.clone()) {
                (Some(ticket), Some(shown)) => {
                    let (number, generation) = (Some(self.given + 1), self.generation);
                    let of_it = |wish: &&mut Wish| wish.number.is_none() && wish.shown == shown;
                    for wish in self.copying.iter_mut().filter(of_it) {
                        (wish.number, wish.generation) = (number, generation);
                        wish.elements = Elements::of(session.graph(), &shown.resource);
                    }
                    self.on_its_way = Some((shown, ticket));
                }
                _ => self.stale |= report.displayed || report.dispatched > 0,
            }
        }
        self.history.take(session);
        let news = self.take_done(session);
        self.hand_over(session.graph());
        self.show_map(session);
        news
    }

    /// Shows texels by the user's own map, or by the graph's.
    fn show_map(&self, session: &mut Session) {
        let display = self.map.map(|map| self.display(session.graph(), map));
        session.set_display(display);
    }

    /// Takes what the other thread has done. Whether there was anything.
    fn take_done(&mut self, session: &mut Session) -> bool {
        let mut news = false;
        while let Some(done) = self.numberer.as_ref().and_then(Numberer::done) {
            news = true;
            match done {
                Done::Copy(copy) => {
                    let wished = self.copying.extract_if(.., |wish| wish.number == Some(copy.number));
                    self.copied.extend(wished.map(|Wish { purpose, generation, elements, .. }| {
                        let taken = copy.clone();
                        Copied { purpose, taken, generation, elements }
                    }));
                    if self.of.as_ref() == Some(&copy.shown) {
                        self.found = Some(copy);
                    }
                    continue;
                }
                Done::Numbers(numbers) => {
                    self.cost = numbers.took;
                    self.numbers = Some(numbers);
                }
                // The next frame reopens the device and asks again.
                Done::Lost => {
                    self.stale = true;
                    self.copying.iter_mut().for_each(|wish| wish.number = None);
                }
                Done::Looked(looked) => {
                    if let Some(ended) = self.finding.as_mut().and_then(|finding| finding.looked(looked)) {
                        self.end(session, ended);
                    }
                }
            }
            self.works = false;
        }
        news
    }

    /// Gives the other thread its next job, if it has none: a slice to look at, a copy that has arrived, or another channel.
    fn hand_over(&mut self, graph: &Graph) {
        if self.works {
            return;
        }
        let job = self.finding.as_mut().and_then(Finding::hand_over).map(Job::Look);
        if let Some(job) = job.or_else(|| self.arrived(graph)).or_else(|| self.other_channel(graph)) {
            self.numberer.get_or_insert_with(numbers::start).ask(job);
            self.works = true;
        }
    }

    /// The copy that was asked for, once it has arrived.
    fn arrived(&mut self, graph: &Graph) -> Option<Job> {
        // The other thread reports the loss of a device.
        let arrived = |(_, ticket): &mut (Shown, ReadTicket<Captured>)| ticket.has_arrived().unwrap_or(true);
        let (shown, ticket) = self.on_its_way.take_if(arrived)?;
        self.given += 1;
        let channel = self.channel(graph, &shown);
        Some(Job::Read { shown, ticket, number: self.given, channel })
    }

    /// The known copy, if the known numbers are of another channel or of another copy.
    fn other_channel(&self, graph: &Graph) -> Option<Job> {
        let copy = self.found.as_ref()?;
        let channel = self.channel(graph, &copy.shown);
        let known = self.numbers.as_ref().is_some_and(|known| (known.number, known.channel) == (copy.number, channel));
        (!known).then(|| Job::Channel { copy: copy.clone(), channel })
    }

    /// The channel whose distribution is shown.
    fn channel(&self, graph: &Graph, shown: &Shown) -> u32 {
        self.map.unwrap_or_else(|| graphs_map(graph, shown)).channel
    }

    /// The user's own way of showing.
    pub fn map(&self) -> Option<Map> {
        self.map
    }

    /// Shows texels in the user's own way from now on, or in the graph's.
    pub fn shows(&mut self, map: Option<Map>) {
        self.map = map;
    }

    /// The picture that was copied last.
    fn picture(&self) -> Option<&Arc<Texels>> {
        match &*self.found.as_ref()?.captured {
            Captured::Texels(texels) => Some(texels),
            Captured::Bytes { .. } => None,
        }
    }

    /// The active pin in a picture, which may have another extent than the one it was pinned in.
    fn pinned_in(&self, texels: &Texels) -> Option<[u32; 2]> {
        self.pins.active().map(|pin| pin.place_in(extent_of(texels)))
    }

    /// Pins a texel of the shown target; it stays while other resources and passes are shown. False when there are too many pins.
    pub fn pin(&mut self, at: [u32; 2]) -> bool {
        let extent = self.picture().map(|texels| extent_of(texels));
        extent.is_none_or(|extent| self.pins.add(at, extent))
    }

    /// Puts a pin on another texel of the shown target.
    pub(crate) fn move_pin(&mut self, number: u32, at: [u32; 2]) {
        if let Some(extent) = self.picture().map(|texels| extent_of(texels)) {
            self.pins.go(number, at, extent);
        }
    }

    /// Makes a pin the active one.
    pub(crate) fn choose_pin(&mut self, number: u32) {
        self.pins.choose(number);
    }

    /// Lets go of a pin.
    pub(crate) fn unpin(&mut self, number: u32) {
        self.pins.remove(number);
    }

    /// Pins the texel under a pixel of the output, or lets go of the pin that is there.
    pub(crate) fn pin_under(&mut self, pixel: Option<[i32; 2]>, output: [u32; 2], region: &Region) -> Pressed {
        let Some((texels, pixel)) = self.picture().zip(pixel) else { return Pressed::Nothing };
        let Some(at) = texel_under(texels, pixel, output, region) else { return Pressed::Nothing };
        if let Some(number) = self.pins.under(texels, at, pixel, output, region) {
            self.pins.remove(number);
            return Pressed::Unpinned;
        }
        if self.pin(at) { Pressed::Pinned } else { Pressed::Full }
    }

    /// Looks for a value in all slices of the shown target, from the active pin on, which the value gets then: [`Self::ended`] has the result.
    pub fn find(&mut self, session: &mut Session, wanted: Wanted) {
        self.stop(session);
        let Some(Taken { shown, captured, .. }) = &self.found else { return };
        let Captured::Texels(texels) = &**captured else { return };
        self.searches += 1;
        let from = self.pinned_in(texels);
        self.finding = Finding::new(session, (shown, captured), wanted, from, self.searches);
    }

    /// Ends the search without a result.
    pub fn stop(&mut self, session: &mut Session) {
        if let Some(finding) = self.finding.take() {
            self.stale = true;
            go_back(session, &finding);
        }
    }

    /// The time that the last numbers took, on their thread.
    pub fn cost(&self) -> Duration {
        self.cost
    }

    /// The end of a search, once.
    pub fn ended(&mut self) -> Option<Ended> {
        self.ended.take()
    }

    fn end(&mut self, session: &mut Session, ended: Ended) {
        match &ended {
            Ended::Found { texel, extent, .. } => {
                self.finding = None;
                self.stale = true;
                self.pins.add_found(*texel, *extent);
            }
            Ended::Nothing { .. } | Ended::Lost => self.stop(session),
        }
        self.ended = Some(ended);
    }

    /// Rows of a buffer from here on.
    pub fn rows(&mut self, first: u64) {
        (self.first, self.stale, self.asked) = (first, true, None);
    }

    /// The channel and range that a map reads, automatic ones found from the percentiles.
    fn display(&self, graph: &Graph, map: Map) -> Display {
        let automatic = || {
            // Those of an earlier copy, or of another channel, until its own are there.
            let known = self.numbers.as_ref().filter(|known| self.of.as_ref() == Some(&known.shown));
            let statistics = known.and_then(|known| known.statistics.as_ref());
            statistics.map(|statistics| statistics.percentiles).filter(|[low, high]| low < high)
        };
        let graphs = self.of.as_ref().map(|shown| graphs_map(graph, shown).range);
        let range = map.range.or_else(automatic).or(graphs.flatten()).unwrap_or([0.0, 1.0]);
        Display { map: MAPS[map.map.min(MAPS.len() - 1)], range, channel: map.channel }
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
            looking: self.finding.as_ref().map(Finding::view),
            ..Inspected::default()
        };
        match &*found.captured {
            Captured::Texels(texels) => {
                let size = graph
                    .find_resource(&found.shown.resource)
                    .and_then(|id| session.plan()?.sizes.get(id.0 as usize).copied());
                if let Some(size) = size {
                    seen.mips = size.mips();
                    seen.layers = size.texels(found.shown.mip).map_or(1, |[_, _, layers]| layers);
                }
                seen.channels = ["r", "g", "b", "a"][..texels.format.channels() as usize].to_vec();
                seen.used = Some(match self.map {
                    Some(map) => Map { range: Some(self.display(graph, map).range), ..map },
                    None => graphs_map(graph, &found.shown),
                });
                let channel = self.channel(graph, &found.shown);
                let known = self.numbers.as_ref();
                if let Some(known) = known.filter(|known| known.shown == found.shown && known.channel == channel) {
                    seen.statistics.clone_from(&known.statistics);
                    seen.not_finite.clone_from(&known.not_finite);
                    seen.earlier = known.number != found.number && found.read.elapsed() > OLD;
                }
                seen.extent = extent_of(texels);
                let under = cursor.and_then(|pixel| texel_under(texels, pixel, session.size(), region));
                seen.cursor = under.and_then(|at| texel(texels, at));
                let pin = |pin: &Pin| Pinned { number: pin.number, texel: texel(texels, pin.place_in(seen.extent)) };
                seen.pins = self.pins.all().iter().map(pin).collect();
                seen.active = self.pins.active().map_or(0, |pin| pin.number);
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

/// Shows what was shown before a search showed other slices.
fn go_back(session: &mut Session, finding: &Finding) {
    if let Some(shown) = finding.gone_from() {
        // A graph that was edited since may not have it, and the next search begins elsewhere.
        let _ = session.set_debug_target(panel_data::debug_target(shown));
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
    use crate::panel_data::tests::{FILL, eventually, open};

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
    fn pins_stay_where_they_are_in_another_picture_and_a_key_takes_them_away() {
        let picture = |width, values: &[f32]| {
            let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            let texels = Texels { format: Format::R32f, width, height: 2, bytes };
            let captured = Captured::Texels(texels.into()).into();
            Some(Taken { shown: Shown::default(), captured, number: 1, read: Instant::now() })
        };
        let mut inspector = Inspector { found: picture(2, &[1.0, 2.0, f32::NAN, 4.0]), ..Inspector::default() };
        let press = |inspector: &mut Inspector, pixel| inspector.pin_under(pixel, [80, 80], &Region::WHOLE);
        let pinned = |inspector: &Inspector| {
            let extent = extent_of(inspector.picture().unwrap());
            inspector.pins.all().iter().map(|pin| pin.place_in(extent)).collect::<Vec<_>>()
        };
        assert_eq!(press(&mut inspector, Some([20, 60])), Pressed::Pinned);
        assert_eq!(press(&mut inspector, Some([60, 10])), Pressed::Pinned);
        assert_eq!(pinned(&inspector), [[0, 1], [1, 0]]);
        // Twice as wide: the same places.
        inspector.found = picture(4, &[0.0; 8]);
        assert_eq!(pinned(&inspector), [[1, 1], [3, 0]]);
        assert_eq!(press(&mut inspector, None), Pressed::Nothing, "nothing is under the cursor");
        // The marks are at 30, 60 and 70, 20; six pixels reach the one beside the texel.
        assert_eq!(press(&mut inspector, Some([19, 60])), Pressed::Pinned, "ten pixels are too far");
        assert_eq!(press(&mut inspector, Some([32, 61])), Pressed::Unpinned);
        assert_eq!(press(&mut inspector, Some([61, 5])), Pressed::Unpinned, "anywhere in its texel");
        assert_eq!(pinned(&inspector), [[0, 1]]);
    }

    const TWO: &str = "name = \"two\"\npresent = \"a\"\n[targets.a]\nformat = \"r32f\"\nsize = [8, 8]\n\
        [targets.b]\nformat = \"r32f\"\nsize = [8, 8]\n\
        [[passes]]\nname = \"first\"\nshader = \"fill.comp\"\ndispatch = { threads = \"a\" }\nbind = { c = \"a\" }\n\
        [[passes]]\nname = \"second\"\nshader = \"fill.comp\"\ndispatch = { threads = \"b\" }\nbind = { c = \"b\" }\n";

    #[test]
    fn a_copy_is_of_what_was_shown_when_it_was_asked_for_or_is_given_up() {
        let folder = tempfile::tempdir().unwrap();
        let mut session = open(&folder, &[("graphs/two.toml", TWO), ("shaders/fill.comp", FILL)]);
        let mut inspector = Inspector::default();
        let frame = |inspector: &mut Inspector, session: &mut Session| {
            inspector.ask(session);
            let report = session.frame().unwrap();
            session.wait().unwrap();
            inspector.take(session, &report);
        };
        let shown = |session: &Session| panel_data::shown(session.debug_target(), session.graph());
        for (target, other) in [("a,after=first", "b"), ("b,after=second", "a")] {
            session.set_debug_target_text(target).unwrap();
            frame(&mut inspector, &mut session);
            // A frame has copied it when another target is shown.
            let asked = shown(&session);
            inspector.copy(CopiedFor::Keeping(1), asked.clone());
            inspector.generation = 7;
            frame(&mut inspector, &mut session);
            inspector.generation = 8;
            session.set_debug_target_text(other).unwrap();
            let copied = eventually(|| {
                frame(&mut inspector, &mut session);
                Some(inspector.copied()).filter(|copied| !copied.is_empty())
            });
            let [Copied { purpose, taken, generation, .. }] = &copied[..] else { panic!("{} copies", copied.len()) };
            assert_eq!((*purpose, &taken.shown, *generation), (CopiedFor::Keeping(1), &asked, 7));
            assert!(inspector.given_up().is_empty() && !inspector.is_copying());
            // No frame can copy it any more.
            session.set_debug_target_text(target).unwrap();
            inspector.copy(CopiedFor::Table, shown(&session));
            session.set_debug_target_text(other).unwrap();
            frame(&mut inspector, &mut session);
            assert_eq!(inspector.given_up(), [(CopiedFor::Table, asked.clone())]);
            // Another one of the same kind takes its place.
            for number in [2, 3] {
                inspector.copy(CopiedFor::Keeping(number), shown(&session));
            }
            assert_eq!(inspector.given_up(), [(CopiedFor::Keeping(2), shown(&session))]);
            let copied = eventually(|| {
                frame(&mut inspector, &mut session);
                Some(inspector.copied()).filter(|copied| !copied.is_empty())
            });
            assert_eq!(copied.iter().map(|copied| copied.purpose).collect::<Vec<_>>(), [CopiedFor::Keeping(3)]);
            // A wish while the copy for another one is on its way. Both get what was shown for them.
            let first = shown(&session);
            inspector.copy(CopiedFor::Keeping(4), first.clone());
            inspector.ask(&mut session);
            session.frame().unwrap();
            session.wait().unwrap();
            inspector.on_its_way = session.captured().map(|ticket| (first.clone(), ticket));
            inspector.copying[0].number = Some(inspector.given + 1);
            session.set_debug_target_text(target).unwrap();
            let second = shown(&session);
            inspector.copy(CopiedFor::Measuring, second.clone());
            assert!(inspector.on_its_way.is_some());
            let mut copied = Vec::new();
            eventually(|| {
                frame(&mut inspector, &mut session);
                copied.extend(inspector.copied());
                (copied.len() == 2).then_some(())
            });
            let copied: Vec<_> = copied.iter().map(|copied| (copied.purpose, copied.taken.shown.clone())).collect();
            assert_eq!(copied, [(CopiedFor::Keeping(4), first), (CopiedFor::Measuring, second)]);
        }
    }
}
