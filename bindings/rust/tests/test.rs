// SPDX-License-Identifier: MIT
//! The scene of bindings/c/scene.h: prints the hash of the answers, and checks errors. That a dropped tree cannot be used
//! is a test in lib.rs' own words.

use mlrt::{ffi, Hits, Mesh, Pool, Tree, NONE};

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

fn hash(hits: &Hits) -> u64 {
    let mut hash = 0xCBF29CE484222325u64;
    for i in 0..hits.t.len() {
        let floats = [hits.t[i], hits.u[i], hits.v[i]].map(f32::to_bits);
        let words = [floats[0], floats[1], floats[2], hits.mesh[i], hits.triangle[i], hits.facing[i] as u32];
        for byte in words.iter().flat_map(|word| word.to_le_bytes()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x100000001B3);
        }
    }
    hash
}

#[test]
fn the_same_answers() -> Result<(), mlrt::Error> {
    let mut draw = Draw(1);
    let mut arrays: [(Vec<[f32; 3]>, Vec<[u32; 3]>); 2] = Default::default();
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
    let mesh = |id: u32, m: usize| Mesh { id, vertices: &arrays[m].0, triangles: &arrays[m].1 };
    let tree = Tree::new(&[mesh(7, 0), mesh(3, 1)])?;
    let pool = Pool::new(2)?;

    let hits = tree.trace(&origins, &directions, None)?;
    assert_eq!(hash(&tree.trace(&origins, &directions, Some(&pool))?), hash(&hits));
    let expected: Vec<bool> = hits.mesh.iter().map(|&mesh| mesh != NONE).collect();
    assert_eq!(tree.occluded(&origins, &directions, Some(&pool))?, expected);
    std::thread::scope(|scope| {
        let other = scope.spawn(|| tree.trace(&origins, &directions, Some(&pool)));
        assert_eq!(other.join().unwrap().unwrap(), hits);
    });
    println!("\n{:016x}", hash(&hits));
    Ok(())
}

#[test]
fn errors_say_what_is_wrong() {
    let vertices = [[0.; 3]; 3];
    let wrong = Mesh { id: 5, vertices: &vertices, triangles: &[[0, 1, 2], [0, 1, 3]] };
    let error = Tree::new(&[wrong]).err().expect("an error");
    assert_eq!(error.status, ffi::MLRT_ERROR_INDEX_RANGE as i32);
    assert!(error.to_string().contains("triangle 1: vertex index 3"), "{error}");

    let error = Pool::new(5000).err().expect("an error");
    assert_eq!(error.status, ffi::MLRT_ERROR_ARGUMENT as i32);

    let empty = Tree::new(&[]).unwrap();
    assert!(empty.trace(&[[0.; 3]], &[], None).is_err());
    assert_eq!(empty.trace(&[[0.; 3]], &[[1.; 3]], None).unwrap().mesh, [NONE]);
}
