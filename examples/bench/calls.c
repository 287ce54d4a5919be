/* SPDX-License-Identifier: MIT */
/* calls.c - what a call of few rays costs over the rays: see calls.h */
#define _POSIX_C_SOURCE 200809L
#include "calls.h"

#include "common/timer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#if defined(__x86_64__) && defined(__linux__)
#define CAN_STEP 1
#include <signal.h>
#else
#define CAN_STEP 0
#endif

enum { MOST = 16, BLOCKS = 256, RAYS = BLOCKS * MOST, ROUNDS = 4 };

/* ---- rays ---------------------------------------------------------------------------------------------------- */

enum rays_kind { MISS, CAMERA_BLOCK, RANDOM, RAYS_KINDS };
static const char *const rays_names[RAYS_KINDS] = {"miss", "camera", "random"};

static struct {
    struct {
        float origin[3], t_min, direction[3], t_max;
    } records[RAYS];
    float origins[RAYS][3], directions[RAYS][3], t_min[RAYS], t_max[RAYS];
    uint32_t skip[RAYS][2], mask[RAYS];
} given;

static struct {
    float t[RAYS], u[RAYS], v[RAYS];
    uint32_t mesh[RAYS], triangle[RAYS];
    int32_t facing[RAYS];
    uint8_t occluded[RAYS];
} found;

static uint32_t state = 1;

static float draw(float lo, float hi)
{
    state = state * 1664525u + 1013904223u;
    return lo + (hi - lo) * (float)(state >> 8) * 0x1p-24f;
}

static void make_rays(const struct subject *subject, enum rays_kind kind)
{
    const struct scene *scene = &subject->scene;
    float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < scene->vertex_count; i++) {
        for (int k = 0; k < 3; k++) {
            lo[k] = fminf(lo[k], scene->vertices[3 * i + k]);
            hi[k] = fmaxf(hi[k], scene->vertices[3 * i + k]);
        }
    }
    for (uint32_t i = 0; i < RAYS; i++) {
        float *o = given.origins[i], *d = given.directions[i];
        if (kind == CAMERA_BLOCK) { // blocks of 4x4 neighbouring pixels, from all over the picture
            const uint32_t side = (subject->camera.width - 4) / 16, block = i / MOST;
            camera_direction(&subject->camera, block % 16 * side + i % 4, block / 16 * side + i % MOST / 4, d);
            memcpy(o, subject->camera.eye, sizeof given.origins[i]);
        } else {
            for (int k = 0; k < 3; k++) {
                o[k] = kind == MISS ? hi[k] + draw(1, 2) * (hi[k] - lo[k]) : draw(lo[k], hi[k]);
                d[k] = kind == MISS ? draw(0.1f, 1) : draw(-1, 1);
            }
        }
        given.t_min[i] = 0;
        given.t_max[i] = INFINITY;
        given.skip[i][0] = given.skip[i][1] = MLRT_NONE;
        given.mask[i] = 0;
        memcpy(given.records[i].origin, o, sizeof given.origins[i]);
        memcpy(given.records[i].direction, d, sizeof given.directions[i]);
        given.records[i].t_min = 0;
        given.records[i].t_max = INFINITY;
    }
}

/* ---- calls --------------------------------------------------------------------------------------------------- */

enum call_kind {
    PLAIN,
    OPTIONS,
    ISA,
    ALL_RESULTS,
    ANY_HIT,
    LIMITS,
    SKIPS,
    MASKS,
    SHARED,
    ROWS,
    STRUCTS,
    ALL,
    CALL_KINDS
};
static const char *const call_names[CALL_KINDS] = {"plain", "options", "isa",   "results", "any",     "limits",
                                                   "skip",  "mask",    "group", "rows",    "structs", "all"};

struct call {
    const struct library *library;
    const mlrt_tree *tree;
    enum call_kind kind;
    uint32_t count; // 0: mlrt_trace_ray
    mlrt_trace_options options;
};

