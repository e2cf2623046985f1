//! Land: a height for every column from fractal noise, and materials by depth, height and slope.

use raxel_world::Bounds;
use raxel_world::MaterialIndex;
use raxel_world::Mode;
use raxel_world::block_index;

use crate::caves::{CaveChunk, Caves};
use crate::noise::{AT_ONCE, Noise, Sampler};
use crate::shape::Span3;
use crate::{Draft, LocalBox, local_part};

/// A material of the ground, from the surface down.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Palette index.
    pub material: MaterialIndex,
    /// Voxels that it is deep; down to the floor for the last one.
    pub depth: i64,
}

/// Another material in place of the uppermost layer. All given conditions must hold.
#[derive(Clone, Debug)]
pub struct Band {
    /// Palette index.
    pub material: MaterialIndex,
    /// Surface at this height or higher.
    pub above: Option<i64>,
    /// Surface lower than this.
    pub below: Option<i64>,
    /// At least this many voxels between this column and its highest or lowest neighbour.
    pub slope: Option<i64>,
    /// Voxels that it is deep.
    pub depth: i64,
}

/// Fills the space below a level that is not land.
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
    /// The source of the heights.
    pub noise: Noise,
    /// Valleys.
    pub river: Option<River>,
    /// The land has no voxel below this.
    pub floor: i64,
    /// Only this many voxels below the surface, and those that a neighbour's lower surface lays bare.
    pub shell: Option<i64>,
    /// At least one.
    pub layers: Vec<Layer>,
    /// The first that fits counts.
    pub bands: Vec<Band>,
    /// Lakes.
    pub water: Option<Water>,
    /// Hollows in the land, where a cell is one voxel.
    pub caves: Option<Caves>,
    /// Add, subtract or paint.
    pub mode: Mode,
    /// Voxels along a cell: 1, or 4, 16, 64 if the land is computed only in cells of that size.
    pub cell: i64,
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

/// The 64 × 64 columns of a column of tiles, in 4 × 4 blocks: block `tx + 16·tz`, then `x + 4·z` in it.
pub(crate) struct Surface(Vec<Column>);

/// Heights of the 66 × 66 columns of a column of tiles and around it, in voxels; x fastest. Those around are 0 if no reader needs them.
pub(crate) struct Heights {
    of: Box<[i64]>,
    /// Smallest and largest of the inner ones.
    pub(crate) range: [i64; 2],
}

/// Columns along an edge of [`Heights`].
const EDGE: usize = 66;

/// Bits of the lowest n voxels of the first column of a block.
const PREFIX: [u64; 5] = [0, 1, 0x1_0001, 0x1_0001_0001, 0x0001_0001_0001_0001];

/// Land made ready to be asked for heights.
pub(crate) struct Relief<'t> {
    terrain: &'t Terrain,
    noise: Sampler,
    river: Option<(&'t River, Sampler)>,
}

