//! Stores that are reached over the network: S3 and what speaks like it, and web servers.

use std::sync::Arc;
use std::time::Duration;

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{ClientOptions, GetOptions, GetRange, RetryConfig};
use tokio::runtime::Runtime;

use crate::store::{Store, StoreError, Wanted};

/// How long a request may take in all, with the times it is tried again. What is above this layer tries again later.
const PATIENCE: Duration = Duration::from_secs(30);
/// How long one answer may take, from the request to its last byte.
const ANSWER: Duration = Duration::from_secs(20);

/// Objects below a prefix of a bucket or a web server.
pub struct ObjectStore {
    store: Arc<dyn object_store::ObjectStore>,
    prefix: Path,
    /// Its threads wait for the network; whoever asks waits for them.
    runtime: Runtime,
}

impl ObjectStore {
    /// Opens `s3://BUCKET/PREFIX`, with credentials, region and endpoint from the environment (`AWS_…`), or a folder of a web server.
    pub fn open(address: &str) -> Result<Self, String> {
        let text = |text: std::ffi::OsString| text.into_string().ok();
        Self::open_with(address, std::env::vars_os().filter_map(|(name, value)| Some((text(name)?, text(value)?))))
    }

    /// The same in another environment.
    pub fn open_with(address: &str, environment: impl IntoIterator<Item = (String, String)>) -> Result<Self, String> {
        let text = |error: object_store::Error| error.to_string();
        let retry = RetryConfig { max_retries: 4, retry_timeout: PATIENCE, ..RetryConfig::default() };
        let options = ClientOptions::new().with_timeout(ANSWER).with_connect_timeout(ANSWER);
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
        Ok(Self { store, prefix, runtime: runtime.map_err(|error| error.to_string())? })
    }

    fn path(&self, key: &str) -> Path {
        self.prefix.parts().chain(Path::from(key).parts()).collect()
    }
}

impl Store for ObjectStore {
    fn get(&self, key: &str, wanted: Wanted) -> Result<Option<Vec<u8>>, StoreError> {
        let range = match wanted {
            Wanted::Whole => None,
            Wanted::Bytes(range) => Some(GetRange::Bounded(range)),
            Wanted::Last(count) => Some(GetRange::Suffix(count)),
        };
        let path = self.path(key);
        let bytes = self.runtime.block_on(async {
            let options = GetOptions { range, ..GetOptions::default() };
            self.store.get_opts(&path, options).await?.bytes().await
        });
        match bytes {
            Ok(bytes) => Ok(Some(bytes.into())),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(failed(key, &error)),
        }
    }

    fn put(&self, key: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let (path, bytes) = (self.path(key), bytes.to_vec());
        let put = self.runtime.block_on(async { self.store.put(&path, bytes.into()).await });
        put.map(|_| ()).map_err(|error| failed(key, &error))
    }
}

fn failed(key: &str, error: &object_store::Error) -> StoreError {
    use object_store::Error;
    // What the server refuses, it refuses the next time, too.
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
