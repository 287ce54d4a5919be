// SPDX-License-Identifier: MIT
package mlrt;

/**
 * The closest hit of one ray.
 *
 * @param t the distance in units of the direction's length; infinite for a miss
 * @param u the weight of the triangle's second vertex
 * @param v the weight of its third
 * @param mesh the id of the mesh; {@link Mlrt#NONE} = miss
 * @param triangle the number of the triangle in its mesh; {@link Mlrt#NONE} = miss
 * @param facing the sign of direction . normal; 0 = miss
 */
public record Hit(float t, float u, float v, int mesh, int triangle, int facing) {
    /**
     * Whether the ray hits anything.
     *
     * @return false for a miss
     */
    public boolean isHit() {
        return facing != 0;
    }
}
