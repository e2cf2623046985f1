//! Edits over tiles: voxel by voxel, cell by cell, and ray by ray through the buffer that a streamer fills meanwhile.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod scenes;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use glam::IVec3;
use raxel_edit::{Base, Brush, Change, EditedChunks, Edits, Operation, Scene};
use raxel_oracle::metrics::Errors;
use raxel_oracle::port::Tree64;
use raxel_oracle::sets::RayTargets;
use raxel_oracle::{Oracle, sets};
use raxel_stream::{StreamOptions, Streamer, StreamingRange, TileKey, View};
use raxel_testing::{Words, union};
use raxel_world::{
    AIR, BLOCKS, Bounds, ChunkPos, ChunkProvider, Content, DenseChunk, MAX_LEVEL, Material, MaterialIndex, Mode,
    Unavailable, cell_edge,
};
use raxel_worldfile::StreamSettings;
use scenes::{Random, scene, world};

const PATIENCE: Duration = Duration::from_secs(120);

/// The rough ground, as a source whose coarse tiles are its own affair: all of one material.
struct Ground {
    world: raxel_world::World,
    tiles: Mutex<BTreeMap<TileKey, Content>>,
}

impl Ground {
    fn new() -> Arc<Self> {
        Arc::new(Self { world: world(), tiles: Mutex::default() })
    }
}

impl Ground {
    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        let key = TileKey { level, pos };
        if let Some(known) = self.tiles.lock().unwrap().get(&key) {
            return known.clone();
        }
        let mut content = self.world.tile(level, pos);
        if level > 0 {
            let mut cells = DenseChunk::default();
            content.unpack(&mut cells);
            (0..BLOCKS).for_each(|block| cells.apply(block, u64::MAX, Mode::Paint, 5));
            content = Content::pack(&cells);
        }
        self.tiles.lock().unwrap().insert(key, content.clone());
        content
    }
}

impl ChunkProvider for Ground {
    fn materials(&self) -> &[Material] {
        self.world.materials()
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.chunk(level, pos))
    }
}

/// Edits with their tiles.
struct Living {
    ground: Arc<Ground>,
    source: Arc<EditedChunks>,
    edits: Edits,
}

impl Living {
    fn new() -> Self {
        let ground = Ground::new();
        let source = Arc::new(EditedChunks::new(ground.clone(), scene().materials));
        Self { ground, source, edits: Edits::default() }
    }

    /// The chunks that a change has changed, once the tiles have it.
    fn took(&self, change: &Change) -> Vec<ChunkPos> {
        self.source.change(change);
        change.chunks.iter().map(|chunk| chunk.pos).collect()
    }

    fn apply(&mut self, operation: Operation) -> Vec<ChunkPos> {
        let change = self.edits.apply(&[operation], &scene(), self.source.unedited()).unwrap();
        self.took(&change)
    }

    fn undo(&mut self) -> Vec<ChunkPos> {
        let change = self.edits.undo(self.source.unedited()).unwrap();
        change.map_or(Vec::new(), |change| self.took(&change))
    }
}

