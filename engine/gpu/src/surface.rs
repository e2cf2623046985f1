//! A window that pictures are presented in: its surface and its swapchain.

mod acquired;

use std::sync::Arc;
use std::time::Duration;

use ash::vk;
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use crate::device::Device;
use crate::image::Image;
use crate::queue::TimelineValue;
use crate::result::{Error, Named, Result};

pub use acquired::AcquiredImage;

/// Formats a picture can be shown in, best first. With an sRGB format the picture, which is encoded already, is copied to an image of
/// that encoding first.
const FORMATS: [(vk::Format, bool); 4] = [
    (vk::Format::B8G8R8A8_UNORM, false),
    (vk::Format::R8G8B8A8_UNORM, false),
    (vk::Format::B8G8R8A8_SRGB, true),
    (vk::Format::R8G8B8A8_SRGB, true),
];

/// Acquires in flight: one more than frames, so that a semaphore is free when its turn comes.
const ACQUIRES: usize = 3;

/// The outcome of presenting a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// It is on its way to the screen.
    Shown,
    /// The window changed meanwhile; the picture may not have been shown.
    OutOfDate,
    /// The window has no area: it is minimised.
    NoArea,
    /// No image of the window was free in time.
    NotReady,
}

/// The image to draw to, if there is one.
pub enum Acquire<'s> {
    /// An image of the window.
    Image(AcquiredImage<'s>),
    /// The window has no area: it is minimised.
    NoArea,
    /// No image was free in time.
    NotReady,
}

/// A window, as the surface needs it.
trait WindowHandles: HasDisplayHandle + HasWindowHandle + Send + Sync {}

impl<W: HasDisplayHandle + HasWindowHandle + Send + Sync> WindowHandles for W {}

/// A window's surface and its swapchain. Keeps the window alive.
pub struct Surface {
    device: Arc<Device>,
    raw: vk::SurfaceKHR,
    format: vk::SurfaceFormatKHR,
    encode: bool,
    vsync: bool,
    mode: vk::PresentModeKHR,
    size: [u32; 2],
    chain: Option<Chain>,
    acquires: Vec<AcquireSemaphore>,
    turn: usize,
    /// Acquired and not presented: the image of the chain, and the semaphore that is signalled when it may be drawn to.
    held: Option<(u32, usize)>,
    /// Longest wait for the device when the swapchain is made again.
    patience: Duration,
    /// Holds the picture's bytes as sRGB texels, so that a blit to an sRGB window leaves them as they are.
    encoded: Option<Arc<Image>>,
    /// The part of the window that pictures fill, where that is not all of it.
    place: Option<Place>,
    window: Arc<dyn WindowHandles>,
}

/// A part of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its top left pixel.
    pub origin: [u32; 2],
    /// Pixels along each axis.
    pub extent: [u32; 2],
    /// The colour around it, sRGB-encoded, each component from 0 to 1.
    pub ground: [f32; 3],
}

struct AcquireSemaphore {
    raw: vk::Semaphore,
    /// The submission that waited for it last.
    waited: TimelineValue,
}

struct Chain {
    raw: vk::SwapchainKHR,
    images: Vec<ChainImage>,
    extent: [u32; 2],
    stale: bool,
}

struct ChainImage {
    raw: vk::Image,
    /// Null where the window's images cannot be drawn to.
    view: vk::ImageView,
    rendered: vk::Semaphore,
}

impl Surface {
    /// Makes the surface of a window. `size` is the window's area in pixels; `vsync` waits for the screen, else the newest picture is
    /// shown as soon as may be. `patience` is the longest that the surface waits for work of the device when the window changes.
    pub fn new<W>(
        device: &Arc<Device>,
        window: Arc<W>,
        size: [u32; 2],
        vsync: bool,
        patience: Duration,
    ) -> Result<Surface>
    where
        W: HasDisplayHandle + HasWindowHandle + Send + Sync + 'static,
    {
        let mut surface = Surface {
            device: device.clone(),
            raw: vk::SurfaceKHR::null(),
            format: vk::SurfaceFormatKHR::default(),
            encode: false,
            vsync,
            mode: vk::PresentModeKHR::FIFO,
            size,
            chain: None,
            acquires: Vec::new(),
            turn: 0,
            held: None,
            patience,
            encoded: None,
            place: None,
            window,
        };
        surface.connect()?;
        for _ in 0..ACQUIRES {
            let raw = semaphore(device)?;
            surface.acquires.push(AcquireSemaphore { raw, waited: TimelineValue::default() });
        }
        surface.rebuild()?;
        Ok(surface)
    }

