//! Reads `[targets.*]` and `[buffers.*]`.

use raxel_diagnostics::Spanned;
use raxel_diagnostics::table::{Node, Table};

use super::{at, literal, removes, text};
use crate::front::model::{Buffer, BufferSize, Display, Literal, Size, Target, Warning};
use crate::ir::checked::DisplayMap;
use crate::ir::supply::FILE;

/// Texels on an axis that any device may have at most (`maxImageDimension2D` of today's devices is 16384 or 32768).
const LONGEST_AXIS: u32 = 65_536;
/// Array layers that a target may have at most.
const MOST_LAYERS: u32 = 2048;
/// Earlier frames that a resource may keep at most: each is a full copy.
const LONGEST_HISTORY: u32 = 16;
/// Bytes that a buffer may have at most: 64 GiB.
const LARGEST_BUFFER: u64 = 1 << 36;
/// Bytes that an element of a buffer may have at most.
const LARGEST_STRIDE: u32 = 1 << 20;
/// Elements that a buffer may have at most for each texel or element of something else.
const MOST_PER: u32 = 1 << 16;
/// Warnings that a buffer may give at most: each is a word that is copied in every frame that may have written it.
const MOST_WARNINGS: usize = 16;
/// Scales of a target's size: below, every target is one texel; above, every one is too large.
const SCALES: std::ops::RangeInclusive<f64> = 0.0001..=64.0;

/// The words of `display.map`.
pub const DISPLAY_MAPS: [(&str, DisplayMap); 8] = [
    ("color", DisplayMap::Color),
    ("raw", DisplayMap::Raw),
    ("gray", DisplayMap::Gray),
    ("turbo", DisplayMap::Turbo),
    ("viridis", DisplayMap::Viridis),
    ("normal", DisplayMap::Normal),
    ("id", DisplayMap::Id),
    ("integer", DisplayMap::Integer),
];

/// The words of `encoding`, and whether they mean sRGB.
const ENCODINGS: [(&str, bool); 2] = [("linear", false), ("srgb", true)];

pub fn target(name: String, node: &Node<'_, '_>, table: &Table<'_, '_>) -> Target {
    let before = table.reporter().count();
    table.conflict("clear", "init", "`clear` fills the target each frame, `init` once");
    let mut target = Target {
        name: Spanned::new(name, node.key_span.clone()),
        remove: removes(table, &["remove"]),
        flawed: false,
        source: text(table, "source"),
        copy: text(table, "copy"),
        slices: table.get("slices").and_then(|node| at(&node, node.integer(1..=MOST_LAYERS))),
        srgb: table.get("encoding").and_then(|node| at(&node, node.word(&ENCODINGS))),
        format: text(table, "format"),
        size: table.get("size").and_then(|node| at(&node, size(&node))),
        mips: table.get("mips").and_then(|node| at(&node, mips(&node))),
        layers: table.get("layers").and_then(|node| at(&node, node.integer(1..=MOST_LAYERS))),
        history: history(table),
        clear: table.get("clear").and_then(|node| literal(&node)),
        init: table.get("init").and_then(|node| literal(&node)),
        keep: table.get("keep").and_then(|node| at(&node, node.boolean())),
        clock: text(table, "clock"),
        display: table.get("display").and_then(|node| at(&node, display(&node))),
    };
    table.conflict("source", "copy", "a copy of a source is the graph's own");
    if target.source.is_some() {
        // A file may be brought into a shape that the graph says.
        let file = target.source.as_ref().is_some_and(|source| source.value.starts_with(FILE));
        let all =
            ["size", "layers", "history", "clear", "init", "keep", "clock", "format", "mips", "slices", "encoding"];
        for key in &all[..if file { 7 } else { all.len() }] {
            table.conflict("source", key, "what a source is and holds comes from outside");
        }
    }
    if target.copy.is_some() {
        for key in
            ["size", "layers", "history", "clear", "init", "keep", "clock", "format", "mips", "slices", "encoding"]
        {
            table.conflict("copy", key, "a copy is as its source is");
        }
    }
    table.finish();
    target.flawed = table.reporter().count() > before;
    target
}

fn history(table: &Table<'_, '_>) -> Option<Spanned<u32>> {
    table.get("history").and_then(|node| at(&node, node.integer(0..=LONGEST_HISTORY)))
}

