//! Keys of a demo as its file has them: moved, taken out, recorded. Comments and order of everything else stay.

use raxel_runtime::camera::Camera;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value, value};

use super::demo::Lane;
use super::recording::Recording;
use super::write_back::{camera_values, implicit_table, literal, parsed, rounded};

/// A key at most this many seconds away is overwritten by a new recording.
const SAME: f64 = 0.005;

/// A key that ends the part before it stands this many seconds in front of the next.
const APART: f64 = 0.01;

/// Why a check stays where it is.
const FIXED: &str = "a check is changed in the file: its reference is the picture of its frame";

/// Why an input stays where it is.
const RECORDED: &str = "inputs are changed in the file: a press belongs to its release";

/// The text of a demo with another time of a key.
pub fn with_time(text: &str, lane: &Lane, key: usize, to: f64) -> Result<String, String> {
    let mut document = parsed(text)?;
    // As it is written: two keys may not meet by rounding.
    let to = rounded(to);
    if lane.movable() {
        in_order(&mut document, lane, key, to)?;
    }
    let duration = seconds_of(document.as_table(), "duration").unwrap_or(f64::INFINITY);
    let time = match lane {
        Lane::Param(name) => param_keys(&mut document, name)
            .and_then(|keys| keys.get_mut(key)?.as_array_mut()?.get_mut(0))
            .ok_or_else(|| format!("the file has no such key of the param `{name}`"))?,
        Lane::Checks => return Err(FIXED.to_owned()),
        Lane::Input(_) => return Err(RECORDED.to_owned()),
        Lane::Camera | Lane::Graphs | Lane::Show | Lane::Edits | Lane::Captions => {
            let name = lane.array();
            let missing = || format!("the file has no `time` of entry {} of `{name}`", key.saturating_add(1));
            let table = document.get_mut(name).and_then(|keys| table_at(keys, key)).ok_or_else(missing)?;
            // An event with an end keeps its length.
            if let (Some(from), Some(until)) = (seconds_of(table, "time"), seconds_of(table, "until"))
                && let Some(end) = table.get_mut("until").and_then(Item::as_value_mut)
            {
                let ends = rounded(to + until - from);
                if ends > duration {
                    return Err(format!("it would end at {ends} s, and the demo ends at {duration} s"));
                }
                replace(end, ends.into());
            }
            table.get_mut("time").and_then(Item::as_value_mut).ok_or_else(missing)?
        }
    };
    replace(time, to.into());
    Ok(document.to_string())
}

/// The text of a demo without a key.
pub fn without_key(text: &str, lane: &Lane, key: usize) -> Result<String, String> {
    let mut document = parsed(text)?;
    let missing = || "the file has no such key".to_owned();
    match lane {
        Lane::Param(name) => {
            let keys = param_keys(&mut document, name).ok_or_else(missing)?;
            if keys.len() == 1 {
                return Err(format!("the only key of `{name}` stays; take the track out of the file"));
            }
            (key < keys.len()).then(|| keys.remove(key)).ok_or_else(missing)?;
        }
        Lane::Checks => return Err(FIXED.to_owned()),
        Lane::Input(_) => return Err(RECORDED.to_owned()),
        Lane::Camera | Lane::Graphs | Lane::Show | Lane::Edits | Lane::Captions => {
            match document.get_mut(lane.array()).ok_or_else(missing)? {
                Item::ArrayOfTables(tables) if key < tables.len() => {
                    tables.remove(key);
                }
                Item::Value(Value::Array(keys)) if key < keys.len() => {
                    keys.remove(key);
                }
                _ => return Err(missing()),
            }
        }
    }
    Ok(document.to_string())
}

