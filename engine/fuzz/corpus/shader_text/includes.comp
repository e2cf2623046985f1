#version 460
#include "part.glsl"
#include <raxel/thread.glsl>
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) writeonly uniform image2D outColor; // é漢
#define TWICE(x) ((x) * 2.0)
struct Cell { int a, b[3]; };
struct Cells { Cell first; Cell rest[7]; };
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    float light = TWICE(shade(sunn)) + 1.5e-3; /* a comment
    of two lines */
    imageStore(outColor, pixel, vec4(light));
}
#file shaders/part.glsl
#pragma once
#include "deep/more.glsl"
float shade(vec3 sun) { return max(dot(sun, vec3(0.0, 1.0, 0.0)), 0.0); }
float shade(float sun) { return sun; }
#file shaders/deep/more.glsl
#ifndef MORE
#define MORE
#include "../part.glsl"
float more(int a) { return float(a) \
    + 1.0; }
#endif
#file output
shaders/main.comp:11: error: 'sunn' : undeclared identifier
shaders/main.comp:11: error: 'shade' : no matching overloaded function found
shaders/part.glsl:3: warning: 'sun' : cannot convert from ' const 3-component vector of float' to ' temp int'
<raxel/thread.glsl>:3: error: '' :  syntax error, unexpected RIGHT_BRACE
3 errors generated.
