//! Resources that plans get from outside: a buffer, an image, or both, with a version that changes with their contents. The runtime writes
//! parts of them between frames.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use raxel_gpu::{Buffer, Image};
use raxel_graph::plan::{SourceSize, copy_name};
use raxel_shader::format::Format;

/// Bytes of writes that may wait for the next frame, over all sources of a device.
const WAITING_BYTES: usize = 256 << 20;

/// Something on the device that plans read and do not make.
#[derive(Debug)]
pub struct ExternalResource {
    name: String,
    buffer: Option<Arc<Buffer>>,
    image: Option<(Arc<Image>, Format)>,
    version: AtomicU64,
    queue: Arc<WriteQueue>,
    /// Writes that were asked for and are not submitted.
    waiting: AtomicU64,
}

/// Writes that wait for the next frame, in the order in which they were made.
#[derive(Debug, Default)]
pub(super) struct WriteQueue {
    waiting: Mutex<Waiting>,
}

#[derive(Debug, Default)]
struct Waiting {
    writes: VecDeque<Write>,
    bytes: usize,
}

/// A part of a source with its new contents.
#[derive(Debug)]
pub(super) struct Write {
    pub(super) source: Arc<ExternalResource>,
    pub(super) part: Part,
    pub(super) bytes: Vec<u8>,
    /// The write after it is for the same frame.
    joined: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// From this byte of the buffer on.
    Bytes { offset: u64 },
    /// A box of texels of one mip of the image.
    Texels { mip: u32, first: [u32; 3], extent: [u32; 3] },
}

/// Why a source cannot be written.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// No plan uses a source of that name.
    #[error("no source `{name}` is on the device: nothing that runs binds it")]
    NotThere {
        /// The name.
        name: String,
    },
    /// The part reaches beyond the end.
    #[error("`{name}` has no {part}")]
    OutOfRange {
        /// Name of the source.
        name: String,
        /// The part, and the existing size.
        part: String,
    },
    /// Too many bytes wait already.
    #[error("{waiting} bytes wait to be written already: run a frame first")]
    TooMany {
        /// Bytes that wait.
        waiting: usize,
    },
}

/// The next version of any source: no two contents have the same.
static VERSION: AtomicU64 = AtomicU64::new(1);

fn next_version() -> u64 {
    VERSION.fetch_add(1, Ordering::Relaxed)
}

impl ExternalResource {
    pub(super) fn new(
        name: &str,
        buffer: Option<Arc<Buffer>>,
        image: Option<(Arc<Image>, Format)>,
        queue: Arc<WriteQueue>,
    ) -> Arc<Self> {
        Arc::new(Self {
            name: name.to_owned(),
            buffer,
            image,
            version: AtomicU64::new(next_version()),
            queue,
            waiting: AtomicU64::new(0),
        })
    }

    /// Its name, e.g. `world.tree64`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its buffer.
    pub(crate) fn buffer(&self) -> Option<&Arc<Buffer>> {
        self.buffer.as_ref()
    }

    /// Its image, in `GENERAL`.
    pub(crate) fn image(&self) -> Option<&Arc<Image>> {
        self.image.as_ref().map(|(image, _)| image)
    }

    /// Equal versions, equal contents. No two sources share a version.
    pub fn version(&self) -> u64 {
        self.version.load(Ordering::Acquire)
    }

    /// The facts about its size that a plan needs.
    pub fn size(&self) -> SourceSize {
        SourceSize {
            bytes: self.buffer.as_ref().map_or(0, |buffer| buffer.size()),
            image: self.image().map(|image| image.info().extent),
        }
    }

    /// Replaces bytes of the buffer from `offset` on, before the next frame. From any thread; nothing waits.
    pub fn write(self: &Arc<Self>, offset: u64, bytes: &[u8]) -> Result<(), WriteError> {
        self.queue.push([self.bytes(offset, bytes)?])
    }

    /// Replaces the first bytes of the buffers of several sources of one device, before one frame: no frame sees some of them alone. From
    /// any thread; nothing waits. After an error, none is replaced.
    pub fn write_together(parts: &[(&Arc<Self>, &[u8])]) -> Result<(), WriteError> {
        let writes = parts.iter().map(|(source, bytes)| source.bytes(0, bytes)).collect::<Result<Vec<Write>, _>>()?;
        parts.first().map_or(Ok(()), |(source, _)| source.queue.push(writes))
    }

    /// A write of bytes, if the buffer has them.
    fn bytes(self: &Arc<Self>, offset: u64, bytes: &[u8]) -> Result<Write, WriteError> {
        let size = self.buffer.as_ref().map_or(0, |buffer| buffer.size());
        if offset.checked_add(bytes.len() as u64).is_none_or(|end| end > size) {
            let part = format!("bytes {offset} to {}: it has {size}", offset.saturating_add(bytes.len() as u64));
            return Err(WriteError::OutOfRange { name: self.name.clone(), part });
        }
        Ok(Write { source: self.clone(), part: Part::Bytes { offset }, bytes: bytes.to_vec(), joined: false })
    }

