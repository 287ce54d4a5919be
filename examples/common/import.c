/* SPDX-License-Identifier: MIT */
/* import.c - mesh files through assimp: see import.h. Built without assimp, it reports that on stderr. */
#include "import.h"

#include "ply_check.h"

#include <stdio.h>

#ifdef HAVE_ASSIMP

#include "file.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <stdlib.h>

struct count {
    uint64_t vertices, triangles;
};

// What assimp's triangulation and the copying below rely on; it aborts or reads out of bounds otherwise.
static const char *find_damage(const struct aiMesh *mesh)
{
    for (unsigned i = 0; i < mesh->mNumFaces; i++) {
        const struct aiFace *face = &mesh->mFaces[i];
        if (face->mNumIndices == 0) return "a face without vertices: the file is damaged or not complete";
        for (unsigned k = 0; k < face->mNumIndices; k++) {
            if (face->mIndices[k] >= mesh->mNumVertices) return "a face names a vertex that does not exist";
        }
    }
    return NULL;
}

static int has_polygons(const struct aiMesh *mesh)
{
    for (unsigned i = 0; i < mesh->mNumFaces; i++) {
        if (mesh->mFaces[i].mNumIndices > 3) return 1;
    }
    return 0;
}

static int is_triangle(const struct aiFace *face)
{
    return face->mNumIndices == 3;
}

static void count_meshes(const struct aiScene *file, const struct aiNode *node, struct count *count)
{
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        const struct aiMesh *mesh = file->mMeshes[node->mMeshes[i]];
        count->vertices += mesh->mNumVertices;
        for (unsigned k = 0; k < mesh->mNumFaces; k++) count->triangles += is_triangle(&mesh->mFaces[k]);
    }
    for (unsigned i = 0; i < node->mNumChildren; i++) count_meshes(file, node->mChildren[i], count);
}

// Rows of a 3x4 matrix: world = rows . (x, y, z, 1).
struct transform {
    double rows[3][4];
    int is_identity; // nothing is computed then, so that the floats stay as they are
};

static struct transform within(const struct transform *outer, const struct aiMatrix4x4 *m)
{
    const double inner[4][4] = {
        {m->a1, m->a2, m->a3, m->a4}, {m->b1, m->b2, m->b3, m->b4}, {m->c1, m->c2, m->c3, m->c4}, {0, 0, 0, 1}};
    struct transform result = {{{0}}, outer->is_identity};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 4; k++) {
            for (int j = 0; j < 3; j++) result.rows[i][k] += outer->rows[i][j] * inner[j][k];
            result.rows[i][k] += outer->rows[i][3] * inner[3][k];
            if (inner[i][k] != (i == k)) result.is_identity = 0;
        }
    }
    return result;
}

static void append_mesh(const struct aiMesh *mesh, const struct transform *transform, struct scene *scene)
{
    uint32_t first = (uint32_t)scene->vertex_count;
    for (unsigned i = 0; i < mesh->mNumVertices; i++) {
        const struct aiVector3D *p = &mesh->mVertices[i];
        float *vertex = scene->vertices + 3 * scene->vertex_count++;
        vertex[0] = p->x, vertex[1] = p->y, vertex[2] = p->z;
        if (transform->is_identity) continue;
        for (int k = 0; k < 3; k++) {
            const double *row = transform->rows[k];
            vertex[k] = (float)(row[0] * p->x + row[1] * p->y + row[2] * p->z + row[3]);
        }
    }
    for (unsigned i = 0; i < mesh->mNumFaces; i++) {
        if (!is_triangle(&mesh->mFaces[i])) continue;
        for (int k = 0; k < 3; k++) {
            scene->indices[3 * scene->triangle_count + k] = first + mesh->mFaces[i].mIndices[k];
        }
        scene->triangle_count++;
    }
}

static void append_node(const struct aiScene *file, const struct aiNode *node, const struct transform *outer,
                        struct scene *scene)
{
    struct transform transform = within(outer, &node->mTransformation);
    for (unsigned i = 0; i < node->mNumMeshes; i++) append_mesh(file->mMeshes[node->mMeshes[i]], &transform, scene);
    for (unsigned i = 0; i < node->mNumChildren; i++) append_node(file, node->mChildren[i], &transform, scene);
}

static int copy_scene(const char *path, const struct aiScene *file, struct scene *scene)
{
    static const struct transform identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, 1};
    struct count count = {0, 0};
    count_meshes(file, file->mRootNode, &count);
    if (count.triangles == 0) {
        fprintf(stderr, "%s: no triangles in this file\n", path);
        return 1;
    }
    if (count.vertices >= UINT32_MAX || count.triangles > INT32_MAX) {
        fprintf(stderr, "%s: more vertices or triangles than 32-bit numbers can name\n", path);
        return 1;
    }
    scene->vertices = malloc(3 * sizeof(float) * (size_t)count.vertices);
    scene->indices = malloc(3 * sizeof(uint32_t) * (size_t)count.triangles);
    if (!scene->vertices || !scene->indices) {
        fprintf(stderr, "%s: not enough memory for %llu triangles\n", path, (unsigned long long)count.triangles);
        return 1;
    }
    append_node(file, file->mRootNode, &identity, scene);
    return 0;
}

// The file as triangles, lines and points, or NULL and what is wrong.
static const struct aiScene *import_triangles(const char *path, const char **problem)
{
    const struct aiScene *file = aiImportFile(path, 0);
    *problem = file ? NULL : aiGetErrorString();
    int polygons = 0;
    for (unsigned i = 0; file && !*problem && i < file->mNumMeshes; i++) {
        *problem = find_damage(file->mMeshes[i]);
        polygons |= has_polygons(file->mMeshes[i]);
    }
    if (file && !*problem && !file->mRootNode) *problem = "no scene in this file";
    if (file && !*problem && polygons) {
        const struct aiScene *triangulated = aiApplyPostProcessing(file, aiProcess_Triangulate);
        if (!triangulated) *problem = aiGetErrorString();
        file = triangulated; // after a failure the scene is gone
    }
    if (file && *problem) aiReleaseImport(file);
    return *problem ? NULL : file;
}

int import_mesh(const char *path, struct scene *scene)
{
    const char *problem = find_input_problem(path);
    if (problem) {
        fprintf(stderr,
                "%s: neither a file that can be read (%s) nor one of the scenes room, office, building, doubled, scan, "
                "scan:N\n",
                path, problem);
        return 1;
    }
    problem = check_ply(path);
    const struct aiScene *file = problem ? NULL : import_triangles(path, &problem);
    if (!file) {
        fprintf(stderr, "%s: %s\n", path, problem);
        return 1;
    }
    int failed = copy_scene(path, file, scene);
    aiReleaseImport(file);
    return failed;
}

#else

int import_mesh(const char *path, struct scene *scene)
{
    (void)scene;
    fprintf(
        stderr,
        "%s: this program was built without assimp, the library that reads mesh files. Install it (Debian, Ubuntu:\n"
        "apt-get install libassimp-dev; or: make deps) and build again. Procedural scenes need no file: room, office,\n"
        "building, doubled, scan, scan:N\n",
        path);
    return 1;
}

#endif
