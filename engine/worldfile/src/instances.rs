//! `[[instances]]`: models that stand in the world without being part of its voxels.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::sync::Arc;

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_language::{Keys, ReadKeys, Shape};
use raxel_layouts::instances::{
    Axis, COORDINATES, Instance, InstanceModel, Instances, MAX_INSTANCES, Motion, MotionKind, Pose,
};

use super::models::Model;
use super::placing::Anchor;
use super::reading::Reading;

/// Voxels that an instance's model may have along an axis.
const MOST_VOXELS: i64 = 1 << 16;
/// Numbers that a movement may have.
const STEPS: RangeInclusive<f64> = -1.0e6..=1.0e6;

/// One of `[[instances]]`.
#[derive(Keys)]
#[keys(context = Reading<'_>)]
struct InstanceKeys {
    /// Name of the instance; may be left out.
    name: Option<String>,
    /// Name of one of [models].
    model: Model,
    /// Place of the anchor's cell, in voxels. Fractions are allowed.
    #[keys(range = Pose::COORDINATES)]
    position: [f64; 3],
    /// Degrees to the left, seen from above, about the centre of the anchor's cell.
    #[keys(range = -360.0..=360.0, default = 0.0)]
    yaw: f64,
    /// Degrees about its own X axis, before yaw.
    #[keys(range = -360.0..=360.0, default = 0.0)]
    pitch: f64,
    /// Degrees about its own Z axis, before pitch.
    #[keys(range = -360.0..=360.0, default = 0.0)]
    roll: f64,
    /// Point of the model: the centre of its lowest layer, its smallest corner, or the origin of its file.
    #[keys(default = Anchor::Base)]
    anchor: Anchor,
    /// How many instances along x, y and z. They are numbered along x first.
    #[keys(range = 1..=MAX_INSTANCES, default = [1; 3])]
    count: [usize; 3],
    /// Voxels from one instance to the next along x, y and z. All are in one place when left out.
    #[keys(range = STEPS, absent = [0.0; 3])]
    step: [f64; 3],
    /// Turns it by a param, about an axis of the world.
    turn: Option<Turn>,
    /// Moves it by a param, after `turn`.
    slide: Option<Slide>,
}

/// `slide`.
#[derive(Keys)]
struct Slide {
    /// Name of a param of the graph, a number.
    param: String,
    /// Voxels along each axis for a value of 1.
    #[keys(range = STEPS)]
    along: [f64; 3],
    /// Value in graphs without this param, in units of the param. Such graphs are refused when left out.
    #[keys(range = STEPS)]
    default: Option<f64>,
}

/// `turn`.
#[derive(Keys)]
struct Turn {
    /// Name of a param of the graph, a number: degrees to the left, seen from the end of the axis.
    param: String,
    /// An axis of the world.
    #[keys(default = Axis::Y)]
    axis: Axis,
    /// A point on the axis, in voxels. The centre of the instance's anchor when left out.
    #[keys(range = Pose::COORDINATES)]
    about: Option<[f64; 3]>,
    /// The instance moves around the axis without turning itself.
    #[keys(default = false)]
    upright: bool,
    /// Value in graphs without this param, in units of the param. Such graphs are refused when left out.
    #[keys(range = STEPS)]
    default: Option<f64>,
}

impl From<Slide> for Motion {
    fn from(Slide { param, along, default }: Slide) -> Self {
        Self { param, default, kind: MotionKind::Slide(along) }
    }
}

impl From<Turn> for Motion {
    fn from(Turn { param, axis, about, upright, default }: Turn) -> Self {
        Self { param, default, kind: MotionKind::Rotation { axis, about, upright } }
    }
}

/// The shape of `[[instances]]`.
pub(super) fn declared() -> Shape {
    Shape::array(Shape::Table(InstanceKeys::form()), ..=MAX_INSTANCES)
}

