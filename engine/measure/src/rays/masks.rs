//! The table of the marcher `raymask`, as graphs/rivals/march/raymask.toml makes it in its first frame, for rays without a graph.

use std::sync::Arc;

use raxel_diagnostics::Files;
use raxel_gpu::{Backing, Barrier, Buffer, BufferInfo, CommandBuffer, Descriptors, Device, Location, Resource, vk};
use raxel_shader::Request;

use super::error::RayError;
use super::stream::PATIENCE;
use super::tracer::{Named, compile};

/// GLSL name of the table.
pub(super) const BINDING: &str = "rayMasks";
/// The shader that makes it, which comes from the binary.
pub(super) const PATH: &str = "shaders/rivals/march/raymask_bake.comp";

/// 3 × 3 pairs of faces, 256 × 256 pairs of squares on them, 64 bits each.
const ENTRIES: u32 = 9 * 256 * 256;

/// Makes the table, wide enough that no hit depends on it. `left` pipelines are still to be made, this one included.
pub(super) fn bake(device: &Arc<Device>, files: &Arc<dyn Files>, left: usize) -> Result<Resource, RayError> {
    let defines = vec![("RX_RAYMASK_CONSERVATIVE".to_owned(), "1".to_owned())];
    let request = Request { path: PATH.into(), entry: "main".into(), defines };
    let named = Named { pipeline: "raymask table", told: "the raymask table", left };
    let (shader, pipeline) = compile(device, files, &request, named, None)?;
    let size = u64::from(ENTRIES) * 8;
    let info = BufferInfo { size, usage: vk::BufferUsageFlags::STORAGE_BUFFER, location: Location::Device };
    let table = Resource::whole(&Arc::new(Buffer::new(device, BINDING, &info, Backing::Own)?));
    let resources = vec![vec![table.clone()]; shader.interface.bindings.len()];
    let descriptors = Descriptors::new(device, BINDING, &pipeline, &resources)?;
    let mut commands = CommandBuffer::new(device, BINDING)?;
    let mut recording = commands.begin()?;
    recording.bind(&pipeline, &descriptors);
    recording.dispatch([ENTRIES.div_ceil(shader.interface.local_size[0].value), 1, 1]);
    recording.barrier(&Barrier::full());
    let finished_at = recording.submit()?;
    device.wait(finished_at, PATIENCE)?;
    Ok(table)
}
