/* SPDX-License-Identifier: MIT */
/*
 * Arrays as they lie in memory: packed or with gaps, at any address that is a multiple of 4, with nothing that may be
 * touched behind their last element; rays that skip triangles of several meshes; results of all kinds, side by side.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { COUNT = 70, WORDS = 6, GUARD = 0xA5 };

/* ---- arrays that end with their memory --------------------------------------------------------------------------- */

struct array {
    unsigned char *data;
    size_t element_size;
    size_t stride;
    size_t size;
};

static struct array make_array(size_t count, size_t element_size, size_t gap)
{
    struct array array = {NULL, element_size, element_size + gap, (count - 1) * (element_size + gap) + element_size};
    array.data = allocate_guarded(array.size);
    memset(array.data, GUARD, array.size);
    return array;
}

static void free_array(struct array *array)
{
    free_guarded(array->data, array->size);
}

static mlrt_const_array input_of(const struct array *array)
{
    return (mlrt_const_array){array->data, array->stride};
}

static mlrt_array output_of(const struct array *array)
{
    return (mlrt_array){array->data, array->stride, 0};
}

static void *element_at(const struct array *array, size_t i)
{
    return array->data + i * array->stride;
}

/* What is in the gaps must stay. */
static void check_gaps(const struct array *array)
{
    for (size_t i = 0; i < array->size; i++) {
        if (i % array->stride >= array->element_size) assert_int_equal(array->data[i], GUARD);
    }
}

/* ---- scenes and rays --------------------------------------------------------------------------------------------- */

/* A torus of three meshes, whose ids are not in the order of their positions. */
static struct fixture three_meshes(void)
{
    struct soup soup = {0};
    soup_add_torus(&soup, 24, 12, 1, 0.4f);
    mlrt_mesh meshes[3];
    const size_t third = soup.count / 3;
    for (uint32_t i = 0; i < 3; i++) {
        meshes[i] = soup_mesh(&soup);
        meshes[i].id = 70 - 30 * i;
        meshes[i].vertices = soup.corners + 9 * third * i;
        meshes[i].triangle_count = i < 2 ? third : soup.count - 2 * third;
        meshes[i].vertex_count = 3 * meshes[i].triangle_count;
    }
    struct fixture fixture = make_fixture("torus of three meshes", 1900, meshes, 3);
    free_soup(&soup);
    return fixture;
}

/* Some skip what they would hit, some another mesh's, some what there is not. */
static void add_skips(const struct fixture *fixture, struct random *random, struct ray_list *list)
{
    for (size_t i = 0; i < list->count; i++) {
        struct reference_ray *ray = &list->rays[i];
        struct reference_hit hit;
        reference_trace(fixture->reference, ray, &hit);
        ray->skip[0] = hit.mesh;
        ray->skip[1] = hit.triangle;
        const uint32_t kind = draw_below(random, 8);
        if (kind == 0) ray->skip[0] = 10 + 30 * draw_below(random, 3);
        if (kind == 1) ray->skip[0] = ray->skip[1] = MLRT_NONE;
        if (kind == 2) ray->skip[1] += 1000;
        if (kind == 3) ray->skip[0] = 41;
    }
}

