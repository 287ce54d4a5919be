/* SPDX-License-Identifier: MIT */
/* shapes.c - boxes, turned and bent solids: see shapes.h. In double; a vertex is rounded to float when it is stored. */
#include "shapes.h"

#include "steady_math.h"

#include <math.h>
#include <stdlib.h>

struct place world_place(void)
{
    struct place place = {0, 0, 0, 1, 0};
    return place;
}

static void to_world(const struct place *place, const double p[3], double world[3])
{
    world[0] = place->x + place->cosine * p[0] + place->sine * p[2];
    world[1] = place->y + p[1];
    world[2] = place->z - place->sine * p[0] + place->cosine * p[2];
}

struct place place_at(const struct place *outer, double x, double y, double z, double turns)
{
    const double p[3] = {x, y, z};
    double world[3];
    to_world(outer, p, world);
    double c = turn_cos(turns), s = turn_sin(turns);
    struct place place = {world[0], world[1], world[2], outer->cosine * c - outer->sine * s,
                          outer->cosine * s + outer->sine * c};
    return place;
}

/* ---- storing ------------------------------------------------------------------------------------------------- */

// `data` made room for `capacity` elements; unchanged, with *failed set, if there is no memory.
static void *grown(void *data, size_t capacity, size_t element_size, int *failed)
{
    void *bigger = realloc(data, capacity * element_size);
    if (!bigger) *failed = 1;
    return bigger ? bigger : data;
}

static void reserve(struct shapes *shapes, size_t vertices, size_t triangles)
{
    struct scene *scene = shapes->scene;
    if (scene->vertex_count + vertices > shapes->vertex_capacity && !shapes->failed) {
        size_t capacity = 2 * shapes->vertex_capacity + vertices;
        scene->vertices = grown(scene->vertices, capacity, 3 * sizeof(float), &shapes->failed);
        shapes->vertex_capacity = capacity;
    }
    if (scene->triangle_count + triangles > shapes->triangle_capacity && !shapes->failed) {
        size_t capacity = 2 * shapes->triangle_capacity + triangles;
        scene->indices = grown(scene->indices, capacity, 3 * sizeof(uint32_t), &shapes->failed);
        scene->material_ids = grown(scene->material_ids, capacity, 1, &shapes->failed);
        shapes->triangle_capacity = capacity;
    }
}

static void store_vertex(struct shapes *shapes, const struct place *place, const double p[3])
{
    double world[3];
    to_world(place, p, world);
    float *vertex = shapes->scene->vertices + 3 * shapes->scene->vertex_count++;
    for (int k = 0; k < 3; k++) vertex[k] = (float)world[k];
}

static int same_position(const struct scene *scene, uint32_t i, uint32_t j)
{
    const float *a = scene->vertices + 3 * (size_t)i, *b = scene->vertices + 3 * (size_t)j;
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static void store_triangle(struct shapes *shapes, uint32_t i, uint32_t j, uint32_t k)
{
    struct scene *scene = shapes->scene;
    if (same_position(scene, i, j) || same_position(scene, j, k) || same_position(scene, k, i)) return;
    uint32_t *corner = scene->indices + 3 * scene->triangle_count;
    corner[0] = i, corner[1] = j, corner[2] = k;
    scene->material_ids[scene->triangle_count++] = shapes->material;
}

/* ---- flat ---------------------------------------------------------------------------------------------------- */

void add_quad(struct shapes *shapes, const struct place *place, const double corners[4][3])
{
    reserve(shapes, 4, 2);
    if (shapes->failed) return;
    uint32_t first = (uint32_t)shapes->scene->vertex_count;
    for (int i = 0; i < 4; i++) store_vertex(shapes, place, corners[i]);
    store_triangle(shapes, first, first + 1, first + 2);
    store_triangle(shapes, first, first + 2, first + 3);
}

void add_box(struct shapes *shapes, const struct place *place, double x0, double y0, double z0, double x1, double y1,
             double z1)
{
    static const uint8_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    reserve(shapes, 8, 12);
    if (shapes->failed) return;
    uint32_t first = (uint32_t)shapes->scene->vertex_count;
    for (int i = 0; i < 8; i++) {
        const double p[3] = {i & 1 ? x1 : x0, i & 2 ? y1 : y0, i & 4 ? z1 : z0};
        store_vertex(shapes, place, p);
    }
    for (int i = 0; i < 6; i++) {
        store_triangle(shapes, first + faces[i][0], first + faces[i][1], first + faces[i][2]);
        store_triangle(shapes, first + faces[i][0], first + faces[i][2], first + faces[i][3]);
    }
}

/* ---- curved -------------------------------------------------------------------------------------------------- */

void add_surface(struct shapes *shapes, const struct place *place, uint32_t columns, uint32_t rows, int closed,
                 surface_point point, const void *surface)
{
    uint32_t width = closed ? columns : columns + 1;
    reserve(shapes, (size_t)width * (rows + 1), 2 * (size_t)columns * rows);
    if (shapes->failed) return;
    uint32_t first = (uint32_t)shapes->scene->vertex_count;
    for (uint32_t j = 0; j <= rows; j++) {
        for (uint32_t i = 0; i < width; i++) {
            double p[3];
            point(surface, (double)i / columns, (double)j / rows, p);
            store_vertex(shapes, place, p);
        }
    }
    for (uint32_t j = 0; j < rows; j++) {
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t a = first + j * width + i, b = first + j * width + (i + 1) % width;
            store_triangle(shapes, a, b + width, b);
            store_triangle(shapes, a, a + width, b + width);
        }
    }
}

struct lathe {
    const double (*profile)[2];
    uint32_t count;
    uint32_t steps;
};

