//! Opens a logical device: its offer, the part of it that raxel enables, and raxel's own objects on it.

use std::ffi::{CStr, CString, c_void};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use ash::{amd, ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use raxel_cache::Cache;

use super::{Capabilities, Device};
use crate::candidates::{Seen, text};
use crate::choice::{Verdict, Version};
use crate::instance::Instance;
use crate::modules::{self, Enabled};
use crate::pipeline_cache::PipelineCache;
use crate::query::QueueClock;
use crate::queue::Queue;
use crate::result::{Error, Named, Result};
use crate::subgroups;

static NEXT_ID: AtomicU64 = AtomicU64::new(1);

/// Opens the device that was chosen.
pub(super) fn open(
    instance: Arc<Instance>,
    seen: &Seen,
    verdicts: Vec<Verdict>,
    cache: Option<Arc<Cache>>,
) -> Result<Arc<Device>> {
    let offered = Offered::of(&instance, seen);
    let chosen = Chosen::of(&offered, &instance, seen);
    let raw = create(&instance, seen, &chosen)?;
    let (allocator, pipelines, queue) = equip(&instance, &raw, seen, &offered.properties, cache)?;
    Ok(Arc::new(Device {
        swapchain: chosen.cannot_present.is_none().then(|| khr::swapchain::Device::new(&instance.raw, &raw)),
        debug: instance.labels.then(|| ext::debug_utils::Device::new(&instance.raw, &raw)),
        marker: chosen.marker.then(|| amd::buffer_marker::Device::new(&instance.raw, &raw)),
        allocator: Mutex::new(Some(allocator)),
        retired: Mutex::default(),
        pipelines,
        lost: AtomicBool::new(false),
        hung: AtomicBool::new(false),
        capabilities: capabilities(&offered, &chosen, seen, instance.validated),
        verdicts,
        id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
        raw,
        physical: seen.physical,
        queue,
        instance,
    }))
}

/// The offer of a device. The pointers from structure to structure lead nowhere any more.
struct Offered {
    properties: vk::PhysicalDeviceProperties,
    subgroup: vk::PhysicalDeviceSubgroupProperties<'static>,
    sizes: vk::PhysicalDeviceSubgroupSizeControlProperties<'static>,
    driver: vk::PhysicalDeviceDriverProperties<'static>,
    floats: vk::PhysicalDeviceFloatControlsProperties<'static>,
    can: vk::PhysicalDeviceFeatures,
    can12: vk::PhysicalDeviceVulkan12Features<'static>,
    can13: vk::PhysicalDeviceVulkan13Features<'static>,
    dynamic_rendering: vk::Bool32,
    family: vk::QueueFamilyProperties,
}

impl Offered {
    fn of(instance: &Instance, seen: &Seen) -> Self {
        let physical = seen.physical;
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut sizes = vk::PhysicalDeviceSubgroupSizeControlProperties::default();
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut floats = vk::PhysicalDeviceFloatControlsProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut subgroup)
            .push_next(&mut driver)
            .push_next(&mut floats);
        if seen.core13 {
            properties = properties.push_next(&mut sizes);
        }
        let (mut can12, mut can13) =
            (vk::PhysicalDeviceVulkan12Features::default(), vk::PhysicalDeviceVulkan13Features::default());
        let mut can_render = vk::PhysicalDeviceDynamicRenderingFeatures::default();
        let mut can = vk::PhysicalDeviceFeatures2::default().push_next(&mut can12);
        if seen.core13 {
            can = can.push_next(&mut can13);
        } else if seen.has(khr::dynamic_rendering::NAME) {
            can = can.push_next(&mut can_render);
        }
        // SAFETY: plain queries; the chains live until the calls return.
        let families = unsafe {
            instance.raw.get_physical_device_properties2(physical, &mut properties);
            instance.raw.get_physical_device_features2(physical, &mut can);
            instance.raw.get_physical_device_queue_family_properties(physical)
        };
        let (can, properties) = (can.features, properties.properties);
        let family = families[seen.family as usize];
        let dynamic_rendering = if seen.core13 { can13.dynamic_rendering } else { can_render.dynamic_rendering };
        Self { properties, subgroup, sizes, driver, floats, can, can12, can13, dynamic_rendering, family }
    }

    /// Operations of subgroups in compute shaders.
    fn subgroup_operations(&self) -> vk::SubgroupFeatureFlags {
        if self.subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE) {
            self.subgroup.supported_operations
        } else {
            vk::SubgroupFeatureFlags::empty()
        }
    }
}

