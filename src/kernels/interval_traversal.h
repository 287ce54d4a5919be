/* SPDX-License-Identifier: MIT */
/*
 * Interval traversal: a packet goes down the tree as one, by the interval of distances at which its rays can be in a
 * cell. The cost of a step does not depend on the number of rays.
 *
 * With all signs of a direction component equal, the distances of a group's rays to the plane x_k = c are within
 * (c - o_k) [1 / |d|_max, 1 / |d|_min]. c - o_k has one rounding, the reciprocals and the products one each: the
 * reciprocals are moved apart by a factor 1 -+ 2^-21, which pays for all of them; packet.h's limits on the magnitudes
 * rule out overflow and underflow. d_k = 0 makes a reciprocal infinite; in the plane itself the product is then a NaN,
 * every comparison is false, and both children are visited. Comparisons are strict, so a ray that grazes a plane, and a
 * cell without thickness, see both sides.
 *
 * Based on: Reshetov et al. 2005, section 4.3.
 */

#define RECIPROCAL_SLACK 0x1p-21f

/* Where a traversal starts: a node, and a box that contains all that matters of its cell. */
struct entry_point {
    uint32_t node;
    uint32_t depth;
    struct mlrt_box box;
};

struct distance_interval {
    float lo;
    float hi;
};

/* The rays of a group along one axis. */
struct group_axis {
    float origin_lo;
    float origin_hi;
    float small; /* reciprocals of the direction, with its sign: smallest and largest magnitude */
    float large; /* may be infinite */
    uint32_t negative;
};

MLRT_INLINE struct distance_interval plane_distances(const struct group_axis *axis, float c)
{
    const float x = c - axis->origin_hi, y = c - axis->origin_lo;
    const float a = x * axis->small, b = x * axis->large;
    struct distance_interval t;
    /* The operand that can be a NaN stands second, where the comparison keeps it. */
    t.lo = a < b ? a : b;
    t.hi = a > b ? a : b;
    if (x == y) return t;
    const float e = y * axis->small, f = y * axis->large;
    const float lo = e < f ? e : f, hi = e > f ? e : f;
    t.lo = t.lo < lo ? t.lo : lo;
    t.hi = t.hi > hi ? t.hi : hi;
    return t;
}

/* Bounds of the rays of a group over a vector array. Lanes outside count as `other`. */
MLRT_INLINE float lowest(const float *values, uint32_t lanes)
{
    vf all = v_set1(INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        all = v_min(v_select(m_from_bits(lanes >> v), v_load(values + v), v_set1(INFINITY)), all);
    }
    return v_hmin(all);
}

MLRT_INLINE float highest(const float *values, uint32_t lanes)
{
    vf all = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        all = v_max(v_select(m_from_bits(lanes >> v), v_load(values + v), v_set1(-INFINITY)), all);
    }
    return v_hmax(all);
}

/* Lanes of the packet whose direction component is negative. */
MLRT_INLINE uint32_t negative_lanes(const struct mlrt_packet *packet, int k)
{
    uint32_t negative = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        negative |= m_bits(v_lt(v_load(packet->direction[k] + v), v_set1(0))) << v;
    }
    return negative;
}

/* Of `lanes`, those that agree with the lowest of them in all three signs. */
MLRT_INLINE uint32_t same_sign_lanes(const uint32_t negative[3], uint32_t lanes)
{
    const uint32_t lowest_lane = lanes & (0u - lanes);
    uint32_t same = lanes;
    for (int k = 0; k < 3; ++k) same &= (negative[k] & lowest_lane) ? negative[k] : ~negative[k];
    return same;
}

MLRT_INLINE void set_group_axis(const struct mlrt_packet *packet, uint32_t lanes, int k, struct group_axis *axis,
                                float *reach)
{
    const float lo = lowest(packet->direction[k], lanes), hi = highest(packet->direction[k], lanes);
    axis->negative = lo < 0;
    const float largest = axis->negative ? lo : hi, smallest = axis->negative ? hi : lo;
    axis->small = (1 / largest) * (1 - RECIPROCAL_SLACK);
    axis->large = (1 / smallest) * (1 + RECIPROCAL_SLACK);
    *reach = largest < 0 ? -largest : largest;
    if (packet->has_apex) {
        axis->origin_lo = axis->origin_hi = packet->apex[k];
    } else {
        axis->origin_lo = lowest(packet->origin[k], lanes);
        axis->origin_hi = highest(packet->origin[k], lanes);
    }
}

