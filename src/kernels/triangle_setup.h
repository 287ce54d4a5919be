/* SPDX-License-Identifier: MIT */
/*
 * What packets with a common origin share about a triangle: where it is seen from there, and the terms of its edge
 * functions. A worker keeps a small table of both for the packets of the neighbourhood.
 */

#define FILTER_BOUND 0x1p-20f /* triangle_filter.h derives both */
#define FILTER_FLOOR 0x1p-146f

static void forget_setups(const float apex[3], struct mlrt_worker *worker)
{
    for (uint32_t i = 0; i <= worker->setup_mask; ++i) worker->setups[i].number = MLRT_NONE;
    memcpy(worker->apex, apex, sizeof worker->apex);
}

/* The table's entry for a triangle. Its terms may still be missing. */
MLRT_INLINE struct mlrt_triangle_setup *get_setup(const struct mlrt_tree *tree, uint32_t number,
                                                  const struct ray_group *group, struct mlrt_worker *worker)
{
    struct mlrt_triangle_setup *setup = &worker->setups[number & worker->setup_mask];
    if (setup->number == number && setup->main_axis == group->axis_code) return setup;
    if (setup->number != number) setup->has_terms = 0;
    setup->number = number;
    setup->main_axis = group->axis_code;
    set_triangle_outline(&tree->triangles[number], group->axis_code, worker->apex, &setup->outline);
    return setup;
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
        for (int i = 0; i < 4; ++i) setup->cross[k][i] = sum[p][i] * edge[q][i] - sum[q][i] * edge[p][i];
        for (int i = 0; !MLRT_GUESS && i < 4; ++i) {
            setup->size[k][i] = sum_size[p][i] * length[q][i] + sum_size[q][i] * length[p][i];
        }
    }
    float distance = 0, distance_size = 0, distance_floor = 4;
    for (int k = 0; k < 3; ++k) {
        distance += vertex[k] * setup->cross[k][3];
        if (MLRT_GUESS) continue;
        distance_size += fabsf(vertex[k]) * setup->size[k][3];
        distance_floor += fabsf(vertex[k]);
    }
    setup->distance = distance;
    setup->distance_bound = distance_size * FILTER_BOUND + distance_floor * FILTER_FLOOR;
    setup->has_terms = 1;
}
