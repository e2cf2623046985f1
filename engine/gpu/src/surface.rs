//! A window that pictures are presented in.

use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use crate::command::{CommandBuffer, transition};
use crate::device::Device;
use crate::image::{Image, ImageInfo};
use crate::memory::Backing;
use crate::queue::{TimelineValue, WindowSemaphores};
use crate::result::{Error, Named, Result};

/// Formats a picture can be shown in, best first. With an sRGB format the picture, which is encoded already, takes a detour.
const FORMATS: [(vk::Format, bool); 4] = [
    (vk::Format::B8G8R8A8_UNORM, false),
    (vk::Format::R8G8B8A8_UNORM, false),
    (vk::Format::B8G8R8A8_SRGB, true),
    (vk::Format::R8G8B8A8_SRGB, true),
];

/// Acquires in flight: one more than frames, so that a semaphore is free when its turn comes.
const ACQUIRES: usize = 3;

/// What became of a picture that was to be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// It is on its way to the screen.
    Shown,
    /// The window changed meanwhile; the picture may not have been shown.
    OutOfDate,
}

/// The image of the window that the next picture goes to.
pub struct Acquired {
    index: u32,
    semaphores: WindowSemaphores,
}

/// A window's surface and its swapchain. Keeps the window alive.
pub struct Surface {
    device: Arc<Device>,
    raw: vk::SurfaceKHR,
    format: vk::SurfaceFormatKHR,
    encode: bool,
    mode: vk::PresentModeKHR,
    size: [u32; 2],
    chain: Option<Chain>,
    acquired: [vk::Semaphore; ACQUIRES],
    turn: usize,
    /// Holds the picture's bytes as sRGB texels, so that a blit to an sRGB window leaves them as they are.
    detour: Option<Arc<Image>>,
    _window: Arc<dyn Any + Send + Sync>,
}

struct Chain {
    raw: vk::SwapchainKHR,
    images: Vec<vk::Image>,
    rendered: Vec<vk::Semaphore>,
    extent: [u32; 2],
    stale: bool,
}

