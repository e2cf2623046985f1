//! Reads `[targets.*]` and `[buffers.*]`.

use raxel_diagnostics::Spanned;
use raxel_diagnostics::table::{Node, Table};
use raxel_graph::checked::DisplayMap;
use raxel_graph::supply::has_shape;
use raxel_language::{ReadKeys, Value};

use super::literal;
use crate::model::{BufferSize, Display, Elements, Literal, RelativeSize, Scale, Size, Warning};

/// Texels on an axis that any device may have at most (`maxImageDimension2D` of today's devices is 16384 or 32768).
pub(crate) const LONGEST_AXIS: u32 = 65_536;
/// Mips that a target may have at most: an axis of [`LONGEST_AXIS`] halved down to one texel.
pub(crate) const MOST_MIPS: u32 = LONGEST_AXIS.ilog2() + 1;
/// Array layers that a target may have at most.
pub(crate) const MOST_LAYERS: u32 = 2048;
/// Earlier frames that a resource may keep at most: each is a full copy.
pub(crate) const LONGEST_HISTORY: u32 = 16;
/// Bytes that a buffer may have at most: 64 GiB.
pub(crate) const LARGEST_BUFFER: u64 = 1 << 36;
/// Bytes that an element of a buffer may have at most.
pub(crate) const LARGEST_STRIDE: u32 = 1 << 20;
/// Elements that a buffer may have at most for each texel or element of something else.
pub(crate) const MOST_PER: u32 = 1 << 16;
/// Warnings that a buffer may give at most: each is a word that is copied in every frame that may have written it.
pub(crate) const MOST_WARNINGS: usize = 16;
/// Scales of a target's size: below, every target is one texel; above, every one is too large.
pub(crate) const SCALES: std::ops::RangeInclusive<f64> = 0.0001..=64.0;

/// Keys that a target cannot have when its contents come from outside.
pub(crate) fn supplied_target(
    table: &Table<'_, '_>,
    source: Option<&Spanned<String>>,
    copy: Option<&Spanned<String>>,
) -> bool {
    let all = ["size", "layers", "history", "clear", "init", "keep", "clock", "format", "mips", "slices", "encoding"];
    let before = table.reporter().count();
    if let Some(source) = source {
        // Such texels may be brought into a shape of the graph.
        for key in &all[..if has_shape(&source.value) { 7 } else { all.len() }] {
            table.conflict("source", key, "the source gives the size and the contents");
        }
    }
    if copy.is_some() {
        for key in all {
            table.conflict("copy", key, "a copy is as its source is");
        }
    }
    table.reporter().count() == before
}

/// Keys that a buffer cannot have when its contents come from outside.
pub(crate) fn supplied_buffer(table: &Table<'_, '_>) -> bool {
    let before = table.reporter().count();
    for (origin, why) in
        [("source", "the contents of a source come from outside"), ("copy", "a copy is as its source is")]
    {
        for key in ["size", "clear", "init", "history", "keep", "clock", "warnings"] {
            table.conflict(origin, key, why);
        }
    }
    table.reporter().count() == before
}

impl<C: ?Sized> Value<C> for Size {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        size(node)
    }
}

impl<C: ?Sized> Value<C> for Scale {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        if node.is_array() { node.numbers(SCALES).map(Scale::Each) } else { node.number(SCALES).map(Scale::All) }
    }
}

impl<C: ?Sized> Value<C> for BufferSize {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        buffer_size(node)
    }
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
    let part = RelativeSize::read_whole(&table, &())?;
    match (part.of, part.scale) {
        (None, None) => node.bad_value(format!("`{}` needs `of`, `scale` or both", node.name)),
        (Some(target), None) => Some(Size::Of { target, scale: 1.0 }),
        (Some(target), Some(Scale::All(scale))) => Some(Size::Of { target, scale }),
        (Some(_), Some(Scale::Each(_))) => table.get("scale")?.wrong_type("a number"),
        (None, Some(Scale::Each(scales))) => Some(Size::Output(scales)),
        (None, Some(Scale::All(scale))) => Some(Size::Output([scale; 2])),
    }
}

