/* SPDX-License-Identifier: Apache-2.0 */
/* The one file of C++: OpenColorIO has no interface for C. Nothing is thrown out of it. */
#include <OpenColorIO/OpenColorIO.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "pixels/colour.h"
#include "pixels/colour_find.h"

namespace OCIO = OCIO_NAMESPACE;

extern "C" {
#include "parallel.h"
}

struct colour {
    OCIO::ConstConfigRcPtr config;
    OCIO::ConstTransformRcPtr transform;
    OCIO::ConstCPUProcessorRcPtr processor; /* null until colour_prepare() */
};

namespace
{

void add(struct colour_list *list, const std::string &name,
         const OCIO::ConstConfigRcPtr &config,
         const OCIO::ConstTransformRcPtr &transform)
{
    if (list->n == COLOUR_MAX_VIEWS)
        return;
    struct colour *view = new (std::nothrow) colour;
    if (!view)
        return;
    view->config = config;
    view->transform = transform;
    std::snprintf(list->names[list->n], sizeof(list->names[0]), "%s", name.c_str());
    list->views[list->n++] = view;
}

/* All views of the configuration's first display, "NAME view". */
void add_config(struct colour_list *list, const OCIO::ConstConfigRcPtr &config,
                const char *name)
{
    const std::string display = config->getDefaultDisplay();
    for (int i = 0; i < config->getNumViews(display.c_str()); i++) {
        const std::string view = config->getView(display.c_str(), i);
        OCIO::DisplayViewTransformRcPtr transform =
            OCIO::DisplayViewTransform::Create();
        transform->setSrc(OCIO::ROLE_SCENE_LINEAR);
        transform->setDisplay(display.c_str());
        transform->setView(view.c_str());
        add(list, std::string(name) + " " + view, config, transform);
    }
}

/* Rec. 709 to ACES2065-1, its output transform for a dim screen, sRGB's curve. */
void add_aces(struct colour_list *list)
{
    /* ACES TB-2014-004 primaries, Bradford-adapted from D65; rows to AP0. */
    static const double to_ap0[16] = {0.439632981919,
                                      0.382988698152,
                                      0.177378319929,
                                      0,
                                      0.089776442459,
                                      0.813439428749,
                                      0.096784128793,
                                      0,
                                      0.017541170383,
                                      0.111546553302,
                                      0.870912276314,
                                      0,
                                      0,
                                      0,
                                      0,
                                      1};
    OCIO::MatrixTransformRcPtr matrix = OCIO::MatrixTransform::Create();
    matrix->setMatrix(to_ap0);
    OCIO::BuiltinTransformRcPtr output = OCIO::BuiltinTransform::Create();
    output->setStyle("ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0");
    OCIO::BuiltinTransformRcPtr screen = OCIO::BuiltinTransform::Create();
    screen->setStyle("DISPLAY - CIE-XYZ-D65_to_sRGB");
    OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
    group->appendTransform(matrix);
    group->appendTransform(output);
    group->appendTransform(screen);
    add(list, "ACES 1.0 SDR", OCIO::Config::CreateRaw(), group);
}

/* False with a message. */
bool add_file(struct colour_list *list, const char *path, const char *name, char *text,
              size_t n_bytes)
{
    try {
        add_config(list, OCIO::Config::CreateFromFile(path), name);
        return true;
    } catch (const std::exception &e) {
        std::snprintf(text, n_bytes, "%s: OpenColorIO cannot use it: %.300s", path,
                      e.what());
    }
    return false;
}

struct showing {
    const struct colour *colour;
    const float *pixels;
    int n_channels;
    float gain;
    uint8_t *rgba;
};

const int BLOCK = 256;

void show_block(const struct showing *s, int64_t begin, int n)
{
    float block[BLOCK][4];
    const int green = s->n_channels > 1 ? 1 : 0, blue = s->n_channels > 1 ? 2 : 0;
    for (int i = 0; i < n; i++) {
        const float *in = s->pixels + (begin + i) * s->n_channels;
        block[i][0] = s->gain * in[0];
        block[i][1] = s->gain * in[green];
        block[i][2] = s->gain * in[blue];
        block[i][3] = 1;
    }
    OCIO::PackedImageDesc image(block, n, 1, 4);
    s->colour->processor->apply(image);
    for (int i = 0; i < n; i++) {
        uint8_t *out = s->rgba + 4 * (begin + i);
        for (int c = 0; c < 3; c++) {
            const float v = block[i][c];
            out[c] = (uint8_t)(v > 0 ? std::lrintf(255 * std::fmin(v, 1.0f)) : 0);
        }
        out[3] = 255;
    }
}

void show_range(void *data, int64_t begin, int64_t end, int thread)
{
    (void)thread;
    const struct showing *s = (const struct showing *)data;
    for (int64_t at = begin; at < end; at += BLOCK)
        show_block(s, at, (int)(end - at < BLOCK ? end - at : BLOCK));
}

} // namespace

extern "C" bool colour_list_make(struct colour_list *list, const char *config,
                                 char *text, size_t n_bytes)
{
    char path[4096], unused[512];
    const char *variable = std::getenv("OCIO");
    const bool has_variable = variable && *variable;
    bool is_good = true;
    std::memset(list, 0, sizeof(*list));
    std::snprintf(list->names[list->n++], sizeof(list->names[0]), "sRGB");
    OCIO::SetLoggingLevel(OCIO::LOGGING_LEVEL_NONE);
    if (config || has_variable)
        is_good = add_file(list, config ? config : variable, "OCIO", text, n_bytes);
    if (colour_find_blender(path, sizeof(path)))
        add_file(list, path, "Blender", unused, sizeof(unused));
    try {
        add_aces(list);
    } catch (const std::exception &) {
        /* a library older than 2.1 has no such transform */
    }
    return is_good;
}

extern "C" bool colour_prepare(struct colour *colour, char *text, size_t n_bytes)
{
    if (!colour || colour->processor)
        return true;
    try {
        colour->processor =
            colour->config->getProcessor(colour->transform)->getDefaultCPUProcessor();
        return true;
    } catch (const std::exception &e) {
        std::snprintf(text, n_bytes, "OpenColorIO cannot make it: %.300s", e.what());
    }
    return false;
}

extern "C" void colour_list_free(struct colour_list *list)
{
    for (int i = 0; i < list->n; i++)
        delete list->views[i];
    std::memset(list, 0, sizeof(*list));
}

extern "C" void colour_show(const struct colour *colour, const float *pixels,
                            int n_channels, size_t n, double exposure, uint8_t *rgba)
{
    struct showing s = {colour, pixels, n_channels, (float)std::exp2(exposure), rgba};
    os_parallel(0, (int64_t)n, 0, show_range, &s);
}
