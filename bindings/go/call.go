// SPDX-License-Identifier: MIT

package mlrt

// #include "bridge.h"
import "C"

import (
	"context"
	"runtime/cgo"
	"sync"
	"unsafe"
)

// A Level is the kind of a message.
type Level int

// Kinds of messages.
const (
	LogError   = Level(C.MLRT_LOG_ERROR)   // the reason why a call fails
	LogWarning = Level(C.MLRT_LOG_WARNING) // something was left out
	LogInfo    = Level(C.MLRT_LOG_INFO)    // a tree was built, its size and time; or the host stopped a call
)

// A Host receives messages and progress of a call. Its functions, and those that receive tiles, must not end their goroutine
// (runtime.Goexit, and so FailNow of testing).
type Host struct {
	Log      func(level Level, message string) // on the goroutine of the call
	Progress func(fraction float64)            // the part that is done, 0..1, every few milliseconds, one call at a time
}

// A call is what callbacks find by their handle. A panic of Progress or of a tile's callback ends the call; that, and one of
// Log, goes on when the call has ended.
type call struct {
	tree     *Tree // or nil, as is the pool
	pool     *Pool
	outer    *call // within whose callback it is made, or nil
	ctx      context.Context
	host     Host
	tile     func(*Tile) error
	mutex    sync.Mutex
	err      error
	panicked any
}

// callbackUses tells whether this goroutine runs a callback of a call, or of one in whose callback that is made, which uses
// the tree or the pool: to wait for its end would never end.
func callbackUses(tree *Tree, pool *Pool) bool {
	for c := currentCall(); c != nil; c = c.outer {
		if tree != nil && c.tree == tree || pool != nil && c.pool == pool {
			return true
		}
	}
	return false
}

// currentCall is the call whose callback this goroutine runs, or nil. Goroutines in callbacks stay on their threads.
func currentCall() *call {
	if handle := C.bridge_current_call(); handle != 0 {
		return cgo.Handle(handle).Value().(*call)
	}
	return nil
}

// guard runs a callback; false: the call must end.
func (c *call) guard(callback func() error) (goOn bool) {
	fail := func(err error, panicked any) {
		c.mutex.Lock()
		defer c.mutex.Unlock()
		if c.err == nil {
			c.err = err
		}
		if c.panicked == nil {
			c.panicked = panicked
		}
	}
	returned := false
	defer func() {
		if panicked := recover(); panicked != nil {
			fail(nil, panicked)
			goOn = false
		} else if !returned {
			// It would leave the library in the middle of the call, whose threads go on.
			go panic("mlrt: a callback called runtime.Goexit, as FailNow and Fatal of testing do")
			select {}
		}
	}()
	err := callback()
	returned = true
	if err != nil {
		fail(err, nil)
		return false
	}
	return true
}

// run makes a call of the library that uses a tree and a pool, with the host and the context if they have anything to do.
func run(ctx context.Context, tree *Tree, pool *Pool, host Host, tile func(*Tile) error,
	function func(C.bridge_host, C.uintptr_t) C.bridge_outcome) error {
	if err := ctx.Err(); err != nil {
		return &Error{Status: Cancelled, Cause: err}
	}
	var bridge C.bridge_host
	if host.Log != nil {
		bridge.functions |= C.BRIDGE_LOG
	}
	if host.Progress != nil || ctx.Done() != nil {
		bridge.functions |= C.BRIDGE_PROGRESS
	}
	if bridge.functions == 0 && tile == nil {
		return check(function(bridge, 0))
	}
	c := &call{tree: tree, pool: pool, outer: currentCall(), ctx: ctx, host: host, tile: tile}
	handle := cgo.NewHandle(c)
	defer handle.Delete()
	bridge.call = C.uintptr_t(handle)
	user := C.uintptr_t(0)
	if tile != nil {
		user = C.uintptr_t(handle)
	}
	err := check(function(bridge, user))
	if c.panicked != nil {
		panic(c.panicked)
	}
	if e, failed := err.(*Error); failed && e.Status == Cancelled {
		e.Cause = c.err
	}
	return err
}

//export mlrtGoLog
func mlrtGoLog(user C.uintptr_t, level C.int32_t, message *C.char) {
	c := cgo.Handle(user).Value().(*call)
	c.guard(func() error {
		c.host.Log(Level(level), C.GoString(message))
		return nil
	})
}

//export mlrtGoProgress
func mlrtGoProgress(user C.uintptr_t, fraction C.double) C.int32_t {
	c := cgo.Handle(user).Value().(*call)
	goOn := c.guard(func() error {
		if c.host.Progress != nil {
			c.host.Progress(float64(fraction))
		}
		return c.ctx.Err()
	})
	if goOn {
		return 0
	}
	return 1
}

//export mlrtGoTile
func mlrtGoTile(user C.uintptr_t, from *C.mlrt_tile) C.int32_t {
	c := cgo.Handle(user).Value().(*call)
	if c.guard(func() error { return c.tile(newTile(from)) }) {
		return 0
	}
	return 1
}

// A Tile has the results of a finished tile of a picture: those of pixel (X + i, Y + j) are element j * Width + i. They are
// valid until the callback returns. Slices that the options' Outputs do not name are nil.
type Tile struct {
	Worker           int // calls that run at the same time have different ones, from 0
	X, Y             int // its first pixel, in the whole picture
	Width, Height    int
	T, U, V          []float32
	MeshID, Triangle []uint32
	Facing           []int32
	Occluded         []uint8 // as in HitArrays
}

func tileSlice[T, From any](from *From, n int) []T {
	return unsafe.Slice((*T)(unsafe.Pointer(from)), n)[:n:n]
}

func newTile(from *C.mlrt_tile) *Tile {
	tile := &Tile{
		Worker: int(from.worker), X: int(from.x), Y: int(from.y), Width: int(from.width), Height: int(from.height),
	}
	n := tile.Width * tile.Height
	if from.t != nil {
		tile.T = tileSlice[float32](from.t, n)
	}
	if from.u != nil {
		tile.U, tile.V = tileSlice[float32](from.u, n), tileSlice[float32](from.v, n)
	}
	if from.mesh != nil {
		tile.MeshID = tileSlice[uint32](from.mesh, n)
	}
	if from.triangle != nil {
		tile.Triangle = tileSlice[uint32](from.triangle, n)
	}
	if from.facing != nil {
		tile.Facing = tileSlice[int32](from.facing, n)
	}
	if from.occluded != nil {
		tile.Occluded = tileSlice[uint8](from.occluded, n)
	}
	return tile
}
