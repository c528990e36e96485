/* SPDX-License-Identifier: Apache-2.0 */
/* Layers over each other, and two eyes in one picture. */
#include "model/stack.h"
#include "testing.h"

static void layers_lie_over(void)
{
    const float top[3][4] = {{0.5f, 0.25f, 0, 0.5f}, {0, 0, 0, 0}, {1, 2, 3, 1.5f}};
    float rgb[3][3] = {{1, 1, 1}, {0.1f, 0.2f, 0.3f}, {9, 9, 9}}, grey[3] = {1, 2, 3};
    float rgba[3][4] = {{0, 0, 0, 0.5f}, {1, 1, 1, 1}, {0, 0, 0, 0}};
    stack_put_over(top[0], rgb[0], 3, 3);
    CHECK(rgb[0][0] == 1 && rgb[0][1] == 0.75f && rgb[0][2] == 0.5f);
    CHECK(rgb[1][0] == 0.1f && rgb[1][2] == 0.3f);
    CHECK(rgb[2][0] == 1 && rgb[2][2] == 3); /* alpha above 1 counts as 1 */
    stack_put_over(top[0], grey, 3, 1);
    CHECK(grey[0] == 1 && grey[1] == 2 && grey[2] == 1);
    stack_put_over(top[0], rgba[0], 3, 4);
    CHECK(rgba[0][3] == 0.75f && rgba[1][3] == 1);
}

static void eyes_are_joined(void)
{
    const float right[2][4][3] = {{{11, 12, 13}, {13, 14, 15}, {0, 0, 0}, {2, 2, 2}},
                                  {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
    float left[2][4][3], start[2][4][3];
    for (int i = 0; i < 24; i++)
        start[i / 12][i / 3 % 4][i % 3] = (float)(100 + i);
    memcpy(left, start, sizeof(left));
    stack_join_eyes(left[0][0], right[0][0], 4, 2, 3, EYES_LEFT);
    CHECK(memcmp(left, start, sizeof(left)) == 0);
    stack_join_eyes(left[0][0], right[0][0], 4, 2, 3, EYES_ANAGLYPH);
    CHECK(left[0][0][0] == 100 && left[0][0][1] == 12 && left[0][0][2] == 13);
    CHECK(left[1][3][0] == start[1][3][0] && left[1][3][1] == 1);
    memcpy(left, start, sizeof(left));
    stack_join_eyes(left[0][0], right[0][0], 4, 2, 3, EYES_BESIDE);
    CHECK(left[0][0][0] == 101.5f && left[0][1][0] == 107.5f);
    CHECK(left[0][2][0] == 12 && left[0][3][0] == 1 && left[1][2][0] == 1);
    stack_join_eyes(left[0][0], right[0][0], 4, 2, 3, EYES_RIGHT);
    CHECK(memcmp(left, right, sizeof(left)) == 0);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(layers_lie_over);
    TEST(eyes_are_joined);
    return testing_end();
}
