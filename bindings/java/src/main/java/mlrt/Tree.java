// SPDX-License-Identifier: MIT
package mlrt;

import static mlrt.Native.P;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;

/**
 * Triangles, and what finds them. It never changes; any number of threads may trace it at once. No segment that is given to
 * a call may be closed before the call ends.
 */
public final class Tree extends Handle {
    private final MemorySegment data; // a tree that was loaded in place needs it

    private Tree(MemorySegment tree, MemorySegment data) {
        super(tree, Native.DESTROY_TREE, null);
        this.data = data;
    }

    @Override
    MemorySegment acquire() {
        if (data != null && !data.scope().isAlive()) throw new IllegalStateException("the memory that the Tree was loaded from was freed");
        return super.acquire();
    }

    // ---- making trees ------------------------------------------------------------------------------------------------

    /** What the out parameter of a builder holds; frees it if a callback threw. */
    private static Tree made(Call call, int status, MemorySegment out, MemorySegment data) throws Throwable {
        var tree = out.get(P, 0);
        try {
            call.check(status);
        } catch (Throwable problem) {
            Native.DESTROY_TREE.invokeExact(tree);
            throw problem;
        }
        return new Tree(tree, data);
    }

    /**
     * The best tree there is, a hierarchy of boxes, over all triangles of meshes.
     *
     * @param meshes the meshes; none is allowed
     * @return the tree
     */
    public static Tree build(Mesh... meshes) {
        return build(new TreeOptions(), meshes);
    }

