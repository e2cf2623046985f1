//! Phase 2, extends: a graph file and the files that it extends become one model. The file laid on top wins, key by key; params, targets,
//! buffers, blocks, loops, passes, bind entries and block members are matched by name. Places stay those of the file that a value came
//! from.

use std::collections::HashMap;

use raxel_diagnostics::files::{join, read_text};
use raxel_diagnostics::{Code, Diagnostic, Files, SourceMap, Span, Spanned, codes};
use raxel_graph::supply::has_shape;
use raxel_language::Layer;
use raxel_language::layer::{merge, unknown};

use crate::model::{Buffer, File, Fills, Member, Pass, SharedBlock, Target};
use crate::parse::parse;

/// Files that may extend each other in a row.
const LONGEST_CHAIN: usize = 16;

/// Params, targets, buffers, blocks, loops, passes, and entries of a block or a pass that a file may have of each.
const MOST: usize = 4096;

/// A model with the files it came from, the given one first.
#[derive(Clone, Debug)]
pub(crate) struct Loaded {
    /// The merged declarations.
    pub model: File,
    /// Their paths.
    pub files: Vec<String>,
}

/// Reads the graph file of that path and every file it extends. `None` when one of them cannot be read as TOML.
pub(crate) fn load(
    path: &str,
    files: &dyn Files,
    texts: &mut SourceMap,
    found: &mut Vec<Diagnostic>,
) -> Option<Loaded> {
    let mut chain: Vec<File> = Vec::new();
    let mut next = (path.to_owned(), None::<Span>);
    loop {
        let (path, named_at) = next;
        if is_shader(&path) {
            found.push(not_a_graph(&path, named_at));
            return None;
        }
        let text = match read_text(files, &path, named_at.map(|span| (span, "extended here")), texts) {
            Ok(text) => text,
            Err(diagnostic) => {
                found.push(*diagnostic);
                return None;
            }
        };
        let file = parse(&path, &text, found)?;
        let base = file.extends.clone();
        if let Some(diagnostic) = too_many(&file) {
            found.push(diagnostic);
            return None;
        }
        repeated_passes(&file, found);
        chain.push(file);
        let Some(base) = base else { break };
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        let Some(base_path) = join(folder, &base.value) else {
            found.push(
                Diagnostic::error(
                    codes::files::OUTSIDE_ROOT,
                    format!("`{}` is not a path inside the project", base.value),
                )
                .label(base.span, "extended here")
                .help(format!("write it relative to `{folder}/`")),
            );
            return None;
        };
        if let Some(diagnostic) = refuse(&chain, &base_path, &base.span) {
            found.push(diagnostic);
            return None;
        }
        next = (base_path, Some(base.span));
    }
    let files = chain.iter().map(|file| file.path.to_string()).collect();
    // The innermost base first, then each file over all below it.
    let mut layers = chain.into_iter().rev();
    let mut base = layers.next()?;
    reject_overlay_keys(&base, found);
    base.params.retain(|param| !param.remove);
    base.clocks.retain(|clock| !clock.remove);
    base.targets.retain(|target| !target.remove);
    base.buffers.retain(|buffer| !buffer.remove);
    base.blocks.retain(|block| !block.remove);
    base.loops.retain(|repeated| !repeated.remove);
    base.passes.retain(|pass| !pass.remove);
    let model = layers.fold(base, |below, above| overlay(below, above, found));
    Some(Loaded { model, files })
}

/// Whether a name is that of a shader: no graph is called so.
fn is_shader(path: &str) -> bool {
    let extension = path.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
    extension.is_some_and(|extension| ["comp", "glsl", "hlsl", "spv"].contains(&extension.as_str()))
}

fn not_a_graph(path: &str, named_at: Option<Span>) -> Diagnostic {
    let message = format!("`{path}` is a shader, and a graph is needed");
    let diagnostic = Diagnostic::error(codes::files::UNREADABLE, message);
    let name = path.strip_prefix("shaders/").unwrap_or(path);
    let diagnostic = diagnostic.help(format!("name a graph that has `shader = \"{name}\"` in a pass"));
    match named_at {
        Some(place) => diagnostic.label(place, "extended here"),
        None => diagnostic,
    }
}

/// The reason if the last file of a chain may not extend `base`.
fn refuse(chain: &[File], base: &str, named_at: &Span) -> Option<Diagnostic> {
    let names = || chain.iter().map(|file| file.path.as_ref()).chain([base]).collect::<Vec<_>>().join(" → ");
    let message = if chain.iter().any(|file| file.path.as_ref() == base) {
        format!("`{base}` extends itself: {}", names())
    } else if chain.len() >= LONGEST_CHAIN {
        format!("more than {LONGEST_CHAIN} graphs extend each other: {}", names())
    } else {
        return None;
    };
    let mut diagnostic =
        Diagnostic::error(codes::graph::EXTENDS_CYCLE, message).label(named_at.clone(), "this closes the chain");
    // The files between the one that is named again and the last.
    let from = chain.iter().position(|file| file.path.as_ref() == base).unwrap_or(chain.len() - 1);
    for extends in chain[from..chain.len() - 1].iter().filter_map(|file| file.extends.as_ref()) {
        diagnostic = diagnostic.label(extends.span.clone(), "extended here");
    }
    Some(diagnostic)
}

