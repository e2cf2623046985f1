//! Looks at a module from end to end before anything relies on it.

use std::collections::{HashMap, HashSet};

use spirv::{ExecutionModel, Op};

use crate::binary::{HEADER_WORDS, MAX_WORDS};
use crate::error::{ModuleError, broken};
use crate::instruction::Instruction;

/// Largest id bound (the limit of the specification, section 2.17).
pub(crate) const MAX_BOUND: u32 = 4_194_303;
/// Deepest nesting of types (the specification allows structs of 255; no layout in a block comes near).
const MAX_TYPE_DEPTH: u32 = 64;
/// Most nodes that all types have together when every use of a type is written out. The reflector writes them out.
const MAX_TYPE_NODES: u64 = 1 << 20;

const MAGIC: u32 = 0x0723_0203;

pub(crate) fn header(words: &[u32]) -> Result<(), ModuleError> {
    if words.len() < HEADER_WORDS {
        return broken(format!("the file has {} words, fewer than the {HEADER_WORDS} of a header", words.len()));
    }
    if words.len() > MAX_WORDS {
        return Err(ModuleError::Unsupported(format!("the module has more than {MAX_WORDS} words")));
    }
    if words[0] == MAGIC.swap_bytes() {
        return Err(ModuleError::Unsupported("the module has the other byte order".to_owned()));
    }
    if words[0] != MAGIC {
        return broken(format!("the file starts with {:#010x}, not with SPIR-V's {MAGIC:#010x}", words[0]));
    }
    let (major, minor) = ((words[1] >> 16) & 0xff, (words[1] >> 8) & 0xff);
    if words[1] & 0xff00_00ff != 0 || major != 1 {
        return broken(format!("the header has version {:#010x}, which does not exist", words[1]));
    }
    if minor > 6 {
        return Err(ModuleError::Unsupported(format!("the module is SPIR-V 1.{minor}, and raxel reads up to 1.6")));
    }
    if words[3] == 0 || words[3] > MAX_BOUND {
        return broken(format!("the id bound is {}, not 1 to {MAX_BOUND}", words[3]));
    }
    if words[4] != 0 {
        return broken(format!("the header's last word is {}, not 0", words[4]));
    }
    Ok(())
}

/// Where an instruction that declares something has its result id.
fn result_of(instruction: &Instruction<'_>) -> Option<usize> {
    use Op as O;
    let first = [
        O::ExtInstImport,
        O::TypeVoid,
        O::TypeBool,
        O::TypeInt,
        O::TypeFloat,
        O::TypeVector,
        O::TypeMatrix,
        O::TypeImage,
        O::TypeSampler,
        O::TypeSampledImage,
        O::TypeArray,
        O::TypeRuntimeArray,
        O::TypeStruct,
        O::TypePointer,
        O::TypeFunction,
        O::TypeForwardPointer,
        O::Label,
        O::String,
    ];
    let second = [
        O::ConstantTrue,
        O::ConstantFalse,
        O::Constant,
        O::ConstantComposite,
        O::ConstantNull,
        O::SpecConstantTrue,
        O::SpecConstantFalse,
        O::SpecConstant,
        O::SpecConstantComposite,
        O::SpecConstantOp,
        O::Variable,
        O::Function,
        O::FunctionParameter,
    ];
    if first.iter().any(|op| instruction.is(*op)) {
        Some(0)
    } else if second.iter().any(|op| instruction.is(*op)) {
        Some(1)
    } else {
        None
    }
}

