/* SPDX-License-Identifier: Apache-2.0 */
#include "pages/html.h"

#include <stdlib.h>
#include <string.h>

#include "console/cli.h"
#include "path.h"
#include "sources/picture.h"

bool html_check_name(const char *page)
{
    const char *ending = page ? strrchr(page, '.') : ".html";
    if (ending && (!strcmp(ending, ".html") || !strcmp(ending, ".htm")))
        return true;
    message("--html: '%s' does not end in .html", page);
    return false;
}

void html_print(FILE *file, const char *text)
{
    for (; *text; text++)
        if (*text == '<')
            fputs("&lt;", file);
        else if (*text == '&')
            fputs("&amp;", file);
        else if (*text == '"')
            fputs("&quot;", file);
        else
            fputc(*text, file);
}

void html_print_address(FILE *file, const char *name)
{
    for (; *name; name++)
        if (strchr("-_.", *name) || (*name >= '0' && *name <= '9') ||
            (*name >= 'A' && *name <= 'Z') || (*name >= 'a' && *name <= 'z'))
            fputc(*name, file);
        else
            fprintf(file, "%%%02x", (unsigned char)*name);
}

char *html_make_folder(const char *page, const char *ending, struct image_error *error)
{
    const char *name = os_path_name(page), *dot = strrchr(name, '.');
    const size_t n = dot ? (size_t)(dot - page) : strlen(page);
    char *folder = app_memory(n + strlen(ending) + 1, 1, error);
    if (!folder)
        return NULL;
    memcpy(folder, page, n);
    strcpy(folder + n, ending);
    if (picture_need_folder(folder, OS_FOLDER_GOES_UNLESS_KEPT, error))
        return folder;
    free(folder);
    return NULL;
}
