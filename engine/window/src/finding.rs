//! The search for a value in all slices of the shown target: one slice a frame is copied, and another thread looks at it.

use std::collections::VecDeque;
use std::sync::Arc;

use raxel_execute::{Captured, ReadTicket};
use raxel_panels::view::{Looking, Shown};
use raxel_picture::{Place, Search, Sought};
use raxel_runtime::Session;

use super::panel_data;

/// Slices that are on their way at most.
const AHEAD: usize = 3;

/// What a user looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// The value.
    pub sought: Sought,
    /// The channel.
    pub channel: u32,
    /// The next one, else the one before.
    pub forward: bool,
}

/// A search that is under way.
pub(crate) struct Finding {
    wanted: Wanted,
    /// What was shown when it began.
    origin: Shown,
    /// What it shows, if a slice is written only while it is shown.
    showing: Option<Shown>,
    slices: Vec<Slice>,
    /// As it began: it has the order of the slices.
    order: Search,
    /// As far as it has come; `None` while the other thread has it.
    search: Option<Search>,
    /// Slices that were looked at.
    looked: usize,
    /// Slices whose copy was asked for.
    asked: usize,
    /// The frame that runs brings a copy.
    due: bool,
    copies: VecDeque<Source>,
    number: u64,
}

#[derive(Clone, Copy)]
struct Slice {
    mip: u32,
    layer: u32,
    extent: [u32; 2],
}

/// A copy of a slice.
enum Source {
    /// It is known already.
    Known(Arc<Captured>),
    /// It comes from the device.
    Coming(ReadTicket<Captured>),
}

/// A slice that the other thread looks at.
pub(crate) struct Look {
    search: Search,
    source: Source,
    channel: u32,
    number: u64,
}

/// A slice that was looked at.
pub(crate) struct Looked {
    /// `None` if the copy was lost with its device.
    search: Option<Search>,
    number: u64,
}

/// How a search ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// A value was found.
    Found {
        /// The slice that has it.
        shown: Shown,
        /// Its texel.
        texel: [u32; 2],
        /// Extent of the slice.
        extent: [u32; 2],
    },
    /// No value is as wanted.
    Nothing {
        /// What was wanted.
        sought: Sought,
        /// Slices of the target.
        slices: usize,
    },
    /// The target cannot be copied any more.
    Lost,
}

impl Finding {
    /// A search from the shown slice on, whose copy is known; from a texel on if one is given. `number` tells one search from another.
    pub(crate) fn new(
        session: &Session,
        (shown, copy): (&Shown, &Arc<Captured>),
        wanted: Wanted,
        from: Option<[u32; 2]>,
        number: u64,
    ) -> Option<Self> {
        let (graph, plan) = (session.graph(), session.plan()?);
        let size = plan.sizes.get(graph.find_resource(&shown.resource)?.0 as usize)?;
        let slice = |[mip, layer]: [u32; 2]| {
            let [width, height, _] = size.texels(mip)?;
            Some(Slice { mip, layer, extent: [width, height] })
        };
        let slices: Vec<Slice> = size.slices().filter_map(slice).collect();
        let start = slices.iter().position(|slice| (slice.mip, slice.layer) == (shown.mip, shown.layer))?;
        let from = from.map(|[x, y]| y as usize * slices[start].extent[0] as usize + x as usize);
        let order = Search::new(wanted.sought, wanted.forward, slices.len(), start, from);
        Some(Self {
            wanted,
            origin: shown.clone(),
            showing: None,
            slices,
            search: Some(order.clone()),
            order,
            looked: 0,
            asked: 1,
            due: false,
            copies: VecDeque::from([Source::Known(copy.clone())]),
            number,
        })
    }

    /// Whether what is shown is still what is searched.
    pub(crate) fn is_of(&self, shown: &Shown) -> bool {
        self.showing.as_ref().unwrap_or(&self.origin) == shown
    }

    /// The target to go back to, if the search shows another part of it.
    pub(crate) fn gone_from(&self) -> Option<&Shown> {
        self.showing.as_ref().and(Some(&self.origin))
    }

    /// The panel's view.
    pub(crate) fn view(&self) -> Looking {
        Looking { sought: self.wanted.sought, looked: self.looked, slices: self.slices.len() }
    }

    /// Before a frame: asks for a copy of the next slice.
    pub(crate) fn ask(&mut self, session: &mut Session) {
        if self.copies.len() >= AHEAD {
            return;
        }
        let Some(slice) = self.order.upcoming(self.asked).map(|index| self.slices[index]) else { return };
        let shown = self.shown(slice);
        if self.is_of(&shown) {
            session.capture_shown(0..u64::MAX);
        } else if !session.capture_part(slice.mip, slice.layer) {
            // The running plan leaves out what writes this slice, so it has to be shown.
            if session.set_debug_target(panel_data::debug_target(&shown)).is_err() {
                return;
            }
            session.capture_shown(0..u64::MAX);
            self.showing = Some(shown);
        }
        (self.due, self.asked) = (true, self.asked + 1);
    }

