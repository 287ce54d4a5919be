// SPDX-License-Identifier: MIT
//! Meshes, rays, cameras and lights, and what comes back.

use std::mem::size_of;

use crate::arrays::{zeros, Element, Input, Output};
use crate::error::{Error, Result};
use crate::ffi;
use crate::NONE;

/// The triangles of a [`Mesh`].
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Indices<'a> {
    /// Triangle i has the vertices 3i, 3i + 1, 3i + 2.
    Consecutive,
    /// Three numbers of vertices each.
    U32(Input<'a, [u32; 3]>),
    /// The same, in 16 bits.
    U16(Input<'a, [u16; 3]>),
}

impl<'a, T: Into<Input<'a, [u32; 3]>>> From<T> for Indices<'a> {
    fn from(triangles: T) -> Self {
        Indices::U32(triangles.into())
    }
}

/// An indexed mesh, borrowed until the tree is built.
#[derive(Debug, Clone, Copy)]
pub struct Mesh<'a> {
    /// Reported with hits. Ids must differ; if all are 0, they become 0, 1, 2, ...
    pub id: u32,
    /// The vertices.
    pub vertices: Input<'a, [f32; 3]>,
    /// The triangles.
    pub triangles: Indices<'a>,
    /// Rays see the mesh if their mask has a bit in common with it; 0: all bits.
    pub mask: u32,
}

impl<'a> Mesh<'a> {
    /// A mesh of vertices and triangles of three numbers of vertices: `Mesh::new(&vertices, &triangles)`.
    pub fn new(vertices: impl Into<Input<'a, [f32; 3]>>, triangles: impl Into<Indices<'a>>) -> Self {
        Mesh { id: 0, vertices: vertices.into(), triangles: triangles.into(), mask: 0 }
    }

    pub(crate) fn to_ffi(self) -> ffi::mlrt_mesh {
        let mesh = ffi::mlrt_mesh {
            id: self.id,
            vertices: self.vertices.pointer().cast(),
            vertex_count: self.vertices.len(),
            vertex_stride: self.vertices.stride(),
            mask: self.mask,
            ..Default::default()
        };
        fn indices<T: Element>(mesh: ffi::mlrt_mesh, triangles: Input<T>) -> ffi::mlrt_mesh {
            ffi::mlrt_mesh {
                indices: triangles.pointer().cast(),
                triangle_count: triangles.len(),
                triangle_stride: triangles.stride(),
                index_size: (size_of::<T>() / 3) as u32,
                ..mesh
            }
        }
        match self.triangles {
            Indices::Consecutive => ffi::mlrt_mesh { triangle_count: self.vertices.len() / 3, ..mesh },
            Indices::U32(triangles) => indices(mesh, triangles),
            Indices::U16(triangles) => indices(mesh, triangles),
        }
    }
}

/// Rays, in arrays of the program.
///
/// Each array has an element per ray, or one that serves all ([`Input::all`]).
#[derive(Debug, Clone, Copy)]
pub struct Rays<'a> {
    /// Where the rays start.
    pub origins: Input<'a, [f32; 3]>,
    /// Where they go; of any length, which is the unit of t.
    pub directions: Input<'a, [f32; 3]>,
    /// Hits count from here on, exclusively; `None`: 0.
    pub t_min: Option<Input<'a, f32>>,
    /// Hits count up to here, inclusively; `None`: no limit.
    pub t_max: Option<Input<'a, f32>>,
    /// Mesh and triangle that the ray passes through; [`NONE`](crate::NONE): none.
    pub skip: Option<Input<'a, [u32; 2]>>,
    /// A mask for each ray, in place of that of the options.
    pub mask: Option<Input<'a, u32>>,
    /// Rays in a row of a picture; 0: not known. A hint for speed only.
    pub row_length: u32,
    /// Each so many neighbouring rays start at one point: then `origins`, `t_min` and `skip` have as many elements less.
    /// 0: 1.
    pub rays_per_origin: u32,
}

