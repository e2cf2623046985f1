//! Finds the least distance in frames at which two accesses of one resource meet in the same copy.
//!
//! The history of a resource without a clock advances by one copy in each frame: of C copies, the two accesses are to the same one when
//! d ≡ age(to) − age(from) (mod C). The history of a resource with a clock advances by one copy in each tick, and a frame runs 0 to
//! `most` ticks, which a plan cannot know. The distance between the two copies, in ticks, is then a range, and the accesses can meet when
//! the range contains a multiple of C. An access in tick i of a frame implies that the frame runs more than i ticks.

use crate::back::order::ResourceAccess;
use crate::ir::checked::Graph;
use crate::ir::plan::CopySelector;

/// The smallest number of frames from `from` to a later `to` in which they may access one copy of their resource.
pub(super) fn frames_apart(graph: &Graph, copies: u32, from: &ResourceAccess, to: &ResourceAccess) -> u32 {
    let (CopySelector::Before(clock) | CopySelector::Tick(clock, _) | CopySelector::After(clock)) = from.selector
    else {
        let frames = (to.age + copies - from.age % copies) % copies;
        return if frames == 0 && to.action <= from.action { copies } else { frames };
    };
    frames_apart_by_ticks(graph.clock(clock).most.into(), copies, from, to)
}

/// The same for a resource whose clock ticks at most `most` times in a frame.
fn frames_apart_by_ticks(most: i64, copies: u32, from: &ResourceAccess, to: &ResourceAccess) -> u32 {
    // One tick more in each frame reaches every copy, in as many frames as there are copies.
    let first = u32::from(to.action <= from.action);
    let meet = |frames: &u32| ticks_apart(most, from, to, *frames).is_some_and(|range| holds_multiple(range, copies));
    (first..=first + copies).find(meet).unwrap_or(first + copies)
}

/// The least and the largest number of ticks from the copy of `from` to that of `to`, `frames` frames later; `None` when no frame runs
/// both.
fn ticks_apart(most: i64, from: &ResourceAccess, to: &ResourceAccess, frames: u32) -> Option<(i64, i64)> {
    let ages = i64::from(from.age) - i64::from(to.age);
    let ran = |access: &ResourceAccess| match access.selector {
        CopySelector::Tick(_, tick) => i64::from(tick) + 1,
        _ => 0,
    };
    if frames == 0 {
        // Both are counted from the ticks before the frame, which runs at least as many as its later access requires.
        let least = ran(from).max(ran(to));
        let at = |access: &ResourceAccess, due: i64| match access.selector {
            CopySelector::Tick(_, tick) => i64::from(tick),
            CopySelector::After(_) => due - 1,
            CopySelector::Before(_) | CopySelector::Frame => -1,
        };
        let distance = |due: i64| at(to, due) - at(from, due) + ages;
        return (least <= most).then(|| (distance(least), distance(most)));
    }
    // Ticks that the frame of `from` still runs behind it, those of the frames between, and those of the frame of `to` before it.
    let behind = match from.selector {
        CopySelector::Tick(_, tick) => (0, most - i64::from(tick) - 1),
        CopySelector::After(_) => (0, 0),
        CopySelector::Before(_) | CopySelector::Frame => (0, most),
    };
    let between = (0, i64::from(frames - 1) * most);
    let ahead = match to.selector {
        CopySelector::Tick(_, tick) => (i64::from(tick) + 1, i64::from(tick) + 1),
        CopySelector::After(_) => (0, most),
        CopySelector::Before(_) | CopySelector::Frame => (0, 0),
    };
    Some((behind.0 + between.0 + ahead.0 + ages, behind.1 + between.1 + ahead.1 + ages))
}

fn holds_multiple((least, largest): (i64, i64), of: u32) -> bool {
    largest.div_euclid(of.into()) * i64::from(of) >= least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::checked::ClockId;
    use crate::ir::plan::AccessMask;
    use crate::ir::subresources::SubresourceRange;

    /// Whether two accesses, `frames` frames apart, are to one copy for some numbers of ticks: every number of each frame is tried.
    fn meet(most: i64, copies: i64, from: &ResourceAccess, to: &ResourceAccess, frames: u32) -> bool {
        // The tick of an access whose frame begins behind `begun` ticks and runs `ticks`; none if it does not run.
        let tick = |access: &ResourceAccess, begun: i64, ticks: i64| match access.selector {
            CopySelector::Tick(_, tick) => (i64::from(tick) < ticks).then_some(begun + i64::from(tick)),
            CopySelector::After(_) => Some(begun + ticks - 1),
            CopySelector::Before(_) | CopySelector::Frame => Some(begun - 1),
        };
        let between = 0..=most * i64::from(frames.saturating_sub(1));
        (0..=most).any(|first| {
            between.clone().any(|between| {
                (0..=most).any(|last| {
                    let (begun, last) = if frames == 0 { (0, first) } else { (first + between, last) };
                    let places = tick(from, 0, first).zip(tick(to, begun, last));
                    let [from_age, to_age] = [from.age, to.age].map(i64::from);
                    places.is_some_and(|(a, b)| (a - from_age - b + to_age).rem_euclid(copies) == 0)
                })
            })
        })
    }

    #[test]
    fn two_accesses_first_meet_in_the_frame_that_trying_all_ticks_says() {
        let clock = ClockId(0);
        let selectors = |most: u32| {
            let ticks = (0..most).map(move |tick| CopySelector::Tick(clock, tick));
            ticks.chain([CopySelector::Before(clock), CopySelector::After(clock)])
        };
        let order = |selector: CopySelector| match selector {
            CopySelector::Tick(_, tick) => i64::from(tick),
            CopySelector::After(_) => i64::MAX,
            CopySelector::Before(_) | CopySelector::Frame => -1,
        };
        let range = SubresourceRange { mips: (0, 1), layers: (0, 1) };
        let access = |action, age, selector| ResourceAccess {
            action,
            resource: 0,
            age,
            selector,
            range,
            mask: AccessMask::TRANSFER_READ,
        };
        let (mut tried, mut later) = (0, 0);
        for (most, copies) in (1..=3).flat_map(|most| (1..=5).map(move |copies| (most, copies))) {
            for (from_selector, to_selector) in
                selectors(most).flat_map(|from| selectors(most).map(move |to| (from, to)))
            {
                for (from_age, to_age) in (0..copies).flat_map(|from| (0..copies).map(move |to| (from, to))) {
                    // Behind `from` in its frame stand accesses of the same tick or a later one.
                    let behind =
                        [0, 1].into_iter().take(if order(from_selector) <= order(to_selector) { 2 } else { 1 });
                    for to_action in behind {
                        let (from, to) = (access(0, from_age, from_selector), access(to_action, to_age, to_selector));
                        let first = u32::from(to.action <= from.action);
                        let right = (first..=first + copies)
                            .find(|frames| meet(most.into(), copies.into(), &from, &to, *frames));
                        let found = frames_apart_by_ticks(most.into(), copies, &from, &to);
                        assert_eq!(Some(found), right, "at most {most} ticks, {copies} copies: {from:?} {to:?}");
                        tried += 1;
                        later += u32::from(found > 1);
                    }
                }
            }
        }
        assert!(tried > 1000 && later > 100, "{tried} {later}");
    }
}
