//! First hit in exact arithmetic, written to be read: fractions of 128-bit integers, nothing prepared, nothing clever.
//! [`crate::Oracle`] gives the same answers faster.

use glam::IVec3;
pub use raxel_ray::exact::{ExactHit, Passage, Time, face_of};
use raxel_ray::{Lattice, ONE, Ray};
use raxel_world::{ChunkPos, World};

/// The exact tracer's answer about a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The first hit, if there is one.
    pub hit: Option<ExactHit>,
    /// Another rule for ties may give another hit: on its way the ray touches an edge or a corner of a solid voxel that it does not go
    /// through, or enters its hit by one, or begins on the surface of a solid, or lies in a plane of the lattice.
    pub tie: bool,
}

/// Whether one of the cells is solid that a ray only touches when it crosses planes of several axes (bits of `crossed`) at once and
/// arrives in `cell`.
pub(crate) fn touched(cell: [i64; 3], sign: [i64; 3], crossed: u32, solid: impl Fn([i64; 3]) -> bool) -> bool {
    // Every cell around the edge or corner but the first (no axis crossed) and the last (all of them).
    (1..crossed).filter(|some| some & !crossed == 0).any(|some| {
        solid(
            [0, 1, 2].map(|axis| if (crossed & !some) >> axis & 1 == 1 { cell[axis] - sign[axis] } else { cell[axis] }),
        )
    })
}

/// First solid voxel along a ray. Its `t_max` is not looked at.
pub fn first_hit(world: &World, ray: &Ray) -> Answer {
    let mut tie = false;
    let hit = Lattice::of(ray).and_then(|lattice| {
        let walk = Walk::new(world, lattice)?;
        tie = lattice.touches(|cell| solid(world, cell));
        walk.run(&mut tie)
    });
    Answer { hit, tie }
}

fn solid(world: &World, cell: [i64; 3]) -> bool {
    let [x, y, z] = cell.map(i32::try_from);
    matches!((x, y, z), (Ok(x), Ok(y), Ok(z)) if world.voxel(IVec3::new(x, y, z)) != 0)
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

    #[expect(clippy::cast_possible_truncation, reason = "the ray is inside the world, whose cells have 32 bits")]
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
                *tie |= self.crossed.iter().filter(|crossed| **crossed).count() > 1;
                return Some(ExactHit {
                    voxel: voxel.to_array(),
                    face: face_of(self.lattice.dir, self.crossed),
                    material,
                    time: self.time,
                });
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
    #[expect(clippy::cast_possible_truncation, reason = "the ray is inside the world, whose cells have 32 bits")]
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
        let crossed = (0..3).filter(|&axis| self.crossed[axis]).fold(0, |bits, axis| bits | 1 << axis);
        *tie |= touched(self.cell, self.lattice.dir.map(i64::signum), crossed, |cell| solid(self.world, cell));
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
}
