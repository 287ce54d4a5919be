// SPDX-License-Identifier: MIT

package mlrt

// #include "bridge.h"
import "C"

import (
	"fmt"
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
// serves all rays. The zero Array, and that of an empty slice, is left out; an empty one of triangles has no triangles.
type Array[T Element] struct {
	data   unsafe.Pointer
	stride uintptr // bytes; 0 = the zero Array, or one element for all
	row    int     // elements; 0 = packed
	count  int
	all    bool
}

// Slice returns the array of the elements of a slice.
func Slice[T Element](slice []T) Array[T] {
	var t T
	array := Array[T]{stride: unsafe.Sizeof(t), count: len(slice)}
	if len(slice) > 0 {
		array.data = unsafe.Pointer(&slice[0])
	}
	return array
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
	if hasPointers(reflect.TypeOf(structs).Elem()) {
		panic("mlrt.Field: the structs contain pointers")
	}
	array := Array[T]{stride: unsafe.Sizeof(s), count: len(structs)}
	if len(structs) == 0 {
		return array
	}
	array.data = unsafe.Pointer(field(&structs[0]))
	offset := uintptr(array.data) - uintptr(unsafe.Pointer(&structs[0]))
	if offset+unsafe.Sizeof(t) > unsafe.Sizeof(s) || offset > unsafe.Sizeof(s) {
		panic("mlrt.Field: not a field of the struct")
	}
	return array
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

// Rows returns an array for the results of a picture whose rows begin every `elements` elements; 0 = packed.
func (a Array[T]) Rows(elements int) Array[T] {
	a.row = elements
	return a
}

// Len returns the number of elements: 1 if one serves all.
func (a Array[T]) Len() int {
	if a.all {
		return 1
	}
	return a.count
}

// A place is where the elements of an array lie.
type place struct {
	name                     string
	start, count, step, size int // the address of the first; how many; bytes from one to the next; bytes of each
}

func (a Array[T]) place(name string, count int) place {
	var t T
	p := place{name, int(uintptr(a.data)), count, int(a.stride), int(unsafe.Sizeof(t))}
	if p.step == p.size { // without gaps: like one element
		p.count, p.size = 1, count*p.size
	}
	return p
}

// meets tells whether two arrays have bytes in common. Of different strides with gaps it is not known: then false.
func (p place) meets(q place) bool {
	distance := q.start - p.start
	if p.count == 0 || q.count == 0 || distance >= (p.count-1)*p.step+p.size || -distance >= (q.count-1)*q.step+q.size {
		return false
	}
	if p.count == 1 && q.count == 1 {
		return true
	}
	if p.count > 1 && q.count > 1 && p.step != q.step {
		return false
	}
	step := p.step
	if p.count == 1 {
		step = q.step
	}
	// The first of q's elements, seen from one of p's, that ends behind its begin: does it begin before its end?
	k := -((q.size + distance - 1) / step)
	if q.size+distance < 1 {
		k = (-q.size-distance)/step + 1
	}
	k = max(k, 1-p.count)
	return k < q.count && distance+k*step < p.size
}

// arrays are those of a call: pinned as long as it runs, and checked.
type arrays struct {
	pinner        runtime.Pinner
	read, written []place
	err           error // the first one
}

func (a *arrays) fail(err error) {
	if a.err == nil {
		a.err = err
	}
}

// pin returns the address of an array, which stays until Unpin.
func pin[T Element](pinner *runtime.Pinner, array Array[T]) unsafe.Pointer {
	if array.data != nil {
		pinner.Pin(array.data)
	}
	return array.data
}

// input is an array of `count` elements of the C interface.
func input[T Element](a *arrays, name string, array Array[T], count int) (out C.mlrt_const_array) {
	switch {
	case array.data == nil:
		return out
	case array.all:
		out.stride = C.MLRT_STRIDE_ALL
	case array.count != count:
		a.fail(argumentError("%s: %d elements, where %d are needed", name, array.count, count))
		return out
	default:
		out.stride = C.size_t(array.stride)
		a.read = append(a.read, array.place(name, count))
	}
	out.data = pin(&a.pinner, array)
	return out
}

// output is an array for `rows` rows of `columns` results.
func output[T Element](a *arrays, name string, array Array[T], columns, rows int) (out C.mlrt_array) {
	if array.data == nil {
		return out
	}
	row := array.row
	if row == 0 {
		row = columns
	}
	switch {
	case array.all:
		a.fail(argumentError("%s: one element for all is no array for results", name))
	case rows > 1 && row < columns:
		a.fail(argumentError("%s: rows that begin every %d elements overlap, as they have %d", name, row, columns))
	case columns > array.count || rows > 1 && columns > 0 && rows-1 > (array.count-columns)/row:
		a.fail(argumentError("%s: too short for %d rows of %d results", name, rows, columns))
	}
	if a.err != nil {
		return out
	}
	if row == columns || rows < 2 {
		a.written = append(a.written, array.place(name, columns*rows))
	} else if line := array.place(name, columns); line.count == 1 { // rows with gaps between them, but none within
		line.count, line.step = rows, row*int(array.stride)
		a.written = append(a.written, line)
	}
	out.data, out.stride = pin(&a.pinner, array), C.size_t(array.stride)
	if rows > 1 && array.row != 0 {
		out.row_stride = C.size_t(row) * out.stride
	}
	return out
}

// check returns the first error of the arrays, or one if results have bytes in common with each other or with what is read.
func (a *arrays) check() error {
	for i, p := range a.written {
		for _, list := range [2][]place{a.written[i+1:], a.read} {
			for _, q := range list {
				if p.meets(q) {
					a.fail(argumentError("%s: it shares memory with %s", p.name, q.name))
				}
			}
		}
	}
	return a.err
}

// checkCount refuses what the library does, before memory is taken for it.
func checkCount(name string, count int) error {
	if count > math.MaxInt32 {
		return &Error{Status: TooLarge, Message: fmt.Sprintf("%s: %d is more than %d", name, count, math.MaxInt32)}
	}
	return nil
}

// checkMemory fails where the system has no memory for `count` results of `size` bytes each: Go would end the program.
func checkMemory(count, size int) error {
	const enough = 1 << 28
	if count <= enough/size || count <= math.MaxInt/size && C.bridge_has_memory(C.size_t(count)*C.size_t(size)) != 0 {
		return nil
	}
	return &Error{Status: OutOfMemory, Message: fmt.Sprintf("%d results of %d bytes each", count, size)}
}

// word is a number for the C interface. One that does not fit, of which C would take the low bits, becomes the greatest:
// the library refuses that where it is not a mere hint.
func word(value int) C.uint32_t {
	if value < 0 || uint64(value) > math.MaxUint32 {
		return math.MaxUint32
	}
	return C.uint32_t(value)
}

// code is one of the C interface's named numbers. One that does not fit becomes one that the library refuses.
func code[T ~int](value T) C.int32_t {
	if int64(value) != int64(int32(value)) {
		return math.MinInt32
	}
	return C.int32_t(value)
}
