//! The contents of `#[keys(…)]`.

use proc_macro2::TokenStream;
use quote::quote;
use syn::meta::ParseNestedMeta;
use syn::parse::ParseStream;
use syn::spanned::Spanned;
use syn::{Attribute, DeriveInput, Expr, Generics, Ident, LitStr, Path, Token, Type};

/// Of the type.
pub(crate) struct Container {
    /// Its parameters, which are numbers.
    pub generics: Generics,
    /// Its name, with its parameters.
    pub ident: TokenStream,
    pub about: String,
    /// `context = Type`: the context of reading.
    pub context: Option<Type>,
    /// `check = function(field, field)`.
    pub checks: Vec<Check>,
    /// `into = Type`.
    pub into: Option<Type>,
    /// `layer("param", unknown = CODE)`.
    pub layer: Option<Layer>,
    /// `layer`: a whole file, which is laid over another.
    pub file: bool,
    /// `over = function`: the effect of a layer on the base before its keys replace those of the base.
    pub over: Option<Path>,
    /// `added = function`: the checks of a table that the base does not have.
    pub added: Option<Path>,
    /// `tag = "op"`.
    pub tag: Option<LitStr>,
}

/// How a table is laid over an equal one.
pub(crate) struct Layer {
    pub what: LitStr,
    pub unknown: Expr,
    /// The whole table replaces the one below, and not key by key.
    pub whole: bool,
}

/// A function that is given fields.
pub(crate) struct Check {
    pub function: Path,
    pub fields: Vec<Ident>,
}

/// Of a field.
pub(crate) struct Field {
    pub ident: Ident,
    pub ty: Type,
    pub about: String,
    /// The key, if it is not called like the field.
    pub rename: Option<LitStr>,
    pub range: Option<Expr>,
    /// The value for an absent key, shown in the schema.
    pub default: Option<Expr>,
    /// The same, not shown.
    pub absent: Option<Expr>,
    /// The default that the schema shows for a key that is filled in some other way.
    pub told: Option<Expr>,
    pub unit: Option<LitStr>,
    pub map: Option<Expr>,
    pub read: Option<Expr>,
    pub shape: Option<Expr>,
    pub excludes: Vec<Exclusion>,
    /// A layer in a layer: it is laid over its equal, and does not replace it.
    pub cover: bool,
    pub role: Role,
}

/// Keys that a field excludes, and why.
pub(crate) struct Exclusion {
    pub keys: Vec<LitStr>,
    pub why: LitStr,
}

/// The roles of a field.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// A key.
    Key,
    /// Further keys of the same table.
    Flatten,
    /// The name of the table.
    Entry,
    /// The key that is the name of the table.
    Name,
    /// The place of the table.
    Span,
    /// `remove = true`.
    Remove,
    /// Whether something in the table was wrong.
    Flawed,
    /// Nothing of the file.
    Skip,
}

/// Of a variant of an enum.
pub(crate) struct Variant {
    pub about: String,
    pub rename: Option<LitStr>,
    /// `key = "pass"`: this form is meant if the key is there.
    pub key: Option<LitStr>,
    /// Why no key of another form may be there then.
    pub excludes: Option<LitStr>,
}

impl Container {
    pub(crate) fn of(input: &DeriveInput) -> syn::Result<Self> {
        let mut found = Self {
            generics: input.generics.clone(),
            ident: {
                let (ident, (_, params, _)) = (&input.ident, input.generics.split_for_impl());
                quote!(#ident #params)
            },
            about: about(&input.attrs),
            context: None,
            checks: Vec::new(),
            into: None,
            layer: None,
            file: false,
            over: None,
            added: None,
            tag: None,
        };
        each(&input.attrs, |meta| {
            match word(meta)?.as_str() {
                "context" => found.context = Some(meta.value()?.parse()?),
                "into" => found.into = Some(meta.value()?.parse()?),
                "over" => found.over = Some(meta.value()?.parse()?),
                "added" => found.added = Some(meta.value()?.parse()?),
                "tag" => found.tag = Some(meta.value()?.parse()?),
                "about" => found.about = meta.value()?.parse::<LitStr>()?.value(),
                "check" => found.checks.push(Check::of(&meta.value()?.parse()?)?),
                "layer" if !meta.input.peek(syn::token::Paren) => found.file = true,
                "layer" => {
                    let inner;
                    syn::parenthesized!(inner in meta.input);
                    let what = inner.parse()?;
                    inner.parse::<Token![,]>()?;
                    let unknown = named(&inner, "unknown")?;
                    let whole = inner.parse::<Option<Ident>>()?;
                    if let Some(other) = whole.as_ref().filter(|word| *word != "whole") {
                        return Err(syn::Error::new(other.span(), "expected `whole`"));
                    }
                    found.layer = Some(Layer { what, unknown, whole: whole.is_some() });
                }
                _ => {
                    return Err(
                        meta.error("a type has `context`, `into`, `tag`, `about`, `check`, `layer`, `over` or `added`")
                    );
                }
            }
            Ok(())
        })?;
        Ok(found)
    }
}

impl Check {
    /// `function(field, …)`.
    fn of(call: &Expr) -> syn::Result<Self> {
        let wrong = |at: &Expr| syn::Error::new(at.span(), "a check is `function(field, …)`");
        let path = |expression: &Expr| match expression {
            Expr::Path(path) => Ok(path.path.clone()),
            other => Err(wrong(other)),
        };
        let Expr::Call(call) = call else { return Err(wrong(call)) };
        let field = |expression| Ok(path(expression)?.require_ident()?.clone());
        Ok(Self { function: path(&call.func)?, fields: call.args.iter().map(field).collect::<syn::Result<_>>()? })
    }
}

impl Field {
    /// The keys of another declaration.
    pub(crate) fn flatten(ident: Ident, ty: Type) -> Self {
        Self {
            ident,
            ty,
            about: String::new(),
            rename: None,
            range: None,
            default: None,
            absent: None,
            told: None,
            unit: None,
            map: None,
            read: None,
            shape: None,
            excludes: Vec::new(),
            cover: false,
            role: Role::Flatten,
        }
    }