impl<'a> Rays<'a> {
    /// Rays of unlimited length: `Rays::new(&origins, &directions)`.
    pub fn new(origins: impl Into<Input<'a, [f32; 3]>>, directions: impl Into<Input<'a, [f32; 3]>>) -> Self {
        Rays {
            origins: origins.into(),
            directions: directions.into(),
            t_min: None,
            t_max: None,
            skip: None,
            mask: None,
            row_length: 0,
            rays_per_origin: 0,
        }
    }

    /// How many rays there are: as many as directions, or as origins if one direction serves all.
    pub fn len(&self) -> usize {
        match (self.directions.is_all(), self.origins.is_all()) {
            (false, _) => self.directions.len(),
            (true, false) => self.origins.len().saturating_mul(self.rays_per_origin.max(1) as usize),
            (true, true) => 1,
        }
    }

    /// Is there no ray?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn to_ffi(self) -> Result<ffi::mlrt_rays> {
        let count = self.len();
        let shared = self.rays_per_origin.max(1) as usize;
        if count % shared != 0 {
            let message = format!("rays.rays_per_origin: {shared} does not divide {count} rays");
            return Err(Error::argument(message));
        }
        Error::check_count("rays.count", count)?;
        fn optional<T: Element>(input: Option<Input<T>>, name: &str, len: usize) -> Result<ffi::mlrt_const_array> {
            input.map_or(Ok(Default::default()), |input| input.array(name, len))
        }
        Ok(ffi::mlrt_rays {
            row_length: self.row_length,
            count,
            origins: self.origins.array("rays.origins", count / shared)?,
            directions: self.directions.array("rays.directions", count)?,
            t_min: optional(self.t_min, "rays.t_min", count / shared)?,
            t_max: optional(self.t_max, "rays.t_max", count)?,
            skip: optional(self.skip, "rays.skip", count / shared)?,
            mask: optional(self.mask, "rays.mask", count)?,
            rays_per_origin: self.rays_per_origin,
            ..Default::default()
        })
    }
}

/// A limit of a struct of the C interface, in which 0 means none: a negative one instead, below which nothing lies.
fn limit(t_max: f32) -> f32 {
    match t_max {
        f32::INFINITY => 0.,
        0. => -1.,
        t => t,
    }
}

/// One ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes; of any length, which is the unit of t.
    pub direction: [f32; 3],
    /// Hits count from here on, exclusively.
    pub t_min: f32,
    /// Hits count up to here, inclusively.
    pub t_max: f32,
    /// Mesh and triangle that it passes through.
    pub skip: Option<[u32; 2]>,
}

impl Ray {
    /// A ray of unlimited length.
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Ray { origin, direction, t_min: 0., t_max: f32::INFINITY, skip: None }
    }

    pub(crate) fn to_ffi(self) -> ffi::mlrt_ray {
        let skip = self.skip.unwrap_or([0; 2]);
        ffi::mlrt_ray {
            flags: if self.skip.is_some() { ffi::MLRT_RAY_SKIP } else { 0 },
            origin: self.origin,
            direction: self.direction,
            t_min: self.t_min,
            t_max: limit(self.t_max),
            skip_mesh: skip[0],
            skip_triangle: skip[1],
            ..Default::default()
        }
    }

    pub(crate) fn from_ffi(ray: &ffi::mlrt_ray) -> Self {
        Ray {
            origin: ray.origin,
            direction: ray.direction,
            t_min: ray.t_min,
            t_max: if ray.t_max == 0. { f32::INFINITY } else { ray.t_max },
            skip: (ray.flags & ffi::MLRT_RAY_SKIP != 0).then_some([ray.skip_mesh, ray.skip_triangle]),
        }
    }
}

