// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.MemorySegment;

/**
 * A camera. Pixel (i, j) has the vector p = d00 + (i + sampleX) dx + (j + sampleY) dy. The ray of a pinhole camera has the
 * origin eye and the direction p, that of a parallel one the origin p and one direction for all.
 */
public final class Camera {
    private final boolean parallel;
    private final int width;
    private final int height;
    private final float[] eyeOrDirection;
    private final float[] d00;
    private final float[] dx;
    private final float[] dy;
    private int cropX;
    private int cropY;
    private int cropWidth;
    private int cropHeight;
    private float sampleX = 0.5f;
    private float sampleY = 0.5f;
    private float tMin;
    private float tMax;

    private Camera(boolean parallel, int width, int height, float[] eyeOrDirection, float[] d00, float[] dx, float[] dy) {
        this.parallel = parallel;
        this.width = MlrtException.notNegative("camera.width", width);
        this.height = MlrtException.notNegative("camera.height", height);
        this.eyeOrDirection = eyeOrDirection.clone();
        this.d00 = d00.clone();
        this.dx = dx.clone();
        this.dy = dy.clone();
    }

    /**
     * Rays from one point.
     *
     * @param width columns of the whole picture
     * @param height rows of the whole picture
     * @param eye where the rays start
     * @param d00 p of x = 0, y = 0
     * @param dx from p of one pixel to that of the next in a row
     * @param dy from p of one row to that of the next
     * @return the camera
     */
    public static Camera pinhole(int width, int height, float[] eye, float[] d00, float[] dx, float[] dy) {
        return new Camera(false, width, height, eye, d00, dx, dy);
    }

    /**
     * Rays in one direction.
     *
     * @param width columns of the whole picture
     * @param height rows of the whole picture
     * @param direction where the rays go
     * @param d00 p of x = 0, y = 0
     * @param dx from p of one pixel to that of the next in a row
     * @param dy from p of one row to that of the next
     * @return the camera
     */
    public static Camera parallel(int width, int height, float[] direction, float[] d00, float[] dx, float[] dy) {
        return new Camera(true, width, height, direction, d00, dx, dy);
    }

    private static double[] unit(double[] vector, String name) {
        double length = Math.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
        if (!(length > 0 && length < Double.POSITIVE_INFINITY))
            throw new IllegalArgumentException(name + ": the vector is zero or not finite");
        return new double[] {vector[0] / length, vector[1] / length, vector[2] / length};
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }

    /**
     * A pinhole camera that looks at a point, in the middle of the picture; rows count downwards.
     *
     * @param eye where the rays start, three numbers
     * @param target the point, three numbers
     * @param up which way is up, three numbers
     * @param fov the height of the picture in degrees
     * @param width columns
     * @param height rows
     * @return the camera
     */
    public static Camera lookAt(float[] eye, float[] target, float[] up, double fov, int width, int height) {
        if (!(fov > 0 && fov < 180)) throw new IllegalArgumentException("fov: between 0 and 180 degrees, not " + fov);
        double[] forward = unit(new double[] {target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]}, "target - eye");
        double[] right = unit(cross(forward, new double[] {up[0], up[1], up[2]}), "up, seen along target - eye");
        double[] upward = cross(right, forward);
        double pixel = 2 * Math.tan(Math.toRadians(fov) / 2) / height;
        float[] d00 = new float[3], dx = new float[3], dy = new float[3];
        for (int k = 0; k < 3; k++) {
            d00[k] = (float) (forward[k] + pixel * (upward[k] * height - right[k] * width) / 2);
            dx[k] = (float) (right[k] * pixel);
            dy[k] = (float) (-upward[k] * pixel);
        }
        return pinhole(width, height, eye, d00, dx, dy);
    }

    /**
     * Only these pixels.
     *
     * @param x the first column
     * @param y the first row
     * @param columns how many columns; 0 = up to the last
     * @param rows how many rows; 0 = up to the last
     * @return this
     */
    public Camera crop(int x, int y, int columns, int rows) {
        cropX = MlrtException.notNegative("camera.crop_x", x);
        cropY = MlrtException.notNegative("camera.crop_y", y);
        cropWidth = MlrtException.notNegative("camera.crop_width", columns);
        cropHeight = MlrtException.notNegative("camera.crop_height", rows);
        return this;
    }

    /**
     * Where in the pixel its ray passes; the middle, (0.5, 0.5), if it is not said.
     *
     * @param x along the row
     * @param y across the rows
     * @return this
     */
    public Camera sample(float x, float y) {
        sampleX = x;
        sampleY = y;
        return this;
    }

    /**
     * The range of t.
     *
     * @param least 0 = hits in front of the origin
     * @param greatest 0 = no limit
     * @return this
     */
    public Camera range(float least, float greatest) {
        tMin = least;
        tMax = greatest;
        return this;
    }

    /**
     * The columns that are rendered.
     *
     * @return how many
     */
    public int columns() {
        return cropWidth > 0 ? cropWidth : Math.max(0, width - cropX);
    }

    /**
     * The rows that are rendered.
     *
     * @return how many
     */
    public int rows() {
        return cropHeight > 0 ? cropHeight : Math.max(0, height - cropY);
    }

    /** How many pixels it renders. If they are too many, throws what the library says, before memory is taken for them. */
    long pixels() {
        long count = (long) columns() * rows();
        if (count <= Integer.MAX_VALUE) return count;
        try (var call = new Call()) {
            call.check((int) Native.CAMERA_RAYS.invokeExact(toStruct(call).memory(), MemorySegment.NULL, MemorySegment.NULL));
            return count;
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    Native.Struct toStruct(Call call) {
        return call.struct(Native.CAMERA).set("projection", parallel ? 1 : 0).set("width", width).set("height", height)
            .set("crop_x", cropX).set("crop_y", cropY).set("crop_width", cropWidth).set("crop_height", cropHeight)
            .set(parallel ? "direction" : "eye", eyeOrDirection).set("d00", d00).set("dx", dx).set("dy", dy)
            .set("sample_x", sampleX).set("sample_y", sampleY).set("t_min", tMin).set("t_max", tMax);
    }
}