impl Relief<'_> {
    /// The first voxels above the land at some columns.
    #[expect(clippy::cast_possible_truncation, reason = "places in a tile are below 64, and casts of floats saturate")]
    fn heights(&self, columns: &[[i64; 2]; AT_ONCE]) -> [i64; AT_ONCE] {
        let terrain = self.terrain;
        let [x, z] = [0, 1].map(|axis| columns.map(|column| column[axis] as f64 + 0.5));
        let land = self.noise.at(&x, &z);
        let river = self.river.as_ref().map(|(river, noise)| (river, noise.at(&x, &z)));
        std::array::from_fn(|i| {
            let unit = f64::midpoint(land[i], 1.0);
            let raised = (1..terrain.exponent).fold(unit, |power, _| power * unit);
            let mut height = terrain.base + terrain.amplitude * raised;
            if let Some((river, noise)) = &river {
                // Near its zeros the noise grows by about two for each wave: distance is value over slope.
                let distance = noise[i].abs() / (2.0 * river.noise.frequency);
                let t = ((distance - river.width) / river.banks).clamp(0.0, 1.0);
                height = river.bed + (height - river.bed) * (t * t * (3.0 - 2.0 * t));
            }
            height.floor() as i64
        })
    }

    /// Works out the heights of numbered columns.
    fn each(&self, wanted: &[usize], column: impl Fn(usize) -> [i64; 2], mut to: impl FnMut(usize, i64)) {
        for group in wanted.chunks(AT_ONCE) {
            // The last column stands in for missing ones.
            let columns = std::array::from_fn(|i| column(group[i.min(group.len() - 1)]));
            group.iter().zip(self.heights(&columns)).for_each(|(i, height)| to(*i, height));
        }
    }

    /// The uppermost voxel at a column with its material, water included; `None` outside the area.
    pub(crate) fn top(&self, x: i64, z: i64) -> Option<(i64, MaterialIndex)> {
        let terrain = self.terrain;
        if !terrain.covers([x, z]) {
            return None;
        }
        let places = [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1), (0, 0), (0, 0), (0, 0)];
        let [here, west, east, north, south, ..] = self.heights(&places.map(|(dx, dz)| [x + dx, z + dz]));
        let around = if terrain.needs_neighbours() { [west, east, north, south] } else { [0; 4] };
        let column = terrain.column(here, around);
        match &terrain.water {
            Some(water) if water.level > column.height => Some((water.level - 1, water.material)),
            _ => (column.height > column.bottom).then_some((column.height - 1, column.surface)),
        }
    }
}

impl Terrain {
    /// A box around everything that it can touch, in cells.
    #[expect(clippy::cast_possible_truncation, reason = "casts of floats saturate")]
    pub fn bounds(&self) -> Bounds {
        let land = self.river.as_ref().map_or(self.base, |river| self.base.max(river.bed)) + self.amplitude;
        let top = (land.ceil() as i64).max(self.water.as_ref().map_or(i64::MIN, |water| water.level)).max(self.floor);
        let (min, max) = ([self.min[0], self.floor, self.min[1]], [self.max[0], top, self.max[1]]);
        Bounds { min: min.map(|c| c.div_euclid(self.cell)), max: max.map(|c| ceil_div(c, self.cell)) }
    }

    /// The same land in cells of 4^level voxels.
    pub(crate) fn at_level(&self, level: u32) -> Self {
        Self { cell: raxel_world::cell_edge(level), ..self.clone() }
    }

