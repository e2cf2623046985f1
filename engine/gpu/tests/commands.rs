//! The promises of the types of this crate to every caller. These tests need a Vulkan driver and fail without one.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, CommandBuffer, Device, DeviceOptions, Error, Location, ReadbackRing,
    Recording, UploadRing, Validation, download_buffer, upload, vk,
};

const PATIENCE: Duration = Duration::from_secs(120);

fn device() -> Arc<Device> {
    Device::new(&DeviceOptions { device: None, validation: Validation::Required })
        .expect("a driver and the validation layer")
}

fn silent(device: &Device) {
    let messages = device.log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

fn large(device: &Arc<Device>) -> Buffer {
    let usage = vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
    let info = BufferInfo { size: 64 << 20, usage, location: Location::Device };
    Buffer::new(device, "large", &info, Backing::Own).expect("it fits")
}

#[test]
fn a_command_buffer_refuses_to_be_recorded_while_it_runs() {
    let device = device();
    let buffer = large(&device);
    let mut commands = CommandBuffer::new(&device, "busy").expect("a pool");
    let mut refused = 0;
    for round in 0..20 {
        if let Err(error) = commands.begin() {
            assert!(matches!(&error, Error::InFlight { name } if name == "busy"), "{error}");
            refused += 1;
        }
        device.wait(commands.submitted(), PATIENCE).expect("it ends");
        let mut recording = commands.begin().expect("it has ended");
        for _ in 0..8 {
            recording.fill_buffer(&buffer, 0, buffer.size(), round);
            recording.barrier(&Barrier::full());
        }
        recording.submit().expect("it runs");
    }
    assert!(refused > 0, "the device never worked while the next recording began");
    // Dropped while it may still run: it is destroyed when the device has passed it.
    drop(commands);
    device.wait_idle(PATIENCE).expect("it ends");
    device.collect();
    silent(&device);
}

#[test]
fn a_recording_that_is_given_up_runs_nothing() {
    let device = device();
    let buffer = upload(&device, "bytes", &[7; 64], PATIENCE).expect("it fits");
    let mut commands = CommandBuffer::new(&device, "given up").expect("a pool");
    let mut recording = commands.begin().expect("nothing runs");
    recording.fill_buffer(&buffer, 0, 64, 0);
    drop(recording);
    commands.begin().expect("nothing was submitted").submit().expect("it runs");
    let mut ring = ReadbackRing::new(&device);
    let bytes = ring.buffer(&buffer, 0, 64).and_then(|ticket| ticket.wait(PATIENCE)).expect("it is read");
    assert_eq!(bytes, [7; 64]);
    silent(&device);
}

#[test]
fn nothing_is_recorded_that_reaches_beyond_a_buffer() {
    let device = device();
    let buffer = upload(&device, "bytes", &[7; 64], PATIENCE).expect("it fits");
    let other = upload(&device, "other", &[7; 32], PATIENCE).expect("it fits");
    let mut commands = CommandBuffer::new(&device, "beyond").expect("a pool");
    let mut recording = commands.begin().expect("nothing runs");
    let mut refused = |name: &str, record: &dyn Fn(&mut Recording<'_>)| {
        let outcome = catch_unwind(AssertUnwindSafe(|| record(&mut recording)));
        assert!(outcome.is_err(), "{name}");
    };
    refused("a fill behind the end", &|to| to.fill_buffer(&buffer, 32, 36, 0));
    refused("a fill whose end overflows", &|to| to.fill_buffer(&buffer, u64::MAX - 3, 8, 0));
    refused("a fill of half a word", &|to| to.fill_buffer(&buffer, 0, 6, 0));
    refused("bytes for a larger buffer", &|to| to.update_buffer(&other, 0, &[0; 64]));
    refused("a copy out of a smaller buffer", &|to| to.copy_buffer((&other, 0), (&buffer, 0), 64));
    refused("a copy into a smaller buffer", &|to| to.copy_buffer((&buffer, 0), (&other, 16), 32));
    refused("a dispatch without a pipeline", &|to| to.dispatch([1; 3]));
    refused("an indirect one", &|to| to.dispatch_indirect(&buffer, 0));
    recording.submit().expect("what was refused was not recorded");
    device.wait_idle(PATIENCE).expect("it ends");
    silent(&device);
}

#[test]
fn tickets_give_what_was_there_when_they_were_asked_for() {
    let device = device();
    let buffer = upload(&device, "bytes", &1_u32.to_le_bytes(), PATIENCE).expect("it fits");
    let mut ring = ReadbackRing::new(&device);
    let mut commands = CommandBuffer::new(&device, "change").expect("a pool");
    let mut tickets = Vec::new();
    for value in 1..=8_u32 {
        device.wait(commands.submitted(), PATIENCE).expect("it ends");
        let mut recording = commands.begin().expect("it has ended");
        recording.fill_buffer(&buffer, 0, 4, value);
        recording.barrier(&Barrier::full());
        recording.submit().expect("it runs");
        tickets.push((value, ring.buffer(&buffer, 0, 4).expect("there is room for eight")));
    }
    assert!(matches!(ring.buffer(&buffer, 0, 4), Err(Error::ReadbacksInFlight { most: 8 })));
    for (value, ticket) in &tickets {
        assert_eq!(ticket.wait(PATIENCE).expect("it is read"), value.to_le_bytes());
        // Asked again, it says the same.
        assert_eq!(ticket.poll().expect("it is read"), Some(value.to_le_bytes().to_vec()));
    }
    // A ticket that is dropped makes room, also while the device still copies.
    tickets.clear();
    for _ in 0..20 {
        drop(ring.buffer(&buffer, 0, 4));
        device.wait_idle(PATIENCE).expect("it ends");
    }
    silent(&device);
}

#[test]
fn any_part_of_what_the_device_wrote_can_be_copied_out() {
    let device = device();
    let bytes: Vec<u8> = (0..64).collect();
    let buffer = upload(&device, "bytes", &bytes, PATIENCE).expect("it fits");
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let info = BufferInfo { size: 64, usage, location: Location::Download };
    let host = Buffer::new(&device, "host", &info, Backing::Own).expect("it fits");
    let mut commands = CommandBuffer::new(&device, "copy").expect("a pool");
    let mut recording = commands.begin().expect("nothing runs");
    recording.copy_buffer((&buffer, 0), (&host, 0), 64);
    let (copy, stage) = (vk::PipelineStageFlags2::COPY, vk::PipelineStageFlags2::HOST);
    let barrier =
        Barrier::default().memory((copy, vk::AccessFlags2::TRANSFER_WRITE), (stage, vk::AccessFlags2::HOST_READ));
    recording.barrier(&barrier);
    let value = recording.submit().expect("it runs");
    device.wait(value, PATIENCE).expect("it ends");
    for start in 0..24 {
        for length in 0..40 {
            let mut part = vec![0xff; length];
            assert!(host.read(start as u64, &mut part));
            assert_eq!(part, bytes[start..start + length]);
        }
    }
    assert!(!host.read(60, &mut [0; 5]) && !host.read(u64::MAX, &mut [0; 5]));
    // Memory that only the device sees cannot be read.
    assert!(!buffer.read(0, &mut [0; 4]));
    silent(&device);
}

/// A small ring in front of a large buffer, written from many threads at once: every part has room of its own, and is written again and
/// again, with and without a flush in between.
#[test]
fn what_goes_through_a_ring_arrives_in_order() {
    const PART: usize = 16 << 10;
    const PARTS: usize = 8;
    let device = device();
    let mut expected = vec![0xee; PART * PARTS];
    let target = Arc::new(upload(&device, "target", &expected, PATIENCE).expect("it fits"));
    let ring = UploadRing::new(&device, &target, 20_000, PATIENCE).expect("it fits");
    std::thread::scope(|scope| {
        for (number, part) in expected.chunks_mut(PART).enumerate() {
            let ring = &ring;
            scope.spawn(move || {
                let mut random = 1 + number as u64;
                let mut next = |range: usize| {
                    random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (random >> 33) as usize % range
                };
                for round in 0..60 {
                    let start = 4 * next(PART / 4);
                    let bytes = vec![round ^ number as u8; 4 * next((PART - start) / 4 + 1)];
                    ring.write((number * PART + start) as u64, &bytes).expect("the device goes on");
                    part[start..start + bytes.len()].copy_from_slice(&bytes);
                    if next(10) == 0 {
                        ring.flush().expect("the device goes on");
                    }
                }
            });
        }
    });
    ring.flush().expect("the device goes on");
    let waits = device.waits();
    ring.flush().expect("there is nothing to do");
    assert_eq!(device.waits(), waits, "a flush does not wait");
    let found = download_buffer(&device, &target, 0, target.size(), PATIENCE).expect("it is there");
    assert!(found == expected, "the bytes differ");
    drop(ring);
    device.wait_idle(PATIENCE).expect("it ends");
    device.collect();
    silent(&device);
}
