//! The cost of a step of 1,000 single voxels in 200 chunks of the shipped land, from the operations to the words that a frame reads.
//! `cargo bench -p raxel-edit --bench many`; with `RAYON_NUM_THREADS=1`, on one core.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a bench")]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use raxel_diagnostics::{DiskFiles, SourceMap};
use raxel_edit::{ChunkCache, EditedChunks, Edits, Operation, Scene};
use raxel_layouts::TileBlock;
use raxel_layouts::lights::{LightPowers, TileLights};
use raxel_world::{ChunkPos, ChunkProvider, Side};

/// Chunks along x and z, and voxels that are set in each.
const CHUNKS: [i32; 2] = [20, 10];
const VOXELS: i32 = 5;

/// A step of the flight's edits, with other voxels and another material in each frame.
fn sets(frame: i32) -> Vec<Operation> {
    let voxel = |n: i32| {
        let (chunk, voxel) = (n / VOXELS, n % VOXELS);
        let at = [64 * (chunk % CHUNKS[0]), 0, 64 * (chunk / CHUNKS[0])];
        let inside = [11 * voxel + 3, frame & 63, 7 * voxel + 20];
        let cell = [0, 1, 2].map(|i| at[i] + inside[i]);
        Operation::Set { cell, material: 1 + ((frame ^ frame >> 6) & 1) as u16 }
    };
    (0..CHUNKS[0] * CHUNKS[1] * VOXELS).map(voxel).collect()
}

fn many(c: &mut Criterion) {
    let files = DiskFiles::new(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))).expect("the repository");
    let loaded = raxel_worldfile::load("worlds/frontier.toml", &files, &mut SourceMap::default());
    let streamed = loaded.unwrap_or_else(|errors| panic!("{errors:?}")).0.stream.expect("it is streamed");
    let kept = Arc::new(ChunkCache::new(streamed.generator.clone(), 1 << 30));
    let materials = kept.materials().to_vec();
    let source = EditedChunks::new(kept, materials.clone());
    let (scene, mut edits) = (Scene::new(&materials, &[]), Edits::default());
    let powers = LightPowers::of(&materials).expect("crystals shine");
    let mut frame = 0;
    let mut step = || {
        let change = edits.apply(&sets(frame), &scene, source.unedited()).expect("they are small");
        source.change(&change);
        frame += 1;
        change.chunks.into_iter().map(|chunk| chunk.pos).collect::<Vec<ChunkPos>>()
    };
    let chunks = step();
    assert_eq!(chunks.len(), 200);
    let mut group = c.benchmark_group("many");
    group.sample_size(20);
    group.bench_function("apply", |b| b.iter(&mut step));
    group.bench_function("encode chunks", |b| {
        b.iter(|| {
            for pos in &chunks {
                let content = source.try_chunk(0, *pos).unwrap();
                if let Ok(block) = TileBlock::of(&content, 0) {
                    black_box(block.encode(0, 0));
                }
            }
        });
    });
    group.bench_function("lamps of chunks", |b| {
        b.iter(|| {
            for pos in &chunks {
                let beside = |face| Arc::new(Side::of(&source.try_chunk(0, pos.beside(face)).unwrap(), face ^ 1));
                black_box(TileLights::of(&source.try_chunk(0, *pos).unwrap(), (0, *pos), &powers, beside));
            }
        });
    });
    for level in 1..=3 {
        let mut tiles: Vec<ChunkPos> = chunks
            .iter()
            .map(|pos| ChunkPos::new(pos.x >> (2 * level), pos.y >> (2 * level), pos.z >> (2 * level)))
            .collect();
        tiles.sort_unstable();
        tiles.dedup();
        group.bench_function(format!("{} tiles of level {level}", tiles.len()), |b| {
            b.iter(|| {
                // A chunk that was edited again is reduced again.
                step();
                for pos in &tiles {
                    let content = source.try_chunk(level as u32, *pos).unwrap();
                    if let Ok(block) = TileBlock::of(&content, level as u32) {
                        black_box(block.encode(0, 0));
                    }
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, many);
criterion_main!(benches);
