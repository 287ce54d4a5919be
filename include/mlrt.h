/* SPDX-License-Identifier: MIT */
/*
 * mlrt.h - where do rays hit triangles: exact answers behind a C ABI, by tiles of rays that go through a tree together
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
 * bits from one ray, a packet or a tile, from every method, instruction set and number of threads. The rule, in real
 * arithmetic, for a ray o + t d and a triangle a b c with normal n = (b - a) x (c - a):
 *
 *   - Never hit: a triangle with a vertex that is not finite, or with n exactly 0. Hits nothing: a ray with a NaN, with
 *     an o or d that is not finite, with d = 0, or without t_min < t_max. A t_min below 0 counts as 0.
 *   - e_ij = d . ((v_i - o) x (v_j - o)), D = d . n = e_ab + e_bc + e_ca, N = (a - o) . n. The ray hits if D is not
 *     0, no D e_ij is negative, and t_min < N / D <= t_max. So triangles are closed and two-sided, the interval is half
 *     open, and a ray in the plane of a triangle misses it.
 *   - The closest hit has the smallest N / D; of equal ones the first in the input wins (mesh by position, then
 *     triangle).
 *   - Any-hit says yes exactly if there is a closest hit.
 *   - Reported are t = N / D, u = e_ca / D (the weight of b), v = e_ab / D (the weight of c), correctly rounded, and
 *     facing = the sign of D: +1 where the ray travels along n, -1 against it. A miss has t = inf, u = v = 0, mesh =
 *     triangle = MLRT_NONE, facing = 0. The t of a hit can round to inf too, if N / D is beyond the range of float and
 *     t_max = inf, and to t_min, so to 0. Mesh, triangle and facing tell hits from misses.
 *
 * Numbers. Lengths are in the units of the mesh, t in units of the length of d, which may be any finite length.
 * Denormals count as what they are. The floating-point environment (rounding, flush-to-zero, exception masks) may be
 * anything: each call sets what it needs and restores what it found.
 *
 * Structs start with `struct_size`, which the caller sets to sizeof; the rest zero means default. Later versions append
 * fields, in multiples of 4 bytes, and never change the meaning or the place of those that are here. So header and
 * library may be of different versions: fields that the caller's struct is too short for count as 0 and are not
 * written; those that the library does not know must be 0, and if they are for results, they are set to 0. Otherwise,
 * and for a size that no version has (less than in 0.1, say, or far more than the library's), the answer is
 * MLRT_ERROR_STRUCT_SIZE. In an array of structs all have the struct_size of the first. mlrt_array and mlrt_const_array
 * have no struct_size and never grow. That of mlrt_tile is set by the library.
 *
 * Arrays are a pointer and a byte stride; stride 0 means packed, and MLRT_STRIDE_ALL that one element serves all rays
 * (input arrays of rays and points only). Addresses and strides must be multiples of 4 (of 2 for 2-byte indices, of 1
 * for uint8_t), and strides, of rows too, at most 2^31, or the answer is MLRT_ERROR_ARGUMENT. No byte outside the
 * elements is read or written.
 *
 * Ownership. Arguments are borrowed for the length of the call; a tree or pool keeps the allocator of the host it was
 * made with, a pool also its hooks, and a tree loaded with MLRT_LOAD_IN_PLACE its data. Only mlrt_create_*,
 * mlrt_build_* and mlrt_load_* hand something out, and it goes to mlrt_destroy_tree or mlrt_destroy_pool. Destroying
 * NULL does nothing.
 *
 * Errors. Functions that can fail return an int32_t status, MLRT_OK = 0 or one of MLRT_ERROR_*; new codes may be added.
 * After an error nothing is leaked and outputs given by handle are NULL. The library never prints, exits or aborts.
 *
 * Threads. There are no threads unless the caller made a pool, and no global state. A tree never changes after it is
 * built: any number of threads may trace it at once. A pool of threads serves one call at a time; calls that share one
 * wait for each other (not so with mlrt_pool_options.enqueue).
 */
#ifndef MLRT_H
#define MLRT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Windows: MLRT_BUILD_DLL where the library is compiled as a DLL; who calls a DLL may define MLRT_USE_DLL. */
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
 * With MLRT_PREFIX defined, functions are named MLRT_PREFIX... in place of mlrt_...: compiled with -DMLRT_PREFIX=game_,
 * the library has game_trace_ray, and so has every program that includes this header with the same definition. It goes
 * on writing mlrt_trace_ray. For a copy of the library within another one; types and constants keep their names.
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
#define mlrt_load_tree                MLRT_RENAMED(load_tree)
#define mlrt_occluded_points          MLRT_RENAMED(occluded_points)
#define mlrt_offset_point             MLRT_RENAMED(offset_point)
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

#define MLRT_VERSION_MAJOR  0       /* of this header; mlrt_version tells the library's */
#define MLRT_VERSION_MINOR  1       /* likewise */
#define MLRT_VERSION_PATCH  0       /* likewise */
#define MLRT_VERSION_STRING "0.1.0" /* the three of them */

/* What functions that can fail return. New codes may be added. */
enum {
    MLRT_OK = 0,                  /* it worked */
    MLRT_ERROR_ARGUMENT = 1,      /* a pointer is NULL that must not be, or a value is out of its range */
    MLRT_ERROR_STRUCT_SIZE = 2,   /* a struct_size is not set, or not of any version */
    MLRT_ERROR_INDEX_RANGE = 3,   /* a triangle names a vertex that does not exist; mlrt_tree_options.message */
    MLRT_ERROR_OUT_OF_MEMORY = 4, /* an allocation failed, or a memory_limit was reached; nothing was kept */
    MLRT_ERROR_TOO_LARGE = 5,     /* more triangles, rays or pixels than 32-bit counts allow */
    MLRT_ERROR_CAMERA = 6,        /* camera of size zero, crop outside of it, numbers not finite, dx and dy parallel */
    MLRT_ERROR_UNSUPPORTED = 7,   /* an instruction set that is not in this machine or build, or a method that goes
                                     through the other structure (MLRT_STRUCTURE_*) */
    MLRT_ERROR_THREAD = 8,        /* the system would not start a thread */
    MLRT_ERROR_CANCELLED = 9,     /* a tile callback or a host's progress function asked to stop */
    MLRT_ERROR_DATA = 10 /* not a saved tree, or one that is damaged, of another version, or of other triangles */
};

/* The id reported for a miss; also what a `skip` entry holds to skip nothing. */
#define MLRT_NONE 0xFFFFFFFFu

/* The library's version as MAJOR * 10000 + MINOR * 100 + PATCH, which can differ from the header's. */
MLRT_API uint32_t mlrt_version(void);

