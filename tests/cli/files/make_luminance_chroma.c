/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes luminance-chroma.exr with OpenEXR's own writer of such files:
 *
 *     cc make_luminance_chroma.c $(pkg-config --cflags --libs OpenEXR) && ./a.out FILE
 *
 * Pixel (x, y) of 48 x 32 has the colours that colour() gives: smooth, so that chroma
 * at half the size loses little.
 */
#include <ImfCRgbaFile.h>
#include <stdio.h>

enum { WIDTH = 48, HEIGHT = 32 };

static void colour(int x, int y, float rgb[3])
{
    rgb[0] = 0.2f + 0.6f * (float)x / WIDTH;
    rgb[1] = 0.2f + 0.5f * (float)y / HEIGHT;
    rgb[2] = 0.8f - 0.5f * (float)x / WIDTH;
}

int main(int argc, char **argv)
{
    static ImfRgba pixels[WIDTH * HEIGHT];
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        float rgb[3];
        colour(i % WIDTH, i / WIDTH, rgb);
        ImfFloatToHalf(rgb[0], &pixels[i].r);
        ImfFloatToHalf(rgb[1], &pixels[i].g);
        ImfFloatToHalf(rgb[2], &pixels[i].b);
        ImfFloatToHalf(1, &pixels[i].a);
    }
    ImfHeader *header = ImfNewHeader();
    ImfHeaderSetDataWindow(header, 0, 0, WIDTH - 1, HEIGHT - 1);
    ImfHeaderSetDisplayWindow(header, 0, 0, WIDTH - 1, HEIGHT - 1);
    ImfHeaderSetCompression(header, IMF_PIZ_COMPRESSION);
    ImfOutputFile *file =
        argc == 2 ? ImfOpenOutputFile(argv[1], header, IMF_WRITE_YC) : NULL;
    int is_good = file && ImfOutputSetFrameBuffer(file, pixels, 1, WIDTH) &&
                  ImfOutputWritePixels(file, HEIGHT) && ImfCloseOutputFile(file);
    if (!is_good)
        fprintf(stderr, "%s\n", ImfErrorMessage());
    return !is_good;
}
