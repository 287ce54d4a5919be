/* SPDX-License-Identifier: MIT */
/*
 * task.h - a scene with a view, and the rays of each kind that all who take part are asked for
 *
 *     frame      rays of the camera, made while tracing; the closest hit, shaded, into a picture
 *     primary    the same rays, numbers of triangles into an array
 *     shadow     from the light to each hit of the view: is anything between
 *     sun        from each hit of the view in one direction: is anything there
 *     array      the camera's rays ready in arrays, in rows of pixels; numbers and distances into arrays
 *     list       the same as a plain list
 *     parallel   the rays of a camera with parallel rays instead, in arrays, in rows of pixels
 *     bounce     one ray from each hit in a random direction, cosine-weighted; numbers and distances into arrays
 */
#ifndef TASK_H
#define TASK_H

#include "common/view.h"
#include "shade.h"

#include <mlrt.h>

enum kind { FRAME, PRIMARY, SHADOW, SUN, ARRAY, LIST, PARALLEL, BOUNCE, KIND_COUNT };

/* Kinds that ask whether anything is hit, of points with triangles to pass. */
static inline int is_shadow(enum kind kind)
{
    return kind == SHADOW || kind == SUN;
}

extern const char *const kind_names[KIND_COUNT];

struct subject {
    char name[SCENE_NAME_SIZE];
    struct scene scene;
    mlrt_camera camera;
    size_t pixel_count;
    float light[3];
    struct normal *normals; /* one more than triangles */
};

/*
 * Loads a scene (those of scene.h, sphere, sphere:N or a file) and looks at it from `view` ("FILE.json:SCENE/VIEW") if
 * that is not NULL, else from the view that the file `views` has for it, or its own. Returns 0, or 1 after saying on
 * stderr what is wrong. Free it with free_subject either way.
 */
int load_subject(const char *word, const char *views, const char *view, struct subject *subject);

/* Sets up pictures of size x size pixels. */
int set_size(struct subject *subject, uint32_t size);

void free_subject(struct subject *subject);

/* Pixel (column, row) of a camera: the arithmetic of mlrt.h. */
void camera_direction(const mlrt_camera *camera, uint32_t column, uint32_t row, float direction[3]);

/* Rays by component, in an order that is good for packets; the arrays are filled up to a multiple of 16 rays. */
struct stream {
    size_t count;         /* without those that fill up */
    float *origins[3];    /* NULL = all start at `origin` */
    float *directions[3]; /* NULL = all have `direction` */
    float origin[3];
    float direction[3];
    float t_min;
    float t_max;
    uint32_t *elements; /* for each ray, the element of the caller's arrays that it is */
};

struct task {
    enum kind kind;
    const struct subject *subject;
    size_t ray_count;     /* rays that count: all elements but those without a point */
    size_t element_count; /* of the results */
    float (*origins)[3];  /* shadow, sun: points, NaN where there is none; others: origins */
    float (*directions)[3];
    float sun[3];         /* sun: the direction towards it */
    uint32_t (*skip)[2];  /* shadow, sun: the triangles that points lie on */
    struct stream stream; /* not for frame and primary */
};

/* Prepares the rays, using the pool. Returns 0, or 1 after saying on stderr what is wrong. Free it either way. */
int make_task(enum kind kind, const struct subject *subject, const mlrt_tree *tree, mlrt_pool *pool, struct task *task);
void free_task(struct task *task);

/* What comes out: those arrays that a kind writes, an element each; the others are NULL. */
struct answers {
    uint32_t *triangles; /* MLRT_NONE = miss. Of frames, only when asked for as primary */
    float *t;
    uint8_t *occluded;
    uint32_t *rgba;
};

/* Returns 0, or 1 after saying on stderr that there is not enough memory. Free it either way. */
int make_answers(const struct task *task, struct answers *answers);
void free_answers(struct answers *answers);

#endif
