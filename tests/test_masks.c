/* SPDX-License-Identifier: MIT */
/*
 * Masks: what a ray with a mask hits is what it would hit if the meshes that it does not see were not there. So every
 * way of tracing is compared with the reference over the visible meshes alone.
 */
#include <stdlib.h>
#include <string.h>

#include "support.h"

#define MESH_COUNT   5
#define RAY_COUNT    (SANITIZED ? 120 : 360)
#define PICTURE_SIZE (SANITIZED ? 34 : 50)

/* Bits of meshes, in order; the third is seen by all. */
static const uint32_t mesh_masks[MESH_COUNT] = {1, 2, 0, 3, 0x80000004u};

/* Masks of rays; 0 is all bits, and 8 sees the third mesh alone. */
static const uint32_t ray_masks[] = {0, 1, 2, 3, 4, 8, 0x80000000u, 0xFFFFFFFFu};
#define MASK_COUNT (sizeof ray_masks / sizeof *ray_masks)

static const uint64_t SEED = 20261;

/* A wall, a box around all, and three soups through one another, so that what is hidden is often in front. */
static struct soup make_part(struct random *random, int part)
{
    struct soup soup = {NULL, 0, 0};
    const float lo[3] = {-6, -6, -6}, hi[3] = {6, 6, 6};
    const float corner[3] = {-4, -4, 1}, side[3] = {8, 0, 0}, other[3] = {0, 8, 0};
    switch (part) {
    case 0:
        soup_add_quad(&soup, corner, side, other);
        break;
    case 2:
        soup_add_box(&soup, lo, hi);
        break;
    default:
        soup_add_random(&soup, random, 300, 4, 1.5f);
    }
    return soup;
}

struct scene {
    struct soup parts[MESH_COUNT];
    struct fixture masked;              /* all meshes; its reference knows nothing of masks */
    struct fixture visible[MASK_COUNT]; /* those that are seen with a mask */
};

static int is_seen(int part, uint32_t mask)
{
    const uint32_t own = mesh_masks[part] ? mesh_masks[part] : ~0u;
    return (own & (mask ? mask : ~0u)) != 0;
}

static void make_scene(struct scene *scene)
{
    struct random random = {SEED};
    mlrt_mesh meshes[MESH_COUNT];
    for (int i = 0; i < MESH_COUNT; i++) {
        scene->parts[i] = make_part(&random, i);
        meshes[i] = soup_mesh(&scene->parts[i]);
        meshes[i].id = (uint32_t)(70 - 10 * i);
        meshes[i].mask = mesh_masks[i];
    }
    scene->masked = make_fixture("masked", SEED, meshes, MESH_COUNT);
    for (size_t m = 0; m < MASK_COUNT; m++) {
        mlrt_mesh seen[MESH_COUNT];
        size_t count = 0;
        for (int i = 0; i < MESH_COUNT; i++) {
            if (is_seen(i, ray_masks[m])) seen[count++] = meshes[i];
        }
        for (size_t i = 0; i < count; i++) seen[i].mask = 0;
        scene->visible[m] = make_fixture("visible", SEED, seen, count);
    }
}

static void free_scene(struct scene *scene)
{
    free_fixture(&scene->masked);
    for (size_t m = 0; m < MASK_COUNT; m++) free_fixture(&scene->visible[m]);
    for (int i = 0; i < MESH_COUNT; i++) free_soup(&scene->parts[i]);
}

/* Random ones, and neighbours from one point: what goes alone, and what goes together. */
static struct ray_list make_rays(const struct scene *scene)
{
    struct random random = {SEED + 1};
    struct ray_list list = {NULL, 0, 0, 0};
    add_aimed_rays(&list, &random, &scene->masked, RAY_COUNT, -8, 8);
    const float eye[3] = {0.5f, 0.25f, -5};
    for (int i = 0; i < 2 * RAY_COUNT; i++) {
        const int column = i % 30 - 15, row = i % RAY_COUNT / 30 - RAY_COUNT / 60;
        const float step = i < RAY_COUNT ? 0.05f : 0.004f;
        const float direction[3] = {(float)column * step, (float)row * step, 1};
        add_ray(&list, eye, direction);
    }
    /* Some are beyond what float arithmetic carries: these go alone in double. */
    for (size_t i = 3; i < list.count; i += 11) {
        for (int k = 0; k < 3; k++) list.rays[i].direction[k] *= 0x1p80f;
    }
    for (size_t i = 0; i < list.count; i += 7) {
        list.rays[i].skip[0] = 70;
        list.rays[i].skip[1] = (uint32_t)(i & 1);
    }
    return list;
}

