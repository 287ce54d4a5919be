// SPDX-License-Identifier: MIT

package mlrt

// #include "bridge.h"
import "C"

import (
	"context"
	"runtime"
	"sync"
	"unsafe"
)

// A Tree is triangles, and the structure that finds them. It never changes, and any number of goroutines may trace it.
type Tree struct {
	mutex  sync.RWMutex // Close waits for calls
	handle *C.mlrt_tree
	bytes  runtime.Pinner // those that a tree loaded in place uses
}

// newTree returns a tree without a handle. A panic of a callback leaves it to its finalizer.
func newTree() *Tree {
	tree := &Tree{}
	runtime.SetFinalizer(tree, (*Tree).Close)
	return tree
}

// made returns what a builder has made, or its error.
func (tree *Tree) made(err error) (*Tree, error) {
	if err != nil {
		tree.bytes.Unpin()
		return nil, err
	}
	return tree, nil
}

// options in C that every builder has, too.
func (o *TreeOptions) toC(pool *C.mlrt_pool) *C.mlrt_tree_options {
	return &C.mlrt_tree_options{
		struct_size:       C.sizeof_mlrt_tree_options,
		preset:            code(o.Preset),
		traversal_cost:    C.float(o.TraversalCost),
		intersection_cost: C.float(o.IntersectionCost),
		memory_limit:      C.uint64_t(o.MemoryLimit),
		pool:              pool,
	}
}

func (o *KdTreeOptions) toC(pool *C.mlrt_pool) *C.mlrt_kdtree_options {
	return &C.mlrt_kdtree_options{
		struct_size:       C.sizeof_mlrt_kdtree_options,
		preset:            code(o.Preset),
		traversal_cost:    C.float(o.TraversalCost),
		intersection_cost: C.float(o.IntersectionCost),
		memory_limit:      C.uint64_t(o.MemoryLimit),
		max_references:    C.uint64_t(o.MaxReferences),
		max_depth:         word(o.MaxDepth),
		rules_off:         C.uint32_t(o.RulesOff),
		pool:              pool,
	}
}

// Build builds a hierarchy of boxes: the best tree that the library has. Triangles that can never be hit are left out, and
// counted in its Info. The same input always gives the same tree.
func Build(ctx context.Context, list []Mesh, options *TreeOptions) (*Tree, error) {
	if err := checkSizes(); err != nil {
		return nil, err
	}
	if options == nil {
		options = &TreeOptions{}
	}
	pool, release, err := options.Pool.use()
	if err != nil {
		return nil, err
	}
	defer release()
	var pinner runtime.Pinner
	defer pinner.Unpin()
	tree, o := newTree(), options.toC(pool)
	first, count, err := meshes(&pinner, list)
	if err != nil {
		return nil, err
	}
	return tree.made(run(ctx, nil, options.Pool, options.Host, nil, func(host C.bridge_host, _ C.uintptr_t) C.bridge_outcome {
		return C.bridge_build_tree(first, count, o, host, &tree.handle)
	}))
}

// BuildKdTree builds the paper's kd-tree, which is slower to build and to trace: for study.
func BuildKdTree(ctx context.Context, list []Mesh, options *KdTreeOptions) (*Tree, error) {
	if options == nil {
		options = &KdTreeOptions{}
	}
	pool, release, err := options.Pool.use()
	if err != nil {
		return nil, err
	}
	defer release()
	var pinner runtime.Pinner
	defer pinner.Unpin()
	tree, o := newTree(), options.toC(pool)
	first, count, err := meshes(&pinner, list)
	if err != nil {
		return nil, err
	}
	return tree.made(run(ctx, nil, options.Pool, options.Host, nil, func(host C.bridge_host, _ C.uintptr_t) C.bridge_outcome {
		return C.bridge_build_kdtree(first, count, o, host, &tree.handle)
	}))
}