/* What a status code means, as one English phrase. Never NULL: an unknown code has a text too. The string is static. */
MLRT_API const char *mlrt_status_string(int32_t status);

/* What mlrt_capabilities tells, or-ed together. New ones may be added. */
enum {
    MLRT_CAN_SSE = 1,   /* MLRT_ISA_SSE works: in this build, on this machine */
    MLRT_CAN_AVX2 = 2,  /* MLRT_ISA_AVX2 */
    MLRT_CAN_AVX512 = 4 /* MLRT_ISA_AVX512 */
};

/* What this library can do on this machine: MLRT_CAN_*. May be called before anything else. */
MLRT_API uint64_t mlrt_capabilities(void);

/*
 * The structs of this header, in the order of mlrt_struct_sizes. New ones are added at the end.
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
    MLRT_STRUCT_COUNT = 21           /* how many this header has */
};

/*
 * Writes sizeof each struct, as this library was compiled, to sizes[0 .. count - 1]: element MLRT_STRUCT_MESH is that
 * of mlrt_mesh. Elements that this library has no struct for become 0. For bindings that write layouts by hand: one
 * that differs from theirs is of another version, or wrong. May be called before anything else.
 */
MLRT_API void mlrt_struct_sizes(uint32_t *sizes, uint32_t count);

/* ------------------------------------------------------------------------------------------------------------------
 * The host: memory, messages, progress
 * ------------------------------------------------------------------------------------------------------------------ */

/* Returns `size` bytes (not 0), aligned to `alignment` (a power of two, 64 at most), or NULL if there are none. */
typedef void *(*mlrt_allocate_callback)(void *user, size_t size, size_t alignment);

/* Takes back a block (not NULL), with the size and alignment that it was asked for with. */
typedef void (*mlrt_free_callback)(void *user, void *block, size_t size, size_t alignment);

/* What a message is: the `level` of mlrt_log_callback */
enum {
    MLRT_LOG_ERROR = 0,   /* why a call fails, in words */
    MLRT_LOG_WARNING = 1, /* something was left out */
    MLRT_LOG_INFO = 2     /* what was built, and how long it took */
};

/* Receives one line (UTF-8, no newline, 255 bytes at most), valid for the length of the call. */
typedef void (*mlrt_log_callback)(void *user, int32_t level, const char *message);

/*
 * Told how much of a call is done, 0..1 and never less than before: every few milliseconds, and 1 at the end if it went
 * well. Return 0 to go on; anything else (but for the answer to 1) ends the call within some milliseconds, and it
 * returns MLRT_ERROR_CANCELLED. The builder and the methods of kd-trees look less often, and a system that takes back
 * much memory takes its time.
 */
typedef int32_t (*mlrt_progress_callback)(void *user, double fraction);

/*
 * What the program around the library provides: options that have a `host` may point to one. Any function may be NULL.
 *
 * `allocate` and `free` are given both or neither; neither means malloc and free. A call with a host takes all its
 * memory from it, and a tree or a pool that it makes keeps both functions and `user` until it is destroyed. They are
 * called from the thread of the call only, and so is `log`; but mlrt_trace_all_hits calls them from the threads of its
 * pool too, several at a time. `progress` may come from any of these threads, but never twice at a time. None of them
 * may jump out of the library, or use the pool of the call that calls it, unless that pool has tasks.
 */
typedef struct mlrt_host {
    uint32_t struct_size;            /* sizeof(mlrt_host) */
    uint32_t reserved;               /* must be 0 */
    void *user;                      /* handed to all of them */
    mlrt_allocate_callback allocate; /* NULL = malloc */
    mlrt_free_callback free;         /* NULL = free */
    mlrt_log_callback log;           /* NULL = silence */
    mlrt_progress_callback progress; /* NULL = calls run to their end */
} mlrt_host;

/* ------------------------------------------------------------------------------------------------------------------
 * Building a tree
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * A tree: the triangles of any number of meshes, and what finds them (MLRT_STRUCTURE_*). Immutable. All functions take
 * every tree, and how it was built never changes an answer.
 */
typedef struct mlrt_tree mlrt_tree;

/*
 * An indexed triangle mesh in the caller's memory.
 *
 * Vertices are three floats each. Indices are three unsigned integers per triangle, of 2 or 4 bytes; with
 * `indices` = NULL, triangle i consists of the vertices 3i, 3i + 1, 3i + 2. Elements may not overlap.
 */
typedef struct mlrt_mesh {
    uint32_t struct_size; /* sizeof(mlrt_mesh) */
    uint32_t id; /* reported with hits. Ids must differ and not be MLRT_NONE; if all are 0, they are 0, 1, 2, ... */
    const void *vertices;   /* float[3] each, aligned to 4 bytes */
    size_t vertex_count;    /* indices are less than this */
    size_t vertex_stride;   /* bytes from one vertex to the next, a multiple of 4; 0 = 12 */
    const void *indices;    /* NULL = consecutive vertices */
    size_t triangle_count;  /* 0 is allowed */
    size_t triangle_stride; /* bytes from one index triple to the next, a multiple of index_size; 0 = 3 * index_size */
    uint32_t index_size;    /* 2 or 4; 0 = 4 */
    uint32_t mask;          /* seen by rays whose mask has a bit in common; 0 = all bits */
} mlrt_mesh;

/*
 * What a tree finds triangles by: mlrt_tree_info.structure. Each has a builder and methods of its own, one of which is
 * the default there (MLRT_METHOD_*). The answers are the same.
 */
enum {
    MLRT_STRUCTURE_KDTREE = 1, /* the paper's kd-tree, of mlrt_build_kdtree: for study and for the paper's tables */
    MLRT_STRUCTURE_BVH = 2     /* boxes, 16 a node, up to 16 triangles a leaf, of mlrt_build_tree: for all else */
};

/*
 * What boxes to build: mlrt_tree_options.preset
 *
 * FAST refers to each triangle once. Where large triangles lie among small ones the others cut them in two: DEFAULT
 * makes up to 1.15 references per triangle and takes about twice as long to build, BEST up to 1.5 and about twice as
 * long again.
 */
enum {
    MLRT_TREE_DEFAULT = 0, /* the tree that renders fastest here, but for BEST */
    MLRT_TREE_FAST = 1,    /* built fastest, for scenes that change */
    MLRT_TREE_BEST = 2     /* for many pictures of one scene, if it takes memory and time to build does not matter */
};

