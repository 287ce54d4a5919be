/* SPDX-License-Identifier: MIT */
/* furniture.c - the furniture of the procedural rooms: see furniture.h */
#include "furniture.h"

#include "steady_math.h"

#include <math.h>

void set_materials(struct scene *scene)
{
    static const struct material materials[] = {
        [WALL] = {{0.78f, 0.74f, 0.66f}, 0},        [ACCENT] = {{0.16f, 0.34f, 0.38f}, 0},
        [FLOOR_LIGHT] = {{0.48f, 0.30f, 0.16f}, 0}, [FLOOR_DARK] = {{0.40f, 0.24f, 0.12f}, 0},
        [CEILING] = {{0.86f, 0.85f, 0.82f}, 0},     [WOOD] = {{0.55f, 0.33f, 0.15f}, 0},
        [DARK_WOOD] = {{0.23f, 0.11f, 0.05f}, 0},   [METAL] = {{0.48f, 0.50f, 0.53f}, 0},
        [BLACK] = {{0.04f, 0.04f, 0.05f}, 0},       [WHITE] = {{0.85f, 0.85f, 0.84f}, 0},
        [FABRIC] = {{0.55f, 0.12f, 0.07f}, 0},      [FABRIC_2] = {{0.08f, 0.22f, 0.42f}, 0},
        [LEAF] = {{0.10f, 0.36f, 0.08f}, 0},        [LEAF_2] = {{0.20f, 0.46f, 0.10f}, 0},
        [TERRACOTTA] = {{0.62f, 0.24f, 0.11f}, 0},  [BRASS] = {{0.72f, 0.50f, 0.17f}, 0},
        [LAMP] = {{1.00f, 0.90f, 0.68f}, 0.85f},    [SCREEN] = {{0.30f, 0.52f, 0.80f}, 0.55f},
        [GLASS] = {{0.70f, 0.84f, 0.98f}, 0.75f},   [PAPER] = {{0.92f, 0.90f, 0.84f}, 0},
        [CARPET] = {{0.28f, 0.08f, 0.09f}, 0},      [SPINE] = {{0.60f, 0.10f, 0.08f}, 0},
        [SPINE + 1] = {{0.10f, 0.27f, 0.50f}, 0},   [SPINE + 2] = {{0.78f, 0.58f, 0.16f}, 0},
        [SPINE + 3] = {{0.12f, 0.38f, 0.24f}, 0},   [SPINE + 4] = {{0.80f, 0.74f, 0.60f}, 0},
        [SPINE + 5] = {{0.30f, 0.12f, 0.32f}, 0},
    };
    for (size_t i = 0; i < sizeof materials / sizeof *materials; i++) scene->materials[i] = materials[i];
}

static uint32_t at_least(uint32_t low, uint32_t x)
{
    return x < low ? low : x;
}

/* ---- seats --------------------------------------------------------------------------------------------------- */

void add_wooden_chair(struct shapes *shapes, const struct place *place)
{
    shapes->material = WOOD;
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 0.17 : -0.21, z = i & 2 ? 0.17 : -0.21;
        add_box(shapes, place, x, 0, z, x + 0.04, i & 2 ? 0.43 : 0.95, z + 0.04);
    }
    add_box(shapes, place, -0.17, 0.84, -0.2, 0.17, 0.92, -0.18);
    add_box(shapes, place, -0.17, 0.66, -0.2, 0.17, 0.74, -0.18);
    shapes->material = FABRIC;
    add_box(shapes, place, -0.22, 0.43, -0.165, 0.22, 0.48, 0.23);
}

// A five-armed foot with castors and a column up to `height`.
static void add_swivel_foot(struct shapes *shapes, const struct place *place, double height, uint32_t detail)
{
    static const double castor[][2] = {{0, 0}, {0.022, 0.004}, {0.03, 0.03}, {0.022, 0.056}, {0, 0.06}};
    for (int i = 0; i < 5; i++) {
        struct place arm = place_at(place, 0, 0, 0, 0.07 + i / 5.0);
        static const double curve[4][3] = {{0, 0.12, 0}, {0, 0.13, 0.12}, {0, 0.085, 0.2}, {0, 0.075, 0.3}};
        shapes->material = METAL;
        add_rod(shapes, &arm, curve, 0.018, at_least(2, detail / 4), at_least(5, detail / 2));
        shapes->material = BLACK;
        struct place end = place_at(&arm, 0, 0, 0.29, 0);
        add_lathe(shapes, &end, castor, 5, at_least(1, detail / 16), at_least(5, detail / 2));
    }
    const double column[][2] = {{0, 0.07},      {0.045, 0.075},         {0.045, 0.15},
                                {0.028, 0.155}, {0.028, height - 0.04}, {0.07, height}};
    shapes->material = METAL;
    add_lathe(shapes, place, column, 6, 1, detail);
}

