/* SPDX-License-Identifier: MIT */
/*
 * A bundle: rays of a tile that share a main axis and its sign, seen relative to their waist.
 *
 * The waist is a point w near where the rays come closest to each other. Relative to it a point p has a depth
 * z = +-(p_main - w_main), signed so that all rays go up it, and two places x_j = p_j - w_j over the axes main + 1 and
 * main + 2. A ray is its place x0 where z = 0, its slopes s = d_j / |d_main|, and the depths between which it looks for
 * hits: its points are x0 + s z. Rays that start at one point or end at one have x0 = 0 or nearly so, rays of one
 * direction have one slope; others that are alike have small ranges of both.
 *
 * Along a ray, distances are measured in depth from its origin: tau = t |d_main|. That is not negative for hits, and a
 * nearer hit has the smaller tau.
 */
#ifndef MLRT_TRACE_BUNDLE_H
#define MLRT_TRACE_BUNDLE_H

#include <math.h>

#include "base/tuning.h"
#include "bvh/node.h"
#include "rays/packet.h"

#define MLRT_BUNDLE_PACKETS 16

/* The axis that slope or place `side` of a bundle with this main axis is over. */
MLRT_INLINE int mlrt_slope_axis(int main_axis, int side)
{
    const int axis = main_axis + 1 + side;
    return axis < 3 ? axis : axis - 3;
}

struct mlrt_waist {
    int32_t main_axis;
    float sign; /* of the main components: +-1 */
    float point[3];
    float slope[2];  /* along which triangles around it are seen: 0, or that of rays that are nearly parallel */
    int32_t is_beam; /* they are */
};

/* Has a bundle go along the axis that a direction goes along most. */
static inline void mlrt_set_main_axis(const float direction[3], struct mlrt_waist *waist)
{
    const float x = fabsf(direction[0]), y = fabsf(direction[1]), z = fabsf(direction[2]);
    waist->main_axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    waist->sign = direction[waist->main_axis] < 0 ? -1.0f : 1.0f;
    waist->slope[0] = waist->slope[1] = 0;
    waist->is_beam = 0;
}

/* What rays of a packet have in numbers: their slopes, their places at the waist and the cross product of both. */
enum mlrt_ray_term {
    MLRT_SLOPE_J,
    MLRT_SLOPE_L,
    MLRT_PLACE_J,
    MLRT_PLACE_L,
    MLRT_MOMENT, /* s_l x_j - s_j x_l */
    MLRT_RAY_TERMS
};

