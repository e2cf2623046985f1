//! Numbers of targets: the statistics of a slice, and the place of a value in all slices.

use std::collections::VecDeque;
use std::sync::Arc;

use raxel_execute::Texels;
use raxel_picture::{Place, Search, Sought, Statistics};
use raxel_runtime::Session;
use raxel_runtime::debug_target::DebugTarget;
use serde_json::{Value, json};

use super::later::Later;
use super::read::{self, Middle};
use super::refusal::Refusal;
use super::request::{Find, Found};

/// Slices that are copied ahead of the one that is looked at.
const AHEAD: usize = 3;

/// Statistics of each channel of a slice.
pub(super) fn statistics(
    session: &mut Session,
    target: &DebugTarget,
    middle: Option<&Middle>,
) -> Result<Later<Value>, Refusal> {
    read::of_texels(session, target, middle, |texels| {
        let of = |channel| {
            let found = Statistics::of(texels.channel(channel).into_iter())?;
            let [smallest, largest] = found.range;
            Some(json!({
                "count": found.count, "nan": found.nan, "infinite": found.infinite,
                "smallest": smallest, "largest": largest, "mean": found.mean,
                "percentiles": found.percentiles, "histogram": found.histogram.as_slice(),
            }))
        };
        let channels: Vec<Value> = (0..texels.format.channels()).filter_map(of).collect();
        Ok(json!({
            "width": texels.width, "height": texels.height, "format": texels.format.name(), "channels": channels,
        }))
    })
}

/// A search for the next texel with a value, in one slice of a target or in all. A few slices are copied ahead, and another thread looks at one.
pub(super) struct Finding {
    wanted: Find,
    middle: Option<Middle>,
    slices: Vec<[u32; 2]>,
    /// As it began: it has the order of the slices.
    order: Search,
    /// Slices that were asked for.
    asked: usize,
    copies: VecDeque<Later<Arc<Texels>>>,
    /// The search, while no thread has it.
    search: Option<Search>,
    looking: Option<Later<Looked>>,
    /// The texel that it ends with, if no other slice has a better one.
    hit: Option<Hit>,
}

/// A slice that was looked at.
struct Looked {
    search: Search,
    /// The texel of this slice that the search has found, if it has.
    hit: Option<Hit>,
}

/// A texel that was found.
struct Hit {
    at: Place,
    texel: [u32; 2],
    /// Its values in the frame in which it was found.
    values: Value,
}

impl Finding {
    pub(crate) fn new(session: &Session, wanted: Find, middle: Option<Middle>) -> Result<Self, Refusal> {
        let sought = sought(&wanted.value)?;
        let slices = slices(session, &wanted)?;
        let (start, from) = begin(session, &wanted, &slices)?;
        let order = Search::new(sought, wanted.forward, slices.len(), start, from);
        Ok(Self {
            wanted,
            middle,
            slices,
            search: Some(order.clone()),
            order,
            asked: 0,
            copies: VecDeque::new(),
            looking: None,
            hit: None,
        })
    }

    /// The answer, once it is there. Never waits.
    pub(crate) fn poll(&mut self, session: &mut Session) -> Option<Result<Value, Refusal>> {
        self.step(session, |_, later| later.poll(), |_, later| later.poll()).transpose()
    }

    /// The answer, which is found at once: where no frame waits for it.
    pub(crate) fn finish(mut self, session: &mut Session) -> Result<Value, Refusal> {
        loop {
            let at_once = self.step(session, |on, later| Some(later.finish(on)), |on, later| Some(later.finish(on)))?;
            if let Some(answer) = at_once {
                return Ok(answer);
            }
        }
    }

    /// Goes on as far as copies and looks are there. They are taken by two functions, which may wait.
    fn step(
        &mut self,
        session: &mut Session,
        mut copied: impl FnMut(&Session, &mut Later<Arc<Texels>>) -> Option<Result<Arc<Texels>, Refusal>>,
        mut looked: impl FnMut(&Session, &mut Later<Looked>) -> Option<Result<Looked, Refusal>>,
    ) -> Result<Option<Value>, Refusal> {
        loop {
            if let Some(looking) = &mut self.looking {
                let Some(found) = looked(session, looking) else { return Ok(None) };
                let Looked { search, hit } = found?;
                (self.looking, self.search) = (None, Some(search));
                self.hit = hit.or(self.hit.take());
            }
            let Some(search) = &self.search else { return Ok(None) };
            if search.slice().is_none() {
                return Ok(Some(self.answer()));
            }
            self.ask(session)?;
            let Some(copy) = self.copies.front_mut() else { return Ok(None) };
            let Some(texels) = copied(session, copy) else { return Ok(None) };
            self.copies.pop_front();
            self.look(texels?);
        }
    }