    /// Pictures fill a part of the window from now on, or all of it.
    pub fn set_place(&mut self, place: Option<Place>) {
        self.place = place;
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

    /// Format of the window's images, which an [`crate::Overlay`] for this window must be made for.
    pub fn format(&self) -> vk::Format {
        self.format.format
    }

    /// Waits for an image of the window, at most `timeout` for each of a few tries: a dragged window changes again and again. A
    /// surface that the window system took away is created again.
    pub fn acquire(&mut self, timeout: Duration) -> Result<Acquire<'_>> {
        for _ in 0..4 {
            match self.try_acquire(timeout) {
                Ok(Some(true)) => return Ok(Acquire::Image(AcquiredImage::of(self))),
                Ok(Some(false)) => return Ok(if self.chain.is_none() { Acquire::NoArea } else { Acquire::NotReady }),
                Ok(None) => {}
                Err(Error::SurfaceLost) => self.reconnect()?,
                Err(error) => return Err(error),
            }
        }
        Ok(Acquire::NotReady)
    }

    /// Whether an image is held now; `None` when the swapchain was found to be out of date.
    fn try_acquire(&mut self, timeout: Duration) -> Result<Option<bool>> {
        if self.chain.as_ref().is_none_or(|chain| chain.stale) {
            self.rebuild()?;
        }
        let (Some(chain), Some(functions)) = (&mut self.chain, &self.device.swapchain) else { return Ok(Some(false)) };
        if self.held.is_some() {
            return Ok(Some(true));
        }
        let turn = self.turn % ACQUIRES;
        let semaphore = &self.acquires[turn];
        self.device.wait(semaphore.waited, self.patience)?;
        // The largest number means "for ever".
        let nanoseconds = u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX).min(u64::MAX - 1);
        // SAFETY: the semaphore is unsignalled with no wait pending: the submission that waited for it has finished.
        match unsafe { functions.acquire_next_image(chain.raw, nanoseconds, semaphore.raw, vk::Fence::null()) } {
            Ok((index, suboptimal)) => {
                self.turn += 1;
                self.held = Some((index, turn));
                // A suboptimal image can still be presented; the chain is made again after it.
                chain.stale = suboptimal;
                Ok(Some(true))
            }
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(Some(false)),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                chain.stale = true;
                Ok(None)
            }
            Err(result) => self.device.watch(Err(result).named("vkAcquireNextImageKHR")),
        }
    }

    /// Makes the `VkSurfaceKHR` of the window, and asks for its capabilities.
    fn connect(&mut self) -> Result<()> {
        let device = self.device.clone();
        let cannot = |reason: String| Error::CannotPresent { device: device.capabilities().name.clone(), reason };
        let functions = match &device.instance.surface {
            Some(functions) if device.swapchain.is_some() => functions,
            _ => return Err(cannot(device.capabilities().cannot_present.unwrap_or_default().to_owned())),
        };
        let display = self.window.display_handle().map_err(|error| cannot(error.to_string()))?.as_raw();
        let handle = self.window.window_handle().map_err(|error| cannot(error.to_string()))?.as_raw();
        // SAFETY: the handles are alive: the window is kept by the surface, which destroys the `VkSurfaceKHR` before it.
        self.raw =
            unsafe { ash_window::create_surface(&device.instance.entry, &device.instance.raw, display, handle, None) }
                .named("vkCreateSurfaceKHR")?;
        let (physical, raw) = (device.physical, self.raw);
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
        (self.format, self.encode) = choose_format(&formats, |format| {
            device.format_features(format).contains(vk::FormatFeatureFlags::BLIT_DST)
        })?;
        self.mode = choose_mode(&modes, self.vsync);
        Ok(())
    }

    /// Replaces a lost surface by one of the same window.
    fn reconnect(&mut self) -> Result<()> {
        let chain = self.chain.take();
        self.destroy(chain)?;
        if let Some(functions) = &self.device.instance.surface {
            // SAFETY: its swapchain is gone.
            unsafe { functions.destroy_surface(self.raw, None) };
        }
        self.raw = vk::SurfaceKHR::null();
        self.connect()
    }

    /// Makes a swapchain for the window's present area.
    fn rebuild(&mut self) -> Result<()> {
        let device = self.device.clone();
        let (Some(surface), Some(functions)) = (&device.instance.surface, &device.swapchain) else { return Ok(()) };
        if self.raw == vk::SurfaceKHR::null() {
            self.connect()?;
        }
        // SAFETY: a query with live handles.
        let can = unsafe { surface.get_physical_device_surface_capabilities(device.physical, self.raw) }
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
        let transfer = vk::ImageUsageFlags::TRANSFER_DST;
        if !can.supported_usage_flags.contains(transfer) {
            self.destroy(old)?;
            return Err(Error::CannotPresent {
                device: device.capabilities().name.clone(),
                reason: "its images cannot be copied to".to_owned(),
            });
        }
        let attachment = vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let draws = device.capabilities().graphics && can.supported_usage_flags.contains(attachment);
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
            .image_usage(if draws { transfer | attachment } else { transfer })
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
        let mut chain = Chain { raw, images: Vec::new(), extent: [extent.width, extent.height], stale: false };
        let filled = self.fill(&mut chain, draws);
        if let Err(error) = filled {
            self.destroy(Some(chain))?;
            return Err(error);
        }
        self.chain = Some(chain);
        Ok(())
    }

    fn fill(&self, chain: &mut Chain, draws: bool) -> Result<()> {
        let Some(functions) = &self.device.swapchain else { return Ok(()) };
        // SAFETY: the chain was just made.
        let images = unsafe { functions.get_swapchain_images(chain.raw) }.named("vkGetSwapchainImagesKHR")?;
        for raw in images {
            chain.images.push(ChainImage { raw, view: vk::ImageView::null(), rendered: semaphore(&self.device)? });
            let Some(image) = chain.images.last_mut().filter(|_| draws) else { continue };
            let create = vk::ImageViewCreateInfo::default()
                .image(raw)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(self.format.format)
                .subresource_range(crate::command::whole());
            // SAFETY: the image belongs to the chain, which is destroyed after its views.
            image.view = unsafe { self.device.raw.create_image_view(&create, None) }.named("vkCreateImageView")?;
        }
        Ok(())
    }

    /// Waits for the device, and destroys a chain that was taken out of the surface.
    fn destroy(&mut self, chain: Option<Chain>) -> Result<()> {
        let (Some(chain), Some(functions)) = (chain, &self.device.swapchain) else { return Ok(()) };
        // A lost device waits for nothing, and its objects may be destroyed; one that hangs keeps them for ever.
        match self.device.wait_idle(self.patience) {
            Ok(()) => {}
            Err(Error::DeviceLost) if !self.device.is_hung() => {}
            Err(error) => return Err(error),
        }
        let held = self.held.take().map(|(_, turn)| turn);
        let queue = self.device.queue.lock();
        // Only presents are left on the queue, and they wait for nothing that is not signalled.
        match self.device.wait_queue(*queue, self.patience) {
            Ok(()) | Err(Error::DeviceLost) => {}
            Err(error) => return Err(error),
        }
        // SAFETY: the device has finished all work, or is lost. Nothing uses the chain, its views or its semaphores any more.
        unsafe {
            for image in chain.images {
                self.device.raw.destroy_image_view(image.view, None);
                self.device.raw.destroy_semaphore(image.rendered, None);
            }
            functions.destroy_swapchain(chain.raw, None);
        }
        drop(queue);
        if let Some(turn) = held {
            // The semaphore of an image that was never drawn to is signalled, and nothing can wait for it any more.
            let new = semaphore(&self.device)?;
            let old = std::mem::replace(&mut self.acquires[turn].raw, new);
            // SAFETY: its chain is gone and no submission refers to it.
            unsafe { self.device.raw.destroy_semaphore(old, None) };
        }
        Ok(())
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        let chain = self.chain.take();
        if self.destroy(chain).is_err() || self.device.is_hung() {
            // The device may still use it for ever; see `Device::drop`.
            return;
        }
        // SAFETY: the chain is gone, and with it all work that waits for an acquire semaphore.
        unsafe {
            for semaphore in &self.acquires {
                self.device.raw.destroy_semaphore(semaphore.raw, None);
            }
            if let Some(functions) = &self.device.instance.surface {
                functions.destroy_surface(self.raw, None);
            }
        }
    }
}

fn semaphore(device: &Device) -> Result<vk::Semaphore> {
    // SAFETY: plain data.
    unsafe { device.raw.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }.named("vkCreateSemaphore")
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
