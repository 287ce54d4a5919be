// SPDX-License-Identifier: MIT
package mlrt;

/** How to load a saved tree: {@link Tree#load}. */
public final class LoadOptions {
    boolean inPlace;
    long geometryHash;
    long memoryLimit;
    Log log;

    /** The defaults. */
    public LoadOptions() {}

    /**
     * Use the data where it lies, if its address is a multiple of 64: it must not change, and its arena must stay open, until the tree is closed.
     *
     * @param value the new value
     * @return this
     */
    public LoadOptions inPlace(boolean value) {
        inPlace = value;
        return this;
    }

    /**
     * What {@link Mlrt#hashGeometry} says of the meshes: a tree of others is an error; 0 = any.
     *
     * @param value the new value
     * @return this
     */
    public LoadOptions geometryHash(long value) {
        geometryHash = value;
        return this;
    }

    /**
     * Most bytes held at one time; 0 = no limit.
     *
     * @param value the new value
     * @return this
     */
    public LoadOptions memoryLimit(long value) {
        memoryLimit = MlrtException.notNegative("memoryLimit", value);
        return this;
    }

    /**
     * Receives messages; null = none.
     *
     * @param value the new value
     * @return this
     */
    public LoadOptions log(Log value) {
        log = value;
        return this;
    }

    Native.Struct toStruct(Call call) {
        return call.struct(Native.LOAD_OPTIONS).set("flags", inPlace ? 1 : 0).set("geometry_hash", geometryHash)
            .set("memory_limit", memoryLimit).set("host", call.host(null, log));
    }
}
