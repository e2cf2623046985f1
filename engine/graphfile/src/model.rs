//! The file model: what graph files say, word for word, each value with its place. Nothing is looked up yet, and every key may be
//! missing, because a file that `extends` another says only what differs. [`crate::extends`] lays such files over each other.

mod passes;

use std::sync::Arc;

use raxel_diagnostics::{Span, Spanned, codes};
use raxel_graph::checked::DisplayMap;
use raxel_language::{Describe, Keys, Limits, Shape};
use serde_json::json;

use crate::extends::{settle_buffer, settle_target};
use crate::parse::loops::swap;
use crate::parse::resources::{
    LARGEST_BUFFER, LARGEST_STRIDE, LONGEST_HISTORY, MOST_LAYERS, MOST_PER, SCALES, beside_of, display, filled, mips,
    shown_range, stride, supplied_buffer, supplied_target, values, warnings, whole_word,
};
use crate::parse::{MOST_TICKS, RATES, at, by_name, passes, rate, shared_blocks};
use crate::schema::{
    displays, facts_of_worlds, formats, listed_values, listed_warnings, member_types, mip_counts, named,
    pairs_of_names, param_types, reference, value_types,
};

pub use passes::{Bind, Constant, Dispatch, Every, Filter, Mip, Pass, Rhythm, Wrap};

