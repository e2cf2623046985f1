//! Sessions: open a project, run its graph over its world, drive it by params and demos, and swap in every edit while it runs.

pub mod camera;
pub mod clock;
pub mod params;
pub mod project;
pub mod reload;
pub mod show;
pub mod timeline;
