/* SPDX-License-Identifier: MIT */
/*
 * A beam against cells: which children of a cell can its rays reach, and can they reach a box at all.
 *
 * A ray that is in front of its origin by x along axis a is at o_j + m x on axis j, with m = d_j / d_a. All tests compare
 * such products with distances from the origin, m x against (h - o_j): four roundings at most, each relative, and the
 * beam's slopes are already widened by 2^-20 of themselves. So an answer "no" is a proof, at any scale; packet.h's limits
 * rule out underflow that could matter. Comparisons with a NaN (0 times infinity) are false: not excluded.
 *
 * Based on: Reshetov et al. 2005, section 3.3: direct culling puts the planes of the beam against the box, inverse
 * culling the planes of the box against the beam.
 */

enum {
    NEAR_CHILD = 1,
    FAR_CHILD = 2,
    BOTH_CHILDREN = 3
};

/* Bounds of m x for m in [slope_lo, slope_hi] and x between x_lo <= x_hi, which have one sign. */
MLRT_INLINE struct distance_interval offset_range(const struct mlrt_beam *beam, int a, int j, float x_lo, float x_hi)
{
    const float m_lo = beam->slope_lo[a][j], m_hi = beam->slope_hi[a][j];
    if (x_lo >= 0) {
        return (struct distance_interval){m_lo * (m_lo >= 0 ? x_lo : x_hi), m_hi * (m_hi >= 0 ? x_hi : x_lo)};
    }
    return (struct distance_interval){m_hi * (m_hi >= 0 ? x_lo : x_hi), m_lo * (m_lo >= 0 ? x_hi : x_lo)};
}

/*
 * Inverse culling: the plane x_a = c splits a cell that the beam touches. On it, the rays fill a rectangle. Where that
 * lies wholly past the side through which the rays leave the cell, none gets to the far child; where it lies wholly before
 * the side through which they come in, none was in the near child.
 */
MLRT_INLINE int cull_inverse(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    const float x_lo = c - beam->origin_hi[a], x_hi = c - beam->origin_lo[a];
    if (beam->negative[a] ? x_lo > 0 : x_hi < 0) return FAR_CHILD; /* the plane is behind every origin */
    if (beam->negative[a] ? x_hi > 0 : x_lo < 0) return BOTH_CHILDREN;
    for (int step = 1; step < 3; ++step) {
        const int j = (a + step) % 3;
        const struct distance_interval q = offset_range(beam, a, j, x_lo, x_hi);
        const int above = q.lo > cell->hi[j] - beam->origin_lo[j];
        const int below = q.hi < cell->lo[j] - beam->origin_hi[j];
        if (beam->negative[j] ? below : above) return NEAR_CHILD;
        if (beam->negative[j] ? above : below) return FAR_CHILD;
    }
    return BOTH_CHILDREN;
}

/* 1 if, seen along axis a, no ray of the beam touches the box. */
MLRT_INLINE int misses_box_along(const struct mlrt_beam *beam, const struct mlrt_box *box, int a)
{
    float x_lo = box->lo[a] - beam->origin_hi[a], x_hi = box->hi[a] - beam->origin_lo[a];
    if (beam->negative[a]) {
        if (x_lo > 0) return 1;
        if (x_hi > 0) x_hi = 0;
    } else {
        if (x_hi < 0) return 1;
        if (x_lo < 0) x_lo = 0;
    }
    for (int step = 1; step < 3; ++step) {
        const int j = (a + step) % 3;
        const struct distance_interval q = offset_range(beam, a, j, x_lo, x_hi);
        if (q.lo > box->hi[j] - beam->origin_lo[j] || q.hi < box->lo[j] - beam->origin_hi[j]) return 1;
    }
    return 0;
}

/* 1 if no ray of the beam touches the box: all six faces against the beam. */
static int misses_box(const struct mlrt_beam *beam, const struct mlrt_box *box)
{
    return misses_box_along(beam, box, 0) || misses_box_along(beam, box, 1) || misses_box_along(beam, box, 2);
}

/* The part of a box in the beam's region. 0 if there is none. */
MLRT_INLINE int clip_to_region(const struct mlrt_beam *beam, struct mlrt_box *box)
{
    for (int k = 0; k < 3; ++k) {
        if (beam->region.lo[k] > box->lo[k]) box->lo[k] = beam->region.lo[k];
        if (beam->region.hi[k] < box->hi[k]) box->hi[k] = beam->region.hi[k];
        if (box->lo[k] > box->hi[k]) return 0;
    }
    return 1;
}

/*
 * A covering triangle: one that every ray of the beam hits. Nothing behind it matters, so the beam's region can end
 * where it is.
 *
 * All rays are positive multiples of directions in a rectangle of slopes over the main axis. Edge functions are linear in
 * the direction, so if each has the same certain sign at the four corners, every ray is inside; and the hit points are
 * between those of the corners. In double; with u = 2^-53 the bounds are those of triangle_filter.h, 16 u M.
 */
static void end_region_at_cover(const struct mlrt_triangle *triangle, struct mlrt_beam *beam)
{
    const int a = beam->main_axis, j = (a + 1) % 3, l = (a + 2) % 3;
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
    double distance = 0, distance_size = 0;
    for (int k = 0; k < 3; ++k) {
        distance += vertex[0][k] * cross[3][k];
        distance_size += fabs(vertex[0][k]) * size[3][k];
    }
    const double distance_bound = distance_size * 0x1p-49;

    struct mlrt_box end = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    int sign = 0;
    for (int corner = 0; corner < 4; ++corner) {
        double d[3], value[4], bound[4];
        d[a] = beam->negative[a] ? -1 : 1;
        d[j] = (corner & 1 ? beam->slope_hi : beam->slope_lo)[a][j] * d[a];
        d[l] = (corner & 2 ? beam->slope_hi : beam->slope_lo)[a][l] * d[a];
        for (int i = 0; i < 4; ++i) {
            value[i] = d[0] * cross[i][0] + d[1] * cross[i][1] + d[2] * cross[i][2];
            bound[i] = (fabs(d[0]) * size[i][0] + fabs(d[1]) * size[i][1] + fabs(d[2]) * size[i][2]) * 0x1p-49;
            if (!(fabs(value[i]) > 2 * bound[i])) return;
            const int this_sign = value[i] > 0 ? 1 : -1;
            if (sign == 0) sign = this_sign;
            if (this_sign != sign) return;
        }
        if (!(sign * distance > distance_bound)) return;
        const double t = (fabs(distance) + distance_bound) / (fabs(value[3]) - bound[3]) * (1 + 0x1p-45);
        const double t_near = (fabs(distance) - distance_bound) / (fabs(value[3]) + bound[3]) * (1 - 0x1p-45);
        for (int k = 0; k < 3; ++k) {
            const double far = t * d[k], near = t_near * d[k], o = beam->origin_lo[k];
            const double slack = (fabs(o) + fabs(far)) * 0x1p-48;
            end.lo[k] = fminf(end.lo[k], mlrt_float_down(o + fmin(far, near) - slack));
            end.hi[k] = fmaxf(end.hi[k], mlrt_float_up(o + fmax(far, near) + slack));
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
