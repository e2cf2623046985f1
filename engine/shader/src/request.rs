//! The compiler's requests and results: the contract between the graph compiler and the shader compiler.

use std::collections::HashMap;
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_spirv::Module;
use serde::{Deserialize, Serialize};

use crate::interface::Interface;

/// One shader to be compiled.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Request {
    /// Path relative to the project root, e.g. `shaders/primary.comp`. `.spv` is taken as it is, `.hlsl` is HLSL, all else GLSL.
    pub path: String,
    /// Entry point (`main` by default; HLSL and SPIR-V may have another).
    pub entry: String,
    /// Preprocessor definitions in order of name.
    pub defines: Vec<(String, String)>,
}

impl Request {
    /// Whether the shader is HLSL, by the name of its file.
    pub(crate) fn is_hlsl(&self) -> bool {
        is_hlsl(&self.path)
    }
}

/// Whether a file is HLSL, by its name.
pub(crate) fn is_hlsl(path: &str) -> bool {
    path.to_ascii_lowercase().ends_with(".hlsl")
}

/// A compiled shader.
#[derive(Clone, Debug)]
pub struct Shader {
    /// The request.
    pub request: Request,
    /// The module for the driver: SPIR-V 1.5, or up to 1.6 when it came ready.
    pub spirv: Arc<[u32]>,
    /// Its interface.
    pub interface: Interface,
    /// Every file that went in (the shader itself first, then includes), by project path. A library include that came from the
    /// binary and not from disk is `<raxel/….glsl>`.
    pub files: Vec<String>,
    /// BLAKE3 of the request, the texts that went in, and the compiler's version: equal keys, equal modules.
    pub key: [u8; 32],
    /// BLAKE3 of the driver's input: the module and the name of its entry point. Texts that differ in comments, in functions that nothing
    /// calls, or in defines that change nothing have the same one.
    pub module: [u8; 32],
}

impl Shader {
    /// Bytes of `shared` variables, with these bits of specialization constants by their id.
    pub fn shared_bytes(&self, specialized: &HashMap<u32, u32>) -> u64 {
        let default = self.interface.shared_bytes;
        if default == 0 || specialized.is_empty() {
            return default;
        }
        let module = Module::new(&self.spirv, &self.interface.entry);
        module.map_or(default, |module| module.memory_with(specialized).shared)
    }
}

/// Compiles shaders. The graph compiler is given one of these and does not care where modules come from.
pub trait ShaderProvider: Sync {
    /// Compiles, or takes from a cache. Warnings come with the shader. On failure at least one diagnostic is an error.
    /// `texts` receives the text of every file that went in, so that diagnostics can be rendered.
    fn shader(
        &self,
        request: &Request,
        texts: &mut SourceMap,
    ) -> Result<(Arc<Shader>, Vec<Diagnostic>), Vec<Diagnostic>>;
}
