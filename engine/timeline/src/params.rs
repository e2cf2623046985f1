//! Params and push overrides by name: the values that users set on the command line, in the window or in a demo. They last over reloads, as
//! long as the graph declares the name with the same type.

use std::collections::BTreeMap;

use raxel_diagnostics::names::{closest, list};
use raxel_graph::checked::{Graph, Param, ParamId, Value};

/// Why a value could not be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SetError {
    /// The graph has nothing of this name.
    #[error("the graph has no {kind} `{name}`{}", advice(.closest.as_deref(), .known))]
    Unknown {
        /// The type of the wanted thing: `param`, `pass`, `push member` or `target`.
        kind: &'static str,
        /// The unknown name.
        name: String,
        /// The closest known name, if one is close.
        closest: Option<String>,
        /// All known names.
        known: Vec<String>,
    },
    /// The value has another type than the param.
    #[error("`{name}` is {expected}, not {found}")]
    WrongType {
        /// Name.
        name: String,
        /// The type that the graph declares.
        expected: &'static str,
        /// The type of the value.
        found: &'static str,
    },
    /// A component of the value is NaN or infinite.
    #[error("`{name}` must be finite")]
    NotFinite {
        /// Name.
        name: String,
    },
    /// The value has another number of components than the member.
    #[error("`{name}` has {expected} components, which {found} has not")]
    WrongShape {
        /// Name.
        name: String,
        /// Number of components of the member.
        expected: u32,
        /// The type of the value.
        found: &'static str,
    },
    /// The value is outside the range that the graph declares.
    #[error("`{name}` is {found}; it must be in {}…{}", .range[0], .range[1])]
    OutOfRange {
        /// Name.
        name: String,
        /// The component outside of the range.
        found: f64,
        /// Smallest and largest value.
        range: [f64; 2],
    },
    /// The text is no choice of the param, and no number of one.
    #[error("`{name}` has no choice `{text}`{}", advice(.closest.as_deref(), .known))]
    NotAChoice {
        /// Name.
        name: String,
        /// The text.
        text: String,
        /// The closest choice, if one is close.
        closest: Option<String>,
        /// All choices.
        known: Vec<String>,
    },
    /// The text is not a value of the type.
    #[error("`{text}` is no {expected}, which `{name}` needs")]
    NotAValue {
        /// Name.
        name: String,
        /// The text.
        text: String,
        /// The type that the graph declares.
        expected: &'static str,
    },
}

fn advice(closest: Option<&str>, known: &[String]) -> String {
    match closest {
        Some(name) => format!("; did you mean `{name}`?"),
        None if known.is_empty() => String::new(),
        None => format!("; there are {}", list(known.iter().map(String::as_str))),
    }
}

impl SetError {
    /// An error for a name that the graph does not have.
    pub fn unknown<'n>(kind: &'static str, name: &str, known: impl Iterator<Item = &'n str> + Clone) -> Self {
        Self::Unknown {
            kind,
            name: name.to_owned(),
            closest: closest(name, known.clone()).map(str::to_owned),
            known: known.map(str::to_owned).collect(),
        }
    }
}

/// The values of a graph's params.
#[derive(Clone, Debug, Default)]
pub struct Params {
    /// Values by [`ParamId`], ready for a frame.
    values: Vec<Value>,
    /// Values that were set, by name; kept across reloads even while the graph lacks the name, so that undoing an edit restores it.
    set: BTreeMap<String, Value>,
    version: u64,
}

impl Params {
    /// Adopts the params of a graph. Values that were set stay if type and range allow; all others get the graph's default.
    pub fn adopt(&mut self, graph: &Graph) {
        self.values = graph
            .params
            .iter()
            .map(|param| match self.set.get(&param.name) {
                Some(value) if type_name(value) == type_name(&param.default) => clamped(*value, param.range),
                _ => param.default,
            })
            .collect();
        self.version += 1;
    }

    /// A number that grows whenever a value may have changed.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// The value of a param of the adopted graph.
    pub fn get(&self, id: ParamId) -> Value {
        self.values[id.0 as usize]
    }

    /// All values, in the order of the graph's params.
    pub fn values(&self) -> &[Value] {
        &self.values
    }

    /// Sets a param by name. A number of another type is converted if nothing is lost, such as `1` for an `f32`.
    pub fn set(&mut self, graph: &Graph, name: &str, value: Value) -> Result<(), SetError> {
        let (index, param) = find(graph, name)?;
        let value = checked(param, value)?;
        self.set.insert(name.to_owned(), value);
        if self.values[index] != value {
            self.values[index] = value;
            self.version += 1;
        }
        Ok(())
    }

