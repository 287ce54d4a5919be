/* SPDX-License-Identifier: MIT */
/*
 * The scene of scene.h through mlrt.hpp: prints the hash, and tries everything that the header has. Without exceptions
 * (-fno-exceptions) it tries results in place of errors, and prints the same hash.
 */
#include <algorithm>
#include <atomic>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <limits>
#include <new>
#include <thread>
#include <type_traits>
#include <utility>

#include "mlrt.hpp"

#include "../c/scene.h"

static_assert(!std::is_copy_constructible<mlrt::Tree>::value && !std::is_copy_assignable<mlrt::Pool>::value, "");
static_assert(std::is_nothrow_move_constructible<mlrt::Tree>::value, "");

typedef std::array<float, 3> Point;
typedef std::array<int32_t, 3> Integers;

// Elements that say what their numbers are must say the right thing.
static_assert(std::is_constructible<mlrt::Input<float, 3>, const std::vector<Point> &>::value, "points");
static_assert(std::is_constructible<mlrt::Input<uint32_t, 3>, const std::vector<Integers> &>::value, "triangles");
static_assert(!std::is_constructible<mlrt::Input<uint32_t, 3>, const std::vector<Point> &>::value, "not triangles");
static_assert(!std::is_constructible<mlrt::Input<float, 3>, const std::vector<Integers> &>::value, "not points");
static_assert(!std::is_constructible<mlrt::Input<uint32_t, 2>, const std::vector<void *> &>::value, "not ids");
static_assert(!std::is_constructible<mlrt::Output<float>, std::vector<std::array<int32_t, 1>> &>::value, "not floats");
static_assert(mlrt::detail::IsElement<float, float, 1>::value &&
                  mlrt::detail::IsElement<const float[3], float, 3>::value &&
                  mlrt::detail::IsElement<mlrt::Hit, uint32_t, 6>::value,
              "a number, an array, and a struct that does not say what it has");
static_assert(!mlrt::detail::IsElement<int32_t, float, 1>::value && !mlrt::detail::IsElement<int[3], float, 3>::value &&
                  !mlrt::detail::IsElement<Point, float, 2>::value,
              "other numbers, and more of them");

static void require(bool fact, const char *what) {
    if (fact) return;
    std::fprintf(stderr, "failed: %s\n", what);
    std::exit(1);
}

static uint64_t hash_of(const mlrt::Hits &hits) {
    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    for (size_t i = 0; i < hits.size(); i++) {
        hash = hash_hit(hash, hits.t[i], hits.u[i], hits.v[i], hits.mesh[i], hits.triangle[i], hits.facing[i]);
    }
    return hash;
}

struct Arrays {
    std::vector<float> vertices[SCENE_MESHES], origins, directions;
    std::vector<uint32_t> indices[SCENE_MESHES];

    Arrays() {
        static struct scene scene;
        make_scene(&scene);
        for (int m = 0; m < SCENE_MESHES; m++) {
            vertices[m].assign(std::begin(scene.vertices[m]), std::end(scene.vertices[m]));
            indices[m].assign(std::begin(scene.indices[m]), std::end(scene.indices[m]));
        }
        origins.assign(std::begin(scene.origins), std::end(scene.origins));
        directions.assign(std::begin(scene.directions), std::end(scene.directions));
    }
    std::vector<mlrt_mesh> meshes() const {
        return {mlrt::mesh(vertices[0], indices[0], scene_ids[0]), mlrt::mesh(vertices[1], indices[1], scene_ids[1])};
    }
    mlrt::Rays rays() const { return mlrt::Rays(origins, directions); }
};