    /// Makes it ready to be asked for heights.
    pub(crate) fn relief(&self) -> Relief<'_> {
        let river = self.river.as_ref().map(|river| (river, river.noise.sampler_for(self.cell)));
        Relief { terrain: self, noise: self.noise.sampler_for(self.cell), river }
    }

    fn covers(&self, column: [i64; 2]) -> bool {
        (0..2).all(|i| (self.min[i]..self.max[i]).contains(&column[i]))
    }

    fn needs_neighbours(&self) -> bool {
        self.shell.is_some() || self.bands.iter().any(|band| band.slope.is_some())
    }

    /// Works out the columns of the chunks at (`chunk_x`, `chunk_z`), with their neighbours' heights.
    pub(crate) fn surface(&self, chunk_x: i32, chunk_z: i32) -> Surface {
        self.surface_of(&self.heights(chunk_x, chunk_z), chunk_x, chunk_z)
    }

    /// Works out the heights of the tiles at (`tile_x`, `tile_z`), in voxels. A cell is as high as its corners are on average.
    #[expect(clippy::cast_possible_wrap, reason = "places in a tile are below 64, and casts of floats saturate")]
    pub(crate) fn heights(&self, tile_x: i32, tile_z: i32) -> Heights {
        let relief = self.relief();
        let first = [tile_x, tile_z].map(|tile| i64::from(tile) * 64 - 1);
        let neighbours = self.needs_neighbours();
        let border = |x: usize, z: usize| x == 0 || z == 0 || x == EDGE - 1 || z == EDGE - 1;
        let column = |x: usize, z: usize| [(first[0] + x as i64) * self.cell, (first[1] + z as i64) * self.cell];
        let mut of = vec![0i64; EDGE * EDGE].into_boxed_slice();
        if self.cell == 1 {
            let wanted: Vec<usize> = (0..EDGE * EDGE).filter(|i| neighbours || !border(i % EDGE, i / EDGE)).collect();
            relief.each(&wanted, |i| column(i % EDGE, i / EDGE), |i, height| of[i] = height);
        } else {
            const CORNERS: usize = EDGE + 1;
            let all: Vec<usize> = (0..CORNERS * CORNERS).collect();
            let mut corners = vec![0i64; all.len()];
            relief.each(&all, |i| column(i % CORNERS, i / CORNERS), |i, height| corners[i] = height);
            for (i, height) in of.iter_mut().enumerate() {
                let corner = i / EDGE * CORNERS + i % EDGE;
                let four = [corner, corner + 1, corner + CORNERS, corner + CORNERS + 1];
                *height = (four.into_iter().map(|corner| corners[corner]).sum::<i64>() + 2).div_euclid(4);
            }
        }
        let inner = (0..EDGE * EDGE).filter(|i| !border(i % EDGE, i / EDGE)).map(|i| of[i]);
        let range = inner.fold([i64::MAX, i64::MIN], |[low, high], height| [low.min(height), high.max(height)]);
        Heights { of, range }
    }

    /// The columns of heights.
    #[expect(clippy::cast_possible_wrap, reason = "places in a tile are below 64, and casts of floats saturate")]
    pub(crate) fn surface_of(&self, heights: &Heights, tile_x: i32, tile_z: i32) -> Surface {
        let origin = [tile_x, tile_z].map(|tile| i64::from(tile) * 64);
        let columns = (0..4096).map(|i| {
            let (block, inside) = (i / 16, i % 16);
            let (x, z) = (block % 16 * 4 + inside % 4, block / 16 * 4 + inside / 4);
            let at = (z + 1) * EDGE + x + 1;
            let height = |at: usize| heights.of[at];
            let neighbours = [at - 1, at + 1, at - EDGE, at + EDGE].map(height);
            let middle = [origin[0] + x as i64, origin[1] + z as i64].map(|c| c * self.cell + self.cell / 2);
            if self.covers(middle) { self.column(height(at), neighbours) } else { Column::default() }
        });
        Surface(columns.collect())
    }

    fn column(&self, height: i64, neighbours: [i64; 4]) -> Column {
        let cell = self.cell;
        let height = height.max(self.floor);
        let lowest = neighbours.into_iter().fold(height, i64::min);
        let slope = neighbours.iter().map(|n| (n - height).abs() / cell).max().unwrap_or(0);
        let band = self.bands.iter().find(|band| {
            band.above.is_none_or(|above| height >= above)
                && band.below.is_none_or(|below| height < below)
                && band.slope.is_none_or(|least| slope >= least)
        });
        let (surface, depth) =
            band.map_or((self.layers[0].material, self.layers[0].depth), |band| (band.material, band.depth));
        // A shell of less than two cells would let rays slip in at the edges of a tile.
        let bottom = self.shell.map_or(self.floor, |shell| {
            let shell = if cell == 1 { shell } else { shell.max(2 * cell) };
            (height - shell).min(lowest).max(self.floor)
        });
        // A cell is solid if most of it is below the surface, which keeps its material, however thin it is. No column of land is without one.
        let bottom = bottom.div_euclid(cell);
        let least = if cell > 1 && height > self.floor { bottom + 1 } else { i64::MIN };
        let end = in_cells(height, cell).max(least);
        let depth = if cell == 1 { depth } else { in_cells(depth, cell).max(1) };
        if let Some(water) = self.water.as_ref().filter(|water| cell > 1 && water.level > height) {
            // Water is visible even where it does not reach the centre of a cell.
            let level = in_cells(water.level, cell).max(bottom + 1);
            return Column {
                inside: true,
                height: level,
                bottom,
                surface: water.material,
                surface_end: end.min(level - 1).max(bottom),
            };
        }
        Column { inside: true, height: end, bottom, surface, surface_end: end.saturating_sub(depth) }
    }

    /// The relation of a tile to the terrain, from the range of its heights alone. [`Span3::Both`] is always allowed; inside, all its cells are of
    /// the last layer's material.
    pub(crate) fn span(&self, tile_y: i32, heights: &Heights, inside_area: bool) -> Span3 {
        let low = i64::from(tile_y) * 64 * self.cell;
        let high = low + 64 * self.cell;
        let water = self.water.as_ref().map_or(i64::MIN, |water| water.level);
        let top = heights.range[1].max(self.floor).max(water);
        if high <= self.floor || low >= ceil_div(top, self.cell) * self.cell {
            return Span3::Outside;
        }
        let hollow = self.cell == 1
            && self.caves.as_ref().is_some_and(|caves| {
                let (from, to) = caves.heights();
                low < to && high > from
            });
        let above_last: i64 = self.layers[..self.layers.len() - 1].iter().map(|layer| layer.depth).sum();
        let deepest = self.bands.iter().map(|band| band.depth).fold(self.layers[0].depth.max(above_last), i64::max);
        let whole = heights.range[0].saturating_sub(deepest).saturating_sub(2 * self.cell);
        if inside_area && self.shell.is_none() && !hollow && low >= self.floor && high <= whole {
            return Span3::Inside;
        }
        Span3::Both
    }

    /// The material of everything deep below.
    pub(crate) fn deepest(&self) -> MaterialIndex {
        self.layers[self.layers.len() - 1].material
    }

    /// Whether every column of a tile is in its area.
    pub(crate) fn covers_tile(&self, tile_x: i32, tile_z: i32) -> bool {
        let edge = 64 * self.cell;
        (0..2).all(|i| {
            let low = i64::from([tile_x, tile_z][i]) * edge;
            self.min[i] <= low && low + edge <= self.max[i]
        })
    }

    #[expect(clippy::cast_possible_truncation, reason = "places in a tile are below 64, and casts of floats saturate")]
    pub(crate) fn apply(&self, draft: &mut Draft<'_>, surface: &Surface) {
        let Some(LocalBox { low, high }) = local_part(&self.bounds(), draft.pos) else { return };
        let origin = draft.pos.origin().to_array().map(i64::from);
        let origin_y = origin[1];
        let strata = Strata::of(self);
        let level = strata.water.map_or(i64::MIN, |(_, level)| level);
        // Where the last layer begins, below the surface.
        let above_last: i64 = strata.layers[..strata.layers.len() - 1].iter().map(|(_, depth)| depth).sum();
        let caves = self.caves.as_ref().filter(|caves| {
            let (from, to) = caves.heights();
            self.cell == 1 && origin_y < to && origin_y + 64 > from
        });
        let mut hollows = None;
        for tile in 0..256 {
            let columns = &surface.0[tile * 16..][..16];
            let (tx, tz) = (tile as u32 % 16, tile as u32 / 16);
            let top = columns.iter().map(|c| if c.inside { c.height.max(level) } else { i64::MIN }).max();
            let whole = |c: &Column| (c.bottom, c.surface_end.min(c.height.saturating_sub(above_last)));
            let solid_from = columns.iter().map(|c| whole(c).0).max().unwrap_or(i64::MAX);
            let solid_to = columns.iter().map(|c| whole(c).1).min().unwrap_or(i64::MIN);
            let ceilings = caves.map(|caves| Ceilings::of(caves, columns, level));
            for by in (low[1] >> 2)..=((high[1] - 1) >> 2) {
                let y = origin_y + i64::from(by) * 4;
                if top.is_none_or(|top| y >= top) {
                    break;
                }
                let hollow = caves.zip(ceilings.as_ref()).map_or(0, |(caves, ceilings)| match ceilings.below(y) {
                    0 => 0,
                    below => {
                        let samples: &mut CaveChunk<'_> = hollows.get_or_insert_with(|| caves.field().chunk(origin));
                        below & samples.mask([tx, by.cast_unsigned(), tz])
                    }
                });
                let block = block_index(tx, by.cast_unsigned(), tz);
                if y >= solid_from && y + 4 <= solid_to {
                    draft.chunk.apply(block, !hollow, self.mode, self.deepest());
                } else {
                    strata.apply_block(draft, block, y, columns, hollow);
                }
            }
        }
    }
}

