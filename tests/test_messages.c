/* SPDX-License-Identifier: MIT */
/*
 * mlrt_last_message: each thread has its own, and only calls that fail change it.
 */
#define _POSIX_C_SOURCE 200809L
#include <pthread.h>
#include <string.h>

#include "support.h"

static const float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};

static mlrt_tree *some_tree(void)
{
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    return tree;
}

/* A call that fails and one that succeeds, in a thread that has made no call: NULL, or what was wrong. */
static void *use_a_new_thread(void *tree)
{
    char first[300];
    mlrt_tree_info info = {.struct_size = sizeof info};
    if (mlrt_last_message()[0]) return "not empty at first";
    if (mlrt_get_tree_info(tree, NULL) != MLRT_ERROR_ARGUMENT) return "no error";
    if (!mlrt_last_message()[0]) return "empty after an error";
    strcpy(first, mlrt_last_message());
    if (mlrt_get_tree_info(tree, &info) != MLRT_OK) return "an error";
    if (strcmp(mlrt_last_message(), first) != 0) return "changed by a call that succeeds";
    info.struct_size = 3;
    if (mlrt_get_tree_info(tree, &info) != MLRT_ERROR_STRUCT_SIZE) return "not the error of the size";
    if (strcmp(mlrt_last_message(), first) == 0) return "not changed by another error";
    return NULL;
}

#define THREAD_COUNT 8

static void each_thread_has_its_own(void **state)
{
    (void)state;
    pthread_t threads[THREAD_COUNT];
    mlrt_tree *tree = some_tree();
    char before[300];
    assert_int_equal(mlrt_save_tree(tree, NULL, 0, NULL), MLRT_ERROR_ARGUMENT);
    strcpy(before, mlrt_last_message());
    for (int i = 0; i < THREAD_COUNT; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, use_a_new_thread, tree), 0);
    for (int i = 0; i < THREAD_COUNT; i++) {
        void *wrong = "not joined";
        assert_int_equal(pthread_join(threads[i], &wrong), 0);
        if (wrong) fail_msg("a new thread's message: %s", (const char *)wrong);
    }
    assert_string_equal(mlrt_last_message(), before);
    mlrt_destroy_tree(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_thread_has_its_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
