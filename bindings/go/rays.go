// SPDX-License-Identifier: MIT

package mlrt

// #include "bridge.h"
import "C"

import (
	"math"
	"runtime"
)

// A Mesh is an indexed mesh. Its arrays may change after the tree is built.
type Mesh struct {
	ID             uint32 // reported with hits. IDs must differ; if all are 0, they become 0, 1, 2, ...
	Vertices       Array[[3]float32]
	Triangles      Array[[3]uint32] // three numbers of vertices each
	ShortTriangles Array[[3]uint16] // the same in 16 bits; with neither, triangle i has the vertices 3i, 3i + 1, 3i + 2
	Mask           uint32           // rays see the mesh if their mask has a bit in common with it; 0 = all bits
}

// NewMesh makes a mesh of vertices and triangles.
func NewMesh(vertices [][3]float32, triangles [][3]uint32) Mesh {
	return Mesh{Vertices: Slice(vertices), Triangles: Slice(triangles)}
}

func meshes(pinner *runtime.Pinner, list []Mesh) (first *C.mlrt_mesh, count C.size_t, err error) {
	if len(list) == 0 {
		return nil, 0, nil
	}
	out := make([]C.mlrt_mesh, len(list))
	for i, mesh := range list {
		if mesh.Vertices.all || mesh.Triangles.all || mesh.ShortTriangles.all {
			return nil, 0, argumentError("meshes[%d]: one element for all is no array of a mesh", i)
		}
		out[i] = C.mlrt_mesh{
			struct_size:   C.sizeof_mlrt_mesh,
			id:            C.uint32_t(mesh.ID),
			vertices:      pin(pinner, mesh.Vertices),
			vertex_count:  C.size_t(mesh.Vertices.count),
			vertex_stride: C.size_t(mesh.Vertices.stride),
			mask:          C.uint32_t(mesh.Mask),
		}
		switch {
		case mesh.Triangles.stride != 0 && mesh.ShortTriangles.stride != 0:
			return nil, 0, argumentError("meshes[%d].ShortTriangles: it has Triangles, too", i)
		case mesh.Triangles.stride != 0:
			out[i].indices, out[i].index_size = pin(pinner, mesh.Triangles), 4
			out[i].triangle_count, out[i].triangle_stride = C.size_t(mesh.Triangles.count), C.size_t(mesh.Triangles.stride)
		case mesh.ShortTriangles.stride != 0:
			out[i].indices, out[i].index_size = pin(pinner, mesh.ShortTriangles), 2
			out[i].triangle_count = C.size_t(mesh.ShortTriangles.count)
			out[i].triangle_stride = C.size_t(mesh.ShortTriangles.stride)
		case mesh.Vertices.count%3 != 0:
			return nil, 0, argumentError("meshes[%d].Vertices: %d are not three for each triangle", i, mesh.Vertices.count)
		default:
			out[i].triangle_count = C.size_t(mesh.Vertices.count / 3)
		}
	}
	pinner.Pin(&out[0])
	return &out[0], C.size_t(len(out)), nil
}

// Rays are in arrays of the program. Each has an element per ray, or one that serves all; those that are zero are left out.
type Rays struct {
	Origins       Array[[3]float32] // where the rays start
	Directions    Array[[3]float32] // where they go; of any length, which is the unit of t
	TMin          Array[float32]    // hits count from here on, exclusively; left out: 0
	TMax          Array[float32]    // and up to here, inclusively; left out: no limit
	Skip          Array[[2]uint32]  // mesh and triangle that the ray passes through; None, None = none
	Mask          Array[uint32]     // a mask for each ray, in place of that of the options
	RowLength     int               // rays in a row of a picture; 0 = not known. A hint for speed only
	RaysPerOrigin int               // each so many neighbours share an element of Origins, TMin and Skip; 0 = 1
}

// NewRays makes rays of unlimited length.
func NewRays(origins, directions [][3]float32) Rays {
	return Rays{Origins: Slice(origins), Directions: Slice(directions)}
}

// Len returns the number of rays: that of Directions, or of Origins if one direction serves all.
func (rays *Rays) Len() int {
	if !rays.Directions.all {
		return rays.Directions.count
	}
	origins, shared := rays.Origins.Len(), max(rays.RaysPerOrigin, 1)
	if origins > math.MaxInt/shared {
		return math.MaxInt
	}
	return origins * shared
}

// count returns the number of rays, if that is one that the library takes.
func (rays *Rays) count() (int, error) {
	n := rays.Len()
	return n, checkCount("rays.count", n)
}

