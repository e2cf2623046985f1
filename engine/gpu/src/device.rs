//! The logical device: one queue, its timeline, its memory, and its capabilities.

mod open;

use std::collections::BTreeSet;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ash::{amd, ext, khr, vk};
use gpu_allocator::vulkan::Allocator;
use raxel_cache::Cache;

use crate::candidates::look_at_all;
use crate::choice::{DeviceKind, Verdict, Version, choose};
use crate::instance::{Instance, Validation};
use crate::log::ValidationLog;
use crate::pipeline_cache::{PipelineCache, PipelineCounts};
use crate::query::QueueClock;
use crate::queue::Queue;
use crate::result::{Error, Named, Result};
use crate::retire::Retired;

/// How a device is opened.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Index in the loader's list or a part of the name; `None` takes `RAXEL_DEVICE` from the environment, else the best one.
    pub device: Option<String>,
    /// How much is checked.
    pub validation: Validation,
}

/// The capabilities of the device that raxel uses.
#[derive(Clone, Debug)]
#[allow(clippy::struct_excessive_bools, reason = "each is a feature of its own, there or not")]
pub struct Capabilities {
    /// Name of the device.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Kind of the device.
    pub kind: DeviceKind,
    /// Vulkan version of the device.
    pub version: Version,
    /// Bytes of device-local memory.
    pub memory: u64,
    /// `VkPhysicalDeviceLimits`.
    pub limits: vk::PhysicalDeviceLimits,
    /// Invocations in a subgroup.
    pub subgroup_size: u32,
    /// The least and the most invocations in a subgroup that a compute pipeline can ask for (`VK_EXT_subgroup_size_control`); `None` where it
    /// cannot ask, or could not for every workgroup.
    pub subgroup_sizes: Option<[u32; 2]>,
    /// Subgroup operations that compute shaders have.
    pub subgroup_operations: vk::SubgroupFeatureFlags,
    /// SPIR-V capabilities that a shader may declare.
    pub shaders: BTreeSet<spirv::Capability>,
    /// 64-bit integers in shaders (`shaderInt64`).
    pub int64: bool,
    /// Out-of-range buffer accesses stay in the buffer (`robustBufferAccess`).
    pub robust_buffers: bool,
    /// Out-of-range image accesses read zero (`robustImageAccess`).
    pub robust_images: bool,
    /// Storage images may be loaded without a format qualifier.
    pub read_without_format: bool,
    /// Storage images may be stored to without a format qualifier.
    pub write_without_format: bool,
    /// The clock of the queue; `None` when it takes no timestamps.
    pub clock: Option<QueueClock>,
    /// Why no window can be presented to; `None` where one can.
    pub cannot_present: Option<&'static str>,
    /// Ballots and votes that do not ask which invocations are active (`VK_EXT_shader_subgroup_ballot`, `VK_EXT_shader_subgroup_vote`).
    pub plain_ballots: bool,
    /// Markers cost a word in the command stream (`VK_AMD_buffer_marker`); elsewhere a dependency and a fill.
    pub buffer_markers: bool,
    /// The queue can draw triangles, not only compute.
    pub graphics: bool,
    /// The validation layer is on.
    pub validated: bool,
}

impl Capabilities {
    /// The first SPIR-V capability that a module declares and the device lacks.
    pub fn lacks(&self, spirv: &[u32]) -> Option<String> {
        crate::modules::lacking(&self.shaders, spirv)
    }
}

/// An open device. Everything made on it holds an `Arc` of it.
pub struct Device {
    pub(crate) raw: ash::Device,
    pub(crate) physical: vk::PhysicalDevice,
    pub(crate) queue: Queue,
    pub(crate) swapchain: Option<khr::swapchain::Device>,
    pub(crate) debug: Option<ext::debug_utils::Device>,
    pub(crate) marker: Option<amd::buffer_marker::Device>,
    /// `None` only while the device is dropped.
    pub(crate) allocator: Mutex<Option<Allocator>>,
    pub(crate) retired: Mutex<Retired>,
    pub(crate) pipelines: PipelineCache,
    /// The driver reported the loss, or the device was abandoned.
    pub(crate) lost: AtomicBool,
    /// Its work may never end.
    pub(crate) hung: AtomicBool,
    capabilities: Capabilities,
    verdicts: Vec<Verdict>,
    id: u64,
    pub(crate) instance: Arc<Instance>,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Device").field(&self.capabilities.name).finish()
    }
}

