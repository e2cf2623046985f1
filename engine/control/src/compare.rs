//! Requests that compare what is shown with a picture that is kept.

use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::thread;

use raxel_execute::Texels;
use raxel_runtime::Session;
use raxel_runtime::debug_target::DebugTarget;
use raxel_workbench::display;
use raxel_workbench::kept::{Figures, Kept, Pixels, VALUES, What};
use serde_json::{Value, json};

use super::host::Host;
use super::read;
use super::refusal::Refusal;

/// What to keep.
#[derive(Clone, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ToKeep {
    /// The picture in a file.
    pub path: Option<String>,
    /// A target as it goes on.
    pub target: Option<String>,
}

/// Keeps what is shown, a file, or a target as it goes on.
pub(super) fn keep(host: &mut dyn Host, wanted: &ToKeep) -> Result<Value, Refusal> {
    let session = host.session();
    let kept = match (&wanted.path, &wanted.target) {
        (Some(path), None) => {
            let file = session.project().root().join(Path::new(path));
            // To read a pipe would wait for its writer.
            if std::fs::metadata(&file).is_ok_and(|found| !found.is_file()) {
                return Err(Refusal::new(format!("`{path}` cannot be read: it is not a file")));
            }
            Kept::read(&file, path).map_err(Refusal::new)?
        }
        (None, Some(text)) => {
            let target = DebugTarget::parse(text)?;
            if target.after.is_some() {
                return Err(Refusal::new(format!("`{target}` is not what the frame ends with")));
            }
            target.resolve(session.graph())?;
            Kept::live(target)
        }
        (None, None) => {
            let (target, texels) = shown(session)?;
            Kept::copy(&target.to_string(), texels)
        }
        (Some(_), Some(_)) => return Err(Refusal::new("`path` and `target` exclude each other")),
    };
    let answer = json!({ "kept": kept.name });
    host.keep(Some(kept));
    Ok(answer)
}

/// Measures how far the shown target is from the kept picture, on another thread.
pub(super) fn measure(host: &mut dyn Host) -> Result<Receiver<Result<Value, Refusal>>, Refusal> {
    let kept = host.kept().cloned().ok_or_else(|| {
        let help = vec!["`keep` keeps the shown picture, a file or another target".to_owned()];
        Refusal { error: "no picture is kept".to_owned(), help }
    })?;
    let session = host.session();
    let (target, texels) = shown(session)?;
    let (pixels, shown_by) = match kept.what {
        What::Still(pixels) => (pixels, session.display().or_else(|| display::of_graph(session)).unwrap_or(VALUES)),
        What::Live(live) => {
            let live = session.read_texels(&live.resource, live.age, live.mip, live.layer)?;
            (Pixels::Texels(live.into()), VALUES)
        }
    };
    let (send, receive) = channel();
    thread::spawn(move || {
        let figures = pixels.figures(&texels, &shown_by).map_err(Refusal::new);
        // A program that has gone does not wait for it.
        let _ = send.send(figures.map(|figures| described(&target, &kept.name, figures)));
    });
    Ok(receive)
}

fn described(of: &DebugTarget, kept: &str, figures: Figures) -> Value {
    let Figures { flip, rmse, max, differing, pixels } = figures;
    json!({
        "of": of.to_string(), "kept": kept, "flip": read::float(flip), "rmse": read::float(rmse), "max": read::float(max),
        "differing": differing, "pixels": pixels,
    })
}

/// The shown target with its texels at the end of the last frame.
fn shown(session: &mut Session) -> Result<(DebugTarget, Texels), Refusal> {
    let target = session.debug_target().clone();
    if target.after.is_some() {
        return Err(Refusal::new(format!("`{target}` is not what the frame ends with")));
    }
    let target = DebugTarget { resource: display::shown_resource(session).to_owned(), ..target };
    let texels = session.read_texels(&target.resource, target.age, target.mip, target.layer)?;
    Ok((target, texels))
}
