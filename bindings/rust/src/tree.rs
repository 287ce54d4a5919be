// SPDX-License-Identifier: MIT
//! Trees, and rays through them.

use std::any::Any;
use std::ffi::c_void;
use std::marker::PhantomData;
use std::ops::ControlFlow;
use std::panic::{catch_unwind, resume_unwind, AssertUnwindSafe};
use std::ptr::{self, NonNull};
use std::sync::Mutex;

use crate::arrays::{zeros, Output};
use crate::error::{check, Result};
use crate::ffi;
use crate::host::{Keeper, Kept};
use crate::options::{KdTreeOptions, LoadOptions, Query, TraceOptions, TreeOptions};
use crate::rays::{Camera, Hit, HitArrays, HitListArrays, HitLists, Hits, Light, Mesh, Points, Ray, Rays, Tile};

/// Points or vectors, one after the other.
type Points3 = Vec<[f32; 3]>;

/// The build report of a tree.
pub type TreeInfo = ffi::mlrt_tree_info;

/// An estimate of the memory that a builder takes.
pub type MemoryEstimate = ffi::mlrt_memory_estimate;

/// Receives each tile of a picture once, from the threads of the pool, several at a time; `Break` ends the render.
pub type TileCallback<'a> = dyn Fn(&Tile) -> ControlFlow<()> + Sync + 'a;

/// Triangles, and the structure that finds them. It never changes, and any number of threads may trace it at once.
///
/// `'data` is the life of the bytes that a tree loaded [in place](Tree::load_in_place) uses; other trees are
/// `Tree<'static>`.
pub struct Tree<'data> {
    handle: NonNull<ffi::mlrt_tree>,
    // Used by `handle`, and freed after it:
    _keeper: Option<Box<Keeper>>,
    _bytes: Option<Box<dyn Any + Send + Sync>>,
    data: PhantomData<&'data [u8]>,
}

// SAFETY: mlrt.h, "Threads".
unsafe impl Send for Tree<'_> {}
unsafe impl Sync for Tree<'_> {}

impl Drop for Tree<'_> {
    fn drop(&mut self) {
        // SAFETY: borrows of this tree have ended, and so have the calls that used it.
        unsafe { ffi::mlrt_destroy_tree(self.handle.as_ptr()) }
    }
}

impl std::fmt::Debug for Tree<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let info = self.info();
        write!(f, "Tree({} triangles, {} bytes)", info.triangle_count, info.memory_size)
    }
}

/// Meshes as structs of the C interface.
fn list(meshes: &[Mesh]) -> Vec<ffi::mlrt_mesh> {
    meshes.iter().map(|mesh| mesh.to_ffi()).collect()
}

/// Estimates the memory of [`Tree::build`] from the numbers of triangles alone.
pub fn estimate_tree(meshes: &[Mesh], options: &TreeOptions) -> Result<MemoryEstimate> {
    let (list, mut estimate) = (list(meshes), MemoryEstimate::default());
    let options = options.with_host(ptr::null());
    check(unsafe { ffi::mlrt_estimate_tree(list.as_ptr(), list.len(), &options, &mut estimate) })?;
    Ok(estimate)
}

/// Estimates the memory of [`Tree::build_kdtree`]: a guess, which can be off by a factor of two.
pub fn estimate_kdtree(meshes: &[Mesh], options: &KdTreeOptions) -> Result<MemoryEstimate> {
    let (list, mut estimate) = (list(meshes), MemoryEstimate::default());
    let options = options.with_host(ptr::null());
    check(unsafe { ffi::mlrt_estimate_kdtree(list.as_ptr(), list.len(), &options, &mut estimate) })?;
    Ok(estimate)
}

/// A hash of the ids, masks and corners of meshes, for [`LoadOptions::geometry_hash`].
pub fn hash_geometry(meshes: &[Mesh]) -> Result<u64> {
    let (list, mut hash) = (list(meshes), 0);
    check(unsafe { ffi::mlrt_hash_geometry(list.as_ptr(), list.len(), &mut hash) })?;
    Ok(hash)
}

