//! The host and the device never touch a buffer at the same time, for any caller. These tests need a Vulkan driver and fail without one.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, CommandBuffer, ComputePipeline, DescriptorSlot, Descriptors, Device,
    DeviceOptions, Error, Image, ImageInfo, Location, PipelineInfo, Recording, Resource, SharedWords, UploadRing,
    Validation, download_buffer, upload, vk,
};

const PATIENCE: Duration = Duration::from_secs(120);

/// `void main() {}` in workgroups of one, as SPIR-V.
fn nothing() -> Vec<u32> {
    let instruction = |code: u32, operands: &[u32]| [&[(operands.len() as u32 + 1) << 16 | code], operands].concat();
    let [capability, memory_model, entry_point, execution_mode] = [17, 14, 15, 16];
    let [type_void, type_function, function, label, end_return, end_function] = [19, 33, 54, 248, 253, 56];
    let (compute, main, local_size) = (5, 0x6e69_616d, 17);
    [
        // Magic number, version 1.3, generator, bound of ids, schema.
        vec![0x0723_0203, 0x0001_0300, 0, 5, 0],
        instruction(capability, &[1]),
        instruction(memory_model, &[0, 1]),
        instruction(entry_point, &[compute, 3, main, 0]),
        instruction(execution_mode, &[3, local_size, 1, 1, 1]),
        instruction(type_void, &[1]),
        instruction(type_function, &[2, 1]),
        instruction(function, &[1, 3, 0, 2]),
        instruction(label, &[4]),
        instruction(end_return, &[]),
        instruction(end_function, &[]),
    ]
    .concat()
}

fn device() -> Arc<Device> {
    Device::new(&DeviceOptions { device: None, validation: Validation::Required })
        .expect("a driver and the validation layer")
}

