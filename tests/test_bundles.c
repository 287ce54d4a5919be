/* SPDX-License-Identifier: MIT */
/*
 * Arrays of rays that are alike, in every form that mlrt_rays allows: method tile with each instruction set, closest
 * and any hit, against method ray bit for bit, and a part of the rays against the reference.
 *
 * A case is a number. It says which kind of bundle (bundle_rays.h) goes into which world (worlds.h), and the seed from
 * which all else is drawn: how many rays, in rows or as a list, their ranges, skips, masks, strides. A failure prints the
 * number.
 *
 *     test_bundles COUNT [FIRST]
 *
 * runs so many cases from the number FIRST on, and says how many answers were compared.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bundle_rays.h"
#include "hostile_rays.h"
#include "worlds.h"

static uint64_t case_count, first_case;
static uint64_t answer_count, judged_count, ray_count;

/* ---- worlds ------------------------------------------------------------------------------------------------------ */

enum { WORLD_LIMIT = 64 };

/* The worlds that were last asked for. */
static struct {
    uint64_t number;
    int is_there;
    struct world world;
} worlds[WORLD_LIMIT];

static struct world *find_world(uint64_t number)
{
    const size_t i = number % WORLD_LIMIT;
    if (!worlds[i].is_there || worlds[i].number != number) {
        free_world(&worlds[i].world);
        make_world(number, 0, &worlds[i].world);
    }
    worlds[i].number = number;
    worlds[i].is_there = 1;
    return &worlds[i].world;
}

static int free_worlds(void **state)
{
    (void)state;
    for (int i = 0; i < WORLD_LIMIT; i++) free_world(&worlds[i].world);
    return 0;
}

/* ---- what each ray has besides ----------------------------------------------------------------------------------- */

static float draw_odd_limit(struct random *random, float t)
{
    const float below = isfinite(t) ? next_float(t, -1) : t;
    const float odd[] = {0.0f,     -0.0f,     -1.0f, 1.0f,    0x1p-140f, -0x1p-140f, 0x1p-149f,
                         INFINITY, -INFINITY, NAN,   FLT_MAX, -FLT_MAX,  t,          below};
    return odd[draw_below(random, sizeof odd / sizeof odd[0])];
}

/* Ends or begins the range at a hit, or a float aside. */
static void limit_near_hit(struct reference_ray *ray, struct random *random, float t)
{
    if (!isfinite(t)) return;
    const float near = next_float(t, (int)draw_below(random, 3) - 1);
    if (draw_below(random, 2))
        ray->t_max = near;
    else
        ray->t_min = near;
    if (draw_below(random, 8) == 0) ray->t_min = ray->t_max = near;
}

static void set_ranges(struct ray_list *list, struct random *random, const struct reference_hit *hits)
{
    const uint32_t kind = draw_below(random, 12);
    const float t = hits[draw_below(random, (uint32_t)list->count)].t;
    const float common = isfinite(t) ? t : 1, least = draw_odd_limit(random, common);
    for (size_t i = 0; i < list->count; i++) {
        struct reference_ray *ray = &list->rays[i];
        switch (kind) {
        case 0: // one for all
            ray->t_max = common;
            break;
        case 1:
            ray->t_min = least;
            break;
        case 2:
        case 7:
            limit_near_hit(ray, random, hits[i].t);
            break;
        case 3:
            ray->t_min = draw_odd_limit(random, hits[i].t);
            ray->t_max = draw_odd_limit(random, hits[i].t);
            break;
        case 4: // most are empty
            ray->t_max = common;
            ray->t_min = next_float(common, (int)draw_below(random, 4) - 1);
            break;
        case 5: // a few
            if (draw_below(random, 24)) break;
            ray->t_min = draw_below(random, 2) ? draw_odd_limit(random, hits[i].t) : ray->t_min;
            ray->t_max = draw_odd_limit(random, hits[i].t);
            break;
        case 6:
            ray->t_max = common * draw_range(random, 0.5f, 1.5f);
            break;
        default:
            return;
        }
    }
}

