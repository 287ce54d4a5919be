// SPDX-License-Identifier: MIT
package mlrt;

import static mlrt.Native.I;
import static mlrt.Native.P;

import java.lang.foreign.Arena;
import java.lang.foreign.FunctionDescriptor;
import java.lang.foreign.MemorySegment;
import java.lang.invoke.MethodHandle;
import java.lang.invoke.MethodHandles;
import java.lang.invoke.MethodType;
import java.util.Map;
import java.util.Objects;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.Executor;
import java.util.concurrent.FutureTask;
import java.util.concurrent.atomic.AtomicLong;

/** Threads that calls share their work with: its own, or those of an executor. */
public final class Pool extends Handle {
    /** Hands the tasks of the library to an executor. */
    private static final class Tasks {
        private static final MethodHandle TASK = Native.LINKER.downcallHandle(FunctionDescriptor.ofVoid(P));

        private final Executor executor;
        private final Map<Long, FutureTask<Void>> tasks = new ConcurrentHashMap<>();
        private final AtomicLong last = new AtomicLong();

        Tasks(Executor executor) {
            this.executor = executor;
        }

        private static void run(MemorySegment function, MemorySegment argument) {
            try {
                TASK.invokeExact(function, argument);
            } catch (Throwable problem) {
                throw Native.unexpected(problem);
            }
        }

        /** The number of the task; NULL if it has been run. */
        MemorySegment enqueue(MemorySegment user, MemorySegment function, MemorySegment argument) {
            var task = new FutureTask<Void>(() -> run(function, argument), null);
            long number = last.incrementAndGet();
            tasks.put(number, task);
            try {
                executor.execute(task::run); // not the task, which whoever has it could cancel
            } catch (Throwable refused) {
                // finish runs it
            }
            return MemorySegment.ofAddress(number);
        }

        /** Runs the task if no thread has begun with it, or else waits for its end. */
        void finish(MemorySegment user, MemorySegment number) {
            var task = tasks.remove(number.address());
            task.run();
            boolean interrupted = false;
            while (!task.isDone()) {
                try {
                    task.get();
                } catch (InterruptedException later) {
                    interrupted = true;
                } catch (java.util.concurrent.ExecutionException impossible) {
                    break;
                }
            }
            if (interrupted) Thread.currentThread().interrupt();
        }

        MemorySegment stub(String name, MethodType type, FunctionDescriptor descriptor, Arena arena) {
            try {
                return Native.LINKER.upcallStub(MethodHandles.lookup().findVirtual(Tasks.class, name, type).bindTo(this), descriptor, arena);
            } catch (ReflectiveOperationException impossible) {
                throw new LinkageError(name, impossible);
            }
        }
    }

    /** Whether a call with it waits for another one, and so must not be made in a callback of that. */
    final boolean ownThreads;

    private final int threads;

    /**
     * Threads of its own. Calls that share the pool wait for each other.
     *
     * @param threads how many are at work, the calling one included, 1..1024; 0 = one per processor
     */
    public Pool(int threads) {
        this(create(MlrtException.notNegative("threads", threads)), null);
    }

    /** `stubs`, of a pool without threads of its own, are closed after it is freed. */
    private Pool(MemorySegment pool, Arena stubs) {
        super(pool, Native.DESTROY_POOL, stubs);
        ownThreads = stubs == null;
        try {
            threads = (int) Native.POOL_THREAD_COUNT.invokeExact(pool);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * How many threads are at work, the calling one included; of an executor's, how many tasks. Also after close().
     *
     * @return the number, at least 1
     */
    public int threads() {
        return threads;
    }

    /**
     * The threads of an executor. Several calls may use the pool at once, also from tasks of the executor.
     *
     * @param executor what runs tasks; it must not be shut down before the pool is closed
     * @param tasks how many are at work at once, the calling thread included; 0 = one per processor
     * @return the pool
     */
    public static Pool of(Executor executor, int tasks) {
        Objects.requireNonNull(executor, "executor");
        MlrtException.notNegative("tasks", tasks);
        var stubs = Arena.ofShared();
        try (var call = new Call()) {
            var hooks = new Tasks(executor);
            var segment = MemorySegment.class;
            var options = call.struct(Native.POOL_OPTIONS).set("thread_count", tasks)
                .set("enqueue", hooks.stub("enqueue", MethodType.methodType(segment, segment, segment, segment), FunctionDescriptor.of(P, P, P, P), stubs))
                .set("finish", hooks.stub("finish", MethodType.methodType(void.class, segment, segment), FunctionDescriptor.ofVoid(P, P), stubs));
            var out = call.allocate(P.byteSize());
            call.check((int) Native.CREATE_POOL_WITH_OPTIONS.invokeExact(options.memory(), out));
            return new Pool(out.get(P, 0), stubs);
        } catch (Throwable problem) {
            stubs.close();
            throw Native.unexpected(problem);
        }
    }

    private static MemorySegment create(int threads) {
        try (var call = new Call()) {
            var out = call.allocate(P.byteSize());
            call.check((int) Native.CREATE_POOL.invokeExact(threads, out));
            return out.get(P, 0);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }
}
