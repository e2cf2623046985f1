//! The source of the voxels below the edits, as a hash.

use std::fmt::Write as _;

use raxel_diagnostics::Files;
use raxel_worldfile::Loaded;

/// Keys of a world file that change no voxel.
const COSMETIC: [&str; 6] = ["name", "about", "camera", "cameras", "save", "stream"];

/// A hash of everything that the voxels of a world are built from: its file without the keys that change no voxel, and the files of its
/// models. Materials count by their names; how they look does not. Of tiles that come from a store, it is the store's own description.
pub(super) fn hash(loaded: &Loaded, files: &dyn Files) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    if let Some(baked) = loaded.stream.as_ref().and_then(|streamed| streamed.generator.fingerprint()) {
        hasher.update(baked.as_bytes());
    }
    for (index, path) in loaded.files.iter().enumerate() {
        let Ok(bytes) = files.read(path) else { continue };
        let table = (index == 0).then(|| std::str::from_utf8(&bytes).ok()?.parse::<toml::Table>().ok()).flatten();
        match table {
            Some(table) => hasher.update(essence(table).as_bytes()),
            None => hasher.update(path.as_bytes()).update(&bytes),
        };
    }
    *hasher.finalize().as_bytes()
}

fn essence(mut table: toml::Table) -> String {
    for key in COSMETIC {
        table.remove(key);
    }
    if let Some(toml::Value::Table(materials)) = table.get_mut("materials") {
        for (_, material) in materials.iter_mut() {
            *material = toml::Value::Boolean(true);
        }
    }
    let mut text = String::new();
    write_sorted(&toml::Value::Table(table), &mut text);
    text
}

/// A value without comments and spaces, keys in alphabetic order.
fn write_sorted(value: &toml::Value, text: &mut String) {
    match value {
        toml::Value::Table(table) => {
            let mut entries: Vec<_> = table.iter().collect();
            entries.sort_unstable_by_key(|(key, _)| *key);
            for (key, value) in entries {
                let _ = write!(text, "{key:?}{{");
                write_sorted(value, text);
                *text += "}";
            }
        }
        toml::Value::Array(values) => {
            for value in values {
                *text += "[";
                write_sorted(value, text);
                *text += "]";
            }
        }
        value => *text += &value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_do_not_count_and_voxels_do() {
        let essence = |text: &str| essence(text.parse().unwrap());
        let world = "seed = 1\nname = \"a\"\n[materials]\nm = { albedo = \"#ffffff\" }\n[[build]]\nop = \"box\"\nsize = [4, 4, 4]\n";
        let same = "# a comment\nname = \"b\"\nseed = 1\n[camera]\nposition = [1, 2, 3]\n[materials.m]\nalbedo = [0, 0, 0]\n\
                    [save]\npath = \"saves/x\"\n[[build]]\nsize = [4, 4, 4]\nop = \"box\"\n";
        assert_eq!(essence(world), essence(same));
        for other in [world.replace("seed = 1", "seed = 2"), world.replace("4]", "5]"), world.replace("m =", "n =")] {
            assert_ne!(essence(world), essence(&other));
        }
    }
}