static void add_picture(struct ray_list *list)
{
    const float eye[3] = {0.1f, -3, 0.7f}, target[3] = {0, 0, 0};
    mlrt_camera camera = look_at(eye, target, 0.6f, 10, 7);
    add_camera_rays(list, &camera);
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

static uint32_t word_of(const struct reference_hit *hit, int word)
{
    const uint32_t words[WORDS] = {bits_of_float(hit->t), bits_of_float(hit->u), bits_of_float(hit->v), hit->mesh,
                                   hit->triangle,         (uint32_t)hit->facing};
    return words[word];
}

static void check_words(const struct array outputs[WORDS], const struct reference_hit *expected, size_t count)
{
    for (int word = 0; word < WORDS; word++) {
        for (size_t i = 0; i < count; i++) {
            uint32_t found;
            memcpy(&found, element_at(&outputs[word], i), 4);
            if (found != word_of(&expected[i], word)) {
                fail_msg("word %d of ray %zu of %zu is %08x, not %08x", word, i, count, (unsigned)found,
                         (unsigned)word_of(&expected[i], word));
            }
        }
        check_gaps(&outputs[word]);
    }
}

static void trace_closest(const struct fixture *fixture, const mlrt_rays *rays, const struct variant *variant,
                          size_t gap, const struct reference_hit *expected)
{
    struct array outputs[WORDS];
    for (int word = 0; word < WORDS; word++) outputs[word] = make_array(rays->count, 4, gap);
    mlrt_hits hits = {.struct_size = sizeof hits,
                      .t = output_of(&outputs[0]),
                      .u = output_of(&outputs[1]),
                      .v = output_of(&outputs[2]),
                      .mesh = output_of(&outputs[3]),
                      .triangle = output_of(&outputs[4]),
                      .facing = output_of(&outputs[5])};
    assert_int_equal(mlrt_trace_packet(variant_tree(variant, fixture), rays, &variant->options, &hits), MLRT_OK);
    check_words(outputs, expected, rays->count);
    for (int word = 0; word < WORDS; word++) free_array(&outputs[word]);
}

static void check_occluded_bytes(const struct array *output, const struct reference_hit *expected, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(*(unsigned char *)element_at(output, i), expected[i].mesh != MLRT_NONE);
    }
    check_gaps(output);
}

static void trace_any(const struct fixture *fixture, const mlrt_rays *rays, const struct variant *variant, size_t gap,
                      const struct reference_hit *expected)
{
    struct array output = make_array(rays->count, 1, gap);
    mlrt_hits hits = {.struct_size = sizeof hits, .occluded = output_of(&output)};
    mlrt_trace_options options = variant->options;
    options.query = MLRT_QUERY_ANY;
    assert_int_equal(mlrt_trace_packet(variant_tree(variant, fixture), rays, &options, &hits), MLRT_OK);
    check_occluded_bytes(&output, expected, rays->count);
    free_array(&output);
}

/* The first `count` rays of a list in arrays of their own. */
static void trace_arrays(const struct fixture *fixture, const struct ray_list *list, size_t count, uint32_t row_length,
                         size_t gap, const struct reference_hit *expected)
{
    struct array origins = make_array(count, 12, gap), directions = make_array(count, 12, gap);
    struct array t_min = make_array(count, 4, gap), t_max = make_array(count, 4, gap);
    struct array skip = make_array(count, 8, gap);
    for (size_t i = 0; i < count; i++) {
        memcpy(element_at(&origins, i), list->rays[i].origin, 12);
        memcpy(element_at(&directions, i), list->rays[i].direction, 12);
        memcpy(element_at(&t_min, i), &list->rays[i].t_min, 4);
        memcpy(element_at(&t_max, i), &list->rays[i].t_max, 4);
        memcpy(element_at(&skip, i), list->rays[i].skip, 8);
    }
    mlrt_rays rays = {.struct_size = sizeof rays,
                      .row_length = row_length,
                      .count = count,
                      .origins = input_of(&origins),
                      .directions = input_of(&directions),
                      .t_min = input_of(&t_min),
                      .t_max = input_of(&t_max),
                      .skip = input_of(&skip)};
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        if (!variant_at(v)->probe) continue;
        trace_closest(fixture, &rays, variant_at(v), gap, expected);
        trace_any(fixture, &rays, variant_at(v), gap, expected);
    }
    free_array(&origins);
    free_array(&directions);
    free_array(&t_min);
    free_array(&t_max);
    free_array(&skip);
}

static void trace_every_count(const struct fixture *fixture, const struct ray_list *list)
{
    static const uint32_t row_lengths[] = {0, 10, 5, 16, 4, 33, 8};
    struct reference_hit expected[COUNT];
    assert_true(list->count >= COUNT);
    struct ray_list first = *list;
    first.count = COUNT;
    trace_reference(fixture, &first, expected);
    for (size_t count = 1; count <= COUNT; count++) {
        trace_arrays(fixture, list, count, row_lengths[count % 7], count / 7 % 3 * 4, expected);
    }
    for (uint32_t row_length = 0; row_length <= 20; row_length++) {
        trace_arrays(fixture, list, COUNT, row_length, row_length % 4 * 4, expected);
    }
}

