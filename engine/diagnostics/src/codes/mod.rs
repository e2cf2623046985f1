//! Every code, by range. The range says which room found the error.

/// `RX00xx`: files and TOML (missing, unreadable, not UTF-8, syntax, unknown key, wrong type).
pub mod files;
/// `RX01xx`: the graph (names, bindings, push layouts, sizes, dispatch, order).
pub mod graph;
/// `RX04xx`: projects, demos, command line, device.
pub mod session;
/// `RX02xx`: shaders (include, compile, SPIR-V, reflection).
pub mod shader;
/// `RX03xx`: worlds and models.
pub mod world;

/// Every code with its page, in order.
pub fn all() -> impl Iterator<Item = (crate::Code, &'static str)> {
    [files::ALL, graph::ALL, shader::ALL, world::ALL, session::ALL].into_iter().flatten().copied()
}
