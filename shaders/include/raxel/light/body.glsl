// Inside a clear body: a run of voxels of one material, such as glass or water. Needs <raxel/world.glsl>.
#ifndef RAXEL_LIGHT_BODY_GLSL
#define RAXEL_LIGHT_BODY_GLSL

#include "../ray.glsl"
#ifdef RX_BINDS_instances
#include "../scene.glsl"
#endif

// The end of a way through a body.
struct RxBodyEnd {
    ivec3 inside;   // the last voxel of the body
    ivec3 beyond;   // the first cell that is not of it
    uint face;      // the face of `beyond` that was reached
    vec2 uv;        // place on it
    float t;        // in lengths of the direction
    uint material;  // of `beyond`; 0 is air
};

// A plain walk through a grid of cells, in floats: unlike rx_trace, it may pass an edge on the wrong side.
struct RxGridWalk {
    ivec3 start;
    ivec3 cell;
    ivec3 way;    // the step along each axis
    vec3 frac;    // place in the start cell
    vec3 dir;
    vec3 each;    // lengths of the direction from plane to plane, on each axis
    vec3 next;    // lengths to the next plane, on each axis
    float t;      // lengths to the last plane
    uint axis;    // of that plane
};

// A walk from cell to cell that begins in a cell, at `frac` in it.
RxGridWalk rx_grid_walk(ivec3 cell, vec3 frac, vec3 dir) {
    vec3 each = 1.0 / max(abs(dir), vec3(1e-9));
    bvec3 up = greaterThan(dir, vec3(0.0));
    return RxGridWalk(cell, cell, ivec3(mix(vec3(-1.0), vec3(1.0), up)), frac, dir, each, mix(frac, 1.0 - frac, up) * each, 0.0, 0u);
}

// On to the next cell; returns the one before it.
ivec3 rx_grid_step(inout RxGridWalk walk) {
    ivec3 before = walk.cell;
    walk.axis = walk.next.x <= walk.next.y && walk.next.x <= walk.next.z ? 0u : walk.next.y <= walk.next.z ? 1u : 2u;
    walk.t = walk.next[walk.axis];
    walk.next[walk.axis] += walk.each[walk.axis];
    walk.cell[walk.axis] += walk.way[walk.axis];
    return before;
}

// The end of a way whose last step left the body. `inside` is the cell before that step, `material` that of the cell behind it.
RxBodyEnd rx_grid_end(RxGridWalk walk, ivec3 inside, uint material) {
    vec3 place = clamp(walk.frac + walk.t * walk.dir - vec3(walk.cell - walk.start), 0.0, 1.0);
    vec2 uv = walk.axis == 0u ? place.yz : walk.axis == 1u ? place.xz : place.xy;
    return RxBodyEnd(inside, walk.cell, 2u * walk.axis + (walk.way[walk.axis] < 0 ? 1u : 0u), uv, walk.t, material);
}

// Walks from cell to cell, from a point in a voxel of the material `body`, until the material changes; false if it does not change within `most`
// cells.
bool rx_walk_body(ivec3 cell, vec3 frac, vec3 dir, uint body, uint most, out RxBodyEnd end) {
    RxGridWalk walk = rx_grid_walk(cell, frac, dir);
    end = RxBodyEnd(cell, cell, RX_FACE_INSIDE, vec2(0.5), 0.0, body);
    for (uint i = 0u; i < most; ++i) {
        ivec3 inside = rx_grid_step(walk);
        end.inside = inside;
        end.t = walk.t;
        end.material = rx_material(walk.cell);
        if (end.material == body) continue;
        end = rx_grid_end(walk, inside, end.material);
        return true;
    }
    return false;
}

#ifdef RX_BINDS_instances
// The first place on an instance along a ray that stays in a body as far as `most`, in lengths of the direction.
bool rx_instance_in_body(RxSceneRay ray, float most, out RxHit hit) {
    RX_RAY(ray).t_max = most;
    RxSceneHit nearest = RxSceneHit(RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u), RX_NO_INSTANCE, false, ivec3(0), 0u);
    bool found = rx_trace_instances_on(ray, false, false, RxTime(uvec2(0u), 1u), nearest);
    hit = rx_place_of(nearest);
    return found;
}

// A direction of the world in the axes of a model.
vec3 rx_model_direction(RxInstance instance, vec3 dir) {
    vec3 turned = rx_instance_is_free(instance) ? rx_direction_in_instance(instance, dir) : dir, own = vec3(0.0);
    for (uint axis = 0u; axis < 3u; ++axis) {
        float c = turned[rx_instance_axis(instance, axis)];
        own[axis] = rx_instance_turns_around(instance, axis) ? -c : c;
    }
    return own;
}

