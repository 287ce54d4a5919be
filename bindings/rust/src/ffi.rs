// SPDX-License-Identifier: MIT
//! The C interface, as in `mlrt.h`. `Default` of a struct sets its `struct_size`; all else is 0.
//!
//! Written by make_ffi.py: change the header instead.

use std::ffi::{c_char, c_void};
use std::marker::{PhantomData, PhantomPinned};

/// The stride of an input array whose one element serves all rays.
pub const MLRT_STRIDE_ALL: usize = usize::MAX;

/// The id that is reported for a miss. In a `skip` element it means that nothing is skipped.
pub const MLRT_NONE: u32 = 0xFFFFFFFF;

/// success
pub const MLRT_OK: i32 = 0;

/// a pointer that must not be NULL is, or a value is out of its range
pub const MLRT_ERROR_ARGUMENT: i32 = 1;

/// a struct_size is not set, or not of any version
pub const MLRT_ERROR_STRUCT_SIZE: i32 = 2;

/// a triangle names a vertex that does not exist: see mlrt_tree_options.message
pub const MLRT_ERROR_INDEX_RANGE: i32 = 3;

/// an allocation failed, or a memory_limit was reached; nothing was kept
pub const MLRT_ERROR_OUT_OF_MEMORY: i32 = 4;

/// more meshes, triangles, rays or pixels than 32-bit counts allow
pub const MLRT_ERROR_TOO_LARGE: i32 = 5;

/// camera of size zero, crop outside it, numbers not finite (t_min, t_max: NaN), a direction of 0 (of a parallel camera), or dx and dy parallel
pub const MLRT_ERROR_CAMERA: i32 = 6;

/// an instruction set that this machine or build does not have, or a method of the other structure (MLRT_STRUCTURE_\*)
pub const MLRT_ERROR_UNSUPPORTED: i32 = 7;

/// the system would not start a thread
pub const MLRT_ERROR_THREAD: i32 = 8;

/// a tile callback or a host's progress function asked to stop
pub const MLRT_ERROR_CANCELLED: i32 = 9;

/// no saved tree, or one that is damaged, of another version, or of other triangles
pub const MLRT_ERROR_DATA: i32 = 10;

/// this build has MLRT_ISA_SSE, and this machine can run it
pub const MLRT_CAN_SSE: u64 = 1;

/// the same of MLRT_ISA_AVX2
pub const MLRT_CAN_AVX2: u64 = 2;

/// the same of MLRT_ISA_AVX512
pub const MLRT_CAN_AVX512: u64 = 4;

/// the same of MLRT_ISA_NEON
pub const MLRT_CAN_NEON: u64 = 8;

/// mlrt_host
pub const MLRT_STRUCT_HOST: usize = 0;

/// mlrt_mesh
pub const MLRT_STRUCT_MESH: usize = 1;

/// mlrt_tree_options
pub const MLRT_STRUCT_TREE_OPTIONS: usize = 2;

/// mlrt_tree_info
pub const MLRT_STRUCT_TREE_INFO: usize = 3;

/// mlrt_memory_estimate
pub const MLRT_STRUCT_MEMORY_ESTIMATE: usize = 4;

/// mlrt_load_options
pub const MLRT_STRUCT_LOAD_OPTIONS: usize = 5;

/// mlrt_pool_options
pub const MLRT_STRUCT_POOL_OPTIONS: usize = 6;

/// mlrt_counters
pub const MLRT_STRUCT_COUNTERS: usize = 7;

/// mlrt_trace_options
pub const MLRT_STRUCT_TRACE_OPTIONS: usize = 8;

/// mlrt_array
pub const MLRT_STRUCT_ARRAY: usize = 9;

/// mlrt_hits
pub const MLRT_STRUCT_HITS: usize = 10;

/// mlrt_const_array
pub const MLRT_STRUCT_CONST_ARRAY: usize = 11;

/// mlrt_rays
pub const MLRT_STRUCT_RAYS: usize = 12;

/// mlrt_ray
pub const MLRT_STRUCT_RAY: usize = 13;

/// mlrt_hit
pub const MLRT_STRUCT_HIT: usize = 14;

/// mlrt_hit_lists
pub const MLRT_STRUCT_HIT_LISTS: usize = 15;

/// mlrt_camera
pub const MLRT_STRUCT_CAMERA: usize = 16;

/// mlrt_tile
pub const MLRT_STRUCT_TILE: usize = 17;

/// mlrt_light
pub const MLRT_STRUCT_LIGHT: usize = 18;

/// mlrt_points
pub const MLRT_STRUCT_POINTS: usize = 19;

/// mlrt_kdtree_options
pub const MLRT_STRUCT_KDTREE_OPTIONS: usize = 20;

/// the reason why a call fails
pub const MLRT_LOG_ERROR: i32 = 0;

/// something was left out
pub const MLRT_LOG_WARNING: i32 = 1;

/// a tree was built, its size and time; or the host stopped a call
pub const MLRT_LOG_INFO: i32 = 2;

/// the paper's kd-tree, by mlrt_build_kdtree: for study, and for the paper's tables
pub const MLRT_STRUCTURE_KDTREE: u32 = 1;

/// a hierarchy of boxes, by mlrt_build_tree: for all else. 16 boxes a node, up to 16 triangles a leaf
pub const MLRT_STRUCTURE_BVH: u32 = 2;

/// faster to render than FAST, slower than BEST
pub const MLRT_TREE_DEFAULT: i32 = 0;

/// built fastest, for scenes that change
pub const MLRT_TREE_FAST: i32 = 1;

/// renders fastest, for many pictures of one scene: takes more memory and time to build
pub const MLRT_TREE_BEST: i32 = 2;

/// the paper's, as far as the paper tells. It stays as it is, for comparisons
pub const MLRT_KDTREE_PAPER: i32 = 0;

/// larger leaves, smaller cells: renders faster, takes longer to build
pub const MLRT_KDTREE_TUNED: i32 = 1;

/// an empty side of more than 10 % of a cell is cut off first
pub const MLRT_RULE_EMPTY_SPACE: u32 = 1;

/// a plane that triangles in it cover wholly is a split; they go to the smaller side
pub const MLRT_RULE_COPLANAR: u32 = 2;

/// cells under a minimum size are not split
pub const MLRT_RULE_MINIMUM_CELL: u32 = 4;

/// candidates come from triangles clipped to the cell, not from bounding boxes
pub const MLRT_RULE_CLIPPED_SPLITS: u32 = 8;

/// a subtree that costs more than a leaf becomes a leaf
pub const MLRT_RULE_RETRACTION: u32 = 16;

/// use the data where it lies: it must stay unchanged until the tree is destroyed
pub const MLRT_LOAD_IN_PLACE: u32 = 1;

/// boxes: TILE; kd-tree: MULTILEVEL, the paper's
pub const MLRT_METHOD_DEFAULT: i32 = 0;

/// one ray at a time in double, plain C: the reference
pub const MLRT_METHOD_RAY: i32 = 1;

/// kd-tree: 2x2 rays with masks (I. Wald et al., "Interactive Rendering with Coherent Ray Tracing", 2001)
pub const MLRT_METHOD_PACKET2: i32 = 2;

/// kd-tree: 4x4 rays by interval traversal from the root (the paper, section 4.3)
pub const MLRT_METHOD_PACKET4: i32 = 3;

/// kd-tree: the same from entry points of beams (the paper, sections 3.3 to 4.2)
pub const MLRT_METHOD_MULTILEVEL: i32 = 4;

/// boxes: a tile of 16 packets of 16 rays goes down together, as a bundle. Pictures of a pinhole camera, and any-hit rays with one origin or direction, begin with bundles of 16 tiles, which need no rays. Packets too wide for a bundle go lane by lane; where few rays meet a box, each goes alone
pub const MLRT_METHOD_TILE: i32 = 5;

/// the best that this machine has
pub const MLRT_ISA_AUTO: i32 = 0;

/// plain C: only in builds without SSE2 and NEON, which have no other
pub const MLRT_ISA_SCALAR: i32 = 1;

/// SSE2, on every x86-64: 4 boxes, packets, triangles or rays at a time
pub const MLRT_ISA_SSE: i32 = 2;

/// AVX2 and FMA: 8 at a time
pub const MLRT_ISA_AVX2: i32 = 3;

/// AVX-512 F and DQ: 16 at a time
pub const MLRT_ISA_AVX512: i32 = 4;

/// NEON, on every aarch64 (little-endian), which has no other: 4 at a time
pub const MLRT_ISA_NEON: i32 = 5;

/// the closest hit: writes all of mlrt_hits but `occluded`
pub const MLRT_QUERY_CLOSEST: i32 = 0;

/// whether there is a hit: writes only mlrt_hits.occluded
pub const MLRT_QUERY_ANY: i32 = 1;

/// the planes of the cell against the beam
pub const MLRT_CULLING_INVERSE: i32 = 0;

/// the planes of the beam against the cell
pub const MLRT_CULLING_DIRECT: i32 = 1;

/// a tile that one triangle provably covers, nearer than all else, is done at once
pub const MLRT_SHORTCUT_WHOLE_TILES: u32 = 1;

/// packets start at a list of leaves, not at the one node above them all
pub const MLRT_SHORTCUT_ENTRY_LISTS: u32 = 2;

/// terms of a triangle and an origin are kept for the packets that follow; so does method packet4
pub const MLRT_SHORTCUT_SHARED_SETUPS: u32 = 4;

/// t
pub const MLRT_OUTPUT_T: u32 = 1;

/// u and v
pub const MLRT_OUTPUT_UV: u32 = 2;

/// mesh and triangle
pub const MLRT_OUTPUT_IDS: u32 = 4;

/// facing
pub const MLRT_OUTPUT_FACING: u32 = 8;

