//! The bytes of a buffer as rows, by the struct that a shader declares for them.

use raxel_graph::checked::{Graph, ResourceKind};
use raxel_shader::interface::{BindingKind, Block, Scalar, Type};

/// The most columns of a table: the rest of a struct is left out.
const COLUMNS: usize = 64;

/// How a buffer is divided into elements, and these into scalars.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Elements {
    /// Offset of the first element.
    first: u64,
    /// Bytes from one element to the next.
    stride: u64,
    columns: Vec<Column>,
    /// Columns before the first element.
    head: Vec<Column>,
}

#[derive(Clone, Debug, PartialEq)]
struct Column {
    name: String,
    scalar: Scalar,
    offset: u64,
}

impl Elements {
    /// Of a buffer: as the first shader that binds it declares it, else by the words of its element.
    pub(crate) fn of(graph: &Graph, resource: &str) -> Option<Elements> {
        let id = graph.find_resource(resource)?;
        let ResourceKind::Buffer(buffer) = &graph.resource(id).kind else { return None };
        let declared = graph.passes.iter().find_map(|pass| {
            let access = pass.accesses.iter().find(|access| access.resource == id)?;
            match &pass.shader.interface.bindings.get(access.binding? as usize)?.kind {
                BindingKind::StorageBuffer(block) => Elements::of_block(block),
                _ => None,
            }
        });
        Some(declared.unwrap_or_else(|| Elements::of_words(buffer.size.stride().unwrap_or(4))))
    }

    fn of_block(block: &Block) -> Option<Elements> {
        let (last, others) = block.members.split_last()?;
        let mut head = Vec::new();
        let mut columns = Vec::new();
        let (first, stride) = if let Type::Array { element, len: None, stride } = &last.ty {
            others.iter().for_each(|member| flatten(&member.name, &member.ty, member.offset.into(), &mut head));
            flatten("", element, 0, &mut columns);
            (u64::from(last.offset), u64::from(*stride))
        } else {
            block.members.iter().for_each(|m| flatten(&m.name, &m.ty, m.offset.into(), &mut columns));
            (0, u64::from(block.size))
        };
        (stride > 0 && !columns.is_empty()).then_some(Elements { first, stride, columns, head })
    }

    pub(super) fn of_words(stride: u32) -> Elements {
        let words = (stride / 4).max(1);
        let column = |word: u32| Column { name: format!("[{word}]"), scalar: Scalar::U32, offset: u64::from(word) * 4 };
        let columns = (0..words).take(COLUMNS).map(column).collect();
        Elements { first: 0, stride: u64::from(stride.max(4)), columns, head: Vec::new() }
    }

    /// Byte offset of an element.
    pub(crate) fn offset(&self, element: u64) -> u64 {
        self.first.saturating_add(element.saturating_mul(self.stride))
    }

    /// Whole elements of a buffer of `bytes` bytes.
    pub(crate) fn count(&self, bytes: u64) -> u64 {
        bytes.saturating_sub(self.first) / self.stride
    }

    /// Name and type of each column.
    pub(crate) fn names(&self) -> Vec<String> {
        self.columns.iter().map(Column::title).collect()
    }

    /// The values of an element, where `bytes` begin at offset `start` of the buffer. A missing value is left empty.
    pub(crate) fn row(&self, bytes: &[u8], start: u64, element: u64) -> Vec<String> {
        let at = self.offset(element);
        self.columns.iter().map(|column| column.value(bytes, start, at).unwrap_or_default()).collect()
    }

    /// Names and values of the columns before the first element, as far as they are there.
    pub(crate) fn head(&self, bytes: &[u8], start: u64) -> Vec<[String; 2]> {
        self.head.iter().filter_map(|column| Some([column.title(), column.value(bytes, start, 0)?])).collect()
    }
}

impl Column {
    fn title(&self) -> String {
        let ty = format!("{:?}", self.scalar).to_lowercase();
        if self.name.is_empty() { ty } else { format!("{} {ty}", self.name) }
    }

    /// The value, in a struct at offset `at` of the buffer.
    #[expect(clippy::cast_possible_truncation, reason = "the word has as many bits as the scalar")]
    fn value(&self, bytes: &[u8], start: u64, at: u64) -> Option<String> {
        let from = usize::try_from((at + self.offset).checked_sub(start)?).ok()?;
        let part = bytes.get(from..from.checked_add(self.scalar.size() as usize)?)?;
        let mut word = [0; 8];
        word[..part.len()].copy_from_slice(part);
        let word = u64::from_le_bytes(word);
        Some(match self.scalar {
            Scalar::Bool => (word != 0).to_string(),
            Scalar::I8 => (word as i8).to_string(),
            Scalar::I16 => (word as i16).to_string(),
            Scalar::I32 => (word as i32).to_string(),
            Scalar::I64 => word.cast_signed().to_string(),
            Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => word.to_string(),
            Scalar::F32 => f32::from_bits(word as u32).to_string(),
            Scalar::F64 => f64::from_bits(word).to_string(),
            Scalar::F16 => format!("0x{word:04x}"),
            Scalar::Address => format!("0x{word:x}"),
        })
    }
}

