//! Parts make the whole, in any processes and after any interruptions; a failing store is never taken for an empty one.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use common::{expected, land, plan, solid_tile};
use raxel_bake::{BakeError, BakePart, FolderStore, Plan, Store, StoreError, Wanted, ZarrSource, bake};
use raxel_testing::files;
use raxel_world::{Bounds, ChunkPos, ChunkProvider, Content};

fn bake_to(folder: &Path, land: &dyn ChunkProvider, plan: &Plan, part: &str) -> raxel_bake::Report {
    let part = if part.is_empty() { BakePart::Whole } else { part.parse().unwrap() };
    bake(land, plan, part, &FolderStore::new(folder.to_owned()), &mut |_, _| {}).unwrap()
}

#[test]
fn parts_are_the_whole() {
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    let inside = |name: &str| folder.path().join(name);
    let whole = bake_to(&inside("whole"), &*land, &plan, "");
    assert_eq!((whole.shards, whole.written, whole.skipped), (16, 16, 0));
    assert!(whole.chunks > 8, "{whole:?}");
    for part in ["3/3", "1/3", "2/3"] {
        bake_to(&inside("list"), &*land, &plan, part);
    }
    for z in (0..2).rev() {
        for y in 0..2 {
            for x in 0..2 {
                // A process that comes new to the world bakes the same.
                assert_eq!(bake_to(&inside("boxes"), &*common::land(), &plan, &format!("{x},{y},{z}/2")).shards, 2);
            }
        }
    }
    let wanted = files(&inside("whole"));
    assert_eq!(wanted.len(), 16 + 3);
    assert!(files(&inside("list")) == wanted && files(&inside("boxes")) == wanted);
    let bytes: usize = wanted.iter().filter(|(name, _)| name.contains("/c/")).map(|(_, bytes)| bytes.len()).sum();
    assert_eq!(whole.bytes, bytes as u64);

    // A shard that is there and whole is left as it is; everything else is made again.
    let damage = |name: &str, how: &dyn Fn(&mut Vec<u8>)| {
        let path = inside("whole").join(name);
        let mut bytes = std::fs::read(&path).unwrap();
        how(&mut bytes);
        std::fs::write(path, bytes).unwrap();
    };
    let largest = wanted.iter().max_by_key(|(_, bytes)| bytes.len()).unwrap();
    damage(&largest.0, &|bytes| bytes[100] ^= 4);
    damage("zarr.json", &|bytes| bytes.truncate(200));
    damage("1/c/0/0/0", &|bytes| bytes.truncate(bytes.len() - 3));
    damage("1/c/0/0/1", &Vec::clear);
    std::fs::remove_file(inside("whole/1/c/1/1/1")).unwrap();
    let again = bake_to(&inside("whole"), &*land, &plan, "");
    assert_eq!((again.shards, again.written, again.redone, again.skipped), (16, 4, 3, 12));
    assert_eq!((again.chunks, again.bytes), (whole.chunks, whole.bytes));
    assert!(files(&inside("whole")) == wanted);

    // A document that is valid JSON, but not the written one.
    let replace = |from: &str, to: &str| {
        let text = std::fs::read_to_string(inside("whole/zarr.json")).unwrap();
        assert!(text.contains(from), "{from}");
        std::fs::write(inside("whole/zarr.json"), text.replace(from, to)).unwrap();
    };
    replace("\"emission\": 4.0", "\"emission\": 5.0");
    assert!(ZarrSource::open(inside("whole").to_str().unwrap(), Path::new("/")).is_err());
    bake_to(&inside("whole"), &*land, &plan, "");
    assert!(files(&inside("whole")) == wanted);
    replace("\"format\": 2", "\"format\": 1");
    let error = bake(&*land, &plan, BakePart::Whole, &FolderStore::new(inside("whole")), &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, BakeError::OtherFormat(_)), "{error}");
}

#[test]
fn another_world_is_not_mixed_in() {
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let store = FolderStore::new(folder.path().to_owned());
    let part = || "1/16".parse().unwrap();
    let baked = |plan: &Plan| bake(&*land, plan, part(), &store, &mut |_, _| {});
    let first = plan(&*land);
    baked(&first).unwrap();
    let before = files(folder.path());
    let materials = land.materials().to_vec();
    let other = Plan::new("hill", "4567", materials.clone(), first.region(), common::EDGE, common::LEVELS).unwrap();
    let error = baked(&other).unwrap_err();
    assert!(matches!(error, BakeError::OtherWorld { .. }), "{error}");
    for word in ["land", "0123", "hill", "4567"] {
        assert!(error.to_string().contains(word), "{error}");
    }
    let region = Bounds { max: [500; 3], ..first.region() };
    let larger = Plan::new("land", "0123", materials, region, common::EDGE, common::LEVELS).unwrap();
    assert!(matches!(baked(&larger), Err(BakeError::OtherPlan { .. })));
    assert!(files(folder.path()) == before);
}

