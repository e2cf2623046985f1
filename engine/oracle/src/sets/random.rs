//! Random numbers, cells and directions that sets are made of.

use raxel_world::random::SplitMix64;

/// Random numbers, places and directions, the same everywhere.
#[derive(Clone, Debug)]
pub struct Random(SplitMix64);

impl Random {
    /// From any seed.
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// In 0…n − 1, by the remainder: the sets that published figures were measured with are made this way.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// [`below`](Self::below), for places in a list.
    #[expect(clippy::cast_possible_truncation, reason = "it is below `n`, which is a `usize`")]
    pub fn index(&mut self, n: usize) -> usize {
        self.below(n as u64) as usize
    }

    /// In 0…1, a multiple of 2⁻²⁴ below 1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// In −1…1.
    pub(super) fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    fn vector(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.signed())
    }

    /// A direction, roughly uniform on the sphere.
    pub(super) fn direction(&mut self) -> [f32; 3] {
        loop {
            let v = self.vector();
            let square: f32 = v.iter().map(|v| v * v).sum();
            if (0.01..1.0).contains(&square) {
                return v.map(|v| v / square.sqrt());
            }
        }
    }

    /// A cell of a box.
    #[expect(clippy::cast_possible_wrap, reason = "the number is below the side of a box")]
    pub(super) fn cell(&mut self, [low, high]: [[i64; 3]; 2]) -> [i64; 3] {
        std::array::from_fn(|i| low[i] + self.below((high[i] - low[i]).max(1).cast_unsigned()) as i64)
    }
}
