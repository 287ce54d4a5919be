/* SPDX-License-Identifier: MIT */
/*
 * See worlds.h.
 */
#include "worlds.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/scene.h"
#include "hard_scenes.h"

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

typedef void make_function(struct soup *soup, struct random *random);

static void nothing(struct soup *soup, struct random *random)
{
    (void)soup;
    (void)random;
}

static void one_triangle(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, 1, 1, 2);
}

static void small_triangles(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, 400, 1, 0.15f);
}

static void large_triangles(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, 60, 1, 1);
}

/* On a lattice, where vertices, edges and planes are hit exactly. */
static void lattice_triangles(struct soup *soup, struct random *random)
{
    while (soup->count < 150) {
        float p[9];
        for (int n = 0; n < 9; n++) p[n] = 0.25f * (float)draw_below(random, 17);
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

static void coplanar_grids(struct soup *soup, struct random *random)
{
    for (int axis = 0; axis < 3; axis++) soup_add_grid(soup, axis, (float)draw_below(random, 5), 6);
}

/* A wall cut into 1 to 5 strips, each of which has its own triangles and lies 0 to 3 floats aside. */
static void add_wall(struct soup *soup, struct random *random, int axis, float level)
{
    const int strips = 1 + (int)draw_below(random, 5), turned = (int)draw_below(random, 2);
    for (int i = 0; i < strips; i++) {
        float corner[3], side[3] = {0, 0, 0}, other[3] = {0, 0, 0};
        const int across = (axis + 1 + turned) % 3, along = (axis + 2 - turned) % 3;
        corner[axis] = next_float(level, (int)draw_below(random, 4));
        corner[across] = -2 + 4 * (float)i / (float)strips;
        corner[along] = -2;
        side[across] = 4 / (float)strips;
        other[along] = 4;
        soup_add_quad(soup, corner, side, other);
    }
}

/* A room whose walls are there two or three times. */
static void doubled_walls(struct soup *soup, struct random *random)
{
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < 5; i++) add_wall(soup, random, axis, i % 2 ? -2.0f : 2.0f);
    }
    soup_add_random(soup, random, 20, 1.5f, 0.3f);
}

/* A vertex of a grid over a surface, each coordinate up to `most` floats aside. */
static void surface_point(const float frame[3][3], float u, float v, uint32_t most, struct random *random,
                          float point[3])
{
    for (int k = 0; k < 3; k++) {
        const int floats = (int)draw_below(random, 2 * most + 1) - (int)most;
        point[k] = next_float(frame[0][k] + u * frame[1][k] + v * frame[2][k], floats);
    }
}

/*
 * Surfaces that are there two or three times, each cut into a grid of its own, along either diagonal. The vertices of a
 * copy lie up to 3 floats aside, so the planes of triangles cross each other all over the surface.
 */
static void doubled_surfaces(struct soup *soup, struct random *random)
{
    const int is_aligned = (int)draw_below(random, 2), surfaces = 1 + (int)draw_below(random, 3);
    for (int i = 0; i < surfaces; i++) {
        float frame[3][3] = {{0}};
        for (int n = 0; n < 3; n++) draw_point(random, n ? -4 : -1, n ? 4 : 1, frame[n]);
        for (int k = 0; is_aligned && k < 3; k++) frame[1][k] *= k == i, frame[2][k] *= k == (i + 1) % 3;
        for (int k = 0; k < 3; k++) frame[0][k] -= 0.5f * (frame[1][k] + frame[2][k]);
        const int copies = 2 + (int)draw_below(random, 2);
        for (int copy = 0; copy < copies; copy++) {
            const uint32_t cells = 1 + draw_below(random, 4), most = copy ? draw_below(random, 4) : 0;
            const int turned = (int)draw_below(random, 2);
            for (uint32_t cell = 0; cell < cells * cells; cell++) {
                float corner[4][3];
                for (uint32_t c = 0; c < 4; c++) {
                    const uint32_t column = cell % cells + (c == 1 || c == 2), row = cell / cells + (c >= 2);
                    surface_point((const float(*)[3])frame, (float)column / (float)cells, (float)row / (float)cells,
                                  most, random, corner[c]);
                }
                soup_add_triangle(soup, corner[turned], corner[1 + turned], corner[2 + turned]);
                soup_add_triangle(soup, corner[turned], corner[2 + turned], corner[(3 + turned) % 4]);
            }
        }
    }
}