/// The text of a demo with the camera as a key at a time. One that stands there is replaced, and keeps how it goes on.
pub fn with_camera_key(text: &str, time: f64, camera: &Camera) -> Result<String, String> {
    let mut document = parsed(text)?;
    let keys = document.entry("camera").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    let times: Vec<f64> = (0..).map_while(|key| seconds_of(table_at(keys, key)?, "time")).collect();
    if let Some(same) = times.iter().position(|at| (at - time).abs() < SAME) {
        let table = table_at(keys, same).ok_or("the key is not a table")?;
        table.remove("look_at");
        for (key, new) in camera_values(camera) {
            match (table.get_mut(key).and_then(Item::as_value_mut), new.into_value()) {
                (Some(old), Ok(new)) => replace(old, new),
                (None, Ok(new)) => drop(table.insert(key, Item::Value(new))),
                (_, Err(_)) => {}
            }
        }
        return Ok(document.to_string());
    }
    let after = times.iter().filter(|at| **at < time).count();
    let members = std::iter::once(("time", value(rounded(time)))).chain(camera_values(camera));
    match keys {
        Item::ArrayOfTables(tables) => {
            let mut table: Table = members.collect();
            table.decor_mut().set_prefix("\n");
            // Tables are written by their positions; those of one position, as they stand here.
            let position = |index: usize| tables.get(index).and_then(Table::position);
            if let Some(position) = after.checked_sub(1).map_or_else(|| position(0), position) {
                table.set_position(Some(position));
            }
            let mut all: Vec<Table> = std::mem::take(tables).into_iter().collect();
            all.insert(after, table);
            *tables = all.into_iter().collect();
        }
        Item::Value(Value::Array(keys)) if keys.len() == times.len() => {
            let table: InlineTable = members.filter_map(|(key, item)| Some((key, item.into_value().ok()?))).collect();
            keys.insert(after, table);
        }
        _ => return Err("`camera` of the file is not a list of tables".to_owned()),
    }
    Ok(document.to_string())
}

/// The text of a demo with these keys of a param, in order of time. They replace the keys from the first to the last of their times. Until the
/// first key of a new track, the param has the value of `before`.
pub fn with_param_keys(text: &str, recording: &Recording) -> Result<String, String> {
    let (keys, param) = (recording.keys(), &recording.param);
    let (Some(first), Some(last)) = (keys.first().map(|key| key.0), keys.last().map(|key| key.0)) else {
        return Ok(text.to_owned());
    };
    let mut document = parsed(text)?;
    let tracks = document.entry("tracks").or_insert_with(implicit_table);
    let tracks = tracks.as_table_like_mut().ok_or("`tracks` of the file is not a table")?;
    let new = !tracks.contains_key(param);
    let track = tracks.entry(param).or_insert(Item::Table(Table::new()));
    let track = track.as_table_like_mut().ok_or_else(|| format!("`tracks.{param}` of the file is not a table"))?;
    let array = track.entry("keys").or_insert(value(Array::new()));
    let array = array.as_array_mut().ok_or_else(|| format!("`keys` of the track `{param}` is not an array"))?;
    array.retain(|key| time_of(key).is_none_or(|time| time < first - SAME || time > last + SAME));
    let at = array.iter().take_while(|key| time_of(key).is_some_and(|time| time < first)).count();
    // As they are written: no two at one time.
    let hold = rounded(first - APART);
    let rest = [(rounded(first) > 0.0).then_some(0.0), (hold > 0.0).then_some(hold)];
    let rest = rest.into_iter().flatten().filter(|_| new).map(|time| (time, recording.before));
    let rest = rest.take(if recording.steps() { 1 } else { 2 });
    for (offset, (time, value)) in rest.chain(keys).enumerate() {
        let key: Array = [rounded(time).into(), literal(&value)].into_iter().collect::<Array>();
        array.insert(at + offset, Value::Array(key));
    }
    if new && recording.steps() {
        track.insert("interpolation", value("step"));
    }
    Ok(document.to_string())
}

/// The text of a demo with the keys of recordings, in their order.
pub fn with_recordings(text: &str, recordings: &[Recording]) -> Result<String, String> {
    recordings.iter().try_fold(text.to_owned(), |text, recording| with_param_keys(&text, recording))
}

/// The text of a demo of a graph and a world, by their project paths, with the keys of recordings and the camera as it is.
pub fn new_demo(graph: &str, world: &str, recordings: &[Recording], camera: &Camera) -> Result<String, String> {
    let inside = |path: &str, folder: &str| {
        let inside = path.strip_prefix(folder).and_then(|path| path.strip_prefix('/')).map(str::to_owned);
        inside.ok_or_else(|| format!("a demo plays only files in `{folder}`, and `{path}` is not"))
    };
    let (graph, world) = (inside(graph, "graphs")?, inside(world, "worlds")?);
    let ends = recordings.iter().filter_map(Recording::last);
    let duration = ends.fold(1.0, |most: f64, last| most.max(last.ceil()));
    let mut document = DocumentMut::new();
    for (key, item) in [("world", value(world)), ("graph", value(graph)), ("duration", value(duration))] {
        document.insert(key, item);
    }
    with_recordings(&with_camera_key(&document.to_string(), 0.0, camera)?, recordings)
}

