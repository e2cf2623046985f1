//! Resolves `[params.*]`: type, default, range.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_graph::ValueType;
use raxel_graph::checked::{self, Value};
use raxel_shader::interface::Scalar;

use super::{Declared, missing};
use crate::literal::{describe, typed};
use crate::model::{Data, Literal, Param};

pub(crate) fn param(param: &Param, found: &mut Vec<Diagnostic>) -> Declared<checked::Param> {
    let (before, name) = (found.len(), &param.name);
    let whose = format!("`params.{}`", name.value);
    if param.ty.is_none() && !param.flawed {
        found.push(missing(&whose, "type", &name.span));
    }
    let ty = param.ty.as_ref().and_then(|word| param_type(&word.value, &word.span, found));
    let default = match (&param.default, ty) {
        (Some(literal), Some(ty)) => default(param, literal, ty, found),
        (None, _) if !param.flawed => {
            found.push(missing(&whose, "default", &name.span));
            None
        }
        _ => None,
    };
    range(param, ty, default, found);
    choices(param, ty, default, found);
    color(param, ty, found);
    let detail = param.ty.as_ref().map_or(&name.span, |ty| &ty.span).clone();
    let item = checked::Param {
        name: name.value.clone(),
        default: default.unwrap_or(Value::Bool(false)),
        range: match (&param.choices, &param.range) {
            (Some(choices), _) => Some([0.0, choices.value.0.len() as f64 - 1.0]),
            (None, range) => range.as_ref().map(|range| range.value),
        },
        step: param.step.as_ref().map(|step| step.value),
        label: said(param.label.as_ref()).unwrap_or_else(|| name.value.clone()),
        tooltip: said(param.tooltip.as_ref()),
        unit: said(param.unit.as_ref()),
        group: said(param.group.as_ref()),
        choices: param.choices.iter().flat_map(|names| &names.value.0).map(|name| name.value.clone()).collect(),
        color: param.color.as_ref().map_or_else(|| is_called_color(param, ty), |color| color.value),
        place: name.span.clone(),
    };
    Declared { item, sound: default.is_some() && !param.flawed && found.len() == before, detail }
}

/// The text of a key, unless it is empty.
fn said(text: Option<&Spanned<String>>) -> Option<String> {
    text.map(|text| text.value.clone()).filter(|text| !text.trim().is_empty())
}

/// The type of that word; a param can be all but a matrix.
fn param_type(word: &str, place: &Span, found: &mut Vec<Diagnostic>) -> Option<ValueType> {
    let words = || ValueType::words().filter(|word| *word != "mat4");
    if words().any(|known| known == word) {
        return ValueType::from_word(word);
    }
    found.push(unknown_type(word, place, words()));
    None
}

/// The diagnostic for a word that is no type.
pub(crate) fn unknown_type<'n>(word: &str, place: &Span, words: impl Iterator<Item = &'n str> + Clone) -> Diagnostic {
    let diagnostic = Diagnostic::error(codes::graph::UNKNOWN_TYPE, format!("there is no type `{word}`"))
        .label(place.clone(), "no such type");
    match ValueType::word_of_glsl(word).or_else(|| closest(word, words.clone())) {
        Some(word) => diagnostic.help(format!("did you mean `{word}`?")),
        None => diagnostic.help(format!("one of: {}", list(words))),
    }
}

fn default(param: &Param, literal: &Literal, ty: ValueType, found: &mut Vec<Diagnostic>) -> Option<Value> {
    let value = typed(literal, ty);
    if value.is_none() {
        let mut diagnostic = Diagnostic::error(
            codes::graph::LITERAL,
            format!(
                "the default of param `{}` is {}, which is no `{}`",
                param.name.value,
                describe(literal),
                ty.word()
            ),
        )
        .label(literal.span.clone(), "");
        if let Some(ty) = &param.ty {
            diagnostic = diagnostic.label(ty.span.clone(), "the type");
        }
        found.push(diagnostic);
    }
    value
}

