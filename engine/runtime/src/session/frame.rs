//! One frame, and what can be read of it.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use raxel_gpu::Surface;
use raxel_graph::checked::ResourceId;

use super::{FrameError, ReadError, Session};
use crate::build::{self, Assembly, BuildError, Selection};
use crate::clock::FrameTime;
use crate::execute::{Builtins, ExecuteError, FrameInputs, FrameReport, Picture, Texels};
use crate::params::SetError;

/// Most plans that are kept for the time when they are wanted again: debug targets that are looked at in turn.
const KEPT_PLANS: usize = 16;

impl Session {
    /// Runs the next frame without a window.
    pub fn frame(&mut self) -> Result<FrameReport, FrameError> {
        let time = self.begin()?;
        loop {
            match self.run(&time, None) {
                Err(error @ ExecuteError::DeviceLost { .. }) => self.recover(error)?,
                result => return result.map_err(FrameError::Device),
            }
        }
    }

    /// Runs the next frame and presents it. After [`FrameError::SurfaceLost`] the window needs a new surface.
    pub fn frame_on(&mut self, surface: &mut Surface) -> Result<FrameReport, FrameError> {
        let time = self.begin()?;
        match self.run(&time, Some(surface)) {
            Err(error @ ExecuteError::DeviceLost { .. }) => {
                self.recover(error)?;
                Err(FrameError::SurfaceLost)
            }
            result => result.map_err(FrameError::Device),
        }
    }

    /// Brings everything to the time of the next frame.
    fn begin(&mut self) -> Result<FrameTime, FrameError> {
        let time = self.clock.tick(Instant::now());
        self.values.clear();
        self.values.extend_from_slice(self.params.values());
        if let Some(demo) = self.demo.as_ref().filter(|_| !self.taken_over) {
            let at = demo.at(time.time, &self.graph);
            if let Some(camera) = at.camera {
                self.camera = camera;
            }
            for (name, value) in at.params {
                if let Some(id) = self.graph.find_param(&name) {
                    self.values[id.0 as usize] = value;
                }
            }
            // A demo changes what is shown at its keys, not in between: a choice of the user's stays until the next key.
            if self.demo_target.as_ref() != Some(&at.debug_target) {
                if self.demo_target.is_some() || !at.debug_target.resource.is_empty() {
                    self.debug_target = at.debug_target.clone();
                }
                self.demo_target = Some(at.debug_target);
            }
        }
        if time.index == 0 && time.advanced {
            self.previous_camera = self.camera;
        }
        self.replan()?;
        Ok(time)
    }

    fn run(&mut self, time: &FrameTime, window: Option<&mut Surface>) -> Result<FrameReport, ExecuteError> {
        let builtins = self.builtins(time);
        let inputs = FrameInputs {
            builtins: &builtins,
            params: &self.values,
            overrides: &self.overrides,
            clock: time.time,
            disabled: &self.disabled,
        };
        let report = self.executor.frame(&inputs, window)?;
        self.previous_camera = self.camera;
        Ok(report)
    }

    fn builtins(&self, time: &FrameTime) -> Builtins {
        Builtins {
            frame_index: time.index as u32,
            frame_time: time.time as f32,
            frame_delta: time.delta as f32,
            cursor_position: self.cursor.unwrap_or([-1; 2]),
            ..Builtins::of(&self.camera, &self.previous_camera, self.output, &self.world)
        }
    }

    /// Swaps in a plan for another selection of the same graph and world.
    pub(super) fn plan_for(&mut self, selection: Selection) -> Result<(), FrameError> {
        let known = self.plans.iter().find(|(known, _)| *known == selection).map(|(_, plan)| plan.clone());
        let built = match known {
            Some(plan) => build::sources(&plan, &self.world, &self.context).map(|sources| Assembly { plan, sources }),
            None => build::assemble(&self.graph, &self.world, &selection, &self.context),
        };
        let prepared = built.and_then(|assembly| {
            build::prepare(&assembly, &self.context).map(|prepared| (assembly.plan.clone(), prepared))
        });
        let (plan, prepared) = prepared.map_err(|error| self.plan_error(error))?;
        self.executor.swap(prepared);
        self.remember(selection, plan);
        Ok(())
    }

    /// Notes the plan that runs.
    pub(super) fn remember(&mut self, selection: Selection, plan: Arc<raxel_graph::plan::Plan>) {
        self.plans.retain(|(known, _)| *known != selection);
        if self.plans.len() == KEPT_PLANS {
            self.plans.remove(0);
        }
        self.plans.push((selection.clone(), plan));
        self.selection = selection;
    }

    pub(super) fn plan_error(&self, error: BuildError) -> FrameError {
        match error {
            BuildError::Diagnosed(diagnostics) => {
                FrameError::Plan { diagnostics, texts: Box::new(self.state.diagnostics().1) }
            }
            BuildError::Device(error) => FrameError::Device(error),
        }
    }

    /// The picture of the last frame: what is shown, through its display map.
    pub fn read_presented(&mut self) -> Result<Picture, ReadError> {
        Ok(self.executor.read_presented()?)
    }

    /// Texels of mip 0, layer 0 of a target, as the last frame left them. What is not shown must be pinned.
    pub fn read_target(&mut self, name: &str) -> Result<Texels, ReadError> {
        self.read_texels(name, 0, 0, 0)
    }

    /// Texels of a target: of so many frames ago, of a mip, of a layer or slice.
    pub fn read_texels(&mut self, name: &str, age: u32, mip: u32, layer: u32) -> Result<Texels, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.executor.read_target(resource, age, mip, layer)?)
    }

    /// Bytes of a buffer, as the last frame left them.
    pub fn read_buffer(&mut self, name: &str, bytes: Range<u64>) -> Result<Vec<u8>, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.executor.read_buffer(resource, 0, bytes)?)
    }

    fn resource(&self, name: &str) -> Result<ResourceId, SetError> {
        let names = self.graph.resources.iter().map(|resource| resource.name.as_str());
        self.graph.find_resource(name).ok_or_else(|| SetError::unknown("resource", name, names))
    }
}
