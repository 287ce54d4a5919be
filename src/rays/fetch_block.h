/* SPDX-License-Identifier: MIT */
/* The rays of a block, of any source. */
#ifndef MLRT_RAYS_FETCH_BLOCK_H
#define MLRT_RAYS_FETCH_BLOCK_H

#include <string.h>

#include "rays/check_packet.h"
#include "rays/rectangle.h"
#include "simd/simd.h"

/*
 * The rays of a camera's block, by the formula of camera.h with the same bits. Those of a pinhole camera are checked,
 * those of a parallel one are not.
 */
static void get_camera_packet(const mlrt_camera *view, uint32_t x, uint32_t y, uint32_t lanes,
                              struct mlrt_packet *packet)
{
    const int is_parallel = mlrt_is_parallel(view);
    float(*points)[MLRT_PACKET_RAYS] = is_parallel ? packet->origin : packet->direction;
    const vf x0 = v_set1((float)(view->crop_x + x)), y0 = v_set1((float)(view->crop_y + y));
    memcpy(packet->apex, view->eye, sizeof packet->apex);
    packet->has.apex = !is_parallel;
    packet->has.skip = packet->has.masks = 0;
    packet->has.limits = view->t_min > 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf xs = v_add(v_add(x0, v_load(mlrt_lane_x + v)), v_set1(view->sample_x));
        const vf ys = v_add(v_add(y0, v_load(mlrt_lane_y + v)), v_set1(view->sample_y));
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            const vf row = v_add(v_set1(view->d00[k]), v_mul(xs, v_set1(view->dx[k])));
            const vf p = v_add(row, v_mul(ys, v_set1(view->dy[k])));
            if (is_parallel) v_store(packet->direction[k] + v, v_set1(view->direction[k]));
            v_store(points[k] + v, v_add(p, v_set1(0))); /* -0 becomes 0 */
        }
        take_limits(v_set1(view->t_min), v_set1(view->t_max), v, packet);
    }
    if (!is_parallel) check_vectors(view->t_min < view->t_max ? lanes : 0, packet);
}

/*
 * A block is read in two steps: fetch_block reads the numbers of its rays, check_block checks them. If many packets are
 * made, call fetch_block for all of them first. It stores in pieces what check_block loads as whole vectors; a load
 * that directly follows such stores has to wait for them.
 */
static void fetch_block(const struct mlrt_source *source, const struct mlrt_rectangle *block, uint32_t lanes,
                        struct mlrt_packet *packet)
{
    if (source->kind == MLRT_SOURCE_CAMERA) {
        get_camera_packet(&source->view, block->x, block->y, lanes, packet);
    } else {
        mlrt_fetch_packet(source, block->x, block->y, lanes, packet);
    }
}

static void check_block(const struct mlrt_source *source, uint32_t lanes, struct mlrt_packet *packet)
{
    if (!mlrt_is_pinhole(source)) check_packet(lanes, packet);
}

#endif
