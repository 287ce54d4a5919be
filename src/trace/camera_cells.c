/* SPDX-License-Identifier: MIT */
/*
 * Cells of a camera.
 *
 * A ray's direction before rounding is affine in column and row, so that ratios of two components have their extremes
 * over a cell at its corners. Rounding moves component k of any ray by at most 3.001 u (|d00_k| + |x dx_k| + |y dy_k|)
 * (mlrta/beam.c); `pad` is 8 u of that sum, and 2^-100 for underflow. So a ratio exceeds the extreme of those
 * computed at the corners by at most 2 (p_j + |slope| p_main) / (|d_main| - 2 p_main), with p = 0.38 pad. That is less
 * than 2 (pad_j + |slope| pad_main) / |d_main|, which is used, since |d_main| is more than 4 pad_main. So |d_main| is
 * more than 2^-98, and reciprocals are finite: an infinite slope times 0 would be a NaN.
 */
#include "trace/camera_cells.h"

#include <math.h>

#include "trace/cells.h"
#include "trace/corner_slopes.h"
#include "trace/ray_tile.h"

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

int mlrt_gather_camera_cells(const mlrt_camera *view, float unit, const struct mlrt_rectangle *area, uint32_t side,
                             struct mlrt_bundle *bundle)
{
    float floor = 0x1p-100f, limit = MLRT_SAFE_MAX, pad[3], middle[3];
    MLRT_ALIGNED(16) float columns[2][4];
    MLRT_ALIGNED(16) float rows[2][4];
    struct mlrt_waist *waist = &bundle->waist;
    mlrt_camera scaled;
    if (view->t_min != 0 || !isinf(view->t_max)) return 0;
    if (MLRT_UNLIKELY(unit != 1)) {
        scale_view(view, &scaled, &floor, &limit);
        view = &scaled;
    }
    const uint32_t x = area->x, y = area->y, width = area->width, height = area->height;
    set_cell_samples(view->crop_x, x, side, width, view->sample_x, columns);
    set_cell_samples(view->crop_y, y, side, height, view->sample_y, rows);
    const float x_max = larger_size(columns[0][0], mlrt_sample_position(view->crop_x, x + width - 1, view->sample_x));
    const float y_max = larger_size(rows[0][0], mlrt_sample_position(view->crop_y, y + height - 1, view->sample_y));
    for (int k = 0; k < 3; ++k) {
        const float whole = fabsf(view->d00[k]) + x_max * fabsf(view->dx[k]) + y_max * fabsf(view->dy[k]);
        if (!(whole <= limit)) return 0;
        pad[k] = whole * (8 * 0x1p-24f) + floor;
        middle[k] = (view->d00[k] + columns[0][0] * view->dx[k]) + rows[0][0] * view->dy[k];
    }
    mlrt_face_waist(middle, waist);
    if (!mlrt_set_apex(view->eye, unit, waist)) return 0;
    f4 error[3], from[2][3]; /* d00 + x dx for the first, and the last, columns of four cells */
    float along[3];
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int axis = (waist->main_axis + k) % 3;
        error[k] = f4_set1(pad[axis]);
        along[k] = view->dy[axis];
        MLRT_UNROLL
        for (int end = 0; end < 2; ++end) {
            from[end][k] = f4_add(f4_set1(view->d00[axis]), f4_mul(f4_load(columns[end]), f4_set1(view->dx[axis])));
        }
    }
    const uint32_t all = mlrt_places(2, (width + side - 1) / side, (height + side - 1) / side);
    for (uint32_t row = 0; row < 4; ++row) {
        struct corner_slopes of = NO_CORNERS;
        MLRT_UNROLL
        for (int corner = 0; corner < 4; ++corner) {
            f4 d[3];
            MLRT_UNROLL
            for (int k = 0; k < 3; ++k) d[k] = f4_add(from[corner & 1][k], f4_set1(rows[corner >> 1][row] * along[k]));
            add_corner(waist->sign, d, &of);
        }
        if (all >> 4 * row & 15 & ~set_cell_slopes(&of, error, 4 * row, &bundle->hulls)) return 0;
    }
    mlrt_begin_cells(all, bundle);
    return 1;
}
