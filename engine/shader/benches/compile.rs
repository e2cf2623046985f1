//! How long a shader edit takes from text to module and interface: `cargo bench -p raxel-shader`.

use std::path::Path;
use std::sync::Arc;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use raxel_diagnostics::{DiskFiles, Files, MemoryFiles, SourceMap};
use raxel_shader::{Compiler, Request, ShaderProvider, bytes_of};

fn request(path: &str) -> Request {
    Request {
        path: path.to_owned(),
        entry: "main".to_owned(),
        defines: vec![("RX_LAYOUT_TREE64".to_owned(), "1".to_owned())],
    }
}

fn compile(criterion: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let disk = DiskFiles::new(&root).expect("the repository is there");
    let path = "shaders/primary.comp";
    let asked = request(path);
    let compiler = Compiler::new(Arc::new(disk.clone()));
    let (shader, _) = compiler.shader(&asked, &mut SourceMap::default()).expect("primary.comp compiles");

    criterion.bench_function("primary.comp after an edit", |bencher| {
        let text = disk.read(path).expect("it was read before");
        let files = MemoryFiles::default();
        for file in &shader.files {
            files.insert(file.as_str(), disk.read(file).expect("it was read before"));
        }
        let compiler = Compiler::new(Arc::new(files.clone()));
        let mut edits = 0;
        bencher.iter_batched(
            || {
                edits += 1;
                files.insert(path, [&text[..], format!("// {edits}\n").as_bytes()].concat());
            },
            |()| compiler.shader(&asked, &mut SourceMap::default()).expect("it compiles"),
            BatchSize::PerIteration,
        );
    });
    criterion.bench_function("primary.comp unchanged", |bencher| {
        bencher.iter(|| compiler.shader(&asked, &mut SourceMap::default()).expect("it compiles"));
    });
    criterion.bench_function("primary.spv", |bencher| {
        let files = Arc::new(MemoryFiles::new([("primary.spv", bytes_of(&shader.spirv))]));
        let asked = request("primary.spv");
        bencher.iter(|| Compiler::new(files.clone()).shader(&asked, &mut SourceMap::default()).expect("it is sound"));
    });
}

criterion_group!(benches, compile);
criterion_main!(benches);