    pub(crate) fn of(field: &syn::Field) -> syn::Result<Self> {
        let ident = field.ident.clone().ok_or_else(|| syn::Error::new(field.span(), "a key has a name"))?;
        let mut found = Self { about: about(&field.attrs), role: Role::Key, ..Self::flatten(ident, field.ty.clone()) };
        each(&field.attrs, |meta| {
            match word(meta)?.as_str() {
                "rename" => found.rename = Some(meta.value()?.parse()?),
                "range" => found.range = Some(meta.value()?.parse()?),
                "default" => found.default = Some(meta.value()?.parse()?),
                "absent" => found.absent = Some(meta.value()?.parse()?),
                "told" => found.told = Some(meta.value()?.parse()?),
                "unit" => found.unit = Some(meta.value()?.parse()?),
                "about" => found.about = meta.value()?.parse::<LitStr>()?.value(),
                "map" => found.map = Some(meta.value()?.parse()?),
                "read" => found.read = Some(meta.value()?.parse()?),
                "shape" => found.shape = Some(meta.value()?.parse()?),
                "excludes" => found.excludes.push(Exclusion::of(meta)?),
                "flatten" => found.role = Role::Flatten,
                "cover" => found.cover = true,
                "entry" => found.role = Role::Entry,
                "name" => found.role = Role::Name,
                "span" => found.role = Role::Span,
                "remove" => found.role = Role::Remove,
                "flawed" => found.role = Role::Flawed,
                "skip" => found.role = Role::Skip,
                _ => {
                    return Err(meta.error(
                        "a field has `rename`, `range`, `default`, `absent`, `told`, `unit`, `about`, `map`, `read`, `shape`, \
                         `excludes` or `cover`; or is `flatten`, `entry`, `name`, `span`, `remove`, `flawed` or `skip`",
                    ));
                }
            }
            Ok(())
        })?;
        if found.role == Role::Key && found.about.is_empty() {
            return Err(syn::Error::new(found.ident.span(), "a key has a description: write a doc comment above it"));
        }
        Ok(found)
    }

    /// The key, as it is written.
    pub(crate) fn key(&self) -> String {
        self.rename.as_ref().map_or_else(|| self.ident.to_string(), LitStr::value)
    }
}

impl Exclusion {
    /// `excludes("a", "b", why = "…")`.
    fn of(meta: &ParseNestedMeta<'_>) -> syn::Result<Self> {
        let inner;
        syn::parenthesized!(inner in meta.input);
        let mut keys = Vec::new();
        while inner.peek(LitStr) {
            keys.push(inner.parse()?);
            inner.parse::<Token![,]>()?;
        }
        Ok(Self { keys, why: named(&inner, "why")? })
    }
}

impl Variant {
    pub(crate) fn of(variant: &syn::Variant) -> syn::Result<Self> {
        let mut found = Self { about: about(&variant.attrs), rename: None, key: None, excludes: None };
        each(&variant.attrs, |meta| {
            match word(meta)?.as_str() {
                "rename" => found.rename = Some(meta.value()?.parse()?),
                "key" => found.key = Some(meta.value()?.parse()?),
                "excludes" => found.excludes = Some(meta.value()?.parse()?),
                _ => return Err(meta.error("a variant has `rename`, `key` or `excludes`")),
            }
            Ok(())
        })?;
        Ok(found)
    }
}

/// `name = value`, at the end of a list.
fn named<T: syn::parse::Parse>(input: ParseStream<'_>, name: &str) -> syn::Result<T> {
    let found: Ident = input.parse()?;
    if found != name {
        return Err(syn::Error::new(found.span(), format!("expected `{name} = …`")));
    }
    input.parse::<Token![=]>()?;
    let value = input.parse()?;
    input.parse::<Option<Token![,]>>()?;
    Ok(value)
}

fn word(meta: &ParseNestedMeta<'_>) -> syn::Result<String> {
    Ok(meta.path.require_ident()?.to_string())
}

fn each(attributes: &[Attribute], mut read: impl FnMut(&ParseNestedMeta<'_>) -> syn::Result<()>) -> syn::Result<()> {
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("keys")) {
        attribute.parse_nested_meta(|meta| read(&meta))?;
    }
    Ok(())
}

/// The first paragraph of a doc comment, as one line.
fn about(attributes: &[Attribute]) -> String {
    let mut lines = Vec::new();
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("doc")) {
        let syn::Meta::NameValue(pair) = &attribute.meta else { continue };
        let Expr::Lit(literal) = &pair.value else { continue };
        let syn::Lit::Str(text) = &literal.lit else { continue };
        lines.extend(text.value().split('\n').map(|line| line.trim().to_owned()));
    }
    lines.split(String::is_empty).next().unwrap_or_default().join(" ")
}
