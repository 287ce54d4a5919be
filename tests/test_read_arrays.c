/* SPDX-License-Identifier: MIT */
/*
 * Rays as tiles read them out of arrays (read_arrays.h) against the same words taken one by one: elements packed, in
 * structs where another array's word follows, or apart; one origin for several rays; skips of several meshes. Every
 * array ends with its memory, and what is behind that must not be touched.
 */
#include <string.h>

#include "rays/source.h"
#include "support.h"
#include "read/read.h"
#include "trace/ray_tile.h"
#include "scene/masks.h"

/*
 * Where arrays are in a struct, in words; APART: they have one of their own, with a stride of so many more words; NONE.
 */
enum { NONE = -1, APART = -2 };
enum field { ORIGIN, DIRECTION, T_MIN, T_MAX, SKIP, FIELD_COUNT };
static const size_t field_words[FIELD_COUNT] = {3, 3, 1, 1, 2};

struct layout {
    int place[FIELD_COUNT];
    size_t words;
    size_t gap; /* of arrays apart */
};

static const struct layout layouts[] = {
    {{APART, APART, APART, APART, APART}, 0, 0},
    {{APART, APART, NONE, NONE, NONE}, 0, 0},
    {{APART, APART, APART, NONE, APART}, 0, 1},
    {{APART, APART, NONE, APART, NONE}, 0, 2},
    {{0, 4, 3, 7, NONE}, 8, 0},
    {{0, 4, 7, 3, NONE}, 8, 0},
    {{4, 0, 3, 7, NONE}, 8, 0},
    {{0, 3, NONE, NONE, NONE}, 6, 0},
    {{3, 0, NONE, NONE, NONE}, 6, 0},
    {{0, 3, 6, 7, NONE}, 8, 0},
    {{0, 5, NONE, NONE, 3}, 8, 0},
    {{5, 0, NONE, NONE, 3}, 8, 0},
    {{5, 0, NONE, 8, 3}, 10, 0},
    {{0, 4, NONE, NONE, NONE}, 8, 0}, /* of the last struct the last word is not there */
    {{1, 4, NONE, NONE, NONE}, 9, 0},
    {{0, 4, 3, NONE, 8}, 11, 0},
    {{0, 4, NONE, 7, 8}, 16, 0},
    {{0, APART, 3, APART, APART}, 4, 1},
    {{APART, 0, APART, 3, APART}, 4, 0},
    {{0, APART, 3, APART, APART}, 3, 0}, /* of which the word that follows is in the next element */
    {{APART, 0, APART, 3, APART}, 3, 0},
    {{0, 3, NONE, NONE, 3}, 3, 0},
    {{0, 4, 3, 7, NONE}, 4, 0},
};

#define LAYOUT_COUNT (sizeof layouts / sizeof *layouts)

struct array {
    unsigned char *block;
    size_t size;
    const unsigned char *data;
    size_t stride;
};

/*
 * Rays i have the elements i / group of origins, t_min and skips. With a group the struct has only these, or only
 * others.
 */
static int is_of_group(int field)
{
    return field == ORIGIN || field == T_MIN || field == SKIP;
}

static void fill_words(struct random *random, unsigned char *block, size_t size)
{
    for (size_t i = 0; i + 4 <= size; i += 4) {
        const float a = draw_below(random, 20) ? draw_range(random, -4, 4) : 0;
        memcpy(block + i, &a, 4);
    }
}

static void free_array(struct array *array)
{
    if (array->block) free_guarded(array->block, array->size);
}

static void make_apart(struct random *random, size_t count, size_t words, size_t gap, struct array *array)
{
    array->stride = 4 * (words + gap);
    array->size = (count - 1) * array->stride + 4 * words;
    array->data = array->block = allocate_guarded(array->size);
    fill_words(random, array->block, array->size);
}

