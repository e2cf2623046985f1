//! Texts over which the compiler stops the process rather than report a mistake. HLSL has its own in [`crate::hlsl`].

use raxel_diagnostics::{Diagnostic, Span, codes};

use crate::lexer::Token;

/// The layout qualifier of types that hold addresses.
pub(crate) const BUFFER_REFERENCE: &str = "buffer_reference";

/// Why a text of a shader, its own or an included one, cannot be given to the compiler.
pub(crate) fn refusal(path: &str, tokens: &[Token<'_>], hlsl: bool) -> Option<Diagnostic> {
    // Constants are folded, and some cannot be: addresses, and blocks that are called constant.
    let (mut constant, mut block) = (None, false);
    for token in tokens {
        match token.text {
            BUFFER_REFERENCE => {
                let place = Span::new(path, token.range());
                return Some(buffer_reference(path).label(place, "this is an address of the device"));
            }
            "const" => constant = Some(token.range()),
            // In HLSL these are names.
            "buffer" | "uniform" if !hlsl => block = true,
            ";" | "{" | "}" => (constant, block) = (None, false),
            _ => {}
        }
        if let (Some(range), true) = (&constant, block) {
            let message = "a binding cannot be `const`";
            return Some(
                Diagnostic::error(codes::shader::COMPILE, message).label(Span::new(path, range.clone()), "take it out"),
            );
        }
    }
    None
}

/// The refusal of addresses.
pub(crate) fn buffer_reference(path: &str) -> Diagnostic {
    Diagnostic::error(
        codes::graph::CAPABILITY,
        format!("`{path}` needs buffer references, which raxel does not switch on"),
    )
    .help("declare a `buffer` block and bind it by its name")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lexer::tokens;

    #[test]
    fn what_stops_the_compiler_is_refused() {
        let code = |text| refusal("shaders/a.comp", &tokens(text), false).map(|found| found.code.as_str());
        assert_eq!(code("const layout(std430) buffer S { uint a[]; } s;"), Some("RX0210"));
        assert_eq!(code("layout(rgba8) uniform const image2D a;"), Some("RX0210"));
        assert_eq!(code("layout(buffer_reference) buffer Node { uint a; };"), Some("RX0164"));
        let right = "layout(constant_id = 1) const int N = 2; buffer S { int a; }; // const\nvoid f(const int a) {} uniform U { int b; };";
        assert_eq!(code(right), None);
        assert_eq!(refusal("shaders/a.hlsl", &tokens("const uint a = buffer[0];"), true), None);
    }
}
