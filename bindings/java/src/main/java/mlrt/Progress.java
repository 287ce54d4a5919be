// SPDX-License-Identifier: MIT
package mlrt;

/** Receives the progress of a call. Any thread of the call's pool calls it, one at a time. */
@FunctionalInterface
public interface Progress {
    /**
     * Receives the part that is done, every few milliseconds, and 1 at the end of a call that succeeds. An exception ends
     * the call, which throws it.
     *
     * @param fraction 0..1, never less than before
     * @return true to go on; false to end the call with {@link MlrtException.Status#CANCELLED}
     */
    boolean report(double fraction);
}
