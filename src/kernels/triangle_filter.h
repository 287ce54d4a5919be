/* SPDX-License-Identifier: MIT */
/*
 * A packet against a triangle: for nearly all rays, float arithmetic with a bound on its error says surely not, or
 * surely yes and surely nearer. The rest are judged one by one (hit.h).
 *
 * With u = 2^-24 and everything computed in float, for one ray:
 *
 *   a = fl(v_i - o), b = fl(v_j - o), g = fl(v_j - v_i)    each off by u of itself
 *   s = fl(a + b)                                          off by 2 u (|a| + |b|)
 *   2 e = d . (s x g)         per product g u, s 2 u, itself u; subtraction u; product with d u; two sums 2 u: 8 u
 *   D = d . n, n = (b - a) x (c - a)     two differences, product, subtraction, product, two sums: 7 u
 *   N = fl(a - o) . n                    difference, n's 4, product, two sums: 8 u
 *
 * times M, the same expression with all signs made positive and |s| replaced by |a| + |b|. What is computed as M lacks
 * at most 8 u of itself, so 16 u M = 2^-20 M is a bound with a factor of two to spare. For M, |d| may be replaced by
 * anything larger: a whole packet shares the largest |d_k| of its rays, and so one bound.
 *
 * s x g = 2 (a x b), but where a x b cancels for a small triangle far away, s x g does not: its M shrinks with the
 * edge.
 *
 * Underflow: a float subtraction never underflows inexactly; each product may lose 2^-150, which later factors scale.
 * The sum of these losses is under 2^-149 (|d_x| + |d_y| + |d_z| + 2) for 2 e and D, and the same with |a - o| for N.
 * `floor` is 2^-146 (sum + 4). Overflow makes M infinite or NaN, and then no comparison below is true: undecided.
 *
 * Distances: t = N / D lies between (|N| - EN) / (|D| + ED) and (|N| + EN) / (|D| - ED), in signs that make D positive;
 * three roundings, paid for by a factor 1 -+ 2^-21, and 2^-148 for underflow of the quotient.
 */

#define QUOTIENT_BOUND 0x1p-21f
#define QUOTIENT_FLOOR 0x1p-148f

/* What the rays of a packet need to know of a triangle. Index 3 of cross and bound is the normal. */
struct triangle_terms {
    vf cross[4][3]; /* twice a x b, b x c, c x a relative to the origin; n */
    vf bound[4];    /* error bounds of d . cross[i] */
    vf distance;    /* N */
    vf distance_bound;
};

MLRT_INLINE void cross_product(const vf first[3], const vf second[3], vf cross[3])
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = v_sub(v_mul(first[i], second[j]), v_mul(first[j], second[i]));
    }
}

/* The cross product of magnitudes, all signs positive. */
MLRT_INLINE void cross_size(const vf first[3], const vf second[3], vf size[3])
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        size[k] = v_add(v_mul(first[i], second[j]), v_mul(first[j], second[i]));
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

/* Terms for rays of different origins, lane by lane; reach >= |d|. */
MLRT_INLINE void set_terms(const struct mlrt_triangle *triangle, const vf origin[3], const float reach[3],
                           struct triangle_terms *terms)
{
    const vf far[3] = {v_set1(reach[0]), v_set1(reach[1]), v_set1(reach[2])};
    vf vertex[3][3], away[3][3], edge[3][3], length[3][3], sum[3], sum_size[3], size[3];
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
            const float from = triangle->v[i][k], to = triangle->v[(i + 1) % 3][k];
            vertex[i][k] = v_sub(v_set1(from), origin[k]);
            away[i][k] = v_abs(vertex[i][k]);
            edge[i][k] = v_set1(to - from);
            length[i][k] = v_abs(edge[i][k]);
        }
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        for (int k = 0; k < 3; ++k) {
            sum[k] = v_add(vertex[i][k], vertex[j][k]);
            sum_size[k] = v_add(away[i][k], away[j][k]);
        }
        cross_product(sum, edge[i], terms->cross[i]);
        cross_size(sum_size, length[i], size);
        terms->bound[i] = dot_bound(far, size);
    }
    /* n = (b - a) x (c - a) = (a - c) x (b - a): the same products with the same signs. */
    cross_product(edge[2], edge[0], terms->cross[3]);
    cross_size(length[2], length[0], size);
    terms->bound[3] = dot_bound(far, size);
    terms->distance = dot_product(vertex[0], terms->cross[3]);
    terms->distance_bound = dot_bound(away[0], size);
}

