/* SPDX-License-Identifier: Apache-2.0 */
#include "run.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "clean_up.h"
#include "ini.h"
#include "text.h"

double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- an end in the middle ------------------------------------------------------- */

/*
 * exit() where memory lacks leaves nothing either: POV-Ray's processes end and its
 * folders go. All of this is one thread's.
 */
enum { MOST_FOLDERS = 4, MOST_CHILDREN = 64 };

static char open_folders[MOST_FOLDERS][256];
static int locks[MOST_FOLDERS]; /* a descriptor and 1; 0: none */
static pid_t children[MOST_CHILDREN];

static void remember_child(pid_t pid)
{
    int i = 0;
    while (i < MOST_CHILDREN - 1 && children[i])
        i++;
    children[i] = pid;
}

static void forget_child(pid_t pid)
{
    for (int i = 0; i < MOST_CHILDREN; i++)
        if (children[i] == pid)
            children[i] = 0;
}

static void remove_tree(const char *folder);

static void clean_up(void)
{
    for (int i = 0; i < MOST_CHILDREN; i++)
        if (children[i] > 0) {
            kill(-children[i], SIGKILL);
            kill(children[i], SIGKILL);
            waitpid(children[i], NULL, 0);
        }
    for (int i = 0; i < MOST_FOLDERS; i++)
        if (open_folders[i][0])
            remove_tree(open_folders[i]);
}

static void remember_folder(const char *folder, int lock)
{
    static bool is_registered;
    if (!is_registered)
        is_registered = os_clean_up_also(clean_up) == 0;
    for (int i = 0; i < MOST_FOLDERS; i++)
        if (!open_folders[i][0]) {
            snprintf(open_folders[i], sizeof open_folders[i], "%s/", folder);
            locks[i] = lock + 1;
            return;
        }
}

static void forget_folder(const char *folder)
{
    for (int i = 0; i < MOST_FOLDERS; i++)
        if (strcmp(open_folders[i], folder) == 0) {
            open_folders[i][0] = 0;
            if (locks[i] > 0)
                close(locks[i] - 1);
            locks[i] = 0;
        }
}

/* ---- folders ------------------------------------------------------------------- */

/* POV-Ray may write to /tmp by default, and the name must fit into its strings. */
static bool is_good_folder(const char *folder)
{
    return folder && folder[0] == '/' && strlen(folder) < 200 &&
           !strpbrk(folder, "\"'\\ ;") && access(folder, W_OK | X_OK) == 0;
}

#define FOLDER_PREFIX "rackfocus-"
#define LOCK_NAME "alive"

/* A lock that the system takes from a process that is killed. It stays open. */
static int lock_folder(const char *folder)
{
    char *path = text_format("%s/" LOCK_NAME, folder);
    int file = open(path, O_CREAT | O_RDWR | O_CLOEXEC, 0600);
    free(path);
    if (file >= 0)
        flock(file, LOCK_EX | LOCK_NB);
    return file;
}

/* Is it one of ours whose process is no more? One without a lock is being made, or is
 * of an older version. */
static bool is_abandoned(const char *folder)
{
    char *path = text_format("%s/" LOCK_NAME, folder);
    struct stat info;
    int file =
        lstat(folder, &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == geteuid()
            ? open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW)
            : -1;
    free(path);
    bool is_free = file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0;
    if (file >= 0)
        close(file);
    return is_free;
}

static void remove_abandoned(const char *base)
{
    DIR *folder = opendir(base);
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        char *path = text_format("%s/%s", base, entry->d_name);
        if (strncmp(entry->d_name, FOLDER_PREFIX, sizeof FOLDER_PREFIX - 1) == 0 &&
            is_abandoned(path))
            remove_tree(path);
        free(path);
    }
    if (folder)
        closedir(folder);
}

