//! Resolves `[[passes]]`: the shader to compile, its bindings, its dispatch, and when it runs.

use raxel_diagnostics::files::join;
use raxel_diagnostics::{Diagnostic, Spanned, codes};
use raxel_graph::checked::{self, Every, Extent, LoopId, ResourceId, ResourceKind, RoundIndex};
use raxel_graph::supply::layout_of;
use raxel_shader::Request;

use super::conditions::condition;
use super::resources::no_elements;
use super::supplied::extent_from_outside;
use super::values::{constant, fills};
use super::{Bind, Declared, Pass, Scope, age, missing, unknown};
use crate::model::{self, Filter, Mip, Wrap};
use crate::queues::Queue;

/// A pass. `arguments` is the buffer that is made for it if it dispatches a queue.
pub(crate) fn pass(
    pass: &model::Pass,
    scope: &Scope<'_>,
    arguments: Option<ResourceId>,
    found: &mut Vec<Diagnostic>,
) -> Pass {
    let whose = format!("pass `{}`", pass.name.value);
    let bind: Vec<Bind> = pass.bind.iter().map(|entry| bind(entry, scope, found)).collect();
    let request = request(pass, &whose, &bind, scope, found);
    if pass.dispatch.is_none() && !pass.flawed {
        found.push(missing_dispatch(pass, &whose, &bind, scope));
    }
    let dispatched = pass.dispatch.as_ref().and_then(|given| dispatch(given, scope, arguments, found));
    let (dispatch, queue) = dispatched.map_or((None, None), |(dispatch, queue)| (Some(dispatch), queue));
    let every = pass.every.as_ref().and_then(|given| self::every(given, scope, found));
    Pass {
        name: pass.name.clone(),
        request,
        dispatch,
        queue,
        dispatch_mip: pass.dispatch.as_ref().and_then(|given| dispatch_mip(&given.value)),
        in_loop: pass.in_loop.as_ref().and_then(|name| in_loop(name, scope, found)),
        names_loop: pass.in_loop.is_some(),
        bind,
        push: pass.push.as_ref().map(|block| fills(block, scope, found)),
        uniforms: pass.uniforms.iter().map(|block| fills(block, scope, found)).collect(),
        specialization: (pass.specialization.iter())
            .map(|(name, value)| (name.clone(), constant(value, scope, found)))
            .collect(),
        subgroup_size: pass.subgroup_size.as_ref().map(|size| size.value),
        when: pass
            .when
            .as_ref()
            .and_then(|when| condition(when, scope, found))
            .into_iter()
            .chain(pass.also_when.iter().cloned())
            .collect(),
        every,
        // Its clock decides which resources it may write.
        sound: !pass.flawed && every.is_some() == pass.every.is_some(),
    }
}

/// The diagnostic for a pass without `dispatch`, with the first target that it binds as the likely one.
fn missing_dispatch(pass: &model::Pass, whose: &str, bind: &[Bind], scope: &Scope<'_>) -> Diagnostic {
    let mut bound = (bind.iter())
        .filter_map(|entry| entry.target.as_ref())
        .map(|target| &scope.resources[target.value.0.0 as usize].item);
    let target = bound.find(|resource| matches!(resource.kind, ResourceKind::Target(_)));
    let name = target.map_or("NAME", |target| &target.name);
    missing(whose, "dispatch", &pass.name.span)
        .help(format!("e.g. `dispatch = {{ threads = \"{name}\" }}` for one thread per texel of a target"))
}

/// The compiler's request: the file's defines, and one more for each world layout that is bound.
fn request(
    pass: &model::Pass,
    whose: &str,
    bind: &[Bind],
    scope: &Scope<'_>,
    found: &mut Vec<Diagnostic>,
) -> Option<Spanned<Request>> {
    let Some(shader) = &pass.shader else {
        if !pass.flawed {
            found.push(missing(whose, "shader", &pass.name.span));
        }
        return None;
    };
    let Some(path) = join("shaders", &shader.value) else {
        found.push(
            Diagnostic::error(
                codes::files::OUTSIDE_ROOT,
                format!("`{}` is not a path inside the project", shader.value),
            )
            .label(shader.span.clone(), "")
            .help("write it relative to `shaders/`"),
        );
        return None;
    };
    let mut defines: Vec<(String, String)> = Vec::new();
    for (name, text) in &pass.defines {
        if !is_macro_name(&name.value) {
            found.push(
                Diagnostic::error(codes::graph::DEFINE, format!("`{}` cannot be the name of a define", name.value))
                    .label(name.span.clone(), "")
                    .help("a define has letters, digits and `_`, no digit first, no `__` and no `GL_` in front"),
            );
        } else if text.contains(['\n', '\r', '\0']) {
            found.push(
                Diagnostic::error(codes::graph::DEFINE, format!("define `{}` has more than one line", name.value))
                    .label(name.span.clone(), ""),
            );
        } else {
            defines.push((name.value.clone(), text.clone()));
        }
    }
    for entry in bind {
        let Some(target) = &entry.target else { continue };
        let source = scope.resources[target.value.0.0 as usize].item.kind.supplied_by();
        if let Some(layout) = source.and_then(layout_of) {
            let define = layout_define(layout, &entry.name.value);
            // A name that is no macro name is no name of a binding either; the comparison with the shader reports that.
            if is_macro_name(&define) {
                defines.push((define, "1".to_owned()));
            }
        }
    }
    defines.sort();
    defines.dedup();
    let entry = pass.entry.as_ref().map_or("main", |entry| &entry.value).to_owned();
    Some(Spanned::new(Request { path, entry, defines }, shader.span.clone()))
}

