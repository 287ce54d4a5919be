/* SPDX-License-Identifier: MIT */
/*
 * mlrt.hpp - mlrt.h for C++11 and later: handles that free themselves, errors as exceptions. Header only; link libmlrt.
 *
 * Trees and pools can be moved, not copied. One that was moved from is empty: a call of an empty tree throws, and an
 * empty pool stands for the calling thread alone. For all that is not wrapped here, use the C interface: get() returns
 * the handle, mlrt::make<mlrt_...>() a struct whose size is set.
 */
#ifndef MLRT_HPP
#define MLRT_HPP

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mlrt.h"

namespace mlrt {

/* what() is the library's text for the status, followed by the library's message if there is one. */
struct Error : std::runtime_error {
    int32_t status;
    Error(int32_t code, const std::string &details)
        : std::runtime_error(mlrt_status_string(code) + (details.empty() ? details : ": " + details)), status(code) {}
};

/* Throws an Error unless the status is MLRT_OK. */
inline void check(int32_t status, const char *details = "") {
    if (status != MLRT_OK) throw Error(status, details);
}

/* A struct of the C interface: its size is set, all other fields are 0, so defaults. */
template <class Struct> Struct make() {
    Struct s = Struct();
    s.struct_size = sizeof s;
    return s;
}

struct Destroy {
    void operator()(mlrt_tree *tree) const { mlrt_destroy_tree(tree); }
    void operator()(mlrt_pool *pool) const { mlrt_destroy_pool(pool); }
};

/* A pool of `threads` threads, of which the calling one is one; 0 = one per processor. */
class Pool {
    std::unique_ptr<mlrt_pool, Destroy> handle;

  public:
    explicit Pool(uint32_t threads = 0) {
        mlrt_pool *pool;
        check(mlrt_create_pool(threads, &pool));
        handle.reset(pool);
    }
    mlrt_pool *get() const { return handle.get(); }
};

/* Closest hits, one element per ray; a miss has t = inf and mesh = triangle = MLRT_NONE. */
struct Hits {
    std::vector<float> t, u, v;
    std::vector<uint32_t> mesh, triangle;
    std::vector<int32_t> facing;
    explicit Hits(size_t n) : t(n), u(n), v(n), mesh(n), triangle(n), facing(n) {}
};

/* A mesh: three floats a vertex, three vertex numbers a triangle. The vectors must live until the tree is built. */
inline mlrt_mesh mesh(const std::vector<float> &vertices, const std::vector<uint32_t> &indices, uint32_t id = 0) {
    mlrt_mesh m = make<mlrt_mesh>();
    m.id = id, m.vertices = vertices.data(), m.vertex_count = vertices.size() / 3;
    m.indices = indices.data(), m.triangle_count = indices.size() / 3;
    return m;
}

/* A tree, and rays that are traced in it. All vectors of rays have three floats for each origin and direction. */
class Tree {
    std::unique_ptr<mlrt_tree, Destroy> handle;

    template <class Builder, class Options>
    void build(Builder builder, const std::vector<mlrt_mesh> &meshes, Options &options) {
        mlrt_tree *tree;
        char details[256] = "";
        if (!options.message) options.message = details, options.message_size = sizeof details;
        check(builder(meshes.data(), meshes.size(), &options, &tree), options.message);
        handle.reset(tree);
    }

  public:
    /* Calls mlrt_build_tree: a hierarchy of boxes. */
    explicit Tree(const std::vector<mlrt_mesh> &meshes, mlrt_tree_options options = make<mlrt_tree_options>()) {
        build(mlrt_build_tree, meshes, options);
    }
    /* Calls mlrt_build_kdtree: the paper's kd-tree. */
    Tree(const std::vector<mlrt_mesh> &meshes, mlrt_kdtree_options options) {
        build(mlrt_build_kdtree, meshes, options);
    }
    mlrt_tree *get() const { return handle.get(); }

    /* Returns the closest hit of each ray. */
    Hits trace(const std::vector<float> &origins, const std::vector<float> &directions,
               const Pool *pool = nullptr) const {
        Hits hits(origins.size() / 3);
        mlrt_hits out = make<mlrt_hits>();
        out.t.data = hits.t.data(), out.u.data = hits.u.data(), out.v.data = hits.v.data();
        out.mesh.data = hits.mesh.data(), out.triangle.data = hits.triangle.data();
        out.facing.data = hits.facing.data();
        trace(origins, directions, MLRT_QUERY_CLOSEST, pool, out);
        return hits;
    }

    /* Returns 1 for each ray that hits anything, else 0. */
    std::vector<uint8_t> occluded(const std::vector<float> &origins, const std::vector<float> &directions,
                                  const Pool *pool = nullptr) const {
        std::vector<uint8_t> answers(origins.size() / 3);
        mlrt_hits out = make<mlrt_hits>();
        out.occluded.data = answers.data();
        trace(origins, directions, MLRT_QUERY_ANY, pool, out);
        return answers;
    }

    /* Calls mlrt_trace_packet: writes the answers of a query to arrays of the caller. */
    void trace(const std::vector<float> &origins, const std::vector<float> &directions, int32_t query, const Pool *pool,
               const mlrt_hits &out) const {
        if (origins.size() != directions.size() || origins.size() % 3)
            throw Error(MLRT_ERROR_ARGUMENT, "three floats for each origin and direction");
        mlrt_rays rays = make<mlrt_rays>();
        rays.count = origins.size() / 3, rays.origins.data = origins.data(), rays.directions.data = directions.data();
        mlrt_trace_options options = make<mlrt_trace_options>();
        options.query = query, options.pool = pool ? pool->get() : nullptr;
        check(mlrt_trace_packet(get(), &rays, &options, &out));
    }
};

} // namespace mlrt

#endif
