//! Land: a height for every column from fractal noise, and materials by depth, height and slope.

use fastnoise_lite::{FastNoiseLite, NoiseType};

use crate::build::{Target, local_part};
use crate::chunk::block_index;
use crate::dense::Mode;
use crate::material::MaterialIndex;
use crate::world::Bounds;

/// Fractal noise over the plane: octaves of OpenSimplex2, each finer and weaker than the last.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Same seed, same land.
    pub seed: u64,
    /// Waves a voxel of the first octave.
    pub frequency: f64,
    /// How many octaves, 1…16.
    pub octaves: u32,
    /// Frequency of an octave over that of the one before.
    pub lacunarity: f64,
    /// Strength of an octave over that of the one before.
    pub gain: f64,
    /// Fold every octave, so that its zeros become sharp crests.
    pub ridges: bool,
}

impl Noise {
    /// Coordinates in waves must stay below this, so that the lattice of the noise fits 32 bits after its skew.
    pub const MAX_WAVES: f64 = 1e9;

    /// Waves of the finest octave at a distance of `reach` voxels from the origin.
    pub fn waves(&self, reach: f64) -> f64 {
        reach * self.frequency * self.lacunarity.powi(self.octaves as i32 - 1).max(1.0)
    }

    fn sampler(&self) -> Sampler {
        let mut strength = 1.0;
        let mut frequency = self.frequency;
        let octaves: Vec<_> = (0..self.octaves)
            .map(|octave| {
                let seed = crate::random::mix(self.seed.wrapping_add(u64::from(octave)));
                let mut noise = FastNoiseLite::with_seed(seed as u32 as i32);
                noise.set_noise_type(Some(NoiseType::OpenSimplex2));
                noise.set_frequency(Some(1.0));
                let this = (noise, frequency, strength);
                frequency *= self.lacunarity;
                strength *= self.gain;
                this
            })
            .collect();
        let total: f64 = octaves.iter().map(|(_, _, strength)| strength).sum();
        Sampler { octaves, scale: 1.0 / total, ridges: self.ridges }
    }
}

/// Noise made ready to be sampled.
struct Sampler {
    octaves: Vec<(FastNoiseLite, f64, f64)>,
    scale: f64,
    ridges: bool,
}

impl Sampler {
    /// In −1…1.
    fn at(&self, x: f64, z: f64) -> f64 {
        let mut sum = 0.0;
        for (noise, frequency, strength) in &self.octaves {
            let value = f64::from(noise.get_noise_2d(x * frequency, z * frequency));
            sum += strength * if self.ridges { 1.0 - 2.0 * value.abs() } else { value };
        }
        (sum * self.scale).clamp(-1.0, 1.0)
    }
}

/// A material of the ground, from the surface down.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Palette index.
    pub material: MaterialIndex,
    /// Voxels that it is deep; down to the floor for the last one.
    pub depth: i64,
}

/// Where another material takes the place of the uppermost layer. All conditions that are there must hold.
#[derive(Clone, Debug)]
pub struct Band {
    /// Palette index.
    pub material: MaterialIndex,
    /// Surface at this height or higher.
    pub above: Option<i64>,
    /// Surface lower than this.
    pub below: Option<i64>,
    /// At least so many voxels between this column and its highest or lowest neighbour.
    pub slope: Option<i64>,
    /// Voxels that it is deep.
    pub depth: i64,
}

/// Fills what lies lower than a level and is not land.
#[derive(Clone, Debug)]
pub struct Water {
    /// Palette index.
    pub material: MaterialIndex,
    /// The first voxel above the water.
    pub level: i64,
}

/// Valleys along the zeros of a second noise: they meander, and never end inside the land.
#[derive(Clone, Debug)]
pub struct River {
    /// The second noise.
    pub noise: Noise,
    /// Height of the bed.
    pub bed: f64,
    /// Half the width of the bed, about, in voxels.
    pub width: f64,
    /// Voxels, about, over which the land rises from the bed to its own height.
    pub banks: f64,
}

