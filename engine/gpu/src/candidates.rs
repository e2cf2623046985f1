//! Looks at the physical devices: the properties of each, and raxel's needs that it lacks.

use std::ffi::CStr;

use ash::{khr, vk};

use crate::choice::{Candidate, DeviceKind, Version};
use crate::instance::Instance;
use crate::result::{Named, Result};

/// A physical device with the facts for the choice and the opening.
pub(crate) struct Seen {
    pub(crate) physical: vk::PhysicalDevice,
    pub(crate) candidate: Candidate,
    pub(crate) family: u32,
    /// Vulkan 1.3 or newer. A device of 1.2 has the functions of 1.3 that raxel calls by the names of extensions.
    pub(crate) core13: bool,
    extensions: Vec<vk::ExtensionProperties>,
}

impl Seen {
    pub(crate) fn has(&self, name: &CStr) -> bool {
        self.extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name))
    }
}

/// Looks at every device that the loader lists.
pub(crate) fn look_at_all(instance: &Instance) -> Result<Vec<Seen>> {
    // SAFETY: the instance is alive.
    let devices = unsafe { instance.raw.enumerate_physical_devices() }.named("vkEnumeratePhysicalDevices")?;
    devices.into_iter().enumerate().map(|(index, physical)| look_at(instance, index, physical)).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "Vulkan counts queue families in 32 bits")]
fn look_at(instance: &Instance, index: usize, physical: vk::PhysicalDevice) -> Result<Seen> {
    let raw = &instance.raw;
    // SAFETY: `physical` comes from this instance; all of these are plain queries.
    let (properties, memory, families, extensions) = unsafe {
        (
            raw.get_physical_device_properties(physical),
            raw.get_physical_device_memory_properties(physical),
            raw.get_physical_device_queue_family_properties(physical),
            raw.enumerate_device_extension_properties(physical).named("vkEnumerateDeviceExtensionProperties")?,
        )
    };
    let version = Version::from_packed(properties.api_version);
    let mut missing = Vec::new();
    let at_least = |minor| version >= Version { major: 1, minor, patch: 0 };
    let core13 = at_least(3);
    if at_least(2) {
        let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut synchronization = vk::PhysicalDeviceSynchronization2Features::default();
        let mut maintenance = vk::PhysicalDeviceMaintenance4Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut v12);
        // Only a device that knows a structure may be asked with it.
        let has = |name| core13 || extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        if has(khr::synchronization2::NAME) {
            features = features.push_next(&mut synchronization);
        }
        if has(khr::maintenance4::NAME) {
            features = features.push_next(&mut maintenance);
        }
        // SAFETY: as above; the chain lives until the call returns.
        unsafe { raw.get_physical_device_features2(physical, &mut features) };
        for (there, name) in [
            (synchronization.synchronization2, "synchronization2"),
            (maintenance.maintenance4, "maintenance4"),
            (v12.timeline_semaphore, "timelineSemaphore"),
        ] {
            if there == vk::FALSE {
                missing.push(name);
            }
        }
    } else {
        missing.push("Vulkan 1.2");
    }
    // A family that can also draw is the one that window systems present from.
    let with = |flags: vk::QueueFlags| families.iter().position(|family| family.queue_flags.contains(flags));
    let family = with(vk::QueueFlags::COMPUTE | vk::QueueFlags::GRAPHICS).or_else(|| with(vk::QueueFlags::COMPUTE));
    if family.is_none() {
        missing.push("a queue with compute");
    }
    let memory = memory
        .memory_heaps_as_slice()
        .iter()
        .filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
        .map(|heap| heap.size)
        .sum();
    let candidate = Candidate {
        index,
        name: text(properties.device_name_as_c_str()),
        kind: match properties.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
            vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
            vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
            vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
            _ => DeviceKind::Other,
        },
        version,
        missing,
        memory,
    };
    Ok(Seen { physical, candidate, family: family.unwrap_or(0) as u32, core13, extensions })
}

pub(crate) fn text(name: std::result::Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