pub(crate) fn mips(node: &Node<'_, '_>) -> Option<u32> {
    if node.is_string() {
        return node.word(&[("full", 0)]);
    }
    if !node.is_integer() {
        return node.wrong_type("a number of mips or `\"full\"`");
    }
    node.integer(1..=MOST_MIPS)
}

pub(crate) fn display(node: &Node<'_, '_>) -> Option<Display> {
    if node.is_string() {
        return node.word(DisplayMap::WORDS).map(|map| Display { map: Some(map), range: None, channel: None });
    }
    if !node.is_table() {
        return node.wrong_type("the name of a map, or a table with `map`, `range` and `channel`");
    }
    Display::read_whole(&node.table()?, &())
}

#[expect(clippy::cast_possible_truncation, reason = "the range is checked as the 32-bit floats that shaders get")]
pub(crate) fn shown_range(node: &Node<'_, '_>) -> Option<[f64; 2]> {
    let [low, high] = node.numbers::<2>(f64::from(f32::MIN)..=f64::from(f32::MAX))?;
    if low >= high {
        return node.bad_value(format!("`{}` is empty: {low} is not less than {high}", node.name));
    }
    // Shaders get 32-bit floats, and a range of one value shows one colour.
    if low as f32 >= high as f32 {
        return node.bad_value(format!("`{}` is empty: {low} and {high} are the same 32-bit float", node.name));
    }
    Some([low, high])
}

/// Words of a buffer that are warned of. A mistake in one of them drops all, so that the buffer is reported once.
pub(crate) fn warnings(node: &Node<'_, '_>) -> Option<Vec<Warning>> {
    let elements = node.array()?;
    if elements.len() > MOST_WARNINGS {
        let count = elements.len();
        return node.bad_value(format!("`{}` has {count} warnings; the most is {MOST_WARNINGS}", node.name));
    }
    Vec::read(node, &(), &())
}

/// The place of a `uint`.
pub(crate) fn whole_word(node: &Node<'_, '_>) -> Option<u64> {
    let offset = node.integer(0..=LARGEST_BUFFER)?;
    if offset.is_multiple_of(4) {
        return Some(offset);
    }
    node.bad_value(format!("`{}` is {offset}; a count is a whole `uint`, at a multiple of 4 bytes", node.name))
}

/// Text with something in it.
pub(crate) fn filled(node: &Node<'_, '_>) -> Option<String> {
    match node.string()? {
        text if text.trim().is_empty() => node.bad_value(format!("`{}` is empty", node.name)),
        text => Some(text),
    }
}

/// An array with something in it.
pub(crate) fn values(node: &Node<'_, '_>) -> Option<Literal> {
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
    let elements = Elements::read_whole(&table, &());
    if ["of", "count", "per", "scale"].into_iter().all(|key| table.get(key).is_none()) {
        return node.bad_value(format!("`{}` needs `count` or `of`", node.name));
    }
    let Elements { stride, of, count, per, scale } = elements?;
    match (of, count) {
        (Some(of), None) => Some(BufferSize::Of { of, scale, per: per.unwrap_or(1), stride }),
        (None, Some(count)) if count.saturating_mul(u64::from(stride)) > LARGEST_BUFFER => node.bad_value(format!(
            "`{}` is {count} × {stride} bytes; the most is {} GiB",
            node.name,
            LARGEST_BUFFER >> 30
        )),
        (None, Some(count)) => Some(BufferSize::Elements { count, stride }),
        // Reported already.
        _ => None,
    }
}

/// Bytes of an element.
pub(crate) fn stride(node: &Node<'_, '_>) -> Option<u32> {
    let stride = node.integer(4..=LARGEST_STRIDE)?;
    if stride.is_multiple_of(4) {
        return Some(stride);
    }
    node.bad_value(format!("`{}` is {stride} bytes; it must be a multiple of 4", node.name))
}

/// Keys that mean something only beside `of`.
pub(crate) fn beside_of(
    table: &Table<'_, '_>,
    of: Option<&Spanned<String>>,
    per: Option<&u32>,
    scale: Option<&Spanned<f64>>,
) -> bool {
    if of.is_some() || (per.is_none() && scale.is_none()) {
        return true;
    }
    if let Some(alone) = table.get("per").or_else(|| table.get("scale")) {
        alone.bad_value::<()>(format!("`{}` needs `of`", alone.name));
    }
    false
}
