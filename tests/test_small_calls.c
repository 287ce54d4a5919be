/* SPDX-License-Identifier: MIT */
/*
 * mlrt_trace_packet with few rays, which are traced one by one or by a worker on the stack: the answers are those of
 * method ray, for hostile rays and limits, any choice of arrays and strides, and results that lie on the rays. And
 * exception flags of calls of one ray.
 */
#include <fenv.h>
#include <math.h>
#include <string.h>

#include "hard_scenes.h"
#include "hostile_rays.h"
#include "support.h"

enum { COUNT = SANITIZED ? 120 : 360, MOST = 17, STACK_RAYS = 120 };

struct record {
    float origin[3];
    float t_min;
    float direction[3];
    float t_max;
};

struct answers {
    struct reference_hit hits[COUNT];
    uint8_t occluded[COUNT];
};

static float draw_limit(struct random *random, float usual)
{
    const float limits[] = {0, -0.0f, -1, NAN, 1e-40f, INFINITY, 1e30f, -INFINITY};
    const uint32_t i = draw_below(random, 4 * sizeof limits / sizeof limits[0]);
    return i < sizeof limits / sizeof limits[0] ? limits[i] : usual;
}

static void make_records(struct random *random, const struct fixture *fixture, struct record *records)
{
    struct ray_list list = {0};
    while (list.count < COUNT) add_hostile_rays(&list, random, fixture, draw_hostile_kind(random), 20);
    for (size_t i = 0; i < COUNT; i++) {
        const struct reference_ray *ray = &list.rays[draw_below(random, (uint32_t)list.count)];
        memcpy(records[i].origin, ray->origin, sizeof ray->origin);
        memcpy(records[i].direction, ray->direction, sizeof ray->direction);
        records[i].t_min = draw_limit(random, ray->t_min);
        records[i].t_max = draw_limit(random, ray->t_max);
    }
    free_rays(&list);
}

static mlrt_rays rays_of(const struct record *records, size_t count, int has_t_min, int has_t_max)
{
    return (mlrt_rays){.struct_size = sizeof(mlrt_rays),
                       .count = count,
                       .origins = {records->origin, sizeof *records},
                       .directions = {records->direction, sizeof *records},
                       .t_min = {has_t_min ? &records->t_min : NULL, sizeof *records},
                       .t_max = {has_t_max ? &records->t_max : NULL, sizeof *records}};
}

static void trace(const struct fixture *fixture, const mlrt_rays *rays, const mlrt_trace_options *options,
                  struct reference_hit *found, uint8_t *occluded)
{
    mlrt_hits hits = {.struct_size = sizeof hits};
    if (options->query == MLRT_QUERY_ANY)
        hits.occluded.data = occluded;
    else
        hits = public_hits(found, 0);
    assert_int_equal(mlrt_trace_packet(fixture->tree, rays, options, &hits), MLRT_OK);
}

/* Calls of 1 to MOST rays, one after the other. */
static void trace_in_pieces(struct random *random, const struct fixture *fixture, const struct record *records,
                            int has_t_min, int has_t_max, const mlrt_trace_options *options, struct answers *answers)
{
    for (size_t i = 0, count; i < COUNT; i += count) {
        count = 1 + draw_below(random, MOST);
        if (count > COUNT - i) count = COUNT - i;
        const mlrt_rays rays = rays_of(records + i, count, has_t_min, has_t_max);
        trace(fixture, &rays, options, answers->hits + i, answers->occluded + i);
    }
}

static void check_scene(const struct fixture *fixture, struct random *random)
{
    static struct answers expected, got;
    struct record records[COUNT];
    make_records(random, fixture, records);
    for (int variant = 0; variant < 8; variant++) {
        const int has_t_min = variant & 1, has_t_max = variant & 2;
        mlrt_trace_options options = {.struct_size = sizeof options,
                                      .query = variant & 4 ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST,
                                      .method = MLRT_METHOD_RAY};
        const mlrt_rays all = rays_of(records, COUNT, has_t_min, has_t_max);
        memset(&expected, 0, sizeof expected);
        memset(&got, 0, sizeof got);
        trace(fixture, &all, &options, expected.hits, expected.occluded);
        options.method = MLRT_METHOD_DEFAULT;
        trace_in_pieces(random, fixture, records, has_t_min, has_t_max, &options, &got);
        for (size_t i = 0; i < COUNT; i++) {
            if (!memcmp(&expected.hits[i], &got.hits[i], sizeof got.hits[i]) && expected.occluded[i] == got.occluded[i])
                continue;
            print_error("%s, seed %llu, variant %d: ray %zu differs\n", fixture->name,
                        (unsigned long long)fixture->seed, variant, i);
            fail();
        }
    }
}

