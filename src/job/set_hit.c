/* SPDX-License-Identifier: MIT */
/* See set_hit.h. */
#include "job/set_hit.h"

#include <math.h>
#include <string.h>

#include "job/sink.h"
#include "scene/triangle_numbers.h"

void mlrt_set_hit(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t number, uint32_t outputs,
                  mlrt_hit *hit)
{
    mlrt_set_miss(0, hit);
    if (number == MLRT_NONE) return;
    mlrt_find_ids(tree, number, &hit->mesh, &hit->triangle);
    if (!outputs) return;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    mlrt_report_hit(ray, &triangle, outputs, hit);
}

void mlrt_set_result(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, uint32_t number, mlrt_hit *hit)
{
    struct mlrt_ray_segment segment = {.t_max = INFINITY, .mask = MLRT_MASK_ALL};
    if (!ray->any) {
        memcpy(segment.origin, ray->given.origin, sizeof segment.origin);
        memcpy(segment.direction, ray->given.direction, sizeof segment.direction);
        mlrt_set_hit(tree, &segment, number, MLRT_OUTPUT_T | MLRT_OUTPUT_UV | MLRT_OUTPUT_FACING, hit);
    }
    hit->occluded = number != MLRT_NONE;
}

void mlrt_write_hits(const mlrt_hit *hits, size_t first, uint32_t count, const mlrt_hits *list)
{
    const mlrt_hit *const end = hits + count;
    for (int c = 0; c < MLRT_CHANNEL_OCCLUDED; ++c) {
        const mlrt_array *array = mlrt_array_of(list, (enum mlrt_channel)c);
        if (!array->data) continue;
        const size_t stride = mlrt_stride_of(array, (enum mlrt_channel)c);
        unsigned char *at = (unsigned char *)array->data + first * stride;
        for (const mlrt_hit *hit = hits; hit < end; ++hit, at += stride)
            memcpy(at, (const unsigned char *)&hit->t + 4 * c, 4);
    }
    if (!list->occluded.data) return;
    const size_t stride = mlrt_stride_of(&list->occluded, MLRT_CHANNEL_OCCLUDED);
    unsigned char *at = (unsigned char *)list->occluded.data + first * stride;
    for (const mlrt_hit *hit = hits; hit < end; ++hit, at += stride) *at = (uint8_t)hit->occluded;
}
