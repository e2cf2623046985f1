//! Alias: lets transient resources that never live at the same time share memory.
//!
//! Packing is greedy by size with best fit (Pisarchyk and Lee, "Efficient Memory Management for Deep Neural Net Inference", 2020, section
//! 5.2): the largest resource first, each at the place in a growing arena, free during its whole life, that makes the arena grow least and
//! leaves the smallest hole. If a resource would make an arena grow by its whole size, it begins another one. So every resource in an arena
//! shares bytes with another, and an arena of several is a block; a resource alone in one gets memory of its own.

use crate::back::lifetimes::Life;
use crate::ir::index::index32;
use crate::ir::plan::{BlockOffset, BlockPlan, Requirements, ResourceDesc, ResourcePlan};

/// The memory of a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Alias {
    /// By used resource: its place in a shared block.
    pub places: Vec<Option<BlockOffset>>,
    /// By used resource: the others that share memory with it, in order.
    pub neighbours: Vec<Vec<u32>>,
    /// Shared blocks.
    pub blocks: Vec<BlockPlan>,
}

/// A resource that may share memory.
struct Item {
    resource: u32,
    needs: Requirements,
    image: bool,
    life: (u32, u32),
    offset: u64,
}

impl Item {
    fn end(&self) -> u64 {
        self.offset + self.needs.size
    }

    /// Whether both have a byte in common; of two resources of different kinds, a page (`granularity` is `bufferImageGranularity`).
    fn touches(&self, other: &Item, granularity: u64) -> bool {
        let page = if self.image == other.image { 1 } else { granularity };
        let pages = |item: &Item| (item.offset / page, item.end().div_ceil(page));
        let (a, b) = (pages(self), pages(other));
        a.0 < b.1 && b.0 < a.1
    }

    fn meets(&self, other: &Item) -> bool {
        self.life.0 <= other.life.1 && other.life.0 <= self.life.1
    }
}

struct Arena {
    type_bits: u32,
    size: u64,
    items: Vec<Item>,
}

/// Finds a place for every transient resource.
pub(crate) fn alias(resources: &[ResourcePlan], lives: &[Life], granularity: u64, enabled: bool) -> Alias {
    let granularity = granularity.max(1);
    let mut result = Alias {
        places: vec![None; resources.len()],
        neighbours: vec![Vec::new(); resources.len()],
        blocks: Vec::new(),
    };
    if !enabled {
        return result;
    }
    let mut items: Vec<Item> = (0..)
        .zip(resources.iter().zip(lives))
        .filter_map(|(resource, (plan, life))| match *life {
            // A resource that is the same from frame to frame would have to be made again if it gave its memory away.
            Life::Transient { first, last } if plan.memory.size > 0 && plan.varies => Some(Item {
                resource,
                needs: Requirements { alignment: plan.memory.alignment.max(1), ..plan.memory },
                image: matches!(plan.desc, ResourceDesc::Image(_)),
                life: (first, last),
                offset: 0,
            }),
            _ => None,
        })
        .collect();
    items.sort_by_key(|item| (std::cmp::Reverse(item.needs.size), item.life.0, item.resource));
    let mut arenas: Vec<Arena> = Vec::new();
    for item in items {
        put(item, &mut arenas, granularity);
    }
    for arena in arenas.iter().filter(|arena| arena.items.len() > 1) {
        block(arena, granularity, &mut result);
    }
    result
}

/// Puts an item where its arena grows least.
fn put(mut item: Item, arenas: &mut Vec<Arena>, granularity: u64) {
    let mut best: Option<(u64, u64, usize, u64)> = None;
    for (index, arena) in arenas.iter().enumerate() {
        if arena.type_bits & item.needs.type_bits == 0 {
            continue;
        }
        let (offset, hole) = fit(&item, arena, granularity);
        let growth = (offset + item.needs.size).saturating_sub(arena.size);
        let place = (growth, hole, index, offset);
        if best.is_none_or(|best| place < best) {
            best = Some(place);
        }
    }
    match best {
        Some((growth, _, index, offset)) if growth < item.needs.size => {
            let arena = &mut arenas[index];
            item.offset = offset;
            arena.size += growth;
            arena.type_bits &= item.needs.type_bits;
            arena.items.push(item);
        }
        _ => arenas.push(Arena { type_bits: item.needs.type_bits, size: item.needs.size, items: vec![item] }),
    }
}

