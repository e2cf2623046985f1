//! The language server as an editor drives it: diagnostics as you type, completion, hover, definitions.

mod common;

use std::collections::BTreeSet;
use std::io::{BufRead, Write};
use std::path::Path;
use std::process::{ChildStdin, Command, Stdio};

use common::{Project, Running, Said, command};
use serde_json::{Value, json};

/// An editor with a server.
struct Editor {
    child: Running,
    to: ChildStdin,
    from: Said<Value>,
    id: u64,
}

fn address(path: &Path) -> String {
    format!("file://{}", path.canonicalize().unwrap().display())
}

/// The next message of a server; `None` when it has gone.
fn message(pipe: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let line = common::line(pipe)?;
        match line.trim().strip_prefix("Content-Length: ") {
            Some(number) => length = number.parse().unwrap(),
            None if line.trim().is_empty() => break,
            None => {}
        }
    }
    let mut bytes = vec![0; length];
    pipe.read_exact(&mut bytes).ok()?;
    Some(serde_json::from_slice(&bytes).unwrap())
}

impl Editor {
    fn start(project: &Project) -> Self {
        Self::start_with(project, json!({}))
    }

    #[allow(clippy::needless_pass_by_value, reason = "capabilities are made where they are sent")]
    fn start_with(project: &Project, capabilities: Value) -> Self {
        Self::start_by(command(project.root(), &["lsp", "--stdio"]), capabilities)
    }

    #[allow(clippy::needless_pass_by_value, reason = "capabilities are made where they are sent")]
    fn start_by(mut command: Command, capabilities: Value) -> Self {
        let mut child = Running::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()));
        let (to, from) = (child.0.stdin.take().unwrap(), Said::by(child.0.stdout.take().unwrap(), message));
        let mut editor = Self { child, to, from, id: 0 };
        let greeting = editor.ask("initialize", json!({ "capabilities": capabilities }));
        assert_eq!(greeting["serverInfo"]["name"], "raxel");
        editor.tell("initialized", json!({}));
        editor
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        write!(self.to, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        self.to.flush().unwrap();
    }

    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    fn answer(&mut self, method: &str, params: Value) -> Value {
        self.id += 1;
        let id = self.id;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let message = self.from.next();
            if message["id"] == json!(id) {
                return message;
            }
        }
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        let message = self.answer(method, params);
        assert!(message["error"].is_null(), "{message}");
        message["result"].clone()
    }

    /// Why a request is refused.
    fn refused(&mut self, method: &str, params: Value) -> String {
        let message = self.answer(method, params);
        message["error"]["message"].as_str().unwrap_or_else(|| panic!("{message}")).to_owned()
    }

    fn open(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": address(path), "languageId": "x", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    fn change(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": address(path), "version": 2 });
        self.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [{ "text": text }] }));
    }

    /// The next diagnostics of a file.
    fn diagnostics(&mut self, path: &Path) -> Vec<Value> {
        loop {
            let message = self.from.next();
            if message["method"] == "textDocument/publishDiagnostics"
                && message["params"]["uri"] == json!(address(path))
            {
                return message["params"]["diagnostics"].as_array().unwrap().clone();
            }
        }
    }

    /// The completions at `|` in a text of the file.
    fn offered(&mut self, path: &Path, text: &str) -> Vec<String> {
        let place = self.place(path, text);
        let items = self.ask("textDocument/completion", place);
        items.as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap().to_owned()).collect()
    }

    /// Sends a text without its `|`, and gives the position of it.
    fn place(&mut self, path: &Path, text: &str) -> Value {
        let at = text.find('|').unwrap();
        self.change(path, &text.replacen('|', "", 1));
        let line = text[..at].matches('\n').count();
        let character = text[..at].rsplit('\n').next().unwrap().encode_utf16().count();
        json!({ "textDocument": { "uri": address(path) }, "position": { "line": line, "character": character } })
    }
}

#[test]
fn mistakes_are_told_as_they_are_typed_and_taken_back() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let (graph, shader) = (project.path("graphs/inspect.toml"), project.path("shaders/inspect.comp"));
    let text = std::fs::read_to_string(&graph).unwrap();
    // Nothing is saved: the text of the editor counts.
    editor.open(&graph, &text.replacen("present", "presnet", 1));
    let found = editor.diagnostics(&graph);
    let wrong = found.iter().find(|found| found["message"].as_str().unwrap().contains("presnet")).unwrap();
    assert_eq!(wrong["source"], "raxel");
    let line = text.lines().position(|line| line.starts_with("present")).unwrap();
    assert_eq!(wrong["range"]["start"], json!({ "line": line, "character": 0 }));
    assert!(wrong["message"].as_str().unwrap().contains("did you mean `present`?"), "{wrong}");
    editor.change(&graph, &text);
    assert_eq!(editor.diagnostics(&graph), [json!(null); 0]);

    // A mistake in a shader is reported in the shader; where two files disagree, both places are named.
    let source = std::fs::read_to_string(&shader).unwrap();
    editor.open(&shader, &source.replace("float sky_depth;", "int sky_depth;"));
    let found = editor.diagnostics(&graph);
    let related = found[0]["relatedInformation"].as_array().unwrap();
    assert!(related.iter().any(|place| place["location"]["uri"] == json!(address(&shader))), "{found:?}");
    editor.change(&shader, &source.replace("void main", "void mian"));
    assert!(!editor.diagnostics(&shader).is_empty());
    editor.ask("shutdown", json!(null));
    editor.tell("exit", json!(null));
    assert!(editor.child.finish().success());
}

