/* SPDX-License-Identifier: MIT */
/*
 * t, u, v and facing of the hits of a packet (rule R5), a vector of doubles at a time, or of one ray. The bits are
 * those of the judge (mlrt_report_hit), since each number is the float nearest to the same exact quotient.
 *
 * With p = a - o, the determinants are those at the head of determinants.h:
 *
 *     normal = (c-a) x (a-b)     D = d . normal     e_ca = (c-a) . (p x d) = d . ((c-a) x p)
 *                                N = p . normal     e_ab = (a-b) . (p x d) = d . ((a-b) x p)
 *
 * Count the factors (1 + delta) of each. A component of a cross product has one for its product, one for its
 * difference, and those of its operands: 1 for a side or p, none for d. The dot product adds those of its other vector,
 * one product and at most two sums. So there are 7 factors, for N 8, as in determinants.h, and the errors are at most
 * 8.001 u of the sizes. With fused multiply-add there are fewer.
 *
 * WIDTHS. Let X and D be the determinants as computed, x and d the true ones, and s(X) and s(D) upper bounds of their
 * sizes, since all lanes of a packet share one bound of |d_0| + |d_1| + |d_2|. Where s(D) < 2^12 |D| is not certain,
 * the judge computes the numbers (mlrt_report_lane). Elsewhere |D - d| < 2^-37 |D|, so facing is the sign of D, and
 *
 *     x / d - X / D = ((x - X) + (x / d) (D - d)) / D.
 *
 * u and v are at most 1 where a ray hits, so this is at most 8.001 u (s(X) + s(D)) / |D|. t is at most 1 + 2^-36 times
 * (|N| + 8.001 u s(N)) / |D|, so the error of t is at most 8.002 u (s(N) + 2^12 |N|) / |D|. The quotient X * (1 / D)
 * is rounded twice more, and its ends once each: 3.01 u s(X) / |D| as in quotients.c. The sum is less than w / |D|
 * with the width
 *
 *     w = 12 u s(X) + 9 u s(D)  for u and v,     w = 12 u s(N) + 9 u 2^12 |N|  for t,
 *
 * and leaves 0.9 u of each size for the roundings of w, of its product with 1 / |D|, and of the ends by as much as
 * that. If both ends round to one float, that is the answer; else the judge computes it. For a direction of usual
 * length the width is 2^-38 of t, and for u and v 2^-48 of the ratio of the triangle's size and distance: so one hit in
 * thousands goes to the judge.
 *
 * One ray (report_lone_ray) has 12 u s(X) + 9 u 2^12 |X| for u and v as well, by the reasons for t, and its ends are
 * (X + w) * (1 / D) and (X - w) * (1 / D): as many roundings.
 *
 * hit_terms.h caches the terms that all rays that hit a triangle share, and those that also depend on one origin:
 * neighbours mostly hit the same triangle. A packet that hits several triangles computes the terms for each lane.
 */
#ifndef MLRT_HITS_HIT_NUMBERS_H
#define MLRT_HITS_HIT_NUMBERS_H

#include <math.h>
#include <string.h>

#include "exact/quotients.h"
#include "exact/vector.h"
#include "job/hit_terms.h"
#include "hits/outcome.h"
#include "job/read_lanes.h"
#include "job/write_arrays.h"
#include "simd/double_quad.h"
#include "simd/doubles.h"
#include "simd/simd.h"

MLRT_INLINE void fused_cross_product(const vd a[3], const vd b[3], vd cross[3])
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = d_mul_sub(a[i], b[j], d_mul(a[j], b[i]));
    }
}

MLRT_INLINE vd fused_dot_product(const vd a[3], const vd b[3])
{
    return d_mul_add(a[2], b[2], d_mul_add(a[1], b[1], d_mul(a[0], b[0])));
}

/* The terms of a triangle that do not depend on rays: its sides and its normal. */
struct plane_terms {
    vd corner[3];
    vd side[2][3]; /* c-a and a-b */
    vd side_size[2];
    vd normal[3];
    vd normal_size;
};

MLRT_INLINE void set_plane_terms(const vd corner[9], struct plane_terms *plane)
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        plane->corner[k] = corner[k];
        plane->side[0][k] = d_sub(corner[6 + k], corner[k]);
        plane->side[1][k] = d_sub(corner[k], corner[3 + k]);
    }
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) plane->side_size[i] = size_of_doubles(plane->side[i]);
    fused_cross_product(plane->side[0], plane->side[1], plane->normal);
    plane->normal_size = d_mul(plane->side_size[0], plane->side_size[1]);
}

/* The terms that also depend on the origin of a ray, and the widths from the head of this file. */
struct start_terms {
    vd p[3];
    vd n;
    vd n_width;
    vd edge_width[2]; /* of u and v, to be multiplied with the size of d */
};

