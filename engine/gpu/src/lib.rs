//! Vulkan for raxel, with the `unsafe` that takes: a device with one queue, memory, images, buffers, compute pipelines, command
//! buffers, timestamps, windows, triangles over a picture, and bytes to the device and back.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! Objects hold their device and their parts. An object that is dropped while the device may still use it is destroyed when the device's
//! timeline has passed it (`retire`), so a handle that the device sees is alive. The host writes a buffer only while no submitted work uses
//! it (`last_use`), or word by word ([`SharedWords`]). Commands check that the parts they name exist.
//!
//! The caller decides in which order the device accesses memory: [`Barrier`]s say which access comes after which. A wrong order gives wrong
//! bytes to shaders, and nothing worse. In tests, the validation layer checks it (synchronization validation). So the library `raxel` does
//! not re-export the types that record commands.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]
#![allow(unsafe_code, reason = "Vulkan is a C interface; each block says why it is sound")]

mod buffer;
mod candidates;
mod choice;
mod command;
mod descriptors;
mod device;
mod heap;
mod image;
mod instance;
pub mod known;
mod last_use;
mod log;
mod memory;
mod modules;
mod overlay;
mod pipeline;
mod pipeline_cache;
mod query;
mod queue;
mod readback;
mod renderdoc;
mod result;
mod retire;
mod ring;
mod shared_words;
mod stopwatch;
mod subgroups;
mod surface;
mod transfer;
#[cfg(target_os = "linux")]
mod xlib;

pub use ash::vk;

pub use buffer::{Buffer, BufferInfo};
pub use choice::{Candidate, DeviceKind, Verdict, Version, choose};
pub use command::{Barrier, ClearColor, CommandBuffer, Recording, Scope};
pub use descriptors::{Descriptors, Resource};
pub use device::{Capabilities, Device, DeviceOptions, has_abandoned_device};
pub use heap::trim_heaps;
pub use image::{Image, ImageInfo, ImageView, ViewInfo};
pub use instance::Validation;
pub use log::{Message, Severity, ValidationLog};
pub use memory::{Backing, Location, MemoryBlock};
pub use overlay::{Overlay, OverlayFrame, OverlayMesh, OverlayShaders, OverlayVertex, TexturePatch};
pub use pipeline::{ComputePipeline, DescriptorSlot, PipelineInfo, Sampler, Sampling};
pub use pipeline_cache::PipelineCounts;
pub use query::{QueueClock, Timestamps};
pub use queue::TimelineValue;
pub use readback::{Readback, ReadbackRing};
pub use renderdoc::RenderDoc;
pub use result::{Error, Result};
pub use ring::UploadRing;
pub use shared_words::SharedWords;
pub use stopwatch::Stopwatch;
pub use subgroups::Packets;
pub use surface::{Acquire, AcquiredImage, Place, Presented, Surface};
pub use transfer::{download_buffer, download_image, upload, upload_image};
#[cfg(target_os = "linux")]
pub use xlib::on_lost_x_server;
