#version 460
#include <world.glsl>
layout(local_size_x_id = 1, local_size_y = 8) in;
layout(constant_id = 0) const int BOUNCES = 1;
layout(constant_id = 1) const uint WIDTH = 8;

layout(push_constant) uniform Push {
    ivec3 camera_cell;
    vec3 camera_frac;
    mat4 view;
    float exposure;
    int debug_mode;
    ivec2 extent;
} push;

struct Light {
    vec3 color;
    bool on;
};
struct Sun {
    vec3 direction;
    float strength;
};
layout(std140) uniform Sky {
    vec4 colors[2];
    Light lights[2];
    Sun sun;
} sky;

layout(rg32ui) uniform writeonly uimage2D outHit;
layout(r32f) uniform writeonly image2D outDepth;
layout(rgba16f) uniform writeonly image2D outColor;
uniform sampler2D last;
layout(std430) writeonly buffer Rays {
    vec4 rays[];
};

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    vec3 color = sky.colors[1].rgb * sky.lights[1].color * float(sky.lights[0].on) * sky.sun.direction * push.exposure;
    imageStore(outHit, pixel, uvec4(world.words[0], BOUNCES + MAX_STEPS, 0, 0));
    imageStore(outDepth, pixel, vec4(push.camera_frac.x + float(push.camera_cell.x + push.debug_mode)));
    imageStore(outColor, pixel, texelFetch(last, pixel, 0) + vec4(color, 1.0));
    rays[pixel.x] = push.view * vec4(push.extent, 0, NAME.x);
}