static void same_as_in_one_call(void **state)
{
    (void)state;
    for (size_t i = first_variant(); i < hard_scene_count(); i += variant_step()) {
        struct random random = {7700 + i};
        struct fixture fixture = make_hard_scene(i);
        check_scene(&fixture, &random);
        free_fixture(&fixture);
    }
}

/* ---- any arrays ---- */

enum { MOST_RAYS = 18, CHANNELS = 6, ROOM = 8 * MOST_RAYS };

/* The elements of the input arrays: words in the order of mlrt_rays. */
enum { ORIGIN, DIRECTION, T_MIN, T_MAX, SKIP, MASK, INPUTS };
static const size_t widths[INPUTS] = {3, 3, 1, 1, 2, 1};

struct any_call {
    uint32_t elements[INPUTS][3 * MOST_RAYS]; /* as ray i has them */
    uint32_t room[INPUTS][ROOM];              /* as they lie in arrays */
    mlrt_const_array arrays[INPUTS];
    uint32_t group;
    mlrt_trace_options options;
    int has_options;
    uint32_t results[CHANNELS][ROOM];
    uint8_t occluded[ROOM];
    size_t strides[CHANNELS + 1];
    uint32_t wanted;
};

static void draw_elements(struct random *random, const struct record *records, size_t count, struct any_call *call)
{
    for (size_t i = 0; i < count; i++) {
        const struct record *record = &records[i];
        const uint32_t skip[2] = {draw_below(random, 4), draw_below(random, 64)}, masks[] = {0, 1, 2, 3, 4, 5, 6, ~0u};
        memcpy(&call->elements[ORIGIN][3 * i], record->origin, 12);
        memcpy(&call->elements[DIRECTION][3 * i], record->direction, 12);
        memcpy(&call->elements[T_MIN][i], &record->t_min, 4);
        memcpy(&call->elements[T_MAX][i], &record->t_max, 4);
        memcpy(&call->elements[SKIP][2 * i], skip, 8);
        call->elements[MASK][i] = masks[draw_below(random, 8)];
    }
}

/* Lays out one input: with one element for each `group` rays, or one for all. */
static void lay_out(struct random *random, int input, size_t count, size_t group, struct any_call *call)
{
    const size_t width = widths[input], stride = width + draw_below(random, 3);
    const int is_common = draw_below(random, 4) == 0;
    uint32_t *elements = call->elements[input];
    for (size_t i = 0; i < count; i++) {
        const size_t from = is_common ? 0 : i / group * group;
        memcpy(&elements[i * width], &elements[from * width], 4 * width);
        if (i % group == 0) memcpy(&call->room[input][i / group * stride], &elements[i * width], 4 * width);
    }
    const int is_packed = stride == width && draw_below(random, 2);
    call->arrays[input] = (mlrt_const_array){call->room[input], is_common   ? MLRT_STRIDE_ALL
                                                                : is_packed ? 0
                                                                            : 4 * stride};
}

static void draw_call(struct random *random, const struct record *records, size_t count, uint32_t given,
                      struct any_call *call)
{
    static const uint32_t groups[] = {0, 1, 2, 3, 4, 8};
    draw_elements(random, records, count, call);
    call->group = groups[draw_below(random, 6)];
    if (call->group && count % call->group) call->group = draw_below(random, 2) ? (uint32_t)count : 1;
    for (int input = 0; input < INPUTS; input++) {
        const size_t group = call->group && (input == ORIGIN || input == T_MIN || input == SKIP) ? call->group : 1;
        call->arrays[input].data = NULL;
        if (input < T_MIN || given >> (input - T_MIN) & 1) lay_out(random, input, count, group, call);
    }
    call->options = (mlrt_trace_options){.struct_size = sizeof call->options,
                                         .query = draw_below(random, 3) == 0 ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST,
                                         .isa = (int32_t)draw_below(random, MLRT_ISA_NEON + 1),
                                         .mask = draw_below(random, 8),
                                         .pool = draw_below(random, 4) ? NULL : shared_pool(2)};
    if (!isa_is_supported(call->options.isa)) call->options.isa = MLRT_ISA_AUTO;
    call->has_options = call->options.query == MLRT_QUERY_ANY || draw_below(random, 4);
    if (!call->has_options) call->options.mask = 0;
    call->wanted = 1 + draw_below(random, (1u << CHANNELS) - 1);
    for (int channel = 0; channel <= CHANNELS; channel++) call->strides[channel] = 1 + draw_below(random, 8);
    memset(call->results, 0x55, sizeof call->results);
    memset(call->occluded, 0x55, sizeof call->occluded);
}

