/* SPDX-License-Identifier: Apache-2.0 */
/* A folder of its own for each test program of exr/, and samples to write. */
#ifndef RF_EXR_TESTING_H
#define RF_EXR_TESTING_H

#include "../testing.h"

#include <dirent.h>
#include <stdlib.h>

static char folder[] = "/tmp/rf_test_exr_XXXXXX";

static inline const char *in_folder(const char *name)
{
    static char paths[4][200];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static inline int count_files(const char *path)
{
    DIR *stream = opendir(path);
    int n = 0;
    for (struct dirent *entry; stream && (entry = readdir(stream));)
        n += entry->d_name[0] != '.';
    if (stream)
        closedir(stream);
    return n;
}

static inline void fill(float *samples, size_t n)
{
    for (size_t i = 0; i < n; i++)
        samples[i] = (float)(i % 251) / 64.0f;
}
static inline bool make_folder(void)
{
    return mkdtemp(folder) != NULL;
}

static inline void remove_folder(void)
{
    char command[100];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    if (system(command) != 0)
        printf("# %s stays\n", folder);
}

#endif