/* Parallel walls with gaps, one behind the other: depths differ from pixel to pixel. */
static void combs(struct soup *soup, struct random *random)
{
    for (int i = 0; i < 40; i++) {
        const float depth = ldexpf(1, i / 4) * (1 + 0.25f * (float)(i % 4)), from = draw_range(random, -1, 1);
        const float corner[3] = {from * depth, -depth, depth}, side[3] = {0.1f * depth, 0, 0};
        const float other[3] = {0, 2 * depth, 0};
        soup_add_quad(soup, corner, side, other);
    }
}

static void needles(struct soup *soup, struct random *random)
{
    soup_add_needles(soup, random, 150, draw_below(random, 2) ? 1e3f : 1e6f);
}

/* Needles that end in one vertex, on a lattice point. */
static void needle_fan(struct soup *soup, struct random *random)
{
    const float centre[3] = {1, 2, 3};
    for (int i = 0; i < 200; i++) {
        float tip[3], next[3];
        draw_point(random, -1, 1, tip);
        for (int k = 0; k < 3; k++) {
            tip[k] += centre[k];
            next[k] = tip[k] + draw_range(random, -0.001f, 0.001f);
        }
        soup_add_triangle(soup, centre, tip, next);
    }
}

static void curved(struct soup *soup, struct random *random)
{
    soup_add_torus(soup, 28, 14, 1, 0.4f);
    soup_add_random(soup, random, 20, 1.5f, 0.5f);
}

static void sphere_in_a_box(struct soup *soup, struct random *random)
{
    const float lo[3] = {-3, -3, -3}, hi[3] = {3, 3, draw_range(random, 1.5f, 3)};
    soup_add_icosphere(soup, 2, 1);
    soup_add_box(soup, lo, hi);
}

static void lattice_boxes(struct soup *soup, struct random *random)
{
    const float room_lo[3] = {0, 0, 0}, room_hi[3] = {8, 8, 4};
    soup_add_box(soup, room_lo, room_hi);
    for (int i = 0; i < 25; i++) {
        float lo[3], hi[3];
        for (int k = 0; k < 3; k++) {
            lo[k] = 0.25f * (float)draw_below(random, k == 2 ? 12 : 28);
            hi[k] = lo[k] + 0.25f * (float)(1 + draw_below(random, 6));
        }
        soup_add_box(soup, lo, hi);
    }
}

/* One triangle that float arithmetic cannot carry among many that it can. */
static void one_huge_triangle(struct soup *soup, struct random *random)
{
    float p[9];
    soup_add_random(soup, random, 150, 1, 0.4f);
    for (int n = 0; n < 9; n++) p[n] = 0x1p70f * draw_range(random, -1, 1);
    soup_add_triangle(soup, p, p + 3, p + 6);
}

static void one_tiny_triangle(struct soup *soup, struct random *random)
{
    float p[9];
    soup_add_random(soup, random, 150, 1, 0.4f);
    for (int n = 0; n < 9; n++) p[n] = 0x1p-70f * draw_range(random, -1, 1);
    soup_add_triangle(soup, p, p + 3, p + 6);
}

static void far_from_the_origin(struct soup *soup, struct random *random)
{
    const float offset[3] = {0x1p20f, -0x1p20f, 0x1p18f};
    soup_add_torus(soup, 20, 10, 8, 3);
    soup_add_random(soup, random, 60, 12, 3);
    move_soup(soup, 1, offset);
}

/* Triangles around one another, all of which nearly touch in one plane. */
static void nested(struct soup *soup, struct random *random)
{
    const int count = 20 + (int)draw_below(random, 60);
    for (int i = 0; i < count; i++) {
        const float s = 0.0001f + (float)i / (2.0f * (float)count);
        const float a[3] = {0.5f - s, 0.5f - s, 0.5f - s}, b[3] = {0.5f + s, 0.5f - s, 0.5f + s};
        const float c[3] = {0.5f, 0.5f + s, 0.5f};
        soup_add_triangle(soup, a, b, c);
    }
}

