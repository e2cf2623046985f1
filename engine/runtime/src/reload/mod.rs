//! Hot reload: watch the files that went in, wait until a save is finished, rebuild off-thread what depends on it.

pub mod builder;
mod event;
pub mod parts;
pub mod record;
pub mod settle;
pub mod watch;

pub use event::{Failed, Rebuilt, ReloadEvent, Reloaded};
