//! Every shader of the repository compiles as its graphs use it, is valid, and says where everything is declared.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use raxel_diagnostics::{DiskFiles, SourceMap, render};
use raxel_shader::interface::{BindingKind, Block, Type};
use raxel_shader::{Compiler, Request, Shader, ShaderProvider};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The values of `key = "…"` in a graph, in order.
fn values<'t>(text: &'t str, key: &str) -> Vec<&'t str> {
    text.lines()
        .filter_map(|line| line.split_once('='))
        .filter(|(word, _)| word.trim() == key)
        .filter_map(|(_, value)| value.split('"').nth(1))
        .collect()
}

/// (shader, layout) of every graph; a graph that extends another has the shaders of both.
fn used() -> BTreeSet<(String, String)> {
    let mut used = BTreeSet::new();
    let graphs = ["graphs", "graphs/rivals"].map(|folder| std::fs::read_dir(root().join(folder)).unwrap());
    for entry in graphs.into_iter().flatten() {
        let path = entry.unwrap().path();
        let read = |name: &str| std::fs::read_to_string(path.with_file_name(name)).unwrap_or_default();
        let text = read(path.file_name().unwrap().to_str().unwrap());
        let base = values(&text, "extends").first().map(|base| read(base)).unwrap_or_default();
        let mut layouts = values(&text, "source");
        if layouts.is_empty() {
            layouts = values(&base, "source");
        }
        for shader in values(&text, "shader").into_iter().chain(values(&base, "shader")) {
            // Instances are no layout, and no shader has them alone.
            used.extend(layouts.iter().filter(|layout| **layout != "world.instances").map(|layout| {
                let layout = layout.trim_start_matches("world.").to_uppercase();
                (format!("shaders/{shader}"), format!("RX_LAYOUT_{layout}"))
            }));
        }
    }
    used
}

#[test]
fn every_shader_compiles_as_its_graphs_use_it() {
    let compiler = Compiler::new(Arc::new(DiskFiles::new(&root()).unwrap()));
    let used = used();
    assert!(used.contains(&("shaders/primary.comp".to_owned(), "RX_LAYOUT_TREE64".to_owned())), "{used:?}");
    for (path, layout) in used {
        let request =
            Request { path: path.clone(), entry: "main".to_owned(), defines: vec![(layout.clone(), "1".to_owned())] };
        let mut texts = SourceMap::default();
        let shader = match compiler.shader(&request, &mut texts) {
            Ok((shader, warnings)) => {
                assert!(warnings.is_empty(), "{path}: {}", render::human(&warnings, &texts, false));
                shader
            }
            Err(found) => panic!("{path} with {layout}:\n{}", render::human(&found, &texts, false)),
        };
        assert_eq!(raxel_spirv::validate(&shader.spirv), Ok(()), "{path} with {layout}");
        // The module for software devices is as valid.
        if let Some(opaque) = raxel_spirv::Module::new(&shader.spirv, "main").unwrap().with_opaque_uniforms() {
            assert_eq!(raxel_spirv::validate(&opaque), Ok(()), "{path} with {layout}, opaque");
        }
        check_places(&shader, &texts);
    }
}

/// A module that checks its accesses is valid, and knows a name and a place for each of them.
#[test]
fn every_shader_compiles_with_checks_of_bounds() {
    let compiler = Compiler::new(Arc::new(DiskFiles::new(&root()).unwrap()));
    compiler.check_bounds(true);
    let mut checked = 0;
    for (path, layout) in used() {
        let request =
            Request { path: path.clone(), entry: "main".to_owned(), defines: vec![(layout.clone(), "1".to_owned())] };
        let shader =
            compiler.shader(&request, &mut SourceMap::default()).unwrap_or_else(|found| panic!("{path}: {found:?}")).0;
        assert_eq!(raxel_spirv::validate(&shader.spirv), Ok(()), "{path} with {layout}");
        let accesses = shader.interface.prints.iter().flat_map(|prints| &prints.accesses);
        for access in accesses {
            assert!(access.place.is_some() && !access.name.is_empty(), "{path} with {layout}: {access:?}");
            checked += 1;
        }
    }
    assert!(checked > 100, "{checked}");
}

/// A module that records its writes is valid, alone and with checks of bounds, and knows the line of each write.
#[test]
fn every_shader_compiles_with_records_of_writes() {
    let compiler = Compiler::new(Arc::new(DiskFiles::new(&root()).unwrap()));
    compiler.record_writes(true);
    let mut sites = 0;
    for (path, layout) in used() {
        let request =
            Request { path: path.clone(), entry: "main".to_owned(), defines: vec![(layout.clone(), "1".to_owned())] };
        let shader =
            compiler.shader(&request, &mut SourceMap::default()).unwrap_or_else(|found| panic!("{path}: {found:?}")).0;
        assert_eq!(raxel_spirv::validate(&shader.spirv), Ok(()), "{path} with {layout}");
        let bindings = || shader.interface.bindings.iter();
        let is_written = |binding: &&raxel_shader::interface::Binding| {
            matches!(binding.kind, BindingKind::StorageImage { .. }) && binding.access.writes()
        };
        let writes = shader.interface.prints.as_ref().and_then(|prints| prints.writes.as_ref());
        if let Some(binding) = bindings().find(is_written) {
            let writes = writes.unwrap_or_else(|| panic!("{path} with {layout}: nothing writes `{}`", binding.name));
            let unknown = writes.sites.iter().find(|site| site.line.is_none());
            assert_eq!(unknown, None, "{path} with {layout}");
            sites += writes.sites.len();
        }
    }
    assert!(sites > 20, "{sites}");
    compiler.check_bounds(true);
    let defines = vec![("RX_LAYOUT_TREE64".to_owned(), "1".to_owned())];
    let request = Request { path: "shaders/primary.comp".to_owned(), entry: "main".to_owned(), defines };
    let shader = compiler.shader(&request, &mut SourceMap::default()).unwrap().0;
    assert_eq!(raxel_spirv::validate(&shader.spirv), Ok(()));
    let prints = shader.interface.prints.as_ref().unwrap();
    assert!(prints.writes.is_some() && !prints.accesses.is_empty());
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
