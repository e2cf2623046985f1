//! Presentation: the pictures that frames end at are shown in a window, with layers drawn over them. Knows nothing of graphs and plans.

mod error;
mod pixels;
mod presenter;
mod viewport;

pub use error::PresentError;
pub use presenter::{Presenter, new_overlay};
pub use raxel_gpu::{OverlayFrame, OverlayMesh, OverlayVertex, Place, Presented, TexturePatch};
pub use viewport::Viewport;
