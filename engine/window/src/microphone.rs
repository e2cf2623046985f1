//! The microphone: graphs hear its captured sound. Capturing is a feature, since it needs a library of the system on Linux.

use raxel_runtime::inputs::Microphone;

/// Captures while something hears it.
#[derive(Default)]
pub(crate) enum Capture {
    /// Nothing hears the microphone.
    #[default]
    Off,
    /// A thread captures.
    #[cfg(feature = "microphone")]
    On(thread::Capturing),
    /// This build captures nothing, which was said.
    #[cfg(not(feature = "microphone"))]
    Refused,
}

impl Capture {
    /// Begins and ends capturing as it is wanted. Gives what a user should know; an error is a warning.
    pub(crate) fn follow(&mut self, wanted: bool, microphone: &Microphone) -> Option<Result<String, String>> {
        match self {
            #[cfg(feature = "microphone")]
            Self::On(capturing) if wanted => return capturing.follow(microphone),
            // The device is given back: nobody is listened to for nothing.
            #[cfg(feature = "microphone")]
            Self::On(_) => *self = Self::Off,
            #[cfg(feature = "microphone")]
            Self::Off if wanted => {
                *self = Self::On(thread::Capturing::start(of_system::DefaultInput, microphone.line()));
            }
            #[cfg(not(feature = "microphone"))]
            Self::Off if wanted => {
                *self = Self::Refused;
                let said = "the graph hears the microphone, and this raxel captures none: build it with `--features microphone`";
                return Some(Err(said.to_owned()));
            }
            #[cfg(not(feature = "microphone"))]
            Self::Refused => {}
            Self::Off => {}
        }
        // Without the feature for capturing, nothing captures.
        let _ = microphone;
        None
    }
}

#[cfg(any(test, feature = "microphone"))]
mod thread {
    use std::any::Any;
    use std::sync::mpsc::{Receiver, Sender, channel};
    use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
    use std::time::{Duration, Instant};

    use raxel_runtime::inputs::{Line, Microphone};

    /// The time until raxel looks for a device again.
    const RETRY: Duration = Duration::from_secs(2);

    /// The time that a device may take to open before raxel reports it.
    const PATIENCE: Duration = Duration::from_secs(5);

    /// Most messages of a thread: a device that comes and goes must not fill a terminal.
    const MOST_SAID: usize = 16;

