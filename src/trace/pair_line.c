/* SPDX-License-Identifier: MIT */
/*
 * WHAT IS COMPUTED. A ray meets the planes of triangles 1 and 2 at t_1 = N_1 / D_1 and t_2 = N_2 / D_2, and plane 2 at the
 * point that is the mean of its corners c_i with the weights e_i / D_2, where e_i is the edge function of the edge across
 * from c_i. With h_i = n_1 . (a_1 - c_i), the height of corner c_i below plane 1, that makes
 *
 *     N_1 D_2 - N_2 D_1 = F = sum of h_i e_i,    t_1 - t_2 = F / (D_1 D_2)
 *
 * whether the ray passes inside of triangle 2 or not. The heights do not depend on the ray. So F is linear in what e_i is
 * linear in, the terms of a ray of a bundle (leaf.h): it is an edge function of the line that both planes
 * have in common. Where planes are close to each other, what cancels in N_1 D_2 - N_2 D_1 has cancelled in the heights.
 * If all heights have one sign, so has F for rays that hit triangle 2: F / D_2 is a mean of heights.
 *
 * HEIGHTS, in double, v = 2^-53. 8 roundings (predicate.c, N), relative to the sum of the magnitudes of the six products,
 * which as computed lacks at most 10: less than 8.001 v of it. HEIGHT_ERROR is 10 v. A corner that both triangles have
 * is at height 0. If no height is certain the planes are one, or too close for this.
 *
 * THE LINE, u = 2^-24. Let size_i and g_i belong to edge function e_i as in leaf.h, and S = the sum of |h_i| size_i,
 * G that of |h_i| |g_i|, S at least 2^-20 G; the bounds of h_i take the place of |h_i| in S' and G', and q is the greater
 * of S' / S and G' / G. The coefficients of F / S are sums of h_i times coefficients of e_i: they have 8 roundings of v, and
 * one of u. So F has 5 roundings of u less than an edge function, and one of its own besides: as |e_i| <= R size_i +
 * X R |g_i|, where heights are off F / S is off by no more than q (R + X R rho), rho = G / S. Edge functions have the bound
 * 14 u R + (13 u X + 4 u R A + floor) R rho. That times 1 + q / 6 u is 2.1 q (R + X R rho) more, which is twice as much as
 * it has to be.
 *
 * RANGE. Corners that are usual are at most 2^60 and multiples of 2^-149. So heights, products of three differences, are 0
 * or within 2^-447 .. 2^187, coefficients within 2^-745 .. 2^313, and nothing overflows or underflows.
 */
#include "trace/pair_line.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "hits/undecided.h"

#define HEIGHT_ERROR (10 * MLRT_UNIT_ROUNDOFF)

/* Lines whose heights are off by more than this many u are none. */
#define MOST_DOUBT 64

/* Of edge functions: leaf.h. */
#define EDGE_ERROR (14 * 0x1p-24)

/* A cross product and its size, component by component. */
static void cross_with_sizes(const double p[3], const double q[3], double cross[3], double size[3])
{
    for (int k = 0; k < 3; ++k) {
        const double r = p[(k + 1) % 3] * q[(k + 2) % 3], s = p[(k + 2) % 3] * q[(k + 1) % 3];
        cross[k] = r - s;
        size[k] = fabs(r) + fabs(s);
    }
}

/* Corners by axis from the main one on, in the signs of the waist; 0 if the triangle is odd. */
static int load_corners(const struct mlrt_tree *tree, const struct mlrt_waist *waist, uint32_t number,
                        double corner[3][3])
{
    const struct mlrt_triangle *triangle = &tree->triangles[number];
    const double unit = tree->bvh.unit, sign = waist->sign;
    const int j = (waist->main_axis + 1) % 3, l = (waist->main_axis + 2) % 3;
    int is_usual = 1;
    for (int i = 0; i < 3; ++i) {
        corner[i][0] = triangle->v[i][waist->main_axis] * unit * sign;
        corner[i][1] = triangle->v[i][j] * unit;
        corner[i][2] = triangle->v[i][l] * unit;
        for (int k = 0; k < 3; ++k) {
            is_usual &= fabs(corner[i][k]) <= MLRT_SAFE_MAX && (double)(float)corner[i][k] == corner[i][k];
        }
    }
    return is_usual;
}

static void subtract(const double p[3], const double q[3], double difference[3])
{
    for (int k = 0; k < 3; ++k) difference[k] = p[k] - q[k];
}

void mlrt_set_plane(const struct mlrt_triangle *triangle, struct mlrt_plane *plane)
{
    double ab[3], ac[3];
    for (int k = 0; k < 3; ++k) {
        plane->point[k] = triangle->v[0][k];
        ab[k] = triangle->v[1][k] - plane->point[k];
        ac[k] = triangle->v[2][k] - plane->point[k];
    }
    cross_with_sizes(ab, ac, plane->normal, plane->size);
}

static int is_corner(double (*corner)[3], const double point[3])
{
    for (int i = 0; i < 3; ++i) {
        if (corner[i][0] == point[0] && corner[i][1] == point[1] && corner[i][2] == point[2]) return 1;
    }
    return 0;
}

/* How far corners of the second triangle lie below the plane of the first, and bounds of the errors. Returns how many
 * heights are certainly above 0, less those that are below; *certain receives how many are certain at all. */
