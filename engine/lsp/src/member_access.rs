//! Members of structures, blocks and vectors: what can stand behind a dot, and what a name behind a dot means. `expressions.rs` finds the type in
//! front of the dot. Where it finds none there is no answer.

use std::ops::Range;

use raxel_shader::library;

use super::documents::Document;
use super::expressions::{Names, call_at, operand, type_of};
use super::glsl::{Declaration, DeclarationKind, Member, comment_on, is_name, members, type_before, without_comments};
use super::glsl_types::Numeric;
use super::names::identifier;
use super::project_texts::{ProjectText, declared_in};
use super::scopes::local_at;
use super::{builtins, call_types};

/// A member as an editor shows it.
pub(super) struct KnownMember<'t> {
    pub name: String,
    /// In Markdown.
    pub about: String,
    ty: String,
    /// Where it is declared; components of a vector are nowhere.
    pub declared: Option<(&'t ProjectText, Range<usize>)>,
}

/// The members of a block or structure.
pub(super) fn members_of<'t>(text: &'t ProjectText, known: &Declaration) -> Vec<KnownMember<'t>> {
    let body = known.body.clone().unwrap_or_default();
    let owner = known.block.as_deref().unwrap_or(&known.name);
    let described = |member: Member| {
        let comment = comment_on_member(&text.text, &member.whole);
        let comment = if comment.is_empty() { comment } else { format!("{comment}\n\n") };
        let declaration = &text.text[member.whole.clone()];
        let about = format!("```glsl\n{declaration}\n```\n{comment}A member of `{owner}`. `{}`", text.path);
        KnownMember { name: member.name, about, ty: member.ty, declared: Some((text, member.place)) }
    };
    members(text.text.code(), body).into_iter().map(described).collect()
}

/// The comment on a member. What stands above a member on the line of the brace is the comment on the whole.
fn comment_on_member(text: &str, whole: &Range<usize>) -> String {
    let line = text[..whole.start].rfind('\n').map_or(0, |end| end + 1);
    let own_line = text[line..whole.start].trim().is_empty();
    if own_line { comment_on(text, whole) } else { String::new() }
}

/// Whether the name at a byte of a shader stands behind a dot, as the point of a number does not.
pub(super) fn is_behind_dot(text: &str, at: usize) -> bool {
    text[..at].trim_end_matches(is_name).trim_end().ends_with('.')
}

/// What can stand behind the dot before a byte of a shader. Empty where the type in front of the dot is not known.
pub(super) fn offered<'t>(document: &Document, texts: &'t [ProjectText], at: usize) -> Vec<KnownMember<'t>> {
    let shader = Shader { document, texts };
    let Some(ty) = shader.type_before_dot(at) else { return Vec::new() };
    match Components::of(&ty) {
        Some(vector) => vector.selections().iter().filter_map(|selection| vector.select(selection)).collect(),
        None => shader.members(&ty),
    }
}

/// The member that a name at a byte of a shader means: behind a dot, where it is declared, or a plain name if its block has no instance name.
pub(super) fn under<'t>(document: &Document, texts: &'t [ProjectText], at: usize) -> Option<KnownMember<'t>> {
    let shader = Shader { document, texts };
    let name = identifier(&document.text, at);
    if is_behind_dot(&document.text, at) {
        return shader.member(&shader.type_before_dot(at)?, name);
    }
    shader.declared_under(at).or_else(|| shader.plain(name))
}

/// The type of the call of a function of GLSL whose name is at a byte of a shader, if it follows the arguments.
pub(super) fn call_under(document: &Document, texts: &[ProjectText], at: usize) -> Option<String> {
    let text = &document.text;
    let start = text[..at].trim_end_matches(is_name).len();
    let name = start..start + text[start..].find(|c| !is_name(c))?;
    let is_generic = builtins::named(&text[name.clone()]).is_some_and(|builtin| call_types::is_generic(&builtin));
    let code = without_comments(text);
    let call = call_at(&code, &name).filter(|_| is_generic)?;
    type_of(&code, call, &Shader { document, texts })
}

