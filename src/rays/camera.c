/* SPDX-License-Identifier: MIT */
/*
 * The check of a camera, and the beams of its tiles.
 *
 * A tile's vectors p = d00 + x dx + y dy are affine in (x, y). So over the rectangle of sample positions, each
 * component has its extremes at the four corners, and so has each ratio of two components whose denominator keeps its
 * sign. But the rays have *rounded* vectors. By the formula of camera.h, component k is off by at most
 *
 *     fl(x dx): u |x dx|;  first sum: u (|d00| + |x dx|)(1 + u);  fl(y dy): u |y dy|;  second sum: u of everything
 *
 * so by less than 3 u (|d00_k| + |x dx_k| + |y dy_k|) (1 + 2 u), with u = 2^-24. `pad` is 4 u times the largest such
 * sum over the corners, plus 2^-146 for underflow. With exact values A and pads p, a ratio is off by
 *
 *     |(A_j + e_j) / (A_a + e_a) - A_j / A_a| <= (p_j + |A_j / A_a| p_a) / (|A_a| - p_a).
 */
#include "rays/camera.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#include "exact/rounding.h"
#include "mlrta/beam.h"

/* Up to here float holds the number of a column or row exactly, and its sum with 0.5. */
#define PIXEL_LIMIT (1u << 23)

