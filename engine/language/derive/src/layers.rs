//! A struct that is laid over an equal one of the base: it is read in spite of mistakes, and every key may be missing.

use proc_macro2::TokenStream;
use quote::quote;
use syn::Ident;

use crate::attributes::{Check, Container, Field, Layer, Role};
use crate::{context, fields, tables};

pub(crate) fn expand(container: &Container, layer: &Layer, all: &[Field]) -> syn::Result<TokenStream> {
    let ident = &container.ident;
    let (_, context) = context(container);
    let Layer { what, unknown, whole } = layer;
    let remove = the(container, all, Role::Remove)?;
    // The author names the table, or a key of it does.
    let key = all.iter().find(|field| field.role == Role::Name);
    let name = key.map_or_else(|| the(container, all, Role::Entry), |key| Ok(&key.ident))?;
    let key_name = key.map(Field::key);
    let beside: Vec<&str> = key_name.as_deref().into_iter().chain(["remove"]).collect();
    // Nothing of a table that is replaced as a whole remains to be flawed.
    let flawed = if *whole { None } else { Some(the(container, all, Role::Flawed)?) };
    let flawed: Vec<&Ident> = flawed.into_iter().collect();
    mergeable(all)?;
    let idents = all.iter().map(|field| &field.ident);
    let values = all.iter().map(|field| match field.role {
        Role::Entry | Role::Name => quote!(__name),
        Role::Remove => quote!(::raxel_language::layer::removes(__table, &[#(#beside),*])),
        _ => read(container, field),
    });
    let context_argument = container.context.iter().map(|_| quote!(__context,));
    let context_argument = quote!(#(#context_argument)*);
    let checks = container.checks.iter().map(|Check { function, fields }| {
        let arguments = fields.iter().map(|field| fields::argument(all, field, &quote!(&__read.#field)));
        quote!(let _: bool = #function(__table, #context_argument #(#arguments),*);)
    });
    let over = container.over.iter();
    let merged = merged(all);
    let (before, mutable) =
        if *whole { (quote!(), quote!()) } else { (quote!(let __before = __table.reporter().count();), quote!(mut)) };
    let cover = if *whole {
        quote!(*self = __above;)
    } else {
        quote! {
            #(self.#flawed |= __above.#flawed;)*
            #(#over(self, &__above);)*
            #merged
        }
    };
    let naming = key_name.iter().map(|key| {
        quote! {
            let __name = __table
                .need(#key)
                .and_then(|__node| ::raxel_language::Value::<#context>::read(&__node, &(), __context))
                .unwrap_or_else(|| ::raxel_language::Spanned::new(::std::string::String::new(), __table.span().clone()));
        }
    });
    let body = quote! {
        #before
        #(#naming)*
        let #mutable __read = Self { #(#idents: #values),* };
        #(#checks)*
        __table.finish();
        #(__read.#flawed = __table.reporter().count() > __before;)*
        ::core::option::Option::Some(__read)
    };
    // A table that a key names, such as one of `[[passes]]`, has an empty name without that key.
    let reader = if key_name.is_some() {
        let body = quote! {
            let __table = &__node.table()?;
            #body
        };
        tables::value(container, &body)
    } else {
        tables::named(container, &body)
    };
    let added = container.added.iter();
    Ok(quote! {
        #reader

        #[automatically_derived]
        impl ::raxel_language::Layer for #ident {
            const WHAT: &'static str = #what;
            const UNKNOWN: ::raxel_language::Code = #unknown;

            fn name(&self) -> &::raxel_language::Spanned<::std::string::String> {
                &self.#name
            }

            fn removed(&self) -> bool {
                self.#remove
            }

            fn added(&self, __found: &mut ::std::vec::Vec<::raxel_language::Diagnostic>) {
                #(#added(self, __found);)*
            }

            fn cover(&mut self, __above: Self, __found: &mut ::std::vec::Vec<::raxel_language::Diagnostic>) {
                #cover
            }
        }
    })
}

/// A whole file that is laid over another.
pub(crate) fn file(container: &Container, all: &[Field]) -> syn::Result<TokenStream> {
    mergeable(all)?;
    let ident = &container.ident;
    let (idents, values) = (all.iter().map(|field| &field.ident), all.iter().map(|field| read(container, field)));
    let reader = tables::reader(container, &quote!(::core::option::Option::Some(Self { #(#idents: #values),* })));
    let merged = merged(all);
    Ok(quote! {
        #reader

        #[automatically_derived]
        impl #ident {
            /// Puts `above` over this: the keys of the file on top win.
            pub(crate) fn cover(&mut self, __above: Self, __found: &mut ::std::vec::Vec<::raxel_language::Diagnostic>) {
                #merged
            }
        }
    })
}

fn mergeable(all: &[Field]) -> syn::Result<()> {
    match all.iter().find(|field| field.default.is_some() || field.absent.is_some() || field.map.is_some()) {
        None => Ok(()),
        Some(field) => Err(syn::Error::new_spanned(
            &field.ident,
            "a key of a layer may be missing: it has no `default` to be merged",
        )),
    }
}

/// The value of a key, or nothing if it is wrong or absent; nothing of a field that is no key.
fn read(container: &Container, field: &Field) -> TokenStream {
    if field.role != Role::Key {
        return quote!(::core::default::Default::default());
    }
    let (key, excludes, value) = (field.key(), fields::excludes(field), fields::value(container, field));
    quote!({
        #excludes
        __table.get(#key).and_then(|__node| {
            let __node = &__node;
            #value
        }).unwrap_or_default()
    })
}

/// Lays the keys of `__above` over those of `self`.
fn merged(all: &[Field]) -> TokenStream {
    let merge = |field: &Field| {
        let key = &field.ident;
        if field.cover {
            quote!(::raxel_language::layer::cover(&mut self.#key, __above.#key, __found);)
        } else if fields::is_option(&field.ty) {
            quote!(::raxel_language::layer::replace(&mut self.#key, __above.#key);)
        } else {
            quote!(::raxel_language::layer::merge(&mut self.#key, __above.#key, __found);)
        }
    };
    all.iter().filter(|field| field.role == Role::Key).map(merge).collect()
}

/// The one field of that role.
fn the<'f>(container: &Container, all: &'f [Field], role: Role) -> syn::Result<&'f Ident> {
    let found = all.iter().find(|field| field.role == role).map(|field| &field.ident);
    found.ok_or_else(|| {
        syn::Error::new_spanned(&container.ident, "a layer has an `entry`, a `remove` and a `flawed` field")
    })
}
