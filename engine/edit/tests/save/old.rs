//! Saves of older formats: written by the programs of their time.

use std::path::Path;

use raxel_edit::save::{pack, verify};

use super::{Game, quiet, replayed};

/// A save as format 1 had it: a checkpoint of six edits of the script, and six in a journal.
const FOLDER: [(&str, &[u8]); 2] = [
    ("chunks.log", include_bytes!("../format1/chunks.log")),
    ("journal-000002.log", include_bytes!("../format1/journal-000002.log")),
];

/// The same in one file.
const PACKED: [(&str, &[u8]); 1] = [("chunks.log", include_bytes!("../format1/packed.save"))];

fn put(folder: &Path, files: &[(&str, &[u8])]) {
    for (name, bytes) in files {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

#[test]
fn a_save_of_format_1_opens_and_is_written_anew() {
    for files in [&FOLDER[..], &PACKED] {
        let folder = tempfile::tempdir().unwrap();
        put(folder.path(), files);
        let report = verify(folder.path()).unwrap();
        assert_eq!((report.newest, report.meta.unwrap().format, &report.damages[..]), (12, 1, &[][..]));
        let packed = pack(folder.path()).unwrap();
        for n in 13..16 {
            let (mut game, damages) = Game::open(folder.path(), quiet());
            assert!(damages.is_empty() && game.voxels() == replayed(n - 1), "{damages:?}");
            game.play(n);
            if n == 14 {
                game.save.checkpoint(&game.edits);
            }
        }
        let report = verify(folder.path()).unwrap();
        assert_eq!((report.newest, report.meta.unwrap().format, &report.damages[..]), (15, 2, &[][..]));
        let elsewhere = tempfile::tempdir().unwrap();
        put(elsewhere.path(), &[("chunks.log", &packed)]);
        let (game, damages) = Game::open(elsewhere.path(), quiet());
        assert!(damages.is_empty() && game.voxels() == replayed(12), "{damages:?}");
    }
}

#[test]
fn a_stop_while_a_save_of_format_1_is_written_anew_loses_nothing() {
    let before = tempfile::tempdir().unwrap();
    put(before.path(), &FOLDER);
    let after = super::copy(before.path());
    drop(Game::open(after.path(), quiet()));
    let [chunks, tail] = ["chunks.log", "tail"].map(|name| std::fs::read(after.path().join(name)).unwrap());
    // The tail comes first, then the chunks, and then the journal goes.
    for written in [&[("tail", &tail[..])][..], &[("tail", &tail), ("chunks.log", &chunks)]] {
        let stopped = super::copy(before.path());
        put(stopped.path(), written);
        for _ in 0..2 {
            let (game, damages) = Game::open(stopped.path(), quiet());
            assert!(damages.is_empty() && game.voxels() == replayed(12), "{damages:?}");
        }
    }
}

#[test]
fn a_record_of_format_1_at_full_length_with_a_wrong_sum_is_a_loss() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), &FOLDER);
    let mut journal = FOLDER[1].1.to_vec();
    *journal.last_mut().unwrap() ^= 1;
    std::fs::write(folder.path().join(FOLDER[1].0), journal).unwrap();
    let damages = verify(folder.path()).unwrap().damages;
    assert!(damages.len() == 1 && !damages[0].unfinished && damages[0].what == "edit 12", "{damages:?}");
}
