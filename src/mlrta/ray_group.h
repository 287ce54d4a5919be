/* SPDX-License-Identifier: MIT */
/*
 * A group: rays of a packet that go down the tree as one, with bounds of their origins and directions and, if they have
 * a common origin, the frustum in which they lie.
 *
 * The directions of a group have the same signs: on each axis d_k >= 0 for all rays, or d_k < 0 for all. And a group is
 * narrow, since it visits all cells that lie between its rays. The other rays of the packet form further groups.
 */
#ifndef MLRT_MLRTA_RAY_GROUP_H
#define MLRT_MLRTA_RAY_GROUP_H

#include <math.h>

#include "mlrta/outline.h"
#include "mlrta/setups.h"
#include "rays/extremes.h"
#include "rays/slope_limits.h"
#include "scene/reach.h"
#include "simd/simd.h"

/*
 * Along each axis, directions of a group differ by at most this share of their greatest component; by less if the group
 * comes from far outside, so that it is no wider in the scene (share_of_scene). Measured on the shadow rays of
 * conference, where blocks on silhouettes are wide: 4600 ms without a limit, 500 ms at 0.1, 230 ms at 0.05, no further
 * gain below.
 */
#define GROUP_SPREAD 0.05f

/*
 * Along each axis, origins of a group differ by at most this share of the scene's greatest extent. Measured on
 * axis-parallel rays with origins anywhere, towards a sphere of 20,480 triangles: without the limit, groups of rays
 * that have only their direction in common were 200 times slower than single rays. The origins of a parallel camera's
 * packets differ by far less.
 */
#define GROUP_EXTENT 0.03125f

/*
 * The limits above are shares of the whole scene. If most of it is small beside one triangle, groups within the limits
 * can meet all that is small. So a group has a budget, GROUP_EFFORT and GROUP_RAY_EFFORT for each of its rays: a leaf
 * takes one, and so does each ray that float leaves undecided for a triangle. When it is spent the group gives up, and
 * its rays go one by one in double. Measured on a sphere of 19,600 triangles over a triangle 1000 times larger, with
 * cells of any size: 4 us a ray in place of 600 from origins 300 radii away, 6 in place of 6000 from 10^7.
 */
#define GROUP_EFFORT     64
#define GROUP_RAY_EFFORT 32

/* Bounds of the directions of some lanes; and, with index 3, the least t_min and the greatest distance to look at. */
struct lane_range {
    MLRT_ALIGNED(16) float lo[4];
    MLRT_ALIGNED(16) float hi[4];
};

/* The rays along one axis. */
struct group_axis {
    float origin_lo;
    float origin_hi;
    float small;   /* 1 / d_k has the magnitude of this at least, and its sign; */
    float large;   /* and of this at most. Moved apart by RECIPROCAL_SLACK; may be infinite */
    float largest; /* largest |d_k| */
    uint32_t negative;
};

/* Entries of a group's mailbox. A triangle can lie in several leaves, but one test of it serves all rays of a group. */
#define SEEN_COUNT 16

struct ray_group {
    uint32_t lanes;
    struct lane_range range;
    struct group_axis axis[3];
    uint32_t axis_code;        /* the main axis, that of the largest |d_k|, and its sign (outline.h) */
    float direction_size;      /* the larger of |d_main| and twice any other |d_k|: R of triangle_filter.h */
    int has_frustum;           /* the rays have a common origin, and `slopes` is set */
    struct ray_slopes slopes;  /* over the main axis */
    int effort_left;           /* of its budget; negative = the group has given up */
    uint32_t seen[SEEN_COUNT]; /* triangles tested lately: entry number % SEEN_COUNT */
};

