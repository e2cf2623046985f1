//! Changes that come faster than they can be shown, and changes that come while a worker makes their tiles.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::IVec3;
use raxel_oracle::port::Tree64;
use raxel_stream::{Publication, StreamOptions, Streamer, StreamingRange, View};
use raxel_testing::Words;
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Unavailable, World, child_cell};
use raxel_worldfile::StreamSettings;

const PATIENCE: Duration = Duration::from_secs(120);

/// Chunks in a row that change.
const CHUNKS: i32 = 8;

/// Chunks that say how often they have changed: a voxel in the 16³ node n for bit n of the number, and always one in the last node.
struct Counted(Vec<Material>, AtomicU64);

impl Counted {
    fn chunk(&self, _level: u32, pos: ChunkPos) -> Content {
        if !(0..CHUNKS).contains(&pos.x) || pos.y != 0 || pos.z != 0 {
            return Content::Empty;
        }
        let mut dense = DenseChunk::default();
        let bits = 1 << 63 | self.1.load(Ordering::Acquire);
        for node in (0..64).filter(|node| bits >> node & 1 == 1) {
            let [x, y, z] = child_cell(node).map(|c| 16 * c);
            dense.set(x, y, z, 1);
        }
        Content::pack(&dense)
    }
}

impl ChunkProvider for Counted {
    fn materials(&self) -> &[Material] {
        &self.0
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.chunk(level, pos))
    }
}

/// The mark of each chunk that a frame sees.
fn seen(words: &[u32], publication: &Publication) -> Vec<u64> {
    let header = publication.words();
    let body = &words[header.len()..];
    let mut found = Vec::new();
    let mut open = vec![(header[12] as usize, header[3] >> 1)];
    while let Some((at, height)) = open.pop() {
        let node = &body[4 * at..][..4];
        let mask = u64::from(node[0]) | u64::from(node[1]) << 32;
        if height == 3 {
            found.push(mask & !(1 << 63));
        } else {
            open.extend((0..mask.count_ones() as usize).map(|rank| (node[2] as usize + rank, height - 1)));
        }
    }
    found
}

/// A frame that waits for an edit gets it, even if no frame has taken the publication before.
#[test]
fn an_edit_overtakes_what_no_frame_has_taken() {
    let materials = vec![Material::air(), Material::matt("a", [0.5; 3])];
    let source = Arc::new(Counted(materials, AtomicU64::new(0)));
    let memory = Words::new(1 << 20);
    let reach = StreamingRange::of(&StreamSettings { near: 640, far: 640, ..StreamSettings::default() }, [0, 64]);
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: true };
    let view = View::at(IVec3::new(256, 40, 0));
    let streamer = Streamer::new(source.clone(), memory.clone(), 1 << 20, reach, view, options);
    let began = Instant::now();
    while !streamer.has_pending() {
        assert!(began.elapsed() < PATIENCE, "{:?}", streamer.stats());
        std::thread::sleep(Duration::from_millis(1));
    }
    for number in 1..=20 {
        source.1.store(number, Ordering::Release);
        let change = streamer.changed(&[ChunkPos::new(3, 0, 0)]);
        // The publication before the edit is there to be taken, or was just taken.
        let taken = streamer.take_with(change, PATIENCE).expect("there is a publication");
        assert!(taken.changes >= change, "{} of {change}", taken.changes);
        let words = memory.all();
        let mut frame = words.clone();
        frame[..taken.words().len()].copy_from_slice(taken.words());
        assert!(seen(&frame, &taken).contains(&number), "{number} in {:?}", seen(&frame, &taken));
        drop(words);
        streamer.released(taken.version);
    }
    let late = streamer.take_with(streamer.changed(&[ChunkPos::new(3, 0, 0)]) + 1, Duration::from_millis(1));
    assert!(late.is_none_or(|taken| taken.changes <= 21), "nothing shows a change that is not there");
}

