// Models that stand in the world without being part of its voxels, see [[instances]] in docs/world-file.md. Bind `instances` to a
// buffer with `source = "world.instances"`, and `world` as ever:
//
//     bool rx_trace_scene(RxSceneRay ray, out RxSceneHit hit);   the first solid voxel of the world or of an instance along a ray
//     RxSceneRay rx_scene_ray(RxRay ray);                        a ray that begins anywhere
//     RxSceneRay rx_scene_ray_from_hit(RxSceneHit hit, vec3 dir);   one that goes on from a hit
//
// The buffer holds a tree of boxes, depth first: two quads a node, smallest voxel, link, last voxel, kind. A kind below 3 is the split axis: the
// first child follows the node, and the link is the second child. Kind 3 is a leaf: the link is its instance. Then come eight
// quads for each instance, the models in the layout `tree64`, and the faces of models that give off light.
//
// The ray walks an instance on the lattice of the world, turned by quarter turns, in the world's frame: its hits are those of voxels of the
// world. Integers bring the ray into the frame of any other instance. It is rounded down to multiples of 2^-24 there, and exact from then
// on (instance_frame.glsl). The comparison of hits is exact, too. docs/exactness.md has the details.
#ifndef RAXEL_INSTANCES_GLSL
#define RAXEL_INSTANCES_GLSL

#include "world.glsl"
#include "box.glsl"
#include "instance_voxels.glsl"

const uint RX_INSTANCE_DEPTH = 36u;  // more than any tree of boxes has
const uint RX_INSTANCE_LEAF = 3u;

// A hit of the world or of one of its instances.
struct RxSceneHit {
    RxHit at;        // `voxel`, `face` and `uv` are those of the world, or of the model's own frame if `free`
    uint instance;   // in the order of the world's file; RX_NO_INSTANCE is the world itself
    bool free;       // the instance is not on the lattice of the world
    ivec3 cell;      // the voxel in its model, in the coordinates of its file; that of the world, if it was the world
    uint cell_face;  // the face of that voxel
};

// A face of a voxel in the frame that an instance is walked in, as a face of its model.
uint rx_instance_face(RxInstance instance, uint face) {
    for (uint axis = 0u; axis < 3u; ++axis) {
        if (rx_instance_axis(instance, axis) == rx_face_axis(face)) {
            return 2u * axis + ((face & 1u) ^ (rx_instance_turns_around(instance, axis) ? 1u : 0u));
        }
    }
    return face;
}

// Follows a ray through the cube of an instance. Until `t_free`, in lengths of its direction, the ray meets no solid voxel.
bool rx_trace_in_instance(RxInstance instance, RxRay ray, float t_free, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    uint log2_size = instance.shape & 31u;
    RxWalk walk;
    if (!rx_walk_begin(ray, instance.corner, log2_size, t_free, walk)) return false;
    uvec3 flip = rx_walk_flip(walk, (1u << log2_size) - 1u);
    uvec3 limit = rx_walk_limit(walk, log2_size, instance.low, instance.high);
    uint log2_free = 0u, material = 0u;
    bool unsure = false;
    // Every round leaves a block for good, and there are fewer than 3 * size blocks on a line.
    uint rounds = 4u << log2_size;
    do {
        for (unsure = false; !unsure && hit.steps < rounds; ++hit.steps) {
            if (any(greaterThan(walk.q, limit)) || walk.t > walk.t_end) break;
            material = rx_instance_look(instance, rx_instance_cell(instance, walk.q ^ flip), log2_free);
            if (material != 0u) break;
            unsure = !rx_walk_step(walk, log2_free);
        }
        if (unsure) rx_walk_settle(walk, ray, instance.corner, log2_size, log2_free);
    } while (unsure);
    if (material == 0u) return false;
    uint steps = hit.steps + 1u;
    bool within = rx_walk_hit(walk, ray, instance.corner, log2_size, hit);
    hit.material = material;
    hit.steps = steps;
    return within;
}

