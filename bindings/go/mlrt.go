// SPDX-License-Identifier: MIT

// Package mlrt says where rays hit triangles: the exact answers of libmlrt, for slices.
//
//	tree, err := mlrt.NewTree(mlrt.Mesh{Vertices: vertices, Triangles: triangles})
//	defer tree.Close()
//	hits, err := tree.Trace(origins, directions, nil)
//
// Slices go in and come out without a copy: the call pins them. Trees and pools are freed by Close, or else some time
// after the last use; all methods may be called from any number of goroutines. pkg-config must know libmlrt.
package mlrt

// #cgo pkg-config: mlrt
// #include <mlrt.h>
import "C"

import (
	"errors"
	"fmt"
	"runtime"
	"sync"
	"unsafe"
)

// None is the mesh and the triangle of a miss.
const None = uint32(C.MLRT_NONE)

// Status codes of an Error.
const (
	ErrorArgument   = int32(C.MLRT_ERROR_ARGUMENT)
	ErrorIndexRange = int32(C.MLRT_ERROR_INDEX_RANGE)
)

// ErrClosed is what a closed Tree or Pool answers.
var ErrClosed = errors.New("mlrt: used after Close")

// An Error is what the library says went wrong.
type Error struct {
	Status  int32  // MLRT_ERROR_*
	Details string // more than the status says, or empty
}

func (e *Error) Error() string {
	text := "mlrt: " + C.GoString(C.mlrt_status_string(C.int32_t(e.Status)))
	if e.Details != "" {
		text += ": " + e.Details
	}
	return text
}

// A Pool is threads that calls share their work with. Calls that share a Pool wait for each other.
type Pool struct {
	mutex  sync.RWMutex // Close waits for calls
	handle *C.mlrt_pool
}

// NewPool makes a pool of `threads` threads at work, the calling one included; 0 = one per processor.
func NewPool(threads uint32) (*Pool, error) {
	pool := &Pool{}
	if status := C.mlrt_create_pool(C.uint32_t(threads), &pool.handle); status != C.MLRT_OK {
		return nil, &Error{Status: int32(status)}
	}
	runtime.SetFinalizer(pool, (*Pool).Close)
	return pool, nil
}

// Close frees the pool, after the calls that use it. Again does nothing.
func (pool *Pool) Close() error {
	pool.mutex.Lock()
	defer pool.mutex.Unlock()
	C.mlrt_destroy_pool(pool.handle)
	pool.handle = nil
	return nil
}

// A Mesh is an indexed mesh. If all IDs are 0, they become 0, 1, 2, ...
type Mesh struct {
	ID        uint32
	Vertices  [][3]float32
	Triangles [][3]uint32
}

// Hits are the closest hits, an element per ray. A miss has an infinite T, and Mesh and Triangle None.
type Hits struct {
	T, U, V        []float32
	Mesh, Triangle []uint32
	Facing         []int32
}

// A Tree is triangles, and what finds them. It never changes.
type Tree struct {
	mutex  sync.RWMutex // Close waits for calls
	handle *C.mlrt_tree
}

// pin keeps a slice where it is until pinner.Unpin, and returns its address: nil if it is empty.
func pin[T any](pinner *runtime.Pinner, slice []T) unsafe.Pointer {
	if len(slice) == 0 {
		return nil
	}
	pinner.Pin(&slice[0])
	return unsafe.Pointer(&slice[0])
}

