// SPDX-License-Identifier: MIT
//! The scene of bindings/c/scene.h: prints the hash of its answers, and the layouts of all structs, and tries everything
//! that the crate has. That a dropped tree cannot be used, nor the bytes that one borrows, is tested in its documentation.

use std::alloc::Layout;
use std::ops::ControlFlow;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use mlrt::*;

struct Draw(u32);

impl Draw {
    fn number(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1664525).wrapping_add(1013904223);
        self.0 >> 20
    }
    fn point(&mut self, divisor: f32) -> [f32; 3] {
        std::array::from_fn(|_| (self.number() as f32 - 2048.) / divisor)
    }
    fn triangle(&mut self) -> [u32; 3] {
        std::array::from_fn(|_| self.number() % 100)
    }
}

type Arrays = (Vec<[f32; 3]>, Vec<[u32; 3]>);

struct Scene {
    arrays: [Arrays; 2],
    origins: Vec<[f32; 3]>,
    directions: Vec<[f32; 3]>,
}

impl Scene {
    fn new() -> Scene {
        let mut draw = Draw(1);
        let mut arrays: [Arrays; 2] = Default::default();
        for (vertices, triangles) in &mut arrays {
            vertices.extend((0..100).map(|_| draw.point(256.)));
            triangles.extend((0..150).map(|_| draw.triangle()));
        }
        let (mut origins, mut directions) = (Vec::new(), Vec::new());
        for i in 0..1000 {
            origins.push(draw.point(256.));
            directions.push(draw.point(2048.));
            if i % 4 == 3 {
                directions[i] = std::array::from_fn(|k| arrays[0].0[i % 100][k] - origins[i][k]);
            }
        }
        Scene { arrays, origins, directions }
    }

    fn meshes(&self) -> [Mesh<'_>; 2] {
        let mesh = |id, m: usize| Mesh { id, ..Mesh::new(&self.arrays[m].0, &self.arrays[m].1) };
        [mesh(7, 0), mesh(3, 1)]
    }

    fn rays(&self) -> Rays<'_> {
        Rays::new(&self.origins, &self.directions)
    }

    fn tree(&self) -> Tree<'static> {
        Tree::new(&self.meshes()).unwrap()
    }
}

fn hash(hits: &Hits) -> u64 {
    let mut hash = 0xCBF29CE484222325u64;
    for i in 0..hits.len() {
        let floats = [hits.t[i], hits.u[i], hits.v[i]].map(f32::to_bits);
        let words = [floats[0], floats[1], floats[2], hits.mesh[i], hits.triangle[i], hits.facing[i] as u32];
        for byte in words.iter().flat_map(|word| word.to_le_bytes()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x100000001B3);
        }
    }
    hash
}

/// Two triangles, one behind the other, seen along z.
const WALLS: [[f32; 3]; 6] = [[-9., -9., 5.], [9., -9., 5.], [0., 9., 5.], [-9., -9., 8.], [9., -9., 8.], [0., 9., 8.]];

fn walls() -> Tree<'static> {
    Tree::new(&[Mesh::new(&WALLS, Indices::Consecutive)]).unwrap()
}

#[test]
fn the_same_answers() -> Result<()> {
    let scene = Scene::new();
    let (tree, pool) = (scene.tree(), Pool::new(2)?);
    let hits = tree.trace(&scene.rays(), &Default::default())?;
    let threads = TraceOptions { pool: Some(&pool), ..Default::default() };
    assert_eq!(tree.trace(&scene.rays(), &threads)?, hits);
    let expected: Vec<bool> = hits.mesh.iter().map(|&mesh| mesh != NONE).collect();
    assert_eq!(tree.occluded(&scene.rays(), &threads)?, expected);
    std::thread::scope(|scope| {
        let other = scope.spawn(|| tree.trace(&scene.rays(), &threads));
        assert_eq!(other.join().unwrap().unwrap(), hits);
    });
    println!("\n{:016x}", hash(&hits));
    Ok(())
}

