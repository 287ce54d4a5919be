/* SPDX-License-Identifier: MIT */
/*
 * Rays in the units of boxes. Rays that go alone or lane by lane are copied into another packet and scaled there if the
 * unit of the boxes (bvh/unit.h) is not 1, or if their directions are unusually large or small. Each direction is also
 * multiplied by a power of two that brings its greatest component to 1 .. 2, and t by the power that follows from both.
 * A lane that the filters leave undecided is decided with the ray as it was given.
 */
#ifndef MLRT_TRACE_UNITS_H
#define MLRT_TRACE_UNITS_H

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/counters.h"
#include "bvh/unit.h"
#include "exact/ray_interval.h"
#include "exact/rounding.h"
#include "hits/close_calls.h"
#include "hits/undecided.h"
#include "rays/check_packet.h"
#include "rays/lone_ray.h"
#include "rays/ray_powers.h"
#include "simd/simd.h"

/* Finds the powers of two of each lane. Returns those of `lanes` where the powers and their reciprocals are normal. */
static uint32_t find_powers(const struct mlrt_packet *packet, uint32_t lanes, float unit,
                            struct mlrt_ray_scales *scales)
{
    uint32_t found = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf x = v_abs(v_load(packet->direction[0] + v)), y = v_abs(v_load(packet->direction[1] + v));
        v_store(scales->direction + v, v_max(v_max(x, y), v_abs(v_load(packet->direction[2] + v))));
    }
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        scales->direction[lane] = mlrt_power_within(scales->direction[lane]);
    }
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf one = v_set1(1), lo = v_set1(MLRT_LEAST_RAY_POWER), hi = v_set1(1 / MLRT_LEAST_RAY_POWER);
        vf power = v_load(scales->direction + v), time = v_mul(power, v_set1(unit));
        const vm normal = m_and(m_and(v_ge(power, lo), v_le(power, hi)), m_and(v_ge(time, lo), v_le(time, hi)));
        power = v_select(normal, power, one);
        time = v_select(normal, time, one);
        v_store(scales->direction + v, v_div(one, power));
        v_store(scales->time + v, time);
        v_store(scales->inverse_time + v, v_div(one, time));
        found |= m_bits(normal) << v;
    }
    return found & lanes;
}

/*
 * Finds the scales that bring the rays of a packet into units. Returns those of `lanes` that float carries there: their
 * origins are within reach (scene/reach.h) and are scaled without rounding.
 */
static MLRT_NOINLINE uint32_t find_ray_scales(const struct mlrt_packet *packet, uint32_t lanes, float unit, float reach,
                                              struct mlrt_ray_scales *scales)
{
    const vf scale = v_set1(unit), inverse = v_set1(1 / unit), zero = v_set1(0);
    uint32_t carried = find_powers(packet, lanes, unit, scales);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf t_min = v_mul(v_load(packet->t_min + v), v_load(scales->time + v));
        vm fits = v_le(t_min, v_set1(MLRT_BVH_FAR));
        for (int k = 0; k < 3; ++k) {
            const vf given = packet->has.apex ? v_set1(packet->apex[k]) : v_load(packet->origin[k] + v);
            const vf origin = v_mul(given, scale), d = v_load(packet->direction[k] + v);
            fits = m_and(fits, m_and(v_le(v_abs(origin), v_set1(reach)), v_eq(v_mul(origin, inverse), given)));
            const vf size = v_abs(v_mul(d, v_load(scales->direction + v)));
            fits = m_and(fits, m_or(v_eq(d, zero), v_ge(size, v_set1(MLRT_SAFE_MIN))));
        }
        carried &= ~((~m_bits(fits) & ALL_LANES) << v);
    }
    return carried;
}

/*
 * Sorts the rays of `lanes` that can hit something by rule R1 (segment.h): those that float carries in units become
 * active, the others in_double.
 */
static MLRT_NOINLINE void check_packet_in_units(uint32_t lanes, float unit, float reach, struct mlrt_packet *packet)
{
    struct mlrt_ray_scales scales;
    check_packet(lanes, packet);
    const uint32_t valid = packet->active | packet->in_double;
    packet->active = find_ray_scales(packet, valid, unit, reach, &scales);
    packet->in_double = valid & ~packet->active;
}

/* Copies the nearest hit of a lane to another packet, in which t is `times` as large. */
static void copy_nearest(const struct mlrt_packet *from, uint32_t lane, double times, struct mlrt_packet *to)
{
    to->nearest.triangle[lane] = from->nearest.triangle[lane];
    to->nearest.lo[lane] = mlrt_float_down(from->nearest.lo[lane] * times);
    to->nearest.hi[lane] = mlrt_float_up(from->nearest.hi[lane] * times);
}