void add_office_chair(struct shapes *shapes, const struct place *place, uint32_t detail)
{
    add_swivel_foot(shapes, place, 0.42, detail);
    uint32_t columns = 2 * detail, rows = at_least(4, detail * 3 / 4);
    const struct cushion seat = {{0, 0.47, 0.01}, {0.25, 0.05, 0.245}, 1, 0, 0};
    const struct cushion back = {{0, 0.82, -0.25}, {0.23, 0.26, 0.04}, 1, 0.07, -0.05};
    shapes->material = FABRIC;
    add_cushion(shapes, place, &seat, columns, rows);
    add_cushion(shapes, place, &back, columns, rows);
    static const double spine[4][3] = {{0, 0.43, -0.1}, {0, 0.42, -0.3}, {0, 0.5, -0.32}, {0, 0.8, -0.285}};
    shapes->material = METAL;
    add_rod(shapes, place, spine, 0.02, at_least(4, detail / 2), at_least(5, detail / 2));
    for (int side = -1; side <= 1; side += 2) {
        const double rail[4][3] = {{side * 0.24, 0.45, -0.12},
                                   {side * 0.36, 0.5, -0.14},
                                   {side * 0.28, 0.8, -0.12},
                                   {side * 0.29, 0.66, 0.16}};
        shapes->material = METAL;
        add_rod(shapes, place, rail, 0.014, at_least(4, detail / 2), at_least(5, detail / 2));
        const struct cushion pad = {{side * 0.29, 0.685, 0.05}, {0.035, 0.018, 0.13}, 1, 0, 0};
        shapes->material = BLACK;
        add_cushion(shapes, place, &pad, detail, at_least(3, detail / 3));
    }
}

void add_armchair(struct shapes *shapes, const struct place *place, double width, uint32_t detail)
{
    uint32_t columns = 2 * detail, rows = at_least(4, detail * 2 / 3);
    double half = width / 2;
    const struct cushion parts[] = {
        {{0, 0.27, 0}, {half, 0.15, 0.4}, 2, 0, 0},
        {{0, 0.44, 0.05}, {half - 0.13, 0.07, 0.33}, 2, 0, 0},
        {{0, 0.6, -0.33}, {half - 0.1, 0.3, 0.11}, 2, 0, -0.07},
        {{-half + 0.07, 0.44, 0}, {0.08, 0.2, 0.4}, 2, 0, 0},
        {{half - 0.07, 0.44, 0}, {0.08, 0.2, 0.4}, 2, 0, 0},
    };
    shapes->material = FABRIC_2;
    for (int i = 0; i < 5; i++) add_cushion(shapes, place, &parts[i], columns, rows);
    shapes->material = DARK_WOOD;
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? half - 0.12 : -half + 0.07, z = i & 2 ? 0.27 : -0.32;
        add_box(shapes, place, x, 0, z, x + 0.05, 0.13, z + 0.05);
    }
}

/* ---- tables -------------------------------------------------------------------------------------------------- */

void add_table(struct shapes *shapes, const struct place *place, double width, double depth)
{
    double x = width / 2, z = depth / 2;
    shapes->material = DARK_WOOD;
    for (int i = 0; i < 4; i++) {
        double lx = i & 1 ? x - 0.12 : -x + 0.05, lz = i & 2 ? z - 0.12 : -z + 0.05;
        add_box(shapes, place, lx, 0, lz, lx + 0.07, 0.7, lz + 0.07);
    }
    shapes->material = WOOD;
    add_box(shapes, place, -x, 0.7, -z, x, 0.74, z);
}

struct slab {
    double half_width, half_depth, bottom, top;
};

