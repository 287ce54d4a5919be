/* SPDX-License-Identifier: MIT */
/*
 * For libFuzzer: any bytes, with size and hash made right, are an error or a tree that can be used. test_save.c leaves
 * files to start from in the folder that FUZZ_FILES names:
 *
 *     make CC=clang SAN=address,undefined,fuzzer-no-link fuzz
 */
#include <stdlib.h>
#include <string.h>

#include "forged_files.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < FILE_HEADER_SIZE || size % 4 != 0) return 0;
    void *block;
    unsigned char *copy = allocate_file(size, &block);
    const uint64_t stated = size;
    memcpy(copy, data, size);
    memcpy(copy + FILE_SIZE, &stated, sizeof stated);
    repair_hash(copy, size);
    load_and_exercise(copy, size, 1, data[size - 1]);
    free(block);
    return 0;
}