static void set_skips(struct ray_list *list, struct random *random, const struct world *world,
                      const struct reference_hit *hits)
{
    static const uint32_t wrong[] = {MLRT_NONE, 0x80000000u, 0x7FFFFFFFu, 1000000, 0};
    const uint32_t kind = draw_below(random, 10);
    const struct reference_hit *one = &hits[draw_below(random, (uint32_t)list->count)];
    for (size_t i = 0; i < list->count; i++) {
        uint32_t *skip = list->rays[i].skip;
        const struct reference_hit *hit = kind == 1 ? one : &hits[i];
        if (kind > 3) return;
        skip[0] = hit->mesh;
        skip[1] = hit->triangle;
        if (kind >= 2 && draw_below(random, kind == 2 ? 2 : 16) == 0) {
            skip[draw_below(random, 2)] = wrong[draw_below(random, 5)];
            if (draw_below(random, 3) == 0) skip[0] = world->mesh_count ? world->meshes[0].id : 0;
            if (draw_below(random, 3) == 0) skip[1] = draw_below(random, (uint32_t)world->soup.count + 1);
        }
    }
}

/* Of a ray; 0 is all bits. */
static const uint32_t ray_masks[] = {0, 1, 2, 3, 4, 8, 0x80000000u, 0xFFFFFFFFu};

enum { RAY_MASK_COUNT = sizeof ray_masks / sizeof ray_masks[0] };

/* Masks of rays: none, one for all, one for each, or for each 16. Returns whether there are any. */
static int set_masks(uint32_t *masks, size_t count, struct random *random, uint32_t *common_mask)
{
    const uint32_t kind = draw_below(random, 6);
    *common_mask = draw_below(random, 4) ? 0 : ray_masks[draw_below(random, RAY_MASK_COUNT)];
    uint32_t mask = ray_masks[draw_below(random, RAY_MASK_COUNT)];
    for (size_t i = 0; i < count; i++) {
        if (kind == 1 || (kind == 2 && i % 16 == 0)) mask = ray_masks[draw_below(random, RAY_MASK_COUNT)];
        masks[i] = mask;
    }
    return kind < 3;
}

/* ---- arrays of the caller's -------------------------------------------------------------------------------------- */

enum { ORIGIN, DIRECTION, T_MIN, T_MAX, SKIP, MASK, FIELD_COUNT };

static const size_t field_sizes[FIELD_COUNT] = {12, 12, 4, 4, 8, 4};

#define APART ((size_t)-1)

/* A struct of the caller's for a ray, or of a part of it. The other fields have arrays of their own. */
static const struct layout {
    size_t stride; /* 0 = no struct: all arrays are packed */
    size_t offsets[FIELD_COUNT];
} layouts[] = {
    {0, {APART, APART, APART, APART, APART, APART}},
    {4, {APART, APART, APART, APART, APART, APART}}, // arrays of their own, with gaps
    {24, {0, 12, APART, APART, APART, APART}},
    {28, {0, 12, APART, 24, APART, APART}},
    {32, {0, 16, 12, 28, APART, APART}},
    {32, {0, 12, APART, 24, APART, 28}},
    {36, {12, 0, APART, 24, 28, APART}},
    {40, {0, 12, 24, 28, 32, APART}},
    {64, {0, 16, 32, 36, 40, 48}},
};

enum { LAYOUT_COUNT = sizeof layouts / sizeof layouts[0], BLOCK_LIMIT = FIELD_COUNT + 1 };

struct arrays {
    void *blocks[BLOCK_LIMIT];
    size_t sizes[BLOCK_LIMIT];
    mlrt_rays rays;
};

static mlrt_const_array *array_of(mlrt_rays *rays, int field)
{
    mlrt_const_array *const arrays[FIELD_COUNT] = {&rays->origins, &rays->directions, &rays->t_min,
                                                   &rays->t_max,   &rays->skip,       &rays->mask};
    return arrays[field];
}

static const void *field_of(const struct ray_list *list, const uint32_t *masks, int field, size_t i)
{
    const struct reference_ray *ray = &list->rays[i];
    const void *const fields[FIELD_COUNT] = {ray->origin, ray->direction, &ray->t_min,
                                             &ray->t_max, ray->skip,      &masks[i]};
    return fields[field];
}

