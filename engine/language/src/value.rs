//! Types that a key can have.

use std::ops::{Deref, RangeInclusive};

use raxel_diagnostics::Spanned;
use raxel_diagnostics::table::{Node, Table};
use serde_json::{Value as Json, json};

use crate::schema::number;
use crate::{Form, Shape};

/// A type with a description of its values.
pub trait Describe: Sized {
    /// The limits that `range` sets; `()` where nothing can be limited.
    type Limits: Default;

    /// The shape of a value within limits.
    fn shape(limits: &Self::Limits) -> Shape;

    /// The value when the key is absent; `None` if the key must be there.
    fn absent() -> Option<Self> {
        None
    }

    /// How the file would say this value; `Null` if a default never is of this type.
    fn written(&self) -> Json {
        Json::Null
    }
}

/// Describes the values of types whose reader is written by hand: `Color => Shape::Text;`.
#[macro_export]
macro_rules! describe {
    ($($value:ty => $shape:expr;)*) => {$(
        impl $crate::Describe for $value {
            type Limits = ();

            fn shape((): &()) -> $crate::Shape {
                $shape
            }
        }
    )*};
}

/// A type that can be read. `C` is the context of reading besides the text.
pub trait Value<C: ?Sized = ()>: Describe {
    /// Reads a value. Reports everything that is wrong with it, and then gives `None`.
    fn read(node: &Node<'_, '_>, limits: &Self::Limits, context: &C) -> Option<Self>;
}

/// A table with declared keys.
pub trait Keys: Sized {
    /// The keys.
    fn form() -> Form;
}

/// A table whose keys can be read.
pub trait ReadKeys<C: ?Sized = ()>: Keys {
    /// Reads the keys. Unknown ones are reported by [`Table::finish`], which is the caller's to call.
    fn read_keys(table: &Table<'_, '_>, context: &C) -> Option<Self>;

    /// Reads a table that has these keys and no others.
    fn read_whole(table: &Table<'_, '_>, context: &C) -> Option<Self> {
        let read = Self::read_keys(table, context);
        table.finish();
        read
    }
}

/// A table that the author names.
pub trait Named<C: ?Sized = ()>: Keys {
    /// Reads the whole table, and reports unknown keys.
    fn read_named(name: Spanned<String>, table: &Table<'_, '_>, context: &C) -> Option<Self>;
}

/// Tables by name, in the order of the file, such as `[params.exposure]`.
#[derive(Clone, Debug, PartialEq)]
pub struct ByName<T>(pub Vec<T>);

impl<T> Default for ByName<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Deref for ByName<T> {
    type Target = Vec<T>;

    fn deref(&self) -> &Vec<T> {
        &self.0
    }
}

impl<'a, T> IntoIterator for &'a ByName<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<T: Keys> Describe for ByName<T> {
    type Limits = ();

    fn shape((): &()) -> Shape {
        Shape::by_name(Shape::Table(T::form()))
    }

    fn absent() -> Option<Self> {
        Some(Self::default())
    }
}

impl<C: ?Sized, T: Named<C>> Value<C> for ByName<T> {
    fn read(node: &Node<'_, '_>, (): &(), context: &C) -> Option<Self> {
        let table = node.table()?;
        let entries = table.entries().into_iter();
        let tables = entries.filter_map(|(name, node)| {
            node.table().map(|table| T::read_named(Spanned::new(name, node.key_span.clone()), &table, context))
        });
        // Every table is read, so that everything wrong is reported.
        let read: Vec<Option<T>> = tables.collect();
        read.into_iter().collect::<Option<_>>().map(Self)
    }
}

/// Numbers from one to another. Limits of a declaration are shown in the schema, those of a type are not.
#[derive(Clone, Debug)]
pub struct NumberRange<T> {
    range: RangeInclusive<T>,
    told: bool,
}

impl<T> From<RangeInclusive<T>> for NumberRange<T> {
    fn from(range: RangeInclusive<T>) -> Self {
        Self { range, told: true }
    }
}

impl Default for NumberRange<f64> {
    fn default() -> Self {
        Self { range: f64::MIN..=f64::MAX, told: false }
    }
}

impl Describe for f64 {
    type Limits = NumberRange<f64>;

    fn shape(limits: &Self::Limits) -> Shape {
        let (least, most) = (*limits.range.start(), *limits.range.end());
        Shape::Number {
            least: Some(least).filter(|least| limits.told && *least > f64::MIN),
            most: Some(most).filter(|most| limits.told && *most < f64::MAX),
        }
    }

    fn written(&self) -> Json {
        number(*self)
    }
}

impl<C: ?Sized> Value<C> for f64 {
    fn read(node: &Node<'_, '_>, limits: &Self::Limits, _: &C) -> Option<Self> {
        node.number(limits.range.clone())
    }
}

impl<const N: usize> Describe for [f64; N] {
    type Limits = NumberRange<f64>;

    fn shape(limits: &Self::Limits) -> Shape {
        Shape::array(f64::shape(limits), N..=N)
    }

