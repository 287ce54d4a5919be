/* SPDX-License-Identifier: MIT */
/*
 * A closed packet of a bundle (cover.h), of which only hull and cover are known. When it is opened, its rays are made,
 * if they were not, and the cover becomes their nearest hit; or it ends closed.
 */
#ifndef MLRT_TRACE_CLOSED_PACKET_H
#define MLRT_TRACE_CLOSED_PACKET_H

#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/make_rays.h"
#include "trace/ray_hulls.h"
#include "trace/ray_terms.h"
#include "trace/units.h"

/* Does a packet have its rays? */
MLRT_INLINE int has_rays(const struct mlrt_bundle *bundle, uint32_t place)
{
    return bundle->tile && bundle->tile->made >> place & 1;
}

/*
 * Makes the rays of a packet of which only the hull was known. Returns 0 if the packet has left the bundle: because
 * none of its rays can hit anything (rule R1), or because float does not carry one of them; then it is set aside if
 * it has active rays.
 */
static MLRT_NOINLINE int make_rays_of_packet(const struct mlrt_job *job, struct mlrt_bundle *bundle, uint32_t place)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    const int v = (int)(place - place % VW);
    make_rays(job, bundle->tile, place);
    if (MLRT_UNLIKELY(bundle->scene.unit != 1))
        check_packet_in_units(packet->active | packet->in_double, bundle->scene.unit, bundle->scene.reach, packet);
    int fits = packet->active && !packet->in_double;
    if (fits && (bundle->scene.unit != 1 || bundle->tile->seen)) { /* bounds of the rays are closer than the cell's */
        const float last = bundle->hulls.last[place];              /* may be the cover's */
        fits = !(packet->active & ~bound_rays(bundle, place)) && hulls_fit(bundle, 1u << place);
        finish_depths(bundle, 1u << place, v);
        if (last < bundle->hulls.last[place]) bundle->hulls.last[place] = last;
        finish_hulls(bundle, v);
    } else if (fits) {
        fits = !may_have_tiny_slopes(&bundle->hulls, place) || !has_tiny_slopes(bundle, packet);
    }
    if (fits) return 1;
    leave_bundle(bundle, place);
    bundle->state.set_aside |= packet->active ? 1u << place : 0;
    return 0;
}

/*
 * Opens a closed packet: makes its cover the nearest hit of all rays, at depths between those of the cover over all
 * rays. A packet that stands for a tile leaves the bundle.
 */
static MLRT_NOINLINE void open_bundle_packet(const struct mlrt_job *job, struct mlrt_bundle *bundle, uint32_t place)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    bundle->state.closed &= ~(1u << place);
    if (!bundle->tile) {
        leave_bundle(bundle, place);
        return;
    }
    if (!has_rays(bundle, place) && !make_rays_of_packet(job, bundle, place)) return;
    need_lanes(bundle, place);
    if (hulls->closed.cover[place] == MLRT_NONE) return;
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const vf near = v_set1(hulls->closed.cover_near[place]), far = v_set1(hulls->last[place]),
             away = v_set1(hulls->filter.away[place]);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm active = m_from_bits(packet->active >> v);
        const vf z = v_load(rays->to_waist[0] + v), slack = v_set1(SLOPE_SLACK), floor = v_set1(HULL_FLOOR);
        const vf lo = v_sub(v_add(near, z), v_mul_add(v_add(v_abs(near), away), slack, floor));
        const vf hi = v_add(v_add(far, z), v_mul_add(v_add(v_abs(far), away), slack, floor));
        v_store(rays->lo + v, v_select(active, v_max(lo, v_set1(0)), v_load(rays->lo + v)));
        v_store(rays->hi + v, v_select(active, hi, v_load(rays->hi + v)));
        i_store(packet->nearest.triangle + v,
                i_select(active, i_set1(hulls->closed.cover[place]), i_load(packet->nearest.triangle + v)));
    }
}

/* Ends a packet whose rays have never been tested: all of them hit its cover, or miss if it has none. */
MLRT_INLINE void finish_untouched_packet(struct mlrt_bundle *bundle, uint32_t place)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    const vi cover = i_set1(bundle->hulls.closed.cover[place]), none = i_set1(MLRT_NONE);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        i_store(packet->nearest.triangle + v, i_select(m_from_bits(packet->active >> v), cover, none));
    }
}

#endif
