/* SPDX-License-Identifier: MIT */
#include "golden.h"

#include <string.h>

/* FNV-1a (Fowler, Noll, Vo), over the bytes of a number from the lowest up. */
static uint64_t hash_number(uint64_t hash, uint32_t number)
{
    for (int i = 0; i < 4; i++) hash = (hash ^ (number >> 8 * i & 0xFF)) * 0x100000001B3u;
    return hash;
}

static uint64_t hash_float(uint64_t hash, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return hash_number(hash, bits);
}

uint64_t hash_golden_hits(uint64_t hash, const struct golden_hit hits[GOLDEN_COUNT])
{
    for (int i = 0; i < GOLDEN_COUNT; i++) {
        hash = hash_number(hash, hits[i].mesh);
        hash = hash_number(hash, hits[i].triangle);
        hash = hash_float(hash, hits[i].t);
        hash = hash_float(hash, hits[i].u);
        hash = hash_float(hash, hits[i].v);
    }
    return hash;
}

const char *golden_scene(int scene)
{
    static const char *const names[GOLDEN_SCENES] = {"room", "scan:5000", "scan:40000"};
    return names[scene];
}

/* Cameras by numbers that are exact in float: no function of libm has a part in this. */
mlrt_camera golden_camera(int scene)
{
    static const float room_eye[3] = {0.5f, 1.5f, 2.25f}, scan_eye[3] = {0.25f, 0.125f, 4};
    static const float d00[3] = {-0.625f, 0.46875f, -1}, dx[3] = {0.015625f, 0, 0.0009765625f},
                       dy[3] = {0, -0.015625f, 0};
    mlrt_camera camera = {.struct_size = sizeof camera, .width = GOLDEN_WIDTH, .height = GOLDEN_HEIGHT};
    memcpy(camera.eye, scene == 0 ? room_eye : scan_eye, sizeof camera.eye);
    memcpy(camera.d00, d00, sizeof camera.d00);
    memcpy(camera.dx, dx, sizeof camera.dx);
    memcpy(camera.dy, dy, sizeof camera.dy);
    camera.sample_x = camera.sample_y = 0.5f;
    return camera;
}

static mlrt_hits outputs_of(struct golden_hit *hits)
{
    size_t stride = sizeof *hits;
    mlrt_hits out = {.struct_size = sizeof out,
                     .t = {&hits->t, stride, 0},
                     .u = {&hits->u, stride, 0},
                     .v = {&hits->v, stride, 0},
                     .mesh = {&hits->mesh, stride, 0},
                     .triangle = {&hits->triangle, stride, 0},
                     .facing = {&hits->facing, stride, 0}};
    return out;
}

int32_t golden_picture(const mlrt_tree *tree, int scene, const mlrt_trace_options *options,
                       struct golden_hit hits[GOLDEN_COUNT])
{
    mlrt_camera camera = golden_camera(scene);
    mlrt_hits out = outputs_of(hits);
    return mlrt_render_tiles(tree, &camera, options, &out, NULL, NULL);
}

struct golden_rays {
    float origins[GOLDEN_COUNT][3];
    float directions[GOLDEN_COUNT][3];
};

static int32_t write_rays(int scene, struct golden_rays *rays)
{
    mlrt_camera camera = golden_camera(scene);
    mlrt_array origins = {rays->origins, 0, 0}, directions = {rays->directions, 0, 0};
    return mlrt_camera_rays(&camera, &origins, &directions);
}

int32_t golden_packet(const mlrt_tree *tree, int scene, const mlrt_trace_options *options, uint32_t row_length,
                      struct golden_hit hits[GOLDEN_COUNT])
{
    static struct golden_rays list;
    int32_t status = write_rays(scene, &list);
    if (status != MLRT_OK) return status;
    mlrt_rays rays = {.struct_size = sizeof rays,
                      .row_length = row_length,
                      .count = GOLDEN_COUNT,
                      .origins = {list.origins, 0},
                      .directions = {list.directions, 0}};
    mlrt_hits out = outputs_of(hits);
    return mlrt_trace_packet(tree, &rays, options, &out);
}