/* How to build boxes: mlrt_build_tree. NULL or all zero but struct_size = defaults. */
typedef struct mlrt_tree_options {
    uint32_t struct_size;    /* sizeof(mlrt_tree_options) */
    int32_t preset;          /* MLRT_TREE_* */
    float traversal_cost;    /* of a node, 0..1e6, in units of a leaf; 0 = 1 */
    float intersection_cost; /* of a triangle in a leaf, 0..1e6, in the same units; 0 = a small share of the leaf's */
    char *message;           /* NULL, or a buffer for what went wrong, in words (UTF-8, terminated), or "" */
    size_t message_size;     /* its size in bytes */
    const mlrt_host *host;   /* NULL = malloc and silence */
    uint64_t memory_limit;   /* bytes held at one time at most, or MLRT_ERROR_OUT_OF_MEMORY; 0 = no limit */
    struct mlrt_pool *pool;  /* who builds; NULL = the calling thread alone. The tree is the same */
} mlrt_tree_options;

/*
 * Builds the best tree there is over the triangles of `meshes`: a hierarchy of boxes.
 *
 *   meshes      array of mesh_count structs, all of the struct_size of the first. The mesh data may be freed on return.
 *   mesh_count  0 is allowed, as is a mesh without triangles: the tree is empty and every ray misses.
 *   options     NULL = defaults.
 *   tree        receives the tree, or NULL after an error. Free it with mlrt_destroy_tree.
 *
 * Triangles that can never be hit (a vertex that is not finite, an area of exactly zero) are left out of the tree and
 * counted in mlrt_tree_info; the numbers of the others do not change. The same input gives the same tree, always.
 * An index out of range is MLRT_ERROR_INDEX_RANGE, and options->message names mesh (by position), triangle and index.
 * It names the option, too, that is out of its range (MLRT_ERROR_ARGUMENT). At most 2^30 - 1 triangles in all, or
 * MLRT_ERROR_TOO_LARGE.
 *
 * Memory, the triangles' 36 bytes included: some 83 to 92 bytes per triangle, at most 129 while it is built (FAST: 83
 * to 85 and 117, BEST: 85 to 101 and 150). Meshes of a few triangles take more, and masks 4 bytes per triangle.
 * mlrt_tree_info says how much it was.
 *
 * Method: surface area heuristic over bins, with spatial splits (M. Stich, H. Friedrich, A. Dietrich, "Spatial Splits
 * in Bounding Volume Hierarchies", 2009), and the best way to put sixteen boxes into a node (H. Ylitie, T. Karras, S.
 * Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017).
 */
MLRT_API int32_t mlrt_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                                 mlrt_tree **tree);

/* What kd-tree to build: mlrt_kdtree_options.preset */
enum {
    MLRT_KDTREE_PAPER = 0, /* as in the paper, as far as it says. It stays as it is, for comparisons */
    MLRT_KDTREE_TUNED = 1  /* larger leaves, smaller cells: renders faster here, takes longer to build */
};

/* Rules of the kd-tree's builder that can be switched off to measure their effect: mlrt_kdtree_options.rules_off */
enum {
    MLRT_RULE_EMPTY_SPACE = 1,  /* an empty side of more than 10 % of a cell is cut off first */
    MLRT_RULE_COPLANAR = 2,     /* a plane wholly covered by triangles in it is a split, they go to the smaller side */
    MLRT_RULE_MINIMUM_CELL = 4, /* cells under a minimum size are not split */
    MLRT_RULE_CLIPPED_SPLITS =
        8,                    /* candidates come from triangles clipped to the cell, not from their bounding boxes */
    MLRT_RULE_RETRACTION = 16 /* a subtree that costs more than a leaf becomes a leaf */
};

/* How to build a kd-tree: mlrt_build_kdtree. NULL or all zero but struct_size = defaults. */
typedef struct mlrt_kdtree_options {
    uint32_t struct_size;    /* sizeof(mlrt_kdtree_options) */
    int32_t preset;          /* MLRT_KDTREE_* */
    float traversal_cost;    /* of one node step, 0..1e6, relative to intersection_cost; 0 = the preset's */
    float intersection_cost; /* of one triangle, 0..1e6; 0 = the preset's */
    char *message;           /* as in mlrt_tree_options, as are the next three */
    size_t message_size;     /* its size in bytes */
    const mlrt_host *host;   /* NULL = malloc and silence */
    uint64_t memory_limit;   /* bytes held at one time at most; 0 = no limit */
    uint64_t max_references; /* leaf entries at most, bounding its memory; 0 = 8 per triangle + 1024 */
    uint32_t max_depth;      /* inner nodes above a leaf at most, 1..60; 0 = by the number of triangles */
    uint32_t rules_off;      /* MLRT_RULE_* or-ed together; 0 = every rule is on */
} mlrt_kdtree_options;

/*
 * Builds the paper's kd-tree, whose rays the paper's method (MLRT_METHOD_MULTILEVEL) traces if no other is named.
 * Arguments, errors and what is left out are as in mlrt_build_tree. The calling thread builds it alone.
 *
 * It is slower to build and to trace than what mlrt_build_tree makes. Memory, the triangles' 36 bytes included: 60 to
 * 90 bytes per triangle, and twice that while it is built.
 *
 * Method: surface area heuristic over clipped split candidates (V. Havran, J. Bittner, "On improving kd-trees for ray
 * shooting", 2002) with the three rules of the paper (section 3.1).
 */
MLRT_API int32_t mlrt_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                                   mlrt_tree **tree);

/* How much memory a builder takes, foreseen: mlrt_estimate_tree, mlrt_estimate_kdtree. */
typedef struct mlrt_memory_estimate {
    uint32_t struct_size;      /* sizeof(mlrt_memory_estimate) */
    uint32_t reserved;         /* set to 0 */
    uint64_t memory_size;      /* bytes held by the tree */
    uint64_t peak_memory_size; /* bytes held at most at one time while building */
} mlrt_memory_estimate;

/*
 * Foresees the memory of mlrt_build_tree with the same arguments, from numbers of triangles alone.
 *
 *   meshes      as for mlrt_build_tree; of each, struct_size and triangle_count are enough.
 *   mesh_count  how many there are.
 *   options     NULL = defaults.
 *   estimate    receives the answer (struct_size must be set).
 *
 * Scenes of more than a few thousand triangles take 80 to 110 % of what is said. What holds is a memory_limit.
 */
MLRT_API int32_t mlrt_estimate_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options,
                                    mlrt_memory_estimate *estimate);

/* Foresees the memory of mlrt_build_kdtree, likewise: a guess, which can be off by two. */
MLRT_API int32_t mlrt_estimate_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options,
                                      mlrt_memory_estimate *estimate);

/* Frees a tree. No call may be using it. NULL is allowed. */
MLRT_API void mlrt_destroy_tree(mlrt_tree *tree);