/* The rays of a packet, lane by lane. */
struct mlrt_bundle_rays {
    MLRT_ALIGNED(64) float term[MLRT_RAY_TERMS][MLRT_PACKET_RAYS]; /* without places, slopes only */
    MLRT_ALIGNED(64) float to_waist[3][MLRT_PACKET_RAYS]; /* w - o: depth, and with places, place j, place l */
    MLRT_ALIGNED(64) float pace[MLRT_PACKET_RAYS];        /* |d_main| */
    MLRT_ALIGNED(64) float begin[MLRT_PACKET_RAYS];       /* bounds of tau: after it; nearest hit so far */
    MLRT_ALIGNED(64) float lo[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float hi[MLRT_PACKET_RAYS];
};

/* Intervals of the terms, by packet. */
struct mlrt_hull_row {
    MLRT_ALIGNED(64) float lo[MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float hi[MLRT_BUNDLE_PACKETS];
};

/*
 * The hulls of packets, by packet. `term` is what the lanes have; slopes and places are moved apart by what rounding may
 * change. A packet that looks no further has first = inf, last = -inf.
 */
struct mlrt_hulls {
    struct mlrt_hull_row term[MLRT_RAY_TERMS];
    struct mlrt_hull_row slope[2];
    struct mlrt_hull_row place[2];
    MLRT_ALIGNED(64) float first[MLRT_BUNDLE_PACKETS]; /* depths between which the rays look */
    MLRT_ALIGNED(64) float last[MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float begin[MLRT_BUNDLE_PACKETS]; /* the greatest tau at which a ray begins to look */
    /* What the filters need (leaf.h): the terms as middle and radius, and what errors are relative to. */
    MLRT_ALIGNED(64) float middle[MLRT_RAY_TERMS][MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float radius[MLRT_RAY_TERMS][MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float reach[MLRT_BUNDLE_PACKETS]; /* R */
    MLRT_ALIGNED(64) float blur[MLRT_BUNDLE_PACKETS];  /* Q */
    MLRT_ALIGNED(64) float away[MLRT_BUNDLE_PACKETS];  /* A */
    /* Of closed packets (cover.h): depths between which all rays look, and what covers them from where. */
    MLRT_ALIGNED(64) float core_first[MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float core_last[MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float cover_near[MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) uint32_t cover[MLRT_BUNDLE_PACKETS]; /* a triangle's number; MLRT_NONE: nothing so far */
    MLRT_ALIGNED(64)
    uint32_t skip[MLRT_BUNDLE_PACKETS]; /* of packets without rays: the triangle that all of them pass */
};

/* One hull of all packets that go together. */
struct mlrt_hull {
    float slope_lo[2];
    float slope_hi[2];
    float place_lo[2];
    float place_hi[2];
    float first;
    float last;
};

/* What boxes need of the rays of a packet that go one by one (single.h). */
struct mlrt_reciprocals {
    MLRT_ALIGNED(64) float near[3][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float far[3][MLRT_PACKET_RAYS];
};

struct mlrt_bundle_cache;
struct mlrt_ray_tile;

/* A bundle on its way down the hierarchy: the packets of a tile, or the tiles of a square, which have no rays. Bits are
 * packets. */
struct mlrt_bundle {
    struct mlrt_waist waist;
    int has_places; /* 0: all rays start at the waist, and all places are 0 */
    int is_apex;    /* the waist is where some rays start: */
    float apex[3];  /* there, as rays are given */
    int has_begins; /* some t_min is not 0 */
    int far_first;  /* boxes that the rays come to last are opened first */
    float unit;     /* brings rays into units (bvh/unit.h), where all of this is */
    float scene_first, scene_last;
    float core_first, core_last; /* where most triangles are, as a guess */
    struct mlrt_hull whole;
    struct mlrt_hulls hulls;
    uint32_t going;     /* packets with a hull */
    uint32_t apexes;    /* packets whose rays all start at the waist */
    uint32_t closed;    /* of whose rays no more is known than what covers all of them (cover.h) */
    uint32_t covered;   /* that are done, as one triangle hides all of their rays */
    uint32_t riding;    /* that go lane by lane afterwards, unless one triangle happens to hide all of their rays */
    uint32_t nearer;    /* whose rays may look less far than their hulls say */
    uint32_t given_up;  /* that were tested in vain too often */
    uint32_t set_aside; /* that are to go lane by lane afterwards */
    uint32_t made;      /* of whose rays there are the numbers, lane by lane */
    uint32_t has_reciprocals;            /* of whose rays there are these */
    uint32_t tests[MLRT_BUNDLE_PACKETS]; /* of triangles that no ray could hit */
    struct mlrt_bundle_cache *cache;
    struct mlrt_ray_tile *tile; /* whose packets they are; NULL: they are tiles */
};

/* What bundles with one waist share about the triangles of a leaf: arrays have a place for each triangle. */
struct mlrt_bundle_leaf {
    int32_t axis;        /* the main one; ~axis if rays go down it */
    int32_t has_places;  /* 0: set up for rays from the waist only */
    uint32_t there;      /* places with a triangle that the call's common mask shows; bit per place */
    uint32_t from_waist; /* of these, those that a ray from the waist can hit: it does not lie in their planes */
    uint32_t flipped;    /* whose terms have the other sign, so that N is not negative at the waist */
    uint32_t doubtful;   /* of which float does not know that sign; none once that is settled */
    uint32_t row;        /* floats in a row of corners */
    const uint32_t *numbers;
    const float *corners;
    uint32_t odd;                                     /* bvh/unit.h */
    uint32_t ready;                                   /* vectors of places that have their terms */
    uint32_t fans;                                    /* of what the outlines are: see outline.h */
    MLRT_ALIGNED(64) float near[MLRT_BVH_LEAF_LIMIT]; /* depths of the triangle */
    MLRT_ALIGNED(64) float far[MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float outline_lo[2][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float outline_hi[2][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float weight[MLRT_BVH_LEAF_LIMIT];
    /* Edge functions ab, bc, ca: a constant, and what the terms of a ray are multiplied with. */
    MLRT_ALIGNED(64) float edge_constant[3][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float edge[3][MLRT_RAY_TERMS][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float normal[3][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float distance[MLRT_BVH_LEAF_LIMIT];  /* of the plane from the waist: N there */
    MLRT_ALIGNED(64) float steepness[MLRT_BVH_LEAF_LIMIT]; /* rho: how much places weigh in edge functions */
    MLRT_ALIGNED(64) float away[MLRT_BVH_LEAF_LIMIT];      /* what the error of `distance` is relative to */
};

/* What is known of two triangles. */
enum mlrt_pair_kind { MLRT_NO_LINE, MLRT_LINE, MLRT_ONE_PLANE };

/*
 * The line that the planes of two triangles have in common, as an edge function: of a ray that meets both, its sign times
 * those of both D is that of t(first) - t(second) (pair_line.c). `normal` is that of the second.
 */
struct mlrt_pair_line {
    uint32_t first;
    uint32_t second;
    uint32_t waist_count; /* the cache's when it was set */
    int32_t kind;
    float constant;
    float coefficient[MLRT_RAY_TERMS];
    float normal[3];
    float error;     /* relative to R; as EDGE_ERROR */
    float steepness; /* as that of a leaf */
};

#define MLRT_PAIR_LINE_BITS 8

/* The set-ups of leaves that were met last, for one waist. */
struct mlrt_bundle_cache {
    struct mlrt_bundle_leaf *leaves; /* 1 << bits of them, by a hash of the first quad */
    uint32_t bits;
    struct mlrt_waist waist;                       /* main_axis -1: of none */
    uint32_t waist_count;                          /* how many there were so far */
    uint32_t children[1u << MLRT_LEAF_SETUP_BITS]; /* whose they are, as in the nodes; 0 = nobody's */
    struct mlrt_pair_line lines[1u << MLRT_PAIR_LINE_BITS];
};

#endif
