//! Small saves, damaged in every way that there is: no loss goes without a name.

use std::collections::BTreeMap;
use std::path::Path;

use raxel_edit::save::{Damage, Save, SaveOptions, compact};
use raxel_edit::{Operation, PackedChunk};
use raxel_world::ChunkPos;

use super::scenes::Random;
use super::{Game, meta, quiet, records};

/// The files of a save.
type Files = BTreeMap<String, Vec<u8>>;

fn files(folder: &Path) -> Files {
    let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
    let named = entries.map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap()));
    named.filter(|(name, _)| name != "lock").collect()
}

/// A folder whose files are exchanged again and again.
struct Place {
    folder: tempfile::TempDir,
    now: Files,
}

impl Place {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap(), now: Files::new() }
    }

    fn put(&mut self, files: &Files) {
        for name in self.now.keys().filter(|name| !files.contains_key(*name)) {
            std::fs::remove_file(self.folder.path().join(name)).unwrap();
        }
        for (name, bytes) in files.iter().filter(|(name, bytes)| self.now.get(*name) != Some(*bytes)) {
            std::fs::write(self.folder.path().join(name), bytes).unwrap();
        }
        self.now.clone_from(files);
    }

    fn read(&self) -> Found {
        let options = SaveOptions { read_only: true, ..quiet() };
        let opened = Save::open(self.folder.path(), &meta(), options).unwrap();
        Found { chunks: opened.chunks, steps: opened.steps, damages: opened.damages }
    }
}

struct Found {
    chunks: Vec<(ChunkPos, PackedChunk)>,
    steps: Vec<(u64, Vec<Operation>)>,
    damages: Vec<Damage>,
}

impl Found {
    fn is(&self, other: &Self) -> bool {
        (&self.chunks, &self.steps) == (&other.chunks, &other.steps)
    }

    fn is_named(&self) -> bool {
        self.damages.iter().any(|damage| !damage.unfinished)
    }
}

/// A save that is damaged.
struct Case {
    what: &'static str,
    files: Files,
    /// The files as they were after each edit.
    earlier: Vec<Files>,
}

impl Case {
    /// A save of edits of single voxels, which are few bytes.
    fn play(what: &'static str, material: u16, between: impl Fn(&Path, Game, i32) -> Game) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (mut game, _) = Game::open(folder.path(), quiet());
        let mut earlier = vec![files(folder.path())];
        for n in 1..=8 {
            game.commit(Operation::set([n * 40, 1000, 0], material));
            earlier.push(files(folder.path()));
            game = between(folder.path(), game, n);
            earlier.push(files(folder.path()));
        }
        Self { what, files: files(folder.path()), earlier }
    }

    fn all(material: u16) -> Vec<Self> {
        let again = |folder: &Path, game: Game| {
            drop(game);
            Game::open(folder, quiet()).0
        };
        vec![
            Self::play("one journal", material, |_, game, _| game),
            Self::play(
                "several journals",
                material,
                move |folder, game, n| {
                    if n % 3 == 0 { again(folder, game) } else { game }
                },
            ),
            Self::play("a checkpoint and a journal", material, |_, mut game, n| {
                if n % 3 == 0 {
                    game.save.checkpoint(&game.edits);
                }
                game
            }),
            Self::play("a checkpoint of everything", material, |_, mut game, n| {
                if n % 4 == 0 {
                    game.save.checkpoint(&game.edits);
                }
                game
            }),
            Self::play("written anew", material, move |folder, mut game, n| {
                if n == 2 {
                    game.save.checkpoint(&game.edits);
                }
                if n != 5 {
                    return game;
                }
                drop(game);
                compact(folder).unwrap();
                Game::open(folder, quiet()).0
            }),
            Self::interrupted(material),
        ]
    }

