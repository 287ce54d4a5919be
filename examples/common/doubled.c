/* SPDX-License-Identifier: MIT */
/*
 * doubled.c - the scene `doubled`: a kitchen whose large surfaces are all there twice, about 19 thousand triangles
 *
 * Such surfaces are common in CAD and game data: a wall of a room and of its neighbour, a front of a cupboard and its
 * veneer. The second copy of a surface is cut into another grid, along the other diagonals, and each coordinate of its
 * vertices is at most 3 floats away from the first copy's plane. In every fourth surface it is 0 floats away: where
 * such a surface is parallel to an axis, rays hit both copies at the same distance.
 */
#include "furniture.h"
#include "procedural.h"
#include "steady_math.h"

#include <string.h>

enum { MOST_ULPS = 3 };

static const double half_x = 2.6, half_z = 2.1, top = 2.6;
static const double pitches[2] = {0.31, 0.22}; // of the grids of the two copies, in metres

/* A flat rectangle by its corners in order. */
struct patch {
    double corners[4][3];
};

struct doubler {
    struct shapes *shapes;
    uint32_t surface_count; /* so far */
    uint32_t random;
};

/* ---- surfaces ------------------------------------------------------------------------------------------------ */

static void patch_point(const void *surface, double u, double v, double point[3])
{
    const struct patch *patch = surface;
    for (int k = 0; k < 3; k++) {
        point[k] = (1 - v) * ((1 - u) * patch->corners[0][k] + u * patch->corners[1][k]) +
                   v * ((1 - u) * patch->corners[3][k] + u * patch->corners[2][k]);
    }
}

// So many floats away from `x`, which is neither 0 nor next to it.
static float moved(float x, int32_t ulps)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits += ulps;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static void move_vertices(struct doubler *doubler, size_t first, uint32_t most)
{
    const struct scene *scene = doubler->shapes->scene;
    for (size_t i = 3 * first; i < 3 * scene->vertex_count && !doubler->shapes->failed; i++) {
        const int32_t ulps = (int32_t)random_below(&doubler->random, 2 * most + 1) - (int32_t)most;
        scene->vertices[i] = moved(scene->vertices[i], ulps);
    }
}

static uint32_t cells_between(const double a[3], const double b[3], double pitch)
{
    double length = 0; // along the axes: sides are parallel to them in their place
    for (int k = 0; k < 3; k++) length += a[k] < b[k] ? b[k] - a[k] : a[k] - b[k];
    return 1 + (uint32_t)(length / pitch);
}

// Cells are cut in parallel to the line from the first corner to the third; the second copy begins at another corner.
static void add_doubled(struct doubler *doubler, const struct place *place, const struct patch *patch)
{
    for (int copy = 0; copy < 2; copy++) {
        struct patch turned;
        for (int i = 0; i < 4; i++) memcpy(turned.corners[i], patch->corners[(i + copy) % 4], sizeof turned.corners[i]);
        const uint32_t columns = cells_between(turned.corners[0], turned.corners[1], pitches[copy]);
        const uint32_t rows = cells_between(turned.corners[0], turned.corners[3], pitches[copy]);
        const size_t first = doubler->shapes->scene->vertex_count;
        add_surface(doubler->shapes, place, columns, rows, 0, patch_point, &turned);
        if (copy) move_vertices(doubler, first, doubler->surface_count % (MOST_ULPS + 1));
    }
    doubler->surface_count++;
}

static void add_doubled_box(struct doubler *doubler, const struct place *place, double x0, double y0, double z0,
                            double x1, double y1, double z1)
{
    static const uint8_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int i = 0; i < 6; i++) {
        struct patch patch;
        for (int k = 0; k < 4; k++) {
            const int corner = faces[i][k];
            patch.corners[k][0] = corner & 1 ? x1 : x0;
            patch.corners[k][1] = corner & 2 ? y1 : y0;
            patch.corners[k][2] = corner & 4 ? z1 : z0;
        }
        add_doubled(doubler, place, &patch);
    }
}

/* ---- the kitchen --------------------------------------------------------------------------------------------- */

static void add_shell(struct doubler *doubler, const struct place *place)
{
    const double x = half_x, z = half_z;
    const struct {
        uint8_t material;
        struct patch patch;
    } sides[] = {
        {ACCENT, {{{-x, 0, -z}, {x, 0, -z}, {x, top, -z}, {-x, top, -z}}}},
        {WALL, {{{x, 0, z}, {-x, 0, z}, {-x, top, z}, {x, top, z}}}},
        {WALL, {{{-x, 0, z}, {-x, 0, -z}, {-x, top, -z}, {-x, top, z}}}},
        {WALL, {{{x, 0, -z}, {x, 0, z}, {x, top, z}, {x, top, -z}}}},
        {FLOOR_LIGHT, {{{-x, 0, z}, {x, 0, z}, {x, 0, -z}, {-x, 0, -z}}}},
        {CEILING, {{{-x, top, -z}, {x, top, -z}, {x, top, z}, {-x, top, z}}}},
    };
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
        doubler->shapes->material = sides[i].material;
        add_doubled(doubler, place, &sides[i].patch);
    }
}

static void add_handle(struct shapes *shapes, const struct place *place, double y, double z)
{
    shapes->material = METAL;
    add_box(shapes, place, -0.08, y, z + 0.015, 0.08, y + 0.015, z + 0.03);
    add_box(shapes, place, -0.08, y, z, -0.065, y + 0.015, z + 0.015);
    add_box(shapes, place, 0.065, y, z, 0.08, y + 0.015, z + 0.015);
}

