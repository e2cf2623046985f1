#include <pthread.h>
#include <stdarg.h>
#include <unistd.h>
enum { LIMITS = -1, FEATURES = -2, AT_MOST = 0, AT_LEAST = 1, AND = 2, SET = 3 };
enum { FORMAT_NOT_SUPPORTED = -11, INCOMPLETE = 5 };
enum { SAMPLED_BIT = 1, STORAGE_BIT = 2, ATOMIC_BIT = 4, FILTER_BIT = 0x1000 };
enum { CAPABILITY = 17, EXECUTION_MODE = 16, EXECUTION_MODE_ID = 331, LOCAL_SIZE = 17, LOCAL_SIZE_ID = 38 };
enum { DECORATE = 71, SPEC_ID = 1, BUILT_IN = 11, WORKGROUP_SIZE = 25, VARIABLE = 59, WORKGROUP_CLASS = 4 };
enum { TYPE_BOOL = 20, TYPE_INT = 21, TYPE_FLOAT = 22, TYPE_VECTOR = 23, TYPE_MATRIX = 24, TYPE_ARRAY = 28, TYPE_STRUCT = 30, TYPE_POINTER = 32 };
enum { CONSTANT_TRUE = 41, CONSTANT = 43, CONSTANT_COMPOSITE = 44, SPEC_TRUE = 48, SPEC_FALSE = 49, SPEC_CONSTANT = 50, SPEC_COMPOSITE = 51, SPEC_OPERATION = 52 };
enum { COMPOSITE_EXTRACT = 81, ADD = 128, SUB = 130, MUL = 132, UDIV = 134, SDIV = 135, SELECT = 169, GREATER = 172, LESS = 176 };
enum { CREATION_FEEDBACK = 1000192000, REQUIRED_SUBGROUP_SIZE = 1000225001, PIPELINE_SIZE = 96, UNIFORM_BUFFER = 6 };
enum { GRAPHICS_BIT = 1, USAGE_STORAGE = 8, NAME_SIZE = 256, EXTENSION_SIZE = 260, FAMILY_SIZE = 24 };

static void exceeded(const char *what, Word asked, Word most) {
    fprintf(stderr, "%s: asked for %llu %s of %llu\n", device_name, asked, what, most);
    fflush(NULL);
    _exit(EXCEEDED);
}
static void lacks(unsigned capability) {
    fprintf(stderr, "%s: a module declares the capability %u, which the device lacks\n", device_name, capability);
    fflush(NULL);
    _exit(EXCEEDED);
}
static void lower(void *answer, int of) {
    for (unsigned i = 0; i < sizeof patches / sizeof *patches; i++) {
        const struct Patch *patch = &patches[i];
        if (patch->of != of) continue;
        unsigned *word = (unsigned *)((char *)answer + patch->at);
        if (patch->how == AND) *word &= patch->value;
        if (patch->how == AT_MOST && *word > patch->value) *word = patch->value;
        if (patch->how == AT_LEAST && *word < patch->value) *word = patch->value;
        if (patch->how == SET) *word = patch->value;
    }
}
static void lower_chain(struct Chain *chain) {
    for (; chain; chain = chain->next) lower(chain, chain->type);
}
static int among(int format, const int *formats, unsigned count) {
    for (unsigned i = 0; i < count; i++) if (formats[i] == format) return 1;
    return 0;
}
static int is_known(int format) { return FORMATS || !among(format, unknown, sizeof unknown / sizeof *unknown); }
static int stores(int format) {
    return FORMATS || among(format, stored_everywhere, sizeof stored_everywhere / sizeof *stored_everywhere);
}

