//! Reads the interface of a module: its bindings, its push constants, the size of its workgroups.

use raxel_diagnostics::quietly;
use raxel_spirv::{Chains, Module, WorkgroupSize};
use spirq::ReflectConfig;
use spirq::annotation::DecorationRegistry;
use spirq::constant::ConstantValue;
use spirq::parse::SpirvBinary;
use spirq::reflect::ReflectIntermediate;
use spirq::spirv::{self, StorageClass};
use spirq::ty::{AccessType, ImageType, MatrixAxisOrder, ScalarType, StructType, Type as SpirvType};

use crate::format::Format;
use crate::interface::{
    Access, Binding, BindingKind, Block, ByteRanges, Dim, Interface, LocalSize, Member, Scalar, ScalarKind,
    SpecConstant, Type,
};

/// The interface of the entry point that `module` was opened with. On failure the reason, without the file's name.
pub(crate) fn reflect(module: &Module<'_>, entry: &str) -> Result<Interface, String> {
    if module.has_late_constants() {
        return Err(
            "a constant is computed at run time: give each side of `&&` and `||` a constant of its own".to_owned()
        );
    }
    let declarations = SpirvBinary::from(module.declarations());
    // The reflector panics on enum values and opcodes that it does not know.
    let mut interface = quietly(|| read(&declarations, module))
        .unwrap_or_else(|| Err("it uses an instruction that the reflector does not know".to_owned()))?;
    entry.clone_into(&mut interface.entry);
    interface.capabilities = module.capabilities();
    interface.shared_bytes = module.memory().shared;
    Ok(interface)
}

fn read(declarations: &SpirvBinary, module: &Module<'_>) -> Result<Interface, String> {
    let config = ReflectConfig::new();
    let mut spirq = ReflectIntermediate::new(&config).map_err(|error| error.to_string())?;
    let mut instructions = declarations.instrs().map_err(|error| error.to_string())?;
    spirq.parse_global_declrs(&mut instructions).map_err(|error| error.to_string())?;
    if let Some(unread) = instructions.peek() {
        return Err(format!("an instruction of opcode {} is out of place", unread.opcode()));
    }

    let mut interface = Interface { local_size: local_size(&spirq, module)?, ..Interface::default() };
    let used = module.used_ids();
    let buffer_blocks = module.buffer_blocks();
    let (mut variables, mut unused): (Vec<_>, Vec<_>) = spirq.var_reg.iter().partition(|(id, _)| used.contains(*id));
    variables.sort_by_key(|(id, _)| **id);
    unused.sort_by_key(|(id, _)| **id);
    let chains = module.chains(&variables.iter().map(|(id, _)| **id).collect());
    // Before SPIR-V 1.3 a storage buffer is a uniform whose block is decorated as `BufferBlock`.
    let class_of = |id: u32, class: StorageClass| match class {
        StorageClass::Uniform if buffer_blocks.contains(&id) => StorageClass::StorageBuffer,
        class => class,
    };
    for (id, variable) in variables {
        let ty = &*variable.ptr_ty.pointee_ty;
        let class = class_of(*id, variable.ptr_ty.store_cls);
        let name = variable.name.as_deref().filter(|name| !name.is_empty());
        match class {
            StorageClass::PushConstant => {
                let SpirvType::Struct(ty) = ty else { return Err("the push constants are not a block".to_owned()) };
                let block = block(ty)?;
                interface.push_reads = reads(&block, chains.get(id));
                name.unwrap_or_default().clone_into(&mut interface.push_name);
                interface.push = Some(block);
            }
            StorageClass::Uniform | StorageClass::StorageBuffer | StorageClass::UniformConstant => {
                let mut binding = binding(*id, name, class, ty, &spirq.deco_reg)?;
                if let BindingKind::UniformBuffer(block) = &binding.kind {
                    binding.reads = reads(block, chains.get(id));
                }
                interface.bindings.push(binding);
            }
            _ => {}
        }
    }
    interface.bindings.sort_by_key(|binding| (binding.set, binding.binding));
    for (id, variable) in unused {
        let ty = &*variable.ptr_ty.pointee_ty;
        let name = variable.name.as_deref().filter(|name| !name.is_empty());
        // With any mistake in it: nothing depends on it.
        match (class_of(*id, variable.ptr_ty.store_cls), ty) {
            (StorageClass::PushConstant, SpirvType::Struct(ty)) => interface.unused.push = block(ty).ok(),
            (class @ (StorageClass::Uniform | StorageClass::StorageBuffer | StorageClass::UniformConstant), ty) => {
                interface.unused.bindings.extend(binding(*id, name, class, ty, &spirq.deco_reg));
            }
            _ => {}
        }
    }
    interface.unused.bindings.sort_by_key(|binding| (binding.set, binding.binding));

    for (_, constant) in spirq.interp.iter() {
        let Some(id) = constant.spec_id else { continue };
        let SpirvType::Scalar(ty) = &constant.ty else { continue };
        interface.specialization.push(SpecConstant {
            id,
            name: constant.name.clone().unwrap_or_default(),
            scalar: scalar(ty)?,
            default: bits(&constant.value),
            place: None,
        });
    }
    interface.specialization.sort_by(|a, b| (a.id, &a.name).cmp(&(b.id, &b.name)));
    Ok(interface)
}

