//! Indices as the 32-bit numbers that plans hold.

/// An index, or a count, of a graph's parts: resources, passes, steps, actions, bindings.
///
/// Each comes from its own text in a graph file, or from a pass with at most [`MOST_ROUNDS`] rounds. So memory is exhausted long before
/// there are 2³².
///
/// [`MOST_ROUNDS`]: crate::ir::checked::MOST_ROUNDS
#[expect(clippy::cast_possible_truncation, reason = "no graph has 2³² parts, see above")]
pub fn index32(index: usize) -> u32 {
    debug_assert!(u32::try_from(index).is_ok(), "a graph has {index} parts");
    index as u32
}