    /// Replaces a box of texels of one mip of the image, before the next frame: x first, then y, then z, without padding. From any
    /// thread; nothing waits.
    pub fn write_texels(
        self: &Arc<Self>,
        mip: u32,
        first: [u32; 3],
        extent: [u32; 3],
        bytes: &[u8],
    ) -> Result<(), WriteError> {
        let refused = |part: String| Err(WriteError::OutOfRange { name: self.name.clone(), part });
        let Some((image, format)) = self.image.as_ref().filter(|(image, _)| mip < image.info().mips) else {
            return refused(format!("mip {mip} of an image"));
        };
        let there = image.mip_extent(mip);
        let inside = (0..3).all(|axis| {
            extent[axis] > 0 && first[axis].checked_add(extent[axis]).is_some_and(|end| end <= there[axis])
        });
        let texels = extent.iter().fold(1_u64, |texels, side| texels.saturating_mul(u64::from(*side)));
        if !inside || texels.checked_mul(u64::from(format.bytes())) != Some(bytes.len() as u64) {
            return refused(format!(
                "{extent:?} texels at {first:?} in {} bytes: mip {mip} has {there:?}",
                bytes.len()
            ));
        }
        let part = Part::Texels { mip, first, extent };
        self.queue.push([Write { source: self.clone(), part, bytes: bytes.to_vec(), joined: false }])
    }

    /// Whether a write of it is not part of a submitted frame yet.
    pub fn is_waiting(&self) -> bool {
        self.waiting.load(Ordering::Acquire) > 0
    }

    /// Notes that the frame with one of its writes was submitted.
    pub(super) fn submitted(&self) {
        self.waiting.fetch_sub(1, Ordering::AcqRel);
    }

    /// Bytes that wait to be written before the next frame, over all sources of the device.
    pub fn waiting_bytes(&self) -> usize {
        self.queue.waiting.lock().unwrap_or_else(PoisonError::into_inner).bytes
    }

    /// Notes that its contents change with the frame that is being recorded.
    pub(super) fn changed(&self) {
        self.version.store(next_version(), Ordering::Release);
    }
}

impl WriteQueue {
    /// Adds writes for one frame: all, or none where too many bytes wait already.
    fn push(&self, writes: impl IntoIterator<Item = Write>) -> Result<(), WriteError> {
        let mut writes: Vec<Write> = writes.into_iter().filter(|write| !write.bytes.is_empty()).collect();
        let bytes = writes.iter().map(|write| write.bytes.len()).sum();
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.bytes.saturating_add(bytes) > WAITING_BYTES {
            return Err(WriteError::TooMany { waiting: waiting.bytes });
        }
        waiting.bytes += bytes;
        if let [before @ .., _] = &mut writes[..] {
            before.iter_mut().for_each(|write| write.joined = true);
        }
        for write in writes {
            write.source.waiting.fetch_add(1, Ordering::AcqRel);
            waiting.writes.push_back(write);
        }
        Ok(())
    }

    /// Takes the oldest whole writes, about `most` bytes of them. It takes at least one if there is any, with the writes that belong to the
    /// same frame.
    pub(super) fn take(&self, most: usize, taken: &mut Vec<Write>) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut bytes, mut joined) = (0, false);
        while let Some(next) = waiting.writes.front() {
            let size = next.bytes.len();
            if bytes > 0 && bytes + size > most && !joined {
                return;
            }
            joined = next.joined;
            bytes += size;
            waiting.bytes -= size;
            taken.extend(waiting.writes.pop_front());
        }
    }
}

/// Resources supplied to a plan, by the name of the resource that each stands for.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    by_resource: BTreeMap<String, Arc<ExternalResource>>,
}

impl Sources {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Supplies a resource, or another source for it.
    pub fn insert(&mut self, resource: &str, source: Arc<ExternalResource>) {
        self.by_resource.insert(resource.to_owned(), source);
    }

    /// The supplied resource of that name.
    pub fn get(&self, resource: &str) -> Option<&Arc<ExternalResource>> {
        self.by_resource.get(resource)
    }

    /// Sizes by the planner's names: supplied resources may be read and copied.
    pub fn sizes(&self) -> BTreeMap<String, SourceSize> {
        let sources = self.by_resource.values();
        sources
            .flat_map(|source| [source.name.clone(), copy_name(&source.name)].map(|name| (name, source.size())))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(source: &Arc<ExternalResource>, bytes: usize) -> Write {
        Write { source: source.clone(), part: Part::Bytes { offset: 0 }, bytes: vec![0; bytes], joined: false }
    }

    #[test]
    fn writes_that_belong_together_go_together_or_not_at_all() {
        let queue = Arc::new(WriteQueue::default());
        let [a, b] = ["a", "b"].map(|name| ExternalResource::new(name, None, None, queue.clone()));
        queue.push([write(&a, 90)]).unwrap();
        queue.push([write(&a, 20), write(&b, 20)]).unwrap();
        queue.push([write(&b, 10)]).unwrap();
        let take = || {
            let mut taken = Vec::new();
            queue.take(110, &mut taken);
            taken.iter().map(|write| (write.source.name().to_owned(), write.bytes.len())).collect::<Vec<_>>()
        };
        let of =
            |list: &[(&str, usize)]| list.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)).collect::<Vec<_>>();
        // The limit lies between the two that belong together.
        assert_eq!(take(), of(&[("a", 90), ("a", 20), ("b", 20)]));
        assert_eq!(take(), of(&[("b", 10)]));
        assert_eq!((take(), a.waiting_bytes()), (Vec::new(), 0));

        queue.push([write(&a, WAITING_BYTES - 30)]).unwrap();
        let refused = queue.push([write(&a, 20), write(&b, 20)]);
        assert_eq!(refused, Err(WriteError::TooMany { waiting: WAITING_BYTES - 30 }));
        assert_eq!(take(), of(&[("a", WAITING_BYTES - 30)]));
        assert_eq!(take(), Vec::new(), "neither of the two");
    }
}
