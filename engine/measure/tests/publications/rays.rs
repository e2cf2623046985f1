//! Rays through publications, against the exact tracer.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use glam::IVec3;
use raxel_diagnostics::MemoryFiles;
use raxel_edit::{Brush, EditedChunks, Edits, Operation, Scene};
use raxel_layouts::Layout;
use raxel_measure::rays::{DeviceWorld, Method, Stream, Tracer};
use raxel_oracle::metrics::Errors;
use raxel_oracle::sets::{RaySet, RayTargets};
use raxel_oracle::{Oracle, Ray, sets};
use raxel_stream::{Publication, TileKey, View};
use raxel_testing::{ReachableSet, union};
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, World};
use rayon::prelude::*;

use crate::{
    HEADER, IN_FLIGHT, Memory, PATIENCE, WORDS, device, endless, fly_on, materials, number, reach, run, silent,
    streamer,
};

/// Traces rays of every set, about this many together, and counts wrong hits.
fn judge(
    stream: &mut Stream,
    tracer: &mut Tracer,
    on_device: &DeviceWorld,
    shown: &World,
    rays: u64,
    seed: u64,
) -> Errors {
    let (oracle, targets) = (Oracle::new(shown), RayTargets::of(shown));
    let each = rays.div_ceil(sets::ALL.len() as u64);
    let block = |set: &'static RaySet, number: u64| {
        let count = (each - number * RaySet::BLOCK as u64).min(RaySet::BLOCK as u64);
        set.block(&targets, seed, number, count as usize)
    };
    let blocks: Vec<(&'static RaySet, u64)> =
        sets::ALL.iter().flat_map(|set| (0..each.div_ceil(RaySet::BLOCK as u64)).map(move |n| (set, n))).collect();
    let rays: Vec<Ray> = blocks.into_par_iter().flat_map_iter(|(set, number)| block(set, number)).collect();
    let hits = stream.trace_all(tracer, on_device, &rays).unwrap();
    let judged = rays.par_iter().zip(&hits).with_min_len(64).fold(Errors::default, |mut errors, (ray, words)| {
        let (answer, hit) = (oracle.first_hit(ray), words.hit());
        let before = errors.wrong();
        errors.add(ray, &answer, words.outcome(hit.as_ref()));
        assert_eq!(errors.wrong(), before, "{ray:?}\nexact {answer:?}\nfound {words:?}");
        errors
    });
    judged.reduce(Errors::default, Errors::and)
}

/// Rays through this many publications: of a flight in which tiles come and go while rays are traced, and of complete worlds in which edits,
/// other levels and places far away take turns.
fn trace(publications: u64, rays: u64) {
    let device = device();
    let mut tracer = Tracer::new(&device, Arc::new(MemoryFiles::default()), &Method::of(Layout::TREE64)).unwrap();
    let mut stream = Stream::new(&device).unwrap();
    let mut random = SplitMix64::new(number("RAXEL_SEED", 5));
    let (mut errors, mut judged, mut dropped) = (Errors::default(), 0, 0);
    for (staged, levels) in [(false, false), (true, false), (false, true), (true, true)] {
        let memory = Memory::new(&device, WORDS, staged);
        let on_device = DeviceWorld::of_buffer(&memory.buffer);
        let source = Arc::new(EditedChunks::new(endless(), materials()));
        let mut shape = if levels { reach(64, 256) } else { reach(192, 192) };
        let streamer = streamer(source.clone(), &memory, shape.clone(), levels);
        let (scene, mut edits) = (Scene::new(&materials(), &[]), Edits::default());
        let (mut camera, mut in_flight) = (IVec3::ZERO, VecDeque::new());
        let until = Instant::now() + PATIENCE * 5;
        let mut of_this = 0;
        while of_this < publications.div_ceil(4) {
            assert!(Instant::now() < until, "{of_this} publications: {:?}", streamer.stats());
            if levels && random.below(2) == 0 {
                let at = [0; 3].map(|_| random.below(200) as i32 - 100);
                let at = (camera + IVec3::from_array(at)).as_dvec3().to_array();
                let brush = if random.below(2) == 0 { Brush::Subtract } else { Brush::Add(1 + random.below(5) as u16) };
                let operation = Operation::sphere(at, 1.0 + random.below(30) as f64, brush);
                let change = match random.below(4) {
                    0 => edits.undo(source.unedited()).unwrap(),
                    _ => edits.apply(&[operation], &scene, source.unedited()).ok(),
                };
                if let Some(change) = change {
                    source.change(&change);
                    let changed: Vec<ChunkPos> = change.chunks.iter().map(|chunk| chunk.pos).collect();
                    streamer.changed(&changed);
                }
            } else if levels || streamer.is_settled() || random.below(4) == 0 {
                camera = fly_on(camera, &mut random);
                streamer.follow(View::at(camera));
            }
            if levels {
                streamer.wait(PATIENCE).unwrap();
            }
            let Some(taken) = streamer.take() else {
                std::thread::yield_now();
                continue;
            };
            in_flight.push_back(taken);
            while in_flight.len() > if levels { 1 } else { IN_FLIGHT } {
                in_flight.pop_front();
                streamer.released(in_flight[0].version);
            }
            // The oldest is the one that would be overwritten first.
            let publication: &Arc<Publication> = &in_flight[0];
            run(&device, |recording| {
                recording.update_buffer(&memory.buffer, 0, bytemuck::cast_slice(publication.words()));
            });
            let tiles = if levels {
                source.edited_heights().into_iter().for_each(|heights| shape.include(heights));
                shape.tiles(camera)
            } else {
                let reached = ReachableSet::of(&publication.header, &memory.host.lock().unwrap()[HEADER..]);
                reached.chunks.into_iter().map(|(pos, _)| TileKey { level: 0, pos }).collect()
            };
            let shown = union(&*source, &tiles).unwrap();
            errors = errors.and(judge(&mut stream, &mut tracer, &on_device, &shown, rays, random.bits()));
            of_this += 1;
        }
        judged += of_this;
        let stats = streamer.stats();
        assert_eq!(stats.pool.failed, 0, "{stats:?}");
        dropped += stats.dropped;
        silent(&device);
    }
    println!(
        "{judged} publications, {dropped} tiles dropped, {} hits, {} wrong, on {}",
        errors.hits,
        errors.wrong(),
        device.capabilities().name
    );
    assert!(errors.wrong() == 0 && errors.hits > judged * rays / 20, "{errors:?}");
}

#[test]
fn rays_over_publications_are_exact_on_the_device() {
    trace(12, 600);
}

#[test]
#[ignore = "takes minutes without a GPU"]
fn rays_over_many_publications_are_exact_on_the_device() {
    trace(number("RAXEL_PUBLICATIONS", 200), number("RAXEL_RAYS", 1_000_000));
}
