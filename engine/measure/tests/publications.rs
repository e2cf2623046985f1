//! A streamed world on a device while it changes: rays through its buffer against the exact tracer, and every word that a frame can reach
//! against its source, while other tiles are written, evicted and overwritten with poison.
//!
//! The long runs, for a GPU: `RAXEL_PUBLICATIONS=200 RAXEL_RAYS=1000000 cargo test --release -p raxel-measure --test publications --
//! --ignored --nocapture`.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::IVec3;
use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_edit::{Brush, ChunkCache, EditedChunks, Edits, Operation, Scene};
use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, CommandBuffer, ComputePipeline, DescriptorSlot, Descriptors, Device,
    DeviceOptions, Location, PipelineInfo, Resource, SharedWords, TimelineValue, UploadRing, Validation, vk,
};
use raxel_layouts::lights::{HEADER_WORDS, LIGHT_WORDS, LightPowers, TileLights, grouped_header};
use raxel_layouts::{Layout, MATERIAL_WORDS, TileBlock, TileNode};
use raxel_measure::rays::{DeviceWorld, Method, Stream, Tracer};
use raxel_oracle::metrics::Errors;
use raxel_oracle::sets::{RaySet, RayTargets};
use raxel_oracle::{Oracle, Ray, sets};
use raxel_shader::{Compiler, Request, ShaderProvider as _};
use raxel_stream::{
    PoolMemory, Publication, ReachableSet, StreamOptions, Streamer, StreamingRange, TileKey, View, union,
};
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Mode, Side, Unavailable, World};
use raxel_worldfile::StreamSettings;
use rayon::prelude::*;

const PATIENCE: Duration = Duration::from_secs(120);
const HEADER: usize = 16;
const WORDS: u32 = 1 << 20;
const LAMP_WORDS: u32 = 1 << 18;
/// Frames that the device has not finished.
const IN_FLIGHT: usize = 3;

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|value| value.parse().ok()).unwrap_or(default)
}

fn device() -> Arc<Device> {
    let validation = if std::env::var_os("RAXEL_NO_LAYERS").is_some() { Validation::Off } else { Validation::Required };
    Device::new(&DeviceOptions { device: None, validation }).unwrap()
}

fn silent(device: &Device) {
    let messages = device.log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

/// The buffer, how words come to it, and the same words on the host.
struct Memory {
    buffer: Arc<Buffer>,
    way: Way,
    host: Mutex<Vec<u32>>,
}

/// The way of words into the buffer.
enum Way {
    InPlace(SharedWords),
    Staged(Box<UploadRing>),
}

impl Memory {
    /// `staged`: through a ring that is much smaller than what is written.
    fn new(device: &Arc<Device>, count: u32, staged: bool) -> Arc<Self> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let location = if staged { Location::Device } else { Location::Shared };
        let info = BufferInfo { size: 4 * u64::from(count), usage, location };
        let buffer = Arc::new(Buffer::new(device, "world", &info, Backing::Own).unwrap());
        let way = match SharedWords::new(buffer.clone()) {
            Some(words) => Way::InPlace(words),
            None => Way::Staged(Box::new(UploadRing::new(device, &buffer, 1 << 18, PATIENCE).unwrap())),
        };
        Arc::new(Self { buffer, way, host: Mutex::new(vec![0; count as usize]) })
    }
}

impl PoolMemory for Memory {
    fn write(&self, at: u32, words: &[u32]) {
        self.host.lock().unwrap()[at as usize..][..words.len()].copy_from_slice(words);
        match &self.way {
            Way::InPlace(shared) => shared.store(at.into(), words).unwrap(),
            Way::Staged(ring) => ring.write(4 * u64::from(at), bytemuck::cast_slice(words)).unwrap(),
        }
    }

    fn flush(&self) {
        if let Way::Staged(ring) = &self.way {
            ring.flush().unwrap();
        }
    }
}

/// The material that gives off light.
const LAMP: u16 = 6;

fn materials() -> Vec<Material> {
    let matt = (1..6).map(|n| Material::matt(format!("m{n}"), [0.5; 3]));
    let lamp = Material { emission: 3.0, ..Material::matt("lamp", [1.0; 3]) };
    std::iter::once(Material::air()).chain(matt).chain([lamp]).collect()
}

