// SPDX-License-Identifier: MIT
package mlrt;

/** The arrays of results that {@link Hits} and {@link HitLists} have both, and their elements. */
public sealed interface HitArrays permits Hits, HitLists {
    /**
     * The array of distances.
     *
     * @return floats; null = not wanted
     */
    Array t();

    /**
     * The array of the weights of second vertices.
     *
     * @return floats; null = not wanted
     */
    Array u();

    /**
     * The array of the weights of third vertices.
     *
     * @return floats; null = not wanted
     */
    Array v();

    /**
     * The array of ids of meshes.
     *
     * @return ints; null = not wanted
     */
    Array mesh();

    /**
     * The array of numbers of triangles.
     *
     * @return ints; null = not wanted
     */
    Array triangle();

    /**
     * The array of signs.
     *
     * @return ints; null = not wanted
     */
    Array facing();

    /**
     * The distance in units of the direction's length; infinite for a miss.
     *
     * @param i the number of the element
     * @return the value
     */
    default float t(long i) {
        return t().getFloat(i);
    }

    /**
     * The weight of the triangle's second vertex.
     *
     * @param i the number of the element
     * @return the value
     */
    default float u(long i) {
        return u().getFloat(i);
    }

    /**
     * The weight of its third.
     *
     * @param i the number of the element
     * @return the value
     */
    default float v(long i) {
        return v().getFloat(i);
    }

    /**
     * The id of the mesh; {@link Mlrt#NONE} = miss.
     *
     * @param i the number of the element
     * @return the value
     */
    default int mesh(long i) {
        return mesh().getInt(i);
    }

    /**
     * The number of the triangle in its mesh; {@link Mlrt#NONE} = miss.
     *
     * @param i the number of the element
     * @return the value
     */
    default int triangle(long i) {
        return triangle().getInt(i);
    }

    /**
     * The sign of direction . normal; 0 = miss.
     *
     * @param i the number of the element
     * @return the value
     */
    default int facing(long i) {
        return facing().getInt(i);
    }
}
