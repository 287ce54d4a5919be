// SPDX-License-Identifier: MIT

package mlrt

// #include "bridge.h"
import "C"

import (
	"math"
	"reflect"
	"runtime"
	"unsafe"
)

// An Element is what arrays can be made of.
type Element interface {
	float32 | uint32 | int32 | uint8 | [2]uint32 | [3]float32 | [3]uint32 | [3]uint16
}

// An Array is read or written by the library where it lies: a slice, a field of a slice of structs, or one element that
// serves all rays. The zero Array is left out.
type Array[T Element] struct {
	data      unsafe.Pointer
	stride    uintptr // bytes
	rowStride uintptr // bytes; 0 = packed
	size      uintptr // bytes from data on
	count     int
	all       bool
}

// Slice returns the array of the elements of a slice.
func Slice[T Element](slice []T) Array[T] {
	var t T
	if len(slice) == 0 {
		return Array[T]{}
	}
	size := unsafe.Sizeof(t)
	return Array[T]{data: unsafe.Pointer(&slice[0]), stride: size, size: size * uintptr(len(slice)), count: len(slice)}
}

// All returns an input array whose one element serves all rays: a common origin, direction, limit and so on.
func All[T Element](value T) Array[T] {
	return Array[T]{data: unsafe.Pointer(&value), all: true}
}

// Field returns the array of a field of structs, of which `field` returns the address:
//
//	mlrt.Field(vertices, func(v *Vertex) *[3]float32 { return &v.Position })
//
// It panics if the structs contain pointers, which C may not see, or if the field does not lie in the struct.
func Field[S any, T Element](structs []S, field func(*S) *T) Array[T] {
	var s S
	var t T
	if hasPointers(reflect.TypeOf(s)) {
		panic("mlrt.Field: the structs contain pointers")
	}
	if len(structs) == 0 {
		return Array[T]{}
	}
	data := unsafe.Pointer(field(&structs[0]))
	offset := uintptr(data) - uintptr(unsafe.Pointer(&structs[0]))
	if offset+unsafe.Sizeof(t) > unsafe.Sizeof(s) || offset > unsafe.Sizeof(s) {
		panic("mlrt.Field: not a field of the struct")
	}
	size := unsafe.Sizeof(s)*uintptr(len(structs)) - offset
	return Array[T]{data: data, stride: unsafe.Sizeof(s), size: size, count: len(structs)}
}

func hasPointers(t reflect.Type) bool {
	switch t.Kind() {
	case reflect.Array:
		return t.Len() > 0 && hasPointers(t.Elem())
	case reflect.Struct:
		for i := 0; i < t.NumField(); i++ {
			if hasPointers(t.Field(i).Type) {
				return true
			}
		}
		return false
	}
	return t.Kind() > reflect.Complex128
}

// Rows returns an array for the results of a picture whose rows begin every `elements` elements.
func (a Array[T]) Rows(elements int) Array[T] {
	a.rowStride = uintptr(elements) * a.stride
	return a
}

// Len returns the number of elements: 1 if one serves all.
func (a Array[T]) Len() int {
	if a.all {
		return 1
	}
	return a.count
}

func (a Array[T]) pin(pinner *runtime.Pinner) unsafe.Pointer {
	if a.data != nil {
		pinner.Pin(a.data)
	}
	return a.data
}

// input is an array of `count` elements of the C interface.
func (a Array[T]) input(pinner *runtime.Pinner, name string, count int) (array C.mlrt_const_array, err error) {
	if a.data != nil && !a.all && a.count != count {
		return array, argumentError("%s: %d elements, where %d are needed", name, a.count, count)
	}
	array.data = a.pin(pinner)
	array.stride = C.size_t(a.stride)
	if a.all {
		array.stride = C.MLRT_STRIDE_ALL
	}
	return array, nil
}

// output is an array for `rows` rows of `columns` results.
func (a Array[T]) output(pinner *runtime.Pinner, name string, columns, rows int) (array C.mlrt_array, err error) {
	if a.data == nil {
		return array, nil
	}
	var t T
	rowStride := a.rowStride
	if rowStride == 0 {
		rowStride = uintptr(columns) * a.stride
	}
	if columns > 0 && rows > 0 {
		needed := uintptr(rows-1)*rowStride + uintptr(columns-1)*a.stride + unsafe.Sizeof(t)
		if a.all || needed > a.size {
			return array, argumentError("%s: too short for %d rows of %d results", name, rows, columns)
		}
	}
	array.data, array.stride, array.row_stride = a.pin(pinner), C.size_t(a.stride), C.size_t(a.rowStride)
	return array, nil
}

// word is a number for the C interface. One that does not fit, of which C would take the low bits, becomes the greatest:
// the library refuses that where it is not a mere hint.
func word(value int) C.uint32_t {
	if value < 0 || uint64(value) > math.MaxUint32 {
		return math.MaxUint32
	}
	return C.uint32_t(value)
}

// first keeps the first error of several.
type first struct{ err error }

func collect[A any](f *first) func(A, error) A {
	return func(array A, err error) A {
		if f.err == nil {
			f.err = err
		}
		return array
	}
}
