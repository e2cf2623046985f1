//! The exact tracer, made fast for one world: a walk in whole numbers that steps over empty blocks.
//!
//! # Method
//! Everything is mirrored so that the ray moves up on every axis. With G its fraction and D its direction on the lattice, it crosses
//! the n-th plane of an axis at the time (n·2²⁴ − G) / D; call the numerator N. Instead of times, the walk keeps for each pair of axes the
//! *cross difference* of their next crossings
//!
//! > e(a, b) = N(a)·D(b) − N(b)·D(a),
//!
//! whose sign decides which plane is crossed first (a positive one: that of b; zero: both at once). A crossing of a adds 2²⁴·D(b), so
//! following the ray takes additions only; how many planes of b are crossed until the ray leaves a block by a plane of a is one division.
//! This is the integer form of the walk of Amanatides and Woo (1987), in which nothing is ever rounded.
//!
//! # Range
//! A crossing of a lies at most a block of s voxels ahead of the ray, and so does one of b: they differ by at most s·2²⁴ / min(D(a), D(b))
//! lattice steps (an axis that stands still has N = 2²⁴), hence |e(a, b)| ≤ s·2²⁴·max(D(a), D(b)) < s·2⁵⁵: up to blocks of 64 voxels this fits
//! 62 bits. Longer steps, and the way from an origin outside the world, are computed from the origin in 128 bits.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

use raxel_ray::{Lattice, ONE, Ray};
use raxel_world::random::mix;
use raxel_world::{Chunk, World};

use crate::exact::{Answer, ExactHit, Time, face_of, touched};

/// A world, prepared for exact rays.
pub struct Oracle<'w> {
    world: &'w World,
    /// Smallest, and one past the largest coordinates of solids; the same twice in an empty world.
    bounds: [[i64; 3]; 2],
    chunks: HashMap<u128, usize, BuildHasherDefault<Mix>>,
    distinct: Vec<Prepared<'w>>,
    /// `coarse[i]` are the cubes of 2^(8 + 2i) voxels a side that hold solids.
    coarse: Vec<HashSet<u128, BuildHasherDefault<Mix>>>,
}

/// A chunk with the masks that empty blocks are found by.
struct Prepared<'w> {
    chunk: &'w Chunk,
    /// Which 16³ nodes have solids.
    root: u64,
    /// Which 4³ blocks of each node have solids.
    nodes: [u64; 64],
}

