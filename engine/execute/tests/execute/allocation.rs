//! A running frame allocates nothing: the walk over the plan does not, and recording and submitting it on the device do not either.

use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, FrameInputs, Recorder, Replay};
use raxel_graph::checked::Value;

use crate::frames::chain;
use crate::lab::{Lab, Planned};

#[derive(Default)]
struct Calls(u32);

impl Recorder for Calls {
    fn uniforms(&mut self, _: &[u8]) {
        self.0 += 1;
    }
    fn barrier(&mut self, _: usize) {
        self.0 += 1;
    }
    fn clear(&mut self, _: usize, _: usize) {
        self.0 += 1;
    }
    fn copy(&mut self, _: usize) {
        self.0 += 1;
    }
    fn bind(&mut self, _: usize) {
        self.0 += 1;
    }
    fn push(&mut self, _: usize, _: &[u8]) {
        self.0 += 1;
    }
    fn dispatch(&mut self, _: usize) {
        self.0 += 1;
    }
    fn present(&mut self) {
        self.0 += 1;
    }
}

#[test]
fn thirty_passes_allocate_nothing() {
    let mut lab = Lab::new();
    let files = chain(30, &[0, 7]);
    let files: Vec<_> = files.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
    let plan = lab.load(&files, &Planned::default());
    let mut replay = Replay::new(&plan, 0);
    let mut builtins = Builtins::default();
    let params = [Value::F32(2.0)];
    // The first frames may reserve what later ones use.
    for frame in 0..12 {
        builtins.frame_time = if frame < 8 { frame as f32 } else { 8.0 };
        let inputs =
            FrameInputs { builtins: &builtins, params: &params, overrides: &[], clock: Moment::START, disabled: &[] };
        let mut calls = Calls::default();
        let walk = allocation_counter::measure(|| {
            replay.decide(frame, &inputs);
            replay.walk(&mut calls);
        });
        assert_eq!(walk.count_total, 0, "frame {frame}");
        assert_eq!(calls.0 > 90, frame <= 8, "frame {frame}: {} calls", calls.0);
        let run = allocation_counter::measure(|| {
            lab.executor.frame(&inputs).expect("it runs");
        });
        assert!(run.count_total == 0 || frame < 3, "frame {frame}: {run:?}");
    }
}