fn size(node: &Node<'_, '_>) -> Option<Size> {
    if node.is_number() {
        return node.number(SCALES).map(|scale| Size::Output([scale; 2]));
    }
    if node.is_array() {
        let elements = node.array()?;
        if elements.iter().any(|element| element.is_number() && !element.is_integer()) {
            return node.bad_value(format!(
                "`{}` is in whole texels; parts of the output are written `{{ scale = [x, y] }}`",
                node.name
            ));
        }
        return match elements.len() {
            3 => node.integers(1..=LONGEST_AXIS).map(Size::Fixed3),
            2 => node.integers(1..=LONGEST_AXIS).map(Size::Fixed2),
            n => node.bad_value(format!("`{}` needs 2 or 3 integers, not {n}", node.name)),
        };
    }
    if !node.is_table() {
        return node.wrong_type("a scale, `[w, h]`, `[w, h, d]` or a table with `of` and `scale`");
    }
    let table = node.table()?;
    let of = text(&table, "of");
    let scale = table.get("scale");
    table.finish();
    match (of, scale) {
        (None, None) => node.bad_value(format!("`{}` needs `of`, `scale` or both", node.name)),
        (Some(target), None) => Some(Size::Of { target, scale: 1.0 }),
        (Some(target), Some(scale)) => Some(Size::Of { target, scale: scale.number(SCALES)? }),
        (None, Some(scale)) if scale.is_array() => scale.numbers::<2>(SCALES).map(Size::Output),
        (None, Some(scale)) => scale.number(SCALES).map(|scale| Size::Output([scale; 2])),
    }
}

fn mips(node: &Node<'_, '_>) -> Option<u32> {
    if node.is_string() {
        return node.word(&[("full", 0)]);
    }
    if !node.is_integer() {
        return node.wrong_type("a number of mips or `\"full\"`");
    }
    node.integer(1..=17)
}

#[expect(clippy::cast_possible_truncation, reason = "the range is checked as the 32-bit floats that shaders get")]
fn display(node: &Node<'_, '_>) -> Option<Display> {
    if node.is_string() {
        return node.word(&DISPLAY_MAPS).map(|map| Display { map: Some(map), range: None, channel: None });
    }
    if !node.is_table() {
        return node.wrong_type("the name of a map, or a table with `map`, `range` and `channel`");
    }
    let table = node.table()?;
    let map = table.get("map").map(|node| node.word(&DISPLAY_MAPS));
    let range = table.get("range").map(|node| {
        let range = node.numbers::<2>(f64::from(f32::MIN)..=f64::from(f32::MAX))?;
        let [low, high] = range;
        if low >= high {
            return node.bad_value(format!("`{}` is empty: {low} is not less than {high}", node.name));
        }
        // Shaders get 32-bit floats, and a range of one value shows one colour.
        if low as f32 >= high as f32 {
            return node.bad_value(format!("`{}` is empty: {low} and {high} are the same 32-bit float", node.name));
        }
        Some(range)
    });
    let channel = table.get("channel").map(|node| at(&node, node.integer(0..=3)));
    table.finish();
    // A key that is there and wrong makes the whole value unknown: its mistake is reported already.
    let known = |absent: bool, known: bool| absent || known;
    let sound = known(map.is_none(), map.flatten().is_some())
        && known(range.is_none(), range.flatten().is_some())
        && known(channel.is_none(), channel.as_ref().is_some_and(Option::is_some));
    sound.then(|| Display { map: map.flatten(), range: range.flatten(), channel: channel.flatten() })
}

pub fn buffer(name: String, node: &Node<'_, '_>, table: &Table<'_, '_>) -> Buffer {
    let before = table.reporter().count();
    table.conflict("clear", "init", "`clear` fills the buffer each frame, `init` once");
    let mut buffer = Buffer {
        name: Spanned::new(name, node.key_span.clone()),
        remove: removes(table, &["remove"]),
        flawed: false,
        size: table.get("size").and_then(|node| at(&node, buffer_size(&node))),
        source: text(table, "source"),
        values: table.get("values").and_then(|node| values(&node)),
        ty: text(table, "type"),
        copy: text(table, "copy"),
        clear: table.get("clear").and_then(|node| literal(&node)),
        init: table.get("init").and_then(|node| literal(&node)),
        history: history(table),
        keep: table.get("keep").and_then(|node| at(&node, node.boolean())),
        clock: text(table, "clock"),
        warnings: table.get("warnings").and_then(|node| warnings(&node)),
    };
    table.conflict("source", "copy", "a copy of a source is the graph's own");
    for (origin, why) in
        [("source", "the contents of a source come from outside"), ("copy", "a copy is as its source is")]
    {
        for key in ["size", "clear", "init", "history", "keep", "clock", "warnings"] {
            table.conflict(origin, key, why);
        }
    }
    for key in ["size", "source", "copy", "clear", "init", "history", "warnings"] {
        table.conflict("values", key, "what is written in the file has its size, and stays as it is");
    }
    table.finish();
    buffer.flawed = table.reporter().count() > before;
    buffer
}

