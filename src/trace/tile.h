/* SPDX-License-Identifier: MIT */
/*
 * Traces the packets of a tile, wherever their rays start, in one of two ways. Packets that are alike become a bundle,
 * by their hulls (ray_hulls.h), and go down the hierarchy together (traverse_bundle.h). Packets that are too wide for
 * that are traced lane by lane (lane_by_lane.h). The ways in are trace_bundle, for packets that have rays, and
 * trace_cells, for bundles without; both go through trace_going_packets.
 */
#ifndef MLRT_TRACE_TILE_H
#define MLRT_TRACE_TILE_H

#include <math.h>
#include <string.h>

#include "base/progress.h"
#include "rays/check_packet.h"
#include "simd/simd.h"
#include "simd/sixteen.h"
#include "trace/bundle.h"
#include "trace/cover.h"
#include "trace/lane_by_lane.h"
#include "trace/ray_hulls.h"
#include "trace/traverse_bundle.h"
#include "trace/units.h"
#include "trace/waist.h"

/* Sets the depths between which a box lies. */
static void find_depths(const struct mlrt_box *box, const struct mlrt_waist *waist, float *first, float *last)
{
    const float below = box->lo[waist->main_axis] - waist->point[waist->main_axis];
    const float above = box->hi[waist->main_axis] - waist->point[waist->main_axis];
    *first = waist->sign > 0 ? below : -above;
    *last = waist->sign > 0 ? above : -below;
}

/* Sets the depths of the scene, and of most triangles. */
static void set_scene_depths(const struct mlrt_bvh *bvh, struct mlrt_bundle *bundle)
{
    find_depths(&bvh->whole, &bundle->waist, &bundle->scene.first, &bundle->scene.last);
    find_depths(&bvh->core, &bundle->waist, &bundle->scene.core_first, &bundle->scene.core_last);
}

/* Returns the packets of a bundle that are far wider than the narrow ones. */
static MLRT_NOINLINE uint32_t find_wide_packets(const struct mlrt_bundle *bundle)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    MLRT_ALIGNED(64) float widths[MLRT_BUNDLE_PACKETS];
    vf least = v_set1(INFINITY), greatest = v_set1(0);
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        const vm going = m_from_bits(bundle->state.going >> v);
        const vf first = v_max(v_load(hulls->first + v), v_set1(bundle->scene.core_first));
        const vf last = v_min(v_load(hulls->last + v), v_set1(bundle->scene.core_last));
        const vf depth = v_max(v_abs(first), v_abs(last));
        vf width = v_set1(0);
        for (int i = 0; i < 2; ++i) {
            width = v_mul_add(v_load(hulls->filter.radius[i] + v), depth, width);
            if (bundle->has.intercepts) width = v_add(v_load(hulls->filter.radius[MLRT_INTERCEPT_J + i] + v), width);
        }
        v_store(widths + v, width);
        least = v_min(v_select(going, width, v_set1(INFINITY)), least);
        greatest = v_max(v_select(going, width, v_set1(0)), greatest);
    }
    if (MLRT_LIKELY(v_hmax(greatest) <= MLRT_WIDE_FACTOR * v_hmin(least))) return 0;
    float sorted[MLRT_BUNDLE_PACKETS];
    uint32_t count = 0, wide = 0;
    for (uint32_t left = bundle->state.going; left; left &= left - 1) {
        const float width = widths[mlrt_lowest_bit(left)];
        uint32_t at = count++;
        for (; at > 0 && sorted[at - 1] > width; --at) sorted[at] = sorted[at - 1];
        sorted[at] = width;
    }
    const float limit = MLRT_WIDE_FACTOR * sorted[count / 4];
    for (uint32_t left = bundle->state.going; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        if (!(widths[place] <= limit)) wide |= 1u << place;
    }
    return count > 1 ? wide : 0;
}

/*
 * Are the rays of a bundle closer together where they end than where they begin? Where any hit will do, the search
 * starts at their ends then, since one triangle is likelier to hide all rays where they are close. It also does if
 * they are equally close everywhere: rays mostly begin on surfaces and end in the open.
 */
