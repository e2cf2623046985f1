// The index of a thread in a dispatch over the elements of a list: `threads = "BUFFER"`, `count = "QUEUE"`. Workgroups beyond a device's
// limit along x continue in rows along y, so `gl_GlobalInvocationID.x` alone is not the index. The last workgroups may reach past the end
// of the list: compare the index with its length.
#ifndef RAXEL_THREAD
#define RAXEL_THREAD

/// The thread's number among all threads of the dispatch, for any shape of the workgroup: threads of one workgroup are neighbours. A macro,
/// because a function in an included file would stand before the shader's `layout(local_size_x = …) in;` and see workgroups of one thread.
/// Use it behind that line.
#define rx_thread() \
    (((gl_WorkGroupID.z * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x) * \
         (gl_WorkGroupSize.x * gl_WorkGroupSize.y * gl_WorkGroupSize.z) + \
     gl_LocalInvocationIndex)

#endif
