//! Time without rounding. Times of frames and ticks are exact fractions: frame 62 at 60 frames a second and tick 31 at 30 ticks a second
//! have the same time.

use std::cmp::Ordering;
use std::time::Duration;

/// Largest denominator of a [`Fraction`], and largest number it holds by the second: their product fits 64 bits.
const FINEST: u64 = 1 << 31;
const LARGEST: f64 = (1_u64 << 32) as f64;

/// Units in the last place that a float may be off: the product of a count and a rounded step is off by two.
const ROUNDED: u128 = 2;

/// A number of seconds, or a rate per second, as a fraction in lowest terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fraction {
    numerator: u64,
    denominator: u64,
}

impl Fraction {
    /// Zero.
    pub const ZERO: Fraction = Fraction { numerator: 0, denominator: 1 };

    /// The simplest fraction that rounds to this float: the one with the smallest denominator. `1.0 / 60.0` gives 1/60, `29.97` gives
    /// 2997/100, and `30000.0 / 1001.0` gives 30000/1001. Negative floats and NaN give 0, large floats 2³².
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`LARGEST` is below 2⁶⁴")]
    pub fn of(number: f64) -> Fraction {
        if number.is_nan() || number < 0.5 / FINEST as f64 {
            return Self::ZERO;
        }
        if number >= LARGEST {
            return Self { numerator: LARGEST as u64, denominator: 1 };
        }
        // The float is mantissa / unit; shifts are exact, for the number is between 2⁻³² and 2³².
        let exponent = (number.to_bits() >> 52) as u32;
        let mantissa = u128::from(number.to_bits() & ((1 << 52) - 1) | 1 << 52);
        let unit = 1_u128 << (1075 - exponent);
        Self::between((mantissa - ROUNDED, unit), (mantissa + ROUNDED, unit))
    }

    /// The fraction with the smallest denominator from `low` to `high`, by their continued fractions (the Stern-Brocot tree). If its
    /// denominator is too large, the last convergent before it.
    #[expect(clippy::cast_possible_truncation, reason = "numerators and denominators are at most `LARGEST`")]
    fn between(mut low: (u128, u128), mut high: (u128, u128)) -> Fraction {
        let (mut before, mut last) = ((0, 1), (1, 0));
        loop {
            let whole = low.0 / low.1;
            let is_whole = low.0 == whole * low.1;
            let ends = is_whole || (whole + 1) * high.1 <= high.0;
            // A term of 2³³ is too large, and products with a larger one would not fit.
            let term = if ends && !is_whole { whole + 1 } else { whole }.min(1 << 33);
            let next = (term * last.0 + before.0, term * last.1 + before.1);
            if next.1 > u128::from(FINEST) {
                return Self { numerator: last.0 as u64, denominator: last.1 as u64 };
            }
            (before, last) = (last, next);
            if ends {
                return Self { numerator: last.0 as u64, denominator: last.1 as u64 };
            }
            (low, high) = ((high.1, high.0 - whole * high.1), (low.1, low.0 - whole * low.1));
        }
    }

    /// Numerator and denominator.
    pub fn parts(self) -> (u64, u64) {
        (self.numerator, self.denominator)
    }
}

/// A time since the start of a session's clock: whole seconds, and a fraction of a second in lowest terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Moment {
    seconds: u64,
    part: u64,
    of: u64,
}

impl Moment {
    /// The start of the clock.
    pub const START: Moment = Moment { seconds: 0, part: 0, of: 1 };

    /// The time of a frame, if each frame takes `step` seconds and frame 0 is at the start.
    pub fn of_frame(frame: u64, step: Fraction) -> Moment {
        Self::START.after(frame, step)
    }

    /// The time `steps` steps later.
    #[must_use]
    pub fn after(self, steps: u64, step: Fraction) -> Moment {
        // Below 2¹²⁷, since a fraction is below 2⁶³.
        let way = u128::from(steps) * u128::from(step.numerator);
        let (of, by) = (u128::from(self.of), u128::from(step.denominator));
        let common = of / gcd(of, by) * by;
        let part = u128::from(self.part) * (common / of) + way % by * (common / by);
        let seconds = u64::try_from(way / by).unwrap_or(u64::MAX);
        Self::reduced(self.seconds.saturating_add(seconds), part, common)
    }

