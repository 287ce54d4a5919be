/* SPDX-License-Identifier: MIT */
/*
 * embree.c - Embree 3 as a method: its own hierarchy, fast and robust, one ray and 16 rays at a time
 *
 * It is set up as its manual advises ("Performance Recommendations"): high build quality, flush-to-zero and
 * denormals-are-zero while tracing (restored afterwards, as the rest of the program needs the default environment), the
 * incoherent flag for single rays in no order, the coherent flag for pictures. Packets are 4x4 pixels of a picture, or
 * 16 successive rays. The interval is that of the library, 0 to infinity. "Robust" has RTC_SCENE_FLAG_ROBUST.
 *
 * Based on: "Embree: High Performance Ray Tracing Kernels 3.13", the manual; I. Wald et al., "Embree: A Kernel
 * Framework for Efficient CPU Ray Tracing", SIGGRAPH 2014.
 */
#include "method.h"

#ifdef HAVE_EMBREE

#include <embree3/rtcore.h>

#include <math.h>
#include <pmmintrin.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

enum { FAST = 0, ROBUST = 1, PACKETS = 2, WIDTH = 16, BLOCK_SIDE = 4 }; // FAST or ROBUST, and maybe PACKETS: a variant

#define SMALLEST_HIGH_QUALITY 1e-15f
#define LARGEST_VALID         1.844e18f // Embree's FLT_LARGE: it leaves out triangles that reach beyond

struct embree {
    RTCDevice device;
    RTCScene scene;
};

static int fill_geometry(const struct scene *scene, RTCGeometry geometry)
{
    void *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                             scene->vertex_count);
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                                            scene->triangle_count);
    if (!vertices || !indices) return 1;
    memcpy(vertices, scene->vertices, 3 * sizeof(float) * scene->vertex_count);
    memcpy(indices, scene->indices, 3 * sizeof(uint32_t) * scene->triangle_count);
    return 0;
}

/*
 * The builder of high quality, as Debian compiles it (3.13.5, assertions on), ends the program on tiny meshes when it
 * cuts a triangle in two. Meshes below this size get medium quality, which cuts none.
 */
static enum RTCBuildQuality safe_quality(const struct scene *scene)
{
    float minimum[3], maximum[3], size = 0;
    scene_bounds(scene, minimum, maximum);
    for (int k = 0; k < 3; k++) size = fmaxf(size, maximum[k] - minimum[k]);
    return size < SMALLEST_HIGH_QUALITY ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH;
}