// Results, as programs without exceptions use them.
static void without_exceptions(const Arrays &arrays) {
    mlrt::Result<mlrt::Tree> tree = mlrt::Tree::try_build(arrays.meshes());
    require(bool(tree), "a tree");
    mlrt::Hits hits(SCENE_RAYS);
    require(bool(tree.value.try_trace(arrays.rays(), hits.arrays())), "hits");
    std::printf("%016" PRIx64 "\n", hash_of(hits));

    Arrays wrong = arrays;
    wrong.indices[1][5] = SCENE_VERTICES;
    const mlrt::Result<mlrt::Tree> failed = mlrt::Tree::try_build(wrong.meshes());
    require(!failed && failed.code() == MLRT_ERROR_INDEX_RANGE && !failed.message().empty(), "index out of range");
    require(failed.text().find(mlrt_status_string(MLRT_ERROR_INDEX_RANGE)) == 0, "a text with the meaning");
    require(mlrt::Pool::try_create(5000).code() == MLRT_ERROR_ARGUMENT, "too many threads");
    require(mlrt::Pool::try_create().value.thread_count() >= 1, "a thread per processor");
    require(mlrt::Pool::try_create(2).value.thread_count() == 2, "threads of a pool");
    require(mlrt::Pool().thread_count() == 1, "an empty pool");
    require(mlrt::Pool::try_create(4, mlrt::Pool::Executor()).code() == MLRT_ERROR_ARGUMENT, "an empty executor");
    require(mlrt::Tree().try_trace(arrays.rays(), hits.arrays()).code() == MLRT_ERROR_ARGUMENT, "an empty tree");
    hits = mlrt::Hits(SCENE_RAYS - 1);
    require(tree.value.try_trace(arrays.rays(), hits.arrays()).code() == MLRT_ERROR_ARGUMENT, "short results");
    mlrt::HitArrays packed;
    packed.t = mlrt::Output<float>(hits.t.data(), 16, 0);
    require(tree.value.try_trace(arrays.rays(), packed).code() == MLRT_ERROR_ARGUMENT, "short packed results");

    // With strides beyond memory, sizes are not those modulo 2^64.
    const size_t quarter = std::numeric_limits<size_t>::max() / 4 + 1;
    const mlrt::Output<float> far(hits.t.data(), 16, quarter), packed_rows(hits.t.data(), 16);
    require(far.fits(1, 1) && !far.fits(5, 1) && !packed_rows.rows(quarter).fits(1, 5), "sizes beyond memory");
    require(packed_rows.fits(2, 2) && !packed_rows.fits(2, 3) && !packed_rows.fits(quarter, quarter), "packed rows");
    require(!packed_rows.rows(4).fits(2, 3), "rows that overlap");
    require(mlrt::Output<float>(hits.t.data(), 24, 12).rows(4).fits(2, 3), "rows within each other");
}

#if MLRT_EXCEPTIONS

// Two triangles, one behind the other, seen along z.
static const std::vector<Point> walls = {{{-9, -9, 5}}, {{9, -9, 5}}, {{0, 9, 5}},
                                         {{-9, -9, 8}}, {{9, -9, 8}}, {{0, 9, 8}}};
static const Point zero = {{0, 0, 0}}, along_z = {{0, 0, 1}};
static const float infinity = std::numeric_limits<float>::infinity();

// Allocations by `new` of this thread that succeed before the others fail; negative: all succeed.
static thread_local int allocations = -1;

void *operator new(size_t size) {
    if (allocations == 0) throw std::bad_alloc();
    if (allocations > 0) allocations--;
    void *block = std::malloc(size ? size : 1);
    if (!block) throw std::bad_alloc();
    return block;
}
void operator delete(void *block) noexcept { std::free(block); }
void operator delete(void *block, size_t) noexcept { std::free(block); }

// The status of what `call` throws, whose text must contain `words`.
template <class Call> static int32_t status_of(Call call, const char *words) {
    try {
        call();
    } catch (const mlrt::Error &error) {
        require(std::strstr(error.what(), words) != nullptr, error.what());
        return error.status;
    }
    return MLRT_OK;
}

