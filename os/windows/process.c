/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A child and all that it starts belong to a job, which Windows ends when its last
 * handle is closed: also when this process dies.
 */
#include "process.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "wide.h"

/* More at once are not known to os_process_end_all(); the system ends those. */
enum { MOST_CHILDREN = 64 };

struct child {
    HANDLE job, process;
};

static SRWLOCK lock = SRWLOCK_INIT;
static struct child *children[MOST_CHILDREN];

static void exchange_child(const struct child *from, struct child *to)
{
    AcquireSRWLockExclusive(&lock);
    int i = 0;
    while (i < MOST_CHILDREN && children[i] != from)
        i++;
    if (i < MOST_CHILDREN)
        children[i] = to;
    ReleaseSRWLockExclusive(&lock);
}

/* ---- the command line ------------------------------------------------------------ */

/* Backslashes at `from`. */
static size_t count_slashes(const char *from)
{
    return strspn(from, "\\");
}

/* One argument as the C library of the other program takes it apart; returns its end. */
static char *quote(char *to, const char *argument)
{
    *to++ = '"';
    while (*argument) {
        const size_t n = count_slashes(argument);
        argument += n;
        /* Before a quote each counts half. */
        const size_t n_written = *argument == '"' || !*argument ? 2 * n : n;
        memset(to, '\\', n_written);
        to += n_written;
        if (*argument == '"')
            *to++ = '\\';
        if (*argument)
            *to++ = *argument++;
    }
    *to++ = '"';
    return to;
}

static wchar_t *command_line_of(char *const *arguments)
{
    size_t n = 1;
    for (int i = 0; arguments[i]; i++)
        n += 2 * strlen(arguments[i]) + 3;
    char *line = malloc(n), *end = line;
    if (!line)
        return NULL;
    for (int i = 0; arguments[i]; i++) {
        if (i > 0)
            *end++ = ' ';
        end = quote(end, arguments[i]);
    }
    *end = 0;
    wchar_t *wide = os_wide_text(line);
    free(line);
    return wide;
}

/* The program's path, from the PATH where the name has no folder; free() it. */
static wchar_t *find_program(const char *name)
{
    wchar_t *wide = os_wide_text(name);
    if (!wide)
        return NULL;
    for (wchar_t *c = wide; *c; c++)
        if (*c == L'/')
            *c = L'\\';
    const DWORD n = SearchPathW(NULL, wide, L".exe", 0, NULL, NULL);
    wchar_t *found = n > 0 ? malloc(((size_t)n + 1) * sizeof(*found)) : NULL;
    if (!found || SearchPathW(NULL, wide, L".exe", n + 1, found, NULL) == 0) {
        free(found);
        found = NULL;
        errno = ENOENT;
    }
    free(wide);
    return found;
}

/* ---- the start ------------------------------------------------------------------- */

/* What CreateProcessW() wants, all to be freed. */
struct start {
    wchar_t *program, *line, *folder;
    HANDLE in, out;
};

static HANDLE inheritable(const char *path, DWORD access, DWORD how)
{
    HANDLE handle = os_handle_open(path, access, OS_SHARE_ALL, how, 0);
    if (handle != INVALID_HANDLE_VALUE)
        SetHandleInformation(handle, HANDLE_FLAG_INHERIT, HANDLE_FLAG_INHERIT);
    return handle;
}

static int prepare(struct start *start, const struct os_process_request *request)
{
    start->in = start->out = INVALID_HANDLE_VALUE;
    start->program = find_program(request->arguments[0]);
    if (!start->program)
        return errno;
    start->line = command_line_of(request->arguments);
    start->folder = request->folder ? os_wide_text(request->folder) : NULL;
    if (!start->line || (request->folder && !start->folder))
        return ENOMEM;
    start->in = inheritable("NUL", GENERIC_READ, OPEN_EXISTING);
    if (start->in == INVALID_HANDLE_VALUE)
        return errno;
    start->out = inheritable(request->log, GENERIC_WRITE, OPEN_ALWAYS);
    return start->out == INVALID_HANDLE_VALUE ? errno : 0;
}