fn silent(device: &Device) {
    let messages = device.log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

fn buffer(device: &Arc<Device>, size: u64, usage: vk::BufferUsageFlags, location: Location) -> Buffer {
    Buffer::new(device, "tested", &BufferInfo { size, usage, location }, Backing::Own).expect("it fits")
}

fn pipeline(device: &Arc<Device>) -> ComputePipeline {
    let slots = [DescriptorSlot { set: 0, binding: 0, ty: vk::DescriptorType::UNIFORM_BUFFER, count: 1 }];
    let info = PipelineInfo {
        spirv: &nothing(),
        entry: "main",
        slots: &slots,
        push_bytes: 0,
        specialization: &[],
        subgroup_size: None,
    };
    ComputePipeline::new(device, "nothing", &info).expect("it compiles")
}

/// Keeps the device busy for a while.
fn linger(recording: &mut Recording<'_>, large: &Buffer) {
    for round in 0..8 {
        recording.fill_buffer(large, 0, large.size(), round);
        recording.barrier(&Barrier::full());
    }
}

#[test]
fn a_buffer_that_submitted_work_uses_is_not_written() {
    let device = device();
    let (from, to, uniform) =
        (vk::BufferUsageFlags::TRANSFER_SRC, vk::BufferUsageFlags::TRANSFER_DST, vk::BufferUsageFlags::UNIFORM_BUFFER);
    let large = buffer(&device, 64 << 20, to, Location::Device);
    let (copied, bound) =
        (buffer(&device, 64, from, Location::Upload), Arc::new(buffer(&device, 64, uniform, Location::Upload)));
    let unused = buffer(&device, 64, from, Location::Upload);
    let pipeline = pipeline(&device);
    let resources = [vec![Resource::Buffer { buffer: bound.clone(), offset: 0, size: 64 }]];
    let sets = Descriptors::new(&device, "sets", &pipeline, &resources).expect("there is room");
    let mut commands = CommandBuffer::new(&device, "uses").expect("a pool");
    let mut refused = [0, 0];
    for _ in 0..10 {
        let mut recording = commands.begin().expect("it has ended");
        recording.copy_buffer((&copied, 0), (&large, 0), 64);
        recording.bind(&pipeline, &sets);
        recording.dispatch([1; 3]);
        recording.barrier(&Barrier::full());
        linger(&mut recording, &large);
        // Commands that are recorded and not submitted see this write.
        copied.write(0, &[1; 64]).expect("nothing is submitted");
        bound.write(0, &[1; 64]).expect("nothing is submitted");
        let value = recording.submit().expect("it runs");
        for (count, buffer) in refused.iter_mut().zip([&copied, &*bound]) {
            match buffer.write(0, &[2; 64]) {
                Ok(()) => assert!(device.has_reached(value).expect("it runs"), "it was still running"),
                Err(error) => {
                    assert!(matches!(&error, Error::InUse { name } if name == "tested"), "{error}");
                    *count += 1;
                }
            }
        }
        unused.write(0, &[2; 64]).expect("no work uses it");
        device.wait(value, PATIENCE).expect("it ends");
        copied.write(0, &[3; 64]).expect("the work has finished");
        bound.write(0, &[3; 64]).expect("the work has finished");
    }
    assert!(refused.iter().all(|refused| *refused > 0), "the device was always faster: {refused:?}");
    silent(&device);
}

/// Ends the other thread of a test, also when this one panics.
struct Ends<'t>(&'t AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A thread writes one buffer again and again, while another one submits copies of it: each copy has the bytes of one write.
#[test]
fn no_submission_sees_half_of_a_write() {
    const BYTES: usize = 1 << 20;
    let device = device();
    let from = buffer(&device, BYTES as u64, vk::BufferUsageFlags::TRANSFER_SRC, Location::Upload);
    let back = buffer(&device, BYTES as u64, vk::BufferUsageFlags::TRANSFER_DST, Location::Download);
    from.write(0, &vec![0; BYTES]).expect("nothing uses it");
    let done = AtomicBool::new(false);
    let (written, kinds) = std::thread::scope(|scope| {
        let writer = scope.spawn(|| {
            let mut written = 0_u64;
            while !done.load(Ordering::Relaxed) {
                match from.write(0, &vec![written as u8; BYTES]) {
                    Ok(()) => written += 1,
                    Err(Error::InUse { .. }) => std::thread::yield_now(),
                    Err(error) => panic!("{error}"),
                }
            }
            written
        });
        let ends = Ends(&done);
        let mut commands = CommandBuffer::new(&device, "copies").expect("a pool");
        let mut kinds = std::collections::BTreeSet::new();
        let mut bytes = vec![0; BYTES];
        for _ in 0..100 {
            let mut recording = commands.begin().expect("it has ended");
            recording.copy_buffer((&from, 0), (&back, 0), BYTES as u64);
            let (copy, host) = (vk::PipelineStageFlags2::COPY, vk::PipelineStageFlags2::HOST);
            let (write, read) = (vk::AccessFlags2::TRANSFER_WRITE, vk::AccessFlags2::HOST_READ);
            recording.barrier(&Barrier::default().memory((copy, write), (host, read)));
            let value = recording.submit().expect("it runs");
            device.wait(value, PATIENCE).expect("it ends");
            assert!(back.read(0, &mut bytes));
            assert!(bytes.iter().all(|byte| *byte == bytes[0]), "a copy has bytes of two writes");
            kinds.insert(bytes[0]);
        }
        drop(ends);
        (writer.join().expect("it ends"), kinds.len())
    });
    assert!(written > 1 && kinds > 1, "{written} writes, {kinds} of them seen");
    silent(&device);
}

#[test]
fn only_bytes_of_upload_buffers_are_written() {
    let device = device();
    let from = vk::BufferUsageFlags::TRANSFER_SRC;
    let upload_buffer = buffer(&device, 64, from, Location::Upload);
    let refused = |buffer: &Buffer, offset: u64, bytes: &[u8]| {
        let error = buffer.write(offset, bytes).expect_err("it is refused");
        assert!(matches!(error, Error::NotWritable { size: 64, .. }), "{error}");
    };
    refused(&upload_buffer, 60, &[0; 5]);
    refused(&upload_buffer, u64::MAX, &[0; 5]);
    upload_buffer.write(64, &[]).expect("nothing is written at the end");
    for location in [Location::Device, Location::Shared, Location::Download] {
        refused(&buffer(&device, 64, from, location), 0, &[0; 4]);
    }
    let target = Arc::new(upload(&device, "target", &[7; 64], PATIENCE).expect("it fits"));
    let ring = UploadRing::new(&device, &target, 1 << 10, PATIENCE).expect("it fits");
    for (offset, bytes) in [(60, 8), (u64::MAX - 3, 8), (2, 4), (0, 6)] {
        let error = ring.write(offset, &vec![0; bytes]).expect_err("it is refused");
        assert!(matches!(error, Error::NotWritable { size: 64, .. }), "{error}");
    }
    ring.flush().expect("there is nothing to do");
    assert_eq!(download_buffer(&device, &target, 0, 64, PATIENCE).expect("it is there"), [7; 64]);
    silent(&device);
}

#[test]
fn shared_words_are_stored_while_the_device_works() {
    let device = device();
    let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::STORAGE_BUFFER;
    let large = buffer(&device, 64 << 20, vk::BufferUsageFlags::TRANSFER_DST, Location::Device);
    let shared = Arc::new(buffer(&device, 64, usage, Location::Shared));
    let words = SharedWords::new(shared.clone()).expect("the host sees it");
    for location in [Location::Device, Location::Upload, Location::Download] {
        assert!(SharedWords::new(Arc::new(buffer(&device, 64, usage, location))).is_none(), "{location:?}");
    }
    words.store(0, &[1; 16]).expect("they fit");
    let mut commands = CommandBuffer::new(&device, "reads").expect("a pool");
    let mut recording = commands.begin().expect("nothing runs");
    // The first eight words alone are read.
    recording.copy_buffer((&shared, 0), (&large, 0), 32);
    recording.barrier(&Barrier::full());
    linger(&mut recording, &large);
    let value = recording.submit().expect("it runs");
    words.store(8, &[2, 3, 4, 5, 6, 7, 8, 9]).expect("they fit");
    device.wait(value, PATIENCE).expect("it ends");
    let bytes = download_buffer(&device, &shared, 0, 64, PATIENCE).expect("it is there");
    let found: Vec<u32> = bytes.chunks_exact(4).map(|word| u32::from_ne_bytes(word.try_into().unwrap())).collect();
    assert_eq!(found, [1, 1, 1, 1, 1, 1, 1, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
    for (at, count) in [(9, 8), (17, 0), (u64::MAX, 2)] {
        let error = words.store(at, &vec![0; count]).expect_err("it is refused");
        assert!(matches!(error, Error::NotWritable { size: 64, .. }), "{error}");
    }
    words.store(16, &[]).expect("nothing is stored at the end");
    silent(&device);
}

#[test]
fn nothing_is_recorded_that_reaches_beyond_an_image_or_other_sets() {
    let device = device();
    let (source, target) = (vk::ImageUsageFlags::TRANSFER_SRC, vk::ImageUsageFlags::TRANSFER_DST);
    let image = |format, extent, volume, mips, layers| {
        let info = ImageInfo { format, volume, extent, mips, layers, usage: source | target };
        Image::new(&device, "image", &info, Backing::Own).expect("it fits")
    };
    let flat = image(vk::Format::R8G8B8A8_UNORM, [8, 4, 1], false, 2, 3);
    let volume = image(vk::Format::R8_UNORM, [4, 4, 4], true, 1, 1);
    let bytes = upload(&device, "bytes", &[7; 128], PATIENCE).expect("it fits");
    let small = upload(&device, "small", &[7; 64], PATIENCE).expect("it fits");
    let uniform = Arc::new(buffer(&device, 64, vk::BufferUsageFlags::UNIFORM_BUFFER, Location::Upload));
    let [one, other] = [pipeline(&device), pipeline(&device)];
    let sets = Descriptors::new(
        &device,
        "sets",
        &one,
        &[vec![Resource::Buffer { buffer: uniform.clone(), offset: 0, size: 64 }]],
    );
    let sets = sets.expect("there is room");
    let too_long = [vec![Resource::Buffer { buffer: uniform, offset: 32, size: 64 }]];
    assert!(catch_unwind(AssertUnwindSafe(|| Descriptors::new(&device, "sets", &one, &too_long))).is_err());

    let mut commands = CommandBuffer::new(&device, "beyond").expect("a pool");
    let mut recording = commands.begin().expect("nothing runs");
    let mut refused = |name: &str, record: &dyn Fn(&mut Recording<'_>)| {
        let outcome = catch_unwind(AssertUnwindSafe(|| record(&mut recording)));
        assert!(outcome.is_err(), "{name}");
    };
    refused("a layer into a smaller buffer", &|to| to.copy_image_to_buffer(&flat, 0, 0, &small));
    refused("a layer that is not there", &|to| to.copy_image_to_buffer(&flat, 0, 3, &bytes));
    refused("a mip that is not there", &|to| to.copy_image_to_buffer(&flat, 2, 0, &bytes));
    refused("a slice that is not there", &|to| to.copy_image_to_buffer(&volume, 0, 4, &bytes));
    refused("texels out of a smaller buffer", &|to| {
        to.copy_buffer_to_texels((&small, 0), &flat, 0, [0; 3], [8, 4, 1]);
    });
    refused("texels beyond the edge", &|to| to.copy_buffer_to_texels((&bytes, 0), &flat, 0, [1, 0, 0], [8, 1, 1]));
    refused("texels of no mip", &|to| to.copy_buffer_to_texels((&bytes, 0), &flat, 2, [0; 3], [1; 3]));
    refused("an image of other texels", &|to| to.copy_image(&flat, &volume));
    refused("a mark behind the end", &|to| to.mark(&bytes, 128, 1, false));
    refused("a mark beside a word", &|to| to.mark(&bytes, 2, 1, false));
    refused("sets of another pipeline", &|to| to.bind(&other, &sets));
    recording.submit().expect("what was refused was not recorded");
    device.wait_idle(PATIENCE).expect("it ends");
    silent(&device);
}
