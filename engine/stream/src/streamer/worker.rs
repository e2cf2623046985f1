//! Makes tiles, one after the other.

use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Instant;

use raxel_world::layout::{TileBlock, TileNode};
use raxel_world::{Content, Unavailable};

use super::{Job, Shared};
use crate::directory::LiveTile;
use crate::pool::Block;
use crate::reach::TileKey;

/// A tile that was made.
pub(super) struct Made {
    pub(super) key: TileKey,
    pub(super) tile: Result<(LiveTile, Option<Block>), Unmade>,
    /// Bytes written.
    pub(super) bytes: u64,
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
        let mut desk = shared.desk();
        let job = loop {
            if shared.stop.load(Ordering::Acquire) {
                return;
            }
            match desk.jobs.pop() {
                Some(job) => break job,
                None => desk = shared.work.wait(desk).unwrap_or_else(PoisonError::into_inner),
            }
        };
        desk.in_work.insert(job.key);
        drop(desk);

        let made = make(shared, job);

        let mut desk = shared.desk();
        desk.in_work.remove(&job.key);
        desk.made.push(made);
        // The director looks when there is enough for it to do, or nothing else to wait for.
        if desk.made.len() == 1 || desk.jobs.is_empty() {
            shared.news.notify_one();
        }
    }
}

fn make(shared: &Shared, Job { key, stale }: Job) -> Made {
    let content = match shared.source.try_chunk(key.level, key.pos) {
        Ok(content) => content,
        Err(reason) => return Made { key, tile: Err(Unmade::Unavailable(reason)), bytes: 0 },
    };
    let block = match TileBlock::of(&content, key.level) {
        Err(node) => return Made { key, tile: Ok((LiveTile { node, children: [].into() }, None)), bytes: 0 },
        Ok(block) => block,
    };
    debug_assert!(matches!(content, Content::Chunk(_)));
    let Some(place) = shared.pool.allocate_tile(block.words()) else {
        return Made { key, tile: Err(Unmade::NoRoom), bytes: 0 };
    };
    let (words, node) = block.encode(shared.pool.address(&place), shared.pool.full_run());
    wait_for_frame(shared, 4 * words.len() as u64, stale);
    shared.pool.write(&place, &words);
    // A part of a coarse tile may be shown beside finer ones: then the directory has copies of its nodes.
    let children = if key.level == 0 {
        [].into()
    } else {
        let count = node.mask().count_ones() as usize;
        words.chunks_exact(4).take(count).map(|quad| TileNode([quad[0], quad[1], quad[2], quad[3]])).collect()
    };
    Made { key, tile: Ok((LiveTile { node: Some(node), children }, Some(place))), bytes: 4 * words.len() as u64 }
}

/// Waits until a frame may bring so many bytes; what was edited is brought at once.
fn wait_for_frame(shared: &Shared, bytes: u64, stale: bool) {
    let mut desk = shared.desk();
    while !stale && !shared.stop.load(Ordering::Acquire) {
        let Some(wait) = desk.allowance.wait(Instant::now()) else { break };
        desk = shared.allowed.wait_timeout(desk, wait).unwrap_or_else(PoisonError::into_inner).0;
    }
    desk.allowance.spend(bytes);
}
