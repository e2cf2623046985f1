//! Barriers: the fewest that order every pair of conflicting accesses, in a frame and over all later frames. Each barrier has
//! the fewest stages and accesses.
//!
//! The model is Vulkan's (chapter "Synchronization and Cache Control"). A barrier orders all commands before it against all behind
//! it, for the stages it names; source stages include logically earlier ones (`COMPUTE_SHADER` includes `DRAW_INDIRECT`),
//! destination stages logically later ones. Barriers chain when a destination stage of the first is a source stage of the second.
//! * A load after a store and a store after a store need the first store made available (its access in the source scope where the
//!   chain starts) and visible to the second access (its access in the destination scope of a barrier of the chain).
//! * A store after a load needs the chain only.
//! * Shared memory: an image takes it over by its own `UNDEFINED` → `GENERAL` transition, a store to all of the memory that must
//!   come after all accesses of the former occupants and before all of its own. Two rules are stricter than Vulkan's, because the synchronization
//!   validation of the Khronos layer (1.3.239) is stricter. The scopes of a transition count for that take-over only: their stages order no other
//!   commands. Its source scope names the store accesses of the former occupants itself, even if an earlier barrier has made those stores available
//!   and a chain of stages would do. A buffer needs no transition: its accesses conflict with those of the former occupants as if all were one
//!   resource.
//!
//! *Every* conflicting pair is covered on its own, even if an access between the two would carry the order along. So a frame may
//! leave out a step (`every`, a result that is still valid) as long as the barriers stay: this removes pairs and adds none.

mod cover;
mod frames_apart;
mod hazards;
mod place;
mod prune;

use crate::back::alias::Alias;
use crate::back::lifetimes::Life;
use crate::back::order::Order;
use crate::ir::checked::Graph;
use crate::ir::index::index32;
use crate::ir::plan::{Barrier, ResourcePlan};

/// A frame with its memory laid out: all that barriers depend on.
pub(crate) struct Frame<'a> {
    /// The graph, for its clocks.
    pub graph: &'a Graph,
    /// Actions and accesses.
    pub order: &'a Order,
    /// Used resources.
    pub resources: &'a [ResourcePlan],
    /// Their lifetimes.
    pub lives: &'a [Life],
    /// Their shared memory.
    pub alias: &'a Alias,
}

/// The barrier in front of each action, where one is needed.
pub(crate) fn barriers(frame: &Frame) -> Vec<Option<Barrier>> {
    // The accesses to order, as intervals of gaps: one barrier in each interval is enough.
    let hazards = hazards::find(frame);
    // The fewest gaps that hit every interval.
    let gaps = place::place(index32(frame.order.actions.len()), &hazards);
    // Every hazard asks its bits of the last barrier in its interval; then bits that other barriers cover are taken away again.
    let scopes = prune::prune(frame, &hazards, &gaps);
    // Add the reason of each.
    scopes.into_barriers(frame, &hazards)
}
