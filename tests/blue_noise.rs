//! The shipped blue noise: made by our own tool, without low frequencies in space and in time, every value equally often.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

#[path = "../examples/textures/blue_noise.rs"]
mod blue_noise;

use std::f64::consts::TAU;

/// Mean power of the frequencies (x, y) that `wanted` selects, in cycles a pixel from −½ to ½, over all pictures; 0 is the mean's own
/// and not counted.
fn power_in_space(noise: &[u8], [width, height, _]: [usize; 3], wanted: impl Fn(f64) -> bool) -> f64 {
    let mut powers = Vec::new();
    for picture in noise.chunks_exact(width * height) {
        let rows: Vec<Vec<[f64; 2]>> =
            picture.chunks_exact(width).map(|row| transform(row.iter().map(|value| [centred(*value), 0.0]))).collect();
        for x in 0..width {
            let column = transform(rows.iter().map(|row| row[x]));
            for (y, [re, im]) in column.into_iter().enumerate() {
                let frequency = signed(x, width).hypot(signed(y, height));
                if frequency > 0.0 && wanted(frequency) {
                    powers.push(re * re + im * im);
                }
            }
        }
    }
    mean(&powers)
}

/// The same over time, at every pixel.
fn power_in_time(noise: &[u8], [width, height, pictures]: [usize; 3], wanted: impl Fn(f64) -> bool) -> f64 {
    let mut powers = Vec::new();
    for pixel in 0..width * height {
        let values = (0..pictures).map(|picture| [centred(noise[picture * width * height + pixel]), 0.0]);
        for (index, [re, im]) in transform(values).into_iter().enumerate() {
            let frequency = signed(index, pictures).abs();
            if frequency > 0.0 && wanted(frequency) {
                powers.push(re * re + im * im);
            }
        }
    }
    mean(&powers)
}

fn transform(values: impl ExactSizeIterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let values: Vec<[f64; 2]> = values.collect();
    let count = values.len();
    let turns: Vec<(f64, f64)> = (0..count).map(|i| (-TAU * i as f64 / count as f64).sin_cos()).collect();
    (0..count)
        .map(|frequency| {
            values.iter().enumerate().fold([0.0; 2], |[re, im], (at, [a, b])| {
                let (sin, cos) = turns[frequency * at % count];
                [re + a * cos - b * sin, im + a * sin + b * cos]
            })
        })
        .collect()
}

fn centred(value: u8) -> f64 {
    f64::from(value) - 127.5
}

fn signed(index: usize, count: usize) -> f64 {
    let index = if index > count / 2 { index as f64 - count as f64 } else { index as f64 };
    index / count as f64
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The properties of blue noise; white noise has about the same power everywhere.
fn assert_blue(noise: &[u8], extent: [usize; 3], low: f64) {
    let [width, height, pictures] = extent;
    assert_eq!(noise.len(), width * height * pictures);
    let (space, all) = (power_in_space(noise, extent, |f| f < 0.15), power_in_space(noise, extent, |_| true));
    assert!(space < low * all, "in space: {space} of {all}");
    let (time, all) = (power_in_time(noise, extent, |f| f < 0.13), power_in_time(noise, extent, |_| true));
    assert!(time < 0.2 * all, "in time: {time} of {all}");
    let mut counts = [0_usize; 256];
    for value in noise {
        counts[usize::from(*value)] += 1;
    }
    let each = noise.len() / 256;
    assert!(counts.iter().all(|count| count.abs_diff(each) <= 1), "{counts:?}");
    for picture in noise.chunks_exact(width * height) {
        let mean = picture.iter().map(|value| f64::from(*value)).sum::<f64>() / picture.len() as f64;
        assert!((mean - 127.5).abs() < 4.0, "{mean}");
    }
}

#[test]
fn the_shipped_file_is_blue_in_space_and_in_time() {
    let [width, height, pictures] = blue_noise::EXTENT;
    let file = image::open("textures/blue_noise.png").expect("it is shipped").into_luma8();
    assert_eq!(file.dimensions(), (width as u32, (height * pictures) as u32));
    assert_blue(file.as_raw(), blue_noise::EXTENT, 0.02);
    let bytes = std::fs::metadata("textures/blue_noise.png").expect("it is there").len();
    assert!(bytes < 512 << 10, "{bytes}");
}

#[test]
fn the_tool_makes_it_again() {
    let extent = [32, 32, 8];
    let noise = blue_noise::blue_noise(extent, blue_noise::SEED);
    assert_eq!(noise, blue_noise::blue_noise(extent, blue_noise::SEED));
    assert_ne!(noise, blue_noise::blue_noise(extent, blue_noise::SEED + 1));
    assert_blue(&noise, extent, 0.02);
}
