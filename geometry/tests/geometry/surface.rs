//! Small surfaces with their eigenfunctions, for tests of what stands on them.

use catamaran::Par;
use catamaran::faer::Mat;
use catamaran::sparse::{CsMat, EigenOptions, Mass, eigs};
use catamaran_geometry::mesh::{self, LaplacianOptions, TriMesh, families};
use catamaran_geometry::spectral::Eigenbasis;

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

/// The same surface with its vertices in another order and another size, and for each of its
/// vertices the old one.
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
    let options = LaplacianOptions::new().par(Par::Seq);
    let found = mesh::laplacian(mesh, &options).unwrap();
    let Mass::Lumped(mass) = found.mass else { panic!("a lumped mass") };
    (found.stiffness, mass)
}

/// The first `len` eigenfunctions.
pub fn eigenbasis(mesh: &TriMesh, len: usize) -> Eigenbasis {
    let (stiffness, mass) = laplacian(mesh);
    let mass = Mass::Lumped(mass);
    let options = EigenOptions::new().k(len).tolerance(1e-11).par(Par::Seq);
    let pairs = eigs(stiffness.view(), &mass, &options).unwrap();
    Eigenbasis::new(pairs.values, pairs.vectors, mass).unwrap()
}

/// Positions as three functions.
pub fn coordinates(mesh: &TriMesh) -> Mat<f64> {
    Mat::from_fn(mesh.vertices().len(), 3, |i, c| mesh.vertices()[i][c])
}

/// The numbers of threads that must give the same.
pub const THREADS: [Par; 3] = [Par::Seq, Par::Threads(2), Par::Threads(3)];
