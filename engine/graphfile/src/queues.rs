//! Queues: a pass with one thread for each element of a queue gets a pass of raxel's own in front, which makes its indirect arguments.
//! Both are ordinary passes from there on: barriers, memory, culling and the memo need to know nothing of queues.

use std::sync::{Arc, OnceLock};

use raxel_diagnostics::{Diagnostic, MemoryFiles, SourceMap, Span, codes};
use raxel_shader::interface::{Access, Scalar};
use raxel_shader::{Compiler, Request, Shader, ShaderProvider};

use raxel_graph::checked::{
    BoundAccess, Buffer, BufferSize, Dispatch, Fill, InLoop, Interval, Origin, Pass, Resource, ResourceId,
    ResourceKind, Usage, Value, ValueOrigin,
};
use raxel_graph::{ValueType, index32};

/// Path that the shader of the arguments has in messages; it is in the library, not in the project.
const PATH: &str = "shaders/raxel/arguments.comp";
/// Bytes of the arguments: three counts, padded.
const BYTES: u64 = 16;

/// The place of the number of a pass's threads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Queue {
    /// The buffer.
    pub buffer: ResourceId,
    /// Byte offset of the count, a multiple of 4.
    pub offset: u64,
}

/// The buffer for the arguments of the pass of that name. The name of a file's resource has no dot.
pub(crate) fn arguments(pass: &str, place: Span) -> Resource {
    Resource {
        name: format!("{pass}.arguments"),
        kind: ResourceKind::Buffer(Buffer { size: BufferSize::Bytes(BYTES), clear: None, init: None }),
        history: 0,
        keep: false,
        clock: None,
        made: true,
        warnings: Vec::new(),
        origin: Origin::Graph,
        place,
    }
}

/// The pass that makes the arguments of `pass` from its queue. It runs whenever `pass` does.
pub(crate) fn maker(pass: &Pass, queue: Queue) -> Result<Pass, Diagnostic> {
    let shader = shader().map_err(|diagnostic| diagnostic.label(pass.place.clone(), "for this pass"))?;
    let binding = |name: &str| shader.interface.bindings.iter().position(|b| b.name == name).map(index32);
    let access = |resource, access, name| BoundAccess {
        resource,
        age: 0,
        mips: Interval::one(0),
        layers: Interval::one(0),
        access,
        usage: Usage::StorageBuffer,
        binding: binding(name),
        sampler: None,
    };
    let Dispatch::Indirect { buffer: arguments, .. } = pass.dispatch else {
        return Err(Diagnostic::error(codes::graph::INDIRECT, format!("pass `{}` has no arguments", pass.name)));
    };
    Ok(Pass {
        name: format!("{}.arguments", pass.name),
        dispatch: Dispatch::Groups([1; 3]),
        accesses: vec![access(queue.buffer, Access::Read, "queue"), access(arguments, Access::Write, "arguments")],
        push: vec![Fill {
            member: "word".to_owned(),
            offset: 0,
            ty: ValueType::scalar(Scalar::U32),
            stride: 0,
            from: ValueOrigin::Value(Value::U32(u32::try_from(queue.offset / 4).unwrap_or(u32::MAX))),
        }],
        uniforms: Vec::new(),
        // The workgroup of the pass, with the constants that size it.
        specialization: (0..).zip(workgroup(pass)).collect(),
        subgroup_size: None,
        // Of the round it takes only its place.
        in_loop: pass.in_loop.as_ref().map(|in_loop| InLoop { of: in_loop.of, mips: Vec::new(), dispatch_mip: None }),
        made: true,
        shader,
        ..pass.clone()
    })
}

/// Threads along each axis of a pass's workgroup, as values of constants.
fn workgroup(pass: &Pass) -> [ValueOrigin; 3] {
    pass.shader.interface.local_size.map(|axis| {
        let set = axis.spec_id.and_then(|id| pass.specialization.iter().find(|(other, _)| *other == id));
        set.map_or(ValueOrigin::Value(Value::U32(axis.value)), |(_, source)| source.clone())
    })
}

/// The shader that makes arguments, compiled once.
fn shader() -> Result<Arc<Shader>, Diagnostic> {
    static SHADER: OnceLock<Arc<Shader>> = OnceLock::new();
    if let Some(shader) = SHADER.get() {
        return Ok(shader.clone());
    }
    let compiler = Compiler::new(Arc::new(MemoryFiles::new([(PATH, include_str!("queues/arguments.comp"))])));
    let request = Request { path: PATH.to_owned(), entry: "main".to_owned(), defines: Vec::new() };
    match compiler.shader(&request, &mut SourceMap::default()) {
        Ok((shader, _)) => Ok(SHADER.get_or_init(|| shader).clone()),
        // Only a compiler out of memory refuses it.
        Err(found) => {
            let said = found.first().map_or("", |diagnostic| diagnostic.message.as_str());
            let message = format!("the shader of indirect arguments does not compile: {said}");
            Err(Diagnostic::error(codes::shader::COMPILE, message))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shader_has_what_its_pass_is_given() {
        let interface = &shader().expect("it is ours").interface;
        let names: Vec<&str> = interface.bindings.iter().map(|binding| binding.name.as_str()).collect();
        assert_eq!(names.len(), 2);
        assert!(names.contains(&"queue") && names.contains(&"arguments"), "{names:?}");
        assert_eq!(interface.push.as_ref().map(|block| block.size), Some(4));
        let constants: Vec<_> = interface.specialization.iter().map(|constant| constant.id).collect();
        assert_eq!(constants, [0, 1, 2]);
    }
}
