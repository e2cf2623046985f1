//! Baked stores that are damaged at random, asked through the library: every answer is exact, or names the chunk that is unavailable.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod project;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use project::{Project, Sessions};
use raxel_bake::{BakePart, FolderStore, Plan, bake};
use raxel_diagnostics::{DiskFiles, MemoryFiles, SourceMap};
use raxel_edit::EditError;
use raxel_edit::query::{cast, collide, histogram, overlaps};
use raxel_ray::Ray;
use raxel_runtime::world::SessionWorld;
use raxel_runtime::{Options, Session};
use raxel_testing::files;
use raxel_world::random::SplitMix64;
use raxel_world::{Bounds, Cause, ChunkPos, ChunkProvider, Content, Unavailable};
use raxel_worldfile::Effort;

/// Levels of detail in a store.
const LEVELS: u32 = 2;

const LAND: &str = include_str!("fixtures/stores/land.toml");

const WORLD: &str = "[stream]\nsource = \"zarr:store\"\nnear = 64\n";

/// A store of two chunks along each axis, in shards of an edge, and more of them where the shards are larger.
struct Baked {
    folder: tempfile::TempDir,
    edge: u32,
    plan: Plan,
}

impl Baked {
    fn new(seed: u32, edge: u32) -> Self {
        let files = MemoryFiles::new([("land.toml", LAND.replace("seed = 0", &format!("seed = {seed}")))]);
        let land = raxel_worldfile::load("land.toml", &files, &mut SourceMap::default()).expect("it is right").0;
        let land = land.stream.expect("it is streamed").generator;
        let region = Bounds { min: [-64; 3], max: [64; 3] };
        let fingerprint = format!("{seed:08x}");
        let plan = Plan::new("land", &fingerprint, land.materials().to_vec(), region, edge, LEVELS).unwrap();
        let folder = tempfile::tempdir().unwrap();
        bake(&*land, &plan, BakePart::Whole, &FolderStore::new(folder.path().join("store")), &mut |_, _| {}).unwrap();
        fs::write(folder.path().join("world.toml"), WORLD).unwrap();
        Self { folder, edge, plan }
    }

    /// The store, and every object of it.
    fn objects(&self) -> Vec<(String, Vec<u8>)> {
        files(&self.folder.path().join("store"))
    }

    /// The object that a tile is in; `None` outside of the region.
    fn object(&self, level: u32, pos: ChunkPos) -> Option<String> {
        let (of, chunks) = (&self.plan.levels()[level as usize], (self.edge / 64) as i32);
        let pos = [pos.x, pos.y, pos.z];
        let at: [i32; 3] = std::array::from_fn(|axis| pos[axis].div_euclid(chunks) - of.first[axis]);
        let inside = (0..3).all(|axis| (0..of.shards[axis] as i32).contains(&at[axis]));
        inside.then(|| format!("{level}/c/{}/{}/{}", at[2], at[1], at[0]))
    }
}

fn load(folder: &Path) -> Result<SessionWorld, String> {
    let files = DiskFiles::new(folder).unwrap();
    let loaded = SessionWorld::load("world.toml", &files, &mut SourceMap::default(), Effort::Whole);
    loaded.map(|(world, _)| world).map_err(|diagnostics| {
        let said: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.message.as_str()).collect();
        said.join("; ")
    })
}

fn tiles() -> impl Iterator<Item = (u32, ChunkPos)> {
    let axis = -3..3;
    let at = move |level| {
        let axis = axis.clone();
        axis.clone().flat_map(move |x| {
            let axis = axis.clone();
            axis.clone().flat_map(move |y| axis.clone().map(move |z| (level, ChunkPos::new(x, y, z))))
        })
    };
    (0..LEVELS).flat_map(at)
}

/// Damages a few objects of a store.
fn damage(random: &mut SplitMix64, store: &Path, other: &Path, names: &[String]) {
    let mut below = |end: usize| random.below(end as u64) as usize;
    for _ in 0..=below(4) {
        // A document in one of six.
        let path = match below(6) {
            0 => store.join("zarr.json"),
            _ => store.join(&names[below(names.len())]),
        };
        let Ok(mut bytes) = fs::read(&path) else { continue };
        let at = below(bytes.len().max(1));
        // Headers and indices are hit as often as other places.
        let at = if below(2) == 0 { at } else { bytes.len().saturating_sub(1 + below(200)) };
        let length = (bytes.len() - at).min(1 + below(64));
        match below(10) {
            0 | 1 if !bytes.is_empty() => bytes[at] ^= 1u8 << below(8),
            2 => bytes.truncate(at),
            3 => bytes[at..at + length].fill(0),
            4 => bytes[at..at + length].fill_with(|| below(256) as u8),
            5 => bytes.extend((0..=below(300)).map(|n| n as u8)),
            6 => drop(bytes.drain(at..at + length)),
            // The same place in another world, and another place in the same one.
            7 => bytes = fs::read(other.join(path.strip_prefix(store).unwrap())).unwrap_or_default(),
            8 => bytes = fs::read(store.join(&names[below(names.len())])).unwrap_or_default(),
            _ => {
                fs::remove_file(&path).unwrap();
                if below(3) == 0 {
                    fs::create_dir(&path).unwrap();
                }
                continue;
            }
        }
        fs::write(&path, bytes).unwrap();
    }
}

