// SPDX-License-Identifier: MIT

package mlrt_test

import (
	"context"
	"encoding/binary"
	"errors"
	"fmt"
	"hash/fnv"
	"math"
	"os"
	"os/exec"
	"reflect"
	"runtime"
	"strings"
	"sync"
	"sync/atomic"
	"testing"
	"time"
	"unsafe"

	mlrt "github.com/libmlrt/libmlrt/bindings/go"
)

var ctx = context.Background()

type draw uint32

func (d *draw) number() uint32 {
	*d = *d*1664525 + 1013904223
	return uint32(*d >> 20)
}

func (d *draw) point(divisor float32) (p [3]float32) {
	for k := range p {
		p[k] = (float32(d.number()) - 2048) / divisor
	}
	return p
}

func hash(hits *mlrt.Hits) uint64 {
	sum := fnv.New64a()
	for i := range hits.T {
		binary.Write(sum, binary.LittleEndian, []uint32{
			math.Float32bits(hits.T[i]), math.Float32bits(hits.U[i]), math.Float32bits(hits.V[i]),
			hits.Mesh[i], hits.Triangle[i], uint32(hits.Facing[i]),
		})
	}
	return sum.Sum64()
}

// The scene of bindings/c/scene.h.
type scene struct {
	vertices            [2][][3]float32
	triangles           [2][][3]uint32
	origins, directions [][3]float32
}

func newScene() *scene {
	d, s := draw(1), &scene{}
	for m := range s.vertices {
		for i := 0; i < 100; i++ {
			s.vertices[m] = append(s.vertices[m], d.point(256))
		}
		for i := 0; i < 150; i++ {
			s.triangles[m] = append(s.triangles[m], [3]uint32{d.number() % 100, d.number() % 100, d.number() % 100})
		}
	}
	for i := 0; i < 1000; i++ {
		s.origins = append(s.origins, d.point(256))
		s.directions = append(s.directions, d.point(2048))
		for k := 0; k < 3 && i%4 == 3; k++ {
			s.directions[i][k] = s.vertices[0][i%100][k] - s.origins[i][k]
		}
	}
	return s
}

func (s *scene) meshes() []mlrt.Mesh {
	meshes := []mlrt.Mesh{mlrt.NewMesh(s.vertices[0], s.triangles[0]), mlrt.NewMesh(s.vertices[1], s.triangles[1])}
	meshes[0].ID, meshes[1].ID = 7, 3
	return meshes
}

func (s *scene) rays() mlrt.Rays { return mlrt.NewRays(s.origins, s.directions) }

// Two triangles, one behind the other, seen along z.
var walls = [][3]float32{{-9, -9, 5}, {9, -9, 5}, {0, 9, 5}, {-9, -9, 8}, {9, -9, 8}, {0, 9, 8}}

func build(t *testing.T, meshes ...mlrt.Mesh) *mlrt.Tree {
	tree := must(mlrt.Build(ctx, meshes, nil))
	t.Cleanup(func() { tree.Close() })
	return tree
}

func must[T any](value T, err error) T {
	if err != nil {
		panic(err)
	}
	return value
}

func equal[T any](t *testing.T, found, expected T) {
	t.Helper()
	if !reflect.DeepEqual(found, expected) {
		t.Errorf("%v, expected %v", found, expected)
	}
}

// status requires an error whose text has these words.
func status(t *testing.T, err error, expected mlrt.Status, words string) {
	t.Helper()
	if !errors.Is(err, expected) || !strings.Contains(err.Error(), words) {
		t.Errorf("error %v, expected %v with %q", err, expected, words)
	}
}

func TestTheSameAnswers(t *testing.T) {
	s := newScene()
	tree, pool := build(t, s.meshes()...), must(mlrt.NewPool(2))
	defer pool.Close()
	hits := must(tree.Trace(ctx, s.rays(), nil))
	options := &mlrt.TraceOptions{Pool: pool}
	for i, yes := range must(tree.Occluded(ctx, s.rays(), options)) {
		if yes != (hits.Mesh[i] != mlrt.None) {
			t.Fatalf("ray %d: any hit is not the closest hit", i)
		}
	}
	var group sync.WaitGroup
	for i := 0; i < 4; i++ {
		group.Add(1)
		go func() {
			defer group.Done()
			equal(t, must(tree.Trace(ctx, s.rays(), options)), hits)
		}()
	}
	group.Wait()
	fmt.Printf("\n%016x\n", hash(hits))
}

