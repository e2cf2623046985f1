//! The compiler's interface of shaders.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, Span};
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, BindingKind, Dim, LocalSize, Scalar, ScalarKind, Type};
use raxel_shader::{Compiler, Request, Shader, ShaderProvider};

fn request(path: &str) -> Request {
    Request { path: path.to_owned(), entry: "main".to_owned(), defines: Vec::new() }
}

fn compile(files: &[(&str, &str)], request: &Request) -> (Arc<Shader>, SourceMap) {
    let compiler = Compiler::new(Arc::new(MemoryFiles::new(files.iter().copied())));
    let mut texts = SourceMap::default();
    match compiler.shader(request, &mut texts) {
        Ok((shader, warnings)) => {
            assert_eq!(warnings, [], "warnings");
            (shader, texts)
        }
        Err(found) => panic!("{}", raxel_diagnostics::render::human(&found, &texts, false)),
    }
}

fn text_at<'t>(texts: &'t SourceMap, place: Option<&Span>) -> (&'t str, usize) {
    let place = place.expect("a place");
    (&texts.get(&place.file).unwrap()[place.range.clone()], place.range.start)
}

const EVERYTHING: &str = include_str!("fixtures/interface/everything.comp");

const COMMON: &str = "#pragma once\nstruct Material { vec3 albedo; float roughness; };\n";

#[test]
fn reads_everything() {
    let files = [("shaders/a.comp", EVERYTHING), ("shaders/include/common.glsl", COMMON)];
    let (shader, texts) = compile(&files, &request("shaders/a.comp"));
    let interface = &shader.interface;
    assert_eq!(shader.files, ["shaders/a.comp", "shaders/include/common.glsl"]);
    assert_eq!(shader.spirv[1], 0x0001_0500, "SPIR-V 1.5");
    assert_eq!(interface.entry, "main");
    assert_eq!(
        interface.local_size,
        [
            LocalSize { value: 8, spec_id: None },
            LocalSize { value: 1, spec_id: Some(7) },
            LocalSize { value: 1, spec_id: None }
        ]
    );

    let push = interface.push.as_ref().unwrap();
    let members: Vec<_> = push.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
    assert_eq!(members, [("camera_cell", 0), ("camera_frac", 16), ("view", 32), ("exposure", 96)]);
    assert_eq!((push.name.as_str(), push.size), ("Push", 100));
    assert_eq!(push.members[0].ty, Type::Vector(Scalar::I32, 3));
    assert_eq!(
        push.members[2].ty,
        Type::Matrix { scalar: Scalar::F32, columns: 4, rows: 4, stride: 16, row_major: false }
    );
    assert_eq!(
        text_at(&texts, push.members[1].place.as_ref()),
        ("camera_frac", EVERYTHING.rfind("camera_frac;").unwrap())
    );

    let mut names: Vec<_> = interface.bindings.iter().map(|b| (b.name.as_str(), b.access, b.count)).collect();
    names.sort_by_key(|(name, ..)| *name);
    assert_eq!(
        names,
        [
            ("Counters", Access::ReadWrite, 1),
            ("history", Access::Read, 1),
            ("hits", Access::Read, 1),
            ("ids", Access::Read, 2),
            ("out_color", Access::Write, 1),
            ("settings", Access::Read, 1),
            ("volume", Access::ReadWrite, 1),
            ("world", Access::Read, 1),
        ]
    );
    let slots: std::collections::BTreeSet<_> = interface.bindings.iter().map(|b| (b.set, b.binding)).collect();
    assert_eq!(slots.len(), interface.bindings.len(), "every binding has a number of its own");
    let kind = |name: &str| &interface.bindings.iter().find(|b| b.name == name).unwrap().kind;
    assert_eq!(
        *kind("hits"),
        BindingKind::StorageImage {
            format: Some(Format::Rg32ui),
            dim: Dim::D2,
            arrayed: true,
            scalar: ScalarKind::Uint
        }
    );
    assert_eq!(*kind("ids"), BindingKind::SampledImage { dim: Dim::D3, arrayed: false, scalar: ScalarKind::Int });
    let BindingKind::StorageBuffer(world) = kind("world") else { panic!("{:?}", kind("world")) };
    assert_eq!(world.size, 16);
    let Type::Array { element, len: None, stride: 12 } = &world.members[1].ty else { panic!("{world:?}") };
    let Type::Struct(node) = &**element else { panic!("{element:?}") };
    assert_eq!((node.size, node.members[1].offset), (12, 4));
    let BindingKind::UniformBuffer(settings) = kind("settings") else { panic!("{:?}", kind("settings")) };
    assert_eq!(
        settings.members[0].ty,
        Type::Matrix { scalar: Scalar::F32, columns: 3, rows: 4, stride: 16, row_major: true }
    );
    assert_eq!(settings.members[0].ty.size(), 64);
    let Type::Array { element, len: Some(2), stride: 16 } = &settings.members[1].ty else { panic!("{settings:?}") };
    let Type::Struct(material) = &**element else { panic!("{element:?}") };
    let place = material.members[1].place.as_ref().unwrap();
    assert_eq!(&*place.file, "shaders/include/common.glsl");
    assert_eq!(text_at(&texts, Some(place)).0, "roughness");
    for binding in &interface.bindings {
        assert_eq!(text_at(&texts, binding.place.as_ref()).0, binding.name);
    }

    let constants: Vec<_> =
        interface.specialization.iter().map(|c| (c.id, c.name.as_str(), c.scalar, c.default)).collect();
    assert_eq!(
        constants,
        [
            (3, "STEPS", Scalar::I32, 64),
            (4, "FAST", Scalar::Bool, 1),
            (5, "BIAS", Scalar::F32, u64::from(0.5f32.to_bits())),
            (7, "", Scalar::U32, 1)
        ]
    );
    assert_eq!(text_at(&texts, interface.specialization[0].place.as_ref()).0, "STEPS");
    assert_eq!(text_at(&texts, interface.specialization[3].place.as_ref()).0, "7");
}

