/* SPDX-License-Identifier: MIT */
/* One build of a hierarchy of boxes: the state that is passed from file to file. build.c begins with what they do. */
#ifndef MLRT_BVH_BUILD_H
#define MLRT_BVH_BUILD_H

#include "base/progress.h"
#include "base/scheduler.h"
#include "bvh/node.h"
#include "bvh/split.h"

/*
 * The pool takes references, or triangles, in chunks of so many, and looks after each chunk whether the call is
 * cancelled. Filling the slabs of a chunk takes 3 ms.
 */
#define MLRT_CHUNK_SIZE 4096

/*
 * Bytes of the block of references for each of them. It becomes the block of the leaves' corners, 36 to 46 bytes for
 * each, and the system need not clear other pages for these.
 */
#define MLRT_REFERENCE_ROOM 40

/* When a leaf is written, the triangles of the references so many places behind its own are prefetched. */
#define MLRT_WORDS_AHEAD 32

/* The parts of MLRT_BVH_WORK for making a triangle's reference first, and for writing nodes at the end. */
#define MLRT_FIRST_WORK 1.0
#define MLRT_LAST_WORK  1.0

struct mlrt_bvh_preset {
    float spare_share;     /* spare places per triangle, for references that spatial splits add */
    float overlap_limit;   /* spatial splits are tried where sides overlap by more than this part of the scene's area */
    uint32_t spatial_size; /* and in sets of more references than this; at least MLRT_BVH_LEAF_LIMIT */
    uint32_t failure_limit; /* and not below sets in which they were tried in vain more than so many times on end */
};

/*
 * A node of the binary hierarchy. Its lower child is the next one in the array.
 *
 * `choice` is the cheapest way to make the node at most i slots (children) of a node above. choice[i], 2 <= i <= 15:
 * how many of the i slots the lower child gets, and the upper child the others; 0 = as for i - 1 slots. choice[1]:
 * 0 = one slot is a leaf, 1 = it is a node. choice[0]: how many of that node's sixteen slots the lower child gets.
 */
struct mlrt_binary_node {
    float lo[3];
    float hi[3];
    uint32_t first; /* its references: `count` of them from this one on */
    uint32_t count;
    uint32_t upper; /* the upper child; 0 = the node has no children */
    uint8_t choice[MLRT_BVH_WIDTH];
};

/*
 * cost[i], 1 <= i <= slot_count: the least cost, times area, of a binary node and all below it as at most i slots. More
 * slots would be of no use, or there are no more.
 */
struct mlrt_forest_costs {
    float cost[MLRT_BVH_WIDTH];
    int slot_count;
};

/* A set to be cut, the number of its binary node, and its limits. */
struct mlrt_portion {
    struct mlrt_bvh_set set;
    uint32_t spare; /* free places behind the references of the set */
    uint32_t node;
    uint32_t depth;
    uint32_t budget;       /* the most leaves */
    uint32_t failed_count; /* spatial splits tried in vain, for this set and those above it, since one was made */
};

/* The references of a chunk of triangles, and how many triangles are left out. */
struct mlrt_chunk {
    struct mlrt_bvh_set set;
    struct mlrt_box bounds; /* of the references, not in units */
    uint64_t non_finite_count;
    uint64_t zero_area_count;
};

/* The size of a part of the hierarchy. Counts stay below 2^32: there are fewer leaves than MLRT_REFERENCE_MARK. */
struct mlrt_bvh_size {
    uint32_t node_count;
    uint32_t quad_count;
    uint32_t slot_count; /* of the node above */
    uint32_t depth;      /* nodes on the longest path from the root */
};

/* Where the next node, quad and slot are written: behind those that `size` counts. */
struct mlrt_bvh_cursor {
    struct mlrt_bvh_size size;
    uint32_t depth;               /* of the parent */
    struct mlrt_bvh_node *parent; /* the node whose children are written; NULL = nothing is written, only counted */
};

