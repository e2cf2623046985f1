//! Sessions over small projects, and the files of these.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::path::Path;

use raxel_runtime::session::Validation;
use raxel_runtime::{Options, Session};
pub(crate) use raxel_testing::Project;

pub(crate) const FILL_GRAPH: &str = include_str!("../fixtures/project/fill.toml");

/// Fills with a GLSL expression.
pub(crate) fn fill(expression: &str) -> String {
    format!(
        r"#version 460
//INCLUDE
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outColor;
void main() {{
    imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), {expression});
}}
"
    )
}

/// Adds a param to last frame's sum.
pub(crate) const COUNT: &str = include_str!("../fixtures/project/count.comp");

pub(crate) const COUNT_GRAPH: &str = include_str!("../fixtures/project/count.toml");

/// Writes `history.valid`, `frame.still` and last frame's sum plus one.
pub(crate) const VALID: &str = include_str!("../fixtures/project/valid.comp");

pub(crate) const VALID_GRAPH: &str = include_str!("../fixtures/project/valid.toml");

/// Number of solid voxels in red, a param in green.
pub(crate) const WORLD_GRAPH: &str = include_str!("../fixtures/project/world.toml");

pub(crate) const WORLD_SHADER: &str = include_str!("../fixtures/project/world.comp");

/// A cube of that edge.
pub(crate) fn box_world(edge: u32) -> String {
    format!(
        r##"name = "box"
[materials]
red = {{ albedo = "#ff0000" }}
[[build]]
op = "box"
min = [0, 0, 0]
max = [{edge}, {edge}, {edge}]
material = "red"
"##
    )
}

/// Holds `gain`.
pub(crate) fn box_demo(gain: f32) -> String {
    format!(
        r#"world = "box.toml"
graph = "world.toml"
duration = 10.0
[tracks.gain]
keys = [[0.0, {gain:?}]]
"#
    )
}

/// Says which validation messages came, if any did.
pub(crate) fn assert_silent(session: &Session) {
    let messages = session.device().log().messages();
    assert!(messages.is_empty(), "{messages:#?}");
}

/// Sessions of a project.
pub(crate) trait Sessions {
    /// A project with the graph `fill`.
    fn filled() -> Self;
    fn options(&self) -> Options;
    fn open_with(options: Options) -> Session {
        Session::open(options).unwrap_or_else(|error| panic!("{error}"))
    }
    fn open(&self) -> Session {
        self.open_graph("graphs/fill.toml")
    }
    fn open_graph(&self, graph: &str) -> Session {
        Self::open_with(Options { graph: Some(Path::new(graph).to_owned()), ..self.options() })
    }
    fn open_demo(&self, demo: &str) -> Session {
        Self::open_with(Options { demo: Some(Path::new(demo).to_owned()), ..self.options() })
    }
}

impl Sessions for Project {
    fn filled() -> Self {
        let project = Self::empty();
        project.write("graphs/fill.toml", FILL_GRAPH);
        project.write("shaders/fill.comp", fill("vec4(0.25)"));
        project
    }

    fn options(&self) -> Options {
        Options {
            project: Some(self.root().to_owned()),
            size: [16, 16],
            validation: Validation::Required,
            watch: true,
            ..Options::default()
        }
    }
}

/// The first texel of the shown target.
pub(crate) fn texel(session: &mut Session) -> [f32; 4] {
    let present = session.graph().present;
    let name = session.graph().resource(present).name.clone();
    session.read_target(&name).unwrap().floats()[0]
}

/// Its red channel.
pub(crate) fn red(session: &mut Session) -> f32 {
    texel(session)[0]
}

/// Its red channel after one more frame.
pub(crate) fn red_after_frame(session: &mut Session) -> f32 {
    session.frame().unwrap();
    red(session)
}

/// Writes a WAV file of one channel, with 48,000 samples a second.
pub(crate) fn write_wav(path: &Path, samples: &[i16]) {
    let bytes = u32::try_from(2 * samples.len()).unwrap();
    let mut file = Vec::new();
    file.extend(b"RIFF");
    file.extend((36 + bytes).to_le_bytes());
    file.extend(b"WAVEfmt ");
    file.extend(16_u32.to_le_bytes());
    // Whole numbers, one channel.
    file.extend(1_u16.to_le_bytes());
    file.extend(1_u16.to_le_bytes());
    file.extend(48_000_u32.to_le_bytes());
    file.extend(96_000_u32.to_le_bytes());
    file.extend(2_u16.to_le_bytes());
    file.extend(16_u16.to_le_bytes());
    file.extend(b"data");
    file.extend(bytes.to_le_bytes());
    file.extend(samples.iter().flat_map(|sample| sample.to_le_bytes()));
    std::fs::write(path, file).unwrap();
}