/// Whether a key of a track may move to a time: it stays in order, and within the demo.
fn in_order(document: &mut DocumentMut, lane: &Lane, key: usize, to: f64) -> Result<(), String> {
    let duration = seconds_of(document.as_table(), "duration").unwrap_or(f64::INFINITY);
    if !(0.0..=duration).contains(&to) {
        return Err(format!("a key of this demo is at 0 to {duration} s, got {to}"));
    }
    let mut time = |key: usize| match lane {
        Lane::Param(name) => time_of(param_keys(document, name)?.get(key)?),
        _ => seconds_of(table_at(document.get_mut(lane.array())?, key)?, "time"),
    };
    if time(key).is_none() {
        // The caller reports a key that is not there.
        return Ok(());
    }
    let [before, after] = [key.checked_sub(1), key.checked_add(1)].map(|beside| time(beside?));
    // Edits of one time follow the order of the file.
    let beyond = |first: f64, second: f64| if *lane == Lane::Edits { first > second } else { first >= second };
    match before.filter(|before| beyond(*before, to)).or_else(|| after.filter(|after| beyond(to, *after))) {
        Some(beside) => Err(format!(
            "keys are in order of time: a key beside this one is at {beside} s, and {to} s is not between them"
        )),
        None => Ok(()),
    }
}

/// The time of a key of a param, `[seconds, value]`.
fn time_of(key: &Value) -> Option<f64> {
    let time = key.as_array()?.get(0)?;
    time.as_float().or_else(|| time.as_integer().map(|time| time as f64))
}

fn param_keys<'d>(document: &'d mut DocumentMut, param: &str) -> Option<&'d mut Array> {
    let track = document.get_mut("tracks")?.as_table_like_mut()?.get_mut(param)?;
    track.as_table_like_mut()?.get_mut("keys")?.as_array_mut()
}

/// A table of a list of tables, written in either way.
fn table_at(keys: &mut Item, index: usize) -> Option<&mut dyn TableLike> {
    match keys {
        Item::ArrayOfTables(tables) => Some(tables.get_mut(index)? as &mut dyn TableLike),
        Item::Value(Value::Array(keys)) => Some(keys.get_mut(index)?.as_inline_table_mut()? as &mut dyn TableLike),
        _ => None,
    }
}

fn seconds_of(table: &dyn TableLike, key: &str) -> Option<f64> {
    let seconds = table.get(key)?;
    seconds.as_float().or_else(|| seconds.as_integer().map(|seconds| seconds as f64))
}

/// Puts a value in the place of another, between the same spaces and comments.
fn replace(old: &mut Value, new: Value) {
    let decor = old.decor().clone();
    *old = new;
    *old.decor_mut() = decor;
}

#[cfg(test)]
mod tests {
    use raxel_graph::checked;

    use super::super::recording::Recorder;
    use super::*;

    const DEMO: &str = "# A flight.\nduration = 8.0\n\n# the start\n[[camera]]\ntime     = 0.0 # s\nposition = [1.0, 2.0, 3.0]\nlook_at  = [0.0, 0.0, 0.0]\n\n\
                        [[camera]]\ntime = 4\nposition = [5.0, 2.0, 3.0]\nyaw = 3.0\n\n[tracks.fog]\nkeys = [[0.0, 1.0], [5, 2.0]] # mist\n\n\
                        [[show]]\ntime = 1.0\ntarget = \"depth\"\n\n\
                        [[caption]]\ntime = 1\nuntil = 2.5 # gone\ntext = \"mist\"\n";

    #[test]
    fn a_key_moves_and_nothing_else_changes() {
        let moved = |lane, key, to| with_time(DEMO, &lane, key, to).unwrap();
        assert_eq!(moved(Lane::Camera, 0, 0.51), DEMO.replace("0.0 # s", "0.51 # s"));
        assert_eq!(moved(Lane::Camera, 1, 3.0), DEMO.replace("time = 4\n", "time = 3.0\n"));
        assert_eq!(moved(Lane::Param("fog".to_owned()), 1, 6.2), DEMO.replace("[5, 2.0]", "[6.2, 2.0]"));
        assert_eq!(moved(Lane::Show, 0, 2.25), DEMO.replace("time = 1.0", "time = 2.25"));
        let caption = DEMO.replace("time = 1\n", "time = 4.25\n").replace("until = 2.5", "until = 5.75");
        assert_eq!(moved(Lane::Captions, 0, 4.25), caption);
        let inline = "camera = [{ time = 0.0, yaw = 1 }, { time = 2.0 }] # all\n";
        assert_eq!(with_time(inline, &Lane::Camera, 1, 1.5).unwrap(), inline.replace("2.0", "1.5"));
    }

