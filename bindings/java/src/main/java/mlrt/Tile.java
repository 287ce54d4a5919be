// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import mlrt.Native.Struct;

/**
 * The results of a finished tile, row by row, in memory that is the library's: for the thread of the callback, until it
 * returns. Then, and elsewhere, reading it is an IllegalStateException or a WrongThreadException.
 */
public final class Tile {
    private final Struct struct;
    private final Arena arena;

    /** A tile that can be read until an arena is closed. */
    Tile(MemorySegment tile, Arena arena) {
        struct = new Struct(Native.TILE, tile.reinterpret(Native.TILE.size(), arena, null));
        this.arena = arena;
    }

    /**
     * The number of the worker that calls; calls that run at the same time have different ones.
     *
     * @return 0..threads - 1
     */
    public int worker() {
        return struct.getInt("worker");
    }

    /**
     * The column of the tile's first pixel.
     *
     * @return the column, counted like the camera's
     */
    public int x() {
        return struct.getInt("x");
    }

    /**
     * The row of the tile's first pixel.
     *
     * @return the row, counted like the camera's
     */
    public int y() {
        return struct.getInt("y");
    }

    /**
     * The tile's width.
     *
     * @return pixels
     */
    public int width() {
        return struct.getInt("width");
    }

    /**
     * The tile's height.
     *
     * @return pixels
     */
    public int height() {
        return struct.getInt("height");
    }

    private Array array(String name, int size) {
        var address = struct.getAddress(name);
        return address.address() == 0 ? null : Array.of(address.reinterpret((long) width() * height() * size, arena, null).asReadOnly());
    }

    /**
     * The results, those that {@link TraceOptions#outputs} names; the others are null.
     *
     * @return arrays that are valid until the callback returns
     */
    public Hits hits() {
        return new Hits(array("t", 4), array("u", 4), array("v", 4), array("mesh", 4), array("triangle", 4), array("facing", 4),
            array("occluded", 1));
    }
}
