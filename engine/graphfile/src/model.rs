//! The file model: the contents of graph files, word for word, each value with its place. Nothing is looked up yet, and every key may be
//! missing, because a file that `extends` another has only the differences. [`crate::extends`] lays such files over each other.

mod passes;

use std::sync::Arc;

use raxel_diagnostics::{Span, Spanned, codes};
use raxel_graph::checked::DisplayMap;
use raxel_language::{Describe, Keys, NumberRange, Shape};
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

pub(crate) use passes::{Bind, Constant, Dispatch, Every, Filter, Mip, Pass, Rhythm, Wrap};

/// A compute render graph: targets, buffers, params, blocks and passes.
///
/// One graph file, or several laid over each other.
#[derive(Clone, Debug, Keys)]
#[keys(layer)]
pub(crate) struct File {
    /// Its path; of the outermost file when there are several.
    #[keys(skip)]
    pub path: Arc<str>,
    /// Keys of the file itself that are there under a wrong name, which is reported.
    #[keys(skip)]
    pub misspelt: Vec<String>,
    /// Name of the graph. Needed, unless the graph extends another.
    pub name: Option<Spanned<String>>,
    /// One line about the graph; may be left out.
    pub about: Option<Spanned<String>>,
    /// The target or buffer that is shown by default. Needed, unless the extended graph has it.
    pub present: Option<Spanned<String>>,
    /// The graph that this one changes: a path relative to this file. Tables merge by name, key by key; passes by `name`. A graph of its
    /// own when left out.
    pub extends: Option<Spanned<String>>,
    /// Live values: sliders in the window, tracks in a demo, `--set` on the command line.
    #[keys(read = by_name, shape = named("param"))]
    pub params: Vec<Param>,
    /// Fixed rates, independent of the frame rate. Passes with `every` of a clock run once for each of its ticks.
    #[keys(read = by_name, shape = named("clock"))]
    pub clocks: Vec<Clock>,
    /// Images that passes read and write.
    #[keys(read = by_name, shape = named("target"))]
    pub targets: Vec<Target>,
    /// Storage buffers. Buffers and targets share one set of names.
    #[keys(read = by_name, shape = named("buffer"))]
    pub buffers: Vec<Buffer>,
    /// Values for every push-constant or uniform block of this name: the name of the instance, or of the block. Values of the pass win.
    #[keys(read = shared_blocks, shape = named("fills"))]
    pub blocks: Vec<SharedBlock>,
    /// Groups of adjacent passes that repeat within a frame: passes with `loop = "NAME"`.
    #[keys(read = by_name, shape = named("loop"))]
    pub loops: Vec<Loop>,
    /// Compute dispatches, in the order in which they run.
    #[keys(read = passes, shape = Shape::array(reference("pass"), ..))]
    pub passes: Vec<Pass>,
}

/// A live value.
#[derive(Clone, Debug, Keys)]
#[keys(layer("param", unknown = codes::graph::UNKNOWN_PARAM))]
pub(crate) struct Param {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Removes it from the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported. A key that seems to be missing may be misspelt.
    #[keys(flawed)]
    pub(crate) flawed: bool,
    /// Type of the value. Needed.
    #[keys(rename = "type", shape = param_types())]
    pub ty: Option<Spanned<String>>,
    /// Value until you set another one, in its `unit`. Needed.
    pub default: Option<Literal>,
    /// Smallest and largest value of each component, in its `unit`. When left out, every value is allowed, and the window has a number
    /// field instead of a slider.
    pub range: Option<Spanned<[f64; 2]>>,
    /// Step of the slider, in its `unit`. When left out, it is 1 for integers, and small for other numbers.
    #[keys(range = 0.0..=f64::MAX)]
    pub step: Option<Spanned<f64>>,
    /// Text beside the slider. The name of the param when left out.
    pub label: Option<Spanned<String>>,
    /// Help that the window shows under the pointer; may be left out.
    pub tooltip: Option<Spanned<String>>,
    /// Unit that is shown behind the number, e.g. `°` or `voxels`. No unit when left out.
    pub unit: Option<Spanned<String>>,
    /// Title of its group in the window and in `raxel list`. Without a group, params whose names begin with the same word stand together.
    pub group: Option<Spanned<String>>,
    /// Names of the values 0, 1, 2, … of an `i32` or `u32`. They are its range. A plain number when left out.
    pub choices: Option<Spanned<Choices>>,
    /// Whether a `vec3` or `vec4` is a linear colour. When left out, it is one if its name or label has `color`, `colour`, `tint` or
    /// `albedo`.
    pub color: Option<Spanned<bool>>,
}

/// Names of values: at least two, none of them empty.
#[derive(Clone, Debug)]
pub(crate) struct Choices(pub Vec<Spanned<String>>);

