/* SPDX-License-Identifier: MIT */
/*
 * building.c - the scene `building`: storeys of corridors and furnished rooms, about 2 million triangles
 *
 * Most of it is hidden from any point: a view shows a corridor and parts of a few rooms, and the rest is behind walls.
 * In 1024 x 1024 pixels the default view hits 0.23 % of the triangles. Doors stand open and rooms have windows to the
 * corridor, so that views reach into them.
 */
#include "furniture.h"
#include "procedural.h"
#include "steady_math.h"

enum { STOREYS = 5, ROOMS = 10, DETAIL = 12 };
static const double room_x = 5, room_z = 5.6, corridor = 1.4, height = 3.1, slab = 0.3, wall = 0.12;

struct opening {
    double x0, y0, x1, y1;
};

// A wall from x = 0 to `length`, with holes given from left to right, between z = -wall / 2 and wall / 2.
static void add_wall(struct shapes *shapes, const struct place *place, double length, const struct opening *openings,
                     uint32_t count)
{
    double x = 0, z = wall / 2;
    for (uint32_t i = 0; i < count; i++) {
        const struct opening *o = openings + i;
        add_box(shapes, place, x, 0, -z, o->x0, height, z);
        if (o->y0 > 0) add_box(shapes, place, o->x0, 0, -z, o->x1, o->y0, z);
        add_box(shapes, place, o->x0, o->y1, -z, o->x1, height, z);
        x = o->x1;
    }
    add_box(shapes, place, x, 0, -z, length, height, z);
}

// A frame around an opening, with `panes` - 1 bars across.
static void add_frame(struct shapes *shapes, const struct place *place, const struct opening *o, int panes)
{
    double z = wall / 2 + 0.02, w = 0.05;
    add_box(shapes, place, o->x0, o->y0, -z, o->x0 + w, o->y1, z);
    add_box(shapes, place, o->x1 - w, o->y0, -z, o->x1, o->y1, z);
    add_box(shapes, place, o->x0 + w, o->y1 - w, -z, o->x1 - w, o->y1, z);
    if (o->y0 > 0) add_box(shapes, place, o->x0 + w, o->y0, -z, o->x1 - w, o->y0 + w, z);
    for (int i = 1; i < panes; i++) {
        double x = o->x0 + (o->x1 - o->x0) * i / panes;
        add_box(shapes, place, x - 0.02, o->y0 + w, -0.02, x + 0.02, o->y1 - w, 0.02);
    }
}

// A leaf hinged at the left of its opening, `turns` open.
static void add_door(struct shapes *shapes, const struct place *place, const struct opening *o, double turns)
{
    static const double grip[4][3] = {{0.84, 1.0, 0.03}, {0.85, 1.0, 0.09}, {0.85, 1.0, 0.08}, {0.74, 1.0, 0.08}};
    struct place hinge = place_at(place, o->x0 + 0.05, 0, -wall / 2, turns);
    shapes->material = WOOD;
    add_box(shapes, &hinge, 0, 0.01, -0.02, o->x1 - o->x0 - 0.1, o->y1 - 0.06, 0.02);
    shapes->material = METAL;
    add_rod(shapes, &hinge, grip, 0.012, DETAIL, 8);
}

/* ---- rooms: x from 0 to room_x, the door at z = 0, the outer window at z = -room_z
 * ------------------------------------ */

static void furnish_office(struct shapes *shapes, const struct place *room, uint32_t *random)
{
    for (int i = 0; i < 4; i++) {
        double x = i % 2 ? 3.75 : 1.25, z = i / 2 ? -4.3 : -2.1;
        struct place desk = place_at(room, x, 0, z, i % 2 ? 0.25 : -0.25);
        add_desk(shapes, &desk, DETAIL, random);
        double seat_x = random_between(random, -0.2, 0.1), seat_z = random_between(random, 0.6, 0.9);
        struct place chair = place_at(&desk, seat_x, 0, seat_z, 0.5 + random_between(random, -0.1, 0.1));
        add_office_chair(shapes, &chair, DETAIL);
    }
    struct place shelf = place_at(room, 4.78, 0, -0.95, -0.25);
    add_shelf(shapes, &shelf, 1.4, 2.1, 6, 16, random);
}

static void furnish_meeting(struct shapes *shapes, const struct place *room, uint32_t *random)
{
    struct place table = place_at(room, 2.5, 0, -2.9, 0.25);
    add_oval_table(shapes, &table, 3, 1.3, DETAIL);
    for (int i = 0; i < 8; i++) {
        double side = i % 2 ? -1 : 1, away = side * random_between(random, 0.95, 1.2);
        double turns = (side > 0 ? 0.5 : 0) + random_between(random, -0.07, 0.07);
        struct place seat = place_at(&table, -1.2 + 0.8 * (i / 2), 0, away, turns);
        add_office_chair(shapes, &seat, DETAIL);
    }
    for (int i = 0; i < 2; i++) {
        struct place lamp = place_at(room, 2.5, height, -2.1 - 1.6 * i, 0);
        add_pendant(shapes, &lamp, 1, 0.24, 2 * DETAIL);
    }
    struct place picture = place_at(room, 4.94, 1.6, -2.9, -0.25);
    add_picture(shapes, &picture, 1.6, 1, (uint8_t)(SPINE + random_below(random, 6)));
}

