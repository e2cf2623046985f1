//! Saves under everything that can happen to them: kills at any moment, files cut off at any byte, flipped bytes, full disks, other
//! processes, other programs.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod damage;
mod old;
#[path = "../scenes/mod.rs"]
mod scenes;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use raxel_edit::save::{Compacted, Meta, Opened, Save, SaveError, SaveEvent, SaveOptions, compact, pack, verify};
use raxel_edit::{Brush, Edits, Operation, PackedChunk, Scene};
use raxel_testing::{Running, Said, line, output};
use raxel_world::{ChunkPos, World};
use scenes::{Random, scene, world};

fn meta() -> Meta {
    let materials = scene().materials.iter().map(|material| material.name.clone()).collect();
    Meta { format: 0, world: "worlds/test.toml".to_owned(), generator: [7; 32], materials }
}

/// Only requested checkpoints.
fn quiet() -> SaveOptions {
    SaveOptions { checkpoint: Duration::from_secs(3600), journal_bytes: u64::MAX, ..SaveOptions::default() }
}

/// The n-th edit of a script that goes on for ever. Small ones, so that many fit into a test.
fn script(n: u64) -> Operation {
    let mut random = Random(n * 1000);
    match random.operation() {
        Operation::Box { bounds, .. } | Operation::Restore { bounds } if bounds.size().iter().any(|s| *s > 40) => {
            Operation::set(bounds.min.map(|c| c as i32), 1)
        }
        operation => operation,
    }
}

/// A world, its edits and its save.
struct Game {
    base: World,
    scene: Scene,
    edits: Edits,
    save: Save,
}

impl Game {
    fn open(folder: &Path, options: SaveOptions) -> (Self, Vec<String>) {
        let opened = Save::open(folder, &meta(), options).unwrap();
        let damages = opened.damages.iter().map(|damage| format!("{damage} {}", damage.unfinished)).collect();
        (Self::start(opened), damages)
    }

    fn start(opened: Opened) -> Self {
        let Opened { mut save, chunks, steps, .. } = opened;
        let (base, scene, mut edits) = (world(), scene(), Edits::default());
        edits.adopt(chunks, scene.materials.len());
        for (_, operations) in steps {
            let change = edits.replay(&operations, &scene, &base).unwrap();
            save.replayed(&change);
        }
        Self { base, scene, edits, save }
    }

    fn play(&mut self, n: u64) {
        self.commit(script(n));
        assert_eq!(self.save.seq(), n);
    }

    fn commit(&mut self, operation: Operation) {
        let operations = [operation];
        let change = self.edits.apply(&operations, &self.scene, &self.base).unwrap();
        assert!(self.save.commit(&operations, &change).unwrap());
    }

    fn voxels(&self) -> BTreeMap<ChunkPos, PackedChunk> {
        all(&self.edits)
    }
}

fn all(edits: &Edits) -> BTreeMap<ChunkPos, PackedChunk> {
    edits.positions().map(|pos| (pos, edits.packed(pos).unwrap())).collect()
}

/// The chunks that the first edits of the script leave behind.
fn replayed(edits: u64) -> BTreeMap<ChunkPos, PackedChunk> {
    left_by(1..=edits)
}

/// The chunks that some of them leave behind.
fn left_by(edits: impl Iterator<Item = u64>) -> BTreeMap<ChunkPos, PackedChunk> {
    let mut all_edits = Edits::default();
    let operations: Vec<_> = edits.map(script).collect();
    all_edits.replay(&operations, &scene(), &world()).unwrap();
    all(&all_edits)
}

/// The program that is killed: plays the script from where its save is, and says each edit that was acknowledged.
#[test]
fn child() {
    let Ok(folder) = std::env::var("RAXEL_TEST_SAVE") else { return };
    // Checkpoints all the time, so that they are killed too.
    let options = SaveOptions {
        journal_bytes: 3000,
        checkpoint: Duration::from_millis(3),
        sync: Duration::from_millis(2),
        ..SaveOptions::default()
    };
    let (mut game, _) = Game::open(Path::new(&folder), options);
    let mut out = std::io::stdout().lock();
    for n in game.save.seq() + 1.. {
        game.play(n);
        writeln!(out, "acknowledged {n}").unwrap();
        out.flush().unwrap();
        game.save.poll(&game.edits);
    }
}

