// Holds the first program that opens a file of the name `slow.exr`, until there is a file `GATE`.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
static void hold(const char *path) {
    size_t length = strlen(path);
    if (length < 8 || strcmp(path + length - 8, "slow.exr")) return;
    while (access(getenv("GATE"), F_OK)) usleep(1000);
}
#define OPEN(name) \
    int name(const char *path, int flags, ...) { \
        va_list more; \
        va_start(more, flags); \
        int mode = va_arg(more, int); \
        va_end(more); \
        hold(path); \
        return ((int (*)(const char *, int, ...))dlsym(RTLD_NEXT, #name))(path, flags, mode); \
    }
OPEN(open)
OPEN(open64)
