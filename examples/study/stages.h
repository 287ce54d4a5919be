/* SPDX-License-Identifier: MIT */
/*
 * stages.h - which stage of the library decides how many (ray, triangle) pairs
 *
 * The counters of mlrt.h, taken apart: every pair that the float filter looks at is decided by it, or recognised as an
 * exact tie, or handed to double precision, which hands on what it cannot tell to exact arithmetic.
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

/* Traces the rays by the multi-level method (a picture from its camera) and counts. Returns the library's status. */
int32_t count_stages(const struct subject *subject, const struct ray_set *rays, struct stages *stages);

#endif
