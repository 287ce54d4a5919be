/* SPDX-License-Identifier: MIT */
/*
 * watertight.c - the test of Woop, Benthin and Wald: no gaps between triangles that share an edge
 *
 * Once per ray: z is the axis along which the direction is longest, x and y are the two others in an order that keeps
 * the handedness, and the shear Sx = dx / dz, Sy = dy / dz, Sz = 1 / dz turns the direction into the z axis. Per
 * triangle, the corners relative to the origin are sheared, and the edge functions U, V, W are 2D determinants of their
 * x and y. If one of them is 0, all three are computed again in double. The ray hits if no two of them have different
 * signs; t = (U Az + V Bz + W Cz) / (U + V + W).
 *
 * This is the variant without back-face culling. As published, only the constants of the ray are precomputed.
 *
 * Based on: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", Journal of Computer Graphics
 * Techniques 2(1), 2013, section 3.
 */
#include "traversal.h"
#include "vector.h"

MLRT_INLINE void prepare(struct study_ray *ray)
{
    int z = 0;
    for (int k = 1; k < 3; k++) {
        if (fabsf(ray->direction[k]) > fabsf(ray->direction[z])) z = k;
    }
    int turned = ray->direction[z] < 0;
    int x = (z + 1 + turned) % 3, y = (z + 2 - turned) % 3;
    ray->axis[0] = x, ray->axis[1] = y, ray->axis[2] = z;
    ray->shear[0] = ray->direction[x] / ray->direction[z];
    ray->shear[1] = ray->direction[y] / ray->direction[z];
    ray->shear[2] = 1 / ray->direction[z];
}

MLRT_INLINE float determinant_in_double(float a, float b, float c, float d)
{
    return (float)((double)a * (double)b - (double)c * (double)d);
}

MLRT_INLINE int test_watertight(const void *table, const struct mlrt_triangle *triangles, uint32_t number,
                                const struct study_ray *ray, double *t)
{
    (void)table;
    const struct mlrt_triangle *triangle = &triangles[number];
    float x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) {
        float corner[3];
        subtract_float(triangle->v[i], ray->origin, corner);
        z[i] = corner[ray->axis[2]];
        x[i] = corner[ray->axis[0]] - ray->shear[0] * z[i];
        y[i] = corner[ray->axis[1]] - ray->shear[1] * z[i];
    }
    float u = x[2] * y[1] - y[2] * x[1];
    float v = x[0] * y[2] - y[0] * x[2];
    float w = x[1] * y[0] - y[1] * x[0];
    if (u == 0 || v == 0 || w == 0) {
        u = determinant_in_double(x[2], y[1], y[2], x[1]);
        v = determinant_in_double(x[0], y[2], y[0], x[2]);
        w = determinant_in_double(x[1], y[0], y[1], x[0]);
    }
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return 0;
    float sum = u + v + w;
    if (sum == 0) return 0;
    float scaled = ray->shear[2] * (u * z[0] + v * z[1] + w * z[2]);
    *t = (double)(scaled * (1 / sum));
    return 1;
}

static void trace(const struct method_run *run, const struct ray_set *rays, const struct answers *answers)
{
    walk_all(run, rays, prepare, test_watertight, answers);
}

const struct method watertight_methods[] = {
    {"woop2013", "Woop et al. 2013, watertight, float", 0, 0, 0, NULL, trace, NULL},
    {NULL, NULL, 0, 0, 0, NULL, NULL, NULL},
};
