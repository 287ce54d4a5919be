/* SPDX-License-Identifier: MIT */
/*
 * The triangles of a leaf as a bundle sees them (bundle.h): their set-up, and tests of packets against them. L5, L6,
 * ... are the lemmas of docs/accuracy.md, "Bundles", which derive the bounds.
 *
 * WHAT IS COMPUTED. Vectors have the components depth, place j, place l. Let p and q be the ends of an edge relative to
 * the waist w, and g = q - p; let o be the origin of a ray relative to the waist. The ray is at x = (0, x_j, x_l) at
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
 * EDGES, u = 2^-24, in units of size. R, A, X of a packet and E, the error of a place, are defined in ray_hulls.h; rho
 * is the greatest |g| / size of the three edges. The magnitudes of all terms with C sum to at most R times the size:
 * this is why edges are divided by it, and one R serves for all of them. By L5 e is off by no more than
 *
 *     13.001 u R + (8.1 u X + 1.01 E) R rho + 2^-48 R.
 *
 * EDGE_ERROR makes 14 u R of the first term. BLUR_OF_PLACE, PLACE_ERROR and PLACE_FLOOR make 13 u X + 4 u R A + 2^-140
 * of the bracket. The difference covers the last term, and the roundings of the bound itself. If all rays
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
 * CUTS. Over a hull, an edge function lies within its value at the middles of the terms, less and plus the sum of
 * |coefficient| radius. By L11 this interval, as computed, misses the edge function of a ray by at most
 * 14.002 u R + (13.2 u X + 1.01 E) R rho, and that of D misses D by at most 11.1 u R: twice the bound for a single ray
 * is enough for both.
 *
 * FROM THE WAIST (L17). For rays that start at the waist, o = 0, so N is the same for all. All coefficients of a
 * triangle are negated if N as computed is negative. If it is not above its bound, DISTANCE_ERROR F + DISTANCE_FLOOR,
 * the judge determines the sign of N. With the waist's sign +1 this is the opposite of the sign of the side of the
 * plane on which the waist lies (mlrt_side_of_plane). With -1 it is the sign of that side, since the triangle is
 * mirrored. With N > 0, a hit has D > 0 and no negative edge function.
 *
 * BEGINS AND ENDS (L15). Rays begin on surfaces, and end on them. If D has one certain sign, say +1, a ray does not hit
 * the triangle if N < 0, as then t < 0, or if N > t_max D. Both are decided in double, with the determinants and sizes
 * of close_calls.h. N - t_max D has no more than 9 roundings: 8 of N, or 7 of D and 1 of the product, and 1 of the
 * difference. So it is off by 9.001 * 2^-53 of s(N) + t_max s(D), of which CLOSE_ERROR is 12. If t_max is infinite, the
 * latter is not decided: no comparison is true.
 */
#ifndef MLRT_TRACE_LEAF_H
#define MLRT_TRACE_LEAF_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/counters.h"
#include "hits/close_calls.h"
#include "hits/triangle_filter.h"
#include "hits/undecided.h"
#include "job/stop.h"
#include "rays/extremes.h"
#include "rays/slope_limits.h"
#include "scene/masks.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/ray_hulls.h"
#include "trace/outline.h"
#include "trace/leaf_in_double.h"
#include "trace/plane_order.h"
#include "trace/planes.h"

#if MLRT_GUESS
#define EDGE_ERROR     0.0f
#define DISTANCE_ERROR 0.0f
#else
#define EDGE_ERROR     (14 * 0x1p-24f)
#define DISTANCE_ERROR (16 * 0x1p-24f)
#endif

/* ---- set-ups ---- */

