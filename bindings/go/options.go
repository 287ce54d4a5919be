// SPDX-License-Identifier: MIT

package mlrt

// #include "bridge.h"
import "C"

import (
	"sync"
	"unsafe"
)

// A Preset is one of mlrt_tree_options.
type Preset int

// Presets of Build.
const (
	DefaultTree = Preset(C.MLRT_TREE_DEFAULT) // faster to render than FastTree, slower than BestTree
	FastTree    = Preset(C.MLRT_TREE_FAST)    // built fastest, for scenes that change
	BestTree    = Preset(C.MLRT_TREE_BEST)    // renders fastest, for many pictures of one scene
)

// TreeOptions say how to build a hierarchy of boxes. Their zero values are the defaults.
type TreeOptions struct {
	Preset           Preset
	TraversalCost    float32 // of a node, 0..1e6, in units of a leaf's; 0 = 1
	IntersectionCost float32 // of a triangle in a leaf, 0..1e6; 0 = a small share of the leaf's
	MemoryLimit      uint64  // most bytes held at one time; 0 = no limit
	Pool             *Pool   // whose threads build; nil = the calling thread alone
	Host             Host
}

// A KdTreePreset is one of mlrt_kdtree_options.
type KdTreePreset int

// Presets of BuildKdTree.
const (
	PaperKdTree = KdTreePreset(C.MLRT_KDTREE_PAPER) // the paper's
	TunedKdTree = KdTreePreset(C.MLRT_KDTREE_TUNED) // larger leaves, smaller cells
)

// Rules are those of the kd-tree's builder.
type Rules uint32

// Rules of the kd-tree's builder, which can be or-ed together.
const (
	EmptySpace    = Rules(C.MLRT_RULE_EMPTY_SPACE)    // an empty side of more than 10 % of a cell is cut off first
	Coplanar      = Rules(C.MLRT_RULE_COPLANAR)       // a plane that triangles in it cover wholly is a split
	MinimumCell   = Rules(C.MLRT_RULE_MINIMUM_CELL)   // cells under a minimum size are not split
	ClippedSplits = Rules(C.MLRT_RULE_CLIPPED_SPLITS) // candidates come from triangles clipped to the cell
	Retraction    = Rules(C.MLRT_RULE_RETRACTION)     // a subtree that costs more than a leaf becomes a leaf
)

// KdTreeOptions say how to build the paper's kd-tree.
type KdTreeOptions struct {
	Preset           KdTreePreset
	TraversalCost    float32 // of a step, 0..1e6, relative to IntersectionCost; 0 = the preset's
	IntersectionCost float32 // of a triangle, 0..1e6; 0 = the preset's
	MemoryLimit      uint64  // most bytes held at one time; 0 = no limit
	MaxReferences    uint64  // most leaf entries; 0 = 8 per triangle + 1024
	MaxDepth         int     // most inner nodes above a leaf, 1..60; 0 = by the number of triangles
	RulesOff         Rules   // rules to do without
	Pool             *Pool   // whose threads build; nil = the calling thread alone
	Host             Host
}

// LoadOptions say how to load a saved tree.
type LoadOptions struct {
	GeometryHash uint64 // the HashGeometry of the meshes that it must be of; 0 = any
	MemoryLimit  uint64 // most bytes held at one time; 0 = no limit
	Log          func(level Level, message string)
}

// A Query is what rays are asked.
type Query int

// Queries.
const (
	ClosestHit = Query(C.MLRT_QUERY_CLOSEST) // all results but Occluded
	AnyHit     = Query(C.MLRT_QUERY_ANY)     // only Occluded
)

// A Method is a way to trace. All give the same answers.
type Method int

// Methods.
const (
	DefaultMethod = Method(C.MLRT_METHOD_DEFAULT)    // TileMethod for boxes, Multilevel for kd-trees
	RayMethod     = Method(C.MLRT_METHOD_RAY)        // one ray at a time, in double: the reference
	Packet2       = Method(C.MLRT_METHOD_PACKET2)    // kd-trees: 2x2 rays with masks
	Packet4       = Method(C.MLRT_METHOD_PACKET4)    // kd-trees: 4x4 rays from the root
	Multilevel    = Method(C.MLRT_METHOD_MULTILEVEL) // kd-trees: 4x4 rays from entry points of beams
	TileMethod    = Method(C.MLRT_METHOD_TILE)       // boxes: tiles of 16 packets of 16 rays
)

// An ISA is an instruction set. All give the same answers.
type ISA int

// Instruction sets.
const (
	AutoISA = ISA(C.MLRT_ISA_AUTO)   // the best that this machine has
	Scalar  = ISA(C.MLRT_ISA_SCALAR) // plain C, where the processor has neither SSE2 nor NEON
	SSE     = ISA(C.MLRT_ISA_SSE)    // SSE2
	AVX2    = ISA(C.MLRT_ISA_AVX2)   // AVX2 and FMA
	AVX512  = ISA(C.MLRT_ISA_AVX512) // AVX-512 F and DQ
	NEON    = ISA(C.MLRT_ISA_NEON)   // NEON, on aarch64
)

// Culling is how method Multilevel tests a beam against a cell.
type Culling int

// Kinds of culling.
const (
	InverseCulling = Culling(C.MLRT_CULLING_INVERSE) // the planes of the cell against the beam
	DirectCulling  = Culling(C.MLRT_CULLING_DIRECT)  // the planes of the beam against the cell
)