    /// Seconds and `part / of` of one, which may be more than a second.
    #[expect(clippy::cast_possible_truncation, reason = "`of` is at most 2⁶² after the loop, and `part` is below it")]
    fn reduced(seconds: u64, part: u128, of: u128) -> Moment {
        let seconds = seconds.saturating_add(u64::try_from(part / of).unwrap_or(u64::MAX));
        let part = part % of;
        let common = gcd(part, of);
        let (mut part, mut of) = (part / common, of / common);
        // Two fractions of 2³¹ always fit. More of them lose a rest below 2⁻⁶⁰ s.
        while of > 1 << 62 {
            (part, of) = (part >> 1, of >> 1);
        }
        Self { seconds, part: part as u64, of: of as u64 }
    }

    /// The time in seconds, as the nearest float.
    pub fn seconds(self) -> f64 {
        const EXACT: u128 = 1 << f64::MANTISSA_DIGITS;
        let all = u128::from(self.seconds) * u128::from(self.of) + u128::from(self.part);
        if all <= EXACT && u128::from(self.of) <= EXACT {
            return all as f64 / self.of as f64;
        }
        self.seconds as f64 + self.part as f64 / self.of as f64
    }

    /// Seconds since an earlier time, or 0 since a later one.
    pub fn since(self, earlier: Moment) -> f64 {
        if self <= earlier {
            return 0.0;
        }
        let (of, by) = (u128::from(self.of), u128::from(earlier.of));
        let common = of / gcd(of, by) * by;
        let (part, less) = (u128::from(self.part) * (common / of), u128::from(earlier.part) * (common / by));
        let seconds = self.seconds - earlier.seconds;
        if part >= less {
            Self::reduced(seconds, part - less, common).seconds()
        } else {
            Self::reduced(seconds - 1, part + common - less, common).seconds()
        }
    }

    /// For ticks at `rate` per second, the first at the start: the number of the last tick, and the fraction of the way to the next, below
    /// 1.
    pub fn tick(self, rate: Fraction) -> (u64, f64) {
        let (times, per) = (u128::from(rate.numerator), u128::from(rate.denominator));
        let whole = u128::from(self.seconds) * times;
        // Below 2¹²⁶ and 2⁹³.
        let above = whole % per * u128::from(self.of) + u128::from(self.part) * times;
        let below = per * u128::from(self.of);
        let number = u64::try_from(whole / per + above / below).unwrap_or(u64::MAX);
        (number, (above % below) as f64 / below as f64)
    }

    /// For ticks at `rate` per second: the number of the nearest tick, or of the later of two.
    pub fn nearest(self, rate: Fraction) -> u64 {
        let twice = Fraction { numerator: rate.numerator * 2, ..rate };
        self.tick(twice).0.div_ceil(2)
    }

    /// The time within a period that repeats every `round` seconds.
    #[must_use]
    pub fn within(self, round: Moment) -> Moment {
        let common = u128::from(self.of) / gcd(u128::from(self.of), u128::from(round.of)) * u128::from(round.of);
        let units = |moment: Moment| {
            let all = u128::from(moment.seconds) * u128::from(moment.of) + u128::from(moment.part);
            all.checked_mul(common / u128::from(moment.of))
        };
        match (units(self), units(round)) {
            (Some(_), Some(0)) => Self::START,
            (Some(units), Some(round)) => Self::reduced(0, units % round, common),
            // A session of centuries.
            _ => Self::from(self.seconds().rem_euclid(round.seconds())),
        }
    }
}

impl PartialOrd for Moment {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Moment {
    fn cmp(&self, other: &Self) -> Ordering {
        let cross = |a: u64, b: u64| u128::from(a) * u128::from(b);
        self.seconds.cmp(&other.seconds).then_with(|| cross(self.part, other.of).cmp(&cross(other.part, self.of)))
    }
}

impl From<Fraction> for Moment {
    fn from(seconds: Fraction) -> Self {
        Self::of_frame(1, seconds)
    }
}

/// By [`Fraction::of`].
impl From<f64> for Moment {
    fn from(seconds: f64) -> Self {
        Self::from(Fraction::of(seconds))
    }
}

impl From<Duration> for Moment {
    fn from(duration: Duration) -> Self {
        Self::reduced(duration.as_secs(), u128::from(duration.subsec_nanos()), 1_000_000_000)
    }
}

impl std::ops::Add<Duration> for Moment {
    type Output = Moment;