/// The closest hit of a ray, or a miss.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// The distance in units of the direction's length; infinite for a miss, and can be for a hit.
    pub t: f32,
    /// The weight of the triangle's second vertex.
    pub u: f32,
    /// The weight of its third vertex.
    pub v: f32,
    /// The id of the mesh; [`NONE`]: a miss.
    pub mesh: u32,
    /// The number of the triangle in its mesh; [`NONE`]: a miss.
    pub triangle: u32,
    /// +1 where the ray travels along the normal (b - a) x (c - a), -1 against it; 0: a miss.
    pub facing: i32,
}

impl Hit {
    /// What a ray that hits nothing has.
    pub const MISS: Hit = Hit { t: f32::INFINITY, u: 0., v: 0., mesh: NONE, triangle: NONE, facing: 0 };

    /// Is this a hit?
    pub fn is_hit(&self) -> bool {
        self.facing != 0
    }
}

impl Default for Hit {
    fn default() -> Self {
        Hit::MISS
    }
}

/// The closest hits of rays or pixels, an element for each; a miss is as in [`Hit::MISS`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hits {
    /// Distances.
    pub t: Vec<f32>,
    /// Weights of second vertices.
    pub u: Vec<f32>,
    /// Weights of third vertices.
    pub v: Vec<f32>,
    /// Ids of meshes.
    pub mesh: Vec<u32>,
    /// Numbers of triangles in their meshes.
    pub triangle: Vec<u32>,
    /// Signs of the sides hit.
    pub facing: Vec<i32>,
}

impl Hits {
    pub(crate) fn new(n: usize) -> Result<Hits> {
        Ok(Hits { t: zeros(n)?, u: zeros(n)?, v: zeros(n)?, mesh: zeros(n)?, triangle: zeros(n)?, facing: zeros(n)? })
    }

    pub(crate) fn arrays(&mut self) -> HitArrays<'_> {
        HitArrays {
            t: Some((&mut self.t).into()),
            u: Some((&mut self.u).into()),
            v: Some((&mut self.v).into()),
            mesh: Some((&mut self.mesh).into()),
            triangle: Some((&mut self.triangle).into()),
            facing: Some((&mut self.facing).into()),
            occluded: None,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.facing.len()
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.facing.is_empty()
    }

    /// Number i: `None` for a miss. Panics if there is no such ray.
    pub fn get(&self, i: usize) -> Option<Hit> {
        (self.facing[i] != 0).then(|| Hit {
            t: self.t[i],
            u: self.u[i],
            v: self.v[i],
            mesh: self.mesh[i],
            triangle: self.triangle[i],
            facing: self.facing[i],
        })
    }
}

/// The arrays that receive results: those that are `None` are not computed.
#[derive(Debug, Default)]
pub struct HitArrays<'a> {
    /// Distances.
    pub t: Option<Output<'a, f32>>,
    /// Weights of second vertices.
    pub u: Option<Output<'a, f32>>,
    /// Weights of third vertices.
    pub v: Option<Output<'a, f32>>,
    /// Ids of meshes.
    pub mesh: Option<Output<'a, u32>>,
    /// Numbers of triangles in their meshes.
    pub triangle: Option<Output<'a, u32>>,
    /// Signs of the sides hit.
    pub facing: Option<Output<'a, i32>>,
    /// [`Query::Any`](crate::Query::Any): 1 if something is hit. With lights: bit k is 1 if light k does not reach the hit.
    pub occluded: Option<Output<'a, u8>>,
}

fn optional<T: Element>(
    output: &mut Option<Output<T>>,
    name: &str,
    columns: usize,
    rows: usize,
) -> Result<ffi::mlrt_array> {
    output.as_mut().map_or(Ok(Default::default()), |output| output.array(name, columns, rows))
}

impl<'a> HitArrays<'a> {
    /// Results as a slice of structs, which are written together.
    pub fn records(hits: &'a mut [Hit]) -> Self {
        let (data, size) = (hits.as_mut_ptr().cast::<u8>(), std::mem::size_of_val(hits));
        let stride = size_of::<Hit>();
        macro_rules! field {
            ($name:ident) => {{
                let offset = std::mem::offset_of!(Hit, $name);
                Some(Output::field(data.wrapping_add(offset).cast(), stride, size.saturating_sub(offset)))
            }};
        }
        HitArrays {
            t: field!(t),
            u: field!(u),
            v: field!(v),
            mesh: field!(mesh),
            triangle: field!(triangle),
            facing: field!(facing),
            occluded: None,
        }
    }