#[test]
fn layouts_are_those_of_the_header() {
    // bindings/test.sh compares each line with the header.
    for (structure, field, place) in ffi::layouts() {
        println!("layout {structure} {field} {place}");
    }
    let mut sizes = [0u32; 64];
    unsafe { ffi::mlrt_struct_sizes(sizes.as_mut_ptr(), sizes.len() as u32) };
    assert_eq!(sizes[ffi::MLRT_STRUCT_TRACE_OPTIONS] as usize, std::mem::size_of::<ffi::mlrt_trace_options>());
    assert_eq!(version(), (0, 1, 0));
    assert!(can_use(Isa::Scalar) != can_use(Isa::Sse) && can_use(Isa::Sse) >= can_use(Isa::Avx2));
}

#[test]
fn errors_say_what_is_wrong() {
    let wrong = Mesh { id: 5, ..Mesh::new(&WALLS, &[[0, 1, 2], [0, 1, 6]]) };
    let error = Tree::new(&[wrong]).unwrap_err();
    assert_eq!((error.kind(), error.status()), (ErrorKind::IndexRange, ffi::MLRT_ERROR_INDEX_RANGE));
    assert!(error.to_string().contains("triangle 1: vertex index 6"), "{error}");
    assert!(error.to_string().ends_with(error.message()), "{error}");

    let error = Pool::new(5000).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Argument);
    assert!(error.message().contains("thread_count: 5000"), "{error}");
    let tree = walls();
    let origins = [[0.; 3]; 2];
    let error = tree.trace(&Rays::new(&origins, &[[1.; 3]]), &Default::default()).unwrap_err();
    assert!(error.message().contains("origins: 2 elements, where 1"), "{error}");
    let mut short = [0.; 1];
    let hits = HitArrays { t: Some(short.as_mut_slice().into()), ..Default::default() };
    let error = tree.trace_into(&Rays::new(&origins, &origins), &Default::default(), hits).unwrap_err();
    assert!(error.message().contains("hits.t"), "{error}");
    let error =
        tree.trace(&Rays::new(&origins, &origins), &TraceOptions { initial_tile_size: 5, ..Default::default() });
    assert!(error.as_ref().unwrap_err().message().contains("initial_tile_size: 5"), "{error:?}");
    assert_eq!(error.unwrap_err().kind(), ErrorKind::Argument);
    assert_eq!(tree.render_hits(&Camera::default(), &Default::default()).unwrap_err().kind(), ErrorKind::Camera);
    let options = TraceOptions { method: Method::Packet2, ..Default::default() };
    assert_eq!(tree.trace(&Rays::new(&origins, &origins), &options).unwrap_err().kind(), ErrorKind::Unsupported);
    let none = Rays::new(&[], &[]);
    assert!(tree.trace(&none, &Default::default()).unwrap().is_empty());
    assert!(tree.all_hits(&none, &Default::default(), 2).unwrap().total.is_empty());
    let no_pixels = tree.render_hits(&Camera { width: 0, ..Default::default() }, &Default::default());
    assert_eq!(no_pixels.unwrap_err().kind(), ErrorKind::Camera);
    assert_eq!(Tree::load(b"no tree", &Default::default()).unwrap_err().kind(), ErrorKind::Data);
    let empty = Tree::new(&[]).unwrap();
    assert_eq!(empty.trace(&Rays::new(&[[0.; 3]], &[[1.; 3]]), &Default::default()).unwrap().mesh, [NONE]);
}

#[test]
fn sizes_beyond_all_memory_are_errors() {
    let (tree, options) = (walls(), TraceOptions::default());
    let origins = [[0.; 3]; 1000];
    let rays = Rays { rays_per_origin: u32::MAX, ..Rays::new(&origins, Input::all(&[0., 0., 1.])) };
    assert_eq!(tree.trace(&rays, &options).unwrap_err().kind(), ErrorKind::TooLarge);
    assert_eq!(tree.occluded(&rays, &options).unwrap_err().kind(), ErrorKind::TooLarge);
    assert_eq!(tree.all_hits(&rays, &options, 1).unwrap_err().kind(), ErrorKind::TooLarge);
    let rays = Rays::new(&origins, &origins);
    assert_eq!(tree.all_hits(&rays, &options, u32::MAX).unwrap_err().kind(), ErrorKind::OutOfMemory);
    for side in [1 << 23, u32::MAX] {
        let camera = Camera { width: side, height: side, ..Camera::look_at([0.; 3], WALLS[0], [0., 1., 0.], 9., 1, 1) };
        assert_eq!(tree.render_hits(&camera, &options).unwrap_err().kind(), ErrorKind::TooLarge);
        assert_eq!(camera.rays().unwrap_err().kind(), ErrorKind::TooLarge);
    }
}