fn start_child(folder: &Path) -> Running {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "child", "--nocapture", "--test-threads=1"]).env("RAXEL_TEST_SAVE", folder);
    Running::start(command.stdout(Stdio::piped()).stderr(Stdio::null()))
}

/// Kills the program this many times, each time at a random moment, and inspects the remaining files.
fn kill(times: u64) {
    let folder = tempfile::tempdir().unwrap();
    // The voxels after every edit so far, followed along.
    let (base, scene, mut edits, mut known) = (world(), scene(), Edits::default(), 0);
    let mut random = Random(42);
    let mut interrupted = 0;
    for round in 0..times {
        let mut child = start_child(folder.path());
        let mut acknowledged = known;
        let lines = Said::by(child.0.stdout.take().unwrap(), line);
        let number = |line: &str| line.trim_end().rsplit(' ').next().and_then(|n| n.parse().ok());
        // Some die while they open the save, most while they play.
        let edits_first = if round % 10 == 0 { 0 } else { 1 + random.next(60) };
        let started = acknowledged;
        while acknowledged < started + edits_first {
            acknowledged = number(&lines.next()).unwrap_or(acknowledged);
        }
        std::thread::sleep(Duration::from_micros(random.next(6000)));
        child.0.kill().unwrap();
        child.finish();
        for line in lines.rest() {
            acknowledged = number(&line).unwrap_or(acknowledged);
        }
        let opened = Save::open(folder.path(), &meta(), quiet()).unwrap();
        let seq = opened.save.seq();
        assert!(seq >= acknowledged, "edit {acknowledged} was acknowledged, and the save ends at {seq}");
        assert!(seq <= acknowledged + 1, "one edit at most was saved and not yet said");
        assert!(opened.damages.iter().all(|damage| damage.unfinished), "{:?}", opened.damages);
        interrupted += opened.damages.len();
        let game = Game::start(opened);
        for n in known + 1..=seq {
            edits.replay(&[script(n)], &scene, &base).unwrap();
        }
        known = seq;
        assert!(game.voxels() == all(&edits), "round {round}: the voxels after edit {seq} differ");
    }
    assert!(known > times * 10);
    println!("{times} kills, {known} edits, {interrupted} records that were being written");
}

#[test]
fn no_acknowledged_edit_is_lost_by_a_kill() {
    kill(30);
}

#[test]
#[ignore = "takes minutes"]
fn no_acknowledged_edit_is_lost_by_a_thousand_kills() {
    kill(1000);
}

/// A save with a checkpoint of six edits and six edits in its journal.
fn twelve_edits(folder: &Path) {
    let (mut game, _) = Game::open(folder, quiet());
    for n in 1..=6 {
        game.play(n);
    }
    assert!(matches!(game.save.checkpoint(&game.edits)[..], [SaveEvent::Checkpoint { seq: 6, .. }]));
    for n in 7..=12 {
        game.play(n);
    }
}

fn only_journal(folder: &Path) -> PathBuf {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut journals: Vec<_> = files.filter(|path| path.to_string_lossy().contains("journal")).collect();
    journals.sort();
    assert_eq!(journals.len(), 1, "{journals:?}");
    journals.remove(0)
}

/// The same files in another folder.
fn copy(from: &Path) -> tempfile::TempDir {
    let to = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), to.path().join(entry.file_name())).unwrap();
    }
    to
}

