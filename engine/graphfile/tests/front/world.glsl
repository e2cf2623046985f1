layout(std430) readonly buffer RxWorld {
    ivec3 origin;
    uint root;
    uint words[];
} world;