static void rays_of_one_origin(void **state)
{
    (void)state;
    struct random random = {1901};
    struct fixture fixture = three_meshes();
    struct ray_list list = {0};
    add_picture(&list);
    trace_every_count(&fixture, &list);
    add_skips(&fixture, &random, &list);
    trace_every_count(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void rays_of_many_origins(void **state)
{
    (void)state;
    struct random random = {1902};
    struct fixture fixture = three_meshes();
    struct ray_list list = {0};
    add_aimed_rays(&list, &random, &fixture, COUNT, -3, 3);
    for (size_t i = 0; i < list.count; i++) {
        if (draw_below(&random, 2)) list.rays[i].t_min = draw_range(&random, -1, 1);
        if (draw_below(&random, 2)) list.rays[i].t_max = draw_range(&random, -1, 4);
    }
    add_skips(&fixture, &random, &list);
    trace_every_count(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* Neighbours whose ranges differ: without an array, all begin at 0, or go on for ever. */
static void ranges_of_one_origin(void **state)
{
    (void)state;
    struct random random = {1907};
    struct fixture fixture = three_meshes();
    for (int given = 0; given < 4; given++) {
        struct ray_list list = {0};
        struct reference_hit expected[COUNT], got[COUNT];
        uint8_t occluded[COUNT];
        add_picture(&list);
        for (size_t i = 0; i < list.count; i++) {
            if (given & 1 && draw_below(&random, 2)) list.rays[i].t_min = draw_range(&random, 1.5f, 3.5f);
            if (given & 2 && draw_below(&random, 2)) list.rays[i].t_max = draw_range(&random, 1.5f, 3.5f);
        }
        trace_reference(&fixture, &list, expected);
        mlrt_rays rays = public_rays(&list);
        if (!(given & 1)) rays.t_min.data = NULL;
        if (!(given & 2)) rays.t_max.data = NULL;
        for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
            mlrt_trace_options options = variant_at(v)->options;
            const mlrt_tree *tree = variant_tree(variant_at(v), &fixture);
            mlrt_hits hits = public_hits(got, 0);
            assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
            hits = (mlrt_hits){.struct_size = sizeof hits, .occluded = {occluded, 0, 0}};
            options.query = MLRT_QUERY_ANY;
            assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
            for (size_t i = 0; i < list.count; i++) {
                check_hit(&fixture, "ranges", i, &list.rays[i], &expected[i], &got[i]);
                assert_int_equal(occluded[i], expected[i].mesh != MLRT_NONE);
            }
        }
        free_rays(&list);
    }
    free_fixture(&fixture);
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

static void trace_points(const struct fixture *fixture, const struct ray_list *list, const mlrt_light *light,
                         size_t count, uint32_t row_length, size_t gap, const struct reference_hit *expected)
{
    const int is_point = light->kind == MLRT_LIGHT_POINT;
    struct array positions = make_array(count, 12, gap), skip = make_array(count, 8, gap);
    for (size_t i = 0; i < count; i++) {
        // Of a point light, the list has its position and the way from there to the point.
        float point[3];
        for (int k = 0; k < 3; k++) {
            point[k] = list->rays[i].origin[k] + (is_point ? list->rays[i].direction[k] : 0);
        }
        memcpy(element_at(&positions, i), point, 12);
        memcpy(element_at(&skip, i), list->rays[i].skip, 8);
    }
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = row_length,
                                .count = count,
                                .positions = input_of(&positions),
                                .skip = input_of(&skip)};
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        const struct variant *variant = variant_at(v);
        if (!variant->probe) continue;
        struct array output = make_array(count, 1, gap);
        const mlrt_array occluded = output_of(&output);
        assert_int_equal(
            mlrt_occluded_points(variant_tree(variant, fixture), &points, light, &variant->options, &occluded),
            MLRT_OK);
        check_occluded_bytes(&output, expected, count);
        free_array(&output);
    }
    free_array(&positions);
    free_array(&skip);
}

static void trace_every_count_of_points(const struct fixture *fixture, struct ray_list *list, const mlrt_light *light)
{
    static const uint32_t row_lengths[] = {0, 10, 5, 16, 4, 33, 8};
    struct random random = {1903};
    struct reference_hit expected[COUNT];
    add_skips(fixture, &random, list);
    trace_reference(fixture, list, expected);
    for (size_t count = 1; count <= COUNT; count++) {
        trace_points(fixture, list, light, count, row_lengths[count % 7], count / 7 % 3 * 4, expected);
    }
}

/* Coordinates are small multiples of 2^-10, so that a point is its light's position and the way from there, exactly. */
static float draw_short(struct random *random)
{
    return (float)((int)draw_below(random, 4096) - 2048) / 1024;
}

static void points_of_a_point_light(void **state)
{
    (void)state;
    struct random random = {1904};
    struct fixture fixture = three_meshes();
    struct ray_list list = {0};
    const mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_POINT, .position = {0.125f, -3, 0.75f}};
    for (int i = 0; i < COUNT; i++) {
        float direction[3];
        for (int k = 0; k < 3; k++) direction[k] = draw_short(&random) - light.position[k];
        add_ray(&list, light.position, direction)->t_max = 1;
    }
    trace_every_count_of_points(&fixture, &list, &light);
    free_rays(&list);
    free_fixture(&fixture);
}

static void points_of_a_directional_light(void **state)
{
    (void)state;
    struct random random = {1905};
    struct fixture fixture = three_meshes();
    struct ray_list list = {0};
    const mlrt_light light = {
        .struct_size = sizeof light, .kind = MLRT_LIGHT_DIRECTIONAL, .position = {0.125f, -3, 0.75f}};
    for (int i = 0; i < COUNT; i++) {
        const float origin[3] = {draw_short(&random), draw_short(&random), draw_short(&random)};
        add_ray(&list, origin, light.position);
    }
    trace_every_count_of_points(&fixture, &list, &light);
    free_rays(&list);
    free_fixture(&fixture);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* Frames of all words, packed: what one triangle covers and what is missed goes out in rectangles. */
static void check_frame(const struct fixture *fixture, const mlrt_camera *camera)
{
    struct ray_list list = {0};
    add_camera_rays(&list, camera);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    trace_reference(fixture, &list, expected);
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        const struct variant *variant = variant_at(v);
        if (!variant->probe) continue;
        for (size_t gap = 0; gap <= 4; gap += 4) {
            struct array outputs[WORDS];
            for (int word = 0; word < WORDS; word++) outputs[word] = make_array(list.count, 4, gap);
            mlrt_hits frame = {.struct_size = sizeof frame,
                               .t = output_of(&outputs[0]),
                               .u = output_of(&outputs[1]),
                               .v = output_of(&outputs[2]),
                               .mesh = output_of(&outputs[3]),
                               .triangle = output_of(&outputs[4]),
                               .facing = output_of(&outputs[5])};
            assert_int_equal(
                mlrt_render_tiles(variant_tree(variant, fixture), camera, &variant->options, &frame, NULL, NULL),
                MLRT_OK);
            check_words(outputs, expected, list.count);
            for (int word = 0; word < WORDS; word++) free_array(&outputs[word]);
        }
    }
    free(expected);
    free_rays(&list);
}

static void frames_of_a_torus(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {4, 4}, {5, 3}, {37, 41}, {66, 9}, {64, 64}};
    const float eye[3] = {0.1f, -3, 0.7f}, target[3] = {0, 0, 0};
    struct fixture fixture = three_meshes();
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        const mlrt_camera camera = look_at(eye, target, 0.9f, sizes[i][0], sizes[i][1]);
        check_frame(&fixture, &camera);
    }
    free_fixture(&fixture);
}

