// Light before the end of each slice, of what air_march.comp has found of the slices.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D sent;
layout(rgba32f) uniform readonly image2D clears;
layout(rgba32f) uniform writeonly image2D outMarched;

void main() {
    ivec2 column = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(column, ivec2(40, 24)))) return;
    vec3 light = vec3(0.0), clear = vec3(1.0);
    for (int i = 0; i < 32; ++i) {
        ivec2 texel = ivec2(40 * i + column.x, column.y);
        light += clear * imageLoad(sent, texel).rgb;
        clear *= imageLoad(clears, texel).rgb;
        imageStore(outMarched, texel, vec4(light, dot(clear, vec3(1.0 / 3.0))));
    }
}
