//! Holds mouse, keys, gamepad and microphone for a program.

use raxel_diagnostics::names::{closest, list};
use raxel_runtime::Session;
use raxel_runtime::inputs::{
    BUTTONS, GAMEPAD_BUTTONS, Key, KeySet, button_named, button_names, gamepad_button_named, gamepad_button_names,
};
use serde_json::{Value, json};

use super::Drive;
use super::refusal::Refusal;
use super::request::HeldInputs;

/// Holds the inputs of a request from the next frame on, and answers with all that are held.
pub(super) fn hold(session: &mut Session, drive: Drive, held: HeldInputs) -> Result<Value, Refusal> {
    if held != HeldInputs::default() {
        let buttons = held.buttons.map(|names| bits(&names, "mouse button", &BUTTONS, button_named)).transpose()?;
        let of_gamepad =
            |names: Vec<String>| bits(&names, "button of a gamepad", &GAMEPAD_BUTTONS, gamepad_button_named);
        let gamepad_buttons = held.gamepad_buttons.map(of_gamepad).transpose()?;
        let keys = held.keys.map(|names| keys_named(&names)).transpose()?;
        if drive == Drive::Window {
            return Err(Refusal::new("the window has its own mouse and keyboard"));
        }
        // The file may be none that can be read, and then nothing has changed.
        if let Some(path) = held.microphone {
            session.give_sound((!path.is_empty()).then_some(&path)).map_err(Refusal::new)?;
        }
        // A demo that drives them would win.
        session.take_over();
        let inputs = session.inputs();
        if let Some(cursor) = held.cursor {
            inputs.cursor = cursor.first().zip(cursor.get(1)).map(|(x, y)| [*x, *y]);
        }
        buttons.into_iter().for_each(|buttons| inputs.hold_buttons(buttons));
        held.wheel.into_iter().for_each(|lines| inputs.set_wheel(lines));
        keys.into_iter().for_each(|keys| inputs.hold_keys(keys));
        held.gamepad_sticks.into_iter().for_each(|sticks| inputs.set_gamepad_sticks(sticks));
        held.gamepad_triggers.into_iter().for_each(|triggers| inputs.set_gamepad_triggers(triggers));
        gamepad_buttons.into_iter().for_each(|buttons| inputs.hold_gamepad_buttons(buttons));
        held.time_of_day.into_iter().for_each(|seconds| inputs.set_time_of_day(seconds));
    }
    let microphone = session.microphone().given().map_or(String::new(), |file| file.path.clone());
    let inputs = session.inputs();
    Ok(json!({
        "cursor": inputs.cursor.map_or(Vec::new(), Vec::from),
        "buttons": button_names(inputs.buttons()).collect::<Vec<_>>(),
        "wheel": inputs.wheel(),
        "keys": inputs.keys().names().collect::<Vec<_>>(),
        "gamepad_sticks": inputs.gamepad().sticks,
        "gamepad_triggers": inputs.gamepad().triggers,
        "gamepad_buttons": gamepad_button_names(inputs.gamepad().buttons).collect::<Vec<_>>(),
        "microphone": microphone,
        "time_of_day": inputs.time_of_day(),
    }))
}

/// The bits of buttons.
fn bits(
    names: &[String],
    what: &str,
    known: &[&'static str],
    named: impl Fn(&str) -> Option<u32>,
) -> Result<u32, Refusal> {
    let bit = |name: &String| {
        named(name).ok_or_else(|| not_held(what, name, known.iter().copied(), list(known.iter().copied())))
    };
    names.iter().try_fold(0, |bits, name| Ok(bits | bit(name)?))
}

/// The keys of these names.
fn keys_named(names: &[String]) -> Result<KeySet, Refusal> {
    let key = |name: &String| {
        Key::named(name)
            .ok_or_else(|| not_held("key", name, Key::names(), "names are those of browsers, e.g. `KeyW`".to_owned()))
    };
    names.iter().map(key).collect()
}

/// A button or a key that there is not.
fn not_held(what: &str, name: &str, known: impl Iterator<Item = &'static str>, otherwise: String) -> Refusal {
    let help = closest(name, known).map_or(otherwise, |like| format!("did you mean `{like}`?"));
    Refusal { error: format!("`{name}` is no {what}"), help: vec![help] }
}
