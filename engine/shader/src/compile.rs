//! GLSL and HLSL to SPIR-V through shaderc.

use std::cell::RefCell;
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, Span, codes};
use shaderc::{
    CompileOptions, EnvVersion, IncludeType, OptimizationLevel, ResolvedInclude, ShaderKind, SourceLanguage,
    SpirvVersion, TargetEnv,
};

use crate::fatal::{BUFFER_REFERENCE, buffer_reference};
use crate::hlsl;
use crate::lexer::{self, Token};
use crate::limits;
use crate::messages;
use crate::rehearsal;
use crate::request::Request;
use crate::sources::{Form, Sources};

/// Changes when the same texts would give another module: part of every key.
pub(crate) const VERSION: &str =
    concat!("raxel-shader ", env!("CARGO_PKG_VERSION"), " shaderc 0.10 spv1.5 unoptimised, shared memory bounded");

/// Compiles the text of a request; everything said about it goes to `sources.diagnostics`. `None` when there is an error.
pub(crate) fn compile(
    shaderc: &shaderc::Compiler,
    request: &Request,
    text: &Arc<str>,
    sources: &mut Sources<'_>,
) -> Option<Vec<u32>> {
    let hlsl = is_hlsl(&request.path);
    let refusals = refusals(request, text, hlsl);
    if !refusals.is_empty() {
        sources.diagnostics.extend(refusals);
        return None;
    }
    // The stack suffices for any text that `limits` lets through.
    let thread = std::thread::Builder::new().name("shader compiler".to_owned()).stack_size(limits::STACK);
    let outcome = std::thread::scope(|scope| {
        let running = thread.spawn_scoped(scope, || run(shaderc, request, text, hlsl, sources));
        running.map_err(|error| error.to_string())?.join().map_err(|_| "it panicked".to_owned())
    });
    outcome.unwrap_or_else(|reason| {
        sources.diagnostics.push(failure(&request.path, &reason));
        None
    })
}

fn run(
    shaderc: &shaderc::Compiler,
    request: &Request,
    text: &Arc<str>,
    hlsl: bool,
    sources: &mut Sources<'_>,
) -> Option<Vec<u32>> {
    if hlsl && !rehearsal::survived(shaderc, request, text, &mut sources.fresh()) {
        sources.diagnostics.push(
            failure(&request.path, "it would stop the process over a mistake that it does not report")
                .help("take back the last edit, and look for an operator or a member that makes no sense"),
        );
        return None;
    }
    let state = RefCell::new(&mut *sources);
    let result = with_includes(request, hlsl, &state).and_then(|options| {
        shaderc.compile_into_spirv(text, ShaderKind::Compute, &request.path, &request.entry, Some(&options))
    });
    match result {
        Ok(module) => {
            let found = messages::diagnostics(&module.get_warning_messages(), sources);
            sources.diagnostics.extend(found);
            Some(module.as_binary().to_vec())
        }
        Err(shaderc::Error::CompilationError(_, output)) => {
            let output: String =
                output.lines().filter(|line| !line.contains(INCLUDE_FAILED)).flat_map(|line| [line, "\n"]).collect();
            let found = messages::diagnostics(&output, sources);
            // After a missing include all else is doubtful: what it declares is missing too.
            let include_failed = sources.diagnostics.iter().any(Diagnostic::is_error);
            sources.diagnostics.extend(found.into_iter().filter(|found| !include_failed || !found.is_error()));
            if !sources.diagnostics.iter().any(Diagnostic::is_error) {
                sources.diagnostics.push(failure(&request.path, output.trim()));
            }
            None
        }
        Err(error) => {
            sources.diagnostics.push(failure(&request.path, &error.to_string()));
            None
        }
    }
}

/// The text with its includes and macros written out. `None` when there is an error in that.
pub(crate) fn preprocess(
    shaderc: &shaderc::Compiler,
    request: &Request,
    text: &str,
    sources: &mut Sources<'_>,
) -> Option<String> {
    let state = RefCell::new(sources);
    let options = with_includes(request, is_hlsl(&request.path), &state).ok()?;
    Some(shaderc.preprocess(text, &request.path, &request.entry, Some(&options)).ok()?.as_text())
}

/// The options, with includes read from `sources`.
fn with_includes<'a>(
    request: &Request,
    hlsl: bool,
    sources: &'a RefCell<&mut Sources<'_>>,
) -> Result<CompileOptions<'a>, shaderc::Error> {
    let mut options = options(request, hlsl)?;
    options.set_include_callback(|requested, form, includer, depth| {
        let form = match form {
            IncludeType::Relative => Form::Quoted,
            IncludeType::Standard => Form::Angled,
        };
        // shaderc calls back on this thread, one include at a time, and never from inside the callback.
        match sources.borrow_mut().include(requested, form, includer, depth) {
            Some((name, text)) => Ok(ResolvedInclude { resolved_name: name, content: text.to_string() }),
            None => Err(INCLUDE_FAILED.to_owned()),
        }
    });
    Ok(options)
}

