/* SPDX-License-Identifier: MIT */
/* One build of a hierarchy of boxes: the state that is passed from file to file. build.c begins with what they do. */
#ifndef MLRT_BVH_BUILD_H
#define MLRT_BVH_BUILD_H

#include "base/progress.h"
#include "base/scheduler.h"
#include "bvh/node.h"
#include "bvh/set.h"

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

/* Sets of up to so many references are split at the best of all places. In larger sets bins are as good and faster. */
#define MLRT_SWEEP_LIMIT 32

/* With 16 bins expected costs are 0.3 % higher, with 64 they are no lower. */
#define MLRT_BVH_BINS 32

/* How a split deals out references: each by its own rank, by the bin of its centre, or cut by a plane between bins. */
enum mlrt_split_kind { MLRT_SPLIT_BY_RANK, MLRT_SPLIT_BY_BIN, MLRT_SPLIT_BY_PLANE };

/*
 * The first `bin_count` bins of each axis, of equal width. References are put into bins by their centres (BY_BIN), or
 * cut at the planes between bins (BY_PLANE): then a reference has a part in each bin from its first to its last.
 */
struct mlrt_bvh_bins {
    struct mlrt_quad_box box[MLRT_BVH_BINS][3];             /* of the references, or parts, in each bin */
    MLRT_ALIGNED(16) int32_t first_count[MLRT_BVH_BINS][4]; /* how many references have it as their bin, or first bin */
    MLRT_ALIGNED(16) int32_t last_count[MLRT_BVH_BINS][4];  /* BY_PLANE: as their last bin */
    uint32_t bin_count;
    enum mlrt_split_kind kind;
};

/* The bin of x along each axis is the whole part of (x - start) * scale. Elements 3 are 0. */
struct mlrt_binning {
    MLRT_ALIGNED(16) float start[4];
    MLRT_ALIGNED(16) float scale[4]; /* bins per unit of length */
    float width[3];                  /* of a bin; 0 where all are in bin 0 */
};

struct mlrt_bvh_split {
    double cost; /* sum over both sides of area times cost; HUGE_VAL = there is no split */
    enum mlrt_split_kind kind;
    uint32_t axis;
    uint32_t bin;                   /* bins up to this one are the lower side */
    uint32_t count[2];              /* references of each side; by a plane the most: those on both count on each */
    uint8_t rank[MLRT_SWEEP_LIMIT]; /* by rank: of each reference, in the order of centres */
    struct mlrt_quad_box box[2];    /* of both sides; by a plane estimated */
};

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
 * cost[i], 1 <= i <= slot_count: the least cost, times area, of a binary node and all below it as at most i slots (a
 * forest of at most i trees, in the paper of collapse.c). More slots would be of no use, or there are no more.
 */
struct mlrt_slot_costs {
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

/* What a task becomes: a binary node, and all below it. One worker makes it. */
struct mlrt_bvh_subtree {
    uint32_t node;
    struct mlrt_slot_costs costs;
    uint32_t slots;              /* of a node above: how many it may take, at most */
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
        struct mlrt_portion **level;       /* those of one depth that are too large */
        struct mlrt_portion **tasks;       /* those that one worker each builds, in depth-first order */
        struct mlrt_bvh_subtree *subtrees; /* of the tasks, and one of no node at the end */
        uint32_t task_count;
        const struct mlrt_portion *shared; /* whose bins all workers fill; NULL = none */
        uint64_t least_shared;             /* references of the sets of a level that are shared */
        struct mlrt_bvh_bins *shares;      /* of each worker, if there are several: bins of its part of a set */
    } work;