/// A world without end of small things in six materials, one of them a light, different in every chunk; some chunks are empty, and some
/// full.
struct Endless(Vec<Material>);

impl Endless {
    fn chunk(level: u32, pos: ChunkPos) -> Content {
        let mut dense = DenseChunk::default();
        if level > 0 {
            for child in 0..64 {
                let cell = raxel_world::child_cell(child);
                let [x, y, z] = cell.map(|c| c as i32);
                let below = Self::chunk(level - 1, ChunkPos::new(4 * pos.x + x, 4 * pos.y + y, 4 * pos.z + z));
                raxel_world::reduce(&below, cell, &mut dense);
            }
            return Content::pack(&dense);
        }
        let seed = [pos.x, pos.y, pos.z].iter().fold(7u64, |seed, c| {
            (seed ^ u64::from(c.cast_unsigned())).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
        });
        let mut random = SplitMix64::new(seed);
        match random.below(12) {
            0..=5 => return Content::Empty,
            6 => return Content::Full(1 + random.below(5) as u16),
            _ => {}
        }
        for _ in 0..40 {
            let block = random.below(4096) as usize;
            dense.apply(block, u64::MAX, Mode::Add, 1 + random.below(5) as u16);
            dense.apply(block, random.bits(), Mode::Add, 1 + random.below(5) as u16);
            dense.apply(random.below(4096) as usize, random.bits(), Mode::Add, 1 + random.below(5) as u16);
        }
        // Two of the lamps touch the next chunk.
        for n in 0..6 {
            let [x, y, z] = [0; 3].map(|_| random.below(64) as u32);
            dense.set(if n < 2 { 63 } else { x }, y, z, LAMP);
        }
        Content::pack(&dense)
    }
}

impl ChunkProvider for Endless {
    fn materials(&self) -> &[Material] {
        &self.0
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(Self::chunk(level, pos))
    }
}

fn endless() -> Arc<dyn ChunkProvider> {
    // A memory of it, since coarse tiles are made of many chunks.
    Arc::new(ChunkCache::new(Arc::new(Endless(materials())), 1 << 30))
}

fn reach(near: u32, far: u32) -> StreamingRange {
    StreamingRange::of(&StreamSettings { near, far, ..StreamSettings::default() }, [-128, 128])
}

fn streamer(source: Arc<dyn ChunkProvider>, memory: &Arc<Memory>, reach: StreamingRange, complete: bool) -> Streamer {
    let options = StreamOptions { workers: 2, complete, upload: None, poison: true };
    Streamer::new(source, memory.clone(), WORDS, reach, View::at(IVec3::ZERO), options)
}

/// Steps and jumps, up to 2²⁴ voxels away.
fn fly_on(camera: IVec3, random: &mut SplitMix64) -> IVec3 {
    let jump = [130, 130, 3000, 1 << 24][random.below(4) as usize];
    let mut by = |range: i32| random.below(2 * range as u64 + 1) as i32 - range;
    let to = camera + IVec3::new(by(jump), by(40), by(jump));
    to.clamp(IVec3::new(-(1 << 25), -100, -(1 << 25)), IVec3::new(1 << 25, 100, 1 << 25))
}