fn local_size(spirq: &ReflectIntermediate<'_>, module: &Module<'_>) -> Result<[LocalSize; 3], String> {
    match module.workgroup_size() {
        WorkgroupSize::Literals(sizes) => Ok(sizes.map(|value| LocalSize { value, spec_id: None })),
        WorkgroupSize::Ids(ids) => {
            let mut sizes = [LocalSize::default(); 3];
            for (size, id) in sizes.iter_mut().zip(ids) {
                let constant = spirq.interp.get(id).map_err(|_| "the workgroup size is not a constant".to_owned())?;
                let value = bits(&constant.value);
                let value =
                    u32::try_from(value).map_err(|_| format!("the workgroup size {value} has more than 32 bits"))?;
                *size = LocalSize { value, spec_id: constant.spec_id };
            }
            Ok(sizes)
        }
    }
}

fn binding(
    id: u32,
    name: Option<&str>,
    class: StorageClass,
    ty: &SpirvType,
    decorations: &DecorationRegistry<'_>,
) -> Result<Binding, String> {
    let (count, ty) = match ty {
        SpirvType::Array(array) => (array.nelement, &*array.element_ty),
        ty => (Some(1), ty),
    };
    let place = decorations.get_var_desc_bind_or_default(id);
    let kind = match ty {
        _ if count.is_none() => BindingKind::Unsupported("an array of descriptors without a length".to_owned()),
        SpirvType::Array(_) => BindingKind::Unsupported("an array of arrays of descriptors".to_owned()),
        SpirvType::Struct(ty) if class == StorageClass::StorageBuffer => BindingKind::StorageBuffer(block(ty)?),
        SpirvType::Struct(ty) if class == StorageClass::Uniform => BindingKind::UniformBuffer(block(ty)?),
        SpirvType::Image(image) => image_kind(image)?,
        SpirvType::CombinedImageSampler(sampler) => {
            let image = &sampler.sampled_image_ty;
            match dim(image.dim) {
                Some(dim) if !image.is_multisampled => {
                    BindingKind::SampledImage { dim, arrayed: image.is_array, scalar: scalar_kind(&image.scalar_ty)? }
                }
                _ => BindingKind::Unsupported(sampler.to_string()),
            }
        }
        other => BindingKind::Unsupported(other.to_string()),
    };
    let name = match (name, ty) {
        (Some(name), _) => name.to_owned(),
        (None, SpirvType::Struct(StructType { name: Some(block), .. })) => block.clone(),
        _ => format!("set{}binding{}", place.set(), place.bind()),
    };
    let access = match (&kind, decorations.get_desc_access_ty(id, ty)) {
        (BindingKind::SampledImage { .. } | BindingKind::UniformBuffer(_), _) | (_, Some(AccessType::ReadOnly)) => {
            Access::Read
        }
        (_, Some(AccessType::WriteOnly)) => Access::Write,
        _ => Access::ReadWrite,
    };
    Ok(Binding {
        name,
        set: place.set(),
        binding: place.bind(),
        count: count.unwrap_or(0),
        kind,
        access,
        reads: ByteRanges::default(),
        place: None,
    })
}

/// The bytes of a block that its access chains select.
fn reads(block: &Block, chains: Option<&Chains>) -> ByteRanges {
    let whole = || ByteRanges::new(vec![[0, block.size]]);
    match chains {
        Some(Chains { chains, whole: false }) => {
            let parts = chains.iter().map(|chain| selected(block, chain)).collect::<Option<Vec<_>>>();
            parts.map_or_else(whole, ByteRanges::new)
        }
        _ => whole(),
    }
}

