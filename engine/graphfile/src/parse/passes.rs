//! Reads `[[passes]]`.

use raxel_diagnostics::Spanned;
use raxel_diagnostics::table::{Node, Table};
use raxel_graph::checked::LARGEST_SUBGROUP;
use raxel_language::layer::removes;
use raxel_language::{Named, ReadKeys, Value};

use super::{at, literal};
use crate::model::{Bind, Constant, Dispatch, Every, Fills, Member, Mip, Rhythm, SharedBlock};

/// Times a second that something may run: a thousandth is the unit in which ticks are counted.
pub(crate) const RATES: std::ops::RangeInclusive<f64> = 0.001..=10_000.0;

/// Structs in structs that `push` and `uniforms` may nest at most.
const DEEPEST_NESTING: usize = 16;

/// `defines`: those that are right.
pub(crate) fn defines(node: &Node<'_, '_>) -> Option<Vec<(Spanned<String>, String)>> {
    let read = |(name, node): (String, Node<'_, '_>)| {
        let text = if node.is_string() {
            node.string()?
        } else if node.is_boolean() {
            u8::from(node.boolean()?).to_string()
        } else if node.is_integer() {
            node.integer(i64::MIN..=i64::MAX)?.to_string()
        } else if node.is_number() {
            // `{:?}` keeps the point of `2.0`, so that the shader too sees a float.
            format!("{:?}", node.number(f64::MIN..=f64::MAX)?)
        } else {
            return node.wrong_type("a string, a number or a boolean");
        };
        Some((Spanned::new(name, node.key_span.clone()), text))
    };
    Some(node.table()?.entries().into_iter().filter_map(read).collect())
}

/// `specialization`: the constants that are right.
pub(crate) fn specialization(node: &Node<'_, '_>) -> Option<Vec<(Spanned<String>, Constant)>> {
    let read = |(name, node): (String, Node<'_, '_>)| {
        let constant =
            if node.is_string() { Constant::From(at(&node, node.string())?) } else { Constant::Value(literal(&node)?) };
        Some((Spanned::new(name, node.key_span.clone()), constant))
    };
    Some(node.table()?.entries().into_iter().filter_map(read).collect())
}

/// The sizes of subgroups that Vulkan lets a pass ask for: powers of two up to 128.
pub(crate) fn subgroup_size(node: &Node<'_, '_>) -> Option<Spanned<u32>> {
    let size: u32 = node.integer(1..=LARGEST_SUBGROUP)?;
    if size.is_power_of_two() {
        at(node, Some(size))
    } else {
        node.bad_value(format!("`{}` is {size}; it must be a power of two", node.name))
    }
}

impl<C: ?Sized> Value<C> for Dispatch {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        dispatch(node)
    }
}

