/* SPDX-License-Identifier: MIT */
/* What rays share of t, u and v: see hit_terms.h. */
#include "hit_terms.h"

#include <math.h>
#include <string.h>

static void cross_product(const double a[3], const double b[3], double cross[3])
{
    for (int k = 0; k < 3; ++k) cross[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static double size_of(const double a[3])
{
    return fabs(a[0]) + fabs(a[1]) + fabs(a[2]);
}

/* In the order of kernels/hit_numbers.h, though other roundings would do as well. */
static void set_up_terms(const struct mlrt_triangle *triangle, const float apex[3], double term[MLRT_HIT_TERM_COUNT])
{
    const double *normal = term + MLRT_HIT_NORMAL;
    double ab[3], ac[3], p[3];
    for (int k = 0; k < 3; ++k) {
        ab[k] = (double)triangle->v[1][k] - triangle->v[0][k];
        ac[k] = (double)triangle->v[2][k] - triangle->v[0][k];
        p[k] = (double)triangle->v[0][k] - apex[k];
    }
    cross_product(ab, ac, term + MLRT_HIT_NORMAL);
    cross_product(ac, p, term + MLRT_HIT_EDGE);
    cross_product(p, ab, term + MLRT_HIT_EDGE + 3);
    term[MLRT_HIT_NORMAL_SIZE] = size_of(ab) * size_of(ac);
    term[MLRT_HIT_N] = p[0] * normal[0] + p[1] * normal[1] + p[2] * normal[2];
    term[MLRT_HIT_N_SIZE] = size_of(p) * term[MLRT_HIT_NORMAL_SIZE];
    term[MLRT_HIT_EDGE_SIZE] = size_of(ac) * size_of(p);
    term[MLRT_HIT_EDGE_SIZE + 1] = size_of(p) * size_of(ab);
}

const struct mlrt_hit_terms *mlrt_find_hit_terms(const struct mlrt_tree *tree, uint32_t number, const float apex[3],
                                                 struct mlrt_hit_term_cache *cache)
{
    if (memcmp(apex, cache->apex, sizeof cache->apex) != 0) {
        for (int i = 0; i < MLRT_HIT_TERMS_COUNT; ++i) cache->entries[i].number = MLRT_NONE;
        memcpy(cache->apex, apex, sizeof cache->apex);
    }
    struct mlrt_hit_terms *terms = &cache->entries[number % MLRT_HIT_TERMS_COUNT];
    if (terms->number != number) {
        set_up_terms(&tree->triangles[number], apex, terms->term);
        terms->number = number;
    }
    return terms;
}
