/* SPDX-License-Identifier: MIT */
/* embree.c - tasks done by Embree 3: see peer.h */
#include "peer.h"

#include <stdio.h>

#ifdef HAVE_EMBREE

#include "common/timer.h"

#include <embree3/rtcore.h>

#include <pmmintrin.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

enum { TILE_SIDE = 64, BATCH_SIZE = 4096, STREAM_PACKETS = 16, HALF_PAGE = 2048 };

struct peer {
    RTCDevice device;
    RTCScene scene;
    float *vertices; // as Embree reads them: four bytes behind the last one
    int64_t memory_size;
};

/* ---- building ------------------------------------------------------------------------------------------------ */

static bool count_memory(void *user, ssize_t bytes, bool post)
{
    (void)post;
    // Called by all the builder's threads.
    __atomic_fetch_add(&((struct peer *)user)->memory_size, (int64_t)bytes, __ATOMIC_RELAXED);
    return true;
}

static int share_mesh(const struct scene *scene, RTCGeometry geometry, struct peer *peer)
{
    peer->vertices = malloc((3 * scene->vertex_count + 4) * sizeof *peer->vertices);
    if (!peer->vertices) return 1;
    memcpy(peer->vertices, scene->vertices, 3 * sizeof(float) * scene->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, peer->vertices, 0,
                               3 * sizeof(float), scene->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene->indices, 0,
                               3 * sizeof(uint32_t), scene->triangle_count);
    return 0;
}

