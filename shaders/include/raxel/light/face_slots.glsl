// The number of slots of the table of faces (face_table.glsl). Shaders that declare its buffer need it as the length of arrays.
#ifndef RAXEL_LIGHT_FACE_SLOTS_GLSL
#define RAXEL_LIGHT_FACE_SLOTS_GLSL

#ifdef RX_FACE_WHOLE
const uint RX_FACE_LOG2_SLOTS = 19u;
const uint RX_FACE_HOME_BITS = 19u;
#else
const uint RX_FACE_LOG2_SLOTS = 20u;
const uint RX_FACE_HOME_BITS = 20u;
#endif
const uint RX_FACE_SLOTS = 1u << RX_FACE_LOG2_SLOTS;

#endif
