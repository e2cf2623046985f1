//! Shaders: GLSL, HLSL and SPIR-V in; a module and its interface out.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! A [`Compiler`] compiles in its own process, with limits on the size of texts, macros and types, unless the program has called
//! [`worker::isolate`]: child processes compile from then on, with limits on time and memory, so that no text can end or stop the program.

mod compile;
mod compiler;
mod fatal;
mod first_look;
pub mod format;
mod front_end;
mod functions;
#[doc(hidden)]
pub mod fuzzing;
mod graphics;
mod hlsl;
pub mod interface;
mod lexer;
pub mod library;
mod limits;
mod messages;
mod module_cache;
mod outline;
mod places;
mod print_format;
pub mod prints;
mod reflect;
mod request;
mod sources;
mod stripped;
pub mod worker;
pub mod writes;

pub use compiler::Compiler;
pub use first_look::FirstLook;
pub use graphics::{GraphicsStage, compile_graphics};
pub use raxel_spirv::bytes_of;
pub use request::{Request, Shader, ShaderProvider};
