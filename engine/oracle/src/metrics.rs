//! How wrong a tracer is: each ray's hit against the exact one, and counts over many.

use serde::Serialize;

use crate::exact::{Answer, ExactHit, Passage};
use crate::lattice::Lattice;
use crate::ray::{Hit, Ray};

/// What a tracer made of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome<'h> {
    /// It says that nothing is hit.
    Miss,
    /// It says that this is hit.
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
}

/// Counts over a set of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit something by the exact tracer.
    pub hits: u64,
    /// Rays of which another rule for ties may say something else.
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
    /// Wrong in any of these ways, though the ray meets no tie.
    pub wrong_without_tie: u64,
    /// Of the wrong hits those in a voxel that the ray does touch, and not later than the right one: another rule for ties would make
    /// them right.
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
    /// Wrong in any way.
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
            wrong_without_tie: self.wrong_without_tie + other.wrong_without_tie,
            tied: self.tied + other.tied,
            missed_chord: self.missed_chord.max(other.missed_chord),
            false_gap: self.false_gap.max(other.false_gap),
            t_error: self.t_error.max(other.t_error),
            t_voxels: self.t_voxels.max(other.t_voxels),
            t_ulp: self.t_ulp.max(other.t_ulp),
        }
    }

    /// Adds one ray, and says whether it is wrong.
    pub fn add<'h>(&mut self, ray: &Ray, exact: &Answer, found: impl Into<Outcome<'h>>) -> Option<Wrong> {
        self.rays += 1;
        self.hits += u64::from(exact.hit.is_some());
        self.ties += u64::from(exact.tie);
        let lattice = Lattice::of(ray);
        let wrong = match (found.into(), &exact.hit, &lattice) {
            (Outcome::Hang, ..) => Some(Wrong::Hang),
            (Outcome::Unwritten, ..) => Some(Wrong::Unwritten),
            (Outcome::Miss, None, _) => None,
            (Outcome::Miss, Some(_), _) => Some(Wrong::Miss),
            (Outcome::Hit(found), ..) if !(found.t.is_finite() && found.uv.iter().all(|uv| uv.is_finite())) => {
                Some(Wrong::NotFinite)
            }
            (Outcome::Hit(found), exact, lattice) => self.compare(exact.as_ref(), lattice.as_ref(), found),
        };
        let count = match wrong? {
            Wrong::Miss => &mut self.missed,
            Wrong::False => &mut self.invented,
            Wrong::Early => &mut self.early,
            Wrong::Late => &mut self.late,
            Wrong::Hang => &mut self.hangs,
            Wrong::NotFinite => &mut self.not_finite,
            Wrong::Unwritten => &mut self.unwritten,
            Wrong::Face => &mut self.face,
            Wrong::Material => &mut self.material,
        };
        *count += 1;
        self.wrong_without_tie += u64::from(!exact.tie);
        if let (Some(lattice), Some(exact)) = (&lattice, &exact.hit)
            && !matches!(wrong, Some(Wrong::Face | Wrong::Material | Wrong::NotFinite))
        {
            let chord = Passage::of(lattice, exact.voxel).map_or(0.0, |passage| passage.length(lattice));
            self.missed_chord = self.missed_chord.max(chord);
        }
        wrong
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

/// Least distance between a ray and a voxel's cube, in voxels.
fn distance(lattice: &Lattice, voxel: [i32; 3]) -> f64 {
    let low: [f64; 3] = std::array::from_fn(|axis| {
        (i64::from(voxel[axis]) - lattice.cell[axis]) as f64 - lattice.frac[axis] as f64 / crate::lattice::ONE as f64
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
    fn chords_gaps_and_times_are_measured() {
        let (world, ray, hit) = one();
        let (_, errors) = judged(&ray, &world, Outcome::Miss);
        assert!((errors.missed_chord - 1.0).abs() < 1e-12, "straight through: {errors:?}");

        // Through the corner region of (10, 0, 0): in by x = 10 at y = 0.75, out by y = 1 at x = 10.25.
        let slanted = Ray::new([9, 0, 0], [0.25, 0.0, 0.5], [1.0, 1.0, 0.0]);
        let (_, errors) = judged(&slanted, &world, Outcome::Miss);
        assert!((errors.missed_chord - 2f64.sqrt() / 4.0).abs() < 1e-6, "{errors:?}");

        // Two voxels above the ray; one that it touches along an edge is no gap but a tie.
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
