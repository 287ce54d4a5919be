/* SPDX-License-Identifier: MIT */
/*
 * See support.h. Generators come first, then the table of all ways to trace, then the checks.
 */
#define _DEFAULT_SOURCE 1

#include "support.h"

#include "common/scene.h"
#include "job/structure.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* ONE_TEST=NAME: of a program's tests, this alone is run. */
__attribute__((constructor)) static void choose_test(void)
{
    const char *name = getenv("ONE_TEST");
    if (name) cmocka_set_test_filter(name);
}

size_t scaled(size_t count)
{
    return SANITIZED ? (count + 15) / 16 : count;
}

void *allocate_or_fail(size_t count, size_t size)
{
    void *block = calloc(count ? count : 1, size);
    assert_non_null(block);
    return block;
}

static void *grow(void *block, size_t *capacity, size_t needed, size_t size)
{
    if (needed <= *capacity) return block;
    *capacity = needed + needed / 2 + 16;
    block = realloc(block, *capacity * size);
    assert_non_null(block);
    return block;
}

/* ---- random numbers ---------------------------------------------------------------------------------------------- */

/* SplitMix64 (Sebastiano Vigna): every seed is good, 0 too. */
uint32_t draw_bits(struct random *random)
{
    uint64_t z = random->state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (uint32_t)((z ^ (z >> 31)) >> 32);
}

uint32_t draw_below(struct random *random, uint32_t limit)
{
    return (uint32_t)(((uint64_t)draw_bits(random) * limit) >> 32);
}

float draw_range(struct random *random, float lo, float hi)
{
    double unit = (double)(draw_bits(random) >> 8) / 16777216.0;
    return (float)((double)lo + ((double)hi - (double)lo) * unit);
}

float float_of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

uint32_t bits_of_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

float draw_finite(struct random *random)
{
    uint32_t bits = draw_bits(random);
    while ((bits & 0x7F800000u) == 0x7F800000u) bits = draw_bits(random);
    return float_of_bits(bits);
}

void draw_point(struct random *random, float lo, float hi, float point[3])
{
    for (int k = 0; k < 3; k++) point[k] = draw_range(random, lo, hi);
}

/* Floats in order are integers in order, if those with a sign bit count downwards. */
float next_float(float value, int steps)
{
    uint32_t bits = bits_of_float(value);
    int64_t rank = bits >> 31 ? -(int64_t)(bits & 0x7FFFFFFFu) : (int64_t)bits;
    rank += steps;
    return float_of_bits(rank < 0 ? (uint32_t)-rank | 0x80000000u : (uint32_t)rank);
}

/* ---- triangles --------------------------------------------------------------------------------------------------- */

void soup_add_triangle(struct soup *soup, const float a[3], const float b[3], const float c[3])
{
    soup->corners = grow(soup->corners, &soup->capacity, soup->count + 1, 9 * sizeof(float));
    float *corner = soup->corners + 9 * soup->count++;
    memcpy(corner, a, 3 * sizeof(float));
    memcpy(corner + 3, b, 3 * sizeof(float));
    memcpy(corner + 6, c, 3 * sizeof(float));
}

void soup_add_quad(struct soup *soup, const float corner[3], const float side[3], const float other_side[3])
{
    float b[3], c[3], d[3];
    for (int k = 0; k < 3; k++) {
        b[k] = corner[k] + side[k];
        c[k] = b[k] + other_side[k];
        d[k] = corner[k] + other_side[k];
    }
    soup_add_triangle(soup, corner, b, c);
    soup_add_triangle(soup, corner, c, d);
}

void soup_add_grid(struct soup *soup, int axis, float level, int cells)
{
    for (int row = 0; row < cells; row++) {
        for (int column = 0; column < cells; column++) {
            float corner[3] = {0}, side[3] = {0}, other_side[3] = {0};
            corner[axis] = level;
            corner[(axis + 1) % 3] = (float)column;
            corner[(axis + 2) % 3] = (float)row;
            side[(axis + 1) % 3] = 1;
            other_side[(axis + 2) % 3] = 1;
            soup_add_quad(soup, corner, side, other_side);
        }
    }
}

void soup_add_box(struct soup *soup, const float lo[3], const float hi[3])
{
    for (int axis = 0; axis < 3; axis++) {
        for (int end = 0; end < 2; end++) {
            int i = (axis + 1) % 3, j = (axis + 2) % 3;
            float p[4][3];
            for (int n = 0; n < 4; n++) {
                p[n][axis] = end ? hi[axis] : lo[axis];
                p[n][i] = (n == 1 || n == 2) ? hi[i] : lo[i];
                p[n][j] = n >= 2 ? hi[j] : lo[j];
            }
            soup_add_triangle(soup, p[0], p[end ? 1 : 2], p[end ? 2 : 1]);
            soup_add_triangle(soup, p[0], p[end ? 2 : 3], p[end ? 3 : 2]);
        }
    }
}

void soup_add_random(struct soup *soup, struct random *random, size_t count, float extent, float size)
{
    for (size_t i = 0; i < count; i++) {
        float centre[3], p[3][3];
        draw_point(random, -extent, extent, centre);
        for (int c = 0; c < 3; c++) {
            draw_point(random, -size, size, p[c]);
            for (int k = 0; k < 3; k++) p[c][k] += centre[k];
        }
        soup_add_triangle(soup, p[0], p[1], p[2]);
    }
}

/* Long, thin, in pairs that share the long edge. */
void soup_add_needles(struct soup *soup, struct random *random, size_t count, float aspect)
{
    for (size_t i = 0; i < count; i++) {
        float from[3], to[3], above[3], below[3];
        draw_point(random, -1, 1, from);
        draw_point(random, -1, 1, to);
        for (int k = 0; k < 3; k++) {
            above[k] = to[k] + draw_range(random, -1, 1) / aspect;
            below[k] = from[k] + draw_range(random, -1, 1) / aspect;
        }
        soup_add_triangle(soup, from, to, above);
        soup_add_triangle(soup, to, from, below);
    }
}

static void middle_on_sphere(const float a[3], const float b[3], float radius, float middle[3])
{
    // The sum is the same for both orders of a and b, so neighbours get the same vertex.
    double sum[3], length = 0;
    for (int k = 0; k < 3; k++) {
        sum[k] = (double)a[k] + (double)b[k];
        length += sum[k] * sum[k];
    }
    for (int k = 0; k < 3; k++) middle[k] = (float)(sum[k] * (double)radius / sqrt(length));
}