/// Builds and loads.
impl Tree<'static> {
    /// Builds a hierarchy of boxes with default options: the best tree that the library has.
    pub fn new(meshes: &[Mesh]) -> Result<Tree<'static>> {
        Tree::build(meshes, &TreeOptions::default())
    }

    /// Builds a hierarchy of boxes.
    ///
    /// Triangles that can never be hit are left out, and counted in [`info`](Tree::info). The same input always gives the
    /// same tree.
    pub fn build(meshes: &[Mesh], options: &TreeOptions) -> Result<Tree<'static>> {
        let (list, mut tree) = (list(meshes), ptr::null_mut());
        let (result, kept) = options.host.with(|host| {
            let options = options.with_host(host);
            check(unsafe { ffi::mlrt_build_tree(list.as_ptr(), list.len(), &options, &mut tree) })
        });
        Tree::own(tree, result, kept, None)
    }

    /// Builds the paper's kd-tree, which is slower to build and to trace: for study.
    pub fn build_kdtree(meshes: &[Mesh], options: &KdTreeOptions) -> Result<Tree<'static>> {
        let (list, mut tree) = (list(meshes), ptr::null_mut());
        let (result, kept) = options.host.with(|host| {
            let options = options.with_host(host);
            check(unsafe { ffi::mlrt_build_kdtree(list.as_ptr(), list.len(), &options, &mut tree) })
        });
        Tree::own(tree, result, kept, None)
    }

    /// Makes a tree from a copy of the bytes that [`save`](Tree::save) wrote.
    pub fn load(bytes: &[u8], options: &LoadOptions) -> Result<Tree<'static>> {
        // SAFETY: the bytes are copied.
        unsafe { load(bytes, options, 0, None) }
    }

    /// Makes a tree that uses the bytes where they lie, and owns what has them: a file mapped into memory, for example.
    ///
    /// They are copied if they do not begin at a multiple of 64.
    pub fn load_owned<B>(bytes: B, options: &LoadOptions) -> Result<Tree<'static>>
    where
        B: AsRef<[u8]> + Send + Sync + 'static,
    {
        let owner = Box::new(bytes);
        let bytes: *const [u8] = (*owner).as_ref();
        // SAFETY: the tree keeps the owner, which is not touched meanwhile, and drops it last.
        unsafe { load(&*bytes, options, ffi::MLRT_LOAD_IN_PLACE, Some(owner)) }
    }
}

/// # Safety
///
/// With MLRT_LOAD_IN_PLACE the bytes stay as they are for as long as the tree lives.
unsafe fn load<'data>(
    bytes: &[u8],
    options: &LoadOptions,
    flags: u32,
    owner: Option<Box<dyn Any + Send + Sync>>,
) -> Result<Tree<'data>> {
    let mut tree = ptr::null_mut();
    let (result, kept) = options.host.with(|host| {
        let options = ffi::mlrt_load_options {
            flags,
            geometry_hash: options.geometry_hash,
            memory_limit: options.memory_limit,
            host,
            ..Default::default()
        };
        check(ffi::mlrt_load_tree(bytes.as_ptr().cast(), bytes.len(), &options, &mut tree))
    });
    Tree::own(tree, result, kept, owner)
}