/* Vertices that are not finite, triangles without area, and all else twice. */
static void flawed(struct soup *soup, struct random *random)
{
    soup_add_random(soup, random, 80, 1, 0.5f);
    const size_t count = soup->count;
    for (size_t i = 0; i < count; i++) {
        float p[9];
        memcpy(p, soup->corners + 9 * i, sizeof p);
        if (i % 5 == 0) p[draw_below(random, 9)] = draw_below(random, 2) ? NAN : INFINITY;
        if (i % 5 == 1) memcpy(p + 3, p, 12);
        soup_add_triangle(soup, p + 3, p + 6, p);
    }
}

static void any_bits(struct soup *soup, struct random *random)
{
    while (soup->count < 60) {
        float p[9];
        for (int n = 0; n < 9; n++) p[n] = draw_finite(random);
        soup_add_triangle(soup, p, p + 3, p + 6);
    }
}

static void room(struct soup *soup, struct random *random)
{
    struct scene scene;
    (void)random;
    assert_int_equal(load_scene("room", &scene), 0);
    for (size_t i = 0; i < scene.triangle_count; i++) {
        const uint32_t *corner = scene.indices + 3 * i;
        soup_add_triangle(soup, scene.vertices + 3 * corner[0], scene.vertices + 3 * corner[1],
                          scene.vertices + 3 * corner[2]);
    }
    free_scene(&scene);
}

static const struct {
    const char *name;
    make_function *make;
    int has_scale; /* 1 = has no magnitude of its own, so it can be scaled as a whole */
} scenes[] = {
    {"nothing", nothing, 0},
    {"one triangle", one_triangle, 1},
    {"small triangles", small_triangles, 1},
    {"large triangles", large_triangles, 1},
    {"triangles on a lattice", lattice_triangles, 1},
    {"coplanar grids", coplanar_grids, 1},
    {"doubled walls", doubled_walls, 1},
    {"doubled surfaces", doubled_surfaces, 1},
    {"combs", combs, 1},
    {"needles", needles, 1},
    {"needle fan", needle_fan, 1},
    {"torus and triangles", curved, 1},
    {"sphere in a box", sphere_in_a_box, 1},
    {"boxes on a lattice", lattice_boxes, 1},
    {"one huge triangle", one_huge_triangle, 0},
    {"one tiny triangle", one_tiny_triangle, 0},
    {"far from the origin", far_from_the_origin, 0},
    {"nested", nested, 1},
    {"flawed", flawed, 1},
    {"any bits", any_bits, 0},
    {"room", room, 1},
};

enum { SCENE_COUNT = sizeof scenes / sizeof scenes[0] };

size_t world_scene_count(void)
{
    return SCENE_COUNT;
}

/* ---- twists ------------------------------------------------------------------------------------------------------ */

static void add_corners(struct soup *soup, const float p[9])
{
    soup_add_triangle(soup, p, p + 3, p + 6);
}

/* Triangles `first` and after, times 2^power. */
static void scale_from(struct soup *soup, size_t first, int power)
{
    for (size_t i = 9 * first; i < 9 * soup->count; i++) soup->corners[i] = ldexpf(soup->corners[i], power);
}

/* Beside these, another scene or up to 120 triangles of a hard one, as large, or so large or small that they are odd. */
static void join(struct soup *soup, struct random *random)
{
    const size_t first = soup->count;
    if (draw_below(random, 2)) {
        scenes[draw_below(random, SCENE_COUNT)].make(soup, random);
    } else {
        struct soup whole = {0};
        hard_scene_at(draw_below(random, (uint32_t)hard_scene_count()))->make(&whole, random);
        const size_t begin = whole.count ? draw_below(random, (uint32_t)whole.count) : 0;
        const size_t end = begin + draw_below(random, 121);
        for (size_t i = begin; i < end && i < whole.count; i++) add_corners(soup, whole.corners + 9 * i);
        free_soup(&whole);
    }
    if (draw_below(random, 3) == 0) scale_from(soup, first, (int)draw_below(random, 201) - 100);
}

