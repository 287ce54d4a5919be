/* SPDX-License-Identifier: MIT */
/*
 * render.c - renders a scene to a PNG file; measures its time, counts its work, or hashes its answers
 *
 * The loop of an application: load triangles, build a tree, set up a camera, render tiles, and shade each tile in its
 * callback while the hits are in the cache. Exit codes: 0, 1 if something failed, 2 for a mistake on the command line.
 */
#define _POSIX_C_SOURCE 200112L

#include "common/hash.h"
#include "common/interior.h"
#include "common/map.h"
#include "common/must.h"
#include "common/options.h"
#include "common/png_write.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/shade.h"
#include "common/terminal.h"
#include "common/timer.h"
#include "common/tree.h"
#include "common/view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct settings {
    const char *scene, *view, *output;
    struct view camera; // fields that are not a number keep the scene's or the view's
    uint32_t size[2];
    struct tree_settings build;
    mlrt_trace_options trace;
    int culling_check;
    uint32_t threads, frames;
    int shadows, no_shade, stats, hash;
    int32_t map; // MAP_*
};

/* ---- command line -------------------------------------------------------------------------------------------- */

static int read_settings(struct settings *s, int argc, char **argv, int *exit_code)
{
    const struct option options[] = {
        {OPTION_HEADING, 0, 0, 0, "What to see:", 0, 0},
        {OPTION_TEXT, "--scene", &s->scene, "NAME|FILE",
         "room, office, building, doubled, scan, scan:N (about N triangles), or a mesh file:\nPLY, OBJ, STL, glTF, ... "
         "(default: office)",
         0, 0},
        {OPTION_TEXT, "--view", &s->view, "FILE.json:SCENE/VIEW", "a view from a file, instead of the scene's own", 0,
         0},
        {OPTION_VECTOR, "--eye", s->camera.eye, "x,y,z", "where the camera is", 0, 0},
        {OPTION_VECTOR, "--look", s->camera.look, "x,y,z", "the point in the middle of the picture", 0, 0},
        {OPTION_VECTOR, "--up", s->camera.up, "x,y,z", "what is up in the picture", 0, 0},
        {OPTION_NUMBER, "--fov", &s->camera.vfov, "degrees", "field of view from the lower to the upper edge", 0, 0},
        {OPTION_VECTOR, "--light", s->camera.light, "x,y,z", "where the light is", 0, 0},
        {OPTION_FLAG, "--shadows", &s->shadows, NULL, "light it, with hard shadows", 0, 0},
        {OPTION_SIZE, "--size", s->size, "WxH", "pixels (default: 1024x1024)", 1, 32768},
        {OPTION_CHOICE, "--map", &s->map, MAP_WORDS,
         "in false colours, with a legend: for the ray of each pixel alone, the nodes it opens,\nits triangle tests, "
         "the "
         "distance of its hit, what is left to exact methods, or its time",
         MAP_NODES, 0},
        {OPTION_TEXT, "-o", &s->output, "FILE.png", "where the picture goes", 0, 0},

        {OPTION_HEADING, 0, 0, 0, "How to trace it (the answers are the same from all):", 0, 0},
        {OPTION_CHOICE, "--method", &s->trace.method, "ray|packet2|packet4|multilevel|tile",
         "one ray at a time; of kd-trees 2x2 or 4x4 packets, or the multilevel\nalgorithm (default there); of boxes "
         "tiles "
         "(default there)",
         MLRT_METHOD_RAY, 0},
        {OPTION_CHOICE, "--isa", &s->trace.isa, "auto|scalar|sse|avx2|avx512|neon",
         "instruction set (default: auto, the best there is)", MLRT_ISA_AUTO, 0},
        {OPTION_COUNT, "--threads", &s->threads, "N", "threads; 0 = one per processor (default: 0)", 0,
         MAXIMUM_WORKERS},
        {OPTION_POWER_OF_TWO, "--its", &s->trace.initial_tile_size, "N", "initial tile size in pixels, a power of two",
         4, 1024},
        {OPTION_POWER_OF_TWO, "--mts", &s->trace.minimum_tile_size, "N", "minimum tile size in pixels, a power of two",
         4, 1024},
        {OPTION_COUNT, "--sf", &s->trace.split_factor, "4|16", "split factor: pieces that a tile is cut into", 4, 16},
        {OPTION_CHOICE, "--culling", &s->trace.culling, "inverse|direct",
         "planes of the cell against the beam (default), or\nplanes of the beam against the cell", MLRT_CULLING_INVERSE,
         0},
        {OPTION_FLAG, "--culling-check", &s->culling_check, NULL,
         "check cells that the culling test leaves undecided against all their faces", 0, 0},
        TREE_OPTIONS(s->build),

        {OPTION_HEADING, 0, 0, 0, "What to tell about it, as lines `name value` on standard output:", 0, 0},
        {OPTION_COUNT, "--frames", &s->frames, "N", "render N times; median time, frames and pixels per second", 1,
         1000000},
        {OPTION_FLAG, "--no-shade", &s->no_shade, NULL, "only find the hits, no colours: for measuring", 0, 0},
        {OPTION_FLAG, "--stats", &s->stats, NULL, "what tracing (without shadows) and building did, counted", 0, 0},
        {OPTION_FLAG, "--hash", &s->hash, NULL,
         "a number that stands for all hits (and one for the shadows): equal if\nand only if every bit is", 0, 0},
    };
    if (!parse_options("render - renders a scene of triangles", options, sizeof options / sizeof *options, argc, argv,
                       exit_code))
        return 0;
    const char *mistake = NULL;
    if (!s->output && !s->frames && !s->stats && !s->hash)
        mistake = "nothing to do: give -o FILE.png, --frames, --stats or --hash";
    if (s->map && (!s->output || s->no_shade || s->shadows || s->frames))
        mistake = "--map: needs -o, and neither shading nor --frames";
    if (s->output && s->no_shade) mistake = "--no-shade makes no picture for -o";
    if (s->camera.vfov <= 0 || s->camera.vfov >= 180) mistake = "--fov: between 0 and 180 degrees";
    if (s->trace.split_factor && s->trace.split_factor != 4 && s->trace.split_factor != 16)
        mistake = "--sf: either 4 or 16";
    if (s->trace.initial_tile_size && s->trace.minimum_tile_size > s->trace.initial_tile_size)
        mistake = "--mts: larger than --its";
    if (mistake) fprintf(stderr, "%s\n", mistake);
    *exit_code = 2;
    return !mistake && !(s->output && check_png_name(s->output)) && !check_tree_settings(&s->build);
}