    /// Returns a param to the graph's default.
    pub fn unset(&mut self, graph: &Graph, name: &str) -> Result<(), SetError> {
        let (index, param) = find(graph, name)?;
        self.set.remove(name);
        self.values[index] = param.default;
        self.version += 1;
        Ok(())
    }
}

/// The param of that name with its index.
fn find<'g>(graph: &'g Graph, name: &str) -> Result<(usize, &'g Param), SetError> {
    graph.params.iter().enumerate().find(|(_, param)| param.name == name).ok_or_else(|| {
        let known: Vec<&str> = graph.params.iter().map(|param| param.name.as_str()).collect();
        SetError::unknown("param", name, known.into_iter())
    })
}

/// Converts a value to the param's type, and checks its range.
pub fn checked(param: &Param, value: Value) -> Result<Value, SetError> {
    if components(&value).iter().any(|number| !number.is_finite()) {
        return Err(SetError::NotFinite { name: param.name.clone() });
    }
    let value = converted(value, &param.default).ok_or_else(|| SetError::WrongType {
        name: param.name.clone(),
        expected: type_name(&param.default),
        found: type_name(&value),
    })?;
    if let Some(range) = param.range
        && let Some(&found) = components(&value).iter().find(|&&number| number < range[0] || number > range[1])
    {
        return Err(SetError::OutOfRange { name: param.name.clone(), found, range });
    }
    Ok(value)
}

/// Reads the value of a param from text: `0.5`, `true`, `1,2,3`, `[1, 2, 3]`, or the name of a choice.
pub fn parse(graph: &Graph, name: &str, text: &str) -> Result<Value, SetError> {
    let (_, param) = find(graph, name)?;
    let choice = param.choices.iter().position(|choice| choice == text.trim());
    let value = match choice {
        Some(index) => from_components(&[index as f64], &param.default),
        None => parse_like(text, &param.default),
    };
    let value = value.ok_or_else(|| match param.choices.as_slice() {
        [] => SetError::NotAValue { name: name.to_owned(), text: text.to_owned(), expected: type_name(&param.default) },
        choices => SetError::NotAChoice {
            name: name.to_owned(),
            text: text.to_owned(),
            closest: closest(text, choices.iter().map(String::as_str)).map(str::to_owned),
            known: choices.to_vec(),
        },
    })?;
    checked(param, value)
}

/// Reads a value of the type of `like` from text.
pub(crate) fn parse_like(text: &str, like: &Value) -> Option<Value> {
    let text = text.trim();
    if let Value::Bool(_) = like {
        return match text {
            "true" | "1" => Some(Value::Bool(true)),
            "false" | "0" => Some(Value::Bool(false)),
            _ => None,
        };
    }
    let inner = text.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(text);
    let numbers: Vec<f64> = inner.split(',').map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    from_components(&numbers, like)
}

/// GLSL's name of a value's type.
pub fn type_name(value: &Value) -> &'static str {
    match value {
        Value::Bool(_) => "bool",
        Value::I32(_) => "i32",
        Value::U32(_) => "u32",
        Value::F32(_) => "f32",
        Value::IVec2(_) => "ivec2",
        Value::IVec3(_) => "ivec3",
        Value::IVec4(_) => "ivec4",
        Value::UVec2(_) => "uvec2",
        Value::UVec3(_) => "uvec3",
        Value::UVec4(_) => "uvec4",
        Value::Vec2(_) => "vec2",
        Value::Vec3(_) => "vec3",
        Value::Vec4(_) => "vec4",
        Value::Mat4(_) => "mat4",
    }
}

/// Whether a value has integer components.
pub fn is_integer(value: &Value) -> bool {
    use Value::{I32, IVec2, IVec3, IVec4, U32, UVec2, UVec3, UVec4};
    matches!(value, I32(_) | U32(_) | IVec2(_) | IVec3(_) | IVec4(_) | UVec2(_) | UVec3(_) | UVec4(_))
}

/// The components of a value as numbers. A bool is 0 or 1. A matrix gives its columns one after the other.
pub fn components(value: &Value) -> Vec<f64> {
    fn all<T: Copy + Into<f64>>(parts: &[T]) -> Vec<f64> {
        parts.iter().map(|&part| part.into()).collect()
    }
    match value {
        Value::Bool(value) => vec![f64::from(u8::from(*value))],
        Value::I32(value) => vec![f64::from(*value)],
        Value::U32(value) => vec![f64::from(*value)],
        Value::F32(value) => vec![f64::from(*value)],
        Value::IVec2(parts) => all(parts),
        Value::IVec3(parts) => all(parts),
        Value::IVec4(parts) => all(parts),
        Value::UVec2(parts) => all(parts),
        Value::UVec3(parts) => all(parts),
        Value::UVec4(parts) => all(parts),
        Value::Vec2(parts) => all(parts),
        Value::Vec3(parts) => all(parts),
        Value::Vec4(parts) => all(parts),
        Value::Mat4(columns) => all(columns.as_flattened()),
    }
}