func (rays *Rays) toC(a *arrays) (*C.mlrt_rays, error) {
	n, err := rays.count()
	if err != nil {
		return nil, err
	}
	shared := max(rays.RaysPerOrigin, 1)
	if n%shared != 0 {
		return nil, argumentError("rays.RaysPerOrigin: %d does not divide %d rays", shared, n)
	}
	return &C.mlrt_rays{
		struct_size:     C.sizeof_mlrt_rays,
		row_length:      word(rays.RowLength),
		count:           C.size_t(n),
		origins:         input(a, "rays.Origins", rays.Origins, n/shared),
		directions:      input(a, "rays.Directions", rays.Directions, n),
		t_min:           input(a, "rays.TMin", rays.TMin, n/shared),
		t_max:           input(a, "rays.TMax", rays.TMax, n),
		skip:            input(a, "rays.Skip", rays.Skip, n/shared),
		mask:            input(a, "rays.Mask", rays.Mask, n),
		rays_per_origin: word(rays.RaysPerOrigin),
	}, a.err
}

// A Ray is one ray. TMax is a limit as given; NewRay sets it to infinity.
type Ray struct {
	Origin    [3]float32
	Direction [3]float32 // of any length, which is the unit of t
	TMin      float32    // hits count from here on, exclusively
	TMax      float32    // and up to here, inclusively
	Skip      *[2]uint32 // mesh and triangle that it passes through; nil = none
}

// NewRay makes a ray of unlimited length.
func NewRay(origin, direction [3]float32) Ray {
	return Ray{Origin: origin, Direction: direction, TMax: float32(math.Inf(1))}
}

// limit is a t_max of structs of the C interface, in which 0 means none: below a negative one nothing lies.
func limit(tMax float32) C.float {
	switch {
	case math.IsInf(float64(tMax), 1):
		return 0
	case tMax == 0:
		return -1
	}
	return C.float(tMax)
}

func (ray *Ray) toC() C.mlrt_ray {
	out := C.mlrt_ray{
		struct_size: C.sizeof_mlrt_ray,
		origin:      vector(ray.Origin),
		direction:   vector(ray.Direction),
		t_min:       C.float(ray.TMin),
		t_max:       limit(ray.TMax),
	}
	if ray.Skip != nil {
		out.flags = C.MLRT_RAY_SKIP
		out.skip_mesh, out.skip_triangle = C.uint32_t(ray.Skip[0]), C.uint32_t(ray.Skip[1])
	}
	return out
}

func floats(v [3]C.float) [3]float32 {
	return [3]float32{float32(v[0]), float32(v[1]), float32(v[2])}
}

func newRay(from *C.mlrt_ray) *Ray {
	ray := &Ray{
		Origin: floats(from.origin), Direction: floats(from.direction), TMin: float32(from.t_min), TMax: float32(from.t_max),
	}
	if from.t_max == 0 {
		ray.TMax = float32(math.Inf(1))
	}
	if from.flags&C.MLRT_RAY_SKIP != 0 {
		ray.Skip = &[2]uint32{uint32(from.skip_mesh), uint32(from.skip_triangle)}
	}
	return ray
}

// A Hit is the closest hit of a ray. A miss has T infinite, Mesh and Triangle None, and Facing 0.
type Hit struct {
	T              float32 // the distance in units of the direction's length; a hit's can be infinite, too
	U, V           float32 // the weights of the triangle's second and third vertex
	Mesh, Triangle uint32  // the id of the mesh, and the number of the triangle in it
	Facing         int32   // +1 where the ray travels along the normal (b - a) x (c - a), -1 against it
}

// IsHit tells hits from misses.
func (hit *Hit) IsHit() bool { return hit.Facing != 0 }

// Hits are the closest hits of rays or pixels, an element for each.
type Hits struct {
	T, U, V        []float32
	Mesh, Triangle []uint32
	Facing         []int32
}

func newHits(n int) (*Hits, error) {
	if err := checkMemory(n, 25); err != nil { // one for HitLists.Crossing
		return nil, err
	}
	return &Hits{
		T: make([]float32, n), U: make([]float32, n), V: make([]float32, n),
		Mesh: make([]uint32, n), Triangle: make([]uint32, n), Facing: make([]int32, n),
	}, nil
}

// Arrays returns the slices as arrays for TraceInto and Render.
func (hits *Hits) Arrays() HitArrays {
	return HitArrays{
		T: Slice(hits.T), U: Slice(hits.U), V: Slice(hits.V),
		Mesh: Slice(hits.Mesh), Triangle: Slice(hits.Triangle), Facing: Slice(hits.Facing),
	}
}

// HitArrays receive results. Those that are zero are not computed.
type HitArrays struct {
	T, U, V        Array[float32]
	Mesh, Triangle Array[uint32]
	Facing         Array[int32]
	// AnyHit: 1 if something is hit. With lights: bit k is 1 if light k does not reach the hit.
	Occluded Array[uint8]
}