/// A height field.
#[derive(Clone, Debug)]
pub struct Terrain {
    /// Smallest x and z.
    pub min: [i64; 2],
    /// One past the largest x and z.
    pub max: [i64; 2],
    /// Height of the lowest land.
    pub base: f64,
    /// From the lowest to the highest land.
    pub amplitude: f64,
    /// Above 1, low land becomes wider and high land steeper: the noise in 0…1 is raised to this power.
    pub exponent: u32,
    /// What makes the heights.
    pub noise: Noise,
    /// Valleys.
    pub river: Option<River>,
    /// The land has no voxel below this.
    pub floor: i64,
    /// Only so many voxels below the surface, and what a neighbour's lower surface lays bare.
    pub shell: Option<i64>,
    /// At least one.
    pub layers: Vec<Layer>,
    /// The first that fits counts.
    pub bands: Vec<Band>,
    /// Lakes.
    pub water: Option<Water>,
    /// Add, subtract or paint.
    pub mode: Mode,
}

/// Everything about one column of voxels that its chunks share.
#[derive(Clone, Copy, Debug, Default)]
struct Column {
    /// Whether the terrain covers it.
    inside: bool,
    /// The first voxel above the land.
    height: i64,
    /// The lowest voxel.
    bottom: i64,
    /// Of the uppermost layer.
    surface: MaterialIndex,
    /// Lower end of the uppermost layer.
    surface_end: i64,
}

/// The 64 × 64 columns of a column of chunks, in 4 × 4 tiles: tile `tx + 16·tz`, then `x + 4·z` in it.
pub(crate) struct Surface(Vec<Column>);

/// Bits of the lowest n voxels of the first column of a block.
const PREFIX: [u64; 5] = [0, 1, 0x1_0001, 0x1_0001_0001, 0x0001_0001_0001_0001];

impl Terrain {
    /// A box around everything that it can touch.
    pub fn bounds(&self) -> Bounds {
        let land = self.river.as_ref().map_or(self.base, |river| self.base.max(river.bed)) + self.amplitude;
        let top = (land.ceil() as i64).max(self.water.as_ref().map_or(i64::MIN, |water| water.level)).max(self.floor);
        Bounds { min: [self.min[0], self.floor, self.min[1]], max: [self.max[0], top, self.max[1]] }
    }

    /// Works out the columns of the chunks at (`chunk_x`, `chunk_z`), with their neighbours' heights.
    pub(crate) fn surface(&self, chunk_x: i32, chunk_z: i32) -> Surface {
        const EDGE: usize = 66;
        let noise = self.noise.sampler();
        let river = self.river.as_ref().map(|river| (river, river.noise.sampler()));
        let origin = [i64::from(chunk_x) * 64, i64::from(chunk_z) * 64];
        let needs_neighbours = self.shell.is_some() || self.bands.iter().any(|band| band.slope.is_some());
        let mut heights = vec![0i64; EDGE * EDGE];
        for (i, height) in heights.iter_mut().enumerate() {
            let (x, z) = (i % EDGE, i / EDGE);
            let border = x == 0 || z == 0 || x == EDGE - 1 || z == EDGE - 1;
            if needs_neighbours || !border {
                *height = self.height(&noise, river.as_ref(), origin[0] + x as i64 - 1, origin[1] + z as i64 - 1);
            }
        }
        let columns = (0..4096).map(|i| {
            let (tile, inside) = (i / 16, i % 16);
            let (x, z) = (tile % 16 * 4 + inside % 4, tile / 16 * 4 + inside / 4);
            let at = (z + 1) * EDGE + x + 1;
            let neighbours = [heights[at - 1], heights[at + 1], heights[at - EDGE], heights[at + EDGE]];
            let in_area = (self.min[0]..self.max[0]).contains(&(origin[0] + x as i64))
                && (self.min[1]..self.max[1]).contains(&(origin[1] + z as i64));
            if in_area { self.column(heights[at], neighbours) } else { Column::default() }
        });
        Surface(columns.collect())
    }

    fn height(&self, noise: &Sampler, river: Option<&(&River, Sampler)>, x: i64, z: i64) -> i64 {
        let (x, z) = (x as f64 + 0.5, z as f64 + 0.5);
        let unit = f64::midpoint(noise.at(x, z), 1.0);
        let raised = (1..self.exponent).fold(unit, |power, _| power * unit);
        let mut height = self.base + self.amplitude * raised;
        if let Some((river, noise)) = river {
            // Near its zeros the noise grows by about two for each wave: distance is value over slope.
            let distance = noise.at(x, z).abs() / (2.0 * river.noise.frequency);
            let t = ((distance - river.width) / river.banks).clamp(0.0, 1.0);
            height = river.bed + (height - river.bed) * (t * t * (3.0 - 2.0 * t));
        }
        height.floor() as i64
    }

