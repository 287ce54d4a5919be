/* SPDX-License-Identifier: MIT */
/*
 * Which packets of a tile go together: see packet_cells.h.
 */
#include "packet_cells.h"

#include <string.h>

#include "kernels/quad.h"

/* Parts of packets that cannot go as one are so wide at most. */
#define WIDEST_PART 0.03f

void mlrt_set_main_axis(const float direction[3], struct mlrt_cells *cells)
{
    const float x = fabsf(direction[0]), y = fabsf(direction[1]), z = fabsf(direction[2]);
    cells->main_axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    cells->sign = direction[cells->main_axis] < 0 ? -1.0f : 1.0f;
    memset(&cells->shear, 0, sizeof cells->shear);
}

void mlrt_set_shear(const struct mlrt_job *job, const float direction[3], const float origin[3],
                    struct mlrt_cells *cells)
{
    mlrt_make_shear(job->tree, &job->source, direction, origin, job->any, &cells->shear);
    cells->main_axis = cells->shear.main_axis;
    cells->sign = cells->shear.sign;
    cells->begin = 0;
    memcpy(cells->apex, cells->shear.centre, sizeof cells->apex);
}

/* Has the cells of a tile see things as a packet does. */
static void look_as(const struct mlrt_job *job, const struct mlrt_packet *packet, struct mlrt_cells *cells)
{
    const uint32_t lane = mlrt_lowest_bit(packet->active);
    const float direction[3] = {packet->direction[0][lane], packet->direction[1][lane], packet->direction[2][lane]};
    if (MLRT_LIKELY(packet->has_apex)) {
        mlrt_set_main_axis(direction, cells);
        memcpy(cells->apex, packet->apex, sizeof cells->apex);
    } else {
        const float origin[3] = {packet->origin[0][lane], packet->origin[1][lane], packet->origin[2][lane]};
        mlrt_set_shear(job, direction, origin, cells);
        cells->begin = INFINITY;
    }
}

/* Does a packet that is to go with others see things as these cells do? */
static int is_seen_so(const struct mlrt_packet *packet, const struct mlrt_cells *cells)
{
    if (MLRT_UNLIKELY(!packet->has_apex)) return mlrt_has_direction(packet, &cells->shear);
    return !mlrt_are_sheared(cells) && memcmp(packet->apex, cells->apex, sizeof cells->apex) == 0;
}

/* Of packets of these widths, those wider than MLRT_WIDE_FACTOR times most: than a quarter of them, as edges may be
 * many. */
static uint32_t find_widest(const float widths[MLRT_CELL_COUNT], uint32_t gathered, float *limit)
{
    float sorted[MLRT_CELL_COUNT] = {0};
    uint32_t count = 0, wide = 0;
    for (uint32_t left = gathered; left; left &= left - 1) {
        const float width = widths[mlrt_lowest_bit(left)];
        uint32_t at = count++;
        for (; at > 0 && sorted[at - 1] > width; --at) sorted[at] = sorted[at - 1];
        sorted[at] = width;
    }
    *limit = MLRT_WIDE_FACTOR * sorted[count / 4];
    for (uint32_t left = gathered; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        if (widths[place] > *limit) wide |= 1u << place;
    }
    return wide;
}

/* Of four cells, how wide they are over one axis; -inf where there is none. */
static f4 widths_over(const struct mlrt_slopes *slopes, int first)
{
    return f4_sub(f4_load(slopes->hi + first), f4_load(slopes->lo + first));
}

/*
 * Of the packets `gathered`, those far wider than most, which lie across an edge of what the tile is about: they would
 * meet all that lies between their rays. If there are any, *limit receives how wide the others are at most.
 */
static uint32_t find_wide_packets(const struct mlrt_cells *cells, uint32_t gathered, float *limit)
{
    MLRT_ALIGNED(16) float widths[MLRT_CELL_COUNT];
    f4 least = f4_set1(INFINITY), greatest = f4_set1(0);
    for (int i = 0; i < MLRT_CELL_COUNT; i += 4) {
        const f4 width = f4_max(widths_over(&cells->slopes[0], i), widths_over(&cells->slopes[1], i));
        f4_store(widths + i, width);
        least = f4_min(f4_abs(width), least);
        greatest = f4_max(width, greatest);
    }
    if (MLRT_LIKELY(f4_hmax(greatest) <= MLRT_WIDE_FACTOR * f4_hmin(least))) return 0;
    return find_widest(widths, gathered, limit);
}

uint32_t mlrt_gather_packets(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t waiting, uint32_t *wide,
                             float *width)
{
    struct mlrt_cells *cells = &tile->cells;
    look_as(job, &tile->packets[mlrt_lowest_bit(waiting)], cells);
    cells->closed = 0;
    mlrt_set_tile(tile, cells);
    tile->limits_below = 0;
    tile->has_ray_slopes = 0;
    uint32_t gathered = 0;
    for (uint32_t place = 0; place < MLRT_CELL_COUNT; ++place) {
        struct mlrt_packet *packet = &tile->packets[place];
        const int is_waiting = waiting >> place & 1;
        if (is_waiting && is_seen_so(packet, cells) && job->kernels->add_packet(tile, place)) {
            gathered |= 1u << place;
        } else {
            if (is_waiting && packet->shear) mlrt_unshear_packet(packet);
            mlrt_leave_out_cell(cells, place);
        }
    }
    *width = WIDEST_PART;
    *wide = find_wide_packets(cells, gathered, width);
    for (uint32_t left = *wide; left; left &= left - 1) mlrt_leave_out_cell(cells, mlrt_lowest_bit(left));
    cells->closed &= ~*wide;
    if (!gathered) *wide = waiting & (0u - waiting);
    return gathered & ~*wide;
}

uint32_t mlrt_lanes_near_first(const struct mlrt_packet *packet, uint32_t lanes, int main_axis, float width)
{
    const uint32_t first = mlrt_lowest_bit(lanes);
    uint32_t near = lanes;
    for (int side = 1; side < 3; ++side) {
        const float *direction = packet->direction[(main_axis + side) % 3], *depth = packet->direction[main_axis];
        const float slope = direction[first] / depth[first];
        for (uint32_t left = near & (near - 1); left; left &= left - 1) {
            const uint32_t lane = mlrt_lowest_bit(left);
            if (!(fabsf(direction[lane] / depth[lane] - slope) <= 0.5f * width)) near &= ~(1u << lane);
        }
    }
    return near;
}
