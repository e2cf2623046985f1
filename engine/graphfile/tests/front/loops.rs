//! `[loops.*]`: passes that are repeated, and every mistake.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use raxel_graph::checked::{ClockId, Dispatch, Graph, RoundIndex, Rounds, ValueOrigin};
use raxel_graph::plan::PlanInput;

use crate::files::Project;

const PATH: &str = "graphs/loops.toml";

const GRAPH: &str = include_str!("../fixtures/loops/loops.toml");

const SHADERS: [(&str, &str); 3] = [
    (
        "shaders/start.comp",
        r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(rgba16f) uniform writeonly image2D outBase;
void main() {
    imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), vec4(1.0));
    imageStore(outBase, ivec2(gl_GlobalInvocationID.xy), vec4(1.0));
}
",
    ),
    (
        "shaders/down.comp",
        r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform readonly image2D fine;
layout(rgba16f) uniform writeonly image2D coarse;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(coarse, pixel, imageLoad(fine, 2 * pixel));
}
",
    ),
    ("shaders/mix.comp", include_str!("../fixtures/loops/mix.comp")),
];

fn project() -> Project {
    let mut project = Project::new();
    project.put(PATH, GRAPH);
    for (path, text) in SHADERS {
        project.put(path, text);
    }
    project
}

fn compiled(project: &Project) -> Graph {
    match project.compile(PATH).0 {
        Ok((graph, warnings)) => {
            assert_eq!(warnings, []);
            graph
        }
        Err(found) => panic!("{found:#?}"),
    }
}

#[test]
fn loops_arrive_in_the_checked_graph() {
    let graph = compiled(&project());
    let id = |name: &str| graph.find_resource(name).unwrap();
    assert_eq!(graph.loops[0].rounds, Rounds::Mips(id("pyramid")));
    assert_eq!(
        (graph.loops[1].rounds, graph.loops[1].down),
        (Rounds::Param(graph.find_param("rounds").unwrap()), true)
    );
    assert_eq!(graph.loops[1].swap, [[id("color"), id("other")]]);
    let in_loop = |name: &str| graph.pass(graph.find_pass(name).unwrap()).in_loop.clone();
    assert_eq!(in_loop("start"), None);
    let down = in_loop("down").unwrap();
    assert_eq!(down.dispatch_mip, Some(RoundIndex::Next));
    assert_eq!(down.mips.len(), 2);
    let mix = graph.pass(graph.find_pass("mix").unwrap());
    assert_eq!(mix.push[0].from, ValueOrigin::Round(RoundIndex::Index), "a signed member takes it too");
    assert_eq!(mix.specialization, [(0, ValueOrigin::Round(RoundIndex::Next))]);
    assert!(matches!(mix.dispatch, Dispatch::ThreadsOf { mip: 0, .. }));
}

#[test]
fn loops_are_laid_over_those_of_a_base() {
    let mut project = project();
    project.put("graphs/over.toml", "extends = \"loops.toml\"\n[loops.relax]\ncount = 4\n");
    let (graph, _) = project.compile("graphs/over.toml").0.unwrap_or_else(|found| panic!("{found:#?}"));
    assert_eq!((graph.loops[1].rounds, graph.loops[1].down), (Rounds::Fixed(4), true));
    // The param is not used any more.
    assert!(project.rendered("graphs/over.toml").contains("param `rounds` is not used"));
    project.put("graphs/over.toml", "extends = \"loops.toml\"\nloops.relax.remove = true\n");
    assert!(project.rendered("graphs/over.toml").contains("there is no loop `relax`"));
    project.put("graphs/over.toml", "extends = \"loops.toml\"\nloops.relux.remove = true\n");
    assert!(project.rendered("graphs/over.toml").contains("the base has no loop `relux`"));
}

