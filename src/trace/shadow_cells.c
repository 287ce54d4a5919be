/* SPDX-License-Identifier: MIT */
/*
 * The cells of a light: for each cell of a camera that one triangle covers, the slopes and depths of its shadow rays,
 * which are not made yet.
 *
 * The rays of a camera's cell have slopes in a rectangle, and all hit one triangle. In units of depth, a ray's
 * direction is d = (+-1, s, s'), and it hits the triangle's plane at z = N / D, in the terms of shadow_ray.h. If D > 0
 * over the whole rectangle, the hits lie in the quadrilateral whose corners are the hits of the rays at the corners of
 * the rectangle. So slopes and depths as seen from the light have their extremes at these corners, if the whole
 * quadrilateral lies in front of the light.
 *
 * ERRORS. m is rounded to float, by 2^-24 of at most 1. D is a sum of three products with slopes up to 2 and three
 * roundings: it is off by less than 2^-20. N, computed in double, is off by 2^-32 of P, the greatest |p_k|, and by
 * 2^-24 of itself. So with D > 2^-5 the condition of shadow_ray.h on D holds for each ray, as |d| is less than 5.1.
 * Then z is off by 2^-32 P / D < 2^-26 P, and by 2^-19.9 z / D. As |d_k| <= 2, hit points are off by twice that across:
 * 2^-18.9 z / D < 2^-18 z / D. Besides, each component is off by
 *
 *     2^-22 (|o - L| + 2 z)                 the rounding of o - L, z d and their sum, with something to spare
 *     2^-22 (|o - L| + 2 z) + 2^-27 P       the step off the surface
 *     2^-24 (|o - L| + 2 z)                 the rounding of the shadow ray itself
 *     3.1 * 2^-34 (P + 2.1 z) 2.1 / D < 2^-26 (P + 2 z)     "ITS PLACE" in shadow_ray.h
 *
 * The sum of these is less than 2^-20 (|o - L| + 2 z + P). With a smaller D the bounds would be wide, and the packet
 * gets shadow rays instead.
 */
#include "trace/shadow_cells.h"

#include <math.h>
#include <string.h>

#include "hits/shadow_ray.h"
#include "rays/slope_limits.h"
#include "simd/quad.h"
#include "trace/cells.h"
#include "trace/corner_slopes.h"

/* The least D, and the errors of hit points: relative to z / D, and relative to |o - L| + 2 z + P. */
#define LEAST_STEEPNESS 0x1p-5f
#define ALONG_ERROR     0x1p-18f
#define PLACE_ERROR     0x1p-20f

/* The plane of the cover of each cell. */
struct planes {
    MLRT_ALIGNED(16) float m[3][MLRT_BUNDLE_PACKETS];       /* m, with the sign that makes N positive */
    MLRT_ALIGNED(16) float n[MLRT_BUNDLE_PACKETS];          /* |N| */
    MLRT_ALIGNED(16) float greatest_p[MLRT_BUNDLE_PACKETS]; /* P */
};

enum side { UNKNOWN, DARK, FACING };

/* Finds the plane of a triangle, for one cell, and on which side of it the light is as seen from `eye`. */
static enum side find_plane(const struct mlrt_source *light, const struct mlrt_triangle *triangle, const float eye[3],
                            struct planes *planes, uint32_t place)
{
    struct mlrt_surface surface;
    mlrt_find_surface(light, triangle, eye, &surface);
    const double n = surface.n;
    if (!(surface.is_thick && fabs(n) > 2 * MLRT_SHADOW_SIDE * surface.greatest_p &&
          fabs(surface.height) > 2 * MLRT_SHADOW_SIDE * surface.height_size)) {
        return UNKNOWN;
    }
    if ((n > 0) != (surface.height > 0)) return DARK;
    const struct mlrt_vector m = mlrt_scale(surface.m, n > 0 ? 1 : -1);
    planes->m[0][place] = (float)m.x, planes->m[1][place] = (float)m.y, planes->m[2][place] = (float)m.z;
    planes->n[place] = (float)fabs(n);
    planes->greatest_p[place] = (float)(surface.greatest_p * (1 + 0x1p-22));
    return FACING;
}

/*
 * Finds the planes of the cells `among` whose covers face the light, and returns these cells. *dark receives those
 * whose covers surely face away. Cells in neither set are undecided.
 */
static uint32_t find_planes(const struct mlrt_source *light, const struct mlrt_tree *tree,
                            const struct mlrt_bundle *seen, uint32_t among, struct planes *planes, uint32_t *dark)
{
    uint32_t facing = 0, number = MLRT_NONE, last = 0;
    enum side side = UNKNOWN;
    for (; among; among &= among - 1) {
        const uint32_t place = mlrt_lowest_bit(among);
        if (seen->hulls.closed.cover[place] != number) {
            number = seen->hulls.closed.cover[place];
            const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
            side = find_plane(light, &triangle, seen->waist.point, planes, last = place);
        } else if (side == FACING) {
            for (int k = 0; k < 3; ++k) planes->m[k][place] = planes->m[k][last];
            planes->n[place] = planes->n[last];
            planes->greatest_p[place] = planes->greatest_p[last];
        }
        facing |= (uint32_t)(side == FACING) << place;
        *dark |= (uint32_t)(side == DARK) << place;
    }
    return facing;
}

