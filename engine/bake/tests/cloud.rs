//! Stores behind HTTP: a server that speaks S3, and a web server that fails.

#![cfg(feature = "cloud")]

mod common;

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use common::python::Python;
use common::{LEVELS, cells, expected, files, land, plan, solid_tile, tiles};
use raxel_bake::{Directory, ObjectStore, Part, Store as _, Wanted, ZarrSource, bake};
use raxel_world::ChunkSource as _;

/// Serves S3 until its input ends, and says where.
const SERVE: &str = r#"
import sys
import boto3
from moto.server import ThreadedMotoServer
server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
server.start()
host, port = server.get_host_and_port()
endpoint = f"http://127.0.0.1:{port}"
key = dict(aws_access_key_id="test", aws_secret_access_key="test", region_name="us-east-1")
boto3.client("s3", endpoint_url=endpoint, **key).create_bucket(Bucket="worlds")
print(endpoint, flush=True)
sys.stdin.read()
server.stop()
"#;

/// Reads the arrays of a bucket, and compares them with raw cells in a folder.
const COMPARE: &str = r#"
import json, sys
import boto3, numpy, zarr
from zarr.core.buffer import cpu
folder, levels, endpoint = sys.argv[1], int(sys.argv[2]), sys.argv[3]
key = dict(aws_access_key_id="test", aws_secret_access_key="test", region_name="us-east-1")
client = boto3.client("s3", endpoint_url=endpoint, **key)
objects = {}
for page in client.get_paginator("list_objects_v2").paginate(Bucket="worlds", Prefix="land/"):
    for entry in page["Contents"]:
        body = client.get_object(Bucket="worlds", Key=entry["Key"])["Body"].read()
        objects[entry["Key"].removeprefix("land/")] = cpu.Buffer.from_bytes(body)
group = zarr.open_group(zarr.storage.MemoryStore(objects), mode="r")
for level in range(levels):
    wanted = numpy.fromfile(f"{folder}/{level}.raw", dtype="<u2").reshape(json.load(open(f"{folder}/{level}.json")))
    found = group[str(level)][:]
    assert found.any() and found.shape == wanted.shape and (found == wanted).all(), level
"#;

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
        ObjectStore::open_with(address, environment.map(|(name, value)| (name.to_owned(), value.to_owned()))).unwrap()
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
    let again = bake(&*land, &plan, Part::Whole, &store, &mut |_, _| {}).unwrap();
    assert_eq!((again.written, again.skipped), (0, 16));
    bake(&*land, &plan, Part::Whole, &Directory::new(folder.path().join("store")), &mut |_, _| {}).unwrap();
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

/// How a web server answers a request.
#[derive(Clone, Copy, Debug)]
enum Answer {
    Right,
    /// 500.
    Error,
    /// It hangs up in the middle of the bytes.
    Half,
}

/// A web server over a folder that answers its requests as it is told; those after that, it answers right.
struct WebServer {
    address: String,
    answers: Arc<Mutex<Vec<Answer>>>,
    requests: Arc<AtomicUsize>,
}

impl WebServer {
    fn start(folder: PathBuf) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}/", listener.local_addr().unwrap());
        let (answers, requests) = (Arc::new(Mutex::new(Vec::new())), Arc::new(AtomicUsize::new(0)));
        let server = Self { address, answers: answers.clone(), requests: requests.clone() };
        // It ends with the test.
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (folder, answers, requests) = (folder.clone(), answers.clone(), requests.clone());
                std::thread::spawn(move || serve(stream, &folder, &answers, &requests));
            }
        });
        server
    }

    fn answers(&self, answers: &[Answer]) {
        *self.answers.lock().unwrap() = answers.iter().rev().copied().collect();
    }
}

/// Answers one request, and closes.
fn serve(mut stream: TcpStream, folder: &Path, answers: &Mutex<Vec<Answer>>, requests: &AtomicUsize) {
    let mut lines = BufReader::new(stream.try_clone().unwrap()).lines().map_while(Result::ok);
    let Some(request) = lines.next() else { return };
    let headers: Vec<String> =
        lines.take_while(|line| !line.is_empty()).map(|line| line.to_ascii_lowercase()).collect();
    requests.fetch_add(1, Ordering::Relaxed);
    let answer = answers.lock().unwrap().pop().unwrap_or(Answer::Right);
    let path = request.split(' ').nth(1).unwrap_or("/").trim_start_matches('/');
    let head = |status: &str, more: &str, length: usize| {
        format!("HTTP/1.1 {status}\r\nContent-Length: {length}\r\nConnection: close\r\n{more}\r\n")
    };
    let (head, body) = match (answer, std::fs::read(folder.join(path))) {
        (Answer::Error, _) => (head("500 Internal Server Error", "", 0), Vec::new()),
        (_, Err(_)) => (head("404 Not Found", "", 0), Vec::new()),
        (_, Ok(bytes)) => match headers.iter().find_map(|line| line.strip_prefix("range: bytes=")) {
            None => (head("200 OK", "", bytes.len()), bytes),
            Some(range) => {
                let size = bytes.len();
                let (from, to) = match range.split_once('-').unwrap() {
                    ("", last) => (size - last.parse::<usize>().unwrap().min(size), size),
                    (from, to) => (from.parse().unwrap(), to.parse::<usize>().unwrap() + 1),
                };
                let more = format!("Content-Range: bytes {from}-{}/{size}\r\n", to - 1);
                (head("206 Partial Content", &more, to - from), bytes[from..to].to_vec())
            }
        },
    };
    let sent = if matches!(answer, Answer::Half) { &body[..body.len() / 2] } else { &body[..] };
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(sent));
    let _ = stream.shutdown(std::net::Shutdown::Write);
    let _ = stream.read(&mut [0; 64]);
}

#[test]
fn a_web_server_that_fails_is_asked_again() {
    let (land, folder) = (land(), tempfile::tempdir().unwrap());
    let plan = plan(&*land);
    bake(&*land, &plan, Part::Whole, &Directory::new(folder.path().to_owned()), &mut |_, _| {}).unwrap();
    let server = WebServer::start(folder.path().to_owned());
    let solid = solid_tile(&*land, &plan);
    let wanted = expected(&*land, &plan, solid);
    let open = || ZarrSource::open(&server.address, Path::new("/"));
    for answers in [
        &[Answer::Right, Answer::Error, Answer::Right, Answer::Error][..],
        &[Answer::Right, Answer::Half, Answer::Right, Answer::Half],
        &[Answer::Error, Answer::Half, Answer::Right],
    ] {
        server.answers(answers);
        assert_eq!(open().unwrap().try_chunk(solid.0, solid.1).as_ref(), Ok(&wanted), "{answers:?}");
    }
    // For longer than anybody waits.
    let source = open().unwrap();
    let before = server.requests.load(Ordering::Relaxed);
    server.answers(&[Answer::Half; 200]);
    let error = source.try_chunk(solid.0, solid.1).unwrap_err().to_string();
    assert!(error.contains(&server.address) && error.contains("0/c/"), "{error}");
    assert!(server.requests.load(Ordering::Relaxed) > before + 2);
    server.answers(&[]);
    assert_eq!(source.try_chunk(solid.0, solid.1), Ok(wanted));
}
