/* SPDX-License-Identifier: MIT */
/*
 * mlrt_render_tiles: pictures of every size, from everywhere, against the rays that the camera is defined by.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

static struct fixture torus(void)
{
    struct soup soup = {0};
    soup_add_torus(&soup, 30, 16, 1, 0.4f);
    return fixture_of_soup("torus", 1, &soup);
}

/* Boxes on a floor: planes that all axes share. */
static struct fixture boxes(void)
{
    struct random random = {2};
    struct soup soup = {0};
    const float lo[3] = {-4, -4, -1}, hi[3] = {4, 4, 4};
    soup_add_box(&soup, lo, hi);
    for (int i = 0; i < 24; i++) {
        float from[3], to[3];
        for (int k = 0; k < 3; k++) {
            from[k] = (float)draw_below(&random, 6) - 3;
            to[k] = from[k] + 0.5f + 0.25f * (float)draw_below(&random, 4);
        }
        soup_add_box(&soup, from, to);
    }
    return fixture_of_soup("boxes", 2, &soup);
}

static void picture_sizes(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1},   {1, 9},   {9, 1},   {2, 3},   {5, 7},
                                        {17, 13}, {64, 64}, {66, 65}, {130, 30}};
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        mlrt_camera camera = look_at(eye, target, 1, sizes[i][0], sizes[i][1]);
        check_camera(&fixture, &camera);
    }
    free_fixture(&fixture);
}

static void a_picture_of_several_large_tiles(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    mlrt_camera camera = look_at(eye, target, 1, 300, 280);
    check_camera_quickly(&fixture, &camera);
    free_fixture(&fixture);
}

static void crops(void **state)
{
    (void)state;
    static const uint32_t crops[][4] = {{0, 0, 10, 10}, {3, 5, 20, 11},   {59, 39, 1, 1}, {13, 0, 0, 7},
                                        {1, 2, 0, 0},   {30, 30, 30, 10}, {63, 0, 1, 40}};
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    for (size_t i = 0; i < sizeof crops / sizeof crops[0]; i++) {
        mlrt_camera camera = look_at(eye, target, 1, 64, 40);
        camera.crop_x = crops[i][0];
        camera.crop_y = crops[i][1];
        camera.crop_width = crops[i][2];
        camera.crop_height = crops[i][3];
        check_camera(&fixture, &camera);
    }
    free_fixture(&fixture);
}

/* A small window far out in the largest picture there is. */
static void a_crop_of_the_largest_picture(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    mlrt_camera camera = look_at(eye, target, 1, 1u << 23, 1u << 23);
    camera.crop_x = (1u << 22) + 12345;
    camera.crop_y = (1u << 22) - 54321;
    camera.crop_width = 40;
    camera.crop_height = 37;
    check_camera(&fixture, &camera);
    camera.crop_x = (1u << 23) - 20;
    camera.crop_y = (1u << 23) - 20;
    camera.crop_width = 20;
    camera.crop_height = 0;
    check_camera_quickly(&fixture, &camera);
    free_fixture(&fixture);
}

static void sample_offsets(void **state)
{
    (void)state;
    static const float offsets[][2] = {{0, 0},       {1, 1}, {0.999f, 0.001f}, {-0.5f, 2.5f}, {1e-30f, -1e-30f},
                                       {100, -77.7f}};
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    for (size_t i = 0; i < sizeof offsets / sizeof offsets[0]; i++) {
        mlrt_camera camera = look_at(eye, target, 1, 40, 37);
        camera.sample_x = offsets[i][0];
        camera.sample_y = offsets[i][1];
        check_camera_quickly(&fixture, &camera);
    }
    free_fixture(&fixture);
}

static void cameras_inside_a_closed_scene(void **state)
{
    (void)state;
    struct random random = {3};
    struct fixture fixture = boxes();
    for (size_t i = 0; i < scaled(8); i++) {
        float eye[3], target[3];
        draw_point(&random, -3.5f, 3.5f, eye);
        draw_point(&random, -3.5f, 3.5f, target);
        mlrt_camera camera = look_at(eye, target, 1.2f, 48, 36);
        check_camera(&fixture, &camera);
    }
    free_fixture(&fixture);
}