#[test]
fn defines_choose() {
    let text = "#version 460\nlayout(local_size_x = WIDTH) in;\nvoid main() {}\n";
    let mut asked = request("shaders/a.comp");
    asked.defines.push(("WIDTH".to_owned(), "32".to_owned()));
    let (shader, _) = compile(&[("shaders/a.comp", text)], &asked);
    assert_eq!(shader.interface.local_size[0].value, 32);
    asked.defines[0].1 = "16".to_owned();
    let (other, _) = compile(&[("shaders/a.comp", text)], &asked);
    assert_ne!(shader.key, other.key);
}

/// A shader with a push-constant block and a uniform block, and this as its body.
fn reading(body: &str) -> Arc<Shader> {
    let text = format!(
        r"#version 460
layout(local_size_x = 1) in;
struct Sun {{ vec3 direction; float strength; }};
layout(push_constant) uniform Frame {{
    mat4 view;
    uint index;
    float weights[4];
    Sun sun;
}} frame;
layout(std140) uniform Lights {{ vec4 first; vec4 many[4]; Sun suns[2]; }} lights;
buffer Sink {{ float sink[]; }};
float weigh(float weights[4]) {{ return weights[0] + weights[3]; }}
float never() {{ return frame.view[3].w; }}
float indirectly(uint at) {{ return lights.many[at].x; }}
void main() {{ {body} sink[0] += float(frame.index) + lights.first.x; }}"
    );
    compile(&[("shaders/a.comp", &text)], &request("shaders/a.comp")).0
}

/// The parts that it may load of the push constants, and of the uniform block `lights`.
fn reads(body: &str) -> (Vec<[u32; 2]>, Vec<[u32; 2]>) {
    let interface = &reading(body).interface;
    let lights = interface.bindings.iter().find(|binding| binding.name == "lights").unwrap();
    assert_eq!((interface.push_name.as_str(), interface.push.as_ref().unwrap().name.as_str()), ("frame", "Frame"));
    (interface.push_reads.iter().collect(), lights.reads.iter().collect())
}

#[test]
fn the_members_that_a_shader_reads_are_known() {
    let index = [64, 68];
    let first = [0, 16];
    // A function without a caller reads nothing.
    assert_eq!(reads(""), (vec![index], vec![first]));
    assert_eq!(reads("sink[1] = frame.view[2].z;"), (vec![[0, 68]], vec![first]), "a part of a matrix is all of it");
    assert_eq!(reads("sink[1] = frame.sun.strength;"), (vec![index, [108, 112]], vec![first]));
    assert_eq!(reads("sink[1] = frame.weights[2];"), (vec![index, [76, 80]], vec![first]), "one element");
    assert_eq!(reads("sink[1] = frame.weights[frame.index];"), (vec![[64, 84]], vec![first]), "any element");
    assert_eq!(reads("sink[1] = weigh(frame.weights);"), (vec![[64, 84]], vec![first]), "a copy for a function");
    assert_eq!(reads("sink[1] = indirectly(3);"), (vec![index], vec![[0, 80]]), "in a function that is called");
    assert_eq!(reads("sink[1] = lights.suns[1].strength;"), (vec![index], vec![first, [108, 112]]));
    assert_eq!(reads("Sun sun = lights.suns[0]; sink[1] = sun.strength;"), (vec![index], vec![first, [80, 96]]));
    let dynamic = reads("sink[1] = lights.suns[frame.index].strength;");
    assert_eq!(dynamic, (vec![index], vec![first, [80, 112]]), "a member of any element");
}
