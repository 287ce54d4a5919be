/* SPDX-License-Identifier: MIT */
/*
 * The example programs as commands: help, version, files without a flag, names of pictures, maps; and the view that a
 * scene gets without one of its own.
 */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/interior.h"
#include "support.h"

enum { OUTPUT_SIZE = 16384 };

/* Runs a program of the build, after other words for the shell. Returns its exit code; what it printed goes to
 * `output`, also what it said on stderr. */
static int run_after(const char *before, const char *command, char output[OUTPUT_SIZE])
{
    char line[1024];
    const char *build = getenv("BUILD");
    snprintf(line, sizeof line, "%s %s/bin/%s 2>&1", before, build ? build : "build", command);
    FILE *pipe = popen(line, "r");
    assert_non_null(pipe);
    const size_t size = fread(output, 1, OUTPUT_SIZE - 1, pipe);
    output[size] = 0;
    const int status = pclose(pipe);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static int run(const char *command, char output[OUTPUT_SIZE])
{
    return run_after("", command, output);
}

/* render is there only with libpng. */
static int have_render(void)
{
    char path[1024];
    const char *build = getenv("BUILD");
    snprintf(path, sizeof path, "%s/bin/render", build ? build : "build");
    return access(path, X_OK) == 0;
}

static void help_and_version(void **state)
{
    char shorter[OUTPUT_SIZE], longer[OUTPUT_SIZE], version[OUTPUT_SIZE];
    (void)state;
    assert_int_equal(run("inspect -h", shorter), 0);
    assert_int_equal(run("inspect --help", longer), 0);
    assert_string_equal(shorter, longer);
    assert_non_null(strstr(shorter, "--version"));
    assert_int_equal(run("inspect --version", version), 0);
    assert_string_equal(version, "inspect (mlrt) " MLRT_VERSION_STRING "\n");
    assert_int_equal(run("inspect --versions", version), 2);
}

static void a_word_without_a_dash_is_a_scene(void **state)
{
    char with[OUTPUT_SIZE], without[OUTPUT_SIZE];
    (void)state;
    assert_int_equal(run("inspect --scene room | grep hash", with), 0);
    assert_int_equal(run("inspect room | grep hash", without), 0);
    assert_string_equal(with, without);
    assert_int_not_equal(with[0], 0);
    assert_int_equal(run("inspect no_such_scene", without), 1);
    assert_non_null(strstr(without, "no_such_scene"));
    assert_int_equal(run("engine room", without), 2); // it has no scenes
}

static void pictures_have_a_name_that_says_what_they_are(void **state)
{
    char output[OUTPUT_SIZE];
    (void)state;
    if (!have_render()) skip();
    assert_int_equal(run("render room --size 16x16 -o picture.jpg", output), 2);
    assert_non_null(strstr(output, ".png"));
    assert_int_not_equal(access("picture.jpg", F_OK), 0);
    assert_int_equal(run("engine --frames 1 -o picture.jpg", output), 2);
    assert_int_not_equal(access("picture.jpg", F_OK), 0);
}

static void maps_are_drawn(void **state)
{
    static const char *const maps[] = {"nodes", "tests", "depth", "judge", "time"};
    char output[OUTPUT_SIZE], command[256], folder[] = "/tmp/mlrt-maps-XXXXXX", path[64];
    static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    (void)state;
    if (!have_render()) skip();
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/map.png", folder);
    for (int i = 0; i < 5; i++) {
        unsigned char head[24] = {0};
        snprintf(command, sizeof command, "render room --size %dx33 --map %s -o %s", i == 0 ? 1 : 200, maps[i], path);
        assert_int_equal(run(command, output), 0);
        assert_string_equal(output, ""); // nothing is told where no terminal is
        FILE *file = fopen(path, "rb");
        assert_non_null(file);
        assert_int_equal(fread(head, 1, sizeof head, file), sizeof head);
        fclose(file);
        assert_memory_equal(head, signature, sizeof signature);
        assert_int_equal(head[19], i == 0 ? 1 : 200);
        assert_int_equal(head[23], 33);
        remove(path);
    }
    rmdir(folder);
    assert_int_equal(run("render room --map nodes", output), 2);
    assert_int_equal(run("render room --map colours -o x.png", output), 2);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

static size_t size_of(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 ? (size_t)status.st_size : 0;
}

/* No file may grow beyond a block, as if the disk were full. */
static void files_are_written_whole_or_not_at_all(void **state)
{
    static const char *const commands[] = {"inspect room --save %s", "occlusion --size 64 -o %s",
                                           "render room --shadows --size 64x64 -o %s"};
    char output[OUTPUT_SIZE], command[256], folder[] = "/tmp/mlrt-files-XXXXXX", path[64], part[80], link[64];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/file.png", folder);
    snprintf(part, sizeof part, "%s.part", path);
    snprintf(link, sizeof link, "%s/link.png", folder);
    assert_int_equal(symlink("file.png", link), 0);
    for (int i = 0; i < 2 + have_render(); i++) {
        write_text(path, "as it was");
        snprintf(command, sizeof command, commands[i], path);
        assert_int_equal(run_after("trap '' XFSZ; ulimit -f 1;", command, output), 1);
        assert_non_null(strstr(output, "cannot "));
        assert_int_equal(size_of(path), strlen("as it was"));
        assert_int_not_equal(access(part, F_OK), 0);
        snprintf(command, sizeof command, commands[i], link);
        assert_int_equal(run(command, output), 0);
        assert_true(size_of(path) > strlen("as it was")); // a link leads to the file, and stays a link
    }
    assert_int_equal(unlink(link), 0);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

/* Reading of a pipe that nobody writes to would never end. */
static void only_files_are_read(void **state)
{
    static const char *const commands[] = {"inspect %s", "inspect --load %s", "occlusion --size 16 --view %s:hall"};
    char output[OUTPUT_SIZE], command[256], folder[] = "/tmp/mlrt-files-XXXXXX", path[64];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/pipe.ply", folder);
    assert_int_equal(mkfifo(path, 0600), 0);
    for (int i = 0; i < 3; i++) {
        snprintf(command, sizeof command, commands[i], path);
        assert_int_equal(run(command, output), 1);
        snprintf(command, sizeof command, commands[i], folder);
        assert_int_equal(run(command, output), 1);
    }
    unlink(path);
    rmdir(folder);
}

/* assimp would read the header of each for ever. */
static void ply_files_that_are_cut_off_are_refused(void **state)
{
    static const char *const starts[] = {"ply", "PLY", "Ply", "pLY"};
    char output[OUTPUT_SIZE], command[256], folder[] = "/tmp/mlrt-files-XXXXXX", path[64], text[128];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/mesh.ply", folder);
    for (int i = 0; i < 4; i++) {
        snprintf(text, sizeof text, "%s\nformat ascii 1.0\nelement vertex 3\n", starts[i]);
        write_text(path, text);
        snprintf(command, sizeof command, "inspect %s", path);
        assert_int_equal(run(command, output), 1);
        assert_non_null(strstr(output, path));
    }
    unlink(path);
    rmdir(folder);
}

/* What cannot be written is missing, so the program has failed. Only Linux has a device that is always full. */
static void output_that_is_lost_is_a_failure(void **state)
{
    static const char *const commands[] = {"inspect room",
                                           "inspect --help",
                                           "inspect --version",
                                           "occlusion --size 16",
                                           "engine --frames 1 --size 16x16 --quiet",
                                           "pays --largest 0 --runs 1",
                                           "depth --scene room --size 16 --rays 16 --runs 1 --limit 20",
                                           "price --worst --scene room --size 16 --runs 1",
                                           "steps --scene room --size 64 --runs 1",
                                           "bench --alone --scene room --size 64 --runs 1 --kind frame",
                                           "reproduce --scene room --size 64 --runs 1 --only 7"};
    char output[OUTPUT_SIZE];
    (void)state;
    if (access("/dev/full", W_OK) != 0) skip();
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        assert_int_equal(run_after("exec >/dev/full;", commands[i], output), 1);
    }
}

static void options_that_would_be_ignored_are_mistakes(void **state)
{
    static const char *const commands[] = {"inspect --load tree --save copy",
                                           "inspect --load tree room",
                                           "inspect --load tree --cancel 3",
                                           "steps --size 65",
                                           "errors --side 17",
                                           "render room --map nodes --frames 3 -o map.png"};
    char output[OUTPUT_SIZE];
    (void)state;
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        if (i >= 4 && !have_render()) continue; // nor errors
        const int code = run(commands[i], output);
        if (code == 127) continue; // errors needs GMP
        assert_int_equal(code, 2);
        assert_non_null(strstr(output, "--"));
    }
}

static void numbers_of_triangles_make_sense(void **state)
{
    static const char *const words[] = {"sphere:",   "sphere:x",   "sphere:-5",
                                        "sphere:19", "sphere:80x", "sphere:99999999999999999999"};
    char output[OUTPUT_SIZE], command[256];
    (void)state;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        snprintf(command, sizeof command, "bench --alone --size 64 --runs 1 --kind frame --scene %s", words[i]);
        assert_int_equal(run(command, output), 1);
        assert_non_null(strstr(output, "20 to 5242880"));
    }
    assert_int_equal(run("bench --alone --size 64 --runs 1 --kind frame --scene sphere:80,sphere", output), 0);
    assert_non_null(strstr(output, "80: 80 triangles"));
    assert_non_null(strstr(output, "sphere: 20480 triangles"));
}

