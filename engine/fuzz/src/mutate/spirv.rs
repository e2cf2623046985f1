//! Changes of SPIR-V instruction by instruction: a change of single bits hardly ever leaves a module that a reader gets to the end of.
#![expect(
    clippy::cast_possible_truncation,
    reason = "random words are the lowest of random bits, and an input is far below 2³² words"
)]

use std::collections::HashMap;

use raxel_world::random::SplitMix64;

use super::{binary, pick};

/// Words before the first instruction.
const HEADER: usize = 5;

/// Opcodes of declarations, accesses and arithmetic that raxel looks at, beside those of the module itself: extended instructions, types, constants,
/// variables, access chains, conversions, integers, bits, copies.
const OPCODES: [u32; 48] = [
    1, 5, 6, 10, 11, 12, 15, 16, 17, 19, 20, 21, 22, 23, 24, 25, 28, 29, 30, 32, 33, 41, 43, 44, 46, 48, 50, 51, 52,
    54, 55, 56, 57, 59, 61, 62, 65, 66, 67, 71, 72, 83, 113, 128, 137, 199, 245, 331,
];

/// Opcodes with a type, a result and two operands of that type: integers, floats, bits.
const SAME_SHAPE: [&[u32]; 2] =
    [&[128, 130, 132, 134, 135, 137, 138, 139, 194, 195, 196, 197, 198, 199], &[129, 131, 133, 136, 140, 141]];

/// Opcodes whose last operand is a number: constants, decorations, modes, extractions.
const NUMBERED: [u32; 6] = [16, 43, 50, 71, 72, 81];

/// Changes instructions one to four times; rarely single bytes.
pub(super) fn mutated(input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let (Some(mut module), Some(other)) = (Words::of(input), Words::of(other)) else {
        return binary::mutated(input, input, random);
    };
    if random.below(16) == 0 {
        return binary::mutated(input, input, random);
    }
    // A module that a change broke is mostly refused for it, so that later changes hardly matter.
    for _ in 0..=random.below(3) {
        if random.below(4) == 0 { module.change(&other, random) } else { module.turn(random) }
    }
    module.bytes()
}

/// A module cut into instructions.
struct Words {
    header: [u32; HEADER],
    /// Opcode and operands.
    instructions: Vec<(u32, Vec<u32>)>,
}

impl Words {
    /// Reads as many instructions as there are.
    fn of(bytes: &[u8]) -> Option<Self> {
        let words: Vec<u32> =
            bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect();
        let (header, mut rest) = words.split_first_chunk::<HEADER>()?;
        let mut instructions = Vec::new();
        while let Some(first) = rest.first() {
            let count = ((first >> 16) as usize).clamp(1, rest.len());
            instructions.push((first & 0xffff, rest[1..count].to_vec()));
            rest = &rest[count..];
        }
        (!instructions.is_empty()).then_some(Self { header: *header, instructions })
    }

    fn bytes(&self) -> Vec<u8> {
        let instructions = self.instructions.iter().flat_map(|(opcode, operands)| {
            std::iter::once(((operands.len() as u32 + 1) << 16) | opcode).chain(operands.iter().copied())
        });
        self.header.iter().copied().chain(instructions).flat_map(u32::to_le_bytes).collect()
    }

    /// The kind of each id that is declared before an instruction: a type, by its opcode, or a value, by its type.
    fn kinds(&self, before: usize) -> HashMap<u32, (bool, u32)> {
        let mut kinds = HashMap::new();
        for (opcode, operands) in &self.instructions[..before] {
            match operands.as_slice() {
                [id, ..] if (19..=33).contains(opcode) => kinds.insert(*id, (true, *opcode)),
                [ty, id, ..] if kinds.get(ty).is_some_and(|(is_type, _)| *is_type) => kinds.insert(*id, (false, *ty)),
                _ => continue,
            };
        }
        kinds
    }

