//! The caches, in memory and on disk: nothing is compiled twice, and nothing stale is given out.

use std::sync::Arc;

use raxel_cache::Cache;
use raxel_diagnostics::{Diagnostic, MemoryFiles, SourceMap};
use raxel_shader::{Compiler, Request, Shader, ShaderProvider, library};

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

/// A compiler as in another process: it finds only files on disk.
fn with_disk(files: &MemoryFiles, folder: &std::path::Path) -> Compiler {
    Compiler::new(Arc::new(files.clone())).with_cache(Some(Arc::new(Cache::at(folder))))
}

fn same(a: &Shader, b: &Shader) {
    assert_eq!(
        (&a.spirv, &a.interface, &a.files, a.key, a.module),
        (&b.spirv, &b.interface, &b.files, b.key, b.module)
    );
}

#[test]
fn a_later_process_compiles_nothing_and_sees_every_edit() {
    let folder = tempfile::tempdir().unwrap();
    let files = MemoryFiles::new([("shaders/a.comp", TEXT), ("shaders/include/b.glsl", "#define SIZE 8\n")]);
    let first = with_disk(&files, folder.path());
    let made = get(&first);
    let later = with_disk(&files, folder.path());
    same(&made, &get(&later));
    assert_eq!((first.compiled(), later.compiled()), (1, 0));
    // An include that changes, one that comes to win, and the text itself.
    for (path, text, size) in [
        ("shaders/include/b.glsl", "#define SIZE 16\n".to_owned(), 16),
        ("shaders/b.glsl", "#define SIZE 32\n".to_owned(), 32),
        ("shaders/a.comp", TEXT.replace("SIZE", "4"), 4),
    ] {
        files.insert(path, text);
        for expected in [1, 0] {
            let compiler = with_disk(&files, folder.path());
            assert_eq!(get(&compiler).interface.local_size[0].value, size, "{path}");
            assert_eq!(compiler.compiled(), expected, "{path}");
        }
    }
    // Defines belong to the request.
    files.insert("shaders/a.comp", TEXT.replace("#include \"b.glsl\"", ""));
    for size in ["3", "5"] {
        let request = Request { defines: vec![("SIZE".to_owned(), size.to_owned())], ..request() };
        let (shader, _) = with_disk(&files, folder.path()).shader(&request, &mut SourceMap::default()).unwrap();
        assert_eq!(shader.interface.local_size[0].value.to_string(), size);
    }
}

/// Compiles with a compiler of another process; the shader, its warnings, and how many texts were compiled.
fn anew(files: &MemoryFiles, folder: &std::path::Path) -> (Arc<Shader>, Vec<Diagnostic>, u64) {
    let compiler = with_disk(files, folder);
    let (shader, warnings) = compiler.shader(&request(), &mut SourceMap::default()).unwrap();
    (shader, warnings, compiler.compiled())
}

#[test]
fn comments_and_white_space_compile_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let files = MemoryFiles::new([("shaders/a.comp", TEXT), ("shaders/include/b.glsl", "#define SIZE 8\n")]);
    let made = anew(&files, folder.path()).0;
    files.insert("shaders/a.comp", format!("// What it does.\n\n{}", TEXT.replace("{}", "{}  // Nothing yet.")));
    files.insert("shaders/include/b.glsl", "/* In threads. */\n#define  SIZE 8 // Along x.\n");
    let (edited, _, compiled) = anew(&files, folder.path());
    assert_eq!((compiled, &edited.spirv, edited.module), (0, &made.spirv, made.module));
    // It is of other texts all the same: a place in them is another one.
    assert_ne!(edited.key, made.key);
    // In the text or in an include, everything except comments counts.
    files.insert("shaders/include/b.glsl", "/* In threads. */\n#define  SIZE 16 // Along x.\n");
    let (other, _, compiled) = anew(&files, folder.path());
    assert_eq!((compiled, other.interface.local_size[0].value), (1, 16));
    assert_ne!(other.module, made.module);
}

