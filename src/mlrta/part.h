/* SPDX-License-Identifier: MIT */
/* A build of the kd-tree while it goes on: cells that are to be built, the parts that it is cut into, their memory. */
#ifndef MLRT_MLRTA_PART_H
#define MLRT_MLRTA_PART_H

#include <pthread.h>

#include "base/platform.h"
#include "base/progress.h"
#include "mlrta/kdtree.h"
#include "mlrta/split.h"

struct mlrt_preset {
    struct mlrt_cost_model model;
    double minimum_cell; /* rule 3: cells of less than this part of the scene's surface area are not split */
};

struct mlrt_kdtree_settings {
    struct mlrt_preset preset;
    uint32_t rules_off;
    uint32_t depth_limit;
    uint64_t reference_limit;
    mlrt_pool *pool;
};

struct mlrt_growing_array {
    void *elements;
    size_t capacity;
};

/* The parts that a build is cut into. */
struct mlrt_kdtree_parts {
    struct mlrt_growing_array all; /* struct mlrt_kdtree_part */
    uint32_t count;
    uint32_t first; /* the first that the workers take in this round */
    size_t size;    /* cells of more references than this are cut into parts */
};

/* What the workers of a call share. Only one at a time allocates or frees. */
struct mlrt_kdtree_build {
    struct mlrt_memory *memory;
    pthread_mutex_t memory_mutex;
    const struct mlrt_triangle *triangles;
    struct mlrt_kdtree_settings settings;
    double scene_area;
    float tiny; /* as in mlrt_clip_halves */
    struct mlrt_progress *progress;
    struct mlrt_kdtree_parts parts;
};

/* A cell to be built. Its references are those of its part from `first` to `first + count`, the last of all. */
struct mlrt_kdtree_cell {
    struct mlrt_box box;
    uint32_t node;
    uint32_t depth;
    uint32_t bad_refinement_count;
    size_t first;
    size_t count;
    uint64_t reference_limit; /* entries that the leaves of this cell may have in all; at least `count` */
    double work;              /* its share of the progress of the build */
    double cost;              /* expected for a ray through it: set when its subtree is built */
};

/* A subtree that one worker builds. */
struct mlrt_kdtree_subtree {
    struct mlrt_growing_array references; /* struct mlrt_reference: of siblings that wait, then of the current cell */
    struct mlrt_growing_array nodes;      /* struct mlrt_node */
    struct mlrt_growing_array entries;    /* uint32_t */
    struct mlrt_growing_array scratch;    /* double: to look for planes and to sort */
    uint32_t node_count;
    uint32_t node_limit;
    uint32_t entry_count;
    uint64_t retracted_count;
};

/* A part of the tree: a cell that is cut in two, or a subtree. All 0 = not used. */
struct mlrt_kdtree_part {
    struct mlrt_kdtree_build *build;
    struct mlrt_kdtree_cell cell; /* of its root */
    uint32_t lower;          /* number of the part that has its lower side; the upper side has the next; 0 = not cut */
    struct mlrt_split split; /* if it is cut */
    struct mlrt_kdtree_subtree built; /* if it is not */
};

/* ---- part.c ---------------------------------------------------------------------------------------------------- */

/* Changes the number of elements of `size` bytes and keeps the contents. Returns 0 if there is no memory. */
int mlrt_set_room(struct mlrt_kdtree_build *build, struct mlrt_growing_array *array, size_t count, size_t size);

/* Makes room for `needed` elements. Returns 0 if there is no memory. */
int mlrt_make_room(struct mlrt_kdtree_build *build, struct mlrt_growing_array *array, size_t needed, size_t size);

void mlrt_release_room(struct mlrt_kdtree_build *build, struct mlrt_growing_array *array, size_t size);

MLRT_INLINE struct mlrt_kdtree_part *mlrt_part_at(const struct mlrt_kdtree_build *build, uint32_t number)
{
    return (struct mlrt_kdtree_part *)build->parts.all.elements + number;
}

MLRT_INLINE struct mlrt_reference *mlrt_reference_at(const struct mlrt_kdtree_part *part, size_t index)
{
    return (struct mlrt_reference *)part->built.references.elements + index;
}

MLRT_INLINE struct mlrt_node *mlrt_node_at(const struct mlrt_kdtree_part *part, uint32_t index)
{
    return (struct mlrt_node *)part->built.nodes.elements + index;
}

MLRT_INLINE uint32_t *mlrt_entry_at(const struct mlrt_kdtree_part *part, uint32_t index)
{
    return (uint32_t *)part->built.entries.elements + index;
}

MLRT_INLINE int mlrt_rule_is_on(const struct mlrt_kdtree_build *build, uint32_t rule)
{
    return (build->settings.rules_off & rule) == 0;
}

/* ---- cell.c ---------------------------------------------------------------------------------------------------- */

/* What becomes of a cell. FAILED: there is no memory, or the call is cancelled. */
enum mlrt_choice { MLRT_CHOICE_FAILED, MLRT_CHOICE_LEAF, MLRT_CHOICE_SPLIT };

/* Cuts a cell in two, if that pays. A large cell advances the progress by the work of one of the levels below it. */
enum mlrt_choice mlrt_cut_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell, struct mlrt_split *split,
                               struct mlrt_kdtree_cell sides[2]);

/* Adds the children of a node, and sets *first_child to the lower one. Returns 0 if there is no memory. */
int mlrt_add_children(struct mlrt_kdtree_part *part, uint32_t node, const struct mlrt_split *split,
                      uint32_t *first_child);

/*
 * Ends the subtree of a cell, whose sides are built: sets its cost, and if it does not pay, one leaf replaces it. Its
 * entries are those from `offset` on. Returns 0 if there is no memory.
 */
int mlrt_close_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell, const struct mlrt_kdtree_cell *below,
                    const struct mlrt_kdtree_cell *above, uint32_t offset);

/*
 * Builds the subtree of a cell, sets its cost, and overwrites its references. Returns 0 if there is no memory, or the
 * call is cancelled.
 */
int mlrt_build_cell(struct mlrt_kdtree_part *part, struct mlrt_kdtree_cell *cell);

#endif
