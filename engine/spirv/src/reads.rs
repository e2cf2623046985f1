//! Which parts of a block a module may load: the access chains that start at its variable.

use std::collections::{HashMap, HashSet};

use spirv::Op;

use crate::instruction::Instruction;
use crate::module::accessed;

/// The uses of one variable in the functions that the entry point reaches.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chains {
    /// The indices of each access chain from the variable; `None` for one that is computed at run time. The pointer of a chain is used only
    /// within the part that the chain selects.
    pub chains: Vec<Vec<Option<u32>>>,
    /// The variable is also used in another way, so that all of it may be loaded.
    pub whole: bool,
}

/// The chains of each of `variables`. `bodies` are the instructions of the reachable functions.
pub(crate) fn chains<'w>(
    declarations: &[Instruction<'_>],
    bodies: impl Iterator<Item = &'w Instruction<'w>>,
    variables: &HashSet<u32>,
) -> HashMap<u32, Chains> {
    let constants: HashMap<u32, u32> = (declarations.iter().filter(|instruction| instruction.is(Op::Constant)))
        .filter_map(|instruction| match instruction.operands {
            [_, id, value] => Some((*id, *value)),
            _ => None,
        })
        .collect();
    let mut found: HashMap<u32, Chains> = variables.iter().map(|id| (*id, Chains::default())).collect();
    for instruction in bodies {
        let chain = instruction.is(Op::AccessChain) || instruction.is(Op::InBoundsAccessChain);
        match instruction.operands {
            [_, _, base, indices @ ..] if chain => {
                if let Some(of) = found.get_mut(base) {
                    of.chains.push(indices.iter().map(|id| constants.get(id).copied()).collect());
                }
            }
            _ => {
                for id in accessed(instruction) {
                    if let Some(of) = found.get_mut(id) {
                        of.whole = true;
                    }
                }
            }
        }
    }
    found
}
