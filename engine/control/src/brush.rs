//! The brush of a window, for the program that sets it.

use raxel_runtime::Session;
use serde_json::{Value, json};

use super::host::{Brush, Host};
use super::refusal::Refusal;
use super::request::BrushChange;

/// Changes the brush, and answers with it.
pub(super) fn change(host: &mut dyn Host, change: &BrushChange) -> Result<Value, Refusal> {
    if host.window().is_none() {
        return Err(Refusal::no_window("brush").or("`edit` edits the world"));
    }
    let material = change.material.as_deref().map(|name| material(host.session(), name)).transpose()?;
    let window = host.window().ok_or_else(|| Refusal::no_window("brush"))?;
    let now = window.brush();
    let brush = Brush {
        effect: change.effect.unwrap_or(now.effect),
        shape: change.shape.unwrap_or(now.shape),
        size: change.size.unwrap_or(now.size),
        height: change.height.unwrap_or(now.height),
        material: material.unwrap_or(now.material),
    };
    if brush != now {
        window.set_brush(brush);
    }
    Ok(described(&brush, host.session()))
}

/// The material of a name; an empty one is that under the cursor.
fn material(session: &Session, name: &str) -> Result<Option<u16>, Refusal> {
    if name.is_empty() {
        return Ok(None);
    }
    // The first one is air, which no brush has.
    let known = || session.scene().materials.iter().map(|material| &*material.name).skip(1);
    let found = known().position(|known| known == name).and_then(|index| u16::try_from(index + 1).ok());
    found.map(Some).ok_or_else(|| Refusal::unknown("the world has no material", name, known()))
}

fn described(brush: &Brush, session: &Session) -> Value {
    let Brush { effect, shape, size, height, material } = *brush;
    let material = material.and_then(|index| session.scene().materials.get(usize::from(index)));
    let material = material.map_or("", |material| &material.name);
    json!({ "effect": effect, "shape": shape, "size": size, "height": height, "material": material })
}
