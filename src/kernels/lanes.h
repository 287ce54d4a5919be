/* SPDX-License-Identifier: MIT */
/*
 * Lane by lane: a packet whose rays have too little in common for a hull goes down the hierarchy of boxes with each lane
 * tested against each box. A leaf costs the lesser of its lanes, each against all triangles at once, and of its triangles,
 * each against all lanes at once. From the box on that few lanes meet, these go one by one.
 *
 * All arithmetic, and its bounds, are those of single rays (bvh_single.h), with rays in the lanes in place of boxes or
 * triangles. Where the signs of all directions agree, boxes are first picked by intervals of origins and reciprocals: the
 * product of a difference and a reciprocal lies between those of the intervals' ends, and roundings are monotone.
 *
 * Based on: I. Wald, C. Benthin, P. Slusallek, "Interactive Rendering with Coherent Ray Tracing", 2001 (packets against
 * one box); C. Benthin et al., "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC
 * Architecture", 2012 (the way from packets to single rays).
 */

/* So many lanes, or fewer, go one by one. */
#define FEW_LANES 6

/* In trees of more nodes, rays whose directions have different signs go one by one from the root on. */
#ifndef SMALL_TREE
#define SMALL_TREE 100
#endif

struct pending_lanes {
    float near;
    uint32_t child;
    uint32_t lanes;
};

/* A packet's rays as boxes are tested against them. */
struct lanes_search {
    struct mlrt_reciprocals reciprocals;
    uint32_t negative[3]; /* lanes whose direction goes down an axis */
    int agree;            /* the signs of all lanes are equal, and no component is 0 */
    float origin_lo[3], origin_hi[3];
    float reciprocal_lo[3], reciprocal_hi[3];
    float least_t_min;
    uint32_t alive; /* lanes that still look */
    uint32_t count;
    struct pending_lanes stack[WAITING_LIMIT];
};

static MLRT_NOINLINE void begin_lanes(const struct mlrt_packet *packet, uint32_t lanes, struct lanes_search *search)
{
    set_reciprocals(packet, &search->reciprocals);
    search->alive = lanes;
    search->count = 0;
    search->agree = 1;
    search->least_t_min = lowest(packet->t_min, lanes);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        uint32_t negative = 0, zero = 0;
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            const vf d = v_load(packet->direction[k] + v);
            negative |= m_bits(v_lt(d, v_set1(0))) << v;
            zero |= m_bits(v_eq(d, v_set1(0))) << v;
        }
        search->negative[k] = negative & lanes;
        if (zero & lanes || (search->negative[k] && search->negative[k] != lanes)) search->agree = 0;
    }
    for (int k = 0; search->agree && k < 3; ++k) {
        search->origin_lo[k] = packet->has_apex ? packet->apex[k] : lowest(packet->origin[k], lanes);
        search->origin_hi[k] = packet->has_apex ? packet->apex[k] : highest(packet->origin[k], lanes);
        const float *smaller = search->negative[k] ? search->reciprocals.far[k] : search->reciprocals.near[k];
        const float *larger = search->negative[k] ? search->reciprocals.near[k] : search->reciprocals.far[k];
        search->reciprocal_lo[k] = lowest(smaller, lanes);
        search->reciprocal_hi[k] = highest(larger, lanes);
    }
}

/* The boxes of a node that rays between these origins and reciprocals may meet. */
MLRT_INLINE uint32_t boxes_of_lanes(const struct lanes_search *search, const struct mlrt_bvh_node *node, float farthest)
{
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_WIDTH; v += VW) {
        vf first = v_set1(search->least_t_min), last = v_set1(farthest);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            const int down = search->negative[k] != 0;
            const vf lo = v_set1(search->reciprocal_lo[k]), hi = v_set1(search->reciprocal_hi[k]);
            const vf near = v_sub(v_load((down ? node->hi : node->lo)[k] + v),
                                  v_set1(down ? search->origin_lo[k] : search->origin_hi[k]));
            const vf far = v_sub(v_load((down ? node->lo : node->hi)[k] + v),
                                 v_set1(down ? search->origin_hi[k] : search->origin_lo[k]));
            first = v_max(v_min(v_mul(near, lo), v_mul(near, hi)), first);
            last = v_min(v_max(v_mul(far, lo), v_mul(far, hi)), last);
        }
        met |= m_bits(v_le(first, last)) << v;
    }
    return met;
}

