//! Resolves the values of blocks and of specialization constants: literals, params, builtins, and values of the graph and its clocks.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_graph::ValueType;
use raxel_graph::checked::{
    Builtin, ClockValue, Extent, Material, ResourceId, ResourceKind, RoundIndex, Value, ValueOrigin,
};
use raxel_graph::index32;
use raxel_shader::interface::Scalar;

use super::params::unknown_type;
use super::passes::{elements, of_kind};
use super::{Feed, Member, Scope};
use crate::model::{self, Fills};

/// Elements that an array member may be declared with.
const LONGEST_MEMBER: u32 = 4096;

/// The values of a block of a pass, or of one of `[blocks.*]`.
pub(crate) fn fills(block: &Fills<model::Member>, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Fills<Member> {
    Fills { name: block.name.clone(), members: block.members.iter().map(|m| member(m, scope, found)).collect() }
}

fn member(member: &model::Member, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Member {
    let ty = member.ty.as_ref().and_then(|word| {
        let ty = member_type(&word.value);
        if ty.is_none() {
            found.push(unknown_type(&word.value, &word.span, ValueType::words()));
        }
        ty.map(|ty| Spanned::new(ty, word.span.clone()))
    });
    let feed = match (&member.from, &member.value) {
        (Some(from), _) => source(from, scope, found).map(|feed| Spanned::new(feed, from.span.clone())),
        (None, Some(literal)) => Some(Spanned::new(Feed::Literal(literal.clone()), literal.span.clone())),
        (None, None) => None,
    };
    Member { path: member.path.clone(), ty, feed, offset: member.offset.clone() }
}

/// `vec3`, `vec4[8]`.
fn member_type(word: &str) -> Option<(ValueType, Option<u32>)> {
    let Some((element, rest)) = word.split_once('[') else { return ValueType::from_word(word).map(|ty| (ty, None)) };
    let len: u32 = rest.strip_suffix(']')?.parse().ok().filter(|len| (1..=LONGEST_MEMBER).contains(len))?;
    ValueType::from_word(element).map(|ty| (ty, Some(len)))
}

pub(crate) fn constant(
    value: &model::Constant,
    scope: &Scope<'_>,
    found: &mut Vec<Diagnostic>,
) -> Option<Spanned<Feed>> {
    match value {
        model::Constant::Value(literal) => Some(Spanned::new(Feed::Literal(literal.clone()), literal.span.clone())),
        model::Constant::From(from) => source(from, scope, found).map(|feed| Spanned::new(feed, from.span.clone())),
    }
}

/// The word of `from`: `param.NAME`, `target.NAME.size`, `buffer.NAME.count`, `material.NAME`, `clock.NAME.tick`, or a builtin.
fn source(from: &Spanned<String>, scope: &Scope<'_>, found: &mut Vec<Diagnostic>) -> Option<Feed> {
    let word = from.value.as_str();
    if let Some(name) = word.strip_prefix("param.") {
        let id = scope.param(name, &from.span, found)?;
        let param = &scope.params[id.0 as usize];
        return param.sound.then(|| Feed::From(ValueOrigin::Param(id), Value::ty(&param.item.default)));
    }
    if let Some(name) = word.strip_prefix("target.").and_then(|rest| rest.strip_suffix(".size")) {
        let name = Spanned::new(name.to_owned(), from.span.clone());
        let id = of_kind(&name, scope, "target", found)?;
        if !scope.resources[id.0 as usize].sound {
            return None;
        }
        let rows = if has_third_axis(id, scope) { 3 } else { 2 };
        let ty = ValueType::vector(Scalar::I32, rows);
        return Some(Feed::From(ValueOrigin::ExtentOf(id), ty));
    }
    if let Some(name) = word.strip_prefix("buffer.").and_then(|rest| rest.strip_suffix(".count")) {
        let name = Spanned::new(name.to_owned(), from.span.clone());
        let id = of_kind(&name, scope, "buffer", found)?;
        let ty = ValueType::scalar(Scalar::U32);
        return elements(id, &name, scope, found).then_some(Feed::From(ValueOrigin::CountOf(id), ty));
    }
    if let Some(index) = RoundIndex::ALL.into_iter().find(|index| index.name() == word) {
        return Some(Feed::From(ValueOrigin::Round(index), ValueType::scalar(Scalar::U32)));
    }
    if let Some(name) = word.strip_prefix("material.").filter(|name| !name.is_empty()) {
        let mut materials = scope.materials.borrow_mut();
        materials.push(Material { name: name.to_owned(), place: from.span.clone() });
        let ty = ValueType::scalar(Scalar::U32);
        return Some(Feed::From(ValueOrigin::Material(index32(materials.len()) - 1), ty));
    }
    if let Some(builtin) = Builtin::ALL.iter().find(|builtin| builtin.name() == word) {
        return Some(Feed::From(ValueOrigin::Builtin(*builtin), builtin.ty()));
    }
    if let Some((name, word)) = word.strip_prefix("clock.").and_then(|rest| rest.rsplit_once('.'))
        && let Some((value, _)) = ClockValue::ALL.iter().find(|(_, known)| *known == word)
    {
        let id = scope.clock(name, &from.span, found)?;
        let scalar = match value {
            ClockValue::Tick => Scalar::U32,
            ClockValue::Delta | ClockValue::Phase => Scalar::F32,
        };
        return Some(Feed::From(ValueOrigin::Clock(id, *value), ValueType::scalar(scalar)));
    }
    found.push(unknown_source(word, &from.span, scope));
    None
}

fn unknown_source(word: &str, place: &Span, scope: &Scope<'_>) -> Diagnostic {
    let rounds = || RoundIndex::ALL.into_iter().map(RoundIndex::name);
    let builtins = || Builtin::ALL.iter().map(|builtin| builtin.name()).chain(rounds());
    let params: Vec<String> = scope.params.iter().map(|param| format!("param.{}", param.item.name)).collect();
    let diagnostic = Diagnostic::error(codes::graph::UNKNOWN_BUILTIN, format!("nothing is called `{word}`"))
        .label(place.clone(), "no such value");
    // A param is often named without the word `param`.
    let meant = params.iter().find(|param| param["param.".len()..] == *word).map(String::as_str);
    match meant
        .or_else(|| closest(word, params.iter().map(String::as_str).chain(builtins().map(|name| -> &str { name }))))
    {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => diagnostic.help(format!(
            "`param.NAME`, `target.NAME.size`, `buffer.NAME.count`, `material.NAME` or one of: {}",
            list(builtins())
        )),
    }
}

/// Whether the extent of a target has depth or layers. A chain of `of` that closes on itself is reported elsewhere.
fn has_third_axis(id: ResourceId, scope: &Scope<'_>) -> bool {
    let mut next = id;
    for _ in 0..=scope.resources.len() {
        let ResourceKind::Target(target) = &scope.resources[next.0 as usize].item.kind else { return false };
        if next == id && target.layers > 1 {
            return true;
        }
        match target.extent {
            Extent::Fixed3(_) | Extent::World { .. } | Extent::Source => return true,
            Extent::Of { target, .. } => next = target,
            Extent::Output { .. } | Extent::Fixed2(_) => return false,
        }
    }
    false
}