/// `remove`, `before` and `after` mean something only over a base.
fn reject_overlay_keys(file: &File, found: &mut Vec<Diagnostic>) {
    let mut reject = |key: &str, name: &Spanned<String>, span: &Span| {
        found.push(
            Diagnostic::error(
                codes::graph::NOTHING_TO_OVERLAY,
                format!("`{}` has `{key}`, but `{}` extends no graph", name.value, file.path),
            )
            .label(span.clone(), "this file has no base")
            .help("give the graph a base with `extends = \"base.toml\"`, or take the key out"),
        );
    };
    let removed = (file.params.iter().filter(|p| p.remove).map(|p| &p.name))
        .chain(file.clocks.iter().filter(|c| c.remove).map(|c| &c.name))
        .chain(file.targets.iter().filter(|t| t.remove).map(|t| &t.name))
        .chain(file.buffers.iter().filter(|b| b.remove).map(|b| &b.name))
        .chain(file.blocks.iter().filter(|b| b.remove).map(|b| &b.fills.name))
        .chain(file.blocks.iter().flat_map(|b| b.fills.members.iter().filter(|m| m.remove).map(|m| &m.path)))
        .chain(file.loops.iter().filter(|l| l.remove).map(|l| &l.name))
        .chain(file.passes.iter().filter(|p| p.remove).map(|p| &p.name))
        .chain(file.passes.iter().flat_map(|p| p.bind.iter().filter(|b| b.remove).map(|b| &b.name)))
        .chain(
            file.passes.iter().flat_map(|p| blocks(p).flat_map(|f| &f.members).filter(|m| m.remove).map(|m| &m.path)),
        );
    removed.for_each(|name| reject("remove", name, &name.span));
    for pass in &file.passes {
        for (key, place) in [("before", &pass.before), ("after", &pass.after)] {
            if let Some(place) = place {
                reject(key, &pass.name, &place.span);
            }
        }
    }
}

/// A file that has two passes of one name cannot be laid over another, nor another over it. (TOML itself refuses a repeated key.)
fn repeated_passes(file: &File, found: &mut Vec<Diagnostic>) {
    let mut first: HashMap<&str, &Span> = HashMap::new();
    for name in file.passes.iter().map(|pass| &pass.name).filter(|name| !name.value.is_empty()) {
        let Some(earlier) = first.insert(&name.value, &name.span) else { continue };
        found.push(
            Diagnostic::error(codes::graph::DUPLICATE_NAME, format!("two passes are called `{}`", name.value))
                .label(name.span.clone(), "this pass has the name of another")
                .label(earlier.clone(), "the one before"),
        );
    }
}

/// The diagnostic for a file with more of something than any graph needs: later phases compare names with names.
fn too_many(file: &File) -> Option<Diagnostic> {
    let entries = file.passes.iter().flat_map(|pass| {
        let binds = ("entries of `bind`", pass.bind.get(MOST).map(|bind| &bind.name));
        let constants = ("constants", pass.specialization.get(MOST).map(|(name, _)| name));
        let members = blocks(pass).map(|block| ("members", block.members.get(MOST).map(|member| &member.path)));
        members.chain([binds, constants])
    });
    let tables = [
        ("params", file.params.get(MOST).map(|param| &param.name)),
        ("clocks", file.clocks.get(MOST).map(|clock| &clock.name)),
        ("targets", file.targets.get(MOST).map(|target| &target.name)),
        ("buffers", file.buffers.get(MOST).map(|buffer| &buffer.name)),
        ("blocks", file.blocks.get(MOST).map(|block| &block.fills.name)),
        ("loops", file.loops.get(MOST).map(|repeated| &repeated.name)),
        ("passes", file.passes.get(MOST).map(|pass| &pass.name)),
    ];
    let shared = file.blocks.iter().map(|block| ("members", block.fills.members.get(MOST).map(|member| &member.path)));
    let (what, name) = tables.into_iter().chain(shared).chain(entries).find_map(|(what, name)| Some((what, name?)))?;
    Some(
        Diagnostic::error(codes::graph::TOO_MANY, format!("more than {MOST} {what}"))
            .label(name.span.clone(), "this is one too many"),
    )
}

