//! A graph as data: what the generator makes, the writer writes and the interpreter runs.

/// Resources and passes in the order of the file.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    pub name: String,
    pub resources: Vec<Resource>,
    pub passes: Vec<Pass>,
    pub clock: Option<Clock>,
    /// Rounds of the loop `rounds`.
    pub rounds: u32,
    /// `u` of `[blocks.both]`; `v` is `param.n`.
    pub common: u32,
    /// Defaults of `n` and `flag`.
    pub n: u32,
    pub flag: bool,
    pub present: usize,
}

#[derive(Clone, Debug)]
pub(crate) struct Clock {
    /// As in the file.
    pub hz: &'static str,
    pub most: u32,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Resource {
    pub name: String,
    pub kind: Kind,
    pub history: usize,
    pub clear: Option<u32>,
    pub init: Option<u32>,
    pub keep: bool,
    pub clock: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    Target {
        size: Size,
        mips: usize,
    },
    Words(u32),
    /// An element for each texel of a target.
    Of(usize),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Size {
    Output,
    Half,
    Fixed([u32; 2]),
}

#[derive(Clone, Debug)]
pub(crate) struct Pass {
    pub name: String,
    pub reads: Vec<Read>,
    pub writes: Vec<Write>,
    /// Takes the block `both`, with `u` of its own where it has one.
    pub common: Option<Common>,
    pub a: Int,
    pub b: Float,
    pub k: u32,
    pub every: Every,
    pub in_loop: bool,
    /// Runs while `param.flag` is this.
    pub when: Option<bool>,
}

/// The block `both` in a pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Common {
    /// The pass's own values over the block's.
    pub u: Option<u32>,
}

#[derive(Clone, Debug)]
pub(crate) struct Read {
    pub resource: usize,
    pub age: usize,
    pub mip: usize,
}

#[derive(Clone, Debug)]
pub(crate) struct Write {
    pub resource: usize,
    pub mip: usize,
    pub how: How,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum How {
    /// All texels.
    Over,
    /// Loads each texel before it stores.
    Change,
    /// Every second texel.
    Part,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Int {
    Value(u32),
    N,
    FrameIndex,
    FrameStill,
    HistoryValid,
    Tick,
    LoopIndex,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Float {
    Value(f32),
    Time,
    Phase,
    Delta,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Every {
    Frame,
    Frames(u32),
    Hz(&'static str),
    Still(u32),
    Clock,
}

impl Pass {
    /// The resources that it binds.
    pub(crate) fn bound(&self) -> impl Iterator<Item = usize> + '_ {
        self.reads.iter().map(|read| read.resource).chain(self.writes.iter().map(|write| write.resource))
    }
}

impl Resource {
    pub(crate) fn mips(&self) -> usize {
        if let Kind::Target { mips, .. } = self.kind { mips } else { 1 }
    }

    pub(crate) fn is_target(&self) -> bool {
        matches!(self.kind, Kind::Target { .. })
    }
}
