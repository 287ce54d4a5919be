/* SPDX-License-Identifier: MIT */
/*
 * The hash that every binding's test prints is the one of the reference's answers, and of every way of tracing.
 */
#include "../bindings/c/scene.h"
#include "support.h"

static struct scene scene;

static void make_scene_fixture(struct fixture *fixture, struct ray_list *list)
{
    mlrt_mesh meshes[SCENE_MESHES] = {{.struct_size = sizeof meshes[0]}, {.struct_size = sizeof meshes[0]}};
    make_scene(&scene);
    for (int m = 0; m < SCENE_MESHES; m++) {
        meshes[m].id = scene_ids[m];
        meshes[m].vertices = scene.vertices[m];
        meshes[m].vertex_count = SCENE_VERTICES;
        meshes[m].indices = scene.indices[m];
        meshes[m].triangle_count = SCENE_TRIANGLES;
    }
    *fixture = make_fixture("bindings", 1, meshes, SCENE_MESHES);
    for (int i = 0; i < SCENE_RAYS; i++) add_ray(list, &scene.origins[3 * i], &scene.directions[3 * i]);
}

static void the_reference_gives_the_hash(void **state)
{
    (void)state;
    static struct reference_hit hits[SCENE_RAYS];
    struct fixture fixture;
    struct ray_list list = {0};
    make_scene_fixture(&fixture, &list);
    trace_reference(&fixture, &list, hits);
    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    int of_mesh[SCENE_MESHES] = {0, 0};
    for (int i = 0; i < SCENE_RAYS; i++) {
        const struct reference_hit *hit = &hits[i];
        for (int m = 0; m < SCENE_MESHES; m++) of_mesh[m] += hit->mesh == scene_ids[m];
        hash = hash_hit(hash, hit->t, hit->u, hit->v, hit->mesh, hit->triangle, hit->facing);
    }
    free_rays(&list);
    free_fixture(&fixture);
    for (int m = 0; m < SCENE_MESHES; m++) assert_true(of_mesh[m] > SCENE_RAYS / 5);
    assert_true(of_mesh[0] + of_mesh[1] < SCENE_RAYS * 9 / 10); // some miss
    if (hash != SCENE_HASH) fail_msg("0x%016llX", (unsigned long long)hash);
}

static void every_way_of_tracing_agrees(void **state)
{
    (void)state;
    struct fixture fixture;
    struct ray_list list = {0};
    make_scene_fixture(&fixture, &list);
    list.count = scaled(list.count);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reference_gives_the_hash),
        cmocka_unit_test(every_way_of_tracing_agrees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
