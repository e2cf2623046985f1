//! A web server over a folder that lies on request.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use raxel_world::random::SplitMix64;

/// How a request is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    Right,
    /// With this status only.
    Status(u16),
    /// It hangs up before it says anything.
    Nothing,
    /// Bytes that are no HTTP.
    Garbage,
    /// 200 with a page, as the portal of a hotel has one.
    Page,
    /// The connection ends within the bytes.
    Half,
    /// Fewer bytes than were asked for, in headers that agree with one another.
    Short,
    /// `Content-Length` is one less than the bytes are.
    LengthLess,
    /// `Content-Length` is one more.
    LengthMore,
    /// Neither a length nor an end.
    Endless,
    /// `Content-Length` is 2^60, and the bytes never end.
    Huge,
    /// 200 and the whole object.
    Whole,
    /// 206 and the whole object.
    WholePart,
    /// 206 without `Content-Range`.
    NoRange,
    /// `Content-Range` is of other bytes.
    OtherRange,
    /// `Content-Range` has the largest numbers there are.
    LargestRange,
    /// `Content-Range` names another size of the object.
    OtherSize,
    /// The headers are right, and the bytes are those one further on.
    Shifted,
    /// One bit is another one.
    Flipped,
    /// As many zeros.
    Zeros,
    /// The connection stays open, and nothing comes.
    Stall,
    /// Half of the bytes, and then nothing.
    HalfStall,
    /// Byte by byte, so slowly that the last comes too late.
    Drip,
    /// To where the right answer is.
    Redirect,
    /// To itself.
    Loop,
    /// A redirect without a place.
    Nowhere,
    /// To another object.
    Elsewhere,
    /// Connects to a port without a listener.
    Closed,
    /// The object of another world, with another `ETag`.
    Changed,
    /// The object of another world, with the `ETag` of this one.
    ChangedInSecret,
}

use Answer::{
    Changed, ChangedInSecret, Closed, Drip, Elsewhere, Endless, Flipped, Garbage, Half, HalfStall, Huge, LargestRange,
    LengthLess, LengthMore, Loop, NoRange, Nothing, Nowhere, OtherRange, OtherSize, Page, Redirect, Right, Shifted,
    Short, Stall, Status, Whole, WholePart, Zeros,
};

/// Every lie.
pub(crate) const LIES: [Answer; 35] = [
    Status(500),
    Status(503),
    Status(429),
    Status(416),
    Status(404),
    Status(403),
    Status(204),
    Nothing,
    Garbage,
    Page,
    Half,
    Short,
    LengthLess,
    LengthMore,
    Endless,
    Huge,
    Whole,
    WholePart,
    NoRange,
    OtherRange,
    LargestRange,
    OtherSize,
    Shifted,
    Flipped,
    Zeros,
    Stall,
    HalfStall,
    Drip,
    Redirect,
    Loop,
    Nowhere,
    Elsewhere,
    Closed,
    Changed,
    ChangedInSecret,
];

impl Answer {
    /// Whether only a limit of time ends it.
    pub(crate) fn is_slow(self) -> bool {
        matches!(self, Stall | HalfStall | Drip | Endless | Huge)
    }
}

/// The answers to the next requests.
pub(crate) enum Plan {
    /// These, the first one first, and right afterwards.
    Then(Vec<Answer>),
    /// Always this.
    Always(Answer),
    /// On average, one request in this many gets a lie.
    Random(SplitMix64, u64),
}

impl Plan {
    fn next(&mut self) -> Answer {
        match self {
            Self::Then(answers) if answers.is_empty() => Right,
            Self::Then(answers) => answers.remove(0),
            Self::Always(answer) => *answer,
            Self::Random(random, of) => match random.below(*of) {
                0 => LIES[random.below(LIES.len() as u64) as usize],
                _ => Right,
            },
        }
    }
}

/// A server that ends with the test.
pub(crate) struct WebServer {
    pub address: String,
    plan: Arc<Mutex<(Plan, usize)>>,
}

impl WebServer {
    /// Serves one folder; [`Changed`] answers come from another one.
    pub(crate) fn start(folder: PathBuf, other: PathBuf) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let plan = Arc::new(Mutex::new((Plan::Then(Vec::new()), 0)));
        let server = Self { address: format!("http://127.0.0.1:{port}/"), plan: plan.clone() };
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (plan, folders) = (plan.clone(), [folder.clone(), other.clone()]);
                std::thread::spawn(move || serve(stream, &folders, &plan));
            }
        });
        server
    }

    pub(crate) fn answers(&self, plan: Plan) {
        self.plan.lock().unwrap().0 = plan;
    }

    /// Requests so far.
    pub(crate) fn requests(&self) -> usize {
        self.plan.lock().unwrap().1
    }
}

