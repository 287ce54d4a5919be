/* SPDX-License-Identifier: MIT */
/*
 * The waist of a tile's rays: where they are closest together, as far as a few of them tell. No answer depends on it.
 */
#ifndef MLRT_TRACE_WAIST_H
#define MLRT_TRACE_WAIST_H

#include <math.h>
#include <string.h>

#include "rays/extremes.h"
#include "rays/slope_limits.h"
#include "trace/bundle.h"
#include "trace/ray_tile.h"

/* The waist of a tile is guessed from at most this many of its rays. */
#define SAMPLE_LIMIT 6

struct ray_sample {
    float origin[3];
    float direction[3];
};

/* Takes a ray of a packet as a sample. Returns 0 if float does not carry it, or it comes from too far away. */
static int take_sample(const struct mlrt_packet *packet, uint32_t lane, const struct mlrt_bundle_scene *scene,
                       struct ray_sample *sample)
{
    float largest = 0;
    for (int k = 0; k < 3; ++k) {
        sample->origin[k] = (packet->has.apex ? packet->apex[k] : packet->origin[k][lane]) * scene->unit;
        sample->direction[k] = packet->direction[k][lane];
        if (!(fabsf(sample->origin[k]) <= scene->reach && fabsf(sample->direction[k]) <= GREATEST_PACE)) return 0;
        largest = larger_of(fabsf(sample->direction[k]), largest);
    }
    return largest >= LEAST_PACE;
}

/* Takes samples, from corners and middle of a tile first. Returns their number. */
static uint32_t take_samples(const struct mlrt_ray_tile *tile, uint32_t places, const struct mlrt_bundle_scene *scene,
                             struct ray_sample samples[SAMPLE_LIMIT])
{
    static const uint8_t order[MLRT_BUNDLE_PACKETS] = {5, 15, 0, 3, 12, 10, 6, 9, 1, 2, 4, 7, 8, 11, 13, 14};
    uint32_t count = 0;
    for (int i = 0; i < MLRT_BUNDLE_PACKETS && count < SAMPLE_LIMIT; ++i) {
        const struct mlrt_packet *packet = &tile->packets[order[i]];
        if (!(places >> order[i] & 1) || !packet->active) continue;
        uint32_t lane = mlrt_lowest_bit(packet->active);
        if (i & 1 && packet->active >> 15) lane = 15;
        count += (uint32_t)take_sample(packet, lane, scene, &samples[count]);
    }
    return count;
}

/* Means, variances and covariances of slopes and intercepts of samples, at the point of a waist. */
struct sample_spread {
    float slope[2];
    float intercept[2];
    float slope_slope;
    float slope_intercept;
    float intercept_intercept;
};

static void find_spread(const struct ray_sample *samples, uint32_t count, const struct mlrt_waist *from,
                        struct sample_spread *of)
{
    const int a = from->main_axis;
    float taken = 0;
    memset(of, 0, sizeof *of);
    for (uint32_t i = 0; i < count; ++i) {
        const float pace = samples[i].direction[a] * from->sign, scale = 1 / pace;
        const float depth = (samples[i].origin[a] - from->point[a]) * from->sign;
        if (!(pace > 0)) continue;
        taken += 1;
        for (int side = 0; side < 2; ++side) {
            const int j = mlrt_slope_axis(a, side);
            const float s = samples[i].direction[j] * scale, x = samples[i].origin[j] - from->point[j] - s * depth;
            of->slope[side] += s;
            of->intercept[side] += x;
            of->slope_slope += s * s;
            of->slope_intercept += s * x;
            of->intercept_intercept += x * x;
        }
    }
    const float share = 1 / taken;
    of->slope_slope *= share;
    of->slope_intercept *= share;
    of->intercept_intercept *= share;
    for (int side = 0; side < 2; ++side) {
        of->slope[side] *= share;
        of->intercept[side] *= share;
        of->slope_slope -= of->slope[side] * of->slope[side];
        of->slope_intercept -= of->slope[side] * of->intercept[side];
        of->intercept_intercept -= of->intercept[side] * of->intercept[side];
    }
}

