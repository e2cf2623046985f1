//! Makes the files in `textures/`. Their bytes are the same on every machine.
//!
//! ```text
//! cargo run --release --example textures
//! ```

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "textures have at most 256 texels a side and 256 grades of grey, and hashes keep their low bits"
)]

mod blue_noise;
mod tiles;

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

fn main() -> Result<(), Box<dyn Error>> {
    let noise = blue_noise::blue_noise(blue_noise::EXTENT, blue_noise::SEED);
    let [width, height, slices] = blue_noise::EXTENT.map(|side| side as u32);
    write("textures/blue_noise.png", &noise, [width, height * slices], ExtendedColorType::L8)?;
    let side = tiles::SIDE as u32;
    write("textures/tiles.png", &tiles::tiles(), [side, side], ExtendedColorType::Rgb8)
}

fn write(path: &str, bytes: &[u8], [width, height]: [u32; 2], color: ExtendedColorType) -> Result<(), Box<dyn Error>> {
    let file = BufWriter::new(File::create(path)?);
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(bytes, width, height, color)?;
    println!("{path}: {width}x{height}");
    Ok(())
}
