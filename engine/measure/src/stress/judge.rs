//! Judging parts of a list of rays on all cores.

use std::time::Instant;

use raxel_oracle::camera::Tile;
use raxel_oracle::exact::Answer;
use raxel_oracle::instances::{SceneHit, SceneOracle};
use raxel_oracle::metrics::{Errors, Outcome, Wrong, ends_at_hit};
use raxel_oracle::period::{PeriodHit, PeriodRay};
use raxel_oracle::{Hit, Lattice, Oracle, Ray};
use rayon::prelude::*;

use super::onward::{Onward, OnwardScene};
use super::plan::{Kind, Row};
use super::posed::Posed;
use super::truth::{Truth, outcome, period_ray};
use crate::rays::{HitWords, RayWords, State, VoxelEdit};

/// Wrong rays that are kept of each row, to be looked at.
pub(crate) const WRONG_KEPT: usize = 8;
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
    /// The right answer.
    pub exact: Truth,
    /// The tracer's answer.
    pub found: Option<Hit>,
}

/// The results of a list of rays: counts of each set, and the first wrong rays.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// By set.
    pub sets: Vec<Errors>,
    /// The first few.
    pub wrong: Vec<Sample>,
}

impl Tally {
    pub(super) fn of(sets: usize) -> Self {
        Self { sets: vec![Errors::default(); sets], wrong: Vec::new() }
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
        self
    }
}

/// The exact tracers of a site.
pub(super) struct Oracles<'w> {
    /// Of its voxels.
    pub site: Oracle<'w>,
    /// Of these with instances, if any row traces them.
    pub scene: Option<SceneOracle<'w>>,
    /// Of the edited voxels that each publication shows, if any row traces these.
    pub stages: Vec<Oracle<'w>>,
    /// Of the voxels that a shader leaves, if any row traces them.
    pub stored: Option<Oracle<'w>>,
}

/// Rays of a list of their own: through one publication of a streamed site, through a copy with voxels that a shader has set, or onward from hits.
#[derive(Default)]
pub(super) struct Seen {
    pub rays: Vec<Ray>,
    /// Index of each ray's set.
    pub sets: Vec<u16>,
    /// The exact answers.
    pub answers: Vec<Answer>,
}

/// A list of rays with the facts about it.
#[derive(Default)]
pub(super) struct Batch {
    pub rays: Vec<Ray>,
    /// Index of each ray's set.
    pub sets: Vec<u16>,
    /// The exact answers to the rays.
    pub answers: Vec<Answer>,
    /// The period rays next to the rays, with their exact hits, if any row traces them.
    pub periods: Vec<PeriodRay>,
    pub(crate) period_hits: Vec<Option<PeriodHit>>,
    /// The exact hits of the rays through the site's instances, if any row traces them.
    pub(crate) scene_hits: Vec<Option<SceneHit>>,
    /// The rays through each publication of the site, if any row traces them. All together are as many as the rays.
    pub seen: Vec<Seen>,
    /// The rays through the copy with voxels that a shader has set, if any row traces them.
    pub stored: Seen,
    /// The rays that go on from the hits of the rays, if any row traces them; and from those through the site's instances.
    pub onward: Onward,
    pub(crate) onward_scene: OnwardScene,
    /// Seconds that the answers took, of all cores together.
    pub answer_seconds: f64,
    pub site: usize,
    pub(crate) set_count: usize,
    /// Tiles of pixels that rays belong to, in their order.
    pub tiles: Vec<Tile>,
    /// Where the rays of each tile begin in the list, and how many of them are in it.
    pub(crate) tile_rays: Vec<(usize, usize)>,
}

