// A copied block of 16³ voxels: the material of each, and above it the instance + 1. Voxel (x, y, z) has the index x + 16 y + 256 z.
const uint BLOCK_VOXELS = 4096u;
struct Block { uint voxels[4096]; };
