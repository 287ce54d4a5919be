/* SPDX-License-Identifier: MIT */
/*
 * method.h - a method: a way to find out which triangles rays hit
 *
 * Methods of others are of two kinds. Triangle tests from the literature share one traversal of the library's kd-tree
 * (traversal.h), so that such methods differ in the test alone; traversal and tests are plain C, one ray at a time. A
 * library (Embree, tinybvh) has a structure of its own. The methods of this library are called through its public
 * interface.
 */
#ifndef METHOD_H
#define METHOD_H

#include "generator.h"

struct method_run;

/* Where answers go: an element for each ray. */
struct answers {
    uint32_t *triangles; // MLRT_NONE for a miss
    float *t;            // of the hit, as the method gives it; NULL = not wanted
};

struct method {
    const char *name;  // on the command line and in CSV files
    const char *title; // for people
    int is_ours;
    int needs_camera; // 1 = traces pictures only: the camera, not the rays that were written out
    int32_t variant;  // what tells methods of one file apart

    /* Prepares run->state. Returns 0, or 1 after a message on stderr. NULL = nothing to prepare. */
    int (*create)(struct method_run *run);

    /* Finds what each ray hits. Called in the default floating-point environment. */
    void (*trace)(const struct method_run *run, const struct ray_set *rays, const struct answers *answers);

    void (*destroy)(struct method_run *run); // NULL = nothing to free
};

/* A method that is prepared for a subject. */
struct method_run {
    const struct method *method;
    const struct subject *subject;
    void *state;
    float largest; // magnitude of a component of an origin or direction among the rays that come next
};

/*
 * All methods, in the order in which results are listed. Those of Embree and tinybvh are missing where they
 * were not there to build with.
 */
size_t method_count(void);
const struct method *method_at(size_t i);

/* The word, which ends at a comma or its 0, as a method; NULL = there is none. */
const struct method *find_method(const char *word);

/* The parts of the list, each from the file that is named after it; ended by an entry without a name. */
extern const struct method moeller_trumbore_methods[];
extern const struct method watertight_methods[];
extern const struct method pluecker_methods[];
extern const struct method projection_methods[];
extern const struct method box_walk_methods[];
extern const struct method embree_methods[];
extern const struct method tinybvh_methods[];
extern const struct method guess_methods[];
extern const struct method library_methods[];

#endif
