/* SPDX-License-Identifier: MIT */
/*
 * mlrt_camera_rays: the formula of a camera, step by step, and where the rays go.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { WIDTH = 9, HEIGHT = 7, COUNT = WIDTH * HEIGHT, GUARD = 0x5A };

static mlrt_camera some_camera(int32_t projection)
{
    mlrt_camera camera = {.struct_size = sizeof camera,
                          .projection = projection,
                          .width = WIDTH,
                          .height = HEIGHT,
                          .eye = {1, 2, 3},
                          .direction = {0.5f, -0.25f, 4},
                          .d00 = {-0.7f, 1.1f, 0.3f},
                          .dx = {0.1f, 0.03f, -0.001f},
                          .dy = {0.02f, -0.3f, 0.07f},
                          .sample_x = 0.3f,
                          .sample_y = 0.7f};
    return camera;
}

/* Compares all rays with the reference's arithmetic. */
static void assert_rays(const mlrt_camera *camera)
{
    struct ray_list list = {0};
    add_camera_rays(&list, camera);
    float *origins = allocate_or_fail(list.count, 12), *directions = allocate_or_fail(list.count, 12);
    mlrt_array out_origins = {origins, 0, 0}, out_directions = {directions, 0, 0};
    assert_int_equal(mlrt_camera_rays(camera, &out_origins, &out_directions), MLRT_OK);
    for (size_t i = 0; i < list.count; i++) {
        for (int k = 0; k < 3; k++) {
            assert_int_equal(bits_of_float(origins[3 * i + (size_t)k]), bits_of_float(list.rays[i].origin[k]));
            float d = directions[3 * i + (size_t)k], wanted = list.rays[i].direction[k];
            if (!isnan(wanted))
                assert_int_equal(bits_of_float(d), bits_of_float(wanted));
            else
                assert_true(isnan(d));
        }
    }
    free(origins);
    free(directions);
    free_rays(&list);
}

static void pinhole_rays_follow_the_formula(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
    assert_rays(&camera);
}

static void parallel_rays_follow_the_formula(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PARALLEL);
    assert_rays(&camera);
}

static void random_cameras_follow_the_formula(void **state)
{
    (void)state;
    struct random random = {1};
    for (int i = 0; i < 500; i++) {
        mlrt_camera camera = some_camera((int32_t)draw_below(&random, 2));
        for (int k = 0; k < 3; k++) {
            camera.d00[k] = draw_range(&random, -2, 2);
            camera.dx[k] = draw_range(&random, -0.1f, 0.1f);
            camera.dy[k] = draw_range(&random, -0.1f, 0.1f);
        }
        camera.sample_x = draw_range(&random, -1, 2);
        camera.sample_y = draw_range(&random, -1, 2);
        assert_rays(&camera);
    }
}

static void denormal_steps_follow_the_formula(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
    for (int k = 0; k < 3; k++) {
        camera.d00[k] = 1e-43f * (float)(k + 1);
        camera.dx[k] = 3e-44f;
        camera.dy[k] = -1e-42f * (float)(k - 1);
    }
    assert_rays(&camera);
}

static void products_that_underflow_are_rounded_once(void **state)
{
    (void)state;
    struct random random = {2};
    for (int i = 0; i < 200; i++) {
        mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
        for (int k = 0; k < 3; k++) {
            camera.d00[k] = draw_range(&random, -1e-38f, 1e-38f);
            camera.dx[k] = draw_range(&random, -1e-38f, 1e-38f);
            camera.dy[k] = draw_range(&random, -1e-38f, 1e-38f);
        }
        camera.sample_x = draw_range(&random, 0, 1);
        camera.sample_y = draw_range(&random, 0, 1);
        assert_rays(&camera);
    }
}

static void overflow_follows_the_formula(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
    camera.d00[0] = 3e38f;
    camera.dx[0] = 1e38f;
    camera.dy[0] = -1e38f;
    assert_rays(&camera);
}

static void large_pixel_numbers_are_rounded(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
    camera.width = camera.height = 1u << 23;
    camera.crop_x = (1u << 23) - WIDTH;
    camera.crop_y = (1u << 23) - HEIGHT;
    assert_rays(&camera); // x + 0.3 needs more digits than float has
}

static void crops_count_pixels_of_the_whole_picture(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
    camera.crop_x = 4;
    camera.crop_y = 2;
    camera.crop_width = 3;
    camera.crop_height = 5;
    assert_rays(&camera);
}

static void crops_of_zero_go_to_the_edges(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
    camera.crop_x = 4;
    camera.crop_y = 2;
    float all[3 * 5 * 5 + 1];
    mlrt_array out = {all, 0, 0}, none = {NULL, 0, 0};
    all[75] = -77;
    assert_int_equal(mlrt_camera_rays(&camera, &none, &out), MLRT_OK);
    assert_true(all[75] == -77);
    assert_rays(&camera);
}

