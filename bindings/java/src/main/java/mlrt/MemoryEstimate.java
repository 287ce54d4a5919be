// SPDX-License-Identifier: MIT
package mlrt;

/**
 * An estimate of the memory that a builder takes.
 *
 * @param memorySize bytes held by the tree
 * @param peakMemorySize most bytes held at one time while building
 */
public record MemoryEstimate(long memorySize, long peakMemorySize) {}
