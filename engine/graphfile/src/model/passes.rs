//! What passes say.

use raxel_diagnostics::{Spanned, codes};
use raxel_graph::checked::{Condition, MOST_STILL, RoundIndex};
use raxel_language::{Keys, Shape};

use super::{Fills, Literal, Member};
use crate::extends::reject_removals;
use crate::parse::{RATES, binds, defines, needs_target, push, rate, specialization, subgroup_size, uniforms};
use crate::schema::{conditions, constants, definitions, reference, subgroup_sizes};

/// One compute dispatch of one shader.
#[derive(Clone, Debug, Keys)]
#[keys(layer("pass", unknown = codes::graph::UNKNOWN_PASS), added = reject_removals)]
pub struct Pass {
    /// Its name.
    #[keys(name)]
    pub name: Spanned<String>,
    /// Takes it out of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    #[keys(flawed)]
    pub flawed: bool,
    /// Over a graph that `extends` names: puts the pass before this one. A new pass goes to the end when left out, one of that graph
    /// stays.
    #[keys(excludes("after", why = "a pass has one place"))]
    pub before: Option<Spanned<String>>,
    /// Over a graph that `extends` names: puts the pass after this one. A new pass goes to the end when left out, one of that graph
    /// stays.
    pub after: Option<Spanned<String>>,
    /// The shader, relative to shaders/: needed.
    pub shader: Option<Spanned<String>>,
    /// The entry point.
    #[keys(told = "main".to_owned())]
    pub entry: Option<Spanned<String>>,
    /// Preprocessor definitions.
    #[keys(read = defines, shape = definitions())]
    pub defines: Vec<(Spanned<String>, String)>,
    /// Specialization constants by name: written values, or what is fixed while a plan runs, such as `buffer.NAME.count`.
    #[keys(read = specialization, shape = constants())]
    pub specialization: Vec<(Spanned<String>, Constant)>,
    /// Invocations in a subgroup that the device is asked for, if it has subgroups of that size. Those that it makes by itself when left
    /// out.
    #[keys(rename = "subgroup", read = subgroup_size, shape = subgroup_sizes())]
    pub subgroup_size: Option<Spanned<u32>>,
    /// How many workgroups: `[x, y, z]`, or as many as cover some threads. Needed.
    #[keys(about = "How many workgroups: [x, y, z], or as many as cover some threads. Needed.")]
    pub dispatch: Option<Spanned<Dispatch>>,
    /// GLSL name = resource. `NAME@1` is the last frame of NAME.
    #[keys(read = binds, shape = Shape::by_name(reference("bind")))]
    pub bind: Vec<Bind>,
    /// The push constants: every member of the shader's block.
    #[keys(cover, read = push, shape = Shape::by_name(reference("member")))]
    pub push: Option<Fills<Member>>,
    /// Uniform blocks that raxel fills, by GLSL name.
    #[keys(read = uniforms, shape = Shape::by_name(reference("fills")))]
    pub uniforms: Vec<Fills<Member>>,
    /// The loop that repeats it; it runs once when left out.
    #[keys(rename = "loop")]
    pub in_loop: Option<Spanned<String>>,
    /// Runs only while this holds; `!` negates. Always when left out.
    #[keys(shape = conditions())]
    pub when: Option<Spanned<String>>,
    /// Conditions of buffers that it binds, or leaves out where they do not hold.
    #[keys(skip)]
    pub also_when: Vec<Condition>,
    /// Runs at a rhythm of its own; in every frame when left out.
    pub every: Option<Spanned<Every>>,
}

/// `every`.
#[derive(Clone, Debug, PartialEq)]
pub enum Every {
    /// `{ hz = 20 }`.
    Hz(f64),
    /// `{ frames = 3 }`.
    Frames(u32),
    /// `{ still = 64 }`.
    Still(u32),
    /// `"sim"`, the name of a clock.
    Clock(String),
}

