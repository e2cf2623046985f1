//! Describes the sources to the graph compiler: their names, and the declarations that shaders need for each.

use std::sync::Arc;

use raxel_diagnostics::Files;
use raxel_edit::records;
use raxel_graph::{Catalog, FileContents, ImageRequest, Refusal, SourceLayout};
use raxel_layouts::BlockMember;
use raxel_layouts::instances::{InstanceBuffer, records as poses};
use raxel_media::FileSources;
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Block, Member, Scalar, Type};

use super::SourceName;

/// The name under which graphs declare their edits of the world.
pub(crate) const EDITS: &str = "world.edits";

/// The name under which graphs declare where their passes put instances.
pub(crate) const POSES: &str = "world.poses";

/// The texels of a layout's image.
pub const VOXEL_FORMAT: Format = Format::R16ui;

/// The sources of a project: every layout of the session's world, its lights and instances, models in every layout, and the project's files.
pub struct SourceCatalog {
    worlds: Vec<SourceLayout>,
    files: Arc<dyn Files>,
    read: FileSources,
}

impl SourceCatalog {
    /// Reads files by `files`.
    pub fn new(files: Arc<dyn Files>) -> Self {
        let layouts = raxel_rivals::LAYOUTS.iter().map(|layout| SourceName::World(*layout));
        let named = layouts.chain([SourceName::Lights, SourceName::Instances, SourceName::Keys]);
        let worlds = named.map(|name| described(&name)).chain([edits(), self::poses()]).collect();
        Self { worlds, files, read: FileSources::default() }
    }
}

impl Catalog for SourceCatalog {
    fn sources(&self) -> &[SourceLayout] {
        &self.worlds
    }

    fn source(&self, name: &str) -> Option<SourceLayout> {
        match name {
            EDITS => Some(edits()),
            POSES => Some(self::poses()),
            name => SourceName::parse(name).map(|name| described(&name)),
        }
    }

    fn file(&self, path: &str, image: Option<&ImageRequest>) -> Result<Arc<FileContents>, Refusal> {
        self.read.read(&*self.files, path, image)
    }

    fn microphone(&self, image: &ImageRequest) -> Result<Arc<FileContents>, Refusal> {
        self.read.microphone(image)
    }
}

fn described(name: &SourceName) -> SourceLayout {
    let layout = name.layout();
    SourceLayout {
        name: name.to_string(),
        block: match (name, layout) {
            (_, Some(layout)) => block("RxWorld", &layout.block()),
            (SourceName::Instances, None) => block("RxInstances", &InstanceBuffer::block()),
            (SourceName::Keys, None) => {
                block("RxKeys", &[BlockMember { name: "words", offset: 0, ty: "uint", stride: Some(4) }])
            }
            (_, None) => block("RxLights", &raxel_layouts::lights::block()),
        },
        image: layout.filter(|layout| layout.has_image()).map(|_| VOXEL_FORMAT),
        access: Access::Read,
        collected: None,
    }
}

/// Records of passes that edit the world.
fn edits() -> SourceLayout {
    written(EDITS, "RxEdits", records::HEADER_WORDS, records::BYTES)
}

/// Records of passes that move instances.
fn poses() -> SourceLayout {
    written(POSES, "RxPoses", poses::HEADER_WORDS, poses::BYTES)
}

/// A count, and records behind a header.
#[expect(clippy::cast_possible_truncation, reason = "a header has a few words")]
fn written(name: &str, of_block: &str, header_words: usize, bytes: u64) -> SourceLayout {
    let member = |name, offset, stride| BlockMember { name, offset, ty: "uint", stride };
    let members = [
        member("count", 0, None),
        member("unused0", 4, None),
        member("unused1", 8, None),
        member("unused2", 12, None),
        member("records", 4 * header_words as u32, Some(4)),
    ];
    SourceLayout {
        name: name.to_owned(),
        block: block(of_block, &members),
        image: None,
        access: Access::ReadWrite,
        collected: Some(bytes),
    }
}

fn block(name: &str, members: &[BlockMember]) -> Block {
    let sized_end = |member: &BlockMember| match member.stride {
        Some(_) => member.offset,
        None => member.offset + if member.ty == "ivec3" { 12 } else { 4 },
    };
    Block {
        name: name.to_owned(),
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
    use raxel_diagnostics::MemoryFiles;

    use super::*;

    #[test]
    fn every_layout_is_offered_with_its_runtime_array() {
        let catalog = SourceCatalog::new(Arc::new(MemoryFiles::default()));
        let sources = catalog.sources();
        let layouts = raxel_rivals::LAYOUTS.iter().map(|layout| layout.name());
        let of_world = |names: &[&'static str]| names.iter().map(|name| format!("world.{name}")).collect::<Vec<_>>();
        let layouts = of_world(&layouts.chain(["lights", "instances"]).collect::<Vec<_>>());
        let names = [layouts, vec!["input.keys".to_owned()], of_world(&["edits", "poses"])].concat();
        assert_eq!(sources.iter().map(|source| &source.name).collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
        for source in sources {
            let last = source.block.members.last().unwrap();
            assert!(matches!(last.ty, Type::Array { len: None, stride: 4 | 16, .. }), "{last:?}");
            assert_eq!(source.block.size, last.offset);
        }
        let model = catalog.source("model.pine.texture3d").unwrap();
        let texture3d = sources.iter().find(|source| source.name == "world.texture3d").unwrap();
        assert_eq!((model.block, model.image), (texture3d.block.clone(), Some(VOXEL_FORMAT)));
        assert_eq!(catalog.source("model.pine.tree"), None);
    }
}