/* Terms for rays of one origin, from what was set up; reach >= |d|. */
MLRT_INLINE void set_apex_terms(const struct mlrt_triangle_setup *setup, const float reach[3],
                                struct triangle_terms *terms)
{
    const float floor = (reach[0] + reach[1] + reach[2] + 4) * FILTER_FLOOR;
    float bound[4] = {0, 0, 0, 0};
    for (int i = 0; !MLRT_GUESS && i < 4; ++i) {
        bound[i] = (reach[0] * setup->size[0][i] + reach[1] * setup->size[1][i] + reach[2] * setup->size[2][i]) *
                       FILTER_BOUND +
                   floor;
    }
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) terms->cross[i][k] = v_set1(setup->cross[k][i]);
        terms->bound[i] = v_set1(bound[i]);
    }
    terms->distance = v_set1(setup->distance);
    terms->distance_bound = v_set1(setup->distance_bound);
}

/* What the filter says of a vector of rays; the lanes in neither have nothing to do with the triangle. */
struct verdict {
    vm nearer; /* surely hit, surely before the nearest hit so far */
    vm undecided;
    vm inside; /* surely inside all edges; of the undecided lanes only */
    vf lo;     /* where nearer: lo <= t <= hi */
    vf hi;
};

/* The best guess of a decision, for builds that measure what better ones cost (platform.h). */
MLRT_INLINE struct verdict guess_vector(const struct triangle_terms *terms, const struct mlrt_packet *packet, int v,
                                        vm active)
{
    const vf d[3] = {v_load(packet->direction[0] + v), v_load(packet->direction[1] + v),
                     v_load(packet->direction[2] + v)};
    const vf zero = v_set1(0);
    const vf ab = dot_product(d, terms->cross[0]), bc = dot_product(d, terms->cross[1]),
             ca = dot_product(d, terms->cross[2]);
    const vm above = m_and(m_and(v_ge(ab, zero), v_ge(bc, zero)), v_ge(ca, zero));
    const vm below = m_and(m_and(v_le(ab, zero), v_le(bc, zero)), v_le(ca, zero));
    struct verdict verdict;
    verdict.nearer = m_and(active, m_or(above, below));
    verdict.undecided = verdict.inside = m_andnot(active, active);
    verdict.lo = verdict.hi = zero;
    if (!m_bits(verdict.nearer)) return verdict;
    const vf t = v_div(terms->distance, dot_product(d, terms->cross[3]));
    verdict.lo = verdict.hi = t;
    verdict.nearer = m_and(verdict.nearer, m_and(v_gt(t, v_load(packet->t_min + v)), v_lt(t, v_load(packet->hi + v))));
    return verdict;
}

MLRT_INLINE struct verdict filter_vector(const struct triangle_terms *terms, const struct mlrt_packet *packet, int v,
                                         vm active)
{
    const vf d[3] = {v_load(packet->direction[0] + v), v_load(packet->direction[1] + v),
                     v_load(packet->direction[2] + v)};
    if (MLRT_GUESS) return guess_vector(terms, packet, v, active);
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
    verdict.nearer = verdict.undecided = verdict.inside = candidates;
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
    verdict.inside = m_and(m_and(candidates, certain), m_or(all_above, all_below));
    verdict.nearer = m_and(verdict.inside, nearer);
    verdict.undecided = m_andnot(m_andnot(candidates, m_and(certain, farther)), verdict.nearer);
    return verdict;
}

/* Do two triangles lie in one plane? A worker remembers the last answers, since neighbours ask the same. */
static int share_plane(const struct mlrt_tree *tree, uint32_t first, uint32_t second, struct mlrt_worker *worker)
{
    struct mlrt_plane_pair *pair = &worker->pairs[(first ^ second) % MLRT_PLANE_PAIR_COUNT];
    if (pair->first != first || pair->second != second) {
        pair->first = first;
        pair->second = second;
        pair->share = mlrt_share_plane(&tree->triangles[first], &tree->triangles[second]);
    }
    return pair->share;
}

/*
 * Exact ties are common: things drawn twice, walls of one plane. Where the nearest hit so far lies in the plane of the
 * triangle, so does the ray's hit of it: at the same t, which is known to be in range. So the later of the two in the
 * input changes nothing, whether it is hit or not, and the earlier one replaces the other where it is surely inside.
 * Returns the lanes of `lanes` that are settled so.
 */