impl Surface {
    /// Makes the surface of a window. `size` is the window's area in pixels; `vsync` waits for the screen, else the newest picture is
    /// shown as soon as may be.
    pub fn new<W>(device: &Arc<Device>, window: Arc<W>, size: [u32; 2], vsync: bool) -> Result<Surface>
    where
        W: HasDisplayHandle + HasWindowHandle + Send + Sync + 'static,
    {
        let cannot = |reason: String| Error::CannotPresent { device: device.capabilities().name.clone(), reason };
        let functions = match &device.instance.surface {
            Some(functions) if device.capabilities().present => functions,
            _ => return Err(cannot("the driver has no VK_KHR_swapchain".to_owned())),
        };
        let display = window.display_handle().map_err(|error| cannot(error.to_string()))?.as_raw();
        let handle = window.window_handle().map_err(|error| cannot(error.to_string()))?.as_raw();
        // SAFETY: the handles are alive: the window is kept by the surface, which destroys the `VkSurfaceKHR` before it.
        let raw =
            unsafe { ash_window::create_surface(&device.instance.entry, &device.instance.raw, display, handle, None) }
                .named("vkCreateSurfaceKHR")?;
        let mut surface = Surface {
            device: device.clone(),
            raw,
            format: vk::SurfaceFormatKHR::default(),
            encode: false,
            mode: vk::PresentModeKHR::FIFO,
            size,
            chain: None,
            acquired: [vk::Semaphore::null(); ACQUIRES],
            turn: 0,
            detour: None,
            _window: window,
        };
        let physical = device.physical;
        // SAFETY: queries with live handles of one instance.
        let (supported, formats, modes) = unsafe {
            (
                functions
                    .get_physical_device_surface_support(physical, device.queue.family, raw)
                    .named("vkGetPhysicalDeviceSurfaceSupportKHR")?,
                functions
                    .get_physical_device_surface_formats(physical, raw)
                    .named("vkGetPhysicalDeviceSurfaceFormatsKHR")?,
                functions
                    .get_physical_device_surface_present_modes(physical, raw)
                    .named("vkGetPhysicalDeviceSurfacePresentModesKHR")?,
            )
        };
        if !supported {
            return Err(cannot("its queue cannot present there".to_owned()));
        }
        let (format, encode) = choose_format(&formats, |format| {
            device.format_features(format).contains(vk::FormatFeatureFlags::BLIT_DST)
        })?;
        (surface.format, surface.encode) = (format, encode);
        surface.mode = choose_mode(&modes, vsync);
        for semaphore in &mut surface.acquired {
            // SAFETY: plain data.
            *semaphore = unsafe { device.raw.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
                .named("vkCreateSemaphore")?;
        }
        surface.rebuild()?;
        Ok(surface)
    }

    /// The window has another area now, in pixels; zero when it is minimised.
    pub fn resize(&mut self, size: [u32; 2]) {
        if self.size != size {
            self.size = size;
            if let Some(chain) = &mut self.chain {
                chain.stale = true;
            }
        }
    }

    /// Area of the pictures shown, in pixels; `None` while the window has none.
    pub fn extent(&self) -> Option<[u32; 2]> {
        self.chain.as_ref().map(|chain| chain.extent)
    }

    /// Waits for an image of the window. `None` while the window has no area.
    pub fn acquire(&mut self) -> Result<Option<Acquired>> {
        // The window may change again and again while it is dragged; after a few tries the frame goes on without it.
        for _ in 0..4 {
            if self.chain.as_ref().is_none_or(|chain| chain.stale) {
                self.rebuild()?;
            }
            let (Some(chain), Some(functions)) = (&mut self.chain, &self.device.swapchain) else { return Ok(None) };
            let semaphore = self.acquired[self.turn % ACQUIRES];
            // SAFETY: the semaphore is unsignalled with no wait pending: the frame that used it last has finished.
            let next = unsafe { functions.acquire_next_image(chain.raw, u64::MAX, semaphore, vk::Fence::null()) };
            match next {
                Ok((index, suboptimal)) => {
                    self.turn += 1;
                    chain.stale = suboptimal;
                    let rendered = chain.rendered[index as usize];
                    return Ok(Some(Acquired {
                        index,
                        semaphores: WindowSemaphores { acquired: semaphore, rendered },
                    }));
                }
                Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => chain.stale = true,
                Err(result) => return self.device.watch(Err(result).named("vkAcquireNextImageKHR")),
            }
        }
        Ok(None)
    }

    /// Records the copy of a picture (RGBA, 8 bits, sRGB-encoded bytes, in `GENERAL`, last touched by a transfer or made visible to
    /// one) to the acquired image, scaled to the window.
    pub fn draw(&mut self, commands: &mut CommandBuffer, acquired: &Acquired, picture: &Arc<Image>) -> Result<()> {
        let source = if self.encode { self.detour(commands, picture)? } else { picture.clone() };
        let Some(chain) = &self.chain else { return Ok(()) };
        let image = chain.images[acquired.index as usize];
        let transfer = vk::PipelineStageFlags2::ALL_TRANSFER;
        let ready = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        commands.image_barrier(
            transition(image, vk::ImageLayout::UNDEFINED, ready)
                .src_stage_mask(transfer)
                .dst_stage_mask(transfer)
                .dst_access_mask(vk::AccessFlags2::TRANSFER_WRITE),
        );
        commands.blit(&source, image, ready, chain.extent);
        commands.image_barrier(
            transition(image, ready, vk::ImageLayout::PRESENT_SRC_KHR)
                .src_stage_mask(transfer)
                .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE),
        );
        Ok(())
    }

    /// Submits the commands that drew to the acquired image and presents it.
    pub fn present(&mut self, commands: &mut CommandBuffer, acquired: &Acquired) -> Result<(TimelineValue, Presented)> {
        commands.end()?;
        let value = self.device.submit_for_window(commands, Some(&acquired.semaphores));
        commands.close();
        let value = value?;
        let (Some(chain), Some(functions)) = (&mut self.chain, &self.device.swapchain) else {
            return Ok((value, Presented::OutOfDate));
        };
        let (waits, chains, indices) = ([acquired.semaphores.rendered], [chain.raw], [acquired.index]);
        let info = vk::PresentInfoKHR::default().wait_semaphores(&waits).swapchains(&chains).image_indices(&indices);
        let queue = self.device.queue.lock();
        // SAFETY: the image was acquired and its commands are submitted; the queue is locked.
        match unsafe { functions.queue_present(*queue, &info) } {
            Ok(suboptimal) => {
                chain.stale |= suboptimal;
                Ok((value, Presented::Shown))
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                chain.stale = true;
                Ok((value, Presented::OutOfDate))
            }
            Err(result) => self.device.watch(Err(result).named("vkQueuePresentKHR")),
        }
    }

