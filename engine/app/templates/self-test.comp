#version 460

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform writeonly image2D outColor;

// Every pixel has a value that `raxel doctor` knows.
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    int index = pixel.y * size.x + pixel.x;
    imageStore(outColor, pixel, vec4(vec3(pixel * 4, index % 7 * 36) / 255.0, 1.0));
}
