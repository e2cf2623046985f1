//! Loops of a checked graph, and the inputs of their passes from the round.

use raxel_diagnostics::Span;
use serde::Serialize;

use super::{BoundAccess, Interval, ParamId, PassId, ResourceId, Value};

/// Index into [`Graph::loops`](super::Graph::loops).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct LoopId(pub u32);

/// Most rounds that a loop may have.
pub const MOST_ROUNDS: u32 = 64;

/// A group of passes, one behind the other in the file, that is repeated in each frame.
#[derive(Clone, Debug, Serialize)]
pub struct Loop {
    /// Name.
    pub name: String,
    /// How often.
    pub rounds: Rounds,
    /// `loop.index` runs down to 0, and not up from it.
    pub down: bool,
    /// Pairs of resources that change places after each round, for later rounds and for all later passes. Both are alike.
    pub swap: Vec<[ResourceId; 2]>,
    /// Where it is declared.
    pub place: Span,
}

/// How often a loop is repeated, at most [`MOST_ROUNDS`] times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Rounds {
    /// So often.
    Fixed(u32),
    /// The value of an integer param, whose range has a whole number from 0 to [`MOST_ROUNDS`] at both ends.
    Param(ParamId),
    /// Once for each step from a mip of this target to the next: its mips less one.
    Mips(ResourceId),
}

/// The number of rounds for a param's value; `None` for values that count nothing.
pub fn count_of(value: Value) -> Option<u32> {
    match value {
        Value::U32(count) => Some(count.min(MOST_ROUNDS)),
        Value::I32(count) => Some(u32::try_from(count).unwrap_or(0).min(MOST_ROUNDS)),
        _ => None,
    }
}

/// A number that is another one in each round of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum RoundIndex {
    /// The round: from 0 up, or down to 0.
    Index,
    /// One more.
    Next,
}

impl RoundIndex {
    /// Both.
    pub const ALL: [RoundIndex; 2] = [RoundIndex::Index, RoundIndex::Next];

    /// The word in the file.
    pub const fn name(self) -> &'static str {
        match self {
            RoundIndex::Index => "loop.index",
            RoundIndex::Next => "loop.next",
        }
    }

    /// Its description, in one sentence.
    pub const fn about(self) -> &'static str {
        match self {
            RoundIndex::Index => "Round of the loop that the pass is in: from 0 up, or down to 0.",
            RoundIndex::Next => "`loop.index` + 1.",
        }
    }

    /// The number in the round of that index.
    pub const fn at(self, index: u32) -> u32 {
        match self {
            RoundIndex::Index => index,
            RoundIndex::Next => index + 1,
        }
    }
}

/// The values that a pass of a loop takes from the round.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct InLoop {
    /// The loop.
    pub of: LoopId,
    /// Accesses (indices into [`Pass::accesses`](super::Pass::accesses)) of the mip of the round.
    pub mips: Vec<(u32, RoundIndex)>,
    /// The dispatch covers the mip of the round.
    pub dispatch_mip: Option<RoundIndex>,
}

/// The accesses of a pass of a loop in the round of that index.
pub fn accesses_of_round(accesses: &[BoundAccess], in_loop: &InLoop, index: u32) -> Vec<BoundAccess> {
    let mut accesses = accesses.to_vec();
    for (access, of_round) in &in_loop.mips {
        accesses[*access as usize].mips = Interval::one(of_round.at(index));
    }
    accesses
}

/// Which pass of the file a pass of a plan's graph is, and which round of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Round {
    /// The pass of the graph that was planned.
    pub pass: PassId,
    /// `loop.index`; `None` when the pass is in no loop.
    pub index: Option<u32>,
}