static void errors(const Arrays &arrays) {
    Arrays wrong = arrays;
    wrong.indices[1][5] = SCENE_VERTICES;
    require(status_of([&] { mlrt::Tree tree(wrong.meshes()); }, "vertex index 100") == MLRT_ERROR_INDEX_RANGE, "index");
    require(status_of([&] { mlrt::Pool pool(5000); }, "thread_count: 5000") == MLRT_ERROR_ARGUMENT, "too many threads");
    mlrt::Tree tree(arrays.meshes());
    const std::vector<float> none;
    require(status_of([&] { tree.trace(mlrt::Rays(none, arrays.directions)); }, "") == MLRT_ERROR_ARGUMENT,
            "no origins");
    const std::vector<float> one = {1, 2, 3};
    require(status_of([&] { tree.trace(mlrt::Rays(one, arrays.directions)); },
                      "rays.origins: 1 elements, where 1000") == MLRT_ERROR_ARGUMENT,
            "one origin");
    const mlrt::Hits hits = tree.trace(arrays.rays());
    require(tree.trace(mlrt::Rays()).size() == 0 && tree.all_hits(mlrt::Rays(), 2).total.empty(), "no rays");
    const mlrt::Points no_points{mlrt::Input<float, 3>()};
    const mlrt::Light light = mlrt::Light::point(zero);
    require(tree.occluded(mlrt::Rays()).empty() && tree.occluded_points(no_points, light).empty(), "no rays or points");
    const auto of_none = [&](const mlrt::Tree &t) {
        return status_of([&] { t.trace(mlrt::Rays()); }, "tree: NULL") == MLRT_ERROR_ARGUMENT &&
               status_of([&] { t.all_hits(mlrt::Rays(), 2); }, "tree: NULL") == MLRT_ERROR_ARGUMENT &&
               status_of([&] { t.occluded_points(no_points, light); }, "tree: NULL") == MLRT_ERROR_ARGUMENT;
    };
    require(of_none(mlrt::Tree()), "no rays through an empty tree");
    mlrt::Rays unlimited = arrays.rays();
    std::vector<float> cleared(8);
    cleared.clear();
    unlimited.t_max = cleared;
    require(hash_of(tree.trace(unlimited)) == hash_of(hits), "an empty container is left out, also one with memory");

    // Too many results are an error before memory is taken for them.
    mlrt::Rays many(mlrt::Input<float, 3>::all(zero), mlrt::Input<float, 3>::all(along_z));
    many.rays_per_origin = 0xFFFFFFFF;
    require(status_of([&] { tree.trace(many); }, "rays.count") == MLRT_ERROR_TOO_LARGE, "too many rays");
    require(status_of([&] { tree.occluded(many); }, "rays.count") == MLRT_ERROR_TOO_LARGE, "too many rays");
    require(status_of([&] { tree.all_hits(many, 1); }, "rays.count") == MLRT_ERROR_TOO_LARGE, "too many rays");
    mlrt::Camera wide;
    wide.width = wide.height = 1 << 23, wide.dx[0] = wide.dy[1] = wide.d00[2] = 1;
    require(status_of([&] { tree.render(wide); }, "more pixels") == MLRT_ERROR_TOO_LARGE, "too many pixels");
    wide.width = wide.height = 0xFFFFFFFF;
    require(status_of([&] { tree.render(wide); }, "camera.width") == MLRT_ERROR_TOO_LARGE, "too many pixels");
    require(status_of([&] { tree.render(mlrt::Camera()); }, "") == MLRT_ERROR_CAMERA, "a camera without pixels");
    mlrt::Tree moved(std::move(tree)), other{std::vector<mlrt_mesh>()};
    require(status_of([&] { tree.trace(arrays.rays()); }, "") == MLRT_ERROR_ARGUMENT, "a moved-from tree");
    other = std::move(moved);
    require(hash_of(other.trace(arrays.rays())) == hash_of(hits), "a moved tree");
    require(mlrt::version() == 100 && mlrt::knows_all_structs(), "a library of another version");
    require(mlrt::capabilities() == mlrt_capabilities(), "capabilities");
}