static int create(struct method_run *run)
{
    enum RTCBuildQuality quality = safe_quality(&run->subject->scene);
    struct embree *embree = calloc(1, sizeof *embree);
    run->state = embree;
    if (embree) embree->device = rtcNewDevice(NULL);
    if (!embree || !embree->device) {
        fprintf(stderr, "%s: cannot start Embree\n", run->method->name);
        return 1;
    }
    embree->scene = rtcNewScene(embree->device);
    rtcSetSceneFlags(embree->scene, run->method->variant & ROBUST ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(embree->scene, quality);
    RTCGeometry geometry = rtcNewGeometry(embree->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, quality);
    int failed = fill_geometry(&run->subject->scene, geometry);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(embree->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(embree->scene);
    if (!failed && rtcGetDeviceError(embree->device) == RTC_ERROR_NONE) return 0;
    fprintf(stderr, "%s: cannot build Embree's scene of %s\n", run->method->name, run->subject->name);
    return 1;
}

static void destroy(struct method_run *run)
{
    struct embree *embree = run->state;
    if (embree && embree->scene) rtcReleaseScene(embree->scene);
    if (embree && embree->device) rtcReleaseDevice(embree->device);
    free(embree);
}

static void start_context(struct RTCIntersectContext *context, const struct ray_set *rays)
{
    rtcInitIntersectContext(context);
    context->flags = rays->row_length ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
}

static void trace_singly(RTCScene scene, const struct ray_set *rays, const struct answers *answers)
{
    struct RTCIntersectContext context;
    start_context(&context, rays);
    for (size_t i = 0; i < rays->count; i++) {
        const float *o = rays->origins[i], *d = rays->directions[i];
        struct RTCRayHit query;
        query.ray.org_x = o[0], query.ray.org_y = o[1], query.ray.org_z = o[2];
        query.ray.dir_x = d[0], query.ray.dir_y = d[1], query.ray.dir_z = d[2];
        query.ray.tnear = 0, query.ray.tfar = INFINITY, query.ray.time = 0;
        query.ray.mask = 0xFFFFFFFFu, query.ray.id = 0, query.ray.flags = 0;
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.primID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &query);
        answers->triangles[i] = query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? MLRT_NONE : query.hit.primID;
        if (answers->t) answers->t[i] = query.ray.tfar;
    }
}

// The rays of packet `number`: 4x4 pixels, or 16 rays in a row, fewer at the end of a list. Returns their number.
static int packet_members(const struct ray_set *rays, size_t number, size_t members[WIDTH])
{
    int count = 0;
    if (rays->row_length == 0) {
        for (size_t i = number * WIDTH; i < rays->count && count < WIDTH; i++) members[count++] = i;
        return count;
    }
    size_t blocks_per_row = rays->row_length / BLOCK_SIDE;
    size_t x = number % blocks_per_row * BLOCK_SIDE, y = number / blocks_per_row * BLOCK_SIDE;
    for (; count < WIDTH; count++) {
        members[count] = (y + (size_t)count / BLOCK_SIDE) * rays->row_length + x + (size_t)count % BLOCK_SIDE;
    }
    return count;
}

static void trace_packets(RTCScene scene, const struct ray_set *rays, const struct answers *answers)
{
    struct RTCIntersectContext context;
    start_context(&context, rays);
    for (size_t packet = 0; packet * WIDTH < rays->count; packet++) {
        size_t members[WIDTH];
        RTC_ALIGN(64) int valid[WIDTH];
        struct RTCRayHit16 query;
        int count = packet_members(rays, packet, members);
        for (int lane = 0; lane < WIDTH; lane++) {
            size_t i = members[lane < count ? lane : 0];
            const float *o = rays->origins[i], *d = rays->directions[i];
            valid[lane] = lane < count ? -1 : 0;
            query.ray.org_x[lane] = o[0], query.ray.org_y[lane] = o[1], query.ray.org_z[lane] = o[2];
            query.ray.dir_x[lane] = d[0], query.ray.dir_y[lane] = d[1], query.ray.dir_z[lane] = d[2];
            query.ray.tnear[lane] = 0, query.ray.tfar[lane] = INFINITY, query.ray.time[lane] = 0;
            query.ray.mask[lane] = 0xFFFFFFFFu, query.ray.id[lane] = 0, query.ray.flags[lane] = 0;
            query.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
            query.hit.primID[lane] = RTC_INVALID_GEOMETRY_ID;
            query.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect16(valid, scene, &context, &query);
        for (int lane = 0; lane < count; lane++) {
            int miss = query.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID;
            answers->triangles[members[lane]] = miss ? MLRT_NONE : query.hit.primID[lane];
            if (answers->t) answers->t[members[lane]] = query.ray.tfar[lane];
        }
    }
}

// Rays beyond Embree's range are not valid, and end the program where its assertions are compiled in: they count as
// misses.
static int is_valid(const struct ray_set *rays, size_t i)
{
    for (int k = 0; k < 3; k++) {
        if (fabsf(rays->origins[i][k]) > LARGEST_VALID || fabsf(rays->directions[i][k]) > LARGEST_VALID) return 0;
    }
    return 1;
}

static void trace_valid(RTCScene scene, const struct ray_set *rays, const struct answers *answers)
{
    for (size_t i = 0; i < rays->count; i++) {
        const struct ray_set one = {.count = 1, .origins = rays->origins + i, .directions = rays->directions + i};
        const struct answers its = {answers->triangles + i, answers->t ? answers->t + i : NULL};
        *its.triangles = MLRT_NONE;
        if (is_valid(rays, i)) trace_singly(scene, &one, &its);
    }
}

static void trace(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    const struct embree *embree = run->state;
    unsigned int saved = _mm_getcsr();
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    if (run->largest > LARGEST_VALID)
        trace_valid(embree->scene, rays, answers);
    else if (run->method->variant & PACKETS)
        trace_packets(embree->scene, rays, answers);
    else
        trace_singly(embree->scene, rays, answers);
    _mm_setcsr(saved);
}

const struct method embree_methods[] = {
    {"embree_fast", "Embree 3 fast, one ray", 0, 0, FAST, create, trace, destroy},
    {"embree_fast16", "Embree 3 fast, 16 rays", 0, 0, FAST | PACKETS, create, trace, destroy},
    {"embree_robust", "Embree 3 robust, one ray", 0, 0, ROBUST, create, trace, destroy},
    {"embree_robust16", "Embree 3 robust, 16 rays", 0, 0, ROBUST | PACKETS, create, trace, destroy},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};

#else

const struct method embree_methods[] = {{NULL, NULL, 0, 0, 0, NULL, NULL, NULL}};

#endif
