//! Measures the errors of a tracer: compares each hit with the exact one, and counts over many rays.

use std::ops::RangeInclusive;

use raxel_ray::{FAR, Hit, Lattice, Ray};
use serde::Serialize;

use crate::exact::{Answer, ExactHit, Passage};

/// A tracer's result for a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome<'h> {
    /// Nothing is hit.
    Miss,
    /// This is hit.
    Hit(&'h Hit),
    /// It gave up at its bound of rounds.
    Hang,
    /// It wrote nothing.
    Unwritten,
}

impl<'h> From<Option<&'h Hit>> for Outcome<'h> {
    fn from(hit: Option<&'h Hit>) -> Self {
        hit.map_or(Outcome::Miss, Outcome::Hit)
    }
}

/// In which way a tracer was wrong about a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wrong {
    /// It missed a hit.
    Miss,
    /// It hit something where there is nothing to hit.
    False,
    /// It hit another voxel, before the right one.
    Early,
    /// It hit another voxel, behind the right one.
    Late,
    /// It gave up.
    Hang,
    /// Its t or uv is not finite.
    NotFinite,
    /// It wrote no hit.
    Unwritten,
    /// The right voxel, another face.
    Face,
    /// The right voxel and face, another material.
    Material,
    /// The right hit, but beyond the ray's `t_max`.
    Beyond,
    /// The right hit, at a t that is off by more than [`ULPS`].
    Time,
    /// The right hit, at a place on the face that is off by more than [`ULPS`].
    Place,
    /// The right hit, after fewer looks than one, or more than there are cells on the way.
    Steps,
}

/// The largest error of t and uv of a right hit, in 2⁻²³ of their value: two operands rounded to ½ and a division to 2½, as
/// docs/exactness.md derives it.
pub const ULPS: f64 = 3.5;

/// Whether a t or uv of a right hit is as near to the exact one as [`ULPS`] allows.
pub fn near(found: f32, exact: f64) -> bool {
    // Below the least normal number devices may write zero.
    (f64::from(found) - exact).abs() <= (ULPS * exact * 2f64.powi(-23)).max(f64::from(f32::MIN_POSITIVE))
}

/// Counts over a set of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit something by the exact tracer.
    pub hits: u64,
    /// Rays for which another rule for ties may give another hit.
    pub ties: u64,
    /// A hit where there is one was missed.
    pub missed: u64,
    /// A hit was reported where there is none.
    pub invented: u64,
    /// The voxel hit lies before the right one.
    pub early: u64,
    /// The voxel hit lies behind the right one.
    pub late: u64,
    /// The tracer gave up.
    pub hangs: u64,
    /// A hit with a t or uv that is not finite.
    pub not_finite: u64,
    /// Nothing was written where the hit should be.
    pub unwritten: u64,
    /// The right voxel, another face.
    pub face: u64,
    /// The right voxel and face, another material.
    pub material: u64,
    /// The right hit, though it lies beyond the ray's end.
    pub beyond: u64,
    /// Right hits whose t is off by more than [`ULPS`].
    pub time: u64,
    /// Right hits whose uv is off by more than [`ULPS`].
    pub place: u64,
    /// Right hits with a number of steps that cannot be.
    pub steps: u64,
    /// Wrong in any of these ways, though the ray meets no tie.
    pub wrong_without_tie: u64,
    /// The wrong hits in a voxel that the ray touches, not later than the right hit. Another rule for ties would make them right.
    pub tied: u64,
    /// Longest way through a voxel that should have been hit and was not, in voxels.
    pub missed_chord: f64,
    /// Largest distance between the ray and a voxel that was hit wrongly, in voxels.
    pub false_gap: f64,
    /// Largest difference in t of a right hit, relative to t or absolute below 1 voxel, in voxels.
    pub t_error: f64,
    /// Largest difference in t of a right hit in voxels along the ray.
    pub t_voxels: f64,
    /// The same in units of the last place of the exact t.
    pub t_ulp: f64,
}

impl Errors {
    /// Hits that are wrong: another voxel, face or material, or whether anything is hit.
    pub fn wrong(&self) -> u64 {
        self.missed
            + self.invented
            + self.early
            + self.late
            + self.hangs
            + self.not_finite
            + self.unwritten
            + self.face
            + self.material
            + self.beyond
    }

    /// Right hits with a wrong number: t, uv or steps. Only counted by [`Errors::add_with_numbers`].
    pub fn inexact(&self) -> u64 {
        self.time + self.place + self.steps
    }