    /// What captures.
    pub(crate) trait Device: Send + 'static {
        /// Feeds a line from now on, until what it gives is dropped. Names to `opening` what it is about to open, and says by `gone` why it captures
        /// no more. The error says why it does not.
        fn open(&mut self, line: &Line, gone: Gone, opening: &Opening) -> Result<Opened, String>;
    }

    /// What is being opened, for whoever waits.
    #[derive(Clone, Default)]
    pub(crate) struct Opening(Arc<Mutex<Option<Attempt>>>);

    struct Attempt {
        began: Instant,
        device: Option<String>,
    }

    impl Opening {
        /// The name of the device that is opened from now on.
        pub(crate) fn names(&self, device: &str) {
            if let Some(attempt) = &mut *self.lock() {
                attempt.device = Some(device.to_owned());
            }
        }

        fn begin(&self) {
            *self.lock() = Some(Attempt { began: Instant::now(), device: None });
        }

        fn end(&self) {
            *self.lock() = None;
        }

        /// What has been opening for so long, in words.
        fn for_longer_than(&self, patience: Duration) -> Option<String> {
            let attempt = self.lock();
            let attempt = attempt.as_ref().filter(|attempt| attempt.began.elapsed() > patience)?;
            Some(
                attempt
                    .device
                    .as_ref()
                    .map_or_else(|| "the microphone".to_owned(), |name| format!("microphone `{name}`")),
            )
        }

        fn lock(&self) -> MutexGuard<'_, Option<Attempt>> {
            // It is whole after every operation, so a panic elsewhere does not spoil it.
            self.0.lock().unwrap_or_else(PoisonError::into_inner)
        }
    }

    /// A device that captures.
    pub(crate) struct Opened {
        /// Its name.
        pub name: String,
        /// The capture, until it is dropped.
        pub stream: Box<dyn Any>,
    }

    /// Says that a device captures no more.
    #[derive(Clone)]
    pub(crate) struct Gone(Sender<Event>);

    impl Gone {
        /// Why it is gone.
        pub(crate) fn say(&self, why: String) {
            // Who listened may have ended.
            let _ = self.0.send(Event::Gone(why));
        }
    }

    enum Event {
        Gone(String),
        Stop,
    }

    /// A thread that captures. Only this thread waits for the device, which may be stuck. No frame waits, and the end of the window does not.
    pub(crate) struct Capturing {
        said: Receiver<Result<String, String>>,
        events: Sender<Event>,
        opening: Opening,
        patience: Duration,
        /// That a device does not open was said.
        slow: bool,
        /// That the device is stuck was said.
        stuck: bool,
    }

    impl Capturing {
        pub(crate) fn start(device: impl Device, line: Line) -> Self {
            Self::start_with(device, line, [RETRY, PATIENCE])
        }

        fn start_with(device: impl Device, line: Line, [retry, patience]: [Duration; 2]) -> Self {
            let ((say, said), (events, received)) = (channel(), channel());
            let (gone, failed) = (Gone(events.clone()), say.clone());
            let opening = Opening::default();
            let told = opening.clone();
            let run = move || capture(device, &line, (&gone, &told), &received, &say, retry);
            if let Err(error) = std::thread::Builder::new().name("raxel-microphone".to_owned()).spawn(run) {
                // It is received below.
                let _ = failed.send(Err(format!("the microphone is silent: {error}")));
            }
            Self { said, events, opening, patience, slow: false, stuck: false }
        }

        /// Gives what a user should know since the last call; an error is a warning.
        pub(crate) fn follow(&mut self, microphone: &Microphone) -> Option<Result<String, String>> {
            if let Ok(said) = self.said.try_recv() {
                return Some(said);
            }
            if let Some(device) = self.opening.for_longer_than(self.patience).filter(|_| !self.slow) {
                self.slow = true;
                return Some(Err(format!("{device} does not open: graphs hear silence until it does")));
            }
            let newly = microphone.is_stuck() && !self.stuck;
            self.stuck |= newly;
            newly.then(|| Err("the microphone gives no sound: graphs hear silence until it does".to_owned()))
        }
    }

    impl Drop for Capturing {
        fn drop(&mut self) {
            // It has ended already if nobody receives it.
            let _ = self.events.send(Event::Stop);
        }
    }

    /// Opens a device, and again when it is gone, until it is told to stop. Each message is said once.
    fn capture(
        mut device: impl Device,
        line: &Line,
        (gone, opening): (&Gone, &Opening),
        events: &Receiver<Event>,
        say: &Sender<Result<String, String>>,
        retry: Duration,
    ) {
        let mut known = Vec::new();
        let mut say = |said: Result<String, String>| {
            if !known.contains(&said) && known.len() < MOST_SAID {
                known.push(said.clone());
                // The window may be gone.
                let _ = say.send(said);
            }
        };
        loop {
            opening.begin();
            let result = device.open(line, gone.clone(), opening);
            opening.end();
            match result {
                Ok(Opened { name, stream }) => {
                    say(Ok(format!("microphone `{name}`")));
                    let event = events.recv();
                    drop(stream);
                    let Ok(Event::Gone(why)) = event else { return };
                    say(Err(format!("microphone `{name}` is gone ({why}): graphs hear silence until one is there")));
                }
                Err(why) => say(Err(format!("the microphone is silent: {why}"))),
            }
            // A device may report its end more than once.
            loop {
                match events.recv_timeout(retry) {
                    Ok(Event::Gone(_)) => {}
                    Ok(Event::Stop) => return,
                    Err(_) => break,
                }
            }
        }
    }

    #[cfg(test)]
    mod tests {
        use raxel_runtime::inputs::Feed;

        use super::*;

        /// Longer than any of it takes.
        const LIMIT: Duration = Duration::from_secs(60);

        /// The result of each call of `open`, first to last.
        struct Script(Vec<Box<Opens>>);

        type Opens = dyn FnMut(&Line, Gone) -> Result<Opened, String> + Send;

        impl Device for Script {
            fn open(&mut self, line: &Line, gone: Gone, _: &Opening) -> Result<Opened, String> {
                if self.0.is_empty() { Err("it has ended".to_owned()) } else { self.0.remove(0)(line, gone) }
            }
        }

        fn opened(name: &str, feed: Feed) -> Opened {
            Opened { name: name.to_owned(), stream: Box::new(feed) }
        }

        /// The next message.
        fn said(capturing: &Capturing) -> Result<String, String> {
            capturing.said.recv_timeout(LIMIT).unwrap()
        }

        /// Brings a microphone to a time, and gives what a frame hears last.
        fn heard(microphone: &mut Microphone, seconds: f64) -> i16 {
            microphone.follow(seconds, None);
            let heard = microphone.heard();
            heard.over.checked_sub(1).map_or(0, |last| heard.sample(last))
        }

        #[test]
        fn a_device_is_heard_until_it_is_gone_and_so_is_the_next() {
            let mut microphone = Microphone::default();
            let none = |_: &Line, _: Gone| Err("there is none".to_owned());
            let one = |name: &'static str, level: f32| {
                move |line: &Line, gone: Gone| {
                    let mut feed = line.feed(48_000, 2).unwrap();
                    feed.hear(&[level; 960]);
                    (0..3).for_each(|_| gone.say("it was unplugged".to_owned()));
                    Ok(opened(name, feed))
                }
            };
            let script = Script(vec![
                Box::new(none),
                Box::new(none),
                Box::new(one("a", 1.0)),
                Box::new(none),
                Box::new(|line, _| Ok(opened("b", line.feed(44_100, 1)?))),
            ]);
            let capturing = Capturing::start_with(script, microphone.line(), [Duration::from_millis(1), LIMIT]);
            assert_eq!(said(&capturing), Err("the microphone is silent: there is none".to_owned()));
            assert_eq!(said(&capturing), Ok("microphone `a`".to_owned()), "what was said is not said again");
            let gone = "microphone `a` is gone (it was unplugged): graphs hear silence until one is there";
            assert_eq!(said(&capturing), Err(gone.to_owned()));
            assert_eq!(said(&capturing), Ok("microphone `b`".to_owned()));
            // The samples of `a` went with it.
            assert_eq!([heard(&mut microphone, 0.01), heard(&mut microphone, 0.02)], [0; 2]);
        }

        #[test]
        fn messages_are_few_whatever_a_device_does() {
            let mut script: Vec<Box<Opens>> =
                (0..100).map(|at| Box::new(move |_: &Line, _: Gone| Err(at.to_string())) as _).collect();
            let (end, ended) = channel();
            script.push(Box::new(move |_, _| {
                end.send(()).unwrap();
                Err("the end".to_owned())
            }));
            let capturing = Capturing::start_with(Script(script), Line::default(), [Duration::from_micros(1), LIMIT]);
            for at in 0..MOST_SAID {
                assert_eq!(said(&capturing), Err(format!("the microphone is silent: {at}")));
            }
            ended.recv_timeout(LIMIT).unwrap();
            assert!(capturing.said.try_recv().is_err(), "no more is said");
        }

        /// A device that never comes back from opening, until the test lets it.
        struct Stuck {
            name: Option<&'static str>,
            opens: Sender<()>,
            free: Receiver<()>,
        }

        impl Device for Stuck {
            fn open(&mut self, _: &Line, _: Gone, opening: &Opening) -> Result<Opened, String> {
                self.name.iter().for_each(|name| opening.names(name));
                self.opens.send(()).unwrap();
                self.free.recv().unwrap();
                Err("at last".to_owned())
            }
        }

        #[test]
        fn a_device_that_does_not_open_stops_nothing_and_is_named_once() {
            for (name, said) in [(Some("a"), "microphone `a`"), (None, "the microphone")] {
                let mut microphone = Microphone::default();
                let ((opens, opened), (freed, free)) = (channel(), channel());
                let times = [RETRY, Duration::from_millis(20)];
                let mut capturing = Capturing::start_with(Stuck { name, opens, free }, microphone.line(), times);
                opened.recv_timeout(LIMIT).unwrap();
                let expected = format!("{said} does not open: graphs hear silence until it does");
                let began = Instant::now();
                let first = loop {
                    assert_eq!(heard(&mut microphone, began.elapsed().as_secs_f64()), 0);
                    if let Some(said) = capturing.follow(&microphone) {
                        break said;
                    }
                    assert!(began.elapsed() < LIMIT, "nothing is said");
                };
                assert_eq!(first, Err(expected));
                for frame in 0..300 {
                    assert_eq!(
                        (heard(&mut microphone, f64::from(frame) / 60.0), capturing.follow(&microphone)),
                        (0, None)
                    );
                }
                freed.send(()).unwrap();
                let failed = capturing.said.recv_timeout(LIMIT).unwrap();
                assert_eq!(failed, Err("the microphone is silent: at last".to_owned()));
            }
        }

        #[test]
        fn a_device_that_gives_nothing_is_named_once() {
            let mut microphone = Microphone::default();
            let device = Script(vec![Box::new(|line, _| Ok(opened("a", line.feed(48_000, 1)?)))]);
            let mut capturing = Capturing::start(device, microphone.line());
            assert_eq!(said(&capturing), Ok("microphone `a`".to_owned()));
            let mut warnings = Vec::new();
            for frame in 0..600 {
                heard(&mut microphone, f64::from(frame) / 60.0);
                warnings.extend(capturing.follow(&microphone));
            }
            assert_eq!(warnings, [Err("the microphone gives no sound: graphs hear silence until it does".to_owned())]);
        }
    }
}

