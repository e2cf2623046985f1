//! `op = "terrain"`.

use raxel_diagnostics::table::Table;
use raxel_diagnostics::{Diagnostic, codes};

use raxel_generate::{Band, Caves, Layer, Noise, River, Terrain, Water};
use raxel_world::Mode;

use super::extent;
use super::materials::Palette;
use super::operations::Seed;

/// Deepest layer, in voxels.
const DEPTH: i64 = 1 << 32;
/// As heights and amplitudes in the file.
const HEIGHTS: std::ops::RangeInclusive<f64> = extent::POSITIONS;

#[expect(clippy::cast_possible_truncation, reason = "heights are within ±2³¹")]
pub(super) fn read(
    table: &Table<'_, '_>,
    mode: Option<Mode>,
    palette: &Palette,
    seed: Seed,
    streamed: bool,
) -> Option<Terrain> {
    let area = extent::read_endless(table, streamed);
    let base = table.get("base").map_or(Some(0.0), |node| node.number(HEIGHTS));
    let amplitude = table.need("amplitude").and_then(|node| node.number(0.0..=*HEIGHTS.end()));
    let exponent = table.get("exponent").map_or(Some(1), |node| node.integer(1..=8));
    let seed = seed.read(table);
    let noise = seed.and_then(|seed| noise(table, seed, 5));
    let river = match table.get("river").map(|node| node.table()) {
        None => Some(None),
        Some(Some(river)) => seed.and_then(|seed| read_river(&river, seed)).map(Some),
        Some(None) => None,
    };
    let floor = table.get("floor").map(|node| node.integer(extent::CELLS));
    let shell = table.get("shell").map(|node| node.integer(1..=DEPTH));
    let layers = read_layers(table, palette);
    let first_depth = layers.as_ref().map_or(1, |layers| layers[0].depth);
    let bands = read_bands(table, palette, first_depth);
    let water = match table.get("water").map(|node| node.table()) {
        None => Some(None),
        Some(Some(water)) => {
            let material = water.need("material").and_then(|node| palette.find(&node));
            let level = water.need("level").and_then(|node| node.integer(extent::CELLS));
            water.finish();
            material.zip(level).map(|(material, level)| Some(Water { material, level }))
        }
        Some(None) => None,
    };
    let caves = match table.get("caves").map(|node| node.table()) {
        None => Some(None),
        Some(Some(caves)) => read_caves(&caves, seed).map(Some),
        Some(None) => None,
    };
    let (min, max) = area?;
    let (base, river) = (base?, river?);
    let lowest = river.as_ref().map_or(base, |river| base.min(river.bed));
    let terrain = Terrain {
        min,
        max,
        base,
        amplitude: amplitude?,
        exponent: exponent?,
        noise: noise?,
        floor: floor.unwrap_or(Some(lowest.floor() as i64 - 16))?,
        river,
        shell: match shell {
            Some(shell) => Some(shell?),
            None => None,
        },
        layers: layers?,
        bands: bands?,
        water: water?,
        caves: caves?,
        mode: mode?,
        cell: 1,
    };
    extent::inside_world(table, &terrain.bounds())?;
    near_enough(table, &terrain)?;
    Some(terrain)
}

/// `frequency`, `octaves`, `lacunarity`, `gain`, `ridges`.
fn noise(table: &Table<'_, '_>, seed: u64, octaves: u32) -> Option<Noise> {
    let frequency = table.get("frequency").map_or(Some(1.0 / 128.0), |node| node.number(1e-9..=1.0));
    let octaves = table.get("octaves").map_or(Some(octaves), |node| node.integer(1..=16));
    let lacunarity = table.get("lacunarity").map_or(Some(2.0), |node| node.number(1.0..=8.0));
    let gain = table.get("gain").map_or(Some(0.5), |node| node.number(0.0..=1.0));
    let ridges = table.get("ridges").map_or(Some(false), |node| node.boolean());
    Some(Noise {
        seed,
        frequency: frequency?,
        octaves: octaves?,
        lacunarity: lacunarity?,
        gain: gain?,
        ridges: ridges?,
    })
}