static int32_t call_packet(const struct call *call, uint32_t first)
{
    const enum call_kind kind = call->kind;
    mlrt_rays rays = {.struct_size = sizeof rays,
                      .count = call->count,
                      .origins = {given.origins[first], 0},
                      .directions = {given.directions[first], 0}};
    mlrt_hits hits = {
        .struct_size = sizeof hits, .t = {found.t + first, 0, 0}, .triangle = {found.triangle + first, 0, 0}};
    if (kind == LIMITS || kind == ALL) rays.t_min.data = given.t_min + first, rays.t_max.data = given.t_max + first;
    if (kind == SKIPS || kind == ALL) rays.skip.data = given.skip[first];
    if (kind == MASKS || kind == ALL) rays.mask.data = given.mask + first;
    if (kind == SHARED) rays.rays_per_origin = call->count;
    if (kind == ROWS) rays.row_length = 4;
    if (kind == STRUCTS) {
        rays.origins = (mlrt_const_array){given.records[first].origin, sizeof *given.records};
        rays.directions = (mlrt_const_array){given.records[first].direction, sizeof *given.records};
        rays.t_min = (mlrt_const_array){&given.records[first].t_min, sizeof *given.records};
        rays.t_max = (mlrt_const_array){&given.records[first].t_max, sizeof *given.records};
    }
    if (kind == ALL_RESULTS || kind == ALL) {
        hits.u.data = found.u + first, hits.v.data = found.v + first;
        hits.mesh.data = found.mesh + first, hits.facing.data = found.facing + first;
    }
    if (kind == ANY_HIT) {
        hits.t.data = hits.triangle.data = NULL;
        hits.occluded.data = found.occluded + first;
    }
    const int has_options = kind == OPTIONS || kind == ISA || kind == ANY_HIT || kind == ALL;
    return call->library->trace_packet(call->tree, &rays, has_options ? &call->options : NULL, &hits);
}

static int32_t call_single(const struct call *call, uint32_t i)
{
    mlrt_ray ray = {.struct_size = sizeof ray};
    mlrt_hit hit = {.struct_size = sizeof hit};
    memcpy(ray.origin, given.origins[i], sizeof ray.origin);
    memcpy(ray.direction, given.directions[i], sizeof ray.direction);
    return call->library->trace_ray(call->tree, &ray, call->kind == PLAIN ? NULL : &call->options, &hit);
}

// Nanoseconds of a call of the first `count` rays of a block; of as many calls of one ray each if `alone`.
static int time_calls(const struct call *call, int alone, double *nanoseconds)
{
    int32_t status = MLRT_OK;
    const double start = thread_seconds_now();
    for (uint32_t i = 0; i < ROUNDS * BLOCKS && status == MLRT_OK; i++) {
        const uint32_t first = i % BLOCKS * MOST;
        if (!alone) status = call_packet(call, first);
        for (uint32_t j = 0; alone && j < call->count && status == MLRT_OK; j++) status = call_single(call, first + j);
    }
    *nanoseconds = (thread_seconds_now() - start) * 1e9 / (ROUNDS * BLOCKS);
    return status != MLRT_OK;
}

/* ---- instructions -------------------------------------------------------------------------------------------- */

#if CAN_STEP
static volatile sig_atomic_t steps;

static void count_step(int signal)
{
    (void)signal;
    steps++;
}

// With the trap flag, the processor stops after each instruction.
static void set_trap_flag(int set)
{
    unsigned long flags;
    __asm__ volatile("pushfq; popq %0" : "=r"(flags));
    flags = set ? flags | 0x100 : flags & ~0x100ul;
    __asm__ volatile("pushq %0; popfq" : : "r"(flags) : "memory", "cc");
}

static int32_t trace_nothing(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                             mlrt_hit *hit)
{
    return (void)tree, (void)ray, (void)options, (void)hit, MLRT_OK;
}

