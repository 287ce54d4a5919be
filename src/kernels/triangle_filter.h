/* SPDX-License-Identifier: MIT */
/*
 * A packet against a triangle: for nearly all rays, float arithmetic with a bound on its error says surely not, or
 * surely yes and surely nearer. The rest are judged one by one (hit.h).
 *
 * WHAT IS COMPUTED. Relative to the origin o let a = fl(v_i - o), b = fl(v_j - o), and g = fl(v_j - v_i) from the
 * corners themselves. Then
 *
 *     e' = d . ((a + b) x g / size)        has the sign of the edge function e_ij
 *     D' = d . (n / size)                  n = (a - c) x (b - a)
 *     N' = fl(a - o) . (n / size)          so t = N' / D'
 *
 * where size belongs to the cross product. With M_k the sum of the magnitudes of the two products in its component k,
 * |a| + |b| in place of |a + b|, it is M_main + (M_j + M_l) / 2, where the main axis is that along which the rays go.
 * |a_k| + |b_k| is the larger of |a_k + b_k| and |a_k - b_k|, so of what is there already, but for 3 u of itself; for n
 * something larger does no harm. (a + b) x g = 2 (a x b), but where a x b cancels for a small triangle far away, this
 * does not: its error shrinks with the edge. Only signs of e' and ratios of N' and D' matter, so they can be scaled,
 * and scaled like this they have one bound for all triangles.
 *
 * EDGES, with u = 2^-24 and R the largest of |d_main|, 2 |d_j|, 2 |d_l| of the rays at hand. Roundings of a component
 * of a + b: 1 for each of a and b, 1 for their sum, together 2 u of |a_k| + |b_k| (not of |a_k + b_k|, which can be
 * much smaller). The edge has 1, the products of the cross product 1, their subtraction 1, 1 / size 1, the product with
 * it 1; in the dot product the products have 1 and the sums 2. That makes 10, relative to the sum of |d_k| M_k / size,
 * which is at most R for the size without rounding. As computed it is less by at most 8 roundings. So
 * |e' - exact| <= 10.001 u R.
 *
 * Underflow: float sums have none. A product in the cross product may lose 2^-150; since size is made at least 2^-100,
 * the three components lose no more than 2^-47 R in all. The product with 1 / size may lose 2^-150 and so may those
 * with d: nothing beside u R, since R >= 2^-60 (packet.h). So EDGE_BOUND R = 11 u R is a bound. Overflow: magnitudes up
 * to 2^60 make sizes of at most 2^125, whose reciprocals are no denormals. So all of this is finite: there is no NaN,
 * which v_min would drop. Without a least size there would be: a cross product can underflow to 0 altogether.
 *
 * DISTANCES. D' has 9 roundings, so it is off by 9.001 u R, and |D'| < 1.001 R. N' has 10; with A made of a as R is of
 * d it is off by 10.001 u A, and by 2^-148 where its products underflow, and |N'| < 1.001 A. In signs that make D'
 * positive, let E = 12 u A + 2^-82 and W = 16 u R. Rounded themselves, N' -+ E are bounds on either side with 2^-83 to
 * spare, and D' -+ W with 5.9 u R.
 *
 * So t < x if N' + E < x (D' - W), and t > x if N' - E > x (D' + W), for x >= 0: the rounding of the product takes 1.1
 * u R of what W has to spare, and the 2^-150 it may lose are nothing beside 2^-83. x may be infinite, and so may the
 * product: D' - W is positive where it counts, and no N' is infinite.
 *
 * Let D' > 2 W and s = W / D'. Then t lies between (N' - E) / D' (1 - s) and (N' + E) / D' (1 + 2 s): D' is off
 * by 9.001 / 16 s of itself, and what s has to spare, 6.9 u at least, pays for the four roundings of each. They may
 * lose 2^-149, less than 2^-83 / D'. The lower end is kept of hits only, and is finite: along some axis |d_k| >= 2^-60,
 * and a hit is no farther than 2^61, so t <= 2^121. (The upper one may be infinite.)
 */

/* What the rays of a packet need to know of a triangle. Index 3 of cross is the normal. */
struct triangle_terms {
    vf cross[4][3]; /* (a + b) x (b - a) and so on relative to the origin, and n; each scaled by its size */
    vf distance;    /* N' */
    vf distance_bound;
};

MLRT_INLINE void cross_product(const vf first[3], const vf second[3], vf cross[3])
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = v_sub(v_mul(first[i], second[j]), v_mul(first[j], second[i]));
    }
}

MLRT_INLINE vf dot_product(const vf a[3], const vf b[3])
{
    return v_add(v_add(v_mul(a[0], b[0]), v_mul(a[1], b[1])), v_mul(a[2], b[2]));
}