static void frames_of_a_box(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 0.7f}, target[3] = {0, 0, 0}, lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
    struct soup soup = {0};
    soup_add_box(&soup, lo, hi);
    struct fixture fixture = fixture_of_soup("box", 1906, &soup);
    const mlrt_camera camera = look_at(eye, target, 1.2f, 83, 79);
    check_frame(&fixture, &camera);
    free_fixture(&fixture);
}

/* ---- results in structs ------------------------------------------------------------------------------------------ */

/* Where words are in a struct of so many; -1 = not asked for. */
struct layout {
    int words;
    int place[WORDS];
};

static const struct layout layouts[] = {
    {5, {0, 1, 2, 3, 4, -1}}, {6, {0, 1, 2, 3, 4, 5}},     {8, {0, 1, 2, 3, 4, -1}},    {6, {5, 4, 3, 2, 1, 0}},
    {8, {2, 3, 7, 0, 1, -1}}, {7, {0, -1, -1, 2, 3, -1}},  {2, {0, -1, -1, -1, 1, -1}}, {3, {-1, 1, 2, -1, -1, 0}},
    {7, {3, 4, 5, 0, 6, 2}},  {1, {-1, -1, -1, -1, 0, -1}}};

/* Structs that lie in rows of so many, with a gap of words after each row. */
struct structs {
    const struct layout *layout;
    size_t width;
    size_t gap;
    uint32_t *data;
    size_t size;
};