#[test]
fn a_journal_cut_off_at_any_byte_opens_up_to_its_last_whole_edit_and_names_the_others() {
    let folder = tempfile::tempdir().unwrap();
    twelve_edits(folder.path());
    let journal = only_journal(folder.path());
    let bytes = std::fs::read(&journal).unwrap();
    let ends: Vec<usize> = records(&bytes).into_iter().skip(3).chain([bytes.len()]).collect();
    let cut = copy(folder.path());
    for end in 0..bytes.len() {
        std::fs::write(only_journal(cut.path()), &bytes[..end]).unwrap();
        let opened = Save::open(cut.path(), &meta(), SaveOptions { read_only: true, ..quiet() }).unwrap();
        let whole = 6 + ends.iter().filter(|whole| **whole <= end).count() as u64;
        assert_eq!(opened.steps.iter().map(|(seq, _)| *seq).collect::<Vec<_>>(), (7..=whole).collect::<Vec<_>>());
        let said: Vec<String> =
            (opened.damages.iter().filter(|damage| !damage.unfinished)).map(ToString::to_string).collect();
        let named = |n: &u64| said.iter().any(|said| names(said, *n));
        assert_eq!((1..=12).filter(named).collect::<Vec<_>>(), (whole + 1..=12).collect::<Vec<_>>(), "{end}: {said:?}");
    }
}

/// Where the records of a file begin.
fn records(bytes: &[u8]) -> Vec<usize> {
    (0..bytes.len() - 4).filter(|&at| [b"RXV1", b"RXV2"].iter().any(|magic| bytes[at..].starts_with(*magic))).collect()
}

/// Whether a message about damage names an edit as lost.
fn names(said: &str, edit: u64) -> bool {
    let Some((_, edits)) = said.rsplit_once("edit") else { return false };
    let numbers: Vec<u64> = edits.trim_start_matches('s').trim().split('…').filter_map(|n| n.parse().ok()).collect();
    numbers.first().is_some_and(|first| (*first..=*numbers.last().unwrap()).contains(&edit))
}

/// A disk writes unsynced data in any order. Each sector behind the last sync is written, or zeros, or beyond the end of the file.
#[test]
fn a_power_cut_costs_edits_behind_the_last_sync_and_no_others() {
    const SECTOR: usize = 64;
    let folder = tempfile::tempdir().unwrap();
    let (mut game, _) = Game::open(folder.path(), quiet());
    let mut ends = Vec::new();
    for n in 1..=16 {
        game.play(n);
        ends.push(std::fs::metadata(only_journal(folder.path())).unwrap().len() as usize);
    }
    drop(game);
    let journal = std::fs::read(only_journal(folder.path())).unwrap();
    let (synced, mut random, mut lost) = (ends[5], Random(8), [0; 17]);
    for _ in 0..120 {
        let mut bytes = journal.clone();
        bytes.truncate(synced + random.next((journal.len() - synced) as u64 + 1) as usize);
        for start in (synced / SECTOR * SECTOR..bytes.len()).step_by(SECTOR) {
            let sector = start.max(synced)..(start + SECTOR).min(bytes.len());
            if random.next(4) == 0 {
                bytes[sector].fill(0);
            }
        }
        let whole = |n: &u64| {
            let from = if *n == 1 { 0 } else { ends[*n as usize - 2] };
            bytes.get(from..ends[*n as usize - 1]) == Some(&journal[from..ends[*n as usize - 1]])
        };
        let (left, gone): (Vec<u64>, Vec<u64>) = (1..=16).partition(whole);
        assert!(left.starts_with(&[1, 2, 3, 4, 5, 6]));
        lost[gone.len()] += 1;
        let cut = copy(folder.path());
        std::fs::write(only_journal(cut.path()), &bytes).unwrap();
        let (game, _) = Game::open(cut.path(), quiet());
        assert!(game.voxels() == left_by(left.into_iter()), "{gone:?} are gone");
    }
    assert!(lost.iter().filter(|count| **count > 0).count() > 5, "{lost:?}");
}

#[test]
fn a_checkpoint_cut_off_at_any_byte_costs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (mut game, _) = Game::open(folder.path(), quiet());
    for n in 1..=6 {
        game.play(n);
    }
    drop(game);
    // The journals as they are while the checkpoint is being written.
    let before = copy(folder.path());
    let (mut game, _) = Game::open(folder.path(), quiet());
    game.save.checkpoint(&game.edits);
    drop(game);
    let chunks = std::fs::read(folder.path().join("chunks.log")).unwrap();
    let begun = std::fs::read(before.path().join("chunks.log")).unwrap().len();
    let expected = replayed(6);
    for end in (begun..=chunks.len()).filter(|end| end % 97 == 0 || chunks.len() - end < 100) {
        let cut = copy(before.path());
        std::fs::write(cut.path().join("chunks.log"), &chunks[..end]).unwrap();
        let (mut game, _) = Game::open(cut.path(), quiet());
        assert!(game.voxels() == expected, "cut at {end}");
        // And it goes on from there.
        game.play(7);
        game.save.checkpoint(&game.edits);
        let voxels = game.voxels();
        drop(game);
        let (game, damages) = Game::open(cut.path(), quiet());
        assert!(game.voxels() == voxels && damages.is_empty(), "{damages:?}");
    }
}

