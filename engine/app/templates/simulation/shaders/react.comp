// One step of the Gray-Scott model: du = Du lap(u) - u v v + feed (1 - u), dv = Dv lap(v) + u v v - (feed + kill) v.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32f) uniform readonly image2D before;
layout(rg32f) uniform writeonly image2D outChemicals;
layout(push_constant) uniform Push {
    uint tick;
    float feed;
    float kill;
    ivec2 cursor;
    ivec2 output_size;
};

// The plane has no edge: what leaves on one side comes in on the other.
vec2 at(ivec2 cell) {
    ivec2 size = imageSize(before);
    return imageLoad(before, (cell + size) % size).xy;
}

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outChemicals);
    if (any(greaterThanEqual(cell, size))) return;

    vec2 here = at(cell);
    vec2 sides = at(cell + ivec2(1, 0)) + at(cell - ivec2(1, 0)) + at(cell + ivec2(0, 1)) + at(cell - ivec2(0, 1));
    vec2 corners = at(cell + ivec2(1, 1)) + at(cell - ivec2(1, 1)) + at(cell + ivec2(1, -1)) + at(cell + ivec2(-1, 1));
    vec2 spread = 0.2 * sides + 0.05 * corners - here;
    float reaction = here.x * here.y * here.y;
    vec2 next = here + vec2(spread.x - reaction + feed * (1.0 - here.x), 0.5 * spread.y + reaction - (feed + kill) * here.y);

    // A few drops of the second chemical at the start, and one wherever the cursor is.
    vec2 place = (vec2(cell) + 0.5) / vec2(size);
    bool drop = tick == 0u && distance(fract(place * vec2(4.0, 3.0) + 0.13 * vec2(cell.yx) / 40.0), vec2(0.5)) < 0.14;
    bool brush = cursor.x >= 0 && distance(vec2(cursor) / vec2(output_size) * vec2(size), vec2(cell)) < 3.0;
    if (drop || brush) next.y = 0.9;
    imageStore(outChemicals, cell, vec4(next, 0.0, 0.0));
}