fn dispatch(node: &Node<'_, '_>) -> Option<Dispatch> {
    if node.is_array() {
        return counts(node).map(Dispatch::Groups);
    }
    if !node.is_table() {
        return node.wrong_type("`[x, y, z]` workgroups, or a table with `threads`, `groups`, `count` or `indirect`");
    }
    let table = node.table()?;
    let (threads, mip) = (table.get("threads"), table.get("mip"));
    let (groups, tile) = (table.get("groups"), table.get("tile"));
    let (indirect, count, offset) = (table.get("indirect"), table.get("count"), table.get("offset"));
    table.finish();
    let given = [("threads", &threads), ("groups", &groups), ("indirect", &indirect), ("count", &count)];
    let given: Vec<&str> = given.iter().filter(|(_, node)| node.is_some()).map(|(key, _)| *key).collect();
    if given.len() != 1 {
        let which = if given.is_empty() { "none".to_owned() } else { given.join(", ") };
        return node.bad_value(format!(
            "`{}` needs one of `threads`, `groups`, `count`, `indirect`; it has {which}",
            node.name
        ));
    }
    let named = |node: &Option<Node<'_, '_>>| node.as_ref().is_some_and(Node::is_string);
    if let (Some(mip), false) = (&mip, named(&threads) || named(&groups)) {
        return mip.bad_value(format!("`{}` needs `threads` or `groups` to name a target", mip.name));
    }
    if let (Some(tile), false) = (&tile, named(&groups)) {
        return tile.bad_value(format!("`{}` needs `groups` to name a target", tile.name));
    }
    if let (Some(offset), None) = (&offset, indirect.as_ref().or(count.as_ref())) {
        return offset.bad_value(format!("`{}` needs `indirect` or `count`", offset.name));
    }
    if let Some(node) = threads {
        if node.is_array() {
            return counts(&node).map(Dispatch::Threads);
        }
        if !node.is_string() {
            return node.wrong_type("the name of a target or buffer, or `[x, y, z]`");
        }
        let mip = dispatch_mip(mip, &node)?;
        return Some(Dispatch::ThreadsOf { target: Spanned::new(node.string()?, node.span.clone()), mip });
    }
    let queue = count.is_some();
    if let Some(node) = indirect.or(count) {
        let offset = match offset {
            Some(offset) => Spanned::new(offset.integer(0..=i64::MAX.cast_unsigned())?, offset.span),
            None => Spanned::new(0, node.span.clone()),
        };
        let buffer = Spanned::new(node.string()?, node.span.clone());
        return Some(if queue { Dispatch::Queue { buffer, offset } } else { Dispatch::Indirect { buffer, offset } });
    }
    let node = groups?;
    if !node.is_string() {
        return counts(&node).map(Dispatch::Groups);
    }
    let tile = match tile {
        Some(tile) => counts(&tile)?,
        None => [1; 3],
    };
    let mip = dispatch_mip(mip, &node)?;
    Some(Dispatch::GroupsOf { target: Spanned::new(node.string()?, node.span.clone()), tile, mip })
}

fn dispatch_mip(given: Option<Node<'_, '_>>, target: &Node<'_, '_>) -> Option<Spanned<Mip>> {
    match given {
        Some(given) => Value::read(&given, &(), &()),
        None => Some(Spanned::new(Mip::Level(0), target.span.clone())),
    }
}

/// One to three counts; those that are left out are 1.
fn counts(node: &Node<'_, '_>) -> Option<[u32; 3]> {
    let elements = node.array()?;
    if elements.is_empty() || elements.len() > 3 {
        return node.bad_value(format!("`{}` needs 1 to 3 integers, not {}", node.name, elements.len()));
    }
    let mut counts = [1; 3];
    for (count, element) in counts.iter_mut().zip(&elements) {
        *count = element.integer(0..=u32::MAX)?;
    }
    Some(counts)
}

/// `bind`: the bindings that are right.
pub(crate) fn binds(node: &Node<'_, '_>) -> Option<Vec<Bind>> {
    let read = |(name, node): (String, Node<'_, '_>)| {
        let name = Spanned::new(name, node.key_span.clone());
        if node.is_string() {
            let target = at(&node, node.string());
            let (mip, layer, filter, wrap, partial) = (None, None, None, None, None);
            return Some(Bind { name, remove: false, target, mip, layer, filter, wrap, partial });
        }
        if !node.is_table() {
            return node.wrong_type("the name of a resource, or a table with `target`");
        }
        Bind::read_named(name, &node.table()?, &())
    };
    Some(node.table()?.entries().into_iter().filter_map(read).collect())
}

/// A binding that is not taken away has a resource.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "a check gets a reference to each field")]
pub(crate) fn needs_target(table: &Table<'_, '_>, remove: &bool, target: Option<&Spanned<String>>) -> bool {
    *remove || target.is_some() || table.need("target").is_some()
}

/// `[blocks.*]`: those that are tables.
pub(crate) fn shared_blocks(node: &Node<'_, '_>) -> Option<Vec<SharedBlock>> {
    let read = |(name, node): (String, Node<'_, '_>)| shared_block(name, &node, &node.table()?);
    Some(node.table()?.entries().into_iter().filter_map(read).collect())
}

