//! The mistakes in texts that were just edited, long before the modules of their shaders are there: all other texts go to the compiler as
//! outlines ([`crate::outline`]).

use std::collections::{BTreeSet, HashMap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use raxel_diagnostics::{Diagnostic, SourceMap};

use crate::compile;
use crate::compiler::Compiler;
use crate::request::{Request, Shader, ShaderProvider};
use crate::sources::Sources;

/// Most shaders that are looked at: nearly all of a project include its library, and the compiler takes milliseconds for each.
const MOST_SHADERS: usize = 16;

/// Takes the place of a [`Compiler`] to look at edited files alone. It gives no shaders, only the errors in these files, and possibly none: of a
/// request that does not depend on them as well.
///
/// Each error is one that the compiler has for the whole texts, too. Some errors need them: that a function calls itself by way of another file, or
/// that a file which did not change is wrong now.
pub struct FirstLook<'c> {
    compiler: &'c Compiler,
    edited: &'c BTreeSet<String>,
    /// Errors by request: graphs share shaders.
    known: Mutex<HashMap<Request, Vec<Diagnostic>>>,
    is_sure: AtomicBool,
}

impl<'c> FirstLook<'c> {
    /// A look at these files of the project, by their paths. All others must be as they were when the compiler had no errors for them.
    pub fn new(compiler: &'c Compiler, edited: &'c BTreeSet<String>) -> Self {
        Self { compiler, edited, known: Mutex::default(), is_sure: AtomicBool::new(true) }
    }

    /// Whether the files that were edited have no other errors, as far as this look can tell.
    pub fn is_sure(&self) -> bool {
        self.is_sure.load(Ordering::Relaxed)
    }

    fn doubt(&self) {
        self.is_sure.store(false, Ordering::Relaxed);
    }

    fn known(&self) -> MutexGuard<'_, HashMap<Request, Vec<Diagnostic>>> {
        // The map is whole after every operation, so a panic elsewhere does not spoil it.
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn errors(&self, request: &Request, texts: &mut SourceMap) -> Vec<Diagnostic> {
        let edited = self.edited;
        if !self.compiler.may_depend_on(request, edited) {
            return Vec::new();
        }
        if let Some(known) = self.known().get(request) {
            return known.clone();
        }
        if request.is_hlsl() || self.known().len() >= MOST_SHADERS {
            self.doubt();
            return Vec::new();
        }
        let mut sources = Sources::with_outlines(self.compiler.files(), edited);
        match sources.root(&request.path) {
            Ok(text) => drop(compile::compile(request, &text, false, &mut sources, None)),
            Err(diagnostic) => sources.diagnostics.push(*diagnostic),
        }
        texts.extend(&sources.texts);
        let mut errors = sources.diagnostics;
        errors.retain(Diagnostic::is_error);
        let found = errors.len();
        let is_edited =
            |error: &Diagnostic| error.labels.first().is_some_and(|label| edited.contains(&*label.span.file));
        errors.retain(is_edited);
        if errors.len() < found {
            self.doubt();
        }
        self.known().insert(request.clone(), errors.clone());
        errors
    }
}

impl ShaderProvider for FirstLook<'_> {
    fn shader(
        &self,
        request: &Request,
        texts: &mut SourceMap,
    ) -> Result<(Arc<Shader>, Vec<Diagnostic>), Vec<Diagnostic>> {
        Err(self.errors(request, texts))
    }
}
