//! A tree of boxes over instances, rebuilt whenever one of them moves.
//!
//! Splits are where the surface area heuristic is least over a few planes (Wald, "On fast construction of SAH-based bounding volume
//! hierarchies", 2007), but each side takes at least a quarter: that bounds the depth, and so the stack of the shader.

/// Words of a node.
pub(super) const NODE_WORDS: usize = 8;
/// In place of an axis: a leaf.
const LEAF: u32 = 3;
/// Places where a split is tried.
const BINS: usize = 16;

/// Smallest voxel and last voxel.
pub(super) type Box3 = [[i64; 3]; 2];

/// With at least this many boxes, two threads make the sides of a node.
const SHARED: usize = 1024;

/// The nodes of a tree over boxes, depth first, as words: smallest corner, link, last voxel, kind. The kind is the axis that was split, and
/// then the first child, the one lower on that axis, follows and the link is the index of the second; or 3, and the link is the index of
/// the box.
#[expect(
    clippy::cast_possible_truncation,
    reason = "there are at most `MAX_INSTANCES` boxes, whose coordinates are cells"
)]
pub(super) fn build(boxes: &[Box3]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut words = vec![0; NODE_WORDS * nodes(boxes.len())];
    if !order.is_empty() {
        add(boxes, &mut order, 0, &mut words);
    }
    words
}

/// Nodes of a tree over `boxes` boxes.
fn nodes(boxes: usize) -> usize {
    (2 * boxes).saturating_sub(1)
}

/// Writes the tree over the boxes of `order` to `words`, which is as long as it; `first` is the index of its first node.
#[expect(
    clippy::cast_possible_truncation,
    reason = "there are at most `MAX_INSTANCES` boxes, whose coordinates are cells"
)]
fn add(boxes: &[Box3], order: &mut [u32], first: usize, words: &mut [u32]) {
    let (node, below) = words.split_at_mut(NODE_WORDS);
    let bounds = order.iter().map(|&i| boxes[i as usize]).reduce(union).unwrap_or_default();
    let mut put = |link: u32, kind: u32| {
        let [low, last] = bounds.map(|corner| corner.map(|c| (c as i32).cast_unsigned()));
        node.copy_from_slice(&[low[0], low[1], low[2], link, last[0], last[1], last[2], kind]);
    };
    if let [only] = *order {
        return put(only, LEAF);
    }
    let (axis, left) = split(boxes, order);
    let second = first + 1 + nodes(left);
    put(second as u32, axis as u32);
    let (low, high) = order.split_at_mut(left);
    let (low_words, high_words) = below.split_at_mut(NODE_WORDS * nodes(left));
    if low.len() + high.len() < SHARED {
        add(boxes, low, first + 1, low_words);
        add(boxes, high, second, high_words);
    } else {
        rayon::join(|| add(boxes, low, first + 1, low_words), || add(boxes, high, second, high_words));
    }
}

/// Brings boxes to two sides of an axis; gives the axis and how many are on the lower side.
#[expect(clippy::cast_sign_loss, reason = "the middle is between `low` and `high`, so that the bin is below `BINS`")]
fn split(boxes: &[Box3], order: &mut [u32]) -> (usize, usize) {
    // Twice the centre, so that it is whole.
    let middle = |i: u32, axis: usize| boxes[i as usize][0][axis] + boxes[i as usize][1][axis];
    let ranges: [(i64, i64); 3] = std::array::from_fn(|axis| {
        order.iter().fold((i64::MAX, i64::MIN), |(low, high), &i| {
            let at = middle(i, axis);
            (low.min(at), high.max(at))
        })
    });
    let widest = (0..3).max_by_key(|&axis| (ranges[axis].1 - ranges[axis].0, 2 - axis));
    let axis = widest.unwrap_or(0);
    let (low, high) = ranges[axis];
    let count = order.len();
    let [least, most] = [count.div_ceil(4), count - count.div_ceil(4)];
    let half = count / 2;
    // At the median of the centres along the axis; of equal centres, the one with the smaller index is lower.
    let halve = |order: &mut [u32]| {
        order.select_nth_unstable_by_key(half, |&i| (middle(i, axis), i));
        (axis, half)
    };
    if high == low || count < 4 {
        return halve(order);
    }
    // Boxes in the bins, and the cost of a split behind each.
    let bin = |i: u32| (i128::from(middle(i, axis) - low) * BINS as i128 / i128::from(high - low + 1)) as usize;
    let mut ends = [0_usize; BINS];
    let mut hulls: [Option<Box3>; BINS] = [None; BINS];
    for &i in order.iter() {
        let bin = bin(i);
        ends[bin] += 1;
        hulls[bin] = join(hulls[bin], Some(boxes[i as usize]));
    }
    for i in 1..BINS {
        ends[i] += ends[i - 1];
    }
    let mut above = [None; BINS];
    for i in (0..BINS - 1).rev() {
        above[i] = join(above[i + 1], hulls[i + 1]);
    }
    let mut below = None;
    let mut best: Option<(f64, usize)> = None;
    for i in 0..BINS - 1 {
        below = join(below, hulls[i]);
        let (Some(low), Some(high)) = (below, above[i]) else { continue };
        let cost = area(low) * ends[i] as f64 + area(high) * (count - ends[i]) as f64;
        if (least..=most).contains(&ends[i]) && best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, i));
        }
    }
    let Some((_, last_bin)) = best else { return halve(order) };
    let mut left = 0;
    for i in 0..count {
        if bin(order[i]) <= last_bin {
            order.swap(left, i);
            left += 1;
        }
    }
    (axis, left)
}

