/* SPDX-License-Identifier: Apache-2.0 */
#include "controls/gl.h"

#include <SDL.h>
#include <SDL_opengl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/report.h"

/* Of frame buffers, which libGL does not export everywhere. */
static struct {
    PFNGLGENFRAMEBUFFERSPROC gen_framebuffers;
    PFNGLDELETEFRAMEBUFFERSPROC delete_framebuffers;
    PFNGLBINDFRAMEBUFFERPROC bind_framebuffer;
    PFNGLFRAMEBUFFERRENDERBUFFERPROC framebuffer_renderbuffer;
    PFNGLCHECKFRAMEBUFFERSTATUSPROC check_framebuffer;
    PFNGLGENRENDERBUFFERSPROC gen_renderbuffers;
    PFNGLDELETERENDERBUFFERSPROC delete_renderbuffers;
    PFNGLBINDRENDERBUFFERPROC bind_renderbuffer;
    PFNGLRENDERBUFFERSTORAGEPROC renderbuffer_storage;
    PFNGLGENERATEMIPMAPPROC generate_mipmap;
} gl;

static int32_t max_side;
static int32_t window_height;

bool gl_load(char *text, size_t n_bytes)
{
    const struct {
        const char *name;
        void *at;
    } names[] = {{"glGenFramebuffers", &gl.gen_framebuffers},
                 {"glDeleteFramebuffers", &gl.delete_framebuffers},
                 {"glBindFramebuffer", &gl.bind_framebuffer},
                 {"glFramebufferRenderbuffer", &gl.framebuffer_renderbuffer},
                 {"glCheckFramebufferStatus", &gl.check_framebuffer},
                 {"glGenRenderbuffers", &gl.gen_renderbuffers},
                 {"glDeleteRenderbuffers", &gl.delete_renderbuffers},
                 {"glBindRenderbuffer", &gl.bind_renderbuffer},
                 {"glRenderbufferStorage", &gl.renderbuffer_storage},
                 {"glGenerateMipmap", &gl.generate_mipmap}};
    const char *version = (const char *)glGetString(GL_VERSION);
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
        void *function = SDL_GL_GetProcAddress(names[i].name);
        SDL_memcpy(names[i].at, &function, sizeof(function));
        if (function)
            continue;
        snprintf(text, n_bytes,
                 "this OpenGL (%s) has no %s; a driver with OpenGL 3.0 or with "
                 "ARB_framebuffer_object is needed, Mesa's software driver is one",
                 version ? version : "unknown version", names[i].name);
        return false;
    }
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_side);
    max_side = max_side < 64 ? 64 : max_side > 4096 ? 4096 : max_side;
    return true;
}

void gl_describe(char *text, size_t n_bytes)
{
    const char *name = (const char *)glGetString(GL_RENDERER);
    snprintf(text, n_bytes, "%s", name ? name : "unknown OpenGL");
}

/* ---- the window ------------------------------------------------------------------ */

static void set_up_plane(int32_t width, int32_t height)
{
    glViewport(0, 0, width, height);
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glOrtho(0, width, height, 0, -1, 1);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
}

void gl_begin(int32_t width, int32_t height)
{
    window_height = height;
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    set_up_plane(width, height);
    glClearColor(0.11f, 0.11f, 0.12f, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}

void gl_clip(int32_t x, int32_t y, int32_t width, int32_t height)
{
    glEnable(GL_SCISSOR_TEST);
    glScissor(x, window_height - y - height, width > 0 ? width : 0,
              height > 0 ? height : 0);
}

void gl_fill(int32_t x, int32_t y, int32_t width, int32_t height, uint32_t rgba)
{
    gl_clip(x, y, width, height);
    glClearColor((float)(rgba >> 24) / 255, (float)(rgba >> 16 & 0xff) / 255,
                 (float)(rgba >> 8 & 0xff) / 255, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}

void gl_read_window(int32_t width, int32_t height, uint8_t *rgb)
{
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, rgb);
}

/* ---- pictures -------------------------------------------------------------------- */

static int count_along(int32_t side, int32_t piece)
{
    return (side + piece - 1) / piece;
}

static int32_t smaller(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static void make_pieces(struct gl_picture *picture, int32_t width, int32_t height)
{
    gl_picture_free(picture);
    picture->width = width;
    picture->height = height;
    picture->piece = max_side;
    picture->n_pieces = count_along(width, max_side) * count_along(height, max_side);
    picture->textures = app_memory((size_t)picture->n_pieces, sizeof(unsigned), NULL);
    if (!picture->textures)
        picture->n_pieces = 0; /* nothing is drawn */
    glGenTextures(picture->n_pieces, picture->textures);
}

void gl_picture_put(struct gl_picture *picture, const uint8_t *rgba, int32_t width,
                    int32_t height)
{
    const bool is_new = picture->width != width || picture->height != height;
    if (is_new)
        make_pieces(picture, width, height);
    const int across = count_along(width, picture->piece);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, width);
    for (int i = 0; i < picture->n_pieces; i++) {
        const int32_t x = i % across * picture->piece, y = i / across * picture->piece;
        const int32_t w = smaller(picture->piece, width - x);
        const int32_t h = smaller(picture->piece, height - y);
        const uint8_t *from = rgba + 4 * ((size_t)y * (size_t)width + (size_t)x);
        glBindTexture(GL_TEXTURE_2D, picture->textures[i]);
        if (is_new)
            glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, w, h, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                         from);
        else
            glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE,
                            from);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

void gl_picture_free(struct gl_picture *picture)
{
    if (picture->n_pieces)
        glDeleteTextures(picture->n_pieces, picture->textures);
    free(picture->textures);
    *picture = (struct gl_picture){0};
}

/* Squares where px are magnified, means where they are made much smaller. */
static void choose_sampling(double scale, bool is_smooth)
{
    const bool is_small = scale < 0.5;
    if (is_small)
        gl.generate_mipmap(GL_TEXTURE_2D);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER,
                    !is_smooth && (scale == floor(scale) || scale > 2) ? GL_NEAREST
                                                                       : GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                    is_small    ? GL_LINEAR_MIPMAP_LINEAR
                    : scale < 1 ? GL_LINEAR
                                : GL_NEAREST);
}

