/* SPDX-License-Identifier: MIT */
/*
 * task.h - a scene with a view, and the rays of each kind that all contenders trace
 *
 * Any-hit kinds answer whether something is hit. "Numbers" are numbers of triangles.
 *
 *     frame      rays of the camera, made while tracing; the closest hit is shaded, into a picture
 *     lit        the same, and a shadow ray from each hit to the light: hits that it does not reach are darker
 *     primary    the rays of frame; numbers into an array
 *     shadow     any-hit: from the light to each hit of the view
 *     sun        any-hit: from each hit of the view, all in one direction
 *     array      the camera's rays, ready in arrays, in rows of pixels; numbers and distances into arrays
 *     list       the same as a plain list
 *     parallel   the same of a camera with parallel rays
 *     bounce     one ray from each hit in a random direction, cosine-weighted; numbers and distances into arrays
 *
 * Rays that a renderer makes by itself; those marked * are structs of 32 bytes with limits, in rows of pixels:
 *
 *     reach *    any-hit: from each hit of the view to the light
 *     mirror *   the reflections at the hits; numbers and distances
 *     lens       one ray for each pixel from a random point of a lens of f/8, focused on the median depth of the hits;
 *                arrays of origins and directions in rows of pixels; numbers and distances
 *     one-way *  any-hit: from each hit that faces one direction, in that direction, as long as a tenth of the scene's
 *                diagonal (a batch of ambient occlusion whose pixels share a sequence of directions)
 *     hemisphere any-hit: from each hit of every fourth pixel of every fourth row 16 rays in random directions,
 *                cosine-weighted, as long as a tenth of the diagonal; a list: arrays of origins, directions and ends
 *     record *   the camera's rays; distances, weights, numbers of meshes and triangles
 *
 * Rays in orders that other programs have, in lists whose rows, if they have any, the library is not told:
 *
 *     samples    the camera's rays: four at random of each 2x2 pixels, one after the other; numbers and distances
 *     curve      the camera's rays along a Morton curve; numbers and distances
 *     panorama   from the camera's place in all directions, by rows around its upward axis; numbers and distances
 *     area       any-hit: from each hit of the view to a random point of a light, in a cube around the point light as
 *                wide as 4 % of the diagonal; in rows of pixels
 *
 * One call for each ray, in a list of such structs:
 *
 *     single     the camera's ray and that of bounce by turns; numbers and distances
 *     single-any any-hit: the ray of reach and that of bounce by turns
 */
#ifndef TASK_H
#define TASK_H

#include "common/view.h"
#include "shade.h"

#include <mlrt.h>

enum kind {
    FRAME,
    LIT,
    PRIMARY,
    SHADOW,
    SUN,
    ARRAY,
    LIST,
    PARALLEL,
    BOUNCE,
    REACH,
    MIRROR,
    LENS,
    ONE_WAY,
    HEMISPHERE,
    RECORD,
    SAMPLES,
    CURVE,
    PANORAMA,
    AREA,
    SINGLE,
    SINGLE_ANY,
    KIND_COUNT,
    LIT_LESS_FRAME = KIND_COUNT
};

/* Kinds whose rays are made while they are traced. */
static inline int is_picture(enum kind kind)
{
    return kind == FRAME || kind == LIT || kind == PRIMARY;
}

/* Kinds that ask whether anything is hit, of points with triangles to pass. */
static inline int is_shadow(enum kind kind)
{
    return kind == SHADOW || kind == SUN;
}

/* Kinds that ask whether anything is hit, of rays. */
static inline int is_any(enum kind kind)
{
    return kind == REACH || kind == ONE_WAY || kind == HEMISPHERE || kind == AREA || kind == SINGLE_ANY;
}

/* Kinds whose answers are only whether something is hit. */
static inline int is_yes_or_no(enum kind kind)
{
    return is_shadow(kind) || is_any(kind);
}

/* Kinds with a call for each ray. */
static inline int is_single(enum kind kind)
{
    return kind == SINGLE || kind == SINGLE_ANY;
}

/*
 * Where Embree's shadow rays end that come from a light. Points are a rounding error off their surfaces, which the
 * library knows to skip; up to 1, Embree finds 3 to 30 % of the points to be shaded by the triangle that they lie on.
 */
#define SHADOW_END 0.9999f

extern const char *const kind_names[KIND_COUNT + 1];

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

/* Makes the table of normals of the subject's scene. Returns 0, or 1 after saying on stderr that memory is out. */
int make_normals(struct subject *subject);

static inline mlrt_light light_of(const struct subject *subject)
{
    const float *p = subject->light;
    return (mlrt_light){.struct_size = sizeof(mlrt_light), .kind = MLRT_LIGHT_POINT, .position = {p[0], p[1], p[2]}};
}

/* Pixel (column, row) of a camera: the arithmetic of mlrt.h. */
void camera_direction(const mlrt_camera *camera, uint32_t column, uint32_t row, float direction[3]);

/* A ray as a renderer may have it. */
struct ray_record {
    float origin[3]; /* NaN = there is none */
    float t_min;
    float direction[3];
    float t_max;
};

enum { HEMISPHERE_RAYS = 16 /* from each hit */ };

/* Rays by component, in an order that is good for packets; the arrays are filled up to a multiple of 16 rays. */
struct stream {
    size_t count;         /* without those that fill up */
    float *origins[3];    /* NULL = all start at `origin` */
    float *directions[3]; /* NULL = all have `direction` */
    float origin[3];
    float direction[3];
    float *t_mins;  /* NULL = all have `t_min` */
    float *t_maxes; /* NULL = all have `t_max` */
    float t_min;
    float t_max;
    uint32_t *elements; /* for each ray, the element of the caller's arrays that it is */
};

struct task {
    enum kind kind;
    const struct subject *subject;
    size_t ray_count;     /* rays that count: all elements but those without a point */
    size_t element_count; /* of the results */
    uint32_t row_length;  /* elements of a row of the picture; 0 = a list */
    float (*origins)[3];  /* shadow, sun: points, NaN where there is none; others: origins */
    float (*directions)[3];
    float *t_max;               /* NULL = rays do not end */
    float (*shared_origins)[3]; /* hemisphere: the origins once for all HEMISPHERE_RAYS neighbours that have them */
    struct ray_record *records; /* rays in place of those arrays; or NULL */
    float sun[3];               /* sun: the direction towards it */
    uint32_t (*skip)[2];        /* shadow, sun: the triangles that points lie on */
    struct stream stream;       /* not of pictures */
};

/* An element's ray, of kinds that have origins and directions. */
void get_ray(const struct task *task, size_t element, struct ray_record *ray);

/* Prepares the rays, using the pool. Returns 0, or 1 after a message on stderr. Free it either way. */
int make_task(enum kind kind, const struct subject *subject, const mlrt_tree *tree, mlrt_pool *pool, struct task *task);
void free_task(struct task *task);

/* What comes out: those arrays that a kind writes, an element each; the others are NULL. */
struct answers {
    uint32_t *triangles; /* MLRT_NONE = miss. Of frames, only when asked for as primary */
    float *t, *u, *v;
    uint32_t *mesh;
    uint8_t *occluded; /* lit: 1 = a hit that the light does not reach. Its `triangles` and this only without `rgba` */
    uint32_t *rgba;
};

/* Returns 0, or 1 after saying on stderr that there is not enough memory. Free it either way. */
int make_answers(const struct task *task, struct answers *answers);
void free_answers(struct answers *answers);

#endif