MLRT_INLINE void set_start_terms(const struct plane_terms *plane, const vd origin[3], uint32_t outputs,
                                 struct start_terms *start)
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) start->p[k] = d_sub(plane->corner[k], origin[k]);
    const vd size = size_of_doubles(start->p);
    start->n = fused_dot_product(start->p, plane->normal);
    start->n_width = d_add(d_mul(d_mul(d_set1(MLRT_NUMERATOR_ERROR), size), plane->normal_size),
                           d_mul(d_set1(MLRT_DENOMINATOR_ERROR * MLRT_GREATEST_D_SIZE), d_abs(start->n)));
    if (!(outputs & MLRT_OUTPUT_UV)) return;
    const vd d_error = d_mul(d_set1(MLRT_DENOMINATOR_ERROR), plane->normal_size);
    const vd numerator_error = d_mul(d_set1(MLRT_NUMERATOR_ERROR), size);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) start->edge_width[i] = d_add(d_mul(numerator_error, plane->side_size[i]), d_error);
}

MLRT_INLINE void spread_vector(struct mlrt_vector v, vd of[3])
{
    of[0] = d_set1(v.x), of[1] = d_set1(v.y), of[2] = d_set1(v.z);
}

MLRT_INLINE void spread_plane_terms(const struct mlrt_hit_terms *kept, struct plane_terms *plane)
{
    spread_vector(kept->corner, plane->corner);
    MLRT_UNROLL
    for (int i = 0; i < 2; ++i) {
        spread_vector(kept->side[i], plane->side[i]);
        plane->side_size[i] = d_set1(kept->side_size[i]);
    }
    spread_vector(kept->normal, plane->normal);
    plane->normal_size = d_set1(kept->normal_size);
}

/* Returns the terms of a triangle, and of the apex if the packet has one. They are valid until the next call. */
MLRT_INLINE const struct mlrt_hit_terms *find_shared_terms(const struct mlrt_tree *tree,
                                                           const struct mlrt_packet *packet, uint32_t number,
                                                           struct mlrt_hit_term_cache *cache)
{
    const uint32_t place = number % MLRT_HIT_TERMS_COUNT;
    struct mlrt_hit_terms *kept = &cache->entries[place];
    if (cache->numbers[place] == number &&
        (!packet->has.apex || memcmp(packet->apex, kept->origin, sizeof kept->origin) == 0))
        return kept;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    /* without an apex the terms of an origin are not used: any will do */
    mlrt_set_hit_terms(&triangle, packet->has.apex ? packet->apex : triangle.v[0], kept);
    cache->numbers[place] = number;
    return kept;
}

/* An upper bound of |d_0| + |d_1| + |d_2| over the lanes `hit`. */
MLRT_INLINE double greatest_direction_size(const struct mlrt_packet *packet, uint32_t hit)
{
    vf greatest = v_set1(0);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf x = v_abs(v_load(packet->direction[0] + v)), y = v_abs(v_load(packet->direction[1] + v)),
                 z = v_abs(v_load(packet->direction[2] + v));
        greatest = v_max(v_select(m_from_bits(hit >> v), v_add(v_add(x, y), z), v_set1(0)), greatest);
    }
    return (double)v_hmax(greatest) * (1 + 0x1p-22);
}

/* 1 / D, its magnitude, and that negated. */
struct lane_denominator {
    vd inverse;
    vd size;
    vd minus_size;
};

/* Returns the lanes where s(D) < 2^12 |D| is certain, as the widths require. */
MLRT_INLINE uint32_t invert_denominator(vd d, vd d_size, struct lane_denominator *denominator)
{
    denominator->inverse = d_div(d_set1(1), d);
    denominator->size = d_abs(denominator->inverse);
    denominator->minus_size = d_sub(d_set1(0), denominator->size);
    return d_gt(d_set1(MLRT_GREATEST_D_SIZE), d_mul(d_size, denominator->size));
}

/* Bounds of x / D. */
struct quotient_ends {
    vd low;
    vd high;
};

MLRT_INLINE struct quotient_ends enclose_quotients(vd x, vd width, const struct lane_denominator *denominator)
{
    const vd quotient = d_mul(x, denominator->inverse);
    return (struct quotient_ends){d_mul_add(width, denominator->minus_size, quotient),
                                  d_mul_add(width, denominator->size, quotient)};
}

/* Rounds x / D to floats. Returns the lanes where the float is certain. */
MLRT_INLINE uint32_t round_quotients(vd x, vd width, const struct lane_denominator *denominator, float *result)
{
    const struct quotient_ends ends = enclose_quotients(x, width, denominator);
    d_store(result, ends.high);
    return MLRT_GUESS ? ALL_LANES : d_same_float(ends.low, ends.high);
}