/// The offset in an arena, and the hole that it leaves. Of the offsets that do not grow the arena, it is the one with the smallest hole; if
/// there is none, the lowest offset.
fn fit(item: &Item, arena: &Arena, granularity: u64) -> (u64, u64) {
    let mut taken: Vec<(u64, u64)> =
        arena.items.iter().filter(|other| other.meets(item)).map(|other| (other.offset, other.end())).collect();
    taken.sort_unstable();
    // An item that takes whole pages has no page in common with one beside it.
    let mixed = arena.items.iter().any(|other| other.image != item.image && other.meets(item));
    let alignment = item.needs.alignment.max(if mixed { granularity } else { 1 });
    let size = item.needs.size.next_multiple_of(if mixed { granularity } else { 1 });
    let mut best: Option<(u64, u64)> = None;
    let mut free = 0;
    for (start, end) in taken {
        let offset = u64::next_multiple_of(free, alignment);
        if offset + size <= start {
            let hole = start - offset - size;
            if best.is_none_or(|(least, _)| hole < least) {
                best = Some((hole, offset));
            }
        }
        free = free.max(end);
    }
    let last = u64::next_multiple_of(free, alignment);
    if last + item.needs.size <= arena.size {
        let hole = arena.size - last - item.needs.size;
        if best.is_none_or(|(least, _)| hole < least) {
            best = Some((hole, last));
        }
    }
    best.map_or((last, 0), |(hole, offset)| (offset, hole))
}

