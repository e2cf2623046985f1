//! The builtin values of a frame from the session: its camera, its output, its world.

use raxel_execute::Builtins;

use crate::camera::Camera;
use crate::world::{SessionWorld, saturated};

/// The builtin values of a camera, of where it was in the frame before, of an output of that extent in pixels, and of a world. Time is zero.
#[expect(clippy::cast_possible_truncation, reason = "shaders get 32-bit floats")]
pub fn of(camera: &Camera, previous: &Camera, output: [u32; 2], world: &SessionWorld) -> Builtins {
    let [width, height] = output;
    let aspect = f64::from(width) / f64::from(height);
    let bounds = world.bounds_around(camera.cell);
    Builtins {
        camera_cell: camera.cell.to_array(),
        camera_frac: camera.frac.to_array(),
        camera_view_to_world: camera.view_to_world().to_cols_array_2d(),
        camera_world_to_view: camera.world_to_view().to_cols_array_2d(),
        camera_fov: camera.fov as f32,
        camera_tan_half_fov: camera.tan_half_fov(aspect).to_array(),
        camera_previous_cell: previous.cell.to_array(),
        camera_previous_frac: previous.frac.to_array(),
        camera_previous_view_to_world: previous.view_to_world().to_cols_array_2d(),
        camera_previous_world_to_view: previous.world_to_view().to_cols_array_2d(),
        output_size: [width.cast_signed(), height.cast_signed()],
        output_aspect: aspect as f32,
        world_min: bounds.min.map(saturated),
        world_max: bounds.max.map(saturated),
        world_voxels: match world.streamed() {
            Some(_) => u32::MAX,
            None => u32::try_from(world.voxels().solids()).unwrap_or(u32::MAX),
        },
        ..Builtins::default()
    }
}
