//! A copy of the debug target, taken at the point of the frame where it is shown, because later passes may overwrite it.

use std::ops::Range;
use std::sync::Arc;

use raxel_gpu::{Barrier, Buffer, BufferInfo, Device, Image, Location, Readback, Recording, TimelineValue, vk};
use raxel_graph::plan::{Plan, ResourceDesc};
use raxel_shader::format::Format;

use super::error::ExecuteError;
use super::physical::Physical;
use super::readback::ReadTicket;
use super::report::Texels;

/// A copy of the shown resource, as it was at its point of the frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Captured {
    /// The shown layer or slice of the shown mip of a target.
    Texels(Arc<Texels>),
    /// A part of a buffer.
    Bytes {
        /// Offset of the first of the bytes.
        start: u64,
        /// Bytes of the whole buffer.
        total: u64,
        /// The bytes.
        bytes: Vec<u8>,
    },
}

/// What a frame shall copy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// The shown part of a target, or these bytes of a buffer.
    Shown(Range<u64>),
    /// This layer or slice of this mip of the shown target.
    Part { mip: u32, layer: u32 },
}

/// The copy that the frame in recording takes.
pub(super) struct Capture {
    staging: Arc<Buffer>,
    part: Part,
}

#[derive(Clone, Debug)]
enum Part {
    Texels { format: Format, mip: u32, layer: u32, width: u32, height: u32 },
    Bytes { range: Range<u64>, total: u64 },
}

impl Capture {
    /// Of the shown resource of a plan. `None` where there is nothing to copy. `spare` is memory of an earlier copy: it is used again if it has
    /// the size and nobody else has it.
    pub(super) fn of_shown(
        device: &Arc<Device>,
        plan: &Plan,
        physical: &Physical,
        wanted: &Wanted,
        spare: &mut Option<Arc<Buffer>>,
    ) -> Result<Option<Capture>, ExecuteError> {
        let shown = plan.present;
        let planned = plan.resources.iter().find(|planned| planned.resource == shown.resource);
        let image = match planned.map(|planned| &planned.desc) {
            Some(ResourceDesc::Image(desc) | ResourceDesc::SourceImage(_, desc)) => Some(desc),
            _ => None,
        };
        let (part, size) = if let Some(desc) = image {
            let (mip, layer) = match *wanted {
                Wanted::Shown(_) => (shown.mip, shown.layer),
                Wanted::Part { mip, layer } => (mip, layer),
            };
            let slices = if desc.volume { desc.extent[2].checked_shr(mip).unwrap_or(0).max(1) } else { desc.layers };
            if mip >= desc.mips || layer >= slices {
                return Ok(None);
            }
            let [width, height] = [desc.extent[0], desc.extent[1]].map(|texels| (texels >> mip).max(1));
            let size = u64::from(width) * u64::from(height) * u64::from(desc.format.bytes());
            (Part::Texels { format: desc.format, mip, layer, width, height }, size)
        } else {
            let total = physical.buffer(0).map_or(0, |buffer| buffer.size());
            let Wanted::Shown(bytes) = wanted else { return Ok(None) };
            let end = bytes.end.min(total) & !3;
            let start = bytes.start.min(end) & !3;
            (Part::Bytes { range: start..end, total }, end - start)
        };
        if size == 0 {
            return Ok(None);
        }
        let fits = spare.take_if(|spare| spare.size() == size && Arc::strong_count(spare) == 1);
        let staging = if let Some(spare) = fits {
            spare
        } else {
            let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_DST, location: Location::Download };
            Arc::new(Buffer::new(device, "copy of the shown target", &info, raxel_gpu::Backing::Own)?)
        };
        *spare = Some(staging.clone());
        Ok(Some(Capture { staging, part }))
    }

    /// Records the copy. Everything before is waited for, and everything after waits, the host too.
    pub(super) fn record(
        &self,
        recording: &mut Recording<'_>,
        image: Option<&Arc<Image>>,
        buffer: Option<&Arc<Buffer>>,
    ) {
        recording.barrier(&Barrier::full());
        match (&self.part, image, buffer) {
            (Part::Texels { mip, layer, .. }, Some(image), _) => {
                recording.copy_image_to_buffer(image, *mip, *layer, &self.staging);
            }
            (Part::Bytes { range, .. }, _, Some(buffer)) => {
                recording.copy_buffer((buffer, range.start), (&self.staging, 0), range.end - range.start);
            }
            _ => {}
        }
        recording.barrier(&Barrier::full_to_host());
    }

    /// The ticket of a copy that was submitted.
    pub(super) fn ticket(self, device: &Arc<Device>, submitted: TimelineValue) -> ReadTicket<Captured> {
        let Capture { staging, part } = self;
        ReadTicket::new(Readback::of(device, staging, submitted), move |bytes| match &part {
            Part::Texels { format, width, height, .. } => {
                Captured::Texels(Texels { format: *format, width: *width, height: *height, bytes }.into())
            }
            Part::Bytes { range, total } => Captured::Bytes { start: range.start, total: *total, bytes },
        })
    }
}
