//! The file model: what graph files say, word for word, each value with its place. Nothing is looked up yet, and every key may be
//! missing, because a file that `extends` another says only what differs. [`crate::front::extends`] lays such files over each other.

use std::sync::Arc;

use raxel_diagnostics::{Span, Spanned, codes};
use raxel_language::Keys;

use crate::front::parse::{MOST_TICKS, RATES, at, rate};
use crate::front::schema::{param_types, reference};
use crate::ir::checked::{DisplayMap, RoundIndex};

/// One graph file, or several laid over each other.
#[derive(Clone, Debug)]
pub struct File {
    /// Its path; of the outermost file when there are several.
    pub path: Arc<str>,
    /// `name`.
    pub name: Option<Spanned<String>>,
    /// `about`.
    pub about: Option<Spanned<String>>,
    /// `present`.
    pub present: Option<Spanned<String>>,
    /// `extends`.
    pub extends: Option<Spanned<String>>,
    /// Keys of the file itself that are there under a wrong name, which is reported.
    pub misspelt: Vec<String>,
    /// `[params.*]`.
    pub params: Vec<Param>,
    /// `[blocks.*]`.
    pub blocks: Vec<SharedBlock>,
    /// `[clocks.*]`.
    pub clocks: Vec<Clock>,
    /// `[targets.*]`.
    pub targets: Vec<Target>,
    /// `[buffers.*]`.
    pub buffers: Vec<Buffer>,
    /// `[loops.*]`.
    pub loops: Vec<Loop>,
    /// `[[passes]]`.
    pub passes: Vec<Pass>,
}

/// A live value.
#[derive(Clone, Debug, Keys)]
#[keys(layer("param", unknown = codes::graph::UNKNOWN_PARAM))]
pub struct Param {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Takes it out of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    #[keys(flawed)]
    pub flawed: bool,
    /// Its type: needed.
    #[keys(rename = "type", shape = param_types())]
    pub ty: Option<Spanned<String>>,
    /// Its value until somebody sets it, in its `unit`: needed.
    pub default: Option<Literal>,
    /// Smallest and largest value of each component, in its `unit`; any value when left out, and a field to drag instead of a slider.
    pub range: Option<Spanned<[f64; 2]>>,
    /// Step of the slider, in its `unit`: 1 for integers and a fine one for other numbers when left out.
    #[keys(range = 0.0..=f64::MAX)]
    pub step: Option<Spanned<f64>>,
    /// Text beside the slider; its name when left out.
    pub label: Option<Spanned<String>>,
    /// What it does, for whoever rests the pointer on it; may be left out.
    pub tooltip: Option<Spanned<String>>,
    /// Unit of the value, e.g. `°` or `voxels`: shown behind the number. A number without one when left out.
    pub unit: Option<Spanned<String>>,
    /// Title of the group that it stands in, in the window and in `raxel list`. Without one, params whose names begin with the same word
    /// stand together.
    pub group: Option<Spanned<String>>,
    /// Names of the values 0, 1, 2, … of an `i32` or `u32`, to be chosen from. They are its range; a number when left out.
    pub choices: Option<Spanned<Choices>>,
    /// Of a `vec3` or `vec4`: it is a linear colour. When left out, one is whose name or label has `color`, `colour`, `tint` or `albedo`.
    pub color: Option<Spanned<bool>>,
}

/// Names of values: at least two, none of them empty.
#[derive(Clone, Debug)]
pub struct Choices(pub Vec<Spanned<String>>);

/// A rhythm apart from the frames.
#[derive(Clone, Debug, Keys)]
#[keys(layer("clock", unknown = codes::graph::UNKNOWN_CLOCK))]
pub struct Clock {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Takes it out of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    #[keys(flawed)]
    pub flawed: bool,
    /// Ticks a second of the session's time. Needed.
    #[keys(read = |node| at(node, rate(node)), range = RATES, unit = "Hz")]
    pub hz: Option<Spanned<f64>>,
    /// Ticks that one frame catches up at most; time beyond them is dropped.
    #[keys(range = 1..=MOST_TICKS, told = 4)]
    pub most: Option<Spanned<u32>>,
}

