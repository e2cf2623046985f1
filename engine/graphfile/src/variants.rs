//! Passes over buffers that only some worlds have: each becomes a pass that binds the buffer, and one that is compiled without it. Their
//! conditions exclude each other, so a plan has one of them.

use std::collections::HashMap;

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, Spanned, codes};
use raxel_graph::checked::{Condition, Fact};

use crate::model::{Bind, File, Pass};
use crate::resolve::FACTS;

/// Writes out the passes that bind a buffer with `when`.
pub(crate) fn write_out(model: &mut File, found: &mut Vec<Diagnostic>) {
    let mut conditions: HashMap<String, Condition> = HashMap::new();
    for buffer in &model.buffers {
        let condition = buffer.when.as_ref().and_then(|when| condition(when, found));
        conditions.extend(condition.map(|condition| (buffer.name.value.clone(), condition)));
    }
    if conditions.is_empty() {
        return;
    }
    let of = |entry: &Bind| {
        let name = entry.target.as_ref()?.value.split('@').next()?;
        conditions.get(name)
    };
    model.passes = std::mem::take(&mut model.passes).into_iter().flat_map(|pass| cases(pass, &of)).collect();
}

/// A pass for each combination of the facts that its bindings ask for: at most two for each fact about worlds.
fn cases<'c>(pass: Pass, of: &impl Fn(&Bind) -> Option<&'c Condition>) -> Vec<Pass> {
    let mut facts: Vec<&Fact> = Vec::new();
    for condition in pass.bind.iter().filter_map(of) {
        if !facts.contains(&&condition.fact) {
            facts.push(&condition.fact);
        }
    }
    let mut cases = vec![pass];
    for fact in facts {
        let both = |pass: &Pass| [false, true].map(|negated| case(pass, fact, negated, of));
        cases = cases.iter().flat_map(both).flatten().collect();
    }
    cases
}

/// The pass where a fact holds, or where it does not; `None` if its own condition keeps it from running there.
fn case<'c>(pass: &Pass, fact: &Fact, negated: bool, of: &impl Fn(&Bind) -> Option<&'c Condition>) -> Option<Pass> {
    let own = own(pass, fact);
    if own.is_some_and(|own| own != negated) {
        return None;
    }
    let mut case = pass.clone();
    case.bind.retain(|entry| of(entry).is_none_or(|known| known.fact != *fact || known.negated == negated));
    let here = case.bind.iter().filter(|entry| of(entry).is_some_and(|known| known.fact == *fact));
    case.defines.extend(here.filter_map(|entry| define(&entry.name)));
    if own.is_none() {
        case.also_when.push(Condition { fact: fact.clone(), negated });
    }
    Some(case)
}

/// False if the condition of a pass itself asks for a fact, true if it asks for the contrary, `None` otherwise.
fn own(pass: &Pass, fact: &Fact) -> Option<bool> {
    let when = &pass.when.as_ref()?.value;
    let word = when.strip_prefix('!').unwrap_or(when);
    let asks = FACTS.iter().any(|known| known.name == word && known.fact == *fact);
    asks.then_some(word.len() < when.len())
}

/// The define by which a shader knows that a buffer is bound. The check against the shader reports names that GLSL does not allow.
fn define(binding: &Spanned<String>) -> Option<(Spanned<String>, String)> {
    let named = binding.value.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') && !binding.value.contains("__");
    let named = named && !binding.value.starts_with('_') && binding.value.len() <= 200;
    named.then(|| (Spanned::new(format!("RX_BINDS_{}", binding.value), binding.span.clone()), "1".to_owned()))
}

/// `world.has_instances` or `!world.has_instances`; `always` takes away a condition of the base.
fn condition(when: &Spanned<String>, found: &mut Vec<Diagnostic>) -> Option<Condition> {
    if when.value == "always" {
        return None;
    }
    let word = when.value.strip_prefix('!').unwrap_or(&when.value);
    let known = || FACTS.iter().filter(|known| known.name.starts_with("world."));
    if let Some(known) = known().find(|known| known.name == word) {
        return Some(Condition { fact: known.fact.clone(), negated: word.len() < when.value.len() });
    }
    let diagnostic = Diagnostic::error(codes::graph::UNKNOWN_FACT, format!("`{word}` is no condition of a buffer"))
        .label(when.span.clone(), "not something that a world has");
    let names = || known().map(|known| known.name);
    found.push(match closest(word, names()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => diagnostic.help(format!("one of: {}", list(names()))),
    });
    None
}
