/* SPDX-License-Identifier: MIT */
/*
 * Whole scenes against the exact reference, by every method and instruction set: random pixels of a picture, the
 * closest hit and the shadow ray of each; then hostile rays, made from the scene's own vertices, planes and surfaces.
 *
 * Without arguments it runs on procedural scenes, as one of the tests. For any other scene, with so many pixels (at
 * most 100,000) and so many hostile rays:
 *
 *     test_scenes RAYS FILE [VIEWS.json:SCENE/VIEW]
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <mlrt.h>

#include "common/scene.h"
#include "common/view.h"
#include "reference.h"
#include "tally.h"

enum { SIDE = SANITIZED ? 128 : 384, PIXEL_LIMIT = 100000 };

/* The pictures of one scene, and what the reference says of them. */
struct subject {
    struct scene scene;
    mlrt_camera camera;
    mlrt_tree *tree, *kdtree;
    struct reference_scene *reference;
    uint32_t pixel_count;
    uint32_t *pixels;           /* positions in the picture */
    struct reference_hit *hits; /* of these pixels */
    uint8_t *shadows;
    float *points; /* of all pixels: where shadow rays go */
    uint32_t *skip;
    size_t difference_count;
};

static void *allocate(size_t count, size_t size)
{
    void *block = calloc(count, size);
    if (!block) abort();
    return block;
}

static struct reference_scene *make_reference(const struct scene *scene)
{
    struct reference_triangle *triangles = allocate(scene->triangle_count, sizeof *triangles);
    for (size_t i = 0; i < scene->triangle_count; i++) {
        for (int corner = 0; corner < 3; corner++) {
            const float *vertex = scene->vertices + 3 * (size_t)scene->indices[3 * i + (size_t)corner];
            memcpy(triangles[i].corner[corner], vertex, sizeof triangles[i].corner[corner]);
        }
        triangles[i].triangle = (uint32_t)i;
    }
    struct reference_scene *reference = reference_create(triangles, scene->triangle_count);
    free(triangles);
    return reference;
}

/* The ray of a pixel, by the reference's own formula. */
static struct reference_ray pixel_ray(const mlrt_camera *camera, uint32_t pixel)
{
    struct reference_ray ray = {.t_max = INFINITY, .skip = {REFERENCE_NONE, REFERENCE_NONE}};
    memcpy(ray.origin, camera->eye, sizeof ray.origin);
    reference_pixel_vector(camera->d00, camera->dx, camera->dy, pixel % SIDE, pixel / SIDE, camera->sample_x,
                           camera->sample_y, ray.direction);
    return ray;
}

static struct reference_ray shadow_ray(const struct subject *subject, const float light[3], uint32_t pixel)
{
    struct reference_ray ray = {.t_max = 1, .skip = {subject->skip[2 * pixel], subject->skip[2 * pixel + 1]}};
    memcpy(ray.origin, light, sizeof ray.origin);
    reference_difference(subject->points + 3 * (size_t)pixel, light, ray.direction);
    return ray;
}

/* Asks the reference. Points off the hits come from the library; only the rays towards them are judged. */
static void find_answers(struct subject *subject, const float light[3])
{
    uint32_t state = 12345;
    for (uint32_t i = 0; i < subject->pixel_count; i++) {
        state = state * 1664525u + 1013904223u;
        const uint32_t pixel = (state >> 8) % (SIDE * SIDE);
        subject->pixels[i] = pixel;
        const struct reference_ray ray = pixel_ray(&subject->camera, pixel);
        struct reference_hit *hit = &subject->hits[i], shadow;
        reference_trace(subject->reference, &ray, hit);
        float *point = subject->points + 3 * (size_t)pixel;
        if (hit->triangle == REFERENCE_NONE ||
            mlrt_offset_point(subject->tree, 0, hit->triangle, hit->u, hit->v, -hit->facing, point) != MLRT_OK) {
            continue;
        }
        subject->skip[2 * pixel] = 0;
        subject->skip[2 * pixel + 1] = hit->triangle;
        const struct reference_ray to_light = shadow_ray(subject, light, pixel);
        reference_trace(subject->reference, &to_light, &shadow);
        subject->shadows[i] = shadow.triangle != REFERENCE_NONE;
    }
}