    #[test]
    fn what_the_file_does_not_have_is_said() {
        assert!(with_time(DEMO, &Lane::Camera, 2, 1.0).unwrap_err().contains("entry 3 of `camera`"));
        assert!(with_time(DEMO, &Lane::Param("sun".to_owned()), 0, 1.0).unwrap_err().contains("`sun`"));
        assert!(with_time(DEMO, &Lane::Camera, usize::MAX, 1.0).is_err());
        assert!(without_key(DEMO, &Lane::Camera, usize::MAX).is_err());
        for (key, to) in [(0, 4.0), (1, 0.0), (1, 8.5), (0, -1.0), (0, f64::NAN)] {
            let refused = with_time(DEMO, &Lane::Camera, key, to).unwrap_err();
            assert!(refused.contains("in order of time") || refused.contains("0 to 8 s"), "{refused}");
        }
        assert!(with_time(DEMO, &Lane::Param("fog".to_owned()), 0, 5.0).unwrap_err().contains("in order of time"));
        // As they are written, both would be at 4 s.
        assert!(with_time(DEMO, &Lane::Camera, 0, 3.9996).unwrap_err().contains("in order of time"));
        assert!(with_time(DEMO, &Lane::Captions, 0, 7.0).unwrap_err().contains("would end at 8.5 s"));
        assert!(with_time("a = ", &Lane::Camera, 0, 1.0).unwrap_err().starts_with("the file is broken"));
        assert!(without_key(DEMO, &Lane::Edits, 0).is_err());
        assert!(with_time(DEMO, &Lane::Input("keys".to_owned()), 0, 1.0).unwrap_err().contains("in the file"));
        assert!(with_time(DEMO, &Lane::Checks, 0, 1.0).is_err() && without_key(DEMO, &Lane::Checks, 0).is_err());
        assert!(without_key("tracks.fog.keys = [[0.0, 1.0]]", &Lane::Param("fog".to_owned()), 0).is_err());
        assert!(with_camera_key("camera = 3", 1.0, &Camera::at([0.0; 3])).is_err());
    }

    #[test]
    fn a_key_is_taken_out() {
        let without = without_key(DEMO, &Lane::Param("fog".to_owned()), 1).unwrap();
        assert_eq!(without, DEMO.replace(", [5, 2.0]", ""));
        let without = without_key(DEMO, &Lane::Camera, 1).unwrap();
        let cut = "[[camera]]\ntime = 4\nposition = [5.0, 2.0, 3.0]\nyaw = 3.0\n\n";
        assert_eq!(without, DEMO.replace(cut, ""));
    }

    #[test]
    fn the_camera_is_recorded_in_order_of_time() {
        let mut camera = Camera::at([7.5, 8.0, -9.25]);
        camera.yaw = 30.0_f64.to_radians();
        let lines = |time: &str| {
            format!("[[camera]]\ntime = {time}\nposition = [7.5, 8.0, -9.25]\nyaw = 30.0\npitch = 0.0\nfov = 60.0\n")
        };
        let between = with_camera_key(DEMO, 2.5, &camera).unwrap();
        let second = DEMO.find("[[camera]]\ntime = 4").unwrap();
        assert_eq!(between, format!("{}{}\n{}", &DEMO[..second], lines("2.5"), &DEMO[second..]));
        let last = with_camera_key(DEMO, 7.0, &camera).unwrap();
        let tracks = DEMO.find("[tracks.fog]").unwrap();
        assert_eq!(last, format!("{}{}\n{}", &DEMO[..tracks], lines("7.0"), &DEMO[tracks..]));
        // Into a file without any, and before the first.
        let first = with_camera_key("duration = 8.0\n", 2.5, &camera).unwrap();
        assert_eq!(first, format!("duration = 8.0\n\n{}", lines("2.5")));
        let before = with_camera_key(&first, 1.0, &camera).unwrap();
        assert_eq!(before, format!("duration = 8.0\n\n{}\n{}", lines("1.0"), lines("2.5")));
        let inline = with_camera_key("camera = [{ time = 0.0, yaw = 1 }]\n", 2.0, &camera).unwrap();
        assert!(
            inline.starts_with("camera = [{ time = 0.0, yaw = 1 }, { time = 2.0, position = [7.5, 8.0, -9.25]"),
            "{inline}"
        );
    }

