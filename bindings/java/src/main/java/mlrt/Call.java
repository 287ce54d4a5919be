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
import java.util.function.BooleanSupplier;
import mlrt.Native.Struct;
import mlrt.Native.Type;

/** A call of the library: its arguments in native memory, the objects that it uses, and the callbacks that it makes. */
final class Call implements AutoCloseable {
    private static final MethodHandle ON_PROGRESS = method("onProgress", int.class, MemorySegment.class, double.class);
    private static final MethodHandle ON_LOG = method("onLog", void.class, MemorySegment.class, int.class, MemorySegment.class);
    private static final MethodHandle ON_TILE = method("onTile", int.class, MemorySegment.class, MemorySegment.class);

    /** The call whose callback a thread runs. */
    private static final ThreadLocal<Call> CURRENT = new ThreadLocal<>();

    /** Where the elements of an array lie: `count` of `size` bytes, `step` bytes apart. */
    private record Place(String name, long start, long count, long step, long size) {
        /** Elements without gaps are like one. */
        static Place of(String name, MemorySegment data, long count, long step, long size) {
            return step == size ? new Place(name, data.address(), Math.min(count, 1), step, count * size)
                : new Place(name, data.address(), count, step, size);
        }

        /** Whether two arrays have bytes in common. Of different strides with gaps it is not known: then false. */
        boolean meets(Place other) {
            if (count == 0 || other.count == 0) return false;
            if (count > 1 && other.count > 1 && step != other.step) return false;
            long apart = count > 1 ? step : other.step, distance = other.start - start;
            // The first of the other's elements, seen from one of these, that ends behind its begin: does it begin before its end?
            long k = Math.max(1 - count, Math.floorDiv(-other.size - distance, apart) + 1);
            return k < other.count && distance + k * apart < size;
        }
    }

    private final Call outer = CURRENT.get(); // within whose callback this one is made, or null
    private final Arena arena = Arena.ofConfined();
    private final List<Place> places = new ArrayList<>();
    private final List<Handle> held = new ArrayList<>();
    private final List<Object> kept = new ArrayList<>();
    private Progress progress;
    private Log log;
    private TileCallback tiles;
    private Counters counters;
    private Struct counts;
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
        for (var call = outer; call != null && handle instanceof Pool pool && pool.ownThreads; call = call.outer) {
            if (call.held.contains(handle)) throw new IllegalStateException("the Pool's threads make the call whose callback this is");
        }
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
        long elements = array.stride() == Array.STRIDE_ALL ? 1 : count, step = array.stride() > 0 ? array.stride() : size;
        if (array.data().isNative()) places.add(Place.of(name, array.data(), elements, step, size));
        struct.memory().set(Native.L, struct.type().offsets().get(field) + 8, array.stride());
    }

    /** Remembers where results lie. Throws if they have bytes in common with others, or with what the call reads. */
    private void keepApart(Place results) {
        for (var other : places) {
            if (results.meets(other)) throw new IllegalArgumentException(results.name + ": it shares memory with " + other.name);
        }
        places.add(results);
    }

    /** Writes an array for results, `rows` of `columns` elements of `size` bytes, to a field. */
    void output(Struct struct, String field, Array array, long columns, long rows, int size) {
        output(struct, field, array, columns, rows, size, field);
    }

    void output(Struct struct, String field, Array array, long columns, long rows, int size, String name) {
        if (array == null) return;
        array.checkOutput(columns, rows, size, name);
        checkAlive(array.data());
        kept.add(array.data());
        long step = array.stride() == 0 ? size : array.stride(), rowStep = array.rowStride();
        if (rows < 2 || rowStep == 0 || rowStep == columns * step) keepApart(Place.of(name, array.data(), columns * rows, step, size));
        else if (step == size) keepApart(Place.of(name, array.data(), rows, rowStep, columns * size)); // gaps between rows only
        struct.set(field, array.data());
        long at = struct.type().offsets().get(field);
        struct.memory().set(Native.L, at + 8, array.stride());
        struct.memory().set(Native.L, at + 16, array.rowStride());
    }

    /** The counts of this call, which close() adds to those. */
    MemorySegment count(Counters counters) {
        this.counters = counters;
        counts = struct(Native.COUNTERS);
        return counts.memory();
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

    /** Runs a callback. 1 = end the call, for it says false, or has thrown. */
    private int run(BooleanSupplier callback) {
        var before = CURRENT.get();
        try {
            CURRENT.set(this);
            return callback.getAsBoolean() ? 0 : 1;
        } catch (Throwable problem) {
            thrown = problem;
            return 1;
        } finally {
            CURRENT.set(before);
        }
    }

    private int onProgress(MemorySegment user, double fraction) {
        return run(() -> thrown == null && progress.report(fraction));
    }

    private void onLog(MemorySegment user, int level, MemorySegment message) {
        run(() -> {
            var levels = Log.Level.values();
            log.log(levels[Math.clamp(level, 0, levels.length - 1)], Native.string(message));
            return true;
        });
    }

    private int onTile(MemorySegment user, MemorySegment memory) {
        return run(() -> {
            try (var arena = Arena.ofConfined()) {
                return thrown == null && tiles.accept(new Tile(memory, arena));
            }
        });
    }

    /** Throws what a callback threw, or what the status says; to be called at once, on the thread of the call. */
    void check(int status) throws Throwable {
        String reason = status == 0 ? null : Native.string((MemorySegment) Native.LAST_MESSAGE.invokeExact());
        if (thrown != null) throw thrown;
        if (status != 0) throw new MlrtException(status, reason);
    }

    @Override
    public void close() {
        if (counters != null) counters.add(counts);
        held.forEach(Handle::release);
        arena.close();
        Reference.reachabilityFence(kept);
    }
}
