//! The texts of one shader: the file itself and its includes, found inside the project or in the embedded library.

use std::collections::BTreeSet;
use std::sync::Arc;

use raxel_diagnostics::files::{self, join};
use raxel_diagnostics::{Diagnostic, FileError, Files, SourceMap, Span, codes};

use crate::front_end::{Form, Include, Included};
use crate::limits::TextLimits;
use crate::outline::outline;
use crate::request::is_hlsl;
use crate::{fatal, lexer, library};

/// Where shaders live in a project, and where `<…>` includes are looked for.
const SHADERS: &str = "shaders";
const INCLUDE: &str = "shaders/include";

/// Longest chain of includes.
const MAX_DEPTH: usize = 32;
/// Most bytes that all texts of one shader may have together, counted as often as they are included.
const MAX_BYTES: usize = 4 << 20;

/// A path that was asked for, and the hash of its content (`None`: nothing). A shader stays valid as long as all of its questions have the
/// same answers.
pub(crate) type Dependency = (String, Option<blake3::Hash>);

/// One text that went into a shader.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// Project path, or `<raxel/…>` for a file of the embedded library.
    pub name: String,
    /// The text.
    pub text: Arc<str>,
    /// Where it is included: the first place, and every other one that adds its text again.
    included_at: Vec<Span>,
}

/// Reads and remembers the texts of one compilation.
pub(crate) struct Sources<'f> {
    files: &'f dyn Files,
    /// In order of first inclusion; the shader itself is the first.
    pub found: Vec<Source>,
    /// Every question asked of `files`.
    pub dependencies: Vec<Dependency>,
    /// Texts to render diagnostics with (also those that could not be used).
    pub texts: SourceMap,
    /// The errors.
    pub diagnostics: Vec<Diagnostic>,
    /// Names of the files being included right now, outermost first.
    stack: Vec<String>,
    /// (includer, requested) that were refused: the compiler asks a second time for a quoted include that failed.
    refused: Vec<(String, String)>,
    bytes: usize,
    limits: TextLimits,
    /// The files whose texts go to the compiler whole, and all others as outlines. `None`: every text is whole.
    whole: Option<&'f BTreeSet<String>>,
}

impl<'f> Sources<'f> {
    pub(crate) fn new(files: &'f dyn Files) -> Self {
        Self {
            files,
            found: Vec::new(),
            dependencies: Vec::new(),
            texts: SourceMap::default(),
            diagnostics: Vec::new(),
            stack: Vec::new(),
            refused: Vec::new(),
            bytes: 0,
            limits: TextLimits::default(),
            whole: None,
        }
    }

    /// Gives the compiler outlines of all texts but these.
    pub(crate) fn with_outlines(files: &'f dyn Files, whole: &'f BTreeSet<String>) -> Self {
        Self { whole: Some(whole), ..Self::new(files) }
    }

    /// Reads the shader itself.
    pub(crate) fn root(&mut self, path: &str) -> Result<Arc<str>, Box<Diagnostic>> {
        let text = self.read(path, None)?.ok_or_else(|| Box::new(files::not_found(self.files, path, None, SHADERS)))?;
        self.count(path, &text, &Span::new(path, 0..0))?;
        self.stack = vec![path.to_owned()];
        self.found.push(Source { name: path.to_owned(), text: text.clone(), included_at: Vec::new() });
        Ok(self.for_compiler(path, text))
    }

    /// Answers an `#include`: the name and the text to put there. On `None` the reason is in `diagnostics`.
    pub(crate) fn include(&mut self, include: &Include) -> Included {
        let Include { requested, form, includer, depth } = include;
        let (form, depth) = (*form, *depth);
        let question = (includer.clone(), requested.clone());
        if self.refused.contains(&question) {
            return None;
        }
        self.stack.truncate(depth);
        match self.resolve(requested, form, includer) {
            Ok(Some(answer)) => Some(answer),
            // A quoted include is asked for once more as an angled one.
            Ok(None) if form == Form::Quoted => None,
            Ok(None) => {
                self.refused.push(question);
                let diagnostic = self.not_found(requested, includer);
                self.diagnostics.push(diagnostic);
                None
            }
            Err(diagnostic) => {
                self.refused.push(question);
                let diagnostic = self.with_chain(*diagnostic, includer);
                self.diagnostics.push(diagnostic);
                None
            }
        }
    }