char *temp_folder_make(struct povray_error *error)
{
    const char *wanted = getenv("TMPDIR");
    bool is_below_tmp = wanted && strncmp(wanted, "/tmp/", 5) == 0;
    const char *base = is_below_tmp && is_good_folder(wanted) ? wanted : "/tmp";
    char *folder = text_format("%s/" FOLDER_PREFIX "XXXXXX", base);
    remove_abandoned(base);
    if (!mkdtemp(folder)) {
        snprintf(error->message, sizeof error->message, "%s: cannot make a folder: %s",
                 folder, strerror(errno));
        free(folder);
        return NULL;
    }
    remember_folder(folder, lock_folder(folder));
    char *with_slash = text_format("%s/", folder);
    free(folder);
    return with_slash;
}

static int remove_entry(const char *path, const struct stat *info, int kind,
                        struct FTW *at)
{
    remove(path);
    return 0;
}

static void remove_tree(const char *folder)
{
    nftw(folder, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
}

void temp_folder_remove(const char *folder)
{
    remove_tree(folder);
    forget_folder(folder);
}

/* ---- processes ----------------------------------------------------------------- */

struct argument_list {
    char **items;
    int n;
};

static void add_argument(struct argument_list *list, char *argument)
{
    list->items = glue_grow(list->items, (size_t)list->n + 2, sizeof *list->items);
    list->items[list->n++] = argument;
    list->items[list->n] = NULL;
}

/* The options of a text, parted by blanks. */
static void add_words(struct argument_list *list, const char *words)
{
    while (*words) {
        size_t n = strcspn(words, " ");
        if (n > 0)
            add_argument(list, text_format("%.*s", (int)n, words));
        words += n + (words[n] == ' ');
    }
}

/* +L for a folder. POV-Ray has no way to write one with both quotes: a link serves. */
static char *library_option(const char *folder, const char *private_folder)
{
    const char *quote = strchr(folder, '"') ? "'" : "\"";
    char *full = strpbrk(folder, "'") && *quote == '\'' ? realpath(folder, NULL) : NULL;
    char *link = text_format("%sbeside", private_folder);
    const bool is_linked = full && symlink(full, link) == 0;
    char *option = text_format("+L%s%s%s", quote, is_linked ? link : folder, quote);
    free(link);
    free(full);
    return option;
}

/* The user's option where the current folder is another: files are named from the root.
 * Library paths are all given by the sandbox. */
static char *moved_option(const char *option)
{
    const char *header = ini_value(option, "Include_Header", "HI");
    const bool is_file = option[0] != '+' && option[0] != '-' && !strchr(option, '=');
    const char *name = header ? header : is_file ? option : NULL;
    char *file =
        text_format("%.*s", (int)strcspn(name ? name : "", "["), name ? name : "");
    char *full = file[0] ? realpath(file, NULL) : NULL, *moved;
    if (full)
        moved = text_format("%.*s%s%s", (int)(name - option), option, full,
                            name + strlen(file));
    else
        moved = text_format("%s", option);
    free(full);
    free(file);
    return moved;
}

static void add_user_options(struct argument_list *list,
                             const struct run_request *request)
{
    const struct povray_options *options = request->options;
    for (int i = 0; i < options->n_args; i++)
        add_argument(list, request->sandbox ? moved_option(options->args[i])
                                            : text_format("%s", options->args[i]));
}

/* The folders of the scene's files. */
static void add_folders(struct argument_list *list, const struct run *run,
                        const struct run_request *request)
{
    const struct run_sandbox *sandbox = request->sandbox;
    for (int i = 0; sandbox && i < sandbox->n_folders; i++) {
        const char *name = sandbox->folders[i][0] ? sandbox->folders[i] : ".";
        char *full = realpath(name, NULL);
        if (full)
            add_argument(list, library_option(full, run->folder));
        free(full);
    }
    char *folder = path_folder(request->options->scene);
    if (folder[0] && !sandbox)
        add_argument(list, library_option(folder, run->folder));
    free(folder);
}

static void make_arguments(struct argument_list *list, const struct run *run,
                           const struct run_request *request)
{
    const struct povray_options *options = request->options;
    add_argument(list, text_format("povray"));
    add_words(list, request->before);
    if (options->frame >= 0) { /* the user's own +KFI and +KFF win */
        add_argument(list, text_format("+KFI%d", options->first_frame));
        add_argument(list, text_format("+KFF%d", options->last_frame));
    }
    add_user_options(list, request);
    add_folders(list, run, request);
    if (options->frame >= 0) {
        add_argument(list, text_format("+SF%d", options->frame));
        add_argument(list, text_format("+EF%d", options->frame));
    }
    add_words(list, request->after);
    add_argument(list, text_format("+I%s%s", request->temp_folder, request->scene));
    add_argument(list, text_format("+O%so.exr", run->folder));
    add_words(list, "+FE -D -P -C -GA +GDdebug +GFfatal +GWwarning");
}

/* Where POV-Ray works: NULL for the current folder, which its own file may stand in. */
struct place {
    char *folder, *ini;
};

/* In the child: never returns. */
static void execute(char **arguments, const char *log, const struct place *place,
                    int report)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    setpgid(0, 0);
    if (place->ini)
        setenv("POVINI", place->ini, 1);
    if (place->folder && chdir(place->folder) != 0)
        _exit(126);
    int null = open("/dev/null", O_RDONLY), out = open(log, O_CREAT | O_WRONLY, 0600);
    if (null >= 0 && out >= 0) {
        dup2(null, 0);
        dup2(out, 1);
        dup2(out, 2);
        execvp(arguments[0], arguments);
    }
    int code = errno;
    ssize_t n = write(report, &code, sizeof code);
    _exit(n == sizeof code ? 127 : 126);
}

