//! Chooses the device that presents a window: the device that makes the pictures, or another one, which gets the pictures through the host.

use std::cmp::Reverse;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_gpu::{Device, DeviceKind, Error, Verdict};
use raxel_runtime::present::Presenter;
use raxel_terminal::console::Console;
use raxel_terminal::failure::Result;
use winit::window::Window;

use super::overlay::Overlay;

/// An open window and the objects that draw to it.
pub(super) struct Open {
    pub window: Arc<Window>,
    pub presenter: Presenter,
    pub overlay: Overlay,
    /// Whose pictures are presented.
    pub pictures: Pictures,
}

/// The device that makes the pictures of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pictures {
    /// The one that presents them.
    Same,
    /// Another one, whose pictures come through the host: the one that presents is free while the other works.
    Other,
}

/// Between two pictures that are refused in a row. After a longer time, none was tried: the window was hidden, or waited for a file.
const IN_A_ROW: Duration = Duration::from_secs(2);

/// How long a window may take no picture before that is reported. Window systems hold the images of windows that nobody sees for a while.
const REFUSED: Duration = Duration::from_secs(10);

/// Whether the window takes pictures. A driver that never has an image for one, or whose device is lost again and again, would leave it black
/// without a word.
#[derive(Debug, Default)]
pub(super) struct Refusals {
    /// When the first picture after the last one that was taken was refused, and when the last one was.
    since: Option<(Instant, Instant)>,
    reported: bool,
}

impl Refusals {
    /// The window took a picture.
    pub(crate) fn end(&mut self) {
        self.since = None;
    }

    /// The window refused a picture `now`. True, once, when it has taken none for long.
    pub(crate) fn add(&mut self, now: Instant) -> bool {
        let (first, _) = self.since.filter(|(_, last)| now.duration_since(*last) < IN_A_ROW).unwrap_or((now, now));
        self.since = Some((first, now));
        let is_long = !self.reported && now.duration_since(first) >= REFUSED;
        self.reported |= is_long;
        is_long
    }
}

/// The report of a window that takes no pictures.
pub(super) fn refused(device: &str) -> String {
    let seconds = REFUSED.as_secs();
    format!(
        "the window has taken no picture for {seconds} s: {device} does not present any\n\
         help: `--present-with DEVICE` has another device present; `raxel render -o p.png` needs no window"
    )
}

/// The device that presents, where the command line names one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PresentWith {
    /// The one that makes the pictures.
    Own,
    /// The best one with this number, or with this in its name, opened once more even if it is the one that makes the pictures.
    Device(String),
}

/// Reads [`PresentWith`]. A device that is not there is found when the window opens.
pub(super) fn present_with(text: &str) -> std::result::Result<PresentWith, String> {
    match text.trim() {
        "" => Err("write `own`, a part of a device's name, or its number in `raxel doctor`".to_owned()),
        "own" => Ok(PresentWith::Own),
        device => Ok(PresentWith::Device(device.to_owned())),
    }
}

impl Open {
    /// For a window that shows the pictures of `device`. A software device has one queue, and its presenting waits for all work in it. So
    /// another device presents there, and the panels answer while the first one works. A GPU presents by itself if it can. If it cannot
    /// (it has no display, and the window is on a server that does not know it), the best capable device presents.
    pub(crate) fn on(
        device: &Arc<Device>,
        with: Option<&PresentWith>,
        window: &Arc<Window>,
        vsync: bool,
        console: &Console,
    ) -> Result<Open> {
        let presented_by = |presenting: &Arc<Device>| -> Result<Open> {
            let size = window.inner_size();
            let presenter = Presenter::new(presenting, window.clone(), [size.width, size.height], vsync)?;
            let most = presenting.capabilities().limits.max_image_dimension2_d as usize;
            let pictures = if presenting.id() == device.id() { Pictures::Same } else { Pictures::Other };
            Ok(Open { window: window.clone(), presenter, overlay: Overlay::new(window, most), pictures })
        };
        match with {
            Some(PresentWith::Own) => {
                let help = "without `--present-with own`, another device may present; `raxel render` needs no window";
                let opened = presented_by(device);
                return if device.is_lost() { opened } else { opened.map_err(|failure| failure.help(help)) };
            }
            Some(PresentWith::Device(name)) => return presented_by(&device.beside(name)?),
            None if device.capabilities().kind == DeviceKind::Cpu => return presented_by(&device.another()?),
            None => {}
        }
        let unseen = no_gpu_behind(window);
        let failure = match unseen {
            Some(reason) => {
                let device = device.capabilities().name.clone();
                Error::CannotPresent { device, reason: reason.to_owned() }.into()
            }
            None => match presented_by(device) {
                Err(failure) if !device.is_lost() => failure,
                opened => return opened,
            },
        };
        for index in others(device.verdicts(), unseen.is_some()) {
            let opened = device.beside(&index.to_string()).map_err(Into::into).and_then(|other| presented_by(&other));
            match opened {
                Ok(open) => {
                    let why = failure.message.as_deref().unwrap_or_default();
                    let name = &open.presenter.device().capabilities().name;
                    console.message(&format!("{name} presents the window: {why}"));
                    return Ok(open);
                }
                Err(other) => console.detail(other.message.as_deref().unwrap_or_default()),
            }
        }
        Err(failure.help("`--present-with DEVICE` has another device present; `raxel render -o p.png` needs no window"))
    }
}

