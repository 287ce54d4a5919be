// SPDX-License-Identifier: MIT
//! Where do rays hit triangles: the exact answers of libmlrt, for slices.
//!
//! ```
//! let vertices = [[0., 0., 5.], [1., 0., 5.], [0., 1., 5.]];
//! let tree = mlrt::Tree::new(&[mlrt::Mesh { id: 0, vertices: &vertices, triangles: &[[0, 1, 2]] }])?;
//! let hits = tree.trace(&[[0.25, 0.25, 0.]], &[[0., 0., 1.]], None)?;
//! assert_eq!((hits.t[0], hits.triangle[0]), (5., 0));
//! # Ok::<(), mlrt::Error>(())
//! ```
//!
//! Slices go in and vectors come out without a copy. Trees and pools are freed when they are dropped, and can be shared
//! among threads. A dropped one cannot be used:
//!
//! ```compile_fail,E0382
//! let tree = mlrt::Tree::new(&[]).unwrap();
//! drop(tree);
//! tree.trace(&[], &[], None);
//! ```
//!
//! What is not wrapped is in [`ffi`], which bindgen makes from the header.

use std::{ffi::c_void, ffi::CStr, fmt, mem::size_of, ptr, ptr::NonNull};

/// The C interface.
#[allow(non_camel_case_types, non_upper_case_globals, missing_docs, clippy::all)]
pub mod ffi {
    include!(concat!(env!("OUT_DIR"), "/mlrt.rs"));
}

/// Mesh and triangle of a miss.
pub const NONE: u32 = ffi::MLRT_NONE;

/// What the library says went wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// One of `ffi::MLRT_ERROR_*`.
    pub status: i32,
    /// More than the status says, or empty.
    pub details: String,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        // SAFETY: never NULL, and static.
        let text = unsafe { CStr::from_ptr(ffi::mlrt_status_string(self.status)) }.to_string_lossy();
        f.write_str(&text)?;
        if self.details.is_empty() {
            Ok(())
        } else {
            write!(f, ": {}", self.details)
        }
    }
}

impl std::error::Error for Error {}

fn check(status: i32, details: impl FnOnce() -> String) -> Result<(), Error> {
    if status == ffi::MLRT_OK as i32 {
        Ok(())
    } else {
        Err(Error { status, details: details() })
    }
}

/// Threads that calls share their work with. Calls that share a pool wait for each other.
pub struct Pool(NonNull<ffi::mlrt_pool>);

// SAFETY: mlrt.h, "Threads".
unsafe impl Send for Pool {}
unsafe impl Sync for Pool {}

impl Pool {
    /// `threads` at work, the calling one included; 0 = one per processor.
    pub fn new(threads: u32) -> Result<Pool, Error> {
        let mut pool = ptr::null_mut();
        check(unsafe { ffi::mlrt_create_pool(threads, &mut pool) }, String::new)?;
        Ok(Pool(NonNull::new(pool).expect("a pool")))
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        unsafe { ffi::mlrt_destroy_pool(self.0.as_ptr()) }
    }
}

/// An indexed mesh, borrowed until the tree is built. If all ids are 0, they become 0, 1, 2, ...
#[derive(Clone, Copy)]
pub struct Mesh<'a> {
    pub id: u32,
    pub vertices: &'a [[f32; 3]],
    pub triangles: &'a [[u32; 3]],
}

/// The closest hits, one element per ray. A miss has `t` infinite and `mesh` and `triangle` [`NONE`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hits {
    pub t: Vec<f32>,
    pub u: Vec<f32>,
    pub v: Vec<f32>,
    pub mesh: Vec<u32>,
    pub triangle: Vec<u32>,
    pub facing: Vec<i32>,
}

/// Triangles, and what finds them. Never changes.
pub struct Tree(NonNull<ffi::mlrt_tree>);

// SAFETY: mlrt.h, "Threads".
unsafe impl Send for Tree {}
unsafe impl Sync for Tree {}

impl Drop for Tree {
    fn drop(&mut self) {
        unsafe { ffi::mlrt_destroy_tree(self.0.as_ptr()) }
    }
}

