/* SPDX-License-Identifier: Apache-2.0 */
#include "commands/farm_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "common/text_file.h"
#include "rackfocus/rackfocus.h"

/* ---- shell ---------------------------------------------------------------------- */

static void print_list(FILE *file, const char *name, char *const *items, int n)
{
    fprintf(file, "%s() {\n    cat <<'END'\n", name);
    for (int i = 0; i < n; i++)
        fprintf(file, "%s\n", items[i]);
    fprintf(file, "END\n}\n");
}

static void print_chunks(FILE *file, const struct farm_job *job)
{
    print_list(file, "list_chunks", job->chunks, job->n_chunks);
    if (job->n_views > 0)
        print_list(file, "list_views", job->views, job->n_views);
}

/* The functions that make a chunk, whose list is $1, and check all frames. */
static void print_functions(FILE *file, const struct farm_job *job)
{
    char added[80], *frames = app_memory(strlen(job->frames) + 10, 1, NULL);
    const bool has_threads = command_line_value(&job->line, "threads") != NULL;
    fprintf(file, "cd ");
    command_line_print_word(file, job->folder);
    fprintf(file, " || exit 1\nprogram=");
    command_line_print_word(file, job->program);
    snprintf(added, sizeof(added), "--frames \"$1\"%s",
             has_threads ? "" : " -j \"$threads\"");
    fprintf(file, "\nmake_frames() {\n    exec \"$program\"");
    command_line_print(file, &job->line, "frames", added);
    if (job->n_views > 0) {
        fprintf(file, "\n}\nmake_views() {\n    exec \"$program\"");
        snprintf(added, sizeof(added), "--frames \"$1\" --only-views \"$2\"%s",
                 has_threads ? "" : " -j \"$threads\"");
        command_line_print(file, &job->line, "frames", added);
    }
    fprintf(file, "\n}\ncheck_frames() {\n    exec \"$program\" frames");
    if (job->html) {
        fprintf(file, " --html ");
        command_line_print_word(file, job->html);
    }
    fprintf(file, " --");
    if (frames)
        sprintf(frames, "--frames %s", job->frames);
    command_line_print(file, &job->line, "frames", frames);
    fprintf(file, "\n}\n");
    free(frames);
}

static void print_head(FILE *file, const struct farm_job *job)
{
    /* The name may hold anything but an end of line, which would end the comment. */
    fprintf(file, "# Frames of ");
    for (const char *at = job->name; *at; at++)
        fputc(*at == '\n' || *at == '\r' ? ' ' : *at, file);
    fprintf(file, ", by rackfocus %s. Again: makes what is not finished.\n",
            rf_version());
}

/* Hands over the array of the views, where there is one, that of the frames after it, and
 * the check after that, each whatever became of the one before. */
static void print_sbatch(FILE *file, const struct farm_job *job)
{
    const int n_threads = (int)job->n_threads > 0 ? (int)job->n_threads : 1;
    if (job->n_views > 0)
        fprintf(file,
                "views=$(sbatch --parsable --array=1-%d --cpus-per-task=%d \\\n"
                "    --output=\"$logs/%%A_%%a_views.log\" \"$@\" \"$self\" views) "
                "|| exit\n"
                "echo \"views: job ${views%%%%;*}, %d tasks\"\n",
                job->n_chunks * job->n_views, n_threads, job->n_chunks * job->n_views);
    fprintf(file,
            "id=$(sbatch --parsable --array=1-%d --cpus-per-task=%d%s \\\n"
            "    --output=\"$logs/%%A_%%a.log\" \"$@\" \"$self\" frames) || exit\n"
            "id=${id%%%%;*}\n"
            "check=$(sbatch --parsable --dependency=\"afterany:$id\" \\\n"
            "    --output=\"$logs/%%j_check.log\" \"$@\" \"$self\" check) || exit\n"
            "echo \"frames: job $id, %d tasks; check: job ${check%%%%;*}; "
            "logs: $self.logs\"\n",
            job->n_chunks, n_threads,
            job->n_views > 0 ? " --dependency=\"afterany:${views%%;*}\"" : "",
            job->n_chunks);
}

static void print_slurm(FILE *file, const void *data)
{
    const struct farm_job *job = data;
    fprintf(file, "#!/bin/sh\n#SBATCH --job-name=rackfocus\n#SBATCH --requeue\n"
                  "#SBATCH --open-mode=append\n");
    print_head(file, job);
    fprintf(file,
            "#   sh FILE [options of sbatch, for both steps]\n"
            "threads=${SLURM_CPUS_PER_TASK:-%d}\n",
            (int)job->n_threads);
    fprintf(file, "self=$(CDPATH= cd -- \"$(dirname -- \"$0\")\" && pwd)/"
                  "$(basename -- \"$0\")\n");
    print_functions(file, job);
    print_chunks(file, job);
    fputs("case ${SLURM_JOB_ID:+${1-}} in\n", file);
    if (job->n_views > 0)
        fprintf(file,
                "views) i=$((SLURM_ARRAY_TASK_ID - 1))\n"
                "    make_views \"$(list_chunks | sed -n \"$((i / %d + 1))p\")\" \\\n"
                "        \"$(list_views | sed -n \"$((i %% %d + 1))p\")\" ;;\n",
                job->n_views, job->n_views);
    fputs("frames) make_frames \"$(list_chunks | sed -n "
          "\"${SLURM_ARRAY_TASK_ID}p\")\" ;;\n"
          "check) check_frames ;;\n"
          "esac\n"
          "command -v sbatch >/dev/null || {\n"
          "    echo \"rackfocus: sbatch: not found; submit where Slurm is: sh "
          "$self\" >&2\n"
          "    exit 1\n}\n"
          "mkdir -p \"$self.logs\" || exit 1\n"
          "logs=$(printf %s \"$self.logs\" | sed 's/%/%%/g') # of sbatch's patterns\n",
          file);
    print_sbatch(file, job);
}

