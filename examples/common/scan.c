/* SPDX-License-Identifier: MIT */
/*
 * scan.c - the scene `scan`: one closed surface of many tiny triangles, like those of range scanners
 *
 * A scaly knot: a tube along the (2, 3) torus knot whose radius is displaced at four frequencies (swellings, scales,
 * grooves, grain). The grid wraps around in both directions, so every edge has exactly two triangles and a ray from
 * inside cannot miss.
 */
#include "furniture.h"
#include "procedural.h"
#include "steady_math.h"

#include <math.h>

static const double large_radius = 1.0, small_radius = 0.42, tube_radius = 0.235;
static const double length_to_girth = 9.0; // of the tube: makes the triangles about as long as they are wide

// The middle of the tube at s in turns, and the unit vectors across it: away from the torus, and along the torus.
static void knot_frame(double s, double middle[3], double outward[3], double sideways[3])
{
    double ca = turn_cos(2 * s), sa = turn_sin(2 * s), cb = turn_cos(3 * s), sb = turn_sin(3 * s);
    double ring = large_radius + small_radius * cb;
    const double tangent[3] = {-2 * ring * sa - 3 * small_radius * sb * ca, 2 * ring * ca - 3 * small_radius * sb * sa,
                               3 * small_radius * cb};
    double length = sqrt(tangent[0] * tangent[0] + tangent[1] * tangent[1] + tangent[2] * tangent[2]);
    middle[0] = ring * ca, middle[1] = ring * sa, middle[2] = small_radius * sb;
    outward[0] = cb * ca, outward[1] = cb * sa, outward[2] = sb;
    sideways[0] = (tangent[1] * outward[2] - tangent[2] * outward[1]) / length;
    sideways[1] = (tangent[2] * outward[0] - tangent[0] * outward[2]) / length;
    sideways[2] = (tangent[0] * outward[1] - tangent[1] * outward[0]) / length;
}

// Overlapping scales, as on a roof: a ramp along the body that falls off at its end, 0..1. Rows are staggered by half.
static double scales(double along, double around)
{
    double best = 0;
    for (int layer = 0; layer < 2; layer++) {
        double a = along + 0.5 * layer, b = around + 0.5 * layer;
        a -= floor(a);
        b -= floor(b) + 0.5;
        double edge = 0.86 - 2.4 * b * b; // where the scale ends: a rounded tip
        double ramp = a < edge ? a / 0.86 : 0;
        if (a >= edge && a < edge + 0.14) ramp = edge / 0.86 * (1 - (a - edge) / 0.14);
        double width = 1 - 4 * b * b; // thinner to its sides
        double height = ramp * (0.45 + 0.55 * width);
        if (height > best) best = height;
    }
    return best;
}

static void scan_point(const void *surface, double u, double v, double point[3])
{
    (void)surface;
    double middle[3], outward[3], sideways[3], direction[3];
    knot_frame(v, middle, outward, sideways);
    double c = turn_cos(u), s = turn_sin(u);
    for (int k = 0; k < 3; k++) direction[k] = outward[k] * c + sideways[k] * s;
    double radius = tube_radius * (1 + 0.13 * turn_sin(5 * v) + 0.05 * turn_sin(12 * v + 0.3));
    double p[3];
    for (int k = 0; k < 3; k++) p[k] = middle[k] + radius * direction[k];
    radius *= 1 + 0.07 * noise(3 * p[0], 3 * p[1], 3 * p[2]);
    radius *= 1 + 0.13 * scales(84 * v, 14 * u);
    radius *= 1 + 0.012 * noise(24 * p[0], 24 * p[1], 24 * p[2]) + 0.006 * noise(90 * p[0], 90 * p[1], 90 * p[2]);
    for (int k = 0; k < 3; k++) point[k] = middle[k] + radius * direction[k];
}

// Like a surface closed in u, but closed in v too: the last row is the first.
static void add_torus(struct shapes *shapes, uint32_t columns, uint32_t rows)
{
    struct place world = world_place();
    size_t first = shapes->scene->vertex_count;
    add_surface(shapes, &world, columns, rows, 1, scan_point, NULL);
    if (shapes->failed) return;
    struct scene *scene = shapes->scene;
    scene->vertex_count -= columns;
    for (size_t i = 0; i < 3 * scene->triangle_count; i++) {
        if (scene->indices[i] >= scene->vertex_count) scene->indices[i] -= (uint32_t)(scene->vertex_count - first);
    }
}

void make_scan(struct shapes *shapes, uint32_t triangle_count)
{
    struct scene *scene = shapes->scene;
    set_materials(scene);
    scene->materials[WALL] = (struct material){{0.42f, 0.55f, 0.46f}, 0};
    shapes->material = WALL;
    uint32_t columns = (uint32_t)(sqrt(triangle_count / (2 * length_to_girth)) + 0.5);
    uint32_t rows = (uint32_t)(triangle_count / (2.0 * columns) + 0.5);
    add_torus(shapes, columns, rows);

    const struct view view = {{0.85, -2.1, 3.9}, {0.09, -0.07, -0.05}, {0, 1, 0}, 42, {-2.6, 3.2, 4.6}};
    scene->view = view;
    scene->light_range = 0;
}