/* The cross product of what stands for a vertex and an edge, scaled by its size. */
MLRT_INLINE void scaled_cross_product(const vf sum[3], const vf edge[3], uint32_t main_axis, vf cross[3])
{
    cross_product(sum, edge, cross);
    if (MLRT_GUESS) return;
    const uint32_t a = main_axis, j = (a + 1) % 3, l = (a + 2) % 3;
    vf reach[3], length[3];
    for (int k = 0; k < 3; ++k) {
        length[k] = v_abs(edge[k]);
        reach[k] = v_max(v_abs(sum[k]), length[k]);
    }
    const vf main = v_add(v_mul(reach[j], length[l]), v_mul(reach[l], length[j]));
    const vf others = v_add(v_mul(reach[a], v_add(length[j], length[l])), v_mul(length[a], v_add(reach[j], reach[l])));
    const vf size = v_add(main, v_mul(others, v_set1(0.5f)));
    const vf scale = v_div(v_set1(1), v_max(size, v_set1(SMALLEST_SIZE)));
    for (int k = 0; k < 3; ++k) cross[k] = v_mul(cross[k], scale);
}

/* Terms for rays of different origins, lane by lane. */
MLRT_INLINE void set_terms(const struct mlrt_triangle *triangle, const vf origin[3], uint32_t main_axis,
                           struct triangle_terms *terms)
{
    vf vertex[3][3], edge[3][3], sum[3];
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
            const float from = triangle->v[i][k], to = triangle->v[(i + 1) % 3][k];
            vertex[i][k] = v_sub(v_set1(from), origin[k]);
            edge[i][k] = v_set1(to - from);
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) sum[k] = v_add(vertex[i][k], vertex[(i + 1) % 3][k]);
        scaled_cross_product(sum, edge[i], main_axis, terms->cross[i]);
    }
    /* n = (b - a) x (c - a) = (a - c) x (b - a) */
    scaled_cross_product(edge[2], edge[0], main_axis, terms->cross[3]);
    terms->distance = dot_product(vertex[0], terms->cross[3]);
    const vf other = v_max(v_abs(vertex[0][(main_axis + 1) % 3]), v_abs(vertex[0][(main_axis + 2) % 3]));
    const vf farthest = v_max(v_abs(vertex[0][main_axis]), v_mul(other, v_set1(2)));
    terms->distance_bound = v_add(v_mul(farthest, v_set1(DISTANCE_BOUND)), v_set1(DISTANCE_FLOOR));
}

/* Terms for rays of one origin, from what was set up. */
MLRT_INLINE void set_apex_terms(const struct mlrt_triangle_setup *setup, struct triangle_terms *terms)
{
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) terms->cross[i][k] = v_set1(setup->cross[k][i]);
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

/* What the decision needs: computed numbers, and bounds of their errors. */
struct float_test {
    vf least; /* of the edge functions */
    vf greatest;
    vf above; /* their bound, and its negative */
    vf below;
    vf determinant;
    vf plane_bound;
    vf distance;
    vf distance_bound;
};

/* Lanes that are not surely outside. */
MLRT_INLINE vm may_be_inside(const struct float_test *test, vm active)
{
    return m_andnot(active, m_and(v_gt(test->greatest, test->above), v_lt(test->least, test->below)));
}

/* The verdict on lanes that are not surely outside; lo and hi are of the nearest hits so far. */
MLRT_INLINE struct verdict compare_distances(const struct float_test *test, vm candidates, vf t_min, vf lo, vf hi)
{
    struct verdict verdict;
    const vf size = v_abs(test->determinant), distance = v_flip(test->distance, test->determinant);
    const vf least_d = v_sub(size, test->plane_bound), greatest_d = v_add(size, test->plane_bound);
    const vf least_n = v_sub(distance, test->distance_bound), greatest_n = v_add(distance, test->distance_bound);
    const vm certain = m_and(candidates, v_gt(least_d, test->plane_bound));
    const vm farther = m_or(v_gt(least_n, v_mul(hi, greatest_d)), v_le(greatest_n, v_mul(t_min, least_d)));
    const vm nearer = m_and(v_lt(greatest_n, v_mul(lo, least_d)), v_gt(least_n, v_mul(t_min, greatest_d)));
    verdict.inside = m_and(certain, m_or(v_gt(test->least, test->above), v_lt(test->greatest, test->below)));
    verdict.nearer = m_and(verdict.inside, nearer);
    verdict.undecided = m_andnot(m_andnot(candidates, m_and(certain, farther)), verdict.nearer);
    verdict.lo = verdict.hi = v_set1(0);
    if (!m_bits(verdict.nearer)) return verdict;
    const vf inverse = v_div(v_set1(1), size), slack = v_mul(inverse, test->plane_bound);
    verdict.lo = v_mul(v_mul(least_n, inverse), v_sub(v_set1(1), slack));
    verdict.hi = v_mul(v_mul(greatest_n, inverse), v_add(v_set1(1), v_add(slack, slack)));
    return verdict;
}

