//! Errors of a device.

use std::ffi::OsString;

use ash::vk;

/// Result of everything in this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An error of the loader, the driver or the device.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The Vulkan loader library is not installed.
    #[error("no Vulkan loader: {reason}\n{}", INSTALL)]
    NoLoader {
        /// The message of the system.
        reason: String,
    },
    /// The loader found no driver, or every driver lacks something raxel needs.
    #[error("no suitable Vulkan device{}\n{}", list(.candidates), remedy(.candidates))]
    NoDriver {
        /// One line for each device that was looked at, with the reason against it.
        candidates: Vec<String>,
    },
    /// The device that was asked for by name or index is not there or not suitable.
    #[error(
        "no suitable Vulkan device `{wanted}`{}\n\
         help: `--device` and `RAXEL_DEVICE` take a part of a name in this list, or its number",
        list(.candidates)
    )]
    NoSuchDevice {
        /// The request.
        wanted: String,
        /// One line for each device there is.
        candidates: Vec<String>,
    },
    /// Validation was asked for and `VK_LAYER_KHRONOS_validation` is not installed.
    #[error(
        "the Vulkan validation layer is not installed\n\
         help: on Debian or Ubuntu: sudo apt-get install vulkan-validationlayers"
    )]
    NoValidationLayer,
    /// The device is gone: a hang, a crash of the driver, or unplugged.
    #[error("the device was lost")]
    DeviceLost,
    /// The device did not finish in time.
    #[error("the device did not finish within {seconds} s")]
    TimedOut {
        /// How long was waited.
        seconds: f64,
    },
    /// A command buffer was to be recorded while the device still runs it.
    #[error("the command buffer `{name}` is still running")]
    InFlight {
        /// Name of the command buffer.
        name: String,
    },
    /// The host was to write a buffer that submitted work still uses.
    #[error("the device still uses the buffer `{name}`")]
    InUse {
        /// Name of the buffer.
        name: String,
    },
    /// The host was to write bytes that a buffer does not have, or a buffer that the host cannot write.
    #[error("the host cannot write {bytes} bytes at offset {offset} of `{name}`, which has {size} bytes")]
    NotWritable {
        /// Name of the buffer.
        name: String,
        /// Where the bytes were to go.
        offset: u64,
        /// Number of bytes.
        bytes: u64,
        /// Bytes of the buffer.
        size: u64,
    },
    /// Too many tickets for bytes are held.
    #[error("{most} read-backs are in flight: take or drop one first")]
    ReadbacksInFlight {
        /// How many there may be.
        most: usize,
    },
    /// The window system took the surface away, and a new one cannot be made for the window.
    #[error("the surface of the window was lost")]
    SurfaceLost,
    /// No memory left for this.
    #[error("out of memory for `{name}` ({size} bytes)")]
    OutOfMemory {
        /// The object that it was for.
        name: String,
        /// Bytes asked for.
        size: u64,
    },
    /// A buffer larger than the device can bind.
    #[error("`{name}` has {size} bytes, more than the {limit} that the device can bind")]
    TooLarge {
        /// Name of the buffer.
        name: String,
        /// Bytes.
        size: u64,
        /// `maxStorageBufferRange`.
        limit: u64,
    },
    /// The device cannot use this format in this way.
    #[error("the device cannot use {format:?} as {usage} (image `{name}`)")]
    FormatUnsupported {
        /// Name of the image.
        name: String,
        /// Format.
        format: vk::Format,
        /// The intended usage.
        usage: String,
    },
    /// A shader needs a feature that the device does not have.
    #[error("the device lacks `{lacks}`, which `{name}` needs")]
    CapabilityMissing {
        /// Name of the pipeline.
        name: String,
        /// The SPIR-V capability.
        lacks: String,
    },
    /// A pipeline with more resources of one type than the device can bind.
    #[error("`{name}` binds {count} {what}, but the device allows {limit} (`{limit_name}`)")]
    TooManyBindings {
        /// Name of the pipeline.
        name: String,
        /// Resources that are bound.
        count: u64,
        /// Their kind.
        what: &'static str,
        /// How many the device can bind.
        limit: u32,
        /// Vulkan's name of the limit.
        limit_name: &'static str,
    },
    /// The window system offers no format raxel can show a picture in.
    #[error("the surface offers none of the 8-bit RGBA or BGRA formats; it offers {offered:?}")]
    SurfaceFormat {
        /// The offered formats.
        offered: Vec<vk::Format>,
    },
    /// The device cannot present to this window.
    #[error("{device} cannot present to this window: {reason}")]
    CannotPresent {
        /// Name of the device.
        device: String,
        /// Why.
        reason: String,
    },
    /// The driver fails to make an object that the device claims to support.
    #[error("the driver does not make `{name}`: {call}: {result}")]
    NotMade {
        /// Name of the object.
        name: String,
        /// Name of the call.
        call: &'static str,
        /// The returned code.
        result: vk::Result,
    },
    /// Any other error of a Vulkan call.
    #[error("{call}: {result}")]
    Vulkan {
        /// Name of the call.
        call: &'static str,
        /// The returned code.
        result: vk::Result,
    },
}