static void add_sphere_part(struct soup *soup, const float a[3], const float b[3], const float c[3], int subdivisions,
                            float radius)
{
    if (subdivisions == 0) {
        soup_add_triangle(soup, a, b, c);
        return;
    }
    float ab[3], bc[3], ca[3];
    middle_on_sphere(a, b, radius, ab);
    middle_on_sphere(b, c, radius, bc);
    middle_on_sphere(c, a, radius, ca);
    add_sphere_part(soup, a, ab, ca, subdivisions - 1, radius);
    add_sphere_part(soup, ab, b, bc, subdivisions - 1, radius);
    add_sphere_part(soup, ca, bc, c, subdivisions - 1, radius);
    add_sphere_part(soup, ab, bc, ca, subdivisions - 1, radius);
}

void soup_add_icosphere(struct soup *soup, int subdivisions, float radius)
{
    static const signed char corner[12][3] = {{-1, 2, 0}, {1, 2, 0}, {-1, -2, 0}, {1, -2, 0},
                                              {0, -1, 2}, {0, 1, 2}, {0, -1, -2}, {0, 1, -2},
                                              {2, 0, -1}, {2, 0, 1}, {-2, 0, -1}, {-2, 0, 1}};
    static const unsigned char face[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                              {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                              {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                              {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    float p[12][3];
    double golden = (1 + sqrt(5.0)) / 2, length = sqrt(1 + golden * golden);
    for (int i = 0; i < 12; i++) {
        for (int k = 0; k < 3; k++) {
            int c = corner[i][k];
            double x = c == 2 ? golden : c == -2 ? -golden : (double)c;
            p[i][k] = (float)(x * (double)radius / length);
        }
    }
    for (int f = 0; f < 20; f++)
        add_sphere_part(soup, p[face[f][0]], p[face[f][1]], p[face[f][2]], subdivisions, radius);
}

static void torus_point(int i, int around, int j, int across, float radius, float tube, float point[3])
{
    double pi = 3.14159265358979323846;
    double a = 2 * pi * (i % around) / around, b = 2 * pi * (j % across) / across;
    double out = (double)radius + (double)tube * cos(b);
    point[0] = (float)(out * cos(a));
    point[1] = (float)(out * sin(a));
    point[2] = (float)((double)tube * sin(b));
}

void soup_add_torus(struct soup *soup, int around, int across, float radius, float tube)
{
    for (int i = 0; i < around; i++) {
        for (int j = 0; j < across; j++) {
            float p[4][3];
            for (int n = 0; n < 4; n++)
                torus_point(i + (n == 1 || n == 2), around, j + (n >= 2), across, radius, tube, p[n]);
            soup_add_triangle(soup, p[0], p[1], p[2]);
            soup_add_triangle(soup, p[0], p[2], p[3]);
        }
    }
}

void move_soup(struct soup *soup, float scale, const float offset[3])
{
    for (size_t i = 0; i < 9 * soup->count; i++)
        soup->corners[i] = (float)((double)soup->corners[i] * (double)scale + (double)offset[i % 3]);
}

void swap_axes(struct soup *soup, int turns)
{
    for (size_t i = 0; i < 3 * soup->count; i++) {
        float *p = soup->corners + 3 * i, old[3] = {p[0], p[1], p[2]};
        for (int k = 0; k < 3; k++) p[(k + turns) % 3] = old[k];
    }
}

void free_soup(struct soup *soup)
{
    free(soup->corners);
    memset(soup, 0, sizeof *soup);
}

mlrt_mesh soup_mesh(const struct soup *soup)
{
    mlrt_mesh mesh = {.struct_size = sizeof mesh,
                      .vertices = soup->corners,
                      .vertex_count = 3 * soup->count,
                      .triangle_count = soup->count};
    return mesh;
}

/* ---- fixtures ---------------------------------------------------------------------------------------------------- */

static uint32_t read_index(const mlrt_mesh *mesh, size_t triangle, int corner)
{
    size_t size = mesh->index_size ? mesh->index_size : 4;
    size_t stride = mesh->triangle_stride ? mesh->triangle_stride : 3 * size;
    const unsigned char *at = (const unsigned char *)mesh->indices + triangle * stride + (size_t)corner * size;
    uint16_t narrow;
    uint32_t wide;
    if (size == 2) {
        memcpy(&narrow, at, 2);
        return narrow;
    }
    memcpy(&wide, at, 4);
    return wide;
}

static void read_triangle(const mlrt_mesh *mesh, size_t triangle, struct reference_triangle *out)
{
    size_t stride = mesh->vertex_stride ? mesh->vertex_stride : 12;
    for (int c = 0; c < 3; c++) {
        size_t vertex = mesh->indices ? read_index(mesh, triangle, c) : 3 * triangle + (size_t)c;
        memcpy(out->corner[c], (const unsigned char *)mesh->vertices + vertex * stride, 12);
    }
}

static struct reference_scene *reference_of_meshes(const mlrt_mesh *meshes, size_t count)
{
    size_t total = 0, position = 0;
    int has_ids = 0;
    for (size_t m = 0; m < count; m++) {
        total += meshes[m].triangle_count;
        has_ids |= meshes[m].id != 0;
    }
    struct reference_triangle *triangles = allocate_or_fail(total, sizeof *triangles);
    for (size_t m = 0; m < count; m++) {
        for (size_t i = 0; i < meshes[m].triangle_count; i++, position++) {
            read_triangle(&meshes[m], i, &triangles[position]);
            triangles[position].mesh = has_ids ? meshes[m].id : (uint32_t)m;
            triangles[position].triangle = (uint32_t)i;
        }
    }
    struct reference_scene *scene = reference_create(triangles, total);
    free(triangles);
    return scene;
}

mlrt_tree *build_structure(const mlrt_mesh *meshes, size_t count, uint32_t structure)
{
    const mlrt_kdtree_options tuned = {.struct_size = sizeof tuned, .preset = MLRT_KDTREE_TUNED};
    mlrt_tree *tree = NULL;
    assert_int_equal(structure == MLRT_STRUCTURE_KDTREE ? mlrt_build_kdtree(meshes, count, &tuned, &tree)
                                                        : mlrt_build_tree(meshes, count, NULL, &tree),
                     MLRT_OK);
    return tree;
}

static void assert_built(const struct fixture *fixture, int32_t status)
{
    if (status != MLRT_OK)
        print_error("%s (seed %llu): %s\n", fixture->name, (unsigned long long)fixture->seed,
                    mlrt_status_string(status));
    assert_int_equal(status, MLRT_OK);
}

struct fixture make_fixture_with(const char *name, uint64_t seed, const mlrt_mesh *meshes, size_t count,
                                 const mlrt_kdtree_options *options)
{
    struct fixture fixture = {name, seed, NULL, NULL, NULL};
    const mlrt_tree_options boxes = {.struct_size = sizeof boxes,
                                     .traversal_cost = options->traversal_cost,
                                     .intersection_cost = options->intersection_cost};
    assert_built(&fixture, mlrt_build_tree(meshes, count, &boxes, &fixture.tree));
    assert_built(&fixture, mlrt_build_kdtree(meshes, count, options, &fixture.kdtree));
    fixture.reference = reference_of_meshes(meshes, count);
    return fixture;
}

struct fixture make_fixture(const char *name, uint64_t seed, const mlrt_mesh *meshes, size_t count)
{
    const mlrt_kdtree_options tuned = {.struct_size = sizeof tuned, .preset = MLRT_KDTREE_TUNED};
    return make_fixture_with(name, seed, meshes, count, &tuned);
}

struct fixture fixture_of_soup(const char *name, uint64_t seed, struct soup *soup)
{
    mlrt_mesh mesh = soup_mesh(soup);
    struct fixture fixture = make_fixture(name, seed, &mesh, 1);
    free_soup(soup);
    return fixture;
}

struct fixture fixture_of_example(const char *scene_name)
{
    struct scene scene;
    assert_int_equal(load_scene(scene_name, &scene), 0);
    mlrt_mesh mesh = {.struct_size = sizeof mesh,
                      .vertices = scene.vertices,
                      .vertex_count = scene.vertex_count,
                      .indices = scene.indices,
                      .triangle_count = scene.triangle_count};
    struct fixture fixture = make_fixture(scene_name, 0, &mesh, 1);
    free_scene(&scene);
    return fixture;
}

void free_fixture(struct fixture *fixture)
{
    mlrt_destroy_tree(fixture->tree);
    mlrt_destroy_tree(fixture->kdtree);
    reference_destroy(fixture->reference);
    memset(fixture, 0, sizeof *fixture);
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

struct reference_ray *add_ray(struct ray_list *list, const float origin[3], const float direction[3])
{
    list->rays = grow(list->rays, &list->capacity, list->count + 1, sizeof *list->rays);
    struct reference_ray *ray = &list->rays[list->count++];
    memcpy(ray->origin, origin, sizeof ray->origin);
    memcpy(ray->direction, direction, sizeof ray->direction);
    ray->t_min = 0;
    ray->t_max = INFINITY;
    ray->skip[0] = MLRT_NONE;
    ray->skip[1] = MLRT_NONE;
    return ray;
}

struct reference_ray *add_ray_towards(struct ray_list *list, const float origin[3], const float target[3])
{
    float direction[3];
    reference_difference(target, origin, direction);
    return add_ray(list, origin, direction);
}

static const struct reference_triangle *random_triangle(struct random *random, const struct fixture *fixture)
{
    size_t count = reference_triangle_count(fixture->reference);
    return count ? reference_triangle_at(fixture->reference, draw_below(random, (uint32_t)count)) : NULL;
}

/* A vertex, a point near an edge (on it as far as floats go), or one inside. */
static void point_of_triangle(struct random *random, const struct reference_triangle *triangle, float point[3])
{
    int kind = (int)draw_below(random, 3);
    float u = draw_range(random, 0, 1), v = draw_range(random, 0, 1 - u);
    int first = (int)draw_below(random, 3);
    const float *a = triangle->corner[first];
    const float *b = triangle->corner[(first + 1) % 3], *c = triangle->corner[(first + 2) % 3];
    if (kind < 2) v = 0;
    if (kind < 1) u = 0;
    for (int k = 0; k < 3; k++) {
        double sum = (double)a[k] * (1.0 - (double)u - (double)v) + (double)b[k] * (double)u + (double)c[k] * (double)v;
        point[k] = kind == 0 ? a[k] : (float)sum;
    }
}

void add_aimed_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t count, float lo,
                    float hi)
{
    for (size_t i = 0; i < count; i++) {
        const struct reference_triangle *triangle = random_triangle(random, fixture);
        float origin[3], target[3] = {0, 0, 0};
        draw_point(random, lo, hi, origin);
        if (triangle) point_of_triangle(random, triangle, target);
        add_ray_towards(list, origin, target);
    }
}

void add_random_rays(struct ray_list *list, struct random *random, size_t count, float lo, float hi)
{
    for (size_t i = 0; i < count; i++) {
        float origin[3], direction[3];
        draw_point(random, lo, hi, origin);
        draw_point(random, -1, 1, direction);
        add_ray(list, origin, direction);
    }
}

void add_axis_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct reference_triangle *triangle = random_triangle(random, fixture);
        float origin[3] = {0, 0, 0}, direction[3];
        int axis = (int)draw_below(random, 3), back = (int)draw_below(random, 2);
        if (triangle) memcpy(origin, triangle->corner[draw_below(random, 3)], sizeof origin);
        for (int k = 0; k < 3; k++) direction[k] = draw_below(random, 2) ? 0.0f : -0.0f;
        direction[axis] = back ? -1.0f : 1.0f;
        if (draw_below(random, 4) == 0) direction[(axis + 1) % 3] = 1;
        if (draw_below(random, 2)) origin[axis] -= 8 * direction[axis];
        if (draw_below(random, 4) == 0) origin[(axis + 1) % 3] += draw_range(random, -1, 1);
        add_ray(list, origin, direction);
    }
}

void add_surface_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct reference_triangle *triangle = random_triangle(random, fixture);
        float origin[3] = {0, 0, 0}, direction[3];
        draw_point(random, -1, 1, direction);
        if (triangle) {
            point_of_triangle(random, triangle, origin);
            uint32_t from = draw_below(random, 3);
            if (draw_below(random, 3) == 0)
                reference_difference(triangle->corner[(from + 1) % 3], triangle->corner[from], direction);
        }
        add_ray(list, origin, direction);
    }
}

