//! The plan of a run.

use std::fmt;
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::time::Duration;

use glam::IVec3;
use raxel_layouts::Layout;
use raxel_oracle::camera::Tile;
use raxel_oracle::metrics::most_steps;
use raxel_oracle::scenes::Scene;
use raxel_oracle::sets::RaySet;
use raxel_oracle::{Hit, Ray};
use raxel_world::World;

use crate::rays::Method;

/// The kind of work of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The rays, from their origin.
    Rays,
    /// The rays, begun ahead of their origin, up to the time until which they are free by the exact tracer.
    Ahead,
    /// Tiles of pixels.
    Tiles,
    /// The period rays next to the rays.
    Periods,
    /// The rays, through the world and instances in it.
    Instances,
    /// Rays that go on from the hits of the rays.
    Onward,
    /// The same through the world and instances in it.
    OnwardInstances,
    /// The rays, and others that are aimed at the remaining voxels, through a copy in which a shader has set voxels.
    Stored,
    /// The rays, and others that are aimed at the voxels after edits, through publications of the world while it is streamed and edited.
    Streamed,
}

/// Who traces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Row {
    /// A method on the device.
    Device(Method),
    /// The tracer of `tree64` on the CPU ([`raxel_oracle::port`]), which must give the device's hits bit for bit.
    Port,
}

impl Row {
    /// The row that decides whether a run passes: the exact tracer of the default layout.
    pub fn default_tracer() -> Self {
        Row::Device(Method::of(Layout::TREE64))
    }

    /// Whether it claims to be exact: a layout's own tracer; one of the other ways to call it, or its CPU port; or the conservative table
    /// of masks.
    pub fn exact(&self) -> bool {
        self.marcher().is_none_or(|marcher| marcher == "raymask" || Self::WAYS.contains(&marcher))
    }

    /// The marcher that begins rays ahead of their origin, up to the time until which they are free by the exact tracer.
    pub const AHEAD: &str = "ahead";

    /// The marcher that begins the rays of a tile of pixels where the tile is still free by a beam (`shaders/include/raxel/beam.glsl`). It
    /// traces the sets that are made of tiles, and no others.
    pub const BEAM: &str = "beam";

    /// The marcher that walks the tree once for the rays of a tile (`shaders/include/raxel/packet.glsl`), and traces the rest ray by ray.
    /// It traces the sets that are made of tiles, and no others.
    pub const PACKET: &str = "packet";

    /// The marcher that walks the tree once for 64 rays in a row of one direction (`shaders/include/raxel/parallel.glsl`), and traces the
    /// rest ray by ray.
    pub const PARALLEL: &str = "parallel";

    /// The same as for shadows: whether a ray hits anything.
    pub const PARALLEL_ANY: &str = "parallel_any";

    /// The marcher that traces the period rays next to the rays (`shaders/include/raxel/period.glsl`), over the layout `flat64`.
    pub(crate) const PERIOD: &str = "period";

    /// The same with lanes that take new rays when theirs have ended (`shaders/include/raxel/refill.glsl`).
    pub const REFILL: &str = "refill";

    /// The marcher that traces the world with instances at any pose in it (`shaders/include/raxel/instances.glsl`).
    pub const INSTANCES: &str = "instances";

    /// The marcher that traces rays that go on from the hits of others (`rx_ray_from_hit`).
    pub const ONWARD: &str = "onward";

    /// The same through the world with instances (`rx_scene_ray_from_hit`).
    pub const INSTANCES_ONWARD: &str = "instances_onward";

    /// The marcher that traces a copy of the world in which a shader has set voxels (`rx_set`).
    pub const STORED: &str = "stored";

    /// The marcher that traces a streamer's publications of the world while that is edited (`engine/stream`), over the layout `tree64`.
    pub const STREAMED: &str = "streamed";

    /// Every marcher that is another way to call an exact tracer.
    pub const WAYS: [&str; 12] = [
        Self::AHEAD,
        Self::BEAM,
        Self::PACKET,
        Self::PARALLEL,
        Self::PARALLEL_ANY,
        Self::PERIOD,
        Self::REFILL,
        Self::INSTANCES,
        Self::ONWARD,
        Self::INSTANCES_ONWARD,
        Self::STORED,
        Self::STREAMED,
    ];

    /// The marchers that trace period rays.
    pub const PERIODS: [&str; 2] = [Self::PERIOD, Self::REFILL];

    fn marcher(&self) -> Option<&str> {
        match self {
            Row::Device(method) => method.marcher.as_deref(),
            Row::Port => None,
        }
    }

    pub(super) fn kind(&self) -> Kind {
        match self.marcher() {
            Some(Self::AHEAD) => Kind::Ahead,
            Some(Self::BEAM | Self::PACKET) => Kind::Tiles,
            Some(Self::PERIOD | Self::REFILL) => Kind::Periods,
            Some(Self::INSTANCES) => Kind::Instances,
            Some(Self::ONWARD) => Kind::Onward,
            Some(Self::INSTANCES_ONWARD) => Kind::OnwardInstances,
            Some(Self::STORED) => Kind::Stored,
            Some(Self::STREAMED) => Kind::Streamed,
            _ => Kind::Rays,
        }
    }