/*
 * The corners of a vector of triangles: axis 0 is the main axis, with the sign of the waist, the other two follow it.
 * `from` has the corners as they lie in the leaf, `to` has them relative to the waist.
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
MLRT_INLINE void set_up_vector_by(const struct bundle_corners *corners, uint32_t v, int has_places,
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
        if (!has_places) continue;
        v_store(leaf->edges.coefficient[i][MLRT_PLACE_J] + v, v_sub(v_set1(0), v_mul(g[i][2], factor)));
        v_store(leaf->edges.coefficient[i][MLRT_PLACE_L] + v, v_mul(g[i][1], factor));
        v_store(leaf->edges.coefficient[i][MLRT_MOMENT] + v, v_mul(g[i][0], factor));
        steepness = v_max(v_mul(length, size), steepness);
    }
    v_store(leaf->edges.steepness + v, steepness);
}

static MLRT_NOINLINE void set_up_bundle_vector(const struct bundle_corners *corners, uint32_t v, int has_places,
                                               struct mlrt_bundle_leaf *leaf)
{
    if (has_places) {
        set_up_vector_by(corners, v, 1, leaf);
    } else {
        set_up_vector_by(corners, v, 0, leaf);
    }
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
                                            int has_places, uint32_t child, uint32_t mask,
                                            struct mlrt_bundle_leaf *leaf)
{
    const uint32_t row = 4 * mlrt_bvh_quad_count(child);
    leaf->corners = tree->bvh.corners + 36 * (size_t)mlrt_bvh_offset(child);
    leaf->numbers = tree->bvh.numbers + 4 * (size_t)mlrt_bvh_offset(child);
    leaf->axis = axis_code(waist);
    leaf->row = row;
    leaf->has_places = has_places;
    leaf->state.there = leaf->state.flipped = leaf->state.ready = leaf->state.fans = leaf->state.doubtful =
        leaf->state.odd = 0;
    for (uint32_t v = 0; v < row; v += VW) {
        struct bundle_corners of;
        load_bundle_corners(waist, leaf->corners, row, v, &of);
        set_outlines(waist, (const vf(*)[3])of.to, v, leaf);
        leaf->state.there |= (~m_bits(i_eq(i_load_any(leaf->numbers + v), i_set1(MLRT_NONE))) & ALL_LANES) << v;
        leaf->state.odd |= (~m_bits(v_eq(of.from[0][0], of.from[0][0])) & ALL_LANES) << v;
    }
    leaf->state.there &= 0xFFFFu >> (MLRT_BVH_LEAF_LIMIT - row);
    leaf->state.odd &= leaf->state.there;
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
        set_up_bundle_vector(&of, v, leaf->has_places, leaf);
        now |= (ALL_LANES & 0xFFFF) << v;
    }
    if (MLRT_UNLIKELY((leaf->state.odd & now) != 0)) {
        mlrt_set_up_odd_triangles(tree, waist, leaf->state.odd & now, leaf);
    }
    leaf->state.ready |= now;
    leaf->state.doubtful |= doubtful_places(leaf) & now;
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
           leaf->has_places >= bundle->has.places;
}

/*
 * Returns the set-up of a leaf, from the cache if it is there. Sets *seen to the triangles that the bundle may hit:
 * these have coefficients. A worker keeps the last set-ups, since neighbouring tiles see the same leaves from one
 * waist.
 */
MLRT_INLINE const struct mlrt_bundle_leaf *find_bundle_leaf(const struct mlrt_job *job,
                                                            const struct mlrt_bundle *bundle, int has_places,
                                                            uint32_t child, const struct mlrt_worker *worker,
                                                            uint32_t *seen)
{
    struct mlrt_bundle_cache *cache = bundle->cache;
    const uint32_t place = place_of_leaf(child, cache);
    struct mlrt_bundle_leaf *leaf = &cache->leaves[place];
    if (!has_bundle_leaf(bundle, child)) {
        begin_bundle_leaf(job->tree, &bundle->waist, bundle->has.places, child, worker->mask, leaf);
        cache->children[place] = child;
    }
    struct hull_outline whole;
    outline_whole(bundle, &whole);
    *seen = triangles_met(bundle, leaf, &whole, has_places, has_places ? leaf->state.there : leaf->state.from_waist);
    if (*seen & ~leaf->state.ready) set_up_triangles(job->tree, &bundle->waist, *seen & ~leaf->state.ready, leaf);
    if (MLRT_UNLIKELY(leaf->state.doubtful != 0) && !has_places) {
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

/* ---- cuts ---- */

/* Bounds edge functions, or D, of a vector of triangles over the hull of a packet; rounding errors come on top. */
MLRT_INLINE void bound_over_hull(const struct mlrt_hulls *hulls, uint32_t place, const float *constant,
                                 const float (*coefficient)[MLRT_BVH_LEAF_LIMIT], int term_count, vf *least,
                                 vf *greatest)
{
    vf middle = v_load(constant), radius = v_set1(0);
    MLRT_UNROLL
    for (int i = 0; i < term_count; ++i) {
        const vf c = v_load(coefficient[i]);
        middle = v_mul_add(c, v_set1(hulls->filter.middle[i][place]), middle);
        radius = v_mul_add(v_abs(c), v_set1(hulls->filter.radius[i][place]), radius);
    }
    *least = v_sub(middle, radius);
    *greatest = v_add(middle, radius);
}

/* Error bounds of the edge functions of a vector of triangles, for the rays of a packet (L5). */
MLRT_INLINE vf edge_bounds(const struct mlrt_hulls *hulls, uint32_t place, vf steepness, int has_places)
{
    const vf bound = v_set1(EDGE_ERROR * hulls->filter.reach[place]);
    if (!has_places || MLRT_GUESS) return bound;
    return v_mul_add(steepness, v_set1(hulls->filter.blur[place] * hulls->filter.reach[place]), bound);
}

/*
 * Returns the triangles of `among` that the rays of a packet may hit. A triangle is left out if all rays pass outside
 * of one edge, and D has one sign; or if all rays pass two edges on different sides. For rays from the waist a hit
 * has no negative edge function (see "FROM THE WAIST").
 */
MLRT_INLINE uint32_t triangles_within_edges(const struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                            uint32_t place, int has_places, uint32_t among)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    const int term_count = has_places ? MLRT_RAY_TERMS : 2;
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        if (!(among >> v & ALL_LANES)) continue;
        vf lowest = v_set1(INFINITY), highest = v_set1(-INFINITY), least, greatest;
        MLRT_UNROLL
        for (int i = 0; i < 3; ++i) {
            bound_over_hull(hulls, place, leaf->edges.constant[i] + v,
                            (const float(*)[MLRT_BVH_LEAF_LIMIT])(leaf->edges.coefficient[i][0] + v), term_count,
                            &least, &greatest);
            lowest = v_min(greatest, lowest);
            highest = v_max(least, highest);
        }
        const vf bound = v_mul(edge_bounds(hulls, place, v_load(leaf->edges.steepness + v), has_places), v_set1(2));
        if (!has_places) {
            met |= (~m_bits(v_lt(lowest, v_sub(v_set1(0), bound))) & ALL_LANES) << v;
            continue;
        }
        bound_over_hull(hulls, place, leaf->planes.normal[0] + v,
                        (const float(*)[MLRT_BVH_LEAF_LIMIT])(leaf->planes.normal[1] + v), 2, &least, &greatest);
        const vf width = v_set1(2 * PLANE_BOUND * hulls->filter.reach[place]);
        const vm below = v_lt(lowest, v_sub(v_set1(0), bound)), above = v_gt(highest, bound);
        const vm forward = v_gt(least, width), backward = v_lt(greatest, v_sub(v_set1(0), width));
        const vm out = m_or(m_and(below, m_or(above, forward)), m_and(above, backward));
        met |= (~m_bits(out) & ALL_LANES) << v;
    }
    return met & among;
}

