/* SPDX-License-Identifier: MIT */
/*
 * A tracing call (struct mlrt_job), the state of each of its workers, and the table of functions that an instruction
 * set provides.
 */
#ifndef MLRT_JOB_JOB_H
#define MLRT_JOB_JOB_H

#include "base/forms.h"
#include "base/tuning.h"
#include "job/hit_terms.h"
#include "job/write_arrays.h"
#include "rays/source.h"

/* State of workers that only one structure uses: trace/bundle.h and mlrta/setups.h. */
struct mlrt_bundle;
struct mlrt_bundles;
struct mlrt_setups;

/* base/progress.h */
struct mlrt_progress;

/* The options of the kd-tree. */
struct mlrt_multilevel {
    int32_t culling;
    int culling_check;
    uint32_t shortcuts; /* MLRT_SHORTCUT_*: those that are on */
    uint32_t minimum_tile_size;
    uint32_t split_divisor; /* pieces per side: the root of the split factor */
};

/* One call of the interface, as all workers see it. */
struct mlrt_job {
    const struct mlrt_tree *tree;
    const struct mlrt_kernels *kernels;
    struct mlrt_source source;
    int32_t method; /* resolved: not DEFAULT */
    int any;
    const struct mlrt_job *lights; /* a job for each light: its source, with `any` set */
    uint32_t light_count;
    uint32_t initial_tile_size;
    struct mlrt_multilevel multilevel;
    struct mlrt_sink frame; /* the caller's arrays; empty if there are none */
    uint32_t outputs;       /* of the callback */
    mlrt_tile_callback callback;
    void *user;
};

/*
 * A cached comparison of two triangles that do not lie in one plane, or may not (undecided.h). All 0 = empty entry,
 * since a triangle is never compared with itself.
 */
struct mlrt_triangle_pair {
    uint32_t first;
    uint32_t second;
    int32_t differ; /* they surely do not lie in one plane */
    int32_t order;  /* from `apex`: +1 if the first is behind the second wherever a ray hits it, -1 if it is before */
    float apex[3];
};

/* A triangle, and another one in the same plane (undecided.c). */
struct mlrt_known_plane {
    uint32_t number; /* MLRT_NONE = empty entry */
    uint32_t plane;
};

/*
 * Logarithms of how many planes and pairs a worker keeps. Calls of few rays keep few, since clearing large tables
 * would take longer than they save. With 256 pairs in place of 64, a picture of a room whose walls are all there twice
 * compares 1 % fewer pairs again.
 */
#define MLRT_KNOWN_PLANE_BITS 12
#define MLRT_FEW_PLANE_BITS   4
#define MLRT_PAIR_BITS        6
#define MLRT_FEW_PAIR_BITS    4

/* Answers about triangles that a worker keeps, since neighbouring rays need the same ones (undecided.h). */
struct mlrt_known_triangles {
    struct mlrt_triangle_pair *pairs; /* entry (first ^ second) & pair_mask */
    uint32_t pair_mask;               /* length of the table, a power of two, less one */
    uint32_t plane_mask;
    struct mlrt_known_plane *planes; /* entry number & plane_mask */
};

/* How a worker looks up in the middle of an item (stop.h). */
struct mlrt_watch {
    struct mlrt_progress *progress; /* NULL = the host has no progress function */
    uint64_t environment;           /* floating-point environment of the caller */
    double pixels_told;             /* pixels of the current item that progress has counted */
    uint32_t slow_steps;            /* counts calls of mlrt_is_stopped_in_step */
    int stopped;                    /* the call is to end */
};

/* 1 if there are so few rays that large tables of workers would not pay. */
static inline int mlrt_is_small(const struct mlrt_job *job)
{
    return (uint64_t)job->source.width * job->source.height < MLRT_MANY_RAYS;
}

/* Are the rays one block of a list? Then no bundle is made of them. */
static inline int mlrt_is_block(const struct mlrt_job *job)
{
    return job->source.kind != MLRT_SOURCE_CAMERA && job->source.count <= MLRT_PACKET_RAYS;
}

/* The state of one worker, in cache lines of its own. */
struct mlrt_worker {
    MLRT_ALIGNED(64) mlrt_counters counters;
    struct mlrt_known_triangles known;
    /* What the kernels of the tree's structure keep (trace/bundle.h, mlrta/setups.h); the other is not set. */
    struct mlrt_bundles *bundles;
    struct mlrt_setups *setups;
    struct mlrt_sink tile;            /* the callback's arrays, over the current tile; empty without a callback */
    const struct mlrt_sink *sinks[2]; /* of frame and tile, those that are not empty */
    uint32_t sink_count;
    uint32_t mask; /* of all rays; MLRT_MASK_ALL if each has its own, or triangles have none */
    struct mlrt_hit_term_cache hit_terms;
    uint32_t mesh; /* position of the mesh that was hit last */
    struct mlrt_watch watch;
    struct mlrt_scaled_packet *scaled; /* the packet in units while its rays go alone (trace/units.h), else NULL */
};

/* rays/lone_ray.h */
struct mlrt_lone_ray;

