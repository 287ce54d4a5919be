/* SPDX-License-Identifier: MIT */
/*
 * The tree as a whole: the triangles of the scene, and the structure over them, a hierarchy of boxes (bvh/node.h) or a
 * kd-tree (mlrta/kdtree.h).
 *
 * Triangles keep the order of the input: triangle i of mesh m has the number meshes.first[m] + i everywhere in the
 * library, so the order of numbers is the order of ties in the hit rule. Triangles that are left out (not finite, or
 * without area) are stored too, but no leaf holds them. A kd-tree keeps an array of the triangles. In a hierarchy of
 * boxes the leaves have them already (bvh/node.h).
 */
#ifndef MLRT_SCENE_TREE_H
#define MLRT_SCENE_TREE_H

#include "base/memory.h"
#include "exact/predicate.h"
#include "exact/triangle.h"
#include "mlrt.h"

/* job/structure.h */
struct mlrt_structure;

/* bvh/node.h */
struct mlrt_bvh_node;

/* mlrta/kdtree.h */
struct mlrt_node;

/* The hierarchy of boxes. bvh/node.h describes its arrays. A file has `unit` and `leaf_quad_count` as they lie here. */
struct mlrt_bvh {
    struct mlrt_bvh_node *nodes;
    uint32_t node_count;      /* 0 without triangles */
    uint32_t quad_count;      /* of leaves, and behind them of triangles that no leaf has as they were given */
    float *corners;           /* 36 * quad_count + 16 */
    uint32_t *numbers;        /* 4 * quad_count + 16 */
    uint32_t *places;         /* of all triangles, mlrt_pack_place; NULL = tree->triangles has them */
    float unit;               /* the factor of the coordinates of boxes and corners: bvh/unit.h; 0 in a kd-tree */
    uint32_t leaf_quad_count; /* quads of leaves: the first ones */
    float reach;              /* from where float tells boxes apart, in units: reach.h */
    struct mlrt_box whole;    /* bounds of all triangles that leaves hold, in units */
    struct mlrt_box core;     /* estimated bounds of most of them, in units: no answer depends on it */
    int is_usual;             /* 1 = no triangle can be odd: the unit is 1, and `whole` is within MLRT_SAFE_MAX */
};

/* The kd-tree. mlrta/kdtree.h describes its arrays. */
struct mlrt_kdtree {
    struct mlrt_node *nodes;
    uint32_t node_count; /* at least 1 */
    uint32_t reference_count;
    uint32_t *references;
    int float_safe; /* 1 = every split plane and every bound is mlrt_is_float_safe */
    float reach;    /* from where float tells cells apart: reach.h */
};

/* Mesh m is at position m of the caller's array. */
struct mlrt_mesh_table {
    uint32_t count;
    uint32_t *ids;   /* count: the ids that results report */
    uint32_t *first; /* count + 1: number of the first triangle of each mesh, ascending */
    uint32_t *by_id; /* count: positions of the meshes in the order of their ids */
};

struct mlrt_tree {
    const struct mlrt_structure *structure;
    struct mlrt_memory memory;
    struct mlrt_triangles by_number; /* how to read a triangle */
    struct mlrt_triangle *triangles; /* triangle_count, in order; NULL = they lie in the hierarchy of boxes */
    uint32_t triangle_count;
    struct mlrt_mesh_table meshes;
    uint32_t *masks;        /* triangle_count: the mask of each triangle's mesh; NULL = all are MLRT_MASK_ALL */
    int borrowed;           /* 1 = all arrays lie in the caller's memory and are not freed (api/save.c) */
    struct mlrt_box bounds; /* of all triangles not left out, not rounded; all 0 if there are none */
    /* The structure's own part; that of the other structure is empty. */
    struct mlrt_bvh bvh;
    struct mlrt_kdtree kdtree;
    mlrt_tree_info info;
};

/* Lets tree->by_number read the triangles where they are: in order, or else by their places. */
static inline void mlrt_find_triangles(struct mlrt_tree *tree)
{
    const struct mlrt_bvh *bvh = &tree->bvh;
    const float *ordered = tree->triangles ? tree->triangles->v[0] : NULL;
    tree->by_number = (struct mlrt_triangles){ordered, NULL, 0, 1};
    if (!ordered && bvh->places)
        tree->by_number = (struct mlrt_triangles){bvh->corners, bvh->places, bvh->leaf_quad_count, 1 / bvh->unit};
}

/* Returns an empty tree, allocated from `memory`, which it keeps; NULL if out of memory. */
struct mlrt_tree *mlrt_allocate_tree(const struct mlrt_structure *structure, const struct mlrt_memory *memory);

/* 1 if rays can hit a triangle. If not, it is left out: counts why. */
static inline int mlrt_keep_triangle(const struct mlrt_triangle *triangle, uint64_t *non_finite_count,
                                     uint64_t *zero_area_count)
{
    const int is_finite = mlrt_triangle_is_finite(triangle);
    if (is_finite && mlrt_triangle_has_area(triangle)) return 1;
    ++*(is_finite ? zero_area_count : non_finite_count);
    return 0;
}

/* 1 if the triangle is left out: no leaf may hold it. tree->info must have the counts of triangles left out. */
int mlrt_is_left_out(const struct mlrt_tree *tree, uint32_t number);

#endif