static void (*properties)(Word, void *), (*properties2)(Word, struct Chain *);
static void (*features)(Word, void *), (*features2)(Word, struct Chain *);
static void (*formats)(Word, int, unsigned *);
static int (*images)(Word, int, int, int, unsigned, unsigned, unsigned *);
static void (*families)(Word, unsigned *, char *);
static int (*extensions)(Word, const char *, unsigned *, char *);
static int (*create_device)(Word, const char *, const void *, Word *);
static int (*create_layout)(Word, const char *, const void *, Word *);
static int (*create_image)(Word, const char *, const void *, Word *);
static int (*create_pipeline_layout)(Word, const char *, const void *, Word *);
static int (*create_module)(Word, const char *, const void *, Word *);
static int (*create_pipelines)(Word, Word, unsigned, const char *, const void *, Word *);
static void (*image_memory)(Word, const char *, void *);
static int (*times)(Word, Word, unsigned, unsigned, size_t, Word *, Word, unsigned);
static void (*blit)(Word, Word, int, Word, int, unsigned, const void *, int);
static int (*create_drawing)(Word, Word, unsigned, const void *, const void *, Word *);
static void (*update_sets)(Word, unsigned, const char *, unsigned, const void *);

static void our_properties(Word device, void *answer) { properties(device, answer); lower(answer, LIMITS); }
static void our_properties2(Word device, struct Chain *answer) {
    properties2(device, answer);
    lower(answer + 1, LIMITS);
    lower_chain(answer->next);
}
static void our_features(Word device, void *answer) { features(device, answer); lower(answer, FEATURES); }
static void our_features2(Word device, struct Chain *answer) {
    features2(device, answer);
    lower(answer + 1, FEATURES);
    lower_chain(answer->next);
}
static void our_formats(Word device, int format, unsigned *answer) {
    formats(device, format, answer);
    for (int i = 0; i < 3; i++) {
        if (!is_known(format)) answer[i] = 0;
        if (!stores(format)) answer[i] &= ~(unsigned)(STORAGE_BIT | ATOMIC_BIT);
        if (!FORMATS && among(format, unfiltered, sizeof unfiltered / sizeof *unfiltered)) answer[i] &= ~(unsigned)FILTER_BIT;
    }
}
static int our_images(Word device, int format, int type, int tiling, unsigned usage, unsigned flags, unsigned *answer) {
    if (!is_known(format) || ((usage & USAGE_STORAGE) && !stores(format))) return FORMAT_NOT_SUPPORTED;
    int result = images(device, format, type, tiling, usage, flags, answer);
    unsigned most = type == 2 ? SIDE_3D : SIDE_2D;
    for (int i = 0; i < 3; i++) if (!result && answer[i] > most) answer[i] = most;
    return result;
}
static void our_families(Word device, unsigned *count, char *answer) {
    families(device, count, answer);
    for (unsigned i = 0; answer && i < *count; i++) {
        unsigned *family = (unsigned *)(answer + FAMILY_SIZE * i);
        if (!GRAPHICS) family[0] &= ~(unsigned)GRAPHICS_BIT;
        if (family[2] > TIMESTAMP_BITS) family[2] = TIMESTAMP_BITS;
    }
}
/* The clock begins again at 0 after the first time. */
static int our_times(Word device, Word pool, unsigned first, unsigned count, size_t size, Word *answer, Word stride, unsigned flags) {
    int result = times(device, pool, first, count, size, answer, stride, flags);
    Word last = TIMESTAMP_BITS < 64 ? (1ull << TIMESTAMP_BITS) - 1 : ~0ull, start = answer[0];
    for (unsigned i = 0; TIMESTAMP_BITS < 64 && i < count; i++) answer[i * stride / 8] = (answer[i * stride / 8] - start + last) & last;
    return result;
}
static void our_blit(Word commands, Word from, int from_layout, Word to, int to_layout, unsigned count, const void *regions, int filter) {
    if (!GRAPHICS) exceeded("blits on a queue with graphics", count, 0);
    blit(commands, from, from_layout, to, to_layout, count, regions, filter);
}
static int our_drawing(Word device, Word cache, unsigned count, const void *infos, const void *allocator, Word *made) {
    if (!GRAPHICS) exceeded("pipelines that draw", count, 0);
    return create_drawing(device, cache, count, infos, allocator, made);
}
static int is_kept(const char *extension) {
    if (!strcmp(extension, "VK_KHR_swapchain")) return SWAPCHAIN;
    return EXTENSIONS || ((MINOR < 3) && (!strcmp(extension, "VK_KHR_synchronization2") ||
        !strcmp(extension, "VK_KHR_maintenance4") || !strcmp(extension, "VK_KHR_dynamic_rendering")));
}
/* Of Vulkan 1.3; each has another name by its extension. */
static int is_core13(const char *name) {
    static const char *const all[] = { "vkCmdPipelineBarrier2", "vkQueueSubmit2", "vkCmdWriteTimestamp2", "vkCmdSetEvent2", "vkCmdWaitEvents2",
        "vkGetDeviceBufferMemoryRequirements", "vkGetDeviceImageMemoryRequirements", "vkCmdBeginRendering", "vkCmdEndRendering",
        "vkCmdBlitImage2", "vkCmdCopyBuffer2", "vkCmdCopyImage2", "vkCmdCopyBufferToImage2", "vkCmdCopyImageToBuffer2", "vkCmdResolveImage2",
        "vkCmdResetEvent2", "vkGetDeviceImageSparseMemoryRequirements", "vkGetPhysicalDeviceToolProperties", "vkCreatePrivateDataSlot" };
    for (unsigned i = 0; i < sizeof all / sizeof *all; i++) if (!strcmp(name, all[i])) return 1;
    return 0;
}
static int our_extensions(Word device, const char *layer, unsigned *count, char *answer) {
    unsigned all = 0, kept = 0;
    int result = extensions(device, layer, &all, NULL);
    if (result || !all) { *count = all; return result; }
    char *found = malloc((size_t)all * EXTENSION_SIZE);
    result = extensions(device, layer, &all, found);
    for (unsigned i = 0; i < all; i++) {
        if (!is_kept(found + i * EXTENSION_SIZE)) continue;
        if (answer && kept < *count) memcpy(answer + kept * EXTENSION_SIZE, found + i * EXTENSION_SIZE, EXTENSION_SIZE);
        kept++;
    }
    free(found);
    if (answer && kept > *count) return INCOMPLETE;
    *count = kept;
    return result;
}
/* What is asked for is what is offered. */
static int our_device(Word physical, const char *info, const void *allocator, Word *device) {
    const unsigned *asked = *(const unsigned *const *)(info + 64);
    for (unsigned i = 0; i < sizeof patches / sizeof *patches; i++) {
        const struct Patch *patch = &patches[i];
        if (patch->how != AND || patch->value) continue;
        if (patch->of == FEATURES && asked && asked[patch->at / 4]) exceeded("of a feature at byte", patch->at, 0);
        for (const struct Chain *chain = *(struct Chain *const *)(info + 8); chain; chain = chain->next)
            if (chain->type == patch->of && *(const unsigned *)((const char *)chain + patch->at)) exceeded("of a feature at byte", patch->at, 0);
    }
    unsigned count = *(const unsigned *)(info + 48);
    const char *const *names = *(const char *const *const *)(info + 56);
    for (unsigned i = 0; i < count; i++) if (!is_kept(names[i])) exceeded(names[i], 1, 0);
    return create_device(physical, info, allocator, device);
}
static int our_layout(Word device, const char *info, const void *allocator, Word *layout) {
    unsigned count = *(const unsigned *)(info + 20), of[16] = {0}, all = 0;
    const char *binding = *(const char *const *)(info + 24);
    for (unsigned i = 0; i < count; i++, binding += 24) {
        const unsigned *words = (const unsigned *)binding;
        if (words[1] < 16) of[words[1]] += words[2];
        all += words[2];
    }
    if (of[7] + of[9] > STORAGE_BUFFERS) exceeded("storage buffers", of[7] + of[9], STORAGE_BUFFERS);
    if (of[3] > STORAGE_IMAGES) exceeded("storage images", of[3], STORAGE_IMAGES);
    if (of[6] + of[8] > UNIFORM_BUFFERS) exceeded("uniform blocks", of[6] + of[8], UNIFORM_BUFFERS);
    if (of[1] + of[2] > SAMPLED_IMAGES) exceeded("sampled images", of[1] + of[2], SAMPLED_IMAGES);
    if (all > RESOURCES) exceeded("resources", all, RESOURCES);
    return create_layout(device, info, allocator, layout);
}
static int our_pipeline_layout(Word device, const char *info, const void *allocator, Word *layout) {
    unsigned count = *(const unsigned *)(info + 32);
    const unsigned *range = *(const unsigned *const *)(info + 40);
    for (unsigned i = 0; i < count; i++, range += 3)
        if (range[1] + range[2] > PUSH_CONSTANTS) exceeded("bytes of push constants", range[1] + range[2], PUSH_CONSTANTS);
    return create_pipeline_layout(device, info, allocator, layout);
}
/* The texts of modules, for the pipelines made of them. A handle may come again for another module: the newest one counts. */
struct Module { Word handle, words; unsigned *code; struct Module *next; };
static struct Module *modules;
static pthread_mutex_t of_modules = PTHREAD_MUTEX_INITIALIZER;