#[test]
fn mistakes() {
    let cases: &[(&str, &str, &str)] = &[
        ("RX0190", "loop = \"relax\"", "loop = \"relex\""),
        ("RX0192", "[[\"color\", \"other\"]]", "[[\"color\", \"pyramid\"]]"),
        ("RX0192", "[[\"color\", \"other\"]]", "[[\"color\", \"color\"]]"),
        ("RX0192", "[[\"color\", \"other\"]]", "[[\"color\", \"other\"], [\"other\", \"color\"]]"),
        ("RX0100", "[[\"color\", \"other\"]]", "[[\"color\", \"othr\"]]"),
        ("RX0014", "[[\"color\", \"other\"]]", "[[\"color\"]]"),
        ("RX0193", "range = [0, 8]\n", ""),
        ("RX0193", "range = [0, 8]", "range = [0, 80]"),
        ("RX0193", "type = \"i32\"\ndefault = 3", "type = \"f32\"\ndefault = 3.0"),
        ("RX0101", "\"param.rounds\"", "\"param.round\""),
        ("RX0014", "\"param.rounds\"", "\"rounds\""),
        ("RX0014", "\"param.rounds\"", "65"),
        ("RX0122", "{ mips = \"pyramid\" }", "{ mips = \"param\" }\n[buffers.param]\nsize = 4"),
        ("RX0194", "loop = \"down\"\n", ""),
        ("RX0194", "loop = \"relax\"\n", ""),
        ("RX0128", "mips = \"full\"", "mips = 1"),
        ("RX0128", "count = { mips = \"pyramid\" }\n", "count = 4\n"),
        (
            "RX0129",
            "coarse = { target = \"pyramid\", mip = \"loop.next\" }",
            "coarse = { target = \"pyramid\", mip = 3 }",
        ),
        ("RX0012", "order = \"down\"", "order = 1"),
        ("RX0014", "order = \"down\"", "order = \"back\""),
        ("RX0014", "mip = \"loop.index\" }, coarse", "mip = \"loop.last\" }, coarse"),
        ("RX0011", "order = \"down\"", "direction = \"down\""),
        ("RX0012", "count = { mips = \"pyramid\" }\n", "count = 1.5\n"),
        ("RX0161", "[loops.relax]", "[loops.spare]\ncount = 1\n[loops.relax]"),
        ("RX0161", "count = \"param.rounds\"", "count = 2"),
        ("RX0154", "[loops.relax]", "[loops.spare]\nremove = true\n[loops.relax]"),
    ];
    let mut said = String::new();
    for (code, old, new) in cases {
        let mut project = project();
        // A pyramid of known mips; the mistake is beyond them.
        if new.starts_with("count = 4") {
            project.put(PATH, &GRAPH.replace("mips = \"full\"", "mips = 4"));
        }
        if new.starts_with("mips = 1") {
            project.put(PATH, &GRAPH.replace("count = { mips = \"pyramid\" }\n", "count = 1\n"));
        }
        let text = project.edit(PATH, old, new).rendered(PATH);
        assert!(text.contains(&format!("[{code}]")), "{code} is not in\n{text}\nafter {old:?} → {new:?}");
        writeln!(said, "──── {old:?} → {new:?}\n{text}").unwrap();
    }
    insta::assert_snapshot!(said);
}

#[test]
fn a_loop_without_a_round_is_told() {
    let told = |mips: &str| {
        let mut project = project();
        project.put(PATH, &GRAPH.replace("mips = \"full\"\n", mips));
        let warns = project.compile(PATH).0.is_ok();
        (warns, project.rendered(PATH).matches("[RX0491]: loop `down` has no round").count())
    };
    assert_eq!(told("mips = \"full\"\n"), (true, 0));
    assert_eq!(told("mips = 2\n"), (true, 0));
    // A target that says nothing of mips has one.
    assert_eq!(told("mips = 1\n"), (true, 1));
    assert_eq!(told(""), (true, 1));
    // The full chain of a single texel is that texel.
    assert_eq!(told("mips = \"full\"\nsize = [1, 1]\n"), (true, 1));
}