    pub(crate) fn as_ffi(&mut self, columns: usize, rows: usize) -> Result<ffi::mlrt_hits> {
        Ok(ffi::mlrt_hits {
            t: optional(&mut self.t, "hits.t", columns, rows)?,
            u: optional(&mut self.u, "hits.u", columns, rows)?,
            v: optional(&mut self.v, "hits.v", columns, rows)?,
            mesh: optional(&mut self.mesh, "hits.mesh", columns, rows)?,
            triangle: optional(&mut self.triangle, "hits.triangle", columns, rows)?,
            facing: optional(&mut self.facing, "hits.facing", columns, rows)?,
            occluded: optional(&mut self.occluded, "hits.occluded", columns, rows)?,
            ..Default::default()
        })
    }
}

/// All hits of rays: hit j of ray i is element i * `capacity` + j. Elements behind the last hit of a ray are misses.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HitLists {
    /// Elements per ray.
    pub capacity: usize,
    /// Distances.
    pub t: Vec<f32>,
    /// Weights of second vertices.
    pub u: Vec<f32>,
    /// Weights of third vertices.
    pub v: Vec<f32>,
    /// Ids of meshes.
    pub mesh: Vec<u32>,
    /// Numbers of triangles in their meshes.
    pub triangle: Vec<u32>,
    /// Signs of the sides hit.
    pub facing: Vec<i32>,
    /// 1: the hit crosses the surface; 0: it only touches it, or there is no hit.
    pub crossing: Vec<u8>,
    /// Hits of each ray, with those beyond `capacity`.
    pub total: Vec<u32>,
    /// Those of them that cross the surface. Odd: the ray starts inside of a closed mesh.
    pub crossing_total: Vec<u32>,
}

/// The arrays that receive lists of hits, `capacity` elements per ray; those that are `None` are not written.
#[derive(Debug, Default)]
pub struct HitListArrays<'a> {
    /// Most hits written per ray; 0: only the totals are.
    pub capacity: u32,
    /// Distances.
    pub t: Option<Output<'a, f32>>,
    /// Weights of second vertices.
    pub u: Option<Output<'a, f32>>,
    /// Weights of third vertices.
    pub v: Option<Output<'a, f32>>,
    /// Ids of meshes.
    pub mesh: Option<Output<'a, u32>>,
    /// Numbers of triangles in their meshes.
    pub triangle: Option<Output<'a, u32>>,
    /// Signs of the sides hit.
    pub facing: Option<Output<'a, i32>>,
    /// 1: the hit crosses the surface.
    pub crossing: Option<Output<'a, u8>>,
    /// One per ray: the number of its hits.
    pub total: Option<Output<'a, u32>>,
    /// One per ray: the number of those that cross the surface.
    pub crossing_total: Option<Output<'a, u32>>,
}

impl HitListArrays<'_> {
    pub(crate) fn as_ffi(&mut self, rays: usize) -> Result<ffi::mlrt_hit_lists> {
        let n = rays.saturating_mul(self.capacity as usize);
        Ok(ffi::mlrt_hit_lists {
            capacity: self.capacity,
            t: optional(&mut self.t, "lists.t", n, 1)?,
            u: optional(&mut self.u, "lists.u", n, 1)?,
            v: optional(&mut self.v, "lists.v", n, 1)?,
            mesh: optional(&mut self.mesh, "lists.mesh", n, 1)?,
            triangle: optional(&mut self.triangle, "lists.triangle", n, 1)?,
            facing: optional(&mut self.facing, "lists.facing", n, 1)?,
            crossing: optional(&mut self.crossing, "lists.crossing", n, 1)?,
            total: optional(&mut self.total, "lists.total", rays, 1)?,
            crossing_total: optional(&mut self.crossing_total, "lists.crossing_total", rays, 1)?,
            ..Default::default()
        })
    }
}

