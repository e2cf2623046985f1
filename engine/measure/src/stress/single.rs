//! One ray, traced by all rows of a plan.

use std::sync::Arc;

use raxel_diagnostics::Files;
use raxel_gpu::Device;
use raxel_layouts::Layout;
use raxel_oracle::exact::Answer;
use raxel_oracle::metrics::Errors;
use raxel_oracle::port::Tree64;
use raxel_oracle::{Hit, Oracle, Ray};
use raxel_runtime::sources::layout_limits;
use raxel_world::World;

use super::judge::{latest_start, said};
use super::plan::{Kind, Plan, Row};
use super::run::refusal;
use super::streamed;
use super::truth::{Truth, outcome, period_ray};
use crate::rays::{Method, RayError, RayWords, State, Stream, Tracer};

/// The result of a row: its state and hit; or why it does not trace.
pub type Said = Result<(State, Option<Hit>), String>;

/// All answers about one ray.
#[derive(Clone, Debug)]
pub struct Single {
    /// The exact answer.
    pub exact: Answer,
    /// The hit of each row, and the exact one.
    pub rows: Vec<(Row, Truth, Said)>,
}

/// Traces one ray through one site by all rows of a plan.
pub fn single(
    plan: &Plan,
    site: usize,
    ray: &Ray,
    device: &Arc<Device>,
    files: &Arc<dyn Files>,
) -> Result<Single, RayError> {
    let world = plan.sites[site].build(plan.seed);
    let oracle = Oracle::new(&world);
    let exact = oracle.first_hit(ray);
    let mut stream = Stream::with_capacity(device, 64)?.with_patience(plan.watchdog);
    let mut rows = Vec::new();
    for row in &plan.rows {
        let found = match row {
            Row::Port => {
                let encoded = Layout::TREE64.encode(&world, u64::from(u32::MAX)).map_err(|error| error.to_string());
                encoded.map(|encoded| {
                    let hit = Tree64::new(&encoded.words).trace(ray);
                    (if hit.is_some() { State::Hit } else { State::Miss }, hit)
                })
            }
            Row::Device(method) if row.kind() == Kind::Streamed => {
                let (truth, found) = streamed_single(plan, row, ray, (&world, method), (device, files, &mut stream))?;
                rows.push((row.clone(), truth.unwrap_or(Truth::Ray(exact)), found));
                continue;
            }
            Row::Device(_) if !row.traces_alone() => Err("traces no ray alone, but those of --sets".to_owned()),
            Row::Device(method) => {
                let traced = Tracer::new(device, files.clone(), method).and_then(|mut tracer| {
                    let world = tracer.upload(&world)?;
                    match row.kind() {
                        Kind::Periods => stream.trace_all(&mut tracer, &world, &[period_ray(ray)]),
                        Kind::Ahead => {
                            let ahead = RayWords::ahead(ray, latest_start(ray, &exact));
                            stream.trace_all(&mut tracer, &world, &[ahead])
                        }
                        _ => stream.trace_all(&mut tracer, &world, &[*ray]),
                    }
                });
                match traced {
                    Ok(words) => Ok((words[0].state(), said(&words[0]).0)),
                    Err(error @ RayError::Layout(_)) => Err(error.to_string()),
                    Err(error) if error.is_of_tracer() => Err(error.to_string()),
                    Err(error) => return Err(error),
                }
            }
        };
        rows.push((row.clone(), Truth::of(row, ray, &oracle), found));
    }
    Ok(Single { exact, rows })
}

/// Traces one ray through the publications of a site: the first one that the row is wrong about, or else the newest.
fn streamed_single(
    plan: &Plan,
    row: &Row,
    ray: &Ray,
    (world, method): (&Arc<World>, &Method),
    (device, files, stream): (&Arc<Device>, &Arc<dyn Files>, &mut Stream),
) -> Result<(Option<Truth>, Said), RayError> {
    let stages = match streamed::stages(world, plan.seed, layout_limits(device).buffer_bytes) {
        Ok(stages) => stages,
        Err(error) => return Ok((None, Err(refusal(error)?))),
    };
    let mut tracer = match Tracer::new(device, files.clone(), method) {
        Err(error) if error.is_of_tracer() => return Ok((None, Err(error.to_string()))),
        tracer => tracer?,
    };
    let mut shown = (None, Err("nothing is published".to_owned()));
    for stage in &stages {
        let on_device = tracer.upload_words("world", &stage.words)?;
        let words = stream.trace_all(&mut tracer, &on_device, &[*ray])?[0];
        let truth = Truth::of(row, ray, &Oracle::new(&stage.world));
        let (hit, other) = said(&words);
        let wrong = truth.judge(&mut Errors::default(), ray, row, outcome(hit.as_ref(), other));
        shown = (Some(truth), Ok((words.state(), hit)));
        if wrong.is_some() {
            break;
        }
    }
    Ok(shown)
}
