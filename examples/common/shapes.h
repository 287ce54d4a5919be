/* SPDX-License-Identifier: MIT */
/*
 * shapes.h - boxes, turned and bent solids, added to a scene in the material and at the place that are set
 *
 * Every function appends triangles that share vertices within the shape. The functions return no errors: if an
 * allocation fails, `failed` is set, and later calls do nothing.
 */
#ifndef SHAPES_H
#define SHAPES_H

#include "scene.h"

struct shapes {
    struct scene *scene;
    size_t vertex_capacity;
    size_t triangle_capacity;
    int failed;
    uint8_t material;
};

/* A position, and a turn around the vertical (y) axis. */
struct place {
    double x, y, z;
    double cosine, sine;
};

/* The world's place, and a place within another: at x, y, z of it, turned by `turns`. */
struct place world_place(void);
struct place place_at(const struct place *outer, double x, double y, double z, double turns);

/* A box from one corner to the opposite one: 12 triangles. */
void add_box(struct shapes *shapes, const struct place *place, double x0, double y0, double z0, double x1, double y1,
             double z1);

/* A flat quadrilateral by its corners in order: 2 triangles. */
void add_quad(struct shapes *shapes, const struct place *place, const double corners[4][3]);

/*
 * A curved surface: columns x rows quadrilaterals. `point` gives the place at u, v in 0..1. With `closed`, u = 1 is u =
 * 0. Triangles that have shrunk to nothing (at a pole) are left out.
 */
typedef void (*surface_point)(const void *surface, double u, double v, double point[3]);
void add_surface(struct shapes *shapes, const struct place *place, uint32_t columns, uint32_t rows, int closed,
                 surface_point point, const void *surface);

/*
 * A turned solid around the vertical: `profile` lists radius and height from the bottom to the top, joined by straight
 * lines (steps = 1) or by a smooth curve in `steps` pieces each.
 */
void add_lathe(struct shapes *shapes, const struct place *place, const double (*profile)[2], uint32_t count,
               uint32_t steps, uint32_t segments);

/* A round rod with flat ends along the Bezier curve of four points, `radius` thick. */
void add_rod(struct shapes *shapes, const struct place *place, const double curve[4][3], double radius, uint32_t steps,
             uint32_t segments);

/*
 * A cushion: a box of half sizes `half` around `centre` with edges as round as `rounding` says (0 = an ellipsoid, 1 and
 * 2 = more and more of a box), whose sides at x = +-half are bent towards +z by `bend` and whose top leans by `lean`.
 */
struct cushion {
    double centre[3];
    double half[3];
    int rounding;
    double bend;
    double lean;
};
void add_cushion(struct shapes *shapes, const struct place *place, const struct cushion *cushion, uint32_t columns,
                 uint32_t rows);

/* A leaf: a pointed blade from `root` along a curve to `tip`, hanging by `droop`, `width` wide, slightly folded. */
struct leaf {
    double root[3];
    double tip[3];
    double droop;
    double width;
};
void add_leaf(struct shapes *shapes, const struct place *place, const struct leaf *leaf, uint32_t steps);

#endif
