/* SPDX-License-Identifier: MIT */
/*
 * A bundle: the rays of a tile that share a main axis and its sign, described relative to a waist.
 *
 * The waist w is a point near where the rays come closest to each other. Relative to it, a point p has a depth
 * z = +-(p_main - w_main), with the sign of the axis, so that depth grows along all rays; and the
 * components p_j - w_j and p_l - w_l, over the axes main + 1 and main + 2. The origin of a ray, in the same terms, is
 * o.
 *
 * A ray is described by its slopes s_j = d_j / |d_main| and its intercepts x_j = o_j - s_j o_main at depth 0: at depth
 * z it is at x + s z. Rays that start at one point, or end at one, have intercepts of 0 or nearly 0; parallel rays have
 * one slope; other rays that are alike have small ranges of both.
 *
 * Distances along a ray are measured in depth from its origin: tau = t |d_main|. Hits have no negative tau, and of two
 * hits the nearer one has the smaller tau.
 *
 * A packet is closed while none of its rays has been tested: all of them hit one triangle, its cover, or none so far
 * (cover.h). A cell is a packet, or a tile, of which only the hull is known: its rays are not made (cells.h).
 *
 * As an index, `place` is the position of a packet in its tile, or of a triangle in its leaf; where both occur,
 * `triangle` is the latter. `number` is that of a triangle in the tree. L1, L2, ... are the lemmas of docs/accuracy.md,
 * "Bundles".
 */
#ifndef MLRT_TRACE_BUNDLE_H
#define MLRT_TRACE_BUNDLE_H

#include <math.h>

#include "base/tuning.h"
#include "bvh/node.h"
#include "hits/shadow_ray.h"
#include "rays/packet.h"

#define MLRT_BUNDLE_PACKETS 16 /* or tiles */

/* How far edge functions of rays that start at the waist are off, in units of size times R (leaf.h, EDGES). */
#define EDGE_ERROR (MLRT_GUESS ? 0 : 14 * 0x1p-24f)

/* The axis of the slope and the intercept `side` (0: j, 1: l) of a bundle with this main axis. */
MLRT_INLINE int mlrt_slope_axis(int main_axis, int side)
{
    const int axis = main_axis + 1 + side;
    return axis < 3 ? axis : axis - 3;
}

struct mlrt_waist {
    int32_t main_axis;
    float sign; /* of the main components: +-1 */
    float point[3];
    float slope[2];  /* the slope along which outline.h sees triangles: that of the rays if is_beam, else 0 */
    int32_t is_beam; /* the rays are nearly parallel */
};

/* Faces a waist along `direction`: sets main axis and sign by its largest component. No slope, no beam. */
static inline void mlrt_face_waist(const float direction[3], struct mlrt_waist *waist)
{
    const float x = fabsf(direction[0]), y = fabsf(direction[1]), z = fabsf(direction[2]);
    waist->main_axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    waist->sign = direction[waist->main_axis] < 0 ? -1.0f : 1.0f;
    waist->slope[0] = waist->slope[1] = 0;
    waist->is_beam = 0;
}

/* What edge functions are linear in (leaf.h), of a ray: slopes, intercepts, and the cross product of these. */
enum mlrt_ray_term {
    MLRT_SLOPE_J,
    MLRT_SLOPE_L,
    MLRT_INTERCEPT_J,
    MLRT_INTERCEPT_L,
    MLRT_MOMENT, /* s_l x_j - s_j x_l; the number of slopes and intercepts */
    MLRT_RAY_TERMS
};

/* The rays of a packet, lane by lane. */
struct mlrt_bundle_rays {
    MLRT_ALIGNED(64) float term[MLRT_RAY_TERMS][MLRT_PACKET_RAYS]; /* without intercepts only the slopes */
    MLRT_ALIGNED(64)
    float to_waist[3][MLRT_PACKET_RAYS];            /* -o: depth, j, l; without intercepts only the depth */
    MLRT_ALIGNED(64) float pace[MLRT_PACKET_RAYS];  /* |d_main| in units */
    MLRT_ALIGNED(64) float begin[MLRT_PACKET_RAYS]; /* tau of t_min: hits lie beyond it */
    MLRT_ALIGNED(64) float lo[MLRT_PACKET_RAYS];    /* bounds of tau: of the nearest hit so far, or t_max */
    MLRT_ALIGNED(64) float hi[MLRT_PACKET_RAYS];
};

