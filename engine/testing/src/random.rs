//! Random choices that are the same each time.

use raxel_world::random::SplitMix64;

/// A generator with the questions that random tests ask.
#[derive(Clone)]
pub struct Random(SplitMix64);

impl Random {
    /// The same seed makes the same choices.
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// A number below `end`; 0 if `end` is 0.
    ///
    /// # Panics
    /// If `end` is negative.
    pub fn below<T: TryFrom<u64> + TryInto<u64>>(&mut self, end: T) -> T {
        let Ok(end) = end.try_into() else { panic!("no number is below a negative one and not negative") };
        let Ok(number) = T::try_from(self.bits() % end.max(1)) else {
            unreachable!("it is below a number of this type")
        };
        number
    }

    /// True with a chance of `percent` in a hundred.
    pub fn percent(&mut self, percent: u32) -> bool {
        self.below(100) < percent
    }

    /// One of these.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }
}