static int is_finite_vector(const float v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

static int is_zero_vector(const float v[3])
{
    return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

/* 1 if the vectors are not parallel, so that they span a picture. Exact: products of two floats are, in double. */
static int spans_plane(const float a[3], const float b[3])
{
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        if ((double)a[i] * b[j] != (double)a[j] * b[i]) return 1;
    }
    return 0;
}

/* Resolves the length of a crop along one axis; 0 if it is not in the picture. */
static int crop_range(uint32_t first, uint32_t count, uint32_t whole, uint32_t *resolved)
{
    if (first >= whole || count > whole - first) return 0;
    *resolved = count ? count : whole - first;
    return 1;
}

int32_t mlrt_make_view(const mlrt_camera *camera, struct mlrt_view *view)
{
    if (camera->projection != MLRT_PROJECTION_PINHOLE && camera->projection != MLRT_PROJECTION_PARALLEL) {
        return MLRT_ERROR_ARGUMENT;
    }
    view->parallel = camera->projection == MLRT_PROJECTION_PARALLEL;
    if (camera->width == 0 || camera->height == 0) return MLRT_ERROR_CAMERA;
    if (camera->width > PIXEL_LIMIT || camera->height > PIXEL_LIMIT) return MLRT_ERROR_TOO_LARGE;
    if (!crop_range(camera->crop_x, camera->crop_width, camera->width, &view->width) ||
        !crop_range(camera->crop_y, camera->crop_height, camera->height, &view->height)) {
        return MLRT_ERROR_CAMERA;
    }
    if ((uint64_t)view->width * view->height > INT32_MAX) return MLRT_ERROR_TOO_LARGE;
    if (!is_finite_vector(camera->d00) || !is_finite_vector(camera->dx) || !is_finite_vector(camera->dy) ||
        !isfinite(camera->sample_x) || !isfinite(camera->sample_y) || isnan(camera->t_min) || isnan(camera->t_max)) {
        return MLRT_ERROR_CAMERA;
    }
    if (view->parallel) {
        if (!is_finite_vector(camera->direction) || is_zero_vector(camera->direction)) return MLRT_ERROR_CAMERA;
    } else if (!is_finite_vector(camera->eye)) {
        return MLRT_ERROR_CAMERA;
    }
    if (!spans_plane(camera->dx, camera->dy)) return MLRT_ERROR_CAMERA;

    view->first_x = camera->crop_x;
    view->first_y = camera->crop_y;
    for (int k = 0; k < 3; ++k) {
        view->eye[k] = camera->eye[k];
        view->direction[k] = camera->direction[k] + 0.0f; /* -0 becomes 0 */
        view->d00[k] = camera->d00[k];
        view->dx[k] = camera->dx[k];
        view->dy[k] = camera->dy[k];
    }
    view->sample_x = camera->sample_x;
    view->sample_y = camera->sample_y;
    view->t_min = camera->t_min < 0 ? 0 : camera->t_min;
    /* 0 stands for no limit. A t_max below 0 allows no hit and becomes 0: -inf would pass for no limit. */
    view->t_max = camera->t_max == 0 ? INFINITY : camera->t_max < 0 ? 0 : camera->t_max;
    return MLRT_OK;
}

/* The vectors p at the corners of a tile's sample positions, off by at most 2^-52 of their terms, and the pads. */
struct corners {
    double p[3][4];
    double pad[3];
};

static void find_corners(const struct mlrt_view *view, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                         struct corners *corners)
{
    const double xs[2] = {mlrt_sample_position(view->first_x, x, view->sample_x),
                          mlrt_sample_position(view->first_x, x + width - 1, view->sample_x)};
    const double ys[2] = {mlrt_sample_position(view->first_y, y, view->sample_y),
                          mlrt_sample_position(view->first_y, y + height - 1, view->sample_y)};
    const double x_max = fmax(fabs(xs[0]), fabs(xs[1])), y_max = fmax(fabs(ys[0]), fabs(ys[1]));
    for (int k = 0; k < 3; ++k) {
        const double d00 = view->d00[k], dx = view->dx[k], dy = view->dy[k];
        for (int i = 0; i < 4; ++i) corners->p[k][i] = d00 + xs[i & 1] * dx + ys[i >> 1] * dy;
        corners->pad[k] = 0x1p-22 * (fabs(d00) + x_max * fabs(dx) + y_max * fabs(dy)) + 0x1p-146;
    }
}

struct range {
    double lo;
    double hi;
};

/* Bounds of component k over the rays of the tile. */
static struct range component_range(const struct corners *corners, int k)
{
    struct range range = {corners->p[k][0], corners->p[k][0]};
    for (int i = 1; i < 4; ++i) {
        range.lo = corners->p[k][i] < range.lo ? corners->p[k][i] : range.lo;
        range.hi = corners->p[k][i] > range.hi ? corners->p[k][i] : range.hi;
    }
    range.lo -= corners->pad[k];
    range.hi += corners->pad[k];
    return range;
}

/* 1 if component k is exactly 0 for every pixel, so that it needs no pad. */
static int is_zero_component(const struct mlrt_view *view, int k)
{
    return view->d00[k] == 0 && view->dx[k] == 0 && view->dy[k] == 0;
}

/* Bounds the points of the rays along axis k: from the range of their origins forward, to t_max. */
static void set_region(struct mlrt_beam *beam, int k, double direction_lo, double direction_hi, double t_max)
{
    double lo = beam->origin_lo[k], hi = beam->origin_hi[k];
    if (beam->negative[k]) {
        lo = isinf(t_max) ? -INFINITY : lo + t_max * direction_lo;
    } else if (direction_hi > 0) {
        hi = isinf(t_max) ? INFINITY : hi + t_max * direction_hi;
    }
    beam->region.lo[k] = mlrt_float_down(lo - fabs(lo) * 0x1p-50);
    beam->region.hi[k] = mlrt_float_up(hi + fabs(hi) * 0x1p-50);
}

static int make_pinhole_beam(const struct mlrt_view *view, const struct corners *corners, struct mlrt_beam *beam)
{
    double reciprocal[3][4], nearest[3], largest = -1;
    for (int k = 0; k < 3; ++k) {
        struct range range = is_zero_component(view, k) ? (struct range){0, 0} : component_range(corners, k);
        if (range.lo < 0 && range.hi >= 0) return 0;
        if (!mlrt_is_float_safe(view->eye[k])) return 0;
        if (range.lo < -MLRT_SAFE_MAX || range.hi > MLRT_SAFE_MAX) return 0;
        beam->negative[k] = range.hi < 0;
        beam->origin_lo[k] = beam->origin_hi[k] = view->eye[k];
        set_region(beam, k, range.lo, range.hi, view->t_max);
        nearest[k] = beam->negative[k] ? -range.hi : range.lo; /* min |A_a| - p_a */
        for (int i = 0; i < 4; ++i) reciprocal[k][i] = 1 / corners->p[k][i];
        if (nearest[k] > largest) {
            largest = nearest[k];
            beam->main_axis = k;
        }
    }
    if (largest <= 0) return 0;
    for (int a = 0; a < 3; ++a) {
        for (int j = 0; j < 3; ++j) {
            if (j == a) continue;
            if (nearest[a] <= 0) {
                mlrt_set_slope(beam, a, j, -INFINITY, INFINITY);
                continue;
            }
            double lo = INFINITY, hi = -INFINITY, size = 0;
            for (int i = 0; i < 4; ++i) {
                double slope = corners->p[j][i] * reciprocal[a][i];
                lo = slope < lo ? slope : lo;
                hi = slope > hi ? slope : hi;
            }
            size = fabs(lo) > fabs(hi) ? fabs(lo) : fabs(hi);
            double slack = (corners->pad[j] + size * corners->pad[a]) / nearest[a] * (1 + 0x1p-40);
            mlrt_set_slope(beam, a, j, lo - slack, hi + slack);
        }
    }
    beam->has_apex = 1;
    return 1;
}

static int make_parallel_beam(const struct mlrt_view *view, const struct corners *corners, struct mlrt_beam *beam)
{
    beam->main_axis = 0;
    for (int k = 0; k < 3; ++k) {
        const float d = view->direction[k];
        struct range range = is_zero_component(view, k) ? (struct range){0, 0} : component_range(corners, k);
        beam->negative[k] = d < 0;
        beam->origin_lo[k] = mlrt_float_down(range.lo);
        beam->origin_hi[k] = mlrt_float_up(range.hi);
        if (!mlrt_is_float_safe(beam->origin_lo[k]) || !mlrt_is_float_safe(beam->origin_hi[k])) return 0;
        set_region(beam, k, d, d, view->t_max);
        if (fabsf(d) > fabsf(view->direction[beam->main_axis])) beam->main_axis = k;
    }
    for (int a = 0; a < 3; ++a) {
        for (int j = 0; j < 3; ++j) {
            double slope = (double)view->direction[j] / view->direction[a];
            if (j != a) mlrt_set_slope(beam, a, j, slope, slope);
        }
    }
    beam->has_apex = 0;
    return 1;
}

int mlrt_make_view_beam(const struct mlrt_view *view, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                        struct mlrt_beam *beam)
{
    struct corners corners;
    find_corners(view, x, y, width, height, &corners);
    beam->may_cover = view->t_min == 0;
    beam->is_unlimited = isinf(view->t_max);
    return view->parallel ? make_parallel_beam(view, &corners, beam) : make_pinhole_beam(view, &corners, beam);
}
