//! Caves: tunnels along the curves where two noises in space are both near zero.
//!
//! The noises are sampled where all three coordinates are multiples of 4, and are trilinear in between: a voxel is hollow if both,
//! interpolated at its centre, are smaller than the width. So a chunk takes 17³ samples of each, and 4³ voxels between samples that all
//! are on one side of the width need no closer look.

#![allow(clippy::inline_always, reason = "what is not inlined is not compiled for the processor at hand")]

use pulp::{Arch, Simd, WithSimd};
use raxel_world::child_index;

use crate::noise::{Noise, Sampler};

/// Hollows in the land.
#[derive(Clone, Debug)]
pub struct Caves {
    /// The two noises whose common zeros the tunnels follow.
    pub noises: [Noise; 2],
    /// How far from zero the noises may be, in (0, 1): wider tunnels.
    pub width: f64,
    /// Voxels of land that stay above them; where there is water, at least [`Caves::UNDER_WATER`].
    pub cover: i64,
    /// No voxel below this is hollow.
    pub above: Option<i64>,
    /// No voxel at this height or higher is hollow.
    pub below: Option<i64>,
}

/// Voxels between samples.
const STEP: i64 = 4;
/// Samples along an edge of a chunk.
const SAMPLES: usize = 17;
/// Samples that are made at once, one above the other: below the land, all of them are needed.
const GROUP: usize = 8;
/// Room for the samples of a column of them.
const COLUMN: usize = SAMPLES.next_multiple_of(GROUP);

/// A noise at the corners of a 4³ block: of its four vertical edges, those along x first, the lower end and the upper one.
type Corners = [[f64; 2]; 4];

impl Caves {
    /// Voxels of land that stay between caves and water.
    pub const UNDER_WATER: i64 = 4;

    /// Made ready to be sampled.
    pub(crate) fn field(&self) -> CaveField<'_> {
        CaveField { caves: self, samplers: self.noises.each_ref().map(Noise::sampler) }
    }

    /// Heights in which a voxel can be hollow.
    pub(crate) fn heights(&self) -> (i64, i64) {
        (self.above.unwrap_or(i64::MIN), self.below.unwrap_or(i64::MAX))
    }
}

/// Caves made ready to be sampled.
pub(crate) struct CaveField<'c> {
    caves: &'c Caves,
    samplers: [Sampler; 2],
}

/// The samples of one chunk, made when they are first needed: above the land none is, and the second noise is where the first one is near
/// zero.
pub(crate) struct CaveChunk<'c> {
    field: CaveField<'c>,
    /// The chunk's smallest voxel.
    origin: [i64; 3],
    /// Of each noise.
    samples: [Samples; 2],
}

/// Samples of a noise in columns, those along x first.
struct Samples {
    of: Vec<[f64; COLUMN]>,
    /// A bit for each group of a column that is made.
    made: Vec<u8>,
}

impl<'c> CaveField<'c> {
    /// The samples of the chunk whose smallest voxel is `origin`.
    pub(crate) fn chunk(self, origin: [i64; 3]) -> CaveChunk<'c> {
        let samples = || Samples { of: vec![[0.0; COLUMN]; SAMPLES * SAMPLES], made: vec![0; SAMPLES * SAMPLES] };
        CaveChunk { field: self, origin, samples: [samples(), samples()] }
    }

    /// Whether one voxel is hollow, its cover not looked at.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        reason = "places in a field's grid are small, and the cell lies at or above its corner"
    )]
    pub(crate) fn is_hollow(&self, cell: [i64; 3]) -> bool {
        let (low, high) = self.caves.heights();
        if cell[1] < low || cell[1] >= high {
            return false;
        }
        let corner = cell.map(|c| c & !(STEP - 1));
        let at = [(0, 1), (1, 0), (2, 2)].map(|(axis, bit)| {
            std::array::from_fn::<f64, 8, _>(|n| (corner[axis] + (n as i64 >> bit & 1) * STEP) as f64)
        });
        let local = [0, 1, 2].map(|i| (cell[i] - corner[i]) as u32);
        let bit = child_index(local[0], local[1], local[2]);
        let is_near = |sampler: &Sampler| {
            let values = sampler.in_space(at);
            let corners: Corners = std::array::from_fn(|column| [values[2 * column], values[2 * column + 1]]);
            near_zero(&corners, self.caves.width) >> bit & 1 == 1
        };
        self.samplers.iter().all(is_near)
    }
}

