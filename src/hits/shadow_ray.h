/* SPDX-License-Identifier: MIT */
/*
 * Rays towards lights from what a picture's rays hit (mlrt.h, "Shadows of a picture").
 *
 * THE RAY, in double, each step rounded, for a ray o + t d that hits a triangle a b c, and a point light at L (a
 * directional light with direction l: L = 0):
 *
 *     n = (b - a) cross (c - a)      S = |b - a| |c - a|     (|x| = |x_0| + |x_1| + |x_2|)
 *     m = n (1 / greatest |n_k|)        p = a - o               N = p . m       D = d . m       t = N / D
 *     f_k = t d_k                    x_k = (o_k - L_k) + f_k
 *     size = greatest |x_k|, |f_k|, |p_k| / 32
 *     q_k = the float nearest to x_k + step m_k, step = 2^-22 size with the sign of -D
 *     H = (a - L) . m, or -l . m     h = |a - L|, or |l|
 *
 * The light is on the ray's side if H and D have one sign. The ray's end is L + q, or it begins at q. That is so if
 *
 *     greatest |n_k| > 2^-16 S      |D| > 2^-14 |d|      |H| > 2^-32 h      2^-100 < size < 2^100
 *
 * and if not, sides are found exactly, and q by offset.c.
 *
 * ITS SIDE. Let u = 2^-53, and n^ the exact normal, divided by n's greatest component. A component of n has 4 factors
 * (1
 * + delta), on magnitudes that sum up to S at most: it is off by 4.01 u S, and m_k by 2^16 times that and two
 * roundings, less than 2^-34. So N and D are off by 3.1 * 2^-34 of the greatest |p_k| and |d_k|, P and E. The point o +
 * t d then lies at a height |n^ . (o + t d - a)| <= 3.1 * 2^-34 (P + t E) <= 3.1 * 2^-34 * 33 size < 2^-27 size.
 * Rounding x_k and the sum takes 2^-49 size, and that to float 2^-24 |q_k| each, 3.01 * 2^-24 size in all. The step
 * gives 2^-22 size (1 - 2^-30), which is more than all of it. So L + q, or q, is strictly on the ray's side, in exact
 * arithmetic. For D and H the bounds above are more than what they can be off by, 2^-32 of |d| or h with all roundings:
 * their signs are right.
 *
 * ITS PLACE. t is off by 3.1 * 2^-34 (P + t E) / |D|, which moves the point along the ray by less than 3.1 * 2^-34 (P +
 * t E) E / |D|: 2^-18 (P + t E) at most, and far less unless the ray nearly lies in the plane.
 */
#ifndef MLRT_HITS_SHADOW_RAY_H
#define MLRT_HITS_SHADOW_RAY_H

#include "job/job.h"

/* The conditions above. */
#define MLRT_SHADOW_NORMAL   0x1p-16
#define MLRT_SHADOW_GRAZING  0x1p-14
#define MLRT_SHADOW_SIDE     0x1p-32
#define MLRT_SHADOW_LEAST    0x1p-100
#define MLRT_SHADOW_GREATEST 0x1p100
#define MLRT_SHADOW_STEP     0x1p-22
#define MLRT_SHADOW_PLANE    0x1p-5

/* A triangle between where a ray begins and a light, in the words above. */
struct mlrt_surface {
    double m[3];
    double n;
    double reach;       /* greatest |p_k| */
    double height;      /* H */
    double height_size; /* h */
    int is_round;       /* n is more than 2^-16 S: the rest has a meaning */
};

void mlrt_find_surface(const struct mlrt_source *light, const struct mlrt_triangle *triangle, const float origin[3],
                       struct mlrt_surface *surface);

/*
 * The ray from a hit to the light of a source (MLRT_SOURCE_POINT_LIGHT or _DIRECTIONAL_LIGHT), and in *faces whether
 * the light is on the ray's side. Returns 0 if no ray is needed: the light is on the other side, or where the hit is.
 */
int mlrt_make_shadow_ray(const struct mlrt_source *light, const struct mlrt_triangle *triangle,
                         const struct mlrt_ray_segment *ray, int *faces, struct mlrt_ray_segment *shadow);

/*
 * The same for a lane of a packet: where the ray ends, or begins, goes to `ends`; one that hits nothing has a direction
 * of 0. Returns the lane's bit if the light is on its side.
 */
uint32_t mlrt_make_shadow_lane(const struct mlrt_job *job, const struct mlrt_packet *seen, uint32_t lane,
                               float (*ends)[MLRT_PACKET_RAYS]);

/*
 * Does something lie between the hit of a ray and the light? `job` is that of the light; `number` is what was hit.
 * `counters` may be NULL.
 */
int mlrt_is_shaded(const struct mlrt_job *job, const struct mlrt_ray_segment *ray, uint32_t number,
                   mlrt_counters *counters);

/* The lights that do not reach the hits of a packet's lanes, bit k for light k of the job: one ray at a time. */
void mlrt_find_shadows(const struct mlrt_job *job, const struct mlrt_packet *packet, uint32_t lanes,
                       uint8_t shadows[MLRT_PACKET_RAYS], mlrt_counters *counters);

#endif
