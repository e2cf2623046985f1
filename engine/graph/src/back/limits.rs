//! Limits: mistakes that only an output size and a device can show.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Code, Diagnostic, codes};

use crate::back::cull::Cull;
use crate::back::needs;
use crate::back::sizes::{self, groups, local_size, specialization};
use crate::ir::checked::{
    BoundAccess, BufferSize, Dispatch, Extent, Graph, Pass, Resource, ResourceId, ResourceKind, Target, Value,
    ValueOrigin,
};
use crate::ir::plan::{DeviceLimits, PlanInput};
use crate::ir::size::{Size, full_chain};

/// Checks that the present point exists.
pub(crate) fn check_present(graph: &Graph, sizes: &[Size], input: &PlanInput) -> Result<(), Vec<Diagnostic>> {
    let present = input.present;
    let resource = graph.resource(present.resource);
    let mut found = Vec::new();
    let mut missing = |what: &str, asked: u32, there: u32| {
        if asked >= there {
            let range = if there == 1 { "only 0".to_owned() } else { format!("0 to {}", there - 1) };
            found.push(
                Diagnostic::error(
                    codes::graph::PRESENT_OUT_OF_RANGE,
                    format!("`{}` has no {what} {asked} to show: it has {range}", resource.name),
                )
                .label(resource.place.clone(), "declared here"),
            );
        }
    };
    missing("earlier frame", present.age, resource.history + 1);
    let made = is_made(resource, input);
    if let (Size::Image { mips, layers, .. }, true) = (sizes[present.resource.0 as usize], made) {
        missing("mip", present.mip, mips);
        let slices = sizes[present.resource.0 as usize].texels(present.mip).map_or(layers, |[_, _, slices]| slices);
        missing("layer", present.layer, slices);
    }
    if found.is_empty() { Ok(()) } else { Err(found) }
}

/// Checks the created resources and the dispatches against the limits of the device.
pub(crate) fn check(
    graph: &Graph,
    sizes: &[Size],
    materials: &[u32],
    input: &PlanInput,
    cull: &Cull,
) -> Result<(), Vec<Diagnostic>> {
    let mut found = Vec::new();
    for &id in &cull.used {
        created(graph, graph.resource(id), sizes[id.0 as usize], input, &mut found);
    }
    for &id in &cull.live {
        let pass = graph.pass(id);
        let before = found.len();
        let constants = specialization(pass, sizes, materials);
        dispatch(pass, sizes, (&constants, input.world.extent), &input.limits, &mut found);
        unknown_materials(graph, pass, input.world.materials, &mut found);
        blocks(pass, &input.limits, &mut found);
        bindings(pass, &input.limits, &mut found);
        for access in &pass.accesses {
            if is_made(graph.resource(access.resource), input) {
                subresources(graph, pass, access, sizes, &mut found);
            }
        }
        if let Dispatch::Indirect { buffer, offset } = pass.dispatch {
            let (buffer, offset, counts) = match graph.queue_of(buffer) {
                Some((queue, offset)) => (queue, u64::from(offset), (4, "the number of its threads")),
                None => (buffer, offset, (12, "12 bytes of workgroup counts")),
            };
            arguments(graph, pass, (buffer, offset), counts, sizes, &mut found);
        }
        if pass.round.is_some() {
            each_mistake_in_one_round(&mut found, before);
        }
    }
    if found.is_empty() { Ok(()) } else { Err(found) }
}

/// Whether the device can create a resource.
pub(crate) fn fits(graph: &Graph, resource: &Resource, size: Size, input: &PlanInput) -> bool {
    let mut found = Vec::new();
    created(graph, resource, size, input, &mut found);
    found.is_empty()
}

