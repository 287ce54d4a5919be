/* SPDX-License-Identifier: MIT */
/*
 * mlrt.h - finds where rays hit triangles: exact answers behind a C ABI, from tiles of rays that are traced together
 *
 * Based on: Alexander Reshetov, Alexei Soupikov, Jim Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005. Ingo
 * Wald, Solomon Boulos, Peter Shirley, "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies", 2007.
 *
 * A complete program: one triangle, one ray, the distance printed.
 *
 *     #include <mlrt.h>
 *     #include <stdio.h>
 *     int main(void)
 *     {
 *         const float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
 *         mlrt_mesh mesh = {sizeof mesh, 0, corners, 3, 0, NULL, 1, 0, 0, 0};
 *         mlrt_tree *tree = NULL;
 *         int32_t status = mlrt_build_tree(&mesh, 1, NULL, &tree);
 *         mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
 *         mlrt_hit hit = {.struct_size = sizeof hit};
 *         if (status == MLRT_OK) status = mlrt_trace_ray(tree, &ray, NULL, &hit);
 *         printf("%s: t = %g, triangle %u\n", mlrt_status_string(status), (double)hit.t, (unsigned)hit.triangle);
 *         mlrt_destroy_tree(tree);
 *         return status != MLRT_OK;
 *     }
 *
 * RULES OF THE WHOLE INTERFACE
 *
 * Answers. Every hit-or-miss and which-is-nearer decision equals exact arithmetic on the float numbers given: the same
 * bits from one ray, a packet or a tile, with every method, instruction set and number of threads. The rule, in real
 * arithmetic, for a ray o + t d and a triangle a b c with normal n = (b - a) x (c - a):
 *
 *   - Never hit: a triangle with a vertex that is not finite, or with n exactly 0. Hits nothing: a ray with a NaN, with
 *     an o or d that is not finite, with d = 0, or without t_min < t_max. A t_min below 0 counts as 0.
 *   - e_ij = d . ((v_i - o) x (v_j - o)), D = d . n = e_ab + e_bc + e_ca, N = (a - o) . n. The ray hits if D is not
 *     0, no D e_ij is negative, and t_min < N / D <= t_max. So triangles are closed and two-sided, the interval is half
 *     open, and a ray in the plane of a triangle misses it.
 *   - The closest hit has the smallest N / D. Where several have the same, it is the first of them in the input (mesh
 *     by position, then triangle).
 *   - Any-hit says yes exactly if there is a closest hit.
 *   - Reported are t = N / D, u = e_ca / D (the weight of b), v = e_ab / D (the weight of c), correctly rounded, and
 *     facing = the sign of D: +1 where the ray travels along n, -1 against it. A miss has t = inf, u = v = 0, mesh =
 *     triangle = MLRT_NONE, facing = 0. A hit's t can also round to inf (if N / D is beyond the range of float and
 *     t_max = inf) or to t_min, which may be 0. So mesh, triangle and facing tell hits from misses; t does not.
 *
 * Numbers. Lengths are in the units of the mesh, t in units of the length of d, which may be any finite length.
 * Denormals are numbers like others, not 0. A call may be made in any floating-point environment (rounding,
 * flush-to-zero, exception masks): it sets the one that it needs, and restores the caller's. Like any arithmetic, it
 * may raise exception flags; it lowers none. A tile callback runs in the environment of its thread, the functions of a
 * host and the hooks of a pool in that one or in the library's (round to nearest, denormals kept, exceptions masked).
 *
 * Structs start with `struct_size`, which the caller sets to the struct's sizeof; the rest zero means default. Later
 * versions append fields, in multiples of 4 bytes, and never change the meaning or the place of a field that is here.
 * So header and library may be of different versions. A field that the caller's struct is too short for counts as 0; if
 * it is a result, it is not written. A field that the library does not know must be 0; if the struct is for results,
 * the library sets it to 0. MLRT_ERROR_STRUCT_SIZE is the answer if such a field is not 0, or if no version has a
 * struct of that size (it ends before its first fields, for example, or is far larger than the library's). In an array
 * of structs all have the struct_size of the first. mlrt_array and mlrt_const_array have no struct_size and never grow.
 * In mlrt_tile the library sets it.
 *
 * Arrays are a pointer and a byte stride. Stride 0 means packed; MLRT_STRIDE_ALL means that one element serves all rays
 * (only in input arrays of rays and points). Addresses and strides must be multiples of 4 (of 2 for 2-byte indices, of
 * 1 for uint8_t), and strides, those of rows too, at most 2^31; otherwise the answer is MLRT_ERROR_ARGUMENT. No byte
 * outside the elements is read or written. An element for a result may overlap neither another one nor anything that
 * the call reads; arrays may lie within each other, as the fields of structs do.
 *
 * Ownership. The library uses arguments only until the call returns, with three exceptions: a tree or a pool keeps the
 * allocator of the host that it was made with, a pool also keeps its hooks, and a tree loaded with MLRT_LOAD_IN_PLACE
 * keeps its data. Only mlrt_create_*, mlrt_build_* and mlrt_load_* make objects, which the caller frees with
 * mlrt_destroy_pool or mlrt_destroy_tree. Destroying NULL does nothing.
 *
 * Errors. Functions that can fail return an int32_t status: MLRT_OK = 0, or one of MLRT_ERROR_*. New codes may be
 * added. After an error nothing is leaked, and a tree or pool that was to be made is NULL. The library never prints,
 * exits or aborts. mlrt_last_message tells why a call failed.
 *
 * Threads. The library starts no threads unless the caller makes a pool, and it has no global state but the last
 * message, which each thread has for itself, and what the processor can do. A tree never changes after it is built: any
 * number of threads may trace it at once. A pool with threads of its own serves one call at a time, and calls that
 * share it wait for each other. A pool with mlrt_pool_options.enqueue serves several at once. After fork() the child
 * has the trees, but not the threads of a pool: it makes a pool of its own, and neither uses nor destroys the parent's.
 */
#ifndef MLRT_H
#define MLRT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Windows: define MLRT_BUILD_DLL to compile the library as a DLL. Programs that call a DLL may define MLRT_USE_DLL. */
#ifndef MLRT_API
#if defined(_WIN32) && defined(MLRT_BUILD_DLL)
#define MLRT_API __declspec(dllexport)
#elif defined(_WIN32) && defined(MLRT_USE_DLL)
#define MLRT_API __declspec(dllimport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define MLRT_API __attribute__((visibility("default")))
#else
#define MLRT_API
#endif
#endif

#ifdef MLRT_PREFIX
/*
 * MLRT_PREFIX renames the functions, for a copy of the library within another library. Compiled with
 * -DMLRT_PREFIX=game_, the library exports game_trace_ray in place of mlrt_trace_ray. A program that includes this
 * header with the same definition calls it by writing mlrt_trace_ray, as always. Types and constants keep their names.
 */
#define MLRT_JOIN(prefix, name)       prefix##name
#define MLRT_EXPAND(prefix, name)     MLRT_JOIN(prefix, name)
#define MLRT_RENAMED(name)            MLRT_EXPAND(MLRT_PREFIX, name)
#define mlrt_build_kdtree             MLRT_RENAMED(build_kdtree)
#define mlrt_build_tree               MLRT_RENAMED(build_tree)
#define mlrt_camera_rays              MLRT_RENAMED(camera_rays)
#define mlrt_capabilities             MLRT_RENAMED(capabilities)
#define mlrt_create_pool              MLRT_RENAMED(create_pool)
#define mlrt_create_pool_with_options MLRT_RENAMED(create_pool_with_options)
#define mlrt_destroy_pool             MLRT_RENAMED(destroy_pool)
#define mlrt_destroy_tree             MLRT_RENAMED(destroy_tree)
#define mlrt_estimate_kdtree          MLRT_RENAMED(estimate_kdtree)
#define mlrt_estimate_tree            MLRT_RENAMED(estimate_tree)
#define mlrt_get_tree_info            MLRT_RENAMED(get_tree_info)
#define mlrt_hash_geometry            MLRT_RENAMED(hash_geometry)
#define mlrt_last_message             MLRT_RENAMED(last_message)
#define mlrt_load_tree                MLRT_RENAMED(load_tree)
#define mlrt_occluded_points          MLRT_RENAMED(occluded_points)
#define mlrt_offset_point             MLRT_RENAMED(offset_point)
#define mlrt_pool_thread_count        MLRT_RENAMED(pool_thread_count)
#define mlrt_render_tiles             MLRT_RENAMED(render_tiles)
#define mlrt_save_tree                MLRT_RENAMED(save_tree)
#define mlrt_shadow_ray               MLRT_RENAMED(shadow_ray)
#define mlrt_status_string            MLRT_RENAMED(status_string)
#define mlrt_struct_sizes             MLRT_RENAMED(struct_sizes)
#define mlrt_trace_all_hits           MLRT_RENAMED(trace_all_hits)
#define mlrt_trace_packet             MLRT_RENAMED(trace_packet)
#define mlrt_trace_ray                MLRT_RENAMED(trace_ray)
#define mlrt_version                  MLRT_RENAMED(version)
#endif