/* A binary node that one worker makes, and all below it. */
struct mlrt_forest {
    uint32_t node;
    struct mlrt_forest_costs costs;
    uint32_t slots;              /* of the node above, that it may take at most */
    struct mlrt_bvh_cursor from; /* where it is written */
    struct mlrt_bvh_size size;   /* 0 until it is measured */
};

struct mlrt_bvh_build {
    struct mlrt_tree *tree;
    mlrt_pool *pool;
    struct mlrt_progress *progress;
    const struct mlrt_bvh_preset *preset;
    struct mlrt_bvh_costs costs;
    double scene_area; /* area of the core of the scene; a few boxes may be larger */

    /* What follows from the options and the triangles. */
    struct {
        uint32_t capacity;   /* references that there is room for */
        uint32_t leaf_limit; /* leaves of the binary hierarchy, at most */
        uint32_t task_size;  /* sets of at most so many references are tasks */
        uint32_t task_capacity;
        uint32_t level_capacity;
        uint32_t chunk_count; /* of triangles */
        double cut_work;      /* per reference of a set that is cut */
        int typical;          /* the exponent of a typical coordinate (unit.h) */
    } limits;

    /* The boxes of triangles, or of their parts, from which the hierarchy is built. */
    struct {
        struct mlrt_chunk *chunks;
        struct mlrt_quad_box *boxes;
        struct mlrt_bvh_set whole; /* all of them before any is cut */
    } references;

    /*
     * The binary hierarchy. `words` has mlrt_reference_word of each reference. Between sets, and in MLRT_WORDS_AHEAD
     * more places at the end, it is not set.
     */
    struct {
        struct mlrt_binary_node *nodes;
        uint32_t *words;
    } binary;

    /* The sets that are shared out to the pool. */
    struct {
        struct mlrt_portion *portions; /* the root, and the sides of all sets that are too large for tasks */
        uint32_t portion_count;
        struct mlrt_portion **level; /* those of one depth that are too large */
        struct mlrt_portion **tasks; /* those that one worker each builds, in depth-first order */
        struct mlrt_forest *forests; /* of the tasks, and one of no node at the end */
        uint32_t task_count;
        const struct mlrt_portion *shared; /* whose bins all workers fill; NULL = none */
        uint64_t least_shared;             /* references of the sets of a level that are shared */
        struct mlrt_bvh_bins *shares;      /* of each worker, if there are several: bins of its part of a set */
    } work;

    struct mlrt_bvh_part *parts; /* of the result, measured (build.c) */

    /* The memory of all arrays but `boxes`. */
    struct {
        void *start;
        uint64_t size;
    } block;
};

/* A step of the build: one of its items. */
typedef void mlrt_bvh_step(struct mlrt_bvh_build *build, uint32_t item, uint32_t worker);

/* Runs `count` items on the pool, in the library's floating-point environment. Returns a status. */
int32_t mlrt_run_step(struct mlrt_bvh_build *build, uint32_t count, mlrt_bvh_step *step);

/* ---- references.c ---------------------------------------------------------------------------------------------- */

/*
 * Makes the references of all triangles, without gaps. Sets their whole set, the bounds and extent of the tree, and the
 * counts of triangles left out. Returns a status.
 */
int32_t mlrt_make_references(struct mlrt_bvh_build *build);

/* ---- cut.c ----------------------------------------------------------------------------------------------------- */

/* Cuts a portion in two and returns 1. Returns 0 if the portion becomes a leaf, or the call is cancelled. */
int mlrt_cut_portion(struct mlrt_bvh_build *build, struct mlrt_portion *portion, struct mlrt_portion sides[2]);

/* ---- binary.c -------------------------------------------------------------------------------------------------- */

/* Builds the binary hierarchy over all references, and chooses what its nodes become. Returns a status. */
int32_t mlrt_build_binary(struct mlrt_bvh_build *build);

/* ---- write.c --------------------------------------------------------------------------------------------------- */

/* Allocates tree->bvh and writes all of it; sets tree->info.depth. Returns a status. */
int32_t mlrt_write_hierarchy(struct mlrt_bvh_build *build);

#endif
