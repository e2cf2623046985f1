//! Phase 5, check: compares the graph with the declarations of its shaders, and its parts with each other. Each file holds one family of
//! checks. Every disagreement is reported once and names both places.

mod bindings;
mod blocks;
mod clocks;
mod constants;
mod dispatch;
mod extents;
mod flow;
mod given;
mod images;
mod loops;
mod overlaps;
mod portability;
mod sources;

use std::collections::HashSet;
use std::sync::Arc;

use raxel_diagnostics::{Code, Diagnostic, Severity, Span};
use raxel_graph::checked::{self, Graph};
use raxel_graph::supply::Catalog;
use raxel_shader::Shader;
use raxel_shader::interface::Interface;

use crate::queues;
use crate::reflect::Reflected;
use crate::resolve::{Pass, Resolved};

/// A pass beside its shader.
struct Context<'a> {
    graph: &'a Resolved,
    pass: &'a Pass,
    shader: &'a Arc<Shader>,
    sources: &'a dyn Catalog,
    /// No earlier pass uses the shader, so mistakes of the shader alone are reported now.
    first_use: bool,
    /// The severity of a value or binding that the pass gives and the shader does not use.
    unused: Severity,
}

impl Context<'_> {
    fn interface(&self) -> &Interface {
        &self.shader.interface
    }

    /// The shader does not use something that the pass gives it.
    fn unused(&self, code: Code, message: String) -> Diagnostic {
        let diagnostic = Diagnostic { severity: self.unused, ..Diagnostic::error(code, message) };
        match self.unused {
            Severity::Error => diagnostic,
            Severity::Warning => diagnostic.note("the graph runs on; `raxel check` reports this as an error"),
        }
    }

    /// Adds the place in the shader; a module without its source is at least named.
    fn in_shader(&self, diagnostic: Diagnostic, place: Option<&Span>, text: impl Into<String>) -> Diagnostic {
        match place {
            Some(place) => diagnostic.label(place.clone(), text),
            None => diagnostic.note(format!("{} in `{}`", text.into(), self.shader.request.path)),
        }
    }
}

/// Checks everything that can be checked without a device. `None` when a pass is so broken that there is no graph.
pub(crate) fn check(
    resolved: &Resolved,
    reflected: &Reflected,
    sources: &dyn Catalog,
    unused: Severity,
    found: &mut Vec<Diagnostic>,
) -> Option<Graph> {
    // Checks the extents of targets by themselves: no size refers to itself, and no target has more mips than its texels allow.
    extents::check(resolved, found);
    // The passes of a loop stand together.
    loops::check(resolved, found);
    loops::without_rounds(resolved, found);
    // Each pass against its shader.
    let mut passes = Vec::with_capacity(resolved.passes.len());
    let mut seen = HashSet::new();
    for (pass, shader) in resolved.passes.iter().zip(reflected) {
        let Some(shader) = shader else { continue };
        let first_use = seen.insert(shader.key);
        let checked = check_pass(&Context { graph: resolved, pass, shader, sources, first_use, unused }, found);
        passes.extend(checked);
    }
    // Checks of the flow from pass to pass, once all of them are known.
    let complete = passes.len() == resolved.passes.len() && resolved.present.is_some();
    if !complete {
        return None;
    }
    // A pass that dispatches a queue gets one in front that makes its arguments.
    let passes = with_arguments(resolved, passes, found)?;
    let graph = assemble(resolved, passes)?;
    clocks::check(&graph, resolved, found);
    flow::check(&graph, resolved, found);
    Some(graph)
}

/// Checks one pass. `None` when something in it is missing or wrong.
fn check_pass(context: &Context<'_>, found: &mut Vec<Diagnostic>) -> Option<checked::Pass> {
    let before = found.iter().filter(|diagnostic| diagnostic.is_error()).count();
    let pass = context.pass;
    // Every name the shader binds is bound to something that suits it.
    let mut accesses = bindings::check(context, found);
    // Every member of its blocks has a value of its type.
    let push = blocks::push(context, found);
    let uniforms = blocks::uniforms(context, found);
    // Constants, then the workgroup size that they may set.
    let specialization = constants::check(context, found);
    portability::check(context, &specialization, found);
    accesses.extend(dispatch::check(context, found));
    let in_loop = loops::in_loop(context, &accesses);
    // Nothing is written through one name while another sees it, in any round.
    for accesses in loops::rounds(context, &accesses, in_loop.as_ref()) {
        if overlaps::check(context, &accesses, found) {
            break;
        }
    }
    let errors = found.iter().filter(|diagnostic| diagnostic.is_error()).count();
    let dispatch = pass.dispatch.as_ref()?.value.clone();
    let bound = pass.bind.iter().all(|entry| entry.target.is_some());
    (errors == before && pass.sound && bound).then(|| checked::Pass {
        name: pass.name.value.clone(),
        shader: context.shader.clone(),
        dispatch,
        accesses,
        push,
        uniforms,
        specialization,
        subgroup_size: pass.subgroup_size,
        in_loop,
        round: None,
        when: pass.when.clone(),
        every: pass.every,
        made: false,
        place: pass.name.span.clone(),
    })
}

fn with_arguments(
    resolved: &Resolved,
    passes: Vec<checked::Pass>,
    found: &mut Vec<Diagnostic>,
) -> Option<Vec<checked::Pass>> {
    let mut all = Vec::with_capacity(passes.len());
    for (pass, declared) in passes.into_iter().zip(&resolved.passes) {
        if let Some(queue) = declared.queue {
            match queues::maker(&pass, queue) {
                Ok(maker) => all.push(maker),
                Err(diagnostic) => {
                    found.push(diagnostic);
                    return None;
                }
            }
        }
        all.push(pass);
    }
    Some(all)
}

fn assemble(resolved: &Resolved, passes: Vec<checked::Pass>) -> Option<Graph> {
    let mut files = resolved.files.clone();
    for file in passes.iter().filter(|pass| !pass.made).flat_map(|pass| &pass.shader.files) {
        if !files.contains(file) {
            files.push(file.clone());
        }
    }
    Some(Graph {
        name: resolved.name.clone(),
        about: resolved.about.clone(),
        present: resolved.present.as_ref()?.value,
        params: resolved.params.iter().map(|param| param.item.clone()).collect(),
        clocks: resolved.clocks.iter().map(|clock| clock.item.clone()).collect(),
        resources: resolved.resources.iter().map(|resource| resource.item.clone()).collect(),
        loops: resolved.loops.iter().map(|repeated| repeated.item.clone()).collect(),
        passes,
        materials: resolved.materials.clone(),
        files,
    })
}
