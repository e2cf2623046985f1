static void *vulkan;
static Find find_of_device;
static Function of_device(void *device, const char *name);
static Function answered(const char *name, Function found) {
    if (!found) return found;
    if (strcmp(name, "vkGetDeviceProcAddr")) return ours(name, found);
    find_of_device = (Find)found;
    return (Function)of_device;
}
static Function of_device(void *device, const char *name) { return answered(name, find_of_device(device, name)); }
Function vkGetInstanceProcAddr(void *instance, const char *name) {
    return answered(name, ((Find)dlsym(vulkan, "vkGetInstanceProcAddr"))(instance, name));
}
void *dlopen(const char *name, int flags) {
    void *(*open)(const char *, int) = dlsym(RTLD_NEXT, "dlopen");
    if (!name || strcmp(name, "libvulkan.so.1")) return open(name, flags);
    vulkan = open(name, flags);
    return vulkan ? open(getenv("LD_PRELOAD"), flags) : NULL;
}
