/* SPDX-License-Identifier: MIT */
/*
 * See hard_scenes.h.
 */
#include "hard_scenes.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { TRIANGLE_LIMIT = 2000 };

static const float zero[3] = {0, 0, 0};

/* ---- shared ------------------------------------------------------------------------------------------------------ */

/* The soup's triangles from `first` on once more, scaled and moved. */
static void add_copy(struct soup *soup, size_t first, size_t end, float scale, const float offset[3])
{
    for (size_t i = first; i < end; i++) {
        float p[9];
        for (int n = 0; n < 9; n++)
            p[n] = (float)((double)soup->corners[9 * i + (size_t)n] * (double)scale + (double)offset[n % 3]);
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

static void draw_lattice_point(struct random *random, int limit, float point[3])
{
    for (int k = 0; k < 3; k++) point[k] = (float)draw_below(random, (uint32_t)limit);
}

static float power_of_ten(struct random *random, float from, float to)
{
    return (float)pow(10, (double)draw_range(random, from, to));
}

/* ---- edges, vertices, needles ------------------------------------------------------------------------------------ */

static void shared_edges(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT) {
        float p[4][3], centre[3];
        draw_point(random, -4, 4, centre);
        for (int i = 0; i < 4; i++) {
            draw_point(random, -1, 1, p[i]);
            for (int k = 0; k < 3; k++) p[i][k] += centre[k];
        }
        soup_add_triangle(soup, p[0], p[1], p[2]);
        if (soup->count % 4 == 1)
            soup_add_triangle(soup, p[0], p[1], p[3]);
        else
            soup_add_triangle(soup, p[1], p[0], p[3]);
    }
}

static void fans(struct soup *soup, struct random *random)
{
    for (int blades = 3; blades <= 64; blades += blades < 16 ? 1 : 3) {
        float centre[3], rim[64][3];
        draw_lattice_point(random, 40, centre);
        for (int i = 0; i < blades; i++) {
            double angle = 6.28318530717958647692 * i / blades;
            rim[i][0] = centre[0] + (float)(10 * cos(angle));
            rim[i][1] = centre[1] + (float)(10 * sin(angle));
            rim[i][2] = centre[2] + draw_range(random, -1, 1);
        }
        for (int i = 0; i < blades; i++) {
            const float *next = rim[(i + 1) % blades];
            if (i % 3 == 1)
                soup_add_triangle(soup, next, centre, rim[i]);
            else
                soup_add_triangle(soup, centre, rim[i], next);
        }
    }
}

static void open_grids(struct soup *soup, struct random *random)
{
    (void)random;
    for (int axis = 0; axis < 3; axis++) soup_add_grid(soup, axis, (float)(3 + axis), 16);
}

static void strip_of_needles(struct soup *soup, struct random *random)
{
    (void)random;
    for (int i = 0; soup->count < TRIANGLE_LIMIT; i++) {
        const float y = (float)i * 1e-6f, next = (float)(i + 1) * 1e-6f;
        const float a[3] = {0, y, 0}, b[3] = {1, y, 0}, c[3] = {0, next, 0}, d[3] = {1, next, 0};
        soup_add_triangle(soup, a, b, c);
        soup_add_triangle(soup, b, d, c);
    }
}

static void needles(struct soup *soup, struct random *random)
{
    soup_add_needles(soup, random, TRIANGLE_LIMIT / 2, 1e6f);
}

static void slivers_of_all_aspects(struct soup *soup, struct random *random)
{
    for (int power = 1; power <= 10; power++) soup_add_needles(soup, random, 100, (float)pow(10, power));
}

/* Long skinny triangles that all end in one edge; like a hair brush seen from the side. */
static void skinny_fan(struct soup *soup, struct random *random)
{
    for (int i = 0; i < TRIANGLE_LIMIT; i++) {
        float a[3] = {0, 0, 0}, b[3] = {500, 0, 0}, c[3] = {500, 0, 0};
        a[1] = b[1] = draw_range(random, -5, 5);
        c[1] = b[1] + draw_range(random, -0.002f, 0.002f);
        c[2] = draw_range(random, -0.0001f, 0.0001f);
        soup_add_triangle(soup, a, b, c);
    }
}

static void nearly_collinear(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT) {
        float a[3], side[3], b[3], c[3];
        draw_point(random, -1, 1, a);
        draw_point(random, -1, 1, side);
        for (int k = 0; k < 3; k++) {
            b[k] = a[k] + side[k];
            c[k] = a[k] + 0.3f * side[k]; // off the line by a rounding
        }
        soup_add_triangle(soup, a, b, c);
    }
}

