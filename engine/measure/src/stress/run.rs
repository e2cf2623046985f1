//! Goes through a plan on one device.

use std::sync::Arc;
use std::sync::mpsc::{channel, sync_channel};
use std::time::Instant;

use raxel_diagnostics::Files;
use raxel_gpu::{Device, DeviceKind};
use raxel_layouts::Layout;
use raxel_oracle::camera::Tile;
use raxel_oracle::metrics::Outcome;
use raxel_oracle::port::Tree64;
use raxel_oracle::sets::{RaySet, RayTargets};
use raxel_oracle::{Hit, Oracle, Ray};
use raxel_runtime::sources::layout_limits;
use raxel_stream::StreamError;
use raxel_world::World;
use rayon::prelude::*;

use super::judge::{Batch, Oracles, Seen, Tally, compare};
use super::plan::{Kind, Plan, Row, Site};
use super::posed::Posed;
use super::report::{Refused, Report, RowReport};
use super::stored::Stored;
use super::streamed::{self, Stage};
use crate::rays::{DeviceWorld, HitWords, Method, RayError, Stream, Traced, Tracer};

/// How far a run is.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Rays traced and judged, of all rows.
    pub rays: u64,
    /// The site.
    pub site: &'a str,
    /// The row.
    pub row: &'a Row,
}

/// A row that can be run.
enum Ready {
    Device(Box<Tracer>),
    Port,
    Unusable,
}

/// A row's world.
enum Loaded {
    Device(DeviceWorld),
    /// The publications of a streamed site.
    Stages(Vec<DeviceWorld>),
    Port(Vec<u32>),
    Refused,
}

/// Things besides the voxels that rows trace of a site, each only if a row needs it.
#[derive(Default)]
struct Prepared {
    /// Its instances, if they may stand there.
    posed: Option<Posed>,
    /// Its publications, or why there are none.
    stages: Vec<Stage>,
    not_streamed: Option<String>,
    /// The voxels that a shader sets, and the world afterwards.
    stored: Option<Stored>,
}

impl Prepared {
    fn of(plan: &Plan, world: &Arc<World>, device: &Device) -> Result<Self, RayError> {
        let wants = |kind| plan.rows.iter().any(|row| row.kind() == kind);
        let mut prepared = Self::default();
        if wants(Kind::Instances) || wants(Kind::OnwardInstances) {
            prepared.posed = Posed::of(world, plan.seed);
        }
        if wants(Kind::Stored) {
            prepared.stored = Some(Stored::of(world, plan.seed));
        }
        if wants(Kind::Streamed) {
            match streamed::stages(world, plan.seed, layout_limits(device).buffer_bytes) {
                Ok(stages) => prepared.stages = stages,
                Err(error) => prepared.not_streamed = Some(refusal(error)?),
            }
        }
        Ok(prepared)
    }
}

/// The reason why a row does not trace a site. Errors that do not belong to the site stay errors.
pub(super) fn refusal(error: RayError) -> Result<String, RayError> {
    match error {
        RayError::Layout(_) | RayError::NotStreamed(_) | RayError::Stream(StreamError::NoRoom { .. }) => {
            Ok(error.to_string())
        }
        error if error.is_of_tracer() => Ok(error.to_string()),
        error => Err(error),
    }
}

/// Runs a plan. Errors of a row or a site are in its report. An error is one of the device; the report then has the results before it.
pub fn run(
    plan: &Plan,
    device: &Arc<Device>,
    files: &Arc<dyn Files>,
    progress: &mut dyn FnMut(Progress<'_>),
) -> (Report, Result<(), RayError>) {
    let start = Instant::now();
    let mut report = Report {
        rows: plan.rows.iter().map(|row| RowReport::new(row, plan)).collect(),
        answered: 0,
        answer_seconds: 0.0,
        seconds: 0.0,
    };
    let result = go_through(plan, device, files, &mut report, progress);
    report.seconds = start.elapsed().as_secs_f64();
    (report, result)
}

fn go_through(
    plan: &Plan,
    device: &Arc<Device>,
    files: &Arc<dyn Files>,
    report: &mut Report,
    progress: &mut dyn FnMut(Progress<'_>),
) -> Result<(), RayError> {
    let mut rows = Vec::new();
    let on_device = |report: &RowReport| matches!(report.row, Row::Device(_));
    let mut left = report.rows.iter().filter(|report| on_device(report)).count();
    for report in &mut report.rows {
        rows.push(ready(report, device, files, left)?);
        left -= usize::from(on_device(report));
    }
    let software = device.capabilities().kind == DeviceKind::Cpu;
    let (device, stream) = (device.clone(), Stream::new(device)?.with_patience(plan.watchdog));
    let mut runner = Runner { plan, device, files: files.clone(), stream, report, progress, done: 0, software };
    for (number, site) in plan.sites.iter().enumerate() {
        runner.site(number, site, &mut rows)?;
    }
    Ok(())
}

/// A row with its tracer, where `left` tracers are still to be made.
fn ready(report: &mut RowReport, device: &Arc<Device>, files: &Arc<dyn Files>, left: usize) -> Result<Ready, RayError> {
    let Row::Device(method) = &report.row else { return Ok(Ready::Port) };
    match Tracer::among(device, files.clone(), method, left) {
        Ok(tracer) => Ok(Ready::Device(Box::new(tracer))),
        Err(error) if error.is_of_tracer() => {
            report.unusable = Some(error.to_string());
            Ok(Ready::Unusable)
        }
        Err(error) => Err(error),
    }
}

struct Runner<'a> {
    plan: &'a Plan,
    device: Arc<Device>,
    files: Arc<dyn Files>,
    stream: Stream,
    report: &'a mut Report,
    progress: &'a mut dyn FnMut(Progress<'_>),
    done: u64,
    software: bool,
}

