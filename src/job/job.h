/* SPDX-License-Identifier: MIT */
/*
 * What one instruction set provides: a function that traces one tile of a picture of rays.
 */
#ifndef MLRT_JOB_JOB_H
#define MLRT_JOB_JOB_H

#include "job/hit_terms.h"
#include "job/write_arrays.h"
#include "rays/source.h"

/* Lights whose shadows a picture may have: one bit each. */
#define MLRT_LIGHT_LIMIT 8

/* What structures keep for a worker, and pass: trace/bundle.h, mlrta/setups.h. */
struct mlrt_bundle;
struct mlrt_bundle_cache;
struct mlrt_triangle_setup;

/* progress.h */
struct mlrt_progress;

/* One call of the interface, as all workers see it. */
struct mlrt_job {
    const struct mlrt_tree *tree;
    const struct mlrt_kernels *kernels;
    struct mlrt_source source;
    int32_t method; /* resolved: not DEFAULT */
    int32_t culling;
    int culling_check;
    /* What the multi-level method has beyond the paper. */
    int whole_tiles;
    int entry_lists;
    int shared_setups;
    int any;
    /* One ray in double, whatever its numbers: mlrt_trace_segment (run/trace_ray.h). */
    uint32_t (*trace_segment)(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                              mlrt_counters *counters);
    const struct mlrt_job *lights; /* of each light whose shadows are wanted: its source, and `any` */
    uint32_t light_count;
    uint32_t initial_tile_size;
    uint32_t minimum_tile_size;
    uint32_t split_divisor; /* pieces per side: the root of the split factor */
    struct mlrt_sink frame;
    int has_frame;
    uint32_t outputs; /* for the callback */
    mlrt_tile_callback callback;
    void *user;
};

/* What was found of two triangles: not that they lie in one plane (undecided.h). All 0 = empty entry: nobody asks about
 * a triangle and itself. */
struct mlrt_triangle_pair {
    uint32_t first;
    uint32_t second;
    int32_t differ; /* they surely do not lie in one plane */
    int32_t order;  /* from `apex`: +1 if the first is behind the second wherever a ray hits it, -1 if it is before */
    float apex[3];
};

/* A triangle, and one of the same plane (undecided.c). */
struct mlrt_known_plane {
    uint32_t number; /* MLRT_NONE = empty entry */
    uint32_t plane;
};

/*
 * As powers of two, how many of each are kept: few for few rays, which would not pay for clearing them. With 256 pairs
 * in place of 64, a picture of a room all of whose walls are there twice compares 1 % less of them anew.
 */
#define MLRT_KNOWN_PLANE_BITS 12
#define MLRT_FEW_PLANE_BITS   4
#define MLRT_PAIR_BITS        6
#define MLRT_FEW_PAIR_BITS    4

/* What one worker has to itself, in cache lines of its own. */

struct mlrt_worker {
    MLRT_ALIGNED(64) mlrt_counters counters;
    struct mlrt_triangle_pair *pairs; /* entry (first ^ second) & pair_mask */
    uint32_t pair_mask;               /* how many there are: a power of two, less one */
    struct mlrt_known_plane *planes;  /* entry number & plane_mask */
    uint32_t plane_mask;
    struct mlrt_triangle_setup *setups; /* mlrta/setups.h: entry number & setup_mask; for rays from `apex` */
    uint32_t setup_mask;                /* the kept part of the table: a power of two, less one */
    float apex[3];
    struct mlrt_sink tile; /* the callback's arrays, over the current tile; empty without a callback */
    /* trace/bundle.h: of closest hits; of any, as a picture's shadows go in turn with its tiles. */
    struct mlrt_bundle_cache *bundle_caches;
    uint32_t mask;            /* of all rays; MLRT_MASK_ALL if they have their own, or triangles have none */
    uint32_t open_bundles[2]; /* how many of the next tiles begin with open packets: of closest hits, of any */
    uint32_t lane_tiles[2];   /* how many of the next tiles go lane by lane: of closest hits, of any */
    uint32_t open_tiles;      /* of the next ones, how many begin with open cells (levels.c); squares likewise */
    uint32_t open_squares;
    struct mlrt_hit_term_cache hit_terms;
    uint32_t mesh; /* position of the one that was last hit */
    uint32_t tile_x;
    uint32_t tile_y;
    struct mlrt_progress *progress; /* stop.h; NULL = nobody wants to know */
    uint64_t environment;           /* floating-point environment of the caller */
    double pixels_told;             /* of the current item */
    uint32_t slow_steps;
    struct mlrt_scaled_packet *scaled; /* whose rays go alone, in units; else NULL */
    int stopped;                       /* the call is to end */
};