/* The distances at which the group can be in the closed box; lo > hi if nowhere. */
MLRT_INLINE struct distance_interval box_distances(const struct group_axis axis[3], const struct mlrt_box *box,
                                                   struct distance_interval part)
{
    for (int k = 0; k < 3; ++k) {
        const struct distance_interval below = plane_distances(&axis[k], box->lo[k]);
        const struct distance_interval above = plane_distances(&axis[k], box->hi[k]);
        const float enter = axis[k].negative ? above.lo : below.lo, exit = axis[k].negative ? below.hi : above.hi;
        if (enter > part.lo) part.lo = enter;
        if (exit < part.hi) part.hi = exit;
    }
    return part;
}

struct pending_cell {
    uint32_t node;
    struct distance_interval part;
};

/* Traces lanes of equal signs from an entry point. Returns the lanes that hit something. */
static uint32_t traverse_group(const struct mlrt_job *job, const struct entry_point *entry, uint32_t lanes,
                               struct mlrt_packet *packet, mlrt_counters *counters)
{
    const struct mlrt_tree *tree = job->tree;
    struct group_axis axis[3];
    struct ray_group group = {.lanes = lanes};
    for (int k = 0; k < 3; ++k) set_group_axis(packet, lanes, k, &axis[k], &group.reach[k]);

    struct distance_interval part = {lowest(packet->t_min, lanes), highest(packet->hi, lanes)};
    part = box_distances(axis, &entry->box, part);
    if (part.lo > part.hi) return 0;

    struct pending_cell stack[MLRT_DEPTH_LIMIT];
    int pending_count = 0;
    uint32_t node = entry->node, hit = 0;
    float farthest = part.hi; /* of the nearest hits so far: what lies behind concerns no ray */
    COUNT(counters, packet_count, 1);
    for (;;) {
        const struct mlrt_node *here = &tree->nodes[node];
        COUNT(counters, cell_count, 1);
        const uint32_t k = mlrt_node_axis(here);
        if (k != 3) {
            const struct distance_interval plane = plane_distances(&axis[k], here->u.split);
            const uint32_t child = mlrt_node_child(here), first = child + axis[k].negative, second = child + !axis[k].negative;
            if (part.hi < plane.lo) {
                node = first;
            } else if (part.lo > plane.hi) {
                node = second;
            } else {
                stack[pending_count].node = second;
                stack[pending_count].part.lo = plane.lo > part.lo ? plane.lo : part.lo;
                stack[pending_count].part.hi = part.hi;
                ++pending_count;
                if (plane.hi < part.hi) part.hi = plane.hi;
                node = first;
            }
            continue;
        }
        const uint32_t *entries = tree->references + here->u.offset;
        const uint32_t count = mlrt_leaf_count(here);
        uint32_t changed = 0;
        for (uint32_t i = 0; i < count; ++i) {
            COUNT(counters, triangle_test_count, 1);
            changed |= test_triangle(tree, entries[i], &group, 0, MLRT_PACKET_RAYS, packet, counters);
        }
        if (changed) {
            hit |= changed;
            if (job->any) {
                group.lanes &= ~changed;
                if (!group.lanes) return hit;
            }
            farthest = highest(packet->hi, group.lanes);
        }
        do {
            if (pending_count == 0) return hit;
            --pending_count;
            node = stack[pending_count].node;
            part = stack[pending_count].part;
        } while (part.lo > farthest);
        if (part.hi > farthest) part.hi = farthest;
    }
}

/* Traces a packet's active rays from an entry point, lanes of different signs one group after the other. */
static void traverse_interval(const struct mlrt_job *job, const struct entry_point *entry, struct mlrt_packet *packet,
                              mlrt_counters *counters)
{
    uint32_t negative[3];
    for (int k = 0; k < 3; ++k) negative[k] = negative_lanes(packet, k);
    for (uint32_t lanes = packet->active; lanes;) {
        const uint32_t same = same_sign_lanes(negative, lanes);
        traverse_group(job, entry, same, packet, counters);
        lanes &= ~same;
    }
}