// A flat slab, between an ellipse and its rectangle in outline: middle, lower rim, edge, upper rim, middle.
static void slab_point(const void *surface, double u, double v, double point[3])
{
    static const double ring[6] = {0, 0.985, 1, 1, 0.985, 0};
    static const double level[6] = {0, 0, 0.3, 0.7, 1, 1};
    const struct slab *slab = surface;
    int row = (int)(v * 5 + 0.5);
    double c = turn_cos(u), s = turn_sin(u);
    // From the circle out to |x|^3 + |z|^3 = 1: by sum^(-1/3), found with Newton's method, as cbrt differs between
    // libms.
    double sum = fabs(c * c * c) + fabs(s * s * s), push = 1;
    for (int i = 0; i < 5; i++) push *= (4 - sum * push * push * push) / 3;
    point[0] = slab->half_width * ring[row] * c * push;
    point[1] = slab->bottom + (slab->top - slab->bottom) * level[row];
    point[2] = slab->half_depth * ring[row] * s * push;
}

void add_oval_table(struct shapes *shapes, const struct place *place, double width, double depth, uint32_t detail)
{
    const struct slab top = {width / 2, depth / 2, 0.7, 0.745},
                      inlay = {width / 2 - 0.3, depth / 2 - 0.3, 0.743, 0.747};
    shapes->material = WOOD;
    add_surface(shapes, place, 4 * detail, 5, 1, slab_point, &top);
    shapes->material = DARK_WOOD;
    add_surface(shapes, place, 4 * detail, 5, 1, slab_point, &inlay);
    static const double column[][2] = {{0, 0},      {0.42, 0.005}, {0.4, 0.04}, {0.16, 0.09},
                                       {0.12, 0.3}, {0.14, 0.55},  {0.3, 0.7}};
    for (int i = -1; i <= 1; i++) {
        struct place foot = place_at(place, i * width * 0.3, 0, 0, 0);
        add_lathe(shapes, &foot, column, 7, at_least(1, detail / 6), detail);
    }
}

static void add_desk_lamp(struct shapes *shapes, const struct place *place, uint32_t detail)
{
    static const double foot[][2] = {{0, 0}, {0.08, 0}, {0.075, 0.015}, {0, 0.025}};
    static const double arm[4][3] = {{0, 0.02, 0}, {0, 0.35, -0.12}, {0, 0.45, 0.02}, {0, 0.38, 0.16}};
    static const double shade[][2] = {{0.075, 0}, {0.07, 0.03}, {0.03, 0.075}, {0, 0.08}};
    shapes->material = BRASS;
    add_lathe(shapes, place, foot, 4, 1, detail);
    add_rod(shapes, place, arm, 0.008, detail, 6);
    struct place end = place_at(place, 0, 0.33, 0.17, 0);
    add_lathe(shapes, &end, shade, 4, 2, detail);
}

static void add_monitor(struct shapes *shapes, const struct place *place)
{
    shapes->material = BLACK;
    add_box(shapes, place, -0.12, 0, -0.08, 0.12, 0.012, 0.08);
    add_box(shapes, place, -0.02, 0.012, -0.05, 0.02, 0.2, -0.03);
    add_box(shapes, place, -0.28, 0.12, -0.03, 0.28, 0.47, 0);
    shapes->material = SCREEN;
    add_box(shapes, place, -0.265, 0.135, 0, 0.265, 0.455, 0.001);
}

void add_desk(struct shapes *shapes, const struct place *place, uint32_t detail, uint32_t *random)
{
    shapes->material = WOOD;
    add_box(shapes, place, -0.8, 0.7, -0.4, 0.8, 0.735, 0.4);
    shapes->material = METAL;
    for (int side = -1; side <= 1; side += 2) {
        add_box(shapes, place, side * 0.74 - 0.02, 0, -0.35, side * 0.74 + 0.02, 0.7, -0.31);
        add_box(shapes, place, side * 0.74 - 0.02, 0, 0.31, side * 0.74 + 0.02, 0.7, 0.35);
    }
    shapes->material = WHITE;
    add_box(shapes, place, 0.35, 0.1, -0.3, 0.72, 0.7, 0.33);
    shapes->material = METAL;
    for (int i = 0; i < 3; i++) add_box(shapes, place, 0.46, 0.23 + i * 0.18, 0.33, 0.6, 0.25 + i * 0.18, 0.345);
    double screen_x = random_between(random, -0.15, 0.05), screen_turns = random_between(random, -0.03, 0.03);
    struct place screen = place_at(place, screen_x, 0.735, -0.2, screen_turns);
    add_monitor(shapes, &screen);
    struct place lamp = place_at(place, -0.6, 0.735, -0.2, random_between(random, 0, 0.2));
    add_desk_lamp(shapes, &lamp, detail);
    struct place cup = place_at(place, 0.4, 0.735, 0.12, random_between(random, 0, 1));
    add_cup(shapes, &cup, detail);
    shapes->material = BLACK;
    add_box(shapes, place, -0.25, 0.735, 0.08, 0.2, 0.75, 0.24);
    for (int i = 0; i < 4; i++) {
        struct place sheet = place_at(place, -0.55, 0.735 + i * 0.004, 0.15, random_between(random, -0.06, 0.06));
        shapes->material = PAPER;
        add_box(shapes, &sheet, -0.105, 0, -0.148, 0.105, 0.003, 0.148);
    }
}

