/* SPDX-License-Identifier: MIT */
/*
 * What all rays of one apex that hit one triangle share of t, u and v, in double, as a worker keeps it: the next tile
 * hits the same triangles, if they are large. kernels/hit_numbers.h has the formulas.
 */
#ifndef MLRT_HIT_TERMS_H
#define MLRT_HIT_TERMS_H

#include "kdtree.h"

/* Which is which: the normal, N, and the vectors of e_ca and e_ab before their product with d. A size is the same with
 * all factors and sums positive; a width is what the quotient with D may be off by, times |D|. Those of D, e_ca and e_ab are
 * still to be multiplied with the size of d. */
enum mlrt_hit_term {
    MLRT_HIT_NORMAL,
    MLRT_HIT_NORMAL_SIZE = 3,
    MLRT_HIT_N,
    MLRT_HIT_N_WIDTH,
    MLRT_HIT_EDGE, /* two times three: only u and v need them */
    MLRT_HIT_EDGE_WIDTH = MLRT_HIT_EDGE + 6,
    MLRT_HIT_TERM_COUNT = MLRT_HIT_EDGE_WIDTH + 2
};

struct mlrt_hit_terms {
    uint32_t number; /* of the triangle; MLRT_NONE = empty entry */
    double term[MLRT_HIT_TERM_COUNT];
};

#define MLRT_HIT_TERMS_COUNT 16

/* Those that were wanted last, from one apex. */
struct mlrt_hit_term_cache {
    struct mlrt_hit_terms entries[MLRT_HIT_TERMS_COUNT]; /* number % MLRT_HIT_TERMS_COUNT */
    float apex[3];
};

#endif