#[test]
fn strides_that_no_slice_has() -> Result<()> {
    // Steps of usize::MAX bytes would be one element for all, here one of no numbers.
    let (tree, directions) = (walls(), [[0., 0., 1.]; 4]);
    for numbers in [vec![], vec![0.; 3]] {
        let rays = Rays::new(Input::strided(&numbers, usize::MAX), &directions);
        assert_eq!(tree.trace(&rays, &Default::default()).unwrap_err().kind(), ErrorKind::Argument);
    }
    assert!(catch_unwind(|| Input::<[f32; 3]>::strided(&[], 0)).is_err());

    // Rows that share pixels, and rows within each other: a picture on its side.
    let camera = Camera::look_at([0.; 3], [0., 0., 5.], [0., 1., 0.], 120., 40, 30);
    let picture = tree.render_hits(&camera, &Default::default())?;
    let mut t = vec![0.; 1200];
    let mut frame = HitArrays { t: Some(Output::strided(&mut t, 1, 39)), ..Default::default() };
    let error = tree.render(&camera, &Default::default(), Some(&mut frame), None).unwrap_err();
    assert!(error.message().contains("overlap with a row step of 39"), "{error}");
    let mut frame = HitArrays { t: Some(Output::strided(&mut t, 30, 1)), ..Default::default() };
    tree.render(&camera, &Default::default(), Some(&mut frame), None)?;
    assert!((0..1200).all(|i| t[i % 40 * 30 + i / 40] == picture.t[i]));
    Ok(())
}

#[test]
fn counters_of_any_size_are_those_of_the_crate() -> Result<()> {
    let tree = walls();
    for struct_size in [0, 8, 168, u32::MAX] {
        let counters = Mutex::new(Counters { struct_size, ..Default::default() });
        let options = TraceOptions { counters: Some(&counters), ..Default::default() };
        tree.trace(&Rays::new(&[[0.; 3]], &[[0., 0., 1.]]), &options)?;
        assert_eq!(counters.lock().unwrap().ray_count, 1);
    }
    Ok(())
}

#[test]
fn how_a_tree_is_built_changes_no_answer() -> Result<()> {
    let scene = Scene::new();
    let hits = scene.tree().trace(&scene.rays(), &Default::default())?;
    let (pool, messages) = (Pool::new(2)?, Mutex::new(Vec::new()));
    let log = |level, message: &str| messages.lock().unwrap().push((level, message.to_string()));
    let log: &Log = &log;
    let host = Host { log: Some(log), ..Default::default() };
    let options = TreeOptions {
        preset: Preset::Best,
        traversal_cost: 2.,
        intersection_cost: 0.5,
        memory_limit: 1 << 24,
        pool: Some(&pool),
        host: host.clone(),
    };
    let tree = Tree::build(&scene.meshes(), &options)?;
    assert_eq!(tree.trace(&scene.rays(), &Default::default())?, hits);
    assert_eq!(tree.info().structure, ffi::MLRT_STRUCTURE_BVH);
    assert!(estimate_tree(&scene.meshes(), &options)?.memory_size > 0);
    assert!(messages.lock().unwrap().iter().any(|(level, _)| *level == Level::Info), "{messages:?}");
    let little = TreeOptions { memory_limit: 100, host: host.clone(), ..Default::default() };
    assert_eq!(Tree::build(&scene.meshes(), &little).unwrap_err().kind(), ErrorKind::OutOfMemory);
    assert!(messages.lock().unwrap().iter().any(|(level, _)| *level == Level::Error), "{messages:?}");

    let options = KdTreeOptions {
        preset: KdTreePreset::Tuned,
        traversal_cost: 1.,
        intersection_cost: 2.,
        memory_limit: 1 << 24,
        max_references: 100_000,
        max_depth: 5,
        rules_off: Rules::COPLANAR | Rules::RETRACTION,
        pool: Some(&pool),
        host,
    };
    let tree = Tree::build_kdtree(&scene.meshes(), &options)?;
    assert_eq!((tree.info().structure, tree.info().depth), (ffi::MLRT_STRUCTURE_KDTREE, 5));
    assert!(estimate_kdtree(&scene.meshes(), &options)?.memory_size > 0);
    for method in [Method::Default, Method::Ray, Method::Packet2, Method::Packet4, Method::Multilevel] {
        let counters = Mutex::new(Counters::default());
        let options = TraceOptions {
            method,
            isa: if can_use(Isa::Scalar) { Isa::Scalar } else { Isa::Sse },
            culling: Culling::Direct,
            culling_check: true,
            initial_tile_size: 16,
            minimum_tile_size: 8,
            split_factor: 4,
            shortcuts_off: Shortcuts::WHOLE_TILES | Shortcuts::ENTRY_LISTS,
            counters: Some(&counters),
            ..Default::default()
        };
        assert_eq!(tree.trace(&scene.rays(), &options)?, hits);
        assert_eq!(counters.lock().unwrap().ray_count, 1000);
    }
    Ok(())
}

