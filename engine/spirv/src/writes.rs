//! Writes of one texel, recorded on demand. Behind each write to a storage image a call compares the image and the coordinates with a texel
//! whose words the caller puts into the buffer of records. If they are the same, it keeps a record of the invocation and of the value. The
//! write itself stays as it is, so such a shader computes the same as any other.
//!
//! The buffer has a word for each descriptor of a storage image: 0, or 1 more than the layer of the texel in the view that is bound there.
//! So another texel needs no other module. A function that gets an image as an argument learns its word from a variable of the invocation,
//! which each caller sets: GLSL has no recursion.

mod kind;
mod watcher;

use std::collections::HashMap;

use spirv::{Decoration, Dim, Op, StorageClass};

use crate::additions::write;
use crate::instruction::Instruction;
use crate::print::{PrintError, PrintedScalar, PrintedType, RECORDS, unsupported};
use crate::record::Writer;

pub use kind::WriteKind;

/// Words of a record's values: the number of the write in the module, and four of what it writes.
const VALUES: u32 = 5;

/// Most writes of a module.
const MAX_WRITES: usize = 16_384;

/// Most descriptors of storage images of a module.
const MAX_DESCRIPTORS: u32 = 16_384;

/// Words between the coordinates and the first image: the word of an image that is none of them, always 0.
const NONE: u32 = 1;

/// The writes to storage images of a module, and their part of the buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TexelWrites {
    /// The word of the buffer that has the texel's x; y follows.
    pub texel_word: u32,
    /// The word behind the last image's.
    pub end_word: u32,
    /// The storage images.
    pub images: Vec<WatchedImage>,
    /// The writes, in the order of the module.
    pub sites: Vec<WriteSite>,
    /// The word of the buffer that counts the records; [`RECORDS`] of them follow.
    pub first_word: u32,
}

/// A variable that is a storage image, or an array of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WatchedImage {
    /// Its descriptor set.
    pub set: u32,
    /// Its binding.
    pub binding: u32,
    /// Its descriptors.
    pub count: u32,
    /// The word of the buffer for the first of them.
    pub first_word: u32,
}

/// One write to a storage image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WriteSite {
    /// What it does.
    pub kind: WriteKind,
    /// The type of the value; of an atomic operation a scalar.
    pub value: PrintedType,
    /// The file as the module names it, and the line, counted from 1. `None` in a module without line numbers.
    pub line: Option<(String, u32)>,
}

/// The types that matter here.
#[derive(Clone, Copy)]
enum Type {
    /// Of 32 bits.
    Scalar(PrintedScalar),
    /// Component, and how many.
    Vector(u32, u32),
    /// A storage image: where its layer or slice is among the coordinates, if it has one, and how many coordinates it has.
    Image(Layer, u32),
    /// Storage images: the constant that is their number.
    Array(u32),
    /// Pointee.
    Pointer(u32),
}

/// The coordinate that is a layer, a face or a slice.
#[derive(Clone, Copy)]
enum Layer {
    None,
    Second,
    Third,
}

/// How the word of an image is found.
#[derive(Clone, Copy)]
enum Source {
    /// The value with this id.
    Value(u32),
    /// The variable with this id, which callers set.
    Argument(u32),
}

/// A texel whose pointer atomic operations take.
#[derive(Clone, Copy)]
struct Pointed {
    image: Source,
    ty: (Layer, u32),
    coordinate: u32,
}

/// The writes of a module, as they are met.
pub(crate) struct Writes {
    types: HashMap<u32, Type>,
    /// Types of values.
    values: HashMap<u32, u32>,
    /// 32-bit constants that cannot be specialized.
    constants: HashMap<u32, u32>,
    /// Images and pointers to them.
    sources: HashMap<u32, Source>,
    texels: HashMap<u32, Pointed>,
    /// The variables that hold the words of arguments, by function and number of the argument.
    arguments: HashMap<(u32, u32), u32>,
    /// The function that is read, and the number of its parameters so far.
    function: (u32, u32),
    /// The function that compares, once there is one.
    watcher: Option<u32>,
    found: TexelWrites,
}

