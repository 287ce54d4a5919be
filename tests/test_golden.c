/* SPDX-License-Identifier: MIT */
/*
 * The golden numbers (golden.h) from every way of tracing, and the first of them from the reference.
 */
#include "golden.h"
#include "support.h"

static void assert_golden(const char *what, uint64_t hash, uint64_t expected)
{
    if (hash != expected) fail_msg("%s: 0x%016llX", what, (unsigned long long)hash);
}

static void make_scenes(struct fixture scenes[GOLDEN_SCENES])
{
    for (int s = 0; s < GOLDEN_SCENES; s++) scenes[s] = fixture_of_example(golden_scene(s));
}

static void free_scenes(struct fixture scenes[GOLDEN_SCENES])
{
    for (int s = 0; s < GOLDEN_SCENES; s++) free_fixture(&scenes[s]);
}

static void the_reference_gives_the_golden_number(void **state)
{
    (void)state;
    static struct reference_hit hits[GOLDEN_COUNT];
    static struct golden_hit golden_hits[GOLDEN_COUNT];
    struct fixture scenes[GOLDEN_SCENES];
    uint64_t hash = GOLDEN_START;
    size_t hit_count = 0;
    make_scenes(scenes);
    for (int s = 0; s < GOLDEN_SCENES; s++) {
        struct ray_list list = {0};
        mlrt_camera camera = golden_camera(s);
        add_camera_rays(&list, &camera);
        trace_reference(&scenes[s], &list, hits);
        for (int i = 0; i < GOLDEN_COUNT; i++) {
            hit_count += hits[i].mesh != MLRT_NONE;
            golden_hits[i] =
                (struct golden_hit){hits[i].t, hits[i].u, hits[i].v, hits[i].mesh, hits[i].triangle, hits[i].facing};
        }
        hash = hash_golden_hits(hash, golden_hits);
        free_rays(&list);
    }
    free_scenes(scenes);
    assert_true(hit_count > GOLDEN_COUNT); // the cameras look at something
    assert_golden("reference", hash, GOLDEN_HITS);
}

static void every_picture_gives_the_golden_number(void **state)
{
    (void)state;
    static struct golden_hit hits[GOLDEN_COUNT];
    struct fixture scenes[GOLDEN_SCENES];
    make_scenes(scenes);
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        uint64_t hash = GOLDEN_START;
        mlrt_trace_options options = variant_at(v)->options;
        options.pool = shared_pool(variant_at(v)->threads);
        for (int s = 0; s < GOLDEN_SCENES; s++) {
            assert_int_equal(golden_picture(variant_tree(variant_at(v), &scenes[s]), s, &options, hits), MLRT_OK);
            hash = hash_golden_hits(hash, hits);
        }
        assert_golden("picture", hash, GOLDEN_HITS);
    }
    free_scenes(scenes);
}

static void every_packet_gives_the_golden_number(void **state)
{
    (void)state;
    static struct golden_hit hits[GOLDEN_COUNT];
    struct fixture scenes[GOLDEN_SCENES];
    make_scenes(scenes);
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        uint64_t hash = GOLDEN_START;
        uint32_t row_length = v % 2 ? GOLDEN_WIDTH : 0;
        mlrt_trace_options options = variant_at(v)->options;
        options.pool = shared_pool(variant_at(v)->threads);
        for (int s = 0; s < GOLDEN_SCENES; s++) {
            const mlrt_tree *tree = variant_tree(variant_at(v), &scenes[s]);
            assert_int_equal(golden_packet(tree, s, &options, row_length, hits), MLRT_OK);
            hash = hash_golden_hits(hash, hits);
        }
        assert_golden("packet", hash, GOLDEN_HITS);
    }
    free_scenes(scenes);
}

static void trees_and_all_other_answers_give_the_other_golden_number(void **state)
{
    (void)state;
    struct fixture scenes[GOLDEN_SCENES];
    make_scenes(scenes);
    for (int32_t isa = MLRT_ISA_AUTO; isa <= MLRT_ISA_NEON; isa++) {
        if (!isa_is_supported(isa)) continue;
        uint64_t hash = GOLDEN_START;
        mlrt_trace_options options = {.struct_size = sizeof options, .isa = isa};
        for (int s = 0; s < GOLDEN_SCENES; s++) {
            assert_int_equal(hash_golden_rest(&hash, scenes[s].kdtree, s, &options), MLRT_OK);
            assert_int_equal(hash_golden_rest(&hash, scenes[s].tree, s, &options), MLRT_OK);
        }
        assert_golden("rest", hash, GOLDEN_REST);
    }
    free_scenes(scenes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reference_gives_the_golden_number),
        cmocka_unit_test(every_picture_gives_the_golden_number),
        cmocka_unit_test(every_packet_gives_the_golden_number),
        cmocka_unit_test(trees_and_all_other_answers_give_the_other_golden_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