/* ---- tests ---- */

#define PACKET_VECTORS (MLRT_PACKET_RAYS / VW)

/* Of each triangle and each ray of a packet, the least and the greatest of the three edge functions. */
struct edge_values {
    MLRT_ALIGNED(64) float least[MLRT_BVH_LEAF_LIMIT][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float greatest[MLRT_BVH_LEAF_LIMIT][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float bound[MLRT_BVH_LEAF_LIMIT]; /* error bounds; without places [0] is that of all */
    uint32_t of_vector[PACKET_VECTORS];                /* of each vector of rays: the triangles that may be hit */
};

/*
 * Finds the edge values of `count` vectors of rays, from the vector `first` on. This loop has no branch that depends
 * on a triangle's result, and keeps only terms in registers. Most triangles have no ray inside and end here, and so do
 * those that all such rays skip: rays to a light mostly end on one.
 */
MLRT_INLINE void find_edge_values(const struct mlrt_bundle_leaf *leaf, const struct mlrt_bundle_rays *rays,
                                  const struct mlrt_packet *packet, uint32_t triangles, int has_places, int first,
                                  int count, struct edge_values *of)
{
    const int term_count = has_places ? MLRT_RAY_TERMS : 2;
    vf term[PACKET_VECTORS][MLRT_RAY_TERMS], bound = v_set1(of->bound[0]);
    vi skip[PACKET_VECTORS];
    uint32_t met[PACKET_VECTORS] = {0};
    MLRT_UNROLL
    for (int n = 0; n < count; ++n) {
        const int v = VW * (first + n);
        skip[n] = packet->has.skip ? i_load(packet->skip + v) : i_set1(MLRT_NONE);
        const vm lanes = m_from_bits(packet->active >> v);
        MLRT_UNROLL
        for (int i = 0; i < term_count; ++i) term[n][i] = v_select(lanes, v_load(rays->term[i] + v), v_set1(NAN));
    }
    for (; triangles; triangles &= triangles - 1) {
        const uint32_t triangle = mlrt_lowest_bit(triangles), bit = triangles & (0u - triangles);
        vf least[PACKET_VECTORS], greatest[PACKET_VECTORS];
        MLRT_UNROLL
        for (int edge = 0; edge < 3; ++edge) {
            vf e[PACKET_VECTORS];
            MLRT_UNROLL
            for (int n = 0; n < count; ++n) e[n] = v_set1(leaf->edges.constant[edge][triangle]);
            MLRT_UNROLL
            for (int i = 0; i < term_count; ++i) {
                const vf c = v_set1(leaf->edges.coefficient[edge][i][triangle]);
                MLRT_UNROLL
                for (int n = 0; n < count; ++n) e[n] = v_mul_add(c, term[n][i], e[n]);
            }
            MLRT_UNROLL
            for (int n = 0; n < count; ++n) {
                least[n] = edge ? v_min(e[n], least[n]) : e[n];
                if (has_places) greatest[n] = edge ? v_max(e[n], greatest[n]) : e[n];
            }
        }
        if (has_places) bound = v_set1(of->bound[triangle]);
        MLRT_UNROLL
        for (int n = 0; n < count; ++n) {
            const int v = VW * (first + n);
            v_store(of->least[triangle] + v, least[n]);
            if (has_places) v_store(of->greatest[triangle] + v, greatest[n]);
            /* Lanes that are not active have NaN, of which no comparison is true. */
            vm may = v_ge(least[n], v_sub(v_set1(0), bound));
            if (has_places) may = m_or(may, v_le(greatest[n], bound));
            may = m_andnot(may, i_eq(skip[n], i_set1(leaf->numbers[triangle])));
            met[n] |= m_bits(may) ? bit : 0;
        }
    }
    MLRT_UNROLL
    for (int n = 0; n < count; ++n) of->of_vector[first + n] = met[n];
}

/* The nearest hits of a vector of rays: tau is between least_n / greatest_d and greatest_n / least_d. */
struct nearest_hits {
    vf least_n;
    vf greatest_n;
    vf least_d;
    vf greatest_d;
    vi triangle;
};

/* A vector of a packet's rays while it is tested against the triangles of a leaf. */
struct bundle_vector {
    vf slope[2];
    vf to_waist[3];
    struct nearest_hits nearest;
};

MLRT_INLINE void load_nearest_hits(const struct mlrt_bundle_rays *rays, const struct mlrt_packet *packet, int v,
                                   struct nearest_hits *nearest)
{
    nearest->least_n = v_load(rays->lo + v);
    nearest->greatest_n = v_load(rays->hi + v);
    nearest->least_d = nearest->greatest_d = v_set1(1);
    nearest->triangle = i_load(packet->nearest.triangle + v);
}

MLRT_INLINE void load_bundle_vector(const struct mlrt_bundle_rays *rays, const struct mlrt_packet *packet,
                                    int has_places, int v, struct bundle_vector *of)
{
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) of->slope[i] = v_load(rays->term[i] + v);
    MLRT_UNROLL
    for (int i = 0; i < 3; ++i) of->to_waist[i] = has_places ? v_load(rays->to_waist[i] + v) : v_set1(0);
    load_nearest_hits(rays, packet, v, &of->nearest);
}

/* Sets bounds of tau from those of N and D. The slack covers the two roundings of each (L8). */
MLRT_INLINE void find_quotients(vf least_n, vf greatest_n, vf least_d, vf greatest_d, vf *lo, vf *hi)
{
    const vf quotient = v_mul(v_div(least_n, greatest_d), v_set1(1 - RECIPROCAL_SLACK));
    *lo = v_min(quotient, v_set1(GREATEST_DISTANCE));
    *hi = v_mul(v_div(greatest_n, least_d), v_set1(1 + RECIPROCAL_SLACK));
}

/* Stores the nearest hits of a vector where they are not the packet's. Returns the lanes where they were stored. */
MLRT_INLINE uint32_t store_nearest_hits(const struct nearest_hits *nearest, int v, struct mlrt_bundle_rays *rays,
                                        struct mlrt_packet *packet)
{
    const vm same = i_eq(nearest->triangle, i_load(packet->nearest.triangle + v));
    const uint32_t changed = ~m_bits(same) & ALL_LANES;
    if (!changed) return 0;
    vf lo, hi;
    find_quotients(nearest->least_n, nearest->greatest_n, nearest->least_d, nearest->greatest_d, &lo, &hi);
    v_store(rays->lo + v, v_select(same, v_load(rays->lo + v), lo));
    v_store(rays->hi + v, v_select(same, v_load(rays->hi + v), hi));
    i_store(packet->nearest.triangle + v, nearest->triangle);
    return changed << v;
}

/*
 * Bounds of t that are made from bounds of tau = t |d_main|, or the reverse, are moved apart by RECIPROCAL_SLACK of
 * themselves and by CONVERSION_FLOOR (L9): either of the two roundings may underflow and lose 2^-150. The floor is
 * needed. A ray may meet a slanted plane at a depth of less than 2^-149 from its origin; so it may meet two planes in
 * an order that t tells and tau does not.
 */
#define CONVERSION_FLOOR 0x1p-148f

/*
 * Sets the bounds of t in a packet from those of tau. Replaces -0 in its directions by 0, as 1 / -0 is -inf
 * (single_ray.h).
 */
static MLRT_NOINLINE void set_packet_distances(const struct mlrt_bundle_rays *rays, struct mlrt_packet *packet)
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf pace = v_load(rays->pace + v), t_max = v_load(packet->t_max + v);
        const vm none = i_eq(i_load(packet->nearest.triangle + v), i_set1(MLRT_NONE));
        /* Where |d_main| is large, t may be denormal, and its least step is a large one in depth. */
        const vf floor = v_select(v_gt(pace, v_set1(MLRT_SAFE_MAX)), v_set1(0x1p-147f), v_set1(CONVERSION_FLOOR));
        const vf near = v_sub(v_mul(v_div(v_load(rays->lo + v), pace), v_set1(1 - RECIPROCAL_SLACK)), floor);
        const vf lo = v_max(v_min(near, v_set1(FLT_MAX)), v_set1(0));
        const vf hi = v_add(v_mul(v_div(v_load(rays->hi + v), pace), v_set1(1 + RECIPROCAL_SLACK)), floor);
        v_store(packet->nearest.lo + v, v_select(none, t_max, lo));
        v_store(packet->nearest.hi + v, v_select(none, t_max, hi));
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k)
            v_store(packet->direction[k] + v, v_add(v_load(packet->direction[k] + v), v_set1(0)));
    }
}

