// Water as particles: smoothed particle hydrodynamics with its pressure solved by positions (Macklin and Mueller, "Position based fluids",
// 2013). Lengths are in voxels, times in seconds. The water lives in a box of the world; `walls` has its voxels, 1 where solid.
#ifndef SPH_WATER_GLSL
#define SPH_WATER_GLSL

const float REACH = 1.7;             // of a kernel: where particles no longer feel each other
const float REST = 2.03034;          // density of water at rest: two particles a voxel, by the kernel below over a cubic lattice
const float SPACING = 0.7937;        // of that lattice
const float SOFT = 0.05;             // keeps lone particles from being thrown, per square voxel
const float MARGIN = 0.02;           // from a wall
const float PI = 3.14159265;

struct Particle {
    vec3 at;         // from the corner of the box
    float density;   // in parts of that at rest
    vec3 speed;      // in a tick: where the particle was at its beginning
    uint cell;       // of the grid of neighbours
};

uniform usampler3D walls;

ivec3 box_size() {
    return textureSize(walls, 0);
}

// Cells of the grid are as wide as a kernel reaches, so that all neighbours lie in 27 of them.
ivec3 grid_size() {
    return ivec3(ceil(vec3(box_size()) / REACH));
}

uint grid_index(ivec3 cell) {
    ivec3 size = grid_size();
    return uint(cell.x + size.x * (cell.y + size.y * cell.z));
}

ivec3 grid_cell(uint index) {
    ivec3 size = grid_size();
    return ivec3(index % uint(size.x), index / uint(size.x) % uint(size.y), index / uint(size.x * size.y));
}

ivec3 cell_at(vec3 at) {
    return clamp(ivec3(floor(at / REACH)), ivec3(0), grid_size() - 1);
}

// The box has walls on all sides, in any world.
bool solid(ivec3 voxel) {
    return any(lessThan(voxel, ivec3(0))) || any(greaterThanEqual(voxel, box_size())) || texelFetch(walls, voxel, 0).x != 0u;
}

// Poly6 and the slope of the spiky kernel (Mueller, Charypar and Gross 2003).
float kernel(float square) {
    float d = max(REACH * REACH - square, 0.0);
    return 315.0 / (64.0 * PI) / pow(REACH, 9.0) * d * d * d;
}

vec3 kernel_slope(vec3 from) {
    float r = length(from), d = max(REACH - r, 0.0);
    return r > 1e-5 ? -45.0 / PI / pow(REACH, 6.0) * d * d / r * from : vec3(0.0);
}

// A wall counts as water at rest. Gives the share of a kernel behind a plane at this distance, and how fast the share falls with the distance.
float behind(float distance, out float slope) {
    float u = clamp(distance / REACH, 0.0, 1.0), u2 = u * u, w = 1.0 - u2;
    slope = 315.0 / 256.0 * w * w * w * w / REACH;
    return 0.5 - 315.0 / 256.0 * u * (1.0 + u2 * (-4.0 / 3.0 + u2 * (6.0 / 5.0 + u2 * (-4.0 / 7.0 + u2 / 9.0))));
}

// Density that walls give to a place, in parts of that at rest, and its gradient.
float density_of_walls(vec3 at, out vec3 gradient) {
    ivec3 voxel = ivec3(floor(at));
    float sum = 0.0;
    gradient = vec3(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            ivec3 next = voxel;
            for (int i = 1; i <= 2; ++i) {
                next[axis] += side == 0 ? -1 : 1;
                if (!solid(next)) continue;
                float distance = side == 0 ? at[axis] - float(next[axis] + 1) : float(next[axis]) - at[axis], slope;
                sum += behind(distance, slope);
                gradient[axis] += side == 0 ? -slope : slope;
                break;
            }
        }
    }
    return sum;
}

// The place of a particle that wants to go from one place to another: axis by axis, it stays out of solid voxels.
vec3 kept_out(vec3 from, vec3 to) {
    for (int axis = 0; axis < 3; ++axis) {
        vec3 next = from;
        next[axis] = to[axis];
        ivec3 voxel = ivec3(floor(from));
        int last = clamp(int(floor(to[axis])), voxel[axis] - 4, voxel[axis] + 4), way = last > voxel[axis] ? 1 : -1;
        next[axis] = clamp(next[axis], float(last), float(last + 1));
        while (voxel[axis] != last) {
            voxel[axis] += way;
            if (solid(voxel)) {
                next[axis] = way > 0 ? float(voxel[axis]) - MARGIN : float(voxel[axis] + 1) + MARGIN;
                break;
            }
        }
        from = next;
    }
    return clamp(from, vec3(MARGIN), vec3(box_size()) - MARGIN);
}

#endif