/*
 * The build report. Counts are of the finished tree. A tree that was loaded has no build_seconds, and its bytes are
 * those that loading took.
 */
typedef struct mlrt_tree_info {
    uint32_t struct_size;      /* sizeof(mlrt_tree_info) */
    uint32_t depth;            /* inner nodes above the deepest leaf */
    uint64_t triangle_count;   /* as given, left-out ones included */
    uint64_t non_finite_count; /* left out: a vertex is NaN or infinite */
    uint64_t zero_area_count;  /* left out: the area is exactly zero */
    uint64_t node_count;       /* inner nodes and leaves; of boxes: nodes, which are all inner ones */
    uint64_t leaf_count;       /* empty ones included */
    uint64_t empty_leaf_count; /* of boxes: 0 */
    uint64_t reference_count;  /* entries of all leaves together: a triangle can be in several */
    uint64_t retracted_count;  /* subtrees turned back into leaves; of boxes: 0 */
    uint64_t memory_size;      /* bytes held by the tree */
    uint64_t peak_memory_size; /* bytes held at most at one time while building */
    uint64_t tree_hash;        /* over nodes and leaf entries: equal trees have equal hashes */
    double sah_cost;           /* expected cost of a random ray through the scene box, in intersection_cost = 1; of
                                  boxes: in units of a node's */
    double build_seconds;      /* of the whole call, by the clock on the wall */
    float bounds_min[3];       /* the least coordinates of triangles in the tree; all 0 if there is none */
    float bounds_max[3];       /* the greatest, likewise */
    uint32_t structure;        /* MLRT_STRUCTURE_*: what the tree is, however it came here */
    uint32_t reserved;         /* set to 0 */
} mlrt_tree_info;

/* Fills *info (struct_size must be set). */
MLRT_API int32_t mlrt_get_tree_info(const mlrt_tree *tree, mlrt_tree_info *info);

/* ------------------------------------------------------------------------------------------------------------------
 * Saving and loading
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * Writes a tree of either structure, triangles and all, to memory, for mlrt_load_tree.
 *
 *   tree      the tree, which stays as it is.
 *   buffer    where to write; NULL = nowhere, to learn the size.
 *   capacity  bytes that `buffer` has room for. Less than it takes is MLRT_ERROR_ARGUMENT, and nothing is written.
 *   size      receives how many bytes it takes.
 */
MLRT_API int32_t mlrt_save_tree(const mlrt_tree *tree, void *buffer, size_t capacity, size_t *size);

/* How to load: mlrt_load_options.flags, or-ed together */
enum {
    MLRT_LOAD_IN_PLACE = 1 /* use the data where it lies: it must stay, unchanged, as long as the tree */
};

/* How to load: mlrt_load_tree. NULL or all zero but struct_size = defaults. */
typedef struct mlrt_load_options {
    uint32_t struct_size;   /* sizeof(mlrt_load_options) */
    uint32_t flags;         /* MLRT_LOAD_* */
    uint64_t geometry_hash; /* what mlrt_hash_geometry says the triangles are; others are MLRT_ERROR_DATA. 0 = any */
    uint64_t memory_limit;  /* as in mlrt_tree_options */
    char *message;          /* NULL, or a buffer that receives details of an error (UTF-8, terminated) */
    size_t message_size;    /* its size in bytes */
    const mlrt_host *host;  /* NULL = malloc and silence */
} mlrt_load_options;

/*
 * Makes a tree of what mlrt_save_tree wrote: the same tree, of the same structure, with the same answers.
 *
 *   data     what was saved, at any address. A file mapped into memory will do. With MLRT_LOAD_IN_PLACE it is used
 *            where it lies, if the address is a multiple of 64 (else it is copied), and the tree takes next to no
 *            memory of its own.
 *   size     bytes of data.
 *   options  NULL = defaults.
 *   tree     receives the tree, or NULL after an error.
 *
 * All of it is checked: any bytes give a tree that is safe to use, or MLRT_ERROR_DATA. A hash over everything tells
 * damage by chance. It does not tell forgery: a file made to look whole can give wrong answers, but do no other harm.
 * A file is of one version of the format and of one byte order, and others are MLRT_ERROR_DATA: keep the meshes, and
 * build again. The host's `progress` is not called.
 */
MLRT_API int32_t mlrt_load_tree(const void *data, size_t size, const mlrt_load_options *options, mlrt_tree **tree);

/*
 * A hash of meshes: of ids, masks, and the corners of all triangles in order. It is the same however they are indexed
 * and laid out in memory, and on every machine. Is a saved tree still that of my meshes?
 *
 *   meshes      as for mlrt_build_tree.
 *   mesh_count  how many there are.
 *   hash        receives the hash.
 */
MLRT_API int32_t mlrt_hash_geometry(const mlrt_mesh *meshes, size_t mesh_count, uint64_t *hash);

/* ------------------------------------------------------------------------------------------------------------------
 * Threads
 * ------------------------------------------------------------------------------------------------------------------ */

/* A pool: threads, its own or those of the host's job system, among which calls share out their work. */
typedef struct mlrt_pool mlrt_pool;

/*
 * Creates a pool for `thread_count` threads at work, 1..1024, the calling one included: thread_count - 1 threads are
 * started, and sleep between calls. 0 = one per processor that is online. Free it with mlrt_destroy_pool.
 */
MLRT_API int32_t mlrt_create_pool(uint32_t thread_count, mlrt_pool **pool);

/* What the host's job system runs: once, with the argument given along. */
typedef void (*mlrt_task_function)(void *argument);

/*
 * Hands a task to the host's job system: function(argument) is to be run, on any thread, now or later. Returns what
 * `finish` is to wait for. It may also run the task at once, before it returns, and then return NULL.
 */
typedef void *(*mlrt_enqueue_callback)(void *user, mlrt_task_function function, void *argument);

/* Waits until a task (not NULL) that `enqueue` returned has been run; it may run it, or others, meanwhile. */
typedef void (*mlrt_finish_callback)(void *user, void *task);

/* What pool to make: mlrt_create_pool_with_options. All zero but struct_size = as of mlrt_create_pool with 0. */
typedef struct mlrt_pool_options {
    uint32_t struct_size;  /* sizeof(mlrt_pool_options) */
    uint32_t thread_count; /* as in mlrt_create_pool; with `enqueue`, at most so many tasks at once, the caller's too */
    const mlrt_host *host; /* NULL = malloc */
    void *user;            /* handed to `enqueue` and `finish` */
    mlrt_enqueue_callback enqueue; /* NULL = the pool starts threads of its own */
    mlrt_finish_callback finish;   /* given if `enqueue` is, and only then */
} mlrt_pool_options;

