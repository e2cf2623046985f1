//! Push constants and uniform blocks: every member of the shader's block has one value, of its type, at its offset.

use std::collections::BTreeSet;

use raxel_diagnostics::names::closest;
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_graph::checked::{Fill, UniformBlock, ValueOrigin};
use raxel_graph::index32;
use raxel_graph::value::{ValueType, glsl};
use raxel_shader::interface::{Binding, BindingKind, Block, Member as ShaderMember, Type};

use super::given::Given;
use super::{Context, loops};
use crate::literal::{describe, typed};
use crate::model::Data;
use crate::resolve::{Feed, Member};

/// Bytes of push constants that every Vulkan device has.
const PUSH_BYTES: u32 = 128;
/// Members that a block may have, those of structs and arrays of structs counted one by one.
const MOST_MEMBERS: usize = 4096;

/// Checks the push-constant block; gives its values in order of offset.
pub(crate) fn push(context: &Context<'_>, found: &mut Vec<Diagnostic>) -> Vec<Fill> {
    let pass = &context.pass.name;
    let interface = context.interface();
    let Some(block) = &interface.push else {
        if let Some(given) = &context.pass.push {
            found.push(without_push(context, &given.name.span));
        }
        return Vec::new();
    };
    let shared = Given::shared(context.graph, &interface.push_name, &block.name);
    let Some(given) = Given::new(context.pass.push.as_ref(), shared) else {
        if context.pass.sound {
            found.push(undeclared(context, block));
        }
        return Vec::new();
    };
    if block.size > PUSH_BYTES {
        let place = block.members.last().and_then(|member| member.place.as_ref());
        let diagnostic = Diagnostic::error(
            codes::graph::PUSH_SIZE,
            format!("push constants of {} bytes; every device has {PUSH_BYTES}, not all have more", block.size),
        )
        .label(given.name().span.clone(), format!("the push layout of pass `{}`", pass.value));
        let diagnostic = context.in_shader(diagnostic, place, "the last member");
        found.push(diagnostic.help(
            "move members to a uniform block, `layout(std140) uniform NAME { … } name;`, filled by `[passes.uniforms.name]`",
        ));
    }
    fills(context, "push constant", block, &given, found)
}

/// The pass gives push constants to a shader that uses none.
fn without_push(context: &Context<'_>, given: &Span) -> Diagnostic {
    let (shader, pass) = (&context.shader.request.path, &context.pass.name.value);
    let filled = format!("filled for pass `{pass}`");
    if let Some(block) = &context.interface().unused.push {
        let message = format!("`{shader}` declares push constants and does not use them");
        let diagnostic = context.unused(codes::graph::NO_BLOCK, message).label(given.clone(), filled);
        let place = block.members.first().and_then(|member| member.place.as_ref());
        let diagnostic = context.in_shader(diagnostic, place, "the first member");
        return diagnostic.help("use one of them in the shader, or take the block out");
    }
    let message = format!("pass `{pass}` gives push constants, but `{shader}` declares none");
    let diagnostic = context.unused(codes::graph::NO_BLOCK, message).label(given.clone(), filled);
    diagnostic.help("declare `layout(push_constant) uniform` in the shader, or take the block out")
}

fn undeclared(context: &Context<'_>, block: &Block) -> Diagnostic {
    let pass = &context.pass.name;
    let diagnostic = Diagnostic::error(
        codes::graph::MEMBER_MISSING,
        format!("the shader has push constants, but pass `{}` declares none", pass.value),
    )
    .label(pass.span.clone(), "needs `[passes.push]`");
    let place = block.members.first().and_then(|member| member.place.as_ref());
    let diagnostic = context.in_shader(diagnostic, place, "the first member");
    let members: Vec<String> =
        block.members.iter().map(|member| format!("{} {}", glsl(&member.ty), member.name)).collect();
    diagnostic.help(format!("the members are: {}", members.join(", ")))
}

