//! A module whose structure has been checked, the questions that can be asked of it, and the copies that differ from it.

use std::collections::{BTreeSet, HashMap, HashSet};

use spirv::{BuiltIn, Capability, Decoration, ExecutionMode, Op};

use crate::binary::HEADER_WORDS;
use crate::constants::Constants;
use crate::error::{ModuleError, broken};
use crate::instruction::Instruction;
use crate::memory::{Memory, memory};
use crate::print::PrintError;
use crate::reads::Chains;
use crate::record::{self, Checks, Recording};
use crate::undefined::{self, Undefined};
use crate::{bindings, bounds, check, opaque, reads};

/// Most bytes of variables that each thread may have: more than any device keeps at hand, and software drivers take minutes and
/// gigabytes to compile it.
const MAX_PRIVATE: u64 = 64 << 10;

/// A module whose structure has been checked.
pub struct Module<'w> {
    words: &'w [u32],
    instructions: Vec<Instruction<'w>>,
    /// The function that the entry point is.
    entry: u32,
    /// The memory of its variables.
    memory: Memory,
}

impl<'w> Module<'w> {
    /// Looks at a module from end to end, and finds the compute entry point `entry`.
    pub fn new(words: &'w [u32], entry: &str) -> Result<Self, ModuleError> {
        check::header(words)?;
        let bound = words[3];
        let mut instructions = Vec::new();
        let mut rest = &words[HEADER_WORDS..];
        while let Some(first) = rest.first() {
            let count = (first >> 16) as usize;
            if count == 0 || count > rest.len() {
                return broken(format!(
                    "the instruction at word {} says it has {count} words, and {} are left",
                    words.len() - rest.len(),
                    rest.len()
                ));
            }
            instructions.push(Instruction { opcode: first & 0xffff, operands: &rest[1..count] });
            rest = &rest[count..];
        }
        check::ids(&instructions, bound)?;
        check::functions(&instructions)?;
        check::types(&instructions)?;
        let entry = check::find_entry(&instructions, entry)?;
        let memory = memory(&instructions, &HashMap::new());
        if memory.private > MAX_PRIVATE {
            return Err(ModuleError::TooMuch { bytes: memory.private, limit: MAX_PRIVATE });
        }
        Ok(Self { words, instructions, entry, memory })
    }

    /// The words up to the first function: everything about the module's interface. The reflector computes no constants: those that are the
    /// length of an array or a workgroup size have their default as their value, and all others are undefined.
    pub fn declarations(&self) -> Vec<u32> {
        let sizes = self.sizes();
        let mut constants = Constants::new(&self.instructions, &HashMap::new());
        let mut words = self.words[..HEADER_WORDS].to_vec();
        for instruction in self.before_functions() {
            constants.declare(instruction);
            let [ty, id, ..] = instruction.operands else {
                instruction.write(&mut words);
                continue;
            };
            if !instruction.is(Op::SpecConstantOp) {
                instruction.write(&mut words);
            } else if let (true, Some(number)) = (sizes.contains(id), constants.words(*id)) {
                let value = [*ty, *id].into_iter().chain(number).collect::<Vec<_>>();
                Instruction { opcode: Op::Constant as u32, operands: &value }.write(&mut words);
            } else {
                words.extend([(3 << 16) | Op::Undef as u32, *ty, *id]);
            }
        }
        words
    }

    /// Ids of constants that are the length of an array or a workgroup size.
    fn sizes(&self) -> HashSet<u32> {
        let mut sizes: HashSet<u32> = self.of(Op::TypeArray).filter_map(|operands| operands.get(2)).copied().collect();
        if let WorkgroupSize::Ids(ids) = self.workgroup_size() {
            sizes.extend(ids);
        }
        sizes
    }

    /// Whether a constant is computed from a value that a function computes. No module may do so, but the GLSL compiler makes such modules of `&&`
    /// and `||` whose second side is long.
    pub fn has_late_constants(&self) -> bool {
        let late: HashSet<u32> = self.of(Op::Phi).filter_map(|operands| operands.get(1)).copied().collect();
        // The other operands of these are no ids.
        let counted = [Op::CompositeExtract, Op::CompositeInsert, Op::VectorShuffle].map(|op| op as u32);
        self.of(Op::SpecConstantOp).any(|operands| match operands {
            [_, _, op, operands @ ..] => !counted.contains(op) && operands.iter().any(|id| late.contains(id)),
            _ => false,
        })
    }

