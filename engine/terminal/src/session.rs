//! Opening a session for the command line, and the exit codes of its errors.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use raxel_diagnostics::{codes, names};
use raxel_gpu::{Device, DeviceOptions, Severity};
use raxel_runtime::camera::Camera;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::manifest::Manifest;
use raxel_runtime::project::Project;
use raxel_runtime::timeline::Demo;
use raxel_runtime::world::SessionWorld;
use raxel_runtime::{FrameError, Observe, OpenError, Options, ReadError, Session};
use raxel_worldfile::CAMERA_COORDINATES;

use crate::console::{Console, Format, To};
use crate::failure::{Exit, Failure, Result};
use crate::offline::{FileKind, OfflineProject};
use crate::prints::print_prints;

/// The files that `run` and `render` open.
#[derive(Clone, Debug, clap::Args)]
pub struct What {
    /// A graph, a demo (*.demo.toml) or a world; the project's demo or graph by default.
    #[arg(value_name = "GRAPH|DEMO|WORLD")]
    pub file: Option<PathBuf>,

    /// The world; the demo's, or the project's by default.
    #[arg(long, value_name = "WORLD")]
    pub world: Option<PathBuf>,

    /// The debug target: NAME, or NAME@1 (a frame ago), followed by any of `,mip=2` `,layer=3` `,after=PASS`.
    #[arg(long, value_name = "TARGET")]
    pub target: Option<String>,

    /// Take the debug target right after this pass. For a pass in a loop: after its last round, or after round 2 with PASS[2].
    #[allow(rustdoc::broken_intra_doc_links, reason = "`--help` shows this text as it is")]
    #[arg(long, value_name = "PASS")]
    pub after: Option<String>,

    /// Set a param; may be repeated.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,

    /// The camera.
    #[command(flatten)]
    pub eye: Eye,

    /// Check each access of a shader to arrays and images, and report those out of bounds with file and line. The passes become slower.
    #[arg(long)]
    pub check_bounds: bool,

    /// Seconds without a finished pass after which a frame counts as hung, and is given up; six times as many on a software device, where
    /// Linux counts processor time.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    pub watchdog: Duration,
}

/// A camera of the command line.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub struct Eye {
    /// Where the camera is, in voxels; or one of the world's cameras by name.
    #[arg(long, value_name = "NAME|X,Y,Z", value_parser = viewpoint, allow_hyphen_values = true)]
    pub camera: Option<Viewpoint>,

    /// The point that the camera looks at, in voxels.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub look_at: Option<Triple>,
}

impl Eye {
    /// Whether no option of a camera is given.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The requested camera, in a world; the other properties stay as in `camera`.
    pub fn of(&self, mut camera: Camera, world: &SessionWorld) -> Result<Camera> {
        match &self.camera {
            Some(Viewpoint::Position(Triple(position))) => {
                camera = Camera { yaw: camera.yaw, pitch: camera.pitch, fov: camera.fov, ..Camera::at(*position) };
            }
            Some(Viewpoint::Named(name)) => camera = named_camera(world, name)?,
            None => {}
        }
        if let Some(Triple(target)) = self.look_at {
            if camera.is_at(target) {
                let [x, y, z] = target;
                let message = format!("`--look-at {x},{y},{z}` is where the camera is: it has no direction");
                return Err(Failure::usage(message).help("--camera X,Y,Z puts it elsewhere"));
            }
            camera.look_at(target);
        }
        Ok(camera)
    }
}

/// Reads a number of seconds such as `2.5`.
pub fn seconds(text: &str) -> std::result::Result<Duration, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| (0.001..=86400.0).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| "a number of seconds from 0.001 to 86400".to_owned())
}

/// A position in voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple([f64; 3]);

fn triple(text: &str) -> std::result::Result<Triple, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|n| n.trim().parse().ok().filter(|n: &f64| n.is_finite())).collect();
    let numbers: [f64; 3] =
        (numbers.and_then(|n| n.try_into().ok())).ok_or_else(|| "write three numbers, e.g. 10,24.5,-3".to_owned())?;
    match numbers.iter().find(|n| !CAMERA_COORDINATES.contains(n)) {
        Some(n) => Err(format!(
            "{n:?} is out of range; it must be in {}…{}",
            CAMERA_COORDINATES.start(),
            CAMERA_COORDINATES.end()
        )),
        None => Ok(Triple(numbers)),
    }
}