static void builders(const Arrays &arrays) {
    const mlrt::Hits hits = mlrt::Tree(arrays.meshes()).trace(arrays.rays());
    const mlrt::Pool pool(2);
    mlrt::Host host;
    std::vector<int32_t> levels;
    host.log = [&](int32_t level, const char *) { levels.push_back(level); };
    mlrt::TreeOptions options;
    options.preset = MLRT_TREE_BEST, options.traversal_cost = 2, options.intersection_cost = 0.5f;
    options.memory_limit = 1 << 24, options.pool = pool.get(), options.host = host.get();
    require(mlrt::estimate(arrays.meshes(), options).memory_size > 0, "an estimate");
    const mlrt::Tree tree(arrays.meshes(), options);
    require(hash_of(tree.trace(arrays.rays())) == hash_of(hits), "options change no answer");
    options.memory_limit = 100;
    require(status_of([&] { mlrt::Tree small(arrays.meshes(), options); }, "") == MLRT_ERROR_OUT_OF_MEMORY, "a limit");
    require(levels == std::vector<int32_t>({MLRT_LOG_WARNING, MLRT_LOG_INFO, MLRT_LOG_ERROR}), "messages");

    mlrt::KdTreeOptions kd;
    kd.preset = MLRT_KDTREE_TUNED, kd.traversal_cost = 1, kd.intersection_cost = 2, kd.memory_limit = 1 << 24;
    kd.max_references = 100000, kd.max_depth = 5, kd.rules_off = MLRT_RULE_COPLANAR, kd.pool = pool.get(),
    kd.host = host.get();
    require(mlrt::estimate(arrays.meshes(), kd).memory_size > 0, "an estimate");
    const mlrt::Tree kdtree(arrays.meshes(), kd);
    const uint64_t can = mlrt_capabilities();
    const int32_t narrowest = can & MLRT_CAN_SSE ? MLRT_ISA_SSE : can & MLRT_CAN_NEON ? MLRT_ISA_NEON : MLRT_ISA_SCALAR;
    require(kdtree.info().structure == MLRT_STRUCTURE_KDTREE && kdtree.info().depth == 5, "a kd-tree");
    for (int32_t method = MLRT_METHOD_DEFAULT; method <= MLRT_METHOD_MULTILEVEL; method++) {
        mlrt::Counters counters;
        mlrt::TraceOptions trace;
        trace.set(counters).set(host);
        trace.method = method, trace.isa = narrowest, trace.culling = MLRT_CULLING_DIRECT, trace.culling_check = 1;
        trace.initial_tile_size = 16, trace.minimum_tile_size = 8, trace.split_factor = 4;
        trace.shortcuts_off = MLRT_SHORTCUT_WHOLE_TILES;
        require(hash_of(kdtree.trace(arrays.rays(), trace)) == hash_of(hits), "a kd-tree changes no answer");
        require(counters.ray_count == SCENE_RAYS, "counters");
    }
}