/// A cell of a level above 0 in an edited chunk, from its voxels, the source's voxels there, and the source's cell.
fn cell_of(edits: &Edits, base: &dyn Base, level: u32, cell: [i32; 3], below: MaterialIndex) -> MaterialIndex {
    let edge = cell_edge(level) as i32;
    let first = cell.map(|c| c * edge);
    let pos = ChunkPos::of_cell(IVec3::from_array(first));
    let [old, new] = [base.try_chunk(pos), edits.chunk(pos, base)].map(Result::unwrap);
    let (mut was, mut is, mut changed) = (0, 0, false);
    let mut written: BTreeMap<MaterialIndex, i32> = BTreeMap::new();
    for n in 0..edge.pow(3) {
        let [x, y, z] = std::array::from_fn(|i| ((first[i] + n / edge.pow(i as u32) % edge) & 63) as u32);
        let [old, new] = [&old, &new].map(|chunk| chunk.as_ref().map_or(AIR, |chunk| chunk.voxel(x, y, z)));
        was += i32::from(old != AIR);
        is += i32::from(new != AIR);
        changed |= old != new;
        if new != AIR && new != old {
            *written.entry(new).or_insert(0) += 1;
        }
    }
    let (wall, half) = (edge * edge, edge.pow(3) / 2);
    let solid = match below {
        _ if !changed => return below,
        AIR => is - was >= wall / 2 && (is >= half || is - was >= wall),
        _ => is > 0 && (is >= half || was - is <= wall / 2),
    };
    let most = written.values().max().copied();
    let commonest = written.iter().find(|(_, count)| Some(**count) == most).map(|(material, _)| *material);
    match below {
        _ if !solid => AIR,
        AIR => commonest.expect("something has come"),
        below if 2 * written.values().sum::<i32>() >= wall => commonest.unwrap_or(below),
        below => below,
    }
}

#[test]
fn every_cell_is_that_of_the_source_until_enough_of_it_is_edited() {
    let mut living = Living::new();
    let mut random = Random(5);
    for _ in 0..60 {
        living.apply(random.operation());
    }
    living.undo();
    let (mut edited, mut kept) = (0, 0);
    for level in 0..=MAX_LEVEL {
        let tiles: BTreeSet<ChunkPos> = (living.edits.positions())
            .map(|pos| ChunkPos::new(pos.x >> (2 * level), pos.y >> (2 * level), pos.z >> (2 * level)))
            .collect();
        for pos in tiles {
            let (found, below) =
                (ChunkProvider::try_chunk(&*living.source, level, pos).unwrap(), living.ground.chunk(level, pos));
            let [found, below] = [found, below].map(|content| content.to_chunk());
            let origin = pos.origin().to_array();
            // All of a few cells: walking through all voxels of each would take minutes.
            for n in 0..3000 {
                let local = [random.next(64) as u32, random.next(64) as u32, random.next(64) as u32];
                let cell: [i32; 3] = std::array::from_fn(|i| origin[i] + local[i] as i32);
                let edge = cell_edge(level) as i32;
                let chunk = ChunkPos::of_cell(IVec3::from_array(cell.map(|c| c * edge)));
                let at = |chunk: &Option<Arc<raxel_world::Chunk>>| {
                    chunk.as_ref().map_or(AIR, |chunk| chunk.voxel(local[0], local[1], local[2]))
                };
                let own = living.edits.packed(chunk).is_some();
                if own && level > 1 && n % 8 != 0 {
                    continue;
                }
                let expected = match (own, level) {
                    (false, _) => at(&below),
                    (true, 0) => {
                        let edited = living.edits.chunk(chunk, living.source.unedited()).unwrap();
                        edited.map_or(AIR, |chunk| chunk.voxel(local[0], local[1], local[2]))
                    }
                    (true, _) => cell_of(&living.edits, living.source.unedited(), level, cell, at(&below)),
                };
                assert_eq!(at(&found), expected, "level {level} cell {cell:?}");
                *(if own { &mut edited } else { &mut kept }) += 1;
            }
        }
    }
    assert!(edited > 10_000 && kept > 3000, "{edited} {kept}");
}

/// The shipped endless land, with its edits.
fn frontier() -> (Arc<dyn ChunkProvider>, Arc<EditedChunks>, Scene) {
    let root = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let files = raxel_diagnostics::DiskFiles::new(root).unwrap();
    let loaded = raxel_worldfile::load("worlds/frontier.toml", &files, &mut raxel_diagnostics::SourceMap::default());
    let land = loaded.unwrap_or_else(|found| panic!("{found:?}")).0.stream.expect("it is streamed").generator;
    let scene = Scene::new(land.materials(), &[]);
    (land.clone(), Arc::new(EditedChunks::new(land, scene.materials.clone())), scene)
}