static bool spawn(struct run *run, char **arguments, const struct place *place)
{
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return false;
    char *log = text_format("%slog", run->folder);
    run->started_s = seconds_now();
    run->pid = fork();
    if (run->pid == 0)
        execute(arguments, log, place, ends[1]);
    if (run->pid > 0)
        remember_child(run->pid);
    free(log);
    close(ends[1]);
    int code = 0;
    if (run->pid > 0 && read(ends[0], &code, sizeof code) == sizeof code) {
        waitpid(run->pid, &run->status, 0);
        forget_child(run->pid);
        run->pid = 0;
        errno = code;
    }
    int kept = errno;
    close(ends[0]);
    errno = kept;
    if (run->pid < 0)
        run->pid = 0;
    return run->pid > 0;
}

static bool copy_file(const char *from, const char *to)
{
    struct text text = {0};
    const bool is_copied = text_read_file(&text, from) && text_write_file(&text, to);
    text_free(&text);
    return is_copied;
}

/* The folder that a scene may write to, with the files that it finds there. */
static bool make_sandbox(struct place *place, const struct run *run,
                         const struct run_sandbox *sandbox)
{
    char *ini = ini_standard_file();
    place->folder = text_format("%swork/", run->folder);
    place->ini = ini ? realpath(ini, NULL) : NULL;
    free(ini);
    if (mkdir(place->folder, 0700) != 0)
        return false;
    DIR *copies = opendir(sandbox->copies);
    for (struct dirent *entry; copies && (entry = readdir(copies));) {
        char *from = text_format("%s%s", sandbox->copies, entry->d_name);
        char *to = text_format("%s%s", place->folder, entry->d_name);
        if (path_is_file(from))
            copy_file(from, to);
        free(from);
        free(to);
    }
    if (copies)
        closedir(copies);
    return true;
}

bool run_start(struct run *run, const struct run_request *request,
               struct povray_error *error)
{
    *run = (struct run){.folder =
                            text_format("%s%s/", request->temp_folder, request->name)};
    struct argument_list list = {0};
    struct place place = {0};
    bool is_started = false;
    remove_tree(run->folder); /* of an earlier run of this name */
    errno = 0;
    if (mkdir(run->folder, 0700) == 0 &&
        (!request->sandbox || make_sandbox(&place, run, request->sandbox))) {
        make_arguments(&list, run, request);
        is_started = spawn(run, list.items, &place);
    }
    if (!is_started && errno == ENOENT)
        snprintf(error->message, sizeof error->message,
                 "povray was not found; install POV-Ray 3.7 (Debian: apt-get install "
                 "povray) or put it on the PATH");
    else if (!is_started)
        snprintf(error->message, sizeof error->message, "povray cannot be started: %s",
                 strerror(errno));
    for (int i = 0; i < list.n; i++)
        free(list.items[i]);
    free(list.items);
    free(place.folder);
    free(place.ini);
    return is_started;
}

