/* SPDX-License-Identifier: MIT */
/*
 * Arrays of rays that are alike, in every form that mlrt_rays allows: method tile with each instruction set, closest
 * and any hit, against method ray bit for bit, and a part of the rays against the reference.
 *
 * A case is a number. It says which kind of bundle (bundle_rays.h) goes into which scene, and the seed from which all
 * else is drawn: how many rays, in rows or as a list, their ranges, skips, masks, strides. A failure prints the number.
 *
 *     test_bundles COUNT [FIRST]
 *
 * runs so many cases from the number FIRST on, and says how many answers were compared.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bundle_rays.h"
#include "common/scene.h"
#include "hostile_rays.h"
#include "support.h"

enum { MESH_LIMIT = 4 };

static uint64_t case_count, first_case;
static uint64_t answer_count, judged_count, ray_count;

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

/* ---- worlds ------------------------------------------------------------------------------------------------------ */

/* Masks of meshes and of rays; of a mesh 0 is all bits, and so it is of a ray. */
static const uint32_t mesh_masks[] = {1, 2, 0, 3, 0x80000004u};
static const uint32_t ray_masks[] = {0, 1, 2, 3, 4, 8, 0x80000000u, 0xFFFFFFFFu};

enum { MESH_MASK_COUNT = sizeof mesh_masks / sizeof mesh_masks[0] };
enum { RAY_MASK_COUNT = sizeof ray_masks / sizeof ray_masks[0] };

/* A scene, in one mesh or in several with masks. */
struct world {
    uint64_t number;
    int is_there;
    char name[80];
    struct soup soup;
    mlrt_mesh meshes[MESH_LIMIT];
    size_t mesh_count;
    struct fixture fixture;                           /* of all triangles: its reference knows nothing of masks */
    struct reference_scene *visible[1 << MESH_LIMIT]; /* of the meshes in a set; made when they are asked for */
};

enum { WORLD_LIMIT = 64 };

static struct world worlds[WORLD_LIMIT];

static void free_world(struct world *world)
{
    free_fixture(&world->fixture);
    for (int i = 0; i < 1 << MESH_LIMIT; i++) reference_destroy(world->visible[i]);
    free_soup(&world->soup);
    memset(world, 0, sizeof *world);
}

