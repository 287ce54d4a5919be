/* SPDX-License-Identifier: MIT */
/*
 * peer.h - Embree 3, used as its manual advises for speed. In a build without Embree, have_peer returns 0
 *
 * It has high build quality, huge pages, flush-to-zero and denormals-are-zero while tracing, the coherent or incoherent
 * flag, and packets of 4x4 pixels; of the ways to call it the fastest one counts. "Fast" is the default scene, "robust"
 * has RTC_SCENE_FLAG_ROBUST. Results of streams stay in the order of the stream.
 *
 * Based on: "Embree: High Performance Ray Tracing Kernels 3.13", the manual, "Performance Recommendations".
 */
#ifndef PEER_H
#define PEER_H

#include "common/timer.h"
#include "crew.h"
#include "task.h"

enum { PEER_MEDIUM_QUALITY = 0, PEER_HIGH_QUALITY = 1 };

/* PEER_ISA_AUTO: all that the processor has. */
enum { PEER_ISA_AUTO, PEER_ISA_SSE, PEER_ISA_AVX, PEER_ISA_AVX2, PEER_ISA_AVX512 };

struct peer;

struct peer_settings {
    int robust;
    int quality;      /* PEER_*_QUALITY */
    uint32_t threads; /* of the builder; 0 = all */
    int32_t isa;      /* PEER_ISA_*: the widest instruction set it may use */
};

/* What it took. */
struct peer_build {
    struct span time;
    int64_t memory_size; /* held by the hierarchy, in bytes; the mesh stays the caller's and is not in it */
};

/* 1 = this program was built with it. */
int have_peer(void);

/* Builds over the scene's triangles. `build` may be NULL. Returns NULL after a message on stderr. */
struct peer *create_peer(const struct scene *scene, const struct peer_settings *settings, struct peer_build *build);

void destroy_peer(struct peer *peer);

/*
 * Ways to call it: so many rays at a time, or a stream; for frames each with its own normals or the table's; for rays
 * of renderers each with the coherent or the incoherent flag.
 */
enum { PEER_VARIANT_COUNT = 13 };

/* The name of a variant, or NULL if it cannot do tasks of this kind. */
const char *peer_variant_name(enum kind kind, int variant);

/* Traces all rays of the task, by the crew or, with crew = NULL, by the calling thread. */
void run_peer(const struct peer *peer, int variant, const struct task *task, struct crew *crew,
              const struct answers *answers);

#endif