/// Bytes of the record at the end of a checkpoint.
const COMMIT: usize = 48;

#[test]
fn a_finished_checkpoint_whose_end_is_cut_off_keeps_its_chunks_and_names_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    twelve_edits(folder.path());
    let whole = Game::open(copy(folder.path()).path(), quiet()).0.voxels();
    let chunks = std::fs::read(folder.path().join("chunks.log")).unwrap();
    // Two commits are at the end; without one of them, nothing is missed.
    for end in (0..chunks.len() - COMMIT).filter(|end| end % 31 == 0 || chunks.len() - end <= 2 * COMMIT + 2) {
        let cut = copy(folder.path());
        std::fs::write(cut.path().join("chunks.log"), &chunks[..end]).unwrap();
        let report = verify(cut.path()).unwrap();
        assert!(report.damages.iter().any(|damage| !damage.unfinished), "cut at {end}: {:?}", report.damages);
        assert_eq!(report.newest, 12);
        for _ in 0..2 {
            let (game, _) = Game::open(cut.path(), quiet());
            if chunks.len() - end <= 2 * COMMIT {
                assert!(game.voxels() == whole, "cut at {end}");
            }
        }
    }
    let gone = copy(folder.path());
    std::fs::remove_file(gone.path().join("chunks.log")).unwrap();
    let (_, damages) = Game::open(gone.path(), SaveOptions { read_only: true, ..quiet() });
    assert_eq!(damages, ["chunks.log: missing: edits 1…6 false"]);
}

#[test]
fn a_file_with_the_chunks_that_is_gone_is_missed_where_all_journals_are_empty() {
    let folder = tempfile::tempdir().unwrap();
    let (mut game, _) = Game::open(folder.path(), quiet());
    for n in 1..=6 {
        game.play(n);
    }
    game.save.checkpoint(&game.edits);
    drop(game);
    std::fs::remove_file(folder.path().join("chunks.log")).unwrap();
    let named = |folder: &Path| -> Vec<_> { verify(folder).unwrap().damages.iter().map(ToString::to_string).collect() };
    for _ in 0..2 {
        assert_eq!(named(folder.path()), ["chunks.log: missing: edits 1…6"]);
        let (game, damages) = Game::open(folder.path(), quiet());
        assert_eq!((game.save.seq(), damages.len()), (6, 1));
    }
    let (mut game, _) = Game::open(folder.path(), quiet());
    game.play(7);
    drop(game);
    assert_eq!(named(folder.path()), ["chunks.log: missing: edits 1…6"]);
    for _ in 0..2 {
        compact(folder.path()).unwrap();
        assert_eq!(named(folder.path()), [""; 0]);
        let (game, _) = Game::open(folder.path(), quiet());
        assert!(game.save.seq() == 7 && game.voxels() == left_by(7..=7));
    }
}

#[test]
fn lost_edits_are_named_until_the_save_is_written_anew() {
    let folder = tempfile::tempdir().unwrap();
    twelve_edits(folder.path());
    let journal = only_journal(folder.path());
    let mut bytes = std::fs::read(&journal).unwrap();
    let records = records(&bytes);
    // Behind two descriptions: edits 9 and 10 are gone without a trace.
    bytes.drain(records[4]..records[6]);
    std::fs::write(&journal, bytes).unwrap();
    let named = |folder: &Path| -> Vec<_> { verify(folder).unwrap().damages.iter().map(ToString::to_string).collect() };
    assert_eq!(named(folder.path()), ["journal-000002.log: missing: edits 9…10"]);
    compact(folder.path()).unwrap();
    assert_eq!(named(folder.path()), [""; 0]);
    let (game, _) = Game::open(folder.path(), quiet());
    assert_eq!(game.save.seq(), 12);
    assert!(game.voxels() == left_by((1..=12).filter(|n| ![9, 10].contains(n))));
}

