//! Each call to the system that changes a save fails in turn, or is the last before the program or the machine stops.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use glam::IVec3;
use raxel_world::{ChunkPos, Material, World};

use super::disk::{Disk, Storage, System};
use super::verify::{compact_on, pack};
use super::{Meta, Save, SaveEvent, SaveOptions};
use crate::edits::Edits;
use crate::operation::Operation;
use crate::scene::Scene;

/// The fate of one call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    /// It fails, a write half way; those after it work.
    Once,
    /// It is the last: the program is killed in it, a write half way.
    Stop,
}

/// The part of a file that is on the disk.
#[derive(Clone, Debug, Default)]
struct Disked {
    /// As it was at the last sync.
    synced: Vec<u8>,
    /// As the program sees it.
    now: Vec<u8>,
    /// Bytes that a failed sync has dropped, which no later one brings to the disk, and the bytes there instead.
    dropped: BTreeMap<usize, u8>,
}

impl Disked {
    fn sync(&mut self) {
        self.synced.clone_from(&self.now);
        for (&at, &byte) in &self.dropped {
            self.synced[at] = byte;
        }
    }

    fn drop_unsynced(&mut self) {
        for (at, byte) in self.now.iter().enumerate() {
            let old = self.synced.get(at).copied();
            if old != Some(*byte) {
                self.dropped.insert(at, old.unwrap_or(0));
            }
        }
    }

    fn write(&mut self, at: usize, bytes: &[u8]) {
        self.now.resize(self.now.len().max(at + bytes.len()), 0);
        self.now[at..at + bytes.len()].copy_from_slice(bytes);
        self.dropped.retain(|byte, _| !(at..at + bytes.len()).contains(byte));
    }

    fn truncate(&mut self, bytes: usize) {
        self.now.truncate(bytes);
        self.dropped.retain(|at, _| *at < bytes);
    }
}

struct State {
    fault: Option<(usize, Fault)>,
    calls: usize,
    names: BTreeMap<PathBuf, usize>,
    files: Vec<Disked>,
}

/// A disk that counts its calls.
#[derive(Clone)]
struct Faulty(Arc<Mutex<State>>);

struct FaultyFile {
    disk: Faulty,
    file: Arc<dyn Storage>,
    id: usize,
}

/// How much of a call is done.
#[derive(PartialEq, Eq)]
enum Done {
    Whole,
    Half,
    Nothing,
}

impl Faulty {
    fn new(fault: Option<(usize, Fault)>) -> Self {
        Self(Arc::new(Mutex::new(State { fault, calls: 0, names: BTreeMap::new(), files: Vec::new() })))
    }

