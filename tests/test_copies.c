/* SPDX-License-Identifier: MIT */
/*
 * Copies of the shared library in one process, and one that comes and goes: nothing of it stays, no thread, no page, no
 * memory. (copies/main.c has static copies besides.)
 */
#define _POSIX_C_SOURCE 200809L // nanosleep

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "support.h"
#include "copies/load.h"

static char original[512], copy[512];

static void copy_file(const char *from, const char *to)
{
    FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
    assert_non_null(in);
    assert_non_null(out);
    char block[1 << 16];
    size_t size;
    while ((size = fread(block, 1, sizeof block, in)) > 0) assert_int_equal(fwrite(block, 1, size, out), size);
    fclose(in);
    assert_int_equal(fclose(out), 0);
}

static int set_up(void **state)
{
    (void)state;
    const char *build = getenv("BUILD");
    if (!build) build = "build";
    snprintf(original, sizeof original, "%s/libmlrt.so", build);
    snprintf(copy, sizeof copy, "%s/tests/libmlrt-copy-%ld.so", build, (long)getpid());
    copy_file(original, copy);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    return remove(copy);
}

static void two_copies_do_not_disturb_each_other(void **state)
{
    (void)state;
    struct library first, second;
    struct use uses[2];
    void *first_handle = load_library(original, &first), *second_handle = load_library(copy, &second);
    assert_non_null(first_handle);
    assert_non_null(second_handle);
    assert_true(first.trace != second.trace);
    assert_int_equal(begin_use(&first, &uses[0]), MLRT_OK);
    assert_int_equal(begin_use(&second, &uses[1]), MLRT_OK);
    uint64_t hash = hash_hits(&first, &uses[0]);
    assert_true(hash != 0);
    assert_true(hash_hits(&second, &uses[1]) == hash);
    end_use(&first, &uses[0]);
    assert_int_equal(dlclose(first_handle), 0);
    assert_true(hash_hits(&second, &uses[1]) == hash); // without the other
    end_use(&second, &uses[1]);
    assert_int_equal(dlclose(second_handle), 0);
}

/* Lines of a file that contain a word. */
static int count_lines(const char *path, const char *word)
{
    FILE *file = fopen(path, "r");
    if (!file) return -1;
    char line[4096];
    int count = 0;
    while (fgets(line, sizeof line, file)) count += strstr(line, word) != NULL;
    fclose(file);
    return count;
}

/* Threads of this process; -1 where nothing tells. */
static int count_threads(void)
{
    DIR *folder = opendir("/proc/self/task");
    if (!folder) return -1;
    int count = 0;
    for (struct dirent *entry; (entry = readdir(folder)) != NULL;) count += entry->d_name[0] != '.';
    closedir(folder);
    return count;
}

/* A thread that was joined may be listed for some moments more. */
static void expect_threads(int count)
{
    const struct timespec millisecond = {0, 1000000};
    for (int i = 0; i < 2000 && count_threads() != count; i++) nanosleep(&millisecond, NULL);
    assert_int_equal(count_threads(), count);
}

static int count_pages_held(void)
{
    return count_lines("/proc/self/maps", strrchr(copy, '/'));
}

static void it_comes_and_goes_without_a_trace(void **state)
{
    (void)state;
    int thread_count = count_threads();
    uint64_t hash = 0;
    for (size_t round = 0; round < scaled(100); round++) {
        struct library library;
        struct use use;
        void *handle = load_library(copy, &library);
        assert_non_null(handle);
        if (count_pages_held() == 0) fail_msg("%s is not loaded", copy); // so that the count below means something
        assert_int_equal(begin_use(&library, &use), MLRT_OK);
        if (thread_count > 0) expect_threads(thread_count + 1);
        uint64_t now = hash_hits(&library, &use);
        assert_true(now != 0 && (round == 0 || now == hash));
        hash = now;
        end_use(&library, &use);
        assert_int_equal(dlclose(handle), 0);
        assert_true(count_pages_held() <= 0);
        expect_threads(thread_count);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_copies_do_not_disturb_each_other),
        cmocka_unit_test(it_comes_and_goes_without_a_trace),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