#[test]
fn arrays_may_have_any_shape() -> Result<()> {
    #[derive(Clone, Copy)]
    struct Vertex {
        _normal: [f32; 3],
        position: [f32; 3],
    }

    let scene = Scene::new();
    let tree = scene.tree();
    let hits = tree.trace(&scene.rays(), &Default::default())?;

    // Meshes of structs, and of 16-bit indices with a fourth one.
    let structs: Vec<_> = scene.arrays[0].0.iter().map(|&position| Vertex { _normal: [9.; 3], position }).collect();
    let short: Vec<u16> = scene.arrays[0].1.iter().flat_map(|t| [t[0] as u16, t[1] as u16, t[2] as u16, 999]).collect();
    let mut meshes = scene.meshes();
    meshes[0].vertices = field!(structs, Vertex, position);
    meshes[0].triangles = Indices::U16(Input::strided(&short, 4));
    assert_eq!(hash_geometry(&meshes)?, hash_geometry(&scene.meshes())?);
    assert_eq!(Tree::new(&meshes)?.trace(&scene.rays(), &Default::default())?, hits);

    // Rays with padding, hits as structs.
    let padded: Vec<f32> = scene.directions.iter().flat_map(|d| [d[0], d[1], d[2], 9.]).collect();
    let rays = Rays { row_length: 100, ..Rays::new(&scene.origins, Input::strided(&padded, 4)) };
    let mut records = vec![Hit::default(); rays.len()];
    tree.trace_into(&rays, &Default::default(), HitArrays::records(&mut records))?;
    for (i, record) in records.iter().enumerate() {
        assert_eq!(record.is_hit().then_some(*record), hits.get(i));
    }
    let mut apart = vec![-1.; 3000];
    let arrays = HitArrays { t: Some(Output::strided(&mut apart, 3, 0)), ..Default::default() };
    tree.trace_into(&rays, &Default::default(), arrays)?;
    assert!((0..1000).all(|i| apart[3 * i] == hits.t[i] && apart[3 * i + 1] == -1.));

    // One origin and one limit for all; four rays from each origin.
    let origin = scene.origins[5];
    let all = Rays { t_max: Some(Input::all(&0.5)), ..Rays::new(Input::all(&origin), &scene.directions) };
    let (limits, origins) = (vec![0.5; 1000], vec![origin; 1000]);
    let written_out = Rays { t_max: Some((&limits).into()), ..Rays::new(&origins, &scene.directions) };
    assert_eq!(tree.trace(&all, &Default::default())?, tree.trace(&written_out, &Default::default())?);
    let every_fourth: Vec<_> = scene.origins.iter().copied().step_by(4).collect();
    let repeated: Vec<_> = (0..1000).map(|i| scene.origins[i / 4 * 4]).collect();
    let bundles = Rays { rays_per_origin: 4, ..Rays::new(&every_fourth, &scene.directions) };
    let expected = tree.trace(&Rays::new(&repeated, &scene.directions), &Default::default())?;
    assert_eq!(tree.trace(&bundles, &Default::default())?, expected);
    assert!(tree.trace(&Rays { rays_per_origin: 3, ..bundles }, &Default::default()).is_err());
    Ok(())
}