    /// Wrong rays in a million.
    pub fn ppm(&self) -> f64 {
        self.wrong() as f64 * 1e6 / self.rays.max(1) as f64
    }

    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            ties: self.ties + other.ties,
            missed: self.missed + other.missed,
            invented: self.invented + other.invented,
            early: self.early + other.early,
            late: self.late + other.late,
            hangs: self.hangs + other.hangs,
            not_finite: self.not_finite + other.not_finite,
            unwritten: self.unwritten + other.unwritten,
            face: self.face + other.face,
            material: self.material + other.material,
            beyond: self.beyond + other.beyond,
            time: self.time + other.time,
            place: self.place + other.place,
            steps: self.steps + other.steps,
            wrong_without_tie: self.wrong_without_tie + other.wrong_without_tie,
            tied: self.tied + other.tied,
            missed_chord: self.missed_chord.max(other.missed_chord),
            false_gap: self.false_gap.max(other.false_gap),
            t_error: self.t_error.max(other.t_error),
            t_voxels: self.t_voxels.max(other.t_voxels),
            t_ulp: self.t_ulp.max(other.t_ulp),
        }
    }

    /// The count of one way to be wrong.
    fn count(&mut self, wrong: Wrong) -> &mut u64 {
        match wrong {
            Wrong::Miss => &mut self.missed,
            Wrong::False => &mut self.invented,
            Wrong::Early => &mut self.early,
            Wrong::Late => &mut self.late,
            Wrong::Hang => &mut self.hangs,
            Wrong::NotFinite => &mut self.not_finite,
            Wrong::Unwritten => &mut self.unwritten,
            Wrong::Face => &mut self.face,
            Wrong::Material => &mut self.material,
            Wrong::Beyond => &mut self.beyond,
            Wrong::Time => &mut self.time,
            Wrong::Place => &mut self.place,
            Wrong::Steps => &mut self.steps,
        }
    }

    /// Adds one ray of another kind, with the result of its own judge: whether it hits something, whether by a tie, and its fault.
    pub fn add_judged(&mut self, hits: bool, tie: bool, wrong: Option<Wrong>) {
        self.rays += 1;
        self.hits += u64::from(hits);
        self.ties += u64::from(tie);
        let before = self.wrong();
        if let Some(wrong) = wrong {
            *self.count(wrong) += 1;
        }
        self.wrong_without_tie += if tie { 0 } else { self.wrong() - before };
    }

    /// Adds one ray, and returns its fault, if its hit is wrong.
    pub fn add<'h>(&mut self, ray: &Ray, exact: &Answer, found: impl Into<Outcome<'h>>) -> Option<Wrong> {
        let lattice = Lattice::of(ray);
        let (found, end) = (found.into(), End::of(ray, exact, lattice.as_ref()));
        let expected = exact.hit.as_ref().filter(|_| end != End::Before);
        self.rays += 1;
        self.hits += u64::from(expected.is_some());
        self.ties += u64::from(exact.tie);
        let wrong = match found {
            Outcome::Hang => Some(Wrong::Hang),
            Outcome::Unwritten => Some(Wrong::Unwritten),
            Outcome::Miss => expected.filter(|_| end != End::At).map(|_| Wrong::Miss),
            Outcome::Hit(found) if !(found.t.is_finite() && found.uv.iter().all(|uv| uv.is_finite())) => {
                Some(Wrong::NotFinite)
            }
            Outcome::Hit(found) => match self.compare(exact.hit.as_ref(), lattice.as_ref(), found) {
                None if end == End::Before => Some(Wrong::Beyond),
                wrong => wrong,
            },
        };
        *self.count(wrong?) += 1;
        self.wrong_without_tie += u64::from(!exact.tie);
        if let (Some(lattice), Some(exact)) = (&lattice, expected)
            && !matches!(wrong, Some(Wrong::Face | Wrong::Material | Wrong::NotFinite))
        {
            let chord = Passage::of(lattice, exact.voxel).map_or(0.0, |passage| passage.length(lattice));
            self.missed_chord = self.missed_chord.max(chord);
        }
        wrong
    }

    /// Adds one ray like [`Errors::add`]; of a right hit t, uv and the number of steps are judged, too: `steps` are those that can be. For
    /// tracers whose steps are cells on the ray, [`most_steps`] is the most.
    pub fn add_with_numbers<'h>(
        &mut self,
        ray: &Ray,
        exact: &Answer,
        found: impl Into<Outcome<'h>>,
        steps: RangeInclusive<u64>,
    ) -> Option<Wrong> {
        let found = found.into();
        let wrong = self.add(ray, exact, found);
        let (None, Outcome::Hit(found), Some(lattice), Some(exact)) = (wrong, found, Lattice::of(ray), &exact.hit)
        else {
            return wrong;
        };
        let exact_uv = exact.uv(ray, &lattice);
        let (wrong, count) = if !near(found.t, exact.time.in_lengths(&lattice)) {
            (Wrong::Time, &mut self.time)
        } else if !found.uv.into_iter().zip(exact_uv).all(|(found, exact)| near(found, exact)) {
            (Wrong::Place, &mut self.place)
        } else if !steps.contains(&u64::from(found.steps)) {
            (Wrong::Steps, &mut self.steps)
        } else {
            return None;
        };
        *count += 1;
        Some(wrong)
    }

    /// Compares a hit with finite numbers with the exact one.
    fn compare(&mut self, exact: Option<&ExactHit>, lattice: Option<&Lattice>, found: &Hit) -> Option<Wrong> {
        let Some(lattice) = lattice else { return Some(Wrong::False) };
        let Some(exact) = exact.filter(|exact| exact.voxel == found.voxel) else {
            let passage = Passage::of(lattice, found.voxel);
            let in_time = |passage: &Passage| exact.is_none_or(|exact| passage.enter <= exact.time);
            self.tied += u64::from(passage.as_ref().is_some_and(in_time));
            if passage.is_none() {
                self.false_gap = self.false_gap.max(distance(lattice, found.voxel));
            }
            return Some(match exact {
                None => Wrong::False,
                Some(exact) if f64::from(found.t) < exact.time.in_lengths(lattice) => Wrong::Early,
                Some(_) => Wrong::Late,
            });
        };
        if exact.face != found.face {
            return Some(Wrong::Face);
        }
        if u32::from(exact.material) != found.material {
            return Some(Wrong::Material);
        }
        let t = exact.time.in_lengths(lattice);
        let off = (f64::from(found.t) - t).abs();
        // A length of the ray's direction in voxels.
        let length = lattice.length() * f64::from(lattice.exponent).exp2();
        self.t_voxels = self.t_voxels.max(off * length);
        if t > 0.0 {
            // In voxels along the largest axis, for distances below 1, else relative.
            let voxels = t * (f64::from(lattice.exponent) + 30.0).exp2();
            self.t_error = self.t_error.max(off / t * voxels.min(1.0));
            self.t_ulp = self.t_ulp.max(off / (t.log2().floor() - 23.0).exp2());
        } else {
            self.t_error = self.t_error.max(off);
        }
        None
    }
}

