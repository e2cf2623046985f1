//! Finding a member of a pass's push-constant or uniform block by its name.

use raxel_execute::Override;
use raxel_graph::checked::{Fill, Graph, PassId, Value};

use crate::params::{self, SetError};

/// The member of the blocks of a pass, in each of its cases, as overrides of that value.
pub(super) fn find_member(graph: &Graph, pass: &str, member: &str, value: Value) -> Result<Vec<Override>, SetError> {
    let mut cases = graph.cases(pass).peekable();
    if cases.peek().is_none() {
        return Err(SetError::unknown("pass", pass, graph.pass_names()));
    }
    cases.map(|id| find_member_of(graph, id, member, value)).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "a shader numbers its bindings and members in 32 bits")]
fn find_member_of(graph: &Graph, id: PassId, member: &str, value: Value) -> Result<Override, SetError> {
    let found = graph.pass(id);
    let in_block = |uniform: Option<u32>, fills: &[Fill]| {
        let fill = fills.iter().position(|fill| fill.member == member)?;
        Some((uniform, fill))
    };
    let blocks = std::iter::once((None, &found.push))
        .chain(found.uniforms.iter().enumerate().map(|(i, block)| (Some(i as u32), &block.fills)));
    let place = blocks.clone().find_map(|(uniform, fills)| in_block(uniform, fills));
    let Some((uniform, fill)) = place else {
        let names: Vec<&str> = blocks.flat_map(|(_, fills)| fills.iter().map(|fill| fill.member.as_str())).collect();
        return Err(SetError::unknown("push member", member, names.into_iter()));
    };
    let fills = uniform.map_or(&found.push, |index| &found.uniforms[index as usize].fills);
    fits(&fills[fill], value)?;
    Ok(Override { pass: PassId(id.0), uniform, fill: fill as u32, value })
}

/// A value must have as many components as the member; their types are converted.
fn fits(fill: &Fill, value: Value) -> Result<(), SetError> {
    let expected = fill.ty.rows * fill.ty.columns;
    if params::components(&value).len() == expected as usize {
        return Ok(());
    }
    Err(SetError::WrongShape { name: fill.member.clone(), expected, found: params::type_name(&value) })
}
