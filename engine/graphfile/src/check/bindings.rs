//! Every GLSL name is bound to a resource of the right kind, and every entry of `bind` is a GLSL name that the shader uses.

use raxel_diagnostics::names::closest;
use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::{BoundAccess, BufferSize, Interval, Resource, ResourceKind, Usage, Values};
use raxel_graph::index32;
use raxel_graph::value::{ValueType, glsl};
use raxel_shader::interface::{Access, Binding, BindingKind, Block, Member, Type};

use super::given::Given;
use super::{Context, images, sources};
use crate::resolve::{Bind, Declared};

/// Checks all bindings of a pass; gives the accesses that they are.
pub(crate) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) -> Vec<BoundAccess> {
    let bindings = &context.interface().bindings;
    let entries = &context.pass.bind;
    let mut accesses = Vec::with_capacity(entries.len());
    let misspelt = unused(context, &mut accesses, found);
    for (index, binding) in bindings.iter().enumerate() {
        if !supported(context, binding, found) {
            continue;
        }
        let filled = context.pass.uniforms.iter().find(|block| block.name.value == binding.name);
        let shared = block(binding).filter(|_| matches!(binding.kind, BindingKind::UniformBuffer(_)));
        let shared = shared.and_then(|block| Given::shared(context.graph, &binding.name, &block.name));
        let entry = entries.iter().find(|entry| entry.name.value == binding.name);
        match (entry, filled) {
            (Some(entry), Some(block)) => found.push(
                Diagnostic::error(
                    codes::files::CONFLICTING_KEYS,
                    format!("`{}` is both bound to a resource and filled as a uniform block", binding.name),
                )
                .label(entry.name.span.clone(), "bound here")
                .label(block.name.span.clone(), "filled here"),
            ),
            (Some(entry), None) => accesses.extend(bound(context, index32(index), binding, entry, found)),
            (None, Some(_)) => {}
            (None, None) if shared.is_some() => {}
            (None, None) if misspelt.contains(&binding.name.as_str()) => {}
            (None, None) => unbound(context, binding, found),
        }
    }
    accesses
}

/// Reports entries that the shader has no use for; gives the names that they are likely meant to be. The accesses that an entry would have
/// if the shader used it go to `accesses`.
fn unused<'c>(context: &'c Context<'_>, accesses: &mut Vec<BoundAccess>, found: &mut Vec<Diagnostic>) -> Vec<&'c str> {
    let interface = context.interface();
    let entries = &context.pass.bind;
    let of_name = |bindings: &'c [Binding], name: &str| bindings.iter().find(|binding| binding.name == name);
    let mut meant = Vec::new();
    for entry in entries.iter().filter(|entry| of_name(&interface.bindings, &entry.name.value).is_none()) {
        let name = entry.name.value.as_str();
        let shader = &context.shader.request.path;
        let bound_for = format!("bound for pass `{}`", context.pass.name.value);
        if let Some(declared) = of_name(&interface.unused.bindings, name) {
            let message = format!("`{shader}` declares `{name}` and does not use it");
            let diagnostic =
                context.unused(codes::graph::BIND_UNUSED, message).label(entry.name.span.clone(), bound_for);
            let diagnostic = context.in_shader(diagnostic, declared.place.as_ref(), "declared here, without a use");
            found.push(diagnostic.help(format!("use `{name}` in the shader, or take the entry out")));
            // Not bound to anything, but there. An entry that does not suit the declaration is an error once the shader uses it.
            let access = bound(context, 0, declared, entry, &mut Vec::new());
            accesses.extend(access.map(|access| BoundAccess { binding: None, ..access }));
            continue;
        }
        let message = format!("`{shader}` has no binding `{name}`");
        if let Some(binding) = nearest(context, entry) {
            meant.push(binding.name.as_str());
            let diagnostic =
                Diagnostic::error(codes::graph::BIND_UNUSED, message).label(entry.name.span.clone(), bound_for);
            let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), "bound to nothing");
            found.push(diagnostic.help(format!("did you mean `{}`?", binding.name)));
            continue;
        }
        let diagnostic = context.unused(codes::graph::BIND_UNUSED, message).label(entry.name.span.clone(), bound_for);
        found.push(diagnostic.help(format!("declare `{name}` in the shader and use it, or take the entry out")));
    }
    meant
}