static void furnish_library(struct shapes *shapes, const struct place *room, uint32_t *random)
{
    for (int i = 0; i < 8; i++) {
        struct place shelf = place_at(room, i % 2 ? 0.24 : 4.76, 0, -1.0 - 1.3 * (i / 2), i % 2 ? 0.25 : -0.25);
        add_shelf(shapes, &shelf, 1.25, 2.3, 6, 24, random);
    }
    struct place table = place_at(room, 2.5, 0, -3.4, 0.25);
    add_table(shapes, &table, 2.2, 0.9);
    for (int i = 0; i < 4; i++) {
        struct place chair = place_at(&table, i / 2 ? 0.5 : -0.5, 0, i % 2 ? 0.65 : -0.65, i % 2 ? 0.5 : 0);
        add_wooden_chair(shapes, &chair);
    }
}

static void furnish_lounge(struct shapes *shapes, const struct place *room, uint32_t *random)
{
    static const double seats[5][4] = {{0.65, -2.6, 0.25, 2.2},
                                       {4.35, -2.0, -0.25, 0.95},
                                       {4.35, -3.3, -0.25, 0.95},
                                       {2.5, -4.7, 0, 1.9},
                                       {2.0, -0.75, 0.5, 0.95}};
    for (int i = 0; i < 5; i++) {
        struct place seat = place_at(room, seats[i][0], 0, seats[i][1], seats[i][2]);
        add_armchair(shapes, &seat, seats[i][3], DETAIL);
    }
    shapes->material = CARPET;
    add_box(shapes, room, 1.2, 0, -4.0, 3.8, 0.012, -1.4);
    struct place table = place_at(room, 2.5, -0.3, -2.7, 0);
    add_oval_table(shapes, &table, 1.2, 0.8, DETAIL);
    for (int i = 0; i < 3; i++) {
        struct place plant = place_at(room, i == 1 ? 4.5 : 0.5, 0, i == 2 ? -1.0 : -5.0, 0);
        add_plant(shapes, &plant, 90, DETAIL, random);
    }
}

static void add_room(struct shapes *shapes, const struct place *place, uint32_t kind, uint32_t *random)
{
    static const struct opening to_corridor[2] = {{0.35, 0, 1.4, 2.15}, {1.9, 0.95, 4.6, 2.3}},
                                outside = {0.7, 0.9, 4.3, 2.5};
    static void (*const furnish[])(struct shapes *, const struct place *,
                                   uint32_t *) = {furnish_office, furnish_meeting, furnish_library, furnish_lounge};
    struct place far = place_at(place, 0, 0, -room_z, 0), side = place_at(place, 0, 0, 0, 0.25);
    shapes->material = WALL;
    add_wall(shapes, place, room_x, to_corridor, 2);
    add_wall(shapes, &far, room_x, &outside, 1);
    shapes->material = kind % 2 ? ACCENT : WALL;
    add_wall(shapes, &side, room_z, NULL, 0);
    shapes->material = WHITE;
    add_frame(shapes, place, &to_corridor[0], 1);
    add_frame(shapes, place, &to_corridor[1], 3);
    add_frame(shapes, &far, &outside, 3);
    add_door(shapes, place, &to_corridor[0], random_between(random, 0.04, 0.3));
    struct place radiator = place_at(&far, room_x / 2, 0, 0.16, 0), blind = place_at(&far, room_x / 2, 0, 0.1, 0);
    add_radiator(shapes, &radiator, 30, DETAIL);
    double drop = random_between(random, 0.3, 1.5);
    blind.y += 2.5 - drop;
    add_blind(shapes, &blind, 3.6, drop, (uint32_t)(drop * 30));
    furnish[kind](shapes, place, random);
}

/* ---- the house ----------------------------------------------------------------------------------------------- */

