/* SPDX-License-Identifier: MIT */
/*
 * A tracing call (struct mlrt_job), the state of each of its workers, and the table of functions that an instruction
 * set provides.
 */
#ifndef MLRT_JOB_JOB_H
#define MLRT_JOB_JOB_H

#include "base/forms.h"
#include "base/tuning.h"
#include "exact/vector.h"
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

/* The caller's function that gets the results of tiles. */
struct mlrt_callback {
    mlrt_tile_callback function; /* NULL = none */
    void *user;
    uint32_t outputs; /* what it gets */
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
    struct mlrt_callback callback;
};

/*
 * Two triangles that surely do not lie in one plane (undecided.c). All 0 = empty entry, since a triangle is never
 * compared with itself.
 */
struct mlrt_triangle_pair {
    uint32_t first;
    uint32_t second;
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

/*
 * Terms of t, u and v that all rays share that hit one triangle, in double. A worker keeps some: that pays because the
 * next packets hit the same triangles if these are large. hits/hit_numbers.h has the formulas.
 */

/* The judge computes the numbers of hits whose D is not more than its size over this: that bounds the error of t. */
#define MLRT_GREATEST_D_SIZE 0x1p12

/*
 * The terms of a triangle. A size is the sum of the magnitudes of a vector's components, or a product of such sums; a
 * width is a bound of the error of a quotient with D, times |D|.
 */
struct mlrt_hit_terms {
    /* For all rays. */
    struct mlrt_vector corner;
    struct mlrt_vector side[2]; /* c-a and a-b */
    double side_size[2];
    struct mlrt_vector normal;
    double normal_size;
    /* For rays from one origin: N, and the vectors whose dot products with d are e_ca and e_ab. */
    float origin[3];
    double n;
    double n_width;
    struct mlrt_vector edge[2];
    double edge_width[2]; /* to be multiplied with the size of d */
};

#define MLRT_HIT_TERMS_COUNT 16

/* The terms of triangle `number` are in entry number % MLRT_HIT_TERMS_COUNT. */
struct mlrt_hit_term_cache {
    uint32_t numbers[MLRT_HIT_TERMS_COUNT]; /* of triangles; MLRT_NONE = empty entry */
    struct mlrt_hit_terms entries[MLRT_HIT_TERMS_COUNT];
};

/* How a worker looks up in the middle of an item (mlrt_is_stopped). */
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

/* rays/lone_ray.h */
struct mlrt_lone_ray;

/* The state of one worker, in cache lines of its own. */
struct mlrt_worker {
    MLRT_ALIGNED(64) mlrt_counters counters;
    struct mlrt_known_triangles known;
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

/* The functions of an instruction set, for one structure. They are all that is called through a table. */
struct mlrt_kernels {
    uint32_t width; /* floats of a vector */
    /* Traces the rays of a rectangle that starts at multiples of 4, and writes their results to frame and tile. */
    void (*trace_area)(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_rectangle *area);
    /*
     * Traces one ray in float, without counting, and sets the fields of the hit that its query writes. The unit of the
     * boxes is 1, and the ray meets the box of the scene. Returns MLRT_OK. The kernels of the kd-tree have NULL.
     * trace/one_ray.h
     */
    int32_t (*trace_ray)(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_hit *hit);
    /*
     * Likewise where the unit is not 1: brings the ray as it was given into units. If float does not carry it there,
     * this sets nothing and returns another status than MLRT_OK.
     */
    int32_t (*trace_ray_in_units)(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, mlrt_hit *hit);
};

/*
 * The Makefile says which of them are compiled; trace/structure.c and mlrta/structure.c have them by instruction set.
 */
extern const struct mlrt_kernels mlrt_kernels_kdtree_counting, mlrt_kernels_kdtree_sse, mlrt_kernels_kdtree_avx2;
extern const struct mlrt_kernels mlrt_kernels_scalar, mlrt_kernels_sse, mlrt_kernels_avx2, mlrt_kernels_avx512;

/* ---- job.c: what the kernels call that is compiled once ---- */

/* Sets the terms of a triangle, and of an origin. */
void mlrt_set_hit_terms(const struct mlrt_triangle *triangle, const float origin[3], struct mlrt_hit_terms *terms);

/* Progress is reported to the host in the middle of an item, and the host is asked whether it has ended the call. */

/*
 * Adds pixels that are done, and calls the host if it was not called for a millisecond (base/progress.h). Returns 1 if
 * the call is to end: from then on the worker's results are not used, and it may return with any. To be called in the
 * floating-point environment of the library.
 */
int mlrt_is_stopped(struct mlrt_worker *worker, double pixels);

/* Steps that take up to some microseconds ask the host in one of so many calls only. */
#define MLRT_SLOW_STEPS 64

/* As mlrt_is_stopped, for such a step, with no pixels done. */
static inline int mlrt_is_stopped_in_step(struct mlrt_worker *worker)
{
    if (!worker->watch.progress) return 0;
    if (++worker->watch.slow_steps % MLRT_SLOW_STEPS == 0) return mlrt_is_stopped(worker, 0);
    return worker->watch.stopped;
}

/* Rays that are traced one by one in double, and results without rays, which are written to frame and callback. */

/* Traces lanes of a packet one by one in double, and stores the triangles that they hit. `counters` may be NULL. */
void mlrt_trace_single_rays(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                            mlrt_counters *counters);

/* Writes misses to a rectangle of a picture. */
void mlrt_write_picture_misses(const struct mlrt_job *job, struct mlrt_worker *worker,
                               const struct mlrt_rectangle *tile);

/* Writes one value of `occluded` to a rectangle of a picture. */
void mlrt_write_picture_shadow(const struct mlrt_worker *worker, uint8_t shadow, const struct mlrt_rectangle *tile);

/* Writes the lights that do not reach the hits of a packet's lanes. */
void mlrt_write_packet_shadows(const struct mlrt_worker *worker, const uint8_t shadows[MLRT_PACKET_RAYS],
                               uint32_t lanes, const struct mlrt_rectangle *block);

#endif
