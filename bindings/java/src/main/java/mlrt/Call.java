// SPDX-License-Identifier: MIT
package mlrt;

import static mlrt.Native.I;
import static mlrt.Native.P;

import java.lang.foreign.Arena;
import java.lang.foreign.FunctionDescriptor;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.lang.invoke.MethodHandle;
import java.lang.invoke.MethodHandles;
import java.lang.invoke.MethodType;
import java.lang.ref.Reference;
import java.util.ArrayList;
import java.util.List;
import mlrt.Native.Struct;
import mlrt.Native.Type;

/** A call of the library: its arguments in native memory, the objects that it uses, and the callbacks that it makes. */
final class Call implements AutoCloseable {
    private static final MethodHandle ON_PROGRESS = method("onProgress", int.class, MemorySegment.class, double.class);
    private static final MethodHandle ON_LOG = method("onLog", void.class, MemorySegment.class, int.class, MemorySegment.class);
    private static final MethodHandle ON_TILE = method("onTile", int.class, MemorySegment.class, MemorySegment.class);

    private final Arena arena = Arena.ofConfined();
    private final List<Handle> held = new ArrayList<>();
    private final List<Object> kept = new ArrayList<>();
    private Progress progress;
    private Log log;
    private TileCallback tiles;
    private volatile Throwable thrown; // by a callback: exceptions must not leave it

    private static MethodHandle method(String name, Class<?> result, Class<?>... arguments) {
        try {
            return MethodHandles.lookup().findVirtual(Call.class, name, MethodType.methodType(result, arguments));
        } catch (ReflectiveOperationException impossible) {
            throw new LinkageError(name, impossible);
        }
    }

    Struct struct(Type type) {
        return Struct.make(type, arena);
    }

    MemorySegment allocate(long size) {
        return arena.allocate(size, 64);
    }

    /** The object of a handle, which is in use until the end of the call; NULL for null. */
    MemorySegment hold(Handle handle) {
        if (handle == null) return MemorySegment.NULL;
        var object = handle.acquire();
        held.add(handle);
        return object;
    }

    /** Of memory that was freed, C would get the address all the same. */
    private static void checkAlive(MemorySegment segment) {
        if (!segment.scope().isAlive() || !segment.isAccessibleBy(Thread.currentThread()))
            throw new IllegalStateException("an array's memory was freed, or is another thread's");
    }

    /** Native memory as it is; a copy of a heap array. */
    MemorySegment toNative(MemorySegment segment) {
        checkAlive(segment);
        if (!segment.isNative()) return arena.allocate(segment.byteSize(), 8).copyFrom(segment);
        kept.add(segment);
        return segment;
    }

    /** Writes an input array of `count` elements of `size` bytes to a field. */
    void input(Struct struct, String field, Array array, long count, int size, String name) {
        if (array == null) return;
        array.checkInput(count, size, name);
        struct.set(field, toNative(array.data()));
        struct.memory().set(Native.L, struct.type().offsets().get(field) + 8, array.stride());
    }

    /** Writes an array for results, `rows` of `columns` elements of `size` bytes, to a field. */
    void output(Struct struct, String field, Array array, long columns, long rows, int size) {
        if (array == null) return;
        array.checkOutput(columns, rows, size, field);
        checkAlive(array.data());
        kept.add(array.data());
        struct.set(field, array.data());
        long at = struct.type().offsets().get(field);
        struct.memory().set(Native.L, at + 8, array.stride());
        struct.memory().set(Native.L, at + 16, array.rowStride());
    }

    /** A struct of callbacks; NULL if there are none. They are made for this call only. */
    MemorySegment host(Progress progress, Log log) {
        if (progress == null && log == null) return MemorySegment.NULL;
        this.progress = progress;
        this.log = log;
        var host = struct(Native.HOST);
        if (progress != null) host.set("progress", stub(ON_PROGRESS, FunctionDescriptor.of(I, P, ValueLayout.JAVA_DOUBLE)));
        if (log != null) host.set("log", stub(ON_LOG, FunctionDescriptor.ofVoid(P, I, P)));
        return host.memory();
    }

    MemorySegment tiles(TileCallback callback) {
        if (callback == null) return MemorySegment.NULL;
        tiles = callback;
        return stub(ON_TILE, FunctionDescriptor.of(I, P, P));
    }

    private MemorySegment stub(MethodHandle method, FunctionDescriptor type) {
        return Native.LINKER.upcallStub(method.bindTo(this), type, arena);
    }

    private int onProgress(MemorySegment user, double fraction) {
        try {
            return thrown == null && progress.report(fraction) ? 0 : 1;
        } catch (Throwable problem) {
            thrown = problem;
            return 1;
        }
    }

    private void onLog(MemorySegment user, int level, MemorySegment message) {
        try {
            var levels = Log.Level.values();
            log.log(levels[Math.clamp(level, 0, levels.length - 1)], Native.string(message));
        } catch (Throwable problem) {
            thrown = problem;
        }
    }

    private int onTile(MemorySegment user, MemorySegment tile) {
        try {
            return thrown == null && tiles.accept(new Tile(tile)) ? 0 : 1;
        } catch (Throwable problem) {
            thrown = problem;
            return 1;
        }
    }

    /** Throws what a callback threw, or what the status says; to be called at once, on the thread of the call. */
    void check(int status) throws Throwable {
        String reason = status == 0 ? null : Native.string((MemorySegment) Native.LAST_MESSAGE.invokeExact());
        if (thrown != null) throw thrown;
        if (status != 0) throw new MlrtException(status, reason);
    }

    @Override
    public void close() {
        held.forEach(Handle::release);
        arena.close();
        Reference.reachabilityFence(kept);
    }
}
