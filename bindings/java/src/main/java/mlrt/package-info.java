// SPDX-License-Identifier: MIT
/**
 * Where do rays hit triangles: the exact answers of libmlrt, for arrays and memory segments.
 *
 * <pre>{@code
 * try (var tree = Tree.build(new Mesh(vertices, indices))) {  // float[], int[]
 *     var hits = tree.trace(origins, directions);             // float[], three per ray
 *     System.out.println(hits.t(0) + " " + hits.triangle(0));
 * }
 * }</pre>
 *
 * Native segments, those of direct buffers too, are used without a copy; heap arrays are copied once. Run with {@code
 * --enable-native-access=ALL-UNNAMED}. The library is the first of: the file of the property {@code mlrt.path}; libmlrt in a
 * folder of {@code java.library.path}; the one in the jar, loaded by way of a temporary file; what the system finds as
 * libmlrt.so.0.
 */
package mlrt;