/*
 * Creates a pool with options: above all one that starts no threads but shares work through the host's job system.
 *
 * A call with such a pool enqueues thread_count - 1 tasks at most at a time, works on the same items itself, and before
 * it returns finishes every task whose `enqueue` did not return NULL. Nothing is lost if a task starts late, or only
 * in `finish`: the others do its work. A call waits for nothing else, so it may be made from within a job, and several
 * may use such a pool at once, without waiting for each other. (E. Catto's Box2D 3 has hooks like these.)
 */
MLRT_API int32_t mlrt_create_pool_with_options(const mlrt_pool_options *options, mlrt_pool **pool);

/* Ends the threads and frees the pool. No call may be using it. NULL is allowed. */
MLRT_API void mlrt_destroy_pool(mlrt_pool *pool);

/* ------------------------------------------------------------------------------------------------------------------
 * Tracing: options, results, counters
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * How to trace: mlrt_trace_options.method. The answers are the same from each. All but RAY go through one structure,
 * and are MLRT_ERROR_UNSUPPORTED in a tree of the other.
 */
enum {
    MLRT_METHOD_DEFAULT = 0, /* boxes: tile. Kd-tree: multilevel, the paper's; in mlrt_trace_ray, ray */
    MLRT_METHOD_RAY = 1,     /* one ray at a time in double, plain C: the reference */
    MLRT_METHOD_PACKET2 = 2, /* kd-tree: 2x2 rays with masks (I. Wald et al., "Interactive Rendering with Coherent Ray
                                Tracing", 2001) */
    MLRT_METHOD_PACKET4 = 3, /* kd-tree: 4x4 rays by interval traversal from the root (the paper, section 4.3) */
    MLRT_METHOD_MULTILEVEL = 4, /* kd-tree: the same from entry points of beams (the paper, sections 3.3 to 4.2) */
    MLRT_METHOD_TILE = 5 /* boxes: 16 packets of 4x4 rays together; of a camera first 16 tiles of them, without rays.
                            Rays that have no origin or no way in common go alone */
};

/*
 * Instruction sets: mlrt_trace_options.isa. The answers are the same from each. One that is not in this machine or
 * build is MLRT_ERROR_UNSUPPORTED.
 *
 * All of them are there for method tile. The methods of the kd-tree take SSE2 where there is SSE2, whatever is asked
 * for, method ray is plain C, and so is method tile with counters.
 */
enum {
    MLRT_ISA_AUTO = 0,   /* the best that this machine has */
    MLRT_ISA_SCALAR = 1, /* plain C, always there */
    MLRT_ISA_SSE = 2,    /* SSE2, on every x86-64: 4 boxes, triangles, packets or rays at a time */
    MLRT_ISA_AVX2 = 3,   /* AVX2 and FMA: 8 at a time */
    MLRT_ISA_AVX512 = 4  /* AVX-512 F and DQ: 16 at a time */
};

/* What to ask: mlrt_trace_options.query */
enum {
    MLRT_QUERY_CLOSEST = 0, /* the closest hit: of mlrt_hits all but `occluded` */
    MLRT_QUERY_ANY = 1      /* is there a hit at all: only mlrt_hits.occluded is written */
};

/* Method multilevel: how a beam is tested against a cell (the paper, section 3.3), mlrt_trace_options.culling */
enum {
    MLRT_CULLING_INVERSE = 0, /* the planes of the cell against the beam */
    MLRT_CULLING_DIRECT = 1   /* the planes of the beam against the cell */
};

/*
 * What the multi-level method does beyond the paper. Each can be switched off to measure its effect, and the paper's
 * algorithm is what remains without all of them: mlrt_trace_options.shortcuts_off
 */
enum {
    MLRT_SHORTCUT_WHOLE_TILES = 1, /* a tile that one triangle provably covers, in front of all else, is done at once */
    MLRT_SHORTCUT_ENTRY_LISTS = 2, /* packets start at a list of leaves, not at the one node above them all */
    MLRT_SHORTCUT_SHARED_SETUPS = 4 /* what depends on a triangle and the origin only is kept for the next packets */
};

/* Results a tile callback receives: mlrt_trace_options.outputs */
enum {
    MLRT_OUTPUT_T = 1,         /* t */
    MLRT_OUTPUT_UV = 2,        /* u and v */
    MLRT_OUTPUT_IDS = 4,       /* mesh and triangle */
    MLRT_OUTPUT_FACING = 8,    /* facing */
    MLRT_OUTPUT_TRIANGLE = 16, /* the triangle without its mesh: half as much to write, where there is one mesh only */
    MLRT_OUTPUT_OCCLUDED = 32  /* with `lights`: occluded */
};

/*
 * What traversal did, of the kd-tree in units of 4x4 packets: the columns of the paper's table 2. Numbers are added to
 * what is there, so that one struct can collect several calls, one at a time; they can differ between methods and
 * machines. Counting takes time: that of method tile is done in plain C.
 *
 * Method tile looks at sixteen packets, or at sixteen tiles of them, at once. So cells and tests are shared by up to
 * 256 or 4096 rays, and are not to be compared with those of the kd-tree. It has no beams and entry points: these
 * counters stay as they are. Shadow rays of a picture's lights are counted as rays that went alone, though without
 * counters they do not.
 */
typedef struct mlrt_counters {
    uint32_t struct_size;  /* sizeof(mlrt_counters) */
    uint32_t reserved;     /* must be 0 */
    uint64_t ray_count;    /* rays traced */
    uint64_t packet_count; /* groups of rays traced together: packets, or less where directions differ; rays
                            * that went alone. Of method tile only the latter, each time
                            * that one did */
    uint64_t beam_count;   /* beams for which an entry point was searched */
    uint64_t cell_count;   /* nodes, inner or leaf, descended into or popped; those of the entry-point search included.
                            * Method tile: nodes opened and leaves looked at by a tile or by a ray that went alone */
    uint64_t entry_point_cell_count;  /* of these, in the entry-point search */
    uint64_t triangle_test_count;     /* (packet, triangle) tests with at least one ray taking part. Method tile: also
                                       * tests of all closed cells of a tile against a triangle, and (ray, triangle) of
                                       * rays that went alone */
    uint64_t judged_lane_count;       /* (ray, triangle) pairs that the float filter left to double arithmetic */
    uint64_t entry_point_count;       /* entry points from which packets were traced */
    uint64_t entry_point_depth_sum;   /* their depths below the root, added up */
    uint64_t missed_beam_count;       /* beams that provably hit nothing: no ray of theirs was traced */
    uint64_t covered_beam_count;      /* beams whose rays provably all hit one triangle first: none was traced */
    uint64_t undecided_cull_count;    /* inner nodes where the culling test could exclude no child */
    uint64_t undecided_checked_count; /* of these, still undecided after the extra check */
    uint64_t lane_test_count;         /* (ray, triangle) pairs that the float filter looked at */
    uint64_t undecided_test_count;    /* of triangle_test_count, those with a judged ray */
    uint64_t tie_lane_count;          /* (ray, triangle) pairs settled because the nearest hit lies in the same plane */
    uint64_t exact_edge_count;        /* decisions left to exact arithmetic: on which side of an edge a ray passes */
    uint64_t exact_range_count;       /* decisions left to exact arithmetic: is a hit within t_min and t_max? */
    uint64_t exact_order_count;       /* decisions left to exact arithmetic: which of two hits is nearer? */
} mlrt_counters;

