//! Measures along rays how far land in cells of several voxels lies from the same land in single voxels.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::collections::HashMap;

use glam::{DVec3, IVec3};
use raxel_diagnostics::{FileError, Files, SourceMap};
use raxel_stream::{StreamingRange, TileKey};
use raxel_world::{BLOCKS, ChunkPos, ChunkProvider, Content, cell_edge, voxel_index};
use raxel_worldfile::StreamSettings;

/// Added to where a ray leaves a box, so that it is in the next one.
const STEP: f64 = 1e-7;

/// The masks of a tile without a solid cell.
static NOTHING: [u64; BLOCKS] = [0; BLOCKS];

/// The part of a tile that stops rays.
enum Solid {
    None,
    All,
    Some(Box<[u64; BLOCKS]>),
}

/// A world around a camera, whose tiles are made when a ray comes to them: no layout, no pool.
struct Seen<'s> {
    source: &'s dyn ChunkProvider,
    reach: StreamingRange,
    camera: DVec3,
    heights: [f64; 2],
    tiles: HashMap<TileKey, Solid>,
}

impl<'s> Seen<'s> {
    fn new(source: &'s dyn ChunkProvider, near: u32, far: u32, camera: DVec3) -> Self {
        let heights = source.height_range().expect("land has heights");
        let reach = StreamingRange::of(&StreamSettings { near, far, ..StreamSettings::default() }, heights);
        Self { source, reach, camera, heights: heights.map(|height| height as f64), tiles: HashMap::new() }
    }

    /// The finest tile that is shown where a voxel is.
    fn tile_at(&self, place: DVec3) -> Option<TileKey> {
        let (cell, camera) = (place.floor().as_ivec3(), self.camera.floor().as_ivec3());
        let levels = 0..=self.reach.top();
        levels.map(|level| TileKey::of_cell(level, cell)).find(|key| self.reach.wants(camera, *key, 0))
    }

    /// The length of a ray, and the edge of the cell that it hits.
    fn hit(&mut self, direction: DVec3) -> Option<(f64, f64)> {
        let [low, high] = self.heights;
        let mut t = if self.camera.y > high { (high - self.camera.y) / direction.y + STEP } else { 0.0 };
        if t < 0.0 {
            return None;
        }
        loop {
            let place = self.camera + direction * t;
            if place.y < low || (place.y > high && direction.y > 0.0) {
                return None;
            }
            let key = self.tile_at(place)?;
            let edge = cell_edge(key.level) as f64;
            let origin = DVec3::from_array(key.origin().map(|c| c as f64));
            // A part of a coarse tile may be shown as finer tiles.
            let chunk_end = self.leaves((place / 64.0).floor() * 64.0, 64.0, direction);
            let source = self.source;
            let solid = self.tiles.entry(key).or_insert_with(|| match source.try_chunk(key.level, key.pos).unwrap() {
                Content::Empty => Solid::None,
                Content::Full(_) => Solid::All,
                Content::Chunk(chunk) => Solid::Some(Box::new(*chunk.masks())),
            });
            let masks = match solid {
                Solid::All => return Some((t, edge)),
                Solid::None => &NOTHING,
                Solid::Some(masks) => &**masks,
            };
            let cell = ((place - origin) / edge).floor().clamp(DVec3::ZERO, DVec3::splat(63.0));
            let [x, y, z] = cell.to_array().map(|c| c as u32);
            let (block, bit) = voxel_index(x, y, z);
            if masks[block] >> bit & 1 == 1 {
                return Some((t, edge));
            }
            let (corner, cells) = match solid {
                Solid::None => (DVec3::ZERO, 64.0),
                Solid::Some(masks) if masks[block] == 0 => ((cell / 4.0).floor() * 4.0, 4.0),
                _ => (cell, 1.0),
            };
            t = self.leaves(origin + corner * edge, cells * edge, direction).min(chunk_end).max(t) + STEP;
        }
    }

    /// Where a ray leaves a cube that it is in.
    fn leaves(&self, low: DVec3, edge: f64, direction: DVec3) -> f64 {
        let planes = low + DVec3::select(direction.cmpgt(DVec3::ZERO), DVec3::splat(edge), DVec3::ZERO);
        let at = (planes - self.camera) / direction;
        DVec3::select(direction.cmpeq(DVec3::ZERO), DVec3::INFINITY, at).min_element()
    }
}