/// A compute render graph: targets, buffers, params, blocks and passes.
///
/// One graph file, or several laid over each other.
#[derive(Clone, Debug, Keys)]
#[keys(layer)]
pub struct File {
    /// Its path; of the outermost file when there are several.
    #[keys(skip)]
    pub path: Arc<str>,
    /// Keys of the file itself that are there under a wrong name, which is reported.
    #[keys(skip)]
    pub misspelt: Vec<String>,
    /// Name of the graph: needed, unless it extends another.
    pub name: Option<Spanned<String>>,
    /// What it shows, in one line; may be left out.
    pub about: Option<Spanned<String>>,
    /// The target or buffer that is shown by default: needed, unless the graph that it extends says it.
    pub present: Option<Spanned<String>>,
    /// Another graph file, relative to this one, of which only the differences are written here; left out where a graph stands by itself.
    /// Tables are laid over each other by name, key by key; passes by `name`.
    pub extends: Option<Spanned<String>>,
    /// Live values: sliders in the window, tracks in a demo, `--set` on the command line.
    #[keys(read = by_name, shape = named("param"))]
    pub params: Vec<Param>,
    /// Rhythms of their own, apart from the frames: passes with `every` of a clock run once for each of its ticks.
    #[keys(read = by_name, shape = named("clock"))]
    pub clocks: Vec<Clock>,
    /// Images that passes read and write.
    #[keys(read = by_name, shape = named("target"))]
    pub targets: Vec<Target>,
    /// Storage buffers. They share their names with the targets.
    #[keys(read = by_name, shape = named("buffer"))]
    pub buffers: Vec<Buffer>,
    /// Values that are written once: each table fills every push-constant or uniform block of its name (the name of the instance, or of
    /// the block), as far as the pass gives no values of its own.
    #[keys(read = shared_blocks, shape = named("fills"))]
    pub blocks: Vec<SharedBlock>,
    /// Groups of passes that are repeated in each frame: those with `loop = "NAME"`, which stand together.
    #[keys(read = by_name, shape = named("loop"))]
    pub loops: Vec<Loop>,
    /// Compute dispatches, in the order in which they run.
    #[keys(read = passes, shape = Shape::array(reference("pass"), ..))]
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

/// An image.
#[derive(Clone, Debug, Keys)]
#[keys(layer("target", unknown = codes::graph::UNKNOWN_RESOURCE), over = settle_target, check = supplied_target(source, copy))]
pub struct Target {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Takes it out of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    #[keys(flawed)]
    pub flawed: bool,
    /// What supplies it from outside, and passes only read: `world.texture3d`, `model.NAME.texture3d`, or a file of the project, e.g.
    /// `file.textures/grass.png` (.png or .exr). Left out where passes write it.
    #[keys(excludes("copy", why = "a copy of a source is the graph's own"))]
    pub source: Option<Spanned<String>>,
    /// What fills it when that changes, at creation and on reset, and passes may write: `world.texture3d` or `model.NAME.texture3d`. Left
    /// out where nothing does.
    pub copy: Option<Spanned<String>>,
    /// Of a file: it is a strip of so many pictures, one below the other, that are the slices of a 3-D image. A 2-D image when left out.
    #[keys(range = 1..=MOST_LAYERS)]
    pub slices: Option<Spanned<u32>>,
    /// Of a file: `srgb` brings its colours into linear light, `linear` takes the numbers as they are.
    #[keys(told = Encoding::Linear)]
    pub encoding: Option<Spanned<Encoding>>,
    /// Texel format, named by GLSL's own layout qualifier. Needed, unless a `source` or `copy` fills it: a file has a format of its own,
    /// and can be brought into others.
    #[keys(shape = formats())]
    pub format: Option<Spanned<String>>,
    /// A part of the output (0.5), texels ([w, h] or [w, h, d]), or a part of another target or of the world. The output when left out.
    pub size: Option<Spanned<Size>>,
    /// Number of mips; "full" goes down to one texel. Those of a file are made by a box filter.
    ///
    /// 0 is `"full"`.
    #[keys(read = |node| at(node, mips(node)), shape = mip_counts(), told = 1)]
    pub mips: Option<Spanned<u32>>,
    /// Number of array layers.
    #[keys(range = 1..=MOST_LAYERS, told = 1)]
    pub layers: Option<Spanned<u32>>,
    /// How many earlier frames are kept.
    #[keys(range = 0..=LONGEST_HISTORY, shape = reference("history"))]
    pub history: Option<Spanned<u32>>,
    /// Fills it at the start of each frame: one number, or one a channel. When left out, nothing does.
    #[keys(excludes("init", why = "`clear` fills the target each frame, `init` once"))]
    pub clear: Option<Literal>,
    /// Fills it at creation and on reset: one number, or one a channel; the contents then survive from frame to frame. When left out, they
    /// do not.
    pub init: Option<Literal>,
    /// Has memory of its own and keeps its contents from frame to frame (with `clear`: until it is cleared).
    #[keys(told = false)]
    pub keep: Option<Spanned<bool>>,
    /// The clock whose ticks turn its history and its clears, instead of the frames. Only passes of that clock write it.
    pub clock: Option<Spanned<String>>,
    /// How it becomes a picture; by the map of its format when left out.
    #[keys(read = |node| at(node, display(node)), shape = displays())]
    pub display: Option<Spanned<Display>>,
}

/// `encoding` of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum Encoding {
    /// Numbers as they are.
    Linear,
    /// Colours that become linear light.
    Srgb,
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

/// A part of another target, of the world, or of the output.
#[derive(Keys)]
pub struct Part {
    /// The other target, or `world`: three dimensions, one texel per voxel of the world's bounds, rounded up. The output when left out.
    pub of: Option<Spanned<String>>,
    /// The part, as a multiple: one number for every axis, or two for width and height of the output.
    #[keys(told = 1)]
    pub scale: Option<Scale>,
}

/// `scale` of a size.
pub enum Scale {
    /// Of every axis.
    All(f64),
    /// Of width and height.
    Each([f64; 2]),
}

/// The map with its settings.
#[derive(Clone, Debug, PartialEq, Keys)]
pub struct Display {
    /// The map. When left out: `id` for integers, `gray` for one or two channels, `raw` for normalised formats, `color` for other floats.
    pub map: Option<DisplayMap>,
    /// Values of texels that are shown as the ends of the map.
    #[keys(read = shown_range, told = [0.0, 1.0])]
    pub range: Option<[f64; 2]>,
    /// The channel that maps of one channel show, from 0.
    #[keys(range = 0..=3, told = 0)]
    pub channel: Option<Spanned<u32>>,
}

/// A storage buffer.
#[derive(Clone, Debug, Keys)]
#[keys(layer("buffer", unknown = codes::graph::UNKNOWN_RESOURCE), over = settle_buffer, check = supplied_buffer())]
pub struct Buffer {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Takes it out of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    #[keys(flawed)]
    pub flawed: bool,
    /// Bytes, a number of elements, or elements for each texel of a target or of a part of the world, or for each element of another
    /// buffer. Needed, unless `values`, `source` or `copy` say it.
    pub size: Option<Spanned<BufferSize>>,
    /// What supplies it from outside, and passes only read: `world.tree64` or another layout, `model.NAME.tree64`, or the bytes of a file,
    /// e.g. `file.data/table.bin`. Or `world.edits` or `world.poses`, which passes write: what they do to the world, and where its
    /// instances go. Left out where passes write it.
    #[keys(excludes("copy", why = "a copy of a source is the graph's own"))]
    pub source: Option<Spanned<String>>,
    /// What is in it: numbers, or arrays of as many as a vector has components. Passes only read it. Instead of `size`.
    #[keys(
        read = values,
        shape = listed_values(),
        excludes(
            "size", "source", "copy", "clear", "init", "history", "warnings",
            why = "`values` give the size and the contents"
        )
    )]
    pub values: Option<Literal>,
    /// Type of the values; laid out as std430 does, a `vec3` in 16 bytes, a `bool` as a `uint`.
    #[keys(rename = "type", shape = value_types(), told = "f32".to_owned())]
    pub ty: Option<Spanned<String>>,
    /// What fills it when that changes, at creation and on reset, and passes may write: `world.octree` or another layout, or
    /// `model.NAME.octree`. Left out where nothing does.
    pub copy: Option<Spanned<String>>,
    /// 32-bit pattern that fills it at the start of each frame. When left out, nothing does.
    #[keys(shape = i64::shape(&Limits::default()), excludes("init", why = "`clear` fills the buffer each frame, `init` once"))]
    pub clear: Option<Literal>,
    /// 32-bit pattern that fills it at creation and on reset; the contents then survive from frame to frame. When left out, they do not.
    #[keys(shape = i64::shape(&Limits::default()))]
    pub init: Option<Literal>,
    /// How many earlier frames are kept.
    #[keys(range = 0..=LONGEST_HISTORY, shape = reference("history"))]
    pub history: Option<Spanned<u32>>,
    /// Has memory of its own and keeps its contents from frame to frame (with `clear`: until it is cleared).
    #[keys(told = false)]
    pub keep: Option<Spanned<bool>>,
    /// The clock whose ticks turn its history and its clears, instead of the frames. Only passes of that clock write it.
    pub clock: Option<Spanned<String>>,
    /// What the world must have for passes to bind it, e.g. `world.has_instances`; `!` negates. Where this does not hold, passes are compiled
    /// and run without the binding. Where it holds, their shaders see `RX_BINDS_NAME`, with the binding's name. Bound everywhere when left out.
    #[keys(shape = facts_of_worlds())]
    pub when: Option<Spanned<String>>,
    /// What is said while a word of it is not 0: passes count there what should not be, e.g. what found no room. Nothing when left out.
    #[keys(read = warnings, shape = listed_warnings())]
    pub warnings: Option<Vec<Warning>>,
}

