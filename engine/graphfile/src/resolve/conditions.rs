//! Resolves `when`: the conditions under which a pass runs.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, Spanned, codes};
use raxel_graph::checked::{Condition, Fact, Value};

use super::Scope;

/// The facts of `when` that are no param.
pub const FACTS: [(&str, Fact); 6] = [
    ("world.has_emission", Fact::WorldHasEmission),
    ("world.has_transparency", Fact::WorldHasTransparency),
    ("world.has_voxels", Fact::WorldHasVoxels),
    ("world.has_instances", Fact::WorldHasInstances),
    ("device.packets", Fact::DevicePackets),
    ("device.ballots", Fact::DeviceBallots),
];

/// `world.has_emission`, `!param.fog`; `always` takes away a condition of the base.
pub fn condition(when: &Spanned<String>, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Option<Condition> {
    if when.value == "always" {
        return None;
    }
    let word = when.value.strip_prefix('!').unwrap_or(&when.value);
    let negated = word.len() < when.value.len();
    if let Some((_, fact)) = FACTS.iter().find(|(name, _)| *name == word) {
        return Some(Condition { fact: fact.clone(), negated });
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
    let facts = || FACTS.iter().map(|(name, _)| *name);
    let diagnostic = Diagnostic::error(codes::graph::UNKNOWN_FACT, format!("there is no condition `{word}`"))
        .label(when.span.clone(), "no such condition");
    found.push(match closest(word, facts()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => diagnostic.help(format!("`param.NAME` of a bool, or one of: {}", list(facts()))),
    });
    None
}