fn union(a: Box3, b: Box3) -> Box3 {
    [std::array::from_fn(|i| a[0][i].min(b[0][i])), std::array::from_fn(|i| a[1][i].max(b[1][i]))]
}

fn join(a: Option<Box3>, b: Option<Box3>) -> Option<Box3> {
    match (a, b) {
        (Some(a), Some(b)) => Some(union(a, b)),
        (a, b) => a.or(b),
    }
}

fn area([low, last]: Box3) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|i| (last[i] - low[i] + 1) as f64);
    x * y + y * z + z * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use raxel_world::random::SplitMix64;

    /// The depth that the shader has room for.
    const DEPTH: usize = 36;

    /// Checks a node and gives the boxes below it, and how many may wait on the stack.
    fn check(words: &[u32], node: usize, boxes: &[Box3], found: &mut Vec<u32>) -> (Box3, usize) {
        let at = &words[NODE_WORDS * node..][..NODE_WORDS];
        let corner = |from: usize| [0, 1, 2].map(|i| i64::from(at[from + i].cast_signed()));
        let hull = [corner(0), corner(4)];
        if at[7] == LEAF {
            found.push(at[3]);
            assert_eq!(hull, boxes[at[3] as usize]);
            return (hull, 0);
        }
        let before = found.len();
        let (low, a) = check(words, node + 1, boxes, found);
        let first = found.len() - before;
        let (high, b) = check(words, at[3] as usize, boxes, found);
        let both = found.len() - before;
        assert!(first.min(both - first) >= both.div_ceil(4), "{first} of {both}");
        assert_eq!(hull, union(low, high));
        (hull, 1 + a.max(b))
    }

    #[test]
    fn every_box_is_in_one_leaf_and_the_stack_holds_the_way() {
        let mut random = SplitMix64::new(3);
        for count in [1, 2, 3, 4, 7, 100, 1000, crate::instances::MAX_INSTANCES] {
            for spread in [1, 60, 1 << 20] {
                // Far apart by powers: the worst for a split by planes.
                let mut at = || {
                    let size =
                        1 + (random.bits() % spread) as i64 * if random.bits().is_multiple_of(9) { 512 } else { 1 };
                    (random.bits() % size as u64) as i64
                };
                let boxes: Vec<Box3> = (0..count)
                    .map(|_| {
                        let low = [at(), at(), at()];
                        [low, low.map(|c| c + 5)]
                    })
                    .collect();
                let words = build(&boxes);
                assert_eq!(words.len(), NODE_WORDS * nodes(count));
                let mut found = Vec::new();
                let (_, depth) = check(&words, 0, &boxes, &mut found);
                found.sort_unstable();
                assert!(found.iter().copied().eq(0..count as u32));
                assert!(depth <= DEPTH, "{depth} for {count} over {spread}");
            }
        }
        assert!(build(&[]).is_empty());
    }

    /// Between clusters of 4 and 3 and one of 13 far from both, on any axis, in any order of their boxes.
    #[test]
    fn clusters_are_split_where_they_are_apart() {
        for axis in 0..3 {
            let place = |i: i64| match i % 3 {
                1 if i < 12 => -500,
                1 => -400,
                _ => 500,
            };
            let boxes: Vec<Box3> = (0..20_i64)
                .map(|i| {
                    let low = std::array::from_fn(|a| if a == axis { place(i) + i } else { 50 - i });
                    [low, low.map(|c| c + 2)]
                })
                .collect();
            let words = build(&boxes);
            let mut below = Vec::new();
            check(&words, 1, &boxes, &mut below);
            below.sort_unstable();
            assert_eq!((below, words[7]), (vec![1, 4, 7, 10, 13, 16, 19], axis as u32));
        }
    }
}
