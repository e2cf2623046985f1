//! Display maps: what a debug target looks like.

use crate::lab::{Lab, Planned};

/// One target of a format, filled with one expression of `p`, shown.
fn picture(format: &str, display: &str, store: &str) -> Vec<[u8; 4]> {
    let image = match format {
        f if f.ends_with("ui") => "uimage2D",
        f if f.ends_with('i') => "iimage2D",
        _ => "image2D",
    };
    let mut lab = Lab::new();
    let toml = format!(
        r#"name = "shown"
present = "color"
[targets.color]
format = "{format}"
{display}
[[passes]]
name = "fill"
shader = "fill.comp"
dispatch = {{ threads = "color" }}
bind = {{ outColor = "color" }}
"#
    );
    let shader = format!(
        "#version 460
layout(local_size_x = 8, local_size_y = 4) in;
layout({format}) writeonly uniform {image} outColor;
void main() {{ ivec2 p = ivec2(gl_GlobalInvocationID.xy); imageStore(outColor, p, {store}); }}"
    );
    lab.load(&[("graphs/test.toml", &toml), ("shaders/fill.comp", &shader)], &Planned::default());
    lab.frame();
    let picture = lab.executor.read_presented().expect("a frame ran");
    picture.rgba.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2], pixel[3]]).collect()
}

#[test]
fn scalars_in_grey_and_in_colour() {
    let grey = picture("r32f", "display = { map = \"gray\", range = [0.0, 7.0] }", "vec4(p.x)");
    assert_eq!(grey.iter().take(8).map(|pixel| pixel[0]).collect::<Vec<_>>(), [0, 36, 73, 109, 146, 182, 219, 255]);
    assert_eq!(picture("r32f", "", "vec4(p.x)")[1], [255, 255, 255, 255]);
    let viridis = picture("r32f", "display = { map = \"viridis\", range = [0.0, 7.0] }", "vec4(p.x)");
    // matplotlib: #440154 and #fde725, within the fit's error.
    for (pixel, end) in [(viridis[0], [0x44, 0x01, 0x54]), (viridis[7], [0xfd, 0xe7, 0x25])] {
        assert!((0..3).all(|c| pixel[c].abs_diff(end[c]) <= 6), "{pixel:?} is not {end:?}");
    }
    let turbo = picture("r32f", "display = { map = \"turbo\", range = [0.0, 7.0] }", "vec4(p.x)");
    assert!(turbo[1][2] > turbo[1][0] && turbo[6][0] > turbo[6][2], "blue is near, red is far: {turbo:?}");
}

#[test]
fn vectors_ids_and_bytes() {
    let normal = picture("rgba16f", "display = \"normal\"", "vec4(-1.0, 0.0, 1.0, 0.0)");
    // 127.5 is a tie, which devices round either way.
    assert!(matches!(normal[0], [0, 127 | 128, 255, 255]), "{:?}", normal[0]);
    let raw = picture("rgba8", "", "vec4(p.x * 17, 255, 3, 255) / 255.0");
    assert_eq!(raw[5], [85, 255, 3, 255]);
    let ids = picture("r32ui", "", "uvec4(p.x)");
    assert_eq!(ids[0], [0, 0, 0, 255]);
    assert_ne!(ids[1], ids[2]);
    assert_eq!(ids[1], ids[9]);
    let integer = picture("r32i", "display = { map = \"integer\", range = [-4.0, 3.0] }", "ivec4(p.x - 4)");
    assert_eq!(integer.iter().take(8).map(|pixel| pixel[1]).collect::<Vec<_>>(), [0, 36, 73, 109, 146, 182, 219, 255]);
}

#[test]
fn what_is_no_number_stands_out() {
    let broken = picture("r32f", "", "vec4(uintBitsToFloat(p.x < 4 ? 0x7fc00000u : 0xff800000u))");
    assert_eq!(broken[0], [255, 0, 255, 255]);
    assert_eq!(broken[4][2], 0, "infinity is yellow");
    assert!(broken[4][0] > broken[4][2] && broken[4][1] > broken[4][2]);
}

#[test]
fn a_target_of_another_size_fills_the_picture() {
    let small = picture("rgba8", "size = [2, 1]", "vec4(p.x, 0, 0, 1)");
    assert_eq!(small.iter().take(8).map(|pixel| pixel[0]).collect::<Vec<_>>(), [0, 0, 0, 0, 255, 255, 255, 255]);
}

#[test]
fn buffers_volumes_layers_and_history() {
    let toml = include_str!("../fixtures/shown/many.toml");
    let shader = include_str!("../fixtures/shown/many.comp");
    let shown = |present: &str| {
        let mut lab = Lab::new();
        let output = if present.starts_with("trail") { [8, 4] } else { [2, 2] };
        let files = [("graphs/test.toml", toml), ("shaders/fill.comp", shader)];
        lab.load(&files, &Planned { output, present, ..Planned::default() });
        for frame in 0..6 {
            lab.frame_with(&crate::lab::at(frame), &[]);
        }
        let picture = lab.executor.read_presented().expect("frames ran");
        picture.rgba.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect::<Vec<_>>()
    };
    assert_eq!(shown("stack:0"), [[0; 3]; 4]);
    assert_eq!(shown("stack:2"), [[0; 3], [255; 3], [0; 3], [255; 3]]);
    assert_eq!(shown("volume:1"), [[51; 3]; 4]);
    assert_eq!(shown("trail")[0], [85; 3]);
    assert_eq!(shown("trail@2")[31], [51; 3], "three fifteenths, two frames ago");
    // Three floats a pixel are a colour; bare words are ids in a square.
    assert_eq!(shown("pixels"), [[255, 0, 0], [0, 255, 0], [255, 0, 0], [0, 255, 0]]);
    let words = shown("words");
    assert_eq!((words[0], words[1]), ([0; 3], words[3]));
    assert_ne!(words[1], [0; 3]);
}
