//! Entries as objects of a bucket, in a store that speaks the protocol of S3.

use super::{CacheStorage, STORE};
use object_store::aws::{AmazonS3, AmazonS3Builder, AmazonS3ConfigKey};
use object_store::{ClientConfigKey, Error, ObjectStore, ObjectStoreExt, RetryConfig, path::Path};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};
use std::{error::Error as _, path::PathBuf};
use throng_motion::error::{BuildError, Result, ensure};
use tokio::runtime::{Builder, Runtime};

/// Size of the parts in which longer entries are sent; such an entry appears when all parts have arrived (bytes).
const PART: usize = 64 << 20;
/// Time for which a request to an unreachable or busy store is retried.
const PATIENCE: Duration = Duration::from_secs(30);

/// A part of a bucket: the objects below a prefix.
///
/// Endpoint, region and credentials come from the environment, by the names that `object_store` knows:
/// `AWS_ENDPOINT_URL`, `AWS_REGION`, `AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`, `AWS_ALLOW_HTTP` and others.
#[derive(Debug)]
pub(super) struct ObjectStorage {
    /// Address as given, without a trailing slash.
    address: String,
    prefix: Path,
    store: AmazonS3,
    runtime: Runtime,
    /// True once the store has failed to answer: later requests fail at once.
    is_away: AtomicBool,
}

impl ObjectStorage {
    /// - `address`: `s3://BUCKET/PREFIX`; the prefix may be left out.
    ///
    /// # Errors
    /// [`BuildError::Store`] if the store does not answer, refuses, or has no such bucket.
    pub(super) fn open(address: &str) -> Result<Self> {
        let address = address.trim_end_matches('/');
        let of = |why: String| BuildError::Store { address: address.into(), why };
        let name = address.strip_prefix(STORE).unwrap_or_default();
        let (bucket, prefix) = name.split_once('/').unwrap_or((name, ""));
        ensure(!bucket.is_empty(), || of("expected s3://BUCKET/PREFIX".into()))?;
        // rustls needs a choice if a program has none or several providers; an earlier choice stays.
        _ = rustls::crypto::ring::default_provider().install_default();
        let mut settings = AmazonS3Builder::from_env().with_bucket_name(bucket).with_retry(RetryConfig {
            retry_timeout: PATIENCE,
            max_retries: 6,
            ..RetryConfig::default()
        });
        // An entry may take long, but a connection that transfers nothing times out soon.
        for (key, time) in [(ClientConfigKey::Timeout, "30min"), (ClientConfigKey::ReadTimeout, "60s")] {
            let key = AmazonS3ConfigKey::Client(key);
            if std::env::var_os(format!("AWS_{}", key.as_ref().to_uppercase())).is_none() {
                settings = settings.with_config(key, time);
            }
        }
        let store = settings.build().map_err(|e| of(e.to_string()))?;
        let prefix = Path::parse(prefix).map_err(|e| of(e.to_string()))?;
        // One thread serves the connections; callers wait on their own threads.
        let runtime = Builder::new_multi_thread().worker_threads(1).enable_all().build();
        let runtime = runtime.map_err(|e| of(e.to_string()))?;
        let objects = Self { address: address.into(), prefix, store, runtime, is_away: AtomicBool::new(false) };
        // An existing bucket answers that it has no such object.
        match objects.runtime.block_on(objects.store.get(&objects.path(".throng"))) {
            Err(e @ Error::NotFound { .. }) if !e.to_string().contains("NoSuchBucket") => Ok(objects),
            Err(e) => Err(objects.describe_error("it cannot be asked for an object", e)),
            Ok(_) => Ok(objects),
        }
    }

    fn path(&self, name: &str) -> Path {
        self.prefix.clone().join(name)
    }

