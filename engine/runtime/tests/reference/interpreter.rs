//! Runs a graph as docs/graph-file.md says, one texel after the other: no plan, nothing is left out, nothing shares memory.

use std::collections::BTreeMap;

use crate::model::{Every, Float, Graph, How, Int, Kind, Pass, Resource, Size};
use crate::shaders::mixed;

/// A number of seconds or of times a second: numerator and denominator.
pub(crate) type Exact = (u128, u128);

/// A decimal as it is written.
pub(crate) fn exact(decimal: &str) -> Exact {
    let (whole, part) = decimal.split_once('.').unwrap_or((decimal, ""));
    (format!("{whole}{part}").parse().expect("digits"), 10_u128.pow(part.len() as u32))
}

/// The inputs of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    pub output: [u32; 2],
    pub time: Exact,
    pub salt: u32,
    pub n: u32,
    pub flag: bool,
}

/// Each mip: width, height, texels.
type Image = Vec<(u32, u32, Vec<u32>)>;

/// The copies of a resource, the current one first.
struct Ring {
    declared: Resource,
    copies: Vec<Image>,
}

#[derive(Default)]
pub(crate) struct Machine {
    rings: BTreeMap<String, Ring>,
    index: u32,
    /// The whole of what a frame depends on besides time, as the last frame had it, and how long since it changed.
    last: Option<([u32; 2], u32, bool)>,
    still: u32,
    /// Frames since a history was cleared.
    held: u32,
    /// Of the clock: ticks that were due by the last frame, and ticks that have run.
    due_before: Option<u128>,
    run: u32,
    /// By pass: the tick of its last run.
    ran: BTreeMap<String, u128>,
}

/// The ticks that have become due by a time after the first.
fn ticks(time: Exact, hz: Exact) -> (u128, u128, u128) {
    let (above, below) = (time.0 * hz.0, time.1 * hz.1);
    (above / below, above % below, below)
}

impl Machine {
    /// Starts over.
    pub(crate) fn reset(&mut self) {
        *self = Machine::default();
    }

    /// The graph or a shader was edited: passes whose shader was edited run at once.
    pub(crate) fn edited(&mut self, shaders: bool) {
        self.last = None;
        if shaders {
            self.ran.clear();
        }
    }

    pub(crate) fn texels(&self, name: &str, age: usize, mip: usize) -> &(u32, u32, Vec<u32>) {
        &self.rings[name].copies[age][mip]
    }

    fn extents(graph: &Graph, resource: &Resource, output: [u32; 2]) -> Vec<[u32; 2]> {
        match &resource.kind {
            Kind::Words(words) => vec![[*words, 1]],
            Kind::Of(target) => {
                let [w, h] = Self::extents(graph, &graph.resources[*target], output)[0];
                vec![[w * h, 1]]
            }
            Kind::Target { size, mips } => {
                let [w, h] = match size {
                    Size::Output => output,
                    Size::Half => output.map(|side| side / 2),
                    Size::Fixed(size) => *size,
                };
                (0..*mips).map(|mip| [(w >> mip).max(1), (h >> mip).max(1)]).collect()
            }
        }
    }

    /// Makes resources that are missing, or whose size or declaration has changed. They start at `init`, or zero.
    fn allocate(&mut self, graph: &Graph, output: [u32; 2]) {
        for resource in &graph.resources {
            let extents = Self::extents(graph, resource, output);
            let same = |ring: &Ring| {
                let cleared = Resource { clear: resource.clear, ..ring.declared.clone() };
                cleared == *resource && ring.copies[0].iter().map(|mip| [mip.0, mip.1]).eq(extents.iter().copied())
            };
            if self.rings.get(&resource.name).is_some_and(same) {
                continue;
            }
            let fill = resource.init.unwrap_or(0);
            let mip = |[w, h]: &[u32; 2]| (*w, *h, vec![fill; (w * h) as usize]);
            let copy: Image = extents.iter().map(mip).collect();
            let ring = Ring { declared: resource.clone(), copies: vec![copy; resource.history + 1] };
            self.rings.insert(resource.name.clone(), ring);
            let written = graph.passes.iter().flat_map(|pass| &pass.writes);
            if resource.history > 0
                && written.into_iter().any(|write| graph.resources[write.resource].name == resource.name)
            {
                self.held = 0;
            }
        }
    }

    /// A turn of the frames or of the ticks: the oldest copy becomes the current one, and is cleared.
    fn turn(&mut self, graph: &Graph, clock: bool) {
        for resource in graph.resources.iter().filter(|resource| resource.clock == clock) {
            let ring = self.rings.get_mut(&resource.name).expect("it is allocated");
            ring.copies.rotate_right(1);
            if let Some(clear) = resource.clear {
                ring.copies[0].iter_mut().for_each(|mip| mip.2.fill(clear));
            }
        }
    }