/// `[targets.NAME]`.
#[derive(Clone, Debug)]
pub struct Target {
    /// The key.
    pub name: Spanned<String>,
    /// `remove = true`.
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    pub flawed: bool,
    /// `source`.
    pub source: Option<Spanned<String>>,
    /// `copy`.
    pub copy: Option<Spanned<String>>,
    /// `slices` of a file.
    pub slices: Option<Spanned<u32>>,
    /// `encoding` of a file: sRGB, else linear.
    pub srgb: Option<Spanned<bool>>,
    /// `format`.
    pub format: Option<Spanned<String>>,
    /// `size`.
    pub size: Option<Spanned<Size>>,
    /// `mips`; 0 is `"full"`.
    pub mips: Option<Spanned<u32>>,
    /// `layers`.
    pub layers: Option<Spanned<u32>>,
    /// `history`.
    pub history: Option<Spanned<u32>>,
    /// `clear`.
    pub clear: Option<Literal>,
    /// `init`.
    pub init: Option<Literal>,
    /// `keep`.
    pub keep: Option<Spanned<bool>>,
    /// `clock`.
    pub clock: Option<Spanned<String>>,
    /// `display`.
    pub display: Option<Spanned<Display>>,
}

/// `size` of a target.
#[derive(Clone, Debug, PartialEq)]
pub enum Size {
    /// `0.5`, `{ scale = [0.5, 1.0] }`: parts of the output.
    Output([f64; 2]),
    /// `[w, h]` in texels.
    Fixed2([u32; 2]),
    /// `[w, h, d]` in texels.
    Fixed3([u32; 3]),
    /// `{ of = "hit", scale = 0.5 }`, `{ of = "world", scale = 0.25 }`.
    Of {
        /// The other target, or [`WORLD`].
        target: Spanned<String>,
        /// 1 when the file gives none.
        scale: f64,
    },
}

/// What `of` says when a size follows the bounds of the world.
pub const WORLD: &str = "world";

/// `display` of a target.
#[derive(Clone, Debug, PartialEq)]
pub struct Display {
    /// `map`, or the whole value when it is a word.
    pub map: Option<DisplayMap>,
    /// `range`.
    pub range: Option<[f64; 2]>,
    /// `channel`.
    pub channel: Option<Spanned<u32>>,
}

/// `[buffers.NAME]`.
#[derive(Clone, Debug)]
pub struct Buffer {
    /// The key.
    pub name: Spanned<String>,
    /// `remove = true`.
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    pub flawed: bool,
    /// `size`.
    pub size: Option<Spanned<BufferSize>>,
    /// `source`.
    pub source: Option<Spanned<String>>,
    /// `values`.
    pub values: Option<Literal>,
    /// `type` of the values, a word such as `vec3`.
    pub ty: Option<Spanned<String>>,
    /// `copy`.
    pub copy: Option<Spanned<String>>,
    /// `clear`.
    pub clear: Option<Literal>,
    /// `init`.
    pub init: Option<Literal>,
    /// `history`.
    pub history: Option<Spanned<u32>>,
    /// `keep`.
    pub keep: Option<Spanned<bool>>,
    /// `clock`.
    pub clock: Option<Spanned<String>>,
    /// `warnings`.
    pub warnings: Option<Vec<Warning>>,
}

/// One of `[[buffers.NAME.warnings]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// `offset` in bytes; 0 when the file gives none.
    pub offset: u64,
    /// `says`.
    pub says: Spanned<String>,
    /// `help`.
    pub help: Option<String>,
}

/// `size` of a buffer.
#[derive(Clone, Debug, PartialEq)]
pub enum BufferSize {
    /// Bytes.
    Bytes(u64),
    /// `{ count = 1024, stride = 16 }`.
    Elements {
        /// Number of elements.
        count: u64,
        /// Bytes of an element.
        stride: u32,
    },
    /// `{ of = "hit", per = 2, stride = 8 }`, `{ of = "world", scale = 0.25, stride = 4 }`.
    Of {
        /// The target or buffer, or [`WORLD`].
        of: Spanned<String>,
        /// The part of the world; only there.
        scale: Option<Spanned<f64>>,
        /// Elements for each texel or element of it; 1 when the file gives none.
        per: u32,
        /// Bytes of an element.
        stride: u32,
    },
}

/// `[loops.NAME]`.
#[derive(Clone, Debug)]
pub struct Loop {
    /// The key.
    pub name: Spanned<String>,
    /// `remove = true`.
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    pub flawed: bool,
    /// `count`.
    pub count: Option<Spanned<Rounds>>,
    /// `order`: down, else up.
    pub down: Option<Spanned<bool>>,
    /// `swap`: pairs of names.
    pub swap: Option<Vec<[Spanned<String>; 2]>>,
}

