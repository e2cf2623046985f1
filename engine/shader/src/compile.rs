//! GLSL and HLSL to SPIR-V through shaderc.

use std::sync::Arc;

use raxel_cache::Cache;
use raxel_diagnostics::{Diagnostic, Span, codes};

use crate::fatal::{BUFFER_REFERENCE, buffer_reference};
use crate::front_end::{self, Include, Job, Outcome};
use crate::hlsl;
use crate::lexer::{self, Token};
use crate::messages;
use crate::module_cache::Keeper;
use crate::request::Request;
use crate::sources::Sources;
use crate::worker::{self, Stopped};

/// Compiles the text of a request; all messages about it go to `sources.diagnostics`. `None` when there is an error. The module is kept in
/// `cache`, with the numbers of its lines if it is to be `checked`.
pub(crate) fn compile(
    request: &Request,
    text: &Arc<str>,
    checked: bool,
    sources: &mut Sources<'_>,
    cache: Option<&Cache>,
) -> Option<Vec<u32>> {
    let refusals = refusals(request, text);
    if !refusals.is_empty() {
        sources.diagnostics.extend(refusals);
        return None;
    }
    let job = Job { request: request.clone(), text: text.clone() };
    let mut keeper = cache.map(|cache| Keeper::new(cache, checked));
    let mut include = |include: Include| {
        let answer = sources.include(&include);
        if let Some(keeper) = &mut keeper {
            keeper.asked(include, &answer);
        }
        answer
    };
    let outcome = worker::compile(&job, &mut include).unwrap_or_else(|| Ok(front_end::compile(&job, &mut include)));
    match outcome {
        Ok(Outcome::Module { words, warnings }) => {
            let found = messages::diagnostics(&warnings, sources);
            sources.diagnostics.extend(found);
            if let Some(keeper) = keeper {
                keeper.keep(&job, &words, &warnings);
            }
            Some(words)
        }
        Ok(Outcome::Mistakes(output)) => {
            let found = messages::diagnostics(&output, sources);
            // After a missing include all else is doubtful: its declarations are missing too.
            let include_failed = sources.diagnostics.iter().any(Diagnostic::is_error);
            sources.diagnostics.extend(found.into_iter().filter(|found| !include_failed || !found.is_error()));
            if !sources.diagnostics.iter().any(Diagnostic::is_error) {
                sources.diagnostics.push(failure(&request.path, output.trim()));
            }
            None
        }
        Ok(Outcome::OutOfMemory) => {
            sources.diagnostics.push(failure(&request.path, "there is not enough memory"));
            None
        }
        Ok(Outcome::Failed(reason)) => {
            sources.diagnostics.push(failure(&request.path, &reason));
            None
        }
        Err(stopped) => {
            sources.diagnostics.push(interrupted(&request.path, stopped));
            None
        }
    }
}

/// The message when the compiler had to be ended, or ended itself.
fn interrupted(path: &str, stopped: Stopped) -> Diagnostic {
    let place = |diagnostic: Diagnostic| diagnostic.label(Span::new(path, 0..0), "in this shader");
    match stopped {
        Stopped::Time(limits) => place(Diagnostic::error(
            codes::shader::TOO_MUCH,
            format!("`{path}` takes the shader compiler more than {} s and was given up", limits.seconds),
        ))
        .help("look for structs of structs, macros of macros and arrays of arrays, whose size multiplies with each level"),
        Stopped::Memory(limits) => place(Diagnostic::error(
            codes::shader::TOO_MUCH,
            format!("`{path}` takes the shader compiler more than {} MiB and was given up", limits.bytes >> 20),
        ))
        .help("look for large constant arrays, and for types whose size multiplies with each level; large tables belong into a buffer"),
        Stopped::Crash => failure(path, "it breaks down over a mistake that it does not report")
            .help("take back the last edit, and look for an operator or a member that makes no sense"),
    }
}

fn failure(path: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(codes::shader::COMPILE, format!("the shader compiler fails: {reason}"))
        .label(Span::new(path, 0..0), "in this shader")
}

/// Mistakes that raxel reports better than the compiler, or that would make it stop the process.
pub(crate) fn refusals(request: &Request, text: &str) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let is_hlsl = request.is_hlsl();
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
