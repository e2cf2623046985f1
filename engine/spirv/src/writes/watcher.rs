//! The function that compares a write with the watched texel.

use spirv::{FunctionControl, Op, SelectionControl};

use super::{VALUES, Writes};
use crate::additions::write;
use crate::print::RECORDS;
use crate::record::Writer;

impl Writes {
    /// The function that compares a write with the texel, and records it: word of the image, x, y, layer, number of the write, value.
    pub(super) fn watcher(&mut self, writer: &mut Writer) -> u32 {
        if let Some(known) = self.watcher {
            return known;
        }
        let (void, bool, uint, word) = (writer.void, writer.bool, writer.uint, writer.word);
        let recorder = writer.recorder(VALUES as usize, RECORDS);
        let [zero, one, first] = [0, 1, self.found.first_word].map(|value| writer.constant(value));
        let texel = [0, 1].map(|axis| writer.constant(self.found.texel_word + axis));
        let parameters = vec![uint; 4 + VALUES as usize];
        let ty = writer.additions.ty(Op::TypeFunction, &[&[void], parameters.as_slice()].concat());
        let buffer = writer.buffer;
        let mut body = Vec::new();
        let mut op = |op: Op, operands: &[u32]| write(op, operands, &mut body);
        let additions = &mut writer.additions;
        let [function, start, then, end, recorded] = [(); 5].map(|()| additions.id());
        let parameters: Vec<u32> = parameters.iter().map(|_| additions.id()).collect();
        op(Op::Function, &[void, function, FunctionControl::NONE.bits(), ty]);
        for parameter in &parameters {
            op(Op::FunctionParameter, &[uint, *parameter]);
        }
        op(Op::Label, &[start]);
        let [image, x, y, layer] = parameters[..4] else { unreachable!("there are at least four parameters") };
        let mut load = |at: u32, op: &mut dyn FnMut(Op, &[u32])| {
            let [place, loaded] = [(); 2].map(|()| additions.id());
            op(Op::AccessChain, &[word, place, buffer, zero, at]);
            op(Op::Load, &[uint, loaded, place]);
            loaded
        };
        let watched = [image, texel[0], texel[1]].map(|at| load(at, &mut op));
        let [is_watched, next, is_layer, is_x, is_y] = [(); 5].map(|()| additions.id());
        op(Op::INotEqual, &[bool, is_watched, watched[0], zero]);
        op(Op::IAdd, &[uint, next, layer, one]);
        op(Op::IEqual, &[bool, is_layer, watched[0], next]);
        op(Op::IEqual, &[bool, is_x, watched[1], x]);
        op(Op::IEqual, &[bool, is_y, watched[2], y]);
        let mut same = is_watched;
        for other in [is_layer, is_x, is_y] {
            let both = additions.id();
            op(Op::LogicalAnd, &[bool, both, same, other]);
            same = both;
        }
        op(Op::SelectionMerge, &[end, SelectionControl::NONE.bits()]);
        op(Op::BranchConditional, &[same, then, end]);
        op(Op::Label, &[then]);
        op(Op::FunctionCall, &[&[void, recorded, recorder, first], &parameters[4..]].concat());
        op(Op::Branch, &[end]);
        op(Op::Label, &[end]);
        op(Op::Return, &[]);
        op(Op::FunctionEnd, &[]);
        writer.functions.extend_from_slice(&body);
        self.watcher = Some(function);
        function
    }
}
