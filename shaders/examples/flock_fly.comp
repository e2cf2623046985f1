// One tick of a flock: each bird steers by its neighbours, towards a place that wanders over the bay, and away from obstacles. C. Reynolds,
// "Flocks, herds, and schools: a distributed behavioral model", SIGGRAPH 1987.
#version 460
#include <raxel/world.glsl>
#include <raxel/random.glsl>

layout(local_size_x = 64) in;

struct Bird {
    vec4 place;     // voxels
    vec4 velocity;  // voxels a second
};
layout(std430) readonly buffer Before { Bird before[]; };
layout(std430) writeonly buffer After { Bird after[]; };

layout(push_constant) uniform Push {
    uint tick;
    float delta;     // seconds
    float speed;     // voxels a second
    float together;
    float apart;     // voxels
} push;

const float SIGHT = 34.0;  // voxels

// The goal of the flock: a loop over the bay. Some birds fly it a little later than others.
vec3 goal(float seconds) {
    return vec3(95.0 * sin(0.31 * seconds), 74.0 + 16.0 * sin(0.53 * seconds), 80.0 * sin(0.47 * seconds + 0.7));
}

// They begin in a cloud.
Bird hatched(uint i) {
    uint state = rx_hash(i);
    vec3 away = rx_random_direction(state);
    float far = 45.0 * sqrt(rx_random(state));
    return Bird(vec4(vec3(0.0, 82.0, 0.0) + far * away * vec3(1.0, 0.4, 1.0), 0.0), vec4(push.speed * vec3(1.0, 0.0, 0.2), 0.0));
}

vec3 steered(Bird own, uint i) {
    vec3 middle = vec3(0.0), heading = vec3(0.0), off = vec3(0.0);
    float seen = 0.0;
    for (uint k = 0u; k < uint(before.length()); ++k) {
        vec3 to = before[k].place.xyz - own.place.xyz;
        float d = length(to);
        if (k == i || d > SIGHT) continue;
        seen += 1.0;
        middle += to;
        heading += before[k].velocity.xyz;
        if (d < push.apart) off -= to / max(d * d, 0.25);
    }
    uint state = rx_hash(i + 512u);
    vec3 wish = 0.3 * (goal(float(push.tick) * push.delta - 3.0 * rx_random(state)) - own.place.xyz);
    if (seen > 0.0) wish += push.together * (0.4 * middle / seen + 1.2 * (heading / seen - own.velocity.xyz)) + 90.0 * off;
    // Up and away from the land ahead, the nearer the more.
    vec3 floor_of = floor(own.place.xyz);
    RxRay ahead = rx_ray(ivec3(floor_of), own.place.xyz - floor_of, own.velocity.xyz + vec3(0.0, -0.35 * push.speed, 0.0));
    RxHit hit;
    ahead.t_max = 1.6;  // seconds of flight
    if (rx_trace(ahead, hit)) wish += 60.0 * (1.8 - hit.t) * (rx_normal(hit.face) + vec3(0.0, 1.0, 0.0));
    return wish;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(after.length())) return;
    Bird own = before[i];
    if (own.velocity == vec4(0.0)) own = hatched(i);
    vec3 push_by = steered(own, i);
    // They turn no faster than they can.
    push_by *= min(1.0, 2.2 * push.speed / max(length(push_by), 1.0e-3));
    vec3 velocity = own.velocity.xyz + push.delta * push_by;
    velocity *= clamp(push.speed / max(length(velocity), 1.0e-3), 0.96, 1.04);
    velocity.y = clamp(velocity.y, -0.5 * push.speed, 0.5 * push.speed);
    vec3 place = own.place.xyz + push.delta * velocity;
    // The lean into the turn: the push to its right.
    vec3 right = normalize(cross(velocity, vec3(0.0, 1.0, 0.0)) + vec3(1.0e-6));
    float lean = mix(own.velocity.w, clamp(dot(push_by, right) / push.speed, -1.0, 1.0), 0.08);
    after[i] = Bird(vec4(place, 0.0), vec4(velocity, lean == 0.0 ? 1.0e-6 : lean));
}