static mlrt_array array_of(struct any_call *call, int channel)
{
    return (mlrt_array){call->wanted >> channel & 1 ? call->results[channel] : NULL, 4 * call->strides[channel], 20};
}

static void trace_call(struct random *random, const mlrt_tree *tree, size_t count, struct any_call *call)
{
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .row_length = draw_below(random, 2) ? 0 : draw_below(random, 20),
                            .count = count,
                            .origins = call->arrays[ORIGIN],
                            .directions = call->arrays[DIRECTION],
                            .t_min = call->arrays[T_MIN],
                            .t_max = call->arrays[T_MAX],
                            .skip = call->arrays[SKIP],
                            .mask = call->arrays[MASK],
                            .rays_per_origin = call->group};
    mlrt_hits hits = {.struct_size = sizeof hits};
    if (call->options.query == MLRT_QUERY_ANY)
        hits.occluded = (mlrt_array){call->occluded, call->strides[CHANNELS], 20};
    else
        hits = (mlrt_hits){.struct_size = sizeof hits,
                           .t = array_of(call, 0),
                           .u = array_of(call, 1),
                           .v = array_of(call, 2),
                           .mesh = array_of(call, 3),
                           .triangle = array_of(call, 4),
                           .facing = array_of(call, 5)};
    assert_int_equal(mlrt_trace_packet(tree, &rays, call->has_options ? &call->options : NULL, &hits), MLRT_OK);
}

/* Ray i by method ray. */
static mlrt_hit expect_hit(const mlrt_tree *tree, const struct any_call *call, size_t i)
{
    const uint32_t own_mask = call->arrays[MASK].data ? call->elements[MASK][i] : call->options.mask;
    const mlrt_trace_options options = {
        .struct_size = sizeof options, .query = call->options.query, .method = MLRT_METHOD_RAY, .mask = own_mask};
    mlrt_ray ray = {.struct_size = sizeof ray, .flags = call->arrays[SKIP].data ? MLRT_RAY_SKIP : 0};
    mlrt_hit hit = {.struct_size = sizeof hit};
    memcpy(ray.origin, &call->elements[ORIGIN][3 * i], 12);
    memcpy(ray.direction, &call->elements[DIRECTION][3 * i], 12);
    if (call->arrays[T_MIN].data) memcpy(&ray.t_min, &call->elements[T_MIN][i], 4);
    if (call->arrays[T_MAX].data) memcpy(&ray.t_max, &call->elements[T_MAX][i], 4);
    if (call->arrays[T_MAX].data && ray.t_max == 0) ray.t_max = -1; /* 0 is a limit in an array, and none here */
    if (call->arrays[SKIP].data) {
        ray.skip_mesh = call->elements[SKIP][2 * i];
        ray.skip_triangle = call->elements[SKIP][2 * i + 1];
    }
    assert_int_equal(mlrt_trace_ray(tree, &ray, &options, &hit), MLRT_OK);
    return hit;
}

/* Compares all bytes of the results: those of hits, and those between, which stay. Returns the first wrong ray. */
static size_t find_difference(const mlrt_tree *tree, const struct any_call *call, size_t count)
{
    static uint32_t expected[CHANNELS][ROOM];
    uint8_t occluded[ROOM];
    memset(expected, 0x55, sizeof expected);
    memset(occluded, 0x55, sizeof occluded);
    for (size_t i = 0; i < count; i++) {
        const mlrt_hit hit = expect_hit(tree, call, i);
        const int any = call->options.query == MLRT_QUERY_ANY;
        if (any) occluded[i * call->strides[CHANNELS]] = (uint8_t)hit.occluded;
        for (int channel = 0; channel < CHANNELS; channel++) {
            uint32_t *place = &expected[channel][i * call->strides[channel]];
            if (!any && call->wanted >> channel & 1) memcpy(place, (const char *)&hit.t + 4 * channel, 4);
            if (*place != call->results[channel][i * call->strides[channel]]) return i;
        }
        if (occluded[i * call->strides[CHANNELS]] != call->occluded[i * call->strides[CHANNELS]]) return i;
    }
    return memcmp(expected, call->results, sizeof expected) || memcmp(occluded, call->occluded, sizeof occluded)
               ? 0
               : count;
}

