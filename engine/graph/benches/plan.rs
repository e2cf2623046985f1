//! `cargo bench -p raxel-graph --bench plan`: how long a graph takes from its text to its plan, shader compilation left out.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a bench")]
#![allow(missing_docs, reason = "a benchmark")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use raxel_diagnostics::{Diagnostic, FileError, Files, SourceMap};
use raxel_graph::checked::Graph;
use raxel_graph::plan::{Plan, PlanInput};
use raxel_graphfile::compile;
use raxel_shader::format::Format;
use raxel_shader::interface::{
    Access, Binding, BindingKind, Block, ByteRanges, Dim, Interface, LocalSize, Member, Scalar, ScalarKind, Type,
};
use raxel_shader::{Request, Shader, ShaderProvider};

/// A chain of passes over full, half and quarter-size targets: each samples the two before it and stores one; every fourth reads
/// history, every fifth appends to a buffer.
fn text(passes: usize) -> String {
    let mut text =
        String::from("name = \"chain\"\npresent = \"t0\"\n[params.exposure]\ntype = \"f32\"\ndefault = 1.0\n");
    text += "[buffers.list]\nsize = 65536\nclear = 0\n";
    for target in 0..passes {
        let size = ["1.0", "0.5", "0.25"][target % 3];
        let _ = writeln!(text, "[targets.t{target}]\nformat = \"rgba16f\"\nsize = {size}");
        if target.is_multiple_of(4) {
            text += "history = 1\n";
        }
    }
    for pass in 0..passes {
        let target = passes - 1 - pass;
        let _ = writeln!(text, "[[passes]]\nname = \"p{pass}\"\nshader = \"{}.comp\"", shader_name(pass, passes));
        let _ = writeln!(text, "dispatch = {{ threads = \"t{target}\" }}\n[passes.bind]\nresult = \"t{target}\"");
        if pass > 0 {
            let _ = writeln!(text, "before = \"t{}\"", target + 1);
        }
        if pass > 1 {
            let _ = writeln!(text, "earlier = \"t{}\"", target + 2);
        }
        if target.is_multiple_of(4) {
            let _ = writeln!(text, "history = \"t{target}@1\"");
        }
        if pass.is_multiple_of(5) {
            text += "list = \"list\"\n";
        }
        text += "[passes.push]\nexposure = { type = \"f32\", from = \"param.exposure\" }\n";
    }
    text
}

/// The name has the shader's bindings.
fn shader_name(pass: usize, passes: usize) -> String {
    let mut name = String::from("s");
    for (there, letter) in
        [(pass > 0, 'b'), (pass > 1, 'e'), ((passes - 1 - pass).is_multiple_of(4), 'h'), (pass.is_multiple_of(5), 'l')]
    {
        if there {
            name.push(letter);
        }
    }
    name
}

/// Shaders that are compiled already.
struct Ready;

impl ShaderProvider for Ready {
    fn shader(&self, request: &Request, _: &mut SourceMap) -> Result<(Arc<Shader>, Vec<Diagnostic>), Vec<Diagnostic>> {
        let sampled = |name: &str, binding| Binding {
            name: name.into(),
            set: 0,
            binding,
            count: 1,
            kind: BindingKind::SampledImage { dim: Dim::D2, arrayed: false, scalar: ScalarKind::Float },
            access: Access::Read,
            reads: ByteRanges::default(),
            place: None,
        };
        let result = BindingKind::StorageImage {
            format: Some(Format::Rgba16f),
            dim: Dim::D2,
            arrayed: false,
            scalar: ScalarKind::Float,
        };
        let mut bindings =
            vec![Binding { name: "result".into(), kind: result, access: Access::Write, ..sampled("result", 0) }];
        for (letter, name) in [('b', "before"), ('e', "earlier"), ('h', "history")] {
            if name_has(&request.path, letter) {
                bindings.push(sampled(name, bindings.len() as u32));
            }
        }
        if name_has(&request.path, 'l') {
            let words = Type::Array { element: Box::new(Type::Scalar(Scalar::U32)), len: None, stride: 4 };
            let block = Block {
                name: "List".into(),
                size: 0,
                members: vec![Member { name: "words".into(), offset: 0, ty: words, place: None }],
            };
            let kind = BindingKind::StorageBuffer(block);
            let binding = bindings.len() as u32;
            bindings.push(Binding { kind, access: Access::ReadWrite, ..sampled("list", binding) });
        }
        let exposure = Member { name: "exposure".into(), offset: 0, ty: Type::Scalar(Scalar::F32), place: None };
        let local = LocalSize { value: 8, spec_id: None };
        let interface = Interface {
            entry: "main".into(),
            local_size: [local, local, LocalSize::default()],
            push: Some(Block { name: "Push".into(), size: 4, members: vec![exposure] }),
            push_reads: ByteRanges::new(vec![[0, 4]]),
            bindings,
            ..Interface::default()
        };
        let files = vec![request.path.clone()];
        let shader =
            Shader { request: request.clone(), spirv: Arc::from([]), interface, files, key: [0; 32], module: [0; 32] };
        Ok((Arc::new(shader), Vec::new()))
    }
}

fn name_has(path: &str, letter: char) -> bool {
    path.trim_start_matches("shaders/s").trim_end_matches(".comp").contains(letter)
}

/// One file.
struct One(String);

impl Files for One {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        if path == "graphs/chain.toml" { Ok(Arc::from(self.0.as_bytes())) } else { Err(FileError::NotFound) }
    }
}

fn checked(files: &One) -> Graph {
    match compile("graphs/chain.toml", files, &Ready, &Vec::new(), &mut SourceMap::default()) {
        Ok((graph, _)) => graph,
        Err(found) => panic!("the benchmark's own graph is wrong: {found:#?}"),
    }
}

fn planned(graph: &Arc<Graph>) -> Plan {
    let sources = BTreeMap::new();
    let input = PlanInput::on_paper(graph, [1280, 720], &sources);
    raxel_graph::plan(graph.clone(), &input).expect("the benchmark's own graph can be planned")
}

fn plans(criterion: &mut Criterion) {
    for passes in [30, 100, 1000] {
        let files = One(text(passes));
        let graph = Arc::new(checked(&files));
        assert_eq!(planned(&graph).passes.len(), passes);
        let mut group = criterion.benchmark_group(format!("{passes} passes"));
        group.sample_size(if passes > 100 { 10 } else { 50 });
        group.bench_function("plan", |b| b.iter(|| planned(&graph)));
        group.bench_function("parse, check and plan", |b| b.iter(|| planned(&Arc::new(checked(&files)))));
        group.finish();
    }
}

criterion_group!(benches, plans);
criterion_main!(benches);
