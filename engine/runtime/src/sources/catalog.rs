//! What the graph compiler is told of the sources: which there are, and what a shader must declare for each.

use raxel_graph::SourceLayout;
use raxel_shader::format::Format;
use raxel_shader::interface::{Block, Member, Scalar, Type};
use raxel_world::layout::{BlockMember, Layout};

use super::SourceName;

/// The texels of a layout's image.
pub const VOXEL_FORMAT: Format = Format::R16ui;

/// Every layout of the session's world.
pub fn catalog() -> Vec<SourceLayout> {
    Layout::ALL.iter().map(|layout| described(&SourceName::World(*layout), *layout)).collect()
}

/// A source that is a world, or a part of one, in a layout.
fn described(name: &SourceName, layout: Layout) -> SourceLayout {
    SourceLayout {
        name: name.to_string(),
        block: block(&layout.block()),
        image: layout.has_image().then_some(VOXEL_FORMAT),
    }
}

fn block(members: &[BlockMember]) -> Block {
    let sized_end = |member: &BlockMember| match member.stride {
        Some(_) => member.offset,
        None => member.offset + if member.ty == "ivec3" { 12 } else { 4 },
    };
    Block {
        name: "RxWorld".to_owned(),
        size: members.iter().map(sized_end).max().unwrap_or(0),
        members: members
            .iter()
            .map(|member| {
                let element = match member.ty {
                    "ivec3" => Type::Vector(Scalar::I32, 3),
                    "uvec4" => Type::Vector(Scalar::U32, 4),
                    _ => Type::Scalar(Scalar::U32),
                };
                Member {
                    name: member.name.to_owned(),
                    offset: member.offset,
                    ty: match member.stride {
                        Some(stride) => Type::Array { element: Box::new(element), len: None, stride },
                        None => element,
                    },
                    place: None,
                }
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layout_is_offered_with_its_runtime_array() {
        let sources = catalog();
        let names: Vec<String> = Layout::ALL.iter().map(|layout| format!("world.{}", layout.name())).collect();
        assert_eq!(sources.iter().map(|source| &source.name).collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
        for source in sources {
            let last = source.block.members.last().unwrap();
            assert!(matches!(last.ty, Type::Array { len: None, stride: 4 | 16, .. }), "{last:?}");
            assert_eq!(source.block.size, last.offset);
        }
    }
}
