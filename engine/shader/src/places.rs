//! Finds where the sources declare what reflection reports, so that a diagnostic can point at it.

use std::sync::Arc;

use raxel_diagnostics::Span;

use crate::interface::{Binding, BindingKind, Block, Interface, Type};
use crate::lexer::{self, Token};
use crate::sources::Sources;

/// Fills every `place` that can be found.
pub(crate) fn fill(interface: &mut Interface, sources: &Sources<'_>) {
    let texts: Vec<_> =
        sources.found.iter().map(|source| (Arc::from(source.name.as_str()), lexer::tokens(&source.text))).collect();
    let finder = Finder { texts };
    for binding in &mut interface.bindings {
        finder.binding(binding);
        if binding.place.is_none() {
            binding.place = sources.world_include(&binding.name).cloned();
        }
    }
    if let Some(push) = &mut interface.push {
        finder.block(push);
    }
    for constant in &mut interface.specialization {
        constant.place = finder.constant(constant.id, &constant.name);
    }
}

struct Finder<'t> {
    /// Name and tokens of each file; the shader itself is the first.
    texts: Vec<(Arc<str>, Vec<Token<'t>>)>,
}

impl Finder<'_> {
    fn first(&self, find: impl Fn(&[Token<'_>]) -> Option<usize>) -> Option<Span> {
        self.texts.iter().find_map(|(file, tokens)| {
            let at = find(tokens)?;
            Some(Span { file: file.clone(), range: tokens[at].range() })
        })
    }

    fn binding(&self, binding: &mut Binding) {
        let name = &binding.name;
        match &mut binding.kind {
            BindingKind::StorageBuffer(block) | BindingKind::UniformBuffer(block) => {
                // `buffer Block { … } name;`, or the block itself when it has no instance name, or `StructuredBuffer<T> name`.
                let block_name = block.name.clone();
                binding.place = self
                    .first(|tokens| {
                        let open = body(tokens, &block_name)?;
                        let after = close(tokens, open)? + 1;
                        tokens.get(after).filter(|token| token.text == name).map(|_| after)
                    })
                    .or_else(|| self.first(|tokens| body(tokens, name).map(|open| open - 1)))
                    .or_else(|| self.declaration(name));
                self.block(block);
            }
            _ => binding.place = self.declaration(name),
        }
    }

    /// `Type name`, followed by `;`, `[`, `,`, `:`, `=` or `)`; a global one if there is any.
    fn declaration(&self, name: &str) -> Option<Span> {
        let declares = |tokens: &[Token<'_>], global: bool| {
            let mut depth = 0usize;
            for (at, token) in tokens.iter().enumerate() {
                match token.text {
                    "{" => depth += 1,
                    "}" => depth = depth.saturating_sub(1),
                    text if text == name && (depth == 0 || !global) && at > 0 => {
                        let before = &tokens[at - 1];
                        let after = tokens.get(at + 1).map_or(";", |token| token.text);
                        let typed = before.is_identifier() || matches!(before.text, ">" | ",");
                        if typed && matches!(after, ";" | "[" | "," | ":" | "=" | ")") {
                            return Some(at);
                        }
                    }
                    _ => {}
                }
            }
            None
        };
        self.first(|tokens| declares(tokens, true)).or_else(|| self.first(|tokens| declares(tokens, false)))
    }

    fn block(&self, block: &mut Block) {
        if block.name.is_empty() {
            return;
        }
        for index in 0..block.members.len() {
            let name = block.members[index].name.clone();
            let place = self.first(|tokens| {
                let open = body(tokens, &block.name)?;
                member(tokens, open, &name)
            });
            let member = &mut block.members[index];
            member.place = place;
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

    /// `layout(constant_id = N) const T name`, or `local_size_x_id = N`.
    fn constant(&self, id: u32, name: &str) -> Option<Span> {
        let id = id.to_string();
        self.first(|tokens| {
            let at = (2..tokens.len()).find(|at| {
                let word = tokens[at - 2].text;
                let sized = word.starts_with("local_size_") && word.ends_with("_id");
                tokens[*at].text == id && tokens[at - 1].text == "=" && (word == "constant_id" || sized)
            })?;
            (at..tokens.len().min(at + 8)).find(|next| !name.is_empty() && tokens[*next].text == name).or(Some(at))
        })
    }
}

/// The `{` of `name { … }` or `name : register(…) { … }`, at token 1 or later.
fn body(tokens: &[Token<'_>], name: &str) -> Option<usize> {
    (0..tokens.len().saturating_sub(1)).find_map(|at| {
        if tokens[at].text != name {
            return None;
        }
        match tokens[at + 1].text {
            "{" => Some(at + 1),
            ":" => (at + 2..tokens.len().min(at + 12))
                .take_while(|next| tokens[*next].text != ";")
                .find(|next| tokens[*next].text == "{"),
            _ => None,
        }
    })
}

/// The `}` that closes the `{` at `open`.
fn close(tokens: &[Token<'_>], open: usize) -> Option<usize> {
    let mut depth = 0usize;
    tokens.iter().enumerate().skip(open).find_map(|(at, token)| {
        match token.text {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            _ => return None,
        }
        (depth == 0).then_some(at)
    })
}

/// The member `name` of the body that starts at `open`: after a type or a comma, before `;`, `[`, `,` or `:`.
fn member(tokens: &[Token<'_>], open: usize, name: &str) -> Option<usize> {
    let end = close(tokens, open)?;
    (open + 2..end).find(|at| {
        tokens[*at].text == name
            && matches!(tokens[at + 1].text, ";" | "[" | "," | ":")
            && (tokens[at - 1].is_identifier() || matches!(tokens[at - 1].text, "," | ">" | "]"))
    })
}
