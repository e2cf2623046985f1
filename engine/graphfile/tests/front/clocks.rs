//! Clocks, kept resources and partial stores in files: what they become, and every mistake about them.

use std::fmt::Write as _;

use raxel_diagnostics::Diagnostic;
use raxel_graph::checked::{ClockId, ClockValue, Every, Graph, ValueOrigin};
use raxel_shader::interface::Access;

use crate::files::Project;

/// Codes that are tried here.
pub(crate) const CODES: [&str; 5] = ["RX0136", "RX0165", "RX0166", "RX0167", "RX0168"];

const GRAPH: &str = include_str!("../fixtures/clocks/waves.toml");

const STEP: &str = include_str!("../fixtures/clocks/step.comp");

fn project(old: &str, new: &str) -> Project {
    let mut project = Project::new();
    project.put("shaders/step.comp", STEP);
    project.put("graphs/waves.toml", GRAPH);
    if old.is_empty() { project } else { project.edit("graphs/waves.toml", old, new) }
}

fn graph(project: &Project) -> (Graph, Vec<Diagnostic>) {
    project.compile("graphs/waves.toml").0.unwrap_or_else(|found| panic!("{found:#?}"))
}

#[test]
fn what_a_file_says_is_what_the_graph_has() {
    let (graph, warnings) = graph(&project("", ""));
    assert!(warnings.is_empty(), "{warnings:#?}");
    let clock = &graph.clocks[0];
    assert_eq!((clock.name.as_str(), clock.most, graph.clocks.len()), ("sim", 4, 1));
    let [height, color] = &graph.resources[..] else { panic!("{:#?}", graph.resources) };
    assert_eq!((height.clock, height.keep, height.history), (Some(ClockId(0)), false, 1));
    assert_eq!((color.clock, color.keep), (None, true));
    assert_eq!(graph.passes[0].every, Some(Every::Clock(ClockId(0))));
    assert_eq!(graph.passes[0].push[0].from, ValueOrigin::Clock(ClockId(0), ClockValue::Delta));
    // A resource that is stored in part is loaded too.
    let stored = |pass: usize| graph.passes[pass].accesses.iter().find(|a| a.access.writes()).map(|a| a.access);
    assert_eq!((stored(0), stored(1)), (Some(Access::Write), Some(Access::ReadWrite)));
}

#[test]
fn a_variant_changes_a_clock() {
    let mut project = project("", "");
    project.put("graphs/fast.toml", "extends = \"waves.toml\"\n[clocks.sim]\nhz = 240\nmost = 8\n");
    let graph = project.compile("graphs/fast.toml").0.unwrap_or_else(|found| panic!("{found:#?}")).0;
    assert!((graph.clocks[0].hz - 240.0).abs() < 1e-9 && graph.clocks[0].most == 8);
    project.put("graphs/none.toml", "extends = \"waves.toml\"\n[clocks.sim]\nremove = true\n");
    let text = project.rendered("graphs/none.toml");
    assert_eq!(text.matches("[RX0165]").count(), 4, "{text}");
    project.put("graphs/none.toml", "extends = \"waves.toml\"\n[clocks.smi]\nremove = true\n");
    assert!(project.rendered("graphs/none.toml").contains("[RX0165]: the base has no clock `smi`"));
}

#[test]
fn mistakes_are_told() {
    let show = "name = \"show\"\nshader = \"step.comp\"";
    let other = "[[passes]]\nname = \"other\"\nshader = \"step.comp\"\ndispatch = [1, 1]\npush = { value = 1.0 }\n";
    let color = "bind = { before = \"height\", outColor = \"color\" }\n";
    let between = format!("{other}{color}[[passes]]\n{show}\nevery = \"sim\"");
    let second = GRAPH.find(&format!("[[passes]]\n{show}")).expect("it is there");
    let whole = format!("[[passes]]\n{show}");
    assert_eq!(&GRAPH[second..second + whole.len()], whole);
    let writer = format!("{other}bind = {{ before = \"color\", outColor = \"height\" }}\n{whole}");
    // `far` is cleared in every frame, and written twenty times a second.
    let cleared = "clear = 0.5\n[targets.far]\nformat = \"r32f\"\nclear = 1.0\n".to_owned()
        + &other.replace("[[passes]]", "[[passes]]\nevery = { hz = 20 }")
        + "bind = { before = \"height\", outColor = \"far\" }\n"
        + &other.replace("other", "far")
        + "bind = { before = \"far\", outColor = \"color\" }\n";
    let cases: [(&str, &str, &str); 13] = [
        ("RX0136", "before = \"height\",", "before = { target = \"height\", partial = true },"),
        ("RX0165", "every = \"sim\"", "every = \"simm\""),
        ("RX0165", "clock.sim.phase", "clock.sin.phase"),
        ("RX0165", "clock = \"sim\"", "clock = \"frames\""),
        ("RX0104", "clock.sim.phase", "clock.sim.time"),
        ("RX0166", &whole, &between),
        ("RX0167", &whole, &writer),
        ("RX0168", "clock = \"sim\"\n", ""),
        ("RX0168", "clear = 0.5\n", &cleared),
        ("RX0013", "hz = 60", "most = 3"),
        ("RX0014", "hz = 60", "hz = 60\nmost = 17"),
        ("RX0014", "hz = 60", "hz = 0.0001"),
        ("RX0161", "every = \"sim\"", "every = { still = 9 }"),
    ];
    let mut said = String::new();
    for (code, old, new) in cases {
        let project = project(old, new);
        let text = project.rendered("graphs/waves.toml");
        assert!(text.contains(&format!("[{code}]")), "{code} is not in\n{text}\nafter {old:?} → {new:?}");
        writeln!(said, "──── {old:?} → {new:?}\n{text}").expect("a string takes all");
    }
    insta::assert_snapshot!("clocks", said);
}