// Records returns the fields of structs, which are written together.
func Records(hits []Hit) HitArrays {
	return HitArrays{
		T:        Field(hits, func(hit *Hit) *float32 { return &hit.T }),
		U:        Field(hits, func(hit *Hit) *float32 { return &hit.U }),
		V:        Field(hits, func(hit *Hit) *float32 { return &hit.V }),
		Mesh:     Field(hits, func(hit *Hit) *uint32 { return &hit.Mesh }),
		Triangle: Field(hits, func(hit *Hit) *uint32 { return &hit.Triangle }),
		Facing:   Field(hits, func(hit *Hit) *int32 { return &hit.Facing }),
	}
}

func (hits *HitArrays) toC(a *arrays, columns, rows int) (*C.mlrt_hits, error) {
	out := &C.mlrt_hits{
		struct_size: C.sizeof_mlrt_hits,
		t:           output(a, "hits.T", hits.T, columns, rows),
		u:           output(a, "hits.U", hits.U, columns, rows),
		v:           output(a, "hits.V", hits.V, columns, rows),
		mesh:        output(a, "hits.Mesh", hits.Mesh, columns, rows),
		triangle:    output(a, "hits.Triangle", hits.Triangle, columns, rows),
		facing:      output(a, "hits.Facing", hits.Facing, columns, rows),
		occluded:    output(a, "hits.Occluded", hits.Occluded, columns, rows),
	}
	return out, a.check()
}

// HitLists are all hits of rays: hit j of ray i is element i * Capacity + j. Those behind the last hit of a ray are misses.
type HitLists struct {
	Capacity       int
	T, U, V        []float32
	Mesh, Triangle []uint32
	Facing         []int32
	Crossing       []uint8  // 1 = the hit crosses the surface, 0 = it only touches it, or there is no hit
	Total          []uint32 // hits of each ray, with those beyond Capacity
	CrossingTotal  []uint32 // those of them that cross. Odd: the ray starts inside of a closed mesh
}

// HitListArrays receive lists of hits. Those that are zero are not written.
type HitListArrays struct {
	Capacity       int // most hits written per ray; 0 = only the totals are
	T, U, V        Array[float32]
	Mesh, Triangle Array[uint32]
	Facing         Array[int32]
	Crossing       Array[uint8]
	Total          Array[uint32] // one per ray, as is the next
	CrossingTotal  Array[uint32]
}

// checkCapacity fails where n lists of `capacity` hits are no number of elements.
func checkCapacity(n, capacity int) error {
	if capacity < 0 || uint64(capacity) > math.MaxUint32 || capacity > 0 && n > math.MaxInt/4/capacity {
		return argumentError("capacity: no lists of %d hits for %d rays", capacity, n)
	}
	return nil
}

func (lists *HitListArrays) toC(a *arrays, n int) (*C.mlrt_hit_lists, error) {
	if err := checkCapacity(n, lists.Capacity); err != nil {
		return nil, err
	}
	all := n * lists.Capacity
	out := &C.mlrt_hit_lists{
		struct_size:    C.sizeof_mlrt_hit_lists,
		capacity:       word(lists.Capacity),
		t:              output(a, "lists.T", lists.T, all, 1),
		u:              output(a, "lists.U", lists.U, all, 1),
		v:              output(a, "lists.V", lists.V, all, 1),
		mesh:           output(a, "lists.Mesh", lists.Mesh, all, 1),
		triangle:       output(a, "lists.Triangle", lists.Triangle, all, 1),
		facing:         output(a, "lists.Facing", lists.Facing, all, 1),
		crossing:       output(a, "lists.Crossing", lists.Crossing, all, 1),
		total:          output(a, "lists.Total", lists.Total, n, 1),
		crossing_total: output(a, "lists.CrossingTotal", lists.CrossingTotal, n, 1),
	}
	return out, a.check()
}

// A Camera has the rays of a picture: pixel (i, j) has p = D00 + (i + Sample[0]) DX + (j + Sample[1]) DY, and the ray from
// Eye along p, or if it is Parallel from p along Direction, in exactly the arithmetic that mlrt.h states. TMax is a limit
// as given: LookAt sets it to infinity.
type Camera struct {
	Parallel      bool
	Width, Height int    // of the picture, 1..2^23
	Crop          [4]int // only these pixels: x, y, width, height; a width or height of 0: up to the last
	Eye           [3]float32
	Direction     [3]float32 // Parallel: where the rays go
	D00, DX, DY   [3]float32
	Sample        [2]float32 // where in the pixel; 0.5 = the middle
	TMin, TMax    float32
}

func cross(a, b [3]float64) (c [3]float64) {
	for k := range c {
		c[k] = a[(k+1)%3]*b[(k+2)%3] - a[(k+2)%3]*b[(k+1)%3]
	}
	return c
}

