//! The render-graph compiler: a TOML file in, an immutable plan out. No GPU; no I/O but the files it is given.

pub mod checked;
pub mod plan;
