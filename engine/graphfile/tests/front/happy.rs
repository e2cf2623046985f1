//! The result of a graph without a mistake.

use raxel_graph::checked::{
    Builtin, Clear, Dispatch, Every, Extent, Fact, Interval, ResourceKind, Usage, Value, ValueOrigin,
};
use raxel_shader::interface::{Access, Scalar};

use crate::files::Project;

#[test]
fn every_construct_arrives_in_the_checked_graph() {
    let (compiled, _) = Project::new().compile("graphs/base.toml");
    let (graph, warnings) = compiled.unwrap_or_else(|_| panic!("{}", Project::new().rendered("graphs/base.toml")));
    assert_eq!(warnings, []);
    assert_eq!(graph.name, "base");
    assert_eq!(graph.resource(graph.present).name, "color");
    assert_eq!(graph.params[1].default, Value::Vec3([1.0; 3]));
    assert_eq!(graph.params[0].range, Some([0.0, 8.0]));
    assert!(graph.params[1].color, "it is called a tint");

    let target = |name: &str| match &graph.resource(graph.find_resource(name).unwrap()).kind {
        ResourceKind::Target(target) => target.clone(),
        ResourceKind::Buffer(_) => panic!("{name}"),
    };
    assert_eq!(target("half_depth").extent, Extent::Output { scale: [0.5; 2] });
    assert_eq!(target("irradiance").extent, Extent::Fixed3([32, 32, 16]));
    assert_eq!(target("cascades").init, Some(Clear::Float([0.0, 0.0, 0.0, 1.0])));
    assert_eq!(target("pyramid").mips, 5);

    let primary = graph.pass(graph.find_pass("primary").unwrap());
    assert_eq!(
        primary.specialization,
        [(0, ValueOrigin::Value(Value::I32(2))), (1, ValueOrigin::Value(Value::U32(8)))]
    );
    assert_eq!(primary.subgroup_size, None);
    assert_eq!(primary.dispatch, Dispatch::ThreadsOf { target: graph.find_resource("hit").unwrap(), mip: 0 });
    let defines: Vec<_> = primary.shader.request.defines.iter().map(|(name, text)| (&name[..], &text[..])).collect();
    assert_eq!(defines, [("FAST", "1"), ("MAX_STEPS", "256"), ("NAME", "vec3(1)"), ("RX_LAYOUT_TREE64", "1")]);
    let push: Vec<_> =
        primary.push.iter().map(|fill| (&fill.member[..], fill.offset, [fill.ty.rows, fill.ty.columns])).collect();
    let members = [("camera_cell", 0, [3, 1]), ("camera_frac", 16, [3, 1]), ("view", 32, [4, 4])];
    assert_eq!(push[..3], members);
    assert_eq!(primary.push[2].stride, 16);
    assert_eq!(primary.push[0].from, ValueOrigin::Builtin(Builtin::CameraCell));
    assert_eq!(primary.push[5].from, ValueOrigin::ExtentOf(graph.find_resource("hit").unwrap()));

    // colors[0], colors[1], lights[0].color, lights[0].on, …, sun.direction, sun.strength; std140.
    let sky: Vec<_> = primary.uniforms[0].fills.iter().map(|fill| (&fill.member[..], fill.offset)).collect();
    let first = [("colors[0]", 0), ("colors[1]", 16), ("lights[0].color", 32), ("lights[0].on", 44)];
    assert_eq!(sky[..4], first);
    assert_eq!(sky[6..], [("sun.direction", 64), ("sun.strength", 76)]);
    assert_eq!(primary.uniforms[0].fills[3].ty.scalar, Scalar::U32);
    assert_eq!(primary.uniforms[0].fills[3].from, ValueOrigin::Value(Value::Bool(true)));
    assert_eq!(primary.uniforms[0].size, 80);

    let access = |pass: &str, resource: &str| {
        let id = graph.find_resource(resource).unwrap();
        let pass = graph.pass(graph.find_pass(pass).unwrap());
        pass.accesses.iter().filter(|access| access.resource == id).cloned().collect::<Vec<_>>()
    };
    let color = access("primary", "color");
    assert_eq!(
        color.iter().map(|a| (a.age, a.usage, a.access)).collect::<Vec<_>>(),
        [(0, Usage::StorageImage, Access::Write), (1, Usage::SampledImage, Access::Read)]
    );
    assert!(color[1].sampler.unwrap().linear);
    assert_eq!(access("primary", "world")[0].access, Access::Read);
    let pyramid = access("pyramid", "pyramid");
    assert_eq!(
        pyramid.iter().map(|a| (a.mips, a.access)).collect::<Vec<_>>(),
        [(Interval::one(0), Access::Read), (Interval::one(1), Access::Write)]
    );
    assert_eq!(access("probe_update", "cascades")[0].layers, Interval { first: 0, count: 4 });
    assert_eq!(access("probe_update", "masks")[0].layers, Interval::one(2));
    assert_eq!(access("probe_update", "args")[0].usage, Usage::IndirectArguments);
    let probes = graph.pass(graph.find_pass("probe_update").unwrap());
    assert_eq!(probes.every, Some(Every::Hz(20.0)));
    assert_eq!(probes.when[0].fact, Fact::WorldHasEmission);
    let finish = graph.pass(graph.find_pass("finish").unwrap());
    assert_eq!(finish.dispatch, Dispatch::Groups([4, 4, 1]));
    assert!(finish.when[0].negated);
    // Two passes with one request share one module.
    assert!(std::sync::Arc::ptr_eq(&probes.shader, &finish.shader));
    assert_eq!(
        graph.files,
        [
            "graphs/base.toml",
            "shaders/primary.comp",
            "shaders/include/world.glsl",
            "shaders/pyramid.comp",
            "shaders/probes.comp"
        ]
    );
}

