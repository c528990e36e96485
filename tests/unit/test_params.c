/* SPDX-License-Identifier: Apache-2.0 */
/* The table of parameters, row by row, so that a new row is tested without a change. */
#include <locale.h>
#include <stdlib.h>
#include <unistd.h>

#include "rackfocus/rackfocus.h"
#include "testing.h"

static size_t n_rows;
static const struct rf_param_info *rows;

static double member(const struct rf_params *params, const struct rf_param_info *row)
{
    const char *at = (const char *)params + row->offset;
    return row->type == RF_TYPE_FLOAT ? *(const double *)at : *(const int32_t *)at;
}

static void put_member(struct rf_params *params, const struct rf_param_info *row,
                       double value)
{
    char *at = (char *)params + row->offset;
    if (row->type == RF_TYPE_FLOAT)
        *(double *)at = value;
    else
        *(int32_t *)at = (int32_t)value;
}

static void check_row(bool is_good, const struct rf_param_info *row, const char *what)
{
    if (!testing_check(is_good, __FILE__, __LINE__, what))
        printf("#     parameter %s\n", row->key);
}

static void table_is_complete(void)
{
    CHECK(n_rows > 30);
    for (size_t i = 0; i < n_rows; i++) {
        const struct rf_param_info *row = &rows[i];
        size_t n_help = strlen(row->help);
        check_row(n_help > 10 && row->help[n_help - 1] != ' ', row, "has help");
        check_row(!strncmp(row->attribute, "rackfocus:", 10), row, "attribute prefix");
        check_row(row->min <= row->def && row->def <= row->max, row,
                  "default in range");
        check_row(row->min < row->max || row->n_choices == 1, row,
                  "range is not empty");
        check_row((row->type == RF_TYPE_ENUM) == (row->choices != NULL), row,
                  "choices for enum alone");
        check_row(row->group <= RF_GROUP_HIGHLIGHTS, row, "group");
        check_row(strlen(row->field) < sizeof((struct rf_error *)0)->field, row,
                  "field fits rf_error");
        check_row(!strpbrk(row->key, "_ ") && !strpbrk(row->field, "- "), row,
                  "key with dashes, field with underscores");
    }
}

static void names_are_unique(void)
{
    for (size_t i = 0; i < n_rows; i++) {
        for (size_t j = 0; j < i; j++) {
            check_row(strcmp(rows[i].key, rows[j].key) != 0, &rows[i], "key unique");
            check_row(strcmp(rows[i].attribute, rows[j].attribute) != 0, &rows[i],
                      "attribute unique");
            check_row(rows[i].offset != rows[j].offset, &rows[i], "own member");
        }
        for (int a = 0; a < rows[i].n_choices; a++)
            for (int b = 0; b < a; b++)
                check_row(strcmp(rows[i].choices[a].name, rows[i].choices[b].name) != 0,
                          &rows[i], "choice unique");
    }
}

static void found_by_key_and_field(void)
{
    for (size_t i = 0; i < n_rows; i++) {
        check_row(rf_param_find(rows[i].key) == &rows[i], &rows[i], "by key");
        check_row(rf_param_find(rows[i].field) == &rows[i], &rows[i], "by field");
    }
    CHECK(rf_param_find("squeeze") == rf_param_find("pixel-aspect"));
    CHECK(rf_param_find("no-such-thing") == NULL);
    CHECK(rf_param_find("") == NULL);
    CHECK(rf_param_find(NULL) == NULL);
    CHECK(rf_param_find("F-STOP") == NULL);
}

static void init_sets_defaults(void)
{
    struct rf_params params;
    memset(&params, 0xa5, sizeof params);
    rf_params_init(&params);
    CHECK(params.size == sizeof params);
    for (size_t i = 0; i < n_rows; i++)
        check_row(member(&params, &rows[i]) == rows[i].def, &rows[i], "default");
    struct rf_error error;
    CHECK(rf_params_check(&params, &error) == RF_OK);
}

/* A caller built with an older header has a shorter struct: nothing behind it moves. */
static void init_stays_inside_a_shorter_struct(void)
{
    for (size_t n = sizeof(size_t); n <= sizeof(struct rf_params); n += 4) {
        unsigned char memory[sizeof(struct rf_params) + 16]
            __attribute__((aligned(16)));
        memset(memory, 0xa5, sizeof memory);
        rf_params_init_sized((struct rf_params *)memory, n);
        for (size_t i = n; i < sizeof memory; i++)
            REQUIRE(memory[i] == 0xa5);
    }
}

