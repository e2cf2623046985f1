//! The worlds that come with raxel.

use std::path::Path;
use std::sync::Arc;

use raxel_diagnostics::{FileError, Files, SourceMap};
use raxel_worldfile::{Loaded, load};

struct Root;

impl Files for Root {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        std::fs::read(root.join(path)).map(Into::into).map_err(|error| FileError::Io(error.to_string()))
    }
}

fn shipped(name: &str) -> Loaded {
    let path = format!("worlds/{name}.toml");
    let (loaded, warnings) = load(&path, &Root, &mut SourceMap::default()).unwrap_or_else(|e| panic!("{path}: {e:#?}"));
    assert_eq!(warnings, [], "{path}");
    assert_eq!(loaded.name, name);
    assert!(loaded.about.is_some() && loaded.camera.is_some());
    // No material is there for nothing.
    for (material, count) in loaded.world.materials().iter().zip(loaded.world.counts()).skip(1) {
        assert!(*count > 0, "{path}: {}", material.name);
    }
    loaded
}

#[test]
fn valley() {
    let world = shipped("valley").world;
    assert!(world.has_transparency() && !world.has_emission());
    assert_eq!(world.bounds().expect("land").size()[0], 512);
}

#[test]
fn menger() {
    assert_eq!(shipped("menger").world.solids(), 20u64.pow(5));
}

#[test]
fn monument() {
    let world = shipped("monument").world;
    assert!(world.has_emission() && world.has_transparency());
}

#[test]
fn terrain() {
    let Loaded { world, cameras, .. } = shipped("terrain");
    assert_eq!(world.solids(), 9 << 22, "9 voxels in each of 2048 × 2048 columns");
    assert_eq!(world.bounds().expect("land").size(), [2048, 163, 2048]);
    assert_eq!(cameras.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["overview", "ground", "down"]);
}

#[test]
fn fair() {
    let path = "worlds/fair.toml";
    let (loaded, warnings) = load(path, &Root, &mut SourceMap::default()).unwrap_or_else(|e| panic!("{path}: {e:#?}"));
    assert_eq!(warnings, [], "{path}");
    let instances = &loaded.instances;
    let named: Vec<&str> = instances.list.iter().filter_map(|instance| instance.name.as_deref()).collect();
    assert_eq!((named, instances.list.len()), (vec!["carousel", "wheel"], 23));
    assert_eq!(instances.models.len(), 5);
    // Everything can move.
    assert!(instances.list.iter().all(|instance| !instance.motions.is_empty()));
}

#[test]
fn flock() {
    let path = "worlds/flock.toml";
    let (loaded, warnings) = load(path, &Root, &mut SourceMap::default()).unwrap_or_else(|e| panic!("{path}: {e:#?}"));
    assert_eq!(warnings, [], "{path}");
    assert_eq!((loaded.instances.models.len(), loaded.instances.list.len()), (1, 512));
    // The shader moves them all: graphs/examples/flock.toml has as many.
    assert!(loaded.instances.list.iter().all(|instance| instance.motions.is_empty()));
}

#[test]
fn models_are_what_their_files_build() {
    for name in ["hut", "mushroom", "vein"] {
        let path = format!("worlds/models/{name}.toml");
        let (loaded, warnings) =
            load(&path, &Root, &mut SourceMap::default()).unwrap_or_else(|e| panic!("{path}: {e:#?}"));
        assert_eq!(warnings, [], "{path}");
        assert!(loaded.world.has_emission());
        let model = Root.read(&format!("worlds/models/{name}.vox")).expect("it is there");
        assert!(raxel_world::vox::export(&loaded.world).expect("it is small")[..] == model[..], "export {path} again");
    }
}