/// The materials of the land, in cells.
struct Strata {
    /// From the surface down: material, depth.
    layers: Vec<(MaterialIndex, i64)>,
    /// Material, first height without it. Of cells of several voxels, it is the uppermost layer.
    water: Option<(MaterialIndex, i64)>,
    mode: Mode,
}

impl Strata {
    fn of(terrain: &Terrain) -> Self {
        let cell = terrain.cell;
        Self {
            layers: terrain.layers.iter().map(|layer| (layer.material, in_cells(layer.depth, cell))).collect(),
            water: terrain.water.as_ref().filter(|_| cell == 1).map(|water| (water.material, water.level)),
            mode: terrain.mode,
        }
    }

    #[expect(clippy::cast_sign_loss, reason = "the number is clamped to 0…4")]
    fn apply_block(&self, draft: &mut Draft<'_>, block: usize, y: i64, columns: &[Column], hollow: u64) {
        let mut masks: Vec<(MaterialIndex, u64)> = Vec::with_capacity(self.layers.len() + 2);
        for (i, column) in columns.iter().enumerate() {
            let mut fill = |material: MaterialIndex, from: i64, to: i64, not: u64| {
                let from = (from.max(column.bottom) - y).clamp(0, 4) as usize;
                let to = (to - y).clamp(0, 4) as usize;
                if from >= to {
                    return;
                }
                let bits = ((PREFIX[to] ^ PREFIX[from]) << i) & !not;
                match masks.iter_mut().find(|(m, _)| *m == material) {
                    Some((_, mask)) => *mask |= bits,
                    None => masks.push((material, bits)),
                }
            };
            if column.inside {
                fill(column.surface, column.surface_end, column.height, hollow);
                let mut end = column.height;
                for (n, (material, depth)) in self.layers.iter().enumerate() {
                    let last = n + 1 == self.layers.len();
                    let start = if last { i64::MIN / 2 } else { end.saturating_sub(*depth) };
                    fill(*material, start, end.min(column.surface_end), hollow);
                    end = start;
                }
                if let Some((material, level)) = self.water {
                    fill(material, column.height, level, 0);
                }
            }
        }
        for (material, mask) in masks {
            draft.chunk.apply(block, mask, self.mode, material);
        }
    }
}