/* ------------------------------------------------------------------------------------------------------------------
 * Versions and codes
 * ------------------------------------------------------------------------------------------------------------------ */

#define MLRT_VERSION_MAJOR  0       /* of this header; mlrt_version returns the library's */
#define MLRT_VERSION_MINOR  1       /* of this header */
#define MLRT_VERSION_PATCH  0       /* of this header */
#define MLRT_VERSION_STRING "0.1.0" /* the three numbers */

/* Status codes, which functions that can fail return. New ones may be added. */
enum {
    MLRT_OK = 0,                  /* success */
    MLRT_ERROR_ARGUMENT = 1,      /* a pointer that must not be NULL is, or a value is out of its range */
    MLRT_ERROR_STRUCT_SIZE = 2,   /* a struct_size is not set, or not of any version */
    MLRT_ERROR_INDEX_RANGE = 3,   /* a triangle names a vertex that does not exist: see mlrt_tree_options.message */
    MLRT_ERROR_OUT_OF_MEMORY = 4, /* an allocation failed, or a memory_limit was reached; nothing was kept */
    MLRT_ERROR_TOO_LARGE = 5,     /* more meshes, triangles, rays or pixels than 32-bit counts allow */
    MLRT_ERROR_CAMERA = 6,        /* camera of size zero, crop outside it, numbers not finite (t_min, t_max: NaN), a
                                     direction of 0 (of a parallel camera), or dx and dy parallel */
    MLRT_ERROR_UNSUPPORTED = 7,   /* an instruction set that this machine or build does not have, or a method of the
                                     other structure (MLRT_STRUCTURE_*) */
    MLRT_ERROR_THREAD = 8,        /* the system would not start a thread */
    MLRT_ERROR_CANCELLED = 9,     /* a tile callback or a host's progress function asked to stop */
    MLRT_ERROR_DATA = 10          /* no saved tree, or one that is damaged, of another version, or of other triangles */
};

/* The id that is reported for a miss. In a `skip` element it means that nothing is skipped. */
#define MLRT_NONE 0xFFFFFFFFu

/* Returns the library's version, MAJOR * 10000 + MINOR * 100 + PATCH, which can differ from the header's. */
MLRT_API uint32_t mlrt_version(void);

/* Returns what a status code means: an English phrase, never NULL, also for unknown codes. The string is static. */
MLRT_API const char *mlrt_status_string(int32_t status);

/*
 * Returns why the last call of this thread that did not return MLRT_OK failed, in words that name the argument, its
 * value and the rule: "rays.t_max: stride 13 is not a multiple of 4". UTF-8 without a newline, 255 bytes at most, never
 * NULL; "" if no call of the thread has failed. Calls that succeed leave it as it is, so ask only after a failure.
 *
 * Each thread has its own message, which lasts until the next call of the thread that fails, or until the thread ends.
 * The thread of a call is the one that made it, also where a pool does the work. Where a runtime may move its tasks
 * from thread to thread (goroutines, promises), ask before anything else may run.
 */
MLRT_API const char *mlrt_last_message(void);

/* What mlrt_capabilities returns, or-ed together. New ones may be added. */
enum {
    MLRT_CAN_SSE = 1,    /* this build has MLRT_ISA_SSE, and this machine can run it */
    MLRT_CAN_AVX2 = 2,   /* the same of MLRT_ISA_AVX2 */
    MLRT_CAN_AVX512 = 4, /* the same of MLRT_ISA_AVX512 */
    MLRT_CAN_NEON = 8    /* the same of MLRT_ISA_NEON */
};

/* Returns what this library can do on this machine: MLRT_CAN_*. May be called before anything else. */
MLRT_API uint64_t mlrt_capabilities(void);

/*
 * The structs of this header: indices of the array of mlrt_struct_sizes. New ones are added at the end.
 */
enum {
    MLRT_STRUCT_HOST = 0,            /* mlrt_host */
    MLRT_STRUCT_MESH = 1,            /* mlrt_mesh */
    MLRT_STRUCT_TREE_OPTIONS = 2,    /* mlrt_tree_options */
    MLRT_STRUCT_TREE_INFO = 3,       /* mlrt_tree_info */
    MLRT_STRUCT_MEMORY_ESTIMATE = 4, /* mlrt_memory_estimate */
    MLRT_STRUCT_LOAD_OPTIONS = 5,    /* mlrt_load_options */
    MLRT_STRUCT_POOL_OPTIONS = 6,    /* mlrt_pool_options */
    MLRT_STRUCT_COUNTERS = 7,        /* mlrt_counters */
    MLRT_STRUCT_TRACE_OPTIONS = 8,   /* mlrt_trace_options */
    MLRT_STRUCT_ARRAY = 9,           /* mlrt_array */
    MLRT_STRUCT_HITS = 10,           /* mlrt_hits */
    MLRT_STRUCT_CONST_ARRAY = 11,    /* mlrt_const_array */
    MLRT_STRUCT_RAYS = 12,           /* mlrt_rays */
    MLRT_STRUCT_RAY = 13,            /* mlrt_ray */
    MLRT_STRUCT_HIT = 14,            /* mlrt_hit */
    MLRT_STRUCT_HIT_LISTS = 15,      /* mlrt_hit_lists */
    MLRT_STRUCT_CAMERA = 16,         /* mlrt_camera */
    MLRT_STRUCT_TILE = 17,           /* mlrt_tile */
    MLRT_STRUCT_LIGHT = 18,          /* mlrt_light */
    MLRT_STRUCT_POINTS = 19,         /* mlrt_points */
    MLRT_STRUCT_KDTREE_OPTIONS = 20, /* mlrt_kdtree_options */
    MLRT_STRUCT_COUNT = 21           /* the number of structs in this header */
};

/*
 * Writes the size of each struct in this library to sizes[0 .. count - 1]: element MLRT_STRUCT_MESH is that of
 * mlrt_mesh, and so on. Elements for which this library has no struct become 0. For bindings whose layouts are written
 * by hand: a size that differs from theirs is that of another version, or their layout is wrong. May be called before
 * anything else.
 */
MLRT_API void mlrt_struct_sizes(uint32_t *sizes, uint32_t count);

/* ------------------------------------------------------------------------------------------------------------------
 * The host: memory, messages, progress
 * ------------------------------------------------------------------------------------------------------------------ */

/* Returns `size` bytes (never 0), aligned to `alignment` (a power of two, 64 at most); NULL if there is no memory. */
typedef void *(*mlrt_allocate_callback)(void *user, size_t size, size_t alignment);

/* Frees a block (never NULL); `size` and `alignment` are those with which it was allocated. */
typedef void (*mlrt_free_callback)(void *user, void *block, size_t size, size_t alignment);

/* The kinds of messages: `level` of mlrt_log_callback */
enum {
    MLRT_LOG_ERROR = 0,   /* the reason why a call fails */
    MLRT_LOG_WARNING = 1, /* something was left out */
    MLRT_LOG_INFO = 2     /* a tree was built, its size and time; or the host stopped a call */
};

/* Receives one line (UTF-8, no newline, 255 bytes at most). `message` is valid until the function returns. */
typedef void (*mlrt_log_callback)(void *user, int32_t level, const char *message);

