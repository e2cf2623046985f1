//! An enum: words, or forms of a table.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::{DataEnum, Fields, Ident};

use crate::attributes::{Container, Field, Variant};
use crate::{fields, tables};

/// An enum without fields: each variant is a word.
pub(crate) fn words(container: &Container, data: &DataEnum) -> syn::Result<TokenStream> {
    let ident = &container.ident;
    let variants = data.variants.iter().map(Variant::of).collect::<syn::Result<Vec<_>>>()?;
    let idents: Vec<_> = data.variants.iter().map(|variant| &variant.ident).collect();
    let words: Vec<_> = variants.iter().zip(&idents).map(|(variant, ident)| word(variant, ident)).collect();
    let meanings = variants.iter().map(|variant| &variant.about);
    Ok(quote! {
        impl #ident {
            /// Its words, as files have them.
            pub const WORDS: &'static [(&'static str, Self)] = &[#((#words, Self::#idents)),*];
        }

        #[automatically_derived]
        impl ::raxel_language::Describe for #ident {
            type Limits = ();

            fn shape((): &()) -> ::raxel_language::Shape {
                ::raxel_language::Shape::Words(::std::vec![
                    #(::raxel_language::Word { name: #words.into(), about: #meanings.into() }),*
                ])
            }

            fn written(&self) -> ::raxel_language::Json {
                match self {
                    #(Self::#idents => #words.into(),)*
                }
            }
        }

        #[automatically_derived]
        impl<__Context: ?::core::marker::Sized> ::raxel_language::Value<__Context> for #ident {
            fn read(
                __node: &::raxel_language::Node<'_, '_>,
                (): &(),
                _: &__Context,
            ) -> ::core::option::Option<Self> {
                __node.word(Self::WORDS)
            }
        }
    })
}

