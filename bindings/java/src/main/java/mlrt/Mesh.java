// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.MemorySegment;

/** An indexed triangle mesh. Heap arrays are copied while the tree is built, native memory is used as it is. */
public final class Mesh {
    private final Array vertices;
    private final Array indices;
    private final int indexSize;
    private int id;
    private int mask;

    private Mesh(Array vertices, Array indices, int indexSize) {
        this.vertices = vertices;
        this.indices = indices;
        this.indexSize = indexSize;
    }

    /**
     * A mesh of indices.
     *
     * @param vertices three numbers each
     * @param indices three vertices for each triangle
     */
    public Mesh(float[] vertices, int[] indices) {
        this(Array.of(vertices), Array.of(indices), Integer.BYTES);
    }

    /**
     * A mesh of 2-byte indices, which are unsigned.
     *
     * @param vertices three numbers each
     * @param indices three vertices for each triangle
     */
    public Mesh(float[] vertices, short[] indices) {
        this(Array.of(vertices), Array.of(MemorySegment.ofArray(indices)), Short.BYTES);
    }

    /**
     * Triangles without indices: triangle i has the vertices 3i, 3i + 1, 3i + 2.
     *
     * @param vertices three numbers each
     */
    public Mesh(float[] vertices) {
        this(Array.of(vertices), null, 0);
    }

    /**
     * A mesh in memory, with strides.
     *
     * @param vertices three floats each
     * @param indices three indices each; null = none
     * @param indexSize the bytes of an index, 2 or 4
     * @return the mesh
     */
    public static Mesh of(Array vertices, Array indices, int indexSize) {
        return new Mesh(vertices, indices, indices == null ? 0 : indexSize);
    }

    /**
     * What is reported with hits. If all ids are 0, they are 0, 1, 2, ...
     *
     * @param value the id
     * @return this
     */
    public Mesh id(int value) {
        id = value;
        return this;
    }

    /**
     * Rays see the mesh if their mask has a bit in common with it; 0 = all bits.
     *
     * @param value the mask
     * @return this
     */
    public Mesh mask(int value) {
        mask = value;
        return this;
    }

    private static long count(Array array, int size, String name) {
        if (array.stride() < 0) throw new IllegalArgumentException(name + ": a stride is below 0");
        long bytes = array.data().byteSize();
        if (array.stride() > 0) return bytes < size ? 0 : (bytes - size) / array.stride() + 1;
        if (bytes % size != 0) throw new IllegalArgumentException(name + ": " + bytes + " bytes are not three numbers each");
        return bytes / size;
    }

    static MemorySegment toNative(Mesh[] meshes, Call call) {
        var list = call.allocate(Math.max(1, meshes.length) * Native.MESH.size());
        for (int i = 0; i < meshes.length; i++) {
            var mesh = meshes[i];
            String name = "meshes[" + i + "].";
            var struct = new Native.Struct(Native.MESH, list.asSlice(i * Native.MESH.size(), Native.MESH.size()));
            long vertices = count(mesh.vertices, 12, name + "vertices");
            struct.set("struct_size", (int) Native.MESH.size()).set("id", mesh.id).set("mask", mesh.mask)
                .set("vertices", call.toNative(mesh.vertices.data())).set("vertex_count", vertices)
                .set("vertex_stride", mesh.vertices.stride()).set("index_size", mesh.indexSize).set("triangle_count", vertices / 3);
            if (mesh.indices == null && vertices % 3 != 0)
                throw new IllegalArgumentException(name + "vertices: " + vertices + " are not three for each triangle");
            if (mesh.indices == null) continue;
            if (mesh.indexSize != 2 && mesh.indexSize != 4) throw new IllegalArgumentException(name + "indexSize: " + mesh.indexSize + " is not 2 or 4");
            struct.set("indices", call.toNative(mesh.indices.data())).set("triangle_stride", mesh.indices.stride())
                .set("triangle_count", count(mesh.indices, 3 * mesh.indexSize, name + "indices"));
        }
        return list;
    }
}