impl Writes {
    /// `None` of a module that writes no storage image.
    pub(crate) fn new(instructions: &[Instruction<'_>], writer: &mut Writer) -> Option<Self> {
        let writes = |of: &Instruction<'_>| of.is(Op::ImageWrite) || of.is(Op::ImageTexelPointer);
        if !instructions.iter().any(writes) {
            return None;
        }
        let mut new = Self {
            types: HashMap::new(),
            values: HashMap::new(),
            constants: HashMap::new(),
            sources: HashMap::new(),
            texels: HashMap::new(),
            arguments: HashMap::new(),
            function: (0, 0),
            watcher: None,
            found: TexelWrites { texel_word: 0, end_word: 0, images: Vec::new(), sites: Vec::new(), first_word: 0 },
        };
        let mut variables = Vec::new();
        let mut places: HashMap<u32, [u32; 2]> = HashMap::new();
        for instruction in instructions.iter().take_while(|instruction| !instruction.is(Op::Function)) {
            match (Op::from_u32(instruction.opcode), instruction.operands) {
                (Some(Op::Decorate), [id, decoration, value]) => {
                    for (part, wanted) in [Decoration::DescriptorSet, Decoration::Binding].into_iter().enumerate() {
                        if *decoration == wanted as u32 {
                            places.entry(*id).or_default()[part] = *value;
                        }
                    }
                }
                (Some(Op::Variable), [ty, id, class, ..]) if *class == StorageClass::UniformConstant as u32 => {
                    new.values.insert(*id, *ty);
                    variables.push(*id);
                }
                _ => new.declaration(instruction),
            }
        }
        new.reserve(&variables, &places, writer);
        Some(new)
    }

    fn declaration(&mut self, instruction: &Instruction<'_>) {
        let (id, ty) = match (Op::from_u32(instruction.opcode), instruction.operands) {
            (Some(Op::Constant), [ty, id, value]) => {
                self.constants.insert(*id, *value);
                self.values.insert(*id, *ty);
                return;
            }
            (Some(Op::TypeInt), [id, 32, 0]) => (id, Type::Scalar(PrintedScalar::Uint)),
            (Some(Op::TypeInt), [id, 32, _]) => (id, Type::Scalar(PrintedScalar::Int)),
            (Some(Op::TypeFloat), [id, 32, ..]) => (id, Type::Scalar(PrintedScalar::Float)),
            (Some(Op::TypeVector), [id, part, count]) if self.types.contains_key(part) => {
                (id, Type::Vector(*part, *count))
            }
            // The last number says that it is used without a sampler.
            (Some(Op::TypeImage), [id, _, dim, _, arrayed, 0, 2, ..]) => {
                let (layer, coordinates) = match (Dim::from_u32(*dim), *arrayed != 0) {
                    (Some(Dim::Dim1D), false) => (Layer::None, 1),
                    (Some(Dim::Dim1D), true) => (Layer::Second, 2),
                    (Some(Dim::Dim2D), false) => (Layer::None, 2),
                    (Some(Dim::Dim2D), true) | (Some(Dim::Dim3D | Dim::DimCube), _) => (Layer::Third, 3),
                    _ => return,
                };
                (id, Type::Image(layer, coordinates))
            }
            (Some(Op::TypeArray), [id, element, length])
                if matches!(self.types.get(element), Some(Type::Image(..))) =>
            {
                (id, Type::Array(*length))
            }
            (Some(Op::TypePointer), [id, _, pointee]) if self.types.contains_key(pointee) => {
                (id, Type::Pointer(*pointee))
            }
            (_, [ty, id, ..])
                if (Op::ConstantTrue as u32..=Op::SpecConstantOp as u32).contains(&instruction.opcode)
                    || instruction.is(Op::Undef) =>
            {
                self.values.insert(*id, *ty);
                return;
            }
            _ => return,
        };
        self.types.insert(*id, ty);
    }

    /// Gives each descriptor of a storage image its word, and the records their part.
    fn reserve(&mut self, variables: &[u32], places: &HashMap<u32, [u32; 2]>, writer: &mut Writer) {
        let texel_word = writer.words_of_texel();
        let mut next = texel_word + 2 + NONE;
        for id in variables {
            let count = match self.pointee(*id) {
                Some(Type::Image(..)) => Some(1),
                Some(Type::Array(length)) => self.constants.get(&length).copied(),
                _ => None,
            };
            let most = MAX_DESCRIPTORS.saturating_sub(next);
            let Some(count) = count.filter(|count| *count <= most) else { continue };
            let [set, binding] = places.get(id).copied().unwrap_or_default();
            self.found.images.push(WatchedImage { set, binding, count, first_word: next });
            let word = writer.constant(next);
            self.sources.insert(*id, Source::Value(word));
            next += count;
        }
        writer.reserve(next);
        self.found.texel_word = texel_word;
        self.found.end_word = next;
        self.found.first_word = writer.part(RECORDS, VALUES);
    }

    /// The writes that were found, if there are any.
    pub(crate) fn found(self) -> Option<TexelWrites> {
        (!self.found.sites.is_empty()).then_some(self.found)
    }

    /// Takes note of an instruction of a function, and writes what has to stand in front of it.
    pub(crate) fn before(&mut self, instruction: &Instruction<'_>, writer: &mut Writer, function: &mut Vec<u32>) {
        // In a function a type only ever comes first as the type of a result.
        if let [ty, id, ..] = instruction.operands
            && self.types.contains_key(ty)
        {
            self.values.insert(*id, *ty);
        }
        match (Op::from_u32(instruction.opcode), instruction.operands) {
            (Some(Op::Function), [_, id, ..]) => self.function = (*id, 0),
            (Some(Op::FunctionParameter), [ty, id]) => {
                if self.is_of_images(*ty) {
                    let variable = self.argument(self.function, writer);
                    self.sources.insert(*id, Source::Argument(variable));
                }
                self.function.1 += 1;
            }
            (Some(Op::FunctionCall), [_, _, called, arguments @ ..]) => {
                for (argument, number) in arguments.iter().zip(0..) {
                    if self.values.get(argument).is_some_and(|ty| self.is_of_images(*ty)) {
                        let word = self.word(self.sources.get(argument).copied(), writer, function);
                        let variable = self.argument((*called, number), writer);
                        write(Op::Store, &[variable, word], function);
                    }
                }
            }
            (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, id, base, index]) => {
                self.element(*id, *base, *index, writer, function);
            }
            (Some(Op::Load | Op::CopyObject), [_, id, from, ..]) => {
                if let Some(source) = self.sources.get(from).copied() {
                    self.sources.insert(*id, source);
                }
            }
            (Some(Op::ImageTexelPointer), [_, id, pointer, coordinate, ..]) => {
                if let (Some(image), Some(Type::Image(layer, count))) =
                    (self.sources.get(pointer).copied(), self.pointee(*pointer))
                {
                    self.texels.insert(*id, Pointed { image, ty: (layer, count), coordinate: *coordinate });
                }
            }
            _ => {}
        }
    }