/// Where a ray ends, by its `t_max`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Before its hit: there is nothing to hit.
    Before,
    /// As near to its hit as t may be off: either is right.
    At,
    /// Behind its hit, or nowhere.
    Behind,
}

impl End {
    fn of(ray: &Ray, exact: &Answer, lattice: Option<&Lattice>) -> Self {
        let (Some(hit), Some(lattice)) = (&exact.hit, lattice) else { return End::Behind };
        if ray.t_max >= FAR {
            return End::Behind;
        }
        let (t, end) = (hit.time.in_lengths(lattice), f64::from(ray.t_max));
        if (t - end).abs() <= ULPS * 2f64.powi(-23) * t {
            End::At
        } else if t > end {
            End::Before
        } else {
            End::Behind
        }
    }
}

/// Whether a ray ends so near to its hit that a tracer may find it or not: t may be off by [`ULPS`].
pub fn ends_at_hit(ray: &Ray, exact: &Answer) -> bool {
    ray.t_max < FAR && End::of(ray, exact, Lattice::of(ray).as_ref()) == End::At
}

/// Cells on the way from a ray's origin to a hit, both included: a tracer that leaves a block with each step looks at no more.
pub fn most_steps(ray: &Ray, found: &Hit) -> u64 {
    1 + (0..3).map(|axis| u64::from(found.voxel[axis].abs_diff(ray.cell[axis]))).sum::<u64>()
}