/* Gives some of the rays a t range near the hit that they would have, or lets them pass its triangle. */
static void restrict_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t first)
{
    for (size_t i = first; i < list->count; i++) {
        struct reference_ray *ray = &list->rays[i];
        struct reference_hit hit;
        reference_trace(fixture->reference, ray, &hit);
        switch (draw_below(random, 6)) {
        case 0:
            ray->t_max = hit.t;
            break;
        case 1:
            ray->t_min = isinf(hit.t) ? 0 : hit.t;
            break;
        case 2:
            ray->t_max = isinf(hit.t) ? 1 : next_float(hit.t, -1);
            break;
        case 3:
            ray->t_min = isinf(hit.t) ? 0 : next_float(hit.t, -1);
            break;
        case 4:
            ray->skip[0] = hit.mesh;
            ray->skip[1] = hit.triangle;
            break;
        default:
            ray->t_min = -draw_range(random, 0, 1);
            break;
        }
    }
}

void add_mixed_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t count, float lo,
                    float hi)
{
    size_t part = count / 6;
    add_aimed_rays(list, random, fixture, 2 * part, lo, hi);
    add_random_rays(list, random, part, lo, hi);
    add_axis_rays(list, random, fixture, part);
    add_surface_rays(list, random, fixture, part);
    size_t first = list->count;
    add_aimed_rays(list, random, fixture, part, lo, hi);
    restrict_rays(list, random, fixture, first);
}

