//! `raxel doctor --world`: the memory that a world takes in each layout.

use std::path::Path;
use std::sync::Arc;

use raxel_gpu::Device;
use raxel_layouts::{EncodedImage, Layout};
use raxel_runtime::project::Project;
use raxel_runtime::sources::layout_limits;
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;

use super::{Grade, Report};
use crate::verbs::world::bytes;

/// Says how many bytes each layout of raxel's own needs, and whether a buffer of the device has room for them; of a streamed world, the bytes that its file
/// asks for.
pub(super) fn judge(world: &Path, device: &Arc<Device>, report: &mut Report<'_>) -> Result {
    let console: &Console = report.console;
    let (offline, path) = OfflineProject::of(Some(world), Project::default_world, console)?;
    let world = offline.world(&path, console)?;
    let (range, memory) =
        (u64::from(device.capabilities().limits.max_storage_buffer_range), device.capabilities().memory);
    let has = format!("the device has {} (maxStorageBufferRange), {} in all", bytes(range), bytes(memory));
    if let Some(streamed) = world.streamed() {
        let (asked, there) = (streamed.settings.gpu_memory, range.min(memory));
        let (grade, taken) = if asked <= there {
            (Grade::Good, String::new())
        } else {
            (Grade::Optional, format!(", of which raxel takes {}", bytes(there)))
        };
        let finding = format!("`gpu_memory` is {}{taken}; {has}", bytes(asked));
        report.line(grade, "streamed world", &finding);
        return Ok(());
    }
    let limits = layout_limits(device);
    let mut fitting = 0;
    for layout in Layout::OWN {
        let image = |encoded: u64| {
            let image = layout.encode_image(world.voxels(), limits)?;
            Ok(encoded + image.as_ref().map_or(0, EncodedImage::bytes))
        };
        let encoded = layout.encode(world.voxels(), limits);
        match encoded.and_then(|encoded| image(encoded.geometry_bytes + encoded.attribute_bytes)) {
            Ok(taken) if taken <= memory => {
                fitting += 1;
                report.line(Grade::Good, layout.name(), &format!("{} for `{path}`; {has}", bytes(taken)));
            }
            Ok(taken) => {
                report.line(Grade::Optional, layout.name(), &format!("{} for `{path}`; {has}", bytes(taken)));
            }
            Err(error) => report.line(Grade::Optional, layout.name(), &format!("{error}; {has}")),
        }
    }
    if fitting == 0 {
        let message =
            format!("`{path}` fits no layout on this device: a smaller world, or one with `[stream]`, takes less");
        report.bad("world", Failure::new(Exit::Project, message));
    }
    Ok(())
}
