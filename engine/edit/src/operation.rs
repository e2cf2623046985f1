//! Operations of edits: plain data of integers.

use raxel_generate::{Placed, Shape};
use raxel_world::{AIR, Bounds, ChunkPos, MaterialIndex, Mode, Orientation, Placement};
use serde::{Deserialize, Serialize};

use crate::packed::PackedChunk;
use crate::scene::Scene;
use crate::shape::{Ball, Pillar};

/// Fixed-point unit of centres and radii: 1/256 voxel.
pub const UNIT: i64 = STEPS as i64;
const STEPS: u32 = 256;

/// Largest radius, in voxels.
pub const MOST_RADIUS: u32 = 4096;

/// Most chunks that one operation may cover: 32,768 of 64³ voxels, or 8.6·10⁹ voxels.
pub const MOST_CHUNKS: u64 = 1 << 15;

const CELLS: std::ops::RangeInclusive<i64> = -(1 << 31)..=1 << 31;

/// Converts a position from voxels to 1/256 voxel, rounded to nearest. Saturates; NaN becomes 0.
#[expect(clippy::cast_possible_truncation, reason = "a cast of a float saturates, which is what is wanted here")]
pub fn fixed(voxels: f64) -> i64 {
    (voxels * UNIT as f64).round() as i64
}

/// The effect of an operation on the voxels that it covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Brush {
    /// Makes all of them solid, with this material.
    Add(MaterialIndex),
    /// Makes them air.
    Subtract,
    /// Gives the solid ones this material.
    Paint(MaterialIndex),
}

impl Brush {
    pub(crate) fn mode(self) -> Mode {
        match self {
            Self::Add(_) => Mode::Add,
            Self::Subtract => Mode::Subtract,
            Self::Paint(_) => Mode::Paint,
        }
    }

    pub(crate) fn material(self) -> Option<MaterialIndex> {
        match self {
            Self::Add(material) | Self::Paint(material) => Some(material),
            Self::Subtract => None,
        }
    }
}

/// One edit. Materials are palette indices of the [`Scene`]. The order of the variants is part of the format of saves.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Operation {
    /// Sets one voxel. Air empties it.
    Set {
        /// The voxel.
        cell: [i32; 3],
        /// Its new material, or air.
        material: MaterialIndex,
    },
    /// A box of voxels.
    Box {
        /// The voxels of the box.
        bounds: Bounds,
        /// The effect on the voxels.
        brush: Brush,
    },
    /// The voxels whose centres are in a ball.
    Sphere {
        /// Its centre, in 1/256 voxel.
        center: [i64; 3],
        /// Its radius, in 1/256 voxel.
        radius: u32,
        /// The effect on the voxels.
        brush: Brush,
    },
    /// The voxels whose centres are in a cylinder.
    Cylinder {
        /// Axis of the cylinder: 0 for x, 1 for y, 2 for z.
        axis: u8,
        /// Centre of its base, in 1/256 voxel; the component along the axis is rounded down to a voxel boundary.
        base: [i64; 3],
        /// Its radius, in 1/256 voxel.
        radius: u32,
        /// Height in voxels, from base to top.
        height: u32,
        /// The effect on the voxels.
        brush: Brush,
    },
    /// Places a model of the world's file.
    Model {
        /// Its name.
        model: String,
        /// One of the 24 rotations about the lattice point at its origin, as the byte of [`Orientation::from_vox`].
        orientation: u8,
        /// Where the origin of the model goes, in voxels.
        position: [i32; 3],
        /// How the voxels of the model combine with those of the world.
        mode: Mode,
    },
    /// Restores the voxels that the world's file builds in a box.
    Restore {
        /// The voxels of the box.
        bounds: Bounds,
    },
    /// Replaces whole chunks, as undo and redo do. `None` restores the chunk that the world's file builds.
    Put {
        /// The chunks.
        chunks: Vec<(ChunkPos, Option<PackedChunk>)>,
    },
}

