#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>
static int full(int to, off64_t at, size_t size) {
    struct stat about;
    char link[64], name[512] = "";
    if (!size || fstat(to, &about) || !S_ISREG(about.st_mode)) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", to);
    if (readlink(link, name, sizeof name - 1) < 0 || !strncmp(name, "/memfd:", 7)) return 0;
    if (at < 0) at = lseek64(to, 0, SEEK_CUR);
    const char *room = getenv("ROOM_FOR_FILES");
    if (room && at + (off64_t)size <= atoll(room)) return 0;
    errno = ENOSPC;
    return 1;
}
#define REAL(function) ((__typeof__(&function))dlsym(RTLD_NEXT, #function))
ssize_t write(int to, const void *from, size_t size) { return full(to, -1, size) ? -1 : REAL(write)(to, from, size); }
ssize_t writev(int to, const struct iovec *from, int count) {
    size_t size = 0;
    for (int i = 0; i < count; i++) size += from[i].iov_len;
    return full(to, -1, size) ? -1 : REAL(writev)(to, from, count);
}
ssize_t pwrite64(int to, const void *from, size_t size, off64_t at) { return full(to, at, size) ? -1 : REAL(pwrite64)(to, from, size, at); }
ssize_t copy_file_range(int from, off64_t *at, int to, off64_t *place, size_t size, unsigned flags) {
    return full(to, place ? *place : -1, size) ? -1 : REAL(copy_file_range)(from, at, to, place, size, flags);
}
