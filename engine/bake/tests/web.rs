//! A web server that fails and lies. The result is right, or an error that names the chunk and the store.

#![cfg(feature = "cloud")]
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use common::web::{Answer, LIES, Plan, WebServer};
use common::{expected, land, plan, solid_tile, tiles};
use raxel_bake::{BakePart, FolderStore, ObjectStore, Patience, SourceError, ZarrSource, bake};
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, ChunkProvider as _, Content};

/// Time limit for everything about one lie: many times the usual time.
const LIMIT: Duration = Duration::from_secs(120);

/// A baked world, another one, and what is in the first.
struct Baked {
    folder: tempfile::TempDir,
    tiles: Vec<((u32, ChunkPos), Content)>,
    solid: (u32, ChunkPos),
}

impl Baked {
    fn new() -> Self {
        let (land, folder) = (land(), tempfile::tempdir().unwrap());
        let plan = plan(&*land);
        let other = raxel_bake::Plan::new(
            "other",
            "4567",
            land.materials().to_vec(),
            plan.region(),
            common::EDGE,
            common::LEVELS,
        );
        for (name, plan) in [("land", &plan), ("other", &other.unwrap())] {
            let store = FolderStore::new(folder.path().join(name));
            bake(&*land, plan, BakePart::Whole, &store, &mut |_, _| {}).unwrap();
        }
        let what = |tile| (tile, expected(&*land, &plan, tile));
        let solid = solid_tile(&*land, &plan);
        Self { folder, tiles: tiles(&plan).into_iter().map(what).collect(), solid }
    }

    fn serve(&self) -> WebServer {
        let inside = |name: &str| -> PathBuf { self.folder.path().join(name) };
        WebServer::start(inside("land"), inside("other"))
    }

    fn content(&self, tile: (u32, ChunkPos)) -> &Content {
        &self.tiles.iter().find(|(other, _)| *other == tile).unwrap().1
    }

    /// The answer is the content of the tile, or names the missing tile and its place.
    fn judge(&self, source: &ZarrSource, tile: (u32, ChunkPos), server: &WebServer, what: &str) -> bool {
        match source.try_chunk(tile.0, tile.1) {
            Ok(found) => {
                assert!(found == *self.content(tile), "{what}: other voxels at {tile:?}");
                true
            }
            Err(error) => {
                assert!((error.level, error.pos) == tile, "{what}: {error}");
                let object = format!("`{}/c/", tile.0);
                assert!(error.reason.contains(&server.address) && error.reason.contains(&object), "{what}: {error}");
                false
            }
        }
    }
}

/// `slow` servers are given up soon; all others get the time that they need on a busy machine.
fn open(server: &WebServer, slow: bool) -> Result<ZarrSource, SourceError> {
    let [answer, request] = if slow { [400, 500] } else { [20_000, 30_000] }.map(Duration::from_millis);
    let [pause, between] = [1, 2].map(Duration::from_millis);
    let patience = Patience { answer, request, pause, pauses: vec![between; 2] };
    let store = ObjectStore::open_with(&server.address, [], patience).unwrap();
    ZarrSource::of(Arc::new(store), &server.address)
}

/// Runs every job at once; none may hang.
fn at_once(jobs: impl IntoIterator<Item = Box<dyn FnOnce() + Send>>) {
    let (sender, receiver) = channel::<()>();
    let start = |job: Box<dyn FnOnce() + Send>| {
        let sender = sender.clone();
        std::thread::spawn(move || {
            job();
            drop(sender);
        })
    };
    let threads: Vec<_> = jobs.into_iter().map(start).collect();
    drop(sender);
    // Nothing is ever sent: the channel closes with the last job.
    assert_eq!(receiver.recv_timeout(LIMIT), Err(RecvTimeoutError::Disconnected), "something hangs");
    for thread in threads {
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    }
}

/// Whether a client asks again: it takes all but these for faults that pass.
fn passes(lie: Answer) -> bool {
    !matches!(lie, Answer::Status(204 | 403 | 404) | Answer::Whole | Answer::Page)
}