/// The answers of the whole store, and the parts that may be unavailable in a damaged one.
struct Judge<'a> {
    baked: &'a Baked,
    whole: &'a SessionWorld,
    /// Every tile of it, in the order of [`tiles`].
    contents: &'a [Content],
    damaged: BTreeSet<String>,
    answers: &'a [[AtomicUsize; 2]; 5],
}

impl Judge<'_> {
    /// An answer is the right one, or names a chunk in a damaged shard.
    fn judge<T: PartialEq + std::fmt::Debug>(&self, query: usize, found: Result<T, Unavailable>, whole: &T) {
        self.answers[query][usize::from(found.is_ok())].fetch_add(1, Ordering::Relaxed);
        match found {
            Ok(found) => assert!(found == *whole, "query {query}: {found:?}, not {whole:?}"),
            Err(error) => {
                let object = self.baked.object(error.level, error.pos).expect("it is in the region");
                assert!(self.damaged.contains(&object), "{error}, and `{object}` is whole");
                assert!(matches!(error.cause, Cause::Damaged | Cause::Missing | Cause::Failing), "{error}");
                assert!(error.reason.contains("`store`") && error.reason.contains(&object), "{error}");
            }
        }
    }

    fn ask(&self, found: &SessionWorld, random: &mut SplitMix64) {
        let (whole, found) = (self.whole.newest(), (found.newest(), found.tiles().unwrap()));
        for ((level, pos), content) in tiles().zip(self.contents) {
            self.judge(0, ChunkProvider::try_chunk(&**found.1, level, pos), content);
            if level == 0 {
                self.judge(0, found.0.try_chunk(pos), &content.to_chunk());
            }
        }
        for _ in 0..30 {
            let cell = std::array::from_fn(|_| random.below(160) as i32 - 80);
            let ray = Ray::new(cell, [0.5; 3], std::array::from_fn(|_| random.below(2001) as f32 / 1000.0 - 1.0));
            let reach = random.below(300) as f64;
            self.judge(1, cast(found.0, &ray, reach), &cast(whole, &ray, reach).unwrap());
            let min: [i64; 3] = std::array::from_fn(|_| random.below(40_000) as i64 - 20_000);
            let corners = [min, min.map(|c| c + 500)];
            let motion = std::array::from_fn(|_| random.below(20_000) as i64 - 10_000);
            self.judge(2, collide(found.0, corners, motion), &collide(whole, corners, motion).unwrap());
            self.judge(3, overlaps(found.0, corners), &overlaps(whole, corners).unwrap());
            let min: [i64; 3] = std::array::from_fn(|_| random.below(150) as i64 - 75);
            let bounds = Bounds { min, max: min.map(|c| c + 1 + random.below(40) as i64) };
            let counted = histogram(found.0, &bounds).map_err(|error| match error {
                EditError::Unavailable(unavailable) => unavailable,
                error => panic!("{error}"),
            });
            self.judge(4, counted, &histogram(whole, &bounds).unwrap());
        }
    }
}

