/* SPDX-License-Identifier: MIT */
/*
 * stability.h - where methods start to fail: one parameter varies, all others stay as they are
 *
 *     aim       the targets of rays in the sphere: each generator
 *     shift     the sphere moved away from 0 by this much along each axis, rays with it: 0 .. 1e6 radii, where
 *               floats are further apart than the corners of triangles were
 *     scale     the sphere scaled, origins and directions with it: 1e-38 .. 1e38
 *     length    the sphere as it is, directions scaled: 1e-30 .. 1e30
 *     sliver    a flat sheet of triangles this many times as long as high: 1 .. 1e7
 *     grazing   a flat sheet, and rays at this angle to it: 90 .. 1e-6 degrees
 *
 * Rays of shift, scale and length are of the generator `surface`. Those of the sheets go to points inside its
 * triangles; for slivers from all sides, for grazing from one sheet's width away.
 */
#ifndef STABILITY_H
#define STABILITY_H

#include "common/options.h"
#include "measure.h"

struct stability_case {
    const char *scene;     // the mesh
    const char *condition; // like shift=1e3
};

typedef void (*stability_consumer)(void *user, const struct stability_case *which, const struct selection *selection,
                                   const struct measurement *measurements);

/*
 * Runs the sweeps whose names are listed, all if none is. Returns 0, or 1 after a message on stderr.
 */
int run_sweeps(const struct word_list *names, size_t ray_count, const struct selection *selection,
               stability_consumer consumer, void *user);

#endif