func TestErrorsSayWhatIsWrong(t *testing.T) {
	_, err := mlrt.Build(ctx, []mlrt.Mesh{mlrt.NewMesh(walls, [][3]uint32{{0, 1, 2}, {0, 1, 6}})}, nil)
	status(t, err, mlrt.IndexRange, "triangle 1: vertex index 6")
	_, err = mlrt.NewPool(5000)
	status(t, err, mlrt.Argument, "thread_count: 5000")
	for _, number := range []int{-1, 1<<32 + 1} { // of which C would take the low bits
		_, err = mlrt.NewPool(number)
		status(t, err, mlrt.Argument, "thread_count")
	}
	tree := build(t, mlrt.Mesh{Vertices: mlrt.Slice(walls)})
	_, err = tree.Trace(ctx, mlrt.NewRays(make([][3]float32, 2), make([][3]float32, 1)), nil)
	status(t, err, mlrt.Argument, "rays.Origins: 2 elements, where 1")
	rays := mlrt.NewRays(make([][3]float32, 2), make([][3]float32, 2))
	status(t, tree.TraceInto(ctx, rays, nil, mlrt.HitArrays{T: mlrt.Slice(make([]float32, 1))}), mlrt.Argument, "hits.T")
	for _, capacity := range []int{-1, 1<<32 + 1, 1 << 62} {
		_, err = tree.AllHits(ctx, rays, nil, capacity)
		status(t, err, mlrt.Argument, "capacity")
		lists := mlrt.HitListArrays{Capacity: capacity, T: mlrt.Slice(make([]float32, 2))}
		status(t, tree.AllHitsInto(ctx, rays, nil, lists), mlrt.Argument, "capacity")
	}
	shared := mlrt.Rays{Origins: rays.Origins, Directions: mlrt.All([3]float32{0, 0, 1}), RaysPerOrigin: 1 << 33}
	status(t, tree.TraceInto(ctx, shared, nil, mlrt.HitArrays{T: mlrt.Slice(make([]float32, 2))}), mlrt.TooLarge, "rays.count")
	_, err = tree.Trace(ctx, rays, &mlrt.TraceOptions{InitialTileSize: 1<<32 + 16})
	status(t, err, mlrt.Argument, "initial_tile_size")
	_, err = tree.Trace(ctx, rays, &mlrt.TraceOptions{InitialTileSize: 5})
	status(t, err, mlrt.Argument, "initial_tile_size: 5")
	_, err = tree.Trace(ctx, rays, &mlrt.TraceOptions{Method: mlrt.Packet2})
	status(t, err, mlrt.Unsupported, "")
	_, err = tree.RenderHits(ctx, mlrt.Camera{Width: 1, Height: 1}, nil)
	status(t, err, mlrt.BadCamera, "")
	_, err = tree.RenderHits(ctx, mlrt.Camera{Width: -1, Height: 1}, nil)
	status(t, err, mlrt.BadCamera, "")
	_, err = tree.RenderHits(ctx, mlrt.Camera{}, nil)
	status(t, err, mlrt.BadCamera, "camera.width: 0")
	_, err = mlrt.Load([]byte("no tree"), nil)
	status(t, err, mlrt.BadData, "")
	equal(t, must(build(t).Trace(ctx, mlrt.NewRays(walls[:1], walls[:1]), nil)).Mesh, []uint32{mlrt.None})
	equal(t, len(must(tree.Trace(ctx, mlrt.Rays{}, nil)).T), 0)
	equal(t, len(must(tree.AllHits(ctx, mlrt.Rays{}, nil, 2)).Total), 0)
	major, minor, patch := mlrt.Version()
	equal(t, [3]int{major, minor, patch}, [3]int{0, 1, 0})
	narrowest := 0
	for _, isa := range []mlrt.ISA{mlrt.Scalar, mlrt.SSE, mlrt.NEON} {
		if mlrt.CanUse(isa) {
			narrowest++
		}
	}
	if narrowest != 1 || mlrt.CanUse(mlrt.AVX512) && !mlrt.CanUse(mlrt.SSE) {
		t.Error("instruction sets")
	}
}

func TestHowATreeIsBuiltChangesNoAnswer(t *testing.T) {
	s := newScene()
	hits := must(build(t, s.meshes()...).Trace(ctx, s.rays(), nil))
	pool := must(mlrt.NewPool(2))
	defer pool.Close()
	var levels []mlrt.Level
	host := mlrt.Host{Log: func(level mlrt.Level, message string) { levels = append(levels, level) }}
	options := &mlrt.TreeOptions{
		Preset: mlrt.BestTree, TraversalCost: 2, IntersectionCost: 0.5, MemoryLimit: 1 << 24, Pool: pool, Host: host,
	}
	tree := must(mlrt.Build(ctx, s.meshes(), options))
	defer tree.Close()
	equal(t, must(tree.Trace(ctx, s.rays(), nil)), hits)
	equal(t, must(tree.Info()).Structure, mlrt.Boxes)
	if must(mlrt.EstimateTree(s.meshes(), options)).MemorySize == 0 {
		t.Error("no estimate")
	}
	_, err := mlrt.Build(ctx, s.meshes(), &mlrt.TreeOptions{MemoryLimit: 100, Host: host})
	status(t, err, mlrt.OutOfMemory, "")
	// Some triangles have no area; then the tree is there; then the second is not.
	equal(t, levels, []mlrt.Level{mlrt.LogWarning, mlrt.LogInfo, mlrt.LogError})

	kd := &mlrt.KdTreeOptions{
		Preset: mlrt.TunedKdTree, TraversalCost: 1, IntersectionCost: 2, MemoryLimit: 1 << 24, MaxReferences: 100000,
		MaxDepth: 5, RulesOff: mlrt.Coplanar | mlrt.Retraction, Pool: pool, Host: host,
	}
	kdTree := must(mlrt.BuildKdTree(ctx, s.meshes(), kd))
	defer kdTree.Close()
	info := must(kdTree.Info())
	equal(t, []int{int(info.Structure), info.Depth, int(info.Triangles)}, []int{int(mlrt.KdTree), 5, 300})
	if must(mlrt.EstimateKdTree(s.meshes(), kd)).PeakMemorySize == 0 {
		t.Error("no estimate")
	}
	narrowest := mlrt.SSE
	for _, isa := range []mlrt.ISA{mlrt.Scalar, mlrt.NEON} {
		if mlrt.CanUse(isa) {
			narrowest = isa
		}
	}
	for _, method := range []mlrt.Method{mlrt.DefaultMethod, mlrt.RayMethod, mlrt.Packet2, mlrt.Packet4, mlrt.Multilevel} {
		counters := &mlrt.Counters{}
		options := &mlrt.TraceOptions{
			Method: method, ISA: narrowest, Culling: mlrt.DirectCulling, CullingCheck: true, InitialTileSize: 16,
			MinimumTileSize: 8, SplitFactor: 4, ShortcutsOff: mlrt.WholeTiles | mlrt.EntryLists, Counters: counters,
		}
		equal(t, must(kdTree.Trace(ctx, s.rays(), options)), hits)
		equal(t, counters.Counts().Rays, 1000)
	}
}