static int our_module(Word device, const char *info, const void *allocator, Word *module) {
    Word words = *(const Word *)(info + 24) / 4;
    const unsigned *code = *(const unsigned *const *)(info + 32);
    for (Word at = 5; at + 1 < words && code[at] >> 16; at += code[at] >> 16)
        for (unsigned i = 0; (code[at] & 0xffff) == CAPABILITY && i < sizeof missing / sizeof *missing; i++)
            if (code[at + 1] == missing[i]) lacks(code[at + 1]);
    int result = create_module(device, info, allocator, module);
    if (result) return result;
    struct Module *made = malloc(sizeof *made);
    made->handle = *module;
    made->words = words;
    made->code = memcpy(malloc(words * 4), code, words * 4);
    pthread_mutex_lock(&of_modules);
    made->next = modules;
    modules = made;
    pthread_mutex_unlock(&of_modules);
    return result;
}
/* The value that a pipeline gives a specialization constant. */
static Word specialized(const char *info, unsigned id, Word usual) {
    unsigned count = info ? *(const unsigned *)info : 0;
    const char *entry = info ? *(const char *const *)(info + 8) : NULL, *data = info ? *(const char *const *)(info + 24) : NULL;
    for (unsigned i = 0; i < count; i++, entry += 16)
        if (*(const unsigned *)entry == id) memcpy(&usual, data + *(const unsigned *)(entry + 4), *(const Word *)(entry + 8));
    return usual;
}
static Word computed(const unsigned *code, unsigned words, const Word *values, const unsigned *const *parts) {
    if (words < 6) return 0;
    Word left = values[code[4]], right = values[code[5]];
    switch (code[3]) {
    case COMPOSITE_EXTRACT: return parts[code[4]] ? values[parts[code[4]][3 + code[5]]] : 0;
    case ADD: return left + right;
    case SUB: return left - right;
    case MUL: return left * right;
    case UDIV: case SDIV: return right ? left / right : 0;
    case SELECT: return left ? right : values[code[6]];
    case GREATER: return left > right;
    case LESS: return left < right;
    default: return 0;
    }
}
/* The workgroup and the shared memory of a pipeline, with its constants. A length that is computed in another way than these counts as nothing. */
static void look_at_pipeline(const char *info) {
    pthread_mutex_lock(&of_modules);
    const struct Module *module = modules;
    while (module && module->handle != *(const Word *)(info + 48)) module = module->next;
    pthread_mutex_unlock(&of_modules);
    if (!module) return;
    const unsigned *code = module->code;
    const char *constants = *(const char *const *)(info + 64);
    Word *values = calloc(code[3], sizeof *values), *sizes = calloc(code[3], sizeof *sizes), shared = 0, side[3] = {1, 1, 1};
    unsigned *numbers = calloc(code[3], sizeof *numbers), ids[3] = {0}, workgroup = 0;
    const unsigned **parts = calloc(code[3], sizeof *parts);
    for (Word at = 5; at < module->words && code[at] >> 16; at += code[at] >> 16) {
        const unsigned *of = code + at, words = *of >> 16;
        switch (*of & 0xffff) {
        case DECORATE:
            if (of[2] == SPEC_ID) numbers[of[1]] = of[3] + 1;
            if (of[2] == BUILT_IN && of[3] == WORKGROUP_SIZE) workgroup = of[1];
            break;
        case EXECUTION_MODE:
            for (int i = 0; of[2] == LOCAL_SIZE && i < 3; i++) side[i] = of[3 + i];
            break;
        case EXECUTION_MODE_ID:
            for (int i = 0; of[2] == LOCAL_SIZE_ID && i < 3; i++) ids[i] = of[3 + i];
            break;
        case CONSTANT_TRUE: values[of[2]] = 1; break;
        case SPEC_TRUE: case SPEC_FALSE:
            values[of[2]] = (*of & 0xffff) == SPEC_TRUE;
            if (numbers[of[2]]) values[of[2]] = specialized(constants, numbers[of[2]] - 1, values[of[2]]);
            break;
        case CONSTANT: values[of[2]] = of[3]; break;
        case SPEC_CONSTANT: values[of[2]] = numbers[of[2]] ? specialized(constants, numbers[of[2]] - 1, of[3]) : of[3]; break;
        case SPEC_OPERATION: values[of[2]] = computed(of, words, values, parts); break;
        case CONSTANT_COMPOSITE: case SPEC_COMPOSITE:
            parts[of[2]] = of;
            for (int i = 0; of[2] == workgroup && i < 3; i++) ids[i] = of[3 + i];
            break;
        case TYPE_BOOL: sizes[of[1]] = 4; break;
        case TYPE_INT: case TYPE_FLOAT: sizes[of[1]] = of[2] / 8; break;
        case TYPE_VECTOR: case TYPE_MATRIX: sizes[of[1]] = sizes[of[2]] * of[3]; break;
        case TYPE_ARRAY: sizes[of[1]] = sizes[of[2]] * values[of[3]]; break;
        case TYPE_STRUCT: for (unsigned i = 2; i < words; i++) sizes[of[1]] += sizes[of[i]]; break;
        case TYPE_POINTER: sizes[of[1]] = sizes[of[3]]; break;
        case VARIABLE: if (of[3] == WORKGROUP_CLASS) shared += sizes[of[1]]; break;
        default: break;
        }
    }
    for (int i = 0; i < 3; i++) if (ids[i]) side[i] = values[ids[i]];
    static const unsigned sides[3] = { WORKGROUP_X, WORKGROUP_Y, WORKGROUP_Z };
    for (int i = 0; i < 3; i++) if (side[i] > sides[i]) exceeded("invocations along an axis of a workgroup", side[i], sides[i]);
    Word threads = side[0] * side[1] * side[2];
    if (threads > INVOCATIONS) exceeded("invocations in a workgroup", threads, INVOCATIONS);
    if (shared > SHARED_MEMORY) exceeded("bytes of shared memory", shared, SHARED_MEMORY);
    free(values);
    free(sizes);
    free(numbers);
    free(parts);
}
/* One pipeline at a time, as raxel makes them. The device below has other sizes of subgroups: what is asked for is looked at, and not passed on. */
static int our_pipelines(Word device, Word cache, unsigned count, const char *infos, const void *allocator, Word *made) {
    usleep(1000 * PIPELINE_MILLISECONDS);
    for (unsigned i = 0; i < count; i++) look_at_pipeline(infos + PIPELINE_SIZE * i);
    for (const struct Chain *chain = *(struct Chain *const *)(infos + 8); chain; chain = chain->next)
        if (MINOR < 3 && chain->type == CREATION_FEEDBACK) exceeded("structures of Vulkan 1.3", 1, 0);
    const struct Chain *asked = *(const struct Chain *const *)(infos + 32);
    if (!SUBGROUPS || count != 1 || !asked || asked->type != REQUIRED_SUBGROUP_SIZE) return create_pipelines(device, cache, count, infos, allocator, made);
    unsigned size = *(const unsigned *)(asked + 1);
    if (size < SUBGROUP_LEAST || size > SUBGROUP_MOST) exceeded("invocations in a subgroup", size, SUBGROUP_MOST);
    Word info[PIPELINE_SIZE / 8];
    memcpy(info, infos, PIPELINE_SIZE);
    info[4] = (Word)asked->next;
    return create_pipelines(device, cache, 1, (const char *)info, allocator, made);
}
static void look_at_image(const char *info) {
    const unsigned *words = (const unsigned *)(info + 16);
    unsigned type = words[1], format = words[2], most = type == 2 ? SIDE_3D : SIDE_2D, usage = *(const unsigned *)(info + 56);
    for (int i = 3; i < 6; i++) if (words[i] > most) exceeded("texels along a side", words[i], most);
    if (words[7] > LAYERS) exceeded("layers", words[7], LAYERS);
    if (!is_known(format)) exceeded("as image: format", format, 0);
    if ((usage & USAGE_STORAGE) && !stores(format)) exceeded("as storage image: format", format, 0);
}
static int our_image(Word device, const char *info, const void *allocator, Word *image) {
    look_at_image(info);
    return create_image(device, info, allocator, image);
}
static void our_image_memory(Word device, const char *info, void *answer) {
    look_at_image(*(const char *const *)(info + 16));
    image_memory(device, info, answer);
}
static void our_sets(Word device, unsigned count, const char *writes, unsigned copies, const void *copied) {
    for (unsigned i = 0; i < count; i++) {
        const char *write = writes + 64 * i;
        unsigned buffers = *(const unsigned *)(write + 32), type = *(const unsigned *)(write + 36);
        const Word *buffer = *(const Word *const *)(write + 48);
        Word most = type == UNIFORM_BUFFER ? UNIFORM_RANGE : BUFFER_RANGE;
        for (unsigned k = 0; (type == 7 || type == 9 || type == UNIFORM_BUFFER) && k < buffers; k++) {
            Word offset = buffer[3 * k + 1], range = buffer[3 * k + 2];
            if (range != ~0ull && range > most) exceeded("bytes of a buffer", range, most);
            if (offset % ALIGNMENT) exceeded("as offset of a buffer, multiples", offset, ALIGNMENT);
        }
    }
    update_sets(device, count, writes, copies, copied);
}
static void *vulkan;
static Function ours(const char *name, Function found) {
    if ((MINOR < 3) && is_core13(name)) return NULL;
#define OURS(call, here) if (!strcmp(name, call)) { here = (void *)found; return (Function)our_##here; }
    OURS("vkGetPhysicalDeviceProperties", properties)
    OURS("vkGetPhysicalDeviceProperties2", properties2)
    OURS("vkGetPhysicalDeviceFeatures", features)
    OURS("vkGetPhysicalDeviceFeatures2", features2)
    OURS("vkGetPhysicalDeviceFormatProperties", formats)
    OURS("vkGetPhysicalDeviceImageFormatProperties", images)
    OURS("vkGetPhysicalDeviceQueueFamilyProperties", families)
    OURS("vkEnumerateDeviceExtensionProperties", extensions)
#undef OURS
/* The loader's own function finds the driver of the device that it is called with: each device has other functions. */
#define OURS(call, before, here) if (!strcmp(name, call)) { before = dlsym(vulkan, name); return (Function)here; }
    OURS("vkCreateDevice", create_device, our_device)
    OURS("vkCreateDescriptorSetLayout", create_layout, our_layout)
    OURS("vkCreatePipelineLayout", create_pipeline_layout, our_pipeline_layout)
    OURS("vkCreateShaderModule", create_module, our_module)
    OURS("vkCreateComputePipelines", create_pipelines, our_pipelines)
    OURS("vkCreateImage", create_image, our_image)
    OURS("vkGetDeviceImageMemoryRequirements", image_memory, our_image_memory)
    OURS("vkUpdateDescriptorSets", update_sets, our_sets)
    OURS("vkGetQueryPoolResults", times, our_times)
    OURS("vkCmdBlitImage", blit, our_blit)
    OURS("vkCreateGraphicsPipelines", create_drawing, our_drawing)
    return found;
}