#[test]
fn who_reads_while_another_makes_checkpoints_misses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (mut game, _) = Game::open(folder.path(), quiet());
    let acknowledged = std::sync::atomic::AtomicU64::new(0);
    let over = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        let reader = scope.spawn(|| {
            while !over.load(std::sync::atomic::Ordering::Acquire) {
                let least = acknowledged.load(std::sync::atomic::Ordering::Acquire);
                let report = verify(folder.path()).unwrap();
                assert!(report.newest >= least, "{} of {least}", report.newest);
                assert!(report.damages.iter().all(|damage| damage.unfinished), "{:?}", report.damages);
            }
        });
        for n in 1..=400 {
            game.play(n);
            acknowledged.store(n, std::sync::atomic::Ordering::Release);
            game.save.checkpoint(&game.edits);
            if reader.is_finished() {
                break;
            }
        }
        over.store(true, std::sync::atomic::Ordering::Release);
    });
}

#[test]
fn a_stop_before_old_journals_are_removed_leaves_materials_right() {
    let folder = tempfile::tempdir().unwrap();
    twelve_edits(folder.path());
    let before = copy(folder.path());
    let mut turned = meta();
    turned.materials[1..].reverse();
    // The program is killed when the chunks are rewritten, with the materials in their new order, and the journal is still there.
    let opened = Save::open(folder.path(), &turned, quiet()).unwrap();
    let expected = (opened.chunks, opened.steps);
    drop(opened.save);
    let journal = only_journal(before.path());
    std::fs::copy(&journal, folder.path().join(journal.file_name().unwrap())).unwrap();
    let opened = Save::open(folder.path(), &turned, quiet()).unwrap();
    assert!((opened.chunks, opened.steps) == expected);
}

#[test]
fn a_flipped_byte_costs_its_record_and_names_it() {
    let folder = tempfile::tempdir().unwrap();
    twelve_edits(folder.path());
    let whole = Game::open(copy(folder.path()).path(), quiet()).0.voxels();
    let journal = std::fs::read(only_journal(folder.path())).unwrap();
    let chunks = std::fs::read(folder.path().join("chunks.log")).unwrap();
    let mut random = Random(5);
    let mut named = 0;
    for round in 0..150 {
        let broken = copy(folder.path());
        let in_journal = round % 2 == 0;
        let (path, bytes) = if in_journal {
            (only_journal(broken.path()), &journal)
        } else {
            (broken.path().join("chunks.log"), &chunks)
        };
        let mut bytes = bytes.clone();
        let at = random.next(bytes.len() as u64) as usize;
        bytes[at] ^= 1 << random.next(8);
        std::fs::write(&path, bytes).unwrap();
        let report = verify(broken.path()).unwrap();
        assert_eq!(report.damages.len(), 1, "byte {at}: {:?}", report.damages);
        let damage = &report.damages[0];
        assert!(damage.bytes.contains(&(at as u64)), "{damage}");
        named += usize::from(damage.what.contains("edit") && !damage.what.contains("followed"));
        let (game, _) = Game::open(broken.path(), quiet());
        let voxels = game.voxels();
        if in_journal {
            // The other edits of the journal were applied all the same.
            assert!(game.save.seq() >= 11, "byte {at}");
        } else if damage.what.starts_with("the chunk") {
            // Every other chunk is unchanged, except where the journal's edits met the lost one.
            let differ = whole.iter().filter(|(pos, chunk)| voxels.get(pos) != Some(chunk)).count();
            assert!(differ <= 1, "byte {at}: {differ} chunks differ");
        } else {
            assert!(voxels == whole, "byte {at}: {damage}");
        }
    }
    assert!(named > 100, "{named}");
}