/// Answers one request, and closes. Writing fails when the client hangs up, which it may.
fn serve(mut stream: TcpStream, folders: &[PathBuf; 2], plan: &Mutex<(Plan, usize)>) {
    let _ = stream.set_read_timeout(Some(Duration::from_secs(60)));
    let mut lines = BufReader::new(stream.try_clone().unwrap()).lines().map_while(Result::ok);
    let Some(request) = lines.next() else { return };
    let headers: Vec<String> =
        lines.take_while(|line| !line.is_empty()).map(|line| line.to_ascii_lowercase()).collect();
    let path = request.split(' ').nth(1).unwrap_or("/").trim_start_matches('/');
    let answer = if path.ends_with("?right") {
        Right
    } else {
        let mut plan = plan.lock().unwrap();
        plan.1 += 1;
        plan.0.next()
    };
    let path = path.trim_end_matches("?right");
    let changed = matches!(answer, Changed | ChangedInSecret);
    let bytes = std::fs::read(folders[usize::from(changed)].join(path));
    let (status, more) = match (answer, &bytes) {
        (Status(status), _) => (status, String::new()),
        (Page, _) => return send(&mut stream, "HTTP/1.1 200 OK", "Content-Length: 13\r\n", b"<html></html>"),
        (Nothing, _) => return,
        (Garbage, _) => return drop(stream.write_all(b"\x16\x03\x01 this is no HTTP\r\n\r\n")),
        (Stall, _) => (200, String::new()),
        (Redirect, _) => (302, format!("Location: /{path}?right\r\n")),
        (Loop, _) => (302, format!("Location: /{path}\r\n")),
        (Nowhere, _) => (302, String::new()),
        (Elsewhere, _) => (307, "Location: /0/zarr.json?right\r\n".to_owned()),
        (Closed, _) => (302, "Location: http://127.0.0.1:1/\r\n".to_owned()),
        (_, Err(_)) => (404, String::new()),
        (_, Ok(_)) => (200, String::new()),
    };
    if answer == Stall {
        return drop(stream.read(&mut [0; 64]));
    }
    let Some(whole) = bytes.ok().filter(|_| status == 200) else {
        return send(&mut stream, &format!("HTTP/1.1 {status} -"), &format!("Content-Length: 0\r\n{more}"), &[]);
    };
    give(&mut stream, answer, &whole, headers.iter().find_map(|line| line.strip_prefix("range: bytes=")));
}

/// Gives an object, or the part of it that a header names.
fn give(stream: &mut TcpStream, answer: Answer, whole: &[u8], range: Option<&str>) {
    let size = whole.len();
    let number = |text: &str| text.parse::<usize>().unwrap();
    let (mut from, mut to) = match range.map(|range| range.split_once('-').unwrap()) {
        None => (0, size),
        Some(("", last)) => (size - number(last).min(size), size),
        Some((from, to)) => (number(from).min(size), (number(to) + 1).min(size)),
    };
    match answer {
        WholePart => (from, to) = (0, size),
        Short => to -= (to - from) / 3,
        _ => {}
    }
    let mut body = whole[from..to].to_vec();
    let last = body.len().saturating_sub(1);
    match answer {
        Shifted => body.rotate_left(1.min(last)),
        Flipped => body[last / 2] ^= 4,
        Zeros => body.fill(0),
        Whole => body = whole.to_vec(),
        _ => {}
    }
    let part = range.is_some() && answer != Whole;
    let status = if part { "HTTP/1.1 206 Partial Content" } else { "HTTP/1.1 200 OK" };
    let content_range = match answer {
        _ if !part || answer == NoRange => String::new(),
        OtherRange => format!("Content-Range: bytes {}-{to}/{}\r\n", from + 1, size + 1),
        LargestRange => format!("Content-Range: bytes 0-{}/{0}\r\n", u64::MAX),
        OtherSize => format!("Content-Range: bytes {from}-{}/{}\r\n", to - 1, size + 1000),
        _ => format!("Content-Range: bytes {from}-{}/{size}\r\n", to.saturating_sub(1)),
    };
    let length = match answer {
        Endless => String::new(),
        Huge => format!("Content-Length: {}\r\n", 1u64 << 60),
        LengthLess => format!("Content-Length: {last}\r\n"),
        LengthMore => format!("Content-Length: {}\r\n", body.len() + 1),
        _ => format!("Content-Length: {}\r\n", body.len()),
    };
    let tag = if answer == Changed { "b" } else { "a" };
    let headers = format!("{length}{content_range}ETag: \"{tag}\"\r\n");
    match answer {
        Half | HalfStall => {
            send(stream, status, &headers, &body[..body.len() / 2]);
            if answer == HalfStall {
                let _ = stream.read(&mut [0; 64]);
            }
        }
        Drip => {
            send(stream, status, &headers, &[]);
            for byte in body {
                std::thread::sleep(Duration::from_millis(20));
                if stream.write_all(&[byte]).is_err() {
                    return;
                }
            }
        }
        Endless | Huge => {
            send(stream, status, &headers, &body);
            while stream.write_all(&[b' '; 4096]).is_ok() {}
        }
        _ => send(stream, status, &headers, &body),
    }
    let _ = stream.shutdown(Shutdown::Write);
    let _ = stream.read(&mut [0; 64]);
}

fn send(stream: &mut TcpStream, status: &str, headers: &str, body: &[u8]) {
    let head = format!("{status}\r\nConnection: close\r\n{headers}\r\n");
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(body));
}
