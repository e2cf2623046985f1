//! Several worlds in one shader: `<raxel/world/BINDING.glsl>` beside `<raxel/world.glsl>`.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::interface::BindingKind;
use raxel_shader::{Compiler, Request, Shader, ShaderProvider};

const LAYOUTS: [&str; 9] =
    ["TREE64", "CHUNKS", "BVH", "CHUNK_TABLE", "BRICKMAP", "OCTREE", "SVO", "SVDAG", "TEXTURE3D"];

const SHADER: &str = include_str!("fixtures/worlds/look_up.comp");

fn compile(files: &[(&str, &str)], defines: &[String]) -> Result<(Arc<Shader>, String), String> {
    let compiler = Compiler::new(Arc::new(MemoryFiles::new(files.iter().copied())));
    let defines = defines.iter().map(|name| (name.clone(), "1".to_owned())).collect();
    let request = Request { path: "shaders/a.comp".to_owned(), entry: "main".to_owned(), defines };
    let mut texts = SourceMap::default();
    match compiler.shader(&request, &mut texts) {
        Ok((shader, warnings)) => Ok((shader, render::human(&warnings, &texts, false))),
        Err(found) => Err(render::human(&found, &texts, false)),
    }
}

fn defines(world: &str, pine: &str, oak: &str) -> Vec<String> {
    vec![format!("RX_LAYOUT_{world}"), format!("RX_LAYOUT_{pine}_pine"), format!("RX_LAYOUT_{oak}_oak")]
}

/// A name that the template leaves out is declared twice here, in any layout.
#[test]
fn a_layout_can_stand_three_times_in_a_shader() {
    for layout in LAYOUTS {
        let (shader, warnings) = compile(&[("shaders/a.comp", SHADER)], &defines(layout, layout, layout))
            .unwrap_or_else(|said| panic!("{layout}:\n{said}"));
        assert_eq!(warnings, "", "{layout}");
        let mut names: Vec<_> = shader.interface.bindings.iter().map(|binding| binding.name.as_str()).collect();
        names.sort_unstable();
        let expected: &[&str] = match layout {
            "TEXTURE3D" => &["Out", "oak", "oak_voxels", "pine", "pine_voxels", "world", "world_voxels"],
            _ => &["Out", "oak", "pine", "world"],
        };
        assert_eq!(names, expected);
        for binding in &shader.interface.bindings {
            assert!(binding.place.is_some(), "{layout}: `{}` has no place", binding.name);
        }
    }
}

#[test]
fn each_binding_has_the_layout_of_its_own_define() {
    let (shader, warnings) = compile(&[("shaders/a.comp", SHADER)], &defines("OCTREE", "TREE64", "BVH")).unwrap();
    assert_eq!(warnings, "");
    for (name, member) in [("world", "log2_slots"), ("pine", "leaf_count"), ("oak", "block_count")] {
        let binding = shader.interface.bindings.iter().find(|binding| binding.name == name).unwrap();
        let BindingKind::StorageBuffer(block) = &binding.kind else { panic!("`{name}` is not a buffer") };
        assert!(block.members.iter().any(|m| m.name == member), "`{name}` has no `{member}`");
    }
}

#[test]
fn marchers_go_over_the_world_whatever_else_is_bound() {
    for (layout, marcher) in [("BRICKMAP", "RAYMASK"), ("BVH", "STACK"), ("OCTREE", "STACKLESS"), ("TREE64", "DDA")] {
        for other in ["BRICKMAP", "TREE64", "BVH"] {
            let mut defines = defines(layout, other, "OCTREE");
            defines.push(format!("RX_MARCH_{marcher}"));
            let result = compile(&[("shaders/a.comp", SHADER)], &defines);
            assert!(result.is_ok(), "{layout} {marcher} beside {other}:\n{}", result.unwrap_err());
        }
    }
}

#[test]
fn a_binding_without_a_layout_is_named() {
    let said = compile(&[("shaders/a.comp", SHADER)], &defines("TREE64", "TREE64", "NONE")).unwrap_err();
    assert!(said.contains("bind `oak` to a buffer"), "{said}");
    assert!(said.contains("<raxel/world/oak.glsl>") && said.contains("included from shaders/a.comp:4"), "{said}");
}

/// The project's file wins, as for every file of the library; a mistake in it is shown with every world that has it.
#[test]
fn a_mistake_in_a_layout_says_by_which_worlds_it_comes_in() {
    let layout = raxel_shader::library::text("raxel/rivals/internal/layouts/chunks.glsl")
        .unwrap()
        .replace("bvec4 a =", "bvec5 a =");
    let files =
        [("shaders/a.comp", SHADER), ("shaders/include/raxel/rivals/internal/layouts/chunks.glsl", layout.as_str())];
    let line = 1 + layout.lines().position(|line| line.contains("bvec5")).unwrap();
    let said = compile(&files, &defines("TREE64", "CHUNKS", "CHUNKS")).unwrap_err();
    for part in [
        format!("shaders/include/raxel/rivals/internal/layouts/chunks.glsl:{line}:9"),
        "included from <raxel/world/pine.glsl>:".to_owned(),
        "included from shaders/a.comp:3".to_owned(),
    ] {
        assert!(said.contains(&part), "no `{part}` in\n{said}");
    }
    let said = compile(&files, &defines("CHUNKS", "CHUNKS", "BVH")).unwrap_err();
    assert!(said.contains("included from <raxel/world.glsl>:"), "{said}");
    assert!(!said.contains("included from shaders/a.comp:4"), "{said}");

    // A template of the project's own, too.
    let template = raxel_shader::library::text("raxel/world/NAME.glsl").unwrap().replace("#define world NAME\n", "");
    let files = [("shaders/a.comp", SHADER), ("shaders/include/raxel/world/NAME.glsl", template.as_str())];
    assert!(compile(&files, &defines("TREE64", "CHUNKS", "BVH")).is_err());
}

const SETTER: &str = include_str!("fixtures/worlds/setter.comp");

#[test]
fn a_voxel_is_set_in_the_layouts_that_have_room_for_it() {
    for layout in ["CHUNKS", "CHUNK_TABLE", "OCTREE", "TEXTURE3D"] {
        let (shader, warnings) = compile(&[("shaders/a.comp", SETTER)], &defines(layout, layout, layout))
            .unwrap_or_else(|said| panic!("{layout}:\n{said}"));
        assert_eq!(warnings, "", "{layout}");
        for binding in &shader.interface.bindings {
            let written = match &binding.kind {
                BindingKind::StorageBuffer(_) | BindingKind::StorageImage { .. } => binding.access.writes(),
                _ => false,
            };
            let image = layout == "TEXTURE3D";
            let expected = match binding.name.as_str() {
                "world" | "pine" => !image,
                "world_texels" | "pine_texels" => image,
                _ => false,
            };
            assert_eq!(written, expected, "{layout}: {}", binding.name);
        }
    }
    for layout in ["TREE64", "BVH", "BRICKMAP", "SVO", "SVDAG"] {
        let said = compile(&[("shaders/a.comp", SETTER)], &defines("OCTREE", layout, "CHUNKS")).unwrap_err();
        let expected = format!("the layout `{}` has no rx_set", layout.to_lowercase());
        assert!(said.contains(&expected) && said.contains("included from shaders/a.comp:5"), "{said}");
        // A binding that is only read may have it.
        assert!(compile(&[("shaders/a.comp", SETTER)], &defines("OCTREE", "CHUNKS", layout)).is_ok(), "{layout}");
    }
}