/// A rhythm apart from the frames.
#[derive(Clone, Debug, Keys)]
#[keys(layer("clock", unknown = codes::graph::UNKNOWN_CLOCK))]
pub(crate) struct Clock {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Removes it from the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported. A key that seems to be missing may be misspelt.
    #[keys(flawed)]
    pub(crate) flawed: bool,
    /// Ticks a second of the session's time. Needed.
    #[keys(read = |node| at(node, rate(node)), range = RATES, unit = "Hz")]
    pub hz: Option<Spanned<f64>>,
    /// Most ticks that one frame runs. Time beyond them is dropped.
    #[keys(range = 1..=MOST_TICKS, told = 4)]
    pub most: Option<Spanned<u32>>,
}

/// An image.
#[derive(Clone, Debug, Keys)]
#[keys(layer("target", unknown = codes::graph::UNKNOWN_RESOURCE), over = settle_target, check = supplied_target(source, copy))]
pub(crate) struct Target {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Removes it from the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported. A key that seems to be missing may be misspelt.
    #[keys(flawed)]
    pub(crate) flawed: bool,
    /// Supplies it from outside; passes only read it. `world.texture3d`, `model.NAME.texture3d`, `input.microphone`, or a picture, video or
    /// sound of the project, e.g. `file.textures/grass.png`. When left out, passes write it.
    #[keys(excludes("copy", why = "a copy of a source is the graph's own"))]
    pub source: Option<Spanned<String>>,
    /// Fills it at creation, on reset, and when the source changes; passes may write it. `world.texture3d` or `model.NAME.texture3d`.
    /// Nothing when left out.
    pub copy: Option<Spanned<String>>,
    /// Number of pictures in a file that is a strip of pictures, one below the other. They become the slices of a 3-D image. A 2-D image
    /// when left out.
    #[keys(range = 1..=MOST_LAYERS)]
    pub slices: Option<Spanned<u32>>,
    /// How raxel reads a file: `srgb` converts colours to linear light, `linear` keeps the numbers.
    #[keys(told = Encoding::Linear)]
    pub encoding: Option<Spanned<Encoding>>,
    /// Texel format, by the name of the GLSL layout qualifier. Needed, unless it has a `source` or `copy`. A file has its own format, and
    /// can be converted to wider ones.
    #[keys(shape = formats())]
    pub format: Option<Spanned<String>>,
    /// Extent: a part of the output (0.5), texels ([w, h] or [w, h, d]), or a part of another target or of the world. The output when left
    /// out.
    pub size: Option<Spanned<Size>>,
    /// Number of mips; "full" goes down to one texel. A box filter makes the mips of a file.
    ///
    /// 0 is `"full"`.
    #[keys(read = |node| at(node, mips(node)), shape = mip_counts(), told = 1)]
    pub mips: Option<Spanned<u32>>,
    /// Number of array layers.
    #[keys(range = 1..=MOST_LAYERS, told = 1)]
    pub layers: Option<Spanned<u32>>,
    /// How many earlier frames (with a clock: ticks) are kept. Passes read them as `NAME@1`, `NAME@2`, …
    #[keys(range = 0..=LONGEST_HISTORY, told = 0)]
    pub history: Option<Spanned<u32>>,
    /// Fills it at the start of each frame: one number, or one for each channel. Nothing when left out.
    #[keys(excludes("init", why = "`clear` fills the target each frame, `init` once"))]
    pub clear: Option<Literal>,
    /// Fills it at creation and on reset: one number, or one for each channel. Contents then stay from frame to frame. Nothing when left
    /// out.
    pub init: Option<Literal>,
    /// Gives it its own memory, and keeps contents from frame to frame; with `clear`, until the next frame clears it.
    #[keys(told = false)]
    pub keep: Option<Spanned<bool>>,
    /// The clock whose ticks turn its history and `clear`, instead of frames. Only passes of this clock write it.
    pub clock: Option<Spanned<String>>,
    /// How numbers become a picture. The map of its format when left out.
    #[keys(read = |node| at(node, display(node)), shape = displays())]
    pub display: Option<Spanned<Display>>,
}

/// `encoding` of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub(crate) enum Encoding {
    /// Numbers as they are.
    Linear,
    /// Colours that become linear light.
    Srgb,
}

/// `size` of a target.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Size {
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

/// The value of `of` when a size follows the bounds of the world.
pub(crate) const WORLD: &str = "world";

/// A part of another target, of the world, or of the output.
#[derive(Keys)]
pub(crate) struct RelativeSize {
    /// The other target, or `world`: a 3-D image with a texel for each voxel of the world's bounds. The output when left out.
    pub of: Option<Spanned<String>>,
    /// The part, as a multiple; the extent is rounded up. One number for every axis, or two for width and height of the output.
    #[keys(told = 1)]
    pub scale: Option<Scale>,
}

