//! The memory of a pool on the device, and how words come to it: the host writes them in place, or the device copies them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use raxel_execute::ExecuteError;
use raxel_gpu::{Backing, Buffer, BufferInfo, Device, Location, SharedWords, UploadRing, vk};

use crate::PoolMemory;

/// How long a copy to the device may take.
const COPY: Duration = Duration::from_secs(60);

/// With the value `staged`, tiles go through staging memory on every device, also where the host could write them in place.
const UPLOADS: &str = "RAXEL_UPLOADS";

/// A buffer for a pool, and the way of words into it, by a ring of `ring` bytes where it is staged.
pub(super) fn pool_memory(
    device: &Arc<Device>,
    name: &str,
    bytes: u64,
    ring: u64,
    uploads: &Arc<Uploads>,
) -> Result<(Arc<Buffer>, Arc<dyn PoolMemory>), ExecuteError> {
    let buffer = pool_buffer(device, name, bytes)?;
    let memory: Arc<dyn PoolMemory> = if let Some(words) = SharedWords::new(buffer.clone()) {
        Arc::new(InPlace { words, uploads: uploads.clone() })
    } else {
        let ring = UploadRing::new(device, &buffer, ring, COPY).map_err(ExecuteError::from)?;
        Arc::new(Staged { ring, uploads: uploads.clone() })
    };
    Ok((buffer, memory))
}

/// Memory of the device that the host can write, if there is enough of it; otherwise memory that only the device sees.
fn pool_buffer(device: &Arc<Device>, name: &str, size: u64) -> Result<Arc<Buffer>, ExecuteError> {
    let usage =
        vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
    let make = |location| Buffer::new(device, name, &BufferInfo { size, usage, location }, Backing::Own);
    if std::env::var_os(UPLOADS).is_none_or(|how| how != "staged")
        && let Ok(buffer) = make(Location::Shared)
        && buffer.is_device_local()
    {
        return Ok(Arc::new(buffer));
    }
    Ok(Arc::new(make(Location::Device)?))
}

/// The fate of the words for the device.
#[derive(Default)]
pub(super) struct Uploads(Mutex<Arrived>);

#[derive(Default)]
enum Arrived {
    /// All of them, so far.
    #[default]
    All,
    /// Not all, which no frame knows yet.
    Failed(raxel_gpu::Error),
    /// Not all, which a frame has reported.
    Reported,
}

impl Uploads {
    /// Notes the first error.
    fn note(&self, result: raxel_gpu::Result<()>) {
        let mut arrived = self.arrived();
        if let (Err(error), Arrived::All) = (result, &*arrived) {
            *arrived = Arrived::Failed(error);
        }
    }

    /// Reports the error, once; from then on the device counts as lost.
    pub(super) fn check(&self) -> Result<(), ExecuteError> {
        let mut arrived = self.arrived();
        if let Arrived::All = *arrived {
            return Ok(());
        }
        match std::mem::replace(&mut *arrived, Arrived::Reported) {
            Arrived::Failed(error) => Err(error.into()),
            _ => Err(ExecuteError::DeviceLost { suspect: None, timed_out: false }),
        }
    }

    fn arrived(&self) -> MutexGuard<'_, Arrived> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The host writes the device's memory. Every submission that follows sees the words. No frame reaches words that are being stored: the
/// streamer writes only blocks that no unfinished frame can reach.
struct InPlace {
    words: SharedWords,
    uploads: Arc<Uploads>,
}

impl PoolMemory for InPlace {
    fn write(&self, at: u32, words: &[u32]) {
        self.uploads.note(self.words.store(u64::from(at), words));
    }
}

/// Words are copied by the device: frames that are submitted after a copy see them.
struct Staged {
    ring: UploadRing,
    uploads: Arc<Uploads>,
}

impl PoolMemory for Staged {
    fn write(&self, at: u32, words: &[u32]) {
        self.uploads.note(self.ring.write(4 * u64::from(at), bytemuck::cast_slice(words)));
    }

    fn flush(&self) {
        self.uploads.note(self.ring.flush());
    }
}

#[cfg(test)]
mod tests {
    use glam::IVec3;
    use raxel_gpu::{DeviceOptions, Validation};
    use raxel_world::{Material, World};
    use raxel_worldfile::StreamSettings;

    use super::*;
    use crate::{StreamOptions, Streamer, StreamingRange, View};

    /// Memory of the host.
    struct Host(Mutex<Vec<u32>>);

    impl PoolMemory for Host {
        fn write(&self, at: u32, words: &[u32]) {
            self.0.lock().unwrap()[at as usize..][..words.len()].copy_from_slice(words);
        }
    }

    /// Software devices let the host write everything, so that sessions there never stage.
    #[test]
    fn staged_words_arrive_as_written_ones_do() {
        const WORDS: u32 = 1 << 16;
        let device = Device::new(&DeviceOptions { device: None, validation: Validation::Required }).unwrap();
        let zeros = vec![0; 4 * WORDS as usize];
        let buffer = Arc::new(raxel_gpu::upload(&device, "pool", &zeros, COPY).unwrap());
        let host = Arc::new(Host(Mutex::new(vec![0; WORDS as usize])));
        // So small that it is full again and again.
        let uploads = Arc::new(Uploads::default());
        let ring = UploadRing::new(&device, &buffer, 10_000, COPY).unwrap();
        let staged = Arc::new(Staged { ring, uploads: uploads.clone() });

        let voxels =
            (0..4000).map(|i| (IVec3::new(i * 7 % 300 - 150, i * 13 % 90, i * 29 % 280 - 140), 1 + (i % 2) as u16));
        let world = Arc::new(World::from_voxels(vec![Material::air(); 3], voxels));
        let settings = StreamSettings { near: 200, far: 200, ..StreamSettings::default() };
        let memories: [Arc<dyn PoolMemory>; 2] = [host.clone(), staged.clone()];
        for memory in memories {
            // One worker takes its places in the order of the tiles.
            let options = StreamOptions { workers: 1, complete: true, upload: None, poison: false };
            let reach = StreamingRange::of(&settings, [0, 90]);
            let streamer = Streamer::new(world.clone(), memory, WORDS, reach, View::at(IVec3::ZERO), options);
            streamer.wait(Duration::from_secs(600)).unwrap();
            assert!(streamer.stats().live > 10);
        }
        let bytes = raxel_gpu::download_buffer(&device, &buffer, 0, buffer.size(), COPY).unwrap();
        assert!(bytes == bytemuck::cast_slice::<u32, u8>(&host.0.lock().unwrap()), "the words differ");
        assert!(uploads.check().is_ok() && uploads.check().is_ok());

        // Past the end of the buffer. A later success does not hide it.
        staged.write(WORDS - 1, &[1, 2]);
        staged.write(0, &[1]);
        staged.flush();
        let error = uploads.check().unwrap_err();
        assert!(matches!(&error, ExecuteError::Gpu(raxel_gpu::Error::NotWritable { .. })), "{error}");
        for _ in 0..2 {
            let lost = uploads.check().unwrap_err();
            assert!(matches!(lost, ExecuteError::DeviceLost { .. }), "{lost}");
        }
        let messages = device.log().take();
        assert!(messages.is_empty(), "{messages:#?}");
    }
}
