/* SPDX-License-Identifier: MIT */
/*
 * A packet against a triangle: for nearly all rays, float arithmetic with a bound on its error says surely not, or
 * surely yes and surely nearer. The rest are judged one by one (hit.h).
 *
 * With u = 2^-24 and everything computed in float, for one ray:
 *
 *   a = fl(v_i - o), b = fl(v_j - o)                each within a factor 1 + u of the exact difference
 *   e = d . (a x b)                                 two differences, product, subtraction, product, two sums: 7 roundings
 *   D = d . n, n = (b - a) x (c - a)                the same 7
 *   N = fl(a - o) . n                               difference, n's 4, product, two sums: 8
 *
 * so each is off by at most g M, with g = 8 u / (1 - 8 u) and M the same expression with all signs made positive. What
 * is computed as M lacks at most a factor (1 - 8 u) again, so 16 u M = 2^-20 M is a bound with a factor of two to spare.
 * For M, |d| may be replaced by anything larger: a whole packet shares the largest |d_k| of its rays, and so one bound.
 *
 * Underflow: a float subtraction never underflows inexactly; each product may lose 2^-150, which later factors scale. The
 * sum of these losses is under 2^-149 (|d_x| + |d_y| + |d_z| + 2) for e and D, and the same with |a - o| for N. `floor`
 * is 2^-146 (sum + 4). Overflow makes M infinite or NaN, and then no comparison below is true: undecided.
 *
 * Distances: t = N / D lies between (|N| - EN) / (|D| + ED) and (|N| + EN) / (|D| - ED), in signs that make D positive;
 * three roundings, paid for by a factor 1 -+ 2^-21, and 2^-148 for underflow of the quotient.
 */

#define FILTER_BOUND 0x1p-20f
#define FILTER_FLOOR 0x1p-146f
#define QUOTIENT_BOUND 0x1p-21f
#define QUOTIENT_FLOOR 0x1p-148f

/* What the rays of a packet need to know of a triangle. Index 3 of cross and bound is the normal. */
struct triangle_terms {
    vf cross[4][3];    /* a x b, b x c, c x a relative to the origin; n */
    vf bound[4];       /* error bounds of d . cross[i] */
    vf distance;       /* N */
    vf distance_bound;
};

/* first x second, and the sums of the magnitudes of its products. */
MLRT_INLINE void cross_product(const vf first[3], const vf second[3], vf cross[3], vf size[3])
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const vf p = v_mul(first[i], second[j]), q = v_mul(first[j], second[i]);
        cross[k] = v_sub(p, q);
        size[k] = v_add(v_abs(p), v_abs(q));
    }
}

MLRT_INLINE vf dot_product(const vf a[3], const vf b[3])
{
    return v_add(v_add(v_mul(a[0], b[0]), v_mul(a[1], b[1])), v_mul(a[2], b[2]));
}

/* A bound on the error of (vectors no larger than reach) . cross. */
MLRT_INLINE vf dot_bound(const vf reach[3], const vf size[3])
{
    const vf floor = v_mul(v_add(v_add(v_add(reach[0], reach[1]), reach[2]), v_set1(4)), v_set1(FILTER_FLOOR));
    return v_add(v_mul(dot_product(reach, size), v_set1(FILTER_BOUND)), floor);
}

/* Terms for origins and direction sizes (`reach` >= |d|) that are given lane by lane. */
MLRT_INLINE void set_terms(const struct mlrt_triangle *triangle, const vf origin[3], const vf reach[3],
                           struct triangle_terms *terms)
{
    vf vertex[3][3], edge[2][3], size[3];
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) vertex[i][k] = v_sub(v_set1(triangle->v[i][k]), origin[k]);
        edge[0][k] = v_set1(triangle->v[1][k] - triangle->v[0][k]);
        edge[1][k] = v_set1(triangle->v[2][k] - triangle->v[0][k]);
    }
    for (int i = 0; i < 3; ++i) {
        cross_product(vertex[i], vertex[(i + 1) % 3], terms->cross[i], size);
        terms->bound[i] = dot_bound(reach, size);
    }
    cross_product(edge[0], edge[1], terms->cross[3], size);
    terms->bound[3] = dot_bound(reach, size);
    const vf away[3] = {v_abs(vertex[0][0]), v_abs(vertex[0][1]), v_abs(vertex[0][2])};
    terms->distance = dot_product(vertex[0], terms->cross[3]);
    terms->distance_bound = dot_bound(away, size);
}

/* What the filter says of a vector of rays; the lanes in neither have nothing to do with the triangle. */
struct verdict {
    vm nearer;    /* surely hit, surely before the nearest hit so far */
    vm undecided;
    vf lo;        /* where nearer: lo <= t <= hi */
    vf hi;
};

