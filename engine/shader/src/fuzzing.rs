//! A door for the fuzz targets: all that raxel does itself with the texts of a shader, without the compiler.

use raxel_diagnostics::{Diagnostic, Files, SourceMap};

use crate::front_end::{Form, Include};
use crate::request::Request;
use crate::sources::{Sources, directives};
use crate::{compile, hlsl, lexer, messages, stripped};

/// Most includes that are asked for: the includes of a small text can double with each level.
const MOST_INCLUDES: usize = 24;

/// Reads a shader and its includes, and takes `output` for the compiler's messages about it. Returns all messages, with the texts.
pub fn read(files: &dyn Files, path: &str, output: &str) -> (Vec<Diagnostic>, SourceMap) {
    let request = Request { path: path.to_owned(), entry: "main".to_owned(), defines: Vec::new() };
    let mut sources = Sources::new(files);
    let mut found = Vec::new();
    match sources.root(path) {
        Err(diagnostic) => found.push(*diagnostic),
        Ok(text) => {
            found.extend(compile::refusals(&request, &text));
            let mut left = MOST_INCLUDES;
            include_all(&text, path, 1, &mut sources, &mut left);
            found.extend(messages::diagnostics(output, &sources));
        }
    }
    for source in &sources.found {
        check(&request, &source.text);
    }
    found.append(&mut sources.diagnostics);
    (found, sources.texts)
}

/// Asks for the includes of a text and of the texts behind them, as the compiler does.
fn include_all(text: &str, includer: &str, depth: usize, sources: &mut Sources<'_>, left: &mut usize) {
    for (_, line) in directives(text) {
        let rest = line.trim_start().trim_start_matches('#').trim_start();
        let Some(name) = rest.strip_prefix("include").map(str::trim_start) else { continue };
        let (form, end) = if name.starts_with('<') { (Form::Angled, '>') } else { (Form::Quoted, '"') };
        let Some(requested) = name.get(1..).and_then(|name| name.split(end).next()) else { continue };
        if *left == 0 {
            return;
        }
        *left -= 1;
        let mut include = Include { requested: requested.to_owned(), form, includer: includer.to_owned(), depth };
        let mut answer = sources.include(&include);
        if answer.is_none() && form == Form::Quoted {
            include.form = Form::Angled;
            answer = sources.include(&include);
        }
        if let Some((name, text)) = answer {
            include_all(&text, &name, depth + 1, sources, left);
        }
    }
}

/// Tokens lie in the text one behind the other, and stripping twice is stripping once.
fn check(request: &Request, text: &str) {
    let mut end = 0;
    for token in lexer::tokens(text) {
        assert!(token.at >= end && text[token.range()] == *token.text && !token.text.is_empty(), "{token:?}");
        end = token.range().end;
    }
    let lines = lexer::line_ranges(text);
    assert!(lines.iter().all(|line| text.get(line.clone()).is_some_and(|line| !line.contains('\n'))));
    let once = stripped::stripped(text);
    assert!(once.len() <= text.len() + 1, "{once:?} is longer than {text:?}");
    if let Some((range, wrong)) = hlsl::mistake(request, text) {
        assert!(text.get(range).is_some() && !wrong.is_empty());
    }
}
