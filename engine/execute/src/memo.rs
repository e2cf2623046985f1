//! Skips passes that need not run again. A frame whose results are all in place dispatches nothing. In any other frame, only the
//! passes that lead to a missing result run.
//!
//! Each mip of each physical copy of a resource has the id of its content: a hash of the pass that made it, the pushed bytes, and the ids
//! of everything that the pass read. At the start of a frame the memo computes the ids that a full frame would leave behind. A copy whose
//! ids would change is *dirty*; so is a copy whose content in place differs from the one that a running pass reads. Every writer of a dirty
//! copy runs, and nothing else does: a copy is rewritten from its first writer on, or left alone.
//!
//! Two facts about a plan carry the argument. First, a `writeonly` binding writes everything that is read later; transient resources
//! share memory by the same rule. Second, a pass is a function of its inputs. A pass that breaks the latter on purpose (a race won by
//! chance) is shown as it came out last. Aliased resources never count as in place: their memory is another's when the frame ends.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use raxel_graph::checked::{Clear, ClockId, Interval};
use raxel_graph::plan::{CopySelector, Lifetime, Plan, ResourceDesc, Step};
use raxel_shader::interface::Access;

use super::digest::{self, Digest};
use super::ticks::Ticks;

/// Content of one mip of one copy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Content {
    /// Equal ids, equal texels.
    id: Digest,
    /// Digest of the run that made it, without the contents before: the same run over its own result changes nothing.
    run: Digest,
}

/// A resource as the memo sees it.
#[derive(Clone, Debug)]
struct Slot {
    /// Index of (copy 0, mip 0) in `Memo::content`; copies follow each other, mips within them.
    first: usize,
    copies: u32,
    mips: u32,
    /// Shares memory: its contents are lost when the frame ends.
    aliased: bool,
    /// Its contents at the start of a frame are never read.
    transient: bool,
}

/// One access of one step.
#[derive(Clone, Copy, Debug)]
struct SlotAccess {
    slot: u32,
    age: u32,
    selector: CopySelector,
    /// Index in `Memo::content` of mip 0 of the copy that it is about in this frame.
    base: usize,
    mips: (u32, u32),
    /// All layers of the mips.
    whole: bool,
    reads: bool,
    writes: bool,
    /// If it reads: index in `Memo::seen` of the id of its first mip.
    seen: usize,
}

/// A step that makes something out of something.
#[derive(Clone, Debug)]
struct Node {
    step: u32,
    /// The tick that it belongs to: it runs when at least that many are due.
    tick: Option<(ClockId, u32)>,
    maker: Maker,
    accesses: Vec<SlotAccess>,
    /// Its inputs in `Memo::seen`: its key, then the ids of all that it reads.
    seen: Range<usize>,
}

/// The source of the part of a node's key that is not an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Maker {
    Clear(Digest),
    /// Index of the resource.
    Copy(u32),
    /// The number of the pass in the plan, and in the graph: a pass of a clock makes the same in every tick.
    Pass {
        pass: u32,
        salt: u32,
    },
    Present,
}

/// Decides for each frame which steps run.
#[derive(Clone, Debug)]
pub(crate) struct Memo {
    slots: Vec<Slot>,
    nodes: Vec<Node>,
    /// In place now, by slot, copy, mip. The last one is the shown picture.
    content: Vec<Content>,
    /// The contents after a full frame.
    wanted: Vec<Content>,
    /// By slot and copy, as indices into `content` of their mip 0.
    dirty: Vec<bool>,
    /// By node: its key, and the ids of the mips that it reads. In one row, so that it is hashed as it lies there.
    seen: Vec<Digest>,
    /// By node: whether it may run in this frame.
    active: Vec<bool>,
    run: Vec<bool>,
    /// By resource: the version of its source that a copy is to be filled with.
    copies: Vec<Option<u64>>,
    /// By pass of the plan: the digest of its newest run, with all that it read. 0 before the first.
    runs: Vec<Digest>,
    /// Passes of the plan that run in the next frame even if all that they make is in place.
    forced: Vec<usize>,
    fresh: u64,
}

static FRESH: AtomicU64 = AtomicU64::new(1 << 32);

/// The contents of a transient resource at the start of a frame.
const UNDEFINED: Content = Content { id: 0x75_6e64_6566, run: 0 };

/// Tags in the upper half of ids that are counted instead of hashed.
const MADE_UP: Digest = 0xf0 << 64;
const SUPPLIED: Digest = 0x50 << 64;

