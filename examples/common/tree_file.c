/* SPDX-License-Identifier: MIT */
/* tree_file.c - trees in files: see tree_file.h */
#define _POSIX_C_SOURCE 200809L
#include "tree_file.h"

#include "file.h"
#include "must.h"
#include "timer.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define REPEATS 3

static int write_file(const char *name, const void *data, size_t size)
{
    struct output_file output;
    if (open_output(name, &output)) return 1;
    const int failed = fwrite(data, 1, size, output.file) != size;
    if (failed) fprintf(stderr, "%s: cannot be written: %s\n", name, strerror(errno));
    return close_output(&output, failed);
}

int save_tree(const mlrt_tree *tree, const char *name, double *seconds)
{
    size_t size;
    must_succeed(mlrt_save_tree(tree, NULL, 0, &size));
    void *data = malloc(size);
    if (data == NULL) {
        fprintf(stderr, "%s: out of memory\n", name);
        return 1;
    }
    memset(data, 0, size);
    const double start = seconds_now();
    must_succeed(mlrt_save_tree(tree, data, size, &size));
    *seconds = seconds_now() - start;
    const int failed = write_file(name, data, size);
    free(data);
    return failed;
}

/* NULL after saying what is wrong. Such a mapping is never given back: the program ends soon. */
static const void *map_file(const char *name, size_t *size)
{
    struct stat status;
    void *data = MAP_FAILED;
    const char *problem = find_input_problem(name);
    const int descriptor = problem ? -1 : open(name, O_RDONLY);
    if (descriptor >= 0 && fstat(descriptor, &status) == 0 && status.st_size > 0) {
        *size = (size_t)status.st_size;
        data = mmap(NULL, *size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    }
    if (descriptor >= 0) close(descriptor);
    if (data == MAP_FAILED)
        fprintf(stderr, "%s: cannot be read%s%s\n", name, problem ? ": " : "", problem ? problem : "");
    return data == MAP_FAILED ? NULL : data;
}

static void keep_least(double *least, double value)
{
    if (*least == 0 || value < *least) *least = value;
}

static int32_t time_load(const void *data, size_t size, const mlrt_load_options *options, mlrt_tree **tree,
                         double *least)
{
    int32_t status = MLRT_OK;
    for (int i = 0; i < REPEATS && status == MLRT_OK; i++) {
        mlrt_destroy_tree(*tree);
        const double start = seconds_now();
        status = mlrt_load_tree(data, size, options, tree);
        keep_least(least, seconds_now() - start);
    }
    return status;
}

static void time_memcpy(const void *data, size_t size, double *least)
{
    for (int i = 0; i < REPEATS; i++) {
        const double start = seconds_now();
        unsigned char *copy = malloc(size);
        if (copy == NULL) return;
        memcpy(copy, data, size);
        const volatile unsigned char *seen = copy; // or nobody would copy
        (void)seen[size / 2];
        keep_least(least, seconds_now() - start);
        free(copy);
    }
}

int load_tree(const char *name, mlrt_tree **tree, struct load_times *times)
{
    char message[256] = "";
    mlrt_load_options options = {
        .struct_size = sizeof options, .flags = MLRT_LOAD_IN_PLACE, .message = message, .message_size = sizeof message};
    *times = (struct load_times){0, 0, 0, 0};
    *tree = NULL;
    const void *data = map_file(name, &times->file_size);
    if (data == NULL) return 1;
    int32_t status = time_load(data, times->file_size, &options, tree, &times->in_place);
    options.flags = 0;
    if (status == MLRT_OK) status = time_load(data, times->file_size, &options, tree, &times->copied);
    time_memcpy(data, times->file_size, &times->memcpy_alone);
    if (status != MLRT_OK) fprintf(stderr, "%s: %s\n", name, *message ? message : mlrt_status_string(status));
    return status != MLRT_OK;
}