/// A camera: where it is, and degrees to the right of −Z and upwards.
struct Camera(&'static str, [f64; 3], f64, f64);

/// Rays of a picture, 16 to 9 and 60 degrees high.
fn rays(Camera(_, _, yaw, pitch): &Camera, [width, height]: [usize; 2]) -> Vec<DVec3> {
    let (yaw, pitch) = (yaw.to_radians(), pitch.to_radians());
    let forward = DVec3::new(yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos());
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let half = 30f64.to_radians().tan();
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let along = |at: usize, size: usize| (2 * at + 1) as f64 / size as f64 - 1.0;
    let ray = |[x, y]: [usize; 2]| forward + half * (right * along(x, width) * 16.0 / 9.0 - up * along(y, height));
    pixels.map(|pixel| ray(pixel).normalize()).collect()
}

/// Pixels of a picture, by what coarser land makes of them.
#[derive(Debug, Default)]
struct Counts {
    pixels: u32,
    /// In the sky, and there in both.
    sky: u32,
    /// Within a cell of where single voxels are.
    close: u32,
    /// Of them, those that lie in cells of several voxels.
    close_cells: u32,
    /// All that do.
    cells: u32,
    /// Sky where single voxels are, at a silhouette and elsewhere.
    gone: [u32; 2],
}

impl Counts {
    fn percent(&self) -> f64 {
        100.0 * f64::from(self.sky + self.close) / f64::from(self.pixels)
    }
}

fn compare(source: &dyn ChunkProvider, camera: &Camera, [near, far]: [u32; 2], size: [usize; 2]) -> Counts {
    let at = DVec3::from_array(camera.1);
    let [mut fine, mut coarse] = [far, near].map(|near| Seen::new(source, near, far, at));
    let rays = rays(camera, size);
    let exact: Vec<Option<f64>> = rays.iter().map(|ray| fine.hit(*ray).map(|(depth, _)| depth)).collect();
    let mut counts = Counts { pixels: rays.len() as u32, ..Counts::default() };
    for (at, (ray, exact_depth)) in rays.iter().zip(&exact).enumerate() {
        let found = coarse.hit(*ray);
        let Some(exact_depth) = exact_depth else {
            counts.sky += u32::from(found.is_none());
            continue;
        };
        let there = coarse.tile_at(coarse.camera + *ray * (exact_depth + 1e-3));
        let level = there.map_or(0, |key| key.level);
        counts.cells += u32::from(level > 0);
        let Some((depth, edge)) = found else {
            let (x, y) = ((at % size[0]).cast_signed(), (at / size[0]).cast_signed());
            let is_sky = |x: isize, y: isize| {
                let inside = (0..size[0].cast_signed()).contains(&x) && (0..size[1].cast_signed()).contains(&y);
                inside && exact[y.cast_unsigned() * size[0] + x.cast_unsigned()].is_none()
            };
            let silhouette = (-1..=1).any(|dy| (-1..=1).any(|dx| is_sky(x + dx, y + dy)));
            counts.gone[usize::from(!silhouette)] += 1;
            continue;
        };
        let cell = edge.max(cell_edge(level) as f64);
        // Single voxels are the same ones in both.
        let close = (depth - exact_depth).abs() <= if cell > 1.0 { cell } else { 1e-3 };
        counts.close += u32::from(close);
        counts.close_cells += u32::from(close && level > 0);
    }
    counts
}

struct Root;

impl Files for Root {
    fn read(&self, path: &str) -> Result<std::sync::Arc<[u8]>, FileError> {
        let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path);
        std::fs::read(path).map(Into::into).map_err(|error| FileError::Io(error.to_string()))
    }
}

fn frontier() -> std::sync::Arc<dyn ChunkProvider> {
    let loaded = raxel_worldfile::load("worlds/frontier.toml", &Root, &mut SourceMap::default());
    loaded.unwrap_or_else(|found| panic!("{found:?}")).0.stream.expect("it is streamed").generator
}

/// The uppermost voxel of a column.
fn top(source: &dyn ChunkProvider, [x, z]: [i32; 2]) -> f64 {
    let of_chunk = |y: i32| {
        let key = TileKey::of_cell(0, IVec3::new(x, 64 * y, z));
        let chunk = source.try_chunk(0, ChunkPos::new(key.pos.x, y, key.pos.z)).unwrap().to_chunk()?;
        let solid = |local: &u32| chunk.voxel((x & 63) as u32, *local, (z & 63) as u32) != 0;
        (0..64).rev().find(solid).map(|local| 64 * y + local as i32)
    };
    f64::from((-2..8).rev().find_map(of_chunk).expect("there is land"))
}

fn cameras(source: &dyn ChunkProvider) -> [Camera; 8] {
    let above = |at: [i32; 2], height: f64| [f64::from(at[0]), top(source, at) + height, f64::from(at[1])];
    [
        Camera("the file's", [40.0, 170.0, 60.0], 35.0, -14.0),
        Camera("far away", [1e6, 260.0, -7e5], 0.0, -10.0),
        Camera("from a mountain", above([-793, 603], 20.0), 250.0, -12.0),
        Camera("over water", [7.0, 40.0, 3.0], 80.0, -4.0),
        Camera("low", above([340, 360], 12.0), 200.0, -2.0),
        Camera("along a valley", [7.0, 70.0, 3.0], 300.0, -8.0),
        Camera("down a slope", above([-900, 700], 60.0), 120.0, -20.0),
        Camera("high", [40.0, 700.0, 60.0], 35.0, -25.0),
    ]
}

/// Everything is near and small here, so cells cover a larger part of the picture than in a window.
#[test]
fn land_in_cells_lies_where_the_land_is() {
    let source = frontier();
    let mut sum = Counts::default();
    for camera in &cameras(&*source)[..4] {
        let counts = compare(&*source, camera, [128, 512], [48, 27]);
        println!("{}: {:.1} %, {counts:?}", camera.0, counts.percent());
        assert_eq!(counts.gone[1], 0, "{}: sky where land is", camera.0);
        sum.close_cells += counts.close_cells;
        sum.cells += counts.cells;
    }
    assert!(sum.cells > 500 && 100 * sum.close_cells >= 70 * sum.cells, "{} of {}", sum.close_cells, sum.cells);
}

/// Takes about three minutes.
#[test]
#[ignore = "long: run it by name"]
fn pictures_of_a_large_window_have_the_depths_of_single_voxels() {
    let source = frontier();
    for camera in &cameras(&*source) {
        let counts = compare(&*source, camera, [1024, 4096], [160, 90]);
        let cells = 100.0 * f64::from(counts.close_cells) / f64::from(counts.cells.max(1));
        println!("{}: {:.1} %, of those in cells {cells:.0} %, {counts:?}", camera.0, counts.percent());
        assert_eq!(counts.gone[1], 0, "{}: sky where land is", camera.0);
        // From high above, most of the picture lies in cells.
        assert!(counts.percent() >= if camera.0 == "high" { 85.0 } else { 95.0 }, "{}", camera.0);
    }
}