static int32_t trace_no_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                               const mlrt_hits *hits)
{
    return (void)tree, (void)rays, (void)options, (void)hits, MLRT_OK;
}

static long count_steps(const struct call *call, int alone)
{
    steps = 0;
    set_trap_flag(1);
    if (alone) {
        (void)call_single(call, 0);
    } else {
        (void)call_packet(call, 0);
    }
    set_trap_flag(0);
    return steps;
}

// Instructions from call to return, for the first block. The caller's own are those of a call that does nothing.
static long count_instructions(const struct call *call, int alone)
{
    const struct library nothing = {.trace_ray = trace_nothing, .trace_packet = trace_no_packet};
    struct call empty = *call;
    empty.library = &nothing;
    const struct sigaction action = {.sa_handler = count_step};
    if (sigaction(SIGTRAP, &action, NULL)) return 0;
    return count_steps(call, alone) - count_steps(&empty, alone);
}
#else
static long count_instructions(const struct call *call, int alone)
{
    return (void)call, (void)alone, 0;
}
#endif

/* ---- the study ----------------------------------------------------------------------------------------------- */

static int study_call(const struct bench_settings *settings, const struct arena *arena, enum rays_kind rays,
                      enum call_kind kind, uint32_t count)
{
    double together[2][MAXIMUM_RUNS], alone[2][MAXIMUM_RUNS];
    struct call calls[2] = {{&this_library, arena->tree, kind, count, {.struct_size = sizeof(mlrt_trace_options)}}};
    if (kind == ISA || kind == ALL) calls[0].options.isa = MLRT_ISA_SSE;
    if (kind == ANY_HIT) calls[0].options.query = MLRT_QUERY_ANY;
    calls[1] = calls[0];
    calls[1].library = arena->old;
    calls[1].tree = arena->old_tree;
    const uint32_t libraries = arena->old_tree ? 2 : 1;
    for (uint32_t run = 0; run < settings->runs; run++) {
        for (uint32_t i = 0; i < libraries; i++) {
            if (time_calls(&calls[i], 1, &alone[i][run]) || time_calls(&calls[i], 0, &together[i][run])) return 1;
        }
    }
    for (uint32_t i = 0; i < libraries; i++) {
        const double call = median(together[i], settings->runs), single = median(alone[i], settings->runs);
        printf("%s,%s,%s,%s,%u,%.1f,%.1f,%.1f,%ld,%ld\n", arena->subject.name, i ? "old" : "mlrt", rays_names[rays],
               call_names[kind], (unsigned)count, call, single, call - single, count_instructions(&calls[i], 0),
               count_instructions(&calls[i], 1));
    }
    fflush(stdout);
    return 0;
}

static int study_calls_of(const struct bench_settings *settings, const char *word)
{
    static const uint32_t counts[] = {1, 2, 4, 5, 8, 12, 15, 16};
    struct arena arena;
    int failed = open_arena(settings, word, &arena) || set_size(&arena.subject, settings->size);
    for (int rays = 0; rays < RAYS_KINDS && !failed; rays++) {
        make_rays(&arena.subject, (enum rays_kind)rays);
        for (int kind = 0; kind < CALL_KINDS && !failed; kind++) {
            for (size_t i = 0; i < sizeof counts / sizeof *counts && !failed; i++) {
                failed = study_call(settings, &arena, (enum rays_kind)rays, (enum call_kind)kind, counts[i]);
            }
        }
    }
    close_arena(&arena);
    return failed;
}

int study_calls(const struct bench_settings *settings)
{
    int failed = 0;
    puts("scene,library,rays,call,count,ns,ns_alone,ns_over,instructions,instructions_of_one_alone");
    for (size_t i = 0; i < settings->scenes.count; i++) failed |= study_calls_of(settings, settings->scenes.words[i]);
    return failed;
}