    fn detour(&mut self, commands: &mut CommandBuffer, picture: &Arc<Image>) -> Result<Arc<Image>> {
        let transfer = vk::PipelineStageFlags2::ALL_TRANSFER;
        let wanted = ImageInfo {
            format: vk::Format::R8G8B8A8_SRGB,
            usage: vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST,
            ..*picture.info()
        };
        let image = match &self.detour {
            Some(image) if *image.info() == wanted => image.clone(),
            _ => Arc::new(Image::new(&self.device, "picture, sRGB", &wanted, Backing::Own)?),
        };
        self.detour = Some(image.clone());
        commands.image_barrier(
            transition(image.raw, vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL)
                .src_stage_mask(transfer)
                .dst_stage_mask(transfer)
                .dst_access_mask(vk::AccessFlags2::TRANSFER_WRITE),
        );
        commands.copy_image(picture, &image);
        commands.image_barrier(
            transition(image.raw, vk::ImageLayout::GENERAL, vk::ImageLayout::GENERAL)
                .src_stage_mask(transfer)
                .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
                .dst_stage_mask(transfer)
                .dst_access_mask(vk::AccessFlags2::TRANSFER_READ),
        );
        Ok(image)
    }

    /// Makes the swapchain anew for the window's area.
    fn rebuild(&mut self) -> Result<()> {
        let (Some(surface), Some(functions)) = (&self.device.instance.surface, &self.device.swapchain) else {
            return Ok(());
        };
        // SAFETY: a query with live handles.
        let can = unsafe { surface.get_physical_device_surface_capabilities(self.device.physical, self.raw) }
            .named("vkGetPhysicalDeviceSurfaceCapabilitiesKHR")?;
        let extent = match can.current_extent {
            vk::Extent2D { width: u32::MAX, .. } => vk::Extent2D {
                width: self.size[0].min(can.max_image_extent.width),
                height: self.size[1].min(can.max_image_extent.height),
            },
            extent => extent,
        };
        let old = self.chain.take();
        if extent.width == 0 || extent.height == 0 || self.size.contains(&0) {
            return self.destroy(old);
        }
        if !can.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_DST) {
            self.destroy(old)?;
            return Err(Error::CannotPresent {
                device: self.device.capabilities().name.clone(),
                reason: "its images cannot be copied to".to_owned(),
            });
        }
        let alpha = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT]
            .into_iter()
            .find(|alpha| can.supported_composite_alpha.contains(*alpha))
            .unwrap_or(can.supported_composite_alpha);
        let most = if can.max_image_count == 0 { u32::MAX } else { can.max_image_count };
        let create = vk::SwapchainCreateInfoKHR::default()
            .surface(self.raw)
            .min_image_count((can.min_image_count + 1).min(most))
            .image_format(self.format.format)
            .image_color_space(self.format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::TRANSFER_DST)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(can.current_transform)
            .composite_alpha(alpha)
            .present_mode(self.mode)
            .clipped(true)
            .old_swapchain(old.as_ref().map_or(vk::SwapchainKHR::null(), |old| old.raw));
        // SAFETY: the surface is alive; the old chain is retired by the call and destroyed below.
        let made = unsafe { functions.create_swapchain(&create, None) }.named("vkCreateSwapchainKHR");
        self.destroy(old)?;
        let raw = made?;
        let mut chain = Chain {
            raw,
            images: Vec::new(),
            rendered: Vec::new(),
            extent: [extent.width, extent.height],
            stale: false,
        };
        // SAFETY: the chain was just made.
        let images = unsafe { functions.get_swapchain_images(raw) }.named("vkGetSwapchainImagesKHR");
        if let Ok(images) = &images {
            for image in images {
                chain.images.push(*image);
                // SAFETY: plain data.
                match unsafe { self.device.raw.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) } {
                    Ok(semaphore) => chain.rendered.push(semaphore),
                    Err(result) => {
                        self.destroy(Some(chain))?;
                        return Err(result).named("vkCreateSemaphore");
                    }
                }
            }
        }
        self.chain = Some(chain);
        images.map(drop)
    }

    fn destroy(&self, chain: Option<Chain>) -> Result<()> {
        let (Some(chain), Some(functions)) = (chain, &self.device.swapchain) else { return Ok(()) };
        if self.device.hung.load(Ordering::Relaxed) {
            return Err(Error::DeviceLost);
        }
        let queue = self.device.queue.lock();
        // SAFETY: the queue is idle, presents included, so nothing uses the chain or its semaphores.
        unsafe {
            // A lost device waits for nothing, and its objects may be destroyed.
            let _ = self.device.watch(self.device.raw.queue_wait_idle(*queue).named("vkQueueWaitIdle"));
            for semaphore in chain.rendered {
                self.device.raw.destroy_semaphore(semaphore, None);
            }
            functions.destroy_swapchain(chain.raw, None);
        }
        Ok(())
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        let chain = self.chain.take();
        if self.destroy(chain).is_err() || self.device.hung.load(Ordering::Relaxed) {
            // The device may still use it for ever; see `Device::drop`.
            return;
        }
        let queue = self.device.queue.lock();
        // SAFETY: the chain is gone; an acquire semaphore is waited for by a submission that has finished. The queue is locked.
        unsafe {
            let _ = self.device.raw.queue_wait_idle(*queue);
            for semaphore in self.acquired {
                self.device.raw.destroy_semaphore(semaphore, None);
            }
            if let Some(functions) = &self.device.instance.surface {
                functions.destroy_surface(self.raw, None);
            }
        }
    }
}

