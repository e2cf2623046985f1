//! Keys as data: the source of schemas, reference pages, completion and hover texts.

use std::borrow::Cow;
use std::fmt;
use std::ops::{Bound, RangeBounds};

use serde_json::Value;

/// The keys of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Form {
    /// The description of the table.
    pub about: &'static str,
    /// Its keys, in the order in which they are declared.
    pub keys: Vec<Key>,
    /// If any: the table has the keys of one of these, too.
    pub forms: Vec<Form>,
}

/// A key of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// The shape of its value.
    pub shape: Shape,
    /// Unit of its value.
    pub unit: Option<&'static str>,
    /// The value for an absent key.
    pub default: Option<Value>,
    /// It must be there.
    pub needed: bool,
    /// Keys that cannot stand beside it. Each of them has this key in its own list.
    pub conflicts: Vec<Conflict>,
}

/// A key that cannot stand beside another.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    /// The name of that key.
    pub with: &'static str,
    /// The reason, as the second half of a sentence.
    pub why: &'static str,
}

/// The shape of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A string.
    Text,
    /// `true` or `false`.
    Flag,
    /// An integer in a range.
    Integer {
        /// The smallest, if the schema shows it.
        least: Option<i64>,
        /// The largest, if the schema shows it.
        most: Option<i64>,
    },
    /// A finite number in a range.
    Number {
        /// The smallest, if the schema shows it.
        least: Option<f64>,
        /// The largest, if the schema shows it.
        most: Option<f64>,
    },
    /// One of several words.
    Words(Vec<Word>),
    /// This word and no other: the key that distinguishes one of several forms of a table.
    Word(&'static str),
    /// An array.
    Array {
        /// The shape of each element.
        of: Box<Shape>,
        /// The smallest number of elements, if the schema shows it.
        least: Option<usize>,
        /// The largest number of elements, if the schema shows it.
        most: Option<usize>,
    },
    /// A table.
    Table(Form),
    /// A table of values that the author names.
    ByName(Box<Shape>),
    /// One of several.
    Either(Vec<Shape>),
    /// A shape that none of the others can describe, as a JSON schema.
    Schema(Value),
}

/// A word that a value can be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// The word, as files have it.
    pub name: Cow<'static, str>,
    /// Its meaning. Empty where its name says it all.
    pub about: String,
}

impl Shape {
    /// Words that mean what they say.
    pub fn words(names: impl IntoIterator<Item = &'static str>) -> Self {
        Self::Words(names.into_iter().map(|name| Word { name: name.into(), about: String::new() }).collect())
    }

    /// An array of that many elements.
    pub fn array(of: Shape, counts: impl RangeBounds<usize>) -> Self {
        let told = |bound: Bound<&usize>| if let Bound::Included(count) = bound { Some(*count) } else { None };
        Self::Array { of: Box::new(of), least: told(counts.start_bound()), most: told(counts.end_bound()) }
    }

    /// Values that the author names.
    pub fn by_name(of: Shape) -> Self {
        Self::ByName(Box::new(of))
    }
}

impl Form {
    /// Its own keys, followed by those of its forms.
    pub fn all_keys(&self) -> Vec<&Key> {
        self.keys.iter().chain(self.forms.iter().flat_map(Form::all_keys)).collect()
    }

    fn all_keys_mut(&mut self) -> Vec<&mut Key> {
        self.keys.iter_mut().chain(self.forms.iter_mut().flat_map(Form::all_keys_mut)).collect()
    }

    /// Adds that a key cannot stand beside others, to that key and to each of the others.
    pub fn exclude(&mut self, name: &'static str, others: &[&'static str], why: &'static str) {
        for key in self.all_keys_mut() {
            if key.name == name {
                key.conflicts.extend(others.iter().map(|other| Conflict { with: other, why }));
            } else if others.contains(&key.name) {
                key.conflicts.push(Conflict { with: name, why });
            }
        }
    }
}

impl Key {
    /// Its meaning, and the keys that cannot stand beside it.
    pub fn description(&self) -> String {
        let mut text = self.about.to_owned();
        let mut left = &self.conflicts[..];
        while let Some(Conflict { why, .. }) = left.first() {
            // One sentence for all neighbours with one reason.
            let (same, others) = left.split_at(left.iter().take_while(|conflict| conflict.why == *why).count());
            let names: Vec<String> = same.iter().map(|conflict| format!("`{}`", conflict.with)).collect();
            let names = match names.split_last() {
                Some((last, first)) if !first.is_empty() => format!("{} or {last}", first.join(", ")),
                _ => names.concat(),
            };
            text = format!("{text} Not beside {names}: {why}.");
            left = others;
        }
        text
    }
}

/// In a line: the name, the shape of the value, and the description.
impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.name, self.shape)?;
        if let Some(unit) = self.unit {
            write!(f, ", {unit}")?;
        }
        match &self.default {
            Some(default) => write!(f, ", {default} by default")?,
            None if self.needed => write!(f, ", needed")?,
            None => {}
        }
        write!(f, ". {}", self.description())
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::Text => write!(f, "text"),
            Shape::Flag => write!(f, "true or false"),
            Shape::Integer { least, most } => {
                write!(f, "integer")?;
                range(f, least.as_ref(), most.as_ref())
            }
            Shape::Number { least, most } => {
                write!(f, "number")?;
                range(f, least.as_ref(), most.as_ref())
            }
            Shape::Words(words) => {
                write!(f, "{}", words.iter().map(|word| &*word.name).collect::<Vec<_>>().join(" or "))
            }
            Shape::Word(word) => write!(f, "{word}"),
            Shape::Array { of, least: Some(least), most: Some(most) } if least == most => {
                write!(f, "array of {least} ({of})")
            }
            Shape::Array { of, .. } => write!(f, "array ({of})"),
            Shape::Table(_) => write!(f, "table"),
            Shape::ByName(of) => write!(f, "by name ({of})"),
            Shape::Either(shapes) => {
                let shapes: Vec<String> = shapes.iter().map(Shape::to_string).collect();
                write!(f, "{}", shapes.join(", or "))
            }
            Shape::Schema(_) => write!(f, "value"),
        }
    }
}

fn range<T: fmt::Display>(f: &mut fmt::Formatter<'_>, least: Option<&T>, most: Option<&T>) -> fmt::Result {
    match (least, most) {
        (Some(least), Some(most)) => write!(f, " in {least}…{most}"),
        (Some(least), None) => write!(f, ", at least {least}"),
        (None, Some(most)) => write!(f, ", at most {most}"),
        (None, None) => Ok(()),
    }
}