/// Why an operation is refused. No voxel has changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// A chunk that it would change is unavailable at the moment.
    #[error("the world is not there: {0}")]
    Unavailable(#[from] raxel_world::Unavailable),
    /// The operation leaves the range of voxel coordinates.
    #[error("the edit reaches from {min:?} to {max:?}; voxel coordinates are −2147483648 … 2147483647")]
    OutOfRange {
        /// Its smallest corner.
        min: [i64; 3],
        /// One past its largest corner.
        max: [i64; 3],
    },
    /// The operation covers no voxel.
    #[error("the edit covers nothing: {what}")]
    Empty {
        /// The fault of its size.
        what: String,
    },
    /// The operation covers too many chunks.
    #[error("the edit reaches over {chunks} chunks of 64³ voxels; one edit may reach over {limit}")]
    TooLarge {
        /// Number of chunks that it covers.
        chunks: u128,
        /// Most chunks allowed.
        limit: u64,
    },
    /// The radius is too large.
    #[error("the edit has a radius of {radius} voxels; {limit} is the largest")]
    Radius {
        /// The radius, in voxels.
        radius: u32,
        /// The largest.
        limit: u32,
    },
    /// The world does not have this material.
    #[error("the edit uses material {material}; the world has {materials}, numbered from 0 (air)")]
    UnknownMaterial {
        /// The index.
        material: MaterialIndex,
        /// Materials of the world.
        materials: usize,
    },
    /// The world does not have this model.
    #[error("the edit places the model `{model}`, and the world has no model of that name")]
    UnknownModel {
        /// The name.
        model: String,
    },
    /// The byte is not one of the 24 rotations.
    #[error("{orientation} is not one of the 24 rotations")]
    Orientation {
        /// The byte.
        orientation: u8,
    },
    /// A chunk of the operation is damaged.
    #[error("the chunk {x}, {y}, {z} of the edit is broken")]
    BrokenChunk {
        /// Position in chunks.
        x: i32,
        /// Position in chunks.
        y: i32,
        /// Position in chunks.
        z: i32,
    },
}

impl Operation {
    /// One voxel.
    pub fn set(cell: [i32; 3], material: MaterialIndex) -> Self {
        Self::Set { cell, material }
    }