    fn with<T>(&self, look: impl FnOnce(&mut State) -> T) -> T {
        look(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn calls(&self) -> usize {
        self.with(|state| state.calls)
    }

    fn next(&self) -> Done {
        self.with(|state| {
            let call = state.calls;
            state.calls += 1;
            match state.fault {
                Some((at, _)) if call == at => Done::Half,
                Some((at, Fault::Stop)) if call > at => Done::Nothing,
                _ => Done::Whole,
            }
        })
    }

    /// A call that is done or is not.
    fn whole(&self) -> io::Result<()> {
        if self.next() == Done::Whole { Ok(()) } else { Err(io::Error::other("EIO")) }
    }

    fn file(&self, path: &Path, file: Arc<dyn Storage>, there: Vec<u8>) -> Arc<dyn Storage> {
        let id = self.with(|state| {
            state.files.push(Disked { synced: there.clone(), now: there, ..Disked::default() });
            state.names.insert(path.to_owned(), state.files.len() - 1);
            state.files.len() - 1
        });
        Arc::new(FaultyFile { disk: self.clone(), file, id })
    }

    /// The power fails: of files that were written, some or all are as they were at their last sync.
    fn cut_power(&self, mut is_lost: impl FnMut() -> bool) {
        self.with(|state| {
            for (path, id) in state.names.iter().filter(|(path, _)| path.exists()) {
                if is_lost() {
                    std::fs::write(path, &state.files[*id].synced).unwrap();
                }
            }
        });
    }
}

impl Disk for Faulty {
    fn create(&self, path: &Path) -> io::Result<Arc<dyn Storage>> {
        self.whole()?;
        Ok(self.file(path, System.create(path)?, Vec::new()))
    }

    fn open(&self, path: &Path) -> io::Result<(Arc<dyn Storage>, u64)> {
        self.whole()?;
        let there = std::fs::read(path).unwrap_or_default();
        let (file, bytes) = System.open(path)?;
        Ok((self.file(path, file, there), bytes))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.whole()?;
        System.rename(from, to)?;
        self.with(|state| {
            let id = state.names.remove(from).unwrap();
            state.names.insert(to.to_owned(), id);
        });
        Ok(())
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        self.whole()?;
        self.with(|state| state.names.remove(path));
        System.remove(path)
    }

    fn sync_folder(&self, _: &Path) -> io::Result<()> {
        self.whole()
    }
}

impl Storage for FaultyFile {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        let done = self.disk.next();
        let written = match done {
            Done::Whole => bytes,
            Done::Half => &bytes[..bytes.len() / 2],
            Done::Nothing => &[],
        };
        self.file.append(written)?;
        self.disk.with(|state| {
            let end = state.files[self.id].now.len();
            state.files[self.id].write(end, written);
        });
        if done == Done::Whole { Ok(()) } else { Err(ErrorKind::StorageFull.into()) }
    }

    fn write_at(&self, at: u64, bytes: &[u8]) -> io::Result<()> {
        // A few bytes in one page: no kill divides them, though an error may.
        let (done, stops) = (self.disk.next(), self.disk.with(|state| matches!(state.fault, Some((_, Fault::Stop)))));
        let written = match done {
            Done::Whole => bytes,
            Done::Half if !stops => &bytes[..bytes.len() / 2],
            _ => &[],
        };
        self.file.write_at(at, written)?;
        self.disk.with(|state| state.files[self.id].write(at as usize, written));
        if done == Done::Whole { Ok(()) } else { Err(io::Error::other("EIO")) }
    }

    fn truncate(&self, bytes: u64) -> io::Result<()> {
        self.disk.whole()?;
        self.disk.with(|state| state.files[self.id].truncate(bytes as usize));
        self.file.truncate(bytes)
    }

    fn sync(&self) -> io::Result<()> {
        let done = self.disk.whole();
        self.disk.with(|state| {
            let file = &mut state.files[self.id];
            if done.is_ok() { file.sync() } else { file.drop_unsynced() }
        });
        done
    }
}

fn meta() -> Meta {
    let materials = vec!["air".to_owned(), "stone".to_owned()];
    Meta { format: 0, world: "worlds/test.toml".to_owned(), generator: [7; 32], materials }
}

fn quiet() -> SaveOptions {
    let hour = Duration::from_secs(3600);
    SaveOptions { checkpoint: hour, sync: hour, journal_bytes: u64::MAX, ..SaveOptions::default() }
}

/// The scenario: edits over a world with one voxel.
struct Game {
    base: World,
    scene: Scene,
    edits: Edits,
}

impl Game {
    fn new() -> Self {
        let materials = vec![Material::air(), Material::matt("stone".to_owned(), [0.5; 3])];
        let scene = Scene::new(&materials, &[]);
        Self { base: World::from_voxels(materials, [(IVec3::ZERO, 1)]), scene, edits: Edits::default() }
    }

    /// Takes over a save that was opened.
    fn adopt(&mut self, folder: &Path, disk: Arc<dyn Disk>) -> Option<(Save, bool)> {
        let opened = Save::open_on(disk, folder, &meta(), quiet()).ok()?;
        let named = opened.damages.iter().any(|damage| !damage.unfinished);
        let mut save = opened.save;
        self.edits.adopt(opened.chunks, 2);
        for (_, operations) in opened.steps {
            save.replayed(&self.edits.replay(&operations, &self.scene, &self.base).unwrap());
        }
        Some((save, named))
    }

    /// Edit n is a voxel in a chunk of its own.
    fn commit(&mut self, save: &mut Save) -> io::Result<bool> {
        let operations = [Operation::set([(save.seq() as i32 + 1) * 64, 1000, 0], 1)];
        let change = self.edits.apply(&operations, &self.scene, &self.base).unwrap();
        save.commit(&operations, &change)
    }

