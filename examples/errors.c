/* SPDX-License-Identifier: MIT */
/*
 * errors.c - maps of where ray tracing methods are wrong, in false colours, beside pictures of the scenes
 *
 *     errors -o errors.png
 *
 * A row for each scene where float arithmetic is at its limits, a column for each method. Each pixel is a ray; its
 * answer is compared with exact arithmetic (study/oracle.h), and t with the correctly rounded one. Under each map
 * stands the number of wrong answers, without those where only t is rounded otherwise.
 *
 * Exit codes: 0, 1 if something failed or the library was wrong anywhere, 2 for a mistake on the command line.
 */
#include "common/label.h"
#include "common/must.h"
#include "common/options.h"
#include "common/png_write.h"
#include "common/report.h"
#include "common/terminal.h"
#include "common/view.h"
#include "study/guess.h"
#include "study/meshes.h"
#include "study/method.h"
#include "study/oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))

/* ---- scenes -------------------------------------------------------------------------------------------------- */

/* Makes a scene and looks at it: from `eye` at `target`, `size` wide and high there, in the scene's units. */
struct look {
    double eye[3], target[3], right[3], down[3];
    double size[2];
};

typedef int (*scene_maker)(struct scene *scene, struct look *look);

static const float *corner_of(const struct scene *scene, size_t triangle, int corner)
{
    return scene->vertices + 3 * (size_t)scene->indices[3 * triangle + (size_t)corner];
}

// How much a triangle faces a point: the sine of the angle at which it is seen; below 0 its back is.
static double facing(const struct scene *scene, size_t triangle, const double eye[3])
{
    const float *a = corner_of(scene, triangle, 0), *b = corner_of(scene, triangle, 1),
                *c = corner_of(scene, triangle, 2);
    double normal[3], sum = 0, length = 0;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        normal[k] = ((double)b[i] - a[i]) * ((double)c[j] - a[j]) - ((double)b[j] - a[j]) * ((double)c[i] - a[i]);
        length += normal[k] * normal[k];
        sum += normal[k] * (eye[k] - a[k]);
    }
    return sum / sqrt(length);
}

// The first edge of a front whose other triangle shows its back: part of the outline.
static int find_outline(const struct scene *scene, const double eye[3], const float *edge[2])
{
    for (size_t front = 0; front < scene->triangle_count; front++) {
        const double angle = facing(scene, front, eye);
        for (int side = 0; side < 3 && angle > 0 && angle < 0.02; side++) {
            const uint32_t from = scene->indices[3 * front + (size_t)side],
                           to = scene->indices[3 * front + (size_t)(side + 1) % 3];
            for (size_t back = 0; back < scene->triangle_count; back++) {
                for (size_t other = 0; other < 3; other++) {
                    if (scene->indices[3 * back + other] != to || scene->indices[3 * back + (other + 1) % 3] != from)
                        continue;
                    if (facing(scene, back, eye) >= 0) continue;
                    edge[0] = corner_of(scene, front, side), edge[1] = corner_of(scene, front, (side + 1) % 3);
                    return 0;
                }
            }
        }
    }
    return 1;
}

// An edge in the outline of a unit sphere, along its whole length, but only a few millionths across: the triangle next
// to it is seen at an angle of less than 1.2 degrees.
static int make_rim(struct scene *scene, struct look *look)
{
    const float *edge[2];
    *look = (struct look){.eye = {0, 0, 3}, .size = {2e-6, 0}};
    if (make_sphere(SPHERE_LEVEL, NULL, scene) || find_outline(scene, look->eye, edge)) return 1;
    double ahead[3], length = 0;
    for (int k = 0; k < 3; k++) {
        look->target[k] = 0.5 * edge[0][k] + 0.5 * edge[1][k];
        look->down[k] = (double)edge[1][k] - edge[0][k];
        ahead[k] = look->target[k] - look->eye[k];
        length += look->down[k] * look->down[k];
    }
    for (int k = 0; k < 3; k++) {
        look->right[k] = ahead[(k + 1) % 3] * look->down[(k + 2) % 3] - ahead[(k + 2) % 3] * look->down[(k + 1) % 3];
    }
    look->size[1] = 0.9 * sqrt(length);
    return 0;
}

