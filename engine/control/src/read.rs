//! Reads the results of frames: pictures, texels, bytes of buffers.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use data_encoding::BASE64;
use raxel_execute::{Captured, Texels};
use raxel_graph::plan::Present;
use raxel_output::{Coding, Compression, Output, Pending, Shot};
use raxel_runtime::Session;
use raxel_runtime::debug_target::DebugTarget;
use raxel_shader::interface::ScalarKind;
use serde_json::{Value, json};

use super::later::Later;
use super::refusal::Refusal;

/// The output right after a pass of the last frame.
#[derive(Clone)]
pub(super) struct Middle {
    of: Present,
    texels: Arc<Texels>,
}

/// The copy that the last frame took.
pub(super) fn shown_in_the_middle(session: &mut Session) -> Option<Middle> {
    let copy = session.captured()?.poll().ok().flatten()?;
    let of = session.debug_target().resolve(session.graph()).ok()?;
    match copy {
        Captured::Texels(texels) if of.after.is_some() => Some(Middle { of, texels }),
        _ => None,
    }
}

/// The picture of the last frame.
pub(super) fn picture(session: &mut Session, path: Option<String>) -> Result<Later<Value>, Refusal> {
    let ticket = session.request_picture()?;
    Ok(Later::of_one(ticket, move |picture| {
        let about = json!({ "width": picture.width, "height": picture.height, "channels": 4, "type": "u1" });
        give(about, &picture.rgba, path.as_deref())
    }))
}

/// All texels of a target as numbers.
pub(super) fn texels(
    session: &mut Session,
    target: &DebugTarget,
    middle: Option<&Middle>,
    path: Option<String>,
) -> Result<Later<Value>, Refusal> {
    of_texels(session, target, middle, move |texels| {
        let (kind, bytes) = numbers(&texels);
        let about = json!({
            "width": texels.width, "height": texels.height, "channels": texels.format.channels(), "type": kind,
            "format": texels.format.name(),
        });
        give(about, &bytes, path.as_deref())
    })
}

/// Bytes of a buffer.
pub(super) fn buffer(
    session: &mut Session,
    name: &str,
    range: Range<u64>,
    path: Option<String>,
) -> Result<Later<Value>, Refusal> {
    let ticket = session.request_buffer(name, range)?;
    Ok(Later::of_one(ticket, move |bytes: Vec<u8>| give(json!({ "bytes": bytes.len() }), &bytes, path.as_deref())))
}

/// The file that a program wants bytes in. It must not be a pipe or a device: a program that waits for the answer does not read them.
fn file(path: &str) -> Result<Pending, Refusal> {
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Err(Refusal::new(format!("`{path}` cannot be written: it is no regular file")));
    }
    Ok(Pending::new(Path::new(path))?)
}

/// An answer with bytes: as base64 in it, or in a file.
fn give(mut about: Value, bytes: &[u8], path: Option<&str>) -> Result<Value, Refusal> {
    match path {
        Some(path) => file(path)?.finish(bytes)?,
        None => about["data"] = BASE64.encode(bytes).into(),
    }
    Ok(about)
}

/// One texel of a target.
pub(super) fn pixel(
    session: &mut Session,
    target: &DebugTarget,
    [x, y]: [u32; 2],
    middle: Option<&Middle>,
) -> Result<Later<Value>, Refusal> {
    let name = target.to_string();
    of_texels(session, target, middle, move |texels| {
        if x >= texels.width || y >= texels.height {
            let (width, height) = (texels.width, texels.height);
            return Err(Refusal::new(format!("`{name}` has {width}×{height} texels; there is none at {x}, {y}")));
        }
        Ok(values(&texels, [x, y]))
    })
}

/// The values of a texel that is inside, and their bits. It looks at no other texel: a target may have millions.
pub(super) fn values(texels: &Texels, at: [u32; 2]) -> Value {
    let floats = || texels.texel(at).map(|(floats, _)| floats.map(f32::to_bits));
    let words = texels.integer(at).or_else(floats).unwrap_or_default();
    let bits = &words[..texels.format.channels() as usize];
    let values: Vec<Value> = bits.iter().map(|bits| number(kind(texels), *bits)).collect();
    json!({ "format": texels.format.name(), "values": values, "bits": bits })
}

