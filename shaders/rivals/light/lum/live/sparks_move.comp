// A tick of the sparks: they rise, slow down, drift with the wind and go out. A spark that went out starts from the fire again.
#version 460
#include <raxel/random.glsl>

layout(local_size_x = 64) in;
struct Spark { vec3 at; float left; vec3 speed; float unused; };   // voxels; seconds until it goes out; voxels a second
layout(std430) buffer Sparks { Spark sparks[]; };
layout(push_constant) uniform Push { vec3 fire; uint tick; float delta; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= sparks.length()) return;
    Spark spark = sparks[i];
    spark.left -= push.delta;
    if (spark.left <= 0.0) {
        uint seed = rx_hash(i ^ rx_hash(push.tick));
        vec3 off = vec3(rx_random(seed), 0.0, rx_random(seed)) - vec3(0.5, 0.0, 0.5);
        spark.at = push.fire + 2.5 * off;
        spark.speed = vec3(5.0 * off.x, 7.0 + 6.0 * rx_random(seed), 5.0 * off.z);
        spark.left = 0.3 + 1.9 * rx_random(seed);
    }
    uint wobble = rx_hash(i ^ rx_hash(push.tick ^ 0x5bd1u));
    vec3 push_aside = 26.0 * (vec3(rx_random(wobble), rx_random(wobble), rx_random(wobble)) - 0.5) + vec3(2.5, 0.0, 1.0);
    spark.speed += push.delta * (push_aside - 0.9 * (spark.speed - vec3(0.0, 6.0, 0.0)));
    spark.at += push.delta * spark.speed;
    sparks[i] = spark;
}