/* Products of these underflow in float, and only there. */
static void edges_that_underflow(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT) {
        float p[3][3];
        for (int n = 0; n < 9; n++) p[n / 3][n % 3] = ldexpf((float)draw_below(random, 64) - 32, -75);
        soup_add_triangle(soup, p[0], p[1], p[2]);
    }
}

/* ---- random ------------------------------------------------------------------------------------------------------ */

static void small_triangles(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, TRIANGLE_LIMIT, 1, 0.1f);
}

static void large_triangles(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, TRIANGLE_LIMIT / 2, 1, 1);
}

static void dust(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, TRIANGLE_LIMIT, 1, 0.001f);
}

static void any_bits(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT / 16) {
        float p[9];
        for (int n = 0; n < 9; n++) p[n] = draw_finite(random);
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

/* ---- planes, ties, copies ---------------------------------------------------------------------------------------- */

/* Triangles in a few planes across the axes, over one another. */
static void coincident_planes(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT) {
        int axis = (int)draw_below(random, 3);
        float level = (float)draw_below(random, 3), p[3][3];
        for (int i = 0; i < 3; i++) {
            draw_point(random, -0.5f, 2.5f, p[i]);
            p[i][axis] = level;
        }
        soup_add_triangle(soup, p[0], p[1], p[2]);
    }
}

static void coincident_windings(struct soup *soup, struct random *random)
{
    struct soup once = {0};
    soup_add_random(&once, random, TRIANGLE_LIMIT / 3, 1, 0.3f);
    for (size_t i = 0; i < once.count; i++) {
        const float *c = once.corners + 9 * i;
        soup_add_triangle(soup, c + 6, c + 3, c);
        soup_add_triangle(soup, c, c + 3, c + 6);
        soup_add_triangle(soup, c + 3, c + 6, c);
    }
    free_soup(&once);
}

static void everything_twice(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, TRIANGLE_LIMIT / 4, 1, 0.3f);
    soup_add_torus(soup, 25, 10, 1, 0.4f);
    add_copy(soup, 0, soup->count, 1, zero);
}

static void sixty_in_one_spot(struct soup *soup, struct random *random)
{
    while (soup->count + 60 <= TRIANGLE_LIMIT) {
        float p[3][3];
        draw_point(random, -2, 2, p[0]);
        for (int i = 1; i < 3; i++) {
            draw_point(random, -1, 1, p[i]);
            for (int k = 0; k < 3; k++) p[i][k] += p[0][k];
        }
        for (int i = 0; i < 60; i++) soup_add_triangle(soup, p[0], p[1], p[2]);
    }
}

static void one_spot_only(struct soup *soup, struct random *random)
{
    const float a[3] = {0, 0, 0}, b[3] = {1, 0.5f, 0}, c[3] = {0, 1, 0.25f};
    (void)random;
    for (int i = 0; i < 60; i++) soup_add_triangle(soup, a, b, c);
}

static void one_float_apart(struct soup *soup, struct random *random)
{
    (void)random;
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 3; i >= -3; i--) soup_add_grid(soup, axis, next_float(1, i), 5);
    }
}

static void neighbouring_floats(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT / 2) {
        float p[3][3];
        for (int n = 0; n < 9; n++) p[n / 3][n % 3] = next_float(1, (int)draw_below(random, 9) - 4);
        soup_add_triangle(soup, p[0], p[1], p[2]);
    }
}

static void small_integers(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT) {
        float p[3][3];
        for (int i = 0; i < 3; i++) draw_lattice_point(random, 6, p[i]);
        soup_add_triangle(soup, p[0], p[1], p[2]);
    }
}