fn created(graph: &Graph, resource: &Resource, size: Size, input: &PlanInput, found: &mut Vec<Diagnostic>) {
    if !is_made(resource, input) {
        return;
    }
    match size {
        Size::Image { extent, volume, mips, layers } => {
            image(graph, resource, (extent, volume, mips, layers), input, found);
        }
        Size::Buffer { bytes, elements } => {
            buffer(graph, resource, (bytes, elements), input, found);
            found.extend(bytes.and_then(|bytes| warned_beyond(resource, bytes)));
        }
    }
}

/// A pass of a loop is often wrong in every round. Mistakes with the same code and places are reported for the first round only.
fn each_mistake_in_one_round(found: &mut Vec<Diagnostic>, before: usize) {
    let of_round = found.split_off(before);
    let places = |diagnostic: &Diagnostic| diagnostic.labels.iter().map(|label| label.span.clone()).collect::<Vec<_>>();
    let same = |known: &Diagnostic, new: &Diagnostic| known.code == new.code && places(known) == places(new);
    found.extend(
        of_round.into_iter().filter(|new| !found[..before].iter().any(|known| same(known, new))).collect::<Vec<_>>(),
    );
}

/// Whether its extent is known: that of an image from outside is not before its supplier has made it.
fn is_made(resource: &Resource, input: &PlanInput) -> bool {
    match &resource.kind {
        ResourceKind::Target(Target { extent: Extent::Source, .. }) => {
            sizes::supplied(resource, input.sources).is_some_and(|source| source.image.is_some())
        }
        _ => true,
    }
}

fn image(
    graph: &Graph,
    resource: &Resource,
    (extent, volume, mips, layers): ([u32; 3], bool, u32, u32),
    input: &PlanInput,
    found: &mut Vec<Diagnostic>,
) {
    let [w, h, d] = extent;
    let shown = if volume { format!("{w}×{h}×{d}") } else { format!("{w}×{h}") };
    let base = base(graph, resource);
    let here = match base {
        Some(Base::Output) => format!("{shown} at this output size"),
        Some(Base::World) => format!("{shown} for this world"),
        None => format!("{shown} texels"),
    };
    let (limit, name) = if volume {
        (input.limits.image_3d, "maxImageDimension3D")
    } else {
        (input.limits.image_2d, "maxImageDimension2D")
    };
    if extent.into_iter().max().unwrap_or(1) > limit {
        let diagnostic = Diagnostic::error(
            codes::graph::TARGET_TOO_LARGE,
            format!("`{}` would be {shown} texels, but the device allows {limit} on an axis", resource.name),
        )
        .label(resource.place.clone(), here.clone())
        .note(format!("the limit is `{name}` = {limit}"));
        found.push(note_base(diagnostic, base, input));
    }
    if layers > input.limits.image_layers {
        let limit = input.limits.image_layers;
        found.push(over(
            codes::graph::TOO_MANY_LAYERS,
            resource,
            format!("`{}` has {layers} layers, but the device allows {limit}", resource.name),
            ("maxImageArrayLayers", limit.into()),
        ));
    }
    let chain = full_chain(extent);
    if mips > chain {
        found.push(
            Diagnostic::error(
                codes::graph::TOO_MANY_MIPS,
                format!("`{}` has {mips} mips, but {shown} texels have only {chain} down to one", resource.name),
            )
            .label(resource.place.clone(), here)
            .help("`mips = \"full\"` is the full chain at every size"),
        );
    }
}

/// The extent that a size follows, at the end of the chain of `of`.
#[derive(Clone, Copy)]
enum Base {
    Output,
    World,
}

fn base(graph: &Graph, resource: &Resource) -> Option<Base> {
    let mut kind = &resource.kind;
    for _ in 0..=graph.resources.len() {
        let next = match kind {
            ResourceKind::Target(target) => match target.extent {
                Extent::Output { .. } => return Some(Base::Output),
                Extent::World { .. } => return Some(Base::World),
                Extent::Of { target, .. } => target,
                Extent::Fixed2(_) | Extent::Fixed3(_) | Extent::Source => return None,
            },
            ResourceKind::Buffer(buffer) => match buffer.size {
                BufferSize::World { .. } => return Some(Base::World),
                BufferSize::Of { of, .. } => of,
                BufferSize::Bytes(_) | BufferSize::Elements { .. } | BufferSize::Source(_) | BufferSize::Values(_) => {
                    return None;
                }
            },
        };
        kind = &graph.resource(next).kind;
    }
    None
}