#[cfg(feature = "microphone")]
mod of_system {
    use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
    use cpal::{
        Device as CpalDevice, Error, ErrorKind, FromSample, Sample, SampleFormat, SizedSample, Stream, StreamConfig,
    };
    use raxel_runtime::inputs::{Feed, Line};

    use super::thread::{Device, Gone, Opened, Opening};

    /// The input that the system captures from by default.
    pub(crate) struct DefaultInput;

    impl Device for DefaultInput {
        fn open(&mut self, line: &Line, gone: Gone, opening: &Opening) -> Result<Opened, String> {
            // ALSA would write all that it tries to the terminal, at each attempt. The error has the important part.
            #[cfg(target_os = "linux")]
            let _ = alsa::Output::local_error_handler();
            let text = |error: Error| error.to_string();
            let device = cpal::default_host().default_input_device().ok_or("the system has none")?;
            let name = device.description().map_or_else(|_| "default".to_owned(), |device| device.name().to_owned());
            opening.names(&name);
            let supported = device.default_input_config().map_err(text)?;
            let feed =
                line.feed(supported.sample_rate(), supported.channels()).map_err(|why| format!("`{name}`: {why}"))?;
            let config = supported.config();
            let stream = match supported.sample_format() {
                SampleFormat::F32 => build::<f32>(&device, config, feed, gone),
                SampleFormat::F64 => build::<f64>(&device, config, feed, gone),
                SampleFormat::I8 => build::<i8>(&device, config, feed, gone),
                SampleFormat::I16 => build::<i16>(&device, config, feed, gone),
                SampleFormat::I24 => build::<cpal::I24>(&device, config, feed, gone),
                SampleFormat::I32 => build::<i32>(&device, config, feed, gone),
                SampleFormat::U8 => build::<u8>(&device, config, feed, gone),
                SampleFormat::U16 => build::<u16>(&device, config, feed, gone),
                SampleFormat::U24 => build::<cpal::U24>(&device, config, feed, gone),
                SampleFormat::U32 => build::<u32>(&device, config, feed, gone),
                format => return Err(format!("`{name}` has samples of the format {format}")),
            };
            let stream = stream.map_err(text)?;
            stream.play().map_err(text)?;
            Ok(Opened { name, stream: Box::new(stream) })
        }
    }