/*
 * Receives the part of a call that is done, 0..1 and never less than before: every few milliseconds, and 1 at the end
 * of a call that succeeds. Return 0 to go on. Any other result ends the call within some milliseconds, with
 * MLRT_ERROR_CANCELLED; after the 1 the result is ignored. The builder and the methods of kd-trees call it less often,
 * and the system can take longer to free much memory.
 */
typedef int32_t (*mlrt_progress_callback)(void *user, double fraction);

/*
 * Functions that the program around the library provides. Options with a field `host` may point to one of these; each
 * function may be NULL.
 *
 * Give both `allocate` and `free`, or neither: then malloc and free are used. A call with a host takes all its memory
 * from it, and a tree or a pool that the call makes keeps both functions and `user` until it is destroyed. The library
 * calls `allocate`, `free` and `log` from the thread of the call only, with two exceptions: mlrt_build_kdtree calls
 * `allocate` and `free` from the threads of its pool too, one at a time, and mlrt_trace_all_hits several at a time. It
 * calls `progress` from any of these threads, but from one at a time. None of the functions may jump out of the
 * library. None may use the pool of the call that it is called from; `log` and `progress` may if that pool has tasks
 * (mlrt_pool_options.enqueue).
 */
typedef struct mlrt_host {
    uint32_t struct_size;            /* sizeof(mlrt_host) */
    uint32_t reserved;               /* must be 0 */
    void *user;                      /* the first argument of all four */
    mlrt_allocate_callback allocate; /* NULL = malloc */
    mlrt_free_callback free;         /* NULL = free */
    mlrt_log_callback log;           /* NULL = no messages */
    mlrt_progress_callback progress; /* NULL = no call is cancelled */
} mlrt_host;

/* ------------------------------------------------------------------------------------------------------------------
 * Building a tree
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * A tree: the triangles of any number of meshes, and the structure that finds them (MLRT_STRUCTURE_*). It is immutable.
 * All functions take trees of either structure, and how a tree was built never changes an answer.
 */
typedef struct mlrt_tree mlrt_tree;

/*
 * An indexed triangle mesh in the caller's memory.
 *
 * A vertex is three floats. A triangle is three indices of vertices, unsigned integers of 2 or 4 bytes; with `indices`
 * = NULL, triangle i has the vertices 3i, 3i + 1, 3i + 2. Elements of an array may not overlap.
 */
typedef struct mlrt_mesh {
    uint32_t struct_size; /* sizeof(mlrt_mesh) */
    uint32_t id; /* reported with hits. Ids must differ and not be MLRT_NONE; if all are 0, they are 0, 1, 2, ... */
    const void *vertices;   /* float[3] each, aligned to 4 bytes */
    size_t vertex_count;    /* every index must be less */
    size_t vertex_stride;   /* bytes from one vertex to the next, a multiple of 4; 0 = 12 */
    const void *indices;    /* NULL = consecutive vertices */
    size_t triangle_count;  /* 0 is allowed */
    size_t triangle_stride; /* bytes from one index triple to the next, a multiple of index_size; 0 = 3 * index_size */
    uint32_t index_size;    /* 2 or 4; 0 = 4 */
    uint32_t mask;          /* rays see the mesh if their mask has a bit in common with it; 0 = all bits */
} mlrt_mesh;

/*
 * The structures by which trees find triangles: mlrt_tree_info.structure. Each has a builder and methods of its own,
 * one of them its default (MLRT_METHOD_*). The answers are the same.
 */
enum {
    MLRT_STRUCTURE_KDTREE = 1, /* the paper's kd-tree, by mlrt_build_kdtree: for study, and for the paper's tables */
    MLRT_STRUCTURE_BVH = 2     /* a hierarchy of boxes, by mlrt_build_tree: for all else. 16 boxes a node, up to 16
                                  triangles a leaf */
};

/*
 * Presets of mlrt_build_tree: mlrt_tree_options.preset
 *
 * FAST puts each triangle into one leaf. DEFAULT and BEST cut large triangles that lie among small ones in two, so that
 * a triangle can be in several leaves: DEFAULT makes up to 1.15 references (leaf entries) per triangle that is given
 * and takes up to 4 times as long to build as FAST, BEST makes up to 1.5 and takes up to 5 times as long as DEFAULT.
 */
enum {
    MLRT_TREE_DEFAULT = 0, /* faster to render than FAST, slower than BEST */
    MLRT_TREE_FAST = 1,    /* built fastest, for scenes that change */
    MLRT_TREE_BEST = 2     /* renders fastest, for many pictures of one scene: takes more memory and time to build */
};

/* How to build a hierarchy of boxes: mlrt_build_tree. NULL, or all zero but struct_size: defaults. */
typedef struct mlrt_tree_options {
    uint32_t struct_size;    /* sizeof(mlrt_tree_options) */
    int32_t preset;          /* MLRT_TREE_* */
    float traversal_cost;    /* of a node, 0..1e6, in units of a leaf's cost; 0 = 1 */
    float intersection_cost; /* of a triangle in a leaf, 0..1e6, in the same units; 0 = a small share of the leaf's */
    char *message;           /* NULL, or a buffer: receives why the call failed (UTF-8, terminated), or "" */
    size_t message_size;     /* size of the buffer in bytes */
    const mlrt_host *host;   /* NULL = malloc, and no messages */
    uint64_t memory_limit;   /* most bytes held at one time; beyond: MLRT_ERROR_OUT_OF_MEMORY; 0 = no limit */
    struct mlrt_pool *pool;  /* whose threads build; NULL = the calling thread alone. The tree is the same */
} mlrt_tree_options;

/*
 * Builds the best tree that the library has over the triangles of `meshes`: a hierarchy of boxes.
 *
 *   meshes      array of mesh_count structs, all of the struct_size of the first. The mesh data may be freed on return.
 *   mesh_count  0 is allowed, as is a mesh without triangles: in an empty tree every ray misses.
 *   options     NULL = defaults.
 *   tree        receives the tree, or NULL after an error. Free it with mlrt_destroy_tree.
 *
 * Triangles that can never be hit (a vertex that is not finite, an area of exactly zero) are left out of the tree and
 * counted in mlrt_tree_info; the numbers of the others do not change. The same input always gives the same tree.
 * MLRT_ERROR_INDEX_RANGE: an index is out of range; options->message names mesh (by position), triangle and index.
 * MLRT_ERROR_ARGUMENT: an option is out of its range; options->message names the option. MLRT_ERROR_TOO_LARGE: more
 * than 2^30 - 1 triangles in all.
 *
 * Memory per triangle, its own 36 bytes included: 51 to 60 bytes, and at most 136 while the tree is built (FAST: 50 to
 * 56 and 127, BEST: 52 to 69 and 154). Flat grids take a little less, meshes of a few triangles more, and masks 4
 * bytes per triangle. mlrt_tree_info tells how much a tree took.
 *
 * Method: surface area heuristic over bins, with spatial splits (M. Stich, H. Friedrich, A. Dietrich, "Spatial Splits
 * in Bounding Volume Hierarchies", 2009), and the best way to put sixteen boxes into a node (H. Ylitie, T. Karras, S.
 * Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017).
 */
MLRT_API int32_t mlrt_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                                 mlrt_tree **tree);

/* Presets of mlrt_build_kdtree: mlrt_kdtree_options.preset */
enum {
    MLRT_KDTREE_PAPER = 0, /* the paper's, as far as the paper tells. It stays as it is, for comparisons */
    MLRT_KDTREE_TUNED = 1  /* larger leaves, smaller cells: renders faster, takes longer to build */
};

/* Rules of the kd-tree's builder that can be switched off to measure their effect: mlrt_kdtree_options.rules_off */
enum {
    MLRT_RULE_EMPTY_SPACE = 1,  /* an empty side of more than 10 % of a cell is cut off first */
    MLRT_RULE_COPLANAR = 2,     /* a plane that triangles in it cover wholly is a split; they go to the smaller side */
    MLRT_RULE_MINIMUM_CELL = 4, /* cells under a minimum size are not split */
    MLRT_RULE_CLIPPED_SPLITS = 8, /* candidates come from triangles clipped to the cell, not from bounding boxes */
    MLRT_RULE_RETRACTION = 16     /* a subtree that costs more than a leaf becomes a leaf */
};