/// A key that a new pass removes was never there.
pub(crate) fn reject_removals(pass: &Pass, found: &mut Vec<Diagnostic>) {
    let removed = (pass.bind.iter().filter(|bind| bind.remove).map(|bind| ("binding", &bind.name)))
        .chain(blocks(pass).flat_map(|block| &block.members).filter(|m| m.remove).map(|m| ("member", &m.path)));
    found.extend(removed.map(|(what, name)| unknown(what, codes::graph::NOTHING_TO_OVERLAY, name, [].into_iter())));
}

fn blocks(pass: &Pass) -> impl Iterator<Item = &Fills<Member>> {
    pass.push.iter().chain(&pass.uniforms)
}

/// Lays `above` over `below`.
fn overlay(mut below: File, mut above: File, found: &mut Vec<Diagnostic>) -> File {
    let moves: Vec<_> = above.passes.iter().map(|p| (p.name.clone(), p.before.clone(), p.after.clone())).collect();
    below.path = above.path.clone();
    below.misspelt.append(&mut above.misspelt);
    below.cover(above, found);
    for (name, before, after) in moves {
        place(&mut below.passes, &name, before.as_ref(), after.as_ref(), found);
    }
    below
}

/// Moves a pass before or after another of the base.
fn place(
    passes: &mut Vec<Pass>,
    name: &Spanned<String>,
    before: Option<&Spanned<String>>,
    after: Option<&Spanned<String>>,
    found: &mut Vec<Diagnostic>,
) {
    let Some(anchor) = before.or(after) else { return };
    let Some(from) = passes.iter().position(|pass| pass.name.value == name.value) else { return };
    let moved = passes.remove(from);
    let place = passes.iter().position(|pass| pass.name.value == anchor.value);
    if place.is_none() {
        found.push(unknown("pass", codes::graph::UNKNOWN_PASS, anchor, passes.iter().map(|pass| &pass.name.value[..])));
    }
    let index = place.map_or(from, |index| index + usize::from(before.is_none()));
    passes.insert(index, moved);
}

/// The keys that a target of the base loses under another.
pub(crate) fn settle_target(below: &mut Target, above: &Target) {
    if above.source.is_some() || above.copy.is_some() {
        // A source brings its own format, extent and contents.
        (below.source, below.copy) = (None, None);
        (below.format, below.size, below.mips, below.layers) = (None, None, None, None);
        (below.clear, below.init, below.history) = (None, None, None);
        (below.keep, below.clock) = (None, None);
        (below.slices, below.encoding) = (None, None);
    } else if above.size.is_some()
        || above.format.is_some() && !below.source.as_ref().is_some_and(|source| has_shape(&source.value))
    {
        // The same target, made here.
        (below.source, below.copy, below.slices, below.encoding) = (None, None, None, None);
    }
    // Keys that exclude each other also replace each other.
    if above.clear.is_some() || above.init.is_some() {
        (below.clear, below.init) = (None, None);
    }
}

/// The keys that a buffer of the base loses under another.
pub(crate) fn settle_buffer(below: &mut Buffer, above: &Buffer) {
    if above.source.is_some() || above.copy.is_some() {
        // A source brings its own size and contents.
        (below.clear, below.init, below.history) = (None, None, None);
        (below.keep, below.clock, below.warnings) = (None, None, None);
    }
    // A buffer has one of these keys. The one of the overlay replaces that of the base.
    if above.size.is_some() || above.source.is_some() || above.copy.is_some() || above.values.is_some() {
        (below.size, below.source, below.values, below.copy) = (None, None, None, None);
        if above.values.is_none() {
            below.ty = None;
        } else {
            below.warnings = None;
        }
    }
    // Keys that exclude each other also replace each other.
    if above.clear.is_some() || above.init.is_some() {
        (below.clear, below.init) = (None, None);
    }
}

impl Layer for SharedBlock {
    const WHAT: &'static str = "block";
    const UNKNOWN: Code = codes::graph::NOTHING_TO_OVERLAY;
    fn name(&self) -> &Spanned<String> {
        &self.fills.name
    }
    fn removed(&self) -> bool {
        self.remove
    }
    fn added(&self, found: &mut Vec<Diagnostic>) {
        let removed = self.fills.members.iter().filter(|member| member.remove);
        found.extend(
            removed.map(|member| unknown("member", codes::graph::NOTHING_TO_OVERLAY, &member.path, [].into_iter())),
        );
    }
    fn cover(&mut self, above: Self, found: &mut Vec<Diagnostic>) {
        self.fills.cover(above.fills, found);
    }
}

impl Layer for Fills<Member> {
    const WHAT: &'static str = "block";
    const UNKNOWN: Code = codes::graph::NOTHING_TO_OVERLAY;
    fn name(&self) -> &Spanned<String> {
        &self.name
    }
    fn removed(&self) -> bool {
        false
    }
    fn cover(&mut self, above: Self, found: &mut Vec<Diagnostic>) {
        merge(&mut self.members, above.members, found);
    }
}
