//! From the scene graph to voxels in world coordinates.

use glam::IVec3;

use super::error::{VoxError, VoxErrorKind};
use super::reader::{Attributes, Node, VoxFile, VoxModel};
use crate::orientation::{Orientation, Placement};

/// Deepest scene graph.
const MAX_DEPTH: usize = 256;
/// Nodes visited, counting a shared one at each visit.
const MAX_VISITS: usize = 1 << 20;
/// Voxels placed, counting those of a shared model at each place.
const MAX_VOXELS: usize = 1 << 26;

/// Number of frames, at least 1.
pub(super) fn frames(file: &VoxFile) -> u32 {
    if file.root.is_none() {
        return u32::try_from(file.models.len().max(1)).unwrap_or(u32::MAX);
    }
    let keys = file.nodes.values().filter_map(|(_, node)| match node {
        Node::Transform { frames, .. } => frames.iter().map(key).max(),
        Node::Shape { models, .. } => models.iter().map(|(_, attributes)| key(attributes)).max(),
        Node::Group { .. } => None,
    });
    keys.max().unwrap_or(0).saturating_add(1)
}

/// Every voxel that is seen in a frame, with its palette index. Of two at one place the later stays.
pub(super) fn voxels(file: &VoxFile, frame: u32) -> Result<Vec<(IVec3, u8)>, VoxError> {
    let mut scene = Scene { file, frame, path: Vec::new(), visits: 0, found: Vec::new() };
    let up = Placement { turn: Orientation::Y_UP_FROM_Z_UP, to: [0; 3] };
    match file.root {
        Some(root) => scene.visit(root, &up, 0)?,
        None => {
            // Files from before the scene graph: a model stands on the ground, about its centre; several are frames.
            if let Some(model) = file.models.get(frame as usize) {
                let lift = Placement { turn: Orientation::IDENTITY, to: [0, 0, i64::from(model.size[2] / 2)] };
                scene.place(model, &up.after(&lift), 0)?;
            }
        }
    }
    Ok(scene.found)
}

struct Scene<'f> {
    file: &'f VoxFile,
    frame: u32,
    /// Ids of the nodes above the one being visited.
    path: Vec<u32>,
    visits: usize,
    found: Vec<(IVec3, u8)>,
}

impl Scene<'_> {
    /// `from` is where a node is named, for the message when there is none.
    fn visit(&mut self, id: u32, placement: &Placement, from: usize) -> Result<(), VoxError> {
        let Some((offset, node)) = self.file.nodes.get(&id) else {
            return Err(VoxError::new(VoxErrorKind::Value, from, format!("there is no node {id}")));
        };
        let offset = *offset;
        if self.path.contains(&id) {
            return Err(VoxError::new(VoxErrorKind::Cycle, offset, format!("node {id} is inside itself")));
        }
        self.visits += 1;
        if self.path.len() >= MAX_DEPTH || self.visits > MAX_VISITS {
            let message = format!("the scene graph is deeper than {MAX_DEPTH} or has more than {MAX_VISITS} nodes");
            return Err(VoxError::new(VoxErrorKind::TooLarge, offset, message));
        }
        self.path.push(id);
        match node {
            Node::Transform { attributes, child, layer, frames } => {
                let layer_hidden = u32::try_from(*layer).is_ok_and(|id| self.file.layers.get(&id).is_some_and(hidden));
                if !hidden(attributes) && !layer_hidden {
                    let own = at_frame(self.frame, frames.iter().map(|frame| (frame, frame)))
                        .map_or(Ok(Placement::IDENTITY), |frame| transform(frame, offset))?;
                    self.visit(*child, &placement.after(&own), offset)?;
                }
            }
            Node::Group { attributes, children } => {
                if !hidden(attributes) {
                    for child in children {
                        self.visit(*child, placement, offset)?;
                    }
                }
            }
            Node::Shape { attributes, models } => {
                if !hidden(attributes)
                    && let Some(id) = at_frame(self.frame, models.iter().map(|(id, attributes)| (attributes, *id)))
                {
                    let Some(model) = self.file.models.get(id as usize) else {
                        let message = format!("there is no model {id} among {}", self.file.models.len());
                        return Err(VoxError::new(VoxErrorKind::Value, offset, message));
                    };
                    self.place(model, placement, offset)?;
                }
            }
        }
        self.path.pop();
        Ok(())
    }

    /// Places a model about its centre, which is the lattice point at half its size, rounded down.
    fn place(&mut self, model: &VoxModel, placement: &Placement, offset: usize) -> Result<(), VoxError> {
        if self.found.len() + model.voxels.len() > MAX_VOXELS {
            let message = format!("the scene places more than {MAX_VOXELS} voxels");
            return Err(VoxError::new(VoxErrorKind::TooLarge, offset, message));
        }
        let centre = model.size.map(|edge| i64::from(edge / 2));
        for &[x, y, z, color] in &model.voxels {
            let local = [x, y, z].map(i64::from);
            let cell = placement.cell(std::array::from_fn(|i| local[i] - centre[i]));
            let [Ok(x), Ok(y), Ok(z)] = cell.map(i32::try_from) else {
                let message = format!("a voxel at {cell:?} (Y up) is outside the world of ±2³¹");
                return Err(VoxError::new(VoxErrorKind::Value, offset, message));
            };
            self.found.push((IVec3::new(x, y, z), color));
        }
        Ok(())
    }
}

fn hidden(attributes: &Attributes) -> bool {
    attributes.get("_hidden").is_some_and(|value| value == "1")
}

/// The first frame that the attributes hold for.
fn key(attributes: &Attributes) -> u32 {
    attributes.get("_f").and_then(|f| f.trim().parse().ok()).unwrap_or(0)
}

/// The value in a frame: that of the last key up to it, or of the first key if all come later; the first of several.
fn at_frame<'a, T>(frame: u32, keys: impl Iterator<Item = (&'a Attributes, T)>) -> Option<T> {
    let order = |attributes| match key(attributes) {
        key if key <= frame => (false, frame - key),
        key => (true, key),
    };
    keys.min_by_key(|(attributes, _)| order(attributes)).map(|(_, value)| value)
}

fn transform(frame: &Attributes, offset: usize) -> Result<Placement, VoxError> {
    let wrong = |key: &str, value: &str, what: &str| {
        VoxError::new(VoxErrorKind::Value, offset, format!("`{key}` is `{}`: {what}", value.escape_debug()))
    };
    let turn = match frame.get("_r") {
        None => Orientation::IDENTITY,
        Some(text) => (text.trim().parse::<u8>().ok())
            .and_then(Orientation::from_vox)
            .ok_or_else(|| wrong("_r", text, "not one of the 48 rotations"))?,
    };
    let to = match frame.get("_t") {
        None => [0; 3],
        Some(text) => {
            let numbers: Option<Vec<i64>> =
                text.split_whitespace().map(|n| n.parse::<i32>().ok().map(i64::from)).collect();
            numbers
                .and_then(|numbers| <[i64; 3]>::try_from(numbers).ok())
                .ok_or_else(|| wrong("_t", text, "not three 32-bit integers"))?
        }
    };
    Ok(Placement { turn, to })
}