/* Each choice of optional arrays, for each number of rays up to one more than a packet has. */
static void check_all_arrays(struct random *random, const struct fixture *fixture, size_t rounds)
{
    static struct any_call call;
    static struct record records[COUNT];
    make_records(random, fixture, records);
    for (size_t round = 0; round < rounds; round++) {
        for (size_t count = 1; count < MOST_RAYS; count++) {
            const uint32_t given = draw_below(random, 16);
            const uint64_t state = random->state;
            draw_call(random, records + draw_below(random, COUNT - MOST_RAYS), count, given, &call);
            trace_call(random, fixture->tree, count, &call);
            const size_t wrong = find_difference(fixture->tree, &call, count);
            if (wrong == count) continue;
            fail_msg("%s, random state %llu: ray %zu of %zu differs; optional arrays %#x, group %u, isa %d, query %d",
                     fixture->name, (unsigned long long)state, wrong, count, (unsigned)given, (unsigned)call.group,
                     (int)call.options.isa, (int)call.options.query);
        }
    }
}

static void any_arrays(void **state)
{
    (void)state;
    for (size_t i = 0; i < hard_scene_count(); i++) {
        struct random random = {8800 + i};
        struct fixture fixture = make_hard_scene(i);
        check_all_arrays(&random, &fixture, scaled(10));
        free_fixture(&fixture);
    }
}

/* Three meshes with masks. */
static void any_arrays_with_masks(void **state)
{
    (void)state;
    struct random random = {4242};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 240, 10, 4);
    mlrt_mesh meshes[3];
    for (uint32_t i = 0; i < 3; i++) {
        meshes[i] = soup_mesh(&soup);
        meshes[i].vertices = soup.corners + i * 80 * 9;
        meshes[i].vertex_count = 240;
        meshes[i].triangle_count = 80;
        meshes[i].id = i;
        meshes[i].mask = 1u << i;
    }
    struct fixture fixture = make_fixture("masks", random.state, meshes, 3);
    check_all_arrays(&random, &fixture, scaled(240));
    free_fixture(&fixture);
    free_soup(&soup);
}

/* t of ray i goes to a number of ray i + 1: all rays are read before a result is written. */
static void results_on_the_rays(void **state)
{
    (void)state;
    const float wall[9] = {-9, -9, 5, 9, -9, 5, 0, 9, 5};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = wall, .vertex_count = 3, .triangle_count = 1};
    mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
    for (size_t count = 1; count <= MOST; count++) {
        for (int word = 0; word < 8; word++) {
            struct record records[MOST + 1];
            for (size_t i = 0; i <= MOST; i++) {
                records[i] = (struct record){{0, 0, (float)i}, 0, {0, 0, 1}, 100};
            }
            const mlrt_rays rays = rays_of(records, count, 1, 1);
            const mlrt_hits hits = {.struct_size = sizeof hits,
                                    .t = {(char *)&records[1] + 4 * word, sizeof *records, 0}};
            assert_int_equal(mlrt_trace_packet(tree, &rays, NULL, &hits), MLRT_OK);
            for (size_t i = 0; i < count; i++) {
                float t;
                memcpy(&t, (const char *)&records[i + 1] + 4 * word, sizeof t);
                assert_float_equal(t, 5 > (float)i ? 5 - (float)i : INFINITY, 0);
            }
        }
    }
    mlrt_destroy_tree(tree);
}

/* A byte array, with a stride, for any hit; bytes between its elements stay. */
static void bytes_between_results_stay(void **state)
{
    (void)state;
    const float wall[9] = {-9, -9, 5, 9, -9, 5, 0, 9, 5};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = wall, .vertex_count = 3, .triangle_count = 1};
    const mlrt_trace_options options = {.struct_size = sizeof options, .query = MLRT_QUERY_ANY};
    mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
    for (size_t count = 1; count <= MOST; count++) {
        struct record records[MOST];
        uint8_t bytes[3 * MOST];
        memset(bytes, 7, sizeof bytes);
        for (size_t i = 0; i < MOST; i++) records[i] = (struct record){{0, 0, 0}, 0, {0, 0, i % 2 ? 1.0f : -1.0f}, 100};
        const mlrt_rays rays = rays_of(records, count, 1, 1);
        const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {bytes, 3, 0}};
        assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
        for (size_t i = 0; i < sizeof bytes; i++) {
            assert_int_equal(bytes[i], i % 3 == 0 && i / 3 < count ? (i / 3) % 2 : 7);
        }
    }
    mlrt_destroy_tree(tree);
}