fn note_base(diagnostic: Diagnostic, base: Option<Base>, input: &PlanInput) -> Diagnostic {
    match base {
        Some(Base::Output) => {
            let [x, y] = input.output;
            diagnostic.note(format!("the output is {x}×{y} pixels"))
        }
        Some(Base::World) => {
            let [x, y, z] = input.world.extent;
            diagnostic
                .note(format!("the world is {x}×{y}×{z} voxels"))
                .help("a smaller `scale` follows a world of this extent too")
        }
        None => diagnostic,
    }
}

fn buffer(
    graph: &Graph,
    resource: &Resource,
    (bytes, elements): (Option<u64>, u64),
    input: &PlanInput,
    found: &mut Vec<Diagnostic>,
) {
    let Some(bytes) = bytes else { return };
    let limit = input.limits.storage_buffer;
    if bytes > limit {
        let mut diagnostic = over(
            codes::graph::BUFFER_TOO_LARGE,
            resource,
            format!("`{}` would be {bytes} bytes, but the device allows {limit}", resource.name),
            ("maxStorageBufferRange", limit),
        );
        if let ResourceKind::Buffer(buffer) = &resource.kind {
            match &buffer.size {
                BufferSize::Of { of, per, stride } => {
                    let of = graph.resource(*of);
                    let each = if matches!(of.kind, ResourceKind::Target(_)) { "texel" } else { "element" };
                    let bytes = u64::from(*per) * u64::from(*stride);
                    diagnostic = diagnostic.label(of.place.clone(), format!("{bytes} bytes for each {each} of this"));
                }
                BufferSize::World { stride, .. } => {
                    diagnostic = diagnostic.note(format!("it has {elements} elements of {stride} bytes"));
                }
                BufferSize::Source(name) => {
                    diagnostic = diagnostic.note(format!("`{name}` supplies it; a smaller world has fewer bytes"));
                }
                BufferSize::Bytes(_) | BufferSize::Elements { .. } | BufferSize::Values(_) => {}
            }
        }
        found.push(note_base(diagnostic, base(graph, resource), input));
    }
}

/// The first warning of a buffer that counts beyond its end.
fn warned_beyond(resource: &Resource, bytes: u64) -> Option<Diagnostic> {
    let warning = resource.warnings.iter().find(|warning| warning.offset + 4 > bytes)?;
    let (name, offset) = (&resource.name, warning.offset);
    let message = format!("a warning of `{name}` counts at offset {offset}, but `{name}` has {bytes} bytes");
    let diagnostic = Diagnostic::error(codes::graph::WARNING_OUT_OF_RANGE, message)
        .label(warning.place.clone(), "this offset")
        .label(resource.place.clone(), "declared here");
    Some(match bytes.checked_sub(4).map(|last| last & !3) {
        Some(last) => diagnostic.help(format!("offsets are in bytes; that of the last `uint` is {last}")),
        None => diagnostic,
    })
}

fn over(code: Code, resource: &Resource, message: String, (name, limit): (&str, u64)) -> Diagnostic {
    Diagnostic::error(code, message)
        .label(resource.place.clone(), "declared here")
        .note(format!("the limit is `{name}` = {limit}"))
}

