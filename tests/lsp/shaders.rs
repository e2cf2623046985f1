//! Names of shaders and of the library are offered, explained and found.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::json;

use crate::common::{Project, command};
use crate::{Editor, NOTE, address, notes, place_of};

#[test]
fn shaders_have_the_names_of_glsl_and_an_outline() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let shader = project.path("shaders/inspect.comp");
    let text = std::fs::read_to_string(&shader).unwrap();
    editor.open(&shader, &text);
    let body = |inside: &str| text.replace("    RxHit hit;\n", &format!("    {inside}\n    RxHit hit;\n"));
    let offered = editor.offered(&shader, &body("smo|"));
    for name in ["smoothstep", "imageLoad", "gl_GlobalInvocationID", "rx_trace", "outDepth", "push"] {
        assert!(offered.iter().any(|label| label == name), "{name} is not among {offered:?}");
    }
    let mut hover = |inside: &str| {
        let place = editor.place(&shader, &body(inside));
        let said = editor.ask("textDocument/hover", place);
        said["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    assert!(hover("float x = smooth|step(0.0, 1.0, 0.5);").contains("0 below low, 1 above high"));
    let said = hover("imageStore(outDe|pth, pixel, vec4(0.0));");
    for part in
        ["uniform writeonly image2D outDepth;", "distance along the ray", "pass `inspect` of `graphs/inspect.toml`"]
    {
        assert!(said.contains(part), "{said}");
    }
    let place = editor.place(&shader, &body("imageStore(outDe|pth, pixel, vec4(0.0));"));
    let line = text.lines().position(|line| line.contains("image2D outDepth;")).unwrap() as u64;
    assert_eq!(place_of(&editor.ask("textDocument/definition", place)), (address(&shader).as_str(), line));
    // A declaration of an include is found there.
    let place = editor.place(&shader, &body("RxRay other = rx_camera|_ray();"));
    let found = editor.ask("textDocument/definition", place);
    assert_eq!(place_of(&found).0, address(&project.path("shaders/include/raxel/camera.glsl")), "{found}");

    let outline = |editor: &mut Editor, path: &Path| -> Vec<String> {
        let document = json!({ "textDocument": { "uri": address(path) } });
        let symbols = editor.ask("textDocument/documentSymbol", document);
        symbols.as_array().unwrap().iter().map(|symbol| symbol["name"].as_str().unwrap().to_owned()).collect()
    };
    editor.change(&shader, &text);
    assert_eq!(outline(&mut editor, &shader), ["outHit", "outDepth", "outNormal", "outSteps", "push", "main"]);
    let graph = project.path("graphs/inspect.toml");
    editor.open(&graph, &std::fs::read_to_string(&graph).unwrap());
    let expected = ["sky_depth", "hit", "depth", "normal", "steps", "world", "instances", "inspect"];
    assert_eq!(outline(&mut editor, &graph), expected);
}

#[test]
fn locals_and_parameters_are_known_in_their_scope() {
    let (_project, mut editor, _, shader) = notes();
    let offered = editor.offered(&shader, &NOTE.replace("return twice", "return tw|"));
    assert!(["twice", "near", "by", "far", "outColor"].iter().all(|name| offered.iter().any(|label| label == name)));
    let offered = editor.offered(&shader, &NOTE.replace("vec4(near)", "vec4(|"));
    assert!(offered.iter().any(|label| label == "near") && offered.iter().all(|label| label != "twice"));
    let place = editor.place(&shader, &NOTE.replace("near * by", "ne|ar * by"));
    let said = editor.ask("textDocument/hover", place.clone());
    assert!(said["contents"]["value"].as_str().unwrap().contains("float near\n```\nA parameter."), "{said}");
    let found = editor.ask("textDocument/definition", place);
    assert_eq!(found["range"]["start"], json!({ "line": 5, "character": 16 }));
}

/// A structure and blocks of a shader of their own, besides those of the library.
const MEMBERS: &str = include_str!("../fixtures/lsp/members.comp");

#[test]
fn members_are_known_behind_a_dot() {
    let project = Project::empty();
    project.write("shaders/members.comp", MEMBERS);
    let mut editor = Editor::start(&project);
    let shader = project.path("shaders/members.comp");
    editor.open(&shader, MEMBERS);
    let body = |inside: &str| MEMBERS.replace("    //\n", &format!("    {inside}\n"));
    let ball = ["centre", "radius", "weight"];
    let plane = ["x", "y", "xy", "r", "g", "rg"];
    for expression in
        ["many[1].", "push.ball.", "balls.all[push.ball.weight[0]].", "grown(many[0]).", "Ball(vec3(0.0), 1.0)."]
    {
        assert_eq!(editor.offered(&shader, &body(&format!("{expression}|"))), ball, "{expression}");
        assert_eq!(editor.offered(&shader, &body(&format!("float a = {expression}ra|;"))), ball, "{expression}");
    }
    for expression in [
        "AT[0].",
        "many[0].centre.xy.",
        "vec2(1.0).",
        "mix(AT[0], vec2(1.0), push.exposure).",
        "(2.0 * vec2[2](AT[0], AT[1])[1]).",
        "clamp(many[0].centre.xy, 0.0, 1.0).",
    ] {
        assert_eq!(editor.offered(&shader, &body(&format!("{expression}|"))), plane, "{expression}");
    }
    for expression in [
        "hit.voxel.",
        "turn[0].",
        "gl_WorkGroupID.",
        "grown(many[0]).centre.",
        "(2.0 * push.ball.centre).",
        "min(hit.voxel, max(gl_WorkGroupID, 2u)).",
        "(turn * vec4(1.0)).",
    ] {
        assert_eq!(editor.offered(&shader, &body(&format!("{expression}|"))).len(), 14, "{expression}");
    }
    let offered = editor.offered(&shader, &body("hit.|"));
    assert!(offered.iter().any(|name| name == "voxel") && offered.iter().all(|name| name != "rx_trace"), "{offered:?}");
    assert_eq!(editor.offered(&shader, &body("texture(air, push.ball.centre).|")).len(), 30);
    // Without a type nothing is offered: a name that is none, an array, a sum of two sizes, a number.
    for expression in
        ["nothing.", "many.", "AT.", "(AT[0] + push.ball.centre).", "1.", "push.exposure.", "mix(nothing, 1.0, 0.5)."]
    {
        assert_eq!(editor.offered(&shader, &body(&format!("{expression}|"))), [""; 0], "{expression}");
    }
    let place = editor.place(&shader, &body("push.|"));
    let items = editor.ask("textDocument/completion", place);
    let about = items[1]["documentation"]["value"].as_str().unwrap();
    assert!(about.contains("float exposure;") && about.contains("in stops"), "{about}");

    let mut hover = |inside: &str| {
        let place = editor.place(&shader, &body(inside));
        let said = editor.ask("textDocument/hover", place);
        said["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    for (inside, parts) in [
        ("float a = push.expo|sure;", ["float exposure;", "in stops", "A member of `Push`"]),
        ("float a = many[0].rad|ius;", ["float radius, weight[2];", "Never negative.", "A member of `Ball`"]),
        ("vec2 a = hit.u|v;", ["vec2 uv;", "`RxHit`", "raxel/ray.glsl"]),
        ("vec2 a = many[0].centre.z|x;", ["vec2 zx", "Components of a `vec3`", ""]),
        // A member, and not the function of GLSL.
        ("float a = dist|ance;", ["float distance;", "A member of `Sky`", ""]),
        ("vec2 a = mi|x(AT[0], AT[1], push.exposure);", ["T mix(T x", "The type of this call: `vec2`", ""]),
        ("vec2 a = textu|re(air, hit.uv.xyx).xy;", ["gvec4 texture(", "The type of this call: `vec4`", ""]),
    ] {
        let said = hover(inside);
        assert!(parts.iter().all(|part| said.contains(part)), "{inside}: {said}");
    }
    for nothing in ["float a = hit.dist|ance;", "float a = nothing.dist|ance;", "float a = many[0].len|gth();"] {
        assert_eq!(hover(nothing), "", "{nothing}");
    }
    let mut line = |inside: &str| {
        let place = editor.place(&shader, &body(inside));
        editor.ask("textDocument/definition", place)["range"]["start"]["line"].as_u64()
    };
    for (inside, declaration) in [
        ("push.expo|sure;", "float exposure"),
        ("many[0].weig|ht[0];", "float radius"),
        ("float a = dist|ance;", "float distance"),
    ] {
        let expected = MEMBERS.lines().position(|line| line.contains(declaration)).unwrap() as u64;
        assert_eq!(line(inside), Some(expected), "{inside}");
    }
    assert_eq!((line("float a = many[0].centre.x|y;"), line("hit.ball|s;")), (None, None));
}

/// The library is in the binary alone.
#[test]
fn names_of_the_library_lead_to_its_files() {
    let project = Project::empty();
    project.write("shaders/members.comp", MEMBERS);
    let mut server = command(project.root(), &["lsp", "--stdio"]);
    let cache = project.path("cache");
    server.env("RAXEL_CACHE", &cache);
    let mut editor = Editor::start_by(server, json!({}));
    let shader = project.path("shaders/members.comp");
    editor.open(&shader, MEMBERS);
    for (before, after, line) in [
        ("RxHit hit;", "RxH|it hit;", "struct RxHit {"),
        ("RxHit hit;", "RxHit hit; hit.mater|ial = 0u;", "    uint material;"),
        ("RxHit hit;", "RxHit hit; rx_nor|mal(0u);", "vec3 rx_normal("),
        ("<raxel/ray.glsl>", "<raxel/r|ay.glsl>", ""),
    ] {
        let place = editor.place(&shader, &MEMBERS.replace(before, after));
        let found = editor.ask("textDocument/definition", place);
        let (uri, at) = place_of(&found);
        let path = Path::new(uri.strip_prefix("file://").unwrap_or_else(|| panic!("{after}: {found}")));
        assert!(path.starts_with(&cache) && path.ends_with("raxel/ray.glsl"), "{after}: {found}");
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.lines().nth(usize::try_from(at).unwrap()).unwrap().starts_with(line), "{after}: {found}");
    }
    // Without a cache there is no file to show.
    let mut editor = Editor::start(&project);
    editor.open(&shader, MEMBERS);
    let place = editor.place(&shader, &MEMBERS.replace("RxHit hit;", "RxH|it hit;"));
    assert_eq!(editor.ask("textDocument/definition", place), json!(null));
}

#[test]
fn the_signature_of_a_call_is_shown_while_it_is_typed() {
    let (_project, mut editor, _, shader) = notes();
    let mut signature = |call: &str| {
        let place = editor.place(&shader, &NOTE.replace("far(push.time, 2.0);", call));
        editor.ask("textDocument/signatureHelp", place)
    };
    let own = signature("far(max(1.0, 2.0), |");
    assert_eq!(own["signatures"][0]["label"], "float far(float near, float by)");
    assert_eq!(own["activeParameter"], 1);
    assert_eq!(own["signatures"][0]["documentation"]["value"], "Twice as far.");
    let glsl = signature("clamp(1.0, |");
    assert_eq!(
        (&glsl["signatures"][0]["label"], &glsl["activeParameter"]),
        (&json!("T clamp(T x, T low, T high)"), &json!(1))
    );
    let library = signature("rx_tone(|");
    assert_eq!(library["signatures"][0]["label"], "vec3 rx_tone(vec3 light, uint curve)");
    let print = signature("0.0; debugPrintfEXT(\"%f\", |");
    assert_eq!(print["signatures"][0]["label"], "void debugPrintfEXT(string format, values...)");
    assert_eq!(print["activeParameter"], 1);
    let assert = signature("0.0; rx_assert(|");
    assert_eq!(assert["signatures"][0]["label"], "void rx_assert(bool condition)");
    assert!(signature("|").is_null());
}

#[test]
fn the_words_of_glsl_and_the_functions_that_print_are_known() {
    let (_project, mut editor, _, shader) = notes();
    let offered = editor.offered(&shader, &NOTE.replace("// Twice as far.", "l|"));
    for word in [
        "layout",
        "uniform",
        "readonly",
        "struct",
        "vec3",
        "mat4x3",
        "uimage2D",
        "sampler3D",
        "debugPrintfEXT",
        "rx_assert",
    ] {
        assert!(offered.iter().any(|label| label == word), "{word} is not among {offered:?}");
    }
    let names: BTreeSet<&String> = offered.iter().collect();
    assert_eq!(names.len(), offered.len(), "one is there twice: {offered:?}");
    let has = |offered: &[String], name: &str| offered.iter().any(|label| label == name);
    // The words of a layout are names elsewhere.
    assert!(!has(&offered, "push_constant") && !has(&offered, "rgba16f"));
    let offered = editor.offered(&shader, &NOTE.replace("layout(rgba16f)", "layout(|)"));
    assert!(has(&offered, "push_constant") && has(&offered, "local_size_x") && has(&offered, "r32ui"), "{offered:?}");
    for (call, meaning) in [
        ("debugPrin|tfEXT(\"%f\", 1.0);", "Prints a line"),
        ("rx_ass|ert(true);", "Reports an error if the condition is false"),
    ] {
        let with_print = NOTE.replace("#version 460\n", "#version 460\n#include <raxel/print.glsl>\n");
        let place = editor.place(&shader, &with_print.replace("imageStore", &format!("{call}\n    imageStore")));
        let said = editor.ask("textDocument/hover", place);
        let said = said["contents"]["value"].as_str().unwrap_or_else(|| panic!("{call} has no hover"));
        assert!(said.contains(meaning) && said.contains("`#include <raxel/print.glsl>`"), "{said}");
    }
}
