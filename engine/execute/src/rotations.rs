//! Finds the copies of resources with a history that a frame touches.

use raxel_graph::plan::CopySelector;

/// The combinations of copies that a pass can touch. Each selector comes with its period: after that number of steps of its counter, it
/// selects the same copies again. There are as many ways as the product of the periods.
#[derive(Clone, Debug, Default)]
pub(super) struct Rotations(Vec<(CopySelector, u64)>);

impl Rotations {
    pub(super) fn of(selectors: impl Iterator<Item = (CopySelector, u64)>) -> Rotations {
        let mut rotations: Vec<(CopySelector, u64)> = Vec::new();
        for (selector, copies) in selectors {
            match rotations.iter_mut().find(|(known, _)| *known == selector) {
                Some((_, period)) => *period = lcm(*period, copies),
                None => rotations.push((selector, copies)),
            }
        }
        Rotations(rotations)
    }

    /// Number of ways.
    pub(super) fn count(&self) -> u64 {
        self.0.iter().map(|(_, period)| period).product()
    }

    /// The index of the current state; `rotation` returns the counter of each selector.
    pub(super) fn way(&self, rotation: impl Fn(CopySelector) -> u64) -> u64 {
        self.0.iter().fold(0, |way, &(selector, period)| way * period + rotation(selector) % period)
    }

    /// The counter of a selector in one of the ways.
    pub(super) fn rotation(&self, mut way: u64, of: CopySelector) -> u64 {
        for &(selector, period) in self.0.iter().rev() {
            if selector == of {
                return way % period;
            }
            way /= period;
        }
        0
    }
}

/// The physical copy that holds the content of `age` frames ago in frame `frame`.
#[expect(clippy::cast_possible_truncation, reason = "it is below the number of copies")]
pub(super) fn copy_of(frame: u64, age: u32, copies: u32) -> usize {
    let copies = u64::from(copies.max(1));
    ((frame + copies - u64::from(age) % copies) % copies) as usize
}

fn lcm(a: u64, b: u64) -> u64 {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
}

#[cfg(test)]
mod tests {
    use raxel_graph::checked::ClockId;
    use raxel_graph::plan::CopySelector;

    use super::{Rotations, copy_of, lcm};

    #[test]
    fn histories_rotate() {
        assert_eq!(lcm(2, 3), 6);
        assert_eq!((0..4).map(|frame| copy_of(frame, 0, 2)).collect::<Vec<_>>(), [0, 1, 0, 1]);
        assert_eq!(copy_of(0, 1, 2), 1);
        assert_eq!(copy_of(5, 2, 3), 0);
        assert_eq!(copy_of(7, 3, 1), 0);
    }

    #[test]
    fn every_way_of_standing_has_its_number() {
        let after = CopySelector::After(ClockId(0));
        let rotations = Rotations::of([(CopySelector::Frame, 2), (after, 3), (CopySelector::Frame, 3)].into_iter());
        assert_eq!(rotations.count(), 18);
        let mut seen = [false; 18];
        for frame in 0..6 {
            for tick in 100..103 {
                let way = rotations.way(|selector| if selector == after { tick } else { frame });
                assert!(!std::mem::replace(&mut seen[way as usize], true));
                assert_eq!(rotations.rotation(way, CopySelector::Frame), frame % 6);
                assert_eq!(rotations.rotation(way, after), tick % 3);
            }
        }
        assert_eq!(Rotations::default().count(), 1);
    }
}