func unit(a [3]float64) [3]float64 {
	length := math.Sqrt(a[0]*a[0] + a[1]*a[1] + a[2]*a[2])
	return [3]float64{a[0] / length, a[1] / length, a[2] / length}
}

func wide(a [3]float32) [3]float64 {
	return [3]float64{float64(a[0]), float64(a[1]), float64(a[2])}
}

// LookAt makes a pinhole camera at `eye` with `target` in the middle, `degrees` high. Pixels count from the upper left.
func LookAt(eye, target, up [3]float32, degrees float64, width, height int) Camera {
	forward := wide(target)
	for k := range forward {
		forward[k] -= float64(eye[k])
	}
	forward = unit(forward)
	right := unit(cross(forward, wide(up)))
	upward := cross(right, forward)
	pixel := 2 * math.Tan(degrees*math.Pi/360) / float64(height)
	camera := Camera{Width: width, Height: height, Eye: eye, Sample: [2]float32{0.5, 0.5}, TMax: float32(math.Inf(1))}
	for k := range forward {
		camera.D00[k] = float32(forward[k] + pixel*(upward[k]*float64(height)-right[k]*float64(width))/2)
		camera.DX[k] = float32(right[k] * pixel)
		camera.DY[k] = float32(-upward[k] * pixel)
	}
	return camera
}

// Size returns the columns and rows of what is rendered.
func (camera *Camera) Size() (columns, rows int) {
	columns, rows = camera.Crop[2], camera.Crop[3]
	if columns == 0 {
		columns = camera.Width - camera.Crop[0]
	}
	if rows == 0 {
		rows = camera.Height - camera.Crop[1]
	}
	return max(columns, 0), max(rows, 0)
}

// toC returns a camera with no more pixels than the library takes, and no fewer than one.
func (camera *Camera) toC() (*C.mlrt_camera, error) {
	for _, number := range append([]int{camera.Width, camera.Height}, camera.Crop[:]...) {
		if number < 0 || uint64(number) > math.MaxUint32 {
			return nil, &Error{Status: BadCamera, Message: "camera: a size or place that is negative or too large"}
		}
	}
	out := &C.mlrt_camera{
		struct_size: C.sizeof_mlrt_camera,
		width:       C.uint32_t(camera.Width),
		height:      C.uint32_t(camera.Height),
		crop_x:      C.uint32_t(camera.Crop[0]),
		crop_y:      C.uint32_t(camera.Crop[1]),
		crop_width:  C.uint32_t(camera.Crop[2]),
		crop_height: C.uint32_t(camera.Crop[3]),
		eye:         vector(camera.Eye),
		direction:   vector(camera.Direction),
		d00:         vector(camera.D00),
		dx:          vector(camera.DX),
		dy:          vector(camera.DY),
		sample_x:    C.float(camera.Sample[0]),
		sample_y:    C.float(camera.Sample[1]),
		t_min:       C.float(camera.TMin),
		t_max:       limit(camera.TMax),
	}
	if camera.Parallel {
		out.projection = C.MLRT_PROJECTION_PARALLEL
	}
	if columns, rows := camera.Size(); uint64(columns)*uint64(rows)-1 >= math.MaxInt32 {
		return out, check(C.bridge_camera_rays(out, nil, nil)) // which says what is wrong
	}
	return out, nil
}

// Rays returns the very rays that Render traces, row by row.
func (camera *Camera) Rays() (origins, directions [][3]float32, err error) {
	if _, err = camera.toC(); err != nil {
		return nil, nil, err
	}
	columns, rows := camera.Size()
	if err = checkMemory(columns*rows, 24); err != nil {
		return nil, nil, err
	}
	origins, directions = make([][3]float32, columns*rows), make([][3]float32, columns*rows)
	err = camera.RaysInto(Slice(origins), Slice(directions))
	return origins, directions, err
}

// RaysInto writes these rays to arrays of the program. Either may be left out.
func (camera *Camera) RaysInto(origins, directions Array[[3]float32]) error {
	c, err := camera.toC()
	if err != nil {
		return err
	}
	columns, rows := camera.Size()
	var a arrays
	defer a.pinner.Unpin()
	starts, ways := output(&a, "origins", origins, columns, rows), output(&a, "directions", directions, columns, rows)
	if err := a.check(); err != nil {
		return err
	}
	return check(C.bridge_camera_rays(c, &starts, &ways))
}

// Points are asked whether they lie in the shadow of a light.
type Points struct {
	Positions Array[[3]float32]
	Skip      Array[[2]uint32] // mesh and triangle that each lies on, which does not shade it; left out: none
	RowLength int              // points in a row of a picture; 0 = a plain list. A hint for speed only
}