impl Memo {
    /// For a plan whose resources have only their `init` contents.
    #[expect(clippy::cast_possible_truncation, reason = "a plan numbers its steps and resources in 32 bits")]
    pub(crate) fn new(plan: &Plan) -> Memo {
        let index_of = |resource| plan.resources.iter().position(|r| r.resource == resource);
        let mut memo = Memo::empty(plan.steps.len());
        for resource in &plan.resources {
            let mips = match &resource.desc {
                ResourceDesc::Image(image) | ResourceDesc::SourceImage(_, image) => image.mips,
                ResourceDesc::Buffer(_) | ResourceDesc::Source(_) => 1,
            };
            let (aliased, transient) = match resource.lifetime {
                Lifetime::Persistent => (false, false),
                Lifetime::Transient { place, .. } => (place.is_some(), true),
            };
            memo.slot(resource.copies, mips, aliased, transient);
        }
        for (step, kind) in plan.steps.iter().enumerate() {
            let slot_access = |resource, age, part: Interval, layers: Interval, access: Access| {
                let slot = index_of(resource)? as u32;
                let mips = memo.slots[slot as usize].mips;
                let first = part.first.min(mips - 1);
                let count = if part.count == 0 { mips - first } else { part.count.min(mips - first) };
                let selector = plan.selector(step, resource);
                let (reads, writes) = (access.reads(), access.writes());
                let whole = match &plan.resources[slot as usize].desc {
                    ResourceDesc::Image(image) => layers.first == 0 && [0, image.layers].contains(&layers.count),
                    _ => true,
                };
                Some(SlotAccess { slot, age, selector, base: 0, mips: (first, count), whole, reads, writes, seen: 0 })
            };
            let (maker, accesses): (_, Vec<SlotAccess>) = match kind {
                Step::Barrier(_) => continue,
                Step::Clear { resource, .. } => {
                    let resource = &plan.resources[*resource as usize];
                    let value = digest::of_value(0, &resource.clear.map(Clear::bits));
                    (
                        Maker::Clear(value),
                        slot_access(resource.resource, 0, Interval::ALL, Interval::ALL, Access::Write)
                            .into_iter()
                            .collect(),
                    )
                }
                Step::Copy { resource } => {
                    let copy = plan.resources[*resource as usize].resource;
                    (
                        Maker::Copy(*resource),
                        slot_access(copy, 0, Interval::ALL, Interval::ALL, Access::Write).into_iter().collect(),
                    )
                }
                Step::Dispatch { pass } => {
                    let declared = &plan.graph.pass(plan.passes[*pass as usize].pass).accesses;
                    let accesses =
                        declared.iter().filter_map(|a| slot_access(a.resource, a.age, a.mips, a.layers, a.access));
                    (Maker::Pass { pass: *pass, salt: plan.passes[*pass as usize].pass.0 }, accesses.collect())
                }
                Step::Present => {
                    let shown = plan.present;
                    (
                        Maker::Present,
                        slot_access(shown.resource, shown.age, Interval::one(shown.mip), Interval::ALL, Access::Read)
                            .into_iter()
                            .collect(),
                    )
                }
            };
            let tick = plan.clock_of(step).zip(plan.tick_of(step));
            memo.node(step as u32, tick, maker, accesses);
        }
        memo.finish();
        memo.runs = vec![0; plan.passes.len()];
        memo
    }

    fn empty(steps: usize) -> Memo {
        Memo {
            slots: Vec::new(),
            nodes: Vec::new(),
            content: Vec::new(),
            wanted: Vec::new(),
            dirty: Vec::new(),
            seen: Vec::new(),
            active: Vec::new(),
            run: vec![true; steps],
            copies: Vec::new(),
            runs: Vec::new(),
            forced: Vec::new(),
            // Made-up ids differ between memos, since a swap carries contents from one to the next.
            fresh: FRESH.fetch_add(1 << 32, Ordering::Relaxed),
        }
    }

    fn slot(&mut self, copies: u32, mips: u32, aliased: bool, transient: bool) {
        let first = self.slots.last().map_or(0, |s| s.first + (s.copies * s.mips) as usize);
        self.slots.push(Slot { first, copies, mips, aliased, transient });
    }

    fn node(&mut self, step: u32, tick: Option<(ClockId, u32)>, maker: Maker, mut accesses: Vec<SlotAccess>) {
        let key = self.nodes.last().map_or(0, |node| node.seen.end);
        let mut end = key + 1;
        for access in accesses.iter_mut().filter(|access| access.reads) {
            access.seen = end;
            end += access.mips.1 as usize;
        }
        self.nodes.push(Node { step, tick, maker, accesses, seen: key..end });
    }

    fn finish(&mut self) {
        let contents = self.slots.last().map_or(0, |s| s.first + (s.copies * s.mips) as usize) + 1;
        self.content = vec![Content::default(); contents];
        self.wanted = self.content.clone();
        self.dirty = vec![false; contents];
        self.copies = vec![None; self.slots.len()];
        self.seen = vec![0; self.nodes.last().map_or(0, |node| node.seen.end)];
        self.active = vec![false; self.nodes.len()];
        self.forget();
    }