/* Not inlined: its four callers would have 2.5 kB more in all. */
static MLRT_NOINLINE void find_range(const struct mlrt_packet *packet, uint32_t lanes, struct lane_range *range)
{
    const vf none = v_set1(INFINITY), zero = v_set1(0);
    vf least[4] = {none, none, none, none}, negated[4] = {none, none, none, none};
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm chosen = m_from_bits(lanes >> v);
        MLRT_UNROLL
        for (int k = 0; k < 4; ++k) {
            const vf lo = v_load((k < 3 ? packet->direction[k] : packet->t_min) + v);
            const vf hi = v_load((k < 3 ? packet->direction[k] : packet->nearest.hi) + v);
            least[k] = v_min(v_select(chosen, lo, none), least[k]);
            negated[k] = v_min(v_select(chosen, v_sub(zero, hi), none), negated[k]);
        }
    }
    f4_store(range->lo, v_hmin4(least[0], least[1], least[2], least[3]));
    f4_store(range->hi, f4_sub(f4_set1(0), v_hmin4(negated[0], negated[1], negated[2], negated[3])));
}

MLRT_INLINE int have_common_signs(const struct lane_range *range)
{
    return !((range->lo[0] < 0 && range->hi[0] >= 0) || (range->lo[1] < 0 && range->hi[1] >= 0) ||
             (range->lo[2] < 0 && range->hi[2] >= 0));
}

/* The extent of the scene, as a share of how far outside of it `origin` is; at most 1. */
MLRT_INLINE float share_of_scene(const float origin[3], const struct mlrt_box *scene)
{
    const float extent = mlrt_extent_of(scene);
    float outside = extent;
    for (int k = 0; k < 3; ++k)
        outside = larger_of(larger_of(scene->lo[k] - origin[k], origin[k] - scene->hi[k]), outside);
    return MLRT_LIKELY(outside == extent) ? 1 : extent / outside;
}

MLRT_INLINE int are_narrow(const struct lane_range *range, float limit)
{
    float spread = 0, length = 0;
    for (int k = 0; k < 3; ++k) {
        const float size = -range->lo[k] > range->hi[k] ? -range->lo[k] : range->hi[k];
        if (range->hi[k] - range->lo[k] > spread) spread = range->hi[k] - range->lo[k];
        if (size > length) length = size;
    }
    return spread <= limit * length;
}

/* Of `lanes`, those whose directions have the same three signs as that of the lowest lane. */
static uint32_t same_sign_lanes(const struct mlrt_packet *packet, uint32_t lanes)
{
    const uint32_t seed = lanes & (0u - lanes);
    uint32_t same = lanes;
    for (int k = 0; k < 3; ++k) {
        uint32_t negative = 0;
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW)
            negative |= m_bits(v_lt(v_load(packet->direction[k] + v), v_set1(0))) << v;
        same &= (negative & seed) ? negative : ~negative;
    }
    return same;
}

/* Of `lanes`, those whose vectors differ from that of the lowest by at most half of `limit` along each axis. */
static uint32_t lanes_within(const float vectors[3][MLRT_PACKET_RAYS], uint32_t lanes, float limit)
{
    const uint32_t seed = mlrt_lowest_bit(lanes);
    uint32_t within = 1u << seed;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf difference = v_set1(0);
        for (int k = 0; k < 3; ++k)
            difference = v_max(v_abs(v_sub(v_load(vectors[k] + v), v_set1(vectors[k][seed]))), difference);
        within |= m_bits(v_le(difference, v_set1(0.5f * limit))) << v;
    }
    return lanes & within;
}

/* `lo` and `hi` bound the directions along this axis. */
MLRT_INLINE void set_group_reciprocals(float lo, float hi, struct group_axis *axis)
{
    /* Adding 0 turns -0 into 0, so that the reciprocals of a group that is not negative are not negative. */
    const float largest = (axis->negative ? lo : hi) + 0.0f, smallest = (axis->negative ? hi : lo) + 0.0f;
    axis->small = (1 / largest) * (1 - RECIPROCAL_SLACK);
    axis->large = (1 / smallest) * (1 + RECIPROCAL_SLACK);
}

/* Sets what is known of the rays along axis k, whose directions lie between `lo` and `hi`. */
MLRT_INLINE void set_group_axis(const struct mlrt_packet *packet, uint32_t lanes, int k, float lo, float hi,
                                struct group_axis *axis)
{
    axis->negative = lo < 0;
    axis->largest = axis->negative ? -lo : hi;
    set_group_reciprocals(lo, hi, axis);
    if (packet->has.apex) {
        axis->origin_lo = axis->origin_hi = packet->apex[k];
    } else {
        axis->origin_lo = lowest(packet->origin[k], lanes);
        axis->origin_hi = highest(packet->origin[k], lanes);
    }
}