/// The binding without an entry that an entry without a binding is likely meant for.
fn nearest<'c>(context: &'c Context<'_>, entry: &Bind) -> Option<&'c Binding> {
    let entries = &context.pass.bind;
    let given = |name: &str| {
        entries.iter().any(|entry| entry.name.value == name)
            || context.pass.uniforms.iter().any(|block| block.name.value == name)
    };
    let free = || context.interface().bindings.iter().filter(move |binding| !given(&binding.name));
    let name = entry.name.value.as_str();
    // A block may also be named by its type where its instance name is needed.
    let by_type = free().find(|binding| block(binding).is_some_and(|block| block.name == name));
    let close = || {
        let close = closest(name, free().map(|binding| binding.name.as_str()))?;
        free().find(|binding| binding.name == close)
    };
    // One that was renamed: the only binding without an entry, for the only entry without a binding.
    let renamed = || {
        let interface = context.interface();
        let declared = |name: &str| {
            interface.bindings.iter().chain(&interface.unused.bindings).any(|binding| binding.name == name)
        };
        let strays = entries.iter().filter(|entry| !declared(&entry.name.value)).count();
        let mut fitting = free().filter(|binding| fits(context, binding, entry));
        fitting.next().filter(|_| strays == 1 && fitting.next().is_none())
    };
    by_type.or_else(close).or_else(renamed)
}

/// Whether the resource of an entry is of the kind that a binding takes.
fn fits(context: &Context<'_>, binding: &Binding, entry: &Bind) -> bool {
    let Some(target) = &entry.target else { return false };
    match context.graph.resources[target.value.0.0 as usize].item.kind {
        ResourceKind::Target(_) => {
            matches!(binding.kind, BindingKind::StorageImage { .. } | BindingKind::SampledImage { .. })
        }
        ResourceKind::Buffer(_) => matches!(binding.kind, BindingKind::StorageBuffer(_)),
    }
}

fn block(binding: &Binding) -> Option<&Block> {
    match &binding.kind {
        BindingKind::StorageBuffer(block) | BindingKind::UniformBuffer(block) => Some(block),
        _ => None,
    }
}

/// Whether raxel binds such a thing at all.
fn supported(context: &Context<'_>, binding: &Binding, found: &mut Vec<Diagnostic>) -> bool {
    let pass = &context.pass.name;
    let (code, message, label) = match &binding.kind {
        BindingKind::Unsupported(what) => (
            codes::graph::UNSUPPORTED_BINDING,
            format!("`{}` is `{what}`, which a graph cannot bind", binding.name),
            "images, samplers with their image, storage and uniform blocks can be bound",
        ),
        _ if binding.count != 1 => {
            let length = if binding.count == 0 { String::new() } else { binding.count.to_string() };
            (
                codes::graph::DESCRIPTOR_ARRAY,
                format!("`{}[{length}]` is an array of bindings, which a graph cannot bind", binding.name),
                "declare them one by one, or use the layers of one image",
            )
        }
        _ => return true,
    };
    let diagnostic = Diagnostic::error(code, message);
    // Nothing in the graph is wrong here, so the shader's place comes first.
    let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), label);
    found.push(diagnostic.label(pass.span.clone(), format!("used by pass `{}`", pass.value)));
    false
}

fn unbound(context: &Context<'_>, binding: &Binding, found: &mut Vec<Diagnostic>) {
    let pass = &context.pass;
    // An entry that could not be read is reported already.
    if !pass.sound {
        return;
    }
    let name = &binding.name;
    let diagnostic = Diagnostic::error(
        codes::graph::UNBOUND,
        format!("the shader's `{name}` is bound to nothing in pass `{}`", pass.name.value),
    )
    .label(pass.name.span.clone(), format!("`bind` has no `{name}`"));
    let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), "declared here");
    found.push(match &binding.kind {
        BindingKind::UniformBuffer(_) => diagnostic
            .help(format!("fill it with `[passes.uniforms.{name}]`, or bind a buffer: `bind = {{ {name} = \"…\" }}`")),
        _ => diagnostic.help(format!("add `{name} = \"…\"` to `bind`")),
    });
}

