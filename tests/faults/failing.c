/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Preloaded into the command: calls fail as a system in need lets them.
 *
 *   FAIL_ALLOCATION=k   malloc, calloc, realloc, aligned_alloc, posix_memalign
 *   FAIL_THREAD=k       pthread_create, where k - 1 run beside the first
 *   FAIL_COUNT=FILE     write the numbers of calls there at the end
 *
 * Calls before main() count too: a program that cannot start is a clean failure.
 */
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);

static atomic_long n_allocations, n_threads;
static long failing_allocation, failing_thread;
static bool is_counting;

__attribute__((constructor)) static void begin(void)
{
    const char *k = getenv("FAIL_ALLOCATION");
    failing_allocation = k ? atol(k) : 0;
    k = getenv("FAIL_THREAD");
    failing_thread = k ? atol(k) : 0;
    is_counting = true;
}

__attribute__((destructor)) static void end(void)
{
    const char *path = getenv("FAIL_COUNT");
    long n = n_allocations;
    is_counting = false;
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file)
        return;
    fprintf(file, "%ld %ld\n", n, (long)n_threads);
    fclose(file);
}

static bool fails(void)
{
    if (!is_counting || ++n_allocations != failing_allocation)
        return false;
    errno = ENOMEM;
    return true;
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
