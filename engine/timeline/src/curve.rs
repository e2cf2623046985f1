//! Curves through keys.

use raxel_language::Keys;

/// How a value gets from one key to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum Interpolation {
    /// It keeps the value of the key before.
    Step,
    /// In a straight line.
    Linear,
    /// Along a Catmull-Rom spline (Catmull and Rom, 1974), with tangents for keys that are not evenly spaced: the slope at a key is
    /// that of the line between its neighbours.
    Smooth,
}

/// Index of the last key at or before `time`; 0 when there is none. `times` is ascending and not empty.
pub(crate) fn segment(times: impl ExactSizeIterator<Item = f64>, time: f64) -> usize {
    times.take_while(|&key| key <= time).count().saturating_sub(1)
}

/// Value at `time` of a curve through `(time, value)` keys, ascending and not empty. Constant before the first and after the last.
pub(crate) fn sample(keys: usize, key: impl Fn(usize) -> (f64, f64), time: f64, interpolation: Interpolation) -> f64 {
    let i = segment((0..keys).map(|i| key(i).0), time);
    let (t0, v0) = key(i);
    if i + 1 == keys || time <= t0 || interpolation == Interpolation::Step {
        return v0;
    }
    let (t1, v1) = key(i + 1);
    let (span, u) = (t1 - t0, (time - t0) / (t1 - t0));
    if interpolation == Interpolation::Linear {
        return v0 + (v1 - v0) * u;
    }
    let slope = |before: (f64, f64), after: (f64, f64)| (after.1 - before.1) / (after.0 - before.0);
    let m0 = slope(if i == 0 { (t0, v0) } else { key(i - 1) }, (t1, v1));
    let m1 = slope((t0, v0), if i + 2 < keys { key(i + 2) } else { (t1, v1) });
    // Cubic Hermite basis.
    let (u2, u3) = (u * u, u * u * u);
    v0 * (2.0 * u3 - 3.0 * u2 + 1.0) + v1 * (3.0 * u2 - 2.0 * u3) + span * (m0 * (u3 - 2.0 * u2 + u) + m1 * (u3 - u2))
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    #[test]
    fn curves_pass_through_their_keys() {
        let keys = [(0.0, 1.0), (1.0, 3.0), (4.0, -2.0), (5.0, -2.0)];
        for interpolation in [Interpolation::Step, Interpolation::Linear, Interpolation::Smooth] {
            let at = |time| sample(keys.len(), |i| keys[i], time, interpolation);
            for (time, value) in keys {
                assert!((at(time) - value).abs() < 1e-12);
            }
            assert_eq!((at(-1.0), at(9.0)), (1.0, -2.0));
        }
    }

    #[test]
    fn between_keys() {
        let keys = [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (4.0, 4.0)];
        let at = |time, interpolation| sample(keys.len(), |i| keys[i], time, interpolation);
        assert_eq!(at(1.5, Interpolation::Step), 1.0);
        assert_eq!(at(1.5, Interpolation::Linear), 1.5);
        // A straight line stays one, evenly spaced or not.
        for time in [0.25, 1.5, 2.1, 3.9] {
            assert!((at(time, Interpolation::Smooth) - time).abs() < 1e-12);
        }
    }

    #[test]
    fn a_smooth_curve_has_no_corners() {
        let keys = [(0.0, 0.0), (1.0, 5.0), (3.0, 1.0), (3.5, 2.0)];
        let at = |time| sample(keys.len(), |i| keys[i], time, Interpolation::Smooth);
        for (time, _) in &keys[1..3] {
            let (h, t) = (1e-6, *time);
            let (left, right) = ((at(t) - at(t - h)) / h, (at(t + h) - at(t)) / h);
            assert!((left - right).abs() < 1e-3, "{left} {right}");
        }
    }
}