/* The arrays of one struct, which ends with the last word that is one's. */
static void make_struct(struct random *random, const struct layout *layout, int of_group, int all, size_t count,
                        struct array arrays[FIELD_COUNT])
{
    size_t end = 0;
    int holder = -1;
    for (int field = 0; field < FIELD_COUNT; field++) {
        if (layout->place[field] < 0 || (!all && is_of_group(field) != of_group)) continue;
        const size_t last = (size_t)layout->place[field] + field_words[field];
        if (last > end) end = last;
        if (holder < 0) holder = field;
    }
    if (holder < 0) return;
    const size_t stride = 4 * layout->words, size = (count - 1) * stride + 4 * end;
    unsigned char *block = allocate_guarded(size);
    fill_words(random, block, size);
    for (int field = 0; field < FIELD_COUNT; field++) {
        if (layout->place[field] < 0 || (!all && is_of_group(field) != of_group)) continue;
        arrays[field].data = block + 4 * layout->place[field];
        arrays[field].stride = stride;
        if (field != holder) continue;
        arrays[field].block = block;
        arrays[field].size = size;
    }
}

static const unsigned char *element_of(const struct array *array, size_t i)
{
    return array->data + i * array->stride;
}

/* Pairs of mesh and triangle: mostly of one mesh, in some places of several, or of none that there is. */
static void set_skips(struct random *random, const struct array *skips, size_t count)
{
    const uint32_t mixed = draw_below(random, 3);
    uint32_t mesh = 10;
    for (size_t i = 0; i < count; i++) {
        if (mixed && draw_below(random, mixed == 1 ? 100 : 3) == 0) mesh = 10 * (1 + draw_below(random, 4));
        const uint32_t pair[2] = {draw_below(random, 9) ? mesh : MLRT_NONE, draw_below(random, 14)};
        memcpy((unsigned char *)(uintptr_t)element_of(skips, i), pair, sizeof pair);
    }
}

static void check_words(const char *what, size_t ray, const void *given, float found, size_t layout, uint32_t group)
{
    if (memcmp(given, &found, 4) != 0)
        fail_msg("%s of ray %zu, layout %zu, %u rays an origin: %a", what, ray, layout, group, found);
}

static void check_packet(const struct array arrays[FIELD_COUNT], const struct mlrt_source *source, size_t layout,
                         uint32_t group, const struct mlrt_rectangle *block, const struct mlrt_packet *packet)
{
    static const float zero = 0, infinity = INFINITY;
    const uint32_t lanes = mlrt_existing_lanes(source, block);
    assert_int_equal(packet->active, lanes);
    assert_int_equal(packet->has.skip, arrays[SKIP].data != NULL);
    assert_int_equal(packet->has.limits, arrays[T_MIN].data || arrays[T_MAX].data);
    assert_int_equal(packet->has.apex, 0);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
        if (!(lanes >> lane & 1)) continue;
        const size_t ray =
            (block->y + (size_t)mlrt_lane_y[lane]) * source->width + block->x + (size_t)mlrt_lane_x[lane];
        for (size_t k = 0; k < 3; k++) {
            check_words("origin", ray, element_of(&arrays[ORIGIN], ray / group) + 4 * k, packet->origin[k][lane],
                        layout, group);
            check_words("direction", ray, element_of(&arrays[DIRECTION], ray) + 4 * k, packet->direction[k][lane],
                        layout, group);
        }
        const void *first = arrays[T_MIN].data ? (const void *)element_of(&arrays[T_MIN], ray / group) : &zero;
        const void *last = arrays[T_MAX].data ? (const void *)element_of(&arrays[T_MAX], ray) : &infinity;
        check_words("t_min", ray, first, packet->t_min[lane], layout, group);
        check_words("t_max", ray, last, packet->t_max[lane], layout, group);
        struct mlrt_ray_segment segment;
        uint32_t skip;
        (void)mlrt_get_ray(source, (uint32_t)ray, &segment, &skip);
        if (packet->has.skip) assert_int_equal(packet->skip[lane], skip);
    }
}