    /// Whether it can trace a ray that is given alone.
    pub fn traces_alone(&self) -> bool {
        matches!(self.kind(), Kind::Rays | Kind::Ahead | Kind::Periods | Kind::Streamed)
    }

    /// Whether it traces tiles of pixels.
    pub(crate) fn traces_tiles(&self) -> bool {
        self.kind() == Kind::Tiles
    }

    /// Whether it traces instances, too.
    pub(super) fn traces_instances(&self) -> bool {
        matches!(self.kind(), Kind::Instances | Kind::OnwardInstances)
    }

    /// How many steps it can have taken to a hit. Those of an exact tracer are cells on the ray, but those of `bvh` are nodes beside it, too, and
    /// packets count none.
    pub fn steps(&self, ray: &Ray, hit: &Hit) -> RangeInclusive<u64> {
        let packet = matches!(self.marcher(), Some(Self::PACKET | Self::PARALLEL | Self::PARALLEL_ANY));
        let nodes = matches!(self, Row::Device(method) if method.layout == raxel_rivals::BVH);
        let most = if self.exact() && !packet && !nodes { most_steps(ray, hit) } else { u64::MAX };
        u64::from(!packet)..=most
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Row::Device(method) => method.fmt(f),
            Row::Port => f.write_str("tree64:cpu"),
        }
    }
}

/// A world that rays are traced through.
#[derive(Clone)]
pub struct Site {
    /// Name; of a scene `NAME@near` or `NAME@far`.
    pub name: String,
    source: Source,
}

#[derive(Clone)]
enum Source {
    Scene(&'static Scene, IVec3),
    World(Arc<World>),
}

/// Which sites of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sites {
    /// Around the origin, or beside it.
    Near,
    /// At an end of the range of coordinates.
    Far,
}

impl Site {
    /// A scene at one of its sites. Scenes take turns at three ends of the range of `i32`.
    pub fn scene(scene: &'static Scene, sites: Sites) -> Self {
        let at = |name: &str| name.bytes().map(usize::from).sum::<usize>() % 3;
        let (name, corner) = match sites {
            Sites::Near => {
                // Some lie where a place in the world's cube and its coordinates differ on every axis.
                let corner = if at(scene.name) == 1 { IVec3::new(70, 133, 200) } else { IVec3::new(-13, 5, -40) };
                (format!("{}@near", scene.name), corner)
            }
            Sites::Far => {
                // The last voxel at the largest coordinate.
                let end = i32::MAX - (scene.size - 1);
                let ends = [IVec3::MIN, IVec3::splat(end), IVec3::new(i32::MIN, 1 << 30, end)];
                (format!("{}@far", scene.name), ends[at(scene.name)])
            }
        };
        Self { name, source: Source::Scene(scene, corner) }
    }

    /// A world that is there.
    pub fn world(name: impl Into<String>, world: Arc<World>) -> Self {
        Self { name: name.into(), source: Source::World(world) }
    }

    /// Builds it.
    pub fn build(&self, seed: u64) -> Arc<World> {
        match &self.source {
            Source::Scene(scene, corner) => Arc::new(scene.world(*corner, seed)),
            Source::World(world) => world.clone(),
        }
    }
}

impl fmt::Debug for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Site").field(&self.name).finish()
    }
}

/// Everything that a run depends on.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Who traces. A row's hits are judged one by one, but the port's are also compared with those of `tree64`, if that comes before.
    pub rows: Vec<Row>,
    /// Which rays.
    pub sets: Vec<&'static RaySet>,
    /// The sites that they go through.
    pub sites: Vec<Site>,
    /// Rays of all rows, sets and sites together; each combination gets the same number, at least 1.
    pub rays: u64,
    /// Other seeds, other rays and other random scenes.
    pub seed: u64,
    /// The time for one submission of rays, after which the device counts as hung.
    pub watchdog: Duration,
}

impl Plan {
    /// Rays of each combination of row, set and site. From a tile on, whole tiles: the rays of a list are traced 64 at a time, so a part of a tile
    /// would put the tiles of all later sets across two groups.
    pub fn rays_each(&self) -> u64 {
        let combinations = (self.rows.len() * self.sets.len() * self.sites.len()).max(1) as u64;
        let each = self.rays.div_ceil(combinations).max(1);
        let tile = Tile::RAYS as u64;
        if each < tile { each } else { each.next_multiple_of(tile) }
    }

    /// Rays of each row and site, of all sets.
    pub(crate) fn rays_a_site(&self) -> u64 {
        self.rays_each() * self.sets.len() as u64
    }

    /// Rays of all rows, sets and sites: `rays`, rounded up.
    pub fn total(&self) -> u64 {
        self.rays_a_site() * (self.rows.len() * self.sites.len()) as u64
    }
}
