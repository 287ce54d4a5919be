/* SPDX-License-Identifier: MIT */
/*
 * Odd triangles of a leaf, and signs that float does not tell: see leaf_in_double.h.
 */
#include "trace/leaf_in_double.h"

#include <math.h>

#include "bvh/unit.h"
#include "exact/predicate.h"
#include "trace/planes.h"

void mlrt_set_odd_outlines(const struct mlrt_tree *tree, const struct mlrt_waist *waist, struct mlrt_bundle_leaf *leaf)
{
    const int a = waist->main_axis;
    for (uint32_t odd = leaf->state.odd; odd; odd &= odd - 1) {
        const uint32_t place = mlrt_lowest_bit(odd);
        const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, leaf->numbers[place]);
        double near = INFINITY, far = -INFINITY;
        for (int i = 0; i < 3; ++i) {
            const double depth = (triangle.v[i][a] * (double)tree->bvh.unit - waist->point[a]) * waist->sign;
            near = fmin(depth, near);
            far = fmax(depth, far);
        }
        leaf->outline.near[place] = mlrt_low_bound(near);
        leaf->outline.far[place] = -mlrt_low_bound(-far);
        leaf->outline.weight[place] = 0;
        for (int i = 0; i < 2; ++i) leaf->outline.lo[i][place] = -INFINITY, leaf->outline.hi[i][place] = INFINITY;
    }
    leaf->state.fans &= ~leaf->state.odd;
}

/* Negates all coefficients of the triangle at a place. */
static void flip_triangle(struct mlrt_bundle_leaf *leaf, uint32_t place)
{
    leaf->state.flipped ^= 1u << place;
    leaf->planes.distance[place] = -leaf->planes.distance[place];
    for (int i = 0; i < 3; ++i) {
        leaf->planes.normal[i][place] = -leaf->planes.normal[i][place];
        leaf->edges.constant[i][place] = -leaf->edges.constant[i][place];
        for (int term = 0; term < MLRT_RAY_TERMS; ++term)
            leaf->edges.coefficient[i][term][place] = -leaf->edges.coefficient[i][term][place];
    }
}

/*
 * N at the waist is off by 2^-49 of the sum of its products (planes.h), and by its rounding to float. `away` is set
 * from these two errors and not from F, which may be far larger.
 */
static void set_odd_plane(const struct mlrt_turned_corners *of, uint32_t place, struct mlrt_bundle_leaf *leaf)
{
    struct mlrt_turned_plane plane;
    mlrt_turn_plane(of, &plane);
    const double scale = 1 / mlrt_weigh(plane.size), n = plane.n * scale, error = plane.n_size * scale * 0x1p-49;
    for (int k = 0; k < 3; ++k) leaf->planes.normal[k][place] = (float)(plane.normal[k] * scale);
    leaf->planes.distance[place] = (float)n;
    leaf->planes.away[place] = (float)(fabs(n) + error * 0x1p20);
    leaf->state.flipped &= ~(1u << place);
    if (n < 0) flip_triangle(leaf, place);
}

static void set_up_odd_triangle(const struct mlrt_turned_corners *of, uint32_t place, struct mlrt_bundle_leaf *leaf)
{
    double steepness = 0;
    for (int i = 0; i < 3; ++i) {
        double to[3], along[3], moment[3], size[3];
        float coefficient[MLRT_RAY_TERMS];
        for (int k = 0; k < 3; ++k) {
            to[k] = of->corner[i][k] - of->waist[k];
            along[k] = of->corner[(i + 1) % 3][k] - of->corner[i][k];
        }
        mlrt_cross_with_sizes(to, along, moment, size);
        const double length = mlrt_sum_of_magnitudes(along), scale = 1 / fmax(mlrt_weigh(size), length * 0x1p-20);
        mlrt_scale_edge(moment, along, scale, &leaf->edges.constant[i][place], coefficient);
        for (int term = 0; term < MLRT_RAY_TERMS; ++term) leaf->edges.coefficient[i][term][place] = coefficient[term];
        steepness = fmax(length * scale, steepness);
    }
    leaf->edges.steepness[place] = (float)(steepness * (1 + 0x1p-22));
    set_odd_plane(of, place, leaf);
}

void mlrt_set_up_odd_triangles(const struct mlrt_tree *tree, const struct mlrt_waist *waist, uint32_t odd,
                               struct mlrt_bundle_leaf *leaf)
{
    for (; odd; odd &= odd - 1) {
        const uint32_t place = mlrt_lowest_bit(odd);
        struct mlrt_turned_corners of;
        mlrt_turn_corners(tree, waist, leaf->numbers[place], &of);
        set_up_odd_triangle(&of, place, leaf);
    }
}

void mlrt_settle_signs(const struct mlrt_tree *tree, const struct mlrt_waist *waist, struct mlrt_bundle_leaf *leaf)
{
    float eye[3]; /* the waist, not in units: this division is exact, as the waist is the origin of a ray */
    for (int k = 0; k < 3; ++k) eye[k] = waist->point[k] / tree->bvh.unit;
    for (; leaf->state.doubtful; leaf->state.doubtful &= leaf->state.doubtful - 1) {
        const uint32_t place = mlrt_lowest_bit(leaf->state.doubtful);
        /* With the waist's sign +1, N has the sign of -side. */
        const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, leaf->numbers[place]);
        const int side = mlrt_side_of_plane(&triangle, eye);
        if (side == 0) {
            leaf->state.from_waist &= ~(1u << place);
        } else if ((leaf->state.flipped >> place & 1) != ((side > 0) == (waist->sign > 0))) {
            flip_triangle(leaf, place);
        }
    }
}