    fn has(&self, edit: u64) -> bool {
        self.edits.packed(ChunkPos::new(edit as i32, 1000 / 64, 0)).is_some_and(|chunk| !chunk.bytes().is_empty())
    }
}

/// The newest edits that survive the end of the program, and a power cut.
#[derive(Clone, Copy, Debug, Default)]
struct Promised {
    kill: u64,
    power: u64,
}

/// Opens a save and plays on.
fn play(disk: &Faulty, folder: &Path, before: u64) -> Promised {
    let mut promised = Promised { kill: before, power: before };
    let mut game = Game::new();
    let Some((mut save, _)) = game.adopt(folder, Arc::new(disk.clone())) else { return promised };
    if save.is_read_only() {
        return promised;
    }
    assert_eq!(save.seq(), before);
    let note = |promised: &mut Promised, events: Vec<SaveEvent>, newest: u64| {
        for event in events {
            match event {
                SaveEvent::Checkpoint { seq, .. } => promised.power = promised.power.max(seq),
                SaveEvent::Recovered => promised.kill = newest,
                SaveEvent::Failing { .. } => {}
            }
        }
    };
    for step in 0..7 {
        if matches!(game.commit(&mut save), Ok(true)) {
            promised.kill = save.seq();
        }
        if step % 2 == 1 && save.sync().is_ok() {
            promised.power = promised.kill;
        }
        if step == 2 || step == 5 {
            note(&mut promised, save.checkpoint(&game.edits), save.seq());
        }
        note(&mut promised, save.poll(&game.edits), save.seq());
    }
    promised.kill = promised.kill.max(promised.power);
    promised
}

/// A folder with a save of three edits, and without one.
fn beginnings() -> Vec<(tempfile::TempDir, u64)> {
    let saved = |edits: u64, middle: bool| {
        let folder = tempfile::tempdir().unwrap();
        let mut game = Game::new();
        let (mut save, _) = game.adopt(folder.path(), Arc::new(Faulty::new(None))).unwrap();
        for n in 0..edits {
            game.commit(&mut save).unwrap();
            if n == 1 && middle {
                save.checkpoint(&game.edits);
            }
        }
        folder
    };
    let packed = tempfile::tempdir().unwrap();
    std::fs::write(packed.path().join("chunks.log"), pack(saved(3, true).path()).unwrap()).unwrap();
    vec![(tempfile::tempdir().unwrap(), 0), (saved(3, false), 3), (saved(3, true), 3), (packed, 3)]
}

fn copy(from: &Path) -> tempfile::TempDir {
    let to = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        std::fs::copy(entry.path(), to.path().join(entry.file_name())).unwrap();
    }
    to
}

/// Opens the rest of the save, and compares it with the synced bytes.
fn judge(folder: &Path, promised: u64, may_name: bool, what: &str) {
    let mut game = Game::new();
    let (mut save, named) = game.adopt(folder, Arc::new(Faulty::new(None))).unwrap();
    let newest = save.seq();
    assert!(newest >= promised, "{what}: edit {promised} was promised, and the save ends at {newest}");
    let missing: Vec<u64> = (1..=newest).filter(|edit| !game.has(*edit)).collect();
    assert!(missing.iter().all(|edit| *edit > promised), "{what}: {missing:?} of {promised} are gone");
    assert!(
        may_name || (missing.is_empty() && !named),
        "{what}: {missing:?} are gone, or damage is named that is none"
    );
    // And it goes on.
    game.commit(&mut save).unwrap();
    drop(save);
    let (save, _) = Game::new().adopt(folder, Arc::new(Faulty::new(None))).unwrap();
    assert_eq!(save.seq(), newest + 1, "{what}");
}

#[test]
fn any_call_that_fails_or_is_the_last_costs_nothing_that_was_promised() {
    for (number, (beginning, edits)) in beginnings().into_iter().enumerate() {
        for fault in [Fault::Once, Fault::Stop] {
            for call in 0.. {
                let folder = copy(beginning.path());
                let disk = Faulty::new(Some((call, fault)));
                let promised = play(&disk, folder.path(), edits);
                let what = format!("beginning {number}, {fault:?}, call {call}");
                judge(folder.path(), promised.kill, false, &what);
                if disk.calls() <= call {
                    assert!(call > 40, "{what}");
                    break;
                }
            }
        }
    }
}

#[test]
fn a_power_cut_at_any_call_costs_nothing_that_was_synced() {
    for (number, (beginning, edits)) in beginnings().into_iter().enumerate() {
        for fault in [Fault::Once, Fault::Stop] {
            for (call, lost) in (0..).flat_map(|call| [(call, 0), (call, 1 + call % 3)]) {
                let folder = copy(beginning.path());
                let disk = Faulty::new(Some((call, fault)));
                let promised = play(&disk, folder.path(), edits);
                let mut n = 0;
                // All files, or every second, third or fourth.
                disk.cut_power(|| {
                    n += 1;
                    n % (lost + 1) == 0
                });
                let what = format!("beginning {number}, {fault:?}, call {call}, every {} is lost", lost + 1);
                judge(folder.path(), promised.power, true, &what);
                if disk.calls() <= call {
                    break;
                }
            }
        }
    }
}

#[test]
fn writing_a_save_anew_can_stop_or_fail_at_any_call() {
    for (beginning, edits) in beginnings().into_iter().skip(1) {
        for fault in [Fault::Once, Fault::Stop] {
            for call in 0.. {
                let [killed, cut] = [0, 1].map(|_| copy(beginning.path()));
                let what = format!("{fault:?}, call {call}");
                let disk = Faulty::new(Some((call, fault)));
                let done = compact_on(&disk, killed.path()).is_ok();
                judge(killed.path(), edits, false, &what);
                let disk = Faulty::new(Some((call, fault)));
                let _ = compact_on(&disk, cut.path());
                disk.cut_power(|| true);
                judge(cut.path(), edits, false, &what);
                if done {
                    assert!(call > 8, "{what}");
                    break;
                }
            }
        }
    }
}
