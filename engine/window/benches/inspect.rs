//! The time that *Inspect* takes of the frame's thread, for one copy of a target of 1920 × 1080 texels in `rgba32f`, and the time that the
//! numbers of this copy take on the other thread. Needs a Vulkan driver.
//!
//! `cargo bench -p raxel-window --bench inspect`

#![allow(missing_docs, reason = "a benchmark")]

use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use raxel_execute::Region;
use raxel_picture::{Statistics, not_finite};
use raxel_runtime::{Options, Session};
use raxel_window::inspector::Inspector;

const GRAPH: &str = "name = \"wide\"\npresent = \"wide\"\n[targets.wide]\nformat = \"rgba32f\"\nsize = [1920, 1080]\n\
    [[passes]]\nname = \"write\"\nshader = \"write.comp\"\ndispatch = { threads = \"wide\" }\nbind = { to = \"wide\" }\n\
    push = { frame = \"frame.index\" }\n";

const WRITE: &str = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(rgba32f) writeonly uniform image2D to;\n\
    layout(push_constant) uniform Push { uint frame; } push;\n\
    void main() { uvec2 at = gl_GlobalInvocationID.xy; imageStore(to, ivec2(at), sin(vec4(at, at) * 0.1) + push.frame); }\n";

/// The smallest value that the panel shows.
fn smallest(inspector: &mut Inspector, session: &Session) -> Option<f32> {
    let seen = inspector.view(session, &[], Some([9, 9]), &Region::WHOLE)?;
    seen.statistics.as_ref().map(|numbers| numbers.range[0])
}

/// Runs frames until the numbers of another copy are shown. The longest time of one frame that the inspector took, and the sum.
fn copy(session: &mut Session, inspector: &mut Inspector) -> [Duration; 2] {
    let (before, mut times) = (smallest(inspector, session), Vec::new());
    loop {
        let began = Instant::now();
        inspector.ask(session);
        let asked = began.elapsed();
        let report = session.frame().expect("the frame runs");
        session.wait().expect("the device works");
        let began = Instant::now();
        inspector.take(session, &report);
        let now = smallest(inspector, session);
        times.push(asked + began.elapsed());
        if now != before {
            return [times.iter().copied().max().unwrap_or_default(), times.iter().sum()];
        }
    }
}

fn inspect(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("graphs/wide.toml", GRAPH), ("shaders/write.comp", WRITE)] {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a file is in a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    }
    let project = Some(folder.path().to_owned());
    let options = Options { project, size: [640, 360], ..Options::default() };
    let mut session = Session::open(options).unwrap_or_else(|error| panic!("{error}"));
    let mut inspector = Inspector::default();
    for (which, name) in ["inspect/longest frame of a copy", "inspect/all frames of a copy"].iter().enumerate() {
        criterion.bench_function(name, |bencher| {
            bencher
                .iter_custom(|count| (0..count).map(|_| copy(&mut session, &mut inspector)[which]).sum::<Duration>());
        });
    }
    let values: Vec<[f32; 4]> = session.read_texels("wide", 0, 0, 0).expect("texels").floats();
    criterion.bench_function("inspect/numbers, on the other thread", |bencher| {
        bencher.iter(|| (not_finite(&values, 4), Statistics::of(values.iter().map(|texel| texel[0]))));
    });
}

criterion_group!(name = benches; config = Criterion::default().sample_size(10); targets = inspect);
criterion_main!(benches);
