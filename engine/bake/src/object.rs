//! Stores that are reached over the network: Stores that are reached over the network: S3 and services like it, and web servers.

use std::sync::Arc;
use std::time::Duration;

use futures_util::TryStreamExt as _;
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{BackoffConfig, ClientOptions, GetOptions, GetRange, RetryConfig};
use tokio::runtime::Runtime;

use crate::store::{DOCUMENT, PAUSES, Store, StoreError, Wanted};

/// The longest wait for a server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patience {
    /// One answer, from the request to its last byte.
    pub answer: Duration,
    /// A request in all, with the times it is tried again.
    pub request: Duration,
    /// The first pause before a request is tried again; later ones are longer.
    pub pause: Duration,
    /// [`Store::pauses`].
    pub pauses: Vec<Duration>,
}

impl Default for Patience {
    fn default() -> Self {
        let [answer, request] = [20, 30].map(Duration::from_secs);
        Self { answer, request, pause: Duration::from_millis(100), pauses: PAUSES.to_vec() }
    }
}

/// Objects below a prefix of a bucket or a web server.
pub struct ObjectStore {
    store: Arc<dyn object_store::ObjectStore>,
    prefix: Path,
    patience: Patience,
    /// Its threads wait for the network, and callers wait for these threads.
    runtime: Runtime,
}

impl ObjectStore {
    /// Opens `s3://BUCKET/PREFIX`, with credentials, region and endpoint from the environment (`AWS_…`), or a folder of a web server.
    pub fn open(address: &str) -> Result<Self, String> {
        let text = |text: std::ffi::OsString| text.into_string().ok();
        let environment = std::env::vars_os().filter_map(|(name, value)| Some((text(name)?, text(value)?)));
        Self::open_with(address, environment, Patience::default())
    }

    /// The same in another environment, and with other limits of time.
    pub fn open_with(
        address: &str,
        environment: impl IntoIterator<Item = (String, String)>,
        patience: Patience,
    ) -> Result<Self, String> {
        let text = |error: object_store::Error| error.to_string();
        let backoff = BackoffConfig { init_backoff: patience.pause, ..BackoffConfig::default() };
        let retry = RetryConfig { backoff, max_retries: 4, retry_timeout: patience.request };
        let options = ClientOptions::new().with_timeout(patience.answer).with_connect_timeout(patience.answer);
        let (store, prefix): (Arc<dyn object_store::ObjectStore>, &str) =
            if let Some(rest) = address.strip_prefix("s3://") {
                let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
                let mut builder = AmazonS3Builder::new();
                // An endpoint that somebody names may be one without TLS.
                let mut http = false;
                for (name, value) in environment {
                    let name = name.to_ascii_lowercase();
                    if let Some(key) = name.starts_with("aws_").then(|| name.parse().ok()).flatten() {
                        http |= key == AmazonS3ConfigKey::Endpoint && value.starts_with("http://");
                        builder = builder.with_config(key, value);
                    }
                }
                let builder = builder.with_bucket_name(bucket).with_retry(retry);
                let store = builder.with_client_options(options.with_allow_http(http)).build().map_err(text)?;
                (Arc::new(store), prefix)
            } else {
                let options = options.with_allow_http(address.starts_with("http://"));
                let builder = HttpBuilder::new().with_url(address).with_retry(retry).with_client_options(options);
                (Arc::new(builder.build().map_err(text)?), "")
            };
        let prefix = Path::parse(prefix.trim_matches('/')).map_err(|error| error.to_string())?;
        let mut runtime = tokio::runtime::Builder::new_multi_thread();
        let runtime = runtime.worker_threads(2).enable_all().thread_name("store").build();
        Ok(Self { store, prefix, patience, runtime: runtime.map_err(|error| error.to_string())? })
    }

    fn path(&self, key: &str) -> Path {
        self.prefix.parts().chain(Path::from(key).parts()).collect()
    }
}

impl Store for ObjectStore {
    fn get(&self, key: &str, wanted: Wanted) -> Result<Option<Vec<u8>>, StoreError> {
        let range = match &wanted {
            Wanted::Whole | Wanted::Document => None,
            Wanted::Bytes(range) => Some(GetRange::Bounded(range.clone())),
            Wanted::Last(count) => Some(GetRange::Suffix(*count)),
        };
        let most = if wanted == Wanted::Document { DOCUMENT } else { u64::MAX };
        let (store, path) = (self.store.clone(), self.path(key));
        // On a thread of the runtime, so that a panic on unforeseen headers is an error here.
        let read = self.runtime.spawn(async move {
            let options = GetOptions { range, ..GetOptions::default() };
            read(store.get_opts(&path, options).await?, most).await
        });
        match self.runtime.block_on(read).unwrap_or_else(|source| Err(object_store::Error::JoinError { source })) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(failed(key, &error)),
        }
    }

    fn put(&self, key: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let (path, bytes) = (self.path(key), bytes.to_vec());
        let put = self.runtime.block_on(async { self.store.put(&path, bytes.into()).await });
        put.map(|_| ()).map_err(|error| failed(key, &error))
    }

    fn pauses(&self) -> &[Duration] {
        &self.patience.pauses
    }
}

/// Reads exactly the bytes that the headers of an answer promise, even if the server sends more.
async fn read(answer: object_store::GetResult, most: u64) -> object_store::Result<Vec<u8>> {
    let promised = answer.range.end.saturating_sub(answer.range.start);
    let wrong = |said: String| object_store::Error::Generic { store: "HTTP", source: said.into() };
    if promised > most {
        return Err(wrong(format!("it has {promised} bytes, and at most {most} are read")));
    }
    let mut bytes = Vec::new();
    let mut pieces = answer.into_stream();
    while let Some(piece) = pieces.try_next().await? {
        bytes.extend_from_slice(&piece);
        if bytes.len() as u64 > promised {
            return Err(wrong(format!("more bytes came than the {promised} that the headers promise")));
        }
    }
    if (bytes.len() as u64) < promised {
        return Err(wrong(format!("{} bytes came of the {promised} that the headers promise", bytes.len())));
    }
    Ok(bytes)
}

fn failed(key: &str, error: &object_store::Error) -> StoreError {
    use object_store::Error;
    // A request that the server refuses, it refuses the next time, too.
    let passing = matches!(error, Error::Generic { .. } | Error::JoinError { .. });
    let mut reason = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(inner) = cause {
        let text = inner.to_string();
        if !reason.contains(&text) {
            reason = format!("{reason}: {text}");
        }
        cause = inner.source();
    }
    StoreError { key: key.to_owned(), reason, passing }
}
