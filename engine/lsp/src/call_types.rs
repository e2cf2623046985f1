//! The type of a call of a function of GLSL. One declaration in `builtins.txt` stands for many: its `T`, `I`, `B`, `mat` and `g` follow the arguments.

use super::builtins::Builtin;
use super::glsl_types::Numeric;

/// The type of a call with arguments of these types. `None` where the arguments fit no declaration, or too few of them are known.
pub(super) fn result(builtin: &Builtin, arguments: &[Option<String>]) -> Option<String> {
    let all = || builtin.declarations.lines().filter_map(Declaration::of);
    let of_so_many = || all().filter(|declared| declared.parameters.len() == arguments.len());
    let first = |converts: bool| of_so_many().find_map(|declared| declared.result(builtin.name, arguments, converts));
    // Arguments may be left out behind the one that decides.
    let of_opaque = || all().find_map(|declared| declared.of_opaque(arguments));
    first(false).or_else(|| first(true)).or_else(of_opaque)
}

/// Whether the type of a call follows its arguments.
pub(super) fn is_generic(builtin: &Builtin) -> bool {
    let is_type = |ty: &str| matches!(ty, "T" | "I" | "B" | "mat" | "ivec" | "gvec4");
    builtin.declarations.lines().filter_map(Declaration::of).any(|declared| is_type(declared.result))
}

/// An argument is of another kind than its parameter.
struct Misfit;

/// A line of declarations.
struct Declaration<'d> {
    result: &'d str,
    /// The types of the parameters.
    parameters: Vec<&'d str>,
}

impl<'d> Declaration<'d> {
    fn of(line: &'d str) -> Option<Self> {
        let (head, rest) = line.split_once('(')?;
        let parameters = rest.trim_end_matches(')').split(',').filter(|part| !part.trim().is_empty());
        let ty =
            |part: &'d str| part.trim().rsplit_once(' ').map_or(part, |(ty, _)| ty.rsplit(' ').next().unwrap_or(ty));
        Some(Self { result: head.split(' ').next()?, parameters: parameters.map(ty).collect() })
    }

    /// The result for these arguments. With `converts`, integers do for floats.
    fn result(&self, name: &str, arguments: &[Option<String>], converts: bool) -> Option<String> {
        if self.result == "mat" {
            // The sides of a matrix may come from vectors of two sizes.
            return of_matrices(name, arguments).map(Numeric::name);
        }
        // Arguments that do not fit refuse the declaration, whatever its result is.
        let floats = self.common("T", arguments, |ty| converts || ty.is_float()).ok()?;
        let integers = self.common("I", arguments, |ty| !ty.is_float() && !ty.is_bool()).ok()?;
        let truths = self.common("B", arguments, Numeric::is_bool).ok()?;
        let ty = match self.result {
            "T" => floats.or(integers).map(|ty| if ty.is_float() { ty } else { ty.of("float") }),
            "I" => match name {
                "floatBitsToInt" | "bitCount" | "findLSB" | "findMSB" => Some(floats.or(integers)?.of("int")),
                "floatBitsToUint" => Some(floats?.of("uint")),
                _ => integers,
            },
            "B" => Some(floats.or(truths)?.of("bool")),
            "gvec4" | "ivec" => return self.of_opaque(arguments),
            concrete => return Some(concrete.to_owned()),
        };
        ty.map(Numeric::name)
    }

    /// The type that the arguments of all parameters of one letter have in common, if one of them is known.
    fn common(
        &self,
        letter: &str,
        arguments: &[Option<String>],
        fits: impl Fn(Numeric) -> bool,
    ) -> Result<Option<Numeric>, Misfit> {
        let mut common: Option<Numeric> = None;
        let mut is_unknown = false;
        for (_, argument) in self.parameters.iter().zip(arguments).filter(|(ty, _)| **ty == letter) {
            let Some(argument) = argument else {
                is_unknown = true;
                continue;
            };
            let ty = Numeric::named(argument).filter(|ty| !ty.is_matrix() && fits(*ty)).ok_or(Misfit)?;
            common = Some(common.map_or(Some(ty), |known| known.each_with(ty)).ok_or(Misfit)?);
        }
        // A number may stand beside a vector that is not known.
        Ok(common.filter(|ty| !is_unknown || ty.vector_size().is_some()))
    }