/// triangle without mesh, half as much to write: for trees of one mesh
pub const MLRT_OUTPUT_TRIANGLE: u32 = 16;

/// with `lights`: occluded
pub const MLRT_OUTPUT_OCCLUDED: u32 = 32;

/// the ray passes through the triangle of skip_mesh and skip_triangle
pub const MLRT_RAY_SKIP: u32 = 1;

/// rays from one point
pub const MLRT_PROJECTION_PINHOLE: i32 = 0;

/// rays in one direction: an orthographic camera, the view of a directional light
pub const MLRT_PROJECTION_PARALLEL: i32 = 1;

/// position = that of the light
pub const MLRT_LIGHT_POINT: i32 = 0;

/// position = the direction towards the light, of any length
pub const MLRT_LIGHT_DIRECTIONAL: i32 = 1;

/// A handle: `mlrt_tree` of the header.
#[repr(C)]
pub struct mlrt_tree {
    _data: [u8; 0],
    _marker: PhantomData<(*mut u8, PhantomPinned)>,
}

/// A handle: `mlrt_pool` of the header.
#[repr(C)]
pub struct mlrt_pool {
    _data: [u8; 0],
    _marker: PhantomData<(*mut u8, PhantomPinned)>,
}

/// Returns `size` bytes (never 0), aligned to `alignment` (a power of two, 64 at most); NULL if there is no memory.
pub type mlrt_allocate_callback = unsafe extern "C" fn(user: *mut c_void, size: usize, alignment: usize) -> *mut c_void;

/// Frees a block (never NULL); `size` and `alignment` are those with which it was allocated.
pub type mlrt_free_callback = unsafe extern "C" fn(user: *mut c_void, block: *mut c_void, size: usize, alignment: usize);

/// Receives one line (UTF-8, no newline, 255 bytes at most). `message` is valid until the function returns.
pub type mlrt_log_callback = unsafe extern "C" fn(user: *mut c_void, level: i32, message: *const c_char);

/// ```text
/// Receives the part of a call that is done, 0..1 and never less than before: every few milliseconds, and 1 at the end
/// of a call that succeeds. Return 0 to go on. Any other result ends the call within some milliseconds, with
/// MLRT_ERROR_CANCELLED; after the 1 the result is ignored. The builder and the methods of kd-trees call it less often,
/// and the system can take longer to free much memory.
/// ```
pub type mlrt_progress_callback = unsafe extern "C" fn(user: *mut c_void, fraction: f64) -> i32;

/// A task for the host's job system, which calls it once, with the argument that `enqueue` received.
pub type mlrt_task_function = unsafe extern "C" fn(argument: *mut c_void);

/// ```text
/// Hands a task to the host's job system, which calls function(argument) once, on any thread, now or later. Returns a
/// handle for `finish`, or NULL if it has already run the task.
/// ```
pub type mlrt_enqueue_callback = unsafe extern "C" fn(user: *mut c_void, function: mlrt_task_function, argument: *mut c_void) -> *mut c_void;

/// Waits until a task has run, whose handle (not NULL) `enqueue` returned. It may run this and other tasks meanwhile.
pub type mlrt_finish_callback = unsafe extern "C" fn(user: *mut c_void, task: *mut c_void);

/// ```text
/// Receives each tile once: squares of initial_tile_size, smaller at the edges. The threads of the pool call it, several
/// at a time. It may call any tracing function, but not with the pool of the render, unless that pool has tasks
/// (mlrt_pool_options.enqueue). Return 0 to go on. Any other result ends the render soon: mlrt_render_tiles returns
/// MLRT_ERROR_CANCELLED.
/// ```
pub type mlrt_tile_callback = unsafe extern "C" fn(user: *mut c_void, tile: *const mlrt_tile) -> i32;

/// ```text
/// Functions that the program around the library provides. Options with a field `host` may point to one of these; each
/// function may be NULL.
///
/// Give both `allocate` and `free`, or neither: then malloc and free are used. A call with a host takes all its memory
/// from it, and a tree or a pool that the call makes keeps both functions and `user` until it is destroyed. The library
/// calls `allocate`, `free` and `log` from the thread of the call only, with two exceptions: mlrt_build_kdtree calls
/// `allocate` and `free` from the threads of its pool too, one at a time, and mlrt_trace_all_hits several at a time. It
/// calls `progress` from any of these threads, but from one at a time. None of the functions may jump out of the
/// library. None may use the pool of the call that it is called from; `log` and `progress` may if that pool has tasks
/// (mlrt_pool_options.enqueue).
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_host {
    /// sizeof(mlrt_host)
    pub struct_size: u32,
    /// must be 0
    pub reserved: u32,
    /// the first argument of all four
    pub user: *mut c_void,
    /// NULL = malloc
    pub allocate: Option<mlrt_allocate_callback>,
    /// NULL = free
    pub free: Option<mlrt_free_callback>,
    /// NULL = no messages
    pub log: Option<mlrt_log_callback>,
    /// NULL = no call is cancelled
    pub progress: Option<mlrt_progress_callback>,
}

