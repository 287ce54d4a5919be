// SPDX-License-Identifier: MIT
package mlrt;

/** What the library says went wrong. The message names the argument, its value and the rule. */
public final class MlrtException extends RuntimeException {
    private static final long serialVersionUID = 1;

    /** What went wrong, in one word: MLRT_ERROR_* of mlrt.h. */
    public enum Status {
        /** Success; no exception has it. */
        OK,
        /** A value is out of its range. */
        ARGUMENT,
        /** A struct is of another version. */
        STRUCT_SIZE,
        /** A triangle names a vertex that does not exist. */
        INDEX_RANGE,
        /** An allocation failed, or a limit of memory was reached. */
        OUT_OF_MEMORY,
        /** More triangles, rays or pixels than 32-bit counts allow. */
        TOO_LARGE,
        /** A camera of size zero, with a crop outside it, or with numbers that are not finite. */
        CAMERA,
        /** An instruction set that this machine does not have, or a method of the other structure. */
        UNSUPPORTED,
        /** The system would not start a thread. */
        THREAD,
        /** A callback asked to stop. */
        CANCELLED,
        /** No saved tree, or one that is damaged, of another version, or of other triangles. */
        DATA,
        /** A status that is newer than this class. */
        UNKNOWN
    }

    /** The number of the status. */
    private final int code;

    MlrtException(int code, String reason) {
        super(reason.isEmpty() ? Mlrt.statusString(code) : reason);
        this.code = code;
    }

    /** Refuses what the library does, before memory is taken for it. */
    static long checkCount(String name, long count) {
        if (count < 0) throw new IllegalArgumentException(name + ": " + count + " is below 0");
        if (count <= Integer.MAX_VALUE) return count;
        throw new MlrtException(Status.TOO_LARGE.ordinal(), name + ": " + count + " is more than " + Integer.MAX_VALUE);
    }

    /** A number that is one of C's unsigned ones. */
    static int notNegative(String name, int value) {
        if (value < 0) throw new IllegalArgumentException(name + ": " + value + " is below 0");
        return value;
    }

    /** A number that is one of C's unsigned ones. */
    static long notNegative(String name, long value) {
        if (value < 0) throw new IllegalArgumentException(name + ": " + value + " is below 0");
        return value;
    }

    /**
     * What went wrong, in one word.
     *
     * @return the status
     */
    public Status status() {
        var all = Status.values();
        return code >= 0 && code < all.length - 1 ? all[code] : Status.UNKNOWN;
    }

    /**
     * The number of the status in mlrt.h.
     *
     * @return the number
     */
    public int code() {
        return code;
    }
}