static size_t place_of(const struct structs *structs, size_t i, int word)
{
    const size_t words = (size_t)structs->layout->words, row = structs->width * words + structs->gap;
    return i / structs->width * row + i % structs->width * words + (size_t)structs->layout->place[word];
}

/* They end with their memory. */
static struct structs make_structs(const struct layout *layout, size_t count, size_t width, size_t gap)
{
    struct structs structs = {layout, width, gap, NULL, 0};
    for (int word = 0; word < WORDS; word++) {
        const size_t end = layout->place[word] < 0 ? 0 : 4 * (place_of(&structs, count - 1, word) + 1);
        if (end > structs.size) structs.size = end;
    }
    structs.data = allocate_guarded(structs.size);
    memset(structs.data, GUARD, structs.size);
    return structs;
}

static mlrt_hits hits_of_structs(const struct structs *structs)
{
    mlrt_hits hits = {.struct_size = sizeof hits};
    mlrt_array *const arrays[WORDS] = {&hits.t, &hits.u, &hits.v, &hits.mesh, &hits.triangle, &hits.facing};
    const size_t stride = 4 * (size_t)structs->layout->words;
    for (int word = 0; word < WORDS; word++) {
        if (structs->layout->place[word] < 0) continue;
        *arrays[word] = (mlrt_array){structs->data + structs->layout->place[word], stride,
                                     stride * structs->width + 4 * structs->gap};
    }
    return hits;
}

/* What was asked for is there, and nothing else was touched. */
static void check_and_free_structs(struct structs *structs, const struct reference_hit *expected, size_t count)
{
    uint32_t *image = allocate_or_fail(structs->size, 1);
    memset(image, GUARD, structs->size);
    for (size_t i = 0; i < count; i++) {
        for (int word = 0; word < WORDS; word++) {
            if (structs->layout->place[word] >= 0) image[place_of(structs, i, word)] = word_of(&expected[i], word);
        }
    }
    assert_memory_equal(structs->data, image, structs->size);
    free(image);
    free_guarded(structs->data, structs->size);
}

static void trace_to_structs(const struct fixture *fixture, const struct ray_list *list, uint32_t row_length)
{
    struct reference_hit expected[COUNT];
    trace_reference(fixture, list, expected);
    mlrt_rays rays = public_rays(list);
    rays.row_length = row_length;
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        const struct variant *variant = variant_at(v);
        for (size_t l = 0; variant->probe && l < sizeof layouts / sizeof layouts[0]; l++) {
            struct structs structs = make_structs(&layouts[l], list->count, list->count, 0);
            const mlrt_hits hits = hits_of_structs(&structs);
            assert_int_equal(mlrt_trace_packet(variant_tree(variant, fixture), &rays, &variant->options, &hits),
                             MLRT_OK);
            check_and_free_structs(&structs, expected, list->count);
        }
    }
}

static void rays_to_structs(void **state)
{
    (void)state;
    struct random random = {1908};
    struct fixture fixture = three_meshes();
    struct ray_list picture = {0}, aimed = {0};
    add_picture(&picture);
    add_aimed_rays(&aimed, &random, &fixture, COUNT, -3, 3);
    for (uint32_t row_length = 0; row_length <= 20; row_length += 5) {
        trace_to_structs(&fixture, &picture, row_length);
        trace_to_structs(&fixture, &aimed, row_length);
    }
    free_rays(&picture);
    free_rays(&aimed);
    free_fixture(&fixture);
}

