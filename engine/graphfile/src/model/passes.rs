//! The declarations of passes.

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
pub(crate) struct Pass {
    /// Name of the pass.
    #[keys(name)]
    pub name: Spanned<String>,
    /// Removes it from the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported. A key that seems to be missing may be misspelt.
    #[keys(flawed)]
    pub(crate) flawed: bool,
    /// Places the pass before this pass of the extended graph. When left out, a new pass goes to the end, and an old one stays.
    #[keys(excludes("after", why = "a pass has one place"))]
    pub before: Option<Spanned<String>>,
    /// Places the pass after this pass of the extended graph. When left out, a new pass goes to the end, and an old one stays.
    pub after: Option<Spanned<String>>,
    /// The shader, relative to shaders/. Needed.
    pub shader: Option<Spanned<String>>,
    /// The entry point.
    #[keys(told = "main".to_owned())]
    pub entry: Option<Spanned<String>>,
    /// Preprocessor definitions.
    #[keys(read = defines, shape = definitions())]
    pub defines: Vec<(Spanned<String>, String)>,
    /// Specialization constants by name: numbers, or values that are fixed while a plan runs, such as `buffer.NAME.count`.
    #[keys(read = specialization, shape = constants())]
    pub specialization: Vec<(Spanned<String>, Constant)>,
    /// Number of invocations in a subgroup, if the device has subgroups of this size. The device's own size when left out.
    #[keys(rename = "subgroup", read = subgroup_size, shape = subgroup_sizes())]
    pub subgroup_size: Option<Spanned<u32>>,
    /// How many workgroups: `[x, y, z]`, or enough for some threads. Needed.
    #[keys(about = "How many workgroups: [x, y, z], or enough for some threads. Needed.")]
    pub dispatch: Option<Spanned<Dispatch>>,
    /// Resources by GLSL name. `NAME@1` is the last frame of NAME.
    #[keys(read = binds, shape = Shape::by_name(reference("bind")))]
    pub bind: Vec<Bind>,
    /// Values for every member of the push-constant block.
    #[keys(cover, read = push, shape = Shape::by_name(reference("member")))]
    pub push: Option<Fills<Member>>,
    /// Values for uniform blocks, by GLSL name.
    #[keys(read = uniforms, shape = Shape::by_name(reference("fills")))]
    pub uniforms: Vec<Fills<Member>>,
    /// The loop that repeats the pass. It runs once when left out.
    #[keys(rename = "loop")]
    pub in_loop: Option<Spanned<String>>,
    /// The pass runs only while this holds; `!` negates. Always when left out.
    #[keys(shape = conditions())]
    pub when: Option<Spanned<String>>,
    /// Conditions of buffers that it binds, or leaves out where they do not hold.
    #[keys(skip)]
    pub(crate) also_when: Vec<Condition>,
    /// How often the pass runs. In every frame when left out.
    pub every: Option<Spanned<Every>>,
}

/// `every`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Every {
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
pub(crate) enum Dispatch {
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
pub(crate) enum Constant {
    /// Written in the file.
    Value(Literal),
    /// The word of `from`, or the whole value when it is a string.
    From(Spanned<String>),
}

/// A resource with its view.
#[derive(Clone, Debug, Keys)]
#[keys(layer("binding", unknown = codes::graph::NOTHING_TO_OVERLAY, whole), check = needs_target(remove, target))]
pub(crate) struct Bind {
    /// The key: the GLSL name.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Removes it from the pass of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// The resource, e.g. `color` or `color@1`. Needed.
    ///
    /// With its age, e.g. `color@1`. `None` with `remove`.
    pub target: Option<Spanned<String>>,
    /// The mip, from 0. When left out, a storage image is mip 0, and a sampled image has all mips.
    pub mip: Option<Spanned<Mip>>,
    /// One layer, from 0, as a 2-D image. All layers when left out.
    #[keys(range = 0..=65_535)]
    pub layer: Option<Spanned<u32>>,
    /// Filter of a sampled image.
    #[keys(told = Filter::Nearest)]
    pub filter: Option<Spanned<Filter>>,
    /// The texels beyond the edge of a sampled image.
    #[keys(told = Wrap::Clamp)]
    pub wrap: Option<Spanned<Wrap>>,
    /// The shader stores only some of the texels (or bytes) that are read later, and leaves the others. Without it, a `writeonly` binding
    /// stores all of them.
    #[keys(told = false)]
    pub partial: Option<Spanned<bool>>,
}

/// A mip as the file names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mip {
    /// A number.
    Level(u32),
    /// Another one in each round of a loop: `"loop.index"`, `"loop.next"`.
    Round(RoundIndex),
}

/// `filter` of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub(crate) enum Filter {
    /// The closest texel.
    Nearest,
    /// A mix of the texels around.
    Linear,
}

/// `wrap` of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub(crate) enum Wrap {
    /// The texel at the edge.
    Clamp,
    /// The image again.
    Repeat,
}

/// `every` as a table, which has one of these keys.
#[derive(Keys)]
pub(crate) struct Rhythm {
    /// Times a second, at most once a frame. Needed in this form.
    #[keys(read = rate, range = RATES, excludes("frames", "still", why = "a pass has one rhythm"))]
    pub hz: Option<f64>,
    /// The pass runs in frames whose index is a multiple of this. Needed in this form.
    #[keys(range = 1..=u32::MAX, excludes("still", why = "a pass has one rhythm"))]
    pub frames: Option<u32>,
    /// The pass runs while `frame.still`, a number of frames, is less than this. Needed in this form.
    #[keys(range = 1..=MOST_STILL)]
    pub still: Option<u32>,
}
