// SPDX-License-Identifier: MIT
//! How to build, load and trace. All options have defaults: write `TraceOptions { mask: 3, ..Default::default() }`.

use std::ops::BitOr;
use std::sync::Mutex;

use crate::ffi;
use crate::host::Host;
use crate::pool::Pool;
use crate::rays::Light;

/// An enum whose values are those of constants of the C interface.
macro_rules! choices {
    ($(#[$text:meta])* $name:ident: $type:ty { $($(#[$variant_text:meta])* $variant:ident = $value:ident,)* }) => {
        $(#[$text])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        #[non_exhaustive]
        pub enum $name { $($(#[$variant_text])* $variant,)* }

        impl $name {
            pub(crate) fn code(self) -> $type {
                match self { $($name::$variant => ffi::$value,)* }
            }
        }
    };
}

/// A set of flags of the C interface, which `|` joins.
macro_rules! flags {
    ($(#[$text:meta])* $name:ident { $($(#[$flag_text:meta])* $flag:ident = $value:ident,)* }) => {
        $(#[$text])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        pub struct $name(pub u32);

        impl $name {
            $($(#[$flag_text])* pub const $flag: $name = $name(ffi::$value);)*
        }

        impl BitOr for $name {
            type Output = $name;
            fn bitor(self, other: $name) -> $name {
                $name(self.0 | other.0)
            }
        }
    };
}

choices! {
    /// Presets of [`Tree::build`](crate::Tree::build).
    Preset: i32 {
        /// Faster to render than `Fast`, slower than `Best`.
        #[default]
        Default = MLRT_TREE_DEFAULT,
        /// Built fastest, for scenes that change.
        Fast = MLRT_TREE_FAST,
        /// Renders fastest, for many pictures of one scene: takes more memory and time to build.
        Best = MLRT_TREE_BEST,
    }
}

choices! {
    /// Presets of [`Tree::build_kdtree`](crate::Tree::build_kdtree).
    KdTreePreset: i32 {
        /// The paper's, as far as the paper tells.
        #[default]
        Paper = MLRT_KDTREE_PAPER,
        /// Larger leaves, smaller cells: renders faster, takes longer to build.
        Tuned = MLRT_KDTREE_TUNED,
    }
}

choices! {
    /// What is asked of rays, by [`Tree::trace_into`](crate::Tree::trace_into) and [`Tree::render`](crate::Tree::render).
    Query: i32 {
        /// The closest hit: all results but `occluded`.
        #[default]
        Closest = MLRT_QUERY_CLOSEST,
        /// Is there a hit? Only `occluded`.
        Any = MLRT_QUERY_ANY,
    }
}

choices! {
    /// Methods. All give the same answers.
    Method: i32 {
        /// `Tile` for boxes, `Multilevel` for kd-trees.
        #[default]
        Default = MLRT_METHOD_DEFAULT,
        /// One ray at a time, in double: the reference.
        Ray = MLRT_METHOD_RAY,
        /// Kd-trees: 2x2 rays with masks.
        Packet2 = MLRT_METHOD_PACKET2,
        /// Kd-trees: 4x4 rays from the root.
        Packet4 = MLRT_METHOD_PACKET4,
        /// Kd-trees: 4x4 rays from entry points of beams, the paper's method.
        Multilevel = MLRT_METHOD_MULTILEVEL,
        /// Boxes: tiles of 16 packets of 16 rays.
        Tile = MLRT_METHOD_TILE,
    }
}

choices! {
    /// Instruction sets. All give the same answers.
    Isa: i32 {
        /// The best that this machine has.
        #[default]
        Auto = MLRT_ISA_AUTO,
        /// Plain C.
        Scalar = MLRT_ISA_SCALAR,
        /// SSE2.
        Sse = MLRT_ISA_SSE,
        /// AVX2 and FMA.
        Avx2 = MLRT_ISA_AVX2,
        /// AVX-512 F and DQ.
        Avx512 = MLRT_ISA_AVX512,
        /// NEON, on aarch64.
        Neon = MLRT_ISA_NEON,
    }
}

choices! {
    /// How method multilevel tests a beam against a cell.
    Culling: i32 {
        /// The planes of the cell against the beam.
        #[default]
        Inverse = MLRT_CULLING_INVERSE,
        /// The planes of the beam against the cell.
        Direct = MLRT_CULLING_DIRECT,
    }
}

flags! {
    /// Rules of the kd-tree's builder, for [`KdTreeOptions::rules_off`].
    Rules {
        /// An empty side of more than 10 % of a cell is cut off first.
        EMPTY_SPACE = MLRT_RULE_EMPTY_SPACE,
        /// A plane that triangles in it cover wholly is a split.
        COPLANAR = MLRT_RULE_COPLANAR,
        /// Cells under a minimum size are not split.
        MINIMUM_CELL = MLRT_RULE_MINIMUM_CELL,
        /// Candidates come from triangles clipped to the cell.
        CLIPPED_SPLITS = MLRT_RULE_CLIPPED_SPLITS,
        /// A subtree that costs more than a leaf becomes a leaf.
        RETRACTION = MLRT_RULE_RETRACTION,
    }
}

flags! {
    /// Shortcuts of method multilevel, for [`TraceOptions::shortcuts_off`].
    Shortcuts {
        /// A tile that one triangle covers is done at once.
        WHOLE_TILES = MLRT_SHORTCUT_WHOLE_TILES,
        /// Packets start at a list of leaves.
        ENTRY_LISTS = MLRT_SHORTCUT_ENTRY_LISTS,
        /// Terms of a triangle and an origin are kept for the packets that follow.
        SHARED_SETUPS = MLRT_SHORTCUT_SHARED_SETUPS,
    }
}

flags! {
    /// The results that a tile callback receives.
    Outputs {
        /// `t`.
        T = MLRT_OUTPUT_T,
        /// `u` and `v`.
        UV = MLRT_OUTPUT_UV,
        /// `mesh` and `triangle`.
        IDS = MLRT_OUTPUT_IDS,
        /// `facing`.
        FACING = MLRT_OUTPUT_FACING,
        /// `triangle` without `mesh`.
        TRIANGLE = MLRT_OUTPUT_TRIANGLE,
        /// With lights: `occluded`.
        OCCLUDED = MLRT_OUTPUT_OCCLUDED,
    }
}

/// How to build a hierarchy of boxes: [`Tree::build`](crate::Tree::build).
#[derive(Debug, Clone, Default)]
pub struct TreeOptions<'a> {
    /// Fast to build, or fast to trace.
    pub preset: Preset,
    /// The cost of a node, 0 to 1e6, in units of a leaf's; 0: 1.
    pub traversal_cost: f32,
    /// The cost of a triangle in a leaf, 0 to 1e6, in the same units; 0: a small share of the leaf's.
    pub intersection_cost: f32,
    /// Most bytes held at one time; 0: no limit.
    pub memory_limit: u64,
    /// Whose threads build; `None`: the calling thread alone. The tree is the same.
    pub pool: Option<&'a Pool>,
    /// Memory, messages, progress.
    pub host: Host<'a>,
}

impl TreeOptions<'_> {
    pub(crate) fn with_host(&self, host: *const ffi::mlrt_host) -> ffi::mlrt_tree_options {
        ffi::mlrt_tree_options {
            preset: self.preset.code(),
            traversal_cost: self.traversal_cost,
            intersection_cost: self.intersection_cost,
            host,
            memory_limit: self.memory_limit,
            pool: self.pool.map_or(std::ptr::null_mut(), Pool::as_ptr),
            ..Default::default()
        }
    }
}

/// How to build the paper's kd-tree: [`Tree::build_kdtree`](crate::Tree::build_kdtree).
#[derive(Debug, Clone, Default)]
pub struct KdTreeOptions<'a> {
    /// The paper's parameters, or tuned ones.
    pub preset: KdTreePreset,
    /// The cost of a step, 0 to 1e6, relative to that of a triangle; 0: the preset's.
    pub traversal_cost: f32,
    /// The cost of a triangle, 0 to 1e6; 0: the preset's.
    pub intersection_cost: f32,
    /// Most bytes held at one time; 0: no limit.
    pub memory_limit: u64,
    /// Most leaf entries; 0: 8 per triangle + 1024.
    pub max_references: u64,
    /// Most inner nodes above a leaf, 1 to 60; 0: by the number of triangles.
    pub max_depth: u32,
    /// Rules to do without.
    pub rules_off: Rules,
    /// Whose threads build; `None`: the calling thread alone. The tree is the same.
    pub pool: Option<&'a Pool>,
    /// Memory, messages, progress.
    pub host: Host<'a>,
}

impl KdTreeOptions<'_> {
    pub(crate) fn with_host(&self, host: *const ffi::mlrt_host) -> ffi::mlrt_kdtree_options {
        ffi::mlrt_kdtree_options {
            preset: self.preset.code(),
            traversal_cost: self.traversal_cost,
            intersection_cost: self.intersection_cost,
            host,
            memory_limit: self.memory_limit,
            max_references: self.max_references,
            max_depth: self.max_depth,
            rules_off: self.rules_off.0,
            pool: self.pool.map_or(std::ptr::null_mut(), Pool::as_ptr),
            ..Default::default()
        }
    }
}

/// How to load a saved tree: [`Tree::load`](crate::Tree::load).
#[derive(Debug, Clone, Default)]
pub struct LoadOptions<'a> {
    /// The [`hash_geometry`](crate::hash_geometry) of the meshes that the tree must be of; 0: any.
    pub geometry_hash: u64,
    /// Most bytes held at one time; 0: no limit.
    pub memory_limit: u64,
    /// Memory and messages; progress is not called.
    pub host: Host<'a>,
}

/// Counts of the work of tracing. Each call adds to them.
pub type Counters = ffi::mlrt_counters;

/// How to trace.
#[derive(Debug, Clone, Default)]
pub struct TraceOptions<'a> {
    /// What `trace_into` and `render` ask; the other functions say it by their names.
    pub query: Query,
    /// The method.
    pub method: Method,
    /// The instruction set.
    pub isa: Isa,
    /// Method multilevel: how beams are tested against cells.
    pub culling: Culling,
    /// Method multilevel: check cells that the culling test leaves undecided against all their faces.
    pub culling_check: bool,
    /// Pixels, 4 to 1024, a power of two; 0: by source and method.
    pub initial_tile_size: u32,
    /// Method multilevel: pixels, 4 to `initial_tile_size`, a power of two; 0: default.
    pub minimum_tile_size: u32,
    /// Method multilevel: 4 or 16; 0: 16.
    pub split_factor: u32,
    /// The results that the callback of `render` receives.
    pub outputs: Outputs,
    /// Method multilevel: shortcuts to do without.
    pub shortcuts_off: Shortcuts,
    /// Rays see the meshes whose mask has a bit in common with it; 0: all bits.
    pub mask: u32,
    /// Whose threads trace; `None`: the calling thread alone.
    pub pool: Option<&'a Pool>,
    /// Counts the work, with narrower kernels; locked during the call.
    pub counters: Option<&'a Mutex<Counters>>,
    /// Memory, messages, progress.
    pub host: Host<'a>,
    /// `render` of closest hits: lights, 8 at most, whose shadows `occluded` receives.
    pub lights: &'a [Light],
}

impl TraceOptions<'_> {
    /// Calls `function` with this as the C interface's options, and with this query.
    pub(crate) fn with<T>(&self, query: Query, function: impl FnOnce(*const ffi::mlrt_trace_options) -> T) -> T {
        let lights: Vec<_> = self.lights.iter().copied().map(Light::to_ffi).collect();
        let mut counters =
            self.counters.map(|counters| counters.lock().unwrap_or_else(|poisoned| poisoned.into_inner()));
        if let Some(counters) = &mut counters {
            // The program may have set it to anything.
            counters.struct_size = Counters::default().struct_size;
        }
        let (result, kept) = self.host.with(|host| {
            let options = ffi::mlrt_trace_options {
                query: query.code(),
                method: self.method.code(),
                isa: self.isa.code(),
                culling: self.culling.code(),
                culling_check: self.culling_check.into(),
                initial_tile_size: self.initial_tile_size,
                minimum_tile_size: self.minimum_tile_size,
                split_factor: self.split_factor,
                outputs: self.outputs.0,
                shortcuts_off: self.shortcuts_off.0,
                mask: self.mask,
                pool: self.pool.map_or(std::ptr::null_mut(), Pool::as_ptr),
                counters: counters.as_mut().map_or(std::ptr::null_mut(), |counters| &mut **counters),
                host,
                lights: if lights.is_empty() { std::ptr::null() } else { lights.as_ptr() },
                light_count: lights.len() as u32,
                ..Default::default()
            };
            function(&options)
        });
        kept.resume();
        result
    }
}