// A ray in the frame of a free instance; its time counts in units of the direction on the lattice, see rx_lattice_direction. False if it
// begins more than 2^29 voxels away along an axis.
bool rx_ray_in_instance(RxInstance instance, RxRay ray, vec3 direction, out RxRay turned) {
    ivec3 cells = ray.cell - instance.cell;
    // Whether the difference went over the end, too.
    bvec3 over = notEqual(lessThan(cells, ivec3(0)), lessThan(ray.cell, instance.cell));
    turned = RxRay(ivec3(0), vec3(0.0), vec3(0.0), RX_FAR);
    if (any(over) || rx_beyond(cells, 0x20000000)) return false;
    ivec3 rest = ivec3(clamp(ray.frac, 0.0, 1.0) * 16777216.0) - ivec3(instance.fraction);
    uvec3 place;
    rx_turned(instance.row_x, cells, rest, turned.cell.x, place.x);
    rx_turned(instance.row_y, cells, rest, turned.cell.y, place.y);
    rx_turned(instance.row_z, cells, rest, turned.cell.z, place.z);
    turned.frac = vec3(place) * 5.9604644775390625e-8;
    turned.dir = direction;
    return true;
}

// The time of a hit, exactly: numerator / size, in multiples of a constant that is the same for all frames.
struct RxTime {
    uvec2 numerator;
    uint size;
};

// `ray` is the one that found the hit, in its own frame, and `exponent` that of the largest component of the direction in the world.
RxTime rx_time_of(RxRay ray, RxHit hit, uint exponent) {
    uint axis = rx_face_axis(hit.face);
    if (axis > 2u) return RxTime(uvec2(0u), 1u);
    uint top = rx_lattice_top(ray.dir);
    uint bits = rx_pick(floatBitsToUint(ray.dir), axis);
    bool down = (bits >> 31) != 0u;
    uint frac = rx_pick(uvec3(clamp(ray.frac, 0.0, 1.0) * 16777216.0), axis);
    uint planes = rx_pick(down ? uvec3(ray.cell) - uvec3(hit.voxel) : uvec3(hit.voxel) - uvec3(ray.cell), axis);
    uvec2 numerator = rx_difference(uvec2(planes << 24, planes >> 8), uvec2(down ? 16777216u - frac : frac, 0u));
    // A turn changes the largest component by at most a factor of the square root of 3.
    uint shift = exponent + 1u - top;
    numerator = uvec2(numerator.x << shift, (numerator.y << shift) | (shift == 0u ? 0u : numerator.x >> (32u - shift)));
    return RxTime(numerator, rx_lattice_component(bits, top));
}

// numerator * by, 96 bits with the lowest word first.
uvec3 rx_time_product(uvec2 numerator, uint by) {
    uvec2 low = rx_product(numerator.x, by), high = rx_product(numerator.y, by);
    uint middle = low.y + high.x;
    return uvec3(low.x, middle, high.y + (middle < low.y ? 1u : 0u));
}

// A time in units of d, rounded up. Lengths of the direction will not do: along a long one, a near hit has less than the smallest normal float, and
// a device may take that for 0.
float rx_time_end(RxTime time) {
    float multiples = float(time.numerator.y) * 4294967296.0 + float(time.numerator.x);
    return multiples / float(time.size) * 32.0 * 1.0001 + 1.0e-3;
}

// Whether one time comes before another, exactly.
bool rx_time_before(RxTime a, RxTime b) {
    uvec3 p = rx_time_product(a.numerator, b.size), q = rx_time_product(b.numerator, a.size);
    return p.z != q.z ? p.z < q.z : p.y != q.y ? p.y < q.y : p.x < q.x;
}