    fn add(self, duration: Duration) -> Moment {
        let nanosecond = Fraction { numerator: 1, denominator: 1_000_000_000 };
        self.after(u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX), nanosecond)
    }
}

fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a.max(1)
}

#[cfg(test)]
mod tests {
    use raxel_world::random::SplitMix64;

    use super::*;

    #[test]
    fn a_float_is_the_fraction_that_was_written() {
        for (number, parts) in [
            (0.0, (0, 1)),
            (1.0 / 60.0, (1, 60)),
            (60.0, (60, 1)),
            (29.97, (2997, 100)),
            (30000.0 / 1001.0, (30000, 1001)),
            (1001.0 / 30000.0, (1001, 30000)),
            (59.94, (2997, 50)),
            (0.1, (1, 10)),
            (0.1 + 0.2, (3, 10)),
            (0.001, (1, 1000)),
            (9999.999, (9_999_999, 1000)),
            (86399.99, (8_639_999, 100)),
            (0.123_456, (1929, 15625)),
            (f64::NAN, (0, 1)),
            (-1.0, (0, 1)),
            (f64::INFINITY, (1 << 32, 1)),
            (f64::MIN_POSITIVE, (0, 1)),
        ] {
            assert_eq!(Fraction::of(number).parts(), parts, "{number}");
        }
        // All decimals with three digits, and the sums of counted steps.
        for thousandths in 1..=1_000_000_u64 {
            let text = format!("{}.{:03}", thousandths / 1000, thousandths % 1000);
            let (above, below) = Fraction::of(text.parse().expect("a number")).parts();
            assert!(u128::from(above) * 1000 == u128::from(thousandths) * u128::from(below), "{text}: {above}/{below}");
        }
        for fps in [24.0, 25.0, 29.97, 30000.0 / 1001.0, 30.0, 60.0, 144.0] {
            let step = Fraction::of(1.0 / fps);
            for frame in 0..100_000_u32 {
                let exact = Moment::of_frame(u64::from(frame), step);
                for float in [f64::from(frame) / fps, f64::from(frame) * (1.0 / fps)] {
                    assert_eq!(Moment::from(float), exact, "frame {frame} at {fps}");
                }
            }
        }
    }

    #[test]
    fn floats_that_nobody_chose_stay_close_and_in_order() {
        let mut random = SplitMix64::new(22);
        for _ in 0..100_000 {
            let mut float = || random.bits() as f64 * 2.0_f64.powi((random.bits() % 90) as i32 - 104);
            let (float, other, round) = (float(), Fraction::of(float()), Moment::from(float()));
            let moment = Moment::from(float);
            let error = (moment.seconds() - float).abs();
            assert!(error <= 1e-9 + float * 2.0_f64.powi(-51) || float > LARGEST, "{float:e}: {moment:?}");
            // No sum of these overflows, and a later time compares as later.
            let later = moment.after(random.bits(), other) + Duration::from_nanos(random.bits());
            assert!(later >= moment && later.since(moment) >= 0.0 && moment.since(later) <= 0.0);
            let (_, phase) = later.tick(other);
            assert!((0.0..=1.0).contains(&phase));
            assert!(later.within(round).seconds() <= round.seconds() * (1.0 + 1e-12));
        }
    }

    #[test]
    fn rounds_start_over_exactly() {
        // Ten rounds of 7/5 s at 30 frames a second: 42 frames each.
        let (round, step) = (Moment::from(1.4), Fraction::of(1.0 / 30.0));
        for frame in 0..420 {
            assert_eq!(Moment::of_frame(frame, step).within(round), Moment::of_frame(frame % 42, step));
        }
        assert_eq!(Moment::from(2.5).nearest(Fraction::of(30.0)), 75);
        assert_eq!(Moment::from(0.05).nearest(Fraction::of(30.0)), 2, "half a frame is the later one");
        assert_eq!(Moment::from(0.049).nearest(Fraction::of(30.0)), 1);
    }
}
