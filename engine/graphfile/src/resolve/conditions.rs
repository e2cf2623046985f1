//! Resolves `when`: the conditions under which a pass runs.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, Spanned, codes};
use raxel_graph::checked::{Condition, Fact, Value};

use super::Scope;

/// A fact of `when` that is no param.
pub(crate) struct KnownFact {
    /// Its name in files.
    pub name: &'static str,
    pub fact: Fact,
    /// When it holds.
    pub holds: &'static str,
}

/// All of them. docs/graph-file.md has the same sentences.
pub(crate) const FACTS: [KnownFact; 6] = [
    KnownFact {
        name: "world.has_emission",
        fact: Fact::WorldHasEmission,
        holds: "a voxel of the world or of an instance gives off light",
    },
    KnownFact {
        name: "world.has_transparency",
        fact: Fact::WorldHasTransparency,
        holds: "a voxel of the world is transparent",
    },
    KnownFact { name: "world.has_voxels", fact: Fact::WorldHasVoxels, holds: "the world has a solid voxel" },
    KnownFact { name: "world.has_instances", fact: Fact::WorldHasInstances, holds: "the world has instances" },
    KnownFact {
        name: "device.packets",
        fact: Fact::DevicePackets,
        holds: "`<raxel/packet.glsl>` and `<raxel/parallel.glsl>` work with this device and this world",
    },
    KnownFact {
        name: "device.ballots",
        fact: Fact::DeviceBallots,
        holds: "shaders may use `RX_PLAIN_BALLOTS` of `<raxel/refill.glsl>`",
    },
];

/// `world.has_emission`, `!param.fog`; `always` takes away a condition of the base.
pub(crate) fn condition(when: &Spanned<String>, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Option<Condition> {
    if when.value == "always" {
        return None;
    }
    let word = when.value.strip_prefix('!').unwrap_or(&when.value);
    let negated = word.len() < when.value.len();
    if let Some(known) = FACTS.iter().find(|known| known.name == word) {
        return Some(Condition { fact: known.fact.clone(), negated });
    }
    if let Some(name) = word.strip_prefix("param.") {
        let id = scope.param(name, &when.span, found)?;
        let param = &scope.params[id.0 as usize];
        if matches!(param.item.default, Value::Bool(_)) {
            return Some(Condition { fact: Fact::Param(id), negated });
        }
        if param.sound {
            let ty = param.item.default.ty().word();
            found.push(
                Diagnostic::error(codes::graph::CONDITION_TYPE, format!("param `{name}` is `{ty}`, not `bool`"))
                    .label(when.span.clone(), "a condition holds or does not")
                    .label(param.detail.clone(), "declared here"),
            );
        }
        return None;
    }
    let facts = || FACTS.iter().map(|known| known.name);
    let diagnostic = Diagnostic::error(codes::graph::UNKNOWN_FACT, format!("there is no condition `{word}`"))
        .label(when.span.clone(), "no such condition");
    found.push(match closest(word, facts()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => diagnostic.help(format!("`param.NAME` of a bool, or one of: {}", list(facts()))),
    });
    None
}