static void shapes(const Arrays &arrays) {
    struct Vertex {
        float normal[3];
        Point position;
    };
    const mlrt::Tree tree(arrays.meshes());
    const mlrt::Hits hits = tree.trace(arrays.rays());

    // A mesh of structs, and one of 16-bit indices with a fourth one.
    std::vector<Vertex> structs(SCENE_VERTICES);
    for (size_t i = 0; i < structs.size(); i++) std::copy_n(&arrays.vertices[0][3 * i], 3, structs[i].position.begin());
    std::vector<uint16_t> quads;
    for (size_t i = 0; i < arrays.indices[0].size(); i++) {
        quads.push_back(static_cast<uint16_t>(arrays.indices[0][i]));
        if (i % 3 == 2) quads.push_back(999);
    }
    std::vector<mlrt_mesh> meshes = arrays.meshes();
    meshes[0] = mlrt::mesh(mlrt::Input<float, 3>::field(structs, &Vertex::position),
                           mlrt::Input<uint16_t, 3>(quads.data(), SCENE_TRIANGLES, 8), scene_ids[0]);
    require(mlrt::hash_geometry(meshes) == mlrt::hash_geometry(arrays.meshes()), "the same triangles");
    require(hash_of(mlrt::Tree(meshes).trace(arrays.rays())) == hash_of(hits), "the same answers");

    // Vectors with padding, results as structs.
    std::vector<float> padded;
    for (size_t i = 0; i < arrays.directions.size(); i++) {
        padded.push_back(arrays.directions[i]);
        if (i % 3 == 2) padded.push_back(9);
    }
    mlrt::Rays rays(arrays.origins, mlrt::Input<float, 3>(padded.data(), SCENE_RAYS, 16));
    rays.row_length = 100;
    std::vector<mlrt::Hit> records(SCENE_RAYS);
    tree.trace(rays, mlrt::HitArrays::records(records));
    for (size_t i = 0; i < SCENE_RAYS; i++)
        require(bool(records[i]) == (hits.facing[i] != 0) && records[i].t == hits.t[i] && records[i].v == hits.v[i],
                "records");

    // One origin and one limit for all; four rays from each origin.
    const float half = 0.5f;
    const Point origin = {{arrays.origins[15], arrays.origins[16], arrays.origins[17]}};
    mlrt::Rays all(mlrt::Input<float, 3>::all(origin), arrays.directions);
    all.t_max = mlrt::Input<float>::all(half);
    const std::vector<Point> origins(SCENE_RAYS, origin);
    const std::vector<float> limits(SCENE_RAYS, half);
    mlrt::Rays written_out(origins, arrays.directions);
    written_out.t_max = limits;
    require(hash_of(tree.trace(all)) == hash_of(tree.trace(written_out)), "one element for all");
    std::vector<Point> every(SCENE_RAYS / 4), repeated(SCENE_RAYS);
    for (size_t i = 0; i < SCENE_RAYS; i++) std::copy_n(&arrays.origins[i / 4 * 12], 3, repeated[i].begin());
    for (size_t i = 0; i < every.size(); i++) every[i] = repeated[4 * i];
    mlrt::Rays bundles(every, arrays.directions);
    bundles.rays_per_origin = 4;
    require(hash_of(tree.trace(bundles)) == hash_of(tree.trace(mlrt::Rays(repeated, arrays.directions))), "bundles");
    bundles.rays_per_origin = 3;
    require(status_of([&] { tree.trace(bundles); }, "rays_per_origin") == MLRT_ERROR_ARGUMENT, "bundles of three");
}

static void limits_skips_masks() {
    const mlrt::Tree tree({mlrt::mesh(walls, 4)});
    const std::vector<Point> origins(4, zero), directions(4, along_z);
    const std::vector<float> t_min = {0, 5, 0, 0}, t_max = {infinity, infinity, 4.5f, 9};
    const std::vector<uint32_t> skip = {MLRT_NONE, MLRT_NONE, MLRT_NONE, MLRT_NONE, MLRT_NONE, MLRT_NONE, 4, 0};
    mlrt::Rays rays(origins, directions);
    rays.t_min = t_min, rays.t_max = t_max, rays.skip = skip;
    require(tree.trace(rays).triangle == std::vector<uint32_t>({0, 1, MLRT_NONE, 1}), "limits and skips");

    mlrt::Ray ray(zero, along_z);
    require(tree.trace_ray(ray).triangle == 0 && tree.occluded_ray(ray), "a ray");
    ray.t_min = 5, ray.t_max = 9;
    require(tree.trace_ray(ray).triangle == 1, "a ray with limits");
    ray.t_min = 0;
    require(tree.trace_ray(ray.pass_through(4, 0)).triangle == 1, "a ray that passes through");
    ray.t_min = 5;
    require(!tree.trace_ray(ray.pass_through(4, 1)), "a ray that passes through the second wall");

    const std::vector<uint32_t> front = {0, 1, 2}, back = {3, 4, 5}, masks = {0, 1, 2, 4};
    const mlrt::Tree masked({mlrt::mesh(walls, front, 0, 1), mlrt::mesh(walls, back, 0, 2)});
    mlrt::TraceOptions options;
    options.mask = 2;
    require(masked.trace(mlrt::Rays(origins, directions), options).mesh == std::vector<uint32_t>(4, 1), "a mask");
    rays = mlrt::Rays(origins, directions);
    rays.mask = masks;
    require(masked.trace(rays).mesh == std::vector<uint32_t>({0, 0, 1, MLRT_NONE}), "masks");
}

