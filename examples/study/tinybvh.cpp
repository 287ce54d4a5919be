/* SPDX-License-Identifier: MIT */
/*
 * tinybvh.cpp - tinybvh behind functions of C: see tinybvh.h
 *
 * Its fastest layout for x86 processors of today (BVH8_CPU, AVX2), built with spatial splits (BuildHQ), one ray at a
 * time: it has no packets there. Its constructor of rays divides directions by their length, which rounds them; the
 * rays here keep the direction that they were given, so that no wrong answer comes from that.
 *
 * Based on: its header's "How to use", version 1.6.
 */
#define TINYBVH_IMPLEMENTATION
#include "tinybvh.h"

#include <tiny_bvh.h>

#include <algorithm>
#include <cmath>
#include <vector>

struct tinybvh_scene {
    std::vector<tinybvh::bvhvec4> corners;
    tinybvh::BVH8_CPU hierarchy;
};

// The greatest length of a triangle over its height. On meshes of triangles a million times as long as high the builders
// end the program.
static const double GREATEST_ASPECT = 5e5;

static double greatest_aspect(const std::vector<tinybvh::bvhvec4> &corners)
{
    double greatest = 0;
    for (size_t i = 0; i + 2 < corners.size(); i += 3) {
        double e[2][3], longest = 0, area = 0;
        for (int k = 0; k < 3; k++) {
            e[0][k] = static_cast<double>(corners[i + 1][k]) - corners[i][k];
            e[1][k] = static_cast<double>(corners[i + 2][k]) - corners[i][k];
        }
        for (int k = 0; k < 3; k++) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            area += std::pow(e[0][l] * e[1][m] - e[0][m] * e[1][l], 2);
        }
        for (const auto &edge : e) longest = std::max(longest, edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]);
        if (area > 0) greatest = std::max(greatest, longest / std::sqrt(area));
    }
    return greatest;
}

extern "C" struct tinybvh_scene *tinybvh_create(const float *vertices, size_t vertex_count, const uint32_t *indices,
                                                size_t triangle_count)
{
    (void)vertex_count;
    if (triangle_count == 0) return nullptr;
    tinybvh_scene *scene = new tinybvh_scene;
    scene->corners.reserve(3 * triangle_count);
    for (size_t i = 0; i < 3 * triangle_count; i++) {
        const float *p = vertices + 3 * static_cast<size_t>(indices[i]);
        scene->corners.push_back(tinybvh::bvhvec4(p[0], p[1], p[2], 0));
    }
    if (greatest_aspect(scene->corners) > GREATEST_ASPECT) {
        delete scene;
        return nullptr;
    }
    scene->hierarchy.BuildHQ(scene->corners.data(), static_cast<uint32_t>(triangle_count));
    return scene;
}

extern "C" void tinybvh_trace(const struct tinybvh_scene *scene, const float (*origins)[3],
                              const float (*directions)[3], size_t count, uint32_t miss, uint32_t *triangles,
                              float *t)
{
    for (size_t i = 0; i < count; i++) {
        const float *o = origins[i], *d = directions[i];
        tinybvh::Ray ray(tinybvh::bvhvec3(o[0], o[1], o[2]), tinybvh::bvhvec3(d[0], d[1], d[2]));
        ray.D = tinybvh::bvhvec3(d[0], d[1], d[2]);
        ray.rD = tinybvh::tinybvh_rcp(ray.D);
        scene->hierarchy.Intersect(ray);
        triangles[i] = ray.hit.t < BVH_FAR ? ray.hit.prim : miss;
        if (t) t[i] = ray.hit.t;
    }
}

extern "C" void tinybvh_destroy(struct tinybvh_scene *scene)
{
    delete scene;
}