// Cupboards under a worktop, and others on the wall above, each 0.6 m wide.
static void add_row(struct doubler *doubler, const struct place *place, int count)
{
    struct shapes *shapes = doubler->shapes;
    for (int i = 0; i < count; i++) {
        const struct place here = place_at(place, 0.6 * (i + 0.5), 0, 0, 0);
        shapes->material = WHITE;
        add_doubled_box(doubler, &here, -0.3, 0.1, 0, 0.3, 0.86, 0.58);
        add_doubled_box(doubler, &here, -0.3, 1.45, 0, 0.3, 2.15, 0.34);
        shapes->material = WOOD;
        add_doubled_box(doubler, &here, -0.29, 0.12, 0.58, 0.29, 0.84, 0.6);
        add_doubled_box(doubler, &here, -0.29, 1.47, 0.34, 0.29, 2.13, 0.36);
        add_handle(shapes, &here, 0.76, 0.6);
        add_handle(shapes, &here, 1.52, 0.36);
    }
    shapes->material = DARK_WOOD;
    add_doubled_box(doubler, place, 0, 0.86, 0, 0.6 * count, 0.9, 0.62);
    shapes->material = BLACK;
    add_doubled_box(doubler, place, 0, 0, 0.02, 0.6 * count, 0.1, 0.53);
}

static void add_crockery(struct shapes *shapes, const struct place *place)
{
    static const double bowl[][2] = {{0, 0},       {0.07, 0},    {0.14, 0.04}, {0.18, 0.1},
                                     {0.165, 0.1}, {0.06, 0.02}, {0, 0.02}};
    shapes->material = TERRACOTTA;
    add_lathe(shapes, place, bowl, 7, 2, 24);
    for (int i = 0; i < 3; i++) {
        const struct place cup = place_at(place, 0.3 + 0.13 * i, 0, 0.05 - 0.1 * (i % 2), 0.3 * i);
        add_cup(shapes, &cup, 12);
    }
}

static void add_table_and_chairs(struct doubler *doubler, const struct place *place)
{
    static const double seats[4][3] = {
        {-0.35, 0.6, 0.52}, {0.35, 0.66, 0.47}, {-0.35, -0.64, 0.02}, {0.38, -0.6, -0.03}};
    struct shapes *shapes = doubler->shapes;
    add_table(shapes, place, 1.4, 0.8);
    shapes->material = WOOD;
    add_doubled_box(doubler, place, -0.72, 0.74, -0.42, 0.72, 0.76, 0.42);
    for (int i = 0; i < 4; i++) {
        const struct place seat = place_at(place, seats[i][0], 0, seats[i][1], seats[i][2]);
        add_wooden_chair(shapes, &seat);
    }
    const struct place crockery = place_at(place, -0.2, 0.76, 0, 0.1);
    add_crockery(shapes, &crockery);
}

// In an upper storey away from the origin of the house, so that no coordinate is near 0.
void make_doubled(struct shapes *shapes)
{
    struct scene *scene = shapes->scene;
    const struct place world = world_place(), kitchen = place_at(&world, 11.3, 3.1, 7.9, 0);
    struct doubler doubler = {shapes, 0, 17};
    set_materials(scene);
    add_shell(&doubler, &kitchen);

    const struct place back = place_at(&kitchen, -half_x + 0.65, 0, -half_z, 0);
    add_row(&doubler, &back, 6);
    const struct place left = place_at(&kitchen, -half_x, 0, half_z - 0.4, 0.25);
    add_row(&doubler, &left, 3);
    const struct place cup = place_at(&back, 1.4, 0.9, 0.3, 0);
    add_crockery(shapes, &cup);

    const struct place fridge = place_at(&kitchen, half_x - 0.33, 0, -half_z + 0.36, 0);
    shapes->material = METAL;
    add_doubled_box(&doubler, &fridge, -0.3, 0.03, -0.32, 0.3, 2, 0.28);
    shapes->material = SPINE + 1;
    add_doubled_box(&doubler, &fridge, -0.3, 0.03, 0.28, 0.3, 2, 0.31);

    const struct place table = place_at(&kitchen, 0.75, 0, 0.55, 0.04);
    add_table_and_chairs(&doubler, &table);
    const struct place rug = place_at(&kitchen, -0.8, 0, 0.2, 0.02);
    shapes->material = CARPET;
    add_doubled_box(&doubler, &rug, -0.5, 0, -0.8, 0.5, 0.012, 0.8);
    const struct place picture = place_at(&kitchen, half_x, 1.6, 0.5, -0.25);
    add_picture(shapes, &picture, 0.9, 0.6, SPINE + 2);
    const struct place lamp = place_at(&kitchen, 0.75, top, 0.55, 0);
    add_pendant(shapes, &lamp, 0.8, 0.26, 24);
    const struct place plant = place_at(&kitchen, -half_x + 0.35, 0, half_z - 0.3, 0);
    add_plant(shapes, &plant, 30, 8, &doubler.random);

    const struct view view = {{13.6, 4.85, 9.75}, {10.75, 3.95, 7.0}, {0, 1, 0}, 62, {11.2, 5.3, 8.3}};
    scene->view = view;
    scene->light_range = 2.4;
}
