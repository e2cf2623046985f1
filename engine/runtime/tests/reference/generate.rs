//! Makes meaningful random graphs: most passes read the output of passes before them.

use raxel_testing::Random;

use crate::model::{Clock, Common, Every, Float, Graph, How, Int, Kind, Pass, Read, Resource, Size, Write};

/// The choices of a seed.
pub(crate) fn random(seed: u64) -> Random {
    Random::new(seed.wrapping_mul(0xD1B5_4A32_D192_ED03))
}

pub(crate) const RATES: [&str; 8] = ["7", "10", "12.5", "20", "23.976", "30", "59.94", "100"];

fn resource(r: &mut Random, number: usize, before: &[Resource], clocked: bool) -> Resource {
    let targets: Vec<usize> = (0..before.len()).filter(|at| before[*at].is_target()).collect();
    let kind = match r.below(10) {
        0..2 if number > 0 => Kind::Words(1 + word(r) % 100),
        2 if !targets.is_empty() => Kind::Of(r.pick(&targets)),
        _ => {
            let fixed = Size::Fixed(r.pick(&[[4, 4], [8, 6], [13, 2], [16, 16]]));
            let size = [Size::Output, Size::Output, Size::Half, fixed][r.below(4)].clone();
            // Half of the smallest output has one mip.
            let mips = if r.percent(15) && size != Size::Half { 2 } else { 1 };
            Kind::Target { size, mips }
        }
    };
    let history = if r.percent(20) { 1 + r.below(2) } else { 0 };
    let filled = r.below(10);
    Resource {
        name: format!("r{number}"),
        kind,
        history,
        clear: (filled < 2).then(|| word(r)),
        init: (filled == 2).then(|| word(r)),
        keep: r.percent(8),
        clock: clocked && number > 0 && r.percent(35),
    }
}

pub(crate) fn graph(r: &mut Random) -> Graph {
    let clocked = r.percent(40);
    let mut resources: Vec<Resource> = Vec::new();
    for number in 0..3 + r.below(6) {
        let next = resource(r, number, &resources, clocked);
        resources.push(next);
    }
    let count = 2 + r.below(6);
    let first = r.below(count);
    let ticking = if clocked { first..(first + 1 + r.below(2)).min(count) } else { 0..0 };
    let start = r.below(count);
    let mut looped = if r.percent(25) { start..(start + 1 + r.below(2)).min(count) } else { 0..0 };
    if looped.clone().any(|at| ticking.contains(&at)) {
        looped = 0..0;
    }
    // The guide does not define the frames in a history of ticks.
    let ticked_history = resources.iter().any(|resource| resource.clock && resource.history > 0);
    let mut passes: Vec<Pass> = Vec::new();
    let mut written: Vec<usize> = Vec::new();
    for number in 0..count {
        let (ticks, in_loop) = (ticking.contains(&number), looped.contains(&number));
        let when = (!ticks && !in_loop && r.percent(12)).then(|| r.percent(50));
        // A pass that is switched off leaves `init` or its earlier output; a cleared resource is the same either way.
        let may_write = |at: usize| {
            (ticks || !resources[at].clock)
                && (when.is_none() || (resources[at].clear.is_some() && resources[at].history == 0))
        };
        let mut writes: Vec<Write> = Vec::new();
        for _ in 0..=r.below(2) {
            let at = r.below(resources.len());
            if may_write(at) && writes.iter().all(|write| write.resource != at) {
                let how = r.pick(&[How::Over, How::Over, How::Over, How::Change, How::Part]);
                writes.push(Write { resource: at, mip: r.below(resources[at].mips()), how });
            }
        }
        if writes.is_empty() {
            let Some(at) = (0..resources.len()).find(|at| may_write(*at)) else { continue };
            writes.push(Write { resource: at, mip: 0, how: How::Over });
        }
        let mut reads: Vec<Read> = Vec::new();
        for _ in 0..r.below(3) {
            let at = if written.is_empty() || r.percent(25) { r.below(resources.len()) } else { r.pick(&written) };
            let history = resources[at].history;
            let age = if history > 0 && r.percent(70) { 1 + r.below(history) } else { 0 };
            // If only a switched-off pass would read some contents, they are not kept for the frame that switches it on.
            let declared = &resources[at];
            let kept = declared.keep || declared.clock || history > 0 || declared.init.or(declared.clear).is_some();
            if when.is_some() && !kept {
                continue;
            }
            let stored = writes.iter().any(|write| write.resource == at);
            if reads.iter().all(|read| read.resource != at) && (age > 0 || !stored) {
                reads.push(Read { resource: at, age, mip: r.below(resources[at].mips()) });
            }
        }
        let every = match r.below(12) {
            _ if ticks => Every::Clock,
            _ if in_loop || when.is_some() => Every::Frame,
            0 => Every::Frames(2 + word(r) % 2),
            1 => Every::Hz(r.pick(&RATES)),
            2 => Every::Still(1 + word(r) % 3),
            _ => Every::Frame,
        };
        let a = match r.below(8) {
            0 => Int::N,
            1 => Int::FrameIndex,
            2 => Int::FrameStill,
            3 if !ticked_history => Int::HistoryValid,
            4 if clocked => Int::Tick,
            5 if in_loop => Int::LoopIndex,
            _ => Int::Value(word(r)),
        };
        let b = match r.below(6) {
            0 => Float::Time,
            1 if clocked => Float::Phase,
            2 if clocked => Float::Delta,
            _ => Float::Value(0.25),
        };
        written.extend(writes.iter().map(|write| write.resource));
        let common = r.percent(25).then(|| Common { u: r.percent(30).then(|| word(r)) });
        passes.push(Pass { name: format!("p{number}"), reads, writes, common, a, b, k: word(r), every, in_loop, when });
    }
    if passes.is_empty() {
        let writes = vec![Write { resource: 0, mip: 0, how: How::Over }];
        let (a, b, every) = (Int::N, Float::Time, Every::Frame);
        passes.push(Pass {
            name: "last".to_owned(),
            reads: Vec::new(),
            writes,
            common: None,
            a,
            b,
            k: 1,
            every,
            in_loop: false,
            when: None,
        });
    }
    let shown = *written.last().unwrap_or(&0);
    let clock = clocked.then(|| Clock { hz: r.pick(&RATES), most: 1 + word(r) % 4 });
    let (rounds, common, n, flag) = (1 + word(r) % 3, word(r), word(r), r.percent(50));
    Graph { name: "random".to_owned(), resources, passes, clock, rounds, common, n, flag, present: shown }
}

pub(crate) fn word(random: &mut Random) -> u32 {
    random.below(1000)
}