static void minus_zero_stays_what_the_formula_gives(void **state)
{
    (void)state;
    mlrt_camera camera = {.struct_size = sizeof camera, .width = 3, .height = 3};
    camera.d00[0] = -0.0f;
    camera.d00[2] = 1;
    camera.dx[0] = -0.0f;
    camera.dx[1] = 1;
    camera.dy[0] = -0.0f;
    camera.dy[2] = 0.5f;
    assert_rays(&camera);
}

static void either_array_may_be_missing(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PARALLEL);
    float both[2][3 * COUNT], alone[3 * COUNT];
    mlrt_array origins = {both[0], 0, 0}, directions = {both[1], 0, 0}, one = {alone, 0, 0}, none = {NULL, 0, 0};
    assert_int_equal(mlrt_camera_rays(&camera, &origins, &directions), MLRT_OK);
    assert_int_equal(mlrt_camera_rays(&camera, &one, &none), MLRT_OK);
    assert_memory_equal(alone, both[0], sizeof alone);
    assert_int_equal(mlrt_camera_rays(&camera, &none, &one), MLRT_OK);
    assert_memory_equal(alone, both[1], sizeof alone);
    assert_int_equal(mlrt_camera_rays(&camera, &none, &none), MLRT_OK);
}

static void strides_leave_the_bytes_between_alone(void **state)
{
    (void)state;
    static const size_t strides[] = {12, 16, 28};
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
    float packed[3 * COUNT];
    mlrt_array out = {packed, 0, 0}, none = {NULL, 0, 0};
    assert_int_equal(mlrt_camera_rays(&camera, &none, &out), MLRT_OK);
    for (size_t s = 0; s < sizeof strides / sizeof strides[0]; s++) {
        size_t stride = strides[s], size = 4 + COUNT * stride;
        unsigned char *block = allocate_or_fail(size, 1);
        memset(block, GUARD, size);
        out = (mlrt_array){block + 4, stride, 0};
        assert_int_equal(mlrt_camera_rays(&camera, &none, &out), MLRT_OK);
        for (size_t i = 0; i < size; i++) {
            int inside = i >= 4 && (i - 4) % stride < 12;
            size_t at = inside ? (i - 4) / stride * 12 + (i - 4) % stride : 0;
            assert_int_equal(block[i], inside ? ((unsigned char *)packed)[at] : GUARD);
        }
        free(block);
    }
}

static void nothing_behind_the_arrays_is_written(void **state)
{
    (void)state;
    mlrt_camera camera = some_camera(MLRT_PROJECTION_PINHOLE);
    float *origins = allocate_guarded(12 * COUNT), *directions = allocate_guarded(12 * COUNT);
    mlrt_array out_origins = {origins, 0, 0}, out_directions = {directions, 0, 0};
    assert_int_equal(mlrt_camera_rays(&camera, &out_origins, &out_directions), MLRT_OK);
    free_guarded(origins, 12 * COUNT);
    free_guarded(directions, 12 * COUNT);
}

/* The rays that camera_rays writes, traced as a packet, are what render_tiles draws. */
static void tracing_the_rays_is_rendering(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_icosphere(&soup, 2, 1);
    struct fixture fixture = fixture_of_soup("sphere", 3, &soup);
    const float eye[3] = {2, -2, 1}, target[3] = {0, 0, 0};
    mlrt_camera camera = look_at(eye, target, 0.8f, WIDTH, HEIGHT);
    float origins[3 * COUNT], directions[3 * COUNT], traced[COUNT], rendered[COUNT];
    mlrt_array out_origins = {origins, 0, 0}, out_directions = {directions, 0, 0};
    assert_int_equal(mlrt_camera_rays(&camera, &out_origins, &out_directions), MLRT_OK);
    mlrt_rays rays = {
        .struct_size = sizeof rays, .count = COUNT, .origins = {origins, 0}, .directions = {directions, 0}};
    mlrt_hits hits = {.struct_size = sizeof hits, .t = {traced, 0, 0}};
    assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, NULL, &hits), MLRT_OK);
    hits.t.data = rendered;
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, NULL, &hits, NULL, NULL), MLRT_OK);
    assert_memory_equal(traced, rendered, sizeof traced);
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pinhole_rays_follow_the_formula),
        cmocka_unit_test(parallel_rays_follow_the_formula),
        cmocka_unit_test(random_cameras_follow_the_formula),
        cmocka_unit_test(denormal_steps_follow_the_formula),
        cmocka_unit_test(products_that_underflow_are_rounded_once),
        cmocka_unit_test(overflow_follows_the_formula),
        cmocka_unit_test(large_pixel_numbers_are_rounded),
        cmocka_unit_test(crops_count_pixels_of_the_whole_picture),
        cmocka_unit_test(crops_of_zero_go_to_the_edges),
        cmocka_unit_test(minus_zero_stays_what_the_formula_gives),
        cmocka_unit_test(either_array_may_be_missing),
        cmocka_unit_test(strides_leave_the_bytes_between_alone),
        cmocka_unit_test(nothing_behind_the_arrays_is_written),
        cmocka_unit_test(tracing_the_rays_is_rendering),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