// A MemoryEstimate is that of a builder, in bytes.
type MemoryEstimate struct {
	MemorySize     uint64 // held by the tree
	PeakMemorySize uint64 // held at one time while building
}

// EstimateTree estimates the memory of Build from the numbers of triangles alone.
func EstimateTree(list []Mesh, options *TreeOptions) (MemoryEstimate, error) {
	if options == nil {
		options = &TreeOptions{}
	}
	var pinner runtime.Pinner
	defer pinner.Unpin()
	first, count, err := meshes(&pinner, list)
	if err != nil {
		return MemoryEstimate{}, err
	}
	estimate := C.mlrt_memory_estimate{struct_size: C.sizeof_mlrt_memory_estimate}
	err = check(C.bridge_estimate_tree(first, count, options.toC(nil), &estimate))
	return MemoryEstimate{uint64(estimate.memory_size), uint64(estimate.peak_memory_size)}, err
}

// EstimateKdTree estimates the memory of BuildKdTree: a guess, which can be off by a factor of two.
func EstimateKdTree(list []Mesh, options *KdTreeOptions) (MemoryEstimate, error) {
	if options == nil {
		options = &KdTreeOptions{}
	}
	var pinner runtime.Pinner
	defer pinner.Unpin()
	first, count, err := meshes(&pinner, list)
	if err != nil {
		return MemoryEstimate{}, err
	}
	estimate := C.mlrt_memory_estimate{struct_size: C.sizeof_mlrt_memory_estimate}
	err = check(C.bridge_estimate_kdtree(first, count, options.toC(nil), &estimate))
	return MemoryEstimate{uint64(estimate.memory_size), uint64(estimate.peak_memory_size)}, err
}

// HashGeometry returns a hash of the ids, masks and corners of meshes, for LoadOptions.
func HashGeometry(list []Mesh) (uint64, error) {
	var pinner runtime.Pinner
	defer pinner.Unpin()
	first, count, err := meshes(&pinner, list)
	if err != nil {
		return 0, err
	}
	var hash C.uint64_t
	err = check(C.bridge_hash_geometry(first, count, &hash))
	return uint64(hash), err
}

// Load makes a tree from a copy of the bytes that Save wrote.
func Load(bytes []byte, options *LoadOptions) (*Tree, error) {
	return load(bytes, 0, options)
}

// LoadInPlace makes a tree that uses the bytes where they lie, and takes next to no memory of its own: those of a file that
// is mapped into memory, for example. They must stay as they are until Close. Bytes that do not begin at a multiple of 64
// are copied.
func LoadInPlace(bytes []byte, options *LoadOptions) (*Tree, error) {
	return load(bytes, C.MLRT_LOAD_IN_PLACE, options)
}

func load(bytes []byte, flags C.uint32_t, options *LoadOptions) (*Tree, error) {
	if options == nil {
		options = &LoadOptions{}
	}
	tree := newTree()
	o := &C.mlrt_load_options{
		struct_size:   C.sizeof_mlrt_load_options,
		flags:         flags,
		geometry_hash: C.uint64_t(options.GeometryHash),
		memory_limit:  C.uint64_t(options.MemoryLimit),
	}
	data := pin(&tree.bytes, Slice(bytes))
	tree, err := tree.made(run(context.Background(), nil, nil, Host{Log: options.Log}, nil,
		func(host C.bridge_host, _ C.uintptr_t) C.bridge_outcome {
			return C.bridge_load_tree(data, C.size_t(len(bytes)), o, host, &tree.handle)
		}))
	if err == nil && flags == 0 {
		tree.bytes.Unpin()
	}
	return tree, err
}

// Close frees the tree, after the calls that use it. Again does nothing. In a callback of such a call it is an error.
func (tree *Tree) Close() error {
	if callbackUses(tree, nil) {
		return errOwnCallback
	}
	tree.mutex.Lock()
	defer tree.mutex.Unlock()
	C.mlrt_destroy_tree(tree.handle)
	tree.handle = nil
	tree.bytes.Unpin()
	return nil
}

