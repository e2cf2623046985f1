//! Members of structures, blocks and vectors: what can stand behind a dot, and what a name behind a dot means. The type in front of the dot is known
//! for names, their members and elements, and for calls of functions whose return type is declared. Elsewhere there is no answer.

use std::ops::Range;

use raxel_shader::library;

use super::builtins;
use super::documents::Document;
use super::glsl::{
    Declaration, DeclarationKind, Member, comment_on, is_name, members, name_before, open_of, type_before,
    without_comments,
};
use super::names::identifier;
use super::project_texts::{ProjectText, declared_in};
use super::scopes::local_at;

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
    match Vector::named(&ty) {
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

/// A shader with what it includes.
struct Shader<'d, 't> {
    document: &'d Document,
    texts: &'t [ProjectText],
}

/// A name of an expression such as `a(b)[c].d`.
struct Link<'c> {
    name: &'c str,
    /// Where the name begins.
    at: usize,
    is_called: bool,
    indices: usize,
}

impl<'t> Shader<'_, 't> {
    /// The type of the expression in front of the dot before a byte.
    fn type_before_dot(&self, at: usize) -> Option<String> {
        let code = without_comments(&self.document.text);
        let before = code.get(..at)?.trim_end_matches(is_name).trim_end().strip_suffix('.')?;
        let links = links(before)?;
        let (first, rest) = links.split_first()?;
        let mut ty = indexed(self.type_of_first(first)?, first.indices)?;
        for link in rest {
            // GLSL has one method, `length`, and that is a number.
            let member = self.member(&ty, link.name).filter(|_| !link.is_called)?;
            ty = indexed(member.ty, link.indices)?;
        }
        Some(ty)
    }

    fn type_of_first(&self, first: &Link<'_>) -> Option<String> {
        let name = first.name;
        if first.is_called {
            return self.return_type(name);
        }
        let text = &self.document.text;
        if let Some(local) = local_at(text.locals(), name, first.at) {
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

    /// The type of a call of a function or a constructor.
    fn return_type(&self, name: &str) -> Option<String> {
        let is_type = Vector::named(name).is_some() || self.structure(name).is_some();
        if is_type {
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
        match Vector::named(ty) {
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

/// The names of the expression that a code ends with, in order. `None` where something else stands in it.
fn links(code: &str) -> Option<Vec<Link<'_>>> {
    let mut found = Vec::new();
    let mut rest = code;
    loop {
        rest = rest.trim_end();
        let mut indices = 0;
        while rest.ends_with(']') {
            rest = rest[..open_of(rest, ['[', ']'])?].trim_end();
            indices += 1;
        }
        let is_called = rest.ends_with(')');
        if is_called {
            rest = rest[..open_of(rest, ['(', ')'])?].trim_end();
        }
        let place = name_before(rest, rest.len())?;
        let name = &rest[place.clone()];
        if name.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        found.push(Link { name, at: place.start, is_called, indices });
        match rest[..place.start].trim_end().strip_suffix('.') {
            Some(before) => rest = before,
            None => break,
        }
    }
    found.reverse();
    Some(found)
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

/// The type of an element: of an array, of a matrix its column, of a vector its component.
fn indexed(ty: String, indices: usize) -> Option<String> {
    let mut ty = ty;
    for _ in 0..indices {
        let array = ty.find('[').filter(|_| ty.ends_with(']'));
        ty = match array {
            // The first length is that of the outermost array.
            Some(open) => {
                let close = open + ty[open..].find(']')?;
                format!("{}{}", ty[..open].trim_end(), ty[close + 1..].trim())
            }
            None => match ty.strip_prefix("mat").or_else(|| ty.strip_prefix("dmat")) {
                Some(size) => {
                    let double = if ty.starts_with('d') { "d" } else { "" };
                    format!("{double}vec{}", size.rsplit('x').next()?)
                }
                None => Vector::named(&ty)?.component.to_owned(),
            },
        };
    }
    Some(ty)
}

/// A type of vectors.
#[derive(Clone, Copy)]
struct Vector<'n> {
    /// `i` of `ivec3`.
    prefix: &'n str,
    size: usize,
    component: &'static str,
}

impl<'n> Vector<'n> {
    fn named(name: &'n str) -> Option<Self> {
        let (prefix, size) = name.split_once("vec")?;
        let size = ["2", "3", "4"].iter().position(|known| *known == size)? + 2;
        let component = match prefix {
            "" | "f32" => "float",
            "i" | "i32" => "int",
            "u" | "u32" => "uint",
            "b" => "bool",
            "d" | "f64" => "double",
            "f16" => "float16_t",
            "i8" => "int8_t",
            "i16" => "int16_t",
            "i64" => "int64_t",
            "u8" => "uint8_t",
            "u16" => "uint16_t",
            "u64" => "uint64_t",
            _ => return None,
        };
        Some(Self { prefix, size, component })
    }

    /// Components in their order, as positions and as colours: `x`, `y`, `xy`, …, `rgb`. All others are too many to choose from.
    fn selections(self) -> Vec<String> {
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
    fn select<'t>(self, selection: &str) -> Option<KnownMember<'t>> {
        let of_set = |set: &str| selection.chars().all(|letter| set[..self.size].contains(letter));
        if !(1..=4).contains(&selection.len()) || !["xyzw", "rgba", "stpq"].into_iter().any(of_set) {
            return None;
        }
        let Self { prefix, size, component } = self;
        let ty = if selection.len() == 1 { component.to_owned() } else { format!("{prefix}vec{}", selection.len()) };
        let what = if selection.len() == 1 { "A component" } else { "Components" };
        let about = format!("```glsl\n{ty} {selection}\n```\n{what} of a `{prefix}vec{size}`.");
        Some(KnownMember { name: selection.to_owned(), about, ty, declared: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expression_is_read_from_its_end() {
        let read = |code| {
            let links: Option<Vec<Link<'_>>> = links(code);
            let shown = |link: &Link<'_>| {
                format!("{}{}{}", link.name, if link.is_called { "()" } else { "" }, "[]".repeat(link.indices))
            };
            links.map(|links| links.iter().map(shown).collect::<Vec<_>>().join("."))
        };
        for (code, found) in [
            ("x = a", Some("a")),
            ("f(x).b [i[0]] [1] . c", Some("f().b[][].c")),
            ("return far(a, (b))", Some("far()")),
            ("(a + b)", None),
            ("1", None),
            ("a.2", None),
            ("", None),
            (")", None),
            ("]", None),
            ("é", None),
        ] {
            assert_eq!(read(code).as_deref(), found, "{code}");
        }
    }

    #[test]
    fn elements_have_the_type_that_indices_leave() {
        let of = |ty: &str, indices| indexed(ty.to_owned(), indices);
        for (ty, indices, left) in [
            ("vec3", 0, Some("vec3")),
            ("vec3[2][N]", 1, Some("vec3[N]")),
            ("vec3[2]", 2, Some("float")),
            ("mat4", 1, Some("vec4")),
            ("mat2x3", 1, Some("vec3")),
            ("ivec2", 1, Some("int")),
            ("float", 1, None),
            ("RxHit", 1, None),
        ] {
            assert_eq!(of(ty, indices).as_deref(), left, "{ty}");
        }
        assert_eq!(
            (lengths_at("a[2] [N[1]], b[3]", 1), lengths_at("a = b[1]", 1), lengths_at("a[", 1)),
            ("[2] [N[1]]", "", "")
        );
    }

    #[test]
    fn vectors_have_their_components() {
        let all = Vector::named("uvec2").unwrap().selections();
        assert_eq!(all, ["x", "y", "xy", "r", "g", "rg"]);
        let about = |ty, selection| Vector::named(ty).and_then(|vector| vector.select(selection)).map(|found| found.ty);
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
        ] {
            assert_eq!(about(ty, selection), None, "{ty} {selection}");
        }
    }
}