fn choose_format(
    offered: &[vk::SurfaceFormatKHR],
    can_blit: impl Fn(vk::Format) -> bool,
) -> Result<(vk::SurfaceFormatKHR, bool)> {
    FORMATS
        .iter()
        .filter(|(format, _)| can_blit(*format))
        .find_map(|(format, encode)| {
            let fits =
                |f: &&vk::SurfaceFormatKHR| f.format == *format && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR;
            offered.iter().find(fits).map(|format| (*format, *encode))
        })
        .ok_or_else(|| Error::SurfaceFormat { offered: offered.iter().map(|f| f.format).collect() })
}

fn choose_mode(offered: &[vk::PresentModeKHR], vsync: bool) -> vk::PresentModeKHR {
    // FIFO is always there.
    let wanted: &[_] = if vsync { &[] } else { &[vk::PresentModeKHR::MAILBOX, vk::PresentModeKHR::IMMEDIATE] };
    wanted.iter().copied().find(|mode| offered.contains(mode)).unwrap_or(vk::PresentModeKHR::FIFO)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(formats: &[vk::Format]) -> Vec<vk::SurfaceFormatKHR> {
        formats
            .iter()
            .map(|format| vk::SurfaceFormatKHR { format: *format, color_space: vk::ColorSpaceKHR::SRGB_NONLINEAR })
            .collect()
    }

    #[test]
    fn a_format_that_leaves_the_bytes_alone_comes_first() {
        let offered = offer(&[vk::Format::B8G8R8A8_SRGB, vk::Format::R8G8B8A8_UNORM]);
        let (format, encode) = choose_format(&offered, |_| true).expect("one of them suits");
        assert_eq!((format.format, encode), (vk::Format::R8G8B8A8_UNORM, false));
        let (format, encode) = choose_format(&offered[..1], |_| true).expect("it suits");
        assert_eq!((format.format, encode), (vk::Format::B8G8R8A8_SRGB, true));
    }

    #[test]
    fn no_format_is_an_error_that_lists_what_there_is() {
        let offered = offer(&[vk::Format::A2B10G10R10_UNORM_PACK32]);
        let error = choose_format(&offered, |_| true).expect_err("none suits").to_string();
        assert!(error.contains("A2B10G10R10_UNORM_PACK32"), "{error}");
    }

    #[test]
    fn vsync_is_fifo_and_without_it_the_newest_picture_wins() {
        let all = [vk::PresentModeKHR::FIFO, vk::PresentModeKHR::IMMEDIATE, vk::PresentModeKHR::MAILBOX];
        assert_eq!(choose_mode(&all, true), vk::PresentModeKHR::FIFO);
        assert_eq!(choose_mode(&all, false), vk::PresentModeKHR::MAILBOX);
        assert_eq!(choose_mode(&all[..1], false), vk::PresentModeKHR::FIFO);
    }
}
