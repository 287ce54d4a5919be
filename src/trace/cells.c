/* SPDX-License-Identifier: MIT */
/*
 * The steps to cells that need no vectors: see cells.h.
 */
#include "trace/cells.h"

#include <math.h>
#include <string.h>

#include "exact/triangle.h"
#include "rays/slope_limits.h"

int mlrt_set_apex(const float point[3], float unit, struct mlrt_waist *waist)
{
    int is_exact = 1;
    for (int k = 0; k < 3; ++k) {
        waist->point[k] = point[k] * unit;
        is_exact &= mlrt_is_float_safe(waist->point[k]) && waist->point[k] / unit == point[k];
    }
    return is_exact;
}

/* The greater of two magnitudes. */
static float larger_size(float a, float b)
{
    return fabsf(a) > fabsf(b) ? fabsf(a) : fabsf(b);
}

/*
 * The positions of the first and the last column (or row) of pixels of four cells of `side` pixels each, within an area
 * that is `length` pixels long. A cell that begins beyond the area gets the positions of the first one.
 */
static void set_cell_samples(uint32_t first, uint32_t begin, uint32_t side, uint32_t length, float sample,
                             float samples[2][4])
{
    for (uint32_t i = 0; i < 4; ++i) {
        const uint32_t low = i * side < length ? i * side : 0, high = low + side < length ? low + side : length;
        samples[0][i] = mlrt_sample_position(first, begin + low, sample);
        samples[1][i] = mlrt_sample_position(first, begin + high - 1, sample);
    }
}

/*
 * Copies a view with its directions brought near 1 by a power of two, which leaves slopes as they are. *floor receives
 * a bound of the underflow of its rays before that, and *limit the greatest size with which they are finite.
 */
static void scale_view(const mlrt_camera *view, mlrt_camera *scaled, float *floor, float *limit)
{
    float largest = 0;
    int exponent;
    *scaled = *view;
    for (int k = 0; k < 3; ++k) largest = larger_size(view->d00[k], largest);
    (void)frexp((double)largest, &exponent);
    for (int k = 0; k < 3; ++k) {
        scaled->d00[k] = (float)ldexp((double)view->d00[k], -exponent);
        scaled->dx[k] = (float)ldexp((double)view->dx[k], -exponent);
        scaled->dy[k] = (float)ldexp((double)view->dy[k], -exponent);
    }
    *floor = (float)(0x1p-100 + ldexp(1, -147 - exponent));
    *limit = exponent < 66 ? MLRT_SAFE_MAX : (float)ldexp(1, 126 - exponent);
}

int mlrt_sample_camera_cells(const mlrt_camera *given, float unit, const struct mlrt_rectangle *area, uint32_t side,
                             struct mlrt_waist *waist, struct mlrt_camera_samples *of)
{
    float floor = 0x1p-100f, limit = MLRT_SAFE_MAX;
    const mlrt_camera *view = &of->view;
    if (mlrt_is_parallel(given) || given->t_min != 0 || !isinf(given->t_max)) return 0;
    if (MLRT_UNLIKELY(unit != 1)) {
        scale_view(given, &of->view, &floor, &limit);
    } else {
        of->view = *given;
    }
    const uint32_t x = area->x, y = area->y, width = area->width, height = area->height;
    float columns[2][4], rows[2][4], middle[3];
    set_cell_samples(view->crop_x, x, side, width, view->sample_x, columns);
    set_cell_samples(view->crop_y, y, side, height, view->sample_y, rows);
    const float x_max = larger_size(columns[0][0], mlrt_sample_position(view->crop_x, x + width - 1, view->sample_x));
    const float y_max = larger_size(rows[0][0], mlrt_sample_position(view->crop_y, y + height - 1, view->sample_y));
    for (int k = 0; k < 3; ++k) {
        const float whole = fabsf(view->d00[k]) + x_max * fabsf(view->dx[k]) + y_max * fabsf(view->dy[k]);
        if (!(whole <= limit)) return 0;
        of->pad[k] = whole * (8 * 0x1p-24f) + floor;
        middle[k] = (view->d00[k] + columns[0][0] * view->dx[k]) + rows[0][0] * view->dy[k];
    }
    mlrt_set_main_axis(middle, waist);
    of->all = 0;
    for (uint32_t i = 0; i < MLRT_CELL_COUNT; ++i) {
        const uint32_t column = i % 4, row = i / 4;
        of->all |= (uint32_t)(column * side < width && row * side < height) << i;
        for (int end = 0; end < 2; ++end) {
            of->positions[end][i] = columns[end][column];
            of->positions[2 + end][i] = rows[end][row];
        }
    }
    return mlrt_set_apex(view->eye, unit, waist);
}

int mlrt_begin_parallel_cells(const struct mlrt_bvh *bvh, struct mlrt_array_cells *cells, struct mlrt_waist *waist)
{
    const float *direction = (const float *)(const void *)cells->reader.directions.data;
    mlrt_set_main_axis(direction, waist);
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

int mlrt_begin_apex_cells(const struct mlrt_source *source, size_t first, float unit, struct mlrt_array_cells *cells,
                          struct mlrt_waist *waist)
{
    const int is_light = source->kind == MLRT_SOURCE_POINT_LIGHT;
    const float *point = is_light ? source->light : (const float *)(const void *)cells->reader.points.data;
    float direction[3];
    cells->vectors = is_light ? &cells->reader.points : &cells->reader.directions;
    cells->from = is_light ? source->light : NULL;
    cells->have_ends = is_light;
    memcpy(direction, cells->vectors->data + first * cells->vectors->stride, sizeof direction);
    for (int k = 0; k < 3; ++k) direction[k] -= is_light ? source->light[k] : 0;
    mlrt_set_main_axis(direction, waist);
    return mlrt_set_apex(point, unit, waist);
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

struct mlrt_slab_side mlrt_find_slab_side(const struct mlrt_cell_slab *slab, const struct mlrt_plane_of_cells *of)
{
    const double *n = of->plane.normal, *m = slab->normal;
    const double share = (n[0] * m[0] + n[1] * m[1] + n[2] * m[2]) / (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    double middle = of->distance - share * slab->distance, size = of->size + fabs(share * slab->distance), room = 0;
    for (int k = 0; k < 3; ++k) {
        const double rest = n[k] - share * m[k], lo = slab->lo[k], hi = slab->hi[k];
        middle -= rest * (0.5 * (lo + hi));
        room += fabs(rest) * (0.5 * (hi - lo));
        size += (of->plane.size[k] + fabs(share * m[k])) * (-lo > hi ? -lo : hi);
    }
    const double one = share * slab->least, two = share * slab->greatest;
    const double end = (one < two) == (of->sign > 0) ? one : two; /* the one that is nearer to the plane */
    return (struct mlrt_slab_side){(middle + end) * of->sign, room, size * SLAB_ERROR};
}