#[test]
fn limits_skips_and_masks() -> Result<()> {
    let tree = Tree::new(&[Mesh { id: 4, ..Mesh::new(&WALLS, Indices::Consecutive) }])?;
    let (origins, directions) = ([[0.; 3]; 4], [[0., 0., 1.]; 4]);
    let rays = Rays {
        t_min: Some((&[0., 5., 0., 0.]).into()),
        t_max: Some((&[f32::INFINITY, f32::INFINITY, 4.5, 9.]).into()),
        skip: Some((&[[NONE; 2], [NONE; 2], [NONE; 2], [4, 0]]).into()),
        ..Rays::new(&origins, &directions)
    };
    assert_eq!(tree.trace(&rays, &Default::default())?.triangle, [0, 1, NONE, 1]);

    let ray = Ray::new([0.; 3], [0., 0., 1.]);
    let triangle = |ray| tree.trace_ray(&ray, &Default::default()).unwrap().map(|hit| hit.triangle);
    assert_eq!(triangle(ray), Some(0));
    assert_eq!(triangle(Ray { t_min: 5., ..ray }), Some(1));
    assert_eq!(triangle(Ray { t_max: 4.5, ..ray }), None);
    assert_eq!(triangle(Ray { t_max: 0., ..ray }), None);
    assert_eq!(triangle(Ray { skip: Some([4, 0]), ..ray }), Some(1));
    assert_eq!(triangle(Ray { skip: Some([4, 1]), t_min: 5., ..ray }), None);
    assert!(
        tree.occluded_ray(&ray, &Default::default())?
            && !tree.occluded_ray(&Ray { t_max: 4., ..ray }, &Default::default())?
    );

    let meshes =
        [Mesh { mask: 1, ..Mesh::new(&WALLS, &[[0, 1, 2]]) }, Mesh { mask: 2, ..Mesh::new(&WALLS, &[[3, 4, 5]]) }];
    let tree = Tree::new(&meshes)?;
    let options = TraceOptions { mask: 2, ..Default::default() };
    let masks = [0, 1, 2, 4];
    let rays = Rays { mask: Some((&masks).into()), ..Rays::new(&origins, &directions) };
    assert_eq!(tree.trace(&rays, &Default::default())?.mesh, [0, 0, 1, NONE]);
    assert_eq!(tree.trace(&Rays::new(&origins, &directions), &options)?.mesh, [1; 4]);
    Ok(())
}

