//! Losing the device: everything a session is made of lies in main memory, so that another device can be opened and filled.

use std::time::{Duration, Instant};

use raxel_execute::ExecuteError;

use super::renderer::{self, Renderer, open_device};
use super::switched_off::runs;
use super::{FrameError, Options, Session};
use crate::build;
use crate::build_error::BuildError;
use crate::reload::ReloadEvent;
use crate::world::SessionWorld;

/// A device that dies sooner after it was opened counts against the budget.
const SHORT_LIFE: Duration = Duration::from_secs(10);

/// So many short lives in a row, and the session gives up.
const SHORT_LIVES: u32 = 3;

/// Keeps a session from opening devices for ever.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Budget {
    opened: Option<Instant>,
    short_lives: u32,
}

impl Budget {
    /// Notes a loss. False when there were too many.
    fn spend(&mut self, now: Instant) -> bool {
        let short = self.opened.is_some_and(|opened| now.saturating_duration_since(opened) < SHORT_LIFE);
        self.short_lives = if short { self.short_lives + 1 } else { 0 };
        self.short_lives < SHORT_LIVES
    }

    /// Notes that a device was opened after a loss.
    fn opened(&mut self, now: Instant) {
        self.opened = Some(now);
    }
}

impl Session {
    /// Reopens the device and switches off the pass that ran when it was lost. Contents of targets and buffers start at `init`.
    pub(super) fn recover(&mut self, lost: ExecuteError) -> Result<(), FrameError> {
        let began = Instant::now();
        let suspect = match &lost {
            ExecuteError::DeviceLost { suspect, .. } => suspect.clone(),
            _ => return Err(FrameError::Device(lost)),
        };
        if !self.renderer.recovery.spend(began) {
            return Err(FrameError::Device(lost));
        }
        // The frame may be older than the graph: a pass that was mended meanwhile is not the one that was suspected.
        let off = suspect.as_ref().is_some_and(|suspect| runs(&self.renderer.executor, suspect));
        if let Some(suspect) = suspect.clone().filter(|_| off) {
            self.renderer.off.add(suspect);
        }
        self.renderer.find_off();
        self.renderer.rebuild(&self.world.shown, &self.options).map_err(|error| match error {
            BuildError::Device(error) => FrameError::Device(error),
            BuildError::Diagnosed(diagnostics) => self.files.plan_error(diagnostics),
        })?;
        self.world.output.forget();
        self.world.changed.everything();
        self.settings_changed();
        self.renderer.recovery.opened(Instant::now());
        let milliseconds = began.elapsed().as_secs_f64() * 1e3;
        let suspect = suspect.map(|suspect| suspect.pass);
        self.events.push(ReloadEvent::DeviceRebuilt { suspect, off, milliseconds });
        Ok(())
    }

    /// Whether the device works on a pass that has been edited since, or that is no longer in the graph.
    pub fn works_on_replaced(&self) -> bool {
        let executor = &self.renderer.executor;
        executor.suspect().is_some_and(|suspect| !runs(executor, &suspect))
    }

    /// Names of the passes that are switched off since the device was lost while they ran.
    pub fn switched_off(&self) -> impl Iterator<Item = &str> {
        self.renderer.off.names()
    }
}

impl Renderer {
    /// Finds the passes that are switched off in the graph that runs.
    pub(super) fn find_off(&mut self) {
        self.off.find(&self.graph, &self.executor);
    }

    /// Opens the device again. Everything is made before anything is replaced: when a step fails, the session still knows that its device is
    /// lost, and the next frame tries again.
    fn rebuild(&mut self, world: &SessionWorld, options: &Options) -> Result<(), BuildError> {
        let device = open_device(options).map_err(|error| BuildError::Device(error.into()))?;
        let (mut executor, context) = renderer::start(&device, options).map_err(BuildError::Device)?;
        let assembly = build::assemble(&self.graph, world, &self.plans.running, &context)?;
        executor.swap(build::prepare(&assembly, &context)?);
        executor.set_display(self.shown.display);
        executor.set_region(self.shown.region);
        (self.executor, self.context) = (executor, context);
        self.history.reset();
        self.still.reset();
        self.plans.forget();
        self.plans.allow();
        self.plans.remember(self.plans.running.clone(), assembly.plan);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_short_lives_end_it_and_a_long_one_forgives() {
        let start = Instant::now();
        let at = |seconds| start + Duration::from_secs(seconds);
        let mut budget = Budget::default();
        // The first loss may come at any time.
        assert!(budget.spend(at(1)));
        budget.opened(at(1));
        assert!(budget.spend(at(2)));
        budget.opened(at(2));
        assert!(budget.spend(at(3)));
        budget.opened(at(3));
        let mut forgiven = budget;
        assert!(!budget.spend(at(4)));
        assert!(forgiven.spend(at(60)));
        forgiven.opened(at(60));
        assert!(forgiven.spend(at(61)));
    }

    #[test]
    fn a_recovery_that_fails_half_way_is_tried_again() {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in [
            (
                "graphs/fill.toml",
                "name = \"fill\"\npresent = \"color\"\n[targets.color]\nformat = \"r32f\"\n[[passes]]\nname = \"fill\"\n\
                 shader = \"fill.comp\"\ndispatch = { threads = \"color\" }\nbind = { c = \"color\" }\n",
            ),
            (
                "shaders/fill.comp",
                "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(r32f) writeonly uniform image2D c;\n\
                 void main() { imageStore(c, ivec2(gl_GlobalInvocationID.xy), vec4(0.5)); }\n",
            ),
        ] {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let project = Some(folder.path().to_owned());
        let options = crate::Options { project, size: [8, 8], ..crate::Options::default() };
        let mut session = Session::open(options).unwrap_or_else(|error| panic!("{error}"));
        session.frame().unwrap();
        // A pass that has finished is not suspected.
        session.wait().unwrap();
        let (first, possible) = (session.device().id(), session.renderer.plans.running.clone());
        // A pass that has not finished would be the suspect, and switched off.
        session.wait().unwrap();
        session.abandon_device();
        // A new device is opened, and then nothing can be planned for it.
        session.renderer.plans.running.output = [1_000_000; 2];
        assert!(session.frame().is_err());
        assert_eq!(session.device().id(), first, "nothing was replaced");
        session.renderer.plans.running = possible;
        session.frame().expect("the next frame tries again");
        assert_ne!(session.device().id(), first);
        assert_eq!(session.read_target("color").unwrap().floats()[0][0].to_bits(), 0.5_f32.to_bits());
    }
}