/// Checks the uniform blocks that the graph fills.
pub(crate) fn uniforms(context: &Context<'_>, found: &mut Vec<Diagnostic>) -> Vec<UniformBlock> {
    let bindings = &context.interface().bindings;
    let mut blocks = Vec::new();
    for (index, binding) in bindings.iter().enumerate() {
        let BindingKind::UniformBuffer(block) = &binding.kind else { continue };
        // A block that is bound to a buffer takes nothing from `[blocks.*]`.
        let bound = context.pass.bind.iter().any(|entry| entry.name.value == binding.name);
        let own = context.pass.uniforms.iter().find(|given| given.name.value == binding.name);
        let shared = Given::shared(context.graph, &binding.name, &block.name).filter(|_| !bound);
        if let Some(given) = Given::new(own, shared) {
            let fills = fills(context, "uniform", block, &given, found);
            blocks.push(UniformBlock { binding: index32(index), size: block.size, fills });
        }
    }
    let is_uniform = |binding: &&Binding| matches!(binding.kind, BindingKind::UniformBuffer(_));
    for given in &context.pass.uniforms {
        let of_name = |binding: &&Binding| binding.name == given.name.value;
        if !bindings.iter().filter(is_uniform).any(|binding| of_name(&binding)) {
            found.push(without_uniform(context, &given.name));
        }
    }
    blocks
}

/// The pass fills a uniform block that the shader does not use.
fn without_uniform(context: &Context<'_>, given: &Spanned<String>) -> Diagnostic {
    let interface = context.interface();
    let (shader, name) = (&context.shader.request.path, given.value.as_str());
    let filled = format!("filled for pass `{}`", context.pass.name.value);
    let of_name = |binding: &&Binding| binding.name == name;
    if let Some(binding) = interface.bindings.iter().find(of_name) {
        let message = format!("`{shader}` has no uniform block `{name}`");
        let diagnostic = Diagnostic::error(codes::graph::NO_BLOCK, message).label(given.span.clone(), filled);
        return context.in_shader(diagnostic, binding.place.as_ref(), "this is not a uniform block");
    }
    if let Some(binding) = interface.unused.bindings.iter().find(of_name) {
        let message = format!("`{shader}` declares `{name}` and does not use it");
        let diagnostic = context.unused(codes::graph::NO_BLOCK, message).label(given.span.clone(), filled);
        let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), "declared here, without a use");
        return diagnostic.help(format!("use `{name}` in the shader, or take the block out"));
    }
    let blocks = || {
        interface.bindings.iter().filter_map(|binding| match &binding.kind {
            BindingKind::UniformBuffer(block) => Some((binding.name.as_str(), block)),
            _ => None,
        })
    };
    let message = format!("`{shader}` has no uniform block `{name}`");
    let by_type = blocks().find(|(_, block)| block.name == name).map(|(name, _)| name);
    match by_type.or_else(|| closest(name, blocks().map(|(name, _)| name))) {
        Some(meant) => Diagnostic::error(codes::graph::NO_BLOCK, message)
            .label(given.span.clone(), filled)
            .help(format!("did you mean `{meant}`?")),
        None => context
            .unused(codes::graph::NO_BLOCK, message)
            .label(given.span.clone(), filled)
            .help(format!("declare `{name}` in the shader and use it, or take the block out")),
    }
}

/// A member that takes one value, or an array of scalars or vectors that takes a list of them.
pub(crate) struct Leaf<'a> {
    /// Path in the block, e.g. `sun.direction`, `lights[2].color`.
    pub path: String,
    offset: u32,
    ty: &'a Type,
    place: Option<&'a Span>,
}

/// Every leaf of a block in order of declaration. `None` when there are too many.
pub(crate) fn leaves(block: &Block) -> Option<Vec<Leaf<'_>>> {
    let mut leaves = Vec::new();
    for member in &block.members {
        collect(&member.name, member.offset, &member.ty, member, &mut leaves)?;
    }
    Some(leaves)
}

