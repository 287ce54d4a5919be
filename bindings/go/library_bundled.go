// SPDX-License-Identifier: MIT

//go:build !mlrt_system

package mlrt

// The library is mlrt.c beside this file. 32-bit x86 needs SSE2, for floats that are floats.

// #cgo CFLAGS: -std=gnu99 -O2 -DNDEBUG
// #cgo 386 CFLAGS: -msse2 -mfpmath=sse
// #cgo !windows LDFLAGS: -lm -pthread
import "C"
