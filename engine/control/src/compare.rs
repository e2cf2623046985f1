//! Requests that compare what is shown with a picture that is kept.

use std::path::Path;
use std::sync::Arc;

use raxel_execute::{ReadTicket, Texels};
use raxel_runtime::Session;
use raxel_runtime::debug_target::DebugTarget;
use raxel_workbench::display;
use raxel_workbench::kept::{Figures, Kept, Pixels, VALUES, What};
use serde_json::{Value, json};

use super::host::Host;
use super::later::Later;
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

/// What is to be kept: what is shown, a file, or a target as it goes on.
/// The thread that reads a file has a clone of `reading`.
pub(super) fn keep(session: &mut Session, wanted: &ToKeep, reading: &Arc<()>) -> Result<Later<Kept>, Refusal> {
    match (&wanted.path, &wanted.target) {
        (Some(path), None) => {
            let (file, name) = (session.project().root().join(Path::new(path)), path.clone());
            let reading = reading.clone();
            Ok(Later::beside(move || {
                let kept = Kept::read(&file, &name).map_err(Refusal::new);
                drop(reading);
                kept
            }))
        }
        (None, Some(text)) => {
            let target = DebugTarget::parse(text)?;
            if target.after.is_some() {
                return Err(Refusal::new(format!("`{target}` is not what the frame ends with")));
            }
            target.resolve(session.graph())?;
            Ok(Later::beside(|| Ok(Kept::live(target))))
        }
        (None, None) => {
            let (target, ticket) = shown(session)?;
            let name = target.to_string();
            Ok(Later::of_one(ticket, move |texels| Ok(Kept::copy(&name, texels))))
        }
        (Some(_), Some(_)) => Err(Refusal::new("`path` and `target` exclude each other")),
    }
}

/// Measures how far the shown target is from the kept picture.
pub(super) fn measure(host: &mut dyn Host) -> Result<Later<Value>, Refusal> {
    let kept = host.kept().cloned().ok_or_else(|| {
        let help = vec!["`keep` keeps the shown picture, a file or another target".to_owned()];
        Refusal { error: "no picture is kept".to_owned(), help }
    })?;
    let session = host.session();
    let (target, shown) = shown(session)?;
    let mut tickets = vec![shown];
    let (still, shown_by) = match kept.what {
        What::Still(pixels) => {
            (Some(pixels), session.display().or_else(|| display::of_graph(session)).unwrap_or(VALUES))
        }
        What::Live(live) => {
            tickets.push(session.request_texels(&live.resource, live.age, live.mip, live.layer)?);
            (None, VALUES)
        }
    };
    Ok(Later::of(tickets, move |texels| {
        let mut texels = texels.into_iter();
        let (shown, live) = (texels.next(), texels.next());
        let pixels = still.or_else(|| live.map(|live| Pixels::Texels(live.into())));
        let (shown, pixels) = shown.zip(pixels).ok_or_else(|| Refusal::new("nothing was copied"))?;
        let figures = pixels.figures(&shown, &shown_by).map_err(Refusal::new)?;
        Ok(described(&target, &kept.name, figures))
    }))
}

fn described(of: &DebugTarget, kept: &str, figures: Figures) -> Value {
    let Figures { flip, rmse, max, differing, pixels } = figures;
    json!({
        "of": of.to_string(), "kept": kept, "flip": read::float(flip), "rmse": read::float(rmse), "max": read::float(max),
        "differing": differing, "pixels": pixels,
    })
}

/// The shown target, and a copy of its texels at the end of the last frame.
fn shown(session: &mut Session) -> Result<(DebugTarget, ReadTicket<Texels>), Refusal> {
    let target = session.debug_target().clone();
    if target.after.is_some() {
        return Err(Refusal::new(format!("`{target}` is not what the frame ends with")));
    }
    let target = DebugTarget { resource: display::shown_resource(session).to_owned(), ..target };
    let ticket = session.request_texels(&target.resource, target.age, target.mip, target.layer)?;
    Ok((target, ticket))
}
