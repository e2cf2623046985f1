//! Diagnostics as plain data, their codes and their rendering; and the two readers that produce most of them: of project files and of TOML tables.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

mod code;
pub mod codes;
mod diagnostic;
pub mod disk;
pub mod files;
pub mod names;
mod quiet;
pub mod render;
pub mod schema;
pub mod table;

pub use code::Code;
pub use codes::explain;
pub use diagnostic::{Diagnostic, Label, Severity, SourceMap, Span, Spanned, each_once};
pub use disk::{DiskFiles, MemoryFiles};
pub use files::{FileError, Files};
pub use quiet::quietly;
