// The light along a ray that leaves the world: the sky, and below the horizon the ground or the sea around a finite world (border.comp).
// Needs scene.glsl.
#ifndef BEAUTY_BEYOND_GLSL
#define BEAUTY_BEYOND_GLSL

#include <raxel/light/bsdf.glsl>
#include "land.glsl"

uniform sampler2D land;   // albedo, level; kind

const float LAND_HAZE = 2600.0;   // voxels behind which land is hardly seen

struct Land {
    vec3 albedo;
    float level;   // y of the world
    uint kind;
};

Land read_land() {
    vec4 surface = texelFetch(land, ivec2(0), 0);
    return Land(surface.rgb, surface.a, uint(texelFetch(land, ivec2(1, 0), 0).x));
}

// The distance along a ray to the land; negative where the ray does not get there. `from` is relative to the camera's cell.
float land_distance(Land land, vec3 from, vec3 dir) {
    float height = float(frame.camera_cell.y) + from.y - land.level;
    return land.kind != LAND_NONE && dir.y < -1e-5 && height > 0.0 ? height / -dir.y : -1.0;
}

// The share of the haze at the horizon in the light of the land.
float land_haze(float distance) {
    float far = distance / LAND_HAZE;
    return 1.0 - exp(-far * far);
}

vec3 horizon_radiance(vec3 dir, vec3 to_sun) {
    return sky_radiance(normalize(vec3(dir.x, 0.003, dir.z)), to_sun);
}

// Skylight on a face that looks up, / pi: the mean of five directions.
vec3 sky_above(vec3 to_sun) {
    vec3 sum = 0.36 * sky_radiance(vec3(0.0, 1.0, 0.0), to_sun);
    for (int i = 0; i < 4; ++i) {
        float angle = RX_PI * (0.25 + 0.5 * float(i));
        sum += 0.16 * sky_radiance(vec3(0.707 * cos(angle), 0.707, 0.707 * sin(angle)), to_sun);
    }
    return sum;
}

// Light that the land sends to a ray that has come to `at`, relative to the camera's cell. `sunlit` is the visible share of the sun there,
// and `skylight` the light of the sky, / pi.
vec3 land_radiance(Land land, vec3 at, vec3 dir, float distance, vec3 to_sun, float sunlit, vec3 skylight) {
    vec3 place = vec3(frame.camera_cell) + at, sunlight = sunlit * sun_through_clouds(place) * sun_irradiance(to_sun);
    // Patches of the ground and waves fade where they are smaller than a pixel, even at a grazing angle.
    float pixel = distance * 0.003 / max(-dir.y, 0.02);
    if (land.kind == LAND_GROUND) {
        float patches = 0.0, size = 160.0, height = 0.10;
        for (int i = 0; i < 4; ++i) {
            patches += height * (noise2(place.xz / size) - 0.5) / (1.0 + 4.0 * pixel * pixel / (size * size));
            size *= 0.23;
            height *= 0.7;
        }
        return land.albedo * (1.0 + patches) * (sunlight * (max(to_sun.y, 0.0) / RX_PI) + skylight);
    }
    vec2 slope = vec2(0.0);
    for (float size = 40.0; size > 3.0; size *= 0.4) {
        vec2 cell = place.xz / size;
        slope += 0.10 * vec2(noise2(cell) - 0.5, noise2(cell + 57.3) - 0.5) / (1.0 + 4.0 * pixel * pixel / (size * size));
    }
    vec3 normal = normalize(vec3(slope.x, 1.0, slope.y)), mirrored = reflect(dir, normal);
    mirrored = normalize(vec3(mirrored.x, max(mirrored.y, 0.02), mirrored.z));
    float share = rx_fresnel_dielectric(clamp(-dot(dir, normal), 0.05, 1.0), 1.333);
    vec3 sun = sunlight * 12.0 * pow(max(dot(mirrored, to_sun), 0.0), 160.0);
    vec3 body = 0.22 * land.albedo * (sunlight * (max(to_sun.y, 0.0) / RX_PI) + skylight);
    return mix(body, sky_radiance(mirrored, to_sun) + sun, share);
}

// Radiance from beyond the world, for a ray from `from`, relative to the camera's cell.
vec3 beyond(vec3 from, vec3 dir, vec3 to_sun) {
    Land land = read_land();
    float t = land_distance(land, from, dir);
    if (t < 0.0) {
        vec4 clouds = cloud_march(vec3(frame.camera_cell) + from, dir, to_sun, 6, 0.5);
        return clouds.rgb + clouds.a * sky_radiance(dir, to_sun);
    }
    vec3 light = land_radiance(land, from + t * dir, dir, t, to_sun, 1.0, sky_above(to_sun));
    return mix(light, horizon_radiance(dir, to_sun), land_haze(t));
}

#endif
