//! Compares the shown target with a picture that was kept (a copy of a target, or a file), or with another target of the running graph.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread::{self, JoinHandle};

use raxel_execute::{Comparison, ExecuteError, ReadTicket, Reference, Texels};
use raxel_graph::checked::Display;
use raxel_panels::view::{Compare, CompareMode, Figures};
use raxel_runtime::Session;
use raxel_runtime::debug_target::DebugTarget;
use raxel_workbench::kept::{self, Kept, Pixels, VALUES, What};

/// Pixels beside the edge of a wipe where a press takes hold of it.
const GRIP: f64 = 8.0;

/// The comparison of the shown target with another picture.
pub(crate) struct Comparing {
    picture: Option<Held>,
    mode: CompareMode,
    flipped: bool,
    /// Share of the window's width.
    edge: f64,
    /// The left button holds the edge.
    held: bool,
    gain: f32,
    figures: Figures,
    /// Why the two cannot be compared, as reported last.
    refused: Option<String>,
    /// Why the running graph has no live target of this name.
    missing: Option<String>,
    /// The picture that will be kept.
    awaited: Option<Awaited>,
    /// Requests to keep a picture, or none, so far: the number of the last one.
    asked: u64,
    /// Each thread that reads a file has a clone.
    reading: Arc<()>,
    /// On its way: a picture to the device, the figures.
    uploading: Option<Uploading>,
    measuring: Option<Receiver<Figures>>,
    /// The shown target, on its way from the device to be measured.
    copying: Option<Copying>,
}

/// Threads that read files at most: pictures that were given up are still being read.
const MOST_READERS: usize = 3;

/// A picture that was asked for.
struct Awaited {
    name: String,
    from: Coming,
}

/// Where a picture comes from that will be kept.
pub(crate) enum Coming {
    /// A copy of a target, on its way from the device.
    Copy(ReadTicket<Texels>),
    /// Another thread makes it. It is a copy of a target, or a file.
    Thread {
        /// The picture, or why there is none.
        made: Receiver<Result<Kept, String>>,
        /// It is a copy of a target.
        copied: bool,
    },
    /// It is there, or whoever asks brings it by [`Comparing::keep`].
    Asker,
}

/// A copy of the shown target at the end of a frame, to be measured.
struct Copying {
    /// The name of the one that is shown.
    of: String,
    shown: ReadTicket<Texels>,
    kept: Against,
}

/// What the shown target is measured against.
enum Against {
    /// A copy of a live target at the end of the same frame.
    Live(ReadTicket<Texels>),
    /// A picture that was kept, with the way in which the target is shown.
    Still(Pixels, Display),
}