const INCLUDE_FAILED: &str = "raxel cannot include this";

fn failure(path: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(codes::shader::COMPILE, format!("the shader compiler fails: {reason}"))
        .label(Span::new(path, 0..0), "in this shader")
}

/// Whether a file is HLSL, by its name.
pub(crate) fn is_hlsl(path: &str) -> bool {
    path.to_ascii_lowercase().ends_with(".hlsl")
}

/// What can be said better than by the compiler, or would make it stop the process.
fn refusals(request: &Request, text: &str, is_hlsl: bool) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let path = request.path.as_str();
    let tokens = lexer::tokens(text);
    let start = Span::new(path, 0..0);
    if tokens.is_empty() {
        found.push(Diagnostic::error(codes::shader::EMPTY, format!("`{path}` is empty")).label(start, "no text"));
    } else if !is_hlsl {
        found.extend(version_refusal(path, text, &tokens));
    } else if let Some((range, wrong)) = hlsl::mistake(request, text) {
        found.push(Diagnostic::error(codes::shader::COMPILE, wrong).label(Span::new(path, range), "here"));
    }
    if !is_hlsl && request.entry != "main" {
        found.push(
            Diagnostic::error(
                codes::shader::NO_ENTRY,
                format!("the entry point `{}` is asked for, but GLSL always starts at `main`", request.entry),
            )
            .label(Span::new(path, 0..0), "this is GLSL"),
        );
    } else if !is_identifier(&request.entry) {
        found.push(
            Diagnostic::error(codes::shader::NO_ENTRY, format!("`{}` cannot be an entry point", request.entry))
                .label(Span::new(path, 0..0), "asked for of this shader"),
        );
    }
    for (name, value) in &request.defines {
        if !is_identifier(name) || name == "defined" || name.to_ascii_lowercase().starts_with("gl_") {
            found.push(Diagnostic::error(codes::shader::BAD_DEFINE, format!("`{name}` cannot be defined")));
        }
        if value.contains(['\n', '\r', '\0', '\\']) {
            found.push(Diagnostic::error(codes::shader::BAD_DEFINE, format!("the value of `{name}` is not one line")));
        }
        if value.contains(BUFFER_REFERENCE) {
            found.push(buffer_reference(path).label(Span::new(path, 0..0), format!("with the define `{name}`")));
        }
    }
    found
}

/// A version that has compute shaders must come first. Without one the compiler falls back to a version whose built-in functions it
/// cannot even parse for Vulkan, and prints them.
fn version_refusal(path: &str, text: &str, tokens: &[Token<'_>]) -> Option<Diagnostic> {
    const HELP: &str = "write `#version 460` on the first line";
    let between = |a: &Token<'_>, b: &Token<'_>| text[a.range().end..b.at].chars().all(|c| c == ' ' || c == '\t');
    if let [hash, version, number, profile @ ..] = tokens
        && (hash.text, version.text) == ("#", "version")
        && between(hash, version)
        && between(version, number)
    {
        let es = profile.first().is_some_and(|profile| profile.text == "es" && between(number, profile));
        let known = if es { ["310", "320"].as_slice() } else { ["420", "430", "440", "450", "460"].as_slice() };
        return (!known.contains(&number.text)).then(|| {
            Diagnostic::error(codes::shader::NO_VERSION, format!("version `{}` has no compute shaders", number.text))
                .label(Span::new(path, number.range()), "not this version")
                .help(HELP)
        });
    }
    let first = &tokens[0];
    let diagnostic = match tokens.windows(2).find(|pair| (pair[0].text, pair[1].text) == ("#", "version")) {
        Some(late) => Diagnostic::error(codes::shader::NO_VERSION, "`#version` is not the first thing in the file")
            .label(Span::new(path, late[0].at..late[1].range().end), "this must come first")
            .label(Span::new(path, first.range()), "and comes after this"),
        None => Diagnostic::error(codes::shader::NO_VERSION, format!("`{path}` has no `#version`"))
            .label(Span::new(path, first.range()), "the version must come before this"),
    };
    Some(diagnostic.help(HELP))
}

fn is_identifier(name: &str) -> bool {
    !name.is_empty()
        && !name.starts_with(|c: char| c.is_ascii_digit())
        && name.chars().all(|c| c == '_' || c.is_ascii_alphanumeric())
}

pub(crate) fn options<'a>(request: &Request, hlsl: bool) -> Result<CompileOptions<'a>, shaderc::Error> {
    let mut options = CompileOptions::new()?;
    // SPIR-V 1.5: version 1.6, the default of Vulkan 1.3, has `LocalSizeId`, which needs a device feature.
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
    options.set_target_spirv(SpirvVersion::V1_5);
    // Optimisation strips names, and drivers optimise on their own.
    options.set_optimization_level(OptimizationLevel::Zero);
    options.set_generate_debug_info();
    options.set_auto_bind_uniforms(true);
    options.set_auto_map_locations(true);
    if hlsl {
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