static void compare(const struct scene *scene, const struct variant *variant, const struct ray_list *list,
                    const mlrt_trace_options *options, const uint32_t *masks, const struct reference_hit *expected)
{
    char text[200];
    struct reference_hit *got = allocate_or_fail(list->count, sizeof *got);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    const mlrt_tree *tree = variant_tree(variant, &scene->masked);
    mlrt_rays rays = public_rays(list);
    rays.mask.data = masks;
    mlrt_hits hits = public_hits(got, 0), any = {.struct_size = sizeof any, .occluded = {occluded, 0, 0}};
    mlrt_trace_options asked = *options;
    describe("masks", &asked, variant->threads, text, sizeof text);
    assert_int_equal(mlrt_trace_packet(tree, &rays, &asked, &hits), MLRT_OK);
    asked.query = MLRT_QUERY_ANY;
    assert_int_equal(mlrt_trace_packet(tree, &rays, &asked, &any), MLRT_OK);
    for (size_t i = 0; i < list->count; i++) {
        check_hit(&scene->masked, text, i, &list->rays[i], &expected[i], &got[i]);
        assert_int_equal(occluded[i], expected[i].mesh != MLRT_NONE);
    }
    free(occluded);
    free(got);
}

static mlrt_trace_options options_of(const struct variant *variant, uint32_t mask)
{
    mlrt_trace_options options = variant->options;
    options.pool = shared_pool(variant->threads);
    options.mask = mask;
    return options;
}

static void one_mask_for_all_rays(void **state)
{
    const struct scene *scene = *state;
    struct ray_list list = make_rays(scene);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    for (size_t m = 0; m < MASK_COUNT; m++) {
        trace_reference(&scene->visible[m], &list, expected);
        for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
            const mlrt_trace_options options = options_of(variant_at(v), ray_masks[m]);
            compare(scene, variant_at(v), &list, &options, NULL, expected);
        }
    }
    free(expected);
    free_rays(&list);
}

/* Masks change from ray to ray, or every 64 rays; that of the options then counts for nothing. */
static void masks_of_their_own(void **state)
{
    const struct scene *scene = *state;
    struct ray_list list = make_rays(scene);
    struct reference_hit *all = allocate_or_fail(MASK_COUNT * list.count, sizeof *all);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    uint32_t *masks = allocate_or_fail(list.count, sizeof *masks);
    for (size_t m = 0; m < MASK_COUNT; m++) trace_reference(&scene->visible[m], &list, all + m * list.count);
    for (size_t run = 1; run <= 64; run *= 64) {
        for (size_t i = 0; i < list.count; i++) {
            const size_t m = i / run % MASK_COUNT;
            masks[i] = ray_masks[m];
            expected[i] = all[m * list.count + i];
        }
        for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
            const mlrt_trace_options options = options_of(variant_at(v), 2);
            compare(scene, variant_at(v), &list, &options, masks, expected);
        }
    }
    free(masks);
    free(expected);
    free(all);
    free_rays(&list);
}

