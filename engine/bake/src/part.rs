//! The part of all shards that one task makes.

use std::str::FromStr;

use crate::plan::{BakedLevel, Plan, ShardKey};

/// A part of the shards of a plan. All parts of one division together are every shard once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BakePart {
    /// All of them.
    Whole,
    /// `I/N`: part I of N, counted from 1, of the list of shards, as parts of films are.
    OfList {
        /// 1 to `of`.
        part: u64,
        /// At least 1.
        of: u64,
    },
    /// `X,Y,Z/N`: of N × N × N boxes of the region, the one at X, Y, Z, counted from 0. Each level of detail is divided in the same way.
    OfBoxes {
        /// Each below `of`.
        at: [u64; 3],
        /// At least 1.
        of: u64,
    },
}

impl FromStr for BakePart {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORMS: &str = "parts are given as I/N, with I from 1 to N, or X,Y,Z/N, with each from 0 to N - 1";
        let wrong = || format!("`{text}` is not a part: {FORMS}");
        let (part, of) = text.split_once('/').ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse::<u64>().ok();
        let of = number(of).filter(|of| *of > 0).ok_or_else(wrong)?;
        let found = match part.split(',').map(number).collect::<Option<Vec<u64>>>().as_deref() {
            Some([part]) if (1..=of).contains(part) => Self::OfList { part: *part, of },
            Some([x, y, z]) if [x, y, z].into_iter().all(|c| *c < of) => Self::OfBoxes { at: [*x, *y, *z], of },
            _ => return Err(wrong()),
        };
        Ok(found)
    }
}

impl BakePart {
    /// The shards of a plan that are in this part, in the order of the levels and of their places: z last, x first.
    #[expect(clippy::cast_possible_truncation, reason = "each is below a number of shards, which has 32 bits")]
    pub fn shards(self, plan: &Plan) -> impl Iterator<Item = ShardKey> + '_ {
        let counts = plan.levels().iter().map(BakedLevel::count);
        let all: u64 = counts.sum();
        let list = match self {
            Self::OfList { part, of } => share(all, part - 1, of),
            Self::Whole | Self::OfBoxes { .. } => 0..all,
        };
        let mut before = 0;
        plan.levels().iter().flat_map(move |level| {
            let count = level.count();
            let mine =
                list.start.clamp(before, before + count) - before..list.end.clamp(before, before + count) - before;
            before += count;
            let boxes: [std::ops::Range<u64>; 3] = std::array::from_fn(|axis| match self {
                Self::OfBoxes { at, of } => share(u64::from(level.shards[axis]), at[axis], of),
                _ => 0..u64::from(level.shards[axis]),
            });
            let [columns, rows, _] = level.shards.map(u64::from);
            mine.filter_map(move |index| {
                let at = [index % columns, index / columns % rows, index / columns / rows];
                let inside = (0..3).all(|axis| boxes[axis].contains(&at[axis]));
                inside.then(|| ShardKey { level: level.level, at: at.map(|c| c as u32) })
            })
        })
    }
}

/// The indices of `count` that the part at `index` of `of` gets: shares differ by one at most.
#[expect(clippy::cast_possible_truncation, reason = "an index is at most `of`, so that a bound is at most `count`")]
fn share(count: u64, index: u64, of: u64) -> std::ops::Range<u64> {
    let bound = |index: u64| (u128::from(count) * u128::from(index) / u128::from(of)) as u64;
    bound(index)..bound(index + 1)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use raxel_world::{Bounds, Material};

    use super::*;

    #[test]
    fn parts_are_every_shard_once() {
        let region = Bounds { min: [-700, -10, 5], max: [1300, 500, 700] };
        let plan = Plan::new("test", "0", vec![Material::air()], region, 256, 3).unwrap();
        let all: Vec<ShardKey> = BakePart::Whole.shards(&plan).collect();
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
        for of in [1, 2, 3, 5, 400] {
            let parts = (1..=of).flat_map(|part| BakePart::OfList { part, of }.shards(&plan));
            assert_eq!(parts.collect::<Vec<_>>(), all, "of {of}");
        }
        for of in [1, 2, 3] {
            let mut found = Vec::new();
            for x in 0..of {
                for y in 0..of {
                    for z in 0..of {
                        found.extend(BakePart::OfBoxes { at: [x, y, z], of }.shards(&plan));
                    }
                }
            }
            found.sort_unstable();
            let mut sorted = all.clone();
            sorted.sort_unstable();
            assert_eq!(found, sorted, "of {of}");
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        assert_eq!("2/16".parse(), Ok(BakePart::OfList { part: 2, of: 16 }));
        assert_eq!("1,0,2/3".parse(), Ok(BakePart::OfBoxes { at: [1, 0, 2], of: 3 }));
        for wrong in ["", "1", "0/4", "5/4", "1/0", "1,2/4", "1,2,3,0/4", "4,0,0/4", "-1,0,0/4", "a/b", "1//2", "1/2/3"]
        {
            assert!(wrong.parse::<BakePart>().unwrap_err().contains("I/N"), "{wrong}");
        }
    }
}