/// The differing cells of a tile in two sources, with both contents.
fn differences(sources: [&dyn ChunkProvider; 2], level: u32, pos: ChunkPos) -> Vec<([u32; 3], [MaterialIndex; 2])> {
    let [a, b] = sources.map(|source| {
        let mut cells = DenseChunk::default();
        source.try_chunk(level, pos).unwrap().unpack(&mut cells);
        cells
    });
    let of = |cells: &DenseChunk, block: usize, bit: usize| {
        if cells.masks()[block] >> bit & 1 == 1 { cells.block(block)[bit] } else { AIR }
    };
    let cells = (0..BLOCKS).flat_map(|block| (0..64).map(move |bit| (block, bit)));
    let cells = cells.map(|(block, bit)| (block, bit, [of(&a, block, bit), of(&b, block, bit)]));
    cells
        .filter(|(.., found)| found[0] != found[1])
        .map(|(block, bit, found)| {
            let (cell, inner) = (raxel_world::block_cell(block), raxel_world::child_cell(bit as u32));
            (std::array::from_fn(|i| 4 * cell[i] + inner[i]), found)
        })
        .collect()
}

/// The uppermost voxel of a column of the land.
fn top(land: &dyn ChunkProvider, x: i32, z: i32) -> i32 {
    let of_chunk = |y: i32| {
        let pos = ChunkPos::of_cell(IVec3::new(x, 64 * y, z));
        let chunk = land.try_chunk(0, pos).unwrap().to_chunk()?;
        let local = (0..64).rev().find(|local| chunk.voxel((x & 63) as u32, *local, (z & 63) as u32) != AIR)?;
        Some(64 * y + local as i32)
    };
    (-1..8).rev().find_map(of_chunk).expect("there is land")
}

/// Setting and removing single voxels of a hill changes no cell of it from afar.
#[test]
fn single_voxels_are_not_seen_from_afar() {
    let (land, source, scene) = frontier();
    let mut random = Random(3);
    for n in 0..60 {
        let mut edits = Edits::default();
        let [x, z] = [0; 2].map(|_| random.next(200) as i32 - 100);
        let y = top(&*land, x, z);
        // Every other one digs, the others build.
        let cell = [x, y + n % 2, z];
        let operation = Operation::set(cell, if n % 2 == 0 { AIR } else { 5 });
        let change = edits.apply(&[operation], &scene, source.unedited()).unwrap();
        assert_eq!(change.chunks.len(), 1);
        source.change(&change);
        for level in 1..=MAX_LEVEL {
            let pos = TileKey::of_cell(level, IVec3::from_array(cell)).pos;
            let found = differences([&*land, &*source], level, pos);
            assert!(found.is_empty(), "level {level} {cell:?}: {found:?}");
        }
        source.replace(&Edits::default());
    }
}