fn collect<'a>(
    path: &str,
    offset: u32,
    ty: &'a Type,
    within: &'a ShaderMember,
    leaves: &mut Vec<Leaf<'a>>,
) -> Option<()> {
    match ty {
        Type::Struct(block) => {
            for member in &block.members {
                collect(&format!("{path}.{}", member.name), offset + member.offset, &member.ty, member, leaves)?;
            }
        }
        Type::Array { element, len: Some(len), stride }
            if matches!(**element, Type::Struct(_) | Type::Array { .. }) =>
        {
            for index in 0..*len {
                let offset = offset.saturating_add(index.saturating_mul(*stride));
                collect(&format!("{path}[{index}]"), offset, element, within, leaves)?;
            }
        }
        _ => leaves.push(Leaf { path: path.to_owned(), offset, ty, place: within.place.as_ref() }),
    }
    (leaves.len() <= MOST_MEMBERS).then_some(())
}

/// Checks the values of one block.
fn fills(
    context: &Context<'_>,
    what: &str,
    block: &Block,
    given: &Given<'_>,
    found: &mut Vec<Diagnostic>,
) -> Vec<Fill> {
    let Some(leaves) = leaves(block) else {
        found.push(
            Diagnostic::error(
                codes::graph::TOO_MANY,
                format!("block `{}` has more than {MOST_MEMBERS} members that need a value", block.name),
            )
            .label(given.name().span.clone(), "")
            .help("bind a buffer instead"),
        );
        return Vec::new();
    };
    let mut fills = Vec::with_capacity(leaves.len());
    // A list of values may also be given element by element.
    let mut used: BTreeSet<String> = BTreeSet::new();
    let mut missing = Vec::new();
    let mut put = |leaf: &Leaf<'_>, (member, shared): (&Member, bool), found: &mut Vec<Diagnostic>| {
        let mut wrong = Vec::new();
        Slot { context, what, leaf }.whole(member, &mut fills, &mut wrong);
        // A mistake in a shared value is a mistake in every pass whose shader declares the block in the same file.
        found.extend(wrong.into_iter().filter(|wrong| !shared || !found.contains(wrong)).collect::<Vec<_>>());
    };
    for leaf in &leaves {
        if let Some(member) = given.member(&leaf.path) {
            used.insert(leaf.path.clone());
            put(leaf, member, found);
            continue;
        }
        let Type::Array { element, len: Some(len), stride } = leaf.ty else {
            missing.push(leaf);
            continue;
        };
        if !given.has_elements(&leaf.path) {
            missing.push(leaf);
            continue;
        }
        for index in 0..*len {
            let value = given.element(&leaf.path, index);
            let path = format!("{}[{index}]", leaf.path);
            let leaf = Leaf { path, offset: leaf.offset + index * stride, ty: element, place: leaf.place };
            match value {
                Some((member, shared)) => {
                    put(&leaf, (&member, shared), found);
                    used.insert(leaf.path);
                }
                None if context.pass.sound => once(absent(context, what, &leaf, given), found),
                None => {}
            }
        }
    }
    // If one member is unknown to the shader and another one has no value, the name is often misspelt.
    for member in given.own().filter(|member| !used.contains(&member.path.value)) {
        let meant = closest(&member.path.value, missing.iter().map(|leaf| leaf.path.as_str()));
        let meant = missing.iter().position(|leaf| Some(leaf.path.as_str()) == meant);
        let meant = meant.map(|index| missing.remove(index));
        found.push(extra(context, what, block, member, meant));
    }
    if context.pass.sound {
        for leaf in missing {
            once(absent(context, what, leaf, given), found);
        }
    }
    fills.sort_by_key(|fill| fill.offset);
    fills
}

/// A member that a shared block lacks is missing in every pass whose shader declares the block in the same file.
fn once(diagnostic: Diagnostic, found: &mut Vec<Diagnostic>) {
    if !found.contains(&diagnostic) {
        found.push(diagnostic);
    }
}