static int ends_closer(const struct mlrt_bundle *bundle)
{
    const struct mlrt_hull *whole = &bundle->whole;
    const float first = whole->first > bundle->scene.core_first ? whole->first : bundle->scene.core_first;
    const float last = whole->last < bundle->scene.core_last ? whole->last : bundle->scene.core_last;
    float spread = 0, width = 0;
    for (int i = 0; i < 2; ++i) {
        spread += whole->hi[MLRT_SLOPE_J + i] - whole->lo[MLRT_SLOPE_J + i];
        width += whole->hi[MLRT_INTERCEPT_J + i] - whole->lo[MLRT_INTERCEPT_J + i];
    }
    return spread * (last - first) < width || fabsf(last) < fabsf(first);
}

/* Checks the rays of a packet that is not traced with a bundle: rule R1, and which rays float can carry. */
static MLRT_NOINLINE void check_packet_outside(const struct mlrt_bundle_scene *scene, struct mlrt_packet *packet)
{
    const uint32_t lanes = packet->active | packet->in_double;
    if (MLRT_LIKELY(scene->unit == 1)) {
        check_packet(lanes, packet);
        set_far_rays_aside(scene->reach, packet);
    } else {
        check_packet_in_units(lanes, scene->unit, scene->reach, packet);
    }
}

/* Checks packets that are not traced with a bundle. Returns those that have active rays. */
static uint32_t check_packets_outside(const struct mlrt_bundle *bundle, uint32_t places)
{
    uint32_t some = 0;
    for (uint32_t left = places; left; left &= left - 1) {
        struct mlrt_packet *packet = &bundle->tile->packets[mlrt_lowest_bit(left)];
        check_packet_outside(&bundle->scene, packet);
        some |= packet->active ? left & (0u - left) : 0;
    }
    return some;
}

/* Adds to the cells of a bundle the packets whose rays float carries. Returns the others that have active rays. */
static uint32_t add_packets(struct mlrt_bundle *bundle, uint32_t places)
{
    const uint32_t cells = bundle->state.going;
    uint32_t odd = 0, others = 0;
    for (uint32_t left = ~(places | cells) & 0xFFFF; left; left &= left - 1)
        leave_bundle(bundle, mlrt_lowest_bit(left));
    for (uint32_t left = places; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left), fit = bound_rays(bundle, place);
        odd |= (uint32_t)((bundle->tile->packets[place].active & ~fit) != 0) << place;
    }
    bundle->state.going = cells | hulls_fit(bundle, places & ~odd);
    for (uint32_t left = places & ~bundle->state.going; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left), bit = left & (0u - left);
        struct mlrt_packet *packet = &bundle->tile->packets[place];
        check_packet_outside(&bundle->scene, packet);
        const int fits = packet->active && !(packet->active & ~bound_rays(bundle, place));
        if (fits && hulls_fit(bundle, bit)) {
            bundle->state.going |= bit;
        } else {
            leave_bundle(bundle, place);
            others |= packet->active ? bit : 0;
        }
    }
    bundle->state.apexes &= bundle->state.going;
    for (uint32_t left = bundle->state.going; left; left &= left - 1) {
        bundle->has.begins |= bundle->hulls.begin[mlrt_lowest_bit(left)] > 0;
    }
    return others;
}

/*
 * Takes packets that are far wider than the others out of a bundle. Where any hit will do, one triangle may hide all of
 * their rays: then they stay, in two halves, unless all rays are nearly parallel.
 */
static void take_wide_packets_apart(int any, uint32_t places, struct mlrt_bundle *bundle)
{
    if (any && bundle->waist.is_beam) return;
    for (uint32_t left = find_wide_packets(bundle) & places; left; left &= left - 1) {
        if (any) {
            divide_packet(bundle, mlrt_lowest_bit(left));
            continue;
        }
        release_packet(bundle, mlrt_lowest_bit(left));
        bundle->state.set_aside |= left & (0u - left);
    }
    if (bundle->state.divided) finish_again(bundle, bundle->state.divided);
}

