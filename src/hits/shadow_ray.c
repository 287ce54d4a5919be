/* SPDX-License-Identifier: MIT */
/*
 * Shadow rays, one at a time: see shadow_ray.h. The kernels make them a vector at a time, to the same bits
 * (shadow_packet.h).
 */
#include "hits/shadow_ray.h"

#include <math.h>

#include "exact/nearest.h"
#include "exact/offset.h"
#include "exact/quotients.h"
#include "job/structure.h"
#include "job/write_arrays.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double size_of(const double a[3])
{
    return fabs(a[0]) + fabs(a[1]) + fabs(a[2]);
}

static double greatest_of(const double a[3])
{
    return fmax(fmax(fabs(a[0]), fabs(a[1])), fabs(a[2]));
}

void mlrt_find_surface(const struct mlrt_source *light, const struct mlrt_triangle *triangle, const float origin[3],
                       struct mlrt_surface *surface)
{
    double ab[3], ac[3], p[3], to_light[3], *m = surface->m;
    for (int k = 0; k < 3; ++k) {
        const double a = triangle->v[0][k], l = light->light[k];
        ab[k] = triangle->v[1][k] - a;
        ac[k] = triangle->v[2][k] - a;
        p[k] = a - origin[k];
        to_light[k] = light->kind == MLRT_SOURCE_POINT_LIGHT ? a - l : -l;
    }
    for (int k = 0; k < 3; ++k) m[k] = ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3];
    const double greatest = greatest_of(m), scale = 1 / greatest;
    surface->is_round = greatest > MLRT_SHADOW_NORMAL * (size_of(ab) * size_of(ac));
    for (int k = 0; k < 3; ++k) m[k] = m[k] * scale;
    surface->n = dot(p, m);
    surface->reach = greatest_of(p);
    surface->height = dot(to_light, m);
    surface->height_size = size_of(to_light);
}

void mlrt_keep_surface(const struct mlrt_job *light, uint32_t number, const float eye[3],
                       struct mlrt_kept_surface *kept)
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(&light->tree->by_number, number);
    mlrt_find_surface(&light->source, &triangle, eye, &kept->surface);
    kept->light = light;
    kept->number = number;
}

/*
 * Computes the ray by the steps of shadow_ray.h. Returns 0 if its conditions do not hold; the results are then
 * invalid.
 */
static int find_end(const struct mlrt_source *light, const struct mlrt_triangle *triangle,
                    const struct mlrt_ray_segment *ray, int *faces, float end[3])
{
    struct mlrt_surface surface;
    double d[3], f[3], x[3];
    mlrt_find_surface(light, triangle, ray->origin, &surface);
    for (int k = 0; k < 3; ++k) d[k] = ray->direction[k];
    const double steepness = dot(d, surface.m), t = surface.n / steepness;
    for (int k = 0; k < 3; ++k) {
        const double o = ray->origin[k];
        f[k] = t * d[k];
        x[k] = (light->kind == MLRT_SOURCE_POINT_LIGHT ? o - light->light[k] : o) + f[k];
    }
    const double size = fmax(fmax(greatest_of(x), greatest_of(f)), MLRT_SHADOW_PLANE * surface.reach);
    const double step = steepness > 0 ? -MLRT_SHADOW_STEP * size : MLRT_SHADOW_STEP * size;
    for (int k = 0; k < 3; ++k) end[k] = (float)(x[k] + step * surface.m[k]);
    *faces = (surface.height > 0) == (steepness > 0);
    return mlrt_is_certain_surface(&surface) && fabs(steepness) > MLRT_SHADOW_GRAZING * size_of(d) &&
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
    const int is_point = job->source.kind == MLRT_SOURCE_POINT_LIGHT;
    struct mlrt_ray_segment ray, shadow;
    int faces;
    mlrt_get_segment(seen, lane, &ray);
    const struct mlrt_triangle triangle = mlrt_triangle_at(&job->tree->by_number, seen->nearest.triangle[lane]);
    const int is_ray = mlrt_make_shadow_ray(&job->source, &triangle, &ray, &faces, &shadow);
    for (int k = 0; k < 3; ++k) ends[k][lane] = !is_ray ? 0 : is_point ? shadow.direction[k] : shadow.origin[k];
    return (uint32_t)faces << lane;
}

int mlrt_is_shaded(const struct mlrt_job *job, const struct mlrt_ray_segment *ray, uint32_t number,
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
            shadows[lane] |=
                (uint8_t)(mlrt_is_shaded(&job->lights[i], &ray, packet->nearest.triangle[lane], counters) << i);
        }
    }
}