    /// Asks for copies of the next slices.
    fn ask(&mut self, session: &mut Session) -> Result<(), Refusal> {
        while self.copies.len() < AHEAD
            && let Some(slice) = self.order.upcoming(self.asked)
        {
            let [mip, layer] = self.slices[slice];
            let Find { target, age, after, .. } = &self.wanted;
            let target = DebugTarget { resource: target.clone(), age: *age, mip, layer, after: after.clone() };
            match read::of_texels(session, &target, self.middle.as_ref(), Ok) {
                Ok(copy) => self.copies.push_back(copy),
                // There is no room for one more copy on its way.
                Err(_) if !self.copies.is_empty() => return Ok(()),
                Err(refusal) => return Err(refusal),
            }
            self.asked += 1;
        }
        Ok(())
    }

    /// Lets another thread look at a slice.
    fn look(&mut self, texels: Arc<Texels>) {
        let Some(mut search) = self.search.take() else { return };
        let (name, channel) = (self.wanted.target.clone(), self.wanted.channel);
        self.looking = Some(Later::beside(move || {
            let channels = texels.format.channels();
            if channel >= channels {
                return Err(Refusal::new(format!("`{name}` has the channels 0 to {}; got {channel}", channels - 1)));
            }
            let slice = search.slice();
            search.look(&texels.channel(channel));
            let hit = search.found().filter(|at| Some(at.slice) == slice).map(|at| {
                let texel = place(&texels, at.index);
                Hit { at, texel, values: read::values(&texels, texel) }
            });
            Ok(Looked { search, hit })
        }));
    }

    fn answer(&mut self) -> Value {
        let looked = self.search.as_ref().map_or(0, |search| search.progress()[0]);
        let Some(Hit { at, texel: [x, y], values: mut answer }) = self.hit.take() else {
            return json!({ "found": null, "slices": looked });
        };
        let [mip, layer] = self.slices[at.slice];
        answer["found"] = json!({ "mip": mip, "layer": layer, "x": x, "y": y });
        answer["slices"] = looked.into();
        answer
    }
}

fn sought(word: &str) -> Result<Sought, Refusal> {
    let found = Sought::ALL.into_iter().find(|sought| sought.word().eq_ignore_ascii_case(word));
    found.ok_or_else(|| {
        let words = Sought::ALL.map(|sought| format!("`{}`", sought.word().to_lowercase())).join(", ");
        Refusal::new(format!("`value` must be one of {words}; got `{word}`"))
    })
}

/// Mip and layer of the slices that are looked at.
fn slices(session: &Session, find: &Find) -> Result<Vec<[u32; 2]>, Refusal> {
    let name = &find.target;
    // Of the output of a pass, the last frame has a copy of one slice alone.
    if find.after.is_some() {
        return Ok(vec![[find.mip.unwrap_or(0), find.layer.unwrap_or(0)]]);
    }
    let target = DebugTarget { resource: name.clone(), age: find.age, ..DebugTarget::default() };
    let resource = target.resolve(session.graph())?.resource;
    let size = session.plan().and_then(|plan| plan.sizes.get(resource.0 as usize));
    let Some(size) = size else {
        return Err(Refusal::new(format!("`{name}` has no size yet: run a frame with `step`")));
    };
    let wanted = |&[mip, layer]: &[u32; 2]| {
        find.mip.is_none_or(|wanted| wanted == mip) && find.layer.is_none_or(|wanted| wanted == layer)
    };
    let slices: Vec<[u32; 2]> = size.slices().filter(wanted).collect();
    if size.slices().next().is_none() {
        return Err(Refusal::new(format!("`{name}` is a buffer: only targets have texels")));
    }
    if slices.is_empty() {
        let part = |word: &str, part: Option<u32>| part.map_or(String::new(), |part| format!(" {word} {part}"));
        let (mip, layer) = (part("mip", find.mip), part("layer", find.layer));
        return Err(Refusal::new(format!("`{name}` has no{mip}{layer}")));
    }
    Ok(slices)
}

/// The slice and the texel after which the search begins.
fn begin(session: &Session, find: &Find, slices: &[[u32; 2]]) -> Result<(usize, Option<usize>), Refusal> {
    let Some(Found { mip, layer, x, y }) = find.from else {
        // The first of all, or the last.
        return Ok((if find.forward { 0 } else { slices.len() - 1 }, None));
    };
    let slice = slices.iter().position(|slice| *slice == [mip, layer]);
    let resource = session.graph().find_resource(&find.target);
    let sizes = session.plan().map(|plan| &plan.sizes);
    let size = resource.zip(sizes).and_then(|(resource, sizes)| sizes.get(resource.0 as usize)?.texels(mip));
    match (slice, size) {
        (Some(slice), Some([width, height, _])) if x < width && y < height => {
            Ok((slice, Some(y as usize * width as usize + x as usize)))
        }
        _ => Err(Refusal::new(format!("`from` is no texel that is searched: mip {mip}, layer {layer}, {x}, {y}"))),
    }
}

fn place(texels: &Texels, index: usize) -> [u32; 2] {
    let width = texels.width.max(1) as usize;
    [index % width, index / width].map(|place| u32::try_from(place).unwrap_or(u32::MAX))
}
