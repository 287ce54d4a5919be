/* SPDX-License-Identifier: MIT */
/*
 * The shadow rays of a packet's hits, a vector of doubles at a time: the steps of shadow_ray.h, to the same bits. If
 * its conditions do not hold for a lane, shadow_ray.c makes the ray.
 */
#ifndef MLRT_HITS_SHADOW_PACKET_H
#define MLRT_HITS_SHADOW_PACKET_H

#include <math.h>
#include <string.h>

#include "hits/hit_numbers.h"
#include "hits/outcome.h"
#include "hits/shadow_ray.h"
#include "rays/fetch_block.h"
#include "simd/doubles.h"
#include "simd/simd.h"

/* For a vector of rays: the terms of shadow_ray.h that depend on triangle, origin and light, not on the direction. */
struct shadow_terms {
    vd m[3];
    vd n;             /* p . m */
    vd from[3];       /* from the light to the origin */
    vd plane_size;    /* the greatest |p_k| / 32 */
    vd height;        /* H */
    uint32_t certain; /* lanes where the conditions on n and H hold */
};

MLRT_INLINE vd greatest_of_doubles(const vd a[3])
{
    return d_max(d_max(d_abs(a[0]), d_abs(a[1])), d_abs(a[2]));
}

/*
 * Computes the terms of DW lanes, whose triangles have these corners (mlrt_gather_corners). With a directional light, L
 * is 0 for `from`, and the vector from the light is -l.
 */
static MLRT_NOINLINE void set_up_shadow_terms(const struct mlrt_packet *seen, float (*corners)[MLRT_PACKET_RAYS],
                                              uint32_t lane, const struct mlrt_source *light,
                                              struct shadow_terms *terms)
{
    const vd is_point = d_set1(light->kind == MLRT_SOURCE_POINT_LIGHT);
    vd ab[3], ac[3], p[3], from_light[3];
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const vd corner = d_load(corners[k] + lane), origin = origins_in_double(seen, k, lane);
        const vd l = d_set1(light->light[k]);
        ab[k] = d_sub(d_load(corners[3 + k] + lane), corner);
        ac[k] = d_sub(d_load(corners[6 + k] + lane), corner);
        p[k] = d_sub(corner, origin);
        terms->from[k] = d_sub(origin, d_mul(is_point, l));
        from_light[k] = d_sub(d_mul(is_point, corner), l);
    }
    cross_product_of_doubles(ab, ac, terms->m);
    const vd greatest = greatest_of_doubles(terms->m), size = d_mul(size_of_doubles(ab), size_of_doubles(ac));
    const vd scale = d_div(d_set1(1), greatest);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) terms->m[k] = d_mul(terms->m[k], scale);
    terms->n = dot_product_of_doubles(p, terms->m);
    terms->plane_size = d_mul(d_set1(MLRT_SHADOW_PLANE), greatest_of_doubles(p));
    terms->height = dot_product_of_doubles(from_light, terms->m);
    terms->certain = d_gt(greatest, d_mul(d_set1(MLRT_SHADOW_NORMAL), size)) &
                     d_gt(d_abs(terms->height), d_mul(d_set1(MLRT_SHADOW_SIDE), size_of_doubles(from_light)));
}

/*
 * Computes q of DW lanes: the directions of rays from a point light, or the origins of rays to a directional one.
 * Returns the lanes where the conditions of shadow_ray.h hold; *facing receives those that have the light on the ray's
 * side.
 */
