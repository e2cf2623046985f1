//! Checks a demo against its graphs: the names and values that only the graphs know.

use raxel_diagnostics::{Code, Diagnostic, Spanned, codes};
use raxel_graph::checked::{Graph, Param, Value};

use crate::debug_target::DebugTarget;
use crate::demo::{Claim, Demo, Track};
use crate::params::{self, SetError};

impl Demo {
    /// Everything in which the demo and its graphs disagree, with the places in both files. `graph` returns the graph at a project path;
    /// checks of a graph that it does not return are left out.
    pub fn check<'g>(&self, graph: &dyn Fn(&str) -> Option<&'g Graph>) -> Vec<Diagnostic> {
        let places = self.all_graphs();
        let graphs: Vec<(&Spanned<String>, &Graph)> =
            places.iter().filter_map(|place| Some((*place, graph(&place.value)?))).collect();
        let whole = graphs.len() == places.len();
        let mut found = Vec::new();
        for track in &self.tracks {
            let param = |graph: &'g Graph| Some(&graph.params[graph.find_param(&track.param.value)?.0 as usize]);
            let declared: Vec<&Param> = graphs.iter().filter_map(|(_, graph)| param(graph)).collect();
            if declared.is_empty() && whole {
                let names = graphs.iter().flat_map(|(_, graph)| graph.params.iter().map(|param| param.name.as_str()));
                found.push(self.unknown("param", codes::session::UNKNOWN_PARAM, &track.param, names));
            }
            for param in declared {
                let wrong = check_track(track, param);
                if !wrong.is_empty() {
                    found.extend(wrong);
                    break;
                }
            }
        }
        let mut look_at = |time: f64, target: &Spanned<DebugTarget>| {
            let place = self.graph_in(time);
            let Some(graph) = graph(&place.value) else { return };
            if let Err(error) = target.value.resolve(graph) {
                found.push(
                    Diagnostic::error(codes::session::UNKNOWN_TARGET, error.to_string())
                        .label(target.span.clone(), "no such debug target")
                        .label(place.span.clone(), "in this graph"),
                );
            }
        };
        self.shows.iter().for_each(|key| look_at(key.time.value, &key.target));
        for check in &self.checks {
            if let Claim::Picture { target: Some(target), frame, .. } = &check.claim {
                look_at(self.local_time(frame.number() as f64 / self.fps), target);
            }
        }
        for check in &self.checks {
            if let Claim::Pass { pass, .. } = &check.claim
                && whole
                && graphs.iter().all(|(_, graph)| graph.find_pass(&pass.value).is_none())
            {
                let passes = graphs.iter().flat_map(|(_, graph)| graph.passes.iter().filter(|pass| !pass.made));
                let names = passes.map(|pass| pass.name.as_str());
                found.push(self.unknown("pass", codes::session::UNKNOWN_PASS, pass, names));
            }
        }
        found
    }

    /// None of the graphs has the named thing.
    fn unknown<'n>(
        &self,
        what: &'static str,
        code: Code,
        place: &Spanned<String>,
        names: impl Iterator<Item = &'n str> + Clone,
    ) -> Diagnostic {
        let name = &place.value;
        let (message, label) = if self.graphs.is_empty() {
            (format!("`{}` has no {what} `{name}`", self.graph.value), "in this graph")
        } else {
            (format!("none of the graphs has a {what} `{name}`"), "the first of the graphs")
        };
        Diagnostic::error(code, message)
            .label(place.span.clone(), format!("no such {what}"))
            .label(self.graph.span.clone(), label)
            .with_advice(&SetError::unknown(what, name, names))
    }
}

trait Advice {
    fn with_advice(self, error: &SetError) -> Self;
}

impl Advice for Diagnostic {
    /// Adds the advice of the error.
    fn with_advice(self, error: &SetError) -> Self {
        match error {
            SetError::Unknown { closest: Some(name), .. } => self.help(format!("did you mean `{name}`?")),
            SetError::Unknown { known, .. } if !known.is_empty() => {
                let known = raxel_diagnostics::names::list(known.iter().map(String::as_str));
                self.help(format!("it has {known}"))
            }
            _ => self,
        }
    }
}

