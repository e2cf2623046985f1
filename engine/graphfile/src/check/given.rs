//! The values that the graph gives for one block of a shader: the pass's own, over those of `[blocks.*]`.

use std::borrow::Cow;
use std::collections::HashSet;

use raxel_diagnostics::names::closest;
use raxel_diagnostics::{Diagnostic, Spanned, codes};
use raxel_graph::checked::Graph;
use raxel_shader::interface::{BindingKind, Block};

use super::blocks::leaves;
use crate::model::{Data, Fills, Literal};
use crate::resolve::{Feed, Member, Resolved};

/// The values for one block.
pub(crate) struct Given<'a> {
    /// `push` or one of `uniforms` of the pass; the shared ones when the pass has none.
    first: &'a Fills<Member>,
    /// One of `[blocks.*]`.
    shared: Option<&'a Fills<Member>>,
}

impl<'a> Given<'a> {
    /// `None` when there are no values at all.
    pub(crate) fn new(own: Option<&'a Fills<Member>>, shared: Option<&'a Fills<Member>>) -> Option<Self> {
        Some(Self { first: own.or(shared)?, shared })
    }

    /// The shared values for a block: those with the name of its instance, else those with its own.
    pub(crate) fn shared(graph: &'a Resolved, instance: &str, block: &str) -> Option<&'a Fills<Member>> {
        let named = |name: &str| graph.blocks.iter().find(|shared| shared.name.value == name && !name.is_empty());
        named(instance).or_else(|| named(block))
    }

    /// Where the values are given: in the pass if it has any.
    pub(crate) fn name(&self) -> &'a Spanned<String> {
        &self.first.name
    }

    /// Whether the pass has no values of its own.
    pub(crate) fn is_shared(&self) -> bool {
        self.shared.is_some_and(|shared| std::ptr::eq(shared, self.first))
    }

    /// The pass's own members.
    pub(crate) fn own(&self) -> impl Iterator<Item = &'a Member> + use<'a> {
        let own = Some(self.first).filter(|_| !self.is_shared());
        own.into_iter().flat_map(|fills| &fills.members)
    }

    fn shared_members(&self) -> impl Iterator<Item = &'a Member> + use<'a> {
        self.shared.into_iter().flat_map(|fills| &fills.members)
    }

    /// The value of a member, and whether it is a shared one. A shared list does not count if the pass gives elements of it: it is taken
    /// element by element.
    pub(crate) fn member(&self, path: &str) -> Option<(&'a Member, bool)> {
        let of_path = |member: &&Member| member.path.value == path;
        let shared = || self.shared_members().find(of_path).filter(|_| !self.own().any(|own| is_element(own, path)));
        self.own().find(of_path).map(|own| (own, false)).or_else(|| Some((shared()?, true)))
    }

    /// Whether elements of the array are given one by one.
    pub(crate) fn has_elements(&self, path: &str) -> bool {
        self.own().chain(self.shared_members()).any(|member| is_element(member, path))
    }

    /// The value of an element of an array, and whether it is a shared one.
    pub(crate) fn element(&self, path: &str, index: u32) -> Option<(Cow<'a, Member>, bool)> {
        if let Some((member, shared)) = self.member(&format!("{path}[{index}]")) {
            return Some((Cow::Borrowed(member), shared));
        }
        let list = self.shared_members().find(|member| member.path.value == path)?;
        let Some(Spanned { value: Feed::Literal(Literal { data: Data::Array(elements), .. }), .. }) = &list.feed else {
            return None;
        };
        let element = elements.get(index as usize)?;
        let feed = Some(Spanned::new(Feed::Literal(element.clone()), element.span.clone()));
        Some((Cow::Owned(Member { path: list.path.clone(), ty: None, feed, offset: None }), true))
    }

    /// The shared member whose name is nearest to one that has no value.
    pub(crate) fn nearest_shared(&self, path: &str) -> Option<&'a Member> {
        let array = path.split('[').next().unwrap_or(path);
        let others = || self.shared_members().filter(|member| !is_element(member, array));
        let near = closest(path, others().map(|member| member.path.value.as_str()))?;
        others().find(|member| member.path.value == near)
    }
}

fn is_element(member: &Member, array: &str) -> bool {
    member.path.value.strip_prefix(array).is_some_and(|rest| rest.starts_with('['))
}

/// Warns of shared blocks that no shader has, and of values that no shader's block has.
pub(crate) fn unused(graph: &Graph, resolved: &Resolved, found: &mut Vec<Diagnostic>) {
    if resolved.blocks.is_empty() {
        return;
    }
    let filled: Vec<(&str, &Block)> = graph.passes.iter().flat_map(filled).collect();
    for shared in &resolved.blocks {
        let name = &shared.name;
        let of_name = filled.iter().filter(|(instance, block)| {
            Given::shared(resolved, instance, &block.name).is_some_and(|fills| std::ptr::eq(fills, shared))
        });
        let mut paths: Option<HashSet<String>> = None;
        for (_, block) in of_name {
            let leaves = leaves(block).unwrap_or_default();
            paths.get_or_insert_default().extend(leaves.into_iter().map(|leaf| leaf.path));
        }
        let Some(paths) = paths else {
            let known = filled.iter().flat_map(|(instance, block)| [*instance, block.name.as_str()]);
            let warning = Diagnostic::warning(codes::graph::UNUSED, format!("block `{}` is not used", name.value))
                .label(name.span.clone(), "no shader has a push-constant or uniform block of that name");
            found.push(match closest(&name.value, known.filter(|known| !known.is_empty())) {
                Some(known) => warning.help(format!("did you mean `{known}`?")),
                None => warning,
            });
            continue;
        };
        for member in &shared.members {
            let path = &member.path.value;
            // An element of an array is written `weights[2]`; its array is the leaf.
            let array = path.strip_suffix(']').and_then(|path| path.rsplit_once('[')).map(|(array, _)| array);
            if !paths.contains(path) && !array.is_some_and(|array| paths.contains(array)) {
                let message = format!("`{path}` of block `{}` is not used", name.value);
                let warning = Diagnostic::warning(codes::graph::UNUSED, message)
                    .label(member.path.span.clone(), "no shader's block of that name has this member");
                found.push(match closest(path, paths.iter().map(String::as_str)) {
                    Some(near) => warning.help(format!("did you mean `{near}`?")),
                    None => warning,
                });
            }
        }
    }
}

/// The blocks of a pass that the graph fills, each with the name of its instance.
fn filled(pass: &raxel_graph::checked::Pass) -> Vec<(&str, &Block)> {
    let interface = &pass.shader.interface;
    let push = interface.push.iter().map(|block| (interface.push_name.as_str(), block));
    let uniforms = pass.uniforms.iter().filter_map(|uniform| {
        let binding = interface.bindings.get(uniform.binding as usize)?;
        match &binding.kind {
            BindingKind::UniformBuffer(block) => Some((binding.name.as_str(), block)),
            _ => None,
        }
    });
    push.chain(uniforms).collect()
}