const INSTALL: &str = if cfg!(target_os = "macos") {
    "help: brew install vulkan-loader molten-vk"
} else if cfg!(windows) {
    "help: the driver of the graphics card brings Vulkan along; install its newest release"
} else {
    "help: on Debian or Ubuntu: sudo apt-get install libvulkan1 mesa-vulkan-drivers"
};

/// Advice for machines whose devices do not suffice.
const RENEW: &str = if cfg!(target_os = "macos") {
    "help: a newer MoltenVK may do: brew upgrade molten-vk"
} else if cfg!(windows) {
    "help: a newer driver of the graphics card may do"
} else {
    "help: a newer driver may do; without one, the software driver does: on Debian or Ubuntu, sudo apt-get install mesa-vulkan-drivers"
};

/// Variables that say which drivers the loader finds. An empty one counts.
const CHOICES: [&str; 4] =
    ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"];

/// What may help where there is no suitable device.
fn remedy(candidates: &[String]) -> String {
    if candidates.is_empty() { drivers(std::env::var_os) } else { RENEW.to_owned() }
}

/// What may help where the loader has found no driver.
fn drivers(variable: impl Fn(&'static str) -> Option<OsString>) -> String {
    let set = CHOICES.into_iter().find_map(|name| Some((name, variable(name)?)));
    set.map_or_else(
        || INSTALL.to_owned(),
        |(name, value)| {
            let value = value.to_string_lossy();
            let value = value.escape_debug();
            format!("help: `{name}={value}` says which drivers the loader finds: correct it, or unset it\n{INSTALL}")
        },
    )
}

fn list(candidates: &[String]) -> String {
    if candidates.is_empty() {
        return ": the Vulkan loader found no driver".to_owned();
    }
    candidates.iter().fold(":".to_owned(), |text, line| text + "\n  " + line)
}

/// Turns a failed call into an [`Error`] that names the call.
pub(crate) trait Named<T> {
    fn named(self, call: &'static str) -> Result<T>;

    /// For a call that makes an object: names that, too.
    fn making(self, name: &str, call: &'static str) -> Result<T>;
}

impl<T> Named<T> for std::result::Result<T, vk::Result> {
    fn named(self, call: &'static str) -> Result<T> {
        self.map_err(|result| match result {
            vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost,
            vk::Result::ERROR_SURFACE_LOST_KHR => Error::SurfaceLost,
            result => Error::Vulkan { call, result },
        })
    }

    fn making(self, name: &str, call: &'static str) -> Result<T> {
        self.named(call).map_err(|error| match error {
            Error::Vulkan { call, result } => Error::NotMade { name: name.to_owned(), call, result },
            error => error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variable_that_hides_every_driver_is_named_and_without_one_a_driver_is_to_be_installed() {
        let with = |set: &[(&str, &str)]| {
            drivers(|name| set.iter().find(|(known, _)| *known == name).map(|(_, value)| OsString::from(value)))
        };
        assert_eq!(with(&[]), INSTALL);
        let both = with(&[("VK_ICD_FILENAMES", "/a.json"), ("VK_DRIVER_FILES", "")]);
        let said = "help: `VK_DRIVER_FILES=` says which drivers the loader finds: correct it, or unset it\n";
        assert_eq!(both, [said, INSTALL].concat());
        assert!(with(&[("VK_LOADER_DRIVERS_DISABLE", "*")]).contains("`VK_LOADER_DRIVERS_DISABLE=*`"));
    }
}
