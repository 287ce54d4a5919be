/* SPDX-License-Identifier: MIT */
/* procedural.h - the procedural scenes: each fills an empty scene with triangles, materials, a view and a light */
#ifndef PROCEDURAL_H
#define PROCEDURAL_H

#include "shapes.h"

void make_room(struct shapes *shapes);
void make_office(struct shapes *shapes);
void make_building(struct shapes *shapes);
void make_doubled(struct shapes *shapes);

/* `triangle_count` is from 1,000 to 16 million; the scene has as many within one per cent. */
void make_scan(struct shapes *shapes, uint32_t triangle_count);

#endif