#[test]
fn other_formats_generators_and_materials_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    twelve_edits(folder.path());
    let voxels = Game::open(copy(folder.path()).path(), quiet()).0.voxels();
    let open = |meta: &Meta, options| Save::open(copy(folder.path()).path(), meta, options);

    let other = Meta { generator: [8; 32], ..meta() };
    let error = open(&other, quiet()).unwrap_err().to_string();
    assert!(error.contains("0707070707070707 then, 0808080808080808 now"), "{error}");
    let keep = SaveOptions { keep_on_generator_change: true, ..quiet() };
    assert!(Game::start(open(&other, keep).unwrap()).voxels() == voxels);

    // Kept once, the save belongs to the new generator.
    let kept = copy(folder.path());
    drop(Save::open(kept.path(), &other, keep).unwrap());
    assert!(Game::start(Save::open(kept.path(), &other, quiet()).unwrap()).voxels() == voxels);

    // Materials in another order are found by their names.
    let mut turned = meta();
    turned.materials[1..].reverse();
    let opened = open(&turned, quiet()).unwrap();
    let count = meta().materials.len();
    for (pos, packed) in &opened.chunks {
        let theirs: Vec<u16> = std::iter::once(0).chain((1..count as u16).rev()).collect();
        let back = packed.remapped(&theirs).unwrap();
        assert!(verify(folder.path()).is_ok() && packed.unpack(count).is_some());
        assert_eq!(
            back.unpack(count).unwrap().map(|c| c.solids()),
            packed.unpack(count).unwrap().map(|c| c.solids()),
            "{pos:?}"
        );
    }
    assert_eq!(opened.steps.len(), 6);
    let gone = Meta { materials: vec!["air".to_owned(), "m1".to_owned()], ..meta() };
    let error = open(&gone, quiet()).unwrap_err();
    assert!(matches!(&error, SaveError::Materials { names } if names.contains(&"m2".to_owned())), "{error}");

    // A save of a newer program is left as it is.
    let newer = copy(folder.path());
    std::fs::write(newer.path().join("chunks.log"), include_bytes!("../newer.log")).unwrap();
    let error = Save::open(newer.path(), &meta(), quiet()).unwrap_err();
    assert!(matches!(error, SaveError::Newer { found: 3, known: 2 }), "{error}");
    assert_eq!(std::fs::read(newer.path().join("chunks.log")).unwrap(), include_bytes!("../newer.log"));
}

#[test]
fn two_at_once_and_places_that_cannot_be_written_are_read_only() {
    let folder = tempfile::tempdir().unwrap();
    twelve_edits(folder.path());
    let (mut first, _) = Game::open(folder.path(), quiet());
    let second = Save::open(folder.path(), &meta(), quiet()).unwrap();
    let why = second.read_only.clone().unwrap();
    assert!(why.contains("another process has"), "{why}");
    let mut second = Game::start(second);
    assert!(second.voxels() == first.voxels() && second.save.is_read_only());
    let operations = [script(13)];
    let change = second.edits.apply(&operations, &second.scene, &second.base).unwrap();
    assert!(!second.save.commit(&operations, &change).unwrap());
    assert!(second.save.poll(&second.edits).is_empty());
    first.play(13);
    drop(first);
    assert_eq!(Game::open(folder.path(), quiet()).0.save.seq(), 13);

    // A file stands where the folder should be made.
    let nowhere = folder.path().join("lock").join("save");
    let error = Save::open(&nowhere, &meta(), quiet()).unwrap_err();
    assert!(matches!(&error, SaveError::Place { why } if why.ends_with("lock` is a file")), "{error}");
}

/// The program on a disk that fills up.
#[test]
fn child_with_little_room() {
    let Ok(folder) = std::env::var("RAXEL_TEST_FULL") else { return };
    let limit = |bytes| {
        let limit = rustix::process::Rlimit { current: bytes, maximum: None };
        rustix::process::setrlimit(rustix::process::Resource::Fsize, limit).unwrap();
    };
    let (mut game, _) = Game::open(Path::new(&folder), quiet());
    game.play(1);
    limit(Some(900));
    let mut failed = 0;
    for n in 2..=60 {
        let operations = [script(n)];
        let change = game.edits.apply(&operations, &game.scene, &game.base).unwrap();
        failed += u32::from(game.save.commit(&operations, &change).is_err());
    }
    assert!(failed > 20, "{failed}");
    assert_eq!(game.save.poll(&game.edits), [], "it is not tried all the time");
    limit(None);
    let began = Instant::now();
    while game.save.poll(&game.edits) != [SaveEvent::Recovered] {
        assert!(began.elapsed() < Duration::from_secs(120));
        std::thread::sleep(Duration::from_millis(10));
    }
    // A checkpoint that does not fit changes nothing either.
    limit(Some(2000));
    assert!(matches!(game.save.checkpoint(&game.edits)[..], [SaveEvent::Failing { .. }]));
    limit(None);
    assert!(matches!(game.save.checkpoint(&game.edits)[..], [SaveEvent::Checkpoint { seq: 60, .. }]));
    println!("survived");
}

