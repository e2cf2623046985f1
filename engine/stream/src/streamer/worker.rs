//! Makes tiles, one after the other.

use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::Instant;

use raxel_layouts::lights::{LIGHT_WORDS, LightGroup, TileLights};
use raxel_layouts::{TileBlock, TileNode};
use raxel_world::{Bounds, Cause, Content, Side, Unavailable};

use super::threads::{caught, planted};
use super::{Job, Shared};
use crate::pool::PoolBlock;
use crate::reach::TileKey;
use crate::tile_directory::LiveTile;

/// A tile that was made.
pub(super) struct Made {
    pub(super) key: TileKey,
    pub(super) tile: Result<(LiveTile, Option<PoolBlock>), Unmade>,
    pub(super) lamps: MadeLamps,
    /// Bytes written.
    pub(super) bytes: u64,
    /// The first change since the worker began, if there was one: the tile may be without it.
    pub(super) outdated: Option<u64>,
}

/// The lamps of a tile that was made.
#[derive(Default)]
pub(super) struct MadeLamps {
    pub(super) block: Option<PoolBlock>,
    /// The faces of the tile that something touches which gives off light.
    pub(super) sides: u8,
    /// Words of them that there was no room for.
    pub(super) left_out: u32,
}

/// Why a tile was not made.
pub(super) enum Unmade {
    /// The pool had no room for it.
    NoRoom,
    /// The source does not have it for the time being.
    Unavailable(Unavailable),
}

pub(super) fn run(shared: &Shared) {
    loop {
        let mut state = shared.state();
        let job = loop {
            if shared.stop.load(Ordering::Acquire) {
                return;
            }
            match state.jobs.pop() {
                Some(job) => break job,
                None => state = shared.work.wait(state).unwrap_or_else(PoisonError::into_inner),
            }
        };
        state.in_work.insert(job.key, None);
        drop(state);
        assert!(!planted("worker"), "a planted fault");

        let made = make(shared, job);

        let mut state = shared.state();
        let outdated = state.in_work.remove(&job.key).flatten();
        state.made.push(Made { outdated, ..made });
        // The director looks when there is enough for it to do, or nothing else to wait for.
        if state.made.len() == 1 || state.jobs.is_empty() {
            shared.news.notify_one();
        }
    }
}

fn make(shared: &Shared, Job { key, stale }: Job) -> Made {
    let unmade = |why| Made { key, tile: Err(why), lamps: MadeLamps::default(), bytes: 0, outdated: None };
    // The source is the code of others, and may be wrong for one tile alone. Nothing is taken from the pool yet.
    let asked = caught(|| {
        assert!(!planted("source"), "a planted fault");
        let content = shared.source.try_chunk(key.level, key.pos)?;
        let lights = lights(shared, key, &content);
        Ok((content, lights))
    });
    let (content, lights) = match asked {
        Ok(Ok(asked)) => asked,
        Ok(Err(reason)) => return unmade(Unmade::Unavailable(reason)),
        Err(panic) => {
            return unmade(Unmade::Unavailable(Unavailable::new(key.level, key.pos, Cause::Panicked, panic)));
        }
    };
    let (node, children, place, bytes) = match TileBlock::of(&content, key.level) {
        Err(node) => (node, [].into(), None, 0),
        Ok(block) => {
            debug_assert!(matches!(content, Content::Chunk(_)));
            let Some(place) = shared.pool.allocate_tile(block.words()) else { return unmade(Unmade::NoRoom) };
            let (words, node) = block.encode(shared.pool.address(&place), shared.pool.full_run());
            let bytes = 4 * words.len() as u64;
            wait_for_frame(shared, bytes, stale);
            shared.pool.write(&place, &words);
            // A part of a coarse tile may be shown beside finer ones: then the directory has copies of its nodes.
            let count = if key.level == 0 { 0 } else { node.mask().count_ones() as usize };
            let children = words.chunks_exact(4).take(count).map(|quad| TileNode([quad[0], quad[1], quad[2], quad[3]]));
            (Some(node), children.collect(), Some(place), bytes)
        }
    };
    let (lamps, groups) = place_lights(shared, &lights, stale);
    let lamp_bytes = if lamps.block.is_some() { 4 * u64::from(lights.words()) } else { 0 };
    let cells = match &content {
        Content::Chunk(chunk) => chunk.bounds(),
        Content::Empty | Content::Full(_) => Bounds { min: [0; 3], max: [64; 3] },
    };
    let live = LiveTile { node, cells, children, lights: groups };
    Made { key, tile: Ok((live, place)), lamps, bytes: bytes + lamp_bytes, outdated: None }
}

/// The lamps of a tile. An unavailable chunk beyond a face counts as air: a false lamp only costs a ray, but a missing lamp shows in the picture.
fn lights(shared: &Shared, key: TileKey, content: &Content) -> TileLights {
    let Some(lamps) = &shared.lamps else { return TileLights::default() };
    let beside = |face| {
        let pos = key.pos.beside(face);
        shared.neighbor_faces.get(pos, face ^ 1, || match shared.source.try_chunk(key.level, pos) {
            Ok(content) => (Side::of(&content, face ^ 1), true),
            Err(_) => (Side::of(&Content::Empty, face ^ 1), false),
        })
    };
    TileLights::of(content, (key.level, key.pos), &lamps.powers, beside)
}

/// Puts the lamps of a tile into their list, if there is room.
fn place_lights(shared: &Shared, lights: &TileLights, stale: bool) -> (MadeLamps, Arc<[(u32, LightGroup)]>) {
    let made = MadeLamps { sides: lights.sides(), ..MadeLamps::default() };
    let Some(lamps) = shared.lamps.as_ref().filter(|_| !lights.is_empty()) else { return (made, [].into()) };
    let Some(place) = lamps.pool.allocate_tile(lights.words()) else {
        return (MadeLamps { left_out: lights.words(), ..made }, [].into());
    };
    let (words, groups) = lights.encode(lamps.pool.address(&place) / LIGHT_WORDS as u32);
    wait_for_frame(shared, 4 * words.len() as u64, stale);
    lamps.pool.write(&place, &words);
    (MadeLamps { block: Some(place), ..made }, groups.into())
}

/// Waits until a frame may bring `bytes` bytes; edited tiles are brought at once.
fn wait_for_frame(shared: &Shared, bytes: u64, stale: bool) {
    let mut state = shared.state();
    while !stale && !shared.stop.load(Ordering::Acquire) {
        let Some(wait) = state.budget.wait(Instant::now()) else { break };
        state = shared.allowed.wait_timeout(state, wait).unwrap_or_else(PoisonError::into_inner).0;
    }
    state.budget.spend(bytes);
}
