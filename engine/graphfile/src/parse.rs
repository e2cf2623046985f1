//! Phase 1, parse: the text of one graph file becomes a [`File`](crate::model::File). Reports everything that is wrong with the file alone:
//! syntax, unknown keys, wrong types, numbers out of range. It does not look up names.

pub(crate) mod loops;
mod passes;
pub(crate) mod resources;

pub(crate) use passes::{
    RATES, binds, defines, needs_target, push, rate, shared_blocks, specialization, subgroup_size, uniforms,
};

use raxel_diagnostics::table::{self, Node, Reporter, Table};
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_language::{ByName, Named, ReadKeys, Value};

use crate::model::{Choices, Data, File, Literal, Pass};

/// Most entries that an array of numbers in a graph file may have.
pub(crate) const LONGEST_ARRAY: usize = 4096;

/// Most names of a param's values.
pub(crate) const MOST_CHOICES: usize = 64;

/// Ticks that a clock may catch up in one frame at most: each is a group of passes in the plan.
pub(crate) const MOST_TICKS: u32 = 16;

/// Reads the text of the graph file of that path. `None` when it is not TOML, or empty.
pub(crate) fn parse(path: &str, text: &str, found: &mut Vec<Diagnostic>) -> Option<File> {
    let reporter = Reporter::new(path);
    let document = table::parse(text, &reporter);
    let empty = document.as_ref().is_some_and(|document| document.get_ref().is_empty());
    let file = document.filter(|_| !empty).and_then(|document| {
        let root = Table::root(&document, &reporter);
        let mut file = File::read_keys(&root, &())?;
        file.path = reporter.file().clone();
        file.misspelt = root.finish();
        Some(file)
    });
    found.extend(reporter.into_diagnostics());
    if empty {
        // Everything that is missing follows from it.
        found.push(
            Diagnostic::error(codes::files::MISSING_KEY, format!("`{path}` is empty"))
                .label(Span::new(path, 0..0), "this graph has no key"),
        );
    }
    file
}

/// Tables that the author names.
pub(crate) fn by_name<T: Named>(node: &Node<'_, '_>) -> Option<Vec<T>> {
    ByName::read(node, &(), &()).map(|tables| tables.0)
}

/// `[[passes]]`, with all mistakes in them.
pub(crate) fn passes(node: &Node<'_, '_>) -> Option<Vec<Pass>> {
    Some(node.array()?.iter().filter_map(|node| Pass::read(node, &(), &())).collect())
}

impl<C: ?Sized> Value<C> for Choices {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        let elements = node.array()?;
        if !(2..=MOST_CHOICES).contains(&elements.len()) {
            let count = elements.len();
            return node.bad_value(format!("`{}` needs 2 to {MOST_CHOICES} names, not {count}", node.name));
        }
        let name = |element: &Node<'_, '_>| match element.string()? {
            name if name.trim().is_empty() => element.bad_value(format!("`{}` is empty", element.name)),
            name => Some(Spanned::new(name, element.span.clone())),
        };
        // Every element is read, so that every mistake is reported.
        let names: Vec<Option<Spanned<String>>> = elements.iter().map(name).collect();
        names.into_iter().collect::<Option<_>>().map(Self)
    }
}

impl<C: ?Sized> Value<C> for Literal {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        literal(node)
    }
}

/// A value with the place of its node.
pub(crate) fn at<T>(node: &Node<'_, '_>, value: Option<T>) -> Option<Spanned<T>> {
    value.map(|value| Spanned::new(value, node.span.clone()))
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
