/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Child processes. None outlives this one: a child is killed with what it started when
 * os_process_end() or os_clean_up() says so, and by the system when this process dies.
 * A struct belongs to one thread.
 */
#ifndef OS_PROCESS_H
#define OS_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct os_process {
    intptr_t id;    /* 0: not running */
    int exit_code;  /* once ended: what it returned, -1 where it was killed */
    bool has_ended; /* also by os_process_end() */
};

struct os_process_variable {
    const char *name, *value; /* NULL: none */
};

enum { OS_PROCESS_VARIABLES = 2 };

struct os_process_request {
    /* [0] is the program, which is looked for on the PATH; NULL after the last. */
    char *const *arguments;
    const char *log;    /* a file for what it prints; it reads nothing */
    const char *folder; /* where it works; NULL: where this process does */
    /* Of its environment besides ours. */
    struct os_process_variable variables[OS_PROCESS_VARIABLES];
};

/* 0 or errno: ENOENT where there is no such program. */
int os_process_start(struct os_process *process,
                     const struct os_process_request *request);

/* Does not wait. */
bool os_process_has_ended(struct os_process *process);

/* Waits for it. */
void os_process_wait(struct os_process *process);

/* Kills it where it runs, with all that it started. */
void os_process_end(struct os_process *process);

/* Has the running process this file open? True where that cannot be told. */
bool os_process_holds(const struct os_process *process, const char *path);

/* Kills all that run. */
void os_process_end_all(void);

/* In place of this program, the other one with these arguments, up to NULL; a name
 * without a slash is looked for on the PATH. Returns, with errno, only on failure. */
int os_process_become(const char *program, char *const *arguments);

/* The number of this process, which no other on this machine has now. */
int64_t os_process_number(void);

/* Is there a process of this number on this machine, whoever's it is? */
bool os_process_exists(int64_t number);

/* The name of this machine, cut to fit, "" where the system has none: for messages and
 * names of files; letters, digits, '-', '_' and '.' only. */
void os_machine_name(char *name, size_t n_bytes);

/* Processor time of this process and all its threads, seconds. */
double os_process_cpu_s(void);

#endif