/* Sets the numbers of a miss in the lanes outside of `hit`. */
static MLRT_NOINLINE void report_misses(uint32_t hit, struct mlrt_packet_values *values)
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm is_hit = m_from_bits(hit >> v);
        v_store(values->t + v, v_select(is_hit, v_load(values->t + v), v_set1(INFINITY)));
        v_store(values->uv[0] + v, v_select(is_hit, v_load(values->uv[0] + v), v_set1(0)));
        v_store(values->uv[1] + v, v_select(is_hit, v_load(values->uv[1] + v), v_set1(0)));
        i_store(values->facing + v, i_select(is_hit, i_load(values->facing + v), i_set1(0)));
    }
}

/* Sets facing: 1 in the lanes `positive`, where D > 0, and -1 in the others. */
static void report_facing(uint32_t positive, struct mlrt_packet_values *values)
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW)
        i_store(values->facing + v, i_select(m_from_bits(positive >> v), i_set1(1), i_set1(0xFFFFFFFFu)));
}

/*
 * Computes the numbers of a packet with an apex whose hits are all of one triangle. Here and below, bits 0 .. 15 of the
 * result are the lanes whose numbers are certain, and bits 16 .. 31 those with D > 0 if facing is wanted. (If both were
 * fields of a struct, gcc would store and reload them.)
 */
static uint32_t report_from_apex(const struct mlrt_packet *packet, const struct mlrt_hit_terms *terms,
                                 double direction_size, uint32_t outputs, struct mlrt_packet_values *values)
{
    uint32_t reported = 0, positive = 0;
    const vd d_size = d_set1(terms->normal_size * direction_size);
    const vd n = d_set1(terms->n), n_width = d_set1(terms->n_width);
    vd normal[3];
    spread_vector(terms->normal, normal);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        vd direction[3];
        struct lane_denominator denominator;
        load_directions(packet, lane, direction);
        const vd d = fused_dot_product(direction, normal);
        uint32_t certain = invert_denominator(d, d_size, &denominator);
        if (outputs & MLRT_OUTPUT_T) certain &= round_quotients(n, n_width, &denominator, values->t + lane);
        if (outputs & MLRT_OUTPUT_UV) {
            MLRT_UNROLL
            for (int i = 0; i < 2; ++i) {
                const vd width = d_set1(terms->edge_width[i] * direction_size);
                vd edge[3];
                spread_vector(terms->edge[i], edge);
                certain &=
                    round_quotients(fused_dot_product(direction, edge), width, &denominator, values->uv[i] + lane);
            }
        }
        reported |= certain << lane;
        if (outputs & MLRT_OUTPUT_FACING) positive |= d_gt(d, d_set1(0)) << lane;
    }
    return reported | positive << 16;
}

/* Computes the numbers of DW lanes of a packet, from `lane` on, whose origins or triangles differ. */
MLRT_INLINE uint32_t report_lanes(const struct mlrt_packet *packet, const struct plane_terms *plane, uint32_t lane,
                                  double direction_size, uint32_t outputs, struct mlrt_packet_values *values)
{
    vd direction[3], origin[3], moment[3];
    struct lane_denominator denominator;
    struct start_terms start;
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) origin[k] = origins_in_double(packet, k, lane);
    load_directions(packet, lane, direction);
    set_start_terms(plane, origin, outputs, &start);
    const vd d = fused_dot_product(direction, plane->normal), d_size = d_set1(direction_size);
    uint32_t certain = invert_denominator(d, d_mul(plane->normal_size, d_size), &denominator);
    if (outputs & MLRT_OUTPUT_T) certain &= round_quotients(start.n, start.n_width, &denominator, values->t + lane);
    if (outputs & MLRT_OUTPUT_UV) {
        fused_cross_product(start.p, direction, moment);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            certain &= round_quotients(fused_dot_product(plane->side[i], moment), d_mul(start.edge_width[i], d_size),
                                       &denominator, values->uv[i] + lane);
        }
    }
    return certain << lane | (outputs & MLRT_OUTPUT_FACING ? d_gt(d, d_set1(0)) : 0) << (16 + lane);
}

/* Computes the numbers of a packet whose hits are all of one triangle, from different origins. */
static uint32_t report_one_triangle(const struct mlrt_packet *packet, const struct mlrt_hit_terms *terms,
                                    double direction_size, uint32_t outputs, struct mlrt_packet_values *values)
{
    uint32_t reported = 0;
    struct plane_terms plane;
    spread_plane_terms(terms, &plane);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW)
        reported |= report_lanes(packet, &plane, lane, direction_size, outputs, values);
    return reported;
}

