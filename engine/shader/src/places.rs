//! Finds the declarations of reflected names in the sources, so that a diagnostic can point at them. Names are looked up in an index of all
//! tokens: a shader may have as many members as it has lines.

use std::collections::HashMap;
use std::sync::Arc;

use raxel_diagnostics::Span;

use crate::interface::{Binding, BindingKind, Block, Interface, Type};
use crate::lexer::{self, Token};
use crate::sources::Sources;

/// Fills every `place` that can be found.
pub(crate) fn fill(interface: &mut Interface, sources: &Sources<'_>) {
    let texts = Index { texts: sources.found.iter().map(|source| Text::new(&source.name, &source.text)).collect() };
    for binding in interface.bindings.iter_mut().chain(&mut interface.unused.bindings) {
        texts.binding(binding);
        if binding.place.is_none() {
            binding.place = sources.world_include(&binding.name).cloned();
        }
    }
    for push in interface.push.iter_mut().chain(&mut interface.unused.push) {
        texts.block(push);
    }
    for constant in &mut interface.specialization {
        constant.place = texts.constant(constant.id, &constant.name);
    }
}

/// The files of a shader; the shader itself is the first.
struct Index<'t> {
    texts: Vec<Text<'t>>,
}

/// One file.
struct Text<'t> {
    name: Arc<str>,
    tokens: Vec<Token<'t>>,
    /// Where each token text stands, in order.
    positions: HashMap<&'t str, Vec<usize>>,
    /// How many braces are open at each token.
    depths: Vec<usize>,
    /// The `}` of each `{`.
    closing: HashMap<usize, usize>,
}

impl<'t> Text<'t> {
    fn new(name: &str, text: &'t str) -> Self {
        let tokens = lexer::tokens(text);
        let mut positions: HashMap<&str, Vec<usize>> = HashMap::new();
        let (mut depths, mut closing) = (Vec::with_capacity(tokens.len()), HashMap::new());
        let mut open = Vec::new();
        for (at, token) in tokens.iter().enumerate() {
            positions.entry(token.text).or_default().push(at);
            depths.push(open.len());
            match token.text {
                "{" => open.push(at),
                "}" => closing.extend(open.pop().map(|open| (open, at))),
                _ => {}
            }
        }
        Self { name: name.into(), tokens, positions, depths, closing }
    }

    fn positions(&self, text: &str) -> &[usize] {
        self.positions.get(text).map_or(&[], Vec::as_slice)
    }

    /// The text of a token; empty past the end.
    fn at(&self, at: usize) -> &str {
        self.tokens.get(at).map_or("", |token| token.text)
    }

    /// The `{` of `name { … }` or `name : register(…) { … }`.
    fn body(&self, name: &str) -> Option<usize> {
        self.positions(name).iter().find_map(|at| match self.at(at + 1) {
            "{" => Some(at + 1),
            ":" => (at + 2..at + 12).take_while(|next| self.at(*next) != ";").find(|next| self.at(*next) == "{"),
            _ => None,
        })
    }

    /// `Type name`, followed by `;`, `[`, `,`, `:`, `=` or `)`.
    fn declaration(&self, name: &str, global: bool) -> Option<usize> {
        self.positions(name).iter().copied().filter(|at| *at > 0 && (self.depths[*at] == 0 || !global)).find(|at| {
            let before = &self.tokens[at - 1];
            let typed = before.is_identifier() || matches!(before.text, ">" | ",");
            typed && matches!(self.at(at + 1), "" | ";" | "[" | "," | ":" | "=" | ")")
        })
    }

    /// The member `name` of the body that starts at `open`: after a type or a comma, before `;`, `[`, `,` or `:`.
    fn member(&self, open: usize, name: &str) -> Option<usize> {
        let end = *self.closing.get(&open)?;
        let positions = self.positions(name);
        let first = positions.partition_point(|at| *at < open + 2);
        positions[first..].iter().copied().take_while(|at| *at < end).find(|at| {
            let before = &self.tokens[at - 1];
            matches!(self.at(at + 1), ";" | "[" | "," | ":")
                && (before.is_identifier() || matches!(before.text, "," | ">" | "]"))
        })
    }

    /// The member `name` in a file that is included inside a body: one without braces of its own.
    fn included_member(&self, name: &str) -> Option<usize> {
        if self.closing.is_empty() { self.declaration(name, true) } else { None }
    }

    /// The number in `layout(constant_id = N) const T name`, or in `local_size_x_id = N`; rather its name, if it has one.
    fn constant(&self, id: &str, name: &str) -> Option<usize> {
        let at = self.positions(id).iter().copied().filter(|at| *at >= 2).find(|at| {
            let word = self.at(at - 2);
            let sized = word.starts_with("local_size_") && word.ends_with("_id");
            self.at(at - 1) == "=" && (word == "constant_id" || sized)
        })?;
        (at..at + 8).find(|next| !name.is_empty() && self.at(*next) == name).or(Some(at))
    }
}

impl Index<'_> {
    fn first(&self, find: impl Fn(&Text<'_>) -> Option<usize>) -> Option<Span> {
        self.texts.iter().find_map(|text| {
            let at = find(text)?;
            Some(Span { file: text.name.clone(), range: text.tokens[at].range() })
        })
    }

    fn binding(&self, binding: &mut Binding) {
        let name = &binding.name;
        match &mut binding.kind {
            BindingKind::StorageBuffer(block) | BindingKind::UniformBuffer(block) => {
                // `buffer Block { … } name;`, or the block itself when it has no instance name, or `StructuredBuffer<T> name`.
                let block_name = block.name.clone();
                binding.place = self
                    .first(|text| {
                        let after = *text.closing.get(&text.body(&block_name)?)? + 1;
                        (text.at(after) == name).then_some(after)
                    })
                    .or_else(|| self.first(|text| text.body(name).map(|open| open - 1)))
                    .or_else(|| self.declaration(name));
                self.block(block);
            }
            _ => binding.place = self.declaration(name),
        }
    }

    /// A global declaration if there is any.
    fn declaration(&self, name: &str) -> Option<Span> {
        self.first(|text| text.declaration(name, true)).or_else(|| self.first(|text| text.declaration(name, false)))
    }

    fn block(&self, block: &mut Block) {
        if block.name.is_empty() {
            return;
        }
        for member in &mut block.members {
            member.place = self
                .first(|text| text.member(text.body(&block.name)?, &member.name))
                .or_else(|| self.first(|text| text.included_member(&member.name)));
            self.nested(&mut member.ty);
        }
    }

    fn nested(&self, ty: &mut Type) {
        match ty {
            Type::Struct(block) => self.block(block),
            Type::Array { element, .. } => self.nested(element),
            _ => {}
        }
    }

    fn constant(&self, id: u32, name: &str) -> Option<Span> {
        let id = id.to_string();
        self.first(|text| text.constant(&id, name))
    }
}
