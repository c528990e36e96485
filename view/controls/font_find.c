/* SPDX-License-Identifier: Apache-2.0 */
#include "controls/font_find.h"

#include <stdio.h>
#include <string.h>

#ifdef HAVE_FONTCONFIG
#include <fontconfig/fontconfig.h>

/* In this order, so that the window looks alike where there are several. */
static const char wanted[] = "DejaVu Sans,Noto Sans,Liberation Sans,Open Sans,Roboto,"
                             "FreeSans,Arial,Helvetica,sans-serif:style=Regular,Book,"
                             "Roman:scalable=true";

bool font_find(char *path, size_t n_bytes)
{
    FcConfig *config = FcInitLoadConfigAndFonts();
    FcPattern *pattern = FcNameParse((const FcChar8 *)wanted);
    FcPattern *match = NULL;
    FcResult result;
    FcChar8 *file = NULL;
    path[0] = 0;
    if (config && pattern) {
        FcConfigSubstitute(config, pattern, FcMatchPattern);
        FcDefaultSubstitute(pattern);
        match = FcFontMatch(config, pattern, &result);
    }
    if (match && FcPatternGetString(match, FC_FILE, 0, &file) == FcResultMatch &&
        strlen((const char *)file) < n_bytes)
        snprintf(path, n_bytes, "%s", (const char *)file);
    if (match)
        FcPatternDestroy(match);
    if (pattern)
        FcPatternDestroy(pattern);
    if (config)
        FcConfigDestroy(config);
    return path[0] != 0;
}

#else
#include "file.h"

bool font_find(char *path, size_t n_bytes)
{
    static const char *const files[] = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
        "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
        "/usr/share/fonts/TTF/DejaVuSans.ttf",
        "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
        "/usr/share/fonts/noto/NotoSans-Regular.ttf",
        "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
        "/System/Library/Fonts/Helvetica.ttc",
        "/Library/Fonts/Arial.ttf",
        "C:/Windows/Fonts/arial.ttf",
    };
    for (size_t i = 0; i < sizeof(files) / sizeof(files[0]); i++)
        if (strlen(files[i]) < n_bytes &&
            os_file_facts(files[i]).kind == OS_FILE_REGULAR) {
            snprintf(path, n_bytes, "%s", files[i]);
            return true;
        }
    return false;
}
#endif
