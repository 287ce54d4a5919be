/* SPDX-License-Identifier: MIT */
/*
 * The engine of the examples: its pictures are the same for any number of workers, and it holds nothing at the end,
 * also when its load was cancelled or did not fit.
 */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { OUTPUT_SIZE = 8192 };

/* Runs the example with these options. Returns its exit status; what it printed goes to `output`. */
static int run_engine(const char *options, char output[OUTPUT_SIZE])
{
    char command[512];
    const char *build = getenv("BUILD");
    snprintf(command, sizeof command, "%s/bin/engine --quiet %s", build ? build : "build", options);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    const size_t size = fread(output, 1, OUTPUT_SIZE - 1, pipe);
    output[size] = 0;
    return pclose(pipe);
}

/* The line of that name, in the output; it ends at a newline. */
static void get_line(const char *output, const char *name, char line[128])
{
    const char *start = strstr(output, name);
    assert_non_null(start);
    snprintf(line, 128, "%.*s", (int)strcspn(start, "\n"), start);
}

static void the_pictures_are_the_same_for_any_number_of_workers(void **state)
{
    char output[OUTPUT_SIZE], first[128], other[128];
    (void)state;
    assert_int_equal(run_engine("--frames 5 --size 160x90 --workers 1", output), 0);
    get_line(output, "picture_hash ", first);
    static const char *const options[] = {"--frames 5 --size 160x90 --workers 2",
                                          "--frames 5 --size 160x90 --workers 5"};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(run_engine(options[i], output), 0);
        get_line(output, "picture_hash ", other);
        assert_string_equal(first, other);
        assert_non_null(strstr(output, "\nheap_held_size 0\n"));
    }
    assert_int_equal(run_engine("--frames 4 --size 160x90", output), 0);
    get_line(output, "picture_hash ", other);
    assert_string_not_equal(first, other);
}

static void a_cancelled_load_holds_nothing(void **state)
{
    char output[OUTPUT_SIZE];
    (void)state;
    assert_int_equal(run_engine("--cancel-at 0.3", output), 0);
    assert_non_null(strstr(output, "status stopped by a callback\n"));
    assert_non_null(strstr(output, "\nheap_held_size 0\n"));
    assert_null(strstr(output, "picture_hash"));
}

static void a_load_beyond_the_budget_holds_nothing(void **state)
{
    char output[OUTPUT_SIZE];
    (void)state;
    assert_int_not_equal(run_engine("--budget 20", output), 0);
    assert_non_null(strstr(output, "status out of memory\n"));
    assert_non_null(strstr(output, "\nheap_held_size 0\n"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_pictures_are_the_same_for_any_number_of_workers),
        cmocka_unit_test(a_cancelled_load_holds_nothing),
        cmocka_unit_test(a_load_beyond_the_budget_holds_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
