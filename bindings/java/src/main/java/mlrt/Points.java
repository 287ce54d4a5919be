// SPDX-License-Identifier: MIT
package mlrt;

/**
 * Points of which {@link Tree#occludedPoints} tells whether they are in shadow.
 *
 * @param positions three floats each
 * @param skip pairs of ints: mesh and triangle that the point lies on, which does not shade it; null = none
 * @param rowLength points in a row of a picture; 0 = a plain list. A hint for speed only
 */
public record Points(Array positions, Array skip, int rowLength) {
    /**
     * A list of points.
     *
     * @param positions three numbers each
     */
    public Points(float[] positions) {
        this(Array.of(positions), null, 0);
    }

    long count() {
        MlrtException.notNegative("points.rowLength", rowLength);
        if (positions.stride() == Array.STRIDE_ALL) throw new IllegalArgumentException("positions: one point for all is no list");
        long bytes = positions.data().byteSize();
        long count = positions.stride() == 0 ? positions.count(12) : bytes < 12 ? 0 : (bytes - 12) / positions.stride() + 1;
        return MlrtException.checkCount("points.count", count);
    }

    Native.Struct toStruct(Call call) {
        var struct = call.struct(Native.POINTS).set("count", count()).set("row_length", rowLength);
        call.input(struct, "positions", positions, count(), 12, "positions");
        call.input(struct, "skip", skip, count(), 8, "skip");
        return struct;
    }
}
