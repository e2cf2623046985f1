//! The brush of the right mouse button, as edits of the world.

use raxel_edit::query::CastHit;
use raxel_edit::{Brush as Does, Operation, fixed};
use raxel_panels::view::{Brush, Effect, Shape};
use raxel_runtime::Session;
use raxel_world::{AIR, Bounds, MaterialIndex};
use winit::keyboard::ModifiersState;

/// Farthest voxel that can be reached.
pub(super) const REACH: f64 = 4096.0;

/// Voxels across that the keys choose from.
const SIZES: [u32; 8] = [1, 3, 5, 9, 17, 33, 65, 129];

/// The result of a press of the button.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stroke {
    /// An edit.
    Edit(Operation),
    /// The brush gets a material.
    Pick(MaterialIndex),
}

/// The effect of the brush while keys are held: Shift turns it round, Ctrl picks.
pub(super) fn effect(brush: &Brush, modifiers: ModifiersState) -> Effect {
    match (modifiers.control_key(), modifiers.shift_key()) {
        (true, _) => Effect::Pick,
        (false, true) => brush.effect.opposite(),
        (false, false) => brush.effect,
    }
}

/// The stroke of a brush where a ray has met the world.
pub(super) fn stroke(brush: &Brush, effect: Effect, hit: &CastHit) -> Stroke {
    let material = brush.material.unwrap_or(hit.exact.material);
    match effect {
        Effect::Add => Stroke::Edit(operation(brush, hit, hit.front(), Does::Add(material))),
        Effect::Subtract => Stroke::Edit(operation(brush, hit, hit.exact.voxel, Does::Subtract)),
        Effect::Paint => Stroke::Edit(operation(brush, hit, hit.exact.voxel, Does::Paint(material))),
        Effect::Pick => Stroke::Pick(hit.exact.material),
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a brush has few voxels, and there are three axes"
)]
fn operation(brush: &Brush, hit: &CastHit, cell: [i32; 3], does: Does) -> Operation {
    let (voxel, cell) = (cell, cell.map(i64::from));
    let (size, height) = (i64::from(brush.size), i64::from(brush.height));
    // An odd number of voxels lies around the cell, an even one has one more beyond it.
    let low = cell.map(|c| c - (size - 1) / 2);
    let center = low.map(|c| c as f64 + size as f64 / 2.0);
    match brush.shape {
        Shape::Voxel => match does {
            Does::Add(material) | Does::Paint(material) => Operation::set(voxel, material),
            Does::Subtract => Operation::set(voxel, AIR),
        },
        Shape::Box => Operation::Box { bounds: Bounds { min: low, max: low.map(|c| c + size) }, brush: does },
        Shape::Sphere => Operation::sphere(center, size as f64 / 2.0, does),
        Shape::Cylinder => {
            // Seen from inside a voxel there is no face: it stands upright.
            let axis = if hit.exact.face < 6 { hit.exact.face / 2 } else { 1 } as usize;
            let outwards = matches!(does, Does::Add(_));
            let up = (hit.exact.face & 1 == 1 || hit.exact.face >= 6) == outwards;
            let mut base = center.map(fixed);
            base[axis] = fixed((if up { cell[axis] } else { cell[axis] - height + 1 }) as f64);
            let radius = fixed(size as f64 / 2.0) as u32;
            Operation::Cylinder { axis: axis as u8, base, radius, height: brush.height, brush: does }
        }
    }
}

/// A larger or a smaller brush: the next of a few sizes.
pub(super) fn resize(brush: &mut Brush, larger: bool) {
    let next = if larger {
        SIZES.into_iter().find(|size| *size > brush.size)
    } else {
        SIZES.into_iter().rev().find(|size| *size < brush.size)
    };
    brush.size = next.unwrap_or(brush.size);
}

/// The next of `materials` materials, air being the first; after the last one, that of the voxel under the cursor.
#[expect(clippy::cast_possible_truncation, reason = "a world has at most `MAX_MATERIALS` materials besides air")]
pub(super) fn next_material(brush: &mut Brush, materials: usize) {
    let next = brush.material.map_or(1, |material| usize::from(material) + 1);
    brush.material = (next < materials).then_some(next as MaterialIndex);
}

/// In words.
pub(super) fn text(brush: &Brush, session: &Session) -> String {
    let extent = match brush.shape {
        Shape::Voxel => String::new(),
        Shape::Box | Shape::Sphere => format!(", {} voxels across", brush.size),
        Shape::Cylinder => format!(", {} voxels across and {} high", brush.size, brush.height),
    };
    let name = brush.material.and_then(|material| session.scene().materials.get(usize::from(material)));
    let of = name.map_or("the material under the cursor", |material| &material.name);
    // Subtracting ignores the material; Shift adds the brush's one.
    let of = if brush.effect == Effect::Subtract { format!("; Shift adds {of}") } else { format!(", of {of}") };
    format!("{} {}{extent}{of}", brush.effect.word(), brush.shape.word())
}
