/* SPDX-License-Identifier: MIT */
/*
 * What reads the rays of packets, in each instruction set, one object for each.
 */
#ifndef READ_H
#define READ_H

#include "trace/ray_tile.h"

struct readers {
    void (*fetch_block)(const struct mlrt_source *source, const struct mlrt_rectangle *block, uint32_t lanes,
                        struct mlrt_packet *packet);
    void (*check_block)(const struct mlrt_source *source, uint32_t lanes, struct mlrt_packet *packet);
    uint32_t (*read_packets)(const struct mlrt_source *source, struct mlrt_ray_tile *tile);
};

extern const struct readers readers_scalar, readers_sse, readers_avx2, readers_avx512, readers_neon;

/* Those of an instruction set; NULL if this machine lacks it. */
const struct readers *readers_of(int32_t isa);

#endif
