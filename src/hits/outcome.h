/* SPDX-License-Identifier: MIT */
/*
 * A triangle and the rays of a packet, before and after a float filter has looked at them.
 */
#ifndef MLRT_HITS_OUTCOME_H
#define MLRT_HITS_OUTCOME_H

#include "hits/triangle_filter.h"
#include "rays/packet.h"
#include "simd/simd.h"

/* What a float filter has to say: lanes that are nearer, and what is left of the others. */
struct outcome {
    uint32_t nearer;
    uint32_t undecided;
    uint32_t inside;
};

/*
 * Of a vector of lanes, the rays that a triangle is offered to: it is no news to those that it is the nearest of, and
 * may be met again in another leaf.
 */
MLRT_INLINE vm concerned_rays(const struct mlrt_packet *packet, uint32_t lanes, uint32_t number, int v)
{
    const vm rays = m_andnot(m_from_bits(lanes >> v), i_eq(i_load(packet->triangle + v), i_set1(number)));
    return packet->has_skip ? m_andnot(rays, i_eq(i_load(packet->skip + v), i_set1(number))) : rays;
}

/* Makes the triangle the nearest hit where it is, and adds the rest to the outcome. */
MLRT_INLINE void keep_verdict(const struct verdict *verdict, uint32_t number, int v, struct mlrt_packet *packet,
                              struct outcome *outcome)
{
    const uint32_t nearer = m_bits(verdict->nearer);
    if (nearer) {
        v_store(packet->lo + v, v_select(verdict->nearer, verdict->lo, v_load(packet->lo + v)));
        v_store(packet->hi + v, v_select(verdict->nearer, verdict->hi, v_load(packet->hi + v)));
        i_store(packet->triangle + v, i_select(verdict->nearer, i_set1(number), i_load(packet->triangle + v)));
        outcome->nearer |= nearer << v;
    }
    outcome->undecided |= m_bits(verdict->undecided) << v;
    outcome->inside |= m_bits(verdict->inside) << v;
}

/* The lanes whose nearest hit is a triangle. */
MLRT_INLINE uint32_t lanes_of_triangle(const struct mlrt_packet *packet, uint32_t number)
{
    uint32_t lanes = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        lanes |= m_bits(i_eq(i_load(packet->triangle + v), i_set1(number))) << v;
    }
    return lanes;
}

#endif
