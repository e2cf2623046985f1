#include "part.glsl"
#define SIDE 8
[[vk::binding(0)]] RWTexture2D<float4> image;
[numthreads(SIDE, 8u, 2 * (1 + 1))]
void main(uint3 id : SV_DispatchThreadID, in uint group : SV_GroupIndex) { image[id.xy] = float4(.5, 1.e3, 0x1f, 0); }
