/* SPDX-License-Identifier: MIT */
/*
 * The triangles of a leaf as a bundle sees them (bundle.h): what edge functions and distances are made from, how far
 * they are off, and the set-ups of leaves. Hulls are compared with them in hull_triangles.h and cover.h, rays in
 * packet_tests.h. L5, L6, ... are the lemmas of docs/accuracy.md, "Bundles", which derive the bounds.
 *
 * WHAT IS COMPUTED. Vectors have the components depth, j and l (bundle.h). Let p and q be the ends of an edge relative
 * to the waist w, and g = q - p; let o be the origin of a ray relative to the waist. The ray is at x = (0, x_j, x_l) at
 * depth 0, and goes along d = (1, s_j, s_l). Then
 *
 *     e = d . ((p - x) x g) = C_z + s_j C_j + s_l C_l - x_j g_l + x_l g_j + m g_z,    C = p x g,  m = s_l x_j - s_j x_l
 *     D = d . n = n_z + s_j n_j + s_l n_l,                                            n = (a - c) x (b - a)
 *     N = n . (a - w) - n . o                                                         so tau = N / D
 *
 * Only the signs of e and the ratios of N to D matter. So each edge function is divided by a size of its own, and so is
 * n. With M_k the sum of the magnitudes of the two products in component k of the cross product, the size is
 * M_z + (M_j + M_l) / 2. The size of an edge function is at least |g| 2^-20, where |g| is the sum of the magnitudes of
 * the components of g. All sizes are at least 2^-100.
 *
 * EDGES, u = 2^-24, in units of size. R, A, X of a packet and E, the error of an intercept, are defined in ray_terms.h;
 * rho is the greatest |g| / size of the three edges. The magnitudes of all terms with C sum to at most R times the
 * size: this is why edges are divided by it, and one R serves for all of them. By L5 e is off by no more than
 *
 *     13.001 u R + (8.1 u X + 1.01 E) R rho + 2^-48 R.
 *
 * EDGE_ERROR makes 14 u R of the first term. BLUR_OF_INTERCEPT, INTERCEPT_ERROR and INTERCEPT_FLOOR make 13 u X + 4 u R
 * A + 2^-110 of the bracket. The difference covers the last term, and the roundings of the bound itself. If all rays
 * start at the waist, 14 u R is enough. Where a processor multiplies and adds at once, there are fewer roundings.
 *
 * DISTANCES. By L6 D is off by 10.001 u R. Let F be the greatest of |z|, 2 |x_j|, 2 |x_l| of corner a relative to the
 * waist: F is for a what A is for origins. By L7 N is off by 13.001 u (F + A). PLANE_BOUND is 16 u R, and
 * DISTANCE_ERROR 16 u (F + A). They leave 5.9 u R and 2.9 u (F + A): for the roundings when N and D are moved by their
 * bounds, and for those of the products that compare quotients (L8), as in triangle_filter.h.
 *
 * UNDERFLOW AND RANGE. Corners and origins are at most 2^60 and may be denormal; of directions only the slopes matter,
 * which are at most 2. Sums and differences of denormals are exact. A product in C or n may lose 2^-150, but is divided
 * by a size of at least 2^-100, and a coefficient is multiplied by a term of at most 2^65: so an edge function and D
 * lose less than 2^-48 R, which is negligible beside u R. In the same way N loses less than 2^-47 (F + A), and in its
 * products with o 2^-147 more, which DISTANCE_FLOOR covers. Sizes are at most 2^124, so 1 / size is normal; and as
 * size >= |g| 2^-20, no edge function exceeds 2^87.
 *
 * FROM THE WAIST (L17). For rays that start at the waist, o = 0, so N is the same for all. All coefficients of a
 * triangle are negated if N as computed is negative. If it is not above its bound, DISTANCE_ERROR F + DISTANCE_FLOOR,
 * the judge determines the sign of N. With the waist's sign +1 this is the opposite of the sign of the side of the
 * plane on which the waist lies (mlrt_side_of_plane). With -1 it is the sign of that side, since the triangle is
 * mirrored. With N > 0, a hit has D > 0 and no negative edge function.
 */
