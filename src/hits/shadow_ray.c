/* SPDX-License-Identifier: MIT */
/*
 * Shadow rays, one at a time: see shadow_ray.h. The kernels make them a vector at a time, to the same bits
 * (shadow_packet.h).
 */
#include "hits/shadow_ray.h"

#include <math.h>

#include "exact/determinants.h"
#include "exact/predicate.h"
#include "exact/offset.h"
#include "exact/quotients.h"
#include "job/structure.h"
#include "job/read_lanes.h"

static double greatest_of(struct mlrt_vector a)
{
    return fmax(fmax(fabs(a.x), fabs(a.y)), fabs(a.z));
}

void mlrt_find_surface(const struct mlrt_source *light, const struct mlrt_triangle *triangle, const float origin[3],
                       struct mlrt_surface *surface)
{
    const struct mlrt_operands of = mlrt_load_operands(origin, triangle->v[0], triangle->v[0], 1); /* no direction */
    const struct mlrt_vector n = mlrt_cross(of.ab, of.ac), a = mlrt_vector_at(triangle->v[0], 1), zero = {0, 0, 0};
    const struct mlrt_vector from_light =
        mlrt_subtract(light->kind == MLRT_SOURCE_POINT_LIGHT ? a : zero, mlrt_vector_at(light->light, 1));
    const double greatest = greatest_of(n), scale = 1 / greatest;
    surface->is_thick = greatest > MLRT_SHADOW_NORMAL * (of.ab_size * of.ac_size);
    surface->m = mlrt_scale(n, scale);
    surface->n = mlrt_dot(of.to_a, surface->m);
    surface->greatest_p = greatest_of(of.to_a);
    surface->height = mlrt_dot(from_light, surface->m);
    surface->height_size = mlrt_size_of(from_light);
}

const struct mlrt_surface *mlrt_look_up_surface(const struct mlrt_job *light, uint32_t number, const float eye[3],
                                                struct mlrt_kept_surface table[MLRT_KEPT_SURFACES])
{
    struct mlrt_kept_surface *kept = &table[number % MLRT_KEPT_SURFACES];
    if (kept->light == light && kept->number == number) return &kept->surface;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&light->tree->by_number, number);
    mlrt_find_surface(&light->source, &triangle, eye, &kept->surface);
    kept->light = light;
    kept->number = number;
    return &kept->surface;
}

/* Computes the ray by the steps of shadow_ray.h. Returns 0 if its conditions do not hold: the results are invalid. */
static int find_end(const struct mlrt_source *light, const struct mlrt_triangle *triangle,
                    const struct mlrt_ray_segment *ray, int *faces, float end[3])
{
    struct mlrt_surface surface;
    mlrt_find_surface(light, triangle, ray->origin, &surface);
    const struct mlrt_vector o = mlrt_vector_at(ray->origin, 1), d = mlrt_vector_at(ray->direction, 1);
    const double steepness = mlrt_dot(d, surface.m), t = surface.n / steepness;
    const struct mlrt_vector from =
        light->kind == MLRT_SOURCE_POINT_LIGHT ? mlrt_subtract(o, mlrt_vector_at(light->light, 1)) : o;
    const struct mlrt_vector f = mlrt_scale(d, t), x = mlrt_add(from, f);
    const double size = fmax(fmax(greatest_of(x), greatest_of(f)), MLRT_SHADOW_PLANE * surface.greatest_p);
    const double step = steepness > 0 ? -MLRT_SHADOW_STEP * size : MLRT_SHADOW_STEP * size;
    const struct mlrt_vector q = mlrt_add(x, mlrt_scale(surface.m, step));
    end[0] = (float)q.x, end[1] = (float)q.y, end[2] = (float)q.z;
    *faces = (surface.height > 0) == (steepness > 0);
    return mlrt_is_certain_surface(&surface) && fabs(steepness) > MLRT_SHADOW_GRAZING * mlrt_size_of(d) &&
           size > MLRT_SHADOW_LEAST && size < MLRT_SHADOW_GREATEST;
}

/*
 * Likewise for any numbers, with exact sides. If there is no float point on the ray's side, the light counts as being
 * on the other side.
 */
static MLRT_NOINLINE void find_end_exactly(const struct mlrt_source *light, const struct mlrt_triangle *triangle,
                                           const struct mlrt_ray_segment *ray, int *faces, float end[3])
{
    mlrt_hit hit;
    const int side = -mlrt_facing(triangle, ray->direction);
    const int is_point = light->kind == MLRT_SOURCE_POINT_LIGHT;
    *faces = 0;
    if ((is_point ? mlrt_side_of_plane(triangle, light->light) : mlrt_facing(triangle, light->light)) != side) return;
    mlrt_report_hit(ray, triangle, MLRT_OUTPUT_UV, &hit);
    *faces = mlrt_find_offset_point(triangle, hit.u, hit.v, side, is_point ? light->light : NULL, end);
}

int mlrt_make_shadow_ray(const struct mlrt_source *light, const struct mlrt_triangle *triangle,
                         const struct mlrt_ray_segment *ray, int *faces, struct mlrt_ray_segment *shadow)
{
    float end[3];
    if (!find_end(light, triangle, ray, faces, end)) find_end_exactly(light, triangle, ray, faces, end);
    if (!*faces) return 0;
    return light->kind == MLRT_SOURCE_POINT_LIGHT ? mlrt_make_segment(light->light, end, 0, 1, shadow)
                                                  : mlrt_make_segment(end, light->light, 0, INFINITY, shadow);
}

uint32_t mlrt_make_shadow_lane(const struct mlrt_job *job, const struct mlrt_packet *seen, uint32_t lane,
                               float (*ends)[MLRT_PACKET_RAYS])
{
    struct mlrt_ray_segment ray;
    float end[3];
    int faces;
    mlrt_get_segment(seen, lane, &ray);
    const struct mlrt_triangle triangle = mlrt_triangle_at(&job->tree->by_number, seen->nearest.triangle[lane]);
    find_end_exactly(&job->source, &triangle, &ray, &faces, end);
    for (int k = 0; k < 3; ++k) ends[k][lane] = faces ? end[k] : 0;
    return (uint32_t)faces << lane;
}

/*
 * Is the hit of a ray on triangle `number` in the shadow of the light of `job`: behind the surface, or with a triangle
 * between?
 */
static int is_shaded(const struct mlrt_job *job, const struct mlrt_ray_segment *ray, uint32_t number,
                     mlrt_counters *counters)
{
    struct mlrt_ray_segment shadow;
    int faces;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&job->tree->by_number, number);
    if (!mlrt_make_shadow_ray(&job->source, &triangle, ray, &faces, &shadow)) return !faces;
    shadow.mask = job->source.common_mask;
    if (counters) ++counters->ray_count, ++counters->packet_count;
    return job->tree->structure->tracer.trace_ray(job->tree, &shadow, number, 1, NULL, counters) != MLRT_NONE;
}

void mlrt_find_shadows(const struct mlrt_job *job, const struct mlrt_packet *packet, uint32_t lanes,
                       uint8_t shadows[MLRT_PACKET_RAYS], mlrt_counters *counters)
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        struct mlrt_ray_segment ray;
        shadows[lane] = 0;
        if (!(lanes >> lane & 1) || packet->nearest.triangle[lane] == MLRT_NONE) continue;
        mlrt_get_segment(packet, lane, &ray);
        for (uint32_t i = 0; i < job->light_count; ++i) {
            shadows[lane] |= (uint8_t)(is_shaded(&job->lights[i], &ray, packet->nearest.triangle[lane], counters) << i);
        }
    }
}
