// The scattering of light by surfaces. All functions work in the frame whose z axis is the surface's normal; l and v are unit vectors away from
// it, with z > 0. Values are without the cosine unless they say otherwise.
#ifndef RAXEL_LIGHT_BSDF_GLSL
#define RAXEL_LIGHT_BSDF_GLSL

#include "sampling.glsl"

// Square of the roughness; never zero, so that a mirror has a finite density.
float rx_ggx_alpha(float roughness) {
    return max(roughness * roughness, 1e-3);
}

// Share of microfacets' area whose normal is h, per steradian.
float rx_ggx_distribution(float h_z, float alpha) {
    float a2 = alpha * alpha, d = h_z * h_z * (a2 - 1.0) + 1.0;
    return a2 / (RX_PI * d * d);
}

// Masking and shadowing at correlated heights, divided by 4 l_z v_z (Heitz 2014).
float rx_ggx_visibility(float l_z, float v_z, float alpha) {
    float a2 = alpha * alpha;
    return 0.5 / (l_z * sqrt(v_z * v_z * (1.0 - a2) + a2) + v_z * sqrt(l_z * l_z * (1.0 - a2) + a2));
}

// A normal of the GGX distribution as it is seen along v (Dupuy and Benyoub, "Sampling visible GGX normals with spherical caps", 2023).
vec3 rx_ggx_visible_normal(vec3 v, float alpha, vec2 u) {
    vec3 stretched = normalize(vec3(alpha * v.xy, v.z));
    float angle = 2.0 * RX_PI * u.x, z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    vec3 h = stretched + vec3(sqrt(clamp(1.0 - z * z, 0.0, 1.0)) * vec2(cos(angle), sin(angle)), z);
    return normalize(vec3(alpha * h.xy, max(h.z, 1e-6)));
}

// Density, per steradian, of reflecting v about rx_ggx_visible_normal.
float rx_ggx_density(vec3 v, vec3 h, float alpha) {
    float a2 = alpha * alpha;
    return rx_ggx_distribution(h.z, alpha) / (2.0 * (v.z + sqrt(v.z * v.z * (1.0 - a2) + a2)));
}

// Light that reflects off a metal or a coat, between two directions: Schlick's approximation of Fresnel's law.
vec3 rx_fresnel(vec3 f0, float cosine) {
    float m = clamp(1.0 - cosine, 0.0, 1.0), m2 = m * m;
    return f0 + (1.0 - f0) * (m2 * m2 * m);
}

// Fresnel's law for light at a boundary of two clear bodies; `cosine` > 0 is that of its angle, `eta` the index behind the boundary over the one
// before it. 1 for total reflection.
float rx_fresnel_dielectric(float cosine, float eta) {
    float g2 = eta * eta - 1.0 + cosine * cosine;
    if (g2 <= 0.0) return 1.0;
    float g = sqrt(g2), a = (g - cosine) / (g + cosine), b = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
    return 0.5 * a * a * (1.0 + b * b);
}

// The share of light that a white GGX surface reflects at a sampled normal. Its mean over rx_ggx_visible_normal is the share that single
// reflections keep, seen along v. `l` is v mirrored about h.
float rx_ggx_kept(vec3 l, vec3 v, float alpha) {
    if (l.z <= 0.0) return 0.0;
    float a2 = alpha * alpha;
    float from = sqrt(a2 + (1.0 - a2) * v.z * v.z) / v.z, to = sqrt(a2 + (1.0 - a2) * l.z * l.z) / l.z;
    return (1.0 + from) / (from + to);
}

// GGX with the light between microfacets put back (Turquin, "Practical multiple scattering compensation for microfacet models", 2019).
// `kept` is the mean of rx_ggx_kept for this v and alpha.
vec3 rx_ggx(vec3 f0, float alpha, vec3 l, vec3 v, float kept) {
    vec3 h = normalize(l + v);
    vec3 once = rx_fresnel(f0, dot(v, h)) * rx_ggx_distribution(h.z, alpha) * rx_ggx_visibility(l.z, v.z, alpha);
    return once * (1.0 + f0 * (1.0 - kept) / kept);
}

// EON: Oren and Nayar's rough matt surface with the light between facets put back (Portsmouth, Kutz and Hill 2024). Roughness 0 is Lambert.
vec3 rx_rough_diffuse(vec3 albedo, float roughness, vec3 l, vec3 v) {
    const float c1 = 0.5 - 2.0 / (3.0 * RX_PI), c2 = 2.0 / 3.0 - 28.0 / (15.0 * RX_PI);
    float a = 1.0 / (1.0 + c1 * roughness);
    float s = dot(l, v) - l.z * v.z;
    vec3 once = albedo / RX_PI * a * (1.0 + roughness * (s > 0.0 ? s / max(max(l.z, v.z), 1e-6) : s));
    // Directional albedo of a white surface, by the paper's polynomial.
    vec2 m = 1.0 - vec2(l.z, v.z);
    vec2 g = m * (0.0571085289 + m * (0.491881867 + m * (-0.332181442 + m * 0.0714429953)));
    vec2 seen = a * (1.0 + roughness * g);
    float mean = a * (1.0 + c2 * roughness);
    vec3 many = albedo * albedo * mean / (1.0 - albedo * (1.0 - mean));
    return once + many / RX_PI * (1.0 - seen.x) * (1.0 - seen.y) / max(1.0 - mean, 1e-7);
}

#endif
