// A hash table from places to addresses, for layouts that keep chunks by their coordinates: engine/layouts/src/table.rs writes it.
// Such a layout declares `table_at` and `log2_slots` in its block `world`.
//
// A slot is four words: a key of three, and a value; RX_NO_ENTRY marks a free slot. A search starts at the slot of the hash and
// ends at its key or at a free slot. At most half of the slots are taken, so it reads about 1.5 slots for a present key, 2.5
// for an absent one (Knuth, "The Art of Computer Programming" 3, 6.4). Coordinates count chunks from world.origin. The table
// also has each cube of 8, 64, 512, ... chunks a side with a chunk in it: the level of a key, the binary logarithm of its
// cube's size in voxels, is in the top five bits of x.
const uint RX_NO_ENTRY = 0xffffffffu;

// The primes are from Teschner et al., "Optimized spatial hashing for collision detection of deformable objects" (2003).
uint rx_table_slot(uvec3 key) {
    uint sum = (key.x * 73856093u) ^ (key.y * 19349663u) ^ (key.z * 83492791u);
    return ((sum ^ (sum >> 15)) * 0x2c1b3c6du) >> (32u - world.log2_slots);
}

// The value of the cube of 2^level voxels a side that holds `c`, in voxels from world.origin.
uint rx_table_find(uvec3 c, uint level) {
    uvec3 key = c >> level;
    key.x |= level << 27;
    uint mask = (1u << world.log2_slots) - 1u;
    uint slot = rx_table_slot(key);
    for (uint i = 0u; i <= mask; ++i) {
        uint at = world.table_at + 4u * slot;
        uint value = world.words[at + 3u];
        if (value == RX_NO_ENTRY || uvec3(world.words[at], world.words[at + 1u], world.words[at + 2u]) == key) return value;
        slot = (slot + 1u) & mask;
    }
    return RX_NO_ENTRY;
}

// Around a place without a chunk of 2^level voxels: binary logarithm of the size of the largest cube that is known to be empty.
uint rx_table_free(uvec3 c, uint level) {
    uint free = level;
    for (uint above = level + 3u; above < world.log2_size; above += 3u) {
        if (rx_table_find(c, above) != RX_NO_ENTRY) break;
        free = above;
    }
    return free;
}