/// One of `[blocks.*]`. A member that is called `remove` would be a boolean, which no block of this name needs.
fn shared_block(name: String, node: &Node<'_, '_>, table: &Table<'_, '_>) -> Option<SharedBlock> {
    if table.get("remove").is_some_and(|node| node.is_boolean()) && removes(table, &["remove"]) {
        let fills = Fills { name: Spanned::new(name, node.key_span.clone()), members: Vec::new() };
        return Some(SharedBlock { fills, remove: true });
    }
    Some(SharedBlock { fills: fills(name, node)?, remove: false })
}

/// `push`.
pub(crate) fn push(node: &Node<'_, '_>) -> Option<Fills<Member>> {
    fills("push".to_owned(), node)
}

/// `uniforms`: the blocks that are tables.
pub(crate) fn uniforms(node: &Node<'_, '_>) -> Option<Vec<Fills<Member>>> {
    Some(node.table()?.entries().into_iter().filter_map(|(name, node)| fills(name, &node)).collect())
}

fn fills(name: String, node: &Node<'_, '_>) -> Option<Fills<Member>> {
    let mut members = Vec::new();
    collect(&node.table()?, "", 0, &mut members);
    Some(Fills { name: Spanned::new(name, node.key_span.clone()), members })
}

/// Members of a table, those of nested tables under their path.
fn collect(table: &Table<'_, '_>, prefix: &str, depth: usize, members: &mut Vec<Member>) {
    for (key, node) in table.entries() {
        let path = Spanned::new(if prefix.is_empty() { key } else { format!("{prefix}.{key}") }, node.key_span.clone());
        let absent = |path| Member { path, remove: false, ty: None, from: None, value: None, offset: None };
        if node.is_string() {
            let from = at(&node, node.string());
            members.push(Member { from, ..absent(path) });
        } else if !node.is_table() {
            let Some(value) = literal(&node) else { continue };
            members.push(Member { value: Some(value), ..absent(path) });
        } else if let Some(inner) = node.table() {
            if is_member(&inner) {
                members.extend(member(path, &node));
            } else if depth < DEEPEST_NESTING {
                collect(&inner, &path.value, depth + 1, members);
            } else {
                node.bad_value::<()>(format!("`{}` nests more than {DEEPEST_NESTING} structs", node.name));
            }
        }
    }
}

/// Whether a table has the value of one member, and is not a struct with members of its own: it has one of a member's keys, and that key's
/// value is no table.
fn is_member(table: &Table<'_, '_>) -> bool {
    let keys = ["from", "value", "type", "offset", "remove"];
    table.entries().iter().any(|(key, node)| keys.contains(&key.as_str()) && !node.is_table())
}

fn member(path: Spanned<String>, node: &Node<'_, '_>) -> Option<Member> {
    let table = node.table()?;
    let member = Member::read_named(path, &table, &())?;
    if !member.remove && table.get("from").is_none() && table.get("value").is_none() {
        node.bad_value::<()>(format!("`{}` needs `from` or `value`", node.name));
    }
    Some(member)
}

impl<C: ?Sized> Value<C> for Every {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        if node.is_string() {
            return node.string().map(Every::Clock);
        }
        if !node.is_table() {
            return node.wrong_type("the name of a clock, `{ hz = … }`, `{ frames = … }` or `{ still = … }`");
        }
        match Rhythm::read_whole(&node.table()?, &())? {
            Rhythm { hz: Some(hz), .. } => Some(Every::Hz(hz)),
            Rhythm { frames: Some(frames), .. } => Some(Every::Frames(frames)),
            Rhythm { still: Some(still), .. } => Some(Every::Still(still)),
            Rhythm { .. } => node.bad_value(format!("`{}` needs `hz`, `frames` or `still`", node.name)),
        }
    }
}

/// A number of times a second.
pub(crate) fn rate(node: &Node<'_, '_>) -> Option<f64> {
    match node.number(f64::MIN..=f64::MAX)? {
        rate if RATES.contains(&rate) => Some(rate),
        rate => {
            let (least, most) = (RATES.start(), RATES.end());
            node.bad_value(format!("`{}` is {rate}; it must be at least {least} and at most {most}", node.name))
        }
    }
}