    /// After a frame: takes the copy that it has made. False if it has made none.
    pub(crate) fn take(&mut self, session: &mut Session) -> bool {
        if !std::mem::take(&mut self.due) {
            return true;
        }
        let ticket = session.captured();
        let taken = ticket.is_some();
        self.copies.extend(ticket.map(Source::Coming));
        taken
    }

    /// The next slice for the other thread, once its copy is there.
    pub(crate) fn hand_over(&mut self) -> Option<Look> {
        let arrived = match self.copies.front()? {
            Source::Known(_) => true,
            // The other thread reports the loss of a device.
            Source::Coming(ticket) => ticket.has_arrived().unwrap_or(true),
        };
        if !arrived {
            return None;
        }
        let search = self.search.take()?;
        let source = self.copies.pop_front()?;
        Some(Look { search, source, channel: self.wanted.channel, number: self.number })
    }

    /// Takes a slice that was looked at. Gives the end of the search.
    pub(crate) fn looked(&mut self, looked: Looked) -> Option<Ended> {
        if looked.number != self.number {
            return None;
        }
        let Some(search) = looked.search else { return Some(Ended::Lost) };
        [self.looked, _] = search.progress();
        let (goes_on, found) = (search.slice().is_some(), search.found());
        self.search = Some(search);
        (!goes_on).then(|| self.ended(found))
    }

    fn ended(&self, found: Option<Place>) -> Ended {
        let Some(Place { slice, index }) = found else {
            return Ended::Nothing { sought: self.wanted.sought, slices: self.slices.len() };
        };
        let slice = self.slices[slice];
        let width = slice.extent[0].max(1) as usize;
        let texel = [index % width, index / width].map(|place| u32::try_from(place).unwrap_or(u32::MAX));
        Ended::Found { shown: self.shown(slice), texel, extent: slice.extent }
    }

    fn shown(&self, slice: Slice) -> Shown {
        Shown { mip: slice.mip, layer: slice.layer, ..self.origin.clone() }
    }
}

impl Look {
    /// Looks at the slice.
    pub(crate) fn run(self) -> Looked {
        let Self { mut search, source, channel, number } = self;
        let captured = match source {
            Source::Known(captured) => captured,
            Source::Coming(ticket) => match ticket.poll() {
                Ok(Some(captured)) => Arc::new(captured),
                Ok(None) | Err(_) => return Looked { search: None, number },
            },
        };
        let Captured::Texels(texels) = &*captured else { return Looked { search: None, number } };
        search.look(&texels.channel(channel));
        Looked { search: Some(search), number }
    }
}

#[cfg(test)]
mod tests {
    use raxel_execute::Region;

    use super::*;
    use crate::inspector::Inspector;
    use crate::panel_data::debug_target;
    use crate::panel_data::tests::{FILL, eventually, open};

    /// A frame of a window with *Inspect* open.
    fn inspect(inspector: &mut Inspector, session: &mut Session) {
        inspector.ask(session);
        let report = session.frame().unwrap();
        session.wait().unwrap();
        inspector.take(session, &report);
    }

    /// Texels with their number, NaN in a texel of slices 1 and 3, and in mip 1, which the shown mip does not need.
    const FOG: &str = "#version 460\nlayout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;\n\
        layout(r32f) writeonly uniform image3D c;\nlayout(push_constant) uniform PC { uint mip; } pc;\n\
        void main() { ivec3 at = ivec3(gl_GlobalInvocationID); bool odd = pc.mip == 0u ? at == ivec3(1, 2, 1) || at == ivec3(3, 0, 3) : at == ivec3(1, 0, 1);\n\
        imageStore(c, at, vec4(odd ? uintBitsToFloat(0x7fc00000u) : float(at.x + 4 * at.y + 16 * at.z) - 9.0 * pc.mip)); }\n";

