/* SPDX-License-Identifier: MIT */
/*
 * A triangle and the rays of a packet: which rays a float filter tests, and where its verdict goes.
 */
#ifndef MLRT_HITS_OUTCOME_H
#define MLRT_HITS_OUTCOME_H

#include "hits/triangle_filter.h"
#include "job/job.h"
#include "scene/masks.h"
#include "simd/simd.h"

/* The result of a float filter for the lanes of a packet. */
struct outcome {
    uint32_t nearer;    /* the triangle has become their nearest hit */
    uint32_t undecided; /* to be decided by close_calls.h */
    uint32_t inside;    /* surely inside all edges */
};

/* Returns those of `lanes` whose masks show a triangle. */
static MLRT_NOINLINE uint32_t lanes_by_masks(const struct mlrt_job *job, const struct mlrt_worker *worker,
                                             const struct mlrt_packet *packet, uint32_t number, uint32_t lanes)
{
    if (packet->has.masks) return mlrt_seeing_lanes(job->tree, number, packet->mask, lanes);
    return mlrt_is_hidden(job->tree, number, worker->mask) ? 0 : lanes;
}

/* Returns those of `lanes` that see a triangle: all of them, if no mask hides any. */
MLRT_INLINE uint32_t lanes_that_see(const struct mlrt_job *job, const struct mlrt_worker *worker,
                                    const struct mlrt_packet *packet, uint32_t number, uint32_t lanes)
{
    if (MLRT_LIKELY(!packet->has.masks && worker->mask == MLRT_MASK_ALL)) return lanes;
    return lanes_by_masks(job, worker, packet, number, lanes);
}

/*
 * The lanes, of the vector from v on, that must test triangle `number`: those of `lanes` that do not skip it, and do
 * not already have it as their nearest hit (a triangle can be in several leaves).
 */
MLRT_INLINE vm lanes_to_test(const struct mlrt_packet *packet, uint32_t lanes, uint32_t number, int v)
{
    const vm rays = m_andnot(m_from_bits(lanes >> v), i_eq(i_load(packet->nearest.triangle + v), i_set1(number)));
    return packet->has.skip ? m_andnot(rays, i_eq(i_load(packet->skip + v), i_set1(number))) : rays;
}

/* Makes the triangle the nearest hit of the lanes where it is nearer, and adds the verdict to the outcome. */
MLRT_INLINE void keep_verdict(const struct verdict *verdict, uint32_t number, int v, struct mlrt_packet *packet,
                              struct outcome *outcome)
{
    const uint32_t nearer = m_bits(verdict->nearer);
    if (nearer) {
        v_store(packet->nearest.lo + v, v_select(verdict->nearer, verdict->lo, v_load(packet->nearest.lo + v)));
        v_store(packet->nearest.hi + v, v_select(verdict->nearer, verdict->hi, v_load(packet->nearest.hi + v)));
        i_store(packet->nearest.triangle + v,
                i_select(verdict->nearer, i_set1(number), i_load(packet->nearest.triangle + v)));
        outcome->nearer |= nearer << v;
    }
    outcome->undecided |= m_bits(verdict->undecided) << v;
    outcome->inside |= m_bits(verdict->inside) << v;
}

/* One component of the origins of DW lanes, from `lane` on. */
MLRT_INLINE vd origins_in_double(const struct mlrt_packet *packet, int k, uint32_t lane)
{
    return packet->has.apex ? d_set1(packet->apex[k]) : d_load(packet->origin[k] + lane);
}

/* The directions of DW lanes, from `lane` on. */
MLRT_INLINE void load_directions(const struct mlrt_packet *packet, uint32_t lane, vd direction[3])
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) direction[k] = d_load(packet->direction[k] + lane);
}

/* The lanes whose nearest hit is triangle `number`. */
MLRT_INLINE uint32_t lanes_of_triangle(const struct mlrt_packet *packet, uint32_t number)
{
    uint32_t lanes = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW)
        lanes |= m_bits(i_eq(i_load(packet->nearest.triangle + v), i_set1(number))) << v;
    return lanes;
}

#endif