/* How to build a kd-tree: mlrt_build_kdtree. NULL, or all zero but struct_size: defaults. */
typedef struct mlrt_kdtree_options {
    uint32_t struct_size;    /* sizeof(mlrt_kdtree_options) */
    int32_t preset;          /* MLRT_KDTREE_* */
    float traversal_cost;    /* of one node step, 0..1e6, relative to intersection_cost; 0 = the preset's */
    float intersection_cost; /* of one triangle, 0..1e6; 0 = the preset's */
    char *message;           /* this and the next three are as in mlrt_tree_options */
    size_t message_size;     /* size of the buffer in bytes */
    const mlrt_host *host;   /* NULL = malloc, and no messages */
    uint64_t memory_limit;   /* most bytes held at one time; 0 = no limit */
    uint64_t max_references; /* most leaf entries, at least one per triangle: at the limit nothing is split any more, so
                                it limits the memory; 0 = 8 per triangle + 1024 */
    uint32_t max_depth;      /* most inner nodes above a leaf, 1..60; 0 = by the number of triangles */
    uint32_t rules_off;      /* MLRT_RULE_* or-ed together: rules to do without; 0 = all rules are on */
    struct mlrt_pool *pool;  /* whose threads build; NULL = the calling thread alone. The tree is the same */
} mlrt_kdtree_options;

/*
 * Builds the paper's kd-tree. In it the default method is the paper's (MLRT_METHOD_MULTILEVEL). Arguments, errors and
 * the triangles that are left out are as in mlrt_build_tree. It is the same tree for any number of threads.
 *
 * It is slower to build and to trace than the tree of mlrt_build_tree. Memory per triangle, its own 36 bytes included:
 * 40 to 95 bytes, and 1.8 to 2.4 times that while the tree is built; up to 25 % more with several threads.
 *
 * Method: surface area heuristic over clipped split candidates (V. Havran, J. Bittner, "On improving kd-trees for ray
 * shooting", 2002) with the three rules of the paper (section 3.1).
 */
MLRT_API int32_t mlrt_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                                   mlrt_tree **tree);

/* An estimate of the memory that a builder takes: mlrt_estimate_tree, mlrt_estimate_kdtree. */
typedef struct mlrt_memory_estimate {
    uint32_t struct_size;      /* sizeof(mlrt_memory_estimate) */
    uint32_t reserved;         /* set to 0 */
    uint64_t memory_size;      /* bytes held by the tree */
    uint64_t peak_memory_size; /* most bytes held at one time while building */
} mlrt_memory_estimate;

/*
 * Estimates the memory of mlrt_build_tree with the same arguments, from the numbers of triangles alone.
 *
 *   meshes      as for mlrt_build_tree; of each, struct_size and triangle_count are enough.
 *   mesh_count  the number of meshes.
 *   options     NULL = defaults.
 *   estimate    receives the estimate (struct_size must be set).
 *
 * Scenes of more than a few thousand triangles take 80 to 110 % of it, flat grids less. Only a memory_limit is sure to
 * hold.
 */
MLRT_API int32_t mlrt_estimate_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                                    mlrt_memory_estimate *estimate);

/* Estimates the memory of mlrt_build_kdtree from the same arguments: a guess, which can be off by a factor of two. */
MLRT_API int32_t mlrt_estimate_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                                      mlrt_memory_estimate *estimate);

/* Frees a tree. No call may be using it. NULL is allowed. */
MLRT_API void mlrt_destroy_tree(mlrt_tree *tree);

/*
 * The build report. Counts are those of the finished tree. In the report of a loaded tree build_seconds is 0, and the
 * sizes in bytes are those of loading it.
 */
typedef struct mlrt_tree_info {
    uint32_t struct_size;      /* sizeof(mlrt_tree_info) */
    uint32_t depth;            /* inner nodes above the deepest leaf */
    uint64_t triangle_count;   /* as given, with those that were left out */
    uint64_t non_finite_count; /* left out: a vertex is NaN or infinite */
    uint64_t zero_area_count;  /* left out: the area is exactly zero */
    uint64_t node_count;       /* kd-tree: inner nodes and leaves; boxes: inner nodes, as leaves are not nodes */
    uint64_t leaf_count;       /* with the empty ones */
    uint64_t empty_leaf_count; /* boxes: 0 */
    uint64_t reference_count;  /* entries of all leaves together: a triangle can be in several */
    uint64_t retracted_count;  /* subtrees turned back into leaves; boxes: 0 */
    uint64_t memory_size;      /* bytes held by the tree */
    uint64_t peak_memory_size; /* most bytes held at one time while building */
    uint64_t tree_hash;        /* over nodes and leaf entries: equal trees have equal hashes */
    double sah_cost;           /* expected cost of a random ray through the scene's box, in units of a triangle's cost
                                  (kd-tree) or of a node's (boxes) */
    double build_seconds;      /* time that passed during the whole call */
    float bounds_min[3];       /* the least coordinates of triangles in the tree; all 0 if there is none */
    float bounds_max[3];       /* the greatest coordinates; all 0 if there is no triangle */
    uint32_t structure;        /* MLRT_STRUCTURE_*: that of the tree, built or loaded */
    uint32_t reserved;         /* set to 0 */
} mlrt_tree_info;

/* Writes the build report of a tree to *info (struct_size must be set). */
MLRT_API int32_t mlrt_get_tree_info(const mlrt_tree *tree, mlrt_tree_info *info);

/* ------------------------------------------------------------------------------------------------------------------
 * Saving and loading
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * Writes a tree of either structure to memory, with its triangles, for mlrt_load_tree.
 *
 *   tree      the tree, which stays as it is.
 *   buffer    where to write; NULL = nowhere, to learn the size.
 *   capacity  size of `buffer` in bytes. If it is too small, nothing is written: MLRT_ERROR_ARGUMENT.
 *   size      receives the number of bytes that the saved tree takes, also if `capacity` is too small.
 */
MLRT_API int32_t mlrt_save_tree(const mlrt_tree *tree, void *buffer, size_t capacity, size_t *size);

/* Flags of mlrt_load_tree: mlrt_load_options.flags, or-ed together */
enum {
    MLRT_LOAD_IN_PLACE = 1 /* use the data where it lies: it must stay unchanged until the tree is destroyed */
};

/* How to load: mlrt_load_tree. NULL, or all zero but struct_size: defaults. */
typedef struct mlrt_load_options {
    uint32_t struct_size;   /* sizeof(mlrt_load_options) */
    uint32_t flags;         /* MLRT_LOAD_* */
    uint64_t geometry_hash; /* what mlrt_hash_geometry says of the wanted triangles: data of others are
                               MLRT_ERROR_DATA. 0 = any triangles */
    uint64_t memory_limit;  /* as in mlrt_tree_options */
    char *message;          /* NULL, or a buffer that receives details of an error (UTF-8, terminated) */
    size_t message_size;    /* size of the buffer in bytes */
    const mlrt_host *host;  /* NULL = malloc, and no messages */
} mlrt_load_options;

/*
 * Makes a tree from the bytes that mlrt_save_tree wrote: the same tree, of the same structure, with the same answers.
 *
 *   data     the bytes, at any address, also of a file mapped into memory. With MLRT_LOAD_IN_PLACE, if the address is a
 *            multiple of 64, they are used where they lie, and the tree takes next to no memory of its own; at other
 *            addresses they are copied.
 *   size     the number of bytes.
 *   options  NULL = defaults.
 *   tree     receives the tree, or NULL after an error.
 *
 * All of it is checked: any bytes give a tree that is safe to use, or MLRT_ERROR_DATA. A hash over everything detects
 * accidental damage, but no forgery: a forged file can give wrong answers, but do no other harm. MLRT_ERROR_DATA also
 * means another version of the format, or another byte order: so keep the meshes, to build the tree again. The host's
 * `progress` is not called.
 */
MLRT_API int32_t mlrt_load_tree(const void *data, size_t size, const mlrt_load_options *options, mlrt_tree **tree);

/*
 * Computes a hash of meshes: of their ids, masks, and the corners of all triangles in order. It tells whether a saved
 * tree is still that of the caller's meshes. It does not depend on indices, on the layout in memory, or on the machine.
 * Corners count bit for bit, so that 0 and -0 differ.
 *
 *   meshes      as for mlrt_build_tree, but ids are not compared with each other.
 *   mesh_count  the number of meshes.
 *   hash        receives the hash.
 */