static void failures_say_why(void **state)
{
    static const struct {
        const char *command, *words;
    } cases[] = {{"inspect room --traversal-cost -1", "options.traversal_cost"},
                 {"bench --alone --size 64 --runs 1 --kind array --view %s:a room", "camera.eye"},
                 {"bench --alone --size 64 --runs 1 --kind record --view %s:a room", "camera.eye"},
                 {"occlusion --size 16 --view %s:a", "camera.eye"},
                 {"occlusion --size 16 --view %s:b", "no list of views"},
                 {"render room --size 16x16 --hash --eye 1e39,0,0", "camera.eye"},
                 {"render room --size 16x16 -o map.png --map nodes --eye 1e39,0,0", "camera.eye"}};
    char output[OUTPUT_SIZE], command[256], folder[] = "/tmp/mlrt-files-XXXXXX", path[64];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/views.json", folder);
    write_text(path, "{\"a\": [{\"eye\": [1e39, 0, 0], \"look\": [0, 0, 0], \"vfov\": 45}]}");
    for (size_t i = 0; i < sizeof cases / sizeof *cases - (have_render() ? 0 : 2); i++) {
        snprintf(command, sizeof command, cases[i].command, path);
        assert_int_equal(run(command, output), 1);
        if (!strstr(output, "built without")) assert_non_null(strstr(output, cases[i].words));
    }
    write_text(path, "{\"a\": [{\"eye\": [3, 2, 1], \"look\": [0, 1, 0], \"vfov\": 45}]}, and more");
    snprintf(command, sizeof command, "occlusion --size 16 --view %s:a", path);
    assert_int_equal(run(command, output), 1);
    unlink(path);
    rmdir(folder);
}