void free_rays(struct ray_list *list)
{
    free(list->rays);
    memset(list, 0, sizeof *list);
}

mlrt_rays public_rays(const struct ray_list *list)
{
    const struct reference_ray *first = list->rays;
    size_t stride = sizeof *first;
    mlrt_rays rays = {.struct_size = sizeof rays, .row_length = list->row_length, .count = list->count};
    if (list->count == 0) return rays;
    rays.origins = (mlrt_const_array){first->origin, stride};
    rays.directions = (mlrt_const_array){first->direction, stride};
    rays.t_min = (mlrt_const_array){&first->t_min, stride};
    rays.t_max = (mlrt_const_array){&first->t_max, stride};
    rays.skip = (mlrt_const_array){first->skip, stride};
    return rays;
}

/* ---- cameras ----------------------------------------------------------------------------------------------------- */

static void normalize(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] /= length;
}

static void cross_product(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* right and down for a view along `forward`, all of length 1; forward is normalized too. */
static void make_frame(double forward[3], double right[3], double down[3])
{
    normalize(forward);
    double up[3] = {0, 0, 1};
    if (fabs(forward[2]) > 0.9) {
        up[1] = 1;
        up[2] = 0;
    }
    cross_product(forward, up, right);
    normalize(right);
    cross_product(forward, right, down);
}

static mlrt_camera picture(int32_t projection, uint32_t width, uint32_t height, const double middle[3],
                           const double right[3], const double down[3], double pixel)
{
    mlrt_camera camera = {.struct_size = sizeof camera, .projection = projection, .width = width, .height = height};
    camera.sample_x = 0.5f;
    camera.sample_y = 0.5f;
    for (int k = 0; k < 3; k++) {
        camera.dx[k] = (float)(right[k] * pixel);
        camera.dy[k] = (float)(down[k] * pixel);
        camera.d00[k] = (float)(middle[k] - pixel * (right[k] * width + down[k] * height) / 2);
    }
    return camera;
}

mlrt_camera look_at(const float eye[3], const float target[3], float field, uint32_t width, uint32_t height)
{
    double forward[3], right[3], down[3];
    for (int k = 0; k < 3; k++) forward[k] = (double)target[k] - (double)eye[k];
    make_frame(forward, right, down);
    mlrt_camera camera = picture(MLRT_PROJECTION_PINHOLE, width, height, forward, right, down, (double)field / width);
    memcpy(camera.eye, eye, sizeof camera.eye);
    return camera;
}

mlrt_camera look_along(const float centre[3], const float direction[3], float extent, uint32_t width, uint32_t height)
{
    double forward[3], right[3], down[3], middle[3];
    for (int k = 0; k < 3; k++) {
        forward[k] = (double)direction[k];
        middle[k] = (double)centre[k];
    }
    make_frame(forward, right, down);
    mlrt_camera camera = picture(MLRT_PROJECTION_PARALLEL, width, height, middle, right, down, (double)extent / width);
    memcpy(camera.direction, direction, sizeof camera.direction);
    return camera;
}

void camera_crop(const mlrt_camera *camera, uint32_t *width, uint32_t *height)
{
    *width = camera->crop_width ? camera->crop_width : camera->width - camera->crop_x;
    *height = camera->crop_height ? camera->crop_height : camera->height - camera->crop_y;
}

void add_camera_rays(struct ray_list *list, const mlrt_camera *camera)
{
    uint32_t width, height;
    camera_crop(camera, &width, &height);
    for (uint32_t j = 0; j < height; j++) {
        for (uint32_t i = 0; i < width; i++) {
            float p[3];
            reference_pixel_vector(camera->d00, camera->dx, camera->dy, camera->crop_x + i, camera->crop_y + j,
                                   camera->sample_x, camera->sample_y, p);
            int pinhole = camera->projection == MLRT_PROJECTION_PINHOLE;
            struct reference_ray *ray = add_ray(list, pinhole ? camera->eye : p, pinhole ? p : camera->direction);
            ray->t_min = camera->t_min;
            ray->t_max = camera->t_max != 0 ? camera->t_max : INFINITY;
        }
    }
    list->row_length = width;
}

/* ---- ways of tracing --------------------------------------------------------------------------------------------- */

#define VARIANT_LIMIT 96

static struct variant variants[VARIANT_LIMIT];
static size_t variants_used;

int32_t narrowest_isa(void)
{
    return MLRT_ISA_NARROWEST;
}

int isa_is_supported(int32_t isa)
{
    mlrt_tree *tree = NULL;
    mlrt_ray ray = {.struct_size = sizeof ray, .direction = {0, 0, 1}};
    mlrt_hit hit = {.struct_size = sizeof hit};
    mlrt_trace_options options = {.struct_size = sizeof options, .isa = isa};
    assert_int_equal(mlrt_build_tree(NULL, 0, NULL, &tree), MLRT_OK);
    int32_t status = mlrt_trace_ray(tree, &ray, &options, &hit);
    mlrt_destroy_tree(tree);
    assert_true(status == MLRT_OK || status == MLRT_ERROR_UNSUPPORTED);
    return status == MLRT_OK;
}

struct tiling {
    uint32_t initial;
    uint32_t minimum;
    uint32_t factor;
};

int is_kdtree_method(int32_t method)
{
    return method >= MLRT_METHOD_PACKET2 && method <= MLRT_METHOD_MULTILEVEL;
}

static struct variant *add_variant(int32_t method, int32_t isa, struct tiling tiling, int probe)
{
    static const uint32_t threads[] = {0, 2, 0, 3, 1, 0, 8};
    assert_true(variants_used < VARIANT_LIMIT);
    struct variant *variant = &variants[variants_used];
    variant->options = (mlrt_trace_options){.struct_size = sizeof variant->options,
                                            .method = method,
                                            .isa = isa,
                                            .initial_tile_size = tiling.initial,
                                            .minimum_tile_size = tiling.minimum,
                                            .split_factor = tiling.factor};
    variant->threads = threads[variants_used % (sizeof threads / sizeof threads[0])];
    variant->probe = probe;
    variant->on_kdtree = is_kdtree_method(method);
    variants_used++;
    return variant;
}

static void list_variants_of(int32_t isa)
{
    static const struct tiling whole = {0, 0, 0};
    static const struct tiling tilings[] = {{4, 4, 4},   {8, 4, 4},    {16, 4, 16},
                                            {32, 32, 4}, {128, 8, 16}, {1024, 4, 16}};
    static const struct tiling fine = {64, 4, 4};
    add_variant(MLRT_METHOD_RAY, isa, whole, 0);
    add_variant(MLRT_METHOD_RAY, isa, whole, 0)->on_kdtree = 1;
    add_variant(MLRT_METHOD_TILE, isa, whole, 1);
    add_variant(MLRT_METHOD_DEFAULT, isa, whole, 0)->on_kdtree = 1;
    add_variant(MLRT_METHOD_PACKET2, isa, whole, 1);
    add_variant(MLRT_METHOD_PACKET4, isa, whole, 1);
    for (int32_t switches = 0; switches < 8; switches++) {
        struct variant *variant =
            add_variant(MLRT_METHOD_MULTILEVEL, isa, switches & 1 ? fine : whole, switches == 0 || switches == 7);
        variant->options.culling = switches & 1 ? MLRT_CULLING_DIRECT : MLRT_CULLING_INVERSE;
        variant->options.culling_check = switches >> 1 & 1;
        variant->options.shortcuts_off = switches & 4 ? 7u : 0;
    }
    for (size_t i = 0; i < sizeof tilings / sizeof tilings[0]; i++)
        add_variant(MLRT_METHOD_MULTILEVEL, isa, tilings[i], 0);
}

static void list_variants(void)
{
    struct tiling whole = {0, 0, 0};
    add_variant(MLRT_METHOD_DEFAULT, MLRT_ISA_AUTO, whole, 1);
    add_variant(MLRT_METHOD_DEFAULT, MLRT_ISA_AUTO, whole, 1)->on_kdtree = 1;
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
        if (isa_is_supported(isa)) list_variants_of(isa);
    }
}