static void check_source(const struct fixture *fixture, struct random *random, size_t number, size_t count,
                         uint32_t row_length, uint32_t group, const struct readers *readers)
{
    static struct mlrt_ray_tile tile;
    const struct layout *layout = &layouts[number];
    struct array arrays[FIELD_COUNT] = {{0}};
    struct mlrt_source source;
    for (int field = 0; field < FIELD_COUNT; field++) {
        const size_t elements = is_of_group(field) ? count / group : count;
        if (layout->place[field] == APART)
            make_apart(random, elements, field_words[field], layout->gap, &arrays[field]);
    }
    make_struct(random, layout, 1, group == 1, count / group, arrays);
    if (group > 1) make_struct(random, layout, 0, 0, count, arrays);
    if (arrays[SKIP].data) set_skips(random, &arrays[SKIP], count / group);
    mlrt_const_array given[FIELD_COUNT];
    for (int field = 0; field < FIELD_COUNT; field++) {
        given[field] = (mlrt_const_array){arrays[field].data, arrays[field].stride};
    }
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .count = count,
                            .row_length = row_length,
                            .rays_per_origin = group,
                            .origins = given[ORIGIN],
                            .directions = given[DIRECTION],
                            .t_min = given[T_MIN],
                            .t_max = given[T_MAX],
                            .skip = given[SKIP]};
    mlrt_make_ray_source(fixture->tree, &rays, &source);
    mlrt_set_masks(fixture->tree, MLRT_MASK_ALL, &source);
    const int is_list = source.width <= 4;
    const struct mlrt_rectangle whole = {0, 0, source.width, source.height};
    for (uint32_t y = 0; y < source.height; y += is_list ? 64 : 16) {
        for (uint32_t x = 0; x < source.width; x += 16) {
            struct mlrt_rectangle area = mlrt_cut_piece(&whole, x, y, is_list ? 64 : 16);
            mlrt_begin_tile(&area, is_list, &tile);
            readers->read_packets(&source, &tile);
            for (uint32_t left = tile.blocks; left; left &= left - 1) {
                const uint32_t place = mlrt_lowest_bit(left);
                const struct mlrt_rectangle block = mlrt_block_of_tile(&tile, place);
                check_packet(arrays, &source, number, group, &block, &tile.packets[place]);
            }
        }
    }
    for (int field = 0; field < FIELD_COUNT; field++) free_array(&arrays[field]);
}

/* Three meshes with ids 10, 20, 30. */
static struct fixture three_meshes(void)
{
    struct soup soup = {0};
    const float lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
    mlrt_mesh meshes[3];
    for (int i = 0; i < 3; i++) soup_add_box(&soup, lo, hi);
    for (uint32_t i = 0; i < 3; i++) {
        meshes[i] = soup_mesh(&soup);
        meshes[i].id = 10 * (3 - i);
        meshes[i].vertices = soup.corners + 9 * 12 * i;
        meshes[i].triangle_count = 12;
        meshes[i].vertex_count = 36;
    }
    struct fixture fixture = make_fixture("three boxes", 1, meshes, 3);
    free_soup(&soup);
    return fixture;
}

static void rays_are_read_as_they_lie(void **state)
{
    static const size_t counts[] = {1, 16, 160, 320, 48 * 20, 165};
    static const uint32_t row_lengths[] = {0, 4, 5, 16, 48, 20}, groups[] = {1, 1, 16, 32, 5, 2, 160};
    (void)state;
    struct fixture fixture = three_meshes();
    struct random random = {9100};
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
        const struct readers *readers = readers_of(isa);
        if (!readers) continue;
        for (size_t layout = 0; layout < LAYOUT_COUNT; layout++) {
            for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
                for (size_t j = 0; j < sizeof groups / sizeof *groups; j++) {
                    if (counts[i] % groups[j]) continue;
                    const uint32_t row_length = row_lengths[draw_below(&random, 6)];
                    check_source(&fixture, &random, layout, counts[i], row_length, groups[j], readers);
                }
            }
        }
    }
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(rays_are_read_as_they_lie)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