impl Device {
    /// Opens the best device, or the one that `options` or `RAXEL_DEVICE` names.
    pub fn new(options: &DeviceOptions) -> Result<Arc<Device>> {
        Self::with_cache(options, raxel_cache::of_process())
    }

    /// As [`Device::new`], but keeps the driver's compiled shaders in this cache, and not in that of the process. `None` keeps nothing.
    pub fn with_cache(options: &DeviceOptions, cache: Option<Arc<Cache>>) -> Result<Arc<Device>> {
        let instance = Instance::new(options.validation)?;
        let wanted = options
            .device
            .clone()
            .or_else(|| std::env::var("RAXEL_DEVICE").ok())
            .filter(|text| !text.trim().is_empty());
        let looked_at = look_at_all(&instance)?;
        let verdicts = choose(looked_at.iter().map(|seen| seen.candidate.clone()).collect(), wanted.as_deref());
        let Some(chosen) = verdicts.iter().position(|verdict| verdict.chosen) else {
            let candidates = verdicts.iter().map(ToString::to_string).collect();
            return Err(match wanted {
                Some(wanted) if !verdicts.is_empty() => Error::NoSuchDevice { wanted, candidates },
                _ => Error::NoDriver { candidates },
            });
        };
        open::open(instance, &looked_at[chosen], verdicts, cache)
    }

    /// Another device of the same hardware; see [`Device::beside`].
    pub fn another(&self) -> Result<Arc<Device>> {
        let chosen = self.verdicts.iter().find(|verdict| verdict.chosen);
        self.beside(&chosen.map_or(0, |verdict| verdict.candidate.index).to_string())
    }

    /// Another device, of the hardware with this number in the loader's list or with this in its name, checked as this one is. The
    /// devices share nothing, not even the instance. A software driver has a pool of threads for each instance, so work on one device
    /// does not wait for work on the other.
    pub fn beside(&self, wanted: &str) -> Result<Arc<Device>> {
        let validation = if self.capabilities.validated { Validation::Required } else { Validation::Off };
        Device::new(&DeviceOptions { device: Some(wanted.to_owned()), validation })
    }

    /// Every device the loader listed and why it was or was not chosen; the text `raxel` prints.
    pub fn verdicts(&self) -> &[Verdict] {
        &self.verdicts
    }

    /// Its capabilities.
    pub fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    /// A number that no other device of this process has: caches of a device use it as their key.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Messages of the validation layer.
    pub fn log(&self) -> &ValidationLog {
        &self.instance.log
    }