impl Runner<'_> {
    fn site(&mut self, number: usize, site: &Site, rows: &mut [Ready]) -> Result<(), RayError> {
        let world = site.build(self.plan.seed);
        let place = RayTargets::of(&world);
        let prepared = Prepared::of(self.plan, &world, &self.device)?;
        let oracles = Oracles {
            site: Oracle::new(&world),
            scene: prepared.posed.as_ref().map(|posed| posed.scene.oracle()),
            stages: prepared.stages.iter().map(|stage| Oracle::new(&stage.world)).collect(),
            stored: prepared.stored.as_ref().map(|stored| Oracle::new(&stored.world)),
        };
        let mut worlds = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            worlds.push(self.load(number, i, row, (&world, &prepared))?);
        }
        // As many blocks as keep the device busy for a while, and take little memory.
        let in_batch = if self.software { 32 } else { 256 };
        let plan = self.plan;
        std::thread::scope(|scope| {
            // While the device traces a batch, the next one is made and answered.
            let (made, batches) = sync_channel(1);
            // Finished batches are reused: allocating their memory again would take as long as judging them.
            let (done, spent) = channel::<Batch>();
            let (place, oracles, prepared) = (&place, &oracles, &prepared);
            scope.spawn(move || {
                for blocks in blocks(plan).chunks(in_batch) {
                    let mut batch = spent.try_recv().unwrap_or_default();
                    fill(&mut batch, plan, number, (place, prepared), blocks);
                    batch.answer(oracles, prepared.posed.as_ref(), &plan.rows);
                    if made.send(batch).is_err() {
                        return; // the device has failed
                    }
                }
            });
            for batch in batches {
                let mut reference: Option<Vec<HitWords>> = None;
                for (i, (row, world)) in rows.iter_mut().zip(&worlds).enumerate() {
                    self.trace(i, row, world, (&batch, prepared.posed.as_ref()), &mut reference)?;
                    self.done += batch.rays.len() as u64;
                    (self.progress)(Progress { rays: self.done, site: &site.name, row: &self.plan.rows[i] });
                }
                self.report.answered += batch.answers.len() as u64;
                self.report.answer_seconds += batch.answer_seconds / rayon::current_num_threads() as f64;
                // If the receiver is gone, it is dropped.
                let _ = done.send(batch);
            }
            Ok(())
        })
    }

    fn load(
        &mut self,
        site: usize,
        row: usize,
        ready: &Ready,
        (world, prepared): (&World, &Prepared),
    ) -> Result<Loaded, RayError> {
        let loaded = match ready {
            Ready::Unusable => return Ok(Loaded::Refused),
            Ready::Device(tracer) if self.plan.rows[row].traces_instances() => match &prepared.posed {
                None => {
                    let why = "instances stand at most 10⁹ voxels from the origin".to_owned();
                    self.report.rows[row].refuse(site, why);
                    return Ok(Loaded::Refused);
                }
                Some(posed) => tracer.upload(world).and_then(|world| {
                    Ok(Loaded::Device(world.with("instances", tracer.upload_words("instances", &posed.words()?)?)))
                }),
            },
            Ready::Device(tracer) if self.plan.rows[row].kind() == Kind::Streamed => {
                if let Some(why) = &prepared.not_streamed {
                    self.report.rows[row].refuse(site, why.clone());
                    return Ok(Loaded::Refused);
                }
                let shown = prepared.stages.iter().map(|stage| tracer.upload_words("world", &stage.words));
                shown.collect::<Result<_, _>>().map(Loaded::Stages)
            }
            Ready::Device(tracer) if self.plan.rows[row].kind() == Kind::Stored => match &prepared.stored {
                None => return Ok(Loaded::Refused),
                Some(stored) => tracer.upload_writable(world).and_then(|copy| {
                    self.store(site, row, tracer.method(), &copy, stored)?;
                    Ok(Loaded::Device(copy))
                }),
            },
            Ready::Device(tracer) => tracer.upload(world).map(Loaded::Device),
            Ready::Port => Layout::TREE64
                .encode(world, u64::from(u32::MAX))
                .map(|encoded| Loaded::Port(encoded.words))
                .map_err(RayError::from),
        };
        loaded.or_else(|error| {
            match error {
                // The rest of the run still counts.
                RayError::Gpu(error @ raxel_gpu::Error::OutOfMemory { .. }) => {
                    let refused = Refused { site, why: error.to_string(), out_of_memory: true };
                    self.report.rows[row].refused.push(refused);
                }
                error => self.report.rows[row].refuse(site, refusal(error)?),
            }
            Ok(Loaded::Refused)
        })
    }

    /// Sets voxels of a copy by the shader of its layout.
    fn store(
        &mut self,
        site: usize,
        row: usize,
        traced: &Method,
        copy: &DeviceWorld,
        stored: &Stored,
    ) -> Result<(), RayError> {
        let method = Method { marcher: Some("store".to_owned()), ..traced.clone() };
        let mut setter = Tracer::new(&self.device, self.files.clone(), &method)?;
        for (edits, has_chunk) in [(&stored.edits, true), (&stored.beyond, false)] {
            let said = self.stream.trace_all(&mut setter, copy, edits)?;
            let tally = Batch::judge_edits(site, self.plan.sets.len(), edits, &said, has_chunk);
            self.report.rows[row].add(site, tally);
        }
        Ok(())
    }

    fn trace(
        &mut self,
        row: usize,
        ready: &mut Ready,
        world: &Loaded,
        (batch, posed): (&Batch, Option<&Posed>),
        reference: &mut Option<Vec<HitWords>>,
    ) -> Result<(), RayError> {
        match (ready, world) {
            (Ready::Device(tracer), Loaded::Device(world)) if self.plan.rows[row].traces_tiles() => {
                let report = &mut self.report.rows[row];
                self.stream.trace(tracer, world, &batch.tiles, |part| {
                    report.add(batch.site, batch.judge_tiles(&self.plan.rows[row], part.range.start, part.hits));
                    if let Some(seconds) = part.seconds {
                        report.seconds += seconds;
                        report.timed += part.hits.len() as u64;
                    }
                    Ok::<_, RayError>(())
                })?;
            }
            (Ready::Device(tracer), Loaded::Device(world)) => {
                // The row that the port is compared with.
                let compared = self.plan.rows[row] == Row::default_tracer() && self.plan.rows.contains(&Row::Port);
                let mut kept = compared.then(Vec::new);
                let mut total = Tally::of(batch.set_count);
                let (mut seconds, mut timed) = (0.0, 0);
                let by = &self.plan.rows[row];
                let look = |part: Traced<'_>| {
                    let first = part.range.start;
                    let tally = match (by.kind(), posed) {
                        (Kind::Instances, Some(posed)) => batch.judge_scene(posed, first, part.hits),
                        (Kind::OnwardInstances, Some(posed)) => batch.judge_scene_onward(posed, first, part.hits),
                        (Kind::Onward, _) => batch.judge_seen(by, &batch.onward.seen, first, part.hits),
                        (Kind::Stored, _) => batch.judge_seen(by, &batch.stored, first, part.hits),
                        _ => batch.judge_words(by, first, part.hits),
                    };
                    total = std::mem::take(&mut total).and(tally);
                    if let Some(kept) = &mut kept {
                        kept.extend_from_slice(part.hits);
                    }
                    if let Some(part_seconds) = part.seconds {
                        seconds += part_seconds;
                        timed += part.hits.len() as u64;
                    }
                    Ok::<_, RayError>(())
                };
                match by.kind() {
                    Kind::Ahead => self.stream.trace(tracer, world, &batch.ahead(), look)?,
                    Kind::Periods => self.stream.trace(tracer, world, &batch.periods, look)?,
                    Kind::Onward => self.stream.trace(tracer, world, &batch.onward.from, look)?,
                    Kind::OnwardInstances => self.stream.trace(tracer, world, &batch.onward_scene.from, look)?,
                    Kind::Stored => self.stream.trace(tracer, world, &batch.stored.rays, look)?,
                    Kind::Rays | Kind::Tiles | Kind::Instances | Kind::Streamed => {
                        self.stream.trace(tracer, world, &batch.rays, look)?;
                    }
                }
                let report = &mut self.report.rows[row];
                report.seconds += seconds;
                report.timed += timed;
                report.add(batch.site, total);
                if kept.is_some() {
                    *reference = kept;
                }
            }
            (Ready::Device(tracer), Loaded::Stages(worlds)) => {
                let (by, report) = (&self.plan.rows[row], &mut self.report.rows[row]);
                for (world, seen) in worlds.iter().zip(&batch.seen) {
                    self.stream.trace(tracer, world, &seen.rays, |part| {
                        report.add(batch.site, batch.judge_seen(by, seen, part.range.start, part.hits));
                        if let Some(seconds) = part.seconds {
                            report.seconds += seconds;
                            report.timed += part.hits.len() as u64;
                        }
                        Ok::<_, RayError>(())
                    })?;
                }
            }
            (Ready::Port, Loaded::Port(words)) => {
                let tree = Tree64::new(words);
                let start = Instant::now();
                let hits: Vec<Option<Hit>> =
                    batch.rays.par_iter().with_min_len(64).map(|ray| tree.trace(ray)).collect();
                let report = &mut self.report.rows[row];
                report.seconds += start.elapsed().as_secs_f64();
                report.timed += hits.len() as u64;
                report.add(batch.site, batch.judge(&Row::Port, 0, &hits, |hit| (*hit, Outcome::Miss)));
                if let Some(device) = reference {
                    report.differs = Some(report.differs.unwrap_or_default().and(compare(batch, &hits, device)));
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Every block of every set, set by set: (set, number of the block).
fn blocks(plan: &Plan) -> Vec<(usize, u64)> {
    let each = plan.rays_each().div_ceil(RaySet::BLOCK as u64);
    (0..plan.sets.len()).flat_map(|set| (0..each).map(move |number| (set, number))).collect()
}

/// The rays of a block.
struct Block {
    rays: Vec<Ray>,
    tiles: Vec<Tile>,
    /// As many that are aimed at the voxels of each publication.
    aimed: Vec<Vec<Ray>>,
    /// As many that are aimed at the voxels that a shader has left.
    stored: Vec<Ray>,
}

/// Fills a batch with the rays of blocks, made on all cores; they are not answered yet.
fn fill(
    batch: &mut Batch,
    plan: &Plan,
    site: usize,
    (place, prepared): (&RayTargets, &Prepared),
    blocks: &[(usize, u64)],
) {
    let count = |number: u64| (plan.rays_each() - number * RaySet::BLOCK as u64).min(RaySet::BLOCK as u64) as usize;
    let (stages, stored) = (&prepared.stages, prepared.stored.as_ref());
    let made: Vec<Block> = blocks
        .par_iter()
        .map(|&(set, number)| {
            let (set, count) = (plan.sets[set], count(number));
            let rays = |targets: &RayTargets| set.block(targets, plan.seed, number, count);
            let tiles = set.tiles(place, plan.seed, number, count);
            let aimed = stages.iter().map(|stage| rays(&stage.targets)).collect();
            let stored = stored.map(|stored| rays(&stored.targets)).unwrap_or_default();
            Block { rays: rays(place), tiles, aimed, stored }
        })
        .collect();
    let Batch { rays, sets, tiles, tile_rays, seen, stored, .. } = batch;
    stored.rays.clear();
    stored.sets.clear();
    rays.clear();
    sets.clear();
    tiles.clear();
    tile_rays.clear();
    seen.resize_with(stages.len(), Seen::default);
    for Seen { rays, sets, .. } in &mut *seen {
        rays.clear();
        sets.clear();
    }
    for (&(set, _), block) in blocks.iter().zip(made) {
        let begin = rays.len();
        rays.extend_from_slice(&block.rays);
        sets.resize(rays.len(), set as u16);
        tile_rays.extend((0..block.tiles.len()).map(|tile| {
            let first = tile * Tile::RAYS;
            (begin + first, Tile::RAYS.min(block.rays.len() - first))
        }));
        tiles.extend(block.tiles);
        // Half of these are aimed at the voxels before.
        stored
            .rays
            .extend(block.stored.iter().enumerate().map(|(i, aimed)| if i % 2 == 0 { block.rays[i] } else { *aimed }));
        stored.sets.resize(stored.rays.len(), set as u16);
        // Publications take turns. Half of the rays through each are aimed at the voxels before the edits, half at those after them.
        for (i, ray) in block.rays.iter().enumerate().filter(|_| !stages.is_empty()) {
            let place = begin + i;
            let number = place / 2 % stages.len();
            let aimed = if place.is_multiple_of(2) { ray } else { &block.aimed[number][i] };
            seen[number].rays.push(*aimed);
            seen[number].sets.push(set as u16);
        }
    }
    (batch.site, batch.set_count) = (site, plan.sets.len());
}