/// The bytes that the indices of a chain select; `None` where they lead out of the block.
fn selected(block: &Block, chain: &[Option<u32>]) -> Option<[u32; 2]> {
    let (first, mut rest) = chain.split_first()?;
    let member = block.members.get((*first)? as usize)?;
    let (mut offset, mut ty) = (member.offset, &member.ty);
    while let Some((index, deeper)) = rest.split_first() {
        match (ty, index) {
            (Type::Struct(inner), Some(index)) => {
                let member = inner.members.get(*index as usize)?;
                (offset, ty) = (offset.checked_add(member.offset)?, &member.ty);
            }
            (Type::Array { element, len, stride }, Some(index)) if len.is_some_and(|len| *index < len) => {
                (offset, ty) = (offset.checked_add(index.checked_mul(*stride)?)?, element);
            }
            // Any element, or a part of a vector or matrix: all of it.
            _ => break,
        }
        rest = deeper;
    }
    Some([offset, offset.checked_add(ty.size())?])
}

fn image_kind(image: &ImageType) -> Result<BindingKind, String> {
    let unsupported = || Ok(BindingKind::Unsupported(image.to_string()));
    // A separate texture has no sampler of its own.
    let (Some(dim), Some(false), false) = (dim(image.dim), image.is_sampled, image.is_multisampled) else {
        return unsupported();
    };
    let format = match image.fmt {
        spirv::ImageFormat::Unknown => None,
        known => match format(known) {
            Some(format) => Some(format),
            None => return unsupported(),
        },
    };
    Ok(BindingKind::StorageImage { format, dim, arrayed: image.is_array, scalar: scalar_kind(&image.scalar_ty)? })
}

fn dim(dim: spirv::Dim) -> Option<Dim> {
    match dim {
        spirv::Dim::Dim1D => Some(Dim::D1),
        spirv::Dim::Dim2D => Some(Dim::D2),
        spirv::Dim::Dim3D => Some(Dim::D3),
        spirv::Dim::DimCube => Some(Dim::Cube),
        _ => None,
    }
}

fn block(ty: &StructType) -> Result<Block, String> {
    let mut members = Vec::with_capacity(ty.members.len());
    let mut size = 0;
    for (index, member) in ty.members.iter().enumerate() {
        let name = member.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("member{index}"));
        let offset = member
            .offset
            .and_then(|offset| u32::try_from(offset).ok())
            .ok_or_else(|| format!("member `{name}` of a block has no offset"))?;
        let ty = self::ty(&member.ty)?;
        size = size.max(offset.saturating_add(ty.size()));
        members.push(Member { name, offset, ty, place: None });
    }
    Ok(Block { name: ty.name.clone().unwrap_or_default(), size, members })
}

fn ty(ty: &SpirvType) -> Result<Type, String> {
    Ok(match ty {
        SpirvType::Scalar(ty) => Type::Scalar(scalar(ty)?),
        SpirvType::Vector(ty) => Type::Vector(scalar(&ty.scalar_ty)?, ty.nscalar),
        SpirvType::Matrix(ty) => Type::Matrix {
            scalar: scalar(&ty.vector_ty.scalar_ty)?,
            columns: ty.nvector,
            rows: ty.vector_ty.nscalar,
            stride: stride(ty.stride)?,
            row_major: ty.axis_order == Some(MatrixAxisOrder::RowMajor),
        },
        SpirvType::Array(ty) => {
            Type::Array { element: Box::new(self::ty(&ty.element_ty)?), len: ty.nelement, stride: stride(ty.stride)? }
        }
        SpirvType::Struct(ty) => Type::Struct(block(ty)?),
        SpirvType::DeviceAddress(_) | SpirvType::DevicePointer(_) => Type::Scalar(Scalar::Address),
        other => return Err(format!("a block holds `{other}`, which has no bytes")),
    })
}

fn stride(stride: Option<usize>) -> Result<u32, String> {
    stride
        .and_then(|stride| u32::try_from(stride).ok())
        .ok_or_else(|| "an array or matrix in a block has no stride".to_owned())
}