    /// Whether a call reported the loss of the device. Nothing can be done with a lost device but to open another.
    pub fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Relaxed)
    }

    /// Declares the device lost: nothing is waited for any more and its objects are leaked, since the device may still use them.
    pub fn abandon(&self) {
        ABANDONED.store(true, Ordering::Relaxed);
        self.hung.store(true, Ordering::Relaxed);
        self.lost.store(true, Ordering::Relaxed);
    }

    /// Whether its work may never end.
    pub(crate) fn is_hung(&self) -> bool {
        self.hung.load(Ordering::Relaxed)
    }

    /// The number of made pipelines, and the number that the driver had kept.
    pub fn pipeline_counts(&self) -> PipelineCounts {
        self.pipelines.counts()
    }

    /// Keeps the driver's compiled shaders so far for the next process, if this one has a cache (`raxel_cache`). Closing the device does
    /// so, too.
    pub fn keep_pipelines(&self) {
        self.pipelines.keep(&self.raw);
    }

    /// Gives a handle a name in messages and captures.
    pub(crate) fn name<H: vk::Handle>(&self, handle: H, name: &str) {
        if let (Some(debug), Ok(name)) = (&self.debug, std::ffi::CString::new(name)) {
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
            // SAFETY: the handle is alive and belongs to this device. A name that cannot be set is no loss.
            let _ = unsafe { debug.set_debug_utils_object_name(&info) };
        }
    }

    /// Remembers a loss, whichever call reports it.
    pub(crate) fn watch<T>(&self, result: Result<T>) -> Result<T> {
        if matches!(result, Err(Error::DeviceLost)) {
            self.lost.store(true, Ordering::Relaxed);
        }
        result
    }

    /// The SPIR-V capabilities that a module declares beyond those of every device, and whether this device has each.
    pub fn demands(&self, spirv: &[u32]) -> Vec<(String, bool)> {
        crate::modules::demands(&self.capabilities.shaders, spirv)
    }

    /// Whether an image of this kind can be made with these usages.
    ///
    /// # Errors
    /// The driver does not say: it has no memory for the answer, for example.
    pub fn image_support(&self, info: &crate::image::ImageInfo) -> Result<bool> {
        Ok(self.image_properties(info)?.is_some_and(|limits| {
            limits.max_mip_levels >= info.mips
                && limits.max_array_layers >= info.layers
                && limits.max_extent.width >= info.extent[0]
                && limits.max_extent.height >= info.extent[1]
                && limits.max_extent.depth >= info.extent[2]
        }))
    }

    /// Bytes that an image of this format, dimension and usage may have (`maxResourceSize`); 0 if there can be none.
    pub fn largest_image(&self, info: &crate::image::ImageInfo) -> u64 {
        match self.image_properties(info) {
            Ok(limits) => limits.map_or(0, |limits| limits.max_resource_size),
            // A driver that does not say allows at least this; it is asked again when the image is made.
            Err(_) => LEAST_RESOURCE_SIZE,
        }
    }

    /// `None` if there can be no such image.
    fn image_properties(&self, info: &crate::image::ImageInfo) -> Result<Option<vk::ImageFormatProperties>> {
        let (ty, flags) = info.kind();
        // SAFETY: a query on the physical device.
        let properties = unsafe {
            self.instance.raw.get_physical_device_image_format_properties(
                self.physical,
                info.format,
                ty,
                vk::ImageTiling::OPTIMAL,
                info.usage,
                flags,
            )
        };
        match properties {
            Err(vk::Result::ERROR_FORMAT_NOT_SUPPORTED) => Ok(None),
            properties => properties.named("vkGetPhysicalDeviceImageFormatProperties").map(Some),
        }
    }

    /// The uses of optimal-tiling images of a format.
    pub fn format_features(&self, format: vk::Format) -> vk::FormatFeatureFlags {
        // SAFETY: a query on the physical device.
        unsafe { self.instance.raw.get_physical_device_format_properties(self.physical, format) }
            .optimal_tiling_features
    }
}

/// `maxResourceSize` of every format that a device supports is at least this ("Required Limits").
const LEAST_RESOURCE_SIZE: u64 = 1 << 31;

/// The time that a closed device may still work before it counts as hung.
const CLOSING: Duration = Duration::from_secs(60);

impl Drop for Device {
    fn drop(&mut self) {
        if matches!(self.wait_idle(CLOSING), Err(Error::TimedOut { .. })) {
            self.abandon();
        }
        if self.hung.load(Ordering::Relaxed) {
            // Its work may never end: freeing anything could be a use after free, and waiting could take for ever.
            if let Ok(allocator) = self.allocator.get_mut() {
                std::mem::forget(allocator.take());
            }
            std::mem::forget(self.instance.clone());
            return;
        }
        // SAFETY: this is the last holder of the device, so no other thread can be in a call with it.
        unsafe {
            let _ = self.raw.device_wait_idle();
            let retired = self.retired.get_mut().unwrap_or_else(std::sync::PoisonError::into_inner);
            let retired = std::mem::take(retired);
            self.free(retired.all());
            if let Ok(allocator) = self.allocator.get_mut() {
                drop(allocator.take());
            }
            self.keep_pipelines();
            self.raw.destroy_pipeline_cache(self.pipelines.raw, None);
            self.queue.destroy(&self.raw);
            self.raw.destroy_device(None);
        }
    }
}

static ABANDONED: AtomicBool = AtomicBool::new(false);

/// Whether this process has abandoned a device ([`Device::abandon`]). Then it should leave without the drivers' own ends, which may wait for the
/// work that does not end: `_exit` rather than `exit`.
pub fn has_abandoned_device() -> bool {
    ABANDONED.load(Ordering::Relaxed)
}
