//! Reads `[loops.*]`, and the mips that follow a loop.

use raxel_diagnostics::Spanned;
use raxel_diagnostics::table::Node;
use raxel_graph::checked::{MOST_ROUNDS, RoundIndex};
use raxel_language::{ReadKeys, Value};

use super::at;
use super::resources::MOST_MIPS;
use crate::model::{Mip, MipSteps, Rounds};

impl<C: ?Sized> Value<C> for Rounds {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        rounds(node)
    }
}

fn rounds(node: &Node<'_, '_>) -> Option<Rounds> {
    if node.is_integer() {
        return node.integer(0..=MOST_ROUNDS).map(Rounds::Fixed);
    }
    if node.is_string() {
        let text = node.string()?;
        return match text.strip_prefix("param.") {
            Some(name) => Some(Rounds::Param(Spanned::new(name.to_owned(), node.span.clone()))),
            None => node.bad_value(format!("`{}` is \"{text}\"; a param is written \"param.NAME\"", node.name)),
        };
    }
    if !node.is_table() {
        return node.wrong_type("a number of rounds, `\"param.NAME\"` or `{ mips = \"NAME\" }`");
    }
    MipSteps::read_whole(&node.table()?, &()).map(|steps| Rounds::Mips(steps.mips))
}

/// `[["a", "b"], …]`; `None` when a part of it is wrong.
pub(crate) fn swap(node: &Node<'_, '_>) -> Option<Vec<[Spanned<String>; 2]>> {
    node.array()?
        .iter()
        .map(|pair| {
            let names = pair.array()?;
            let [first, second] = &names[..] else {
                return pair.bad_value(format!("`{}` needs 2 names, not {}", pair.name, names.len()));
            };
            Some([at(first, first.string())?, at(second, second.string())?])
        })
        .collect()
}

/// A number, `"loop.index"` or `"loop.next"`.
impl<C: ?Sized> Value<C> for Mip {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        if node.is_string() {
            let words = RoundIndex::ALL.map(|index| (index.name(), Mip::Round(index)));
            return node.word(&words);
        }
        if !node.is_integer() {
            return node.wrong_type("the number of a mip, `\"loop.index\"` or `\"loop.next\"`");
        }
        node.integer(0..=MOST_MIPS - 1).map(Mip::Level)
    }
}
