// SPDX-License-Identifier: MIT
package mlrt;

import mlrt.Native.Struct;

/** One ray. */
public final class Ray {
    private final float[] origin;
    private final float[] direction;
    private float tMin;
    private float tMax;
    private boolean skips;
    private int skipMesh;
    private int skipTriangle;

    /**
     * A ray from 0 without a limit.
     *
     * @param origin three numbers
     * @param direction three numbers, of any length
     */
    public Ray(float[] origin, float[] direction) {
        this.origin = origin.clone();
        this.direction = direction.clone();
    }

    /** What the library wrote. */
    Ray(Struct struct) {
        origin = struct.getVector("origin");
        direction = struct.getVector("direction");
        tMin = struct.getFloat("t_min");
        tMax = struct.getFloat("t_max");
        skips = (struct.getInt("flags") & 1) != 0;
        skipMesh = struct.getInt("skip_mesh");
        skipTriangle = struct.getInt("skip_triangle");
    }

    /**
     * Hits have t beyond it.
     *
     * @param value the least t; 0 = hits in front of the origin
     * @return this
     */
    public Ray tMin(float value) {
        tMin = value;
        return this;
    }

    /**
     * Hits have t up to it.
     *
     * @param value the greatest t; 0 = no limit
     * @return this
     */
    public Ray tMax(float value) {
        tMax = value;
        return this;
    }

    /**
     * A triangle to pass through.
     *
     * @param mesh its mesh, as reported
     * @param triangle its number, as reported
     * @return this
     */
    public Ray skip(int mesh, int triangle) {
        skips = true;
        skipMesh = mesh;
        skipTriangle = triangle;
        return this;
    }

    /**
     * Where the ray starts.
     *
     * @return three numbers
     */
    public float[] origin() {
        return origin.clone();
    }

    /**
     * Where the ray goes.
     *
     * @return three numbers
     */
    public float[] direction() {
        return direction.clone();
    }

    Struct toStruct(Call call) {
        return call.struct(Native.RAY).set("origin", origin).set("direction", direction).set("t_min", tMin).set("t_max", tMax)
            .set("flags", skips ? 1 : 0).set("skip_mesh", skipMesh).set("skip_triangle", skipTriangle);
    }
}
