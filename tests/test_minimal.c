/* SPDX-License-Identifier: MIT */
/*
 * The program in the head comment of mlrt.h is examples/minimal.c, letter by letter.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

/* The whole file, or NULL. The tests run in the root of the project. */
static char *read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    char *text = allocate_or_fail(1 << 20, 1);
    size_t size = fread(text, 1, (1 << 20) - 1, file);
    text[size] = 0;
    fclose(file);
    return text;
}

/* From the first line that starts with " *     #" to the next line that is not so indented, without the prefix. */
static void extract_program(const char *header, char *program)
{
    static const char prefix[] = " *     ";
    const size_t width = sizeof prefix - 1;
    const char *line = strstr(header, "\n *     #include");
    assert_non_null(line);
    line++;
    size_t size = 0;
    while (strncmp(line, prefix, width) == 0) {
        const char *end = strchr(line, '\n') + 1;
        memcpy(program + size, line + width, (size_t)(end - line) - width);
        size += (size_t)(end - line) - width;
        line = end;
    }
    program[size] = 0;
}

static void the_program_in_the_header_is_the_example(void **state)
{
    (void)state;
    char *header = read_file("include/mlrt.h"), *example = read_file("examples/minimal.c");
    assert_non_null(header);
    assert_non_null(example);
    char *program = allocate_or_fail(strlen(header), 1);
    extract_program(header, program);
    assert_true(strlen(program) > 500);
    const char *start = strstr(example, "#include"); // a licence line and a comment may come before it
    assert_non_null(start);
    assert_string_equal(start, program);
    free(header);
    free(example);
    free(program);
}

/* What the program does, as a function. */
static void the_program_finds_its_triangle(void **state)
{
    (void)state;
    const float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    mlrt_mesh mesh = {sizeof mesh, 0, corners, 3, 0, NULL, 1, 0, 0, 0};
    mlrt_tree *tree = NULL;
    mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
    mlrt_hit hit = {.struct_size = sizeof hit};
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, &hit), MLRT_OK);
    assert_true(hit.t == 5);
    assert_int_equal(hit.triangle, 0);
    mlrt_destroy_tree(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_program_in_the_header_is_the_example),
        cmocka_unit_test(the_program_finds_its_triangle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
