// The picture with its glow over it.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform readonly image2D picture;
uniform sampler2D glow;
layout(rgba16f) uniform writeonly image2D outFinal;
layout(push_constant) uniform Push {
    float strength;
};

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outFinal);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 color = imageLoad(picture, pixel).rgb;
    color += strength * textureLod(glow, (vec2(pixel) + 0.5) / vec2(size), 0.0).rgb;
    imageStore(outFinal, pixel, vec4(color, 1.0));
}
