//! The types of GLSL that have arithmetic: numbers, vectors and matrices.

/// A type of numbers.
struct Component {
    name: &'static str,
    /// `i` of `ivec3`.
    prefix: &'static str,
    /// The names with their size, of the component and of vectors.
    sized: [&'static str; 2],
}

/// In the order of their implicit conversions: in an expression of two types, the later one wins (GLSL 4.60, 4.1.10).
const COMPONENTS: [Component; 12] = [
    component("bool", "b", ["", ""]),
    component("int8_t", "i8", ["", ""]),
    component("uint8_t", "u8", ["", ""]),
    component("int16_t", "i16", ["", ""]),
    component("uint16_t", "u16", ["", ""]),
    component("int", "i", ["int32_t", "i32"]),
    component("uint", "u", ["uint32_t", "u32"]),
    component("int64_t", "i64", ["", ""]),
    component("uint64_t", "u64", ["", ""]),
    component("float16_t", "f16", ["", ""]),
    component("float", "", ["float32_t", "f32"]),
    component("double", "d", ["float64_t", "f64"]),
];

const fn component(name: &'static str, prefix: &'static str, sized: [&'static str; 2]) -> Component {
    Component { name, prefix, sized }
}

/// A number, a vector or a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Numeric {
    /// Index in [`COMPONENTS`].
    component: usize,
    /// More than 1 of a matrix only.
    columns: usize,
    /// Components of a column; 1 of a number.
    rows: usize,
}

impl Numeric {
    /// The type of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let known = |is: &dyn Fn(&Component) -> bool| COMPONENTS.iter().position(is);
        if name.is_empty() {
            return None;
        }
        if let Some(component) = known(&|known| known.name == name || known.sized[0] == name) {
            return Some(Self { component, columns: 1, rows: 1 });
        }
        if let Some((prefix, size)) = name.split_once("vec") {
            let is_it = |known: &Component| known.prefix == prefix || !prefix.is_empty() && known.sized[1] == prefix;
            return Some(Self { component: known(&is_it)?, columns: 1, rows: side(size)? });
        }
        let (prefix, size) = name.split_once("mat").filter(|(prefix, _)| matches!(*prefix, "" | "d" | "f16"))?;
        let (columns, rows) = size.split_once('x').unwrap_or((size, size));
        let component = known(&|known| known.prefix == prefix)?;
        Some(Self { component, columns: side(columns)?, rows: side(rows)? })
    }

    /// A number of the type with this name.
    fn number(name: &str) -> Self {
        let component = COMPONENTS.iter().position(|known| known.name == name).unwrap_or_default();
        Self { component, columns: 1, rows: 1 }
    }

    /// Its name.
    pub(crate) fn name(self) -> String {
        let Component { name, prefix, .. } = &COMPONENTS[self.component];
        match (self.columns, self.rows) {
            (1, 1) => (*name).to_owned(),
            (1, rows) => format!("{prefix}vec{rows}"),
            (columns, rows) if columns == rows => format!("{prefix}mat{rows}"),
            (columns, rows) => format!("{prefix}mat{columns}x{rows}"),
        }
    }

    /// Number of components of a vector.
    pub(crate) fn vector_size(self) -> Option<usize> {
        (self.columns == 1 && self.rows > 1).then_some(self.rows)
    }

    pub(crate) fn is_matrix(self) -> bool {
        self.columns > 1
    }

    pub(crate) fn is_bool(self) -> bool {
        self.component == 0
    }

    /// Whether its components are `float`, `double` or `float16_t`.
    pub(crate) fn is_float(self) -> bool {
        matches!(COMPONENTS[self.component].name, "float" | "double" | "float16_t")
    }

    /// A type as large with other components.
    pub(crate) fn of(self, component: &str) -> Self {
        Self { component: Self::number(component).component, ..self }
    }

    /// A vector of that many such components, or one of them.
    pub(crate) fn with_rows(self, rows: usize) -> Self {
        Self { columns: 1, rows, ..self }
    }

    /// What an index leaves: of a matrix a column, of a vector a component.
    pub(crate) fn element(self) -> Option<Self> {
        match (self.columns, self.rows) {
            (1, 1) => None,
            (1, _) => Some(Self { rows: 1, ..self }),
            _ => Some(Self { columns: 1, ..self }),
        }
    }