/* exact/predicate.h */
struct mlrt_hit_report;

/* trace/ray_tile.h */
struct mlrt_rectangle;
struct mlrt_ray_tile;

/* mlrta/entry_point.h */
struct entry_list;

/* How packets of a picture are read and written, and what is rare enough to be shared by both structures. */
struct mlrt_picture_kernels {
    /* Make the rays of a block, and check them; `lanes` are those that exist. rays/fetch_block.h, check_packet.h */
    void (*fetch_block)(const struct mlrt_source *source, const struct mlrt_rectangle *block, uint32_t lanes,
                        struct mlrt_packet *packet);
    void (*check_block)(const struct mlrt_source *source, uint32_t lanes, struct mlrt_packet *packet);
    /* Makes the rays of all blocks of a tile. trace/read_tile.h */
    void (*read_packets)(const struct mlrt_source *source, struct mlrt_ray_tile *tile);
    /* Writes the results of a packet. hits/write_packet.h */
    void (*write_packet)(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                         uint32_t lanes, const struct mlrt_rectangle *block);
    /* Decides lanes of a packet that a filter left undecided. hits/close_calls.h */
    uint32_t (*decide_lanes)(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                             struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters);
};

/* Traces a block of at most 4x4 rays, and writes their results. */
typedef void mlrt_trace_block(const struct mlrt_job *job, struct mlrt_worker *worker,
                              const struct mlrt_rectangle *block, const struct entry_list *list);

/* The functions of an instruction set. */
struct mlrt_kernels {
    /* Traces the rays of a rectangle that starts at multiples of 4, and writes their results to frame and tile. */
    void (*trace_tile)(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area);
    int counts; /* the functions add to the worker's counters */

    const struct mlrt_picture_kernels *picture;

    /* Traces a block from the nodes of a list. Only the kernels of the kd-tree: mlrta/block.h */
    mlrt_trace_block *trace_block;

    /* The kernels of the kd-tree have none of the following. */

    /*
     * Traces one ray through a tree whose unit is 1. Returns the number of the triangle that it hits, whose corners are
     * at *corners, or MLRT_NONE. Kernels that count have NULL. trace/single_ray.h
     */
    uint32_t (*trace_ray)(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, struct mlrt_corners *corners);
    /*
     * Sets t, u, v and facing of one ray's hit. Returns 0 and sets nothing if the judge has to compute them.
     * hits/hit_numbers.h
     */
    int (*report_ray)(const struct mlrt_corners *corners, const float origin[3], const float direction[3],
                      struct mlrt_hit_report *report);
    /* The kernels whose report_ray is used; NULL = the judge is as fast. */
    const struct mlrt_kernels *reports;
    /*
     * Likewise for a ray that is brought into units. `skip` is the number of the triangle that the ray passes through.
     * Returns 0, and leaves *number, if float does not carry the ray there.
     */
    int (*trace_scaled_ray)(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, int any, uint32_t skip,
                            uint32_t *number);
    /*
     * Makes a bundle without rays of the cells of `side` x `side` pixels of a camera's picture (trace/camera_cells.h),
     * or of the tiles of points that rays from a light lead to (trace/point_cells.h). Returns 0 if that is not
     * possible.
     */
    int (*gather_cells)(const struct mlrt_job *job, const struct mlrt_rectangle *area, uint32_t side,
                        struct mlrt_bundle *bundle);
    /* Traces a bundle whose packets, or tiles, have no rays yet. trace/tile.h */
    void (*trace_cells)(const struct mlrt_job *job, struct mlrt_worker *worker, int is_open,
                        struct mlrt_bundle *bundle);
    /* Traces the packets `waiting` (bit per place) of a bundle's tile, whose rays are made. trace/tile.h */
    void (*trace_bundle)(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle,
                         uint32_t waiting);
    /* Makes the shadow rays of a packet's hits. Kernels that count have NULL. hits/shadow_packet.h */
    uint32_t (*make_shadow_packet)(const struct mlrt_job *job, const struct mlrt_packet *seen, uint32_t hit,
                                   struct mlrt_packet *packet);
};

/* Method ray, of any structure (hits/finish.c). */
extern const struct mlrt_kernels mlrt_kernels_ray;

/*
 * The Makefile says which of them are compiled; trace/structure.c and mlrta/structure.c have them by instruction set.
 */
extern const struct mlrt_kernels mlrt_kernels_kdtree, mlrt_kernels_kdtree_avx2, mlrt_kernels_kdtree_counting;
extern const struct mlrt_kernels mlrt_kernels_scalar_counting;
extern const struct mlrt_kernels mlrt_kernels_scalar, mlrt_kernels_sse, mlrt_kernels_avx2, mlrt_kernels_avx512;

/*
 * mlrt_plain_picture is compiled with the kernels that every processor of this kind runs. Kernels that count, and
 * those of the kd-tree, use it too.
 */
extern const struct mlrt_picture_kernels mlrt_plain_picture, mlrt_picture_avx2, mlrt_picture_avx512;

#endif