/* ---- on walls and ceilings ----------------------------------------------------------------------------------- */

void add_shelf(struct shapes *shapes, const struct place *place, double width, double height, uint32_t boards,
               uint32_t books_per_board, uint32_t *random)
{
    double half = width / 2, pitch = (height - 0.1) / boards;
    shapes->material = WOOD;
    add_box(shapes, place, -half, 0, -0.15, -half + 0.03, height, 0.15);
    add_box(shapes, place, half - 0.03, 0, -0.15, half, height, 0.15);
    for (uint32_t i = 0; i <= boards; i++) {
        double y = 0.07 + i * pitch;
        shapes->material = WOOD;
        add_box(shapes, place, -half + 0.03, y, -0.15, half - 0.03, y + 0.025, 0.15);
        if (i == boards) break;
        double x = -half + 0.04, thickness = (width - 0.08) / (books_per_board ? books_per_board : 1);
        for (uint32_t k = 0; k < books_per_board; k++, x += thickness) {
            double thick = thickness * random_between(random, 0.72, 0.97);
            double top = y + 0.025 + (pitch - 0.03) * random_between(random, 0.6, 0.92);
            double front = random_between(random, 0.04, 0.12);
            shapes->material = (uint8_t)(SPINE + random_below(random, 6));
            if (random_below(random, 9) != 0) add_box(shapes, place, x, y + 0.025, -0.14, x + thick, top, front);
        }
    }
}

void add_plant(struct shapes *shapes, const struct place *place, uint32_t leaves, uint32_t detail, uint32_t *random)
{
    static const double pot[][2] = {{0, 0},        {0.15, 0},    {0.2, 0.33}, {0.21, 0.36},
                                    {0.185, 0.36}, {0.18, 0.32}, {0, 0.31}};
    shapes->material = TERRACOTTA;
    add_lathe(shapes, place, pot, 7, 1, at_least(8, detail));
    for (uint32_t i = 0; i < leaves; i++) {
        double share = (double)i / leaves, angle = i * 0.381966 + random_between(random, -0.04, 0.04);
        double reach = random_between(random, 0.3, 0.55) * (1.15 - 0.5 * share), c = turn_cos(angle),
               s = turn_sin(angle);
        double height = 0.5 + 0.85 * share + random_between(random, -0.05, 0.1);
        struct leaf leaf = {{0.03 * c, 0.31, 0.03 * s}, {reach * c, height, reach * s}, 0, 0};
        leaf.droop = random_between(random, 0.1, 0.28);
        leaf.width = random_between(random, 0.08, 0.15);
        shapes->material = i % 3 ? LEAF : LEAF_2;
        add_leaf(shapes, place, &leaf, at_least(4, detail / 2));
    }
}

void add_pendant(struct shapes *shapes, const struct place *place, double length, double radius, uint32_t detail)
{
    const double shade[][2] = {{radius, -length},
                               {radius * 0.97, -length + radius * 0.3},
                               {radius * 0.6, -length + radius * 0.75},
                               {radius * 0.18, -length + radius * 0.95},
                               {0, -length + radius}};
    const double canopy[][2] = {{0, -0.04}, {0.06, -0.03}, {0.06, 0}};
    const double bulb[][2] = {{0, -length + radius * 0.08},
                              {radius * 0.26, -length + radius * 0.25},
                              {radius * 0.26, -length + radius * 0.4},
                              {0, -length + radius * 0.6}};
    shapes->material = BRASS;
    add_lathe(shapes, place, shade, 5, detail > 8 ? at_least(2, detail / 5) : 1, detail);
    shapes->material = LAMP;
    add_lathe(shapes, place, bulb, 4, detail > 8 ? 3 : 1, at_least(6, detail / 2));
    shapes->material = BLACK;
    if (detail > 8) add_lathe(shapes, place, canopy, 3, 1, detail);
    add_box(shapes, place, -0.006, -length + radius, -0.006, 0.006, 0, 0.006);
}

