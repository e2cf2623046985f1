//! The watchdog and the crash markers.

use std::time::{Duration, Instant};

use raxel_graph::checked::Value;
use raxel_runtime::execute::{Builtins, ExecuteError, ExecutorOptions, FrameInputs};

use crate::lab::{Lab, Planned};

const TOML: &str = r#"
name = "hang"
present = "color"
[params.rounds]
type = "i32"
default = 1
[targets.color]
format = "r32ui"
[targets.quick]
format = "r32ui"
[[passes]]
name = "quick"
shader = "spin.comp"
dispatch = { threads = "quick" }
bind = { dst = "quick" }
push.rounds = { type = "i32", value = 1 }
[[passes]]
name = "spin"
shader = "spin.comp"
dispatch = [50000, 4, 1]
bind = { dst = "color" }
push.rounds = { type = "i32", from = "param.rounds" }
"#;

const SPIN: &str = "#version 460
layout(local_size_x = 8, local_size_y = 4) in;
layout(r32ui) writeonly uniform uimage2D dst;
layout(push_constant) uniform Push { int rounds; } push;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    uint x = uint(p.x + 1);
    for (int i = 0; i < push.rounds; ++i) x = x * 1664525u + 1013904223u + (x >> 7);
    if (all(lessThan(p, imageSize(dst))) || x == 0u) imageStore(dst, p % imageSize(dst), uvec4(x));
}";

#[test]
fn a_hang_is_noticed_and_blamed_on_its_pass() {
    let mut lab = Lab::with(ExecutorOptions {
        watchdog: Some(Duration::from_millis(500)),
        memo: false,
        ..ExecutorOptions::default()
    });
    lab.load(
        &[("graphs/test.toml", TOML), ("shaders/spin.comp", SPIN)],
        &Planned { pinned: &["quick"], ..Planned::default() },
    );
    let builtins = Builtins::default();
    let frame = |lab: &mut Lab, rounds: i32| {
        let params = [Value::I32(rounds)];
        let inputs = FrameInputs { builtins: &builtins, params: &params, overrides: &[], clock: 0.0, disabled: &[] };
        let start = Instant::now();
        let result = lab.executor.frame(&inputs, None).and_then(|_| lab.executor.wait());
        (result, start.elapsed())
    };
    // How many rounds take about a second and a half here. The first frame also makes the driver compile.
    frame(&mut lab, 1).0.expect("one round is no hang");
    // (The software driver leaves a loop after 65535 rounds, so most of the work is in the number of groups.)
    let software = lab.device.capabilities().kind == raxel_gpu::DeviceKind::Cpu;
    let most = if software { 65_000 } else { 1 << 30 };
    let mut rounds = 1;
    loop {
        let (result, time) = frame(&mut lab, rounds);
        result.expect("so few rounds are no hang");
        if time > Duration::from_millis(100) || rounds > most / 2 {
            rounds = (1.5 * f64::from(rounds) / time.as_secs_f64()).min(f64::from(most)) as i32;
            break;
        }
        rounds *= 2;
    }
    let error = frame(&mut lab, rounds).0.expect_err("so long is more than the watchdog allows");
    let ExecuteError::DeviceLost { suspect, timed_out } = &error else { panic!("{error}") };
    assert_eq!((suspect.as_deref(), *timed_out), (Some("spin"), true));
    assert!(error.to_string().contains("`spin`"), "{error}");
    // Nothing more can be had from this device, and every question says so.
    assert!(lab.device.is_lost());
    assert!(matches!(lab.executor.read_presented(), Err(ExecuteError::DeviceLost { .. })));
    assert!(frame(&mut lab, 1).0.is_err());
    // The driver's threads must be done before the process ends.
    std::thread::sleep(Duration::from_secs(3));
}