#[test]
fn where_numbers_of_lines_count_every_line_does() {
    let folder = tempfile::tempdir().unwrap();
    let size = "layout(local_size_x = __LINE__) in;\n";
    let files = MemoryFiles::new([
        ("shaders/a.comp", TEXT.replace("layout(local_size_x = SIZE) in;\n", "SIZE\n")),
        ("shaders/include/b.glsl", format!("#define SIZE {size}")),
    ]);
    let made = anew(&files, folder.path()).0;
    files.insert("shaders/a.comp", TEXT.replace("layout(local_size_x = SIZE) in;\n", "// One line more.\nSIZE\n"));
    let (moved, _, compiled) = anew(&files, folder.path());
    assert_eq!((compiled, made.interface.local_size[0].value + 1), (1, moved.interface.local_size[0].value));
    // A warning points at a line.
    let warned =
        |above: &str| format!("#version 460\n{above}#extension GL_EXT_nothing_known : enable\nvoid main() {{}}\n");
    files.insert("shaders/a.comp", warned(""));
    let (_, before, compiled) = anew(&files, folder.path());
    assert_eq!((before.len(), compiled), (1, 1));
    files.insert("shaders/a.comp", warned("// One line more.\n"));
    let (_, after, compiled) = anew(&files, folder.path());
    assert_eq!((after.len(), compiled), (1, 1));
    assert_ne!(before, after);
}

#[test]
fn functions_that_nothing_calls_are_no_part_of_a_module() {
    let files = MemoryFiles::new([("shaders/a.comp", TEXT), ("shaders/include/b.glsl", "#define SIZE 8\n")]);
    let compiler = Compiler::new(Arc::new(files.clone()));
    let made = get(&compiler);
    files.insert("shaders/include/b.glsl", "float twice(float x) { return 2.0 * x; }\n#define SIZE 8\n");
    let edited = get(&compiler);
    assert_eq!((&edited.spirv, edited.module), (&made.spirv, made.module));
    assert_ne!(edited.key, made.key);
}

#[test]
fn warnings_and_texts_come_from_disk_too_and_errors_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{}// a \\\nb\n", TEXT.replace("#version 460", "#version 460\n#pragma nothing_known"));
    let files = MemoryFiles::new([("shaders/a.comp", text), ("shaders/include/b.glsl", "#define SIZE 8\n".to_owned())]);
    let run = || {
        let compiler = with_disk(&files, folder.path());
        let mut texts = SourceMap::default();
        let found = compiler.shader(&request(), &mut texts).map(|(_, warnings)| warnings);
        (found, texts.get("shaders/include/b.glsl").cloned(), compiler.compiled())
    };
    let (first, again) = (run(), run());
    assert!(first.0.is_ok() && first.1.is_some());
    assert_eq!((first.0, first.1, 0), again);
    files.insert("shaders/include/b.glsl", "#define SIZE none\n");
    let (first, again) = (run(), run());
    assert!(first.0.is_err());
    assert_eq!((first.0, first.2), (again.0, again.2));
}

#[test]
fn what_is_damaged_on_disk_is_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let files = MemoryFiles::new([("shaders/a.comp", TEXT), ("shaders/include/b.glsl", "#define SIZE 8\n")]);
    let made = get(&with_disk(&files, folder.path()));
    let entry = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap();
    let whole = std::fs::read(entry.path()).unwrap();
    let name = entry.file_name().into_string().unwrap();
    let name = name.strip_suffix(".kept").unwrap();
    let damage: [&dyn Fn(); 3] = [
        &|| std::fs::write(entry.path(), &whole[..whole.len() / 2]).unwrap(),
        &|| std::fs::write(entry.path(), b"").unwrap(),
        // Whole, and no module.
        &|| Cache::at(folder.path()).write(name, b"something else"),
    ];
    for damage in damage {
        damage();
        for expected in [1, 0] {
            let compiler = with_disk(&files, folder.path());
            same(&made, &get(&compiler));
            assert_eq!(compiler.compiled(), expected);
        }
    }
}