static void add_corridor(struct shapes *shapes, const struct place *floor, uint32_t *random)
{
    double length = ROOMS * room_x;
    shapes->material = CARPET;
    add_box(shapes, floor, 0.5, 0, -0.75, length - 0.5, 0.01, 0.75);
    for (int i = 0; i < ROOMS; i++) {
        struct place lamp = place_at(floor, (i + 0.5) * room_x, height, 0, 0);
        shapes->material = METAL;
        add_box(shapes, &lamp, -0.8, -0.06, -0.12, 0.8, 0, 0.12);
        shapes->material = LAMP;
        add_box(shapes, &lamp, -0.77, -0.065, -0.1, 0.77, -0.06, 0.1);
        struct place corner = place_at(floor, (i + 1) * room_x - 0.1, 0, i % 2 ? 1.05 : -1.05, 0);
        add_plant(shapes, &corner, 70, DETAIL, random);
        struct place seat = place_at(floor, (i + 1) * room_x - 0.1, 0, i % 2 ? -0.95 : 0.95, i % 2 ? 0 : 0.5);
        add_wooden_chair(shapes, &seat);
    }
}

// Two flights of stairs from this storey to the next, behind x = 0.
static void add_stairs(struct shapes *shapes, const struct place *floor)
{
    enum { STEPS = 10 };
    double rise = (height + slab) / (2 * STEPS);
    shapes->material = WOOD;
    for (int i = 0; i < STEPS; i++) {
        double x = -1.6 - 0.28 * i, back = -1.6 - 0.28 * (STEPS - 1 - i);
        add_box(shapes, floor, x - 0.3, rise * i, 0.1, x, rise * (i + 1), 1.35);
        add_box(shapes, floor, back - 0.3, rise * (STEPS + i), -1.35, back, rise * (STEPS + i + 1), -0.1);
    }
    add_box(shapes, floor, -5.7, rise * STEPS - 0.15, -1.35, -4.4, rise * STEPS, 1.35);
}

static void add_storey(struct shapes *shapes, uint32_t storey, uint32_t *random)
{
    static const struct opening gap = {0.3, 0, 2 * 1.4 - 0.3, 2.4};
    static const struct opening end_window = {0.4, 0.6, 2 * 1.4 - 0.4, 2.6};
    struct place world = world_place(), floor = place_at(&world, 0, storey * (height + slab), 0, 0);
    double length = ROOMS * room_x, depth = corridor + room_z;
    shapes->material = FLOOR_LIGHT;
    add_box(shapes, &floor, 0, -slab / 2, -depth, length, 0, depth);
    shapes->material = CEILING;
    add_box(shapes, &floor, 0, -slab, -depth, length, -slab / 2, depth);
    for (uint32_t i = 0; i < ROOMS; i++) {
        struct place north = place_at(&floor, i * room_x, 0, -corridor, 0);
        struct place south = place_at(&floor, (i + 1) * room_x, 0, corridor, 0.5);
        add_room(shapes, &north, (storey + i) % 4, random);
        add_room(shapes, &south, (storey + i * 3 + 1 + random_below(random, 2)) % 4, random);
    }
    shapes->material = WALL;
    struct place last = place_at(&floor, length, 0, 0, 0.25);
    struct place north = place_at(&last, corridor, 0, 0, 0), south = place_at(&last, -depth, 0, 0, 0);
    add_wall(shapes, &north, room_z, NULL, 0);
    add_wall(shapes, &south, room_z, NULL, 0);
    struct place end = place_at(&last, -corridor, 0, 0, 0), entry = place_at(&floor, 0, 0, corridor, 0.25);
    add_wall(shapes, &end, 2 * corridor, &end_window, 1);
    add_wall(shapes, &entry, 2 * corridor, &gap, 1);
    shapes->material = WHITE;
    add_frame(shapes, &end, &end_window, 3);
    add_corridor(shapes, &floor, random);
    add_stairs(shapes, &floor);
}

static void add_stairwell(struct shapes *shapes)
{
    struct place world = world_place();
    double top = STOREYS * (height + slab);
    shapes->material = ACCENT;
    add_box(shapes, &world, -6, 0, -1.6, -5.8, top, 1.6);
    add_box(shapes, &world, -6, 0, -1.6, 0, top, -1.4);
    add_box(shapes, &world, -6, 0, 1.4, 0, top, 1.6);
    shapes->material = FLOOR_DARK;
    add_box(shapes, &world, -6, -slab, -1.6, 0, 0, 1.6);
    shapes->material = CEILING;
    add_box(shapes, &world, -6, top - slab, -1.6, 0, top, 1.6);
    double depth = corridor + room_z;
    add_box(shapes, &world, 0, top - slab, -depth, ROOMS * room_x, top, depth);
}

void make_building(struct shapes *shapes)
{
    struct scene *scene = shapes->scene;
    uint32_t random = 11;
    set_materials(scene);
    for (uint32_t storey = 0; storey < STOREYS; storey++) add_storey(shapes, storey, &random);
    add_stairwell(shapes);

    double y = 2 * (height + slab);
    const struct view view = {{9.2, y + 1.65, 0.8}, {14.2, y + 1.3, -1.45}, {0, 1, 0}, 64, {13.2, y + 2.7, 0.2}};
    scene->view = view;
    scene->light_range = 5;
}
