//! `[stream]`: how much of a world is there at a time.

use raxel_diagnostics::Span;
use raxel_diagnostics::table::{Node, Table};

use super::extent;

/// What `[stream]` says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamSettings {
    /// Voxels around the camera that are there one by one.
    pub near: u32,
    /// Voxels around the camera that are there at all, beyond `near` in cells of 4, 16 and 64 voxels; `near` if left out.
    pub far: u32,
    /// Smallest and one past the largest height that is loaded; that of everything built if left out.
    pub height: Option<[i64; 2]>,
    /// Bytes of the buffer on the device.
    pub gpu_memory: u64,
    /// Bytes of packed chunks that are kept on the host, so that going back makes nothing again; 0 keeps none.
    pub cpu_memory: u64,
    /// Bytes of the list of lamps on the device, in a world where something gives off light.
    pub lamp_memory: u64,
    /// Bytes that a frame of a window brings to the device, about.
    pub upload: u64,
    /// Threads that make chunks; 0 is one for each core but one.
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
    pub const NEAR: u32 = 512;
    /// `near` at most: 64 chunks.
    pub const MOST_NEAR: u32 = 4096;
    /// `far` at most, and 64 times `near`: levels go no higher.
    pub const MOST_FAR: u32 = 1 << 18;
    /// Bytes, if the file does not say.
    pub const GPU_MEMORY: u64 = 256 << 20;
    /// What the addresses in the buffer can reach.
    pub const MOST_GPU_MEMORY: u64 = 2 << 30;
    /// Smallest buffer.
    pub const LEAST_MEMORY: u64 = 1 << 20;
    /// Bytes of packed chunks, if the file does not say.
    pub const CPU_MEMORY: u64 = 256 << 20;
    /// Bytes of packed chunks at most.
    pub const MOST_CPU_MEMORY: u64 = 1 << 40;
    /// Bytes of the list of lamps, if the file does not say.
    pub const LAMP_MEMORY: u64 = 16 << 20;
    /// Smallest list of lamps.
    pub const LEAST_LAMP_MEMORY: u64 = 1 << 12;
    /// Bytes that a frame brings to the device, if the file does not say.
    pub const UPLOAD: u64 = 4 << 20;
    /// Least that a frame may bring.
    pub const LEAST_UPLOAD: u64 = 1 << 16;
    /// Most threads.
    pub const MOST_THREADS: u32 = 256;
}

/// What `[stream]` says, with where the tiles come from.
pub(super) struct Stream {
    pub(super) settings: StreamSettings,
    /// The address of the store, if they are not built, and where the file names it.
    pub(super) source: Option<(String, Span)>,
}

/// What a source begins with: tiles come from arrays of Zarr, and from nowhere else.
const ZARR: &str = "zarr:";

pub(super) fn read(table: &Table<'_, '_>) -> Option<Stream> {
    let source = match table.get("source") {
        None => Some(None),
        Some(node) => node.string().and_then(|text| match text.strip_prefix(ZARR) {
            Some(address) if !address.is_empty() => Some(Some((address.to_owned(), node.span.clone()))),
            _ => node
                .bad_value(format!("`{text}` is not a source: write \"zarr:FOLDER\" or \"zarr:s3://BUCKET/FOLDER\"")),
        }),
    };
    let default = StreamSettings::default();
    let near = table.get("near").map_or(Some(default.near), |node| node.integer(64..=StreamSettings::MOST_NEAR));
    let far = match table.get("far") {
        None => near,
        Some(node) => {
            let far = node.integer(64..=StreamSettings::MOST_FAR);
            match far.zip(near) {
                Some((far, near)) if far < near => {
                    node.bad_value(format!("`{}` is {far}, and `near` is {near}: it must not be smaller", node.name))
                }
                Some((far, near)) if far > 64 * near => node.bad_value(format!(
                    "`{}` is {far}, more than 64 times `near`, which is {near}: cells are at most 64 voxels large",
                    node.name
                )),
                _ => far,
            }
        }
    };
    let height = match table.get("height") {
        None => Some(None),
        Some(node) => match node.integers::<_, 2>(extent::CELLS) {
            Some([low, high]) if low >= high => {
                node.bad_value(format!("`{}` is empty: from {low} to {high}", node.name))
            }
            height => height.map(Some),
        },
    };
    let gpu_memory = table.get("gpu_memory").map_or(Some(default.gpu_memory), |node| {
        bytes(&node, StreamSettings::LEAST_MEMORY, StreamSettings::MOST_GPU_MEMORY)
    });
    let cpu_memory = table
        .get("cpu_memory")
        .map_or(Some(default.cpu_memory), |node| bytes(&node, 0, StreamSettings::MOST_CPU_MEMORY));
    let lamp_memory = table.get("lamp_memory").map_or(Some(default.lamp_memory), |node| {
        bytes(&node, StreamSettings::LEAST_LAMP_MEMORY, StreamSettings::MOST_GPU_MEMORY)
    });
    let upload = match table.get("upload") {
        None => Some(default.upload),
        Some(node) => {
            let upload = bytes(&node, StreamSettings::LEAST_UPLOAD, StreamSettings::MOST_GPU_MEMORY);
            match upload.zip(gpu_memory) {
                Some((upload, memory)) if upload > memory => node.bad_value(format!(
                    "`{}` is {upload} bytes, and `gpu_memory` is {memory}: a frame cannot bring more than there is room for",
                    node.name
                )),
                _ => upload,
            }
        }
    };
    let threads = table.get("threads").map_or(Some(0), |node| node.integer(0..=StreamSettings::MOST_THREADS));
    table.finish();
    let settings = StreamSettings {
        near: near?,
        far: far?,
        height: height?,
        gpu_memory: gpu_memory?,
        cpu_memory: cpu_memory?,
        lamp_memory: lamp_memory?,
        upload: upload?,
        threads: threads?,
    };
    Some(Stream { settings, source: source? })
}

/// A number of bytes: an integer, or a number with a unit, `"512 MiB"`.
fn bytes(node: &Node<'_, '_>, least: u64, most: u64) -> Option<u64> {
    let found = if node.is_string() {
        let text = node.string()?;
        match parse(&text) {
            Some(bytes) => bytes,
            None => {
                return node.bad_value(format!("`{text}` is not an amount of memory: write \"512 MiB\" or \"1 GiB\""));
            }
        }
    } else {
        node.integer(0..=i64::MAX.cast_unsigned())?
    };
    if (least..=most).contains(&found) {
        return Some(found);
    }
    node.bad_value(format!("`{}` is {}; it must be {} to {}", node.name, amount(found), amount(least), amount(most)))
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
