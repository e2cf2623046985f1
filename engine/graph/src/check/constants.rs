//! Specialization constants: each that the graph sets is one of the shader's, with a value of its type.

use raxel_diagnostics::table::{closest, list};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_shader::interface::Type;

use super::Context;
use crate::checked::Value;
use crate::value::{ValueType, describe, glsl, typed};

/// Checks `specialization`; gives values by constant id, in order of the ids.
pub fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) -> Vec<(u32, Value)> {
    let constants = &context.interface().specialization;
    let mut values: Vec<(u32, Value)> = Vec::new();
    for (name, literal) in &context.pass.specialization {
        let Some(constant) = constants.iter().find(|constant| constant.name == name.value && !name.value.is_empty())
        else {
            let names = || constants.iter().map(|constant| constant.name.as_str()).filter(|name| !name.is_empty());
            let diagnostic = Diagnostic::error(
                codes::graph::UNKNOWN_CONSTANT,
                format!("`{}` has no specialization constant `{}`", context.shader.request.path, name.value),
            )
            .label(name.span.clone(), "no such constant");
            found.push(match closest(&name.value, names()) {
                Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
                None if names().next().is_none() => {
                    diagnostic.help("declare it, e.g. `layout(constant_id = 0) const int NAME = 1;`")
                }
                None => diagnostic.help(format!("there is {}", list(names()))),
            });
            continue;
        };
        if let Some(value) = typed(literal, ValueType::new(constant.scalar, (1, 1))) {
            values.push((constant.id, value));
            continue;
        }
        let diagnostic = Diagnostic::error(
            codes::graph::CONSTANT_TYPE,
            format!(
                "constant `{}` is `{}` in the shader, but its value is {}",
                name.value,
                glsl(&Type::Scalar(constant.scalar)),
                describe(literal)
            ),
        )
        .label(literal.span.clone(), "");
        found.push(context.in_shader(diagnostic, constant.place.as_ref(), "the shader says"));
    }
    values.sort_by_key(|(id, _)| *id);
    values
}
