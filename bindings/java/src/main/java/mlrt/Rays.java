// SPDX-License-Identifier: MIT
package mlrt;

/** Rays, in arrays with an element per ray, or one for all. */
public final class Rays {
    private final Array origins;
    private final Array directions;
    private Array tMin;
    private Array tMax;
    private Array skip;
    private Array mask;
    private int raysPerOrigin = 1;
    private int rowLength;
    private long count = -1;

    /**
     * Rays from 0 without a limit.
     *
     * @param origins three floats each
     * @param directions three floats each, of any length
     */
    public Rays(Array origins, Array directions) {
        this.origins = origins;
        this.directions = directions;
    }

    /**
     * Rays from 0 without a limit.
     *
     * @param origins three numbers each
     * @param directions three numbers each, of any length
     */
    public Rays(float[] origins, float[] directions) {
        this(Array.of(origins), Array.of(directions));
    }

    /**
     * Floats; null = 0 for all.
     *
     * @param value the new value
     * @return this
     */
    public Rays tMin(Array value) {
        tMin = value;
        return this;
    }

    /**
     * Floats; null = no limit. 0 means 0.
     *
     * @param value the new value
     * @return this
     */
    public Rays tMax(Array value) {
        tMax = value;
        return this;
    }

    /**
     * Pairs of ints: mesh and triangle, as reported, that the ray passes through; null = none.
     *
     * @param value the new value
     * @return this
     */
    public Rays skip(Array value) {
        skip = value;
        return this;
    }

    /**
     * Ints: a mask for each ray in place of that of the options; null = none.
     *
     * @param value the new value
     * @return this
     */
    public Rays mask(Array value) {
        mask = value;
        return this;
    }

    /**
     * k: each k neighbouring rays have one element of origins, tMin and skip.
     *
     * @param value the new value
     * @return this
     */
    public Rays raysPerOrigin(int value) {
        if (value < 1) throw new IllegalArgumentException("raysPerOrigin: " + value + " is below 1");
        raysPerOrigin = value;
        return this;
    }

    /**
     * Rays in a row of a picture; 0 = not known. A hint for speed only.
     *
     * @param value the new value
     * @return this
     */
    public Rays rowLength(int value) {
        rowLength = MlrtException.notNegative("rowLength", value);
        return this;
    }

    /**
     * The number of rays, where no packed array of directions, tMax, masks or origins tells it.
     *
     * @param value the new value
     * @return this
     */
    public Rays count(long value) {
        count = MlrtException.checkCount("rays.count", value);
        return this;
    }

    private static long count(Array array, int size) {
        return array == null ? -1 : array.count(size);
    }

    /** The number of rays. */
    long count() {
        long[] found = {count, count(directions, 12), count(tMax, 4), count(mask, 4)};
        for (long number : found) {
            if (number >= 0) return MlrtException.checkCount("rays.count", number);
        }
        long groups = count(origins, 12);
        if (groups < 0) throw new IllegalArgumentException("count: it is needed, since no array of rays is packed");
        return MlrtException.checkCount("rays.count", MlrtException.checkCount("rays.count", groups) * raysPerOrigin);
    }

    Native.Struct toStruct(Call call) {
        long rays = count(), groups = rays / raysPerOrigin;
        var struct = call.struct(Native.RAYS).set("row_length", rowLength).set("count", rays).set("rays_per_origin", raysPerOrigin);
        call.input(struct, "origins", origins, groups, 12, "origins");
        call.input(struct, "directions", directions, rays, 12, "directions");
        call.input(struct, "t_min", tMin, groups, 4, "tMin");
        call.input(struct, "t_max", tMax, rays, 4, "tMax");
        call.input(struct, "skip", skip, groups, 8, "skip");
        call.input(struct, "mask", mask, rays, 4, "mask");
        return struct;
    }
}