// NewTree builds a tree over meshes, which may change afterwards: mlrt_build_tree.
func NewTree(meshes ...Mesh) (*Tree, error) {
	var pinner runtime.Pinner
	defer pinner.Unpin()
	list := make([]C.mlrt_mesh, len(meshes))
	for i, mesh := range meshes {
		list[i] = C.mlrt_mesh{
			struct_size:    C.sizeof_mlrt_mesh,
			id:             C.uint32_t(mesh.ID),
			vertices:       pin(&pinner, mesh.Vertices),
			vertex_count:   C.size_t(len(mesh.Vertices)),
			indices:        pin(&pinner, mesh.Triangles),
			triangle_count: C.size_t(len(mesh.Triangles)),
		}
	}
	message := make([]C.char, 256)
	options := C.mlrt_tree_options{
		struct_size:  C.sizeof_mlrt_tree_options,
		message:      (*C.char)(pin(&pinner, message)),
		message_size: C.size_t(len(message)),
	}
	tree := &Tree{}
	status := C.mlrt_build_tree((*C.mlrt_mesh)(pin(&pinner, list)), C.size_t(len(list)), &options, &tree.handle)
	if status != C.MLRT_OK {
		return nil, &Error{Status: int32(status), Details: C.GoString(&message[0])}
	}
	runtime.SetFinalizer(tree, (*Tree).Close)
	return tree, nil
}

// Close frees the tree, after the calls that use it. Again does nothing.
func (tree *Tree) Close() error {
	tree.mutex.Lock()
	defer tree.mutex.Unlock()
	C.mlrt_destroy_tree(tree.handle)
	tree.handle = nil
	return nil
}

// Trace finds the closest hit of each ray. The pool may be nil.
func (tree *Tree) Trace(origins, directions [][3]float32, pool *Pool) (*Hits, error) {
	n := len(origins)
	hits := &Hits{
		T: make([]float32, n), U: make([]float32, n), V: make([]float32, n),
		Mesh: make([]uint32, n), Triangle: make([]uint32, n), Facing: make([]int32, n),
	}
	var pinner runtime.Pinner
	defer pinner.Unpin()
	out := C.mlrt_hits{struct_size: C.sizeof_mlrt_hits}
	out.t.data, out.u.data, out.v.data = pin(&pinner, hits.T), pin(&pinner, hits.U), pin(&pinner, hits.V)
	out.mesh.data, out.triangle.data = pin(&pinner, hits.Mesh), pin(&pinner, hits.Triangle)
	out.facing.data = pin(&pinner, hits.Facing)
	if err := tree.call(origins, directions, C.MLRT_QUERY_CLOSEST, pool, &out); err != nil {
		return nil, err
	}
	return hits, nil
}

// Occluded says whether each ray hits anything at all. The pool may be nil.
func (tree *Tree) Occluded(origins, directions [][3]float32, pool *Pool) ([]bool, error) {
	occluded := make([]bool, len(origins)) // the library writes bytes 0 and 1
	var pinner runtime.Pinner
	defer pinner.Unpin()
	out := C.mlrt_hits{struct_size: C.sizeof_mlrt_hits}
	out.occluded.data = pin(&pinner, occluded)
	if err := tree.call(origins, directions, C.MLRT_QUERY_ANY, pool, &out); err != nil {
		return nil, err
	}
	return occluded, nil
}

// call traces into out, whose arrays have an element for each origin and are pinned.
func (tree *Tree) call(origins, directions [][3]float32, query C.int32_t, pool *Pool, out *C.mlrt_hits) error {
	if len(origins) != len(directions) {
		details := fmt.Sprintf("%d origins, %d directions", len(origins), len(directions))
		return &Error{Status: ErrorArgument, Details: details}
	}
	tree.mutex.RLock()
	defer tree.mutex.RUnlock()
	if tree.handle == nil {
		return ErrClosed
	}
	options := C.mlrt_trace_options{struct_size: C.sizeof_mlrt_trace_options, query: query}
	if pool != nil {
		pool.mutex.RLock()
		defer pool.mutex.RUnlock()
		if pool.handle == nil {
			return ErrClosed
		}
		options.pool = pool.handle
	}
	if len(origins) == 0 {
		return nil
	}
	var pinner runtime.Pinner
	defer pinner.Unpin()
	rays := C.mlrt_rays{struct_size: C.sizeof_mlrt_rays, count: C.size_t(len(origins))}
	rays.origins.data, rays.directions.data = pin(&pinner, origins), pin(&pinner, directions)
	if status := C.mlrt_trace_packet(tree.handle, &rays, &options, out); status != C.MLRT_OK {
		return &Error{Status: int32(status)}
	}
	return nil
}