/* The arrays that must be there: those with an element that differs from what their absence means. */
static uint32_t needed_fields(const struct ray_list *list, int has_masks)
{
    uint32_t needed = 1u << ORIGIN | 1u << DIRECTION | (uint32_t)has_masks << MASK;
    for (size_t i = 0; i < list->count; i++) {
        const struct reference_ray *ray = &list->rays[i];
        if (bits_of_float(ray->t_min) != 0) needed |= 1u << T_MIN;
        if (bits_of_float(ray->t_max) != bits_of_float(INFINITY)) needed |= 1u << T_MAX;
        if (ray->skip[0] != MLRT_NONE) needed |= 1u << SKIP;
    }
    return needed;
}

static struct arrays make_arrays(const struct ray_list *list, const uint32_t *masks, uint32_t fields,
                                 const struct layout *layout)
{
    struct arrays arrays = {.rays = {.struct_size = sizeof arrays.rays, .count = list->count}};
    const size_t count = list->count;
    const int is_struct = layout->offsets[ORIGIN] != APART;
    if (is_struct) {
        arrays.sizes[FIELD_COUNT] = count * layout->stride;
        arrays.blocks[FIELD_COUNT] = allocate_guarded(arrays.sizes[FIELD_COUNT]);
        memset(arrays.blocks[FIELD_COUNT], 0xFF, arrays.sizes[FIELD_COUNT]);
    }
    for (int f = 0; f < FIELD_COUNT; f++) {
        if (!(fields >> f & 1)) continue;
        size_t stride = layout->stride;
        unsigned char *data;
        if (layout->offsets[f] != APART) {
            data = (unsigned char *)arrays.blocks[FIELD_COUNT] + layout->offsets[f];
        } else {
            stride = field_sizes[f] + (is_struct || !stride ? 0 : 4 * ((size_t)f + 1));
            arrays.sizes[f] = (count - 1) * stride + field_sizes[f];
            data = arrays.blocks[f] = allocate_guarded(arrays.sizes[f]);
            memset(data, 0xFF, arrays.sizes[f]);
        }
        for (size_t i = 0; i < count; i++) memcpy(data + i * stride, field_of(list, masks, f, i), field_sizes[f]);
        const int may_be_zero = stride == field_sizes[f] && (f + count) % 2;
        *array_of(&arrays.rays, f) = (mlrt_const_array){data, may_be_zero ? 0 : stride};
    }
    return arrays;
}