/// Every declaration has an id inside the bound, and declares it once.
pub(crate) fn ids(instructions: &[Instruction<'_>], bound: u32) -> Result<(), ModuleError> {
    let mut declared = vec![false; bound as usize];
    for instruction in instructions {
        let Some(position) = result_of(instruction) else { continue };
        let Some(id) = instruction.operands.get(position).copied() else {
            return broken(format!("an instruction of opcode {} has no result id", instruction.opcode));
        };
        if id == 0 || id >= bound {
            return broken(format!("id {id} is outside the bound of {bound}"));
        }
        if !instruction.is(Op::TypeForwardPointer) && std::mem::replace(&mut declared[id as usize], true) {
            return broken(format!("id {id} is declared twice"));
        }
    }
    Ok(())
}

/// Functions begin and end in turn, there is one, and all that are called are there.
pub(crate) fn functions(instructions: &[Instruction<'_>]) -> Result<(), ModuleError> {
    let mut inside = false;
    let (mut declared, mut called) = (HashSet::<u32>::new(), HashSet::<u32>::new());
    for instruction in instructions {
        let begins = instruction.is(Op::Function);
        if begins && inside || instruction.is(Op::FunctionEnd) && !inside {
            return broken("functions are not properly ended");
        }
        if begins {
            declared.extend(instruction.operands.get(1));
        } else if instruction.is(Op::FunctionCall) {
            called.extend(instruction.operands.get(2));
        }
        inside = (inside || begins) && !instruction.is(Op::FunctionEnd);
    }
    if inside || declared.is_empty() {
        return broken("the last function is cut off");
    }
    match called.difference(&declared).min() {
        Some(missing) => broken(format!("function {missing} is called and not there")),
        None => Ok(()),
    }
}

/// Types are declared after their parts, and written out they are not too deep and not too many.
pub(crate) fn types(instructions: &[Instruction<'_>]) -> Result<(), ModuleError> {
    let mut known: HashMap<u32, (u32, u64)> = HashMap::new();
    let mut total = 0u64;
    for instruction in instructions {
        let parts: &[u32] = match Op::from_u32(instruction.opcode) {
            Some(
                Op::TypeVector
                | Op::TypeMatrix
                | Op::TypeImage
                | Op::TypeSampledImage
                | Op::TypeArray
                | Op::TypeRuntimeArray,
            ) => part(instruction, 1..2)?,
            Some(Op::TypePointer) => part(instruction, 2..3)?,
            Some(Op::TypeStruct) => &instruction.operands[1..],
            Some(Op::TypeVoid | Op::TypeBool | Op::TypeInt | Op::TypeFloat | Op::TypeSampler) => &[],
            _ => continue,
        };
        let (mut depth, mut nodes) = (0, 1u64);
        for id in parts {
            // A part that is not known yet is a forward pointer, which has no parts of its own for the reflector.
            let (part_depth, part_nodes) = known.get(id).copied().unwrap_or((0, 1));
            depth = depth.max(part_depth);
            nodes = nodes.saturating_add(part_nodes);
        }
        total = total.saturating_add(nodes);
        if depth >= MAX_TYPE_DEPTH || total > MAX_TYPE_NODES {
            return broken("its types are nested too deep or written out too large");
        }
        known.insert(instruction.operands[0], (depth + 1, nodes));
    }
    // A variable copies its type once more.
    for instruction in instructions.iter().filter(|instruction| instruction.is(Op::Variable)) {
        let nodes = instruction.operands.first().and_then(|ty| known.get(ty)).map_or(1, |(_, nodes)| *nodes);
        total = total.saturating_add(nodes);
        if total > MAX_TYPE_NODES {
            return broken("its variables are too many for their types");
        }
    }
    Ok(())
}

fn part<'w>(instruction: &Instruction<'w>, range: std::ops::Range<usize>) -> Result<&'w [u32], ModuleError> {
    instruction
        .operands
        .get(range)
        .ok_or_else(|| ModuleError::Broken(format!("a type of opcode {} is cut off", instruction.opcode)))
}

pub(crate) fn find_entry(instructions: &[Instruction<'_>], entry: &str) -> Result<u32, ModuleError> {
    let mut found = Vec::new();
    let mut ids = Vec::new();
    for instruction in instructions.iter().filter(|instruction| instruction.is(Op::EntryPoint)) {
        let [model, id, name @ ..] = instruction.operands else { return broken("an entry point is cut off") };
        let name = literal(name)?;
        let compute = *model == ExecutionModel::GLCompute as u32;
        if compute && name == entry {
            ids.push(*id);
        }
        let kind = ExecutionModel::from_u32(*model).map_or_else(|| format!("kind {model}"), |kind| format!("{kind:?}"));
        found.push(format!("`{name}` ({kind})"));
    }
    match ids.as_slice() {
        [] => Err(ModuleError::NoEntry { entry: entry.to_owned(), found }),
        [id] => {
            let exists = instructions
                .iter()
                .any(|instruction| instruction.is(Op::Function) && instruction.operands.get(1) == Some(id));
            if exists { Ok(*id) } else { broken(format!("the entry point `{entry}` has no function")) }
        }
        _ => broken(format!("there are {} compute entry points `{entry}`", ids.len())),
    }
}

/// A literal string (section 2.2.1): UTF-8, ended by a zero byte.
pub(crate) fn literal(words: &[u32]) -> Result<String, ModuleError> {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect();
    if bytes.len() >= words.len() * 4 {
        return broken("a string has no end");
    }
    String::from_utf8(bytes).or_else(|_| broken("a string is not UTF-8"))
}
