/* SPDX-License-Identifier: MIT */
/*
 * measure.h - speed and wrong decisions of several methods on the same rays
 *
 * Each method answers all rays once; these answers are compared with the oracle's. Then the methods take turns, so that
 * a machine that slows down does so for all; the speed is that of the median run, in processor time of the thread. A
 * run reads the caller's arrays of origins and directions and writes an array of triangle numbers, on one thread. The
 * time to prepare tables and hierarchies does not count.
 */
#ifndef MEASURE_H
#define MEASURE_H

#include "method.h"
#include "oracle.h"

enum { MAXIMUM_METHODS = 32 };

struct selection {
    size_t count;
    const struct method *methods[MAXIMUM_METHODS];
};

/* A method that cannot trace these rays has ray_count 0. */
struct measurement {
    struct verdict verdict;
    double mrays; // millions of rays per second
};

/*
 * Prepares the methods for the subject, measures each on each set, and hands the results over, one set after the other.
 * `runs` 0: the run that is judged is the one that is timed. Answers of the library's own methods that differ from the
 * right ones are printed on stderr. Returns 0, or 1 after a message on stderr.
 */
typedef void (*measurement_consumer)(void *user, size_t set, const struct selection *selection,
                                     const struct measurement *measurements);
int measure_methods(struct subject *subject, const struct ray_set *sets, size_t set_count,
                    const struct selection *selection, uint32_t runs, measurement_consumer consumer, void *user);

#endif
