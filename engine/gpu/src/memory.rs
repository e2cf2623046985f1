//! Device memory: an allocation of one's own, or a place in a block that several images and buffers share.

use std::sync::{Arc, PoisonError};

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use crate::device::Device;
use crate::result::{Error, Result};
use crate::retire::Dead;

/// Where memory lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// Fast for the device, unseen by the host.
    Device,
    /// Written by the host while no submitted work uses it, read by the device ([`crate::Buffer::write`]).
    Upload,
    /// Stored word by word by the host, also while the device reads it ([`crate::SharedWords`]).
    Shared,
    /// Written by the device, read by the host.
    Download,
}

/// A piece of device memory.
pub(crate) struct Memory {
    device: Arc<Device>,
    /// `None` only while it is dropped.
    allocation: Option<Allocation>,
}

impl Memory {
    /// `linear`: buffers; else optimal-tiling images, or both mixed.
    pub(crate) fn new(
        device: &Arc<Device>,
        name: &str,
        requirements: vk::MemoryRequirements,
        location: Location,
        linear: bool,
    ) -> Result<Memory> {
        let desc = AllocationCreateDesc {
            name,
            requirements,
            location: match location {
                Location::Device => MemoryLocation::GpuOnly,
                Location::Upload | Location::Shared => MemoryLocation::CpuToGpu,
                Location::Download => MemoryLocation::GpuToCpu,
            },
            linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let mut allocator = device.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        let allocation = allocator
            .as_mut()
            .and_then(|allocator| allocator.allocate(&desc).ok())
            .ok_or_else(|| Error::OutOfMemory { name: name.to_owned(), size: requirements.size })?;
        Ok(Memory { device: device.clone(), allocation: Some(allocation) })
    }

    pub(crate) fn allocation(&self) -> &Allocation {
        self.allocation.as_ref().expect("only `drop` takes it")
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            self.device.retire(Dead::Memory(allocation));
        }
    }
}

/// A block of device-local memory that images and buffers are placed in at chosen offsets, over each other if need be.
pub struct MemoryBlock {
    pub(crate) memory: Memory,
    size: u64,
}

impl MemoryBlock {
    /// Allocates a block. `type_bits` are the memory types that suit every occupant.
    pub fn new(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        alignment: u64,
        type_bits: u32,
    ) -> Result<Arc<MemoryBlock>> {
        // Occupants may be linear and optimal: pages at both ends are the block's own.
        let page = device.capabilities().limits.buffer_image_granularity.max(1);
        let requirements = vk::MemoryRequirements {
            size: size.next_multiple_of(page),
            alignment: alignment.max(page),
            memory_type_bits: type_bits,
        };
        let memory = Memory::new(device, name, requirements, Location::Device, false)?;
        Ok(Arc::new(MemoryBlock { memory, size }))
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        self.size
    }
}

/// Where the memory of an image or buffer comes from.
#[derive(Clone, Copy)]
pub enum Backing<'a> {
    /// Its own.
    Own,
    /// A place in a block: the block and the byte offset.
    Placed(&'a Arc<MemoryBlock>, u64),
}

/// The owner of the memory while the object lives.
pub(crate) enum Held {
    Own(Memory),
    Block(#[allow(dead_code, reason = "held for its lifetime")] Arc<MemoryBlock>),
}

impl Held {
    /// Finds memory for an object; returns the object to hold, the memory, and the offset to bind at.
    pub(crate) fn find(
        device: &Arc<Device>,
        name: &str,
        requirements: vk::MemoryRequirements,
        backing: Backing<'_>,
        location: Location,
        linear: bool,
    ) -> Result<(Held, vk::DeviceMemory, u64)> {
        match backing {
            Backing::Own => {
                let memory = Memory::new(device, name, requirements, location, linear)?;
                // SAFETY: the handle is used only while `memory` is held.
                let (raw, offset) = unsafe { (memory.allocation().memory(), memory.allocation().offset()) };
                Ok((Held::Own(memory), raw, offset))
            }
            Backing::Placed(block, at) => {
                let fits = at % requirements.alignment.max(1) == 0
                    && at.checked_add(requirements.size).is_some_and(|end| end <= block.size);
                if !fits {
                    return Err(Error::OutOfMemory { name: name.to_owned(), size: requirements.size });
                }
                let allocation = block.memory.allocation();
                // SAFETY: the handle is used only while the block is held.
                let (raw, offset) = unsafe { (allocation.memory(), allocation.offset()) };
                Ok((Held::Block(block.clone()), raw, offset + at))
            }
        }
    }
}
