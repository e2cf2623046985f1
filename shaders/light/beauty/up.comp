// Adds the coarser mip of the bloom to this one, through a tent of nine taps.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D source;
layout(rgba16f) uniform image2D destination;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(destination);
    if (any(greaterThanEqual(pixel, size))) return;
    vec2 place = (vec2(pixel) + 0.5) / vec2(size), texel = 1.0 / vec2(textureSize(source, 0));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 9; ++i) {
        ivec2 step = ivec2(i % 3, i / 3) - 1;
        sum += textureLod(source, place + texel * vec2(step), 0.0).rgb / float((1 + abs(step.x)) * (1 + abs(step.y)) * 4);
    }
    imageStore(destination, pixel, vec4(mix(imageLoad(destination, pixel).rgb, sum, 0.6), 1.0));
}