    /// Killed when half of a checkpoint was written: its journals are there.
    fn interrupted(material: u16) -> Self {
        let mut case = Self::play("killed in a checkpoint", material, |_, game, _| game);
        let later = Self::play("", material, |_, mut game, n| {
            if n == 8 {
                game.save.checkpoint(&game.edits);
            }
            game
        });
        let chunks = &later.files["chunks.log"];
        let open = chunks[..records(chunks)[8]].to_vec();
        assert!(open.len() > case.files["chunks.log"].len());
        case.files.insert("chunks.log".to_owned(), open);
        // The journal that the checkpoint has begun.
        case.files.insert("journal-000002.log".to_owned(), later.files["journal-000002.log"].clone());
        case.files.insert("tail".to_owned(), later.files["tail"].clone());
        case
    }

    /// Tries damages. Each is a complete set of files. Says how many were losses.
    fn judge(&self, damages: impl IntoIterator<Item = (String, Files)>) -> [usize; 2] {
        let mut place = Place::new();
        place.put(&self.files);
        let whole = place.read();
        assert!(!whole.is_named(), "{}: {:?}", self.what, whole.damages);
        let mut counts = [0; 2];
        for (what, files) in damages {
            place.put(&files);
            let found = place.read();
            assert!(found.is(&whole) || found.is_named(), "{}: {what}: {:?}", self.what, found.damages);
            counts[usize::from(!found.is(&whole))] += 1;
        }
        counts
    }

    fn with(&self, name: &str, bytes: Vec<u8>) -> Files {
        let mut files = self.files.clone();
        files.insert(name.to_owned(), bytes);
        files
    }
}

/// Flips `each` of the eight bits of every byte.
fn flip(each: usize) {
    for case in Case::all(1) {
        let bits = case.files.iter().flat_map(|(name, bytes)| (0..bytes.len() * each).map(move |n| (name, bytes, n)));
        let counts = case.judge(bits.map(|(name, bytes, n)| {
            let (at, bit) = (n / each, (n % each + n / each) % 8);
            let mut bytes = bytes.clone();
            bytes[at] ^= 1 << bit;
            (format!("{name}: bit {bit} of byte {at}"), case.with(name, bytes))
        }));
        assert!(counts[1] > 100, "{}: {counts:?}", case.what);
    }
}

#[test]
fn a_flipped_bit_of_every_byte_is_named_or_costs_nothing() {
    flip(1);
}

#[test]
#[ignore = "takes a minute"]
fn every_flipped_bit_is_named_or_costs_nothing() {
    flip(8);
}

#[test]
fn every_cut_is_named_or_costs_nothing() {
    for case in Case::all(1) {
        let ends = case.files.iter().flat_map(|(name, bytes)| (0..bytes.len()).map(move |end| (name, bytes, end)));
        let counts = case.judge(
            ends.map(|(name, bytes, end)| (format!("{name} cut at {end}"), case.with(name, bytes[..end].to_vec()))),
        );
        assert!(counts[1] > 100, "{}: {counts:?}", case.what);
    }
}

#[test]
fn every_range_of_records_that_is_cut_out_is_named_or_costs_nothing() {
    for case in Case::all(1) {
        let mut all = Vec::new();
        for (name, bytes) in &case.files {
            let ends: Vec<usize> = records(bytes).into_iter().chain([bytes.len()]).collect();
            for (first, from) in ends.iter().enumerate() {
                for to in &ends[first + 1..] {
                    let rest = [&bytes[..*from], &bytes[*to..]].concat();
                    all.push((format!("{name} without {from}..{to}"), case.with(name, rest)));
                }
            }
        }
        assert!(case.judge(all)[1] > 5, "{}", case.what);
    }
}