impl<'data> Tree<'data> {
    /// What a builder has made, or its error.
    fn own(
        handle: *mut ffi::mlrt_tree,
        result: Result<()>,
        kept: Kept,
        bytes: Option<Box<dyn Any + Send + Sync>>,
    ) -> Result<Tree<'data>> {
        let tree = NonNull::new(handle).map(|handle| Tree { handle, _keeper: None, _bytes: bytes, data: PhantomData });
        let (keeper, panic) = kept.into_parts();
        if let Some(panic) = panic {
            drop(tree); // before the memory that it lies in
            resume_unwind(panic);
        }
        result?;
        let mut tree = tree.expect("a tree");
        tree._keeper = keeper;
        Ok(tree)
    }

    /// Makes a tree that uses the bytes where they lie, and takes next to no memory of its own. They are copied if they do
    /// not begin at a multiple of 64.
    ///
    /// The tree borrows the bytes:
    ///
    /// ```compile_fail,E0505
    /// let bytes = mlrt::Tree::new(&[])?.save()?;
    /// let tree = mlrt::Tree::load_in_place(&bytes, &Default::default())?;
    /// drop(bytes);
    /// tree.info();
    /// # Ok::<(), mlrt::Error>(())
    /// ```
    pub fn load_in_place(bytes: &'data [u8], options: &LoadOptions) -> Result<Tree<'data>> {
        // SAFETY: the bytes are borrowed for as long as the tree lives.
        unsafe { load(bytes, options, ffi::MLRT_LOAD_IN_PLACE, None) }
    }

    /// The handle of the C interface.
    pub fn as_ptr(&self) -> *mut ffi::mlrt_tree {
        self.handle.as_ptr()
    }

    /// The build report.
    pub fn info(&self) -> TreeInfo {
        let mut info = TreeInfo::default();
        // It cannot fail: neither is NULL, and the size is set.
        unsafe { ffi::mlrt_get_tree_info(self.as_ptr(), &mut info) };
        info
    }

    /// How many bytes the saved tree takes.
    pub fn saved_size(&self) -> Result<usize> {
        let mut size = 0;
        check(unsafe { ffi::mlrt_save_tree(self.as_ptr(), ptr::null_mut(), 0, &mut size) })?;
        Ok(size)
    }

    /// The tree as bytes, with its triangles.
    pub fn save(&self) -> Result<Vec<u8>> {
        let mut bytes = zeros(self.saved_size()?)?;
        self.save_into(&mut bytes)?;
        Ok(bytes)
    }

    /// Writes the tree to `bytes`, and returns how many it takes. If there are too few, nothing is written.
    pub fn save_into(&self, bytes: &mut [u8]) -> Result<usize> {
        let mut size = 0;
        check(unsafe { ffi::mlrt_save_tree(self.as_ptr(), bytes.as_mut_ptr().cast(), bytes.len(), &mut size) })?;
        Ok(size)
    }

    /// The closest hit of each ray.
    pub fn trace(&self, rays: &Rays, options: &TraceOptions) -> Result<Hits> {
        let mut hits = Hits::new(rays.to_ffi()?.count)?;
        self.trace_arrays(rays, Query::Closest, options, &mut hits.arrays())?;
        Ok(hits)
    }

    /// Does each ray hit anything?
    pub fn occluded(&self, rays: &Rays, options: &TraceOptions) -> Result<Vec<bool>> {
        let mut occluded = zeros(rays.to_ffi()?.count)?;
        let mut arrays = HitArrays { occluded: Some((&mut occluded).into()), ..Default::default() };
        self.trace_arrays(rays, Query::Any, options, &mut arrays)?;
        Ok(occluded.into_iter().map(|byte| byte != 0).collect())
    }

    /// Writes the answers to arrays of the program; the options' query says which.
    pub fn trace_into(&self, rays: &Rays, options: &TraceOptions, mut hits: HitArrays) -> Result<()> {
        self.trace_arrays(rays, options.query, options, &mut hits)
    }

    fn trace_arrays(&self, rays: &Rays, query: Query, options: &TraceOptions, hits: &mut HitArrays) -> Result<()> {
        let n = rays.len();
        let (rays, hits) = (rays.to_ffi()?, hits.as_ffi(n, 1)?);
        options.with(query, |options| check(unsafe { ffi::mlrt_trace_packet(self.as_ptr(), &rays, options, &hits) }))
    }

    /// The closest hit of one ray: `None` for a miss. For more than a few rays [`trace`](Tree::trace) is faster.
    pub fn trace_ray(&self, ray: &Ray, options: &TraceOptions) -> Result<Option<Hit>> {
        let hit = self.one_ray(ray, Query::Closest, options)?;
        Ok((hit.facing != 0).then_some(Hit {
            t: hit.t,
            u: hit.u,
            v: hit.v,
            mesh: hit.mesh,
            triangle: hit.triangle,
            facing: hit.facing,
        }))
    }

    /// Does one ray hit anything?
    pub fn occluded_ray(&self, ray: &Ray, options: &TraceOptions) -> Result<bool> {
        Ok(self.one_ray(ray, Query::Any, options)?.occluded != 0)
    }

    fn one_ray(&self, ray: &Ray, query: Query, options: &TraceOptions) -> Result<ffi::mlrt_hit> {
        let (ray, mut hit) = (ray.to_ffi(), ffi::mlrt_hit::default());
        options.with(query, |options| check(unsafe { ffi::mlrt_trace_ray(self.as_ptr(), &ray, options, &mut hit) }))?;
        Ok(hit)
    }

    /// All hits of each ray, in order, `capacity` at most; their totals count those beyond it, too.
    pub fn all_hits(&self, rays: &Rays, options: &TraceOptions, capacity: u32) -> Result<HitLists> {
        let rows = rays.to_ffi()?.count;
        let n = rows.saturating_mul(capacity as usize);
        let mut lists = HitLists {
            capacity: capacity as usize,
            t: zeros(n)?,
            u: zeros(n)?,
            v: zeros(n)?,
            mesh: zeros(n)?,
            triangle: zeros(n)?,
            facing: zeros(n)?,
            crossing: zeros(n)?,
            total: zeros(rows)?,
            crossing_total: zeros(rows)?,
        };
        fn wanted<'a, T: crate::Element>(vector: &'a mut Vec<T>, capacity: u32) -> Option<Output<'a, T>> {
            (capacity > 0).then(|| vector.into())
        }
        let arrays = HitListArrays {
            capacity,
            t: wanted(&mut lists.t, capacity),
            u: wanted(&mut lists.u, capacity),
            v: wanted(&mut lists.v, capacity),
            mesh: wanted(&mut lists.mesh, capacity),
            triangle: wanted(&mut lists.triangle, capacity),
            facing: wanted(&mut lists.facing, capacity),
            crossing: wanted(&mut lists.crossing, capacity),
            total: Some((&mut lists.total).into()),
            crossing_total: Some((&mut lists.crossing_total).into()),
        };
        self.all_hits_into(rays, options, arrays)?;
        Ok(lists)
    }

    /// Writes all hits of each ray to arrays of the program.
    pub fn all_hits_into(&self, rays: &Rays, options: &TraceOptions, mut lists: HitListArrays) -> Result<()> {
        let lists = lists.as_ffi(rays.len())?;
        let rays = rays.to_ffi()?;
        options.with(Query::Closest, |options| {
            check(unsafe { ffi::mlrt_trace_all_hits(self.as_ptr(), &rays, options, &lists) })
        })
    }

    /// The closest hits of a camera's pixels, row by row.
    pub fn render_hits(&self, camera: &Camera, options: &TraceOptions) -> Result<Hits> {
        let mut hits = Hits::new(camera.pixels()?)?;
        let options = TraceOptions { query: Query::Closest, ..options.clone() };
        self.render(camera, &options, Some(&mut hits.arrays()), None)?;
        Ok(hits)
    }

    /// Renders a picture, into arrays of the program (a row of pixels each [row step](Output::strided)), or to a callback,
    /// or both; at least one must be given. The options have the query, lights, and the outputs for the callback.
    ///
    /// The callback must not use the pool of the render, unless that pool has an executor. A panic in it ends the render,
    /// and goes on after it.
    pub fn render(
        &self,
        camera: &Camera,
        options: &TraceOptions,
        frame: Option<&mut HitArrays>,
        callback: Option<&TileCallback>,
    ) -> Result<()> {
        struct Call<'a> {
            callback: &'a TileCallback<'a>,
            panic: Mutex<Option<Box<dyn Any + Send>>>,
        }

        unsafe extern "C" fn tile(user: *mut c_void, tile: *const ffi::mlrt_tile) -> i32 {
            // SAFETY: both live until the callback returns.
            let (call, tile) = (&*user.cast_const().cast::<Call>(), &*tile);
            match catch_unwind(AssertUnwindSafe(|| (call.callback)(&Tile::from_ffi(tile)))) {
                Ok(ControlFlow::Continue(())) => 0,
                Ok(ControlFlow::Break(())) => 1,
                Err(panic) => {
                    *call.panic.lock().unwrap() = Some(panic);
                    1
                }
            }
        }

        let (columns, rows) = camera.size();
        let frame = frame.map(|frame| frame.as_ffi(columns, rows)).transpose()?;
        let frame = frame.as_ref().map_or(ptr::null(), |frame| frame as *const _);
        let camera = camera.to_ffi();
        let call = callback.map(|callback| Call { callback, panic: Mutex::new(None) });
        let user = call.as_ref().map_or(ptr::null(), |call| call as *const Call).cast_mut().cast();
        let function = call.as_ref().map(|_| tile as ffi::mlrt_tile_callback);
        let result = options.with(options.query, |options| {
            check(unsafe { ffi::mlrt_render_tiles(self.as_ptr(), &camera, options, frame, function, user) })
        });
        if let Some(panic) = call.and_then(|call| call.panic.into_inner().unwrap()) {
            resume_unwind(panic);
        }
        result
    }

    /// Is something between each point and the light?
    pub fn occluded_points(&self, points: &Points, light: &Light, options: &TraceOptions) -> Result<Vec<bool>> {
        let mut occluded = zeros(points.to_ffi()?.count)?;
        self.occluded_points_into(points, light, options, (&mut occluded).into())?;
        Ok(occluded.into_iter().map(|byte| byte != 0).collect())
    }

    /// The same, written to an array of the program: 1 if something is in between, 0 if nothing is.
    pub fn occluded_points_into(
        &self,
        points: &Points,
        light: &Light,
        options: &TraceOptions,
        mut occluded: Output<u8>,
    ) -> Result<()> {
        let occluded = occluded.array("occluded", points.len(), 1)?;
        let (points, light) = (points.to_ffi()?, light.to_ffi());
        options.with(Query::Any, |options| {
            check(unsafe { ffi::mlrt_occluded_points(self.as_ptr(), &points, &light, options, &occluded) })
        })
    }

    /// The ray that decides whether a light reaches the hit of a ray: `None` if the light is on the other side.
    pub fn shadow_ray(&self, ray: &Ray, hit: &Hit, light: &Light) -> Result<Option<Ray>> {
        let hit = ffi::mlrt_hit { mesh: hit.mesh, triangle: hit.triangle, ..Default::default() };
        let (mut shadow, mut faces) = (ffi::mlrt_ray::default(), 0);
        let (ray, light) = (ray.to_ffi(), light.to_ffi());
        check(unsafe { ffi::mlrt_shadow_ray(self.as_ptr(), &ray, &hit, &light, &mut shadow, &mut faces) })?;
        Ok((faces != 0).then(|| Ray::from_ffi(&shadow)))
    }

    /// A point just off a triangle, next to (1 - u - v) a + u b + v c, on the side to which its normal points (`side` +1) or
    /// on the other one (-1). The side from which a ray came is `-hit.facing`.
    pub fn offset_point(&self, mesh: u32, triangle: u32, u: f32, v: f32, side: i32) -> Result<[f32; 3]> {
        let mut point = [0.; 3];
        check(unsafe { ffi::mlrt_offset_point(self.as_ptr(), mesh, triangle, u, v, side, point.as_mut_ptr()) })?;
        Ok(point)
    }
}

