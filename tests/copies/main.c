/* SPDX-License-Identifier: MIT */
/*
 * Three copies of the library in one process, at work at the same time: linked statically, linked statically with its
 * functions renamed, and loaded. Each finds the same hits. `make check-copies` runs it.
 */
#include <inttypes.h>
#include <stdio.h>

#include "load.h"

extern const struct library plain_copy, renamed_copy;

int main(int argc, char **argv)
{
    struct library copies[3] = {plain_copy, renamed_copy, {NULL, NULL, NULL, NULL, NULL}};
    struct use uses[3];
    uint64_t hashes[3];
    void *handle = argc == 2 ? load_library(argv[1], &copies[2]) : NULL;
    if (!handle) {
        fprintf(stderr, "usage: copies LIBRARY: cannot load it\n");
        return 2;
    }
    int failed =
        copies[0].trace == copies[1].trace || copies[0].trace == copies[2].trace || copies[1].trace == copies[2].trace;
    if (failed) fprintf(stderr, "copies: two of them are the same\n");
    for (int i = 0; i < 3; i++) failed |= begin_use(&copies[i], &uses[i]) != MLRT_OK;
    if (!failed) {
        for (int i = 0; i < 3; i++) hashes[i] = hash_hits(&copies[i], &uses[i]);
        printf("copies: static %016" PRIx64 ", renamed %016" PRIx64 ", shared %016" PRIx64 "\n", hashes[0], hashes[1],
               hashes[2]);
        failed = hashes[0] == 0 || hashes[0] != hashes[1] || hashes[0] != hashes[2];
    }
    for (int i = 0; i < 3; i++) end_use(&copies[i], &uses[i]);
    dlclose(handle);
    return failed;
}