    /// Writes the record of an instruction of a function that writes a texel, behind it.
    pub(crate) fn after(
        &mut self,
        instruction: &Instruction<'_>,
        line: Option<&(String, u32)>,
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Result<(), PrintError> {
        let Some(op) = Op::from_u32(instruction.opcode) else { return Ok(()) };
        let (texel, kind, words) = match (op, instruction.operands) {
            (Op::ImageWrite, [image, coordinate, value, ..]) => {
                let Some(Type::Image(layer, count)) = self.type_of(*image) else { return Ok(()) };
                let Some(source) = self.sources.get(image).copied() else { return Ok(()) };
                let texel = Pointed { image: source, ty: (layer, count), coordinate: *coordinate };
                (texel, WriteKind::Store, vec![*value])
            }
            (Op::AtomicStore, [pointer, _, _, value]) => {
                let Some(texel) = self.texels.get(pointer).copied() else { return Ok(()) };
                // There is no word of the texel before it: the first is not read.
                (texel, WriteKind::AtomicStore, vec![*value, *value])
            }
            (_, [_, old, pointer, _, rest @ ..]) => {
                let (Some(texel), Some(kind)) = (self.texels.get(pointer).copied(), WriteKind::of(op)) else {
                    return Ok(());
                };
                let semantics = if kind == WriteKind::CompareExchange { 2 } else { 1 };
                (texel, kind, [&[*old], rest.get(semantics..).unwrap_or(&[])].concat())
            }
            _ => return Ok(()),
        };
        self.record(texel, (kind, &words), line, writer, function)
    }

    /// Writes a call of the function that compares.
    fn record(
        &mut self,
        texel: Pointed,
        (kind, values): (WriteKind, &[u32]),
        line: Option<&(String, u32)>,
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Result<(), PrintError> {
        let Some(value) = values.first().and_then(|value| self.shape(*value)) else { return Ok(()) };
        if values.iter().any(|other| self.shape(*other).is_none()) {
            return Ok(());
        }
        let Some(place) = self.place(texel, writer, function) else { return Ok(()) };
        if self.found.sites.len() == MAX_WRITES {
            return unsupported(format!("the shader has more than {MAX_WRITES} writes to images"), line.cloned());
        }
        let mut words = Vec::new();
        for value in values {
            let Some((ty, part)) = self.shape(*value) else { continue };
            writer.words(*value, ty, part, &mut words, function);
        }
        let zero = writer.constant(0);
        words.resize(4, zero);
        let image = self.word(Some(texel.image), writer, function);
        #[expect(clippy::cast_possible_truncation, reason = "there are at most `MAX_WRITES`")]
        let site = writer.constant(self.found.sites.len() as u32);
        let (watcher, result) = (self.watcher(writer), writer.additions.id());
        let call = [&[writer.void, result, watcher, image], place.as_slice(), &[site], words.as_slice()].concat();
        write(Op::FunctionCall, &call, function);
        self.found.sites.push(WriteSite { kind, value: value.0, line: line.cloned() });
        Ok(())
    }

    /// The texel's x, y and layer, as unsigned words; `None` of coordinates that are no integers of 32 bits.
    fn place(&self, texel: Pointed, writer: &mut Writer, function: &mut Vec<u32>) -> Option<[u32; 3]> {
        let (ty, part) = self.shape(texel.coordinate)?;
        let (layer, count) = texel.ty;
        if ty.components < count || !matches!(ty.scalar, PrintedScalar::Int | PrintedScalar::Uint) {
            return None;
        }
        let mut words = Vec::new();
        writer.words(texel.coordinate, ty, part, &mut words, function);
        let zero = writer.constant(0);
        words.truncate(count as usize);
        words.resize(3, zero);
        let [x, second, third] = words[..] else { return None };
        Some(match layer {
            Layer::Second => [x, zero, second],
            Layer::None | Layer::Third => [x, second, third],
        })
    }

    /// Finds the word of an element of an array of images.
    fn element(&mut self, id: u32, base: u32, index: u32, writer: &mut Writer, function: &mut Vec<u32>) {
        let (Some(Type::Array(length)), Some(source)) = (self.pointee(base), self.sources.get(&base).copied()) else {
            return;
        };
        let Some((PrintedType { scalar, components: 1 }, part)) = self.shape(index) else { return };
        let first = self.word(Some(source), writer, function);
        let mut words = Vec::new();
        writer.words(index, PrintedType { scalar, components: 1 }, part, &mut words, function);
        let [index] = words[..] else { return };
        let Some(length) = self.constants.get(&length).copied() else { return };
        let (bool, uint, length, none) = (writer.bool, writer.uint, writer.constant(length), self.none(writer));
        let [inside, sum, word] = [(); 3].map(|()| writer.additions.id());
        // An index that is too large would be the word of another image.
        write(Op::ULessThan, &[bool, inside, index, length], function);
        write(Op::IAdd, &[uint, sum, first, index], function);
        write(Op::Select, &[uint, word, inside, sum, none], function);
        self.sources.insert(id, Source::Value(word));
    }

    /// The word that is always 0.
    fn none(&self, writer: &mut Writer) -> u32 {
        writer.constant(self.found.texel_word + 2)
    }

    /// The id of the number of an image's word.
    fn word(&self, source: Option<Source>, writer: &mut Writer, function: &mut Vec<u32>) -> u32 {
        match source {
            Some(Source::Value(id)) => id,
            Some(Source::Argument(variable)) => {
                let loaded = writer.additions.id();
                write(Op::Load, &[writer.uint, loaded, variable], function);
                loaded
            }
            None => self.none(writer),
        }
    }

    /// The variable that holds the word of an argument.
    fn argument(&mut self, argument: (u32, u32), writer: &mut Writer) -> u32 {
        *self.arguments.entry(argument).or_insert_with(|| writer.private())
    }

    /// A value's shape, and the type of its components; `None` if they have not 32 bits.
    fn shape(&self, value: u32) -> Option<(PrintedType, u32)> {
        let ty = *self.values.get(&value)?;
        match self.types.get(&ty)? {
            Type::Scalar(scalar) => Some((PrintedType { scalar: *scalar, components: 1 }, ty)),
            Type::Vector(part, components) => match self.types.get(part)? {
                Type::Scalar(scalar) => Some((PrintedType { scalar: *scalar, components: *components }, *part)),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether a type is a storage image, or a pointer to one or to several.
    fn is_of_images(&self, ty: u32) -> bool {
        match self.types.get(&ty) {
            Some(Type::Image(..) | Type::Array(..)) => true,
            Some(Type::Pointer(to)) => matches!(self.types.get(to), Some(Type::Image(..) | Type::Array(..))),
            _ => false,
        }
    }

    fn type_of(&self, value: u32) -> Option<Type> {
        self.values.get(&value).and_then(|ty| self.types.get(ty)).copied()
    }

    /// The type that a pointer points to.
    fn pointee(&self, pointer: u32) -> Option<Type> {
        match self.type_of(pointer)? {
            Type::Pointer(to) => self.types.get(&to).copied(),
            _ => None,
        }
    }
}
