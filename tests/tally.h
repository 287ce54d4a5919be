/* SPDX-License-Identifier: MIT */
/*
 * Comparisons on a large scale: the reference once per ray, then every method and instruction set, each answer compared
 * bit for bit. Differences do not end the run: they are counted, and the first few are printed with their ray.
 */
#ifndef TESTS_TALLY_H
#define TESTS_TALLY_H

#include "support.h"

struct tally {
    uint64_t ray_count;        /* judged by the reference */
    uint64_t answer_count;     /* of the library, compared */
    uint64_t difference_count; /* of these */
    double reference_seconds;  /* of processor time */
    double library_seconds;
};

/* How many ways of tracing are compared. */
size_t tally_way_count(void);

/* trace_packet, closest hit and, if asked for, any hit; trace_ray for some of the rays. */
void tally_rays(struct tally *tally, const struct fixture *fixture, const struct ray_list *list, int with_any_hit);

/* trace_all_hits: the first hits of each ray, and how many there are. */
void tally_lists(struct tally *tally, const struct fixture *fixture, const struct ray_list *list);

/* render_tiles, closest and any hit, and trace_packet on what camera_rays writes. */
void tally_camera(struct tally *tally, const struct fixture *fixture, const mlrt_camera *camera);

/* occluded_points. `skip` has two per point. */
void tally_points(struct tally *tally, const struct fixture *fixture, const float *points, const uint32_t *skip,
                  size_t count, const mlrt_light *light);

/*
 * At least `ray_count` rays of all hostile kinds, with pictures, lights, lists and any-hit among them, in batches, or as many
 * as `seconds` of processor time allow. Batch n has the seed fixture->seed + n, which differences are printed with: as
 * `seed` it gives them again, first.
 */
void tally_hostile(struct tally *tally, const struct fixture *fixture, uint64_t ray_count, double seconds);

#endif
