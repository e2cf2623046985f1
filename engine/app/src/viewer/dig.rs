//! Digging and placing with the mouse.

use raxel_edit::{Brush, Operation};
use raxel_runtime::Session;
use raxel_world::MaterialIndex;

/// Farthest voxel that can be reached.
const REACH: f64 = 4096.0;

/// Radii to choose from, in voxels. The smallest is one voxel.
const RADII: [f64; 8] = [0.5, 1.5, 2.5, 4.5, 8.5, 16.5, 32.5, 64.5];

/// What the mouse does to voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// A ball of air around the voxel under the cursor.
    Dig,
    /// A ball of material in front of it.
    Place,
}

/// The size and the material of the ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    radius: usize,
    /// None: that of the voxel under the cursor.
    material: Option<MaterialIndex>,
}

impl Default for Ball {
    fn default() -> Self {
        Self { radius: 3, material: None }
    }
}

impl Ball {
    /// The edit at a pixel of the window; `None` where nothing can be reached.
    pub(super) fn edit(self, action: Action, session: &Session, pixel: [i32; 2]) -> Option<Operation> {
        let hit = session.pick(pixel, REACH)?;
        let (cell, brush) = match action {
            Action::Dig => (hit.exact.voxel, Brush::Subtract),
            Action::Place => (hit.front(), Brush::Add(self.material.unwrap_or(hit.exact.material))),
        };
        Some(Operation::sphere(cell.map(|c| f64::from(c) + 0.5), RADII[self.radius], brush))
    }

    /// A larger or a smaller ball.
    pub(super) fn resize(&mut self, by: isize) {
        self.radius = self.radius.saturating_add_signed(by).min(RADII.len() - 1);
    }

    /// The next material of the world; after the last one, that of the voxel under the cursor.
    pub(super) fn next_material(&mut self, materials: usize) {
        let next = self.material.map_or(1, |material| usize::from(material) + 1);
        self.material = (next < materials).then_some(next as MaterialIndex);
    }

    /// In words.
    pub(super) fn text(self, session: &Session) -> String {
        let name = self.material.and_then(|material| session.scene().materials.get(usize::from(material)));
        let of = name.map_or("the material under the cursor", |material| &material.name);
        format!("ball of {} voxels across, of {of}", 2.0 * RADII[self.radius])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_materials_go_round() {
        let mut ball = Ball::default();
        for _ in 0..20 {
            ball.resize(1);
        }
        assert_eq!(ball.radius, 7);
        for _ in 0..20 {
            ball.resize(-1);
        }
        assert_eq!(ball.radius, 0);
        let mut seen = Vec::new();
        for _ in 0..4 {
            ball.next_material(4);
            seen.push(ball.material);
        }
        assert_eq!(seen, [Some(1), Some(2), Some(3), None]);
    }
}