static void forget_vector(double vector[3])
{
    vector[0] = vector[1] = vector[2] = NAN;
}

static void keep_given(double *vector, const double *given, int count)
{
    for (int k = 0; k < count; k++) vector[k] = isnan(given[k]) ? vector[k] : given[k];
}

// The scene's own view, replaced by the file's, replaced by what the command line gives.
static int choose_view(const struct settings *s, struct scene *scene)
{
    if (s->view) {
        if (read_view(s->view, &scene->view)) return 1;
        scene->light_range = 0;
    } else {
        look_from_inside(scene);
    }
    keep_given(scene->view.eye, s->camera.eye, 3);
    keep_given(scene->view.look, s->camera.look, 3);
    keep_given(scene->view.up, s->camera.up, 3);
    keep_given(scene->view.light, s->camera.light, 3);
    keep_given(&scene->view.vfov, &s->camera.vfov, 1);
    return 0;
}

/* ---- frames -------------------------------------------------------------------------------------------------- */

// All the results of a picture. Arrays that nobody asked for are NULL.
struct frame {
    float *t, *u, *v;
    uint32_t *mesh, *triangle;
    int32_t *facing;
    uint8_t *occluded, *rgb;
};

struct session {
    const struct settings *settings;
    struct scene scene;
    mlrt_tree *tree;
    mlrt_pool *pool;
    mlrt_camera camera;
    mlrt_light light;
    struct shading shading;
    struct frame frame;
    size_t pixel_count;
};

