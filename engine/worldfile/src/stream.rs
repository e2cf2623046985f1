//! `[stream]`: how much of a world is there at a time.

use std::ops::RangeInclusive;

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Span, Spanned};
use raxel_language::{Describe, Keys, Shape};
use serde_json::json;

use super::extent::CELLS;

/// The contents of `[stream]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
#[keys(check = farther(near, far), check = filled(height), check = fits(gpu_memory, upload))]
pub struct StreamSettings {
    /// Distance from the camera to which single voxels are loaded, in voxels.
    #[keys(range = 64..=Self::MOST_NEAR, default = Self::NEAR)]
    pub near: u32,
    /// Distance from the camera to which anything is loaded, in voxels: beyond `near` in cells of 4, 16 and 64. `near` when left out, and
    /// at most 64 times `near`.
    #[keys(range = 64..=Self::MOST_FAR, absent = 0)]
    pub far: u32,
    /// Lowest height that is loaded, and one past the highest, in voxels. Every height when left out.
    #[keys(range = CELLS)]
    pub height: Option<[i64; 2]>,
    /// Bytes of the buffer on the device.
    #[keys(
        read = bytes(Self::BUFFERS),
        shape = memory(Self::BUFFERS),
        absent = Self::GPU_MEMORY,
        told = amount(Self::GPU_MEMORY)
    )]
    pub gpu_memory: u64,
    /// Bytes of packed chunks that stay on the host, so that going back builds nothing again. 0 keeps none.
    #[keys(
        read = bytes(0..=Self::MOST_CPU_MEMORY),
        shape = memory(0..=Self::MOST_CPU_MEMORY),
        absent = Self::CPU_MEMORY,
        told = amount(Self::CPU_MEMORY)
    )]
    pub cpu_memory: u64,
    /// Bytes of the list of lamps (`world.lights`) on the device, if a material gives off light.
    #[keys(
        read = bytes(Self::LAMPS),
        shape = memory(Self::LAMPS),
        absent = Self::LAMP_MEMORY,
        told = amount(Self::LAMP_MEMORY)
    )]
    pub lamp_memory: u64,
    /// About how many bytes a frame of a window uploads; at most `gpu_memory`.
    #[keys(read = bytes(Self::UPLOADS), shape = memory(Self::UPLOADS), absent = Self::UPLOAD, told = amount(Self::UPLOAD))]
    pub upload: u64,
    /// Threads that build chunks. 0 is one for each core but one.
    #[keys(range = 0..=Self::MOST_THREADS, default = 0)]
    pub threads: u32,
}

impl Default for StreamSettings {
    fn default() -> Self {
        Self {
            near: Self::NEAR,
            far: Self::NEAR,
            height: None,
            gpu_memory: Self::GPU_MEMORY,
            cpu_memory: Self::CPU_MEMORY,
            lamp_memory: Self::LAMP_MEMORY,
            upload: Self::UPLOAD,
            threads: 0,
        }
    }
}

impl StreamSettings {
    /// Voxels, if the file does not say.
    pub(crate) const NEAR: u32 = 512;
    /// `near` at most: 64 chunks.
    pub(crate) const MOST_NEAR: u32 = 4096;
    /// `far` at most, and 64 times `near`: levels go no higher.
    pub const MOST_FAR: u32 = 1 << 18;
    /// Bytes, if the file does not say.
    pub(crate) const GPU_MEMORY: u64 = 256 << 20;
    /// Bytes that the buffer may have: the limit of its addresses.
    const BUFFERS: RangeInclusive<u64> = 1 << 20..=2 << 30;
    /// Bytes of packed chunks, if the file does not say.
    pub(crate) const CPU_MEMORY: u64 = 256 << 20;
    /// Bytes of packed chunks at most.
    const MOST_CPU_MEMORY: u64 = 1 << 40;
    /// Bytes of the list of lamps, if the file does not say.
    pub(crate) const LAMP_MEMORY: u64 = 16 << 20;
    /// Bytes that the list of lamps may have.
    const LAMPS: RangeInclusive<u64> = 1 << 12..=2 << 30;
    /// Bytes that a frame brings to the device, if the file does not say.
    pub const UPLOAD: u64 = 4 << 20;
    /// Bytes that a frame may bring.
    const UPLOADS: RangeInclusive<u64> = 1 << 16..=2 << 30;
    /// Most threads.
    const MOST_THREADS: u32 = 256;
}

/// Builds the world around the camera while it moves.
#[derive(Keys)]
pub(super) struct Stream {
    #[keys(flatten)]
    settings: StreamSettings,
    /// Store of a baked world: a folder of the project, or a URL. Instead of [[build]]. The world is built when left out.
    ///
    /// Here without the `zarr:` before it.
    #[keys(read = source, shape = Shape::Schema(json!({ "type": "string", "pattern": "^zarr:." })))]
    pub(super) source: Option<Spanned<String>>,
    #[keys(span)]
    pub(super) place: Span,
}

