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
#include "exact/vector.h"
#include "mlrta/beam.h"

/* The terms of a triangle at the four corners of a beam. Index 3 of value and bound is the determinant D. */
struct corner_terms {
    double value[4][4]; /* [edge][corner] */
    double bound[4];    /* of the errors of `value`, for all corners */
    double distance;    /* N */
    double distance_bound;
};

/* The directions of the corners, of length 1 along the main axis: corner i has the slopes i & 1 and i >> 1. */
struct corner_directions {
    int axis[3];    /* the main one, and the two others */
    double d[4][3]; /* by the axes above */
    double size[3]; /* the largest magnitude of each component */
};

static void set_corner_directions(const struct mlrt_beam *beam, struct corner_directions *corners)
{
    const int a = corners->axis[0] = beam->main_axis;
    const double main = beam->negative[a] ? -1 : 1;
    corners->size[0] = 1;
    for (int corner = 0; corner < 4; ++corner) corners->d[corner][0] = main;
    for (int side = 0; side < 2; ++side) {
        const int j = corners->axis[side + 1] = (a + side + 1) % 3;
        const double lo = beam->slope_lo[a][j] * main, hi = beam->slope_hi[a][j] * main;
        for (int corner = 0; corner < 4; ++corner) corners->d[corner][side + 1] = corner >> side & 1 ? hi : lo;
        corners->size[side + 1] = fmax(fabs(lo), fabs(hi));
    }
}

MLRT_INLINE double product_of(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Sets term i at the corners: that of the vector p x q, by the components along the corners' axes. */
static void set_corner_term(const struct corner_directions *corners, const double p[3], const double q[3], int i,
                            double cross[3], double size[3], struct corner_terms *terms)
{
    mlrt_cross_with_sizes(p, q, cross, size);
    for (int corner = 0; corner < 4; ++corner) terms->value[i][corner] = product_of(corners->d[corner], cross);
    terms->bound[i] = product_of(corners->size, size) * 0x1p-49;
}

static void set_corner_terms(const struct mlrt_triangle *triangle, const struct mlrt_beam *beam,
                             const struct corner_directions *corners, struct corner_terms *terms)
{
    double vertex[4][3], edge[2][3], cross[3], size[3];
    for (int k = 0; k < 3; ++k) {
        const int axis = corners->axis[k];
        for (int i = 0; i < 3; ++i) vertex[i][k] = (double)triangle->v[i][axis] - beam->origin_lo[axis];
        vertex[3][k] = vertex[0][k];
        edge[0][k] = (double)triangle->v[1][axis] - triangle->v[0][axis];
        edge[1][k] = (double)triangle->v[2][axis] - triangle->v[0][axis];
    }
    for (int i = 0; i < 3; ++i) set_corner_term(corners, vertex[i], vertex[i + 1], i, cross, size, terms);
    set_corner_term(corners, edge[0], edge[1], 3, cross, size, terms);
    terms->distance = product_of(vertex[0], cross);
    terms->distance_bound =
        (fabs(vertex[0][0]) * size[0] + fabs(vertex[0][1]) * size[1] + fabs(vertex[0][2]) * size[2]) * 0x1p-49;
}

/*
 * +1 or -1 if value i surely has that sign for the whole beam, else 0. It must exceed twice its error bound, so that
 * greatest_depth divides by more than half of |value|.
 */
static MLRT_NOINLINE int certain_sign(const struct corner_terms *terms, int i)
{
    double least = terms->value[i][0], greatest = least;
    for (int corner = 1; corner < 4; ++corner) {
        const double value = terms->value[i][corner];
        least = value < least ? value : least;
        greatest = value > greatest ? value : greatest;
    }
    return (least > 2 * terms->bound[i]) - (-greatest > 2 * terms->bound[i]);
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
    return (fabs(terms->distance) - terms->distance_bound) / (fabs(terms->value[3][corner]) + terms->bound[3]) *
           (1 - 0x1p-45);
}

MLRT_INLINE double greatest_depth(const struct corner_terms *terms, int corner)
{
    return (fabs(terms->distance) + terms->distance_bound) / (fabs(terms->value[3][corner]) - terms->bound[3]) *
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
static void end_region_at_cover(const struct corner_terms *cover, const struct corner_directions *corners,
                                struct mlrt_beam *beam)
{
    struct mlrt_box end = MLRT_NO_BOX;
    for (int corner = 0; corner < 4; ++corner) {
        const double *d = corners->d[corner], near = least_depth(cover, corner), far = greatest_depth(cover, corner);
        for (int i = 0; i < 3; ++i) {
            const int k = corners->axis[i];
            const double o = beam->origin_lo[k], p = near * d[i], q = far * d[i];
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