/// An enum with fields: each variant is a form of one table.
pub(crate) fn expand(container: &Container, data: &DataEnum) -> syn::Result<TokenStream> {
    let forms = data.variants.iter().map(Form::of).collect::<syn::Result<Vec<_>>>()?;
    let (describing, reading) = match &container.tag {
        Some(tag) => {
            let tag = tag.value();
            (tagged_keys(&tag, &forms), tagged(container, &tag, &forms))
        }
        None => (keys_of_all(&forms), by_key(container, &forms)?),
    };
    let (keys, reader) = (tables::keys(container, &describing), tables::reader(container, &reading));
    let value = tables::whole(container);
    Ok(quote!(#keys #reader #value))
}

struct Form<'d> {
    ident: &'d Ident,
    variant: Variant,
    fields: Vec<Field>,
    /// The fields have names; else there is one, another declaration.
    named: bool,
}

impl<'d> Form<'d> {
    fn of(variant: &'d syn::Variant) -> syn::Result<Self> {
        let fields = match &variant.fields {
            Fields::Named(fields) => fields.named.iter().map(Field::of).collect::<syn::Result<_>>()?,
            Fields::Unit => Vec::new(),
            Fields::Unnamed(fields) if fields.unnamed.len() == 1 => {
                vec![Field::flatten(format_ident!("keys"), fields.unnamed[0].ty.clone())]
            }
            Fields::Unnamed(fields) => {
                return Err(syn::Error::new_spanned(fields, "a form has fields with names, or is one declaration"));
            }
        };
        let named = !matches!(variant.fields, Fields::Unnamed(_));
        Ok(Self { ident: &variant.ident, variant: Variant::of(variant)?, fields, named })
    }

    /// Reads the keys of this form, and gives the variant.
    fn read(&self, container: &Container) -> TokenStream {
        let (ident, reading) = (self.ident, fields::reading(container, &self.fields));
        let made = if self.named {
            fields::made(&quote!(Self::#ident), &self.fields)
        } else {
            quote!(__keys.map(Self::#ident))
        };
        quote!({ #reading #made })
    }
}

/// The value of one key decides which form it is.
fn tagged(container: &Container, tag: &str, forms: &[Form<'_>]) -> TokenStream {
    let words = forms.iter().map(|form| word(&form.variant, form.ident));
    let numbers: Vec<usize> = (0..forms.len()).collect();
    let arms = forms.iter().map(|form| form.read(container));
    quote! {
        let __words = [#((#words, #numbers)),*];
        match __table.need(#tag).and_then(|__node| __node.word(&__words)) {
            #(::core::option::Option::Some(#numbers) => #arms,)*
            _ => {
                // Which keys there are is not known.
                __table.entries();
                ::core::option::Option::None
            }
        }
    }
}

fn tagged_keys(tag: &str, forms: &[Form<'_>]) -> TokenStream {
    let form = |form: &Form<'_>| {
        let (about, word) = (&form.variant.about, word(&form.variant, form.ident));
        let keys = fields::describing(&form.fields, true);
        quote! {
            __form.forms.push({
                let mut __form = ::raxel_language::Form { about: #about, ..::core::default::Default::default() };
                __form.keys.push(::raxel_language::Key {
                    name: #tag,
                    about: #about,
                    shape: ::raxel_language::Shape::Word(#word),
                    unit: ::core::option::Option::None,
                    default: ::core::option::Option::None,
                    needed: true,
                    conflicts: ::std::vec::Vec::new(),
                });
                #keys
                __form
            });
        }
    };
    forms.iter().map(form).collect()
}

/// The keys of all forms, in one table.
fn keys_of_all(forms: &[Form<'_>]) -> TokenStream {
    let keys = forms.iter().map(|form| fields::describing(&form.fields, false));
    let conflicts = forms.iter().filter_map(|form| {
        let (key, why, others) =
            (form.variant.key.as_ref()?, form.variant.excludes.as_ref()?, names_of_others(forms, form));
        Some(quote!(__form.exclude(#key, &#others, #why);))
    });
    keys.chain(conflicts).collect()
}

/// The names of the keys of all forms but this one.
fn names_of_others(forms: &[Form<'_>], form: &Form<'_>) -> TokenStream {
    let others = forms.iter().filter(|other| other.ident != form.ident);
    let others: TokenStream = others.map(|form| fields::describing(&form.fields, false)).collect();
    quote!({
        let mut __form = ::raxel_language::Form::default();
        #others
        __form.keys.iter().map(|__key| __key.name).collect::<::std::vec::Vec<_>>()
    })
}

/// A key of only one form decides for it; the last form is the remaining one.
fn by_key(container: &Container, forms: &[Form<'_>]) -> syn::Result<TokenStream> {
    let Some((last, first)) = forms.split_last() else {
        return Err(syn::Error::new_spanned(&container.ident, "a table has one form at least"));
    };
    let mut code = TokenStream::new();
    for form in first {
        let Some(key) = &form.variant.key else {
            return Err(syn::Error::new_spanned(form.ident, "every form but the last has `key = \"…\"`"));
        };
        let others = names_of_others(forms, form);
        let conflicts = form.variant.excludes.iter().map(|why| {
            quote! {
                for __other in #others {
                    __table.conflict(#key, __other, #why);
                }
            }
        });
        let read = form.read(container);
        code.extend(quote! {
            if __table.get(#key).is_some() {
                #(#conflicts)*
                return #read;
            }
        });
    }
    let last = last.read(container);
    code.extend(last);
    Ok(code)
}

/// The word of a variant: its name in lower case, with `_` between the words of it.
fn word(variant: &Variant, ident: &Ident) -> String {
    if let Some(rename) = &variant.rename {
        return rename.value();
    }
    let mut word = String::new();
    for letter in ident.to_string().chars() {
        if letter.is_uppercase() && !word.is_empty() {
            word.push('_');
        }
        word.extend(letter.to_lowercase());
    }
    word
}