    /// A ball, by its centre and radius in voxels. One whose centre or radius is NaN, or whose radius is negative, is refused when it is made.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a radius below 0 becomes 0 and a large one the largest, and both are refused when the edit is made"
    )]
    pub fn sphere(center: [f64; 3], radius: f64, brush: Brush) -> Self {
        let steps = |voxels: f64| if voxels.is_nan() { i64::MIN } else { fixed(voxels) };
        Self::Sphere { center: center.map(steps), radius: (radius * UNIT as f64).round() as u32, brush }
    }

    /// A box around the voxels that the operation may change. `None` for [`Operation::Put`], which names its chunks.
    ///
    /// # Errors
    /// Reports every fault of it, its size included.
    pub fn bounds(&self, scene: &Scene) -> Result<Option<Bounds>, EditError> {
        self.check(scene)?;
        let bounds = match self {
            Self::Set { cell, .. } => {
                let min = cell.map(i64::from);
                Bounds { min, max: min.map(|c| c + 1) }
            }
            Self::Box { bounds, .. } | Self::Restore { bounds } => *bounds,
            Self::Sphere { center, radius, .. } => Ball { center: *center, radius: *radius }.bounds(),
            Self::Cylinder { axis, base, radius, height, .. } => {
                Pillar { axis: usize::from(*axis), base: *base, radius: *radius, height: *height }.bounds()
            }
            Self::Model { model, position, .. } => {
                let placement = self.placement().unwrap_or(Placement::IDENTITY);
                let voxels = scene.model(model).and_then(|model| model.voxels.bounds());
                let at = position.map(i64::from);
                voxels.map_or(Bounds { min: at, max: at }, |bounds| Placed::placed_bounds(&bounds, &placement))
            }
            Self::Put { .. } => return Ok(None),
        };
        if (0..3).any(|i| !CELLS.contains(&bounds.min[i]) || !CELLS.contains(&bounds.max[i])) {
            return Err(EditError::OutOfRange { min: bounds.min, max: bounds.max });
        }
        let chunks = bounds.chunk_count();
        if chunks > u128::from(MOST_CHUNKS) {
            return Err(EditError::TooLarge { chunks, limit: MOST_CHUNKS });
        }
        Ok(Some(bounds))
    }

    /// The same operation in another palette: material i becomes `indices[i]`. `None` if it has a material beyond `indices`.
    #[must_use]
    pub fn remapped(&self, indices: &[MaterialIndex]) -> Option<Self> {
        let index = |material: MaterialIndex| indices.get(usize::from(material)).copied();
        let mut operation = self.clone();
        match &mut operation {
            Self::Set { material, .. } => *material = index(*material)?,
            Self::Box { brush, .. } | Self::Sphere { brush, .. } | Self::Cylinder { brush, .. } => match brush {
                Brush::Add(material) | Brush::Paint(material) => *material = index(*material)?,
                Brush::Subtract => {}
            },
            Self::Put { chunks } => {
                for packed in chunks.iter_mut().filter_map(|(_, packed)| packed.as_mut()) {
                    *packed = packed.remapped(indices)?;
                }
            }
            Self::Model { .. } | Self::Restore { .. } => {}
        }
        Some(operation)
    }

    /// The same operation with another material, if it has one.
    #[must_use]
    pub fn with_material(mut self, other: MaterialIndex) -> Self {
        match &mut self {
            Self::Set { material, .. } => *material = other,
            Self::Box { brush, .. } | Self::Sphere { brush, .. } | Self::Cylinder { brush, .. } => match brush {
                Brush::Add(material) | Brush::Paint(material) => *material = other,
                Brush::Subtract => {}
            },
            Self::Model { .. } | Self::Restore { .. } | Self::Put { .. } => {}
        }
        self
    }

    /// The turn and the move of a model; `None` for any other operation.
    pub(crate) fn placement(&self) -> Option<Placement> {
        match self {
            Self::Model { orientation, position, .. } => {
                Some(Placement { turn: Orientation::from_vox(*orientation)?, to: position.map(i64::from) })
            }
            _ => None,
        }
    }

    /// Everything but where it is.
    fn check(&self, scene: &Scene) -> Result<(), EditError> {
        let empty = |what: String| Err(EditError::Empty { what });
        let known = |material: MaterialIndex| {
            let materials = scene.materials.len();
            if usize::from(material) < materials {
                Ok(())
            } else {
                Err(EditError::UnknownMaterial { material, materials })
            }
        };
        let brushed = |brush: &Brush| match brush.material() {
            Some(AIR) => Err(EditError::UnknownMaterial { material: AIR, materials: scene.materials.len() }),
            Some(material) => known(material),
            None => Ok(()),
        };
        let round = |radius: u32| match radius / STEPS {
            _ if radius == 0 => empty("its radius is 0".to_owned()),
            voxels if voxels >= MOST_RADIUS && radius > MOST_RADIUS * STEPS => {
                Err(EditError::Radius { radius: voxels, limit: MOST_RADIUS })
            }
            _ => Ok(()),
        };
        match self {
            Self::Set { material, .. } => known(*material),
            Self::Box { bounds, brush } => {
                brushed(brush)?;
                not_empty(bounds)
            }
            Self::Restore { bounds } => not_empty(bounds),
            Self::Sphere { center, radius, brush } => {
                brushed(brush)?;
                round(*radius)?;
                inside(center)
            }
            Self::Cylinder { axis, base, radius, height, brush } => {
                brushed(brush)?;
                round(*radius)?;
                inside(base)?;
                match (axis, height) {
                    (_, 0) => empty("its height is 0".to_owned()),
                    (0..3, _) => Ok(()),
                    _ => empty(format!("there is no axis {axis}")),
                }
            }
            Self::Model { model, orientation, .. } => {
                if scene.model(model).is_none() {
                    return Err(EditError::UnknownModel { model: model.clone() });
                }
                match Orientation::from_vox(*orientation) {
                    Some(turn) if turn.is_rotation() => Ok(()),
                    _ => Err(EditError::Orientation { orientation: *orientation }),
                }
            }
            Self::Put { .. } => Ok(()),
        }
    }
}

fn not_empty(bounds: &Bounds) -> Result<(), EditError> {
    if (0..3).any(|i| bounds.min[i] >= bounds.max[i]) {
        let what = format!("its box goes from {:?} to {:?}", bounds.min, bounds.max);
        return Err(EditError::Empty { what });
    }
    Ok(())
}

/// A position whose voxel is in range, so that no sum with a radius overflows.
fn inside(position: &[i64; 3]) -> Result<(), EditError> {
    let cell = position.map(|p| p.div_euclid(UNIT));
    if cell.iter().all(|c| CELLS.contains(c)) {
        Ok(())
    } else {
        Err(EditError::OutOfRange { min: cell, max: cell.map(|c| c.saturating_add(1)) })
    }
}