/* One method's picture and shadows beside the answers. */
static void compare(struct subject *subject, const mlrt_tree *tree, const float light[3],
                    const mlrt_trace_options *options)
{
    const size_t count = (size_t)SIDE * SIDE;
    float *t = allocate(count, sizeof *t), *u = allocate(count, sizeof *u), *v = allocate(count, sizeof *v);
    uint32_t *triangle = allocate(count, sizeof *triangle);
    uint8_t *occluded = allocate(count, 1);
    const mlrt_hits frame = {
        .struct_size = sizeof frame, .t = {t, 0, 0}, .u = {u, 0, 0}, .v = {v, 0, 0}, .triangle = {triangle, 0, 0}};
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = SIDE,
                                .count = count,
                                .positions = {subject->points, 0},
                                .skip = {subject->skip, 0}};
    const mlrt_light lamp = {sizeof lamp, MLRT_LIGHT_POINT, {light[0], light[1], light[2]}};
    const mlrt_array answers = {occluded, 0, 0};
    int32_t status = mlrt_render_tiles(tree, &subject->camera, options, &frame, NULL, NULL);
    if (status == MLRT_OK) status = mlrt_occluded_points(tree, &points, &lamp, options, &answers);
    size_t different = status != MLRT_OK;
    for (uint32_t i = 0; i < subject->pixel_count; i++) {
        const uint32_t pixel = subject->pixels[i];
        const struct reference_hit *hit = &subject->hits[i];
        const int same = hit->triangle == triangle[pixel] && memcmp(&hit->t, &t[pixel], sizeof *t) == 0 &&
                         memcmp(&hit->u, &u[pixel], sizeof *u) == 0 && memcmp(&hit->v, &v[pixel], sizeof *v) == 0 &&
                         subject->shadows[i] == occluded[pixel];
        if (!same && different == 0) {
            print_message("pixel %u, method %d, isa %d: triangle %u, not %u; t %a, not %a; shadow %d, not %d\n",
                          (unsigned)pixel, (int)options->method, (int)options->isa, (unsigned)triangle[pixel],
                          (unsigned)hit->triangle, (double)t[pixel], (double)hit->t, occluded[pixel],
                          subject->shadows[i]);
        }
        different += !same;
    }
    subject->difference_count += different;
    free(t);
    free(u);
    free(v);
    free(triangle);
    free(occluded);
}

static void compare_methods(struct subject *subject, const float light[3])
{
    mlrt_pool *pool = NULL;
    mlrt_create_pool(2, &pool);
    for (size_t v = 0; v < variant_count(); v++) {
        mlrt_trace_options options = variant_at(v)->options;
        if (!variant_at(v)->probe && options.method != MLRT_METHOD_RAY) continue;
        options.pool = pool;
        compare(subject, variant_at(v)->on_kdtree ? subject->kdtree : subject->tree, light, &options);
    }
    mlrt_destroy_pool(pool);
}

/*
 * Answers of all methods that differ from the reference on random pixels of a scene and on hostile rays; SIZE_MAX if it
 * cannot be loaded.
 */
static size_t count_differences(const char *name, const char *view, uint32_t pixel_count, uint64_t ray_count,
                                struct tally *tally)
{
    struct subject subject = {.pixel_count = pixel_count};
    if (load_scene(name, &subject.scene) || (view && read_view(view, &subject.scene.view)) ||
        camera_of_view(&subject.scene.view, SIDE, SIDE, &subject.camera)) {
        return SIZE_MAX;
    }
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = subject.scene.vertices,
                            .vertex_count = subject.scene.vertex_count,
                            .indices = subject.scene.indices,
                            .triangle_count = subject.scene.triangle_count};
    const mlrt_kdtree_options tuned = {.struct_size = sizeof tuned, .preset = MLRT_KDTREE_TUNED};
    if (mlrt_build_tree(&mesh, 1, NULL, &subject.tree) != MLRT_OK) return SIZE_MAX;
    if (mlrt_build_kdtree(&mesh, 1, &tuned, &subject.kdtree) != MLRT_OK) return SIZE_MAX;
    subject.reference = make_reference(&subject.scene);
    subject.pixels = allocate(pixel_count, sizeof *subject.pixels);
    subject.hits = allocate(pixel_count, sizeof *subject.hits);
    subject.shadows = allocate(pixel_count, 1);
    subject.points = allocate((size_t)SIDE * SIDE * 3, sizeof *subject.points);
    subject.skip = allocate((size_t)SIDE * SIDE * 2, sizeof *subject.skip);
    for (size_t i = 0; i < (size_t)SIDE * SIDE * 3; i++) subject.points[i] = NAN;
    float light[3];
    for (int k = 0; k < 3; k++) light[k] = (float)subject.scene.view.light[k];

    find_answers(&subject, light);
    compare_methods(&subject, light);
    const struct fixture fixture = {name, 1, subject.tree, subject.reference, subject.kdtree};
    tally_hostile(tally, &fixture, ray_count, INFINITY);
    subject.difference_count += (size_t)tally->difference_count;

    reference_destroy(subject.reference);
    mlrt_destroy_tree(subject.tree);
    mlrt_destroy_tree(subject.kdtree);
    free_scene(&subject.scene);
    free(subject.pixels);
    free(subject.hits);
    free(subject.shadows);
    free(subject.points);
    free(subject.skip);
    return subject.difference_count;
}