/* Does the process hold the file open? True where that cannot be told. */
static bool is_open_in(pid_t pid, const char *path)
{
    char *folder_path = text_format("/proc/%d/fd", (int)pid), target[4096];
    DIR *folder = opendir(folder_path);
    free(folder_path);
    bool is_open = !folder;
    for (struct dirent *entry; !is_open && (entry = readdir(folder));) {
        ssize_t n = readlinkat(dirfd(folder), entry->d_name, target, sizeof target - 1);
        is_open =
            n > 0 && (size_t)n == strlen(path) && !memcmp(target, path, (size_t)n);
    }
    if (folder)
        closedir(folder);
    return is_open;
}

/* POV-Ray takes a third of a second to end after its picture is written. */
static bool is_picture_complete(const struct run *run)
{
    struct stat info;
    char *path = run_picture(run);
    bool is_complete = path && stat(path, &info) == 0 && info.st_size > 0 &&
                       !is_open_in(run->pid, path);
    free(path);
    return is_complete;
}

static void kill_run(struct run *run)
{
    kill(-run->pid, SIGKILL);
    kill(run->pid, SIGKILL);
    waitpid(run->pid, &run->status, 0);
    forget_child(run->pid);
    run->pid = 0;
}

bool run_has_ended(struct run *run)
{
    if (run->pid == 0)
        return true;
    if (waitpid(run->pid, &run->status, WNOHANG) != 0) {
        forget_child(run->pid);
        run->pid = 0;
    } else if (is_picture_complete(run)) {
        run->has_picture = true;
        kill_run(run);
    } else {
        return false;
    }
    run->ended_s = seconds_now();
    return true;
}

void run_stop(struct run *run)
{
    if (run->pid > 0)
        kill_run(run);
    free(run->folder);
    *run = (struct run){0};
}

bool run_wait(struct run *const *runs, int n, const struct povray_options *options,
              struct povray_error *error)
{
    for (;;) {
        bool is_busy = false;
        for (int i = 0; i < n; i++)
            is_busy |= !run_has_ended(runs[i]);
        if (options->is_cancelled && options->is_cancelled(options->user)) {
            snprintf(error->message, sizeof error->message, "interrupted");
            error->is_interrupted = true;
            return false;
        }
        if (!is_busy)
            return true;
        if (options->progress)
            options->progress(options->user, run_fraction(runs[0]));
        run_pause();
    }
}

bool run_is_good(const struct run *run)
{
    return run->has_picture ||
           (run->pid == 0 && WIFEXITED(run->status) && WEXITSTATUS(run->status) == 0);
}

static char *read_named(const struct run *run, const char *name)
{
    char *path = text_format("%s%s", run->folder, name);
    struct text text = {0};
    text_read_file(&text, path);
    text_add(&text, "", 0);
    free(path);
    return text.data;
}

char *run_stream(const struct run *run, const char *name)
{
    return read_named(run, name);
}

char *run_picture(const struct run *run)
{
    DIR *folder = opendir(run->folder);
    char *picture = NULL;
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        size_t n = strlen(entry->d_name);
        if (n > 4 && strcmp(entry->d_name + n - 4, ".exr") == 0 && !picture)
            picture = text_format("%s%s", run->folder, entry->d_name);
    }
    if (folder)
        closedir(folder);
    return picture;
}

double run_fraction(const struct run *run)
{
    char *path = text_format("%slog", run->folder), tail[513];
    int file = open(path, O_RDONLY | O_CLOEXEC);
    free(path);
    if (file < 0)
        return 0;
    off_t end = lseek(file, 0, SEEK_END);
    ssize_t n = pread(file, tail, 512, end > 512 ? end - 512 : 0);
    close(file);
    if (n <= 0)
        return 0;
    tail[n] = 0;
    double fraction = 0;
    for (const char *at = tail; (at = strstr(at, " pixels (")); at++)
        fraction = strtod(at + 9, NULL) / 100;
    return fraction;
}

void run_pause(void)
{
    nanosleep(&(struct timespec){0, 5000000}, NULL);
}