/* As the other functions of parameters, which answer and do not crash. */
static void without_a_struct_nothing_is_set(void)
{
    rf_params_init(NULL);
    struct rf_error error;
    CHECK(rf_params_set(NULL, "f-stop", "1", &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_params_check(NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK(!rf_param_is_read(NULL, "f-stop", NULL));
}

static void check_round_trip(const struct rf_param_info *row, double value)
{
    struct rf_params a, b;
    struct rf_error error;
    char text[64];
    rf_params_init(&a);
    rf_params_init(&b);
    check_row(rf_params_set_number(&a, row->key, value, &error) == RF_OK, row, "set");
    check_row(member(&a, row) == value, row, "the number that was set");
    check_row(rf_params_get(&a, row->field, text, sizeof text) == RF_OK, row, "get");
    check_row(strlen(text) < 32, row, "text is short");
    check_row(rf_params_set(&b, row->key, text, &error) == RF_OK, row, "set text");
    if (member(&b, row) != value)
        printf("# %s: %.17g became \"%s\"\n", row->key, value, text);
    check_row(member(&b, row) == value, row, "the same number back");
    put_member(&b, row, row->def);
    put_member(&a, row, row->def);
    check_row(!memcmp(&a, &b, sizeof a), row, "nothing else was touched");
}

static void every_value_survives_text(void)
{
    for (size_t i = 0; i < n_rows; i++) {
        const struct rf_param_info *row = &rows[i];
        check_round_trip(row, row->min);
        check_round_trip(row, row->max);
        check_round_trip(row, row->def);
        if (row->type == RF_TYPE_FLOAT) {
            check_round_trip(row, row->min + (row->max - row->min) / 3);
            check_round_trip(row, row->def + 1e-9 * (row->max - row->def));
        } else {
            for (double v = row->min; v <= row->max && v < row->min + 20; v++)
                check_round_trip(row, v);
        }
    }
}

static void choices_are_set_by_name(void)
{
    for (size_t i = 0; i < n_rows; i++)
        for (int c = 0; c < rows[i].n_choices; c++) {
            struct rf_params params;
            char text[64];
            rf_params_init(&params);
            const char *name = rows[i].choices[c].name;
            check_row(rf_params_set(&params, rows[i].key, name, NULL) == RF_OK,
                      &rows[i], name);
            check_row(member(&params, &rows[i]) == c, &rows[i], name);
            rf_params_get(&params, rows[i].key, text, sizeof text);
            CHECK_STR(text, name);
        }
}

static void check_rejected(const struct rf_param_info *row, double value)
{
    struct rf_params params, before;
    struct rf_error error = {0};
    rf_params_init(&params);
    before = params;
    check_row(rf_params_set_number(&params, row->key, value, &error) ==
                  RF_ERROR_PARAMETER,
              row, "out of range is rejected");
    check_row(error.code == RF_ERROR_PARAMETER, row, "code in the error");
    check_row(!strcmp(error.field, row->field), row, "the field is named");
    check_row(strstr(error.message, row->key) != NULL, row, "the key is in the text");
    check_row(!memcmp(&params, &before, sizeof params), row, "nothing changed");
    /* The same value written into the struct is found by the check. */
    if (row->type != RF_TYPE_FLOAT && (isnan(value) || value != floor(value)))
        return;
    if (fabs(value) > INT32_MAX && row->type != RF_TYPE_FLOAT)
        return;
    put_member(&params, row, value);
    memset(&error, 0, sizeof error);
    check_row(rf_params_check(&params, &error) == RF_ERROR_PARAMETER, row,
              "check finds it");
    check_row(!strcmp(error.field, row->field), row, "check names the field");
}

static void out_of_range_is_rejected(void)
{
    for (size_t i = 0; i < n_rows; i++) {
        const struct rf_param_info *row = &rows[i];
        bool is_float = row->type == RF_TYPE_FLOAT;
        check_rejected(row, is_float ? nextafter(row->min, -INFINITY) : row->min - 1);
        check_rejected(row, is_float ? nextafter(row->max, INFINITY) : row->max + 1);
        check_rejected(row, NAN);
        check_rejected(row, INFINITY);
        check_rejected(row, -INFINITY);
        if (!is_float)
            check_rejected(row, row->min + 0.5);
    }
}

static void bad_text_is_rejected(void)
{
    static const char *const texts[] = {"",   " ",   "abc",   "1x",  "1,5",
                                        "--", "nan", "1e999", "0x1", "0X1p0"};
    for (size_t i = 0; i < n_rows; i++)
        for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) {
            struct rf_params params, before;
            struct rf_error error = {0};
            rf_params_init(&params);
            before = params;
            if (rf_params_set(&params, rows[i].key, texts[k], &error) == RF_OK)
                printf("# accepted \"%s\"\n", texts[k]);
            check_row(error.code == RF_ERROR_PARAMETER, &rows[i], "bad text");
            check_row(!strcmp(error.field, rows[i].field), &rows[i], "field");
            check_row(!memcmp(&params, &before, sizeof params), &rows[i], "unchanged");
        }
}

static void messages_list_ranges_and_choices(void)
{
    struct rf_params params;
    struct rf_error error;
    rf_params_init(&params);
    rf_params_set(&params, "blades", "17", &error);
    CHECK_CONTAINS(error.message, "17");
    CHECK_CONTAINS(error.message, "0 to 16");
    rf_params_set(&params, "cat-eye", "5", &error);
    CHECK_STR(error.message, "cat-eye is 5; its range is 0 to 4");
    rf_params_set(&params, "optics", "telescope", &error);
    CHECK_CONTAINS(error.message, "telescope");
    for (int i = 0; i < rf_param_find("optics")->n_choices; i++)
        CHECK_CONTAINS(error.message, rf_param_find("optics")->choices[i].name);
    rf_params_set(&params, "depth", "x", &error);
    for (int i = 0; i < rf_param_find("depth")->n_choices; i++)
        CHECK_CONTAINS(error.message, rf_param_find("depth")->choices[i].name);
}

static void unknown_names_are_rejected(void)
{
    struct rf_params params;
    struct rf_error error = {0};
    char text[8] = "";
    rf_params_init(&params);
    CHECK(rf_params_set(&params, "fstop", "1", &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "fstop");
    CHECK_CONTAINS(error.message, "fstop");
    CHECK(rf_params_set_number(&params, "x", 1, &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "x");
    CHECK(rf_params_set(&params, NULL, "1", &error) == RF_ERROR_PARAMETER);
    CHECK(rf_params_get(&params, "x", text, sizeof text) == RF_ERROR_PARAMETER);
    char name[400];
    memset(name, 'n', sizeof name);
    name[sizeof name - 1] = '\0';
    CHECK(rf_params_set(&params, name, "1", &error) == RF_ERROR_PARAMETER);
    CHECK(strlen(error.message) < sizeof error.message);
}

static void get_keeps_to_its_buffer(void)
{
    struct rf_params params;
    rf_params_init(&params);
    for (size_t i = 0; i < n_rows; i++) {
        const char *key = rows[i].key;
        char whole[RF_PARAM_TEXT_BYTES], text[RF_PARAM_TEXT_BYTES + 1];
        put_member(&params, &rows[i], rows[i].max / 3); /* many digits, or a choice */
        check_row(rf_params_get(&params, key, whole, sizeof whole) == RF_OK, &rows[i],
                  "enough");
        const size_t needed = strlen(whole) + 1;
        for (size_t n = 0; n <= needed; n++) {
            memset(text, ',', sizeof text); /* what a comma was looked for in */
            const rf_result result = rf_params_get(&params, key, text, n);
            check_row(result == (n < needed ? RF_ERROR_ARGUMENT : RF_OK), &rows[i],
                      "says whether it fits");
            if (n > 0)
                check_row(!strcmp(text, n < needed ? "" : whole), &rows[i], "whole");
            for (size_t k = n; k < sizeof text; k++)
                check_row(text[k] == ',', &rows[i], "no byte more");
        }
        check_row(rf_params_get(&params, key, NULL, 0) == RF_ERROR_ARGUMENT, &rows[i],
                  "NULL");
        rf_params_init(&params);
    }
}

/* Of every call that takes parameters. */
static void sizes_that_no_version_had_are_refused(void)
{
    const size_t sizes[] = {0,
                            3,
                            sizeof(size_t),
                            sizeof(struct rf_params) - 8,
                            sizeof(struct rf_params) + 8,
                            1 << 20};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct rf_params params;
        struct rf_lens lens;
        struct rf_error errors[4] = {{0}};
        char text[RF_PARAM_TEXT_BYTES] = "#";
        rf_params_init(&params);
        params.size = sizes[i];
        const struct rf_params before = params;
        CHECK(rf_params_check(&params, &errors[0]) == RF_ERROR_ARGUMENT);
        CHECK(rf_params_set(&params, "f-stop", "2", &errors[1]) == RF_ERROR_ARGUMENT);
        CHECK(rf_params_set_number(&params, "white", 2, &errors[2]) ==
              RF_ERROR_ARGUMENT);
        CHECK(rf_lens_init(&lens, &params, 40, 30, &errors[3]) == RF_ERROR_ARGUMENT);
        for (int k = 0; k < 4; k++) {
            CHECK_STR(errors[k].field, "size");
            CHECK_CONTAINS(errors[k].message, "rf_params_init()");
        }
        CHECK(rf_params_get(&params, "f-stop", text, sizeof text) == RF_ERROR_ARGUMENT);
        CHECK(!memcmp(&params, &before, sizeof params));
        CHECK(!rf_param_is_read(&params, "f-stop", NULL));
    }
    CHECK(rf_params_set(NULL, "f-stop", "2", NULL) == RF_ERROR_ARGUMENT);
    struct rf_params params;
    rf_params_init(&params);
    CHECK(rf_params_set(&params, "f-stop", NULL, NULL) == RF_ERROR_PARAMETER);
}

static void blades_need_three(void)
{
    struct rf_params params;
    struct rf_error error;
    for (int shape = 0; shape < rf_param_find("aperture")->n_choices; shape++)
        for (int blades = 0; blades <= 16; blades++) {
            rf_params_init(&params);
            params.aperture = shape;
            params.blades = blades;
            bool is_good = blades >= 3 || (blades == 0 && shape != RF_APERTURE_POLYGON);
            rf_result result = rf_params_check(&params, &error);
            CHECK(result == (is_good ? RF_OK : RF_ERROR_PARAMETER));
            if (!is_good)
                CHECK_STR(error.field, "blades");
        }
}

/* A German desktop writes 2,8; our texts keep the point. */
static void locale_does_not_matter(void)
{
#ifdef _WIN32
    SKIP("localedef makes the locale, and Windows has none");
#else
    char folder[] = "/tmp/rackfocus-locale-XXXXXX", command[256];
    if (!mkdtemp(folder))
        SKIP("no temporary folder");
    snprintf(command, sizeof command,
             "localedef -i de_DE -f UTF-8 %s/de_DE.UTF-8 >/dev/null 2>&1", folder);
    int status = system(command);
    setenv("LOCPATH", folder, 1);
    bool has_locale = status == 0 && setlocale(LC_ALL, "de_DE.UTF-8");
    if (has_locale) {
        char text[32];
        snprintf(text, sizeof text, "%.1f", 2.8);
        CHECK_STR(text, "2,8");
        struct rf_params params;
        rf_params_init(&params);
        CHECK(rf_params_set(&params, "f-stop", "1.75", NULL) == RF_OK);
        CHECK(params.f_stop == 1.75);
        CHECK(rf_params_set(&params, "f-stop", "1,75", NULL) == RF_ERROR_PARAMETER);
        rf_params_get(&params, "f-stop", text, sizeof text);
        CHECK_STR(text, "1.75");
        every_value_survives_text();
    }
    setlocale(LC_ALL, "C");
    unsetenv("LOCPATH");
    snprintf(command, sizeof command, "rm -rf %s", folder);
    status = system(command);
    if (!has_locale)
        SKIP("localedef made no German locale (package locales)");
#endif
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    rows = rf_param_list(&n_rows);
    TEST(table_is_complete);
    TEST(names_are_unique);
    TEST(found_by_key_and_field);
    TEST(init_sets_defaults);
    TEST(without_a_struct_nothing_is_set);
    TEST(init_stays_inside_a_shorter_struct);
    TEST(every_value_survives_text);
    TEST(choices_are_set_by_name);
    TEST(out_of_range_is_rejected);
    TEST(bad_text_is_rejected);
    TEST(messages_list_ranges_and_choices);
    TEST(unknown_names_are_rejected);
    TEST(get_keeps_to_its_buffer);
    TEST(sizes_that_no_version_had_are_refused);
    TEST(blades_need_three);
    TEST(locale_does_not_matter);
    return testing_end();
}