/// One entry held against its binding.
fn bound(
    context: &Context<'_>,
    index: u32,
    binding: &Binding,
    entry: &Bind,
    found: &mut Vec<Diagnostic>,
) -> Option<BoundAccess> {
    let target = entry.target.as_ref()?;
    let (id, age) = target.value;
    let declared = &context.graph.resources[id.0 as usize];
    let errors = |found: &[Diagnostic]| found.iter().filter(|diagnostic| diagnostic.is_error()).count();
    let before = errors(found);
    writable(context, binding, entry, found);
    let access = match (&declared.item.kind, &binding.kind) {
        (ResourceKind::Target(image), BindingKind::StorageImage { .. } | BindingKind::SampledImage { .. }) => {
            images::check(context, index, binding, entry, image, found)?
        }
        (ResourceKind::Buffer(_), BindingKind::StorageBuffer(block) | BindingKind::UniformBuffer(block)) => {
            for (key, place) in [
                ("mip", entry.mip.as_ref().map(|v| &v.span)),
                ("layer", entry.layer.as_ref().map(|v| &v.span)),
                ("filter", entry.linear.as_ref().map(|v| &v.span)),
                ("wrap", entry.repeat.as_ref().map(|v| &v.span)),
            ] {
                if let Some(place) = place {
                    let message = format!("`{}` is a buffer, which has no `{key}`", declared.item.name);
                    found.push(
                        Diagnostic::error(codes::graph::WRONG_KIND, message)
                            .label(place.clone(), "only a target has one")
                            .label(declared.item.place.clone(), "declared here"),
                    );
                }
            }
            if declared.sound {
                layout(context, binding, block, entry, found);
            }
            let uniform = matches!(binding.kind, BindingKind::UniformBuffer(_));
            BoundAccess {
                resource: id,
                age,
                mips: Interval::one(0),
                layers: Interval::one(0),
                access: if uniform { Access::Read } else { binding.access },
                usage: if uniform { Usage::UniformBuffer } else { Usage::StorageBuffer },
                binding: Some(index),
                sampler: None,
            }
        }
        (kind, _) => {
            let is = if matches!(kind, ResourceKind::Target(_)) { "target" } else { "buffer" };
            let needs = match &binding.kind {
                BindingKind::StorageBuffer(_) => "a buffer block",
                BindingKind::UniformBuffer(_) => "a uniform block",
                _ => "an image",
            };
            let diagnostic = Diagnostic::error(
                codes::graph::WRONG_KIND,
                format!("`{}` is {needs} in the shader, but `{}` is a {is}", binding.name, declared.item.name),
            )
            .label(target.span.clone(), format!("a {is}"));
            let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), needs);
            found.push(diagnostic.label(declared.item.place.clone(), "declared here"));
            return None;
        }
    };
    let access = partial(context, binding, entry, access, found);
    (errors(found) == before).then_some(access)
}

/// A partial store lets earlier contents show through: to every later phase it is a load as well as a store.
fn partial(
    context: &Context<'_>,
    binding: &Binding,
    entry: &Bind,
    access: BoundAccess,
    found: &mut Vec<Diagnostic>,
) -> BoundAccess {
    let Some(partial) = &entry.partial else { return access };
    if access.access.writes() {
        return BoundAccess { access: Access::ReadWrite, ..access };
    }
    let diagnostic = Diagnostic::error(
        codes::graph::PARTIAL,
        format!("the shader only reads `{}`, and `partial` is about stores", binding.name),
    )
    .label(partial.span.clone(), "nothing is stored through this binding");
    found.push(context.in_shader(diagnostic, binding.place.as_ref(), "declared here").help("take `partial` out"));
    access
}

/// Earlier frames and sources are only read.
fn writable(context: &Context<'_>, binding: &Binding, entry: &Bind, found: &mut Vec<Diagnostic>) {
    let Some(target) = entry.target.as_ref().filter(|_| writes(binding)) else { return };
    let (id, age) = target.value;
    let resource = &context.graph.resources[id.0 as usize].item;
    let why = if age > 0 {
        "an earlier frame cannot be changed"
    } else if !resource.is_writable() {
        "no pass can change a resource with a `source`"
    } else if resource.kind.values().is_some() {
        "no pass can change `values` of the graph's file"
    } else {
        return;
    };
    let (name, what) =
        (&binding.name, if age > 0 { format!("{}@{age}", resource.name) } else { resource.name.clone() });
    let diagnostic = Diagnostic::error(
        codes::graph::READ_ONLY,
        format!("the shader may write `{name}`, but `{what}` can only be read"),
    )
    .label(target.span.clone(), why);
    let text = if binding.access == Access::Write { "declared `writeonly`" } else { "not declared `readonly`" };
    let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), text);
    found.push(match binding.access {
        Access::Write => diagnostic,
        _ => diagnostic.help(format!("declare `{name}` as `readonly` if the shader only reads it")),
    });
}

fn writes(binding: &Binding) -> bool {
    matches!(binding.kind, BindingKind::StorageImage { .. } | BindingKind::StorageBuffer(_)) && binding.access.writes()
}

