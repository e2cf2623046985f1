//! The words that a frame can reach, summed on the device.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::time::Instant;

use glam::IVec3;
use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, CommandBuffer, ComputePipeline, DescriptorSlot, Descriptors, Device,
    Location, PipelineInfo, Resource, TimelineValue, vk,
};
use raxel_layouts::lights::{HEADER_WORDS, LIGHT_WORDS, LightPowers, TileLights, grouped_header};
use raxel_layouts::{MATERIAL_WORDS, TileBlock, TileNode};
use raxel_shader::{Compiler, Request, ShaderProvider as _};
use raxel_stream::{Publication, StreamOptions, Streamer, View};
use raxel_testing::ReachableSet;
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, ChunkProvider, Side};

use crate::{HEADER, IN_FLIGHT, Memory, PATIENCE, WORDS, device, endless, fly_on, number, reach, silent};

const LAMP_WORDS: u32 = 1 << 18;

/// A sum of words and their places, for each range of one of the buffers: bit 31 of its length says that it is of that of the lamps.
const SUMS: &str = include_str!("../fixtures/publications/sums.comp");

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
fn every_word_that_a_frame_reaches_is_right_on_the_device() {
    check_words(120, false);
    check_words(120, true);
}

#[test]
#[ignore = "takes minutes"]
fn every_word_is_right_on_the_device_in_ten_thousand_frames() {
    check_words(10_000, false);
    check_words(10_000, true);
}
