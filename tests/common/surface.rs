//! Small surfaces with their eigenfunctions, for tests of what stands on them.

use catamaran::Par;
use catamaran::faer::{Mat, Side};
use catamaran::mesh::{TriMesh, families};
use catamaran::sparse::{CsMat, Mass};
use catamaran::spectral::Eigenbasis;

/// A closed surface without any symmetry.
pub fn blob(subdivisions: u32) -> TriMesh {
    let (mut vertices, faces) = families::icosphere(subdivisions).unwrap().into_parts();
    for p in &mut vertices {
        let [x, y, z] = *p;
        let r = 1.0
            + 0.25 * (3.0 * x + 1.0).sin()
            + 0.2 * (2.0 * y - x).cos()
            + 0.15 * (2.5 * z + y).sin();
        *p = [1.6 * r * x, 1.2 * r * y, r * z];
    }
    TriMesh::new(vertices, faces).unwrap()
}

/// The same surface with its vertices in another order and another size, and for each of its vertices the old one.
pub fn shuffled(mesh: &TriMesh, scale: f64) -> (TriMesh, Vec<u32>) {
    let n = mesh.vertices().len() as u32;
    // A step that has no divisor in common with n visits every vertex.
    let step = (n / 3..).find(|&step| gcd(step, n) == 1).unwrap();
    let old: Vec<u32> =
        (0..n).map(|i| (u64::from(i) * u64::from(step) % u64::from(n)) as u32).collect();
    let mut new = vec![0; n as usize];
    for (i, &x) in old.iter().enumerate() {
        new[x as usize] = i as u32;
    }
    let vertices = old.iter().map(|&x| mesh.vertices()[x as usize].map(|c| c * scale)).collect();
    let faces = mesh.faces().iter().rev().map(|face| face.map(|x| new[x as usize])).collect();
    (TriMesh::new(vertices, faces).unwrap(), old)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The cotangent stiffness and the lumped mass.
pub fn laplacian(mesh: &TriMesh) -> (CsMat<f64>, Vec<f64>) {
    let n = mesh.vertices().len();
    let mut entries = sprs::TriMat::new((n, n));
    let mut mass = vec![0.0; n];
    for face in mesh.faces() {
        let p = face.map(|x| mesh.vertices()[x as usize]);
        for corner in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|step| (corner + step) % 3);
            let (u, v) = (minus(p[b], p[a]), minus(p[c], p[a]));
            let area = 0.5 * cross(u, v).iter().map(|x| x * x).sum::<f64>().sqrt();
            let dot: f64 = (0..3).map(|l| u[l] * v[l]).sum();
            let weight = 0.25 * dot / area;
            let (i, j) = (face[b] as usize, face[c] as usize);
            for (row, column, value) in
                [(i, i, weight), (j, j, weight), (i, j, -weight), (j, i, -weight)]
            {
                entries.add_triplet(row, column, value);
            }
            mass[face[a] as usize] += area / 3.0;
        }
    }
    (entries.to_csr(), mass)
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The first `len` eigenfunctions.
pub fn eigenbasis(mesh: &TriMesh, len: usize) -> Eigenbasis {
    let (stiffness, mass) = laplacian(mesh);
    let n = mass.len();
    let mut symmetric = Mat::<f64>::zeros(n, n);
    for (&value, (i, j)) in stiffness.iter() {
        symmetric[(i, j)] += value / (mass[i] * mass[j]).sqrt();
    }
    let eigen = symmetric.self_adjoint_eigen(Side::Lower).unwrap();
    let values = eigen.S().column_vector().iter().take(len).copied().collect();
    let vectors = Mat::from_fn(n, len, |i, j| eigen.U()[(i, j)] / mass[i].sqrt());
    Eigenbasis::new(values, vectors, Mass::Lumped(mass)).unwrap()
}

/// Positions as three functions.
pub fn coordinates(mesh: &TriMesh) -> Mat<f64> {
    Mat::from_fn(mesh.vertices().len(), 3, |i, c| mesh.vertices()[i][c])
}

/// The numbers of threads that must give the same.
pub const THREADS: [Par; 3] = [Par::Seq, Par::Threads(2), Par::Threads(3)];
