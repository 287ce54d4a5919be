// SPDX-License-Identifier: MIT

package mlrt

// #include "bridge.h"
import "C"

import (
	"runtime"
	"runtime/cgo"
	"sync"
	"unsafe"
)

// A Pool is threads that calls share their work with: its own, or goroutines. Calls that share a pool with threads of its
// own wait for each other; calls that share one of goroutines run at once.
type Pool struct {
	mutex    sync.RWMutex // Close waits for calls
	handle   *C.mlrt_pool
	executor cgo.Handle // 0 = none
	threads  int
}

// NewPool makes a pool of `threads` threads at work, the calling one included; 0 = one per processor.
func NewPool(threads int) (*Pool, error) {
	pool := &Pool{}
	if err := check(C.bridge_create_pool(word(threads), &pool.handle)); err != nil {
		return nil, err
	}
	pool.threads = int(C.mlrt_pool_thread_count(pool.handle))
	runtime.SetFinalizer(pool, (*Pool).Close)
	return pool, nil
}

// NewGoroutinePool makes a pool that starts no threads: a call runs at most `jobs` - 1 goroutines at a time, and works
// itself. 0 = one per processor.
func NewGoroutinePool(jobs int) (*Pool, error) {
	return NewExecutorPool(jobs, func(job func()) { go job() })
}

// NewExecutorPool makes a pool whose jobs `execute` runs, at most `jobs` - 1 at a time, on any goroutine, now or later. A
// job that does not begin in time is done by the call that it belongs to, and then does nothing.
func NewExecutorPool(jobs int, execute func(job func())) (*Pool, error) {
	if execute == nil {
		return nil, argumentError("execute: it is nil")
	}
	pool := &Pool{executor: cgo.NewHandle(execute)}
	err := check(C.bridge_create_pool_with_executor(word(jobs), C.uintptr_t(pool.executor), &pool.handle))
	if err != nil {
		pool.executor.Delete()
		return nil, err
	}
	pool.threads = int(C.mlrt_pool_thread_count(pool.handle))
	runtime.SetFinalizer(pool, (*Pool).Close)
	return pool, nil
}

// Threads returns how many threads are at work, the calling one included; of a pool that starts none, how many jobs.
// Also after Close. A nil pool is the calling thread alone: 1.
func (pool *Pool) Threads() int {
	if pool == nil {
		return 1
	}
	return pool.threads
}

// Close frees the pool, after the calls that use it. Again does nothing. In a callback of such a call it is an error.
func (pool *Pool) Close() error {
	if callbackUses(nil, pool) {
		return errOwnCallback
	}
	pool.mutex.Lock()
	defer pool.mutex.Unlock()
	C.mlrt_destroy_pool(pool.handle)
	pool.handle = nil
	if pool.executor != 0 {
		pool.executor.Delete()
		pool.executor = 0
	}
	return nil
}

// use returns the handle, and keeps it open until release is called. A nil pool is that of the calling thread alone.
func (pool *Pool) use() (handle *C.mlrt_pool, release func(), err error) {
	if pool == nil {
		return nil, func() {}, nil
	}
	if !pool.mutex.TryRLock() { // Close waits, or is at work
		return nil, nil, ErrClosed
	}
	if pool.handle == nil {
		pool.mutex.RUnlock()
		return nil, nil, ErrClosed
	}
	if pool.executor == 0 && callbackUses(nil, pool) {
		pool.mutex.RUnlock()
		return nil, nil, argumentError("options.Pool: its threads make the call whose callback this is")
	}
	return pool.handle, pool.mutex.RUnlock, nil
}

// A task is run once, by whoever comes first.
type task struct {
	once     sync.Once
	function C.mlrt_task_function
	argument unsafe.Pointer
}

// run returns when the task is done.
func (t *task) run() {
	t.once.Do(func() { C.bridge_run(t.function, t.argument) })
}

//export mlrtGoEnqueue
func mlrtGoEnqueue(user C.uintptr_t, function C.mlrt_task_function, argument unsafe.Pointer) C.uintptr_t {
	execute := cgo.Handle(user).Value().(func(func()))
	t := &task{function: function, argument: argument}
	func() {
		defer func() { _ = recover() }() // mlrtGoFinish does a job that got lost
		execute(t.run)
	}()
	return C.uintptr_t(cgo.NewHandle(t))
}

//export mlrtGoFinish
func mlrtGoFinish(handle C.uintptr_t) {
	h := cgo.Handle(handle)
	h.Value().(*task).run()
	h.Delete()
}
