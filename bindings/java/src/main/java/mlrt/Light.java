// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.MemorySegment;
import mlrt.Native.Struct;

/** A light. */
public final class Light {
    private final int kind;
    private final float[] position;

    private Light(int kind, float[] position) {
        if (position.length != 3) throw new IllegalArgumentException("position: three numbers are needed, not " + position.length);
        this.kind = kind;
        this.position = position.clone();
    }

    /**
     * A point light.
     *
     * @param position where it is
     * @return the light
     */
    public static Light point(float... position) {
        return new Light(0, position);
    }

    /**
     * A directional light.
     *
     * @param direction towards the light, of any length
     * @return the light
     */
    public static Light directional(float... direction) {
        return new Light(1, direction);
    }

    private void write(MemorySegment memory) {
        new Struct(Native.LIGHT, memory).set("struct_size", (int) Native.LIGHT.size()).set("kind", kind).set("position", position);
    }

    MemorySegment toNative(Call call) {
        return toNative(new Light[] {this}, call);
    }

    static MemorySegment toNative(Light[] lights, Call call) {
        var list = call.allocate(lights.length * Native.LIGHT.size());
        for (int i = 0; i < lights.length; i++) lights[i].write(list.asSlice(i * Native.LIGHT.size(), Native.LIGHT.size()));
        return list;
    }
}