/// A count that should be 0.
#[derive(Clone, Debug, PartialEq, Keys)]
pub struct Warning {
    /// Where in the buffer the count is, a `uint`: bytes, a multiple of 4.
    #[keys(read = whole_word, range = 0..=LARGEST_BUFFER, default = 0, unit = "bytes")]
    pub offset: u64,
    /// What is counted and what it means for the picture, e.g. "faces found no slot"; the count follows it. Needed.
    #[keys(read = |node| at(node, filled(node)), shape = Shape::Schema(json!({ "type": "string", "minLength": 1 })))]
    pub says: Spanned<String>,
    /// What can be done about it; may be left out.
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

/// Elements.
#[derive(Keys)]
#[keys(check = beside_of(of, per, scale))]
pub struct Elements {
    /// Bytes of an element, a multiple of 4: needed.
    #[keys(read = stride, range = 4..=LARGEST_STRIDE, unit = "bytes")]
    pub stride: u32,
    /// Elements for each texel of this target, each element of this buffer, or each voxel of the bounds of the `world`; instead of `count`.
    #[keys(excludes("count", why = "texels and elements of something else are counted already"))]
    pub of: Option<Spanned<String>>,
    /// Number of elements, instead of `of`.
    #[keys(range = 1..=LARGEST_BUFFER)]
    pub count: Option<u64>,
    /// Elements for each of them.
    #[keys(range = 1..=MOST_PER, told = 1)]
    pub per: Option<u32>,
    /// With `of = "world"`: texels per voxel on every axis, rounded up.
    #[keys(range = SCALES, told = 1.0)]
    pub scale: Option<Spanned<f64>>,
}

/// Passes that are repeated.
#[derive(Clone, Debug, Keys)]
#[keys(layer("loop", unknown = codes::graph::UNKNOWN_LOOP))]
pub struct Loop {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Takes it out of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported, so that what seems missing may be what is misspelt.
    #[keys(flawed)]
    pub flawed: bool,
    /// Number of rounds: needed.
    pub count: Option<Spanned<Rounds>>,
    /// Whether `loop.index` goes from 0 up or down to 0.
    #[keys(told = Order::Up)]
    pub order: Option<Spanned<Order>>,
    /// Pairs of names that change places after each round, for later rounds and for all later passes; none when left out.
    #[keys(read = swap, shape = pairs_of_names())]
    pub swap: Option<Vec<[Spanned<String>; 2]>>,
}

/// `order` of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum Order {
    /// From 0.
    Up,
    /// To 0.
    Down,
}

/// From mip to mip.
#[derive(Keys)]
pub struct MipSteps {
    /// The target: a round for each step from one of its mips to the next. Needed in this form.
    pub mips: Spanned<String>,
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

/// A member with its type, checked against the shader.
#[derive(Clone, Debug, Keys)]
#[keys(layer("member", unknown = codes::graph::NOTHING_TO_OVERLAY, whole))]
pub struct Member {
    /// The key; nested members by path, e.g. `sun.direction`.
    #[keys(entry)]
    pub path: Spanned<String>,
    /// Takes it out of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Its type; an array as `vec4[8]`. Needed in this form.
    #[keys(rename = "type", shape = member_types())]
    pub ty: Option<Spanned<String>>,
    /// Where the value comes from, instead of `value`: the whole value when it is a string.
    #[keys(shape = reference("from"), excludes("value", why = "a member has one value"))]
    pub from: Option<Spanned<String>>,
    /// The value, instead of `from`: the whole value when it is no string and no table.
    #[keys(shape = reference("literal"))]
    pub value: Option<Literal>,
    /// Its offset in bytes; it is not checked when left out.
    #[keys(range = 0..=u32::MAX)]
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