    fn build<T: SizedSample>(
        device: &CpalDevice,
        config: StreamConfig,
        mut feed: Feed,
        gone: Gone,
    ) -> Result<Stream, Error>
    where
        f32: FromSample<T>,
    {
        let mut samples = Vec::new();
        let hear = move |captured: &[T], _: &cpal::InputCallbackInfo| {
            samples.clear();
            samples.extend(captured.iter().map(|sample| f32::from_sample(*sample)));
            feed.hear(&samples);
        };
        let failed = move |error: Error| match error.kind() {
            // It goes on.
            ErrorKind::Xrun | ErrorKind::RealtimeDenied | ErrorKind::DeviceChanged => {}
            _ => gone.say(error.to_string()),
        };
        device.build_input_stream(config, hear, failed, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_captured_unless_it_is_wanted() {
        let (mut capture, microphone) = (Capture::default(), Microphone::default());
        assert_eq!(capture.follow(false, &microphone), None);
        assert!(matches!(capture, Capture::Off));
    }

    #[test]
    #[cfg(not(feature = "microphone"))]
    fn a_build_that_captures_nothing_says_so_once() {
        let (mut capture, microphone) = (Capture::default(), Microphone::default());
        let said = capture.follow(true, &microphone).unwrap().unwrap_err();
        assert!(said.contains("build it with `--features microphone`"), "{said}");
        assert_eq!([capture.follow(true, &microphone), capture.follow(false, &microphone)], [None, None]);
        assert_eq!(capture.follow(true, &microphone), None);
    }
}