#ifndef MLRT_TRACE_LEAF_H
#define MLRT_TRACE_LEAF_H

#include <stddef.h>
#include <string.h>

#include "hits/triangle_filter.h"
#include "scene/masks.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/leaf_in_double.h"
#include "trace/outline.h"

#define DISTANCE_ERROR (MLRT_GUESS ? 0 : 16 * 0x1p-24f)

/*
 * The corners of a vector of triangles: axis 0 is the main axis, with the sign of the waist, the other two follow it.
 * `from` has the corners in the coordinates of the leaf but for that sign, `to` has them relative to the waist.
 */
struct bundle_corners {
    vf from[3][3];
    vf to[3][3];
};

MLRT_INLINE void load_bundle_corners(const struct mlrt_waist *waist, const float *corners, uint32_t row, uint32_t v,
                                     struct bundle_corners *of)
{
    const vf sign = v_set1(waist->sign);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int axis = (waist->main_axis + k) % 3;
        const vf w = v_set1(waist->point[axis]);
        MLRT_UNROLL
        for (int i = 0; i < 3; ++i) {
            const vf c = v_load_any(corners + (uint32_t)(3 * i + axis) * row + v);
            of->from[i][k] = k == 0 ? v_flip(c, sign) : c;
            of->to[i][k] = k == 0 ? v_flip(v_sub(c, w), sign) : v_sub(c, w);
        }
    }
}

/* Sets `cross` to p x q. Returns its size, or `least` if that is more. */
MLRT_INLINE vf cross_with_size(const vf p[3], const vf q[3], vf least, vf cross[3])
{
    vf size[3];
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const vf second = v_mul(p[j], q[i]);
        cross[k] = v_mul_sub(p[i], q[j], second);
        size[k] = v_mul_add(v_abs(p[i]), v_abs(q[j]), v_abs(second));
    }
    return v_max(v_mul_add(v_add(size[1], size[2]), v_set1(0.5f), size[0]), least);
}

/* Sets the coefficients of a vector of triangles. */
MLRT_INLINE void set_up_vector_by(const struct bundle_corners *corners, uint32_t v, int has_intercepts,
                                  struct mlrt_bundle_leaf *leaf)
{
    vf g[3][3], normal[3], steepness = v_set1(0);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        MLRT_UNROLL
        for (int i = 0; i < 3; ++i) g[i][k] = v_sub(corners->from[(i + 1) % 3][k], corners->from[i][k]);
    }
    const vf scale = v_div(v_set1(1), cross_with_size(g[2], g[0], v_set1(SMALLEST_SIZE), normal));
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) normal[k] = v_mul(normal[k], scale);
    const vf distance = dot_product(corners->to[0], normal);
    const vf other = v_max(v_abs(corners->to[0][1]), v_abs(corners->to[0][2]));
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) v_store(leaf->planes.normal[k] + v, v_flip(normal[k], distance));
    v_store(leaf->planes.distance + v, v_abs(distance));
    v_store(leaf->planes.away + v, v_max(v_abs(corners->to[0][0]), v_mul(other, v_set1(2))));
    leaf->state.flipped |= m_bits(v_lt(v_flip(v_set1(1), distance), v_set1(0))) << v;
    MLRT_UNROLL
    for (int i = 0; i < 3; ++i) {
        vf cross[3];
        const vf length = v_add(v_add(v_abs(g[i][0]), v_abs(g[i][1])), v_abs(g[i][2]));
        const vf least = v_max(v_mul(length, v_set1(0x1p-20f)), v_set1(SMALLEST_SIZE));
        const vf size = v_div(v_set1(1), cross_with_size(corners->to[i], g[i], least, cross)),
                 factor = v_flip(size, distance);
        v_store(leaf->edges.constant[i] + v, v_mul(cross[0], factor));
        v_store(leaf->edges.coefficient[i][MLRT_SLOPE_J] + v, v_mul(cross[1], factor));
        v_store(leaf->edges.coefficient[i][MLRT_SLOPE_L] + v, v_mul(cross[2], factor));
        if (!has_intercepts) continue;
        v_store(leaf->edges.coefficient[i][MLRT_INTERCEPT_J] + v, v_sub(v_set1(0), v_mul(g[i][2], factor)));
        v_store(leaf->edges.coefficient[i][MLRT_INTERCEPT_L] + v, v_mul(g[i][1], factor));
        v_store(leaf->edges.coefficient[i][MLRT_MOMENT] + v, v_mul(g[i][0], factor));
        steepness = v_max(v_mul(length, size), steepness);
    }
    v_store(leaf->edges.steepness + v, steepness);
}