/* A triangle without area, so small or large that boxes have another unit, leaves a tree without nodes. */
static void trees_without_nodes(void **state)
{
    (void)state;
    for (int exponent = -60; exponent <= 60; exponent += 60) {
        const float x = ldexpf(1, exponent);
        const float line[9] = {x, x, x, 2 * x, x, x, 3 * x, x, x};
        const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = line, .vertex_count = 3, .triangle_count = 1};
        const mlrt_ray ray = {.struct_size = sizeof ray, .origin = {2 * x, x, 0}, .direction = {0, 0, 1}};
        mlrt_hit hit = {.struct_size = sizeof hit};
        float t = 0;
        const mlrt_rays rays = {
            .struct_size = sizeof rays, .count = 1, .origins = {ray.origin, 0}, .directions = {ray.direction, 0}};
        const mlrt_hits hits = {.struct_size = sizeof hits, .t = {&t, 0, 0}};
        mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
        assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, &hit), MLRT_OK);
        assert_int_equal(mlrt_trace_packet(tree, &rays, NULL, &hits), MLRT_OK);
        assert_int_equal(hit.triangle, MLRT_NONE);
        assert_true(isinf(t));
        mlrt_destroy_tree(tree);
    }
}

/* Mistakes are found however few the rays are. */
static void mistakes_are_errors(void **state)
{
    (void)state;
    const float wall[9] = {-9, -9, 5, 9, -9, 5, 0, 9, 5};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = wall, .vertex_count = 3, .triangle_count = 1};
    mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
    struct record records[1] = {{{0, 0, 0}, 0, {0, 0, 1}, 100}};
    float t[2];
    uint8_t occluded[1];
    for (int mistake = 0; mistake < 10; mistake++) {
        mlrt_rays rays = rays_of(records, 1, 1, 1);
        mlrt_hits hits = {.struct_size = sizeof hits, .t = {t, 0, 0}};
        mlrt_trace_options options = {.struct_size = sizeof options};
        if (mistake == 1) rays.origins.stride = 13;
        if (mistake == 2) rays.directions.stride = 14;
        if (mistake == 3) rays.directions.data = NULL;
        if (mistake == 4) rays.reserved = 1;
        if (mistake == 5) hits.occluded.data = occluded;
        if (mistake == 6) hits.t.stride = 2;
        if (mistake == 7) hits.t.data = (unsigned char *)t + 1;
        if (mistake == 8) options.query = 2;
        if (mistake == 9) options.query = MLRT_QUERY_ANY;
        const int32_t status = mlrt_trace_packet(tree, &rays, &options, &hits);
        if (status != (mistake ? MLRT_ERROR_ARGUMENT : MLRT_OK))
            fail_msg("mistake %d: status %d", mistake, (int)status);
    }
    mlrt_destroy_tree(tree);
}

/* Calls lower no exception flag of the caller. */
static void no_flag_is_lowered(void **state)
{
    (void)state;
    static struct record records[COUNT];
    int wrong = 0;
    for (size_t i = 0; i < hard_scene_count(); i++) {
        struct random random = {9900 + i};
        struct fixture fixture = make_hard_scene(i);
        make_records(&random, &fixture, records);
        for (size_t j = 0; j < COUNT; j++) {
            const int flags = j % 2 ? FE_INEXACT | FE_OVERFLOW : 0;
            mlrt_ray ray = {.struct_size = sizeof ray, .t_min = records[j].t_min, .t_max = records[j].t_max};
            mlrt_hit hit = {.struct_size = sizeof hit};
            memcpy(ray.origin, records[j].origin, sizeof ray.origin);
            memcpy(ray.direction, records[j].direction, sizeof ray.direction);
            volatile float large = 0x1.8p127f;
            feclearexcept(FE_ALL_EXCEPT);
            if (flags) large *= 3; /* feraiseexcept may raise the flag of another unit */
            mlrt_trace_ray(fixture.tree, &ray, NULL, &hit);
            const int found = fetestexcept(FE_ALL_EXCEPT);
            if ((found & flags) == flags) continue;
            print_error("%s: ray %zu, flags %#x in place of %#x, o = (%a, %a, %a), d = (%a, %a, %a), t in (%a, %a]\n",
                        fixture.name, j, (unsigned)found, (unsigned)flags, (double)ray.origin[0], (double)ray.origin[1],
                        (double)ray.origin[2], (double)ray.direction[0], (double)ray.direction[1],
                        (double)ray.direction[2], (double)ray.t_min, (double)ray.t_max);
            wrong++;
        }
        free_fixture(&fixture);
    }
    assert_int_equal(wrong, 0);
}