size_t variant_count(void)
{
    if (variants_used == 0) list_variants();
    return variants_used;
}

size_t variant_step(void)
{
    return SANITIZED ? 5 : 1;
}

size_t first_variant(void)
{
    static size_t call_count;
    return call_count++ % variant_step();
}

const struct variant *variant_at(size_t index)
{
    assert_true(index < variant_count());
    return &variants[index];
}

const mlrt_tree *method_tree(int32_t method, const struct fixture *fixture)
{
    return is_kdtree_method(method) ? fixture->kdtree : fixture->tree;
}

const mlrt_tree *variant_tree(const struct variant *variant, const struct fixture *fixture)
{
    return variant->on_kdtree ? fixture->kdtree : fixture->tree;
}

#define POOL_LIMIT 8

static struct {
    uint32_t threads;
    mlrt_pool *pool;
} pools[POOL_LIMIT];

static void destroy_pools(void)
{
    for (int i = 0; i < POOL_LIMIT; i++) mlrt_destroy_pool(pools[i].pool);
}

mlrt_pool *shared_pool(uint32_t threads)
{
    if (threads == 0) return NULL;
    int i = 0;
    while (i < POOL_LIMIT && pools[i].pool && pools[i].threads != threads) i++;
    assert_true(i < POOL_LIMIT);
    if (!pools[i].pool) {
        if (i == 0) atexit(destroy_pools);
        assert_int_equal(mlrt_create_pool(threads, &pools[i].pool), MLRT_OK);
        pools[i].threads = threads;
    }
    return pools[i].pool;
}

void describe(const char *call, const mlrt_trace_options *o, uint32_t threads, char *text, size_t size)
{
    static const char *const methods[] = {"default", "ray", "packet2", "packet4", "multilevel", "tile"};
    static const char *const isas[] = {"auto", "scalar", "sse", "avx2", "avx512", "neon"};
    snprintf(text, size, "%s, method %s, isa %s, culling %s%s, tiles %u/%u/%u, %u threads", call, methods[o->method],
             isas[o->isa], o->culling ? "direct" : "inverse", o->culling_check ? " with check" : "",
             (unsigned)o->initial_tile_size, (unsigned)o->minimum_tile_size, (unsigned)o->split_factor,
             (unsigned)threads);
}

/* ---- comparison -------------------------------------------------------------------------------------------------- */

static void print_triangle(const struct fixture *fixture, const char *label, uint32_t mesh, uint32_t triangle)
{
    const struct reference_triangle *found = reference_find(fixture->reference, mesh, triangle);
    if (!found) return;
    print_error("  %s triangle (%u, %u):", label, (unsigned)mesh, (unsigned)triangle);
    for (int i = 0; i < 3; i++)
        print_error(" (%a, %a, %a)", (double)found->corner[i][0], (double)found->corner[i][1],
                    (double)found->corner[i][2]);
    print_error("\n");
}

static void print_hit(const char *label, const struct reference_hit *hit)
{
    print_error("  %s t = %a, u = %a, v = %a, mesh %u, triangle %u, facing %d\n", label, (double)hit->t, (double)hit->u,
                (double)hit->v, (unsigned)hit->mesh, (unsigned)hit->triangle, (int)hit->facing);
}