/// For the 16 columns of a block, the first height that cannot be hollow, and the least and the largest of these.
struct Ceilings {
    of: [i64; 16],
    range: [i64; 2],
}

impl Ceilings {
    fn of(caves: &Caves, columns: &[Column], level: i64) -> Self {
        let of = std::array::from_fn(|i| caves.ceiling(columns[i].height, level));
        let range = of.iter().fold([i64::MAX, i64::MIN], |[low, high], c| [low.min(*c), high.max(*c)]);
        Self { of, range }
    }

    /// The voxels of a block at height `y` that have enough land above them.
    #[expect(clippy::cast_sign_loss, reason = "the number is clamped to 0…4")]
    fn below(&self, y: i64) -> u64 {
        match self.range {
            [_, high] if y >= high => 0,
            [low, _] if y + 4 <= low => u64::MAX,
            _ => (0..16).fold(0, |mask, i| mask | PREFIX[(self.of[i] - y).clamp(0, 4) as usize] << i),
        }
    }
}

impl Caves {
    /// The first height of a column that cannot be hollow, below land of that height and water up to `level`.
    pub(crate) fn ceiling(&self, height: i64, level: i64) -> i64 {
        // The shore counts as under water.
        let cover = if height < level + Self::UNDER_WATER { self.cover.max(Self::UNDER_WATER) } else { self.cover };
        height.saturating_sub(cover)
    }
}

fn ceil_div(value: i64, by: i64) -> i64 {
    -(-value).div_euclid(by)
}

/// A depth or a height in whole cells, to the nearest.
fn in_cells(depth: i64, cell: i64) -> i64 {
    (depth + cell / 2).div_euclid(cell)
}
