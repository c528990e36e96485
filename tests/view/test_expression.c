/* SPDX-License-Identifier: Apache-2.0 */
/* What may be typed into a number's field. */
#include "model/expression.h"
#include "testing.h"

static const struct expression_field plain = {0};
static const struct expression_field mm = {.per_mm = 1};
static const struct expression_field metres = {.per_mm = 1e-3};

static double read(const char *text, const struct expression_field *field)
{
    double value = -12345;
    char reason[128];
    return expression_read(text, field, &value, reason, sizeof(reason)) ? value : NAN;
}

static bool fails(const char *text, const struct expression_field *field,
                  const char *part)
{
    double value = 7;
    char reason[128];
    const bool is_read = expression_read(text, field, &value, reason, sizeof(reason));
    return !is_read && value == 7 && strstr(reason, part);
}

static void sums_and_products(void)
{
    CHECK(read("2*3", &plain) == 6);
    CHECK(read("1/4", &plain) == 0.25);
    CHECK(read(" 1 + 2 * 3 - 4 / 8", &plain) == 6.5);
    CHECK(read("(1+2)*3", &plain) == 9);
    CHECK(read("-(1+2)", &plain) == -3);
    CHECK(read("8-3-2", &plain) == 3); /* from the left */
    CHECK(read("8/2/2", &plain) == 2);
    CHECK(read("2,5", &plain) == 2.5);
    CHECK(read("1e-3", &plain) == 1e-3);
    CHECK(read("--2", &plain) == 2);
}

static void units_of_length(void)
{
    CHECK(read("85mm", &mm) == 85);
    CHECK(read("8.5 cm", &mm) == 85);
    CHECK_NEAR(read("3 m", &metres), 3, 1e-12);
    CHECK_NEAR(read("3 m + 20 cm", &metres), 3.2, 1e-12);
    CHECK_NEAR(read("(1+2) m", &metres), 3, 1e-12);
    CHECK_NEAR(read("2 ft", &metres), 0.6096, 1e-12);
    CHECK_NEAR(read("1 in", &mm), 25.4, 1e-12);
    CHECK(read("7", &metres) == 7);
    CHECK(fails("3 m", &plain, "no length"));
    CHECK(fails("3 parsec", &mm, "parsec"));
}

static void angles_stops_and_own_units(void)
{
    const struct expression_field angle = {.is_angle = true};
    const struct expression_field stop = {.is_f_stop = true};
    const struct expression_field px = {.own = "px"};
    CHECK(read("90°", &angle) == 90);
    CHECK_NEAR(read("3.14159265358979 rad", &angle), 180, 1e-9);
    CHECK(read("f/2.8", &stop) == 2.8);
    CHECK(read("12 px", &px) == 12);
    CHECK(fails("12 px", &plain, "px"));
    CHECK(fails("90 deg", &mm, "no angle"));
}

static void infinity(void)
{
    CHECK(isinf(read("inf", &plain)) && read("inf", &plain) > 0);
    CHECK(isinf(read("Infinity", &metres)));
    CHECK(isinf(read("∞", &metres)));
    CHECK(fails("inf-inf", &plain, "no value"));
}

static void nonsense_has_a_reason(void)
{
    CHECK(fails("abc", &plain, "abc"));
    CHECK(fails("", &plain, "missing"));
    CHECK(fails("2*", &plain, "missing"));
    CHECK(fails("(2", &plain, ")"));
    CHECK(fails("2)", &plain, "cannot be read"));
    CHECK(fails("1/0", &plain, "zero"));
    CHECK(fails("0x10", &plain, "no number"));
    CHECK(fails("2 3", &plain, "cannot be read"));
    CHECK(fails("nan", &plain, "nan"));
    char deep[200];
    memset(deep, '(', sizeof(deep) - 1);
    deep[sizeof(deep) - 1] = 0;
    CHECK(fails(deep, &plain, "parentheses"));
    char longer[400];
    memset(longer, '1', sizeof(longer) - 1);
    longer[sizeof(longer) - 1] = 0;
    CHECK(fails(longer, &plain, "too long"));
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(sums_and_products);
    TEST(units_of_length);
    TEST(angles_stops_and_own_units);
    TEST(infinity);
    TEST(nonsense_has_a_reason);
    return testing_end();
}