/// Least distance between a ray and a voxel's cube, in voxels.
fn distance(lattice: &Lattice, voxel: [i32; 3]) -> f64 {
    let low: [f64; 3] = std::array::from_fn(|axis| {
        (i64::from(voxel[axis]) - lattice.cell[axis]) as f64 - lattice.frac[axis] as f64 / raxel_ray::ONE as f64
    });
    let length = lattice.length();
    let dir = lattice.dir.map(|d| d as f64 / length);
    let from_cube = |t: f64| {
        let square = |axis: usize| {
            let place = dir[axis] * t;
            (low[axis] - place).max(place - low[axis] - 1.0).max(0.0).powi(2)
        };
        (square(0) + square(1) + square(2)).sqrt()
    };
    // The distance is convex in t, and least not further along the ray than the cube's far corner is away.
    let (mut a, mut b) = (0.0, low.iter().map(|low| low.abs() + 1.0).sum::<f64>());
    for _ in 0..200 {
        let (left, right) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if from_cube(left) <= from_cube(right) { b = right } else { a = left }
    }
    from_cube(f64::midpoint(a, b))
}

#[cfg(test)]
mod tests {
    use glam::IVec3;
    use raxel_world::World;

    use super::*;
    use crate::exact::first_hit;
    use crate::scenes::materials;

    /// One voxel of material 2 at (10, 0, 0), and a ray that goes through it.
    fn one() -> (World, Ray, Hit) {
        let world = World::from_voxels(materials(), [(IVec3::new(10, 0, 0), 2)]);
        let ray = Ray::new([0; 3], [0.5; 3], [2.0, 0.0, 0.0]);
        let hit = Hit { voxel: [10, 0, 0], face: 0, material: 2, t: 4.75, uv: [0.5; 2], steps: 3 };
        (world, ray, hit)
    }

    fn judged(ray: &Ray, world: &World, found: Outcome<'_>) -> (Option<Wrong>, Errors) {
        let mut errors = Errors::default();
        let wrong = errors.add(ray, &first_hit(world, ray), found);
        assert_eq!((errors.rays, errors.wrong()), (1, u64::from(wrong.is_some())));
        (wrong, errors)
    }

    #[test]
    fn every_way_to_be_wrong_has_a_name() {
        let (world, ray, hit) = one();
        assert_eq!(judged(&ray, &world, Outcome::Hit(&hit)).0, None);
        for (found, wrong) in [
            (Outcome::Miss, Wrong::Miss),
            (Outcome::Hang, Wrong::Hang),
            (Outcome::Unwritten, Wrong::Unwritten),
            (Outcome::Hit(&Hit { face: 1, ..hit }), Wrong::Face),
            (Outcome::Hit(&Hit { material: 1, ..hit }), Wrong::Material),
            (Outcome::Hit(&Hit { t: f32::NAN, ..hit }), Wrong::NotFinite),
            (Outcome::Hit(&Hit { uv: [0.5, f32::INFINITY], ..hit }), Wrong::NotFinite),
            (Outcome::Hit(&Hit { voxel: [9, 0, 0], t: 4.25, ..hit }), Wrong::Early),
            (Outcome::Hit(&Hit { voxel: [12, 0, 0], t: 5.75, ..hit }), Wrong::Late),
        ] {
            assert_eq!(judged(&ray, &world, found).0, Some(wrong));
        }
        let away = Ray { dir: [-1.0, 0.0, 0.0], ..ray };
        assert_eq!(judged(&away, &world, Outcome::Hit(&hit)).0, Some(Wrong::False));
        assert_eq!(judged(&away, &world, Outcome::Miss).0, None);
    }

