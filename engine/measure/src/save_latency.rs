//! The time of an edit from the end of the save to the finished picture: `raxel bench reload`.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use raxel_runtime::project::Project;
use raxel_runtime::reload::{Failed, ReloadEvent, Reloaded, Stages};
use raxel_runtime::session::{FrameError, OpenError, Options, Session};
use serde::Serialize;

use crate::Times;

/// The settings of the measurement.
#[derive(Clone)]
pub struct LatencyOptions {
    /// How the session is opened. The project is copied first; nothing in it is written to.
    pub session: Options,
    /// An empty folder for the copy. The caller removes it.
    pub scratch: PathBuf,
    /// Edits of each kind.
    pub edits: usize,
    /// The shader to edit: its project path, or the end of it. Without one, that of the last pass that makes the shown target.
    pub shader: Option<String>,
}

/// The result. Times are from the end of the save to the finished first frame of the new plan.
#[derive(Clone, Debug, Serialize)]
pub struct SaveLatency {
    /// Name of the device.
    pub device: String,
    /// Extent of the output in pixels.
    pub size: [u32; 2],
    /// Project path of the shader that is edited.
    pub shader_path: String,
    /// Its edits: compiled, made a pipeline, run.
    pub shader: Times,
    /// The stages of that time.
    pub stages: ShaderStages,
    /// Edits of its comments: compiled to the module that runs already.
    pub comment: Times,
    /// Edits of the graph that compile no shader.
    pub graph: Times,
}

/// The stages of the time of each edit of a shader, one after the other.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ShaderStages {
    /// Until the edit was seen, and known to be finished. Shaders of files that are whole are compiled meanwhile.
    pub notice: Times,
    /// The rest of compiling and reflecting, the graph checked.
    pub compile: Times,
    /// The graph was planned, and the driver made pipelines of new modules.
    pub plan: Times,
    /// Images, buffers and descriptors were made, and the plan swapped in.
    pub swap: Times,
    /// The first frame, on the device; with the driver's work that waits until a pipeline is used.
    pub frame: Times,
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum LatencyError {
    /// The project does not open.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A frame does not run.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The copy cannot be written.
    #[error("the copy of the project: {0}")]
    Io(#[from] io::Error),
    /// The project has no shader that can be edited this way.
    #[error("no pass of `{graph}` that runs has a shader in GLSL with `void main()`{}", .named.as_ref().map_or_else(String::new, |name| format!(" called `{name}`")))]
    NoShader {
        /// Its project path.
        graph: String,
        /// The requested one.
        named: Option<String>,
    },
    /// An edit that should be right is not.
    #[error("an edit failed: {}", .0.diagnostics.first().map_or("", |diagnostic| diagnostic.message.as_str()))]
    Edit(Box<Failed>),
    /// An edit did not arrive.
    #[error("an edit of `{0}` was not noticed within ten seconds")]
    Unnoticed(String),
}

/// Edits a copy of a project while a session runs it, and measures.
#[expect(clippy::cast_possible_truncation, reason = "any 31 bits that differ from edit to edit will do")]
pub fn save_latency(options: &LatencyOptions) -> Result<SaveLatency, LatencyError> {
    let original = match &options.session.project {
        Some(path) => Project::around(path).or_else(|_| Project::at(path)),
        None => match options.session.demo.as_ref().or(options.session.graph.as_ref()) {
            Some(file) => Project::around_file(file),
            None => Project::around(Path::new(".")),
        },
    };
    let original = original.map_err(OpenError::from)?;
    let relative = |path: &Option<PathBuf>| match path {
        Some(path) => original.path_of(path).map(|path| Some(PathBuf::from(path))),
        None => Ok(None),
    };
    let copy = options.scratch.canonicalize()?;
    for folder in ["graphs", "shaders", "worlds"] {
        let from = original.root().join(folder);
        if from.is_dir() {
            copy_folder(&from, &copy.join(folder))?;
        }
    }
    let session_options = Options {
        project: Some(copy.clone()),
        graph: relative(&options.session.graph).map_err(OpenError::from)?.map(|path| copy.join(path)),
        world: relative(&options.session.world).map_err(OpenError::from)?.map(|path| copy.join(path)),
        demo: relative(&options.session.demo).map_err(OpenError::from)?.map(|path| copy.join(path)),
        watch: true,
        ..options.session.clone()
    };
    let mut session = Session::open(session_options)?;
    finish_frame(&mut session)?;

    let shader_path = editable_shader(&session, &copy, options.shader.as_deref())?;
    let graph_path = session.graph_path().to_owned();
    let shader = fs::read_to_string(copy.join(&shader_path))?;
    let graph = fs::read_to_string(copy.join(&graph_path))?;
    // The first edit of each kind also warms caches of the system; people edit more than once.
    let mut shader_times = Vec::new();
    let mut stages = ShaderStages::default();
    let first = first_constant();
    let mut comment_times = Vec::new();
    let mut graph_times = Vec::new();
    for edit in 0..=options.edits {
        // A constant that no other edit of this or an earlier run has. So the module is new to the driver and its caches, too.
        let constant = first.wrapping_add(edit as u32) | 0x8000_0000;
        let line = format!("void main() {{\n    if (gl_GlobalInvocationID.x == {constant}u) return;");
        let text = shader.replacen(&main_of(&shader).unwrap_or_default(), &line, 1);
        let edited = save_and_wait(&mut session, &copy, &shader_path, &text)?;
        shader_times.push(edited.whole);
        if edit > 0 {
            edited.add_to(&mut stages);
        }
        comment_times.push(save_and_wait(&mut session, &copy, &shader_path, &format!("{text}// {edit}\n"))?.whole);
        let text = format!("{graph}\n[targets.reload_bench]\nformat = \"r32f\"\nsize = [{0}, {0}]\n", edit + 1);
        graph_times.push(save_and_wait(&mut session, &copy, &graph_path, &text)?.whole);
    }
    shader_times.remove(0);
    comment_times.remove(0);
    graph_times.remove(0);
    Ok(SaveLatency {
        device: session.device().capabilities().name.clone(),
        size: session.size(),
        shader_path,
        shader: Times { milliseconds: shader_times },
        stages,
        comment: Times { milliseconds: comment_times },
        graph: Times { milliseconds: graph_times },
    })
}

/// A constant for the first edit that no earlier run has had, for all that matters.
#[expect(clippy::cast_possible_truncation, reason = "any 31 bits that differ from edit to edit will do")]
fn first_constant() -> u32 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    now.as_micros() as u32
}