    fn column(&self, height: i64, neighbours: [i64; 4]) -> Column {
        let height = height.max(self.floor);
        let lowest = neighbours.into_iter().fold(height, i64::min);
        let slope = neighbours.iter().map(|n| (n - height).abs()).max().unwrap_or(0);
        let band = self.bands.iter().find(|band| {
            band.above.is_none_or(|above| height >= above)
                && band.below.is_none_or(|below| height < below)
                && band.slope.is_none_or(|least| slope >= least)
        });
        let (surface, depth) =
            band.map_or((self.layers[0].material, self.layers[0].depth), |band| (band.material, band.depth));
        let bottom = self.shell.map_or(self.floor, |shell| (height - shell).min(lowest).max(self.floor));
        Column { inside: true, height, bottom, surface, surface_end: height.saturating_sub(depth) }
    }

    pub(crate) fn apply(&self, target: &mut Target<'_>, surface: &Surface) {
        let Some((low, high)) = local_part(&self.bounds(), target.pos) else { return };
        let origin_y = i64::from(target.pos.origin().y);
        let deepest = self.layers[self.layers.len() - 1].material;
        // Where the last layer begins, below the surface.
        let above_last: i64 = self.layers[..self.layers.len() - 1].iter().map(|layer| layer.depth).sum();
        for tile in 0..256 {
            let columns = &surface.0[tile * 16..][..16];
            let (tx, tz) = (tile as u32 % 16, tile as u32 / 16);
            let level = self.water.as_ref().map_or(i64::MIN, |water| water.level);
            let top = columns.iter().map(|c| if c.inside { c.height.max(level) } else { i64::MIN }).max();
            let whole = |c: &Column| (c.bottom, c.surface_end.min(c.height.saturating_sub(above_last)));
            let solid_from = columns.iter().map(|c| whole(c).0).max().unwrap_or(i64::MAX);
            let solid_to = columns.iter().map(|c| whole(c).1).min().unwrap_or(i64::MIN);
            for by in (low[1] >> 2)..=((high[1] - 1) >> 2) {
                let y = origin_y + i64::from(by) * 4;
                if top.is_none_or(|top| y >= top) {
                    break;
                }
                let block = block_index(tx, by as u32, tz);
                if y >= solid_from && y + 4 <= solid_to {
                    target.chunk.apply(block, u64::MAX, self.mode, deepest);
                } else {
                    self.apply_block(target, block, y, columns);
                }
            }
        }
    }

    fn apply_block(&self, target: &mut Target<'_>, block: usize, y: i64, columns: &[Column]) {
        let mut masks: Vec<(MaterialIndex, u64)> = Vec::with_capacity(self.layers.len() + 2);
        for (i, column) in columns.iter().enumerate() {
            let mut fill = |material: MaterialIndex, from: i64, to: i64| {
                let from = (from.max(column.bottom) - y).clamp(0, 4) as usize;
                let to = (to - y).clamp(0, 4) as usize;
                if from >= to {
                    return;
                }
                let bits = (PREFIX[to] ^ PREFIX[from]) << i;
                match masks.iter_mut().find(|(m, _)| *m == material) {
                    Some((_, mask)) => *mask |= bits,
                    None => masks.push((material, bits)),
                }
            };
            if column.inside {
                fill(column.surface, column.surface_end, column.height);
                let mut end = column.height;
                for (n, layer) in self.layers.iter().enumerate() {
                    let last = n + 1 == self.layers.len();
                    let start = if last { i64::MIN / 2 } else { end.saturating_sub(layer.depth) };
                    fill(layer.material, start, end.min(column.surface_end));
                    end = start;
                }
                if let Some(water) = &self.water {
                    fill(water.material, column.height, water.level);
                }
            }
        }
        for (material, mask) in masks {
            target.chunk.apply(block, mask, self.mode, material);
        }
    }
}
