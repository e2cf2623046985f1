//! The cache: nothing is compiled twice, and nothing stale is given out.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_shader::{Compiler, Request, Shader, ShaderSource, library};

fn request() -> Request {
    Request { path: "shaders/a.comp".to_owned(), entry: "main".to_owned(), defines: Vec::new() }
}

fn get(compiler: &Compiler) -> Arc<Shader> {
    let mut texts = SourceMap::default();
    let (shader, _) = compiler.shader(&request(), &mut texts).unwrap();
    for file in &shader.files {
        assert!(texts.get(file).is_some(), "the text of {file} comes along");
    }
    shader
}

const TEXT: &str = "#version 460\n#include \"b.glsl\"\nlayout(local_size_x = SIZE) in;\nvoid main() {}\n";

#[test]
fn an_edit_is_seen_and_taking_it_back_is_free() {
    let files = MemoryFiles::new([("shaders/a.comp", TEXT), ("shaders/include/b.glsl", "#define SIZE 8\n")]);
    let compiler = Compiler::new(Arc::new(files.clone()));
    let first = get(&compiler);
    assert!(Arc::ptr_eq(&first, &get(&compiler)));
    files.insert("shaders/include/b.glsl", "#define SIZE 16\n");
    let second = get(&compiler);
    assert_eq!(second.interface.local_size[0].value, 16);
    assert_ne!(first.key, second.key);
    files.insert("shaders/include/b.glsl", "#define SIZE 8\n");
    assert!(Arc::ptr_eq(&first, &get(&compiler)));
}

#[test]
fn what_two_versions_have_in_common_is_held_once() {
    let files = MemoryFiles::new([("shaders/a.comp", TEXT), ("shaders/include/b.glsl", "#define SIZE 8\n")]);
    let compiler = Compiler::new(Arc::new(files.clone()));
    let included = |compiler: &Compiler| {
        // The second time it comes out of the cache.
        get(compiler);
        let mut texts = SourceMap::default();
        compiler.shader(&request(), &mut texts).unwrap();
        texts.get("shaders/include/b.glsl").unwrap().clone()
    };
    let before = included(&compiler);
    files.insert("shaders/a.comp", format!("{TEXT}// another version\n"));
    let after = included(&compiler);
    assert!(Arc::ptr_eq(&before, &after));
    files.insert("shaders/include/b.glsl", "#define SIZE 16\n");
    assert!(!Arc::ptr_eq(&after, &included(&compiler)));
}

#[test]
fn a_file_that_comes_to_win_is_seen() {
    let files = MemoryFiles::new([("shaders/a.comp", TEXT), ("shaders/include/b.glsl", "#define SIZE 8\n")]);
    let compiler = Compiler::new(Arc::new(files.clone()));
    assert_eq!(get(&compiler).interface.local_size[0].value, 8);
    files.insert("shaders/b.glsl", "#define SIZE 32\n");
    assert_eq!(get(&compiler).interface.local_size[0].value, 32);
    files.remove("shaders/b.glsl");
    files.remove("shaders/include/b.glsl");
    assert!(compiler.shader(&request(), &mut SourceMap::default()).is_err());
}

#[test]
fn the_library_comes_with_the_binary_and_a_copy_on_disk_wins() {
    let Some((name, text)) = library::FILES.iter().find(|(name, _)| *name == "raxel/ray.glsl") else {
        panic!("the library has no ray.glsl: {:?}", library::FILES.iter().map(|(name, _)| name).collect::<Vec<_>>())
    };
    let files = MemoryFiles::new([(
        "shaders/a.comp",
        format!("#version 460\n#extension GL_ARB_gpu_shader_int64 : enable\n#include <{name}>\nvoid main() {{}}\n"),
    )]);
    let compiler = Compiler::new(Arc::new(files.clone()));
    let shader = get(&compiler);
    assert_eq!(shader.files[1], format!("<{name}>"));
    let copy = format!("shaders/include/{name}");
    files.insert(copy.as_str(), text);
    assert_eq!(get(&compiler).files[1], copy);
}

#[test]
fn many_threads_may_compile() {
    let files = MemoryFiles::default();
    let paths: Vec<String> = (0..24).map(|i| format!("shaders/{i}.comp")).collect();
    for (i, path) in paths.iter().enumerate() {
        files.insert(path, format!("#version 460\nlayout(local_size_x = {}) in;\nvoid main() {{}}\n", i + 1));
    }
    let compiler = Compiler::new(Arc::new(files));
    std::thread::scope(|scope| {
        for part in paths.chunks(6) {
            let compiler = &compiler;
            scope.spawn(move || {
                for path in part {
                    let request = Request { path: path.clone(), entry: "main".to_owned(), defines: Vec::new() };
                    let (shader, _) = compiler.shader(&request, &mut SourceMap::default()).unwrap();
                    let expected: u32 = path[8..].trim_end_matches(".comp").parse().unwrap();
                    assert_eq!(shader.interface.local_size[0].value, expected + 1);
                }
            });
        }
    });
}