    /// A recording of these times and values.
    fn recorded(param: &str, samples: &[(f64, f64)]) -> Recording {
        let mut recorder = Recorder::default();
        recorder.turn(true);
        for (time, value) in samples {
            recorder.moved(param, checked::Value::F32(0.5), *time, &[*value]);
        }
        recorder.frame(9.0, false).remove(0)
    }

    #[test]
    fn a_param_is_recorded_over_the_keys_that_are_there() {
        let written = with_param_keys(DEMO, &recorded("fog", &[(4.0, 1.0), (5.0, 3.0), (6.0, 1.0)])).unwrap();
        assert_eq!(written, DEMO.replace("[5, 2.0]]", "[4.0, 1.0], [5.0, 3.0], [6.0, 1.0]]"));
        // One key, while the demo is paused.
        let one = with_param_keys(DEMO, &recorded("fog", &[(2.0, 4.0)])).unwrap();
        assert_eq!(one, DEMO.replace("[5, 2.0]", "[2.0, 4.0], [5, 2.0]"));
        // Before a new track begins, nothing changes.
        let new = with_param_keys(DEMO, &recorded("sun", &[(2.0, 4.0), (3.0, 5.0)])).unwrap();
        let track = "[tracks.sun]\nkeys = [[0.0, 0.5], [1.99, 0.5], [2.0, 4.0], [3.0, 5.0]]\n";
        assert!(new.contains(track) && new.contains("keys = [[0.0, 1.0], [5, 2.0]] # mist"), "{new}");
        let at_once = with_param_keys("duration = 3.0\n", &recorded("sun", &[(0.0, 4.0)])).unwrap();
        assert_eq!(at_once, "duration = 3.0\n\n[tracks.sun]\nkeys = [[0.0, 4.0]]\n");
        for (first, keys) in
            [(0.01, "[0.0, 0.5], [0.01, 4.0]"), (0.0102, "[0.0, 0.5], [0.01, 4.0]"), (0.0004, "[0.0, 4.0]")]
        {
            let soon = with_param_keys("duration = 3.0\n", &recorded("sun", &[(first, 4.0)])).unwrap();
            assert_eq!(soon, format!("duration = 3.0\n\n[tracks.sun]\nkeys = [{keys}]\n"));
        }
        assert!(with_param_keys("tracks = 3", &recorded("sun", &[(0.0, 4.0)])).is_err());
        assert!(with_param_keys("tracks.sun.keys = 3", &recorded("sun", &[(0.0, 4.0)])).is_err());
    }

    #[test]
    fn a_new_demo_plays_what_was_recorded() {
        let recording = [recorded("fog", &[(0.5, 1.0), (2.25, 4.0)])];
        let camera = Camera::at([7.5, 8.0, -9.25]);
        let text = new_demo("graphs/more/a.toml", "worlds/b.toml", &recording, &camera).unwrap();
        assert!(
            text.starts_with("world = \"b.toml\"\ngraph = \"more/a.toml\"\nduration = 3.0\n\n[[camera]]\ntime = 0.0\n"),
            "{text}"
        );
        assert!(
            text.ends_with("\n[tracks.fog]\nkeys = [[0.0, 0.5], [0.49, 0.5], [0.5, 1.0], [2.25, 4.0]]\n"),
            "{text}"
        );
        assert!(new_demo("a.toml", "worlds/b.toml", &recording, &camera).unwrap_err().contains("`a.toml` is not"));
    }

    #[test]
    fn a_key_at_that_time_is_recorded_anew() {
        let again = with_camera_key(DEMO, 0.001, &Camera::at([7.5, 8.0, -9.25])).unwrap();
        let recorded = "position = [7.5, 8.0, -9.25]\nyaw = 0.0\npitch = 0.0\nfov = 60.0\n";
        let looks = "position = [1.0, 2.0, 3.0]\nlook_at  = [0.0, 0.0, 0.0]\n";
        assert_eq!(again, DEMO.replace(looks, recorded));
    }
}