impl Batch {
    /// Finds the exact answers that rows are judged by.
    pub(crate) fn answer(&mut self, oracles: &Oracles<'_>, posed: Option<&Posed>, rows: &[Row]) {
        let Oracles { site: oracle, scene, stages, stored } = oracles;
        let wants = |kind| rows.iter().any(|row| row.kind() == kind);
        self.scene_hits.clear();
        if let Some(scene) = scene {
            let hits = self.rays.par_iter().with_min_len(64).map(|ray| scene.first_hit(ray));
            hits.collect_into_vec(&mut self.scene_hits);
        }
        self.periods.clear();
        if wants(Kind::Periods) {
            self.rays.par_iter().map(period_ray).collect_into_vec(&mut self.periods);
        }
        let hits = self.periods.par_iter().with_min_len(64).map(|ray| ray.first_hit(oracle));
        hits.collect_into_vec(&mut self.period_hits);
        for (seen, oracle) in self.seen.iter_mut().zip(stages) {
            answer(oracle, &seen.rays, &mut seen.answers);
        }
        if let Some(oracle) = stored {
            answer(oracle, &self.stored.rays, &mut self.stored.answers);
        }
        self.answer_seconds = answer(oracle, &self.rays, &mut self.answers);
        if wants(Kind::Onward) {
            self.onward.fill(oracle, &self.rays, &self.sets, &self.answers);
        }
        if wants(Kind::OnwardInstances)
            && let Some(scene) = posed.zip(scene.as_ref())
        {
            self.onward_scene.fill(scene, &self.rays, &self.sets, &self.scene_hits);
        }
    }

    /// The rays with the times up to which they are free. A time is anywhere up to the exact hit, often just before it.
    pub(crate) fn ahead(&self) -> Vec<RayWords> {
        let words = |(i, (ray, answer)): (usize, (&Ray, &Answer))| RayWords::ahead(ray, t_free(ray, answer, i as u32));
        self.rays.par_iter().zip(&self.answers).enumerate().with_min_len(GRAIN).map(words).collect()
    }