/// A tower, a wall one voxel thick, a crater and a painted field are seen at the levels that they are large enough for.
#[test]
fn what_is_as_thick_as_a_wall_is_seen_from_afar() {
    const BRICK: MaterialIndex = 5;
    let (land, source, scene) = frontier();
    let (x, z) = (24, 24);
    let ground = (i64::from(top(&*land, x as i32, z as i32)) + 15) & !15;
    let solid = |level: u32, bounds: &Bounds| {
        let edge = cell_edge(level);
        // The cells that lie in it for a half at least, along every axis.
        let ranges: [std::ops::Range<i64>; 3] = std::array::from_fn(|i| {
            (bounds.min[i] + edge / 2).div_euclid(edge)..(bounds.max[i] - 1 - edge / 2).div_euclid(edge) + 1
        });
        let [xs, ys, zs] = ranges;
        let cells = ys.flat_map(|y| {
            zs.clone().flat_map({
                let xs = xs.clone();
                move |z| xs.clone().map(move |x| [x, y, z])
            })
        });
        let at = |cell: [i64; 3]| {
            let pos = ChunkPos::of_cell(IVec3::from_array(cell.map(|c| c as i32)));
            let local = cell.map(|c| (c & 63) as u32);
            ChunkProvider::try_chunk(&*source, level, pos)
                .unwrap()
                .to_chunk()
                .map_or(AIR, |chunk| chunk.voxel(local[0], local[1], local[2]))
        };
        cells.map(at).collect::<Vec<_>>()
    };
    let mut edits = Edits::default();
    let tower = Bounds { min: [x - 6, ground + 16, z - 6], max: [x + 6, ground + 144, z + 6] };
    let wall = Bounds { min: [x + 40, ground + 16, z], max: [x + 41, ground + 48, z + 64] };
    for bounds in [tower, wall] {
        let change = edits.apply(&[Operation::Box { bounds, brush: Brush::Add(BRICK) }], &scene, source.unedited());
        source.change(&change.unwrap());
    }
    for level in 1..3 {
        let edge = cell_edge(level);
        let cells = solid(level, &tower);
        assert!(!cells.is_empty() && cells.iter().all(|cell| *cell == BRICK), "level {level}: {cells:?}");
        // A thin wall lies in one layer of cells.
        let x = wall.min[0].div_euclid(edge) * edge;
        let cells =
            solid(level, &Bounds { min: [x, wall.min[1], wall.min[2]], max: [x + edge, wall.max[1], wall.max[2]] });
        assert!(cells.len() >= 4 && cells.iter().all(|cell| *cell == BRICK), "level {level}: {cells:?}");
    }
    // A crater: cells without a remaining voxel are gone from afar, with the caves below that coarse land lacks.
    let hole = Bounds { min: [x - 64, ground - 32, z - 64], max: [x - 32, ground + 64, z - 32] };
    let dug = edits.apply(&[Operation::Box { bounds: hole, brush: Brush::Subtract }], &scene, source.unedited());
    source.change(&dug.unwrap());
    for level in 1..3 {
        let cells = solid(level, &hole);
        let left = cells.iter().filter(|cell| **cell != AIR).count();
        assert!(!cells.is_empty() && left == 0, "level {level}: {left} of {}", cells.len());
    }
}

#[test]
fn every_publication_shows_the_edited_world_at_every_level() {
    const WORDS: u32 = 1 << 20;
    let mut living = Living::new();
    let settings = StreamSettings { near: 64, far: 256, ..StreamSettings::default() };
    let mut reach = StreamingRange::of(&settings, [-64, 64]);
    let memory = Words::new(WORDS);
    let options = StreamOptions { workers: 2, complete: true, upload: None, poison: true };
    let mut camera = IVec3::new(20, 30, 20);
    let streamer =
        Streamer::new(living.source.clone(), memory.clone(), WORDS, reach.clone(), View::at(camera), options);
    streamer.wait(PATIENCE).unwrap();
    let mut random = Random(11);
    let (mut hits, mut published) = (0, 0);
    for step in 0..60 {
        let mut chunks = Vec::new();
        for _ in 0..=random.next(4) {
            chunks.extend(match random.next(6) {
                0 => living.undo(),
                // High above everything that the source builds, and far from the camera: only edits are there.
                1 => {
                    let min = [random.next(300) as i64, 64 + random.next(200) as i64, random.next(300) as i64];
                    let bounds = Bounds { min, max: min.map(|c| c + 9) };
                    living.apply(Operation::Box { bounds, brush: Brush::Add(2) })
                }
                _ => living.apply(random.operation()),
            });
        }
        streamer.changed(&chunks);
        if step % 3 == 0 {
            camera += IVec3::from_array([0; 3].map(|_| random.next(90) as i32 - 45));
            streamer.follow(View::at(camera));
        }
        streamer.wait(PATIENCE).unwrap();
        let Some(taken) = streamer.take() else { continue };
        streamer.released(taken.version);
        published += 1;
        living.source.edited_heights().into_iter().for_each(|heights| reach.include(heights));
        let shown = union(&*living.source, &reach.tiles(camera)).unwrap();
        let words = memory.frame(&taken);
        let (tree, oracle, targets) = (Tree64::new(&words), Oracle::new(&shown), RayTargets::of(&shown));
        let mut errors = Errors::default();
        for set in sets::ALL {
            for ray in set.block(&targets, step, 0, 24) {
                errors.add(&ray, &oracle.first_hit(&ray), tree.trace(&ray).as_ref());
            }
        }
        assert_eq!(errors.wrong(), 0, "step {step}: {errors:?}");
        hits += errors.hits;
    }
    assert!(published > 50 && hits > 3000, "{published} publications, {hits} hits");
}

