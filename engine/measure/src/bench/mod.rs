//! Run time against error: graphs × layouts × worlds × cameras × sizes, each timed on the device and judged by the exact oracle on the very
//! same rays. The figures of `raxel bench`.
//!
//! A graph is judged when it has a target `hit` of format `rgba32i`: x, y, z is the voxel, w is face + 8 · material (material 0: not looked
//! up), or −1 where nothing is hit. Targets `depth` (`r32f`, in lengths of the ray's direction) and `steps` (`r32ui`) add to the judgement. Its
//! rays must be those of `rx_camera_ray`. A graph whose `about` ends with `exact` claims that all of them are right. A graph with a target
//! `bounce_hit` is timed and judged by the rays that leave its hits ([`raxel_oracle::bounce`]), in its pass whose name begins with `bounce`.

mod judge;
mod measure;
mod runner;

use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_layouts::Layout;
use raxel_oracle::metrics::Errors;
use serde::Serialize;

pub use runner::{BenchError, Broken, Runner, Uncompiled, cameras, pinhole};

use raxel_runtime::world::LayoutCost;

/// Bytes for each solid voxel of a world in a layout.
#[derive(Clone, Copy, Debug)]
pub struct BytesPerVoxel {
    /// Of the words with the places of voxels.
    pub geometry: f64,
    /// Of that and of materials.
    pub all: f64,
}

/// The runs: every combination.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// Project paths.
    pub graphs: Vec<String>,
    /// Layouts of the world; the graph's own when empty.
    pub layouts: Vec<Layout>,
    /// Those of the graphs that are run over their own layout only.
    pub own: Vec<String>,
    /// Project paths.
    pub worlds: Vec<String>,
    /// Names of cameras; all that a world names, or else its first, when empty.
    pub cameras: Vec<String>,
    /// Extents in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// How long each is measured.
    pub effort: Effort,
}

/// How long a case is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Effort {
    /// Frames that are run first and not timed; fewer when they take half of `seconds`, more on a GPU until it is awake.
    pub warmup: u32,
    /// Frames that are timed.
    pub frames: u32,
    /// After this many seconds of timed frames no more are begun, once there are three; after four times as many in any case.
    pub seconds: f64,
}

impl Default for Effort {
    fn default() -> Self {
        Self { warmup: 4, frames: 32, seconds: 2.0 }
    }
}

/// One combination.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Case {
    /// Project path.
    pub graph: String,
    /// Layout of its world; `None` when it binds no world.
    pub layout: Option<&'static str>,
    /// Project path.
    pub world: String,
    /// Name of the camera; `camera` for the world's first.
    pub camera: String,
    /// Extent in pixels.
    pub size: [u32; 2],
}

/// The result of a combination.
#[derive(Clone, Debug)]
pub struct Row {
    /// The combination.
    pub case: Case,
    /// The measurement, or the reason why there is none.
    pub outcome: Result<Measured, Refusal>,
}

/// Why nothing could be measured.
#[derive(Clone, Debug, Default)]
pub struct Refusal {
    /// In a line.
    pub reason: String,
    /// The planner's messages about it, with places in the graph's files.
    pub found: Vec<Diagnostic>,
    /// The texts that these point into.
    pub texts: Arc<SourceMap>,
}

impl Refusal {
    pub(self) fn new(reason: String) -> Self {
        Self { reason, ..Self::default() }
    }

    /// Of diagnostics; `texts` are to be added.
    pub(self) fn of(found: Vec<Diagnostic>) -> Self {
        Self { reason: measure::first(&found), found, ..Self::default() }
    }
}

/// Measurements of one combination.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Rays that the time is for: pixels, or hits for a graph that bounces.
    pub rays: u64,
    /// The rays are those that leave the hits of the pixels.
    pub bounced: bool,
    /// Frames that were timed.
    pub frames: u32,
    /// GPU time of a frame, from the begin of its first pass to the end of its last; of the pass whose name begins with `bounce` for a graph that bounces.
    pub time: Spread,
    /// GPU time of each pass.
    pub passes: Vec<PassSpread>,
    /// Passes that do not depend on the camera, and so run once and not in every frame: GPU time of that once.
    pub once: Vec<PassSpread>,
    /// Cells looked at, a ray.
    pub steps: Option<f64>,
    /// The memory of the layout.
    pub cost: Option<LayoutCost>,
    /// Solid voxels of the world.
    pub voxels: u64,
    /// Whether `judgement` is of depths too.
    pub depths: bool,
    /// Its errors, or the reason why they are unknown.
    pub judgement: Result<Errors, String>,
    /// Whether the graph claims to be exact: its `about` ends with that word.
    pub claims_exact: bool,
}

/// Median and 95th percentile, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Half of the frames took no longer.
    pub median: f64,
    /// 95 of 100 frames took no longer.
    pub p95: f64,
}

/// A pass with its time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassSpread {
    /// Its name.
    pub pass: String,
    /// Its time.
    #[serde(flatten)]
    pub time: Spread,
}

impl Measured {
    /// Rays that a graph that claims to be exact gets wrong, or whose t is off by more than it may be.
    pub fn broken(&self) -> u64 {
        let errors = self.judgement.as_ref().ok().filter(|_| self.claims_exact);
        errors.map_or(0, |errors| errors.wrong() + errors.inexact())
    }

    /// Millions of rays a second, by the median.
    pub fn mrays(&self) -> f64 {
        self.rays as f64 / self.time.median / 1e3
    }

    /// Nanoseconds a ray, by the median.
    pub fn nanoseconds_a_ray(&self) -> f64 {
        self.time.median * 1e6 / self.rays.max(1) as f64
    }

    /// Bytes a solid voxel.
    pub fn bytes_a_voxel(&self) -> Option<BytesPerVoxel> {
        let cost = self.cost.filter(|_| self.voxels > 0)?;
        let a_voxel = |bytes: u64| bytes as f64 / self.voxels as f64;
        Some(BytesPerVoxel {
            geometry: a_voxel(cost.geometry_bytes),
            all: a_voxel(cost.geometry_bytes + cost.attribute_bytes),
        })
    }

    /// Millions of voxels encoded a second.
    pub fn encoded_mvoxels(&self) -> Option<f64> {
        self.cost.filter(|cost| cost.encode_seconds > 0.0).map(|cost| self.voxels as f64 / cost.encode_seconds / 1e6)
    }
}

impl Spread {
    /// Of samples in any unit, by nearest rank; `None` of none.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a rank is at most the number of samples"
    )]
    pub fn of(samples: &[f64]) -> Option<Self> {
        let mut sorted = samples.to_vec();
        sorted.sort_by(f64::total_cmp);
        let rank = |part: f64| sorted.get(((part * sorted.len() as f64).ceil() as usize).max(1) - 1).copied();
        Some(Self { median: rank(0.5)?, p95: rank(0.95)? })
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "ranks are picked from the samples, not computed")]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_of_nearest_ranks() {
        let samples: Vec<f64> = (1..=20).rev().map(f64::from).collect();
        assert_eq!(Spread::of(&samples), Some(Spread { median: 10.0, p95: 19.0 }));
        assert_eq!(Spread::of(&[3.0]), Some(Spread { median: 3.0, p95: 3.0 }));
        assert_eq!(Spread::of(&[]), None);
    }
}