    /// Judges a row's answer about ray `i`.
    fn judge_one(&self, tally: &mut Tally, row: &Row, i: usize, found: (Option<Hit>, Outcome<'_>)) {
        self.count(tally, row, (&self.rays[i], self.sets[i]), self.truth(row, i), found);
    }

    /// Counts the hit that a row found for a ray of a set, against the exact one.
    fn count(
        &self,
        tally: &mut Tally,
        row: &Row,
        (ray, set): (&Ray, u16),
        exact: Truth,
        (hit, other): (Option<Hit>, Outcome<'_>),
    ) {
        let set = usize::from(set);
        if let Some(wrong) = exact.judge(&mut tally.sets[set], ray, row, outcome(hit.as_ref(), other))
            && tally.wrong.len() < WRONG_KEPT
        {
            tally.wrong.push(Sample { site: self.site, set, wrong, ray: *ray, exact, found: hit });
        }
    }

    /// Tallies the answers about the rays from `first` on, one by one on all cores.
    fn tally<T: Sync>(&self, first: usize, found: &[T], one: impl Fn(&mut Tally, usize, &T) + Sync) -> Tally {
        let judged = |(chunk, found): (usize, &[T])| {
            let mut tally = Tally::of(self.set_count);
            (first + chunk * GRAIN..).zip(found).for_each(|(i, found)| one(&mut tally, i, found));
            tally
        };
        let chunks = found.par_chunks(GRAIN).enumerate();
        chunks.map(judged).reduce(|| Tally::of(self.set_count), Tally::and)
    }

    /// The right answer to ray `i` for a row.
    fn truth(&self, row: &Row, i: usize) -> Truth {
        match row.kind() {
            // Streamed and stored ones, and those onward, have rays of their own, see [`Seen`].
            Kind::Rays | Kind::Ahead | Kind::Tiles | Kind::Onward | Kind::Stored | Kind::Streamed => {
                Truth::Ray(self.answers[i])
            }
            Kind::Periods => Truth::Period(self.periods[i], self.period_hits[i]),
            Kind::Instances | Kind::OnwardInstances => Truth::Scene(self.scene_hits[i]),
        }
    }

    /// Judges the device's answers about the rays from `first` on, through a site's instances.
    pub(crate) fn judge_scene(&self, posed: &Posed, first: usize, words: &[HitWords]) -> Tally {
        self.tally(first, words, |tally, i, words| {
            let (ray, exact, set) = (&self.rays[i], self.scene_hits[i], usize::from(self.sets[i]));
            if let Some(wrong) = posed.judge(&mut tally.sets[set], ray, exact.as_ref(), words)
                && tally.wrong.len() < WRONG_KEPT
            {
                let (site, exact) = (self.site, Truth::Scene(exact));
                tally.wrong.push(Sample { site, set, wrong, ray: *ray, exact, found: words.hit() });
            }
        })
    }

    /// Judges the device's answers about the rays from `first` on of those that continue from hits through a site's instances.
    pub(crate) fn judge_scene_onward(&self, posed: &Posed, first: usize, words: &[HitWords]) -> Tally {
        let OnwardScene { exact_from, rays, sets, hits, .. } = &self.onward_scene;
        self.tally(first, words, |tally, i, words| {
            let (ray, exact, set) = (&rays[i].ray, hits[i], usize::from(sets[i]));
            if let Some(wrong) = posed.judge_onward(&mut tally.sets[set], ray, (&exact_from[i], exact.as_ref()), words)
                && tally.wrong.len() < WRONG_KEPT
            {
                let (site, exact) = (self.site, Truth::Scene(exact));
                tally.wrong.push(Sample { site, set, wrong, ray: *ray, exact, found: words.hit() });
            }
        })
    }

    /// Counts, in the first set, a shader's answers about the voxels that it had to set. A voxel that it did not set, although the copy has
    /// the chunk, is a miss. A voxel that it claims to have set, although the copy lacks the chunk, is a false hit.
    pub(crate) fn judge_edits(
        site: usize,
        sets: usize,
        edits: &[VoxelEdit],
        found: &[HitWords],
        stored: bool,
    ) -> Tally {
        let mut tally = Tally::of(sets);
        for (edit, words) in edits.iter().zip(found) {
            let ray = Ray::new(edit.cell, [0.5; 3], [1.0, 0.0, 0.0]);
            let wrong = match words.state() {
                State::Hit if !stored => Some(Wrong::False),
                State::Miss if stored => Some(Wrong::Miss),
                State::Hang | State::Unwritten => Some(Wrong::Unwritten),
                State::Hit | State::Miss => None,
            };
            tally.sets[0].add_judged(stored, false, wrong);
            if let Some(wrong) = wrong
                && tally.wrong.len() < WRONG_KEPT
            {
                let exact = Truth::Edited(Answer { hit: None, tie: false });
                tally.wrong.push(Sample { site, set: 0, wrong, ray, exact, found: words.hit() });
            }
        }
        tally
    }

    /// Judges the device's answers about the rays from `first` on of those of a list of their own.
    pub(crate) fn judge_seen(&self, row: &Row, seen: &Seen, first: usize, words: &[HitWords]) -> Tally {
        self.tally(first, words, |tally, i, words| {
            let exact = Truth::Edited(seen.answers[i]);
            self.count(tally, row, (&seen.rays[i], seen.sets[i]), exact, said(words));
        })
    }

    /// Judges a row's results of the rays from `first` on, by their answers.
    pub(crate) fn judge<T: Sync>(
        &self,
        row: &Row,
        first: usize,
        found: &[T],
        outcome: impl Fn(&T) -> (Option<Hit>, Outcome<'static>) + Sync,
    ) -> Tally {
        self.tally(first, found, |tally, i, found| self.judge_one(tally, row, i, outcome(found)))
    }

    /// Judges the device's words.
    pub(crate) fn judge_words(&self, row: &Row, first: usize, words: &[HitWords]) -> Tally {
        self.judge(row, first, words, said)
    }

    /// Judges the device's words about the tiles from `first` on.
    pub(crate) fn judge_tiles(&self, row: &Row, first: usize, words: &[HitWords]) -> Tally {
        let judged = |(ranges, words): (&[(usize, usize)], &[HitWords])| {
            let mut tally = Tally::of(self.set_count);
            for (&(begin, count), words) in ranges.iter().zip(words.chunks(Tile::RAYS)) {
                for (i, words) in (begin..begin + count).zip(words) {
                    self.judge_one(&mut tally, row, i, said(words));
                }
            }
            tally
        };
        let tiles = self.tile_rays[first..].par_chunks(GRAIN / Tile::RAYS);
        tiles.zip(words.par_chunks(GRAIN)).map(judged).reduce(|| Tally::of(self.set_count), Tally::and)
    }
}

/// Finds the exact answers to rays, and gives the seconds that took, of all cores together.
fn answer(oracle: &Oracle<'_>, rays: &[Ray], answers: &mut Vec<Answer>) -> f64 {
    answers.resize(rays.len(), Answer { hit: None, tie: false });
    let chunks = answers.par_chunks_mut(GRAIN).zip(rays.par_chunks(GRAIN));
    let seconds = chunks.map(|(answers, rays)| {
        let start = Instant::now();
        for (answer, ray) in answers.iter_mut().zip(rays) {
            *answer = oracle.first_hit(ray);
        }
        start.elapsed().as_secs_f64()
    });
    seconds.sum()
}

/// The device's answer about a ray.
pub(super) fn said(words: &HitWords) -> (Option<Hit>, Outcome<'static>) {
    // A tracer that finds a voxel of one material and looks up another is wrong about the material.
    let hit =
        words.hit().map(|hit| if words.looked_up == hit.material { hit } else { Hit { material: u32::MAX, ..hit } });
    (hit, words.outcome(None))
}

/// A time up to which a ray is free: of one that misses anything, of one that hits some share of the way, or all of it.
fn t_free(ray: &Ray, answer: &Answer, number: u32) -> f32 {
    let Some(lattice) = Lattice::of(ray) else { return 0.0 };
    let bits = number.wrapping_mul(0x9e37_79b9);
    let share = f64::from(bits >> 8) / f64::from(1 << 24);
    let Some(hit) = answer.hit else {
        let voxel = 1.0 / (lattice.length() * f64::from(lattice.exponent).exp2());
        return (voxel * (share * 20.0).exp2()) as f32;
    };
    let t = hit.time.in_lengths(&lattice);
    let rounded = (if number & 1 == 0 { t } else { t * share }) as f32;
    if f64::from(rounded) > t { rounded.next_down() } else { rounded }
}

/// The latest time at which an `ahead` row begins a ray.
pub(super) fn latest_start(ray: &Ray, answer: &Answer) -> f32 {
    t_free(ray, answer, 0)
}

/// How the hits of one tracer differ from those of another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Differences {
    /// Rays with another voxel, face or material.
    pub hits: u64,
    /// Rays with the same hit and another bit of t or uv.
    pub bits: u64,
    /// Rays with the same hit, found after another number of steps.
    pub steps: u64,
}

impl Differences {
    pub(super) fn and(self, other: Self) -> Self {
        Self { hits: self.hits + other.hits, bits: self.bits + other.bits, steps: self.steps + other.steps }
    }
}

/// Compares two tracers ray by ray.
pub(super) fn compare(batch: &Batch, one: &[Option<Hit>], other: &[HitWords]) -> Differences {
    let differ = |(i, (one, other)): (usize, (&Option<Hit>, &HitWords))| match (one, other.hit()) {
        (None, None) => Differences::default(),
        // Of a ray that ends at its hit a bit of t decides whether that is found.
        (None, Some(_)) | (Some(_), None) if ends_at_hit(&batch.rays[i], &batch.answers[i]) => {
            Differences { bits: 1, ..Differences::default() }
        }
        (Some(a), Some(b)) if (a.voxel, a.face, a.material) == (b.voxel, b.face, b.material) => {
            let bits = |hit: &Hit| [hit.t, hit.uv[0], hit.uv[1]].map(f32::to_bits);
            Differences { hits: 0, bits: u64::from(bits(a) != bits(&b)), steps: u64::from(a.steps != b.steps) }
        }
        _ => Differences { hits: 1, ..Differences::default() },
    };
    one.par_iter().zip(other).enumerate().with_min_len(GRAIN).map(differ).reduce(Differences::default, Differences::and)
}
