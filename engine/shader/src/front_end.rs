//! The front end proper: one text to one module through shaderc, in this process. It reads no file: the caller answers its includes, and
//! knows the places of its messages.

use std::cell::RefCell;
use std::sync::{Arc, OnceLock};

use serde::{Deserialize, Serialize};
use shaderc::{
    CompileOptions, EnvVersion, IncludeType, OptimizationLevel, ResolvedInclude, ShaderKind, SourceLanguage,
    SpirvVersion, TargetEnv,
};

use crate::limits;
use crate::request::Request;

/// Changes when the same texts would give another module: part of every key.
pub(crate) const VERSION: &str = concat!(
    "raxel-shader ",
    env!("CARGO_PKG_VERSION"),
    " shaderc 0.10 ",
    env!("RAXEL_SHADERC_LIBRARIES"),
    " spv1.5 unoptimised, shared memory bounded, lines of prints exact, lengths computed"
);

/// The compiler's message where an include cannot be had.
const INCLUDE_FAILED: &str = "raxel cannot include this";

/// One text to be compiled.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Job {
    pub request: Request,
    pub text: Arc<str>,
}

/// The result.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Outcome {
    /// A module, and the warnings as the compiler prints them.
    Module { words: Vec<u32>, warnings: String },
    /// The text has mistakes: the compiler's messages.
    Mistakes(String),
    /// There is not enough memory for it.
    OutOfMemory,
    /// The compiler gives up for a reason of its own.
    Failed(String),
}

/// How an include is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Form {
    /// `#include "x"`.
    Quoted,
    /// `#include <x>`.
    Angled,
}

/// An `#include` that the compiler meets.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Include {
    pub requested: String,
    pub form: Form,
    /// Name of the file that includes.
    pub includer: String,
    /// 1 in the shader itself.
    pub depth: usize,
}

/// The name of an included file and its text. `None` when it cannot be had.
pub(crate) type Included = Option<(String, Arc<str>)>;

/// Compiles on a thread of its own, whose stack suffices for any text that `limits` lets through.
pub(crate) fn compile(job: &Job, include: &mut (dyn FnMut(Include) -> Included + Send)) -> Outcome {
    let thread = std::thread::Builder::new().name("shader compiler".to_owned()).stack_size(limits::STACK);
    std::thread::scope(|scope| match thread.spawn_scoped(scope, || run(job, include)) {
        Ok(running) => running.join().unwrap_or_else(|_| Outcome::Failed("it panicked".to_owned())),
        Err(error) => Outcome::Failed(error.to_string()),
    })
}

/// Compiles on this thread.
fn run(job: &Job, include: &mut dyn FnMut(Include) -> Included) -> Outcome {
    let Some(shaderc) = shaderc() else {
        return Outcome::Failed("it does not start: out of memory".to_owned());
    };
    let request = &job.request;
    let include = RefCell::new(include);
    let result = options(request).and_then(|mut options| {
        options.set_include_callback(|requested, form, includer, depth| {
            let form = match form {
                IncludeType::Relative => Form::Quoted,
                IncludeType::Standard => Form::Angled,
            };
            let asked = Include { requested: requested.to_owned(), form, includer: includer.to_owned(), depth };
            // shaderc calls back on this thread, one include at a time, and never from inside the callback.
            let answer = (include.borrow_mut())(asked).ok_or(INCLUDE_FAILED)?;
            Ok(ResolvedInclude { resolved_name: answer.0, content: answer.1.to_string() })
        });
        shaderc.compile_into_spirv(&job.text, ShaderKind::Compute, &request.path, &request.entry, Some(&options))
    });
    match result {
        Ok(module) => Outcome::Module { words: module.as_binary().to_vec(), warnings: module.get_warning_messages() },
        Err(shaderc::Error::CompilationError(_, output)) => Outcome::Mistakes(
            output.lines().filter(|line| !line.contains(INCLUDE_FAILED)).flat_map(|line| [line, "\n"]).collect(),
        ),
        // shaderc's report of a C++ exception. glslang throws only the allocator's.
        Err(shaderc::Error::InternalError(reason)) if reason.is_empty() => Outcome::OutOfMemory,
        Err(error) => Outcome::Failed(error.to_string()),
    }
}

/// The compiler itself, one for the process: it builds its tables of built-in names at first use, which takes longer than a shader,
/// and would tear them down with the last of its kind.
fn shaderc() -> Option<&'static shaderc::Compiler> {
    static SHADERC: OnceLock<Option<shaderc::Compiler>> = OnceLock::new();
    SHADERC.get_or_init(|| shaderc::Compiler::new().ok()).as_ref()
}

fn options<'a>(request: &Request) -> Result<CompileOptions<'a>, shaderc::Error> {
    let mut options = CompileOptions::new()?;
    // SPIR-V 1.5: version 1.6, the default of Vulkan 1.3, has `LocalSizeId`, which needs a device feature.
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
    options.set_target_spirv(SpirvVersion::V1_5);
    // Optimisation strips names, and drivers optimise on their own.
    options.set_optimization_level(OptimizationLevel::Zero);
    options.set_generate_debug_info();
    options.set_auto_bind_uniforms(true);
    options.set_auto_map_locations(true);
    if request.is_hlsl() {
        // Before version 13 glslang decorates the storage buffers of HLSL as `BufferBlock`, which SPIR-V 1.4 has no more.
        options.set_target_spirv(SpirvVersion::V1_3);
        options.set_source_language(SourceLanguage::HLSL);
        options.set_hlsl_io_mapping(true);
        options.set_hlsl_offsets(true);
    }
    for (name, value) in &request.defines {
        options.add_macro_definition(name, Some(value));
    }
    Ok(options)
}