    /// Names of the capabilities beyond `Shader` (and `Matrix`, which it implies).
    pub fn capabilities(&self) -> Vec<String> {
        let names: BTreeSet<String> = self
            .of(Op::Capability)
            .filter_map(|operands| operands.first())
            .map(|id| Capability::from_u32(*id).map_or_else(|| format!("{id}"), |name| format!("{name:?}")))
            .filter(|name| name != "Shader" && name != "Matrix")
            .collect();
        names.into_iter().collect()
    }

    /// The memory of the variables, with the defaults of specialization constants.
    pub fn memory(&self) -> Memory {
        self.memory
    }

    /// The memory of the variables, with these bits of specialization constants by their number.
    pub fn memory_with(&self, specialized: &HashMap<u32, u32>) -> Memory {
        memory(&self.instructions, specialized)
    }

    /// Workgroup size: three literals, or three ids of constants.
    pub fn workgroup_size(&self) -> WorkgroupSize {
        // A constant decorated as `WorkgroupSize` wins over the execution mode (Vulkan 1.3, "Interfaces with built-in variables").
        let decorated = self.of(Op::Decorate).find_map(|operands| match operands {
            [id, decoration, builtin]
                if *decoration == Decoration::BuiltIn as u32 && *builtin == BuiltIn::WorkgroupSize as u32 =>
            {
                Some(*id)
            }
            _ => None,
        });
        if let Some(id) = decorated {
            for instruction in &self.instructions {
                let composite = instruction.is(Op::ConstantComposite) || instruction.is(Op::SpecConstantComposite);
                if let [_, result, x, y, z] = instruction.operands
                    && composite
                    && *result == id
                {
                    return WorkgroupSize::Ids([*x, *y, *z]);
                }
            }
        }
        for operands in self.of(Op::ExecutionMode).chain(self.of(Op::ExecutionModeId)) {
            if let [entry, mode, x, y, z] = operands
                && *entry == self.entry
            {
                if *mode == ExecutionMode::LocalSize as u32 {
                    return WorkgroupSize::Literals([*x, *y, *z]);
                }
                if *mode == ExecutionMode::LocalSizeId as u32 {
                    return WorkgroupSize::Ids([*x, *y, *z]);
                }
            }
        }
        WorkgroupSize::Literals([1, 1, 1])
    }

    /// Ids that the entry point uses as the base of an access, directly or through the functions it calls. Global variables that are
    /// not among them are declared and never touched.
    pub fn used_ids(&self) -> HashSet<u32> {
        self.reachable().into_iter().flatten().flat_map(accessed).copied().collect()
    }

    /// How each of these variables, all of them blocks, is accessed.
    pub fn chains(&self, variables: &HashSet<u32>) -> HashMap<u32, Chains> {
        reads::chains(self.before_functions(), self.reachable().into_iter().flatten(), variables)
    }

    /// Calls whose result is undefined for all their other arguments, in the functions that the entry point reaches.
    pub fn undefined(&self) -> Vec<Undefined> {
        undefined::undefined(self.before_functions(), self.reachable().into_iter())
    }

    fn before_functions(&self) -> &[Instruction<'w>] {
        let functions = self.instructions.iter().position(|instruction| instruction.is(Op::Function));
        &self.instructions[..functions.unwrap_or(self.instructions.len())]
    }

