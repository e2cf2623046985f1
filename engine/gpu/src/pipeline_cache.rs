//! The driver's compiled shaders, kept from one run to the next (`VkPipelineCache`).

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;
use raxel_cache::Cache;

use crate::result::{Named, Result};

/// Bytes of the header that every driver's data begins with (`VkPipelineCacheHeaderVersionOne`). A driver that keeps nothing gives no more.
const HEADER: usize = 16 + vk::UUID_SIZE;

/// Most bytes that are kept of a device: some hundred shaders that hold a tracer. Drivers never forget a pipeline by themselves, so with
/// more than that the next process starts over.
const MAX_BYTES: usize = 48 << 20;

/// Pipelines that a device has made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PipelineCounts {
    /// All of them.
    pub made: u64,
    /// Those that the driver found in its cache and did not compile.
    pub found: u64,
}

/// The pipeline cache of a device.
pub(crate) struct PipelineCache {
    pub(crate) raw: vk::PipelineCache,
    disk: Option<(Arc<Cache>, String)>,
    made: AtomicU64,
    found: AtomicU64,
    /// Pipelines that were compiled when it was last written.
    written: AtomicU64,
}

impl PipelineCache {
    /// With the entry of `disk` for this device and this version of its driver.
    pub(crate) fn new(
        raw: &ash::Device,
        properties: &vk::PhysicalDeviceProperties,
        disk: Option<Arc<Cache>>,
    ) -> Result<PipelineCache> {
        let disk = disk.map(|cache| (cache, name(properties)));
        let kept = disk.as_ref().and_then(|(cache, name)| {
            let bytes = cache.read(name)?;
            if is_of(&bytes, properties) {
                return Some(bytes);
            }
            cache.discard(name, "it belongs to another device or driver");
            None
        });
        let create = |bytes: &[u8]| {
            let info = vk::PipelineCacheCreateInfo::default().initial_data(bytes);
            // SAFETY: the data is empty, or came from this driver for this device: the header names both, and a hash proves that it is
            // whole.
            unsafe { raw.create_pipeline_cache(&info, None) }
        };
        // A driver may refuse its own data, and works without.
        let cache = kept.and_then(|bytes| create(&bytes).ok()).map_or_else(|| create(&[]), Ok);
        Ok(PipelineCache {
            raw: cache.named("vkCreatePipelineCache")?,
            disk,
            made: AtomicU64::new(0),
            found: AtomicU64::new(0),
            written: AtomicU64::new(0),
        })
    }

    /// A pipeline was made; `feedback` is the driver's report.
    pub(crate) fn count(&self, feedback: vk::PipelineCreationFeedback) {
        let flags = feedback.flags;
        let found = flags.contains(vk::PipelineCreationFeedbackFlags::VALID)
            && flags.contains(vk::PipelineCreationFeedbackFlags::APPLICATION_PIPELINE_CACHE_HIT);
        self.made.fetch_add(1, Ordering::Relaxed);
        self.found.fetch_add(u64::from(found), Ordering::Relaxed);
    }

    pub(crate) fn counts(&self) -> PipelineCounts {
        PipelineCounts { made: self.made.load(Ordering::Relaxed), found: self.found.load(Ordering::Relaxed) }
    }

    /// Writes the driver's data, if it compiled anything since the last time.
    pub(crate) fn keep(&self, raw: &ash::Device) {
        let Some((cache, name)) = &self.disk else { return };
        let counts = self.counts();
        let compiled = counts.made.saturating_sub(counts.found);
        if self.written.swap(compiled, Ordering::Relaxed) == compiled {
            return;
        }
        // SAFETY: the cache is alive, and a driver reads it while others add to it. Without an answer, nothing is kept.
        match unsafe { raw.get_pipeline_cache_data(self.raw) } {
            Ok(bytes) if bytes.len() > MAX_BYTES => cache.remove(name),
            Ok(bytes) if bytes.len() > HEADER => cache.write(name, &bytes),
            _ => {}
        }
    }
}

/// Names the device and the driver: another of either has an entry of its own.
fn name(properties: &vk::PhysicalDeviceProperties) -> String {
    let uuid = u128::from_be_bytes(properties.pipeline_cache_uuid);
    format!(
        "pipelines-{:x}-{:x}-{:x}-{uuid:032x}",
        properties.vendor_id, properties.device_id, properties.driver_version
    )
}

