/* SPDX-License-Identifier: MIT */
/*
 * What the rest of the library knows of a structure over a tree's triangles: how it is named in messages, built, saved,
 * loaded, and traced. trace/structure.c has the constant of the hierarchy of boxes, mlrta/structure.c the kd-tree's.
 */
#ifndef MLRT_JOB_STRUCTURE_H
#define MLRT_JOB_STRUCTURE_H

#include <stddef.h>

#include "base/platform.h"
#include "base/progress.h"
#include "exact/hit_list.h"
#include "scene/tree.h"

/* job/job.h */
struct mlrt_job;
struct mlrt_kernels;
struct mlrt_worker;

/* The narrowest instruction set that a build has. */
#define MLRT_ISA_NARROWEST (MLRT_SSE_KERNELS ? MLRT_ISA_SSE : MLRT_NEON_KERNELS ? MLRT_ISA_NEON : MLRT_ISA_SCALAR)

/* The counts of a file, in their order in its header (api/save.c). */
enum {
    MLRT_SAVED_STRUCTURE, /* MLRT_STRUCTURE_* */
    MLRT_SAVED_TRIANGLES,
    MLRT_SAVED_MESHES,
    MLRT_SAVED_MASKS,
    MLRT_SAVED_NODES,
    MLRT_SAVED_REFERENCES,
    MLRT_SAVED_BOX_NODES,
    MLRT_SAVED_QUADS,
    MLRT_SAVED_ORDERED,
    MLRT_SAVED_PLACES,
    MLRT_SAVED_COUNTS
};

/* A section of a file: an array of the tree. */
struct mlrt_section {
    uint16_t array;   /* offset of the pointer in struct mlrt_tree */
    uint16_t length;  /* offset of the number of its elements there, a uint32_t */
    uint16_t element; /* bytes of one element */
    uint8_t more;     /* bytes after the last element */
    uint8_t count;    /* MLRT_SAVED_*: the number of elements */
    uint8_t needs;    /* MLRT_SAVED_*: if this is 0, the section is empty and the pointer NULL */
};

/* A line of a table of sections. */
#define MLRT_SECTION(array, length, element, more, count, needs)                                                       \
    {                                                                                                                  \
        offsetof(struct mlrt_tree, array), offsetof(struct mlrt_tree, length), element, more, MLRT_SAVED_##count,      \
            MLRT_SAVED_##needs                                                                                         \
    }

struct mlrt_structure {
    uint32_t code;   /* MLRT_STRUCTURE_* */
    char name[16];   /* as in "the tree is one of boxes" */
    char plural[12]; /* as in "is for boxes" */

    /* Called within the library's floating-point environment. `options` are checked, of the form `options_form`. */
    struct {
        int32_t options_form; /* MLRT_STRUCT_* */
        float work;           /* of building, per triangle, where copying one is MLRT_COPY_WORK (scene/meshes.h) */
        /*
         * Builds over tree->triangles. It may free them if it sets tree->by_number so that triangles are read without
         * them. Sets the own part of the tree, its bounds, and what tree->info says about them. Returns a status.
         */
        int32_t (*build)(struct mlrt_tree *tree, const void *options, struct mlrt_progress *progress);
        struct mlrt_demand (*foresee)(const void *options, uint32_t triangle_count);
        void (*free)(struct mlrt_tree *tree);
    } builder;

    struct {
        struct mlrt_section sections[4];
        uint8_t first; /* the place of the first of `sections` in the file */
        uint8_t count;
        uint16_t numbers; /* offset in struct mlrt_tree of two adjacent words that the file has besides; 0 = none */
        /*
         * Check what was loaded. `take` is called first, and lets triangles be read; `check` knows that the tree's
         * bounds and counts of triangles are right. NULL, or a static string that names the error.
         */
        const char *(*take)(struct mlrt_tree *tree);
        const char *(*check)(struct mlrt_tree *tree);
    } file;

    struct {
        uint8_t method;  /* the default */
        uint8_t methods; /* bit 1 << MLRT_METHOD_* for each that there is */
        /* Default sides of the tiles that threads claim: of cameras, rows of pixels in arrays, and lists. */
        uint16_t camera_side, row_side, list_side;
        /* By MLRT_ISA_*. Where there are none, those of the next narrower set serve; the narrowest count, too. */
        const struct mlrt_kernels *kernels[MLRT_ISA_NEON + 1];
        /*
         * Lays out and clears what a worker keeps for the kernels, from `memory` on, in whole cache lines. Returns its
         * bytes. With NULL, only returns them.
         */
        size_t (*lay_out)(const struct mlrt_job *job, unsigned char *memory, struct mlrt_worker *worker);
        /*
         * Traces one ray whose numbers have any finite magnitude, in double: the answers that every other path must
         * match. Returns the number of the triangle of the nearest hit, or MLRT_NONE; with `any`, of any hit. `skip` is
         * the number of a triangle that the ray passes through, or MLRT_NONE. With a list (NULL = none), adds all hits
         * to it, perhaps some more than once; then no hit ends the search, and the result has no meaning. `counters`
         * may be NULL.
         */
        uint32_t (*trace_ray)(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                              struct mlrt_hit_list *list, mlrt_counters *counters);
    } tracer;
};

extern const struct mlrt_structure mlrt_structure_bvh, mlrt_structure_kdtree;

#endif
