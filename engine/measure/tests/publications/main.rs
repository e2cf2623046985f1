//! A streamed world on a device while it changes: rays through its buffer against the exact tracer, and every word that a frame can reach
//! against its source, while other tiles are written, evicted and overwritten with poison.
//!
//! The long runs, for a GPU: `RAXEL_PUBLICATIONS=200 RAXEL_RAYS=1000000 cargo test --release -p raxel-measure --test publications --
//! --ignored --nocapture`.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod rays;
mod words;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use glam::IVec3;
use raxel_edit::ChunkCache;
use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, CommandBuffer, Device, DeviceOptions, Location, SharedWords, UploadRing,
    Validation, vk,
};
use raxel_stream::{PoolMemory, StreamOptions, Streamer, StreamingRange, View};
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Mode, Unavailable};
use raxel_worldfile::StreamSettings;

const PATIENCE: Duration = Duration::from_secs(120);
const HEADER: usize = 16;
const WORDS: u32 = 1 << 20;

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