static void zeros_and_ones(struct soup *soup, struct random *random)
{
    static const float values[] = {0.0f, -0.0f, 1, -1};
    while (soup->count < TRIANGLE_LIMIT / 4) {
        float p[9];
        for (int n = 0; n < 9; n++) p[n] = values[draw_below(random, 4)];
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

static void lattice(struct soup *soup, struct random *random)
{
    (void)random;
    for (int axis = 0; axis < 3; axis++) {
        for (int level = 0; level <= 8; level++) soup_add_grid(soup, axis, 0.75f * (float)level, 6);
    }
}

static void flat_sheet(struct soup *soup, struct random *random)
{
    (void)random;
    soup_add_grid(soup, 0, -3, 31);
}

static void two_flat_sheets(struct soup *soup, struct random *random)
{
    (void)random;
    soup_add_grid(soup, 1, 0, 22);
    soup_add_grid(soup, 1, 1, 22);
}

/* Flat in one axis, of triangles over one another. */
static void flat_heap(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, TRIANGLE_LIMIT / 2, 1, 0.2f);
    for (size_t i = 0; i < 3 * soup->count; i++) soup->corners[3 * i + 2] = 0.1f;
}

/* Rooms with walls in common, a table in each: cells without thickness (case 26). */
static void boxes_that_share_walls(struct soup *soup, struct random *random)
{
    for (int room = 0; room < 64; room++) {
        const float lo[3] = {(float)(room % 4), (float)(room / 4 % 4), (float)(room / 16)};
        float hi[3], table_lo[3], table_hi[3];
        for (int k = 0; k < 3; k++) {
            hi[k] = lo[k] + 1;
            table_lo[k] = k == 2 ? lo[k] : lo[k] + draw_range(random, 0.1f, 0.4f);
            table_hi[k] = table_lo[k] + draw_range(random, 0.1f, 0.4f);
        }
        soup_add_box(soup, lo, hi);
        soup_add_box(soup, table_lo, table_hi);
    }
}

/* ---- bad triangles ----------------------------------------------------------------------------------------------- */

static void without_area(struct soup *soup, struct random *random)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    while (soup->count < TRIANGLE_LIMIT) {
        float p[3][3];
        size_t i = soup->count;
        draw_point(random, -1, 1, p[0]);
        for (int n = 3; n < 9; n++) p[n / 3][n % 3] = p[0][n % 3] + draw_range(random, -0.3f, 0.3f);
        if (i % 4 == 0) memcpy(p[2], p[i / 4 % 2], sizeof p[2]);
        if (i % 8 == 1) {
            for (int k = 0; k < 3; k++) p[2][k] = -p[1][k], p[0][k] = 0;
        }
        if (i % 8 == 2) p[i / 8 % 3][i / 24 % 3] = bad[i / 72 % 3];
        if (i % 64 == 5) memcpy(p[1], p[0], sizeof p[1]), memcpy(p[2], p[0], sizeof p[2]);
        soup_add_triangle(soup, p[0], p[1], p[2]);
    }
}

static void nothing(struct soup *soup, struct random *random)
{
    (void)soup;
    (void)random;
}

static void nothing_usable(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, 100, 1, 0.5f);
    for (size_t i = 0; i < soup->count; i++) {
        if (i % 2)
            soup->corners[9 * i] = NAN;
        else
            memcpy(soup->corners + 9 * i, soup->corners + 9 * i + 3, 3 * sizeof(float));
    }
}

static void a_single_triangle(struct soup *soup, struct random *random)
{
    const float a[3] = {0, 0, 0}, b[3] = {1, 0, 0}, c[3] = {0, 1, 0};
    (void)random;
    soup_add_triangle(soup, a, b, c);
}

/* ---- scales ------------------------------------------------------------------------------------------------------ */

static void every_scale_at_once(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT / 8) {
        struct soup one = {0};
        soup_add_random(&one, random, 1, 1, 1);
        move_soup(&one, power_of_ten(random, -37, 37), zero);
        soup_add_triangle(soup, one.corners, one.corners + 3, one.corners + 6);
        free_soup(&one);
    }
}