/* Of `lanes` those that may meet a box; *near receives where the first of them does. */
MLRT_INLINE uint32_t lanes_in_box(const struct lanes_search *search, const struct mlrt_packet *packet,
                                  const struct mlrt_bvh_node *node, uint32_t place, uint32_t lanes, float *near)
{
    uint32_t met = 0;
    vf nearest = v_set1(INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf first = v_load(packet->t_min + v), last = v_min(v_load(packet->hi + v), v_set1(FLT_MAX));
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            const vf lo = v_set1(node->lo[k][place]), hi = v_set1(node->hi[k][place]);
            const vm down = m_from_bits(search->negative[k] >> v);
            const vf origin = origin_component(packet, k, v);
            const vf to_near = v_sub(v_select(down, hi, lo), origin), to_far = v_sub(v_select(down, lo, hi), origin);
            first = v_max(v_mul(to_near, v_load(search->reciprocals.near[k] + v)), first);
            last = v_min(v_mul(to_far, v_load(search->reciprocals.far[k] + v)), last);
        }
        const vm hit = m_and(m_from_bits(lanes >> v), v_le(first, last));
        nearest = v_min(v_select(hit, first, v_set1(INFINITY)), nearest);
        met |= m_bits(hit) << v;
    }
    *near = v_hmin(nearest);
    return met;
}

/* Puts the children of a node that lanes may meet on the stack, the nearest on top. */
MLRT_INLINE void push_lanes(const struct mlrt_packet *packet, const struct mlrt_bvh_node *node, uint32_t lanes,
                            struct lanes_search *search)
{
    const uint32_t base = search->count;
    uint32_t boxes = ~m_bits(m_from_bits(0)) & 0xFFFF;
    if (search->agree) {
        boxes = boxes_of_lanes(search, node, finite_limit(highest(packet->hi, lanes)));
    }
    for (; boxes; boxes &= boxes - 1) {
        const uint32_t place = mlrt_lowest_bit(boxes);
        float near;
        if (!node->child[place]) continue;
        const uint32_t met = lanes_in_box(search, packet, node, place, lanes, &near);
        if (!met) continue;
        uint32_t at = search->count++;
        for (; at > base && search->stack[at - 1].near < near; --at) search->stack[at] = search->stack[at - 1];
        search->stack[at] = (struct pending_lanes){near, node->child[place], met};
    }
}

/* Tests lanes against one triangle. Returns those whose nearest hit changed. */
static MLRT_NOINLINE uint32_t test_triangle_by_lanes(const struct mlrt_job *job, uint32_t lanes,
                                                     const float *corners, uint32_t row, uint32_t number,
                                                     struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    struct outcome outcome = {0, 0, 0};
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        if (!(lanes >> v & ALL_LANES)) continue;
        const vm active = concerned_rays(packet, lanes, number, v);
        vf s[3], f[3], g[3], d[3], reach = v_set1(0);
        MLRT_UNROLL
        for (uint32_t k = 0; k < 3; ++k) {
            const float a = corners[k * row];
            s[k] = v_sub(origin_component(packet, (int)k, v), v_set1(a));
            f[k] = v_set1(corners[(3 + k) * row] - a);
            g[k] = v_set1(corners[(6 + k) * row] - a);
            d[k] = v_load(packet->direction[k] + v);
            reach = v_max(v_abs(d[k]), reach);
        }
        struct float_test test;
        set_float_test(s, f, g, d, v_mul(reach, v_set1(4)), &test);
        const vm candidates = may_be_inside(&test, active);
        if (!m_bits(candidates)) continue;
        const struct verdict verdict = compare_distances(&test, candidates, v_load(packet->t_min + v),
                                                         v_load(packet->lo + v), v_load(packet->hi + v));
        keep_verdict(&verdict, number, v, packet, &outcome);
    }
    if (MLRT_LIKELY(!outcome.undecided) || MLRT_GUESS) return outcome.nearer;
    return outcome.nearer |
           decide_scaled_lanes(job, number, outcome.undecided, outcome.inside, packet, worker);
}