#[test]
fn a_full_disk_is_survived_and_everything_is_saved_later() {
    let folder = tempfile::tempdir().unwrap();
    // A file that grows beyond its limit is an error, and not the end of the program, when that signal is ignored.
    let script = "trap '' XFSZ; exec \"$0\" --exact child_with_little_room --nocapture";
    let mut command = Command::new("sh");
    command.args(["-c", script]).arg(std::env::current_exe().unwrap()).env("RAXEL_TEST_FULL", folder.path());
    let output = output(&mut command);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("survived"), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    let (game, damages) = Game::open(folder.path(), quiet());
    assert_eq!((game.save.seq(), damages), (60, Vec::new()));
    assert!(game.voxels() == replayed(60));
}

#[test]
fn compacting_and_packing_keep_everything() {
    let folder = tempfile::tempdir().unwrap();
    let (mut game, _) = Game::open(folder.path(), quiet());
    for n in 1..=20 {
        game.play(n);
        if n % 4 == 0 && n < 20 {
            game.save.checkpoint(&game.edits);
        }
    }
    let voxels = game.voxels();
    assert!(matches!(compact(folder.path()), Err(SaveError::ReadOnly { .. })), "it is open");
    drop(game);
    let before = verify(folder.path()).unwrap();
    assert!(
        before.replaced > 0 && before.damages.is_empty() && (before.applied, before.newest) == (16, 20),
        "{before:?}"
    );
    let packed = pack(folder.path()).unwrap();
    let Compacted { before: old, after: new } = compact(folder.path()).unwrap();
    assert!(new < old, "{old} {new}");
    let after = verify(folder.path()).unwrap();
    assert_eq!((after.replaced, after.chunks, after.newest), (0, before.chunks, 20));
    let elsewhere = tempfile::tempdir().unwrap();
    std::fs::write(elsewhere.path().join("chunks.log"), packed).unwrap();
    for folder in [folder.path(), elsewhere.path()] {
        for n in 21..23 {
            let (mut game, damages) = Game::open(folder, quiet());
            assert!(damages.is_empty(), "{damages:?}");
            assert!(n > 21 || game.voxels() == voxels);
            game.play(n);
        }
        let (game, _) = Game::open(folder, quiet());
        assert!(game.voxels() == replayed(22));
    }
}

#[test]
#[ignore = "a measurement"]
fn ten_thousand_edited_chunks_open_quickly() {
    let folder = tempfile::tempdir().unwrap();
    let (mut game, _) = Game::open(folder.path(), quiet());
    let operations: Vec<_> = (0..10_000_i64)
        .map(|n| {
            let center = [n % 22, n / 22 % 22, n / 484].map(|c| (c * 64 + 32) as f64);
            Operation::sphere(center, 20.0, Brush::Add(1 + (n % 5) as u16))
        })
        .collect();
    let change = game.edits.apply(&operations, &game.scene, &game.base).unwrap();
    assert!(change.chunks.len() >= 10_000);
    game.save.commit(&operations, &change).unwrap();
    game.save.checkpoint(&game.edits);
    drop(game);
    let began = Instant::now();
    let opened = Save::open(folder.path(), &meta(), quiet()).unwrap();
    let read = began.elapsed();
    let mut edits = Edits::default();
    edits.adopt(opened.chunks, scene().materials.len());
    assert_eq!(edits.unpack(), []);
    println!("{} chunks: read and checked in {read:?}, unpacked after {:?}", edits.positions().len(), began.elapsed());
}
