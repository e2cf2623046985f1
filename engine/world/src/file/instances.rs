//! `[[instances]]`: models that stand in the world without being part of its voxels.

use std::collections::BTreeSet;
use std::sync::Arc;

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, codes};

use super::operations::{OperationReader, anchor, anchor_cell};
use crate::instances::{
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
    let tables = root.array_of_tables("instances");
    if let Some(first) = tables.get(MAX_INSTANCES) {
        root.reporter().report(
            Diagnostic::error(
                codes::world::TOO_MANY_INSTANCES,
                format!("the world has {} instances; at most {MAX_INSTANCES} are allowed", tables.len()),
            )
            .label(first.span().clone(), "this one is too many")
            .help("build what never moves into the world: [[build]] with op = \"model\" or \"scatter\""),
        );
        return instances;
    }
    for table in &tables {
        instances.list.extend(read_one(table, reader, &mut names, &mut instances.models));
    }
    instances
}

fn read_one(
    table: &Table<'_, '_>,
    reader: &mut OperationReader,
    names: &mut BTreeSet<String>,
    models: &mut Vec<InstanceModel>,
) -> Option<Instance> {
    let name = table.string("name");
    let model = table.need("model").and_then(|node| reader.model(&node));
    let position = table.need("position").and_then(|node| node.numbers::<3>(Pose::COORDINATES));
    let degrees = |key: &str| table.get(key).map_or(Some(0.0), |node| node.number(-360.0..=360.0));
    let (yaw, pitch, roll) = (degrees("yaw"), degrees("pitch"), degrees("roll"));
    let about = anchor(table);
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
    if let Some(bounds) = model.voxels.bounds() {
        let size = (0..3).map(|i| (bounds.max[i] - bounds.min[i]).max(bounds.max[i].abs()).max(bounds.min[i].abs()));
        let size = size.max().unwrap_or(0);
        let reach = pose.position.iter().fold(0.0_f64, |far, p| far.max(p.abs())) + 2.0 * size as f64;
        if size > MOST_VOXELS || reach > COORDINATES as f64 {
            let why = if size > MOST_VOXELS {
                format!("the model reaches {size} voxels from its origin; that of an instance at most {MOST_VOXELS}")
            } else {
                format!("an instance reaches {reach:.0} voxels from the origin of the world, at most {COORDINATES}")
            };
            table.reporter().report(
                Diagnostic::error(codes::world::INSTANCE_RANGE, why).label(table.span().clone(), "this instance"),
            );
            return None;
        }
    }
    let known = models.iter().position(|known| Arc::ptr_eq(&known.materials, &model.materials));
    let index = known.unwrap_or_else(|| {
        models.push(InstanceModel { voxels: model.voxels, materials: model.materials });
        models.len() - 1
    });
    Some(Instance { name: name.map(|(name, _)| name), model: index, anchor, pose, motions })
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