/* Sets the bounds of tau of a lane from those of t. */
MLRT_INLINE void set_lane_depths(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_bundle_rays *rays)
{
    const float lo = packet->nearest.lo[lane] * rays->pace[lane], hi = packet->nearest.hi[lane] * rays->pace[lane];
    const float near = lo * (1 - RECIPROCAL_SLACK) - CONVERSION_FLOOR;
    rays->lo[lane] = near < GREATEST_DISTANCE ? near : GREATEST_DISTANCE;
    rays->hi[lane] = hi * (1 + RECIPROCAL_SLACK) + CONVERSION_FLOOR;
}

/* Error bounds of D and N that hold for all rays of a packet and all triangles. */
struct plane_bounds {
    vf width;   /* 16 u R: of D */
    float away; /* A: that of N is DISTANCE_ERROR (F + A) */
    int has_begins;
};

/* Where a vector of rays meets the plane of a triangle: bounds of N and D, both negated where D < 0. */
struct plane_of_rays {
    vf least_n;
    vf greatest_n;
    vf least_d;
    vf greatest_d;
    vm backward; /* D < 0 */
    vm certain;  /* rays that may be inside the edges, and whose D has a certain sign */
    vm begun;    /* tau is surely greater than that of t_min */
};

/* Makes a triangle the nearest hit of the lanes `hit`. */
MLRT_INLINE void keep_plane(const struct plane_of_rays *plane, uint32_t number, vm hit, struct nearest_hits *nearest)
{
    nearest->least_n = v_select(hit, plane->least_n, nearest->least_n);
    nearest->greatest_n = v_select(hit, plane->greatest_n, nearest->greatest_n);
    nearest->least_d = v_select(hit, plane->least_d, nearest->least_d);
    nearest->greatest_d = v_select(hit, plane->greatest_d, nearest->greatest_d);
    nearest->triangle = i_select(hit, i_set1(number), nearest->triangle);
}