    /// The result that follows a texture or an image, which is the first argument.
    fn of_opaque(&self, arguments: &[Option<String>]) -> Option<String> {
        let ty = arguments.first()?.as_deref()?;
        let kind = ["sampler", "image"].into_iter().find_map(|kind| ty.split_once(kind))?;
        let (prefix, shape) = kind;
        match self.result {
            "gvec4" if shape.ends_with("Shadow") => Some("float".to_owned()),
            "gvec4" => Some(format!("{prefix}vec4")),
            "ivec" => {
                let of_shape = [("1D", 1), ("2D", 2), ("3D", 3), ("Cube", 2), ("Buffer", 1)];
                let (_, axes) = of_shape.into_iter().find(|(name, _)| shape.starts_with(name))?;
                let axes = axes + usize::from(shape.contains("Array"));
                Some(Numeric::named("int")?.with_rows(axes).name())
            }
            _ => None,
        }
    }
}

/// The result of a function of matrices.
fn of_matrices(name: &str, arguments: &[Option<String>]) -> Option<Numeric> {
    let argument = |at: usize| Numeric::named(arguments.get(at)?.as_deref()?);
    let first = argument(0)?;
    match name {
        "outerProduct" => Some(first.outer_product(argument(1)?)),
        "transpose" => Some(first.transposed()),
        _ => Some(first),
    }
}

#[cfg(test)]
mod tests {
    use super::super::builtins::named;
    use super::*;

    #[test]
    fn a_call_has_the_type_of_its_arguments() {
        let of = |name: &str, arguments: &[&str]| {
            let known = |ty: &&str| (*ty != "?").then(|| (*ty).to_owned());
            result(&named(name).unwrap(), &arguments.iter().map(known).collect::<Vec<_>>())
        };
        for (name, arguments, ty) in [
            ("mix", &["vec3", "vec3", "float"] as &[&str], Some("vec3")),
            ("mix", &["vec2", "vec2", "bvec2"], Some("vec2")),
            ("mix", &["ivec2", "ivec2", "bvec2"], Some("ivec2")),
            ("mix", &["?", "vec3", "float"], Some("vec3")),
            ("mix", &["float", "?", "float"], None),
            ("mix", &["vec2", "vec3", "float"], None),
            ("max", &["int", "uint"], Some("uint")),
            ("max", &["vec3", "int"], Some("vec3")),
            ("max", &["RxHit", "int"], None),
            ("clamp", &["dvec2", "double", "double"], Some("dvec2")),
            ("abs", &["ivec3"], Some("ivec3")),
            ("floor", &["int"], Some("float")),
            ("atan", &["float", "float"], Some("float")),
            ("length", &["vec3"], Some("float")),
            ("cross", &["?", "?"], Some("vec3")),
            ("floatBitsToUint", &["vec2"], Some("uvec2")),
            ("intBitsToFloat", &["ivec3"], Some("vec3")),
            ("bitCount", &["uvec4"], Some("ivec4")),
            ("uaddCarry", &["uvec2", "uvec2", "uvec2"], Some("uvec2")),
            ("lessThan", &["ivec3", "ivec3"], Some("bvec3")),
            ("not", &["bvec2"], Some("bvec2")),
            ("isnan", &["float"], Some("bool")),
            ("transpose", &["mat2x3"], Some("mat3x2")),
            ("outerProduct", &["vec3", "vec2"], Some("mat2x3")),
            ("inverse", &["mat4"], Some("mat4")),
            ("texture", &["usampler3D", "vec3"], Some("uvec4")),
            ("texture", &["sampler2D", "vec2", "float"], Some("vec4")),
            ("texelFetch", &["isampler2D", "ivec2", "int"], Some("ivec4")),
            ("textureSize", &["sampler2DArray", "int"], Some("ivec3")),
            ("imageSize", &["uimage2D"], Some("ivec2")),
            ("imageLoad", &["image3D", "ivec3"], Some("vec4")),
            ("imageAtomicAdd", &["uimage2D", "ivec2", "uint"], Some("uint")),
            ("texture", &["vec3", "vec3"], None),
            ("mix", &[], None),
        ] {
            assert_eq!(of(name, arguments).as_deref(), ty, "{name}({arguments:?})");
        }
        assert!(is_generic(&named("mix").unwrap()) && !is_generic(&named("length").unwrap()));
    }
}
