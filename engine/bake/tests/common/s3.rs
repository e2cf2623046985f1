//! A real server of S3, which a test kills and starts again: s3s-fs, on the path or named by `S3S_FS`.
//! `cargo install s3s-fs --version 0.14.1 --features binary` builds it, with Rust 1.92 or newer.

use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// How long the server may take to answer after its start.
const START: Duration = Duration::from_secs(20);
/// The time between two runs of the server.
pub(crate) const AWAY: Duration = Duration::from_millis(150);

/// A server on a folder. Its buckets are the folders in there; `worlds` is one.
pub(crate) struct Server {
    folder: tempfile::TempDir,
    port: u16,
    child: Mutex<Child>,
    restarts: AtomicUsize,
}

impl Server {
    /// Starts one on a free port.
    pub(crate) fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("worlds")).unwrap();
        // No other process has this port, unless one takes it between here and there.
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let child = Mutex::new(spawn(folder.path(), port));
        Self { folder, port, child, restarts: AtomicUsize::new(0) }
    }

    /// Where it keeps its buckets.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Variables that give a program the server's address and its own credentials.
    pub(crate) fn environment(&self) -> [(String, String); 4] {
        [
            ("AWS_ENDPOINT_URL", format!("http://127.0.0.1:{}", self.port)),
            ("AWS_ACCESS_KEY_ID", "test".to_owned()),
            ("AWS_SECRET_ACCESS_KEY", "test-secret".to_owned()),
            ("AWS_REGION", "us-east-1".to_owned()),
        ]
        .map(|(name, value)| (name.to_owned(), value))
    }

    /// Kills it while it works. It starts again when the answer is dropped.
    pub(crate) fn away(&self) -> Away<'_> {
        let mut child = self.child.lock().unwrap();
        kill(&mut child);
        Away { server: self, child }
    }

    /// The number of its restarts since the last call.
    pub(crate) fn take_restarts(&self) -> usize {
        self.restarts.swap(0, Ordering::Relaxed)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // A test that failed while the server was away.
        let mut child = self.child.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        kill(&mut child);
    }
}

/// The time between two lives of a server.
pub(crate) struct Away<'a> {
    server: &'a Server,
    child: MutexGuard<'a, Child>,
}

impl Drop for Away<'_> {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            *self.child = spawn(self.server.folder.path(), self.server.port);
            self.server.restarts.fetch_add(1, Ordering::Relaxed);
        }
    }
}

fn spawn(folder: &Path, port: u16) -> Child {
    let program = std::env::var("S3S_FS").unwrap_or_else(|_| "s3s-fs".to_owned());
    let mut command = Command::new(&program);
    command.args(["--host", "127.0.0.1", "--access-key", "test", "--secret-key", "test-secret"]);
    command.args(["--port", &port.to_string()]).arg(folder).stdout(Stdio::null()).stderr(Stdio::null());
    let child = command.spawn().unwrap_or_else(|error| panic!("{program}: {error}"));
    let start = Instant::now();
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(start.elapsed() < START, "{program} does not listen on port {port}");
        std::thread::sleep(Duration::from_millis(10));
    }
    child
}

fn kill(child: &mut Child) {
    // One that has ended already is no error.
    let _ = child.kill();
    child.wait().unwrap();
}

/// Restarts the server again and again until the work is done.
pub(crate) fn restarted<T: Send>(server: &Server, work: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let work = scope.spawn(work);
        while !work.is_finished() {
            let away = server.away();
            std::thread::sleep(AWAY);
            drop(away);
            std::thread::sleep(AWAY);
        }
        work.join().unwrap()
    })
}
