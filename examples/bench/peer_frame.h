/* SPDX-License-Identifier: MIT */
/* peer_frame.h - Embree's pictures of a scene, as bench makes them, for programs that have no tasks */
#ifndef PEER_FRAME_H
#define PEER_FRAME_H

#include "common/scene.h"
#include "shade.h"

struct peer_frame;

/* 1 = this program was built with Embree. */
int have_peer(void);

/*
 * Builds Embree's hierarchies, the default one and the robust one, over a scene that stays the caller's; a program that
 * was built without Embree can only use shade_job_of. Returns NULL after a message on stderr.
 */
struct peer_frame *open_peer_frame(const struct scene *scene, const mlrt_camera *camera);
void close_peer_frame(struct peer_frame *frame);

/*
 * Renders the picture by the calling thread, in the way that was fastest when each was tried once: into `rgba`, shaded,
 * or with rgba = NULL numbers into `triangles`. The sides of the picture must be multiples of 64.
 */
void render_peer_frame(struct peer_frame *frame, int robust, uint32_t *triangles, uint32_t *rgba);

/* What shades the library's tiles alike: shade_tile_of_ids. */
struct shade_job shade_job_of(const struct peer_frame *frame, uint32_t *rgba);

#endif