/// The first key that does not fit its param. Further keys of the same track would only repeat it when the type is wrong, and so
/// one is reported for the type, and each for the range.
fn check_track(track: &Track, param: &Param) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let wrong = |key: &Spanned<(f64, Vec<f64>)>, message: String, label: String| {
        Diagnostic::error(codes::session::WRONG_PARAM_VALUE, message)
            .label(key.span.clone(), label)
            .label(param.place.clone(), "declared here")
    };
    for key in &track.keys.values {
        let numbers = &key.value.1;
        let boolean = matches!(param.default, Value::Bool(_));
        let value = params::from_components(numbers, &param.default).filter(|_| boolean == track.keys.boolean);
        let Some(value) = value else {
            let expected = params::type_name(&param.default);
            found.push(wrong(
                key,
                format!("param `{}` is {expected}; this key is none", param.name),
                format!("no {expected}"),
            ));
            break;
        };
        if let Err(error) = params::checked(param, value) {
            found.push(wrong(key, error.to_string(), "outside the range".to_owned()));
        }
    }
    found
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use raxel_diagnostics::disk::MemoryFiles;
    use raxel_diagnostics::{SourceMap, Span};
    use raxel_graph::checked::ResourceId;

    use super::*;
    use crate::{CaptionEdge, read};
    use raxel_execute::moment::{Fraction, Moment};

    const GOOD: &str = r#"
name = "flight"
world = "valley.toml"
graph = "primary.toml"
duration = 8.0
loop = true

[[camera]]
time = 0.0
position = [0.0, 10.0, 0.0]
look_at = [0.0, 10.0, -100.0]

[[camera]]
time = 4
position = [40.0, 10.0, 0.0]
yaw = 350
pitch = -10.0
fov = 179.0

[tracks.exposure]
keys = [[0.0, 1.0], [5.0, 2.0]]

[tracks.bounces]
keys = [[0.0, 1], [4.0, 4]]

