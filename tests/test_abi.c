/* SPDX-License-Identifier: MIT */
/*
 * The binary interface stays as it is: structs and constants are those of tests/abi, which `make update-abi` writes
 * anew after a change that is meant. `make check-abi` looks at the exported names besides, and at the types of
 * functions.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"
#include "abi/interface.h"

static size_t read_all(FILE *file, char *text, size_t capacity)
{
    assert_non_null(file);
    rewind(file);
    size_t size = fread(text, 1, capacity - 1, file);
    text[size] = 0;
    fclose(file);
    return size;
}

/* The tests run in the root of the project. */
static void compare_with(const char *path, FILE *now)
{
    static char recorded_text[1 << 16], text[1 << 16];
    assert_true(read_all(fopen(path, "rb"), recorded_text, sizeof recorded_text) > 100);
    assert_true(read_all(now, text, sizeof text) > 100);
    const char *recorded = recorded_text, *line = text;
    while (*line && *recorded) {
        size_t size = strcspn(line, "\n"), recorded_size = strcspn(recorded, "\n");
        if (size != recorded_size || memcmp(line, recorded, size) != 0)
            fail_msg("%s has '%.*s', the header '%.*s'", path, (int)recorded_size, recorded, (int)size, line);
        line += size + (line[size] != 0);
        recorded += recorded_size + (recorded[recorded_size] != 0);
    }
    assert_string_equal(line, recorded); // one may go on
}

static void layouts_are_as_recorded(void **state)
{
    (void)state;
    const char *path = sizeof(void *) == 8 ? "tests/abi/layout-lp64.txt" : "tests/abi/layout-ilp32.txt";
    struct after_char {
        char first;
        uint64_t second;
    };
    if (sizeof(void *) == 4 && offsetof(struct after_char, second) != 4) skip(); // recorded are those of i386
    FILE *now = tmpfile();
    assert_non_null(now);
    print_layout(now);
    compare_with(path, now);
}

static void structs_have_no_holes(void **state)
{
    (void)state;
    FILE *nowhere = tmpfile();
    assert_non_null(nowhere);
    assert_int_equal(print_layout(nowhere), 0);
    fclose(nowhere);
}

static void constants_are_as_recorded(void **state)
{
    (void)state;
    FILE *now = tmpfile();
    assert_non_null(now);
    print_constants(now);
    compare_with("tests/abi/constants.txt", now);
}

/* mlrt_struct_sizes, and that no struct of the header is without a number. */
static void the_library_tells_the_sizes_of_all_structs(void **state)
{
    (void)state;
    uint32_t sizes[MLRT_STRUCT_COUNT + 2], struct_count = 0;
    memset(sizes, 0xFF, sizeof sizes);
    mlrt_struct_sizes(sizes, MLRT_STRUCT_COUNT + 1);
#define STRUCT(type, number)                                                                                           \
    assert_int_equal(sizes[number], sizeof(type));                                                                     \
    ++struct_count;
#define FIELD(type, name, field_type)
#define END(type)
#define CONSTANT(name)
#include "interface.inc"
    assert_int_equal(struct_count, MLRT_STRUCT_COUNT);
    assert_int_equal(sizes[MLRT_STRUCT_COUNT], 0);
    assert_int_equal(sizes[MLRT_STRUCT_COUNT + 1], 0xFFFFFFFFu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layouts_are_as_recorded),
        cmocka_unit_test(structs_have_no_holes),
        cmocka_unit_test(constants_are_as_recorded),
        cmocka_unit_test(the_library_tells_the_sizes_of_all_structs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