/// TOML has single quotes, too.
#[test]
fn a_shader_is_checked_with_a_graph_that_names_it_in_single_quotes() {
    let project = Project::empty();
    let graph = "name = 'one'\npresent = 'color'\n[targets.color]\nformat = 'rgba8'\n[[passes]]\nname = 'fill'\n\
                 shader = 'fill.comp'\ndispatch = { threads = 'color' }\nbind = { color = 'color' }\n";
    project.write("graphs/one.toml", graph);
    let shader = project.path("shaders/fill.comp");
    let text = "#version 460\nlayout(local_size_x = 8) in;\nlayout(rgba8) uniform writeonly image2D color;\n\
                void main() { imageStore(color, ivec2(0), vec3(1)); }\n";
    project.write("shaders/fill.comp", text);
    let mut editor = Editor::start(&project);
    editor.open(&shader, text);
    let found = editor.diagnostics(&shader);
    assert!(found[0]["message"].as_str().unwrap().contains("imageStore"), "{found:?}");
}

#[test]
fn names_are_completed_and_explained() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let graph = project.path("graphs/inspect.toml");
    editor.open(&graph, "");
    let text = "present = \"a\"\n[params.sun]\ntype = \"f32\"\n[targets.color]\nformat = \"r8\"\n[buffers.list]\nsize = 4\n[[passes]]\nname = \"p\"\n";
    let has = |offered: &[String], wanted: &[&str]| {
        for name in wanted {
            assert!(offered.iter().any(|label| label == name), "{name} is not among {offered:?}");
        }
    };
    let offered = editor.offered(&graph, &format!("{text}bind = {{ out = \"|\" }}\n"));
    assert_eq!(offered, ["color", "list"]);
    let offered = editor.offered(&graph, &format!("{text}[passes.push]\nx = {{ type = \"f32\", from = \"|\" }}\n"));
    has(&offered, &["camera.cell", "frame.time", "param.sun"]);
    has(&editor.offered(&graph, &format!("{text}sha|")), &["shader", "dispatch", "bind", "when"]);
    has(
        &editor.offered(&graph, &format!("{text}shader = \"|\"")),
        &["inspect.comp", "primary.comp", "examples/mip_down.comp"],
    );
    has(&editor.offered(&graph, "[targets.a]\nfor|"), &["format", "size", "history"]);
    has(&editor.offered(&graph, "[targets.a]\nformat = \"|\""), &["rgba16f", "r32f"]);
    let sources = ["world.tree64", "world.instances", "input.keys", "world.edits", "model.tree.tree64"];
    has(&editor.offered(&graph, "[buffers.a]\nsource = \"|\""), &sources);
    let manifest = project.path("raxel.toml");
    std::fs::write(&manifest, "").unwrap();
    editor.open(&manifest, "");
    let offered = editor.offered(&manifest, "demo = \"|\"\n");
    assert!(offered.contains(&"valley.demo.toml".to_owned()) && !offered.contains(&"valley.toml".to_owned()));
    has(&editor.offered(&manifest, "wor|"), &["world", "graph", "size"]);
    // Of tables of several forms, those that are written.
    let demo = project.path("worlds/valley.demo.toml");
    editor.open(&demo, "");
    let offered = editor
        .offered(&demo, "[[edits]]\ntime = 1.0\nop = \"sphere\"\n|\nmode = \"subtract\"\n[[edits]]\nop = \"box\"\n");
    assert_eq!(offered, ["center", "material", "mode", "op", "radius", "time"]);
    // A demo can show the targets of its graph, and of the graph that this one extends.
    let show = "graph = \"beauty.toml\"\n[[show]]\ntime = 1.0\ntarget = \"|\"\n";
    has(&editor.offered(&demo, show), &["bloom", "slot", "hit", "sky_view", "queue"]);
    let ops = ["box", "cylinder", "model", "restore", "set", "sphere"];
    assert_eq!(editor.offered(&demo, "[[edits]]\nop = \"|\"\n"), ops);
    let world = project.path("worlds/pool.toml");
    editor.open(&world, "");
    let offered = editor.offered(&world, "[[build]]\nop = \"cylinder\"\nra|");
    has(&offered, &["base", "radius", "top_radius", "axis"]);
    assert!(!offered.iter().any(|key| ["level", "layers", "center"].contains(&key.as_str())), "{offered:?}");
    let shader = project.path("shaders/inspect.comp");
    editor.open(&shader, "");
    has(&editor.offered(&shader, "void main() { rx_|"), &["rx_trace", "rx_camera_ray", "RxHit"]);
    for include in ["#include <|>", "#include \"|", "#include <raxel/wo|>"] {
        let offered = editor.offered(&shader, &format!("#version 460\n{include}\nvoid main() {{}}\n"));
        has(&offered, &["raxel/world.glsl", "examples/frame.glsl"]);
        assert!(!offered.iter().any(|name| name.starts_with("rx_") || name.starts_with("include/")), "{offered:?}");
    }
    let block = "layout(push_constant) uniform Push { float exposure; vec2 size; } push;\n";
    assert_eq!(editor.offered(&shader, &format!("{block}void main() {{ push.e|")), ["exposure", "size"]);

    let place = editor.place(&graph, "[targets.a]\nhist|ory = 1\n");
    let said = editor.ask("textDocument/hover", place);
    assert!(said["contents"]["value"].as_str().unwrap().starts_with("`history`: "), "{said}");
    let place = editor.place(&graph, "[[passes]]\naf|ter = \"color\"\n");
    let said = editor.ask("textDocument/hover", place);
    assert!(
        said["contents"]["value"].as_str().unwrap().contains("Not beside `before`: a pass has one place."),
        "{said}"
    );
    let place = editor.place(&graph, &format!("{text}bind = {{ out = \"col|or\" }}\n"));
    let found = editor.ask("textDocument/definition", place);
    assert_eq!(found["range"]["start"]["line"], json!(3));
    let place = editor.place(&graph, &format!("{text}shader = \"inspe|ct.comp\"\n"));
    assert_eq!(editor.ask("textDocument/definition", place)["uri"], json!(address(&shader)));
}