    pub(crate) fn transposed(self) -> Self {
        Self { columns: self.rows, rows: self.columns, ..self }
    }

    /// The matrix of a column by a row.
    pub(crate) fn outer_product(self, row: Self) -> Self {
        Self { component: self.component.max(row.component), columns: row.rows, rows: self.rows }
    }

    /// The type of an operator that works on each component, as `+` does: one of both may be a number.
    pub(crate) fn each_with(self, other: Self) -> Option<Self> {
        let component = self.component.max(other.component);
        let is_number = |ty: Self| ty.columns == 1 && ty.rows == 1;
        let larger = if is_number(self) { other } else { self };
        let alike = (self.columns, self.rows) == (other.columns, other.rows);
        (alike || is_number(self) || is_number(other)).then_some(Self { component, ..larger })
    }

    /// The type of a product, which is that of linear algebra where a matrix is among the two (GLSL 4.60, 5.9).
    pub(crate) fn times(self, other: Self) -> Option<Self> {
        let component = self.component.max(other.component);
        match (self.columns > 1, other.columns > 1) {
            (true, true) => {
                (self.columns == other.rows).then_some(Self { component, columns: other.columns, rows: self.rows })
            }
            (true, false) if other.rows > 1 => {
                (self.columns == other.rows).then_some(Self { component, columns: 1, rows: self.rows })
            }
            (false, true) if self.rows > 1 => {
                (self.rows == other.rows).then_some(Self { component, columns: 1, rows: other.columns })
            }
            _ => self.each_with(other),
        }
    }
}

/// A side of a vector or a matrix.
fn side(text: &str) -> Option<usize> {
    ["2", "3", "4"].iter().position(|known| *known == text).map(|at| at + 2)
}

/// The type of an element: of an array, of a matrix its column, of a vector its component.
pub(super) fn element(ty: &str) -> Option<String> {
    if let Some(open) = ty.find('[').filter(|_| ty.ends_with(']')) {
        // The first length is that of the outermost array.
        let close = open + ty[open..].find(']')?;
        return Some(format!("{}{}", ty[..open].trim_end(), ty[close + 1..].trim()));
    }
    Some(Numeric::named(ty)?.element()?.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_known_by_their_names() {
        for name in
            ["bool", "float", "uvec2", "bvec4", "mat3", "mat2x4", "dmat4x3", "f16vec3", "f16mat2", "u64vec2", "int8_t"]
        {
            assert_eq!(Numeric::named(name).map(Numeric::name).as_deref(), Some(name));
        }
        for (name, plain) in [("f32vec3", "vec3"), ("i32vec2", "ivec2"), ("float64_t", "double"), ("mat3x3", "mat3")] {
            assert_eq!(Numeric::named(name).map(Numeric::name).as_deref(), Some(plain));
        }
        for name in ["", "vec", "vec5", "mat5", "imat2", "avec3", "sampler2D", "vec3[2]", "mat2x", "RxHit"] {
            assert_eq!(Numeric::named(name), None, "{name}");
        }
    }

    #[test]
    fn elements_have_the_type_that_an_index_leaves() {
        for (ty, left) in [
            ("vec3[2][N]", Some("vec3[N]")),
            ("vec3[2]", Some("vec3")),
            ("mat4", Some("vec4")),
            ("mat2x3", Some("vec3")),
            ("ivec2", Some("int")),
            ("float", None),
            ("RxHit", None),
        ] {
            assert_eq!(element(ty).as_deref(), left, "{ty}");
        }
    }

    #[test]
    fn products_are_those_of_linear_algebra() {
        let of = |left: &str, right: &str| {
            let (left, right) = (Numeric::named(left).unwrap(), Numeric::named(right).unwrap());
            left.times(right).map(Numeric::name)
        };
        for (left, right, product) in [
            ("float", "vec3", Some("vec3")),
            ("ivec2", "float", Some("vec2")),
            ("mat4x3", "vec4", Some("vec3")),
            ("vec3", "mat4x3", Some("vec4")),
            ("mat2x3", "mat4x2", Some("mat4x3")),
            ("mat3", "double", Some("dmat3")),
            ("vec2", "vec3", None),
            ("mat2", "vec3", None),
        ] {
            assert_eq!(of(left, right).as_deref(), product, "{left} * {right}");
        }
    }
}