/* An interval of one number for each packet. */
struct mlrt_hull_row {
    MLRT_ALIGNED(64) float lo[MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float hi[MLRT_BUNDLE_PACKETS];
};

/* What the filters (leaf.h) need: the terms as middle and radius, and the factors of the error bounds. */
struct mlrt_filter_hulls {
    MLRT_ALIGNED(64) float middle[MLRT_RAY_TERMS][MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float radius[MLRT_RAY_TERMS][MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float direction_size[MLRT_BUNDLE_PACKETS]; /* R */
    MLRT_ALIGNED(64) float blur[MLRT_BUNDLE_PACKETS];           /* 13 u X + 4 u R A + 2^-110: of intercepts, in L5 */
    MLRT_ALIGNED(64) float away[MLRT_BUNDLE_PACKETS];           /* A */
};

/* What is known only of closed packets (cover.h). */
struct mlrt_closed_packets {
    MLRT_ALIGNED(64) float common_first[MLRT_BUNDLE_PACKETS]; /* depths between which every ray looks for hits */
    MLRT_ALIGNED(64) float common_last[MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float cover_near[MLRT_BUNDLE_PACKETS]; /* the least depth of the cover */
    MLRT_ALIGNED(64) uint32_t cover[MLRT_BUNDLE_PACKETS];   /* the number of a triangle; MLRT_NONE = no cover so far */
    MLRT_ALIGNED(64)
    uint32_t skip[MLRT_BUNDLE_PACKETS]; /* of packets without rays: the triangle that all of their rays skip */
};

/*
 * The hulls of packets: bounds of the rays of each. `term` has the extremes as they were computed. `moved` has those of
 * slopes and intercepts, and these, `first` and `last` are moved apart, by more than rounding can change. A packet that
 * has left the bundle has first = inf, last = -inf.
 */
struct mlrt_hulls {
    struct mlrt_hull_row term[MLRT_RAY_TERMS];
    struct mlrt_hull_row moved[MLRT_MOMENT];
    MLRT_ALIGNED(64) float first[MLRT_BUNDLE_PACKETS]; /* depths between which rays look for hits */
    MLRT_ALIGNED(64) float last[MLRT_BUNDLE_PACKETS];
    MLRT_ALIGNED(64) float begin[MLRT_BUNDLE_PACKETS]; /* the greatest tau of a t_min */
    struct mlrt_filter_hulls filter;
    struct mlrt_closed_packets closed;
};

/* One hull, moved apart: of all packets of a bundle, or of one. */
struct mlrt_hull {
    float lo[MLRT_MOMENT]; /* of slopes and intercepts */
    float hi[MLRT_MOMENT];
    float first;
    float last;
};

/* 1 / d, rounded, of the rays of a packet that are traced one by one (single_ray.h). */
struct mlrt_reciprocals {
    MLRT_ALIGNED(64) float rounded[3][MLRT_PACKET_RAYS];
};

struct mlrt_bundle_cache;
struct mlrt_ray_tile;
struct mlrt_array_cells;

/* What the rays of a bundle have. */
struct mlrt_bundle_traits {
    int intercepts; /* 0: all rays start at the waist, and all intercepts are 0 */
    int apex;       /* `apex` of the bundle is set: rays may start there */
    int begins;     /* at least one t_min is above 0 */
};

/* The scene, as a bundle sees it. */
struct mlrt_bundle_scene {
    float unit;                  /* all numbers of a bundle but `apex` are in units of the hierarchy (bvh/unit.h) */
    float reach;                 /* rays from farther away go in double (scene/reach.h) */
    float first, last;           /* depths between which all boxes lie */
    float core_first, core_last; /* depths between which most triangles lie: only for guesses */
};

/*
 * Where the packets of a bundle stand. The masks have a bit for each packet.
 *
 *     going, closed      as it begins, if it fits; and as it ends, if all of its rays hit its cover, or none hits any
 *       | opened         it may hit another triangle (open_bundle_packet): its rays are made, if they were not
 *     going              as it ends otherwise; has_lanes from the first test of its rays on
 *
 * A packet that leaves on the way is no longer going (leave_bundle): it is covered; or its rays, once they were made,
 * do not fit, and are set aside; or it is given up, and set aside at the end. A divided packet goes down twice: its
 * second half is in later[] until the first pass has ended.
 */
struct mlrt_bundle_state {
    uint32_t going;                      /* traced as part of the bundle */
    uint32_t apexes;                     /* all rays start at the waist */
    uint32_t closed;                     /* only their cover is known, and no ray of theirs has been tested (cover.h) */
    uint32_t covered;                    /* done, where any hit will do: triangles hide all rays */
    uint32_t nearer;                     /* rays have new hits, from which `last` of the hull has not been updated */
    uint32_t given_up;                   /* taken out of the bundle after too many tests in vain */
    uint32_t set_aside;                  /* to be traced lane by lane after the bundle */
    uint32_t has_lanes;                  /* tile->rays have the numbers of their rays */
    uint32_t has_reciprocals;            /* tile->reciprocals are set */
    uint32_t divided;                    /* are traced in two halves */
    uint32_t tests[MLRT_BUNDLE_PACKETS]; /* of triangles that no ray could hit */
    uint16_t later[MLRT_BUNDLE_PACKETS]; /* rays of the second half, while that is put off */
};

/*
 * A bundle on its way down the hierarchy. Its packets are those of a tile, or they stand for the tiles of a square and
 * have no rays.
 */
struct mlrt_bundle {
    struct mlrt_waist waist;
    struct mlrt_bundle_traits has;
    float apex[3];    /* with has.apex: the waist, not in units */
    int far_first;    /* the farthest boxes are opened first */
    int ends_at_skip; /* rays that are not made yet end before the plane of the triangle that they skip */
    struct mlrt_bundle_scene scene;
    struct mlrt_hull whole;
    struct mlrt_hulls hulls;
    struct mlrt_bundle_state state;
    struct mlrt_bundle_cache *cache;
    struct mlrt_ray_tile *tile;      /* which has the packets; NULL: they stand for tiles */
    struct mlrt_array_cells *arrays; /* of cells of the caller's arrays: how to read their rays (cells.h); else NULL */
};

/* Which triangles of a leaf are set up, and how. */
struct mlrt_leaf_state {
    uint32_t there;      /* places with a triangle that the call's common mask shows */
    uint32_t from_waist; /* of these, all whose planes are not known to contain the waist */
    uint32_t flipped;    /* all coefficients are negated, so that N at the waist is not negative */
    uint32_t doubtful;   /* float does not tell the sign of N at the waist, and the judge has not been asked */
    uint32_t odd;        /* odd triangles (bvh/unit.h) */
    uint32_t ready;      /* coefficients are set, for whole vectors of places */
    uint32_t fans;       /* the outline is that of a fan, not of a beam (outline.h) */
};

/* Where triangles are seen from the waist (outline.h). */
struct mlrt_leaf_outlines {
    MLRT_ALIGNED(64) float near[MLRT_BVH_LEAF_LIMIT]; /* depths between which the triangle lies */
    MLRT_ALIGNED(64) float far[MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float lo[2][MLRT_BVH_LEAF_LIMIT]; /* along j and l: slopes of a fan, intercepts of a beam */
    MLRT_ALIGNED(64) float hi[2][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float weight[MLRT_BVH_LEAF_LIMIT]; /* of |x| for a fan, of |s - t| for a beam */
};

/* Edge functions ab, bc, ca: a constant, and the coefficients of the terms of a ray. */
struct mlrt_leaf_edges {
    MLRT_ALIGNED(64) float constant[3][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float coefficient[3][MLRT_RAY_TERMS][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float steepness[MLRT_BVH_LEAF_LIMIT]; /* rho: the weight of intercepts in their errors */
};

/* Planes: n and N, in units of the size of n (leaf.h). */
struct mlrt_leaf_planes {
    MLRT_ALIGNED(64) float normal[3][MLRT_BVH_LEAF_LIMIT];
    MLRT_ALIGNED(64) float distance[MLRT_BVH_LEAF_LIMIT]; /* N at the waist */
    MLRT_ALIGNED(64) float away[MLRT_BVH_LEAF_LIMIT];     /* F: the error of `distance` is relative to it */
};

/* The set-up of a leaf, which bundles with one waist share. Arrays and masks have an entry for each place. */
struct mlrt_bundle_leaf {
    int32_t axis;           /* the main axis; ~axis if rays go down it */
    int32_t has_intercepts; /* 0: set up only for rays that start at the waist */
    uint32_t row;           /* floats in a row of corners */
    const uint32_t *numbers;
    const float *corners;
    struct mlrt_leaf_state state;
    struct mlrt_leaf_outlines outline;
    struct mlrt_leaf_edges edges;
    struct mlrt_leaf_planes planes;
};

/* How the planes of two triangles meet: in no line that is certain enough, in a line, or in all points. */
enum mlrt_pair_kind { MLRT_NO_LINE, MLRT_LINE, MLRT_ONE_PLANE };

/*
 * The line in which the planes of two triangles meet, as an edge function F (plane_order.c): for a ray that meets both
 * planes, F D_1 D_2 has the sign of t_1 - t_2. `normal` is n of the second triangle, divided by its size.
 */
struct mlrt_pair_line {
    uint32_t first;
    uint32_t second;
    uint32_t waist_count; /* of the cache, when the line was set */
    int32_t kind;
    float constant;
    float coefficient[MLRT_RAY_TERMS];
    float normal[3];
    float error;     /* in place of EDGE_ERROR */
    float steepness; /* in place of that of a leaf */
};

#define MLRT_PAIR_LINE_BITS 8

/*
 * The set-ups of leaves, and the lines of pairs, that were needed last, for one point and slope: those of other main
 * axes and signs stay among them.
 */
struct mlrt_bundle_cache {
    struct mlrt_bundle_leaf *leaves; /* 1 << bits of them, by a hash of the first quad */
    uint32_t bits;
    struct mlrt_waist waist;                       /* main_axis -1: none so far */
    uint32_t waist_count;                          /* how many waists there have been */
    uint32_t children[1u << MLRT_LEAF_SETUP_BITS]; /* of `leaves`: the leaf, as in a node; 0 = none */
    struct mlrt_pair_line lines[1u << MLRT_PAIR_LINE_BITS];
};

/* An edge of a triangle inside of which not all rays of a cell pass. */
struct mlrt_open_edge {
    float first[3]; /* its ends, ordered so that the inside is on the same side of all edges of a cell */
    float last[3];
    uint32_t number; /* of the triangle */
    uint32_t others; /* a bit for each edge of the cell that has the same ends in the other order */
};

#define MLRT_MOST_OPEN_EDGES 24

/* The open edges of what hides a cell in part (cover_parts.h). */
struct mlrt_cell_parts {
    uint32_t count;
    struct mlrt_open_edge edges[MLRT_MOST_OPEN_EDGES];
};

/*
 * After an attempt in vain the next areas go without one: at first `least`, and after each further attempt in vain
 * twice as many and one more, up to `longest` (1, 3, 7, ...). After a success the next area makes one.
 */
struct mlrt_backoff {
    uint32_t left;   /* areas, from this one on */
    uint32_t length; /* areas at first */
};

/* Does the next area do without the attempt? */
static inline int mlrt_skips_attempt(struct mlrt_backoff *backoff)
{
    if (backoff->left == 0) return 0;
    --backoff->left;
    return 1;
}

/* Notes an attempt. `least` and `longest` are one less than a power of two. */
static inline void mlrt_note_attempt(int is_vain, uint32_t least, uint32_t longest, struct mlrt_backoff *backoff)
{
    backoff->length = is_vain ? ((2 * backoff->length + 1) | least) & longest : 0;
    backoff->left = backoff->length;
}

/* Which of two ways a worker's next tiles go, as bundles or lane by lane: see tile.h. */
struct mlrt_ways {
    int by_lanes;              /* the next tiles go lane by lane */
    float together, lanes;     /* what trials took, in seconds: a tile as a bundle, and lane by lane */
    uint32_t trials;           /* tiles that went both ways */
    struct mlrt_backoff trial; /* until the next of these */
};

/* What hides the cells of a square in part. */
struct mlrt_cover_parts {
    struct mlrt_backoff lone_squares; /* in which no cell waits for further parts */
    uint32_t waited;                  /* cells that have had a part */
    uint32_t open[3];                 /* of the triangle that is offered: see mlrt_add_cover_part */
    struct mlrt_cell_parts cells[MLRT_BUNDLE_PACKETS];
};

/* What a worker keeps. Of pairs, [1] is for any hit: the tiles of a picture and their shadows take turns. */
struct mlrt_bundles {
    struct mlrt_backoff open_bundles[2]; /* tiles that begin with open packets */
    struct mlrt_backoff open_tiles;      /* tiles that begin with open cells (levels.h) */
    struct mlrt_backoff open_squares;    /* squares that are traced tile by tile */
    struct mlrt_ways ways[2];
    struct mlrt_bundle_cache caches[2];
    struct mlrt_kept_surface surfaces[MLRT_KEPT_SURFACES]; /* that a picture's rays hit, if it has lights */
    struct mlrt_cover_parts parts;
};

#endif
