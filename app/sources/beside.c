/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/beside.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

const char *beside_view(const struct source *source)
{
    return source->layer.r < 0 ? NULL : image_view_of(source->colour, source->layer.r);
}

bool beside_is_of_view(const struct source *source, int channel)
{
    const char *view = beside_view(source),
               *own = image_view_of(source->colour, channel);
    return !view || (own && strcmp(own, view) == 0);
}

void beside_drop_view(const char *name, const char *view, char *out, size_t n_bytes)
{
    const size_t n = strlen(view);
    const char *at = name;
    while (at && !(strncmp(at, view, n) == 0 && at[n] == '.')) {
        at = strchr(at, '.');
        at = at ? at + 1 : NULL;
    }
    if (at)
        snprintf(out, n_bytes, "%.*s%s", (int)(at - name), name, at + n + 1);
    else
        snprintf(out, n_bytes, "%s", name);
}

bool beside_is(const struct source *source, int channel, const char *layer, int base)
{
    int count;
    const char *name = image_channels(source->colour, &count)[channel].name;
    const char *view = beside_view(source), *dot = strrchr(name, '.');
    if (!dot || dot[1] == '\0' || dot[2] != '\0' || !beside_is_of_view(source, channel))
        return false;
    const int c = toupper((unsigned char)dot[1]);
    if (c != "XYZ"[base] && c != "RGB"[base])
        return false;
    const size_t n = strlen(layer), n_view = view ? strlen(view) : 0;
    size_t before = (size_t)(dot - name);
    /* Where views share a part theirs may stand before the letter. */
    if (n_view && before > n_view && name[before - n_view - 1] == '.' &&
        strncmp(name + before - n_view, view, n_view) == 0)
        before -= n_view + 1;
    return before >= n && strncasecmp(name + before - n, layer, n) == 0 &&
           (before == n || name[before - n - 1] == '.');
}

bool beside_has_window(const struct source *source, int channel)
{
    int n;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const struct image_box *box =
        &image_parts(source->colour, &n)[channels[channel].part].data_window;
    return memcmp(box, &source->info.data_window, sizeof(*box)) == 0;
}
