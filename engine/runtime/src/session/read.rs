//! Reading the last frame.

use std::ops::Range;

use raxel_execute::{Picture, ReadTicket, Texels};
use raxel_graph::checked::ResourceId;

use super::{ReadError, Session};
use crate::params::SetError;

impl Session {
    /// Reads the picture of the last frame: the debug target through its display map. Waits for the device.
    pub fn read_presented(&mut self) -> Result<Picture, ReadError> {
        Ok(self.renderer.executor.read_presented()?)
    }

    /// Reads the texels of mip 0, layer 0 of a target at the end of the last frame. Under [`Observe::Shown`](super::Options::observe), pin
    /// the target first ([`Self::pin`]). Waits for the device.
    pub fn read_target(&mut self, name: &str) -> Result<Texels, ReadError> {
        self.read_texels(name, 0, 0, 0)
    }

    /// Reads the texels of one mip and one layer (or slice of a 3-D target), as they were `age` frames before the last. Waits for the
    /// device.
    pub fn read_texels(&mut self, name: &str, age: u32, mip: u32, layer: u32) -> Result<Texels, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.renderer.executor.read_target(resource, age, mip, layer)?)
    }

    /// Reads a range of bytes of a buffer at the end of the last frame. Waits for the device.
    pub fn read_buffer(&mut self, name: &str, bytes: Range<u64>) -> Result<Vec<u8>, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.renderer.executor.read_buffer(resource, 0, bytes)?)
    }

    /// Requests the picture of the last frame without waiting. Poll the ticket, or pass it to [`Self::redeem`]. At most eight tickets can
    /// be open.
    pub fn request_picture(&mut self) -> Result<ReadTicket<Picture>, ReadError> {
        Ok(self.renderer.executor.request_picture()?)
    }

    /// As [`Self::read_texels`], without waiting.
    pub fn request_texels(
        &mut self,
        name: &str,
        age: u32,
        mip: u32,
        layer: u32,
    ) -> Result<ReadTicket<Texels>, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.renderer.executor.request_target(resource, age, mip, layer)?)
    }

    /// As [`Self::read_buffer`], without waiting.
    pub fn request_buffer(&mut self, name: &str, bytes: Range<u64>) -> Result<ReadTicket<Vec<u8>>, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.renderer.executor.request_buffer(resource, 0, bytes)?)
    }

    /// Waits for a requested result.
    pub fn redeem<T>(&self, ticket: &ReadTicket<T>) -> Result<T, ReadError> {
        Ok(self.renderer.executor.redeem(ticket)?)
    }

    fn resource(&self, name: &str) -> Result<ResourceId, SetError> {
        let names = self.renderer.graph.resources.iter().filter(|r| !r.made).map(|resource| resource.name.as_str());
        self.renderer.graph.find_resource(name).ok_or_else(|| SetError::unknown("resource", name, names))
    }
}
