//! Opening devices. These tests need a Vulkan driver and fail without one.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use raxel_gpu::{
    ComputePipeline, DescriptorSlot, Device, DeviceKind, DeviceOptions, Error, ImageInfo, Packets, PipelineInfo,
    Validation, download_buffer, download_image, upload, upload_image, vk,
};

const PATIENCE: std::time::Duration = std::time::Duration::from_secs(60);

fn options(device: Option<&str>) -> DeviceOptions {
    DeviceOptions { device: device.map(str::to_owned), validation: Validation::Required }
}

#[test]
fn the_choice_is_explained() {
    let device = Device::new(&options(None)).expect("a driver and the validation layer");
    let verdicts = device.verdicts();
    let chosen: Vec<_> = verdicts.iter().filter(|verdict| verdict.chosen).collect();
    assert_eq!(chosen.len(), 1);
    assert_eq!(chosen[0].candidate.name, device.capabilities().name);
    assert!(verdicts.iter().all(|verdict| !verdict.reason.is_empty()));
    // The same one by its index and by a part of its name.
    let index = chosen[0].candidate.index.to_string();
    let part = chosen[0].candidate.name[..4].to_uppercase();
    for wanted in [index, part] {
        let again = Device::new(&options(Some(&wanted))).expect("it was there a moment ago");
        assert_eq!(again.capabilities().name, device.capabilities().name);
        let reason = &again.verdicts().iter().find(|verdict| verdict.chosen).expect("one is").reason;
        assert!(reason.contains(&wanted), "{reason}");
    }
}

#[test]
fn another_device_is_of_the_same_hardware_and_has_its_own_log() {
    let device = Device::new(&options(None)).expect("a driver and the validation layer");
    let another = device.another().expect("there was room for one");
    let (mine, its) = (device.capabilities(), another.capabilities());
    assert_eq!((&mine.name, mine.validated), (&its.name, its.validated));
    assert_ne!(device.id(), another.id());
    assert!(!std::ptr::eq(device.log(), another.log()));
}

#[test]
fn only_what_packets_lack_is_said() {
    let device = Device::new(&options(None)).expect("a driver and the validation layer");
    let mut able = device.capabilities().clone();
    (able.subgroup_size, able.subgroup_sizes) = (32, None);
    (able.plain_ballots, able.int64) = (true, true);
    able.subgroup_operations = vk::SubgroupFeatureFlags::BASIC;
    assert_eq!(able.packets().to_string(), "in packets of 16 × 16, by subgroups of 32");
    assert!(able.traces_packets() && able.has_plain_ballots());
    able.int64 = false;
    assert_eq!(able.packets(), Packets::None(vec!["64-bit integers"], 32));
    able.subgroup_size = 8;
    let lacks = "one by one: packets need subgroups of 32 or 64, 64-bit integers, and this device has subgroups of 8";
    assert_eq!(able.packets().to_string(), lacks);
    assert!(!able.traces_packets() && !able.has_plain_ballots());
}

#[test]
fn packets_ask_for_subgroups_of_32_or_take_half_of_64() {
    let device = Device::new(&options(None)).expect("a driver and the validation layer");
    let mut able = device.capabilities().clone();
    (able.plain_ballots, able.int64) = (true, true);
    able.subgroup_operations = vk::SubgroupFeatureFlags::BASIC;
    for (own, sizes, packets, plain) in [
        // A device of one size, which can be asked for and need not be.
        (32, Some([32, 32]), "in packets of 16 × 16, by subgroups of 32", true),
        (64, Some([32, 64]), "in packets of 16 × 16, by subgroups of 32, out of sizes from 32 to 64", true),
        (32, Some([8, 32]), "in packets of 16 × 16, by subgroups of 32, out of sizes from 8 to 32", true),
        (64, Some([64, 64]), "in packets of 16 × 16, by half of each subgroup of 64", false),
        (64, None, "in packets of 16 × 16, by half of each subgroup of 64", false),
        (
            16,
            Some([8, 16]),
            "one by one: packets need subgroups of 32 or 64, and this device has subgroups of 16",
            true,
        ),
        (128, None, "one by one: packets need subgroups of 32 or 64, and this device has subgroups of 128", false),
    ] {
        (able.subgroup_size, able.subgroup_sizes) = (own, sizes);
        assert_eq!(able.packets().to_string(), packets, "{own}, {sizes:?}");
        assert_eq!(able.traces_packets(), packets.starts_with("in packets"), "{own}, {sizes:?}");
        assert_eq!(able.has_plain_ballots(), plain, "{own}, {sizes:?}");
    }
    able.subgroup_sizes = Some([32, 64]);
    let asks = [16, 32, 48, 64, 128].map(|size| able.asks_for_subgroups_of(size));
    assert_eq!(asks, [false, true, false, true, false]);
}

