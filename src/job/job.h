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
#include "job/sink.h"
#include "rays/rectangle.h"
#include "rays/source.h"

/* State of workers that only one structure uses: trace/bundle.h and mlrta/setups.h. */
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

/* The caller's function that gets the results of tiles. */
struct mlrt_callback {
    mlrt_tile_callback function; /* NULL = none */
    void *user;
    uint32_t outputs; /* MLRT_OUTPUT_*: what it gets */
};

/* One call of the interface, as all workers see it. */
struct mlrt_job {
    const struct mlrt_tree *tree;
    const struct mlrt_kernels *kernels;
    struct mlrt_source source;
    int32_t method;                /* resolved: not DEFAULT */
    int any;                       /* any hit will do */
    const struct mlrt_job *lights; /* a job for each light: its source, with `any` set */
    uint32_t light_count;
    uint32_t initial_tile_size; /* the side of the tiles that workers claim, in pixels */
    struct mlrt_multilevel multilevel;
    struct mlrt_sink frame; /* the caller's arrays; empty if there are none */
    struct mlrt_callback callback;
};

/* Triangle `number` lies in the plane of triangle `plane` (undecided.c). */
struct mlrt_known_plane {
    uint32_t number; /* MLRT_NONE = empty entry */
    uint32_t plane;
};

/*
 * Logarithms (base 2) of how many planes a worker keeps. Calls of few rays keep few, since clearing a large table would
 * take longer than it saves.
 */
#define MLRT_KNOWN_PLANE_BITS 12
#define MLRT_FEW_PLANE_BITS   4

/* Which triangles lie in one plane, as far as a worker has found: neighbouring rays need the same (undecided.h). */
struct mlrt_known_planes {
    uint32_t plane_mask;             /* length of the table, a power of two, less one */
    struct mlrt_known_plane *planes; /* entry number & plane_mask */
};

/* How a worker reports progress in the middle of an item, and learns that the call is to end (stop.h). */
struct mlrt_watch {
    struct mlrt_progress *progress;  /* NULL = the host has no progress function */
    mlrt_fp_environment environment; /* that of the caller */
    double pixels_told;              /* pixels of the current item that progress has counted */
    uint32_t slow_steps;             /* counts calls of mlrt_is_stopped_in_step */
    int stopped;                     /* the call is to end */
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

/* Where a worker writes results. */
struct mlrt_worker_sinks {
    struct mlrt_sink tile;           /* the callback's arrays, over the current tile; empty without a callback */
    const struct mlrt_sink *each[2]; /* of frame and tile, those that are not empty */
    uint32_t count;
};

/* The state of one worker, in cache lines of its own. */
struct mlrt_worker {
    MLRT_ALIGNED(64) mlrt_counters counters;
    struct mlrt_known_planes known;
    /* What the kernels of the tree's structure keep (trace/bundle.h, mlrta/setups.h); the other is not set. */
    struct mlrt_bundles *bundles;
    struct mlrt_setups *setups;
    struct mlrt_worker_sinks sinks;
    uint32_t mask; /* of all rays; MLRT_MASK_ALL if each has its own, or triangles have none */
    struct mlrt_hit_term_cache hit_terms;
    uint32_t mesh; /* position of the mesh that was hit last */
    struct mlrt_watch watch;
    const struct mlrt_lone_ray *lone;  /* the only ray, while its packet is not filled (trace/units.h), else NULL */
    struct mlrt_scaled_packet *scaled; /* the packet in units while its rays go alone (trace/units.h), else NULL */
};

/* The functions of an instruction set, for one structure. All else of it is reached through them. */
struct mlrt_kernels {
    uint32_t width; /* floats of a vector */
    /* Traces the rays of a rectangle that starts at multiples of 4, and writes their results to frame and tile. */
    void (*trace_area)(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area);
    /*
     * Traces one ray in float, without counting, and sets the fields of the hit that its query writes. The ray meets
     * the box of the scene. Returns MLRT_OK. The kernels of the kd-tree have NULL. trace/lone_ray.h
     */
    int32_t (*trace_ray)(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_hit *hit);
};

/* The Makefile says which are compiled; trace/structure.c and mlrta/structure.c have them by instruction set. */
extern const struct mlrt_kernels mlrt_kernels_kdtree_scalar, mlrt_kernels_kdtree_sse, mlrt_kernels_kdtree_avx2;
extern const struct mlrt_kernels mlrt_kernels_scalar, mlrt_kernels_sse, mlrt_kernels_avx2, mlrt_kernels_avx512;
extern const struct mlrt_kernels mlrt_kernels_neon, mlrt_kernels_kdtree_neon;

#endif
