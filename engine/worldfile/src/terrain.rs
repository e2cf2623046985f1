//! `op = "terrain"`.

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_generate::{Band, Caves, Layer, Noise, Operation, River, Terrain, Water};
use raxel_language::{Keys, ReadKeys, Shape, Value, describe};
use raxel_world::random::mix;

use super::extent::{CELLS, Corners, Extent, POSITIONS};
use super::materials::Named;
use super::operations::Site;
use super::reading::Reading;

/// Deepest layer, in voxels.
const DEPTH: i64 = 1 << 32;

/// `op = "terrain"`.
#[derive(Keys)]
#[keys(context = Reading<'_>, check = bounded(extent))]
pub(super) struct TerrainKeys {
    #[keys(flatten)]
    extent: Extent<2>,
    /// Height of the lowest land, in voxels.
    #[keys(range = POSITIONS, default = 0.0)]
    base: f64,
    /// Height from the lowest land to the highest, in voxels.
    #[keys(range = 0.0..=*POSITIONS.end())]
    amplitude: f64,
    /// Power of the heights, which are from 0 to 1. Above 1, low land becomes wider, and high land steeper.
    #[keys(range = 1..=8, default = 1)]
    exponent: u32,
    /// Hills for each voxel of distance.
    #[keys(range = 1e-9..=1.0, default = 1.0 / 128.0)]
    frequency: f64,
    /// Number of octaves: how often finer detail is added.
    #[keys(range = 1..=16, default = 5)]
    octaves: u32,
    /// How many times finer each octave is.
    #[keys(range = 1.0..=8.0, default = 2.0)]
    lacunarity: f64,
    /// Strength of each octave, as a multiple of the octave before.
    #[keys(range = 0.0..=1.0, default = 0.5)]
    gain: f64,
    /// Sharp crests instead of round hills.
    #[keys(default = false)]
    ridges: bool,
    /// Any number: another one makes another land. The place of the operation in the file when left out.
    seed: Option<i64>,
    /// A valley that meanders through the land.
    river: Option<RiverKeys>,
    /// The lowest voxel; 16 below the lowest land when left out.
    #[keys(range = CELLS)]
    floor: Option<i64>,
    /// Builds only this many voxels below the surface, and those that lie bare. All when left out.
    #[keys(range = 1..=DEPTH)]
    shell: Option<i64>,
    /// Layers from the surface down.
    layers: Layers,
    /// Other uppermost layers by height and slope. The first that fits wins.
    bands: Vec<BandKeys>,
    /// Lakes.
    water: Option<WaterKeys>,
    /// Tunnels through the land.
    caves: Option<CaveKeys>,
}

/// `river`.
#[derive(Keys)]
struct RiverKeys {
    /// Height of the river bed, in voxels.
    #[keys(range = POSITIONS)]
    bed: f64,
    /// About half the width of the river bed, in voxels.
    #[keys(range = 0.0..=1e6)]
    width: f64,
    /// Distance over which the land rises from the bed to its own height, in voxels.
    #[keys(range = 1.0..=1e6)]
    banks: f64,
    /// Bends for each voxel of distance.
    #[keys(range = 1e-9..=1.0, default = 1.0 / 512.0)]
    frequency: f64,
    /// Number of octaves: how often finer bends are added.
    #[keys(range = 1..=16, default = 2)]
    octaves: u32,
    /// Any number: another one makes another course.
    #[keys(default = 0)]
    seed: i64,
}

/// Layers from the surface down, at least one.
struct Layers(Vec<Layer>);

/// One of `layers`.
#[derive(Keys)]
#[keys(context = Reading<'_>)]
struct LayerKeys {
    /// Material of the layer.
    material: Named,
    /// Depth of the layer, in voxels. The last layer goes down to the floor when left out.
    #[keys(range = 1..=DEPTH)]
    depth: Option<i64>,
}

/// One of `bands`.
#[derive(Keys)]
#[keys(context = Reading<'_>, check = somewhere(above, below, slope))]
struct BandKeys {
    /// Material of the uppermost layer here.
    material: Named,
    /// Only where the surface is at this height or higher, in voxels. At any height when left out.
    #[keys(range = CELLS)]
    above: Option<i64>,
    /// Only where the surface is lower than this height, in voxels. At any height when left out.
    #[keys(range = CELLS)]
    below: Option<i64>,
    /// Only where a neighbouring column is at least this many voxels higher or lower. Anywhere when left out.
    #[keys(range = 1..=DEPTH)]
    slope: Option<i64>,
    /// Depth of the layer, in voxels. That of the first layer when left out.
    #[keys(range = 1..=DEPTH)]
    depth: Option<i64>,
}

/// `water`.
#[derive(Keys)]
#[keys(context = Reading<'_>)]
struct WaterKeys {
    /// Material that fills everything below the level that is not land.
    material: Named,
    /// The first height without water, in voxels.
    #[keys(range = CELLS)]
    level: i64,
}

/// `caves`.
#[derive(Keys)]
struct CaveKeys {
    /// How far both noises may be from 0. A larger number makes wider tunnels.
    #[keys(range = 0.0..=1.0)]
    width: f64,
    /// Bends for each voxel of distance.
    #[keys(range = 1e-9..=0.25, default = 1.0 / 64.0)]
    frequency: f64,
    /// Number of octaves: how often finer bends are added.
    #[keys(range = 1..=8, default = 1)]
    octaves: u32,
    /// Voxels of land that stay above caves; under water always at least 4.
    #[keys(range = 0..=DEPTH, default = 0)]
    cover: i64,
    /// Only at this height or higher, in voxels. At any height when left out.
    #[keys(range = CELLS)]
    above: Option<i64>,
    /// Only lower than this height, in voxels. At any height when left out.
    #[keys(range = CELLS)]
    below: Option<i64>,
    /// Any number: another one makes other caves.
    #[keys(default = 0)]
    seed: i64,
}

