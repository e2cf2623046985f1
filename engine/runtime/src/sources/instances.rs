//! The instances of a world on the device: their poses follow from params, and from records of passes.

use std::collections::BTreeSet;
use std::sync::Arc;

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_execute::ExternalResource;
use raxel_graph::checked::{Graph, Resource, Value};
use raxel_layouts::instances::{Frame, InstanceBuffer, Instances, Pose};
use raxel_layouts::{EncodingLimits, LayoutError};

use crate::params;
use crate::world::SessionWorld;

/// Poses that passes have written, which hold until others are written or time jumps.
#[derive(Clone, Debug, Default)]
pub(crate) struct WrittenPoses {
    by_instance: Vec<Option<Pose>>,
    /// Counts changes.
    serial: u64,
}

impl WrittenPoses {
    /// Takes the records of a frame.
    pub(crate) fn take(&mut self, poses: &[(usize, Option<Pose>)]) {
        for &(index, pose) in poses {
            if self.by_instance.len() <= index {
                self.by_instance.resize(index + 1, None);
            }
            if self.by_instance[index] != pose {
                self.by_instance[index] = pose;
                self.serial += 1;
            }
        }
    }

    /// Gives all instances back to the world's file and to params.
    pub(crate) fn forget(&mut self) {
        if !self.by_instance.is_empty() {
            self.by_instance.clear();
            self.serial += 1;
        }
    }

    /// The number of changes so far.
    pub(crate) fn serial(&self) -> u64 {
        self.serial
    }
}

/// The poses of a world's instances, by records of passes and by the params of a graph.
pub(crate) fn frames(instances: &Instances, graph: &Graph, values: &[Value], written: &WrittenPoses) -> Vec<Frame> {
    instances.frames_with(&written.by_instance, |param| {
        let id = graph.find_param(param)?;
        number(&values[id.0 as usize])
    })
}

/// Instances that are on a device.
#[derive(Debug)]
pub(crate) struct LiveInstances {
    instances: Instances,
    buffer: InstanceBuffer,
    /// Their poses in the last write.
    shown: Vec<Frame>,
    /// The graph, the values of its params and the state of the written poses that this follows from; `None` before the first frame.
    followed: Option<(Arc<Graph>, Vec<Value>, u64)>,
}

impl LiveInstances {
    /// Those of a world, where they stand without any param; with the words of their buffer.
    pub(crate) fn new(world: &SessionWorld, limits: EncodingLimits) -> Result<(Self, Vec<u32>), LayoutError> {
        let instances = world.instances().clone();
        let buffer = instances.encode(world.palette(), limits.buffer_bytes)?;
        let shown = instances.frames(|_| None);
        let words = buffer.words(&shown);
        Ok((Self { instances, buffer, shown, followed: None }, words))
    }

    /// Moves them to the poses of passes and of the graph's params, before the next frame. Does nothing while these stay the same.
    pub(crate) fn follow(
        &mut self,
        graph: &Arc<Graph>,
        values: &[Value],
        written: &WrittenPoses,
        source: &Arc<ExternalResource>,
    ) {
        let same = |(known, seen, serial): &(Arc<Graph>, Vec<Value>, u64)| {
            Arc::ptr_eq(known, graph) && seen == values && *serial == written.serial
        };
        if self.followed.as_ref().is_some_and(same) {
            return;
        }
        let frames = frames(&self.instances, graph, values, written);
        // If too many writes wait already, the next frame tries again.
        let words = || self.buffer.moving(&frames);
        if frames == self.shown || source.write(0, bytemuck::cast_slice(&words())).is_ok() {
            self.shown = frames;
            self.followed = Some((graph.clone(), values.to_vec(), written.serial));
        }
    }
}

/// A param that can move an instance.
fn number(value: &Value) -> Option<f64> {
    match value {
        Value::I32(_) | Value::U32(_) | Value::F32(_) => params::components(value).first().copied(),
        _ => None,
    }
}

/// The mistakes in moving the instances of a world by the params of a graph that binds them as `resource`.
pub(crate) fn check(graph: &Graph, world: &SessionWorld, resource: &Resource) -> Vec<Diagnostic> {
    let motions = world.instances().list.iter().flat_map(|instance| &instance.motions);
    let needed: BTreeSet<&str> = motions.filter(|m| m.default.is_none()).map(|m| m.param.as_str()).collect();
    let numbers = || graph.params.iter().filter(|param| number(&param.default).is_some()).map(|p| p.name.as_str());
    let missing = needed.into_iter().filter(|name| numbers().all(|known| known != *name));
    let whose = world.path.as_deref().unwrap_or("the world");
    let diagnostic = |name: &str| {
        let message = match graph.find_param(name) {
            None => format!("instances of `{whose}` are moved by `{name}`, which is not a param of the graph"),
            Some(_) => format!("instances of `{whose}` are moved by the param `{name}`, which is not a single number"),
        };
        let error = Diagnostic::error(codes::world::INSTANCE_PARAM, message).label(resource.place.clone(), "for this");
        match closest(name, numbers()) {
            Some(close) => error.help(format!("did you mean `{close}`?")),
            None if numbers().next().is_none() => {
                error.help(format!("declare it: [params.{name}] with type = \"f32\""))
            }
            None => {
                error.help(format!("numbers among the params: {}; or give the instance a `default`", list(numbers())))
            }
        }
    };
    missing.map(diagnostic).collect()
}
