#version 460
// Colours of the triangles of an overlay. Texture and corners are sRGB-encoded, and are multiplied and blended as they are: interfaces
// are drawn so on the web and by egui.

// The target encodes what it is given: then the colour is decoded first.
layout(constant_id = 0) const bool targetEncodes = false;

layout(set = 0, binding = 0) uniform sampler2D image;

layout(location = 0) in vec2 fragmentUv;
layout(location = 1) in vec4 fragmentColor;
layout(location = 0) out vec4 color;

// IEC 61966-2-1.
vec3 decoded(vec3 srgb) {
    return mix(pow((srgb + 0.055) / 1.055, vec3(2.4)), srgb / 12.92, lessThanEqual(srgb, vec3(0.04045)));
}

void main() {
    color = fragmentColor * texture(image, fragmentUv);
    if (targetEncodes) {
        color.rgb = decoded(color.rgb);
    }
}