    /// A change after which the module may well be valid.
    fn turn(&mut self, random: &mut SplitMix64) {
        let at = random.index(self.instructions.len());
        match random.below(8) {
            // Another id of the same kind.
            0..=3 => {
                let kinds = self.kinds(at);
                let operands = &mut self.instructions[at].1;
                let known: Vec<usize> = (0..operands.len()).filter(|i| kinds.contains_key(&operands[*i])).collect();
                let Some(operand) = pick(random, &known) else { return };
                let kind = kinds[&operands[*operand]];
                let mut same: Vec<u32> = kinds.iter().filter(|(_, other)| **other == kind).map(|(id, _)| *id).collect();
                same.sort_unstable();
                operands[*operand] = pick(random, &same).copied().unwrap_or_default();
            }
            4 | 5 => {
                let all = 0..self.instructions.len();
                let numbered: Vec<usize> = all.filter(|at| NUMBERED.contains(&self.instructions[*at].0)).collect();
                let Some(number) = pick(random, &numbered).and_then(|at| self.instructions[*at].1.last_mut()) else {
                    return;
                };
                *number = match random.below(4) {
                    0 => pick(random, &binary::NUMBERS).copied().unwrap_or_default(),
                    1 => random.below(70) as u32,
                    2 => *number ^ (1 << random.below(32)),
                    _ => number.wrapping_add(random.below(9) as u32).wrapping_sub(4),
                };
            }
            6 => {
                let opcode = &mut self.instructions[at].0;
                if let Some(same) = SAME_SHAPE.iter().find(|same| same.contains(opcode)) {
                    *opcode = pick(random, same).copied().unwrap_or_default();
                }
            }
            // The same once more, with a result of its own.
            _ => {
                let (opcode, mut operands) = self.instructions[at].clone();
                let typed =
                    operands.first().is_some_and(|ty| self.kinds(at).get(ty).is_some_and(|(is_type, _)| *is_type));
                if typed && operands.len() > 1 {
                    operands[1] = self.header[3];
                    self.header[3] = self.header[3].wrapping_add(1);
                }
                self.instructions.insert(at + 1, (opcode, operands));
            }
        }
    }

    fn change(&mut self, other: &Self, random: &mut SplitMix64) {
        let count = self.instructions.len();
        let (at, to) = (random.index(count), random.index(count));
        let bound = self.header[3];
        match random.below(16) {
            // An operand: another id, a number on the edge of something, one that stands elsewhere, or one near.
            0..=7 => {
                let elsewhere = pick(random, &self.instructions[to].1).copied();
                let operands = &mut self.instructions[at].1;
                if operands.is_empty() {
                    return;
                }
                let operand = random.index(operands.len());
                let old = operands[operand];
                operands[operand] = match random.below(8) {
                    0..=2 => random.below(u64::from(bound.clamp(1, 1 << 20)) + 2) as u32,
                    3 | 4 => elsewhere.unwrap_or_default(),
                    5 => pick(random, &binary::NUMBERS).copied().unwrap_or_default(),
                    6 => old ^ (1 << random.below(32)),
                    _ => old.wrapping_add(random.below(9) as u32).wrapping_sub(4),
                };
            }
            8 => self.instructions[at].0 = pick(random, &OPCODES).copied().unwrap_or_default(),
            9 => {
                let opcode = self.instructions[at].0;
                self.instructions[at].0 = opcode.wrapping_add(random.below(5) as u32).wrapping_sub(2) & 0xffff;
            }
            10 => drop(self.instructions.remove(at)),
            11 => self.instructions.swap(at, to),
            // The same once more, with a result of its own where the bound allows one.
            12 => {
                let mut copy = self.instructions[at].clone();
                if let Some(result) = copy.1.get_mut(random.index(2)) {
                    *result = bound;
                    self.header[3] = bound.wrapping_add(1);
                }
                self.instructions.insert(to, copy);
            }
            13 => {
                let from = random.index(other.instructions.len());
                self.instructions.insert(at, other.instructions[from].clone());
            }
            14 => {
                let operands = &mut self.instructions[at].1;
                if random.below(2) == 0 {
                    operands.truncate(random.index(operands.len() + 1));
                } else {
                    operands.push(random.below(u64::from(bound.clamp(1, 1 << 20)) + 2) as u32);
                }
            }
            _ => {
                let word = random.index(HEADER);
                self.header[word] = match (word, random.below(2)) {
                    (1, 0) => 0x0001_0000 + 0x100 * random.below(8) as u32,
                    (3, 0) => bound.wrapping_add(random.below(9) as u32).wrapping_sub(4),
                    _ => pick(random, &binary::NUMBERS).copied().unwrap_or_default(),
                };
            }
        }
        if self.instructions.is_empty() {
            self.instructions.push((0, Vec::new()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_changed_stays() {
        let bytes: Vec<u8> =
            [0x0723_0203, 0x0001_0500, 0, 9, 0, 0x0002_0011, 1, 0x0003_000e, 0, 1].map(u32::to_le_bytes).concat();
        let module = Words::of(&bytes).unwrap();
        assert_eq!(module.instructions, [(17, vec![1]), (14, vec![0, 1])]);
        assert_eq!(module.bytes(), bytes);
        assert!(Words::of(&bytes[..20]).is_none() && Words::of(b"").is_none());
        let made = |seed| mutated(&bytes, &bytes, &mut SplitMix64::new(seed));
        assert!((0..2000).all(|seed| made(seed) == made(seed)));
    }
}
