//! MagicaVoxel scenes: an imported scene can be exported, and is the same world when it is imported again.

use std::collections::BTreeMap;

use raxel_world::{World, vox};

use crate::bounds::Bounds;
use crate::{Mutation, Target};

pub(crate) const TARGET: Target = Target {
    name: "vox",
    run,
    // A small file may show a model of its a hundred times.
    bounds: Bounds { bytes: 256 << 20, ..Bounds::PARSER },
    mutation: Mutation::Binary,
    seeds: &[],
    longest: 8 << 10,
    quick: 1500,
};

fn run(input: &[u8]) {
    for frame in [0, 1] {
        match vox::import_frame(input, frame) {
            Ok(world) => again(&world),
            Err(error) => {
                assert!(!error.message.is_empty());
                assert!(error.offset.is_none_or(|at| at <= input.len()), "{error:?} of {} bytes", input.len());
                let diagnostic = error.diagnostic("worlds/main.vox", None);
                assert!(diagnostic.is_error() && !diagnostic.message.is_empty());
            }
        }
    }
}

fn again(world: &World) {
    let voxels = |world: &World| -> BTreeMap<[i32; 3], String> {
        let name = |material| world.materials()[usize::from(material)].name.clone();
        world.voxels().map(|(cell, material)| (cell.to_array(), name(material))).collect()
    };
    assert_eq!(world.voxels().count() as u64, world.solids());
    let bytes = match vox::export(world) {
        Ok(bytes) => bytes,
        Err(error) => panic!("an imported world cannot be exported: {error}"),
    };
    let again = vox::import(&bytes).unwrap_or_else(|error| panic!("an export cannot be imported: {error}"));
    assert_eq!(voxels(world).keys().collect::<Vec<_>>(), voxels(&again).keys().collect::<Vec<_>>());
}