/// Reports the materials that a pass names and the world has not.
fn unknown_materials(graph: &Graph, pass: &Pass, known: Option<&[String]>, found: &mut Vec<Diagnostic>) {
    let Some(known) = known else { return };
    let fills = pass.push.iter().chain(pass.uniforms.iter().flat_map(|block| &block.fills));
    let sources = fills.map(|fill| &fill.from).chain(pass.specialization.iter().map(|(_, source)| source));
    for source in sources {
        let ValueOrigin::Material(at) = source else { continue };
        let Some(material) = graph.materials.get(*at as usize).filter(|named| !known.contains(&named.name)) else {
            continue;
        };
        let message = format!("the world has no material `{}`", material.name);
        let diagnostic = Diagnostic::error(codes::graph::UNKNOWN_MATERIAL, message)
            .label(material.place.clone(), format!("a value of pass `{}`", pass.name));
        // A mention in a block that several passes take is one mistake.
        if found.iter().any(|known| known.message == diagnostic.message && known.labels[0].span == material.place) {
            continue;
        }
        let names = || known.iter().map(String::as_str).filter(|name| !name.is_empty());
        found.push(match closest(&material.name, names()) {
            Some(name) => diagnostic.help(format!("did you mean `material.{name}`?")),
            None if names().count() > 16 => diagnostic.note(format!("it has {} materials", names().count())),
            None => diagnostic.help(format!("it has {}", list(names()))),
        });
    }
}

fn dispatch(
    pass: &Pass,
    sizes: &[Size],
    (constants, world): (&[(u32, Value)], [u32; 3]),
    limits: &DeviceLimits,
    found: &mut Vec<Diagnostic>,
) {
    let local = local_size(pass, constants);
    if local.contains(&0) {
        let [x, y, z] = local;
        found.push(
            Diagnostic::error(
                codes::graph::WORKGROUP,
                format!("the workgroup of pass `{}` is {x} × {y} × {z}: it has no threads", pass.name),
            )
            .label(pass.place.clone(), "with the constants of the graph"),
        );
        return;
    }
    if let Some(groups) = groups(pass, sizes, constants, world, limits) {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let (count, limit) = (groups[axis], limits.workgroup_count[axis]);
            if count > limit {
                found.push(
                    Diagnostic::error(
                        codes::graph::TOO_MANY_WORKGROUPS,
                        format!(
                            "pass `{}` would dispatch {count} workgroups along {name}, but the device allows {limit}",
                            pass.name
                        ),
                    )
                    .label(pass.place.clone(), format!("its local size along {name} is {}", local[axis]))
                    .note(format!("the limit is `maxComputeWorkGroupCount[{axis}]` = {limit}"))
                    .help("use a larger workgroup, or let each thread do more"),
                );
            }
        }
    }
    let (shared, limit) = (needs::shared_bytes(pass, constants), limits.shared_memory);
    if shared > limit.into() {
        found.push(
            Diagnostic::error(
                codes::graph::SHARED_TOO_LARGE,
                format!("pass `{}` shares {shared} bytes in a workgroup, but the device allows {limit}", pass.name),
            )
            .label(pass.place.clone(), format!("by the shared variables of `{}`", pass.shader.request.path))
            .note(format!("the limit is `maxComputeSharedMemorySize` = {limit}"))
            .help("share less: smaller arrays, or a smaller workgroup"),
        );
    }
    let [x, y, z] = local;
    let threads = local.iter().map(|&side| u64::from(side)).product::<u64>();
    let too_long = (0..3).find(|&axis| local[axis] > limits.workgroup_size[axis]);
    let limit = match too_long {
        Some(axis) => Some((format!("maxComputeWorkGroupSize[{axis}]"), limits.workgroup_size[axis])),
        None if threads > limits.workgroup_invocations.into() => {
            Some(("maxComputeWorkGroupInvocations".to_owned(), limits.workgroup_invocations))
        }
        None => None,
    };
    if let Some((name, limit)) = limit {
        found.push(
            Diagnostic::error(
                codes::graph::WORKGROUP_TOO_LARGE,
                format!("pass `{}` has workgroups of {x}×{y}×{z} threads, more than the device allows", pass.name),
            )
            .label(pass.place.clone(), format!("`{}` says {x}×{y}×{z}", pass.shader.request.path))
            .note(format!("the limit is `{name}` = {limit}"))
            .help("use a smaller workgroup: every device allows 128 threads"),
        );
    }
}

