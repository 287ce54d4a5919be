// SPDX-License-Identifier: MIT

package mlrt_test

import (
	"encoding/binary"
	"errors"
	"fmt"
	"hash/fnv"
	"math"
	"reflect"
	"runtime"
	"strings"
	"sync"
	"testing"

	"mlrt"
)

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
func scene() (meshes []mlrt.Mesh, origins, directions [][3]float32) {
	d := draw(1)
	for _, id := range []uint32{7, 3} {
		mesh := mlrt.Mesh{ID: id, Vertices: make([][3]float32, 100), Triangles: make([][3]uint32, 150)}
		for i := range mesh.Vertices {
			mesh.Vertices[i] = d.point(256)
		}
		for i := range mesh.Triangles {
			mesh.Triangles[i] = [3]uint32{d.number() % 100, d.number() % 100, d.number() % 100}
		}
		meshes = append(meshes, mesh)
	}
	for i := 0; i < 1000; i++ {
		origins = append(origins, d.point(256))
		directions = append(directions, d.point(2048))
		for k := 0; k < 3 && i%4 == 3; k++ {
			directions[i][k] = meshes[0].Vertices[i%100][k] - origins[i][k]
		}
	}
	return meshes, origins, directions
}

func must[T any](value T, err error) T {
	if err != nil {
		panic(err)
	}
	return value
}

func TestTheSameAnswers(t *testing.T) {
	meshes, origins, directions := scene()
	tree, pool := must(mlrt.NewTree(meshes...)), must(mlrt.NewPool(2))
	defer tree.Close()
	defer pool.Close()
	hits := must(tree.Trace(origins, directions, nil))
	occluded := must(tree.Occluded(origins, directions, pool))
	for i, yes := range occluded {
		if yes != (hits.Mesh[i] != mlrt.None) {
			t.Fatalf("ray %d: any hit is not the closest hit", i)
		}
	}
	var group sync.WaitGroup
	for i := 0; i < 4; i++ {
		group.Add(1)
		go func() {
			defer group.Done()
			if !reflect.DeepEqual(must(tree.Trace(origins, directions, pool)), hits) {
				t.Error("a pool changes the answers")
			}
		}()
	}
	group.Wait()
	fmt.Printf("\n%016x\n", hash(hits))
}

func TestErrorsSayWhatIsWrong(t *testing.T) {
	wrong := mlrt.Mesh{Vertices: make([][3]float32, 3), Triangles: [][3]uint32{{0, 1, 2}, {0, 1, 3}}}
	var e *mlrt.Error
	_, err := mlrt.NewTree(wrong)
	if !errors.As(err, &e) || e.Status != mlrt.ErrorIndexRange || !strings.Contains(err.Error(), "triangle 1: vertex index 3") {
		t.Error(err)
	}
	if _, err = mlrt.NewPool(5000); !errors.As(err, &e) || e.Status != mlrt.ErrorArgument {
		t.Error(err)
	}
	if _, err = must(mlrt.NewTree()).Trace(make([][3]float32, 1), nil, nil); !errors.As(err, &e) {
		t.Error(err)
	}
}

func TestClosedMeansClosed(t *testing.T) {
	meshes, origins, directions := scene()
	tree, pool := must(mlrt.NewTree(meshes...)), must(mlrt.NewPool(2))
	pool.Close()
	if _, err := tree.Trace(origins, directions, pool); err != mlrt.ErrClosed {
		t.Error(err)
	}
	tree.Close()
	tree.Close()
	if _, err := tree.Trace(origins, directions, nil); err != mlrt.ErrClosed {
		t.Error(err)
	}
	tree, pool = nil, nil
	runtime.GC() // finalizers of what is closed do nothing
}
