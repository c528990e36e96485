/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/beside.h"

#include <ctype.h>
#include <stddef.h>
#include <string.h>
#include <strings.h>

bool beside_is(const char *channel, const char *layer, int base)
{
    const char *dot = strrchr(channel, '.');
    if (!dot || dot[1] == '\0' || dot[2] != '\0')
        return false;
    const int c = toupper((unsigned char)dot[1]);
    if (c != "XYZ"[base] && c != "RGB"[base])
        return false;
    const size_t n = strlen(layer), before = (size_t)(dot - channel);
    return before >= n && strncasecmp(dot - n, layer, n) == 0 &&
           (before == n || dot[-(ptrdiff_t)n - 1] == '.');
}

bool beside_has_window(const struct source *source, int channel)
{
    int n;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const struct image_box *box =
        &image_parts(source->colour, &n)[channels[channel].part].data_window;
    return memcmp(box, &source->info.data_window, sizeof(*box)) == 0;
}