fn blocks(pass: &Pass, limits: &DeviceLimits, found: &mut Vec<Diagnostic>) {
    let push = pass.shader.interface.push.as_ref().map_or(0, |block| block.size);
    if push > limits.push_constants {
        let limit = limits.push_constants;
        found.push(
            Diagnostic::error(
                codes::graph::PUSH_TOO_LARGE,
                format!("pass `{}` pushes {push} bytes, but the device allows {limit}", pass.name),
            )
            .label(pass.place.clone(), "pushed by this pass")
            .note(format!("the limit is `maxPushConstantsSize` = {limit}"))
            .help("move large members into a uniform block"),
        );
    }
    for block in &pass.uniforms {
        let limit = limits.uniform_buffer;
        if u64::from(block.size) > limit {
            let name = pass.shader.interface.bindings.get(block.binding as usize).map_or("", |b| b.name.as_str());
            found.push(
                Diagnostic::error(
                    codes::graph::UNIFORM_TOO_LARGE,
                    format!(
                        "uniform block `{name}` of pass `{}` has {} bytes, but the device allows {limit}",
                        pass.name, block.size
                    ),
                )
                .label(pass.place.clone(), "bound by this pass")
                .note(format!("the limit is `maxUniformBufferRange` = {limit}"))
                .help("move large arrays into a storage buffer"),
            );
        }
    }
}

fn bindings(pass: &Pass, limits: &DeviceLimits, found: &mut Vec<Diagnostic>) {
    for (what, count, (name, limit)) in needs::bindings(pass, &limits.bindings) {
        if count > limit {
            let message = format!("pass `{}` binds {count} {what}, but the device allows {limit}", pass.name);
            let mut error = Diagnostic::error(codes::graph::TOO_MANY_BINDINGS, message)
                .label(pass.place.clone(), format!("by the interface of `{}`", pass.shader.request.path))
                .note(format!("the limit is `{name}` = {limit}"))
                .help("split the pass, or put several of them into one");
            if pass.shader.interface.prints.is_some() && what == "storage buffers" {
                error = error.note("one of them takes what the shader prints, or what its checks and records find");
            }
            found.push(error);
        }
    }
}

fn subresources(graph: &Graph, pass: &Pass, access: &BoundAccess, sizes: &[Size], found: &mut Vec<Diagnostic>) {
    let Size::Image { mips, extent: [w, h, _], .. } = sizes[access.resource.0 as usize] else { return };
    let last = access.mips.first.saturating_add(access.mips.count.max(1));
    if last > mips {
        let resource = graph.resource(access.resource);
        found.push(
            Diagnostic::error(
                codes::graph::TOO_MANY_MIPS,
                format!("pass `{}` binds mip {} of `{}`, which has {mips}", pass.name, last - 1, resource.name),
            )
            .label(pass.place.clone(), "bound by this pass")
            .label(resource.place.clone(), format!("{w}×{h} at this output size: mips 0 to {}", mips - 1)),
        );
    }
}

fn arguments(
    graph: &Graph,
    pass: &Pass,
    (buffer, offset): (ResourceId, u64),
    (needed, what): (u64, &str),
    sizes: &[Size],
    found: &mut Vec<Diagnostic>,
) {
    let Some(bytes) = sizes[buffer.0 as usize].bytes() else { return };
    if offset.saturating_add(needed) > bytes {
        let resource = graph.resource(buffer);
        found.push(
            Diagnostic::error(
                codes::graph::ARGUMENTS_OUT_OF_RANGE,
                format!(
                    "pass `{}` reads {what} at offset {offset}, but `{}` has {bytes} bytes",
                    pass.name, resource.name
                ),
            )
            .label(pass.place.clone(), "dispatched here")
            .label(resource.place.clone(), "declared here"),
        );
    }
}