/// `scale` of a size.
pub(crate) enum Scale {
    /// Of every axis.
    All(f64),
    /// Of width and height.
    Each([f64; 2]),
}

/// The map with its settings.
#[derive(Clone, Debug, PartialEq, Keys)]
pub(crate) struct Display {
    /// The map. When left out: `id` for integers, `gray` for one or two channels, `raw` for normalised formats, `color` for other floats.
    pub map: Option<DisplayMap>,
    /// Values of texels at the two ends of the map.
    #[keys(read = shown_range, told = [0.0, 1.0])]
    pub range: Option<[f64; 2]>,
    /// The channel that maps of one channel show, from 0.
    #[keys(range = 0..=3, told = 0)]
    pub channel: Option<Spanned<u32>>,
}

/// A storage buffer.
#[derive(Clone, Debug, Keys)]
#[keys(layer("buffer", unknown = codes::graph::UNKNOWN_RESOURCE), over = settle_buffer, check = supplied_buffer())]
pub(crate) struct Buffer {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Removes it from the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported. A key that seems to be missing may be misspelt.
    #[keys(flawed)]
    pub(crate) flawed: bool,
    /// Bytes, or elements: a number of them, or some for each texel of a target, element of a buffer or voxel of the world. Needed, unless
    /// it has `values`, `source` or `copy`.
    pub size: Option<Spanned<BufferSize>>,
    /// Supplies it from outside; passes only read it. `world.tree64` or another layout, `model.NAME.tree64`, `world.lights`,
    /// `world.instances`, `input.keys`, or a file, e.g. `file.data/table.bin`. Passes write `world.edits` and `world.poses`: edits of the
    /// world, and poses of instances. When left out, passes write it.
    #[keys(excludes("copy", why = "a copy of a source is the graph's own"))]
    pub source: Option<Spanned<String>>,
    /// Contents: numbers, or arrays with the components of a vector. Passes only read it. Instead of `size`.
    #[keys(
        read = values,
        shape = listed_values(),
        excludes(
            "size", "source", "copy", "clear", "init", "history", "warnings",
            why = "`values` give the size and the contents"
        )
    )]
    pub values: Option<Literal>,
    /// Type of the values, in the std430 layout: a `vec3` takes 16 bytes, and a `bool` is a `uint`.
    #[keys(rename = "type", shape = value_types(), told = "f32".to_owned())]
    pub ty: Option<Spanned<String>>,
    /// Fills it at creation, on reset, and when the source changes; passes may write it. `world.octree` or another layout, or
    /// `model.NAME.octree`. Nothing when left out.
    pub copy: Option<Spanned<String>>,
    /// 32-bit pattern that fills it at the start of each frame. Nothing when left out.
    #[keys(shape = i64::shape(&NumberRange::default()), excludes("init", why = "`clear` fills the buffer each frame, `init` once"))]
    pub clear: Option<Literal>,
    /// 32-bit pattern that fills it at creation and on reset. Contents then stay from frame to frame. Nothing when left out.
    #[keys(shape = i64::shape(&NumberRange::default()))]
    pub init: Option<Literal>,
    /// How many earlier frames (with a clock: ticks) are kept. Passes read them as `NAME@1`, `NAME@2`, …
    #[keys(range = 0..=LONGEST_HISTORY, told = 0)]
    pub history: Option<Spanned<u32>>,
    /// Gives it its own memory, and keeps contents from frame to frame; with `clear`, until the next frame clears it.
    #[keys(told = false)]
    pub keep: Option<Spanned<bool>>,
    /// The clock whose ticks turn its history and `clear`, instead of frames. Only passes of this clock write it.
    pub clock: Option<Spanned<String>>,
    /// Passes bind it only if the world has this, e.g. `world.has_instances`; `!` negates. Otherwise raxel compiles and runs them without
    /// the binding. With it, their shaders see `RX_BINDS_` and the name of the binding. Always bound when left out.
    #[keys(shape = facts_of_worlds())]
    pub when: Option<Spanned<String>>,
    /// Warnings while a word of it is not 0: passes count unwanted events there, e.g. a full queue. None when left out.
    #[keys(read = warnings, shape = listed_warnings())]
    pub warnings: Option<Vec<Warning>>,
}

/// A count that should be 0.
#[derive(Clone, Debug, PartialEq, Keys)]
pub(crate) struct Warning {
    /// Place of the count, a `uint`, in the buffer: bytes, a multiple of 4.
    #[keys(read = whole_word, range = 0..=LARGEST_BUFFER, default = 0, unit = "bytes")]
    pub offset: u64,
    /// The counted thing and its meaning for the picture, e.g. "faces found no slot". The count follows. Needed.
    #[keys(read = |node| at(node, filled(node)), shape = Shape::Schema(json!({ "type": "string", "minLength": 1 })))]
    pub says: Spanned<String>,
    /// Advice to the user; may be left out.
    pub help: Option<String>,
}

