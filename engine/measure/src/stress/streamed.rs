//! A site as a streamed world shows it while it is edited: publications of a streamer, and the voxels that are right in each.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use glam::IVec3;
use raxel_edit::{Change, ChunkCache, EditedChunks, Edits, Operation, Scene};
use raxel_oracle::sets::{Random, RayTargets};
use raxel_stream::{PoolMemory, Publication, StreamError, StreamOptions, Streamer, StreamingRange, View};
use raxel_world::{Bounds, ChunkPos, ChunkProvider, World};
use raxel_worldfile::StreamSettings;

use super::edited::{BEYOND, Edit, edited, step};
use crate::rays::RayError;

/// How often the world is edited and published again.
const ROUNDS: usize = 6;
/// Edits of a round. The streamer hears of each before it has shown the previous one.
const STEPS: usize = 2;
/// Rays are traced through the publication before this round while the edits of the round are made.
const IN_FLIGHT: usize = 3;
/// Before this round, the camera goes far away and comes back: every tile is dropped and loaded again.
const AWAY: usize = 4;
/// This round begins with an undo.
const UNDO: usize = 2;

/// The largest distance of streamed voxels from the centre of a site.
const MOST_REACH: i64 = 2048;
/// Bytes of tiles of the site that are kept packed: coarse ones are made of many chunks.
const KEPT: u64 = 64 << 20;
/// Words of a pool besides twice the site's: for edits, and for tiles of earlier publications.
const SPARE: u64 = 1 << 18;
/// Longer than a streamer takes that ends at all.
const PATIENCE: Duration = Duration::from_secs(120);

/// A publication that rays are traced through.
pub(super) struct Stage {
    /// The words that a frame reads: those of the pool behind the publication's header.
    pub words: Vec<u32>,
    /// The voxels that it must show.
    pub world: World,
    /// The targets of rays.
    pub targets: RayTargets,
}

/// The publications of a site that rays are traced through: one that is still in flight while later edits are made, and the newest one. The
/// pool has at most `most_bytes` bytes.
pub(super) fn stages(world: &Arc<World>, seed: u64, most_bytes: u64) -> Result<Vec<Stage>, RayError> {
    let honest = |source: Arc<EditedChunks>| source as Arc<dyn ChunkProvider>;
    stages_over(world, seed, most_bytes, &honest, &|_| true)
}

/// The same over the source that `over` makes of the edited one. The streamer hears only of the changed chunks for which `tells` is true.
fn stages_over(
    world: &Arc<World>,
    seed: u64,
    most_bytes: u64,
    over: &dyn Fn(Arc<EditedChunks>) -> Arc<dyn ChunkProvider>,
    tells: &dyn Fn(ChunkPos) -> bool,
) -> Result<Vec<Stage>, RayError> {
    if world.materials().len() < 2 {
        return Err(RayError::NotStreamed("the world has no material to edit it with".to_owned()));
    }
    let (middle, reach) = reach_about(world)?;
    let tiles: Arc<dyn ChunkProvider> = Arc::new(ChunkCache::new(world.clone(), KEPT));
    let bytes = Streamer::estimate(&*tiles, &reach, middle, &|_| 0).pool;
    let most = most_bytes / 4;
    let mut words = (bytes / 2 + SPARE).min(most);
    loop {
        let source = Arc::new(EditedChunks::new(tiles.clone(), world.materials().to_vec()));
        let memory = Arc::new(Words(Mutex::new(vec![0; words as usize])));
        let options = StreamOptions { workers: 2, complete: true, upload: None, poison: true };
        let shown = over(source.clone());
        let streamer = Streamer::new(shown, memory.clone(), words as u32, reach.clone(), View::at(middle), options);
        let editing = Editing {
            streamer,
            source,
            memory,
            scene: Scene::new(world.materials(), &[]),
            edits: Edits::default(),
            world: (**world).clone(),
            before: Vec::new(),
            newest: None,
            middle,
            random: Random::new(seed ^ 0x57ea),
            tells,
        };
        match editing.stages() {
            // The estimate is a sample, and earlier publications hold blocks, too.
            Err(RayError::Stream(StreamError::NoRoom { .. })) if words < most => words = (2 * words).min(most),
            stages => return stages,
        }
    }
}

/// The centre of a world, and a reach around it with all of its voxels, and all of those that edits set. As in a session, the heights are
/// those of the world before the edits. Coarse tiles lie around the chunks, and show nothing: a chunk hides them, also an empty one.
fn reach_about(world: &World) -> Result<(IVec3, StreamingRange), RayError> {
    let Bounds { min, max } = world.bounds().unwrap_or(Bounds { min: [0; 3], max: [1; 3] });
    let middle = std::array::from_fn(|i| (min[i] + max[i]).div_euclid(2));
    let half: [i64; 3] = std::array::from_fn(|i| max[i] - middle[i] + BEYOND);
    let across = ((half[0] * half[0] + half[2] * half[2]) as f64).sqrt().ceil() as i64;
    let near = across.max(half[1]);
    if near > MOST_REACH {
        let size: Vec<i64> = (0..3).map(|i| max[i] - min[i]).collect();
        return Err(RayError::NotStreamed(format!(
            "the world is {} × {} × {} voxels large; with its edits it must lie within {MOST_REACH} voxels around its centre",
            size[0], size[1], size[2]
        )));
    }
    let (near, far) = (near as u32, near as u32 + 1);
    let reach = StreamingRange::of(&StreamSettings { near, far, ..StreamSettings::default() }, [min[1], max[1]]);
    Ok((IVec3::from_array(middle.map(|c| c as i32)), reach))
}

