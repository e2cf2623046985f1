//! Shaders: GLSL, HLSL and SPIR-V in; a module and its interface out.

pub mod format;
pub mod interface;
mod request;

pub use request::{Request, Shader, ShaderSource};