void add_cup(struct shapes *shapes, const struct place *place, uint32_t detail)
{
    static const double cup[][2] = {{0, 0.002},     {0.028, 0.002}, {0.038, 0.05}, {0.041, 0.085},
                                    {0.037, 0.085}, {0.034, 0.05},  {0.02, 0.01},  {0, 0.01}};
    static const double handle[4][3] = {{0.036, 0.07, 0}, {0.075, 0.08, 0}, {0.07, 0.02, 0}, {0.033, 0.022, 0}};
    shapes->material = WHITE;
    add_lathe(shapes, place, cup, 8, at_least(1, detail / 12), detail);
    add_rod(shapes, place, handle, 0.005, at_least(4, detail / 3), at_least(4, detail / 4));
}

void add_laptop(struct shapes *shapes, const struct place *place)
{
    shapes->material = METAL;
    add_box(shapes, place, -0.165, 0, -0.115, 0.165, 0.015, 0.115);
    shapes->material = BLACK;
    for (int row = 0; row < 5; row++)
        for (int key = 0; key < 14; key++) {
            double x = -0.147 + key * 0.021, z = -0.085 + row * 0.021;
            add_box(shapes, place, x, 0.015, z, x + 0.018, 0.017, z + 0.018);
        }
    static const double lid[4][3] = {
        {-0.165, 0.015, -0.118}, {0.165, 0.015, -0.118}, {0.165, 0.23, -0.17}, {-0.165, 0.23, -0.17}};
    static const double screen[4][3] = {
        {-0.155, 0.027, -0.1185}, {0.155, 0.027, -0.1185}, {0.155, 0.222, -0.1655}, {-0.155, 0.222, -0.1655}};
    shapes->material = METAL;
    add_quad(shapes, place, lid);
    shapes->material = SCREEN;
    add_quad(shapes, place, screen);
}

void add_blind(struct shapes *shapes, const struct place *place, double width, double height, uint32_t slats)
{
    double half = width / 2, pitch = height / slats;
    shapes->material = WHITE;
    add_box(shapes, place, -half, height, -0.03, half, height + 0.05, 0.03);
    for (uint32_t i = 0; i < slats; i++) {
        double y = i * pitch, rise = 0.35 * pitch, slat = 0.025;
        const double lower[4][3] = {{-half, y, -slat}, {half, y, -slat}, {half, y + rise, 0}, {-half, y + rise, 0}};
        const double upper[4][3] = {
            {-half, y + rise, 0}, {half, y + rise, 0}, {half, y + 1.6 * rise, slat}, {-half, y + 1.6 * rise, slat}};
        add_quad(shapes, place, lower);
        add_quad(shapes, place, upper);
    }
}

void add_radiator(struct shapes *shapes, const struct place *place, uint32_t ribs, uint32_t detail)
{
    shapes->material = WHITE;
    for (uint32_t i = 0; i < ribs; i++) {
        const struct cushion rib = {{(i - (ribs - 1) / 2.0) * 0.06, 0.4, 0}, {0.022, 0.3, 0.06}, 1, 0, 0};
        add_cushion(shapes, place, &rib, detail, at_least(4, detail / 2));
    }
    double half = ribs * 0.03;
    add_box(shapes, place, -half, 0.16, -0.015, half, 0.19, 0.015);
    add_box(shapes, place, -half, 0.61, -0.015, half, 0.64, 0.015);
}

void add_picture(struct shapes *shapes, const struct place *place, double width, double height, uint8_t material)
{
    double x = width / 2, y = height / 2;
    shapes->material = DARK_WOOD;
    add_box(shapes, place, -x, -y, 0, x, y, 0.025);
    shapes->material = PAPER;
    add_box(shapes, place, -x + 0.03, -y + 0.03, 0.025, x - 0.03, y - 0.03, 0.028);
    shapes->material = material;
    add_box(shapes, place, -x * 0.6, -y * 0.6, 0.028, x * 0.6, y * 0.6, 0.03);
}
