/* SPDX-License-Identifier: MIT */
/*
 * What packets with a common origin share about a triangle: where it is seen from there, and the terms of its edge
 * functions. A worker keeps a small table of both for the packets of the neighbourhood.
 *
 * Seen from the apex, a triangle whose vertices all lie in front of it along the main axis covers slopes x_j / depth
 * between those of its vertices, and so does every ray that hits it. A slope of a vertex has three roundings and one of a
 * ray two; both kinds of bounds are moved apart by 2^-20 of themselves. So rays whose slopes do not overlap the
 * triangle's surely miss it.
 */

#define FILTER_BOUND 0x1p-20f  /* triangle_filter.h derives both */
#define FILTER_FLOOR 0x1p-146f

static void forget_setups(const float apex[3], struct mlrt_worker *worker)
{
    for (uint32_t i = 0; i <= worker->setup_mask; ++i) worker->setups[i].number = MLRT_NONE;
    memcpy(worker->apex, apex, sizeof worker->apex);
}

/* Where a triangle is seen. */
MLRT_INLINE void set_up_outline(const struct mlrt_triangle *triangle, const struct ray_group *group, const float apex[3],
                                struct mlrt_triangle_setup *setup)
{
    const int a = group->main_axis[0];
    float depth[3], least = INFINITY;
    for (int i = 0; i < 3; ++i) {
        depth[i] = (triangle->v[i][a] - apex[a]) * group->direction;
        least = depth[i] < least ? depth[i] : least;
    }
    setup->least_depth = least;
    for (int side = 0; side < 2; ++side) {
        const int j = group->main_axis[1 + side];
        float lo = INFINITY, hi = -INFINITY;
        for (int i = 0; i < 3; ++i) {
            const float slope = (triangle->v[i][j] - apex[j]) / depth[i];
            lo = slope < lo ? slope : lo;
            hi = slope > hi ? slope : hi;
        }
        setup->slope_lo[side] = least > 0 ? lo - fabsf(lo) * SLOPE_SLACK : -INFINITY;
        setup->slope_hi[side] = least > 0 ? hi + fabsf(hi) * SLOPE_SLACK : INFINITY;
    }
}

/* The table's entry for a triangle. Its terms may still be missing. */
MLRT_INLINE struct mlrt_triangle_setup *get_setup(const struct mlrt_tree *tree, uint32_t number,
                                                  const struct ray_group *group, struct mlrt_worker *worker)
{
    struct mlrt_triangle_setup *setup = &worker->setups[number & worker->setup_mask];
    const uint32_t main_axis = (uint32_t)group->main_axis[0] | (group->direction < 0 ? 4u : 0);
    if (setup->number == number && setup->main_axis == main_axis) return setup;
    if (setup->number != number) setup->has_terms = 0;
    setup->number = number;
    setup->main_axis = main_axis;
    set_up_outline(&tree->triangles[number], group, worker->apex, setup);
    return setup;
}

/* Lanes of the group in whose squares a ray may hit the triangle nearer than at `farthest`. */
MLRT_INLINE uint32_t touched_lanes(const struct ray_group *group, const struct mlrt_triangle_setup *setup, float farthest)
{
    if (setup->least_depth > farthest * group->axis[group->main_axis[0]].reach * (1 + SLOPE_SLACK)) return 0;
    uint32_t squares = 0;
    for (int v = 0; v < SQUARE_COUNT; v += VW) {
        const vm wide = m_and(v_le(v_load(group->slope_lo[0] + v), v_set1(setup->slope_hi[0])),
                              v_ge(v_load(group->slope_hi[0] + v), v_set1(setup->slope_lo[0])));
        const vm high = m_and(v_le(v_load(group->slope_lo[1] + v), v_set1(setup->slope_hi[1])),
                              v_ge(v_load(group->slope_hi[1] + v), v_set1(setup->slope_lo[1])));
        squares |= m_bits(m_and(wide, high)) << v;
    }
    static const uint16_t lanes[16] = {0x0000, 0x000F, 0x00F0, 0x00FF, 0x0F00, 0x0F0F, 0x0FF0, 0x0FFF,
                                       0xF000, 0xF00F, 0xF0F0, 0xF0FF, 0xFF00, 0xFF0F, 0xFFF0, 0xFFFF};
    return lanes[squares & 15] & group->lanes;
}

/* Works out the terms of an entry. The layout lets a compiler do four edges at a time. */
static void set_up_terms(const struct mlrt_triangle *triangle, const float apex[3], struct mlrt_triangle_setup *setup)
{
    float sum[3][4], sum_size[3][4], edge[3][4], length[3][4], vertex[3];
    for (int k = 0; k < 3; ++k) {
        const float a = triangle->v[0][k], b = triangle->v[1][k], c = triangle->v[2][k];
        const float x = a - apex[k], y = b - apex[k], z = c - apex[k];
        /* The normal is (a - c) x (b - a). */
        const float sums[4] = {x + y, y + z, z + x, a - c};
        const float sizes[4] = {fabsf(x) + fabsf(y), fabsf(y) + fabsf(z), fabsf(z) + fabsf(x), fabsf(a - c)};
        const float edges[4] = {b - a, c - b, a - c, b - a};
        vertex[k] = x;
        for (int i = 0; i < 4; ++i) {
            sum[k][i] = sums[i];
            sum_size[k][i] = sizes[i];
            edge[k][i] = edges[i];
            length[k][i] = fabsf(edges[i]);
        }
    }
    for (int k = 0; k < 3; ++k) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        for (int i = 0; i < 4; ++i) {
            setup->cross[k][i] = sum[p][i] * edge[q][i] - sum[q][i] * edge[p][i];
            setup->size[k][i] = sum_size[p][i] * length[q][i] + sum_size[q][i] * length[p][i];
        }
    }
    float distance = 0, distance_size = 0, distance_floor = 4;
    for (int k = 0; k < 3; ++k) {
        distance += vertex[k] * setup->cross[k][3];
        distance_size += fabsf(vertex[k]) * setup->size[k][3];
        distance_floor += fabsf(vertex[k]);
    }
    setup->distance = distance;
    setup->distance_bound = distance_size * FILTER_BOUND + distance_floor * FILTER_FLOOR;
    setup->has_terms = 1;
}