/// `count` of a loop.
#[derive(Clone, Debug, PartialEq)]
pub enum Rounds {
    /// `4`.
    Fixed(u32),
    /// `"param.bounces"`, without `param.`.
    Param(Spanned<String>),
    /// `{ mips = "bloom" }`: the steps from one mip of a target to the next.
    Mips(Spanned<String>),
}

/// A mip as the file names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mip {
    /// A number.
    Level(u32),
    /// Another one in each round of a loop: `"loop.index"`, `"loop.next"`.
    Round(RoundIndex),
}

/// One of `[[passes]]`.
#[derive(Clone, Debug)]
pub struct Pass {
    /// `name`.
    pub name: Spanned<String>,
    /// `remove = true`.
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    pub flawed: bool,
    /// `before`: insert (or move) the pass before this one of the base.
    pub before: Option<Spanned<String>>,
    /// `after`: the same, after.
    pub after: Option<Spanned<String>>,
    /// `shader`, relative to `shaders/`.
    pub shader: Option<Spanned<String>>,
    /// `entry`.
    pub entry: Option<Spanned<String>>,
    /// `defines`: name and text.
    pub defines: Vec<(Spanned<String>, String)>,
    /// `specialization`.
    pub specialization: Vec<(Spanned<String>, Constant)>,
    /// `subgroup`.
    pub subgroup_size: Option<Spanned<u32>>,
    /// `dispatch`.
    pub dispatch: Option<Spanned<Dispatch>>,
    /// `bind`.
    pub bind: Vec<Bind>,
    /// `push`.
    pub push: Option<Fills<Member>>,
    /// `uniforms`.
    pub uniforms: Vec<Fills<Member>>,
    /// `loop`.
    pub in_loop: Option<Spanned<String>>,
    /// `when`.
    pub when: Option<Spanned<String>>,
    /// `every`.
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

/// One entry of `bind`.
#[derive(Clone, Debug)]
pub struct Bind {
    /// The key: the GLSL name.
    pub name: Spanned<String>,
    /// `{ remove = true }`.
    pub remove: bool,
    /// The resource with its age, e.g. `color@1`. `None` when the file's value is wrong, and with `remove`.
    pub target: Option<Spanned<String>>,
    /// `mip`.
    pub mip: Option<Spanned<Mip>>,
    /// `layer`.
    pub layer: Option<Spanned<u32>>,
    /// `filter`: linear, else nearest.
    pub linear: Option<Spanned<bool>>,
    /// `wrap`: repeat, else clamp.
    pub repeat: Option<Spanned<bool>>,
    /// `partial`.
    pub partial: Option<Spanned<bool>>,
}

/// `[blocks.NAME]`: values for every push-constant or uniform block of that name.
#[derive(Clone, Debug)]
pub struct SharedBlock {
    /// The values.
    pub fills: Fills<Member>,
    /// `remove = true`.
    pub remove: bool,
}

/// The values of one push-constant or uniform block; `M` is a [`Member`], or what it is when its names are resolved.
#[derive(Clone, Debug)]
pub struct Fills<M> {
    /// The key of the table: `push`, the GLSL name of the uniform block, or the name in `[blocks.*]`.
    pub name: Spanned<String>,
    /// Members by path.
    pub members: Vec<M>,
}

/// The value of one member.
#[derive(Clone, Debug)]
pub struct Member {
    /// The key; nested members by path, e.g. `sun.direction`.
    pub path: Spanned<String>,
    /// `{ remove = true }`.
    pub remove: bool,
    /// `type`, a word such as `vec3` or `vec4[8]`.
    pub ty: Option<Spanned<String>>,
    /// `from`, or the whole value when it is a string.
    pub from: Option<Spanned<String>>,
    /// `value`, or the whole value when it is no string and no table.
    pub value: Option<Literal>,
    /// `offset` in bytes.
    pub offset: Option<Spanned<u32>>,
}

/// A value written in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Literal {
    /// The value.
    pub data: Data,
    /// Where it is written.
    pub span: Span,
}

/// What a [`Literal`] holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// `true`, `false`.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A finite float.
    Float(f64),
    /// An array.
    Array(Vec<Literal>),
}

/// The value of a specialization constant.
#[derive(Clone, Debug, PartialEq)]
pub enum Constant {
    /// Written in the file.
    Value(Literal),
    /// The word of `from`, or the whole value when it is a string.
    From(Spanned<String>),
}
