//! The functions that a call may mean: those that the shader's texts define, and those of GLSL.

use std::ops::Range;

use crate::lexer::{self, Token};

/// Functions of GLSL that a compute shader can call. If arguments do not fit, the compiler reports them as it reports an unknown name.
const BUILT_IN: &str = "\
    radians degrees sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh pow exp log exp2 log2 sqrt inversesqrt abs sign floor trunc round \
    roundEven ceil fract mod modf min max clamp mix step smoothstep isnan isinf floatBitsToInt floatBitsToUint intBitsToFloat uintBitsToFloat fma \
    frexp ldexp packUnorm2x16 packSnorm2x16 packUnorm4x8 packSnorm4x8 unpackUnorm2x16 unpackSnorm2x16 unpackUnorm4x8 unpackSnorm4x8 packHalf2x16 \
    unpackHalf2x16 packDouble2x32 unpackDouble2x32 length distance dot cross normalize faceforward reflect refract matrixCompMult outerProduct \
    transpose determinant inverse lessThan lessThanEqual greaterThan greaterThanEqual equal notEqual any all not uaddCarry usubBorrow umulExtended \
    imulExtended bitfieldExtract bitfieldInsert bitfieldReverse bitCount findLSB findMSB textureSize textureQueryLod textureQueryLevels texture \
    textureLod textureOffset texelFetch texelFetchOffset textureGrad textureGather atomicAdd atomicMin atomicMax atomicAnd atomicOr atomicXor \
    atomicExchange atomicCompSwap imageSize imageLoad imageStore imageAtomicAdd imageAtomicMin imageAtomicMax imageAtomicAnd imageAtomicOr \
    imageAtomicXor imageAtomicExchange imageAtomicCompSwap barrier memoryBarrier memoryBarrierBuffer memoryBarrierImage memoryBarrierShared \
    groupMemoryBarrier";

/// Whether a name is one of GLSL's own functions.
pub(crate) fn is_built_in(name: &str) -> bool {
    BUILT_IN.split_whitespace().any(|built_in| built_in == name)
}

/// Where a text defines functions of a name: each from the name to the end of its parameters.
pub(crate) fn definitions(text: &str, name: &str) -> Vec<Range<usize>> {
    let tokens = lexer::tokens(text);
    let defines = |at: usize| -> Option<Range<usize>> {
        // A type stands before a definition, and a body follows.
        let typed =
            at.checked_sub(1).is_some_and(|before| tokens[before].is_identifier() || tokens[before].text == "]");
        let end = at + 1 + closing(tokens.get(at + 1..)?)?;
        let body = tokens.get(end + 1).is_some_and(|token| token.text == "{");
        (typed && body).then(|| tokens[at].at..tokens[end].range().end)
    };
    (0..tokens.len()).filter(|at| tokens[*at].text == name).filter_map(defines).collect()
}

/// The place of the parenthesis that closes the one at the beginning.
fn closing(tokens: &[Token<'_>]) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, token) in tokens.iter().enumerate() {
        match token.text {
            "(" => depth += 1,
            ")" => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth == 0 {
            return (token.text == ")").then_some(at);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_are_told_from_calls() {
        let text = "float f(vec2 a, float b[2]);\nfloat f(vec2 a, float b[2]) {\n    if (a.x > 0.0) return f(a.yx, b);\n    f(a, b);\n}\n\
                    vec3[2] f() { }\n#define f(x) x\nvoid g() { while (f(a, b)) { } }\nint f(";
        let found: Vec<&str> = definitions(text, "f").into_iter().map(|range| &text[range]).collect();
        assert_eq!(found, ["f(vec2 a, float b[2])", "f()"]);
        assert!(definitions(text, "h").is_empty());
        assert!(is_built_in("mix") && !is_built_in("mi"));
    }
}