/* Begins a bundle of which only `tile` and its cells are set. */
static void begin_bundle(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle)
{
    bundle->cache = &worker->bundles->caches[job->any];
    bundle->scene.unit = job->tree->bvh.unit;
    bundle->scene.reach = job->tree->bvh.reach;
    bundle->state.has_lanes = bundle->state.given_up = bundle->state.nearer = bundle->state.covered = 0;
    bundle->state.set_aside = bundle->state.has_reciprocals = bundle->state.divided = 0;
    memset(bundle->state.later, 0, sizeof bundle->state.later);
    bundle->has.begins = 0;
    memset(bundle->state.tests, 0, sizeof bundle->state.tests);
}

/* Makes the hulls of all packets from the extremes of their rays. They have no covers so far. */
static void finish_all_hulls(struct mlrt_bundle *bundle)
{
    bundle->has.intercepts = (bundle->state.going & ~bundle->state.apexes) != 0;
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        finish_depths(bundle, bundle->state.going, v);
        finish_hulls(bundle, v);
        v_store(bundle->hulls.closed.cover_near + v, v_set1(INFINITY));
        i_store(bundle->hulls.closed.cover + v, i_set1(MLRT_NONE));
    }
}

/*
 * Makes a bundle from the packets `places` and the cells that it has, if any (`closed`). Sets `going` to those that fit
 * it: their rays go along its main axis. Returns the others that have active rays.
 */
static MLRT_NOINLINE uint32_t make_bundle(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t places,
                                          struct mlrt_bundle *bundle)
{
    struct ray_sample samples[SAMPLE_LIMIT];
    const uint32_t cells = bundle->state.closed;
    const uint32_t sample_count = cells ? 0 : take_samples(bundle->tile, places, &bundle->scene, samples);
    begin_bundle(job, worker, bundle);
    bundle->arrays = NULL;
    bundle->state.going = bundle->state.apexes = cells;
    bundle->has.intercepts = 1;
    if (!cells && !choose_waist(&job->tree->bvh.core, samples, sample_count, &bundle->cache->waist, &bundle->waist)) {
        return check_packets_outside(bundle, places);
    }
    set_scene_depths(&job->tree->bvh, bundle);
    const int may_be_apex = cells || (memcmp(bundle->waist.point, samples[0].origin, sizeof samples[0].origin) == 0 &&
                                      mlrt_are_float_safe(samples[0].origin));
    bundle->has.apex = may_be_apex && find_apex(bundle, bundle->apex);
    const uint32_t others = add_packets(bundle, places);
    if (!bundle->state.going) return others;
    finish_all_hulls(bundle);
    bundle->state.closed = mlrt_skips_attempt(&worker->bundles->open_bundles[job->any]) ? 0 : bundle->state.going;
    bundle->state.closed |= cells;
    for (uint32_t left = bundle->state.closed & places; left; left &= left - 1) {
        if (bundle->tile->packets[mlrt_lowest_bit(left)].has.masks) bundle->state.closed &= ~(left & (0u - left));
    }
    take_wide_packets_apart(job->any, places, bundle);
    return others;
}

/* Takes the packets of a bundle down the hierarchy, but for halves that are put off. */
static void trace_pass(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle)
{
    traverse_bundle(job, worker, bundle);
    uint32_t rest = 0;
    if (mlrt_count_bits(bundle->state.given_up) > MLRT_MOST_GIVEN_UP) rest = bundle->state.going;
    for (uint32_t left = rest; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        bundle->state.closed &= ~(1u << place);
        if (has_rays(bundle, place) || make_rays_of_packet(job, bundle, place)) {
            release_packet(bundle, place);
            bundle->state.set_aside |= left & (0u - left);
        }
    }
    bundle->state.set_aside |= bundle->state.given_up;
    for (uint32_t left = bundle->state.going & ~bundle->state.has_lanes; left; left &= left - 1) {
        if (has_rays(bundle, mlrt_lowest_bit(left))) finish_untouched_packet(bundle, mlrt_lowest_bit(left));
    }
}

