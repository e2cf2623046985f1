//! Shows pictures in a window.

use std::sync::Arc;
use std::time::Duration;

use raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use raxel_execute::{FramePicture, Picture};
use raxel_gpu::{
    Acquire, AcquiredImage, CommandBuffer, Device, Overlay, OverlayFrame, OverlayShaders, Place, Presented, Recording,
    Surface, TexturePatch,
};
use raxel_shader::{GraphicsStage, compile_graphics};

use super::error::PresentError;
use super::pixels::Pixels;

/// Pictures whose copies to the window are in flight at once.
const FRAMES: usize = 2;

/// The longest wait for an image of the window. When none comes, the next call tries again: the window stays responsive.
const ACQUIRE: Duration = Duration::from_millis(100);

/// Longest wait for the device: copies and triangles are short, and the session's watchdog has waited for the work before.
const PATIENCE: Duration = Duration::from_secs(60);

/// Shows pictures of a session in a window, with an overlay. A presenter belongs to one device: after a loss of the device, make a new one.
pub struct Presenter {
    device: Arc<Device>,
    surface: Surface,
    commands: [CommandBuffer; FRAMES],
    turn: usize,
    overlay: Option<Overlay>,
    pixels: Pixels,
}

impl Presenter {
    /// Makes a presenter for a window. `size` is the window's area in pixels. With `vsync`, pictures wait for the screen; without it, the
    /// newest picture is shown as soon as possible.
    pub fn new<W>(device: &Arc<Device>, window: Arc<W>, size: [u32; 2], vsync: bool) -> Result<Self, PresentError>
    where
        W: HasDisplayHandle + HasWindowHandle + Send + Sync + 'static,
    {
        Ok(Self {
            surface: Surface::new(device, window, size, vsync, PATIENCE)?,
            commands: [CommandBuffer::new(device, "even presents")?, CommandBuffer::new(device, "odd presents")?],
            turn: 0,
            overlay: None,
            pixels: Pixels::default(),
            device: device.clone(),
        })
    }

    /// The device that presents.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Sets the area of the window in pixels, zero if it is minimised.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.surface.resize(size);
    }

    /// Puts pictures into a part of the window from now on, or into all of it. The overlay always covers all of it.
    pub fn set_place(&mut self, place: Option<Place>) {
        self.surface.set_place(place);
    }

    /// Area of the window in pixels, `None` while it is zero.
    pub fn extent(&self) -> Option<[u32; 2]> {
        self.surface.extent()
    }

    /// Makes a texture for the overlay, or changes a rectangle of a texture.
    pub fn set_texture(&mut self, id: u64, patch: &TexturePatch<'_>) -> Result<(), PresentError> {
        Ok(self.overlay()?.set_texture(id, patch)?)
    }

    /// Frees a texture of the overlay.
    pub fn free_texture(&mut self, id: u64) {
        if let Some(overlay) = &mut self.overlay {
            overlay.free_texture(id);
        }
    }

    /// Shows a picture, scaled to the window, under an overlay. The call does not wait for the picture: the device does. A software driver
    /// waits in this call, without a limit. There, wait for the picture first ([`crate::Session::wait_picture`]), or present with another
    /// device ([`Self::take`]).
    pub fn present(
        &mut self,
        picture: &FramePicture,
        overlay: Option<&OverlayFrame<'_>>,
    ) -> Result<Presented, PresentError> {
        self.present_over(overlay, |acquired, recording, _| acquired.copy_picture(recording, &picture.image))
    }

    /// Takes a picture of another device. [`Self::present_taken`] shows it, any number of times.
    pub fn take(&mut self, picture: &Picture) -> Result<(), PresentError> {
        self.pixels.take(&self.device, picture)
    }

    /// Shows the picture that was taken last, as [`Self::present`] does. Before the first, shows one sRGB-encoded colour.
    pub fn present_taken(
        &mut self,
        color: [f32; 3],
        overlay: Option<&OverlayFrame<'_>>,
    ) -> Result<Presented, PresentError> {
        self.present_over(overlay, |acquired, recording, pixels| {
            if let Some(image) = pixels.image(recording) {
                return acquired.copy_picture(recording, image);
            }
            acquired.clear(recording, color);
            Ok(())
        })
    }

    /// Shows an overlay over one sRGB-encoded colour, for use before the first picture.
    pub fn present_blank(
        &mut self,
        color: [f32; 3],
        overlay: Option<&OverlayFrame<'_>>,
    ) -> Result<Presented, PresentError> {
        self.present_over(overlay, |acquired, recording, _| {
            acquired.clear(recording, color);
            Ok(())
        })
    }

    fn present_over(
        &mut self,
        overlay: Option<&OverlayFrame<'_>>,
        ground: impl FnOnce(&mut AcquiredImage<'_>, &mut Recording<'_>, &mut Pixels) -> raxel_gpu::Result<()>,
    ) -> Result<Presented, PresentError> {
        let frame = self.turn % FRAMES;
        self.device.wait(self.commands[frame].submitted(), PATIENCE)?;
        // Dropped objects are freed here: this is the only user of the device.
        self.device.collect();
        if overlay.is_some() {
            self.overlay()?;
        }
        let mut acquired = match self.surface.acquire(ACQUIRE)? {
            Acquire::Image(acquired) => acquired,
            Acquire::NoArea => return Ok(Presented::NoArea),
            Acquire::NotReady => return Ok(Presented::NotReady),
        };
        // From here on an error gives the image back to the surface, which gives it out again.
        let mut recording = self.commands[frame].begin()?;
        ground(&mut acquired, &mut recording, &mut self.pixels)?;
        if let (Some(content), Some(overlay)) = (overlay, &mut self.overlay) {
            overlay.draw_on(&mut recording, &mut acquired, frame, content)?;
        }
        let (_, presented) = acquired.present(recording)?;
        self.turn += 1;
        Ok(presented)
    }

    /// The overlay, made when it is first needed.
    fn overlay(&mut self) -> Result<&mut Overlay, PresentError> {
        let overlay = match self.overlay.take() {
            Some(overlay) => overlay,
            None => new_overlay(&self.device, self.surface.format())?,
        };
        Ok(self.overlay.insert(overlay))
    }
}

/// An overlay for targets of a format.
pub fn new_overlay(device: &Arc<Device>, format: raxel_gpu::vk::Format) -> Result<Overlay, PresentError> {
    let compile = |stage, name, text| compile_graphics(stage, name, text).map_err(PresentError::Shader);
    let vertex = compile(GraphicsStage::Vertex, "overlay.vert", include_str!("overlay.vert"))?;
    let fragment = compile(GraphicsStage::Fragment, "overlay.frag", include_str!("overlay.frag"))?;
    Ok(Overlay::new(device, &OverlayShaders { vertex: &vertex, fragment: &fragment }, format)?)
}
