/* SPDX-License-Identifier: MIT */
/* stability.c - where methods start to fail: see stability.h */
#include "stability.h"

#include "common/steady_math.h"
#include "meshes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))
#define PI            3.141592653589793

enum { CONDITION_SIZE = 64, SEED = 1 };

/* Makes the mesh and the rays of one value. Returns 0, or 1 after a message on stderr. */
typedef int (*case_maker)(double value, size_t ray_count, struct subject *subject, struct ray_set *rays);

/* ---- spheres ------------------------------------------------------------------------------------------------- */

static int make_placed_sphere(double scale, double shift, struct subject *subject)
{
    const struct placement placement = {scale, shift};
    strcpy(subject->name, "sphere");
    return make_sphere(SPHERE_LEVEL, &placement, &subject->scene) || complete_subject(subject);
}

static int make_aim(double generator, size_t ray_count, struct subject *subject, struct ray_set *rays)
{
    return make_placed_sphere(1, 0, subject) || generate_rays((enum generator)generator, subject, ray_count, rays);
}

static int make_shift(double shift, size_t ray_count, struct subject *subject, struct ray_set *rays)
{
    return make_placed_sphere(1, shift, subject) || generate_rays(GENERATE_SURFACE, subject, ray_count, rays);
}

static int make_scale(double scale, size_t ray_count, struct subject *subject, struct ray_set *rays)
{
    return make_placed_sphere(scale, 0, subject) || generate_rays(GENERATE_SURFACE, subject, ray_count, rays);
}

static int make_length(double length, size_t ray_count, struct subject *subject, struct ray_set *rays)
{
    if (make_shift(0, ray_count, subject, rays)) return 1;
    for (size_t i = 0; i < rays->count; i++) {
        for (int k = 0; k < 3; k++) rays->directions[i][k] = (float)(rays->directions[i][k] * length);
    }
    return 0;
}

/* ---- sheets -------------------------------------------------------------------------------------------------- */

struct sheet {
    double normal[3], axes[2][3];
    double size[2]; // its whole width and height
};

static int start_sheet(uint32_t columns, uint32_t rows, double width, double height, const char *name,
                       struct subject *subject, struct sheet *sheet)
{
    snprintf(subject->name, sizeof subject->name, "%s", name);
    sheet->size[0] = columns * width;
    sheet->size[1] = rows * height;
    return make_sheet(columns, rows, width, height, &subject->scene, sheet->normal, sheet->axes) ||
           complete_subject(subject);
}

/*
 * A ray to a random point of the sheet, at an angle with the given sine and cosine to it, from a random side of the
 * point, which is `distance` away.
 */
static void aim_at_sheet(const struct sheet *sheet, double sine, double cosine, double distance, uint32_t *random,
                         float origin[3], float direction[3])
{
    double x = random_between(random, -0.5, 0.5) * sheet->size[0],
           y = random_between(random, -0.5, 0.5) * sheet->size[1];
    double turns = random_between(random, 0, 1);
    double along[2] = {cosine * turn_cos(turns), cosine * turn_sin(turns)};
    for (int k = 0; k < 3; k++) {
        float target = (float)(x * sheet->axes[0][k] + y * sheet->axes[1][k]);
        double away = along[0] * sheet->axes[0][k] + along[1] * sheet->axes[1][k] + sine * sheet->normal[k];
        origin[k] = (float)(target + distance * away);
        direction[k] = (float)((double)target - origin[k]);
    }
}

static int make_slivers(double aspect, size_t ray_count, struct subject *subject, struct ray_set *rays)
{
    struct sheet sheet;
    uint32_t random = SEED;
    if (start_sheet(1, 512, 2, 2 / aspect, "slivers", subject, &sheet) || allocate_rays(ray_count, rays)) return 1;
    for (size_t i = 0; i < ray_count; i++) {
        double sine = random_between(&random, 0.2, 1); // not grazing: that is another sweep
        aim_at_sheet(&sheet, sine, sqrt(1 - sine * sine), 3, &random, rays->origins[i], rays->directions[i]);
    }
    return 0;
}

static int make_grazing(double degrees, size_t ray_count, struct subject *subject, struct ray_set *rays)
{
    struct sheet sheet;
    uint32_t random = SEED;
    double sine = sin(degrees * PI / 180), cosine = cos(degrees * PI / 180);
    if (start_sheet(32, 32, 0.0625, 0.0625, "sheet", subject, &sheet) || allocate_rays(ray_count, rays)) return 1;
    for (size_t i = 0; i < ray_count; i++) {
        aim_at_sheet(&sheet, sine, cosine, 2, &random, rays->origins[i], rays->directions[i]);
    }
    return 0;
}

/* ---- sweeps -------------------------------------------------------------------------------------------------- */