/// Where a camera is put.
#[derive(Clone, Debug, PartialEq)]
pub enum Viewpoint {
    /// In voxels.
    Position(Triple),
    /// A camera of the world's file.
    Named(String),
}

fn viewpoint(text: &str) -> std::result::Result<Viewpoint, String> {
    // A name has no comma: `nan,0,0` is meant as a place.
    if text.starts_with(|c: char| c.is_alphabetic() || c == '_') && !text.contains(',') {
        return Ok(Viewpoint::Named(text.to_owned()));
    }
    triple(text).map(Viewpoint::Position).map_err(|error| format!("{error}, or the name of a camera of the world"))
}

/// The camera of that name, or a failure that lists the existing ones.
pub fn named_camera(world: &SessionWorld, name: &str) -> Result<Camera> {
    world.camera(name).ok_or_else(|| {
        let whose = world.path.as_deref().unwrap_or("the empty world");
        let failure = Failure::usage(format!("`{whose}` has no camera `{name}`"));
        match names::closest(name, world.camera_names()) {
            Some(close) => failure.help(format!("did you mean `{close}`?")),
            None if world.camera_names().next().is_none() => failure.help("[cameras.NAME] in its file makes one"),
            None => failure.help(format!("it has {}", names::list(world.camera_names()))),
        }
    })
}

impl What {
    /// The same with the demo of the project's manifest where no file and no world is named, and the rest of the manifest.
    pub fn in_project(&self, console: &Console) -> Result<(Self, Manifest)> {
        let named = self.file.as_deref().or(self.world.as_deref());
        let project = named.map_or_else(|| Project::around(Path::new(".")), Project::around_file);
        // Opening it reports the mistakes.
        let Ok(project) = project else { return Ok((self.clone(), Manifest::default())) };
        let manifest = project.manifest().map_err(|(found, texts)| console.stop_in(&found, &texts))?;
        let demo = manifest.demo.as_ref().filter(|_| named.is_none()).map(|demo| project.on_disk(demo));
        Ok((Self { file: demo.or_else(|| self.file.clone()), ..self.clone() }, manifest))
    }

    /// The file, if it is of this kind.
    fn file(&self, kind: FileKind) -> Option<PathBuf> {
        self.file.clone().filter(|file| FileKind::of_named(file) == kind)
    }

    /// The options of a session, with those that are the same for a window and a picture.
    pub fn options(&self, device: &DeviceOptions) -> Result<Options> {
        let world = match (self.file(FileKind::World), &self.world) {
            (Some(_), Some(_)) => return Err(Failure::usage("two worlds are named")),
            (Some(world), None) => Some(world),
            (None, world) => world.clone(),
        };
        let (graph, demo) = (self.file(FileKind::Graph), self.file(FileKind::Demo));
        // Of a world alone its project is known, too.
        let project = match (&graph, &demo, &world) {
            (None, None, Some(world)) => world.parent().filter(|folder| folder.is_dir()).map(Path::to_owned),
            _ => None,
        };
        Ok(Options {
            project,
            graph,
            demo,
            world,
            debug_target: self.debug_target()?,
            device: device.device.clone(),
            validation: device.validation,
            watchdog: self.watchdog,
            observe: Observe::Shown,
            check_bounds: self.check_bounds,
            ..Options::default()
        })
    }

    /// The resource to show.
    pub fn debug_target(&self) -> Result<DebugTarget> {
        // A colon may stand for the first comma: `depth:mip=1`.
        let text = self.target.as_deref().map(|target| target.replacen(':', ",", 1));
        let mut target = match text {
            Some(text) => DebugTarget::parse(&text).map_err(|error| Failure::usage(error.to_string()))?,
            None => DebugTarget::default(),
        };
        if self.after.is_some() {
            target.after.clone_from(&self.after);
        }
        Ok(target)
    }

    /// Whether the file that is named is a demo.
    pub fn is_demo(&self) -> bool {
        self.file(FileKind::Demo).is_some()
    }

    /// The demo, if there is one. Its errors are not reported here: opening does that.
    pub fn demo(&self) -> Option<Arc<Demo>> {
        let file = self.file(FileKind::Demo)?;
        let offline = OfflineProject::around(&file).ok()?;
        offline.loader.demo(&offline.project.path_of(&file).ok()?).result.ok()
    }

