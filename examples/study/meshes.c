/* SPDX-License-Identifier: MIT */
/* meshes.c - spheres and sheets: see meshes.h */
#include "meshes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

// A rotation with nothing special about it. Its rows have length 1 and are perpendicular, to eight digits.
static const double turn[3][3] = {{0.57836534, -0.80044234, -0.15743440},
                                  {0.50125666, 0.50095506, -0.70553936},
                                  {0.64361114, 0.32914447, 0.69096210}};

static void rotate(const double p[3], double rotated[3])
{
    for (int k = 0; k < 3; k++) rotated[k] = turn[0][k] * p[0] + turn[1][k] * p[1] + turn[2][k] * p[2];
}

static int allocate_mesh(size_t vertex_count, size_t triangle_count, struct scene *scene)
{
    scene->vertices = malloc(3 * vertex_count * sizeof *scene->vertices);
    scene->indices = malloc(3 * triangle_count * sizeof *scene->indices);
    if (!scene->vertices || !scene->indices) {
        fprintf(stderr, "not enough memory for %zu triangles\n", triangle_count);
        return 1;
    }
    scene->vertex_count = vertex_count;
    scene->triangle_count = triangle_count;
    scene->view = (struct view){.eye = {0.1, 0.7, 3.1}, .up = {0, 1, 0}, .vfov = 40, .light = {2, 3, 3}};
    return 0;
}

/* ---- sphere -------------------------------------------------------------------------------------------------- */

/*
 * Each face of the icosahedron is a triangular grid of side + 1 points per side. Points on its border are shared with
 * the neighbours, so all points are made from the three corners by their weights, which are whole numbers: the same
 * point has the same weights of the same corners whichever face asks, and is found again in a table by them.
 */
static const int faces[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};

#define GOLDEN 1.6180339887498949

static const double corners[12][3] = {{-1, GOLDEN, 0}, {1, GOLDEN, 0}, {-1, -GOLDEN, 0}, {1, -GOLDEN, 0},
                                      {0, -1, GOLDEN}, {0, 1, GOLDEN}, {0, -1, -GOLDEN}, {0, 1, -GOLDEN},
                                      {GOLDEN, 0, -1}, {GOLDEN, 0, 1}, {-GOLDEN, 0, -1}, {-GOLDEN, 0, 1}};

struct sphere {
    struct scene *scene;
    uint32_t side; // pieces that each edge is cut into
    uint32_t corner_vertex[12];
    uint32_t edge_vertex[12][12]; // the first of the side - 1 points from the lower corner to the higher; 0 = none yet
    struct placement placement;
};

static uint32_t add_sphere_vertex(struct sphere *sphere, const int face[3], const uint32_t weights[3])
{
    double p[3], rotated[3], length = 0;
    for (int k = 0; k < 3; k++) {
        p[k] = 0;
        for (int i = 0; i < 3; i++) p[k] += weights[i] * corners[face[i]][k];
        length += p[k] * p[k];
    }
    for (int k = 0; k < 3; k++) p[k] /= sqrt(length);
    rotate(p, rotated);
    float *vertex = sphere->scene->vertices + 3 * sphere->scene->vertex_count;
    for (int k = 0; k < 3; k++) {
        vertex[k] = (float)(sphere->placement.scale * rotated[k] + sphere->placement.shift);
    }
    return (uint32_t)sphere->scene->vertex_count++;
}

// The number of a point on the edge between two corners, `step` pieces from `from`.
static uint32_t edge_vertex(struct sphere *sphere, int from, int to, uint32_t step)
{
    int low = from < to ? from : to, high = from < to ? to : from;
    uint32_t *first = &sphere->edge_vertex[low][high];
    if (*first == 0) {
        const int face[3] = {low, high, low};
        *first = (uint32_t)sphere->scene->vertex_count;
        for (uint32_t i = 1; i < sphere->side; i++) {
            const uint32_t weights[3] = {sphere->side - i, i, 0};
            add_sphere_vertex(sphere, face, weights);
        }
    }
    return *first + (from == low ? step : sphere->side - step) - 1;
}