/// Runs commands to their end.
fn run(device: &Arc<Device>, record: impl FnOnce(&mut raxel_gpu::Recording<'_>)) {
    let mut commands = CommandBuffer::new(device, "test").unwrap();
    let mut recording = commands.begin().unwrap();
    recording.barrier(&Barrier::full());
    record(&mut recording);
    recording.barrier(&Barrier::full());
    let finished_at = recording.submit().unwrap();
    device.wait(finished_at, PATIENCE).unwrap();
}

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

/// A sum of words and their places, for each range of one of the buffers: bit 31 of its length says that it is of that of the lamps.
const SUMS: &str = include_str!("fixtures/publications/sums.comp");

fn sum(words: &[u32]) -> u32 {
    (0u32..).zip(words).fold(0, |sum, (i, word)| {
        let word = (word ^ i.wrapping_mul(0x9e37_79b9)).wrapping_mul(0x85eb_ca6b);
        sum.wrapping_add(word ^ word >> 15)
    })
}

/// A part of a buffer: first word, words with [`OF_LAMPS`], and their sum.
type Range = (u32, u32, u32);

/// A range is of the buffer of lamps.
const OF_LAMPS: u32 = 1 << 31;

/// Ranges that a frame can have.
const MOST_RANGES: u64 = 1 << 13;

/// A frame on the device.
struct Frame {
    publication: Arc<Publication>,
    ranges: Vec<Range>,
    slot: usize,
    finished_at: TimelineValue,
}

/// A frame's own buffers.
struct OwnBuffers {
    ranges: Arc<Buffer>,
    sums: Arc<Buffer>,
    back: Buffer,
    descriptors: Descriptors,
    commands: CommandBuffer,
}

fn pipeline(device: &Arc<Device>) -> (ComputePipeline, Vec<String>) {
    let files = MemoryFiles::default();
    files.insert("sums.comp", SUMS.as_bytes());
    let request = Request { path: "sums.comp".into(), entry: "main".into(), defines: Vec::new() };
    let (shader, _) = Compiler::new(Arc::new(files)).shader(&request, &mut SourceMap::default()).unwrap();
    let slot = |binding: &raxel_shader::interface::Binding| DescriptorSlot {
        set: binding.set,
        binding: binding.binding,
        ty: vk::DescriptorType::STORAGE_BUFFER,
        count: binding.count,
    };
    let slots: Vec<DescriptorSlot> = shader.interface.bindings.iter().map(slot).collect();
    let info = PipelineInfo {
        spirv: &shader.spirv,
        entry: "main",
        slots: &slots,
        push_bytes: 0,
        specialization: &[],
        subgroup_size: None,
    };
    let names = shader.interface.bindings.iter().map(|binding| binding.name.clone()).collect();
    (ComputePipeline::new(device, "sums", &info).unwrap(), names)
}

impl OwnBuffers {
    fn new(
        device: &Arc<Device>,
        [memory, lamps]: [&Memory; 2],
        (pipeline, names): &(ComputePipeline, Vec<String>),
    ) -> Self {
        let buffer = |name: &str, size: u64, usage, location| {
            Buffer::new(device, name, &BufferInfo { size, usage, location }, Backing::Own).unwrap()
        };
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let (from, to) = (vk::BufferUsageFlags::TRANSFER_SRC, vk::BufferUsageFlags::TRANSFER_DST);
        let ranges = Arc::new(buffer("ranges", 8 * MOST_RANGES, storage, Location::Upload));
        let sums = Arc::new(buffer("sums", 4 * MOST_RANGES, storage | from, Location::Device));
        let back = buffer("sums, back", 4 * MOST_RANGES, to, Location::Download);
        let of = |name: &String| {
            let buffer = match name.to_lowercase().as_str() {
                "world" => &memory.buffer,
                "lamps" => &lamps.buffer,
                "ranges" => &ranges,
                _ => &sums,
            };
            vec![Resource::whole(buffer)]
        };
        let resources: Vec<Vec<Resource>> = names.iter().map(of).collect();
        let descriptors = Descriptors::new(device, "sums", pipeline, &resources).unwrap();
        let commands = CommandBuffer::new(device, "sums").unwrap();
        Self { ranges, sums, back, descriptors, commands }
    }

    /// A frame that sums the ranges of a publication on the device. Nothing waits for it here.
    fn submit(
        &mut self,
        [memory, lamps]: [&Memory; 2],
        pipeline: &ComputePipeline,
        publication: &Publication,
        ranges: &[Range],
    ) -> TimelineValue {
        assert!(ranges.len() as u64 <= MOST_RANGES, "{} ranges", ranges.len());
        let words: Vec<[u32; 2]> = ranges.iter().map(|(at, count, _)| [*at, *count]).collect();
        self.ranges.write(0, bytemuck::cast_slice(&words)).unwrap();
        let mut recording = self.commands.begin().unwrap();
        recording.barrier(&Barrier::full());
        recording.update_buffer(&memory.buffer, 0, bytemuck::cast_slice(publication.words()));
        recording.update_buffer(&lamps.buffer, 0, bytemuck::cast_slice(&publication.lights.expect("there are lamps")));
        recording.barrier(&Barrier::full());
        recording.bind(pipeline, &self.descriptors);
        recording.dispatch([ranges.len() as u32, 1, 1]);
        recording.barrier(&Barrier::full());
        recording.copy_buffer((&self.sums, 0), (&self.back, 0), 4 * ranges.len() as u64);
        recording.barrier(&Barrier::full());
        recording.submit().unwrap()
    }

    fn sums(&self, count: usize) -> Vec<u32> {
        let mut bytes = vec![0; 4 * count];
        assert!(self.back.read(0, &mut bytes));
        bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
    }
}

/// A chunk as it must be in the buffers.
struct Expected {
    node: TileNode,
    range: Option<Range>,
    lights: TileLights,
}

/// The expected contents of chunks, by their places in the world and in the buffer.
type Known = HashMap<(ChunkPos, u32), Expected>;

/// Everything behind the headers that a publication reaches: its directory and the table of its groups of lamps, as they are, and the words of
/// each chunk and of its lamps, as they follow from the source. The nodes of chunks and the headers of lamps are compared here.
fn reached(
    source: &dyn ChunkProvider,
    [words, lamps]: [&[u32]; 2],
    publication: &Publication,
    known: &mut Known,
) -> Vec<Range> {
    let body = &words[HEADER..];
    let full_run = (MATERIAL_WORDS * source.materials().len() as u32).next_multiple_of(4);
    let powers = LightPowers::of(source.materials()).unwrap();
    let reached = ReachableSet::of(&publication.header, body);
    let of = |of: &[u32], at: u32, count: u32| (at, count, sum(&of[at as usize..][..count as usize]));
    let nodes = reached.nodes.iter().map(|range| of(words, HEADER as u32 + range.start, range.len() as u32));
    let mut ranges: Vec<Range> = nodes.collect();
    // The groups of the table are those of the chunks, in the same order.
    let header = publication.lights.unwrap();
    let [_, _, table, group_count] = header;
    let table = HEADER_WORDS as u32 + 4 * table;
    let (at, count, sum_of_table) = of(lamps, table, if group_count == 0 { 0 } else { 4 * group_count });
    ranges.push((at, count | OF_LAMPS, sum_of_table));
    let mut rows = lamps[table as usize..][..4 * group_count as usize].chunks_exact(4);
    let mut groups = Vec::new();
    for (pos, node) in reached.chunks {
        let first = if node.filled_material().is_some() { 0 } else { 4 * node.0[2] };
        let expected = known.entry((pos, first)).or_insert_with(|| {
            let content = source.try_chunk(0, pos).unwrap();
            let beside = |face| Arc::new(Side::of(&source.try_chunk(0, pos.beside(face)).unwrap(), face ^ 1));
            let lights = TileLights::of(&content, (0, pos), &powers, beside);
            match TileBlock::of(&content, 0) {
                Ok(block) => {
                    let (words, node) = block.encode(first, full_run);
                    Expected { node, range: Some((HEADER as u32 + first, words.len() as u32, sum(&words))), lights }
                }
                Err(node) => Expected { node: node.expect("an empty chunk is not reached"), range: None, lights },
            }
        });
        assert_eq!(node, expected.node, "chunk {pos:?} of version {}", publication.version);
        ranges.extend(expected.range);
        if !expected.lights.is_empty() {
            let first = rows.next().expect("a group for each chunk with lamps")[0];
            let (words, group) = expected.lights.encode(first);
            groups.extend(group.into_iter().map(|(_, group)| group));
            ranges.push((HEADER_WORDS as u32 + LIGHT_WORDS as u32 * first, words.len() as u32 | OF_LAMPS, sum(&words)));
        }
    }
    assert!(rows.next().is_none(), "groups of chunks that are not there");
    assert_eq!(header, if groups.is_empty() { [0; HEADER_WORDS] } else { grouped_header(&groups, header[2]) });
    ranges
}

/// Many publications in a row, each shown by a frame. Up to three frames are on the device at a time. The device sums every word that a
/// frame can reach, of voxels and of lamps, and the sums are those of the source.
fn check_words(publications: u64, staged: bool) {
    let device = device();
    let [memory, lamps] = [WORDS, LAMP_WORDS].map(|words| Memory::new(&device, words, staged));
    let buffers = [&*memory, &*lamps];
    let source = endless();
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: true };
    let streamer = Streamer::with_lamps(
        source.clone(),
        (memory.clone(), WORDS),
        Some((lamps.clone(), LAMP_WORDS)),
        reach(192, 192),
        View::at(IVec3::ZERO),
        options,
    );
    let pipeline = pipeline(&device);
    let mut slots: Vec<OwnBuffers> = (0..IN_FLIGHT).map(|_| OwnBuffers::new(&device, buffers, &pipeline)).collect();
    let mut random = SplitMix64::new(number("RAXEL_SEED", 3));
    let (mut camera, mut known) = (IVec3::ZERO, HashMap::new());
    let mut in_flight: VecDeque<Frame> = VecDeque::new();
    let (mut ranges_checked, mut words_checked) = (0, [0u64; 2]);
    let began = Instant::now();
    for frame in 0..publications {
        let until = Instant::now() + PATIENCE;
        let publication = loop {
            if let Some(taken) = streamer.take() {
                break taken;
            }
            if streamer.is_settled() {
                camera = fly_on(camera, &mut random);
                streamer.follow(View::at(camera));
            }
            assert!(Instant::now() < until, "frame {frame}: {:?}", streamer.stats());
            std::thread::yield_now();
        };
        let words = buffers.map(|buffer| buffer.host.lock().unwrap());
        let ranges = reached(&*source, words.each_ref().map(|words| &words[..]), &publication, &mut known);
        drop(words);
        if known.len() > 20_000 {
            known.clear();
        }
        let slot = (frame % IN_FLIGHT as u64) as usize;
        let finished_at = slots[slot].submit(buffers, &pipeline.0, &publication, &ranges);
        in_flight.push_back(Frame { publication, ranges, slot, finished_at });
        while in_flight.len() >= IN_FLIGHT || (frame + 1 == publications && !in_flight.is_empty()) {
            let Frame { publication, ranges, slot, finished_at } = in_flight.pop_front().unwrap();
            device.wait(finished_at, PATIENCE).unwrap();
            for (found, (at, count, expected)) in slots[slot].sums(ranges.len()).into_iter().zip(&ranges) {
                let (count, lamps) = (count & !OF_LAMPS, count & OF_LAMPS != 0);
                let version = publication.version;
                assert_eq!(found, *expected, "{count} words at {at} of version {version} are torn, lamps: {lamps}");
                words_checked[usize::from(lamps)] += u64::from(count);
            }
            ranges_checked += ranges.len();
            if let Some(next) = in_flight.front() {
                streamer.released(next.publication.version);
            }
        }
    }
    let stats = streamer.stats();
    println!(
        "{publications} publishing frames, {ranges_checked} ranges, {} words of voxels, {} of lamps, {} tiles made, {} dropped, {:.0} s, on {}",
        words_checked[0],
        words_checked[1],
        stats.made,
        stats.dropped,
        began.elapsed().as_secs_f64(),
        device.capabilities().name
    );
    let [voxels, of_lamps] = words_checked;
    assert!(voxels > 2_000 * publications && of_lamps > 100 * publications, "{words_checked:?} words, {stats:?}");
    assert!(stats.dropped > 20 && stats.unlisted == 0, "{stats:?}");
    silent(&device);
}

#[test]
fn rays_over_publications_are_exact_on_the_device() {
    trace(12, 600);
}

#[test]
fn every_word_that_a_frame_reaches_is_right_on_the_device() {
    check_words(120, false);
    check_words(120, true);
}

#[test]
#[ignore = "takes minutes without a GPU"]
fn rays_over_many_publications_are_exact_on_the_device() {
    trace(number("RAXEL_PUBLICATIONS", 200), number("RAXEL_RAYS", 1_000_000));
}

#[test]
#[ignore = "takes minutes"]
fn every_word_is_right_on_the_device_in_ten_thousand_frames() {
    check_words(10_000, false);
    check_words(10_000, true);
}