static void print_ray(const struct fixture *fixture, const char *what, size_t index, const struct reference_ray *ray)
{
    print_error("%s, seed %llu: %s\n  ray %zu: o = (%a, %a, %a), d = (%a, %a, %a), t in (%a, %a], skip %u, %u\n",
                fixture->name, (unsigned long long)fixture->seed, what, index, (double)ray->origin[0],
                (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0], (double)ray->direction[1],
                (double)ray->direction[2], (double)ray->t_min, (double)ray->t_max, (unsigned)ray->skip[0],
                (unsigned)ray->skip[1]);
}

int same_hit(const struct reference_hit *a, const struct reference_hit *b)
{
    return bits_of_float(a->t) == bits_of_float(b->t) && bits_of_float(a->u) == bits_of_float(b->u) &&
           bits_of_float(a->v) == bits_of_float(b->v) && a->mesh == b->mesh && a->triangle == b->triangle &&
           a->facing == b->facing;
}

void print_difference(const struct fixture *fixture, const char *what, size_t index, const struct reference_ray *ray,
                      const struct reference_hit *expected, const struct reference_hit *got)
{
    print_ray(fixture, what, index, ray);
    print_hit("expected", expected);
    print_hit("got     ", got);
    print_triangle(fixture, "expected", expected->mesh, expected->triangle);
    print_triangle(fixture, "got", got->mesh, got->triangle);
}

void check_hit(const struct fixture *fixture, const char *what, size_t index, const struct reference_ray *ray,
               const struct reference_hit *expected, const struct reference_hit *got)
{
    if (same_hit(expected, got)) return;
    print_difference(fixture, what, index, ray, expected, got);
    fail();
}

static void check_occluded(const struct fixture *fixture, const char *what, size_t index,
                           const struct reference_ray *ray, const struct reference_hit *expected, uint8_t got)
{
    if (got == (expected->mesh != MLRT_NONE)) return;
    print_ray(fixture, what, index, ray);
    print_error("  occluded %u\n", (unsigned)got);
    print_hit("expected", expected);
    print_triangle(fixture, "expected", expected->mesh, expected->triangle);
    fail();
}

void trace_reference(const struct fixture *fixture, const struct ray_list *list, struct reference_hit *hits)
{
    for (size_t i = 0; i < list->count; i++) reference_trace(fixture->reference, &list->rays[i], &hits[i]);
}

mlrt_hits public_hits(struct reference_hit *hits, size_t row)
{
    size_t stride = sizeof *hits, rows = row * stride;
    mlrt_hits out = {.struct_size = sizeof out,
                     .t = {&hits->t, stride, rows},
                     .u = {&hits->u, stride, rows},
                     .v = {&hits->v, stride, rows},
                     .mesh = {&hits->mesh, stride, rows},
                     .triangle = {&hits->triangle, stride, rows},
                     .facing = {&hits->facing, stride, rows}};
    return out;
}

mlrt_hit_lists public_lists(struct list_element *elements, struct list_totals *totals, uint32_t capacity)
{
    const size_t stride = sizeof *elements;
    mlrt_hit_lists lists = {.struct_size = sizeof lists,
                            .capacity = capacity,
                            .total = {&totals->total, sizeof *totals, 0},
                            .crossing_total = {&totals->crossing_total, sizeof *totals, 0}};
    if (capacity == 0) return lists;
    lists.t = (mlrt_array){&elements->hit.t, stride, 0};
    lists.u = (mlrt_array){&elements->hit.u, stride, 0};
    lists.v = (mlrt_array){&elements->hit.v, stride, 0};
    lists.mesh = (mlrt_array){&elements->hit.mesh, stride, 0};
    lists.triangle = (mlrt_array){&elements->hit.triangle, stride, 0};
    lists.facing = (mlrt_array){&elements->hit.facing, stride, 0};
    lists.crossing = (mlrt_array){&elements->crossing, stride, 0};
    return lists;
}

/* ---- single rays and packets ------------------------------------------------------------------------------------- */

struct reference_hit trace_one(const mlrt_tree *tree, const struct reference_ray *ray,
                               const mlrt_trace_options *options)
{
    mlrt_ray single = {.struct_size = sizeof single, .flags = MLRT_RAY_SKIP, .t_min = ray->t_min, .t_max = ray->t_max};
    memcpy(single.origin, ray->origin, sizeof single.origin);
    memcpy(single.direction, ray->direction, sizeof single.direction);
    single.skip_mesh = ray->skip[0];
    single.skip_triangle = ray->skip[1];
    if (ray->skip[0] == MLRT_NONE) single.flags = 0;
    mlrt_hit hit = {.struct_size = sizeof hit};
    assert_int_equal(mlrt_trace_ray(tree, &single, options, &hit), MLRT_OK);
    struct reference_hit out = {hit.t, hit.u, hit.v, hit.mesh, hit.triangle, hit.facing};
    if (options && options->query == MLRT_QUERY_ANY)
        out.mesh = hit.occluded ? 0 : MLRT_NONE;
    else
        assert_int_equal(hit.occluded, hit.mesh != MLRT_NONE);
    return out;
}

static void check_singles(const struct fixture *fixture, const struct ray_list *list,
                          const struct reference_hit *expected, const struct variant *variant)
{
    char text[200];
    size_t step = list->count / 512 + 1;
    for (size_t i = 0; i < list->count; i += step) {
        const struct reference_ray *ray = &list->rays[i];
        if (ray->t_max == 0) continue; // a single ray cannot say this: 0 means no limit there
        mlrt_trace_options options = variant->options;
        struct reference_hit got = trace_one(variant_tree(variant, fixture), ray, &options);
        describe("trace_ray", &options, 0, text, sizeof text);
        check_hit(fixture, text, i, ray, &expected[i], &got);
        options.query = MLRT_QUERY_ANY;
        got = trace_one(variant_tree(variant, fixture), ray, &options);
        describe("trace_ray, any hit", &options, 0, text, sizeof text);
        check_occluded(fixture, text, i, ray, &expected[i], got.mesh != MLRT_NONE);
    }
}

static void check_closest(const struct fixture *fixture, const struct ray_list *list,
                          const struct reference_hit *expected, const struct variant *variant,
                          struct reference_hit *got)
{
    char text[200];
    mlrt_rays rays = public_rays(list);
    mlrt_hits hits = public_hits(got, 0);
    mlrt_trace_options options = variant->options;
    options.pool = shared_pool(variant->threads);
    memset(got, 0xA5, list->count * sizeof *got);
    assert_int_equal(mlrt_trace_packet(variant_tree(variant, fixture), &rays, &options, &hits), MLRT_OK);
    describe("trace_packet", &options, variant->threads, text, sizeof text);
    for (size_t i = 0; i < list->count; i++) check_hit(fixture, text, i, &list->rays[i], &expected[i], &got[i]);
}

