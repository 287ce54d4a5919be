/* SPDX-License-Identifier: MIT */
/* shade.c - colours for a tile of hits: see shade.h */
#include "shade.h"

#include <math.h>

uint32_t shading_outputs(const struct shading *shading)
{
    return MLRT_OUTPUT_IDS | MLRT_OUTPUT_FACING | (shading->shadows ? MLRT_OUTPUT_UV | MLRT_OUTPUT_OCCLUDED : 0);
}

/* ---- tone ---------------------------------------------------------------------------------------------------- */

static const float brightest = 2; // what `tone` goes up to

// Linear light to sRGB. Up to 0.6 it stays as it is; from there on it nears white, but reaches it nowhere.
void start_shading(struct shading *shading)
{
    const int count = sizeof shading->tone;
    for (int i = 0; i < count; i++) {
        double x = (double)brightest * i / (count - 1), y = x <= 0.6 ? x : 1 - 0.4 * exp((0.6 - x) / 0.4);
        double encoded = y <= 0.0031308 ? 12.92 * y : 1.055 * pow(y, 1 / 2.4) - 0.055;
        shading->tone[i] = (uint8_t)(255 * encoded + 0.5);
    }
}

static void store_pixel(const struct shading *shading, size_t pixel, const float light[3])
{
    const float scale = (float)(sizeof shading->tone - 1) / brightest;
    for (int k = 0; k < 3; k++) {
        float x = light[k] < brightest ? light[k] : brightest;
        shading->rgb[3 * pixel + k] = shading->tone[(size_t)(x * scale)];
    }
}

/* ---- light --------------------------------------------------------------------------------------------------- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static const float *corner(const struct scene *scene, uint32_t triangle, int i)
{
    return scene->vertices + 3 * (size_t)scene->indices[3 * (size_t)triangle + i];
}

// What neighbouring pixels on the same triangle have in common. Light = fill (base + slope cos) + lamp received + glow.
struct surface {
    uint32_t triangle;
    int32_t facing; // 0 = none yet
    double normal[3];
    float fill[3], lamp[3], glow[3];
};

// The unit normal on the side that the ray came from. In double: the products of small triangles' edges leave float.
static void facing_normal(const struct scene *scene, uint32_t triangle, int32_t facing, double normal[3])
{
    const float *a = corner(scene, triangle, 0), *b = corner(scene, triangle, 1), *c = corner(scene, triangle, 2);
    double ab[3], ac[3];
    for (int k = 0; k < 3; k++) ab[k] = (double)b[k] - a[k], ac[k] = (double)c[k] - a[k];
    normal[0] = ab[1] * ac[2] - ab[2] * ac[1];
    normal[1] = ab[2] * ac[0] - ab[0] * ac[2];
    normal[2] = ab[0] * ac[1] - ab[1] * ac[0];
    double length = sqrt(dot(normal, normal)), scale = length > 0 ? -facing / length : 0;
    for (int k = 0; k < 3; k++) normal[k] *= scale;
}

static struct material material_of(const struct scene *scene, uint32_t triangle, const double normal[3])
{
    static const struct material cool = {{0.33f, 0.43f, 0.60f}, 0}, warm = {{0.84f, 0.68f, 0.47f}, 0};
    if (scene->material_ids) return scene->materials[scene->material_ids[triangle]];
    // Warm towards the upper left, where the light of most views is.
    float share = (float)(0.5 - 0.25 * normal[0] + 0.4 * normal[1] + 0.17 * normal[2]);
    struct material tint = {{0}, 0};
    for (int k = 0; k < 3; k++) tint.colour[k] = cool.colour[k] + (warm.colour[k] - cool.colour[k]) * share;
    return tint;
}

static void set_surface(struct surface *surface, const struct scene *scene, uint32_t triangle, int32_t facing)
{
    static const float sky[3] = {0.92f, 1.00f, 1.12f}, ground[3] = {1.10f, 0.98f, 0.86f},
                       lamp[3] = {1.60f, 1.36f, 1.06f};
    // A light that does not fade is as bright on everything as one that does is at most, so it is weaker at its source.
    float strength = scene->light_range > 0 ? 1 : 0.62f;
    surface->triangle = triangle;
    surface->facing = facing;
    facing_normal(scene, triangle, facing, surface->normal);
    struct material material = material_of(scene, triangle, surface->normal);
    float above = (float)(0.5 + 0.5 * surface->normal[1]);
    for (int k = 0; k < 3; k++) {
        surface->fill[k] = material.colour[k] * (ground[k] + (sky[k] - ground[k]) * above);
        surface->lamp[k] = material.colour[k] * lamp[k] * strength;
        surface->glow[k] = material.colour[k] * material.glow;
    }
}

// The light that reaches a hit, 0..1: by the angle, and by the distance if the scene says so.
static double light_received(const struct shading *shading, const struct surface *surface, double u, double v)
{
    const struct scene *scene = shading->scene;
    const float *a = corner(scene, surface->triangle, 0), *b = corner(scene, surface->triangle, 1);
    const float *c = corner(scene, surface->triangle, 2);
    double to_light[3];
    for (int k = 0; k < 3; k++) to_light[k] = shading->view->light[k] - ((1 - u - v) * a[k] + u * b[k] + v * c[k]);
    double cosine = dot(to_light, surface->normal), square = dot(to_light, to_light);
    if (cosine <= 0) return 0;
    double range = scene->light_range, share = range > 0 ? square / (range * range) : 0;
    return cosine / (sqrt(square) * (1 + share));
}

static void shade_hit(const struct shading *shading, const struct surface *surface, const double direction[3],
                      double received, float light[3])
{
    double towards_eye = -dot(surface->normal, direction) / sqrt(dot(direction, direction));
    float fill = (float)(shading->shadows ? 0.10 + 0.22 * towards_eye : 0.12 + 0.95 * towards_eye);
    for (int k = 0; k < 3; k++) {
        light[k] = surface->fill[k] * fill + surface->lamp[k] * (float)received + surface->glow[k];
    }
}

static void shade_miss(const struct shading *shading, uint32_t row, float light[3])
{
    static const float top[3] = {0.20f, 0.34f, 0.56f}, bottom[3] = {0.72f, 0.78f, 0.84f};
    float share = ((float)row + 0.5f) / (float)shading->camera->height;
    for (int k = 0; k < 3; k++) light[k] = top[k] + (bottom[k] - top[k]) * share;
}

/* ---- tiles --------------------------------------------------------------------------------------------------- */