#[test]
fn every_lie_is_noticed() {
    let baked = Arc::new(Baked::new());
    at_once(LIES.into_iter().map(|lie| {
        let baked = baked.clone();
        Box::new(move || {
            let server = baked.serve();
            let slow = lie.is_slow();
            let solid = baked.solid;
            // Once: at the document, at the index of the shard, at the chunk.
            for turn in 0..3 {
                let mut answers = vec![Answer::Right; turn];
                answers.push(lie);
                let what = format!("{lie:?} at request {turn}");
                server.answers(Plan::Then(answers));
                match open(&server, slow) {
                    // A document of another world is another world, all of whose shards are others.
                    Ok(source) if turn == 0 && matches!(lie, Answer::Changed | Answer::ChangedInSecret) => {
                        assert!(source.try_chunk(solid.0, solid.1).is_err(), "{what}");
                    }
                    Ok(source) => {
                        let right = baked.judge(&source, solid, &server, &what);
                        assert!(right || slow || !passes(lie), "{what}: {:?}", source.try_chunk(solid.0, solid.1));
                        assert!(slow || baked.judge(&source, solid, &server, &what), "{what}, once more");
                    }
                    Err(error) => {
                        assert!(turn == 0 && (slow || !passes(lie)), "{what}: {error}");
                        assert!(error.to_string().contains(&server.address), "{what}: {error}");
                    }
                }
            }
            // For ever.
            server.answers(Plan::Then(Vec::new()));
            let source = open(&server, false).unwrap();
            let source = if slow { open(&server, true).unwrap_or(source) } else { source };
            server.answers(Plan::Always(lie));
            let what = format!("{lie:?} for ever");
            let before = server.requests();
            let right = baked.judge(&source, solid, &server, &what);
            // Answers that do not harm a range of bytes may succeed.
            let harmless = [Answer::Redirect, Answer::LengthLess, Answer::LengthMore, Answer::OtherSize];
            assert!(!right || harmless.contains(&lie), "{what}");
            assert!(server.requests() > before, "{what}");
            match open(&server, slow) {
                Ok(source) => drop(source),
                Err(error) => assert!(error.to_string().contains(&server.address), "{what}: {error}"),
            }
            // And right as soon as the server is.
            server.answers(Plan::Then(Vec::new()));
            assert!(slow || baked.judge(&source, solid, &server, &what), "{what}, and then right");
        }) as Box<dyn FnOnce() + Send>
    }));
}

#[test]
fn no_mix_of_lies_gives_other_voxels() {
    let baked = Arc::new(Baked::new());
    let (sender, receiver) = channel();
    let seed = 0x0022_u64;
    at_once((0..24).map(|round| {
        let (baked, sender) = (baked.clone(), sender.clone());
        Box::new(move || {
            let server = baked.serve();
            let source = open(&server, true).or_else(|_| open(&server, false)).unwrap();
            let mut random = SplitMix64::new(seed + round);
            server.answers(Plan::Random(SplitMix64::new(random.bits()), 1 + random.below(3)));
            for _ in 0..12 {
                let tile = baked.tiles[random.below(baked.tiles.len() as u64) as usize].0;
                let tile = if random.below(2) == 0 { tile } else { baked.solid };
                let right = baked.judge(&source, tile, &server, &format!("round {round}"));
                sender.send(right).unwrap();
            }
        }) as Box<dyn FnOnce() + Send>
    }));
    drop(sender);
    let answers: Vec<bool> = receiver.iter().collect();
    let right = answers.iter().filter(|right| **right).count();
    // The test would pass with a server that never lies, or never answers.
    assert!(right > 20 && answers.len() - right > 20, "{right} of {}", answers.len());
}

#[test]
fn a_web_server_that_fails_is_asked_again() {
    let baked = Baked::new();
    let server = baked.serve();
    let solid = baked.solid;
    let open = || ZarrSource::open(&server.address, Path::new("/"));
    for answers in [
        &[Answer::Right, Answer::Status(500), Answer::Right, Answer::Status(500)][..],
        &[Answer::Right, Answer::Half, Answer::Right, Answer::Half],
        &[Answer::Status(500), Answer::Half, Answer::Right],
    ] {
        server.answers(Plan::Then(answers.to_vec()));
        assert_eq!(open().unwrap().try_chunk(solid.0, solid.1).as_ref(), Ok(baked.content(solid)), "{answers:?}");
    }
}