MLRT_INLINE void set_ray_slopes(const struct mlrt_packet *packet, int main_axis, int axis, float lo[MLRT_PACKET_RAYS],
                                float hi[MLRT_PACKET_RAYS])
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf slope = v_div(v_load(packet->direction[axis] + v), v_abs(v_load(packet->direction[main_axis] + v)));
        const vf slack = v_mul(v_abs(slope), v_set1(SLOPE_SLACK));
        v_store(lo + v, v_sub(slope, slack));
        v_store(hi + v, v_add(slope, slack));
    }
}

MLRT_INLINE void set_main_axis(struct ray_group *group)
{
    const float x = group->axis[0].largest, y = group->axis[1].largest, z = group->axis[2].largest;
    const int a = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    const float other = 2 * larger_of(group->axis[(a + 1) % 3].largest, group->axis[(a + 2) % 3].largest);
    group->axis_code = axis_code_of(a, (int)group->axis[a].negative);
    group->direction_size = larger_of(group->axis[a].largest, other);
}

MLRT_INLINE void set_frustum(const struct mlrt_packet *packet, struct ray_group *group)
{
    group->has_frustum = packet->has.apex;
    if (!group->has_frustum) return;
    const int a = (int)(group->axis_code & 3);
    for (int side = 0; side < 2; ++side)
        set_ray_slopes(packet, a, (a + 1 + side) % 3, group->slopes.lo[side], group->slopes.hi[side]);
}

MLRT_INLINE int effort_of_group(uint32_t lanes)
{
    return GROUP_EFFORT + GROUP_RAY_EFFORT * (int)mlrt_count_bits(lanes);
}

/* Makes a group from the lowest of `lanes` and those of the others that fit it. */
static void make_group(const struct mlrt_packet *packet, uint32_t lanes, const struct mlrt_box *scene,
                       struct ray_group *group)
{
    struct lane_range *range = &group->range;
    const uint32_t first = mlrt_lowest_bit(lanes);
    float origin[3];
    for (int k = 0; k < 3; ++k) origin[k] = packet->has.apex ? packet->apex[k] : packet->origin[k][first];
    const float limit = GROUP_SPREAD * share_of_scene(origin, scene);
    if (!packet->has.apex) lanes = lanes_within(packet->origin, lanes, GROUP_EXTENT * mlrt_extent_of(scene));
    find_range(packet, lanes, range);
    if (MLRT_UNLIKELY(!have_common_signs(range))) {
        lanes = same_sign_lanes(packet, lanes);
        find_range(packet, lanes, range);
    }
    if (MLRT_UNLIKELY(!are_narrow(range, limit))) {
        float length = 0;
        for (int k = 0; k < 3; ++k) length = larger_of(fabsf(packet->direction[k][first]), length);
        lanes = lanes_within(packet->direction, lanes, limit * length);
        find_range(packet, lanes, range);
    }
    group->lanes = lanes;
    group->effort_left = effort_of_group(lanes);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) set_group_axis(packet, lanes, k, range->lo[k], range->hi[k], &group->axis[k]);
    set_main_axis(group);
    set_frustum(packet, group);
    for (int i = 0; i < SEEN_COUNT; ++i) group->seen[i] = MLRT_NONE;
}

/* Enters the triangle in the group's mailbox. Returns 1 if it was there. */
MLRT_INLINE int was_seen(struct ray_group *group, uint32_t number)
{
    uint32_t *entry = &group->seen[number % SEEN_COUNT];
    const int seen = *entry == number;
    *entry = number;
    return seen;
}

/*
 * The lanes of a group with a frustum that may hit the triangle or box of this outline at a distance of at most
 * `farthest`. A ray that hits it at t is at the depth t |d_main| there.
 */
MLRT_INLINE uint32_t touched_lanes(const struct ray_group *group, const struct mlrt_outline *outline, float farthest)
{
    if (outline->least_depth > farthest * group->axis[group->axis_code & 3].largest * (1 + SLOPE_SLACK)) return 0;
    return overlapping_lanes(&group->slopes, outline) & group->lanes;
}

#endif
