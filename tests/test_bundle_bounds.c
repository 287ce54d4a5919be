/* SPDX-License-Identifier: MIT */
/*
 * Bundles whose numbers are near the ends of what floats are: places and depths that are denormal, directions of which
 * a component is tiny, whose slopes or reciprocals float does not carry. Every way of tracing against the reference.
 */
#include <math.h>
#include <string.h>

#include "support.h"

enum { SIDE = 16, RAY_COUNT = SIDE * SIDE };

static void add_triangle(struct soup *soup, float ax, float ay, float az, float bx, float by, float bz, float cx,
                         float cy, float cz)
{
    const float a[3] = {ax, ay, az}, b[3] = {bx, by, bz}, c[3] = {cx, cy, cz};
    soup_add_triangle(soup, a, b, c);
}

static void check(const char *name, uint64_t seed, struct soup *soup, struct ray_list *list)
{
    struct fixture fixture = fixture_of_soup(name, seed, soup);
    list->row_length = SIDE;
    check_rays_quickly(&fixture, list);
    free_rays(list);
    free_fixture(&fixture);
}

/* From one point with slopes of 0.45 * 2^-149, at a depth where that is more than the width of a triangle. */
static void slopes_may_underflow(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    const float origin[3] = {0, 0, 0};
    add_triangle(&soup, 0x1p-93f, -0x1p58f, 0x1p59f, 0x1p-89f, -0x1p58f, 0x1p59f, 0x1p-93f, 0x1p59f, 0x1p59f);
    add_triangle(&soup, -0x1p58f, -0x1p58f, 0x1p60f, 0x1p58f, -0x1p58f, 0x1p60f, 0, 0x1p59f, 0x1p60f);
    for (int i = 0; i < RAY_COUNT; i++) {
        const float direction[3] = {0x1.cp-91f, 0x1p50f * (float)(1 + i), 0x1p60f};
        add_ray(&list, origin, direction);
    }
    check("slopes that underflow", 0, &soup, &list);
}

/* Two planes at depths of less than 2^-149 from the origin, in either order: t tells which is nearer. */
static void depths_may_underflow(void **state)
{
    (void)state;
    for (int order = 0; order < 2; order++) {
        struct soup soup = {0};
        struct ray_list list = {0};
        const float origin[3] = {0, 0, 0}, start[2] = {order ? -0.7f : -0.9f, order ? -0.9f : -0.7f};
        for (int i = 0; i < 2; i++) add_triangle(&soup, start[i], -1, 0, start[i], 1, 0, 1, 0, 0x1p-149f);
        add_triangle(&soup, -1, -1, 1, 1, -1, 1, 0, 1, 1);
        for (int i = 0; i < RAY_COUNT; i++) {
            const float direction[3] = {0, 0, 0x1p-60f * (1 + (float)i / RAY_COUNT)};
            add_ray(&list, origin, direction);
        }
        check("depths that underflow", (uint64_t)order, &soup, &list);
    }
}

/*
 * Three planes like those, in different leaves, and so small that t is known to a few units in the last place. One ray of
 * a tile alone goes there: it is traced by itself, and what it finds is kept as tau until the next leaf.
 */
static void depths_of_few_rays_may_underflow(void **state)
{
    static const float ways[3][2] = {{0, 1}, {0, -1}, {1, 0}};
    (void)state;
    for (uint64_t seed = 0; seed < scaled(24); seed++) {
        struct random random = {seed * 0x10001 + 7};
        struct soup soup = {0};
        struct ray_list list = {0};
        const float size = ldexpf(1, -137 + (int)(seed % 4));
        for (int side = 0; side < 3; side++) {
            const float x = size * ways[side][0], y = size * ways[side][1], end = draw_range(&random, 0.3f, 1);
            add_triangle(&soup, -0.01f * x - 0.5f * y, -0.01f * y + 0.5f * x, 0x1p-149f, -0.01f * x + end * y,
                         -0.01f * y - end * x, 0, 4 * x, 4 * y, 0);
            for (int i = 0; i < 16; i++) {
                const float from = 1 + 0.2f * (float)i, to = from + 0.2f;
                add_triangle(&soup, from * x - 0.3f * y, from * y + 0.3f * x, 0, from * x + 0.3f * y,
                             from * y - 0.3f * x, 0, to * x, to * y, 0);
            }
        }
        for (int i = 0; i < RAY_COUNT; i++) {
            const float origin[3] = {10 * (float)(i % SIDE - 5), 10 * (float)(i / SIDE - 5), 0};
            const float direction[3] = {0, 0, 0x1p-60f * draw_range(&random, 1, 2)};
            add_ray(&list, origin, direction);
        }
        check("depths of few rays that underflow", seed, &soup, &list);
    }
}

