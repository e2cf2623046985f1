#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>
typedef unsigned long long Word;
typedef int (*Call)(Word, Word, Word, Word, Word, Word, Word, Word);
enum { LOST = -4, OUT_OF_DATE = -1000001004, SURFACE_LOST = -1000000000, CALLS = sizeof names / sizeof *names };
static Call found_calls[CALLS];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static int order = -1, seen = -1, number, left, answer, armed, always;
static char wanted[64];
static Word lost, queues[64], devices[64];
static unsigned made;
static int (*queue_idle)(Word);
static void (*get_queue)(Word, unsigned, unsigned, Word *);
static void (*destroy)(Word, const void *);

static int is_lost(Word handle) {
    if (!lost) return 0;
    for (unsigned i = 0; i < made && i < 64; i++) if (queues[i] == handle && devices[i] == lost) return 1;
    return handle == lost;
}
static void finish(Word device) {
    for (unsigned i = 0; i < 64; i++) if (queues[i] && devices[i] == device && queue_idle) queue_idle(queues[i]);
}
static Word device_of(Word handle) {
    for (unsigned i = made < 64 ? made : 64; i--;) if (queues[i] == handle) return devices[i];
    return handle;
}
static int call(int n, Word a, Word b, Word c, Word d, Word e, Word f, Word g, Word h) {
    const char *name = names[n];
    char text[128] = {0};
    int fail = 0, presents = !strcmp(name, "vkQueuePresentKHR");
    pthread_mutex_lock(&lock);
    if (order < 0) order = open(getenv("FAULTS_ORDER"), O_RDONLY | O_CLOEXEC);
    if (seen < 0) seen = open(getenv("FAULTS_SEEN"), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (pread(order, text, sizeof text - 1, 0) > 0) {
        int other = 0, skip = 0, code = 0, more = 0;
        char which[64] = {0};
        if (sscanf(text, "%d %63s %d %d %d", &other, which, &skip, &code, &more) == 5 && other != number) {
            number = other; left = skip; answer = code; armed = code != 0; always = more;
            strcpy(wanted, which);
        }
    }
    if (armed && !strcmp(name, wanted) && left-- <= 0) {
        fail = answer;
        armed = always;
        if (fail == LOST && strcmp(name, "vkCreateDevice")) lost = device_of(a);
    }
    if (!fail && can_lose[n] && is_lost(a)) fail = LOST;
    int line = snprintf(text, sizeof text, "%d %s %d\n", number, name, fail);
    if (write(seen, text, line) != line) abort();
    pthread_mutex_unlock(&lock);
    if (fail) {
        /* What was submitted is finished, so that no pass can be blamed, and all can be destroyed as with a device that is really lost. */
        if (fail == LOST && strcmp(name, "vkCreateDevice")) finish(device_of(a));
        /* A picture that comes too late is taken from the queue all the same. */
        if (fail > 0 || (presents && (fail == OUT_OF_DATE || fail == SURFACE_LOST))) {
            int done = found_calls[n](a, b, c, d, e, f, g, h);
            return done < 0 ? done : fail;
        }
        if (strstr(name, "Pipelines")) memset((void *)f, 0, 8 * (unsigned)c);
        return fail;
    }
    return found_calls[n](a, b, c, d, e, f, g, h);
}
static void note_queue(Word device, unsigned family, unsigned index, Word *queue) {
    get_queue(device, family, index, queue);
    pthread_mutex_lock(&lock);
    queues[made % 64] = *queue;
    devices[made % 64] = device;
    made++;
    pthread_mutex_unlock(&lock);
}
static void note_end(Word device, const void *allocator) {
    pthread_mutex_lock(&lock);
    if (lost == device) lost = 0;
    for (unsigned i = 0; i < 64; i++) if (devices[i] == device) queues[i] = devices[i] = 0;
    pthread_mutex_unlock(&lock);
    destroy(device, allocator);
}