/// Makes a value of the type of `like` from one number for each component. `None` if the count differs, a number is not finite, or an
/// integer type gets a fraction or too large a number.
pub fn from_components(numbers: &[f64], like: &Value) -> Option<Value> {
    fn array<const N: usize, T: Copy + Default>(numbers: &[f64], convert: impl Fn(f64) -> Option<T>) -> Option<[T; N]> {
        let numbers: &[f64; N] = numbers.try_into().ok()?;
        let mut parts = [T::default(); N];
        for (part, number) in parts.iter_mut().zip(numbers) {
            *part = convert(*number)?;
        }
        Some(parts)
    }
    #[expect(clippy::cast_possible_truncation, reason = "the number is an integer of 32 bits")]
    fn signed<const N: usize>(numbers: &[f64]) -> Option<[i32; N]> {
        let fits = |n: f64| n.fract() == 0.0 && n >= f64::from(i32::MIN) && n <= f64::from(i32::MAX);
        array(numbers, |n| fits(n).then_some(n as i32))
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the number is an integer of 32 bits")]
    fn unsigned<const N: usize>(numbers: &[f64]) -> Option<[u32; N]> {
        array(numbers, |n| (n.fract() == 0.0 && n >= 0.0 && n <= f64::from(u32::MAX)).then_some(n as u32))
    }
    #[expect(clippy::cast_possible_truncation, reason = "a param is a 32-bit float, and what overflows it is refused")]
    fn float<const N: usize>(numbers: &[f64]) -> Option<[f32; N]> {
        array(numbers, |n| Some(n as f32).filter(|n| n.is_finite()))
    }
    Some(match like {
        Value::Bool(_) => match numbers {
            [0.0] => Value::Bool(false),
            [1.0] => Value::Bool(true),
            _ => return None,
        },
        Value::I32(_) => Value::I32(signed::<1>(numbers)?[0]),
        Value::U32(_) => Value::U32(unsigned::<1>(numbers)?[0]),
        Value::F32(_) => Value::F32(float::<1>(numbers)?[0]),
        Value::IVec2(_) => Value::IVec2(signed(numbers)?),
        Value::IVec3(_) => Value::IVec3(signed(numbers)?),
        Value::IVec4(_) => Value::IVec4(signed(numbers)?),
        Value::UVec2(_) => Value::UVec2(unsigned(numbers)?),
        Value::UVec3(_) => Value::UVec3(unsigned(numbers)?),
        Value::UVec4(_) => Value::UVec4(unsigned(numbers)?),
        Value::Vec2(_) => Value::Vec2(float(numbers)?),
        Value::Vec3(_) => Value::Vec3(float(numbers)?),
        Value::Vec4(_) => Value::Vec4(float(numbers)?),
        Value::Mat4(_) => {
            let parts: [f32; 16] = float(numbers)?;
            Value::Mat4(std::array::from_fn(|column| std::array::from_fn(|row| parts[column * 4 + row])))
        }
    })
}

/// Converts a value to the type of `like`. A bool never becomes a number.
pub fn converted(value: Value, like: &Value) -> Option<Value> {
    if matches!(value, Value::Bool(_)) == matches!(like, Value::Bool(_)) {
        from_components(&components(&value), like)
    } else {
        None
    }
}

fn clamped(value: Value, range: Option<[f64; 2]>) -> Value {
    let Some([low, high]) = range.filter(|[low, high]| low <= high) else { return value };
    let numbers: Vec<f64> = components(&value).iter().map(|number| number.clamp(low, high)).collect();
    from_components(&numbers, &value).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use raxel_diagnostics::Span;
    use raxel_graph::checked::ResourceId;

    use super::*;

    fn graph(params: &[(&str, Value, Option<[f64; 2]>)]) -> Graph {
        let params = params.iter().map(|(name, default, range)| Param {
            range: *range,
            ..Param::new(*name, *default, Span::new("graphs/a.toml", 0..0))
        });
        Graph {
            name: "a".into(),
            about: String::new(),
            present: ResourceId(0),
            clocks: Vec::new(),
            params: params.collect(),
            resources: Vec::new(),
            loops: Vec::new(),
            passes: Vec::new(),
            materials: Vec::new(),
            files: Vec::new(),
        }
    }

    #[test]
    fn what_is_not_finite_is_refused_by_that_name() {
        let graph = graph(&[("exposure", Value::F32(1.0), Some([0.0, 8.0])), ("sun", Value::Vec3([0.0; 3]), None)]);
        let mut params = Params::default();
        params.adopt(&graph);
        for (name, value) in [("exposure", Value::F32(f32::NAN)), ("sun", Value::Vec3([0.0, f32::INFINITY, 0.0]))] {
            let error = params.set(&graph, name, value).unwrap_err();
            assert_eq!(error.to_string(), format!("`{name}` must be finite"));
        }
        assert_eq!(params.values(), [Value::F32(1.0), Value::Vec3([0.0; 3])]);
    }

    #[test]
    fn what_was_set_survives_a_reload_and_defaults_follow_the_file() {
        let mut params = Params::default();
        let first = graph(&[("exposure", Value::F32(1.0), Some([0.0, 8.0])), ("bounces", Value::I32(2), None)]);
        params.adopt(&first);
        params.set(&first, "exposure", Value::F32(5.0)).unwrap();
        // The range shrinks, the other default changes, a param is added.
        let second = graph(&[
            ("sun", Value::Vec3([0.0, 1.0, 0.0]), None),
            ("bounces", Value::I32(3), None),
            ("exposure", Value::F32(1.0), Some([0.0, 4.0])),
        ]);
        params.adopt(&second);
        assert_eq!(params.values(), [Value::Vec3([0.0, 1.0, 0.0]), Value::I32(3), Value::F32(4.0)]);
        // The type changes: the default counts. It changes back: so does the value.
        params.adopt(&graph(&[("exposure", Value::Vec2([1.0; 2]), None)]));
        assert_eq!(params.values(), [Value::Vec2([1.0; 2])]);
        params.adopt(&first);
        assert_eq!(params.values(), [Value::F32(5.0), Value::I32(2)]);
        params.unset(&first, "exposure").unwrap();
        assert_eq!(params.get(ParamId(0)), Value::F32(1.0));
    }

    #[test]
    fn wrong_values_say_what_disagrees() {
        let graph = graph(&[("exposure", Value::F32(1.0), Some([0.0, 8.0])), ("fog", Value::Bool(true), None)]);
        let mut params = Params::default();
        params.adopt(&graph);
        let mut said = |name: &str, value| params.set(&graph, name, value).unwrap_err().to_string();
        assert_eq!(said("exposre", Value::F32(1.0)), "the graph has no param `exposre`; did you mean `exposure`?");
        assert_eq!(said("zzz", Value::F32(1.0)), "the graph has no param `zzz`; there are `exposure`, `fog`");
        assert_eq!(said("fog", Value::F32(1.0)), "`fog` is bool, not f32");
        assert_eq!(said("exposure", Value::F32(9.0)), "`exposure` is 9; it must be in 0…8");
        params.set(&graph, "exposure", Value::I32(2)).unwrap();
        assert_eq!(params.get(ParamId(0)), Value::F32(2.0));
    }

    #[test]
    fn choices_are_set_by_name_and_by_number() {
        let mut graph = graph(&[("tone", Value::U32(0), Some([0.0, 1.0]))]);
        graph.params[0].choices = vec!["Reinhard".to_owned(), "AgX".to_owned()];
        assert_eq!(parse(&graph, "tone", " AgX "), Ok(Value::U32(1)));
        assert_eq!(parse(&graph, "tone", "1"), Ok(Value::U32(1)));
        let said = |text| parse(&graph, "tone", text).unwrap_err().to_string();
        assert_eq!(said("Agx"), "`tone` has no choice `Agx`; did you mean `AgX`?");
        assert_eq!(said("-"), "`tone` has no choice `-`; there are `Reinhard`, `AgX`");
        assert_eq!(said("2"), "`tone` is 2; it must be in 0…1");
    }

    #[test]
    fn values_are_read_from_text() {
        let read = |text, like| parse_like(text, &like);
        assert_eq!(read("0.5", Value::F32(0.0)), Some(Value::F32(0.5)));
        assert_eq!(read("[1, -2,3]", Value::IVec3([0; 3])), Some(Value::IVec3([1, -2, 3])));
        assert_eq!(read("true", Value::Bool(false)), Some(Value::Bool(true)));
        for (text, like) in [("0.5", Value::I32(0)), ("-1", Value::U32(0)), ("1,2", Value::Vec3([0.0; 3]))] {
            assert_eq!(read(text, like), None, "{text}");
        }
        for text in ["", "nan", "1e99", "x", "[1"] {
            assert_eq!(read(text, Value::F32(0.0)), None, "{text}");
        }
        assert_eq!(read("5000000000", Value::I32(0)), None);
    }
}