/*
 * Chooses the waist of rays from samples: at the depth z, from the origin of the first, where x + s z has the least
 * variance, var(x) + z (2 cov(x, s) + z var(s)). That is -cov(x, s) / var(s), but no farther outside of `bounds` than
 * these are deep; for rays that are nearly parallel, it is their middle. The waist of the last tile is kept while it is
 * nearly as good, so that set-ups of leaves are shared. No factor below is critical (docs/tried.md, "Bundles"). Returns
 * 0 without samples.
 */
static MLRT_NOINLINE int choose_waist(const struct mlrt_box *bounds, const struct ray_sample *samples, uint32_t count,
                                      const struct mlrt_waist *last, struct mlrt_waist *waist)
{
    struct sample_spread of;
    if (!count) return 0;
    mlrt_face_waist(samples[0].direction, waist);
    const int a = waist->main_axis;
    memcpy(waist->point, samples[0].origin, sizeof waist->point);
    int is_apex = 1;
    for (uint32_t i = 1; i < count; ++i) {
        for (int k = 0; k < 3; ++k) is_apex &= samples[i].origin[k] == waist->point[k];
    }
    if (is_apex) return 1;
    find_spread(samples, count, waist, &of);
    const float size = bounds->hi[a] - bounds->lo[a];
    const float scene_first = waist->sign > 0 ? bounds->lo[a] - waist->point[a] : waist->point[a] - bounds->hi[a];
    const int is_beam = !(of.slope_slope * size * size > 1e-8f * size * size + 1e-5f * of.intercept_intercept);
    float depth = is_beam ? scene_first + 0.5f * size : -of.slope_intercept / of.slope_slope;
    if (!(depth > scene_first - size)) depth = scene_first - size;
    if (depth > scene_first + 2 * size) depth = scene_first + 2 * size;
    if (last->main_axis == a && last->sign == waist->sign && last->is_beam == is_beam) {
        const float last_z = (last->point[a] - waist->point[a]) * waist->sign, away = fabsf(last_z - scene_first);
        const float last_variance =
            of.intercept_intercept + last_z * (2 * of.slope_intercept + last_z * of.slope_slope);
        const float variance = of.intercept_intercept + depth * (2 * of.slope_intercept + depth * of.slope_slope);
        const float reach_squared = (away + size) * (away + size);
        const float turn_squared = (of.slope[0] - last->slope[0]) * (of.slope[0] - last->slope[0]) +
                                   (of.slope[1] - last->slope[1]) * (of.slope[1] - last->slope[1]);
        const int is_along = is_beam && turn_squared * size * size <= 0.25f * of.intercept_intercept;
        if (last_variance <= 1.5f * variance + 1e-3f * of.slope_slope * reach_squared &&
            (is_beam ? is_along : away <= 3 * size)) {
            *waist = *last;
            return 1;
        }
    }
    waist->is_beam = is_beam;
    for (int side = 0; side < 2; ++side) {
        const float slope = of.slope[side];
        waist->slope[side] = is_beam && fabsf(slope) <= STEEPEST_SLOPE ? slope : 0;
    }
    float step[3];
    step[a] = waist->sign * depth;
    for (int side = 0; side < 2; ++side) step[mlrt_slope_axis(a, side)] = of.intercept[side] + of.slope[side] * depth;
    for (int k = 0; k < 3; ++k) { /* a step that overflows is left out: the waist stays at the first sample's origin */
        if (fabsf(waist->point[k] + step[k]) <= MLRT_SAFE_MAX) waist->point[k] += step[k];
    }
    return 1;
}

/* Sets `apex` to the waist, not in units. Returns 0 if that is not exact. */
static int find_apex(const struct mlrt_bundle *bundle, float apex[3])
{
    int is_exact = 1;
    for (int k = 0; k < 3; ++k) {
        apex[k] = bundle->waist.point[k] / bundle->scene.unit;
        is_exact &= apex[k] * bundle->scene.unit == bundle->waist.point[k];
    }
    return is_exact;
}

#endif
