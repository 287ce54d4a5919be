/* SPDX-License-Identifier: MIT */
/*
 * The tree as a whole: the scene's triangles, and the structure over them, a hierarchy of boxes (bvh/node.h) or a kd-tree
 * (mlrta/kdtree.h).
 *
 * Triangles keep the order of the input: triangle i of mesh m has the number mesh_first[m] + i everywhere in the
 * library, so comparing numbers is the tie order of the hit rule. Triangles that were left out are stored too, but no
 * leaf names them.
 */
#ifndef MLRT_SCENE_TREE_H
#define MLRT_SCENE_TREE_H

#include "base/memory.h"
#include "exact/triangle.h"
#include "mlrt.h"

/* bvh/node.h */
struct mlrt_bvh_node;

/* mlrta/kdtree.h */
struct mlrt_node;

/* The hierarchy of boxes: what its arrays hold is said there. */
struct mlrt_bvh {
    struct mlrt_bvh_node *nodes;
    uint32_t node_count;
    uint32_t quad_count;
    float *corners;        /* 36 * quad_count + 16 */
    uint32_t *numbers;     /* 4 * quad_count + 16 */
    float unit;            /* what coordinates of boxes and corners were multiplied with: unit.h */
    struct mlrt_box whole; /* of all triangles, in units */
    struct mlrt_box core;  /* where most are, as a guess: no answer depends on it */
};

struct mlrt_tree {
    struct mlrt_memory memory;
    struct mlrt_triangle *triangles;
    uint32_t triangle_count;
    uint32_t mesh_count;
    uint32_t *mesh_ids;   /* mesh_count: as reported */
    uint32_t *mesh_first; /* mesh_count + 1: number of the first triangle of each mesh, ascending */
    uint32_t *mesh_by_id; /* mesh_count: positions in the order of their ids */
    uint32_t *masks;      /* triangle_count: that of each one's mesh; NULL if all of them have all bits */
    int borrowed;         /* 1 = all arrays are someone else's, and stay: save.c */
    struct mlrt_node *nodes;
    uint32_t node_count; /* of a kd-tree, where it is at least 1; else 0 */
    uint32_t *references;
    uint32_t reference_count;
    struct mlrt_box bounds; /* of all triangles in the tree: exact, nothing is rounded. All 0 if there is none */
    struct mlrt_bvh bvh;    /* node_count 0 in a kd-tree, or without triangles */
    uint32_t structure;     /* MLRT_STRUCTURE_* */
    int float_safe;         /* 1 = every split plane and every bound is mlrt_is_float_safe */
    mlrt_tree_info info;
};

/* Can float carry the bounds? */
int mlrt_has_safe_bounds(const struct mlrt_tree *tree);

/* 1 if no leaf may name the triangle. The counts of those left out, in tree->info, must be right. */
int mlrt_is_left_out(const struct mlrt_tree *tree, uint32_t number);

#endif