MLRT_INLINE uint32_t make_shadow_vector(const struct shadow_terms *terms, const struct mlrt_packet *seen, uint32_t lane,
                                        uint32_t *facing, float (*ends)[MLRT_PACKET_RAYS])
{
    vd d[3], f[3], x[3];
    load_directions(seen, lane, d);
    const vd steepness = dot_product_of_doubles(d, terms->m), t = d_div(terms->n, steepness);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        f[k] = d_mul(t, d[k]);
        x[k] = d_add(terms->from[k], f[k]);
    }
    const vd size = d_max(d_max(greatest_of_doubles(x), greatest_of_doubles(f)), terms->plane_size);
    const vd step = d_flip(d_mul(d_set1(-MLRT_SHADOW_STEP), size), steepness);
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) d_store(ends[k] + lane, d_add(x[k], d_mul(step, terms->m[k])));
    *facing = d_gt(d_flip(terms->height, steepness), d_set1(0));
    return terms->certain & d_gt(d_abs(steepness), d_mul(d_set1(MLRT_SHADOW_GRAZING), size_of_doubles(d))) &
           d_gt(size, d_set1(MLRT_SHADOW_LEAST)) & d_gt(d_set1(MLRT_SHADOW_GREATEST), size);
}

/* Sets the terms of all lanes of a packet from one eye that hits one triangle. */
MLRT_INLINE void spread_surface(const struct mlrt_surface *surface, const float eye[3], const struct mlrt_source *light,
                                struct shadow_terms *terms)
{
    const int is_point = light->kind == MLRT_SOURCE_POINT_LIGHT;
    for (int k = 0; k < 3; ++k) terms->from[k] = d_set1((double)eye[k] - (is_point ? (double)light->light[k] : 0));
    spread_vector(surface->m, terms->m);
    terms->n = d_set1(surface->n);
    terms->plane_size = d_set1(MLRT_SHADOW_PLANE * surface->greatest_p);
    terms->height = d_set1(surface->height);
    terms->certain = mlrt_is_certain_surface(surface) ? (1u << DW) - 1 : 0;
}

/*
 * Makes the shadow rays of the lanes `hit` of packet `seen` to the light of a job. `kept` is a table of surfaces.
 * Returns the lanes where the light is on the other side of the surface: they get no ray.
 */
static MLRT_NOINLINE uint32_t make_shadow_packet(const struct mlrt_job *job, const struct mlrt_packet *seen,
                                                 uint32_t hit, struct mlrt_kept_surface *kept,
                                                 struct mlrt_packet *packet)
{
    const struct mlrt_source *light = &job->source;
    const int is_point = light->kind == MLRT_SOURCE_POINT_LIGHT;
    float(*ends)[MLRT_PACKET_RAYS] = is_point ? packet->direction : packet->origin;
    float(*others)[MLRT_PACKET_RAYS] = is_point ? packet->origin : packet->direction;
    MLRT_ALIGNED(64) float corners[9][MLRT_PACKET_RAYS];
    struct shadow_terms terms;
    const uint32_t number = seen->nearest.triangle[mlrt_lowest_bit(hit)];
    const int is_kept = seen->has.apex && !(hit & ~lanes_of_triangle(seen, number));
    uint32_t certain = 0, facing = 0;
    if (is_kept) {
        spread_surface(mlrt_look_up_surface(job, number, seen->apex, kept), seen->apex, light, &terms);
    } else {
        mlrt_gather_corners(job->tree, seen, hit, corners);
    }
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        uint32_t vector_facing;
        if (!is_kept) set_up_shadow_terms(seen, corners, lane, light, &terms);
        certain |= make_shadow_vector(&terms, seen, lane, &vector_facing, ends) << lane;
        facing |= vector_facing << lane;
    }
    facing &= certain;
    for (uint32_t left = hit & ~certain; left; left &= left - 1)
        facing |= mlrt_make_shadow_lane(job, seen, mlrt_lowest_bit(left), ends);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        for (int k = 0; k < 3; ++k) v_store(others[k] + v, v_set1(light->light[k]));
        v_store(packet->t_min + v, v_set1(0));
        v_store(packet->t_max + v, v_set1(is_point ? 1 : INFINITY));
        i_store(packet->skip + v, i_load(seen->nearest.triangle + v));
    }
    memcpy(packet->apex, light->light, sizeof packet->apex);
    packet->has.apex = is_point;
    packet->has.limits = packet->has.masks = packet->has.skip = 0;
    check_block(light, hit & facing, packet);
    packet->has.skip = 1;
    return hit & ~facing;
}

#endif
