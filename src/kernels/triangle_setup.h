/* SPDX-License-Identifier: MIT */
/*
 * What packets with a common origin share about a triangle: where it is seen from there, and the terms of its edge
 * functions. A worker keeps a small table of both for the packets of the neighbourhood.
 */

/* triangle_filter.h derives these. */
#define EDGE_BOUND     (10 * 0x1p-24f)
#define PLANE_BOUND    (16 * 0x1p-24f)
#define DISTANCE_BOUND (12 * 0x1p-24f)
#define DISTANCE_FLOOR 0x1p-82f
#define SMALLEST_SIZE  0x1p-100f

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
    setup->has_terms = 0;
    setup->number = number;
    setup->main_axis = group->axis_code;
    set_triangle_outline(&tree->triangles[number], group->axis_code, worker->apex, &setup->outline);
    return setup;
}

static MLRT_NOINLINE int is_in_plane(const struct mlrt_triangle *triangle, const float point[3])
{
    return mlrt_side_of_plane(triangle, point) == 0;
}

/* Works out the terms of an entry, four edges at a time; triangle_filter.h says what they are. */
MLRT_INLINE void set_up_terms(const struct mlrt_triangle *triangle, const float apex[3],
                              struct mlrt_triangle_setup *setup)
{
    const uint32_t a = setup->main_axis & 3, j = (a + 1) % 3, l = (a + 2) % 3;
    f4 corner[3], sum[3], edge[3], reach[3], length[3], cross[3], sizes[3];
    f4_corners(triangle->v, corner);
    float vertex[3];
    for (int k = 0; k < 3; ++k) {
        const f4 to = f4_sub(corner[k], f4_set1(apex[k])), next = f4_next(to);
        edge[k] = f4_sub(f4_next(corner[k]), corner[k]); /* b - a, c - b, a - c, b - a */
        sum[k] = f4_join(f4_add(to, next), edge[k]);     /* the normal is (a - c) x (b - a) */
        length[k] = f4_abs(edge[k]);
        reach[k] = f4_join(f4_add(f4_abs(to), f4_abs(next)), length[k]);
        vertex[k] = f4_last(to);
    }
    for (int k = 0; k < 3; ++k) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        cross[k] = f4_sub(f4_mul(sum[p], edge[q]), f4_mul(sum[q], edge[p]));
        sizes[k] = f4_add(f4_mul(reach[p], length[q]), f4_mul(reach[q], length[p]));
    }
    const f4 size = f4_max(f4_add(f4_mul(f4_add(sizes[j], sizes[l]), f4_set1(0.5f)), sizes[a]), f4_set1(SMALLEST_SIZE));
    for (int k = 0; k < 3; ++k) {
        if (!MLRT_GUESS) cross[k] = f4_div(cross[k], size);
        f4_store(setup->cross[k], cross[k]);
    }
    setup->distance = vertex[0] * f4_last(cross[0]) + vertex[1] * f4_last(cross[1]) + vertex[2] * f4_last(cross[2]);
    const float other = larger_of(fabsf(vertex[j]), fabsf(vertex[l]));
    setup->distance_bound = larger_of(fabsf(vertex[a]), 2 * other) * DISTANCE_BOUND + DISTANCE_FLOOR;
    setup->has_terms = 1;
    setup->in_plane =
        !MLRT_GUESS && MLRT_UNLIKELY(fabsf(setup->distance) <= setup->distance_bound) && is_in_plane(triangle, apex);
}
