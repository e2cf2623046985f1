// The first members of the block of every layout, included inside of it. The layout's own members follow.
    ivec3 origin;         // smallest corner of a cube around the world; of the root, where the layout is one tree
    uint log2_size;       // the cube has 2^log2_size voxels a side
    ivec3 bounds_min;     // smallest and largest coordinates of solid voxels
    uint material_count;
    ivec3 bounds_last;
    uint materials_at;    // word of the first material, behind the header
