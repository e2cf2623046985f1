#version 460
#include <raxel/random.glsl>
#include <raxel/light/bsdf.glsl>
layout(local_size_x = 1) in;
layout(std430) buffer Results { float results[]; };

vec3 upwards(inout uint seed) {
    vec3 d = rx_random_direction(seed);
    return vec3(d.xy, max(abs(d.z), 0.01));
}

void main() {
    uint seed = 7u;
    vec2 lopsided = vec2(0.0);
    for (int i = 0; i < 2000; ++i) {
        vec3 l = normalize(upwards(seed)), v = normalize(upwards(seed));
        float alpha = rx_ggx_alpha(rx_random(seed)), roughness = rx_random(seed);
        float a = rx_ggx(vec3(0.04), alpha, l, v, 1.0).x, b = rx_ggx(vec3(0.04), alpha, v, l, 1.0).x;
        lopsided.x = max(lopsided.x, abs(a - b) / max(a, b));
        a = rx_rough_diffuse(vec3(0.8), roughness, l, v).x;
        b = rx_rough_diffuse(vec3(0.8), roughness, v, l).x;
        lopsided.y = max(lopsided.y, abs(a - b) / max(a, b));
    }
    results[0] = lopsided.x;
    results[1] = lopsided.y;

    const int SIDE = 64;  // lavapipe ends an invocation after 65,535 rounds of loops
    float metal = 0.0, matt = 0.0, ways = 0.0;
    for (int k = 0; k < 6; ++k) {
        float z = k < 3 ? 0.9 : 0.35, roughness = float(k % 3 + 1) / 3.0, alpha = rx_ggx_alpha(roughness);
        vec3 v = vec3(sqrt(1.0 - z * z), 0.0, z);
        float kept = 0.0, evenly = 0.0, all = 0.0, all_matt = 0.0;
        for (int i = 0; i < SIDE * SIDE; ++i) {
            vec2 u = (vec2(i % SIDE, i / SIDE) + 0.5) / float(SIDE);
            vec3 h = rx_ggx_visible_normal(v, alpha, u), l = reflect(-v, h);
            kept += rx_ggx_kept(l, v, alpha);
        }
        kept /= float(SIDE * SIDE);
        for (int i = 0; i < SIDE * SIDE; ++i) {
            vec2 u = (vec2(i % SIDE, i / SIDE) + 0.5) / float(SIDE);
            // Even over the projected disc: the density is cos / pi.
            float r = sqrt(u.x), angle = 2.0 * RX_PI * u.y;
            vec3 l = vec3(r * cos(angle), r * sin(angle), sqrt(1.0 - u.x));
            vec3 h = normalize(l + v);
            evenly += RX_PI * rx_ggx_distribution(h.z, alpha) * rx_ggx_visibility(l.z, v.z, alpha);
            all += RX_PI * rx_ggx(vec3(1.0), alpha, l, v, kept).x;
            all_matt += RX_PI * rx_rough_diffuse(vec3(1.0), roughness, l, v).x;
        }
        evenly /= float(SIDE * SIDE);
        // A third of the roughness gives a lobe too narrow to be integrated evenly.
        if (k % 3 > 0) {
            ways = max(ways, abs(evenly - kept));
            metal = max(metal, abs(all / float(SIDE * SIDE) - 1.0));
        }
        matt = max(matt, abs(all_matt / float(SIDE * SIDE) - 1.0));
    }
    results[2] = metal;
    results[3] = matt;
    results[4] = ways;
}
