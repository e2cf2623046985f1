//! Questions about the newest voxels, answered on the CPU from the chunks themselves: nothing is prepared, so an edit is seen at once.

mod cast;
mod collide;
mod region;

pub use cast::{CastHit, cast};
pub use collide::{Collision, MOST_MOTION, collide, overlaps};
pub use region::{Histogram, histogram};