static MLRT_NOINLINE uint32_t settle_ties(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes,
                                          uint32_t inside, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    uint32_t settled = 0;
    for (uint32_t lane = 0; lanes >> lane; ++lane) {
        const uint32_t nearest = packet->triangle[lane];
        if (!(lanes >> lane & 1) || nearest == MLRT_NONE) continue;
        const int earlier = number < nearest;
        if (earlier && !(inside >> lane & 1)) continue;
        if (!share_plane(tree, number, nearest, worker)) continue;
        if (earlier) packet->triangle[lane] = number;
        settled |= 1u << lane;
    }
    return settled;
}

/* Hands single lanes to the judge. Returns those that are hit nearer than before. */
static MLRT_NOINLINE uint32_t judge_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes,
                                          struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    uint32_t hit = 0;
    for (uint32_t lane = 0; lanes >> lane; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        struct mlrt_ray_segment ray;
        mlrt_get_segment(packet, lane, &ray);
        struct mlrt_nearest nearest = {packet->triangle[lane], packet->lo[lane], packet->hi[lane]};
        if (!mlrt_offer_triangle(tree, &ray, number, &nearest, MLRT_COUNTING ? &worker->counters : NULL)) continue;
        packet->triangle[lane] = nearest.triangle;
        packet->lo[lane] = nearest.lo;
        packet->hi[lane] = nearest.hi;
        hit |= 1u << lane;
    }
    return hit;
}

/*
 * Tests the rays of `group` in the lanes `lanes` against triangle `number` and updates their nearest hits. `setup` is
 * that of the triangle if the rays have a common origin, else NULL. Returns the lanes whose nearest hit changed.
 */
static uint32_t test_triangle(const struct mlrt_tree *tree, uint32_t number, const struct mlrt_triangle_setup *setup,
                              const struct ray_group *group, uint32_t lanes, struct mlrt_packet *packet,
                              struct mlrt_worker *worker)
{
    const float reach[3] = {group->axis[0].reach, group->axis[1].reach, group->axis[2].reach};
    struct triangle_terms terms;
    terms.distance = terms.distance_bound = v_set1(0);
    if (setup) set_apex_terms(setup, reach, &terms);
    uint32_t changed = 0, undecided = 0, inside = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        if (!(lanes >> v & ALL_LANES)) continue;
        /* A triangle met again in another leaf is no news to the rays that it is the nearest of. */
        vm active = m_andnot(m_from_bits(lanes >> v), i_eq(i_load(packet->triangle + v), i_set1(number)));
        if (packet->has_skip) active = m_andnot(active, i_eq(i_load(packet->skip + v), i_set1(number)));
        if (!m_bits(active)) continue;
        COUNT(&worker->counters, lane_test_count, mlrt_count_bits(m_bits(active)));
        if (!setup) {
            const vf origin[3] = {v_load(packet->origin[0] + v), v_load(packet->origin[1] + v),
                                  v_load(packet->origin[2] + v)};
            set_terms(&tree->triangles[number], origin, reach, &terms);
        }
        const struct verdict verdict = filter_vector(&terms, packet, v, active);
        const uint32_t nearer = m_bits(verdict.nearer);
        if (nearer) {
            v_store(packet->lo + v, v_select(verdict.nearer, verdict.lo, v_load(packet->lo + v)));
            v_store(packet->hi + v, v_select(verdict.nearer, verdict.hi, v_load(packet->hi + v)));
            i_store(packet->triangle + v, i_select(verdict.nearer, i_set1(number), i_load(packet->triangle + v)));
            changed |= nearer << v;
        }
        undecided |= m_bits(verdict.undecided) << v;
        inside |= m_bits(verdict.inside) << v;
    }
    if (MLRT_LIKELY(!undecided)) return changed;
    const uint32_t tied = settle_ties(tree, number, undecided, inside, packet, worker);
    undecided &= ~tied;
    COUNT(&worker->counters, tie_lane_count, mlrt_count_bits(tied));
    if (!undecided) return changed;
    COUNT(&worker->counters, undecided_test_count, 1);
    COUNT(&worker->counters, judged_lane_count, mlrt_count_bits(undecided));
    return changed | judge_lanes(tree, number, undecided, packet, worker);
}
