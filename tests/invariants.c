/* SPDX-License-Identifier: MIT */
/*
 * Whole trees against their invariants: see invariants.h.
 */
#include "invariants.h"

#include "bvh/node.h"
#include "mlrta/kdtree.h"

/* ---- points of triangles ---- */

/* Sets *sum to a + b. Returns 1 if that is exact. */
static int add_exactly(double a, double b, double *sum)
{
    *sum = a + b;
    double b_part = *sum - a, a_part = *sum - b_part;
    return (a - a_part) + (b - b_part) == 0;
}

/*
 * Sets `point` to the sum of the vertices times weight / 16; the products are exact. Returns 1 if the sum is exact too.
 */
static int find_check_point(const struct mlrt_triangle *triangle, const int weight[3], double point[3])
{
    for (int k = 0; k < 3; k++) {
        double a = triangle->v[0][k] * (weight[0] / 16.0), b = triangle->v[1][k] * (weight[1] / 16.0),
               c = triangle->v[2][k] * (weight[2] / 16.0);
        if (!add_exactly(a, b, &point[k]) || !add_exactly(point[k], c, &point[k])) return 0;
    }
    return 1;
}

/* Sixteenths of the vertices. */
static const int WEIGHTS[][3] = {{16, 0, 0}, {0, 16, 0}, {0, 0, 16}, {8, 8, 0},  {0, 8, 8},  {8, 0, 8},
                                 {4, 4, 8},  {4, 8, 4},  {8, 4, 4},  {1, 15, 0}, {3, 0, 13}, {0, 11, 5}};

/* ---- boxes ---- */

static int leaf_holds(const struct mlrt_bvh *bvh, uint32_t child, uint32_t triangle)
{
    const uint32_t *numbers = bvh->numbers + 4 * (size_t)mlrt_bvh_offset(child);
    for (uint32_t i = 0; i < 4 * mlrt_bvh_quad_count(child); i++)
        if (numbers[i] == triangle) return 1;
    return 0;
}

/*
 * 1 if a leaf below the node holds the triangle, and its box and the boxes above it contain the point. At most 33 calls
 * deep.
 */
static int is_in_boxes(const struct mlrt_bvh *bvh, uint32_t number, uint32_t triangle, const double point[3])
{
    const struct mlrt_bvh_node *node = &bvh->nodes[number];
    for (int i = 0; i < MLRT_BVH_WIDTH && node->child[i] != 0; i++) {
        int inside = 1;
        for (int k = 0; k < 3; k++) inside = inside && node->lo[k][i] <= point[k] && point[k] <= node->hi[k][i];
        if (!inside) continue;
        if (mlrt_bvh_quad_count(node->child[i]) != 0
                ? leaf_holds(bvh, node->child[i], triangle)
                : is_in_boxes(bvh, mlrt_bvh_offset(node->child[i]), triangle, point))
            return 1;
    }
    return 0;
}

static const char *check_in_boxes(const struct mlrt_tree *tree, uint32_t number)
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    for (size_t i = 0; i < sizeof WEIGHTS / sizeof WEIGHTS[0]; i++) {
        double point[3], in_units[3];
        if (!find_check_point(&triangle, WEIGHTS[i], point)) continue;
        for (int k = 0; k < 3; k++) {
            in_units[k] = point[k] * tree->bvh.unit;
            if (!(tree->bounds.lo[k] <= point[k] && point[k] <= tree->bounds.hi[k]))
                return "a triangle is outside of the bounds";
        }
        if (!is_in_boxes(&tree->bvh, 0, number, in_units))
            return "B3: a point of a triangle is in no leaf that holds it";
    }
    return NULL;
}

const char *check_bvh(const struct mlrt_tree *tree)
{
    const char *wrong = mlrt_check_boxes(tree);
    for (uint32_t i = 0; wrong == NULL && i < tree->triangle_count; i++) {
        if (mlrt_is_left_out(tree, i)) continue;
        if (tree->bvh.node_count == 0) return "B1: there are triangles, but no nodes";
        wrong = check_in_boxes(tree, i);
    }
    return wrong;
}

/* ---- kd-tree ---- */

static int leaf_refers_to(const struct mlrt_tree *tree, const struct mlrt_node *leaf, uint32_t triangle)
{
    uint32_t first = leaf->u.offset, last = first + mlrt_leaf_count(leaf);
    while (first < last) {
        uint32_t middle = first + (last - first) / 2;
        if (tree->kdtree.references[middle] < triangle)
            first = middle + 1;
        else
            last = middle;
    }
    return first < leaf->u.offset + mlrt_leaf_count(leaf) && tree->kdtree.references[first] == triangle;
}

static int is_in_leaves(const struct mlrt_tree *tree, uint32_t triangle, const double point[3])
{
    uint32_t waiting[MLRT_DEPTH_LIMIT + 2];
    uint32_t count = 1;
    waiting[0] = 0;
    while (count > 0) {
        const struct mlrt_node *node = &tree->kdtree.nodes[waiting[--count]];
        if (mlrt_node_is_leaf(node)) {
            if (leaf_refers_to(tree, node, triangle)) return 1;
            continue;
        }
        double x = point[mlrt_node_axis(node)];
        if (x >= node->u.split) waiting[count++] = mlrt_node_child(node) + 1;
        if (x <= node->u.split) waiting[count++] = mlrt_node_child(node);
    }
    return 0;
}

static int is_inside(const struct mlrt_box *box, const struct mlrt_triangle *triangle)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            if (!(box->lo[k] <= triangle->v[i][k] && triangle->v[i][k] <= box->hi[k])) return 0;
    return 1;
}

static const char *check_in_leaves(const struct mlrt_tree *tree, uint32_t number)
{
    const struct mlrt_triangle *triangle = &tree->triangles[number];
    if (!is_inside(&tree->bounds, triangle)) return "a triangle is outside of the bounds";
    for (size_t i = 0; i < sizeof WEIGHTS / sizeof WEIGHTS[0]; i++) {
        double point[3];
        if (find_check_point(triangle, WEIGHTS[i], point) && !is_in_leaves(tree, number, point))
            return "I3: a point of a triangle is in no leaf that refers to it";
    }
    return NULL;
}

const char *check_kdtree(const struct mlrt_tree *tree)
{
    const char *wrong = mlrt_check_nodes(tree);
    for (uint32_t i = 0; wrong == NULL && i < tree->triangle_count; i++)
        if (!mlrt_is_left_out(tree, i)) wrong = check_in_leaves(tree, i);
    return wrong;
}
