//! A project in memory.

#![allow(dead_code, reason = "every test uses another part of it")]

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::IVec3;
use raxel_diagnostics::{Diagnostic, FileError, Files, SourceMap};
use raxel_world::{Material, World, vox};
use raxel_worldfile::Loaded;

/// Files by path.
#[derive(Clone, Default)]
pub(crate) struct Project(pub BTreeMap<String, Vec<u8>>);

impl Files for Project {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        self.0.get(path).map(|bytes| bytes.as_slice().into()).ok_or(FileError::NotFound)
    }
}

/// Materials that the worlds of tests can use.
pub(crate) const MATERIALS: &str = r##"
[materials]
a = { albedo = "#ff0000" }
b = { albedo = [0.0, 1.0, 0.0], roughness = 0.5 }
c = { albedo = "#0000ff", emission = 3.0 }
[models.arrow]
file = "models/arrow.vox"
"##;

impl Project {
    /// With one world file and the model `arrow`.
    pub(crate) fn with_world(text: &str) -> Self {
        let arrow = vox::export(&arrow()).expect("it is small");
        Self(BTreeMap::from([
            ("worlds/test.toml".to_owned(), text.as_bytes().to_vec()),
            ("worlds/models/arrow.vox".to_owned(), arrow),
        ]))
    }

    pub(crate) fn load(&self) -> Result<(Loaded, Vec<Diagnostic>), Vec<Diagnostic>> {
        raxel_worldfile::load("worlds/test.toml", self, &mut SourceMap::default())
    }
}

/// A model without any symmetry, off its own origin.
pub(crate) fn arrow() -> World {
    let red = Material::matt("red", [1.0, 0.0, 0.0]);
    let lit = Material { emission: 2.5, ..Material::matt("lit", [0.0, 1.0, 0.0]) };
    let line = (0..7).map(|x| (IVec3::new(x + 3, 0, 1), 1));
    let head = [([9, 1, 1], 2), ([9, 0, 2], 2), ([8, 0, 3], 1), ([3, 5, 1], 2)];
    let head = head.map(|(cell, material)| (IVec3::from_array(cell), material));
    World::from_voxels(vec![Material::air(), red, lit], line.chain(head))
}

/// The world of some operations, with the materials `a` = 1, `b` = 2, `c` = 3 and the model `arrow`.
pub(crate) fn build(operations: &str) -> World {
    match Project::with_world(&format!("{MATERIALS}{operations}")).load() {
        Ok((loaded, warnings)) => {
            assert_eq!(warnings, [], "{operations}");
            loaded.world
        }
        Err(found) => panic!("{operations}\n{found:#?}"),
    }
}

/// Calls `check` for every cell around the bounds of a world, with a margin.
pub(crate) fn every_cell(world: &World, mut check: impl FnMut([i64; 3], u16)) {
    let bounds = world.bounds().expect("the world has voxels");
    for y in bounds.min[1] - 2..bounds.max[1] + 2 {
        for z in bounds.min[2] - 2..bounds.max[2] + 2 {
            for x in bounds.min[0] - 2..bounds.max[0] + 2 {
                if let [Ok(cx), Ok(cy), Ok(cz)] = [x, y, z].map(i32::try_from) {
                    check([x, y, z], world.voxel(IVec3::new(cx, cy, cz)));
                }
            }
        }
    }
}