    #[test]
    fn wrong_numbers_of_a_right_hit_have_a_name() {
        let (world, ray, hit) = one();
        let judge = |ray: &Ray, hit: &Hit| {
            let mut errors = Errors::default();
            let wrong = errors.add_with_numbers(ray, &first_hit(&world, ray), Some(hit), 1..=most_steps(ray, hit));
            assert_eq!((errors.wrong(), errors.inexact()), (0, u64::from(wrong.is_some())));
            wrong
        };
        let ulps = |value: f32, n: i32| f32::from_bits(value.to_bits().wrapping_add_signed(n));
        for (found, wrong) in [
            (hit, None),
            (Hit { t: ulps(4.75, 4), ..hit }, None),
            (Hit { t: ulps(4.75, 5), ..hit }, Some(Wrong::Time)),
            (Hit { t: 0.0, ..hit }, Some(Wrong::Time)),
            (Hit { t: 9.5, ..hit }, Some(Wrong::Time)),
            (Hit { uv: [0.5, ulps(0.5, -3)], ..hit }, None),
            (Hit { uv: [0.5, ulps(0.5, 4)], ..hit }, Some(Wrong::Place)),
            (Hit { steps: 0, ..hit }, Some(Wrong::Steps)),
            (Hit { steps: 11, ..hit }, None),
            (Hit { steps: 12, ..hit }, Some(Wrong::Steps)),
        ] {
            assert_eq!(judge(&ray, &found), wrong, "{found:?}");
        }
        // Along y the ray goes up by a quarter a voxel: 0.25 + 2.375 from where it begins.
        let slanted = Ray { frac: [0.5, 0.25, 0.125], dir: [2.0, 0.125, 0.0], ..ray };
        let there = Hit { uv: [0.25 + 4.75 * 0.125, 0.125], ..hit };
        assert_eq!(judge(&slanted, &there), None);
        assert_eq!(judge(&slanted, &Hit { uv: [0.125, 0.25 + 4.75 * 0.125], ..hit }), Some(Wrong::Place));
        let back = Ray::new([20, 0, 0], [0.5, 0.75, 0.25], [-1.0, -0.015_625, 0.0]);
        let there = Hit { face: 1, t: 9.5, uv: [0.75 - 9.5 * 0.015_625, 0.25], ..hit };
        assert_eq!(judge(&back, &there), None);
        // Judges looks only if the tracer counts them.
        let uncounted = Hit { steps: 0, ..hit };
        assert_eq!(
            Errors::default().add_with_numbers(&ray, &first_hit(&world, &ray), Some(&uncounted), 0..=u64::MAX),
            None
        );
        let inside = Ray::new([10, 0, 0], [0.5, 0.75, 0.25], [1.0, 0.0, 0.0]);
        assert_eq!(judge(&inside, &Hit { face: 6, t: 0.0, uv: [0.5, 0.75], steps: 1, ..hit }), None);
    }

    #[test]
    fn a_ray_ends_at_its_t_max() {
        let (world, ray, hit) = one();
        let judge = |t_max: f32, found: Outcome<'_>| judged(&Ray { t_max, ..ray }, &world, found).0;
        assert_eq!(judge(4.0, Outcome::Hit(&hit)), Some(Wrong::Beyond));
        assert_eq!((judge(4.0, Outcome::Miss), judge(5.0, Outcome::Miss)), (None, Some(Wrong::Miss)));
        assert_eq!((judge(5.0, Outcome::Hit(&hit)), judge(f32::INFINITY, Outcome::Hit(&hit))), (None, None));
        // At the very end both are right: t itself may be off by a few units in the last place.
        assert_eq!((judge(4.75, Outcome::Miss), judge(4.75, Outcome::Hit(&hit))), (None, None));
        let at_hit = |t_max: f32| ends_at_hit(&Ray { t_max, ..ray }, &first_hit(&world, &ray));
        assert_eq!([4.0, 4.75, 5.0].map(at_hit), [false, true, false]);
    }

    #[test]
    fn chords_gaps_and_times_are_measured() {
        let (world, ray, hit) = one();
        let (_, errors) = judged(&ray, &world, Outcome::Miss);
        assert!((errors.missed_chord - 1.0).abs() < 1e-12, "straight through: {errors:?}");

        // Through the corner region of (10, 0, 0): in by x = 10 at y = 0.75, out by y = 1 at x = 10.25.
        let slanted = Ray::new([9, 0, 0], [0.25, 0.0, 0.5], [1.0, 1.0, 0.0]);
        let (_, errors) = judged(&slanted, &world, Outcome::Miss);
        assert!((errors.missed_chord - 2f64.sqrt() / 4.0).abs() < 1e-6, "{errors:?}");

        // Two voxels above the ray. A voxel that the ray touches along an edge is a tie, not a gap.
        let (_, errors) = judged(&ray, &world, Outcome::Hit(&Hit { voxel: [5, 3, 0], t: 2.25, ..hit }));
        assert!((errors.false_gap - 2.5).abs() < 1e-9 && errors.tied == 0, "{errors:?}");
        let edge = Ray { frac: [0.5, 0.0, 0.5], ..ray };
        let (wrong, errors) = judged(&edge, &world, Outcome::Hit(&Hit { voxel: [10, -1, 0], ..hit }));
        assert_eq!((wrong, errors.tied, errors.ties, errors.wrong_without_tie), (Some(Wrong::Late), 1, 1, 0));
        assert!(errors.false_gap.abs() < 1e-12);

        let late = Hit { t: 4.75 + 4.0 * 2f32.powi(-21), ..hit };
        let (wrong, errors) = judged(&ray, &world, Outcome::Hit(&late));
        assert_eq!(wrong, None);
        assert!(
            (errors.t_ulp - 4.0).abs() < 1e-9 && (errors.t_voxels - 8.0 * 2f64.powi(-21)).abs() < 1e-12,
            "{errors:?}"
        );
    }
}