/* Faces the waist of `shadows` along the shadow ray to the hit of the lowest slopes of one cell. */
static void face_shadow_cells(const struct mlrt_bundle *seen, const float from[3], const struct planes *planes,
                              uint32_t place, struct mlrt_bundle *shadows)
{
    const int a = seen->waist.main_axis;
    float d[3], steepness = 0, x[3];
    d[a] = seen->waist.sign;
    for (int side = 0; side < 2; ++side) d[mlrt_slope_axis(a, side)] = seen->hulls.term[side].lo[place];
    for (int k = 0; k < 3; ++k) steepness += planes->m[k][place] * d[k];
    for (int k = 0; k < 3; ++k) x[k] = from[k] + planes->n[place] / steepness * d[k];
    mlrt_face_waist(x, &shadows->waist);
}

/* For four cells: the extremes over the hits of their corner rays. */
struct hit_extremes {
    f4 least_steepness; /* D */
    f4 greatest_z;      /* from the camera */
    struct corner_slopes slopes;
};

/* Extends the extremes of four cells by the hits of their rays at one corner. */
static MLRT_NOINLINE void add_hits(const struct mlrt_bundle *seen, const struct planes *planes, const float from[3],
                                   uint32_t first, uint32_t corner, const struct mlrt_waist *waist,
                                   struct hit_extremes *of)
{
    const int a = seen->waist.main_axis;
    f4 d[3], x[3], steepness = f4_set1(0);
    d[a] = f4_set1(seen->waist.sign);
    for (uint32_t side = 0; side < 2; ++side) {
        const struct mlrt_hull_row *slopes = &seen->hulls.term[side];
        d[mlrt_slope_axis(a, (int)side)] = f4_load((corner >> side & 1 ? slopes->hi : slopes->lo) + first);
    }
    for (int k = 0; k < 3; ++k) steepness = f4_add(steepness, f4_mul(f4_load(planes->m[k] + first), d[k]));
    const f4 z = f4_div(f4_load(planes->n + first), steepness);
    of->least_steepness = f4_min(steepness, of->least_steepness);
    of->greatest_z = f4_max(z, of->greatest_z);
    for (int k = 0; k < 3; ++k) {
        const int axis = (waist->main_axis + k) % 3;
        x[k] = f4_add(f4_set1(from[axis]), f4_mul(z, d[axis]));
    }
    add_corner(waist->sign, x, &of->slopes);
}

/* Sets the slopes and depths of four cells. Returns those whose bounds are not too wide and slopes not too steep. */
static uint32_t set_shadow_cells(const struct hit_extremes *of, const struct planes *planes, float away, uint32_t first,
                                 struct mlrt_bundle *shadows)
{
    const f4 z = of->greatest_z,
             sizes = f4_add(f4_add(f4_set1(away), f4_add(z, z)), f4_load(planes->greatest_p + first));
    const f4 along = f4_div(f4_mul(f4_set1(ALONG_ERROR), z), of->least_steepness);
    const f4 error = f4_add(f4_add(f4_mul(f4_set1(PLACE_ERROR), sizes), along), f4_set1(SLOPE_FLOOR));
    const f4 least = f4_sub(of->slopes.least_depth, error), greatest = f4_add(of->slopes.greatest_depth, error);
    f4_store(shadows->hulls.closed.common_last + first, f4_mul(least, f4_set1(1 - SLOPE_SLACK)));
    f4_store(shadows->hulls.last + first, f4_mul(greatest, f4_set1(1 + SLOPE_SLACK)));
    return set_cell_slopes(&of->slopes, (const f4[3]){error, error, error}, first, &shadows->hulls) &
           f4_above(of->least_steepness, f4_set1(LEAST_STEEPNESS));
}

uint32_t mlrt_make_shadow_cells(const struct mlrt_source *light, const struct mlrt_tree *tree,
                                const struct mlrt_bundle *seen, uint32_t among, struct mlrt_bundle *shadows,
                                uint32_t *dark)
{
    struct planes planes;
    float from[3], away = 0;
    *dark = 0;
    mlrt_begin_cells(0, shadows);
    shadows->ends_at_skip = 1;
    memcpy(shadows->hulls.closed.skip, seen->hulls.closed.cover, sizeof shadows->hulls.closed.skip);
    memcpy(shadows->waist.point, light->light, sizeof shadows->waist.point);
    for (int k = 0; k < 3; ++k) {
        if (!mlrt_is_float_safe(light->light[k])) return 0;
        from[k] = seen->waist.point[k] - light->light[k];
        away = fmaxf(away, fabsf(from[k]));
    }
    memset(&planes, 0, sizeof planes);
    const uint32_t facing = find_planes(light, tree, seen, among, &planes, dark);
    if (!facing) return 0;
    face_shadow_cells(seen, from, &planes, mlrt_lowest_bit(facing), shadows);
    uint32_t known = 0;
    for (uint32_t first = 0; first < MLRT_BUNDLE_PACKETS; first += 4) {
        struct hit_extremes of = {f4_set1(INFINITY), f4_set1(-INFINITY), NO_CORNERS};
        if (!(facing >> first & 15)) continue;
        for (uint32_t corner = 0; corner < 4; ++corner)
            add_hits(seen, &planes, from, first, corner, &shadows->waist, &of);
        known |= set_shadow_cells(&of, &planes, away, first, shadows) << first;
    }
    known &= facing;
    shadows->state.going = shadows->state.closed = shadows->state.apexes = known;
    return known;
}