/* Copies a packet into `scaled`, in units. Returns those of `lanes` that float carries there. */
static MLRT_NOINLINE uint32_t scale_packet(uint32_t lanes, float unit, float reach, struct mlrt_packet *packet,
                                           struct mlrt_scaled_packet *scaled)
{
    const uint32_t carried = find_ray_scales(packet, lanes, unit, reach, &scaled->scales);
    struct mlrt_packet *rays = &scaled->rays;
    *rays = *packet;
    scaled->given = packet;
    for (int k = 0; k < 3 && packet->has.apex; ++k) rays->apex[k] = packet->apex[k] * unit;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf time = v_load(scaled->scales.time + v), spare = v_set1(MLRT_TIME_SPARE);
        for (int k = 0; k < 3; ++k) {
            v_store(rays->direction[k] + v,
                    v_mul(v_load(packet->direction[k] + v), v_load(scaled->scales.direction + v)));
            if (!packet->has.apex) v_store(rays->origin[k] + v, v_mul(v_load(packet->origin[k] + v), v_set1(unit)));
        }
        v_store(rays->t_min + v, v_max(v_sub(v_mul(v_load(packet->t_min + v), time), spare), v_set1(0)));
        v_store(rays->nearest.lo + v, v_mul(v_load(packet->nearest.lo + v), time));
        v_store(rays->nearest.hi + v, v_add(v_mul(v_load(packet->nearest.hi + v), time), spare));
    }
    return carried;
}

/*
 * Copies the hits that `lanes` found in units to the packet as given. A lane whose triangle is the same in both keeps
 * the bounds that were given.
 */
static MLRT_NOINLINE void take_scaled_hits(const struct mlrt_scaled_packet *scaled, uint32_t lanes)
{
    const struct mlrt_packet *from = &scaled->rays;
    struct mlrt_packet *to = scaled->given;
    uint32_t rounded = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vi number = i_load(from->nearest.triangle + v), given = i_load(to->nearest.triangle + v);
        const vm changed = m_andnot(m_from_bits(lanes >> v & ALL_LANES), i_eq(number, given));
        const vf times = v_load(scaled->scales.inverse_time + v);
        const vf lo = v_mul(v_load(from->nearest.lo + v), times), hi = v_mul(v_load(from->nearest.hi + v), times);
        const vm exact = m_and(changed, m_and(v_gt(lo, v_set1(FLT_MIN)), v_le(hi, v_set1(FLT_MAX))));
        i_store(to->nearest.triangle + v, i_select(exact, number, given));
        v_store(to->nearest.lo + v, v_select(exact, lo, v_load(to->nearest.lo + v)));
        v_store(to->nearest.hi + v, v_select(exact, hi, v_load(to->nearest.hi + v)));
        rounded |= m_bits(m_andnot(changed, exact)) << v;
    }
    for (; MLRT_UNLIKELY(rounded); rounded &= rounded - 1) {
        const uint32_t lane = mlrt_lowest_bit(rounded);
        copy_nearest(from, lane, scaled->scales.inverse_time[lane], to);
    }
}

/* Copies the nearest hits of `lanes` back to the scaled packet after a decision, which changed those of `nearer`. */
static void reload_nearest(struct mlrt_scaled_packet *scaled, uint32_t lanes, uint32_t nearer)
{
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        scaled->rays.nearest.triangle[lane] = scaled->given->nearest.triangle[lane]; /* a tie may have changed it */
        if (nearer >> lane & 1) copy_nearest(scaled->given, lane, scaled->scales.time[lane], &scaled->rays);
    }
}

/* As decide_lanes (close_calls.h), for a packet that may be in units. */
static MLRT_NOINLINE uint32_t decide_scaled_lanes(const struct mlrt_job *job, uint32_t number, uint32_t lanes,
                                                  uint32_t inside, struct mlrt_packet *packet,
                                                  struct mlrt_worker *worker)
{
    struct mlrt_scaled_packet *scaled = worker->scaled;
    if (MLRT_LIKELY(!scaled)) return decide_lanes(job->tree, number, lanes, inside, packet, worker, COUNTERS(worker));
    take_scaled_hits(scaled, lanes);
    const uint32_t nearer = decide_lanes(job->tree, number, lanes, inside, scaled->given, worker, COUNTERS(worker));
    reload_nearest(scaled, lanes, nearer);
    return nearer;
}