static void check_any(const struct fixture *fixture, const struct ray_list *list, const struct reference_hit *expected,
                      const struct variant *variant, uint8_t *got)
{
    char text[200];
    mlrt_rays rays = public_rays(list);
    mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {got, 0, 0}};
    mlrt_trace_options options = variant->options;
    options.pool = shared_pool(variant->threads);
    options.query = MLRT_QUERY_ANY;
    memset(got, 0xA5, list->count);
    assert_int_equal(mlrt_trace_packet(variant_tree(variant, fixture), &rays, &options, &hits), MLRT_OK);
    describe("trace_packet, any hit", &options, variant->threads, text, sizeof text);
    for (size_t i = 0; i < list->count; i++) check_occluded(fixture, text, i, &list->rays[i], &expected[i], got[i]);
}

static void check_rays_by(const struct fixture *fixture, const struct ray_list *list, int probes_only)
{
    struct reference_hit *expected = allocate_or_fail(list->count, sizeof *expected);
    struct reference_hit *got = allocate_or_fail(list->count, sizeof *got);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    trace_reference(fixture, list, expected);
    for (size_t i = first_variant(); i < variant_count(); i += variant_step()) {
        const struct variant *variant = variant_at(i);
        if (probes_only && !variant->probe) continue;
        check_closest(fixture, list, expected, variant, got);
        check_any(fixture, list, expected, variant, occluded);
        if (variant->probe || variant->options.method <= MLRT_METHOD_RAY)
            check_singles(fixture, list, expected, variant);
    }
    free(expected);
    free(got);
    free(occluded);
}

void check_rays(const struct fixture *fixture, const struct ray_list *list)
{
    check_rays_by(fixture, list, 0);
}

