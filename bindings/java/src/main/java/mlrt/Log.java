// SPDX-License-Identifier: MIT
package mlrt;

/** Receives the messages of a call, on its thread. */
@FunctionalInterface
public interface Log {
    /** Kinds of messages. */
    enum Level {
        /** The reason why the call fails. */
        ERROR,
        /** Something was left out. */
        WARNING,
        /** A tree was built, or the host stopped a call. */
        INFO
    }

    /**
     * Receives one line.
     *
     * @param level its kind
     * @param message its text
     */
    void log(Level level, String message);
}