/*
 * How to trace. NULL or all zero but struct_size = defaults.
 *
 * The picture is cut into squares of initial_tile_size, which are what threads claim and what a tile callback gets. For
 * method multilevel this and the next two are the tile sizes of the paper, section 4.2: a tile larger than
 * minimum_tile_size whose entry point is not a leaf is cut into split_factor pieces, and so on. Method tile has levels
 * of its own, of 64, 16 and 4 pixels, less where initial_tile_size is less; minimum_tile_size, split_factor, culling,
 * culling_check and shortcuts_off are checked, and do nothing there.
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
    uint32_t outputs;           /* MLRT_OUTPUT_* or-ed together: what a tile callback wants */
    uint32_t shortcuts_off;     /* MLRT_SHORTCUT_* or-ed together: parts of multilevel to do without */
    uint32_t mask;              /* rays see the meshes whose mask has a bit in common with this one; 0 = all bits */
    mlrt_pool *pool;            /* NULL = the calling thread alone */
    mlrt_counters *counters;    /* NULL = not counted, at no cost, but for the kd-tree, whose kernels always count */
    const mlrt_host *host;      /* NULL = malloc and silence. Not used by mlrt_trace_ray */
    const struct mlrt_light *lights; /* mlrt_render_tiles with MLRT_QUERY_CLOSEST: whose shadows are wanted in
                                        `occluded`; NULL = none. Must be NULL elsewhere */
    uint32_t light_count;            /* of lights, 0..8 */
    uint32_t reserved;               /* must be 0 */
} mlrt_trace_options;

/* An array of results. `data` = NULL: not wanted, and not computed. */
typedef struct mlrt_array {
    void *data;        /* the first element; NULL = not wanted */
    size_t stride;     /* bytes from one element to the next; 0 = packed */
    size_t row_stride; /* bytes from one row of pixels to the next, in mlrt_render_tiles and mlrt_camera_rays; 0 =
                          packed */
} mlrt_array;

/*
 * Where results go. MLRT_QUERY_CLOSEST writes the first six, and with lights the last; MLRT_QUERY_ANY only the last. An
 * array that the query does not write must be NULL.
 *
 * `mesh`, `triangle` and `facing` tell hits from misses. `t` does not always: a hit farther away than the greatest
 * float rounds to inf, as a miss has it, and one very close to 0, though 0 < t.
 *
 * With lights, bit k of `occluded` is 1 if light k of the options does not reach the hit: something is in between, or
 * the light is on the other side of the surface, or so far away that no ray of floats leads to it ("Shadows of a
 * picture" below).
 */
typedef struct mlrt_hits {
    uint32_t struct_size; /* sizeof(mlrt_hits) */
    uint32_t reserved;    /* must be 0 */
    mlrt_array t;         /* float: the distance in units of |d|, rounded; a miss has inf, and so can a hit (above) */
    mlrt_array u;         /* float: the weight of the triangle's second vertex */
    mlrt_array v;         /* float: the weight of its third */
    mlrt_array mesh;      /* uint32_t: the id of the mesh; MLRT_NONE = miss */
    mlrt_array triangle;  /* uint32_t: the number of the triangle in its mesh; MLRT_NONE = miss */
    mlrt_array facing;    /* int32_t: sign of d . n; 0 = miss */
    mlrt_array occluded;  /* uint8_t: 1 = something is hit, 0 = nothing. With lights (above): a bit each; of a miss 0 */
} mlrt_hits;

/* ------------------------------------------------------------------------------------------------------------------
 * Tracing rays
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * The stride of an input array with one element, which serves all rays: a common origin, direction, t_max and so on.
 * The answers are those of the array written out in full. No other array can have this stride: neither a mesh's nor one
 * for results (MLRT_ERROR_ARGUMENT). Languages that cannot read it here: all bits of a size_t are set.
 */
#define MLRT_STRIDE_ALL ((size_t)-1)

/* An input array. Where it may be left out, `data` = NULL does that. */
typedef struct mlrt_const_array {
    const void *data; /* the first element */
    size_t stride;    /* bytes from one element to the next; 0 = packed; MLRT_STRIDE_ALL = one element serves all */
} mlrt_const_array;

/*
 * Rays. Neighbours should be alike: rays are grouped in the order given, 16 at a time and then more. Rows of pixels let
 * groups be squares instead: say how long they are in `row_length`; without it, mlrt_trace_packet looks for them. Any
 * rays give right answers; alike ones are faster.
 */
typedef struct mlrt_rays {
    uint32_t struct_size;        /* sizeof(mlrt_rays) */
    uint32_t row_length;         /* rays per row of a picture; 0 = not known. A hint for speed only */
    size_t count;                /* at most 2^31 - 1 */
    mlrt_const_array origins;    /* float[3] */
    mlrt_const_array directions; /* float[3], of any length */
    mlrt_const_array t_min;      /* float; NULL = 0 for all */
    mlrt_const_array t_max;      /* float; NULL = no limit for all. 0 here means 0 */
    mlrt_const_array skip; /* uint32_t[2]: the mesh and triangle, as reported, that this ray passes; NULL = none */
    mlrt_const_array mask; /* uint32_t: as in mlrt_trace_options, for each ray, and in place of that one (0 = all bits).
                              NULL = that of the options for all. Where the tree's meshes have masks, rays with masks of
                              their own go alone, and slower */
    uint32_t rays_per_origin; /* k neighbouring rays leave from one point: ray i has element i / k of origins, t_min and
                                 skip, which have count / k elements; of the other arrays it has element i. 0 = 1. Must
                                 divide count. With more than 1, rays are grouped in the order given, and row_length
                                 does nothing */
    uint32_t reserved;        /* must be 0 */
} mlrt_rays;

/*
 * Traces any number of rays.
 *
 *   tree     what to trace them in.
 *   rays     the rays: arrays of the caller's.
 *   options  what to ask, and how; NULL = the closest hits, by the calling thread.
 *   hits     where to write: the results of ray i go to element i of its arrays.
 *
 * With a pool, the rays are shared out among its threads. Fewer or other threads, methods or groupings never change a
 * bit of the results. After an error the arrays hold the results of some rays only, or of none.
 */
