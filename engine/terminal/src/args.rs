//! Arguments that several verbs have.

use raxel_gpu::{DeviceOptions, Validation};
use raxel_runtime::present::Viewport;

use crate::console::Format;

/// The form of messages and of a verb's output.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Messages {
    /// The form of messages and results.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    pub format: Format,
}

/// The device of a verb that opens one.
#[derive(Clone, Debug, clap::Args)]
pub struct OnDevice {
    /// The Vulkan device: a part of its name, or its number in `raxel doctor`.
    #[arg(long, global = true, value_name = "DEVICE")]
    device: Option<String>,

    /// Run with the Vulkan validation layer, synchronization checks included; any message makes the exit code 6.
    #[arg(long, global = true)]
    validate: bool,
}

impl OnDevice {
    /// The options that open a device.
    pub fn options(&self) -> DeviceOptions {
        let validation = if self.validate { Validation::Required } else { Validation::Off };
        DeviceOptions { device: self.device.clone(), validation }
    }
}

/// An extent in pixels, both sides at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

/// Reads a scale of the output, such as `0.5`.
pub fn scale(text: &str) -> Result<f64, String> {
    let scales = Viewport::SCALES;
    text.parse()
        .ok()
        .filter(|scale| scales.contains(scale))
        .ok_or_else(|| format!("write a number from {} to {}, e.g. 0.5", scales.start(), scales.end()))
}

/// Reads `640x360`.
pub fn size(text: &str) -> Result<Size, String> {
    const LARGEST: u32 = 16384;
    let side = |side: &str| side.parse().ok().filter(|n| (1..=LARGEST).contains(n));
    text.split_once(['x', 'X', '×'])
        .and_then(|(width, height)| Some(Size([side(width)?, side(height)?])))
        .ok_or_else(|| format!("write WIDTHxHEIGHT with sides of 1 to {LARGEST} pixels, e.g. 640x360"))
}

/// A thing that is named twice is meant once. The first place counts.
pub fn each_once<T: PartialEq>(named: Vec<T>) -> Vec<T> {
    let mut once = Vec::with_capacity(named.len());
    for name in named {
        if !once.contains(&name) {
            once.push(name);
        }
    }
    once
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x360"), Ok(Size([640, 360])));
        for wrong in ["", "640", "0x1", "-1x5", "1x2x3", "99999x1", "a x b"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
