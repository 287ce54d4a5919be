// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.invoke.MethodHandle;
import java.lang.ref.Cleaner;

/** What a Tree and a Pool have in common: an object of the library, freed by close(), or some time after the last use. */
abstract sealed class Handle implements AutoCloseable permits Tree, Pool {
    private static final Cleaner CLEANER = Cleaner.create();

    /** What is freed; it must not refer to the Handle. */
    private record Resource(MemorySegment object, MethodHandle destroy, Arena kept) implements Runnable {
        @Override
        public void run() {
            try {
                destroy.invokeExact(object);
            } catch (Throwable problem) {
                throw Native.unexpected(problem);
            }
            if (kept != null) kept.close();
        }
    }

    private final MemorySegment object;
    private final Cleaner.Cleanable cleanable;
    private int calls;
    private boolean closed;

    /** `kept`, which may be null, is closed after the object is freed. */
    Handle(MemorySegment object, MethodHandle destroy, Arena kept) {
        this.object = object;
        cleanable = CLEANER.register(this, new Resource(object, destroy, kept));
    }

    /** The object, for a call that ends with release(). */
    synchronized MemorySegment acquire() {
        if (closed) throw new IllegalStateException("the " + getClass().getSimpleName() + " is closed");
        calls++;
        return object;
    }

    synchronized void release() {
        calls--;
    }

    /** Frees it now. Again does nothing. IllegalStateException if a call is using it. */
    @Override
    public synchronized void close() {
        if (calls > 0) throw new IllegalStateException("the " + getClass().getSimpleName() + " is in use by another call");
        closed = true;
        cleanable.clean();
    }
}
