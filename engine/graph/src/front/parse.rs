//! Phase 1, parse: the text of one graph file becomes a [`model::File`]. Reports everything that is wrong with the file alone:
//! syntax, unknown keys, wrong types, numbers out of range. What a name refers to is none of its business.

mod loops;
mod passes;
mod resources;

pub use resources::DISPLAY_MAPS;

use raxel_diagnostics::table::{self, Node, Reporter, Table};
use raxel_diagnostics::{Diagnostic, Spanned, codes};

use crate::front::model::{Clock, Data, File, Literal, Param};

/// Most entries that an array of numbers in a graph file may have.
const LONGEST_ARRAY: usize = 4096;

/// Most names of a param's values.
pub const MOST_CHOICES: usize = 64;

/// Ticks that a clock may catch up in one frame at most: each is a group of passes in the plan.
const MOST_TICKS: u32 = 16;

/// Reads the text of the graph file of that path. `None` when it is not TOML.
pub fn parse(path: &str, text: &str, found: &mut Vec<Diagnostic>) -> Option<File> {
    let reporter = Reporter::new(path);
    let file = table::parse(text, &reporter).map(|document| read(&Table::root(&document, &reporter)));
    found.extend(reporter.into_diagnostics());
    file
}

fn read(root: &Table<'_, '_>) -> File {
    let mut file = File {
        path: root.reporter().file().clone(),
        name: text(root, "name"),
        about: text(root, "about"),
        present: text(root, "present"),
        extends: text(root, "extends"),
        misspelt: Vec::new(),
        params: root.tables("params").into_iter().map(|(name, node, table)| param(name, &node, &table)).collect(),
        clocks: root.tables("clocks").into_iter().map(|(name, node, table)| clock(name, &node, &table)).collect(),
        targets: root
            .tables("targets")
            .into_iter()
            .map(|(name, node, table)| resources::target(name, &node, &table))
            .collect(),
        buffers: root
            .tables("buffers")
            .into_iter()
            .map(|(name, node, table)| resources::buffer(name, &node, &table))
            .collect(),
        blocks: root
            .tables("blocks")
            .into_iter()
            .filter_map(|(name, node, table)| passes::shared_block(name, &node, &table))
            .collect(),
        loops: root.tables("loops").into_iter().map(|(name, node, table)| loops::loop_(name, &node, &table)).collect(),
        passes: root.array_of_tables("passes").iter().map(passes::pass).collect(),
    };
    file.misspelt = root.finish();
    file
}

fn param(name: String, node: &Node<'_, '_>, table: &Table<'_, '_>) -> Param {
    let before = table.reporter().count();
    let mut param = Param {
        name: Spanned::new(name, node.key_span.clone()),
        remove: remove(table, &["remove"]),
        flawed: false,
        ty: text(table, "type"),
        default: table.get("default").and_then(|node| literal(&node)),
        range: table.get("range").and_then(|node| at(&node, node.numbers::<2>(f64::MIN..=f64::MAX))),
        step: table.get("step").and_then(|node| at(&node, node.number(0.0..=f64::MAX))),
        label: text(table, "label"),
        tooltip: text(table, "tooltip"),
        unit: text(table, "unit"),
        group: text(table, "group"),
        choices: table.get("choices").and_then(|node| at(&node, choices(&node))),
        color: table.get("color").and_then(|node| at(&node, node.boolean())),
    };
    table.finish();
    param.flawed = table.reporter().count() > before;
    param
}

/// Names of values: at least two, none of them empty.
fn choices(node: &Node<'_, '_>) -> Option<Vec<Spanned<String>>> {
    let elements = node.array()?;
    if !(2..=MOST_CHOICES).contains(&elements.len()) {
        let count = elements.len();
        return node.bad_value(format!("`{}` needs 2 to {MOST_CHOICES} names, not {count}", node.name));
    }
    let name = |element: &Node<'_, '_>| match element.string()? {
        name if name.trim().is_empty() => element.bad_value(format!("`{}` is empty", element.name)),
        name => Some(Spanned::new(name, element.span.clone())),
    };
    // Every element is read, so that everything wrong is said.
    let names: Vec<Option<Spanned<String>>> = elements.iter().map(name).collect();
    names.into_iter().collect()
}

fn clock(name: String, node: &Node<'_, '_>, table: &Table<'_, '_>) -> Clock {
    let before = table.reporter().count();
    let mut clock = Clock {
        name: Spanned::new(name, node.key_span.clone()),
        remove: remove(table, &["remove"]),
        flawed: false,
        hz: table.get("hz").and_then(|node| at(&node, passes::rate(&node))),
        most: table.get("most").and_then(|node| at(&node, node.integer(1..=MOST_TICKS))),
    };
    table.finish();
    clock.flawed = table.reporter().count() > before;
    clock
}

/// Whether `remove = true`, which may stand beside no keys but `beside`.
fn remove(table: &Table<'_, '_>, beside: &[&str]) -> bool {
    let Some(node) = table.get("remove") else { return false };
    let removed = node.boolean() == Some(true);
    if removed {
        for (key, other) in table.entries() {
            if !beside.contains(&key.as_str()) {
                table.reporter().report(
                    Diagnostic::error(
                        codes::files::CONFLICTING_KEYS,
                        format!("`{key}` and `remove` exclude each other: what is removed has no `{key}`"),
                    )
                    .label(other.key_span, "this one")
                    .label(node.key_span.clone(), "and this one"),
                );
            }
        }
    }
    removed
}

/// A value with the place of its node.
fn at<T>(node: &Node<'_, '_>, value: Option<T>) -> Option<Spanned<T>> {
    value.map(|value| Spanned::new(value, node.span.clone()))
}

/// Text of a key, if it is there.
fn text(table: &Table<'_, '_>, key: &str) -> Option<Spanned<String>> {
    table.string(key).map(|(value, span)| Spanned::new(value, span))
}

/// A number, a boolean, or an array of them.
fn literal(node: &Node<'_, '_>) -> Option<Literal> {
    let data = if node.is_boolean() {
        Data::Bool(node.boolean()?)
    } else if node.is_integer() {
        Data::Int(node.integer(i64::MIN..=i64::MAX)?)
    } else if node.is_number() {
        Data::Float(node.number(f64::MIN..=f64::MAX)?)
    } else if node.is_array() {
        let elements = node.array()?;
        if elements.len() > LONGEST_ARRAY {
            let count = elements.len();
            return node.bad_value(format!("`{}` has {count} elements; the most is {LONGEST_ARRAY}", node.name));
        }
        let count = elements.len();
        let elements: Vec<Literal> = elements.iter().filter_map(literal).collect();
        if elements.len() != count {
            return None;
        }
        Data::Array(elements)
    } else {
        return node.wrong_type("a number, a boolean or an array of them");
    };
    Some(Literal { data, span: node.span.clone() })
}
