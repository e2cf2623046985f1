//! HLSL is compiled in another process first. glslang's HLSL front end is less hardened than its GLSL one: about one in a thousand
//! random small edits of a shader makes it stop the process (a null pointer in `HlslParseContext`), which no `catch_unwind` catches. A
//! program that must outlive any text names a function with [`rehearse_hlsl_with`]; it hands the text to a child process, and the
//! child calls [`rehearse_hlsl`].

use std::sync::OnceLock;

use shaderc::ShaderKind;

use crate::compile;
use crate::limits;
use crate::request::Request;
use crate::sources::Sources;

/// Compiles a preprocessed text with an entry point elsewhere. `false` when whoever did that did not survive it.
pub type Rehearse = fn(entry: &str, text: &str) -> bool;

static REHEARSE: OnceLock<Rehearse> = OnceLock::new();

/// From now on, every HLSL text of this process is compiled only when `rehearse` survived it. The first function named stays.
pub fn rehearse_hlsl_with(rehearse: Rehearse) {
    let _ = REHEARSE.set(rehearse);
}

/// The child's part: compiles the text and forgets the result. The process may end here.
pub fn rehearse_hlsl(entry: &str, text: &str) {
    let request = Request { path: "rehearsal.hlsl".to_owned(), entry: entry.to_owned(), defines: Vec::new() };
    let thread = std::thread::Builder::new().stack_size(limits::STACK);
    std::thread::scope(|scope| {
        let running = thread.spawn_scoped(scope, || {
            let (Ok(shaderc), Ok(options)) = (shaderc::Compiler::new(), compile::options(&request, true)) else {
                return;
            };
            let _ = shaderc.compile_into_spirv(text, ShaderKind::Compute, &request.path, entry, Some(&options));
        });
        if let Ok(running) = running {
            let _ = running.join();
        }
    });
}

/// Whether the text of a request can be compiled without an end of the process, as far as anybody tried. Includes are read from
/// `sources`, which nothing else is read from.
pub(crate) fn survived(shaderc: &shaderc::Compiler, request: &Request, text: &str, sources: &mut Sources<'_>) -> bool {
    let Some(rehearse) = REHEARSE.get() else { return true };
    match compile::preprocess(shaderc, request, text, sources) {
        Some(text) => rehearse(&request.entry, &text),
        // A mistake of the preprocessor's kind, which compiling is going to report.
        None => true,
    }
}
