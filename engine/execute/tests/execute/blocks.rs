//! Shared blocks on the device, and the memo's view of them.

use raxel_execute::Builtins;
use raxel_graph::checked::Value;

use crate::lab::{Lab, Planned, at};

/// A file that every shader includes: no shader reads all of it.
const FRAME: (&str, &str) = (
    "shaders/include/frame.glsl",
    "layout(push_constant) uniform Frame { uint index; float light; vec3 color; mat4 view; } frame;",
);

fn shader(body: &str) -> String {
    format!(
        r"#version 460
#include <frame.glsl>
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) writeonly uniform image2D result;
layout(rgba32f) readonly uniform image2D before;
void main() {{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(result)))) return;
    {body}
}}"
    )
}

const GRAPH: &str = include_str!("../fixtures/blocks/shared.toml");

/// A pass runs again when something changes that its shader reads, not when another member of the block does.
#[test]
fn the_memo_looks_at_the_members_that_are_read() {
    let base = shader("imageStore(result, p, imageLoad(before, p) + vec4(frame.color * frame.light, 1.0));");
    let add = shader("imageStore(result, p, imageLoad(before, p) + vec4(float(frame.index)));");
    let mut lab = Lab::new();
    let files = [("graphs/test.toml", GRAPH), FRAME, ("shaders/base.comp", &base), ("shaders/add.comp", &add)];
    lab.load(&files, &Planned { alias: false, ..Planned::default() });
    let params = |light| [Value::F32(light)];

    let report = lab.frame_with(&at(0), &params(0.5));
    assert_eq!((report.dispatched, report.skipped), (2, 0));
    assert_eq!(lab.floats("color", 0, 0, 0)[0], [0.5, 1.0, 1.5, 1.0]);
    // The index is read by the second pass alone.
    let report = lab.frame_with(&at(4), &params(0.5));
    assert_eq!((report.dispatched, report.skipped), (1, 1));
    assert_eq!(lab.floats("color", 0, 0, 0)[0], [4.5, 5.0, 5.5, 5.0]);
    // The camera is read by none.
    let turned = Builtins { camera_view_to_world: [[2.0; 4]; 4], ..at(4) };
    let report = lab.frame_with(&turned, &params(0.5));
    assert_eq!((report.dispatched, report.displayed), (0, false), "a still frame dispatches nothing");
    // The light is read by the first, whose result the second reads.
    let report = lab.frame_with(&turned, &params(1.0));
    assert_eq!((report.dispatched, report.skipped), (2, 0));
    assert_eq!(lab.floats("color", 0, 0, 0)[0], [5.0, 6.0, 7.0, 5.0]);
}
