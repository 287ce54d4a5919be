/* SPDX-License-Identifier: MIT */
/*
 * room.c - the scene `room`: a closed room with a table, four chairs, a lamp and a shelf, about 800 triangles
 *
 * Like the test scenes of the 5th Eurographics Workshop on Rendering (1994), it has few, large triangles, many of them
 * in the planes of others.
 */
#include "furniture.h"
#include "procedural.h"

static void add_shell(struct shapes *shapes, const struct place *place)
{
    const double x = 3, z = 2.5, top = 2.7;
    const double back[4][3] = {{-x, 0, -z}, {x, 0, -z}, {x, top, -z}, {-x, top, -z}};
    const double front[4][3] = {{x, 0, z}, {-x, 0, z}, {-x, top, z}, {x, top, z}};
    const double left[4][3] = {{-x, 0, z}, {-x, 0, -z}, {-x, top, -z}, {-x, top, z}};
    const double right[4][3] = {{x, 0, -z}, {x, 0, z}, {x, top, z}, {x, top, -z}};
    const double ceiling[4][3] = {{-x, top, -z}, {x, top, -z}, {x, top, z}, {-x, top, z}};
    shapes->material = WALL;
    add_quad(shapes, place, front);
    add_quad(shapes, place, left);
    add_quad(shapes, place, right);
    shapes->material = ACCENT;
    add_quad(shapes, place, back);
    shapes->material = CEILING;
    add_quad(shapes, place, ceiling);
    enum { PLANKS = 20 };
    for (int i = 0; i < PLANKS; i++) {
        double near = z - 2 * z * i / PLANKS, far = z - 2 * z * (i + 1) / PLANKS;
        const double plank[4][3] = {{-x, 0, near}, {x, 0, near}, {x, 0, far}, {-x, 0, far}};
        shapes->material = i % 2 ? FLOOR_LIGHT : FLOOR_DARK;
        add_quad(shapes, place, plank);
    }
}

void make_room(struct shapes *shapes)
{
    struct scene *scene = shapes->scene;
    struct place world = world_place();
    uint32_t random = 5;
    set_materials(scene);
    add_shell(shapes, &world);

    shapes->material = CARPET;
    add_box(shapes, &world, -1.5, 0, -1.15, 1.5, 0.012, 1.15);
    add_table(shapes, &world, 1.7, 0.95);
    static const double seats[4][3] = {{-0.4, 0.72, 0.5}, {0.42, 0.78, 0.47}, {-0.42, -0.75, 0.02}, {1.2, -0.1, -0.2}};
    for (int i = 0; i < 4; i++) {
        struct place seat = place_at(&world, seats[i][0], 0.012, seats[i][1], seats[i][2]);
        add_wooden_chair(shapes, &seat);
    }
    struct place shelf = place_at(&world, -2.83, 0, -0.7, 0.25);
    add_shelf(shapes, &shelf, 1.25, 1.05, 2, 6, &random);
    struct place picture = place_at(&world, 0.6, 1.65, -2.5, 0);
    add_picture(shapes, &picture, 1.3, 0.85, SPINE + 2);
    struct place lamp = place_at(&world, 0, 2.7, 0, 0);
    add_pendant(shapes, &lamp, 0.85, 0.3, 8);
    static const double bowl[][2] = {{0, 0}, {0.07, 0}, {0.17, 0.09}};
    struct place centre = place_at(&world, 0.3, 0.74, 0.05, 0);
    shapes->material = TERRACOTTA;
    add_lathe(shapes, &centre, bowl, 3, 1, 8);

    const struct view view = {{2.65, 1.75, 2.2}, {-0.35, 0.82, -0.45}, {0, 1, 0}, 56, {0, 1.78, 0}};
    scene->view = view;
    scene->light_range = 2.6;
}
