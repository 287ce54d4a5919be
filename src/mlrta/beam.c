/* SPDX-License-Identifier: MIT */
/* The beam of a tile: of a camera by the corners of the tile, of arrays by every ray. */
#include "mlrta/beam.h"

#include <math.h>

#include "exact/rounding.h"
#include "rays/slope_limits.h"
#include "rays/source.h"

void mlrt_set_slope(struct mlrt_beam *beam, int a, int j, double lo, double hi)
{
    if (!(lo <= hi)) {
        lo = -INFINITY;
        hi = INFINITY;
    }
    /* A lower bound of +inf and an upper bound of -inf are no bounds either. */
    beam->slope_lo[a][j] = isinf(lo) ? -INFINITY : mlrt_float_down(lo - fabs(lo) * SLOPE_SLACK);
    beam->slope_hi[a][j] = isinf(hi) ? INFINITY : mlrt_float_up(hi + fabs(hi) * SLOPE_SLACK);
}

/* ---- cameras ------------------------------------------------------------------------------------------------- */

/*
 * A tile's vectors p = d00 + x dx + y dy are affine in (x, y). So over the rectangle of sample positions, each
 * component has its extremes at the four corners, and so has each ratio of two components whose denominator keeps its
 * sign. But the rays have *rounded* vectors. By the formula of rays/camera.h, component k is off by at most
 *
 *     fl(x dx): u |x dx|;  first sum: u (|d00| + |x dx|)(1 + u);  fl(y dy): u |y dy|;  second sum: u of everything
 *
 * so by less than 3 u (|d00_k| + |x dx_k| + |y dy_k|) (1 + 2 u), with u = 2^-24. `pad` is 4 u times the largest such
 * sum over the corners, plus 2^-146 for underflow. With exact values A and pads p, a ratio is off by
 *
 *     |(A_j + e_j) / (A_a + e_a) - A_j / A_a| <= (p_j + |A_j / A_a| p_a) / (|A_a| - p_a).
 */

/* The vectors p at the corners of a tile's sample positions, off by at most 2^-52 of their terms, and the pads. */
struct corners {
    double p[3][4];
    double pad[3];
};