    /// Opens a session, prints its warnings and the chosen device, and sets params and camera.
    pub fn open(&self, options: Options, console: &Console) -> Result<Session> {
        let mut session = Session::open(options).map_err(|error| open_failure(error, console))?;
        self.set_up(&mut session, console)?;
        Ok(session)
    }

    /// Says the warnings of a session and the device that was chosen, and sets params and camera.
    pub fn set_up(&self, session: &mut Session, console: &Console) -> Result {
        for verdict in session.device().verdicts().iter().filter(|verdict| verdict.chosen || console.verbose()) {
            console.detail(&verdict.to_string());
        }
        console.diagnostics(session.warnings(), session.texts(), To::Stderr);
        for assignment in &self.set {
            let (name, value) = assigned("--set", assignment)?;
            session
                .set_param_text(name, value)
                .map_err(|error| Failure::usage(format!("`--set {assignment}`: {error}")))?;
        }
        if !self.eye.is_empty() {
            session.take_over();
            let camera = self.eye.of(*session.camera(), session.world())?;
            session.set_camera(camera);
        }
        Ok(())
    }
}

/// Name and value of an option such as `--set name=value`.
pub fn assigned<'t>(option: &str, text: &'t str) -> Result<(&'t str, &'t str)> {
    let parts = text.split_once('=').map(|(name, value)| (name.trim(), value.trim()));
    parts.ok_or_else(|| Failure::usage(format!("`{option} {text}` has no `=`")).help(format!("{option} name=value")))
}

/// The failure of opening, its diagnostics shown.
pub fn open_failure(error: OpenError, console: &Console) -> Failure {
    match error {
        OpenError::Project { diagnostics, texts } => console.stop_in(&diagnostics, &texts),
        OpenError::DebugTarget(error) => Failure::usage(error.to_string()),
        OpenError::Device(error) => error.into(),
    }
}

/// The failure of a frame, its diagnostics shown.
pub fn frame_failure(error: FrameError, console: &Console) -> Failure {
    match error {
        FrameError::Plan { diagnostics, texts } => console.stop_in(&diagnostics, &texts),
        FrameError::Device(error) => error.into(),
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Unknown(error) => Failure::usage(error.to_string()),
            ReadError::Execute(error) => error.into(),
        }
    }
}

/// Prints the messages of a session since the last call: about its world, its save, prints and counts of its passes, failed assertions of
/// its shaders, and accesses out of bounds.
///
/// # Errors
/// When an assertion has failed, or an access was out of bounds.
pub fn print_messages(session: &mut Session, console: &Console) -> Result {
    print_prints(session, console);
    let said = session.take_messages();
    console.diagnostics(&said, session.texts(), To::Stderr);
    let failures = [codes::session::ASSERTION_FAILED, codes::session::OUT_OF_BOUNDS];
    let failed = said.iter().any(|message| failures.contains(&message.code));
    if failed { Err(Failure::printed(Exit::Check)) } else { Ok(()) }
}

/// Prints the messages of the validation layer since the last call. True when there were any.
pub fn print_validation(session: &Session, console: &Console) -> bool {
    print_log(session.device(), console)
}

/// The same of a device without a session.
pub fn print_log(device: &Device, console: &Console) -> bool {
    let messages = device.log().take();
    for message in &messages {
        let severity = match message.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        match console.format() {
            Format::Human => console.message(&format!("validation {severity}[{}]: {}", message.id, message.text)),
            _ => {
                console.message(&format!("validation {severity}[{}]: {}", message.id, message.text.replace('\n', " ")));
            }
        }
    }
    !messages.is_empty()
}

/// The failure of a session that the validation layer complained about.
pub fn validated(complaints: bool) -> Result {
    if complaints {
        Err(Failure::new(Exit::Validation, "the validation layer has complained; see above"))
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triples() {
        assert_eq!(triple("1, -2.5,3e2"), Ok(Triple([1.0, -2.5, 300.0])));
        // As the files of worlds and demos have it.
        assert!(triple("1e300,0,0").is_err_and(|error| error.contains("it must be in -2147483648…2147483648")));
        assert!(triple("0,-2147483648,2147483648").is_ok());
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "nan,1,2", "river,1,2"] {
            assert!(triple(wrong).is_err() && viewpoint(wrong).is_err(), "{wrong}");
        }
        assert_eq!(viewpoint("-1,2,3"), Ok(Viewpoint::Position(Triple([-1.0, 2.0, 3.0]))));
        assert_eq!(viewpoint("ground"), Ok(Viewpoint::Named("ground".to_owned())));
    }
}
