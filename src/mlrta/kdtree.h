/* SPDX-License-Identifier: MIT */
/*
 * The kd-tree in memory, with what always holds. check.c verifies it.
 *
 * Triangles keep the order of the input: triangle i of mesh m has the number mesh_first[m] + i everywhere in the
 * library, so comparing numbers is the tie order of the hit rule. Triangles that were left out are stored too, but no
 * leaf names them.
 *
 * Nodes are 8 bytes. The root is nodes[0]; the two children of an inner node are adjacent, the one below the plane
 * first, and the tree lies in depth-first order: all nodes below the first child come before all below the second.
 *
 *   I1. Children lie behind their parent: child > parent. Every node but the root has one parent; node_count is odd.
 *   I2. A cell is a closed box. The root's is `bounds`; a plane x_k = c with lo_k <= c <= hi_k splits a cell into
 *       [lo, hi with hi_k = c] and [lo with lo_k = c, hi]. c == lo_k or c == hi_k makes a cell of zero thickness.
 *   I3. For every triangle that was not left out, and every point p of it, some leaf whose closed cell contains p
 * refers to the triangle. (Not every such leaf: a triangle that only touches a plane is on one side of it.) Here
 *       arithmetic is exact: bounds are rounded outward wherever they are computed.
 *   I4. No path has more than MLRT_DEPTH_LIMIT inner nodes.
 *   I5. The entries of a leaf are ascending triangle numbers, each once.
 */
#ifndef MLRT_KDTREE_H
#define MLRT_KDTREE_H

#include "bvh/node.h"
#include "base/memory.h"
#include "mlrt.h"

#define MLRT_DEPTH_LIMIT 60

struct mlrt_node {
    union {
        float split;     /* inner: the plane x_axis = split */
        uint32_t offset; /* leaf: its first entry in references[] */
    } u;
    uint32_t word; /* inner: (first child << 2) | axis; leaf: (entry count << 2) | 3 */
};

static inline int mlrt_node_is_leaf(const struct mlrt_node *node)
{
    return (node->word & 3) == 3;
}

static inline uint32_t mlrt_node_axis(const struct mlrt_node *node)
{
    return node->word & 3;
}

static inline uint32_t mlrt_node_child(const struct mlrt_node *node)
{
    return node->word >> 2;
}

static inline uint32_t mlrt_leaf_count(const struct mlrt_node *node)
{
    return node->word >> 2;
}

/* Magnitudes that float arithmetic in traversal carries without overflow or loss: these, and 0. */
#define MLRT_SAFE_MIN 0x1p-60f
#define MLRT_SAFE_MAX 0x1p60f

static inline int mlrt_is_float_safe(float a)
{
    float magnitude = a < 0 ? -a : a;
    return a == 0 || (magnitude >= MLRT_SAFE_MIN && magnitude <= MLRT_SAFE_MAX);
}

/* A triangle as stored: the coordinates of a, b, c in turn, bit for bit as given. */
struct mlrt_triangle {
    float v[3][3];
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
    uint32_t node_count; /* at least 1 */
    uint32_t *references;
    uint32_t reference_count;
    struct mlrt_box bounds; /* of all triangles in the tree: exact, nothing is rounded. All 0 if there is none */
    struct mlrt_bvh bvh;    /* node_count 0 without it, or without triangles */
    uint32_t structures;    /* MLRT_STRUCTURE_*: what there is */
    int float_safe;         /* 1 = every split plane and every bound is mlrt_is_float_safe */
    mlrt_tree_info info;
};

#endif