void check_rays_quickly(const struct fixture *fixture, const struct ray_list *list)
{
    check_rays_by(fixture, list, 1);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

struct collected {
    uint32_t x, y, width, height; /* the crop */
    uint32_t tile_limit;
    uint32_t worker_limit;
    struct reference_hit *hits;
    uint8_t *occluded;
    unsigned char *times; /* how often each pixel was handed out */
    unsigned char *wrong; /* per worker: a tile that cannot be */
};

static void collect_pixel(struct collected *to, const mlrt_tile *tile, size_t from, size_t at)
{
    to->times[at]++;
    if (tile->occluded) to->occluded[at] = tile->occluded[from];
    if (!tile->t) return;
    struct reference_hit *hit = &to->hits[at];
    hit->t = tile->t[from];
    hit->u = tile->u[from];
    hit->v = tile->v[from];
    hit->mesh = tile->mesh[from];
    hit->triangle = tile->triangle[from];
    hit->facing = tile->facing[from];
}

/* Runs in several threads at once: it writes only to pixels of its tile and to its worker's mark. */
static int32_t collect_tile(void *user, const mlrt_tile *tile)
{
    struct collected *to = user;
    if (tile->worker >= to->worker_limit) return 1;
    int whole = tile->t && tile->u && tile->v && tile->mesh && tile->triangle && tile->facing && !tile->occluded;
    int any = !tile->t && !tile->u && !tile->v && !tile->mesh && !tile->triangle && !tile->facing && tile->occluded;
    if (tile->struct_size != sizeof *tile || whole == any || tile->width == 0 || tile->height == 0 ||
        tile->width > to->tile_limit || tile->height > to->tile_limit || tile->x < to->x || tile->y < to->y ||
        tile->x + tile->width > to->x + to->width || tile->y + tile->height > to->y + to->height) {
        to->wrong[tile->worker] = 1;
        return 0;
    }
    for (uint32_t j = 0; j < tile->height; j++) {
        for (uint32_t i = 0; i < tile->width; i++)
            collect_pixel(to, tile, (size_t)j * tile->width + i,
                          (size_t)(tile->y - to->y + j) * to->width + (tile->x - to->x + i));
    }
    return 0;
}

static struct collected make_collected(const mlrt_camera *camera, const struct variant *variant, size_t count)
{
    struct collected collected = {.x = camera->crop_x, .y = camera->crop_y};
    camera_crop(camera, &collected.width, &collected.height);
    collected.tile_limit = variant->options.initial_tile_size ? variant->options.initial_tile_size : 1024;
    collected.worker_limit = variant->threads ? variant->threads : 1;
    collected.hits = allocate_or_fail(count, sizeof *collected.hits);
    collected.occluded = allocate_or_fail(count, 1);
    collected.times = allocate_or_fail(count, 1);
    collected.wrong = allocate_or_fail(collected.worker_limit, 1);
    return collected;
}

static void free_collected(struct collected *collected)
{
    free(collected->hits);
    free(collected->occluded);
    free(collected->times);
    free(collected->wrong);
}

static void check_coverage(const struct fixture *fixture, const struct collected *collected, size_t count,
                           const char *text)
{
    for (uint32_t w = 0; w < collected->worker_limit; w++) {
        if (collected->wrong[w]) fail_msg("%s: %s: a tile with impossible contents", fixture->name, text);
    }
    for (size_t i = 0; i < count; i++) {
        if (collected->times[i] != 1)
            fail_msg("%s: %s: pixel %zu was handed out %u times", fixture->name, text, i,
                     (unsigned)collected->times[i]);
    }
}

/* Frame and callback in one call. */
static void check_picture(const struct fixture *fixture, const mlrt_camera *camera, const struct ray_list *list,
                          const struct reference_hit *expected, const struct variant *variant, int32_t query)
{
    char text[200];
    struct collected collected = make_collected(camera, variant, list->count);
    struct reference_hit *frame = allocate_or_fail(list->count, sizeof *frame);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    mlrt_hits hits = public_hits(frame, collected.width);
    if (query == MLRT_QUERY_ANY) hits = (mlrt_hits){.struct_size = sizeof hits, .occluded = {occluded, 0, 0}};
    mlrt_trace_options options = variant->options;
    options.query = query;
    options.pool = shared_pool(variant->threads);
    options.outputs = MLRT_OUTPUT_T | MLRT_OUTPUT_UV | MLRT_OUTPUT_IDS | MLRT_OUTPUT_FACING;
    memset(frame, 0xA5, list->count * sizeof *frame);
    memset(occluded, 0xA5, list->count);
    int32_t status =
        mlrt_render_tiles(variant_tree(variant, fixture), camera, &options, &hits, collect_tile, &collected);
    assert_int_equal(status, MLRT_OK);
    describe(query == MLRT_QUERY_ANY ? "render_tiles, any hit" : "render_tiles", &options, variant->threads, text,
             sizeof text);
    check_coverage(fixture, &collected, list->count, text);
    for (size_t i = 0; i < list->count; i++) {
        const struct reference_ray *ray = &list->rays[i];
        if (query == MLRT_QUERY_ANY) {
            check_occluded(fixture, text, i, ray, &expected[i], occluded[i]);
            check_occluded(fixture, text, i, ray, &expected[i], collected.occluded[i]);
        } else {
            check_hit(fixture, text, i, ray, &expected[i], &frame[i]);
            check_hit(fixture, text, i, ray, &expected[i], &collected.hits[i]);
        }
    }
    free_collected(&collected);
    free(frame);
    free(occluded);
}

static int same_vector(const float a[3], const float b[3])
{
    for (int k = 0; k < 3; k++) {
        if (bits_of_float(a[k]) != bits_of_float(b[k]) && !(isnan(a[k]) && isnan(b[k]))) return 0;
    }
    return 1;
}

static void check_camera_rays(const mlrt_camera *camera, const struct ray_list *list)
{
    float *origins = allocate_or_fail(list->count, 12), *directions = allocate_or_fail(list->count, 12);
    mlrt_array out_origins = {origins, 0, 0}, out_directions = {directions, 0, 0};
    assert_int_equal(mlrt_camera_rays(camera, &out_origins, &out_directions), MLRT_OK);
    for (size_t i = 0; i < list->count; i++) {
        const struct reference_ray *ray = &list->rays[i];
        if (same_vector(origins + 3 * i, ray->origin) && same_vector(directions + 3 * i, ray->direction)) continue;
        fail_msg("camera_rays: ray %zu: o = (%a, %a, %a), d = (%a, %a, %a), not o = (%a, %a, %a), d = (%a, %a, %a)", i,
                 (double)origins[3 * i], (double)origins[3 * i + 1], (double)origins[3 * i + 2],
                 (double)directions[3 * i], (double)directions[3 * i + 1], (double)directions[3 * i + 2],
                 (double)ray->origin[0], (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0],
                 (double)ray->direction[1], (double)ray->direction[2]);
    }
    free(origins);
    free(directions);
}

static void check_camera_by(const struct fixture *fixture, const mlrt_camera *camera, int probes_only)
{
    struct ray_list list = {0};
    add_camera_rays(&list, camera);
    struct reference_hit *expected = allocate_or_fail(list.count, sizeof *expected);
    trace_reference(fixture, &list, expected);
    check_camera_rays(camera, &list);
    for (size_t i = first_variant(); i < variant_count(); i += variant_step()) {
        const struct variant *variant = variant_at(i);
        if (probes_only && !variant->probe) continue;
        check_picture(fixture, camera, &list, expected, variant, MLRT_QUERY_CLOSEST);
        check_picture(fixture, camera, &list, expected, variant, MLRT_QUERY_ANY);
    }
    free(expected);
    free_rays(&list);
}

void check_camera(const struct fixture *fixture, const mlrt_camera *camera)
{
    check_camera_by(fixture, camera, 0);
}

void check_camera_quickly(const struct fixture *fixture, const mlrt_camera *camera)
{
    check_camera_by(fixture, camera, 1);
}

/* ---- points and lights ------------------------------------------------------------------------------------------- */

void add_shadow_ray(struct ray_list *list, const float point[3], const uint32_t *skip, const mlrt_light *light)
{
    struct reference_ray *ray;
    if (light->kind == MLRT_LIGHT_POINT) {
        ray = add_ray_towards(list, light->position, point);
        ray->t_max = 1;
    } else {
        ray = add_ray(list, point, light->position);
    }
    if (skip) memcpy(ray->skip, skip, sizeof ray->skip);
}

void check_points(const struct fixture *fixture, const float *positions, const uint32_t *skip, size_t count,
                  uint32_t row_length, const mlrt_light *light)
{
    char text[200];
    struct ray_list list = {0};
    struct reference_hit *expected = allocate_or_fail(count, sizeof *expected);
    uint8_t *got = allocate_or_fail(count, 1);
    mlrt_array occluded = {got, 0, 0};
    mlrt_points points = {.struct_size = sizeof points,
                          .row_length = row_length,
                          .count = count,
                          .positions = {positions, 0},
                          .skip = {skip, 0}};
    for (size_t i = 0; i < count; i++) add_shadow_ray(&list, positions + 3 * i, skip ? skip + 2 * i : NULL, light);
    trace_reference(fixture, &list, expected);
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        const struct variant *variant = variant_at(v);
        mlrt_trace_options options = variant->options;
        options.pool = shared_pool(variant->threads);
        memset(got, 0xA5, count);
        assert_int_equal(mlrt_occluded_points(variant_tree(variant, fixture), &points, light, &options, &occluded),
                         MLRT_OK);
        describe("occluded_points", &options, variant->threads, text, sizeof text);
        for (size_t i = 0; i < count; i++) check_occluded(fixture, text, i, &list.rays[i], &expected[i], got[i]);
    }
    free(expected);
    free(got);
    free_rays(&list);
}

/* ---- guarded memory ---------------------------------------------------------------------------------------------- */

static size_t guarded_length(size_t size, size_t page)
{
    return (size + page - 1) / page * page + page;
}

void *allocate_guarded(size_t size)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE), length = guarded_length(size, page);
    unsigned char *block = mmap(NULL, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(block != MAP_FAILED);
    assert_int_equal(mprotect(block + length - page, page, PROT_NONE), 0);
    return block + length - page - size;
}

void free_guarded(void *block, size_t size)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE), length = guarded_length(size, page);
    assert_int_equal(munmap((unsigned char *)block + size + page - length, length), 0);
}

mlrt_light light_at(float x, float y, float z)
{
    mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_POINT, .position = {x, y, z}};
    return light;
}

mlrt_light light_from(float x, float y, float z)
{
    mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_DIRECTIONAL, .position = {x, y, z}};
    return light;
}