static void write_triangle(const char *path, double size)
{
    char text[512];
    snprintf(text, sizeof text,
             "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
             "0 0 0\n%.17g 0 0\n0 %.17g 0\n0 0 %.17g\n%.17g 0 %.17g\n0 %.17g %.17g\n3 0 1 2\n3 3 4 5\n",
             size, size, size / 16, size, size / 16, size, size / 16);
    write_text(path, text);
}

/* Files without an extension, or with two, or with the name of a scene that is made. */
static void files_keep_their_names_and_views(void **state)
{
    static const char *const names[] = {"mesh", "mesh.of.two.ply", "sphere.ply"};
    char output[OUTPUT_SIZE], command[512], folder[] = "/tmp/mlrt-files-XXXXXX", path[64], views[64];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(views, sizeof views, "%s/views.json", folder);
    write_text(views, "{}");
    for (int i = 0; i < 3; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        write_triangle(path, 1);
        snprintf(command, sizeof command, "depth --scene %s --views %s", path, views);
        assert_int_equal(run(command, output), 1);
        if (strstr(output, "built without")) skip();
        assert_non_null(strstr(output, i == 0 ? "\"mesh\"" : i == 1 ? "\"mesh.of.two\"" : "\"sphere\""));
        snprintf(command, sizeof command, "accuracy --rays 16 --runs 1 --scene %s --views %s", path, views);
        const int code = run(command, output);
        if (code != 127) { // it needs GMP
            assert_int_equal(code, 1);
            assert_non_null(strstr(output, "no list of views"));
        }
        unlink(path);
    }
    unlink(views);
    rmdir(folder);
}

static void accuracy_finds_a_view_by_its_name(void **state)
{
    static const char *const views[] = {"", ":mesh", ":hall", ":hall/view2", ":hall/view3"};
    char output[OUTPUT_SIZE], command[512], folder[] = "/tmp/mlrt-files-XXXXXX", path[64], file[64];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/mesh.ply", folder);
    snprintf(file, sizeof file, "%s/views.json", folder);
    write_triangle(path, 1);
    write_text(file, "{\"mesh\": [{\"name\": \"view1\", \"eye\": [0, 0, 3], \"look\": [0, 0, 0], \"vfov\": 45}],"
                     "\"hall\": [{\"name\": \"view2\", \"eye\": [0, 3, 3], \"look\": [0, 0, 0], \"vfov\": 45}]}");
    for (int i = 0; i < 5; i++) {
        snprintf(command, sizeof command,
                 "accuracy --rays 16 --runs 1 --generator camera --method mlrt_tile --csv %s --views %s%s", path, file,
                 views[i]);
        const int code = run(command, output);
        if (code == 127 || strstr(output, "built without")) break;
        assert_int_equal(code, i == 4);
        assert_true(i != 4 || strstr(output, "no view \"view3\""));
    }
    unlink(path);
    unlink(file);
    rmdir(folder);
}

