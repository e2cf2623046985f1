//! Judging parts of a list of rays on all cores.

use std::sync::Arc;

use raxel_oracle::exact::Answer;
use raxel_oracle::metrics::{Errors, Outcome, Wrong};
use raxel_oracle::{Hit, Oracle, Ray};
use rayon::prelude::*;

use crate::rays::HitWords;

/// Wrong rays that are kept of each row, to be looked at.
pub const WRONG_KEPT: usize = 8;
/// Rays that a core judges at a time.
const GRAIN: usize = 2048;

/// A ray that was traced wrongly.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Index of the site in the plan.
    pub site: usize,
    /// Index of the set in the plan.
    pub set: usize,
    /// In which way.
    pub wrong: Wrong,
    /// The ray.
    pub ray: Ray,
    /// What is right.
    pub exact: Answer,
    /// What was found.
    pub found: Option<Hit>,
}

/// What came out of a list of rays: counts of each set, and the first wrong rays.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// By set.
    pub sets: Vec<Errors>,
    /// The first few.
    pub wrong: Vec<Sample>,
    /// Rays whose voxel, face or material differ from those that another tracer found.
    pub other_hits: u64,
    /// Rays with the same hit whose t or uv differ in a bit.
    pub other_bits: u64,
}

impl Tally {
    pub(super) fn of(sets: usize) -> Self {
        Self { sets: vec![Errors::default(); sets], ..Self::default() }
    }

    /// All sets together.
    pub fn total(&self) -> Errors {
        self.sets.iter().copied().fold(Errors::default(), Errors::and)
    }

    pub(super) fn and(mut self, other: Self) -> Self {
        for (mine, other) in self.sets.iter_mut().zip(other.sets) {
            *mine = mine.and(other);
        }
        let room = WRONG_KEPT.saturating_sub(self.wrong.len());
        self.wrong.extend(other.wrong.into_iter().take(room));
        self.other_hits += other.other_hits;
        self.other_bits += other.other_bits;
        self
    }
}

/// A list of rays with what is known about it.
pub(super) struct Batch {
    pub rays: Arc<[Ray]>,
    /// Index of each ray's set.
    pub sets: Vec<u16>,
    /// The exact answers to the first rays, as many as were asked for.
    pub answers: Vec<Answer>,
    pub site: usize,
    pub set_count: usize,
}

impl Batch {
    /// Makes sure that the answers to the first `end` rays are there. How many were found for it.
    pub fn answer(&mut self, oracle: &Oracle<'_>, end: usize) -> usize {
        let begin = self.answers.len();
        if begin < end {
            self.answers.par_extend(self.rays[begin..end].par_iter().with_min_len(64).map(|ray| oracle.first_hit(ray)));
        }
        end.saturating_sub(begin)
    }

    /// Judges the rays from `first` on by their answers.
    pub fn judge<'h, T: Sync>(
        &self,
        first: usize,
        found: &'h [T],
        outcome: impl Fn(&'h T) -> (Option<Hit>, Outcome<'static>) + Sync,
    ) -> Tally {
        let judged = |(chunk, found): (usize, &'h [T])| {
            let mut tally = Tally::of(self.set_count);
            for (i, found) in (first + chunk * GRAIN..).zip(found) {
                let (ray, answer, set) = (&self.rays[i], &self.answers[i], usize::from(self.sets[i]));
                let (hit, other) = outcome(found);
                let outcome = hit.as_ref().map_or(other, Outcome::Hit);
                if let Some(wrong) = tally.sets[set].add(ray, answer, outcome)
                    && tally.wrong.len() < WRONG_KEPT
                {
                    tally.wrong.push(Sample { site: self.site, set, wrong, ray: *ray, exact: *answer, found: hit });
                }
            }
            tally
        };
        let chunks = found.par_chunks(GRAIN).enumerate();
        chunks.map(judged).reduce(|| Tally::of(self.set_count), Tally::and)
    }

    /// Judges what the device wrote.
    pub fn judge_words(&self, first: usize, words: &[HitWords]) -> Tally {
        self.judge(first, words, |words| {
            // A tracer that finds a voxel of one material and looks up another is wrong about the material.
            let hit = words
                .hit()
                .map(|hit| if words.looked_up == hit.material { hit } else { Hit { material: u32::MAX, ..hit } });
            (hit, words.outcome(None))
        })
    }
}

/// How the hits of one tracer differ from those of another: rays with another voxel, face or material; and rays with the same, of which a
/// bit of t or uv differs.
pub(super) fn compare(one: &[Option<Hit>], other: &[HitWords]) -> (u64, u64) {
    let differ = |(one, other): (&Option<Hit>, &HitWords)| match (one, other.hit()) {
        (None, None) => (0, 0),
        (Some(a), Some(b)) if (a.voxel, a.face, a.material) == (b.voxel, b.face, b.material) => {
            let bits = |hit: &Hit| [hit.t, hit.uv[0], hit.uv[1]].map(f32::to_bits);
            (0, u64::from(bits(a) != bits(&b)))
        }
        _ => (1, 0),
    };
    one.par_iter().zip(other).with_min_len(GRAIN).map(differ).reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
}
