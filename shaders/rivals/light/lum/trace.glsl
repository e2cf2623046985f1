// What the rays of Lum's passes meet: the world; with REQUESTS also what is drawn into copies of its blocks. Needs field.glsl.
#ifdef REQUESTS
#include "requests/blocks.glsl"
#else
#define lum_trace rx_trace
#endif
