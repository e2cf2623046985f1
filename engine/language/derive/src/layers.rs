//! A struct that is laid over an equal one of the base: it is read whatever is wrong with it, and every key may be missing.

use proc_macro2::TokenStream;
use quote::quote;
use syn::Ident;

use crate::attributes::{Check, Container, Field, Layer, Role};
use crate::{context, fields};

pub fn expand(container: &Container, layer: &Layer, all: &[Field]) -> syn::Result<TokenStream> {
    let ident = &container.ident;
    let (generics, context) = context(container);
    let Layer { what, unknown, whole } = layer;
    let (name, remove) = (the(container, all, Role::Entry)?, the(container, all, Role::Remove)?);
    // Nothing of a table that is replaced as a whole remains to be flawed.
    let flawed = if *whole { None } else { Some(the(container, all, Role::Flawed)?) };
    let flawed: Vec<&Ident> = flawed.into_iter().collect();
    if let Some(field) =
        all.iter().find(|field| field.default.is_some() || field.absent.is_some() || field.map.is_some())
    {
        return Err(syn::Error::new_spanned(
            &field.ident,
            "a key of a layer may be missing: it has no `default` to be merged",
        ));
    }
    let idents = all.iter().map(|field| &field.ident);
    let values = all.iter().map(|field| match field.role {
        Role::Entry => quote!(__name),
        Role::Remove => quote!(::raxel_language::layer::removes(__table, &["remove"])),
        Role::Key => {
            let (key, excludes, value) = (field.key(), fields::excludes(field), fields::value(container, field));
            quote!({
                #excludes
                __table.get(#key).and_then(|__node| {
                    let __node = &__node;
                    #value
                }).flatten()
            })
        }
        _ => quote!(::core::default::Default::default()),
    });
    let context_argument = container.context.iter().map(|_| quote!(__context,));
    let context_argument = quote!(#(#context_argument)*);
    let checks = container.checks.iter().map(|Check { function, fields }| {
        let arguments = fields.iter().map(|field| fields::argument(all, field, &quote!(&__read.#field)));
        quote!(let _: bool = #function(__table, #context_argument #(#arguments),*);)
    });
    let over = container.over.iter();
    let keys = all.iter().filter(|field| field.role == Role::Key).map(|field| &field.ident);
    let (before, mutable) =
        if *whole { (quote!(), quote!()) } else { (quote!(let __before = __table.reporter().count();), quote!(mut)) };
    let cover = if *whole {
        quote!(*self = __above;)
    } else {
        quote! {
            #(self.#flawed |= __above.#flawed;)*
            #(#over(self, &__above);)*
            #(::raxel_language::layer::replace(&mut self.#keys, __above.#keys);)*
        }
    };
    Ok(quote! {
        #[automatically_derived]
        impl #generics ::raxel_language::Named<#context> for #ident {
            fn read_named(
                __name: ::raxel_language::Spanned<::std::string::String>,
                __table: &::raxel_language::Table<'_, '_>,
                __context: &#context,
            ) -> ::core::option::Option<Self> {
                #before
                let #mutable __read = Self { #(#idents: #values),* };
                #(#checks)*
                __table.finish();
                #(__read.#flawed = __table.reporter().count() > __before;)*
                ::core::option::Option::Some(__read)
            }
        }

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

            fn cover(&mut self, __above: Self, _: &mut ::std::vec::Vec<::raxel_language::Diagnostic>) {
                #cover
            }
        }
    })
}

/// The one field of that role.
fn the<'f>(container: &Container, all: &'f [Field], role: Role) -> syn::Result<&'f Ident> {
    let found = all.iter().find(|field| field.role == role).map(|field| &field.ident);
    found.ok_or_else(|| {
        syn::Error::new_spanned(&container.ident, "a layer has an `entry`, a `remove` and a `flawed` field")
    })
}
