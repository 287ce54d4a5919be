/* SPDX-License-Identifier: MIT */
/*
 * The steps to cells that need no vectors: see cells.h.
 */
#include "trace/cells.h"

#include <math.h>
#include <string.h>

#include "bvh/unit.h"
#include "exact/triangle.h"
#include "rays/slope_limits.h"
#include "simd/sixteen.h"

int mlrt_set_apex(const float point[3], float unit, struct mlrt_waist *waist)
{
    int is_exact = 1;
    for (int k = 0; k < 3; ++k) {
        waist->point[k] = point[k] * unit;
        is_exact &= mlrt_is_float_safe(waist->point[k]) && waist->point[k] / unit == point[k];
    }
    return is_exact;
}

void mlrt_begin_cells(uint32_t there, struct mlrt_bundle *bundle)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    bundle->state.going = bundle->state.closed = bundle->state.apexes = there;
    bundle->ends_at_skip = 0;
    bundle->arrays = NULL;
    memset(hulls->term + MLRT_INTERCEPT_J, 0, 2 * sizeof *hulls->term);
    memset(hulls->first, 0, sizeof hulls->first);
    memset(hulls->begin, 0, sizeof hulls->begin);
    memset(hulls->filter.away, 0, sizeof hulls->filter.away);
    memset(hulls->closed.common_first, 0, sizeof hulls->closed.common_first);
    for (int i = 0; i < MLRT_BUNDLE_PACKETS; ++i) hulls->last[i] = hulls->closed.common_last[i] = INFINITY;
    mlrt_fill_words(hulls->closed.skip, MLRT_NONE);
}

int mlrt_begin_parallel_cells(const struct mlrt_bvh *bvh, struct mlrt_array_cells *cells, struct mlrt_waist *waist)
{
    const float *direction = (const float *)(const void *)cells->reader.directions.data;
    mlrt_face_waist(direction, waist);
    const float given = fabsf(direction[waist->main_axis]), pace = given * bvh->unit;
    int fits = pace >= LEAST_PACE && pace <= GREATEST_PACE && given <= GREATEST_PACE;
    waist->is_beam = 1;
    for (int i = 0; i < 2; ++i) {
        const float slope = direction[mlrt_slope_axis(waist->main_axis, i)] * (1 / given);
        waist->slope[i] = cells->slope[i] = slope;
        fits &= fabsf(slope) >= LEAST_SLOPE || direction[mlrt_slope_axis(waist->main_axis, i)] == 0;
    }
    for (int k = 0; k < 3; ++k) {
        cells->middle[k] = 0.5f * (bvh->core.lo[k] + bvh->core.hi[k]) / bvh->unit;
        fits &= fabsf(cells->middle[k]) < 0x1p100f; /* differences from it do not overflow */
    }
    cells->vectors = &cells->reader.points;
    cells->from = cells->middle;
    return fits && mlrt_set_apex(cells->middle, bvh->unit, waist);
}

int mlrt_begin_apex_cells(const struct mlrt_bvh *bvh, const struct mlrt_source *source, size_t first,
                          struct mlrt_array_cells *cells, struct mlrt_waist *waist)
{
    const int is_light = source->kind == MLRT_SOURCE_POINT_LIGHT;
    const float *point = is_light ? source->light : (const float *)(const void *)cells->reader.points.data;
    float direction[3];
    cells->vectors = is_light ? &cells->reader.points : &cells->reader.directions;
    cells->from = is_light ? source->light : NULL;
    cells->have_ends = is_light;
    memcpy(direction, cells->vectors->data + first * cells->vectors->stride, sizeof direction);
    for (int k = 0; k < 3; ++k) direction[k] -= is_light ? source->light[k] : 0;
    mlrt_face_waist(direction, waist);
    return mlrt_is_within_reach(bvh, point) && mlrt_set_apex(point, bvh->unit, waist);
}

void mlrt_see_plane_of_cells(const struct mlrt_array_cells *cells, const struct mlrt_triangle *triangle,
                             struct mlrt_plane_of_cells *of)
{
    mlrt_set_plane(triangle, &of->plane);
    of->distance = of->size = 0;
    for (int k = 0; k < 3; ++k) {
        const double to = of->plane.point[k] - (cells->are_parallel ? 0 : (double)cells->from[k]);
        of->distance += to * of->plane.normal[k];
        of->size += fabs(to) * of->plane.size[k];
    }
}

#define END_ERROR 0x1p-49 /* L21 */

struct mlrt_side_of_box mlrt_find_side_of_box(const struct mlrt_box *box, const struct mlrt_plane_of_cells *of)
{
    double nearest = of->distance * of->sign, size = of->size;
    for (int k = 0; k < 3; ++k) {
        const double n = of->plane.normal[k] * of->sign, lo = box->lo[k], hi = box->hi[k];
        nearest -= n * (n > 0 ? hi : lo);
        size += of->plane.size[k] * (-lo > hi ? -lo : hi);
    }
    return (struct mlrt_side_of_box){nearest, size * END_ERROR};
}