static double catmull_rom(double a, double b, double c, double d, double t)
{
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

static void lathe_point(const void *surface, double u, double v, double point[3])
{
    const struct lathe *lathe = surface;
    uint32_t last = lathe->count - 1;
    uint32_t step = (uint32_t)(v * (last * lathe->steps) + 0.5); // v is a multiple of 1 / (last * steps)
    uint32_t i = step / lathe->steps;
    double value[2];
    for (int k = 0; k < 2; k++) {
        double here = lathe->profile[i][k];
        if (step % lathe->steps == 0) {
            value[k] = here;
            continue;
        }
        double before = lathe->profile[i ? i - 1 : 0][k], next = lathe->profile[i + 1][k];
        double after = lathe->profile[i + 2 <= last ? i + 2 : last][k];
        value[k] = catmull_rom(before, here, next, after, (double)(step % lathe->steps) / lathe->steps);
    }
    point[0] = value[0] * turn_cos(u);
    point[1] = value[1];
    point[2] = value[0] * turn_sin(u);
}

void add_lathe(struct shapes *shapes, const struct place *place, const double (*profile)[2], uint32_t count,
               uint32_t steps, uint32_t segments)
{
    const struct lathe lathe = {profile, count, steps};
    add_surface(shapes, place, segments, (count - 1) * steps, 1, lathe_point, &lathe);
}

struct rod {
    const double (*curve)[3];
    double radius;
    uint32_t steps;
};

static void normalize(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] /= length;
}

static void cross(const double a[3], const double b[3], double result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

static void bezier(const double p[4][3], double t, double point[3], double tangent[3])
{
    double s = 1 - t;
    for (int k = 0; k < 3; k++) {
        point[k] = s * s * s * p[0][k] + 3 * s * s * t * p[1][k] + 3 * s * t * t * p[2][k] + t * t * t * p[3][k];
        tangent[k] = s * s * (p[1][k] - p[0][k]) + 2 * s * t * (p[2][k] - p[1][k]) + t * t * (p[3][k] - p[2][k]);
    }
}

// The first and the last row are the middles of the end discs, so the rod is closed.
static void rod_point(const void *surface, double u, double v, double point[3])
{
    const struct rod *rod = surface;
    double row = v * (rod->steps + 2), along = (row - 1) / rod->steps, radius = rod->radius;
    if (row < 0.5 || row > rod->steps + 1.5) radius = 0;
    if (along < 0) along = 0;
    if (along > 1) along = 1;
    double tangent[3], side[3], up[3];
    bezier(rod->curve, along, point, tangent);
    normalize(tangent);
    // A reference that is not along the rod anywhere: the axis that its chord has least of.
    double chord[3], reference[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++) chord[k] = fabs(rod->curve[3][k] - rod->curve[0][k]);
    int least = chord[0] <= chord[1] && chord[0] <= chord[2] ? 0 : chord[1] <= chord[2] ? 1 : 2;
    reference[least] = 1;
    cross(tangent, reference, side);
    normalize(side);
    cross(tangent, side, up);
    for (int k = 0; k < 3; k++) point[k] += radius * (turn_cos(u) * side[k] + turn_sin(u) * up[k]);
}

void add_rod(struct shapes *shapes, const struct place *place, const double curve[4][3], double radius, uint32_t steps,
             uint32_t segments)
{
    const struct rod rod = {curve, radius, steps};
    add_surface(shapes, place, segments, steps + 2, 1, rod_point, &rod);
}

// |x| to the power of 1, 1/2, 1/4 by repeated square roots, with the sign of x: the curve of a superellipse.
static double flattened(double x, int times)
{
    double y = fabs(x) < 1e-9 ? 0 : fabs(x);
    for (int i = 0; i < times; i++) y = sqrt(y);
    return x < 0 ? -y : y;
}

static void cushion_point(const void *surface, double u, double v, double point[3])
{
    const struct cushion *c = surface;
    double ring = v <= 0 || v >= 1 ? 0 : flattened(turn_cos(v / 2 - 0.25), c->rounding);
    double x = ring * flattened(turn_cos(u), c->rounding);
    double y = v <= 0 ? -1 : v >= 1 ? 1 : flattened(turn_sin(v / 2 - 0.25), c->rounding);
    double z = ring * flattened(turn_sin(u), c->rounding);
    point[0] = c->centre[0] + c->half[0] * x;
    point[1] = c->centre[1] + c->half[1] * y;
    point[2] = c->centre[2] + c->half[2] * z + c->bend * x * x + c->lean * y;
}

void add_cushion(struct shapes *shapes, const struct place *place, const struct cushion *cushion, uint32_t columns,
                 uint32_t rows)
{
    add_surface(shapes, place, columns, rows, 1, cushion_point, cushion);
}

static void leaf_point(const void *surface, double u, double v, double point[3])
{
    const struct leaf *leaf = surface;
    double across = 2 * u - 1, side[3], along[3];
    for (int k = 0; k < 3; k++) along[k] = leaf->tip[k] - leaf->root[k];
    side[0] = along[2], side[1] = 0, side[2] = -along[0];
    double length = sqrt(side[0] * side[0] + side[2] * side[2]);
    double half = leaf->width * 2 * v * (1 - v) * (1.35 - 0.7 * v) / (length > 0 ? length : 1);
    for (int k = 0; k < 3; k++) point[k] = leaf->root[k] + along[k] * v + side[k] * half * across;
    point[1] +=
        leaf->droop * 4 * v * (1 - v) - leaf->droop * v * v + 0.25 * leaf->width * fabs(across) * 4 * v * (1 - v);
}

void add_leaf(struct shapes *shapes, const struct place *place, const struct leaf *leaf, uint32_t steps)
{
    add_surface(shapes, place, 2, steps, 0, leaf_point, leaf);
}
