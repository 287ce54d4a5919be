/* SPDX-License-Identifier: MIT */
/*
 * Results on their way out: to the caller's frame, to the buffer of a tile callback, or to both.
 */
#ifndef MLRT_OUTPUT_H
#define MLRT_OUTPUT_H

#include "packet.h"
#include "predicate.h"

enum mlrt_channel {
    MLRT_CHANNEL_T,
    MLRT_CHANNEL_U,
    MLRT_CHANNEL_V,
    MLRT_CHANNEL_MESH,
    MLRT_CHANNEL_TRIANGLE,
    MLRT_CHANNEL_FACING,
    MLRT_CHANNEL_OCCLUDED,
    MLRT_CHANNEL_COUNT
};

/* Arrays over a picture, with resolved strides. data = NULL: not wanted. */
struct mlrt_sink {
    struct {
        unsigned char *data;
        size_t stride;
        size_t row_stride;
    } channel[MLRT_CHANNEL_COUNT];
};

/*
 * Checks and resolves a frame of `width` columns for a query. `packed_rows`: rows follow each other without gaps,
 * whatever the arrays' row_stride says (lists of rays).
 */
int32_t mlrt_make_sink(const mlrt_hits *hits, int any, uint32_t width, int packed_rows, struct mlrt_sink *sink);

/* Does the sink want anything? */
int mlrt_sink_is_empty(const struct mlrt_sink *sink);

/* Bytes of one element. */
size_t mlrt_channel_size(enum mlrt_channel channel);

/*
 * Writes the results of a packet's lanes `lanes`, whose block starts at (x, y) of the sink. The rays and nearest hits
 * are the packet's; with `any`, a lane with a triangle is occluded.
 */
void mlrt_write_packet(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lanes, uint32_t x,
                       uint32_t y, const struct mlrt_sink *sink);

/* Writes misses to a run of elements of one row. */
void mlrt_write_misses(uint32_t x, uint32_t y, uint32_t count, const struct mlrt_sink *sink);

/* Does the sink want nothing that differs between rays that hit the same triangle? */
int mlrt_sink_wants_ids_only(const struct mlrt_sink *sink);

/* Writes hits of one triangle to a run of elements of one row of such a sink. */
void mlrt_write_same_hits(const struct mlrt_tree *tree, uint32_t number, uint32_t x, uint32_t y, uint32_t count,
                          const struct mlrt_sink *sink);

/* The ray of a lane. */
void mlrt_get_segment(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_ray_segment *ray);

/* The position of the mesh that a triangle number belongs to. */
uint32_t mlrt_mesh_of_triangle(const struct mlrt_tree *tree, uint32_t number);

/* The ids that a triangle number is reported by; those of a miss for MLRT_NONE. */
void mlrt_find_ids(const struct mlrt_tree *tree, uint32_t number, uint32_t *mesh, uint32_t *triangle);

#endif