/* What no ray may see is not tested by method tile, whether rays go together or alone. */
static void hidden_triangles_do_not_count(void **state)
{
    const struct scene *scene = *state;
    struct ray_list list = make_rays(scene);
    struct reference_hit *got = allocate_or_fail(list.count, sizeof *got);
    mlrt_mesh mesh = soup_mesh(&scene->parts[1]);
    mesh.mask = 1;
    struct fixture hidden = make_fixture("hidden", SEED, &mesh, 1);
    uint32_t tested = 0;
    for (size_t v = 0; v < variant_count(); v++) {
        for (uint32_t mask = 1; mask <= 2 && variant_at(v)->options.method == MLRT_METHOD_TILE; mask++) {
            mlrt_counters counters = {.struct_size = sizeof counters};
            mlrt_trace_options options = options_of(variant_at(v), mask);
            mlrt_rays rays = public_rays(&list);
            mlrt_hits hits = public_hits(got, 0);
            rays.skip.data = NULL;
            options.counters = &counters;
            assert_int_equal(mlrt_trace_packet(variant_tree(variant_at(v), &hidden), &rays, &options, &hits), MLRT_OK);
            assert_int_equal(counters.triangle_test_count != 0, mask == 1);
            assert_int_equal(counters.lane_test_count != 0, mask == 1);
            tested += mask;
        }
    }
    assert_true(tested > 0);
    free_fixture(&hidden);
    free(got);
    free_rays(&list);
}

static void single_rays(void **state)
{
    const struct scene *scene = *state;
    struct ray_list list = make_rays(scene);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    for (size_t m = 0; m < MASK_COUNT; m++) {
        trace_reference(&scene->visible[m], &list, expected);
        for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
            const mlrt_trace_options options = options_of(variant_at(v), ray_masks[m]);
            for (size_t i = 0; i < list.count; i += 5) {
                const struct reference_hit got =
                    trace_one(variant_tree(variant_at(v), &scene->masked), &list.rays[i], &options);
                check_hit(&scene->masked, "trace_ray", i, &list.rays[i], &expected[i], &got);
            }
        }
    }
    free(expected);
    free_rays(&list);
}

static void check_picture(const struct scene *scene, const mlrt_camera *camera, size_t m)
{
    struct ray_list list = {NULL, 0, 0, 0};
    add_camera_rays(&list, camera);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    struct reference_hit *got = allocate_or_fail(list.count, sizeof *got);
    trace_reference(&scene->visible[m], &list, expected);
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        const mlrt_trace_options options = options_of(variant_at(v), ray_masks[m]);
        const mlrt_hits frame = public_hits(got, PICTURE_SIZE);
        const mlrt_tree *tree = variant_tree(variant_at(v), &scene->masked);
        assert_int_equal(mlrt_render_tiles(tree, camera, &options, &frame, NULL, NULL), MLRT_OK);
        for (size_t i = 0; i < list.count; i++) {
            check_hit(&scene->masked, "render", i, &list.rays[i], &expected[i], &got[i]);
        }
    }
    free(got);
    free(expected);
    free_rays(&list);
}

static void pictures(void **state)
{
    const struct scene *scene = *state;
    const float eye[3] = {0.3f, 0.2f, -5}, target[3] = {0, 0, 1}, along[3] = {0.1f, 0.2f, 1};
    const mlrt_camera pinhole = look_at(eye, target, 1, PICTURE_SIZE, PICTURE_SIZE);
    const mlrt_camera parallel = look_along(eye, along, 6, PICTURE_SIZE, PICTURE_SIZE);
    for (size_t m = 0; m < MASK_COUNT; m++) {
        check_picture(scene, &pinhole, m);
        check_picture(scene, &parallel, m);
    }
}

static void shadows(void **state)
{
    const struct scene *scene = *state;
    struct random random = {SEED + 2};
    float positions[3 * 256];
    for (int i = 0; i < 256; i++) draw_point(&random, -5, 5, positions + 3 * i);
    for (int kind = MLRT_LIGHT_POINT; kind <= MLRT_LIGHT_DIRECTIONAL; kind++) {
        const mlrt_light light = {.struct_size = sizeof light, .kind = kind, .position = {1, 2, -5}};
        const mlrt_points points = {.struct_size = sizeof points, .count = 256, .positions = {positions, 0}};
        for (size_t m = 0; m < MASK_COUNT; m++) {
            uint8_t expected[256], got[256];
            const mlrt_array wanted = {expected, 0, 0}, out = {got, 0, 0};
            assert_int_equal(mlrt_occluded_points(scene->visible[m].tree, &points, &light, NULL, &wanted), MLRT_OK);
            for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
                const mlrt_trace_options options = options_of(variant_at(v), ray_masks[m]);
                const mlrt_tree *tree = variant_tree(variant_at(v), &scene->masked);
                assert_int_equal(mlrt_occluded_points(tree, &points, &light, &options, &out), MLRT_OK);
                assert_memory_equal(got, expected, sizeof got);
            }
        }
    }
}