fn absent(context: &Context<'_>, what: &str, leaf: &Leaf<'_>, given: &Given<'_>) -> Diagnostic {
    let name = leaf.path.as_str();
    let whose = if given.is_shared() {
        format!("`[blocks.{}]`", given.name().value)
    } else {
        format!("pass `{}`", context.pass.name.value)
    };
    let message = format!("{what} `{name}` of the shader has no value in {whose}");
    let diagnostic = Diagnostic::error(codes::graph::MEMBER_MISSING, message)
        .label(given.name().span.clone(), format!("`{name}` is missing here"));
    let text = format!("`{}` at offset {}", glsl(leaf.ty), leaf.offset);
    let diagnostic = context.in_shader(diagnostic, leaf.place, text);
    if let Some(near) = given.nearest_shared(name) {
        let diagnostic = diagnostic.label(near.path.span.clone(), "the nearest name");
        return diagnostic.help(format!("is `{}` meant to be `{name}`?", near.path.value));
    }
    let example = match leaf.ty {
        Type::Array { element, len: Some(len), .. } => {
            ValueType::of_member(element).map(|ty| format!("{}[{len}]", ty.word()))
        }
        ty => ValueType::of_member(ty).map(|ty| ty.word().to_owned()),
    };
    let example = example.unwrap_or_else(|| "…".to_owned());
    let key = if name.contains(['.', '[']) { format!("\"{name}\"") } else { name.to_owned() };
    diagnostic.help(format!("add e.g. `{key} = {{ type = \"{example}\", from = \"…\" }}`"))
}

fn extra(context: &Context<'_>, what: &str, block: &Block, member: &Member, meant: Option<&Leaf<'_>>) -> Diagnostic {
    let message = format!("the shader has no {what} `{}`", member.path.value);
    let place =
        |diagnostic: Diagnostic| diagnostic.label(member.path.span.clone(), format!("not in block `{}`", block.name));
    let error = |message| place(Diagnostic::error(codes::graph::MEMBER_EXTRA, message));
    if let Some(leaf) = meant {
        let diagnostic = context.in_shader(error(message), leaf.place, "the shader's nearest name");
        return diagnostic.help(format!("did you mean `{}`?", leaf.path));
    }
    match block.members.iter().find(|other| other.name == member.path.value) {
        Some(other) => context
            .in_shader(error(message), other.place.as_ref(), "a struct")
            .help("give its members one by one, e.g. with a table"),
        None => place(context.unused(codes::graph::MEMBER_EXTRA, message)),
    }
}

/// One member of the shader and the facts for messages about it.
struct Slot<'a> {
    context: &'a Context<'a>,
    /// `push constant` or `uniform`.
    what: &'a str,
    leaf: &'a Leaf<'a>,
}