static int find_heights(double (*first)[3], double (*second)[3], double height[3], double error[3], int *certain)
{
    double ab[3], ac[3], normal[3], size[3];
    int balance = 0;
    *certain = 0;
    subtract(first[1], first[0], ab);
    subtract(first[2], first[0], ac);
    cross_with_sizes(ab, ac, normal, size);
    for (int i = 0; i < 3; ++i) {
        double to[3];
        subtract(first[0], second[i], to);
        height[i] = to[0] * normal[0] + to[1] * normal[1] + to[2] * normal[2];
        error[i] = HEIGHT_ERROR * (fabs(to[0]) * size[0] + fabs(to[1]) * size[1] + fabs(to[2]) * size[2]);
        const int sign = (height[i] > error[i]) - (height[i] < -error[i]);
        if (sign == 0 && is_corner(first, second[i])) height[i] = error[i] = 0;
        balance += sign;
        *certain += sign != 0;
    }
    return balance;
}

/* Sets the line from the corners of the second triangle and their heights; 0 if it is too uncertain. */
static int set_line(double (*corner)[3], const double from[3], const double height[3], const double error[3],
                    struct mlrt_pair_line *line)
{
    double moment[3] = {0, 0, 0}, along[3] = {0, 0, 0}, all = 0, all_off = 0, length = 0, length_off = 0;
    for (int i = 0; i < 3; ++i) {
        double to[3], g[3], cross[3], size[3];
        const double h = height[(i + 2) % 3], off = error[(i + 2) % 3];
        subtract(corner[i], from, to);
        subtract(corner[(i + 1) % 3], corner[i], g);
        cross_with_sizes(to, g, cross, size);
        const double weight = size[0] + 0.5 * (size[1] + size[2]), g_size = fabs(g[0]) + fabs(g[1]) + fabs(g[2]);
        for (int k = 0; k < 3; ++k) {
            moment[k] += h * cross[k];
            along[k] += h * g[k];
        }
        all += fabs(h) * weight;
        all_off += off * weight;
        length += fabs(h) * g_size;
        length_off += off * g_size;
    }
    all = fmax(all, 0x1p-20 * length);
    const double scale = 1 / all, doubt = 1 + fmax(all_off * scale, length_off / length) * (0x1p24 / 6);
    line->constant = (float)(moment[0] * scale);
    line->coefficient[MLRT_SLOPE_J] = (float)(moment[1] * scale);
    line->coefficient[MLRT_SLOPE_L] = (float)(moment[2] * scale);
    line->coefficient[MLRT_PLACE_J] = (float)(-along[2] * scale);
    line->coefficient[MLRT_PLACE_L] = (float)(along[1] * scale);
    line->coefficient[MLRT_MOMENT] = (float)(along[0] * scale);
    line->error = (float)(EDGE_ERROR * doubt);
    line->steepness = (float)(length * scale * doubt * (1 + 0x1p-22));
    return doubt <= MOST_DOUBT;
}

static void set_normal(double (*corner)[3], struct mlrt_pair_line *line)
{
    double ab[3], ac[3], normal[3], size[3];
    subtract(corner[1], corner[0], ab);
    subtract(corner[2], corner[0], ac);
    cross_with_sizes(ab, ac, normal, size);
    const double scale = 1 / (size[0] + 0.5 * (size[1] + size[2]));
    for (int k = 0; k < 3; ++k) line->normal[k] = (float)(normal[k] * scale);
}

MLRT_NOINLINE void mlrt_set_pair_line(const struct mlrt_tree *tree, const struct mlrt_bundle_cache *cache,
                                      uint32_t first, uint32_t second, struct mlrt_worker *worker,
                                      struct mlrt_pair_line *line)
{
    const struct mlrt_waist *waist = &cache->waist;
    double corner_1[3][3], corner_2[3][3], height[3], error[3];
    const double from[3] = {(double)waist->sign * waist->point[waist->main_axis],
                            waist->point[(waist->main_axis + 1) % 3], waist->point[(waist->main_axis + 2) % 3]};
    int certain;
    line->waist_count = cache->waist_count;
    line->first = first;
    line->second = second;
    line->kind = MLRT_ONE_PLANE;
    if (mlrt_known_plane_of(worker, first) == mlrt_known_plane_of(worker, second)) return;
    line->kind = MLRT_NO_LINE;
    if (!load_corners(tree, waist, first, corner_1) || !load_corners(tree, waist, second, corner_2)) return;
    const int balance = find_heights(corner_1, corner_2, height, error, &certain);
    if (certain == 0) {
        line->kind = mlrt_have_one_plane(tree, first, second, worker) ? MLRT_ONE_PLANE : MLRT_NO_LINE;
    } else if (balance == 3 || balance == -3) {
        line->kind = MLRT_LINE;
        memset(line->coefficient, 0, sizeof line->coefficient);
        memset(line->normal, 0, sizeof line->normal);
        line->error = line->steepness = 0;
        line->constant = balance > 0 ? 1 : -1; /* as if D_2 were positive: F / D_2 has the sign of the heights */
        line->normal[0] = 1;
    } else {
        line->kind = set_line(corner_2, from, height, error, line) ? MLRT_LINE : MLRT_NO_LINE;
        set_normal(corner_2, line);
    }
}