func TestArraysOfAnyShape(t *testing.T) {
	type vertex struct{ normal, position [3]float32 }
	s := newScene()
	tree := build(t, s.meshes()...)
	hits := must(tree.Trace(ctx, s.rays(), nil))

	// Meshes of structs, and of 16-bit indices with a fourth one.
	type quad struct {
		triangle [3]uint16
		fourth   uint16
	}
	vertices, quads := make([]vertex, 100), make([]quad, 150)
	for i, position := range s.vertices[0] {
		vertices[i] = vertex{[3]float32{9, 9, 9}, position}
	}
	for i, triangle := range s.triangles[0] {
		quads[i] = quad{[3]uint16{uint16(triangle[0]), uint16(triangle[1]), uint16(triangle[2])}, 999}
	}
	meshes := s.meshes()
	meshes[0] = mlrt.Mesh{
		ID:             7,
		Vertices:       mlrt.Field(vertices, func(v *vertex) *[3]float32 { return &v.position }),
		ShortTriangles: mlrt.Field(quads, func(q *quad) *[3]uint16 { return &q.triangle }),
	}
	equal(t, must(mlrt.HashGeometry(meshes)), must(mlrt.HashGeometry(s.meshes())))
	equal(t, must(build(t, meshes...).Trace(ctx, s.rays(), nil)), hits)

	// Hits as structs.
	records := make([]mlrt.Hit, 1000)
	rays := s.rays()
	rays.RowLength = 100
	if err := tree.TraceInto(ctx, rays, nil, mlrt.Records(records)); err != nil {
		t.Fatal(err)
	}
	for i, r := range records {
		equal(t, r, mlrt.Hit{hits.T[i], hits.U[i], hits.V[i], hits.Mesh[i], hits.Triangle[i], hits.Facing[i]})
	}

	// One origin and one limit for all; four rays from each origin.
	limits, origins := make([]float32, 1000), make([][3]float32, 1000)
	for i := range limits {
		limits[i], origins[i] = 0.5, s.origins[5]
	}
	all := mlrt.Rays{Origins: mlrt.All(s.origins[5]), Directions: mlrt.Slice(s.directions), TMax: mlrt.All[float32](0.5)}
	written := mlrt.Rays{Origins: mlrt.Slice(origins), Directions: mlrt.Slice(s.directions), TMax: mlrt.Slice(limits)}
	equal(t, must(tree.Trace(ctx, all, nil)), must(tree.Trace(ctx, written, nil)))
	var every [][3]float32
	for i := range origins {
		if i%4 == 0 {
			every = append(every, s.origins[i])
		}
		origins[i] = s.origins[i/4*4]
	}
	bundles := mlrt.NewRays(every, s.directions)
	bundles.RaysPerOrigin = 4
	equal(t, must(tree.Trace(ctx, bundles, nil)), must(tree.Trace(ctx, mlrt.NewRays(origins, s.directions), nil)))
	bundles.RaysPerOrigin = 3
	_, err := tree.Trace(ctx, bundles, nil)
	status(t, err, mlrt.Argument, "RaysPerOrigin")

	defer func() {
		if recover() == nil {
			t.Error("structs with pointers, which C must not see")
		}
	}()
	type named struct {
		name     string
		position [3]float32
	}
	mlrt.Field(make([]named, 1), func(n *named) *[3]float32 { return &n.position })
}

func TestLimitsSkipsAndMasks(t *testing.T) {
	tree := build(t, mlrt.Mesh{ID: 4, Vertices: mlrt.Slice(walls)})
	origins, directions := make([][3]float32, 4), [][3]float32{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}}
	inf, none := float32(math.Inf(1)), [2]uint32{mlrt.None, mlrt.None}
	rays := mlrt.NewRays(origins, directions)
	rays.TMin, rays.TMax = mlrt.Slice([]float32{0, 5, 0, 0}), mlrt.Slice([]float32{inf, inf, 4.5, 9})
	rays.Skip = mlrt.Slice([][2]uint32{none, none, none, {4, 0}})
	equal(t, must(tree.Trace(ctx, rays, nil)).Triangle, []uint32{0, 1, mlrt.None, 1})

	triangle := func(change func(*mlrt.Ray)) uint32 {
		ray := mlrt.NewRay([3]float32{}, [3]float32{0, 0, 1})
		change(&ray)
		hit := must(tree.TraceRay(ray, nil))
		equal(t, must(tree.OccludedRay(ray, nil)), hit.IsHit())
		return hit.Triangle
	}
	equal(t, triangle(func(ray *mlrt.Ray) {}), 0)
	equal(t, triangle(func(ray *mlrt.Ray) { ray.TMin = 5 }), 1)
	equal(t, triangle(func(ray *mlrt.Ray) { ray.TMax = 4.5 }), mlrt.None)
	equal(t, triangle(func(ray *mlrt.Ray) { ray.TMax = 0 }), mlrt.None)
	equal(t, triangle(func(ray *mlrt.Ray) { ray.Skip = &[2]uint32{4, 0} }), 1)
	equal(t, triangle(func(ray *mlrt.Ray) { ray.Skip, ray.TMin = &[2]uint32{4, 1}, 5 }), mlrt.None)

	front, back := mlrt.NewMesh(walls, [][3]uint32{{0, 1, 2}}), mlrt.NewMesh(walls, [][3]uint32{{3, 4, 5}})
	front.Mask, back.Mask = 1, 2
	tree = build(t, front, back)
	rays = mlrt.NewRays(origins, directions)
	equal(t, must(tree.Trace(ctx, rays, &mlrt.TraceOptions{Mask: 2})).Mesh, []uint32{1, 1, 1, 1})
	rays.Mask = mlrt.Slice([]uint32{0, 1, 2, 4})
	equal(t, must(tree.Trace(ctx, rays, nil)).Mesh, []uint32{0, 0, 1, mlrt.None})
}