static void check_scene(const char *name, uint32_t pixel_count, uint64_t ray_count)
{
    struct tally tally = {0};
    assert_int_equal(count_differences(name, NULL, pixel_count, ray_count, &tally), 0);
}

static void room(void **state)
{
    (void)state;
    check_scene("room", (uint32_t)scaled(1200), scaled(1500));
}

static void doubled(void **state)
{
    (void)state;
    check_scene("doubled", (uint32_t)scaled(600), scaled(600));
}

/* What a ray hits, and what it hits if it passes that. */
static void hit_twice(const mlrt_tree *tree, const mlrt_camera *camera, uint32_t pixel, mlrt_hit hits[2])
{
    mlrt_ray ray = {.struct_size = sizeof ray};
    memcpy(ray.origin, camera->eye, sizeof ray.origin);
    reference_pixel_vector(camera->d00, camera->dx, camera->dy, pixel % SIDE, pixel / SIDE, camera->sample_x,
                           camera->sample_y, ray.direction);
    for (int i = 0; i < 2; i++) {
        hits[i] = (mlrt_hit){.struct_size = sizeof hits[i]};
        assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, &hits[i]), MLRT_OK);
        ray.flags = MLRT_RAY_SKIP;
        ray.skip_mesh = hits[0].mesh, ray.skip_triangle = hits[0].triangle;
    }
}

/* Of most that a view sees there are two copies; some lie in the very same plane, others not. */
static void doubled_surfaces_are_there_twice(void **state)
{
    (void)state;
    enum { STEP = 677, COUNT = SIDE * SIDE / STEP };
    const float close = 1e-5f; /* of the distance: a few floats of the coordinates, seen at a slant */
    int same = 0, near = 0;
    struct scene scene;
    mlrt_camera camera;
    mlrt_tree *tree;
    assert_int_equal(load_scene("doubled", &scene) || camera_of_view(&scene.view, SIDE, SIDE, &camera), 0);
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene.vertices,
                            .vertex_count = scene.vertex_count,
                            .indices = scene.indices,
                            .triangle_count = scene.triangle_count};
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    for (uint32_t i = 0; i < COUNT; i++) {
        mlrt_hit hits[2];
        hit_twice(tree, &camera, i * STEP, hits);
        same += hits[0].t == hits[1].t;
        near += hits[0].t != hits[1].t && hits[1].t - hits[0].t <= close * hits[0].t;
    }
    mlrt_destroy_tree(tree);
    free_scene(&scene);
    assert_true(same + near > COUNT * 3 / 4);
    assert_true(same > COUNT / 20 && near > COUNT / 4);
}

static void scan(void **state)
{
    (void)state;
    check_scene("scan:20000", (uint32_t)scaled(300), scaled(1500));
}

static int run_on_file(const char *ray_text, const char *name, const char *view)
{
    struct tally tally = {0};
    const uint64_t ray_count = strtoull(ray_text, NULL, 10);
    const uint32_t pixel_count = ray_count < PIXEL_LIMIT ? (uint32_t)ray_count : PIXEL_LIMIT;
    const size_t different = count_differences(name, view, pixel_count, ray_count, &tally);
    if (different == SIZE_MAX) return 2;
    printf("%s: %u pixels with shadow rays, %llu hostile rays, %llu answers of %zu ways, differences: %zu; reference "
           "%.3f us per ray\n",
           name, (unsigned)pixel_count, (unsigned long long)tally.ray_count, (unsigned long long)tally.answer_count,
           tally_way_count(), different, 1e6 * tally.reference_seconds / (double)tally.ray_count);
    return different != 0;
}

int main(int argc, char **argv)
{
    if (argc >= 3) return run_on_file(argv[1], argv[2], argc > 3 ? argv[3] : NULL);
    const struct CMUnitTest tests[] = {cmocka_unit_test(room), cmocka_unit_test(doubled),
                                       cmocka_unit_test(doubled_surfaces_are_there_twice), cmocka_unit_test(scan)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
