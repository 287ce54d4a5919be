/* SPDX-License-Identifier: MIT */
/*
 * One number for everything: a hash over ids and bits of t, u, v of pictures and packets of procedural scenes. It is
 * the same on every machine, from every way of tracing; a change of it is a change of answers. The reference gave it
 * first.
 */
#include <stdlib.h>
#include <string.h>

#include "support.h"

#define GOLDEN 0x984850255297C12Du

enum { WIDTH = 80, HEIGHT = 60, COUNT = WIDTH * HEIGHT };

/* FNV-1a (Fowler, Noll, Vo), over the bytes of a number from the lowest up. */
static uint64_t hash_number(uint64_t hash, uint32_t number)
{
    for (int i = 0; i < 4; i++) hash = (hash ^ (number >> 8 * i & 0xFF)) * 0x100000001B3u;
    return hash;
}

static uint64_t hash_hits(uint64_t hash, const struct reference_hit *hits)
{
    for (int i = 0; i < COUNT; i++) {
        hash = hash_number(hash, hits[i].mesh);
        hash = hash_number(hash, hits[i].triangle);
        hash = hash_number(hash, bits_of_float(hits[i].t));
        hash = hash_number(hash, bits_of_float(hits[i].u));
        hash = hash_number(hash, bits_of_float(hits[i].v));
    }
    return hash;
}

struct golden_scene {
    struct fixture fixture;
    mlrt_camera camera;
    struct ray_list list;
};

enum { SCENES = 3 };

/* Cameras by numbers that are exact in float: no function of libm has a part in this. */
static mlrt_camera camera_at(float x, float y, float z, const float d00[3], const float dx[3], const float dy[3])
{
    mlrt_camera camera = {.struct_size = sizeof camera, .width = WIDTH, .height = HEIGHT, .eye = {x, y, z}};
    memcpy(camera.d00, d00, sizeof camera.d00);
    memcpy(camera.dx, dx, sizeof camera.dx);
    memcpy(camera.dy, dy, sizeof camera.dy);
    camera.sample_x = camera.sample_y = 0.5f;
    return camera;
}

static void make_scenes(struct golden_scene scenes[SCENES])
{
    static const char *const names[SCENES] = {"room", "scan:5000", "scan:40000"};
    const float d00[3] = {-0.625f, 0.46875f, -1}, dx[3] = {0.015625f, 0, 0.0009765625f}, dy[3] = {0, -0.015625f, 0};
    memset(scenes, 0, SCENES * sizeof *scenes);
    for (int s = 0; s < SCENES; s++) {
        scenes[s].fixture = fixture_of_example(names[s]);
        scenes[s].camera =
            s == 0 ? camera_at(0.5f, 1.5f, 2.25f, d00, dx, dy) : camera_at(0.25f, 0.125f, 4, d00, dx, dy);
        add_camera_rays(&scenes[s].list, &scenes[s].camera);
    }
}

static void free_scenes(struct golden_scene scenes[SCENES])
{
    for (int s = 0; s < SCENES; s++) {
        free_rays(&scenes[s].list);
        free_fixture(&scenes[s].fixture);
    }
}

static mlrt_hits outputs_of(struct reference_hit *hits)
{
    size_t stride = sizeof *hits;
    mlrt_hits out = {.struct_size = sizeof out,
                     .t = {&hits->t, stride, 0},
                     .u = {&hits->u, stride, 0},
                     .v = {&hits->v, stride, 0},
                     .mesh = {&hits->mesh, stride, 0},
                     .triangle = {&hits->triangle, stride, 0}};
    return out;
}

static void assert_golden(const char *what, uint64_t hash)
{
    if (hash != GOLDEN) fail_msg("%s: 0x%016llX", what, (unsigned long long)hash);
}

static void the_reference_gives_the_golden_number(void **state)
{
    (void)state;
    static struct reference_hit hits[COUNT];
    struct golden_scene scenes[SCENES];
    uint64_t hash = 0xCBF29CE484222325u;
    size_t hit_count = 0;
    make_scenes(scenes);
    for (int s = 0; s < SCENES; s++) {
        trace_reference(&scenes[s].fixture, &scenes[s].list, hits);
        for (int i = 0; i < COUNT; i++) hit_count += hits[i].mesh != MLRT_NONE;
        hash = hash_hits(hash, hits);
    }
    free_scenes(scenes);
    assert_true(hit_count > COUNT); // the cameras look at something
    assert_golden("reference", hash);
}

static void every_picture_gives_the_golden_number(void **state)
{
    (void)state;
    static struct reference_hit hits[COUNT];
    struct golden_scene scenes[SCENES];
    make_scenes(scenes);
    for (size_t v = 0; v < variant_count(); v++) {
        uint64_t hash = 0xCBF29CE484222325u;
        mlrt_trace_options options = variant_at(v)->options;
        options.pool = shared_pool(variant_at(v)->threads);
        for (int s = 0; s < SCENES; s++) {
            mlrt_hits out = outputs_of(hits);
            int32_t status = mlrt_render_tiles(variant_tree(variant_at(v), &scenes[s].fixture), &scenes[s].camera,
                                               &options, &out, NULL, NULL);
            assert_int_equal(status, MLRT_OK);
            hash = hash_hits(hash, hits);
        }
        assert_golden("picture", hash);
    }
    free_scenes(scenes);
}

static void every_packet_gives_the_golden_number(void **state)
{
    (void)state;
    static struct reference_hit hits[COUNT];
    struct golden_scene scenes[SCENES];
    make_scenes(scenes);
    for (size_t v = 0; v < variant_count(); v++) {
        uint64_t hash = 0xCBF29CE484222325u;
        mlrt_trace_options options = variant_at(v)->options;
        options.pool = shared_pool(variant_at(v)->threads);
        for (int s = 0; s < SCENES; s++) {
            scenes[s].list.row_length = v % 2 ? WIDTH : 0;
            mlrt_rays rays = public_rays(&scenes[s].list);
            mlrt_hits out = outputs_of(hits);
            assert_int_equal(mlrt_trace_packet(variant_tree(variant_at(v), &scenes[s].fixture), &rays, &options, &out),
                             MLRT_OK);
            hash = hash_hits(hash, hits);
        }
        assert_golden("packet", hash);
    }
    free_scenes(scenes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reference_gives_the_golden_number),
        cmocka_unit_test(every_picture_gives_the_golden_number),
        cmocka_unit_test(every_packet_gives_the_golden_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
