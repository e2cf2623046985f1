//! Recording takes: see [`crate::take`].

use std::sync::Arc;

use raxel_graph::checked::Graph;

use super::Session;
use crate::clock::FrameTime;
use crate::take::{Ended, Recorder, Scene, Take, TakeError, Told};

/// A take as far as it has come. Frames that follow change nothing of a copy.
#[derive(Clone, Debug)]
pub struct TakeSoFar {
    pub(super) recorder: Recorder,
    /// That of its last frame: another graph may run since.
    graph: Arc<Graph>,
    identity: TakeIdentity,
}

/// Tells one take of a session from the others. Whoever writes a take holds its identity until the recording goes on or has ended.
#[derive(Clone, Debug, Default)]
pub struct TakeIdentity(Arc<()>);

impl TakeSoFar {
    /// The take as the demo `NAME.demo.toml`. The text of a long take needs more time than a frame has, so another thread may make it.
    pub fn finish(&self, name: &str) -> Result<Take, TakeError> {
        self.recorder.finish(&self.graph, name)
    }

    /// Its identity, for [`Session::stop_recording_of`].
    pub fn identity(&self) -> TakeIdentity {
        self.identity.clone()
    }
}

impl Session {
    /// Starts over ([`Session::reset`]), and records the inputs of each frame from then on.
    pub fn record(&mut self) -> Result<(), TakeError> {
        if self.playback.take.is_some() {
            return Err(TakeError::Recording);
        }
        let world = self.world.shown.path.clone().ok_or(TakeError::NoWorld)?;
        let scene =
            Scene { world, graph: self.graph_path().to_owned(), size: self.size(), pace: self.playback.clock.pace() };
        self.reset();
        self.playback.take = Some(TakeSoFar {
            recorder: Recorder::new(scene),
            graph: self.renderer.graph.clone(),
            identity: TakeIdentity::default(),
        });
        Ok(())
    }

    /// The length in seconds of the take that is being recorded, and why nothing more is noted, if it has ended.
    pub fn recording(&self) -> Option<(f64, Option<Ended>)> {
        self.playback.take.as_ref().map(|take| (take.recorder.seconds(), take.recorder.ended()))
    }

    /// The take so far, as the demo `NAME.demo.toml`. The sound that its graph heard is `NAME.wav` beside it.
    pub fn take(&self, name: &str) -> Result<Take, TakeError> {
        self.playback.take.as_ref().ok_or(TakeError::NotRecording)?.finish(name)
    }

    /// The take so far, to be written while frames go on. The recording goes on until [`Self::stop_recording`].
    pub fn take_so_far(&self) -> Result<TakeSoFar, TakeError> {
        self.playback.take.clone().ok_or(TakeError::NotRecording)
    }

    /// Whether the take is being written: a copy of it or its identity is held.
    pub fn is_take_written(&self) -> bool {
        self.playback.take.as_ref().is_some_and(|take| Arc::strong_count(&take.identity.0) > 1)
    }

    /// Ends the recording of this take, if no other one is being recorded.
    pub fn stop_recording_of(&mut self, identity: &TakeIdentity) {
        self.playback.take.take_if(|take| Arc::ptr_eq(&take.identity.0, &identity.0));
    }

    /// Ends the recording of a take.
    pub fn stop_recording(&mut self) {
        self.playback.take = None;
    }

    /// Records the inputs of the frame at this time.
    pub(super) fn note_take(&mut self, time: &FrameTime) {
        let (size, hears) = (self.size(), self.hears_microphone());
        let Some(take) = &mut self.playback.take else { return };
        take.recorder.note(&Told {
            time,
            graph_path: &self.files.state.graph_path,
            graph: &self.renderer.graph,
            size,
            values: &self.playback.params.shown,
            camera: &self.playback.view.camera,
            inputs: &self.playback.inputs.shown,
            heard: hears.then(|| self.playback.microphone.heard()),
            target: &self.renderer.shown.debug_target,
        });
        if take.recorder.ended().is_none() {
            take.graph.clone_from(&self.renderer.graph);
        }
    }
}
