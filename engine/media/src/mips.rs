//! Mips by the box filter: a texel of a mip is the mean of the part of the mip above that it covers. Where a side is odd, texels are
//! counted with the share of them that is covered, so that nothing moves and nothing is counted twice.

use super::texels::Channel;

/// A mip as numbers: channels next to each other, x first, then y, then z.
struct Level {
    extent: [usize; 3],
    values: Vec<f32>,
}

/// Appends the mips below `mips[0]` until there are `count` of them. The numbers are averaged as they are stored: colours should be in
/// linear light.
#[expect(clippy::cast_possible_truncation, reason = "texels are 32-bit floats")]
pub(crate) fn append(mips: &mut Vec<Vec<u8>>, extent: [u32; 3], channel: Channel, channels: usize, count: u32) {
    let mut extent = extent.map(|side| side as usize);
    let mut above: Option<Level> = None;
    for _ in 1..count {
        let next = extent.map(|side| (side / 2).max(1));
        let level = match &above {
            None => smaller(extent, next, channels, |index| channel.get(&mips[0], index) as f32),
            Some(level) => smaller(level.extent, next, channels, |index| level.values[index]),
        };
        let mut bytes = Vec::with_capacity(level.values.len() * channel.bytes());
        level.values.iter().for_each(|value| channel.put(f64::from(*value), &mut bytes));
        mips.push(bytes);
        extent = next;
        above = Some(level);
    }
}

#[expect(clippy::cast_possible_truncation, reason = "texels are 32-bit floats")]
fn smaller(from: [usize; 3], to: [usize; 3], channels: usize, value: impl Fn(usize) -> f32) -> Level {
    let cover = [0, 1, 2].map(|axis| (0..to[axis]).map(|at| covered(from[axis], to[axis], at)).collect::<Vec<_>>());
    let mut values = Vec::with_capacity(to.iter().product::<usize>() * channels);
    for z in &cover[2] {
        for y in &cover[1] {
            for x in &cover[0] {
                for channel in 0..channels {
                    let mut sum = 0.0_f64;
                    for (sz, wz) in z {
                        for (sy, wy) in y {
                            for (sx, wx) in x {
                                let index = ((sz * from[1] + sy) * from[0] + sx) * channels + channel;
                                sum += wx * wy * wz * f64::from(value(index));
                            }
                        }
                    }
                    values.push(sum as f32);
                }
            }
        }
    }
    Level { extent: to, values }
}

/// Texels of a row of `from` that texel `at` of a row of `to` covers, with their shares, which add up to 1.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the texels are inside the picture")]
fn covered(from: usize, to: usize, at: usize) -> Vec<(usize, f64)> {
    let (first, last) = ((at * from) as f64 / to as f64, ((at + 1) * from) as f64 / to as f64);
    let width = last - first;
    let texels = first.floor() as usize..(last.ceil() as usize).min(from);
    texels.map(|texel| (texel, (last.min(texel as f64 + 1.0) - first.max(texel as f64)) / width)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mip_has_the_means_of_the_one_above() {
        let mut mips = vec![vec![0, 100, 200, 104, 40, 60, 0, 0]];
        append(&mut mips, [4, 2, 1], Channel::Unorm8, 1, 3);
        assert_eq!(mips[1..], [vec![50, 76], vec![63]]);
        // Channels are kept apart, and so are slices until both sides have ended.
        let mut mips = vec![vec![10, 200, 30, 100, 50, 0, 70, 0]];
        append(&mut mips, [1, 2, 2], Channel::Unorm8, 2, 2);
        assert_eq!(mips[1..], [vec![40, 75]]);
    }

    #[test]
    fn odd_sides_lose_nothing_and_move_nothing() {
        // Three texels under one, five under two: 1 + 1 + half of the central one, each.
        let mut mips = vec![vec![30, 60, 90]];
        append(&mut mips, [3, 1, 1], Channel::Unorm8, 1, 2);
        assert_eq!(mips[1], [60]);
        let mut mips = vec![vec![100, 100, 50, 0, 0]];
        append(&mut mips, [5, 1, 1], Channel::Unorm8, 1, 2);
        assert_eq!(mips[1], [90, 10]);
    }
}
