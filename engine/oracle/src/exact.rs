//! First hit in exact arithmetic: no floating point decides anything.

use std::cmp::Ordering;

use glam::IVec3;
use raxel_world::{ChunkPos, World};

use crate::lattice::{Lattice, ONE};
use crate::ray::{FACE_INSIDE, Ray};

/// A time along the lattice ray: `numerator / denominator` lattice steps.
#[derive(Clone, Copy, Debug)]
pub struct Time {
    /// Not negative.
    pub numerator: i128,
    /// Positive.
    pub denominator: i128,
}

impl Time {
    const ZERO: Time = Time { numerator: 0, denominator: 1 };

    /// In lengths of the ray's direction.
    pub fn in_lengths(self, lattice: &Lattice) -> f64 {
        self.numerator as f64 / self.denominator as f64 / ONE as f64 * (-f64::from(lattice.exponent)).exp2()
    }
}

impl PartialEq for Time {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Time {}

impl PartialOrd for Time {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Time {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.numerator * other.denominator).cmp(&(other.numerator * self.denominator))
    }
}

/// The exact first hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExactHit {
    /// The voxel.
    pub voxel: [i32; 3],
    /// 0 −X … 5 +Z, 6 inside.
    pub face: u32,
    /// Palette index.
    pub material: u16,
    /// When.
    pub time: Time,
}

/// What the exact tracer says about a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The first hit, if there is one.
    pub hit: Option<ExactHit>,
    /// The ray went through an edge or a corner on its way: another rule for ties may give another hit.
    pub tie: bool,
}

/// First solid voxel along a ray. Its `t_max` is not looked at.
pub fn first_hit(world: &World, ray: &Ray) -> Answer {
    let mut tie = false;
    let hit = Lattice::of(ray).and_then(|lattice| Walk::new(world, lattice)?.run(&mut tie));
    Answer { hit, tie }
}

struct Walk<'a> {
    world: &'a World,
    lattice: Lattice,
    /// Box of solid voxels: smallest, and one past the largest coordinates.
    bounds: [[i64; 3]; 2],
    cell: [i64; 3],
    time: Time,
    /// Axes of the last crossing.
    crossed: [bool; 3],
}

impl<'a> Walk<'a> {
    fn new(world: &'a World, lattice: Lattice) -> Option<Self> {
        let bounds = world.bounds()?;
        let bounds = [bounds.min, bounds.max];
        Some(Self { world, lattice, bounds, cell: lattice.cell, time: Time::ZERO, crossed: [false; 3] })
    }

    fn run(mut self, tie: &mut bool) -> Option<ExactHit> {
        self.enter(tie)?;
        while self.inside() {
            let voxel = IVec3::from_array(self.cell.map(|c| c as i32));
            if self.world.chunk(ChunkPos::of_cell(voxel)).is_none() {
                self.leave(6, tie)?;
                continue;
            }
            let material = self.world.voxel(voxel);
            if material != 0 {
                return Some(ExactHit { voxel: voxel.to_array(), face: self.face(), material, time: self.time });
            }
            self.leave(if self.world.mask4(voxel >> 2) == 0 { 2 } else { 0 }, tie)?;
        }
        None
    }

    fn inside(&self) -> bool {
        (0..3).all(|i| self.bounds[0][i] <= self.cell[i] && self.cell[i] < self.bounds[1][i])
    }

    /// When the ray crosses the plane that coordinate `plane` names on an axis.
    fn crossing(&self, axis: usize, plane: i64) -> Option<Time> {
        let (d, cell) = (self.lattice.dir[axis], self.lattice.cell[axis]);
        let ahead = i128::from(plane - cell) * i128::from(ONE) - i128::from(self.lattice.frac[axis]);
        (d != 0).then(|| Time { numerator: ahead * i128::from(d.signum()), denominator: i128::from(d.abs()) })
    }

    /// The ray's cell on an axis at a time; a plane that is reached at that very time counts as crossed.
    fn cell_at(&self, axis: usize, time: Time) -> i64 {
        let (d, frac) = (i128::from(self.lattice.dir[axis]), i128::from(self.lattice.frac[axis]));
        let one = i128::from(ONE);
        let size = time.numerator * d.abs();
        let cells = match d.signum() {
            1 => (size + frac * time.denominator).div_euclid(one * time.denominator),
            -1 => -(size + (one - frac) * time.denominator).div_euclid(one * time.denominator),
            _ => 0,
        };
        self.lattice.cell[axis] + cells as i64
    }

    /// Puts the ray where it is at `time`.
    fn advance(&mut self, time: Time, tie: &mut bool) {
        for axis in 0..3 {
            let cell = self.cell_at(axis, time);
            // The plane behind which the new cell lies may have been crossed earlier.
            let plane = if self.lattice.dir[axis] > 0 { cell } else { cell + 1 };
            self.crossed[axis] = cell != self.cell[axis] && self.crossing(axis, plane) == Some(time);
            self.cell[axis] = cell;
        }
        *tie |= self.crossed.iter().filter(|crossed| **crossed).count() > 1;
        self.time = time;
    }

    /// Leaves the aligned block of 2^`log2` voxels around the current cell.
    fn leave(&mut self, log2: u32, tie: &mut bool) -> Option<()> {
        let planes = [0, 1, 2].map(|axis| {
            let low = self.cell[axis] >> log2 << log2;
            self.crossing(axis, if self.lattice.dir[axis] > 0 { low + (1 << log2) } else { low })
        });
        self.advance(planes.into_iter().flatten().min()?, tie);
        Some(())
    }

    /// From an origin outside the bounds to the first cell inside them, if there is one.
    fn enter(&mut self, tie: &mut bool) -> Option<()> {
        if self.inside() {
            return Some(());
        }
        let mut last = Time::ZERO;
        for axis in 0..3 {
            let [low, high] = [self.bounds[0][axis], self.bounds[1][axis]];
            let (cell, d) = (self.cell[axis], self.lattice.dir[axis]);
            if low <= cell && cell < high {
                continue;
            }
            // It must come from the side that it moves away from.
            if d == 0 || (d > 0) != (cell < low) {
                return None;
            }
            last = last.max(self.crossing(axis, if d > 0 { low } else { high })?);
        }
        self.advance(last, tie);
        Some(())
    }

    fn face(&self) -> u32 {
        let d = self.lattice.dir;
        let steepest = (0..3).filter(|&axis| self.crossed[axis]).max_by_key(|&axis| (d[axis].abs(), 2 - axis));
        steepest.map_or(FACE_INSIDE, |axis| 2 * axis as u32 + u32::from(d[axis] < 0))
    }
}