impl Camera {
    /// The number of pixels of the crop. Of more than the library can count, the library says what is wrong.
    fn pixels(&self) -> Result<usize> {
        let (columns, rows) = self.size();
        let n = columns.saturating_mul(rows);
        if n > i32::MAX as usize {
            self.rays_into(None, None)?;
        }
        Ok(n)
    }

    /// The very rays that [`Tree::render`] traces, row by row: origins and directions.
    pub fn rays(&self) -> Result<(Points3, Points3)> {
        let n = self.pixels()?;
        let (mut origins, mut directions) = (zeros(n)?, zeros(n)?);
        self.rays_into(Some((&mut origins).into()), Some((&mut directions).into()))?;
        Ok((origins, directions))
    }

    /// The same, written to arrays of the program.
    pub fn rays_into(&self, origins: Option<Output<[f32; 3]>>, directions: Option<Output<[f32; 3]>>) -> Result<()> {
        let (columns, rows) = self.size();
        let array = |output: Option<Output<[f32; 3]>>, name: &str| {
            output.map_or(Ok(Default::default()), |mut output| output.array(name, columns, rows))
        };
        let (origins, directions) = (array(origins, "origins")?, array(directions, "directions")?);
        check(unsafe { ffi::mlrt_camera_rays(&self.to_ffi(), &origins, &directions) })
    }
}