/* Which of the picture's points the light does not reach, the points being just off the side that the camera sees. */
static int32_t hash_shadows(uint64_t *hash, const mlrt_tree *tree, const mlrt_trace_options *options,
                            const struct golden_hit hits[GOLDEN_COUNT])
{
    static float points[GOLDEN_COUNT][3];
    static uint8_t occluded[GOLDEN_COUNT];
    memset(points, 0, sizeof points);
    for (int i = 0; i < GOLDEN_COUNT; i++) {
        if (hits[i].mesh == MLRT_NONE) continue;
        int32_t status =
            mlrt_offset_point(tree, hits[i].mesh, hits[i].triangle, hits[i].u, hits[i].v, -hits[i].facing, points[i]);
        if (status != MLRT_OK) return status;
        for (int k = 0; k < 3; k++) *hash = hash_float(*hash, points[i][k]);
    }
    mlrt_points list = {
        .struct_size = sizeof list, .row_length = GOLDEN_WIDTH, .count = GOLDEN_COUNT, .positions = {points, 0}};
    mlrt_light light = {.struct_size = sizeof light, .position = {1.25f, 2.25f, 0.75f}};
    mlrt_array out = {occluded, 0, 0};
    int32_t status = mlrt_occluded_points(tree, &list, &light, options, &out);
    for (int i = 0; i < GOLDEN_COUNT; i++) *hash = hash_number(*hash, occluded[i]);
    return status;
}

/* Which lights do not reach the picture's pixels, by the picture itself. */
static int32_t hash_lights(uint64_t *hash, const mlrt_tree *tree, int scene, const mlrt_trace_options *options)
{
    static uint8_t occluded[GOLDEN_COUNT];
    const mlrt_light lights[2] = {{sizeof *lights, MLRT_LIGHT_POINT, {1.25f, 2.25f, 0.75f}},
                                  {sizeof *lights, MLRT_LIGHT_DIRECTIONAL, {-0.25f, 1, 0.5f}}};
    mlrt_camera camera = golden_camera(scene);
    mlrt_trace_options lit = *options;
    lit.lights = lights;
    lit.light_count = 2;
    mlrt_hits frame = {.struct_size = sizeof frame, .occluded = {occluded, 0, 0}};
    int32_t status = mlrt_render_tiles(tree, &camera, &lit, &frame, NULL, NULL);
    for (int i = 0; i < GOLDEN_COUNT; i++) *hash = hash_number(*hash, occluded[i]);
    return status;
}

static int32_t hash_all_hits(uint64_t *hash, const mlrt_tree *tree, int scene)
{
    enum { CAPACITY = 4, STEP = 16, COUNT = GOLDEN_COUNT / STEP };
    static struct golden_rays list;
    static float t[COUNT][CAPACITY];
    static uint32_t triangles[COUNT][CAPACITY], totals[COUNT], crossings[COUNT];
    int32_t status = write_rays(scene, &list);
    if (status != MLRT_OK) return status;
    mlrt_rays rays = {.struct_size = sizeof rays,
                      .count = COUNT,
                      .origins = {list.origins, STEP * sizeof *list.origins},
                      .directions = {list.directions, STEP * sizeof *list.directions}};
    mlrt_hit_lists out = {.struct_size = sizeof out,
                          .capacity = CAPACITY,
                          .t = {t, 0, 0},
                          .triangle = {triangles, 0, 0},
                          .total = {totals, 0, 0},
                          .crossing_total = {crossings, 0, 0}};
    status = mlrt_trace_all_hits(tree, &rays, NULL, &out);
    if (status != MLRT_OK) return status;
    for (int i = 0; i < COUNT; i++) {
        for (int j = 0; j < CAPACITY; j++) *hash = hash_number(hash_float(*hash, t[i][j]), triangles[i][j]);
        *hash = hash_number(hash_number(*hash, totals[i]), crossings[i]);
    }
    return MLRT_OK;
}

int32_t hash_golden_rest(uint64_t *hash, const mlrt_tree *tree, int scene, const mlrt_trace_options *options)
{
    static struct golden_hit hits[GOLDEN_COUNT];
    mlrt_tree_info info = {.struct_size = sizeof info};
    int32_t status = mlrt_get_tree_info(tree, &info);
    *hash = hash_number(hash_number(*hash, (uint32_t)info.tree_hash), (uint32_t)(info.tree_hash >> 32));
    if (status == MLRT_OK) status = golden_picture(tree, scene, options, hits);
    if (status == MLRT_OK) status = hash_shadows(hash, tree, options, hits);
    if (status == MLRT_OK) status = hash_lights(hash, tree, scene, options);
    if (status == MLRT_OK) status = hash_all_hits(hash, tree, scene);
    return status;
}