/// Reads `[[instances]]`; their materials join the palette.
pub(super) fn read(node: &Node<'_, '_>, reading: &Reading<'_>) -> Option<Instances> {
    let mut instances = Instances::default();
    let mut names = BTreeSet::new();
    for table in node.array()?.iter().filter_map(Node::table) {
        let keys = InstanceKeys::read_whole(&table, reading);
        if let Some(name) = table.peek("name", Node::string)
            && let Some(node) = table.get("name").filter(|_| !names.insert(name.clone()))
        {
            table.reporter().report(
                Diagnostic::error(codes::world::INSTANCE_NAME, format!("two instances are called `{name}`"))
                    .label(node.span, "the second one")
                    .help("give it another name, or none"),
            );
        }
        let Some(read) = keys.and_then(|keys| keys.grid(&table, &mut instances.models)) else { continue };
        let wanted = instances.list.len() + read.count();
        if wanted > MAX_INSTANCES {
            table.reporter().report(
                Diagnostic::error(
                    codes::world::TOO_MANY_INSTANCES,
                    format!("the world has {wanted} instances or more; at most {MAX_INSTANCES} are allowed"),
                )
                .label(table.span().clone(), "this is too many")
                .help("build models that never move into the world: [[build]] with op = \"model\" or \"scatter\""),
            );
            break;
        }
        instances.list.extend(read.all());
    }
    Some(instances)
}

/// One table of the file: instances of one model in a grid.
struct Grid {
    first: Instance,
    /// How many there are along each axis of the world.
    counts: [usize; 3],
    /// Voxels from one to the next along each axis.
    step: [f64; 3],
}

impl Grid {
    fn count(&self) -> usize {
        self.counts.iter().product()
    }

    fn position(&self, steps: [usize; 3]) -> [f64; 3] {
        std::array::from_fn(|i| self.first.pose.position[i] + steps[i] as f64 * self.step[i])
    }

    /// Those along X first, then along Y, then along Z. The name is that of the first.
    fn all(&self) -> impl Iterator<Item = Instance> + '_ {
        let [across, up, _] = self.counts;
        (0..self.count()).map(move |i| {
            let position = self.position([i % across, i / across % up, i / across / up]);
            let pose = Pose { position, ..self.first.pose };
            Instance { name: self.first.name.clone().filter(|_| i == 0), pose, ..self.first.clone() }
        })
    }
}

impl InstanceKeys {
    fn grid(self, table: &Table<'_, '_>, models: &mut Vec<InstanceModel>) -> Option<Grid> {
        let Self { name, model, position, yaw, pitch, roll, anchor, count, step, turn, slide } = self;
        let anchor = anchor.cell(&model.voxels);
        let pose = Pose::new(position, [yaw, pitch, roll]);
        let motions = turn.map(Motion::from).into_iter().chain(slide.map(Motion::from)).collect();
        let shown = InstanceModel { voxels: model.voxels, materials: model.materials };
        let mut grid = Grid { first: Instance { name, model: 0, anchor, pose, motions }, counts: count, step };
        let (size, last) = (shown.size(), grid.position(grid.counts.map(|count| count - 1)));
        let reach = shown.reach(pose.position).max(shown.reach(last));
        if size > MOST_VOXELS || reach > COORDINATES as f64 {
            let why = if size > MOST_VOXELS {
                format!("the model reaches {size} voxels from its origin; that of an instance at most {MOST_VOXELS}")
            } else {
                format!("an instance reaches {reach:.0} voxels from the origin of the world, at most {COORDINATES}")
            };
            let error = Diagnostic::error(codes::world::INSTANCE_RANGE, why);
            table.reporter().report(error.label(table.span().clone(), "this instance"));
            return None;
        }
        let known = models.iter().position(|known| Arc::ptr_eq(&known.materials, &shown.materials));
        grid.first.model = known.unwrap_or_else(|| {
            models.push(shown);
            models.len() - 1
        });
        Some(grid)
    }
}
