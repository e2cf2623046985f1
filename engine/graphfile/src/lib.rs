//! Graph files: TOML and its shaders in, a checked graph or every mistake out. No I/O but the files it is given. [`compile_with`] is its six
//! calls: extends, which parses each file → variants → resolve → reflect → layout images → check.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod check;
mod extends;
mod layout_images;
mod literal;
mod model;
mod parse;
mod queues;
mod reflect;
mod resolve;
mod schema;
mod variants;

pub use schema::schema;

use raxel_diagnostics::{Diagnostic, Files, Severity, SourceMap};
use raxel_graph::checked::Graph;
use raxel_graph::supply::Catalog;
use raxel_shader::ShaderProvider;

use self::model::File;

/// The checked graph with warnings, or everything that is wrong with it (warnings included).
pub type Compiled = Result<(Graph, Vec<Diagnostic>), Vec<Diagnostic>>;

/// Another source for one that a graph names; `None` keeps it.
pub type Replace<'a> = &'a dyn Fn(&str) -> Option<String>;

/// How a graph is compiled.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Other sources for those that the graph names. If the source has no image in the other layout, its targets are left out with their bindings.
    pub replace: Replace<'a>,
    /// How much it matters that a shader does not use a binding, a block or a member that the graph gives it. With a warning, the resources of
    /// the graph are as if the shader used it. So their contents outlive an edit that is taken back.
    pub unused: Severity,
}

impl Default for Options<'_> {
    /// The graph as it is written, and nothing unused in it.
    fn default() -> Self {
        Self { replace: &|_| None, unused: Severity::Error }
    }
}

/// Compiles the graph file of that path (relative to the project root). `texts` receives every text that diagnostics point into,
/// which are also the files that the result depends on.
pub fn compile(
    path: &str,
    files: &dyn Files,
    shaders: &dyn ShaderProvider,
    sources: &dyn Catalog,
    texts: &mut SourceMap,
) -> Compiled {
    compile_with(path, files, shaders, sources, Options::default(), texts)
}

/// As [`compile`], with options.
pub fn compile_with(
    path: &str,
    files: &dyn Files,
    shaders: &dyn ShaderProvider,
    sources: &dyn Catalog,
    options: Options<'_>,
    texts: &mut SourceMap,
) -> Compiled {
    let mut found = Vec::new();
    // The file is read, with every file it extends, and laid over them.
    let Some(mut loaded) = extends::load(path, files, texts, &mut found) else { return Err(found) };
    replace_sources(&mut loaded.model, options.replace, sources);
    // A pass over a buffer that only some worlds have is written out as one for each case.
    variants::write_out(&mut loaded.model, &mut found);
    // Names become indices, words become types, literals become values.
    let mut resolved = resolve::resolve(loaded, sources, &mut found);
    // Each distinct shader is compiled once; its interface lists its needs.
    let reflected = reflect::reflect(&resolved, shaders, texts, &mut found);
    // The image of a source goes with its buffer.
    layout_images::add(&mut resolved, &reflected, sources);
    // The graph is compared with its shaders.
    let graph = check::check(&resolved, &reflected, sources, options.unused, &mut found);
    // A mistake in a pass is the same in each of its cases.
    let mut once: Vec<Diagnostic> = Vec::new();
    found.retain(|diagnostic| {
        !once.contains(diagnostic) && {
            once.push(diagnostic.clone());
            true
        }
    });
    // A graph with any error is not handed on.
    match graph {
        Some(graph) if !found.iter().any(Diagnostic::is_error) => Ok((graph, found)),
        _ => Err(found),
    }
}

fn replace_sources(model: &mut File, replace: Replace<'_>, sources: &dyn Catalog) {
    for source in model.buffers.iter_mut().filter_map(|buffer| buffer.source.as_mut()) {
        source.value = replace(&source.value).unwrap_or_else(|| source.value.clone());
    }
    let mut gone = Vec::new();
    model.targets.retain_mut(|target| {
        let Some(source) = &mut target.source else { return true };
        let Some(other) = replace(&source.value) else { return true };
        let stays = sources.source(&other).is_some_and(|layout| layout.image.is_some());
        source.value = other;
        if !stays {
            gone.push(target.name.value.clone());
        }
        stays
    });
    for pass in &mut model.passes {
        pass.bind.retain(|entry| entry.target.as_ref().is_none_or(|target| !gone.contains(&target.value)));
    }
}
