// A mip of the bloom from the finer one: 13 taps in five boxes that overlap (Jimenez, "Next generation post processing in Call of Duty",
// 2014), so small bright things do not flicker.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D source;
layout(rgba16f) uniform writeonly image2D destination;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(destination);
    if (any(greaterThanEqual(pixel, size))) return;
    vec2 place = (vec2(pixel) + 0.5) / vec2(size), texel = 1.0 / vec2(textureSize(source, 0));
    vec3 sum = vec3(0.0);
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            if ((x + y & 1) != 0) continue;
            // The central box counts half, each of the four around it an eighth.
            int far = abs(x) + abs(y);
            float share = far == 0 ? 0.125 : abs(x) == 1 && abs(y) == 1 ? 0.125 : far == 2 ? 0.0625 : 0.03125;
            sum += share * min(textureLod(source, place + texel * vec2(x, y), 0.0).rgb, vec3(4000.0));
        }
    }
    imageStore(destination, pixel, vec4(sum, 1.0));
}
