//! The cost of an edit and a movement: buffers that follow edits against encoding the world again, and trees of boxes over instances.
//! `cargo bench -p raxel-worldfile --bench edit`.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::IVec3;
use raxel_diagnostics::SourceMap;
use raxel_layouts::LiveLayout;
use raxel_layouts::instances::{Instance, InstanceModel, Instances, Pose};
use raxel_world::random::SplitMix64;
use raxel_world::{Chunk, DenseChunk, Material, Mode, World};

/// One voxel of a shipped world, set and taken away again.
fn edits(c: &mut Criterion) {
    let world = raxel_worldfile::load("worlds/valley.toml", &project_root(), &mut SourceMap::default())
        .expect("shipped")
        .0
        .world;
    let (pos, chunk) = world.chunks().nth(world.chunks().len() / 2).expect("it has chunks");
    let mut dense = DenseChunk::default();
    dense.unpack(chunk);
    let partly = |block: &usize| chunk.mask(*block) != 0 && chunk.mask(*block) != u64::MAX;
    let block = (0..4096).find(partly).expect("it has a surface");
    dense.apply(block, 1 << chunk.mask(block).trailing_ones(), Mode::Add, 1);
    let other = Arc::new(Chunk::pack(&dense).expect("it has a voxel"));
    let changed = [other, chunk.clone()].map(|chunk| {
        let change = vec![(pos, Some(chunk))];
        (world.with_chunks(&[], change.clone()), change)
    });
    let mut group = c.benchmark_group("edit");
    group.sample_size(10);
    for layout in raxel_rivals::LAYOUTS.iter().copied().filter(|layout| !layout.has_image()) {
        let Ok(encoded) = layout.encode(&world, u64::MAX) else { continue };
        println!("{}: {} bytes", layout.name(), 4 * encoded.words.len());
        group.bench_function(format!("{} again as a whole", layout.name()), |b| {
            b.iter(|| layout.encode(black_box(&world), u64::MAX));
        });
        if !layout.follows_edits() {
            continue;
        }
        let (mut live, words) = LiveLayout::new(layout, &world, u64::MAX).expect("it fits");
        println!("{} with room: {} bytes", layout.name(), 4 * words.len());
        let mut turn = 0;
        group.bench_function(format!("{} in place, one voxel", layout.name()), |b| {
            b.iter(|| {
                let (world, change) = &changed[turn % 2];
                turn += 1;
                live.update(black_box(world), change.iter().cloned()).expect("it fits")
            });
        });
    }
    group.finish();
}

/// Where thousands of instances stand, from their poses to the words of the buffer.
fn instances(c: &mut Criterion) {
    let materials = vec![Material::air(), Material::matt("a", [0.5; 3])];
    let voxels = (0..6 * 4 * 9).map(|i| (IVec3::new(i % 6, i / 6 % 4, i / 24), 1));
    let model = InstanceModel {
        voxels: Arc::new(World::from_voxels(materials, voxels)),
        materials: Arc::from([0, 1].as_slice()),
    };
    let mut random = SplitMix64::new(1);
    let mut at = || (random.bits() % 1000) as f64 + 0.25;
    let mut group = c.benchmark_group("instances");
    for count in [512, 4096, 16_384] {
        let one = |pose| Instance { name: None, model: 0, anchor: [0; 3], pose, motions: Vec::new() };
        let list = (0..count).map(|_| one(Pose::new([at(), at(), at()], [at(), at(), at()]))).collect();
        let instances = Instances { models: vec![model.clone()], list };
        let buffer = instances.encode(&[], u64::MAX).expect("it fits");
        println!("{count}: {} bytes that move", 4 * buffer.moving(&instances.frames(|_| None)).len());
        group.bench_function(format!("{count} moved"), |b| {
            b.iter(|| buffer.moving(&black_box(&instances).frames(|_| None)));
        });
    }
    group.finish();
}

/// The folder of the workspace.
fn project_root() -> impl raxel_diagnostics::Files {
    struct Root;
    impl raxel_diagnostics::Files for Root {
        fn read(&self, path: &str) -> Result<Arc<[u8]>, raxel_diagnostics::FileError> {
            let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path);
            std::fs::read(path).map(Into::into).map_err(|e| raxel_diagnostics::FileError::Io(e.to_string()))
        }
    }
    Root
}

criterion_group!(benches, edits, instances);
criterion_main!(benches);
