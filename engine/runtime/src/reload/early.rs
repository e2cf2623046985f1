//! Compiles shaders of an edit before the edit is finished: its files are whole already, and only others of the same save are waited for.

use super::debounce::Debounce;
use crate::load::{LoadOutcome, Loader};
use crate::recording_files::{Content, content};
use raxel_graph::checked::Graph;

/// The files that were compiled early last, as they were.
#[derive(Debug, Default)]
pub(crate) struct Early {
    compiled: Vec<(String, Content)>,
}

impl Early {
    /// Leaves the modules of a graph whose files are whole in the compiler's cache, where the finished edit finds them. A file is compiled once as it
    /// is.
    pub(crate) fn compile(&mut self, debounce: &Debounce, loader: &Loader, path: &str, graph: &LoadOutcome<Graph>) {
        let files = loader.files();
        let whole = debounce.whole(|path| content(&files.read(path)));
        if whole.is_empty() || whole == self.compiled {
            return;
        }
        let paths: Vec<String> = whole.iter().map(|(path, _)| path.clone()).collect();
        self.compiled = whole;
        if graph.depends_on(&paths) {
            let _span = tracing::debug_span!("compile early", path).entered();
            // The finished edit loads it again, with whatever else the save changes.
            drop(loader.graph(path));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Instant;

    use raxel_diagnostics::DiskFiles;

    use super::super::debounce::FileActivity;
    use super::*;

    const GRAPH: &str = "name = 'a'\npresent = 'color'\n[targets.color]\nformat = 'rgba8'\n[[passes]]\nname = 'draw'\n\
        shader = 'draw.comp'\ndispatch = { threads = 'color' }\nbind = { color = 'color' }\n";

    fn shader(red: &str) -> String {
        format!(
            "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(rgba8) uniform writeonly image2D color;\n\
             void main() {{ imageStore(color, ivec2(gl_GlobalInvocationID.xy), vec4({red}, 0.0, 0.0, 1.0)); }}\n"
        )
    }

    #[test]
    fn a_shader_is_compiled_while_its_edit_is_waited_for() {
        let project = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = project.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        write("graphs/a.toml", GRAPH);
        write("shaders/draw.comp", &shader("0.1"));
        let loader = Loader::with_files(Arc::new(DiskFiles::new(project.path()).unwrap()));
        let graph = loader.graph("graphs/a.toml");
        assert!(graph.result.is_ok(), "{:?}", graph.result);
        assert_eq!(loader.compiled(), 1);
        let mut debounce = Debounce::default();
        debounce.expect(graph.files.clone());
        let mut early = Early::default();

        let now = Instant::now();
        write("shaders/draw.comp", &shader("0.2"));
        debounce.touch("shaders/draw.comp", FileActivity::Open, now);
        early.compile(&debounce, &loader, "graphs/a.toml", &graph);
        assert_eq!(loader.compiled(), 1, "it may not be whole");
        debounce.touch("shaders/draw.comp", FileActivity::Finished, now);
        for _ in 0..2 {
            early.compile(&debounce, &loader, "graphs/a.toml", &graph);
            assert_eq!(loader.compiled(), 2);
        }
        assert!(
            debounce.changed(now, |path| content(&loader.files().read(path))).is_empty(),
            "the edit is not finished"
        );
        assert!(loader.graph("graphs/a.toml").result.is_ok());
        assert_eq!(loader.compiled(), 2, "the finished edit finds the module");
    }
}