static int allocate_frame(struct session *session)
{
    const struct settings *s = session->settings;
    struct frame *frame = &session->frame;
    size_t n = session->pixel_count;
    int failed = 0;
    if (s->hash) {
        failed |= !(frame->t = malloc(n * sizeof(float))) || !(frame->u = malloc(n * sizeof(float)));
        failed |= !(frame->v = malloc(n * sizeof(float)));
    }
    if (s->hash || s->no_shade) {
        failed |= !(frame->mesh = malloc(n * sizeof(uint32_t))) || !(frame->triangle = malloc(n * sizeof(uint32_t)));
        failed |= s->shadows && !(frame->occluded = malloc(n));
    }
    if (!s->no_shade) failed |= !(frame->rgb = malloc(3 * n));
    if (failed) fprintf(stderr, "not enough memory for %zu pixels\n", n);
    return failed;
}

static void free_frame(struct frame *frame)
{
    free(frame->t);
    free(frame->u);
    free(frame->v);
    free(frame->mesh);
    free(frame->triangle);
    free(frame->occluded);
    free(frame->rgb);
}

// One picture. `everything`: all results go to the frame, for hashing; else only what the settings ask for.
static int render_frame(struct session *session, int everything, mlrt_counters *counters)
{
    const struct settings *s = session->settings;
    struct frame *frame = &session->frame;
    struct shading *shading = &session->shading;
    const int shades = !everything && !s->no_shade;
    mlrt_trace_options options = s->trace;
    shading->rgb = frame->rgb;
    shading->shadows = s->shadows && !counters;
    struct progress_line line = {.work = "rendering"};
    const mlrt_host host = host_with_progress(&line);
    options.struct_size = sizeof options;
    options.outputs = shades ? shading_outputs(shading) : 0;
    options.pool = session->pool;
    options.counters = counters;
    options.host = s->frames ? NULL : &host; // frames are measured
    if (shading->shadows) options.lights = &session->light, options.light_count = 1;

    mlrt_hits hits = {.struct_size = sizeof hits};
    if (everything) hits.t.data = frame->t, hits.u.data = frame->u, hits.v.data = frame->v;
    if (!shades) hits.mesh.data = frame->mesh, hits.triangle.data = frame->triangle;
    if (!shades && shading->shadows) hits.occluded.data = frame->occluded;
    int32_t status = mlrt_render_tiles(session->tree, &session->camera, &options, shades ? NULL : &hits,
                                       shades ? shade_tile : NULL, shading);
    clear_progress(&line);
    return has_failed(status, "render");
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Renders --frames pictures (one without it) and prints how long they took.
static int time_frames(struct session *session)
{
    uint32_t count = session->settings->frames ? session->settings->frames : 1;
    double *seconds = malloc(count * sizeof *seconds);
    int failed = !seconds;
    if (failed) fprintf(stderr, "not enough memory for %lu frames\n", (unsigned long)count);
    for (uint32_t i = 0; i < count && !failed; i++) {
        double start = seconds_now();
        failed = render_frame(session, 0, NULL);
        seconds[i] = seconds_now() - start;
    }
    if (!failed && session->settings->frames) {
        qsort(seconds, count, sizeof *seconds, compare_doubles);
        double median = 0.5 * (seconds[(count - 1) / 2] + seconds[count / 2]);
        print_count("frame_count", count);
        print_number("frame_milliseconds", 1e3 * median);
        print_number("fastest_frame_milliseconds", 1e3 * seconds[0]);
        print_number("frames_per_second", 1 / median);
        print_number("million_pixels_per_second", 1e-6 * (double)session->pixel_count / median);
    }
    free(seconds);
    return failed;
}

// Counts in a picture of its own, so that counting costs no measured time. It has no shadows.
static int print_stats(struct session *session)
{
    mlrt_counters primary = {.struct_size = sizeof primary};
    if (render_frame(session, 0, &primary)) return 1;
    print_counters("primary", &primary);
    mlrt_tree_info info = {.struct_size = sizeof info};
    must_succeed(mlrt_get_tree_info(session->tree, &info));
    print_tree_info(&info);
    return 0;
}

static int print_hashes(struct session *session)
{
    if (render_frame(session, 1, NULL)) return 1;
    const struct frame *frame = &session->frame;
    print_hash("hash", hash_hits(frame->mesh, frame->triangle, frame->t, frame->u, frame->v, session->pixel_count));
    if (session->settings->shadows) print_hash("shadow_hash", hash_bytes(frame->occluded, session->pixel_count));
    return 0;
}

/* ---- from the start to the end ------------------------------------------------------------------------------- */

static int prepare(struct session *session)
{
    const struct settings *s = session->settings;
    double start = seconds_now(), build_seconds;
    tell("loading %s ...", s->scene);
    if (load_scene(s->scene, &session->scene) || choose_view(s, &session->scene)) return 1;
    if (camera_of_view(&session->scene.view, s->size[0], s->size[1], &session->camera)) return 1;
    double load_seconds = seconds_now() - start;
    struct progress_line line = {.work = "building the tree"};
    const mlrt_host host = host_with_progress(&line);
    struct tree_settings build = s->build;
    build.host = &host;
    const int failed = build_tree(&session->scene, &build, &session->tree, &build_seconds);
    clear_progress(&line);
    if (failed) return 1;
    tell("%zu triangles, tree built in %.2f s", session->scene.triangle_count, build_seconds);
    if (s->stats) print_number("load_seconds", load_seconds);
    if (s->threads != 1 && has_failed(mlrt_create_pool(s->threads, &session->pool), "start threads")) return 1;
    struct shading *shading = &session->shading;
    shading->scene = &session->scene;
    shading->camera = &session->camera;
    shading->view = &session->scene.view;
    session->light = light_of_view(shading->view);
    start_shading(shading);
    session->pixel_count = (size_t)s->size[0] * s->size[1];
    return allocate_frame(session);
}

// Renders and writes the picture, and tells how long it took.
static int make_picture(struct session *session)
{
    const struct settings *s = session->settings;
    const double start = seconds_now();
    const int failed =
        s->map ? draw_map(session->tree, &session->camera, s->map, session->frame.rgb) : time_frames(session);
    const double seconds = (seconds_now() - start) / (s->map || !s->frames ? 1 : s->frames);
    if (failed || !s->output) return failed;
    if (write_png(s->output, s->size[0], s->size[1], session->frame.rgb)) return 1;
    tell("%s: %lu x %lu pixels in %.3g ms, %.3g million pixels/s", s->output, (unsigned long)s->size[0],
         (unsigned long)s->size[1], 1e3 * seconds, 1e-6 * (double)session->pixel_count / seconds);
    return 0;
}

static int run(struct session *session)
{
    const struct settings *s = session->settings;
    if (prepare(session)) return 1;
    if ((s->output || s->frames) && make_picture(session)) return 1;
    if (s->stats && print_stats(session)) return 1;
    return s->hash && print_hashes(session);
}

int main(int argc, char **argv)
{
    struct settings settings = {.scene = "office", .size = {1024, 1024}};
    forget_vector(settings.camera.eye);
    forget_vector(settings.camera.look);
    forget_vector(settings.camera.up);
    forget_vector(settings.camera.light);
    settings.camera.vfov = NAN;
    int exit_code;
    if (!read_settings(&settings, argc, argv, &exit_code)) return exit_code;
    settings.trace.culling_check = (uint32_t)settings.culling_check;

    static struct session session;
    session.settings = &settings;
    int failed = run(&session);
    free_frame(&session.frame);
    mlrt_destroy_pool(session.pool);
    mlrt_destroy_tree(session.tree);
    free_scene(&session.scene);
    return end_output(failed);
}