fn read_river(table: &Table<'_, '_>, seed: u64) -> Option<River> {
    let bed = table.need("bed").and_then(|node| node.number(HEIGHTS));
    let width = table.need("width").and_then(|node| node.number(0.0..=1e6));
    let banks = table.need("banks").and_then(|node| node.number(1.0..=1e6));
    let frequency = table.get("frequency").map_or(Some(1.0 / 512.0), |node| node.number(1e-9..=1.0));
    let octaves = table.get("octaves").map_or(Some(2), |node| node.integer(1..=16));
    let own = table.get("seed").map_or(Some(0), |node| node.integer(i64::MIN..=i64::MAX));
    table.finish();
    let noise = Noise {
        seed: raxel_world::random::mix(seed ^ raxel_world::random::mix(!own?.cast_unsigned())),
        frequency: frequency?,
        octaves: octaves?,
        lacunarity: 2.0,
        gain: 0.35,
        ridges: false,
    };
    Some(River { noise, bed: bed?, width: width?, banks: banks? })
}

fn read_caves(table: &Table<'_, '_>, seed: Option<u64>) -> Option<Caves> {
    let width = table.need("width").and_then(|node| node.number(0.0..=1.0));
    let frequency = table.get("frequency").map_or(Some(1.0 / 64.0), |node| node.number(1e-9..=0.25));
    let octaves = table.get("octaves").map_or(Some(1), |node| node.integer(1..=8));
    let cover = table.get("cover").map_or(Some(0), |node| node.integer(0..=DEPTH));
    let height = |key: &str| match table.get(key) {
        Some(node) => node.integer(extent::CELLS).map(Some),
        None => Some(None),
    };
    let (above, below) = (height("above"), height("below"));
    let own = table.get("seed").map_or(Some(0), |node| node.integer(i64::MIN..=i64::MAX));
    table.finish();
    let (octaves, frequency, own, seed) = (octaves?, frequency?, own?.cast_unsigned(), seed?);
    let noise = |n: u64| Noise {
        seed: raxel_world::random::mix(seed ^ raxel_world::random::mix(own.wrapping_mul(2).wrapping_add(n) ^ 0xcafe)),
        frequency,
        octaves,
        lacunarity: 2.0,
        gain: 0.5,
        ridges: false,
    };
    let noises = [noise(0), noise(1)];
    Some(Caves { noises, width: width?, cover: cover?, above: above?, below: below? })
}

fn read_layers(table: &Table<'_, '_>, palette: &Palette) -> Option<Vec<Layer>> {
    let node = table.need("layers")?;
    let tables = node.array()?;
    if tables.is_empty() {
        return node.bad_value(format!("`{}` needs at least one layer", node.name));
    }
    let layers: Vec<_> = (tables.iter().enumerate())
        .map(|(n, node)| {
            let layer = node.table()?;
            let material = layer.need("material").and_then(|node| palette.find(&node));
            // The last layer goes all the way down, unless it is also the first and bands need to know its depth.
            let depth = match layer.get("depth") {
                Some(node) => node.integer(1..=DEPTH),
                None if n + 1 == tables.len() => Some(DEPTH),
                None => layer.need("depth").and(None),
            };
            layer.finish();
            Some(Layer { material: material?, depth: depth? })
        })
        .collect();
    layers.into_iter().collect()
}

fn read_bands(table: &Table<'_, '_>, palette: &Palette, depth: i64) -> Option<Vec<Band>> {
    let Some(node) = table.get("bands") else { return Some(Vec::new()) };
    let bands: Vec<_> = (node.array()?.iter())
        .map(|node| {
            let band = node.table()?;
            let material = band.need("material").and_then(|node| palette.find(&node));
            let height = |key: &str| match band.get(key) {
                Some(node) => node.integer(extent::CELLS).map(Some),
                None => Some(None),
            };
            let (above, below) = (height("above"), height("below"));
            let slope = match band.get("slope") {
                Some(node) => node.integer(1..=DEPTH).map(Some),
                None => Some(None),
            };
            let depth = band.get("depth").map_or(Some(depth), |node| node.integer(1..=DEPTH));
            band.finish();
            if (above, below, slope) == (Some(None), Some(None), Some(None)) {
                node.report(codes::files::MISSING_KEY, format!("`{}` holds everywhere", node.name), "");
            }
            Some(Band { material: material?, above: above?, below: below?, slope: slope?, depth: depth? })
        })
        .collect();
    bands.into_iter().collect()
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