/// How rays leave a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Projection {
    /// From one point.
    #[default]
    Pinhole,
    /// In one direction.
    Parallel,
}

/// The rays of a picture: pixel (i, j) has p = d00 + (i + sample\[0\]) dx + (j + sample\[1\]) dy, and the ray from `eye`
/// along p (pinhole), or from p along `direction` (parallel), in exactly the arithmetic that `mlrt.h` states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// How rays leave it.
    pub projection: Projection,
    /// Columns of the picture, 1 to 2^23.
    pub width: u32,
    /// Rows of the picture, 1 to 2^23.
    pub height: u32,
    /// Only these pixels: x, y, width, height; a width or height of 0: up to the last.
    pub crop: [u32; 4],
    /// Pinhole: where the rays start.
    pub eye: [f32; 3],
    /// Parallel: where the rays go.
    pub direction: [f32; 3],
    /// p of the corner of the first pixel.
    pub d00: [f32; 3],
    /// From one pixel to the next in a row.
    pub dx: [f32; 3],
    /// From one row to the next.
    pub dy: [f32; 3],
    /// Where in the pixel; 0.5: the middle.
    pub sample: [f32; 2],
    /// Hits count from here on, exclusively.
    pub t_min: f32,
    /// Hits count up to here, inclusively.
    pub t_max: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Camera {
            projection: Projection::Pinhole,
            width: 1,
            height: 1,
            crop: [0; 4],
            eye: [0.; 3],
            direction: [0.; 3],
            d00: [0.; 3],
            dx: [0.; 3],
            dy: [0.; 3],
            sample: [0.5; 2],
            t_min: 0.,
            t_max: f32::INFINITY,
        }
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    a.map(|x| x / length)
}

impl Camera {
    /// A pinhole camera at `eye` with `target` in the middle, `degrees` high. Pixels count from the upper left.
    pub fn look_at(eye: [f32; 3], target: [f32; 3], up: [f32; 3], degrees: f64, width: u32, height: u32) -> Camera {
        let eye64 = eye.map(f64::from);
        let forward = unit(std::array::from_fn(|k| f64::from(target[k]) - eye64[k]));
        let right = unit(cross(forward, up.map(f64::from)));
        let upward = cross(right, forward);
        let pixel = 2. * (degrees.to_radians() / 2.).tan() / f64::from(height);
        let corner = |k: usize| forward[k] + pixel * (upward[k] * f64::from(height) - right[k] * f64::from(width)) / 2.;
        Camera {
            width,
            height,
            eye,
            d00: std::array::from_fn(|k| corner(k) as f32),
            dx: right.map(|x| (x * pixel) as f32),
            dy: upward.map(|x| (-x * pixel) as f32),
            ..Default::default()
        }
    }

    /// Columns and rows of the crop: of what is rendered.
    pub fn size(&self) -> (usize, usize) {
        let side = |whole: u32, first: u32, count: u32| match count {
            0 => whole.saturating_sub(first),
            _ => count,
        };
        let [x, y, width, height] = self.crop;
        (side(self.width, x, width) as usize, side(self.height, y, height) as usize)
    }

    pub(crate) fn to_ffi(self) -> ffi::mlrt_camera {
        let [crop_x, crop_y, crop_width, crop_height] = self.crop;
        ffi::mlrt_camera {
            projection: match self.projection {
                Projection::Pinhole => ffi::MLRT_PROJECTION_PINHOLE,
                Projection::Parallel => ffi::MLRT_PROJECTION_PARALLEL,
            },
            width: self.width,
            height: self.height,
            crop_x,
            crop_y,
            crop_width,
            crop_height,
            eye: self.eye,
            direction: self.direction,
            d00: self.d00,
            dx: self.dx,
            dy: self.dy,
            sample_x: self.sample[0],
            sample_y: self.sample[1],
            t_min: self.t_min,
            t_max: limit(self.t_max),
            ..Default::default()
        }
    }
}

