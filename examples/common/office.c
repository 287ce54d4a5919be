/* SPDX-License-Identifier: MIT */
/*
 * office.c - the scene `office`: a conference room, about 280 thousand triangles
 *
 * It is like the conference rooms of ray tracing papers: most triangles are small, in the curved parts of chairs, lamps
 * and plants, while walls, tables and blinds are large and flat.
 */
#include "furniture.h"
#include "procedural.h"
#include "steady_math.h"

static const double half_x = 5.5, half_z = 3.6, top = 3.0;

static void add_floor_and_ceiling(struct shapes *shapes, const struct place *place)
{
    enum { COLUMNS = 22, ROWS = 14 };
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        double x = -half_x + 0.5 * (i % COLUMNS), z = -half_z + 2 * half_z / ROWS * (i / COLUMNS);
        double x1 = x + 0.5, z1 = z + 2 * half_z / ROWS;
        const double tile[4][3] = {{x, 0, z1}, {x1, 0, z1}, {x1, 0, z}, {x, 0, z}};
        shapes->material = (i + i / COLUMNS) % 2 ? FLOOR_LIGHT : FLOOR_DARK;
        add_quad(shapes, place, tile);
    }
    shapes->material = CEILING;
    add_box(shapes, place, -half_x, top, -half_z, half_x, top + 0.1, half_z);
    for (int i = 0; i < 8; i++) {
        struct place panel = place_at(place, -4.2 + 2.8 * (i / 2), top, i % 2 ? 2.3 : -2.3, 0);
        shapes->material = METAL;
        add_box(shapes, &panel, -0.66, -0.03, -0.36, 0.66, 0, 0.36);
        shapes->material = LAMP;
        add_box(shapes, &panel, -0.6, -0.032, -0.3, 0.6, -0.03, 0.3);
    }
}

// The long wall to the back: four windows with blinds, a radiator below each.
static void add_window_wall(struct shapes *shapes, const struct place *place)
{
    shapes->material = WALL;
    add_box(shapes, place, -half_x, 0, -half_z - 0.2, half_x, 0.85, -half_z);
    add_box(shapes, place, -half_x, 2.6, -half_z - 0.2, half_x, top, -half_z);
    for (int i = 0; i <= 4; i++) {
        double x = -half_x + i * 2.75;
        add_box(shapes, place, x - 0.3, 0.85, -half_z - 0.2, x + 0.3, 2.6, -half_z);
    }
    shapes->material = GLASS;
    add_box(shapes, place, -half_x, 0.85, -half_z - 0.21, half_x, 2.6, -half_z - 0.2);
    for (int i = 0; i < 4; i++) {
        struct place window = place_at(place, -half_x + (i + 0.5) * 2.75, 0.85, -half_z, 0);
        shapes->material = WHITE;
        add_box(shapes, &window, -1.1, -0.03, -0.2, 1.1, 0, 0.12);
        add_box(shapes, &window, -0.025, 0, -0.2, 0.025, 1.75, -0.15);
        double drop = i == 1 ? 0.75 : i == 2 ? 1.1 : 1.6;
        struct place blind = place_at(&window, 0, 1.7 - drop, -0.08, 0);
        add_blind(shapes, &blind, 2.1, drop, (uint32_t)(drop * 28));
        struct place radiator = place_at(&window, 0, -0.85, 0.09, 0);
        add_radiator(shapes, &radiator, 24, 16);
    }
}

static void add_screen_wall(struct shapes *shapes, const struct place *place, uint32_t *random)
{
    shapes->material = ACCENT;
    add_box(shapes, place, -half_x - 0.1, 0, -half_z, -half_x, top, half_z);
    struct place wall = place_at(place, -half_x, 0, 0, 0.25);
    shapes->material = BLACK;
    add_box(shapes, &wall, -1.35, 1.05, 0, 1.35, 2.5, 0.05);
    shapes->material = SCREEN;
    add_box(shapes, &wall, -1.3, 1.1, 0.05, 1.3, 2.45, 0.052);
    shapes->material = WHITE;
    for (int i = 0; i < 9; i++) {
        double x = -1.05 + i * 0.24, height = random_between(random, 0.15, 0.4) + i * 0.07;
        add_box(shapes, &wall, x, 1.25, 0.052, x + 0.15, 1.25 + height, 0.056);
    }
    shapes->material = WOOD;
    add_box(shapes, &wall, -1.8, 0.08, 0.02, 1.8, 0.72, 0.5);
    shapes->material = DARK_WOOD;
    add_box(shapes, &wall, -1.85, 0.72, 0, 1.85, 0.76, 0.52);
    for (int i = 0; i < 4; i++) {
        add_box(shapes, &wall, -1.76 + i * 0.89, 0.12, 0.5, -0.91 + i * 0.89, 0.69, 0.515);
    }
    struct place pot = place_at(&wall, -1.5, 0.76, 0.26, 0);
    add_plant(shapes, &pot, 60, 12, random);
}

