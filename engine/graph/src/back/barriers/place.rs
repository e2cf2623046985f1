//! Chooses the gaps that get a barrier: the fewest that hit every interval on the circle of a frame.
//!
//! On a line the greedy choice, always as late as the next interval allows, is optimal; on a circle it is when started at the right
//! gap (Hsu and Tsai, "Linear time algorithms on circular-arc graphs", 1991). Some barrier must hit the shortest interval, so each
//! of its gaps is tried as the start.

use super::hazards::{Gaps, Hazards};

use crate::ir::index::index32;

/// The gaps that get a barrier, in order.
pub(super) fn place(actions: u32, hazards: &Hazards) -> Vec<u32> {
    let takeovers = hazards.takeovers.iter().filter(|takeover| takeover.image).map(|takeover| takeover.gaps);
    hit(actions, hazards.pairs.iter().map(|pair| pair.gaps).chain(takeovers))
}

fn hit(gaps: u32, intervals: impl Iterator<Item = Gaps>) -> Vec<u32> {
    // Two rounds of the circle; an interval of a whole round is hit by any barrier.
    let n = gaps as usize;
    let mut next = vec![usize::MAX; 2 * n + 1];
    let mut shortest: Option<(usize, usize)> = None;
    for Gaps { end, count } in intervals {
        let count = (count as usize).min(n);
        let (mut start, mut end) = (end as usize + n + 1 - count, end as usize + n);
        if start >= n {
            (start, end) = (start - n, end - n);
        }
        for round in [0, n] {
            if start + round < next.len() {
                next[start + round] = next[start + round].min(end + round);
            }
        }
        if shortest.is_none_or(|(start, end)| count < end - start + 1) {
            shortest = Some((start, end));
        }
    }
    let Some((first, last)) = shortest else { return Vec::new() };
    // next[s]: the earliest end of an interval that starts at s or later. A barrier at g is followed by one at next[g + 1].
    for start in (0..2 * n).rev() {
        next[start] = next[start].min(next[start + 1]);
    }
    let mut best: Vec<u32> = Vec::new();
    // The last gap first: with equal numbers, barriers stand as late as they can.
    for start in (first..=last).rev() {
        let start = start % n;
        let mut chosen = vec![index32(start)];
        let mut at = start;
        while next[at + 1] < start + n {
            at = next[at + 1];
            chosen.push(index32(at % n));
            if !best.is_empty() && chosen.len() >= best.len() {
                break;
            }
        }
        if best.is_empty() || chosen.len() < best.len() {
            best = chosen;
        }
    }
    best.sort_unstable();
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fewest gaps by trying all sets.
    fn by_trial(n: u32, intervals: &[Gaps]) -> u32 {
        (0_u32..1 << n).filter(|set| intervals.iter().all(|i| hits(*set, n, *i))).map(u32::count_ones).min().unwrap()
    }

    fn hits(set: u32, n: u32, interval: Gaps) -> bool {
        (0..interval.count.min(n)).any(|back| set >> ((interval.end + n - back) % n) & 1 == 1)
    }

    #[test]
    fn no_set_of_gaps_is_smaller() {
        let mut state = 1_u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for _ in 0..3000 {
            let n = 1 + random(9);
            let count = random(7);
            let intervals: Vec<Gaps> = (0..count).map(|_| Gaps { end: random(n), count: 1 + random(n + 3) }).collect();
            let chosen = hit(n, intervals.iter().copied());
            let set = chosen.iter().fold(0, |set, gap| set | 1 << gap);
            assert!(intervals.iter().all(|i| hits(set, n, *i)), "{n} {intervals:?} {chosen:?}");
            assert_eq!(chosen.len() as u32, by_trial(n, &intervals), "{n} {intervals:?} {chosen:?}");
        }
    }
}