static int make_far_sphere(double shift, struct scene *scene, struct look *look)
{
    const struct placement placement = {1, shift};
    *look = (struct look){{0, 0, 4}, {0, 0, 0}, {1, 0, 0}, {0, -1, 0}, {2.4, 2.4}};
    for (int k = 0; k < 3; k++) look->eye[k] += shift, look->target[k] += shift;
    return make_sphere(SPHERE_LEVEL, &placement, scene);
}

static int make_far(struct scene *scene, struct look *look)
{
    return make_far_sphere(2e5, scene, look);
}

static int make_farther(struct scene *scene, struct look *look)
{
    return make_far_sphere(2e6, scene, look);
}

static int make_slivers(struct scene *scene, struct look *look)
{
    enum { ROWS = 24 };
    const double aspect = 4e5;
    double normal[3], axes[2][3];
    const int failed = make_sheet(1, ROWS, 2, 2 / aspect, scene, normal, axes);
    *look = (struct look){.size = {2.1, 2.1 * ROWS / aspect}};
    for (int k = 0; k < 3; k++) {
        look->eye[k] = 2 * normal[k] + 1.5 * axes[0][k];
        look->right[k] = axes[0][k];
        look->down[k] = axes[1][k];
    }
    return failed;
}

static int make_doubled_room(struct scene *scene, struct look *look)
{
    const int failed = load_scene("doubled", scene);
    mlrt_camera camera;
    if (failed || camera_of_view(&scene->view, 2, 2, &camera)) return 1;
    for (int k = 0; k < 3; k++) {
        look->eye[k] = scene->view.eye[k];
        look->target[k] = (double)camera.eye[k] + camera.d00[k] + camera.dx[k] + camera.dy[k];
        look->right[k] = camera.dx[k], look->down[k] = camera.dy[k];
    }
    look->size[0] = look->size[1] = 2 * tan(scene->view.vfov * 0.008726646259971648);
    return 0;
}

static const struct {
    const char *title;
    scene_maker make;
} cases[] = {
    {"rim of a sphere", make_rim},          {"100 000 sizes off", make_far},      {"1000 000 sizes off", make_farther},
    {"slivers 1 to 400 000", make_slivers}, {"doubled walls", make_doubled_room},
};

static void normalize(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] /= length;
}

static mlrt_camera camera_of_look(struct look *look, uint32_t side)
{
    mlrt_camera camera = {
        .struct_size = sizeof camera, .width = side, .height = side, .sample_x = 0.5f, .sample_y = 0.5f};
    normalize(look->right);
    normalize(look->down);
    for (int k = 0; k < 3; k++) {
        const double dx = look->right[k] * look->size[0] / side, dy = look->down[k] * look->size[1] / side;
        camera.eye[k] = (float)look->eye[k];
        camera.dx[k] = (float)dx;
        camera.dy[k] = (float)dy;
        camera.d00[k] = (float)(look->target[k] - (double)camera.eye[k] - 0.5 * side * (dx + dy));
    }
    return camera;
}

static int make_rays(const mlrt_camera *camera, struct ray_set *rays)
{
    if (allocate_rays((size_t)camera->width * camera->height, rays)) return 1;
    rays->row_length = camera->width;
    rays->is_picture = 1;
    rays->camera = *camera;
    const mlrt_array origins = {rays->origins, 0, 0}, directions = {rays->directions, 0, 0};
    return has_failed(mlrt_camera_rays(camera, &origins, &directions), "make the camera's rays");
}

/* ---- pictures ------------------------------------------------------------------------------------------------ */

enum { MARGIN = 8, LABEL = 2, HEAD = 2 * LABEL_HEIGHT + MARGIN };

// Colours that people with any kind of colour vision tell apart: M. Okabe, K. Ito, "Color Universal Design", 2008.
static const struct {
    const char *title;
    uint8_t rgb[3];
} kinds[ERROR_KIND_COUNT] = {
    [RIGHT] = {"right", {38, 38, 42}},
    [HOLE] = {"missed", {240, 228, 66}},
    [GHOST] = {"hit nothing there", {204, 121, 167}},
    [WRONG_TRIANGLE] = {"wrong triangle", {213, 94, 0}},
    [WRONG_ORDER] = {"wrong order", {86, 180, 233}},
    [ROUNDED_T] = {"only t rounded otherwise", {72, 84, 80}},
};

struct page {
    struct canvas canvas;
    uint32_t side; // of a map
    int failed, guilty;
};