/* Views and then frames, each with as many workers, by what there is. */
static void print_script_steps(FILE *file, const struct farm_job *job)
{
    const bool has_views = job->n_views > 0;
    if (has_views)
        fputs("list_tasks() {\n"
              "    for chunk in $(list_chunks); do\n"
              "        for views in $(list_views); do echo \"$chunk $views\"; done\n"
              "    done\n"
              "}\n",
              file);
    fputs("if parallel --version 2>/dev/null | grep -q GNU; then\n", file);
    if (has_views)
        fputs("    list_tasks | parallel -q --will-cite --colsep ' ' -j \"$workers\" "
              "sh \"$self\" views {1} {2}\n",
              file);
    fputs("    list_chunks | parallel -q --will-cite -j \"$workers\" sh \"$self\" "
          "frames {}\n"
          "else\n",
          file);
    if (has_views)
        fputs("    list_tasks | xargs -n 2 -P \"$workers\" sh \"$self\" views\n", file);
    fputs("    list_chunks | xargs -n 1 -P \"$workers\" sh \"$self\" frames\n"
          "fi\n"
          "check_frames\n",
          file);
}

static void print_script(FILE *file, const void *data)
{
    const struct farm_job *job = data;
    fprintf(file, "#!/bin/sh\n");
    print_head(file, job);
    fprintf(file,
            "#   sh FILE [WORKERS]\n"
            "threads=%d\n"
            "self=$(CDPATH= cd -- \"$(dirname -- \"$0\")\" && pwd)/"
            "$(basename -- \"$0\")\n",
            (int)job->n_threads);
    print_functions(file, job);
    print_chunks(file, job);
    fprintf(file,
            "case ${1-} in\n"
            "%s"
            "frames) make_frames \"$2\" ;;\n"
            "check) check_frames ;;\n"
            "esac\n"
            "processors=$(getconf _NPROCESSORS_ONLN)\n"
            "workers=${1:-$((threads > 0 ? (processors + threads - 1) / threads : "
            "1))}\n",
            job->n_views > 0 ? "views) make_views \"$2\" \"$3\" ;;\n" : "");
    print_script_steps(file, job);
}

/* ---- Open Job Description ------------------------------------------------------- */

/* Counts the frames that a task says it has done with, and tells why it failed. Values
 * come as words: in the text of the script a shell would read them again. */
static const char openjd_frames[] =
    "cd \"$1\" || exit 1\n"
    "program=$2 frames=$3 n=0 done=0 failed= status=1\n"
    "shift 3\n"
    "for range in ${frames//,/ }; do\n"
    "    n=$((n + ${range#*-} - ${range%-*} + 1))\n"
    "done\n"
    "while IFS= read -r line; do\n"
    "    case $line in\n"
    "    'exit status '*) status=${line#exit status }; continue ;;\n"
    "    'frame '* | 'rackfocus: frame '*)\n"
    "        done=$((done + 1))\n"
    "        echo \"openjd_progress: $((done < n ? 100 * done / n : 100))\" ;;\n"
    "    'rackfocus: '*) failed=${line#rackfocus: } ;;\n"
    "    esac\n"
    "    printf '%s\\n' \"$line\"\n"
    "done < <(\"$program\" \"$@\" 2>&1; echo \"exit status $?\")\n"
    "[ \"$status\" = 0 ] || echo \"openjd_fail: frames $frames: $failed\"\n"
    "exit \"$status\"\n";

static const char openjd_check[] =
    "cd \"$1\" || exit 1\n"
    "program=$2\n"
    "shift 2\n"
    "\"$program\" \"$@\" && exit\n"
    "status=$?\n"
    "echo 'openjd_fail: frames are not finished; submit the job again'\n"
    "exit \"$status\"\n";

static void print_text(FILE *file, const char *text)
{
    fputc('"', file);
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            fprintf(file, "\\%c", c);
        else if (c == '\n')
            fputs("\\n", file);
        else if (c < 0x20)
            fprintf(file, "\\u%04x", c);
        else
            fputc(c, file);
    }
    fputc('"', file);
}

static void print_member(FILE *file, const char *before, const char *text)
{
    fputs(before, file);
    print_text(file, text);
}

