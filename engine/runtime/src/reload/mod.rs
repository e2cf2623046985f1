//! Hot reload: watch the files that went in, wait until a save is finished, rebuild off-thread what depends on it.

pub mod settle;
pub mod watch;