/*
 * Sets *farther to the rays that surely meet a plane behind their nearest hits, and *nearer to those that surely meet
 * it before. Both hold only where D has a certain sign. Quotients of bounds are compared as products (L8): rounding is
 * monotone, so if one rounded product is less than the other, so is the exact one.
 */
MLRT_INLINE void compare_planes(const struct plane_of_rays *plane, const struct nearest_hits *nearest, vm *farther,
                                vm *nearer)
{
    *farther = v_gt(v_mul(plane->least_n, nearest->least_d), v_mul(nearest->greatest_n, plane->greatest_d));
    *nearer = v_lt(v_mul(plane->greatest_n, nearest->greatest_d), v_mul(nearest->least_n, plane->least_d));
}

/*
 * Compares the distances of a triangle with those of the nearest hits, for a vector of rays of which `candidates` may
 * be inside the edges and `inside` surely are. Makes it the nearest hit where that is certain. Returns the lanes that
 * are undecided.
 */
MLRT_INLINE uint32_t test_distances(const struct mlrt_bundle_leaf *leaf, uint32_t triangle,
                                    const struct plane_bounds *bounds, const float *begin, int has_places,
                                    vm candidates, vm inside, struct bundle_vector *of, struct plane_of_rays *plane)
{
    vf n = v_set1(leaf->planes.distance[triangle]), d = v_set1(leaf->planes.normal[0][triangle]);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) d = v_mul_add(v_set1(leaf->planes.normal[1 + i][triangle]), of->slope[i], d);
    MLRT_UNROLL
    for (int i = 0; has_places && i < 3; ++i)
        n = v_mul_add(v_set1(leaf->planes.normal[i][triangle]), of->to_waist[i], n);
    const float error = DISTANCE_ERROR * (leaf->planes.away[triangle] + bounds->away) + DISTANCE_FLOOR;
    const vf size = has_places ? v_abs(d) : d, distance = has_places ? v_flip(n, d) : n, width = bounds->width;
    plane->least_d = v_sub(size, width);
    plane->greatest_d = v_add(size, width);
    plane->least_n = v_sub(distance, v_set1(error));
    plane->greatest_n = v_add(distance, v_set1(error));
    plane->certain = m_and(candidates, v_gt(plane->least_d, width));
    plane->backward = v_lt(d, v_set1(0));
    vm farther, nearer;
    compare_planes(plane, &of->nearest, &farther, &nearer);
    if (MLRT_UNLIKELY(bounds->has_begins)) {
        const vf from = v_load(begin);
        farther = m_or(farther, v_lt(plane->greatest_n, v_mul(v_mul(from, v_set1(1 - SLOPE_SLACK)), plane->least_d)));
        plane->begun = v_gt(plane->least_n, v_mul(v_mul(from, v_set1(1 + SLOPE_SLACK)), plane->greatest_d));
    } else {
        farther = m_or(farther, v_lt(plane->greatest_n, v_set1(0)));
        plane->begun = v_gt(plane->least_n, v_set1(0));
    }
    vm hit = m_and(m_and(plane->certain, inside), m_and(nearer, plane->begun));
    vm open = m_andnot(m_andnot(candidates, m_and(plane->certain, farther)), hit);
    if (!has_places) open = m_andnot(open, v_lt(plane->greatest_d, v_set1(0)));
    uint32_t undecided = m_bits(open);
    if (MLRT_GUESS) hit = m_and(m_and(candidates, m_and(nearer, plane->begun)), v_gt(size, v_set1(0))), undecided = 0;
    keep_plane(plane, leaf->numbers[triangle], hit, &of->nearest);
    return undecided;
}

/* Returns F of a vector of rays (plane_order.c), and sets *bound to its error bound. */
MLRT_INLINE vf find_line_values(const struct mlrt_pair_line *line, const struct mlrt_bundle *bundle, uint32_t place,
                                int v, vf *bound)
{
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const float reach = bundle->hulls.filter.reach[place],
                blur = bundle->has.places ? bundle->hulls.filter.blur[place] : 0;
    vf f = v_set1(line->constant);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) f = v_mul_add(v_set1(line->coefficient[i]), v_load(rays->term[i] + v), f);
    for (int i = 2; bundle->has.places && i < MLRT_RAY_TERMS; ++i) {
        f = v_mul_add(v_set1(line->coefficient[i]), v_load(rays->term[i] + v), f);
    }
    *bound = v_set1((line->error + line->steepness * blur) * reach * (1 + SLOPE_SLACK));
    return f;
}

