//! One instruction of a module, as its opcode and operands.

use spirv::Op;

/// Most operands of an instruction: its words are counted in 16 bits.
pub(crate) const MAX_OPERANDS: usize = 0xffff - 1;

/// One instruction: its opcode, and its operands without the first word.
#[derive(Clone, Copy)]
pub(crate) struct Instruction<'w> {
    pub opcode: u32,
    pub operands: &'w [u32],
}

impl Instruction<'_> {
    pub(crate) fn is(&self, op: Op) -> bool {
        self.opcode == op as u32
    }

    /// Appends it to the words of a module.
    #[expect(clippy::cast_possible_truncation, reason = "instructions of a module have at most 2¹⁶ words")]
    pub(crate) fn write(&self, words: &mut Vec<u32>) {
        words.push(((self.operands.len() as u32 + 1) << 16) | self.opcode);
        words.extend_from_slice(self.operands);
    }
}