/// Whether data begins with the header of this device ("Pipeline Cache Header", Vulkan 1.3, 10.7.3), which not every driver checks.
#[expect(clippy::cast_sign_loss, reason = "the constant of Vulkan is 1")]
fn is_of(bytes: &[u8], properties: &vk::PhysicalDeviceProperties) -> bool {
    let word = |at: usize| {
        let word = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    word(0).is_some_and(|length| length as usize >= HEADER && length as usize <= bytes.len())
        && word(4) == Some(vk::PipelineCacheHeaderVersion::ONE.as_raw() as u32)
        && word(8) == Some(properties.vendor_id)
        && word(12) == Some(properties.device_id)
        && bytes.get(16..HEADER) == Some(&properties.pipeline_cache_uuid[..])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ComputePipeline, Device, DeviceOptions, PipelineInfo, Validation};

    /// `void main() {}`.
    const EMPTY_SHADER: &[u32] = &[
        0x0723_0203,
        0x0001_0300,
        0,
        6,
        0,
        0x0002_0011,
        1,
        0x0003_000e,
        0,
        1,
        0x0005_000f,
        5,
        4,
        0x6e69_616d,
        0,
        0x0006_0010,
        4,
        17,
        1,
        1,
        1,
        0x0002_0013,
        2,
        0x0003_0021,
        3,
        2,
        0x0005_0036,
        2,
        4,
        0,
        3,
        0x0002_00f8,
        5,
        0x0001_00fd,
        0x0001_0038,
    ];

    /// Opens the device, makes a pipeline, closes it.
    fn run(cache: &Arc<Cache>) -> (PipelineCounts, String) {
        let options = DeviceOptions { device: None, validation: Validation::Required };
        let device = Device::with_cache(&options, Some(cache.clone())).expect("a driver and the validation layer");
        // SAFETY: the instance is alive, and the device is one of its own.
        let properties = unsafe { device.instance.raw.get_physical_device_properties(device.physical) };
        let info = PipelineInfo {
            spirv: EMPTY_SHADER,
            entry: "main",
            slots: &[],
            push_bytes: 0,
            specialization: &[],
            subgroup_size: None,
        };
        ComputePipeline::new(&device, "empty", &info).expect("it is a sound module");
        assert_eq!(device.log().take(), []);
        (device.pipeline_counts(), name(&properties))
    }

    #[test]
    fn what_the_driver_gives_is_kept_and_what_is_foreign_is_not_given_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let warnings = Arc::new(AtomicU64::new(0));
        let count = warnings.clone();
        let cache = Arc::new(Cache::at(folder.path()).with_warning(move |_, _| {
            count.fetch_add(1, Ordering::Relaxed);
        }));
        let (counts, name) = run(&cache);
        assert_eq!(counts, PipelineCounts { made: 1, found: 0 });
        // Lavapipe before Mesa 24 keeps only the header.
        let gives = cache.read(&name).is_some();
        let (counts, _) = run(&cache);
        assert!(counts.made == 1 && (gives || counts.found == 0), "{counts:?}");
        assert_eq!(warnings.load(Ordering::Relaxed), 0);
        // Whole, and of another device.
        cache.write(&name, &[1; 64]);
        run(&cache);
        assert_eq!(warnings.load(Ordering::Relaxed), 1);
        assert_ne!(cache.read(&name), Some(vec![1; 64]));
    }

    #[test]
    fn only_data_of_the_same_device_and_driver_is_given_to_it() {
        let properties = vk::PhysicalDeviceProperties {
            vendor_id: 0x10de,
            device_id: 0x2335,
            driver_version: 7,
            pipeline_cache_uuid: std::array::from_fn(|i| i as u8),
            ..Default::default()
        };
        let header = |length: u32, version: u32, vendor: u32, device: u32| {
            let words = [length, version, vendor, device].map(u32::to_le_bytes).concat();
            [&words[..], &properties.pipeline_cache_uuid[..], b"data"].concat()
        };
        let own = header(32, 1, 0x10de, 0x2335);
        assert!(is_of(&own, &properties));
        for other in [
            header(31, 1, 0x10de, 0x2335),
            header(37, 1, 0x10de, 0x2335),
            header(32, 2, 0x10de, 0x2335),
            header(32, 1, 0x1002, 0x2335),
            header(32, 1, 0x10de, 0x2336),
            own[..31].to_vec(),
            Vec::new(),
        ] {
            assert!(!is_of(&other, &properties), "{other:?}");
        }
        let mut newer = properties;
        newer.pipeline_cache_uuid[3] ^= 1;
        assert!(!is_of(&own, &newer));
        assert_ne!(name(&newer), name(&properties));
        newer = vk::PhysicalDeviceProperties { driver_version: 8, ..properties };
        assert_ne!(name(&newer), name(&properties));
    }
}
