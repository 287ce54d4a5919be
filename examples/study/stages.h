/* SPDX-License-Identifier: MIT */
/*
 * stages.h - the number of (ray, triangle) pairs that each stage of the library decides
 *
 * The numbers come from the counters of mlrt.h. Every pair that the float filter tests is decided by it, or recognised
 * as an exact tie, or left to double precision, which leaves pairs that it cannot decide to exact arithmetic.
 */
#ifndef STAGES_H
#define STAGES_H

#include "generator.h"

struct stages {
    uint64_t float_count;
    uint64_t tie_count;
    uint64_t double_count;
    uint64_t exact_count;
    uint64_t test_count;           // (packet, triangle) tests
    uint64_t undecided_test_count; // of these, with at least one pair that the float filter could not decide
};

/* Traces the rays by the default method, tile (a picture from its camera), and counts. Returns the library's status. */
int32_t count_stages(const struct subject *subject, const struct ray_set *rays, struct stages *stages);

#endif