func TestPictures(t *testing.T) {
	tree := build(t, mlrt.Mesh{Vertices: mlrt.Slice(walls)})
	camera := mlrt.LookAt([3]float32{0.5, 0, 0}, [3]float32{0, 0, 5}, [3]float32{0, 1, 0}, 60, 64, 64)
	camera.Crop = [4]int{8, 8, 48, 40}
	columns, rows := camera.Size()
	origins, directions, err := camera.Rays()
	if err != nil {
		t.Fatal(err)
	}
	picture := must(tree.RenderHits(ctx, camera, nil))
	equal(t, picture, must(tree.Trace(ctx, mlrt.NewRays(origins, directions), nil)))

	// The first light is in front of the wall, the second behind it.
	pool := must(mlrt.NewPool(2))
	defer pool.Close()
	options := &mlrt.TraceOptions{
		Pool: pool, InitialTileSize: 16,
		Lights:  []mlrt.Light{{Position: [3]float32{0, 0, 1}}, {Kind: mlrt.DirectionalLight, Position: [3]float32{0, 0, 1}}},
		Outputs: mlrt.OutputT | mlrt.OutputUV | mlrt.OutputIDs | mlrt.OutputFacing | mlrt.OutputOccluded,
	}
	var seen atomic.Int64
	shadow := func(pixel int) uint8 {
		if picture.Facing[pixel] != 0 {
			return 2
		}
		return 0
	}
	frame := make([]uint8, 64*rows)
	arrays := mlrt.HitArrays{Occluded: mlrt.Slice(frame).Rows(64)}
	err = tree.Render(ctx, camera, options, &arrays, func(tile *mlrt.Tile) error {
		for i := 0; i < tile.Width*tile.Height; i++ {
			p := (tile.Y-8+i/tile.Width)*columns + tile.X - 8 + i%tile.Width
			if tile.T[i] != picture.T[p] || tile.U[i] != picture.U[p] || tile.V[i] != picture.V[p] ||
				tile.MeshID[i] != picture.Mesh[p] || tile.Triangle[i] != picture.Triangle[p] ||
				tile.Facing[i] != picture.Facing[p] || tile.Occluded[i] != shadow(p) || tile.Worker > 1 {
				t.Error("pixel", p)
			}
		}
		seen.Add(int64(tile.Width * tile.Height))
		return nil
	})
	equal(t, err, nil)
	equal(t, seen.Load(), int64(columns*rows))
	for i := 0; i < 64*rows; i++ {
		expected := uint8(0)
		if i%64 < columns {
			expected = shadow(i/64*columns + i%64)
		}
		equal(t, frame[i], expected)
	}

	camera.Parallel, camera.Direction, camera.TMin, camera.TMax = true, [3]float32{0, 0, 1}, 6, 9
	hit := make([]uint8, columns*rows)
	arrays = mlrt.HitArrays{Occluded: mlrt.Slice(hit)}
	equal(t, tree.Render(ctx, camera, &mlrt.TraceOptions{Query: mlrt.AnyHit}, &arrays, nil), nil)
	for _, yes := range hit {
		equal(t, yes, 1)
	}

	stop := errors.New("enough")
	err = tree.Render(ctx, camera, &mlrt.TraceOptions{Outputs: mlrt.OutputT}, nil, func(*mlrt.Tile) error { return stop })
	status(t, err, mlrt.Cancelled, "enough")
	if !errors.Is(err, stop) {
		t.Error(err)
	}
	defer func() { equal(t, recover(), any("in a callback")) }()
	tree.Render(ctx, camera, &mlrt.TraceOptions{Outputs: mlrt.OutputT}, nil, func(*mlrt.Tile) error { panic("in a callback") })
}