/// A light.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Light {
    /// At a point.
    Point([f32; 3]),
    /// Infinitely far away, in this direction, of any length.
    Directional([f32; 3]),
}

impl Light {
    pub(crate) fn to_ffi(self) -> ffi::mlrt_light {
        let (kind, position) = match self {
            Light::Point(position) => (ffi::MLRT_LIGHT_POINT, position),
            Light::Directional(direction) => (ffi::MLRT_LIGHT_DIRECTIONAL, direction),
        };
        ffi::mlrt_light { kind, position, ..Default::default() }
    }
}

/// Points that may lie in the shadow of a light.
#[derive(Debug, Clone, Copy)]
pub struct Points<'a> {
    /// Where they are.
    pub positions: Input<'a, [f32; 3]>,
    /// Mesh and triangle that each point lies on, which does not shade it; `None`: none.
    pub skip: Option<Input<'a, [u32; 2]>>,
    /// Points in a row of a picture; 0: a plain list. A hint for speed only.
    pub row_length: u32,
}

impl<'a> Points<'a> {
    /// Points: `Points::new(&positions)`.
    pub fn new(positions: impl Into<Input<'a, [f32; 3]>>) -> Self {
        Points { positions: positions.into(), skip: None, row_length: 0 }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        if self.positions.is_all() {
            1
        } else {
            self.positions.len()
        }
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn to_ffi(self) -> Result<ffi::mlrt_points> {
        let count = self.len();
        Error::check_count("points.count", count)?;
        Ok(ffi::mlrt_points {
            row_length: self.row_length,
            count,
            positions: self.positions.array("points.positions", count)?,
            skip: self.skip.map_or(Ok(Default::default()), |skip| skip.array("points.skip", count))?,
            ..Default::default()
        })
    }
}

/// The results of a finished tile, for the callback of [`Tree::render`](crate::Tree::render): those of pixel (x + i,
/// y + j) are element j * width + i. Those that the options' `outputs` do not name are `None`.
#[derive(Debug, Clone, Copy)]
pub struct Tile<'a> {
    /// The worker that calls, from 0; calls that run at the same time have different ones.
    pub worker: u32,
    /// The column of its first pixel, in the whole picture.
    pub x: u32,
    /// The row of its first pixel.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Distances.
    pub t: Option<&'a [f32]>,
    /// Weights of second vertices.
    pub u: Option<&'a [f32]>,
    /// Weights of third vertices.
    pub v: Option<&'a [f32]>,
    /// Ids of meshes.
    pub mesh: Option<&'a [u32]>,
    /// Numbers of triangles in their meshes.
    pub triangle: Option<&'a [u32]>,
    /// Signs of the sides hit.
    pub facing: Option<&'a [i32]>,
    /// As in [`HitArrays::occluded`].
    pub occluded: Option<&'a [u8]>,
}

impl<'a> Tile<'a> {
    /// SAFETY: the tile of a callback, which has not returned for as long as `'a`.
    pub(crate) unsafe fn from_ffi(tile: &'a ffi::mlrt_tile) -> Self {
        let n = tile.width as usize * tile.height as usize;
        unsafe fn slice<'a, T>(data: *const T, n: usize) -> Option<&'a [T]> {
            (!data.is_null()).then(|| std::slice::from_raw_parts(data, n))
        }
        Tile {
            worker: tile.worker,
            x: tile.x,
            y: tile.y,
            width: tile.width,
            height: tile.height,
            t: slice(tile.t, n),
            u: slice(tile.u, n),
            v: slice(tile.v, n),
            mesh: slice(tile.mesh, n),
            triangle: slice(tile.triangle, n),
            facing: slice(tile.facing, n),
            occluded: slice(tile.occluded, n),
        }
    }
}