fn copy(objects: &[(String, Vec<u8>)], store: &Path) {
    for (name, bytes) in objects {
        let path: PathBuf = store.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
}

#[test]
fn every_answer_of_a_damaged_store_is_exact_or_names_a_chunk() {
    const STORES: u64 = 200;
    let baked = [64, 128].map(|edge| Baked::new(5, edge));
    let others = [64, 128].map(|edge| Baked::new(6, edge));
    let answers: [[AtomicUsize; 2]; 5] = Default::default();
    let (refused, next) = (AtomicUsize::new(0), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let whole = baked.each_ref().map(|baked| load(baked.folder.path()).unwrap());
                let contents = whole.each_ref().map(|whole| {
                    let tile = |(level, pos)| ChunkProvider::try_chunk(&**whole.tiles().unwrap(), level, pos).unwrap();
                    tiles().map(tile).collect::<Vec<_>>()
                });
                loop {
                    let round = next.fetch_add(1, Ordering::Relaxed) as u64;
                    if round >= STORES {
                        return;
                    }
                    let mut random = SplitMix64::new(2200 + round);
                    let kind = usize::from(random.below(20) == 0);
                    let folder = tempfile::tempdir().unwrap();
                    let store = folder.path().join("store");
                    let objects = baked[kind].objects();
                    let names: Vec<String> = objects.iter().map(|(name, _)| name.clone()).collect();
                    copy(&objects, &store);
                    fs::write(folder.path().join("world.toml"), WORLD).unwrap();
                    damage(&mut random, &store, &others[kind].folder.path().join("store"), &names);
                    let now = files(&store);
                    let damaged = objects.iter().filter(|object| !now.contains(object)).map(|(name, _)| name.clone());
                    let damaged: BTreeSet<String> = damaged.collect();
                    let (baked, whole, contents) = (&baked[kind], &whole[kind], &contents[kind]);
                    let judge = Judge { baked, whole, contents, damaged, answers: &answers };
                    match load(folder.path()) {
                        Ok(found) => {
                            // A document that was replaced by that of the other world is whole: all of its shards are others.
                            let fingerprint = |world: &SessionWorld| {
                                world.streamed().unwrap().generator.fingerprint().map(str::to_owned)
                            };
                            if fingerprint(&found) == fingerprint(judge.whole) {
                                judge.ask(&found, &mut random);
                            } else {
                                let inside = |(level, pos)| judge.baked.object(level, pos).is_some();
                                let made =
                                    |(level, pos)| ChunkProvider::try_chunk(&**found.tiles().unwrap(), level, pos);
                                let replaced = |tile: &(u32, ChunkPos)| {
                                    judge.damaged.contains(&judge.baked.object(tile.0, tile.1).unwrap())
                                };
                                assert!(
                                    tiles()
                                        .filter(|tile| inside(*tile) && !replaced(tile))
                                        .all(|tile| made(tile).is_err())
                                );
                            }
                        }
                        Err(said) => {
                            assert!(judge.damaged.contains("zarr.json") && said.contains("`store`"), "{said}");
                            refused.fetch_add(1, Ordering::Relaxed);
                        }
                    }
                }
            });
        }
    });
    let answers = answers.map(|query| query.map(AtomicUsize::into_inner));
    let refused = refused.into_inner();
    println!("{STORES} stores: {refused} refused; unavailable and answered, by query: {answers:?}");
    // The test would pass with stores that are never damaged, or never answer.
    assert!(refused > 20 && answers.iter().all(|[refused, answered]| *refused > 50 && *answered > 500));
}

#[test]
fn a_session_names_the_chunk_that_is_unavailable() {
    let baked = Baked::new(5, 64);
    let project = Project::filled();
    copy(&baked.objects(), &project.path("store"));
    project.write("worlds/land.toml", WORLD);
    let options = || Options {
        graph: Some("graphs/fill.toml".into()),
        world: Some("worlds/land.toml".into()),
        ..project.options()
    };
    // The lamp is around (0, 20, 0): this chunk has a quarter of it.
    let (pos, object) = (ChunkPos::new(0, 0, 0), "0/c/1/1/1");
    assert_eq!(baked.object(0, pos).as_deref(), Some(object));
    let whole = fs::read(project.path("store").join(object)).unwrap();
    for cut in [0, whole.len() / 2, whole.len()] {
        fs::write(project.path("store").join(object), &whole[..cut]).unwrap();
        let mut session: Session = Project::open_with(options());
        session.frame().unwrap();
        let mut camera = *session.camera();
        camera.place(glam::DVec3::new(30.0, 20.5, 30.0));
        camera.look_at([0.0, 20.5, 0.0]);
        session.set_camera(camera);
        let bounds = Bounds { min: [1, 18, 1], max: [5, 22, 5] };
        let found = [
            session.world().newest().try_chunk(pos).map(|_| ()),
            session.pick([8, 8], 100.0).map(|hit| assert!(hit.is_some())),
            session.region(&bounds).map(|_| ()).map_err(|error| match error {
                EditError::Unavailable(unavailable) => unavailable,
                error => panic!("{error}"),
            }),
        ];
        for found in found {
            match found {
                Ok(()) => assert_eq!(cut, whole.len()),
                Err(error) => {
                    assert!(cut < whole.len() && error.pos == pos && error.reason.contains(object), "{error}");
                }
            }
        }
        assert!(session.world().newest().try_chunk(ChunkPos::new(9, 0, 0)) == Ok(None));
        project::assert_silent(&session);
    }
}

/// A tile outside of the region is empty in every store, damaged or not.
#[test]
fn around_a_store_there_is_air() {
    let baked = Baked::new(5, 64);
    let world = load(baked.folder.path()).unwrap();
    let outside = tiles().filter(|(level, pos)| baked.object(*level, *pos).is_none());
    let tiles: &Arc<_> = world.tiles().unwrap();
    assert!(outside.into_iter().all(|(level, pos)| tiles.try_chunk(level, pos) == Ok(Content::Empty)));
}