/* `reach` is R. */
MLRT_INLINE struct verdict filter_vector(const struct triangle_terms *terms, float reach,
                                         const struct mlrt_packet *packet, int v, vm active)
{
    if (MLRT_GUESS) return guess_vector(terms, packet, v, active);
    const vf d[3] = {v_load(packet->direction[0] + v), v_load(packet->direction[1] + v),
                     v_load(packet->direction[2] + v)};
    const vf ab = dot_product(d, terms->cross[0]), bc = dot_product(d, terms->cross[1]),
             ca = dot_product(d, terms->cross[2]);
    struct float_test test;
    test.least = v_min(v_min(ab, bc), ca);
    test.greatest = v_max(v_max(ab, bc), ca);
    test.above = v_set1(EDGE_BOUND * reach);
    test.below = v_set1(-EDGE_BOUND * reach);
    const vm candidates = may_be_inside(&test, active);
    if (!m_bits(candidates)) return (struct verdict){candidates, candidates, candidates, v_set1(0), v_set1(0)};
    test.determinant = dot_product(d, terms->cross[3]);
    test.plane_bound = v_set1(PLANE_BOUND * reach);
    test.distance = terms->distance;
    test.distance_bound = terms->distance_bound;
    return compare_distances(&test, candidates, v_load(packet->t_min + v), v_load(packet->lo + v),
                             v_load(packet->hi + v));
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
static uint32_t settle_ties(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                            struct mlrt_packet *packet, struct mlrt_worker *worker)
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
static uint32_t judge_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, struct mlrt_packet *packet,
                            struct mlrt_worker *worker)
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

/* What filter_lanes has to say: lanes that are nearer, and what is left of the others. */
struct outcome {
    uint32_t nearer;
    uint32_t undecided;
    uint32_t inside;
};

/* The float part of test_triangle. `setup` is NULL, or not, at compile time. */
MLRT_INLINE struct outcome filter_lanes(const struct mlrt_tree *tree, uint32_t number,
                                        const struct mlrt_triangle_setup *setup, const struct ray_group *group,
                                        uint32_t lanes, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    struct triangle_terms terms;
    struct outcome outcome = {0, 0, 0};
    if (setup) set_apex_terms(setup, &terms);
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
            set_terms(&tree->triangles[number], origin, group->axis_code & 3, &terms);
        }
        const struct verdict verdict = filter_vector(&terms, group->reach, packet, v, active);
        const uint32_t nearer = m_bits(verdict.nearer);
        if (nearer) {
            v_store(packet->lo + v, v_select(verdict.nearer, verdict.lo, v_load(packet->lo + v)));
            v_store(packet->hi + v, v_select(verdict.nearer, verdict.hi, v_load(packet->hi + v)));
            i_store(packet->triangle + v, i_select(verdict.nearer, i_set1(number), i_load(packet->triangle + v)));
            outcome.nearer |= nearer << v;
        }
        outcome.undecided |= m_bits(verdict.undecided) << v;
        outcome.inside |= m_bits(verdict.inside) << v;
    }
    return outcome;
}

/* What the filter leaves of a test: exact ties, and then the judge. Returns the lanes whose nearest hit changed. */
static MLRT_NOINLINE uint32_t decide_lanes(const struct mlrt_tree *tree, uint32_t number, const struct outcome *outcome,
                                           struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const uint32_t tied = settle_ties(tree, number, outcome->undecided, outcome->inside, packet, worker);
    const uint32_t undecided = outcome->undecided & ~tied;
    COUNT(&worker->counters, tie_lane_count, mlrt_count_bits(tied));
    if (!undecided) return 0;
    COUNT(&worker->counters, undecided_test_count, 1);
    COUNT(&worker->counters, judged_lane_count, mlrt_count_bits(undecided));
    return judge_lanes(tree, number, undecided, packet, worker);
}

/*
 * Tests the rays of `group` in the lanes `lanes` against triangle `number` and updates their nearest hits. `setup` is
 * that of the triangle if the rays have a common origin, else NULL. Returns the lanes whose nearest hit changed.
 */
MLRT_INLINE uint32_t test_triangle(const struct mlrt_tree *tree, uint32_t number,
                                   const struct mlrt_triangle_setup *setup, const struct ray_group *group,
                                   uint32_t lanes, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const struct outcome outcome = filter_lanes(tree, number, setup, group, lanes, packet, worker);
    if (MLRT_LIKELY(!outcome.undecided)) return outcome.nearer;
    return outcome.nearer | decide_lanes(tree, number, &outcome, packet, worker);
}

/* The same for rays of one origin, and for rays of different ones. */
static uint32_t test_triangle_from_apex(const struct mlrt_tree *tree, uint32_t number,
                                        const struct mlrt_triangle_setup *setup, const struct ray_group *group,
                                        uint32_t lanes, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    return test_triangle(tree, number, setup, group, lanes, packet, worker);
}

static uint32_t test_triangle_from_anywhere(const struct mlrt_tree *tree, uint32_t number,
                                            const struct ray_group *group, uint32_t lanes, struct mlrt_packet *packet,
                                            struct mlrt_worker *worker)
{
    return test_triangle(tree, number, NULL, group, lanes, packet, worker);
}