    fn written(&self) -> Json {
        self.iter().map(f64::written).collect()
    }
}

impl<C: ?Sized, const N: usize> Value<C> for [f64; N] {
    fn read(node: &Node<'_, '_>, limits: &Self::Limits, _: &C) -> Option<Self> {
        node.numbers(limits.range.clone())
    }
}

macro_rules! integers {
    ($($integer:ty),*) => {$(
        impl Default for NumberRange<$integer> {
            fn default() -> Self {
                Self { range: <$integer>::MIN..=<$integer>::MAX, told: false }
            }
        }

        impl Describe for $integer {
            type Limits = NumberRange<$integer>;

            fn shape(limits: &Self::Limits) -> Shape {
                let told = |end: $integer| i64::try_from(end).ok().filter(|_| limits.told);
                Shape::Integer {
                    least: told(*limits.range.start()).filter(|least| *least > i64::MIN),
                    most: told(*limits.range.end()).filter(|most| *most < i64::MAX),
                }
            }

            fn written(&self) -> Json {
                json!(self)
            }
        }

        impl<C: ?Sized> Value<C> for $integer {
            fn read(node: &Node<'_, '_>, limits: &Self::Limits, _: &C) -> Option<Self> {
                node.integer(limits.range.clone())
            }
        }

        impl<const N: usize> Describe for [$integer; N] {
            type Limits = NumberRange<$integer>;

            fn shape(limits: &Self::Limits) -> Shape {
                Shape::array(<$integer>::shape(limits), N..=N)
            }

            fn written(&self) -> Json {
                self.iter().map(<$integer>::written).collect()
            }
        }

        impl<C: ?Sized, const N: usize> Value<C> for [$integer; N] {
            fn read(node: &Node<'_, '_>, limits: &Self::Limits, _: &C) -> Option<Self> {
                node.integers(limits.range.clone())
            }
        }
    )*};
}

integers!(u8, i32, u32, i64, u64, usize);

impl Describe for bool {
    type Limits = ();

    fn shape((): &()) -> Shape {
        Shape::Flag
    }

    fn written(&self) -> Json {
        json!(self)
    }
}

impl<C: ?Sized> Value<C> for bool {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        node.boolean()
    }
}

impl Describe for String {
    type Limits = ();

    fn shape((): &()) -> Shape {
        Shape::Text
    }

    fn written(&self) -> Json {
        json!(self)
    }
}

impl<C: ?Sized> Value<C> for String {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        node.string()
    }
}

/// The value with its place.
impl<T: Describe> Describe for Spanned<T> {
    type Limits = T::Limits;

    fn shape(limits: &Self::Limits) -> Shape {
        T::shape(limits)
    }

    fn written(&self) -> Json {
        self.value.written()
    }
}

impl<C: ?Sized, T: Value<C>> Value<C> for Spanned<T> {
    fn read(node: &Node<'_, '_>, limits: &Self::Limits, context: &C) -> Option<Self> {
        T::read(node, limits, context).map(|value| Spanned::new(value, node.span.clone()))
    }
}

/// A key that may be absent.
impl<T: Describe> Describe for Option<T> {
    type Limits = T::Limits;

    fn shape(limits: &Self::Limits) -> Shape {
        T::shape(limits)
    }

    fn absent() -> Option<Self> {
        Some(None)
    }

    fn written(&self) -> Json {
        self.as_ref().map_or(Json::Null, T::written)
    }
}

impl<C: ?Sized, T: Value<C>> Value<C> for Option<T> {
    fn read(node: &Node<'_, '_>, limits: &Self::Limits, context: &C) -> Option<Self> {
        T::read(node, limits, context).map(Some)
    }
}

/// An array of any length; it is empty when the key is absent.
impl<T: Describe> Describe for Vec<T> {
    type Limits = T::Limits;

    fn shape(limits: &Self::Limits) -> Shape {
        Shape::array(T::shape(limits), ..)
    }

    fn absent() -> Option<Self> {
        Some(Vec::new())
    }

    fn written(&self) -> Json {
        self.iter().map(T::written).collect()
    }
}

impl<C: ?Sized, T: Value<C>> Value<C> for Vec<T> {
    fn read(node: &Node<'_, '_>, limits: &Self::Limits, context: &C) -> Option<Self> {
        // Every element is read, so that everything wrong is reported.
        let read: Vec<Option<T>> = node.array()?.iter().map(|node| T::read(node, limits, context)).collect();
        read.into_iter().collect()
    }
}

/// Reads a key: `absent` is its value where it is not there, `None` if it must be.
pub fn read_key<T>(
    table: &Table<'_, '_>,
    key: &str,
    absent: Option<T>,
    read: impl FnOnce(&Node<'_, '_>) -> Option<T>,
) -> Option<T> {
    match absent {
        Some(absent) => table.get(key).map_or(Some(absent), |node| read(&node)),
        None => table.need(key).and_then(|node| read(&node)),
    }
}
