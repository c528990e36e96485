// SPDX-License-Identifier: Apache-2.0
// Makes deep-rle.exr and deep-zips.exr with OpenEXR's own writer, for OpenImageIO has no
// RLE for deep files: 24 x 16 pixels of 1 to 3 samples.
//
//     c++ make_deep.cpp $(pkg-config --cflags --libs OpenEXR) && ./a.out FOLDER

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfHeader.h>
#include <ImfPartType.h>

#include <string>
#include <vector>

using namespace OPENEXR_IMF_NAMESPACE;

enum { WIDTH = 24, HEIGHT = 16, CHANNELS = 5 };

static void write(const std::string &path, Compression compression)
{
    static const char *const names[CHANNELS] = {"A", "B", "G", "R", "Z"};
    std::vector<unsigned> counts(WIDTH * HEIGHT);
    std::vector<float> values[CHANNELS];
    std::vector<float *> pointers[CHANNELS];
    for (auto &channel : values)
        channel.resize(WIDTH * HEIGHT * 3);
    Header header(WIDTH, HEIGHT);
    header.setType(DEEPSCANLINE);
    header.compression() = compression;
    DeepFrameBuffer frame;
    frame.insertSampleCountSlice(Slice(UINT, (char *)counts.data(), sizeof(unsigned),
                                       sizeof(unsigned) * WIDTH));
    for (int c = 0; c < CHANNELS; c++) {
        header.channels().insert(names[c], Channel(FLOAT));
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            counts[i] = 1 + i / 5 % 3;
            for (unsigned s = 0; s < counts[i]; s++) {
                bool is_last = s + 1 == counts[i];
                float a = is_last ? 1 : 0.25f * (s + 1);
                float value = c == 0 ? a : c == 4 ? 3 + 4 * s : a * 0.2f * c;
                values[c][3 * i + s] = value;
            }
            pointers[c].push_back(&values[c][3 * i]);
        }
        frame.insert(names[c], DeepSlice(FLOAT, (char *)pointers[c].data(),
                                         sizeof(float *), sizeof(float *) * WIDTH,
                                         sizeof(float)));
    }
    DeepScanLineOutputFile file(path.c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(HEIGHT);
}

int main(int argc, char **argv)
{
    std::string folder = argc > 1 ? argv[1] : ".";
    write(folder + "/deep-rle.exr", RLE_COMPRESSION);
    write(folder + "/deep-zips.exr", ZIPS_COMPRESSION);
    return 0;
}
