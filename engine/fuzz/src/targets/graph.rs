//! Graph files, from the text to the plan and everything that is printed of it. Shaders are compiled once: a graph that names one with other
//! defines gets the same module.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use raxel_diagnostics::{Diagnostic, MemoryFiles, SourceMap};
use raxel_graph::Phase;
use raxel_graph::plan::{PlanInput, SourceSize};
use raxel_graph::print::{dot, json, mermaid, text};
use raxel_graph::{SourceLayout, dump, plan};
use raxel_graphfile::compile;
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Block, Member, Scalar, Type};
use raxel_shader::{Compiler, Request, Shader, ShaderProvider};

use crate::bounds::Bounds;
use crate::{Mutation, Target, check, projects};

pub(crate) const TARGET: Target = Target {
    name: "graph",
    run,
    bounds: Bounds::PARSER,
    mutation: Mutation::Toml(raxel_graphfile::schema),
    seeds: &["engine/graphfile/tests/front/base.toml"],
    longest: 16 << 10,
    quick: 1500,
};

/// The file of the input.
const PATH: &str = "graphs/main.toml";

/// The graph with every construct, which inputs may extend, and its shaders.
const FILES: [(&str, &str); 5] = [
    ("graphs/base.toml", include_str!("../../front/base.toml")),
    ("shaders/primary.comp", include_str!("../../front/primary.comp")),
    ("shaders/pyramid.comp", include_str!("../../front/pyramid.comp")),
    ("shaders/probes.comp", include_str!("../../front/probes.comp")),
    ("shaders/include/world.glsl", include_str!("../../front/world.glsl")),
];

fn run(input: &[u8]) {
    let files = MemoryFiles::new(FILES);
    projects::add(&files, PATH, input);
    let mut texts = SourceMap::default();
    let compiled = compile(PATH, &files, &*SHADERS, &*SOURCES, &mut texts);
    let Some(graph) = check::outcome(compiled, &texts) else { return };
    let graph = Arc::new(graph);
    let sources = SOURCES.iter().map(|source| (source.name.clone(), SourceSize { bytes: 4096, image: Some([64; 3]) }));
    let sources: BTreeMap<String, SourceSize> = sources.collect();
    for (output, poison, holds) in [([1280, 720], false, true), ([1, 1], true, false), ([16384, 3], false, true)] {
        let paper = PlanInput::on_paper(&graph, output, &sources);
        let input = PlanInput { facts: &|_| holds, alias: !poison, poison, ..paper };
        match plan(graph.clone(), &input) {
            Ok(plan) => {
                let parsed: Result<serde_json::Value, _> = serde_json::from_str(&json(&plan));
                assert!(parsed.is_ok(), "the plan as JSON is none");
                assert!(!text(&plan).is_empty() && !dot(&plan).is_empty() && !mermaid(&plan).is_empty());
                assert!(dump(graph.clone(), &input, Phase::Barriers).is_ok(), "a plan without its phases");
            }
            Err(found) => {
                assert!(found.iter().any(Diagnostic::is_error), "refused without an error: {found:?}");
                check::diagnostics(&found, &texts);
            }
        }
    }
}

static SHADERS: LazyLock<Compiled> = LazyLock::new(|| Compiled {
    compiler: Compiler::new(Arc::new(MemoryFiles::new(FILES))).with_cache(None),
    shaders: Mutex::default(),
});

/// Shaders by path, compiled as the graph with every construct names them.
struct Compiled {
    compiler: Compiler,
    shaders: Mutex<HashMap<String, Arc<Shader>>>,
}

impl ShaderProvider for Compiled {
    fn shader(
        &self,
        request: &Request,
        texts: &mut SourceMap,
    ) -> Result<(Arc<Shader>, Vec<Diagnostic>), Vec<Diagnostic>> {
        for (path, text) in FILES {
            texts.insert(path, text);
        }
        if let Some(shader) = self.shaders.lock().unwrap_or_else(PoisonError::into_inner).get(&request.path) {
            return Ok((shader.clone(), Vec::new()));
        }
        let defines = [("FAST", "1"), ("MAX_STEPS", "256"), ("NAME", "vec3(1)")];
        let defines = defines.map(|(name, value)| (name.to_owned(), value.to_owned()));
        let usual = Request { path: request.path.clone(), entry: "main".to_owned(), defines: defines.to_vec() };
        // A shader is compiled once. A missing one is looked for each time.
        let (shader, _) = self.compiler.shader(&usual, texts)?;
        self.shaders.lock().unwrap_or_else(PoisonError::into_inner).insert(request.path.clone(), shader.clone());
        Ok((shader, Vec::new()))
    }
}

/// The layouts that a runtime would supply.
static SOURCES: LazyLock<Vec<SourceLayout>> = LazyLock::new(|| {
    let member = |name: &str, offset, ty| Member { name: name.to_owned(), offset, ty, place: None };
    let words = Type::Array { element: Box::new(Type::Scalar(Scalar::U32)), len: None, stride: 4 };
    let members = vec![
        member("origin", 0, Type::Vector(Scalar::I32, 3)),
        member("root", 12, Type::Scalar(Scalar::U32)),
        member("words", 16, words),
    ];
    let block = Block { name: "RxWorld".to_owned(), size: 16, members };
    let layout = |name: &str, access, image, collected| SourceLayout {
        name: name.to_owned(),
        access,
        image,
        collected,
        block: block.clone(),
    };
    vec![
        layout("world.tree64", Access::Read, None, None),
        layout("world.chunks", Access::Read, None, None),
        layout("world.texture3d", Access::Read, Some(Format::R16ui), None),
        layout("world.edits", Access::ReadWrite, None, Some(4096)),
    ]
});
