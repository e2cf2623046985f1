//! File languages whose keys are declared once. A struct with doc comments and attributes is the declaration of a table; from it come
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! * the reader, which reports everything that is wrong with a file at once, each mistake at its place;
//! * the keys as data ([`Form`], [`Key`]): type, unit, range, default and meaning of each, and the JSON schema made from them;
//! * the merge of a file with the file that it `extends` ([`Layer`]).
//!
//! ```
//! use raxel_diagnostics::SourceMap;
//! use raxel_diagnostics::table::read_document;
//! use raxel_language::{Keys, ReadKeys};
//!
//! /// A lamp.
//! #[derive(Debug, PartialEq, Keys)]
//! struct Lamp {
//!     /// How bright it is.
//!     #[keys(range = 0.0..=5000.0, unit = "lumen")]
//!     power: f64,
//!     /// Whether it shines.
//!     #[keys(default = true)]
//!     lit: bool,
//! }
//!
//! let read = |text: &str| {
//!     read_document("lamp.toml", text, &mut SourceMap::default(), |root| Lamp::read_whole(root, &()))
//! };
//! assert_eq!(read("power = 800").unwrap().0, Lamp { power: 800.0, lit: true });
//!
//! let found = read("power = -1\nlitt = false").unwrap_err();
//! let messages: Vec<_> = found.iter().map(|found| found.message.as_str()).collect();
//! assert_eq!(messages, ["`power` is -1; it must be in 0…5000", "the file has no key `litt`"]);
//! assert_eq!(found[1].help, ["did you mean `lit`?"]);
//!
//! let form = Lamp::form();
//! assert_eq!(form.keys[0].to_string(), "power: number in 0…5000, lumen, needed. How bright it is.");
//! assert_eq!(form.document("lamp")["properties"]["power"]["maximum"], 5000);
//! ```
//!
//! # Attributes
//!
//! The first paragraph of a doc comment is the meaning of a key, for schemas and reference pages; further paragraphs are for readers of the
//! code. A key must be there unless its type is an `Option`, a `Vec` or [`ByName`], or it has a `default` or `absent`. Values can be of
//! every type that implements [`Value`]; a [`Spanned`] one has its place.
//!
//! | of a field | |
//! |---|---|
//! | `rename = "loop"` | the key, where the field is called otherwise |
//! | `range = 0.0..=1.0` | limits of a number, or of each number of an array |
//! | `default = 30.0` | the value when the key is absent, as the file would say it |
//! | `absent = 30.0` | the same, and the schema does not tell it |
//! | `told = 30.0` | the default that the schema tells of a key that stays `None` |
//! | `unit = "seconds"` | the unit |
//! | `about = "…"` | the meaning, instead of the doc comment |
//! | `map = f64::to_radians` | a function between the value of the file and that of the field |
//! | `read = function` | a function of a [`Node`] that reads the value, instead of the type's own reader |
//! | `shape = Shape::Text` | what the value is, instead of what the type says |
//! | `excludes("a", "b", why = "…")` | keys that cannot stand beside this one; the reader refuses them together, and the schema says it of each |
//! | `flatten` | the keys of another declaration, in the same table |
//! | `entry`, `span` | the name of the table, where the author gives it; its place |
//! | `name` | of a layer: the key that says its name, as in `[[passes]]` |
//! | `cover` | of a layer: what is laid over its equal below, and does not replace it |
//! | `skip` | no key |
//!
//! | of a type | |
//! |---|---|
//! | `context = Clock` | what functions of the declaration are given besides: `read` and `check` get a reference to it as well |
//! | `check = function(a, b)` | a function of the [`Table`] and of fields, called if these are right; `false` refuses the table. A layer gives the fields as they are |
//! | `into = Edit` | the type that the table becomes, by [`From`] |
//! | `layer("param", unknown = CODE)` | tables that are laid over equal ones: fields are `Option`s, which replace each other, or `Vec`s of layers, which are merged. One each is `entry` or `name`, `remove` and `flawed` |
//! | `layer("binding", unknown = CODE, whole)` | the same, but a table replaces its equal as a whole; it has no `flawed` |
//! | `layer` | a whole file that is laid over another by its own method `cover` |
//! | `over = function` | a function of the layer below and the one above, called before keys of the one replace those of the other |
//! | `added = function` | a function of a layer that the base has no equal of, and of the diagnostics |
//! | `tag = "op"` | of an enum: the key whose word says which variant the table is |
//!
//! The variants of an enum without fields are words; `rename` gives one another word. Of an enum with fields each variant is a form of one
//! table; `Name(Type)` is a form with the keys of another declaration. Without a `tag`, a variant with `key = "pass"` is meant where that
//! key is there, and the last one otherwise; `excludes = "…"` is the reason why the other forms' keys cannot stand beside it.
//!
//! # What does not compile
//!
//! A type that cannot be a value, an attribute that does not exist, a layer that could not be merged, and a key without a description:
//!
//! ```compile_fail
//! #[derive(raxel_language::Keys)]
//! struct Lamp {
//!     /// Watts.
//!     power: std::time::Duration,
//! }
//! ```
//!
//! ```compile_fail
//! #[derive(raxel_language::Keys)]
//! struct Lamp {
//!     /// Watts.
//!     #[keys(rnage = 0.0..=1.0)]
//!     power: f64,
//! }
//! ```
//!
//! ```compile_fail
//! #[derive(raxel_language::Keys)]
//! #[keys(layer("lamp", unknown = raxel_diagnostics::codes::graph::UNKNOWN_PARAM))]
//! struct Lamp {
//!     #[keys(entry)]
//!     name: raxel_language::Spanned<String>,
//!     /// Watts.
//!     power: Option<f64>,
//! }
//! ```
//!
//! ```compile_fail
//! #[derive(raxel_language::Keys)]
//! struct Lamp {
//!     power: f64,
//! }
//! ```
//!
//! With a description, the last of them compiles:
//!
//! ```
//! #[derive(raxel_language::Keys)]
//! struct Lamp {
//!     /// Watts.
//!     power: f64,
//! }
//! ```

pub mod key;
pub mod layer;
mod schema;
pub mod value;

pub use key::{Conflict, Form, Key, Shape, Word};
pub use layer::Layer;
pub use raxel_diagnostics::table::{Node, Table};
pub use raxel_diagnostics::{Code, Diagnostic, Spanned};
pub use raxel_language_derive::Keys;
pub use serde_json::Value as Json;
pub use value::{ByName, Describe, Keys, Named, NumberRange, ReadKeys, Value, read_key};
