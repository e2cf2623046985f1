//! Modules that record their writes of a texel: each way to write is found at its line, and the module is valid.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::writes::WatchedDescriptor;
use raxel_shader::{Compiler, Request, Shader, ShaderProvider};

fn recorded(path: &str, text: &str, check_bounds: bool) -> Arc<Shader> {
    let compiler = Compiler::new(Arc::new(MemoryFiles::new([(path.to_owned(), text)])));
    compiler.record_writes(true);
    compiler.check_bounds(check_bounds);
    let request = Request { path: path.to_owned(), entry: "main".to_owned(), defines: Vec::new() };
    let mut texts = SourceMap::default();
    match compiler.shader(&request, &mut texts) {
        Ok((shader, _)) => {
            assert_eq!(raxel_spirv::validate(&shader.spirv), Ok(()), "{path}");
            shader
        }
        Err(found) => panic!("{}", render::human(&found, &texts, false)),
    }
}

fn lines(shader: &Shader) -> Vec<u32> {
    let writes = shader.interface.prints.as_ref().and_then(|prints| prints.writes.as_ref());
    let sites = writes.map(|writes| writes.sites.as_slice()).unwrap_or_default();
    sites.iter().map(|site| site.line.as_ref().expect("the source is known").1).collect()
}

const WRITES: &str = include_str!("fixtures/writes/writes.comp");

#[test]
fn every_way_to_write_is_found_at_its_line() {
    for check_bounds in [false, true] {
        let shader = recorded("shaders/a.comp", WRITES, check_bounds);
        let mut lines = lines(&shader);
        // The order of the module is that of its functions.
        lines.sort_unstable();
        assert_eq!(lines, [11, 14, 19, 20, 21, 22, 23, 24, 25, 26, 27]);
    }
}

#[test]
fn each_descriptor_has_its_word() {
    let shader = recorded("shaders/a.comp", WRITES, false);
    let writes = shader.interface.prints.as_ref().unwrap().writes.as_ref().unwrap();
    let mut places = Vec::new();
    for binding in &shader.interface.bindings {
        for element in 0..binding.count {
            let (set, binding) = (binding.set, binding.binding);
            let watched = writes.watch([70, 80], &[WatchedDescriptor { set, binding, element, layer: 4 }]);
            let (_, words) = watched.expect("it is a storage image");
            assert_eq!(words[..3], [70, 80, 0]);
            places.push(words.iter().position(|word| *word == 5).expect("it has a word"));
        }
    }
    places.sort_unstable();
    assert_eq!(places, (3..11).collect::<Vec<_>>());
}

#[test]
fn modules_that_write_no_image_stay_as_they_are() {
    let text = r"#version 460
layout(local_size_x = 8) in;
layout(r32f) readonly uniform image2D from;
layout(std430) buffer To { float to[]; };
void main() { to[gl_LocalInvocationIndex] = imageLoad(from, ivec2(0)).r; }
";
    let shader = recorded("shaders/a.comp", text, false);
    assert_eq!(shader.interface.prints, None);
}

#[test]
fn hlsl_is_recorded_too() {
    let text = r"RWTexture2D<float4> color : register(u0);
RWTexture2D<uint> counts : register(u1);
[numthreads(8, 8, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    color[id.xy] = float4(1, 2, 3, 4);
    uint old;
    InterlockedAdd(counts[id.xy], 2u, old);
}
";
    let shader = recorded("shaders/a.hlsl", text, false);
    assert_eq!(lines(&shader), [5, 7]);
}