/// The texels of a ticket that has arrived.
fn texels(ticket: &ReadTicket<Texels>) -> Result<Texels, String> {
    match ticket.poll() {
        Ok(Some(texels)) => Ok(texels),
        Ok(None) => Err("the target was not copied".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

impl Copying {
    /// Whether all copies are there. One that was lost with its device is reported by [`Self::figures`].
    fn has_arrived(&self) -> bool {
        let live = match &self.kept {
            Against::Live(live) => Some(live),
            Against::Still(..) => None,
        };
        live.into_iter().chain([&self.shown]).all(|ticket| ticket.has_arrived().unwrap_or(true))
    }

    fn figures(self) -> Figures {
        let Self { of, shown, kept } = self;
        // Tickets hold memory of the device, so they end before the pictures are compared.
        let shown = texels(&{ shown });
        let kept = match kept {
            Against::Live(live) => texels(&{ live }).map(|live| (Pixels::Texels(live.into()), VALUES)),
            Against::Still(pixels, display) => Ok((pixels, display)),
        };
        match kept.and_then(|kept| Ok((kept, shown?))) {
            Ok(((kept, display), shown)) => figures(&kept, of, &shown, &display),
            Err(error) => Figures::Refused(error),
        }
    }
}

/// A reference on its way to a device. Its thread ends before this does: a driver that is still at work when the process ends may crash, since its own
/// ends run then.
struct Uploading {
    device: u64,
    made: Receiver<Result<Reference, ExecuteError>>,
    thread: Option<JoinHandle<()>>,
}

impl Uploading {
    fn start(device: u64, make: impl FnOnce() -> Result<Reference, ExecuteError> + Send + 'static) -> Self {
        let (send, made) = channel();
        let thread = thread::spawn(move || {
            // It is dropped if another picture was kept meanwhile.
            let _ = send.send(make());
        });
        Self { device, made, thread: Some(thread) }
    }
}

impl Drop for Uploading {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            // A panic of the thread was shown when it happened.
            let _ = thread.join();
        }
    }
}

/// The kept picture.
struct Held {
    kept: Kept,
    /// On which device it is, by its number, or why it could not be put there.
    on_device: Option<(u64, Result<Arc<Reference>, String>)>,
}

impl Default for Comparing {
    fn default() -> Self {
        Self {
            picture: None,
            mode: CompareMode::Off,
            flipped: false,
            edge: 0.5,
            held: false,
            gain: 1.0,
            figures: Figures::None,
            refused: None,
            missing: None,
            awaited: None,
            asked: 0,
            reading: Arc::default(),
            uploading: None,
            measuring: None,
            copying: None,
        }
    }
}

impl Comparing {
    /// A picture will be kept. Gives the number of the request, and a message if another picture is given up for it.
    pub(crate) fn ask(&mut self, name: &str, from: Coming) -> (u64, Option<String>) {
        self.asked += 1;
        let said = self.give_up(&format!("{name} was asked for after it"));
        self.awaited = Some(Awaited { name: name.to_owned(), from });
        (self.asked, said)
    }

    /// Gives up the picture that was asked for. Returns a message if there is one.
    fn give_up(&mut self, why: &str) -> Option<String> {
        let Awaited { name, .. } = self.awaited.take()?;
        Some(format!("{name} is not kept: {why}"))
    }

    /// The picture of this request does not come.
    pub(crate) fn give_up_number(&mut self, number: u64, why: &str) -> Option<String> {
        if number == self.asked { self.give_up(why) } else { None }
    }

    /// Compares with this from now on. False if another picture was asked for after the request of this number: that one is kept.
    pub(crate) fn keep(&mut self, kept: Kept, number: u64) -> bool {
        if number != self.asked {
            return false;
        }
        self.awaited = None;
        (self.picture, self.missing) = (Some(Held { kept, on_device: None }), None);
        (self.uploading, self.measuring, self.copying, self.figures) = (None, None, None, Figures::None);
        if self.mode == CompareMode::Off {
            self.mode = CompareMode::Wipe;
        }
        true
    }

    /// The kept picture.
    pub(crate) fn kept(&self) -> Option<&Kept> {
        self.picture.as_ref().map(|held| &held.kept)
    }

    /// Reads a picture from a file on a thread of its own; [`Self::update`] reports the result. Returns a message.
    pub(crate) fn load(&mut self, path: &Path, name: &str) -> Option<String> {
        if Arc::strong_count(&self.reading) > MOST_READERS {
            return Some(format!("{name} is not read: {MOST_READERS} other files are being read"));
        }
        let (path, named, reading) = (path.to_owned(), name.to_owned(), self.reading.clone());
        let (send, made) = channel();
        thread::spawn(move || {
            let kept = Kept::read(&path, &named);
            drop(reading);
            // A window that was closed does not wait for it.
            let _ = send.send(kept);
        });
        self.ask(name, Coming::Thread { made, copied: false }).1
    }

    /// Lets go of the kept picture. Returns a message if another one was on its way.
    pub(crate) fn forget(&mut self) -> Option<String> {
        let said = self.give_up("the comparison has ended");
        let (asked, reading) = (self.asked + 1, self.reading.clone());
        *self = Self { edge: self.edge, gain: self.gain, asked, reading, ..Self::default() };
        said
    }

    /// Whether something is kept.
    pub(crate) fn is_on(&self) -> bool {
        self.picture.is_some()
    }

    /// Another way of showing both.
    pub(crate) fn set_mode(&mut self, mode: CompareMode) {
        (self.mode, self.flipped) = (mode, false);
    }

    /// The next way of showing both.
    pub(crate) fn next_mode(&mut self) -> CompareMode {
        let at = CompareMode::ALL.iter().position(|mode| *mode == self.mode).unwrap_or(0);
        self.set_mode(CompareMode::ALL[(at + 1) % CompareMode::ALL.len()]);
        self.mode
    }

    /// Shows the kept picture alone, or not any more.
    pub(crate) fn flip(&mut self) {
        self.set_flipped(!self.flipped);
    }

    /// Shows the kept picture alone, or both.
    pub(crate) fn set_flipped(&mut self, flipped: bool) {
        self.flipped = flipped;
    }

    /// The factor of differences.
    pub(crate) fn set_gain(&mut self, gain: f32) {
        if gain.is_finite() {
            self.gain = gain.clamp(0.01, 1e5);
        }
    }

    /// Takes hold of the edge of the wipe, where a pixel of a window of this width is on it.
    pub(crate) fn hold_edge(&mut self, x: f64, width: u32, session: &Session) -> bool {
        self.held = self.view(session).has_edge() && (x - self.edge * f64::from(width)).abs() <= GRIP;
        self.held
    }

    /// Puts the edge that is held at a pixel.
    pub(crate) fn drag_edge(&mut self, x: f64, width: u32) {
        if self.held {
            self.edge = (x / f64::from(width.max(1))).clamp(0.0, 1.0);
        }
    }

    /// Lets go of the edge.
    pub(crate) fn release_edge(&mut self) {
        self.held = false;
    }

    /// Before a frame: takes the results of other threads, and sets the session's view. Returns messages.
    pub(crate) fn update(&mut self, session: &mut Session) -> Option<String> {
        let said = self.take_awaited();
        if let Some(figures) = self.measuring.as_ref().and_then(|measuring| measuring.try_recv().ok()) {
            (self.figures, self.measuring) = (figures, None);
        }
        self.take_copies();
        self.upload(session);
        let comparison = match (self.flipped, self.mode) {
            (true, _) => Some(Comparison::Reference),
            (false, CompareMode::Off) => None,
            (false, CompareMode::Wipe) => Some(Comparison::Wipe(self.edge)),
            (false, CompareMode::Difference) => Some(Comparison::Difference(self.gain)),
        };
        match (self.live(), comparison) {
            (Some(target), Some(comparison)) => {
                let compared = session.compare_live(target, comparison);
                self.missing = compared.err().map(|error| error.to_string());
            }
            _ => session.set_comparison(self.reference(session).cloned().zip(comparison)),
        }
        said.or_else(|| self.refusal(session))
    }

    /// The target that is compared with as it goes on.
    fn live(&self) -> Option<&DebugTarget> {
        match &self.kept()?.what {
            What::Live(target) => Some(target),
            What::Still(_) => None,
        }
    }

    /// Why the two cannot be compared, when that is news.
    fn refusal(&mut self, session: &Session) -> Option<String> {
        let refused = self.view(session).refused;
        let news = refused.clone().filter(|_| refused != self.refused);
        self.refused = refused;
        news
    }

    /// Takes the picture that was asked for, once it is there. Returns a message.
    fn take_awaited(&mut self) -> Option<String> {
        let Awaited { name, from } = self.awaited.as_mut()?;
        if let Coming::Copy(_) = from {
            let ready = |from: &Coming| matches!(from, Coming::Copy(ticket) if ticket.has_arrived().unwrap_or(true));
            if !ready(from) {
                return None;
            }
            let (send, made) = channel();
            // The bytes of a large target take longer than a frame may.
            if let Coming::Copy(ticket) = std::mem::replace(from, Coming::Thread { made, copied: true }) {
                let name = name.clone();
                thread::spawn(move || {
                    let texels = texels(&{ ticket });
                    // A window that was closed does not wait for it.
                    let _ = send.send(texels.map(|texels| Kept::copy(&name, texels)));
                });
            }
        }
        let Coming::Thread { made, copied } = from else { return None };
        match made.try_recv() {
            Ok(Ok(kept)) => {
                let name = &kept.name;
                let said = if *copied { kept_message(name) } else { format!("compares with {name}") };
                self.keep(kept, self.asked);
                Some(said)
            }
            Ok(Err(error)) => {
                self.awaited = None;
                Some(error)
            }
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => self.give_up("it cannot be loaded"),
        }
    }

    /// Puts the kept picture on the session's device, on a thread of its own: once, and again after a loss of the device.
    fn upload(&mut self, session: &Session) {
        let Some(Held { kept, on_device }) = &mut self.picture else { return };
        let What::Still(pixels) = &kept.what else { return };
        let device = session.device().id();
        if let Some(uploading) = self.uploading.take_if(|uploading| uploading.device == device) {
            match uploading.made.try_recv() {
                Ok(made) => {
                    *on_device = Some((device, made.map(Arc::new).map_err(|error| error.to_string())));
                }
                Err(TryRecvError::Empty) => self.uploading = Some(uploading),
                Err(TryRecvError::Disconnected) => {
                    *on_device = Some((device, Err("the kept picture did not reach the device".to_owned())));
                }
            }
        }
        let known = on_device.as_ref().is_some_and(|(on, _)| *on == device);
        if known || self.uploading.as_ref().is_some_and(|uploading| uploading.device == device) {
            return;
        }
        let (builder, pixels) = (session.builder(), pixels.clone());
        self.uploading = Some(Uploading::start(device, move || pixels.reference(&builder)));
    }

    fn reference(&self, session: &Session) -> Option<&Arc<Reference>> {
        let (device, made) = self.picture.as_ref()?.on_device.as_ref()?;
        made.as_ref().ok().filter(|_| *device == session.device().id())
    }

    /// Finds the difference between a copy of the shown target, of this name, and the kept picture. `display` is how it is shown.
    pub(crate) fn measure(&mut self, name: &str, texels: Arc<Texels>, display: Display) {
        let Some(Kept { what: What::Still(pixels), .. }) = self.kept() else { return };
        let (pixels, name) = (pixels.clone(), name.to_owned());
        self.find_figures(move || figures(&pixels, name, &texels, &display));
    }

    /// Asks the device for the live target and for the shown one, of this name, as the last frame left both: [`Self::update`] finds how far
    /// they are apart. False when nothing is live.
    pub(crate) fn measure_live(&mut self, session: &mut Session, name: &str, shown: &DebugTarget) -> bool {
        let Some(live) = self.live().cloned() else { return false };
        let mut ask = |of: &DebugTarget| session.request_texels(&of.resource, of.age, of.mip, of.layer);
        match ask(&live).and_then(|live| Ok((live, ask(shown)?))) {
            Ok((live, shown)) => {
                self.copying = Some(Copying { of: name.to_owned(), shown, kept: Against::Live(live) });
            }
            Err(error) => self.figures = Figures::Refused(error.to_string()),
        }
        true
    }

    /// Measures a copy of the shown target, of this name, against the kept picture, once it is there. `display` is how it is shown.
    pub(crate) fn measure_copy(&mut self, name: &str, shown: ReadTicket<Texels>, display: Display) {
        let Some(Kept { what: What::Still(pixels), .. }) = self.kept() else { return };
        let kept = Against::Still(pixels.clone(), display);
        self.copying = Some(Copying { of: name.to_owned(), shown, kept });
    }

    /// Measures the copies of [`Self::measure_live`] or [`Self::measure_copy`], once they are there.
    fn take_copies(&mut self) {
        if let Some(copying) = self.copying.take_if(|copying| copying.has_arrived()) {
            self.find_figures(move || copying.figures());
        }
    }

    /// Finds how far two pictures are apart, on a thread of its own.
    fn find_figures(&mut self, find: impl FnOnce() -> Figures + Send + 'static) {
        let (send, receive) = channel();
        thread::spawn(move || {
            // A window that was closed does not wait for it.
            let _ = send.send(find());
        });
        self.measuring = Some(receive);
    }

    /// The figures were asked for, and the shown target is being copied.
    pub(crate) fn await_figures(&mut self) {
        self.figures = Figures::Awaited;
    }

    /// The shown target could not be copied.
    pub(crate) fn give_up_figures(&mut self, why: &str) {
        if self.figures == Figures::Awaited {
            self.figures = Figures::Refused(why.to_owned());
        }
    }

    /// The panel's view.
    pub(crate) fn view(&self, session: &Session) -> Compare {
        let failed = self.picture.as_ref().and_then(|held| held.on_device.as_ref()?.1.as_ref().err().cloned());
        let mismatch = || match self.live() {
            Some(_) => self.missing.clone().or_else(|| Some(session.live_mismatch()?.to_string())),
            None => Some(session.mismatch(self.reference(session)?)?.to_string()),
        };
        Compare {
            live: self.live().is_some(),
            kept: self.kept().map(|kept| kept.name.clone()),
            mode: self.mode,
            flipped: self.flipped,
            edge: self.edge,
            gain: self.gain,
            refused: failed.or_else(mismatch),
            figures: self.figures.clone(),
        }
    }
}

/// The message about a copy that is kept.
pub(crate) fn kept_message(name: &str) -> String {
    format!("kept {name}; X goes through ways of comparing, V shows it alone")
}

/// The figures as the panel shows them.
fn figures(kept: &Pixels, of: String, shown: &Texels, display: &Display) -> Figures {
    match kept.figures(shown, display) {
        Ok(kept::Figures { flip, rmse, max, differing, pixels }) => {
            Figures::Found { of, flip, rmse, max, differing: [differing, pixels] }
        }
        Err(why) => Figures::Refused(why),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc::Sender;

    use raxel_shader::format::Format;

    use super::*;

    fn texels(values: &[f32]) -> Texels {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Texels { format: Format::R32f, width: u32::try_from(values.len()).unwrap(), height: 1, bytes }
    }

    fn keep(comparing: &mut Comparing, kept: Kept) {
        let (number, _) = comparing.ask(&kept.name.clone(), Coming::Asker);
        assert!(comparing.keep(kept, number));
    }

    /// Whether or not it is finished: a thread that is left behind would be in the driver when the process ends.
    #[test]
    fn an_upload_that_is_dropped_has_ended() {
        let ended = Arc::new(AtomicBool::new(false));
        let (on_thread, (begin, begun)) = (ended.clone(), channel());
        let uploading = Uploading::start(1, move || {
            let _ = begun.recv();
            on_thread.store(true, Ordering::Release);
            Err(ExecuteError::NoPlan)
        });
        thread::spawn(move || begin.send(()));
        drop(uploading);
        assert!(ended.load(Ordering::Acquire));
    }

    fn found(figures: &Figures) -> ([u64; 2], [u64; 2]) {
        let Figures::Found { rmse, max, differing, .. } = figures else { panic!("{figures:?}") };
        // In hundredths.
        ([rmse, max].map(|value| (value * 100.0).round() as u64), *differing)
    }

    #[test]
    fn figures_say_what_they_are_of() {
        let shown = texels(&[1.0, 2.0, 3.0, 4.0]);
        let figures = |kept: &[f32]| {
            super::figures(&Pixels::Texels(Arc::new(texels(kept))), "color, generation 2".to_owned(), &shown, &VALUES)
        };
        assert!(matches!(figures(&[0.0; 4]), Figures::Found { of, .. } if of == "color, generation 2"));
        assert_eq!(found(&figures(&[1.0, 2.0, 3.0, 6.0])), ([100, 200], [1, 4]));
        assert!(matches!(figures(&[1.0; 3]), Figures::Refused(_)), "of another size");
    }

    #[test]
    fn two_live_targets_are_measured_as_one_frame_left_them() {
        let folder = tempfile::tempdir().unwrap();
        let fill = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(r32f) writeonly uniform image2D c;\n\
            layout(push_constant) uniform Push { uint frame; float factor; } push;\n\
            void main() { imageStore(c, ivec2(gl_GlobalInvocationID.xy), vec4(push.factor * float(push.frame))); }\n";
        let mut graph = "name = \"two\"\npresent = \"once\"\n".to_owned();
        for (name, factor) in [("once", 1.0), ("twice", 2.0)] {
            graph += &format!(
                "[targets.{name}]\nformat = \"r32f\"\n[[passes]]\nname = \"{name}\"\nshader = \"fill.comp\"\n\
                 dispatch = {{ threads = \"{name}\" }}\nbind = {{ c = \"{name}\" }}\npush = {{ frame = \"frame.index\", factor = {factor:?} }}\n"
            );
        }
        for (path, text) in [("graphs/two.toml", graph.as_str()), ("shaders/fill.comp", fill)] {
            std::fs::create_dir_all(folder.path().join(path).parent().unwrap()).unwrap();
            std::fs::write(folder.path().join(path), text).unwrap();
        }
        let project = Some(folder.path().to_owned());
        let options = raxel_runtime::Options {
            project,
            size: [8, 8],
            observe: raxel_runtime::Observe::Shown,
            ..Default::default()
        };
        let mut session = Session::open(options).unwrap_or_else(|error| panic!("{error}"));
        let mut comparing = Comparing::default();
        assert!(!comparing.measure_live(&mut session, "once", &DebugTarget::resource("once")), "nothing is live");
        keep(&mut comparing, Kept::live(DebugTarget::resource("twice")));
        let frames = |session: &mut Session, comparing: &mut Comparing| {
            for _ in 0..5 {
                assert_eq!(comparing.update(session), None);
                session.frame().unwrap();
            }
        };
        frames(&mut session, &mut comparing);
        assert!(comparing.measure_live(&mut session, "once", &DebugTarget::resource("once")));
        // The frames that follow change nothing of it.
        let copying = comparing.copying.take();
        frames(&mut session, &mut comparing);
        session.wait().unwrap();
        comparing.copying = copying;
        comparing.take_copies();
        let figures = comparing.measuring.expect("both copies are there").recv().unwrap();
        // In frame 4 one has 4, and the other 8.
        assert_eq!(found(&figures), ([400, 400], [64, 64]));
    }

    #[test]
    fn what_is_kept_is_compared_at_once_and_let_go_of_with_all_but_the_edge() {
        let mut comparing = Comparing::default();
        comparing.flip();
        comparing.drag_edge(32.0, 128);
        assert!((comparing.edge - 0.5).abs() < 1e-9, "nobody holds it");
        comparing.held = true;
        keep(&mut comparing, Kept::copy("color", texels(&[1.0])));
        assert!(comparing.is_on() && comparing.mode == CompareMode::Wipe);
        assert_eq!([comparing.next_mode(), comparing.next_mode()], [CompareMode::Difference, CompareMode::Off]);
        assert!(!comparing.flipped, "another way of showing both shows both");
        comparing.set_gain(f32::NAN);
        comparing.set_gain(1e9);
        comparing.drag_edge(-5.0, 128);
        assert!(comparing.gain.to_bits() == 1e5_f32.to_bits() && comparing.edge.abs() < 1e-9);
        comparing.forget();
        assert!(!comparing.is_on() && comparing.mode == CompareMode::Off);
    }

    #[test]
    fn a_file_that_is_no_picture_is_said_and_keeps_what_was_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("note.png");
        std::fs::write(&path, "no picture").unwrap();
        let mut comparing = Comparing::default();
        keep(&mut comparing, Kept::copy("color", texels(&[1.0])));
        assert_eq!(comparing.load(&path, "note.png"), None);
        let said = loop {
            if let Some(said) = comparing.take_awaited() {
                break said;
            }
        };
        assert!(said.starts_with("`note.png` cannot be loaded: it is not a PNG"), "{said}");
        assert!(comparing.kept().is_some_and(|kept| kept.name == "color, 1 × 1"));
    }

    fn of_thread() -> (Sender<Result<Kept, String>>, Coming) {
        let (send, made) = channel();
        (send, Coming::Thread { made, copied: false })
    }

    /// Whichever comes first, a file or a copy of a target.
    #[test]
    fn the_picture_that_was_asked_for_last_is_kept_and_the_other_one_is_named() {
        let mut comparing = Comparing::default();
        let picture = |name: &str| Kept::copy(name, texels(&[1.0]));
        // The earlier one comes later.
        let (slow, file) = of_thread();
        assert_eq!(comparing.ask("slow.exr", file), (1, None));
        let (number, said) = comparing.ask("color", Coming::Asker);
        assert_eq!(said.as_deref(), Some("slow.exr is not kept: color was asked for after it"));
        assert!(comparing.keep(picture("color"), number));
        assert!(slow.send(Ok(picture("slow.exr"))).is_err(), "nobody waits for it");
        assert_eq!(comparing.take_awaited(), None);
        assert!(comparing.kept().is_some_and(|kept| kept.name == "color, 1 × 1"));
        // The earlier one comes first.
        let (earlier, _) = comparing.ask("depth", Coming::Asker);
        let (slow, file) = of_thread();
        let (_, said) = comparing.ask("slow.exr", file);
        assert_eq!(said.as_deref(), Some("depth is not kept: slow.exr was asked for after it"));
        assert!(!comparing.keep(picture("depth"), earlier), "the file is kept");
        assert_eq!(comparing.give_up_number(earlier, "it is gone"), None, "it was given up before");
        slow.send(Ok(picture("slow.exr"))).unwrap();
        assert_eq!(comparing.take_awaited().as_deref(), Some("compares with slow.exr, 1 × 1"));
        assert!(comparing.kept().is_some_and(|kept| kept.name == "slow.exr, 1 × 1"));
        // Nor does one come after the end of the comparison.
        let (number, _) = comparing.ask("depth", Coming::Asker);
        assert_eq!(comparing.forget().as_deref(), Some("depth is not kept: the comparison has ended"));
        assert!(!comparing.keep(picture("depth"), number) && !comparing.is_on());
        assert_eq!(comparing.forget(), None);
    }

    #[test]
    fn files_that_are_being_read_are_not_too_many() {
        let mut comparing = Comparing::default();
        let readers: Vec<Arc<()>> = (0..MOST_READERS).map(|_| comparing.reading.clone()).collect();
        let said = comparing.load(Path::new("a.png"), "a.png");
        assert_eq!(said.as_deref(), Some("a.png is not read: 3 other files are being read"));
        assert!(comparing.awaited.is_none());
        drop(readers);
        assert_eq!(comparing.load(Path::new("a.png"), "a.png"), None);
    }
}
