#version 460

layout(local_size_x = 8, local_size_y = 8) in;

// No set and no binding numbers: the graph binds resources by these names.
layout(rgba16f) uniform writeonly image2D outColor;

layout(push_constant) uniform Push {
    float time;  // seconds
    float speed; // the slider of graphs/primary.toml
};

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec2 uv = (vec2(pixel) + 0.5) / vec2(size);
    // Edit a number while `raxel run` shows this, and save.
    vec3 color = 0.5 + 0.5 * cos(time * speed + uv.xyx * 3.0 + vec3(0.0, 2.0, 4.0));
    imageStore(outColor, pixel, vec4(color * color, 1.0));
}