static void free_arrays(struct arrays *arrays)
{
    for (int i = 0; i < BLOCK_LIMIT; i++) {
        if (arrays->blocks[i]) free_guarded(arrays->blocks[i], arrays->sizes[i]);
    }
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

enum { OUTPUT_COUNT = 6 };

/* Where results go: which of the six, packed one array after the other (stride 0), or in structs. */
struct output {
    uint32_t wanted;
    size_t stride;
    uint32_t first; /* which of them comes first in the struct */
};

static struct output draw_output(struct random *random)
{
    static const size_t strides[] = {0, 24, 28, 32, 64};
    struct output output = {.wanted = 0x3F, .stride = strides[draw_below(random, 5)], .first = draw_below(random, 6)};
    if (draw_below(random, 3) == 0) output.wanted = 1 + draw_below(random, 0x3F);
    if (draw_below(random, 4) == 0) output.wanted = 0x10 | draw_below(random, 2); // triangle, or triangle and t
    return output;
}

static size_t output_size(const struct output *output, size_t count)
{
    return count * (output->stride ? output->stride : 4 * OUTPUT_COUNT);
}

static unsigned char *output_place(const struct output *output, unsigned char *block, size_t count, uint32_t field)
{
    return block + (output->stride ? 4 * ((field + output->first) % OUTPUT_COUNT) : 4 * field * count);
}

static mlrt_hits hits_of_output(const struct output *output, unsigned char *block, size_t count)
{
    mlrt_hits hits = {.struct_size = sizeof hits};
    mlrt_array *const arrays[OUTPUT_COUNT] = {&hits.t, &hits.u, &hits.v, &hits.mesh, &hits.triangle, &hits.facing};
    for (uint32_t f = 0; f < OUTPUT_COUNT; f++) {
        if (output->wanted >> f & 1)
            *arrays[f] = (mlrt_array){output_place(output, block, count, f), output->stride, 0};
    }
    return hits;
}

/* What the memory holds after the call: 0x77 wherever nothing is to be written. */
static void fill_expected(const struct output *output, const struct reference_hit *hits, size_t count,
                          unsigned char *block)
{
    const size_t stride = output->stride ? output->stride : 4;
    memset(block, 0x77, output_size(output, count));
    for (uint32_t f = 0; f < OUTPUT_COUNT; f++) {
        unsigned char *at = output_place(output, block, count, f);
        for (size_t i = 0; output->wanted >> f & 1 && i < count; i++) {
            const void *const fields[OUTPUT_COUNT] = {&hits[i].t,    &hits[i].u,        &hits[i].v,
                                                      &hits[i].mesh, &hits[i].triangle, &hits[i].facing};
            memcpy(at + i * stride, fields[f], 4);
        }
    }
}

/* The results that a block holds; those that are not wanted as they are in `expected`. */
static void read_output(const struct output *output, unsigned char *block, const struct reference_hit *expected,
                        size_t i, size_t count, struct reference_hit *got)
{
    const size_t stride = output->stride ? output->stride : 4;
    void *const fields[OUTPUT_COUNT] = {&got->t, &got->u, &got->v, &got->mesh, &got->triangle, &got->facing};
    *got = expected[i];
    for (uint32_t f = 0; f < OUTPUT_COUNT; f++) {
        if (output->wanted >> f & 1) memcpy(fields[f], output_place(output, block, count, f) + i * stride, 4);
    }
}

/* ---- a case ------------------------------------------------------------------------------------------------------ */

struct bundle {
    struct world *world;
    struct ray_list list;
    uint32_t *masks;
    int has_masks;
    uint32_t common_mask;
    uint32_t fields;
    struct reference_hit *expected;
    char name[300];
};

/* A few sizes at which blocks, tiles and rows end, and any. */
static struct bundle_shape draw_shape(struct random *random)
{
    static const uint32_t sizes[] = {1, 2, 3, 4, 5, 15, 16, 17, 63, 64, 65, 255, 256, 257, 511, 513, 1023, 1025};
    const uint32_t kind = draw_below(random, 8), limit = (uint32_t)scaled(kind == 7 ? 3000 : 700);
    struct bundle_shape shape = {1 + draw_below(random, limit), 16 + draw_below(random, 85)};
    if (kind < 2) shape.count = sizes[draw_below(random, sizeof sizes / sizeof sizes[0])];
    if (kind == 2) shape.count = shape.width * (1 + draw_below(random, 16));
    if (kind == 3) shape = (struct bundle_shape){1024, 32};
    if (draw_below(random, 3) == 0) shape.width = 16 << draw_below(random, 3);
    return shape;
}

/*
 * The shape of a case. Now and then there are enough rays for tiles that go both ways, as a bundle and lane by lane: the
 * first is the eighth tile of a worker (MLRT_FIRST_TRIAL, src/base/tuning.h).
 */
static struct bundle_shape shape_of_case(uint64_t number, struct random *random)
{
    struct bundle_shape shape = draw_shape(random);
    const uint64_t world = number / bundle_kind_count();
    if (world % 16 == 15) shape.count = 2304 + (uint32_t)(world / 16 * 97 % 2048);
    return shape;
}

static uint32_t draw_row_length(struct random *random, struct bundle_shape shape)
{
    const uint32_t kind = draw_below(random, 8);
    if (kind < 5) return shape.width;
    if (kind < 7) return 0;
    return 16 + draw_below(random, 85);
}

static void fail_case(const struct bundle *bundle, const char *what, size_t i, const struct reference_hit *expected,
                      const struct reference_hit *got)
{
    char text[500];
    snprintf(text, sizeof text, "%s, %s, mask %#x", bundle->name, what,
             (unsigned)(bundle->has_masks ? bundle->masks[i] : bundle->common_mask));
    print_difference(&bundle->world->fixture, text, i, &bundle->list.rays[i], expected, got);
    print_error("  again: test_bundles 1 %llu\n", (unsigned long long)bundle->world->fixture.seed);
    fail();
}

/* Method ray against the reference, in up to 48 rays. */
static void judge(struct bundle *bundle, struct random *random)
{
    const size_t step = bundle->list.count / 48 + 1;
    for (size_t i = draw_below(random, (uint32_t)step); i < bundle->list.count; i += step) {
        const uint32_t mask = bundle->has_masks ? bundle->masks[i] : bundle->common_mask;
        struct reference_hit hit;
        reference_trace(visible_part(bundle->world, mask), &bundle->list.rays[i], &hit);
        if (!same_hit(&hit, &bundle->expected[i])) fail_case(bundle, "method ray", i, &hit, &bundle->expected[i]);
        judged_count++;
    }
}

static void check_closest(const struct bundle *bundle, const mlrt_rays *rays, const mlrt_trace_options *options,
                          struct random *random, const char *text)
{
    const size_t count = bundle->list.count;
    const struct output output = draw_output(random);
    const size_t size = output_size(&output, count);
    unsigned char *wanted = allocate_or_fail(size, 1), *got = allocate_guarded(size);
    const mlrt_hits hits = hits_of_output(&output, got, count);
    fill_expected(&output, bundle->expected, count, wanted);
    memset(got, 0x77, size);
    assert_int_equal(mlrt_trace_packet(bundle->world->fixture.tree, rays, options, &hits), MLRT_OK);
    for (size_t i = 0; i < count && memcmp(got, wanted, size) != 0; i++) {
        struct reference_hit hit;
        read_output(&output, got, bundle->expected, i, count, &hit);
        if (!same_hit(&hit, &bundle->expected[i])) fail_case(bundle, text, i, &bundle->expected[i], &hit);
    }
    if (memcmp(got, wanted, size) != 0)
        fail_msg("case %llu, %s: bytes between results were written", (unsigned long long)bundle->world->fixture.seed,
                 text);
    free_guarded(got, size);
    free(wanted);
    answer_count += count;
}

static void check_any(const struct bundle *bundle, const mlrt_rays *rays, const mlrt_trace_options *options,
                      struct random *random, const char *text)
{
    static const size_t strides[] = {0, 0, 3, 4, 32};
    const size_t count = bundle->list.count, given = strides[draw_below(random, 5)], stride = given ? given : 1;
    const size_t size = (count - 1) * stride + 1;
    unsigned char *got = allocate_guarded(size);
    const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {got, given, 0}};
    memset(got, 0x77, size);
    assert_int_equal(mlrt_trace_packet(bundle->world->fixture.tree, rays, options, &hits), MLRT_OK);
    for (size_t i = 0; i < size; i++) {
        const size_t ray = i / stride;
        const int expected = i % stride ? 0x77 : bundle->expected[ray].mesh != MLRT_NONE;
        if (got[i] == expected) continue;
        const struct reference_hit hit = {.t = got[i], .mesh = got[i] ? 0 : MLRT_NONE, .triangle = MLRT_NONE};
        fail_case(bundle, text, ray, &bundle->expected[ray], &hit);
    }
    free_guarded(got, size);
    answer_count += count;
}