/// Milliseconds of an edit.
struct Edited {
    /// From the end of the write until the frame with the edit was finished.
    whole: f64,
    /// Of that, from the moment when it was seen until it was swapped in.
    reload: f64,
    stages: Stages,
    /// Of that, the frame.
    frame: f64,
}

impl Edited {
    fn add_to(&self, all: &mut ShaderStages) {
        let Stages { load, plan, .. } = self.stages;
        for (times, milliseconds) in [
            (&mut all.notice, self.whole - self.reload - self.frame),
            (&mut all.compile, load),
            (&mut all.plan, plan),
            (&mut all.swap, self.reload - load - plan),
            (&mut all.frame, self.frame),
        ] {
            times.milliseconds.push(milliseconds);
        }
    }
}

/// Saves a file in place, and waits until the frame with the edit is finished.
fn save_and_wait(session: &mut Session, copy: &Path, path: &str, text: &str) -> Result<Edited, LatencyError> {
    fs::write(copy.join(path), text)?;
    let saved = Instant::now();
    loop {
        let events = session.wait_reload(Duration::from_secs(10));
        if events.is_empty() {
            return Err(LatencyError::Unnoticed(path.to_owned()));
        }
        for event in events {
            match event {
                ReloadEvent::Reloaded(Reloaded { milliseconds, stages, .. }) => {
                    let swapped = Instant::now();
                    finish_frame(session)?;
                    let [whole, frame] = [saved, swapped].map(|start| start.elapsed().as_secs_f64() * 1e3);
                    return Ok(Edited { whole, reload: milliseconds, stages, frame });
                }
                ReloadEvent::Failed(failed) => return Err(LatencyError::Edit(Box::new(failed))),
                ReloadEvent::HistoryCleared { .. }
                | ReloadEvent::DeviceRebuilt { .. }
                | ReloadEvent::NotOpened(_)
                | ReloadEvent::Opened => {}
            }
        }
    }
}

/// Runs a frame and waits until the device has finished it.
fn finish_frame(session: &mut Session) -> Result<(), FrameError> {
    session.frame()?;
    session.wait()
}

/// The shader of the last live pass that can be edited, and is called so.
fn editable_shader(session: &Session, copy: &Path, named: Option<&str>) -> Result<String, LatencyError> {
    let plan = session.plan();
    let paths =
        plan.iter().flat_map(|plan| plan.passes.iter().map(|pass| &plan.graph.pass(pass.pass).shader.request.path));
    let called = |path: &&String| {
        named.is_none_or(|name| path.strip_suffix(name).is_some_and(|rest| rest.is_empty() || rest.ends_with('/')))
    };
    paths
        .rev()
        .filter(called)
        .find(|path| fs::read_to_string(copy.join(path)).is_ok_and(|text| main_of(&text).is_some()))
        .cloned()
        .ok_or_else(|| LatencyError::NoShader {
            graph: session.graph_path().to_owned(),
            named: named.map(str::to_owned),
        })
}

/// `void main() {`, as this shader writes it.
fn main_of(text: &str) -> Option<String> {
    let start = text.find("void main")?;
    let end = text[start..].find('{')?;
    Some(text[start..=start + end].to_owned())
}

fn copy_folder(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (kind, to) = (entry.file_type()?, to.join(entry.file_name()));
        if kind.is_dir() {
            copy_folder(&entry.path(), &to)?;
        } else if kind.is_file() {
            fs::copy(entry.path(), to)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn main_is_found_however_it_is_written() {
        assert_eq!(main_of("x\nvoid main( void )\n{ }").unwrap(), "void main( void )\n{");
        assert_eq!(main_of("void mian() {}"), None);
    }
}