[tracks.fog]
keys = [[1.0, true], [2.0, false]]
"#;

    fn graph() -> Graph {
        let place = || Span::new("graphs/primary.toml", 3..9);
        let param = |name: &str, default, range| Param { range, ..Param::new(name, default, place()) };
        Graph {
            name: "primary".into(),
            about: String::new(),
            present: ResourceId(0),
            clocks: Vec::new(),
            params: vec![
                param("exposure", Value::F32(1.0), Some([0.0, 4.0])),
                param("bounces", Value::I32(1), None),
                param("fog", Value::Bool(false), None),
            ],
            resources: Vec::new(),
            loops: Vec::new(),
            passes: Vec::new(),
            materials: Vec::new(),
            files: Vec::new(),
        }
    }

    fn read_text(text: &str) -> Result<Demo, Vec<Diagnostic>> {
        let files = MemoryFiles::new([("worlds/a.demo.toml", text)]);
        read(&files, "worlds/a.demo.toml", &mut SourceMap::default()).map(|(demo, _)| demo)
    }

    /// Checks a demo whose graphs are all the same.
    fn check(demo: &Demo, graph: &Graph) -> Vec<Diagnostic> {
        demo.check(&|_| Some(graph))
    }

    fn codes(found: &[Diagnostic]) -> Vec<&'static str> {
        found.iter().map(|diagnostic| diagnostic.code.as_str()).collect()
    }

    #[test]
    fn a_camera_key_looks_somewhere() {
        let key = |look: &str| {
            format!(
                "world = \"w.toml\"\ngraph = \"g.toml\"\nduration = 2.0\n\
                 [[camera]]\ntime = 0.0\nposition = [1.5, 2.0, 3.0]\n{look}\n"
            )
        };
        let found = read_text(&key("look_at = [1.5, 2, 3]")).unwrap_err();
        assert!(found[0].message.contains("is where the camera is"), "{}", found[0].message);
        assert!(read_text(&key("look_at = [1.5, 2, 3.5]")).is_ok());
        // Straight down and no further.
        assert!(read_text(&key("pitch = -90")).is_ok());
        assert!(read_text(&key("pitch = -90.5")).is_err());
    }

    #[test]
    fn a_demo_is_a_function_of_time() {
        let (demo, graph) = (read_text(GOOD).unwrap(), graph());
        assert_eq!(check(&demo, &graph), []);
        assert_eq!(
            (demo.world.value.as_str(), demo.graph.value.as_str()),
            ("worlds/valley.toml", "graphs/primary.toml")
        );
        assert_eq!(demo.frames(), 240);
        assert!(demo.camera[0].look_at.is_some());
        let at = |time| (demo.params(time, &graph).collect::<Vec<_>>(), demo.camera(time), demo.debug_target(time));
        let value = |name: &str| {
            let id = graph.find_param(name).unwrap();
            at(2.5).0.iter().find(|(param, _)| *param == id).unwrap().1
        };
        assert_eq!(value("exposure"), Value::F32(1.5));
        assert_eq!(value("bounces"), Value::I32(3));
        assert_eq!(value("fog"), Value::Bool(false));
        // It loops, and is the same each time.
        assert_eq!(at(10.5), at(2.5));
        // From straight ahead to 350° is ten degrees to the right, not 350 to the left.
        let camera = demo.camera(2.0).unwrap();
        assert!(camera.yaw.to_degrees() < 0.0 && camera.yaw.to_degrees() > -10.0, "{}", camera.yaw.to_degrees());
        let last = demo.camera(7.0).unwrap();
        assert_eq!((last.cell.x, last.frac.x), (40, 0.0));
        assert!((last.fov.to_degrees() - 179.0).abs() < 1e-9);
    }

    #[test]
    fn every_mistake_of_the_file_is_reported() {
        let text = r#"
world = "../../etc/passwd"
graph = "primary.toml"
duration = 8.0
fsp = 30
[[camera]]
time = 9.0
position = [0, 0]
[[camera]]
time = 1.0
position = [0, 0, 0]
look_at = [1, 2, 3]
yaw = 3
[tracks.exposure]
keys = [[3.0, 1.0], [2.0, 1.0], [4.0]]
interpolation = "smoth"
[[show]]
time = 1.0
target = "a@b"
"#;
        let found = read_text(text).unwrap_err();
        assert_eq!(
            codes(&found),
            ["RX0005", "RX0406", "RX0014", "RX0015", "RX0405", "RX0014", "RX0406", "RX0014", "RX0011"],
            "{found:#?}"
        );
    }

    #[test]
    fn the_graph_is_the_judge_of_names_and_values() {
        let text = GOOD
            .replace("tracks.exposure", "tracks.exposre")
            .replace("[[0.0, 1], [4.0, 4]]", "[[0.0, 1.5], [4.0, 4]]")
            .replace("[[1.0, true], [2.0, false]]", "[[1.0, 0.0], [2.0, 1.0]]");
        let text = format!("{text}\n[[show]]\ntime = 3.0\ntarget = \"depth\"\n");
        let found = check(&read_text(&text).unwrap(), &graph());
        assert_eq!(codes(&found), ["RX0403", "RX0404", "RX0404", "RX0405"]);
        assert_eq!(found[0].help, ["did you mean `exposure`?"]);
        assert_eq!(found[1].labels[1].span, Span::new("graphs/primary.toml", 3..9));
        let outside = check(&read_text(&GOOD.replace("[5.0, 2.0]", "[5.0, 20.0]")).unwrap(), &graph());
        assert_eq!(outside[0].message, "`exposure` is 20; it must be in 0…4");
    }

    #[test]
    fn a_cut_parts_two_curves() {
        let key =
            |time: f64, x: f64, cut: &str| format!("[[camera]]\ntime = {time}\nposition = [{x}, 0.0, 0.0]\n{cut}");
        let text = format!(
            "world = \"w.toml\"\ngraph = \"g.toml\"\nduration = 4.0\n{}{}{}{}",
            key(0.0, 0.0, ""),
            key(1.0, 10.0, ""),
            key(2.0, 100.0, "cut = true\n"),
            key(4.0, 100.0, "")
        );
        let demo = read_text(&text).unwrap();
        let x = |time: f64| demo.camera(time).unwrap().position().x;
        // Neither curve knows of the other: without the cut, the first would swing towards the second.
        assert_eq!([x(0.5), x(1.0), x(1.999), x(2.0), x(3.0)], [5.0, 10.0, 10.0, 100.0, 100.0]);
        assert!(demo.cuts_between(1.9, 2.0) && demo.cuts_between(1.0, 3.0));
        assert!(!demo.cuts_between(2.0, 3.0) && !demo.cuts_between(0.0, 1.9));
    }

    #[test]
    fn graphs_take_turns() {
        let text = format!(
            "{GOOD}[[graphs]]\ntime = 2.0\ngraph = \"other.toml\"\n[[graphs]]\ntime = 6.0\ngraph = \"primary.toml\"\n\
             [[show]]\ntime = 1.0\ntarget = \"near\"\n[[show]]\ntime = 3.0\ntarget = \"far\"\n\
             [[check]]\npass = \"trace\"\nbelow_ms = 1.0\n"
        );
        let demo = read_text(&text).unwrap();
        let at = |time: f64| demo.graph_at(time).value.as_str();
        assert_eq!(
            [at(0.0), at(1.999), at(2.0), at(6.0), at(10.5)],
            [
                "graphs/primary.toml",
                "graphs/primary.toml",
                "graphs/other.toml",
                "graphs/primary.toml",
                "graphs/other.toml"
            ]
        );
        assert_eq!(demo.all_graphs().iter().map(|place| place.value.as_str()).collect::<Vec<_>>(), [at(0.0), at(2.0)]);
        assert!(demo.cuts_between(1.9, 2.0) && !demo.cuts_between(2.0, 5.9) && demo.cuts_between(5.9, 6.1));
        // Another graph begins with its own picture.
        let shown = |time: f64| demo.debug_target(time).map(|target| target.resource.as_str());
        assert_eq!([shown(1.5), shown(2.5), shown(3.5), shown(6.5)], [Some("near"), None, Some("far"), None]);

        // A name is looked for in the graph of its time, and those of no time in all of them.
        let (primary, empty) = (graph(), Graph { params: Vec::new(), ..graph() });
        let found = demo.check(&|path| Some(if path == "graphs/primary.toml" { &primary } else { &empty }));
        assert_eq!(codes(&found), ["RX0405", "RX0405", "RX0420"]);
        assert_eq!(found[1].labels[1].span, demo.graphs[0].graph.span, "the graph at 3 s");
        assert_eq!(found[2].message, "none of the graphs has a pass `trace`");
        let none = demo.check(&|_| Some(&empty));
        assert_eq!(none.iter().filter(|d| d.code == codes::session::UNKNOWN_PARAM).count(), 3);
        // A broken graph brings no further messages.
        assert_eq!(demo.check(&|path| (path == "graphs/primary.toml").then_some(&primary)).len(), 1);
        let late = read_text(&format!("{GOOD}[[graphs]]\ntime = 9.0\ngraph = \"../../a.toml\"\n")).unwrap_err();
        assert_eq!(codes(&late), ["RX0406", "RX0005"]);
    }

    #[test]
    fn keys_take_effect_in_their_frames_in_every_round() {
        let text = "world = \"a.toml\"\ngraph = \"b.toml\"\nduration = 1.4\nloop = true\n\
                    [[caption]]\ntime = 0.7\nuntil = 0.9\ntext = \"here\"\n";
        let demo = read_text(text).unwrap();
        let step = Fraction::of(1.0 / demo.fps);
        assert_eq!((demo.frames(), demo.frame_at(0.7)), (42, 21));
        for frame in 0..42 * 50 {
            let said = demo.caption(Moment::of_frame(frame, step)).is_some();
            assert_eq!(said, (21..27).contains(&(frame % 42)), "frame {frame}");
        }
    }

    #[test]
    fn captions_come_and_go() {
        let text = GOOD.to_owned()
            + "[[caption]]\ntime = 1.0\nuntil = 3.0\ntext = \"one\"\n\
               [[caption]]\ntime = 2.5\nuntil = 4.0\ntext = \"two\"\nplace = \"top\"\n";
        let demo = read_text(&text).unwrap();
        let said = |time: f64| demo.caption(time).map(|line| (line.text.as_str(), line.place == CaptionEdge::Top));
        assert_eq!(
            [said(0.9), said(1.0), said(2.6), said(3.5), said(4.0)],
            [None, Some(("one", false)), Some(("two", true)), Some(("two", true)), None]
        );
        // It loops, and so do they.
        assert_eq!(said(9.0), said(1.0));
    }

    #[test]
    fn every_mistake_in_captions_and_checks_is_reported() {
        let caption = "[[caption]]\ntime = 2.0\nuntil = 1.0\ntext = \"a\"\n\
                       [[caption]]\ntime = 3.0\nuntil = 9.0\ntext = \"\"\nplace = \"left\"\n";
        let check = "[[check]]\nframe = 240\nreference = \"../../a.png\"\nflip = 2.0\n\
                     [[check]]\nflip = 0.1\nreference = \"a.png\"\n\
                     [[check]]\npass = \"p\"\nflip = 0.1\n";
        let found = read_text(&format!("{GOOD}{caption}{check}")).unwrap_err();
        assert_eq!(
            codes(&found),
            ["RX0406", "RX0406", "RX0014", "RX0014", "RX0005", "RX0014", "RX0014", "RX0013", "RX0015", "RX0013"],
            "{found:#?}"
        );
        let good = "[[check]]\nframe = 239\nreference = \"a.png\"\nflip = 0.01\n[[check]]\npass = \"trace\"\nbelow_ms = 3.0\n\
                    [[check]]\ntime = 2.0\ntarget = \"dept\"\nreference = \"b.png\"\nflip = 0.0\n";
        let demo = read_text(&format!("{GOOD}{good}")).unwrap();
        assert!(
            matches!(&demo.checks[0].claim, Claim::Picture { frame, flip, .. } if frame.number() == 239 && *flip == 0.01)
        );
        assert!(
            matches!(&demo.checks[2].claim, Claim::Picture { frame, reference, .. } if frame.number() == 60 && reference.value == "worlds/b.png")
        );
        assert_eq!(demo.checked_times(), [2.0, 239.0 / 30.0]);
        let graph = graph();
        let found = demo.check(&|_| Some(&graph));
        assert_eq!(codes(&found), ["RX0405", "RX0420"]);
    }

    #[test]
    fn broken_files_are_diagnosed() {
        for text in
            ["", "= ", "[[camera", "world = 3", "duration = nan", "camera = 3", "tracks = []", "[tracks.a]\nkeys = []"]
        {
            assert!(!read_text(text).unwrap_err().is_empty(), "{text}");
        }
    }
}
