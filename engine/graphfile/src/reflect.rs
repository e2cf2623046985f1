//! Phase 4, reflect: every distinct shader is compiled once, several at a time, and its interface lists its needs.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_shader::{Request, Shader, ShaderProvider};

use crate::resolve::Resolved;

/// The shader of each pass; `None` where it did not compile or was never named.
pub(crate) type Reflected = Vec<Option<Arc<Shader>>>;

type Outcome = Result<(Arc<Shader>, Vec<Diagnostic>), Vec<Diagnostic>>;

/// Compiles the shaders of all passes. Errors of all of them are reported, each once, with the first pass that uses the shader.
pub(crate) fn reflect(
    graph: &Resolved,
    source: &dyn ShaderProvider,
    texts: &mut SourceMap,
    found: &mut Vec<Diagnostic>,
) -> Reflected {
    // Passes that ask for the same thing share it.
    let mut numbers: HashMap<&Request, usize> = HashMap::new();
    let mut distinct: Vec<&Request> = Vec::new();
    let wanted: Vec<Option<usize>> = (graph.passes.iter())
        .map(|pass| {
            let request = &pass.request.as_ref()?.value;
            Some(*numbers.entry(request).or_insert_with(|| {
                distinct.push(request);
                distinct.len() - 1
            }))
        })
        .collect();
    let outcomes = compile(&distinct, source, texts);
    let mut reported: Vec<Diagnostic> = Vec::new();
    for (number, outcome) in outcomes.iter().enumerate() {
        let news = match outcome {
            Ok((_, warnings)) => warnings,
            Err(errors) => errors,
        };
        let user = wanted.iter().position(|wanted| *wanted == Some(number)).map(|index| &graph.passes[index]);
        for diagnostic in news {
            // Two requests for one file, with different defines, often fail alike.
            if reported.contains(diagnostic) {
                continue;
            }
            reported.push(diagnostic.clone());
            let mut diagnostic = diagnostic.clone();
            let request = user.and_then(|pass| Some((pass, pass.request.as_ref()?)));
            if let Some((pass, request)) = request.filter(|_| diagnostic.is_error()) {
                diagnostic = diagnostic.label(request.span.clone(), format!("for pass `{}`", pass.name.value));
            }
            found.push(diagnostic);
        }
    }
    let shaders: Vec<Option<Arc<Shader>>> =
        outcomes.into_iter().map(|outcome| outcome.ok().map(|(shader, _)| shader)).collect();
    wanted.into_iter().map(|wanted| shaders[wanted?].clone()).collect()
}

/// Compiles each request on as many threads as there are cores; results in the order of the requests.
fn compile(requests: &[&Request], source: &dyn ShaderProvider, texts: &mut SourceMap) -> Vec<Outcome> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let work = || {
        let (mut texts, mut done) = (SourceMap::default(), Vec::new());
        while let Some(request) = requests.get(next.fetch_add(1, Ordering::Relaxed)) {
            done.push((*request, source.shader(request, &mut texts)));
        }
        (texts, done)
    };
    let (mut read, mut done) = thread::scope(|scope| {
        let others: Vec<_> = (1..cores.min(requests.len())).map(|_| scope.spawn(work)).collect();
        let mut all = work();
        for other in others {
            match other.join() {
                Ok((texts, done)) => {
                    all.0.extend(&texts);
                    all.1.extend(done);
                }
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    texts.extend(&std::mem::take(&mut read));
    let order: HashMap<&Request, usize> =
        requests.iter().enumerate().map(|(index, request)| (*request, index)).collect();
    done.sort_by_key(|(request, _)| order[*request]);
    done.into_iter().map(|(_, outcome)| outcome).collect()
}