/* Tests lanes against the triangles of a leaf. */
static MLRT_NOINLINE void test_leaf_by_lanes(const struct mlrt_job *job, uint32_t leaf, uint32_t lanes,
                                             struct lanes_search *search, struct mlrt_packet *packet,
                                             struct mlrt_worker *worker)
{
    const struct mlrt_bvh *bvh = &job->tree->bvh;
    const uint32_t row = 4 * mlrt_bvh_quad_count(leaf);
    const float *corners = bvh->corners + (size_t)36 * mlrt_bvh_offset(leaf);
    const uint32_t *numbers = bvh->numbers + (size_t)4 * mlrt_bvh_offset(leaf);
    if (mlrt_count_bits(lanes) < row) {
        for (; lanes; lanes &= lanes - 1) {
            const uint32_t lane = mlrt_lowest_bit(lanes);
            struct single_ray ray;
            set_single_ray(packet, &search->reciprocals, lane, &ray);
            if (test_leaf(job, &ray, leaf, packet, worker) && job->any) search->alive &= ~(1u << lane);
        }
        return;
    }
    for (uint32_t i = 0; i < row && numbers[i] != MLRT_NONE && lanes; ++i) {
        uint32_t seeing = lanes;
        if (MLRT_UNLIKELY(packet->has_masks)) {
            seeing = mlrt_seeing_lanes(job->tree, numbers[i], packet->mask, lanes);
        } else if (MLRT_UNLIKELY(worker->mask != MLRT_MASK_ALL) && mlrt_is_hidden(job->tree, numbers[i], worker->mask)) {
            seeing = 0;
        }
        if (!seeing) continue;
        COUNT(&worker->counters, triangle_test_count, 1);
        COUNT(&worker->counters, lane_test_count, mlrt_count_bits(seeing));
        const uint32_t changed = test_triangle_by_lanes(job, seeing, corners + i, row, numbers[i], packet, worker);
        if (!job->any) continue;
        lanes &= ~changed;
        search->alive &= ~changed;
    }
}

/* Lanes that go one by one from a child of a node on. */
static MLRT_NOINLINE void trace_few_lanes(const struct mlrt_job *job, uint32_t child, uint32_t lanes,
                                          struct lanes_search *search, struct mlrt_packet *packet,
                                          struct mlrt_worker *worker)
{
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        trace_single(job, &search->reciprocals, lane, child, packet, worker);
        if (job->any && packet->triangle[lane] != MLRT_NONE) search->alive &= ~(1u << lane);
    }
}

/* Traces the rays of a packet in the lanes `lanes`, which are in units. */
static void trace_lanes_in_units(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                                 struct mlrt_worker *worker)
{
    const struct mlrt_bvh_node *nodes = job->tree->bvh.nodes;
    struct lanes_search search;
    uint32_t child = 0;
    begin_lanes(packet, lanes, &search);
    if (mlrt_count_bits(lanes) <= FEW_LANES || (!search.agree && job->tree->bvh.node_count > SMALL_TREE)) {
        trace_few_lanes(job, 0, lanes, &search, packet, worker);
        return;
    }
    COUNT(&worker->counters, packet_count, 1);
    for (;;) {
        COUNT(&worker->counters, cell_count, 1);
        if (mlrt_bvh_quad_count(child) == 0) {
            push_lanes(packet, &nodes[mlrt_bvh_offset(child)], lanes, &search);
        } else {
            test_leaf_by_lanes(job, child, lanes, &search, packet, worker);
        }
        for (;;) {
            if (search.count == 0) return;
            const struct pending_lanes *top = &search.stack[--search.count];
            lanes = top->lanes & search.alive;
            if (!lanes) continue;
            if (!job->any) {
                uint32_t before = 0;
                for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
                    before |= m_bits(v_le(v_set1(top->near), v_load(packet->hi + v))) << v;
                }
                lanes &= before;
                if (!lanes) continue;
            }
            child = top->child;
            if (mlrt_count_bits(lanes) > FEW_LANES) break;
            trace_few_lanes(job, child, lanes, &search, packet, worker);
        }
    }
}

/* Traces the rays of a packet in the lanes `lanes`. A bundle bears directions that must be brought into units first even
 * if the unit is 1. */
static MLRT_NOINLINE void trace_lanes(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                                      struct mlrt_worker *worker)
{
    const float unit = job->tree->bvh.unit;
    if (job->tree->bvh.node_count == 0 || !lanes) return;
    struct checked_lanes directions;
    check_lanes(packet->direction, &directions);
    if (MLRT_LIKELY(unit == 1 && !(lanes & ~directions.safe))) {
        trace_lanes_in_units(job, lanes, packet, worker);
        return;
    }
    struct mlrt_scaled_packet scaled;
    const uint32_t carried = scale_packet(lanes, unit, packet, &scaled);
    worker->scaled = &scaled;
    if (carried) trace_lanes_in_units(job, carried, &scaled.rays, worker);
    worker->scaled = NULL;
    take_scaled_hits(&scaled, carried);
    if (lanes & ~carried) mlrt_trace_single_rays(job, lanes & ~carried, packet, COUNTERS(worker));
}
