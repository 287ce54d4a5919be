/* SPDX-License-Identifier: MIT */
/*
 * The C in README.md, docs/embedding.md and docs/moving.md compiles, each block after those before it, without a
 * warning.
 */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support.h"

/*
 * Copies what is in blocks marked ```c to `program`. Returns how many there are. The tests run in the project's root.
 */
static int copy_blocks(const char *path, FILE *program)
{
    char line[1024];
    int count = 0, inside = 0;
    FILE *text = fopen(path, "r");
    assert_non_null(text);
    while (fgets(line, sizeof line, text)) {
        if (strncmp(line, "```", 3) == 0) {
            inside = !inside && strcmp(line, "```c\n") == 0;
            count += inside;
        } else if (inside) {
            fputs(line, program);
        }
    }
    fclose(text);
    return count;
}

static void check_document(const char *path, int least_count)
{
    char name[] = "/tmp/mlrt-snippets-XXXXXX", command[1024];
    const int descriptor = mkstemp(name);
    assert_true(descriptor >= 0);
    FILE *program = fdopen(descriptor, "w");
    assert_non_null(program);
    fputs("#include <math.h>\n#include <mlrt.h>\n#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n",
          program);
    assert_true(copy_blocks(path, program) >= least_count);
    fclose(program);
    const char *compiler = getenv("CC");
    snprintf(command, sizeof command,
             "%s -std=c99 -pedantic -Wall -Wextra -Wno-unused-function -Werror -Iinclude -fsyntax-only -x c %s",
             compiler ? compiler : "cc", name);
    const int status = system(command);
    remove(name);
    assert_int_equal(status, 0);
}

static void the_program_in_the_readme_compiles(void **state)
{
    (void)state;
    check_document("README.md", 1);
}

static void the_pieces_of_the_embedding_page_compile(void **state)
{
    (void)state;
    check_document("docs/embedding.md", 8);
}

static void the_pieces_of_the_page_on_moving_compile(void **state)
{
    (void)state;
    check_document("docs/moving.md", 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_program_in_the_readme_compiles),
        cmocka_unit_test(the_pieces_of_the_embedding_page_compile),
        cmocka_unit_test(the_pieces_of_the_page_on_moving_compile),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
