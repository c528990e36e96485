/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Preloaded into the command: calls fail as a system in need lets them.
 *
 *   FAIL_ALLOCATION=k   malloc, calloc, realloc, aligned_alloc, posix_memalign
 *   FAIL_FILE=k         open, fopen, write, pwrite, fwrite, fsync, rename; unlink
 *                       counts but does not fail
 *   FAIL_THREAD=k       pthread_create, where k - 1 run beside the first
 *   FAIL_SIGNAL=n       the k-th call of memory or files does not fail: before it the
 *                       process sends itself this signal, so that a kill, a stop or an
 *                       interruption comes at a known moment on a machine of any speed
 *   FAIL_COUNT=FILE     write the numbers of calls there at the end: allocations,
 *                       threads, file calls, writes
 *   FAIL_ALONE=1        programs that the command starts are left alone
 *
 * Calls before main() count too: a program that cannot start is a clean failure.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);

static atomic_long n_allocations, n_threads, n_files, n_writes;
static long failing_allocation, failing_thread, failing_file, failing_write;
static long own_signal;
static bool is_counting;

static long number_of(const char *name)
{
    const char *text = getenv(name);
    return text ? atol(text) : 0;
}

__attribute__((constructor)) static void begin(void)
{
    failing_allocation = number_of("FAIL_ALLOCATION");
    failing_thread = number_of("FAIL_THREAD");
    failing_file = number_of("FAIL_FILE");
    failing_write = number_of("FAIL_WRITE");
    own_signal = number_of("FAIL_SIGNAL");
    if (number_of("FAIL_ALONE"))
        unsetenv("LD_PRELOAD");
    is_counting = true;
}

__attribute__((destructor)) static void end(void)
{
    const char *path = getenv("FAIL_COUNT");
    const long n[] = {n_allocations, n_threads, n_files, n_writes};
    is_counting = false;
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file)
        return;
    fprintf(file, "%ld %ld %ld %ld\n", n[0], n[1], n[2], n[3]);
    fclose(file);
}

/* For a program that preloads this: from now on the k-th allocation fails; 0: none.
 */
void fail_allocation_from_now(long k);
long allocations_since(void);

void fail_allocation_from_now(long k)
{
    n_allocations = 0;
    failing_allocation = k;
}

long allocations_since(void)
{
    return n_allocations;
}

/* Counts a call; says whether it fails. */
static bool strikes(atomic_long *n_calls, long failing, int number)
{
    if (!is_counting || ++*n_calls != failing)
        return false;
    if (own_signal)
        raise((int)own_signal);
    else
        errno = number;
    return !own_signal;
}

static bool fails(void)
{
    return strikes(&n_allocations, failing_allocation, ENOMEM);
}

static bool fails_file(int number)
{
    return strikes(&n_files, failing_file, number);
}

static bool fails_write(void)
{
    return strikes(&n_writes, failing_write, ENOSPC);
}

void *malloc(size_t n)
{
    return fails() ? NULL : __libc_malloc(n);
}

void *calloc(size_t n, size_t size)
{
    return fails() ? NULL : __libc_calloc(n, size);
}

void *realloc(void *memory, size_t n)
{
    return fails() ? NULL : __libc_realloc(memory, n);
}

void *aligned_alloc(size_t alignment, size_t n)
{
    return fails() ? NULL : __libc_memalign(alignment, n);
}

int posix_memalign(void **memory, size_t alignment, size_t n)
{
    void *made = fails() ? NULL : __libc_memalign(alignment, n);
    if (!made)
        return ENOMEM;
    *memory = made;
    return 0;
}

struct start {
    void *(*function)(void *);
    void *user;
};

static atomic_long n_running;

static void *run(void *memory)
{
    struct start start = *(struct start *)memory;
    free(memory);
    void *result = start.function(start.user);
    n_running--;
    return result;
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes,
                   void *(*function)(void *), void *user)
{
    static int (*real)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    if (!real)
        *(void **)&real = dlsym(RTLD_NEXT, "pthread_create");
    n_threads++;
    struct start *start = __libc_malloc(sizeof *start);
    if (!start || (failing_thread && n_running >= failing_thread - 1)) {
        free(start);
        return EAGAIN;
    }
    *start = (struct start){function, user};
    n_running++;
    return real(thread, attributes, run, start);
}

/* ---- files ---------------------------------------------------------------------- */

/* The function of the C library that has the name of the one it stands in. */
#define REAL(type, ...)                                                                \
    static type (*real)(__VA_ARGS__);                                                  \
    if (!real)                                                                         \
    *(void **)&real = dlsym(RTLD_NEXT, __func__)

int open64(const char *path, int flags, ...)
{
    REAL(int, const char *, int, ...);
    va_list rest;
    va_start(rest, flags);
    const int mode = flags & O_CREAT ? va_arg(rest, int) : 0;
    va_end(rest);
    return fails_file(EACCES) ? -1 : real(path, flags, mode);
}

FILE *fopen64(const char *path, const char *mode)
{
    REAL(FILE *, const char *, const char *);
    return fails_file(EACCES) ? NULL : real(path, mode);
}

ssize_t write(int fd, const void *data, size_t n)
{
    REAL(ssize_t, int, const void *, size_t);
    return fails_write() ? -1 : real(fd, data, n);
}

ssize_t pwrite64(int fd, const void *data, size_t n, off64_t at)
{
    REAL(ssize_t, int, const void *, size_t, off64_t);
    return fails_write() ? -1 : real(fd, data, n, at);
}

size_t fwrite(const void *data, size_t size, size_t n, FILE *file)
{
    REAL(size_t, const void *, size_t, size_t, FILE *);
    const bool is_text = file == stdout || file == stderr;
    return !is_text && fails_write() ? 0 : real(data, size, n, file);
}

int fsync(int fd)
{
    REAL(int, int);
    return fails_file(EIO) ? -1 : real(fd);
}

int flock(int fd, int operation)
{
    REAL(int, int, int);
    return fails_file(ENOLCK) ? -1 : real(fd, operation);
}

int rename(const char *old, const char *new)
{
    REAL(int, const char *, const char *);
    return fails_file(EACCES) ? -1 : real(old, new);
}

int unlink(const char *path)
{
    REAL(int, const char *);
    if (own_signal)
        fails_file(0);
    return real(path);
}