static void set_pixel(const struct page *page, uint32_t left, uint32_t top, size_t i, const uint8_t rgb[3])
{
    const size_t x = left + i % page->side, y = top + i / page->side;
    memcpy(page->canvas.rgb + 3 * (y * page->canvas.width + x), rgb, 3);
}

// The right answers as a picture: a grey for each triangle by the angle at which it is seen, black for none.
static void draw_scene(const struct page *page, uint32_t left, uint32_t top, const struct scene *scene,
                       const struct ray_set *rays, const uint32_t *right)
{
    for (size_t i = 0; i < rays->count; i++) {
        uint8_t rgb[3] = {0, 0, 0};
        if (right[i] != MLRT_NONE) {
            double e[2][3], n[3], d[3];
            const uint32_t *corners = scene->indices + 3 * (size_t)right[i];
            for (int k = 0; k < 3; k++) {
                const double a = scene->vertices[3 * (size_t)corners[0] + (size_t)k];
                e[0][k] = scene->vertices[3 * (size_t)corners[1] + (size_t)k] - a;
                e[1][k] = scene->vertices[3 * (size_t)corners[2] + (size_t)k] - a;
                d[k] = rays->directions[i][k];
            }
            for (int k = 0; k < 3; k++)
                n[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
            normalize(n), normalize(d);
            const double shade = fabs(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]);
            const uint32_t tint = right[i] * 2654435761u >> 28; // neighbours differ a little
            rgb[0] = rgb[1] = rgb[2] = (uint8_t)(50 + 175 * shade + tint);
        }
        set_pixel(page, left, top, i, rgb);
    }
}

static void draw_errors(struct page *page, uint32_t left, uint32_t top, const struct subject *subject,
                        const struct ray_set *rays, const struct answers *right, const struct method *method,
                        const struct answers *answers)
{
    size_t counts[ERROR_KIND_COUNT] = {0};
    char text[32];
    for (size_t i = 0; i < rays->count; i++) {
        const enum error_kind kind =
            sort_answer(subject, rays, i, right->triangles[i], right->t[i], answers->triangles[i], answers->t[i]);
        counts[kind]++;
        set_pixel(page, left, top, i, kinds[kind].rgb);
    }
    const size_t wrong = rays->count - counts[RIGHT] - counts[ROUNDED_T];
    page->guilty |= method->is_ours && (wrong || counts[ROUNDED_T]);
    snprintf(text, sizeof text, "%zu wrong", wrong);
    draw_label(&page->canvas, (int)left, (int)(top + page->side + 4), LABEL, text);
    printf("%s,%s,%zu", subject->name, method->name, rays->count);
    for (int kind = 1; kind < ERROR_KIND_COUNT; kind++) printf(",%zu", counts[kind]);
    putchar('\n');
    fflush(stdout);
}

static void draw_case(struct page *page, size_t number, const struct method *const *methods, size_t method_count)
{
    struct subject subject = {.kdtree = NULL};
    struct ray_set rays = {.count = 0};
    struct look look = {.size = {0}};
    const uint32_t top = HEAD + (uint32_t)number * (page->side + 2 * HEAD);
    show_work("%s ...", cases[number].title);
    snprintf(subject.name, sizeof subject.name, "%s", cases[number].title);
    int failed = cases[number].make(&subject.scene, &look) || complete_subject(&subject);
    const mlrt_camera camera = camera_of_look(&look, page->side);
    failed = failed || make_rays(&camera, &rays);
    const size_t count = rays.count ? rays.count : 1;
    const struct answers right = {malloc(count * sizeof(uint32_t)), malloc(count * sizeof(float))};
    const struct answers answers = {malloc(count * sizeof(uint32_t)), malloc(count * sizeof(float))};
    failed = failed || !right.triangles || !right.t || !answers.triangles || !answers.t;
    if (!failed) {
        ask_oracle_for_t(&subject, &rays, right.triangles, right.t);
        draw_scene(page, MARGIN, top, &subject.scene, &rays, right.triangles);
        draw_label(&page->canvas, MARGIN, (int)(top + page->side + 4), LABEL, cases[number].title);
    }
    for (size_t m = 0; m < method_count && !failed; m++) {
        struct method_run run = {methods[m], &subject, NULL, largest_component(&rays)};
        failed = run.method->create && run.method->create(&run);
        if (!failed) {
            run.method->trace(&run, &rays, &answers);
            clear_work();
            draw_errors(page, MARGIN + (uint32_t)(m + 1) * (page->side + MARGIN), top, &subject, &rays, &right,
                        methods[m], &answers);
        }
        if (run.method->destroy) run.method->destroy(&run);
    }
    page->failed |= failed;
    free(right.triangles), free(right.t), free(answers.triangles), free(answers.t);
    free_rays(&rays);
    free_subject(&subject);
}