    fn resolve(
        &mut self,
        requested: &str,
        form: Form,
        includer: &str,
    ) -> Result<Option<(String, Arc<str>)>, Box<Diagnostic>> {
        let place = self.directive(includer, requested);
        for folder in folders(form, includer) {
            let Some(path) = join(&folder, requested) else {
                return Err(Box::new(
                    Diagnostic::error(
                        codes::shader::INCLUDE_OUTSIDE,
                        format!("include `{requested}` leaves the project root"),
                    )
                    .label(place, "included here")
                    .help("includes are relative paths inside the project, with `/` between their parts"),
                ));
            };
            let in_library = path.strip_prefix(INCLUDE).map(|rest| rest.trim_start_matches('/'));
            let library_name = in_library.map(|name| format!("<{name}>"));
            let known = self
                .found
                .iter()
                .find(|source| source.name == path || library_name.as_ref().is_some_and(|name| source.name == *name));
            let (name, text) = if let Some(source) = known {
                (source.name.clone(), source.text.clone())
            } else if let Some(text) = self.read(&path, Some(&place))? {
                (path, text)
            } else if let Some(binding) = in_library.and_then(library::world_binding) {
                let Some(text) = self.world_of(binding, &path, &place)? else { continue };
                text
            } else if let (Some(text), Some(name)) = (in_library.and_then(library::text), library_name) {
                let text: Arc<str> = text.into();
                self.texts.insert(name.as_str(), text.clone());
                (name, text)
            } else {
                continue;
            };
            return self.enter(name, text, place).map(Some);
        }
        Ok(None)
    }

    /// The name and text of `raxel/world/BINDING.glsl`, which is made of a template: the project's, or else the library's.
    fn world_of(
        &mut self,
        binding: &str,
        path: &str,
        place: &Span,
    ) -> Result<Option<(String, Arc<str>)>, Box<Diagnostic>> {
        let own = join(INCLUDE, library::WORLD_TEMPLATE).map(|template| self.read(&template, Some(place)));
        let (name, template) = match own.transpose()?.flatten() {
            Some(template) => (path.to_owned(), template),
            None => match library::text(library::WORLD_TEMPLATE) {
                Some(template) => {
                    (format!("<{}>", path.trim_start_matches(INCLUDE).trim_start_matches('/')), template.into())
                }
                None => return Ok(None),
            },
        };
        let text: Arc<str> = library::for_binding(&template, binding).into();
        self.texts.insert(name.as_str(), text.clone());
        Ok(Some((name, text)))
    }

    /// Opens a file that was found: checks the chain of includes, and makes a protected file empty the second time.
    fn enter(&mut self, name: String, text: Arc<str>, place: Span) -> Result<(String, Arc<str>), Box<Diagnostic>> {
        let protection = Protection::of(&text);
        let again = self.found.iter().any(|source| source.name == name);
        let open = self.stack.contains(&name);
        let empty = (again && protection == Protection::Once) || (open && protection == Protection::Guard);
        if open && !empty {
            let start = self.stack.iter().position(|file| *file == name).unwrap_or(0);
            let chain: Vec<_> = self.stack[start..].iter().chain([&name]).map(|file| format!("`{file}`")).collect();
            return Err(Box::new(
                Diagnostic::error(codes::shader::INCLUDE_CYCLE, format!("`{name}` includes itself"))
                    .label(place, "the cycle closes here")
                    .note(format!("the cycle is {}", chain.join(" → ")))
                    .help("move what both need into a third file, or put `#pragma once` into the files"),
            ));
        }
        if self.stack.len() > MAX_DEPTH {
            return Err(Box::new(
                Diagnostic::error(
                    codes::shader::TOO_MUCH,
                    format!("includes are nested deeper than {MAX_DEPTH} files"),
                )
                .label(place, "one too many"),
            ));
        }
        self.count(&name, &text, &place)?;
        match self.found.iter_mut().find(|source| source.name == name) {
            None => self.found.push(Source { name: name.clone(), text: text.clone(), included_at: vec![place] }),
            Some(source) if protection == Protection::None && !source.included_at.contains(&place) => {
                source.included_at.push(place);
            }
            Some(_) => {}
        }
        self.stack.push(name.clone());
        let text = match protection {
            _ if empty => Arc::from(""),
            // The compiler warns about a pragma that has been dealt with here; spaces keep every column.
            Protection::Once => without_once(&text).into(),
            _ => text,
        };
        let text = self.for_compiler(&name, text);
        Ok((name, text))
    }