/// Why no GPU can present to a window: its X server has none, as Xvfb and servers far away. Drivers that are asked all the same may say no, or end
/// the process (NVIDIA 580 does).
#[cfg(target_os = "linux")]
fn no_gpu_behind(window: &Window) -> Option<&'static str> {
    use raw_window_handle::{HasWindowHandle as _, RawWindowHandle};
    use x11rb::protocol::xproto::ConnectionExt as _;
    let handle = window.window_handle().ok()?.as_raw();
    if !matches!(handle, RawWindowHandle::Xlib(_) | RawWindowHandle::Xcb(_)) {
        return None;
    }
    let (server, _) = x11rb::connect(None).ok()?;
    // If the server does not answer, nothing is concluded.
    let has = |extension: &str| {
        let asked = server.query_extension(extension.as_bytes()).ok();
        asked.and_then(|asked| asked.reply().ok()).is_none_or(|answer| answer.present)
    };
    // The extensions of the X server by which Mesa's drivers present, and NVIDIA's.
    (!has("DRI3") && !has("NV-GLX")).then_some("its X server works with no GPU")
}

/// As above: other window systems are asked by the driver.
#[cfg(not(target_os = "linux"))]
fn no_gpu_behind(_: &Window) -> Option<&'static str> {
    None
}

/// The numbers of the other devices that raxel can use, in the order in which they are asked to present; of processors only, if so.
fn others(verdicts: &[Verdict], processors: bool) -> Vec<usize> {
    let mut usable: Vec<_> = verdicts
        .iter()
        .filter(|verdict| !verdict.chosen && verdict.candidate.missing.is_empty())
        .map(|verdict| &verdict.candidate)
        .filter(|candidate| !processors || candidate.kind == DeviceKind::Cpu)
        .collect();
    usable.sort_by_key(|candidate| (candidate.kind, Reverse(candidate.memory), candidate.index));
    usable.into_iter().map(|candidate| candidate.index).collect()
}

#[cfg(test)]
mod tests {
    use raxel_gpu::{Candidate, Version, choose};

    use super::*;

    #[test]
    fn the_best_of_the_other_usable_devices_is_asked_first() {
        let device = |index, kind, missing: &[&'static str]| Candidate {
            index,
            name: format!("device {index}"),
            kind,
            version: Version { major: 1, minor: 3, patch: 0 },
            missing: missing.to_vec(),
            memory: 1 << 30,
        };
        let verdicts = choose(
            vec![
                device(0, DeviceKind::Cpu, &[]),
                device(1, DeviceKind::Discrete, &[]),
                device(2, DeviceKind::Discrete, &["synchronization2"]),
                device(3, DeviceKind::Integrated, &[]),
            ],
            None,
        );
        assert!(verdicts[1].chosen);
        assert_eq!(others(&verdicts, false), [3, 0]);
        assert_eq!(others(&verdicts, true), [0]);
    }

    #[test]
    fn a_window_that_takes_no_picture_for_long_is_reported_once() {
        const NONE: [u32; 0] = [];
        let (start, second) = (Instant::now(), Duration::from_secs(1));
        let mut refusals = Refusals::default();
        let reports = |refusals: &mut Refusals, seconds: std::ops::Range<u32>| {
            seconds.filter(|at| refusals.add(start + *at * second)).collect::<Vec<_>>()
        };
        assert_eq!(reports(&mut refusals, 0..10), NONE);
        refusals.end();
        assert_eq!(reports(&mut refusals, 10..20), NONE, "a picture was taken");
        // It was hidden for a minute.
        assert_eq!(reports(&mut refusals, 80..90), NONE);
        assert_eq!(reports(&mut refusals, 90..120), [90], "once");
    }

    #[test]
    fn the_command_line_names_a_device_or_its_own() {
        assert_eq!(present_with("own"), Ok(PresentWith::Own));
        assert_eq!(present_with(" llvmpipe"), Ok(PresentWith::Device("llvmpipe".to_owned())));
        assert!(present_with(" ").is_err());
    }
}