static void draw_textured(double x0, double y0, double x1, double y1)
{
    glBegin(GL_QUADS);
    glTexCoord2f(0, 0);
    glVertex2d(x0, y0);
    glTexCoord2f(1, 0);
    glVertex2d(x1, y0);
    glTexCoord2f(1, 1);
    glVertex2d(x1, y1);
    glTexCoord2f(0, 1);
    glVertex2d(x0, y1);
    glEnd();
}

void gl_picture_draw(const struct gl_picture *picture, double x, double y,
                     double scale_x, double scale_y, bool is_smooth)
{
    const int across =
        picture->n_pieces ? count_along(picture->width, picture->piece) : 1;
    glDisable(GL_BLEND);
    glEnable(GL_TEXTURE_2D);
    glTexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_REPLACE);
    for (int i = 0; i < picture->n_pieces; i++) {
        const int32_t left = i % across * picture->piece;
        const int32_t top = i / across * picture->piece;
        const int32_t right = smaller(left + picture->piece, picture->width);
        const int32_t bottom = smaller(top + picture->piece, picture->height);
        glBindTexture(GL_TEXTURE_2D, picture->textures[i]);
        choose_sampling(scale_y, is_smooth);
        draw_textured(x + left * scale_x, y + top * scale_y, x + right * scale_x,
                      y + bottom * scale_y);
    }
}

/* ---- triangles ------------------------------------------------------------------- */

unsigned gl_make_mask(const uint8_t *coverage, int32_t width, int32_t height)
{
    unsigned texture;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_ALPHA8, width, height, 0, GL_ALPHA,
                 GL_UNSIGNED_BYTE, coverage);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

void gl_draw_quads(const struct gl_vertex *vertices, size_t n, unsigned mask)
{
    if (n == 0)
        return;
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glEnable(GL_TEXTURE_2D);
    glBindTexture(GL_TEXTURE_2D, mask);
    glTexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_MODULATE);
    glEnableClientState(GL_VERTEX_ARRAY);
    glEnableClientState(GL_TEXTURE_COORD_ARRAY);
    glEnableClientState(GL_COLOR_ARRAY);
    glVertexPointer(2, GL_FLOAT, sizeof(*vertices), &vertices->x);
    glTexCoordPointer(2, GL_FLOAT, sizeof(*vertices), &vertices->u);
    glColorPointer(4, GL_UNSIGNED_BYTE, sizeof(*vertices), vertices->rgba);
    glDrawArrays(GL_QUADS, 0, (GLsizei)n);
    glDisableClientState(GL_VERTEX_ARRAY);
    glDisableClientState(GL_TEXTURE_COORD_ARRAY);
    glDisableClientState(GL_COLOR_ARRAY);
    glColor4f(1, 1, 1, 1);
}

/* ---- frame buffers --------------------------------------------------------------- */

bool gl_target_make(struct gl_target *target, int32_t width, int32_t height)
{
    *target = (struct gl_target){.width = width, .height = height};
    gl.gen_framebuffers(1, &target->frame);
    gl.bind_framebuffer(GL_FRAMEBUFFER, target->frame);
    gl.gen_renderbuffers(1, &target->colour);
    gl.bind_renderbuffer(GL_RENDERBUFFER, target->colour);
    gl.renderbuffer_storage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    gl.gen_renderbuffers(1, &target->depth);
    gl.bind_renderbuffer(GL_RENDERBUFFER, target->depth);
    gl.renderbuffer_storage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    gl.framebuffer_renderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                target->colour);
    gl.framebuffer_renderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                                target->depth);
    const bool is_complete =
        gl.check_framebuffer(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    gl.bind_framebuffer(GL_FRAMEBUFFER, 0);
    return is_complete;
}

void gl_target_free(struct gl_target *target)
{
    if (!target->frame)
        return;
    gl.delete_framebuffers(1, &target->frame);
    gl.delete_renderbuffers(1, &target->colour);
    gl.delete_renderbuffers(1, &target->depth);
    *target = (struct gl_target){0};
}

void gl_target_begin(const struct gl_target *target)
{
    gl.bind_framebuffer(GL_FRAMEBUFFER, target->frame);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glViewport(0, 0, target->width, target->height);
}

void gl_target_read(const struct gl_target *target, uint8_t *rgba, float *depth)
{
    gl.bind_framebuffer(GL_FRAMEBUFFER, target->frame);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, target->width, target->height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    if (depth)
        glReadPixels(0, 0, target->width, target->height, GL_DEPTH_COMPONENT, GL_FLOAT,
                     depth);
    gl.bind_framebuffer(GL_FRAMEBUFFER, 0);
}