/*
 * Finds the rays for which F D_2 is surely above 0, and those for which it is surely below. The sign of D_1 then tells
 * that of t_1 - t_2.
 */
MLRT_INLINE void find_line_sides(const struct mlrt_pair_line *line, const struct mlrt_bundle *bundle, uint32_t place,
                                 int v, vm *above, vm *below)
{
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    vf bound, d = v_set1(line->normal[0]);
    const vf f = find_line_values(line, bundle, place, v, &bound);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) d = v_mul_add(v_set1(line->normal[1 + i]), v_load(rays->term[i] + v), d);
    const vf signed_f = v_flip(f, d);
    const vm sure = v_gt(v_abs(d), v_set1(PLANE_BOUND * bundle->hulls.filter.reach[place]));
    *above = m_and(sure, v_gt(signed_f, bound));
    *below = m_and(sure, v_lt(signed_f, v_sub(v_set1(0), bound)));
}

/*
 * Decides lanes of a vector where distances do not tell whether a triangle or the nearest hit so far comes first, by
 * the line of their planes (L15), as settle_covers in cover.h does. Returns the lanes that remain undecided.
 */
MLRT_INLINE uint32_t settle_lanes(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle,
                                  uint32_t place, uint32_t number, uint32_t lanes, vm inside,
                                  const struct plane_of_rays *plane, int v, struct nearest_hits *hits)
{
    MLRT_ALIGNED(64) uint32_t nearest_of[VW];
    const vi found = hits->triangle;
    uint32_t left = lanes;
    i_store(nearest_of, found);
    while (lanes) {
        const uint32_t nearest = nearest_of[mlrt_lowest_bit(lanes)];
        const uint32_t same = lanes & m_bits(i_eq(found, i_set1(nearest)));
        lanes &= ~same;
        if (nearest == MLRT_NONE) continue;
        const struct mlrt_pair_line *line = mlrt_find_pair_line(job->tree, number, nearest, worker, bundle->cache);
        if (line->kind == MLRT_ONE_PLANE) { /* as in mlrt_settle_tie */
            const uint32_t tied = number > nearest ? same : same & m_bits(inside);
            if (number < nearest) hits->triangle = i_select(m_from_bits(tied), i_set1(number), hits->triangle);
            left &= ~tied;
        } else if (line->kind == MLRT_LINE) {
            vm above, below;
            find_line_sides(line, bundle, place, v, &above, &below);
            const vm these = m_and(m_from_bits(same), plane->certain), backward = m_and(these, plane->backward);
            const vm forward = m_andnot(these, backward);
            const vm farther = m_or(m_and(above, forward), m_and(below, backward));
            const vm before = m_or(m_and(below, forward), m_and(above, backward));
            const vm nearer = m_and(before, m_and(inside, plane->begun));
            keep_plane(plane, number, nearer, hits);
            left &= ~m_bits(m_or(farther, nearer));
        }
    }
    return left;
}

/*
 * Decides lanes of a vector in double or exactly (close_calls.h, undecided.h). Returns the lanes whose nearest hit is
 * not the one that the packet had before.
 */
static MLRT_NOINLINE uint32_t decide_bundle_lanes(const struct mlrt_job *job, struct mlrt_worker *worker,
                                                  struct mlrt_bundle *bundle, uint32_t place, uint32_t number,
                                                  uint32_t lanes, vm inside, int v, struct nearest_hits *nearest)
{
    struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    const uint32_t changed = store_nearest_hits(nearest, v, rays, packet);
    if (job->any) { /* undecided lanes have no hit: their rays end at t_max */
        for (int i = 0; i < MLRT_PACKET_RAYS; i += VW) {
            v_store(packet->nearest.lo + i, v_load(packet->t_max + i));
            v_store(packet->nearest.hi + i, v_load(packet->t_max + i));
        }
    } else {
        set_packet_distances(rays, packet);
    }
    const uint32_t hit =
        decide_lanes(job->tree, number, lanes << v, m_bits(inside) << v, packet, worker, COUNTERS(worker));
    for (uint32_t those = job->any ? 0 : hit; those; those &= those - 1) {
        set_lane_depths(packet, mlrt_lowest_bit(those), rays);
    }
    load_nearest_hits(rays, packet, v, nearest);
    return changed | hit;
}

/* A number of DW lanes, and the size that its error is relative to. */
struct measured_lanes {
    vd value;
    vd size;
};

/* Sets N of a plane. */
MLRT_INLINE void measure_n(const struct mlrt_plane *plane, const struct mlrt_packet *packet, uint32_t lane,
                           struct measured_lanes *n)
{
    n->value = n->size = d_set1(0);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const vd origin = packet->has.apex ? d_set1(packet->apex[k]) : d_load(packet->origin[k] + lane);
        const vd to = d_sub(d_set1(plane->point[k]), origin);
        n->value = d_mul_add(to, d_set1(plane->normal[k]), n->value);
        n->size = d_mul_add(d_abs(to), d_set1(plane->size[k]), n->size);
    }
}