/// Where something is declared: the file, and the line from 0.
fn place_of(found: &Value) -> (&str, u64) {
    (found["uri"].as_str().unwrap_or_default(), found["range"]["start"]["line"].as_u64().unwrap_or(u64::MAX))
}

#[test]
fn names_of_the_base_are_known_in_a_graph_that_extends_it() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let (graph, base) = (project.path("graphs/mine.toml"), project.path("graphs/inspect.toml"));
    std::fs::write(&graph, "").unwrap();
    editor.open(&graph, "");
    let head = "extends = \"inspect.toml\"\n[params.gain]\ntype = \"f32\"\ndefault = 1.0\n";
    let pass = format!("{head}[[passes]]\nname = \"inspect\"\n");
    let mut has = |text: &str, wanted: &[&str], none: &[&str]| {
        let offered = editor.offered(&graph, text);
        assert!(wanted.iter().all(|name| offered.iter().any(|label| label == name)), "{text}: {offered:?}");
        assert!(!none.iter().any(|name| offered.iter().any(|label| label == name)), "{text}: {offered:?}");
    };
    has(&format!("{head}present = \"|\""), &["depth", "normal", "world"], &[]);
    has(&format!("{pass}bind = {{ outDepth = \"|\" }}\n"), &["depth", "steps"], &["outDepth"]);
    has(&format!("{head}[[passes]]\nname = \"b\"\nafter = \"|\""), &["inspect", "b"], &[]);
    // Short forms: the value of a member is what it comes from, and names are those of the shader.
    let values = ["camera.fov", "param.gain", "param.sky_depth", "target.depth.size", "buffer.world.count"];
    has(&format!("{pass}push = {{ sky_depth = \"|\" }}\n"), &values, &[]);
    has(&format!("{pass}[passes.push]\nsky_depth = \"|\""), &values, &[]);
    has(&format!("{pass}push = {{ | }}\n"), &["sky_depth", "camera_cell"], &["outHit", "name"]);
    has(&format!("{pass}[passes.push]\ncam|"), &["sky_depth", "camera_cell"], &["from", "outHit"]);
    has(&format!("{pass}bind = {{ | }}\n"), &["outHit", "outSteps"], &["push", "name"]);
    has(&format!("{head}[blocks.Push]\n|"), &["sky_depth", "tan_half_fov"], &["name"]);
    has(&format!("{head}[targets.|"), &["depth", "normal"], &["gain"]);
    has(&format!("{pass}[passes.|"), &["push", "bind", "uniforms"], &["targets"]);

    let place = editor.place(&graph, &format!("{head}present = \"dep|th\"\n"));
    let said = editor.ask("textDocument/hover", place.clone());
    let said = said["contents"]["value"].as_str().unwrap();
    assert!(said.contains("[targets.depth]") && said.contains("`graphs/inspect.toml`"), "{said}");
    let lines = std::fs::read_to_string(&base).unwrap();
    let line = lines.lines().position(|line| line == "[targets.depth]").unwrap() as u64;
    assert_eq!(place_of(&editor.ask("textDocument/definition", place)), (address(&base).as_str(), line));
    // A binding leads to the shader.
    let shader = project.path("shaders/inspect.comp");
    let text = std::fs::read_to_string(&shader).unwrap();
    let line = text.lines().position(|line| line.contains("image2D outDepth;")).unwrap() as u64;
    let place = editor.place(&graph, &format!("{pass}bind = {{ outDep|th = \"depth\" }}\n"));
    assert_eq!(place_of(&editor.ask("textDocument/definition", place)), (address(&shader).as_str(), line));

    let demo = project.path("worlds/mine.demo.toml");
    std::fs::write(&demo, "").unwrap();
    editor.open(&demo, "");
    let head = "world = \"valley.toml\"\ngraph = \"mine.toml\"\n[[edits]]\ntime = 1.0\nop = \"set\"\n";
    let offered = editor.offered(&demo, &format!("{head}material = \"|\"\n"));
    assert!(offered.contains(&"grass".to_owned()) && offered.contains(&"sand".to_owned()), "{offered:?}");
    assert_eq!(editor.offered(&demo, &format!("{head}[tracks.]\n|")), ["interpolation", "keys"]);
    std::fs::write(&graph, "extends = \"inspect.toml\"\n[params.gain]\n").unwrap();
    editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": address(&graph) } }));
    assert_eq!(editor.offered(&demo, &format!("{head}[tracks.|]\n")), ["gain", "sky_depth"]);
}

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

/// The edits of a rename in a file, as the texts that they replace by line.
fn edits_in<'v>(edit: &'v Value, path: &Path) -> Vec<&'v Value> {
    edit["changes"][address(path)].as_array().map(|edits| edits.iter().collect()).unwrap_or_default()
}

const NOTE: &str = "#version 460
layout(local_size_x = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float time; } push;
// Twice as far.
float far(float near, float by) {
    float twice = near * by;
    return twice;
}
void main() {
    float near = far(push.time, 2.0);
    imageStore(outColor, ivec2(0), vec4(near));
}
";