MLRT_INLINE struct verdict filter_vector(const struct triangle_terms *terms, const struct mlrt_packet *packet, int v,
                                         vm active)
{
    const vf d[3] = {v_load(packet->direction[0] + v), v_load(packet->direction[1] + v),
                     v_load(packet->direction[2] + v)};
    struct verdict verdict;
    vf e = dot_product(d, terms->cross[0]);
    vm above = v_gt(e, terms->bound[0]), below = v_gt(v_sub(v_set1(0), e), terms->bound[0]);
    vm all_above = above, all_below = below, any_above = above, any_below = below;
    for (int i = 1; i < 3; ++i) {
        e = dot_product(d, terms->cross[i]);
        above = v_gt(e, terms->bound[i]);
        below = v_gt(v_sub(v_set1(0), e), terms->bound[i]);
        all_above = m_and(all_above, above);
        all_below = m_and(all_below, below);
        any_above = m_or(any_above, above);
        any_below = m_or(any_below, below);
    }
    const vm candidates = m_andnot(active, m_and(any_above, any_below));
    verdict.nearer = verdict.undecided = candidates;
    verdict.lo = verdict.hi = v_set1(0);
    if (!m_bits(candidates)) return verdict;

    const vf determinant = dot_product(d, terms->cross[3]);
    const vf size = v_abs(determinant), bound = terms->bound[3];
    const vf distance = v_flip(terms->distance, determinant);
    const vm certain = v_gt(size, bound);
    const vf lo = v_div(v_sub(distance, terms->distance_bound), v_add(size, bound));
    const vf hi = v_div(v_add(distance, terms->distance_bound), v_sub(size, bound));
    verdict.lo = v_sub(v_mul(lo, v_set1(1 - QUOTIENT_BOUND)), v_set1(QUOTIENT_FLOOR));
    verdict.hi = v_add(v_mul(hi, v_set1(1 + QUOTIENT_BOUND)), v_set1(QUOTIENT_FLOOR));

    const vf t_min = v_load(packet->t_min + v);
    const vm farther = m_or(v_gt(verdict.lo, v_load(packet->hi + v)), v_le(verdict.hi, t_min));
    const vm nearer = m_and(v_gt(verdict.lo, t_min), v_lt(verdict.hi, v_load(packet->lo + v)));
    const vm inside = m_or(all_above, all_below);
    verdict.nearer = m_and(m_and(candidates, certain), m_and(inside, nearer));
    verdict.undecided = m_andnot(m_andnot(candidates, m_and(certain, farther)), verdict.nearer);
    return verdict;
}

/* Hands single lanes to the judge. Returns those that are hit nearer than before. */
static MLRT_NOINLINE uint32_t judge_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes,
                                          struct mlrt_packet *packet)
{
    uint32_t hit = 0;
    for (uint32_t lane = 0; lanes >> lane; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        struct mlrt_ray_segment ray;
        mlrt_get_segment(packet, lane, &ray);
        struct mlrt_nearest nearest = {packet->triangle[lane], packet->lo[lane], packet->hi[lane]};
        if (!mlrt_offer_triangle(tree, &ray, number, &nearest)) continue;
        packet->triangle[lane] = nearest.triangle;
        packet->lo[lane] = nearest.lo;
        packet->hi[lane] = nearest.hi;
        hit |= 1u << lane;
    }
    return hit;
}

/* The rays of a packet that take part in a traversal, and what the filter wants to know of them all. */
struct ray_group {
    uint32_t lanes;
    float reach[3]; /* largest |d_k| */
};

/*
 * Tests the rays of `group` against triangle `number`, for the vectors first_vector <= v < end_vector (in lanes), and
 * updates their nearest hits. Returns the lanes whose nearest hit changed.
 */
static uint32_t test_triangle(const struct mlrt_tree *tree, uint32_t number, const struct ray_group *group,
                              int first_lane, int end_lane, struct mlrt_packet *packet, mlrt_counters *counters)
{
    const struct mlrt_triangle *triangle = &tree->triangles[number];
    const vf reach[3] = {v_set1(group->reach[0]), v_set1(group->reach[1]), v_set1(group->reach[2])};
    struct triangle_terms terms;
    if (packet->has_apex) {
        const vf origin[3] = {v_set1(packet->apex[0]), v_set1(packet->apex[1]), v_set1(packet->apex[2])};
        set_terms(triangle, origin, reach, &terms);
    }
    uint32_t changed = 0;
    for (int v = first_lane; v < end_lane; v += VW) {
        vm active = m_from_bits(group->lanes >> v);
        if (packet->has_skip) active = m_andnot(active, i_eq(i_load(packet->skip + v), i_set1(number)));
        if (!m_bits(active)) continue;
        if (!packet->has_apex) {
            const vf origin[3] = {v_load(packet->origin[0] + v), v_load(packet->origin[1] + v),
                                  v_load(packet->origin[2] + v)};
            set_terms(triangle, origin, reach, &terms);
        }
        const struct verdict verdict = filter_vector(&terms, packet, v, active);
        const uint32_t nearer = m_bits(verdict.nearer), undecided = m_bits(verdict.undecided);
        if (nearer) {
            v_store(packet->lo + v, v_select(verdict.nearer, verdict.lo, v_load(packet->lo + v)));
            v_store(packet->hi + v, v_select(verdict.nearer, verdict.hi, v_load(packet->hi + v)));
            i_store(packet->triangle + v, i_select(verdict.nearer, i_set1(number), i_load(packet->triangle + v)));
            changed |= nearer << v;
        }
        if (undecided) {
            COUNT(counters, judged_lane_count, __builtin_popcount(undecided));
            changed |= judge_lanes(tree, number, undecided << v, packet);
        }
    }
    (void)counters;
    return changed;
}