/// Mixes a key into a hash.
#[derive(Default)]
struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = mix(self.0.rotate_left(5) ^ word);
    }

    #[expect(clippy::cast_possible_truncation, reason = "both halves of the word are taken")]
    fn write_u128(&mut self, word: u128) {
        self.write_u64(word as u64 ^ ((word >> 64) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    }
}

/// The cube of 2^`log2` voxels a side that holds a cell.
#[expect(clippy::cast_sign_loss, reason = "40 bits of each coordinate are kept")]
fn key(cell: [i64; 3], log2: u32) -> u128 {
    cell.iter().fold(0, |key, c| key << 40 | ((c >> log2) as u128 & 0xff_ffff_ffff))
}

const SMALLEST_COARSE: u32 = 8;

impl<'w> Oracle<'w> {
    /// Prepares a world. Takes about as long as looking at each 4³ block of each different chunk once.
    pub fn new(world: &'w World) -> Self {
        let bounds = world.bounds().map_or([[0; 3]; 2], |bounds| [bounds.min, bounds.max]);
        let mut known: HashMap<*const Chunk, usize> = HashMap::new();
        let (mut chunks, mut distinct) = (HashMap::default(), Vec::new());
        let span = (0..3).map(|axis| bounds[1][axis] - bounds[0][axis]).max().unwrap_or(0);
        let mut coarse: Vec<HashSet<u128, _>> = Vec::new();
        for (pos, chunk) in world.chunks() {
            let index = *known.entry(std::sync::Arc::as_ptr(chunk)).or_insert_with(|| {
                distinct.push(Prepared {
                    chunk,
                    root: chunk.root_mask(),
                    nodes: std::array::from_fn(|node| chunk.node_mask(node)),
                });
                distinct.len() - 1
            });
            let cell = pos.origin().to_array().map(i64::from);
            chunks.insert(key(cell, 6), index);
            for (level, log2) in (SMALLEST_COARSE..32).step_by(2).take_while(|log2| span >> log2 > 1).enumerate() {
                if coarse.len() == level {
                    coarse.push(HashSet::default());
                }
                coarse[level].insert(key(cell, log2));
            }
        }
        Self { world, bounds, chunks, distinct, coarse }
    }

    /// The world.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// First solid voxel along a ray, exactly; the same answer as [`crate::exact::first_hit`]. Its `t_max` is not looked at.
    pub fn first_hit(&self, ray: &Ray) -> Answer {
        let mut answer = Answer { hit: None, tie: false };
        if let Some(lattice) = Lattice::of(ray).filter(|_| !self.chunks.is_empty())
            && let Some(mut walk) = Walk::new(self, &lattice, &mut answer.tie)
        {
            answer.hit = walk.run(self, &mut answer.tie).map(|material| walk.hit(&lattice, material));
        }
        answer
    }

    /// Smallest, and one past the largest coordinates of solids.
    pub(crate) fn bounds(&self) -> [[i64; 3]; 2] {
        self.bounds
    }

    /// The material of a voxel; or the binary logarithm of an aligned cube around it in which nothing is solid.
    #[expect(clippy::cast_sign_loss, reason = "the lowest bits of a cell are not negative")]
    pub(crate) fn look(&self, cell: [i64; 3]) -> Result<u16, u32> {
        let Some(prepared) = self.chunk(cell) else { return Err(self.empty_around(cell)) };
        let at = |shift: u32| {
            let [x, y, z] = cell.map(|c| (c >> shift & 3) as u32);
            raxel_world::child_index(x, y, z)
        };
        let (node, block) = (at(4), at(2));
        if prepared.root >> node & 1 == 0 {
            Err(4)
        } else if prepared.nodes[node as usize] >> block & 1 == 0 {
            Err(2)
        } else if prepared.chunk.mask((node << 6 | block) as usize) >> at(0) & 1 == 0 {
            Err(0)
        } else {
            let [x, y, z] = cell.map(|c| (c & 63) as u32);
            Ok(prepared.chunk.voxel(x, y, z))
        }
    }

    fn inside(&self, cell: [i64; 3]) -> bool {
        (0..3).all(|axis| self.bounds[0][axis] <= cell[axis] && cell[axis] < self.bounds[1][axis])
    }

    fn chunk(&self, cell: [i64; 3]) -> Option<&Prepared<'w>> {
        self.chunks.get(&key(cell, 6)).map(|&index| &self.distinct[index])
    }

    #[expect(clippy::cast_sign_loss, reason = "the lowest bits of a cell are not negative")]
    fn solid(&self, cell: [i64; 3]) -> bool {
        let [x, y, z] = cell.map(|c| (c & 63) as u32);
        self.chunk(cell).is_some_and(|prepared| prepared.chunk.voxel(x, y, z) != 0)
    }

    /// The size of an empty cube around a cell without a chunk.
    #[expect(clippy::cast_possible_truncation, reason = "there are a few levels")]
    fn empty_around(&self, cell: [i64; 3]) -> u32 {
        let log2 = |level: usize| SMALLEST_COARSE + 2 * level as u32;
        let empty = (0..self.coarse.len()).rev().find(|&level| !self.coarse[level].contains(&key(cell, log2(level))));
        empty.map_or(6, log2)
    }
}

/// A ray on its way.
struct Walk {
    cell: [i64; 3],
    /// Cell of the origin.
    origin: [i64; 3],
    /// Which way each axis goes.
    sign: [i64; 3],
    /// Mirrored fraction; 0 where the ray stands still.
    g: [i64; 3],
    /// Size of the direction.
    d: [i64; 3],
    /// The same times 2²⁴.
    u: [i64; 3],
    /// Cross differences of the next crossings: x and y, x and z, y and z.
    e: [i64; 3],
    /// Axes of the last crossing, as bits.
    crossed: u32,
}

impl Walk {
    /// The ray in its own cell, or in the first one inside the world's bounds, if it ever is inside.
    fn new(oracle: &Oracle<'_>, lattice: &Lattice, tie: &mut bool) -> Option<Self> {
        let sign = lattice.dir.map(|d| if d < 0 { -1 } else { 1 });
        let d = lattice.dir.map(i64::abs);
        let g = [0, 1, 2].map(|axis| match lattice.dir[axis] {
            0 => 0,
            1.. => lattice.frac[axis],
            _ => ONE - lattice.frac[axis],
        });
        let (cell, origin) = (lattice.cell, lattice.cell);
        let mut walk = Self { cell, origin, sign, g, d, u: d.map(|d| d * ONE), e: [0; 3], crossed: 0 };
        walk.rebase();
        *tie |= lattice.touches(|cell| oracle.solid(cell));
        if !oracle.inside(walk.cell) {
            walk.enter(oracle, tie)?;
        }
        Some(walk)
    }