static void release(struct start *start)
{
    free(start->program);
    free(start->line);
    free(start->folder);
    if (start->in != INVALID_HANDLE_VALUE)
        CloseHandle(start->in);
    if (start->out != INVALID_HANDLE_VALUE)
        CloseHandle(start->out);
}

/* A job that ends with its last handle. */
static HANDLE make_job(void)
{
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits = {
        .BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE};
    HANDLE job = CreateJobObjectW(NULL, NULL);
    if (job)
        SetInformationJobObject(job, JobObjectExtendedLimitInformation, &limits,
                                sizeof(limits));
    return job;
}

/* Starts it, halted, so that nothing of it escapes the job. Locked by the caller: the
 * child inherits this process's environment, and `variables` only pass through. */
static int create(const struct start *start, PROCESS_INFORMATION *made)
{
    STARTUPINFOW info = {.cb = sizeof(info),
                         .dwFlags = STARTF_USESTDHANDLES,
                         .hStdInput = start->in,
                         .hStdOutput = start->out,
                         .hStdError = start->out};
    return CreateProcessW(start->program, start->line, NULL, NULL, TRUE,
                          CREATE_SUSPENDED | CREATE_NO_WINDOW |
                              CREATE_NEW_PROCESS_GROUP,
                          NULL, start->folder, &info, made)
               ? 0
               : os_last_error();
}

/* With the first n variables. */
static int create_with(const struct start *start,
                       const struct os_process_variable *variables, int n,
                       PROCESS_INFORMATION *made)
{
    if (n == 0)
        return create(start, made);
    const struct os_process_variable *last = &variables[n - 1];
    if (!last->name)
        return create_with(start, variables, n - 1, made);
    wchar_t *name = os_wide_text(last->name);
    wchar_t *value = os_wide_text(last->value);
    int number = name && value ? 0 : ENOMEM;
    if (number == 0) {
        wchar_t before[4096];
        const DWORD n_before = GetEnvironmentVariableW(name, before, 4096);
        SetEnvironmentVariableW(name, value);
        number = create_with(start, variables, n - 1, made);
        SetEnvironmentVariableW(name, n_before > 0 && n_before < 4096 ? before : NULL);
    }
    free(name);
    free(value);
    return number;
}

static int create_locked(const struct start *start,
                         const struct os_process_request *request,
                         PROCESS_INFORMATION *made)
{
    static SRWLOCK environment = SRWLOCK_INIT;
    AcquireSRWLockExclusive(&environment);
    const int number =
        create_with(start, request->variables, OS_PROCESS_VARIABLES, made);
    ReleaseSRWLockExclusive(&environment);
    return number;
}

int os_process_start(struct os_process *process,
                     const struct os_process_request *request)
{
    struct start start = {0};
    PROCESS_INFORMATION made;
    struct child *child = calloc(1, sizeof(*child));
    *process = (struct os_process){0};
    int number = child ? prepare(&start, request) : ENOMEM;
    if (number == 0)
        number = create_locked(&start, request, &made);
    if (child)
        release(&start);
    if (number != 0) {
        free(child);
        return number;
    }
    *child = (struct child){.job = make_job(), .process = made.hProcess};
    if (child->job)
        AssignProcessToJobObject(child->job, child->process);
    exchange_child(NULL, child);
    ResumeThread(made.hThread);
    CloseHandle(made.hThread);
    process->id = (intptr_t)child;
    return 0;
}

/* ---- the end --------------------------------------------------------------------- */

/* What TerminateProcess() gives; no program of ours returns it. */
static const UINT KILLED = 0xdead;

