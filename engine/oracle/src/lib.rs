//! The exact ray caster that every layout is judged by.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! # The ray
//! A shader traces a [`Ray`]: an integer cell, a fraction and a direction in `f32`. It traces *exactly* that ray put on a lattice
//! ([`Lattice`]): the fraction rounded down to multiples of 2⁻²⁴, and each direction component cut to 31 bits below the exponent of the
//! largest one. The lattice has more bits than the `f32` values in all but extreme cases, rounds towards zero (so mirrored rays stay
//! mirrored) and is found by bit operations alone, so every device traces the same ray.
//!
//! # The rule
//! * The ray starts in the closed cube of its cell, and in no other. If that voxel is solid, it is hit at t = 0 with face 6 (inside).
//! * A zero component never crosses a plane of its axis.
//! * When the ray crosses planes of several axes at the same time (an edge or a corner), it steps over all of them at once: the cells
//!   that it only touches are not visited.
//! * The face that is hit belongs to an axis crossed last; of several, to the one with the largest direction component, then to the first
//!   of x, y, z.
//! * A NaN, an infinity, or a direction whose largest component is zero or denormal hits nothing.
//!
//! [`exact::first_hit`] follows this rule in 128-bit rational arithmetic. Tests check it with an unrelated method on
//! small worlds. [`port`] is the GPU tracer of the layout `tree64`, line by line, over the very buffer the GPU gets.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

pub mod bounce;
pub mod exact;
pub mod export;
pub mod instances;
pub mod metrics;
mod oracle;
pub mod period;
pub mod port;
pub mod scenes;
pub mod sets;

pub use oracle::Oracle;
pub use raxel_ray::{FACE_INSIDE, FAR, Hit, Lattice, Ray, camera};
