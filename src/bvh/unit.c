/* SPDX-License-Identifier: MIT */
/* The unit of a hierarchy of boxes: see unit.h. */
#include "bvh/unit.h"

#include <string.h>

#include "scene/reach.h"

/* The unit is 1 if the typical coordinate is within 2^-20 .. 2^20. */
#define USUAL_EXPONENT 20

/* Triangles with a coordinate of more than 2^16 times the typical one are not in the core. */
#define CORE_EXPONENT 16

/* Of so few, all may be met: one by one, in double, rays from far away would take longer than in float. */
#define FEW_TRIANGLES 256

/* At most so many triangles are sampled. */
#define SAMPLE_COUNT 4096

/* frexp's exponents of floats are -148 .. 128. Exponent e is counted at e - LEAST_EXPONENT. */
#define EXPONENT_COUNT 277
#define LEAST_EXPONENT (-148)

/* The greatest magnitude of a coordinate; 0 if a coordinate is not finite. */
static float size_of_triangle(const struct mlrt_triangle *triangle)
{
    uint32_t bits[9], greatest = 0;
    float size;
    memcpy(bits, triangle, sizeof bits);
    for (int i = 0; i < 9; ++i) {
        const uint32_t magnitude = bits[i] & 0x7FFFFFFF; /* in the order of floats, with NaNs last */
        greatest = magnitude > greatest ? magnitude : greatest;
    }
    memcpy(&size, &greatest, sizeof size);
    return size <= FLT_MAX ? size : 0;
}

/* frexp's exponent of a float that is not denormal is in its bits. */
static int exponent_of(float size)
{
    uint32_t bits;
    int exponent;
    memcpy(&bits, &size, sizeof bits);
    if (bits >> 23 != 0) return (int)(bits >> 23) - 126;
    (void)frexp((double)size, &exponent);
    return exponent;
}

static uint32_t sample_step(const struct mlrt_tree *tree)
{
    return tree->triangle_count / SAMPLE_COUNT + 1;
}

/* The median over the sample of the exponent of each triangle's greatest coordinate. */
static int typical_exponent(const struct mlrt_tree *tree)
{
    uint32_t counts[EXPONENT_COUNT] = {0}, total = 0, below = 0;
    for (uint32_t i = 0; i < tree->triangle_count; i += sample_step(tree)) {
        const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, i);
        const float size = size_of_triangle(&triangle);
        if (!(size > 0)) continue;
        ++counts[exponent_of(size) - LEAST_EXPONENT];
        ++total;
    }
    for (int i = 0; i < EXPONENT_COUNT && total > 0; ++i) {
        below += counts[i];
        if (2 * below >= total) return i + LEAST_EXPONENT;
    }
    return 0;
}

int mlrt_is_odd(const struct mlrt_tree *tree, uint32_t number)
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    struct mlrt_triangle in_units;
    return !mlrt_triangle_in_units(&triangle, tree->bvh.unit, &in_units);
}

int mlrt_set_bvh_unit(struct mlrt_tree *tree)
{
    const int typical = typical_exponent(tree);
    const int limited = typical < -120 ? -120 : typical > 120 ? 120 : typical; /* so that the unit is a normal float */
    const int is_usual = typical >= -USUAL_EXPONENT && typical <= USUAL_EXPONENT;
    tree->bvh.unit = is_usual ? 1 : (float)ldexp(1, -limited);
    return typical;
}

/* Sets the core of a hierarchy whose `whole` is set. */
static void find_core(struct mlrt_tree *tree, int typical)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    const double limit = ldexp(1, typical + CORE_EXPONENT);
    struct mlrt_box core = MLRT_NO_BOX;
    bvh->core = bvh->whole;
    if (mlrt_is_within(bvh->whole.lo, bvh->whole.hi, (float)(limit * bvh->unit))) return;
    for (uint32_t i = 0; i < tree->triangle_count; i += sample_step(tree)) {
        const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, i);
        const float size = size_of_triangle(&triangle);
        for (int corner = 0; corner < 3 && size > 0 && size <= limit; ++corner) {
            const float x[3] = {triangle.v[corner][0] * bvh->unit, triangle.v[corner][1] * bvh->unit,
                                triangle.v[corner][2] * bvh->unit};
            mlrt_extend_box(x, x, &core);
        }
    }
    for (int k = 0; k < 3; ++k) { /* the sample has triangles that are left out, and these may lie outside the bounds */
        if (core.lo[k] > bvh->core.lo[k]) bvh->core.lo[k] = core.lo[k];
        if (core.hi[k] < bvh->core.hi[k]) bvh->core.hi[k] = core.hi[k];
    }
}

void mlrt_set_bvh_extent(struct mlrt_tree *tree, int typical)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    for (int k = 0; k < 3; ++k) {
        bvh->whole.lo[k] = mlrt_low_in_units(tree->bounds.lo[k], bvh->unit);
        bvh->whole.hi[k] = mlrt_high_in_units(tree->bounds.hi[k], bvh->unit);
    }
    bvh->is_usual = bvh->unit == 1 && mlrt_is_within(bvh->whole.lo, bvh->whole.hi, MLRT_SAFE_MAX);
    find_core(tree, typical);
    bvh->reach = tree->triangle_count < FEW_TRIANGLES ? MLRT_SAFE_MAX : mlrt_reach_of(&bvh->core);
}