/*
 * Origins 2^-131 from the waist, and a triangle four to five times 2^-149 beside it: roundings of a place there, and of
 * a slope times a depth, make more than 2^-149 together, and PLACE_ERROR R A is less than that. The first tile starts
 * at 0 and so sets the waist, which the second one keeps. In that each packet has one ray, sixteen times; that of
 * packet 5 says which axis is the main one.
 */
static void places_may_underflow(void **state)
{
    const float origin[3] = {0, 0, 0}, beside[3] = {-271810 * 0x1p-149f, 0, -233378 * 0x1p-149f};
    const float direction[3] = {10406226 * 0x1p-23f, 0, 8934843 * 0x1p-23f};
    struct soup soup = {0};
    struct ray_list list = {0};
    (void)state;
    add_triangle(&soup, 0x4p-149f, -1, 0x3p-149f, 0x4p-149f, 1, 0x3p-149f, 0x5p-149f, 0, 0x3p-149f);
    add_triangle(&soup, -1, -1, 1, 1, -1, 1, 0, 1, 1);
    for (int i = 0; i < 2 * RAY_COUNT; i++) {
        const int column = i % SIDE / 4, row = i / SIDE % SIDE / 4;
        const float other[3] = {0.25f * (float)column, 0.25f * (float)row, 1};
        const int is_other = i < RAY_COUNT || (column == 1 && row == 1);
        add_ray(&list, is_other ? origin : beside, is_other ? other : direction);
    }
    check("places that underflow", 0, &soup, &list);
}

/*
 * Directions of 2^-60 with a component of 2^-130, whose reciprocal is infinite, but not the t of what it leads to. One
 * packet is far wider than the others and so goes lane by lane.
 */
static void reciprocals_may_overflow(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < scaled(24); seed++) {
        struct random random = {seed * 0x10001 + 3};
        struct soup soup = {0};
        struct ray_list list = {0};
        for (int i = 0; i < 60; i++) {
            float centre[3], corner[3][3];
            draw_point(&random, -1, 1, centre);
            for (int j = 0; j < 3; j++) {
                corner[j][0] = 0x1p-12f * (0.5f * centre[0] + draw_range(&random, 0.5f, 0.8f));
                corner[j][1] = centre[1] + draw_range(&random, 0, 0.6f);
                corner[j][2] = 0x1p59f * (1 + 0.5f * centre[2]);
            }
            soup_add_triangle(&soup, corner[0], corner[1], corner[2]);
        }
        for (int i = 0; i < RAY_COUNT; i++) {
            const int is_wide = i % SIDE / 4 == 1 && i / SIDE / 4 == 1;
            const float width = is_wide ? 1 : 0.01f;
            const float origin[3] = {-0x1p-13f * draw_range(&random, 0.5f - 0.5f * width, 0.5f + 0.5f * width),
                                     draw_range(&random, -width, width), 0};
            const float direction[3] = {0x1p-130f * draw_range(&random, 1, 1 + width), 0, 0x1.8p-60f};
            add_ray(&list, origin, direction);
        }
        check("reciprocals that overflow", seed, &soup, &list);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slopes_may_underflow),
        cmocka_unit_test(depths_may_underflow),
        cmocka_unit_test(depths_of_few_rays_may_underflow),
        cmocka_unit_test(places_may_underflow),
        cmocka_unit_test(reciprocals_may_overflow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