    struct mlrt_bvh_part *parts; /* of the result, while it is measured (build.c) */

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

/* ---- split.c --------------------------------------------------------------------------------------------------- */

/* The set of `count` references from `first` on, at least one. If the call is cancelled, its boxes are unfinished. */
struct mlrt_bvh_set mlrt_measure_set(const struct mlrt_bvh_build *build, uint32_t first, uint32_t count);

/* Sets *split to the cheapest split of a set of 2 to MLRT_SWEEP_LIMIT references. */
void mlrt_sweep_set(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set, struct mlrt_bvh_split *split);

/* The bins of coordinates, or centres, that lie in a box. */
struct mlrt_binning mlrt_cut_bins(const struct mlrt_quad_box *box, uint32_t bin_count);

/* Empties the bins of a set of `count` references. */
void mlrt_clear_bins(enum mlrt_split_kind kind, uint32_t count, struct mlrt_bvh_bins *bins);

/*
 * Adds `count` references, from `first` on, to bins of a set whose centres lie in the box `centres`. If the call is
 * cancelled, not all of them.
 */
void mlrt_fill_bins(const struct mlrt_bvh_build *build, uint32_t first, uint32_t count,
                    const struct mlrt_quad_box *centres, struct mlrt_bvh_bins *bins);

/* Adds bins to *sum: then it is as if the references of both had been added to it. */
void mlrt_merge_bins(const struct mlrt_bvh_bins *bins, struct mlrt_bvh_bins *sum);

/* Sets *split to the cheapest split of a set between its bins, BY_BIN. */
void mlrt_choose_split(const struct mlrt_bvh_build *build, const struct mlrt_bvh_bins *bins,
                       const struct mlrt_bvh_set *set, struct mlrt_bvh_split *split);

/*
 * Orders the references of a set by sides, lower ones first, and sets `sides`; by rank or by bin. If the call is
 * cancelled meanwhile, the set still has the same references, in any order.
 */
void mlrt_apply_bvh_split(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set,
                          const struct mlrt_bvh_split *split, struct mlrt_bvh_set sides[2]);

/* ---- spatial_split.c ------------------------------------------------------------------------------------------- */

/*
 * Adds `count` references, from `first` on, to bins of a set whose box is `box`: to each bin the part of the triangle
 * that lies in it, of which the bounds are estimated. If the call is cancelled, not all of them.
 */
void mlrt_fill_slabs(const struct mlrt_triangle *triangles, float unit, const struct mlrt_quad_box *references,
                     uint32_t first, uint32_t count, const struct mlrt_quad_box *box, struct mlrt_progress *progress,
                     struct mlrt_bvh_bins *bins);

/* Sets *split to the cheapest plane between such bins that has at most `spare` references on both sides. */
void mlrt_choose_plane(const struct mlrt_bvh_build *build, const struct mlrt_bvh_bins *bins, uint32_t count,
                       uint32_t spare, struct mlrt_bvh_split *split);

/*
 * Splits a set in place, and sets `sides`. There must be room for split->count[0] + split->count[1] references from
 * set->first on. A reference on both sides stays whole, on one side, where that is cheaper. The upper side lies behind
 * the lower one, possibly with a gap; one side can be empty. If the call is cancelled meanwhile, the references are
 * undefined.
 */
void mlrt_apply_spatial_split(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set,
                              const struct mlrt_bvh_split *split, struct mlrt_bvh_set sides[2]);

/* ---- cut.c ----------------------------------------------------------------------------------------------------- */

/* Cuts a portion in two and returns 1. Returns 0 if the portion becomes a leaf, or the call is cancelled. */
int mlrt_cut_portion(struct mlrt_bvh_build *build, struct mlrt_portion *portion, struct mlrt_portion sides[2]);

/* ---- collapse.c ------------------------------------------------------------------------------------------------ */

/* Sets choices and costs of a binary node without children, of 1 to 16 triangles. */
void mlrt_choose_leaf(const struct mlrt_bvh_build *build, struct mlrt_binary_node *node,
                      struct mlrt_slot_costs *result);

/* Sets choices and costs of a binary node with two children, from the costs of these. */
void mlrt_choose_cut(const struct mlrt_bvh_build *build, const struct mlrt_slot_costs children[2],
                     struct mlrt_binary_node *node, struct mlrt_slot_costs *result);

/* ---- binary.c -------------------------------------------------------------------------------------------------- */

/* Builds the binary hierarchy over all references, and chooses what its nodes become. Returns a status. */
int32_t mlrt_build_binary(struct mlrt_bvh_build *build);

/* ---- write.c --------------------------------------------------------------------------------------------------- */

/* Allocates tree->bvh and writes all of it; sets tree->info.depth. Returns a status. */
int32_t mlrt_write_hierarchy(struct mlrt_bvh_build *build);

#endif