/* In some worlds the triangles are shared out among four meshes, one of which is shown to all. */
static void make_meshes(struct world *world, struct random *random)
{
    const size_t total = world->soup.count;
    const int is_masked = draw_below(random, 3) == 0;
    world->mesh_count = draw_below(random, 3) ? 1 : MESH_LIMIT;
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

static void make_world(uint64_t number, struct world *world)
{
    static const int powers[] = {-100, -70, -30, 0, 30, 70, 100};
    struct random random = {number * 7919 + 17};
    const size_t scene = number % SCENE_COUNT;
    int power = draw_below(&random, 2) ? powers[draw_below(&random, 7)] : 0;
    if (!scenes[scene].has_scale) power = 0;
    world->number = number;
    world->is_there = 1;
    snprintf(world->name, sizeof world->name, "%s * 2^%d", scenes[scene].name, power);
    scenes[scene].make(&world->soup, &random);
    for (size_t i = 0; i < 9 * world->soup.count; i++) world->soup.corners[i] = ldexpf(world->soup.corners[i], power);
    make_meshes(world, &random);
    mlrt_tree_options options = {.struct_size = sizeof options};
    static const int32_t presets[] = {MLRT_TREE_DEFAULT, MLRT_TREE_DEFAULT, MLRT_TREE_FAST, MLRT_TREE_BEST};
    options.preset = presets[draw_below(&random, 4)];
    world->fixture.name = world->name;
    assert_int_equal(mlrt_build_tree(world->meshes, world->mesh_count, &options, &world->fixture.tree), MLRT_OK);
    world->fixture.reference = make_reference(world, ~0u);
}

static struct world *find_world(uint64_t number)
{
    struct world *world = &worlds[number % WORLD_LIMIT];
    if (world->is_there && world->number == number) return world;
    free_world(world);
    make_world(number, world);
    return world;
}

static int free_worlds(void **state)
{
    (void)state;
    for (int i = 0; i < WORLD_LIMIT; i++) free_world(&worlds[i]);
    return 0;
}

static struct reference_scene *visible_part(struct world *world, uint32_t mask)
{
    uint32_t set = 0;
    for (size_t m = 0; m < world->mesh_count; m++) {
        const uint32_t own = world->meshes[m].mask ? world->meshes[m].mask : ~0u;
        if (own & (mask ? mask : ~0u)) set |= 1u << m;
    }
    if (!world->visible[set]) world->visible[set] = make_reference(world, set);
    return world->visible[set];
}

/* ---- what each ray has besides ----------------------------------------------------------------------------------- */

static float draw_odd_limit(struct random *random, float t)
{
    const float below = isfinite(t) ? next_float(t, -1) : t;
    const float odd[] = {0.0f,     -0.0f,     -1.0f, 1.0f,    0x1p-140f, -0x1p-140f, 0x1p-149f,
                         INFINITY, -INFINITY, NAN,   FLT_MAX, -FLT_MAX,  t,          below};
    return odd[draw_below(random, sizeof odd / sizeof odd[0])];
}

/* Ends or begins the range at a hit, or a float aside. */
static void limit_near_hit(struct reference_ray *ray, struct random *random, float t)
{
    if (!isfinite(t)) return;
    const float near = next_float(t, (int)draw_below(random, 3) - 1);
    if (draw_below(random, 2))
        ray->t_max = near;
    else
        ray->t_min = near;
    if (draw_below(random, 8) == 0) ray->t_min = ray->t_max = near;
}

static void set_ranges(struct ray_list *list, struct random *random, const struct reference_hit *hits)
{
    const uint32_t kind = draw_below(random, 12);
    const float t = hits[draw_below(random, (uint32_t)list->count)].t;
    const float common = isfinite(t) ? t : 1, least = draw_odd_limit(random, common);
    for (size_t i = 0; i < list->count; i++) {
        struct reference_ray *ray = &list->rays[i];
        switch (kind) {
        case 0: // one for all
            ray->t_max = common;
            break;
        case 1:
            ray->t_min = least;
            break;
        case 2:
        case 7:
            limit_near_hit(ray, random, hits[i].t);
            break;
        case 3:
            ray->t_min = draw_odd_limit(random, hits[i].t);
            ray->t_max = draw_odd_limit(random, hits[i].t);
            break;
        case 4: // most are empty
            ray->t_max = common;
            ray->t_min = next_float(common, (int)draw_below(random, 4) - 1);
            break;
        case 5: // a few
            if (draw_below(random, 24)) break;
            ray->t_min = draw_below(random, 2) ? draw_odd_limit(random, hits[i].t) : ray->t_min;
            ray->t_max = draw_odd_limit(random, hits[i].t);
            break;
        case 6:
            ray->t_max = common * draw_range(random, 0.5f, 1.5f);
            break;
        default:
            return;
        }
    }
}

static void set_skips(struct ray_list *list, struct random *random, const struct world *world,
                      const struct reference_hit *hits)
{
    static const uint32_t wrong[] = {MLRT_NONE, 0x80000000u, 0x7FFFFFFFu, 1000000, 0};
    const uint32_t kind = draw_below(random, 10);
    const struct reference_hit *one = &hits[draw_below(random, (uint32_t)list->count)];
    for (size_t i = 0; i < list->count; i++) {
        uint32_t *skip = list->rays[i].skip;
        const struct reference_hit *hit = kind == 1 ? one : &hits[i];
        if (kind > 3) return;
        skip[0] = hit->mesh;
        skip[1] = hit->triangle;
        if (kind >= 2 && draw_below(random, kind == 2 ? 2 : 16) == 0) {
            skip[draw_below(random, 2)] = wrong[draw_below(random, 5)];
            if (draw_below(random, 3) == 0) skip[0] = world->mesh_count ? world->meshes[0].id : 0;
            if (draw_below(random, 3) == 0) skip[1] = draw_below(random, (uint32_t)world->soup.count + 1);
        }
    }
}

/* Masks of rays: none, one for all, one for each, or for each 16. Returns whether there are any. */
static int set_masks(uint32_t *masks, size_t count, struct random *random, uint32_t *common_mask)
{
    const uint32_t kind = draw_below(random, 6);
    *common_mask = draw_below(random, 4) ? 0 : ray_masks[draw_below(random, RAY_MASK_COUNT)];
    uint32_t mask = ray_masks[draw_below(random, RAY_MASK_COUNT)];
    for (size_t i = 0; i < count; i++) {
        if (kind == 1 || (kind == 2 && i % 16 == 0)) mask = ray_masks[draw_below(random, RAY_MASK_COUNT)];
        masks[i] = mask;
    }
    return kind < 3;
}

/* ---- arrays of the caller's -------------------------------------------------------------------------------------- */

enum { ORIGIN, DIRECTION, T_MIN, T_MAX, SKIP, MASK, FIELD_COUNT };

static const size_t field_sizes[FIELD_COUNT] = {12, 12, 4, 4, 8, 4};

#define APART ((size_t)-1)

/* A struct of the caller's for a ray, or of a part of it. The other fields have arrays of their own. */
static const struct layout {
    size_t stride; /* 0 = no struct: all arrays are packed */
    size_t offsets[FIELD_COUNT];
} layouts[] = {
    {0, {APART, APART, APART, APART, APART, APART}},
    {4, {APART, APART, APART, APART, APART, APART}}, // arrays of their own, with gaps
    {24, {0, 12, APART, APART, APART, APART}},
    {28, {0, 12, APART, 24, APART, APART}},
    {32, {0, 16, 12, 28, APART, APART}},
    {32, {0, 12, APART, 24, APART, 28}},
    {36, {12, 0, APART, 24, 28, APART}},
    {40, {0, 12, 24, 28, 32, APART}},
    {64, {0, 16, 32, 36, 40, 48}},
};

enum { LAYOUT_COUNT = sizeof layouts / sizeof layouts[0], BLOCK_LIMIT = FIELD_COUNT + 1 };

struct arrays {
    void *blocks[BLOCK_LIMIT];
    size_t sizes[BLOCK_LIMIT];
    mlrt_rays rays;
};

static mlrt_const_array *array_of(mlrt_rays *rays, int field)
{
    mlrt_const_array *const arrays[FIELD_COUNT] = {&rays->origins, &rays->directions, &rays->t_min,
                                                   &rays->t_max,   &rays->skip,       &rays->mask};
    return arrays[field];
}

static const void *field_of(const struct ray_list *list, const uint32_t *masks, int field, size_t i)
{
    const struct reference_ray *ray = &list->rays[i];
    const void *const fields[FIELD_COUNT] = {ray->origin, ray->direction, &ray->t_min,
                                             &ray->t_max, ray->skip,      &masks[i]};
    return fields[field];
}

/* The arrays that must be there: those with an element that differs from what their absence means. */
static uint32_t needed_fields(const struct ray_list *list, int has_masks)
{
    uint32_t needed = 1u << ORIGIN | 1u << DIRECTION | (uint32_t)has_masks << MASK;
    for (size_t i = 0; i < list->count; i++) {
        const struct reference_ray *ray = &list->rays[i];
        if (bits_of_float(ray->t_min) != 0) needed |= 1u << T_MIN;
        if (bits_of_float(ray->t_max) != bits_of_float(INFINITY)) needed |= 1u << T_MAX;
        if (ray->skip[0] != MLRT_NONE) needed |= 1u << SKIP;
    }
    return needed;
}

static struct arrays make_arrays(const struct ray_list *list, const uint32_t *masks, uint32_t fields,
                                 const struct layout *layout)
{
    struct arrays arrays = {.rays = {.struct_size = sizeof arrays.rays, .count = list->count}};
    const size_t count = list->count;
    const int is_struct = layout->offsets[ORIGIN] != APART;
    if (is_struct) {
        arrays.sizes[FIELD_COUNT] = count * layout->stride;
        arrays.blocks[FIELD_COUNT] = allocate_guarded(arrays.sizes[FIELD_COUNT]);
        memset(arrays.blocks[FIELD_COUNT], 0xFF, arrays.sizes[FIELD_COUNT]);
    }
    for (int f = 0; f < FIELD_COUNT; f++) {
        if (!(fields >> f & 1)) continue;
        size_t stride = layout->stride;
        unsigned char *data;
        if (layout->offsets[f] != APART) {
            data = (unsigned char *)arrays.blocks[FIELD_COUNT] + layout->offsets[f];
        } else {
            stride = field_sizes[f] + (is_struct || !stride ? 0 : 4 * ((size_t)f + 1));
            arrays.sizes[f] = (count - 1) * stride + field_sizes[f];
            data = arrays.blocks[f] = allocate_guarded(arrays.sizes[f]);
            memset(data, 0xFF, arrays.sizes[f]);
        }
        for (size_t i = 0; i < count; i++) memcpy(data + i * stride, field_of(list, masks, f, i), field_sizes[f]);
        const int may_be_zero = stride == field_sizes[f] && (f + count) % 2;
        *array_of(&arrays.rays, f) = (mlrt_const_array){data, may_be_zero ? 0 : stride};
    }
    return arrays;
}

static void free_arrays(struct arrays *arrays)
{
    for (int i = 0; i < BLOCK_LIMIT; i++) {
        if (arrays->blocks[i]) free_guarded(arrays->blocks[i], arrays->sizes[i]);
    }
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

enum { OUTPUT_COUNT = 6 };

/* Where results go: which of the six, packed one array after the other (stride 0), or in structs. */
struct output {
    uint32_t wanted;
    size_t stride;
    uint32_t first; /* which of them comes first in the struct */
};

static struct output draw_output(struct random *random)
{
    static const size_t strides[] = {0, 24, 28, 32, 64};
    struct output output = {.wanted = 0x3F, .stride = strides[draw_below(random, 5)], .first = draw_below(random, 6)};
    if (draw_below(random, 3) == 0) output.wanted = 1 + draw_below(random, 0x3F);
    if (draw_below(random, 4) == 0) output.wanted = 0x10 | draw_below(random, 2); // triangle, or triangle and t
    return output;
}

static size_t output_size(const struct output *output, size_t count)
{
    return count * (output->stride ? output->stride : 4 * OUTPUT_COUNT);
}

static unsigned char *output_place(const struct output *output, unsigned char *block, size_t count, uint32_t field)
{
    return block + (output->stride ? 4 * ((field + output->first) % OUTPUT_COUNT) : 4 * field * count);
}

static mlrt_hits hits_of_output(const struct output *output, unsigned char *block, size_t count)
{
    mlrt_hits hits = {.struct_size = sizeof hits};
    mlrt_array *const arrays[OUTPUT_COUNT] = {&hits.t, &hits.u, &hits.v, &hits.mesh, &hits.triangle, &hits.facing};
    for (uint32_t f = 0; f < OUTPUT_COUNT; f++) {
        if (output->wanted >> f & 1)
            *arrays[f] = (mlrt_array){output_place(output, block, count, f), output->stride, 0};
    }
    return hits;
}

/* What the memory holds after the call: 0x77 wherever nothing is to be written. */
static void fill_expected(const struct output *output, const struct reference_hit *hits, size_t count,
                          unsigned char *block)
{
    const size_t stride = output->stride ? output->stride : 4;
    memset(block, 0x77, output_size(output, count));
    for (uint32_t f = 0; f < OUTPUT_COUNT; f++) {
        unsigned char *at = output_place(output, block, count, f);
        for (size_t i = 0; output->wanted >> f & 1 && i < count; i++) {
            const void *const fields[OUTPUT_COUNT] = {&hits[i].t,    &hits[i].u,        &hits[i].v,
                                                      &hits[i].mesh, &hits[i].triangle, &hits[i].facing};
            memcpy(at + i * stride, fields[f], 4);
        }
    }
}

/* The results that a block holds; those that are not wanted as they are in `expected`. */
static void read_output(const struct output *output, unsigned char *block, const struct reference_hit *expected,
                        size_t i, size_t count, struct reference_hit *got)
{
    const size_t stride = output->stride ? output->stride : 4;
    void *const fields[OUTPUT_COUNT] = {&got->t, &got->u, &got->v, &got->mesh, &got->triangle, &got->facing};
    *got = expected[i];
    for (uint32_t f = 0; f < OUTPUT_COUNT; f++) {
        if (output->wanted >> f & 1) memcpy(fields[f], output_place(output, block, count, f) + i * stride, 4);
    }
}

/* ---- a case ------------------------------------------------------------------------------------------------------ */

struct bundle {
    struct world *world;
    struct ray_list list;
    uint32_t *masks;
    int has_masks;
    uint32_t common_mask;
    uint32_t fields;
    struct reference_hit *expected;
    char name[300];
};

/* A few sizes at which blocks, tiles and rows end, and any. */
static struct bundle_shape draw_shape(struct random *random)
{
    static const uint32_t sizes[] = {1, 2, 3, 4, 5, 15, 16, 17, 63, 64, 65, 255, 256, 257, 511, 513, 1023, 1025};
    const uint32_t kind = draw_below(random, 8), limit = (uint32_t)scaled(kind == 7 ? 3000 : 700);
    struct bundle_shape shape = {1 + draw_below(random, limit), 16 + draw_below(random, 85)};
    if (kind < 2) shape.count = sizes[draw_below(random, sizeof sizes / sizeof sizes[0])];
    if (kind == 2) shape.count = shape.width * (1 + draw_below(random, 16));
    if (kind == 3) shape = (struct bundle_shape){1024, 32};
    if (draw_below(random, 3) == 0) shape.width = 16 << draw_below(random, 3);
    return shape;
}

static uint32_t draw_row_length(struct random *random, struct bundle_shape shape)
{
    const uint32_t kind = draw_below(random, 8);
    if (kind < 5) return shape.width;
    if (kind < 7) return 0;
    return 16 + draw_below(random, 85);
}

static void fail_case(const struct bundle *bundle, const char *what, size_t i, const struct reference_hit *expected,
                      const struct reference_hit *got)
{
    char text[500];
    snprintf(text, sizeof text, "%s, %s, mask %#x", bundle->name, what,
             (unsigned)(bundle->has_masks ? bundle->masks[i] : bundle->common_mask));
    print_difference(&bundle->world->fixture, text, i, &bundle->list.rays[i], expected, got);
    print_error("  again: test_bundles 1 %llu\n", (unsigned long long)bundle->world->fixture.seed);
    fail();
}

/* Method ray against the reference, in up to 48 rays. */
static void judge(struct bundle *bundle, struct random *random)
{
    const size_t step = bundle->list.count / 48 + 1;
    for (size_t i = draw_below(random, (uint32_t)step); i < bundle->list.count; i += step) {
        const uint32_t mask = bundle->has_masks ? bundle->masks[i] : bundle->common_mask;
        struct reference_hit hit;
        reference_trace(visible_part(bundle->world, mask), &bundle->list.rays[i], &hit);
        if (!same_hit(&hit, &bundle->expected[i])) fail_case(bundle, "method ray", i, &hit, &bundle->expected[i]);
        judged_count++;
    }
}

static void check_closest(const struct bundle *bundle, const mlrt_rays *rays, const mlrt_trace_options *options,
                          struct random *random, const char *text)
{
    const size_t count = bundle->list.count;
    const struct output output = draw_output(random);
    const size_t size = output_size(&output, count);
    unsigned char *wanted = allocate_or_fail(size, 1), *got = allocate_guarded(size);
    const mlrt_hits hits = hits_of_output(&output, got, count);
    fill_expected(&output, bundle->expected, count, wanted);
    memset(got, 0x77, size);
    assert_int_equal(mlrt_trace_packet(bundle->world->fixture.tree, rays, options, &hits), MLRT_OK);
    for (size_t i = 0; i < count && memcmp(got, wanted, size) != 0; i++) {
        struct reference_hit hit;
        read_output(&output, got, bundle->expected, i, count, &hit);
        if (!same_hit(&hit, &bundle->expected[i])) fail_case(bundle, text, i, &bundle->expected[i], &hit);
    }
    if (memcmp(got, wanted, size) != 0)
        fail_msg("case %llu, %s: bytes between results were written", (unsigned long long)bundle->world->fixture.seed,
                 text);
    free_guarded(got, size);
    free(wanted);
    answer_count += count;
}

static void check_any(const struct bundle *bundle, const mlrt_rays *rays, const mlrt_trace_options *options,
                      struct random *random, const char *text)
{
    static const size_t strides[] = {0, 0, 3, 4, 32};
    const size_t count = bundle->list.count, given = strides[draw_below(random, 5)], stride = given ? given : 1;
    const size_t size = (count - 1) * stride + 1;
    unsigned char *got = allocate_guarded(size);
    const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {got, given, 0}};
    memset(got, 0x77, size);
    assert_int_equal(mlrt_trace_packet(bundle->world->fixture.tree, rays, options, &hits), MLRT_OK);
    for (size_t i = 0; i < size; i++) {
        const size_t ray = i / stride;
        const int expected = i % stride ? 0x77 : bundle->expected[ray].mesh != MLRT_NONE;
        if (got[i] == expected) continue;
        const struct reference_hit hit = {.t = got[i], .mesh = got[i] ? 0 : MLRT_NONE, .triangle = MLRT_NONE};
        fail_case(bundle, text, ray, &bundle->expected[ray], &hit);
    }
    free_guarded(got, size);
    answer_count += count;
}

/* Closest and any hit, each with arrays of one layout and results of another. */
static void check_way(const struct bundle *bundle, struct random *random, struct bundle_shape shape, int32_t method,
                      int32_t isa)
{
    static const char *const isas[] = {"auto", "scalar", "sse", "avx2", "avx512", "neon"};
    const size_t layout = draw_below(random, 4) ? draw_below(random, LAYOUT_COUNT) : 0;
    const uint32_t fields = bundle->fields | (draw_below(random, 3) ? 0 : 1u << (T_MIN + draw_below(random, 3)));
    const uint32_t threads = draw_below(random, 16) ? 0 : 2;
    struct arrays arrays = make_arrays(&bundle->list, bundle->masks, fields, &layouts[layout]);
    arrays.rays.row_length = draw_row_length(random, shape);
    mlrt_trace_options options = {.struct_size = sizeof options,
                                  .method = method,
                                  .isa = isa,
                                  .mask = bundle->common_mask,
                                  .pool = shared_pool(threads)};
    char text[160];
    snprintf(text, sizeof text, "%s, %s, layout %zu, row_length %u, %u threads",
             method == MLRT_METHOD_RAY ? "method ray" : "tile", isas[isa], layout, (unsigned)arrays.rays.row_length,
             (unsigned)threads);
    check_closest(bundle, &arrays.rays, &options, random, text);
    options.query = MLRT_QUERY_ANY;
    strcat(text, ", any hit");
    check_any(bundle, &arrays.rays, &options, random, text);
    free_arrays(&arrays);
}

static int has_isa(int32_t isa)
{
    static signed char known[MLRT_ISA_NEON + 1];
    if (!known[isa]) known[isa] = isa_is_supported(isa) ? 1 : -1;
    return known[isa] > 0;
}

static void make_bundle(struct bundle *bundle, size_t kind, struct bundle_shape shape, struct random *random)
{
    struct world *world = bundle->world;
    const struct fixture *fixture = &world->fixture;
    add_bundle_rays(&bundle->list, random, fixture, kind, shape);
    stretch_directions(&bundle->list, random);
    spoil_bundle(&bundle->list, random, fixture);
    bundle->expected = allocate_or_fail(shape.count, sizeof *bundle->expected);
    bundle->masks = allocate_or_fail(shape.count, sizeof *bundle->masks);
    bundle->has_masks = set_masks(bundle->masks, shape.count, random, &bundle->common_mask);
    const uint32_t *masks = bundle->has_masks ? bundle->masks : NULL;
    trace_rays_singly(fixture->tree, &bundle->list, masks, bundle->common_mask, bundle->expected);
    set_ranges(&bundle->list, random, bundle->expected);
    set_skips(&bundle->list, random, world, bundle->expected);
    trace_rays_singly(fixture->tree, &bundle->list, masks, bundle->common_mask, bundle->expected);
    bundle->fields = needed_fields(&bundle->list, bundle->has_masks);
    snprintf(bundle->name, sizeof bundle->name, "rays that %s, %zu in rows of %u", bundle_kind_name(kind), shape.count,
             (unsigned)shape.width);
}

static void run_case(uint64_t number)
{
    struct random random = {number};
    struct bundle bundle = {.world = find_world(number / bundle_kind_count())};
    const struct bundle_shape shape = draw_shape(&random);
    bundle.world->fixture.seed = number;
    make_bundle(&bundle, number % bundle_kind_count(), shape, &random);
    judge(&bundle, &random);
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
        if (has_isa(isa)) check_way(&bundle, &random, shape, MLRT_METHOD_DEFAULT, isa);
    }
    if (number % 8 == 0) check_way(&bundle, &random, shape, MLRT_METHOD_RAY, MLRT_ISA_AUTO);
    ray_count += shape.count;
    free_rays(&bundle.list);
    free(bundle.expected);
    free(bundle.masks);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* One kind of bundle in every scene. */
static void check_kind(void **state)
{
    const size_t kind = *(const size_t *)*state;
    for (size_t i = 0; i < scaled(2 * SCENE_COUNT); i++) run_case(kind + bundle_kind_count() * i);
}

static void run_cases(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < case_count; i++) {
        run_case(first_case + i);
        if ((i + 1) % 10000 == 0)
            print_message("%llu cases, %llu answers\n", (unsigned long long)i + 1, (unsigned long long)answer_count);
    }
}

int main(int argc, char **argv)
{
    static struct CMUnitTest tests[64];
    static size_t numbers[64];
    const struct CMUnitTest all[] = {cmocka_unit_test(run_cases)};
    int failures;
    for (size_t i = 0; i < bundle_kind_count(); i++) {
        numbers[i] = i;
        tests[i] = (struct CMUnitTest){bundle_kind_name(i), check_kind, NULL, NULL, &numbers[i]};
    }
    if (argc > 1) case_count = strtoull(argv[1], NULL, 10);
    if (argc > 2) first_case = strtoull(argv[2], NULL, 10);
    if (case_count)
        failures = cmocka_run_group_tests(all, NULL, free_worlds);
    else
        failures = _cmocka_run_group_tests("rays that", tests, bundle_kind_count(), NULL, free_worlds);
    printf("%llu rays, %llu answers compared, %llu of the rays with the reference\n", (unsigned long long)ray_count,
           (unsigned long long)answer_count, (unsigned long long)judged_count);
    return failures;
}
