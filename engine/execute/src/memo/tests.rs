//! The memo against a machine that runs everything.

use super::*;

fn mix(hash: u64, value: u64) -> u64 {
    digest::of_bytes(hash, &value.to_ne_bytes()) as u64
}

/// A machine that holds a number for each mip of each copy, and runs nodes on them.
struct Machine {
    values: Vec<u64>,
    picture: u64,
}

/// The machine finds copies by itself.
fn contents(memo: &Memo, access: &SlotAccess, frame: u64) -> std::ops::Range<usize> {
    let slot = &memo.slots[access.slot as usize];
    let first = slot.base(frame, access.age) + access.mips.0 as usize;
    first..first + access.mips.1 as usize
}

impl Machine {
    fn run(&mut self, memo: &Memo, frame: u64, keys: &[Option<Digest>], present: Digest, run: &[bool]) {
        for node in &memo.nodes {
            let Some(key) = node.key(&[], &Ticks::default(), keys, present).filter(|_| run[node.step as usize]) else {
                continue;
            };
            let mut hash = mix(node.maker.salt(), key as u64);
            for access in node.accesses.iter().filter(|t| t.reads) {
                for value in &self.values[contents(memo, access, frame)] {
                    hash = mix(hash, *value);
                }
            }
            for (i, access) in node.accesses.iter().enumerate().filter(|(_, t)| t.writes) {
                for (mip, value) in self.values[contents(memo, access, frame)].iter_mut().enumerate() {
                    *value = mix(mix(hash, i as u64), mip as u64);
                }
            }
            if node.maker == Maker::Present {
                self.picture = hash;
            }
        }
        // Aliased memory is another's when the frame ends.
        for slot in memo.slots.iter().filter(|slot| slot.aliased) {
            for copy in 0..slot.copies {
                self.values[slot.copy_range(copy)].fill(0xdead ^ frame);
            }
        }
    }
}

struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = mix(self.0, 1);
        self.0 % n
    }
}

/// A read of these mips of a slot, in the same frame.
fn read(slot: u32, mips: (u32, u32)) -> SlotAccess {
    let selector = CopySelector::Frame;
    SlotAccess { slot, age: 0, selector, base: 0, whole: true, mips, reads: true, writes: false, seen: 0 }
}

/// A write of these mips of a slot.
fn write(slot: u32, mips: (u32, u32)) -> SlotAccess {
    SlotAccess { reads: false, writes: true, ..read(slot, mips) }
}

/// A random frame: transient slots are written before they are read, as a plan guarantees.
fn random_memo(random: &mut Random) -> (Memo, usize) {
    let passes = 2 + random.below(6) as usize;
    let mut memo = Memo::empty(passes + 4);
    let slots = 2 + random.below(4) as u32;
    for _ in 0..slots {
        let transient = random.below(2) == 0;
        let copies = if transient { 1 } else { 1 + random.below(3) as u32 };
        memo.slot(copies, 1 + random.below(3) as u32, transient && random.below(2) == 0, transient);
    }
    let mut written = vec![false; slots as usize];
    let mut step = 0;
    for pass in 0..passes as u32 {
        let mut accesses: Vec<SlotAccess> = Vec::new();
        for _ in 0..=random.below(3) {
            let slot = random.below(u64::from(slots)) as u32;
            let Slot { copies, mips, transient, .. } = memo.slots[slot as usize];
            if accesses.iter().any(|t| t.slot == slot) {
                continue;
            }
            if transient && !written[slot as usize] {
                accesses.push(write(slot, (0, mips)));
            } else if random.below(2) == 0 {
                let first = random.below(u64::from(mips)) as u32;
                accesses.push(SlotAccess { reads: random.below(3) == 0, ..write(slot, (first, 1)) });
            } else {
                let age = random.below(u64::from(copies)) as u32;
                accesses.push(SlotAccess { age, ..read(slot, (0, mips)) });
            }
        }
        for access in accesses.iter().filter(|t| t.writes) {
            written[access.slot as usize] = true;
        }
        if random.below(8) == 0 {
            let slot = random.below(u64::from(slots)) as u32;
            let mips = memo.slots[slot as usize].mips;
            let access = write(slot, (0, mips));
            if step < 3 {
                written[slot as usize] = true;
                memo.node(step, None, Maker::Clear(7), vec![access]);
                step += 1;
            }
        }
        memo.node(step, None, Maker::Pass { pass, salt: pass }, accesses);
        step += 1;
    }
    let shown = (0..slots).find(|s| !memo.slots[*s as usize].transient || written[*s as usize]);
    let access = shown.map(|slot| read(slot, (0, 1)));
    memo.node(step, None, Maker::Present, access.into_iter().collect());
    memo.finish();
    (memo, passes)
}

