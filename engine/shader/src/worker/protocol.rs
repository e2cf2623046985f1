//! The messages between parent and child, over the child's stdin and stdout: postcard, each message after its length in four bytes.

use std::io::{self, Read, Write};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::CompileLimits;
use crate::front_end::{Include, Included, Job, Outcome};

/// Longest message: a module of the largest size that is read, with room for its encoding.
const MAX_BYTES: u32 = 64 << 20;

/// From the parent.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Order {
    Compile(Job, CompileLimits),
    /// The answer to [`Reply::Include`].
    Included(Included),
}

/// From the child.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Reply {
    /// The first message: the version of the compiler that the child is built of.
    Hello(String),
    Include(Include),
    Done(Outcome),
}

pub(super) fn write(message: &impl Serialize, to: &mut impl Write) -> io::Result<()> {
    let bytes = postcard::to_stdvec(message).map_err(io::Error::other)?;
    let length = u32::try_from(bytes.len()).ok().filter(|length| *length <= MAX_BYTES);
    let length = length.ok_or_else(|| io::Error::other(format!("a message of {} bytes", bytes.len())))?;
    to.write_all(&length.to_le_bytes())?;
    to.write_all(&bytes)?;
    to.flush()
}

pub(super) fn read<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<T> {
    let mut length = [0; 4];
    from.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length);
    if length > MAX_BYTES {
        return Err(io::Error::other(format!("a message of {length} bytes")));
    }
    let mut bytes = Vec::new();
    from.take(u64::from(length)).read_to_end(&mut bytes)?;
    postcard::from_bytes(&bytes).map_err(io::Error::other)
}
