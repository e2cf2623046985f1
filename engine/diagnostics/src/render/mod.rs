//! Diagnostics as text, in three forms that say the same: for people, for editors and grep, for programs. None of them fails for any spans: a file
//! may have changed since it was read, or its text may not be at hand. None of them is long for any input: [`MOST`] diagnostics are shown and the
//! rest is counted, and long words and lines are cut.

mod extent;
mod human;
mod json;
mod position;
mod short;

pub use extent::MOST;
pub(crate) use extent::brief;
pub use human::human;
pub use json::json;
pub use position::{Position, position};
pub use short::short;

#[cfg(test)]
mod tests;