/* Fields of view close to 180 degrees: every tile mixes signs. */
static void very_wide_views(void **state)
{
    (void)state;
    const float eye[3] = {0.1f, 0.2f, 0.3f}, target[3] = {1, 1, 1};
    struct fixture fixture = boxes();
    for (int i = 0; i < 3; i++) {
        mlrt_camera camera = look_at(eye, target, i == 0 ? 8.0f : i == 1 ? 100.0f : 1e5f, 40, 40);
        check_camera(&fixture, &camera);
    }
    free_fixture(&fixture);
}

/* The vectors of the pixels span a plane that the eye sees from the edge, or run backwards through the middle. */
static void cameras_whose_pixels_pass_through_zero(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    mlrt_camera camera = {.struct_size = sizeof camera,
                          .width = 33,
                          .height = 33,
                          .eye = {0.1f, 0.2f, 0.3f},
                          .d00 = {-16, -16, 0},
                          .dx = {1, 0, 0},
                          .dy = {0, 1, 0}};
    check_camera(&fixture, &camera); // pixel (16, 16) has d = 0
    camera.d00[2] = 1e-20f;
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

static void axis_parallel_views(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    for (int axis = 0; axis < 3; axis++) {
        for (int back = 0; back < 2; back++) {
            // The middle column and row have components that are exactly 0, at eyes in the planes of faces.
            mlrt_camera camera = {.struct_size = sizeof camera, .width = 33, .height = 33};
            camera.d00[axis] = back ? -1.0f : 1.0f;
            camera.d00[(axis + 1) % 3] = -0.5f;
            camera.d00[(axis + 2) % 3] = -0.5f;
            camera.dx[(axis + 1) % 3] = 0.03125f;
            camera.dy[(axis + 2) % 3] = 0.03125f;
            camera.eye[axis] = back ? 3.75f : -3.75f;
            check_camera(&fixture, &camera);
            camera.eye[(axis + 1) % 3] = 0.5f;
            camera.eye[(axis + 2) % 3] = -1;
            check_camera_quickly(&fixture, &camera);
        }
    }
    free_fixture(&fixture);
}

static void eyes_on_planes_edges_and_vertices(void **state)
{
    (void)state;
    struct random random = {4};
    struct fixture fixture = boxes();
    size_t count = reference_triangle_count(fixture.reference);
    for (size_t i = 0; i < scaled(8); i++) {
        const struct reference_triangle *triangle =
            reference_triangle_at(fixture.reference, draw_below(&random, (uint32_t)count));
        float target[3];
        draw_point(&random, -4, 4, target);
        mlrt_camera camera = look_at(triangle->corner[0], target, 1.5f, 36, 36);
        check_camera(&fixture, &camera);
    }
    free_fixture(&fixture);
}

static void eyes_far_outside(void **state)
{
    (void)state;
    static const float distances[] = {1e2f, 1e4f, 1e6f, 1e12f};
    const float target[3] = {0, 0, 0};
    struct fixture fixture = boxes();
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; i++) {
        const float eye[3] = {distances[i], distances[i] * 0.7f, distances[i] * 0.3f};
        mlrt_camera camera = look_at(eye, target, 16 / distances[i], 40, 40);
        check_camera(&fixture, &camera);
    }
    free_fixture(&fixture);
}

/* So close that neighbouring pixels have nearly equal, or equal, directions. */
static void extreme_zoom(void **state)
{
    (void)state;
    static const float fields[] = {1e-3f, 1e-5f, 1e-6f, 1e-7f, 1e-9f};
    const float eye[3] = {0, -3, 0};
    struct fixture fixture = torus();
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        const struct reference_triangle *triangle = reference_triangle_at(fixture.reference, 200);
        mlrt_camera camera = look_at(eye, triangle->corner[0], fields[i], 40, 40);
        check_camera(&fixture, &camera);
    }
    free_fixture(&fixture);
}

static void parallel_cameras(void **state)
{
    (void)state;
    struct random random = {5};
    struct fixture fixture = boxes();
    for (size_t i = 0; i < scaled(6); i++) {
        float centre[3], direction[3];
        draw_point(&random, -6, 6, centre);
        draw_point(&random, -1, 1, direction);
        mlrt_camera camera = look_along(centre, direction, 10, 40, 37);
        check_camera(&fixture, &camera);
    }
    free_fixture(&fixture);
}