func TestPointsAndShadows(t *testing.T) {
	tree := build(t, mlrt.Mesh{Vertices: mlrt.Slice(walls)})
	ray := mlrt.NewRay([3]float32{}, [3]float32{0, 0, 1})
	hit := must(tree.TraceRay(ray, nil))
	point := must(tree.OffsetPoint(hit.Mesh, hit.Triangle, hit.U, hit.V, int(-hit.Facing)))
	if point[2] >= 5 || point[2] < 4.99 {
		t.Error(point)
	}
	_, err := tree.OffsetPoint(0, 2, 0, 0, 1)
	status(t, err, mlrt.Argument, "")
	front := mlrt.Light{Position: [3]float32{0, 0, 1}}
	behind := mlrt.Light{Kind: mlrt.DirectionalLight, Position: [3]float32{0, 0, 1}}
	shadow := must(tree.ShadowRay(ray, hit, front))
	equal(t, shadow.Origin, front.Position)
	equal(t, *shadow.Skip, [2]uint32{0, 0})
	equal(t, must(tree.OccludedRay(*shadow, nil)), false)
	equal(t, must(tree.ShadowRay(ray, hit, behind)), nil)

	none := [2]uint32{mlrt.None, mlrt.None}
	points := mlrt.Points{
		Positions: mlrt.Slice([][3]float32{point, {0, 0, 6}, {0, 0, 5}}),
		Skip:      mlrt.Slice([][2]uint32{none, none, {0, 0}}), RowLength: 3,
	}
	equal(t, must(tree.OccludedPoints(ctx, points, front, nil)), []bool{false, true, false})
	equal(t, must(tree.OccludedPoints(ctx, mlrt.Points{Positions: mlrt.All(point)}, behind, nil)), []bool{true})
}

func TestAllHits(t *testing.T) {
	tree := build(t, mlrt.Mesh{Vertices: mlrt.Slice(walls)})
	rays := mlrt.Rays{Origins: mlrt.Slice([][3]float32{{}, {0, 0, 6}, {0, 50, 0}}), Directions: mlrt.Slice([][3]float32{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}})}
	lists := must(tree.AllHits(ctx, rays, nil, 2))
	equal(t, lists.Triangle, []uint32{0, 1, 1, mlrt.None, mlrt.None, mlrt.None})
	equal(t, lists.T[:3], []float32{5, 8, 2})
	equal(t, [][]uint32{lists.Total, lists.CrossingTotal}, [][]uint32{{2, 1, 0}, {2, 1, 0}})
	equal(t, lists.Crossing, []uint8{1, 1, 1, 0, 0, 0})
	equal(t, must(tree.AllHits(ctx, rays, nil, 0)).Total, lists.Total)
}

func TestSavedTrees(t *testing.T) {
	s := newScene()
	tree := build(t, s.meshes()...)
	hits := must(tree.Trace(ctx, s.rays(), nil))
	bytes := must(tree.Save())
	geometry := must(mlrt.HashGeometry(s.meshes()))
	logged := 0
	options := &mlrt.LoadOptions{GeometryHash: 1, MemoryLimit: 1 << 24, Log: func(mlrt.Level, string) { logged++ }}
	_, err := mlrt.Load(bytes, options)
	status(t, err, mlrt.BadData, "")
	equal(t, logged, 1)
	options.GeometryHash = geometry
	copied := must(mlrt.Load(bytes, options))
	defer copied.Close()
	equal(t, must(copied.Trace(ctx, s.rays(), nil)), hits)

	space := make([]byte, len(bytes)+64)
	at := (64 - uintptr(unsafe.Pointer(&space[0]))%64) % 64
	aligned := space[at : at+uintptr(len(bytes))]
	copy(aligned, bytes)
	inPlace := must(mlrt.LoadInPlace(aligned, nil))
	runtime.GC()
	equal(t, must(inPlace.Trace(ctx, s.rays(), nil)), hits)
	if must(inPlace.Info()).MemorySize > must(copied.Info()).MemorySize/10 {
		t.Error("copied")
	}
	inPlace.Close()
}

func TestProgressAndContext(t *testing.T) {
	s := newScene()
	last := 0.
	host := mlrt.Host{Progress: func(fraction float64) {
		if fraction < last {
			t.Error("back from", last, "to", fraction)
		}
		last = fraction
	}}
	tree := must(mlrt.Build(ctx, s.meshes(), &mlrt.TreeOptions{Host: host}))
	defer tree.Close()
	equal(t, last, 1)
	last = 0
	must(tree.Trace(ctx, s.rays(), &mlrt.TraceOptions{Host: host}))
	equal(t, last, 1)

	cancelled, cancel := context.WithCancel(ctx)
	many := mlrt.Rays{Origins: mlrt.All(s.origins[0]), Directions: mlrt.Slice(make([][3]float32, 4000000))}
	directions := make([][3]float32, 4000000)
	for i := range directions {
		directions[i] = [3]float32{0.5, 0.25, 0.125}
	}
	many.Directions = mlrt.Slice(directions)
	calls := 0
	options := &mlrt.TraceOptions{Method: mlrt.RayMethod, Host: mlrt.Host{Progress: func(fraction float64) {
		calls++
		cancel()
	}}}
	_, err := tree.Trace(cancelled, many, options)
	status(t, err, mlrt.Cancelled, "context canceled")
	if !errors.Is(err, context.Canceled) || calls == 0 {
		t.Error(err, calls)
	}
	_, err = mlrt.Build(cancelled, s.meshes(), nil)
	status(t, err, mlrt.Cancelled, "context canceled")
}

func TestPoolsKnowTheirThreads(t *testing.T) {
	all, two, jobs := must(mlrt.NewPool(0)), must(mlrt.NewPool(2)), must(mlrt.NewGoroutinePool(4))
	if all.Threads() < 1 {
		t.Errorf("%d threads, one per processor", all.Threads())
	}
	for _, pool := range []*mlrt.Pool{all, two, jobs} {
		pool.Close()
	}
	equal(t, []int{two.Threads(), jobs.Threads(), (*mlrt.Pool)(nil).Threads()}, []int{2, 4, 1})
}

