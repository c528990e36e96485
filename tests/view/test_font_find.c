/* SPDX-License-Identifier: Apache-2.0 */
/* The font of the controls, with fontconfig and (built without it) by usual names. */
#include "controls/font_find.h"
#include "file.h"
#include "testing.h"

static void a_font_is_found(void)
{
    char path[4096];
    REQUIRE(font_find(path, sizeof(path)));
    CHECK(os_file_facts(path).kind == OS_FILE_REGULAR);
    CHECK(strstr(path, "DejaVuSans.ttf") != NULL); /* the tests' package has it */
}

static void a_name_that_does_not_fit_is_none(void)
{
    char path[8];
    CHECK(!font_find(path, sizeof(path)));
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_font_is_found);
    TEST(a_name_that_does_not_fit_is_none);
    return testing_end();
}
