/* SPDX-License-Identifier: MIT */
/*
 * furniture.h - the furniture of the procedural rooms
 *
 * Each piece stands on y = 0 of its place (a hanging lamp hangs from it) and faces +z. Lengths are in metres. `detail`
 * is the number of segments around a curved part, 6 to 48: the number of triangles grows with its square.
 */
#ifndef FURNITURE_H
#define FURNITURE_H

#include "shapes.h"

/* The materials of the procedural scenes: indices of scene.materials. */
enum {
    WALL,
    ACCENT,
    FLOOR_LIGHT,
    FLOOR_DARK,
    CEILING,
    WOOD,
    DARK_WOOD,
    METAL,
    BLACK,
    WHITE,
    FABRIC,
    FABRIC_2,
    LEAF,
    LEAF_2,
    TERRACOTTA,
    BRASS,
    LAMP,
    SCREEN,
    GLASS,
    PAPER,
    CARPET,
    SPINE /* the first of six colours of book spines; the last of all */
};

void set_materials(struct scene *scene);

void add_wooden_chair(struct shapes *shapes, const struct place *place);
void add_office_chair(struct shapes *shapes, const struct place *place, uint32_t detail);
void add_armchair(struct shapes *shapes, const struct place *place, double width, uint32_t detail);
void add_table(struct shapes *shapes, const struct place *place, double width, double depth);
void add_oval_table(struct shapes *shapes, const struct place *place, double width, double depth, uint32_t detail);
void add_desk(struct shapes *shapes, const struct place *place, uint32_t detail, uint32_t *random);
void add_shelf(struct shapes *shapes, const struct place *place, double width, double height, uint32_t boards,
               uint32_t books_per_board, uint32_t *random);
void add_plant(struct shapes *shapes, const struct place *place, uint32_t leaves, uint32_t detail, uint32_t *random);
void add_pendant(struct shapes *shapes, const struct place *place, double length, double radius, uint32_t detail);
void add_cup(struct shapes *shapes, const struct place *place, uint32_t detail);
void add_laptop(struct shapes *shapes, const struct place *place);
void add_blind(struct shapes *shapes, const struct place *place, double width, double height, uint32_t slats);
void add_radiator(struct shapes *shapes, const struct place *place, uint32_t ribs, uint32_t detail);
void add_picture(struct shapes *shapes, const struct place *place, double width, double height, uint8_t material);

#endif