    /**
     * The same with options.
     *
     * @param options how to build
     * @param meshes the meshes; none is allowed
     * @return the tree
     */
    public static Tree build(TreeOptions options, Mesh... meshes) {
        try (var call = new Call()) {
            var list = Mesh.toNative(meshes, call);
            var settings = options.toStruct(call).memory();
            var out = call.allocate(P.byteSize());
            return made(call, (int) Native.BUILD_TREE.invokeExact(list, (long) meshes.length, settings, out), out, null);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * The kd-tree of the paper, for study.
     *
     * @param options how to build
     * @param meshes the meshes; none is allowed
     * @return the tree
     */
    public static Tree buildKdtree(KdtreeOptions options, Mesh... meshes) {
        try (var call = new Call()) {
            var list = Mesh.toNative(meshes, call);
            var settings = options.toStruct(call).memory();
            var out = call.allocate(P.byteSize());
            return made(call, (int) Native.BUILD_KDTREE.invokeExact(list, (long) meshes.length, settings, out), out, null);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * A saved tree.
     *
     * @param data the bytes that {@link #save(Arena)} returned, for example of a mapped file
     * @param options how to load
     * @return the tree
     */
    public static Tree load(MemorySegment data, LoadOptions options) {
        if (options.inPlace && !data.isNative()) throw new IllegalArgumentException("data: in place means in native memory");
        try (var call = new Call()) {
            var bytes = call.toNative(data);
            var settings = options.toStruct(call).memory();
            var out = call.allocate(P.byteSize());
            return made(call, (int) Native.LOAD_TREE.invokeExact(bytes, data.byteSize(), settings, out), out, options.inPlace ? data : null);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * A saved tree.
     *
     * @param data the bytes that {@link #save()} returned
     * @return the tree
     */
    public static Tree load(byte[] data) {
        return load(MemorySegment.ofArray(data), new LoadOptions());
    }

    /**
     * The bytes from which {@link #load(MemorySegment, LoadOptions)} makes the same tree.
     *
     * @param arena whose memory it is
     * @return the bytes, at an address that can be loaded in place
     */
    public MemorySegment save(Arena arena) {
        try (var call = new Call()) {
            var self = call.hold(this);
            var size = call.allocate(Long.BYTES);
            call.check((int) Native.SAVE_TREE.invokeExact(self, MemorySegment.NULL, 0L, size));
            var bytes = arena.allocate(size.get(Native.L, 0), 64);
            call.check((int) Native.SAVE_TREE.invokeExact(self, bytes, bytes.byteSize(), size));
            return bytes;
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * The bytes from which {@link #load(byte[])} makes the same tree.
     *
     * @return the bytes
     */
    public byte[] save() {
        try (var arena = Arena.ofConfined()) {
            return save(arena).toArray(ValueLayout.JAVA_BYTE);
        }
    }

    /**
     * The build report.
     *
     * @return the report
     */
    public TreeInfo info() {
        try (var call = new Call()) {
            var info = call.struct(Native.TREE_INFO);
            call.check((int) Native.GET_TREE_INFO.invokeExact(call.hold(this), info.memory()));
            return new TreeInfo(info);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    // ---- many rays ---------------------------------------------------------------------------------------------------

    /**
     * The closest hit of each ray.
     *
     * @param origins three numbers each
     * @param directions three numbers each, of any length
     * @return the hits, in memory that the garbage collector frees
     */
    public Hits trace(float[] origins, float[] directions) {
        return trace(new Rays(origins, directions), new TraceOptions());
    }

    /**
     * What the options ask of each ray: its closest hit, or whether there is one.
     *
     * @param rays the rays
     * @param options the query, and how to trace
     * @return the results, in memory that the garbage collector frees
     */
    public Hits trace(Rays rays, TraceOptions options) {
        var hits = Hits.allocateFor(options, rays.count());
        trace(rays, options, hits);
        return hits;
    }

    /**
     * The same into memory of the caller's.
     *
     * @param rays the rays
     * @param options the query, and how to trace
     * @param hits where results go
     */
    public void trace(Rays rays, TraceOptions options, Hits hits) {
        try (var call = new Call()) {
            var self = call.hold(this);
            var list = rays.toStruct(call).memory();
            var settings = options.toStruct(call, options.query, false).memory();
            var out = hits.toStruct(call, rays.count(), 1).memory();
            call.check((int) Native.TRACE_PACKET.invokeExact(self, list, settings, out));
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * Whether rays hit anything.
     *
     * @param rays the rays
     * @param options how to trace; its query is not used
     * @return 1 or 0 for each ray
     */
    public byte[] occluded(Rays rays, TraceOptions options) {
        try (var call = new Call()) {
            var self = call.hold(this);
            var list = rays.toStruct(call).memory();
            var settings = options.toStruct(call, TraceOptions.Query.ANY, false).memory();
            var occluded = call.allocate(Math.max(1, rays.count()));
            var out = call.struct(Native.HITS).set("occluded", occluded).memory();
            call.check((int) Native.TRACE_PACKET.invokeExact(self, list, settings, out));
            return occluded.asSlice(0, rays.count()).toArray(ValueLayout.JAVA_BYTE);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * Every triangle that each ray hits, nearest first.
     *
     * @param rays the rays
     * @param capacity most hits per ray; 0 = only their number
     * @param options how to trace: mask, pool, counters, progress and log are used
     * @return the lists, in memory that the garbage collector frees
     */
    public HitLists allHits(Rays rays, int capacity, TraceOptions options) {
        var lists = HitLists.allocate(rays.count(), capacity, Arena.ofAuto());
        allHits(rays, options, lists);
        return lists;
    }

    /**
     * The same into memory of the caller's.
     *
     * @param rays the rays
     * @param options how to trace: mask, pool, counters, progress and log are used
     * @param lists where results go
     */
    public void allHits(Rays rays, TraceOptions options, HitLists lists) {
        try (var call = new Call()) {
            var self = call.hold(this);
            var list = rays.toStruct(call).memory();
            var settings = options.toStruct(call, TraceOptions.Query.CLOSEST, false).memory();
            var out = lists.toStruct(call, rays.count()).memory();
            call.check((int) Native.TRACE_ALL_HITS.invokeExact(self, list, settings, out));
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * Which points are in the shadow of a light.
     *
     * @param points the points
     * @param light the light
     * @param options how to trace; its query is not used
     * @return 1 for each point that the light does not reach, else 0
     */
    public byte[] occludedPoints(Points points, Light light, TraceOptions options) {
        try (var call = new Call()) {
            var self = call.hold(this);
            var list = points.toStruct(call).memory();
            var lamp = light.toNative(call);
            var settings = options.toStruct(call, TraceOptions.Query.CLOSEST, false).memory();
            var occluded = call.allocate(Math.max(1, points.count()));
            var out = call.allocate(Native.ARRAY.size());
            out.set(P, 0, occluded);
            call.check((int) Native.OCCLUDED_POINTS.invokeExact(self, list, lamp, settings, out));
            return occluded.asSlice(0, points.count()).toArray(ValueLayout.JAVA_BYTE);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    // ---- pictures ----------------------------------------------------------------------------------------------------

    /**
     * A picture: what the options ask of the ray of each pixel, row by row; with lights, also which reach it.
     *
     * @param camera the camera
     * @param options the query, the lights, and how to trace
     * @return the results, in memory that the garbage collector frees
     */
    public Hits render(Camera camera, TraceOptions options) {
        var frame = Hits.allocateFor(options, camera.pixels());
        render(camera, options, frame, null);
        return frame;
    }

    /**
     * The same into memory of the caller's, tile by tile, or both.
     *
     * @param camera the camera
     * @param options the query, the lights, how to trace, and the outputs that a tile has
     * @param frame where results go; null = nowhere
     * @param tiles receives each tile; null = none
     */
    public void render(Camera camera, TraceOptions options, Hits frame, TileCallback tiles) {
        try (var call = new Call()) {
            var self = call.hold(this);
            var view = camera.toStruct(call).memory();
            var settings = options.toStruct(call, options.query, true).memory();
            var out = frame == null ? MemorySegment.NULL : frame.toStruct(call, camera.columns(), camera.rows()).memory();
            var callback = call.tiles(tiles);
            call.check((int) Native.RENDER_TILES.invokeExact(self, view, settings, out, callback, MemorySegment.NULL));
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    // ---- single rays -------------------------------------------------------------------------------------------------

    private Native.Struct traceOne(Call call, Ray ray, TraceOptions options, TraceOptions.Query query) throws Throwable {
        var hit = call.struct(Native.HIT);
        var self = call.hold(this);
        var settings = options.toStruct(call, query, false).memory();
        call.check((int) Native.TRACE_RAY.invokeExact(self, ray.toStruct(call).memory(), settings, hit.memory()));
        return hit;
    }

    /**
     * The closest hit of one ray. For more than a few, {@link #trace(Rays, TraceOptions)} is many times faster per ray.
     *
     * @param ray the ray
     * @param options how to trace; its query is not used
     * @return the hit
     */
    public Hit traceRay(Ray ray, TraceOptions options) {
        try (var call = new Call()) {
            var hit = traceOne(call, ray, options, TraceOptions.Query.CLOSEST);
            return new Hit(hit.getFloat("t"), hit.getFloat("u"), hit.getFloat("v"), hit.getInt("mesh"), hit.getInt("triangle"),
                hit.getInt("facing"));
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * Whether one ray hits anything.
     *
     * @param ray the ray
     * @param options how to trace; its query is not used
     * @return false for a miss
     */
    public boolean occludedRay(Ray ray, TraceOptions options) {
        try (var call = new Call()) {
            return traceOne(call, ray, options, TraceOptions.Query.ANY).getInt("occluded") != 0;
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * The ray that decides whether a light reaches the hit of a ray.
     *
     * @param ray a ray that hits something
     * @param mesh the id of the mesh that it hits
     * @param triangle the number of the triangle that it hits
     * @param light the light
     * @return the ray, which skips the triangle; null if the light is on the other side
     */
    public Ray shadowRay(Ray ray, int mesh, int triangle, Light light) {
        try (var call = new Call()) {
            var self = call.hold(this);
            var hit = call.struct(Native.HIT).set("mesh", mesh).set("triangle", triangle).memory();
            var shadow = call.struct(Native.RAY);
            var faces = call.allocate(Integer.BYTES);
            call.check((int) Native.SHADOW_RAY.invokeExact(self, ray.toStruct(call).memory(), hit, light.toNative(call), shadow.memory(), faces));
            return faces.get(Native.I, 0) == 0 ? null : new Ray(shadow);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * A point just off a triangle, next to (1 - u - v) a + u b + v c, strictly on one side.
     *
     * @param mesh the id of its mesh
     * @param triangle its number in the mesh
     * @param u the weight of the second vertex
     * @param v the weight of the third
     * @param side +1: that to which the normal points; -1: the other one; -facing of a hit: that from which the ray came
     * @return the point, three numbers
     */
    public float[] offsetPoint(int mesh, int triangle, float u, float v, int side) {
        try (var call = new Call()) {
            var point = call.allocate(12);
            call.check((int) Native.OFFSET_POINT.invokeExact(call.hold(this), mesh, triangle, u, v, side, point));
            return point.toArray(Native.F);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }
}