    pub(crate) fn frame(&mut self, graph: &Graph, given: &Given) {
        let changing = (given.output, given.n, given.flag);
        self.still = if self.last == Some(changing) { self.still + 1 } else { 0 };
        self.last = Some(changing);
        self.allocate(graph, given.output);
        let written = |resource: &Resource| {
            let mut writes = graph.passes.iter().flat_map(|pass| &pass.writes);
            writes.any(|write| graph.resources[write.resource].name == resource.name)
        };
        let histories = graph.resources.iter().filter(|resource| written(resource)).map(|resource| resource.history);
        let valid = u32::from(self.held >= histories.max().unwrap_or(0).max(1) as u32);
        let mut due = 0;
        if let Some(clock) = &graph.clock {
            let (number, ..) = ticks(given.time, exact(clock.hz));
            due = self.due_before.map_or(1, |before| number.saturating_sub(before)).min(u128::from(clock.most)) as u32;
            self.due_before = Some(number);
        }
        self.turn(graph, false);
        let mut at = 0;
        while at < graph.passes.len() {
            let every = graph.passes[at].every;
            let alike = |pass: &&Pass| pass.every == Every::Clock || pass.in_loop;
            let together = graph.passes[at..].iter().take_while(alike).count();
            if every == Every::Clock {
                let count = graph.passes[at..].iter().take_while(|pass| pass.every == Every::Clock).count();
                for _ in 0..due {
                    self.turn(graph, true);
                    self.run += 1;
                    for pass in &graph.passes[at..at + count] {
                        self.pass(graph, given, pass, 0, valid);
                    }
                }
                at += count;
            } else if graph.passes[at].in_loop {
                let count = graph.passes[at..at + together].iter().take_while(|pass| pass.in_loop).count();
                for round in 0..graph.rounds {
                    for pass in &graph.passes[at..at + count] {
                        self.pass(graph, given, pass, round, valid);
                    }
                }
                at += count;
            } else {
                if self.is_due(&graph.passes[at], given) {
                    self.pass(graph, given, &graph.passes[at], 0, valid);
                }
                at += 1;
            }
        }
        self.index += 1;
        self.held += 1;
    }

    fn is_due(&mut self, pass: &Pass, given: &Given) -> bool {
        if pass.when.is_some_and(|when| when != given.flag) {
            return false;
        }
        match pass.every {
            Every::Frame | Every::Clock => true,
            Every::Frames(frames) => {
                let first = self.ran.insert(pass.name.clone(), 0).is_none();
                first || self.index.is_multiple_of(frames)
            }
            Every::Still(frames) => self.still < frames,
            Every::Hz(hz) => {
                let (number, ..) = ticks(given.time, exact(hz));
                self.ran.insert(pass.name.clone(), number) != Some(number)
            }
        }
    }

    fn pass(&mut self, graph: &Graph, given: &Given, pass: &Pass, round: u32, valid: u32) {
        let a = match pass.a {
            Int::Value(value) => value,
            Int::N => given.n,
            Int::FrameIndex => self.index,
            Int::FrameStill => self.still,
            Int::HistoryValid => valid,
            Int::Tick => self.run.saturating_sub(1),
            Int::LoopIndex => round,
        };
        let hz = graph.clock.as_ref().map_or((1, 1), |clock| exact(clock.hz));
        let b = match pass.b {
            Float::Value(value) => value,
            Float::Time => (given.time.0 as f64 / given.time.1 as f64) as f32,
            Float::Phase => {
                let (_, above, below) = ticks(given.time, hz);
                (above as f64 / below as f64) as f32
            }
            Float::Delta => (hz.1 as f64 / hz.0 as f64) as f32,
        };
        let h = |h, x| mixed(given.salt, h, x);
        let mut stored: Vec<(usize, usize, Vec<u32>)> = Vec::new();
        for (slot, write) in pass.writes.iter().enumerate() {
            let mut texels = self.texels(&graph.resources[write.resource].name, 0, write.mip).2.clone();
            let step = if write.how == How::Part { 2 } else { 1 };
            for at in (0..texels.len()).step_by(step) {
                let mut value = h(h(h(pass.k.wrapping_add(slot as u32), a), b.to_bits()), at as u32);
                if let Some(own) = pass.common {
                    value = h(h(value, own.u.unwrap_or(graph.common)), given.n);
                }
                for read in &pass.reads {
                    let from = &self.texels(&graph.resources[read.resource].name, read.age, read.mip).2;
                    value = h(value, from[at % from.len()]);
                }
                if write.how == How::Change {
                    value = h(value, texels[at]);
                }
                texels[at] = value;
            }
            stored.push((write.resource, write.mip, texels));
        }
        for (resource, mip, texels) in stored {
            let ring = self.rings.get_mut(&graph.resources[resource].name).expect("it is allocated");
            ring.copies[0][mip].2 = texels;
        }
    }
}
