//! The command line's cache from one run to the next: compiled shaders and pipelines, in the user's cache.

use raxel_cache::{Cache, CacheLocation};
use raxel_diagnostics::{Diagnostic, SourceMap, codes};

use crate::console::{Console, To};

/// Lets this process use the cache of the environment.
pub fn open(console: &Console) {
    let CacheLocation::Folder(folder) = CacheLocation::of_environment() else { return };
    let console = console.clone();
    raxel_cache::use_in_process(Cache::at(folder).with_warning(move |path, reason| {
        let message = format!("`{}` is not used: {reason}", path.display());
        let warning = Diagnostic::warning(codes::session::BAD_CACHE, message).note("it is made again");
        console.diagnostics(&[warning], &SourceMap::default(), To::Stderr);
    }));
}