fn scalar(ty: &ScalarType) -> Result<Scalar, String> {
    Ok(match ty {
        ScalarType::Boolean => Scalar::Bool,
        ScalarType::Integer { bits: 8, is_signed: true } => Scalar::I8,
        ScalarType::Integer { bits: 8, is_signed: false } => Scalar::U8,
        ScalarType::Integer { bits: 16, is_signed: true } => Scalar::I16,
        ScalarType::Integer { bits: 16, is_signed: false } => Scalar::U16,
        ScalarType::Integer { bits: 32, is_signed: true } => Scalar::I32,
        ScalarType::Integer { bits: 32, is_signed: false } => Scalar::U32,
        ScalarType::Integer { bits: 64, is_signed: true } => Scalar::I64,
        ScalarType::Integer { bits: 64, is_signed: false } => Scalar::U64,
        ScalarType::Float { bits: 16 } => Scalar::F16,
        ScalarType::Float { bits: 32 } => Scalar::F32,
        ScalarType::Float { bits: 64 } => Scalar::F64,
        other => return Err(format!("`{other}` is not a scalar type that raxel knows")),
    })
}

fn scalar_kind(ty: &ScalarType) -> Result<ScalarKind, String> {
    match ty {
        ScalarType::Float { .. } => Ok(ScalarKind::Float),
        ScalarType::Integer { is_signed: true, .. } => Ok(ScalarKind::Int),
        ScalarType::Integer { is_signed: false, .. } => Ok(ScalarKind::Uint),
        other => Err(format!("an image of `{other}`")),
    }
}

/// The bits of a constant, zero-extended.
fn bits(value: &ConstantValue) -> u64 {
    let bytes = value.to_typeless().unwrap_or_default();
    bytes.iter().take(8).rev().fold(0, |bits, byte| bits << 8 | u64::from(*byte))
}

fn format(format: spirv::ImageFormat) -> Option<Format> {
    use spirv::ImageFormat as F;
    Some(match format {
        F::Rgba32f => Format::Rgba32f,
        F::Rgba16f => Format::Rgba16f,
        F::Rg32f => Format::Rg32f,
        F::Rg16f => Format::Rg16f,
        F::R11fG11fB10f => Format::R11fG11fB10f,
        F::R32f => Format::R32f,
        F::R16f => Format::R16f,
        F::Rgba16 => Format::Rgba16,
        F::Rgb10A2 => Format::Rgb10A2,
        F::Rgba8 => Format::Rgba8,
        F::Rg16 => Format::Rg16,
        F::Rg8 => Format::Rg8,
        F::R16 => Format::R16,
        F::R8 => Format::R8,
        F::Rgba16Snorm => Format::Rgba16Snorm,
        F::Rgba8Snorm => Format::Rgba8Snorm,
        F::Rg16Snorm => Format::Rg16Snorm,
        F::Rg8Snorm => Format::Rg8Snorm,
        F::R16Snorm => Format::R16Snorm,
        F::R8Snorm => Format::R8Snorm,
        F::Rgba32i => Format::Rgba32i,
        F::Rgba16i => Format::Rgba16i,
        F::Rgba8i => Format::Rgba8i,
        F::Rg32i => Format::Rg32i,
        F::Rg16i => Format::Rg16i,
        F::Rg8i => Format::Rg8i,
        F::R32i => Format::R32i,
        F::R16i => Format::R16i,
        F::R8i => Format::R8i,
        F::Rgba32ui => Format::Rgba32ui,
        F::Rgba16ui => Format::Rgba16ui,
        F::Rgba8ui => Format::Rgba8ui,
        F::Rg32ui => Format::Rg32ui,
        F::Rg16ui => Format::Rg16ui,
        F::Rg8ui => Format::Rg8ui,
        F::R32ui => Format::R32ui,
        F::R16ui => Format::R16ui,
        F::R8ui => Format::R8ui,
        F::Rgb10a2ui => Format::Rgb10A2ui,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Validated modules have no such instruction, but the reflector is older than the validator.
    #[test]
    fn what_the_reflector_does_not_know_is_an_error() {
        let mut words = vec![0x0723_0203, 0x0001_0500, 0, 5, 0, 0x0002_0011, 1, 0x0003_000e, 0, 1];
        words.extend([0x0005_000f, 5, 2, u32::from_le_bytes(*b"main"), 0, 0x0006_0010, 2, 17, 1, 1, 1]);
        words.extend([0x0002_0013, 1, 0x0003_0021, 4, 1, 0x0001_7fff]);
        words.extend([0x0005_0036, 1, 2, 0, 4, 0x0002_00f8, 3, 0x0001_00fd, 0x0001_0038]);
        let module = Module::new(&words, "main").unwrap();
        assert!(reflect(&module, "main").unwrap_err().contains("the reflector does not know"));
    }
}
