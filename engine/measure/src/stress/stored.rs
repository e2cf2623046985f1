//! A site whose voxels a shader has changed in a writable copy (`rx_set`): the voxels to set, and the resulting world.

use std::collections::{BTreeMap, BTreeSet};

use glam::IVec3;
use raxel_edit::Brush;
use raxel_oracle::sets::{Random, RayTargets};
use raxel_world::World;

use super::edited::replaced;
use crate::rays::VoxelEdit;

/// Runs of voxels that are set.
const RUNS: usize = 1500;
/// Longest run.
const LONGEST: u64 = 6;
/// Voxels along an edge of the chunks of every layout that has `rx_set`.
const CHUNK: i32 = 32;

/// The input of a shader, and the right output.
pub(super) struct Stored {
    /// Voxels of chunks that the copy has, each once, in an order in which neighbours in a word are set by neighbouring invocations.
    pub edits: Vec<VoxelEdit>,
    /// Voxels that it has no chunk for.
    pub beyond: Vec<VoxelEdit>,
    /// The voxels afterwards.
    pub world: World,
    /// The targets of rays.
    pub targets: RayTargets,
}

impl Stored {
    /// Edits all over the chunks of a world: voxels are added, taken away and given other materials.
    #[expect(clippy::cast_possible_truncation, reason = "random numbers are below what they were asked for")]
    pub(crate) fn of(world: &World, seed: u64) -> Self {
        let mut random = Random::new(seed ^ 0x5702);
        let chunks: BTreeSet<[i32; 3]> = world.voxels().map(|(cell, _)| cell.to_array().map(|c| c >> 5)).collect();
        let chunks: Vec<IVec3> = chunks.into_iter().map(IVec3::from_array).collect();
        let materials = (world.materials().len() as u64).saturating_sub(1);
        let mut set: BTreeMap<[i32; 3], u16> = BTreeMap::new();
        for run in 0..if chunks.is_empty() || materials == 0 { 0 } else { RUNS } {
            let chunk = chunks[random.index(chunks.len())] * CHUNK;
            let first = chunk + IVec3::from_array([0; 3].map(|_: i32| random.below(CHUNK as u64) as i32));
            let mut material = || if run % 3 == 0 { 0 } else { 1 + random.below(materials) as u16 };
            let (one, other) = (material(), material());
            let length = (1 + random.below(LONGEST) as i32).min(CHUNK - (first.x & (CHUNK - 1)));
            for x in 0..length {
                set.insert([first.x + x, first.y, first.z], if run % 5 == 0 && x % 2 == 0 { other } else { one });
            }
        }
        // By z, y, x: the x of a run are neighbours.
        let mut edits: Vec<VoxelEdit> = set.into_iter().map(|(cell, material)| VoxelEdit { cell, material }).collect();
        edits.sort_by_key(|edit| (edit.cell[2], edit.cell[1], edit.cell[0]));
        let voxels = edits.iter().map(|edit| {
            let brush = if edit.material == 0 { Brush::Subtract } else { Brush::Add(edit.material) };
            (IVec3::from_array(edit.cell), brush)
        });
        let world = replaced(world, voxels);
        let corner = chunks.first().map_or(IVec3::ZERO, |chunk| *chunk * CHUNK);
        // Far away, beyond the cube, and where a difference of 32 bits wraps around.
        let away = [[900, 0, 0], [0, -70_000, 0], [0, 0, 1 << 20], [i32::MAX, i32::MIN, 0], [i32::MIN, 0, 0]];
        let beyond =
            away.map(|by| VoxelEdit { cell: corner.wrapping_add(IVec3::from_array(by)).to_array(), material: 1 });
        let known: BTreeSet<[i32; 3]> = chunks.iter().map(IVec3::to_array).collect();
        let beyond = beyond.into_iter().filter(|edit| !known.contains(&edit.cell.map(|c| c >> 5))).collect();
        Self { edits, beyond, targets: RayTargets::of(&world), world }
    }
}

#[cfg(test)]
mod tests {
    use raxel_oracle::scenes;

    use super::*;
    use crate::stress::{Site, Sites};

    #[test]
    fn voxels_are_added_taken_away_and_changed_in_every_scene() {
        for scene in scenes::ALL.iter().filter(|scene| scene.name != "terrain") {
            for sites in [Sites::Near, Sites::Far] {
                let world = Site::scene(scene, sites).build(3);
                let stored = Stored::of(&world, 1);
                let mut kinds = [0; 3];
                for edit in &stored.edits {
                    let cell = IVec3::from_array(edit.cell);
                    assert_eq!(stored.world.voxel(cell), edit.material, "{scene:?} {edit:?}");
                    match (world.voxel(cell), edit.material) {
                        (0, 1..) => kinds[0] += 1,
                        (1.., 0) => kinds[1] += 1,
                        (1.., 1..) => kinds[2] += 1,
                        (0, 0) => {}
                    }
                }
                let cells: BTreeSet<_> = stored.edits.iter().map(|edit| edit.cell).collect();
                let kept = |world: &World| {
                    let voxels = world.voxels().map(|(cell, material)| (cell.to_array(), material));
                    voxels.filter(|(cell, _)| !cells.contains(cell)).collect::<BTreeMap<_, _>>()
                };
                assert!(cells.len() == stored.edits.len() && stored.beyond.len() >= 4);
                assert!(kept(&world) == kept(&stored.world), "{scene:?}: other voxels stay");
                assert!(kinds[0] > 500 || ["solid", "cubes"].contains(&scene.name), "{scene:?} {kinds:?}");
            }
        }
    }
}