/// A shader with what it includes.
struct Shader<'d, 't> {
    document: &'d Document,
    texts: &'t [ProjectText],
}

impl Names for Shader<'_, '_> {
    fn variable(&self, name: &str, at: usize) -> Option<String> {
        let text = &self.document.text;
        if let Some(local) = local_at(text.locals(), name, at) {
            return Some(format!("{}{}", type_before(&local.ty), lengths_at(text.code(), local.place.end)));
        }
        let is_value = |known: &Declaration| match known.kind {
            DeclarationKind::Function | DeclarationKind::Struct => false,
            DeclarationKind::Push | DeclarationKind::Binding | DeclarationKind::Constant => known.name == name,
        };
        if let Some((text, known)) = declared_in(self.texts).find(|(_, known)| is_value(known)) {
            let code = text.text.code();
            let ty = known.block.as_deref().or_else(|| code.get(known.whole.start..known.place.start))?;
            return Some(format!("{}{}", type_before(ty), lengths_at(code, known.place.end)));
        }
        let of_glsl = || {
            let (ty, _) = builtins::named(name)?.declarations.split_once(' ').filter(|_| name.starts_with("gl_"))?;
            Some(ty.to_owned())
        };
        self.plain(name).map(|member| member.ty).or_else(of_glsl)
    }

    fn call(&self, name: &str, arguments: &[Option<String>]) -> Option<String> {
        self.return_type(name).or_else(|| call_types::result(&builtins::named(name)?, arguments))
    }

    fn member(&self, owner: &str, name: &str) -> Option<String> {
        self.member(owner, name).map(|member| member.ty)
    }
}

impl<'t> Shader<'_, 't> {
    /// The type of the expression in front of the dot before a byte.
    fn type_before_dot(&self, at: usize) -> Option<String> {
        let code = without_comments(&self.document.text);
        let before = code.get(..at)?.trim_end_matches(is_name).trim_end().strip_suffix('.')?;
        type_of(before, operand(before)?..before.len(), self)
    }

    /// The type of a call of a function or a constructor.
    fn return_type(&self, name: &str) -> Option<String> {
        if Numeric::named(name).is_some() || self.structure(name).is_some() {
            return Some(name.to_owned());
        }
        let is_it = |known: &Declaration| known.kind == DeclarationKind::Function && known.name == name;
        let own = declared_in(self.texts).find(|(_, known)| is_it(known));
        if let Some((text, known)) = own {
            return Some(type_before(text.text.get(known.whole.start..known.place.start)?));
        }
        let item = library::items().into_iter().find(|item| item.name == name)?;
        let (ty, _) = item.declaration.split_once(name)?;
        Some(type_before(ty))
    }

    /// The declaration of a type with members.
    fn structure(&self, ty: &str) -> Option<(&'t ProjectText, &'t Declaration)> {
        declared_in(self.texts).find(|(_, known)| known.body.is_some() && known.block.as_deref() == Some(ty))
    }

    fn members(&self, ty: &str) -> Vec<KnownMember<'t>> {
        self.structure(ty).map_or_else(Vec::new, |(text, known)| members_of(text, known))
    }

    fn member(&self, ty: &str, name: &str) -> Option<KnownMember<'t>> {
        match Components::of(ty) {
            Some(vector) => vector.select(name),
            None => self.members(ty).into_iter().find(|member| member.name == name),
        }
    }

    /// The member of a block without an instance name that a plain name means.
    fn plain(&self, name: &str) -> Option<KnownMember<'t>> {
        let is_plain = |known: &Declaration| {
            let is_block = matches!(known.kind, DeclarationKind::Push | DeclarationKind::Binding);
            is_block && known.block.as_deref() == Some(known.name.as_str())
        };
        let blocks = declared_in(self.texts).filter(|(_, known)| is_plain(known));
        blocks.flat_map(|(text, known)| members_of(text, known)).find(|member| member.name == name)
    }

    /// The member whose declaration is at a byte.
    fn declared_under(&self, at: usize) -> Option<KnownMember<'t>> {
        let own = self.texts.iter().find(|text| text.path == self.document.path)?;
        let around = |known: &&Declaration| known.body.as_ref().is_some_and(|body| body.contains(&at));
        let known = own.text.declarations().iter().find(around)?;
        let is_at = |place: &Range<usize>| place.contains(&at) || place.end == at;
        members_of(own, known)
            .into_iter()
            .find(|member| member.declared.as_ref().is_some_and(|(_, place)| is_at(place)))
    }
}