static void parallel_cameras_along_axes(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    for (int axis = 0; axis < 3; axis++) {
        for (int back = 0; back < 2; back++) {
            // Quarter units: columns and rows run in planes of faces. The zeros have both signs.
            mlrt_camera camera = {.struct_size = sizeof camera,
                                  .projection = MLRT_PROJECTION_PARALLEL,
                                  .width = 36,
                                  .height = 36,
                                  .direction = {0.0f, -0.0f, 0.0f}};
            camera.direction[axis] = back ? -1.0f : 1.0f;
            camera.d00[axis] = back ? 5.0f : -5.0f;
            camera.d00[(axis + 1) % 3] = -4.25f;
            camera.d00[(axis + 2) % 3] = -4.25f;
            camera.dx[(axis + 1) % 3] = 0.25f;
            camera.dy[(axis + 2) % 3] = 0.25f;
            check_camera(&fixture, &camera);
        }
    }
    free_fixture(&fixture);
}

/* A parallel camera whose picture is not perpendicular to the rays, and one that is seen edge on. */
static void oblique_parallel_cameras(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    mlrt_camera camera = {.struct_size = sizeof camera,
                          .projection = MLRT_PROJECTION_PARALLEL,
                          .width = 37,
                          .height = 37,
                          .d00 = {-5, -5, 6},
                          .dx = {0.25f, 0.1f, 0},
                          .dy = {0, 0.25f, 0.05f},
                          .direction = {0.3f, 0.2f, -1}};
    check_camera(&fixture, &camera);
    camera.direction[0] = 0.25f;
    camera.direction[1] = 0.1f;
    camera.direction[2] = 0;
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

static void ranges_of_t(void **state)
{
    (void)state;
    static const float ranges[][2] = {{0, 2.9f}, {2.9f, 0}, {2.5f, 3}, {-1, 3}, {3, 2}, {0, -1}, {INFINITY, 0}};
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        mlrt_camera camera = look_at(eye, target, 1, 33, 33);
        camera.t_min = ranges[i][0];
        camera.t_max = ranges[i][1];
        check_camera_quickly(&fixture, &camera);
    }
    free_fixture(&fixture);
}

/* In the corner of a picture is a packet of one ray, which has an origin of its own even if the rays are parallel. */
static void ranges_of_parallel_rays(void **state)
{
    (void)state;
    static const float ranges[] = {0, 0.2f, 1.5f, 3};
    const float centre[3] = {0.7f, -3, 0}, direction[3] = {0, 1, 0};
    struct fixture fixture = torus();
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        for (uint32_t size = 1; size <= 13; size += 4) {
            mlrt_camera camera = look_along(centre, direction, 0.4f, size, size);
            camera.t_min = ranges[i] ? 2 + ranges[i] : 0;
            check_camera_quickly(&fixture, &camera);
        }
    }
    free_fixture(&fixture);
}

/* Pixel vectors of any length, up to where they overflow or vanish. */
static void lengths_of_pixel_vectors(void **state)
{
    (void)state;
    static const float lengths[] = {1e-42f, 1e-38f, 1e-20f, 1e20f, 1e37f, 3e38f};
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        mlrt_camera camera = look_at(eye, target, 1, 33, 33);
        for (int k = 0; k < 3; k++) {
            camera.d00[k] *= lengths[i];
            camera.dx[k] *= lengths[i];
            camera.dy[k] *= lengths[i];
        }
        check_camera_quickly(&fixture, &camera);
    }
    free_fixture(&fixture);
}

static void scenes_of_every_scale(void **state)
{
    (void)state;
    static const float scales[] = {1e-38f, 1e-30f, 1e-10f, 1e10f, 1e30f, 1e37f};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        const float zero[3] = {0, 0, 0}, eye[3] = {0.3f * scales[i], -3 * scales[i], scales[i]}, target[3] = {0, 0, 0};
        struct soup soup = {0};
        soup_add_torus(&soup, 20, 10, 1, 0.4f);
        move_soup(&soup, scales[i], zero);
        struct fixture fixture = fixture_of_soup("scaled torus", i, &soup);
        mlrt_camera camera = look_at(eye, target, 1, 33, 33);
        for (int k = 0; k < 3; k++) {
            // look_at has worked with squares; this view is given directly.
            const float d00[3] = {-0.5f, 1, -0.9f}, dx[3] = {0.03f, 0, 0}, dy[3] = {0, 0, 0.03f};
            camera.d00[k] = d00[k];
            camera.dx[k] = dx[k];
            camera.dy[k] = dy[k];
        }
        check_camera(&fixture, &camera);
        free_fixture(&fixture);
    }
}