/// The words of a pool, on the host.
struct Words(Mutex<Vec<u32>>);

impl PoolMemory for Words {
    fn write(&self, at: u32, words: &[u32]) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)[at as usize..][..words.len()].copy_from_slice(words);
    }
}

/// A streamed world that is edited.
struct Editing<'a> {
    streamer: Streamer,
    source: Arc<EditedChunks>,
    memory: Arc<Words>,
    scene: Scene,
    edits: Edits,
    /// The exact world now, and before each step that can be undone.
    world: World,
    before: Vec<World>,
    /// The newest publication.
    newest: Option<Arc<Publication>>,
    middle: IVec3,
    random: Random,
    tells: &'a dyn Fn(ChunkPos) -> bool,
}

impl Editing<'_> {
    fn stages(mut self) -> Result<Vec<Stage>, RayError> {
        let mut stages = Vec::new();
        self.settle()?;
        for round in 0..ROUNDS {
            if round == AWAY {
                self.go_away_and_back()?;
            }
            let (before, shown) = (self.newest.clone(), self.world.clone());
            if round == UNDO {
                self.undo()?;
            }
            for number in 0..STEPS {
                self.edit(round * STEPS + number)?;
            }
            self.settle()?;
            // A frame with the publication before may not have finished: its tiles are not free yet.
            if round == IN_FLIGHT {
                stages.extend(before.map(|publication| self.stage(&publication, shown)));
            }
            self.release();
        }
        // Wait until all released blocks are overwritten. So an error shows if a shown tile is among them.
        self.streamer.retry();
        self.streamer.wait(PATIENCE)?;
        stages.extend(self.newest.clone().map(|publication| self.stage(&publication, self.world.clone())));
        Ok(stages)
    }

    /// Waits until everything is there and takes the publication with it.
    fn settle(&mut self) -> Result<(), RayError> {
        self.streamer.wait(PATIENCE)?;
        if let Some(taken) = self.streamer.take() {
            self.newest = Some(taken);
        }
        Ok(())
    }

    /// All frames before the newest publication have finished.
    fn release(&self) {
        if let Some(newest) = &self.newest {
            self.streamer.released(newest.version);
        }
    }

    fn edit(&mut self, number: usize) -> Result<(), RayError> {
        let edits = step(&self.world, number, &mut self.random);
        let operations: Vec<Operation> = edits.iter().map(Edit::operation).collect();
        let change = self.edits.apply(&operations, &self.scene, self.source.unedited())?;
        self.show(&change);
        let after = edited(&self.world, &edits);
        let before = std::mem::replace(&mut self.world, after);
        // An edit that changes nothing is no step to undo.
        if !change.chunks.is_empty() {
            self.before.push(before);
        }
        Ok(())
    }

    fn undo(&mut self) -> Result<(), RayError> {
        if let Some(change) = self.edits.undo(self.source.unedited()).map_err(raxel_edit::EditError::from)?
            && let Some(before) = self.before.pop()
        {
            self.show(&change);
            self.world = before;
        }
        Ok(())
    }

    /// Hands a change on, as a session does.
    fn show(&self, change: &Change) {
        self.source.change(change);
        let changed: Vec<ChunkPos> =
            change.chunks.iter().map(|chunk| chunk.pos).filter(|pos| (self.tells)(*pos)).collect();
        self.streamer.changed(&changed);
    }

    fn go_away_and_back(&mut self) -> Result<(), RayError> {
        let far = if self.middle.x > 0 { -(1 << 20) } else { 1 << 20 };
        for by in [far, 0] {
            self.streamer.follow(View::at(self.middle + IVec3::new(by, 0, 0)));
            self.settle()?;
            self.release();
        }
        Ok(())
    }

    fn stage(&self, publication: &Publication, world: World) -> Stage {
        let mut words = self.memory.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        words[..publication.words().len()].copy_from_slice(publication.words());
        Stage { words, targets: RayTargets::of(&world), world }
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use raxel_oracle::metrics::Errors;
    use raxel_oracle::port::Tree64;
    use raxel_oracle::scenes::Scene as Solids;
    use raxel_oracle::{Oracle, sets};
    use raxel_world::{Content, Material, Unavailable};

    use super::*;
    use crate::stress::{Site, Sites};

    const MOST_BYTES: u64 = 256 << 20;

    fn site(scene: &str, at: Sites) -> Arc<World> {
        Site::scene(Solids::find(scene).expect("a scene"), at).build(1)
    }

    /// Rays of all sets through words, judged by a world. They are aimed at the voxels now, and at those before the edits.
    fn judge(words: &[u32], stage: &Stage, before: &World) -> Errors {
        judge_by(words, stage, before, 32)
    }

    /// By so many rays of each set.
    fn judge_by(words: &[u32], stage: &Stage, before: &World, rays: usize) -> Errors {
        let (tree, oracle, mut errors) = (Tree64::new(words), Oracle::new(&stage.world), Errors::default());
        let aims = [&stage.targets, &RayTargets::of(before)];
        for ray in aims.into_iter().flat_map(|aim| sets::ALL.iter().flat_map(|set| set.block(aim, 7, 0, rays))) {
            errors.add(&ray, &oracle.first_hit(&ray), tree.trace(&ray).as_ref());
        }
        errors
    }

    fn wrong(stage: &Stage, before: &World) -> u64 {
        judge(&stage.words, stage, before).wrong()
    }

    #[test]
    fn every_publication_is_exact_near_and_far() {
        for scene in ["dust", "gravel", "motley", "solid", "corners", "menger", "hills"] {
            for at in [Sites::Near, Sites::Far] {
                let world = site(scene, at);
                let stages = stages(&world, 1, MOST_BYTES).expect("it is streamed");
                assert_eq!(stages.len(), 2);
                assert!(stages[0].world != *world && stages[1].world != *world && stages[0].world != stages[1].world);
                for stage in &stages {
                    let errors = judge(&stage.words, stage, &world);
                    assert!(errors.wrong() + errors.inexact() == 0 && errors.hits > 100, "{scene} {at:?} {errors:?}");
                }
            }
        }
    }

    /// A source that has not heard of the edits of one chunk.
    struct Forgetful {
        edited: Arc<EditedChunks>,
        world: Arc<World>,
        forgets: ChunkPos,
    }

    impl ChunkProvider for Forgetful {
        fn materials(&self) -> &[Material] {
            self.edited.materials()
        }

        fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
            if level == 0 && pos == self.forgets {
                return Ok(self.world.tile(level, pos));
            }
            ChunkProvider::try_chunk(&*self.edited, level, pos)
        }
    }

    #[test]
    fn an_edit_that_is_not_shown_is_noticed() {
        let world = site("gravel", Sites::Near);
        let honest = stages(&world, 1, MOST_BYTES).expect("it is streamed");
        let differs = |pos: &ChunkPos| honest[1].world.chunk(*pos) != world.chunk(*pos);
        let forgets = honest[1].world.chunks().map(|(pos, _)| pos).find(differs).expect("an edited chunk");
        let forgetful = |edited: Arc<EditedChunks>| -> Arc<dyn ChunkProvider> {
            Arc::new(Forgetful { edited, world: world.clone(), forgets })
        };
        let stages = stages_over(&world, 1, MOST_BYTES, &forgetful, &|_| true).expect("it is streamed");
        assert!(stages[1].world == honest[1].world);
        // The edit changed a few voxels of the chunk.
        assert!(judge_by(&stages[1].words, &stages[1], &world, 1000).wrong() > 0);
    }

    #[test]
    fn a_streamer_that_is_not_told_of_edits_is_noticed() {
        let world = site("hills", Sites::Far);
        let honest = |source: Arc<EditedChunks>| source as Arc<dyn ChunkProvider>;
        let stages = stages_over(&world, 1, MOST_BYTES, &honest, &|_| false).expect("it is streamed");
        assert!(stages.iter().all(|stage| wrong(stage, &world) > 0));
    }

    /// By then, tiles of an earlier publication are free, and other tiles or poison stand in their place.
    #[test]
    fn a_header_of_an_earlier_publication_is_noticed() {
        let world = site("hills", Sites::Near);
        let stages = stages(&world, 1, MOST_BYTES).expect("it is streamed");
        let mut stale = stages[1].words.clone();
        let header = size_of::<raxel_layouts::Tree64Header>() / 4;
        stale[..header].copy_from_slice(&stages[0].words[..header]);
        // Who follows poison may leave the words.
        let traced = catch_unwind(AssertUnwindSafe(|| judge(&stale, &stages[0], &world).wrong()));
        assert!(traced.map_or(true, |wrong| wrong > 0));
    }

    #[test]
    fn what_cannot_be_streamed_is_refused_with_a_reason() {
        let far_apart = [IVec3::ZERO, IVec3::new(0, 0, 5000)].map(|cell| (cell, 1));
        let wide = World::from_voxels(raxel_oracle::scenes::materials(), far_apart);
        let reason = |world: World, bytes| match stages(&Arc::new(world), 1, bytes) {
            Ok(_) => "it is streamed".to_owned(),
            Err(error) => error.to_string(),
        };
        assert!(reason(wide, MOST_BYTES).contains("1 × 1 × 5001 voxels"));
        assert!(reason(World::empty(), MOST_BYTES).contains("no material"));
        assert!(reason((*site("hills", Sites::Near)).clone(), 1 << 14).contains("bytes of the pool"));
    }
}
