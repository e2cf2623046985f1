//! Every shader of the repository compiles for every layout it can be bound to, and says where everything is declared.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use raxel_diagnostics::{DiskFiles, SourceMap, render};
use raxel_shader::interface::{BindingKind, Block, Type};
use raxel_shader::{Compiler, Request, Shader, ShaderSource};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn shaders() -> Vec<String> {
    let mut paths: Vec<String> = std::fs::read_dir(root().join("shaders"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".comp"))
        .map(|name| format!("shaders/{name}"))
        .collect();
    paths.sort();
    assert!(!paths.is_empty());
    paths
}

#[test]
fn every_shader_compiles_for_every_layout() {
    let compiler = Compiler::new(Arc::new(DiskFiles::new(&root()).unwrap()));
    for path in shaders() {
        for layout in ["CHUNKS", "TREE64"] {
            let request = Request {
                path: path.clone(),
                entry: "main".to_owned(),
                defines: vec![(format!("RX_LAYOUT_{layout}"), "1".to_owned())],
            };
            let mut texts = SourceMap::default();
            let shader = match compiler.shader(&request, &mut texts) {
                Ok((shader, warnings)) => {
                    assert!(warnings.is_empty(), "{path}: {}", render::human(&warnings, &texts, false));
                    shader
                }
                Err(found) => panic!("{path} for {layout}:\n{}", render::human(&found, &texts, false)),
            };
            check_places(&shader, &texts);
        }
    }
}

fn check_places(shader: &Shader, texts: &SourceMap) {
    let path = &shader.request.path;
    for binding in &shader.interface.bindings {
        let place = binding.place.as_ref().unwrap_or_else(|| panic!("{path}: `{}` has no place", binding.name));
        assert_eq!(&texts.get(&place.file).unwrap()[place.range.clone()], binding.name);
        match &binding.kind {
            BindingKind::StorageBuffer(block) | BindingKind::UniformBuffer(block) => check_block(path, block, texts),
            BindingKind::Unsupported(what) => panic!("{path}: `{}` is {what}", binding.name),
            _ => {}
        }
    }
    if let Some(push) = &shader.interface.push {
        check_block(path, push, texts);
    }
}

fn check_block(path: &str, block: &Block, texts: &SourceMap) {
    for member in &block.members {
        let place =
            member.place.as_ref().unwrap_or_else(|| panic!("{path}: `{}.{}` has no place", block.name, member.name));
        assert_eq!(&texts.get(&place.file).unwrap()[place.range.clone()], member.name);
        let mut ty = &member.ty;
        while let Type::Array { element, .. } = ty {
            ty = element;
        }
        if let Type::Struct(block) = ty {
            check_block(path, block, texts);
        }
    }
}