static bool reap(struct os_process *process, DWORD patience_ms)
{
    struct child *child = (struct child *)process->id;
    DWORD code = 0;
    if (!child)
        return true;
    if (WaitForSingleObject(child->process, patience_ms) == WAIT_TIMEOUT)
        return false;
    GetExitCodeProcess(child->process, &code);
    exchange_child(child, NULL);
    /* Crashes are numbers from 0xc0000000 on. */
    *process = (struct os_process){
        .has_ended = true,
        .exit_code = code == KILLED || code >= 0xc0000000 ? -1 : (int)code};
    CloseHandle(child->process);
    if (child->job)
        CloseHandle(child->job);
    free(child);
    return true;
}

bool os_process_has_ended(struct os_process *process)
{
    return reap(process, 0);
}

void os_process_wait(struct os_process *process)
{
    reap(process, INFINITE);
}

static void kill_child(const struct child *child)
{
    if (child->job)
        TerminateJobObject(child->job, KILLED);
    TerminateProcess(child->process, KILLED);
}

void os_process_end(struct os_process *process)
{
    if (process->id == 0)
        return;
    kill_child((const struct child *)process->id);
    reap(process, INFINITE);
}

void os_process_end_all(void)
{
    AcquireSRWLockExclusive(&lock);
    for (int i = 0; i < MOST_CHILDREN; i++)
        if (children[i]) {
            kill_child(children[i]);
            WaitForSingleObject(children[i]->process, 1000);
            children[i] = NULL;
        }
    ReleaseSRWLockExclusive(&lock);
}

bool os_process_holds(const struct os_process *process, const char *path)
{
    (void)process;
    (void)path;
    return true; /* Windows does not say who has a file open */
}

/* ---- this process ---------------------------------------------------------------- */

int os_process_become(const char *program, char *const *arguments)
{
    wchar_t *path = find_program(program), *line = command_line_of(arguments);
    STARTUPINFOW info = {.cb = sizeof(info)};
    PROCESS_INFORMATION made;
    int number = !path ? ENOENT : !line ? ENOMEM : 0;
    if (number == 0 &&
        !CreateProcessW(path, line, NULL, NULL, TRUE, 0, NULL, NULL, &info, &made))
        number = os_last_error();
    free(path);
    free(line);
    if (number != 0)
        return number;
    /* Windows has no way to become another program: its end is ours. */
    DWORD code = 1;
    WaitForSingleObject(made.hProcess, INFINITE);
    GetExitCodeProcess(made.hProcess, &code);
    ExitProcess(code);
}

void os_process_set_default(const char *variable, const char *value)
{
    if (!getenv(variable))
        _putenv_s(variable, value);
}

static double seconds_of(FILETIME time)
{
    return 1e-7 * (double)((uint64_t)time.dwHighDateTime << 32 | time.dwLowDateTime);
}

double os_process_cpu_s(void)
{
    FILETIME created, ended, system, user;
    if (!GetProcessTimes(GetCurrentProcess(), &created, &ended, &system, &user))
        return 0;
    return seconds_of(system) + seconds_of(user);
}

int64_t os_process_number(void)
{
    return GetCurrentProcessId();
}

bool os_process_exists(int64_t number)
{
    DWORD code = 0;
    HANDLE process =
        OpenProcess(PROCESS_QUERY_LIMITED_INFORMATION, FALSE, (DWORD)number);
    if (!process)
        return GetLastError() == ERROR_ACCESS_DENIED;
    const bool is_running = !GetExitCodeProcess(process, &code) || code == STILL_ACTIVE;
    CloseHandle(process);
    return is_running;
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
    char whole[MAX_COMPUTERNAME_LENGTH + 1] = "";
    DWORD n = sizeof(whole);
    GetComputerNameA(whole, &n);
    const size_t length = strlen(whole) < n_bytes ? strlen(whole) : n_bytes - 1;
    memcpy(name, whole, length);
    name[length] = '\0';
    keep_plain(name);
}