static mlrt::Camera camera_of_walls() {
    mlrt::Camera camera;
    camera.width = camera.height = 64, camera.crop_x = camera.crop_y = 8, camera.crop_width = 48,
    camera.crop_height = 40;
    camera.eye[0] = 0.25f;
    camera.d00[0] = camera.d00[1] = -0.5f, camera.d00[2] = 1;
    camera.dx[0] = camera.dy[1] = 1.0f / 64;
    return camera;
}

static void pictures() {
    const mlrt::Tree tree({mlrt::mesh(walls)});
    mlrt::Camera camera = camera_of_walls();
    const size_t columns = camera.columns(), rows = camera.rows(), n = columns * rows;
    std::vector<Point> origins(n), directions(n);
    camera.rays(origins, directions);
    const mlrt::Hits picture = tree.render(camera);
    require(hash_of(picture) == hash_of(tree.trace(mlrt::Rays(origins, directions))), "the rays of a camera");

    // The first light is in front of the wall, the second behind it.
    const std::vector<mlrt::Light> lights = {mlrt::Light::point(along_z), mlrt::Light::directional(along_z)};
    const mlrt::Pool pool(2);
    mlrt::TraceOptions options;
    options.set(pool).set(lights);
    options.initial_tile_size = 16;
    options.outputs = MLRT_OUTPUT_T | MLRT_OUTPUT_IDS | MLRT_OUTPUT_OCCLUDED;
    std::atomic<size_t> seen(0), wrong(0);
    const auto callback = [&](const mlrt_tile &tile) {
        for (uint32_t i = 0; i < tile.width * tile.height; i++) {
            const size_t pixel = (tile.y - 8 + i / tile.width) * columns + tile.x - 8 + i % tile.width;
            wrong += tile.t[i] != picture.t[pixel] || tile.triangle[i] != picture.triangle[pixel] ||
                     tile.occluded[i] != (picture.facing[pixel] ? 2 : 0);
        }
        seen += tile.width * tile.height;
        return true;
    };
    std::vector<uint8_t> occluded(64 * rows, 9);
    mlrt::HitArrays frame;
    frame.occluded = mlrt::Output<uint8_t>(occluded).rows(64);
    tree.render(camera, &frame, callback, options);
    require(seen == n && wrong == 0, "tiles");
    for (size_t i = 0; i < occluded.size(); i++)
        require(occluded[i] == (i % 64 >= columns ? 9 : picture.facing[i / 64 * columns + i % 64] ? 2 : 0), "frame");

    camera.projection = MLRT_PROJECTION_PARALLEL, camera.direction[2] = 1, camera.t_min = 3, camera.t_max = 9;
    mlrt::TraceOptions any;
    any.query = MLRT_QUERY_ANY;
    occluded.assign(n, 0), frame.occluded = occluded;
    tree.render(camera, &frame, nullptr, any);
    require(occluded == std::vector<uint8_t>(n, 1), "a parallel camera");
    occluded.pop_back(), frame.occluded = occluded;
    require(status_of([&] { tree.render(camera, &frame, nullptr, any); }, "shorter") == MLRT_ERROR_ARGUMENT,
            "a short frame");

    const auto stop = [](const mlrt_tile &) { return false; };
    mlrt::TraceOptions distances;
    distances.outputs = MLRT_OUTPUT_T;
    require(status_of([&] { tree.render(camera, nullptr, stop, distances); }, "") == MLRT_ERROR_CANCELLED,
            "a render that stops");
    bool caught = false;
    try {
        tree.render(
            camera, nullptr, [](const mlrt_tile &) -> bool { throw std::out_of_range("in a callback"); }, distances);
    } catch (const std::out_of_range &) {
        caught = true;
    }
    require(caught, "an exception of a callback");
}

