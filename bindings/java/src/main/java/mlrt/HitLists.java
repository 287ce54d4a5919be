// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.Arena;

/**
 * All hits of rays: `capacity` elements per ray, so hit j of ray i is element i * capacity + j. Arrays that are null are
 * not wanted.
 *
 * @param capacity most hits written per ray; 0 = only the totals are
 * @param t floats: distances
 * @param u floats: the weights of second vertices
 * @param v floats: the weights of third vertices
 * @param mesh ints: ids of meshes
 * @param triangle ints: numbers of triangles
 * @param facing ints: signs
 * @param crossing bytes: 1 = the hit crosses the surface, 0 = it only touches it, or there is no hit
 * @param total ints, one per ray: the number of its hits, with those beyond `capacity`
 * @param crossingTotal ints, one per ray: how many of these cross the surface
 */
public record HitLists(int capacity, Array t, Array u, Array v, Array mesh, Array triangle, Array facing, Array crossing,
                       Array total, Array crossingTotal) implements HitArrays {
    /**
     * Room for all of it.
     *
     * @param rays how many
     * @param capacity most hits per ray; 0 = room for the totals alone
     * @param arena whose memory it is
     * @return the arrays
     */
    public static HitLists allocate(long rays, int capacity, Arena arena) {
        Array[] arrays = new Array[9];
        MlrtException.checkCount("rays.count", rays);
        if (capacity < 0 || capacity > 0 && rays > Long.MAX_VALUE / 4 / capacity)
            throw new IllegalArgumentException("lists: no room for " + rays + " rays of " + capacity + " hits");
        for (int i = 0; i < 7 && capacity > 0; i++) arrays[i] = Array.of(arena.allocate((i < 6 ? 4 : 1) * rays * capacity, 64));
        for (int i = 7; i < 9; i++) arrays[i] = Array.of(arena.allocate(4 * rays, 64));
        return new HitLists(capacity, arrays[0], arrays[1], arrays[2], arrays[3], arrays[4], arrays[5], arrays[6], arrays[7], arrays[8]);
    }

    Native.Struct toStruct(Call call, long rays) {
        if (capacity < 0) throw new IllegalArgumentException("capacity: " + capacity + " is below 0");
        var struct = call.struct(Native.HIT_LISTS).set("capacity", capacity);
        if (capacity > 0 && rays > Long.MAX_VALUE / capacity) throw new IllegalArgumentException("capacity: too much for " + rays + " rays");
        long hits = rays * capacity;
        call.output(struct, "t", t, hits, 1, 4);
        call.output(struct, "u", u, hits, 1, 4);
        call.output(struct, "v", v, hits, 1, 4);
        call.output(struct, "mesh", mesh, hits, 1, 4);
        call.output(struct, "triangle", triangle, hits, 1, 4);
        call.output(struct, "facing", facing, hits, 1, 4);
        call.output(struct, "crossing", crossing, hits, 1, 1);
        call.output(struct, "total", total, rays, 1, 4);
        call.output(struct, "crossing_total", crossingTotal, rays, 1, 4);
        return struct;
    }

    /**
     * Whether the hit crosses the surface.
     *
     * @param i the number of the element
     * @return the value
     */
    public boolean crossing(long i) {
        return crossing.getByte(i) != 0;
    }

    /**
     * The number of hits of ray i.
     *
     * @param i the number of the element
     * @return the value
     */
    public int total(long i) {
        return total.getInt(i);
    }

    /**
     * The number of hits of ray i that cross the surface: odd inside a closed mesh, even outside.
     *
     * @param i the number of the element
     * @return the value
     */
    public int crossingTotal(long i) {
        return crossingTotal.getInt(i);
    }
}