    /// Forgets the contents in place: the next frame runs in full. For a reset, and for a frame that failed halfway.
    pub(crate) fn forget(&mut self) {
        for content in &mut self.content {
            self.fresh += 1;
            *content = Content { id: MADE_UP | Digest::from(self.fresh), run: 0 };
        }
    }

    /// Takes over the entries of `old` for a resource that keeps its contents across a swap of plans.
    pub(crate) fn carry(&mut self, slot: usize, old: &Memo, old_slot: usize) {
        let (to, from) = (&self.slots[slot], &old.slots[old_slot]);
        if (to.copies, to.mips) == (from.copies, from.mips) && !to.aliased && !from.aliased {
            let count = (to.copies * to.mips) as usize;
            self.content[to.first..to.first + count].copy_from_slice(&old.content[from.first..from.first + count]);
        }
    }

    /// Sets the version of its source with which a copy (index of its resource) is filled in the next frame, or that it is not filled.
    pub(crate) fn fill_copy(&mut self, resource: usize, version: Option<u64>) {
        self.copies[resource] = version;
    }

    /// The version that a copy is to be filled with in the frame that was decided.
    pub(crate) fn copy_due(&self, resource: usize) -> Option<u64> {
        self.copies[resource]
    }

    /// By pass of the plan: a digest that identifies its newest run. A repetition of the same run has the same digest.
    pub(super) fn runs(&self) -> &[Digest] {
        &self.runs
    }

    /// Makes these passes of the plan run in the next frame, if they are due, even if all that they make is in place.
    pub(crate) fn force(&mut self, passes: impl Iterator<Item = usize>) {
        self.forced.clear();
        self.forced.extend(passes);
    }

    /// Says which content a resource has that the runtime supplies (a source): equal ids, equal bytes.
    pub(crate) fn supply(&mut self, slot: usize, id: u64) {
        let slot = &self.slots[slot];
        for content in &mut self.content[slot.first..slot.first + (slot.copies * slot.mips) as usize] {
            *content = Content { id: SUPPLIED | Digest::from(id), run: 0 };
        }
    }

    /// Decides frame `frame` (the number that rotates histories, beside the ticks). `keys` has for each of the plan's passes a digest of its
    /// pipeline, workgroups, push and uniform bytes, or `None` when it does not run in this frame (not due, or disabled); `present` is one
    /// of how the picture is shown. Gives for each step whether it is to run (barriers: always true), and takes it that they do.
    pub(crate) fn decide(&mut self, frame: u64, ticks: &Ticks, keys: &[Option<Digest>], present: Digest) -> &[bool] {
        self.find_copies(frame, ticks);
        self.predict_contents(ticks, keys, present);
        self.mark_dirty();
        self.propagate_dirty();
        self.commit();
        &self.run
    }

    /// Finds the contents that each access is about in this frame.
    fn find_copies(&mut self, frame: u64, ticks: &Ticks) {
        for node in &mut self.nodes {
            for access in &mut node.accesses {
                let slot = &self.slots[access.slot as usize];
                access.base = slot.base(ticks.rotation(frame, access.selector), access.age);
            }
        }
    }

    /// Predicts the contents that a full frame would leave behind.
    fn predict_contents(&mut self, ticks: &Ticks, keys: &[Option<Digest>], present: Digest) {
        self.wanted.copy_from_slice(&self.content);
        for slot in self.slots.iter().filter(|slot| slot.transient) {
            self.wanted[slot.copy_range(0)].fill(UNDEFINED);
        }
        for (node, active) in self.nodes.iter().zip(&mut self.active) {
            let key = node.key(&self.copies, ticks, keys, present);
            *active = key.is_some();
            let Some(key) = key else { continue };
            self.seen[node.seen.start] = key;
            for access in node.accesses.iter().filter(|access| access.reads) {
                for (seen, content) in self.seen[access.seen..].iter_mut().zip(&self.wanted[access.contents()]) {
                    *seen = content.id;
                }
            }
            let run = digest::of(node.maker.salt(), &self.seen[node.seen.clone()]);
            if let Maker::Pass { pass, .. } = node.maker
                && let Some(newest) = self.runs.get_mut(pass as usize)
            {
                *newest = run;
            }
            for (i, access) in node.accesses.iter().enumerate().filter(|(_, access)| access.writes) {
                for (mip, content) in self.wanted[access.contents()].iter_mut().enumerate() {
                    let run = result(run, i, mip);
                    if content.run != run || access.reads {
                        // A store to all of it replaces the contents before.
                        let kept = !access.whole || access.reads;
                        let id = if kept { digest::of(0, &[run, content.id]) } else { run };
                        *content = Content { id, run };
                    }
                }
            }
            if node.maker == Maker::Present {
                let last = self.wanted.len() - 1;
                self.wanted[last] = Content { id: run, run };
            }
        }
    }

