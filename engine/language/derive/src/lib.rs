//! `#[derive(Keys)]`: a struct becomes the declaration of a table of a file, an enum that of words or of forms of a table. `raxel-language`
//! documents the attributes.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

mod attributes;
mod fields;
mod forms;
mod layers;
mod tables;

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Fields, GenericParam, parse_macro_input};

use attributes::Container;

/// Derives the reader, the description and, for layers, the merge of a table from its fields. See `raxel_language`.
#[proc_macro_derive(Keys, attributes(keys))]
pub fn keys(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    expand(&input).unwrap_or_else(|error| error.to_compile_error()).into()
}

fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    if let Some(other) = input.generics.params.iter().find(|param| !matches!(param, GenericParam::Const(_))) {
        return Err(syn::Error::new_spanned(other, "of the parameters of a type, keys can depend on numbers only"));
    }
    let container = Container::of(input)?;
    let is_table = matches!(input.data, Data::Struct(_));
    if !container.checks.is_empty() && !is_table {
        return Err(syn::Error::new_spanned(&input.ident, "a check is of a table, not of words or forms"));
    }
    match &input.data {
        Data::Struct(data) => match &data.fields {
            Fields::Named(fields) => tables::expand(&container, fields),
            _ => Err(syn::Error::new_spanned(&input.ident, "the fields of a table have names")),
        },
        Data::Enum(data) if data.variants.iter().all(|variant| matches!(variant.fields, Fields::Unit)) => {
            forms::words(&container, data)
        }
        Data::Enum(data) => forms::expand(&container, data),
        Data::Union(_) => Err(syn::Error::new_spanned(&input.ident, "a union is no table")),
    }
}

/// The generics of an impl and the type of its context: any, unless the attributes name one.
fn context(container: &Container) -> (TokenStream, TokenStream) {
    let params = &container.generics.params;
    match &container.context {
        Some(context) => (quote!(<#params>), quote!(#context)),
        None => (quote!(<__Context: ?::core::marker::Sized, #params>), quote!(__Context)),
    }
}
