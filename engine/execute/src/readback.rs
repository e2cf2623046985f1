//! Reads back the picture, targets and buffers of the last frame: with tickets, without waiting, or at once.

use std::ops::Range;
use std::sync::atomic::Ordering;

use raxel_gpu::Readback;
use raxel_graph::checked::ResourceId;
use raxel_graph::plan::{Lifetime, ResourceDesc, ResourcePlan};

use super::error::ExecuteError;
use super::executor::Executor;
use super::physical::Physical;
use super::report::{Picture, Texels};
use super::rotations::copy_of;

/// A read-back on its way from the device. It has the contents at the time of the request. Later frames do not change it, and do not wait for it.
pub struct ReadTicket<T> {
    readback: Readback,
    assemble: Box<dyn Fn(Vec<u8>) -> T + Send>,
}

impl<T> ReadTicket<T> {
    pub(super) fn new(readback: Readback, assemble: impl Fn(Vec<u8>) -> T + Send + 'static) -> Self {
        Self { readback, assemble: Box::new(assemble) }
    }

    /// Returns the result if it has arrived, else `None`. Does not wait.
    ///
    /// # Errors
    /// [`ExecuteError::DeviceLost`] if the device was lost. Then the result never arrives.
    pub fn poll(&self) -> Result<Option<T>, ExecuteError> {
        Ok(self.readback.poll()?.map(&self.assemble))
    }

    /// Whether [`Self::poll`] has the result. It takes no time, while [`Self::poll`] copies the bytes, and may do so on another thread.
    ///
    /// # Errors
    /// As for [`Self::poll`].
    pub fn has_arrived(&self) -> Result<bool, ExecuteError> {
        Ok(self.readback.has_arrived()?)
    }
}

impl Executor {
    /// Requests the picture of the last frame.
    pub fn request_picture(&mut self) -> Result<ReadTicket<Picture>, ExecuteError> {
        let running = self.running.as_ref().ok_or(ExecuteError::NoPlan)?;
        let picture = &running.display.picture;
        if !picture.initialized.load(Ordering::Relaxed) {
            return Err(ExecuteError::NoPlan);
        }
        let image = picture.image.clone();
        let readback = self.readbacks.image(&image, 4, 0, 0);
        let [width, height, _] = image.info().extent;
        self.ticket(readback, move |rgba| Picture { width, height, rgba })
    }

    /// Requests one layer (or slice of a 3-D target) of one mip of a target, as it was `age` frames before the last.
    pub fn request_target(
        &mut self,
        resource: ResourceId,
        age: u32,
        mip: u32,
        layer: u32,
    ) -> Result<ReadTicket<Texels>, ExecuteError> {
        let (planned, physical) = self.live(resource, age)?;
        self.written_by_all(resource, mip, layer)?;
        let (ResourceDesc::Image(desc) | ResourceDesc::SourceImage(_, desc), Some(image)) =
            (&planned.desc, physical.image(copy_of(self.last_rotation(resource), age, physical.count())))
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
        let readback = self.readbacks.image(&image, format.bytes(), mip, layer);
        let [width, height, _] = image.mip_extent(mip);
        self.ticket(readback, move |bytes| Texels { format, width, height, bytes })
    }

    /// Requests bytes of a buffer, as it was `age` frames before the last.
    #[expect(clippy::cast_possible_truncation, reason = "the buffer is mapped, so that `usize` holds its size")]
    pub fn request_buffer(
        &mut self,
        resource: ResourceId,
        age: u32,
        bytes: Range<u64>,
    ) -> Result<ReadTicket<Vec<u8>>, ExecuteError> {
        let (planned, physical) = self.live(resource, age)?;
        self.written_by_all(resource, 0, 0)?;
        let Some(buffer) = physical.buffer(copy_of(self.last_rotation(resource), age, physical.count())) else {
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
        let readback = self.readbacks.buffer(&buffer, start, end - start);
        let (skip, length) = ((bytes.start - start) as usize, (bytes.end - bytes.start) as usize);
        self.ticket(readback, move |words| words[skip..skip + length].to_vec())
    }

    /// Reads the picture of the last frame. Waits for the device.
    pub fn read_presented(&mut self) -> Result<Picture, ExecuteError> {
        let ticket = self.request_picture()?;
        self.redeem(&ticket)
    }

    /// As [`Self::request_target`], but waits for the device.
    pub fn read_target(
        &mut self,
        resource: ResourceId,
        age: u32,
        mip: u32,
        layer: u32,
    ) -> Result<Texels, ExecuteError> {
        let ticket = self.request_target(resource, age, mip, layer)?;
        self.redeem(&ticket)
    }

    /// As [`Self::request_buffer`], but waits for the device.
    pub fn read_buffer(&mut self, resource: ResourceId, age: u32, bytes: Range<u64>) -> Result<Vec<u8>, ExecuteError> {
        let ticket = self.request_buffer(resource, age, bytes)?;
        self.redeem(&ticket)
    }

    fn ticket<T>(
        &self,
        readback: raxel_gpu::Result<Readback>,
        assemble: impl Fn(Vec<u8>) -> T + Send + 'static,
    ) -> Result<ReadTicket<T>, ExecuteError> {
        let readback = readback.map_err(|error| self.attribute_loss(error.into()))?;
        Ok(ReadTicket::new(readback, assemble))
    }

    /// Waits for a requested result, as long as the device goes on finishing passes.
    pub fn redeem<T>(&self, ticket: &ReadTicket<T>) -> Result<T, ExecuteError> {
        let there = self.wait_at_work(ticket.readback.submitted());
        let bytes = there.and_then(|()| ticket.readback.wait(self.shared.watchdog()));
        bytes.map(&ticket.assemble).map_err(|error| self.attribute_loss(error.into()))
    }

    /// The number of the last frame, or of the last tick for a resource with a clock.
    fn last_rotation(&self, resource: ResourceId) -> u64 {
        let frame = self.frame.saturating_sub(1);
        self.running.as_ref().map_or(frame, |running| running.replay.rotation_after(frame, resource))
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
        // Whether it does share memory is chance.
        if matches!(plan.resources[index].lifetime, Lifetime::Transient { .. }) {
            return Err(ExecuteError::NotKept { resource: name() });
        }
        if physical.needs_init() {
            return Err(ExecuteError::NoFrame { resource: name() });
        }
        if age >= physical.count() {
            return Err(out_of_range(physical, format!("`@{age}`: its history is {}", physical.count() - 1)));
        }
        Ok((&plan.resources[index], physical))
    }

    /// Refuses a part of a resource that the last frame did not bring to where the graph has it. Another plan may run since.
    fn written_by_all(&self, resource: ResourceId, mip: u32, layer: u32) -> Result<(), ExecuteError> {
        let (Some(running), Some(ran)) = (&self.running, &self.ran) else { return Ok(()) };
        let name = &running.plan().graph.resource(resource).name;
        let Some(resource) = ran.graph.find_resource(name) else { return Ok(()) };
        match ran.culled_writer(resource, mip, layer) {
            Some(pass) => {
                Err(ExecuteError::CulledWriter { resource: name.clone(), pass: ran.graph.pass(pass).name.clone() })
            }
            None => Ok(()),
        }
    }
}

fn out_of_range(physical: &Physical, part: String) -> ExecuteError {
    ExecuteError::OutOfRange { resource: physical.name.clone(), part }
}