/* Closest and any hit, each with arrays of one layout and results of another. */
static void check_way(const struct bundle *bundle, struct random *random, struct bundle_shape shape, int32_t method,
                      int32_t isa)
{
    static const char *const isas[] = {"auto", "scalar", "sse", "avx2", "avx512", "neon"};
    const size_t layout = draw_below(random, 4) ? draw_below(random, LAYOUT_COUNT) : 0;
    const uint32_t fields = bundle->fields | (draw_below(random, 3) ? 0 : 1u << (T_MIN + draw_below(random, 3)));
    const uint32_t threads = draw_below(random, 16) ? 0 : 2;
    struct arrays arrays = make_arrays(&bundle->list, bundle->masks, fields, &layouts[layout]);
    arrays.rays.row_length = draw_row_length(random, shape);
    mlrt_trace_options options = {.struct_size = sizeof options,
                                  .method = method,
                                  .isa = isa,
                                  .mask = bundle->common_mask,
                                  .pool = shared_pool(threads)};
    char text[160];
    snprintf(text, sizeof text, "%s, %s, layout %zu, row_length %u, %u threads",
             method == MLRT_METHOD_RAY ? "method ray" : "tile", isas[isa], layout, (unsigned)arrays.rays.row_length,
             (unsigned)threads);
    check_closest(bundle, &arrays.rays, &options, random, text);
    options.query = MLRT_QUERY_ANY;
    strcat(text, ", any hit");
    check_any(bundle, &arrays.rays, &options, random, text);
    free_arrays(&arrays);
}

