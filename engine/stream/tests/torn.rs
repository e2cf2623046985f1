//! Every word that a frame can reach, in thousands of publications in a row: each belongs to the tiles of that publication until the last
//! frame reads it, while other tiles are written, given up and overwritten with poison.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::collections::{HashMap, VecDeque};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::IVec3;
use raxel_layouts::{FULL_RUN_WORDS, MATERIAL_WORDS, TileBlock, TileNode};
use raxel_stream::{Publication, StreamOptions, Streamer, StreamingRange, View};
use raxel_testing::{ReachableSet, Words};
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Mode, Unavailable};
use raxel_worldfile::StreamSettings;

const PATIENCE: Duration = Duration::from_secs(120);
const HEADER: usize = 16;
const WORDS: u32 = 1 << 20;
/// Frames that the device has not finished.
const IN_FLIGHT: usize = 3;

/// A world without end of small things in five materials, different in every chunk; some chunks are empty, and some full.
struct Endless(Vec<Material>);

impl Endless {
    fn chunk(pos: ChunkPos) -> Content {
        let seed = [pos.x, pos.y, pos.z].iter().fold(7u64, |seed, c| {
            (seed ^ u64::from(c.cast_unsigned())).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
        });
        let mut random = SplitMix64::new(seed);
        match random.below(8) {
            0 => return Content::Empty,
            1 => return Content::Full(1 + random.below(5) as u16),
            _ => {}
        }
        let mut dense = DenseChunk::default();
        for _ in 0..40 {
            let block = random.below(4096) as usize;
            dense.apply(block, u64::MAX, Mode::Add, 1 + random.below(5) as u16);
            dense.apply(block, random.bits(), Mode::Add, 1 + random.below(5) as u16);
            dense.apply(random.below(4096) as usize, random.bits(), Mode::Add, 1 + random.below(5) as u16);
        }
        Content::pack(&dense)
    }
}

impl ChunkProvider for Endless {
    fn materials(&self) -> &[Material] {
        &self.0
    }

    fn try_chunk(&self, _: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(Self::chunk(pos))
    }
}

/// The expected chunk in the buffer: by its place there, or by its node where it has none.
struct Expected {
    node: TileNode,
    words: Vec<u32>,
}

/// Walks all that a publication reaches. Returns how many chunks, and how many words.
fn check(
    source: &Endless,
    memory: &Words,
    publication: &Publication,
    known: &mut HashMap<(ChunkPos, u32), Expected>,
) -> (usize, usize) {
    let words = memory.all();
    let body = &words[HEADER..];
    let header = publication.header;
    let full_run = (MATERIAL_WORDS * source.0.len() as u32).next_multiple_of(4);
    assert!(body[full_run as usize..][..FULL_RUN_WORDS as usize].iter().all(|word| *word == u32::MAX));
    let reached = ReachableSet::of(&header, body);
    let mut count = reached.nodes.iter().map(Range::len).sum();
    for &(pos, node) in &reached.chunks {
        let first = if node.filled_material().is_some() { 0 } else { 4 * node.0[2] };
        let expected = known.entry((pos, first)).or_insert_with(|| {
            let content = Endless::chunk(pos);
            match TileBlock::of(&content, 0) {
                Ok(block) => {
                    let (words, node) = block.encode(first, full_run);
                    Expected { node, words }
                }
                Err(node) => Expected { node: node.expect("an empty chunk is not reached"), words: Vec::new() },
            }
        });
        assert_eq!(node, expected.node, "chunk {pos:?} of version {}", publication.version);
        let found = &body[first as usize..][..expected.words.len()];
        assert!(found == expected.words, "the words of chunk {pos:?} of version {} are torn", publication.version);
        count += expected.words.len();
    }
    (reached.chunks.len(), count)
}

/// So many publications in a row, each checked when it is the oldest that a frame may read.
fn fly(publications: usize) {
    let source = Arc::new(Endless(
        std::iter::once(Material::air()).chain((1..6).map(|n| Material::matt(format!("m{n}"), [0.5; 3]))).collect(),
    ));
    let settings = StreamSettings { near: 128, far: 128, ..StreamSettings::default() };
    let reach = StreamingRange::of(&settings, [-128, 128]);
    let memory = Words::new(WORDS);
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: true };
    let streamer = Streamer::new(source.clone(), memory.clone(), WORDS, reach, View::at(IVec3::ZERO), options);
    let mut random = SplitMix64::new(3);
    let mut camera = IVec3::ZERO;
    let mut in_flight: VecDeque<Arc<Publication>> = VecDeque::new();
    let mut known = HashMap::new();
    let (mut chunks, mut reached, mut moves) = (0, 0, 0);
    for frame in 0..publications {
        let until = Instant::now() + PATIENCE;
        let taken = loop {
            if let Some(taken) = streamer.take() {
                break taken;
            }
            // Everything is there: on to the next place.
            if streamer.is_settled() {
                let mut by = |range: i32| random.below(2 * range as u64 + 1) as i32 - range;
                moves += 1;
                let jump = if moves % 2 == 0 { 3000 } else { 130 };
                camera = (camera + IVec3::new(by(jump), by(40), by(jump)))
                    .clamp(IVec3::splat(-100_000), IVec3::splat(100_000));
                camera.y = camera.y.clamp(-100, 100);
                streamer.follow(View::at(camera));
            }
            assert!(Instant::now() < until, "frame {frame}: {:?}", streamer.stats());
            std::thread::yield_now();
        };
        in_flight.push_back(taken);
        if in_flight.len() > IN_FLIGHT {
            in_flight.pop_front();
            streamer.released(in_flight[0].version);
        }
        let (of_this, words) = check(&source, &memory, &in_flight[0], &mut known);
        (chunks, reached) = (chunks + of_this, reached + words);
        if known.len() > 4000 {
            known.clear();
        }
    }
    assert!(chunks > 5 * publications && reached > 2_000 * publications, "{chunks} chunks, {reached} words");
    assert!(streamer.stats().dropped > 20, "{:?}", streamer.stats());
}

#[test]
fn no_word_that_a_frame_reaches_is_ever_another() {
    fly(300);
}

#[test]
#[ignore = "takes minutes"]
fn no_word_is_ever_another_in_ten_thousand_publications() {
    fly(10_000);
}
