/* SPDX-License-Identifier: Apache-2.0 */
#include "process.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

/* More at once are not known to os_process_end_all(); the system ends those. */
enum { MOST_CHILDREN = 64 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pid_t children[MOST_CHILDREN];

static void exchange_child(pid_t from, pid_t to)
{
    int i = 0;
    while (i < MOST_CHILDREN && children[i] != from)
        i++;
    if (i < MOST_CHILDREN)
        children[i] = to;
}

static bool set_variables(const struct os_process_request *request)
{
    bool is_set = true;
    for (int i = 0; i < OS_PROCESS_VARIABLES; i++) {
        const struct os_process_variable *variable = &request->variables[i];
        if (variable->name)
            is_set &= setenv(variable->name, variable->value, 1) == 0;
    }
    return is_set;
}

/* In the child: never returns. */
static void execute(const struct os_process_request *request, int report)
{
#ifdef __linux__ /* elsewhere a child outlives a process that is killed */
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    setpgid(0, 0);
    const int null = open("/dev/null", O_RDONLY);
    const int out = open(request->log, O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    if (null >= 0 && out >= 0 && set_variables(request) &&
        (!request->folder || chdir(request->folder) == 0)) {
        dup2(null, 0);
        dup2(out, 1);
        dup2(out, 2);
        execvp(request->arguments[0], request->arguments);
    }
    const int number = errno;
    const ssize_t n = write(report, &number, sizeof number);
    _exit(n == sizeof number ? 127 : 126);
}

static int start(struct os_process *process, const struct os_process_request *request,
                 const int ends[2])
{
    /* Locked, so that os_process_end_all() misses no child. */
    pthread_mutex_lock(&lock);
    const pid_t pid = fork();
    const int forked = pid < 0 ? errno : 0;
    if (pid == 0)
        execute(request, ends[1]);
    if (pid > 0)
        exchange_child(0, pid);
    pthread_mutex_unlock(&lock);
    close(ends[1]);
    if (forked != 0)
        return forked;
    process->id = pid;
    int number = 0;
    if (read(ends[0], &number, sizeof number) == sizeof number)
        os_process_wait(process); /* it found no program */
    return number;
}

int os_process_start(struct os_process *process,
                     const struct os_process_request *request)
{
    int ends[2];
    *process = (struct os_process){0};
    if (pipe(ends) != 0)
        return errno;
    for (int i = 0; i < 2; i++)
        fcntl(ends[i], F_SETFD, FD_CLOEXEC); /* macOS has no pipe2() */
    const int number = start(process, request, ends);
    close(ends[0]);
    return number;
}

/* Waits with these flags; true once the process is no more. */
static bool reap(struct os_process *process, int flags)
{
    int status = 0;
    if (process->id == 0)
        return true;
    const pid_t pid = (pid_t)process->id;
    pid_t found;
    while ((found = waitpid(pid, &status, flags)) < 0 && errno == EINTR)
        ;
    if (found == 0)
        return false;
    pthread_mutex_lock(&lock);
    exchange_child(pid, 0);
    pthread_mutex_unlock(&lock);
    *process = (struct os_process){
        .has_ended = true,
        .exit_code = found > 0 && WIFEXITED(status) ? WEXITSTATUS(status) : -1};
    return true;
}

bool os_process_has_ended(struct os_process *process)
{
    return reap(process, WNOHANG);
}

void os_process_wait(struct os_process *process)
{
    reap(process, 0);
}

static void kill_group(pid_t pid)
{
    kill(-pid, SIGKILL);
    kill(pid, SIGKILL);
}

void os_process_end(struct os_process *process)
{
    if (process->id == 0)
        return;
    kill_group((pid_t)process->id);
    reap(process, 0);
}

void os_process_end_all(void)
{
    pthread_mutex_lock(&lock);
    for (int i = 0; i < MOST_CHILDREN; i++)
        if (children[i] > 0) {
            kill_group(children[i]);
            waitpid(children[i], NULL, 0);
            children[i] = 0;
        }
    pthread_mutex_unlock(&lock);
}

bool os_process_holds(const struct os_process *process, const char *path)
{
    char name[64], target[4096];
    snprintf(name, sizeof name, "/proc/%d/fd", (int)process->id);
    DIR *folder = opendir(name);
    bool is_open = !folder;
    for (struct dirent *entry; !is_open && folder && (entry = readdir(folder));) {
        const ssize_t n =
            readlinkat(dirfd(folder), entry->d_name, target, sizeof target - 1);
        is_open =
            n > 0 && (size_t)n == strlen(path) && memcmp(target, path, (size_t)n) == 0;
    }
    if (folder)
        closedir(folder);
    return is_open;
}

int os_process_become(const char *program, char *const *arguments)
{
    if (strchr(program, '/'))
        execv(program, arguments);
    else
        execvp(program, arguments);
    return errno;
}

double os_process_cpu_s(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

int64_t os_process_number(void)
{
    return getpid();
}

bool os_process_exists(int64_t number)
{
    return number > 0 && (kill((pid_t)number, 0) == 0 || errno == EPERM);
}

/* Other characters do not belong into names of files. */
static void keep_plain(char *name)
{
    for (char *at = name; *at; at++)
        if (!strchr("-_.", *at) && !(*at >= '0' && *at <= '9') &&
            !(*at >= 'a' && *at <= 'z') && !(*at >= 'A' && *at <= 'Z'))
            *at = '_';
}

void os_machine_name(char *name, size_t n_bytes)
{
    if (gethostname(name, n_bytes) != 0 && errno != ENAMETOOLONG)
        name[0] = '\0';
    name[n_bytes - 1] = '\0';
    keep_plain(name);
}
