//! Names of contents: 128 bits of XXH3, so that two different contents never get the same name by chance.

use xxhash_rust::xxh3::xxh3_128_with_seed;

/// Equal digests, equal contents.
pub(super) type Digest = u128;

/// The digest of bytes. Different seeds give unrelated digests of the same bytes.
pub(super) fn of_bytes(seed: u64, bytes: &[u8]) -> Digest {
    xxh3_128_with_seed(bytes, seed)
}

/// The digest of several digests in order.
pub(super) fn of(seed: u64, digests: &[Digest]) -> Digest {
    of_bytes(seed, bytemuck::cast_slice(digests))
}

/// The digest of what a value looks like in debug output.
pub(super) fn of_debug(seed: u64, value: &impl std::fmt::Debug) -> Digest {
    of_bytes(seed, format!("{value:?}").as_bytes())
}
