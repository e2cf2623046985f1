//! Shaders as the compiler of graphs sees them: an interface from somewhere. Here it is made by hand, like that of a module without
//! its source.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_graphfile::compile;
use raxel_shader::interface::{Access, Binding, BindingKind, ByteRanges, Dim, Interface, LocalSize, ScalarKind};
use raxel_shader::{Request, Shader, ShaderProvider};

use crate::files::Project;

const GRAPH: &str = include_str!("../fixtures/modules/modules.toml");

/// Every module stores to one image, and knows nothing of its source.
#[derive(Default)]
struct Modules {
    asked: AtomicUsize,
    arrays: u32,
}

impl ShaderProvider for Modules {
    fn shader(&self, request: &Request, _: &mut SourceMap) -> Result<(Arc<Shader>, Vec<Diagnostic>), Vec<Diagnostic>> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        let kind = BindingKind::StorageImage { format: None, dim: Dim::D2, arrayed: false, scalar: ScalarKind::Float };
        let result = Binding {
            name: "result".to_owned(),
            set: 0,
            binding: 0,
            count: 1 + self.arrays,
            kind,
            access: Access::Write,
            reads: ByteRanges::default(),
            place: None,
        };
        let interface = Interface {
            entry: request.entry.clone(),
            local_size: [8, 8, 1].map(|value| LocalSize { value, spec_id: None }),
            bindings: vec![result],
            ..Interface::default()
        };
        let key = [request.defines.len() as u8; 32];
        let files = vec![request.path.clone()];
        let spirv = Arc::from(Vec::new());
        Ok((Arc::new(Shader { request: request.clone(), spirv, interface, files, key, module: key }), Vec::new()))
    }
}

fn project() -> Project {
    let mut project = Project::new();
    project.put("graphs/modules.toml", GRAPH);
    project
}

#[test]
fn equal_requests_are_compiled_once() {
    let modules = Modules::default();
    let compiled = compile("graphs/modules.toml", &project(), &modules, &Vec::new(), &mut SourceMap::default());
    let (graph, _) = compiled.unwrap();
    assert_eq!(modules.asked.load(Ordering::Relaxed), 2);
    assert_eq!(graph.pass(graph.find_pass("third").unwrap()).shader.request.defines.len(), 1);
}

#[test]
fn a_module_without_its_source_is_named() {
    let modules = Modules { arrays: 3, ..Modules::default() };
    let compiled = compile("graphs/modules.toml", &project(), &modules, &Vec::new(), &mut SourceMap::default());
    let found = compiled.unwrap_err();
    assert_eq!(found[0].code.as_str(), "RX0131");
    assert_eq!(found[0].message, "`result[4]` is an array of bindings, which a graph cannot bind");
    assert_eq!(found[0].labels[0].span.file.as_ref(), "graphs/modules.toml");
    assert!(found[0].notes[0].ends_with("in `shaders/store.spv`"), "{:?}", found[0].notes);
}
