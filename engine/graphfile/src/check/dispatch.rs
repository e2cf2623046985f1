//! Dispatch: some workgroups, over mips that exist; indirect arguments inside their buffer.

use raxel_diagnostics::{Code, Diagnostic, Severity, codes};
use raxel_graph::checked::{BoundAccess, BufferSize, Dispatch, Interval, ResourceId, ResourceKind, Usage};
use raxel_graph::plan::DeviceLimits;
use raxel_shader::interface::Access;

use super::extents::mip_count;
use super::{Context, loops};

/// Bytes of the arguments of an indirect dispatch: three `uint`s.
const ARGUMENTS: u64 = 12;
/// Bytes of the number of threads of a queue: a `uint`.
const COUNT: u64 = 4;

/// Checks the dispatch; gives the access of its indirect arguments.
pub(crate) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) -> Option<BoundAccess> {
    let dispatch = context.pass.dispatch.as_ref()?;
    let error = |code, message: String| {
        Diagnostic::error(code, message)
            .label(dispatch.span.clone(), format!("the dispatch of pass `{}`", context.pass.name.value))
    };
    match &dispatch.value {
        Dispatch::Groups(counts) | Dispatch::Threads(counts) if counts.contains(&0) => {
            found.push(
                error(codes::graph::DISPATCH_SIZE, format!("a dispatch of {counts:?} runs nothing"))
                    .help("every axis is at least 1; switch a pass off with `when`"),
            );
            None
        }
        Dispatch::Groups(_) | Dispatch::Threads(_) => {
            // Whether it is an error only the device can say.
            let warning = |message: String| Diagnostic {
                severity: Severity::Warning,
                ..error(codes::graph::NOT_PORTABLE, message)
            };
            found.extend(too_many_groups(context, &dispatch.value).map(warning));
            None
        }
        Dispatch::ElementsOf { .. } | Dispatch::ThreadsOfWorld => None,
        Dispatch::GroupsOf { tile, .. } if tile.contains(&0) => {
            found.push(
                error(codes::graph::DISPATCH_SIZE, format!("a tile of {tile:?} has no texel"))
                    .help("every axis is at least 1"),
            );
            None
        }
        Dispatch::ThreadsOf { target, mip } | Dispatch::GroupsOf { target, mip, .. } => {
            let count = mip_count(context.graph, *target);
            let beyond = |mip: u32, count: u32| {
                let resource = &context.graph.resources[target.0 as usize].item;
                let s = if count == 1 { "" } else { "s" };
                let message = format!("target `{}` has {count} mip{s}, so no mip {mip}", resource.name);
                error(codes::graph::MIP_OR_LAYER, message).label(resource.place.clone(), "declared here")
            };
            if let Some(index) = &context.pass.dispatch_mip {
                let repeated = loops::around(context, index.value, &index.span, found);
                let last = repeated.zip(count).and_then(|(repeated, count)| {
                    Some((repeated, count, loops::beyond(context.graph, repeated, index.value, count)?))
                });
                if let Some((repeated, count, (mip, why))) = last {
                    found.push(beyond(mip, count).label(repeated.count.clone(), why));
                }
            } else if let Some(count) = count.filter(|count| mip >= count) {
                found.push(beyond(*mip, count));
            }
            None
        }
        Dispatch::Indirect { buffer, offset } => {
            if let Some(queue) = context.pass.queue {
                counts(context, (queue.buffer, queue.offset), ("the count", COUNT), &error, found)?;
            }
            indirect(context, *buffer, *offset, &error, found)
        }
    }
}

/// The axes along which a dispatch has more workgroups than every device allows. A local size that the graph may set is left to the plan.
fn too_many_groups(context: &Context<'_>, dispatch: &Dispatch) -> impl Iterator<Item = String> {
    (0..3).filter_map(move |axis| {
        let local = context.interface().local_size[axis];
        let groups = match dispatch {
            Dispatch::Groups(groups) => groups[axis],
            Dispatch::Threads(threads) if local.spec_id.is_none() => threads[axis].div_ceil(local.value.max(1)),
            _ => return None,
        };
        let limit = DeviceLimits::PORTABLE.workgroup_count[axis];
        (groups > limit).then(|| {
            let name = ["x", "y", "z"][axis];
            format!("{groups} workgroups along {name} are more than the {limit} that every device allows")
        })
    })
}

fn indirect(
    context: &Context<'_>,
    buffer: ResourceId,
    offset: u64,
    error: &dyn Fn(Code, String) -> Diagnostic,
    found: &mut Vec<Diagnostic>,
) -> Option<BoundAccess> {
    counts(context, (buffer, offset), ("the arguments", ARGUMENTS), error, found)?;
    Some(BoundAccess {
        resource: buffer,
        age: 0,
        mips: Interval::one(0),
        layers: Interval::one(0),
        access: Access::Read,
        usage: Usage::IndirectArguments,
        binding: None,
        sampler: None,
    })
}

/// Whether the count of threads or workgroups lies in its buffer.
fn counts(
    context: &Context<'_>,
    (buffer, offset): (ResourceId, u64),
    (what, needed): (&str, u64),
    error: &dyn Fn(Code, String) -> Diagnostic,
    found: &mut Vec<Diagnostic>,
) -> Option<()> {
    let declared = &context.graph.resources[buffer.0 as usize];
    let ResourceKind::Buffer(kind) = &declared.item.kind else { return None };
    let name = &declared.item.name;
    if !offset.is_multiple_of(4) {
        let message = format!("{what} in `{name}`: offset {offset} is not a multiple of 4");
        found.push(error(codes::graph::INDIRECT, message).help(format!("use {}", offset / 4 * 4)));
        return None;
    }
    if let Some(bytes) =
        kind.size.fixed_bytes().filter(|bytes| declared.sound && offset.saturating_add(needed) > *bytes)
    {
        let message = format!("`{name}` has {bytes} bytes, too few for {what} of {needed} bytes at {offset}");
        found.push(error(codes::graph::INDIRECT, message).label(declared.detail.clone(), "the size"));
        return None;
    }
    if matches!(kind.size, BufferSize::Source(_)) {
        let message = format!("`{name}` has a `source`, so it cannot hold {what}");
        found.push(error(codes::graph::INDIRECT, message).label(declared.detail.clone(), "the source"));
        return None;
    }
    Some(())
}
