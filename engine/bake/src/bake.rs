//! Makes shards and writes them.

use std::time::Duration;

use raxel_world::{ChunkPos, ChunkProvider};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

use crate::metadata::{self, Baked, Unreadable};
use crate::part::BakePart;
use crate::plan::{CHUNK, Plan, ShardKey};
use crate::retry::retried;
use crate::seal::Seals;
use crate::shard::{self, ShardWriter};
use crate::store::{Store, StoreError, Wanted};

/// Pauses after which a store that has failed in passing is asked again.
const PAUSES: [Duration; 4] =
    [Duration::from_millis(200), Duration::from_secs(1), Duration::from_secs(5), Duration::from_secs(20)];

/// The work that a task has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Report {
    /// Shards of the part.
    pub shards: u64,
    /// Shards that were made and written.
    pub written: u64,
    /// The number of these that existed but were damaged.
    pub redone: u64,
    /// Shards that existed undamaged.
    pub skipped: u64,
    /// Chunks with solid cells in all of them.
    pub chunks: u64,
    /// Bytes of all of them.
    pub bytes: u64,
}

/// Why a task stops.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BakeError {
    /// The store has failed, for longer than it was tried again.
    #[error("the store has failed at {0}")]
    Store(#[from] StoreError),
    /// Another world is there.
    #[error(
        "the store holds the world `{there}` with the fingerprint {found}; this one is `{wanted_name}` with {wanted}"
    )]
    OtherWorld {
        /// Name of the world that is there.
        there: String,
        /// Its fingerprint.
        found: String,
        /// Name of this world.
        wanted_name: String,
        /// The fingerprint of this world.
        wanted: String,
    },
    /// The same world is there, cut in another way.
    #[error(
        "the store holds the same world, but `{key}` says that it was baked with another region, shard size or levels"
    )]
    OtherPlan {
        /// The document that differs.
        key: String,
    },
    /// A store that another version of raxel has baked.
    #[error("the store cannot be baked to: {0}")]
    OtherFormat(Unreadable),
    /// The tiles of the world cannot be had.
    #[error("the world is not there: {0}")]
    Source(#[from] raxel_world::Unavailable),
}

/// Makes the shards of a part and writes them to a store, with the documents of the arrays. Shards that are there and whole are left as
/// they are. `progress` hears of each shard when it is done, with the sums so far.
///
/// It holds the compressed bytes of one shard, and a chunk a thread.
pub fn bake(
    source: &dyn ChunkProvider,
    plan: &Plan,
    part: BakePart,
    store: &dyn Store,
    progress: &mut dyn FnMut(ShardKey, &Report),
) -> Result<Report, BakeError> {
    describe(plan, store)?;
    let mut report = Report::default();
    let seals = Seals::of(&Baked::of(plan));
    let chunks = (plan.edge / CHUNK).pow(3) as usize;
    for key in part.shards(plan) {
        let object = key.object();
        report.shards += 1;
        match get(store, &object)?.map(|bytes| (shard::check(&bytes, chunks, seals.of_shard(key)), bytes.len())) {
            Some((Ok(solid), bytes)) => {
                report.skipped += 1;
                report.chunks += solid;
                report.bytes += bytes as u64;
            }
            there => {
                let (writer, solid) = make(source, plan, key)?;
                let bytes = writer.finish(seals.of_shard(key));
                report.redone += u64::from(there.is_some());
                report.written += 1;
                report.chunks += solid;
                report.bytes += bytes.len() as u64;
                put(store, &object, &bytes)?;
            }
        }
        progress(key, &report);
    }
    Ok(report)
}

/// Writes the documents, or finds that they are there.
fn describe(plan: &Plan, store: &dyn Store) -> Result<(), BakeError> {
    // The group comes last: a store that has it has the others.
    for (key, document) in metadata::documents(plan).into_iter().rev() {
        let there = get(store, &key)?;
        if there.as_deref() == Some(&document) {
            continue;
        }
        // One that is no JSON was cut off.
        if let Some(there) = there
            && serde_json::from_slice::<serde_json::Value>(&there).is_ok()
        {
            let group = if key == metadata::GROUP { Some(there) } else { get(store, metadata::GROUP)? };
            let group = group.as_deref().map(Baked::read);
            // The group comes last: the arrays are those of this plan.
            if key == metadata::GROUP && matches!(group, Some(Err(Unreadable::Damaged { .. }))) {
                put(store, &key, &document)?;
                continue;
            }
            return Err(match group {
                Some(Err(other @ (Unreadable::Older { .. } | Unreadable::Newer { .. }))) => {
                    BakeError::OtherFormat(other)
                }
                Some(Ok(baked)) if baked.fingerprint != plan.fingerprint => BakeError::OtherWorld {
                    there: baked.world,
                    found: baked.fingerprint,
                    wanted_name: plan.name.clone(),
                    wanted: plan.fingerprint.clone(),
                },
                _ => BakeError::OtherPlan { key },
            });
        }
        put(store, &key, &document)?;
    }
    Ok(())
}

/// The chunks of a shard, and how many of them have solid cells.
fn make(source: &dyn ChunkProvider, plan: &Plan, key: ShardKey) -> Result<(ShardWriter, u64), BakeError> {
    let level = plan.levels()[key.level as usize];
    let edge = (plan.edge / CHUNK).cast_signed();
    let corner: [i32; 3] = std::array::from_fn(|axis| (level.first[axis] + key.at[axis].cast_signed()) * edge);
    let mut writer = ShardWriter::new();
    let mut solid = 0;
    for z in 0..edge {
        // A layer at a time: within a shard, the chunks above and below share a column.
        let layer: Result<Vec<Option<Vec<u8>>>, _> = (0..edge * edge)
            .into_par_iter()
            .map(|at| {
                let pos = ChunkPos::new(corner[0] + at % edge, corner[1] + at / edge, corner[2] + z);
                source.try_chunk(key.level, pos).map(|content| shard::encode(&content))
            })
            .collect();
        for chunk in layer? {
            solid += u64::from(chunk.is_some());
            writer.push(chunk.as_deref());
        }
    }
    Ok((writer, solid))
}

fn get(store: &dyn Store, key: &str) -> Result<Option<Vec<u8>>, StoreError> {
    retried(&PAUSES, |error: &StoreError| error.passing, || store.get(key, Wanted::Whole))
}

fn put(store: &dyn Store, key: &str, bytes: &[u8]) -> Result<(), StoreError> {
    retried(&PAUSES, |error: &StoreError| error.passing, || store.put(key, bytes))
}