#[test]
fn a_loop_with_passes_of_a_clock_has_no_others() {
    let clock = "\n[clocks.sim]\nhz = 60\n[params.rounds]";
    let mix = GRAPH.find("\n[[passes]]\nname = \"mix\"").unwrap();
    let second = GRAPH[mix..].replace("name = \"mix\"", "name = \"again\"");
    let graph = format!("{GRAPH}{second}").replacen("\n[params.rounds]", clock, 1);
    let of_clock = |name: &str, graph: &str| {
        graph.replace(&format!("name = \"{name}\"\n"), &format!("name = \"{name}\"\nevery = \"sim\"\n"))
    };
    let told = |graph: &str| {
        let mut project = project();
        project.put(PATH, graph);
        project.rendered(PATH)
    };
    let both = of_clock("again", &of_clock("mix", &graph));
    let mut right = project();
    right.put(PATH, &both);
    assert_eq!(compiled(&right).passes.len(), 4);
    // The second round of `mix` would stand behind the first of `again`.
    let text = told(&of_clock("mix", &graph));
    let one =
        "[RX0166]: loop `relax` repeats pass `mix`, which runs by clock `sim`, together with `again`, which does not";
    assert!(text.contains(one), "{text}");
    assert!(told(&of_clock("again", &graph)).contains("[RX0166]: loop `relax` repeats pass `again`"));
    // A resource that turns with a clock changes places with it.
    let turning = |graph: &str| {
        let turn = |graph: String, name: &str| {
            let target = format!("[targets.{name}]\n");
            graph.replace(&target, &format!("{target}clock = \"sim\"\n"))
        };
        turn(turn(graph.to_owned(), "color"), "other")
    };
    let all = of_clock("start", &of_clock("down", &both));
    let mut right = project();
    right.put(PATH, &turning(&all));
    assert_eq!(compiled(&right).resources[1].clock, Some(ClockId(0)));
    let text = told(&turning(&of_clock("start", &graph)));
    assert!(text.contains("[RX0167]: loop `relax` lets `color` change places, which turns with clock `sim`"), "{text}");
    let text = told(&both.replace("[targets.other]\n", "[targets.other]\nclock = \"sim\"\n"));
    assert!(text.contains("[RX0192]: `color` and `other` cannot change places: they differ in `clock`"), "{text}");
}

#[test]
fn the_passes_of_a_loop_stand_together() {
    let more = "\n[[passes]]\nname = \"again\"\nloop = \"down\"\nshader = \"down.comp\"\ndispatch = { threads = \"pyramid\", mip = \"loop.next\" }\nbind = { fine = { target = \"pyramid\", mip = \"loop.index\" }, coarse = { target = \"pyramid\", mip = \"loop.next\" } }\n";
    let mut apart = project();
    apart.put(PATH, &format!("{GRAPH}{more}"));
    let text = apart.rendered(PATH);
    assert!(text.contains("[RX0191]: the passes of loop `down` do not stand together"), "{text}");
    assert!(text.contains("this one stands between them"), "{text}");
    // Side by side they are one loop of two passes.
    let mix = GRAPH.find("\n[[passes]]\nname = \"mix\"").unwrap();
    apart.put(PATH, &format!("{}{more}{}", &GRAPH[..mix], &GRAPH[mix..]));
    assert_eq!(compiled(&apart).passes.len(), 4);
}

#[test]
fn a_mistake_of_every_round_is_told_once() {
    let mut project = project();
    project.put(
        PATH,
        &GRAPH.replace("default = 3", "default = 2").replace(
            "fine = { target = \"pyramid\", mip = \"loop.index\" }",
            "fine = { target = \"color\", mip = \"loop.index\" }",
        ),
    );
    let graph = Arc::new(compiled(&project));
    let sources = BTreeMap::new();
    let input = PlanInput::on_paper(&graph, [320, 180], &sources);
    let found = raxel_graph::plan(graph, &input).expect_err("`color` has one mip");
    let messages: Vec<_> = found.iter().map(|diagnostic| diagnostic.message.as_str()).collect();
    assert_eq!(messages, ["pass `down[1]` binds mip 1 of `color`, which has 1"]);
}