/* The words of the line, with "--frames" and a list before "--", and which views alone
 * where that is not NULL. */
static void print_args(FILE *file, const struct farm_job *job, char *const *words,
                       const int n[2], const char *frames, const char *views)
{
    for (int i = 0; i < n[0]; i++)
        print_member(file, ",\n            ", words[i]);
    print_member(file, ",\n            \"--frames\", ", frames);
    if (views)
        print_member(file, ", \"--only-views\", ", views);
    if (!command_line_value(&job->line, "threads"))
        fputs(", \"-j\", \"{{Param.Threads}}\"", file);
    for (int i = n[0]; i < n[1]; i++)
        print_member(file, ",\n            ", words[i]);
}

static void print_script_of_step(FILE *file, const char *script)
{
    print_member(file,
                 "      \"script\": {\n        \"embeddedFiles\": [{\"name\": \"Run\", "
                 "\"type\": \"TEXT\",\n          \"data\": ",
                 script);
    fputs("}],\n        \"actions\": {\"onRun\": {\"command\": \"bash\", \"args\": [\n"
          "            \"{{Task.File.Run}}\", \"{{Param.Folder}}\", "
          "\"{{Param.Program}}\"",
          file);
}

static void print_openjd_head(FILE *file, const struct farm_job *job)
{
    char name[64]; /* the specification allows 128 characters */
    snprintf(name, sizeof(name), "rackfocus %.50s", job->name);
    print_member(
        file,
        "{\n  \"specificationVersion\": \"jobtemplate-2023-09\",\n  \"name\": ", name);
    print_member(file,
                 ",\n  \"parameterDefinitions\": [\n"
                 "    {\"name\": \"Program\", \"type\": \"STRING\", \"description\": "
                 "\"rackfocus on the worker\",\n     \"default\": ",
                 job->program);
    print_member(
        file,
        "},\n    {\"name\": \"Folder\", \"type\": \"STRING\", \"description\": "
        "\"from where names of files are seen\",\n     \"default\": ",
        job->folder);
    fprintf(file,
            "},\n    {\"name\": \"Threads\", \"type\": \"INT\", \"minValue\": 0, "
            "\"description\": \"of a task; 0: one per processor\", \"default\": %d}\n"
            "  ],\n  \"steps\": [\n",
            (int)job->n_threads);
}

static void print_range(FILE *file, const char *name, char *const *items, int n)
{
    fprintf(file, "{\"name\": \"%s\", \"type\": \"STRING\",\n        \"range\": [",
            name);
    for (int i = 0; i < n; i++)
        print_member(file, i > 0 ? ", " : "", items[i]);
    fputs("]}", file);
}

/* The step that makes the frames or, before it, the one that renders their views. */
static void print_step(FILE *file, const struct farm_job *job, char *const *words,
                       const int n[2], bool is_of_views)
{
    fprintf(file,
            "    {\n      \"name\": \"%s\",\n%s"
            "      \"parameterSpace\": {\"taskParameterDefinitions\": [",
            is_of_views ? "Views" : "Frames",
            job->n_views > 0 && !is_of_views
                ? "      \"dependencies\": [{\"dependsOn\": \"Views\"}],\n"
                : "");
    print_range(file, "Frames", job->chunks, job->n_chunks);
    if (is_of_views) {
        fputs(", ", file);
        print_range(file, "Views", job->views, job->n_views);
    }
    fputs("]},\n", file);
    print_script_of_step(file, openjd_frames);
    fputs(", \"{{Task.Param.Frames}}\"", file);
    print_args(file, job, words, n, "{{Task.Param.Frames}}",
               is_of_views ? "{{Task.Param.Views}}" : NULL);
    fputs("]}}}\n    },\n", file);
}

static void print_openjd(FILE *file, const void *data)
{
    const struct farm_job *job = data;
    int n[2];
    char **words = app_memory((size_t)job->line.argc, sizeof(*words), NULL);
    if (!words)
        return;
    n[1] = command_line_words(&job->line, "frames", words, &n[0]);
    print_openjd_head(file, job);
    if (job->n_views > 0)
        print_step(file, job, words, n, true);
    print_step(file, job, words, n, false);
    fputs("    {\n      \"name\": \"Check\",\n"
          "      \"dependencies\": [{\"dependsOn\": \"Frames\"}],\n",
          file);
    print_script_of_step(file, openjd_check);
    fputs(", \"frames\"", file);
    if (job->html)
        print_member(file, ", \"--html\", ", job->html);
    fputs(", \"--\"", file);
    print_args(file, job, words, n, job->frames, NULL);
    fputs("]}}}\n    }\n  ]\n}\n", file);
    free(words);
}

/* ---- the file ------------------------------------------------------------------- */

bool farm_job_write(const struct farm_job *job, enum farm_kind kind, const char *path,
                    struct image_error *error)
{
    static const text_print_fn printers[FARM_N_KINDS] = {print_slurm, print_openjd,
                                                         print_script};
    return text_file_write(path, printers[kind], job, error);
}