// Shortcuts are those that method Multilevel takes beyond the paper.
type Shortcuts uint32

// Shortcuts, which can be or-ed together.
const (
	WholeTiles   = Shortcuts(C.MLRT_SHORTCUT_WHOLE_TILES)   // a tile that one triangle covers is done at once
	EntryLists   = Shortcuts(C.MLRT_SHORTCUT_ENTRY_LISTS)   // packets start at a list of leaves
	SharedSetups = Shortcuts(C.MLRT_SHORTCUT_SHARED_SETUPS) // terms of a triangle and an origin are kept
)

// Outputs are results that a tile callback receives.
type Outputs uint32

// Outputs, which can be or-ed together.
const (
	OutputT        = Outputs(C.MLRT_OUTPUT_T)        // T
	OutputUV       = Outputs(C.MLRT_OUTPUT_UV)       // U and V
	OutputIDs      = Outputs(C.MLRT_OUTPUT_IDS)      // MeshID and Triangle
	OutputFacing   = Outputs(C.MLRT_OUTPUT_FACING)   // Facing
	OutputTriangle = Outputs(C.MLRT_OUTPUT_TRIANGLE) // Triangle without MeshID
	OutputOccluded = Outputs(C.MLRT_OUTPUT_OCCLUDED) // with lights: Occluded
)

// A LightKind is a point or a direction.
type LightKind int

// Kinds of lights.
const (
	PointLight       = LightKind(C.MLRT_LIGHT_POINT)       // at Position
	DirectionalLight = LightKind(C.MLRT_LIGHT_DIRECTIONAL) // far away in the direction Position, of any length
)

// A Light throws shadows.
type Light struct {
	Kind     LightKind
	Position [3]float32
}

func (light Light) toC() C.mlrt_light {
	out := C.mlrt_light{struct_size: C.sizeof_mlrt_light, kind: code(light.Kind)}
	out.position = vector(light.Position)
	return out
}

func vector(v [3]float32) [3]C.float {
	return [3]C.float{C.float(v[0]), C.float(v[1]), C.float(v[2])}
}

// Counters count the work of tracing: mlrt_counters of mlrt.h has what each means. Each call adds to them. They may be
// used by several goroutines.
type Counters struct {
	mutex  sync.Mutex
	counts C.mlrt_counters
}

// add adds the counts of a call.
func (counters *Counters) add(counts *C.mlrt_counters) {
	counters.mutex.Lock()
	defer counters.mutex.Unlock()
	const numbers = (C.sizeof_mlrt_counters - 8) / 8 // behind struct_size and reserved
	sums := (*[numbers]uint64)(unsafe.Pointer(&counters.counts.ray_count))
	for i, count := range (*[numbers]uint64)(unsafe.Pointer(&counts.ray_count)) {
		sums[i] += count
	}
}

// Counts are the values of Counters.
type Counts struct {
	Rays, Packets, Beams, Cells, EntryPointCells, TriangleTests, JudgedLanes, EntryPoints, EntryPointDepthSum, MissedBeams,
	CoveredBeams, UndecidedCulls, UndecidedChecked, LaneTests, UndecidedTests, TieLanes, ExactEdges, ExactRanges,
	ExactOrders uint64
}

// Counts returns what has been counted.
func (counters *Counters) Counts() Counts {
	counters.mutex.Lock()
	defer counters.mutex.Unlock()
	c := &counters.counts
	return Counts{
		Rays: uint64(c.ray_count), Packets: uint64(c.packet_count), Beams: uint64(c.beam_count),
		Cells: uint64(c.cell_count), EntryPointCells: uint64(c.entry_point_cell_count),
		TriangleTests: uint64(c.triangle_test_count), JudgedLanes: uint64(c.judged_lane_count),
		EntryPoints: uint64(c.entry_point_count), EntryPointDepthSum: uint64(c.entry_point_depth_sum),
		MissedBeams: uint64(c.missed_beam_count), CoveredBeams: uint64(c.covered_beam_count),
		UndecidedCulls: uint64(c.undecided_cull_count), UndecidedChecked: uint64(c.undecided_checked_count),
		LaneTests: uint64(c.lane_test_count), UndecidedTests: uint64(c.undecided_test_count),
		TieLanes: uint64(c.tie_lane_count), ExactEdges: uint64(c.exact_edge_count),
		ExactRanges: uint64(c.exact_range_count), ExactOrders: uint64(c.exact_order_count),
	}
}

// TraceOptions say how to trace. Their zero values are the defaults.
type TraceOptions struct {
	Query           Query // of TraceInto and Render; other methods say by their names what they ask
	Method          Method
	ISA             ISA
	Culling         Culling   // Multilevel: how beams are tested against cells
	CullingCheck    bool      // Multilevel: check undecided cells against all their faces
	InitialTileSize int       // pixels, 4..1024, a power of two; 0 = by source and method
	MinimumTileSize int       // Multilevel: pixels, 4..InitialTileSize, a power of two; 0 = default
	SplitFactor     int       // Multilevel: 4 or 16; 0 = 16
	Outputs         Outputs   // what the callback of Render receives
	ShortcutsOff    Shortcuts // Multilevel: shortcuts to do without
	Mask            uint32    // rays see the meshes whose mask has a bit in common with it; 0 = all bits
	Pool            *Pool     // whose threads trace; nil = the calling thread alone
	Counters        *Counters // counts the work, with narrower kernels
	Lights          []Light   // Render of closest hits: 8 at most, whose shadows Occluded receives
	Host            Host
}
