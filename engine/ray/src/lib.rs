//! Rays through voxels, as shaders have them and as they are traced exactly: the lattice that a ray is put on, times along it without
//! rounding, and the rays of a camera. No world is needed for that; the tracers find the hits of a ray.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

pub mod camera;
pub mod exact;
mod lattice;
mod ray;

pub use lattice::{Lattice, ONE};
pub use ray::{FACE_INSIDE, FAR, Hit, Ray};