/* The places where float does not tell the sign of N at the waist. */
MLRT_INLINE uint32_t doubtful_places(const struct mlrt_bundle_leaf *leaf)
{
    uint32_t doubtful = 0;
    for (int v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        if (!(leaf->state.there >> v & ALL_LANES)) continue;
        const vf bound = v_mul_add(v_load(leaf->planes.away + v), v_set1(DISTANCE_ERROR), v_set1(DISTANCE_FLOOR));
        doubtful |= (~m_bits(v_gt(v_load(leaf->planes.distance + v), bound)) & ALL_LANES) << v;
    }
    return doubtful & leaf->state.there;
}

/* Returns the main axis, or ~axis if rays go down it. */
MLRT_INLINE int32_t axis_code(const struct mlrt_waist *waist)
{
    return waist->sign < 0 ? ~waist->main_axis : waist->main_axis;
}

/* Begins the set-up of a leaf: finds the places that have a triangle, and sets their outlines. */
static MLRT_NOINLINE void begin_bundle_leaf(const struct mlrt_tree *tree, const struct mlrt_waist *waist,
                                            int has_intercepts, uint32_t child, uint32_t mask,
                                            struct mlrt_bundle_leaf *leaf)
{
    const uint32_t row = 4 * mlrt_bvh_quad_count(child);
    leaf->corners = tree->bvh.corners + 36 * (size_t)mlrt_bvh_offset(child);
    leaf->numbers = tree->bvh.numbers + 4 * (size_t)mlrt_bvh_offset(child);
    leaf->axis = axis_code(waist);
    leaf->row = row;
    leaf->has_intercepts = has_intercepts;
    leaf->state.there = leaf->state.flipped = leaf->state.ready = leaf->state.fans = leaf->state.doubtful =
        leaf->state.odd = 0;
    for (uint32_t v = 0; v < row; v += VW) {
        struct bundle_corners of;
        const uint32_t in_row = 0xFFFFu >> (MLRT_BVH_LEAF_LIMIT - row) >> v & ALL_LANES;
        const uint32_t there = in_row & ~m_bits(i_eq(i_load_any(leaf->numbers + v), i_set1(MLRT_NONE)));
        load_bundle_corners(waist, leaf->corners, row, v, &of);
        set_outlines(waist, (const vf(*)[3])of.to, there, v, leaf);
        leaf->state.there |= there << v;
        leaf->state.odd |= (there & ~m_bits(v_eq(of.from[0][0], of.from[0][0]))) << v;
    }
    if (MLRT_UNLIKELY(leaf->state.odd != 0)) mlrt_set_odd_outlines(tree, waist, leaf);
    if (MLRT_UNLIKELY(mask != MLRT_MASK_ALL))
        leaf->state.there = mlrt_visible_places(tree, leaf->numbers, leaf->state.there, mask);
    leaf->state.from_waist = leaf->state.there;
}

/* Sets the coefficients of the triangles `wanted`, and of those that share a vector with them. */
static MLRT_NOINLINE void set_up_triangles(const struct mlrt_tree *tree, const struct mlrt_waist *waist,
                                           uint32_t wanted, struct mlrt_bundle_leaf *leaf)
{
    uint32_t now = 0;
    for (uint32_t v = 0; v < leaf->row; v += VW) {
        if (!((wanted & ~leaf->state.ready) >> v & ALL_LANES)) continue;
        struct bundle_corners of;
        load_bundle_corners(waist, leaf->corners, leaf->row, v, &of);
        if (leaf->has_intercepts) {
            set_up_vector_by(&of, v, 1, leaf);
        } else {
            set_up_vector_by(&of, v, 0, leaf);
        }
        now |= ALL_LANES << v;
    }
    if (MLRT_UNLIKELY((leaf->state.odd & now) != 0)) {
        mlrt_set_up_odd_triangles(tree, waist, leaf->state.odd & now, leaf);
    }
    leaf->state.ready |= now;
    leaf->state.doubtful |= doubtful_places(leaf) & now;
}