fn block(arena: &Arena, granularity: u64, result: &mut Alias) {
    let number = index32(result.blocks.len());
    for item in &arena.items {
        result.places[item.resource as usize] = Some(BlockOffset { block: number, offset: item.offset });
        let shares = |other: &&Item| other.resource != item.resource && other.touches(item, granularity);
        let mut neighbours: Vec<u32> = arena.items.iter().filter(shares).map(|other| other.resource).collect();
        neighbours.sort_unstable();
        result.neighbours[item.resource as usize] = neighbours;
    }
    result.blocks.push(BlockPlan {
        size: arena.size,
        alignment: arena.items.iter().map(|item| item.needs.alignment).fold(granularity, u64::max),
        type_bits: arena.type_bits,
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::checked::{Clear, ResourceId};
    use crate::ir::plan::{BufferDesc, ImageDesc, ImageUsage, Lifetime};
    use raxel_shader::format::Format;

    fn resource(index: u32, size: u64) -> ResourcePlan {
        ResourcePlan {
            resource: ResourceId(index),
            desc: ResourceDesc::Buffer(BufferDesc { size, uniform: false, indirect: false }),
            memory: Requirements { size, alignment: 16, type_bits: 1 },
            copies: 1,
            clear: None,
            copy: None,
            init: Clear::Uint([0; 4]),
            lifetime: Lifetime::Persistent,
            varies: true,
        }
    }

    /// Random requirements of buffers and images, with random lives.
    fn mixed(random: &mut impl FnMut(u32) -> u32) -> (Vec<ResourcePlan>, Vec<Life>) {
        let count = 2 + random(24);
        let resources = (0..count).map(|index| {
            let alignment = 1_u64 << random(9);
            let size = u64::from(random(40)) * 16;
            let image = ImageDesc {
                format: Format::R32f,
                volume: false,
                extent: [1; 3],
                mips: 1,
                layers: 1,
                usage: ImageUsage::default(),
            };
            let plan = resource(index, 0);
            ResourcePlan {
                desc: if random(2) == 0 { ResourceDesc::Image(image) } else { plan.desc },
                memory: Requirements { size, alignment, type_bits: [0b111, 0b011, 0b110, 0b100][random(4) as usize] },
                varies: random(10) > 0,
                ..plan
            }
        });
        let resources: Vec<ResourcePlan> = resources.collect();
        let lives = (0..count).map(|_| match (random(10), random(24), random(6)) {
            (0, ..) => Life::Persistent,
            (_, first, more) => Life::Transient { first, last: first + more },
        });
        let lives = lives.collect();
        (resources, lives)
    }

    /// The bytes that a resource takes in its block, in pages of `page` bytes.
    fn pages(resource: &ResourcePlan, place: BlockOffset, page: u64) -> std::ops::Range<u64> {
        place.offset / page..(place.offset + resource.memory.size).div_ceil(page)
    }

    /// Finds faults of a packing, by trying every two resources.
    fn check(resources: &[ResourcePlan], lives: &[Life], granularity: u64, alias: &Alias) {
        let image = |index: usize| matches!(resources[index].desc, ResourceDesc::Image(_));
        let mut used = vec![(u64::MAX, 0, 0); alias.blocks.len()];
        for (index, place) in alias.places.iter().enumerate() {
            let Some(place) = *place else {
                assert!(alias.neighbours[index].is_empty(), "{index} has no place, but neighbours");
                continue;
            };
            let (needs, block) = (resources[index].memory, alias.blocks[place.block as usize]);
            assert!(
                resources[index].varies && needs.size > 0 && lives[index] != Life::Persistent,
                "{index} is not to be placed"
            );
            assert!(place.offset.is_multiple_of(needs.alignment) && block.alignment.is_multiple_of(needs.alignment));
            assert!(block.alignment.is_multiple_of(granularity));
            assert_eq!(block.type_bits & needs.type_bits, block.type_bits);
            assert_ne!(block.type_bits, 0);
            let used = &mut used[place.block as usize];
            *used = (used.0.min(place.offset), used.1.max(place.offset + needs.size), used.2 + 1);
            let mut sharing = Vec::new();
            for (other, beside) in alias.places.iter().enumerate() {
                let Some(beside) = beside.filter(|beside| other != index && beside.block == place.block) else {
                    continue;
                };
                let page = if image(index) == image(other) { 1 } else { granularity };
                let (a, b) = (pages(&resources[index], place, page), pages(&resources[other], beside, page));
                if a.start < b.end && b.start < a.end {
                    sharing.push(index32(other));
                    let (Life::Transient { first, last }, Life::Transient { first: start, last: end }) =
                        (lives[index], lives[other])
                    else {
                        unreachable!("both are placed");
                    };
                    assert!(last < start || end < first, "{index} and {other} live in the same bytes");
                }
            }
            assert!(!sharing.is_empty(), "{index} is in a block, but shares with nobody");
            assert_eq!(alias.neighbours[index], sharing, "of {index}");
        }
        for (block, (first, end, occupants)) in alias.blocks.iter().zip(used) {
            assert!(occupants > 1 && first < block.alignment && block.size == end, "{block:?} {first} {end}");
        }
    }

    #[test]
    fn every_packing_is_right() {
        let mut state = 11_u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        let (mut packed, mut shared, mut blocks) = (0, 0, 0);
        for _ in 0..4000 {
            let (resources, lives) = mixed(&mut random);
            let granularity = [0, 1, 64, 1024][random(4) as usize];
            let alias = alias(&resources, &lives, granularity, true);
            check(&resources, &lives, granularity.max(1), &alias);
            packed += total(&resources, &alias);
            shared += alias.neighbours.iter().map(Vec::len).sum::<usize>();
            blocks += alias.blocks.len();
        }
        // Requested and allocated bytes, so that the test notices worse packing.
        assert_eq!((packed, shared, blocks), (8_913_536, 109_186, 10_449));
    }

    /// Bytes of blocks and of resources with memory of their own.
    fn total(resources: &[ResourcePlan], alias: &Alias) -> u64 {
        let own = resources.iter().zip(&alias.places).filter(|(_, place)| place.is_none());
        own.map(|(resource, _)| resource.memory.size).sum::<u64>() + alias.blocks.iter().map(|b| b.size).sum::<u64>()
    }

    #[test]
    fn packing_is_close_to_what_lives_at_once() {
        let mut state = 7_u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        let (mut packed, mut least, mut apart) = (0, 0, 0);
        for _ in 0..500 {
            let count = 2 + random(20);
            let resources: Vec<_> = (0..count).map(|i| resource(i, u64::from(1 + random(64)) * 16)).collect();
            let lives: Vec<_> = (0..count)
                .map(|_| (random(24), random(6)))
                .map(|(first, more)| Life::Transient { first, last: first + more })
                .collect();
            let at_once = |action: u32| -> u64 {
                let lives = resources.iter().zip(&lives);
                let then = lives.filter(
                    |(_, life)| matches!(life, Life::Transient { first, last } if (*first..=*last).contains(&action)),
                );
                then.map(|(resource, _)| resource.memory.size).sum()
            };
            packed += total(&resources, &alias(&resources, &lives, 1, true));
            least += (0..30).map(at_once).max().unwrap_or(0);
            apart += total(&resources, &alias(&resources, &lives, 1, false));
        }
        // Nothing can be below `least`; resources apart take over twice as much.
        assert!(packed >= least && apart > 2 * least, "{packed} {least} {apart}");
        assert!(packed * 100 <= least * 108, "{packed} bytes where {least} live at once");
    }
}
