//! Hot reload goes on after a compile that had to be stopped. Shaders are compiled in child processes, and this program is its own child,
//! so it has a `main` of its own.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use std::process::ExitCode;
use std::time::Duration;

use project::{Project, Sessions};
use raxel_diagnostics::render;
use raxel_runtime::reload::ReloadEvent;
use raxel_shader::worker::{self, CompileLimits};

/// A text that the front end would write out for ever: each struct holds the one before twice. The macro hides it from the look at the
/// text.
fn endless() -> String {
    let double = |i| format!("DOUBLE(A{i}, A{})\n", i - 1);
    let structs: String = (1..=40).map(double).collect();
    let block = "layout(std430) buffer B { A40 b; };\nvoid main() { b.a = b.b; }\n";
    format!("#version 460\n#define DOUBLE(n, p) struct n {{ p a; p b; }};\nstruct A0 {{ int x; }};\n{structs}{block}")
}

fn main() -> ExitCode {
    // Seconds of processor time: a busy machine changes nothing.
    let limits = CompileLimits { seconds: 2, bytes: 512 << 20 };
    worker::isolate_by(std::env::current_exe().expect("a program has a path"), limits);
    if let Some(code) = worker::isolate() {
        return code;
    }
    let project = Project::filled();
    let mut session = project.open();
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 0.25);
    for red in [0.5, 0.75] {
        project.write("shaders/fill.comp", endless());
        let events = session.wait_reload(Duration::from_secs(120));
        let [ReloadEvent::Failed(failed)] = events.as_slice() else { panic!("{events:#?}") };
        let said = render::short(&failed.diagnostics, &failed.texts);
        assert!(said.contains("RX0204") && said.contains("was given up"), "{said}");
        // The last good picture stands, and the next edit is swapped in.
        let before = project::red(&mut session);
        session.frame().unwrap();
        assert_eq!(project::red(&mut session), before);
        project.write("shaders/fill.comp", project::fill(&format!("vec4({red})")));
        let events = session.wait_reload(Duration::from_secs(60));
        assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
        session.frame().unwrap();
        assert_eq!(project::red(&mut session), red);
    }
    println!("a session reloads after compiles that were stopped");
    ExitCode::SUCCESS
}