/// What `call` writes to, as an output array of the library.
fn array<T>(data: &mut [T]) -> ffi::mlrt_array {
    ffi::mlrt_array { data: data.as_mut_ptr().cast::<c_void>(), ..Default::default() }
}

impl Tree {
    pub fn new(meshes: &[Mesh]) -> Result<Tree, Error> {
        let list: Vec<_> = meshes
            .iter()
            .map(|mesh| ffi::mlrt_mesh {
                struct_size: size_of::<ffi::mlrt_mesh>() as u32,
                id: mesh.id,
                vertices: mesh.vertices.as_ptr().cast(),
                vertex_count: mesh.vertices.len(),
                indices: mesh.triangles.as_ptr().cast(),
                triangle_count: mesh.triangles.len(),
                ..Default::default()
            })
            .collect();
        let mut message = [0u8; 256];
        let options = ffi::mlrt_tree_options {
            struct_size: size_of::<ffi::mlrt_tree_options>() as u32,
            message: message.as_mut_ptr().cast(),
            message_size: message.len(),
            ..Default::default()
        };
        let mut tree = ptr::null_mut();
        let status = unsafe { ffi::mlrt_build_tree(list.as_ptr(), list.len(), &options, &mut tree) };
        check(status, || CStr::from_bytes_until_nul(&message).unwrap_or_default().to_string_lossy().into_owned())?;
        Ok(Tree(NonNull::new(tree).expect("a tree")))
    }

    /// The closest hit of each ray.
    pub fn trace(&self, origins: &[[f32; 3]], directions: &[[f32; 3]], pool: Option<&Pool>) -> Result<Hits, Error> {
        let n = origins.len();
        let (ids, floats) = (vec![NONE; n], vec![0.; n]);
        let mut hits = Hits {
            t: floats.clone(),
            u: floats.clone(),
            v: floats,
            mesh: ids.clone(),
            triangle: ids,
            facing: vec![0; n],
        };
        let out = ffi::mlrt_hits {
            t: array(&mut hits.t),
            u: array(&mut hits.u),
            v: array(&mut hits.v),
            mesh: array(&mut hits.mesh),
            triangle: array(&mut hits.triangle),
            facing: array(&mut hits.facing),
            ..Default::default()
        };
        self.call(origins, directions, ffi::MLRT_QUERY_CLOSEST as i32, pool, out).map(|()| hits)
    }

    /// Does the ray hit anything at all?
    pub fn occluded(
        &self,
        origins: &[[f32; 3]],
        directions: &[[f32; 3]],
        pool: Option<&Pool>,
    ) -> Result<Vec<bool>, Error> {
        let mut occluded = vec![false; origins.len()]; // the library writes bytes 0 and 1
        let out = ffi::mlrt_hits { occluded: array(&mut occluded), ..Default::default() };
        self.call(origins, directions, ffi::MLRT_QUERY_ANY as i32, pool, out).map(|()| occluded)
    }

    /// The arrays of `out` have an element for each origin.
    fn call(
        &self,
        origins: &[[f32; 3]],
        directions: &[[f32; 3]],
        query: i32,
        pool: Option<&Pool>,
        mut out: ffi::mlrt_hits,
    ) -> Result<(), Error> {
        if origins.len() != directions.len() {
            let details = format!("{} origins, {} directions", origins.len(), directions.len());
            return Err(Error { status: ffi::MLRT_ERROR_ARGUMENT as i32, details });
        }
        out.struct_size = size_of::<ffi::mlrt_hits>() as u32;
        let input = |points: &[[f32; 3]]| ffi::mlrt_const_array { data: points.as_ptr().cast(), stride: 0 };
        let rays = ffi::mlrt_rays {
            struct_size: size_of::<ffi::mlrt_rays>() as u32,
            count: origins.len(),
            origins: input(origins),
            directions: input(directions),
            ..Default::default()
        };
        let options = ffi::mlrt_trace_options {
            struct_size: size_of::<ffi::mlrt_trace_options>() as u32,
            query,
            pool: pool.map_or(ptr::null_mut(), |pool| pool.0.as_ptr()),
            ..Default::default()
        };
        check(unsafe { ffi::mlrt_trace_packet(self.0.as_ptr(), &rays, &options, &out) }, String::new)
    }
}