    fn for_compiler(&self, name: &str, text: Arc<str>) -> Arc<str> {
        let is_whole = self.whole.is_none_or(|whole| whole.contains(name));
        if is_whole { text } else { outline(&text).into() }
    }

    /// Counts a text against the limits of one shader. `place` is where it comes in.
    fn count(&mut self, name: &str, text: &str, place: &Span) -> Result<(), Box<Diagnostic>> {
        self.bytes += text.len();
        if self.bytes > MAX_BYTES {
            let message = format!("the texts of this shader have more than {MAX_BYTES} bytes with all includes");
            return Err(Box::new(
                Diagnostic::error(codes::shader::TOO_MUCH, message).label(place.clone(), "too much with this one"),
            ));
        }
        let tokens = lexer::tokens(text);
        self.limits.check(text, &tokens).map_err(|(range, message)| {
            Box::new(
                Diagnostic::error(codes::shader::TOO_MUCH, message).label(Span::new(name, range), "more than this"),
            )
        })?;
        let root = self.found.first().map_or(name, |root| &root.name);
        match fatal::refusal(name, &tokens, is_hlsl(root)) {
            Some(diagnostic) => Err(Box::new(diagnostic)),
            None => Ok(()),
        }
    }

    /// Reads a text and remembers the answer; `None` when there is no such file.
    fn read(&mut self, path: &str, place: Option<&Span>) -> Result<Option<Arc<str>>, Box<Diagnostic>> {
        let bytes = match self.files.read(path) {
            Ok(bytes) => bytes,
            Err(FileError::NotFound) => {
                self.dependencies.push((path.to_owned(), None));
                return Ok(None);
            }
            Err(error) => {
                return Err(Box::new(error.diagnostic(path, place.map(|place| (place.clone(), "included here")))));
            }
        };
        self.dependencies.push((path.to_owned(), Some(blake3::hash(&bytes))));
        let text = files::read_text(&Given(bytes), path, None, &mut self.texts)?;
        if let Some(at) = text.find('\0') {
            return Err(Box::new(
                Diagnostic::error(codes::shader::BAD_TEXT, format!("`{path}` holds a zero byte at offset {at}"))
                    .label(Span::new(path, at..at + 1), "the first zero byte"),
            ));
        }
        Ok(Some(text))
    }

    fn not_found(&self, requested: &str, includer: &str) -> Diagnostic {
        let place = self.directive(includer, requested);
        let quoted = self.text(includer).is_some_and(|text| text[place.range.clone()].starts_with('"'));
        let form = if quoted { Form::Quoted } else { Form::Angled };
        let mut tried: Vec<String> = Vec::new();
        for folder in folders(form, includer) {
            if let Some(path) = join(&folder, requested)
                && !tried.contains(&path)
            {
                tried.push(path);
            }
        }
        let mut diagnostic =
            Diagnostic::error(codes::shader::INCLUDE_NOT_FOUND, format!("include `{requested}` was not found"))
                .label(place, "included here")
                .note(format!("looked for {}", tried.join(", ")));
        if let Some(name) = library::closest(requested) {
            diagnostic = diagnostic.help(format!("did you mean `<{name}>`?"));
        }
        self.with_chain(diagnostic, includer)
    }

    /// Names the files that included `name`.
    ///
    /// A file of a layout is included once for each world that has it, and the compiler does not say which time it means: then
    /// every way to it is given.
    pub(crate) fn with_chain(&self, diagnostic: Diagnostic, name: &str) -> Diagnostic {
        let mut notes = Vec::new();
        let mut left: Vec<&Span> = self.included_at(name).rev().collect();
        while let Some(span) = left.pop()
            && notes.len() < MAX_DEPTH
        {
            let line = self.text(&span.file).map_or(0, |text| lexer::line_of(text, span.range.start));
            let note = format!("included from {}:{line}", span.file);
            if !notes.contains(&note) {
                notes.push(note);
                left.extend(self.included_at(&span.file).rev());
            }
        }
        notes.into_iter().fold(diagnostic, Diagnostic::note)
    }

