//! How fast worlds are built, on one thread: `cargo bench -p raxel-worldfile`.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a bench")]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::IVec3;
use raxel_diagnostics::SourceMap;
use raxel_generate::{Box3, Layer, Menger, Noise, Operation, Shape, Solid, Terrain, build};
use raxel_world::{Bounds, ChunkPos, Content, DenseChunk, Material, Mode, World, vox};

fn materials() -> Vec<Material> {
    vec![Material::air(), Material::matt("a", [0.5; 3]), Material::matt("b", [0.2; 3])]
}

fn terrain(shell: Option<i64>) -> Operation {
    let noise = Noise { seed: 1, frequency: 0.005, octaves: 5, lacunarity: 2.0, gain: 0.5, ridges: false };
    let layer = |material, depth| Layer { material, depth };
    Operation::Terrain(Terrain {
        min: [-256; 2],
        max: [256; 2],
        base: 0.0,
        amplitude: 100.0,
        exponent: 1,
        noise,
        river: None,
        floor: -20,
        shell,
        layers: vec![layer(1, 4), layer(2, 1 << 20)],
        bands: Vec::new(),
        water: None,
        caves: None,
        mode: Mode::Add,
        cell: 1,
    })
}

fn solid(shape: impl Shape + 'static) -> Operation {
    Operation::Solid(Solid { shape: Box::new(shape), mode: Mode::Add, materials: vec![1] })
}

fn bench(c: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let block = Box3 { bounds: Bounds { min: [-100; 3], max: [156; 3] }, shell: None };
    let cases = [
        ("terrain whole 512x512", terrain(None)),
        ("terrain shell 512x512", terrain(Some(16))),
        ("box 256", solid(block)),
        ("menger 5", solid(Menger::new([0; 3], 5))),
    ];
    let mut group = c.benchmark_group("build");
    group.sample_size(10);
    for (name, operation) in cases {
        let operations = [operation];
        let run = || pool.install(|| build(materials(), black_box(&operations)).expect("it fits").0);
        group.throughput(Throughput::Elements(run().solids()));
        group.bench_function(name, |b| b.iter(run));
    }
    let root = project_root();
    group.bench_function("worlds/valley.toml", |b| {
        b.iter(|| {
            pool.install(|| {
                raxel_worldfile::load("worlds/valley.toml", &root, &mut SourceMap::default()).expect("shipped")
            })
        });
    });
    group.finish();
}

/// Single tiles of the endless world that is shipped: above the land, deep below it, at its surface with and without its heights at hand.
fn tiles(c: &mut Criterion) {
    let loaded =
        raxel_worldfile::load("worlds/frontier.toml", &project_root(), &mut SourceMap::default()).expect("shipped").0;
    let generator = loaded.stream.expect("it is streamed").generator;
    let mut group = c.benchmark_group("tile");
    let [_, top] = generator.height_range().expect("land");
    group.bench_function("empty", |b| {
        b.iter(|| generator.try_chunk(0, black_box(ChunkPos::new(3, (top >> 6) as i32 + 1, 3))));
    });
    let surface = |x: i32, level: u32| {
        let tile = |y: i32| generator.try_chunk(level, ChunkPos::new(x, y, 5));
        (0..6).rev().find(|y| matches!(tile(*y), Ok(Content::Chunk(_)))).expect("land")
    };
    group.bench_function("surface and caves", |b| {
        let y = surface(3, 0);
        b.iter(|| generator.try_chunk(0, black_box(ChunkPos::new(3, y, 5))));
    });
    // From the deepest chunk to the first above the land, as a camera that jumps wants them.
    let mut x = 100_000;
    group.bench_function("a column of chunks", |b| {
        b.iter(|| {
            x += 1;
            let tile = |y: &i32| generator.try_chunk(0, black_box(ChunkPos::new(x, *y, 5)));
            (-1..=top.div_euclid(64) as i32).filter(|y| matches!(tile(y), Ok(Content::Chunk(_)))).count()
        });
    });
    for level in 0..=3 {
        let mut x = 100;
        group.bench_function(format!("a fresh column, level {level}"), |b| {
            b.iter(|| {
                x += 1;
                generator.try_chunk(level, black_box(ChunkPos::new(x, 0, 5)))
            });
        });
    }
    group.finish();
}

fn scenes(c: &mut Criterion) {
    let noise = |c: IVec3| ((c.x * 73) ^ (c.y * 151) ^ (c.z * 283)).rem_euclid(7);
    let cells = (0..128i32.pow(3)).map(|i| IVec3::new(i % 128, i / 128 % 128, i / 128 / 128));
    let world =
        World::from_voxels(materials(), cells.filter(|c| noise(*c) < 3).map(|c| (c, (1 + noise(c) % 2) as u16)));
    let bytes = vox::export(&world).expect("it is small");
    let mut group = c.benchmark_group("vox");
    group.sample_size(10).throughput(Throughput::Elements(world.solids()));
    group.bench_function("import", |b| b.iter(|| vox::import(black_box(&bytes)).expect("ours")));
    group.bench_function("export", |b| b.iter(|| vox::export(black_box(&world)).expect("it is small")));
    let chunk = world.chunks().next().expect("it has chunks").1.clone();
    let mut dense = DenseChunk::default();
    group.throughput(Throughput::Elements(u64::from(chunk.solids())));
    group.bench_function("unpack and pack a chunk", |b| {
        b.iter(|| {
            dense.clear();
            dense.unpack(black_box(&chunk));
            raxel_world::Chunk::pack(&dense)
        });
    });
    group.finish();
}

/// The folder of the workspace.
fn project_root() -> impl raxel_diagnostics::Files {
    struct Root;
    impl raxel_diagnostics::Files for Root {
        fn read(&self, path: &str) -> Result<std::sync::Arc<[u8]>, raxel_diagnostics::FileError> {
            let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path);
            std::fs::read(path).map(Into::into).map_err(|e| raxel_diagnostics::FileError::Io(e.to_string()))
        }
    }
    Root
}

criterion_group!(benches, bench, tiles, scenes);
criterion_main!(benches);
