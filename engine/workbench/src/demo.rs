//! The demo that a session plays: its tracks and keys, its end, and changes of its file.

use std::fmt;
use std::str::FromStr;

use raxel_execute::moment::Moment;
use raxel_runtime::Session;
use raxel_runtime::camera::Camera;
use raxel_runtime::reload::ProjectFile;
use raxel_runtime::timeline::Demo;

use super::write_back::{self, Written};

/// The target of a demo's track. Its text is the key of the file: `camera`, `tracks.fog`, `inputs.cursor`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lane {
    /// The camera.
    Camera,
    /// The param of that name.
    Param(String),
    /// The graph.
    Graphs,
    /// The debug target.
    Show,
    /// The world.
    Edits,
    /// Lines of text over the picture.
    Captions,
    /// The checks of pictures.
    Checks,
    /// The input of that name.
    Input(String),
}

/// The lanes that have no name of their own, by their keys in the file.
const PLAIN: [(&str, Lane); 6] = [
    ("camera", Lane::Camera),
    ("graphs", Lane::Graphs),
    ("show", Lane::Show),
    ("edits", Lane::Edits),
    ("caption", Lane::Captions),
    ("check", Lane::Checks),
];

impl Lane {
    /// Whether its keys can be moved and deleted. The target of a check belongs to its reference, and a press to its release.
    pub fn movable(&self) -> bool {
        !matches!(self, Lane::Checks | Lane::Input(_))
    }

    /// The key of the file under which its keys stand.
    pub(crate) fn array(&self) -> &'static str {
        match self {
            Lane::Param(_) => "tracks",
            Lane::Input(_) => "inputs",
            plain => PLAIN.iter().find(|(_, lane)| lane == plain).map_or("", |(key, _)| key),
        }
    }
}

impl fmt::Display for Lane {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Lane::Param(name) | Lane::Input(name) => write!(f, "{}.{name}", self.array()),
            plain => f.write_str(plain.array()),
        }
    }
}

impl FromStr for Lane {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((_, lane)) = PLAIN.iter().find(|(key, _)| *key == text) {
            return Ok(lane.clone());
        }
        match text.split_once('.') {
            Some(("tracks", name)) => Ok(Lane::Param(name.to_owned())),
            Some(("inputs", name)) => Ok(Lane::Input(name.to_owned())),
            _ => Err(format!(
                "`{text}` is no track of a demo: they are `camera`, `graphs`, `show`, `edits`, `caption`, `check`, `tracks.PARAM` and `inputs.NAME`"
            )),
        }
    }
}

/// The lanes of a demo that have keys, with the seconds of each key in order.
pub fn lanes(demo: &Demo) -> Vec<(Lane, Vec<f64>)> {
    let mut lanes = vec![(Lane::Camera, demo.camera.iter().map(|key| key.time.value).collect())];
    lanes.extend(demo.tracks.iter().map(|driven| {
        let times = driven.keys.values.iter().map(|key| key.value.0).collect();
        (Lane::Param(driven.param.value.clone()), times)
    }));
    lanes.push((Lane::Graphs, demo.graphs.iter().map(|key| key.time.value).collect()));
    lanes.push((Lane::Show, demo.shows.iter().map(|key| key.time.value).collect()));
    lanes.push((Lane::Edits, demo.edits.iter().map(|key| key.time.value).collect()));
    lanes.push((Lane::Captions, demo.captions.iter().map(|caption| caption.time.value).collect()));
    lanes.push((Lane::Checks, demo.checked_times()));
    let inputs = demo.inputs.iter().flat_map(raxel_runtime::timeline::DemoInputs::times);
    lanes.extend(inputs.map(|(name, times)| (Lane::Input(name.to_owned()), times)));
    lanes.retain(|(_, times)| !times.is_empty());
    lanes
}

/// Seconds into the demo that a session plays, or of its clock.
pub fn seconds(session: &Session) -> f64 {
    let now = session.clock().now().map_or(Moment::START, |now| now.time);
    session.demo().map_or(now.seconds(), |demo| demo.local_time(now))
}

/// At the end of the demo: starts it over or stays there, as was chosen. Without a choice, the demo decides.
pub fn turn(session: &mut Session, looped: Option<bool>) {
    let (Some(looped), Some(duration)) = (looped, session.demo().map(|demo| demo.duration)) else { return };
    let ended = session.clock().now().is_some_and(|now| now.time >= Moment::from(duration));
    if ended && looped {
        session.seek(0.0);
    } else if ended && !session.clock().paused() {
        session.seek(duration * (1.0 - 1e-9));
        session.pause(true);
    }
}

/// Goes on without the demo where its file is gone: undo has taken back that it was made.
pub fn leave_if_gone(session: &mut Session) {
    let project = session.project();
    if session.demo().is_some_and(|demo| !project.on_disk(&demo.file).exists()) {
        let graph = session.graph_path().to_owned();
        session.open_file(ProjectFile::Graph(graph));
    }
}

/// A change of a demo's file.
#[derive(Clone, Debug, PartialEq)]
pub struct Changed {
    /// Project path of the file.
    pub file: String,
    /// What was written; `None` when the text stays as it is.
    pub written: Option<Written>,
}

/// Changes the text of the file of the demo that a session plays, given the text, the time in seconds and the camera. `None` if it plays none.
///
/// # Errors
/// Why the file is not changed, in one line.
pub fn change(
    session: &Session,
    change: impl FnOnce(&str, f64, &Camera) -> Result<String, String>,
) -> Option<Result<Changed, String>> {
    let file = session.demo()?.file.clone();
    let (time, camera) = (seconds(session), *session.camera());
    let edited = write_back::edit(session.project(), &file, |text| change(text, time, &camera));
    Some(edited.map(|written| Changed { file, written }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lane_has_the_text_of_its_key() {
        let named = [Lane::Param("fog".to_owned()), Lane::Input("cursor".to_owned())];
        for lane in PLAIN.into_iter().map(|(_, lane)| lane).chain(named) {
            assert_eq!(lane.to_string().parse(), Ok(lane));
        }
        for wrong in ["", "fog", "track.fog", "cameras"] {
            assert!(wrong.parse::<Lane>().is_err_and(|error| error.contains("`tracks.PARAM`")), "{wrong}");
        }
    }
}