/// The part of the offer that is enabled.
struct Chosen {
    features: vk::PhysicalDeviceFeatures,
    on12: vk::PhysicalDeviceVulkan12Features<'static>,
    on13: vk::PhysicalDeviceVulkan13Features<'static>,
    /// Dynamic rendering comes from the extension that became a part of Vulkan 1.3.
    renders_by_extension: bool,
    /// Why there is no `VK_KHR_swapchain`; `None` where there is.
    cannot_present: Option<&'static str>,
    /// `VK_AMD_buffer_marker`.
    marker: bool,
    /// `VK_EXT_shader_subgroup_ballot` and `VK_EXT_shader_subgroup_vote`.
    plain_ballots: bool,
}

impl Chosen {
    fn of(offered: &Offered, instance: &Instance, seen: &Seen) -> Self {
        let Offered { can, can12, can13, dynamic_rendering, family, .. } = offered;
        let draws = family.queue_flags.contains(vk::QueueFlags::GRAPHICS);
        Self {
            features: vk::PhysicalDeviceFeatures {
                shader_int64: can.shader_int64,
                shader_int16: can.shader_int16,
                shader_float64: can.shader_float64,
                robust_buffer_access: can.robust_buffer_access,
                shader_storage_image_read_without_format: can.shader_storage_image_read_without_format,
                shader_storage_image_write_without_format: can.shader_storage_image_write_without_format,
                shader_storage_image_extended_formats: can.shader_storage_image_extended_formats,
                shader_storage_image_array_dynamic_indexing: can.shader_storage_image_array_dynamic_indexing,
                shader_sampled_image_array_dynamic_indexing: can.shader_sampled_image_array_dynamic_indexing,
                shader_storage_buffer_array_dynamic_indexing: can.shader_storage_buffer_array_dynamic_indexing,
                ..Default::default()
            },
            on12: vk::PhysicalDeviceVulkan12Features {
                timeline_semaphore: vk::TRUE,
                scalar_block_layout: can12.scalar_block_layout,
                shader_int8: can12.shader_int8,
                shader_float16: can12.shader_float16,
                storage_buffer8_bit_access: can12.storage_buffer8_bit_access,
                shader_buffer_int64_atomics: can12.shader_buffer_int64_atomics,
                vulkan_memory_model: can12.vulkan_memory_model,
                vulkan_memory_model_device_scope: can12.vulkan_memory_model_device_scope,
                ..Default::default()
            },
            on13: vk::PhysicalDeviceVulkan13Features {
                synchronization2: vk::TRUE,
                maintenance4: vk::TRUE,
                robust_image_access: can13.robust_image_access,
                subgroup_size_control: can13.subgroup_size_control,
                compute_full_subgroups: can13.compute_full_subgroups,
                shader_integer_dot_product: can13.shader_integer_dot_product,
                dynamic_rendering: *dynamic_rendering,
                ..Default::default()
            },
            renders_by_extension: !seen.core13 && *dynamic_rendering == vk::TRUE,
            cannot_present: if instance.surface.is_none() {
                Some("the Vulkan loader has no VK_KHR_surface")
            } else if !seen.has(khr::swapchain::NAME) {
                Some("its driver has no VK_KHR_swapchain")
            } else if !draws {
                // A blit brings the picture to the window.
                Some("its queue computes and does not draw")
            } else {
                None
            },
            marker: seen.has(amd::buffer_marker::NAME),
            plain_ballots: seen.has(ext::shader_subgroup_ballot::NAME) && seen.has(ext::shader_subgroup_vote::NAME),
        }
    }
}

/// Makes the device with the chosen features.
fn create(instance: &Instance, seen: &Seen, chosen: &Chosen) -> Result<ash::Device> {
    let optional = [
        (!seen.core13, khr::synchronization2::NAME),
        (!seen.core13, khr::maintenance4::NAME),
        (chosen.renders_by_extension, khr::dynamic_rendering::NAME),
        (chosen.cannot_present.is_none(), khr::swapchain::NAME),
        (chosen.marker, amd::buffer_marker::NAME),
        (chosen.plain_ballots, ext::shader_subgroup_ballot::NAME),
        (chosen.plain_ballots, ext::shader_subgroup_vote::NAME),
        // The specification requires it on devices that have it (MoltenVK).
        (seen.has(khr::portability_subset::NAME), khr::portability_subset::NAME),
    ];
    let extensions: Vec<_> = optional.iter().filter(|(on, _)| *on).map(|(_, name)| name.as_ptr()).collect();
    let (mut on12, mut on13) = (chosen.on12, chosen.on13);
    // The same on a device of Vulkan 1.2, by the structures of the extensions that became a part of 1.3.
    let mut on_synchronization = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
    let mut on_maintenance = vk::PhysicalDeviceMaintenance4Features::default().maintenance4(true);
    let mut on_rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(seen.family).queue_priorities(&[1.0])];
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .enabled_features(&chosen.features)
        .push_next(&mut on12);
    if seen.core13 {
        info = info.push_next(&mut on13);
    } else {
        info = info.push_next(&mut on_synchronization).push_next(&mut on_maintenance);
        if chosen.renders_by_extension {
            info = info.push_next(&mut on_rendering);
        }
    }
    // SAFETY: everything asked for was offered, and `info` lives until the call returns.
    let mut raw = unsafe { instance.raw.create_device(seen.physical, &info, None) }.named("vkCreateDevice")?;
    if !seen.core13 {
        raw = with_functions_of_extensions(instance, &raw);
    }
    Ok(raw)
}