static void a_scene_far_from_the_origin(void **state)
{
    (void)state;
    const float offset[3] = {1e7f, -1e7f, 5e6f}, eye[3] = {1e7f, -1e7f - 60, 5e6f};
    struct soup soup = {0};
    soup_add_torus(&soup, 30, 16, 16, 6);
    move_soup(&soup, 1, offset);
    struct fixture fixture = fixture_of_soup("torus at 1e7", 6, &soup);
    mlrt_camera camera = look_at(eye, offset, 1, 48, 48);
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

static void needles(void **state)
{
    (void)state;
    struct random random = {7};
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct soup soup = {0};
    soup_add_needles(&soup, &random, 400, 1e3f);
    soup_add_needles(&soup, &random, 100, 1e6f);
    struct fixture fixture = fixture_of_soup("needles", 7, &soup);
    mlrt_camera camera = look_at(eye, target, 0.8f, 64, 64);
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

/* Many triangles in a pixel. */
static void a_dense_mesh(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct soup soup = {0};
    soup_add_icosphere(&soup, 5, 1);
    struct fixture fixture = fixture_of_soup("dense sphere", 8, &soup);
    mlrt_camera camera = look_at(eye, target, 1, 40, 40);
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

static void sheets_that_touch_and_tie(void **state)
{
    (void)state;
    const float eye[3] = {4.5f, 3.5f, 12};
    struct soup soup = {0};
    for (int i = 0; i < 3; i++) soup_add_grid(&soup, 2, 0, 8);
    soup_add_grid(&soup, 2, next_float(1.0f, 1), 8);
    soup_add_grid(&soup, 2, 1, 8);
    struct fixture fixture = fixture_of_soup("sheets", 9, &soup);
    // Integer rays: many pass exactly through vertices and edges.
    mlrt_camera camera = {.struct_size = sizeof camera,
                          .width = 40,
                          .height = 40,
                          .d00 = {-6, -6, -12},
                          .dx = {0.25f, 0, 0},
                          .dy = {0, 0.25f, 0}};
    memcpy(camera.eye, eye, sizeof eye);
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

static void the_room(void **state)
{
    (void)state;
    const float eye[3] = {1, 1, 1.5f}, target[3] = {2, 2.5f, 1};
    struct fixture fixture = fixture_of_example("room");
    mlrt_camera camera = look_at(eye, target, 1.3f, 96, 72);
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

static void the_scan(void **state)
{
    (void)state;
    const float eye[3] = {0.5f, -4, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = fixture_of_example("scan:30000");
    mlrt_camera camera = look_at(eye, target, 0.8f, 64, 64);
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

static void an_empty_tree(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = make_fixture("empty", 10, NULL, 0);
    mlrt_camera camera = look_at(eye, target, 1, 40, 20);
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

/* ---- where results go -------------------------------------------------------------------------------------------- */

enum { WIDTH = 21, HEIGHT = 13, GUARD = 0x5A };

/* The frame lies in a larger picture, bytes between elements and rows are somebody else's. */
static void check_frame(const struct fixture *fixture, const mlrt_camera *camera, size_t stride, size_t row_stride,
                        const struct variant *variant)
{
    size_t size = 4 + HEIGHT * row_stride;
    struct ray_list list = {0};
    struct reference_hit *expected = allocate_or_fail(WIDTH * HEIGHT, sizeof *expected);
    unsigned char *block = allocate_or_fail(size, 1);
    add_camera_rays(&list, camera);
    trace_reference(fixture, &list, expected);
    memset(block, GUARD, size);
    mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {block + 4, stride, row_stride}};
    assert_int_equal(mlrt_render_tiles(variant_tree(variant, fixture), camera, &variant->options, &frame, NULL, NULL),
                     MLRT_OK);
    for (size_t i = 0; i < size; i++) {
        size_t row = i < 4 ? 0 : (i - 4) / row_stride, in_row = i < 4 ? row_stride : (i - 4) % row_stride;
        size_t column = in_row / stride, byte = in_row % stride;
        unsigned char wanted[4] = {GUARD, GUARD, GUARD, GUARD};
        if (column < WIDTH) memcpy(wanted, &expected[row * WIDTH + column].triangle, 4);
        assert_int_equal(block[i], byte < 4 ? wanted[byte] : GUARD);
    }
    free(expected);
    free(block);
    free_rays(&list);
}

static void nothing_but_the_frame_is_written(void **state)
{
    (void)state;
    static const size_t strides[] = {4, 8, 20};
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    mlrt_camera camera = look_at(eye, target, 1, WIDTH, HEIGHT);
    for (size_t v = 0; v < variant_count(); v++) {
        for (size_t i = 0; i < sizeof strides / sizeof strides[0]; i++) {
            check_frame(&fixture, &camera, strides[i], WIDTH * strides[i], variant_at(v));
            check_frame(&fixture, &camera, strides[i], WIDTH * strides[i] + 36, variant_at(v));
        }
    }
    free_fixture(&fixture);
}

static void row_stride_of_zero_is_width_times_stride(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    mlrt_camera camera = look_at(eye, target, 1, 4 * WIDTH, 3 * HEIGHT);
    camera.crop_x = 30;
    camera.crop_y = 12;
    camera.crop_width = WIDTH;
    camera.crop_height = HEIGHT;
    float packed[WIDTH * HEIGHT], rows[HEIGHT][WIDTH];
    mlrt_hits frame = {.struct_size = sizeof frame, .t = {packed, 0, 0}};
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, NULL, &frame, NULL, NULL), MLRT_OK);
    frame.t = (mlrt_array){rows, sizeof(float), sizeof rows[0]};
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, NULL, &frame, NULL, NULL), MLRT_OK);
    assert_memory_equal(packed, rows, sizeof packed);
    free_fixture(&fixture);
}

/* Each output of the frame and of the callback for itself: the others must not be needed. */
struct asked {
    uint32_t outputs;
    int wrong;
};

static int32_t look_at_outputs(void *user, const mlrt_tile *tile)
{
    struct asked *asked = user;
    uint32_t outputs = asked->outputs;
    if (!tile->t != !(outputs & MLRT_OUTPUT_T)) asked->wrong |= 1;
    if (!tile->u != !(outputs & MLRT_OUTPUT_UV) || !tile->v != !tile->u) asked->wrong |= 2;
    if (!tile->mesh != !(outputs & MLRT_OUTPUT_IDS)) asked->wrong |= 4;
    if (!tile->triangle != !(outputs & (MLRT_OUTPUT_IDS | MLRT_OUTPUT_TRIANGLE))) asked->wrong |= 32;
    if (!tile->facing != !(outputs & MLRT_OUTPUT_FACING)) asked->wrong |= 8;
    if (tile->occluded) asked->wrong |= 16;
    return 0;
}

static void a_callback_gets_what_it_asked_for(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    mlrt_camera camera = look_at(eye, target, 1, WIDTH, HEIGHT);
    for (uint32_t outputs = 0; outputs < 64; outputs++) {
        float t[WIDTH * HEIGHT];
        struct asked asked = {outputs, 0};
        mlrt_hits frame = {.struct_size = sizeof frame, .t = {t, 0, 0}};
        mlrt_trace_options options = {.struct_size = sizeof options, .outputs = outputs};
        const mlrt_hits *frames[2] = {NULL, &frame}; // a frame's outputs are not the callback's
        for (int i = 0; i < 2; i++) {
            int32_t status = mlrt_render_tiles(fixture.tree, &camera, &options, frames[i], look_at_outputs, &asked);
            assert_int_equal(status, MLRT_OK);
            assert_int_equal(asked.wrong, 0);
        }
    }
    free_fixture(&fixture);
}

/* It would write nothing, unless there is a callback. */
static void a_frame_without_arrays(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    mlrt_camera camera = look_at(eye, target, 1, WIDTH, HEIGHT);
    mlrt_hits frame = {.struct_size = sizeof frame};
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, NULL, &frame, NULL, NULL), MLRT_ERROR_ARGUMENT);
    free_fixture(&fixture);
}

/* ---- counters ---------------------------------------------------------------------------------------------------- */

static void counters_do_not_change_answers_and_add_up(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 1}, target[3] = {0, 0, 0};
    struct fixture fixture = torus();
    mlrt_camera camera = look_at(eye, target, 1, 50, 41);
    for (size_t v = 0; v < variant_count(); v++) {
        static uint32_t plain[50 * 41], counted[50 * 41];
        mlrt_counters counters = {.struct_size = sizeof counters, .ray_count = 7};
        mlrt_trace_options options = variant_at(v)->options;
        mlrt_hits frame = {.struct_size = sizeof frame, .triangle = {plain, 0, 0}};
        const mlrt_tree *tree = variant_tree(variant_at(v), &fixture);
        options.pool = shared_pool(variant_at(v)->threads);
        assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
        frame.triangle.data = counted;
        options.counters = &counters;
        assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &frame, NULL, NULL), MLRT_OK);
        assert_memory_equal(plain, counted, sizeof plain);
        assert_int_equal(counters.ray_count, 7 + 50 * 41);
        assert_true(counters.entry_point_cell_count <= counters.cell_count);
        assert_true(counters.undecided_checked_count <= counters.undecided_cull_count);
        assert_true(counters.missed_beam_count + counters.covered_beam_count <= counters.beam_count);
        assert_true(counters.triangle_test_count > 0);
        assert_int_equal(counters.struct_size, sizeof counters);
    }
    free_fixture(&fixture);
}