static void add_shelf_wall(struct shapes *shapes, const struct place *place, uint32_t *random)
{
    shapes->material = WALL;
    add_box(shapes, place, -half_x, 0, half_z, half_x, top, half_z + 0.1);
    add_box(shapes, place, half_x, 0, -half_z, half_x + 0.1, top, half_z);
    for (int i = 0; i < 4; i++) {
        struct place shelf = place_at(place, -4.4 + i * 1.55, 0, half_z - 0.16, 0.5);
        add_shelf(shapes, &shelf, 1.5, 2.2, 6, 34, random);
    }
    for (int i = 0; i < 2; i++) {
        struct place picture = place_at(place, half_x, 1.6, -1.2 + 2.4 * i, -0.25);
        add_picture(shapes, &picture, 1.1, 0.8, (uint8_t)(SPINE + i));
    }
}

static void add_table_and_chairs(struct shapes *shapes, const struct place *place, uint32_t *random)
{
    shapes->material = CARPET;
    add_box(shapes, place, -3.9, 0, -1.95, 3.9, 0.012, 1.95);
    add_oval_table(shapes, place, 5.8, 1.7, 24);
    for (int i = 0; i < 14; i++) {
        double side = i % 2 ? -1 : 1, x = -2.25 + 0.9 * (i / 2), z = side * random_between(random, 1.12, 1.35);
        double turns = (side > 0 ? 0.5 : 0) + random_between(random, -0.06, 0.06);
        if (i >= 12) x = side * 3.45, z = 0, turns = side > 0 ? -0.25 : 0.25;
        struct place seat = place_at(place, x, 0.012, z, turns);
        add_office_chair(shapes, &seat, 37);
        if (i >= 12) continue;
        struct place work =
            place_at(place, x, 0.747, side * 0.56, (side > 0 ? 0.5 : 0) + random_between(random, -0.04, 0.04) + 0.5);
        if (i % 3 == 0) add_laptop(shapes, &work);
        shapes->material = PAPER;
        for (int k = 0; k < 3; k++) {
            struct place sheet = place_at(&work, 0.32, k * 0.003, 0, random_between(random, -0.04, 0.04));
            add_box(shapes, &sheet, -0.105, 0, -0.148, 0.105, 0.002, 0.148);
        }
        struct place cup = place_at(&work, -0.27, 0, -0.05, random_between(random, 0, 1));
        add_cup(shapes, &cup, 24);
    }
}

void make_office(struct shapes *shapes)
{
    struct scene *scene = shapes->scene;
    struct place world = world_place();
    uint32_t random = 7;
    set_materials(scene);
    add_floor_and_ceiling(shapes, &world);
    add_window_wall(shapes, &world);
    add_screen_wall(shapes, &world, &random);
    add_shelf_wall(shapes, &world, &random);
    add_table_and_chairs(shapes, &world, &random);
    for (int i = 0; i < 3; i++) {
        struct place lamp = place_at(&world, -1.7 + 1.7 * i, top, 0, 0);
        add_pendant(shapes, &lamp, 0.95, 0.28, 40);
    }
    static const double plants[3][2] = {{-4.9, -3.0}, {-4.9, 2.7}, {4.95, -3.1}};
    for (int i = 0; i < 3; i++) {
        struct place plant = place_at(&world, plants[i][0], 0, plants[i][1], 0);
        add_plant(shapes, &plant, 150, 20, &random);
    }

    const struct view view = {{4.9, 1.85, 2.75}, {-0.9, 0.72, -0.35}, {0, 1, 0}, 52, {2.3, 2.7, 2.1}};
    scene->view = view;
    scene->light_range = 4.5;
}