// use keeps the tree open until release is called.
func (tree *Tree) use() (handle *C.mlrt_tree, release func(), err error) {
	if !tree.mutex.TryRLock() { // Close waits, or is at work
		return nil, nil, ErrClosed
	}
	if tree.handle == nil {
		tree.mutex.RUnlock()
		return nil, nil, ErrClosed
	}
	return tree.handle, tree.mutex.RUnlock, nil
}

// A Structure is that of a tree.
type Structure int

// Structures.
const (
	KdTree = Structure(C.MLRT_STRUCTURE_KDTREE) // by BuildKdTree
	Boxes  = Structure(C.MLRT_STRUCTURE_BVH)    // by Build
)

// TreeInfo is the build report of a tree: mlrt_tree_info of mlrt.h has what each number means.
type TreeInfo struct {
	Structure                      Structure
	Depth                          int
	Triangles, NonFinite, ZeroArea uint64 // as given; left out as a vertex is not finite, or the area is 0
	Nodes, Leaves, EmptyLeaves     uint64
	References, Retracted          uint64
	MemorySize, PeakMemorySize     uint64 // bytes
	TreeHash                       uint64 // equal trees have equal hashes
	SAHCost, BuildSeconds          float64
	BoundsMin, BoundsMax           [3]float32
}

// Info returns the build report.
func (tree *Tree) Info() (info TreeInfo, err error) {
	handle, release, err := tree.use()
	if err != nil {
		return info, err
	}
	defer release()
	c := C.mlrt_tree_info{struct_size: C.sizeof_mlrt_tree_info}
	if err := check(C.bridge_get_tree_info(handle, &c)); err != nil {
		return info, err
	}
	return TreeInfo{
		Structure: Structure(c.structure), Depth: int(c.depth),
		Triangles: uint64(c.triangle_count), NonFinite: uint64(c.non_finite_count), ZeroArea: uint64(c.zero_area_count),
		Nodes: uint64(c.node_count), Leaves: uint64(c.leaf_count), EmptyLeaves: uint64(c.empty_leaf_count),
		References: uint64(c.reference_count), Retracted: uint64(c.retracted_count),
		MemorySize: uint64(c.memory_size), PeakMemorySize: uint64(c.peak_memory_size), TreeHash: uint64(c.tree_hash),
		SAHCost: float64(c.sah_cost), BuildSeconds: float64(c.build_seconds),
		BoundsMin: floats(c.bounds_min), BoundsMax: floats(c.bounds_max),
	}, nil
}

// Save returns the tree as bytes, with its triangles.
func (tree *Tree) Save() ([]byte, error) {
	handle, release, err := tree.use()
	if err != nil {
		return nil, err
	}
	defer release()
	var size C.size_t
	if err := check(C.bridge_save_tree(handle, nil, 0, &size)); err != nil {
		return nil, err
	}
	bytes := make([]byte, size)
	return bytes, check(C.bridge_save_tree(handle, unsafe.Pointer(&bytes[0]), size, &size))
}