impl CaveChunk<'_> {
    /// One noise at the corners of a 4³ block.
    fn corners(&mut self, noise: usize, cell: [u32; 3]) -> Corners {
        let [x, y, z] = cell.map(|c| c as usize);
        std::array::from_fn(|column| self.pair(noise, [x + (column & 1), y, z + (column >> 1)]))
    }

    /// A sample, and the one above it.
    #[inline(always)]
    fn pair(&mut self, noise: usize, [x, y, z]: [usize; 3]) -> [f64; 2] {
        let at = z * SAMPLES + x;
        let needed = 1 << (y / GROUP) | 1 << ((y + 1) / GROUP);
        let lacking = needed & !self.samples[noise].made[at];
        if lacking != 0 {
            self.make(noise, [x, z], lacking);
        }
        let samples = &self.samples[noise].of[at];
        [samples[y], samples[y + 1]]
    }

    /// Makes groups of a column of samples, a bit each.
    #[cold]
    #[expect(
        clippy::cast_possible_wrap,
        reason = "places in a field's grid are small, and the cell lies at or above its corner"
    )]
    fn make(&mut self, noise: usize, [x, z]: [usize; 2], groups: u8) {
        let Samples { of, made } = &mut self.samples[noise];
        let at = z * SAMPLES + x;
        made[at] |= groups;
        let place = |local: usize, axis: usize| (self.origin[axis] + local as i64 * STEP) as f64;
        let [x, z] = [place(x, 0), place(z, 2)];
        let sampler = &self.field.samplers[noise];
        for group in (0..SAMPLES.div_ceil(GROUP)).filter(|group| groups >> group & 1 == 1) {
            let first = group * GROUP;
            if first + 1 == SAMPLES {
                [of[at][first]] = sampler.in_space([[x], [place(first, 1)], [z]]);
            } else {
                let heights = std::array::from_fn(|n| place(first + n, 1));
                let values: [f64; GROUP] = sampler.in_space([[x; GROUP], heights, [z; GROUP]]);
                of[at][first..first + GROUP].copy_from_slice(&values);
            }
        }
    }

    /// The hollow voxels of a 4³ block, before the test of their cover. `cell` is the block's place in the chunk, each component in 0…15.
    pub(crate) fn mask(&mut self, cell: [u32; 3]) -> u64 {
        let width = self.field.caves.width;
        // Trilinear values lie between those of the corners.
        let is_solid = |corners: &Corners| {
            let all = |beyond: fn(f64, f64) -> bool| corners.as_flattened().iter().all(|c| beyond(*c, width));
            all(|c, width| c >= width) || all(|c, width| c <= -width)
        };
        let first = self.corners(0, cell);
        if is_solid(&first) {
            return 0;
        }
        let second = self.corners(1, cell);
        if is_solid(&second) {
            return 0;
        }
        let (low, high) = self.field.caves.heights();
        let y = self.origin[1] + i64::from(cell[1]) * STEP;
        let near = near_zero(&first, width);
        if near == 0 {
            return 0;
        }
        let rows = (0..STEP).filter(|row| (low..high).contains(&(y + row)));
        rows.fold(0, |mask, row| mask | 0xffff << (16 * row)) & near & near_zero(&second, width)
    }
}

/// The voxels of a block at whose centres one noise, trilinear between the corners, is near zero.
fn near_zero(corners: &Corners, width: f64) -> u64 {
    Arch::new().dispatch(NearZero { corners, width })
}

/// [`near_zero`], for any processor.
struct NearZero<'c> {
    corners: &'c Corners,
    width: f64,
}

impl WithSimd for NearZero<'_> {
    type Output = u64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> u64 {
        let Self { corners, width } = self;
        // The weights are multiples of an eighth.
        let between = |a: f64, b: f64, at: usize| a + (b - a) * ((at as f64 + 0.5) / STEP as f64);
        // Four voxels along x at once.
        let along_x: [[f64; 4]; 4] = std::array::from_fn(|edge| {
            let (y, z) = (edge & 1, edge & 2);
            std::array::from_fn(|x| between(corners[z][y], corners[z + 1][y], x))
        });
        let rows = |low: [f64; 4], high: [f64; 4], at: usize| -> [f64; 4] {
            std::array::from_fn(|x| between(low[x], high[x], at))
        };
        let mut mask = 0;
        for y in 0..4 {
            let [front, back] = [0, 2].map(|z| rows(along_x[z], along_x[z + 1], y));
            for z in 0..4 {
                let values = rows(front, back, z);
                let near: u64 = (0..4).map(|x| u64::from(values[x].abs() < width) << x).sum();
                mask |= near << (z << 2 | y << 4);
            }
        }
        mask
    }
}