#[test]
fn changes_without_end_are_shown_in_order_while_they_go_on() {
    let materials = vec![Material::air(), Material::matt("a", [0.5; 3])];
    let source = Arc::new(Counted(materials, AtomicU64::new(0)));
    let memory = Words::new(1 << 20);
    let reach = StreamingRange::of(&StreamSettings { near: 640, far: 640, ..StreamSettings::default() }, [0, 64]);
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: true };
    let view = View::at(IVec3::new(256, 40, 0));
    let streamer = Streamer::new(source.clone(), memory.clone(), 1 << 20, reach, view, options);
    let began = Instant::now();
    while !streamer.is_settled() {
        assert!(began.elapsed() < PATIENCE, "{:?}", streamer.stats());
        streamer.take().inspect(|publication| streamer.released(publication.version));
        std::thread::sleep(Duration::from_millis(1));
    }
    let all: Vec<ChunkPos> = (0..CHUNKS).map(|x| ChunkPos::new(x, 0, 0)).collect();
    let (mut shown, mut least, mut steps) = (0, 0, 0);
    let mut look = |publication: &Publication| {
        let words = memory.all();
        let seen = seen(&words, publication);
        assert_eq!(seen.len(), CHUNKS as usize);
        let oldest = seen.iter().copied().min().unwrap();
        assert!(publication.changes >= shown && oldest >= publication.changes, "{publication:?} {seen:?} {shown}");
        assert!(oldest >= least, "a chunk went back: {seen:?} after {least}");
        steps += u32::from(publication.changes > shown);
        (shown, least) = (publication.changes, oldest);
        streamer.released(publication.version);
        steps
    };
    // Each change comes before anybody has seen the one before it, unless this thread was stopped for so long.
    let mut newest = 0;
    for number in 1.. {
        source.1.store(number, Ordering::Release);
        assert_eq!(streamer.changed(&all), number);
        if let Some(publication) = streamer.take() {
            newest = publication.changes;
            if look(&publication) >= 20 {
                break;
            }
        }
        assert!(began.elapsed() < PATIENCE, "changes are not shown while more of them come: {:?}", streamer.stats());
    }
    let last = source.1.load(Ordering::Acquire);
    while newest < last {
        if let Some(publication) = streamer.take() {
            newest = publication.changes;
            look(&publication);
        }
        assert!(began.elapsed() < PATIENCE, "{:?}", streamer.stats());
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The tile whose maker waits, the sender that says that it does, and the receiver that lets it go on.
type Hold = ((u32, ChunkPos), Sender<()>, Receiver<()>);

/// A world before and after an edit. One tile comes late: as it was when the worker asked for it.
struct Held {
    worlds: [World; 2],
    is_edited: AtomicBool,
    late: Mutex<Option<Hold>>,
}

impl ChunkProvider for Held {
    fn materials(&self) -> &[Material] {
        self.worlds[0].materials()
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        let content = self.worlds[usize::from(self.is_edited.load(Ordering::Acquire))].tile(level, pos);
        let late = self.late.lock().unwrap().take_if(|(of, ..)| *of == (level, pos));
        if let Some((_, asked, go_on)) = late {
            asked.send(()).unwrap();
            go_on.recv_timeout(PATIENCE).unwrap();
        }
        Ok(content)
    }
}

/// The event while a worker makes a tile of the chunk that changes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meanwhile {
    Change,
    /// As before the first frame of a part of a film.
    ChangeAndMove,
    /// The camera is back before the worker is done.
    ChangeWhileAway,
}

/// The edits of a film's part come before its first frame, while the tiles around the camera are loading.
#[test]
fn a_change_of_a_chunk_that_a_worker_makes_for_the_first_time_is_shown() {
    use Meanwhile::{Change, ChangeAndMove, ChangeWhileAway};
    // The second chunk is so far away that its tile of level 1 is shown.
    for (level, chunk) in [(0, 3), (1, 12)].map(|(level, x)| (level, ChunkPos::new(x, 0, 0))) {
        for meanwhile in [Change, ChangeAndMove, ChangeWhileAway] {
            let cube = |material| {
                let cells = (0..512).map(|i| IVec3::new(64 * chunk.x + i % 8, i / 8 % 8, i / 64));
                let materials = ["none", "before", "after"].map(|name| Material::matt(name, [0.5; 3]));
                World::from_voxels(materials.into(), cells.map(|cell| (cell, material)))
            };
            let (asked, was_asked) = channel();
            let (go, go_on) = channel();
            let tile = (level, ChunkPos::new(chunk.x >> (2 * level), 0, 0));
            let late = Mutex::new(Some((tile, asked, go_on)));
            let source = Arc::new(Held { worlds: [1, 2].map(cube), is_edited: AtomicBool::new(false), late });
            let memory = Words::new(1 << 20);
            let reach =
                StreamingRange::of(&StreamSettings { near: 320, far: 1280, ..StreamSettings::default() }, [0, 64]);
            let options = StreamOptions { workers: 2, complete: true, upload: None, poison: true };
            let [here, beside, away] = [256, 320, 100_000].map(|x| View::at(IVec3::new(x, 40, 0)));
            let streamer = Streamer::new(source.clone(), memory.clone(), 1 << 20, reach, here, options);
            // The director takes each event in a turn of its own.
            let looked = || {
                let began = Instant::now();
                while !streamer.has_looked() {
                    assert!(began.elapsed() < PATIENCE, "{:?}", streamer.stats());
                    std::thread::sleep(Duration::from_millis(1));
                }
            };
            was_asked.recv_timeout(PATIENCE).unwrap();
            if meanwhile == ChangeWhileAway {
                streamer.follow(away);
                looked();
            }
            source.is_edited.store(true, Ordering::Release);
            streamer.changed(&[chunk]);
            looked();
            streamer.follow(if meanwhile == ChangeAndMove { beside } else { here });
            looked();
            assert!(!streamer.is_settled(), "{meanwhile:?}, level {level}: a tile is still being made");
            go.send(()).unwrap();
            streamer.wait(PATIENCE).unwrap();
            let taken = streamer.take().expect("a publication of everything");
            let mut words = memory.all();
            words[..taken.words().len()].copy_from_slice(taken.words());
            let shown = Tree64::new(&words).material([64 * chunk.x + 3, 3, 3]);
            assert_eq!(shown, 2, "{meanwhile:?}, level {level}: the chunk is shown as it was before its edit");
        }
    }
}
