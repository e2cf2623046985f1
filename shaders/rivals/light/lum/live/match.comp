// The material of the world that is most like each of the model's, by albedo. Made once.
#version 460
#include <raxel/world.glsl>
#include <raxel/world/model.glsl>

layout(local_size_x = 64) in;
layout(std430) writeonly buffer Palette { uint palette[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= palette.length()) return;
    vec3 albedo = model_material_properties(i).albedo;
    uint best = 0u;
    float least = RX_FAR;
    for (uint m = 1u; m < world.material_count; ++m) {
        vec3 d = rx_material_properties(m).albedo - albedo;
        if (dot(d, d) < least) {
            least = dot(d, d);
            best = m;
        }
    }
    palette[i] = best;
}
