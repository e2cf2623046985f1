//! The image of a window that the next picture goes to, from when it is acquired until it is presented.

use std::sync::Arc;

use ash::vk;

use super::{ChainImage, Presented, Surface};
use crate::command::{Barrier, Recording, transition};
use crate::image::{Image, ImageInfo};
use crate::memory::Backing;
use crate::queue::{TimelineValue, WindowSemaphores};
use crate::result::{Named, Result};

/// An image of the window, until it is presented. Dropped before, it goes back to its surface, which gives it out again.
pub struct AcquiredImage<'s> {
    surface: &'s mut Surface,
    picture: Picture,
}

fn opaque([r, g, b]: [f32; 3]) -> [f32; 4] {
    [r, g, b, 1.0]
}

/// How far the image has come.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Picture {
    /// Its contents are undefined.
    None,
    /// A transfer has written it; it is in `TRANSFER_DST_OPTIMAL`.
    Copied,
    /// It is in `COLOR_ATTACHMENT_OPTIMAL`, with the picture in it.
    Attached,
}

/// Makes an image of the window, whose content is no longer needed, the target of a transfer.
fn begin_transfer(recording: &mut Recording<'_>, image: vk::Image) {
    let transfer = vk::PipelineStageFlags2::ALL_TRANSFER;
    recording.image_barrier(
        transition(image, vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL)
            .src_stage_mask(transfer)
            .dst_stage_mask(transfer)
            .dst_access_mask(vk::AccessFlags2::TRANSFER_WRITE),
    );
}

impl<'s> AcquiredImage<'s> {
    /// The image that a surface holds. Its contents are undefined.
    pub(super) fn of(surface: &'s mut Surface) -> Self {
        Self { surface, picture: Picture::None }
    }

    /// Pixels.
    pub fn extent(&self) -> [u32; 2] {
        self.surface.extent().unwrap_or([1; 2])
    }

    /// Records the copy of a picture (RGBA, 8 bits, sRGB-encoded bytes, in `GENERAL`, last touched by a transfer or made visible to
    /// one), scaled to the window or its place in it: the nearest texel.
    pub fn copy_picture(&mut self, recording: &mut Recording<'_>, picture: &Arc<Image>) -> Result<()> {
        let source = if self.surface.encode { self.surface.encode(recording, picture)? } else { picture.clone() };
        let (Some(image), extent) = (self.chain_image().map(|image| image.raw), self.extent()) else { return Ok(()) };
        begin_transfer(recording, image);
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let mut corners = [[0; 2], extent];
        if let Some(place) = self.surface.place {
            recording.clear_raw(image, layout, opaque(place.ground));
            let written = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
            recording.barrier(&Barrier::default().memory(written, written));
            // The window may have become smaller since.
            let end = [0, 1].map(|axis| place.origin[axis].saturating_add(place.extent[axis]).min(extent[axis]));
            corners = [[0, 1].map(|axis| place.origin[axis].min(extent[axis].saturating_sub(1))), end];
        }
        let [from, to] = corners;
        if from[0] < to[0] && from[1] < to[1] {
            recording.blit(&source, image, layout, corners);
        }
        self.picture = Picture::Copied;
        Ok(())
    }

    /// Records a clear in the place of a picture: opaque, sRGB-encoded, each component from 0 to 1.
    pub fn clear(&mut self, recording: &mut Recording<'_>, color: [f32; 3]) {
        let Some(raw) = self.chain_image().map(|image| image.raw) else { return };
        begin_transfer(recording, raw);
        recording.clear_raw(raw, vk::ImageLayout::TRANSFER_DST_OPTIMAL, opaque(color));
        self.picture = Picture::Copied;
    }

