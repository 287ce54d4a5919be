/* SPDX-License-Identifier: MIT */
/*
 * A beam with an apex against triangles: whether a triangle covers the beam (every ray hits it), whether every ray
 * misses a triangle, and whether one triangle lies behind another for every ray.
 *
 * Every direction of the beam is a positive multiple of one in a rectangle of slopes over the main axis. For a
 * direction d and a triangle seen from the apex, the edge functions e, D = d . n, and N D' - N' D of two triangles are
 * linear in d. So a function that surely has one sign at the four corners of the rectangle has that sign for every ray,
 * and the points where rays hit a covering triangle lie in the convex hull of those of the four corners.
 *
 * All of this is computed in double, with edge functions d . (a x b) of vertices relative to the apex. They take 7
 * roundings: two differences, a product, a subtraction, a product and two sums; N takes 8. So 16 u times the sum of
 * magnitudes bounds the error, with u = 2^-53.
 *
 * Based on: Reshetov et al. 2005, section 4.1 (a leaf with an object that every possible ray hits ends the search).
 */
#ifndef MLRT_MLRTA_COVERING_H
#define MLRT_MLRTA_COVERING_H

#include <math.h>

#include "base/platform.h"
#include "exact/rounding.h"
#include "mlrta/beam.h"

/* The terms of a triangle at the four corners of a beam. Index 3 of value and bound is the determinant D. */
struct corner_terms {
    double value[4][4]; /* [edge][corner] */
    double bound[4][4]; /* of the errors of `value` */
    double distance;    /* N */
    double distance_bound;
};

/* The direction of a corner, of length 1 along the main axis. */
MLRT_INLINE void corner_direction(const struct mlrt_beam *beam, int corner, double d[3])
{
    const int a = beam->main_axis, j = (a + 1) % 3, l = (a + 2) % 3;
    d[a] = beam->negative[a] ? -1 : 1;
    d[j] = (corner & 1 ? beam->slope_hi : beam->slope_lo)[a][j] * d[a];
    d[l] = (corner & 2 ? beam->slope_hi : beam->slope_lo)[a][l] * d[a];
}

static void set_corner_terms(const struct mlrt_triangle *triangle, const struct mlrt_beam *beam,
                             struct corner_terms *terms)
{
    double vertex[3][3], edge[2][3], cross[4][3], size[4][3];
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) vertex[i][k] = (double)triangle->v[i][k] - beam->origin_lo[k];
        edge[0][k] = (double)triangle->v[1][k] - triangle->v[0][k];
        edge[1][k] = (double)triangle->v[2][k] - triangle->v[0][k];
    }
    for (int i = 0; i < 4; ++i) {
        const double *p = i < 3 ? vertex[i] : edge[0], *q = i < 3 ? vertex[(i + 1) % 3] : edge[1];
        for (int k = 0; k < 3; ++k) {
            const double r = p[(k + 1) % 3] * q[(k + 2) % 3], s = p[(k + 2) % 3] * q[(k + 1) % 3];
            cross[i][k] = r - s;
            size[i][k] = fabs(r) + fabs(s);
        }
    }
    terms->distance = terms->distance_bound = 0;
    for (int k = 0; k < 3; ++k) {
        terms->distance += vertex[0][k] * cross[3][k];
        terms->distance_bound += fabs(vertex[0][k]) * size[3][k] * 0x1p-49;
    }
    for (int corner = 0; corner < 4; ++corner) {
        double d[3];
        corner_direction(beam, corner, d);
        for (int i = 0; i < 4; ++i) {
            terms->value[i][corner] = d[0] * cross[i][0] + d[1] * cross[i][1] + d[2] * cross[i][2];
            terms->bound[i][corner] =
                (fabs(d[0]) * size[i][0] + fabs(d[1]) * size[i][1] + fabs(d[2]) * size[i][2]) * 0x1p-49;
        }
    }
}

/*
 * +1 or -1 if value i surely has that sign for the whole beam, else 0. It must exceed twice its error bound, so that
 * greatest_depth divides by more than half of |value|.
 */
MLRT_INLINE int certain_sign(const struct corner_terms *terms, int i)
{
    int above = 1, below = 1;
    for (int corner = 0; corner < 4; ++corner) {
        above &= terms->value[i][corner] > 2 * terms->bound[i][corner];
        below &= -terms->value[i][corner] > 2 * terms->bound[i][corner];
    }
    return above - below;
}

/* 1 if every ray of the beam surely hits the triangle at a t > 0. */
static int covers_beam(const struct corner_terms *terms)
{
    const int sign = certain_sign(terms, 3);
    return sign != 0 && certain_sign(terms, 0) == sign && certain_sign(terms, 1) == sign &&
           certain_sign(terms, 2) == sign && sign * terms->distance > terms->distance_bound;
}

/*
 * 1 if surely no ray of the beam hits the triangle at a t > 0: two of its edge functions have opposite signs, or the
 * triangle is behind the apex.
 */
static int misses_beam(const struct corner_terms *terms)
{
    const int ab = certain_sign(terms, 0), bc = certain_sign(terms, 1), ca = certain_sign(terms, 2);
    if (ab * bc < 0 || bc * ca < 0 || ca * ab < 0) return 1;
    return -certain_sign(terms, 3) * terms->distance > terms->distance_bound;
}

/*
 * The least and the greatest depth, along the main axis, at which a corner ray can cross the triangle's plane. D has a
 * certain sign there.
 */
MLRT_INLINE double least_depth(const struct corner_terms *terms, int corner)
{
    return (fabs(terms->distance) - terms->distance_bound) / (fabs(terms->value[3][corner]) + terms->bound[3][corner]) *
           (1 - 0x1p-45);
}

MLRT_INLINE double greatest_depth(const struct corner_terms *terms, int corner)
{
    return (fabs(terms->distance) + terms->distance_bound) / (fabs(terms->value[3][corner]) - terms->bound[3][corner]) *
           (1 + 0x1p-45);
}

/* 1 if every ray of the beam surely crosses the plane of `other` in front of the apex, and behind `cover`. */
static int is_behind(const struct corner_terms *other, const struct corner_terms *cover)
{
    const int sign = certain_sign(other, 3);
    if (sign == 0 || !(sign * other->distance > other->distance_bound)) return 0;
    for (int corner = 0; corner < 4; ++corner) {
        if (!(least_depth(other, corner) > greatest_depth(cover, corner))) return 0;
    }
    return 1;
}

/* Ends the beam's region at a triangle that covers it: hits behind that triangle decide nothing. */
static void end_region_at_cover(const struct corner_terms *cover, struct mlrt_beam *beam)
{
    struct mlrt_box end = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int corner = 0; corner < 4; ++corner) {
        double d[3];
        corner_direction(beam, corner, d);
        for (int k = 0; k < 3; ++k) {
            const double o = beam->origin_lo[k];
            const double p = least_depth(cover, corner) * d[k], q = greatest_depth(cover, corner) * d[k];
            const double slack = (fabs(o) + fabs(p) + fabs(q)) * 0x1p-48;
            end.lo[k] = fminf(end.lo[k], mlrt_float_down(o + fmin(p, q) - slack));
            end.hi[k] = fmaxf(end.hi[k], mlrt_float_up(o + fmax(p, q) + slack));
        }
    }
    for (int k = 0; k < 3; ++k) {
        if (beam->negative[k]) {
            if (end.lo[k] > beam->region.lo[k]) beam->region.lo[k] = end.lo[k];
        } else {
            if (end.hi[k] < beam->region.hi[k]) beam->region.hi[k] = end.hi[k];
        }
    }
}

#endif