func TestPoolsOfGoroutines(t *testing.T) {
	s := newScene()
	tree := build(t, s.meshes()...)
	hits := must(tree.Trace(ctx, s.rays(), nil))
	camera := mlrt.LookAt([3]float32{}, [3]float32{0, 0, 1}, [3]float32{0, 1, 0}, 60, 64, 64)
	for _, pool := range []*mlrt.Pool{
		must(mlrt.NewGoroutinePool(4)),
		must(mlrt.NewExecutorPool(4, func(job func()) { job() })),
		must(mlrt.NewExecutorPool(4, func(job func()) {})), // jobs that get lost
	} {
		options := &mlrt.TraceOptions{Pool: pool, InitialTileSize: 16, Outputs: mlrt.OutputT}
		for i := 0; i < 20; i++ {
			equal(t, must(tree.Trace(ctx, s.rays(), options)), hits)
		}
		// Within a job: no goroutine waits for one that waits for it.
		equal(t, tree.Render(ctx, camera, options, nil, func(*mlrt.Tile) error {
			equal(t, must(tree.Trace(ctx, s.rays(), options)), hits)
			return nil
		}), nil)
		pool.Close()
	}
}

func TestClosedMeansClosed(t *testing.T) {
	s := newScene()
	tree, pool := must(mlrt.Build(ctx, s.meshes(), nil)), must(mlrt.NewPool(2))
	pool.Close()
	if _, err := tree.Trace(ctx, s.rays(), &mlrt.TraceOptions{Pool: pool}); err != mlrt.ErrClosed {
		t.Error(err)
	}
	tree.Close()
	tree.Close()
	if _, err := tree.Trace(ctx, s.rays(), nil); err != mlrt.ErrClosed {
		t.Error(err)
	}
	if _, err := tree.Info(); err != mlrt.ErrClosed {
		t.Error(err)
	}
	tree, pool = nil, nil
	runtime.GC() // finalizers of what is closed do nothing
}

// Without memory for results, which would be too much of it.
func TestCountsThatTheLibraryRefuses(t *testing.T) {
	tree := build(t, mlrt.Mesh{Vertices: mlrt.Slice(walls)})
	for _, shared := range []int{1 << 31, 1 << 33, 1 << 62} { // times 4 it is 0
		rays := mlrt.Rays{Origins: mlrt.Slice(make([][3]float32, 4)), Directions: mlrt.All([3]float32{0, 0, 1}), RaysPerOrigin: shared}
		_, err := tree.Trace(ctx, rays, nil)
		status(t, err, mlrt.TooLarge, "rays.count")
		_, err = tree.Occluded(ctx, rays, nil)
		status(t, err, mlrt.TooLarge, "rays.count")
		_, err = tree.AllHits(ctx, rays, nil, 2)
		status(t, err, mlrt.TooLarge, "rays.count")
		status(t, tree.AllHitsInto(ctx, rays, nil, mlrt.HitListArrays{}), mlrt.TooLarge, "rays.count")
	}
	rays := mlrt.Rays{Origins: mlrt.All([3]float32{}), Directions: mlrt.Slice(make([][3]float32, 4000))}
	_, err := tree.AllHits(ctx, rays, nil, 1<<32-1) // more than there are addresses
	status(t, err, mlrt.OutOfMemory, "17179869180000 results")
	camera := mlrt.LookAt([3]float32{}, [3]float32{0, 0, 5}, [3]float32{0, 1, 0}, 60, 1<<23, 1<<23)
	_, err = tree.RenderHits(ctx, camera, nil)
	status(t, err, mlrt.TooLarge, "pixels")
	_, _, err = camera.Rays()
	status(t, err, mlrt.TooLarge, "pixels")
	camera.Crop = [4]int{0, 0, 1<<32 - 1, 1<<32 - 1} // whose product is negative
	_, err = tree.RenderHits(ctx, camera, nil)
	status(t, err, mlrt.BadCamera, "crop_width")

	// Of these C would take the low bits.
	rays = mlrt.NewRays(walls, walls)
	_, err = tree.Trace(ctx, rays, &mlrt.TraceOptions{Method: 1<<32 + 1})
	status(t, err, mlrt.Argument, "method")
	_, err = mlrt.Build(ctx, nil, &mlrt.TreeOptions{Preset: 1 << 32})
	status(t, err, mlrt.Argument, "preset")
	_, err = tree.OffsetPoint(0, 0, 0, 0, 1<<32+1)
	status(t, err, mlrt.Argument, "side")
}

func TestMeshesSayWhatTheirTrianglesAre(t *testing.T) {
	for _, none := range [][][3]uint32{nil, {}} { // not: the vertices, three by three
		equal(t, must(build(t, mlrt.NewMesh(walls, none)).Info()).Triangles, 0)
	}
	for words, mesh := range map[string]mlrt.Mesh{
		"one element for all": {Vertices: mlrt.All(walls[0])},
		"5 are not three":     {Vertices: mlrt.Slice(walls[:5])},
		"Triangles, too": {
			Vertices: mlrt.Slice(walls), Triangles: mlrt.Slice([][3]uint32{{0, 1, 2}}), ShortTriangles: mlrt.Slice([][3]uint16{{3, 4, 5}}),
		},
	} {
		_, err := mlrt.Build(ctx, []mlrt.Mesh{mesh}, nil)
		status(t, err, mlrt.Argument, words)
		_, err = mlrt.BuildKdTree(ctx, []mlrt.Mesh{mesh}, nil)
		status(t, err, mlrt.Argument, words)
		_, err = mlrt.HashGeometry([]mlrt.Mesh{mesh})
		status(t, err, mlrt.Argument, words)
		_, err = mlrt.EstimateTree([]mlrt.Mesh{mesh}, nil)
		status(t, err, mlrt.Argument, words)
		_, err = mlrt.EstimateKdTree([]mlrt.Mesh{mesh}, nil)
		status(t, err, mlrt.Argument, words)
	}
	defer func() { equal(t, recover(), any("mlrt.Field: the structs contain pointers")) }()
	mlrt.Field(make([]any, 1), func(*any) *float32 { return nil })
}