/// The `[…]` that begin at a byte: the lengths of the arrays that a declared name has.
fn lengths_at(code: &str, at: usize) -> &str {
    let rest = code.get(at..).unwrap_or_default();
    let (mut depth, mut end) = (0_usize, 0);
    for (place, letter) in rest.char_indices() {
        match letter {
            '[' => depth += 1,
            ']' => {
                depth = depth.saturating_sub(1);
                end = place + 1;
            }
            letter if depth == 0 && !letter.is_whitespace() => break,
            _ => {}
        }
    }
    rest[..end].trim()
}

/// The components of a vector.
struct Components {
    of: Numeric,
    size: usize,
}

impl Components {
    /// Those of the vector with this name.
    fn of(name: &str) -> Option<Self> {
        let of = Numeric::named(name)?;
        Some(Self { of, size: of.vector_size()? })
    }

    /// Components in their order, as positions and as colours: `x`, `y`, `xy`, …, `rgb`. All others are too many to choose from.
    fn selections(&self) -> Vec<String> {
        let of_set = |set: &'static str| {
            let chosen = move |bits: usize| -> String {
                let letters = set.chars().enumerate().filter(|(at, _)| bits >> at & 1 == 1);
                letters.map(|(_, letter)| letter).collect()
            };
            let mut found: Vec<String> = (1..1_usize << self.size).map(chosen).collect();
            found.sort_by_key(String::len);
            found
        };
        ["xyzw", "rgba"].into_iter().flat_map(of_set).collect()
    }

    /// What a swizzle of it means.
    fn select<'t>(&self, selection: &str) -> Option<KnownMember<'t>> {
        let of_set = |set: &str| selection.chars().all(|letter| set[..self.size].contains(letter));
        if !(1..=4).contains(&selection.len()) || !["xyzw", "rgba", "stpq"].into_iter().any(of_set) {
            return None;
        }
        let ty = self.of.with_rows(selection.len()).name();
        let what = if selection.len() == 1 { "A component" } else { "Components" };
        let about = format!("```glsl\n{ty} {selection}\n```\n{what} of a `{}`.", self.of.name());
        Some(KnownMember { name: selection.to_owned(), about, ty, declared: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lengths_of_an_array_stand_behind_its_name() {
        assert_eq!(
            (lengths_at("a[2] [N[1]], b[3]", 1), lengths_at("a = b[1]", 1), lengths_at("a[", 1)),
            ("[2] [N[1]]", "", "")
        );
    }

    #[test]
    fn vectors_have_their_components() {
        let all = Components::of("uvec2").unwrap().selections();
        assert_eq!(all, ["x", "y", "xy", "r", "g", "rg"]);
        let about =
            |ty, selection| Components::of(ty).and_then(|vector| vector.select(selection)).map(|found| found.ty);
        assert_eq!(about("vec3", "zzyx").as_deref(), Some("vec4"));
        assert_eq!(about("ivec4", "a").as_deref(), Some("int"));
        for (ty, selection) in [
            ("vec2", "z"),
            ("vec4", "xg"),
            ("vec4", "xyzwx"),
            ("vec3", ""),
            ("vec3", "é"),
            ("vec5", "x"),
            ("float", "x"),
            ("mat2", "x"),
        ] {
            assert_eq!(about(ty, selection), None, "{ty} {selection}");
        }
    }
}