/*
 * Does a ray as given surely miss the box of a triangle? Leaves with odd triangles have boxes without bounds, so such a
 * triangle is tested with every ray that comes to its leaf.
 */
static int surely_misses_box(const struct mlrt_packet *packet, uint32_t lane, const struct mlrt_triangle *triangle)
{
    double enter = packet->t_min[lane], exit = packet->nearest.hi[lane];
    for (int k = 0; k < 3; ++k) {
        const double a = triangle->v[0][k], b = triangle->v[1][k], c = triangle->v[2][k];
        const double lo = fmin(fmin(a, b), c), hi = fmax(fmax(a, b), c), d = packet->direction[k][lane];
        const double o = packet->has.apex ? packet->apex[k] : packet->origin[k][lane];
        if (d == 0) {
            if (o < lo || o > hi) return 1;
            continue;
        }
        enter = fmax(mlrt_plane_distance(d < 0 ? hi : lo, o, 1 / d).enter, enter);
        exit = fmin(mlrt_plane_distance(d < 0 ? lo : hi, o, 1 / d).exit, exit);
    }
    return enter > exit;
}

/*
 * Decides whether one ray hits the triangles numbers[i], for each bit i of `undecided`; it surely passes inside the
 * edges of those in `inside`. Returns 1 if one of them became a nearer hit. With a query for any hit, the first hit
 * ends it. The float filter leaves all odd triangles undecided.
 */
static int decide_triangles(const struct mlrt_job *job, const uint32_t *numbers, uint32_t undecided, uint32_t inside,
                            uint32_t lane, struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    uint32_t hit = 0;
    for (; undecided && !(hit && job->any); undecided &= undecided - 1) {
        const uint32_t place = mlrt_lowest_bit(undecided), number = numbers[place];
        if (MLRT_UNLIKELY(!job->tree->bvh.is_usual) && mlrt_is_odd(job->tree, number)) {
            const struct mlrt_triangle triangle = mlrt_triangle_at(&job->tree->by_number, number);
            if (surely_misses_box(packet, lane, &triangle)) continue;
        }
        hit |= mlrt_decide_lanes(job->tree, number, 1u << lane, (inside >> place & 1) << lane, packet, worker,
                                 COUNTERS(worker));
    }
    return hit != 0;
}

/* Sets lane 0 of a packet, before its search. */
static void fill_lane(const float origin[3], const float direction[3], const struct mlrt_lone_ray *ray,
                      struct mlrt_packet *packet)
{
    for (int k = 0; k < 3; ++k) {
        packet->origin[k][0] = origin[k];
        packet->direction[k][0] = direction[k];
    }
    packet->t_max[0] = ray->t_max;
    packet->has.apex = 0;
}

/*
 * Fills in what begin_lone_search (lone_ray.h) left out of packet and worker: what only the decisions below need. From
 * then on the ray is lane 0 of the packet, no longer worker->lone.
 */
static void fill_lone_packet(struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const struct mlrt_lone_ray *ray = worker->lone;
    fill_lane(ray->origin, ray->direction, ray, packet);
    if (worker->scaled) {
        struct mlrt_packet *given = worker->scaled->given;
        fill_lane(ray->given.origin, ray->given.direction, ray, given);
        given->t_min[0] = ray->t_min;
        given->nearest.lo[0] = given->nearest.hi[0] = ray->t_max;
        given->nearest.triangle[0] = MLRT_NONE;
        given->skip[0] = packet->skip[0];
        given->has.skip = packet->has.skip;
        given->has.masks = 0;
        worker->scaled->scales.time[0] = ray->units.powers.time;
        worker->scaled->scales.inverse_time[0] = 1 / ray->units.powers.time;
    }
    worker->known.plane_mask = 0;
    worker->known.planes->number = MLRT_NONE;
    worker->watch.progress = NULL;
    worker->lone = NULL;
}

/* As decide_triangles, for a packet that may be in units. */
static MLRT_NOINLINE int decide_scaled_triangles(const struct mlrt_job *job, const uint32_t *numbers,
                                                 uint32_t undecided, uint32_t inside, uint32_t lane,
                                                 struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    struct mlrt_scaled_packet *scaled = worker->scaled;
    if (worker->lone) fill_lone_packet(packet, worker);
    if (MLRT_LIKELY(!scaled)) return decide_triangles(job, numbers, undecided, inside, lane, packet, worker);
    take_scaled_hits(scaled, 1u << lane);
    const int changed = decide_triangles(job, numbers, undecided, inside, lane, scaled->given, worker);
    reload_nearest(scaled, 1u << lane, (uint32_t)changed << lane);
    return changed;
}

#endif