MLRT_API int32_t mlrt_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                                   const mlrt_hits *hits);

/* What a ray has: mlrt_ray.flags, or-ed together */
enum {
    MLRT_RAY_SKIP = 1 /* skip_mesh and skip_triangle hold */
};

/* A ray, for mlrt_trace_ray. */
typedef struct mlrt_ray {
    uint32_t struct_size;   /* sizeof(mlrt_ray) */
    uint32_t flags;         /* MLRT_RAY_* */
    float origin[3];        /* o */
    float direction[3];     /* d, of any length */
    float t_min;            /* 0 = hits in front of the origin */
    float t_max;            /* 0 = no limit */
    uint32_t skip_mesh;     /* with MLRT_RAY_SKIP: the mesh, as reported, of the triangle that this ray passes */
    uint32_t skip_triangle; /* with MLRT_RAY_SKIP: the triangle, as reported */
} mlrt_ray;

/* What mlrt_trace_ray found. */
typedef struct mlrt_hit {
    uint32_t struct_size; /* sizeof(mlrt_hit) */
    float t;              /* the distance in units of |d|, rounded; a miss has inf, and so can a hit (mlrt_hits) */
    float u;              /* the weight of the triangle's second vertex */
    float v;              /* the weight of its third */
    uint32_t mesh;        /* the id of the mesh; MLRT_NONE = miss */
    uint32_t triangle;    /* the number of the triangle in its mesh; MLRT_NONE = miss */
    int32_t facing;       /* sign of d . n; 0 = miss */
    uint32_t occluded;    /* 1 = something is hit. With MLRT_QUERY_ANY the only field written */
} mlrt_hit;

/*
 * Traces one ray. For more than a few use mlrt_trace_packet: for rays that are alike it is many times faster per ray.
 *
 *   tree     what to trace it in.
 *   ray      the ray.
 *   options  what to ask, and how; NULL = the closest hit. A pool does nothing.
 *   hit      receives the result (struct_size must be set).
 */
MLRT_API int32_t mlrt_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options,
                                mlrt_hit *hit);

/* ------------------------------------------------------------------------------------------------------------------
 * All hits of a ray
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * Where lists of hits go: `capacity` elements per ray, so hit j of ray i is element i * capacity + j. An array with
 * data = NULL is not wanted. Elements behind a ray's last hit are written as misses.
 */
typedef struct mlrt_hit_lists {
    uint32_t struct_size; /* sizeof(mlrt_hit_lists) */
    uint32_t capacity;    /* hits written per ray at most; 0 = only the totals, and no arrays of hits */
    mlrt_array t;         /* float; as in mlrt_hits, as are the next five */
    mlrt_array u;         /* float */
    mlrt_array v;         /* float */
    mlrt_array mesh;      /* uint32_t */
    mlrt_array triangle;  /* uint32_t */
    mlrt_array facing;    /* int32_t */
    mlrt_array crossing;  /* uint8_t: 1 = this hit crosses the surface, 0 = it only touches it, or there is no hit */
    mlrt_array total;     /* uint32_t, one per ray: how many hits it has, also beyond `capacity` */
    mlrt_array crossing_total; /* uint32_t, one per ray: how many of these cross */
} mlrt_hit_lists;

/*
 * Finds every triangle that each ray hits, in the order of mlrt_trace_packet's rule: by N / D, equal ones as in the
 * input.
 *
 * A hit through an edge or a corner is a hit of each triangle there. For questions of inside and outside such a ray
 * must count once, so each hit says whether it is a `crossing`: whether it would still be a hit with the origin moved
 * by (e, e^2, e^3) for any positive e that is small enough, t_max aside (symbolic perturbation: H. Edelsbrunner, E. P.
 * Muecke, "Simulation of Simplicity", 1990). Along any ray from a point that does not lie on a closed mesh, with t_max
 * = inf, crossing_total is odd if the point is inside, and even if it is outside.
 *
 *   tree     what to trace them in.
 *   rays     the rays: arrays of the caller's.
 *   options  NULL = defaults. Of its fields only mask, pool, counters and host matter, though all are checked.
 *   lists    where to write.
 *
 * MLRT_ERROR_OUT_OF_MEMORY is possible: hits are gathered in memory that grows with the hits of one ray. The arrays
 * then hold the results of some rays only.
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
 * A camera: pixel (i, j), counted from the upper left or wherever the caller likes, has with x = i + sample_x,
 * y = j + sample_y the vector p = d00 + x dx + y dy, and the ray
 *
 *     pinhole:   origin eye, direction p               parallel:   origin p, direction `direction`
 *
 * in exactly this arithmetic, each step rounded to float, for each component k:
 *     x = fl(i + sample_x), y = fl(j + sample_y), p_k = fl(fl(d00_k + fl(x dx_k)) + fl(y dy_k)).
 * So mlrt_camera_rays, and anyone else, can write out the very rays that mlrt_render_tiles traces.
 */
typedef struct mlrt_camera {
    uint32_t struct_size; /* sizeof(mlrt_camera) */
    int32_t projection;   /* MLRT_PROJECTION_* */
    uint32_t width;       /* columns of the whole picture, 1..2^23. The crop has 2^31 - 1 pixels at most */
    uint32_t height;      /* rows of the whole picture, 1..2^23 */
    uint32_t crop_x;      /* the first column to render: column 0 of the frame */
    uint32_t crop_y;      /* the first row to render: row 0 of the frame */
    uint32_t crop_width;  /* columns to render; 0 = up to the right edge */
    uint32_t crop_height; /* rows to render; 0 = up to the last */
    float eye[3];         /* pinhole: where the rays start */
    float direction[3];   /* parallel: where the rays go */
    float d00[3];         /* p of x = 0, y = 0 */
    float dx[3];          /* from p of one pixel to that of the next in a row */
    float dy[3];          /* from p of one row to that of the next */
    float sample_x;       /* where in the pixel, along the row: 0.5 = the middle */
    float sample_y;       /* where in the pixel, across the rows: 0.5 = the middle */
    float t_min;          /* 0 = hits in front of the origin */
    float t_max;          /* 0 = no limit */
} mlrt_camera;

/*
 * A finished tile, as arrays: the result of pixel (x + i, y + j), counted like the camera's pixels, is element
 * j * width + i. Arrays not asked for in the options' `outputs` (with MLRT_QUERY_ANY: all but `occluded`) are NULL.
 * They live in the worker's cache and are gone when the callback returns. No two calls at a time have the same
 * `worker`. (Of a pool with hooks that is the number of a task, whatever thread runs it.)
 */
