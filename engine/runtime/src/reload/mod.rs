//! Hot reload: watch the files that went in, wait until a save is finished, rebuild off-thread what depends on it.

pub mod builder;
pub mod debounce;
mod event;
pub mod project_state;
pub mod recording_files;
pub mod watch;

pub use event::{Failed, Rebuilt, ReloadEvent, Reloaded};