static void all_hits(void **state)
{
    const struct scene *scene = *state;
    struct ray_list list = make_rays(scene);
    mlrt_rays rays = public_rays(&list);
    uint32_t *expected = allocate_or_fail(list.count, sizeof *expected),
             *got = allocate_or_fail(list.count, sizeof *got);
    uint32_t *masks = allocate_or_fail(list.count, sizeof *masks);
    const mlrt_hit_lists wanted = {.struct_size = sizeof wanted, .total = {expected, 0, 0}};
    const mlrt_hit_lists out = {.struct_size = sizeof out, .total = {got, 0, 0}};
    for (size_t m = 0; m < MASK_COUNT; m++) {
        mlrt_trace_options options = {.struct_size = sizeof options, .mask = ray_masks[m]};
        rays.mask.data = NULL;
        assert_int_equal(mlrt_trace_all_hits(scene->visible[m].tree, &rays, NULL, &wanted), MLRT_OK);
        assert_int_equal(mlrt_trace_all_hits(scene->masked.kdtree, &rays, &options, &out), MLRT_OK);
        assert_memory_equal(got, expected, list.count * sizeof *got);
        assert_int_equal(mlrt_trace_all_hits(scene->masked.tree, &rays, &options, &out), MLRT_OK);
        assert_memory_equal(got, expected, list.count * sizeof *got);
        for (size_t i = 0; i < list.count; i++) masks[i] = ray_masks[m];
        rays.mask.data = masks;
        options.mask = 1;
        assert_int_equal(mlrt_trace_all_hits(scene->masked.tree, &rays, &options, &out), MLRT_OK);
        assert_memory_equal(got, expected, list.count * sizeof *got);
    }
    free(masks);
    free(got);
    free(expected);
    free_rays(&list);
}

/* Where no mesh has a mask, a ray's is of no consequence, and nothing is stored. */
static void trees_without_masks(void **state)
{
    const struct scene *scene = *state;
    struct ray_list list = make_rays(scene);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    trace_reference(&scene->visible[0], &list, expected);
    mlrt_trace_options options = {.struct_size = sizeof options, .mask = 0x40};
    for (size_t i = 0; i < list.count; i += 3) {
        const struct reference_hit got = trace_one(scene->visible[0].tree, &list.rays[i], &options);
        check_hit(&scene->visible[0], "no masks", i, &list.rays[i], &expected[i], &got);
    }
    mlrt_tree_info with = {.struct_size = sizeof with}, without = with;
    assert_int_equal(mlrt_get_tree_info(scene->masked.tree, &with), MLRT_OK);
    assert_int_equal(mlrt_get_tree_info(scene->visible[0].tree, &without), MLRT_OK);
    assert_int_equal(with.memory_size - without.memory_size, 4 * with.triangle_count);
    free(expected);
    free_rays(&list);
}

static int set_up(void **state)
{
    struct scene *scene = allocate_or_fail(1, sizeof *scene);
    make_scene(scene);
    *state = scene;
    return 0;
}

static int tear_down(void **state)
{
    free_scene(*state);
    free(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_mask_for_all_rays),
        cmocka_unit_test(masks_of_their_own),
        cmocka_unit_test(hidden_triangles_do_not_count),
        cmocka_unit_test(single_rays),
        cmocka_unit_test(pictures),
        cmocka_unit_test(shadows),
        cmocka_unit_test(all_hits),
        cmocka_unit_test(trees_without_masks),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
