/* SPDX-License-Identifier: MIT */
/* peer_frame.c - Embree's pictures of a scene: see peer_frame.h */
#include "peer_frame.h"

#include "common/timer.h"
#include "peer.h"

#include <math.h>
#include <stdlib.h>

struct peer_frame {
    struct subject subject; // its scene is the caller's
    struct peer *peers[2];  // fast and robust; NULL = there is no Embree
    int variants[2][2];     // the fastest of each, of numbers and of shaded pictures; -1 = not known yet
};

struct peer_frame *open_peer_frame(const struct scene *scene, const mlrt_camera *camera)
{
    struct peer_frame *frame = calloc(1, sizeof *frame);
    if (!frame) return NULL;
    frame->subject.scene = *scene;
    frame->subject.camera = *camera;
    frame->subject.pixel_count = (size_t)camera->width * camera->height;
    int failed = make_normals(&frame->subject);
    for (int robust = 0; robust < 2 && !failed && have_peer(); robust++) {
        const struct peer_settings settings = {.robust = robust, .quality = PEER_HIGH_QUALITY};
        frame->peers[robust] = create_peer(scene, &settings, NULL);
        frame->variants[robust][0] = frame->variants[robust][1] = -1;
        failed = !frame->peers[robust];
    }
    if (!failed) return frame;
    close_peer_frame(frame);
    return NULL;
}

void close_peer_frame(struct peer_frame *frame)
{
    if (!frame) return;
    for (int robust = 0; robust < 2; robust++) {
        if (frame->peers[robust]) destroy_peer(frame->peers[robust]);
    }
    free(frame->subject.normals);
    free(frame);
}

void render_peer_frame(struct peer_frame *frame, int robust, uint32_t *triangles, uint32_t *rgba)
{
    const struct task task = {.kind = rgba ? FRAME : PRIMARY, .subject = &frame->subject};
    const struct answers answers = {.triangles = rgba ? NULL : triangles, .rgba = rgba};
    int *fastest = &frame->variants[robust][rgba != NULL];
    double least = INFINITY;
    for (int variant = 0, is_known = *fastest >= 0; variant < PEER_VARIANT_COUNT && !is_known; variant++) {
        if (!peer_variant_name(task.kind, variant)) continue;
        const double start = thread_seconds_now();
        run_peer(frame->peers[robust], variant, &task, NULL, &answers);
        const double seconds = thread_seconds_now() - start;
        if (seconds < least) least = seconds, *fastest = variant;
    }
    run_peer(frame->peers[robust], *fastest, &task, NULL, &answers);
}

struct shade_job shade_job_of(const struct peer_frame *frame, uint32_t *rgba)
{
    return (struct shade_job){.camera = &frame->subject.camera,
                              .normals = frame->subject.normals,
                              .triangle_count = (uint32_t)frame->subject.scene.triangle_count,
                              .rgba = rgba};
}
