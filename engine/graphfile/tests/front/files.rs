//! A project in memory: the graph that all tests start from, its shaders, and edits of both.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use raxel_diagnostics::render::human;
use raxel_diagnostics::{Diagnostic, FileError, Files, SourceMap};
use raxel_graph::SourceLayout;
use raxel_graphfile::{Compiled, compile};
use raxel_shader::Compiler;
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Block, Member, Scalar, Type};

/// The graph that errors are made in. It has every construct, and no mistake.
pub(crate) const GRAPH: &str = include_str!("base.toml");

const SHADERS: [(&str, &str); 4] = [
    ("shaders/primary.comp", include_str!("primary.comp")),
    ("shaders/pyramid.comp", include_str!("pyramid.comp")),
    ("shaders/probes.comp", include_str!("probes.comp")),
    ("shaders/include/world.glsl", include_str!("world.glsl")),
];

/// A project in memory.
#[derive(Clone)]
pub(crate) struct Project {
    pub files: BTreeMap<String, Arc<[u8]>>,
}

impl Files for Project {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        self.files.get(path).cloned().ok_or(FileError::NotFound)
    }
}

/// Modules of unchanged shaders are shared by all tests.
static UNCHANGED: LazyLock<Compiler> = LazyLock::new(|| Compiler::new(Arc::new(Project::new())));

impl Project {
    pub(crate) fn new() -> Self {
        let mut project = Self { files: BTreeMap::new() };
        project.put("graphs/base.toml", GRAPH);
        for (path, text) in SHADERS {
            project.put(path, text);
        }
        project
    }

    pub(crate) fn put(&mut self, path: &str, text: &str) {
        self.files.insert(path.to_owned(), text.as_bytes().into());
    }

    /// Replaces a piece of a file, which must be there once.
    pub(crate) fn edit(mut self, path: &str, old: &str, new: &str) -> Self {
        let text = String::from_utf8(self.files[path].to_vec()).unwrap();
        assert_eq!(text.matches(old).count(), 1, "`{old}` in {path}");
        self.put(path, &text.replace(old, new));
        self
    }

    pub(crate) fn compile(&self, path: &str) -> (Compiled, SourceMap) {
        let mut texts = SourceMap::default();
        let changed = SHADERS.iter().any(|(path, text)| self.files[*path][..] != *text.as_bytes())
            || self
                .files
                .keys()
                .any(|path| path.starts_with("shaders/") && !SHADERS.iter().any(|(shader, _)| shader == path));
        let compiled = if changed {
            compile(path, self, &Compiler::new(Arc::new(self.clone())), &sources(), &mut texts)
        } else {
            compile(path, self, &*UNCHANGED, &sources(), &mut texts)
        };
        (compiled, texts)
    }

    /// The user's view: every diagnostic of the compilation.
    pub(crate) fn rendered(&self, path: &str) -> String {
        let (compiled, texts) = self.compile(path);
        let found = match compiled {
            Ok((_, warnings)) => warnings,
            Err(found) => {
                assert!(found.iter().any(Diagnostic::is_error), "a failure without an error");
                found
            }
        };
        for diagnostic in &found {
            for label in &diagnostic.labels {
                let text = texts.get(&label.span.file).unwrap_or_else(|| panic!("no text of {}", label.span.file));
                assert!(text.get(label.span.range.clone()).is_some(), "{diagnostic:?} points nowhere");
            }
        }
        human(&found, &texts, false)
    }
}

/// The layouts that the runtime would supply.
pub(crate) fn sources() -> Vec<SourceLayout> {
    let member = |name: &str, offset, ty| Member { name: name.to_owned(), offset, ty, place: None };
    let words = Type::Array { element: Box::new(Type::Scalar(Scalar::U32)), len: None, stride: 4 };
    let layout = |name: &str, image| SourceLayout {
        name: name.to_owned(),
        access: Access::Read,
        image,
        collected: None,
        block: Block {
            name: "RxWorld".to_owned(),
            size: 16,
            members: vec![
                member("origin", 0, Type::Vector(Scalar::I32, 3)),
                member("root", 12, Type::Scalar(Scalar::U32)),
                member("words", 16, words.clone()),
            ],
        },
    };
    vec![layout("world.tree64", None), layout("world.chunks", None), layout("world.texture3d", Some(Format::R16ui))]
}