/* t_max = -inf lets no ray hit anything: it is no "no limit". */
static void a_limit_of_minus_infinity(void **state)
{
    (void)state;
    const float limits[] = {-INFINITY, -1, INFINITY}, eye[3] = {0, 0, 0}, target[3] = {0, 0, 1};
    for (int i = 0; i < 3; i++) {
        struct soup soup = {0};
        const float corner[3] = {-8, -8, 1}, side[3] = {16, 0, 0}, other[3] = {0, 16, 0};
        soup_add_quad(&soup, corner, side, other);
        struct fixture fixture = fixture_of_soup("minus infinity", (uint64_t)i, &soup);
        mlrt_camera camera = look_at(eye, target, 1, 40, 40);
        camera.t_max = limits[i];
        check_camera(&fixture, &camera);
        free_fixture(&fixture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(picture_sizes),
        cmocka_unit_test(a_picture_of_several_large_tiles),
        cmocka_unit_test(crops),
        cmocka_unit_test(a_crop_of_the_largest_picture),
        cmocka_unit_test(sample_offsets),
        cmocka_unit_test(cameras_inside_a_closed_scene),
        cmocka_unit_test(very_wide_views),
        cmocka_unit_test(cameras_whose_pixels_pass_through_zero),
        cmocka_unit_test(axis_parallel_views),
        cmocka_unit_test(eyes_on_planes_edges_and_vertices),
        cmocka_unit_test(eyes_far_outside),
        cmocka_unit_test(extreme_zoom),
        cmocka_unit_test(parallel_cameras),
        cmocka_unit_test(parallel_cameras_along_axes),
        cmocka_unit_test(oblique_parallel_cameras),
        cmocka_unit_test(ranges_of_t),
        cmocka_unit_test(ranges_of_parallel_rays),
        cmocka_unit_test(lengths_of_pixel_vectors),
        cmocka_unit_test(scenes_of_every_scale),
        cmocka_unit_test(a_scene_far_from_the_origin),
        cmocka_unit_test(needles),
        cmocka_unit_test(a_dense_mesh),
        cmocka_unit_test(sheets_that_touch_and_tie),
        cmocka_unit_test(the_room),
        cmocka_unit_test(the_scan),
        cmocka_unit_test(an_empty_tree),
        cmocka_unit_test(nothing_but_the_frame_is_written),
        cmocka_unit_test(row_stride_of_zero_is_width_times_stride),
        cmocka_unit_test(a_callback_gets_what_it_asked_for),
        cmocka_unit_test(a_frame_without_arrays),
        cmocka_unit_test(counters_do_not_change_answers_and_add_up),
        cmocka_unit_test(a_limit_of_minus_infinity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
