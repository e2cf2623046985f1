// For passes that ask for the light of a slice of the view: finds a visible way through the slice, and its place in the
// last frame. Needs scene.glsl, air_slices.glsl, <raxel/random.glsl>, <raxel/light/reproject.glsl>, `hits` and `places`,
// and the camera of the last frame in `push`.
const int TRIES = 8;

// The distance that a pixel sees.
float depth_of(ivec2 pixel) {
    return imageLoad(hits, pixel).w < 0 ? 1e9 : imageLoad(places, pixel).z;
}

// Finds a pixel that sees a point of the slice, so that no light from behind a wall gets into the air before it. If no tried pixel sees as far
// as `t`, takes the one that sees farthest. `reach` ends right before its hit.
vec3 seen_way(ivec3 slice, ivec3 size, float t, inout uint seed, out float reach) {
    ivec2 screen = imageSize(hits), from = slice.xy * screen / size.xy, until = (slice.xy + 1) * screen / size.xy;
    ivec2 wide = max(until - from, ivec2(1)), pixel = from + wide / 2, deepest = pixel;
    float most = -1.0;
    for (int i = 0; i < TRIES && most < t; ++i) {
        float depth = depth_of(min(pixel, screen - 1));
        if (depth > most) {
            most = depth;
            deepest = min(pixel, screen - 1);
        }
        pixel = from + ivec2(rx_random(seed) * float(wide.x), rx_random(seed) * float(wide.y));
    }
    reach = 0.99 * most;
    return pixel_direction(deepest, screen);
}

// The place of a slice's centre in the last frame, in the textures; false where it was out of sight.
bool place_before(ivec3 slice, ivec3 size, out vec3 place) {
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(slice.xy) + 0.5, vec2(size.xy));
    float share = (float(slice.z) + 0.5) / float(size.z);
    vec3 way = vec3(frame.camera_cell - push.cell) + (frame.camera_frac - push.frac) + slice_depth(share) * dir;
    vec2 at;
    bool inside = rx_reproject(way, mat3(push.world_to_view), frame.tan_half_fov, vec2(size.xy), at);
    place = vec3(at / vec2(size.xy), slice_of(length(way)));
    return inside;
}