/* One triangle in a few so large or so small that float does not carry it. */
static void make_odd(struct soup *soup, struct random *random)
{
    const uint32_t each = 2 + draw_below(random, 30), power = 40 + draw_below(random, 70);
    for (size_t i = 0; i < soup->count; i++) {
        if (draw_below(random, each)) continue;
        for (size_t n = 9 * i; n < 9 * i + 9; n++)
            soup->corners[n] = ldexpf(soup->corners[n], draw_below(random, 4) ? (int)power : -(int)power);
    }
}

/* Some triangles across an axis, all in the plane of a vertex, or each in one of its own. */
static void flatten(struct soup *soup, struct random *random)
{
    const uint32_t each = 1 + draw_below(random, 8), axis = draw_below(random, 3), is_one = draw_below(random, 2);
    for (size_t i = 0; i < soup->count; i++) {
        float *p = soup->corners + 9 * i;
        if (draw_below(random, each)) continue;
        for (uint32_t n = axis; n < 9; n += 3) p[n] = is_one ? soup->corners[axis] : p[axis];
    }
}

/* A copy: its corners in another order, up to 2 floats aside each, and in one case of four only a part of it. */
static void add_copy(struct soup *soup, struct random *random, size_t of)
{
    const uint32_t most = draw_below(random, 3), turn = draw_below(random, 3), is_mirrored = draw_below(random, 2);
    float p[9];
    for (uint32_t c = 0; c < 3; c++) {
        const uint32_t from = (is_mirrored ? 3 - c : c) + turn;
        memcpy(p + 3 * c, soup->corners + 9 * of + 3 * (from % 3), 12);
    }
    if (draw_below(random, 4) == 0) {
        const float part = draw_below(random, 2) ? 0.5f : draw_range(random, 0, 1);
        for (int k = 0; k < 3; k++) p[3 + k] = p[k] + part * (p[3 + k] - p[k]);
    }
    for (int n = 0; n < 9; n++) {
        const float moved = next_float(p[n], (int)draw_below(random, 2 * most + 1) - (int)most);
        if (isfinite(moved)) p[n] = moved;
    }
    add_corners(soup, p);
}

static void copy_some(struct soup *soup, struct random *random)
{
    const size_t count = soup->count;
    const uint32_t each = 1 + draw_below(random, 12), copies = 1 + draw_below(random, 3);
    for (size_t i = 0; i < count && soup->count < 1200; i++) {
        if (draw_below(random, each)) continue;
        for (uint32_t j = 0; j < copies; j++) add_copy(soup, random, i);
    }
}

static void stretch_axes(struct soup *soup, struct random *random)
{
    for (int k = 0; k < 3; k++) {
        const int power = (int)draw_below(random, 61) - 30;
        for (size_t n = (size_t)k; n < 9 * soup->count; n += 3) soup->corners[n] = ldexpf(soup->corners[n], power);
    }
}

static void shuffle(struct soup *soup, struct random *random)
{
    for (size_t i = soup->count; i > 1; i--) {
        float *a = soup->corners + 9 * (i - 1), *b = soup->corners + 9 * draw_below(random, (uint32_t)i), kept[9];
        memcpy(kept, a, sizeof kept);
        memmove(a, b, sizeof kept);
        memcpy(b, kept, sizeof kept);
    }
}

/* In this order: what joins the scene can become odd, and all that is odd can have close copies. */
static const struct {
    make_function *apply;
    uint32_t each; /* in one scene of so many that are twisted */
} twists[] = {{join, 2}, {make_odd, 3}, {flatten, 6}, {copy_some, 2}, {stretch_axes, 10}, {shuffle, 3}};

static void twist(struct soup *soup, struct random *random)
{
    for (size_t i = 0; i < sizeof twists / sizeof twists[0]; i++) {
        if (draw_below(random, twists[i].each) == 0) twists[i].apply(soup, random);
    }
}

/* ---- worlds ------------------------------------------------------------------------------------------------------ */

/* Of a mesh; 0 is all bits. */
static const uint32_t mesh_masks[] = {1, 2, 0, 3, 0x80000004u};

enum { MESH_MASK_COUNT = sizeof mesh_masks / sizeof mesh_masks[0] };