    /// The text that is included on a line of a file.
    pub(crate) fn included_on_line(&self, file: &str, line: usize) -> Option<&Source> {
        let text = self.text(file)?;
        let is_it = |span: &Span| *span.file == *file && lexer::line_of(text, span.range.start) == line;
        self.found.iter().find(|source| source.included_at.iter().any(is_it))
    }

    fn included_at(&self, name: &str) -> impl DoubleEndedIterator<Item = &Span> {
        self.source(name).into_iter().flat_map(|source| &source.included_at)
    }

    /// The place where the shader includes the world of this binding by `raxel/world/BINDING.glsl`, whose text names the declarations of a
    /// layout.
    pub(crate) fn world_include(&self, binding: &str) -> Option<&Span> {
        let of = |name: &str| {
            let name = name.strip_prefix(INCLUDE).map_or(name, |rest| rest.trim_start_matches('/'));
            library::world_binding(name.trim_start_matches('<').trim_end_matches('>')).map(str::to_owned)
        };
        let own = binding.strip_suffix("_voxels");
        let source = self
            .found
            .iter()
            .find(|source| of(&source.name).is_some_and(|known| known == binding || Some(known.as_str()) == own))?;
        source.included_at.first()
    }

    pub(crate) fn source(&self, name: &str) -> Option<&Source> {
        self.found.iter().find(|source| source.name == name)
    }

    pub(crate) fn text(&self, name: &str) -> Option<&Arc<str>> {
        self.source(name).map(|source| &source.text)
    }

    /// Where `includer` writes `#include` with this name: the name with its quotes. The start of the file if it is not plain to
    /// see, as when a macro gives the name.
    fn directive(&self, includer: &str, requested: &str) -> Span {
        let text = self.text(includer).map_or("", |text| text);
        let found = directives(text).find_map(|(offset, line)| {
            let rest = line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("include")?;
            let name = rest.trim_start();
            let inner = name.strip_prefix(['"', '<'])?.strip_prefix(requested)?;
            inner.starts_with(['"', '>']).then(|| {
                let start = offset + (line.len() - name.len());
                start..start + requested.len() + 2
            })
        });
        Span::new(includer, found.unwrap_or(0..0))
    }
}

/// Bytes that have been read already.
struct Given(Arc<[u8]>);

impl Files for Given {
    fn read(&self, _: &str) -> Result<Arc<[u8]>, FileError> {
        Ok(self.0.clone())
    }
}

/// The folders an include is looked for in, in order.
fn folders(form: Form, includer: &str) -> Vec<String> {
    match form {
        Form::Angled => vec![INCLUDE.to_owned()],
        Form::Quoted => {
            let own = match includer.strip_prefix('<') {
                Some(library) => format!("{INCLUDE}/{}", parent(library)),
                None => parent(includer).to_owned(),
            };
            vec![own, SHADERS.to_owned(), INCLUDE.to_owned()]
        }
    }
}

fn parent(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Lines that start with `#`, with their offsets.
pub(crate) fn directives(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split_inclusive('\n')
        .scan(0, |offset, line| {
            let start = *offset;
            *offset += line.len();
            Some((start, line))
        })
        .filter(|(_, line)| line.trim_start().starts_with('#'))
}

/// The include guard of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Protection {
    /// Not at all.
    None,
    /// `#pragma once`.
    Once,
    /// `#ifndef X`, `#define X` as its first directives.
    Guard,
}

impl Protection {
    fn of(text: &str) -> Self {
        if directives(text).any(|(_, line)| is_once(line)) {
            return Self::Once;
        }
        let mut lines = directives(text).map(|(_, line)| line.trim_start().trim_start_matches('#').trim());
        let guard = lines.next().and_then(|line| line.strip_prefix("ifndef")).map(str::trim);
        let defined = lines.next().and_then(|line| line.strip_prefix("define")).map(str::trim);
        match (guard, defined) {
            (Some(guard), Some(defined)) if !guard.is_empty() && guard == defined => Self::Guard,
            _ => Self::None,
        }
    }
}

fn is_once(line: &str) -> bool {
    let mut words = line.trim_start().trim_start_matches('#').split_whitespace();
    words.next() == Some("pragma") && words.next() == Some("once")
}

fn without_once(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with('#') && is_once(line) {
            out.extend(line.chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        } else {
            out.push_str(line);
        }
    }
    out
}