    #[test]
    fn a_value_is_found_in_all_slices_also_in_those_that_run_only_while_they_are_shown() {
        let folder = tempfile::tempdir().unwrap();
        let pass = |mip: u32| {
            format!(
                "[[passes]]\nname = \"mip{mip}\"\nshader = \"fog.comp\"\ndispatch = {{ threads = \"fog\", mip = {mip} }}\n\
                 bind = {{ c = {{ target = \"fog\", mip = {mip} }} }}\npush = {{ mip = {mip} }}\n"
            )
        };
        let head = "name = \"fog\"\npresent = \"fog\"\n[targets.fog]\nformat = \"r32f\"\nsize = [4, 4, 4]\nmips = 2\n";
        let graph = format!("{head}{}{}", pass(0), pass(1));
        let mut session = open(&folder, &[("graphs/fog.toml", &graph), ("shaders/fog.comp", FOG)]);
        let mut inspector = Inspector::default();
        eventually(|| {
            inspect(&mut inspector, &mut session);
            inspector.view(&session, &[], None, &Region::WHOLE).map(drop)
        });
        let find = |inspector: &mut Inspector, session: &mut Session, sought, forward| {
            inspector.find(session, Wanted { sought, channel: 0, forward });
            let ended = eventually(|| {
                inspect(inspector, session);
                inspector.ended()
            });
            // As the window does.
            if let Ended::Found { shown, .. } = &ended {
                session.set_debug_target(debug_target(shown)).unwrap();
                eventually(|| {
                    inspect(inspector, session);
                    inspector.view(session, &[], None, &Region::WHOLE).filter(|seen| seen.shown == *shown).map(drop)
                });
            }
            match ended {
                Ended::Found { shown, texel: [x, y], .. } => Ok([shown.mip, shown.layer, x, y]),
                ended => Err(ended),
            }
        };
        let mut nan = |forward| find(&mut inspector, &mut session, Sought::Nan, forward);
        assert_eq!(
            [nan(true), nan(true), nan(true), nan(true)],
            [[0, 1, 1, 2], [0, 3, 3, 0], [1, 1, 1, 0], [0, 1, 1, 2]].map(Ok)
        );
        assert_eq!(nan(false), Ok([1, 1, 1, 0]));
        assert_eq!(find(&mut inspector, &mut session, Sought::Smallest, true), Ok([1, 0, 0, 0]));
        assert_eq!(inspector.pinned().map(|pin| (pin.number, pin.texel)), Some((1, [0, 0])), "one pin has gone along");
        // Nothing is found: what was shown is shown again.
        session.set_debug_target_text("fog,layer=2").unwrap();
        eventually(|| {
            inspect(&mut inspector, &mut session);
            inspector.view(&session, &[], None, &Region::WHOLE).filter(|seen| seen.shown.layer == 2).map(drop)
        });
        let shown = session.debug_target().clone();
        let nothing = find(&mut inspector, &mut session, Sought::Infinite, true);
        assert_eq!(nothing, Err(Ended::Nothing { sought: Sought::Infinite, slices: 6 }));
        assert_eq!(*session.debug_target(), shown);
        // The user shows something else, or stops it: it has no end.
        for stopped in [true, false] {
            inspector.find(&mut session, Wanted { sought: Sought::Largest, channel: 0, forward: true });
            assert!(inspector.view(&session, &[], None, &Region::WHOLE).unwrap().looking.is_some());
            if stopped {
                inspector.stop(&mut session);
            } else {
                session.set_debug_target_text("fog,layer=3").unwrap();
            }
            for _ in 0..20 {
                inspect(&mut inspector, &mut session);
            }
            assert_eq!(inspector.ended(), None);
            let seen = inspector.view(&session, &[], None, &Region::WHOLE);
            assert!(seen.is_none_or(|seen| seen.looking.is_none()));
        }
    }

    #[test]
    fn a_large_target_is_inspected_beside_the_frames() {
        let folder = tempfile::tempdir().unwrap();
        let wide = "name = \"wide\"\npresent = \"wide\"\n[targets.wide]\nformat = \"rgba32f\"\nsize = [1920, 1080]\n\
            [[passes]]\nname = \"first\"\nshader = \"wide.comp\"\ndispatch = { threads = \"wide\" }\nbind = { c = \"wide\" }\n\
            push = { frame = \"frame.index\" }\n";
        let fill = FILL
            .replace("r32f", "rgba32f")
            .replace("void main", "layout(push_constant) uniform PC { uint frame; } pc;\nvoid main");
        let fill = fill
            .replace("vec4(0.5)", "vec4(pc.frame, at.x, at.y, 1.0)")
            .replace("void main() {", "void main() { vec2 at = gl_GlobalInvocationID.xy;");
        let mut session = open(&folder, &[("graphs/wide.toml", wide), ("shaders/wide.comp", &fill)]);
        let (mut inspector, mut longest, mut known) = (Inspector::default(), std::time::Duration::ZERO, Vec::new());
        eventually(|| {
            let began = std::time::Instant::now();
            inspector.ask(&mut session);
            let mut took = began.elapsed();
            let report = session.frame().unwrap();
            session.wait().unwrap();
            let began = std::time::Instant::now();
            inspector.take(&mut session, &report);
            let seen = inspector.view(&session, &[], Some([4, 4]), &Region::WHOLE);
            took += began.elapsed();
            longest = longest.max(took);
            let numbers = seen.and_then(|seen| seen.statistics.as_ref())?;
            assert_eq!((numbers.count, numbers.nan), (1920 * 1080, 0));
            if known.last() != Some(&numbers.range[0]) {
                known.push(numbers.range[0]);
            }
            (known.len() == 4).then_some(())
        });
        let numbers = inspector.cost();
        println!("the longest frame took {longest:?} for the panel, and numbers {numbers:?} on their thread");
        assert!(longest * 4 < numbers, "{longest:?} of a frame, while numbers take {numbers:?}");
    }
}
