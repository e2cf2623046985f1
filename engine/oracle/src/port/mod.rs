//! The GPU tracer of the layout `tree64` on the CPU: `shaders/include/raxel/internal/walk.glsl` and `tree64.glsl`, function by function,
//! with the same names and the same `f32` and integer operations, over the same buffer. Where it differs from a device in a bit, the device
//! has divided less precisely or fused a multiplication with an addition; the hit does not depend on that.

mod tree64;
mod walk;

pub use tree64::Tree64;