/*
 * As many sheets of one triangle as a seed draws, each corner up to 3 floats aside, beside, behind and in each other.
 */
static struct fixture make_stack(struct random *random, uint64_t seed)
{
    struct soup soup = {0};
    const uint32_t sheets = 2 + draw_below(random, 40);
    const int is_flat = (int)draw_below(random, 2), aside = (int)draw_below(random, 4);
    float corner[3][3];
    for (int i = 0; i < 3; i++) draw_point(random, i ? -4 : 1, i ? 4 : 2, corner[i]);
    for (int i = 1; i < 3 && is_flat; i++) corner[i][2] = corner[0][2];
    for (uint32_t sheet = 0; sheet < sheets; sheet++) {
        const uint32_t first = draw_below(random, 3);
        const int stays = (int)draw_below(random, 4) == 0;
        float moved[3][3];
        for (uint32_t i = 0; i < 3; i++) {
            for (int k = 0; k < 3; k++) {
                const int floats = (int)draw_below(random, 2 * (uint32_t)aside + 1) - aside;
                moved[i][k] = next_float(corner[(first + i) % 3][k], stays ? 0 : floats);
            }
        }
        soup_add_triangle(&soup, moved[0], moved[1], moved[2]);
    }
    return fixture_of_soup("stack", seed, &soup);
}

/* Traces the rays of a list in one call, or each in a call of its own, and compares with exact arithmetic. */
static void check_list(const struct fixture *fixture, const struct ray_list *list, const struct reference_hit *expected,
                       const mlrt_trace_options *options, size_t call)
{
    for (size_t i = 0; i < list->count; i += call) {
        const struct ray_list part = {list->rays + i, call, 0, 0};
        struct reference_hit found[STACK_RAYS];
        const mlrt_rays rays = public_rays(&part);
        trace(fixture, &rays, options, found, NULL);
        for (size_t k = 0; k < call; k++) {
            if (same_hit(&expected[i + k], &found[k])) continue;
            fail_msg("stack %llu, ray %zu, calls of %zu, isa %d", (unsigned long long)fixture->seed, i + k, call,
                     (int)options->isa);
        }
    }
}

/*
 * Stacks of sheets that lie closer to each other than float can tell: rays meet a chain of close calls there, with ties
 * that the first triangle wins.
 */
static void stacks_of_sheets(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        struct random random = {7100 + seed};
        struct ray_list list = {0};
        struct reference_hit expected[STACK_RAYS];
        struct fixture fixture = make_stack(&random, seed);
        add_aimed_rays(&list, &random, &fixture, STACK_RAYS / 2, -9, 9);
        add_surface_rays(&list, &random, &fixture, STACK_RAYS / 2);
        list.count = STACK_RAYS;
        for (size_t i = 0; i < list.count; i++) {
            if (i % 5 == 4) list.rays[i].t_min = draw_range(&random, 0, 2);
            reference_trace(fixture.reference, &list.rays[i], &expected[i]);
        }
        for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
            mlrt_trace_options options = {.struct_size = sizeof options, .isa = isa};
            if (!isa_is_supported(isa)) continue;
            check_list(&fixture, &list, expected, &options, 1);
            check_list(&fixture, &list, expected, &options, STACK_RAYS);
            options.method = MLRT_METHOD_RAY;
            check_list(&fixture, &list, expected, &options, STACK_RAYS);
        }
        free_rays(&list);
        free_fixture(&fixture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_as_in_one_call),        cmocka_unit_test(results_on_the_rays),
        cmocka_unit_test(bytes_between_results_stay), cmocka_unit_test(trees_without_nodes),
        cmocka_unit_test(mistakes_are_errors),        cmocka_unit_test(no_flag_is_lowered),
        cmocka_unit_test(stacks_of_sheets),           cmocka_unit_test(any_arrays),
        cmocka_unit_test(any_arrays_with_masks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
