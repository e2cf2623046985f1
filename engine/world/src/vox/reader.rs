//! From bytes to chunks. Every length is checked against the available bytes before anything is allocated.

use std::collections::HashMap;

use super::error::{VoxError, VoxErrorKind};

/// Key and value texts of a node, frame, layer or material.
pub(super) type Attributes = HashMap<String, String>;

/// A .vox file as it is written.
#[derive(Debug, Default)]
pub(super) struct VoxFile {
    pub(super) models: Vec<VoxModel>,
    pub(super) nodes: HashMap<u32, (usize, Node)>,
    /// The node that comes first; scenes start there.
    pub(super) root: Option<u32>,
    /// Attributes by layer id.
    pub(super) layers: HashMap<u32, Attributes>,
    /// Colour of palette index `i + 1`, sRGB and alpha.
    pub(super) palette: Option<Vec<[u8; 4]>>,
    /// Material attributes by palette index.
    pub(super) materials: HashMap<u8, Attributes>,
}

/// A model of at most 256³ voxels.
#[derive(Debug)]
pub(super) struct VoxModel {
    /// Voxels along x, y, z.
    pub(super) size: [u32; 3],
    /// x, y, z, palette index (never 0).
    pub(super) voxels: Vec<[u8; 4]>,
}

/// A node of the scene graph.
#[derive(Debug)]
pub(super) enum Node {
    /// Places its child.
    Transform { attributes: Attributes, child: u32, layer: i32, frames: Vec<Attributes> },
    /// Has children.
    Group { attributes: Attributes, children: Vec<u32> },
    /// Shows one model a frame.
    Shape { attributes: Attributes, models: Vec<(u32, Attributes)> },
}

/// Edge of the largest model that MagicaVoxel writes.
const MAX_EDGE: u32 = 256;

/// Reads a whole file.
pub(super) fn read(bytes: &[u8]) -> Result<VoxFile, VoxError> {
    let mut input = Input { bytes, at: 0, end: bytes.len() };
    if bytes.get(..4) != Some(b"VOX ") {
        return Err(input.structure("this is no .vox file: it does not begin with `VOX `"));
    }
    input.at = 4;
    let _version = input.u32("version")?;
    let (id, _, mut children) = input.chunk()?;
    if &id != b"MAIN" {
        return Err(VoxError::new(
            VoxErrorKind::Structure,
            8,
            format!("the first chunk is `{}`, not `MAIN`", text(id)),
        ));
    }
    let mut file = VoxFile::default();
    let mut size = None;
    while !children.is_empty() {
        let start = children.at;
        let (id, mut content, _) = children.chunk()?;
        match &id {
            b"SIZE" => size = Some(read_size(&mut content)?),
            b"XYZI" => {
                let Some(size) = size.take() else {
                    return Err(VoxError::new(VoxErrorKind::Structure, start, "voxels without a `SIZE` before them"));
                };
                file.models.push(VoxModel { size, voxels: read_voxels(&mut content, size)? });
            }
            b"RGBA" => file.palette = Some(read_palette(&mut content)?),
            b"MATL" => {
                let id = content.u32("material id")?;
                let attributes = content.attributes()?;
                // Ids are palette indices; MagicaVoxel also writes 0 or 256 for the index that is never used.
                if let Ok(index) = u8::try_from(id) {
                    file.materials.insert(index, attributes);
                } else if id > 256 {
                    return Err(VoxError::new(VoxErrorKind::Value, start, format!("material {id} is none of 256")));
                }
            }
            b"LAYR" => {
                let id = content.u32("layer id")?;
                file.layers.insert(id, content.attributes()?);
            }
            b"nTRN" | b"nGRP" | b"nSHP" => {
                let (node_id, node) = read_node(id, &mut content)?;
                file.root.get_or_insert(node_id);
                if file.nodes.insert(node_id, (start, node)).is_some() {
                    return Err(VoxError::new(VoxErrorKind::Value, start, format!("there are two nodes {node_id}")));
                }
            }
            // PACK counts the models of an animation, which are there anyway; IMAP only orders the palette's window; cameras, notes and render settings
            // show no voxel.
            _ => {}
        }
    }
    Ok(file)
}

fn read_size(content: &mut Input<'_>) -> Result<[u32; 3], VoxError> {
    let at = content.at;
    let size = [content.u32("size")?, content.u32("size")?, content.u32("size")?];
    if size.iter().any(|edge| !(1..=MAX_EDGE).contains(edge)) {
        let [x, y, z] = size;
        return Err(VoxError::new(
            VoxErrorKind::Value,
            at,
            format!("a model of {x} × {y} × {z} voxels; each must be in 1…{MAX_EDGE}"),
        ));
    }
    Ok(size)
}

