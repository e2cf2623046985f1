//! Stores behind HTTP: a server that speaks S3.

#![cfg(feature = "cloud")]
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Stdio};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use common::python::Python;
use common::{LEVELS, cells, expected, land, plan, tiles};
use raxel_bake::{BakePart, FolderStore, ObjectStore, Patience, Store as _, Wanted, ZarrSource, bake};
use raxel_testing::files;
use raxel_world::ChunkProvider as _;

/// Serves S3 until its input ends, and says where.
const SERVE: &str = include_str!("fixtures/cloud/serve.py");

/// Reads the arrays of a bucket, and compares them with raw cells in a folder.
const COMPARE: &str = include_str!("fixtures/cloud/compare.py");

/// A server of S3, which ends with its input.
struct Server {
    child: Child,
    endpoint: String,
}

impl Server {
    fn start(python: &Python) -> Self {
        let mut command = python.command();
        command.args(["-c", SERVE]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let (sender, receiver) = mpsc::channel();
        let mut stdout = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || {
            let mut line = String::new();
            let _ = stdout.read_line(&mut line);
            let _ = sender.send(line.trim().to_owned());
        });
        let endpoint = receiver.recv_timeout(Duration::from_secs(120)).unwrap_or_default();
        let server = Self { child, endpoint };
        assert!(server.endpoint.starts_with("http://"), "the server did not say where it is: {}", server.endpoint);
        server
    }

    fn open(&self, address: &str) -> ObjectStore {
        let environment = [
            ("AWS_ENDPOINT_URL", self.endpoint.as_str()),
            ("AWS_ACCESS_KEY_ID", "test"),
            ("AWS_SECRET_ACCESS_KEY", "test"),
            ("AWS_REGION", "us-east-1"),
        ];
        ObjectStore::open_with(
            address,
            environment.map(|(name, value)| (name.to_owned(), value.to_owned())),
            Patience::default(),
        )
        .unwrap()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn shards_go_to_s3_and_come_back() {
    let Some(python) = Python::with("s3", &["zarr==3.1.6", "moto[server]==5.1.22"]) else { return };
    let server = Server::start(&python);
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    // Two tasks at once, each with a store of its own.
    std::thread::scope(|scope| {
        for part in ["1/2", "2/2"] {
            let (land, plan, server) = (&*land, &plan, &server);
            scope.spawn(move || {
                let store = server.open("s3://worlds/land");
                bake(land, plan, part.parse().unwrap(), &store, &mut |_, _| {}).unwrap();
            });
        }
    });
    let store = server.open("s3://worlds/land");
    let again = bake(&*land, &plan, BakePart::Whole, &store, &mut |_, _| {}).unwrap();
    assert_eq!((again.written, again.skipped), (0, 16));
    bake(&*land, &plan, BakePart::Whole, &FolderStore::new(folder.path().join("store")), &mut |_, _| {}).unwrap();
    for (name, bytes) in files(&folder.path().join("store")) {
        assert!(store.get(&name, Wanted::Whole).unwrap() == Some(bytes), "{name}");
    }
    assert_eq!(store.get("0/c/9/9/9", Wanted::Whole), Ok(None));
    let source = ZarrSource::of(Arc::new(store), "s3://worlds/land").unwrap();
    for (level, pos) in tiles(&plan) {
        assert_eq!(source.try_chunk(level, pos).unwrap(), expected(&*land, &plan, (level, pos)), "{level} {pos:?}");
    }
    for level in 0..LEVELS {
        let (cells, shape) = cells(&*land, &plan, level);
        let bytes: Vec<u8> = cells.iter().flat_map(|cell| cell.to_le_bytes()).collect();
        std::fs::write(folder.path().join(format!("{level}.raw")), bytes).unwrap();
        std::fs::write(folder.path().join(format!("{level}.json")), format!("{shape:?}")).unwrap();
    }
    python.run(COMPARE, &[folder.path().to_str().unwrap(), &LEVELS.to_string(), &server.endpoint], &[]);
    // A bucket that is not there is an error, not an empty world.
    let nowhere = ZarrSource::of(Arc::new(server.open("s3://nowhere/land")), "s3://nowhere/land");
    assert!(nowhere.is_err());
}