// with makes a call that traces, with the tree and the options.
func (tree *Tree) with(ctx context.Context, options *TraceOptions, query Query, pinner *runtime.Pinner, tile func(*Tile) error,
	function func(*C.mlrt_tree, *C.mlrt_trace_options, C.bridge_host, C.uintptr_t) C.bridge_outcome) error {
	handle, release, err := tree.use()
	if err != nil {
		return err
	}
	defer release()
	o := &C.mlrt_trace_options{struct_size: C.sizeof_mlrt_trace_options, query: code(query)}
	var host Host
	var pool *Pool
	if options != nil {
		host, pool = options.Host, options.Pool
		used, release, err := pool.use()
		if err != nil {
			return err
		}
		defer release()
		o.method, o.isa, o.culling = code(options.Method), code(options.ISA), code(options.Culling)
		if options.CullingCheck {
			o.culling_check = 1
		}
		o.initial_tile_size, o.minimum_tile_size = word(options.InitialTileSize), word(options.MinimumTileSize)
		o.split_factor, o.outputs = word(options.SplitFactor), C.uint32_t(options.Outputs)
		o.shortcuts_off, o.mask, o.pool = C.uint32_t(options.ShortcutsOff), C.uint32_t(options.Mask), used
		if options.Counters != nil {
			counts := &C.mlrt_counters{struct_size: C.sizeof_mlrt_counters}
			defer options.Counters.add(counts)
			pinner.Pin(counts)
			o.counters = counts
		}
		if len(options.Lights) > 0 {
			lights := make([]C.mlrt_light, len(options.Lights))
			for i, light := range options.Lights {
				lights[i] = light.toC()
			}
			pinner.Pin(&lights[0])
			o.lights, o.light_count = &lights[0], word(len(lights))
		}
	}
	return run(ctx, tree, pool, host, tile, func(bridge C.bridge_host, user C.uintptr_t) C.bridge_outcome {
		return function(handle, o, bridge, user)
	})
}

// Trace finds the closest hit of each ray.
func (tree *Tree) Trace(ctx context.Context, rays Rays, options *TraceOptions) (*Hits, error) {
	n, err := rays.count()
	if err != nil {
		return nil, err
	}
	hits, err := newHits(n)
	if err != nil {
		return nil, err
	}
	arrays := hits.Arrays()
	if err := tree.trace(ctx, &rays, options, ClosestHit, &arrays); err != nil {
		return nil, err
	}
	return hits, nil
}

// Occluded tells whether each ray hits anything.
func (tree *Tree) Occluded(ctx context.Context, rays Rays, options *TraceOptions) ([]bool, error) {
	n, err := rays.count()
	if err != nil {
		return nil, err
	}
	if err := checkMemory(n, 1); err != nil {
		return nil, err
	}
	occluded := make([]bool, n) // the library writes bytes 0 and 1
	arrays := HitArrays{Occluded: bools(occluded)}
	if err := tree.trace(ctx, &rays, options, AnyHit, &arrays); err != nil {
		return nil, err
	}
	return occluded, nil
}

func bools(slice []bool) Array[uint8] {
	if len(slice) == 0 {
		return Array[uint8]{}
	}
	return Slice(unsafe.Slice((*uint8)(unsafe.Pointer(&slice[0])), len(slice)))
}

// TraceInto writes the answers to arrays of the program; the options' Query says which.
func (tree *Tree) TraceInto(ctx context.Context, rays Rays, options *TraceOptions, hits HitArrays) error {
	query := ClosestHit
	if options != nil {
		query = options.Query
	}
	return tree.trace(ctx, &rays, options, query, &hits)
}

func (tree *Tree) trace(ctx context.Context, rays *Rays, options *TraceOptions, query Query, hits *HitArrays) error {
	var a arrays
	defer a.pinner.Unpin()
	from, err := rays.toC(&a)
	if err != nil {
		return err
	}
	to, err := hits.toC(&a, rays.Len(), 1)
	if err != nil {
		return err
	}
	return tree.with(ctx, options, query, &a.pinner, nil,
		func(handle *C.mlrt_tree, o *C.mlrt_trace_options, host C.bridge_host, _ C.uintptr_t) C.bridge_outcome {
			return C.bridge_trace_packet(handle, from, o, host, to)
		})
}

// TraceRay finds the closest hit of one ray. For more than a few rays Trace is faster.
func (tree *Tree) TraceRay(ray Ray, options *TraceOptions) (Hit, error) {
	c, err := tree.one(&ray, options, ClosestHit)
	return Hit{
		T: float32(c.t), U: float32(c.u), V: float32(c.v),
		Mesh: uint32(c.mesh), Triangle: uint32(c.triangle), Facing: int32(c.facing),
	}, err
}