    /// Result of a request; not sent if the store has failed to answer an earlier one.
    fn request<T>(&self, what: &str, request: impl Future<Output = object_store::Result<T>>) -> Result<Option<T>> {
        if self.is_away.load(Ordering::Relaxed) {
            let why = "it is not asked any more, as it did not answer before".into();
            return Err(BuildError::Store { address: self.address.clone(), why });
        }
        match self.runtime.block_on(request) {
            Ok(got) => Ok(Some(got)),
            Err(Error::NotFound { .. }) => Ok(None),
            Err(e) => {
                self.is_away.fetch_or(matches!(e, Error::Generic { .. }), Ordering::Relaxed);
                Err(self.describe_error(what, e))
            }
        }
    }

    /// Error message of a failed request, with a way out.
    fn describe_error(&self, what: &str, e: Error) -> BuildError {
        let way_out = match &e {
            Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => {
                "Check AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, and that they may list, read and write in this bucket"
            }
            Error::NotFound { .. } => "Make the bucket first, or check its name and AWS_ENDPOINT_URL",
            _ => {
                "Check AWS_ENDPOINT_URL, AWS_REGION, AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and the network; \
                 AWS_ALLOW_HTTP=true allows http://"
            }
        };
        let why = format!("{what}: {}. {way_out}", error_text(&e));
        BuildError::Store { address: self.address.clone(), why }
    }

    async fn put(&self, path: &Path, bytes: Vec<u8>) -> object_store::Result<()> {
        if bytes.len() <= PART {
            return self.store.put(path, bytes.into()).await.map(drop);
        }
        let mut upload = self.store.put_multipart(path).await?;
        for part in bytes.chunks(PART) {
            if let Err(e) = upload.put_part(part.to_vec().into()).await {
                // Parts that remain are removed by the bucket's own rules.
                _ = upload.abort().await;
                return Err(e);
            }
        }
        upload.complete().await.map(drop)
    }
}

/// Text of an error: the store's answer, or else the whole chain of causes, of which the last says most.
fn error_text(e: &Error) -> String {
    let mut causes = vec![e.to_string()];
    let mut cause = e.source();
    while let Some(inner) = cause {
        if !causes.iter().any(|c| c.contains(&inner.to_string())) {
            causes.push(inner.to_string());
        }
        cause = inner.source();
    }
    let all = causes.join(": ");
    let between = |tag: &str| {
        let (_, after) = all.split_once(&format!("<{tag}>"))?;
        Some(after.split_once('<')?.0)
    };
    match (between("Code"), between("Message")) {
        (Some(code), Some(message)) => format!("{code}: {}", message.trim_end_matches('.')),
        _ => all.split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

impl CacheStorage for ObjectStorage {
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let bytes = async { self.store.get(&self.path(name)).await?.bytes().await };
        Ok(self.request(&format!("{name} cannot be read"), bytes)?.map(Into::into))
    }

    fn has_entry(&self, name: &str) -> Result<bool> {
        let path = self.path(name);
        Ok(self.request(&format!("{name} cannot be looked for"), self.store.head(&path))?.is_some())
    }

    fn write(&self, name: &str, bytes: Vec<u8>) -> Result<()> {
        let what = format!("{name} cannot be written");
        match self.request(&what, self.put(&self.path(name), bytes))? {
            Some(()) => Ok(()),
            None => {
                Err(BuildError::Store { address: self.address.clone(), why: format!("{what}: the bucket is gone") })
            }
        }
    }

    fn remove(&self, name: &str) -> Result<()> {
        let path = self.path(name);
        self.request(&format!("{name} cannot be removed"), self.store.delete(&path)).map(drop)
    }

    fn list(&self) -> Result<Vec<(String, u64, SystemTime)>> {
        let listed =
            self.request("its objects cannot be listed", self.store.list_with_delimiter(Some(&self.prefix)))?;
        let of = |o: object_store::ObjectMeta| {
            Some((o.location.filename()?.to_owned(), o.size, SystemTime::from(o.last_modified)))
        };
        Ok(listed.into_iter().flat_map(|all| all.objects).filter_map(of).collect())
    }

    fn touch(&self, _: &str, _: Option<SystemTime>) {}

    fn tidy(&self) -> bool {
        false
    }

    fn address(&self, name: &str) -> PathBuf {
        PathBuf::from(format!("{}/{name}", self.address))
    }

    fn is_folder(&self) -> bool {
        false
    }
}