    /// Makes the image, with the picture in it, ready to be drawn to; gives its view. `None` where nothing can be drawn.
    pub(crate) fn attach(&mut self, recording: &mut Recording<'_>) -> Option<vk::ImageView> {
        let (raw, view) = self.chain_image().map(|image| (image.raw, image.view))?;
        if view == vk::ImageView::null() || self.picture == Picture::None {
            return None;
        }
        if self.picture == Picture::Copied {
            recording.image_barrier(
                transition(raw, vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
                    .src_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
                    .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
                    .dst_stage_mask(vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT)
                    .dst_access_mask(
                        vk::AccessFlags2::COLOR_ATTACHMENT_READ | vk::AccessFlags2::COLOR_ATTACHMENT_WRITE,
                    ),
            );
            self.picture = Picture::Attached;
        }
        Some(view)
    }

    /// Submits the commands that drew to the image, and presents it. When the submission fails the image goes back to the surface.
    pub fn present(self, mut recording: Recording<'_>) -> Result<(TimelineValue, Presented)> {
        let surface = self.surface;
        let (Some((index, turn)), Some(chain)) = (surface.held, &mut surface.chain) else {
            return Ok((recording.submit()?, Presented::OutOfDate));
        };
        let image = &chain.images[index as usize];
        let (layout, stage, access) = match self.picture {
            Picture::None => {
                (vk::ImageLayout::UNDEFINED, vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::NONE)
            }
            Picture::Copied => (
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                vk::PipelineStageFlags2::ALL_TRANSFER,
                vk::AccessFlags2::TRANSFER_WRITE,
            ),
            Picture::Attached => (
                vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
                vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT,
                vk::AccessFlags2::COLOR_ATTACHMENT_WRITE,
            ),
        };
        recording.image_barrier(
            transition(image.raw, layout, vk::ImageLayout::PRESENT_SRC_KHR)
                .src_stage_mask(stage)
                .src_access_mask(access),
        );
        let semaphores = WindowSemaphores { acquired: surface.acquires[turn].raw, rendered: image.rendered };
        let value = recording.submit_with(Some(&semaphores))?;
        surface.acquires[turn].waited = value;
        surface.held = None;
        let Some(functions) = &surface.device.swapchain else { return Ok((value, Presented::OutOfDate)) };
        let (waits, chains, indices) = ([image.rendered], [chain.raw], [index]);
        let info = vk::PresentInfoKHR::default().wait_semaphores(&waits).swapchains(&chains).image_indices(&indices);
        let queue = surface.device.queue.lock();
        // SAFETY: the image was acquired and its commands are submitted; the queue is locked.
        match unsafe { functions.queue_present(*queue, &info) } {
            Ok(suboptimal) => {
                chain.stale |= suboptimal;
                Ok((value, Presented::Shown))
            }
            // The next acquire replaces a lost surface.
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR | vk::Result::ERROR_SURFACE_LOST_KHR) => {
                chain.stale = true;
                Ok((value, Presented::OutOfDate))
            }
            Err(result) => {
                // It is unknown whether the image went back: the chain is made again.
                chain.stale = true;
                surface.device.watch(Err(result).named("vkQueuePresentKHR"))
            }
        }
    }

    fn chain_image(&self) -> Option<&ChainImage> {
        let (index, _) = self.surface.held?;
        self.surface.chain.as_ref()?.images.get(index as usize)
    }
}

impl Surface {
    /// A copy of the picture with an sRGB format.
    fn encode(&mut self, recording: &mut Recording<'_>, picture: &Arc<Image>) -> Result<Arc<Image>> {
        let transfer = vk::PipelineStageFlags2::ALL_TRANSFER;
        let wanted = ImageInfo {
            format: vk::Format::R8G8B8A8_SRGB,
            usage: vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST,
            ..*picture.info()
        };
        let image = match &self.encoded {
            Some(image) if *image.info() == wanted => image.clone(),
            _ => Arc::new(Image::new(&self.device, "picture, sRGB", &wanted, Backing::Own)?),
        };
        self.encoded = Some(image.clone());
        recording.image_barrier(
            transition(image.raw, vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL)
                .src_stage_mask(transfer)
                .dst_stage_mask(transfer)
                .dst_access_mask(vk::AccessFlags2::TRANSFER_WRITE),
        );
        recording.copy_image(picture, &image);
        recording.image_barrier(
            transition(image.raw, vk::ImageLayout::GENERAL, vk::ImageLayout::GENERAL)
                .src_stage_mask(transfer)
                .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
                .dst_stage_mask(transfer)
                .dst_access_mask(vk::AccessFlags2::TRANSFER_READ),
        );
        Ok(image)
    }
}
