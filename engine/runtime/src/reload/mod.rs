//! Hot reload: watch the files of a build, wait until a save is finished, rebuild its dependents off-thread.

pub(crate) mod builder;
mod debounce;
mod early;
mod event;
pub(crate) mod mend;
pub(crate) mod project_state;
mod watch;

pub use builder::Waker;
pub use event::{Failed, Rebuilt, ReloadEvent, Reloaded, Stages};
pub use project_state::ProjectFile;