static void scales_within_float(struct soup *soup, struct random *random)
{
    while (soup->count < TRIANGLE_LIMIT) {
        float p[9], scale = power_of_ten(random, -6, 6), size = scale * power_of_ten(random, -3, 0);
        float centre[3];
        draw_point(random, -scale, scale, centre);
        for (int n = 0; n < 9; n++) p[n] = centre[n % 3] + draw_range(random, -size, size);
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

/* In units of a metre. */
static void millimetres_and_one_far_vertex(struct soup *soup, struct random *random)
{
    const float far[3] = {1e30f, -1e30f, 1e29f}, a[3] = {0, 0.001f, 0}, b[3] = {0.001f, 0, 0};
    soup_add_random(soup, random, TRIANGLE_LIMIT - 1, 0.01f, 0.001f);
    soup_add_triangle(soup, a, b, far);
}

static void denormals_among_ones(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, TRIANGLE_LIMIT / 2, 1, 0.3f);
    add_copy(soup, 0, soup->count, 1e-39f, zero);
}

/* Around the smallest and largest numbers that float culling takes. */
static void limits_of_float_culling(struct soup *soup, struct random *random)
{
    static const int exponents[] = {-61, -60, -59, 59, 60, 61};
    while (soup->count < TRIANGLE_LIMIT / 2) {
        float p[9];
        float size = ldexpf(1, exponents[draw_below(random, 6)]);
        for (int n = 0; n < 9; n++) p[n] = size * draw_range(random, -1.5f, 1.5f);
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

static void features_of_a_hundredth(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, TRIANGLE_LIMIT, 1, 0.1f);
}

static void largest_and_smallest(struct soup *soup, struct random *random)
{
    static const float values[] = {FLT_MAX, -FLT_MAX, FLT_MIN, -FLT_MIN, 1.4e-45f, -1.4e-45f, 0, 1, -1, 1e20f};
    while (soup->count < TRIANGLE_LIMIT / 16) {
        float p[9];
        for (int n = 0; n < 9; n++) p[n] = values[draw_below(random, 10)];
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

/* ---- closed meshes ----------------------------------------------------------------------------------------------- */

static void sphere(struct soup *soup, struct random *random)
{
    (void)random;
    soup_add_icosphere(soup, 3, 1);
}

static void torus(struct soup *soup, struct random *random)
{
    (void)random;
    soup_add_torus(soup, 40, 25, 1, 0.25f);
}

static void nested_boxes(struct soup *soup, struct random *random)
{
    (void)random;
    for (int i = 1; i <= 160; i++) {
        const float size = (float)i * 0.25f, lo[3] = {-size, -size, -size}, hi[3] = {size, size, size};
        soup_add_box(soup, lo, hi);
    }
}

/* The sphere with its vertices pulled in and out: a star. */
static void star(struct soup *soup, struct random *random)
{
    (void)random;
    soup_add_icosphere(soup, 3, 1);
    for (size_t i = 0; i < 3 * soup->count; i++) {
        float *p = soup->corners + 3 * i;
        // The same vertex gets the same factor, whichever triangle it is in.
        uint32_t bits = bits_of_float(p[0]) ^ bits_of_float(p[1]) * 2654435761u ^ bits_of_float(p[2]) * 40503u;
        float factor = 0.25f + (float)(bits * 2246822519u >> 24) / 128;
        for (int k = 0; k < 3; k++) p[k] *= factor;
    }
}

/* ---- trees ------------------------------------------------------------------------------------------------------- */

static void a_hub(struct soup *soup, struct random *random)
{
    const float hub[3] = {0.5f, 0.25f, -0.125f};
    while (soup->count < TRIANGLE_LIMIT / 2) {
        float a[3], b[3];
        draw_point(random, -1, 1, a);
        draw_point(random, -1, 1, b);
        soup_add_triangle(soup, hub, a, b);
    }
}

static void huge_over_small(struct soup *soup, struct random *random)
{
    const float a[3] = {-1000, -1000, 0.01f}, b[3] = {1000, -900, 0}, c[3] = {0, 1500, -0.01f};
    soup_add_random(soup, random, TRIANGLE_LIMIT - 1, 1, 0.05f);
    soup_add_triangle(soup, a, b, c);
}

static void towards_a_corner(struct soup *soup, struct random *random)
{
    for (int i = 0; i < TRIANGLE_LIMIT / 2; i++) {
        float p[9], size = ldexpf(1, -(i % 120));
        for (int n = 0; n < 9; n++) p[n] = size * draw_range(random, 0.5f, 1);
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

static void a_wall_and_splinters(struct soup *soup, struct random *random)
{
    soup_add_grid(soup, 0, 0, 24);
    soup_add_random(soup, random, 800, 12, 0.5f);
}

/* The hit of a large triangle lies beyond the cell in which it is found. */
static void slanted_walls(struct soup *soup, struct random *random)
{
    const float a[3] = {-4, -4, -1}, b[3] = {-4, 4, -1}, c[3] = {8, 0, 5};
    soup_add_triangle(soup, a, b, c);
    while (soup->count < TRIANGLE_LIMIT / 2) {
        float p[9], centre[3] = {draw_range(random, 0, 6), draw_range(random, -1, 1), 0};
        centre[2] = 0.5f * centre[0] + 1 - draw_range(random, -0.1f, 0.2f);
        for (int n = 0; n < 9; n++) p[n] = centre[n % 3] + draw_range(random, -0.1f, 0.1f);
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

/* ---- beams ------------------------------------------------------------------------------------------------------- */

static void pointing_at_a_line(struct soup *soup, struct random *random)
{
    for (int i = 0; i < TRIANGLE_LIMIT / 2; i++) {
        const float tip = draw_range(random, -0.5f, 0.5f), y = draw_range(random, -5, 5), z = draw_range(random, -5, 5);
        const float a[3] = {-20, y, z + 0.1f}, b[3] = {tip, y + 0.1f, z}, c[3] = {-20, y, z - 0.1f};
        soup_add_triangle(soup, a, b, c);
    }
}

static void covers_that_intersect(struct soup *soup, struct random *random)
{
    for (int i = 0; i < 100; i++) {
        float p[3][3] = {{-30, -30, 0}, {30, -30, 0}, {0, 40, 0}};
        for (int c = 0; c < 3; c++) p[c][2] = draw_range(random, -3, 3);
        soup_add_triangle(soup, p[0], p[1], p[2]);
    }
    soup_add_random(soup, random, 900, 1, 0.3f);
}

/* Plates behind plates whose borders end within floats of the middle. */
static void plates_that_nearly_cover(struct soup *soup, struct random *random)
{
    for (int i = 0; i < TRIANGLE_LIMIT / 4; i++) {
        const float edge = next_float(0.96875f, (int)draw_below(random, 9) - 4), z = (float)(1 + i % 25) * 0.25f;
        const float a[3] = {-9, -9, z}, b[3] = {edge, -9, z}, c[3] = {edge, edge, z}, d[3] = {-9, edge, z};
        soup_add_triangle(soup, a, b, c);
        soup_add_triangle(soup, a, c, d);
    }
}

static const struct hard_scene scenes[] = {
    {"shared_edges", "1 19 45", shared_edges, 0, 0, 0},
    {"fans", "2 29", fans, 0, 0, 0},
    {"open_grids", "3 22 23", open_grids, 0, 0, 0},
    {"strip_of_needles", "4", strip_of_needles, 0, 0, 0},
    {"needles", "4 29", needles, 0, 0, 0},
    {"slivers_of_all_aspects", "4 19 31", slivers_of_all_aspects, 0, 0, 0},
    {"skinny_fan", "5 6", skinny_fan, 0, 0, 0},
    {"nearly_collinear", "12 19", nearly_collinear, 0, 0, 0},
    {"edges_that_underflow", "14 19", edges_that_underflow, 0, 0, 0},
    {"small_triangles", "6 16 17 18 37 44 45", small_triangles, 0, 0, 0},
    {"small_triangles_1e-38", "14 15", small_triangles, 1e-38f, 0, 0},
    {"small_triangles_1e-30", "14", small_triangles, 1e-30f, 0, 0},
    {"small_triangles_1e-18", "14", small_triangles, 1e-18f, 0, 0},
    {"small_triangles_1e18", "14", small_triangles, 1e18f, 0, 0},
    {"small_triangles_1e30", "14", small_triangles, 1e30f, 0, 0},
    {"small_triangles_1e38", "14", small_triangles, 1e38f, 0, 0},
    {"large_triangles", "29 33 39 40", large_triangles, 0, 0, 0},
    {"dust", "37 46", dust, 0, 0, 0},
    {"any_bits", "14 15", any_bits, 0, 0, 0},
    {"coincident_planes", "7 25 26 27", coincident_planes, 0, 0, 0},
    {"coincident_windings", "10 45", coincident_windings, 0, 0, 0},
    {"everything_twice", "10", everything_twice, 0, 0, 0},
    {"sixty_in_one_spot", "10 28", sixty_in_one_spot, 0, 0, 0},
    {"one_spot_only", "10 28", one_spot_only, 0, 0, 0},
    {"one_float_apart", "11 30", one_float_apart, 0, 0, 0},
    {"neighbouring_floats", "11 30 31", neighbouring_floats, 0, 0, 0},
    {"small_integers", "7 22 23 24 25 31", small_integers, 0, 0, 0},
    {"zeros_and_ones", "12 21", zeros_and_ones, 0, 0, 0},
    {"lattice", "8 9 21 22 23 24 25 36 41", lattice, 0, 0, 0},
    {"flat_sheet", "27 7", flat_sheet, 0, 0, 0},
    {"two_flat_sheets", "27 9", two_flat_sheets, 0, 0, 0},
    {"flat_heap", "10 27", flat_heap, 0, 0, 0},
    {"boxes_that_share_walls", "10 25 26 43", boxes_that_share_walls, 0, 0, 0},
    {"without_area", "12 13", without_area, 0, 0, 0},
    {"nothing", "28", nothing, 0, 0, 0},
    {"nothing_usable", "12 13 28", nothing_usable, 0, 0, 0},
    {"a_single_triangle", "3 7 8 28 41", a_single_triangle, 0, 0, 0},
    {"every_scale_at_once", "14 32", every_scale_at_once, 0, 0, 0},
    {"scales_within_float", "14 32 42", scales_within_float, 0, 0, 0},
    {"millimetres_and_one_far_vertex", "14 29", millimetres_and_one_far_vertex, 0, 0, 0},
    {"denormals", "15", small_triangles, 1e-40f, 0, 0},
    {"denormals_among_ones", "15", denormals_among_ones, 0, 0, 0},
    {"limits_of_float_culling", "14", limits_of_float_culling, 0, 0, 0},
    {"features_of_a_hundredth_at_1e6", "14", features_of_a_hundredth, 0.1f, 1e6f, 0},
    {"small_triangles_at_1e7", "14 30", small_triangles, 100, 1e7f, 0},
    {"largest_and_smallest", "14 15", largest_and_smallest, 0, 0, 0},
    {"sphere", "2 20 32", sphere, 0, 0, 0},
    {"sphere_at_1e5", "2 14 20", sphere, 0, 1e5f, 0},
    {"sphere_1e-6", "2 14 20", sphere, 1e-6f, 0, 0},
    {"torus", "1 20 32", torus, 0, 0, 0},
    {"nested_boxes", "20 22 23 27", nested_boxes, 0, 0, 0},
    {"star", "2 20", star, 0, 0, 0},
    {"a_hub", "2 29", a_hub, 0, 0, 0},
    {"huge_over_small", "29 33 40", huge_over_small, 0, 0, 0},
    {"towards_a_corner", "14 34", towards_a_corner, 0, 0, 1},
    {"lattice_deep", "22 24 26 30 34", lattice, 0, 0, 1},
    {"a_wall_and_splinters", "25 29 31", a_wall_and_splinters, 0, 0, 0},
    {"slanted_walls", "33 40", slanted_walls, 0, 0, 0},
    {"pointing_at_a_line", "35 37", pointing_at_a_line, 0, 0, 0},
    {"covers_that_intersect", "38 39 40", covers_that_intersect, 0, 0, 0},
    {"plates_that_nearly_cover", "11 38 40", plates_that_nearly_cover, 0, 0, 0},
};

size_t hard_scene_count(void)
{
    return sizeof scenes / sizeof scenes[0];
}

const struct hard_scene *hard_scene_at(size_t index)
{
    return &scenes[index];
}

struct fixture make_hard_scene(size_t index)
{
    const struct hard_scene *scene = &scenes[index];
    struct random random = {index + 1};
    struct soup soup = {0};
    scene->make(&soup, &random);
    assert_true(soup.count <= TRIANGLE_LIMIT);
    if (scene->scale != 0 || scene->shift != 0) {
        const float offset[3] = {scene->shift, scene->shift, -scene->shift};
        move_soup(&soup, scene->scale != 0 ? scene->scale : 1, offset);
    }
    mlrt_mesh mesh = soup_mesh(&soup);
    const mlrt_kdtree_options tuned = {.struct_size = sizeof tuned, .preset = MLRT_KDTREE_TUNED};
    const mlrt_kdtree_options deepest = {.struct_size = sizeof deepest,
                                         .preset = MLRT_KDTREE_PAPER,
                                         .rules_off = MLRT_RULE_MINIMUM_CELL | MLRT_RULE_RETRACTION,
                                         .max_depth = 60,
                                         .max_references = 1000000,
                                         .traversal_cost = 1e-3f,
                                         .intersection_cost = 1e3f};
    struct fixture fixture = make_fixture_with(scene->name, index + 1, &mesh, 1, scene->deep ? &deepest : &tuned);
    free_soup(&soup);
    return fixture;
}