#[test]
fn every_removal_and_every_exchange_of_files_is_named_or_costs_nothing() {
    // The same edits with another material, and the same files by name.
    for (case, other) in Case::all(1).into_iter().zip(Case::all(2)) {
        let names: Vec<&String> = case.files.keys().collect();
        let mut all = Vec::new();
        for removed in 1..(1 << names.len()) - 1_u32 {
            let mut left = case.files.clone();
            let gone: Vec<&&String> =
                (names.iter().enumerate()).filter(|(n, _)| removed >> n & 1 == 1).map(|(_, name)| name).collect();
            left.retain(|name, _| !gone.iter().any(|gone| **gone == name));
            all.push((format!("without {gone:?}"), left));
        }
        for from in &names {
            for to in names.iter().filter(|to| *to != from) {
                let copied = case.with(to, case.files[*from].clone());
                let mut renamed = copied.clone();
                renamed.remove(*from);
                let mut swapped = copied.clone();
                swapped.insert((*from).clone(), case.files[*to].clone());
                all.push((format!("{from} renamed to {to}"), renamed));
                all.push((format!("{from} copied over {to}"), copied));
                all.push((format!("{from} and {to} swapped"), swapped));
            }
            all.push((format!("{from} of another save"), case.with(from, other.files[*from].clone())));
            for (n, earlier) in case.earlier.iter().enumerate().filter_map(|(n, files)| Some((n, files.get(*from)?))) {
                all.push((format!("{from} as it was at {n}"), case.with(from, earlier.clone())));
            }
        }
        assert!(case.judge(all)[1] > 5, "{}", case.what);
    }
}

#[test]
fn a_damaged_save_is_written_on_and_its_losses_are_named_until_it_is_written_anew() {
    let mut random = Random(11);
    for case in Case::all(1) {
        for _ in 0..12 {
            let mut place = Place::new();
            let mut files = case.files.clone();
            for _ in 0..=random.next(2) {
                let Some(name) = files.keys().nth(random.next(files.len() as u64) as usize).cloned() else { continue };
                let bytes = files.get_mut(&name).unwrap();
                let at = random.next(bytes.len() as u64 + 1) as usize;
                match random.next(3) {
                    0 => bytes.truncate(at),
                    1 => bytes.iter_mut().skip(at.saturating_sub(3)).take(3).for_each(|byte| *byte ^= 0x55),
                    _ => _ = files.remove(&name),
                }
                files.retain(|_, bytes| !bytes.is_empty());
            }
            place.put(&files);
            let before = place.read();
            let (mut game, _) = Game::open(place.folder.path(), quiet());
            game.commit(Operation::set([-1000, 0, 0], 1));
            let (voxels, seq) = (game.voxels(), game.save.seq());
            drop(game);
            let (mut game, again) = Game::open(place.folder.path(), quiet());
            assert!(game.voxels() == voxels && game.save.seq() == seq, "{}: {:?} {again:?}", case.what, before.damages);
            game.save.checkpoint(&game.edits);
            drop(game);
            compact(place.folder.path()).unwrap();
            let (game, last) = Game::open(place.folder.path(), quiet());
            assert!(game.voxels() == voxels && last.is_empty(), "{}: {last:?}", case.what);
        }
    }
}

/// The numbers behind the largest ones would be no numbers. Sums that are right do not make them edits.
#[test]
fn numbers_that_no_save_reaches_are_damage() {
    let folder = tempfile::tempdir().unwrap();
    let (mut game, _) = Game::open(folder.path(), quiet());
    (1..=3).for_each(|n| game.play(n));
    drop(game);
    let mut files = files(folder.path());
    let journal = files.values_mut().find(|bytes| records(bytes).len() > 4).unwrap();
    let last = journal.windows(4).rposition(|magic| magic == b"RXV2").unwrap();
    journal[last + 12..last + 20].copy_from_slice(&u64::MAX.to_le_bytes());
    let sum = crc32c::crc32c(&journal[last..last + 40]);
    journal[last + 40..last + 44].copy_from_slice(&sum.to_le_bytes());
    let mut place = Place::new();
    place.put(&files);
    let found = place.read();
    assert_eq!(found.steps.iter().map(|(seq, _)| *seq).collect::<Vec<_>>(), [1, 2]);
    assert!(found.damages.iter().any(|damage| !damage.unfinished), "{:?}", found.damages);
    // The tail alone.
    let tail = files.get_mut("tail").unwrap();
    for slot in tail.chunks_exact_mut(36) {
        slot[20..28].copy_from_slice(&u64::MAX.to_le_bytes());
        let sum = crc32c::crc32c(&slot[..32]);
        slot[32..].copy_from_slice(&sum.to_le_bytes());
    }
    place.put(&files);
    assert!(place.read().damages.iter().any(|damage| damage.file == "tail"));
}