/* Computes the numbers of a packet whose hits are of several triangles, without the cache. */
static MLRT_NOINLINE uint32_t report_triangles(const struct mlrt_tree *tree, const struct mlrt_packet *packet,
                                               uint32_t hit, double direction_size, uint32_t outputs,
                                               struct mlrt_packet_values *values)
{
    uint32_t reported = 0;
    MLRT_ALIGNED(64) float corners[9][MLRT_PACKET_RAYS];
    mlrt_gather_corners(tree, packet, hit, corners);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        vd corner[9];
        struct plane_terms plane;
        MLRT_UNROLL
        for (int k = 0; k < 9; ++k) corner[k] = d_load(corners[k] + lane);
        set_plane_terms(corner, &plane);
        reported |= report_lanes(packet, &plane, lane, direction_size, outputs, values);
    }
    return reported;
}

/* Computes the numbers of all lanes as if they hit triangle `number`, with its terms from the cache. */
static MLRT_NOINLINE uint32_t report_kept(const struct mlrt_tree *tree, const struct mlrt_packet *packet,
                                          uint32_t number, double direction_size, uint32_t outputs,
                                          struct mlrt_hit_term_cache *cache, struct mlrt_packet_values *values)
{
    const struct mlrt_hit_terms *terms = find_shared_terms(tree, packet, number, cache);
    return packet->has.apex ? report_from_apex(packet, terms, direction_size, outputs, values)
                            : report_one_triangle(packet, terms, direction_size, outputs, values);
}

/*
 * Computes the numbers of a packet's lanes that `outputs` asks for; `hit` are the lanes with a hit. Lanes whose
 * numbers are not certain are left to the judge.
 */
static void report_packet(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                          uint32_t outputs, struct mlrt_hit_term_cache *cache, struct mlrt_packet_values *values)
{
    if (hit) {
        const uint32_t number = packet->nearest.triangle[mlrt_lowest_bit(hit)];
        const double direction_size = greatest_direction_size(packet, hit);
        const uint32_t reported = hit & ~lanes_of_triangle(packet, number)
                                      ? report_triangles(tree, packet, hit, direction_size, outputs, values)
                                      : report_kept(tree, packet, number, direction_size, outputs, cache, values);
        if (outputs & MLRT_OUTPUT_FACING) report_facing(reported >> 16, values);
        for (uint32_t left = hit & ~reported; left; left &= left - 1)
            mlrt_report_lane(tree, packet, mlrt_lowest_bit(left), outputs, values);
    }
    if (hit != 0xFFFF) report_misses(hit, values);
}

/*
 * The numbers of one ray's hit. Lanes are p, a-c, d and a-b, whose products with the normal (a-c) x (a-b) and with
 * p x d are the numerators of t and u, D, and that of v; but for v, all have the opposite sign. Returns 0 if the judge
 * has to compute the numbers; then those in *hit have no meaning.
 */
MLRT_INLINE int report_lone_ray(const struct mlrt_corners *of, const float origin[3], const float direction[3],
                                mlrt_hit *hit)
{
    const size_t row = of->row;
    d4 vector[3], left[3], right[3], other[3];
    MLRT_UNROLL
    for (size_t k = 0; k < 3; ++k) {
        const float *a = of->corner + k * row, *b = a + 3 * row, *c = a + 6 * row;
        vector[k] = d4_corner_terms(a, origin + k, c, direction + k, b);
        left[k] = d4_lower(vector[k]);
        right[k] = d4_upper(vector[k]);
    }
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) { /* the normal and p x d, twice */
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        other[k] = d4_mul_sub(left[i], right[j], d4_mul(left[j], right[i]));
    }
    const d4 x = d4_mul_add(vector[2], other[2], d4_mul_add(vector[1], other[1], d4_mul(vector[0], other[0])));
    const d4 inverse = d4_inverse(x), magnitude = d4_abs(x), greatest_d_size = d4_set1(MLRT_GREATEST_D_SIZE);
    const d4 length = d4_add(d4_add(d4_abs(vector[0]), d4_abs(vector[1])), d4_abs(vector[2]));
    const d4 size = d4_mul(length, d4_mul(d4_lower(length), d4_upper(length)));
    const d4 width = d4_mul_add(d4_set1(MLRT_NUMERATOR_ERROR), size,
                                d4_mul(d4_set1(MLRT_DENOMINATOR_ERROR * MLRT_GREATEST_D_SIZE), magnitude));
    hit->facing = d4_first(inverse) < 0 ? 1 : -1;
    return d4_round(d4_mul(d4_add(x, width), inverse), d4_mul(d4_sub(x, width), inverse), &hit->t) &
           d4_third_gt(d4_mul(greatest_d_size, magnitude), size);
}

#endif
