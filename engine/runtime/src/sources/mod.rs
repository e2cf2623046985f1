//! Sources: everything that comes into a graph from outside. A source has a name (`world.tree64`), a description that the graph
//! compiler holds shaders against (block, image, access), and, on a device, a buffer or an image with a version.

mod catalog;
mod check;
mod instances;
mod name;
mod on_device;
mod sound;
mod video;

pub(crate) use catalog::{EDITS, POSES};
pub use catalog::{SourceCatalog, VOXEL_FORMAT};
pub use check::check;
pub(crate) use check::unseen_instances;
pub(crate) use instances::{WrittenPoses, check as check_instances, frames as instance_frames};
pub use name::SourceName;
pub(crate) use on_device::OnDevice;
pub use on_device::layout_limits;