impl Slot<'_> {
    /// Checks the graph's values of the member, and adds them.
    fn whole(&self, member: &Member, fills: &mut Vec<Fill>, found: &mut Vec<Diagnostic>) {
        let leaf = self.leaf;
        self.offset(member, found);
        let (element, len, apart) = match leaf.ty {
            Type::Array { element, len: Some(len), stride } => (&**element, Some(*len), *stride),
            ty => (ty, None, 0),
        };
        let Some(ty) = ValueType::of_member(element) else {
            found.push(self.unfillable(member));
            return;
        };
        if let Some(declared) = &member.ty {
            let (word, declared_len) = declared.value;
            if !word.fits(ty) || declared_len != len {
                found.push(self.mismatch(declared, ty, len));
                return;
            }
        }
        let Some(feed) = &member.feed else { return };
        let mut put = |index: u32, from: ValueOrigin| {
            let path = if len.is_some() { format!("{}[{index}]", leaf.path) } else { leaf.path.clone() };
            let stride = match element {
                Type::Matrix { stride, .. } => *stride,
                _ => 0,
            };
            let offset = leaf.offset + index * apart;
            fills.push(Fill { member: path, offset, ty, stride, from });
        };
        match (&feed.value, len) {
            (Feed::From(ValueOrigin::Round(index), from), None) if from.fits(ty) || ty.is_i32() => {
                if loops::around(self.context, *index, &feed.span, found).is_some() {
                    put(0, ValueOrigin::Round(*index));
                }
            }
            (Feed::From(source, from), None) if from.fits(ty) => put(0, source.clone()),
            (Feed::From(_, from), _) => found.push(self.wrong_source(member, &feed.span, *from)),
            (Feed::Literal(literal), None) => {
                // A boolean is written `true` though SPIR-V has it as an unsigned integer.
                let bool_ty = ValueType::scalar(raxel_shader::interface::Scalar::Bool);
                let value = typed(literal, ty).or_else(|| typed(literal, bool_ty).filter(|_| bool_ty.fits(ty)));
                match value {
                    Some(value) => put(0, ValueOrigin::Value(value)),
                    None => found.push(self.wrong_literal(&feed.span, &describe(literal))),
                }
            }
            (Feed::Literal(literal), Some(len)) => match &literal.data {
                Data::Array(elements) if elements.len() == len as usize => {
                    for (index, element) in elements.iter().enumerate() {
                        match typed(element, ty) {
                            Some(value) => put(index32(index), ValueOrigin::Value(value)),
                            None => found.push(self.wrong_literal(&element.span, &describe(element))),
                        }
                    }
                }
                _ => found.push(self.wrong_literal(&feed.span, &describe(literal))),
            },
        }
    }

    fn offset(&self, member: &Member, found: &mut Vec<Diagnostic>) {
        let Some(offset) = member.offset.as_ref().filter(|offset| offset.value != self.leaf.offset) else { return };
        let diagnostic = Diagnostic::error(
            codes::graph::MEMBER_OFFSET,
            format!(
                "{} `{}` is at offset {} in the shader, but the graph declares {}",
                self.what, self.leaf.path, self.leaf.offset, offset.value
            ),
        )
        .label(offset.span.clone(), "declared here");
        let diagnostic = self.context.in_shader(diagnostic, self.leaf.place, "the shader says");
        found.push(diagnostic.help(format!("change the offset to {}", self.leaf.offset)));
    }

    fn mismatch(&self, declared: &Spanned<(ValueType, Option<u32>)>, ty: ValueType, len: Option<u32>) -> Diagnostic {
        let word = |ty: ValueType, len: Option<u32>| match len {
            Some(len) => format!("{}[{len}]", ty.word()),
            None => ty.word().to_owned(),
        };
        let diagnostic = Diagnostic::error(
            codes::graph::MEMBER_TYPE,
            format!(
                "{} `{}` is `{}` at offset {} in the shader, but the graph declares `{}`",
                self.what,
                self.leaf.path,
                glsl(self.leaf.ty),
                self.leaf.offset,
                word(declared.value.0, declared.value.1)
            ),
        )
        .label(declared.span.clone(), "declared here");
        let diagnostic = self.context.in_shader(diagnostic, self.leaf.place, "the shader says");
        diagnostic.help(format!("change the type to \"{}\"", word(ty, len)))
    }

    fn wrong_source(&self, member: &Member, place: &Span, from: ValueType) -> Diagnostic {
        let diagnostic = Diagnostic::error(
            codes::graph::VALUE_TYPE,
            format!(
                "{} `{}` is `{}` in the shader, but its value is `{}`",
                self.what,
                member.path.value,
                glsl(self.leaf.ty),
                from.word()
            ),
        )
        .label(place.clone(), format!("this is `{}`", from.word()));
        self.context.in_shader(diagnostic, self.leaf.place, "the shader says")
    }

    fn wrong_literal(&self, place: &Span, is: &str) -> Diagnostic {
        let diagnostic = Diagnostic::error(
            codes::graph::LITERAL,
            format!(
                "{} `{}` is `{}` in the shader, but its value is {is}",
                self.what,
                self.leaf.path,
                glsl(self.leaf.ty)
            ),
        )
        .label(place.clone(), "");
        self.context.in_shader(diagnostic, self.leaf.place, "the shader says")
    }

    fn unfillable(&self, member: &Member) -> Diagnostic {
        let diagnostic = Diagnostic::error(
            codes::graph::UNFILLABLE,
            format!("{} `{}` is `{}`, which a graph cannot fill", self.what, self.leaf.path, glsl(self.leaf.ty)),
        )
        .label(member.path.span.clone(), "");
        let words: Vec<&str> = ValueType::words().collect();
        self.context
            .in_shader(diagnostic, self.leaf.place, "the shader says")
            .help(format!("a graph fills {}, and arrays of these", words.join(", ")))
    }
}
