/* SPDX-License-Identifier: MIT */
/* What the kernels call that is compiled once: see job.h. */
#include "job/job.h"

#include <math.h>
#include <string.h>

#include "base/progress.h"
#include "exact/quotients.h"
#include "job/structure.h"
#include "job/write_arrays.h"

/* Formulas and widths are those of hits/hit_numbers.h, for one triangle and one origin. */
void mlrt_set_hit_terms(const struct mlrt_triangle *triangle, const float origin[3], struct mlrt_hit_terms *terms)
{
    const struct mlrt_vector a = mlrt_vector_at(triangle->v[0], 1), p = mlrt_subtract(a, mlrt_vector_at(origin, 1));
    const double p_error = MLRT_NUMERATOR_ERROR * mlrt_size_of(p);
    terms->corner = a;
    terms->side[0] = mlrt_subtract(mlrt_vector_at(triangle->v[2], 1), a);
    terms->side[1] = mlrt_subtract(a, mlrt_vector_at(triangle->v[1], 1));
    for (int i = 0; i < 2; ++i) terms->side_size[i] = mlrt_size_of(terms->side[i]);
    terms->normal = mlrt_cross(terms->side[0], terms->side[1]);
    terms->normal_size = terms->side_size[0] * terms->side_size[1];
    terms->n = mlrt_dot(p, terms->normal);
    terms->n_width = p_error * terms->normal_size + MLRT_DENOMINATOR_ERROR * MLRT_GREATEST_D_SIZE * fabs(terms->n);
    for (int i = 0; i < 2; ++i) {
        terms->edge[i] = mlrt_cross(terms->side[i], p);
        terms->edge_width[i] = p_error * terms->side_size[i] + MLRT_DENOMINATOR_ERROR * terms->normal_size;
    }
    memcpy(terms->origin, origin, sizeof terms->origin);
}

/* The host's function runs in the caller's floating-point environment, as it does between items. */
int mlrt_is_stopped(struct mlrt_worker *worker, double pixels)
{
    if (!worker->watch.progress || worker->watch.stopped) return worker->watch.stopped;
    worker->watch.pixels_told += pixels;
    mlrt_leave_fp_environment(&worker->watch.environment);
    const int stopped = mlrt_advance(worker->watch.progress, pixels);
    mlrt_enter_fp_environment(&worker->watch.environment);
    worker->watch.stopped = stopped;
    return stopped;
}

void mlrt_trace_single_rays(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                            mlrt_counters *counters)
{
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        struct mlrt_ray_segment ray;
        mlrt_get_segment(packet, lane, &ray);
        if (!packet->has.masks) ray.mask = job->source.common_mask;
        if (counters) ++counters->packet_count;
        packet->nearest.triangle[lane] = job->tree->structure->tracer.trace_ray(
            job->tree, &ray, packet->has.skip ? packet->skip[lane] : MLRT_NONE, job->any, NULL, counters);
    }
}

static void write_misses(struct mlrt_worker *worker, const struct mlrt_rectangle *area)
{
    for (uint32_t i = 0; i < worker->sinks.count; ++i) mlrt_write_misses(area, worker->sinks.each[i]);
}

/* The last row of a list may be short; it is written by itself. */
void mlrt_write_picture_misses(const struct mlrt_job *job, struct mlrt_worker *worker,
                               const struct mlrt_rectangle *tile)
{
    const uint64_t last = (uint64_t)(tile->y + tile->height - 1) * job->source.width + tile->x;
    struct mlrt_rectangle part = *tile;
    if (MLRT_UNLIKELY(last + tile->width > job->source.count)) {
        const struct mlrt_rectangle row = {tile->x, tile->y + tile->height - 1,
                                           last < job->source.count ? (uint32_t)(job->source.count - last) : 0, 1};
        write_misses(worker, &row);
        --part.height;
    }
    write_misses(worker, &part);
}

void mlrt_write_picture_shadow(const struct mlrt_worker *worker, uint8_t shadow, const struct mlrt_rectangle *tile)
{
    for (uint32_t i = 0; i < worker->sinks.count; ++i) mlrt_write_same_shadow(shadow, tile, worker->sinks.each[i]);
}

void mlrt_write_packet_shadows(const struct mlrt_worker *worker, const uint8_t shadows[MLRT_PACKET_RAYS],
                               uint32_t lanes, const struct mlrt_rectangle *block)
{
    for (uint32_t i = 0; i < worker->sinks.count; ++i) mlrt_write_shadows(shadows, lanes, block, worker->sinks.each[i]);
}
