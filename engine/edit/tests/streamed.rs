//! Edits over tiles: voxel by voxel, cell by cell, and ray by ray through the buffer that a streamer fills meanwhile.

mod scenes;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use glam::IVec3;
use raxel_edit::{Base, Brush, Change, EditedSource, Edits, Operation};
use raxel_oracle::metrics::Errors;
use raxel_oracle::port::Tree64;
use raxel_oracle::sets::RayTargets;
use raxel_oracle::{Oracle, sets};
use raxel_stream::{PoolMemory, Publication, Reach, StreamOptions, Streamer, TileKey, View, union};
use raxel_world::{
    AIR, BLOCKS, Bounds, ChunkPos, ChunkSource, Content, DenseChunk, MAX_LEVEL, Material, MaterialIndex, Mode,
    StreamSettings, cell_edge,
};
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

impl ChunkSource for Ground {
    fn materials(&self) -> &[Material] {
        self.world.materials()
    }

    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        let key = TileKey { level, pos };
        if let Some(known) = self.tiles.lock().unwrap().get(&key) {
            return known.clone();
        }
        let mut content = ChunkSource::chunk(&self.world, level, pos);
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

/// Edits with their tiles.
struct Living {
    ground: Arc<Ground>,
    source: Arc<EditedSource>,
    edits: Edits,
}

impl Living {
    fn new() -> Self {
        let ground = Ground::new();
        let source = Arc::new(EditedSource::new(ground.clone(), scene().materials));
        Self { ground, source, edits: Edits::default() }
    }

    /// What a change has changed, once the tiles have it.
    fn took(&self, change: &Change) -> Vec<ChunkPos> {
        self.source.change(change);
        change.chunks.iter().map(|chunk| chunk.pos).collect()
    }

    fn apply(&mut self, operation: Operation) -> Vec<ChunkPos> {
        let change = self.edits.apply(&[operation], &scene(), self.source.unedited()).unwrap();
        self.took(&change)
    }

    fn undo(&mut self) -> Vec<ChunkPos> {
        let change = self.edits.undo(self.source.unedited());
        change.map_or(Vec::new(), |change| self.took(&change))
    }
}

/// The material that most of 64 cells have, of equally many the lowest; air if all are.
fn commonest(cells: impl Iterator<Item = MaterialIndex>) -> MaterialIndex {
    let mut counts = BTreeMap::new();
    cells.filter(|material| *material != AIR).for_each(|material| *counts.entry(material).or_insert(0) += 1);
    let most = counts.values().max().copied();
    counts.into_iter().find(|(_, count)| Some(*count) == most).map_or(AIR, |(material, _)| material)
}

/// A cell of a level in an edited chunk, from its voxels.
fn cell_of(edits: &Edits, base: &dyn Base, level: u32, cell: [i32; 3]) -> MaterialIndex {
    if level == 0 {
        let chunk = edits.chunk(ChunkPos::of_cell(IVec3::from_array(cell)), base);
        let [x, y, z] = cell.map(|c| (c & 63) as u32);
        return chunk.map_or(AIR, |chunk| chunk.voxel(x, y, z));
    }
    commonest((0..64).map(|i| {
        let inner = [i & 3, i >> 2 & 3, i >> 4];
        cell_of(edits, base, level - 1, std::array::from_fn(|axis| 4 * cell[axis] + inner[axis]))
    }))
}

#[test]
fn every_cell_is_that_of_the_edited_chunk_or_of_the_source() {
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
            let (found, below) = (ChunkSource::chunk(&*living.source, level, pos), living.ground.chunk(level, pos));
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
                let expected =
                    if own { cell_of(&living.edits, living.source.unedited(), level, cell) } else { at(&below) };
                assert_eq!(at(&found), expected, "level {level} cell {cell:?}");
                *(if own { &mut edited } else { &mut kept }) += 1;
            }
        }
    }
    assert!(edited > 10_000 && kept > 3000, "{edited} {kept}");
}

/// The buffer, on the host.
struct Words(Mutex<Vec<u32>>);

impl Words {
    fn frame(&self, publication: &Publication) -> Vec<u32> {
        let mut words = self.0.lock().unwrap().clone();
        words[..publication.words().len()].copy_from_slice(publication.words());
        words
    }
}

impl PoolMemory for Words {
    fn write(&self, at: u32, words: &[u32]) {
        self.0.lock().unwrap()[at as usize..][..words.len()].copy_from_slice(words);
    }
}

#[test]
fn every_publication_shows_the_edited_world_at_every_level() {
    const WORDS: u32 = 1 << 20;
    let mut living = Living::new();
    let settings = StreamSettings { near: 64, far: 256, ..StreamSettings::default() };
    let mut reach = Reach::of(&settings, [-64, 64]);
    let memory = Arc::new(Words(Mutex::new(vec![0xdead_beef; WORDS as usize])));
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
        let shown = union(&*living.source, &reach.tiles(camera));
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
    let adopted = EditedSource::new(living.ground.clone(), scene().materials);
    adopted.replace(&edits);
    let mut edited = 0;
    for pos in living.edits.positions() {
        for level in 0..=MAX_LEVEL {
            let tile = ChunkPos::new(pos.x >> (2 * level), pos.y >> (2 * level), pos.z >> (2 * level));
            let [found, expected] = [&adopted, &*living.source].map(|source| ChunkSource::chunk(source, level, tile));
            assert_eq!(found, expected, "level {level} {tile:?}");
            edited += usize::from(found != living.ground.chunk(level, tile));
        }
    }
    assert!(edited > 20, "{edited}");
    // Where a save has a material that the world does not, there is nothing, and no panic.
    let mut short = Edits::default();
    short.adopt(living.edits.positions().map(|pos| (pos, living.edits.packed(pos).unwrap())).collect::<Vec<_>>(), 1);
    adopted.replace(&short);
    assert!(living.edits.positions().all(|pos| ChunkSource::chunk(&adopted, 0, pos) == Content::Empty));
}

#[test]
fn questions_are_answered_by_the_newest_voxels() {
    let mut living = Living::new();
    let top = (0..64).rev().find(|y| living.ground.world.voxel(IVec3::new(10, *y, 10)) != AIR).unwrap();
    let ray = raxel_oracle::Ray { cell: [10, 300, 10], frac: [0.5; 3], dir: [0.0, -1.0, 0.0], t_max: f32::INFINITY };
    let voxel = |living: &Living| raxel_edit::query::cast(&*living.source, &ray, 1e4).unwrap().exact.voxel;
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
    let up = raxel_edit::query::collide(&*living.source, corners, [0, 30 * 256, 0]);
    assert_eq!((up.moved[1], up.stopped[1]), (9 * 256, true));
}
