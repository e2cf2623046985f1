//! A struct: a table.

use proc_macro2::TokenStream;
use quote::quote;
use syn::FieldsNamed;

use crate::attributes::{Container, Field, Role};
use crate::{context, fields, layers};

pub(crate) fn expand(container: &Container, found: &FieldsNamed) -> syn::Result<TokenStream> {
    let all = found.named.iter().map(Field::of).collect::<syn::Result<Vec<_>>>()?;
    let keys = keys(container, &fields::describing(&all, container.layer.is_none() && !container.file));
    let reader = match &container.layer {
        Some(layer) => layers::expand(container, layer, &all)?,
        None if container.file => layers::file(container, &all)?,
        None => read(container, &all),
    };
    Ok(quote!(#keys #reader))
}

/// The description of the type as a table.
pub(crate) fn keys(container: &Container, describing: &TokenStream) -> TokenStream {
    let (ident, about, params) = (&container.ident, &container.about, &container.generics.params);
    quote! {
        #[automatically_derived]
        impl<#params> ::raxel_language::Keys for #ident {
            fn form() -> ::raxel_language::Form {
                let mut __form = ::raxel_language::Form { about: #about, ..::core::default::Default::default() };
                #describing
                __form
            }
        }
    }
}

/// The reader of a table: of one under a name that its author gives, if a field holds that name.
fn read(container: &Container, all: &[Field]) -> TokenStream {
    let (reading, checks) = (fields::reading(container, all), fields::checks(container, all));
    let made = fields::made(&quote!(Self), all);
    if all.iter().any(|field| field.role == Role::Entry) {
        let body = quote! {
            #reading
            let __read = (|| { #checks #made })();
            __table.finish();
            __read
        };
        return named(container, &body);
    }
    let (reader, value) = (reader(container, &quote!(#reading #checks #made)), whole(container));
    quote!(#reader #value)
}

/// Reads the keys of the table: `body` does, from `__table`.
pub(crate) fn reader(container: &Container, body: &TokenStream) -> TokenStream {
    let ident = &container.ident;
    let (generics, context) = context(container);
    quote! {
        #[automatically_derived]
        impl #generics ::raxel_language::ReadKeys<#context> for #ident {
            fn read_keys(
                __table: &::raxel_language::Table<'_, '_>,
                __context: &#context,
            ) -> ::core::option::Option<Self> {
                #body
            }
        }
    }
}

/// The table under a name that its author gives: `body` reads it from `__table`, with `__name`.
pub(crate) fn named(container: &Container, body: &TokenStream) -> TokenStream {
    let ident = &container.ident;
    let (generics, context) = context(container);
    quote! {
        #[automatically_derived]
        impl #generics ::raxel_language::Named<#context> for #ident {
            fn read_named(
                __name: ::raxel_language::Spanned<::std::string::String>,
                __table: &::raxel_language::Table<'_, '_>,
                __context: &#context,
            ) -> ::core::option::Option<Self> {
                #body
            }
        }
    }
}

/// The table as the value of a key: `body` reads it from `__node`.
pub(crate) fn value(container: &Container, body: &TokenStream) -> TokenStream {
    let (ident, params) = (&container.ident, &container.generics.params);
    let (generics, context) = context(container);
    quote! {
        #[automatically_derived]
        impl<#params> ::raxel_language::Describe for #ident {
            type Limits = ();

            fn shape((): &()) -> ::raxel_language::Shape {
                ::raxel_language::Shape::Table(<Self as ::raxel_language::Keys>::form())
            }
        }

        #[automatically_derived]
        impl #generics ::raxel_language::Value<#context> for #ident {
            fn read(
                __node: &::raxel_language::Node<'_, '_>,
                (): &(),
                __context: &#context,
            ) -> ::core::option::Option<Self> {
                #body
            }
        }
    }
}

/// The whole table as the value of a key; and its conversion, if it becomes another type.
pub(crate) fn whole(container: &Container) -> TokenStream {
    let ident = &container.ident;
    let (generics, context) = context(container);
    let into = container.into.iter();
    let value = value(
        container,
        &quote!(<Self as ::raxel_language::ReadKeys<#context>>::read_whole(&__node.table()?, __context)),
    );
    quote! {
        #value

        #(
            #[automatically_derived]
            impl ::raxel_language::Describe for #into {
                type Limits = ();

                fn shape((): &()) -> ::raxel_language::Shape {
                    <#ident as ::raxel_language::Describe>::shape(&())
                }
            }

            #[automatically_derived]
            impl #generics ::raxel_language::Value<#context> for #into {
                fn read(
                    __node: &::raxel_language::Node<'_, '_>,
                    (): &(),
                    __context: &#context,
                ) -> ::core::option::Option<Self> {
                    <#ident as ::raxel_language::Value<#context>>::read(__node, &(), __context).map(::core::convert::From::from)
                }
            }
        )*
    }
}