/* trace/ray_tile.h */
struct mlrt_rectangle;
struct mlrt_ray_tile;

/* How packets of a picture are read and written. */
struct mlrt_picture_kernels {
    /* The rays of a block, in two steps: `lanes` are those that exist. rays/fetch_block.h */
    void (*fetch_block)(const struct mlrt_source *source, const struct mlrt_rectangle *block, uint32_t lanes,
                        struct mlrt_packet *packet);
    void (*check_block)(const struct mlrt_source *source, uint32_t lanes, struct mlrt_packet *packet);
    /* Those of all blocks of a tile, in one. trace/read_tile.h */
    void (*read_packets)(const struct mlrt_source *source, struct mlrt_ray_tile *tile);
    /* Writes the results of a packet. write_packet.h */
    void (*write_packet)(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                         uint32_t lanes, const struct mlrt_rectangle *block);
};

struct mlrt_kernels {
    /* Traces the rays of a rectangle that starts at multiples of 4, and writes their results to frame and tile. */
    void (*trace_tile)(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area);
    int counts; /* it adds to the worker's counters */

    const struct mlrt_picture_kernels *picture;

    /* What follows is there for the hierarchy of boxes only. */

    /*
     * Traces one ray, and tells its hit: as mlrt_trace_ray, with structs of this version. `skip` is the number of the
     * triangle that the ray passes. Returns 0, having done nothing, if float does not carry the ray (trace/single_ray.h).
     * Kernels that count have NULL.
     */
    int (*trace_ray)(const struct mlrt_tree *tree, const mlrt_ray *ray, int any, uint32_t mask, uint32_t skip,
                     mlrt_hit *hit);
    /* Makes a bundle without rays out of a camera's picture; 0 if it cannot be. camera_cells.h */
    int (*gather_camera_cells)(const struct mlrt_job *job, const struct mlrt_rectangle *area, uint32_t side,
                               struct mlrt_bundle *bundle);
    /* Traces a bundle whose packets, or tiles, have no rays yet. trace/tile.h */
    void (*trace_cells)(const struct mlrt_job *job, struct mlrt_worker *worker, int is_open,
                        struct mlrt_bundle *bundle);
    /* Traces the packets `waiting` (bit per place) of a bundle's tile, whose rays are there. trace/tile.h */
    void (*trace_bundle)(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle,
                         uint32_t waiting);
    /* Makes rays from what a packet hit to a light. shadow_packet.h; those that count have NULL. */
    uint32_t (*make_shadow_packet)(const struct mlrt_job *job, const struct mlrt_packet *seen, uint32_t hit,
                                   struct mlrt_packet *packet);
};

/* Which of them there are: dispatch.c. */
extern const struct mlrt_kernels mlrt_kernels_kdtree, mlrt_kernels_scalar_counting;
extern const struct mlrt_kernels mlrt_kernels_scalar, mlrt_kernels_sse, mlrt_kernels_avx2, mlrt_kernels_avx512;

/* The plain ones every processor of this kind can run. Kernels that count, and those of the kd-tree, use these. */
extern const struct mlrt_picture_kernels mlrt_plain_picture, mlrt_picture_avx2, mlrt_picture_avx512;

#endif