/* The triangle at a place, as it was given, read from the leaf: where its number lies is seldom in the cache. */
static MLRT_NOINLINE struct mlrt_triangle triangle_of_leaf(const struct mlrt_tree *tree,
                                                           const struct mlrt_bundle_leaf *leaf, uint32_t place)
{
    const struct mlrt_corners from = {leaf->corners + place, leaf->row, 1};
    if (MLRT_UNLIKELY(leaf->state.odd >> place & 1)) return mlrt_triangle_at(&tree->by_number, leaf->numbers[place]);
    return mlrt_triangle_of(&from, 1 / tree->bvh.unit);
}

/* The entry of a cache that may have the set-up of a leaf. */
MLRT_INLINE uint32_t place_of_leaf(uint32_t child, const struct mlrt_bundle_cache *cache)
{
    return mlrt_bvh_offset(child) * 0x9E3779B1u >> (32 - cache->bits);
}

/* Is the set-up of a leaf, for this bundle, in the cache? */
MLRT_INLINE int has_bundle_leaf(const struct mlrt_bundle *bundle, uint32_t child)
{
    const uint32_t place = place_of_leaf(child, bundle->cache);
    const struct mlrt_bundle_leaf *leaf = &bundle->cache->leaves[place];
    return bundle->cache->children[place] == child && leaf->axis == axis_code(&bundle->waist) &&
           leaf->has_intercepts >= bundle->has.intercepts;
}

/*
 * Returns the set-up of a leaf, from the cache if it is there. Sets *seen to the triangles that the bundle may hit:
 * these have coefficients. A worker keeps the last set-ups, since neighbouring tiles see the same leaves from one
 * waist.
 */
MLRT_INLINE const struct mlrt_bundle_leaf *find_bundle_leaf(const struct mlrt_job *job,
                                                            const struct mlrt_bundle *bundle, uint32_t child,
                                                            const struct mlrt_worker *worker, uint32_t *seen)
{
    const int has_intercepts = bundle->has.intercepts;
    struct mlrt_bundle_cache *cache = bundle->cache;
    const uint32_t place = place_of_leaf(child, cache);
    struct mlrt_bundle_leaf *leaf = &cache->leaves[place];
    if (!has_bundle_leaf(bundle, child)) {
        begin_bundle_leaf(job->tree, &bundle->waist, has_intercepts, child, worker->mask, leaf);
        cache->children[place] = child;
    }
    *seen = outlines_met(bundle, leaf, &bundle->whole, has_intercepts,
                         has_intercepts ? leaf->state.there : leaf->state.from_waist);
    if (*seen & ~leaf->state.ready) set_up_triangles(job->tree, &bundle->waist, *seen & ~leaf->state.ready, leaf);
    if (MLRT_UNLIKELY(leaf->state.doubtful != 0) && !has_intercepts) {
        mlrt_settle_signs(job->tree, &bundle->waist, leaf);
        *seen &= leaf->state.from_waist;
    }
    return leaf;
}

/*
 * Makes `waist` that of the cache, and drops set-ups for another point or another slope. Those for another main axis
 * stay: each has its axis (has_bundle_leaf).
 */
static void keep_bundle_waist(const struct mlrt_waist *waist, struct mlrt_bundle_cache *cache)
{
    const size_t first = offsetof(struct mlrt_waist, point), size = sizeof *waist - first;
    if (memcmp(waist, &cache->waist, sizeof *waist) == 0) return;
    if (memcmp((const char *)waist + first, (const char *)&cache->waist + first, size) != 0 ||
        cache->waist.main_axis < 0) {
        memset(cache->children, 0, sizeof cache->children);
    }
    cache->waist = *waist;
    if (cache->waist_count++ == 0) memset(cache->lines, 0, sizeof cache->lines);
}

#endif
