//! A real server of S3 that is killed and started again while worlds are baked into it and read from it.
//!
//! The server is s3s-fs: `cargo install s3s-fs --version 0.14.1 --features binary`, for Rust 1.92 or newer, on the path or named by `S3S_FS`. Then
//! `cargo test --profile checked -p raxel-bake --features cloud --test s3_server -- --ignored`

#![cfg(all(feature = "cloud", target_os = "linux"))]
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::collections::BTreeMap;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use common::{expected, land, plan, tiles};
use raxel_bake::{Directory, ObjectStore, Part, Patience, ZarrSource, bake};
use raxel_testing::files;
use raxel_world::ChunkProvider as _;

/// How long the server may take to answer, and how long it is away between two lives.
const START: Duration = Duration::from_secs(20);
const AWAY: Duration = Duration::from_millis(150);

/// A server on a folder; its buckets are the folders in there.
struct Server {
    folder: tempfile::TempDir,
    port: u16,
    child: Mutex<Child>,
    restarts: AtomicUsize,
}

impl Server {
    fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("worlds")).unwrap();
        // Nobody else has this port, unless it is taken between here and there.
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let child = Mutex::new(Self::spawn(folder.path(), port));
        Self { folder, port, child, restarts: AtomicUsize::new(0) }
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
        child.kill().unwrap();
        child.wait().unwrap();
    }

    /// Kills it in the middle of what it does, and starts it again after a while.
    fn restart(&self) {
        let mut child = self.child.lock().unwrap();
        Self::kill(&mut child);
        std::thread::sleep(AWAY);
        *child = Self::spawn(self.folder.path(), self.port);
        self.restarts.fetch_add(1, Ordering::Relaxed);
    }

    fn open(&self, patience: Patience) -> ObjectStore {
        let endpoint = format!("http://127.0.0.1:{}", self.port);
        let environment = [
            ("AWS_ENDPOINT_URL", endpoint.as_str()),
            ("AWS_ACCESS_KEY_ID", "test"),
            ("AWS_SECRET_ACCESS_KEY", "test-secret"),
            ("AWS_REGION", "us-east-1"),
        ];
        let environment = environment.map(|(name, value)| (name.to_owned(), value.to_owned()));
        ObjectStore::open_with("s3://worlds/land", environment, patience).unwrap()
    }

    /// The objects of the world, without what the server keeps beside them.
    fn objects(&self) -> BTreeMap<String, Vec<u8>> {
        let all = files(&self.folder.path().join("worlds/land")).into_iter();
        all.filter(|(name, _)| !name.split('/').any(|part| part.starts_with('.'))).collect()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        Self::kill(&mut self.child.lock().unwrap());
    }
}

/// Restarts the server again and again until the work is done.
fn restarted<T: Send>(server: &Server, work: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let work = scope.spawn(work);
        while !work.is_finished() {
            server.restart();
            std::thread::sleep(AWAY);
        }
        work.join().unwrap()
    })
}

#[test]
#[ignore = "needs s3s-fs"]
fn a_server_that_restarts_costs_no_shard_and_changes_no_voxel() {
    let server = Server::start();
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    bake(&*land, &plan, Part::Whole, &Directory::new(folder.path().to_owned()), &mut |_, _| {}).unwrap();
    let whole: BTreeMap<_, _> = files(folder.path()).into_iter().collect();

    // Two tasks at once; after each shard the server is away for a while.
    let slowly = |part: Part| {
        let store = server.open(Patience::default());
        bake(&*land, &plan, part, &store, &mut |_, _| std::thread::sleep(2 * AWAY)).map(|done| done.written)
    };
    let written = restarted(&server, || {
        std::thread::scope(|scope| {
            let tasks = ["1/2", "2/2"].map(|part| scope.spawn(move || slowly(part.parse().unwrap())));
            tasks.map(|task| task.join().unwrap().expect("it is asked again"))
        })
    });
    let restarts = server.restarts.swap(0, Ordering::Relaxed);
    assert!(restarts > 3, "{restarts}");
    assert_eq!(written.iter().sum::<u64>(), 16);
    assert!(server.objects() == whole);
    // What is there is not made again.
    let again = bake(&*land, &plan, Part::Whole, &server.open(Patience::default()), &mut |_, _| {}).unwrap();
    assert_eq!((again.written, again.skipped), (0, 16));

    let source = ZarrSource::of(Arc::new(server.open(Patience::default())), "s3://worlds/land").unwrap();
    restarted(&server, || {
        for (count, (level, pos)) in tiles(&plan).into_iter().enumerate() {
            let found = source.try_chunk(level, pos).expect("it is asked again");
            assert!(found == expected(&*land, &plan, (level, pos)), "{level} {pos:?}");
            if count % 8 == 0 {
                std::thread::sleep(AWAY / 4);
            }
        }
    });
    let restarts = server.restarts.load(Ordering::Relaxed);
    assert!(restarts > 1, "{restarts}");
}

#[test]
#[ignore = "needs s3s-fs"]
fn a_server_that_is_away_is_an_error_until_it_is_back() {
    let server = Server::start();
    let land = land();
    let plan = plan(&*land);
    bake(&*land, &plan, Part::Whole, &server.open(Patience::default()), &mut |_, _| {}).unwrap();
    let [answer, request, pause] = [400, 500, 1].map(Duration::from_millis);
    let patience = || Patience { answer, request, pause, pauses: vec![pause] };
    let source = ZarrSource::of(Arc::new(server.open(patience())), "s3://worlds/land").unwrap();
    let solid = common::solid_tile(&*land, &plan);
    {
        let mut child = server.child.lock().unwrap();
        Server::kill(&mut child);
        let error = source.try_chunk(solid.0, solid.1).unwrap_err();
        assert_eq!((error.level, error.pos), solid);
        assert!(error.reason.contains("s3://worlds/land"), "{error}");
        // Nothing is written, and nothing is lost.
        let refused = bake(&*land, &plan, Part::Whole, &server.open(patience()), &mut |_, _| {});
        assert!(refused.is_err());
        *child = Server::spawn(server.folder.path(), server.port);
    }
    assert!(source.try_chunk(solid.0, solid.1).unwrap() == expected(&*land, &plan, solid));
    let again = bake(&*land, &plan, Part::Whole, &server.open(Patience::default()), &mut |_, _| {}).unwrap();
    assert_eq!((again.written, again.skipped), (0, 16));
}
