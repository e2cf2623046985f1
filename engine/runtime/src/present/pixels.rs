//! A picture whose pixels come from the host, on the device that shows it.

use std::sync::Arc;

use raxel_execute::Picture;
use raxel_gpu::{Backing, Barrier, Buffer, BufferInfo, Device, Image, ImageInfo, Location, Recording, vk};

use super::error::PresentError;

/// The picture that was taken last.
#[derive(Default)]
pub(super) struct Pixels {
    image: Option<Arc<Image>>,
    /// Pixels that are not in the image yet, and whether the image is new.
    waiting: Option<(Buffer, bool)>,
}

impl Pixels {
    /// Takes the pixels of a picture. The next recording copies them.
    pub(crate) fn take(&mut self, device: &Arc<Device>, picture: &Picture) -> Result<(), PresentError> {
        let wanted = ImageInfo {
            format: vk::Format::R8G8B8A8_UNORM,
            volume: false,
            extent: [picture.width, picture.height, 1],
            mips: 1,
            layers: 1,
            usage: vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST,
        };
        // An image whose first pixels still wait has no contents.
        let mut new = self.waiting.as_ref().is_some_and(|(_, new)| *new);
        if self.image.as_ref().is_none_or(|image| *image.info() != wanted) {
            self.image = Some(Arc::new(Image::new(device, "picture of the host", &wanted, Backing::Own)?));
            new = true;
        }
        let size = picture.rgba.len() as u64;
        let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_SRC, location: Location::Upload };
        let staging = Buffer::new(device, "pixels of the host", &info, Backing::Own)?;
        staging.write(0, &picture.rgba)?;
        self.waiting = Some((staging, new));
        Ok(())
    }

    /// The image with the pixels that were taken last, in `GENERAL`, to be read by transfers; `None` before the first.
    pub(crate) fn image(&mut self, recording: &mut Recording<'_>) -> Option<&Arc<Image>> {
        let image = self.image.as_ref()?;
        if let Some((staging, new)) = self.waiting.take() {
            let stage = vk::PipelineStageFlags2::ALL_TRANSFER;
            let (none, read, write) = (
                (stage, vk::AccessFlags2::NONE),
                (stage, vk::AccessFlags2::TRANSFER_READ),
                (stage, vk::AccessFlags2::TRANSFER_WRITE),
            );
            let before = Barrier::default();
            recording.barrier(&if new { before.activate(image, none, write) } else { before.memory(none, write) });
            let [width, height, _] = image.info().extent;
            recording.copy_buffer_to_texels((&staging, 0), image, 0, [0; 3], [width, height, 1]);
            recording.barrier(&Barrier::default().memory(write, read));
        }
        Some(image)
    }
}
