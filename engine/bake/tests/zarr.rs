//! Baked voxels, read back by raxel and by the Python package `zarr`.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::python::Python;
use common::{LEVELS, cells, expected, land, plan, tiles};
use raxel_bake::{BakePart, FolderStore, ZarrSource, bake};
use raxel_world::ChunkProvider as _;

/// Compares the arrays of a folder with raw cells, which are in files beside it.
const COMPARE: &str = include_str!("fixtures/zarr/compare.py");

#[test]
fn a_source_has_the_tiles_that_were_baked() {
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    let store = FolderStore::new(folder.path().to_owned());
    bake(&*land, &plan, BakePart::Whole, &store, &mut |_, _| {}).unwrap();
    let source = ZarrSource::open(folder.path().to_str().unwrap(), std::path::Path::new("/")).unwrap();
    assert_eq!((source.materials(), source.fingerprint()), (land.materials(), Some("0123")));
    assert_eq!((source.region(), source.top_level()), (plan.region(), LEVELS - 1));
    let tiles = tiles(&plan);
    for (level, pos) in &tiles {
        let found = source.try_chunk(*level, *pos).unwrap();
        assert_eq!(found, expected(&*land, &plan, (*level, *pos)), "level {level}, {pos:?}");
    }
    assert!(tiles.iter().any(|(level, pos)| *level == 1 && source.try_chunk(1, *pos).unwrap().to_chunk().is_some()));
}

#[test]
fn python_reads_what_was_baked() {
    let Some(python) = Python::with("zarr-3.1.6", &["zarr==3.1.6"]) else { return };
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    bake(&*land, &plan, BakePart::Whole, &FolderStore::new(folder.path().join("store")), &mut |_, _| {}).unwrap();
    for level in 0..LEVELS {
        let (cells, shape) = cells(&*land, &plan, level);
        let bytes: Vec<u8> = cells.iter().flat_map(|cell| cell.to_le_bytes()).collect();
        std::fs::write(folder.path().join(format!("{level}.raw")), bytes).unwrap();
        std::fs::write(folder.path().join(format!("{level}.json")), format!("{shape:?}")).unwrap();
    }
    python.run(COMPARE, &[folder.path().to_str().unwrap(), &LEVELS.to_string()], &[]);
}
