/* SPDX-License-Identifier: MIT */
/*
 * Files of saved trees that someone made to look whole: for test_save.c and fuzz_load.c.
 */
#ifndef TESTS_FORGED_FILES_H
#define TESTS_FORGED_FILES_H

#include <stddef.h>
#include <stdint.h>

#include "mlrt.h"

/* Where things are in a file, as the head of src/api/save.c has it. */
enum {
    FILE_BYTE_ORDER = 8,
    FILE_VERSION = 12,
    FILE_SIZE = 16,
    FILE_HASH = 24,
    FILE_GEOMETRY_HASH = 32,
    FILE_STRUCTURE = 40,
    FILE_COUNTS =
        44, /* triangles, meshes, masks, nodes, references, nodes of boxes, quads, triangles in order, places */
    FILE_UNIT = 80,
    FILE_LEAF_QUADS = 84,
    FILE_INFO = 88,
    FILE_SECTIONS = 232,
    FILE_SECTION_COUNT = 11,
    FILE_HEADER_SIZE = 408
};

/* Room for a file whose last byte is the block's last, at a multiple of 64 if `size` is one. Free *block. */
unsigned char *allocate_file(size_t size, void **block);

/* Makes the hash of a file right. `size` is at least FILE_HEADER_SIZE, and a multiple of 4. */
void repair_hash(unsigned char *data, size_t size);

/*
 * Traces rays in many ways, which ways and which rays depend on the seed: answers are not looked at. It must end, and
 * touch no memory that it should not: for builds with sanitizers.
 */
void exercise_tree(const mlrt_tree *tree, uint64_t seed);

/* Loads what may be a file, in place or not, and exercises the tree if it is one. 1 if it is. */
int load_and_exercise(const unsigned char *data, size_t size, int in_place, uint64_t seed);

#endif