impl Stream {
    pub(super) fn settings(&self) -> StreamSettings {
        let StreamSettings { near, far, .. } = self.settings;
        StreamSettings { far: near.max(far), ..self.settings }
    }
}

fn source(node: &Node<'_, '_>) -> Option<Spanned<String>> {
    let text = node.string()?;
    match text.strip_prefix("zarr:").filter(|address| !address.is_empty()) {
        Some(address) => Some(Spanned::new(address.to_owned(), node.span.clone())),
        None => {
            node.bad_value(format!("`{text}` is not a source: write \"zarr:FOLDER\" or \"zarr:s3://BUCKET/FOLDER\""))
        }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "a check gets a reference to each field")]
fn farther(table: &Table<'_, '_>, near: &u32, far: &u32) -> bool {
    let Some(node) = table.get("far") else { return true };
    let wrong = if far < near {
        format!("`{}` is {far}, and `near` is {near}: it must not be smaller", node.name)
    } else if *far > 64 * near {
        let name = &node.name;
        format!("`{name}` is {far}, more than 64 times `near`, which is {near}: cells are at most 64 voxels large")
    } else {
        return true;
    };
    node.bad_value::<()>(wrong);
    false
}

fn filled(table: &Table<'_, '_>, height: Option<&[i64; 2]>) -> bool {
    let (Some([low, high]), Some(node)) = (height, table.get("height")) else { return true };
    if low >= high {
        node.bad_value::<()>(format!("`{}` is empty: from {low} to {high}", node.name));
    }
    low < high
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "a check gets a reference to each field")]
fn fits(table: &Table<'_, '_>, memory: &u64, upload: &u64) -> bool {
    let Some(node) = table.get("upload").filter(|_| upload > memory) else { return true };
    node.bad_value::<()>(format!(
        "`{}` is {upload} bytes, and `gpu_memory` is {memory}: a frame cannot bring more than there is room for",
        node.name
    ));
    false
}

/// A number of bytes: an integer, or a number with a unit, `"512 MiB"`.
fn bytes(range: RangeInclusive<u64>) -> impl Fn(&Node<'_, '_>) -> Option<u64> {
    move |node| {
        let found = if node.is_string() {
            let text = node.string()?;
            let Some(bytes) = parse(&text) else {
                return node.bad_value(format!("`{text}` is not an amount of memory: write \"512 MiB\" or \"1 GiB\""));
            };
            bytes
        } else {
            node.integer(0..=i64::MAX.cast_unsigned())?
        };
        if range.contains(&found) {
            return Some(found);
        }
        let [found, least, most] = [found, *range.start(), *range.end()].map(amount);
        node.bad_value(format!("`{}` is {found}; it must be {least} to {most}", node.name))
    }
}

fn memory(range: RangeInclusive<u64>) -> Shape {
    let text = Shape::Schema(json!({ "type": "string", "pattern": "^[0-9]+ *[KMGT]iB$" }));
    Shape::Either(vec![text, u64::shape(&range.into())])
}

const UNITS: [(&str, u64); 4] = [("KiB", 1 << 10), ("MiB", 1 << 20), ("GiB", 1 << 30), ("TiB", 1 << 40)];

/// Exactly, in the largest unit that goes into it.
fn amount(bytes: u64) -> String {
    let whole = UNITS.iter().rev().find(|(_, unit)| bytes >= *unit && bytes.is_multiple_of(*unit));
    whole.map_or_else(|| format!("{bytes} bytes"), |(name, unit)| format!("{} {name}", bytes / unit))
}

fn parse(text: &str) -> Option<u64> {
    let (number, unit) = UNITS.iter().find_map(|(name, unit)| Some((text.strip_suffix(name)?.trim_end(), *unit)))?;
    number.parse::<u64>().ok()?.checked_mul(unit)
}

#[cfg(test)]
mod tests {
    use super::{amount, parse};

    #[test]
    fn amounts_of_memory() {
        assert_eq!(parse("512 MiB"), Some(512 << 20));
        for text in ["1 KiB", "512 MiB", "2 GiB", "999 TiB"] {
            assert_eq!(parse(text).map(amount).as_deref(), Some(text));
        }
        assert_eq!([0, 1025].map(amount), ["0 bytes", "1025 bytes"]);
        assert_eq!(parse("1GiB"), Some(1 << 30));
        for wrong in ["", "512", "512 MB", "-1 MiB", "1.5 GiB", "99999999999999999999 KiB", "9999999999999999 TiB"] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