/* Traces a bundle, and second halves of packets in another pass. Packets left to go lane by lane are in `set_aside`. */
static void trace_going_packets(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle)
{
    uint32_t first_half[MLRT_BUNDLE_PACKETS], halved = 0;
    sum_up_hulls(bundle);
    bundle->far_first = job->any && ends_closer(bundle);
    keep_bundle_waist(&bundle->waist, bundle->cache);
    trace_pass(job, worker, bundle);
    const uint32_t going = bundle->state.going;
    for (uint32_t left = bundle->state.divided; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        if (!bundle->state.later[place]) continue;
        halved |= left & (0u - left);
        first_half[place] = bundle->tile->packets[place].active;
        bundle->tile->packets[place].active = bundle->state.later[place];
        bundle->state.later[place] = 0;
        bundle->state.tests[place] = 0;
    }
    if (!halved) return;
    for (uint32_t left = going & ~halved; left; left &= left - 1) leave_bundle(bundle, mlrt_lowest_bit(left));
    bundle->state.going = halved;
    for (uint32_t left = halved; left; left &= left - 1) bound_packet(bundle, mlrt_lowest_bit(left));
    finish_again(bundle, halved);
    sum_up_hulls(bundle);
    trace_pass(job, worker, bundle);
    bundle->state.going |= going;
    for (uint32_t left = halved; left; left &= left - 1) {
        bundle->tile->packets[mlrt_lowest_bit(left)].active |= first_half[mlrt_lowest_bit(left)];
    }
}

/* Traces packets lane by lane. */
static void trace_packets_by_lanes(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                                   uint32_t places)
{
    for (; places; places &= places - 1) {
        struct mlrt_packet *packet = &tile->packets[mlrt_lowest_bit(places)];
        trace_lanes(job, packet->active, packet, worker);
    }
}

/*
 * Traces a bundle of packets or tiles that have hulls but no rays (camera_cells.c, shadow_cells.c, array_cells.h).
 * Packets get rays when they are opened. If `is_open`, all are opened at once.
 */
static MLRT_NOINLINE void trace_cells(const struct mlrt_job *job, struct mlrt_worker *worker, int is_open,
                                      struct mlrt_bundle *bundle)
{
    begin_bundle(job, worker, bundle);
    bundle->has.apex = bundle->state.apexes && find_apex(bundle, bundle->apex);
    set_scene_depths(&job->tree->bvh, bundle);
    for (uint32_t left = ~bundle->state.going & 0xFFFF; left; left &= left - 1)
        leave_bundle(bundle, mlrt_lowest_bit(left));
    finish_all_hulls(bundle);
    if (job->tree->bvh.node_count == 0) return;
    for (uint32_t left = is_open ? bundle->state.going : 0; left; left &= left - 1) {
        open_bundle_packet(job, bundle, mlrt_lowest_bit(left));
    }
    trace_going_packets(job, worker, bundle);
    if (bundle->arrays) mlrt_end_cover_parts(bundle, &worker->bundles->parts);
    if (bundle->state.set_aside) trace_packets_by_lanes(job, worker, bundle->tile, bundle->state.set_aside);
}

/* Sets how the next tiles go. The next trial is the later, the more of them agree. */
static void set_way(int by_lanes, struct mlrt_ways *ways)
{
    if (ways->by_lanes != by_lanes) ways->trial.length = 0;
    ways->by_lanes = by_lanes;
    mlrt_note_attempt(1, MLRT_FIRST_TRIAL, MLRT_LAST_TRIAL, &ways->trial);
}

/*
 * Traces those packets of a tile that fit one bundle. Returns the others, which are to be traced lane by lane. The
 * attempt is in vain if hardly a packet fits, or if several are given up on the way: then *is_vain is set to 1.
 */
