//! Statistics of a channel's values: their range, their distribution, and how many are no numbers.

/// Bars of a histogram.
pub const BINS: usize = 64;

/// Counts and range of many values.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// All values.
    pub count: u64,
    /// Of these, NaN.
    pub nan: u64,
    /// Of these, plus or minus infinity.
    pub infinite: u64,
    /// Smallest and largest finite value.
    pub range: [f32; 2],
    /// The values that one of a hundred lies below, and above, finite ones only.
    pub percentiles: [f32; 2],
    /// Mean of the finite values.
    pub mean: f64,
    /// Finite values within the percentiles, by size; the ends count what lies outside.
    pub histogram: [u32; BINS],
}

impl Statistics {
    /// Of values in any order. `None` when there are none.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the place is in 0…1 or outside the percentiles, and the cast saturates"
    )]
    pub fn of(values: impl Iterator<Item = f32>) -> Option<Statistics> {
        let (mut count, mut nan, mut infinite, mut sum) = (0, 0, 0, 0.0);
        let mut finite: Vec<f32> = Vec::with_capacity(values.size_hint().0);
        for value in values {
            count += 1;
            nan += u64::from(value.is_nan());
            infinite += u64::from(value.is_infinite());
            if value.is_finite() {
                sum += f64::from(value);
                finite.push(value);
            }
        }
        if count == 0 {
            return None;
        }
        let mean = if finite.is_empty() { 0.0 } else { sum / finite.len() as f64 };
        let range = finite
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &value| [low.min(value), high.max(value)]);
        let range = if finite.is_empty() { [0.0, 0.0] } else { range };
        let percentiles = percentiles(&mut finite).unwrap_or(range);
        let mut histogram = [0; BINS];
        let [low, high] = percentiles;
        for value in &finite {
            let place = if high > low { (value - low) / (high - low) } else { 0.5 };
            histogram[((place * BINS as f32) as usize).min(BINS - 1)] += 1;
        }
        Some(Statistics { count, nan, infinite, range, percentiles, mean, histogram })
    }
}

/// Values of a channel that are no finite numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NotFinite {
    /// How many are NaN.
    pub nan: u64,
    /// How many are infinite.
    pub infinite: u64,
}

/// Counts the values of each of the first `channels` channels that are not finite.
pub fn not_finite(texels: &[[f32; 4]], channels: usize) -> Vec<NotFinite> {
    let mut found = vec![NotFinite::default(); channels];
    for texel in texels {
        for (count, value) in found.iter_mut().zip(texel) {
            count.nan += u64::from(value.is_nan());
            count.infinite += u64::from(value.is_infinite());
        }
    }
    found
}

/// The values that one of a hundred lies below and above.
fn percentiles(finite: &mut [f32]) -> Option<[f32; 2]> {
    let last = finite.len().checked_sub(1)?;
    let low = *finite.select_nth_unstable_by(last / 100, f32::total_cmp).1;
    let high = *finite.select_nth_unstable_by(last - last / 100, f32::total_cmp).1;
    Some([low, high])
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_counted_apart() {
        let values = [1.0, f32::NAN, 3.0, f32::INFINITY, f32::NEG_INFINITY, 2.0];
        let found = Statistics::of(values.into_iter()).unwrap();
        assert_eq!((found.count, found.nan, found.infinite), (6, 1, 2));
        assert_eq!((found.range, found.mean), ([1.0, 3.0], 2.0));
        assert_eq!(found.histogram.iter().sum::<u32>(), 3);
        assert_eq!(Statistics::of([f32::NAN].into_iter()).unwrap().range, [0.0, 0.0]);
        assert_eq!(Statistics::of([].into_iter()), None);
    }

    #[test]
    fn percentiles_leave_outliers_out() {
        let mut values: Vec<f32> = (0..1000).map(|n| n as f32 / 1000.0).collect();
        values.push(1e9);
        let found = Statistics::of(values.into_iter()).unwrap();
        assert_eq!(found.range, [0.0, 1e9]);
        assert!(found.percentiles[1] < 1.0 && found.percentiles[0] < 0.02, "{:?}", found.percentiles);
        // A thousandth lies above the percentile and counts at the end.
        assert!(found.histogram.iter().all(|&bar| bar > 0));
    }

    #[test]
    fn equal_values_fill_one_bar() {
        let found = Statistics::of(std::iter::repeat_n(5.0, 10)).unwrap();
        assert_eq!((found.percentiles, found.histogram[BINS / 2]), ([5.0, 5.0], 10));
    }
}