/// The define by which an include knows the layout of a binding: that of `world` for `<raxel/world.glsl>`, of any other one for
/// `<raxel/world/BINDING.glsl>`.
fn layout_define(layout: &str, binding: &str) -> String {
    let layout = layout.to_uppercase();
    if binding == "world" { format!("RX_LAYOUT_{layout}") } else { format!("RX_LAYOUT_{layout}_{binding}") }
}

fn is_macro_name(name: &str) -> bool {
    let first = name.bytes().next().is_some_and(|b| b.is_ascii_alphabetic() || b == b'_');
    let all = name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
    first && all && name.len() <= 256 && !name.contains("__") && !name.starts_with("GL_")
}

fn bind(entry: &model::Bind, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Bind {
    Bind {
        name: entry.name.clone(),
        target: entry.target.as_ref().and_then(|target| reference(target, scope, found)),
        mip: entry.mip.clone(),
        layer: entry.layer.clone(),
        linear: entry.filter.clone().map(|filter| Spanned::new(filter.value == Filter::Linear, filter.span)),
        repeat: entry.wrap.clone().map(|wrap| Spanned::new(wrap.value == Wrap::Repeat, wrap.span)),
        partial: entry
            .partial
            .as_ref()
            .filter(|partial| partial.value)
            .map(|partial| Spanned::new((), partial.span.clone())),
    }
}

/// A resource of this frame or an earlier one, e.g. `color@1`.
fn reference(
    name: &Spanned<String>,
    scope: &Scope<'_>,
    found: &mut Vec<Diagnostic>,
) -> Option<Spanned<(ResourceId, u32)>> {
    let (plain, age) = age(&name.value);
    let id = scope.resource(plain, &name.span, found)?;
    let declared = &scope.resources[id.0 as usize];
    let history = declared.item.history;
    match age {
        Some(age) if age <= history => return Some(Spanned::new((id, age), name.span.clone())),
        // A history that could not be read decides nothing.
        Some(_) if !declared.sound => {}
        Some(_) if declared.item.kind.supplied_by().is_some() => found.push(
            Diagnostic::error(codes::graph::HISTORY, format!("`{plain}` comes from outside and has no earlier frames"))
                .label(name.span.clone(), "an earlier frame")
                .label(declared.detail.clone(), "supplied by this source")
                .help(format!("write `{plain}`")),
        ),
        Some(age) => found.push(
            Diagnostic::error(
                codes::graph::HISTORY,
                format!("`{}` is {age} frames old, but `{plain}` keeps {history}", name.value),
            )
            .label(name.span.clone(), "older than the oldest copy")
            .label(declared.item.place.clone(), "declared here")
            .help(format!("give `{plain}` the key `history = {age}`")),
        ),
        None => found.push(
            Diagnostic::error(codes::graph::HISTORY, format!("`{}` names no earlier frame", name.value))
                .label(name.span.clone(), "a number of frames, at least 1, follows `@`")
                .help(format!("write `{plain}` for this frame, `{plain}@1` for the last")),
        ),
    }
    None
}

fn dispatch(
    given: &Spanned<model::Dispatch>,
    scope: &Scope<'_>,
    arguments: Option<ResourceId>,
    found: &mut Vec<Diagnostic>,
) -> Option<(Spanned<checked::Dispatch>, Option<Queue>)> {
    let mut queue = None;
    let dispatch = match &given.value {
        model::Dispatch::Threads(threads) => checked::Dispatch::Threads(*threads),
        model::Dispatch::Groups(groups) => checked::Dispatch::Groups(*groups),
        model::Dispatch::ThreadsOf { target, .. } if target.value == "world" => checked::Dispatch::ThreadsOfWorld,
        model::Dispatch::ThreadsOf { target, mip } => match (counted(target, mip.value, scope, found)?, mip.value) {
            ((id, true), Mip::Level(mip)) => checked::Dispatch::ThreadsOf { target: id, mip },
            // The loop decides which one a round covers.
            ((id, true), Mip::Round(index)) => checked::Dispatch::ThreadsOf { target: id, mip: index.at(0) },
            ((id, false), _) => checked::Dispatch::ElementsOf { buffer: id },
        },
        model::Dispatch::GroupsOf { target, tile, mip } => {
            let target = of_kind(target, scope, "target", found)?;
            let mip = match mip.value {
                Mip::Level(mip) => mip,
                Mip::Round(index) => index.at(0),
            };
            checked::Dispatch::GroupsOf { target, mip, tile: *tile }
        }
        model::Dispatch::Indirect { buffer, offset } => {
            let id = of_kind(buffer, scope, "buffer", found)?;
            checked::Dispatch::Indirect { buffer: id, offset: offset.value }
        }
        model::Dispatch::Queue { buffer, offset } => {
            let id = of_kind(buffer, scope, "buffer", found)?;
            queue = Some(Queue { buffer: id, offset: offset.value });
            checked::Dispatch::Indirect { buffer: arguments?, offset: 0 }
        }
    };
    Some((Spanned::new(dispatch, given.span.clone()), queue))
}

/// The resource that counts the threads: a target (true), or a buffer that has elements (false).
fn counted(
    name: &Spanned<String>,
    mip: Mip,
    scope: &Scope<'_>,
    found: &mut Vec<Diagnostic>,
) -> Option<(ResourceId, bool)> {
    let id = scope.resource(&name.value, &name.span, found)?;
    let declared = &scope.resources[id.0 as usize];
    let ResourceKind::Buffer(_) = &declared.item.kind else {
        return of_kind(name, scope, "target", found).map(|id| (id, true));
    };
    if mip != Mip::Level(0) {
        let mip = match mip {
            Mip::Level(mip) => mip.to_string(),
            Mip::Round(index) => index.name().to_owned(),
        };
        let message = format!("`{}` is a buffer, which has no mip {mip}", name.value);
        found.push(
            Diagnostic::error(codes::graph::WRONG_KIND, message)
                .label(name.span.clone(), "only a target has mips")
                .label(declared.item.place.clone(), "declared here"),
        );
        return None;
    }
    elements(id, name, scope, found).then_some((id, false))
}

/// Whether the elements of a buffer can be counted. A mistake in its declaration is reported there.
pub(crate) fn elements(id: ResourceId, name: &Spanned<String>, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> bool {
    let declared = &scope.resources[id.0 as usize];
    let counted = matches!(&declared.item.kind, ResourceKind::Buffer(buffer) if buffer.size.stride().is_some());
    if !counted && declared.sound {
        found.push(no_elements(name, &declared.detail));
    }
    counted
}

fn dispatch_mip(given: &model::Dispatch) -> Option<Spanned<RoundIndex>> {
    let (model::Dispatch::ThreadsOf { mip, .. } | model::Dispatch::GroupsOf { mip, .. }) = given else { return None };
    let Mip::Round(index) = mip.value else { return None };
    Some(Spanned::new(index, mip.span.clone()))
}

fn in_loop(name: &Spanned<String>, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Option<Spanned<LoopId>> {
    if let Some(id) = scope.loop_names.get(&name.value) {
        return Some(Spanned::new(LoopId(*id), name.span.clone()));
    }
    let known = scope.loop_names.keys().map(String::as_str);
    found.push(unknown(codes::graph::UNKNOWN_LOOP, "loop", &name.value, &name.span, known));
    None
}

/// A resource that must be a target or must be a buffer.
pub(crate) fn of_kind(
    name: &Spanned<String>,
    scope: &Scope<'_>,
    kind: &str,
    found: &mut Vec<Diagnostic>,
) -> Option<ResourceId> {
    let id = scope.resource(&name.value, &name.span, found)?;
    let Declared { item: declared, detail, sound, .. } = &scope.resources[id.0 as usize];
    let is = match declared.kind {
        ResourceKind::Target(_) => "target",
        ResourceKind::Buffer(_) => "buffer",
    };
    if is == kind {
        // A target is named here for its extent. That of a copy is known once a plan is made.
        let outside = matches!(&declared.kind, ResourceKind::Target(target) if target.extent == Extent::Source);
        if outside && *sound && declared.copied_from().is_none() {
            found.push(extent_from_outside(name, detail));
            return None;
        }
        return Some(id);
    }
    found.push(
        Diagnostic::error(codes::graph::WRONG_KIND, format!("`{}` is a {is}, not a {kind}", name.value))
            .label(name.span.clone(), format!("a {kind} is needed here"))
            .label(declared.place.clone(), format!("declared as a {is}")),
    );
    None
}

fn every(given: &Spanned<model::Every>, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Option<Every> {
    Some(match &given.value {
        model::Every::Hz(hz) => Every::Hz(*hz),
        model::Every::Frames(frames) => Every::Frames(*frames),
        model::Every::Still(frames) => Every::Still(*frames),
        model::Every::Clock(name) => Every::Clock(scope.clock(name, &given.span, found)?),
    })
}