/// Whether a buffer has the bytes that a block needs, in the layout of the block.
fn layout(context: &Context<'_>, binding: &Binding, block: &Block, entry: &Bind, found: &mut Vec<Diagnostic>) {
    let Some(target) = &entry.target else { return };
    let declared = &context.graph.resources[target.value.0.0 as usize];
    let ResourceKind::Buffer(buffer) = &declared.item.kind else { return };
    if let (Some(name), true) = (declared.item.collected_as(), context.first_use) {
        return sources::check(context, binding, block, name, declared, found);
    }
    match &buffer.size {
        // The layout is a define of the shader, so another pass with the same shader has the same difference.
        BufferSize::Source(source) if context.first_use => {
            sources::check(context, binding, block, source, declared, found);
        }
        size if size.fixed_bytes().is_some_and(|bytes| bytes < u64::from(block.size)) => {
            let bytes = size.fixed_bytes().unwrap_or(0);
            let diagnostic = Diagnostic::error(
                codes::graph::BUFFER_SIZE,
                format!(
                    "buffer `{}` has {bytes} bytes, but the shader's `{}` needs {}",
                    declared.item.name, binding.name, block.size
                ),
            )
            .label(declared.detail.clone(), "the size");
            let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), "the block");
            found.push(diagnostic.label(target.span.clone(), "bound here"));
        }
        _ => {}
    }
    if let (Some(values), [member]) = (declared.item.kind.values(), block.members.as_slice()) {
        element_type(context, (binding, member), entry, (values, declared), found);
    }
    // Only a block that is one runtime array has elements that the file's `stride` can mean.
    let [member] = block.members.as_slice() else { return };
    let Type::Array { element, len: None, stride } = &member.ty else { return };
    if let Some(declared_stride) = buffer.size.stride().filter(|of_file| declared.sound && of_file != stride) {
        let diagnostic = Diagnostic::error(
            codes::graph::BUFFER_STRIDE,
            format!(
                "an element of buffer `{}` has {declared_stride} bytes, but one of the shader's `{}` has {stride}",
                declared.item.name, binding.name
            ),
        )
        .label(declared.detail.clone(), "the size");
        let place = member.place.as_ref().or(binding.place.as_ref());
        let diagnostic = context.in_shader(diagnostic, place, format!("elements of type `{}`", glsl(element)));
        found.push(diagnostic.help(other_stride(&buffer.size, declared_stride, *stride)));
    }
}

/// Advice that gives the elements the size of the shader's, and keeps the bytes if they are a whole number of elements.
fn other_stride(size: &BufferSize, declared: u32, wanted: u32) -> String {
    let as_many = format!("`stride = {wanted}`");
    let times = declared.checked_div(wanted).filter(|times| *times > 1 && declared.is_multiple_of(wanted));
    let same_bytes = times.and_then(|times| match size {
        BufferSize::Elements { count, .. } => {
            Some(format!("`count = {}, stride = {wanted}`", count * u64::from(times)))
        }
        BufferSize::Of { per, .. } | BufferSize::World { per, .. } => {
            Some(format!("`per = {}, stride = {wanted}`", per * times))
        }
        BufferSize::Bytes(_) | BufferSize::Source(_) | BufferSize::Values(_) => None,
    });
    match same_bytes {
        Some(same) => {
            format!("write {same} for the same number of bytes, or {as_many} for as many elements in fewer bytes")
        }
        None => format!("write {as_many}"),
    }
}

/// The values that a file writes are of the type that the shader reads.
fn element_type(
    context: &Context<'_>,
    (binding, member): (&Binding, &Member),
    entry: &Bind,
    (values, declared): (&Values, &Declared<Resource>),
    found: &mut Vec<Diagnostic>,
) {
    let Type::Array { element, .. } = &member.ty else { return };
    if !declared.sound || ValueType::of_member(element).is_some_and(|ty| values.ty.fits(ty)) {
        return;
    }
    let name = &declared.item.name;
    let (of_file, of_shader) = (values.ty.word(), glsl(element));
    let diagnostic = Diagnostic::error(
        codes::graph::VALUE_TYPE,
        format!(
            "a value of buffer `{name}` is `{of_file}`, but an element of the shader's `{}` is `{of_shader}`",
            binding.name
        ),
    )
    .label(declared.detail.clone(), format!("values of type `{of_file}`"));
    let place = member.place.as_ref().or(binding.place.as_ref());
    let diagnostic =
        context.in_shader(diagnostic, place, "the shader says").label(entry.name.span.clone(), "bound here");
    found.push(match ValueType::of_member(element) {
        Some(ty) => diagnostic.help(format!("give the buffer the key `type = \"{}\"`", ty.word())),
        None => diagnostic,
    });
}