static uint32_t trace_as_bundle(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle,
                                uint32_t places, int *is_vain)
{
    uint32_t others = make_bundle(job, worker, places, bundle);
    *is_vain |= 8 * mlrt_count_bits(bundle->state.going) < mlrt_count_bits(others);
    if (bundle->state.going) {
        const uint32_t closed = bundle->state.closed & places;
        trace_going_packets(job, worker, bundle);
        others |= bundle->state.set_aside;
        *is_vain |= mlrt_count_bits(bundle->state.given_up) > MLRT_MOST_GIVEN_UP;
        if (closed) {
            const uint32_t done = (bundle->state.closed & bundle->state.going) | bundle->state.covered;
            mlrt_note_attempt(!(done & places), MLRT_READ_BACKOFF, MLRT_TILE_BACKOFF,
                              &worker->bundles->open_bundles[job->any]);
        }
    }
    return others;
}

/*
 * Traces a tile both ways, one packet lane by lane and the others as a bundle, and compares what a packet took. The
 * packet is another one in each trial. While tiles go as bundles, what earlier trials took is added, since one packet
 * is not all; a trial while they go lane by lane counts alone, so that they soon go as bundles again. After a bundle in
 * vain lanes get a chance.
 */
static void trace_both_ways(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle,
                            uint32_t places, struct mlrt_ways *ways)
{
    const uint32_t count = mlrt_count_bits(places);
    uint32_t alone = places;
    for (uint32_t i = ways->trials++ % count; i > 0; --i) alone &= alone - 1;
    alone &= 0u - alone;
    int is_vain = 0;
    const double begin = mlrt_seconds_now();
    const uint32_t others = trace_as_bundle(job, worker, bundle, places & ~alone, &is_vain);
    trace_packets_by_lanes(job, worker, bundle->tile, others);
    const double middle = mlrt_seconds_now();
    trace_packets_by_lanes(job, worker, bundle->tile, check_packets_outside(bundle, alone));
    const double end = mlrt_seconds_now();
    const float kept = ways->by_lanes ? 0 : MLRT_TRIALS_KEPT;
    ways->together = kept * ways->together + (float)(middle - begin);
    ways->lanes = kept * ways->lanes + (float)((count - 1) * (end - middle));
    set_way(is_vain | (ways->together > ways->lanes), ways);
}

/*
 * Traces the packets `places` of a tile, whose rays are as their source gave them: those that are active or in_double
 * exist. The bundle may have cells as well, which are `closed`, and rays from its waist.
 */
static MLRT_NOINLINE void trace_bundle(const struct mlrt_job *job, struct mlrt_worker *worker,
                                       struct mlrt_bundle *bundle, uint32_t places)
{
    struct mlrt_ray_tile *tile = bundle->tile;
    const uint32_t cells = bundle->state.closed;
    uint32_t others = 0;
    int is_vain = 0;
    bundle->scene.unit = job->tree->bvh.unit;
    bundle->scene.reach = job->tree->bvh.reach;
    for (uint32_t left = places; left; left &= left - 1) {
        struct mlrt_packet *packet = &tile->packets[mlrt_lowest_bit(left)];
        packet->active |= packet->in_double;
        packet->in_double = 0;
        if (job->tree->bvh.node_count == 0) mlrt_fill_words(packet->nearest.triangle, MLRT_NONE);
    }
    if (job->tree->bvh.node_count == 0) return;
    if (!cells && !(places & (places - 1))) { /* at most one packet, and the worker may have no bundles */
        trace_packets_by_lanes(job, worker, tile, check_packets_outside(bundle, places));
        return;
    }
    struct mlrt_ways *ways = &worker->bundles->ways[job->any];
    if (!mlrt_skips_attempt(&ways->trial) && !cells && mlrt_count_bits(places) >= MLRT_TRIAL_PACKETS) {
        trace_both_ways(job, worker, bundle, places, ways);
    } else if (ways->by_lanes) {
        others = check_packets_outside(bundle, places);
        if (cells) others |= trace_as_bundle(job, worker, bundle, 0, &is_vain);
    } else {
        others = trace_as_bundle(job, worker, bundle, places, &is_vain);
        if (is_vain) set_way(1, ways);
    }
    trace_packets_by_lanes(job, worker, tile, others);
}

#endif