MLRT_API int32_t mlrt_hash_geometry(const mlrt_mesh *meshes, size_t mesh_count, uint64_t *hash);

/* ------------------------------------------------------------------------------------------------------------------
 * Threads
 * ------------------------------------------------------------------------------------------------------------------ */

/* A pool: the threads that share the work of a call, its own or those of the host's job system. */
typedef struct mlrt_pool mlrt_pool;

/*
 * Creates a pool of `thread_count` threads, 1..1024, of which the calling thread is one: thread_count - 1 threads are
 * started, and sleep between calls. 0 = one per processor that is online. They have the signal mask of the caller, and
 * stacks of the system's size, but of 1 MiB at least. Free the pool with mlrt_destroy_pool.
 */
MLRT_API int32_t mlrt_create_pool(uint32_t thread_count, mlrt_pool **pool);

/* A task for the host's job system, which calls it once, with the argument that `enqueue` received. */
typedef void (*mlrt_task_function)(void *argument);

/*
 * Hands a task to the host's job system, which calls function(argument) once, on any thread, now or later. Returns a
 * handle for `finish`, or NULL if it has already run the task.
 */
typedef void *(*mlrt_enqueue_callback)(void *user, mlrt_task_function function, void *argument);

/* Waits until a task has run, whose handle (not NULL) `enqueue` returned. It may run this and other tasks meanwhile. */
typedef void (*mlrt_finish_callback)(void *user, void *task);

/* How to make a pool: mlrt_create_pool_with_options. All zero but struct_size: that of mlrt_create_pool with 0. */
typedef struct mlrt_pool_options {
    uint32_t struct_size;  /* sizeof(mlrt_pool_options) */
    uint32_t thread_count; /* as in mlrt_create_pool; with `enqueue`: most tasks at once, the calling thread included */
    const mlrt_host *host; /* NULL = malloc */
    void *user;            /* the first argument of `enqueue` and `finish` */
    mlrt_enqueue_callback enqueue; /* NULL = the pool starts threads of its own */
    mlrt_finish_callback finish;   /* must be given with `enqueue`, and must be NULL without */
} mlrt_pool_options;

/*
 * Creates a pool with options (not NULL), such as one without threads that shares work through the host's job system.
 *
 * A call with such a pool enqueues at most thread_count - 1 tasks at a time and works on the same items itself. Before
 * it returns, it calls `finish` for every task whose `enqueue` did not return NULL. A task may start late, or only in
 * `finish`: the others do its work. A call waits for nothing else. So it may be made from within a job, and several
 * calls may use such a pool at once, without waiting for each other. (E. Catto's Box2D 3 has hooks like these.)
 */
MLRT_API int32_t mlrt_create_pool_with_options(const mlrt_pool_options *options, mlrt_pool **pool);

/*
 * The thread_count of a pool; where that was 0, the threads that there are. Workers of a call (mlrt_tile.worker) have
 * numbers below it. NULL is no pool, so the calling thread alone: 1. From any thread, also in callbacks.
 */
MLRT_API uint32_t mlrt_pool_thread_count(const mlrt_pool *pool);

/* Ends the threads and frees the pool. No call may be using it. NULL is allowed. */
MLRT_API void mlrt_destroy_pool(mlrt_pool *pool);

/* ------------------------------------------------------------------------------------------------------------------
 * Tracing: options, results, counters
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * Methods: mlrt_trace_options.method. The answers are the same from each. RAY traces trees of both structures. Each
 * other method traces trees of one structure; for a tree of the other the answer is MLRT_ERROR_UNSUPPORTED. In
 * mlrt_trace_ray the ray goes alone, whatever the method.
 */
enum {
    MLRT_METHOD_DEFAULT = 0, /* boxes: TILE; kd-tree: MULTILEVEL, the paper's */
    MLRT_METHOD_RAY = 1,     /* one ray at a time in double, plain C: the reference */
    MLRT_METHOD_PACKET2 = 2, /* kd-tree: 2x2 rays with masks (I. Wald et al., "Interactive Rendering with Coherent Ray
                                Tracing", 2001) */
    MLRT_METHOD_PACKET4 = 3, /* kd-tree: 4x4 rays by interval traversal from the root (the paper, section 4.3) */
    MLRT_METHOD_MULTILEVEL = 4, /* kd-tree: the same from entry points of beams (the paper, sections 3.3 to 4.2) */
    MLRT_METHOD_TILE = 5        /* boxes: a tile of 16 packets of 16 rays goes down together, as a bundle. Pictures of a
                            pinhole camera, and any-hit rays with one origin or direction, begin with bundles of 16
                            tiles, which need no rays. Packets too wide for a bundle go lane by lane; where few rays
                            meet a box, each goes alone */
};

/*
 * Instruction sets: mlrt_trace_options.isa. The answers are the same from each. One that this machine or build does not
 * have is MLRT_ERROR_UNSUPPORTED.
 *
 * Method tile uses the one that is asked for. Methods packet4 and multilevel have AVX2 in place of AVX-512. Method
 * packet2, and calls with counters, use the narrowest one of the build, whichever is asked for: SSE2, NEON, or plain C
 * in builds with neither. Method ray is plain C.
 */
enum {
    MLRT_ISA_AUTO = 0,   /* the best that this machine has */
    MLRT_ISA_SCALAR = 1, /* plain C: only in builds without SSE2 and NEON, which have no other */
    MLRT_ISA_SSE = 2,    /* SSE2, on every x86-64: 4 boxes, packets, triangles or rays at a time */
    MLRT_ISA_AVX2 = 3,   /* AVX2 and FMA: 8 at a time */
    MLRT_ISA_AVX512 = 4, /* AVX-512 F and DQ: 16 at a time */
    MLRT_ISA_NEON = 5    /* NEON, on every aarch64 (little-endian), which has no other: 4 at a time */
};

/* Queries: mlrt_trace_options.query */
enum {
    MLRT_QUERY_CLOSEST = 0, /* the closest hit: writes all of mlrt_hits but `occluded` */
    MLRT_QUERY_ANY = 1      /* whether there is a hit: writes only mlrt_hits.occluded */
};

/* Method multilevel: how a beam is tested against a cell (the paper, section 3.3), mlrt_trace_options.culling */
enum {
    MLRT_CULLING_INVERSE = 0, /* the planes of the cell against the beam */
    MLRT_CULLING_DIRECT = 1   /* the planes of the beam against the cell */
};

/*
 * Shortcuts that method multilevel takes beyond the paper: mlrt_trace_options.shortcuts_off. Each can be switched off,
 * to measure its effect; without all of them the paper's algorithm remains.
 */
enum {
    MLRT_SHORTCUT_WHOLE_TILES = 1, /* a tile that one triangle provably covers, nearer than all else, is done at once */
    MLRT_SHORTCUT_ENTRY_LISTS = 2, /* packets start at a list of leaves, not at the one node above them all */
    MLRT_SHORTCUT_SHARED_SETUPS = 4 /* terms of a triangle and an origin are kept for the packets that follow; so does
                                       method packet4 */
};

/* Results that a tile callback receives: mlrt_trace_options.outputs */
enum {
    MLRT_OUTPUT_T = 1,         /* t */
    MLRT_OUTPUT_UV = 2,        /* u and v */
    MLRT_OUTPUT_IDS = 4,       /* mesh and triangle */
    MLRT_OUTPUT_FACING = 8,    /* facing */
    MLRT_OUTPUT_TRIANGLE = 16, /* triangle without mesh, half as much to write: for trees of one mesh */
    MLRT_OUTPUT_OCCLUDED = 32  /* with `lights`: occluded */
};

/*
 * Counts of the work of tracing. Those of the kd-tree are in units of 4x4 packets, as the columns of the paper's table
 * 2. Counts are added to those in the struct, so that one struct can collect several calls, one at a time; those that
 * the library does not know stay. They can differ between methods, machines, and calls, since method tile goes the way
 * that was faster for the last rays. Counting takes time: with counters, the kernels of the narrowest instruction set
 * run (MLRT_ISA_*).
 *
 * Method tile traces sixteen packets, or sixteen tiles of them, together. So up to 256 or 4096 rays share a cell or a
 * test, and its counts cannot be compared with those of the kd-tree. It has no beams and no entry points: their
 * counters do not change.
 */