static void points_and_hits() {
    const mlrt::Tree tree({mlrt::mesh(walls)});
    const mlrt::Ray ray(zero, along_z);
    const mlrt::Hit hit = tree.trace_ray(ray);
    const Point point = tree.offset_point(hit.mesh, hit.triangle, hit.u, hit.v, -hit.facing);
    require(point[2] < 5 && point[2] > 4.99f, "a point off the wall");
    require(status_of([&] { tree.offset_point(0, 2, 0, 0, 1); }, "") == MLRT_ERROR_ARGUMENT, "no such triangle");
    const mlrt::Light front = mlrt::Light::point(along_z), behind = mlrt::Light::directional(along_z);
    const mlrt::Ray shadow = tree.shadow_ray(ray, hit, front);
    require(shadow.flags == MLRT_RAY_SKIP && shadow.t_max == 1 && !tree.occluded_ray(shadow), "a shadow ray");
    require(tree.shadow_ray(ray, hit, behind).direction[2] == 0, "a light behind");
    const std::vector<Point> positions = {point, {{0, 0, 6}}, {{0, 0, 5}}};
    const std::vector<uint32_t> skip = {MLRT_NONE, MLRT_NONE, MLRT_NONE, MLRT_NONE, 0, 0};
    mlrt::Points points((mlrt::Input<float, 3>(positions)));
    points.skip = skip, points.row_length = 3;
    require(tree.occluded_points(points, front) == std::vector<uint8_t>({0, 1, 0}), "points in shadow");

    const std::vector<Point> origins = {zero, {{0, 0, 6}}, {{0, 50, 0}}};
    const mlrt::Rays rays(origins, mlrt::Input<float, 3>::all(along_z));
    const mlrt::HitLists lists = tree.all_hits(rays, 2);
    require(lists.triangle == std::vector<uint32_t>({0, 1, 1, MLRT_NONE, MLRT_NONE, MLRT_NONE}), "all hits");
    require(lists.total == std::vector<uint32_t>({2, 1, 0}) && lists.crossing_total == lists.total, "their totals");
    require(lists.crossing == std::vector<uint8_t>({1, 1, 1, 0, 0, 0}), "crossings");
    require(tree.all_hits(rays, 0).total == lists.total, "totals alone");
}

static void saving(const Arrays &arrays) {
    const mlrt::Tree tree(arrays.meshes());
    const uint64_t hash = hash_of(tree.trace(arrays.rays()));
    const std::vector<uint8_t> bytes = tree.save();
    mlrt::LoadOptions options;
    options.geometry_hash = mlrt::hash_geometry(arrays.meshes()), options.memory_limit = 1 << 24;
    const mlrt::Tree copied = mlrt::Tree::load(bytes, options);
    require(hash_of(copied.trace(arrays.rays())) == hash, "a loaded tree");
    options.geometry_hash++;
    require(status_of([&] { mlrt::Tree::load(bytes, options); }, "") == MLRT_ERROR_DATA, "other triangles");
    std::vector<uint8_t> space(bytes.size() + 64);
    uint8_t *const aligned = space.data() + (64 - reinterpret_cast<uintptr_t>(space.data()) % 64) % 64;
    std::copy(bytes.begin(), bytes.end(), aligned);
    mlrt::LoadOptions in_place;
    in_place.flags = MLRT_LOAD_IN_PLACE;
    mlrt::Host host;
    host.log = [](int32_t, const char *) {};
    in_place.host = host.get();
    const mlrt::Tree mapped = mlrt::Tree::load(aligned, bytes.size(), in_place);
    require(hash_of(mapped.trace(arrays.rays())) == hash, "a tree in place");
    require(mapped.info().memory_size < copied.info().memory_size / 10, "it takes no memory");
}