func TestResultsThatShareMemory(t *testing.T) {
	s := newScene()
	tree := build(t, s.meshes()...)
	hits := must(tree.Trace(ctx, s.rays(), nil))
	type record struct {
		origin, direction [3]float32
		t, u              float32
	}
	records, room := make([]record, 1001), make([]float32, 2000)
	for i := range s.origins {
		records[i].origin, records[i].direction = s.origins[i], s.directions[i]
	}
	field := func(records []record, field func(*record) *float32) mlrt.Array[float32] {
		return mlrt.Field(records, field)
	}
	first := func(r *record) *float32 { return &r.t }
	strided := mlrt.Rays{
		Origins:    mlrt.Field(records[:1000], func(r *record) *[3]float32 { return &r.origin }),
		Directions: mlrt.Field(records[:1000], func(r *record) *[3]float32 { return &r.direction }),
	}
	words := unsafe.Slice((*uint32)(unsafe.Pointer(&room[0])), len(room))
	for name, into := range map[string]mlrt.HitArrays{
		"one":    {T: mlrt.Slice(room[:1000]), U: mlrt.Slice(room[999:])},
		"types":  {T: mlrt.Slice(room[:1000]), Mesh: mlrt.Slice(words[999:])},
		"fields": {T: field(records, first), U: field(records[1:], first)},
		"inputs": {T: field(records, func(r *record) *float32 { return &r.direction[2] })},
		"mixed":  {T: mlrt.Slice(unsafe.Slice(&records[0].t, 1000))},
		"other":  {T: field(records, first), U: mlrt.Slice(unsafe.Slice(&records[0].u, 1000))},
	} {
		t.Run(name, func(t *testing.T) {
			status(t, tree.TraceInto(ctx, strided, nil, into), mlrt.Argument, "shares memory")
		})
	}
	total := mlrt.HitListArrays{Total: mlrt.Slice(words[:1000]), CrossingTotal: mlrt.Slice(words[1:])}
	status(t, tree.AllHitsInto(ctx, s.rays(), nil, total), mlrt.Argument, "shares memory")
	positions := s.origins[:1000]
	bytes := unsafe.Slice((*uint8)(unsafe.Pointer(&positions[0])), 1000)
	err := tree.OccludedPointsInto(ctx, mlrt.Points{Positions: mlrt.Slice(positions)}, mlrt.Light{}, nil, mlrt.Slice(bytes))
	status(t, err, mlrt.Argument, "shares memory")
	status(t, tree.TraceInto(ctx, s.rays(), nil, mlrt.HitArrays{T: mlrt.All[float32](0)}), mlrt.Argument, "one element")

	// Those side by side do not.
	second := func(r *record) *float32 { return &r.u }
	equal(t, tree.TraceInto(ctx, strided, nil, mlrt.HitArrays{T: field(records, first), U: field(records, second), V: mlrt.Slice(room[:1000])}), nil)
	equal(t, tree.TraceInto(ctx, s.rays(), nil, mlrt.HitArrays{T: mlrt.Slice(room[:1000]), U: mlrt.Slice(room[1000:])}), nil)
	for i := range hits.T {
		equal(t, [4]float32{records[i].t, records[i].u, room[i], room[1000+i]}, [4]float32{hits.T[i], hits.U[i], hits.T[i], hits.U[i]})
	}

	camera := mlrt.LookAt([3]float32{0, 0, -30}, [3]float32{}, [3]float32{0, 1, 0}, 45, 40, 25)
	picture := must(tree.RenderHits(ctx, camera, nil))
	for words, into := range map[string]mlrt.HitArrays{
		"shares memory":      {T: mlrt.Slice(room).Rows(80), U: mlrt.Slice(room[39:]).Rows(80)},
		"overlap":            {T: mlrt.Slice(room).Rows(39)},
		"begin every -40":    {T: mlrt.Slice(room).Rows(-40)},
		"too short":          {T: mlrt.Slice(room).Rows(1 << 62)},
		"too short for 25 r": {T: mlrt.Slice(room[:24*80+39]).Rows(80)},
	} {
		status(t, tree.Render(ctx, camera, nil, &into, nil), mlrt.Argument, words)
	}
	into := mlrt.HitArrays{T: mlrt.Slice(room[:24*80+40]).Rows(80), U: mlrt.Slice(room[40:]).Rows(80)}
	equal(t, tree.Render(ctx, camera, nil, &into, nil), nil)
	for i := range picture.T {
		equal(t, [2]float32{room[i/40*80+i%40], room[i/40*80+40+i%40]}, [2]float32{picture.T[i], picture.U[i]})
	}
}