// Numbers the points of a face: row i, from corner 0 towards the edge between 1 and 2, has i + 1 points.
static void number_face(struct sphere *sphere, const int face[3], uint32_t *numbers)
{
    uint32_t side = sphere->side;
    for (uint32_t row = 0; row <= side; row++) {
        for (uint32_t i = 0; i <= row; i++, numbers++) {
            const uint32_t weights[3] = {side - row, row - i, i};
            if (row == 0)
                *numbers = sphere->corner_vertex[face[0]];
            else if (row == side && (i == 0 || i == side))
                *numbers = sphere->corner_vertex[face[i == 0 ? 1 : 2]];
            else if (i == 0)
                *numbers = edge_vertex(sphere, face[0], face[1], row);
            else if (i == row)
                *numbers = edge_vertex(sphere, face[0], face[2], row);
            else if (row == side)
                *numbers = edge_vertex(sphere, face[1], face[2], i);
            else
                *numbers = add_sphere_vertex(sphere, face, weights);
        }
    }
}

static uint32_t *add_face_triangles(uint32_t side, const uint32_t *numbers, uint32_t *indices)
{
    for (uint32_t row = 0; row < side; row++) {
        const uint32_t *upper = numbers + row * (row + 1) / 2, *lower = upper + row + 1;
        for (uint32_t i = 0; i <= row; i++) {
            *indices++ = upper[i], *indices++ = lower[i], *indices++ = lower[i + 1];
            if (i < row) *indices++ = upper[i], *indices++ = lower[i + 1], *indices++ = upper[i + 1];
        }
    }
    return indices;
}

int make_sphere(uint32_t level, const struct placement *placement, struct scene *scene)
{
    uint32_t side = 1u << level, face_size = (side + 1) * (side + 2) / 2;
    struct sphere sphere = {.scene = scene, .side = side, .placement = {1, 0}};
    if (placement) sphere.placement = *placement;
    uint32_t *numbers = malloc(face_size * sizeof *numbers);
    if (!numbers || allocate_mesh(10 * (size_t)side * side + 2, 20 * (size_t)side * side, scene)) {
        free(numbers);
        return 1;
    }
    scene->vertex_count = 0;
    for (int i = 0; i < 12; i++) {
        const int face[3] = {i, i, i};
        const uint32_t weights[3] = {1, 0, 0};
        sphere.corner_vertex[i] = add_sphere_vertex(&sphere, face, weights);
    }
    uint32_t *indices = scene->indices;
    for (int i = 0; i < 20; i++) {
        number_face(&sphere, faces[i], numbers);
        indices = add_face_triangles(side, numbers, indices);
    }
    free(numbers);
    return 0;
}

/* ---- sheet --------------------------------------------------------------------------------------------------- */

int make_sheet(uint32_t columns, uint32_t rows, double width, double height, struct scene *scene, double normal[3],
               double axes[2][3])
{
    static const double unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (allocate_mesh((size_t)(columns + 1) * (rows + 1), 2 * (size_t)columns * rows, scene)) return 1;
    float *vertex = scene->vertices;
    for (uint32_t j = 0; j <= rows; j++) {
        for (uint32_t i = 0; i <= columns; i++, vertex += 3) {
            const double p[3] = {(i - 0.5 * columns) * width, (j - 0.5 * rows) * height, 0};
            double rotated[3];
            rotate(p, rotated);
            for (int k = 0; k < 3; k++) vertex[k] = (float)rotated[k];
        }
    }
    uint32_t *indices = scene->indices;
    for (uint32_t j = 0; j < rows; j++) {
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
            *indices++ = a, *indices++ = b, *indices++ = d;
            *indices++ = a, *indices++ = d, *indices++ = c;
        }
    }
    rotate(unit[0], axes[0]);
    rotate(unit[1], axes[1]);
    rotate(unit[2], normal);
    return 0;
}