/// The scalars of a type, with the path that leads to each.
#[expect(clippy::cast_possible_truncation, reason = "`COLUMNS` is small")]
fn flatten(path: &str, ty: &Type, offset: u64, columns: &mut Vec<Column>) {
    if columns.len() >= COLUMNS {
        return;
    }
    let mut scalar = |name: String, scalar: Scalar, offset: u64| {
        if columns.len() < COLUMNS {
            columns.push(Column { name, scalar, offset });
        }
    };
    let component = |index: u32| ["x", "y", "z", "w"][index as usize % 4];
    let dotted = |last: &str| if path.is_empty() { last.to_owned() } else { format!("{path}.{last}") };
    match ty {
        Type::Scalar(kind) => scalar(path.to_owned(), *kind, offset),
        Type::Vector(kind, count) => {
            for index in 0..*count {
                scalar(dotted(component(index)), *kind, offset + u64::from(index * kind.size()));
            }
        }
        Type::Matrix { scalar: kind, columns: across, rows, stride, row_major } => {
            for column in 0..*across {
                for row in 0..*rows {
                    let (major, minor) = if *row_major { (row, column) } else { (column, row) };
                    let at = offset + u64::from(major * stride + minor * kind.size());
                    scalar(format!("{path}[{column}].{}", component(row)), *kind, at);
                }
            }
        }
        Type::Array { element, len, stride } => {
            for index in 0..len.unwrap_or(0).min(COLUMNS as u32) {
                flatten(&format!("{path}[{index}]"), element, offset + u64::from(index) * u64::from(*stride), columns);
            }
        }
        Type::Struct(block) => {
            for member in &block.members {
                flatten(&dotted(&member.name), &member.ty, offset + u64::from(member.offset), columns);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use raxel_shader::interface::Member;

    use super::*;

    fn member(name: &str, offset: u32, ty: Type) -> Member {
        Member { name: name.to_owned(), offset, ty, place: None }
    }

    #[test]
    fn a_struct_of_a_shader_gives_the_columns() {
        let ray = Block {
            name: "Ray".to_owned(),
            size: 32,
            members: vec![
                member("origin", 0, Type::Vector(Scalar::F32, 3)),
                member("hits", 12, Type::Scalar(Scalar::U32)),
                member(
                    "ids",
                    16,
                    Type::Array { element: Box::new(Type::Scalar(Scalar::I32)), len: Some(2), stride: 4 },
                ),
            ],
        };
        let rays = Type::Array { element: Box::new(Type::Struct(ray)), len: None, stride: 32 };
        let block = Block {
            name: "Queue".to_owned(),
            size: 16,
            members: vec![member("count", 0, Type::Scalar(Scalar::U32)), member("rays", 16, rays)],
        };
        let elements = Elements::of_block(&block).unwrap();
        let names = ["origin.x f32", "origin.y f32", "origin.z f32", "hits u32", "ids[0] i32", "ids[1] i32"];
        assert_eq!(elements.names(), names);
        let mut bytes = vec![0; 16 + 2 * 32];
        bytes[0] = 2;
        bytes[48..52].copy_from_slice(&1.5_f32.to_le_bytes());
        bytes[60..64].copy_from_slice(&7_u32.to_le_bytes());
        bytes[64..68].copy_from_slice(&(-3_i32).to_le_bytes());
        assert_eq!((elements.count(80), elements.count(79), elements.count(3)), (2, 1, 0));
        assert_eq!(elements.row(&bytes, 0, 1), ["1.5", "0", "0", "7", "-3", "0"]);
        assert_eq!(elements.head(&bytes, 0), [["count u32".to_owned(), "2".to_owned()]]);
        // A part that begins later has the row, and not the head; a row that is not there is empty.
        assert_eq!(elements.row(&bytes[48..], 48, 1)[3], "7");
        assert!(elements.head(&bytes[48..], 48).is_empty() && elements.row(&bytes[48..], 48, 0)[0].is_empty());
    }

    #[test]
    fn without_a_declaration_words_are_shown() {
        let elements = Elements::of_words(8);
        assert_eq!(elements.row(&[1, 0, 0, 0, 2, 0, 0, 0], 0, 0), ["1", "2"]);
        assert_eq!(Elements::of_words(4096).names().len(), COLUMNS);
    }
}
