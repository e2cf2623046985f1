//! Reads the picture, targets and buffers back, as the last frame left them.

use std::ops::Range;
use std::sync::atomic::Ordering;

use raxel_graph::checked::ResourceId;
use raxel_graph::plan::{ResourceDesc, ResourcePlan};

use super::error::ExecuteError;
use super::executor::Executor;
use super::physical::Physical;
use super::prepare::copy_of;
use super::report::{Picture, Texels};

impl Executor {
    /// The picture that the last frame showed. Waits for the device.
    pub fn read_presented(&mut self) -> Result<Picture, ExecuteError> {
        let running = self.running.as_ref().ok_or(ExecuteError::NoPlan)?;
        let picture = &running.display.picture;
        if !picture.initialized.load(Ordering::Relaxed) {
            return Err(ExecuteError::NoPlan);
        }
        let image = picture.image.clone();
        let rgba = self.download_image(&image, 4, 0, 0)?;
        let [width, height, _] = image.info().extent;
        Ok(Picture { width, height, rgba })
    }

    /// One layer, or slice of a 3-D target, of one mip of a target as it was `age` frames before the last. Waits for the device.
    pub fn read_target(
        &mut self,
        resource: ResourceId,
        age: u32,
        mip: u32,
        layer: u32,
    ) -> Result<Texels, ExecuteError> {
        let (planned, physical) = self.live(resource, age)?;
        let (ResourceDesc::Image(desc) | ResourceDesc::SourceImage(_, desc), Some(image)) =
            (&planned.desc, physical.image(copy_of(self.last_frame(), age, physical.count())))
        else {
            return Err(out_of_range(physical, "texels: it is a buffer".to_owned()));
        };
        if mip >= desc.mips {
            return Err(out_of_range(physical, format!("mip {mip}: it has {}", desc.mips)));
        }
        let slices = if desc.volume { (desc.extent[2] >> mip).max(1) } else { desc.layers };
        if layer >= slices {
            let what = if desc.volume { "slice" } else { "layer" };
            return Err(out_of_range(physical, format!("{what} {layer}: it has {slices}")));
        }
        let (format, image) = (desc.format, image.clone());
        let bytes = self.download_image(&image, format.bytes(), mip, layer)?;
        let [width, height, _] = image.mip_extent(mip);
        Ok(Texels { format, width, height, bytes })
    }

    /// Bytes of a buffer as it was `age` frames before the last. Waits for the device.
    pub fn read_buffer(&mut self, resource: ResourceId, age: u32, bytes: Range<u64>) -> Result<Vec<u8>, ExecuteError> {
        let (planned, physical) = self.live(resource, age)?;
        let Some(buffer) = physical.buffer(copy_of(self.last_frame(), age, physical.count())) else {
            return Err(out_of_range(physical, "bytes: it is a target".to_owned()));
        };
        let size = match &planned.desc {
            ResourceDesc::Buffer(desc) => desc.size,
            _ => buffer.size(),
        };
        if bytes.start > bytes.end || bytes.end > size {
            return Err(out_of_range(physical, format!("bytes {}..{}: it has {size}", bytes.start, bytes.end)));
        }
        let buffer = buffer.clone();
        // Copies of buffers need whole words on some devices.
        let (start, end) = (bytes.start & !3, bytes.end.next_multiple_of(4).min(buffer.size()));
        let device = &self.shared.device;
        let words = raxel_gpu::download_buffer(device, &buffer, start, end - start, self.shared.watchdog());
        let words = words.map_err(|error| self.attribute_loss(self.shared.error(error)))?;
        Ok(words[(bytes.start - start) as usize..(bytes.end - start) as usize].to_vec())
    }

    /// The number of the last frame, which rotates histories.
    fn last_frame(&self) -> u64 {
        self.frame.saturating_sub(1)
    }

    fn live(&self, resource: ResourceId, age: u32) -> Result<(&ResourcePlan, &Physical), ExecuteError> {
        let running = self.running.as_ref().ok_or(ExecuteError::NoPlan)?;
        let plan = running.plan();
        let name = || match plan.graph.resources.get(resource.0 as usize) {
            Some(resource) => resource.name.clone(),
            None => format!("resource {}", resource.0),
        };
        let index = plan.resources.iter().position(|r| r.resource == resource);
        let index = index.ok_or_else(|| ExecuteError::NotLive { resource: name() })?;
        let physical = &running.resources[index];
        if physical.is_placed() {
            return Err(ExecuteError::NotKept { resource: name() });
        }
        if physical.needs_init() {
            return Err(ExecuteError::NoPlan);
        }
        if age >= physical.count() {
            return Err(out_of_range(physical, format!("`@{age}`: its history is {}", physical.count() - 1)));
        }
        Ok((&plan.resources[index], physical))
    }

    fn download_image(
        &self,
        image: &raxel_gpu::Image,
        texel_bytes: u32,
        mip: u32,
        layer: u32,
    ) -> Result<Vec<u8>, ExecuteError> {
        let device = &self.shared.device;
        raxel_gpu::download_image(device, image, texel_bytes, mip, layer, self.shared.watchdog())
            .map_err(|error| self.attribute_loss(self.shared.error(error)))
    }
}

fn out_of_range(physical: &Physical, part: String) -> ExecuteError {
    ExecuteError::OutOfRange { resource: physical.name.clone(), part }
}