/// Makes the objects of every device: its memory, its pipeline cache, its queue. If one fails, all of it is destroyed, and so is the
/// device.
fn equip(
    instance: &Instance,
    raw: &ash::Device,
    seen: &Seen,
    properties: &vk::PhysicalDeviceProperties,
    cache: Option<Arc<Cache>>,
) -> Result<(Allocator, PipelineCache, Queue)> {
    let allocator = Allocator::new(&AllocatorCreateDesc {
        instance: instance.raw.clone(),
        device: raw.clone(),
        physical_device: seen.physical,
        debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
        buffer_device_address: false,
        allocation_sizes: gpu_allocator::AllocationSizes::default(),
    });
    let cache = PipelineCache::new(raw, properties, cache);
    let queue = Queue::new(raw, seen.family);
    match (allocator, cache, queue) {
        (Ok(allocator), Ok(cache), Ok(queue)) => Ok((allocator, cache, queue)),
        (allocator, cache, queue) => {
            drop(allocator);
            // SAFETY: only these objects were made on the device.
            unsafe {
                if let Ok(cache) = &cache {
                    raw.destroy_pipeline_cache(cache.raw, None);
                }
                if let Ok(queue) = &queue {
                    queue.destroy(raw);
                }
                raw.destroy_device(None);
            }
            cache?;
            queue?;
            Err(Error::OutOfMemory { name: "memory allocator".to_owned(), size: 0 })
        }
    }
}

fn capabilities(offered: &Offered, chosen: &Chosen, seen: &Seen, validated: bool) -> Capabilities {
    let Offered { properties, subgroup, sizes, driver, floats, family, .. } = offered;
    let Chosen { features, on12, on13, plain_ballots, .. } = chosen;
    let (operations, plain_ballots) = (offered.subgroup_operations(), *plain_ballots);
    let enabled = Enabled { core: features, on12, on13, operations, plain_ballots, floats };
    Capabilities {
        name: seen.candidate.name.clone(),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
        kind: seen.candidate.kind,
        version: Version::from_packed(properties.api_version),
        memory: seen.candidate.memory,
        limits: properties.limits,
        subgroup_size: subgroup.subgroup_size,
        subgroup_sizes: (on13.subgroup_size_control == vk::TRUE)
            .then(|| subgroups::sizes(sizes, &properties.limits))
            .flatten(),
        subgroup_operations: operations,
        shaders: modules::allowed(&enabled),
        int64: features.shader_int64 == vk::TRUE,
        robust_buffers: features.robust_buffer_access == vk::TRUE,
        robust_images: on13.robust_image_access == vk::TRUE,
        read_without_format: features.shader_storage_image_read_without_format == vk::TRUE,
        write_without_format: features.shader_storage_image_write_without_format == vk::TRUE,
        clock: (family.timestamp_valid_bits > 0)
            .then_some(QueueClock { period: properties.limits.timestamp_period, bits: family.timestamp_valid_bits }),
        cannot_present: chosen.cannot_present,
        plain_ballots,
        buffer_markers: chosen.marker,
        graphics: family.queue_flags.contains(vk::QueueFlags::GRAPHICS) && on13.dynamic_rendering == vk::TRUE,
        validated,
    }
}

/// The device with the functions of extensions in the place of those that became core in Vulkan 1.3: the same functions, and their names end in
/// `KHR` (Vulkan specification, "Promotion").
fn with_functions_of_extensions(instance: &Instance, device: &ash::Device) -> ash::Device {
    let find = |name: &CStr| {
        // SAFETY: the device is alive, and the name ends with a zero.
        unsafe { (instance.raw.fp_v1_0().get_device_proc_addr)(device.handle(), name.as_ptr()) }
    };
    let load = |name: &CStr| {
        let promoted = CString::new([name.to_bytes(), b"KHR"].concat()).ok().and_then(|name| find(&name));
        promoted.or_else(|| find(name)).map_or(std::ptr::null(), |function| function as *const c_void)
    };
    // SAFETY: each function is of this device, and has the type of its name.
    unsafe { ash::Device::load_with(load, device.handle()) }
}
