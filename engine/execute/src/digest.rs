//! Names of contents: 128 bits of XXH3, so that two different contents never get the same name by chance.

use std::hash::{Hash, Hasher};

use xxhash_rust::xxh3::{Xxh3, xxh3_128_with_seed};

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

/// The digest of a value by its [`Hash`]. It covers every part with its length or its variant, so different values feed different bytes.
/// Floats have no `Hash`; their callers give the bits.
pub(super) fn of_value(seed: u64, value: &impl Hash) -> Digest {
    let mut bytes = Bytes(Xxh3::with_seed(seed));
    value.hash(&mut bytes);
    bytes.0.digest128()
}

/// Feeds a [`Hash`] to a hash of 128 bits.
struct Bytes(Xxh3);

impl Hasher for Bytes {
    fn write(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    fn finish(&self) -> u64 {
        self.0.digest()
    }
}

#[cfg(test)]
mod tests {
    use raxel_graph::checked::{Clear, Dispatch, ResourceId};

    use super::*;

    #[test]
    fn values_that_differ_have_other_digests() {
        let nan = |payload: u32| f32::from_bits(0x7fc0_0000 | payload);
        let floats = [0.0, -0.0, 1.0, f32::MIN_POSITIVE, f32::INFINITY, nan(0), nan(1)];
        let mut clears = Vec::new();
        for value in floats {
            clears.extend((0..4).map(|channel| {
                let mut of = [2.0; 4];
                of[channel] = value;
                Clear::Float(of)
            }));
        }
        // The same bits in another kind.
        clears.extend([Clear::Int([0; 4]), Clear::Uint([0; 4]), Clear::Float([0.0; 4])]);
        let buffer = ResourceId(1);
        let dispatches = [
            Dispatch::ThreadsOfWorld,
            Dispatch::Threads([1, 2, 3]),
            Dispatch::Groups([1, 2, 3]),
            Dispatch::Groups([3, 2, 1]),
            Dispatch::ThreadsOf { target: buffer, mip: 2 },
            Dispatch::ElementsOf { buffer },
            Dispatch::Indirect { buffer, offset: 0 },
            Dispatch::Indirect { buffer, offset: 1 << 32 },
            Dispatch::GroupsOf { target: buffer, mip: 2, tile: [1, 1, 2] },
            Dispatch::GroupsOf { target: buffer, mip: 2, tile: [1, 2, 1] },
        ];
        // The last element of one list is the first of the next.
        let lists = [(vec![1u32, 2], vec![3u32]), (vec![1], vec![2, 3]), (vec![], vec![1, 2, 3])];
        let mut digests: Vec<Digest> = clears.iter().map(|clear| of_value(0, &Some(clear.bits()))).collect();
        digests.push(of_value(0, &None::<(u8, [u32; 4])>));
        digests.extend(dispatches.iter().map(|dispatch| of_value(0, dispatch)));
        digests.extend(lists.iter().map(|lists| of_value(0, lists)));
        digests.extend(lists.iter().map(|lists| of_value(1, lists)));
        let count = digests.len();
        digests.sort_unstable();
        digests.dedup();
        assert_eq!(digests.len(), count);
        assert_eq!(of_value(7, &dispatches), of_value(7, &dispatches.clone()));
    }
}