/// `dispatch`.
#[derive(Clone, Debug, PartialEq)]
pub enum Dispatch {
    /// `{ threads = "hit", mip = 1 }`, `{ threads = "rays" }`, `{ threads = "world" }`.
    ThreadsOf {
        /// The target or buffer, or the world.
        target: Spanned<String>,
        /// Mip 0 when the file gives none.
        mip: Spanned<Mip>,
    },
    /// `{ groups = "hit", tile = [16, 16], mip = 1 }`.
    GroupsOf {
        /// The target.
        target: Spanned<String>,
        /// Texels of a workgroup; one when the file gives none.
        tile: [u32; 3],
        /// Mip 0 when the file gives none.
        mip: Spanned<Mip>,
    },
    /// `{ threads = [x, y, z] }`.
    Threads([u32; 3]),
    /// `[x, y, z]`, `{ groups = [x, y, z] }`.
    Groups([u32; 3]),
    /// `{ indirect = "args", offset = 0 }`.
    Indirect {
        /// The buffer.
        buffer: Spanned<String>,
        /// Bytes.
        offset: Spanned<u64>,
    },
    /// `{ count = "queue", offset = 0 }`.
    Queue {
        /// The buffer.
        buffer: Spanned<String>,
        /// Bytes.
        offset: Spanned<u64>,
    },
}

/// The value of a specialization constant.
#[derive(Clone, Debug, PartialEq)]
pub enum Constant {
    /// Written in the file.
    Value(Literal),
    /// The word of `from`, or the whole value when it is a string.
    From(Spanned<String>),
}

/// A resource with its view.
#[derive(Clone, Debug, Keys)]
#[keys(layer("binding", unknown = codes::graph::NOTHING_TO_OVERLAY, whole), check = needs_target(remove, target))]
pub struct Bind {
    /// The key: the GLSL name.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Takes it out of the pass of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// The resource: needed.
    ///
    /// With its age, e.g. `color@1`. `None` with `remove`.
    pub target: Option<Spanned<String>>,
    /// The mip, from 0. A storage image is one (0 when left out), a sampled image all of them.
    pub mip: Option<Spanned<Mip>>,
    /// One layer of many, from 0, as a plain 2-D image; all of them when left out.
    #[keys(range = 0..=65_535)]
    pub layer: Option<Spanned<u32>>,
    /// Filter of a sampled image.
    #[keys(told = Filter::Nearest)]
    pub filter: Option<Spanned<Filter>>,
    /// What lies beyond the edge of a sampled image.
    #[keys(told = Wrap::Clamp)]
    pub wrap: Option<Spanned<Wrap>>,
    /// The shader stores only some of the texels (or bytes) that are read later: what was there before shows through. Without it, a
    /// `writeonly` binding is taken to store all of them.
    #[keys(told = false)]
    pub partial: Option<Spanned<bool>>,
}

/// A mip as the file names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mip {
    /// A number.
    Level(u32),
    /// Another one in each round of a loop: `"loop.index"`, `"loop.next"`.
    Round(RoundIndex),
}

/// `filter` of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum Filter {
    /// The closest texel.
    Nearest,
    /// A mix of the texels around.
    Linear,
}

/// `wrap` of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum Wrap {
    /// The texel at the edge.
    Clamp,
    /// The image again.
    Repeat,
}

/// `every` as a table, which has one of these keys.
#[derive(Keys)]
pub struct Rhythm {
    /// Times a second: needed in this form.
    #[keys(read = rate, range = RATES, excludes("frames", "still", why = "a pass has one rhythm"))]
    pub hz: Option<f64>,
    /// Runs in frames whose index this divides: needed in this form.
    #[keys(range = 1..=u32::MAX, excludes("still", why = "a pass has one rhythm"))]
    pub frames: Option<u32>,
    /// Runs while `frame.still`, a number of frames, is less than this: needed in this form.
    #[keys(range = 1..=MOST_STILL)]
    pub still: Option<u32>,
}
