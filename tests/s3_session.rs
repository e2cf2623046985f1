//! Sessions over a world on a real server of S3 that goes away and comes back: nothing is shown that is wrong, and nothing ends.
//!
//! `cargo test --profile checked --features cloud --test s3_session -- --ignored`; `engine/bake/tests/common/s3.rs` says which server.
#![cfg(all(feature = "cloud", target_os = "linux"))]

mod common;
#[allow(dead_code, reason = "a part of this is for other tests")]
#[path = "../engine/bake/tests/common/s3.rs"]
mod s3;

use std::fs;
use std::io::Write as _;
use std::process::{ChildStdin, Command, Stdio};

use common::{Display, Project, Run, Running, Said, command, eventually, line, output};
use s3::{Server, restarted};
use serde_json::{Value, json};

/// A world behind a source. Each camera sees other chunks of it.
const WORLD: &str = r#"
[stream]
source = "zarr:SOURCE"
near = 64
[camera]
position = [-90, 125, 0]
look_at = [-70, 60, 10]
"#;

/// Two places that share no chunk.
const PLACES: [[i32; 3]; 2] = [[-90, 125, 0], [150, 125, 0]];
/// A place between them, which needs chunks that neither of them has.
const MIDDLE: [i32; 3] = [30, 125, 0];

/// There and back, so that chunks are loaded, dropped and loaded again.
const DEMO: &str = include_str!("fixtures/s3_session/there_and_back.demo.toml");

const SIZE: [&str; 4] = ["--size", "96x72", "--watchdog", "100"];

/// A part of the endless world on a server, and the same in a folder of the project.
struct Stage {
    server: Server,
    project: Project,
}

impl Stage {
    fn new() -> Self {
        let (server, project) = (Server::start(), Project::shipped());
        let region = ["--edge", "64", "--levels", "1", "--min", "-192,0,-64", "--max", "256,128,128"];
        let stage = Self { server, project };
        for out in ["s3://worlds/land", "worlds/land"] {
            let bake = ["world", "bake", "worlds/frontier.toml", "--out", out];
            Run::from(output(&mut stage.command(&[&bake[..], &region].concat()))).exits(0);
        }
        for (name, source) in [("remote", "s3://worlds/land"), ("local", "worlds/land")] {
            stage.project.write(&format!("worlds/{name}.toml"), WORLD.replace("SOURCE", source));
            stage.project.write(&format!("worlds/{name}.demo.toml"), DEMO.replace("WORLD", name));
        }
        stage
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = command(self.project.root(), arguments);
        command.envs(self.server.environment()).env_remove("WAYLAND_DISPLAY");
        command
    }

    /// A session that a program drives, over the world of that name.
    fn driven(&self, verb: &[&str], world: &str, display: Option<&Display>) -> Driven {
        let world = format!("worlds/{world}.toml");
        let of = ["graphs/inspect.toml", "--world", &world];
        let mut command = self.command(&[verb, &of, &SIZE].concat());
        command.envs(display.map(|display| ("DISPLAY", &display.name)));
        let log = self.project.path("log");
        let mut child = Running::start(
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(fs::File::create(&log).unwrap()),
        );
        let (requests, answers) = (child.0.stdin.take().unwrap(), Said::by(child.0.stdout.take().unwrap(), line));
        let driven = Driven { child, requests, answers, log };
        driven.answer("event");
        driven
    }

    fn film(&self, world: &str) -> Vec<Vec<u8>> {
        let out = format!("{world}-%d.png");
        let demo = format!("worlds/{world}.demo.toml");
        let film = ["render", &demo, "--frames", "48", "--fps", "60", "-o", &out];
        Run::from(output(&mut self.command(&[&film[..], &SIZE].concat()))).exits(0);
        (0..48).map(|frame| fs::read(self.project.path(&format!("{world}-{frame}.png"))).unwrap()).collect()
    }
}

struct Driven {
    child: Running,
    requests: ChildStdin,
    answers: Said<String>,
    log: std::path::PathBuf,
}

impl Driven {
    /// The next line with that field.
    fn answer(&self, field: &str) -> Value {
        loop {
            let line: Value = serde_json::from_str(&self.answers.next()).unwrap();
            if line.get(field).is_some() {
                return line;
            }
        }
    }