static int build_scene(const struct scene *scene, const struct peer_settings *settings, struct peer *peer,
                       struct span *time)
{
    const enum RTCBuildQuality quality =
        settings->quality == PEER_HIGH_QUALITY ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
    RTCGeometry geometry = rtcNewGeometry(peer->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (share_mesh(scene, geometry, peer)) return 1;
    const struct span start = span_start();
    peer->scene = rtcNewScene(peer->device);
    rtcSetSceneFlags(peer->scene, settings->robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(peer->scene, quality);
    rtcSetGeometryBuildQuality(geometry, quality);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(peer->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(peer->scene);
    *time = span_since(start);
    return rtcGetDeviceError(peer->device) != RTC_ERROR_NONE;
}

int have_peer(void)
{
    return 1;
}

struct peer *create_peer(const struct scene *scene, const struct peer_settings *settings, struct peer_build *build)
{
    static const char *const isa_names[] = {"", ",isa=sse4.2", ",isa=avx", ",isa=avx2", ",isa=avx512"};
    char configuration[64];
    struct peer *peer = calloc(1, sizeof *peer);
    struct span time;
    snprintf(configuration, sizeof configuration, "hugepages=1,threads=%u%s", (unsigned)settings->threads,
             isa_names[settings->isa]);
    if (peer) peer->device = rtcNewDevice(configuration);
    if (!peer || !peer->device) {
        fprintf(stderr, "cannot start Embree\n");
        free(peer);
        return NULL;
    }
    rtcSetDeviceMemoryMonitorFunction(peer->device, count_memory, peer);
    if (build_scene(scene, settings, peer, &time)) {
        fprintf(stderr, "cannot build Embree's scene\n");
        destroy_peer(peer);
        return NULL;
    }
    if (build) *build = (struct peer_build){time, peer->memory_size};
    return peer;
}

void destroy_peer(struct peer *peer)
{
    if (!peer) return;
    if (peer->scene) rtcReleaseScene(peer->scene);
    if (peer->device) rtcReleaseDevice(peer->device);
    free(peer->vertices);
    free(peer);
}

/* ---- tracing ------------------------------------------------------------------------------------------------- */

/* A picture to trace. With `rgba` it is shaded, otherwise numbers go to `triangles`. */
struct picture {
    RTCScene scene;
    const mlrt_camera *camera;
    const struct normal *normals;
    uint32_t triangle_count;
    uint32_t *triangles, *rgba;
    uint8_t *occluded; // lit: without `rgba`
    int own_normals;
    float light[3];
    int32_t lane_columns[16], lane_rows[16]; // in memory: worked out from numbers of lanes they are not vectors
};

struct batch {
    RTCScene scene;
    const struct stream *stream;
    const struct answers *answers;
    struct RTCIntersectContext context;
};

static RTC_ALIGN(64) const int all_valid[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

// Where the lanes of packets 1, 2 and 4 pixels wide are.
static const int32_t all_lane_columns[5][16] = {
    [1] = {0}, [2] = {0, 1, 0, 1}, [4] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3}};
static const int32_t all_lane_rows[5][16] = {
    [1] = {0}, [2] = {0, 0, 1, 1}, [4] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3}};

#define WIDTH                                   1
#define SIDE_X                                  1
#define SIDE_Y                                  1
#define QUERY                                   RTCRayHit
#define NAME_RAY                                RTCRay
#define INTERSECT(valid, scene, context, query) rtcIntersect1(scene, context, query)
#define OCCLUDED(valid, scene, context, query)  rtcOccluded1(scene, context, query)
#define LANE(field, i)                          (*(&(field) + (i)))
#define NAME(word)                              word##_1
#include "embree_packet.h"

#define WIDTH          4
#define SIDE_X         2
#define SIDE_Y         2
#define QUERY          RTCRayHit4
#define NAME_RAY       RTCRay4
#define INTERSECT      rtcIntersect4
#define OCCLUDED       rtcOccluded4
#define LANE(field, i) (field)[i]
#define NAME(word)     word##_4
#include "embree_packet.h"

#define WIDTH          8
#define SIDE_X         4
#define SIDE_Y         2
#define QUERY          RTCRayHit8
#define NAME_RAY       RTCRay8
#define INTERSECT      rtcIntersect8
#define OCCLUDED       rtcOccluded8
#define LANE(field, i) (field)[i]
#define NAME(word)     word##_8
#include "embree_packet.h"

#define WIDTH          16
#define SIDE_X         4
#define SIDE_Y         4
#define QUERY          RTCRayHit16
#define NAME_RAY       RTCRay16
#define INTERSECT      rtcIntersect16
#define OCCLUDED       rtcOccluded16
#define LANE(field, i) (field)[i]
#define NAME(word)     word##_16
#include "embree_packet.h"

// Packets of 16 rays, 16 at a time, as a stream.
static void trace_closest_stream(const struct batch *batch, size_t first, size_t end)
{
    struct RTCIntersectContext context = batch->context;
    RTC_ALIGN(64) struct RTCRayHit16 queries[STREAM_PACKETS];
    memset(queries, 0, sizeof queries);
    for (int i = 0; i < STREAM_PACKETS; i++) start_stream_16(batch->stream, &queries[i].ray);
    while (first < end) {
        unsigned count = 0;
        for (; count < STREAM_PACKETS && first + 16 * count < end; count++) {
            read_rays_16(batch->stream, first + 16 * count, &queries[count].ray);
            start_hit_16(&queries[count]);
        }
        rtcIntersectNM(batch->scene, &context, (struct RTCRayHitN *)queries, 16, count, sizeof *queries);
        for (unsigned i = 0; i < count; i++, first += 16) store_hits_16(&queries[i], batch->answers, first);
    }
}

static void trace_any_stream(const struct batch *batch, size_t first, size_t end)
{
    struct RTCIntersectContext context = batch->context;
    RTC_ALIGN(64) struct RTCRay16 rays[STREAM_PACKETS];
    memset(rays, 0, sizeof rays);
    for (int i = 0; i < STREAM_PACKETS; i++) start_stream_16(batch->stream, &rays[i]);
    while (first < end) {
        unsigned count = 0;
        for (; count < STREAM_PACKETS && first + 16 * count < end; count++) {
            read_rays_16(batch->stream, first + 16 * count, &rays[count]);
        }
        rtcOccludedNM(batch->scene, &context, (struct RTCRayN *)rays, 16, count, sizeof *rays);
        for (unsigned k = 0; k < count; k++, first += 16) {
            for (int i = 0; i < 16; i++) batch->answers->occluded[first + (size_t)i] = rays[k].tfar[i] < 0;
        }
    }
}

/* ---- variants ------------------------------------------------------------------------------------------------ */

static const struct variant {
    const char *name;
    void (*picture)(const struct picture *picture, uint32_t column, uint32_t row);
    void (*closest)(const struct batch *batch, size_t first, size_t end);
    void (*any)(const struct batch *batch, size_t first, size_t end);
    void (*lit)(const struct picture *picture, uint32_t column, uint32_t row);
    int table;      // only frames, lit or not
    int incoherent; // only rays of renderers: these with the other flag
} variants[PEER_VARIANT_COUNT] = {
    {"16", trace_picture_16, trace_closest_16, trace_any_16, trace_lit_16, 0, 0},
    {"8", trace_picture_8, trace_closest_8, trace_any_8, trace_lit_8, 0, 0},
    {"4", trace_picture_4, trace_closest_4, trace_any_4, trace_lit_4, 0, 0},
    {"1", trace_picture_1, trace_closest_1, trace_any_1, trace_lit_1, 0, 0},
    {"NM", NULL, trace_closest_stream, trace_any_stream, NULL, 0, 0},
    {"16t", trace_picture_16, NULL, NULL, trace_lit_16, 1, 0},
    {"8t", trace_picture_8, NULL, NULL, trace_lit_8, 1, 0},
    {"4t", trace_picture_4, NULL, NULL, trace_lit_4, 1, 0},
    {"1t", trace_picture_1, NULL, NULL, trace_lit_1, 1, 0},
    {"16i", NULL, trace_closest_16, trace_any_16, NULL, 0, 1},
    {"8i", NULL, trace_closest_8, trace_any_8, NULL, 0, 1},
    {"4i", NULL, trace_closest_4, trace_any_4, NULL, 0, 1},
    {"NMi", NULL, trace_closest_stream, trace_any_stream, NULL, 0, 1},
};

const char *peer_variant_name(enum kind kind, int variant)
{
    const struct variant *v = &variants[variant];
    switch ((int)kind) {
    case FRAME:
        return v->picture ? v->name : NULL;
    case LIT:
    case LIT_LESS_FRAME:
        return v->lit ? v->name : NULL;
    case PRIMARY:
        return v->picture && !v->table ? v->name : NULL;
    case SINGLE:
    case SINGLE_ANY:
        return v->closest == trace_closest_1 ? v->name : NULL;
    default:
        return v->closest && (!v->incoherent || kind >= REACH) ? v->name : NULL;
    }
}

struct job {
    const struct variant *variant;
    struct picture picture;
    struct batch batch;
    uint32_t tiles_per_row;
    int is_lit;
    int any;
};

static void run_tile(const struct job *job, size_t item)
{
    const uint32_t column = (uint32_t)(item % job->tiles_per_row) * TILE_SIDE;
    const uint32_t row = (uint32_t)(item / job->tiles_per_row) * TILE_SIDE;
    (job->is_lit ? job->variant->lit : job->variant->picture)(&job->picture, column, row);
}

static void run_batch(const struct job *job, size_t item)
{
    const size_t count = (job->batch.stream->count + 15) / 16 * 16, first = item * BATCH_SIZE;
    const size_t end = first + BATCH_SIZE < count ? first + BATCH_SIZE : count;
    (job->any ? job->variant->any : job->variant->closest)(&job->batch, first, end);
}

static void run_item(void *user, size_t item)
{
    const struct job *job = user;
    const unsigned int saved = _mm_getcsr();
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    if (job->picture.camera)
        run_tile(job, item);
    else
        run_batch(job, item);
    _mm_setcsr(saved);
}

static size_t start_picture(const struct peer *peer, const struct task *task, const struct answers *answers,
                            struct job *job)
{
    const struct subject *subject = task->subject;
    job->picture = (struct picture){.scene = peer->scene,
                                    .camera = &subject->camera,
                                    .normals = subject->normals,
                                    .triangle_count = (uint32_t)subject->scene.triangle_count,
                                    .triangles = answers->triangles,
                                    .rgba = task->kind == PRIMARY ? NULL : answers->rgba,
                                    .occluded = answers->occluded,
                                    .own_normals = !job->variant->table};
    memcpy(job->picture.light, subject->light, sizeof job->picture.light);
    job->is_lit = task->kind == LIT;
    job->tiles_per_row = subject->camera.width / TILE_SIDE;
    return (size_t)job->tiles_per_row * (subject->camera.height / TILE_SIDE);
}

static size_t start_batches(const struct peer *peer, const struct task *task, const struct answers *answers,
                            struct job *job)
{
    job->batch = (struct batch){.scene = peer->scene, .stream = &task->stream, .answers = answers};
    rtcInitIntersectContext(&job->batch.context);
    job->batch.context.flags = task->kind == BOUNCE || is_single(task->kind) || job->variant->incoherent
                                   ? RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT
                                   : RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    job->any = is_yes_or_no(task->kind);
    return (task->stream.count + BATCH_SIZE - 1) / BATCH_SIZE;
}

void run_peer(const struct peer *peer, int variant, const struct task *task, struct crew *crew,
              const struct answers *answers)
{
    struct job job = {.variant = &variants[variant]};
    const size_t count =
        is_picture(task->kind) ? start_picture(peer, task, answers, &job) : start_batches(peer, task, answers, &job);
    run_crew(crew, count, run_item, &job);
}

#else

int have_peer(void)
{
    return 0;
}

struct peer *create_peer(const struct scene *scene, const struct peer_settings *settings, struct peer_build *build)
{
    (void)scene, (void)settings, (void)build;
    fprintf(stderr, "this program was built without Embree\n");
    return NULL;
}

void destroy_peer(struct peer *peer)
{
    (void)peer;
}

const char *peer_variant_name(enum kind kind, int variant)
{
    (void)kind, (void)variant;
    return NULL;
}

void run_peer(const struct peer *peer, int variant, const struct task *task, struct crew *crew,
              const struct answers *answers)
{
    (void)peer, (void)variant, (void)task, (void)crew, (void)answers;
}

#endif