static const double aims[] = {GENERATE_RANDOM, GENERATE_SURFACE, GENERATE_EDGE,
                              GENERATE_VERTEX, GENERATE_AXIS,    GENERATE_SPLIT_PLANE};
static const double shifts[] = {0, 1, 1e1, 1e2, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6};
static const double scales[] = {1e-38, 1e-36, 1e-34, 1e-30, 1e-25, 1e-20, 1e-18, 1e-16, 1e-15, 1e-14,
                                1e-13, 1e-12, 1e-11, 1e-10, 1e-9,  1e-8,  1e-7,  1e-6,  1e-5,  1e-4,
                                1e-3,  1e-2,  1e-1,  1,     1e3,   1e6,   1e8,   1e9,   1e10,  1e11,
                                1e12,  1e14,  1e16,  1e18,  1e19,  1e20,  1e25,  1e30,  1e36,  1e38};
static const double lengths[] = {1e-30, 1e-25, 1e-20, 1e-18, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3,
                                 1e-2,  1e-1,  1,     1e1,   1e2,   1e5,   1e10,  1e15,  1e18, 1e20, 1e25, 1e30};
static const double aspects[] = {1, 1e1, 1e2, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6, 3e6, 1e7};
static const double angles[] = {90,   30,   10,   3,    1,    3e-1, 1e-1, 3e-2, 1e-2,
                                3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6};

static const struct sweep {
    const char *name;
    case_maker make;
    const double *values;
    size_t value_count;
} sweeps[] = {
    {"aim", make_aim, aims, LENGTH(aims)},
    {"shift", make_shift, shifts, LENGTH(shifts)},
    {"scale", make_scale, scales, LENGTH(scales)},
    {"length", make_length, lengths, LENGTH(lengths)},
    {"sliver", make_slivers, aspects, LENGTH(aspects)},
    {"grazing", make_grazing, angles, LENGTH(angles)},
};

// 1e+03 is written 1e3; generators by their names.
static void describe_case(const struct sweep *sweep, double value, char condition[CONDITION_SIZE])
{
    if (sweep->make == make_aim) {
        snprintf(condition, CONDITION_SIZE, "aim=%s", generator_name((enum generator)value));
        return;
    }
    int exponent = value == 0 ? 0 : (int)floor(log10(value) + 1e-9);
    if (exponent >= -2 && exponent <= 2)
        snprintf(condition, CONDITION_SIZE, "%s=%g", sweep->name, value);
    else
        snprintf(condition, CONDITION_SIZE, "%s=%.0fe%d", sweep->name, value / pow(10, exponent), exponent);
}

struct forwarding {
    const struct stability_case *which;
    stability_consumer consumer;
    void *user;
};

static void forward(void *user, size_t set, const struct selection *selection, const struct measurement *measurements)
{
    (void)set;
    const struct forwarding *forwarding = user;
    forwarding->consumer(forwarding->user, forwarding->which, selection, measurements);
}

static int run_case(const struct sweep *sweep, double value, size_t ray_count, const struct selection *selection,
                    stability_consumer consumer, void *user)
{
    struct subject subject = {.kdtree = NULL};
    struct ray_set rays = {.count = 0};
    char condition[CONDITION_SIZE];
    describe_case(sweep, value, condition);
    const struct stability_case which = {subject.name, condition};
    struct forwarding forwarding = {&which, consumer, user};
    int failed = sweep->make(value, ray_count, &subject, &rays) ||
                 measure_methods(&subject, &rays, 1, selection, 0, forward, &forwarding);
    free_rays(&rays);
    free_subject(&subject);
    return failed;
}

static const struct sweep *find_sweep(const char *word)
{
    size_t length = strcspn(word, ",");
    for (size_t i = 0; i < LENGTH(sweeps); i++) {
        if (strlen(sweeps[i].name) == length && strncmp(sweeps[i].name, word, length) == 0) return &sweeps[i];
    }
    fprintf(stderr, "--sweep %.*s: there is none of this name; they are", (int)length, word);
    for (size_t i = 0; i < LENGTH(sweeps); i++) fprintf(stderr, " %s", sweeps[i].name);
    fprintf(stderr, "\n");
    return NULL;
}

int run_sweeps(const struct word_list *names, size_t ray_count, const struct selection *selection,
               stability_consumer consumer, void *user)
{
    size_t count = names->count ? names->count : LENGTH(sweeps);
    int failed = 0;
    for (size_t i = 0; i < count; i++) {
        const struct sweep *sweep = names->count ? find_sweep(names->words[i]) : &sweeps[i];
        if (!sweep) return 1;
        for (size_t v = 0; v < sweep->value_count && !failed; v++) {
            failed = run_case(sweep, sweep->values[v], ray_count, selection, consumer, user);
        }
    }
    return failed;
}