impl TerrainKeys {
    #[expect(clippy::cast_possible_truncation, reason = "heights are within ±2³¹")]
    pub(super) fn operation(self, site: &Site<'_>) -> Option<Operation> {
        let Corners { min, max } = self.extent.corners(site.table, site.reading.streamed)?;
        let seed = site.seed(self.seed);
        let Self { base, amplitude, exponent, frequency, octaves, lacunarity, gain, ridges, .. } = self;
        let river = self.river.map(|river| river.river(seed));
        let lowest = river.as_ref().map_or(base, |river| base.min(river.bed));
        let (depth, layers) = (self.layers.0[0].depth, self.layers.0);
        let terrain = Terrain {
            min,
            max,
            base,
            amplitude,
            exponent,
            noise: Noise { seed, frequency, octaves, lacunarity, gain, ridges },
            floor: self.floor.unwrap_or(lowest.floor() as i64 - 16),
            river,
            shell: self.shell,
            layers,
            bands: self.bands.into_iter().map(|band| band.band(depth)).collect(),
            water: self.water.map(|WaterKeys { material, level }| Water { material: material.0, level }),
            caves: self.caves.map(|caves| caves.caves(seed)),
            mode: site.mode,
            cell: 1,
        };
        site.inside_world(&terrain.bounds())?;
        near_enough(site.table, &terrain)?;
        Some(Operation::Terrain(terrain))
    }
}

/// Land in a streamed world has no end.
fn bounded(table: &Table<'_, '_>, reading: &Reading<'_>, extent: &Extent<2>) -> bool {
    extent.corners(table, reading.streamed).is_some()
}

impl RiverKeys {
    fn river(self, seed: u64) -> River {
        let Self { bed, width, banks, frequency, octaves, seed: own } = self;
        let seed = mix(seed ^ mix(!own.cast_unsigned()));
        River {
            noise: Noise { seed, frequency, octaves, lacunarity: 2.0, gain: 0.35, ridges: false },
            bed,
            width,
            banks,
        }
    }
}

impl CaveKeys {
    fn caves(self, seed: u64) -> Caves {
        let Self { width, frequency, octaves, cover, above, below, seed: own } = self;
        let noise = |n: u64| Noise {
            seed: mix(seed ^ mix(own.cast_unsigned().wrapping_mul(2).wrapping_add(n) ^ 0xcafe)),
            frequency,
            octaves,
            lacunarity: 2.0,
            gain: 0.5,
            ridges: false,
        };
        Caves { noises: [noise(0), noise(1)], width, cover, above, below }
    }
}

describe! {
    Layers => Shape::array(Shape::Table(LayerKeys::form()), 1..);
}

impl Value<Reading<'_>> for Layers {
    fn read(node: &Node<'_, '_>, (): &(), reading: &Reading<'_>) -> Option<Self> {
        let tables = node.array()?;
        let Some(last) = tables.len().checked_sub(1) else {
            return node.bad_value(format!("`{}` needs at least one layer", node.name));
        };
        let layer = |(n, node): (usize, &Node<'_, '_>)| {
            let table = node.table()?;
            let keys = LayerKeys::read_keys(&table, reading);
            // The last layer goes all the way down, unless it is also the first and bands need to know its depth.
            let needed = n < last && table.get("depth").is_none() && table.need("depth").is_none();
            table.finish();
            keys.filter(|_| !needed)
                .map(|LayerKeys { material, depth }| Layer { material: material.0, depth: depth.unwrap_or(DEPTH) })
        };
        let layers: Vec<_> = tables.iter().enumerate().map(layer).collect();
        layers.into_iter().collect::<Option<_>>().map(Self)
    }
}

impl BandKeys {
    fn band(self, first: i64) -> Band {
        let Self { material, above, below, slope, depth } = self;
        Band { material: material.0, above, below, slope, depth: depth.unwrap_or(first) }
    }
}

fn somewhere(
    table: &Table<'_, '_>,
    _: &Reading<'_>,
    above: Option<&i64>,
    below: Option<&i64>,
    slope: Option<&i64>,
) -> bool {
    let right = above.is_some() || below.is_some() || slope.is_some();
    if !right {
        let message = format!("`{}` holds everywhere", table.name());
        table.reporter().report(Diagnostic::error(codes::files::MISSING_KEY, message).label(table.span().clone(), ""));
    }
    right
}

/// Reports noise too fine for its distance from the origin.
fn near_enough(table: &Table<'_, '_>, terrain: &Terrain) -> Option<()> {
    let ends = terrain.min.iter().chain(&terrain.max);
    let reach = ends.map(|end| end.unsigned_abs()).max().unwrap_or(0) as f64;
    let of_caves = terrain.caves.as_ref().map(|caves| &caves.noises[0]);
    let noises = [Some(&terrain.noise), terrain.river.as_ref().map(|river| &river.noise), of_caves];
    let waves = noises.into_iter().flatten().map(|noise| noise.waves(reach)).fold(0.0, f64::max);
    if waves <= Noise::MAX_WAVES {
        return Some(());
    }
    table.reporter().report(
        Diagnostic::error(
            codes::world::NOISE_TOO_FINE,
            format!(
                "`{}` has noise too fine for its distance from the origin: {waves:.1e} waves, at most {:.0e}",
                table.name(),
                Noise::MAX_WAVES
            ),
        )
        .label(table.span().clone(), "")
        .help("lower `frequency`, `octaves` or `lacunarity`"),
    );
    None
}
