/* SPDX-License-Identifier: Apache-2.0 */
/* How the panel shows each row of params.def. */
#include "model/fields.h"
#include "testing.h"

/* Sliders stay within what may be typed, and the default can be seen on them. */
static void every_parameter_has_a_field(void)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++) {
        struct field field;
        struct ui_number number;
        field_of(&list[i], &field);
        CHECK(field.label[0] != 0);
        if (list[i].type != RF_TYPE_FLOAT && list[i].type != RF_TYPE_INT)
            continue;
        field_number(&list[i], &field, 0.001, &number);
        const bool is_good = number.min < number.max && number.min >= list[i].min &&
                             number.max <= list[i].max &&
                             (!number.is_log || number.min > 0);
        if (!is_good)
            printf("# %s: from %g to %g\n", list[i].key, number.min, number.max);
        CHECK(is_good);
    }
}

static void labels_are_all_different(void)
{
    size_t n;
    struct field a, b;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < i; k++) {
            field_of(&list[i], &a);
            field_of(&list[k], &b);
            CHECK(strcmp(a.label, b.label) != 0);
        }
}

static void units_follow_from_the_table(void)
{
    static const struct {
        const char *key;
        double per_mm;
        bool is_angle, has_infinity;
    } want[] = {{"focal-length", 1, false, false},
                {"focus-distance", 0.001, false, true},
                {"lens-radius", 0.001, false, false},
                {"tilt-x", 0, true, false},
                {"max-radius", 0, false, false}};
    for (size_t i = 0; i < sizeof(want) / sizeof(want[0]); i++) {
        struct field field;
        struct ui_number number;
        const struct rf_param_info *info = rf_param_find(want[i].key);
        field_of(info, &field);
        field_number(info, &field, 0.001, &number);
        CHECK(number.field.per_mm == want[i].per_mm);
        CHECK(number.field.is_angle == want[i].is_angle);
        CHECK(number.has_infinity == want[i].has_infinity);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(every_parameter_has_a_field);
    TEST(labels_are_all_different);
    TEST(units_follow_from_the_table);
    return testing_end();
}