fn read_voxels(content: &mut Input<'_>, size: [u32; 3]) -> Result<Vec<[u8; 4]>, VoxError> {
    let count = content.u32("number of voxels")?;
    let at = content.at;
    let bytes = content.take(u64::from(count) * 4, "voxels")?;
    let mut voxels = Vec::with_capacity(count as usize);
    for (n, voxel) in bytes.chunks_exact(4).enumerate() {
        let voxel = [voxel[0], voxel[1], voxel[2], voxel[3]];
        if (0..3).any(|i| u32::from(voxel[i]) >= size[i]) {
            let [x, y, z, _] = voxel;
            let message =
                format!("voxel ({x}, {y}, {z}) is outside its model of {} × {} × {}", size[0], size[1], size[2]);
            return Err(VoxError::new(VoxErrorKind::Value, at + 4 * n, message));
        }
        // Palette index 0 is empty space.
        if voxel[3] != 0 {
            voxels.push(voxel);
        }
    }
    Ok(voxels)
}

fn read_palette(content: &mut Input<'_>) -> Result<Vec<[u8; 4]>, VoxError> {
    let bytes = content.take(1024, "palette")?;
    Ok(bytes.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect())
}

fn read_node(id: [u8; 4], content: &mut Input<'_>) -> Result<(u32, Node), VoxError> {
    let node_id = content.u32("node id")?;
    let attributes = content.attributes()?;
    let node = match &id {
        b"nTRN" => {
            let child = content.u32("child node")?;
            let _reserved = content.u32("reserved id")?;
            let layer = content.u32("layer id")?.cast_signed();
            let count = content.count("frames", 4)?;
            let frames = (0..count).map(|_| content.attributes()).collect::<Result<_, _>>()?;
            Node::Transform { attributes, child, layer, frames }
        }
        b"nGRP" => {
            let count = content.count("children", 4)?;
            let children = (0..count).map(|_| content.u32("child node")).collect::<Result<_, _>>()?;
            Node::Group { attributes, children }
        }
        _ => {
            let count = content.count("models", 8)?;
            let models =
                (0..count).map(|_| Ok((content.u32("model id")?, content.attributes()?))).collect::<Result<_, _>>()?;
            Node::Shape { attributes, models }
        }
    };
    Ok((node_id, node))
}

fn text(id: [u8; 4]) -> String {
    id.escape_ascii().to_string()
}

/// A part of the file being read.
struct Input<'b> {
    bytes: &'b [u8],
    at: usize,
    end: usize,
}

impl<'b> Input<'b> {
    fn is_empty(&self) -> bool {
        self.at == self.end
    }

    fn structure(&self, message: impl Into<String>) -> VoxError {
        VoxError::new(VoxErrorKind::Structure, self.at, message)
    }

    #[expect(clippy::cast_possible_truncation, reason = "as many bytes are left in memory")]
    fn take(&mut self, count: u64, what: &str) -> Result<&'b [u8], VoxError> {
        let left = (self.end - self.at) as u64;
        if count > left {
            return Err(self.structure(format!("the {what} would take {count} bytes, but {left} are left")));
        }
        let taken = &self.bytes[self.at..][..count as usize];
        self.at += count as usize;
        Ok(taken)
    }

    fn u32(&mut self, what: &str) -> Result<u32, VoxError> {
        let bytes = self.take(4, what)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    /// A number of things of at least `least` bytes each, which can be there.
    fn count(&mut self, what: &str, least: u64) -> Result<u32, VoxError> {
        let count = self.u32(what)?;
        let left = (self.end - self.at) as u64;
        if u64::from(count) * least > left {
            return Err(self.structure(format!("{count} {what} do not fit into the {left} bytes that are left")));
        }
        Ok(count)
    }

    fn string(&mut self) -> Result<String, VoxError> {
        let length = self.u32("length of a text")?;
        let bytes = self.take(u64::from(length), "text")?;
        // Names may be in any encoding; keys and numbers are ASCII.
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    fn attributes(&mut self) -> Result<Attributes, VoxError> {
        let count = self.count("attributes", 8)?;
        (0..count).map(|_| Ok((self.string()?, self.string()?))).collect()
    }

    /// The next chunk: id, content, children.
    fn chunk(&mut self) -> Result<([u8; 4], Input<'b>, Input<'b>), VoxError> {
        let id = self.take(4, "chunk id")?;
        let id = [id[0], id[1], id[2], id[3]];
        let content = self.u32("chunk size")?;
        let children = self.u32("chunk size")?;
        let start = self.at;
        let what = format!("chunk `{}`", text(id));
        self.take(u64::from(content), &what)?;
        let middle = self.at;
        self.take(u64::from(children), &what)?;
        let part = |at, end| Input { bytes: self.bytes, at, end };
        Ok((id, part(start, middle), part(middle, self.at)))
    }
}
