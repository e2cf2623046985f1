// Rays through panes of glass: results are the share that is left of red and green light behind one pane and behind two bodies side by side, how far behind a
// pane the ray goes on (from where it is now), what a wall behind glass and a body that is too thick answer, and what is left of a ray's length.
#version 460
#include <raxel/world.glsl>
#include <raxel/light/body.glsl>

layout(local_size_x = 1) in;
layout(std430) writeonly buffer Results { float results[]; };

// Along x at half the height of a row of voxels.
RxRay from_left(int y, float slope) {
    return rx_ray(ivec3(-4, y, 0), vec3(0.5, 0.5, 0.5), vec3(2.0, 2.0 * slope, 0.0));
}

void main() {
    RxHit hit;
    vec3 share = vec3(1.0);
    RxRay ray = from_left(0, 0.0);
    ray.t_max = 10.0;
    bool met = rx_trace(ray, hit), passed = met && rx_pass_body(hit, 8u, ray, share);
    results[0] = passed ? share.r : -1.0;
    results[1] = passed ? share.g : -1.0;
    results[2] = passed ? float(ray.cell.x) + ray.frac.x : -1.0;
    results[3] = ray.t_max;

    share = vec3(1.0);
    ray = from_left(2, 0.0);
    met = rx_trace(ray, hit);
    results[4] = met && rx_pass_body(hit, 8u, ray, share) ? share.r : -1.0;
    results[5] = share.g;

    share = vec3(1.0);
    ray = from_left(4, 0.0);
    met = rx_trace(ray, hit);
    results[6] = met && !rx_pass_body(hit, 8u, ray, share) && share == vec3(1.0) ? 1.0 : 0.0;
    ray = from_left(6, 0.0);
    met = rx_trace(ray, hit);
    results[7] = met && !rx_pass_body(hit, 8u, ray, share) && share == vec3(1.0) ? 1.0 : 0.0;

    // Slanting, the way through the pane is longer by the slope's factor.
    share = vec3(1.0);
    ray = from_left(-1, 0.1);
    met = rx_trace(ray, hit);
    results[8] = met && rx_pass_body(hit, 8u, ray, share) ? share.g : -1.0;
    results[9] = float(ray.cell.y) + ray.frac.y;
}
