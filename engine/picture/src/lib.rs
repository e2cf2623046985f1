//! Pictures in files, how far two of them are apart (FLIP, root mean square, largest difference), and the statistics of their values.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod compare;
mod encode;
mod read;
mod search;
mod statistics;

pub use compare::{CompareError, Comparison, compare};
pub use encode::{EncodeError, hdr, jpeg};
pub use read::{ReadError, can_hold, decode, read};
pub use search::{Place, Search, Sought};
pub use statistics::{BINS, NotFinite, Statistics, not_finite};

/// Three numbers a pixel, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// `width × height` pixels: red, green, blue. One channel of a file is grey; alpha is left out.
    pub pixels: Vec<[f32; 3]>,
    /// The meaning of the numbers.
    pub encoding: Encoding,
}

/// The meaning of the numbers of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// sRGB-encoded, 0 to 1: a PNG or JPEG.
    Display,
    /// Any numbers, shown as linear light: an EXR or HDR.
    Linear,
}
