// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.Arena;

/**
 * The arrays that receive results, an element per ray or pixel. Those that are null are not wanted.
 *
 * @param t floats: distances
 * @param u floats: the weights of second vertices
 * @param v floats: the weights of third vertices
 * @param mesh ints: ids of meshes
 * @param triangle ints: numbers of triangles
 * @param facing ints: signs
 * @param occluded bytes: with {@link TraceOptions.Query#ANY} 1 = something is hit; with lights, bit k is 1 if light k does
 *     not reach the hit
 */
public record Hits(Array t, Array u, Array v, Array mesh, Array triangle, Array facing, Array occluded)
        implements HitArrays {
    /**
     * Room for closest hits.
     *
     * @param count how many
     * @param arena whose memory it is
     * @return the arrays, without `occluded`
     */
    public static Hits allocate(long count, Arena arena) {
        MlrtException.checkCount("hits", count);
        Array[] arrays = new Array[6];
        for (int i = 0; i < 6; i++) arrays[i] = Array.of(arena.allocate(4 * count, 64));
        return new Hits(arrays[0], arrays[1], arrays[2], arrays[3], arrays[4], arrays[5], null);
    }

    /**
     * The same arrays with another one for `occluded`.
     *
     * @param array bytes
     * @return the arrays
     */
    public Hits withOccluded(Array array) {
        return new Hits(t, u, v, mesh, triangle, facing, array);
    }

    /**
     * Room for {@link TraceOptions.Query#ANY}.
     *
     * @param count how many
     * @param arena whose memory it is
     * @return `occluded` alone
     */
    public static Hits allocateOccluded(long count, Arena arena) {
        MlrtException.checkCount("hits", count);
        return new Hits(null, null, null, null, null, null, Array.of(arena.allocate(count, 64)));
    }

    /** What a query writes, in memory that the garbage collector frees. */
    static Hits allocateFor(TraceOptions options, long count) {
        var arena = Arena.ofAuto();
        if (options.query == TraceOptions.Query.ANY) return allocateOccluded(count, arena);
        var hits = allocate(count, arena);
        return options.lights.length == 0 ? hits : hits.withOccluded(Array.of(arena.allocate(count, 64)));
    }

    Native.Struct toStruct(Call call, long columns, long rows) {
        var struct = call.struct(Native.HITS);
        call.output(struct, "t", t, columns, rows, 4);
        call.output(struct, "u", u, columns, rows, 4);
        call.output(struct, "v", v, columns, rows, 4);
        call.output(struct, "mesh", mesh, columns, rows, 4);
        call.output(struct, "triangle", triangle, columns, rows, 4);
        call.output(struct, "facing", facing, columns, rows, 4);
        call.output(struct, "occluded", occluded, columns, rows, 1);
        return struct;
    }

    /**
     * Whether something is hit, or the bits of the lights that do not reach the hit.
     *
     * @param i the number of the element
     * @return the value
     */
    public int occluded(long i) {
        return occluded.getByte(i) & 0xFF;
    }
}
