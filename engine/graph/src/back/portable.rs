//! Warnings of what only some devices have: limits that a pass exceeds, capabilities of its shader, and formats of targets.

use raxel_diagnostics::{Diagnostic, Span, codes};

use crate::back::needs::needs_of;
use crate::ir::checked::{Fact, Pass};
use crate::ir::plan::{BindingLimits, DeviceLimits, Plan, ResourceDesc};

/// Limits that many devices do not exceed, a Raspberry Pi 5 among them. docs/promises.md has them, too.
const COMMON: DeviceLimits = DeviceLimits {
    workgroup_invocations: 256,
    bindings: BindingLimits { storage_buffers: 8, ..DeviceLimits::PORTABLE.bindings },
    ..DeviceLimits::PORTABLE
};

/// Capabilities that desktop devices have, and some small devices have not.
const RARER: [&str; 10] = [
    "Int64",
    "Int16",
    "SubgroupBallotKHR",
    "SubgroupVoteKHR",
    "GroupNonUniformShuffle",
    "GroupNonUniformArithmetic",
    "GroupNonUniformQuad",
    "GroupNonUniformShuffleRelative",
    "GroupNonUniformClustered",
    "StorageImageWriteWithoutFormat",
];

/// Those that a device has if `device.packets` or `device.ballots` holds.
const OF_BALLOTS: [&str; 3] = ["Int64", "SubgroupBallotKHR", "SubgroupVoteKHR"];

/// A warning for each need of a plan that many devices do not meet. A capability that the pass's `when` asks the device for is none.
pub fn rarely_met(plan: &Plan) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = formats(plan).collect();
    for planned in &plan.passes {
        let pass = plan.graph.pass(planned.pass);
        let name = plan.graph.declared_name(planned.pass);
        let limits = needs_of(pass, &planned.specialization, &COMMON).into_iter().filter(|need| !need.is_met());
        let over_limits = limits.map(|need| {
            let message =
                format!("pass `{name}` needs {} {}, and many devices have {}", need.needs, need.what, need.has);
            warning(&pass.place, message, "this pass").note(format!("the limit is `{}`", need.limit))
        });
        let rarer = capabilities(pass).map(|capability| {
            let message = format!("pass `{name}` needs `{capability}`, which not every device has");
            warning(&pass.place, message, "declared by the compiled shader")
        });
        for new in over_limits.chain(rarer) {
            // The rounds of a loop and the variants of a pass stand at one place.
            if !found.iter().any(|known| known.message == new.message && known.labels == new.labels) {
                found.push(new);
            }
        }
    }
    found
}

/// A warning for each target whose images not every device can make (`Format::is_stored_everywhere`).
fn formats(plan: &Plan) -> impl Iterator<Item = Diagnostic> {
    plan.resources.iter().filter_map(|planned| {
        let (ResourceDesc::Image(desc) | ResourceDesc::SourceImage(_, desc)) = &planned.desc else { return None };
        let used = match desc.usage.storage {
            _ if !desc.format.is_sampled_everywhere() => "has images of",
            true if !desc.format.is_stored_everywhere() => "stores to images of",
            _ => return None,
        };
        let (target, format) = (plan.graph.resource(planned.resource), desc.format.name());
        let message = format!("target `{}` has the format `{format}`, and not every device {used} it", target.name);
        Some(
            warning(&target.place, message, "this target")
                .help("`raxel explain RX0410` lists the formats of every device"),
        )
    })
}

fn warning(place: &Span, message: String, label: &str) -> Diagnostic {
    Diagnostic::warning(codes::graph::NOT_PORTABLE, message)
        .label(place.clone(), label)
        .help("`raxel doctor --graph` compares the graph with a device")
}

/// The rarer capabilities of a pass, without those that its conditions ask for.
fn capabilities(pass: &Pass) -> impl Iterator<Item = &'static str> {
    let asks =
        pass.when.iter().any(|when| !when.negated && matches!(when.fact, Fact::DevicePackets | Fact::DeviceBallots));
    let declared = |name: &&str| pass.shader.interface.capabilities.iter().any(|known| known == name);
    let found: Vec<&str> = RARER.into_iter().filter(declared).collect();
    found.into_iter().filter(move |name| !(asks && OF_BALLOTS.contains(name)))
}