    fn ask(&mut self, request: &Value) -> Value {
        writeln!(self.requests, "{request}").unwrap_or_else(|error| panic!("{error}\n{}", self.said()));
        self.answer("ok")
    }

    #[track_caller]
    fn done(&mut self, request: &Value) -> Value {
        let answer = self.ask(request);
        assert!(answer["ok"] == true, "{request}: {answer}\n{}", self.said());
        answer
    }

    fn go_to(&mut self, place: [i32; 3]) {
        let look_at = [place[0] + 20, 60, 10];
        self.done(&json!({ "do": "camera", "position": place, "look_at": look_at }));
    }

    /// The picture of the last frame; null before the first one.
    fn picture(&mut self) -> Value {
        self.ask(&json!({ "do": "picture" }))["data"].clone()
    }

    fn said(&self) -> String {
        fs::read_to_string(&self.log).unwrap()
    }

    fn quit(mut self) -> String {
        self.done(&json!({ "do": "quit" }));
        assert_eq!(self.child.finish().code(), Some(0), "{}", self.said());
        self.said()
    }
}

/// The pictures of both places from the world in a folder.
fn expected(stage: &Stage) -> [Value; 2] {
    let mut local = stage.driven(&["control"], "local", None);
    let pictures = PLACES.map(|place| {
        local.go_to(place);
        local.done(&json!({ "do": "step" }));
        local.picture()
    });
    local.quit();
    assert!(pictures[0] != pictures[1]);
    pictures
}

#[test]
#[ignore = "needs s3s-fs"]
fn a_film_from_a_server_that_restarts_is_the_film_from_a_folder() {
    let stage = Stage::new();
    let local = stage.film("local");
    assert!(local[0] != local[24]);
    let remote = restarted(&stage.server, || stage.film("remote"));
    let restarts = stage.server.take_restarts();
    assert!(restarts > 1, "{restarts}");
    let wrong: Vec<usize> = (0..48).filter(|frame| local[*frame] != remote[*frame]).collect();
    assert!(wrong.is_empty(), "frames {wrong:?} differ");
}

#[test]
#[ignore = "needs s3s-fs"]
fn a_session_keeps_its_picture_while_its_server_is_away() {
    let stage = Stage::new();
    let [first, second] = expected(&stage);
    let mut session = stage.driven(&["control"], "remote", None);
    session.go_to(PLACES[0]);
    session.done(&json!({ "do": "step" }));
    assert!(session.picture() == first);
    {
        let _away = stage.server.away();
        // A place that is loaded needs no server.
        session.done(&json!({ "do": "step" }));
        session.go_to(PLACES[1]);
        let refused = session.ask(&json!({ "do": "step" }));
        let reason = refused.to_string();
        assert!(refused["ok"] == false && reason.contains("s3://worlds/land"), "{reason}");
        assert!(session.picture() == first, "the last picture stays");
    }
    session.done(&json!({ "do": "step" }));
    assert!(session.picture() == second);
    session.quit();
}

#[test]
#[ignore = "needs s3s-fs"]
fn a_window_says_that_its_server_is_away_and_goes_on() {
    let (stage, display) = (Stage::new(), Display::start());
    let second = expected(&stage)[1].clone();
    let mut window = stage.driven(&["run", "--control", "--no-panels"], "remote", Some(&display));
    window.go_to(PLACES[1]);
    eventually("the second place", || window.picture() == second);
    {
        let _away = stage.server.away();
        window.go_to(MIDDLE);
        eventually("it says so", || window.said().contains("chunks of the world are missing"));
        // Frames go on: the camera has left.
        eventually("another picture", || {
            let now = window.picture();
            now.is_string() && now != second
        });
    }
    eventually("it says that all is there", || window.said().contains("the chunks that were missing are there"));
    window.go_to(PLACES[1]);
    eventually("the second place again", || window.picture() == second);
    let said = window.quit();
    assert!(said.contains("RX0451") && said.contains("s3://worlds/land"), "{said}");
    assert_eq!(said.matches("chunks of the world are missing").count(), 1, "{said}");
}
