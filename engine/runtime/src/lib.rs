//! Sessions: open a project, run its graph over its world, drive it by params and demos, and swap in every edit while it runs.

pub mod build;
pub mod camera;
pub mod clock;
pub mod execute;
pub mod params;
pub mod project;
pub mod reload;
pub mod session;
pub mod show;
pub mod timeline;
pub mod world;

pub use session::{FrameError, OpenError, Options, ReadError, Session};
