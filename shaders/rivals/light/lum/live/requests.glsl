// Render requests: where the model is to be drawn in this frame. Every pass that reads them works on the boxes that the models cover.

// Each boat has two vectors: the centre and the radius of its circle (voxels); its speed (radians a second), its
// start and its lean to the sides (radians).
layout(std430) readonly buffer Requests { vec4 requests[]; };

int request_count() {
    return requests.length() / 2;
}

// A model in the world: the place of the centre of its floor, and its axes.
struct Placed {
    vec3 at;
    uint drawn;     // 0 before the first frame
    mat3 axes;      // columns: right, up, forward
};

const int EDGE = 32;   // of the cube of voxels that a model may cover

Placed placement(int number, float time) {
    vec4 circle = requests[2 * number], sails = requests[2 * number + 1];
    float angle = sails.y + sails.x * time, lean = sails.z * sin(1.7 * time + sails.y);
    vec3 forward = vec3(-sin(angle), 0.0, cos(angle)) * sign(sails.x + 1e-9), side = cross(vec3(0.0, 1.0, 0.0), forward);
    vec3 up = cos(lean) * vec3(0.0, 1.0, 0.0) + sin(lean) * side;
    Placed placed;
    placed.at = circle.xyz + circle.w * vec3(cos(angle), 0.0, sin(angle)) + vec3(0.0, 0.4 * sin(1.1 * time + sails.y), 0.0);
    placed.drawn = 1u;
    placed.axes = mat3(cross(up, forward), up, forward);
    return placed;
}

// The world's cell of a thread of the cube around a model.
ivec3 cell_of(Placed placed, ivec3 thread) {
    return ivec3(floor(placed.at)) + ivec3(thread.x, thread.y, thread.z) - ivec3(EDGE / 2, 4, EDGE / 2);
}
