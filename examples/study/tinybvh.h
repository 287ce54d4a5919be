/* SPDX-License-Identifier: MIT */
/* tinybvh.h - J. Bikker's tinybvh (C++, one header) behind functions of C */
#ifndef TINYBVH_H
#define TINYBVH_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct tinybvh_scene;

/*
 * Its hierarchy for CPUs, 8 wide, by its builder of high quality. The arrays are copied. NULL = it cannot be built:
 * then all rays count as misses.
 */
struct tinybvh_scene *tinybvh_create(const float *vertices, size_t vertex_count, const uint32_t *indices,
                                     size_t triangle_count);

/* The triangle that each ray hits, or `miss`, and the distance; t may be NULL. */
void tinybvh_trace(const struct tinybvh_scene *scene, const float (*origins)[3], const float (*directions)[3],
                   size_t count, uint32_t miss, uint32_t *triangles, float *t);

void tinybvh_destroy(struct tinybvh_scene *scene);

#ifdef __cplusplus
}
#endif

#endif
