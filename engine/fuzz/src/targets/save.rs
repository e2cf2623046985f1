//! The folder of a save: read by every door, with checksums that are mostly right. It is refused, or read with its damage named, for any bytes.

use std::fs;

use raxel_edit::save::{Meta, Save, SaveOptions, pack, verify};

use crate::bounds::Bounds;
use crate::{Mutation, Target, projects};

pub(crate) const TARGET: Target = Target {
    name: "save",
    run,
    bounds: Bounds { bytes: 128 << 20, ..Bounds::PARSER },
    mutation: Mutation::Save,
    seeds: &[],
    longest: 16 << 10,
    quick: 100,
};

thread_local! {
    static FOLDER: tempfile::TempDir = tempfile::tempdir().expect("a folder for the saves");
}

fn run(input: &[u8]) {
    FOLDER.with(|folder| {
        let folder = folder.path().join("save");
        // The files of the last input are gone.
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir(&folder).expect("the folder is writable");
        for (name, bytes) in projects::parts(input) {
            // Any other name is a place outside of the save.
            if !name.is_empty()
                && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-.".contains(&byte))
                && !name.starts_with('.')
            {
                fs::write(folder.join(name), bytes).expect("the folder is writable");
            }
        }
        let report = match verify(&folder) {
            Ok(report) => report,
            Err(error) => return assert!(!error.to_string().trim().is_empty()),
        };
        assert!(report.damages.iter().all(|damage| !damage.what.trim().is_empty()), "{report:?}");
        assert!(report.applied <= report.newest, "{report:?}");
        let Some(meta) = report.meta.clone() else { return };
        let mut other = Meta { generator: [7; 32], ..meta.clone() };
        other.materials.reverse();
        for meta in [meta, other] {
            let options = SaveOptions { keep_on_generator_change: true, read_only: true, ..SaveOptions::default() };
            let opened = match Save::open(&folder, &meta, options) {
                Ok(opened) => opened,
                Err(error) => {
                    assert!(!error.to_string().trim().is_empty());
                    continue;
                }
            };
            assert_eq!((&opened.damages, opened.save.seq()), (&report.damages, report.newest));
            assert!(opened.steps.iter().all(|(seq, steps)| *seq > report.applied && !steps.is_empty()));
            for (_, chunk) in opened.chunks.iter().take(8) {
                if let Some(Some(chunk)) = chunk.unpack(meta.materials.len()) {
                    assert!(chunk.iter().all(|(_, material)| usize::from(material) < meta.materials.len()));
                }
            }
        }
        // The whole in one file is the same save.
        let Ok(packed) = pack(&folder) else { return };
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir(&folder).expect("the folder is writable");
        fs::write(folder.join("chunks.log"), packed).expect("the folder is writable");
        let again = verify(&folder).expect("what was packed can be read");
        assert_eq!((again.chunks, again.newest), (report.chunks, report.newest), "packed");
    });
}