#[test]
fn pictures_with_lights_to_frames_and_callbacks() -> Result<()> {
    let tree = walls();
    let camera =
        Camera { crop: [8, 8, 48, 40], ..Camera::look_at([0.5, 0., 0.], [0., 0., 5.], [0., 1., 0.], 60., 64, 64) };
    let (columns, rows) = camera.size();
    let (origins, directions) = camera.rays()?;
    let options = TraceOptions::default();
    let picture = tree.render_hits(&camera, &options)?;
    assert_eq!(picture, tree.trace(&Rays { row_length: 48, ..Rays::new(&origins, &directions) }, &options)?);

    // The first light is in front of the wall, the second behind it.
    let lights = [Light::Point([0., 0., 1.]), Light::Directional([0., 0., 1.])];
    let (pool, seen) = (Pool::new(2)?, AtomicUsize::new(0));
    let options = TraceOptions {
        pool: Some(&pool),
        lights: &lights,
        outputs: Outputs::T | Outputs::UV | Outputs::IDS | Outputs::FACING | Outputs::OCCLUDED,
        initial_tile_size: 16,
        ..Default::default()
    };
    let callback = |tile: &Tile| {
        assert!(tile.width <= 16 && tile.worker < 2);
        let (x, y) = ((tile.x - 8) as usize, (tile.y - 8) as usize);
        let n = (tile.width * tile.height) as usize;
        for i in 0..n {
            let pixel = (y + i / tile.width as usize) * columns + x + i % tile.width as usize;
            assert_eq!((tile.t.unwrap()[i], tile.mesh.unwrap()[i]), (picture.t[pixel], picture.mesh[pixel]));
            assert_eq!((tile.u.unwrap()[i], tile.v.unwrap()[i]), (picture.u[pixel], picture.v[pixel]));
            assert_eq!(
                (tile.triangle.unwrap()[i], tile.facing.unwrap()[i]),
                (picture.triangle[pixel], picture.facing[pixel])
            );
            assert_eq!(tile.occluded.unwrap()[i], if picture.facing[pixel] != 0 { 2 } else { 0 });
        }
        seen.fetch_add(n, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let mut frame = vec![9u8; 64 * rows];
    let mut arrays = HitArrays { occluded: Some(Output::strided(&mut frame, 1, 64)), ..Default::default() };
    tree.render(&camera, &options, Some(&mut arrays), Some(&callback))?;
    assert_eq!(seen.load(Ordering::Relaxed), columns * rows);
    for (i, &facing) in picture.facing.iter().enumerate() {
        assert_eq!(frame[i / columns * 64 + i % columns], if facing != 0 { 2 } else { 0 });
    }
    assert!(frame[columns..64].iter().all(|&byte| byte == 9)); // between rows

    let parallel = Camera { projection: Projection::Parallel, direction: [0., 0., 1.], t_min: 6., t_max: 9., ..camera };
    let mut any = vec![0u8; columns * rows];
    let options = TraceOptions { query: Query::Any, ..Default::default() };
    let mut arrays = HitArrays { occluded: Some((&mut any).into()), ..Default::default() };
    tree.render(&parallel, &options, Some(&mut arrays), None)?;
    assert!(any.iter().all(|&byte| byte == 1));

    let stop = |_: &Tile| ControlFlow::Break(());
    let options = TraceOptions { outputs: Outputs::T, ..Default::default() };
    let error = tree.render(&camera, &options, None, Some(&stop)).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Cancelled);
    let panics = |_: &Tile| panic!("in a callback");
    assert!(catch_unwind(AssertUnwindSafe(|| tree.render(&camera, &options, None, Some(&panics)))).is_err());
    Ok(())
}

#[test]
fn points_and_shadows() -> Result<()> {
    let tree = walls();
    let ray = Ray::new([0.; 3], [0., 0., 1.]);
    let hit = tree.trace_ray(&ray, &Default::default())?.unwrap();
    let point = tree.offset_point(hit.mesh, hit.triangle, hit.u, hit.v, -hit.facing)?;
    assert!(point[2] < 5. && point[2] > 4.99);
    assert!(tree.offset_point(0, 2, 0., 0., 1).is_err());
    let (front, behind) = (Light::Point([0., 0., 1.]), Light::Directional([0., 0., 1.]));
    let shadow = tree.shadow_ray(&ray, &hit, &front)?.unwrap();
    assert_eq!((shadow.origin, shadow.t_max, shadow.skip), ([0., 0., 1.], 1., Some([0, 0])));
    assert!(!tree.occluded_ray(&shadow, &Default::default())?);
    assert_eq!(tree.shadow_ray(&ray, &hit, &behind)?, None);

    let positions = [point, [0., 0., 6.], [0., 0., 5.]];
    let points =
        Points { skip: Some((&[[NONE; 2], [NONE; 2], [0, 0]]).into()), row_length: 3, ..Points::new(&positions) };
    assert_eq!(tree.occluded_points(&points, &front, &Default::default())?, [false, true, false]);
    let one = Points::new(Input::all(&point));
    assert_eq!(tree.occluded_points(&one, &behind, &Default::default())?, [true]);
    Ok(())
}

#[test]
fn all_hits_of_a_ray() -> Result<()> {
    let tree = walls();
    let (origins, directions) = ([[0.; 3], [0., 0., 6.], [0., 50., 0.]], [[0., 0., 1.]; 3]);
    let rays = Rays::new(&origins, &directions);
    let lists = tree.all_hits(&rays, &Default::default(), 2)?;
    assert_eq!(lists.triangle, [0, 1, 1, NONE, NONE, NONE]);
    assert_eq!((&lists.t[..3], &lists.facing[..2]), (&[5., 8., 2.][..], &[1, 1][..]));
    assert_eq!((&lists.total[..], &lists.crossing_total[..]), (&[2, 1, 0][..], &[2, 1, 0][..]));
    assert_eq!(lists.crossing, [1, 1, 1, 0, 0, 0]);
    assert_eq!(tree.all_hits(&rays, &Default::default(), 0)?.total, lists.total);
    Ok(())
}

#[test]
fn saved_trees() -> Result<()> {
    #[repr(align(64))]
    struct Aligned([u8; 1 << 16]);

    impl AsRef<[u8]> for Aligned {
        fn as_ref(&self) -> &[u8] {
            &self.0
        }
    }

    let scene = Scene::new();
    let (tree, options) = (scene.tree(), TraceOptions::default());
    let hits = tree.trace(&scene.rays(), &options)?;
    let bytes = tree.save()?;
    let mut aligned = Box::new(Aligned([0; 1 << 16]));
    let size = tree.save_into(&mut aligned.0)?;
    assert_eq!(&aligned.0[..size], &bytes[..]);
    assert!(tree.save_into(&mut [0; 8]).is_err());

    let geometry_hash = hash_geometry(&scene.meshes())?;
    let of_these = LoadOptions { geometry_hash, memory_limit: 1 << 24, ..Default::default() };
    let copied = Tree::load(&bytes, &of_these)?;
    assert_eq!(copied.trace(&scene.rays(), &options)?, hits);
    let of_others = LoadOptions { geometry_hash: 1, ..Default::default() };
    assert_eq!(Tree::load(&bytes, &of_others).unwrap_err().kind(), ErrorKind::Data);

    let in_place = Tree::load_in_place(&aligned.0[..size], &Default::default())?;
    assert_eq!(in_place.trace(&scene.rays(), &options)?, hits);
    assert!(in_place.info().memory_size < copied.info().memory_size / 10);
    drop(in_place);

    struct Cut(Box<Aligned>, usize);
    impl AsRef<[u8]> for Cut {
        fn as_ref(&self) -> &[u8] {
            &self.0 .0[..self.1]
        }
    }
    let owned = Tree::load_owned(Cut(aligned, size), &Default::default())?;
    assert!(owned.info().memory_size < copied.info().memory_size / 10);
    assert_eq!(
        std::thread::spawn(move || owned.trace(&Scene::new().rays(), &Default::default())).join().unwrap()?,
        hits
    );
    Ok(())
}

#[derive(Default)]
struct Counted {
    blocks: AtomicUsize,
    calls: AtomicUsize,
}

unsafe impl Memory for Counted {
    fn allocate(&self, layout: Layout) -> *mut u8 {
        self.blocks.fetch_add(1, Ordering::Relaxed);
        self.calls.fetch_add(1, Ordering::Relaxed);
        unsafe { std::alloc::alloc(layout) }
    }
    unsafe fn free(&self, block: *mut u8, layout: Layout) {
        self.blocks.fetch_sub(1, Ordering::Relaxed);
        std::alloc::dealloc(block, layout)
    }
}

#[test]
fn memory_of_the_program() -> Result<()> {
    let scene = Scene::new();
    let counted = Arc::new(Counted::default());
    let memory: Arc<dyn Memory> = counted.clone();
    let host = Host { memory: Some(memory.clone()), ..Default::default() };
    let tree = Tree::build(&scene.meshes(), &TreeOptions { host: host.clone(), ..Default::default() })?;
    let held = counted.blocks.load(Ordering::Relaxed);
    assert!(held > 0);
    let pool = Pool::with_options(PoolOptions { thread_count: 2, memory: Some(memory), ..Default::default() })?;
    let before = counted.calls.load(Ordering::Relaxed);
    tree.trace(&scene.rays(), &TraceOptions { pool: Some(&pool), host: host.clone(), ..Default::default() })?;
    assert!(counted.calls.load(Ordering::Relaxed) > before);
    let loaded = Tree::load(&tree.save()?, &LoadOptions { host, ..Default::default() })?;
    drop((tree, pool));
    assert!(counted.blocks.load(Ordering::Relaxed) > 0);
    drop(loaded);
    assert_eq!(counted.blocks.load(Ordering::Relaxed), 0);
    Ok(())
}

#[test]
fn progress_cancels() -> Result<()> {
    let scene = Scene::new();
    let last = Mutex::new(0.);
    let report = |fraction: f64| {
        assert!(fraction >= *last.lock().unwrap());
        *last.lock().unwrap() = fraction;
        ControlFlow::Continue(())
    };
    let host = Host { progress: Some(&report), ..Default::default() };
    let tree = Tree::build(&scene.meshes(), &TreeOptions { host: host.clone(), ..Default::default() })?;
    assert_eq!(*last.lock().unwrap(), 1.);
    *last.lock().unwrap() = 0.;
    tree.trace(&scene.rays(), &TraceOptions { host, ..Default::default() })?;
    assert_eq!(*last.lock().unwrap(), 1.);

    // The last report comes when all is done; an earlier one needs a call that takes some milliseconds.
    let (stop, calls) = (Mutex::new(1.), AtomicUsize::new(0));
    let stop = |fraction: f64| {
        *stop.lock().unwrap() = fraction;
        calls.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Break(())
    };
    let host = Host { progress: Some(&stop), ..Default::default() };
    let many = vec![[0.5, 0.25, 0.125]; 4_000_000];
    let rays = Rays::new(Input::all(&scene.origins[0]), &many);
    let options = TraceOptions { method: Method::Ray, host, ..Default::default() };
    assert_eq!(tree.trace(&rays, &options).unwrap_err().kind(), ErrorKind::Cancelled);
    assert!(calls.load(Ordering::Relaxed) > 0);

    let panics = |_: f64| -> ControlFlow<()> { panic!("in progress") };
    let host = Host { progress: Some(&panics), ..Default::default() };
    let build = || Tree::build(&scene.meshes(), &TreeOptions { host: host.clone(), ..Default::default() });
    assert!(catch_unwind(AssertUnwindSafe(build)).is_err());
    Ok(())
}

#[test]
fn pools_know_their_threads() -> Result<()> {
    assert!(Pool::new(0)?.thread_count() >= 1);
    assert_eq!(Pool::new(2)?.thread_count(), 2);
    assert_eq!(Pool::with_executor(4, drop)?.thread_count(), 4);
    Ok(())
}

#[test]
fn jobs_of_the_program() -> Result<()> {
    let scene = Scene::new();
    let tree = scene.tree();
    let hits = tree.trace(&scene.rays(), &Default::default())?;
    // Jobs on threads of their own, jobs that never run, and jobs that run at once.
    let threads = Pool::with_executor(4, |job| drop(std::thread::spawn(|| job.run())))?;
    let lost = Pool::with_executor(4, drop)?;
    let inline = Pool::with_executor(4, Job::run)?;
    for pool in [&threads, &lost, &inline] {
        let options =
            TraceOptions { pool: Some(pool), initial_tile_size: 16, outputs: Outputs::T, ..Default::default() };
        for _ in 0..20 {
            assert_eq!(tree.trace(&scene.rays(), &options)?, hits);
        }
        // Within a job: no thread waits for one that waits for it.
        let camera = Camera::look_at([0.; 3], [0., 0., 1.], [0., 1., 0.], 60., 64, 64);
        let nested = |_: &Tile| {
            assert_eq!(tree.trace(&scene.rays(), &options).unwrap(), hits);
            ControlFlow::Continue(())
        };
        tree.render(&camera, &options, None, Some(&nested))?;
    }
    Ok(())
}
