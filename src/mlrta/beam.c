/* SPDX-License-Identifier: MIT */
/*
 * The beam of a tile of any source. view_beam.c makes the beams of cameras; those of arrays are made here, from every
 * ray of the tile.
 */
#include "mlrta/beam.h"

#include <math.h>

#include "exact/rounding.h"
#include "rays/source.h"

void mlrt_set_slope(struct mlrt_beam *beam, int a, int j, double lo, double hi)
{
    if (!(lo <= hi)) {
        lo = -INFINITY;
        hi = INFINITY;
    }
    /* A lower bound of +inf and an upper bound of -inf are no bounds either. */
    beam->slope_lo[a][j] = isinf(lo) ? -INFINITY : mlrt_float_down(lo - fabs(lo) * MLRT_SLOPE_SLACK);
    beam->slope_hi[a][j] = isinf(hi) ? INFINITY : mlrt_float_up(hi + fabs(hi) * MLRT_SLOPE_SLACK);
}

/*
 * Widens [*lo, *hi] to hold coordinate k of the ray from its origin to t_max. The product is exact in double; `slack`
 * covers the roundings of the sums.
 */
static void add_to_region(const struct mlrt_ray_segment *ray, int k, double *lo, double *hi)
{
    double end = ray->direction[k] == 0 ? ray->origin[k] : ray->origin[k] + (double)ray->t_max * ray->direction[k];
    double slack = isinf(end) ? 0 : (fabs(ray->origin[k]) + fabs(end)) * 0x1p-50;
    *lo = fmin(*lo, fmin(ray->origin[k], end - slack));
    *hi = fmax(*hi, fmax(ray->origin[k], end + slack));
}

/* Of the rays of a tile so far. */
struct bounds {
    double region_lo[3];
    double region_hi[3];
    float direction_lo[3];
    float direction_hi[3];
    uint32_t ray_count;
};

static void add_ray(const struct mlrt_ray_segment *ray, struct bounds *bounds)
{
    for (int a = 0; a < 3; ++a) {
        add_to_region(ray, a, &bounds->region_lo[a], &bounds->region_hi[a]);
        if (ray->direction[a] < bounds->direction_lo[a]) bounds->direction_lo[a] = ray->direction[a];
        if (ray->direction[a] > bounds->direction_hi[a]) bounds->direction_hi[a] = ray->direction[a];
    }
    ++bounds->ray_count;
}

/*
 * Widens the beam to hold the ray's origin. Returns 0 if the ray is not float-safe (source.h), or its signs differ from
 * those of the tile's first ray.
 */
static int fit_ray(const struct mlrt_ray_segment *ray, int first, struct mlrt_beam *beam)
{
    if (!mlrt_is_safe_ray(ray)) return 0;
    for (int k = 0; k < 3; ++k) {
        const float o = ray->origin[k];
        const int negative = ray->direction[k] < 0;
        if (first) {
            beam->origin_lo[k] = beam->origin_hi[k] = o;
            beam->negative[k] = negative;
        } else {
            if (negative != beam->negative[k]) return 0;
            if (o < beam->origin_lo[k]) beam->origin_lo[k] = o;
            if (o > beam->origin_hi[k]) beam->origin_hi[k] = o;
        }
    }
    if (ray->t_min > 0) beam->may_cover = 0;
    return 1;
}

/* Bounds d_j / d_a for all directions within the bounds; d_a has the same sign in all of them. */
static void set_slope_range(const struct bounds *bounds, int a, int j, struct mlrt_beam *beam)
{
    const double j_lo = bounds->direction_lo[j], j_hi = bounds->direction_hi[j];
    const double p = 1.0 / bounds->direction_lo[a], q = 1.0 / bounds->direction_hi[a];
    if (bounds->direction_lo[a] == 0 || bounds->direction_hi[a] == 0) {
        mlrt_set_slope(beam, a, j, -INFINITY, INFINITY);
        return;
    }
    mlrt_set_slope(beam, a, j, fmin(fmin(j_lo * p, j_lo * q), fmin(j_hi * p, j_hi * q)),
                   fmax(fmax(j_lo * p, j_lo * q), fmax(j_hi * p, j_hi * q)));
}

static void finish_beam(const struct bounds *bounds, struct mlrt_beam *beam)
{
    float size[3];
    beam->has_apex = 1;
    beam->main_axis = 0;
    for (int a = 0; a < 3; ++a) {
        size[a] = fmaxf(-bounds->direction_lo[a], bounds->direction_hi[a]);
        beam->has_apex &= beam->origin_lo[a] == beam->origin_hi[a];
        beam->region.lo[a] = mlrt_float_down(bounds->region_lo[a]);
        beam->region.hi[a] = mlrt_float_up(bounds->region_hi[a]);
        if (size[a] > size[beam->main_axis]) beam->main_axis = a;
        for (int j = 0; j < 3; ++j) {
            if (j != a) set_slope_range(bounds, a, j, beam);
        }
    }
}

int mlrt_get_beam(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                  struct mlrt_beam *beam)
{
    if (source->kind == MLRT_SOURCE_CAMERA) {
        const int made = mlrt_make_view_beam(&source->view, x, y, width, height, beam);
        beam->may_cover = beam->may_cover && !source->has_masks;
        return made;
    }

    struct bounds bounds = {.ray_count = 0};
    for (int a = 0; a < 3; ++a) {
        bounds.region_lo[a] = INFINITY;
        bounds.region_hi[a] = -INFINITY;
        bounds.direction_lo[a] = INFINITY;
        bounds.direction_hi[a] = -INFINITY;
    }
    beam->may_cover = source->arrays.skip.data == NULL && !source->has_masks;
    beam->is_unlimited = 0;
    for (uint32_t j = y; j < y + height; ++j) {
        for (uint32_t i = x; i < x + width; ++i) {
            struct mlrt_ray_segment ray;
            if (!mlrt_get_ray(source, i, j, &ray, NULL)) continue;
            if (!fit_ray(&ray, bounds.ray_count == 0, beam)) return 0;
            add_ray(&ray, &bounds);
        }
    }
    if (bounds.ray_count == 0) return 0;
    finish_beam(&bounds, beam);
    return 1;
}