#[test]
fn a_device_that_is_not_there_is_an_error_that_lists_what_is() {
    let error = Device::new(&options(Some("Voodoo 5"))).expect_err("nobody has one");
    let Error::NoSuchDevice { wanted, candidates } = &error else { panic!("{error}") };
    assert_eq!(wanted, "Voodoo 5");
    assert!(!candidates.is_empty());
    assert!(error.to_string().contains(&candidates[0]), "{error}");
    assert!(error.to_string().ends_with("a part of a name in this list, or its number"), "{error}");
}

#[test]
fn no_driver_says_how_to_get_one() {
    let error = Error::NoDriver { candidates: Vec::new() }.to_string();
    assert!(error.contains("apt-get install") && error.contains("mesa-vulkan-drivers"), "{error}");
}

#[test]
fn bytes_go_there_and_come_back_and_dropped_buffers_are_freed() {
    let device = Device::new(&options(None)).expect("a driver and the validation layer");
    let bytes: Vec<u8> = (0..1021u32).map(|i| (i * 7) as u8).collect();
    for _ in 0..8 {
        let buffer = upload(&device, "bytes", &bytes, PATIENCE).expect("it fits");
        assert_eq!(buffer.size(), 1024, "padded to whole words");
        let back = download_buffer(&device, &buffer, 0, 1024, PATIENCE).expect("it was written");
        assert_eq!(back[..1021], bytes);
        assert_eq!(back[1021..], [0; 3]);
        drop(buffer);
        device.collect();
    }
    let limit = u64::from(device.capabilities().limits.max_storage_buffer_range);
    if limit < 1 << 31 {
        let large = vec![0; limit as usize + 4];
        let error = upload(&device, "large", &large, PATIENCE).expect_err("it cannot be bound");
        assert!(matches!(error, Error::TooLarge { .. }), "{error}");
    }
    if device.capabilities().kind == DeviceKind::Cpu {
        assert!(device.capabilities().subgroup_size >= 4);
    }
    assert_eq!(device.log().take(), []);
}

#[test]
fn volumes_are_uploaded_mip_by_mip_in_pieces() {
    let device = Device::new(&options(None)).expect("a driver and the validation layer");
    // More than one staging buffer, whose slices do not divide it; then mips of odd sizes.
    for (extent, mips) in [([1024, 513, 150], 1), ([7, 5, 3], 3)] {
        let usage =
            vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
        let info = ImageInfo { format: vk::Format::R8_UINT, volume: true, extent, mips, layers: 1, usage };
        let texels: Vec<Vec<u8>> = (0..mips)
            .map(|mip| {
                let count = extent.map(|axis| (axis >> mip).max(1) as usize).into_iter().product();
                (0..count).map(|i: usize| (i % 251) as u8 + mip as u8).collect()
            })
            .collect();
        let parts: Vec<&[u8]> = texels.iter().map(Vec::as_slice).collect();
        let image = upload_image(&device, "volume", &info, 1, &parts, PATIENCE).expect("it fits");
        for (mip, texels) in (0..mips).zip(&texels) {
            let [width, height, depth] = image.mip_extent(mip);
            let slice = (width * height) as usize;
            for z in [0, depth / 2, depth - 1] {
                let back = download_image(&device, &image, 1, mip, z, PATIENCE).expect("it was written");
                assert!(back == texels[z as usize * slice..][..slice], "mip {mip}, slice {z} of {extent:?}");
            }
        }
    }
    assert_eq!(device.log().take(), []);
}

/// The driver never sees them: the validation layer would report it.
#[test]
fn shaders_that_ask_for_more_than_the_device_has_are_refused() {
    let device = Device::new(&options(None)).expect("a driver and the validation layer");
    let make = |capability: u32, slots: &[DescriptorSlot]| {
        // Only the declarations: nothing beyond them is looked at before the refusal.
        let spirv = [0x0723_0203, 0x0001_0300, 0, 5, 0, 0x0002_0011, 1, 0x0002_0011, capability];
        let info = PipelineInfo {
            spirv: &spirv,
            entry: "main",
            slots,
            push_bytes: 0,
            specialization: &[],
            subgroup_size: None,
        };
        ComputePipeline::new(&device, "tested", &info).map(drop)
    };
    // Geometry shaders, and a number that no capability has.
    for (capability, name) in [(2, "Geometry"), (65_000, "65000")] {
        let found = make(capability, &[]).unwrap_err();
        assert!(matches!(&found, Error::CapabilityMissing { lacks, .. } if lacks == name), "{found}");
    }
    let limit = device.capabilities().limits.max_per_stage_descriptor_storage_buffers;
    if let Some(count) = limit.checked_add(1) {
        let slot = DescriptorSlot { set: 0, binding: 0, ty: vk::DescriptorType::STORAGE_BUFFER, count };
        let found = make(1, &[slot]).unwrap_err();
        assert!(matches!(found, Error::TooManyBindings { what: "storage buffers", .. }), "{found}");
    }
    let messages = device.log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}