/* Of one scene in several sizes, powers of two apart, the same rays hit. */
static void occlusion_does_not_depend_on_size(void **state)
{
    char first[OUTPUT_SIZE], output[OUTPUT_SIZE], command[256], folder[] = "/tmp/mlrt-files-XXXXXX", path[64];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/mesh.ply", folder);
    for (int i = 0; i < 3; i++) {
        write_triangle(path, ldexp(1, i == 0 ? 0 : i == 1 ? -80 : 66));
        snprintf(command, sizeof command, "occlusion --size 64 --reach 20 %s | grep -v '^[sM]'", path);
        assert_int_equal(run(command, i == 0 ? first : output), 0);
        if (i > 0) assert_string_equal(output, first);
    }
    unlink(path);
    rmdir(folder);
}

/* ---- views --------------------------------------------------------------------------------------------------- */

/* A box from 0 to `size`, whose fronts are outside, or inside. */
static void make_box(const float size[3], int fronts_inside, struct scene *scene)
{
    static const uint32_t corners[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                            {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    static float vertices[8][3];
    static uint32_t indices[12][3];
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < 3; k++) vertices[i][k] = i >> k & 1 ? size[k] : 0;
    }
    for (int i = 0; i < 12; i++) {
        indices[i][0] = corners[i][0];
        indices[i][1] = corners[i][fronts_inside ? 2 : 1];
        indices[i][2] = corners[i][fronts_inside ? 1 : 2];
    }
    memset(scene, 0, sizeof *scene);
    scene->is_imported = 1;
    scene->vertices = vertices[0], scene->vertex_count = 8;
    scene->indices = indices[0], scene->triangle_count = 12;
    scene->view.eye[0] = 1000;
}

static int is_inside(const double point[3], const float size[3])
{
    int inside = 1;
    for (int k = 0; k < 3; k++) inside = inside && point[k] > 0 && point[k] < (double)size[k];
    return inside;
}

static void rooms_are_seen_from_inside(void **state)
{
    static const float sizes[2][3] = {{8, 3, 6}, {80, 60, 28}};
    (void)state;
    for (int i = 0; i < 2; i++) {
        struct scene scene;
        make_box(sizes[i], 1, &scene);
        look_from_inside(&scene);
        assert_true(is_inside(scene.view.eye, sizes[i]));
        assert_true(is_inside(scene.view.look, sizes[i]));
        assert_true(is_inside(scene.view.light, sizes[i]));
        assert_true(scene.view.up[i == 0 ? 1 : 2] == 1);
        make_box(sizes[i], 0, &scene); // a body
        look_from_inside(&scene);
        assert_true(scene.view.eye[0] == 1000);
        make_box(sizes[i], 1, &scene); // a box without its front
        scene.triangle_count = 10, scene.indices += 6;
        look_from_inside(&scene);
        assert_true(scene.view.eye[0] == 1000);
    }
}

static void scenes_without_triangles_keep_their_view(void **state)
{
    struct scene scene = {.view = {.eye = {1, 2, 3}}, .is_imported = 1};
    (void)state;
    look_from_inside(&scene);
    assert_true(scene.view.eye[2] == 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(help_and_version),
        cmocka_unit_test(a_word_without_a_dash_is_a_scene),
        cmocka_unit_test(pictures_have_a_name_that_says_what_they_are),
        cmocka_unit_test(maps_are_drawn),
        cmocka_unit_test(files_are_written_whole_or_not_at_all),
        cmocka_unit_test(only_files_are_read),
        cmocka_unit_test(ply_files_that_are_cut_off_are_refused),
        cmocka_unit_test(output_that_is_lost_is_a_failure),
        cmocka_unit_test(options_that_would_be_ignored_are_mistakes),
        cmocka_unit_test(numbers_of_triangles_make_sense),
        cmocka_unit_test(failures_say_why),
        cmocka_unit_test(files_keep_their_names_and_views),
        cmocka_unit_test(accuracy_finds_a_view_by_its_name),
        cmocka_unit_test(occlusion_does_not_depend_on_size),
        cmocka_unit_test(rooms_are_seen_from_inside),
        cmocka_unit_test(scenes_without_triangles_keep_their_view),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
