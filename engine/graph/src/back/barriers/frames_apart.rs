//! How many frames apart two accesses of one resource first meet in the same copy.
//!
//! The history of a resource without a clock advances by one copy in each frame: of C copies, the two accesses are to the same one when
//! d ≡ age(to) − age(from) (mod C). The history of a resource with a clock advances by one copy in each tick, and a frame runs 0 to
//! `most` ticks, which a plan cannot know. The distance between the two copies, in ticks, is then a range, and the accesses can meet when
//! the range contains a multiple of C. An access in tick i of a frame implies that the frame runs more than i ticks.

use crate::back::order::ResourceAccess;
use crate::ir::checked::Graph;
use crate::ir::plan::Turn;

/// The smallest number of frames from `from` to a later `to` in which they may access one copy of their resource.
pub(super) fn frames_apart(graph: &Graph, copies: u32, from: &ResourceAccess, to: &ResourceAccess) -> u32 {
    let (Turn::Before(clock) | Turn::Tick(clock, _) | Turn::After(clock)) = from.turn else {
        let frames = (to.age + copies - from.age % copies) % copies;
        return if frames == 0 && to.action <= from.action { copies } else { frames };
    };
    let most = i64::from(graph.clock(clock).most);
    // One tick more in each frame reaches every copy, in as many frames as there are copies.
    let first = u32::from(to.action <= from.action);
    let meet = |frames: &u32| ticks_apart(most, from, to, *frames).is_some_and(|range| holds_multiple(range, copies));
    (first..=first + copies).find(meet).unwrap_or(first + copies)
}

/// The least and the largest number of ticks from the copy of `from` to that of `to`, so many frames later; `None` when no frame runs
/// both.
fn ticks_apart(most: i64, from: &ResourceAccess, to: &ResourceAccess, frames: u32) -> Option<(i64, i64)> {
    let ages = i64::from(from.age) - i64::from(to.age);
    let ran = |access: &ResourceAccess| match access.turn {
        Turn::Tick(_, tick) => i64::from(tick) + 1,
        _ => 0,
    };
    if frames == 0 {
        // Both are counted from the ticks before the frame, which runs at least as many as its later access says.
        let least = ran(from).max(ran(to));
        let at = |access: &ResourceAccess, due: i64| match access.turn {
            Turn::Tick(_, tick) => i64::from(tick),
            Turn::After(_) => due - 1,
            Turn::Before(_) | Turn::Frame => -1,
        };
        let distance = |due: i64| at(to, due) - at(from, due) + ages;
        return (least <= most).then(|| (distance(least), distance(most)));
    }
    // Ticks that the frame of `from` still runs behind it, those of the frames between, and those of the frame of `to` before it.
    let behind = match from.turn {
        Turn::Tick(_, tick) => (0, most - i64::from(tick) - 1),
        Turn::After(_) => (0, 0),
        Turn::Before(_) | Turn::Frame => (0, most),
    };
    let between = (0, i64::from(frames - 1) * most);
    let ahead = match to.turn {
        Turn::Tick(_, tick) => (i64::from(tick) + 1, i64::from(tick) + 1),
        Turn::After(_) => (0, most),
        Turn::Before(_) | Turn::Frame => (0, 0),
    };
    Some((behind.0 + between.0 + ahead.0 + ages, behind.1 + between.1 + ahead.1 + ages))
}

fn holds_multiple((least, largest): (i64, i64), of: u32) -> bool {
    largest.div_euclid(of.into()) * i64::from(of) >= least
}