/// The chunks of a save stay packed until a tile is asked for, and show the same then.
#[test]
fn adopted_chunks_are_tiles_like_any_other() {
    let mut living = Living::new();
    let mut random = Random(23);
    (0..40).for_each(|_| drop(living.apply(random.operation())));
    let mut edits = Edits::default();
    let packed = living.edits.positions().map(|pos| (pos, living.edits.packed(pos).unwrap()));
    edits.adopt(packed.collect::<Vec<_>>(), living.source.materials().len());
    let adopted = EditedChunks::new(living.ground.clone(), scene().materials);
    adopted.replace(&edits);
    let mut edited = 0;
    for pos in living.edits.positions() {
        for level in 0..=MAX_LEVEL {
            let tile = ChunkPos::new(pos.x >> (2 * level), pos.y >> (2 * level), pos.z >> (2 * level));
            let [found, expected] =
                [&adopted, &*living.source].map(|source| ChunkProvider::try_chunk(source, level, tile).unwrap());
            assert_eq!(found, expected, "level {level} {tile:?}");
            edited += usize::from(found != living.ground.chunk(level, tile));
        }
    }
    assert!(edited > 20, "{edited}");
    // If a save has a material that the world lacks, voxels are unavailable: they do not become air.
    let mut short = Edits::default();
    short.adopt(living.edits.positions().map(|pos| (pos, living.edits.packed(pos).unwrap())).collect::<Vec<_>>(), 1);
    adopted.replace(&short);
    for pos in living.edits.positions() {
        let found = ChunkProvider::try_chunk(&adopted, 0, pos);
        assert!(found.as_ref().is_err_and(|unavailable| unavailable.pos == pos), "{pos:?}: {found:?}");
    }
}

#[test]
fn questions_are_answered_by_the_newest_voxels() {
    let mut living = Living::new();
    let top = (0..64).rev().find(|y| living.ground.world.voxel(IVec3::new(10, *y, 10)) != AIR).unwrap();
    let ray = raxel_oracle::Ray { cell: [10, 300, 10], frac: [0.5; 3], dir: [0.0, -1.0, 0.0], t_max: f32::INFINITY };
    let voxel = |living: &Living| raxel_edit::query::cast(&*living.source, &ray, 1e4).unwrap().unwrap().exact.voxel;
    assert_eq!(voxel(&living), [10, top, 10]);
    living.apply(Operation::set([10, 200, 10], 3));
    assert_eq!(voxel(&living), [10, 200, 10]);
    living.undo();
    assert_eq!(voxel(&living), [10, top, 10]);
    let bounds = Bounds { min: [0, 100, 0], max: [8, 108, 8] };
    let count = |living: &Living| raxel_edit::query::histogram(&*living.source, &bounds).unwrap();
    assert_eq!(count(&living), [(AIR, 512)].into());
    living.apply(Operation::Box { bounds, brush: Brush::Add(4) });
    assert_eq!(count(&living), [(4, 512)].into());
    let corners = [[256, 90 * 256, 256], [512, 91 * 256, 512]];
    let up = raxel_edit::query::collide(&*living.source, corners, [0, 30 * 256, 0]).unwrap();
    assert_eq!((up.moved[1], up.stopped[1]), (9 * 256, true));
}