/* Sets N - t D of a plane. */
MLRT_INLINE void measure_end(const struct mlrt_plane *plane, const struct mlrt_packet *packet, const float *t,
                             uint32_t lane, const struct measured_lanes *n, struct measured_lanes *height)
{
    const vd end = d_load(t + lane);
    vd d = d_set1(0), d_size = d;
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const vd direction = d_load(packet->direction[k] + lane);
        d = d_mul_add(direction, d_set1(plane->normal[k]), d);
        d_size = d_mul_add(d_abs(direction), d_set1(plane->size[k]), d_size);
    }
    height->value = d_sub(n->value, d_mul(end, d));
    height->size = d_mul_add(end, d_size, n->size);
}

/* On which side of a plane the rays of a packet are, each at a t of its own. */
struct sides_of_plane {
    uint32_t before; /* rays that surely do not reach it by then: N / D > t */
    uint32_t behind; /* rays that are surely past it: N / D < t */
};

/*
 * Finds the sides of a plane by the sign of N - t D in double. `sign` is that of D. With t NULL, t is 0. If the packet
 * has an apex, *of_apex must be N of the apex.
 */
MLRT_INLINE struct sides_of_plane find_sides_of_plane(const struct mlrt_plane *plane, const struct mlrt_packet *packet,
                                                      const float *t, double sign, const struct measured_lanes *of_apex)
{
    const vd error = d_set1(CLOSE_ERROR), signs = d_set1(sign);
    struct sides_of_plane sides = {0, 0};
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        struct measured_lanes n = *of_apex;
        if (!packet->has.apex) measure_n(plane, packet, lane, &n);
        struct measured_lanes height = n;
        if (t) measure_end(plane, packet, t, lane, &n, &height);
        const vd value = d_flip(height.value, signs), bound = d_mul(height.size, error);
        sides.before |= d_gt(value, bound) << lane;
        sides.behind |= d_gt(d_sub(d_set1(0), value), bound) << lane;
    }
    return sides;
}

/*
 * Where any hit will do: decides lanes whose rays may begin, or end, at the plane of a triangle, by the sign of N - t D
 * there ("BEGINS AND ENDS"). A call decides only one of both ends and one sign of D, those of the first lane. Returns
 * the lanes that remain undecided.
 */
static MLRT_NOINLINE uint32_t settle_ends(const struct mlrt_job *job, const struct mlrt_bundle *bundle, uint32_t place,
                                          uint32_t number, uint32_t lanes, vm inside, const struct plane_of_rays *of,
                                          int v, struct nearest_hits *hits)
{
    const struct mlrt_packet *packet = &bundle->tile->packets[place];
    const uint32_t begun = m_bits(of->begun), backward = m_bits(of->backward);
    uint32_t those = lanes & m_bits(of->certain);
    if (!those) return lanes;
    const uint32_t first = mlrt_lowest_bit(those);
    const int at_end = begun >> first & 1, is_backward = backward >> first & 1;
    those &= (at_end ? begun : ~begun) & (is_backward ? backward : ~backward);
    struct mlrt_plane plane;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&job->tree->by_number, number);
    mlrt_set_plane(&triangle, &plane);
    const float *t = at_end ? packet->t_max : packet->has.limits ? packet->t_min : NULL;
    struct measured_lanes n;
    measure_n(&plane, packet, 0, &n);
    const struct sides_of_plane sides =
        find_sides_of_plane(&plane, packet, t, is_backward ? -bundle->waist.sign : bundle->waist.sign, &n);
    vm farther, nearer;
    compare_planes(of, hits, &farther, &nearer);
    const uint32_t missed = (at_end ? sides.before : sides.behind) >> v & those;
    const uint32_t within = at_end ? sides.behind >> v : sides.before >> v & m_bits(nearer);
    const uint32_t hit = those & within & m_bits(inside);
    hits->triangle = i_select(m_from_bits(hit), i_set1(number), hits->triangle);
    return lanes & ~(missed | hit);
}

/* A triangle of a leaf, and the lanes of a vector that its test left undecided. */
struct close_triangle_of_leaf {
    struct plane_of_rays plane;
    vm inside;
    uint32_t lanes; /* that are undecided */
    uint32_t triangle;
};

/*
 * Decides what the tests of a vector of rays against the triangles of a leaf left undecided. All triangles have been
 * tested before, so where any hit will do, lanes that hit one of them need no decision. Returns the lanes whose nearest
 * hit is not the one that the packet had before.
 */