typedef struct mlrt_counters {
    uint32_t struct_size;  /* sizeof(mlrt_counters) */
    uint32_t reserved;     /* must be 0 */
    uint64_t ray_count;    /* rays traced. Of shadow rays of a picture's lights, method tile counts those that it makes:
                              where one triangle covers many pixels, it decides their shadows without rays */
    uint64_t packet_count; /* kd-tree: groups of rays traced together (packets, or less where directions differ), and
                              rays that went alone. Method tile: packets that went lane by lane, and rays that went
                              alone, counted each time */
    uint64_t beam_count;   /* beams for which an entry point was searched */
    uint64_t cell_count;   /* kd-tree: inner nodes and leaves descended into or popped, with those of the entry-point
                              search. Method tile: nodes and leaves that a bundle, a packet that went lane by lane, or a
                              ray that went alone opened */
    uint64_t entry_point_cell_count;  /* of these, in the entry-point search */
    uint64_t triangle_test_count;     /* (packet, triangle) tests that at least one ray takes part in. Method tile: also
                                         (ray, triangle) tests of rays that went alone */
    uint64_t judged_lane_count;       /* (ray, triangle) pairs that the float filter left to double arithmetic */
    uint64_t entry_point_count;       /* entry points from which packets were traced */
    uint64_t entry_point_depth_sum;   /* their depths below the root, added up */
    uint64_t missed_beam_count;       /* beams that provably hit nothing: none of their rays was traced */
    uint64_t covered_beam_count;      /* beams whose rays all provably hit one triangle first: none was traced */
    uint64_t undecided_cull_count;    /* inner nodes where the culling test could exclude no child */
    uint64_t undecided_checked_count; /* of these, still undecided after the extra check */
    uint64_t lane_test_count;         /* (ray, triangle) pairs that the float filter tested */
    uint64_t undecided_test_count;    /* of triangle_test_count, those with a judged ray */
    uint64_t tie_lane_count;          /* (ray, triangle) pairs settled because the nearest hit lies in the same plane */
    uint64_t exact_edge_count;        /* decisions left to exact arithmetic: on which side of an edge a ray passes */
    uint64_t exact_range_count;       /* decisions left to exact arithmetic: is a hit within t_min and t_max? */
    uint64_t exact_order_count;       /* decisions left to exact arithmetic: which of two hits is nearer? */
} mlrt_counters;

/*
 * How to trace. NULL, or all zero but struct_size: defaults.
 *
 * A picture is cut into squares of initial_tile_size; threads claim them one by one, and a tile callback gets one at a
 * time. In method multilevel, initial_tile_size, minimum_tile_size and split_factor are the tile sizes of the paper,
 * section 4.2: a tile larger than minimum_tile_size whose entry point is not a leaf is cut into split_factor pieces,
 * and so on. Method tile has levels of its own, of 64, 16 and 4 pixels, or less where initial_tile_size is less; it
 * checks minimum_tile_size, split_factor, culling, culling_check and shortcuts_off, but does not use them.
 */
typedef struct mlrt_trace_options {
    uint32_t struct_size;       /* sizeof(mlrt_trace_options) */
    int32_t query;              /* MLRT_QUERY_* */
    int32_t method;             /* MLRT_METHOD_* */
    int32_t isa;                /* MLRT_ISA_* */
    int32_t culling;            /* MLRT_CULLING_* */
    uint32_t culling_check;     /* 1 = check cells that the culling test leaves undecided against all their faces */
    uint32_t initial_tile_size; /* pixels, 4..1024, a power of two; 0 = default, by source and method */
    uint32_t minimum_tile_size; /* pixels, 4..initial_tile_size, a power of two; 0 = default */
    uint32_t split_factor;      /* 4 or 16; 0 = 16 */
    uint32_t outputs;           /* MLRT_OUTPUT_* or-ed together: the results that a tile callback receives */
    uint32_t shortcuts_off;     /* MLRT_SHORTCUT_* or-ed together: shortcuts of multilevel to do without */
    uint32_t mask;              /* rays see the meshes whose mask has a bit in common with it; 0 = all bits */
    mlrt_pool *pool;            /* whose threads trace; NULL = the calling thread alone */
    mlrt_counters *counters;    /* NULL = nothing is counted. With counters, narrower kernels run (MLRT_ISA_*) */
    const mlrt_host *host;      /* NULL = malloc, and no messages. mlrt_trace_ray does not use it */
    const struct mlrt_light *lights; /* mlrt_render_tiles with MLRT_QUERY_CLOSEST: lights whose shadows `occluded`
                                        receives; NULL = none. Must be NULL in all other calls */
    uint32_t light_count;            /* number of lights, 0..8 */
    uint32_t reserved;               /* must be 0 */
} mlrt_trace_options;

/* An array of results. With `data` = NULL they are not wanted, and not computed. */
typedef struct mlrt_array {
    void *data;        /* the first element; NULL = not wanted */
    size_t stride;     /* bytes from one element to the next; 0 = packed */
    size_t row_stride; /* bytes from one row of pixels to the next, in mlrt_render_tiles and mlrt_camera_rays; 0 =
                          packed */
} mlrt_array;

/*
 * The arrays that receive results. MLRT_QUERY_CLOSEST writes the first six, and with lights also the last;
 * MLRT_QUERY_ANY writes only the last. An array that the query does not write must be NULL, and one must be given,
 * unless there are no rays, or the call has a callback or counters.
 *
 * `mesh`, `triangle` and `facing` tell hits from misses. `t` does not: the t of a hit farther away than the greatest
 * float rounds to inf, which is that of a miss, and a very small one rounds to 0, though 0 < t.
 *
 * With lights, bit k of `occluded` is 1 if light k of the options does not reach the hit: something is in between, or
 * the light is on the other side of the surface, or it is so far away that no ray of floats leads to it ("Shadows of a
 * picture" below).
 */
typedef struct mlrt_hits {
    uint32_t struct_size; /* sizeof(mlrt_hits) */
    uint32_t reserved;    /* must be 0 */
    mlrt_array t;         /* float: the distance in units of |d|, rounded; inf for a miss, and for hits as above */
    mlrt_array u;         /* float: the weight of the triangle's second vertex */
    mlrt_array v;         /* float: the weight of its third */
    mlrt_array mesh;      /* uint32_t: the id of the mesh; MLRT_NONE = miss */
    mlrt_array triangle;  /* uint32_t: the number of the triangle in its mesh; MLRT_NONE = miss */
    mlrt_array facing;    /* int32_t: the sign of d . n; 0 = miss */
    mlrt_array occluded;  /* uint8_t: 1 = something is hit, 0 = nothing. With lights a bit for each (above); 0 = miss */
} mlrt_hits;

/* ------------------------------------------------------------------------------------------------------------------
 * Tracing rays
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * The stride of an input array whose one element serves all rays: a common origin, direction, t_max and so on. The
 * answers are those of the array written out in full. Arrays of meshes and of results cannot have this stride
 * (MLRT_ERROR_ARGUMENT). For languages that cannot read this line: all bits of a size_t are set.
 */
#define MLRT_STRIDE_ALL ((size_t)-1)

/* An input array. One that may be left out is left out by `data` = NULL. */
typedef struct mlrt_const_array {
    const void *data; /* the first element */
    size_t stride;    /* bytes from one element to the next; 0 = packed; MLRT_STRIDE_ALL = one element serves all */
} mlrt_const_array;

/*
 * Rays, in the caller's arrays.
 *
 * Rays are grouped in the order given: 16 to a packet, and packets to tiles. A group is fast if its rays are alike: if
 * they go nearly the same way, or begin or end near each other; the arrays may have any strides. Give the length of
 * rows of pixels in `row_length`, and groups are squares; without it, mlrt_trace_packet looks for rows. Answers do not
 * depend on the grouping.
 */