// within fails if a function takes longer.
func within(t *testing.T, limit time.Duration, function func()) {
	t.Helper()
	done := make(chan struct{})
	go func() {
		defer close(done)
		function()
	}()
	select {
	case <-done:
	case <-time.After(limit):
		t.Fatal("it does not end")
	}
}

func TestCallbacksThatWouldWaitForTheirCall(t *testing.T) {
	s := newScene()
	camera := mlrt.LookAt([3]float32{0, 0, -30}, [3]float32{}, [3]float32{0, 1, 0}, 45, 64, 64)
	many := mlrt.Rays{Origins: mlrt.All([3]float32{}), Directions: mlrt.Slice(make([][3]float32, 100000))}
	pool, counters := must(mlrt.NewPool(2)), &mlrt.Counters{}
	options := &mlrt.TraceOptions{Outputs: mlrt.OutputT, InitialTileSize: 16, Pool: pool, Counters: counters}
	trace := func(tree *mlrt.Tree, options *mlrt.TraceOptions) error {
		_, err := tree.Trace(ctx, many, options)
		return err
	}
	for name, callback := range map[string]func(*mlrt.Tree) error{
		"Close: a call that uses it":        func(tree *mlrt.Tree) error { return tree.Close() },
		"Close: a call that uses":           func(*mlrt.Tree) error { return pool.Close() },
		"options.Pool: its threads make th": func(tree *mlrt.Tree) error { return trace(tree, &mlrt.TraceOptions{Pool: pool}) },
		"Close: a call": func(tree *mlrt.Tree) error { // in a call within a callback
			return tree.Render(ctx, camera, &mlrt.TraceOptions{Outputs: mlrt.OutputT}, nil, func(*mlrt.Tile) error { return pool.Close() })
		},
		"used after Close": func(tree *mlrt.Tree) error {
			go tree.Close() // which waits for the render
			for trace(tree, nil) == nil {
			}
			return trace(tree, nil)
		},
	} {
		within(t, time.Minute, func() {
			tree := must(mlrt.Build(ctx, s.meshes(), nil))
			defer tree.Close()
			err := tree.Render(ctx, camera, options, nil, func(*mlrt.Tile) error { return callback(tree) })
			status(t, err, mlrt.Cancelled, name)
		})
	}
	within(t, time.Minute, func() {
		tree := must(mlrt.Build(ctx, s.meshes(), nil))
		defer tree.Close()
		before := counters.Counts().Rays
		equal(t, tree.Render(ctx, camera, options, nil, func(*mlrt.Tile) error {
			counters.Counts()
			return trace(tree, &mlrt.TraceOptions{Counters: counters})
		}), nil)
		equal(t, counters.Counts().Rays-before, 64*64+16*100000)
	})
	equal(t, pool.Close(), nil)
}

// Neither memory that a tree in place was to use, nor a tree that was made before its log panicked.
func TestPanicsLeaveNothingBehind(t *testing.T) {
	s := newScene()
	bytes := must(build(t, s.meshes()...).Save())
	bytes[len(bytes)-1] ^= 1
	panics := func(mlrt.Level, string) { panic("in the log") }
	for _, call := range []func(){
		func() { mlrt.LoadInPlace(bytes, &mlrt.LoadOptions{Log: panics}) },
		func() { mlrt.Build(ctx, s.meshes(), &mlrt.TreeOptions{Host: mlrt.Host{Log: panics}}) },
	} {
		func() {
			defer func() { equal(t, recover(), any("in the log")) }()
			call()
		}()
	}
	for i := 0; i < 3; i++ { // ends the program if memory is pinned that nobody can unpin
		runtime.GC()
		time.Sleep(10 * time.Millisecond)
	}
}

func TestCallbacksThatEndTheirGoroutine(t *testing.T) {
	if os.Getenv("MLRT_GOEXIT") != "" {
		tree := build(t, mlrt.Mesh{Vertices: mlrt.Slice(walls)})
		camera := mlrt.LookAt([3]float32{}, [3]float32{0, 0, 5}, [3]float32{0, 1, 0}, 60, 64, 64)
		tree.Render(ctx, camera, &mlrt.TraceOptions{Outputs: mlrt.OutputT}, nil, func(*mlrt.Tile) error { runtime.Goexit(); return nil })
	}
	command := exec.Command(os.Args[0], "-test.run=^TestCallbacksThatEndTheirGoroutine$")
	command.Env = append(os.Environ(), "MLRT_GOEXIT=1")
	output, err := command.CombinedOutput()
	if err == nil || !strings.Contains(string(output), "a callback called runtime.Goexit") {
		t.Errorf("%v: %s", err, output)
	}
}

func TestNoRaysAreCallsLikeOthers(t *testing.T) {
	tree := must(mlrt.Build(ctx, nil, nil))
	equal(t, len(must(tree.OccludedPoints(ctx, mlrt.Points{}, mlrt.Light{}, nil))), 0)
	tree.Close()
	for _, call := range []func() error{
		func() error { _, err := tree.Trace(ctx, mlrt.Rays{}, nil); return err },
		func() error { _, err := tree.AllHits(ctx, mlrt.Rays{}, nil, 1); return err },
		func() error { _, err := tree.OccludedPoints(ctx, mlrt.Points{}, mlrt.Light{}, nil); return err },
	} {
		equal(t, call(), mlrt.ErrClosed)
	}
	if _, err := mlrt.NewExecutorPool(2, nil); !errors.Is(err, mlrt.Argument) {
		t.Error(err)
	}
}
