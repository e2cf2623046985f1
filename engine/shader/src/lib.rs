//! Shaders: GLSL, HLSL and SPIR-V in; a module and its interface out.

mod compile;
mod compiler;
mod fatal;
pub mod format;
mod graphics;
mod hlsl;
pub mod interface;
mod lexer;
pub mod library;
mod limits;
mod messages;
mod places;
mod reflect;
mod rehearsal;
mod request;
mod sources;

pub use compiler::Compiler;
pub use graphics::{GraphicsStage, compile_graphics};
pub use raxel_spirv::bytes_of;
pub use rehearsal::{Rehearse, rehearse_hlsl, rehearse_hlsl_with};
pub use request::{Request, Shader, ShaderSource};