typedef struct mlrt_rays {
    uint32_t struct_size;        /* sizeof(mlrt_rays) */
    uint32_t row_length;         /* rays in a row of a picture; 0 = not known. A hint for speed only */
    size_t count;                /* at most 2^31 - 1 */
    mlrt_const_array origins;    /* float[3] */
    mlrt_const_array directions; /* float[3], of any length */
    mlrt_const_array t_min;      /* float; NULL = 0 for all */
    mlrt_const_array t_max;      /* float; NULL, or inf = no limit. 0 here means 0: no hits */
    mlrt_const_array skip; /* uint32_t[2]: mesh and triangle, as reported, that the ray passes through; NULL = none */
    mlrt_const_array mask; /* uint32_t: a mask for each ray in place of that of the options (0 = all bits). NULL = all
                              rays have that of the options. If the tree's meshes have masks, this takes longer */
    uint32_t rays_per_origin; /* k: each k neighbouring rays start at one point. Ray i has element i / k of origins,
                                 t_min and skip, which have count / k elements, and element i of the other arrays.
                                 0 = 1. k must divide count. If k > 1, rays are grouped in the order given, and
                                 row_length is not used */
    uint32_t reserved;        /* must be 0 */
} mlrt_rays;

/*
 * Traces any number of rays.
 *
 *   tree     the tree.
 *   rays     the rays.
 *   options  the query, and how to trace; NULL = the closest hits, by the calling thread.
 *   hits     the arrays for results: those of ray i go to element i.
 *
 * With a pool, its threads share the rays. Threads, method and grouping never change a bit of the results. After an
 * error the arrays hold the results of some rays only, or of none.
 */
MLRT_API int32_t mlrt_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                   const mlrt_hits *hits);

/* Flags of a ray: mlrt_ray.flags, or-ed together */
enum {
    MLRT_RAY_SKIP = 1 /* the ray passes through the triangle of skip_mesh and skip_triangle */
};

/* A ray, for mlrt_trace_ray. */
typedef struct mlrt_ray {
    uint32_t struct_size;   /* sizeof(mlrt_ray) */
    uint32_t flags;         /* MLRT_RAY_* */
    float origin[3];        /* o */
    float direction[3];     /* d, of any length */
    float t_min;            /* 0 = hits in front of the origin */
    float t_max;            /* 0 or inf = no limit */
    uint32_t skip_mesh;     /* with MLRT_RAY_SKIP: the mesh, as reported, of the triangle to pass through */
    uint32_t skip_triangle; /* with MLRT_RAY_SKIP: that triangle, as reported */
} mlrt_ray;

/* The result of mlrt_trace_ray. */
typedef struct mlrt_hit {
    uint32_t struct_size; /* sizeof(mlrt_hit) */
    float t;              /* the distance in units of |d|, rounded; inf for a miss, and can be for a hit (mlrt_hits) */
    float u;              /* the weight of the triangle's second vertex */
    float v;              /* the weight of its third */
    uint32_t mesh;        /* the id of the mesh; MLRT_NONE = miss */
    uint32_t triangle;    /* the number of the triangle in its mesh; MLRT_NONE = miss */
    int32_t facing;       /* the sign of d . n; 0 = miss */
    uint32_t occluded;    /* 1 = something is hit, 0 = nothing. With MLRT_QUERY_ANY no other field is written */
} mlrt_hit;

/*
 * Traces one ray. For more than a few use mlrt_trace_packet: for rays that are alike it is many times faster per ray.
 *
 *   tree     the tree.
 *   ray      the ray.
 *   options  the query, and how to trace; NULL = the closest hit. A pool does nothing.
 *   hit      receives the result (struct_size must be set).
 */
MLRT_API int32_t mlrt_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                                mlrt_hit *hit);

/* ------------------------------------------------------------------------------------------------------------------
 * All hits of a ray
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * The arrays that receive lists of hits: `capacity` elements per ray, so hit j of ray i is element i * capacity + j. An
 * array with data = NULL is not wanted. Elements after the last hit of a ray are written as misses.
 */
typedef struct mlrt_hit_lists {
    uint32_t struct_size; /* sizeof(mlrt_hit_lists) */
    uint32_t capacity;    /* most hits written per ray; 0 = only the totals are: all arrays of hits must be NULL */
    mlrt_array t;         /* float; this and the next five are as in mlrt_hits */
    mlrt_array u;         /* float */
    mlrt_array v;         /* float */
    mlrt_array mesh;      /* uint32_t */
    mlrt_array triangle;  /* uint32_t */
    mlrt_array facing;    /* int32_t */
    mlrt_array crossing;  /* uint8_t: 1 = this hit crosses the surface, 0 = it only touches it, or there is no hit */
    mlrt_array total;     /* uint32_t, one per ray: the number of its hits, with those beyond `capacity` */
    mlrt_array crossing_total; /* uint32_t, one per ray: the number of these that cross the surface */
} mlrt_hit_lists;

/*
 * Finds every triangle that each ray hits, in the order of the closest-hit rule: by N / D, equal ones as in the input.
 *
 * A ray through an edge or a corner hits each triangle there. To tell inside from outside, such hits must count as one.
 * So each hit says whether it is a `crossing`: whether it would still be a hit, t_max aside, if the origin were moved
 * by (e, e^2, e^3) for any positive e that is small enough (symbolic perturbation: H. Edelsbrunner, E. P. Muecke,
 * "Simulation of Simplicity", 1990). For any ray with t_max = inf from a point that does not lie on a closed mesh,
 * crossing_total is odd if the point is inside the mesh, and even if it is outside.
 *
 *   tree     the tree.
 *   rays     the rays.
 *   options  NULL = defaults. All fields are checked, but only mask, pool, counters and host are used.
 *   lists    the arrays for results.
 *
 * MLRT_ERROR_OUT_OF_MEMORY is possible, as memory grows with the number of hits of one ray. The arrays then hold the
 * results of some rays only.
 */
MLRT_API int32_t mlrt_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                     const mlrt_hit_lists *lists);

/* ------------------------------------------------------------------------------------------------------------------
 * Tracing pictures
 * ------------------------------------------------------------------------------------------------------------------ */

/* How rays leave a camera: mlrt_camera.projection */
enum {
    MLRT_PROJECTION_PINHOLE = 0, /* rays from one point */
    MLRT_PROJECTION_PARALLEL = 1 /* rays in one direction: an orthographic camera, the view of a directional light */
};

/*
 * A camera. Pixel (i, j), counted from the upper left or from any other corner, has the vector p = d00 + x dx + y dy,
 * where x = i + sample_x and y = j + sample_y, and the ray
 *
 *     pinhole:   origin eye, direction p               parallel:   origin p, direction `direction`
 *
 * in exactly this arithmetic, each step rounded to float, for each component k:
 *     x = fl(i + sample_x), y = fl(j + sample_y), p_k = fl(fl(d00_k + fl(x dx_k)) + fl(y dy_k)).
 * So mlrt_camera_rays, or the caller, can write out exactly the rays that mlrt_render_tiles traces.
 */
typedef struct mlrt_camera {
    uint32_t struct_size; /* sizeof(mlrt_camera) */
    int32_t projection;   /* MLRT_PROJECTION_* */
    uint32_t width;       /* columns of the whole picture, 1..2^23. The crop has at most 2^31 - 1 pixels */
    uint32_t height;      /* rows of the whole picture, 1..2^23 */
    uint32_t crop_x;      /* the first column to render: column 0 of the frame */
    uint32_t crop_y;      /* the first row to render: row 0 of the frame */
    uint32_t crop_width;  /* columns to render; 0 = up to the last */
    uint32_t crop_height; /* rows to render; 0 = up to the last */
    float eye[3];         /* pinhole: where the rays start */
    float direction[3];   /* parallel: where the rays go */
    float d00[3];         /* p of x = 0, y = 0 */
    float dx[3];          /* from p of one pixel to that of the next in a row */
    float dy[3];          /* from p of one row to that of the next */
    float sample_x;       /* where in the pixel, along the row: 0.5 = the middle */
    float sample_y;       /* where in the pixel, across the rows: 0.5 = the middle */
    float t_min;          /* 0 = hits in front of the origin */
    float t_max;          /* 0 or inf = no limit */
} mlrt_camera;