// OccludedRay tells whether one ray hits anything.
func (tree *Tree) OccludedRay(ray Ray, options *TraceOptions) (bool, error) {
	c, err := tree.one(&ray, options, AnyHit)
	return c.occluded != 0, err
}

func (tree *Tree) one(ray *Ray, options *TraceOptions, query Query) (C.mlrt_hit, error) {
	var pinner runtime.Pinner
	defer pinner.Unpin()
	from, to := ray.toC(), C.mlrt_hit{struct_size: C.sizeof_mlrt_hit}
	err := tree.with(context.Background(), options, query, &pinner, nil,
		func(handle *C.mlrt_tree, o *C.mlrt_trace_options, _ C.bridge_host, _ C.uintptr_t) C.bridge_outcome {
			return C.bridge_trace_ray(handle, &from, o, &to)
		})
	return to, err
}

// AllHits finds all hits of each ray, in order, `capacity` at most; the totals count those beyond it, too.
func (tree *Tree) AllHits(ctx context.Context, rays Rays, options *TraceOptions, capacity int) (*HitLists, error) {
	n, err := rays.count()
	if err != nil {
		return nil, err
	}
	if err := checkCapacity(n, capacity); err != nil {
		return nil, err
	}
	hits, err := newHits(n * capacity)
	if err != nil {
		return nil, err
	}
	lists := &HitLists{
		Capacity: capacity, T: hits.T, U: hits.U, V: hits.V, Mesh: hits.Mesh, Triangle: hits.Triangle, Facing: hits.Facing,
		Crossing: make([]uint8, n*capacity), Total: make([]uint32, n), CrossingTotal: make([]uint32, n),
	}
	err = tree.AllHitsInto(ctx, rays, options, HitListArrays{
		Capacity: capacity, T: Slice(lists.T), U: Slice(lists.U), V: Slice(lists.V), Mesh: Slice(lists.Mesh),
		Triangle: Slice(lists.Triangle), Facing: Slice(lists.Facing), Crossing: Slice(lists.Crossing),
		Total: Slice(lists.Total), CrossingTotal: Slice(lists.CrossingTotal),
	})
	if err != nil {
		return nil, err
	}
	return lists, nil
}

// AllHitsInto writes all hits of each ray to arrays of the program.
func (tree *Tree) AllHitsInto(ctx context.Context, rays Rays, options *TraceOptions, lists HitListArrays) error {
	var a arrays
	defer a.pinner.Unpin()
	from, err := rays.toC(&a)
	if err != nil {
		return err
	}
	to, err := lists.toC(&a, rays.Len())
	if err != nil {
		return err
	}
	return tree.with(ctx, options, ClosestHit, &a.pinner, nil,
		func(handle *C.mlrt_tree, o *C.mlrt_trace_options, host C.bridge_host, _ C.uintptr_t) C.bridge_outcome {
			return C.bridge_trace_all_hits(handle, from, o, host, to)
		})
}

// RenderHits finds the closest hits of a camera's pixels, row by row.
func (tree *Tree) RenderHits(ctx context.Context, camera Camera, options *TraceOptions) (*Hits, error) {
	if _, err := camera.toC(); err != nil {
		return nil, err
	}
	columns, rows := camera.Size()
	hits, err := newHits(columns * rows)
	if err != nil {
		return nil, err
	}
	var closest TraceOptions
	if options != nil {
		closest = *options
		closest.Query = ClosestHit
	}
	arrays := hits.Arrays()
	if err := tree.Render(ctx, camera, &closest, &arrays, nil); err != nil {
		return nil, err
	}
	return hits, nil
}