void free_world(struct world *world)
{
    free_fixture(&world->fixture);
    for (int i = 0; i < 1 << WORLD_MESH_LIMIT; i++) reference_destroy(world->visible[i]);
    free_soup(&world->soup);
    memset(world, 0, sizeof *world);
}

/* In some worlds the triangles are shared out among four meshes, one of which is shown to all. */
static void make_meshes(struct world *world, struct random *random)
{
    const size_t total = world->soup.count;
    const int is_masked = draw_below(random, 3) == 0;
    world->mesh_count = draw_below(random, 3) ? 1 : WORLD_MESH_LIMIT;
    if (total == 0 && draw_below(random, 2)) world->mesh_count = 0;
    for (size_t i = 0; i < world->mesh_count; i++) {
        mlrt_mesh *mesh = &world->meshes[i];
        const size_t first = i * total / world->mesh_count, end = (i + 1) * total / world->mesh_count;
        *mesh = soup_mesh(&world->soup);
        if (total) mesh->vertices = world->soup.corners + 9 * first;
        mesh->vertex_count = 3 * (end - first);
        mesh->triangle_count = end - first;
        mesh->id = world->mesh_count > 1 ? 40 - 9 * (uint32_t)i : 0;
        if (is_masked) mesh->mask = mesh_masks[draw_below(random, MESH_MASK_COUNT)];
    }
}

/* The triangles of the meshes in `set`. */
static struct reference_scene *make_reference(const struct world *world, uint32_t set)
{
    struct reference_triangle *triangles = allocate_or_fail(world->soup.count, sizeof *triangles);
    size_t count = 0;
    for (size_t m = 0; m < world->mesh_count; m++) {
        const mlrt_mesh *mesh = &world->meshes[m];
        for (size_t i = 0; set >> m & 1 && i < mesh->triangle_count; i++, count++) {
            memcpy(triangles[count].corner, (const float *)mesh->vertices + 9 * i, sizeof triangles[count].corner);
            triangles[count].mesh = mesh->id;
            triangles[count].triangle = (uint32_t)i;
        }
    }
    struct reference_scene *scene = reference_create(triangles, count);
    free(triangles);
    return scene;
}

void make_world(uint64_t number, int with_kdtree, struct world *world)
{
    static const int powers[] = {-100, -70, -30, 0, 30, 70, 100};
    static const int32_t presets[] = {MLRT_TREE_DEFAULT, MLRT_TREE_DEFAULT, MLRT_TREE_FAST, MLRT_TREE_BEST};
    struct random random = {number * 7919 + 17}, twister = {number};
    const size_t scene = number % SCENE_COUNT;
    int power = draw_below(&random, 2) ? powers[draw_below(&random, 7)] : 0;
    const int is_twisted = number >= 2 * SCENE_COUNT && draw_below(&twister, 3) > 0;
    if (!scenes[scene].has_scale) power = 0;
    snprintf(world->name, sizeof world->name, "world %llu: %s%s, * 2^%d", (unsigned long long)number,
             scenes[scene].name, is_twisted ? ", twisted" : "", power);
    scenes[scene].make(&world->soup, &random);
    if (is_twisted) twist(&world->soup, &twister);
    scale_from(&world->soup, 0, power);
    make_meshes(world, &random);
    const mlrt_tree_options options = {.struct_size = sizeof options, .preset = presets[draw_below(&random, 4)]};
    world->fixture.name = world->name;
    world->fixture.seed = number;
    assert_int_equal(mlrt_build_tree(world->meshes, world->mesh_count, &options, &world->fixture.tree), MLRT_OK);
    world->fixture.reference = make_reference(world, ~0u);
    if (with_kdtree) world->fixture.kdtree = build_structure(world->meshes, world->mesh_count, MLRT_STRUCTURE_KDTREE);
}

struct reference_scene *visible_part(struct world *world, uint32_t mask)
{
    uint32_t set = 0;
    for (size_t m = 0; m < world->mesh_count; m++) {
        const uint32_t own = world->meshes[m].mask ? world->meshes[m].mask : ~0u;
        if (own & (mask ? mask : ~0u)) set |= 1u << m;
    }
    if (!world->visible[set]) world->visible[set] = make_reference(world, set);
    return world->visible[set];
}