/// A pass that dispatches a queue reads its arguments from a buffer that a pass in front makes, for the shader's own workgroup.
#[test]
fn a_queue_becomes_two_passes() {
    let project = Project::new()
        .edit("graphs/base.toml", "dispatch = { threads = \"hit\" }", "dispatch = { count = \"counters\", offset = 8 }")
        .edit("graphs/base.toml", "WIDTH = 8", "WIDTH = \"buffer.args.count\"");
    let (graph, _) = project.compile("graphs/base.toml").0.unwrap_or_else(|found| panic!("{found:#?}"));
    let names: Vec<_> = graph.passes.iter().map(|pass| (&pass.name[..], pass.made)).collect();
    assert_eq!(names[..3], [("primary.arguments", true), ("primary", false), ("pyramid", false)]);
    let (maker, primary) = (&graph.passes[0], &graph.passes[1]);
    let arguments = graph.find_resource("primary.arguments").unwrap();
    assert!(graph.resource(arguments).made && graph.resource(arguments).history == 0);
    assert_eq!(primary.dispatch, Dispatch::Indirect { buffer: arguments, offset: 0 });
    let args = graph.find_resource("args").unwrap();
    let local = [ValueOrigin::CountOf(args), ValueOrigin::Value(Value::U32(8)), ValueOrigin::Value(Value::U32(1))];
    assert_eq!(maker.specialization, [0, 1, 2].map(|id| (id, local[id as usize].clone())));
    assert_eq!(maker.push[0].from, ValueOrigin::Value(Value::U32(2)));
    let counters = graph.find_resource("counters").unwrap();
    // Both as they are in this frame, each at the binding of its name.
    let bound = |binding: Option<u32>| maker.shader.interface.bindings[binding.unwrap() as usize].name.as_str();
    let touched: Vec<_> = maker.accesses.iter().map(|of| (of.resource, of.age, of.access, bound(of.binding))).collect();
    assert_eq!(touched, [(counters, 0, Access::Read, "queue"), (arguments, 0, Access::Write, "arguments")]);
    assert!(graph.files.iter().all(|file| !file.contains("arguments")), "{:?}", graph.files);

    let sources = std::collections::BTreeMap::new();
    let input = raxel_graph::plan::PlanInput::on_paper(&graph, [64, 32], &sources);
    let plan = raxel_graph::plan(std::sync::Arc::new(graph), &input).unwrap_or_else(|found| panic!("{found:#?}"));
    let text = raxel_graph::print::text(&plan);
    assert!(text.contains("primary.arguments  1×1×1 groups, made by raxel"), "{text}");
    assert!(text.contains("primary  threads from counters + 8"), "{text}");
    let counted = plan.passes.iter().filter(|live| !plan.graph.pass(live.pass).made).count();
    assert!(text.contains(&format!("{counted} of 4 passes")), "{text}");
}

#[test]
fn a_param_says_how_it_is_shown() {
    let project = Project::new().edit(
        "graphs/base.toml",
        "[params.probes]",
        r#"[params.tone]
type = "u32"
default = 1
choices = ["Reinhard", "AgX"]
group = "Picture"
tooltip = "The curve of the film."
unit = ""
[params.tint2]
type = "vec3"
default = [1, 1, 1]
color = false
[params.probes]"#,
    );
    let (compiled, _) = project.compile("graphs/base.toml");
    let (graph, _) = compiled.unwrap_or_else(|_| panic!("{}", project.rendered("graphs/base.toml")));
    let param = |name: &str| graph.params[graph.find_param(name).unwrap().0 as usize].clone();
    let tone = param("tone");
    assert_eq!(tone.choices, ["Reinhard", "AgX"]);
    assert_eq!(tone.range, Some([0.0, 1.0]), "the choices are the range");
    assert_eq!(tone.group.as_deref(), Some("Picture"));
    assert_eq!(tone.tooltip.as_deref(), Some("The curve of the film."));
    assert_eq!((tone.unit, tone.label.as_str()), (None, "tone"));
    assert!(!param("tint2").color, "what the file says wins over the name");
}
