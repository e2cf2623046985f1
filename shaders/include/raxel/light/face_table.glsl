// A hash table whose keys are the faces of voxels, exactly. The shader that includes this declares
//
//     layout(std430) buffer FaceKeys { uint face_keys[]; };      // RX_FACE_SLOTS elements, `init = 0`; add `readonly` where it only looks
//
// or has `face_keys` beside other tables in one buffer, with the length from face_slots.glsl.
//
// A key has 46 bits: a voxel in a box of 16384 x 4096 x 16384 voxels, a face, and which part of the face. They are mixed by a permutation.
// 20 of the mixed bits choose the slot where the search for a key begins; the slot keeps the other 26 and one more than the distance from
// that slot, 6 bits. So one 32-bit word names its key exactly, and one atomic operation takes the slot: no two keys share a fingerprint, and no
// key is half written (Cleary, "Compact hash tables using bidirectional linear probing", 1984). With RX_FACE_WHOLE, keys are those of whole
// faces alone: 45 bits are enough for them, and the table has half the slots.
#ifndef RAXEL_LIGHT_FACE_TABLE_GLSL
#define RAXEL_LIGHT_FACE_TABLE_GLSL

#include "../ray.glsl"
#include "../random.glsl"
#include "face_slots.glsl"

const uint RX_FACE_PROBES = 63u;        // slots that a key may lie in: of a table that is 60 % full, one key in a million finds none
const uint RX_NO_FACE = 0xffffffffu;    // in place of a slot
const uint RX_FACE_FREED = 1u;          // a freed slot: it can be taken, but the search continues behind it

// A key, mixed: `home` has RX_FACE_HOME_BITS bits, `rest` 26.
struct RxFaceKey {
    uint home;
    uint rest;
};

const uint RX_FACE_REST = (1u << 26) - 1u;

// A voxel's z has 14 bits. Before they are mixed, some are in `home`, behind those of x; the others lie in `rest`, before y, face and part.
const uint RX_FACE_Z_HOME = RX_FACE_HOME_BITS - 14u;
const uint RX_FACE_Z_REST = 14u - RX_FACE_Z_HOME;

// Keys hold the coordinates modulo the sides of the box. So a voxel keeps its key while the box around it moves.
const uvec3 RX_FACE_LEFT = uvec3(16383u, 4095u, 16383u);

// Whether a voxel lies in the box. `origin` is the smallest corner of the box: that of all solid voxels, or one that goes along with the camera.
bool rx_face_fits(ivec3 voxel, ivec3 origin) {
    uvec3 p = uvec3(voxel - origin);
    return ((p.x | p.z) >> 14 | p.y >> 12) == 0u;
}

// The key of RX_FACE_HOME_BITS and 26 bits.
RxFaceKey rx_face_mixed(uint home, uint rest) {
    // Three rounds of a Feistel network, which is a permutation for every hash.
    home ^= rx_hash(rest) >> 32u - RX_FACE_HOME_BITS;
    rest ^= rx_hash(home) >> 6;
    home ^= rx_hash(rest + 0x9e3779b9u) >> 32u - RX_FACE_HOME_BITS;
    return RxFaceKey(home, rest);
}

// The bits that a key was made of.
void rx_face_unmix(inout RxFaceKey key) {
    key.home ^= rx_hash(key.rest + 0x9e3779b9u) >> 32u - RX_FACE_HOME_BITS;
    key.rest ^= rx_hash(key.home) >> 6;
    key.home ^= rx_hash(key.rest) >> 32u - RX_FACE_HOME_BITS;
}

// `part` is 0 for a whole face, 1 to 4 for its quarters (rx_face_quarter), and up to 9 for further keys of a table, such as cells of
// several sizes; always 0 with RX_FACE_WHOLE. The face is not RX_FACE_INSIDE.
RxFaceKey rx_face_key(ivec3 voxel, uint face, uint part) {
    uvec3 p = uvec3(voxel) & RX_FACE_LEFT;
    uint home = p.x | (p.z & (1u << RX_FACE_Z_HOME) - 1u) << 14;
    uint rest = p.z >> RX_FACE_Z_HOME | p.y << RX_FACE_Z_REST | face + 6u * part << RX_FACE_Z_REST + 12u;
    return rx_face_mixed(home, rest);
}

// The parts of a key; of all voxels with this key, the one in the box whose smallest corner is `origin`.
void rx_face_of(RxFaceKey key, ivec3 origin, out ivec3 voxel, out uint face, out uint part) {
    rx_face_unmix(key);
    uvec3 p = uvec3(key.home & 16383u, key.rest >> RX_FACE_Z_REST & 4095u, key.home >> 14 | (key.rest & (1u << RX_FACE_Z_REST) - 1u) << RX_FACE_Z_HOME);
    voxel = origin + ivec3(p - uvec3(origin) & RX_FACE_LEFT);
    uint both = key.rest >> RX_FACE_Z_REST + 12u;
    face = both % 6u;
    part = both / 6u;
}

// The quarter of a face that a place on it lies in, 1 to 4.
uint rx_face_quarter(vec2 uv) {
    return 1u + (uv.x >= 0.5 ? 1u : 0u) + (uv.y >= 0.5 ? 2u : 0u);
}

// Smallest corner and side of a part, on the face.
vec3 rx_face_part(uint part) {
    return part == 0u ? vec3(0.0, 0.0, 1.0) : vec3(0.5 * float(part - 1u & 1u), 0.5 * float(part - 1u >> 1), 0.5);
}

// The word that the slot of a key holds, `probe` slots behind the first slot of the key.
uint rx_face_word(RxFaceKey key, uint probe) {
    return probe + 1u << 26 | key.rest;
}

// The slot that lies `probe` slots behind the first slot of a key.
uint rx_face_slot(RxFaceKey key, uint probe) {
    return key.home + probe & RX_FACE_SLOTS - 1u;
}

// Whether the word of a slot names a key.
bool rx_face_taken(uint word) {
    return word >> 26 != 0u;
}

// The key in a slot; false if there is none.
bool rx_face_in_slot(uint slot, out RxFaceKey key) {
    uint word = face_keys[slot];
    key = RxFaceKey(slot + 1u - (word >> 26) & RX_FACE_SLOTS - 1u, word & RX_FACE_REST);
    return rx_face_taken(word);
}

// The slot of a key, or RX_NO_FACE.
uint rx_face_find(RxFaceKey key) {
    for (uint probe = 0u; probe < RX_FACE_PROBES; ++probe) {
        uint slot = rx_face_slot(key, probe), word = face_keys[slot];
        if (word == rx_face_word(key, probe)) return slot;
        if (word == 0u) break;
    }
    return RX_NO_FACE;
}

#ifdef RX_FACE_INSERT

// The slot of a key, taken for it if it has none; RX_NO_FACE if all that it may lie in are taken. Threads may insert the same key at once
// and get the same slot, as long as no slot is freed in the same dispatch.
uint rx_face_insert(RxFaceKey key) {
    uint found = rx_face_find(key);
    for (uint probe = 0u; found == RX_NO_FACE && probe < RX_FACE_PROBES; ++probe) {
        uint slot = rx_face_slot(key, probe), mine = rx_face_word(key, probe);
        uint word = face_keys[slot];
        // A slot that was free at the look may be taken by now, perhaps for this very key.
        for (uint turn = 0u; turn < 2u && (word == 0u || word == RX_FACE_FREED); ++turn) {
            uint before = atomicCompSwap(face_keys[slot], word, mine);
            if (before == word) before = mine;
            word = before;
        }
        if (word == mine) found = slot;
    }
    return found;
}

#endif
#endif