/// `size` of a buffer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum BufferSize {
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
pub(crate) struct Elements {
    /// Bytes of an element, a multiple of 4. Needed.
    #[keys(read = stride, range = 4..=LARGEST_STRIDE, unit = "bytes")]
    pub stride: u32,
    /// Elements for each texel of this target, element of this buffer, or voxel of the bounds of the `world`. Instead of `count`.
    #[keys(excludes("count", why = "texels and elements of something else are counted already"))]
    pub of: Option<Spanned<String>>,
    /// Number of elements. Instead of `of`.
    #[keys(range = 1..=LARGEST_BUFFER)]
    pub count: Option<u64>,
    /// Elements for each texel, element or voxel of `of`.
    #[keys(range = 1..=MOST_PER, told = 1)]
    pub per: Option<u32>,
    /// Texels per voxel along each axis, for `of = "world"`; the extent is rounded up.
    #[keys(range = SCALES, told = 1.0)]
    pub scale: Option<Spanned<f64>>,
}

/// Passes that are repeated.
#[derive(Clone, Debug, Keys)]
#[keys(layer("loop", unknown = codes::graph::UNKNOWN_LOOP))]
pub(crate) struct Loop {
    /// The key.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Removes it from the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Something in it was wrong and is reported. A key that seems to be missing may be misspelt.
    #[keys(flawed)]
    pub(crate) flawed: bool,
    /// Number of rounds. Needed.
    pub count: Option<Spanned<Rounds>>,
    /// Direction of `loop.index`: `up` from 0, or `down` to 0.
    #[keys(told = Order::Up)]
    pub order: Option<Spanned<Order>>,
    /// Pairs of names that are exchanged after each round, for later rounds and all later passes. None when left out.
    #[keys(read = swap, shape = pairs_of_names())]
    pub swap: Option<Vec<[Spanned<String>; 2]>>,
}

/// `order` of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub(crate) enum Order {
    /// From 0.
    Up,
    /// To 0.
    Down,
}

/// From mip to mip.
#[derive(Keys)]
pub(crate) struct MipSteps {
    /// The target: one round for each step from a mip to the next. Needed in this form.
    pub mips: Spanned<String>,
}

/// `count` of a loop.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Rounds {
    /// `4`.
    Fixed(u32),
    /// `"param.bounces"`, without `param.`.
    Param(Spanned<String>),
    /// `{ mips = "bloom" }`: the steps from one mip of a target to the next.
    Mips(Spanned<String>),
}

/// `[blocks.NAME]`: values for every push-constant or uniform block of that name.
#[derive(Clone, Debug)]
pub(crate) struct SharedBlock {
    /// The values.
    pub fills: Fills<Member>,
    /// `remove = true`.
    pub remove: bool,
}

/// The values of one push-constant or uniform block; `M` is a [`Member`], or its form with resolved names.
#[derive(Clone, Debug)]
pub(crate) struct Fills<M> {
    /// The key of the table: `push`, the GLSL name of the uniform block, or the name in `[blocks.*]`.
    pub name: Spanned<String>,
    /// Members by path.
    pub members: Vec<M>,
}

/// A member with its type, checked against the shader.
#[derive(Clone, Debug, Keys)]
#[keys(layer("member", unknown = codes::graph::NOTHING_TO_OVERLAY, whole))]
pub(crate) struct Member {
    /// The key; nested members by path, e.g. `sun.direction`.
    #[keys(entry)]
    pub path: Spanned<String>,
    /// Removes it from the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// Type, such as `vec3`, or an array such as `vec4[8]`. Needed in this form.
    #[keys(rename = "type", shape = member_types())]
    pub ty: Option<Spanned<String>>,
    /// Source of the value, instead of `value`. A member that is only a string is its source.
    #[keys(shape = reference("from"), excludes("value", why = "a member has one value"))]
    pub from: Option<Spanned<String>>,
    /// The value, instead of `from`: a number, a boolean, or an array, of the components of a vector, the columns of a matrix, or the elements
    /// of an array. A member that is only one of these is its value.
    #[keys(shape = reference("literal"))]
    pub value: Option<Literal>,
    /// Offset in bytes, checked against the shader. Not checked when left out.
    #[keys(range = 0..=u32::MAX)]
    pub offset: Option<Spanned<u32>>,
}

/// A value written in the file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Literal {
    /// The value.
    pub data: Data,
    /// Where it is written.
    pub span: Span,
}

/// The contents of a [`Literal`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Data {
    /// `true`, `false`.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A finite float.
    Float(f64),
    /// An array.
    Array(Vec<Literal>),
}
