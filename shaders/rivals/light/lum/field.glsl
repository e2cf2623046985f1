// Lum's radiance field and map of the sun (platonvin/lum, 2025).

layout(std140) uniform Grid {
    ivec3 world_min;
    ivec3 world_max;
} grid;

// Half the side and half the depth of the sun's map. The map is a square across the sunlight around the centre of the world, and holds all of the world.
float map_half() {
    return 0.5 * length(vec3(grid.world_max - grid.world_min)) + 1.0;
}

vec3 map_middle() {
    return 0.5 * vec3(grid.world_max - grid.world_min);
}

// A place relative to the smallest corner of the world.
vec3 place_in_world(ivec3 voxel, uint face, vec2 uv) {
    RxRay start = rx_ray_from_face(voxel, face, uv, vec3(0.0));
    return vec3(start.cell - grid.world_min) + start.frac;
}

// Place on the sun's map in texels, and depth there.
vec3 on_map(vec3 place, vec3 sun, ivec2 size) {
    vec3 t, b, d = place - map_middle();
    rx_basis(sun, t, b);
    float half_side = map_half();
    return vec3((vec2(dot(d, t), dot(d, b)) / half_side * 0.5 + 0.5) * vec2(size), 0.5 - 0.5 * dot(d, sun) / half_side);
}

// Radiance around a place of a face: a blend of the eight probes around a point in front of it. Probes behind the face count a tenth. The
// blend does not test whether a probe sees the place.
vec3 field(sampler3D probes, vec3 place, vec3 normal, float away) {
    vec3 at = (place + away * normal) / 16.0 - 0.5, sum = vec3(0.0);
    ivec3 base = ivec3(floor(at)), last = textureSize(probes, 0) - 1;
    vec3 part = at - vec3(base);
    float weight = 0.0;
    for (int i = 0; i < 8; ++i) {
        ivec3 step = ivec3(i & 1, i >> 1 & 1, i >> 2), probe = clamp(base + step, ivec3(0), last);
        vec3 along = mix(1.0 - part, part, vec3(step));
        vec3 way = 16.0 * (vec3(probe) + 0.5) - place;
        float w = along.x * along.y * along.z * max(dot(normalize(way + 1e-4), normal), 0.1);
        sum += w * texelFetch(probes, probe, 0).rgb;
        weight += w;
    }
    return SCALE * sum / max(weight, 1e-6);
}

// Radiance at a place in the air: a blend of the eight probes around it.
vec3 field_in_air(sampler3D probes, vec3 place) {
    vec3 at = place / 16.0 - 0.5, sum = vec3(0.0);
    ivec3 base = ivec3(floor(at)), last = textureSize(probes, 0) - 1;
    vec3 part = at - vec3(base);
    for (int i = 0; i < 8; ++i) {
        ivec3 step = ivec3(i & 1, i >> 1 & 1, i >> 2);
        vec3 along = mix(1.0 - part, part, vec3(step));
        sum += along.x * along.y * along.z * texelFetch(probes, clamp(base + step, ivec3(0), last), 0).rgb;
    }
    return SCALE * sum;
}