/// A store that fails in every way there is, at some of its calls.
struct Failing {
    store: FolderStore,
    calls: AtomicUsize,
    /// Which call fails how; calls are counted from 0.
    plan: Mutex<Vec<(usize, Fault)>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    /// The server answers 500.
    Busy,
    /// It says that there is no such object.
    Missing,
    /// Half of the bytes arrive.
    Half,
    /// A bit is another one.
    Flipped,
}

impl Store for Failing {
    fn get(&self, key: &str, wanted: Wanted) -> Result<Option<Vec<u8>>, StoreError> {
        let call = self.calls.fetch_add(1, Ordering::Relaxed);
        let fault = self.plan.lock().unwrap().iter().find(|(at, _)| *at == call).map(|(_, fault)| *fault);
        let bytes = self.store.get(key, wanted)?;
        match fault {
            None => Ok(bytes),
            Some(Fault::Busy) => {
                Err(StoreError { key: key.to_owned(), reason: "500 Internal Server Error".to_owned(), passing: true })
            }
            Some(Fault::Missing) => Ok(None),
            Some(Fault::Half) => Ok(bytes.map(|bytes| bytes[..bytes.len() / 2].to_vec())),
            Some(Fault::Flipped) => Ok(bytes.map(|mut bytes| {
                let at = bytes.len() / 3;
                bytes[at] ^= 16;
                bytes
            })),
        }
    }

    fn put(&self, key: &str, bytes: &[u8]) -> Result<(), StoreError> {
        self.store.put(key, bytes)
    }
}

#[test]
fn a_store_that_fails_is_never_taken_for_an_empty_one() {
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    bake_to(folder.path(), &*land, &plan, "");
    let solid = solid_tile(&*land, &plan);
    let wanted = expected(&*land, &plan, solid);
    let open = |faults: &[(usize, Fault)]| {
        let store = FolderStore::new(folder.path().to_owned());
        let failing = Failing { store, calls: AtomicUsize::new(0), plan: Mutex::new(faults.to_vec()) };
        ZarrSource::of(Arc::new(failing), "s3://test").map(Arc::new)
    };
    // Call 0 opens it; 1 reads the index of the shard, 2 the chunk.
    for fault in [Fault::Busy, Fault::Half, Fault::Flipped] {
        for call in [1, 2] {
            let source = open(&[(call, fault)]).unwrap();
            assert_eq!(source.try_chunk(solid.0, solid.1).as_ref(), Ok(&wanted), "{fault:?} at call {call}");
        }
        // A lasting failure is reported, and the data is right as soon as it ends.
        let all: Vec<(usize, Fault)> = (1..=3).map(|call| (call, fault)).collect();
        let source = open(&all).unwrap();
        let error = source.try_chunk(solid.0, solid.1).unwrap_err().to_string();
        assert!(error.contains("s3://test") && error.contains("0/c/"), "{error}");
        assert_eq!(source.try_chunk(solid.0, solid.1).as_ref(), Ok(&wanted));
    }
    let source = open(&[(1, Fault::Missing), (4, Fault::Missing)]).unwrap();
    for _ in 0..2 {
        let error = source.try_chunk(solid.0, solid.1).unwrap_err().to_string();
        assert!(error.contains("was not baked yet, or was removed"), "{error}");
        assert!(source.try_chunk(solid.0, solid.1).is_ok());
    }
    assert!(open(&[(0, Fault::Busy), (1, Fault::Busy)]).is_ok());
    assert!(open(&[(0, Fault::Missing)]).unwrap_err().to_string().contains("no world was baked to `s3://test`"));
    for fault in [Fault::Half, Fault::Flipped] {
        assert!(open(&[(0, fault), (1, fault)]).is_ok());
        let all = [0, 1, 2].map(|call| (call, fault));
        assert!(open(&all).unwrap_err().to_string().contains("cannot be read"));
    }
    // A level without a bake is not an empty level.
    assert!(open(&[]).unwrap().try_chunk(2, ChunkPos::new(0, 0, 0)).is_err());
    assert_eq!(open(&[]).unwrap().try_chunk(0, ChunkPos::new(900, 0, 0)), Ok(Content::Empty));
}

#[test]
fn baking_goes_on_when_the_store_does() {
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    let store = FolderStore::new(folder.path().join("store"));
    let failing =
        Failing { store, calls: AtomicUsize::new(0), plan: Mutex::new(vec![(2, Fault::Busy), (5, Fault::Busy)]) };
    bake(&*land, &plan, BakePart::Whole, &failing, &mut |_, _| {}).unwrap();
    bake_to(&folder.path().join("whole"), &*land, &plan, "");
    assert!(files(&folder.path().join("store")) == files(&folder.path().join("whole")));
}