/// Words of a buffer that are warned of; none where one is wrong, so that what is said of the buffer is said once.
fn warnings(node: &Node<'_, '_>) -> Option<Vec<Warning>> {
    let elements = node.array()?;
    if elements.len() > MOST_WARNINGS {
        let count = elements.len();
        return node.bad_value(format!("`{}` has {count} warnings; the most is {MOST_WARNINGS}", node.name));
    }
    let warnings: Vec<Option<Warning>> = elements.iter().map(warning).collect();
    warnings.into_iter().collect()
}

fn warning(node: &Node<'_, '_>) -> Option<Warning> {
    let table = node.table()?;
    let before = table.reporter().count();
    let offset = match table.get("offset") {
        Some(node) => node.integer(0..=LARGEST_BUFFER).and_then(|offset| {
            let whole = offset.is_multiple_of(4);
            let wrong = || format!("`{}` is {offset}; a count is a whole `uint`, at a multiple of 4 bytes", node.name);
            if whole { Some(offset) } else { node.bad_value(wrong()) }
        }),
        None => Some(0),
    };
    let says = table.need("says").and_then(|node| match node.string()? {
        text if text.trim().is_empty() => node.bad_value(format!("`{}` is empty", node.name)),
        text => Some(Spanned::new(text, node.span.clone())),
    });
    let help = text(&table, "help").map(|help| help.value);
    table.finish();
    let sound = table.reporter().count() == before;
    Some(Warning { offset: offset?, says: says?, help }).filter(|_| sound)
}

/// An array with something in it.
fn values(node: &Node<'_, '_>) -> Option<Literal> {
    if !node.is_array() {
        return node.wrong_type("an array of numbers, or of arrays of them");
    }
    if node.array()?.is_empty() {
        return node.bad_value(format!("`{}` is empty", node.name));
    }
    literal(node)
}

fn buffer_size(node: &Node<'_, '_>) -> Option<BufferSize> {
    if node.is_integer() {
        let bytes = node.integer(4..=LARGEST_BUFFER)?;
        if !bytes.is_multiple_of(4) {
            return node.bad_value(format!("`{}` is {bytes} bytes; it must be a multiple of 4", node.name));
        }
        return Some(BufferSize::Bytes(bytes));
    }
    if !node.is_table() {
        return node.wrong_type("a number of bytes, `{ count, stride }` or `{ of, per, stride }`");
    }
    let table = node.table()?;
    let stride = table.need("stride").and_then(|node| {
        let stride = node.integer(4..=LARGEST_STRIDE)?;
        if stride.is_multiple_of(4) {
            return Some(stride);
        }
        node.bad_value(format!("`{}` is {stride} bytes; it must be a multiple of 4", node.name))
    });
    let of = text(&table, "of");
    let count = table.get("count").map(|node| node.integer(1..=LARGEST_BUFFER));
    let both = table.conflict("of", "count", "texels and elements of something else are counted already");
    let (per, scale) = (table.get("per"), table.get("scale"));
    table.finish();
    if let (Some(alone), None) = (per.as_ref().or(scale.as_ref()), &of) {
        return alone.bad_value(format!("`{}` needs `of`", alone.name));
    }
    let per = per.map_or(Some(1), |node| node.integer(1..=MOST_PER));
    let scale = scale.map(|node| at(&node, node.number(SCALES)));
    match (of, count) {
        (None, None) => node.bad_value(format!("`{}` needs `count` or `of`", node.name)),
        (Some(of), _) if !both => {
            // A scale that is there and wrong is reported already.
            let scale = if let Some(scale) = scale { Some(scale?) } else { None };
            Some(BufferSize::Of { of, scale, per: per?, stride: stride? })
        }
        (_, Some(count)) if !both => {
            let (count, stride) = (count?, stride?);
            if count.saturating_mul(u64::from(stride)) > LARGEST_BUFFER {
                return node.bad_value(format!("`{}` is {count} × {stride} bytes; the most is 64 GiB", node.name));
            }
            Some(BufferSize::Elements { count, stride })
        }
        _ => None,
    }
}