const NOTES: &str = "name = \"note\"
present = \"color\"
[params.speed]
type = \"f32\"
default = 1.0
[targets.color]
format = \"rgba16f\"
[[passes]]
name = \"note\"
shader = \"note.comp\"
dispatch = { threads = \"color\" }
bind = { outColor = \"color\" }
push = { time = \"param.speed\" }
";

fn notes() -> (Project, Editor, std::path::PathBuf, std::path::PathBuf) {
    let project = Project::empty();
    project.write("graphs/note.toml", NOTES).write("shaders/note.comp", NOTE);
    project.write("graphs/more.toml", "extends = \"note.toml\"\n[[passes]]\nname = \"note\"\nbind = { outColor = \"color\" }\npush.time = \"param.speed\"\n");
    let mut editor = Editor::start(&project);
    let (graph, shader) = (project.path("graphs/note.toml"), project.path("shaders/note.comp"));
    editor.open(&graph, NOTES);
    editor.open(&shader, NOTE);
    (project, editor, graph, shader)
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
const MEMBERS: &str = "#version 460
#include <raxel/ray.glsl>
layout(local_size_x = 8) in;
// A ball.
struct Ball {
    vec3 centre; // in voxels
    // Never negative.
    float radius, weight[2];
};
layout(push_constant) uniform Push {
    Ball ball;
    float exposure; // in stops
} push;
layout(std430) readonly buffer Balls { uint count; Ball all[]; } balls;
layout(std140) uniform Sky { mat4x3 turn; float distance; };
uniform sampler3D air;
const vec2 AT[2] = vec2[2](vec2(0.0), vec2(1.0));
Ball grown(Ball ball) { return ball; }
void main() {
    RxHit hit;
    Ball many[2];
    //
}
";

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

#[test]
fn values_of_keys_are_completed_and_explained() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let (graph, demo) = (project.path("graphs/mine.toml"), project.path("worlds/mine.demo.toml"));
    for path in [&graph, &demo] {
        std::fs::write(path, "").unwrap();
        editor.open(path, "");
    }
    let head = "world = \"valley.toml\"\ngraph = \"inspect.toml\"\n";
    for keys in ["keys = [[0.0, [\"|\"]]]\n", "keys = [\n    # held\n    [0.0, [\"|\"]],\n]\n"] {
        let offered = editor.offered(&demo, &format!("{head}[inputs]\n{keys}"));
        assert!(
            offered.len() > 100 && ["KeyW", "ArrowLeft"].iter().all(|key| offered.iter().any(|label| label == key))
        );
    }
    let offered = editor.offered(&demo, &format!("{head}[inputs]\nbuttons = [[0.0, [\"|\"]]]\n"));
    assert_eq!(offered, ["left", "right", "middle", "back", "forward"]);
    let offered =
        editor.offered(&demo, &format!("{head}[inputs]\ngamepad_buttons = [[0.0, [\"left_stick\", \"|\"]]]\n"));
    assert!(offered.iter().any(|label| label == "south"), "{offered:?}");
    // The keys of a track are no inputs.
    let offered = editor.offered(&demo, &format!("{head}[tracks.sky_depth]\nkeys = [[0.0, \"|\"]]\n"));
    assert_eq!(offered, [""; 0]);

    let mut hover = |path: &Path, text: &str| {
        let place = editor.place(path, text);
        let said = editor.ask("textDocument/hover", place);
        said["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    for (text, meaning) in [
        ("[targets.a]\nformat = \"rgba|16f\"\n", "`rgba16f`: channels: 4, read as floats; bytes of a texel: 8"),
        ("[buffers.a]\nsource = \"world.tr|ee64\"\n", "`world.tree64`: supplied by the session"),
        ("[targets.a.display]\nmap = \"tur|bo\"\n", "`turbo`: One channel through the Turbo colour map."),
        ("[targets.a]\ndisplay = \"i|d\"\n", "`id`: A hash of the integer channels as colour."),
        (
            "[[passes]]\nname = \"a\"\nwhen = \"!world.has_em|ission\"\n",
            "`world.has_emission`: `bool`. Holds if a voxel of the world",
        ),
        (
            "[[passes]]\nname = \"a\"\nwhen = \"device.pac|kets\"\n",
            "`device.packets`: `bool`. Holds if `<raxel/packet.glsl>`",
        ),
        (
            "[buffers.a]\nwhen = \"world.has_inst|ances\"\n",
            "`world.has_instances`: `bool`. Holds if the world has instances.",
        ),
        ("[[passes]]\nname = \"a\"\nwhen = \"alw|ays\"\n", "`always`: Takes the condition of the base away."),
        ("[params.fog]\ntype = \"bool\"\n[[passes]]\nname = \"a\"\nwhen = \"!param.fo|g\"\n", "type = \"bool\""),
    ] {
        let said = hover(&graph, text);
        assert!(said.contains(meaning), "{text}: {said}");
    }
    for (text, meaning) in [
        ("[[edits]]\nop = \"sp|here\"\n", "`sphere`: A ball."),
        ("[inputs]\nkeys = [[0.0, [\"Key|W\"]]]\n", "`keys`: Keys that are held from then on"),
        ("[tracks.sky_|depth]\n", "[params.sky_depth]"),
    ] {
        let said = hover(&demo, &format!("{head}{text}"));
        assert!(said.contains(meaning), "{text}: {said}");
    }
    let place = editor.place(&demo, &format!("{head}[tracks.sky_|depth]\n"));
    let found = editor.ask("textDocument/definition", place);
    assert_eq!(place_of(&found).0, address(&project.path("graphs/inspect.toml")), "{found}");
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

#[test]
fn names_are_followed_and_changed_across_shaders_and_graphs() {
    let (project, mut editor, graph, shader) = notes();
    let at = |text: &str, of: &str, skip: usize| {
        let byte = text.match_indices(of).nth(skip).unwrap().0;
        let line = text[..byte].matches('\n').count();
        json!({ "line": line, "character": text[..byte].rsplit('\n').next().unwrap().len() })
    };
    let rename = |editor: &mut Editor, file: &Path, position: &Value, new: &str| {
        let params = json!({ "textDocument": { "uri": address(file) }, "position": position, "newName": new });
        editor.ask("textDocument/rename", params)
    };
    // A parameter, and not the local of the same name elsewhere.
    let edit = rename(&mut editor, &shader, &at(NOTE, "near", 0), "close");
    let lines: Vec<u64> =
        edits_in(&edit, &shader).iter().map(|edit| edit["range"]["start"]["line"].as_u64().unwrap()).collect();
    assert_eq!(lines, [5, 6]);
    // A binding, from the shader and from a graph: in both, and in a graph that extends it.
    for (file, position) in [(&shader, at(NOTE, "outColor", 1)), (&graph, at(NOTES, "outColor", 0))] {
        let edit = rename(&mut editor, file, &position, "picture");
        assert_eq!(edits_in(&edit, &shader).len(), 2, "{edit}");
        assert_eq!(edits_in(&edit, &graph).len(), 1, "{edit}");
        assert_eq!(edits_in(&edit, &project.path("graphs/more.toml")).len(), 1, "{edit}");
    }
    // A param, in the graph that declares it and in the one that extends it.
    let edit = rename(&mut editor, &graph, &at(NOTES, "speed", 1), "rate");
    assert_eq!(edits_in(&edit, &graph).len(), 2, "{edit}");
    assert_eq!(edits_in(&edit, &project.path("graphs/more.toml")).len(), 1, "{edit}");
    let params = json!({ "textDocument": { "uri": address(&shader) }, "position": at(NOTE, "far", 1), "context": { "includeDeclaration": true } });
    assert_eq!(editor.ask("textDocument/references", params).as_array().map(Vec::len), Some(2));
    // An impossible name is refused with a reason, and half a text does not stop it.
    for (position, new, reason) in [
        (at(NOTE, "outColor", 0), "2d", "is no name"),
        (at(NOTE, "outColor", 0), "image2D", "is a name of GLSL"),
        (at(NOTE, "outColor", 0), "far", "is a name in"),
        (at(NOTE, "imageStore", 0), "store", "is a name of GLSL"),
    ] {
        let params = json!({ "textDocument": { "uri": address(&shader) }, "position": position, "newName": new });
        let refused = editor.refused("textDocument/rename", params);
        assert!(refused.contains(reason), "{refused}");
    }
    editor.change(&shader, "void main( { float a = ");
    let place = json!({ "textDocument": { "uri": address(&shader) }, "position": { "line": 0, "character": 19 }, "newName": "b" });
    editor.ask("textDocument/rename", place);
}

/// A graph may extend one of another folder and change its param; a world may move instances by it.
#[test]
fn a_param_is_renamed_in_every_folder_that_overrides_or_uses_it() {
    let project = Project::empty();
    project.write("shaders/note.comp", NOTE).write("graphs/base/note.toml", NOTES);
    let over = "extends = \"../base/note.toml\"\n[params.speed]\ndefault = 2.0\n";
    project.write("graphs/top/note.toml", over).write("graphs/top.toml", over.replace("..", "."));
    project.write("graphs/base/alone.toml", NOTES);
    project.write("worlds/note.toml", "[[instances]]\nturn = { param = \"speed\" }\n");
    project.write("worlds/shots/note.demo.toml", "graph = \"base/note.toml\"\n[tracks.speed]\nkeys = [[0, 1]]\n");
    let changed = ["graphs/base/note.toml", "graphs/top/note.toml", "graphs/top.toml", "worlds/shots/note.demo.toml"];
    for from in changed {
        let mut editor = Editor::start(&project);
        let (file, text) = (project.path(from), std::fs::read_to_string(project.path(from)).unwrap());
        let rename = |editor: &mut Editor| {
            let place = editor.place(&file, &text.replacen("speed", "spe|ed", 1));
            editor.answer(
                "textDocument/rename",
                json!({ "textDocument": place["textDocument"], "position": place["position"], "newName": "rate" }),
            )
        };
        editor.open(&file, &text);
        // The world may run over two graphs, whose params have nothing in common but their name.
        project.write("graphs/base/alone.toml", NOTES);
        let refused = rename(&mut editor);
        assert!(refused["error"]["message"].as_str().is_some_and(|told| told.contains("alone.toml")), "{refused}");
        std::fs::remove_file(project.path("graphs/base/alone.toml")).unwrap();
        let edit = &rename(&mut editor)["result"];
        for (path, count) in changed.into_iter().zip([2, 1, 1, 1]).chain([("worlds/note.toml", 1)]) {
            assert_eq!(edits_in(edit, &project.path(path)).len(), count, "{path}, from {from}: {edit}");
        }
    }
}

/// The line that the first fix of a text changes, as it is after it.
fn first_fix(editor: &mut Editor, graph: &Path, wrong: &str) -> String {
    editor.change(graph, wrong);
    let found = loop {
        let found = editor.diagnostics(graph);
        if found.iter().any(|found| found["message"].as_str().unwrap().contains("did you mean")) {
            break found;
        }
    };
    let params = json!({
        "textDocument": { "uri": address(graph) },
        "range": found[0]["range"],
        "context": { "diagnostics": found },
    });
    let actions = editor.ask("textDocument/codeAction", params);
    let edit = &edits_in(&actions[0]["edit"], graph)[0];
    let line = wrong.lines().nth(usize::try_from(edit["range"]["start"]["line"].as_u64().unwrap()).unwrap()).unwrap();
    let column = |end: &str| usize::try_from(edit["range"][end]["character"].as_u64().unwrap()).unwrap();
    [&line[..column("start")], edit["newText"].as_str().unwrap(), &line[column("end")..]].concat()
}

/// The fix is written as the file writes it: relative to the folder of shaders, or to that of the graph.
#[test]
fn a_file_that_is_not_there_brings_the_name_of_one_that_is() {
    // The pass is called `note`, too.
    for wrong in ["nota.comp", "old/note.comp", "shaders/note.comp", "note"] {
        let (_project, mut editor, graph, _) = notes();
        let text = NOTES.replace("\"note.comp\"", &format!("{wrong:?}"));
        assert_ne!(text, NOTES);
        let fixed = first_fix(&mut editor, &graph, &text);
        assert_eq!(fixed.split('"').nth(1), Some("note.comp"), "{wrong}: {fixed}");
    }
    for wrong in ["note.toml", "../noet.toml"] {
        let (project, mut editor, ..) = notes();
        project.write("graphs/deep/deep.toml", "");
        let deep = project.path("graphs/deep/deep.toml");
        editor.open(&deep, "");
        assert_eq!(first_fix(&mut editor, &deep, &format!("extends = {wrong:?}\n")), "extends = \"../note.toml\"");
    }
}

/// The thing that the message names may stand in another line than the place that it points at, or within the name of a source.
#[test]
fn a_model_a_file_and_a_default_that_are_not_there_bring_their_fix() {
    let (project, mut editor, graph, _) = notes();
    project.copy_folder("textures");
    let wrong = NOTES.replace("[[passes]]", "[targets.page]\nsource = \"file.textures/tils.png\"\n[[passes]]");
    assert_eq!(first_fix(&mut editor, &graph, &wrong), "source = \"file.textures/tiles.png\"");

    let manifest = project.path("raxel.toml");
    std::fs::write(&manifest, "").unwrap();
    editor.open(&manifest, "");
    assert_eq!(first_fix(&mut editor, &manifest, "graph = \"noet.toml\"\n"), "graph = \"note.toml\"");
    assert_eq!(first_fix(&mut editor, &manifest, "grahp = \"note.toml\"\n"), "graph = \"note.toml\"");

    project.copy_folder("worlds/models");
    let world = "[models.pine]\nfile = \"models/pine.vox\"\n[[build]]\nop = \"model\"\nmodel = \"pine\"\n";
    project
        .write("worlds/trees.toml", world)
        .write("worlds/trees.demo.toml", "graph = \"note.toml\"\nworld = \"trees.toml\"\nduration = 1.0\n");
    let demo = project.path("worlds/trees.demo.toml");
    editor.open(&demo, &std::fs::read_to_string(&demo).unwrap());
    let wrong = NOTES.replace("[[passes]]", "[buffers.tree]\nsource = \"model.pien.tree64\"\n[[passes]]");
    assert_eq!(first_fix(&mut editor, &graph, &wrong), "source = \"model.pine.tree64\"");

    // A sound is named relative to the demo.
    let hears = |file: &str| {
        format!("graph = \"note.toml\"\nworld = \"trees.toml\"\nduration = 1.0\n[inputs]\nmicrophone = \"{file}\"\n")
    };
    let wrong = hears("../textures/nots.ogg");
    assert_eq!(first_fix(&mut editor, &demo, &wrong), "microphone = \"../textures/notes.ogg\"");
}

#[test]
fn diagnostics_bring_their_fix_and_push_values_their_type() {
    let (_project, mut editor, graph, _) = notes();
    let wrong = NOTES.replace("\"param.speed\"", "\"param.sped\"");
    assert_eq!(first_fix(&mut editor, &graph, &wrong), "push = { time = \"param.speed\" }");
    let all = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let hints =
        editor.ask("textDocument/inlayHint", json!({ "textDocument": { "uri": address(&graph) }, "range": all }));
    assert_eq!(hints.as_array().map(Vec::len), Some(1), "{hints}");
    assert_eq!((&hints[0]["label"], &hints[0]["position"]["line"]), (&json!(": float"), &json!(12)));
}

/// The byte of a position in a text.
fn byte_at(text: &str, position: &Value) -> usize {
    let number = |key: &str| usize::try_from(position[key].as_u64().unwrap()).unwrap();
    let start: usize = text.split_inclusive('\n').take(number("line")).map(str::len).sum();
    let mut units = number("character");
    let line = text[start..].split('\n').next().unwrap();
    let is_before = |(_, letter): &(usize, char)| {
        let before = units > 0;
        units = units.saturating_sub(letter.len_utf16());
        before
    };
    start + line.char_indices().take_while(is_before).map(|(_, letter)| letter.len_utf8()).sum::<usize>()
}

/// Makes the changes of a rename in the files.
fn apply(edit: &Value) {
    for (uri, edits) in edit["changes"].as_object().unwrap() {
        let path = Path::new(uri.strip_prefix("file://").unwrap());
        let mut text = std::fs::read_to_string(path).unwrap();
        let mut edits: Vec<(std::ops::Range<usize>, &str)> = edits
            .as_array()
            .unwrap()
            .iter()
            .map(|edit| {
                let place = byte_at(&text, &edit["range"]["start"])..byte_at(&text, &edit["range"]["end"]);
                (place, edit["newText"].as_str().unwrap())
            })
            .collect();
        edits.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
        for (place, new) in edits {
            text.replace_range(place, new);
        }
        std::fs::write(path, text).unwrap();
    }
}

#[test]
fn every_name_of_the_examples_can_be_changed() {
    let project = Project::shipped();
    project.copy_folder("textures");
    let mut editor = Editor::start(&project);
    let examples = std::fs::read_dir(project.path("graphs/examples")).unwrap();
    let mut graphs: Vec<_> = examples.map(|entry| entry.unwrap().path()).collect();
    graphs.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    graphs.sort();
    let mut changed = 0;
    for graph in &graphs {
        editor.open(graph, &std::fs::read_to_string(graph).unwrap());
        let document = json!({ "textDocument": { "uri": address(graph) } });
        let names = |editor: &mut Editor| {
            editor.ask("textDocument/documentSymbol", document.clone()).as_array().unwrap().clone()
        };
        for number in 0..names(&mut editor).len() {
            let symbol = &names(&mut editor)[number];
            let name = symbol["name"].as_str().unwrap();
            let params = json!({ "textDocument": { "uri": address(graph) }, "position": symbol["selectionRange"]["start"], "newName": format!("{name}_2") });
            let answer = editor.answer("textDocument/rename", params);
            if answer["error"].is_null() {
                assert!(!edits_in(&answer["result"], graph).is_empty(), "{name} of {}: {answer}", graph.display());
                apply(&answer["result"]);
                editor.change(graph, &std::fs::read_to_string(graph).unwrap());
                changed += 1;
            } else {
                // A block, or a param of two graphs by which one world moves its instances.
                let is_block = std::fs::read_to_string(graph).unwrap().contains(&format!("[blocks.{name}]"));
                let is_shared = answer["error"]["message"].as_str().unwrap().starts_with("`worlds/fair.toml` means");
                assert!(is_block || is_shared, "{name}: {answer}");
            }
        }
        editor.tell("textDocument/didClose", document);
    }
    assert!(changed > 100, "{changed}");
    let folder = project.root().canonicalize().unwrap();
    let paths =
        graphs.iter().map(|graph| graph.canonicalize().unwrap().strip_prefix(&folder).unwrap().display().to_string());
    let arguments: Vec<String> = std::iter::once("check".to_owned()).chain(paths).collect();
    project.raxel(&arguments.iter().map(String::as_str).collect::<Vec<_>>()).exits(0);
}

/// What is offered as a source or to be copied can be written there: the graph has no mistake.
#[test]
fn what_supplies_a_resource_is_offered_where_it_fits() {
    let (project, mut editor, graph, _) = notes();
    project.copy_folder("textures");
    project.copy_folder("worlds/models");
    project.write("textures/table.bin", "table");
    let world = "[models.pine]\nfile = \"models/pine.vox\"\n[[build]]\nop = \"model\"\nmodel = \"pine\"\n";
    project.write("worlds/trees.toml", world);
    let mut resources = String::new();
    for (table, key, offers, hides) in [
        (
            "targets",
            "source",
            &["world.texture3d", "input.microphone", "file.textures/notes.ogg", "model.pine.texture3d"][..],
            &["world.tree64", "input.keys", "file.textures/table.bin"][..],
        ),
        (
            "targets",
            "copy",
            &["world.texture3d", "model.pine.texture3d"],
            &["world.tree64", "input.microphone", "file.textures/tiles.png"],
        ),
        (
            "buffers",
            "source",
            &["world.tree64", "world.edits", "input.keys", "file.textures/table.bin"],
            &["input.microphone"],
        ),
        (
            "buffers",
            "copy",
            &["world.tree64", "model.pine.octree"],
            &["world.edits", "world.poses", "input.microphone", "file.textures/table.bin"],
        ),
    ] {
        let offered = editor.offered(&graph, &format!("{NOTES}[{table}.a]\n{key} = \"|\""));
        let has = |name: &&str| offered.iter().any(|label| label == name);
        assert!(offers.iter().all(has) && !hides.iter().any(has), "{key} of {table}: {offered:?}");
        for (index, source) in offered.iter().enumerate() {
            resources += &format!("[{table}.{key}{index}_{table}]\n{key} = {source:?}\n");
        }
    }
    project.write("graphs/note.toml", NOTES.replace("[[passes]]", &format!("{resources}[[passes]]")));
    project.raxel(&["check", "graphs/note.toml"]).exits(0);
}

#[test]
fn requests_are_answered_while_every_shader_is_compiled() {
    let project = Project::shipped();
    let mut editor = Editor::start_with(&project, json!({ "window": { "workDoneProgress": true } }));
    let [shader, library] = ["shaders/inspect.comp", "shaders/include/raxel/world.glsl"].map(|path| project.path(path));
    let [text, included] = [&shader, &library].map(|path| std::fs::read_to_string(path).unwrap());
    // Nearly every shader includes the second, and nothing is kept of earlier compilations.
    editor.open(&library, &format!("{included}// changed\n"));
    editor.open(&shader, &text.replace("void main()", "void main(wrong)"));
    let progress = |editor: &mut Editor| loop {
        let message = editor.from.next();
        if message["method"] == "$/progress" {
            break message["params"]["value"]["kind"].as_str().unwrap().to_owned();
        }
    };
    assert_eq!(progress(&mut editor), "begin");
    let document = json!({ "uri": address(&shader) });
    let request = json!({ "textDocument": document });
    editor.send(&json!({ "jsonrpc": "2.0", "id": 77, "method": "textDocument/documentSymbol", "params": request }));
    let first = editor.from.next();
    assert_eq!(first["id"], json!(77), "diagnostics came first: {first}");
    assert_eq!(progress(&mut editor), "end");
    assert!(editor.diagnostics(&shader).iter().any(|found| found["severity"] == json!(1)));
}

/// Errors that the compiler finds in an edited shader come before its graphs are checked, and the check has them too. All else comes with the check.
#[test]
fn the_errors_of_an_edited_shader_come_first() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    // Four graphs run it: the server waits for a quiet moment before it checks them again.
    let shader = project.path("shaders/light/beauty/gloss.comp");
    let text = std::fs::read_to_string(&shader).unwrap();
    let wrong = |text: &str| format!("{text}float wrong = nowhere;\n");
    let codes = |found: &[Value]| found.iter().map(|found| found["code"].to_string()).collect::<BTreeSet<_>>();
    let [error, warning] = ["\"RX0210\"", "\"RX0211\""].map(str::to_owned);
    editor.open(&shader, &wrong(&text));
    let first = editor.diagnostics(&shader);
    assert_eq!(codes(&first), BTreeSet::from([error.clone()]), "{first:?}");

    // The error moves, and there is a warning too.
    let warned = text.replacen("#include", "#extension GL_NV_nothing : warn\n#include", 1);
    editor.change(&shader, &wrong(&warned));
    let looked = editor.diagnostics(&shader);
    assert_eq!(codes(&looked), BTreeSet::from([error.clone()]), "{looked:?}");
    assert_eq!(looked[0]["message"], first[0]["message"]);
    assert_ne!(looked[0]["range"], first[0]["range"]);
    let checked = editor.diagnostics(&shader);
    assert_eq!(codes(&checked), BTreeSet::from([error, warning.clone()]), "{checked:?}");
    assert!(checked.contains(&looked[0]), "{looked:?}\n{checked:?}");

    // Errors of the compiler are taken back at once.
    editor.change(&shader, &wrong(&text));
    assert_eq!(editor.diagnostics(&shader), first);
    editor.change(&shader, &warned);
    assert_eq!(editor.diagnostics(&shader), [json!(null); 0]);
    let checked = editor.diagnostics(&shader);
    assert_eq!(codes(&checked), BTreeSet::from([warning]), "{checked:?}");
    // All else is taken back by the check.
    editor.change(&shader, &text);
    assert_eq!(editor.diagnostics(&shader), [json!(null); 0]);
}

/// A shader that only a graph in a folder runs.
#[test]
fn a_shader_is_checked_with_the_graphs_that_run_it() {
    let project = Project::empty();
    project.write("graphs/deep/note.toml", NOTES).write("graphs/other.toml", NOTES.replace("note.comp", "other.comp"));
    project.write("shaders/note.comp", NOTE).write("shaders/other.comp", "no shader");
    let mut editor = Editor::start(&project);
    let shader = project.path("shaders/note.comp");
    for (wrong, count) in
        [(NOTE.replace("twice;", "thrice;"), 1), (NOTE.to_owned(), 0), (NOTE.replace("far(p", "fur(p"), 1)]
    {
        editor.open(&shader, &wrong);
        let found = loop {
            let found = editor.diagnostics(&shader);
            if found.len() == count {
                break found;
            }
        };
        let names =
            |found: &Value| ["thrice", "fur"].iter().any(|name| found["message"].as_str().unwrap().contains(name));
        assert!(found.iter().all(names), "{found:?}");
    }
}

#[test]
fn members_are_followed_and_changed_across_shaders_and_graphs() {
    let (project, mut editor, graph, shader) = notes();
    let member = NOTE.find("float time").unwrap() + "float ".len();
    let use_of = NOTE.find("push.time").unwrap() + "push.".len();
    let key = NOTES.find("time =").unwrap();
    for (file, text, at) in [(&shader, NOTE, member), (&shader, NOTE, use_of), (&graph, NOTES, key)] {
        let line = text[..at].matches('\n').count();
        let character = text[..at].rsplit('\n').next().unwrap().len();
        let params = json!({ "textDocument": { "uri": address(file) }, "position": { "line": line, "character": character }, "newName": "seconds" });
        let edit = editor.ask("textDocument/rename", params);
        assert_eq!(edits_in(&edit, &shader).len(), 2, "{edit}");
        assert_eq!(edits_in(&edit, &graph).len(), 1, "{edit}");
        assert_eq!(edits_in(&edit, &project.path("graphs/more.toml")).len(), 1, "{edit}");
    }
}

#[test]
fn what_a_shader_lacks_or_does_not_use_is_added_and_removed() {
    let (_project, mut editor, graph, _) = notes();
    let wrong = NOTES
        .replace("{ outColor = \"color\" }", "{ outColor = \"color\", extra = \"color\" }")
        .replace("{ time = \"param.speed\" }", "{ }");
    editor.change(&graph, &wrong);
    let found = loop {
        let found = editor.diagnostics(&graph);
        if found.len() == 2 {
            break found;
        }
    };
    let params = json!({
        "textDocument": { "uri": address(&graph) },
        "range": found[0]["range"],
        "context": { "diagnostics": found },
    });
    let actions = editor.ask("textDocument/codeAction", params);
    let mut titles: Vec<&str> =
        actions.as_array().unwrap().iter().map(|action| action["title"].as_str().unwrap()).collect();
    titles.sort_unstable();
    assert_eq!(titles, ["Add `time = 0.0` to `push`", "Remove `extra`"], "{actions}");
    for action in actions.as_array().unwrap() {
        let edits: Vec<_> = action["edit"]["changes"][address(&graph)].as_array().unwrap().clone();
        let edit = &edits[0];
        let mut text = wrong.clone();
        text.replace_range(
            byte_at(&text, &edit["range"]["start"])..byte_at(&text, &edit["range"]["end"]),
            edit["newText"].as_str().unwrap(),
        );
        let left = if action["title"] == "Remove `extra`" {
            "bind = { outColor = \"color\" }"
        } else {
            "push = { time = 0.0 }"
        };
        assert!(text.contains(left), "{text}");
    }
}