    /// The instructions of the entry point and of every function that it calls, directly or through others.
    fn reachable(&self) -> Vec<&[Instruction<'w>]> {
        let mut bodies: HashMap<u32, &[Instruction<'w>]> = HashMap::new();
        let mut start = None;
        for (at, instruction) in self.instructions.iter().enumerate() {
            if instruction.is(Op::Function) {
                start = instruction.operands.get(1).map(|id| (*id, at + 1));
            } else if let (true, Some((id, start))) = (instruction.is(Op::FunctionEnd), start) {
                bodies.insert(id, &self.instructions[start..at]);
            }
        }
        let mut seen = HashSet::from([self.entry]);
        let mut open = vec![self.entry];
        let mut reachable = Vec::new();
        while let Some(function) = open.pop() {
            let Some(body) = bodies.get(&function).copied() else { continue };
            let calls = body.iter().filter(|instruction| instruction.is(Op::FunctionCall));
            open.extend(calls.filter_map(|call| call.operands.get(2)).copied().filter(|call| seen.insert(*call)));
            reachable.push(body);
        }
        reachable
    }

    /// Variables whose block, or array of blocks, is decorated as `BufferBlock`: storage buffers of modules before SPIR-V 1.3.
    pub fn buffer_blocks(&self) -> HashSet<u32> {
        let decorated = |operands: &[u32]| (operands[1] == Decoration::BufferBlock as u32).then_some(operands[0]);
        let mut types: HashSet<u32> =
            self.of(Op::Decorate).filter(|operands| operands.len() == 2).filter_map(decorated).collect();
        for instruction in &self.instructions {
            match instruction.operands {
                [id, block, ..] if instruction.is(Op::TypeArray) && types.contains(block) => types.insert(*id),
                [id, _, block] if instruction.is(Op::TypePointer) && types.contains(block) => types.insert(*id),
                _ => continue,
            };
        }
        self.of(Op::Variable).filter(|operands| types.contains(&operands[0])).map(|operands| operands[1]).collect()
    }

    /// The module with a place of its own for each binding; `None` when it has that already.
    pub fn with_separate_bindings(&self) -> Option<Vec<u32>> {
        let numbers = bindings::renumbered(&self.instructions, &self.used_ids())?;
        let mut words = self.words[..HEADER_WORDS].to_vec();
        for instruction in &self.instructions {
            bindings::write(instruction, &numbers, &mut words);
        }
        Some(words)
    }

    /// The module with every access to shared memory inside its array, vector or matrix; `None` when it is so already.
    ///
    /// # Errors
    /// When a bound cannot be written into the module.
    pub fn with_shared_bounds(&self) -> Result<Option<Vec<u32>>, ModuleError> {
        bounds::bounded(self.words, &self.instructions)
    }

    /// The module that records into the storage buffer at `binding` of set 0 its prints and what `checks` asks for; `None` when it records
    /// nothing.
    ///
    /// # Errors
    /// When it prints values other than numbers of 32 bits, booleans and vectors of them, or has too many such calls, accesses or writes.
    pub fn with_records(&self, binding: u32, checks: Checks) -> Result<Option<Recording>, PrintError> {
        record::recording(self.words, &self.instructions, binding, checks)
    }

    /// The module with values of uniform blocks and push constants that no driver can fold into it; `None` when it has none of them, or no room
    /// for the instructions.
    pub fn with_opaque_uniforms(&self) -> Option<Vec<u32>> {
        opaque::opaque(self.words, &self.instructions)
    }

    fn of(&self, op: Op) -> impl Iterator<Item = &'w [u32]> {
        self.instructions.iter().filter(move |instruction| instruction.is(op)).map(|instruction| instruction.operands)
    }

    /// The module without the texts and line numbers that only a debugger reads. Names stay: validation messages use them.
    pub fn without_debug_text(&self) -> Vec<u32> {
        let mut words = self.words[..HEADER_WORDS].to_vec();
        for instruction in &self.instructions {
            let debug =
                [Op::Source, Op::SourceContinued, Op::SourceExtension, Op::Line, Op::NoLine, Op::ModuleProcessed];
            if !debug.iter().any(|op| instruction.is(*op)) {
                instruction.write(&mut words);
            }
        }
        words
    }
}

/// Workgroup size as the module has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkgroupSize {
    /// Three numbers.
    Literals([u32; 3]),
    /// Ids of three constants.
    Ids([u32; 3]),
}

/// The operands of an instruction in a function that may be variables being accessed. Of opcodes that are not known here, all.
pub(crate) fn accessed<'w>(instruction: &Instruction<'w>) -> &'w [u32] {
    let operands = instruction.operands;
    let range = match instruction.opcode {
        // Function call: result type, result, function, arguments.
        57 => 3..operands.len(),
        // Image texel pointer, load, access chains, array length, copy object; atomics with a result.
        60 | 61 | 65..=68 | 70 | 83 | 227 | 229..=242 | 318 | 5614 | 5615 | 6035 => 2..3,
        // Store, atomic store, atomic flag clear; return, which may give a pointer; copy memory (sized).
        62 | 228 | 254 | 319 => 0..1,
        63 | 64 => 0..2,
        // Extended instruction: result type, result, set, number, arguments.
        12 => 4..operands.len(),
        // Select and phi may choose between pointers.
        169 | 245 => 2..operands.len(),
        // The rest of the core instructions take values, and their operands may be literals.
        0..=400 => 0..0,
        _ => 0..operands.len(),
    };
    operands.get(range).unwrap_or(&[])
}
