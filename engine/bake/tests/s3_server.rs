//! A real server of S3 that is killed and started again while worlds are baked into it and read from it.
//!
//! `cargo test --profile checked -p raxel-bake --features cloud --test s3_server -- --ignored`; `common/s3.rs` says which server.

#![cfg(all(feature = "cloud", target_os = "linux"))]
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use common::s3::{AWAY, Server, restarted};
use common::{expected, land, plan, tiles};
use raxel_bake::{BakePart, FolderStore, ObjectStore, Patience, ZarrSource, bake};
use raxel_testing::files;
use raxel_world::ChunkProvider as _;

/// The world on the server.
fn open(server: &Server, patience: Patience) -> ObjectStore {
    ObjectStore::open_with("s3://worlds/land", server.environment(), patience).unwrap()
}

/// The objects of the world, without what the server keeps beside them.
fn objects(server: &Server) -> BTreeMap<String, Vec<u8>> {
    let all = files(&server.folder().join("worlds/land")).into_iter();
    all.filter(|(name, _)| !name.split('/').any(|part| part.starts_with('.'))).collect()
}

#[test]
#[ignore = "needs s3s-fs"]
fn a_server_that_restarts_costs_no_shard_and_changes_no_voxel() {
    let server = Server::start();
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    bake(&*land, &plan, BakePart::Whole, &FolderStore::new(folder.path().to_owned()), &mut |_, _| {}).unwrap();
    let whole: BTreeMap<_, _> = files(folder.path()).into_iter().collect();

    // Two tasks at once; after each shard the server is away for a while.
    let slowly = |part: BakePart| {
        let store = open(&server, Patience::default());
        bake(&*land, &plan, part, &store, &mut |_, _| std::thread::sleep(2 * AWAY)).map(|done| done.written)
    };
    let written = restarted(&server, || {
        std::thread::scope(|scope| {
            let tasks = ["1/2", "2/2"].map(|part| scope.spawn(move || slowly(part.parse().unwrap())));
            tasks.map(|task| task.join().unwrap().expect("it is asked again"))
        })
    });
    let restarts = server.take_restarts();
    assert!(restarts > 3, "{restarts}");
    assert_eq!(written.iter().sum::<u64>(), 16);
    assert!(objects(&server) == whole);
    // Shards that are there are not made again.
    let again = bake(&*land, &plan, BakePart::Whole, &open(&server, Patience::default()), &mut |_, _| {}).unwrap();
    assert_eq!((again.written, again.skipped), (0, 16));

    let source = ZarrSource::of(Arc::new(open(&server, Patience::default())), "s3://worlds/land").unwrap();
    restarted(&server, || {
        for (count, (level, pos)) in tiles(&plan).into_iter().enumerate() {
            let found = source.try_chunk(level, pos).expect("it is asked again");
            assert!(found == expected(&*land, &plan, (level, pos)), "{level} {pos:?}");
            if count % 8 == 0 {
                std::thread::sleep(AWAY / 4);
            }
        }
    });
    let restarts = server.take_restarts();
    assert!(restarts > 1, "{restarts}");
}

#[test]
#[ignore = "needs s3s-fs"]
fn a_server_that_is_away_is_an_error_until_it_is_back() {
    let server = Server::start();
    let land = land();
    let plan = plan(&*land);
    bake(&*land, &plan, BakePart::Whole, &open(&server, Patience::default()), &mut |_, _| {}).unwrap();
    let [answer, request, pause] = [400, 500, 1].map(Duration::from_millis);
    let patience = || Patience { answer, request, pause, pauses: vec![pause] };
    let source = ZarrSource::of(Arc::new(open(&server, patience())), "s3://worlds/land").unwrap();
    let solid = common::solid_tile(&*land, &plan);
    {
        let _away = server.away();
        let error = source.try_chunk(solid.0, solid.1).unwrap_err();
        assert_eq!((error.level, error.pos), solid);
        assert!(error.reason.contains("s3://worlds/land"), "{error}");
        // Nothing is written, and nothing is lost.
        let refused = bake(&*land, &plan, BakePart::Whole, &open(&server, patience()), &mut |_, _| {});
        assert!(refused.is_err());
    }
    assert!(source.try_chunk(solid.0, solid.1).unwrap() == expected(&*land, &plan, solid));
    let again = bake(&*land, &plan, BakePart::Whole, &open(&server, Patience::default()), &mut |_, _| {}).unwrap();
    assert_eq!((again.written, again.skipped), (0, 16));
}