static void find_corners(const mlrt_camera *view, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                         struct corners *corners)
{
    const double xs[2] = {mlrt_sample_position(view->crop_x, x, view->sample_x),
                          mlrt_sample_position(view->crop_x, x + width - 1, view->sample_x)};
    const double ys[2] = {mlrt_sample_position(view->crop_y, y, view->sample_y),
                          mlrt_sample_position(view->crop_y, y + height - 1, view->sample_y)};
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

/* Bounds of component k over the rays of the tile. If it is exactly 0 for every pixel, it needs no pad. */
static struct range component_range(const mlrt_camera *view, const struct corners *corners, int k)
{
    struct range range = {corners->p[k][0], corners->p[k][0]};
    if (view->d00[k] == 0 && view->dx[k] == 0 && view->dy[k] == 0) return (struct range){0, 0};
    for (int i = 1; i < 4; ++i) {
        range.lo = corners->p[k][i] < range.lo ? corners->p[k][i] : range.lo;
        range.hi = corners->p[k][i] > range.hi ? corners->p[k][i] : range.hi;
    }
    return (struct range){range.lo - corners->pad[k], range.hi + corners->pad[k]};
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

/*
 * Sets the main axis and the slopes from the directions at the corners, which lie within `range`. Returns 0 if all of
 * their components may be 0.
 */
static int set_corner_slopes(const struct corners *corners, const struct range range[3], struct mlrt_beam *beam)
{
    double reciprocal[3][4], nearest[3]; /* min |A_a| - p_a */
    beam->main_axis = 0;
    for (int k = 0; k < 3; ++k) {
        nearest[k] = beam->negative[k] ? -range[k].hi : range[k].lo;
        if (nearest[k] > nearest[beam->main_axis]) beam->main_axis = k;
        for (int i = 0; i < 4; ++i) reciprocal[k][i] = 1 / corners->p[k][i];
    }
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
    return nearest[beam->main_axis] > 0;
}

/*
 * Makes the beam of a tile of a camera. Returns 0 if its rays differ in sign, or may not be float-safe. The corners'
 * vectors are directions of a pinhole camera's rays, and origins of a parallel one's.
 */
static int make_camera_beam(const mlrt_camera *view, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                            struct mlrt_beam *beam)
{
    struct corners corners;
    struct range origin, direction[3];
    find_corners(view, x, y, width, height, &corners);
    beam->may_cover = view->t_min == 0;
    beam->is_unlimited = isinf(view->t_max);
    beam->has_apex = !mlrt_is_parallel(view);
    for (int k = 0; k < 3; ++k) {
        origin = direction[k] = component_range(view, &corners, k);
        if (mlrt_is_parallel(view)) {
            direction[k].lo = direction[k].hi = view->direction[k];
            for (int i = 0; i < 4; ++i) corners.p[k][i] = view->direction[k];
            corners.pad[k] = 0;
        } else {
            origin.lo = origin.hi = view->eye[k];
        }
        if (direction[k].lo < 0 && direction[k].hi >= 0) return 0;
        if (direction[k].lo < -MLRT_SAFE_MAX || direction[k].hi > MLRT_SAFE_MAX) return 0;
        beam->negative[k] = direction[k].hi < 0;
        beam->origin_lo[k] = mlrt_float_down(origin.lo);
        beam->origin_hi[k] = mlrt_float_up(origin.hi);
        if (!mlrt_is_float_safe(beam->origin_lo[k]) || !mlrt_is_float_safe(beam->origin_hi[k])) return 0;
        set_region(beam, k, direction[k].lo, direction[k].hi, view->t_max);
    }
    return set_corner_slopes(&corners, direction, beam);
}

/* ---- arrays -------------------------------------------------------------------------------------------------- */

/* Sets the main axis, and bounds of the slopes of all directions between lo and hi. Each component has one sign. */
static void set_slopes(const float lo[3], const float hi[3], struct mlrt_beam *beam)
{
    float size[3];
    beam->main_axis = 0;
    for (int a = 0; a < 3; ++a) {
        size[a] = fmaxf(-lo[a], hi[a]);
        if (size[a] > size[beam->main_axis]) beam->main_axis = a;
        for (int j = 0; j < 3; ++j) {
            const double p = (double)lo[j] / lo[a], q = (double)lo[j] / hi[a];
            const double r = (double)hi[j] / lo[a], s = (double)hi[j] / hi[a];
            if (j == a) continue;
            if (lo[a] == 0 || hi[a] == 0)
                mlrt_set_slope(beam, a, j, -INFINITY, INFINITY);
            else
                mlrt_set_slope(beam, a, j, fmin(fmin(p, q), fmin(r, s)), fmax(fmax(p, q), fmax(r, s)));
        }
    }
}

/*
 * Widens a range to hold coordinate k of the ray from its origin to t_max. The product is exact in double; `slack`
 * covers the roundings of the sums.
 */
static void add_to_region(const struct mlrt_ray_segment *ray, int k, struct range *range)
{
    double end = ray->direction[k] == 0 ? ray->origin[k] : ray->origin[k] + (double)ray->t_max * ray->direction[k];
    double slack = isinf(end) ? 0 : (fabs(ray->origin[k]) + fabs(end)) * 0x1p-50;
    range->lo = fmin(range->lo, fmin(ray->origin[k], end - slack));
    range->hi = fmax(range->hi, fmax(ray->origin[k], end + slack));
}

/* Of the rays of a tile so far. */
struct tile_bounds {
    struct range region[3];
    struct mlrt_box direction;
    uint32_t ray_count;
};

/*
 * Adds a ray to the bounds and its origin to the beam. Returns 0 if the ray is not float-safe (source.h), or its signs
 * differ from those of the tile's first ray.
 */
static int fit_ray(const struct mlrt_ray_segment *ray, struct tile_bounds *bounds, struct mlrt_beam *beam)
{
    const int is_first = bounds->ray_count++ == 0;
    if (!mlrt_is_safe_ray(ray)) return 0;
    for (int k = 0; k < 3; ++k) {
        const float o = ray->origin[k], d = ray->direction[k];
        if (is_first) {
            beam->origin_lo[k] = beam->origin_hi[k] = o;
            beam->negative[k] = d < 0;
        }
        if ((d < 0) != beam->negative[k]) return 0;
        if (o < beam->origin_lo[k]) beam->origin_lo[k] = o;
        if (o > beam->origin_hi[k]) beam->origin_hi[k] = o;
        if (d < bounds->direction.lo[k]) bounds->direction.lo[k] = d;
        if (d > bounds->direction.hi[k]) bounds->direction.hi[k] = d;
        add_to_region(ray, k, &bounds->region[k]);
    }
    if (ray->t_min > 0) beam->may_cover = 0;
    return 1;
}

/* Makes the beam of the rays of arrays. Returns 0 if it has none. */
static int make_array_beam(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                           struct mlrt_beam *beam)
{
    const struct range none = {INFINITY, -INFINITY};
    struct tile_bounds bounds = {{none, none, none}, MLRT_NO_BOX, 0};
    beam->may_cover = source->arrays.skip.data == NULL;
    beam->is_unlimited = 0;
    for (uint32_t j = y; j < y + height; ++j) {
        for (uint32_t i = x; i < x + width; ++i) {
            struct mlrt_ray_segment ray;
            uint32_t skip;
            if (mlrt_get_ray(source, j * source->width + i, &ray, &skip) && !fit_ray(&ray, &bounds, beam)) return 0;
        }
    }
    if (bounds.ray_count == 0) return 0;
    set_slopes(bounds.direction.lo, bounds.direction.hi, beam);
    beam->has_apex = 1;
    for (int k = 0; k < 3; ++k) {
        beam->has_apex &= beam->origin_lo[k] == beam->origin_hi[k];
        beam->region.lo[k] = mlrt_float_down(bounds.region[k].lo);
        beam->region.hi[k] = mlrt_float_up(bounds.region[k].hi);
    }
    return 1;
}

int mlrt_get_beam(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                  struct mlrt_beam *beam)
{
    const int made = source->kind == MLRT_SOURCE_CAMERA ? make_camera_beam(&source->view, x, y, width, height, beam)
                                                        : make_array_beam(source, x, y, width, height, beam);
    beam->may_cover = beam->may_cover && !mlrt_has_masks(source);
    return made;
}
