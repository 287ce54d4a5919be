/* SPDX-License-Identifier: MIT */
/*
 * Shadow rays: from the hits of a picture's rays to lights (mlrt.h, "Shadows of a picture").
 *
 * THE RAY is computed in double, each step rounded, for a ray o + t d that hits a triangle a b c, and a point light at
 * L (for a directional light with direction l, L = 0):
 *
 *     n = (b - a) cross (c - a)      S = |b - a| |c - a|     (|x| = |x_0| + |x_1| + |x_2|)
 *     m = n (1 / greatest |n_k|)        p = a - o               N = p . m       D = d . m       t = N / D
 *     f_k = t d_k                    x_k = (o_k - L_k) + f_k
 *     size = greatest |x_k|, |f_k|, |p_k| / 32
 *     q_k = the float nearest to x_k + step m_k, step = 2^-22 size with the sign of -D
 *     H = (a - L) . m, or -l . m     h = |a - L|, or |l|
 *
 * The light is on the ray's side if H and D have one sign. The shadow ray of a point light goes from L to L + q, that
 * of a directional light begins at q. This is valid if
 *
 *     greatest |n_k| > 2^-16 S      |D| > 2^-14 |d|      |H| > 2^-32 h      2^-100 < size < 2^100
 *
 * and otherwise the sides are found exactly, and q by offset.c.
 *
 * ITS SIDE. Let u = 2^-53, and n^ the exact normal, divided by the greatest component of n. A component of n has 4
 * factors (1 + delta), on magnitudes that sum up to S at most: it is off by 4.01 u S, and m_k by 2^16 times that and
 * two roundings, less than 2^-34. Let P be the greatest |p_k| and E the greatest |d_k|: N is off by 3.1 * 2^-34 P, and
 * D by 3.1 * 2^-34 E. So the point o + t d lies at a height
 *
 *     |n^ . (o + t d - a)| <= 3.1 * 2^-34 (P + t E) <= 3.1 * 2^-34 * 33 size < 2^-27 size.
 *
 * Rounding x_k and the sum takes 2^-49 size, and rounding to float takes 2^-24 |q_k| each, 3.01 * 2^-24 size in all.
 * The step gives 2^-22 size (1 - 2^-30), which is more than their sum. So L + q, or q, is strictly on the ray's side,
 * in exact arithmetic. The signs of D and H are right, since the conditions on them exceed their errors, which are at
 * most 2^-32 of |d| or h with all roundings.
 *
 * ITS PLACE. t is off by 3.1 * 2^-34 (P + t E) / |D|. This moves the point along the ray by less than
 * 3.1 * 2^-34 (P + t E) E / |D|: at most 2^-18 (P + t E), and far less unless the ray nearly lies in the plane.
 */
#ifndef MLRT_HITS_SHADOW_RAY_H
#define MLRT_HITS_SHADOW_RAY_H

#include <math.h>

#include "exact/vector.h"
#include "job/job.h"

/* The constants of the steps and conditions above. */
#define MLRT_SHADOW_NORMAL   0x1p-16
#define MLRT_SHADOW_GRAZING  0x1p-14
#define MLRT_SHADOW_SIDE     0x1p-32
#define MLRT_SHADOW_LEAST    0x1p-100
#define MLRT_SHADOW_GREATEST 0x1p100
#define MLRT_SHADOW_STEP     0x1p-22
#define MLRT_SHADOW_PLANE    0x1p-5

/* The terms above that depend on the triangle, the origin of the ray and the light. */
struct mlrt_surface {
    struct mlrt_vector m;
    double n;
    double greatest_p;  /* greatest |p_k| */
    double height;      /* H */
    double height_size; /* h */
    int is_thick;       /* greatest |n_k| > 2^-16 S; if not, the other terms are invalid */
};

void mlrt_find_surface(const struct mlrt_source *light, const struct mlrt_triangle *triangle, const float origin[3],
                       struct mlrt_surface *surface);

/*
 * The terms of a triangle, for the rays of a picture with one eye. A worker keeps them during a call, since
 * neighbouring packets hit the same triangles.
 */
struct mlrt_kept_surface {
    const struct mlrt_job *light; /* NULL = empty entry */
    uint32_t number;              /* of the triangle */
    struct mlrt_surface surface;
};

/* Triangle `number` has the entry number % MLRT_KEPT_SURFACES. */
#define MLRT_KEPT_SURFACES 64

/* Returns the terms of a triangle for the light of a job, from the table if they are there. */
const struct mlrt_surface *mlrt_look_up_surface(const struct mlrt_job *light, uint32_t number, const float eye[3],
                                                struct mlrt_kept_surface table[MLRT_KEPT_SURFACES]);

/* Do the conditions on n and H hold? */
static inline int mlrt_is_certain_surface(const struct mlrt_surface *surface)
{
    return surface->is_thick && fabs(surface->height) > MLRT_SHADOW_SIDE * surface->height_size;
}

/*
 * The ray from a hit to the light of a source (MLRT_SOURCE_POINT_LIGHT or _DIRECTIONAL_LIGHT), and in *faces whether
 * the light is on the ray's side. Returns 0 if no ray is needed: the light is on the other side, or where the hit is.
 */
int mlrt_make_shadow_ray(const struct mlrt_source *light, const struct mlrt_triangle *triangle,
                         const struct mlrt_ray_segment *ray, int *faces, struct mlrt_ray_segment *shadow);

/*
 * Likewise for a lane of a packet for which the conditions above do not hold. `ends` receives the direction from a
 * point light, or the origin of the ray to a directional one; without a ray, zeros. Returns the lane's bit if the light
 * is on the ray's side.
 */
uint32_t mlrt_make_shadow_lane(const struct mlrt_job *job, const struct mlrt_packet *seen, uint32_t lane,
                               float (*ends)[MLRT_PACKET_RAYS]);

/*
 * Finds the lights that do not reach the hits of a packet's lanes, one ray at a time. Bit k is light k of the job.
 * `counters` may be NULL.
 */
void mlrt_find_shadows(const struct mlrt_job *job, const struct mlrt_packet *packet, uint32_t lanes,
                       uint8_t shadows[MLRT_PACKET_RAYS], mlrt_counters *counters);

#endif