/* Of a picture whole tiles are missed, and whole tiles hit one triangle. */
static void frames_in_structs(void **state)
{
    (void)state;
    const float eye[3] = {0.3f, -3, 0.7f}, target[3] = {0, 0, 0}, lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
    struct soup soup = {0};
    soup_add_box(&soup, lo, hi);
    struct fixture fixture = fixture_of_soup("box", 1909, &soup);
    const mlrt_camera camera = look_at(eye, target, 1.2f, 83, 79);
    struct ray_list list = {0};
    add_camera_rays(&list, &camera);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    trace_reference(&fixture, &list, expected);
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        const struct variant *variant = variant_at(v);
        for (size_t l = 0; variant->probe && l < sizeof layouts / sizeof layouts[0]; l++) {
            struct structs structs = make_structs(&layouts[l], list.count, camera.width, l % 3);
            const mlrt_hits frame = hits_of_structs(&structs);
            assert_int_equal(
                mlrt_render_tiles(variant_tree(variant, &fixture), &camera, &variant->options, &frame, NULL, NULL),
                MLRT_OK);
            check_and_free_structs(&structs, expected, list.count);
        }
    }
    free(expected);
    free_rays(&list);
    free_fixture(&fixture);
}

/*
 * Each direction is followed by a word, of which the first ones are the t_min of origins that sixteen rays share. The
 * last direction ends with its memory: no word follows it.
 */
static void words_between_directions_of_shared_origins(void **state)
{
    (void)state;
    enum { ORIGINS = 4, RAYS = 16 * ORIGINS, WORDS_APART = 4 };
    struct random random = {1910};
    struct fixture fixture = three_meshes();
    float origins[ORIGINS][3], t_min[ORIGINS], packed[RAYS][3], expected[RAYS], t[RAYS];
    const size_t size = ((RAYS - 1) * WORDS_APART + 3) * sizeof(float);
    float *words = allocate_guarded(size);
    memset(words, 0, size);
    for (int i = 0; i < ORIGINS; i++) {
        draw_point(&random, -3, 3, origins[i]);
        t_min[i] = words[WORDS_APART * i + 3] = draw_range(&random, 0, 1);
    }
    for (int i = 0; i < RAYS; i++) {
        for (int k = 0; k < 3; k++) packed[i][k] = draw_range(&random, -0.5f, 0.5f) - origins[i / 16][k];
        memcpy(words + (size_t)(WORDS_APART * i), packed[i], sizeof packed[i]);
    }
    mlrt_rays rays = {.struct_size = sizeof rays, .count = RAYS, .rays_per_origin = 16, .origins = {origins, 0}};
    mlrt_hits hits = {.struct_size = sizeof hits, .t = {expected, 0, 0}};
    mlrt_trace_options options = {.struct_size = sizeof options};
    rays.directions.data = packed;
    rays.t_min.data = t_min;
    assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, &options, &hits), MLRT_OK);
    rays.directions = (mlrt_const_array){words, WORDS_APART * sizeof(float)};
    rays.t_min = (mlrt_const_array){words + 3, WORDS_APART * sizeof(float)};
    hits.t.data = t;
    for (options.isa = MLRT_ISA_SCALAR; options.isa <= MLRT_ISA_NEON; options.isa++) {
        if (!isa_is_supported(options.isa)) continue;
        assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, &options, &hits), MLRT_OK);
        assert_memory_equal(t, expected, sizeof t);
    }
    free_guarded(words, size);
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_of_one_origin),
        cmocka_unit_test(rays_of_many_origins),
        cmocka_unit_test(ranges_of_one_origin),
        cmocka_unit_test(points_of_a_point_light),
        cmocka_unit_test(points_of_a_directional_light),
        cmocka_unit_test(frames_of_a_torus),
        cmocka_unit_test(frames_of_a_box),
        cmocka_unit_test(rays_to_structs),
        cmocka_unit_test(frames_in_structs),
        cmocka_unit_test(words_between_directions_of_shared_origins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
