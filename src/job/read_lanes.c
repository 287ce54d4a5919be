/* SPDX-License-Identifier: MIT */
/* See read_lanes.h. */
#include "job/read_lanes.h"

void mlrt_get_segment(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_ray_segment *ray)
{
    for (int k = 0; k < 3; ++k) {
        ray->origin[k] = packet->has.apex ? packet->apex[k] : packet->origin[k][lane];
        ray->direction[k] = packet->direction[k][lane];
    }
    ray->t_min = packet->t_min[lane];
    ray->t_max = packet->t_max[lane];
    ray->mask = packet->has.masks ? packet->mask[lane] : MLRT_MASK_ALL;
}

void mlrt_gather_corners(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                         float corners[9][MLRT_PACKET_RAYS])
{
    const uint32_t standard = packet->nearest.triangle[mlrt_lowest_bit(hit)];
    const float inverse_unit = tree->by_number.inverse_unit;
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const uint32_t number = hit >> lane & 1 ? packet->nearest.triangle[lane] : standard;
        const struct mlrt_corners from = mlrt_corners_of(&tree->by_number, number);
        const size_t row = from.row;
        MLRT_UNROLL
        for (size_t i = 0; i < 9; ++i) corners[i][lane] = from.corner[i * row];
        if (MLRT_LIKELY(inverse_unit == 1) || !from.in_units) continue;
        for (size_t i = 0; i < 9; ++i) corners[i][lane] *= inverse_unit;
    }
}

void mlrt_report_lane(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lane, uint32_t outputs,
                      struct mlrt_packet_values *values)
{
    struct mlrt_ray_segment ray;
    mlrt_hit hit = {.struct_size = 0};
    mlrt_get_segment(packet, lane, &ray);
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, packet->nearest.triangle[lane]);
    mlrt_report_hit(&ray, &triangle, outputs, &hit);
    values->t[lane] = hit.t;
    values->uv[0][lane] = hit.u;
    values->uv[1][lane] = hit.v;
    values->facing[lane] = (uint32_t)hit.facing;
}
