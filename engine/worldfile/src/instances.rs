//! `[[instances]]`: models that stand in the world without being part of its voxels.

use std::collections::BTreeSet;
use std::sync::Arc;

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, codes};

use super::operations::{OperationReader, anchor, anchor_cell};
use raxel_layouts::instances::{
    Axis, COORDINATES, Instance, InstanceModel, Instances, MAX_INSTANCES, Motion, MotionKind, Pose,
};

/// Words for [`Axis`].
const AXES: &[(&str, Axis)] = &[("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)];
/// Voxels that an instance's model may have along an axis.
const MOST_VOXELS: i64 = 1 << 16;

/// Reads all of them; their materials join the palette.
pub(super) fn read(root: &Table<'_, '_>, reader: &mut OperationReader) -> Instances {
    let mut instances = Instances::default();
    let mut names = BTreeSet::new();
    for table in &root.array_of_tables("instances") {
        let Some(read) = read_one(table, reader, &mut names, &mut instances.models) else { continue };
        let wanted = instances.list.len() + read.count();
        if wanted > MAX_INSTANCES {
            root.reporter().report(
                Diagnostic::error(
                    codes::world::TOO_MANY_INSTANCES,
                    format!("the world has {wanted} instances or more; at most {MAX_INSTANCES} are allowed"),
                )
                .label(table.span().clone(), "this is too many")
                .help("build what never moves into the world: [[build]] with op = \"model\" or \"scatter\""),
            );
            break;
        }
        instances.list.extend(read.all());
    }
    instances
}

/// What one table of the file declares: instances of one model in a grid.
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

fn read_one(
    table: &Table<'_, '_>,
    reader: &mut OperationReader,
    names: &mut BTreeSet<String>,
    models: &mut Vec<InstanceModel>,
) -> Option<Grid> {
    let name = table.string("name");
    let model = table.need("model").and_then(|node| reader.model(&node));
    let position = table.need("position").and_then(|node| node.numbers::<3>(Pose::COORDINATES));
    let degrees = |key: &str| table.get(key).map_or(Some(0.0), |node| node.number(-360.0..=360.0));
    let (yaw, pitch, roll) = (degrees("yaw"), degrees("pitch"), degrees("roll"));
    let about = anchor(table);
    let counts = table.get("count").map_or(Some([1; 3]), |node| node.integers(1..=MAX_INSTANCES));
    let step = table.get("step").map_or(Some([0.0; 3]), |node| node.numbers::<3>(-1.0e6..=1.0e6));
    let slide = table.get("slide").map(|node| read_slide(&node));
    let turn = table.get("turn").map(|node| read_turn(&node));
    table.finish();
    if let Some((name, place)) = &name
        && !names.insert(name.clone())
    {
        table.reporter().report(
            Diagnostic::error(codes::world::INSTANCE_NAME, format!("two instances are called `{name}`"))
                .label(place.clone(), "the second one")
                .help("give it another name, or none"),
        );
    }
    let model = model?;
    let anchor = anchor_cell(about?, &model.voxels);
    let pose = Pose::new(position?, [yaw?, pitch?, roll?]);
    let motions = [turn, slide].into_iter().flatten().collect::<Option<Vec<_>>>()?;
    let shown = InstanceModel { voxels: model.voxels, materials: model.materials };
    let name = name.map(|(name, _)| name);
    let mut grid = Grid { first: Instance { name, model: 0, anchor, pose, motions }, counts: counts?, step: step? };
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

fn read_slide(node: &Node<'_, '_>) -> Option<Motion> {
    let table = node.table()?;
    let along = table.need("along").and_then(|node| node.numbers::<3>(-1.0e6..=1.0e6));
    let by = read_param(&table);
    table.finish();
    let (param, default) = by?;
    Some(Motion { param, default, kind: MotionKind::Slide(along?) })
}

fn read_turn(node: &Node<'_, '_>) -> Option<Motion> {
    let table = node.table()?;
    let axis = table.get("axis").map_or(Some(Axis::Y), |node| node.word(AXES));
    let about = match table.get("about") {
        Some(node) => node.numbers::<3>(Pose::COORDINATES).map(Some),
        None => Some(None),
    };
    let upright = table.get("upright").map_or(Some(false), |node| node.boolean());
    let by = read_param(&table);
    table.finish();
    let (param, default) = by?;
    let kind = MotionKind::Turn { axis: axis?, about: about?, upright: upright? };
    Some(Motion { param, default, kind })
}

/// The param that moves an instance, and its value for graphs without it.
fn read_param(table: &Table<'_, '_>) -> Option<(String, Option<f64>)> {
    let param = table.need("param").and_then(|node| node.string());
    let default = table.get("default").map(|node| node.number(-1.0e6..=1.0e6));
    match default {
        Some(value) => Some((param?, Some(value?))),
        None => Some((param?, None)),
    }
}