/*
 * The results of a finished tile, as arrays: that of pixel (x + i, y + j), counted like the camera's pixels, is element
 * j * width + i. Arrays that the options' `outputs` do not name are NULL; with MLRT_QUERY_ANY, all but `occluded` are.
 * They are valid until the callback returns, and lie in the worker's cache. Calls that run at the same time have
 * different numbers in `worker`. (With a pool that has hooks this is the number of a task; any thread may run it.)
 */
typedef struct mlrt_tile {
    uint32_t struct_size;     /* sizeof(mlrt_tile), the library's */
    uint32_t worker;          /* number of the worker, below mlrt_pool_thread_count; 0 is the thread of the call */
    uint32_t x;               /* the column of its first pixel */
    uint32_t y;               /* the row of its first pixel */
    uint32_t width;           /* in pixels */
    uint32_t height;          /* in pixels */
    const float *t;           /* with MLRT_OUTPUT_T; elements are as in mlrt_hits */
    const float *u;           /* with MLRT_OUTPUT_UV */
    const float *v;           /* with MLRT_OUTPUT_UV */
    const uint32_t *mesh;     /* with MLRT_OUTPUT_IDS */
    const uint32_t *triangle; /* with MLRT_OUTPUT_IDS or MLRT_OUTPUT_TRIANGLE */
    const int32_t *facing;    /* with MLRT_OUTPUT_FACING */
    const uint8_t *occluded;  /* with MLRT_QUERY_ANY, or lights and MLRT_OUTPUT_OCCLUDED */
} mlrt_tile;

/*
 * Receives each tile once: squares of initial_tile_size, smaller at the edges. The threads of the pool call it, several
 * at a time. It may call any tracing function, but not with the pool of the render, unless that pool has tasks
 * (mlrt_pool_options.enqueue). Return 0 to go on. Any other result ends the render soon: mlrt_render_tiles returns
 * MLRT_ERROR_CANCELLED.
 */
typedef int32_t (*mlrt_tile_callback)(void *user, const mlrt_tile *tile);

/*
 * Renders a picture: traces the ray of every pixel of the camera's crop.
 *
 *   tree      the tree.
 *   camera    the camera.
 *   options   the query, and how to trace; NULL = the closest hits, by the calling thread.
 *   frame     the arrays for results: element (column, row) of the crop, with their strides. NULL = none.
 *   callback  receives the results of each tile; NULL = none.
 *   user      the first argument of the callback.
 *
 * A frame with an array, a callback, or counters in the options must be given. A pixel without a valid ray (its
 * direction rounds to 0, for example) is a miss.
 */
MLRT_API int32_t mlrt_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                                   const mlrt_hits *frame, mlrt_tile_callback callback, void *user);

/*
 * Writes out the rays of a camera's crop, row by row: crop_width * crop_height origins and directions. Tracing them
 * gives the results of mlrt_render_tiles, bit for bit.
 *
 *   camera      the camera. Its t_min and t_max are not written.
 *   origins     receives float[3] for each ray; NULL, or data = NULL: not wanted.
 *   directions  receives float[3] for each ray; NULL, or data = NULL: not wanted.
 */
MLRT_API int32_t mlrt_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions);

/* ------------------------------------------------------------------------------------------------------------------
 * Light
 * ------------------------------------------------------------------------------------------------------------------ */

/* Kinds of lights: mlrt_light.kind */
enum {
    MLRT_LIGHT_POINT = 0,      /* position = that of the light */
    MLRT_LIGHT_DIRECTIONAL = 1 /* position = the direction towards the light, of any length */
};

/* A light. */
typedef struct mlrt_light {
    uint32_t struct_size; /* sizeof(mlrt_light) */
    int32_t kind;         /* MLRT_LIGHT_* */
    float position[3];    /* must be finite */
} mlrt_light;

/* Points of which mlrt_occluded_points tells whether they are in shadow. */
typedef struct mlrt_points {
    uint32_t struct_size;       /* sizeof(mlrt_points) */
    uint32_t row_length;        /* points in a row of a picture; 0 = not known. A hint for speed only */
    size_t count;               /* at most 2^31 - 1 */
    mlrt_const_array positions; /* float[3] */
    mlrt_const_array skip; /* uint32_t[2]: mesh and triangle that the point lies on: it does not shade the point. NULL =
                              none */
} mlrt_points;

/*
 * Finds out which points are in the shadow of a light.
 *
 *   tree      the tree, whose triangles cast the shadows.
 *   points    the points.
 *   light     the light.
 *   options   NULL = defaults. Its `query` must be one of MLRT_QUERY_*, but is ignored.
 *   occluded  uint8_t: element i receives 1 if something lies between point i and the light, 0 if nothing does. Its
 *             data must not be NULL.
 *
 * The ray of point P is o = L, d = fl(P - L) per component, 0 < t <= 1 for a point light at L, and o = P, d = position,
 * 0 < t for a directional light. A point that is at the light itself, or has a coordinate that is not finite, is not
 * occluded. For points on a surface, move them off it by mlrt_offset_point, and name the triangle in `skip`.
 */
MLRT_API int32_t mlrt_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                      const mlrt_trace_options *options, const mlrt_array *occluded);

/*
 * Shadows of a picture. With `lights` in the options, mlrt_render_tiles finds out for each pixel which lights reach the
 * point that it shows. This is much faster than mlrt_occluded_points, as no points have to leave the library. If the
 * ray o + t d of a pixel hits a triangle abc, bit k of `occluded` is 1 where light k does not reach the hit:
 *
 *   - A light does not reach it unless it is strictly on that side of abc's plane from which the ray came (a
 *     directional light: unless its direction points strictly to that side). A light also counts as one on the other
 *     side if the ray below would leave the range of float: if d' (point light) or o' (directional light) would have a
 *     component beyond the greatest float.
 *   - Otherwise a ray decides: for a point light at L, from o' = L along d' for 0 < t <= 1; for a directional light,
 *     from o' along d' = position (with 0 for -0) for 0 < t. Its end L + d', or its origin o', is a point just off the
 *     hit, surely on the side from which the picture's ray came. It is moved off by about 2^-22 of the greatest
 *     coordinate relative to the eye and to the light; for slivers, and rays that nearly lie in their plane, by as many
 *     floats as it takes. So no triangle shades itself, nor does one in its plane or behind it. The ray sees the meshes
 *     that the picture's rays see (`mask`).
 *
 * mlrt_shadow_ray computes this ray, which is the same on every machine. The answer is that of mlrt_trace_ray for it.
 *
 *   tree    the tree.
 *   ray     a ray that hits something, for example one of mlrt_camera_rays.
 *   hit     its hit: mesh and triangle are read.
 *   light   the light.
 *   shadow  receives the ray that decides, with the triangle to skip (struct_size must be set).
 *   faces   receives 1; or 0 if the light is on the other side, or counts as such because the ray would leave the range
 *           of float. No ray is needed then, and *shadow has a direction of 0. It has one, too, if the point just off the
 *           hit is that of the light: nothing is between them.
 *
 * MLRT_ERROR_ARGUMENT: there is no such triangle, or the ray does not hit it between its t_min and t_max. (What the ray
 * skips does not matter.)
 */
MLRT_API int32_t mlrt_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_hit *hit,
                                 const mlrt_light *light, mlrt_ray *shadow, int32_t *faces);

/*
 * Finds a point just off a triangle a b c: next to (1 - u - v) a + u b + v c, strictly on one side.
 *
 *   tree      the tree that has the triangle.
 *   mesh      the id of its mesh, as reported with hits.
 *   triangle  its number in the mesh, as reported with hits.
 *   u, v      the place on the triangle, as reported with hits; any finite numbers.
 *   side      +1: the side to which the normal (b - a) x (c - a) points; -1: the other one. To get the side from which
 *             a ray came, give -facing of its hit.
 *   point     receives the point.
 *
 * Promise: no ray that starts at the point and goes to the same side, or along the plane, hits that triangle.
 *
 * MLRT_ERROR_ARGUMENT: there is no such triangle, it was left out of the tree, u or v is not finite, or the point would
 * leave the range of float.
 */
MLRT_API int32_t mlrt_offset_point(const mlrt_tree *tree, uint32_t mesh, uint32_t triangle, float u, float v,
                                   int32_t side, float point[3]);

#ifdef __cplusplus
}
#endif

#endif /* MLRT_H */
