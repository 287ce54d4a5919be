// SPDX-License-Identifier: MIT

// Package mlrt finds where rays hit triangles: exactly, fast, and with the same bits on every machine.
//
//	tree, err := mlrt.Build(ctx, []mlrt.Mesh{mlrt.NewMesh(vertices, triangles)}, nil)
//	defer tree.Close()
//	hits, err := tree.Trace(ctx, mlrt.NewRays(origins, directions), nil)
//
// Slices go in and come out without a copy: each call pins them. Trees and pools are freed by Close, or else some time
// after their last use; any goroutine may call any method. Calls that take a context end within milliseconds when it is
// cancelled. Options may be nil, and their zero values are the defaults.
//
// The package compiles the C library, and needs gcc or clang for that. With the build tag mlrt_system it links an
// installed one, which pkg-config must know.
package mlrt

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"errors"
	"fmt"
	"unsafe"
)

// None is the mesh and the triangle of a miss; in an array of triangles to skip it means none.
const None = uint32(C.MLRT_NONE)

// A Status says what kind of error occurred: errors.Is(err, mlrt.OutOfMemory).
type Status int32

// What can go wrong.
const (
	Argument     = Status(C.MLRT_ERROR_ARGUMENT)      // a value is out of its range, or counts do not fit each other
	StructSize   = Status(C.MLRT_ERROR_STRUCT_SIZE)   // the library is older than this package
	IndexRange   = Status(C.MLRT_ERROR_INDEX_RANGE)   // a triangle names a vertex that does not exist
	OutOfMemory  = Status(C.MLRT_ERROR_OUT_OF_MEMORY) // an allocation failed, or a MemoryLimit was reached
	TooLarge     = Status(C.MLRT_ERROR_TOO_LARGE)     // more triangles, rays or pixels than 32-bit counts allow
	BadCamera    = Status(C.MLRT_ERROR_CAMERA)        // a camera of size zero, a crop outside of it, and the like
	Unsupported  = Status(C.MLRT_ERROR_UNSUPPORTED)   // an instruction set or a method that cannot be used here
	ThreadFailed = Status(C.MLRT_ERROR_THREAD)        // the system would not start a thread
	Cancelled    = Status(C.MLRT_ERROR_CANCELLED)     // a context was cancelled, or a callback asked to stop
	BadData      = Status(C.MLRT_ERROR_DATA)          // no saved tree, or a damaged one, or one of other triangles
)

// Error returns what the status means.
func (s Status) Error() string {
	return "mlrt: " + C.GoString(C.mlrt_status_string(C.int32_t(s)))
}

// An Error is a failed call. It unwraps to its Status and, if a context or a callback ended the call, to their error.
type Error struct {
	Status  Status
	Message string // which argument, which value, which rule
	Cause   error  // the error of the context or of the callback, or nil
}

func (e *Error) Error() string {
	text := e.Status.Error()
	if e.Message != "" && "mlrt: "+e.Message != text {
		text += ": " + e.Message
	}
	if e.Cause != nil {
		text += ": " + e.Cause.Error()
	}
	return text
}

// Unwrap returns the status and the cause.
func (e *Error) Unwrap() []error {
	if e.Cause == nil {
		return []error{e.Status}
	}
	return []error{e.Status, e.Cause}
}

// ErrClosed is the answer of a closed Tree or Pool.
var ErrClosed = errors.New("mlrt: used after Close")

var errOwnCallback = argumentError("Close: a call that uses it waits for this callback")

func argumentError(format string, values ...any) error {
	return &Error{Status: Argument, Message: fmt.Sprintf(format, values...)}
}

// check returns the error of a call.
func check(outcome C.bridge_outcome) error {
	if outcome.status == C.MLRT_OK {
		return nil
	}
	e := &Error{Status: Status(outcome.status), Message: C.GoString(outcome.message)}
	C.free(unsafe.Pointer(outcome.message))
	return e
}

// Version returns the version of the library.
func Version() (major, minor, patch int) {
	version := int(C.mlrt_version())
	return version / 10000, version / 100 % 100, version % 100
}

// CanUse tells whether the library can use an instruction set on this machine.
func CanUse(isa ISA) bool {
	capabilities := C.mlrt_capabilities()
	switch isa {
	case Scalar:
		return capabilities&(C.MLRT_CAN_SSE|C.MLRT_CAN_NEON) == 0
	case SSE:
		return capabilities&C.MLRT_CAN_SSE != 0
	case AVX2:
		return capabilities&C.MLRT_CAN_AVX2 != 0
	case AVX512:
		return capabilities&C.MLRT_CAN_AVX512 != 0
	case NEON:
		return capabilities&C.MLRT_CAN_NEON != 0
	}
	return true
}

// checkSizes compares the structs that this package was compiled with to those of the library.
func checkSizes() error {
	sizes := make([]C.uint32_t, C.MLRT_STRUCT_COUNT)
	C.mlrt_struct_sizes(&sizes[0], C.MLRT_STRUCT_COUNT)
	if sizes[C.MLRT_STRUCT_TRACE_OPTIONS] < C.sizeof_mlrt_trace_options {
		return StructSize
	}
	return nil
}
