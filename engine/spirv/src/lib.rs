//! SPIR-V modules: read and checked word by word, validated by the Khronos validator, and rewritten where raxel needs it (a place of its
//! own for each binding, bounds on arrays in shared memory, records of prints, accesses out of bounds and writes of a texel, uniform values
//! that drivers do not fold in). A module from a file may be anything, and no reflector and no driver copes with a damaged one. Numbers and
//! layouts are those of the SPIR-V 1.6 specification, sections 2.3 (physical layout) and 3 (binary form).
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

mod accesses;
mod additions;
mod binary;
mod bindings;
mod bounds;
mod check;
mod constants;
mod error;
mod instruction;
mod memory;
mod module;
mod opaque;
mod print;
mod reads;
mod record;
mod undefined;
mod validate;
mod writes;

pub use accesses::{Access, AccessKind};
pub use binary::{bytes_of, words_of};
pub use error::ModuleError;
pub use memory::Memory;
pub use module::{Module, WorkgroupSize};
pub use print::{PrintCall, PrintError, PrintedScalar, PrintedType, RECORDS, prints};
pub use reads::Chains;
pub use record::{Checks, RECORD_HEAD, Recording};
pub use undefined::Undefined;
pub use validate::validate;
pub use writes::{TexelWrites, WatchedImage, WriteKind, WriteSite};