#[test]
fn skipping_never_changes_a_result() {
    let mut skipped = 0_u32;
    for seed in 0..4000 {
        let random = &mut Random(seed);
        let (mut memo, passes) = random_memo(random);
        // By the plan's rule, passes that are not always due have only persistent outputs. So gate no pass here that writes
        // something transient.
        let gated: Vec<bool> = memo
            .nodes
            .iter()
            .filter(|n| matches!(n.maker, Maker::Pass { pass: _, salt: _ }))
            .map(|n| n.accesses.iter().all(|t| !memo.slots[t.slot as usize].transient))
            .collect();
        let start = || Machine { values: (0..memo.content.len() as u64).map(|i| mix(9, i)).collect(), picture: 0 };
        let (mut full, mut lean) = (start(), start());
        let mut keys: Vec<Option<Digest>> = (0..passes as Digest).map(Some).collect();
        let mut present = 0;
        for frame in 0..12 {
            if frame % 3 == 2 {
                let which = random.below(passes as u64) as usize;
                keys[which] = if gated[which] && random.below(3) == 0 { None } else { Some(random.below(4).into()) };
            }
            if random.below(9) == 0 {
                present = random.below(3).into();
            }
            let all = vec![true; memo.run.len()];
            full.run(&memo, frame, &keys, present, &all);
            let run = memo.decide(frame, &Ticks::default(), &keys, present).to_vec();
            lean.run(&memo, frame, &keys, present, &run);
            skipped += memo.nodes.iter().filter(|n| !run[n.step as usize]).count() as u32;
            for slot in memo.slots.iter().filter(|slot| !slot.aliased) {
                for copy in 0..slot.copies {
                    let range = slot.copy_range(copy);
                    assert_eq!(full.values[range.clone()], lean.values[range], "seed {seed} frame {frame}: {memo:#?}");
                }
            }
            assert_eq!(full.picture, lean.picture, "seed {seed} frame {frame}");
        }
    }
    assert!(skipped > 50_000, "only {skipped} steps were skipped");
}

/// `a` (transient, aliased) → `b` (persistent) → picture.
fn chain() -> Memo {
    let mut memo = Memo::empty(3);
    memo.slot(1, 1, true, true);
    memo.slot(1, 1, false, false);
    memo.node(0, None, Maker::Pass { pass: 0, salt: 0 }, vec![write(0, (0, 1))]);
    memo.node(1, None, Maker::Pass { pass: 1, salt: 1 }, vec![read(0, (0, 1)), write(1, (0, 1))]);
    memo.node(2, None, Maker::Present, vec![read(1, (0, 1))]);
    memo.finish();
    memo
}

#[test]
fn a_still_frame_runs_nothing() {
    let mut memo = chain();
    let keys = [Some(1), Some(2)];
    assert_eq!(memo.decide(0, &Ticks::default(), &keys, 0), [true; 3]);
    assert_eq!(memo.decide(1, &Ticks::default(), &keys, 0), [false; 3]);
    // Another display reruns the picture only; a changed pass reruns the makers of its inputs.
    assert_eq!(memo.decide(2, &Ticks::default(), &keys, 1), [false, false, true]);
    assert_eq!(memo.decide(3, &Ticks::default(), &[Some(1), Some(9)], 1), [true; 3]);
    memo.forget();
    assert_eq!(memo.decide(4, &Ticks::default(), &[Some(1), Some(9)], 1), [true; 3]);
}

#[test]
fn accumulation_always_runs() {
    let mut memo = Memo::empty(2);
    memo.slot(1, 1, false, false);
    memo.node(0, None, Maker::Pass { pass: 0, salt: 0 }, vec![SlotAccess { reads: true, ..write(0, (0, 1)) }]);
    memo.node(1, None, Maker::Present, vec![read(0, (0, 1))]);
    memo.finish();
    for frame in 0..4 {
        assert_eq!(memo.decide(frame, &Ticks::default(), &[Some(1)], 0), [true; 2]);
    }
}
