//! `raxel world bake`: a world into a store, shard by shard.

use std::path::PathBuf;

use raxel_bake::{BakeError, BakePart, DEFAULT_EDGE, Plan, PlanError, Report};
use raxel_diagnostics::names::{counted, grouped};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_runtime::project::Project;
use raxel_runtime::world::SessionWorld;
use raxel_runtime::world::store_refused;
use raxel_stream::streaming_range;
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::offline::OfflineProject;
use raxel_world::{Bounds, ChunkProvider};
use serde_json::json;

use super::info::bytes;

/// Bakes the voxels of a world into Zarr v3 arrays, in a folder or an S3-compatible store.
///
/// Each shard is one object, and depends on the world's file alone, so many machines can each bake a part. Shards that are there and whole stay
/// as they are. Edits in a save are left out.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    raxel world bake worlds/valley.toml --out bakes/valley\n  \
    raxel world bake worlds/frontier.toml --min -2048,-64,-2048 --max 2048,448,2048 --levels 3 --shard 2/16 --out bakes/frontier")]
pub(crate) struct Args {
    /// A world file or a .vox scene; the project's world by default.
    world: Option<PathBuf>,

    /// The store: a folder, or a URL (`s3://BUCKET/FOLDER`, in a raxel with the feature `cloud`).
    #[arg(short, long, value_name = "URL")]
    out: String,

    /// Only a part: I/N is part I of N, counted from 1; X,Y,Z/N is one of N × N × N boxes of the region, counted from 0.
    #[arg(long, value_name = "I/N or X,Y,Z/N")]
    shard: Option<BakePart>,

    /// The smallest voxel of the region. By default that of the world; of an endless world, that of the land near the first camera.
    #[arg(long, value_name = "X,Y,Z", value_parser = cell, allow_hyphen_values = true)]
    min: Option<Cell>,

    /// One past the largest voxel of the region.
    #[arg(long, value_name = "X,Y,Z", value_parser = cell, allow_hyphen_values = true)]
    max: Option<Cell>,

    /// Cells along an edge of a shard, a multiple of 64. The region grows to whole shards.
    #[arg(long, value_name = "CELLS", default_value_t = DEFAULT_EDGE)]
    edge: u32,

    /// Levels of detail, 1 to 4: single voxels, and cells of 4, 16 and 64. By default as many as `far` of the world needs.
    #[arg(long, value_name = "N")]
    levels: Option<u32>,

    #[command(flatten)]
    pub messages: Messages,
}

/// Coordinates of a voxel.
type Cell = [i64; 3];

fn cell(text: &str) -> std::result::Result<Cell, String> {
    let numbers: Option<Vec<i64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| format!("`{text}` is not X,Y,Z"))
}

pub(super) fn run(args: &Args, console: &Console) -> Result {
    let (offline, path) = OfflineProject::of(args.world.as_deref(), Project::default_world, console)?;
    let world = offline.world(&path, console)?;
    let source: &dyn ChunkProvider = match world.streamed() {
        Some(streamed) => &*streamed.generator,
        None => world.voxels(),
    };
    let plan = plan(args, &path, &world, &offline, source).map_err(|error| refused(&error, console))?;
    let folder = std::env::current_dir().unwrap_or_default();
    let store = raxel_bake::open(&args.out, &folder).map_err(|error| console.stop(&[store_refused(&error)]))?;
    let part = args.shard.unwrap_or(BakePart::Whole);
    let all = part.shards(&plan).count();
    let report = raxel_bake::bake(source, &plan, part, &*store, &mut |key, report| {
        console.detail(&format!("{} ({} of {all})", key.object(), report.shards));
    });
    print(&report.map_err(|error| stopped(&error, &args.out, console))?, args, &plan, console);
    Ok(())
}

/// The region to bake: the requested one, or all of the world.
fn plan(
    args: &Args,
    path: &str,
    world: &SessionWorld,
    offline: &OfflineProject,
    source: &dyn ChunkProvider,
) -> std::result::Result<Plan, PlanError> {
    let (there, levels) = if let Some(streamed) = world.streamed() {
        let [low, high] = streamed.settings.height.or(source.height_range()).unwrap_or_default();
        let Bounds { min, max } = world.bounds_around(world.first_camera().cell);
        let min = [min[0], low, min[2]];
        (Bounds { min, max: [max[0], high, max[2]] }, 1 + streamed_levels(world))
    } else {
        (world.bounds(), 1)
    };
    let region = Bounds { min: args.min.unwrap_or(there.min), max: args.max.unwrap_or(there.max) };
    let hash = world.fingerprint(&**offline.loader.files());
    let fingerprint = format!("{:032x}", u128::from_be_bytes(std::array::from_fn(|byte| hash[byte])));
    let name = if world.name().is_empty() { path } else { world.name() };
    Plan::new(name, &fingerprint, world.voxels().materials().to_vec(), region, args.edge, args.levels.unwrap_or(levels))
}

/// The highest level that the view of a streamed world takes.
fn streamed_levels(world: &SessionWorld) -> u32 {
    let (Some(streamed), Some(tiles)) = (world.streamed(), world.tiles()) else { return 0 };
    streaming_range(streamed, tiles).top()
}

fn refused(error: &PlanError, console: &Console) -> Failure {
    console.stop(&[Diagnostic::error(codes::world::BAKE_REGION, error.to_string())])
}

fn stopped(error: &BakeError, out: &str, console: &Console) -> Failure {
    let (code, help) = match error {
        BakeError::OtherWorld { .. } | BakeError::OtherPlan { .. } | BakeError::OtherFormat(_) => {
            (codes::world::STORE_OTHER, "bake to another address, or remove the old bake")
        }
        BakeError::Store(_) | BakeError::Source(_) => {
            (codes::world::STORE_FAILING, "the written shards stay: the same command goes on from there")
        }
    };
    console.stop(&[Diagnostic::error(code, format!("`{out}`: {error}")).help(help)])
}

fn print(report: &Report, args: &Args, plan: &Plan, console: &Console) {
    if console.format() == Format::Json {
        let Bounds { min, max } = plan.region();
        console::json(&json!({
            "reason": "baked", "out": args.out, "levels": plan.levels().len(), "min": min, "max": max, "report": report,
        }));
        return;
    }
    let Report { shards, written, redone, skipped, chunks, bytes: size } = *report;
    let redone = if redone == 0 { String::new() } else { format!(", {} of them again", grouped(redone)) };
    console.message(&format!(
        "{}: {}, {} written{redone}, {} there already; {}, {}",
        args.out,
        counted(shards, "shard"),
        grouped(written),
        grouped(skipped),
        counted(chunks, "chunk"),
        bytes(size)
    ));
}