// The instances along a ray. `hit` and `first` are the nearest hit so far and its time. With `any`, the search ends at the first instance that is met.
bool rx_trace_instances_on(RxSceneRay scene_ray, bool any, bool found, RxTime first, inout RxSceneHit hit) {
    RxRay ray = scene_ray.ray;
    vec3 dir = rx_lattice_direction(ray);
    if (instances.count == 0u || dir == vec3(0.0)) return found;
    RxBoxes boxes = rx_boxes(ray, dir, ivec3(instances.quads[0].xyz), ivec3(instances.quads[1].xyz));
    uint exponent = 127u;  // that of the largest component of dir
    float t_end = ray.t_max >= 1.0e37 ? RX_FAR : ray.t_max * rx_walk_scale(ray.dir) * 1.0001 + 1.0e-3;
    if (found) t_end = min(t_end, rx_time_end(first));

    const uint NONE = 0xffffffffu;
    uint stack[RX_INSTANCE_DEPTH];
    uint depth = 0u, node = 0u, visits = 0u;
    while (node != NONE) {
        // On to the next leaf. Threads of a group search together, and then follow their rays through instances together.
        uint leaf = NONE;
        float t_free = 0.0;
        while (leaf == NONE && node != NONE) {
            uvec4 low = instances.quads[2u * node], last = instances.quads[2u * node + 1u];
            float from = rx_boxes_time(boxes, ray, ivec3(low.xyz), ivec3(last.xyz));
            // A ray without an end would reach even RX_NEVER.
            bool meets = from < RX_NEVER && from <= t_end;
            if (meets && last.w != RX_INSTANCE_LEAF) {
                bool down = dir[last.w] < 0.0;
                stack[depth++] = down ? node + 1u : low.w;
                node = down ? low.w : node + 1u;
            } else {
                if (meets) {
                    leaf = low.w;
                    t_free = from;
                }
                node = depth == 0u ? NONE : stack[--depth];
            }
            // A tree has fewer nodes than this.
            if (++visits == 2u * instances.count) node = NONE;
        }
        if (leaf == NONE) break;

        RxInstance instance = rx_instance_of(leaf);
        bool free = rx_instance_is_free(instance), there = true;
        // In units of d.
        RxRay turned = RxRay(ray.cell, ray.frac, dir, t_end);
        if (free) {
            vec3 direction = rx_direction_in_instance(instance, dir);
            if (leaf == scene_ray.own) {
                turned = scene_ray.start;
                turned.dir = direction;
            } else {
                there = rx_ray_in_instance(instance, ray, direction, turned);
            }
            // The box in the frame of the model is smaller than that around it in the world.
            RxBoxes own = RxBoxes(mix(1.0 / direction, vec3(RX_NEVER), equal(direction, vec3(0.0))), 2.0 * boxes.room);
            t_free = rx_boxes_time(own, turned, instance.corner + instance.low, instance.corner + instance.high);
            there = there && t_free < RX_NEVER && t_free <= t_end;
            turned.t_max = t_end;
        }
        RxHit at;
        if (!there || !rx_trace_in_instance(instance, turned, t_free, at)) continue;
        RxTime time = rx_time_of(turned, at, exponent);
        float t = rx_walk_lengths(ray.dir, at.t);
        at.t = t;
        bool nearer = !found || rx_time_before(time, first)
            || (!rx_time_before(first, time) && hit.instance != RX_NO_INSTANCE && leaf < hit.instance);
        if (nearer && (ray.t_max >= RX_FAR || t <= ray.t_max)) {
            hit.at = at;
            hit.instance = leaf;
            first = time;
            found = true;
            if (any) return true;
            t_end = min(t_end, rx_time_end(time));
        }
    }
    if (hit.instance == RX_NO_INSTANCE) return found;
    RxInstance instance = rx_instance_of(hit.instance);
    hit.free = rx_instance_is_free(instance);
    hit.cell = instance.model_corner + ivec3(rx_instance_cell(instance, uvec3(hit.at.voxel - instance.corner)));
    hit.cell_face = rx_instance_face(instance, hit.at.face);
    return found;
}

// The first solid voxel along a ray, of the world or of an instance. If several are hit at the same time, the world wins, then the first instance.
bool rx_trace_scene(RxSceneRay ray, out RxSceneHit hit) {
    hit = RxSceneHit(RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u), RX_NO_INSTANCE, false, ivec3(0), 0u);
    bool found = rx_trace(ray.ray, hit.at);
    hit.cell = hit.at.voxel;
    hit.cell_face = hit.at.face;
    RxTime first = RxTime(uvec2(0u), 1u);
    if (found) first = rx_time_of(ray.ray, hit.at, rx_lattice_top(ray.ray.dir));
    return rx_trace_instances_on(ray, false, found, first, hit);
}

// The outward normal of a face that was hit, in the world; zero for a start inside.
vec3 rx_scene_normal(RxSceneHit hit) {
    vec3 normal = rx_normal(hit.at.face);
    return hit.free ? rx_direction_from_instance(rx_instance_of(hit.instance), normal) : normal;
}

// The ray that goes on from a hit in a direction of the world. In the world it starts exactly on the face. For a voxel off the lattice, it
// starts at most 2^-22 of the model's size beside the face.
RxSceneRay rx_scene_ray_from_hit(RxSceneHit hit, vec3 dir) {
    RxRay start = rx_ray_from_hit(hit.at, dir);
    if (!hit.free) return rx_scene_ray(start);
    return rx_scene_ray_from_instance(rx_instance_of(hit.instance), hit.instance, start, dir);
}

#endif