impl Default for mlrt_host {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// ```text
/// An indexed triangle mesh in the caller's memory.
///
/// A vertex is three floats. A triangle is three indices of vertices, unsigned integers of 2 or 4 bytes; with `indices`
/// = NULL, triangle i has the vertices 3i, 3i + 1, 3i + 2. Elements of an array may not overlap.
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_mesh {
    /// sizeof(mlrt_mesh)
    pub struct_size: u32,
    /// reported with hits. Ids must differ and not be MLRT_NONE; if all are 0, they are 0, 1, 2, ...
    pub id: u32,
    /// float\[3\] each, aligned to 4 bytes
    pub vertices: *const c_void,
    /// every index must be less
    pub vertex_count: usize,
    /// bytes from one vertex to the next, a multiple of 4; 0 = 12
    pub vertex_stride: usize,
    /// NULL = consecutive vertices
    pub indices: *const c_void,
    /// 0 is allowed
    pub triangle_count: usize,
    /// bytes from one index triple to the next, a multiple of index_size; 0 = 3 \* index_size
    pub triangle_stride: usize,
    /// 2 or 4; 0 = 4
    pub index_size: u32,
    /// rays see the mesh if their mask has a bit in common with it; 0 = all bits
    pub mask: u32,
}

impl Default for mlrt_mesh {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// How to build a hierarchy of boxes: mlrt_build_tree. NULL, or all zero but struct_size: defaults.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_tree_options {
    /// sizeof(mlrt_tree_options)
    pub struct_size: u32,
    /// MLRT_TREE_\*
    pub preset: i32,
    /// of a node, 0..1e6, in units of a leaf's cost; 0 = 1
    pub traversal_cost: f32,
    /// of a triangle in a leaf, 0..1e6, in the same units; 0 = a small share of the leaf's
    pub intersection_cost: f32,
    /// NULL, or a buffer: receives why the call failed (UTF-8, terminated), or ""
    pub message: *mut c_char,
    /// size of the buffer in bytes
    pub message_size: usize,
    /// NULL = malloc, and no messages
    pub host: *const mlrt_host,
    /// most bytes held at one time; beyond: MLRT_ERROR_OUT_OF_MEMORY; 0 = no limit
    pub memory_limit: u64,
    /// whose threads build; NULL = the calling thread alone. The tree is the same
    pub pool: *mut mlrt_pool,
}

impl Default for mlrt_tree_options {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// How to build a kd-tree: mlrt_build_kdtree. NULL, or all zero but struct_size: defaults.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_kdtree_options {
    /// sizeof(mlrt_kdtree_options)
    pub struct_size: u32,
    /// MLRT_KDTREE_\*
    pub preset: i32,
    /// of one node step, 0..1e6, relative to intersection_cost; 0 = the preset's
    pub traversal_cost: f32,
    /// of one triangle, 0..1e6; 0 = the preset's
    pub intersection_cost: f32,
    /// this and the next three are as in mlrt_tree_options
    pub message: *mut c_char,
    /// size of the buffer in bytes
    pub message_size: usize,
    /// NULL = malloc, and no messages
    pub host: *const mlrt_host,
    /// most bytes held at one time; 0 = no limit
    pub memory_limit: u64,
    /// most leaf entries, at least one per triangle: at the limit nothing is split any more, so it limits the memory; 0 = 8 per triangle + 1024
    pub max_references: u64,
    /// most inner nodes above a leaf, 1..60; 0 = by the number of triangles
    pub max_depth: u32,
    /// MLRT_RULE_\* or-ed together: rules to do without; 0 = all rules are on
    pub rules_off: u32,
    /// whose threads build; NULL = the calling thread alone. The tree is the same
    pub pool: *mut mlrt_pool,
}

impl Default for mlrt_kdtree_options {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// An estimate of the memory that a builder takes: mlrt_estimate_tree, mlrt_estimate_kdtree.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_memory_estimate {
    /// sizeof(mlrt_memory_estimate)
    pub struct_size: u32,
    /// set to 0
    pub reserved: u32,
    /// bytes held by the tree
    pub memory_size: u64,
    /// most bytes held at one time while building
    pub peak_memory_size: u64,
}

impl Default for mlrt_memory_estimate {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// ```text
/// The build report. Counts are those of the finished tree. In the report of a loaded tree build_seconds is 0, and the
/// sizes in bytes are those of loading it.
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_tree_info {
    /// sizeof(mlrt_tree_info)
    pub struct_size: u32,
    /// inner nodes above the deepest leaf
    pub depth: u32,
    /// as given, with those that were left out
    pub triangle_count: u64,
    /// left out: a vertex is NaN or infinite
    pub non_finite_count: u64,
    /// left out: the area is exactly zero
    pub zero_area_count: u64,
    /// kd-tree: inner nodes and leaves; boxes: inner nodes, as leaves are not nodes
    pub node_count: u64,
    /// with the empty ones
    pub leaf_count: u64,
    /// boxes: 0
    pub empty_leaf_count: u64,
    /// entries of all leaves together: a triangle can be in several
    pub reference_count: u64,
    /// subtrees turned back into leaves; boxes: 0
    pub retracted_count: u64,
    /// bytes held by the tree
    pub memory_size: u64,
    /// most bytes held at one time while building
    pub peak_memory_size: u64,
    /// over nodes and leaf entries: equal trees have equal hashes
    pub tree_hash: u64,
    /// expected cost of a random ray through the scene's box, in units of a triangle's cost (kd-tree) or of a node's (boxes)
    pub sah_cost: f64,
    /// time that passed during the whole call
    pub build_seconds: f64,
    /// the least coordinates of triangles in the tree; all 0 if there is none
    pub bounds_min: [f32; 3],
    /// the greatest coordinates; all 0 if there is no triangle
    pub bounds_max: [f32; 3],
    /// MLRT_STRUCTURE_\*: that of the tree, built or loaded
    pub structure: u32,
    /// set to 0
    pub reserved: u32,
}

impl Default for mlrt_tree_info {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// How to load: mlrt_load_tree. NULL, or all zero but struct_size: defaults.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_load_options {
    /// sizeof(mlrt_load_options)
    pub struct_size: u32,
    /// MLRT_LOAD_\*
    pub flags: u32,
    /// what mlrt_hash_geometry says of the wanted triangles: data of others are MLRT_ERROR_DATA. 0 = any triangles
    pub geometry_hash: u64,
    /// as in mlrt_tree_options
    pub memory_limit: u64,
    /// NULL, or a buffer that receives details of an error (UTF-8, terminated)
    pub message: *mut c_char,
    /// size of the buffer in bytes
    pub message_size: usize,
    /// NULL = malloc, and no messages
    pub host: *const mlrt_host,
}

impl Default for mlrt_load_options {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// How to make a pool: mlrt_create_pool_with_options. All zero but struct_size: that of mlrt_create_pool with 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_pool_options {
    /// sizeof(mlrt_pool_options)
    pub struct_size: u32,
    /// as in mlrt_create_pool; with `enqueue`: most tasks at once, the calling thread included
    pub thread_count: u32,
    /// NULL = malloc
    pub host: *const mlrt_host,
    /// the first argument of `enqueue` and `finish`
    pub user: *mut c_void,
    /// NULL = the pool starts threads of its own
    pub enqueue: Option<mlrt_enqueue_callback>,
    /// must be given with `enqueue`, and must be NULL without
    pub finish: Option<mlrt_finish_callback>,
}

impl Default for mlrt_pool_options {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// ```text
/// Counts of the work of tracing. Those of the kd-tree are in units of 4x4 packets, as the columns of the paper's table
/// 2. Counts are added to those in the struct, so that one struct can collect several calls, one at a time; those that
/// the library does not know stay. They can differ between methods, machines, and calls, since method tile goes the way
/// that was faster for the last rays. Counting takes time: with counters, the kernels of the narrowest instruction set
/// run (MLRT_ISA_*).
///
/// Method tile traces sixteen packets, or sixteen tiles of them, together. So up to 256 or 4096 rays share a cell or a
/// test, and its counts cannot be compared with those of the kd-tree. It has no beams and no entry points: their
/// counters do not change.
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_counters {
    /// sizeof(mlrt_counters)
    pub struct_size: u32,
    /// must be 0
    pub reserved: u32,
    /// rays traced. Of shadow rays of a picture's lights, method tile counts those that it makes: where one triangle covers many pixels, it decides their shadows without rays
    pub ray_count: u64,
    /// kd-tree: groups of rays traced together (packets, or less where directions differ), and rays that went alone. Method tile: packets that went lane by lane, and rays that went alone, counted each time
    pub packet_count: u64,
    /// beams for which an entry point was searched
    pub beam_count: u64,
    /// kd-tree: inner nodes and leaves descended into or popped, with those of the entry-point search. Method tile: nodes and leaves that a bundle, a packet that went lane by lane, or a ray that went alone opened
    pub cell_count: u64,
    /// of these, in the entry-point search
    pub entry_point_cell_count: u64,
    /// (packet, triangle) tests that at least one ray takes part in. Method tile: also (ray, triangle) tests of rays that went alone
    pub triangle_test_count: u64,
    /// (ray, triangle) pairs that the float filter left to double arithmetic
    pub judged_lane_count: u64,
    /// entry points from which packets were traced
    pub entry_point_count: u64,
    /// their depths below the root, added up
    pub entry_point_depth_sum: u64,
    /// beams that provably hit nothing: none of their rays was traced
    pub missed_beam_count: u64,
    /// beams whose rays all provably hit one triangle first: none was traced
    pub covered_beam_count: u64,
    /// inner nodes where the culling test could exclude no child
    pub undecided_cull_count: u64,
    /// of these, still undecided after the extra check
    pub undecided_checked_count: u64,
    /// (ray, triangle) pairs that the float filter tested
    pub lane_test_count: u64,
    /// of triangle_test_count, those with a judged ray
    pub undecided_test_count: u64,
    /// (ray, triangle) pairs settled because the nearest hit lies in the same plane
    pub tie_lane_count: u64,
    /// decisions left to exact arithmetic: on which side of an edge a ray passes
    pub exact_edge_count: u64,
    /// decisions left to exact arithmetic: is a hit within t_min and t_max?
    pub exact_range_count: u64,
    /// decisions left to exact arithmetic: which of two hits is nearer?
    pub exact_order_count: u64,
}

impl Default for mlrt_counters {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// ```text
/// How to trace. NULL, or all zero but struct_size: defaults.
///
/// A picture is cut into squares of initial_tile_size; threads claim them one by one, and a tile callback gets one at a
/// time. In method multilevel, initial_tile_size, minimum_tile_size and split_factor are the tile sizes of the paper,
/// section 4.2: a tile larger than minimum_tile_size whose entry point is not a leaf is cut into split_factor pieces,
/// and so on. Method tile has levels of its own, of 64, 16 and 4 pixels, or less where initial_tile_size is less; it
/// checks minimum_tile_size, split_factor, culling, culling_check and shortcuts_off, but does not use them.
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_trace_options {
    /// sizeof(mlrt_trace_options)
    pub struct_size: u32,
    /// MLRT_QUERY_\*
    pub query: i32,
    /// MLRT_METHOD_\*
    pub method: i32,
    /// MLRT_ISA_\*
    pub isa: i32,
    /// MLRT_CULLING_\*
    pub culling: i32,
    /// 1 = check cells that the culling test leaves undecided against all their faces
    pub culling_check: u32,
    /// pixels, 4..1024, a power of two; 0 = default, by source and method
    pub initial_tile_size: u32,
    /// pixels, 4..initial_tile_size, a power of two; 0 = default
    pub minimum_tile_size: u32,
    /// 4 or 16; 0 = 16
    pub split_factor: u32,
    /// MLRT_OUTPUT_\* or-ed together: the results that a tile callback receives
    pub outputs: u32,
    /// MLRT_SHORTCUT_\* or-ed together: shortcuts of multilevel to do without
    pub shortcuts_off: u32,
    /// rays see the meshes whose mask has a bit in common with it; 0 = all bits
    pub mask: u32,
    /// whose threads trace; NULL = the calling thread alone
    pub pool: *mut mlrt_pool,
    /// NULL = nothing is counted. With counters, narrower kernels run (MLRT_ISA_\*)
    pub counters: *mut mlrt_counters,
    /// NULL = malloc, and no messages. mlrt_trace_ray does not use it
    pub host: *const mlrt_host,
    /// mlrt_render_tiles with MLRT_QUERY_CLOSEST: lights whose shadows `occluded` receives; NULL = none. Must be NULL in all other calls
    pub lights: *const mlrt_light,
    /// number of lights, 0..8
    pub light_count: u32,
    /// must be 0
    pub reserved: u32,
}

impl Default for mlrt_trace_options {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// An array of results. With `data` = NULL they are not wanted, and not computed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_array {
    /// the first element; NULL = not wanted
    pub data: *mut c_void,
    /// bytes from one element to the next; 0 = packed
    pub stride: usize,
    /// bytes from one row of pixels to the next, in mlrt_render_tiles and mlrt_camera_rays; 0 = packed
    pub row_stride: usize,
}

impl Default for mlrt_array {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        zero
    }
}

/// ```text
/// The arrays that receive results. MLRT_QUERY_CLOSEST writes the first six, and with lights also the last;
/// MLRT_QUERY_ANY writes only the last. An array that the query does not write must be NULL, and one must be given,
/// unless there are no rays, or the call has a callback or counters.
///
/// `mesh`, `triangle` and `facing` tell hits from misses. `t` does not: the t of a hit farther away than the greatest
/// float rounds to inf, which is that of a miss, and a very small one rounds to 0, though 0 < t.
///
/// With lights, bit k of `occluded` is 1 if light k of the options does not reach the hit: something is in between, or
/// the light is on the other side of the surface, or it is so far away that no ray of floats leads to it ("Shadows of a
/// picture" below).
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_hits {
    /// sizeof(mlrt_hits)
    pub struct_size: u32,
    /// must be 0
    pub reserved: u32,
    /// float: the distance in units of |d|, rounded; inf for a miss, and for hits as above
    pub t: mlrt_array,
    /// float: the weight of the triangle's second vertex
    pub u: mlrt_array,
    /// float: the weight of its third
    pub v: mlrt_array,
    /// uint32_t: the id of the mesh; MLRT_NONE = miss
    pub mesh: mlrt_array,
    /// uint32_t: the number of the triangle in its mesh; MLRT_NONE = miss
    pub triangle: mlrt_array,
    /// int32_t: the sign of d . n; 0 = miss
    pub facing: mlrt_array,
    /// uint8_t: 1 = something is hit, 0 = nothing. With lights a bit for each (above); 0 = miss
    pub occluded: mlrt_array,
}

impl Default for mlrt_hits {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// An input array. One that may be left out is left out by `data` = NULL.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_const_array {
    /// the first element
    pub data: *const c_void,
    /// bytes from one element to the next; 0 = packed; MLRT_STRIDE_ALL = one element serves all
    pub stride: usize,
}

impl Default for mlrt_const_array {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        zero
    }
}

/// ```text
/// Rays, in the caller's arrays.
///
/// Rays are grouped in the order given: 16 to a packet, and packets to tiles. A group is fast if its rays are alike: if
/// they go nearly the same way, or begin or end near each other; the arrays may have any strides. Give the length of
/// rows of pixels in `row_length`, and groups are squares; without it, mlrt_trace_packet looks for rows. Answers do not
/// depend on the grouping.
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_rays {
    /// sizeof(mlrt_rays)
    pub struct_size: u32,
    /// rays in a row of a picture; 0 = not known. A hint for speed only
    pub row_length: u32,
    /// at most 2^31 - 1
    pub count: usize,
    /// float\[3\]
    pub origins: mlrt_const_array,
    /// float\[3\], of any length
    pub directions: mlrt_const_array,
    /// float; NULL = 0 for all
    pub t_min: mlrt_const_array,
    /// float; NULL, or inf = no limit. 0 here means 0: no hits
    pub t_max: mlrt_const_array,
    /// uint32_t\[2\]: mesh and triangle, as reported, that the ray passes through; NULL = none
    pub skip: mlrt_const_array,
    /// uint32_t: a mask for each ray in place of that of the options (0 = all bits). NULL = all rays have that of the options. If the tree's meshes have masks, this takes longer
    pub mask: mlrt_const_array,
    /// k: each k neighbouring rays start at one point. Ray i has element i / k of origins, t_min and skip, which have count / k elements, and element i of the other arrays. 0 = 1. k must divide count. If k \> 1, rays are grouped in the order given, and row_length is not used
    pub rays_per_origin: u32,
    /// must be 0
    pub reserved: u32,
}

impl Default for mlrt_rays {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// A ray, for mlrt_trace_ray.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_ray {
    /// sizeof(mlrt_ray)
    pub struct_size: u32,
    /// MLRT_RAY_\*
    pub flags: u32,
    /// o
    pub origin: [f32; 3],
    /// d, of any length
    pub direction: [f32; 3],
    /// 0 = hits in front of the origin
    pub t_min: f32,
    /// 0 or inf = no limit
    pub t_max: f32,
    /// with MLRT_RAY_SKIP: the mesh, as reported, of the triangle to pass through
    pub skip_mesh: u32,
    /// with MLRT_RAY_SKIP: that triangle, as reported
    pub skip_triangle: u32,
}

impl Default for mlrt_ray {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// The result of mlrt_trace_ray.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_hit {
    /// sizeof(mlrt_hit)
    pub struct_size: u32,
    /// the distance in units of |d|, rounded; inf for a miss, and can be for a hit (mlrt_hits)
    pub t: f32,
    /// the weight of the triangle's second vertex
    pub u: f32,
    /// the weight of its third
    pub v: f32,
    /// the id of the mesh; MLRT_NONE = miss
    pub mesh: u32,
    /// the number of the triangle in its mesh; MLRT_NONE = miss
    pub triangle: u32,
    /// the sign of d . n; 0 = miss
    pub facing: i32,
    /// 1 = something is hit, 0 = nothing. With MLRT_QUERY_ANY no other field is written
    pub occluded: u32,
}

impl Default for mlrt_hit {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// ```text
/// The arrays that receive lists of hits: `capacity` elements per ray, so hit j of ray i is element i * capacity + j. An
/// array with data = NULL is not wanted. Elements after the last hit of a ray are written as misses.
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_hit_lists {
    /// sizeof(mlrt_hit_lists)
    pub struct_size: u32,
    /// most hits written per ray; 0 = only the totals are: all arrays of hits must be NULL
    pub capacity: u32,
    /// float; this and the next five are as in mlrt_hits
    pub t: mlrt_array,
    /// float
    pub u: mlrt_array,
    /// float
    pub v: mlrt_array,
    /// uint32_t
    pub mesh: mlrt_array,
    /// uint32_t
    pub triangle: mlrt_array,
    /// int32_t
    pub facing: mlrt_array,
    /// uint8_t: 1 = this hit crosses the surface, 0 = it only touches it, or there is no hit
    pub crossing: mlrt_array,
    /// uint32_t, one per ray: the number of its hits, with those beyond `capacity`
    pub total: mlrt_array,
    /// uint32_t, one per ray: the number of these that cross the surface
    pub crossing_total: mlrt_array,
}

impl Default for mlrt_hit_lists {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// ```text
/// A camera. Pixel (i, j), counted from the upper left or from any other corner, has the vector p = d00 + x dx + y dy,
/// where x = i + sample_x and y = j + sample_y, and the ray
///
///     pinhole:   origin eye, direction p               parallel:   origin p, direction `direction`
///
/// in exactly this arithmetic, each step rounded to float, for each component k:
///     x = fl(i + sample_x), y = fl(j + sample_y), p_k = fl(fl(d00_k + fl(x dx_k)) + fl(y dy_k)).
/// So mlrt_camera_rays, or the caller, can write out exactly the rays that mlrt_render_tiles traces.
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_camera {
    /// sizeof(mlrt_camera)
    pub struct_size: u32,
    /// MLRT_PROJECTION_\*
    pub projection: i32,
    /// columns of the whole picture, 1..2^23. The crop has at most 2^31 - 1 pixels
    pub width: u32,
    /// rows of the whole picture, 1..2^23
    pub height: u32,
    /// the first column to render: column 0 of the frame
    pub crop_x: u32,
    /// the first row to render: row 0 of the frame
    pub crop_y: u32,
    /// columns to render; 0 = up to the last
    pub crop_width: u32,
    /// rows to render; 0 = up to the last
    pub crop_height: u32,
    /// pinhole: where the rays start
    pub eye: [f32; 3],
    /// parallel: where the rays go
    pub direction: [f32; 3],
    /// p of x = 0, y = 0
    pub d00: [f32; 3],
    /// from p of one pixel to that of the next in a row
    pub dx: [f32; 3],
    /// from p of one row to that of the next
    pub dy: [f32; 3],
    /// where in the pixel, along the row: 0.5 = the middle
    pub sample_x: f32,
    /// where in the pixel, across the rows: 0.5 = the middle
    pub sample_y: f32,
    /// 0 = hits in front of the origin
    pub t_min: f32,
    /// 0 or inf = no limit
    pub t_max: f32,
}

impl Default for mlrt_camera {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// ```text
/// The results of a finished tile, as arrays: that of pixel (x + i, y + j), counted like the camera's pixels, is element
/// j * width + i. Arrays that the options' `outputs` do not name are NULL; with MLRT_QUERY_ANY, all but `occluded` are.
/// They are valid until the callback returns, and lie in the worker's cache. Calls that run at the same time have
/// different numbers in `worker`. (With a pool that has hooks this is the number of a task; any thread may run it.)
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_tile {
    /// sizeof(mlrt_tile), the library's
    pub struct_size: u32,
    /// number of the worker, below mlrt_pool_thread_count; 0 is the thread of the call
    pub worker: u32,
    /// the column of its first pixel
    pub x: u32,
    /// the row of its first pixel
    pub y: u32,
    /// in pixels
    pub width: u32,
    /// in pixels
    pub height: u32,
    /// with MLRT_OUTPUT_T; elements are as in mlrt_hits
    pub t: *const f32,
    /// with MLRT_OUTPUT_UV
    pub u: *const f32,
    /// with MLRT_OUTPUT_UV
    pub v: *const f32,
    /// with MLRT_OUTPUT_IDS
    pub mesh: *const u32,
    /// with MLRT_OUTPUT_IDS or MLRT_OUTPUT_TRIANGLE
    pub triangle: *const u32,
    /// with MLRT_OUTPUT_FACING
    pub facing: *const i32,
    /// with MLRT_QUERY_ANY, or lights and MLRT_OUTPUT_OCCLUDED
    pub occluded: *const u8,
}

impl Default for mlrt_tile {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// A light.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_light {
    /// sizeof(mlrt_light)
    pub struct_size: u32,
    /// MLRT_LIGHT_\*
    pub kind: i32,
    /// must be finite
    pub position: [f32; 3],
}

impl Default for mlrt_light {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

/// Points of which mlrt_occluded_points tells whether they are in shadow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mlrt_points {
    /// sizeof(mlrt_points)
    pub struct_size: u32,
    /// points in a row of a picture; 0 = not known. A hint for speed only
    pub row_length: u32,
    /// at most 2^31 - 1
    pub count: usize,
    /// float\[3\]
    pub positions: mlrt_const_array,
    /// uint32_t\[2\]: mesh and triangle that the point lies on: it does not shade the point. NULL = none
    pub skip: mlrt_const_array,
}

impl Default for mlrt_points {
    fn default() -> Self {
        // SAFETY: numbers, pointers and optional functions: all may be 0.
        let zero: Self = unsafe { std::mem::zeroed() };
        Self { struct_size: std::mem::size_of::<Self>() as u32, ..zero }
    }
}

extern "C" {

    /// Returns the library's version, MAJOR \* 10000 + MINOR \* 100 + PATCH, which can differ from the header's.
    pub fn mlrt_version() -> u32;

    /// Returns what a status code means: an English phrase, never NULL, also for unknown codes. The string is static.
    pub fn mlrt_status_string(status: i32) -> *const c_char;

    /// ```text
    /// Returns why the last call of this thread that did not return MLRT_OK failed, in words that name the argument, its
    /// value and the rule: "rays.t_max: stride 13 is not a multiple of 4". UTF-8 without a newline, 255 bytes at most, never
    /// NULL; "" if no call of the thread has failed. Calls that succeed leave it as it is, so ask only after a failure.
    ///
    /// Each thread has its own message, which lasts until the next call of the thread that fails, or until the thread ends.
    /// The thread of a call is the one that made it, also where a pool does the work. Where a runtime may move its tasks
    /// from thread to thread (goroutines, promises), ask before anything else may run.
    /// ```
    pub fn mlrt_last_message() -> *const c_char;

    /// Returns what this library can do on this machine: MLRT_CAN_\*. May be called before anything else.
    pub fn mlrt_capabilities() -> u64;

    /// ```text
    /// Writes the size of each struct in this library to sizes[0 .. count - 1]: element MLRT_STRUCT_MESH is that of
    /// mlrt_mesh, and so on. Elements for which this library has no struct become 0. For bindings whose layouts are written
    /// by hand: a size that differs from theirs is that of another version, or their layout is wrong. May be called before
    /// anything else.
    /// ```
    pub fn mlrt_struct_sizes(sizes: *mut u32, count: u32);

    /// ```text
    /// Builds the best tree that the library has over the triangles of `meshes`: a hierarchy of boxes.
    ///
    ///   meshes      array of mesh_count structs, all of the struct_size of the first. The mesh data may be freed on return.
    ///   mesh_count  0 is allowed, as is a mesh without triangles: in an empty tree every ray misses.
    ///   options     NULL = defaults.
    ///   tree        receives the tree, or NULL after an error. Free it with mlrt_destroy_tree.
    ///
    /// Triangles that can never be hit (a vertex that is not finite, an area of exactly zero) are left out of the tree and
    /// counted in mlrt_tree_info; the numbers of the others do not change. The same input always gives the same tree.
    /// MLRT_ERROR_INDEX_RANGE: an index is out of range; options->message names mesh (by position), triangle and index.
    /// MLRT_ERROR_ARGUMENT: an option is out of its range; options->message names the option. MLRT_ERROR_TOO_LARGE: more
    /// than 2^30 - 1 triangles in all.
    ///
    /// Memory per triangle, its own 36 bytes included: 51 to 60 bytes, and at most 136 while the tree is built (FAST: 50 to
    /// 56 and 127, BEST: 52 to 69 and 154). Flat grids take a little less, meshes of a few triangles more, and masks 4
    /// bytes per triangle. mlrt_tree_info tells how much a tree took.
    ///
    /// Method: surface area heuristic over bins, with spatial splits (M. Stich, H. Friedrich, A. Dietrich, "Spatial Splits
    /// in Bounding Volume Hierarchies", 2009), and the best way to put sixteen boxes into a node (H. Ylitie, T. Karras, S.
    /// Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017).
    /// ```
    pub fn mlrt_build_tree(meshes: *const mlrt_mesh, mesh_count: usize, options: *const mlrt_tree_options, tree: *mut *mut mlrt_tree) -> i32;

    /// ```text
    /// Builds the paper's kd-tree. In it the default method is the paper's (MLRT_METHOD_MULTILEVEL). Arguments, errors and
    /// the triangles that are left out are as in mlrt_build_tree. It is the same tree for any number of threads.
    ///
    /// It is slower to build and to trace than the tree of mlrt_build_tree. Memory per triangle, its own 36 bytes included:
    /// 40 to 95 bytes, and 1.8 to 2.4 times that while the tree is built; up to 25 % more with several threads.
    ///
    /// Method: surface area heuristic over clipped split candidates (V. Havran, J. Bittner, "On improving kd-trees for ray
    /// shooting", 2002) with the three rules of the paper (section 3.1).
    /// ```
    pub fn mlrt_build_kdtree(meshes: *const mlrt_mesh, mesh_count: usize, options: *const mlrt_kdtree_options, tree: *mut *mut mlrt_tree) -> i32;

    /// ```text
    /// Estimates the memory of mlrt_build_tree with the same arguments, from the numbers of triangles alone.
    ///
    ///   meshes      as for mlrt_build_tree; of each, struct_size and triangle_count are enough.
    ///   mesh_count  the number of meshes.
    ///   options     NULL = defaults.
    ///   estimate    receives the estimate (struct_size must be set).
    ///
    /// Scenes of more than a few thousand triangles take 80 to 110 % of it, flat grids less. Only a memory_limit is sure to
    /// hold.
    /// ```
    pub fn mlrt_estimate_tree(meshes: *const mlrt_mesh, mesh_count: usize, options: *const mlrt_tree_options, estimate: *mut mlrt_memory_estimate) -> i32;

    /// Estimates the memory of mlrt_build_kdtree from the same arguments: a guess, which can be off by a factor of two.
    pub fn mlrt_estimate_kdtree(meshes: *const mlrt_mesh, mesh_count: usize, options: *const mlrt_kdtree_options, estimate: *mut mlrt_memory_estimate) -> i32;

    /// Frees a tree. No call may be using it. NULL is allowed.
    pub fn mlrt_destroy_tree(tree: *mut mlrt_tree);

    /// Writes the build report of a tree to \*info (struct_size must be set).
    pub fn mlrt_get_tree_info(tree: *const mlrt_tree, info: *mut mlrt_tree_info) -> i32;

    /// ```text
    /// Writes a tree of either structure to memory, with its triangles, for mlrt_load_tree.
    ///
    ///   tree      the tree, which stays as it is.
    ///   buffer    where to write; NULL = nowhere, to learn the size.
    ///   capacity  size of `buffer` in bytes. If it is too small, nothing is written: MLRT_ERROR_ARGUMENT.
    ///   size      receives the number of bytes that the saved tree takes, also if `capacity` is too small.
    /// ```
    pub fn mlrt_save_tree(tree: *const mlrt_tree, buffer: *mut c_void, capacity: usize, size: *mut usize) -> i32;

    /// ```text
    /// Makes a tree from the bytes that mlrt_save_tree wrote: the same tree, of the same structure, with the same answers.
    ///
    ///   data     the bytes, at any address, also of a file mapped into memory. With MLRT_LOAD_IN_PLACE, if the address is a
    ///            multiple of 64, they are used where they lie, and the tree takes next to no memory of its own; at other
    ///            addresses they are copied.
    ///   size     the number of bytes.
    ///   options  NULL = defaults.
    ///   tree     receives the tree, or NULL after an error.
    ///
    /// All of it is checked: any bytes give a tree that is safe to use, or MLRT_ERROR_DATA. A hash over everything detects
    /// accidental damage, but no forgery: a forged file can give wrong answers, but do no other harm. MLRT_ERROR_DATA also
    /// means another version of the format, or another byte order: so keep the meshes, to build the tree again. The host's
    /// `progress` is not called.
    /// ```
    pub fn mlrt_load_tree(data: *const c_void, size: usize, options: *const mlrt_load_options, tree: *mut *mut mlrt_tree) -> i32;

    /// ```text
    /// Computes a hash of meshes: of their ids, masks, and the corners of all triangles in order. It tells whether a saved
    /// tree is still that of the caller's meshes. It does not depend on indices, on the layout in memory, or on the machine.
    /// Corners count bit for bit, so that 0 and -0 differ.
    ///
    ///   meshes      as for mlrt_build_tree, but ids are not compared with each other.
    ///   mesh_count  the number of meshes.
    ///   hash        receives the hash.
    /// ```
    pub fn mlrt_hash_geometry(meshes: *const mlrt_mesh, mesh_count: usize, hash: *mut u64) -> i32;

    /// ```text
    /// Creates a pool of `thread_count` threads, 1..1024, of which the calling thread is one: thread_count - 1 threads are
    /// started, and sleep between calls. 0 = one per processor that is online. They have the signal mask of the caller, and
    /// stacks of the system's size, but of 1 MiB at least. Free the pool with mlrt_destroy_pool.
    /// ```
    pub fn mlrt_create_pool(thread_count: u32, pool: *mut *mut mlrt_pool) -> i32;

    /// ```text
    /// Creates a pool with options (not NULL), such as one without threads that shares work through the host's job system.
    ///
    /// A call with such a pool enqueues at most thread_count - 1 tasks at a time and works on the same items itself. Before
    /// it returns, it calls `finish` for every task whose `enqueue` did not return NULL. A task may start late, or only in
    /// `finish`: the others do its work. A call waits for nothing else. So it may be made from within a job, and several
    /// calls may use such a pool at once, without waiting for each other. (E. Catto's Box2D 3 has hooks like these.)
    /// ```
    pub fn mlrt_create_pool_with_options(options: *const mlrt_pool_options, pool: *mut *mut mlrt_pool) -> i32;

    /// ```text
    /// The thread_count of a pool; where that was 0, the threads that there are. Workers of a call (mlrt_tile.worker) have
    /// numbers below it. NULL is no pool, so the calling thread alone: 1. From any thread, also in callbacks.
    /// ```
    pub fn mlrt_pool_thread_count(pool: *const mlrt_pool) -> u32;

    /// Ends the threads and frees the pool. No call may be using it. NULL is allowed.
    pub fn mlrt_destroy_pool(pool: *mut mlrt_pool);

    /// ```text
    /// Traces any number of rays.
    ///
    ///   tree     the tree.
    ///   rays     the rays.
    ///   options  the query, and how to trace; NULL = the closest hits, by the calling thread.
    ///   hits     the arrays for results: those of ray i go to element i.
    ///
    /// With a pool, its threads share the rays. Threads, method and grouping never change a bit of the results. After an
    /// error the arrays hold the results of some rays only, or of none.
    /// ```
    pub fn mlrt_trace_packet(tree: *const mlrt_tree, rays: *const mlrt_rays, options: *const mlrt_trace_options, hits: *const mlrt_hits) -> i32;

    /// ```text
    /// Traces one ray. For more than a few use mlrt_trace_packet: for rays that are alike it is many times faster per ray.
    ///
    ///   tree     the tree.
    ///   ray      the ray.
    ///   options  the query, and how to trace; NULL = the closest hit. A pool does nothing.
    ///   hit      receives the result (struct_size must be set).
    /// ```
    pub fn mlrt_trace_ray(tree: *const mlrt_tree, ray: *const mlrt_ray, options: *const mlrt_trace_options, hit: *mut mlrt_hit) -> i32;

    /// ```text
    /// Finds every triangle that each ray hits, in the order of the closest-hit rule: by N / D, equal ones as in the input.
    ///
    /// A ray through an edge or a corner hits each triangle there. To tell inside from outside, such hits must count as one.
    /// So each hit says whether it is a `crossing`: whether it would still be a hit, t_max aside, if the origin were moved
    /// by (e, e^2, e^3) for any positive e that is small enough (symbolic perturbation: H. Edelsbrunner, E. P. Muecke,
    /// "Simulation of Simplicity", 1990). For any ray with t_max = inf from a point that does not lie on a closed mesh,
    /// crossing_total is odd if the point is inside the mesh, and even if it is outside.
    ///
    ///   tree     the tree.
    ///   rays     the rays.
    ///   options  NULL = defaults. All fields are checked, but only mask, pool, counters and host are used.
    ///   lists    the arrays for results.
    ///
    /// MLRT_ERROR_OUT_OF_MEMORY is possible, as memory grows with the number of hits of one ray. The arrays then hold the
    /// results of some rays only.
    /// ```
    pub fn mlrt_trace_all_hits(tree: *const mlrt_tree, rays: *const mlrt_rays, options: *const mlrt_trace_options, lists: *const mlrt_hit_lists) -> i32;

    /// ```text
    /// Renders a picture: traces the ray of every pixel of the camera's crop.
    ///
    ///   tree      the tree.
    ///   camera    the camera.
    ///   options   the query, and how to trace; NULL = the closest hits, by the calling thread.
    ///   frame     the arrays for results: element (column, row) of the crop, with their strides. NULL = none.
    ///   callback  receives the results of each tile; NULL = none.
    ///   user      the first argument of the callback.
    ///
    /// A frame with an array, a callback, or counters in the options must be given. A pixel without a valid ray (its
    /// direction rounds to 0, for example) is a miss.
    /// ```
    pub fn mlrt_render_tiles(tree: *const mlrt_tree, camera: *const mlrt_camera, options: *const mlrt_trace_options, frame: *const mlrt_hits, callback: Option<mlrt_tile_callback>, user: *mut c_void) -> i32;

    /// ```text
    /// Writes out the rays of a camera's crop, row by row: crop_width * crop_height origins and directions. Tracing them
    /// gives the results of mlrt_render_tiles, bit for bit.
    ///
    ///   camera      the camera. Its t_min and t_max are not written.
    ///   origins     receives float[3] for each ray; NULL, or data = NULL: not wanted.
    ///   directions  receives float[3] for each ray; NULL, or data = NULL: not wanted.
    /// ```
    pub fn mlrt_camera_rays(camera: *const mlrt_camera, origins: *const mlrt_array, directions: *const mlrt_array) -> i32;

    /// ```text
    /// Finds out which points are in the shadow of a light.
    ///
    ///   tree      the tree, whose triangles cast the shadows.
    ///   points    the points.
    ///   light     the light.
    ///   options   NULL = defaults. Its `query` must be one of MLRT_QUERY_*, but is ignored.
    ///   occluded  uint8_t: element i receives 1 if something lies between point i and the light, 0 if nothing does. Its
    ///             data must not be NULL.
    ///
    /// The ray of point P is o = L, d = fl(P - L) per component, 0 < t <= 1 for a point light at L, and o = P, d = position,
    /// 0 < t for a directional light. A point that is at the light itself, or has a coordinate that is not finite, is not
    /// occluded. For points on a surface, move them off it by mlrt_offset_point, and name the triangle in `skip`.
    /// ```
    pub fn mlrt_occluded_points(tree: *const mlrt_tree, points: *const mlrt_points, light: *const mlrt_light, options: *const mlrt_trace_options, occluded: *const mlrt_array) -> i32;

    /// ```text
    /// Shadows of a picture. With `lights` in the options, mlrt_render_tiles finds out for each pixel which lights reach the
    /// point that it shows. This is much faster than mlrt_occluded_points, as no points have to leave the library. If the
    /// ray o + t d of a pixel hits a triangle abc, bit k of `occluded` is 1 where light k does not reach the hit:
    ///
    ///   - A light does not reach it unless it is strictly on that side of abc's plane from which the ray came (a
    ///     directional light: unless its direction points strictly to that side). A light also counts as one on the other
    ///     side if the ray below would leave the range of float: if d' (point light) or o' (directional light) would have a
    ///     component beyond the greatest float.
    ///   - Otherwise a ray decides: for a point light at L, from o' = L along d' for 0 < t <= 1; for a directional light,
    ///     from o' along d' = position (with 0 for -0) for 0 < t. Its end L + d', or its origin o', is a point just off the
    ///     hit, surely on the side from which the picture's ray came. It is moved off by about 2^-22 of the greatest
    ///     coordinate relative to the eye and to the light; for slivers, and rays that nearly lie in their plane, by as many
    ///     floats as it takes. So no triangle shades itself, nor does one in its plane or behind it. The ray sees the meshes
    ///     that the picture's rays see (`mask`).
    ///
    /// mlrt_shadow_ray computes this ray, which is the same on every machine. The answer is that of mlrt_trace_ray for it.
    ///
    ///   tree    the tree.
    ///   ray     a ray that hits something, for example one of mlrt_camera_rays.
    ///   hit     its hit: mesh and triangle are read.
    ///   light   the light.
    ///   shadow  receives the ray that decides, with the triangle to skip (struct_size must be set).
    ///   faces   receives 1; or 0 if the light is on the other side, or counts as such because the ray would leave the range
    ///           of float. No ray is needed then, and *shadow has a direction of 0. It has one, too, if the point just off the
    ///           hit is that of the light: nothing is between them.
    ///
    /// MLRT_ERROR_ARGUMENT: there is no such triangle, or the ray does not hit it between its t_min and t_max. (What the ray
    /// skips does not matter.)
    /// ```
    pub fn mlrt_shadow_ray(tree: *const mlrt_tree, ray: *const mlrt_ray, hit: *const mlrt_hit, light: *const mlrt_light, shadow: *mut mlrt_ray, faces: *mut i32) -> i32;

    /// ```text
    /// Finds a point just off a triangle a b c: next to (1 - u - v) a + u b + v c, strictly on one side.
    ///
    ///   tree      the tree that has the triangle.
    ///   mesh      the id of its mesh, as reported with hits.
    ///   triangle  its number in the mesh, as reported with hits.
    ///   u, v      the place on the triangle, as reported with hits; any finite numbers.
    ///   side      +1: the side to which the normal (b - a) x (c - a) points; -1: the other one. To get the side from which
    ///             a ray came, give -facing of its hit.
    ///   point     receives the point.
    ///
    /// Promise: no ray that starts at the point and goes to the same side, or along the plane, hits that triangle.
    ///
    /// MLRT_ERROR_ARGUMENT: there is no such triangle, it was left out of the tree, u or v is not finite, or the point would
    /// leave the range of float.
    /// ```
    pub fn mlrt_offset_point(tree: *const mlrt_tree, mesh: u32, triangle: u32, u: f32, v: f32, side: i32, point: *mut f32) -> i32;
}

/// The places of all fields and the sizes of all structs: (struct, field, offset), (struct, "sizeof", size).
#[doc(hidden)]
pub fn layouts() -> Vec<(&'static str, &'static str, usize)> {
    use std::mem::{offset_of, size_of};
    vec![
        ("mlrt_host", "struct_size", offset_of!(mlrt_host, struct_size)),
        ("mlrt_host", "reserved", offset_of!(mlrt_host, reserved)),
        ("mlrt_host", "user", offset_of!(mlrt_host, user)),
        ("mlrt_host", "allocate", offset_of!(mlrt_host, allocate)),
        ("mlrt_host", "free", offset_of!(mlrt_host, free)),
        ("mlrt_host", "log", offset_of!(mlrt_host, log)),
        ("mlrt_host", "progress", offset_of!(mlrt_host, progress)),
        ("mlrt_host", "sizeof", size_of::<mlrt_host>()),
        ("mlrt_mesh", "struct_size", offset_of!(mlrt_mesh, struct_size)),
        ("mlrt_mesh", "id", offset_of!(mlrt_mesh, id)),
        ("mlrt_mesh", "vertices", offset_of!(mlrt_mesh, vertices)),
        ("mlrt_mesh", "vertex_count", offset_of!(mlrt_mesh, vertex_count)),
        ("mlrt_mesh", "vertex_stride", offset_of!(mlrt_mesh, vertex_stride)),
        ("mlrt_mesh", "indices", offset_of!(mlrt_mesh, indices)),
        ("mlrt_mesh", "triangle_count", offset_of!(mlrt_mesh, triangle_count)),
        ("mlrt_mesh", "triangle_stride", offset_of!(mlrt_mesh, triangle_stride)),
        ("mlrt_mesh", "index_size", offset_of!(mlrt_mesh, index_size)),
        ("mlrt_mesh", "mask", offset_of!(mlrt_mesh, mask)),
        ("mlrt_mesh", "sizeof", size_of::<mlrt_mesh>()),
        ("mlrt_tree_options", "struct_size", offset_of!(mlrt_tree_options, struct_size)),
        ("mlrt_tree_options", "preset", offset_of!(mlrt_tree_options, preset)),
        ("mlrt_tree_options", "traversal_cost", offset_of!(mlrt_tree_options, traversal_cost)),
        ("mlrt_tree_options", "intersection_cost", offset_of!(mlrt_tree_options, intersection_cost)),
        ("mlrt_tree_options", "message", offset_of!(mlrt_tree_options, message)),
        ("mlrt_tree_options", "message_size", offset_of!(mlrt_tree_options, message_size)),
        ("mlrt_tree_options", "host", offset_of!(mlrt_tree_options, host)),
        ("mlrt_tree_options", "memory_limit", offset_of!(mlrt_tree_options, memory_limit)),
        ("mlrt_tree_options", "pool", offset_of!(mlrt_tree_options, pool)),
        ("mlrt_tree_options", "sizeof", size_of::<mlrt_tree_options>()),
        ("mlrt_kdtree_options", "struct_size", offset_of!(mlrt_kdtree_options, struct_size)),
        ("mlrt_kdtree_options", "preset", offset_of!(mlrt_kdtree_options, preset)),
        ("mlrt_kdtree_options", "traversal_cost", offset_of!(mlrt_kdtree_options, traversal_cost)),
        ("mlrt_kdtree_options", "intersection_cost", offset_of!(mlrt_kdtree_options, intersection_cost)),
        ("mlrt_kdtree_options", "message", offset_of!(mlrt_kdtree_options, message)),
        ("mlrt_kdtree_options", "message_size", offset_of!(mlrt_kdtree_options, message_size)),
        ("mlrt_kdtree_options", "host", offset_of!(mlrt_kdtree_options, host)),
        ("mlrt_kdtree_options", "memory_limit", offset_of!(mlrt_kdtree_options, memory_limit)),
        ("mlrt_kdtree_options", "max_references", offset_of!(mlrt_kdtree_options, max_references)),
        ("mlrt_kdtree_options", "max_depth", offset_of!(mlrt_kdtree_options, max_depth)),
        ("mlrt_kdtree_options", "rules_off", offset_of!(mlrt_kdtree_options, rules_off)),
        ("mlrt_kdtree_options", "pool", offset_of!(mlrt_kdtree_options, pool)),
        ("mlrt_kdtree_options", "sizeof", size_of::<mlrt_kdtree_options>()),
        ("mlrt_memory_estimate", "struct_size", offset_of!(mlrt_memory_estimate, struct_size)),
        ("mlrt_memory_estimate", "reserved", offset_of!(mlrt_memory_estimate, reserved)),
        ("mlrt_memory_estimate", "memory_size", offset_of!(mlrt_memory_estimate, memory_size)),
        ("mlrt_memory_estimate", "peak_memory_size", offset_of!(mlrt_memory_estimate, peak_memory_size)),
        ("mlrt_memory_estimate", "sizeof", size_of::<mlrt_memory_estimate>()),
        ("mlrt_tree_info", "struct_size", offset_of!(mlrt_tree_info, struct_size)),
        ("mlrt_tree_info", "depth", offset_of!(mlrt_tree_info, depth)),
        ("mlrt_tree_info", "triangle_count", offset_of!(mlrt_tree_info, triangle_count)),
        ("mlrt_tree_info", "non_finite_count", offset_of!(mlrt_tree_info, non_finite_count)),
        ("mlrt_tree_info", "zero_area_count", offset_of!(mlrt_tree_info, zero_area_count)),
        ("mlrt_tree_info", "node_count", offset_of!(mlrt_tree_info, node_count)),
        ("mlrt_tree_info", "leaf_count", offset_of!(mlrt_tree_info, leaf_count)),
        ("mlrt_tree_info", "empty_leaf_count", offset_of!(mlrt_tree_info, empty_leaf_count)),
        ("mlrt_tree_info", "reference_count", offset_of!(mlrt_tree_info, reference_count)),
        ("mlrt_tree_info", "retracted_count", offset_of!(mlrt_tree_info, retracted_count)),
        ("mlrt_tree_info", "memory_size", offset_of!(mlrt_tree_info, memory_size)),
        ("mlrt_tree_info", "peak_memory_size", offset_of!(mlrt_tree_info, peak_memory_size)),
        ("mlrt_tree_info", "tree_hash", offset_of!(mlrt_tree_info, tree_hash)),
        ("mlrt_tree_info", "sah_cost", offset_of!(mlrt_tree_info, sah_cost)),
        ("mlrt_tree_info", "build_seconds", offset_of!(mlrt_tree_info, build_seconds)),
        ("mlrt_tree_info", "bounds_min", offset_of!(mlrt_tree_info, bounds_min)),
        ("mlrt_tree_info", "bounds_max", offset_of!(mlrt_tree_info, bounds_max)),
        ("mlrt_tree_info", "structure", offset_of!(mlrt_tree_info, structure)),
        ("mlrt_tree_info", "reserved", offset_of!(mlrt_tree_info, reserved)),
        ("mlrt_tree_info", "sizeof", size_of::<mlrt_tree_info>()),
        ("mlrt_load_options", "struct_size", offset_of!(mlrt_load_options, struct_size)),
        ("mlrt_load_options", "flags", offset_of!(mlrt_load_options, flags)),
        ("mlrt_load_options", "geometry_hash", offset_of!(mlrt_load_options, geometry_hash)),
        ("mlrt_load_options", "memory_limit", offset_of!(mlrt_load_options, memory_limit)),
        ("mlrt_load_options", "message", offset_of!(mlrt_load_options, message)),
        ("mlrt_load_options", "message_size", offset_of!(mlrt_load_options, message_size)),
        ("mlrt_load_options", "host", offset_of!(mlrt_load_options, host)),
        ("mlrt_load_options", "sizeof", size_of::<mlrt_load_options>()),
        ("mlrt_pool_options", "struct_size", offset_of!(mlrt_pool_options, struct_size)),
        ("mlrt_pool_options", "thread_count", offset_of!(mlrt_pool_options, thread_count)),
        ("mlrt_pool_options", "host", offset_of!(mlrt_pool_options, host)),
        ("mlrt_pool_options", "user", offset_of!(mlrt_pool_options, user)),
        ("mlrt_pool_options", "enqueue", offset_of!(mlrt_pool_options, enqueue)),
        ("mlrt_pool_options", "finish", offset_of!(mlrt_pool_options, finish)),
        ("mlrt_pool_options", "sizeof", size_of::<mlrt_pool_options>()),
        ("mlrt_counters", "struct_size", offset_of!(mlrt_counters, struct_size)),
        ("mlrt_counters", "reserved", offset_of!(mlrt_counters, reserved)),
        ("mlrt_counters", "ray_count", offset_of!(mlrt_counters, ray_count)),
        ("mlrt_counters", "packet_count", offset_of!(mlrt_counters, packet_count)),
        ("mlrt_counters", "beam_count", offset_of!(mlrt_counters, beam_count)),
        ("mlrt_counters", "cell_count", offset_of!(mlrt_counters, cell_count)),
        ("mlrt_counters", "entry_point_cell_count", offset_of!(mlrt_counters, entry_point_cell_count)),
        ("mlrt_counters", "triangle_test_count", offset_of!(mlrt_counters, triangle_test_count)),
        ("mlrt_counters", "judged_lane_count", offset_of!(mlrt_counters, judged_lane_count)),
        ("mlrt_counters", "entry_point_count", offset_of!(mlrt_counters, entry_point_count)),
        ("mlrt_counters", "entry_point_depth_sum", offset_of!(mlrt_counters, entry_point_depth_sum)),
        ("mlrt_counters", "missed_beam_count", offset_of!(mlrt_counters, missed_beam_count)),
        ("mlrt_counters", "covered_beam_count", offset_of!(mlrt_counters, covered_beam_count)),
        ("mlrt_counters", "undecided_cull_count", offset_of!(mlrt_counters, undecided_cull_count)),
        ("mlrt_counters", "undecided_checked_count", offset_of!(mlrt_counters, undecided_checked_count)),
        ("mlrt_counters", "lane_test_count", offset_of!(mlrt_counters, lane_test_count)),
        ("mlrt_counters", "undecided_test_count", offset_of!(mlrt_counters, undecided_test_count)),
        ("mlrt_counters", "tie_lane_count", offset_of!(mlrt_counters, tie_lane_count)),
        ("mlrt_counters", "exact_edge_count", offset_of!(mlrt_counters, exact_edge_count)),
        ("mlrt_counters", "exact_range_count", offset_of!(mlrt_counters, exact_range_count)),
        ("mlrt_counters", "exact_order_count", offset_of!(mlrt_counters, exact_order_count)),
        ("mlrt_counters", "sizeof", size_of::<mlrt_counters>()),
        ("mlrt_trace_options", "struct_size", offset_of!(mlrt_trace_options, struct_size)),
        ("mlrt_trace_options", "query", offset_of!(mlrt_trace_options, query)),
        ("mlrt_trace_options", "method", offset_of!(mlrt_trace_options, method)),
        ("mlrt_trace_options", "isa", offset_of!(mlrt_trace_options, isa)),
        ("mlrt_trace_options", "culling", offset_of!(mlrt_trace_options, culling)),
        ("mlrt_trace_options", "culling_check", offset_of!(mlrt_trace_options, culling_check)),
        ("mlrt_trace_options", "initial_tile_size", offset_of!(mlrt_trace_options, initial_tile_size)),
        ("mlrt_trace_options", "minimum_tile_size", offset_of!(mlrt_trace_options, minimum_tile_size)),
        ("mlrt_trace_options", "split_factor", offset_of!(mlrt_trace_options, split_factor)),
        ("mlrt_trace_options", "outputs", offset_of!(mlrt_trace_options, outputs)),
        ("mlrt_trace_options", "shortcuts_off", offset_of!(mlrt_trace_options, shortcuts_off)),
        ("mlrt_trace_options", "mask", offset_of!(mlrt_trace_options, mask)),
        ("mlrt_trace_options", "pool", offset_of!(mlrt_trace_options, pool)),
        ("mlrt_trace_options", "counters", offset_of!(mlrt_trace_options, counters)),
        ("mlrt_trace_options", "host", offset_of!(mlrt_trace_options, host)),
        ("mlrt_trace_options", "lights", offset_of!(mlrt_trace_options, lights)),
        ("mlrt_trace_options", "light_count", offset_of!(mlrt_trace_options, light_count)),
        ("mlrt_trace_options", "reserved", offset_of!(mlrt_trace_options, reserved)),
        ("mlrt_trace_options", "sizeof", size_of::<mlrt_trace_options>()),
        ("mlrt_array", "data", offset_of!(mlrt_array, data)),
        ("mlrt_array", "stride", offset_of!(mlrt_array, stride)),
        ("mlrt_array", "row_stride", offset_of!(mlrt_array, row_stride)),
        ("mlrt_array", "sizeof", size_of::<mlrt_array>()),
        ("mlrt_hits", "struct_size", offset_of!(mlrt_hits, struct_size)),
        ("mlrt_hits", "reserved", offset_of!(mlrt_hits, reserved)),
        ("mlrt_hits", "t", offset_of!(mlrt_hits, t)),
        ("mlrt_hits", "u", offset_of!(mlrt_hits, u)),
        ("mlrt_hits", "v", offset_of!(mlrt_hits, v)),
        ("mlrt_hits", "mesh", offset_of!(mlrt_hits, mesh)),
        ("mlrt_hits", "triangle", offset_of!(mlrt_hits, triangle)),
        ("mlrt_hits", "facing", offset_of!(mlrt_hits, facing)),
        ("mlrt_hits", "occluded", offset_of!(mlrt_hits, occluded)),
        ("mlrt_hits", "sizeof", size_of::<mlrt_hits>()),
        ("mlrt_const_array", "data", offset_of!(mlrt_const_array, data)),
        ("mlrt_const_array", "stride", offset_of!(mlrt_const_array, stride)),
        ("mlrt_const_array", "sizeof", size_of::<mlrt_const_array>()),
        ("mlrt_rays", "struct_size", offset_of!(mlrt_rays, struct_size)),
        ("mlrt_rays", "row_length", offset_of!(mlrt_rays, row_length)),
        ("mlrt_rays", "count", offset_of!(mlrt_rays, count)),
        ("mlrt_rays", "origins", offset_of!(mlrt_rays, origins)),
        ("mlrt_rays", "directions", offset_of!(mlrt_rays, directions)),
        ("mlrt_rays", "t_min", offset_of!(mlrt_rays, t_min)),
        ("mlrt_rays", "t_max", offset_of!(mlrt_rays, t_max)),
        ("mlrt_rays", "skip", offset_of!(mlrt_rays, skip)),
        ("mlrt_rays", "mask", offset_of!(mlrt_rays, mask)),
        ("mlrt_rays", "rays_per_origin", offset_of!(mlrt_rays, rays_per_origin)),
        ("mlrt_rays", "reserved", offset_of!(mlrt_rays, reserved)),
        ("mlrt_rays", "sizeof", size_of::<mlrt_rays>()),
        ("mlrt_ray", "struct_size", offset_of!(mlrt_ray, struct_size)),
        ("mlrt_ray", "flags", offset_of!(mlrt_ray, flags)),
        ("mlrt_ray", "origin", offset_of!(mlrt_ray, origin)),
        ("mlrt_ray", "direction", offset_of!(mlrt_ray, direction)),
        ("mlrt_ray", "t_min", offset_of!(mlrt_ray, t_min)),
        ("mlrt_ray", "t_max", offset_of!(mlrt_ray, t_max)),
        ("mlrt_ray", "skip_mesh", offset_of!(mlrt_ray, skip_mesh)),
        ("mlrt_ray", "skip_triangle", offset_of!(mlrt_ray, skip_triangle)),
        ("mlrt_ray", "sizeof", size_of::<mlrt_ray>()),
        ("mlrt_hit", "struct_size", offset_of!(mlrt_hit, struct_size)),
        ("mlrt_hit", "t", offset_of!(mlrt_hit, t)),
        ("mlrt_hit", "u", offset_of!(mlrt_hit, u)),
        ("mlrt_hit", "v", offset_of!(mlrt_hit, v)),
        ("mlrt_hit", "mesh", offset_of!(mlrt_hit, mesh)),
        ("mlrt_hit", "triangle", offset_of!(mlrt_hit, triangle)),
        ("mlrt_hit", "facing", offset_of!(mlrt_hit, facing)),
        ("mlrt_hit", "occluded", offset_of!(mlrt_hit, occluded)),
        ("mlrt_hit", "sizeof", size_of::<mlrt_hit>()),
        ("mlrt_hit_lists", "struct_size", offset_of!(mlrt_hit_lists, struct_size)),
        ("mlrt_hit_lists", "capacity", offset_of!(mlrt_hit_lists, capacity)),
        ("mlrt_hit_lists", "t", offset_of!(mlrt_hit_lists, t)),
        ("mlrt_hit_lists", "u", offset_of!(mlrt_hit_lists, u)),
        ("mlrt_hit_lists", "v", offset_of!(mlrt_hit_lists, v)),
        ("mlrt_hit_lists", "mesh", offset_of!(mlrt_hit_lists, mesh)),
        ("mlrt_hit_lists", "triangle", offset_of!(mlrt_hit_lists, triangle)),
        ("mlrt_hit_lists", "facing", offset_of!(mlrt_hit_lists, facing)),
        ("mlrt_hit_lists", "crossing", offset_of!(mlrt_hit_lists, crossing)),
        ("mlrt_hit_lists", "total", offset_of!(mlrt_hit_lists, total)),
        ("mlrt_hit_lists", "crossing_total", offset_of!(mlrt_hit_lists, crossing_total)),
        ("mlrt_hit_lists", "sizeof", size_of::<mlrt_hit_lists>()),
        ("mlrt_camera", "struct_size", offset_of!(mlrt_camera, struct_size)),
        ("mlrt_camera", "projection", offset_of!(mlrt_camera, projection)),
        ("mlrt_camera", "width", offset_of!(mlrt_camera, width)),
        ("mlrt_camera", "height", offset_of!(mlrt_camera, height)),
        ("mlrt_camera", "crop_x", offset_of!(mlrt_camera, crop_x)),
        ("mlrt_camera", "crop_y", offset_of!(mlrt_camera, crop_y)),
        ("mlrt_camera", "crop_width", offset_of!(mlrt_camera, crop_width)),
        ("mlrt_camera", "crop_height", offset_of!(mlrt_camera, crop_height)),
        ("mlrt_camera", "eye", offset_of!(mlrt_camera, eye)),
        ("mlrt_camera", "direction", offset_of!(mlrt_camera, direction)),
        ("mlrt_camera", "d00", offset_of!(mlrt_camera, d00)),
        ("mlrt_camera", "dx", offset_of!(mlrt_camera, dx)),
        ("mlrt_camera", "dy", offset_of!(mlrt_camera, dy)),
        ("mlrt_camera", "sample_x", offset_of!(mlrt_camera, sample_x)),
        ("mlrt_camera", "sample_y", offset_of!(mlrt_camera, sample_y)),
        ("mlrt_camera", "t_min", offset_of!(mlrt_camera, t_min)),
        ("mlrt_camera", "t_max", offset_of!(mlrt_camera, t_max)),
        ("mlrt_camera", "sizeof", size_of::<mlrt_camera>()),
        ("mlrt_tile", "struct_size", offset_of!(mlrt_tile, struct_size)),
        ("mlrt_tile", "worker", offset_of!(mlrt_tile, worker)),
        ("mlrt_tile", "x", offset_of!(mlrt_tile, x)),
        ("mlrt_tile", "y", offset_of!(mlrt_tile, y)),
        ("mlrt_tile", "width", offset_of!(mlrt_tile, width)),
        ("mlrt_tile", "height", offset_of!(mlrt_tile, height)),
        ("mlrt_tile", "t", offset_of!(mlrt_tile, t)),
        ("mlrt_tile", "u", offset_of!(mlrt_tile, u)),
        ("mlrt_tile", "v", offset_of!(mlrt_tile, v)),
        ("mlrt_tile", "mesh", offset_of!(mlrt_tile, mesh)),
        ("mlrt_tile", "triangle", offset_of!(mlrt_tile, triangle)),
        ("mlrt_tile", "facing", offset_of!(mlrt_tile, facing)),
        ("mlrt_tile", "occluded", offset_of!(mlrt_tile, occluded)),
        ("mlrt_tile", "sizeof", size_of::<mlrt_tile>()),
        ("mlrt_light", "struct_size", offset_of!(mlrt_light, struct_size)),
        ("mlrt_light", "kind", offset_of!(mlrt_light, kind)),
        ("mlrt_light", "position", offset_of!(mlrt_light, position)),
        ("mlrt_light", "sizeof", size_of::<mlrt_light>()),
        ("mlrt_points", "struct_size", offset_of!(mlrt_points, struct_size)),
        ("mlrt_points", "row_length", offset_of!(mlrt_points, row_length)),
        ("mlrt_points", "count", offset_of!(mlrt_points, count)),
        ("mlrt_points", "positions", offset_of!(mlrt_points, positions)),
        ("mlrt_points", "skip", offset_of!(mlrt_points, skip)),
        ("mlrt_points", "sizeof", size_of::<mlrt_points>()),
    ]
}