    /// Planes of an axis crossed since the origin.
    fn count(&self, axis: usize) -> i128 {
        i128::from((self.cell[axis] - self.origin[axis]) * self.sign[axis])
    }

    /// Numerator of the n-th crossing of an axis.
    fn numerator(&self, axis: usize, n: i128) -> i128 {
        n * i128::from(ONE) - i128::from(self.g[axis])
    }

    /// Finds the cross differences from where the ray is; they fit, see the head of this file.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "cells on the way have 64 bits, those of the world 32, and the lowest bits of a cell are not negative"
    )]
    fn rebase(&mut self) {
        let next = [0, 1, 2].map(|axis| self.numerator(axis, self.count(axis) + 1));
        let d = self.d.map(i128::from);
        self.e = [(0, 1), (0, 2), (1, 2)].map(|(a, b)| (next[a] * d[b] - next[b] * d[a]) as i64);
    }

    fn cross_difference(&self, a: usize, b: usize) -> i64 {
        if a < b { self.e[a + b - 1] } else { -self.e[a + b - 1] }
    }

    /// Follows the ray until it has crossed the n-th plane of an axis since its origin.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "cells on the way have 64 bits, those of the world 32, and the lowest bits of a cell are not negative"
    )]
    fn jump(&mut self, oracle: &Oracle<'_>, axis: usize, n: i128, tie: &mut bool) {
        let numerator = self.numerator(axis, n);
        let d = i128::from(self.d[axis]);
        self.crossed = 1 << axis;
        self.cell[axis] = self.origin[axis] + self.sign[axis] * n as i64;
        for other in (0..3).filter(|&other| other != axis) {
            let passed = numerator * i128::from(self.d[other]) + i128::from(self.g[other]) * d;
            let planes = passed / (i128::from(ONE) * d);
            let cell = self.origin[other] + self.sign[other] * planes as i64;
            if cell != self.cell[other] && passed % (i128::from(ONE) * d) == 0 {
                self.crossed |= 1 << other;
            }
            self.cell[other] = cell;
        }
        self.rebase();
        self.notice(oracle, tie);
    }

    /// From outside the bounds to the first cell inside them.
    fn enter(&mut self, oracle: &Oracle<'_>, tie: &mut bool) -> Option<()> {
        let mut last: Option<(usize, i128)> = None;
        for axis in 0..3 {
            let [low, high] = [oracle.bounds[0][axis], oracle.bounds[1][axis]];
            if (low..high).contains(&self.cell[axis]) {
                continue;
            }
            let planes = if self.sign[axis] > 0 { low - self.cell[axis] } else { self.cell[axis] - (high - 1) };
            if self.d[axis] == 0 || planes <= 0 {
                return None;
            }
            let n = i128::from(planes);
            let later = last.is_none_or(|(b, n_b)| {
                self.numerator(axis, n) * i128::from(self.d[b]) > self.numerator(b, n_b) * i128::from(self.d[axis])
            });
            if later {
                last = Some((axis, n));
            }
        }
        let (axis, n) = last?;
        self.jump(oracle, axis, n, tie);
        Some(())
    }

    /// The material of the first solid voxel; then the ray is in it.
    #[expect(
        clippy::cast_sign_loss,
        reason = "cells on the way have 64 bits, those of the world 32, and the lowest bits of a cell are not negative"
    )]
    fn run(&mut self, oracle: &Oracle<'_>, tie: &mut bool) -> Option<u16> {
        while oracle.inside(self.cell) {
            let Some(prepared) = oracle.chunk(self.cell) else {
                self.leave(oracle, oracle.empty_around(self.cell), tie);
                continue;
            };
            let chunk = self.cell.map(|c| c >> 6);
            while self.cell.map(|c| c >> 6) == chunk {
                let at = |shift: u32| {
                    let [x, y, z] = self.cell.map(|c| (c >> shift & 3) as u32);
                    raxel_world::child_index(x, y, z)
                };
                let (node, block) = (at(4), at(2));
                if prepared.root >> node & 1 == 0 {
                    self.leave(oracle, 4, tie);
                } else if prepared.nodes[node as usize] >> block & 1 == 0 {
                    self.leave(oracle, 2, tie);
                } else if prepared.chunk.mask((node << 6 | block) as usize) >> at(0) & 1 == 0 {
                    self.leave(oracle, 0, tie);
                } else {
                    *tie |= self.crossed.count_ones() > 1;
                    let [x, y, z] = self.cell.map(|c| (c & 63) as u32);
                    return Some(prepared.chunk.voxel(x, y, z));
                }
            }
        }
        None
    }

    /// Leaves the aligned block of 2^`log2` voxels around the current cell.
    fn leave(&mut self, oracle: &Oracle<'_>, log2: u32, tie: &mut bool) {
        // Planes up to the one where each axis leaves.
        let size = 1i64 << log2;
        let planes: [i64; 3] = std::array::from_fn(|axis| {
            let place = self.cell[axis] & (size - 1);
            if self.sign[axis] > 0 { size - place } else { place + 1 }
        });
        if log2 > 6 {
            return self.leave_far(oracle, planes, tie);
        }
        let exit = |walk: &Self, a: usize, b: usize| {
            walk.cross_difference(a, b) + (planes[a] - 1) * walk.u[b] - (planes[b] - 1) * walk.u[a]
        };
        let mut a = usize::from(exit(self, 0, 1) > 0);
        if exit(self, a, 2) > 0 {
            a = 2;
        }
        self.crossed = 1 << a;
        let mut moved = [0; 3];
        moved[a] = planes[a];
        for b in (0..3).filter(|&b| b != a) {
            let ahead = self.cross_difference(a, b) + (planes[a] - 1) * self.u[b];
            if ahead >= 0 {
                moved[b] = ahead / self.u[a] + 1;
                self.crossed |= u32::from(ahead % self.u[a] == 0) << b;
            }
        }
        for (axis, planes) in moved.into_iter().enumerate() {
            self.cell[axis] += self.sign[axis] * planes;
        }
        let u = self.u;
        self.e[0] += moved[0] * u[1] - moved[1] * u[0];
        self.e[1] += moved[0] * u[2] - moved[2] * u[0];
        self.e[2] += moved[1] * u[2] - moved[2] * u[1];
        self.notice(oracle, tie);
    }

    /// The same for a block of any size.
    fn leave_far(&mut self, oracle: &Oracle<'_>, planes: [i64; 3], tie: &mut bool) {
        let exits = [0, 1, 2].map(|axis| self.count(axis) + i128::from(planes[axis]));
        let moving = (0..3).filter(|&axis| self.d[axis] != 0);
        let first = moving.reduce(|a, b| {
            let (of_a, of_b) = (self.numerator(a, exits[a]), self.numerator(b, exits[b]));
            if of_a * i128::from(self.d[b]) <= of_b * i128::from(self.d[a]) { a } else { b }
        });
        let first = first.expect("the largest component is no zero");
        self.jump(oracle, first, exits[first], tie);
    }

    /// Looks at the cells that are only touched by a crossing of several axes.
    fn notice(&self, oracle: &Oracle<'_>, tie: &mut bool) {
        if self.crossed.count_ones() > 1 && !*tie {
            *tie = touched(self.cell, self.sign, self.crossed, |cell| oracle.solid(cell));
        }
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "cells on the way have 64 bits, those of the world 32, and the lowest bits of a cell are not negative"
    )]
    fn hit(&self, lattice: &Lattice, material: u16) -> ExactHit {
        let crossed = [0, 1, 2].map(|axis| self.crossed >> axis & 1 == 1);
        let face = face_of(lattice.dir, crossed);
        let time = match (face / 2) as usize {
            axis @ 0..3 => {
                Time { numerator: self.numerator(axis, self.count(axis)), denominator: i128::from(self.d[axis]) }
            }
            _ => Time::ZERO,
        };
        ExactHit { voxel: self.cell.map(|c| c as i32), face, material, time }
    }
}

#[cfg(test)]
mod tests {
    use glam::IVec3;

    use super::*;

    #[test]
    fn coarse_cubes_are_empty_and_large() {
        let voxels = [[0, 0, 0], [1 << 20, 5, 5], [-(1 << 30), 7, 1 << 29]].map(|cell| (IVec3::from_array(cell), 1));
        let world = World::from_voxels(crate::scenes::materials(), voxels);
        let oracle = Oracle::new(&world);
        assert_eq!(oracle.empty_around([100, 0, 0]), 6, "its cube of 256 holds a voxel");
        assert_eq!(oracle.empty_around([300, 0, 0]), 8);
        assert!(oracle.empty_around([-(1 << 25), 1 << 5, 1 << 5]) >= 24);
        for (cell, _) in world.voxels() {
            let cell = cell.to_array().map(i64::from);
            assert!(oracle.coarse.iter().zip((8..).step_by(2)).all(|(set, log2)| set.contains(&key(cell, log2))));
        }
    }
}
