//! Shaders of the runtime's own triangles. Graphs have no such shaders, so nothing is reflected or reported to a user.

use shaderc::{CompileOptions, EnvVersion, OptimizationLevel, ShaderKind, SpirvVersion, TargetEnv};

use crate::module_cache;

/// A stage of a graphics pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphicsStage {
    /// Corners.
    Vertex,
    /// Pixels.
    Fragment,
}

/// Compiles GLSL that ships with the program. `name` stands for the file in messages.
///
/// # Errors
/// The compiler's messages.
pub fn compile_graphics(stage: GraphicsStage, name: &str, text: &str) -> Result<Vec<u32>, String> {
    let follows_from = [if stage == GraphicsStage::Vertex { "vertex" } else { "fragment" }, name, text];
    module_cache::words(raxel_cache::of_process(), &follows_from, || compile(stage, name, text))
}

fn compile(stage: GraphicsStage, name: &str, text: &str) -> Result<Vec<u32>, String> {
    let compiler = shaderc::Compiler::new().map_err(|error| error.to_string())?;
    let mut options = CompileOptions::new().map_err(|error| error.to_string())?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
    options.set_target_spirv(SpirvVersion::V1_5);
    options.set_optimization_level(OptimizationLevel::Performance);
    let kind = match stage {
        GraphicsStage::Vertex => ShaderKind::Vertex,
        GraphicsStage::Fragment => ShaderKind::Fragment,
    };
    let module = compiler.compile_into_spirv(text, kind, name, "main", Some(&options));
    module.map(|module| module.as_binary().to_vec()).map_err(|error| error.to_string())
}