// Render renders a picture into the arrays of a frame, or to a callback, or both; at least one must be given. The options
// have the query, lights, and the outputs for the callback.
//
// The threads of the pool call it, several at a time. An error of the callback ends the render, which returns it as Cause.
// To use the pool of the render in it is an error, unless that is one of goroutines.
func (tree *Tree) Render(ctx context.Context, camera Camera, options *TraceOptions, frame *HitArrays, callback func(*Tile) error) error {
	var a arrays
	defer a.pinner.Unpin()
	from, err := camera.toC()
	if err != nil {
		return err
	}
	var to *C.mlrt_hits
	if frame != nil {
		columns, rows := camera.Size()
		if to, err = frame.toC(&a, columns, rows); err != nil {
			return err
		}
	}
	query := ClosestHit
	if options != nil {
		query = options.Query
	}
	return tree.with(ctx, options, query, &a.pinner, callback,
		func(handle *C.mlrt_tree, o *C.mlrt_trace_options, host C.bridge_host, user C.uintptr_t) C.bridge_outcome {
			return C.bridge_render_tiles(handle, from, o, host, to, user)
		})
}

// OccludedPoints tells whether something lies between each point and the light.
func (tree *Tree) OccludedPoints(ctx context.Context, points Points, light Light, options *TraceOptions) ([]bool, error) {
	n := points.Positions.Len()
	if err := checkCount("points.count", n); err != nil {
		return nil, err
	}
	occluded := make([]bool, n)
	if err := tree.OccludedPointsInto(ctx, points, light, options, bools(occluded)); err != nil {
		return nil, err
	}
	return occluded, nil
}

// OccludedPointsInto writes it to an array of the program: 1 if something lies in between, 0 if nothing does.
func (tree *Tree) OccludedPointsInto(ctx context.Context, points Points, light Light, options *TraceOptions, occluded Array[uint8]) error {
	var a arrays
	defer a.pinner.Unpin()
	n := points.Positions.Len()
	from := C.mlrt_points{
		struct_size: C.sizeof_mlrt_points,
		row_length:  word(points.RowLength),
		count:       C.size_t(n),
		positions:   input(&a, "points.Positions", points.Positions, n),
		skip:        input(&a, "points.Skip", points.Skip, n),
	}
	to := output(&a, "occluded", occluded, n, 1)
	if err := a.check(); err != nil {
		return err
	}
	if n == 0 { // the library wants an array, though it writes none
		to.data = pin(&a.pinner, All[uint8](0))
	}
	c := light.toC()
	return tree.with(ctx, options, AnyHit, &a.pinner, nil,
		func(handle *C.mlrt_tree, o *C.mlrt_trace_options, host C.bridge_host, _ C.uintptr_t) C.bridge_outcome {
			return C.bridge_occluded_points(handle, &from, &c, o, host, &to)
		})
}

// ShadowRay returns the ray that decides whether a light reaches the hit of a ray; nil if the light is on the other side.
func (tree *Tree) ShadowRay(ray Ray, hit Hit, light Light) (*Ray, error) {
	handle, release, err := tree.use()
	if err != nil {
		return nil, err
	}
	defer release()
	from, l := ray.toC(), light.toC()
	h := C.mlrt_hit{struct_size: C.sizeof_mlrt_hit, mesh: C.uint32_t(hit.Mesh), triangle: C.uint32_t(hit.Triangle)}
	shadow := C.mlrt_ray{struct_size: C.sizeof_mlrt_ray}
	var faces C.int32_t
	if err := check(C.bridge_shadow_ray(handle, &from, &h, &l, &shadow, &faces)); err != nil || faces == 0 {
		return nil, err
	}
	return newRay(&shadow), nil
}

// OffsetPoint returns a point just off a triangle, next to (1 - u - v) a + u b + v c, on the side to which its normal points
// (side +1) or on the other one (-1). The side from which a ray came is -Facing of its hit.
func (tree *Tree) OffsetPoint(mesh, triangle uint32, u, v float32, side int) (point [3]float32, err error) {
	handle, release, err := tree.use()
	if err != nil {
		return point, err
	}
	defer release()
	var c [3]C.float
	err = check(C.bridge_offset_point(handle, C.uint32_t(mesh), C.uint32_t(triangle), C.float(u), C.float(v), code(side), &c[0]))
	return floats(c), err
}
