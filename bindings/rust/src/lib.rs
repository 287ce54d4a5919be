// SPDX-License-Identifier: MIT
//! Finds where rays hit triangles: exactly, fast, and with the same bits on every machine.
//!
//! ```
//! let vertices = [[0., 0., 5.], [1., 0., 5.], [0., 1., 5.]];
//! let tree = mlrt::Tree::new(&[mlrt::Mesh::new(&vertices, &[[0, 1, 2]])])?;
//! let rays = mlrt::Rays::new(&[[0.25, 0.25, 0.]], &[[0., 0., 1.]]);
//! let hits = tree.trace(&rays, &Default::default())?;
//! assert_eq!((hits.t[0], hits.triangle[0]), (5., 0));
//! # Ok::<(), mlrt::Error>(())
//! ```
//!
//! Slices go in and come out without a copy. Trees and pools are freed when they are dropped, and can be shared among
//! threads. One that is dropped cannot be used:
//!
//! ```compile_fail,E0382
//! let tree = mlrt::Tree::new(&[]).unwrap();
//! drop(tree);
//! tree.info();
//! ```
//!
//! The crate compiles the library, which is C in one file, and needs a C compiler for that. With the feature `system` it
//! links an installed one. The module [`ffi`] has the C interface itself, and `mlrt.h` is its manual.

#![warn(missing_docs)]

#[rustfmt::skip]
#[allow(non_camel_case_types)]
pub mod ffi;

mod arrays;
mod error;
mod host;
mod options;
mod pool;
mod rays;
mod tree;

#[doc(hidden)]
pub use arrays::field_at;
pub use arrays::{Element, Input, Output};
pub use error::{Error, ErrorKind, Result};
pub use host::{Host, Level, Log, Memory, Progress};
pub use options::{
    Counters, Culling, Isa, KdTreeOptions, KdTreePreset, LoadOptions, Method, Outputs, Preset, Query, Rules, Shortcuts,
    TraceOptions, TreeOptions,
};
pub use pool::{Executor, Job, Pool, PoolOptions};
pub use rays::{
    Camera, Hit, HitArrays, HitListArrays, HitLists, Hits, Indices, Light, Mesh, Points, Projection, Ray, Rays, Tile,
};
pub use tree::{estimate_kdtree, estimate_tree, hash_geometry, MemoryEstimate, TileCallback, Tree, TreeInfo};

/// The mesh and the triangle of a miss; in an array of triangles to skip: none.
pub const NONE: u32 = ffi::MLRT_NONE;

/// The version of the library: major, minor, patch. With the feature `system` it can differ from the crate's.
pub fn version() -> (u32, u32, u32) {
    let version = unsafe { ffi::mlrt_version() };
    (version / 10000, version / 100 % 100, version % 100)
}

/// Can the library use this instruction set on this machine?
pub fn can_use(isa: Isa) -> bool {
    let capabilities = unsafe { ffi::mlrt_capabilities() };
    match isa {
        Isa::Auto => true,
        Isa::Scalar => capabilities & (ffi::MLRT_CAN_SSE | ffi::MLRT_CAN_NEON) == 0,
        Isa::Sse => capabilities & ffi::MLRT_CAN_SSE != 0,
        Isa::Avx2 => capabilities & ffi::MLRT_CAN_AVX2 != 0,
        Isa::Avx512 => capabilities & ffi::MLRT_CAN_AVX512 != 0,
        Isa::Neon => capabilities & ffi::MLRT_CAN_NEON != 0,
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
