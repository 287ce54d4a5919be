// SPDX-License-Identifier: MIT
package mlrt;

/** Receives the finished tiles of a picture, each once. The threads of the pool call it, several at a time. */
@FunctionalInterface
public interface TileCallback {
    /**
     * Receives a tile. An exception ends the render, which throws it.
     *
     * @param tile the tile, which this thread can read until this returns
     * @return true to go on; false to end the render with {@link MlrtException.Status#CANCELLED}
     */
    boolean accept(Tile tile);
}