static void hosts(const Arrays &arrays) {
    mlrt::Host host;
    std::atomic<int> blocks(0);
    double last = 0;
    host.allocate = [&](size_t size, size_t alignment) {
        blocks++;
        void *block = nullptr;
        return posix_memalign(&block, std::max(alignment, sizeof(void *)), size) ? nullptr : block;
    };
    host.free = [&](void *block, size_t, size_t) {
        blocks--;
        std::free(block);
    };
    host.progress = [&](double fraction) {
        require(fraction >= last, "progress");
        last = fraction;
        return true;
    };
    mlrt::TreeOptions options;
    options.host = host.get();
    {
        const mlrt::Tree tree(arrays.meshes(), options);
        require(last == 1 && blocks > 0, "a host");
        mlrt_pool_options pool_options = mlrt::make<mlrt_pool_options>();
        pool_options.host = host.get(), pool_options.thread_count = 2;
        const mlrt::Pool pool(pool_options);
        tree.trace(arrays.rays(), mlrt::TraceOptions().set(pool));
    }
    require(blocks == 0, "all memory is freed");

    const mlrt::Tree tree(arrays.meshes());
    mlrt::Host stop;
    stop.progress = [](double) { return false; };
    const std::vector<Point> many(4000000, Point{{0.5f, 0.25f, 0.125f}});
    mlrt::TraceOptions trace;
    trace.method = MLRT_METHOD_RAY;
    const mlrt::Rays rays(mlrt::Input<float, 3>::all(zero), many);
    require(status_of([&] { tree.trace(rays, trace.set(stop)); }, "") == MLRT_ERROR_CANCELLED,
            "a call that is cancelled");
    stop.progress = [](double) -> bool { throw std::out_of_range("in progress"); };
    bool caught = false;
    try {
        tree.trace(arrays.rays(), trace.set(stop));
    } catch (const std::out_of_range &) {
        caught = true;
    }
    require(caught, "an exception of a host");
}

static void executors(const Arrays &arrays) {
    const mlrt::Tree tree(arrays.meshes());
    const uint64_t hash = hash_of(tree.trace(arrays.rays()));
    // Jobs on threads of their own, jobs that run at once, and jobs that get lost.
    const mlrt::Pool threads(4, [](std::function<void()> job) { std::thread(job).detach(); });
    const mlrt::Pool inline_pool(4, [](std::function<void()> job) { job(); });
    const mlrt::Pool lost(4, [](std::function<void()>) {});
    for (const mlrt::Pool *pool : {&threads, &inline_pool, &lost}) {
        require(pool->thread_count() == 4, "jobs of a pool");
        mlrt::TraceOptions options;
        options.set(*pool).initial_tile_size = 16, options.outputs = MLRT_OUTPUT_T;
        for (int i = 0; i < 20; i++) require(hash_of(tree.trace(arrays.rays(), options)) == hash, "an executor");
        // Jobs for which there is no memory.
        mlrt::Hits hits(SCENE_RAYS);
        for (int succeed = 0; succeed < 4; succeed++) {
            allocations = succeed;
            const bool is_done = bool(tree.try_trace(arrays.rays(), hits.arrays(), options));
            allocations = -1;
            require(is_done && hash_of(hits) == hash, "an executor without memory");
        }
        // Within a job: no thread waits for one that waits for it.
        tree.render(
            camera_of_walls(), nullptr,
            [&](const mlrt_tile &) { return hash_of(tree.trace(arrays.rays(), options)) == hash; }, options);
    }
}

int main() {
    const Arrays arrays;
    without_exceptions(arrays);
    const mlrt::Tree tree(arrays.meshes());
    const mlrt::Pool pool(2);
    const mlrt::Hits hits = tree.trace(arrays.rays());
    require(hash_of(tree.trace(arrays.origins, arrays.directions, &pool)) == hash_of(hits), "a pool changes nothing");
    const std::vector<uint8_t> occluded = tree.occluded(arrays.rays(), mlrt::TraceOptions().set(pool));
    for (size_t i = 0; i < SCENE_RAYS; i++)
        require(occluded[i] == (hits.mesh[i] != MLRT_NONE), "any hit is a closest hit");
    errors(arrays);
    builders(arrays);
    shapes(arrays);
    limits_skips_masks();
    pictures();
    points_and_hits();
    saving(arrays);
    hosts(arrays);
    executors(arrays);
    std::printf("%016" PRIx64 "\n", hash_of(hits));
    return 0;
}

#else

int main() {
    without_exceptions(Arrays());
    return 0;
}

#endif