typedef struct mlrt_tile {
    uint32_t struct_size;     /* sizeof(mlrt_tile), the library's */
    uint32_t worker;          /* 0..threads - 1: which worker calls; 0 is the caller's own thread */
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
 * Called once per tile of initial_tile_size squared (less at the edges), from the threads of the pool, several at a
 * time. It may call any tracing function, but not with the pool of the render, unless that has tasks
 * (mlrt_pool_options). Return 0 to go on; anything else ends the render soon, and mlrt_render_tiles returns
 * MLRT_ERROR_CANCELLED.
 */
typedef int32_t (*mlrt_tile_callback)(void *user, const mlrt_tile *tile);

/*
 * Renders a picture: traces the ray of every pixel of the camera's crop.
 *
 *   tree      what to trace them in.
 *   camera    the camera.
 *   options   what to ask, and how; NULL = the closest hits, by the calling thread.
 *   frame     where to write: element (column, row) of the crop, with the strides given. NULL = nowhere.
 *   callback  called with each tile's results; NULL = none.
 *   user      handed to the callback.
 *
 * At least one of frame and callback must be given. Invalid pixels (a ray whose direction rounds to 0, say) are misses.
 */
MLRT_API int32_t mlrt_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options,
                                   const mlrt_hits *frame, mlrt_tile_callback callback, void *user);

/*
 * Writes out the rays of a camera's crop, row by row: crop_width * crop_height origins and directions. Tracing them
 * gives what mlrt_render_tiles gives, bit for bit.
 *
 *   camera      the camera. Its t_min and t_max are not written.
 *   origins     receives float[3] each; NULL, or data = NULL: not wanted.
 *   directions  likewise.
 */
MLRT_API int32_t mlrt_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions);

/* ------------------------------------------------------------------------------------------------------------------
 * Light
 * ------------------------------------------------------------------------------------------------------------------ */

/* What `position` says: mlrt_light.kind */
enum {
    MLRT_LIGHT_POINT = 0,      /* position = where it is */
    MLRT_LIGHT_DIRECTIONAL = 1 /* position = the direction towards it, of any length */
};

/* Where light comes from. */
typedef struct mlrt_light {
    uint32_t struct_size; /* sizeof(mlrt_light) */
    int32_t kind;         /* MLRT_LIGHT_* */
    float position[3];    /* finite */
} mlrt_light;

/* Points that may be in shadow. */
typedef struct mlrt_points {
    uint32_t struct_size;       /* sizeof(mlrt_points) */
    uint32_t row_length;        /* points per row of a picture; 0 = a plain list. A hint for speed only */
    size_t count;               /* at most 2^31 - 1 */
    mlrt_const_array positions; /* float[3] */
    mlrt_const_array
        skip; /* uint32_t[2]: mesh and triangle that the point lies on, which do not shade it; NULL = none */
} mlrt_points;

/*
 * Finds out which points are in the shadow of a light.
 *
 *   tree      what may lie between.
 *   points    the points: arrays of the caller's.
 *   light     the light.
 *   options   NULL = defaults. Its `query` is ignored.
 *   occluded  uint8_t: element i receives 1 if something lies between point i and the light, 0 if nothing does.
 *
 * The ray is, for a point light at L, o = L, d = fl(P - L) per component, 0 < t <= 1; for a directional light o = P,
 * d = position, 0 < t. A point at the light itself or with a coordinate that is not finite is not occluded.
 * Give points moved off their surface by mlrt_offset_point, and the surface in `skip`.
 */
MLRT_API int32_t mlrt_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light,
                                      const mlrt_trace_options *options, const mlrt_array *occluded);

/*
 * Shadows of a picture. With `lights` in the options mlrt_render_tiles finds out which of them reach what the pixels
 * see: much faster than by mlrt_occluded_points, as no point has to leave the library. For a pixel whose ray o + t d
 * hits a triangle abc, bit k of `occluded` says that light k does not reach it:
 *
 *   - A light that is not strictly on that side of abc's plane which the ray came from (for a directional light:
 *     whose direction does not strictly point to that side) does not reach it. Nor does a light for which no float
 *     holds the ray below: if d' for a point light, or o' for a directional one, would have a component beyond the
 *     greatest float. It counts as one on the other side.
 *   - Otherwise a ray decides: for a point light at L, from o' = L along d' for 0 < t <= 1; for a directional light,
 * from o' along d' = position for 0 < t. Its end L + d', or its origin o', is a point just off the hit, and surely on
 * that side: it is moved off by about 2^-22 of the greatest coordinate relative to the eye and to the light, for
 * slivers and rays that nearly lie in their plane by as many floats as it takes. So no triangle shades itself, nor one
 * that lies in its plane, nor one behind it. The ray sees what the picture's rays see (`mask`).
 *
 * mlrt_shadow_ray tells the ray; it is the same on every machine, and the answer is that of mlrt_trace_ray.
 *
 *   tree    what is seen.
 *   ray     the ray that hit something: of mlrt_camera_rays, say.
 *   hit     what it hit: mesh and triangle.
 *   light   the light.
 *   shadow  receives the ray that decides, with the triangle to skip (struct_size must be set).
 *   faces   receives 1; or 0 if the light is on the other side, or counts as such because the ray would leave the range
 *           of float. No ray is needed then, and *shadow has a direction of 0.
 *
 * MLRT_ERROR_ARGUMENT if there is no such triangle, or the ray does not hit it.
 */
MLRT_API int32_t mlrt_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_hit *hit,
                                 const mlrt_light *light, mlrt_ray *shadow, int32_t *faces);

/*
 * Finds a point just off a triangle a b c: next to (1 - u - v) a + u b + v c, strictly on one side.
 *
 *   tree      the tree that has the triangle.
 *   mesh      the id of its mesh, and
 *   triangle  its number there, as reported with hits.
 *   u, v      where on the triangle, as reported with hits; any finite numbers.
 *   side      +1: where the normal (b - a) x (c - a) points; -1: the other. For the side a ray came from, give -facing
 *             of its hit.
 *   point     receives the point.
 *
 * Promise: no ray that starts at the point and goes to the same side, or along the plane, hits that triangle.
 *
 * MLRT_ERROR_ARGUMENT if there is no such triangle, if it is one of those left out, if u or v is not finite, or if the
 * point would leave the range of float.
 */
MLRT_API int32_t mlrt_offset_point(const mlrt_tree *tree, uint32_t mesh, uint32_t triangle, float u, float v,
                                   int32_t side, float point[3]);

#ifdef __cplusplus
}
#endif

#endif /* MLRT_H */
