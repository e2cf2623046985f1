//! The invocations that write a texel, for the program that asks.

use raxel_execute::{InvocationWrite, PassWrites, TracedTexel};
use raxel_runtime::Session;
use raxel_runtime::debug_target::DebugTarget;
use raxel_shader::interface::ScalarKind;
use serde_json::{Value, json};

use super::Drive;
use super::read::number;
use super::refusal::Refusal;

/// Compiles the shaders with records of their writes, or without.
pub(super) fn record(session: &mut Session, on: bool) -> Value {
    if !on {
        session.find_writers(None);
    }
    let compiles = session.records_writes() != on && session.record_writes(on);
    json!({ "on": on, "compiles": compiles })
}

/// The known writes of a texel, whose writes are recorded from the next frame on.
pub(super) fn find(session: &mut Session, drive: Drive, texel: TracedTexel) -> Result<Value, Refusal> {
    if !session.records_writes() {
        let help = vec!["send `record_writes`, and then `wait_reload`".to_owned()];
        return Err(Refusal { error: "the shaders do not record their writes".to_owned(), help });
    }
    check(session, &texel)?;
    if drive == Drive::Requests && session.picture().is_some() {
        session.wait()?;
    }
    session.find_writers(Some(texel));
    let passes: Vec<Value> = session.writers().iter().map(pass).collect();
    Ok(json!({ "passes": passes }))
}

/// Refuses a texel that is not there.
fn check(session: &Session, texel: &TracedTexel) -> Result<(), Refusal> {
    let target = DebugTarget { mip: texel.mip, layer: texel.layer, ..DebugTarget::resource(&texel.target) };
    let resource = target.resolve(session.graph())?.resource;
    let extent = session.plan().and_then(|plan| plan.sizes.get(resource.0 as usize)?.texels(texel.mip));
    let [x, y] = texel.at;
    match extent {
        None => {
            Err(Refusal::new(format!("`{}` is a buffer; `writers` are those of a texel of a target", texel.target)))
        }
        Some([width, height, layers]) if x >= width || y >= height || texel.layer >= layers => {
            Err(Refusal::new(format!("`{target}` has {width}×{height}×{layers} texels; there is none at {x}, {y}")))
        }
        Some(_) => Ok(()),
    }
}

fn pass(written: &PassWrites) -> Value {
    let writes: Vec<Value> = written.writes.iter().map(write).collect();
    json!({
        "pass": written.pass,
        "frame": written.frame,
        "count": written.count,
        "race": written.races(),
        "writes": writes,
    })
}

fn write(write: &InvocationWrite) -> Value {
    let (file, line) = write.place.as_ref().map(|(file, line)| (&**file, *line)).unzip();
    let kind = match write.value.scalar {
        ScalarKind::Uint => "u4",
        ScalarKind::Int => "i4",
        ScalarKind::Float => "f4",
    };
    let values: Vec<Value> = write.value.words.iter().map(|word| number(kind, *word)).collect();
    json!({
        "file": file,
        "line": line,
        "invocation": write.invocation,
        "workgroup": write.workgroup,
        "values": values,
        "atomic": write.atomic,
    })
}
