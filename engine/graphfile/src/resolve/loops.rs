//! Resolves `[loops.*]`: how often, and which resources change places.

use raxel_diagnostics::{Diagnostic, Spanned, codes};
use raxel_graph::checked::{self, MOST_ROUNDS, Resource, ResourceId, ResourceKind, Rounds, Target, Value};

use super::passes::of_kind;
use super::{Loop, Scope, missing};
use crate::model;

pub(crate) fn loop_(given: &model::Loop, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Loop {
    let before = found.len();
    let name = &given.name;
    if given.count.is_none() && !given.flawed {
        found.push(missing(&format!("`loops.{}`", name.value), "count", &name.span));
    }
    let rounds = given.count.as_ref().and_then(|count| rounds(&count.value, scope, found));
    let mut swap: Vec<[ResourceId; 2]> = Vec::new();
    for [first, second] in given.swap.iter().flatten() {
        let ids = [first, second].map(|name| scope.resource(&name.value, &name.span, found));
        let [Some(a), Some(b)] = ids else { continue };
        if let Some(error) = unlike([first, second], [a, b], &swap, scope) {
            found.push(error);
        } else {
            swap.push([a, b]);
        }
    }
    let item = checked::Loop {
        name: name.value.clone(),
        rounds: rounds.unwrap_or(Rounds::Fixed(1)),
        down: given.order.as_ref().is_some_and(|order| order.value == model::Order::Down),
        swap,
        place: name.span.clone(),
    };
    let count = given.count.as_ref().map_or(&name.span, |count| &count.span).clone();
    Loop { item, count, sound: rounds.is_some() && !given.flawed && found.len() == before }
}

fn rounds(given: &model::Rounds, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Option<Rounds> {
    match given {
        model::Rounds::Fixed(count) => Some(Rounds::Fixed(*count)),
        model::Rounds::Mips(target) => of_kind(target, scope, "target", found).map(Rounds::Mips),
        model::Rounds::Param(name) => {
            let id = scope.param(&name.value, &name.span, found)?;
            let param = &scope.params[id.0 as usize];
            if !param.sound {
                return None;
            }
            let ty = param.item.default.ty().word();
            let why = match (param.item.default, param.item.range) {
                (Value::I32(_) | Value::U32(_), Some([low, high])) => {
                    let fits = low >= 0.0 && high <= f64::from(MOST_ROUNDS);
                    (!fits).then(|| format!("has the range {low}…{high}, and a loop has 0 to {MOST_ROUNDS} rounds"))
                }
                (Value::I32(_) | Value::U32(_), None) => {
                    Some("has no range, and a loop needs to know its most rounds".to_owned())
                }
                _ => Some(format!("is `{ty}`, and rounds are counted in `i32` or `u32`")),
            };
            if let Some(why) = why {
                found.push(
                    Diagnostic::error(codes::graph::LOOP_COUNT, format!("param `{}` {why}", name.value))
                        .label(name.span.clone(), "the number of rounds")
                        .label(param.detail.clone(), "the param")
                        .help(format!("e.g. `type = \"i32\"`, `default = 4`, `range = [0, {}]`", MOST_ROUNDS / 4)),
                );
                return None;
            }
            Some(Rounds::Param(id))
        }
    }
}

/// Why two resources cannot change places, if they cannot.
fn unlike(
    names: [&Spanned<String>; 2],
    ids: [ResourceId; 2],
    taken: &[[ResourceId; 2]],
    scope: &Scope<'_>,
) -> Option<Diagnostic> {
    let [a, b] = ids.map(|id| &scope.resources[id.0 as usize]);
    if !(a.sound && b.sound) {
        return None;
    }
    let error = |why: String| {
        let [first, second] = names;
        Diagnostic::error(codes::graph::SWAP, why)
            .label(first.span.clone(), "this one")
            .label(second.span.clone(), "and this one")
    };
    let (first, second) = (&a.item.name, &b.item.name);
    if ids[0] == ids[1] {
        return Some(error(format!("`{first}` cannot change places with itself")));
    }
    if let Some(twice) = ids.into_iter().find(|id| taken.iter().flatten().any(|other| other == id)) {
        let twice = &scope.resources[twice.0 as usize].item.name;
        return Some(error(format!("`{twice}` changes places with two others in one round")));
    }
    if let Some(supplied) = [a, b].into_iter().find(|declared| declared.item.kind.supplied_by().is_some()) {
        let why = format!("`{}` comes from outside, and nothing can change places with it", supplied.item.name);
        return Some(error(why).label(supplied.detail.clone(), "the source"));
    }
    let what = difference(&a.item, &b.item)?;
    Some(
        error(format!("`{first}` and `{second}` cannot change places: they differ in {what}"))
            .label(a.item.place.clone(), format!("`{first}`"))
            .label(b.item.place.clone(), format!("`{second}`"))
            .help("declare both with the same format, size, mips, layers, history, `clock`, `clear` and `init`"),
    )
}

/// The property in which two resources differ, apart from how they are shown.
fn difference(a: &Resource, b: &Resource) -> Option<&'static str> {
    if a.history != b.history {
        return Some("`history`");
    }
    if a.clock != b.clock {
        return Some("`clock`");
    }
    match (&a.kind, &b.kind) {
        (ResourceKind::Target(a), ResourceKind::Target(b)) => {
            let plain = |target: &Target| Target { display: None, ..target.clone() };
            let parts = [
                (a.format == b.format, "`format`"),
                (a.extent == b.extent, "`size`"),
                (a.mips == b.mips, "`mips`"),
                (a.layers == b.layers, "`layers`"),
                (a.clear == b.clear, "`clear`"),
                (a.init == b.init, "`init`"),
                (plain(a) == plain(b), "what they keep"),
            ];
            parts.into_iter().find(|(same, _)| !same).map(|(_, what)| what)
        }
        (ResourceKind::Buffer(a), ResourceKind::Buffer(b)) => {
            let parts = [
                (a.size == b.size, "`size`"),
                (a.clear == b.clear, "`clear`"),
                (a.init == b.init, "`init`"),
                (a == b, "what they keep"),
            ];
            parts.into_iter().find(|(same, _)| !same).map(|(_, what)| what)
        }
        _ => Some("kind: one is a target, the other a buffer"),
    }
}
