//! Code that reads and describes fields, of a struct or of a variant.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::ext::IdentExt;
use syn::{Ident, Type};

use crate::attributes::{Check, Container, Exclusion, Field, Role};
use crate::context;

/// A variable for each field, `None` where something was wrong.
pub(crate) fn reading(container: &Container, fields: &[Field]) -> TokenStream {
    fields.iter().map(|field| variable(container, field)).collect()
}

fn variable(container: &Container, field: &Field) -> TokenStream {
    let (ident, ty) = (&field.ident, &field.ty);
    let (_, context) = context(container);
    let read = match field.role {
        Role::Key => {
            let excludes = excludes(field);
            let key = field.key();
            let absent = field.default.as_ref().or(field.absent.as_ref()).map_or_else(
                || quote!(<#ty as ::raxel_language::Describe>::absent()),
                |absent| quote!(::core::option::Option::Some(#absent)),
            );
            let value = value(container, field);
            let map = field.map.iter();
            quote!({
                #excludes
                ::raxel_language::read_key::<#ty>(__table, #key, #absent, |__node| #value) #(.map(#map))*
            })
        }
        Role::Flatten => quote!(<#ty as ::raxel_language::ReadKeys<#context>>::read_keys(__table, __context)),
        Role::Entry | Role::Name => quote!(::core::option::Option::Some(__name)),
        Role::Span => quote!(::core::option::Option::Some(__table.span().clone())),
        Role::Remove => quote!(::core::option::Option::Some(::raxel_language::layer::removes(__table, &["remove"]))),
        Role::Flawed | Role::Skip => quote!(::core::option::Option::Some(::core::default::Default::default())),
    };
    let local = local(ident);
    quote!(let #local: ::core::option::Option<#ty> = #read;)
}

/// The variable of a field. A function that is called like the field must not be hidden by it.
fn local(ident: &Ident) -> Ident {
    format_ident!("__{}", ident.unraw())
}

/// The type or variant with its fields, if all are right.
pub(crate) fn made(path: &TokenStream, fields: &[Field]) -> TokenStream {
    let idents = fields.iter().map(|field| &field.ident);
    let locals = fields.iter().map(|field| local(&field.ident));
    quote!(::core::option::Option::Some(#path { #(#idents: #locals?),* }))
}

/// Reports the keys that exclude the field's.
pub(crate) fn excludes(field: &Field) -> TokenStream {
    let key = field.key();
    field
        .excludes
        .iter()
        .flat_map(|exclusion| exclusion.keys.iter().map(|other| (other, &exclusion.why)))
        .map(|(other, why)| quote!(__table.conflict(#key, #other, #why);))
        .collect()
}

/// The value at `__node`.
pub(crate) fn value(container: &Container, field: &Field) -> TokenStream {
    let ty = &field.ty;
    let (_, context) = context(container);
    let Some(read) = &field.read else {
        let limits = limits(field);
        return quote!(<#ty as ::raxel_language::Value<#context>>::read(__node, &#limits, __context));
    };
    let context = container.context.iter().map(|_| quote!(__context));
    let value = quote!((#read)(__node #(, #context)*));
    // A function reads a present value; the field knows that it may be absent.
    if is_option(ty) { quote!(#value.map(::core::option::Option::Some)) } else { value }
}

pub(crate) fn is_option(ty: &Type) -> bool {
    matches!(ty, Type::Path(path) if path.path.segments.last().is_some_and(|last| last.ident == "Option"))
}

fn limits(field: &Field) -> TokenStream {
    field.range.as_ref().map_or_else(
        || quote!(::core::default::Default::default()),
        |range| quote!(::raxel_language::NumberRange::from(#range)),
    )
}

/// Calls the checks whose fields are all right; `__sound` is false after one that failed.
pub(crate) fn checks(container: &Container, all: &[Field]) -> TokenStream {
    let context = container.context.iter().map(|_| quote!(__context,));
    let context = quote!(#(#context)*);
    let check = |Check { function, fields }: &Check| {
        let locals: Vec<Ident> = fields.iter().map(local).collect();
        let arguments = fields.iter().zip(&locals).map(|(field, local)| argument(all, field, &quote!(#local)));
        let call = quote!(__sound &= #function(__table, #context #(#arguments),*););
        if fields.is_empty() {
            return call;
        }
        quote! {
            if let (#(::core::option::Option::Some(#locals),)*) = (#(&#locals,)*) {
                #call
            }
        }
    };
    let checks = container.checks.iter().map(check);
    quote!(let mut __sound = true; #(#checks)* if !__sound { return ::core::option::Option::None; })
}

/// How a check gets a field, given a reference to it: a value that may be absent is an `Option` of a reference.
pub(crate) fn argument(all: &[Field], field: &Ident, reference: &TokenStream) -> TokenStream {
    let optional = all.iter().any(|known| known.ident == *field && is_option(&known.ty));
    if optional { quote!((#reference).as_ref()) } else { quote!(#reference) }
}

/// Adds the keys of the fields to `__form`. `asked` is false where no key must be there.
pub(crate) fn describing(fields: &[Field], asked: bool) -> TokenStream {
    let describe = |field: &Field| {
        let ty = &field.ty;
        match field.role {
            Role::Key => key(field, asked),
            Role::Remove => key(field, false),
            Role::Name => key(field, true),
            Role::Flatten => quote! {
                let __inner = <#ty as ::raxel_language::Keys>::form();
                __form.keys.extend(__inner.keys);
                __form.forms.extend(__inner.forms);
            },
            Role::Entry | Role::Span | Role::Flawed | Role::Skip => quote!(),
        }
    };
    // A key that another excludes may be declared after it.
    fields.iter().map(describe).chain(fields.iter().flat_map(conflicts)).collect()
}

/// Adds the keys that a field excludes.
fn conflicts(field: &Field) -> impl Iterator<Item = TokenStream> {
    let key = field.key();
    field.excludes.iter().map(move |Exclusion { keys, why }| quote!(__form.exclude(#key, &[#(#keys),*], #why);))
}

fn key(field: &Field, asked: bool) -> TokenStream {
    let (name, ty, about) = (field.key(), &field.ty, &field.about);
    let shape = field.shape.as_ref().map_or_else(
        || {
            let limits = limits(field);
            quote!(<#ty as ::raxel_language::Describe>::shape(&#limits))
        },
        |shape| quote!(#shape),
    );
    let some = |value: TokenStream| quote!(::core::option::Option::Some(#value));
    let none = || quote!(::core::option::Option::None);
    let unit = field.unit.as_ref().map_or_else(none, |unit| some(quote!(#unit)));
    let default = match (&field.default, &field.told) {
        (Some(default), _) => some(quote!({
            let __default: #ty = #default;
            ::raxel_language::Describe::written(&__default)
        })),
        (None, Some(told)) => some(quote!(::raxel_language::Describe::written(&#told))),
        (None, None) => none(),
    };
    let needed = if asked && field.default.is_none() && field.absent.is_none() {
        quote!(<#ty as ::raxel_language::Describe>::absent().is_none())
    } else {
        quote!(false)
    };
    quote! {
        __form.keys.push(::raxel_language::Key {
            name: #name,
            about: #about,
            shape: #shape,
            unit: #unit,
            default: #default,
            needed: #needed,
            conflicts: ::std::vec::Vec::new(),
        });
    }
}
