/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pvengine64.exe for tests under wine: hands its arguments to the script povray.sh
 * beside it, which starts this machine's POV-Ray, and ends as that does. What wine starts
 * outside itself gives no handle to wait for: the script leaves a file.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

static int wait_for(const char *path)
{
    int code = 255;
    for (;; Sleep(20)) {
        FILE *file = fopen(path, "r");
        if (file && fscanf(file, "%d", &code) == 1) {
            fclose(file);
            DeleteFileA(path);
            return code;
        }
        if (file)
            fclose(file);
    }
}

/* The script, as this machine names it: the drive Z: is its root. */
static void find_script(char *path, size_t n_bytes)
{
    char own[MAX_PATH];
    GetModuleFileNameA(NULL, own, sizeof own);
    for (char *c = own; *c; c++)
        if (*c == '\\')
            *c = '/';
    *strrchr(own, '/') = 0;
    snprintf(path, n_bytes, "%s/povray.sh", own + strlen("Z:"));
}

int main(int argc, char **argv)
{
    static char line[32768], script[MAX_PATH], done[2 * MAX_PATH];
    STARTUPINFOA start = {.cb = sizeof(start)};
    PROCESS_INFORMATION process;
    find_script(script, sizeof script);
    snprintf(done, sizeof done, "%s-%lu", script, GetCurrentProcessId());
    snprintf(line, sizeof line, "sh \"%s\" \"%s\"", script, done);
    for (int i = 1; i < argc; i++) {
        strcat(line, " \"");
        char *end = line + strlen(line);
        for (const char *c = argv[i]; *c; *end++ = *c++)
            if (*c == '"')
                *end++ = '\\';
        strcpy(end, "\"");
    }
    if (!CreateProcessA("Z:\\bin\\sh", line, NULL, NULL, TRUE, 0, NULL, NULL, &start,
                        &process))
        return 254;
    return wait_for(done);
}