static int has_isa(int32_t isa)
{
    static signed char known[MLRT_ISA_NEON + 1];
    if (!known[isa]) known[isa] = isa_is_supported(isa) ? 1 : -1;
    return known[isa] > 0;
}

static void make_bundle(struct bundle *bundle, size_t kind, struct bundle_shape shape, struct random *random)
{
    struct world *world = bundle->world;
    const struct fixture *fixture = &world->fixture;
    add_bundle_rays(&bundle->list, random, fixture, kind, shape);
    stretch_directions(&bundle->list, random);
    spoil_bundle(&bundle->list, random, fixture);
    bundle->expected = allocate_or_fail(shape.count, sizeof *bundle->expected);
    bundle->masks = allocate_or_fail(shape.count, sizeof *bundle->masks);
    bundle->has_masks = set_masks(bundle->masks, shape.count, random, &bundle->common_mask);
    const uint32_t *masks = bundle->has_masks ? bundle->masks : NULL;
    trace_rays_singly(fixture->tree, &bundle->list, masks, bundle->common_mask, bundle->expected);
    set_ranges(&bundle->list, random, bundle->expected);
    set_skips(&bundle->list, random, world, bundle->expected);
    trace_rays_singly(fixture->tree, &bundle->list, masks, bundle->common_mask, bundle->expected);
    bundle->fields = needed_fields(&bundle->list, bundle->has_masks);
    snprintf(bundle->name, sizeof bundle->name, "rays that %s, %zu in rows of %u", bundle_kind_name(kind), shape.count,
             (unsigned)shape.width);
}

static void run_case(uint64_t number)
{
    struct random random = {number};
    struct bundle bundle = {.world = find_world(number / bundle_kind_count())};
    const struct bundle_shape shape = shape_of_case(number, &random);
    bundle.world->fixture.seed = number;
    make_bundle(&bundle, number % bundle_kind_count(), shape, &random);
    judge(&bundle, &random);
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
        if (has_isa(isa)) check_way(&bundle, &random, shape, MLRT_METHOD_DEFAULT, isa);
    }
    if (number % 8 == 0) check_way(&bundle, &random, shape, MLRT_METHOD_RAY, MLRT_ISA_AUTO);
    ray_count += shape.count;
    free_rays(&bundle.list);
    free(bundle.expected);
    free(bundle.masks);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* One kind of bundle in three worlds of every scene. */
static void check_kind(void **state)
{
    const size_t kind = *(const size_t *)*state;
    for (size_t i = 0; i < scaled(3 * world_scene_count()); i++) run_case(kind + bundle_kind_count() * i);
}

static void run_cases(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < case_count; i++) {
        run_case(first_case + i);
        if ((i + 1) % 10000 == 0)
            print_message("%llu cases, %llu answers\n", (unsigned long long)i + 1, (unsigned long long)answer_count);
    }
}

int main(int argc, char **argv)
{
    static struct CMUnitTest tests[64];
    static size_t numbers[64];
    const struct CMUnitTest all[] = {cmocka_unit_test(run_cases)};
    int failures;
    for (size_t i = 0; i < bundle_kind_count(); i++) {
        numbers[i] = i;
        tests[i] = (struct CMUnitTest){bundle_kind_name(i), check_kind, NULL, NULL, &numbers[i]};
    }
    if (argc > 1) case_count = strtoull(argv[1], NULL, 10);
    if (argc > 2) first_case = strtoull(argv[2], NULL, 10);
    if (case_count)
        failures = cmocka_run_group_tests(all, NULL, free_worlds);
    else
        failures = _cmocka_run_group_tests("rays that", tests, bundle_kind_count(), NULL, free_worlds);
    printf("%llu rays, %llu answers compared, %llu of the rays with the reference\n", (unsigned long long)ray_count,
           (unsigned long long)answer_count, (unsigned long long)judged_count);
    return failures;
}
