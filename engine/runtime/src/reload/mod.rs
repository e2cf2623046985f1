//! Hot reload: watch the files that went in, wait until a save is finished, rebuild off-thread what depends on it.

pub(crate) mod builder;
mod debounce;
mod event;
pub(crate) mod mend;
pub(crate) mod project_state;
mod watch;

pub use builder::Waker;
pub use event::{Failed, Rebuilt, ReloadEvent, Reloaded, Stages};
pub use project_state::ProjectFile;