// As rx_walk_body, through a body of an instance, from a place on the surface of a voxel of the material `body` into that voxel. `dir` is a
// direction of the world. The cells and the face of `end` are those of places. All cells beside the model are air.
bool rx_walk_instance_body(ivec3 voxel, uint face, vec2 uv, vec3 dir, uint body, uint most, out RxBodyEnd end) {
    RxInstance instance = rx_instance_of(rx_place_instance(voxel));
    uint size = 1u << (instance.shape & 31u);
    ivec3 number = ivec3(voxel.x - rx_place_cell(voxel).x, 0, 0);
    RxGridWalk walk = rx_grid_walk(rx_place_cell(voxel), rx_face_place(RX_FACE_PART(face), uv), rx_model_direction(instance, dir));
    end = RxBodyEnd(voxel, voxel, RX_FACE_INSIDE, vec2(0.5), 0.0, body);
    for (uint i = 0u; i < most; ++i) {
        ivec3 inside = rx_grid_step(walk);
        uint material = 0u, log2_free;
        if (all(lessThan(uvec3(walk.cell), uvec3(size)))) material = rx_instance_look(instance, uvec3(walk.cell), log2_free);
        if (material == body) continue;
        end = rx_grid_end(walk, inside, material);
        end.face |= RX_ON_INSTANCE;
        end.inside += number;
        end.beyond += number;
        return true;
    }
    return false;
}
#else
#define rx_instance_in_body(ray, most, hit) false
#define rx_walk_instance_body(voxel, face, uv, dir, body, most, end) false
#endif

// Loss of light in a body per voxel: a coloured body takes away the other colours, and the clearer it is, the less.
vec3 rx_body_loss(RxMaterial material) {
    return -log(clamp(material.albedo, 0.02, 0.99)) * mix(0.4, 0.04, material.transparency);
}

// Continues a ray straight through clear bodies, such as panes of glass. It passes at most four bodies of at most `most` cells each, and
// must end in air. Then `ray` begins behind them and ends where it ended, and `share` is less their loss. Their surfaces mirror nothing
// here.
bool rx_pass_body(RxHit hit, uint most, inout RxRay ray, inout vec3 share) {
    if (hit.face == RX_FACE_INSIDE) return false;
    // From the same place, but into the voxel.
    RxRay at = rx_ray_from_face(hit.voxel, hit.face, hit.uv, ray.dir);
    uint axis = rx_face_axis(hit.face), body = hit.material;
    at.cell = hit.voxel;
    at.frac[axis] = 1.0 - at.frac[axis];
    at.t_max = ray.t_max - hit.t;
    vec3 left = vec3(1.0);
    for (int i = 0; i < 4; ++i) {
        RxMaterial material = rx_material_properties(body);
        RxBodyEnd end;
        if (material.transparency <= 0.0 || !rx_walk_body(at.cell, at.frac, ray.dir, body, most, end)) return false;
        left *= exp(-rx_body_loss(material) * (end.t * length(ray.dir)));
        float rest = at.t_max - end.t;
        // A ray that leaves the last voxel of the body begins in the cell behind it.
        at = rx_ray_from_face(end.inside, end.face ^ 1u, end.uv, ray.dir);
        at.t_max = rest;
        body = end.material;
        if (body == 0u) {
            ray = at;
            share *= left;
            return true;
        }
    }
    return false;
}

#ifdef RX_BINDS_instances
// As rx_pass_body, from a place on an instance through its model. Nothing else that stands in the model is in the way, unless it is where the model ends.
bool rx_pass_instance_body(RxHit hit, uint most, inout RxSceneRay ray, inout vec3 share) {
    vec3 dir = RX_RAY(ray).dir, left = vec3(1.0);
    float t_max = RX_RAY(ray).t_max - hit.t;
    for (int i = 0; i < 4; ++i) {
        RxMaterial material = rx_material_properties(hit.material);
        RxBodyEnd end;
        if (material.transparency <= 0.0 || !rx_walk_instance_body(hit.voxel, hit.face, hit.uv, dir, hit.material, most, end)) return false;
        left *= exp(-rx_body_loss(material) * (end.t * length(dir)));
        t_max -= end.t;
        if (end.material == 0u) {
            RxSceneRay behind = rx_ray_from_place(end.inside, end.face ^ 1u, end.uv, dir);
            if (rx_material(RX_RAY(behind).cell) != 0u) return false;
            ray = behind;
            RX_RAY(ray).t_max = t_max;
            share *= left;
            return true;
        }
        hit = RxHit(end.beyond, end.face, end.material, 0.0, end.uv, 0u);
    }
    return false;
}

// The same along a ray through the world and its instances (<raxel/scene.glsl>), whichever of them the hit is on. False, too, where an instance stands in
// a body of the world.
bool rx_pass_panes(RxHit hit, uint most, inout RxSceneRay ray, inout vec3 share) {
    if (hit.face == RX_FACE_INSIDE) return false;
    if (rx_is_on_instance(hit.face)) return rx_pass_instance_body(hit, most, ray, share);
    RxRay on = RX_RAY(ray);
    vec3 left = share;
    if (!rx_pass_body(hit, most, on, left)) return false;
    RxRay from = rx_ray_from_face(hit.voxel, hit.face, hit.uv, on.dir);
    float far = dot(vec3(on.cell - from.cell) + (on.frac - from.frac), on.dir) / dot(on.dir, on.dir);
    RxHit standing;
    // One that touches the other side from behind stands behind it.
    if (rx_instance_in_body(rx_scene_ray(from), max(far - 1e-3 / length(on.dir), 0.0), standing)) return false;
    ray = rx_scene_ray(on);
    share = left;
    return true;
}
#else
#define rx_pass_panes(hit, most, ray, share) rx_pass_body(hit, most, ray, share)
#endif

#endif