    /// Copies whose content must outlive the frame and is not in place.
    fn mark_dirty(&mut self) {
        self.dirty.fill(false);
        for slot in self.slots.iter().filter(|slot| !slot.aliased) {
            for copy in 0..slot.copies {
                let range = slot.copy_range(copy);
                self.dirty[range.start] = self.wanted[range.clone()] != self.content[range.clone()];
            }
        }
        let last = self.content.len() - 1;
        self.dirty[last] = self.wanted[last] != self.content[last];
    }

    /// Every writer of a dirty copy runs; every copy that a running step writes, or needs other than it is, is dirty.
    fn propagate_dirty(&mut self) {
        for node in &self.nodes {
            self.run[node.step as usize] = false;
        }
        loop {
            let mut stable = true;
            // Backwards: most nodes that must run are found by following inputs to their makers.
            for (node, _) in self.nodes.iter().zip(&self.active).rev().filter(|(_, active)| **active) {
                let picture = node.maker == Maker::Present && self.dirty[self.content.len() - 1];
                let dirty = |access: &SlotAccess| access.writes && self.dirty[access.base];
                if !self.run[node.step as usize] {
                    let is_forced = |pass: u32| self.forced.contains(&(pass as usize));
                    let forced = matches!(node.maker, Maker::Pass { pass, .. } if is_forced(pass));
                    if !picture && !forced && !node.accesses.iter().any(dirty) {
                        continue;
                    }
                    self.run[node.step as usize] = true;
                    stable = false;
                }
                for access in &node.accesses {
                    let in_place = || {
                        let now = &self.content[access.contents()];
                        now.iter().zip(&self.seen[access.seen..]).all(|(content, seen)| content.id == *seen)
                    };
                    let aliased = self.slots[access.slot as usize].aliased;
                    if !self.dirty[access.base] && (access.writes || aliased || !in_place()) {
                        self.dirty[access.base] = true;
                        stable = false;
                    }
                }
            }
            if stable {
                return;
            }
        }
    }

    /// Records the contents after the decided steps have run.
    fn commit(&mut self) {
        for slot in &self.slots {
            for copy in 0..slot.copies {
                let range = slot.copy_range(copy);
                if slot.aliased {
                    for content in &mut self.content[range] {
                        self.fresh += 1;
                        *content = Content { id: MADE_UP | Digest::from(self.fresh), run: 0 };
                    }
                } else if self.dirty[range.start] {
                    self.content[range.clone()].copy_from_slice(&self.wanted[range]);
                }
            }
        }
        let last = self.content.len() - 1;
        self.content[last] = self.wanted[last];
    }
}

impl Slot {
    /// Index of mip 0 of the copy that holds the content of `age` frames (or ticks) ago.
    #[expect(clippy::cast_possible_truncation, reason = "it is below the number of copies")]
    fn base(&self, rotation: u64, age: u32) -> usize {
        if self.copies == 1 {
            return self.first;
        }
        let copies = u64::from(self.copies);
        let copy = (rotation + copies - u64::from(age) % copies) % copies;
        self.first + (copy as usize) * self.mips as usize
    }

    fn copy_range(&self, copy: u32) -> Range<usize> {
        let first = self.first + (copy * self.mips) as usize;
        first..first + self.mips as usize
    }
}

impl SlotAccess {
    fn contents(&self) -> Range<usize> {
        let first = self.base + self.mips.0 as usize;
        first..first + self.mips.1 as usize
    }
}

impl Node {
    /// The part of its key that is not an input; `None` when it does not run in this frame.
    fn key(&self, copies: &[Option<u64>], ticks: &Ticks, keys: &[Option<Digest>], present: Digest) -> Option<Digest> {
        if self.tick.is_some_and(|(clock, tick)| !ticks.is_due(clock, tick)) {
            return None;
        }
        match self.maker {
            Maker::Clear(value) => Some(value),
            Maker::Copy(resource) => copies[resource as usize].map(Digest::from),
            Maker::Pass { pass, .. } => keys[pass as usize],
            Maker::Present => Some(present),
        }
    }
}

impl Maker {
    fn salt(self) -> u64 {
        match self {
            Maker::Clear(_) => 0xc1,
            Maker::Copy(_) => 0xc2,
            Maker::Pass { salt, .. } => 0x1_0000 + u64::from(salt),
            Maker::Present => 0xd1,
        }
    }
}

/// The id of a run's store by one of its accesses in one mip. Digests of runs are spread evenly over 128 bits, so those with a small number
/// added to them are no likelier to meet.
fn result(run: Digest, access: usize, mip: usize) -> Digest {
    run.wrapping_add((access as Digest + 1) << 32 | mip as Digest)
}

#[cfg(test)]
mod tests;
