/* SPDX-License-Identifier: MIT */
/*
 * Memory: alignment, counting, and refusal.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/memory.h"

static void test_blocks_are_aligned_to_64(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 0};
    for (size_t count = 0; count < 200; count++) {
        void *block = mlrt_allocate(&memory, count, 3);
        assert_non_null(block);
        assert_int_equal((uintptr_t)block % 64, 0);
        memset(block, 1, 3 * count);
        mlrt_free(&memory, block, count, 3);
    }
}

static void test_no_elements_are_a_block_too(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 0};
    void *block = mlrt_allocate(&memory, 0, 8);
    assert_non_null(block);
    assert_int_equal(memory.held_size, 1); /* what a host is asked for */
    mlrt_free(&memory, block, 0, 8);
    assert_int_equal(memory.held_size, 0);
}

static void test_held_and_peak_are_counted(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 0};
    void *first = mlrt_allocate(&memory, 10, 4), *second = mlrt_allocate(&memory, 5, 12);
    assert_int_equal(memory.held_size, 100);
    mlrt_free(&memory, first, 10, 4);
    assert_int_equal(memory.held_size, 60);
    mlrt_free(&memory, second, 5, 12);
    assert_int_equal(memory.held_size, 0);
    assert_int_equal(memory.peak_size, 100);
}

static void test_freeing_null_does_nothing(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.held_size = 7, .peak_size = 7};
    mlrt_free(&memory, NULL, 100, 100);
    assert_int_equal(memory.held_size, 7);
}

static void test_a_product_that_overflows_is_refused(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 0};
    assert_null(mlrt_allocate(&memory, SIZE_MAX, 2));
    assert_null(mlrt_allocate(&memory, SIZE_MAX / 4 + 1, 4));
    assert_null(mlrt_allocate(&memory, SIZE_MAX, 1));
    assert_int_equal(memory.held_size, 0);
}

static void test_resizing_keeps_the_common_part(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 0};
    unsigned char *block = mlrt_allocate(&memory, 100, 1);
    for (int i = 0; i < 100; i++) block[i] = (unsigned char)i;
    block = mlrt_resize(&memory, block, 100, 1000, 1);
    assert_int_equal(block[99], 99);
    block = mlrt_resize(&memory, block, 1000, 50, 1);
    for (int i = 0; i < 50; i++) assert_int_equal(block[i], i);
    assert_int_equal(memory.held_size, 50);
    mlrt_free(&memory, block, 50, 1);
}

static void test_resized_blocks_are_aligned_and_whole(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 0};
    size_t count = 1;
    unsigned char *block = mlrt_allocate(&memory, count, 1);
    block[0] = 0;
    for (int step = 0; step < 30; step++) {
        size_t larger = count + count / 3 + 1;
        block = mlrt_resize(&memory, block, count, larger, 1);
        assert_int_equal((uintptr_t)block % 64, 0);
        for (size_t i = 0; i < larger; i++) {
            if (i < count) assert_int_equal(block[i], i % 251);
            block[i] = (unsigned char)(i % 251);
        }
        count = larger;
    }
    assert_int_equal(memory.held_size, count);
    mlrt_free(&memory, block, count, 1);
}

static void test_resizing_null_allocates(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 0};
    void *block = mlrt_resize(&memory, NULL, 0, 10, 4);
    assert_non_null(block);
    assert_int_equal(memory.held_size, 40);
    mlrt_free(&memory, block, 10, 4);
}

static void test_the_limit_holds_and_a_failed_resize_keeps_the_block(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 100};
    unsigned char *block = mlrt_allocate(&memory, 60, 1);
    block[59] = 5;
    assert_null(mlrt_allocate(&memory, 41, 1));
    assert_null(mlrt_resize(&memory, block, 60, 101, 1));
    assert_int_equal(block[59], 5);
    assert_int_equal(memory.held_size, 60);
    mlrt_free(&memory, block, 60, 1);
}

/* A block of no elements counts one byte, also where a resize makes it, or makes more of it. */
static void test_resizing_to_nothing_keeps_to_the_limit(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 64};
    void *block = mlrt_allocate(&memory, 64, 1);
    const size_t counts[] = {64, 0, 0, 64, 0};
    for (size_t i = 1; i < sizeof counts / sizeof *counts; i++) {
        block = mlrt_resize(&memory, block, counts[i - 1], counts[i], 1);
        assert_non_null(block);
        assert_int_equal(memory.held_size, counts[i] ? counts[i] : 1);
    }
    assert_null(mlrt_resize(&memory, block, 0, 65, 1));
    mlrt_free(&memory, block, 0, 1);
    assert_int_equal(memory.held_size, 0);

    memory.limit_size = 1;
    block = mlrt_allocate(&memory, 0, 8);
    block = mlrt_resize(&memory, block, 0, 0, 8);
    assert_non_null(block);
    mlrt_free(&memory, block, 0, 8);
}

static void test_a_block_gives_way_to_one_of_another_size(void **state)
{
    (void)state;
    struct mlrt_memory memory = {.limit_size = 5000000};
    void *block = mlrt_allocate(&memory, 1000, 4);
    const size_t sizes[] = {4000, 700, 0, 1, 4900000, 4500000, 50};
    size_t size = 4000;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        block = mlrt_reuse(&memory, block, size, sizes[i]);
        size = sizes[i];
        assert_non_null(block);
        assert_int_equal((uintptr_t)block % 64, 0);
        assert_int_equal(memory.held_size, size ? size : 1);
        memset(block, 1, size);
    }
    assert_null(mlrt_reuse(&memory, block, size, 5000001));
    assert_int_equal(memory.held_size, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks_are_aligned_to_64),
        cmocka_unit_test(test_no_elements_are_a_block_too),
        cmocka_unit_test(test_held_and_peak_are_counted),
        cmocka_unit_test(test_freeing_null_does_nothing),
        cmocka_unit_test(test_a_product_that_overflows_is_refused),
        cmocka_unit_test(test_resizing_keeps_the_common_part),
        cmocka_unit_test(test_resized_blocks_are_aligned_and_whole),
        cmocka_unit_test(test_resizing_null_allocates),
        cmocka_unit_test(test_the_limit_holds_and_a_failed_resize_keeps_the_block),
        cmocka_unit_test(test_resizing_to_nothing_keeps_to_the_limit),
        cmocka_unit_test(test_a_block_gives_way_to_one_of_another_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
