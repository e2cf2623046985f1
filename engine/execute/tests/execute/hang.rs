//! The watchdog and the crash markers.

use std::time::Duration;

use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, ExecuteError, ExecutorOptions, FrameInputs, Progress};
use raxel_graph::checked::Value;

use crate::lab::{Lab, Planned};

const TOML: &str = include_str!("../fixtures/hang/hang.toml");

const SPIN: &str = include_str!("../fixtures/hang/spin.comp");

/// Rounds that keep any device busy for far longer than [`SHORT`], but not for ever. (The software driver leaves a loop after 65535 rounds,
/// so most of the work is in the number of groups.)
fn heavy(lab: &Lab) -> i32 {
    if lab.device.capabilities().kind == raxel_gpu::DeviceKind::Cpu { 4_000 } else { 1 << 22 }
}

/// No device does the heavy work in this time.
const SHORT: Duration = Duration::from_micros(100);

/// A loaded machine does the heavy work in this time.
const LONG: Duration = Duration::from_secs(300);

#[test]
fn a_hang_is_noticed_and_blamed_on_its_pass() {
    let mut lab = Lab::with(ExecutorOptions { watchdog: LONG, memo: false, ..ExecutorOptions::default() });
    lab.load(
        &[("graphs/test.toml", TOML), ("shaders/spin.comp", SPIN)],
        &Planned { pinned: &["quick"], ..Planned::default() },
    );
    let builtins = Builtins::default();
    let submit = |lab: &mut Lab, rounds: i32| {
        let params = [Value::I32(rounds)];
        let inputs =
            FrameInputs { builtins: &builtins, params: &params, overrides: &[], clock: Moment::START, disabled: &[] };
        lab.executor.frame(&inputs)
    };
    // One round is no hang. The first frame also makes the driver compile.
    submit(&mut lab, 1).expect("one round is not a hang");
    lab.executor.wait().expect("one round is not a hang");
    let rounds = heavy(&lab);
    submit(&mut lab, rounds).expect("submitting waits for nothing");
    // It works, and says on what: on nothing before the device has begun a pass, and the quick pass need not be done yet.
    loop {
        match lab.executor.wait_picture(Duration::from_millis(1)).expect("the watchdog is patient") {
            Progress::Done => panic!("the heavy work is not heavy"),
            Progress::Working { pass, .. } if pass.as_deref() == Some("spin") => break,
            Progress::Working { pass, .. } => assert!(pass.is_none() || pass.as_deref() == Some("quick"), "{pass:?}"),
        }
    }
    lab.executor.set_watchdog(SHORT);
    let error = lab.executor.wait().expect_err("so long is more than the watchdog allows");
    let ExecuteError::DeviceLost { suspect, timed_out } = &error else { panic!("{error}") };
    assert_eq!((suspect.as_ref().map(|suspect| suspect.pass.as_str()), *timed_out), (Some("spin"), true));
    assert!(error.to_string().ends_with("pass `spin` had begun and not finished"), "{error}");
    // Nothing more can be had from this device, and every question fails.
    assert!(lab.device.is_lost());
    assert!(matches!(lab.executor.read_presented(), Err(ExecuteError::DeviceLost { .. })));
    assert!(matches!(lab.executor.wait_next(SHORT), Err(ExecuteError::DeviceLost { .. })));
    assert!(submit(&mut lab, 1).is_err());
    // The driver's threads must be done before the process ends.
    assert!(lab.device.wait_abandoned(LONG));
}

/// Passes of the frame below.
const PASSES: usize = 48;

/// A frame of many passes that each need the one before.
fn chain() -> String {
    let mut toml = String::from(
        r#"name = "chain"
present = "color"
[params.rounds]
type = "i32"
default = 1
[targets.color]
format = "r32ui"
clear = 0
"#,
    );
    for i in 0..PASSES {
        toml += &format!(
            r#"[[passes]]
name = "p{i}"
shader = "add.comp"
dispatch = [5000, 4, 1]
bind = {{ dst = "color" }}
push.rounds = {{ type = "i32", from = "param.rounds" }}
"#
        );
    }
    toml
}

const ADD: &str = include_str!("../fixtures/hang/add.comp");

/// A slow frame is not taken for a hang while its passes go on finishing, however long all of them together take.
#[test]
fn a_device_that_goes_on_finishing_passes_does_not_hang() {
    let mut lab = Lab::with(ExecutorOptions { watchdog: LONG, memo: false, ..ExecutorOptions::default() });
    lab.load(&[("graphs/test.toml", &chain()), ("shaders/add.comp", ADD)], &Planned::default());
    let rounds = if lab.device.capabilities().kind == raxel_gpu::DeviceKind::Cpu { 60 } else { 1 << 18 };
    let builtins = Builtins::default();
    let frame = |lab: &mut Lab| {
        let params = [Value::I32(rounds)];
        let inputs =
            FrameInputs { builtins: &builtins, params: &params, overrides: &[], clock: Moment::START, disabled: &[] };
        let start = std::time::Instant::now();
        lab.executor.frame(&inputs).expect("submitting waits for nothing");
        lab.executor.wait().map(|()| start.elapsed())
    };
    // The first frame also makes the driver compile.
    frame(&mut lab).expect("the watchdog is patient");
    let whole = frame(&mut lab).expect("the watchdog is patient");
    // As long as sixteen passes.
    lab.executor.set_watchdog(whole / 3);
    frame(&mut lab).expect("its passes go on finishing");
}