static void draw_legend(const struct page *page, uint32_t top)
{
    uint32_t x = MARGIN;
    for (int kind = 0; kind < ERROR_KIND_COUNT; kind++) {
        for (uint32_t j = 0; j < 2 * LABEL_HEIGHT; j++) {
            for (uint32_t i = 0; i < 20 && x + i < page->canvas.width; i++)
                memcpy(page->canvas.rgb + 3 * ((size_t)(top + j) * page->canvas.width + x + i), kinds[kind].rgb, 3);
        }
        draw_label(&page->canvas, (int)x + 26, (int)top, LABEL, kinds[kind].title);
        x += 26 + LABEL * LABEL_WIDTH * ((uint32_t)strlen(kinds[kind].title) + 3);
    }
}

/* ---- command line -------------------------------------------------------------------------------------------- */

// Names of columns that fit; methods that this build lacks are left out.
static const struct {
    const char *method, *title;
} columns[] = {{"mt_boxes", "Moeller-Trumbore"},   {"tinybvh", "tinybvh 1.6"},      {"embree_fast", "Embree fast"},
               {"embree_robust", "Embree robust"}, {"guess_tile", "mlrt guessing"}, {"mlrt_tile", "mlrt"}};

int main(int argc, char **argv)
{
    const char *output = "errors.png", *guess = NULL;
    uint32_t side = 208;
    const struct option options[] = {
        {OPTION_TEXT, "--guess", &guess, "FILE.so", "the library as `make GUESS=1 library` builds it: one more column",
         0, 0},
        {OPTION_COUNT, "--side", &side, "N", "pixels of the side of a map, a multiple of 16 (default: 208)", 16, 1024},
        {OPTION_TEXT, "-o", &output, "FILE.png", "where the maps go (default: errors.png)", 0, 0},
    };
    int exit_code;
    if (!parse_options("errors - maps of where ray tracing methods are wrong", options, LENGTH(options), argc, argv,
                       &exit_code))
        return exit_code;
    if (side % 16) fprintf(stderr, "--side: a multiple of 16\n");
    if (side % 16 || check_png_name(output) || (guess && load_guess(guess))) return 2;
    const struct method *methods[LENGTH(columns)];
    const char *titles[LENGTH(columns)];
    size_t count = 0;
    for (size_t i = 0; i < LENGTH(columns); i++) {
        const struct method *method = find_method(columns[i].method);
        if (!method || (strncmp(method->name, "guess", 5) == 0 && !guess)) continue;
        titles[count] = columns[i].title;
        methods[count++] = method;
    }
    struct page page = {.side = side};
    page.canvas.width = MARGIN + (uint32_t)(count + 1) * (side + MARGIN);
    page.canvas.height = HEAD + (uint32_t)LENGTH(cases) * (side + 2 * HEAD) + HEAD;
    page.canvas.rgb = calloc((size_t)page.canvas.width * page.canvas.height, 3);
    if (!page.canvas.rgb) {
        fprintf(stderr, "not enough memory\n");
        return 1;
    }
    puts("scene,method,rays,missed,ghost,wrong_triangle,wrong_order,rounded_t");
    for (size_t m = 0; m < count; m++)
        draw_label(&page.canvas, (int)(MARGIN + (uint32_t)(m + 1) * (side + MARGIN)), 4, LABEL, titles[m]);
    for (size_t i = 0; i < LENGTH(cases) && !page.failed; i++) draw_case(&page, i, methods, count);
    draw_legend(&page, page.canvas.height - HEAD);
    const int failed = page.failed || write_png(output, page.canvas.width, page.canvas.height, page.canvas.rgb);
    free(page.canvas.rgb);
    if (page.guilty) fputs("the library was wrong: see the table\n", stderr);
    return end_output(failed || page.guilty);
}