/// Something that is made of the texels at the end of the last frame, or right after a pass of it.
pub(super) fn of_texels<T: Send + 'static>(
    session: &mut Session,
    target: &DebugTarget,
    middle: Option<&Middle>,
    make: impl FnOnce(Arc<Texels>) -> Result<T, Refusal> + Send + 'static,
) -> Result<Later<T>, Refusal> {
    if target.after.is_none() {
        let ticket = session.request_texels(&target.resource, target.age, target.mip, target.layer)?;
        return Ok(Later::of_one(ticket, move |texels: Texels| make(texels.into())));
    }
    let wanted = target.resolve(session.graph())?;
    match middle.filter(|middle| middle.of == wanted) {
        Some(middle) => {
            let texels = middle.texels.clone();
            Ok(Later::beside(move || make(texels)))
        }
        None => Err(Refusal {
            error: format!("the last frame has no copy of `{target}`"),
            help: vec![format!(
                "choose it with `target`, \"{target}\", and run a frame with `step`; a window takes no copies"
            )],
        }),
    }
}

/// Writes the picture of the last frame to a file.
pub(super) fn screenshot(session: &mut Session, path: String) -> Result<Later<Value>, Refusal> {
    let Output::Single(kind, file) = Output::parse(&path, None)? else {
        return Err(Refusal::new(format!("`{path}` names no single picture")));
    };
    let named = path.clone();
    let write = move |shot: Shot| {
        let pending = Pending::new(&file)?;
        let size = shot.size();
        let coding = Coding { kind, compression: Compression::default(), quality: 90 };
        pending.finish(&coding.encode(shot)?)?;
        Ok(json!({ "path": Path::new(&path), "size": size, "kind": kind.extension() }))
    };
    if !kind.wants_texels() {
        let ticket = session.request_picture()?;
        return Ok(Later::of_one(ticket, move |picture| write(Shot::Picture(picture))));
    }
    let graph = session.graph();
    let target = session.debug_target();
    if target.after.is_some() {
        // The frame has run: the output within it is gone.
        let message =
            format!("`{target}` is not what the frame ends with, and `{named}` takes texels as they are at the end");
        let help = vec!["a .png has the picture as it was shown; a target without `after` has texels".to_owned()];
        return Err(Refusal { error: message, help });
    }
    let (age, mip, layer) = (target.age, target.mip, target.layer);
    let shown = if target.resource.is_empty() { &graph.resource(graph.present).name } else { &target.resource };
    let name = shown.clone();
    let ticket = session.request_texels(&name, age, mip, layer)?;
    Ok(Later::of_one(ticket, move |texels| write(Shot::Texels(vec![(name, texels)]))))
}

/// The type of the numbers of texels.
fn kind(texels: &Texels) -> &'static str {
    match texels.scalar() {
        ScalarKind::Uint => "u4",
        ScalarKind::Int => "i4",
        ScalarKind::Float => "f4",
    }
}

/// The numbers of all texels as little-endian words, and their type: `f4`, `u4` or `i4`.
fn numbers(texels: &Texels) -> (&'static str, Cow<'_, [u8]>) {
    let channels = texels.format.channels() as usize;
    let kind = kind(texels);
    // Channels of 32 bits are such words.
    if texels.bytes.len() == texels.width as usize * texels.height as usize * channels * 4 {
        return (kind, Cow::Borrowed(&texels.bytes));
    }
    let words = match texels.integers() {
        Some(integers) => integers,
        None => texels.floats().into_iter().map(|texel| texel.map(f32::to_bits)).collect(),
    };
    let bytes = words.iter().flat_map(|texel| texel[..channels].iter().flat_map(|word| word.to_le_bytes()));
    (kind, bytes.collect())
}

/// A word as a number of JSON. JSON has neither NaN nor infinity, so those are text.
pub(super) fn number(kind: &str, bits: u32) -> Value {
    match kind {
        "u4" => bits.into(),
        "i4" => bits.cast_signed().into(),
        _ => {
            let value = f32::from_bits(bits);
            if value.is_finite() { json!(value) } else { json!(value.to_string()) }
        }
    }
}

/// A number of JSON. JSON has neither NaN nor infinity, so those are text.
pub(super) fn float(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}