static MLRT_NOINLINE uint32_t settle_leaf(const struct mlrt_job *job, struct mlrt_worker *worker,
                                          struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                          uint32_t place, struct close_triangle_of_leaf *close, uint32_t count, int v,
                                          struct nearest_hits *nearest)
{
    uint32_t decided = 0;
    for (uint32_t i = 0; i < count; ++i) {
        struct plane_of_rays *plane = &close[i].plane;
        const uint32_t number = leaf->numbers[close[i].triangle];
        uint32_t left = close[i].lanes;
        if (mlrt_is_stopped_in_step(worker)) return decided;
        if (leaf->state.flipped >> close[i].triangle & 1) {
            plane->backward = m_andnot(m_from_bits(ALL_LANES), plane->backward);
        }
        if (job->any) {
            left &= m_bits(i_eq(nearest->triangle, i_set1(MLRT_NONE)));
            if (left) left = settle_ends(job, bundle, place, number, left, close[i].inside, plane, v, nearest);
        } else {
            if (left) left = settle_lanes(job, worker, bundle, place, number, left, close[i].inside, plane, v, nearest);
        }
        if (left) {
            decided |= decide_bundle_lanes(job, worker, bundle, place, number, left, close[i].inside, v, nearest);
        }
    }
    return decided;
}

/* Tests a vector of a packet's rays against triangles, given their edge values. Returns the lanes with a new hit. */
MLRT_INLINE uint32_t test_bundle_vector(const struct mlrt_job *job, struct mlrt_worker *worker,
                                        struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                        const struct edge_values *edges, uint32_t place, int has_places, int v)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const struct plane_bounds bounds = {v_set1(PLANE_BOUND * hulls->filter.reach[place]),
                                        has_places ? hulls->filter.away[place] : 0, bundle->has.begins};
    const vi skip = packet->has.skip ? i_load(packet->skip + v) : i_set1(MLRT_NONE);
    uint32_t decided = 0, close_count = 0;
    vf bound = v_set1(edges->bound[0]);
    struct bundle_vector of;
    struct close_triangle_of_leaf close[MLRT_BVH_LEAF_LIMIT];
    load_bundle_vector(rays, packet, has_places, v, &of);
    for (uint32_t met = edges->of_vector[v / VW]; met; met &= met - 1) {
        const uint32_t triangle = mlrt_lowest_bit(met), number = leaf->numbers[triangle];
        if (has_places) bound = v_set1(edges->bound[triangle]);
        const vf least = v_load(edges->least[triangle] + v), below = v_sub(v_set1(0), bound);
        const vm known = m_or(i_eq(of.nearest.triangle, i_set1(number)), i_eq(skip, i_set1(number)));
        vm inside = v_gt(least, bound), may = v_ge(least, below);
        if (has_places) {
            const vf greatest = v_load(edges->greatest[triangle] + v);
            inside = m_or(inside, v_lt(greatest, below));
            may = m_or(may, v_le(greatest, bound));
        }
        may = m_andnot(may, known);
        if (job->any) may = m_and(may, i_eq(of.nearest.triangle, i_set1(MLRT_NONE)));
        if (MLRT_UNLIKELY(packet->has.masks)) {
            may = m_from_bits(mlrt_seeing_lanes(job->tree, number, packet->mask, m_bits(may) << v) >> v);
        }
        struct plane_of_rays plane;
        const uint32_t undecided =
            test_distances(leaf, triangle, &bounds, rays->begin + v, has_places, may, inside, &of, &plane);
        if (MLRT_LIKELY(!undecided)) continue;
        close[close_count++] = (struct close_triangle_of_leaf){plane, inside, undecided, triangle};
    }
    if (MLRT_UNLIKELY(close_count != 0)) {
        struct nearest_hits now = of.nearest; /* a copy, so that the original can stay in registers */
        decided = settle_leaf(job, worker, bundle, leaf, place, close, close_count, v, &now);
        of.nearest = now;
    }
    return decided | store_nearest_hits(&of.nearest, v, rays, packet);
}

/* Vectors of rays from anywhere whose edge values are found at once: for more there are not enough registers. */
#define VECTORS_FROM_ANYWHERE (PACKET_VECTORS < 2 ? PACKET_VECTORS : 2)

/*
 * Tests a packet against triangles of a leaf, and counts those that no ray may hit. Returns the lanes with a new hit.
 */
MLRT_INLINE uint32_t test_bundle_packet(const struct mlrt_job *job, struct mlrt_worker *worker,
                                        struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                        uint32_t triangles, uint32_t place, int has_places)
{
    const struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct edge_values edges;
    uint32_t changed = 0, met = 0;
    COUNT(&worker->counters, triangle_test_count, mlrt_count_bits(triangles));
    COUNT(&worker->counters, lane_test_count, mlrt_count_bits(triangles) * mlrt_count_bits(packet->active));
    for (int v = 0; v < (has_places ? MLRT_BVH_LEAF_LIMIT : 1); v += VW) {
        v_store(edges.bound + v, edge_bounds(&bundle->hulls, place, v_load(leaf->edges.steepness + v), has_places));
    }
    if (has_places) {
        for (int first = 0; first < PACKET_VECTORS; first += VECTORS_FROM_ANYWHERE) {
            find_edge_values(leaf, rays, packet, triangles, 1, first, VECTORS_FROM_ANYWHERE, &edges);
        }
    } else {
        find_edge_values(leaf, rays, packet, triangles, 0, 0, PACKET_VECTORS, &edges);
    }
    for (int n = 0; n < PACKET_VECTORS; ++n) {
        met |= edges.of_vector[n];
        if (edges.of_vector[n])
            changed |= test_bundle_vector(job, worker, bundle, leaf, &edges, place, has_places, VW * n);
    }
    bundle->state.tests[place] += mlrt_count_bits(triangles & ~met);
    return changed;
}

#endif