int32_t shade_tile(void *user, const mlrt_tile *tile)
{
    const struct shading *shading = user;
    const mlrt_camera *camera = shading->camera;
    struct surface surface = {.facing = 0};
    size_t i = 0;
    for (uint32_t row = tile->y; row < tile->y + tile->height; row++) {
        for (uint32_t column = tile->x; column < tile->x + tile->width; column++, i++) {
            float light[3];
            if (tile->facing[i] == 0) {
                shade_miss(shading, row, light);
            } else {
                if (surface.triangle != tile->triangle[i] || surface.facing != tile->facing[i]) {
                    set_surface(&surface, shading->scene, tile->triangle[i], tile->facing[i]);
                }
                double x = column + 0.5, y = row + 0.5, direction[3], received = 0;
                for (int k = 0; k < 3; k++) direction[k] = camera->d00[k] + x * camera->dx[k] + y * camera->dy[k];
                if (shading->shadows && !tile->occluded[i]) {
                    received = light_received(shading, &surface, (double)tile->u[i], (double)tile->v[i]);
                }
                shade_hit(shading, &surface, direction, received, light);
            }
            store_pixel(shading, (size_t)row * camera->width + column, light);
        }
    }
    return 0;
}

/* ---- the least shading --------------------------------------------------------------------------------------- */

static void unit_normal(const struct scene *scene, uint32_t triangle, float normal[3])
{
    double exact[3] = {0, 0, 0};
    if (triangle != MLRT_NONE) facing_normal(scene, triangle, 1, exact);
    for (int k = 0; k < 3; k++) normal[k] = (float)exact[k];
}

static uint8_t grey_by_angle(const mlrt_camera *camera, uint32_t column, uint32_t row, const float normal[3])
{
    float x = (float)column + 0.5f, y = (float)row + 0.5f, product = 0, square = 0;
    for (int k = 0; k < 3; k++) {
        float d = camera->d00[k] + x * camera->dx[k] + y * camera->dy[k];
        product += d * normal[k];
        square += d * d;
    }
    float cosine = fabsf(product) / sqrtf(square);
    return (uint8_t)(255 * (cosine < 1 ? cosine : 1));
}

int32_t shade_tile_simply(void *user, const mlrt_tile *tile)
{
    const struct shading *shading = user;
    uint32_t triangle = MLRT_NONE;
    float normal[3] = {0, 0, 0};
    size_t i = 0;
    for (uint32_t row = tile->y; row < tile->y + tile->height; row++) {
        uint8_t *pixel = shading->rgba + 4 * ((size_t)row * shading->camera->width + tile->x);
        for (uint32_t column = tile->x; column < tile->x + tile->width; column++, i++, pixel += 4) {
            if (tile->triangle[i] != triangle) {
                triangle = tile->triangle[i];
                unit_normal(shading->scene, triangle, normal);
            }
            pixel[0] = pixel[1] = pixel[2] = grey_by_angle(shading->camera, column, row, normal);
            pixel[3] = 255;
        }
    }
    return 0;
}
