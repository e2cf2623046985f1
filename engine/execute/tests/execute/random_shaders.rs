//! The shaders of random graphs: one for each set of up to two things that are loaded and one or two that are stored.

/// A way to bind a resource. Each is one letter of the shader's file name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Sampled,
    ReadImage,
    ReadBuffer,
    WriteImage,
    ReadWriteImage,
    WriteBuffer,
    WriteArguments,
}

use Kind::*;

pub(crate) const READS: [Kind; 3] = [Sampled, ReadImage, ReadBuffer];
pub(crate) const WRITES: [Kind; 4] = [WriteImage, ReadWriteImage, WriteBuffer, WriteArguments];

impl Kind {
    /// The bindings of the shader of that path, in order.
    pub(crate) fn of_shader(path: &str) -> Vec<Kind> {
        let letters = path.trim_start_matches("shaders/").trim_end_matches(".comp");
        let all = || READS.into_iter().chain(WRITES);
        letters.chars().filter_map(|letter| all().find(|kind| kind.letter() == letter)).collect()
    }

    fn letter(self) -> char {
        match self {
            Sampled => 's',
            ReadImage => 'r',
            ReadBuffer => 'b',
            WriteImage => 'w',
            ReadWriteImage => 'x',
            WriteBuffer => 'o',
            WriteArguments => 'a',
        }
    }

    fn declaration(self, at: usize) -> String {
        match self {
            Sampled => format!("uniform sampler2D b{at};\n"),
            ReadImage => format!("layout(r32f) readonly uniform image2D b{at};\n"),
            ReadBuffer => format!("readonly buffer Block{at} {{ float values[]; }} b{at};\n"),
            WriteImage => format!("layout(r32f) writeonly uniform image2D b{at};\n"),
            ReadWriteImage => format!("layout(r32f) uniform image2D b{at};\n"),
            WriteBuffer => format!("writeonly buffer Block{at} {{ float values[]; }} b{at};\n"),
            WriteArguments => format!("writeonly buffer Block{at} {{ uint groups[]; }} b{at};\n"),
        }
    }

    /// Adds the bound resource to `value`, or stores `value` in all of it.
    fn use_(self, at: usize) -> String {
        let over_texels = |store: &str| {
            format!(
                "    for (uint i = t; i < uint(imageSize(b{at}).x * imageSize(b{at}).y); i += 64u) {{
        ivec2 p = ivec2(i % uint(imageSize(b{at}).x), i / uint(imageSize(b{at}).x));
        {store}
    }}\n"
            )
        };
        match self {
            Sampled => format!("    value += texelFetch(b{at}, ivec2(t % 4u, t / 4u % 4u), 0).r * 0.5;\n"),
            ReadImage => format!("    value += imageLoad(b{at}, ivec2(t % 4u, t / 4u % 4u)).r * 0.25;\n"),
            ReadBuffer => format!("    value += b{at}.values[t % uint(b{at}.values.length())] * 0.5;\n"),
            WriteImage => over_texels(&format!("imageStore(b{at}, p, vec4(fract(value + float(i) * 0.125)));")),
            ReadWriteImage => over_texels(&format!(
                "imageStore(b{at}, p, vec4(fract(value + imageLoad(b{at}, p).r * 0.5 + float(i) * 0.125)));"
            )),
            WriteBuffer => {
                format!("    for (uint i = t; i < b{at}.values.length(); i += 64u) b{at}.values[i] = fract(value);\n")
            }
            WriteArguments => format!("    if (t < 3u) b{at}.groups[t] = 1u;\n"),
        }
    }
}

pub(crate) fn shader_name(kinds: &[Kind]) -> String {
    format!("{}.comp", kinds.iter().map(|kind| kind.letter()).collect::<String>())
}

/// One workgroup that loads from everything it reads and stores to all of everything it writes.
fn shader(kinds: &[Kind]) -> String {
    let mut text =
        "#version 460\nlayout(local_size_x = 64) in;\nlayout(push_constant) uniform Push { float add; };\n".to_owned();
    for (at, kind) in kinds.iter().enumerate() {
        text += &kind.declaration(at);
    }
    text += "void main() {\n    uint t = gl_LocalInvocationID.x;\n    float value = add;\n";
    for (at, kind) in kinds.iter().enumerate() {
        text += &kind.use_(at);
    }
    text + "}\n"
}

/// Up to two reads, then one or two writes, both in order.
pub(crate) fn shaders() -> Vec<(String, String)> {
    let up_to_two = |of: &[Kind], least: usize| {
        let mut sets: Vec<Vec<Kind>> = if least == 0 { vec![Vec::new()] } else { Vec::new() };
        for (i, a) in of.iter().enumerate() {
            sets.push(vec![*a]);
            sets.extend(of[i..].iter().map(|b| vec![*a, *b]));
        }
        sets
    };
    let mut all = Vec::new();
    for reads in up_to_two(&READS, 0) {
        for writes in up_to_two(&WRITES, 1) {
            let kinds = [reads.clone(), writes].concat();
            all.push((format!("shaders/{}", shader_name(&kinds)), shader(&kinds)));
        }
    }
    all
}