fn range(param: &Param, ty: Option<ValueType>, default: Option<Value>, found: &mut Vec<Diagnostic>) {
    let Some(range) = &param.range else { return };
    let ([low, high], name) = (range.value, &param.name.value);
    let error = |message: String| Diagnostic::error(codes::graph::PARAM_RANGE, message);
    if ty.is_some_and(|ty| ty.scalar == Scalar::Bool) {
        let message = format!("param `{name}` is a `bool`, which has no range");
        found.push(error(message).label(range.span.clone(), "the range"));
    } else if low >= high {
        let message = format!("the range of param `{name}` is empty: {low} is not less than {high}");
        let diagnostic = error(message).label(range.span.clone(), "the range");
        found.push(if low > high { diagnostic.help(format!("write [{high}, {low}]")) } else { diagnostic });
    } else if let (Some(_), Some(literal)) = (default, &param.default) {
        // As written, before it is rounded to 32 bits.
        if let Some(outside) = numbers(literal).into_iter().find(|number| !(low..=high).contains(number)) {
            let message = format!("the default of param `{name}` is {outside}, outside its range {low}…{high}");
            found
                .push(error(message).label(literal.span.clone(), "the default").label(range.span.clone(), "the range"));
        }
    }
}

fn choices(param: &Param, ty: Option<ValueType>, default: Option<Value>, found: &mut Vec<Diagnostic>) {
    let Some(choices) = &param.choices else { return };
    let name = &param.name.value;
    let error = |message: String| Diagnostic::error(codes::graph::PARAM_CHOICES, message);
    if let Some(ty) = ty
        && !([ty.rows, ty.columns] == [1, 1] && matches!(ty.scalar, Scalar::I32 | Scalar::U32))
    {
        let mut diagnostic = error(format!("param `{name}` is a `{}`, which has no choices", ty.word()))
            .label(choices.span.clone(), "the choices");
        if let Some(ty) = &param.ty {
            diagnostic = diagnostic.label(ty.span.clone(), "the type");
        }
        found.push(diagnostic.help("the names stand for the values 0, 1, 2, … of an `i32` or `u32`"));
        return;
    }
    if let Some(range) = &param.range {
        let message = format!("`choices` and `range` of param `{name}` exclude each other: the choices are the range");
        found.push(
            Diagnostic::error(codes::files::CONFLICTING_KEYS, message)
                .label(choices.span.clone(), "this one")
                .label(range.span.clone(), "and this one"),
        );
    }
    for (index, choice) in choices.value.0.iter().enumerate() {
        if let Some(first) = choices.value.0[..index].iter().find(|first| first.value == choice.value) {
            let message = format!("two choices of param `{name}` are called `{}`", choice.value);
            found.push(error(message).label(choice.span.clone(), "again").label(first.span.clone(), "first here"));
        }
    }
    if let (Some(_), Some(literal)) = (default, &param.default) {
        let last = choices.value.0.len() - 1;
        if let Some(outside) = numbers(literal).into_iter().find(|number| !(0.0..=last as f64).contains(number)) {
            let message = format!("the default of param `{name}` is {outside}; its choices are 0…{last}");
            found.push(
                error(message).label(literal.span.clone(), "the default").label(choices.span.clone(), "the choices"),
            );
        }
    }
}

fn color(param: &Param, ty: Option<ValueType>, found: &mut Vec<Diagnostic>) {
    let (Some(color), Some(ty)) = (param.color.as_ref().filter(|color| color.value), ty) else { return };
    if !can_be_color(ty) {
        let message = format!("param `{}` is a `{}`, which is not a colour", param.name.value, ty.word());
        let mut diagnostic = Diagnostic::error(codes::graph::PARAM_COLOR, message)
            .label(color.span.clone(), "declared as a colour here");
        if let Some(ty) = &param.ty {
            diagnostic = diagnostic.label(ty.span.clone(), "the type");
        }
        found.push(diagnostic.help("colours are `vec3` or, with opacity, `vec4`"));
    }
}

fn can_be_color(ty: ValueType) -> bool {
    ty.scalar == Scalar::F32 && matches!([ty.rows, ty.columns], [3 | 4, 1])
}

/// Where a file does not say, the name or the label does.
fn is_called_color(param: &Param, ty: Option<ValueType>) -> bool {
    let label = param.label.as_ref().map_or("", |label| &label.value);
    let text = format!("{} {label}", param.name.value).to_lowercase();
    let called = ["color", "colour", "tint", "albedo"].iter().any(|word| text.contains(word));
    called && ty.is_some_and(can_be_color)
}

fn numbers(literal: &Literal) -> Vec<f64> {
    match &literal.data {
        Data::Bool(_) => Vec::new(),
        Data::Int(value) => vec![*value as f64],
        Data::Float(value) => vec![*value],
        Data::Array(elements) => elements.iter().flat_map(numbers).collect(),
    }
}
