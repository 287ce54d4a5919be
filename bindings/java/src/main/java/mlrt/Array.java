// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.MemorySegment;
import java.nio.Buffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.nio.ShortBuffer;

/**
 * Elements in memory: packed, or with a stride. Native segments, those of direct buffers too, are used as they are; heap
 * arrays are copied once when they go in. Results go to native memory.
 *
 * @param data the memory, which must stay open during a call
 * @param stride bytes from one element to the next; 0 = packed; {@link #STRIDE_ALL} = one element serves all
 * @param rowStride for results of pictures: bytes from one row of pixels to the next; 0 = packed
 */
public record Array(MemorySegment data, long stride, long rowStride) {
    /** The stride of an input array whose one element serves all rays or points. */
    public static final long STRIDE_ALL = -1;

    /**
     * Packed elements.
     *
     * @param data the memory
     * @return the array
     */
    public static Array of(MemorySegment data) {
        return new Array(data, 0, 0);
    }

    /**
     * Packed elements, of a buffer between its position and its limit.
     *
     * @param data the buffer; a direct one is not copied
     * @return the array
     */
    public static Array of(Buffer data) {
        var order = switch (data) {
            case FloatBuffer numbers -> numbers.order();
            case IntBuffer numbers -> numbers.order();
            case ShortBuffer numbers -> numbers.order();
            default -> ByteOrder.nativeOrder();
        };
        if (order != ByteOrder.nativeOrder())
            throw new IllegalArgumentException("a buffer of the other byte order: ask its ByteBuffer for ByteOrder.nativeOrder() before");
        return of(MemorySegment.ofBuffer(data));
    }

    /**
     * Packed elements.
     *
     * @param data the numbers
     * @return the array
     */
    public static Array of(float[] data) {
        return of(MemorySegment.ofArray(data));
    }

    /**
     * Packed elements.
     *
     * @param data the numbers
     * @return the array
     */
    public static Array of(int[] data) {
        return of(MemorySegment.ofArray(data));
    }

    /**
     * Elements with a stride.
     *
     * @param data the memory, which begins with the first element
     * @param stride bytes from one element to the next
     * @return the array
     */
    public static Array strided(MemorySegment data, long stride) {
        return new Array(data, stride, 0);
    }

    /**
     * One element for all rays or points.
     *
     * @param element its numbers
     * @return the array
     */
    public static Array all(float... element) {
        return new Array(MemorySegment.ofArray(element), STRIDE_ALL, 0);
    }

    /**
     * One element for all rays or points.
     *
     * @param element its numbers
     * @return the array
     */
    public static Array all(int... element) {
        return new Array(MemorySegment.ofArray(element), STRIDE_ALL, 0);
    }

    /** How many elements of `size` bytes there are; -1 if that can't be told. */
    long count(int size) {
        return stride == 0 ? data.byteSize() / size : -1;
    }

    /** The bytes up to the end of an element of `size` bytes that begins `steps` steps after the first. */
    private static long reach(long steps, long step, long size) {
        try {
            return Math.addExact(Math.multiplyExact(steps, step), size);
        } catch (ArithmeticException more) {
            return Long.MAX_VALUE;
        }
    }

    private void checkStrides(String name) {
        if (stride < STRIDE_ALL || rowStride < 0) throw new IllegalArgumentException(name + ": a stride is below 0");
    }

    void checkInput(long count, int size, String name) {
        checkStrides(name);
        if (stride == 0) {
            long needed = count == 0 ? 0 : reach(count - 1, size, size);
            if (data.byteSize() != needed)
                throw new IllegalArgumentException(name + ": " + data.byteSize() + " bytes, but " + needed + " are needed");
        } else {
            checkRoom(stride == STRIDE_ALL ? size : count == 0 ? 0 : reach(count - 1, stride, size), name);
        }
    }

    void checkOutput(long columns, long rows, int size, String name) {
        checkStrides(name);
        if (!data.isNative() || data.isReadOnly())
            throw new IllegalArgumentException(name + ": results go to native memory that can be written");
        if (stride == STRIDE_ALL) throw new IllegalArgumentException(name + ": a stride is below 0");
        long step = stride == 0 ? size : stride;
        long rowStep = rowStride == 0 ? reach(columns, step, 0) : rowStride;
        checkRoom(columns == 0 || rows == 0 ? 0 : reach(rows - 1, rowStep, reach(columns - 1, step, size)), name);
        if (rowsOverlap(columns, rows, step, size))
            throw new IllegalArgumentException(name + ": rows " + rowStride + " bytes apart overlap");
    }

    /** Rows may lie within each other, as those of a transposed picture do. There must be space for all. */
    private boolean rowsOverlap(long columns, long rows, long step, int size) {
        for (long row = 1; rowStride > 0 && row < rows && row * rowStride / step < columns; row++) {
            long column = row * rowStride / step, rest = row * rowStride % step;
            if (rest < size || column + 1 < columns && step - rest < size) return true;
        }
        return false;
    }

    private void checkRoom(long needed, String name) {
        if (data.byteSize() < needed)
            throw new IndexOutOfBoundsException(name + ": " + data.byteSize() + " bytes are too few, " + needed + " are needed");
    }

    float getFloat(long i) {
        return data.get(Native.F, Math.multiplyExact(i, stride == 0 ? Float.BYTES : stride));
    }

    int getInt(long i) {
        return data.get(Native.I, Math.multiplyExact(i, stride == 0 ? Integer.BYTES : stride));
    }

    byte getByte(long i) {
        return data.get(java.lang.foreign.ValueLayout.JAVA_BYTE, Math.multiplyExact(i, stride == 0 ? 1 : stride));
    }
}
